"""Parts that models of a scene may leave out: pairs of runs, one with the part, one without."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ...reference.scene import Case
from ..engines.registry import REFERENCE
from ..faults.variants import Variant, exudyn

THEORY = Variant(REFERENCE)
"""The reference, whose models are theories."""


@dataclass(frozen=True)
class PairedModel:
    """One of a pair of models.

    Attributes
    ----------
    engine : Variant
    model, method : str
    changes : mapping of parameter to value
        Parameters that differ from those of the case.
    """

    engine: Variant
    model: str
    method: str
    changes: Mapping[str, Any] = field(default_factory=dict)

    @property
    def words(self) -> str:
        """The model in words."""
        changes = [f"{name} {value}" for name, value in self.changes.items()]
        return " ".join((self.model, *changes, f"by {self.method}"))


@dataclass(frozen=True)
class Pair:
    """Two models that differ in one thing: `whole` has it, `without` leaves it out.

    Attributes
    ----------
    left_out : str
    case : Case
    whole, without : PairedModel
    span : float or None
        Time over which runs are compared [s]; None for the horizon of the case.
    step : float
        Step of both [s]; the default is 10 to 160 steps in the fastest motion of the scenes.
    """

    left_out: str
    case: Case
    whole: PairedModel
    without: PairedModel
    span: float | None = None
    step: float = 2.0**-11


def absolute_coordinates(case: Case, model: str, span: float) -> tuple[Pair, Pair]:
    """Return Exudyn's absolute coordinates with joints beside a model in minimal coordinates.

    By the same method, and by an explicit one, which joints do not permit.
    """
    implicit = "GeneralizedAlpha"
    whole = PairedModel(exudyn(), "redundant", implicit)
    first, second = (
        Pair("absolute coordinates", case, whole, PairedModel(exudyn(), model, method), span)
        for method in (implicit, "RK44")
    )
    return first, second


def simpler_theory(left_out: str, case: Case, whole: str, without: str) -> Pair:
    """Return two theories of the reference."""
    has, lacks = (PairedModel(THEORY, one, "DOP853") for one in (whole, without))
    return Pair(left_out, case, has, lacks)

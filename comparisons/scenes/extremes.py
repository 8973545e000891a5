"""What a scene may tell ``mbcheck extremes``: the types of its tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from ...reference import get_scene
from ...reference.scene import Case
from ..engines.variants.catalogue import Observation, Variant

FREE, CONSERVATIVE, LOCKED, AFTER_PULSE = "free", "conservative", "locked", "after_pulse"
"""Kinds of `LongMotion`."""


@dataclass(frozen=True, kw_only=True)
class Extreme:
    """A case of a scene with parameters or a start that ask much of an engine.

    Attributes
    ----------
    name : str
    case : str
        Of the scene; what follows does not name, it gives.
    changes : mapping of parameter to value
        (SI)
    state : mapping of str to float, or None
        Initial values in place of those of the case.
    offset : mapping of str to float
        By how much a loop is open at the start.
    models : tuple of str
        Models that are run where an engine has them, in place of its default.
    horizon : float or None
        [s]; None for a few periods.
    full : bool
        Whether it is left out of the default set.
    """

    name: str
    case: str
    changes: Mapping[str, Any] = field(default_factory=dict)
    state: Mapping[str, float] | None = None
    offset: Mapping[str, float] = field(default_factory=dict)
    models: tuple[str, ...] = ()
    horizon: float | None = None
    full: bool = False

    def altered(self, scene: str) -> Case:
        """Return the case at the extreme."""
        case = get_scene(scene).case(self.case)
        return replace(
            case,
            parameters=case.parameters.replace(**self.changes),
            state=case.state if self.state is None else self.state,
            inconsistency=self.offset or case.inconsistency,
        )

    @property
    def alterations(self) -> dict[str, float | str]:
        """What it changes: parameters, initial values, and how far the loop is open."""
        opened = {f"{name} off by": value for name, value in self.offset.items()}
        return {**self.changes, **(self.state or {}), **opened}


@dataclass(frozen=True, kw_only=True)
class EngineFailure(Extreme):
    """One way to fail, or a run beside it that does not, by one method of one engine.

    Attributes
    ----------
    engine : Variant
    method : str
    step : float
        [s]
    settings : mapping of str to float or str
        What the variant does, in words of the engine.
    harmless : bool
        Whether it is right: with these versions and in this scene the failure does not come about.
    section : str
        Of the extremes table.
    """

    engine: Variant
    method: str
    step: float
    settings: Mapping[str, float | str] = field(default_factory=dict)
    harmless: bool = False
    section: str = "failures"


@dataclass(frozen=True, kw_only=True)
class EngineProbe:
    """Something that an engine does beside simulating.

    Attributes
    ----------
    name, engine, model : str
    case : Case
    observe : callable ``(case, model) -> Observation``
    method : str or None
    step, horizon : float or None
        [s]; of the run that rules are asked about.
    """

    name: str
    engine: str
    case: Case
    model: str
    observe: Callable[[Case, str], Observation]
    method: str | None = None
    step: float | None = None
    horizon: float | None = None


@dataclass(frozen=True)
class LongMotion:
    """A motion that is followed for long.

    Attributes
    ----------
    kind : str
        `FREE`, `CONSERVATIVE`, `LOCKED` or `AFTER_PULSE`.
    case : str
        Of the scene; gives the parameters and, but for `FREE` and `LOCKED`, the start.
    segments : int
        Of a continuum, 0 for the case's own.
    periods : (int, int)
        How long it is followed: by default, and in full.
    longest : int
        Periods in full by a method that is cheap enough, 0 for none.
    most_steps : mapping of engine to int
        Where the steps of an engine take so long that a run is cut earlier than others.
    """

    kind: str
    case: str
    segments: int = 0
    periods: tuple[int, int] = (1_000, 10_000)
    longest: int = 0
    most_steps: Mapping[str, int] = field(default_factory=dict)

    def of(self, scene: str) -> Case:
        """Return the case."""
        case = get_scene(scene).case(self.case)
        if not self.segments:
            return case
        return replace(case, parameters=case.parameters.replace(segments=self.segments))


@dataclass(frozen=True)
class Release:
    """How a free vibration of elements begins: at rest but for one rate.

    Attributes
    ----------
    changes : mapping of parameter to value
    rate : str
    observable, length : str
        What is looked at, and the parameter that gives its size.
    """

    changes: Mapping[str, Any]
    rate: str
    observable: str
    length: str


@dataclass(frozen=True)
class FreeVibration:
    """What makes a scene vibrate freely, and which parameters stand for its limits.

    Attributes
    ----------
    undamped : mapping of parameter to value
        Takes forces and dampers away.
    stiffness : str or None
        A parameter that makes the fastest vibration as fast as one likes.
    damping : str or None
    speed : str or None
        A parameter, or the rate of a coordinate at the start.
    of_models : mapping of model to parameters
        What a model cannot do without.
    release : Release or None
        Of a model by elements.
    """

    undamped: Mapping[str, float | str]
    stiffness: str | None
    damping: str | None
    speed: str | None
    of_models: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    release: Release | None = None

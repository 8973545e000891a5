"""Rules that tell before a run what it cannot be trusted in."""

from __future__ import annotations

from dataclasses import dataclass

from ..reference.scene import Case
from .engine import Engine, Method


@dataclass(frozen=True)
class Caution:
    """What a rule says of a run that is to be made.

    Attributes
    ----------
    rule : str
        Its name.
    message : str
        One sentence: what is wrong, with its numbers, and what to do.
    """

    rule: str
    message: str


def cautions(
    engine: Engine, case: Case, model: str, method: Method, step: float, horizon: float
) -> list[Caution]:
    """Return what all rules say of a run of a case over a horizon [s] with this step [s]."""
    return []

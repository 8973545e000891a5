"""The table of kinds of check: a kind is one row of `KINDS`, or of `EXTREMES`."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from ..engines.setup import Setup
from . import diagnosis
from .comparison import Measured
from .diagnosis import Search
from .kinds import (
    algebra,
    energy,
    frequency,
    limits,
    long_runs,
    one_step,
    order,
    parts,
    pushed,
    stability,
    trajectory,
)
from .refusals import refuse_unstable


@dataclass(frozen=True)
class Kind:
    """A kind of check.

    Attributes
    ----------
    level : str
        What is wrong where it fails, in words; empty of an extreme.
    quantities : callable ``(setup) -> tuple of str``
        Names of its quantities; none if it does not apply to a model.
    measure : callable ``(setup) -> Measured``
    searches : sequence of callable ``(deviation) -> str``
        The mistakes that may explain a deviation, in this order.
    integrates : bool
        Whether it needs a method.
    follows : str or None
        Cases of this kind have it too.
    needs : tuple of str
        What a user's own case must have for it: ``motion``, a state of ``rest``, a periodic
        ``orbit``, or something ``conserved``.
    refuse : callable ``(setup) -> None``, optional
        Refuses a setup that it cannot judge, before anything runs.
    asks_forces : bool
        Whether it asks for accelerations.
    quick : bool
        Whether it belongs to a quick answer.
    """

    level: str
    quantities: Callable[[Setup], tuple[str, ...]]
    measure: Callable[[Setup], Measured]
    searches: Sequence[Search] = ()
    integrates: bool = True
    follows: str | None = None
    needs: tuple[str, ...] = ()
    refuse: Callable[[Setup], None] | None = None
    asks_forces: bool = False
    quick: bool = False


IN_STEPS = (diagnosis.of_numbers, diagnosis.of_joints, diagnosis.of_order)
"""Mistakes that show in steps, once no single motion explains them."""

KINDS = {
    "parts": Kind(
        "its reading of the model",
        parts.quantities,
        parts.measure,
        (
            diagnosis.of_repetition,
            diagnosis.of_placement,
            diagnosis.of_parts,
            diagnosis.of_numbers,
            diagnosis.of_joints,
        ),
        integrates=False,
        follows="algebra",
        asks_forces=True,
        quick=True,
    ),
    "algebra": Kind(
        "its accelerations or its mass matrix",
        algebra.quantities,
        algebra.measure,
        (
            diagnosis.of_repetition,
            diagnosis.of_placement,
            diagnosis.of_accelerations,
            diagnosis.of_numbers,
            diagnosis.of_joints,
        ),
        integrates=False,
        asks_forces=True,
        quick=True,
    ),
    "frequency": Kind(
        "its linearised equations of motion",
        frequency.quantities,
        frequency.measure,
        (diagnosis.of_matrices, diagnosis.of_numbers),
        integrates=False,
        needs=("rest",),
    ),
    "step": Kind(
        "a single step from a right state",
        one_step.quantities,
        one_step.measure,
        (diagnosis.of_repetition, diagnosis.of_placement, diagnosis.of_steps, *IN_STEPS),
        follows="trajectory",
        needs=("motion",),
        quick=True,
    ),
    "trajectory": Kind(
        "a free run",
        trajectory.quantities,
        trajectory.measure,
        (diagnosis.of_repetition, diagnosis.of_placement, diagnosis.of_run, *IN_STEPS),
        needs=("motion",),
        refuse=refuse_unstable,
        quick=True,
    ),
    "order": Kind(
        "its order of convergence",
        order.quantities,
        order.measure,
        (diagnosis.of_repetition, diagnosis.of_run, *IN_STEPS, diagnosis.of_limit),
        needs=("motion",),
    ),
    "energy": Kind(
        "its conservation of invariants",
        energy.quantities,
        energy.measure,
        (diagnosis.of_repetition, diagnosis.of_run, diagnosis.of_numbers),
        needs=("motion", "conserved"),
        refuse=refuse_unstable,
    ),
    "stability": Kind(
        "its periodic or long motion",
        stability.quantities,
        stability.measure,
        (diagnosis.of_repetition, diagnosis.of_orbit, diagnosis.of_numbers, diagnosis.of_limit),
        needs=("orbit",),
        refuse=refuse_unstable,
    ),
}
"""Kinds from the model to its motion: a fault on one level mostly shows on those below."""

EXTREMES = {
    "limits": Kind("", limits.quantities, limits.measure),
    "parameters": Kind("", pushed.quantities, pushed.measure),
    "starts": Kind("", pushed.quantities, pushed.measure),
    "long": Kind("", long_runs.quantities, long_runs.measure),
    "failures": Kind("", pushed.quantities, pushed.measure),
}
"""Kinds of checks at extremes; see `scenes.extremes`."""


EVERY_KIND: Mapping[str, Kind] = ChainMap(KINDS, EXTREMES)

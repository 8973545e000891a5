"""What a scene may tell ``mbcheck tradeoff``: the types of its tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ...reference.scene import Array, Case, Scene
from ..checks.truth import Truth
from ..faults.variants import Variant, exudyn, mujoco


def relative_error(values: Array, truth: Truth) -> float:
    """Return the largest error of observables (k, n_t), each over its size."""
    return float(np.max(np.abs(values - truth.values) / truth.size[:, None]))


def sample_times(case: Case, spacing: float, span: float | None = None) -> Array:
    """Return times [s] at a spacing [s] over a span [s], by default the horizon of a case."""
    count = int((case.horizon if span is None else span) / spacing * (1 + 1e-12))
    return np.asarray(case.start_time + spacing * np.arange(1, count + 1), dtype=np.float64)


STEP = 2.0**-11
"""Of a pair of runs [s], but where a model bears less: 10 to 160 steps in the fastest motion."""


@dataclass(frozen=True)
class PairedRun:
    """One of a pair of runs.

    Attributes
    ----------
    engine : Variant
    model, method : str
    changes : mapping of parameter to value
        Parameters that the model has in place of those of the case.
    step : float
        [s]
    """

    engine: Variant
    model: str
    method: str
    changes: Mapping[str, Any] = field(default_factory=dict)
    step: float = STEP


@dataclass(frozen=True)
class Pair:
    """Two runs that differ in one thing: one has it, the other leaves it out.

    Attributes
    ----------
    left_out, compared : str
        What it is; the two models in words, the one that has it first.
    case : Case
    has, lacks : PairedRun
    span : float or None
        Compared so long [s]; None for the horizon of the case.
    """

    left_out: str
    compared: str
    case: Case
    has: PairedRun
    lacks: PairedRun
    span: float | None = None


class PairNumbers(NamedTuple):
    """Numbers of a pair that need no runs.

    Attributes
    ----------
    left_out, compared, case : str
    errors : (float or None, float)
        With it and without it, relative.
    ratios : tuple of float
        Cost with it over cost without.
    cost_of : str
        What the cost is.
    """

    left_out: str
    compared: str
    case: str
    errors: tuple[float | None, float]
    ratios: tuple[float, ...] = ()
    cost_of: str = ""


LeftOutRow = Pair | Callable[[], PairNumbers]
LeftOutRows = Mapping[str, tuple[LeftOutRow, ...]]
"""By engine."""


def redundant(case: Case, model: str, span: float) -> tuple[Pair, Pair]:
    """Compare Exudyn's absolute coordinates with joints and its minimal ones.

    With the same method, and with an explicit one, which joints do not permit.
    """
    implicit = "GeneralizedAlpha"
    first, second = (
        Pair(
            "redundant coordinates",
            f"redundant by {implicit}, {model} by {method}, the same step",
            case,
            PairedRun(exudyn(), "redundant", implicit),
            PairedRun(exudyn(), model, method),
            span,
        )
        for method in (implicit, "RK44")
    )
    return first, second


def without_solver(case: Case, span: float) -> Pair:
    """Compare MuJoCo with its machinery for constraints and with the flag that disables it."""
    return Pair(
        "solver of constraints, of a tree without any",
        "tree, tree with the flag constraint off: RK4",
        case,
        PairedRun(mujoco(), "tree", "RK4"),
        PairedRun(mujoco("Bare"), "tree", "RK4"),
        span,
    )


def inertia_floor(case: Case, compared: str, error: float) -> PairNumbers:
    """Return what the least inertia that MuJoCo takes leaves: it cannot be without."""
    return PairNumbers("point masses without inertia", compared, case.name, (None, error))


@dataclass(frozen=True)
class PartKind:
    """A way to make a continuum of parts.

    Attributes
    ----------
    name : str
    part : str
        What is counted.
    counts, run_counts : tuple of int
        Tried, in rising order: of frequencies; of runs, which cost more.
    choices : mapping of str to str
        Parameters that choose it.
    equations : callable ``(count) -> Scene``, or None
        The scene's equations with so many modes, of a kind that no engine has.
    """

    name: str
    part: str
    counts: tuple[int, ...]
    run_counts: tuple[int, ...]
    choices: Mapping[str, str] = field(default_factory=dict)
    equations: Callable[[int], Scene] | None = None


@dataclass(frozen=True)
class ContinuumParts:
    """How the parts of a continuum are counted.

    Attributes
    ----------
    kinds : mapping of engine to tuple of PartKind
    steady : tuple of str
        Cases whose first frequency is looked at.
    moving, observable : str
        Case that is run, and what is looked at.
    first_frequency : callable ``(parameters, Scene) -> array (1,)``
        [rad/s], of a kind's equations.
    """

    kinds: Mapping[str, tuple[PartKind, ...]]
    steady: tuple[str, ...]
    moving: str
    observable: str
    first_frequency: Callable[[Any, Scene], Array]


@dataclass(frozen=True)
class ClosureOption:
    """A way to close a loop, and what makes it softer.

    Attributes
    ----------
    engine : Variant
    model : str
    option, unit : str
        Option of the engine; empty where the closure is taken as it is.
    values : tuple of float
        Of the option, from soft to hard.
    exact : bool
        Whether joints are closed exactly: the option only lets a solver stop early.
    """

    engine: Variant
    model: str
    option: str = ""
    unit: str = ""
    values: tuple[float, ...] = ()
    exact: bool = False


@dataclass(frozen=True)
class LoopClosures:
    """How a closed loop of a scene is compared.

    Attributes
    ----------
    case : str
    closures : tuple of ClosureOption
    """

    case: str
    closures: tuple[ClosureOption, ...]

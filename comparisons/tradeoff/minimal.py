"""The least that meets a target: parts of a continuum, hardness of a loop, what may be left out.

Every number is computed when it is asked for. What may be left out is told by pairs of models that
differ in one thing, against the scene's reference: one that has it, one that leaves it out. Where
neither engine can have it, errors are those of the equations.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import partial
from typing import Any

import numpy as np

from ...reference import get_scene
from ..checks.truth import roundoff_reference
from ..engines.equations import scene_equations
from ..engines.registry import REFERENCE, get_engine
from ..engines.setup import Setup, power_of_two, run
from ..scenes.data import scene_data
from ..scenes.tradeoff import (
    LeftOutRow,
    LoopClosures,
    Pair,
    PairedRun,
    PairNumbers,
    PartKind,
    relative_error,
    sample_times,
)
from .closures import CLOSED, LoopClosure, closures
from .elements import Counting, Curve, Fewest, continuum_of, parts_of
from .series import TARGETS

REPEATS = 7
"""Pairs of runs whose wall times are compared."""

EQUAL = 0.03
"""Costs that differ by less than this share are told apart no further."""


@dataclass(frozen=True)
class LeftOut:
    """One thing that may be left out of a model.

    Attributes
    ----------
    scene, engine : str
    left_out : str
        What it is.
    compared : str
        The two models, the one that has it first.
    case : str
    error_with : float or None
        Against the reference of the whole scene, over the sizes of its observables; None where
        it cannot be had.
    error_without : float
    cost_ratio : float or None
        Cost with it over cost without: above 1 leaving it out saves.
    lowest, highest : float or None
        Quartiles of the ratio over repeated pairs.
    cost_of : str
        What was compared: ``wall time``, ``steps`` or ``right-hand sides``.
    required : mapping of str to bool or None
        By target: whether it has to be there; None where the model that has it misses too.
    verdict : str
    """

    scene: str
    engine: str
    left_out: str
    compared: str
    case: str
    error_with: float | None
    error_without: float
    cost_ratio: float | None
    lowest: float | None
    highest: float | None
    cost_of: str
    required: Mapping[str, bool | None] = field(default_factory=dict)
    verdict: str = ""


def left_out_rows(scene: str, engine: str) -> tuple[LeftOutRow, ...]:
    """Return what may be left out of an engine's models of a scene."""
    return scene_data(scene, "tradeoff", "LEFT_OUT", dict[str, Any]()).get(engine, ())


def compare(pair: Pair) -> PairNumbers:
    """Run both of a pair, in turns, and compare errors and wall times."""
    case, names = pair.case, get_scene(pair.case.scene).observables
    span = case.horizon if pair.span is None else pair.span
    spacing = max(pair.has.step, pair.lacks.step, power_of_two(span / 64))
    times = sample_times(case, spacing, span)
    right = roundoff_reference(scene_equations(case), case, times, names)
    setups = [setup_of(pair, one) for one in (pair.has, pair.lacks)]
    trajectories = [[run(setup, times) for setup in setups] for _ in range(REPEATS)]
    has, lacks = (relative_error(one.matrix(names), right) for one in trajectories[0])
    ratios = tuple(one.seconds / other.seconds for one, other in trajectories)
    return PairNumbers(pair.left_out, pair.compared, case.name, (has, lacks), ratios, "wall time")


def setup_of(pair: Pair, one: PairedRun) -> Setup:
    """Return one of a pair of runs."""
    engine = one.engine.make()
    method = next(item for item in engine.methods if item.name == one.method)
    case = replace(pair.case, parameters=pair.case.parameters.replace(**one.changes))
    return Setup(engine, case, one.model, method, one.step)


def row_of(scene: str, engine: str, one: LeftOutRow, targets: Sequence[float]) -> LeftOut:
    """Return the row of a comparison, with what it means for these targets."""
    numbers = compare(one) if isinstance(one, Pair) else one()
    has, lacks = numbers.errors
    required = {
        f"{target:g}": False if lacks <= target else True if (has or 0.0) <= target else None
        for target in targets
    }
    ratios, words = numbers.ratios, f"{importance(required)}: {lacks:.2g} without it"
    words += "" if has is None else f", {has:.2g} with it"
    low = ratio = high = None
    if ratios:
        low, ratio, high = np.quantile(ratios, (0.25, 0.5, 0.75)).tolist()
        words += saving(low, ratio, high, numbers.cost_of)
    return LeftOut(
        scene, engine, numbers.left_out, numbers.compared, numbers.case, has, lacks, ratio, low,
        high, numbers.cost_of, required, words,
    )  # fmt: skip


def importance(required: Mapping[str, bool | None]) -> str:
    """Say for which targets something has to be there."""
    needed = [float(name) for name, value in required.items() if value]
    spared = [float(name) for name, value in required.items() if value is False]
    words = [f"required for {percent(max(needed))} and finer"] if needed else []
    words += [f"not required for {percent(min(spared))}"] if spared else []
    return ", ".join(words) or "not what limits the error here"


def saving(low: float, ratio: float, high: float, cost_of: str) -> str:
    """Say what leaving something out saves or costs, by the quartiles of the ratio of costs."""
    if low <= 1 <= high or abs(ratio - 1) < EQUAL:
        return f"; no difference in {cost_of} above the scatter"
    change = f"saves a factor of {ratio:.2g}" if ratio > 1 else f"costs a factor of {1 / ratio:.2g}"
    return f"; leaving it out {change} in {cost_of}"


def percent(target: float) -> str:
    """Return a relative error in percent."""
    return f"{100 * target:g} %"


@dataclass(frozen=True)
class Minimal:
    """The least that meets targets, and what may be left out."""

    curves: tuple[Curve, ...] = ()
    fewest: tuple[Fewest, ...] = ()
    closures: tuple[LoopClosure, ...] = ()
    left_out: tuple[LeftOut, ...] = ()


def joined(parts: Sequence[Minimal]) -> Minimal:
    """Return all parts as one."""
    names = (item.name for item in fields(Minimal))
    return Minimal(*(tuple(row for part in parts for row in getattr(part, name)) for name in names))


def of_parts(
    scene: str, engine: str, kind: PartKind, case: str, targets: Sequence[float]
) -> Minimal:
    """Return how many parts of one kind are needed in one case."""
    curve, rows = parts_of(Counting.of(scene, get_engine(engine), kind, case), targets)
    return Minimal(curves=(curve,), fewest=rows)


def of_loop(scene: str, engine: str, targets: Sequence[float] = (*TARGETS, CLOSED)) -> Minimal:
    """Return how softly an engine may close the loop of a scene."""
    loop = loop_of(scene)
    case = get_scene(scene).case(loop.case)
    mine = (option for option in loop.closures if option.engine.engine == engine)
    return Minimal(
        closures=tuple(row for option in mine for row in closures(case, option, targets))
    )


def of_left_out(scene: str, engine: str, targets: Sequence[float] = TARGETS) -> Minimal:
    """Return what may be left out of an engine's models of a scene."""
    return Minimal(
        left_out=tuple(row_of(scene, engine, one, targets) for one in left_out_rows(scene, engine))
    )


def loop_of(scene: str) -> LoopClosures:
    """Return how the closed loop of a scene is compared."""
    return scene_data(scene, "tradeoff", "LOOP", LoopClosures("", ()))


Piece = tuple[str, Callable[[], Minimal]]


def tasks(
    scenes: Sequence[str], engines: Sequence[str], targets: Sequence[float] = TARGETS
) -> list[Piece]:
    """Return the pieces with their names, each ready for a process of its own."""
    return [
        piece
        for engine in (*engines, REFERENCE)
        for scene in scenes
        for piece in pieces(scene, engine, targets)
    ]


def pieces(scene: str, engine: str, targets: Sequence[float]) -> Iterator[Piece]:
    """Yield the pieces of one scene and engine."""
    continuum = continuum_of(scene)
    for kind in continuum.kinds.get(engine, ()):
        for case in (*continuum.steady, continuum.moving):
            name = f"{scene} {engine} {kind.name}, {case}"
            yield name, partial(of_parts, scene, engine, kind, case, targets)
    if any(option.engine.engine == engine for option in loop_of(scene).closures):
        all_targets = tuple(dict.fromkeys((*targets, CLOSED)))
        yield f"{scene} {engine} closure", partial(of_loop, scene, engine, all_targets)
    if left_out_rows(scene, engine):
        yield f"{scene} {engine} left out", partial(of_left_out, scene, engine, targets)

"""Long horizons: what a thousand periods leave of energy, phase, closure and clock."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from ....reference.errors import CannotJudgeError, EngineError, MbcheckError
from ...engines.registry import get_engine
from ...engines.setup import Setup, default_step, power_of_two, shortest_period
from ...engines.variants.catalogue import LONG_METHODS, LONGEST_METHODS
from ...scenes.data import scene_data
from ...scenes.extremes import AFTER_PULSE, CONSERVATIVE, FREE, LOCKED, LongMotion
from ..row import REFERENCE, RIGHT, WRONG, Provocation, Row, rules_against
from .drifts import (
    WINDOW,
    after_pulse,
    clock,
    closure,
    conservative,
    free_mode,
    free_vibration,
    locked,
    started,
)
from .long_run import Drifts, LongRun, known_orbit

SECTION = "long"

MOST_STEPS, MOST_CONSTRAINED = 1 << 20, 1 << 18
"""Runs that would take more steps are cut, those in full at more; constraints make steps dear."""

COARSER: Mapping[int, float] = {1: 8.0, 2: 4.0, 3: 2.0, 4: 2.0, 5: 2.0, 6: 2.0}
"""Steps in those by default, by order: long runs are made with coarse steps."""

COARSEST_ELEMENTS = 2.0
"""The same of a continuum: Newton's method finds no solution far beyond the default."""

LOSS = 0.1
"""Part of an amplitude, or of a period, whose loss makes a motion wrong though as predicted."""

MEASURES: Mapping[str, Callable[[LongRun], Drifts]] = {
    FREE: free_vibration,
    CONSERVATIVE: conservative,
    LOCKED: locked,
    AFTER_PULSE: after_pulse,
}


def motions(scene: str) -> tuple[LongMotion, ...]:
    """Return the motions of a scene that are followed."""
    return scene_data(scene, "extremes", "MOTIONS", ())


def tasks(scenes: tuple[str, ...], engines: tuple[str, ...], full: bool) -> list[Provocation]:
    """Return the tasks of the section: one for each motion, engine and model."""
    return [
        Provocation(
            SECTION,
            scene,
            f"{motion.kind}, {model}",
            engine,
            partial(rows_of, engine, scene, model, motion, full),
        )
        for scene in scenes
        for engine in engines
        for model in get_engine(engine).distinct_models(scene)
        for motion in motions(scene)
        if any(runs(Setup(get_engine(engine), motion.of(scene), model), motion, full))
    ]


def rows_of(engine: str, scene: str, model: str, motion: LongMotion, full: bool) -> list[Row]:
    """Return a row for each method that follows a motion on a model."""
    setup = Setup(get_engine(engine), motion.of(scene), model)
    return [follow(one, motion, periods) for one, periods in runs(setup, motion, full)]


def runs(setup: Setup, motion: LongMotion, full: bool) -> Iterator[tuple[Setup, int]]:
    """Yield what is run of a motion on a model: its methods, and over how many periods.

    A model beside the default one that has no constraints is run by the best method alone.
    """
    engine = setup.engine
    if setup.why_not:
        return
    every = [replace(setup, method=method) for method in engine.methods]
    known = {one.integrator.name: one for one in every if is_followed(one, motion)}
    names = [name for name in LONG_METHODS.get(engine.name, known) if name in known]
    if setup.model != engine.models(setup.scene.name)[0] and not setup.has_constraints:
        names = names[:1]
    yield from ((known[name], motion.periods[full]) for name in names)
    if full and motion.longest:
        longest = LONGEST_METHODS.get(engine.name, tuple(known)[:1])
        yield from ((known[name], motion.longest) for name in longest if name in known)


def is_followed(setup: Setup, motion: LongMotion) -> bool:
    """Return whether a method follows a motion, and its drift can be predicted.

    Without constraints the method of index 2 is the trapezoidal rule, which tells nothing new. What
    an implicit Euler makes of soft closures is not known: it takes only springs at the end of a
    step.
    """
    linear = setup.integrator.linear
    if setup.why_not or (linear == "trapezoidal" and not setup.has_constraints):
        return False
    late = linear == "implicit_euler" and setup.has_soft_closure
    return motion.kind != FREE or (setup.linear_scheme is not None and not late)


def follow(setup: Setup, motion: LongMotion, periods: int) -> Row:
    """Follow one motion with a coarse step, and tell what it leaves."""
    row = Row.of(SECTION, f"{motion.kind}, {periods} periods", setup, changed={"case": motion.case})
    try:
        run = prepared(setup, motion, periods)
    except MbcheckError as error:
        return row.skipped(f"cannot be predicted: {error}")
    if periods >= motion.periods[False]:
        most = most_steps(run, motion, periods / motion.periods[False])
        run = replace(run, periods=min(periods, int(most * run.step / run.period)))
    name = f"{motion.kind}, {run.periods} periods"
    cut = f"; cut from {periods} periods for cost" if run.periods < periods else ""
    row = replace(row, name=name, step=run.step)
    rules = rules_against(run.setup, run.periods * run.period)
    try:
        row = compared(row, run, periods, rules)
    except EngineError as error:
        row = row.failed(error, rules)
    except CannotJudgeError as error:
        row = row.skipped(error, rules)
    return replace(row, reason=row.reason + cut)


def compared(row: Row, run: LongRun, asked: int, rules: tuple[str, ...]) -> Row:
    """Return the row of a run: right if it drifts as predicted, and loses little.

    Asked for were more periods, perhaps.
    """
    measured = MEASURES[run.kind](run)
    drifts = {
        **measured.drifts,
        **closure(run, measured.trajectory, measured.near),
        **clock(run, measured.trajectory),
    }
    values = {"periods": float(run.periods), "asked": float(asked), "period": run.period}
    values |= measured.numbers
    for name, drift in drifts.items():
        values[f"{name}_drift"], values[f"{name}_predicted"] = drift.measured, drift.predicted
        values[f"{name}_slack"] = drift.slack
    limits = {"energy": 2 * LOSS, "phase": 2 * np.pi * LOSS}
    looked_at = [name for name in limits if name in drifts]
    lost = [name for name in looked_at if abs(drifts[name].measured) > limits[name]]
    wrong = {name: drift for name, drift in drifts.items() if not drift.agrees}
    first = drifts[looked_at[0]]
    row = replace(row, error=abs(first.measured), predicted=abs(first.predicted), values=values)
    words = ", ".join(f"{name} {drift}" for name, drift in (wrong or drifts).items())
    if not wrong and not lost:
        return replace(row, outcome=RIGHT, reason=f"as predicted: {words}")
    reason = f"as predicted, and wrong: {words}; {' and '.join(lost)} lost"
    if wrong:
        reason = f"not as predicted: {words}"
    return replace(row, outcome=WRONG, noticed_by=(*rules, REFERENCE), reason=reason)


def most_steps(run: LongRun, motion: LongMotion, longer: float) -> float:
    """Return where a run is cut that has so many times the periods of the default."""
    most = MOST_CONSTRAINED if run.setup.has_constraints else MOST_STEPS
    most = motion.most_steps.get(run.setup.engine.name, most)
    return most * min(longer, 16.0 if most == MOST_STEPS else 10.0)


def prepared(setup: Setup, motion: LongMotion, periods: int) -> LongRun:
    """Return a motion with its start, period and step.

    Raises
    ------
    MbcheckError
        If the scene has no such motion.
    """
    case = setup.case
    if motion.kind == FREE:
        mode = free_mode(case)
        period = 2 * np.pi / mode.omega
        setup = setup.with_case(started(case, mode))
        setup = setup.with_step(min(coarse_step(setup), power_of_two(period / WINDOW)))
        return LongRun(setup, FREE, period, periods, mode)
    if motion.kind != LOCKED:
        setup = setup.with_step(coarse_step(setup))
        return LongRun(setup, motion.kind, shortest_period(case), periods)
    orbit = known_orbit(case.scene, case.parameters)
    state = dict(zip(setup.scene.state_names, orbit.state.tolist(), strict=True))
    setup = setup.with_case(replace(case, state=state, start_time=0.0))
    longest = coarse_step(setup)
    if not setup.has_soft_closure:  # its vibrations are faster than its turns
        longest = max(longest, min(4 * longest, orbit.period / 128))
    step = orbit.period / int(np.ceil(orbit.period / longest))
    return LongRun(setup.with_step(step), LOCKED, orbit.period, periods)


def coarse_step(setup: Setup) -> float:
    """Return a long step [s], a power of two, that the model's own equations bear."""
    factor = COARSER[min(setup.integrator.order, 6)]
    if setup.scene.discretisation_coordinates:
        factor = min(factor, COARSEST_ELEMENTS)
    bound = setup.stable_step_bound
    step = factor * default_step(setup.case, setup.integrator)
    return float(min(step, power_of_two(bound) if np.isfinite(bound) else np.inf))

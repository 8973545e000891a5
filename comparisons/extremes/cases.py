"""Cases pushed to extremes, and failures provoked for real.

Parameters are pushed at a step that suits them and at the usual one; so are starts. Every way
to fail is provoked that is known of an engine and that a scene can provoke.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from ...reference import get_scene
from ..checks.suite import best_method
from ..engines.registry import REFERENCE as REFERENCE_ENGINE
from ..engines.registry import get_engine
from ..engines.setup import Setup, shortest_period
from ..engines.variants.catalogue import EXTRA_METHODS
from ..scenes.data import scene_data
from ..scenes.extremes import EngineFailure, EngineProbe, Extreme
from .judge import judge
from .row import ENGINE, FAILED, REFERENCE, REFUSED, WRONG, Provocation, Row, rules_against

PERIODS = 4
"""Shortest periods that a run lasts."""

MOST_STEPS = {1: 8192, 2: 4096}
"""Most steps of a run, by order of the method, 2048 without; those of order 1 need many."""

USUAL_STEPS = 100
"""Usual steps that a run with the usual step lasts at least."""

START_LONGER = 4
"""By how much runs from a start may have more steps."""

Run = tuple[str, Setup, float | None]
"""Name of a row, what is run, and its horizon [s]."""


def best_setups(scene: str, extreme: Extreme, engine_name: str) -> Iterator[Setup]:
    """Yield the extreme on each model, by its best method; without one where there is none."""
    engine, case = get_engine(engine_name), extreme.altered(scene)
    known = engine.models(scene)
    for model in [name for name in extreme.models if name in known] or known[:1]:
        setup = Setup(engine, case, model)
        yield replace(setup, method=best_method(setup))


def with_extra_methods(setup: Setup) -> list[Setup]:
    """Return a setup, and the same by those of `EXTRA_METHODS` that run."""
    names = (
        () if setup.scene.discretisation_coordinates else EXTRA_METHODS.get(setup.engine.name, ())
    )
    methods = [one for one in setup.engine.methods if one.name in names and one != setup.method]
    others = (replace(setup, method=method) for method in methods)
    return [setup, *(other for other in others if other.why_not is None)]


def most_steps(setup: Setup) -> int:
    """Return the most steps of a run."""
    return MOST_STEPS.get(setup.integrator.order, 2048)


def parameter_runs(scene: str, extreme: Extreme, engine_name: str) -> Iterator[Run]:
    """Yield runs with a step that suits the parameters, and with the one that a user leaves."""
    usual = get_scene(scene).case(extreme.case)
    for best in best_setups(scene, extreme, engine_name):
        for setup in with_extra_methods(best):
            if setup.method is None:
                yield extreme.name, setup, None
                continue
            horizon = extreme.horizon or PERIODS * shortest_period(setup.case)
            steps = {"adapted": setup.default_step, "kept": setup.with_case(usual).default_step}
            if steps["kept"] == steps["adapted"]:
                del steps["kept"]
            for kind, step in steps.items():
                least = USUAL_STEPS * step if kind == "kept" else 0.0
                longest = max(min(horizon, most_steps(setup) * step), least)
                yield f"{extreme.name}, {kind} step", setup.with_step(step), longest


def start_runs(scene: str, extreme: Extreme, engine_name: str) -> Iterator[Run]:
    """Yield runs from a start, with a step that suits it."""
    for setup in best_setups(scene, extreme, engine_name):
        if setup.method is None:
            yield extreme.name, setup, None
            continue
        step = setup.default_step
        longest = START_LONGER * most_steps(setup) * step
        horizon = longest if extreme.horizon is None else min(extreme.horizon, longest)
        yield extreme.name, setup.with_step(step), horizon


RUNS = {"parameters": parameter_runs, "starts": start_runs}
"""By section."""


def push(section: str, scene: str, extreme: Extreme, engine_name: str) -> list[Row]:
    """Return the rows of one extreme by one engine."""
    return [
        judge(Row.of(section, name, setup, changed=extreme.alterations), setup, horizon)
        for name, setup, horizon in RUNS[section](scene, extreme, engine_name)
    ]


def extreme_tasks(
    section: str, scenes: tuple[str, ...], engines: tuple[str, ...], full: bool
) -> list[Provocation]:
    """Return the tasks of a section."""
    return [
        Provocation(section, scene, one.name, engine, partial(push, section, scene, one, engine))
        for scene in scenes
        for one in scene_data(scene, "extremes", section.upper(), tuple[Extreme, ...]())
        for engine in engines
        if full or not one.full
    ]


SECTION = "failures"


def failures(scene: str, section: str = SECTION) -> list[EngineFailure]:
    """Return the failures that a scene has in a section."""
    listed: tuple[EngineFailure, ...] = scene_data(scene, "extremes", "FAILURES", ())
    return [failure for failure in listed if failure.section == section]


def provoke(scene: str, failure: EngineFailure) -> list[Row]:
    """Return the row of a failure."""
    engine = failure.engine.make()
    method = next(one for one in engine.methods if one.name == failure.method)
    setup = Setup(engine, failure.altered(scene), failure.models[0], method, failure.step)
    row = Row.of(
        failure.section, failure.name, setup, changed={**failure.alterations, **failure.settings}
    )
    return [judge(row, setup, failure.horizon)]


def observe(probe: EngineProbe) -> list[Row]:
    """Return the row of what an engine does beside simulating."""
    engine = get_engine(probe.engine)
    method = next((one for one in engine.methods if one.name == probe.method), None)
    setup = Setup(engine, probe.case, probe.model, method, probe.step)
    seen = probe.observe(probe.case, probe.model)
    noticed: tuple[str, ...] = (ENGINE,) if seen.outcome in (FAILED, REFUSED) else ()
    if seen.outcome == WRONG:
        rules = rules_against(setup, probe.horizon) if probe.horizon else ()
        noticed = (*rules, REFERENCE)
    return [Row.of(SECTION, probe.name, setup, noticed_by=noticed, **seen._asdict())]


def failure_tasks(
    section: str, scenes: tuple[str, ...], engines: tuple[str, ...], full: bool
) -> list[Provocation]:
    """Return the tasks of failures in a section; those of the reference belong to all engines."""
    wanted = (*engines, REFERENCE_ENGINE)
    provoked = [
        Provocation(section, scene, one.name, one.engine.engine, partial(provoke, scene, one))
        for scene in scenes
        for one in failures(scene, section)
        if one.engine.engine in wanted
    ]
    return provoked + [
        Provocation(section, scene, one.name, one.engine, partial(observe, one))
        for scene in scenes
        for one in scene_data(scene, "extremes", "PROBES", tuple[EngineProbe, ...]())
        if section == SECTION and one.engine in engines
    ]

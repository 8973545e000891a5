"""Every way to fail that is known of an engine and that a scene can provoke, provoked for real."""

from __future__ import annotations

from functools import partial

from ..engines.registry import REFERENCE as REFERENCE_ENGINE
from ..engines.registry import get_engine
from ..engines.setup import Setup
from ..scenes.data import scene_data
from ..scenes.extremes import EngineFailure, EngineProbe
from .judge import judge
from .row import ENGINE, FAILED, REFERENCE, REFUSED, WRONG, Row, Task, rules_against

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
    changed = {**failure.alterations, **failure.settings}
    row = Row.of(failure.section, failure.name, setup, changed=changed)
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


def tasks(
    section: str, scenes: tuple[str, ...], engines: tuple[str, ...], full: bool
) -> list[Task]:
    """Return the tasks of failures in a section; those of the reference belong to all engines."""
    wanted = (*engines, REFERENCE_ENGINE)
    provoked = [
        Task(section, scene, one.name, one.engine.engine, partial(provoke, scene, one))
        for scene in scenes
        for one in failures(scene, section)
        if one.engine.engine in wanted
    ]
    return provoked + [
        Task(section, scene, one.name, one.engine, partial(observe, one))
        for scene in scenes
        for one in scene_data(scene, "extremes", "PROBES", tuple[EngineProbe, ...]())
        if section == SECTION and one.engine in engines
    ]

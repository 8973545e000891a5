"""The example of an engine in the page for authors of plug-ins."""

from __future__ import annotations

import re
import types
from pathlib import Path
from typing import Any

from mbcheck.comparisons.checks.suite import Check, checks_of, kinds_of, run_check
from mbcheck.comparisons.checks.table import KINDS
from mbcheck.comparisons.checks.verdict import Result
from mbcheck.comparisons.engines import registry as engines
from mbcheck.comparisons.engines.adapter import Adapter, adapt
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.reference import get_scene
from mbcheck.reference.scene import Case

CASES = {"hula_hoop": "semicircle_3hz_60n", "rotor_pendulum": "case_2_startup"}
LEVELS = ("parts", "algebra", "step")


def blocks(page: Path, language: str) -> list[str]:
    """Return the fenced blocks of a language in a page of the clone; pages are not installed."""
    text = page.read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


def toy_class(page: Path, change: tuple[str, str] | None = None) -> Any:
    """Return the class of a page's example, perhaps with a text in it replaced."""
    (source,) = blocks(page, "python")
    if change:
        assert change[0] in source
        source = source.replace(*change)
    module = types.ModuleType("toy_engine")
    exec(source, module.__dict__)
    return module.Toy


def results(
    engine: Any,
    scene: str,
    kinds: tuple[str, ...] = LEVELS,
    name: str | None = None,
    explain: bool = True,
) -> list[Result]:
    """Return what some kinds of check say of an engine in one case."""
    one = adapt("toy_engine:Toy", engine)
    case = get_scene(scene).case(name or CASES.get(scene, get_scene(scene).cases[0].name))
    found = []
    for kind in kinds_of(case):
        if kind in kinds:
            for check in all_checks(kind, case, one):
                found += run_check(check, engine=one, explain=explain)
    return found


def cases_of_all_kinds(scene: str) -> list[str]:
    """Return a few cases of the default set that are put to all kinds that any of it is put to."""
    cases = [case for case in get_scene(scene).cases if not case.full_only]
    missing, names = {kind for case in cases for kind in kinds_of(case)}, []
    while missing:
        best = max(cases, key=lambda case: len(missing & {*kinds_of(case)}))
        names.append(best.name)
        missing -= {*kinds_of(best)}
    return names


def by_quantity(engine: Adapter, kind: str, case: Case, model: str) -> dict[str, Result]:
    """Return what one kind of check says of an engine's model, by its first method."""
    method = engine.methods[0] if KINDS[kind].integrates else None
    names = KINDS[kind].quantities(Setup(engine, case, model, method))
    check = Check(kind, case, engine.name, model, method, names)
    return {result.quantity: result for result in run_check(check, engine=engine)}


def all_checks(kind: str, case: Any, engine: Adapter, twins: bool = False) -> Any:
    """Return the checks of a kind for an engine in a case, of the models with a drive in time."""
    engines._named[engine.name] = engine
    try:
        checks = list(checks_of(kind, case, engine.name))
        return [check for check in checks if (check.model in engine.twins(case.scene)) == twins]
    finally:
        del engines._named[engine.name]


def seen(engine: Any, scene: str, kinds: tuple[str, ...]) -> set[tuple[str, str]]:
    """Return the cases and kinds of a scene's default set in which an engine deviates."""
    plugged, known = adapt("earned", engine), get_scene(scene)
    return {
        (case.label, kind)
        for case in (*known.cases, *known.placed)
        if not case.full_only
        for kind in kinds_of(case)
        if kind in kinds
        for check in all_checks(kind, case, plugged)
        if bad(run_check(check, engine=plugged, explain=False))
    }


def bad(items: list[Result]) -> list[Result]:
    """Return what deviates or is an error."""
    return [item for item in items if item.verdict in ("deviation", "error")]

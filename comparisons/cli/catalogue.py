"""Contents: scenes, engines, methods, models and kinds of check, and the parts of a scene."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Mapping
from typing import Any

from rich.console import Console

from ...models import mjcf
from ...reference import SCENES, get_scene
from ...reference.errors import EngineUnavailableError
from ...reference.scene import Case, Scene
from ..checks.suite import plan
from ..checks.table import KINDS
from ..documents import SCHEMA
from ..engines.registry import checked_engines, get_engine, known, usable
from ..maps.request import axis_names, quantities
from ..reports.text import matrix_by_kind, print_line, print_table
from ..reports.words import assignments


def overview() -> dict[str, Any]:
    """Return scenes, engines and kinds of check, as ``mbcheck list --json`` writes them."""
    scenes = [get_scene(name) for name in SCENES]
    return {
        "schema": SCHEMA,
        "scenes": [{"name": scene.name, "title": scene.title} for scene in scenes],
        "engines": [engine_entry(name) for name in known()],
        "kinds": list(KINDS),
    }


def coverage() -> dict[str, Any]:
    """Return the number of checks of each kind, as ``mbcheck list --coverage`` writes it.

    Returns
    -------
    dict
        ``cells``: for each scene, engine and kind the number of checks that run by
        default, those that ``--full`` adds, the results that they give, and, where there
        is none, why.
    """
    counts: Counter[tuple[str, str, str, str]] = Counter()
    reasons: dict[tuple[str, str, str], str] = {}
    for check in plan(full=True):
        cell = (check.case.scene, check.engine, check.kind)
        if check.unsupported_reason is not None:
            reasons[cell] = check.unsupported_reason
            continue
        counts[*cell, "full" if check.full_only else "checks"] += 1
        counts[*cell, "results"] += 0 if check.full_only else len(check.ids)
    cells = [
        {
            "scene": scene,
            "engine": engine,
            "kind": kind,
            **{item: counts[scene, engine, kind, item] for item in ("checks", "full", "results")},
            "reason": why_none(counts, reasons, (scene, engine, kind)),
        }
        for scene in SCENES
        for engine in checked_engines()
        if usable(engine)
        for kind in KINDS
    ]
    return {"schema": SCHEMA, "cells": cells}


def why_none(
    counts: Mapping[tuple[str, str, str, str], int],
    reasons: Mapping[tuple[str, str, str], str],
    cell: tuple[str, str, str],
) -> str | None:
    """Return the reason if a cell of the coverage has no check by default, else None."""
    if counts.get((*cell, "checks")):
        return None
    if counts.get((*cell, "full")):
        return "with --full only"
    return reasons.get(cell, "no case or model has it")


def engine_entry(name: str) -> dict[str, Any]:
    """Return an engine's version, methods and models, or why it cannot be imported."""
    try:
        engine = get_engine(name)
    except EngineUnavailableError as error:
        return {"name": name, "version": None, "reason": str(error), "methods": [], "models": {}}
    return {
        "name": name,
        "version": engine.version,
        "reason": None,
        "methods": [{"name": method.name, "order": method.order} for method in engine.methods],
        "models": {scene: list(engine.models(scene)) for scene in SCENES},
    }


def scene_sheet(name: str) -> dict[str, Any]:
    """Return the parts of a scene, as ``mbcheck list SCENE --json`` writes them.

    Raises
    ------
    UnknownNameError
        If there is no such scene.
    """
    scene = get_scene(name)
    return {
        "schema": SCHEMA,
        "scene": scene.name,
        "title": scene.title,
        "paper": scene.paper._asdict(),
        "parameters": parameters(scene),
        "states": [{"name": state, "unit": scene.units[state]} for state in scene.public_states],
        "outputs": [
            {"name": name, "unit": unit, "on_request": name not in scene.observables}
            for name, unit in scene.units.items()
            if name not in scene.state_names
        ],
        "about": list(scene.equilibria),
        "drive": scene.drive_form or None,
        "cases": [case_entry(case) for case in scene.cases],
        "models": {
            entry["name"]: list(get_engine(entry["name"]).models(name))
            for entry in map(engine_entry, known())
            if entry["models"]
        },
        "mjcf": list(mjcf.models(name)),
        "maps": [
            {
                "quantity": quantity,
                "about": scene_map.about,
                "models": list(scene_map.models),
                "engines": scene_map.engines,
                "variables": {
                    key: {"unit": item.unit, "meaning": item.meaning, "classes": list(item.classes)}
                    for key, item in scene_map.variables.items()
                },
            }
            for quantity, scene_map in quantities(name).items()
        ],
        "axes": [
            {"name": key, "unit": item.unit, "meaning": item.meaning}
            for key, item in axis_names(name).items()
        ],
    }


def parameters(scene: Scene) -> list[dict[str, Any]]:
    """Return name, symbol, unit, default, source, meaning and bound of each parameter."""
    return [
        {
            "name": item.name,
            "default": item.default,
            **{key: value for key, value in item.metadata.items() if key != "options"},
        }
        for item in dataclasses.fields(scene.parameters)
    ]


def case_entry(case: Case) -> dict[str, Any]:
    """Return a case: its parameters, start, horizon and kinds of check."""
    changed = {
        name: value
        for name, value in case.parameters.as_dict().items()
        if value != type(case.parameters)().as_dict()[name]
    }
    return {
        "name": case.name,
        "kinds": list(case.kinds),
        "parameters": changed,
        "state": dict(case.state),
        "inconsistency": dict(case.inconsistency),
        "horizon": case.horizon,
        "full_only": case.full_only,
    }


# On the console


def print_overview(console: Console, overview: Mapping[str, Any]) -> None:
    """Print scenes, engines with their methods, and kinds of check."""
    print_table(console, ["scene", ""], [[s["name"], s["title"]] for s in overview["scenes"]])
    engines = [
        [
            item["name"],
            item["version"] or "not available",
            item["reason"] or ", ".join(f"{m['name']} ({m['order']})" for m in item["methods"]),
        ]
        for item in overview["engines"]
    ]
    print_table(console, ["engine", "version", "methods (order)"], engines)
    print_line(console, f"kinds of check: {', '.join(overview['kinds'])}")
    print_line(console, "more about a scene: mbcheck list SCENE")


def print_coverage(console: Console, coverage: Mapping[str, Any]) -> None:
    """Print how many checks each scene, engine and kind has."""
    cells = coverage["cells"]
    counts: dict[tuple[str, ...], object] = {
        (c["scene"], c["engine"], c["kind"]): c["checks"] or None for c in cells
    }
    print_table(console, *matrix_by_kind(counts))
    for cell in cells:
        if not cell["checks"]:
            place = " ".join((cell["scene"], cell["engine"], cell["kind"]))
            print_line(console, f"{place}: {cell['reason']}")
    print_line(console, "checks that run by default; each judges several quantities")


def print_scene(console: Console, sheet: Mapping[str, Any]) -> None:
    """Print a scene: source, parameters, states, places of rest, models, cases."""
    paper = sheet["paper"]
    print_line(console, f"{sheet['scene']}: {sheet['title']}")
    where = [paper["journal"], f"doi {paper['doi']}" if paper["doi"] else ""]
    source = ", ".join(filter(None, [paper["title"], *where]))
    print_line(console, f"{paper['authors']} ({paper['year']}), {source}")
    names = ("name", "symbol", "default", "unit", "source", "meaning")
    rows = [[item[name] for name in names] for item in sheet["parameters"]]
    print_table(console, ["parameter", *names[1:]], rows)
    lines = {"states and observables:": with_units(sheet["states"])}
    for on_request, label in ((False, "also observed:"), (True, "on request (--observe):")):
        lines[label] = with_units([o for o in sheet["outputs"] if o["on_request"] == on_request])
    lines["states of rest (--about):"] = ", ".join(sheet["about"])
    lines["drive:"] = sheet["drive"] or "no function of time"
    for engine, models in sheet["models"].items():
        lines[f"models of {engine}:"] = ", ".join(models) or "none"
    for label, text in lines.items():
        if text:
            print_line(console, f"{label} {text}")
    console.print()
    cases = [
        [
            item["name"],
            item["horizon"],
            assignments(
                {
                    **item["parameters"],
                    **item["state"],
                    **{f"offset of {name}": x for name, x in item["inconsistency"].items()},
                }
            ),
            ", ".join(item["kinds"]) + (" (--full only)" if item["full_only"] else ""),
        ]
        for item in sheet["cases"]
    ]
    print_table(console, ["case", "horizon [s]", "differs by", "kinds"], cases)
    maps = [
        [
            item["quantity"],
            item["about"],
            ", ".join(item["models"]),
            ", ".join(item["variables"]),
            "yes" if item["engines"] else "no",
        ]
        for item in sheet["maps"]
    ]
    if maps:
        heads = ["map (--quantity)", "of", "models of the reference", "variables", "engines"]
        print_table(console, heads, maps)
    if sheet["axes"]:
        rows = [[item[name] for name in ("name", "unit", "meaning")] for item in sheet["axes"]]
        print_table(console, ["axis of a map", "unit", "meaning"], rows)


def with_units(items: list[Mapping[str, Any]]) -> str:
    """Return names with their units."""
    return ", ".join(f"{item['name']} [{item['unit']}]" for item in items)

"""What there is: scenes, engines, methods, models, kinds, and what a scene consists of."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Mapping
from typing import Any

from ...models import mjcf
from ...reference import SCENES, get_scene
from ...reference.errors import EngineUnavailableError
from ...reference.scene import Case, Scene
from ..checks.suite import KINDS, plan
from ..documents import SCHEMA
from ..engines.registry import checked_engines, get_engine, known, usable
from ..maps.request import axis_names, quantities


def overview() -> dict[str, Any]:
    """Return scenes, engines and kinds of check: what ``mbcheck list --json`` writes."""
    scenes = [get_scene(name) for name in SCENES]
    return {
        "schema": SCHEMA,
        "scenes": [{"name": scene.name, "title": scene.title} for scene in scenes],
        "engines": [engine_entry(name) for name in known()],
        "kinds": list(KINDS),
    }


def coverage() -> dict[str, Any]:
    """Return how many checks of each kind there are: what ``mbcheck list --coverage`` writes.

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
        if check.why_not is not None:
            reasons[cell] = check.why_not
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
    """Return why a cell of the coverage has no check by default, or None."""
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
    """Return what a scene consists of: what ``mbcheck list SCENE --json`` writes.

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
    """Return a case: how it starts, how long it runs, what it feeds."""
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

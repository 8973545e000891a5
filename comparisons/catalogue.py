"""What there is: scenes, engines, methods, models, kinds, and what a scene consists of."""

from __future__ import annotations

import dataclasses
from typing import Any

from ..models import mjcf
from ..reference import SCENES, get_scene
from ..reference.errors import EngineUnavailableError
from ..reference.scene import Case, Scene
from .engines import ENGINES, get_engine
from .report import SCHEMA
from .suite import KINDS


def overview() -> dict[str, Any]:
    """Return scenes, engines and kinds of check: what ``mbcheck list --json`` writes."""
    scenes = [get_scene(name) for name in SCENES]
    return {
        "schema": SCHEMA,
        "scenes": [{"name": scene.name, "title": scene.title} for scene in scenes],
        "engines": [engine_entry(name) for name in ENGINES],
        "kinds": list(KINDS),
    }


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
        "states": [{"name": state, "unit": scene.units[state]} for state in scene.state_names],
        "about": list(scene.equilibria),
        "cases": [case_entry(case) for case in scene.cases],
        "models": {
            entry["name"]: entry["models"][name]
            for entry in map(engine_entry, ENGINES)
            if entry["models"]
        },
        "mjcf": list(mjcf.models(name)),
    }


def parameters(scene: Scene) -> list[dict[str, Any]]:
    """Return name, symbol, unit, default, source, meaning and bound of each parameter."""
    return [
        {"name": item.name, "default": item.default, **item.metadata}
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
        "horizon": case.horizon,
        "full_only": case.full_only,
    }

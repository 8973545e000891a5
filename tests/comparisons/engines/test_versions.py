"""Older engines: what is refused, what is translated, and what a diff of releases shows."""

from __future__ import annotations

import importlib
import re
import tomllib
import warnings
from dataclasses import replace
from functools import reduce
from inspect import signature
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from packaging.requirements import Requirement

from mbcheck.comparisons.engines.exudyn import engine as exudyn
from mbcheck.comparisons.engines.exudyn.engine import RENAMED, Exudyn, assign
from mbcheck.comparisons.engines.mujoco import engine as mujoco
from mbcheck.comparisons.engines.mujoco.engine import MuJoCo
from mbcheck.comparisons.faults.exudyn import ExudynAdapter
from mbcheck.reference import get_scene
from mbcheck.reference.errors import EngineUnavailableError

INTEGRATORS = ("EULER", "RK4", "IMPLICIT", "IMPLICITFAST")


def released(version: str, *integrators: str) -> Any:
    """Return what an adapter asks of the engine's module when it is made."""
    names = {f"mjINT_{name}": i for i, name in enumerate(integrators)}
    return SimpleNamespace(__version__=version, mjtIntegrator=SimpleNamespace(**names))


@pytest.mark.parametrize(
    ("engine", "version", "least"),
    [
        (MuJoCo, "3.5.0", "3.6"),
        (MuJoCo, "2.3.7", "3.6"),
        (Exudyn, "1.9.83.dev1", "1.10"),
    ],
)
def test_an_engine_that_is_too_old_is_refused(
    monkeypatch: pytest.MonkeyPatch,
    engine: type[MuJoCo | Exudyn],
    version: str,
    least: str,
) -> None:
    monkeypatch.setattr(importlib, "import_module", lambda name: released(version))
    wanted = f"{engine.name} {version} is too old: mbcheck needs {engine.name} {least} or newer"
    with pytest.raises(EngineUnavailableError, match=wanted):
        engine()


@pytest.mark.parametrize("version", ["3.6.0", "3.12.0", "4.0.1.dev2"])
@pytest.mark.parametrize("more", [(), ("DISCRETE",)])
def test_methods_are_those_that_this_mujoco_has(
    monkeypatch: pytest.MonkeyPatch, version: str, more: tuple[str, ...]
) -> None:
    monkeypatch.setattr(
        importlib, "import_module", lambda name: released(version, *INTEGRATORS, *more)
    )
    engine = MuJoCo()
    assert engine.version == version
    assert {m.name.upper() for m in engine.methods} == {*INTEGRATORS, *more}


def test_pins_and_documents_tell_the_least_versions(clone: Path) -> None:
    project = tomllib.loads((clone / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    needed = {r.name: str(r.specifier) for r in map(Requirement, project["dependencies"])}
    text = (clone / "docs/versions.md").read_text(encoding="utf-8")
    for title, module in (("MuJoCo", mujoco), ("Exudyn", exudyn)):
        least = module.LEAST_VERSION
        assert needed[title.lower()] == f">={least}"
        assert f"{title} {least} or newer" in text


# --- what Exudyn called otherwise before 1.12

CHANGED = {
    "solution.file.write": "False",
    "solution.sensors.active": "False",
    "timeIntegration.solverType": "exudyn.DynamicSolverType.RK44",
    "timeIntegration.newton.residualMode": "1",
    "linearSolver.solverType": "exudyn.LinearSolverType.EigenSparse",
}
"""Settings, and a value that is not their default."""


def setting(settings: Any, path: str) -> Any:
    return reduce(getattr, path.split("."), settings)


@pytest.mark.parametrize("path", RENAMED)
def test_a_setting_is_the_same_by_both_names(path: str) -> None:
    exudyn = pytest.importorskip("exudyn", exc_type=ImportError)
    settings, value = exudyn.SimulationSettings(), eval(CHANGED[path], {"exudyn": exudyn})
    if not hasattr(settings, "solution"):
        pytest.skip("this Exudyn has the older names alone")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        assert setting(settings, RENAMED[path]) != value
        assign(settings, path, value)
        assert setting(settings, path) == setting(settings, RENAMED[path]) == value


@pytest.mark.parametrize("path", RENAMED)
def test_older_settings_are_set_by_their_older_names(path: str) -> None:
    older = SimpleNamespace(
        solutionSettings=SimpleNamespace(writeSolutionToFile=0, sensorsStoreAndWriteFiles=0),
        timeIntegration=SimpleNamespace(
            newton=SimpleNamespace(newtonResidualMode=0),
            explicitIntegration=SimpleNamespace(dynamicSolverType=0),
        ),
        linearSolverType=0,
    )
    assign(older, path, 7)
    assert setting(older, RENAMED[path]) == 7
    assert re.findall(r"=7\b", repr(older)) == ["=7"]


class Older:
    """``exudyn.itemInterface`` before 1.12, as far as it is asked here."""

    class ObjectRotationalMass1D:
        def __init__(self, physicsInertia: float = 1, nodeNumber: int = -1) -> None:
            self.given = {"physicsInertia": physicsInertia, "nodeNumber": nodeNumber}


@pytest.fixture
def older_items(monkeypatch: pytest.MonkeyPatch) -> Any:
    pytest.importorskip("exudyn", exc_type=ImportError)
    system = importlib.import_module("mbcheck.models.exudyn_system")
    monkeypatch.setattr(system.Items, "module", Older)
    return system.items


def test_items_take_the_names_of_today(older_items: Any) -> None:
    made = older_items.ObjectRotationalMass1D(inertia=2.0, nodeNumber=3)
    assert made.given == {"physicsInertia": 2.0, "nodeNumber": 3}
    with pytest.raises(TypeError, match="physicsDiameter"):
        older_items.ObjectRotationalMass1D(diameter=1.0)


def test_older_names_of_items_were_these() -> None:
    """Exudyn 1.13 takes both."""
    items = pytest.importorskip("exudyn.itemInterface", exc_type=ImportError)
    physics = importlib.import_module("mbcheck.models.exudyn_system").physics
    for kind, names in (
        ("ObjectMass1D", "mass"),
        ("ObjectMassPoint2D", "mass"),
        ("ObjectRigidBody2D", "mass inertia"),
        ("ObjectRotationalMass1D", "inertia"),
        ("ObjectANCFCable2D", "length massPerLength bendingStiffness axialStiffness"),
        ("ObjectBeamGeometricallyExact2D", "crossSectionInertia shearStiffness"),
    ):
        assert {physics(name) for name in names.split()} <= set(
            signature(getattr(items, kind)).parameters
        )


def test_what_an_older_exudyn_cannot_join_is_skipped(older_items: Any) -> None:
    engine = ExudynAdapter()

    def refused(scene: str, model: str, **more: Any) -> str | None:
        case = get_scene(scene).cases[0]
        case = replace(case, parameters=case.parameters.replace(**more))
        return engine.bind(case, model).unsupported_reason(case, None)

    reason = f"Exudyn {engine.version} takes no joint off the axis of a rotor"
    assert str(refused("speed_regulator", "redundant")).startswith(reason)
    assert str(refused("rotating_beam", "elements", hub_radius=0.1)).startswith(reason)
    turned = replace(get_scene("speed_regulator").cases[0], placement="turned:1")
    redundant = engine.bind(turned, "redundant")
    assert redundant.description.unplaceable_reason is None  # bodies in space, and no rotor
    assert engine.bind(turned, "redundant").unsupported_reason(turned, None) is None
    on_rim = get_scene("rotating_beam").case("weighed")
    elements = engine.bind(replace(on_rim, placement="turned:1"), "elements")
    assert str(elements.description.unplaceable_reason).startswith(reason)
    assert refused("speed_regulator", "one_dof") is None
    assert refused("rotating_beam", "elements", hub_radius=0.0) is None

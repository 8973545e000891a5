"""Older engines: what is refused, what is translated, and what a diff of releases shows."""

from __future__ import annotations

import importlib
import json
import os
import re
import shutil
import subprocess
import sys
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

from mbcheck.comparisons.checks.diagnosis.steps import ANOTHER_MODEL
from mbcheck.comparisons.checks.verdict import result_from
from mbcheck.comparisons.engines.exudyn import engine as exudyn
from mbcheck.comparisons.engines.exudyn.engine import Exudyn
from mbcheck.comparisons.engines.exudyn.settings import RENAMED, assign
from mbcheck.comparisons.engines.mujoco import engine as mujoco
from mbcheck.comparisons.engines.mujoco.engine import MuJoCo
from mbcheck.comparisons.engines.variants.exudyn import ExudynAdapter
from mbcheck.comparisons.reports.run.located import located
from mbcheck.reference import get_scene
from mbcheck.reference.errors import EngineUnavailableError
from mbcheck.reference.speed_regulator.soft import NO_DRIFT

INTEGRATORS = ("EULER", "RK4", "IMPLICIT", "IMPLICITFAST")

LOOP = {"connect", "connect_hard"}
"""Models of the speed regulator whose loop MuJoCo closes."""

ALGEBRA = "verification/speed_regulator/rotation/algebra/mujoco/connect/accelerations"


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
        return engine.why_not(
            replace(case, parameters=case.parameters.replace(**more)), model, None
        )

    reason = f"Exudyn {engine.version} takes no joint off the axis of a rotor"
    assert str(refused("speed_regulator", "redundant")).startswith(reason)
    assert str(refused("rotating_beam", "elements", hub_radius=0.1)).startswith(reason)
    turned = replace(get_scene("speed_regulator").cases[0], placement="turned:1")
    assert engine.why_not_placed(turned, "redundant") is None  # bodies in space, and no rotor
    assert engine.why_not(turned, "redundant", None) is None
    on_rim = get_scene("rotating_beam").case("weighed")
    refusal = engine.why_not_placed(replace(on_rim, placement="turned:1"), "elements")
    assert str(refusal).startswith(reason)
    assert refused("speed_regulator", "one_dof") is None
    assert refused("rotating_beam", "elements", hub_radius=0.0) is None


# --- releases in environments of their own


def output(*command: object, cwd: Path, codes: tuple[int, ...] = (0,)) -> str:
    """Return what a command prints; fail with that text if it fails."""
    environment = {
        k: v for k, v in os.environ.items() if not k.startswith(("PYTEST_", "PYTHONPATH"))
    }
    done = subprocess.run(
        [str(word) for word in command],
        cwd=cwd,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    assert done.returncode in codes, done.stdout
    return done.stdout


@pytest.fixture(scope="module")
def wheel(clone: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the package of this clone."""
    folder = tmp_path_factory.mktemp("wheel")
    sources = folder / "sources"
    shutil.copytree(
        clone,
        sources,
        ignore=lambda at, names: [n for n in names if n.startswith(".") or n == "build"],
    )
    pip = (sys.executable, "-m", "pip", "--disable-pip-version-check")
    if subprocess.run([*pip, "index", "versions", "mujoco"], capture_output=True).returncode:
        pytest.skip("pip reaches no package index")
    build = ("wheel", "--no-deps", "--wheel-dir", folder)
    output(*pip, *build, ".", cwd=sources)
    (found,) = folder.glob("*.whl")
    return found


def recipe(clone: Path, wheel: Path, engine: str, selection: str) -> str:
    """Return the commands of the document for an engine, with fewer checks, for this Python."""
    text = (clone / "docs/versions.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```sh\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    (block,) = (found for found in blocks if f"--engine {engine} " in found)
    for old, new in (
        ("python3", sys.executable),
        ("path/to/mbcheck", str(wheel)),
        ("mbcheck check", f"mbcheck check {selection}"),
    ):
        assert old in block
        block = block.replace(old, new)
    return block


def difference(old: str, new: str, cwd: Path, code: int) -> dict[str, Any]:
    """Return the document of a diff of two runs."""
    mbcheck = cwd / new.removesuffix(".json") / "bin/mbcheck"
    output(mbcheck, "diff", old, new, "--json", "diff.json", cwd=cwd, codes=(code,))
    found: dict[str, Any] = json.loads((cwd / "diff.json").read_text())
    return found


@pytest.mark.parametrize(
    "between",
    [
        pytest.param(False, marks=pytest.mark.slow),
        pytest.param(True, marks=pytest.mark.campaign),  # the release between the two as well
    ],
)
@pytest.mark.skipif(sys.platform == "win32", reason="the recipe is for a POSIX shell")
def test_releases_of_mujoco_differ_where_loops_are_closed(
    between: bool, clone: Path, wheel: Path, tmp_path: Path
) -> None:
    selection = "hula_hoop speed_regulator --kind algebra --kind order"
    commands = recipe(clone, wheel, "mujoco", selection)
    if not between:
        assert " 3.12 " in commands
        commands = re.sub(r" 3\.12 |^.* mujoco-3\.12\.json .*$", " ", commands, flags=re.MULTILINE)
    output("bash", "-c", commands, cwd=tmp_path)
    old, middle, new = (f"mujoco-{release}.json" for release in ("3.6", "3.12", "4.0"))

    forward = difference(old, new, tmp_path, 0)
    assert forward["old"]["versions"]["mujoco"].startswith("3.6.")
    assert forward["new"]["versions"]["mujoco"].startswith("4.")
    assert not forward["regressions"]
    fixed = {item["id"]: item for item in forward["changes"] if item["sort"] == "fixed"}
    others = [item for item in forward["changes"] if item["sort"] != "fixed"]
    assert {(item["new"]["scene"], item["new"]["model"]) for item in fixed.values()} == {
        ("speed_regulator", model) for model in LOOP
    }
    assert {(item["sort"], item["new"]["method"]) for item in others} == {("appeared", "discrete")}
    assert fixed[ALGEBRA]["old"]["error"] > 0.1  # relative
    assert fixed[ALGEBRA]["new"]["error"] < 1e-10
    assert all(item["old"]["verdict"] == "deviation" for item in fixed.values())

    results = [result_from(item) for item in json.loads((tmp_path / old).read_text())["results"]]
    causes = {item.cause for item in results if item.verdict == "deviation"}
    assert NO_DRIFT in causes <= {NO_DRIFT, ANOTHER_MODEL, None}
    checks = {item.check_id for item in results if item.cause == NO_DRIFT}
    assert located(results) == [
        "mujoco: its accelerations or its mass matrix is wrong",
        f"  {NO_DRIFT} (speed_regulator; {len(checks)} checks)",
    ]

    back = difference(new, old, tmp_path, 1)
    worse = {item["id"] for item in back["changes"] if item["sort"] == "new_deviation"}
    assert worse == set(fixed)

    if between:
        later = difference(middle, new, tmp_path, 0)
        assert {(item["sort"], item["new"]["method"]) for item in later["changes"]} == {
            ("appeared", "discrete")
        }


@pytest.mark.campaign
@pytest.mark.skipif(sys.platform == "win32", reason="the recipe is for a POSIX shell")
def test_an_older_exudyn_runs_what_it_can(clone: Path, wheel: Path, tmp_path: Path) -> None:
    commands = recipe(clone, wheel, "exudyn", "--kind algebra --kind energy")
    output("bash", "-c", commands, cwd=tmp_path)
    found = difference("exudyn-1.10.json", "exudyn-1.13.json", tmp_path, 0)
    assert {(item["sort"], item["new"]["scene"]) for item in found["changes"]} == {
        ("now_runs", "speed_regulator"),
        ("appeared", "speed_regulator"),  # of a case that runs each model's best method alone
        ("now_runs", "rotating_beam"),  # `weighed`, whose clamp is off the axis
    }
    document = json.loads((tmp_path / "exudyn-1.10.json").read_text())
    verdicts = {result["verdict"] for result in document["results"]}
    assert verdicts == {"pass", "skipped"}

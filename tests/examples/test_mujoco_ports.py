"""MuJoCo's algorithms on other hardware, plugged in as a third party would; where installed."""

from __future__ import annotations

import fnmatch
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from mbcheck.comparisons.checks import known
from mbcheck.comparisons.engines.adapter import adapt
from mbcheck.reference import get_scene
from mbcheck.tests.support.example import all_checks, bad, results

PORTS = {"mujoco_warp": "MujocoWarpEngine", "mjx": "MjxEngine"}
NEEDS = {"mujoco_warp": "mujoco_warp", "mjx": "mujoco.mjx"}
TREES = ("hula_hoop", "rotor_pendulum")

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
CASES_KNOWN = {"mjx": {"rotation", "long_crank", "weighed"}, "mujoco_warp": {"rotation"}}

slow = pytest.mark.slow


@pytest.fixture(params=PORTS)
def engine(request: pytest.FixtureRequest) -> Any:
    pytest.importorskip(NEEDS[request.param])
    return getattr(
        import_module(f"mbcheck.examples.{request.param}_engine"), PORTS[request.param]
    )()


@slow
@pytest.mark.parametrize("scene", TREES)
def test_trees_pass(engine: Any, scene: str) -> None:
    found = results(engine, scene)
    assert {item.verdict for item in found} <= {"pass", "skipped"}
    assert {item.subject.kind for item in found if item.verdict == "pass"} == {
        "parts",
        "algebra",
        "step",
    }


@slow
@pytest.mark.parametrize(("scene", "case"), [("hula_hoop", "rod_aligned"), (TREES[1], None)])
def test_free_runs_of_trees_pass(engine: Any, scene: str, case: str | None) -> None:
    found = results(engine, scene, ("trajectory",), case)
    assert {item.subject.method for item in found} == {"RK4", "Euler"}
    assert {item.verdict for item in found} <= {"pass", "skipped"}
    assert "pass" in {item.verdict for item in found}


@slow
def test_loops_lack_a_term_that_mujoco_has(engine: Any) -> None:
    found = bad(results(engine, "speed_regulator", ("algebra",), "rotation"))
    assert found
    assert all("lacks dJ/dt v" in (item.cause or "") for item in found)


@pytest.mark.parametrize("name", PORTS)
def test_known_deviations_are_of_ids_that_there_are(name: str) -> None:
    """Of its methods and models, which are those of MuJoCo plugged in; it need not be there."""
    plugin = pytest.importorskip("mbcheck.examples.mujoco_engine").MujocoPlugin
    stand_in = adapt(name, type("Ids", (plugin,), {"name": name})())
    scene = get_scene("speed_regulator")
    ids = {
        id: case.name
        for case in (*scene.cases, *scene.placed)
        if "algebra" in case.kinds
        for check in all_checks("algebra", case, stand_in)
        for id in check.ids
    }
    entries = known.read(str(EXAMPLES / f"{name}_known.toml")).entries
    about = [{ids[id] for id in fnmatch.filter(ids, entry.id)} for entry in entries]
    assert all(about)
    assert set.union(*about) == CASES_KNOWN[name]
    assert all(entry.max_error for entry in entries)


@slow
def test_no_known_deviation_grew(engine: Any) -> None:
    listing = known.read(str(EXAMPLES / f"{engine.name}_known.toml"))
    found = bad(results(engine, "speed_regulator", ("algebra",), "rotation"))
    assert {listing.settle(item).verdict for item in found} == {"known"}

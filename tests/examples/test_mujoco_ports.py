"""MuJoCo's algorithms on other hardware, plugged in as a third party would; where installed."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import pytest

from mbcheck.tests.support.example import bad, results

PORTS = {"mujoco_warp": "MujocoWarpEngine", "mjx": "MjxEngine"}
NEEDS = {"mujoco_warp": "mujoco_warp", "mjx": "mujoco.mjx"}
TREES = ("hula_hoop", "rotor_pendulum")

pytestmark = pytest.mark.slow


@pytest.fixture(params=PORTS)
def engine(request: pytest.FixtureRequest) -> Any:
    pytest.importorskip(NEEDS[request.param])
    return getattr(
        import_module(f"mbcheck.examples.{request.param}_engine"), PORTS[request.param]
    )()


@pytest.mark.parametrize("scene", TREES)
def test_trees_pass(engine: Any, scene: str) -> None:
    found = results(engine, scene)
    assert {item.verdict for item in found} <= {"pass", "skipped"}
    assert {item.subject.kind for item in found if item.verdict == "pass"} == {
        "parts",
        "algebra",
        "step",
    }


def test_loops_lack_a_term_that_mujoco_has(engine: Any) -> None:
    found = bad(results(engine, "speed_regulator", ("algebra",), "rotation"))
    assert found
    assert all("lacks dJ/dt v" in (item.cause or "") for item in found)

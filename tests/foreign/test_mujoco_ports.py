"""MuJoCo's algorithms on other hardware, plugged in as a third party would."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from mbcheck.comparisons.checks import known
from mbcheck.tests.support.example import bad, results

PORTS = {"mujoco_warp": "MujocoWarpEngine", "mjx": "MjxEngine"}
TREES = ("hula_hoop", "rotor_pendulum")

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"

pytestmark = pytest.mark.foreign


@pytest.fixture(params=PORTS)
def engine(request: pytest.FixtureRequest) -> Any:
    return getattr(
        import_module(f"mbcheck.examples.{request.param}_engine"), PORTS[request.param]
    )()


@pytest.mark.parametrize("scene", TREES)
def test_trees_pass(engine: Any, scene: str) -> None:
    found = results(engine, scene)
    assert {item.verdict for item in found} <= {"pass", "skipped"}
    assert {item.kind for item in found if item.verdict == "pass"} == {
        "parts",
        "algebra",
        "step",
    }


@pytest.mark.parametrize(("scene", "case"), [("hula_hoop", "rod_aligned"), (TREES[1], None)])
def test_free_runs_of_trees_pass(engine: Any, scene: str, case: str | None) -> None:
    found = results(engine, scene, ("trajectory",), case)
    assert {item.method for item in found} == {"RK4", "Euler"}
    assert {item.verdict for item in found} <= {"pass", "skipped"}
    assert "pass" in {item.verdict for item in found}


def test_loops_lack_a_term_that_mujoco_has(engine: Any) -> None:
    found = bad(results(engine, "speed_regulator", ("algebra",), "rotation"))
    assert found
    assert all("lacks dJ/dt v" in (item.cause or "") for item in found)


def test_no_known_deviation_grew(engine: Any) -> None:
    listing = known.read(str(EXAMPLES / f"{engine.name}_known.toml"))
    found = bad(results(engine, "speed_regulator", ("algebra",), "rotation"))
    assert {listing.settle(item).verdict for item in found} == {"known"}

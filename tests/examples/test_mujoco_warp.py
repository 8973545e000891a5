"""MuJoCo Warp, plugged in as a third party would; where it is installed."""

from __future__ import annotations

import pytest

from mbcheck.tests.support.example import bad, results

pytest.importorskip("mujoco_warp")

TREES = ("hula_hoop", "rotor_pendulum")


@pytest.mark.slow
@pytest.mark.parametrize("scene", TREES)
def test_trees_pass_in_numbers_of_32_bits(scene: str) -> None:
    from mbcheck.examples.mujoco_warp_engine import MujocoWarpEngine

    found = results(MujocoWarpEngine(), scene)
    assert {item.verdict for item in found} <= {"pass", "skipped"}
    assert {item.subject.kind for item in found if item.verdict == "pass"} == {
        "parts",
        "algebra",
        "step",
    }


@pytest.mark.slow
def test_its_loops_lack_a_term_that_mujoco_has() -> None:
    from mbcheck.examples.mujoco_warp_engine import MujocoWarpEngine

    found = bad(results(MujocoWarpEngine(), "speed_regulator", ("algebra",), "rotation"))
    assert found
    assert all("lacks dJ/dt v" in (item.cause or "") for item in found)

"""Steps of order 1 in the scenes in space, by engines that tell runs alone."""

from __future__ import annotations

from typing import Any

import pytest

from mbcheck.comparisons.checks.suite import run_check
from mbcheck.comparisons.checks.verdict import Result
from mbcheck.comparisons.engines.adapter import adapt
from mbcheck.reference import SCENES, get_scene
from mbcheck.tests.support.example import all_checks

pytest.importorskip("mujoco")
from mbcheck.tests.support.engines.stepping import Single, Stepping

SPACE = [
    pytest.param(name, marks=[pytest.mark.slow] if len(get_scene(name).coordinates) > 5 else [])
    for name in SCENES
    if get_scene(name).quaternions
]
DAMPERS, VELOCITY = "implicit_euler_dampers", "implicit_euler_velocity"
FACTORS = {"reversed": -1.0, "halved": 0.5, "lost": 0.0}


def steps(engine: Any, scene: str) -> dict[str, Result]:
    """Return what *step* says of an engine in the first case and model of a scene."""
    one = adapt("stepping", engine)
    case = next(case for case in get_scene(scene).cases if "trajectory" in case.kinds)
    check = all_checks("step", case, one)[0]
    return {item.quantity: item for item in run_check(check, "strict", one, explain=False)}


def wrong(engine: Any, scene: str) -> list[str]:
    """Return the quantities of *step* that deviate, or are errors."""
    found = steps(engine, scene).items()
    assert any(item.verdict == "pass" for _, item in found)
    return [name for name, item in found if item.verdict in ("deviation", "error")]


@pytest.mark.parametrize("scene", SPACE)
@pytest.mark.parametrize("way", ["semi", "explicit", "end", "dampers", "substeps", "staggered"])
def test_a_right_step_of_order_1_passes(scene: str, way: str) -> None:
    assert not wrong(Stepping(way=way), scene)


@pytest.mark.parametrize("scene", SPACE)
def test_a_right_step_in_32_bits_passes(scene: str) -> None:
    assert not wrong(Single(), scene)


@pytest.mark.parametrize("scene", SPACE)
@pytest.mark.parametrize("fault", ["last", "zero"])
def test_stale_accelerations_in_the_first_step_are_seen(scene: str, fault: str) -> None:
    assert wrong(Stepping(fault=fault), scene)


@pytest.mark.parametrize("scene", SPACE)
@pytest.mark.parametrize(
    ("scheme", "way"),
    [("ExplicitEuler", "explicit"), (DAMPERS, "dampers"), (VELOCITY, "implicit")],
)
def test_a_declared_scheme_passes(scene: str, scheme: str, way: str) -> None:
    found = steps(Stepping(scheme, way), scene)
    assert found["scheme_residual"].verdict == "pass"
    assert not {item.verdict for item in found.values()} & {"deviation", "error"}


@pytest.mark.slow
def test_an_implicit_step_without_the_slope_of_actuators_is_seen() -> None:
    engine = Stepping(DAMPERS, "dampers", "slope")
    assert wrong(engine, "floating_platform") == ["scheme_residual"]


@pytest.mark.parametrize("scene", SPACE)
@pytest.mark.parametrize(
    "said", ["halved", *(pytest.param(one, marks=pytest.mark.slow) for one in ("reversed", "lost"))]
)
def test_derivatives_of_inertial_forces_are_seen(scene: str, said: str) -> None:
    engine = Stepping(VELOCITY, "implicit", "derivative", FACTORS[said])
    assert "scheme_residual" in wrong(engine, scene)


@pytest.mark.parametrize("scene", SPACE)
@pytest.mark.parametrize("said", FACTORS)
def test_gyroscopic_forces_are_seen(scene: str, said: str) -> None:
    assert "extrapolated" in wrong(Stepping(fault="gyroscopic", factor=FACTORS[said]), scene)


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["floating_platform", "floating_beam"])
@pytest.mark.parametrize("said", FACTORS)
def test_coriolis_forces_are_seen(scene: str, said: str) -> None:
    """Bodies that move on a turning one have such forces, and those of the other scenes none."""
    assert "extrapolated" in wrong(Stepping(fault="coriolis", factor=FACTORS[said]), scene)

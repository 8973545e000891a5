"""`orbit`: the periodic orbit of the reference and of engines."""

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.checks import orbits
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.queries.orbit import OrbitReport
from mbcheck.reference.cost import within
from mbcheck.reference.errors import NoOrbitError, UsageError
from mbcheck.reference.hula_hoop.equations import SCENE, HulaHoop
from mbcheck.reference.newton import Effort
from mbcheck.reference.orbits import find_orbit
from mbcheck.reference.scene import Case
from mbcheck.tests.support.documents import validated

POINT = HulaHoop()


@pytest.fixture(scope="module")
def true_orbit() -> OrbitReport:
    return mbcheck.orbit("hula_hoop")


def test_reference_orbit(true_orbit: OrbitReport) -> None:
    document = validated("orbit", true_orbit.as_json())
    assert document["period"] == pytest.approx(1 / 3)
    assert document["mean_speed"] == pytest.approx(6 * np.pi)
    assert document["stable"]
    assert sum(document["power"].values()) == pytest.approx(0, abs=1e-8)
    moduli = [item["modulus"] for item in document["floquet_multipliers"]]
    assert moduli == sorted(moduli, reverse=True)
    theta = document["harmonics"]["theta"]
    assert [term["order"] for term in theta["terms"]] == [1, 2, 3, 4, 5, 6]
    assert theta["terms"][1]["amplitude"] == pytest.approx(0.2606, abs=1e-4)


def test_harmonics_sum_to_the_state(true_orbit: OrbitReport) -> None:
    for name, one in true_orbit.harmonics.items():
        value = one.mean + sum(term.amplitude * np.cos(term.phase) for term in one.terms)
        assert value == pytest.approx(true_orbit.state[name], abs=3e-2)


@pytest.mark.parametrize("engine", ["mujoco", "exudyn"])
def test_engine_orbit(engine: str, true_orbit: OrbitReport) -> None:
    found = mbcheck.orbit("hula_hoop", engine=engine)
    document = validated("orbit", found.as_json())
    assert document["error_bound"] is None
    assert document["period"] / document["step"] == pytest.approx(
        round(document["period"] / document["step"]), rel=1e-14
    )
    for name, value in true_orbit.state.items():
        assert found.state[name] == pytest.approx(value, abs=1e-5)
    np.testing.assert_allclose(
        [one.modulus for one in found.floquet_multipliers],
        [one.modulus for one in true_orbit.floquet_multipliers],
        atol=1e-6,
    )
    assert found.power["hinge"] == pytest.approx(true_orbit.power["hinge"], rel=1e-6)


def test_orbit_with_a_given_step() -> None:
    found = mbcheck.orbit("hula_hoop", engine="mujoco", method="Euler", step=1 / 3 / 1024)
    assert found.step == 1 / 3 / 1024


def test_difference_quotients_are_exact_to_nine_digits() -> None:
    orbit = find_orbit(SCENE, POINT)
    engine = get_engine("exudyn")
    method = next(item for item in engine.methods if item.name == "RK67")
    case = Case("hula_hoop", "orbit", POINT)
    setup = Setup(engine, case, "kinematic_tree", method)
    period_map = orbits.WholeSteps(setup, 512).period_map(orbit)
    _, slopes = period_map.linearise(np.array([0]), np.zeros((4, 1)))
    expected = orbit.monodromy * period_map.scale.T / period_map.scale - np.eye(4)
    assert np.max(np.abs(slopes[0] - expected)) < 1e-9


@pytest.mark.slow  # that of the command line is not
@pytest.mark.parametrize("engine", ["reference", "mujoco"])
def test_no_orbit(engine: str) -> None:
    with pytest.raises(NoOrbitError, match="no periodic orbit"):
        mbcheck.orbit("hula_hoop", parameters={"force_amplitude": 0.5}, engine=engine)


def test_newton_that_does_not_converge_is_no_orbit() -> None:
    engine = get_engine("mujoco")
    euler = next(item for item in engine.methods if item.name == "Euler")
    setup = Setup(engine, Case("hula_hoop", "orbit", POINT), "tree", euler, step=1 / 3 / 256)
    with pytest.raises(NoOrbitError, match="mujoco Euler has no periodic orbit"):
        orbits.find_engine_orbit(setup, Effort(jacobians=1))


def test_an_orbit_of_too_many_steps_is_refused_before_it_is_sought() -> None:
    period = 1 / POINT.force_frequency
    with within(30.0), pytest.raises(UsageError, match=r"would take about .*budget is 30 s"):
        mbcheck.orbit("hula_hoop", engine="mujoco", method="RK4", step=period / 2**30)

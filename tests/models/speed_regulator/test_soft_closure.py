"""The equations that a soft closure really has, and MuJoCo's integrators on them."""

from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.faults.mujoco import MujocoAdapter
from mbcheck.comparisons.queries.simulate import simulate
from mbcheck.models.speed_regulator import mjcf
from mbcheck.models.speed_regulator.mjcf import HARD_SOLIMP, HARD_SOLREF, MODELS, closed_by
from mbcheck.reference.errors import EngineError, NoOrbitError
from mbcheck.reference.scene import Array, EquationsOfMotion
from mbcheck.reference.soft_constraint import SOLIMP, SOLREF
from mbcheck.reference.solve.schemes import TABLEAUS, ScalarEquations, explicit_runge_kutta
from mbcheck.reference.speed_regulator import SCENE
from mbcheck.reference.speed_regulator.equations import SpeedRegulator
from mbcheck.reference.speed_regulator.soft import (
    COORDINATES,
    coefficients,
    soft_scene,
)
from mbcheck.tests.support.mjcf.crank import (
    CLOSURES,
    DEFAULT,
    OTHER,
    accelerations,
    claimed,
    closed_state,
    compiled,
    final,
    predicted,
    samples,
    truth,
)

ROTATING = {"phi": 0.0, "phi_dot": 5.07}


FINE = 2.0**-10


def acceleration_error(
    model: Any, scene: EquationsOfMotion, p: SpeedRegulator, states: Array
) -> float:
    truth = predicted(scene, p, states)
    return float(np.max(np.abs(accelerations(model, states) - truth)) / np.max(np.abs(truth)))


def exact_final(p: SpeedRegulator, span: float) -> Array:
    phi, speed = truth(SCENE, p, (ROTATING["phi"], ROTATING["phi_dot"]), span)
    return closed_state(p, {"phi": phi, "phi_dot": speed})


# --- The equations of a soft closure


@pytest.mark.parametrize("p", [DEFAULT, OTHER])
def test_inverse_weights_are_mujocos(p: SpeedRegulator) -> None:
    model = compiled(MODELS["connect"], p)
    weights = sum(model.body(name).invweight0[0] for name in ("rod", "slider"))
    assert coefficients(p).inverse_weight == pytest.approx(weights, rel=1e-13)


@pytest.mark.parametrize(
    ("solref", "solimp"),
    [
        ((0.05, 0.7), (0.5, 0.99, 0.01, 0.3, 3.0)),
        ((-900.0, -40.0), (0.3, 0.8, 0.002, 0.6, 1.0)),
        ((0.02, 1.0), (0.0, 1.0, 0.001, 0.5, 2.0)),
    ],
)
def test_other_softness_is_understood(
    solref: tuple[float, float], solimp: tuple[float, ...]
) -> None:
    model = compiled(closed_by(solref, solimp), DEFAULT)
    scene = soft_scene(solref, solimp)
    assert acceleration_error(model, scene, DEFAULT, samples(DEFAULT, 1e-3)) < 1e-10


@pytest.mark.parametrize("name", CLOSURES)
def test_the_claim_is_consistent(name: str) -> None:
    """Forces through the mass matrix are accelerations, powers add up to the energy's rate."""
    scene, c = claimed(name, OTHER), coefficients(OTHER)
    probe = 1e-40
    for state in samples(OTHER, 3e-4, 10):
        q, v = np.split(state, 2)
        a = predicted(scene, OTHER, state[None])[0]
        solved = np.linalg.solve(scene.mass_matrix(q, c), scene.forces(0.0, q, v, c))
        np.testing.assert_allclose(solved, a, rtol=1e-11, atol=1e-10)
        rate = scene.energy(q + 1j * probe * v, v + 1j * probe * a, c).imag / probe
        powers = scene.powers(0.0, q, v, c)
        scale = sum(abs(power) for power in powers.values())
        assert rate == pytest.approx(sum(powers.values()), abs=1e-11 * scale)


@pytest.mark.parametrize("name", CLOSURES)
def test_equilibria_of_the_claim_are_at_rest_in_mujoco(name: str) -> None:
    scene, model = claimed(name), compiled(MODELS[name], DEFAULT)
    for about, equilibrium in scene.equilibria.items():
        values = equilibrium(DEFAULT)
        state = np.array([values[key] for key in COORDINATES] + [0.0] * 3)
        assert np.max(np.abs(accelerations(model, state[None]))) < 1e-8
        assert values["phi"] == pytest.approx(SCENE.equilibria[about](DEFAULT)["phi"], abs=1e-3)
    with pytest.raises(NoOrbitError):
        scene.equilibria["right"](DEFAULT.replace(torque=100.0))


# --- MuJoCo's integrators on it


def runge_kutta(
    scene: EquationsOfMotion, p: SpeedRegulator, state: Array, step: float, span: float
) -> Array:
    equations = ScalarEquations(scene, p, clock=False)
    advance = explicit_runge_kutta(equations, TABLEAUS["RK44"])
    x = equations.start(state, 0.0)
    for _ in range(round(span / step)):
        x = advance(0.0, x, step)
    return np.array(x)


def test_a_positive_time_constant_is_silently_raised_to_two_steps() -> None:
    step, start = 2.0**-6, closed_state(DEFAULT, ROTATING)
    found = final(compiled(MODELS["connect"], DEFAULT), start, step, 0.5)
    raised = soft_scene((2 * step, 1.0), SOLIMP)
    expected = runge_kutta(raised, DEFAULT, start, step, 0.5)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)
    assert np.max(np.abs(found - runge_kutta(soft_scene(), DEFAULT, start, step, 0.5))) > 1e-4


def test_a_step_at_which_mujoco_softens_the_closure_is_refused() -> None:
    """By `refsafe`: a positive time constant of the closure must be two steps at least."""
    for model in (None, "connect"):
        with pytest.raises(EngineError, match="refsafe") as caught:
            simulate("speed_regulator", engine="mujoco", model=model, step=0.02, times=[0.2])
        assert caught.value.kind == "step"
    at_most = SOLREF[0] / 2
    simulate("speed_regulator", engine="mujoco", step=at_most, times=[0.2])
    # a closure that is given by stiffness and damping stays what it is
    hard = MODELS["connect_hard"]
    assert hard.longest_step == MODELS["transmission"].longest_step == np.inf
    step, start = 2.0**-10, closed_state(DEFAULT, ROTATING)
    found = final(compiled(hard, DEFAULT), start, step, 0.125)
    expected = runge_kutta(claimed("connect_hard"), DEFAULT, start, step, 0.125)
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-10)


def test_checks_take_shorter_steps_than_that() -> None:
    engine = MujocoAdapter()
    for case in SCENE.cases:
        for model in CLOSURES:
            for method in engine.methods:
                if engine.bind(case, model).unsupported_reason(case, method) is None:
                    step = Setup(engine, case, model, method).default_step
                    assert step <= SOLREF[0] / 2


# --- Model error and integration error


def test_the_default_closure_errs_by_the_same_at_any_step() -> None:
    start, exact = closed_state(DEFAULT, ROTATING), exact_final(DEFAULT, 1.0)
    model_error = truth(claimed("connect"), DEFAULT, tuple(start), 1.0) - exact
    assert abs(model_error[0]) == pytest.approx(2.0e-4, rel=0.05)
    model = compiled(MODELS["connect"], DEFAULT)
    integration_errors = []
    for step in (2.0**-8, 2.0**-9, 2.0**-10):
        error = final(model, start, step, 1.0) - exact
        integration_errors.append(np.max(np.abs(error - model_error)))
        np.testing.assert_allclose(error, model_error, atol=1e-2 * np.max(np.abs(model_error)))
    assert np.log2(integration_errors[0] / integration_errors[-1]) / 2 == pytest.approx(4, abs=0.3)


def speed_error(solref: tuple[float, float], step: float) -> float:
    """Return the error of phi_dot after 1 s, RK4, against the closed loop."""
    model = compiled(closed_by(solref, HARD_SOLIMP), DEFAULT)
    error = final(model, closed_state(DEFAULT, ROTATING), step, 1.0) - exact_final(DEFAULT, 1.0)
    return float(abs(error[3]))


def test_the_hard_closure_is_five_orders_better() -> None:
    start, exact = closed_state(DEFAULT, ROTATING), exact_final(DEFAULT, 1.0)
    found = final(compiled(MODELS["connect_hard"], DEFAULT), start, 2.0**-13, 1.0)
    error = np.abs(found - exact)
    assert 5e-10 < error[0] < 5e-9
    assert np.max(error[[0, 2, 3]]) < 5e-9


def test_a_harder_closure_loses_more_than_it_gains() -> None:
    harder = (4 * HARD_SOLREF[0], 2 * HARD_SOLREF[1])
    for step in (2.0**-10, 2.0**-11):
        assert speed_error(harder, step) > 4 * speed_error(HARD_SOLREF, step)


def test_the_hard_closure_is_the_hardest_for_all_integrators() -> None:
    start = closed_state(DEFAULT, ROTATING)
    harder = closed_by((4 * HARD_SOLREF[0], 2 * HARD_SOLREF[1]), HARD_SOLIMP)
    for integrator in ("Euler", "implicit", "implicitfast"):
        sound = final(compiled(MODELS["connect_hard"], DEFAULT), start, FINE, 1.0, integrator)
        np.testing.assert_allclose(sound, exact_final(DEFAULT, 1.0), atol=1e-2)
        wild = final(compiled(harder, DEFAULT), start, FINE, 1.0, integrator)
        assert not np.all(np.isfinite(wild))


def test_the_loop_stays_on_its_branch() -> None:
    p = OTHER  # cos b down to 0.6
    for name in CLOSURES:
        state = closed_state(p, ROTATING)
        model = compiled(MODELS[name], p)
        for _ in range(8):
            state = final(model, state, FINE, 0.25)
            values = dict(zip(soft_scene().state_names, state, strict=True))
            assert SCENE.assembled is not None
            assert SCENE.assembled(values, p)
            exact = SCENE.observe(state[[0, 3]], p)
            assert values["y"] == pytest.approx(exact["y"], abs=1e-2)


def test_hard_softness_is_what_the_file_says() -> None:
    text = mjcf.MODELS["connect"].path.read_text(encoding="utf-8")
    numbers = " ".join(f"{value:g}" for value in HARD_SOLIMP)
    assert f'solref="{HARD_SOLREF[0]:.0f} {HARD_SOLREF[1]:.0f}" solimp="{numbers}"' in text

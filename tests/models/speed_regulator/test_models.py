"""The engine models of speed_regulator: files, the transmission, and Exudyn's."""

import mujoco
import numpy as np
import pytest

from mbcheck.comparisons.engines.exudyn.engine import (
    IMPLICIT,
    Probe,
    integrate_samples,
    place_initial,
    quiet,
)
from mbcheck.comparisons.faults.exudyn import ExudynAdapter
from mbcheck.models.mjcf import export
from mbcheck.models.speed_regulator import exudyn_model
from mbcheck.models.speed_regulator.mjcf import MODELS
from mbcheck.reference.scene import Array
from mbcheck.reference.solve.single import solve
from mbcheck.reference.speed_regulator import SCENE
from mbcheck.reference.speed_regulator.equations import SpeedRegulator
from mbcheck.reference.speed_regulator.equations import coefficients as exact_coefficients
from mbcheck.reference.speed_regulator.soft import (
    COORDINATES,
    embedding,
)
from mbcheck.tests.support.mjcf.crank import (
    CLOSURES,
    DEFAULT,
    MASSLESS,
    OTHER,
    compiled,
    final,
    predicted,
    samples,
    truth,
)

ENGINE = ExudynAdapter()


EXUDYN = exudyn_model.MODELS


# --- MJCF files


def test_the_hard_closure_changes_only_the_closure() -> None:
    soft, hard = (export(MODELS[name], DEFAULT).splitlines() for name in CLOSURES)
    changed = [line for line, other in zip(soft, hard, strict=True) if line != other]
    assert len(changed) == 1
    assert "<connect" in changed[0]


@pytest.mark.parametrize("p", [DEFAULT, OTHER])
@pytest.mark.parametrize("name", CLOSURES)
def test_as_opened_the_loop_is_closed_and_joints_mean_what_they_say(
    name: str, p: SpeedRegulator
) -> None:
    model = compiled(MODELS[name], p)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.efc_pos, 0.0, atol=1e-15)
    motion = MODELS[name].joints(p, 0.0, {"phi": 0.0, "phi_dot": 0.0})
    assert [model.joint(i).name for i in range(model.njnt)] == list(motion) == list(COORDINATES)
    np.testing.assert_allclose(data.qpos, [q for q, _ in motion.values()], rtol=0, atol=1e-15)
    observed = SCENE.observe(np.zeros(2), p)
    assert data.sensor("y").data[0] == pytest.approx(observed["y"], rel=1e-14)


def test_joints_of_a_state_that_says_more_are_left_open() -> None:
    state = {"phi": 0.3, "y": -1.0, "phi_dot": 1.0, "y_dot": 0.5}
    motion = MODELS["connect"].joints(DEFAULT, 0.0, state)
    closed = embedding(DEFAULT, {"phi": 0.3, "phi_dot": 1.0})
    assert motion["y"] == (-1.0, 0.5)
    assert motion["pin_angle"] == (closed["pin_angle"], closed["pin_angle_dot"])


def test_models_say_what_they_cannot_stand_for() -> None:
    for name in CLOSURES:
        assert MODELS[name].unsupported_reason(DEFAULT) is None
        assert "rod_mass and slider_mass 0" in str(MODELS[name].unsupported_reason(MASSLESS))
    assert MODELS["transmission"].unsupported_reason(MASSLESS) is None
    assert "must be 0, not 0.5 and 1 kg" in str(MODELS["transmission"].unsupported_reason(DEFAULT))


# --- The transmission


def test_the_transmission_is_exact() -> None:
    model = compiled(MODELS["transmission"], MASSLESS)
    data = mujoco.MjData(model)
    for state in samples(MASSLESS)[:, [0, 3]]:
        data.qpos[:], data.qvel[:] = np.split(state, 2)
        mujoco.mj_forward(model, data)
        expected = SCENE.observe(state, MASSLESS)
        acceleration = predicted(SCENE, MASSLESS, state[None])[0]
        np.testing.assert_allclose(data.qacc, acceleration, rtol=1e-12, atol=1e-12)
        for name in ("phi", "phi_dot", "y", "y_dot"):
            assert data.sensor(name).data[0] == pytest.approx(expected[name], rel=1e-13, abs=1e-13)


def test_the_transmission_keeps_the_order_of_rk4() -> None:
    p, start = DEFAULT.replace(rod_mass=0.0, slider_mass=0.0), (0.0, 5.07)
    model = compiled(MODELS["transmission"], p)
    coarse, fine = (
        np.max(np.abs(final(model, np.array(start), h, 1.0) - truth(SCENE, p, start, 1.0)))
        for h in (2.0**-5, 2.0**-6)
    )
    assert np.log2(coarse / fine) == pytest.approx(4, abs=0.3)


# --- Exudyn


def test_exudyn_models_are_the_loop_first() -> None:
    assert {name: model.constrained for name, model in EXUDYN.items()} == {
        "redundant": True,
        "one_dof": False,
    }
    assert next(iter(EXUDYN)) == "redundant"


def exudyn_accelerations(name: str, p: SpeedRegulator, states: Array) -> Array:
    with quiet(ENGINE.inner.exudyn):
        system = EXUDYN[name].build(p, "")
        probe = Probe(ENGINE.inner.exudyn, system, ENGINE.inner.settings(IMPLICIT[0], 0.0, 1.0))
        found = np.array([system.readout @ probe.motion(0.0, state)[0] for state in states])
        system.container.Reset()
    return found


@pytest.mark.parametrize("p", [DEFAULT, OTHER, MASSLESS], ids=["default", "other", "massless"])
@pytest.mark.parametrize("name", EXUDYN)
def test_exudyns_accelerations_are_right(name: str, p: SpeedRegulator) -> None:
    states = samples(p)[:, [0, 3]]
    truths = predicted(SCENE, p, states)
    found = exudyn_accelerations(name, p, states)
    np.testing.assert_allclose(found, truths, rtol=1e-10, atol=1e-11 * np.max(np.abs(truths)))


def exudyn_run(name: str, p: SpeedRegulator, method: str, step: float, times: Array) -> Array:
    """Return phi, phi_dot, y, y_dot (4, k), and check that the joints are closed."""
    chosen = next(item for item in ENGINE.methods if item.name == method)
    with quiet(ENGINE.inner.exudyn):
        system = EXUDYN[name].build(p, "")
        place_initial(ENGINE.inner.exudyn, system, np.array([0.0, 5.07]))
        settings, solver = ENGINE.inner.settings(chosen, 0.0, step), ENGINE.inner.solver(chosen)
        solver.InitializeSolver(system.mbs, settings)
        solver.it.maxStepSize = step
        try:
            coordinates, rates, *_ = integrate_samples(system.mbs, solver, settings, step, times)
        finally:
            solver.FinalizeSolver(system.mbs, settings)
        outputs = system.outputs(coordinates.T, rates.T)
        states = [system.readout @ coordinates.T, system.readout @ rates.T]
        system.container.Reset()
    return np.vstack([*states, outputs["y"], outputs["y_dot"]])


@pytest.mark.parametrize("p", [DEFAULT, OTHER], ids=["default", "other"])
@pytest.mark.parametrize(
    ("name", "method", "order", "step"),
    [
        ("redundant", "GeneralizedAlpha", 2, 2.0**-8),
        ("redundant", "TrapezoidalIndex2", 2, 2.0**-8),
        ("one_dof", "TrapezoidalIndex2", 2, 2.0**-8),
        ("one_dof", "RK44", 4, 2.0**-6),
    ],
)
def test_exudyns_errors_shrink_at_the_declared_order_on_the_right_branch(
    name: str, method: str, order: int, step: float, p: SpeedRegulator
) -> None:
    times = np.array([0.5, 1.0])
    states = solve(SCENE, p, np.array([0.0, 5.07]), times).states
    observed = SCENE.observe(states, p)
    exact = np.array([observed[key] for key in ("phi", "phi_dot", "y", "y_dot")])
    coarse, fine = (
        np.max(np.abs(exudyn_run(name, p, method, h, times) - exact)) for h in (step, step / 2)
    )
    assert fine < 1e-3
    assert np.log2(coarse / fine) == pytest.approx(order, abs=0.4)


def test_exudyn_places_the_loop_closed_and_tells_where_it_opens() -> None:
    system = EXUDYN["redundant"].build(OTHER, "")
    for phi, speed in samples(OTHER, count=10)[:, [0, 3]]:
        coordinates, rates = system.place(np.array([phi]), np.array([speed]))
        coordinates, rates = coordinates[:, None], rates[:, None]
        outputs = system.outputs(coordinates, rates)
        exact = SCENE.observe(np.array([phi, speed]), OTHER)
        assert outputs["y"][0] == pytest.approx(exact["y"], rel=1e-13)
        assert outputs["y_dot"][0] == pytest.approx(exact["y_dot"], rel=1e-12)
        engine = ENGINE.inner
        probe = Probe(engine.exudyn, system, engine.settings(IMPLICIT[1], 0.0, 1.0))
        closed = probe.violations(np.zeros(1), coordinates.T, rates.T)
        assert closed[0, 0] < 1e-15
        assert closed[1, 0] < 1e-14
        moved = coordinates + 1e-3 * np.eye(7)[:, 6:7]
        opened = probe.violations(np.zeros(1), moved.T, rates.T)
        assert opened[0, 0] == pytest.approx(1e-3)
    system.container.Reset()


def test_mass_of_one_dof_is_the_scenes() -> None:
    with quiet(ENGINE.inner.exudyn):
        system = EXUDYN["one_dof"].build(OTHER, "")
        probe = Probe(ENGINE.inner.exudyn, system, ENGINE.inner.settings(IMPLICIT[0], 0.0, 1.0))
        for phi in (0.0, 0.7, 2.5):
            probe.place(0.0, np.array([phi]), np.zeros(1))
            expected = SCENE.mass_matrix([phi], exact_coefficients(OTHER))
            np.testing.assert_allclose(probe.mass(), expected, rtol=1e-13)
        system.container.Reset()

"""The engine models of rotor_pendulum: both engines' equations are the reference's."""

from functools import lru_cache
from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbcheck.comparisons.engines.setup import Setup, run
from mbcheck.comparisons.faults.exudyn import ExudynAdapter
from mbcheck.models.mjcf import export
from mbcheck.models.rotor_pendulum import exudyn_model
from mbcheck.models.rotor_pendulum.mjcf import INERTIA_FLOOR, MODELS
from mbcheck.reference.rotor_pendulum import SCENE
from mbcheck.reference.rotor_pendulum.equations import (
    RotorPendulum,
    coefficients,
    damping_matrix,
    forces,
    mass_matrix,
    unforced,
)
from mbcheck.reference.scene import Array, Case

TREE = MODELS["tree"]
TABLE_1 = RotorPendulum()
OTHER = RotorPendulum(
    platform_mass=30.0,
    rotor_mass=3.0,
    rod_mass=5.0,
    eccentricity=0.08,
    rod_length=0.4,
    platform_stiffness=1e5,
    platform_damping=300.0,
    rod_stiffness=7e3,
    rod_damping=6.0,
    installation_angle=2.0,
    motor_slope=0.5,
    synchronous_speed=80.0,
    friction=0.1,
)
POINTS = {
    "table_1": TABLE_1,
    "table_1_relative": TABLE_1.replace(motor_placement="relative"),
    "other": OTHER,
    "other_relative": OTHER.replace(motor_placement="relative"),
    "unforced": unforced(OTHER),
}
SCALE = np.array([1e-3, 1.0, 1.0, 0.1, 0.1, 100.0, 100.0, 10.0])
"""Of the states (x, phi_1, phi_2, phi_3 and their rates)."""

every_point = pytest.mark.parametrize("p", POINTS.values(), ids=POINTS)


def a_case(p: RotorPendulum, **state: float) -> Case:
    return Case("rotor_pendulum", "test", p, state, 0.125)


@lru_cache
def exact(p: RotorPendulum, start: tuple[float, ...], span: float) -> Array:
    """Return the final state, by an independent solver."""
    solved = solve_ivp(
        SCENE.right_hand_side(p), (0, span), start, method="DOP853", rtol=1e-13, atol=1e-15
    )
    final: Array = solved.y[:, -1]
    return final


def opened(p: RotorPendulum, step: float | None = None) -> tuple[Any, Any]:
    """Return MuJoCo's model and data as a viewer opens the exported file."""
    model = mujoco.MjModel.from_xml_string(export(TREE, p))
    if step is not None:
        model.opt.timestep = step
    return model, mujoco.MjData(model)


def states() -> Array:
    """Return random states (20, 8)."""
    return np.random.default_rng(3).normal(size=(20, 8)) * SCALE


def distance(found: Array, p: RotorPendulum, state: Array) -> float:
    """Return the largest relative error of accelerations (4,), each on its own scale."""
    expected = np.array(SCENE.accelerations(0.0, *np.split(state, 2), coefficients(p)))
    return float(np.max(abs(found - expected) / (1.0 + abs(expected))))


def place(model: Any, data: Any, p: RotorPendulum, state: Array) -> None:
    values = dict(zip(SCENE.state_names, map(float, state), strict=True))
    for name, (position, velocity) in TREE.joints(p, 0.0, values).items():
        joint = model.joint(name)
        data.qpos[joint.qposadr], data.qvel[joint.dofadr] = position, velocity


def sensed(model: Any, data: Any) -> Array:
    """Return the scene's state as the model's sensors tell it."""
    mujoco.mj_forward(model, data)
    return np.array([data.sensor(name).data[0] for name in SCENE.state_names])


# --- MJCF


def test_file_opens_at_rest_with_nothing_superfluous() -> None:
    model, data = opened(TABLE_1)
    mujoco.mj_resetDataKeyframe(model, data, model.key("rest").id)
    assert not data.qpos.any()
    assert not model.qpos0.any()
    assert not sensed(model, data).any()
    assert data.xpos[model.body("rotor_2").id] == pytest.approx(
        [0.3 * np.cos(np.pi / 6), 0.3 * np.sin(np.pi / 6), 0], abs=1e-15
    )
    assert (model.nbody, model.njnt, model.ngeom, model.nsite, model.neq) == (5, 4, 4, 0, 0)
    assert model.nsensor == len(SCENE.state_names)
    assert model.body(0).subtreemass[0] == 114
    actuated = {model.actuator(name).trnid[0] for name in ("motor_1", "motor_2")}
    assert actuated == {model.joint("phi_1").id, model.tendon("phi_2").id}


def test_points_have_an_inertia_that_no_check_sees_or_the_model_is_refused() -> None:
    assert INERTIA_FLOOR / (TABLE_1.rotor_mass * TABLE_1.eccentricity**2) < 1e-12
    assert TREE.unsupported_reason(TABLE_1) is None
    tiny = TABLE_1.replace(eccentricity=1e-3)
    assert "no point masses" in str(TREE.unsupported_reason(tiny))


@pytest.mark.parametrize("placement", ["absolute", "relative"])
def test_reaction_of_the_motor(placement: str) -> None:
    """Blocked at rest: the rod bears the torque of a motor that stands on it, or nothing."""
    p = TABLE_1.replace(motor_placement=placement)
    model, data = opened(p)
    mujoco.mj_forward(model, data)
    torque = p.motor_slope * p.synchronous_speed
    on_rotor = data.qfrc_actuator[model.joint("theta_2").dofadr[0]]
    on_both = data.qfrc_actuator[model.joint("phi_3").dofadr[0]]
    assert on_rotor == pytest.approx(torque, rel=1e-15)
    assert on_both == pytest.approx(torque if placement == "absolute" else 0, abs=1e-12)


@every_point
def test_exported_file_starts_up_right_in_a_plain_loop(p: RotorPendulum) -> None:
    """As a viewer does it: load the file, step, nothing else."""
    model, data = opened(p)
    for _ in range(1638):
        mujoco.mj_step(model, data)
    truth = exact(p, (0.0,) * 8, 1638 * 2.0**-13)
    assert np.max(abs(sensed(model, data) - truth) / SCALE) < 1e-4
    assert np.max(abs(sensed(model, data) - truth)[[1, 2, 5, 6]]) < 2e-5
    assert data.time == 1638 * 2.0**-13
    assert not data.warning.number.any()
    if p.motor_slope:
        assert truth[5] > 40
        assert truth[6] > 40


@pytest.mark.parametrize("placement", ["absolute", "relative"])
def test_rk4_sees_the_motors_at_its_stages(placement: str) -> None:
    p = OTHER.replace(motor_placement=placement)
    errors = []
    for power in (10, 11, 12):
        model, data = opened(p, 2.0**-power)
        mujoco.mj_step(model, data, nstep=2 ** (power - 2))
        truth = exact(p, (0.0,) * 8, 0.25)
        errors.append(np.max(abs(sensed(model, data) - truth) / SCALE))
    orders = -np.diff(np.log2(errors))
    assert np.all(abs(orders - 4) < 0.2), orders


@pytest.mark.parametrize("placement", ["absolute", "relative"])
@pytest.mark.parametrize("method", ["EULER", "IMPLICIT", "IMPLICITFAST", "DISCRETE"])
def test_which_forces_a_method_takes_implicitly(method: str, placement: str) -> None:
    """As the file says: ``v+ = v + h (M + h D + h^2 K)^-1 (f - h K v)``, ``q+ = q + h v+``."""
    h = 2.0**-9
    p = OTHER.replace(motor_placement=placement)
    c = coefficients(p)
    state = SCALE * [0.7, 0.3, -0.7, 0.5, 1.0, 0.3, 1.0, -2.0]
    q, v = np.split(state, 2)

    def slope(about: Array) -> Array:
        """Return -df/dv at rates (4,): central differences, exact for quadratic forces."""
        behind, ahead = (
            np.array([forces(0.0, q, about + i, c) for i in side * np.eye(4)]) for side in (-1, 1)
        )
        difference: Array = (behind - ahead).T / 2
        return difference

    damping = {
        "EULER": damping_matrix(c),
        "IMPLICIT": slope(v),
        "IMPLICITFAST": slope(np.zeros(4)),
        "DISCRETE": slope(np.zeros(4)),
    }[method]
    stiffness = np.diag([p.platform_stiffness, 0, 0, p.rod_stiffness]) * (method == "DISCRETE")
    matrix = np.array(mass_matrix(q, c)) + h * damping + h * h * stiffness
    expected = v + h * np.linalg.solve(matrix, forces(0.0, q, v, c) - h * stiffness @ v)
    model, data = opened(p, h)
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{method}")
    place(model, data, p, state)
    mujoco.mj_step(model, data)
    found = sensed(model, data)
    assert np.allclose(found[4:], expected, rtol=1e-8, atol=1e-8)
    assert np.allclose(found[:4], q + h * found[4:], rtol=1e-14, atol=1e-14)


# --- Exudyn


@every_point
@pytest.mark.parametrize("model", exudyn_model.MODELS)
def test_exudyn_accelerates_as_the_reference(model: str, p: RotorPendulum) -> None:
    chosen = states()
    times = np.zeros(len(chosen))
    found = ExudynAdapter().bind(a_case(p), model).accelerations(times, chosen)
    for acceleration, state in zip(found, chosen, strict=True):
        assert distance(acceleration, p, state) < 1e-10


@every_point
@pytest.mark.parametrize("model", exudyn_model.MODELS)
def test_exudyn_places_what_it_reads(model: str, p: RotorPendulum) -> None:
    system = exudyn_model.MODELS[model].build(p, "")
    h = 1e-6
    for state in states():
        q, v = np.split(state, 2)
        coordinates, rates = system.place(q, v)
        assert np.allclose(system.readout @ coordinates, q, rtol=0, atol=1e-13)
        assert np.allclose(system.readout @ rates, v, rtol=1e-14)
        ahead, behind = (system.place(q + side * v, v)[0] for side in (h, -h))
        assert np.allclose(rates, (ahead - behind) / (2 * h), rtol=1e-5, atol=1e-5)
    system.container.Reset()


@pytest.mark.parametrize("p", [OTHER, POINTS["other_relative"]], ids=["absolute", "relative"])
@pytest.mark.parametrize(
    ("model", "name", "power", "order"),
    [
        ("kinematic_tree", "RK44", 11, 4),
        ("kinematic_tree", "TrapezoidalIndex2", 12, 2),
        ("redundant", "GeneralizedAlpha", 12, 2),
    ],
)
def test_exudyn_runs_at_the_order_of_its_method(
    p: RotorPendulum, model: str, name: str, power: int, order: int
) -> None:
    engine = ExudynAdapter()
    method = next(item for item in engine.methods if item.name == name)
    start = dict(zip(SCENE.state_names, SCALE * [1, 0.3, -0.7, 0.2, 1, 0.1, 0.5, 0.3], strict=True))
    truth = exact(p, tuple(start.values()), 0.125)
    errors = []
    for step in (2.0**-power, 2.0 ** -(power + 1)):
        found = run(Setup(engine, a_case(p, **start), model, method, step), np.array([0.125]))
        errors.append(np.max(abs(found.matrix(SCENE.state_names)[:, -1] - truth) / SCALE))
    assert errors[1] < 1e-3
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.2)

"""The engine models of rotor_pendulum: both engines' equations are the reference's."""

from functools import lru_cache
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbcheck.comparisons.engine import run
from mbcheck.comparisons.exudyn_engine import ExudynEngine
from mbcheck.comparisons.mujoco_engine import MujocoEngine
from mbcheck.models.mjcf import bind, export
from mbcheck.models.rotor_pendulum import exudyn_model
from mbcheck.models.rotor_pendulum.mjcf import BINDINGS, INERTIA_FLOOR, MODELS
from mbcheck.reference.rotor_pendulum import (
    SCENE,
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


def test_committed_file_is_bound_to_the_defaults() -> None:
    assert export(TREE, TABLE_1) == TREE.path.read_text(encoding="utf-8")


def test_every_parameter_changes_the_file() -> None:
    default = export(TREE, TABLE_1)
    for name in RotorPendulum.names():
        value = "relative" if name == "motor_placement" else 1.5
        assert export(TREE, TABLE_1.replace(**{name: value})) != default, name


def test_every_binding_reaches_the_compiled_model() -> None:
    """Each bound attribute, set to another value alone, changes what MuJoCo compiles."""

    def compiled(text: str) -> bytes:
        model = mujoco.MjModel.from_xml_string(text)
        image = np.empty(mujoco.mj_sizeModel(model), np.uint8)
        mujoco.mj_saveModel(model, None, image)
        return image.tobytes()

    text = TREE.path.read_text(encoding="utf-8")
    default = compiled(text)
    for key, value in BINDINGS.items():
        assert compiled(bind(text, {key: value}, POINTS["other_relative"])) != default, key


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
    used = {model.actuator(name).trnid[0] for name in ("motor_2",)} | {model.tendon("phi_2").id}
    assert used | {model.tendon("theta_2").id} == set(range(model.ntendon))


def test_the_inertia_of_the_points_is_far_below_what_a_check_sees() -> None:
    share = INERTIA_FLOOR / (TABLE_1.rotor_mass * TABLE_1.eccentricity**2)
    assert share < 1e-12
    assert MujocoEngine().effective_inertia if False else True

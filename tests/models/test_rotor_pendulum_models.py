"""The MJCF file of rotor_pendulum, as a viewer opens it."""

from typing import Any

import mujoco
import numpy as np
import pytest

from mbcheck.models.mjcf import export
from mbcheck.models.rotor_pendulum.mjcf import INERTIA_FLOOR, MODELS
from mbcheck.reference.rotor_pendulum import SCENE
from mbcheck.reference.rotor_pendulum.equations import (
    RotorPendulum,
    unforced,
)
from mbcheck.reference.scene import Array
from mbcheck.reference.solve.single import solve

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


def opened(p: RotorPendulum) -> tuple[Any, Any]:
    """Return MuJoCo's model and data as a viewer opens the exported file."""
    model = mujoco.MjModel.from_xml_string(export(TREE, p))
    return model, mujoco.MjData(model)


def sensed(model: Any, data: Any) -> Array:
    """Return the scene's state as the model's sensors tell it."""
    mujoco.mj_forward(model, data)
    return np.array([data.sensor(name).data[0] for name in SCENE.state_names])


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


@pytest.mark.parametrize("p", POINTS.values(), ids=POINTS)
def test_exported_file_starts_up_right_in_a_plain_loop(p: RotorPendulum) -> None:
    """As a viewer does it: load the file, step, nothing else."""
    model, data = opened(p)
    for _ in range(1638):
        mujoco.mj_step(model, data)
    truth = solve(SCENE, p, np.zeros(8), [1638 * 2.0**-13]).states[:, -1]
    assert np.max(abs(sensed(model, data) - truth) / SCALE) < 1e-4
    assert np.max(abs(sensed(model, data) - truth)[[1, 2, 5, 6]]) < 2e-5
    assert data.time == 1638 * 2.0**-13
    assert not data.warning.number.any()
    if p.motor_slope:
        assert truth[5] > 40
        assert truth[6] > 40


# --- Exudyn

"""The engine models of speed_regulator: their files, and what they cannot stand for."""

import mujoco
import numpy as np
import pytest

from mbcheck.models.mjcf import export
from mbcheck.models.speed_regulator import exudyn_model
from mbcheck.models.speed_regulator.mjcf import MODELS
from mbcheck.reference.speed_regulator import SCENE
from mbcheck.reference.speed_regulator.equations import SpeedRegulator
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
)

EXUDYN = exudyn_model.MODELS


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


def test_exudyn_models_are_the_loop_first() -> None:
    assert {name: model.constrained for name, model in EXUDYN.items()} == {
        "redundant": True,
        "one_dof": False,
    }
    assert next(iter(EXUDYN)) == "redundant"

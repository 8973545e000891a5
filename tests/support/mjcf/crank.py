"""speed_regulator in MuJoCo and by the equations of its models."""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import mujoco
import numpy as np

from mbcheck.models.mjcf import Mjcf, export
from mbcheck.models.speed_regulator.mjcf import MODELS
from mbcheck.reference.scene import Array, EquationsOfMotion
from mbcheck.reference.solve.single import solve
from mbcheck.reference.speed_regulator.equations import SpeedRegulator
from mbcheck.reference.speed_regulator.soft import (
    embedding,
    soft_scene,
)

DEFAULT = SpeedRegulator()

OTHER = SpeedRegulator(
    crank_radius=0.4,
    rod_length=0.5,
    flywheel_inertia=0.7,
    rod_mass=0.9,
    slider_mass=0.4,
    stiffness=50.0,
    damping=1.5,
    torque=1.1,
    spring_rest=-0.45,
)

MASSLESS = OTHER.replace(rod_mass=0.0, slider_mass=0.0)

CLOSURES = ("connect", "connect_hard")


def compiled(model: Mjcf, p: SpeedRegulator) -> Any:
    return mujoco.MjModel.from_xml_string(export(model, p))


def claimed(name: str, p: SpeedRegulator = DEFAULT) -> EquationsOfMotion:
    claim = MODELS[name].equations
    assert claim is not None
    scene, parameters = claim(p)
    assert parameters is p
    return scene


def closed_state(p: SpeedRegulator, state: Mapping[str, float]) -> Array:
    return np.array([embedding(p, state)[name] for name in soft_scene().state_names], dtype=float)


def samples(p: SpeedRegulator, opened: float = 0.0, count: int = 40) -> Array:
    """Return random states (k, 6) of the tree, its loop open by about so much."""
    draw = np.random.default_rng(3)
    speeds = draw.normal(size=(count, 2)) * [3.0, 5.0]
    closed = [closed_state(p, {"phi": phi, "phi_dot": speed}) for phi, speed in speeds]
    return np.array(closed) + opened * draw.normal(size=(count, 6))


def accelerations(model: Any, states: Array) -> Array:
    data = mujoco.MjData(model)
    found = []
    for state in states:
        data.qpos[:], data.qvel[:] = np.split(state, 2)
        mujoco.mj_forward(model, data)
        found.append(data.qacc.copy())
    return np.array(found)


def predicted(scene: EquationsOfMotion, p: SpeedRegulator, states: Array) -> Array:
    q, v = np.split(states.T, 2)
    found: Array = np.array(scene.accelerations(0.0, q, v, scene.coefficients(p))).T
    return found


def final(model: Any, state: Array, step: float, span: float, integrator: str = "RK4") -> Array:
    """Return the final state, in the order of the model's joints."""
    config = mujoco.MjLogConfig.get()
    silent = mujoco.MjLogConfig.get()
    silent.logto_console = silent.logto_file = False
    silent.set()
    try:
        model.opt.timestep = step
        model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = np.split(state, 2)
        mujoco.mj_step(model, data, round(span / step))
    finally:
        config.set()
    return np.concatenate([data.qpos, data.qvel])


@lru_cache
def truth(
    scene: EquationsOfMotion, p: SpeedRegulator, state: tuple[float, ...], span: float
) -> Array:
    return solve(scene, p, np.array(state), [span]).states[:, -1]

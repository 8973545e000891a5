"""Trials: copies of a model with an edit, and short runs of them."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ....reference.scene import Array
from ..tuning import NUMERICS
from .model import Loaded, State


def edited(loaded: Loaded, change: Callable[[Any], None]) -> Loaded:
    """Return a model with an edited copy of its ``MjModel``; its text does not change."""
    model = copy.copy(loaded.model)
    change(model)
    loaded.mujoco.mj_setConst(model, loaded.mujoco.MjData(model))
    return replace(loaded, model=model)


def stays_finite(loaded: Loaded, state: State) -> bool:
    """Return True if a short run from a perturbed state neither fails nor will fail later.

    Where nothing drives the model, growth of its energy that continues would only fail later.
    """
    step, energies = short_run(loaded, state)
    driven = loaded.model.nu or loaded.model.nflex
    return step is None and bool(driven or not keeps_growing(energies))


def keeps_growing(energies: Array) -> bool:
    """Return True if a run gains energy, kinetic and total, from each quarter to the next.

    Parameters
    ----------
    energies : array (n, 2)
        Potential and kinetic energy [J] at n times; too few samples show no growth.
    """
    parts = NUMERICS.energy_parts
    if len(energies) < 2 * parts:
        return False
    total, kinetic = (
        [float(np.max(part)) for part in np.array_split(values, parts)]
        for values in (np.sum(energies, axis=1), energies[:, 1])
    )
    floor = NUMERICS.energy_roundoff * float(np.max(np.abs(energies[0])))
    gains = np.diff(total) > NUMERICS.energy_gain * max(kinetic[0], floor)
    return bool(np.all(gains) and np.all(np.diff(kinetic) > 0))


def short_run(loaded: Loaded, state: State) -> tuple[int | None, Array]:
    """Run a model from a perturbed state.

    Returns
    -------
    The step at which the run fails, if it does, and its potential and kinetic energy (n, 2) [J].
    """
    lib, model = loaded.mujoco, copy.copy(loaded.model)
    loaded.switch_off(model, "autoreset")
    data, energies = loaded.data(state, model), list[Array]()
    size = NUMERICS.perturbation
    departure = np.random.default_rng(0).uniform(-size, size, model.nv)
    lib.mj_integratePos(model, data.qpos, departure, 1.0)
    steps = min(NUMERICS.run_steps, int(NUMERICS.run_time / model.opt.timestep) + 1)
    for step in range(1, steps + 1):
        lib.mj_step(model, data)
        if loaded.lost(data):
            return step, np.array(energies)
        if (step - 1) % max(1, steps // NUMERICS.energy_samples) == 0:
            lib.mj_energyPos(model, data)
            lib.mj_energyVel(model, data)
            energies.append(data.energy.copy())
    return None, np.array(energies)


def growth(loaded: Loaded, state: State, direction: Array, step: float, horizon: float) -> float:
    """Return the growth factor of a small departure within a run from a state.

    Parameters
    ----------
    loaded : Loaded
    state : State
    direction : array (nv,)
    step, horizon : float
        Step and length of the run by RK4 [s].
    """
    lib, model, size = loaded.mujoco, loaded.sharp(), NUMERICS.perturbation
    model.opt.integrator, model.opt.timestep = lib.mjtIntegrator.mjINT_RK4, step
    runs = [loaded.data(state, model) for _ in range(2)]
    largest = float(np.max(np.abs(direction))) or 1.0
    lib.mj_integratePos(model, runs[1].qpos, size * direction / largest, 1.0)
    steps = max(10, min(NUMERICS.run_steps, int(horizon / step)))
    difference, most = np.empty(model.nv), 0.0
    for i in range(steps):
        for data in runs:
            lib.mj_step(model, data)
        if i >= steps // 2:
            lib.mj_differentiatePos(model, difference, 1.0, runs[0].qpos, runs[1].qpos)
            most = max(most, float(np.max(np.abs(difference))))
    return most / size if np.isfinite(most) else np.inf

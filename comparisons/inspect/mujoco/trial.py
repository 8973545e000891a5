"""Trials: copies of a model with an edit, and short runs of them."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ....reference.scene import Array
from .model import Loaded, State

HORIZON = 5.0
"""Seconds that a short run lasts."""

MOST_STEPS = 20_000
"""Steps that it has at most."""

SAMPLES, QUARTERS = 400, 4
"""Times at which energy is looked at in it, and parts of which each is compared with the next."""

GAIN = 0.002
"""Share of the kinetic energy by which it grows, from part to part, where it keeps growing."""

ROUNDING = 1e-12
"""Share of an energy below which another is rounding."""

TINY = 1e-6
"""Departure [rad, m] from which growth is measured; a run begins as far from its state."""


def edited(loaded: Loaded, change: Callable[[Any], None]) -> Loaded:
    """Return a model with an edit of a copy of its ``MjModel``; its text stays as it was."""
    model = copy.copy(loaded.model)
    change(model)
    loaded.mujoco.mj_setConst(model, loaded.mujoco.MjData(model))
    return replace(loaded, model=model)


def stays_finite(loaded: Loaded, state: State) -> bool:
    """Return whether a run from a state, a little disturbed, goes on as it shall for a while.

    It stays finite and, where nothing drives it, gains no energy: growth that goes on would only
    fail later.
    """
    step, energies = short_run(loaded, state)
    driven = loaded.model.nu or loaded.model.nflex
    return step is None and bool(driven or not keeps_growing(energies))


def keeps_growing(energies: Array) -> bool:
    """Return whether a run gains energy, kinetic and altogether, from each quarter to the next.

    Parameters
    ----------
    energies : array (n, 2)
        Potential and kinetic energy [J] at n times; few show nothing.
    """
    if len(energies) < 2 * QUARTERS:
        return False
    total, kinetic = (
        [float(np.max(part)) for part in np.array_split(values, QUARTERS)]
        for values in (np.sum(energies, axis=1), energies[:, 1])
    )
    floor = ROUNDING * float(np.max(np.abs(energies[0])))
    gains = np.diff(total) > GAIN * max(kinetic[0], floor)
    return bool(np.all(gains) and np.all(np.diff(kinetic) > 0))


def short_run(loaded: Loaded, state: State) -> tuple[int | None, Array]:
    """Run a model from a state, a little disturbed.

    Returns
    -------
    The step at which it fails, if it does, and its potential and kinetic energy (n, 2) [J].
    """
    lib, model = loaded.mujoco, copy.copy(loaded.model)
    model.opt.disableflags |= loaded.member("mjtDisableBit", "mjDSBL", "autoreset")
    data, energies = loaded.data(state, model), list[Array]()
    departure = np.random.default_rng(0).uniform(-TINY, TINY, model.nv)
    lib.mj_integratePos(model, data.qpos, departure, 1.0)
    steps = min(MOST_STEPS, int(HORIZON / model.opt.timestep) + 1)
    for step in range(1, steps + 1):
        lib.mj_step(model, data)
        if loaded.lost(data):
            return step, np.array(energies)
        if (step - 1) % max(1, steps // SAMPLES) == 0:
            lib.mj_energyPos(model, data)
            lib.mj_energyVel(model, data)
            energies.append(data.energy.copy())
    return None, np.array(energies)


def growth(loaded: Loaded, state: State, direction: Array, step: float, horizon: float) -> float:
    """Return by how much a small departure from the run that starts in a state grows in it.

    Parameters
    ----------
    loaded : Loaded
    state : State
    direction : array (nv,)
    step, horizon : float
        Of the run by Runge and Kutta's method [s].
    """
    lib, model = loaded.mujoco, loaded.sharp()
    model.opt.integrator, model.opt.timestep = lib.mjtIntegrator.mjINT_RK4, step
    runs = [loaded.data(state, model) for _ in range(2)]
    largest = float(np.max(np.abs(direction))) or 1.0
    lib.mj_integratePos(model, runs[1].qpos, TINY * direction / largest, 1.0)
    steps = max(10, min(MOST_STEPS, int(horizon / step)))
    difference = np.empty(model.nv)
    most = 0.0
    for i in range(steps):
        for data in runs:
            lib.mj_step(model, data)
        if i >= steps // 2:
            lib.mj_differentiatePos(model, difference, 1.0, runs[0].qpos, runs[1].qpos)
            most = max(most, float(np.max(np.abs(difference))))
    return most / TINY if np.isfinite(most) else np.inf

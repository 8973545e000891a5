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

CHUNK = 64
"""Steps after which a run is looked at where only its failing counts."""

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
    energies: list[tuple[float, float]] = []
    if failing_step(loaded, state, energies) is not None:
        return False
    return bool(loaded.model.nu or loaded.model.nflex) or not keeps_growing(np.array(energies))


def keeps_growing(energies: Array) -> bool:
    """Return whether a run gains energy, kinetic and altogether, from each quarter to the next.

    Parameters
    ----------
    energies : array (n, 2)
        Potential and kinetic energy [J] at n times; few show nothing.
    """
    if len(energies) < 2 * QUARTERS:
        return False
    total = [float(np.max(part)) for part in np.array_split(np.sum(energies, axis=1), QUARTERS)]
    kinetic = [float(np.max(part)) for part in np.array_split(energies[:, 1], QUARTERS)]
    floor = ROUNDING * float(np.max(np.abs(energies[0])))
    gains = np.diff(total) > GAIN * max(kinetic[0], floor)
    return bool(np.all(gains) and np.all(np.diff(kinetic) > 0))


def failing_step(
    loaded: Loaded, state: State, energies: list[tuple[float, float]] | None = None
) -> int | None:
    """Return the step at which a run from a state, a little disturbed, fails, if it does.

    To ``energies`` its potential and kinetic ones are added, now and then.
    """
    lib, model = loaded.mujoco, copy.copy(loaded.model)
    model.opt.disableflags |= loaded.member("mjtDisableBit", "mjDSBL", "autoreset")
    data, before = loaded.data(state, model), lib.MjData(model)
    departure = np.random.default_rng(0).uniform(-TINY, TINY, model.nv)
    lib.mj_integratePos(model, data.qpos, departure, 1.0)
    steps = min(MOST_STEPS, int(HORIZON / model.opt.timestep) + 1)
    every = CHUNK if energies is None else max(1, steps // SAMPLES)
    done = 0
    for mark in (*range(1, steps, every), steps):
        lib.mj_copyData(before, model, data)
        lib.mj_step(model, data, mark - done)
        if loaded.lost(data):
            for step in range(done, mark):
                lib.mj_step(model, before)
                if loaded.lost(before):
                    return step + 1
        done = mark
        if energies is not None and (mark - 1) % every == 0:
            lib.mj_energyPos(model, data)
            lib.mj_energyVel(model, data)
            energies.append((float(data.energy[0]), float(data.energy[1])))
    return None


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

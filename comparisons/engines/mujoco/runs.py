"""Stepping MuJoCo: one model, or many together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..protocol import Motion

Array = NDArray[np.float64]

THREADS = "MBCHECK_THREADS"
"""Environment variable: on how many threads runs go together."""


class CompiledRun(NamedTuple):
    """What is to be run.

    Attributes
    ----------
    compiled : MjModel
        With its step; runs may share one.
    positions, velocities : array (n_q,), (n_v,)
        At the start.
    start : float
        [s]
    times : array (n_t,)
        Sample times [s], multiples of the step after the start.
    stop : float or None
        Time [s] at which the actuators are switched off, on the same grid.
    """

    compiled: Any
    positions: Array
    velocities: Array
    start: float
    times: Array
    stop: float | None = None


def switch(compiled: Any, off: bool) -> None:
    """Switch all actuators (of group 0) off, or on again."""
    compiled.opt.disableactuator = int(off)


def integrate(
    mujoco: Any, compiled: Any, data: Any, times: Array, stop: float | None = None
) -> Motion:
    """Step a MuJoCo model from ``data.time`` and record it at ``times``.

    Parameters
    ----------
    mujoco : module
    compiled : MjModel
    data : MjData
        The initial state, and controls if the model has any.
    times : array (n_t,)
        Sample times [s], multiples of ``opt.timestep`` after ``data.time``.
    stop : float, optional
        Time [s] at which the actuators are switched off, on the same grid.
    """
    run = CompiledRun(compiled, data.qpos.copy(), data.qvel.copy(), data.time, times, stop)
    before = inputs(mujoco, compiled, data)
    parts = mujoco.mjtState.mjSTATE_TIME | mujoco.mjtState.mjSTATE_QPOS
    parts = int(parts | mujoco.mjtState.mjSTATE_QVEL)
    states = np.empty((len(times), mujoco.mj_stateSize(compiled, parts)))
    advance, save = mujoco.mj_step, mujoco.mj_getState
    begin = perf_counter()
    on, off = legs(times, run.start, compiled.opt.timestep, stop)
    for driven, free, row in zip(on, off, states, strict=True):
        if driven:
            advance(compiled, data, driven)
        if free:
            switch(compiled, off=True)
            advance(compiled, data, free)
        save(compiled, data, row, parts)
    seconds = perf_counter() - begin
    switch(compiled, off=False)
    return replace(recorded(mujoco, run, data, states, before), seconds=seconds)


def recorded(
    mujoco: Any, run: CompiledRun, data: Any, states: Array, before: Mapping[str, bytes]
) -> Motion:
    """Return what was recorded.

    Parameters
    ----------
    mujoco : module
    run : CompiledRun
    data : MjData
        At the end.
    states : array (n_t, 1 + n_q + n_v)
        Time, positions and velocities of the model at the samples.
    before : mapping of str to bytes
        `inputs` at the start.
    """
    clock, positions, velocities = np.split(states, [1, 1 + run.compiled.nq], axis=1)
    after = inputs(mujoco, run.compiled, data)
    steps = steps_counted(run.start, clock[:, 0], run.compiled.opt.timestep)
    return Motion(
        positions,
        velocities,
        clock[:, 0],
        steps,
        warnings(mujoco, data),
        steps * stages(mujoco, run.compiled),
        changed=tuple(name for name in before if before[name] != after[name]),
    )


def stages(mujoco: Any, compiled: Any) -> int:
    """Return how often a step evaluates the forces."""
    return 4 if compiled.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4 else 1


def legs(times: Array, start: float, step: float, stop: float | None) -> NDArray[np.int_]:
    """Return the numbers of steps up to each sample with and without the drive (2, n_t)."""
    numbers = np.rint((np.append(start, times) - start) / step).astype(int)
    driven = numbers[-1] if stop is None else max(0, round((stop - start) / step))
    on = np.diff(np.minimum(numbers, driven))
    return np.array([on, np.diff(numbers) - on])


def steps_counted(begin: float, clock: Array, step: float) -> int:
    """Return the number of steps that the engine's clock shows."""
    counts = np.rint(np.diff(clock, prepend=begin) / step)
    return int(np.sum(counts)) if np.all(np.isfinite(counts)) else -1


def warnings(mujoco: Any, data: Any) -> dict[str, int]:
    """Return MuJoCo's warning counters by name."""
    kinds = mujoco.mjtWarning.__members__
    return {
        name.removeprefix("mjWARN_"): int(data.warning[int(kind)].number)
        for name, kind in kinds.items()
        if name != "mjNWARNING"
    }


def inputs(mujoco: Any, compiled: Any, data: Any) -> Mapping[str, bytes]:
    """Return a copy of what only the caller may change."""
    image = np.empty(mujoco.mj_sizeModel(compiled), np.uint8)
    mujoco.mj_saveModel(compiled, None, image)
    arrays = {
        "opt.timestep": np.array(compiled.opt.timestep),
        "opt.integrator": np.array(compiled.opt.integrator),
        "model": image,
        "qfrc_applied": data.qfrc_applied,
        "xfrc_applied": data.xfrc_applied,
    }
    if mujoco.get_mjcb_control() is None:  # which is the caller's as well
        arrays["ctrl"] = data.ctrl
    return {name: value.tobytes() for name, value in arrays.items()}

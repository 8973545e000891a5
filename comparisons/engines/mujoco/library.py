"""The package mujoco: imported, kept from writing, and stepped."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..protocol import Motion, import_library

Array = NDArray[np.float64]

GL = "MUJOCO_GL"
"""Environment variable that MuJoCo reads as it is imported."""

CURE = "leave it unset, or install it (on Debian libosmesa6 for osmesa, libegl1 for egl)"


def import_mujoco() -> Any:
    """Return the mujoco module.

    Raises
    ------
    EngineUnavailableError
        With the reason.
    """
    return import_library("mujoco", cure)


def cure(reason: str) -> str:
    """Return the cure where MuJoCo cannot be imported, whatever the reason."""
    install = "install it with: pip install mujoco"
    if GL not in os.environ:
        return install
    return f"{GL}={os.environ[GL]} asks for an OpenGL that may not be there: {CURE}; {install}"


@contextmanager
def quiet(mujoco: Any) -> Iterator[None]:
    """Keep MuJoCo from writing to the console and to MUJOCO_LOG.TXT."""
    if not hasattr(mujoco, "MjLogConfig"):  # before 4.0: `contained` keeps the file away
        yield
        return
    saved, silent = mujoco.MjLogConfig.get(), mujoco.MjLogConfig.get()
    silent.logto_console = silent.logto_file = False
    silent.set()
    try:
        yield
    finally:
        saved.set()


@contextmanager
def controlled(mujoco: Any, controls: Callable[[float], Any] | None) -> Iterator[None]:
    """Set the controls (n_u,) as a function of time wherever MuJoCo computes forces.

    It evaluates `mjcb_control` at each stage of a step; ``data.ctrl`` alone holds over a step.
    """
    saved = mujoco.get_mjcb_control()
    hook = None if controls is None else lambda _, data: np.copyto(data.ctrl, controls(data.time))
    mujoco.set_mjcb_control(hook)
    try:
        yield
    finally:
        mujoco.set_mjcb_control(saved)


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
    start, before = data.time, inputs(mujoco, compiled, data)
    parts = mujoco.mjtState.mjSTATE_TIME | mujoco.mjtState.mjSTATE_QPOS
    parts = int(parts | mujoco.mjtState.mjSTATE_QVEL)
    states = np.empty((len(times), mujoco.mj_stateSize(compiled, parts)))
    advance, save = mujoco.mj_step, mujoco.mj_getState
    begin = perf_counter()
    on, off = legs(times, start, compiled.opt.timestep, stop)
    for driven, free, row in zip(on, off, states, strict=True):
        if driven:
            advance(compiled, data, driven)
        if free:
            switch(compiled, off=True)
            advance(compiled, data, free)
        save(compiled, data, row, parts)
    seconds = perf_counter() - begin
    switch(compiled, off=False)
    return replace(recorded(mujoco, compiled, start, data, states, before), seconds=seconds)


def recorded(
    mujoco: Any, compiled: Any, start: float, data: Any, states: Array, before: Mapping[str, bytes]
) -> Motion:
    """Return the motion of a recorded run.

    Parameters
    ----------
    mujoco : module
    compiled : MjModel
    start : float
        [s]
    data : MjData
        At the end.
    states : array (n_t, 1 + n_q + n_v)
        Time, positions and velocities of the model at the samples.
    before : mapping of str to bytes
        `inputs` at the start.
    """
    clock, positions, velocities = np.split(states, [1, 1 + compiled.nq], axis=1)
    after = inputs(mujoco, compiled, data)
    counts = np.rint(np.diff(clock[:, 0], prepend=start) / compiled.opt.timestep)
    steps = int(np.sum(counts)) if np.all(np.isfinite(counts)) else -1
    stages = 4 if compiled.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4 else 1
    return Motion(
        positions,
        velocities,
        clock[:, 0],
        steps,
        warnings(mujoco, data),
        steps * stages,
        changed_inputs=tuple(name for name in before if before[name] != after[name]),
    )


def legs(times: Array, start: float, step: float, stop: float | None) -> NDArray[np.int_]:
    """Return the numbers of steps up to each sample with and without the drive (2, n_t)."""
    numbers = np.rint((np.append(start, times) - start) / step).astype(int)
    driven = numbers[-1] if stop is None else max(0, round((stop - start) / step))
    on = np.diff(np.minimum(numbers, driven))
    return np.array([on, np.diff(numbers) - on])


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

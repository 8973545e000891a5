"""The package mujoco: imported with a reason where it cannot be, and kept from writing."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from ..protocol import import_library

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
    """Return what to do where MuJoCo cannot be imported, whatever the reason."""
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

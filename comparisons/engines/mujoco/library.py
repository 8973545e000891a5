"""The package mujoco: imported with a reason where it cannot be, and kept from writing."""

from __future__ import annotations

import importlib
import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ....reference.errors import EngineUnavailableError

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
    try:
        return importlib.import_module("mujoco")
    except Exception as error:  # a broken binary raises anything, OSError for one
        reason = (str(error).strip() or "no message").splitlines()[0]
        if GL in os.environ:
            reason += f"; {GL}={os.environ[GL]} asks for an OpenGL that may not be there: {CURE}"
        raise EngineUnavailableError(
            f"mujoco cannot be imported ({type(error).__name__}: {reason}); "
            "install it with: pip install mujoco"
        ) from error


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

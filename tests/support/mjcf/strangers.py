"""What files of strangers do to the process that inspects them."""

from __future__ import annotations

import os
import signal
import time

from mbcheck.comparisons.inspect.batch import FileReport, inspect_file
from mbcheck.comparisons.inspect.request import InspectRun

MODEL = """<mujoco><worldbody><body><joint name="{}" damping="-1"/><geom size="0.1"/></body>
  </worldbody></mujoco>"""
SCREEN = {"width": 80}


def end_in(way: str, file: str) -> FileReport:
    """Inspect a file, and end as hostile ones do before anything of it is returned."""
    found = inspect_file(InspectRun(path=file, modes=False, full=True), SCREEN)
    if file == "good.xml":
        return found
    if way == "killed":
        os.kill(os.getpid(), signal.SIGSEGV)
    elif way == "memory":
        bytearray(1 << 40)
    elif way == "raised":
        raise KeyError("a fault of mbcheck")
    else:
        time.sleep(1000)
    return found

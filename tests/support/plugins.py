"""Engines as others might plug them in: a right one, and many that do what they must not.

Each is the source of a module whose class ``Bad`` is asked for beside the right one. What it does,
and where, is data: `CONTAINED` fail for a reason that is known, `UNTRUE` would pass if they could.
"""

from __future__ import annotations

RIGHT = """
import numpy as np
import mbcheck
from mbcheck.reference import get_scene
from mbcheck.reference.solve import schemes


class Right(mbcheck.Engine):
    name, version, reads_mjcf = "right", "1", False
    methods = (mbcheck.Method("RK4", 4, "RK44"),)

    def accelerations(self, system, time, q, v):
        slopes = get_scene(system.case.scene).right_hand_side(system.case.parameters)
        return slopes(time, np.concatenate([q, v]))[len(q):]

    def simulate(self, system, method, step, times):
        scene = get_scene(system.case.scene)
        counts = np.rint((times - system.start_time) / step).astype(int)
        equations = schemes.ScalarEquations(scene, system.case.parameters)
        start = np.concatenate([system.positions, system.velocities])
        states = schemes.integrate(equations, method.scheme, start, step, counts).T
        n = len(system.joints)
        return mbcheck.Motion(states[:, :n], states[:, n:])
"""

HEAD = """
import ctypes, os, signal, stat, subprocess, sys, threading, time
import numpy as np
import mbcheck
from right import Right

class Own(BaseException): pass
class Impossible(mbcheck.Unsupported): pass
class Reduced:
    def __reduce__(self): return os._exit, (0,)
class Word(str):
    def __reduce__(self): return os._exit, (0,)
def deep(): return deep()
def fill():
    for place in range(3, 64):
        try: stat.S_ISSOCK(os.fstat(place).st_mode) and os.write(place, b"\\x7f" * 64)
        except OSError: pass
"""

PLACES = {
    "import": "{do}\nclass Bad(Right): name = '{name}'",
    "init": "class Bad(Right):\n    name = '{name}'\n    def __init__(self): {do}",
    "version": "class Bad(Right):\n    name = '{name}'\n    @property\n"
    "    def version(self): {do}; return '1'",
    "methods": "class Bad(Right):\n    name = '{name}'\n    @property\n"
    "    def methods(self): {do}; return Right.methods",
    "accelerations": "class Bad(Right):\n    name = '{name}'\n"
    "    def accelerations(self, *a): {do}; return super().accelerations(*a)",
    "simulate": "class Bad(Right):\n    name = '{name}'\n"
    "    def simulate(self, *a): {do}; return super().simulate(*a)",
}
"""Where it is done: each is a module's source, with ``do`` and ``name`` to be put in."""

ENDS = {
    "exit_0": ("os._exit(0)", "exit code 0"),
    "exit_1": ("os._exit(1)", "exit code 1"),
    "sys_exit": ("sys.exit(0)", "SystemExit"),
    "interrupt": ("exec('raise KeyboardInterrupt')", "KeyboardInterrupt"),
    "generator": ("exec('raise GeneratorExit')", "GeneratorExit"),
    "own": ("exec('raise Own(1)')", "Own"),
    "abort": ("os.abort()", "SIGABRT"),
    "segfault": ("ctypes.string_at(0)", "SIGSEGV"),
    "kill": ("os.kill(os.getpid(), 9)", "SIGKILL"),
    "term": ("os.kill(os.getpid(), 15)", "SIGTERM"),
    "recursion": ("deep()", "RecursionError"),
    "memory": ("bytearray(1 << 62)", "MemoryError"),
    "closing": ("os.closerange(3, 1024)", ""),
    "filling": ("fill()", ""),
    "hang": ("time.sleep(3600)", "it had not ended after"),
    "evil_error": ("exec('e = ValueError(1); e.args = (Reduced(),); raise e')", ""),
}
"""What is done, and a word of the reason that is told."""

"""Engines as others might plug them in: a right one, and many that do what they must not.

Each is the source of a module whose class ``Bad`` is asked for beside the right one. What it does,
and where, is data: `CONTAINED` fail for a reason that is known, `UNTRUE` would pass if they could.
"""

from __future__ import annotations

import struct

RIGHT = """
import os
import numpy as np
import mbcheck
from mbcheck.reference import get_scene
from mbcheck.reference.solve import schemes

print("printed at import")
os.system("echo printed by a child")


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

EPSILON = (
    b"\x80\x04\x88cmbcheck.comparisons.engines.setup\nSetup\nN}\x8c\x07epsilonG"
    + struct.pack(">d", 1e6)
    + b"s\x86b\x86."
)
"""A pickle that sets `Setup.epsilon` as it is read, on which all tolerances depend."""

PLACES = {
    "import": "{do}\nclass Bad(Right): name = '{name}'",
    "init": "class Bad(Right):\n    name = '{name}'\n    def __init__(self): {do}",
    "version": "class Bad(Right):\n    name = '{name}'\n    @property\n"
    "    def version(self): {do}; return '1'",
    "methods": "class Bad(Right):\n    name = '{name}'\n    @property\n"
    "    def methods(self): {do}; return Right.methods",
    "accelerations": "class Bad(Right):\n    name = '{name}'\n"
    "    def accelerations(self, *a): {do}; return super().accelerations(*a)",
    "unsupported_reason": "class Bad(Right):\n    name = '{name}'\n"
    "    def unsupported_reason(self, *a): {do}",
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

SIMULATE = "    def simulate(self, system, method, step, times):\n"
WRONG = "    def accelerations(self, *a): return 1.01 * super().accelerations(*a)\n"
MOTION = f"{SIMULATE}        m = super().simulate(system, method, step, times)\n"
ODD: dict[str, tuple[str, str, str]] = {
    "zero_max": ("np.max = np.amax = lambda *a, **k: 0.0", WRONG, "x its tolerance"),
    "no_abs": ("np.abs = np.linalg.norm = lambda *a, **k: 0.0", WRONG, "x its tolerance"),
    "judge": (
        "from mbcheck.comparisons.checks import suite, verdict\n"
        "verdict.judge = suite.judge = lambda *a: ('pass', '')",
        WRONG,
        "x its tolerance",
    ),
    "no_numpy": ("sys.modules['numpy'] = None", WRONG, ""),
    "unpickled": (
        f"from mbcheck.comparisons.engines import isolation\nsend = isolation.encoded\n"
        f"def attack(*a, **k):\n    isolation.encoded = send\n    return {EPSILON!r}\n",
        "    def accelerations(self, *a):\n        isolation.encoded = attack\n"
        "        return 1.01 * super().accelerations(*a)\n",
        "no answer",
    ),
    "evil_motion": ("", f"{SIMULATE}        return Reduced()\n", "no plain data"),
    "evil_rows": (
        "",
        f"{MOTION}        m.warnings[1] = Reduced()\n        return m\n",
        "no plain data",
    ),
    "evil_values": (
        "",
        f"{SIMULATE}        return mbcheck.Motion([[Reduced()]], [[Reduced()]])\n",
        "no plain data",
    ),
    "function": ("", f"{SIMULATE}        return lambda: 0\n", "cannot be sent"),
    "generator": ("", f"{SIMULATE}        return (i for i in times)\n", "cannot be sent"),
    "own_unsupported": ("", f"{SIMULATE}        raise Impossible('not today')\n", "not today"),
    "own_version": (
        "class Number:\n    def __repr__(self): return str(os._exit(0))",
        "    version = Number()\n",
        "exit code 0",
    ),
    "nan": ("", f"{MOTION}        m.positions[-1] = np.nan\n        return m\n", "nan"),
    "short": (
        "",
        f"{MOTION}        return mbcheck.Motion(m.positions[1:], m.velocities[1:])\n",
        "has shape",
    ),
    "text": ("", f"{SIMULATE}        return mbcheck.Motion('x', 'y')\n", "must be real numbers"),
    "nothing": ("", f"{SIMULATE}        return None\n", "must return a Motion"),
    "complex": (
        "",
        f"{MOTION}        return mbcheck.Motion(m.positions + 0j, m.velocities)\n",
        "no plain data",
    ),
    "huge": ("", f"{SIMULATE}        return np.zeros((1 << 40, 8))\n", "Unable to"),
    "deep_list": (
        "",
        f"{SIMULATE}        x = []\n        for _ in range(10**5): x = [x]\n        return x\n",
        "cannot be sent",
    ),
    "own_words": (
        "",
        f"{SIMULATE}        return mbcheck.Motion([['1']], [['1']])\n",
        "real numbers",
    ),
    "reason_5": ("", "    def unsupported_reason(self, *a): return 5\n", "must return a reason"),
    "reason_usage": (
        "",
        "    def unsupported_reason(self, *a): raise mbcheck.UsageError('not so')\n",
        "unsupported_reason: not so",
    ),
    "reason_later": (
        "",
        "    asked = 0\n    def unsupported_reason(self, *a):\n        Bad.asked += 1\n"
        "        return 5 if Bad.asked > 3 else None\n",
        "must return a reason",
    ),
    "server": (
        "",
        "    def unsupported_reason(self, *a): os.kill(os.getppid(), 9)\n",
        "exit code 255",
    ),
    "models_5": ("", "    def models(self, *a): return 5\n", "a tuple of names"),
    "models_nul": ("", "    def models(self, *a): return ('a\\0',)\n", "calls a model"),
    "models_many": (
        "",
        "    def models(self, *a): return [f'm{i}' for i in range(10**6)]\n",
        "100",
    ),
    "own_model_5": (
        "",
        "    def describe_model(self, *a): return 5\n",
        "must return an ModelDescription",
    ),
    "no_version": ("", "    version = None\n", "version must be text"),
    "long_version": ("", "    version = 'x' * 10**8\n", "version must be text"),
    "nul": ("", "    methods = (mbcheck.Method('R\\0', 1),)\n", "calls a method"),
    "nan_value": ("", "    max_value = float('nan')\n", "must be a number"),
    "thousands": (
        "",
        "    methods = tuple(mbcheck.Method(f'm{i}', 4) for i in range(3000))\n",
        "methods must be a tuple of mbcheck.Method, of 100 at most",
    ),
    "own_group": ("", f"{SIMULATE}        os.killpg(0, 9)\n", "SIGKILL"),
    "stopped": ("", f"{SIMULATE}        os.kill(os.getpid(), signal.SIGSTOP)\n", "not ended"),
    "floats": ("np.seterr(all='raise')", f"{SIMULATE}        return np.array(1.0) / 0\n", "Float"),
}
"""Code of the module, code of the class, and a word of the reason for which it fails."""

HARMLESS: dict[str, tuple[str, str]] = {
    "views": (
        "",
        "    kept = np.zeros(2)\n    def accelerations(self, *a):\n"
        "        self.kept[:] = super().accelerations(*a)\n        return self.kept\n",
    ),
    "prints": ("os.write(1, b'{' * 999); print('x' * 999)", ""),
    "prints_in_a_call": ("", f"{SIMULATE}        os.write(1, b'x' * 999)\n"
                         "        return super().simulate(system, method, step, times)\n"),
    "word": ("", "    version = Word('1')\n"),
    "emptied": (
        "import shutil, tempfile\nassert tempfile.gettempdir().endswith('emptied')\n"
        "for one in os.scandir(tempfile.gettempdir()): shutil.rmtree(one)",
        "",
    ),
    "child": ("subprocess.Popen(['sleep', '600'])", ""),
    "thread": ("threading.Thread(target=time.sleep, args=(600,)).start()", ""),
    "leaving": ("import atexit; atexit.register(os._exit, 0)", ""),
    "moved": ("os.chdir('/')", ""),
    "poor": ("os.environ.clear()", ""),
    "silent": ("sys.stdout = sys.stderr = None", ""),
    "deaf": ("signal.signal(signal.SIGTERM, signal.SIG_IGN)", ""),
    "writes_over": ("", f"{SIMULATE}        t = times.copy(); times[:] = 0\n"
                    "        return super().simulate(system, method, step, t)\n"),
}  # fmt: skip
"""Code of the module and of the class of engines that are right and behave oddly."""


def sources() -> dict[str, tuple[str, str]]:
    """Return the source of each hostile module by name, and a word of its reason; "" of none."""
    table = {
        f"{place}_{end}": (HEAD + text.format(do=do, name=f"{place}_{end}"), word)
        for place, text in PLACES.items()
        for end, (do, word) in ENDS.items()
        if not (end == "hang" and place not in ("accelerations", "simulate"))
    }
    for name, (module, body, word) in ODD.items():
        table[name] = (f"{HEAD}{module}\nclass Bad(Right):\n    name = '{name}'\n{body}", word)
    return table


def harmless() -> dict[str, str]:
    """Return the source of each module that is to pass, by name."""
    return {
        name: f"{HEAD}{module}\nclass Bad(Right):\n    name = '{name}'\n{body}"
        for name, (module, body) in HARMLESS.items()
    }

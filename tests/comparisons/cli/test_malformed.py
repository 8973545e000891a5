"""Calls that make no sense, generated for every option of every verb: each is refused in one line.

The options are those of the program itself, so that a new one is tried as soon as there is one.
"""

from __future__ import annotations

import random
import resource
import subprocess
import sys
from pathlib import Path
from time import process_time

import click
import pytest

from mbcheck.comparisons.cli.group import VERBS, program
from mbcheck.comparisons.terminal.options import Number
from mbcheck.tests.support.command import MAIN, invoke

LONG, MIRROR = "x" * 5000, "\u202ereverse"
NOT_NUMBERS = (
    "",
    "x",
    "1_0",
    "\uff11",
    "\u0663",
    "0x10",
    "1,5",
    "1e",
    "--",
    "nan",
    "1e999",
    "-1",
    LONG,
)
NOT_COUNTS = (*NOT_NUMBERS, "1.5", "1e3", "9" * 30, "-5")
NOT_NAMES = ("nothing", "a\nb", MIRROR, LONG, "../x")
NOT_VALUES = ("", "=", "=1", "x", "nothing=1", f"{LONG}=1", f"x={LONG}", f"{MIRROR}=1")
OF_HULA_HOOP = (
    *NOT_VALUES, "free_mass", "free_mass=", "free_mass=x", "free_mass=1_0", "free_mass=\uff11",
    "free_mass=0x10", "free_mass=nan", "free_mass=-1", "free_mass=1e999", "free_mass=\u0663",
)  # fmt: skip
OF_ITS_STATE = (
    *NOT_VALUES, "theta", "theta=", "theta=x", "theta=1_0", "theta=nan", "theta=1e999", "y=\uff11",
)  # fmt: skip
NOT_TIMES = (
    "", ",", "1,", "::", "0:1", "0:1:0", "0:1:-1", "1:0:0.1", "0:1:1e-9", "nan", "1e999", "1_0",
    "2,1", "-1", "0", "1:2:3:4", "1 2", "\u0663", "0x10", "0:1_0:1", "0:inf:1", LONG, "1,1",
)  # fmt: skip
NOT_AXES = (
    "", "x", "free_mass", "free_mass=1:2", "=1:2:3", "free_mass=2:1:3", "free_mass=1:2:1_0",
    "free_mass=nan:2:3", "free_mass=1:2:3:4", "free_mass=1:2:1", "free_mass=1:2:99999999999",
    "free_mass=-1:2:3", "free_mass=1:2:\u0663", "nothing=1:2:3", f"{LONG}=1:2:3",
    "free_mass=1_0:20:3",
)  # fmt: skip
NOT_WRITTEN = ("", "/", ".", "nowhere/x.json", "a\0b", f"{LONG}.json", "/dev/null/x")
NOT_FOLDERS = (LONG, "/dev/null/x")
NOT_READ = ("nowhere", "/", ".", "a\0b", LONG, MIRROR)

BASES = {
    "boundary": "boundary hula_hoop --x force_frequency=1:2 --y force_amplitude=5:9",
    "check": "check hula_hoop --kind algebra",
    "compare": "compare nowhere.xml nowhere.xml",
    "compare-maps": "compare-maps nowhere.nc nowhere.nc",
    "diff": "diff nowhere.json nowhere.json",
    "explain": "explain deviation",
    "export": "export hula_hoop -o -",
    "extremes": "extremes hula_hoop",
    "frequencies": "frequencies hula_hoop",
    "inspect": "inspect nowhere.xml",
    "judge": "judge nowhere.csv --case hula_hoop/rod_aligned",
    "list": "list hula_hoop",
    "map": "map hula_hoop --quantity floquet -o m.nc --x force_frequency=1:2:3 "
    "--y force_amplitude=5:9:3",
    "orbit": "orbit hula_hoop",
    "reproduce": "reproduce hula_hoop",
    "simulate": "simulate hula_hoop --times 0.1",
    "tradeoff": "tradeoff hula_hoop",
}
"""A line of each verb that the rest is added to."""

KINDS = {
    "NAME=VALUE": OF_HULA_HOOP, "T1,T2,...|START:STOP:STEP": NOT_TIMES, "NAME=LO:HI:N": NOT_AXES,
    "JOINT=SPEED": NOT_VALUES,
}  # fmt: skip
READ = {"--known"}

Call = tuple[str, tuple[str, ...]]


def wrong_values(option: click.Parameter) -> tuple[str, ...]:
    """Return words that no option of this kind may have."""
    name, kind = option.opts[-1], option.metavar or ""
    if isinstance(option.type, Number):
        return NOT_NUMBERS if option.type.least is None else NOT_COUNTS
    if name == "--state":
        return OF_ITS_STATE
    if kind in KINDS:
        return KINDS[kind]
    if kind == "DIR":
        return NOT_FOLDERS
    if kind.startswith("FILE"):
        return NOT_READ if name in READ else NOT_WRITTEN
    return NOT_NAMES


def calls() -> list[Call]:
    """Return malformed calls: the line of a verb, and the words that make it so."""
    found: list[Call] = []
    for verb, base in BASES.items():
        command = program.get_command(click.Context(program), verb)
        assert command is not None
        for option in command.params:
            if isinstance(option, click.Argument):
                found += [(verb, (word,)) for word in ("nothing", MIRROR, LONG, "")]
            elif not getattr(option, "is_flag", False):
                name = option.opts[-1]
                found += [(base, (name, word)) for word in wrong_values(option)]
                found.append((base, (name,)))
        found += [(base, words) for words in ((), ("--nothing",), (f"--{MIRROR}",))]
        if verb != "inspect":  # which tells of each file in its own line
            found.append((base, ("a", "b", "c")))
    found += [("", (word,)) for word in ("", "nothing", "chek", LONG, MIRROR, "--nothing")]
    right = {base for base in BASES.values() if "nowhere" not in base}
    return [(base, words) for base, words in found if words or base not in right]


DRAWN = random.Random(15).sample(calls(), 800)
COMMANDS, REST = DRAWN[:40], DRAWN[40:]


def test_there_are_enough_of_every_verb() -> None:
    """Five at the least, or a third of all calls of a verb that has few options."""
    drawn, every = ([base.partition(" ")[0] for base, _ in some] for some in (DRAWN, calls()))
    assert all(drawn.count(verb) >= min(5, every.count(verb) / 3) for verb in VERBS)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def refuse(calls: list[Call]) -> float:
    """Make sure that calls in this process are refused; return the slowest's CPU time [s]."""
    slowest, before = 0.0, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for base, words in calls:
        begin = process_time()
        done = invoke(base, *words)
        slowest = max(slowest, process_time() - begin)
        look_at((base, words), done.exit_code, done.stdout, done.stderr)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 1 << 20
    return slowest


def look_at(call: Call, code: int, out: str, error: str) -> None:
    """Make sure that a call was refused in one line."""
    assert code in (1, 2), (call, code, error)
    lines = error.splitlines()
    assert len(lines) == 1, (call, error)
    assert lines[0].startswith("Error: "), (call, error)
    assert len(lines[0]) < 300, (call, error)
    assert lines[0].isprintable(), (call, error)
    assert not out, (call, out)


def test_some_are_refused(here: None) -> None:
    assert refuse(REST[:120]) < 20


@pytest.mark.slow
def test_all_are_refused(here: None) -> None:
    assert refuse(REST) < 20


PEAK = """
import resource, subprocess, sys
code = subprocess.run(sys.argv[1:]).returncode
used = resource.getrusage(resource.RUSAGE_CHILDREN)
print(used.ru_maxrss, used.ru_utime + used.ru_stime, sep="\\n", file=sys.stderr)
sys.exit(code)
"""
"""Runs a command and prints its memory [KiB], which counts that of the process that starts it, and
its CPU time [s].
"""


@pytest.mark.parametrize(
    "call",
    [pytest.param(c, marks=[] if i < 2 else pytest.mark.campaign) for i, c in enumerate(COMMANDS)],
    ids=range(len(COMMANDS)),
)
def test_as_commands(here: None, call: Call) -> None:
    base, words = call
    if any("\0" in word for word in words):  # which no command can have
        words = tuple(word.replace("\0", "\n") for word in words)
    command = [sys.executable, "-c", PEAK, *MAIN, *base.split(), *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    *error, peak, seconds = done.stderr.splitlines(keepends=True)
    look_at((base, words), done.returncode, done.stdout, "".join(error))
    assert int(peak) < 1 << 20
    assert float(seconds) < 20

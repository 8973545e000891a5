"""Code of others runs in processes of its own: whatever it does there is its error alone."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from mbcheck.tests.support.command import process

TOY = """
import numpy as np
import mbcheck
from mbcheck.reference import get_scene


class Toy(mbcheck.Engine):
    name, version, reads_mjcf = "toy", "1", False
    methods = (mbcheck.Method("Euler", 1, "ExplicitEuler"),)

    def accelerations(self, system, time, q, v):
        slopes = get_scene(system.case.scene).right_hand_side(system.case.parameters)
        return slopes(time, np.concatenate([q, v]))[len(q):]
"""
HEAD = "import ctypes, os, sys\nfrom toy import Toy\n\n\nclass Bad(Toy):\n    name = 'bad'\n"
ENDS = {
    "os._exit(0)": "exit code 0",
    "sys.exit(0)": "SystemExit",
    "raise KeyboardInterrupt": "KeyboardInterrupt",
    "os.abort()": "SIGABRT",
    "ctypes.string_at(0)": "SIGSEGV",
}
PLACES = {
    "at import": "import ctypes, os, sys\n{end}\n",
    "in its construction": HEAD + "    def __init__(self):\n        {end}\n",
    "in a property": HEAD + "    @property\n    def version(self):\n        {end}\n",
    "in a call": HEAD + "    def accelerations(self, *state):\n        {end}\n",
}
FEW = "check hula_hoop --kind algebra --id */point_mass_3hz_60n/* --json -"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "toy.py").write_text(TOY)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def verdicts(line: str) -> tuple[dict[str, set[tuple[str, str]]], int]:
    """Return verdicts and reasons by engine, and the exit code."""
    done = process(line)
    found: dict[str, set[tuple[str, str]]] = {}
    for item in json.loads(done.stdout)["results"]:
        found.setdefault(item["engine"], set()).add((item["verdict"], item["reason"]))
    return found, done.returncode


SOME = [("at import", "os._exit(0)"), ("in a call", "ctypes.string_at(0)")]


@pytest.mark.parametrize(
    ("place", "end"),
    [
        pytest.param(place, end, marks=[] if (place, end) in SOME else pytest.mark.slow)
        for place in PLACES
        for end in ENDS
    ],
)
def test_an_engine_that_ends_its_process_is_an_error_and_others_go_on(
    folder: Path, place: str, end: str
) -> None:
    (folder / "bad.py").write_text(PLACES[place].format(end=end))
    found, code = verdicts(f"{FEW} --engine toy:Toy --engine bad:Bad")
    assert code == 1
    assert {verdict for verdict, _ in found.pop("toy")} <= {"pass", "skipped"}
    ((bad, results),) = found.items()
    assert bad in ("bad", "bad:Bad")
    errors = [reason for verdict, reason in results if verdict == "error"]
    assert errors
    assert all(ENDS[end] in reason for reason in errors)


def test_an_engine_that_cannot_be_loaded_is_told_by_every_verb(folder: Path) -> None:
    (folder / "bad.py").write_text(PLACES["at import"].format(end="os._exit(0)"))
    for line in ("simulate hula_hoop --times 1", "orbit hula_hoop", "frequencies hula_hoop"):
        done = process(f"{line} --engine bad:Bad")
        assert done.returncode == 2
        assert "engine bad:Bad: it cannot be loaded" in done.stderr
        assert len(done.stderr.splitlines()) == 1


@pytest.mark.slow
def test_an_engine_that_changes_numpy_changes_no_other(folder: Path) -> None:
    spoilt = HEAD + "\n\nimport numpy\nnumpy.sin = lambda x: 0 * x\nnumpy.cos = lambda x: 0 * x\n"
    (folder / "bad.py").write_text(spoilt)
    for engines in ("--engine bad:Bad --engine toy:Toy", "--engine toy:Toy --engine bad:Bad"):
        found, _ = verdicts(f"{FEW} {engines}")
        assert {verdict for verdict, _ in found["toy"]} <= {"pass", "skipped"}


def test_other_verbs_run_an_engine_beside_themselves(folder: Path) -> None:
    told = HEAD.replace("class", f"assert os.getpid() != {os.getpid()}\n\n\nclass")
    (folder / "bad.py").write_text(told)
    done = process("frequencies hula_hoop --engine bad:Bad --json -")
    assert json.loads(done.stdout)["engine"] == "bad", done.stderr

"""Code of others runs in processes of its own: whatever it does there is its error alone."""

from __future__ import annotations

import json
import os
import re
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from mbcheck.comparisons.engines import registry
from mbcheck.tests.support.command import invoke

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
    monkeypatch.setattr(registry, "_loaded", cache(registry._loaded.__wrapped__))
    monkeypatch.setattr(registry, "_named", {})
    return tmp_path


def verdicts(line: str) -> tuple[dict[str, set[tuple[str, str]]], int]:
    """Return verdicts and reasons by engine, and the exit code."""
    done = invoke(line)
    found: dict[str, set[tuple[str, str]]] = {}
    for item in json.loads(done.stdout)["results"]:
        found.setdefault(item["engine"], set()).add((item["verdict"], item["reason"]))
    return found, done.exit_code


SOME = {("at import", "os._exit(0)"), ("in a call", "ctypes.string_at(0)")}
EACH = {
    ("at import", "raise KeyboardInterrupt"),
    ("in its construction", "sys.exit(0)"),
    ("in a property", "os.abort()"),
    ("in a call", "sys.exit(0)"),
}
"""By default, and in slow tests: with those every place and every end. All pairs: a campaign."""


def marks_of(pair: tuple[str, str]) -> list[Any]:
    """Return the marks of a place and an end."""
    return [] if pair in SOME else [pytest.mark.slow if pair in EACH else pytest.mark.campaign]


@pytest.mark.parametrize(
    ("place", "end"),
    [pytest.param(place, end, marks=marks_of((place, end))) for place in PLACES for end in ENDS],
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
        done = invoke(f"{line} --engine bad:Bad")
        assert done.exit_code == 2
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
    done = invoke("frequencies hula_hoop --engine bad:Bad --json -")
    assert json.loads(done.stdout)["engine"] == "bad", done.stderr


# What the author of an engine is told

RAISES = (
    HEAD
    + """    @property
    def version(self):
        return "1"

    def accelerations(self, *state):
        return helper(len(state))


def helper(size):
    try:
        return [][size]
    except IndexError as error:
        raise ValueError({message}) from error
"""
)


RAISED_AT = RAISES[: RAISES.index("raise ValueError")].count("\n") + 1
"""Line on which it is raised."""


@pytest.mark.parametrize(
    ("message", "seen"),
    [
        ("'a reason\\nin three\\nlines'", "ValueError: a reason\nin three\nlines"),
        ("'\\x1b[31m\\u202egnorw\\x07'", "ValueError: \\x1b[31m\\u202egnorw\\x07"),
        pytest.param("'0' * 5_000_000 + 'the end'", "000the end", marks=pytest.mark.slow),
    ],
)
def test_an_author_sees_the_lines_of_the_engine(folder: Path, message: str, seen: str) -> None:
    """In full, apart from the reason, limited, and without what a terminal obeys."""
    (folder / "bad.py").write_text(RAISES.format(message=message))
    done = invoke(f"{FEW} -v --engine bad:Bad --engine toy:Toy".replace("--json -", "--json f"))
    results = json.loads((folder / "f").read_text())["results"]
    assert len((folder / "f").read_bytes()) < 200_000
    failed = [item for item in results if item["verdict"] == "error"]
    assert failed
    for item in results:
        assert (item["traceback"] is None) == (item["verdict"] != "error")
    for item in failed:
        assert len(item["reason"]) < 400
        assert "\n" not in item["reason"]
        assert len(item["traceback"]) <= 8000
        assert seen in item["traceback"]
        assert item["reason"].endswith(f" (bad.py:{RAISED_AT})")
        assert "\x1b" not in item["traceback"]
        first, second = item["traceback"].split("direct cause")
        for part in (first, second):
            assert f'File "{folder / "bad.py"}", line ' in part
            assert "mbcheck" not in part.partition(str(folder))[0]
        assert "IndexError" in first
        assert "in helper" in second
    printed = done.stdout
    assert len(re.findall(r"^TRACEBACK\b", printed, re.MULTILINE)) == 1
    assert all(line.isprintable() for line in printed.splitlines())
    for line in failed[0]["traceback"].splitlines():
        assert f"  {line}" in printed.splitlines()


def test_a_traceback_is_shown_apart_on_request(folder: Path) -> None:
    (folder / "bad.py").write_text("x = 1\nprint(x / 0)\n")
    few = FEW.replace("--json -", "--junit junit.xml")
    done = invoke(f"{few} --engine bad:Bad --engine toy:Toy")
    assert "1 traceback of engines: shown with -v" in done.stdout
    assert 'bad.py", line 2' not in done.stdout
    assert f'File "{folder / "bad.py"}", line 2, in &lt;module' in Path("junit.xml").read_text()
    assert "ZeroDivisionError" in invoke(f"{few} -v --engine bad:Bad --engine toy:Toy").stdout


def test_what_an_engine_says_of_itself_is_one_line_that_turns_nothing(folder: Path) -> None:
    end = "import mbcheck; raise mbcheck.Unsupported('\\x1b[2J\\u202eon' + 9999 * 'o')"
    (folder / "bad.py").write_text(PLACES["in a call"].format(end=end))
    found, _ = verdicts(f"{FEW} --engine toy:Toy --engine bad:Bad")
    reasons = {reason for verdict, reason in found["bad"] if verdict == "skipped"}
    (told,) = (reason for reason in reasons if "ooo" in reason)
    assert told.startswith("\\x1b[2J\\u202eonooo")
    assert len(told) <= 2000


@pytest.mark.parametrize(
    "place",
    [
        "at import",
        pytest.param("in its construction", marks=pytest.mark.slow),
        pytest.param("in a property", marks=pytest.mark.slow),
    ],
)
def test_the_limit_of_time_holds_as_an_engine_is_loaded(folder: Path, place: str) -> None:
    """It took two minutes to find that it hangs, whatever the limit."""
    (folder / "bad.py").write_text(PLACES[place].format(end="__import__('time').sleep(3600)"))
    found, code = verdicts(f"{FEW} --engine bad:Bad --time-limit 1")
    assert code == 1
    ((verdict, reason),) = found["bad:Bad"]
    assert verdict == "error"
    assert "cannot be loaded: stopped: it had not ended after 1 s" in reason


def test_the_budget_of_a_query_holds_as_an_engine_is_loaded(folder: Path) -> None:
    (folder / "bad.py").write_text("while True: pass\n")
    done = invoke("frequencies hula_hoop --engine bad:Bad --budget 3")
    assert done.exit_code == 2
    assert re.search(r"has not ended after [\d.]+ s, and its budget is 3 s", done.stderr)

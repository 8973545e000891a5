"""Engines that are given as objects, from a plain script and to functions."""

from __future__ import annotations

import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

import mbcheck
from mbcheck.comparisons.engines import registry
from mbcheck.reference.errors import UsageError
from mbcheck.tests.support.command import refusal, succeeds
from mbcheck.tests.support.engines.solved import Solved

SCRIPT = """
import numpy as np
import mbcheck
from mbcheck.reference import get_scene
from mbcheck.reference.solve import schemes


class MyEngine(mbcheck.Engine):
    name, version, reads_mjcf = "mine", "1", False
    methods = (mbcheck.Method("RK4", 4, "RK44"),)

    def __init__(self, factor=1.0):
        self.factor = factor

    def accelerations(self, system, time, q, v):
        print("called")
        slopes = get_scene(system.case.scene).right_hand_side(system.case.parameters)
        return self.factor * slopes(time, np.concatenate([q, v]))[len(q):]

    def simulate(self, system, method, step, times):
        raise mbcheck.Unsupported("not yet")


report = mbcheck.check_engine(MyEngine(), scenes=["hula_hoop"], kinds=["algebra"])
print(report.summary_line, report.exit_code)
report = mbcheck.check(["hula_hoop"], engines=[MyEngine(1.01)], kinds=["algebra"], jobs=2)
print(report.text())
"""
RIGHT = mbcheck.Method("RK4", 4, "RK44")


def test_a_plain_script_checks_its_engine(tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(SCRIPT, encoding="utf-8")
    command = [sys.executable, "script.py"]
    ended = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert ended.returncode == 0, ended.stderr
    assert not ended.stderr
    first, second, *_ = ended.stdout.splitlines()
    assert first.startswith("PASS: ")
    assert first.endswith(" 0")
    assert second == "Located:"
    assert "mine: its accelerations or its mass matrix is wrong" in ended.stdout
    assert "mbcheck.check(engines=[...], ids=[the id])" in ended.stdout
    assert "called" not in ended.stdout


def test_objects_are_known_only_meanwhile() -> None:
    for engine in (Solved(RIGHT), Solved(RIGHT, change=lambda p: p.replace(main_mass=1.0))):
        report = mbcheck.check(["hula_hoop"], [engine], ids=["*/point_mass_3hz_60n/algebra/*"])
        assert report.selection.engines == ("solved",)
    assert report.exit_code == 1
    assert "solved" not in registry._named


@pytest.mark.parametrize(
    ("engines", "words"),
    [
        ([Solved(RIGHT), Solved(RIGHT)], "two engines call themselves solved"),
        ([object()], "engine object is no mbcheck.Engine"),
        ("mujoco", "did you mean"),
    ],
)
def test_what_is_no_list_of_engines_is_refused(engines: object, words: str) -> None:
    with pytest.raises(UsageError, match=words):
        mbcheck.check(["hula_hoop"], engines)  # type: ignore[arg-type]


def leave(*_: object) -> None:
    raise SystemExit(0)


def refuse(*_: object) -> None:
    raise UsageError("the run is over")


ANSWERS = {
    "leaves": (leave, "SystemExit"),
    "ends": (refuse, "unsupported_reason: the run is over"),
    "number": (lambda *_: 5, "must return a reason or None, not int 5"),
}


def test_what_fails_as_checks_are_planned_is_an_error_of_its_engine() -> None:
    """Of all engines of a run nothing was checked, or the run ended."""
    engines = [Solved(RIGHT)]
    for name, (answer, _) in ANSWERS.items():
        wrong = Solved(RIGHT)
        vars(wrong).update(name=name, unsupported_reason=answer)
        engines.append(wrong)
    report = mbcheck.check(["hula_hoop"], engines, ids=["*/point_mass_3hz_60n/algebra/*"])
    assert report.exit_code == 1
    found = {(one.engine, one.verdict): one.reason for one in report.results}
    assert ("solved", "deviation") not in found
    found.pop(("solved", "pass"))
    found.pop(("solved", "skipped"), None)
    for name, (_, words) in ANSWERS.items():
        assert words in found.pop((name, "error"))
    assert not found


def test_an_engine_of_a_package_runs_in_this_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    about = tmp_path / "parcel-1.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: parcel\nVersion: 1\n")
    (about / "entry_points.txt").write_text("[mbcheck.engines]\nmine = parcel:MyEngine\n")
    (tmp_path / "parcel.py").write_text(f"{SCRIPT.partition('report =')[0]}HERE = {os.getpid()}\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(registry, "offered", cache(registry.offered.__wrapped__))
    monkeypatch.setattr(registry, "load_plugin", cache(registry.load_plugin.__wrapped__))
    few = "check hula_hoop --kind algebra --id */point_mass_3hz_60n/*"
    succeeds(f"{few} --engine mine --in-process")
    assert os.getpid() == sys.modules["parcel"].HERE


def test_limits_need_a_process() -> None:
    with pytest.raises(UsageError, match="run in this process, without limits"):
        mbcheck.check_engine(Solved(RIGHT), kinds=["algebra"], time_limit=5)


@pytest.mark.parametrize(
    ("line", "meant"),
    [
        ("check --engine my_engine.MyEngine", "'my_engine:MyEngine'"),
        ("check --engine a.b.C", "'a.b:C'"),
        ("check hula_hoop --engine mujoco --method implicitfst", "'implicitfast'"),
        ("check --profile strikt", "'strict'"),
        ("check --source validatoin", "'validation'"),
    ],
)
def test_a_slip_of_the_pen_is_recognised(line: str, meant: str) -> None:
    assert f"did you mean {meant}?" in refusal(line)


LOUD = SCRIPT.partition("report =")[0].replace("self.factor *", "1 / 0 *")


def test_an_engine_runs_under_a_debugger(tmp_path: Path) -> None:
    """In the process of the command, with its console: `pdb` works in it."""
    stops = LOUD.replace('print("called")', 'print("my prints"); breakpoint()')
    (tmp_path / "loud.py").write_text(stops, encoding="utf-8")
    line = "check hula_hoop --kind algebra --engine loud:MyEngine --in-process --fail-fast"
    command = [sys.executable, "-c", "from mbcheck.comparisons.cli import main; main()"]
    ended = subprocess.run(
        [*command, *line.split()],
        input="p 'the time is', time\nquit\n",
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
    )
    assert "my prints" in ended.stdout
    assert "('the time is', " in ended.stdout


def test_what_it_printed_is_shown_beside_its_traceback(tmp_path: Path) -> None:
    (tmp_path / "loud.py").write_text(LOUD, encoding="utf-8")
    command = [sys.executable, "-c", "from mbcheck.comparisons.cli import main; main()"]
    line = "check hula_hoop --kind algebra --engine loud:MyEngine -v"
    ended = subprocess.run(
        [*command, *line.split()], capture_output=True, text=True, check=False, cwd=tmp_path
    )
    assert ended.returncode == 1
    assert "ZeroDivisionError" in ended.stdout
    assert "its console:" in ended.stdout
    assert "called" in ended.stdout


def test_a_debugger_needs_an_engine_of_the_users() -> None:
    assert "--in-process runs engines that others plug in" in refusal(
        "check --engine mujoco --in-process"
    )

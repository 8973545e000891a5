"""Files and arrays with a trajectory: what they may look like, and what is refused."""

from collections.abc import Mapping
from io import StringIO
from pathlib import Path
from time import process_time
from typing import Any

import mujoco  # noqa: F401
import numpy as np
import pytest

from mbcheck.comparisons.judge.judge import judge_trajectory
from mbcheck.comparisons.judge.recording import recording
from mbcheck.comparisons.queries.simulate import Simulation, simulate
from mbcheck.comparisons.reports.queries import csv_text
from mbcheck.reference.errors import UsageError
from mbcheck.tests.support.command import invoke
from mbcheck.tests.support.trajectory import (
    CASE,
    GOOD,
    START,
    TIMES,
    Columns,
    columns,
    verdicts,
)

pytestmark = pytest.mark.usefixtures("own_folder")

# Files


def written_as(found: Columns, names: list[str], delimiter: str, first: str = "") -> str:
    text = StringIO()
    text.write(first + delimiter.join(names) + "\n")
    for row in zip(*found.values(), strict=True):
        text.write(delimiter.join(f"{value!r}" for value in map(float, row)) + "\n")
    return text.getvalue()


def forms(found: Columns) -> Mapping[str, bytes]:
    names = list(found)
    units = ["t [s]", "y [m]", "theta (rad)", "y_dot [m/s]", "theta_dot [rad/s]"]
    plain = written_as(found, names, ",")
    return {
        "commas": plain.encode(),
        "semicolons": written_as(found, names, ";").encode(),
        "tabs": written_as(found, names, "\t").encode(),
        "blanks": written_as(found, names, " ").encode(),
        "units": written_as(found, units, ",").encode(),
        "named_in_a_comment": written_as(found, names, " ", "# ").encode(),
        "comments": b"# of my simulator\n\n" + plain.encode() + b"# the end\n\n",
        "windows": b"\xef\xbb\xbf" + plain.replace("\n", "\r\n").encode(),
        "quotes": plain.replace("theta_dot", '"theta_dot"').encode(),
        "trailing_commas": plain.replace("\n", ",\n").encode(),
        "spaces": plain.replace(",", " , ").encode(),
        "time": plain.replace("t,", "Time,", 1).encode(),
    }


@pytest.mark.parametrize("form", forms(dict.fromkeys("tyabc", np.zeros(1))))
def test_a_file_may_look_like_this(form: str, truth: Simulation) -> None:
    Path("a.csv").write_bytes(forms(columns(truth))[form])
    found = recording("a.csv")
    assert np.array_equal(found.times, TIMES)
    assert set(found.columns) == set(truth.observables)
    for name, values in truth.observables.items():
        assert np.array_equal(found.columns[name], values)
    assert set(found.units.values()) <= {"m", "rad", "m/s", "rad/s"}
    assert bool(found.units) == (form == "units")


@pytest.mark.parametrize("bounds", [False, True])
def test_what_simulate_writes_is_read_with_every_digit(simulated: Simulation, bounds: bool) -> None:
    Path("a.csv").write_text(csv_text(simulated, bounds))
    found = recording("a.csv")
    assert np.array_equal(found.times, simulated.times)
    for name, values in simulated.observables.items():
        assert np.array_equal(found.columns[name], values)


REFUSED: list[tuple[str, str]] = [
    ("", "is empty"),
    ("# nothing\n\n", "is empty"),
    ("t,theta\n", "has a header and no numbers below it"),
    ("0,0.3\n0.1,1.9\n", "the first line must name the columns"),
    ("theta,theta_dot\n0.3,18\n", "no column is named t; found: 'theta', 'theta_dot'"),
    ("t|theta\n0|0.3\n", "no column is named t; found: 't|theta' (commas, semicolons"),
    ("t,phi\n0,0.3\n0.1,1\n", "no column is an observable of hula_hoop: found 'phi'; known: y,"),
    ("t,theta,theta\n0,1,1\n", "two columns are named 'theta'"),
    (GOOD + "0.2,abc\n", "line 4: theta is 'abc', which is no number"),
    (GOOD + "0.2,\n", "line 4: theta is '', which is no number"),
    ("t;theta\n0;0,3\n", "line 2: theta is '0,3', which is no number; decimals need a point"),
    (GOOD + "0.2,1,2\n", "line 4: 3 numbers, but the header names 2 columns (t, theta); commas"),
    ("t,theta\n0 0.3\n", "line 2: 1 numbers, but the header names 2 columns"),
    (GOOD + "nan,2\n", "line 4: t is nan"),
    (GOOD + "0.1,1.9\n", "line 4: t = 0.1 stands twice; times must increase"),
    ("#x\n" + GOOD + "\n0.05,1.9\n", "line 6: t = 0.05 comes after 0.1; times must increase"),
    ("t,theta\n-0.1,0.3\n0.1,1\n", "the first time is -0.1 s, but"),
    ("t,theta\n0,0.3\n", "no sample lies after the start of the case, t = 0 s"),
    ("t,theta\n0,0.3\n500,1.9\n", "lasts 0.5 s: are they in seconds?"),
    ("t [ms],theta\n0,0.3\n1,1.9\n", "times must be in seconds: t [ms]"),
    ("t,theta [deg]\n0,0.3\n0.1,1\n", "theta is in deg: convert it to rad"),
]


@pytest.mark.parametrize(("text", "words"), REFUSED)
def test_a_file_that_is_refused(text: str, words: str) -> None:
    Path("a.csv").write_text(text)
    done = invoke(f"judge a.csv --case {CASE} --tolerance 0.1")
    assert done.exit_code == 2
    assert words in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_bytes_that_are_no_text() -> None:
    Path("a.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(UsageError, match="is not text in UTF-8"):
        recording("a.csv")


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ({"t": [0, 1], "y": [0]}, "columns differ in length: t 2, y 1"),
        ({"t": [0, 1], "y": [[0], [1]]}, "y must be one row of numbers"),
        ({"t": [0, 1], "y": ["a", "b"]}, "y must be numbers"),
        ({"t": [1, 0], "y": [0, 1]}, "row 1: t = 0 comes after 1"),
        ({"t": [], "y": []}, "empty"),
        ({}, "no column is named t; found: nothing"),
        (3.0, "a trajectory is a file, or arrays by name, not float"),
    ],
)
def test_arrays_that_are_refused(data: Any, words: str) -> None:
    with pytest.raises(UsageError, match=words):
        judge_trajectory(data, CASE)


@pytest.mark.parametrize(("rows", "most"), [(20_000, 5.0)])
def test_a_long_file_takes_seconds(rows: int, most: float) -> None:
    long_file_takes(rows, most)


@pytest.mark.slow
def test_many_rows_take_seconds() -> None:
    long_file_takes(200_000, 15.0)


def long_file_takes(rows: int, most: float) -> None:
    found = simulate("hula_hoop", state=START, times=np.linspace(0, 0.5, rows))
    table = np.array(list(columns(found).values())).T
    np.savetxt("a.csv", table, "%.17g", delimiter=",", header=",".join(columns(found)))
    begin = process_time()
    assert verdicts(judge_trajectory("a.csv", CASE, tolerance=1e-9)) == {"pass"}
    assert process_time() - begin < most

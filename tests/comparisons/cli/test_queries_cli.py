"""The verbs of queries: the head of a CSV file, and budgets that bind."""

from __future__ import annotations

import csv

import pytest

from mbcheck.comparisons.queries.simulate import simulate
from mbcheck.tests.support.command import invoke, refusal, succeeds

SIMULATE = "simulate hula_hoop --times 0,0.05,0.1"


def test_the_head_of_a_csv_tells_its_origin() -> None:
    text = succeeds(f"{SIMULATE} --set rod_length=0.06 --csv - --bounds")
    lines = text.splitlines()
    comments = [line for line in lines if line.startswith("#")]
    assert lines[: len(comments)] == comments
    head, table = "\n".join(comments), list(csv.reader(lines[len(comments) :]))
    found = simulate("hula_hoop", parameters={"rod_length": 0.06}, times=[0, 0.05, 0.1])
    assert found.error_bound is not None
    assert head.startswith("# hula_hoop by reference DOP853, model exact")
    assert "rod_length=0.06" in head
    assert "t=s, y=m, theta=rad, y_dot=m/s, theta_dot=rad/s" in head
    assert f"mbcheck={found.versions['mbcheck']}" in head
    assert table[0][5:] == ["y_bound", "theta_bound", "y_dot_bound", "theta_dot_bound"]
    for name, bound in found.error_bound.items():
        assert f"{name}={bound}" in head
        column = table[0].index(f"{name}_bound")
        assert {row[column] for row in table[1:]} == {repr(bound)}


def test_bounds_need_a_csv_file_and_the_reference() -> None:
    assert "--bounds adds columns" in refusal(f"{SIMULATE} --bounds")
    assert "an engine states no bound" in refusal(f"{SIMULATE} --engine mujoco --bounds --csv -")


def test_a_spring_that_is_nothing_beside_the_weight_ends_in_one_line() -> None:
    done = invoke("orbit rotor_pendulum --set gravity_x=1e300")
    assert done.exit_code == 1
    assert done.stderr.startswith("Error: the natural frequencies")


@pytest.mark.parametrize(
    "line",
    [
        "orbit hula_hoop --set force_amplitude=1e300",
        "orbit speed_regulator --set damping=1e6 --set torque=1.1",
        "orbit speed_regulator --set gravity_x=1e300",
        "orbit rotor_pendulum --set motor_slope=1e6",
    ],
)
def test_what_leads_nowhere_ends_with_its_budget(line: str) -> None:
    said = refusal(f"{line} --budget 0.01")
    assert "its budget is 0.01 s" in said
    assert "\n" not in said.strip()

"""The cost of a computation is foretold, and refused beyond a budget."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from itertools import count
from time import perf_counter, process_time, sleep

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.engines.isolation import isolated
from mbcheck.comparisons.terminal import program
from mbcheck.comparisons.terminal.program import budgeted
from mbcheck.reference.cost import (
    BUDGET,
    LOOKED,
    Budget,
    expected_end,
    keep_budget,
    keep_steps,
    time_left,
    within,
    words,
)
from mbcheck.reference.errors import EngineError, UsageError
from mbcheck.tests.support.command import refusal, succeeds


def running(seconds: float, end: float) -> Budget:
    """Return the budget of a run that has begun some time ago."""
    before = perf_counter() - LOOKED - 1
    return Budget(seconds, end=end, begun=before, since=before)


@pytest.mark.parametrize(
    ("end", "time", "said"),
    [(1e308, 1.0, "years"), (1e4, 1.0, "16 hours|17 hours"), (10.0, 0.0, "inf years")],
)
def test_the_rest_of_a_run_is_foretold(end: float, time: float, said: str) -> None:
    with pytest.raises(UsageError, match=f"about .*({said}), and its budget is 10 minutes"):
        running(600.0, end).look(time)


def test_a_run_that_will_end_in_time_goes_on() -> None:
    budget = running(600.0, 10.0)
    for time in (1.0, np.array([2.0, 3.0]), 9.0, 3.0 + 1j):
        budget.look(time)


def test_each_of_several_runs_is_foretold_by_itself() -> None:
    budget = running(600.0, 1e4)
    budget.farthest = 1e4
    budget.look(0.5)
    assert budget.farthest == 0.5


def test_what_is_half_done_takes_as_long_again() -> None:
    with within(1000.0):
        keep_budget(0.5)
        budget = BUDGET.get()
        assert budget is not None
        budget.begun -= 600.0
        keep_budget(0.7)
        with pytest.raises(UsageError, match="about 20 minutes"):
            keep_budget(0.5)


def test_all_of_a_budget_may_be_used() -> None:
    Budget(1000.0, begun=perf_counter() - 900.0).look(0.5)
    with within(1000.0):
        assert 900.0 < (time_left() or 0.0) <= 1000.0
    assert time_left() is None


def test_what_no_share_is_known_of_ends_with_its_budget() -> None:
    with pytest.raises(UsageError, match="its budget is 3 s"):
        Budget(3.0, begun=perf_counter() - 4).look(0.5)


def test_steps_are_measured_where_they_are_many() -> None:
    with within(60.0):
        keep_steps(1e3, lambda: pytest.fail("measured"))
        keep_steps(1e6, lambda: 1e-6)
        with pytest.raises(UsageError, match="about 17 minutes"):
            keep_steps(1e9, lambda: 1e-6)


BEYOND = {
    "simulate hula_hoop --times 1 --budget 1e-9": "its budget is 1e-09 s",
    "orbit hula_hoop --budget 1e-9": "its budget is 1e-09 s",
    "map hula_hoop --quantity floquet --x force_frequency=1:10:4 --y force_amplitude=5:150:4 "
    "-o - --budget 1e-9": "its budget is 1e-09 s",
    "map hula_hoop --quantity class --x force_frequency=1:10:2 --y force_amplitude=5:150:2 "
    "-o - --engine mujoco --step 1e-7": "9.09e-07 s is the shortest that all of its points",
    "check hula_hoop --engine mujoco --horizon 1 --budget 1e-9": "its budget is 1e-09 s",
    "simulate hula_hoop --times 1 --engine mujoco --step 1e-9": "this would take about ",
    "simulate hula_hoop --times 0:1:1e-7": "more than 1000000 times",
    "simulate rotating_beam --times 1 --set segments=1e9": "so many has 8e+18 bytes",
    "frequencies rotating_beam --set segments=1e9 --engine mujoco": "so many has 8e+18 bytes",
    "export rotating_beam --set segments=1e9 -o -": "so many has 8e+18 bytes",
    "orbit hula_hoop --set force_frequency=1e-300": "periods in one of 1e+300 s",
    "orbit hula_hoop --engine mujoco --step 1e-12": "this would take about ",
    "check hula_hoop --engine mujoco --horizon 1e308": "choose 0.0333 to",
    "check hula_hoop --set stiffness=1e300 --engine mujoco --kind trajectory": "floating-point",
    "simulate hula_hoop --times 1 --budget 0": "greater than 0",
    "simulate hula_hoop --times 1 --budget inf": "must be finite",
}
LONG = (
    "simulate hula_hoop --times 1e308",
    "simulate hula_hoop --times 1 --set stiffness=1e300",
    "simulate hula_hoop --times 1 --state theta_dot=6e9",
    "simulate rotating_beam --times 1e8",
    "simulate rotor_pendulum --times 1e9",
)


@pytest.mark.parametrize("line", BEYOND)
def test_what_is_beyond_a_budget_is_refused_in_one_line(
    line: str, tmp_path: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(str(tmp_path))
    assert BEYOND[line] in refusal(line)


@pytest.mark.slow
@pytest.mark.parametrize("line", LONG)
def test_what_would_take_for_ever_is_refused_soon(line: str) -> None:
    begin = process_time()
    assert "its budget is 10 minutes" in refusal(line)
    assert process_time() - begin < 20 * LOOKED


def test_python_has_a_budget_too() -> None:
    """Of a plain loop, of many short runs, of processes, and of a single long one.

    Ten minutes are enough to measure a step, on the busiest machine; 0.5 s are never enough for the
    others.
    """
    axes = ("force_frequency", 1.0, 10.0, 40), ("force_amplitude", 5.0, 150.0, 40)
    calls: tuple[tuple[float, str, Callable[[], object]], ...] = (
        (0.5, "has not ended", lambda: mbcheck.compute_map("hula_hoop", "class", *axes)),
        (
            0.5,
            "has not ended after",
            lambda: mbcheck.check(["hula_hoop"], engines=["mujoco"], kinds=["trajectory"]),
        ),
        (
            600.0,
            "would take about",
            lambda: mbcheck.compute_map("hula_hoop", "class", *axes, engine="mujoco", step=1e-6),
        ),
    )
    for seconds, said, call in calls:
        begin = process_time()
        with (
            pytest.raises(UsageError, match=f"{said}.*its budget is {words(seconds)}"),
            mbcheck.budget(seconds),
        ):
            call()
        assert process_time() - begin < 2 * LOOKED


def test_a_budget_holds_in_processes_too() -> None:
    with pytest.raises(UsageError, match=r"its budget is 0\.5 s"), mbcheck.budget(0.5):
        list(isolated([partial(sleep, 60.0)], 1))
    with mbcheck.budget(60.0):
        assert list(isolated([partial(abs, -1)], 1)) == [(0, 1)]
        ((_, error),) = isolated([partial(sleep, 60.0)], 1, seconds=0.2)
        assert isinstance(error, EngineError)
        assert error.kind == "timeout"


def test_a_long_run_is_foretold_where_no_terminal_is(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """`simulate hula_hoop --times 1 --state theta_dot=1e5` took 202 s of silence."""
    clock = count(0, 60)
    monkeypatch.setattr(program, "monotonic", lambda: next(clock))
    with budgeted(1e9, "simulate"), expected_end(1.0):
        budget = BUDGET.get()
        assert budget is not None
        budget.since -= LOOKED + 1
        budget.look(0.25)
    line = capfd.readouterr().err
    assert re.fullmatch(r"25 of 100 parts of simulate, \d+ s, about \d+ .* left\n", line)


def test_within_its_budget_a_run_is_the_same() -> None:
    line = "simulate hula_hoop --times 0.1 --csv -"
    assert succeeds(f"{line} --budget 1000") == succeeds(line)


def test_what_went_before_a_run_foretells_nothing_of_it() -> None:
    with within(600.0):
        budget = BUDGET.get()
        assert budget is not None
        budget.since -= LOOKED + 1
        mbcheck.simulate("hula_hoop", times=[0.1])
        budget.since -= LOOKED + 1
        budget.look(0.0)  # of what has another end, or none


def test_a_budget_within_another_is_no_longer() -> None:
    with pytest.raises(UsageError, match=r"its budget is 0\.5 s"), within(0.5), within(600.0):
        mbcheck.simulate("hula_hoop", times=[2000.0])

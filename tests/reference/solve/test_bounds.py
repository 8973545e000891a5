"""Stated bounds against errors: runs drawn at random, solved in higher precision by a second route.

The figures of all draws are printed by ``python -m mbcheck.tests.support.precise SCENE 0 500``.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from mbcheck.reference import SCENES
from mbcheck.reference.solve.single import solve
from mbcheck.tests.support.precise.compare import compare
from mbcheck.tests.support.precise.figures import figures, median_margin
from mbcheck.tests.support.precise.runs import KINDS, PROVOCATIONS, run_of

FEW: Mapping[str, tuple[int, ...]] = {
    "hula_hoop": (0, 1, 2, 3, 4, 65, 66, 7, 8, 9),
    "rotating_beam": (0, 1, 22, 3, 14, 15, 16, 27, 18, 19),
    "rotor_pendulum": (20, 21, 22, 3, 4, 45, 96, 67, 58, 9),
    "speed_regulator": (0, 1, 2, 3, 4, 5, 6, 7, 8, 9),
}
"""Draws of each scene that take little time, one of each kind."""

MANY, BLOCK = 500, 25

COMPARE = "mbcheck.tests.support.precise.compare.solve"

CLOSE = {"rotating_beam": 600.0}
"""Largest median of stated bound over error, of regular motions: 30, but where a check by another
run is all that there is."""


@pytest.mark.parametrize("scene", FEW)
def test_few_draws_are_of_all_kinds(scene: str) -> None:
    assert set(FEW) == set(SCENES) == set(KINDS)
    assert {run_of(scene, number).kind for number in FEW[scene]} == {
        kind.__name__ for kind in KINDS[scene]
    }


@pytest.mark.parametrize(
    ("scene", "number"), [(scene, number) for scene, few in FEW.items() for number in few]
)
def test_no_error_is_above_its_bound(scene: str, number: int) -> None:
    outcome = compare(dataclasses.replace(run_of(scene, number), patience=1))  # long ones shortened
    assert not outcome.refusal
    assert outcome.excess <= 1
    assert outcome.excess_in_time <= 1


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow] if provocation.slow else [])
        for name, provocation in PROVOCATIONS.items()
    ],
)
def test_no_error_is_above_its_bound_where_that_is_hard(name: str) -> None:
    outcome = compare(PROVOCATIONS[name].run)
    assert not outcome.refusal
    assert outcome.excess <= 1
    assert outcome.excess_in_time <= 1


@pytest.mark.campaign
@pytest.mark.parametrize("first", range(0, MANY, BLOCK))
@pytest.mark.parametrize("scene", FEW)
def test_no_error_of_many_draws_is_above_its_bound(scene: str, first: int) -> None:
    outcomes = [compare(run_of(scene, number)) for number in range(first, first + BLOCK)]
    print(figures(outcomes))
    assert max(outcome.excess for outcome in outcomes) <= 1
    assert max(outcome.excess_in_time for outcome in outcomes) <= 1
    assert sum(bool(outcome.refusal) for outcome in outcomes) <= BLOCK // 5
    assert median_margin(outcomes) < CLOSE.get(scene, 30.0)


def test_bound_that_is_too_small_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    def proud(*args: Any) -> Any:
        solution = solve(*args)
        bounds = None if solution.bounds is None else solution.bounds * 1e-9
        return dataclasses.replace(solution, bounds=bounds, error_bound=solution.error_bound * 1e-9)

    assert compare(run_of("hula_hoop", 0)).excess < 1
    monkeypatch.setattr(COMPARE, proud)
    assert compare(run_of("hula_hoop", 0)).excess > 1e3


@pytest.mark.parametrize("state", range(4))
def test_state_that_is_off_is_seen(monkeypatch: pytest.MonkeyPatch, state: int) -> None:
    def wrong(*args: Any) -> Any:
        solution = solve(*args)
        states = solution.states.copy()
        states[state, -1] += 2 * solution.error_bound[state]
        return dataclasses.replace(solution, states=states)

    monkeypatch.setattr(COMPARE, wrong)
    assert 1 < compare(run_of("hula_hoop", 0)).excess < 3.1


def test_draws_are_the_same_each_time() -> None:
    for scene in SCENES:
        one, other = run_of(scene, 11), run_of(scene, 11)
        assert one == other
        assert np.all(np.diff(one.times(1.0)) > 0)

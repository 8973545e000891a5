"""What rows of the speed_regulator paper are made of, and that they can fail."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mbcheck.comparisons.engines.registry import REFERENCE
from mbcheck.comparisons.papers.assess import assess
from mbcheck.comparisons.papers.ledger import NOT_REPRODUCED
from mbcheck.comparisons.papers.session import Session
from mbcheck.comparisons.papers.speed_regulator import derivation, results
from mbcheck.comparisons.papers.speed_regulator.figures import last_turn, turns_apart
from mbcheck.comparisons.papers.speed_regulator.rows import ROWS
from mbcheck.reference.speed_regulator.equations import SpeedRegulator

BY_NAME = {row.name: row for row in ROWS}


def test_another_speed_is_not_reproduced() -> None:
    session = Session()
    for first, wrong in ((5.0785, False), (5.6, True)):
        session.cache[results.SCENE, "own speeds", REFERENCE] = np.array([first, 3.4, 2.5])
        verdict = assess(BY_NAME["formula_21"], session).verdict
        assert (verdict == NOT_REPRODUCED) == wrong


@pytest.mark.slow
def test_wrong_kinematics_change_verdicts(monkeypatch: pytest.MonkeyPatch) -> None:
    right = derivation.kinematics
    wrong = lambda phi, p: right(phi, p)._replace(t=1.001 * right(phi, p).t)  # noqa: E731
    monkeypatch.setattr(derivation, "kinematics", wrong)
    assert assess(BY_NAME["remainder"], Session()).verdict == NOT_REPRODUCED
    wrong = lambda phi, p: right(phi, p)._replace(a_1=1.001 * right(phi, p).a_1)  # noqa: E731
    monkeypatch.setattr(derivation, "kinematics", wrong)
    session = Session()
    for name in ("equation_17", "mean_damper", "kinematics"):
        assert assess(BY_NAME[name], session).verdict == NOT_REPRODUCED, name


def test_averages_are_those_of_a_quadrature() -> None:
    for ratio in (0.1, 0.2, 0.6):
        p = SpeedRegulator(crank_radius=ratio * 1.25)
        means = derivation.averages(p)
        assert means["damper"] == pytest.approx(1 - math.sqrt(1 - ratio**2), rel=1e-13)
        assert means["remainder"] == pytest.approx(means["damper"] - ratio**2 / 2, rel=1e-10)
        assert means["cos_squared"] == pytest.approx(0.5, rel=1e-14)
        assert abs(means["slope"]) + abs(means["mixed"]) < 1e-15


def test_turns_of_a_run() -> None:
    run = results.recorded_motion(Session(), "frictionless")
    speeds = results.turn_speeds(run)
    assert np.all(np.diff(speeds) > 0)
    assert results.mean_over_turns(run, 1)[3] == pytest.approx(speeds[3], rel=1e-3)
    y, rate = last_turn(run)
    assert y[0] == pytest.approx(y[-1], abs=1e-3)
    assert abs(rate[0] - rate[-1]) > 1e-4  # it gets faster
    times, gap = turns_apart(run, run)
    assert len(times) == len(gap) > 3
    assert not np.any(gap)

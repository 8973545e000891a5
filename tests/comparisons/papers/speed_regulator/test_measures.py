"""What rows of the speed_regulator paper are made of, and that they can fail."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbcheck.comparisons.engines.registry import REFERENCE
from mbcheck.comparisons.papers.assess import assess
from mbcheck.comparisons.papers.claims import read_condition, read_paper
from mbcheck.comparisons.papers.ledger import NOT_REPRODUCED
from mbcheck.comparisons.papers.session import Session
from mbcheck.comparisons.papers.speed_regulator import measures
from mbcheck.comparisons.papers.speed_regulator.figures import turns_apart
from mbcheck.comparisons.queries.frequencies import frequencies
from mbcheck.comparisons.scenes.quantity import Points
from mbcheck.comparisons.scenes.speed_regulator.limit_cycles import REGIMES, theory_regimes
from mbcheck.reference import get_scene
from mbcheck.reference.errors import NoOrbitError
from mbcheck.reference.speed_regulator.theory import least_torque, rotation

PLACES = np.array([[0, 0], [1, 0]])
BY_NAME = {row.name: row for row in read_paper("speed_regulator").rows}


def test_another_speed_is_not_reproduced() -> None:
    session = Session()
    for first, wrong in ((5.0785, False), (5.6, True)):
        session.cache["speed_regulator.own_speeds", REFERENCE] = np.array([first, 3.4, 2.5])
        verdict = assess(BY_NAME["formula_21"], session).verdict
        assert (verdict == NOT_REPRODUCED) == wrong


def test_averages_are_those_of_a_quadrature() -> None:
    for ratio in (0.1, 0.2, 0.6):
        means = measures.averages(Session(), ratio)
        assert means["damper"] == pytest.approx(1 - math.sqrt(1 - ratio**2), rel=1e-13)
        assert means["remainder"] == pytest.approx(means["damper"] - ratio**2 / 2, rel=1e-10)
        assert means["cos_squared"] == pytest.approx(0.5, rel=1e-14)


def test_turns_of_a_run() -> None:
    run = measures.recorded_motion(Session(), "frictionless")
    speeds = measures.turn_speeds(run)
    assert np.all(np.diff(speeds) > 0)
    two = 2 / (1 / speeds[2] + 1 / speeds[3])
    assert measures.turn_speeds(run, 2)[1] == pytest.approx(two, rel=1e-12)
    y, rate = measures.last_turn(run)
    assert y[0] == pytest.approx(y[-1], abs=1e-3)
    assert abs(rate[0] - rate[-1]) > 1e-4  # it gets faster
    times, gap = turns_apart(run, run)
    assert len(times) == len(gap) > 3
    assert not np.any(gap)


def test_without_the_damper_there_is_no_steady_rotation() -> None:
    with pytest.raises(NoOrbitError):
        rotation(measures.damped(0.0))


@pytest.mark.slow
def test_rotations_begin_at_the_least_torque() -> None:
    """Of all parameters that readings try, by the regime just below and above it."""
    rows = ("missing_parameters", "spring_reference", "braking_of_figure_6")
    calls = [BY_NAME[name].numbers for name in rows]
    sets = [one for call in calls if isinstance(call, partial) for one in call.keywords["sets"]]
    assert len(sets) == 17
    for p in {measures.EXAMPLE.replace(**changes) for changes in sets}:
        torque = least_torque(p).torque * np.array([0.998, 1.002])
        both = p.replace(**{name: np.repeat(getattr(p, name), 2) for name in p.names()})
        at = Points(
            get_scene(measures.SCENE), both.replace(torque=torque), PLACES, {}, REFERENCE, ""
        )
        assert (theory_regimes(at) == REGIMES.index("rest")).tolist() == [True, False], p


@pytest.mark.slow
def test_tolerance_of_the_solver() -> None:
    """As far as they do not hang on the last bits of the start, which coarse tolerances blow up."""
    derivative = get_scene(measures.SCENE).right_hand_side(measures.EXAMPLE)
    row, speeds = BY_NAME["tolerance_of_the_solver"], []
    for name in ("RK45, 1e-06", "RK23, 0.0001", "RK23, 1e-06"):
        method, tolerance = name.split(", ")
        ends = solve_ivp(
            derivative, (0, 240), [0.0, 6.0], method, (200, 240), rtol=float(tolerance), atol=1e-6
        ).y[0]
        speeds.append(float(np.ptp(ends)) / 40)
        assert float(row.candidates[name].split()[0]) == pytest.approx(speeds[-1], abs=2e-4)
    condition = read_condition("value rounds to printed")
    assert condition.compare({"value": speeds[0]}, row.printed).holds


def test_vibrations_about_rest() -> None:
    words = ", ".join(
        f"{name} {frequencies(measures.SCENE, about=name, engine=REFERENCE).modes[0].omega:.3f} "
        "rad/s"
        for name in ("right", "left")
    )
    assert BY_NAME["resonance"].reference == words
    assert BY_NAME["resonance"].reason.endswith(words)

"""What a run of rotor_pendulum ends in."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from mbcheck.reference.rotor_pendulum import CASE_1, CASE_2, CASE_3, SCENE
from mbcheck.reference.rotor_pendulum.equations import (
    RotorPendulum,
)
from mbcheck.reference.rotor_pendulum.outcome import LEAST_TURNS, outcome
from mbcheck.reference.rotor_pendulum.phase import (
    mean_phase,
    phase_rate,
    wrapped,
)
from mbcheck.reference.scene import Array

# What a run ends in -------------------------------------------------------------------------


SPEED = 153.7
RATE = {p: float(phase_rate(p, SPEED)) for p in (CASE_1, CASE_2, CASE_3)}
STABLE = {CASE_1: -3.129, CASE_2: 0.064}


def synthetic(
    phase: Callable[[Array], Any], horizon: float, per_turn: int = 16, ripple: float = 0.05
) -> tuple[Array, dict[str, Array]]:
    """Return times and values of a run with this phase difference, rotors at `SPEED`."""
    times = np.arange(0, horizon, 2 * np.pi / SPEED / per_turn)
    alpha = phase(times) + 0 * times
    turn = SPEED * times + ripple * np.sin(SPEED * times + 0.3)
    second = turn - alpha
    rates = [SPEED * (1 + ripple * np.cos(SPEED * times + 0.3))] * 2
    rates[1] = rates[1] - np.gradient(alpha, times)
    values = dict(zip(("phi_1", "phi_2"), (turn, second), strict=True))
    return times, values | dict(zip(("phi_1_dot", "phi_2_dot"), rates, strict=True))


def settling(place: float, start: float, rate: float) -> Callable[[Array], Array]:
    return lambda t: place + start * np.exp(-rate * t)


@pytest.mark.parametrize("p", [CASE_1, CASE_2])
@pytest.mark.parametrize("wrap", [False, True])
def test_a_settled_phase_is_synchronised_also_at_the_cut(p: RotorPendulum, wrap: bool) -> None:
    rate = RATE[p]
    for place in (STABLE[p], np.pi if p is CASE_1 else 0.0):
        for start in (0.0, 1.0, -1.0):
            times, values = synthetic(settling(place, start, rate), 8.5 / rate)
            if wrap:
                values |= {name: wrapped(values[name]) for name in ("phi_1", "phi_2")}
            assert outcome(times, values, p) == "synchronised"


@pytest.mark.parametrize("p", [CASE_1, CASE_2])
def test_a_short_look_is_undecided(p: RotorPendulum) -> None:
    rate = RATE[p]
    times, values = synthetic(lambda t: STABLE[p], 7.9 / rate)
    assert outcome(times, values, p) == "undecided"
    assert outcome(times[:1], {name: row[:1] for name, row in values.items()}, p) == "undecided"


@pytest.mark.parametrize("distance", [0.0, 1e-12, 1e-8, 1e-6, 1e-4, 1e-3, 1e-2, 0.1])
@pytest.mark.parametrize("p", [CASE_1, CASE_2])
def test_leaving_the_unstable_phase_is_not_settling(p: RotorPendulum, distance: float) -> None:
    rate = RATE[p]
    unstable = STABLE[p] + np.pi

    def escape(t: Array) -> Array:
        return unstable + 2 * np.arctan(np.tan(distance / 2) * np.exp(rate * t))

    for look in (8.2, 10.0, 12.0, 14.0, 30.0):
        times, values = synthetic(escape, look / rate)
        missing = np.pi - (escape(times[-1:])[0] - unstable)
        verdict = outcome(times, values, p)
        assert verdict in ("synchronised", "undecided")
        assert verdict == "undecided" or missing < 0.01
        assert verdict == "synchronised" or missing > 1e-4


@pytest.mark.parametrize("slips_per_second", [0.3, 1.0, 5.0, 20.0])
def test_slipping_rotors_are_not_synchronised(slips_per_second: float) -> None:
    times, values = synthetic(lambda t: 2 * np.pi * slips_per_second * t, 12 / RATE[CASE_2])
    verdict = outcome(times, values, CASE_2)
    assert verdict == ("not synchronised" if slips_per_second >= 1 else "undecided")


def passing(narrow: float, rate: float) -> Callable[[Array], Array]:
    """Return the phase of ``alpha' = rate (narrow^2 + alpha^2) / 2``."""
    return lambda t: STABLE[CASE_2] + narrow * np.tan(narrow * rate * t / 2 - 1.5)


def test_a_slow_passage_between_slips_is_undecided() -> None:
    rate = RATE[CASE_2]
    for narrow in (0.003, 0.01, 0.1):
        times, values = synthetic(passing(narrow, rate), 20 / rate)
        assert outcome(times, values, CASE_2) != "synchronised"


def test_what_came_before_the_watch_does_not_count() -> None:
    """Rotors that stood still until a hundredth of the run, which is twice as long as the watch."""
    times, values = synthetic(lambda t: STABLE[CASE_2], 16 / RATE[CASE_2])
    started = {name: np.where(times > 0.01 * times[-1], row, 0) for name, row in values.items()}
    assert outcome(times, started, CASE_2) == "synchronised"


def test_rotors_at_rest_are_not_synchronised() -> None:
    """As after a reset; whether once, at the end, or again and again."""
    rate = RATE[CASE_2]
    times, values = synthetic(lambda t: STABLE[CASE_2], 9 / rate)
    still = {name: 0 * row for name, row in values.items()}
    assert outcome(times, still, CASE_2) == "not synchronised"
    assert outcome(times[times < 1], {k: v[times < 1] for k, v in still.items()}, CASE_2) == (
        "not synchronised"
    )
    for begin in (0.5, 0.99):
        reset = {k: np.where(times < begin * times[-1], v, 0) for k, v in values.items()}
        assert outcome(times, reset, CASE_2) == "not synchronised"
    one = values | {"phi_2": still["phi_2"], "phi_2_dot": still["phi_2_dot"]}
    assert outcome(times, one, CASE_2) == "not synchronised"
    assert outcome(times[:20], {k: v[:20] for k, v in still.items()}, CASE_2) == "undecided"


def test_a_reset_in_the_watch_is_seen() -> None:
    rate = RATE[CASE_2]
    times, values = synthetic(lambda t: STABLE[CASE_2], 9 / rate)
    shift = np.where(times > 0.7 * times[-1], 1.3, 0.0)
    both = values | {name: values[name] + shift for name in ("phi_1", "phi_2")}
    assert outcome(times, both, CASE_2) == "undecided"
    period = 0.05  # from rest again and again, both rotors alike: phase 0, equal speeds
    since = times % period
    start = SPEED * (1 - np.exp(-192 * since))
    turned = SPEED * (since - (1 - np.exp(-192 * since)) / 192)
    again = {"phi_1": turned, "phi_2": turned - STABLE[CASE_2]}
    again |= {"phi_1_dot": start, "phi_2_dot": start}
    assert outcome(times, again, CASE_2) != "synchronised"


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("where", [0, -1, slice(None)])
def test_what_is_not_finite_is_undecided(bad: float, where: Any) -> None:
    times, values = synthetic(lambda t: STABLE[CASE_2], 9 / RATE[CASE_2])
    for name in values:
        broken = values[name].copy()
        broken[where] = bad
        assert outcome(times, values | {name: broken}, CASE_2) == "undecided"


def test_too_few_samples_are_undecided() -> None:
    for per_turn in (1, 2, 5):  # one sample per turn shows a turning rotor standing still
        times, values = synthetic(lambda t: STABLE[CASE_2], 9 / RATE[CASE_2], per_turn, 0.0)
        assert outcome(times, values, CASE_2) == "undecided"


def test_motors_off_are_not_judged() -> None:
    times, values = synthetic(lambda t: STABLE[CASE_2], 9 / RATE[CASE_2])
    assert outcome(times, values, SCENE.unforced(CASE_2)) == "undecided"


def test_mean_phase_is_on_the_circle() -> None:
    assert mean_phase(np.array([3.0, -3.0])) == pytest.approx(np.pi)
    assert mean_phase(np.array([2 * np.pi - 0.1, 0.1])) == pytest.approx(0, abs=1e-15)
    assert wrapped(-np.pi) == np.pi
    assert wrapped(7 * np.pi) == pytest.approx(np.pi)
    assert LEAST_TURNS >= 4

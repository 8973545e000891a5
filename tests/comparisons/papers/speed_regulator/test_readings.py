"""What readings of the speed_regulator paper give, computed anew: the texts of the ledger hold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbcheck.comparisons.engines.registry import REFERENCE
from mbcheck.comparisons.papers.ledger import rounds_to
from mbcheck.comparisons.papers.speed_regulator.readings import READINGS
from mbcheck.comparisons.papers.speed_regulator.results import (
    DAMPINGS,
    EXAMPLE,
    SCENE,
    TORQUE,
    damped,
    points,
)
from mbcheck.comparisons.papers.speed_regulator.rows import PRINTED_SPEED, ROWS
from mbcheck.comparisons.queries.frequencies import frequencies
from mbcheck.comparisons.scenes.speed_regulator.limit_cycles import REGIMES, theory_regimes
from mbcheck.reference import get_scene
from mbcheck.reference.scene import Array
from mbcheck.reference.speed_regulator import theory
from mbcheck.reference.speed_regulator.equations import SpeedRegulator
from mbcheck.reference.speed_regulator.rest import found_equilibria
from mbcheck.reference.speed_regulator.theory import least_torque, printed_mean_speed, rotation
from mbcheck.tests.support.papers.shared import holds

BY_NAME = {row.name: row for row in READINGS}
SLOW = pytest.mark.slow
REST = REGIMES.index("rest")
BISECTIONS = 18


def least_torques(sets: Sequence[SpeedRegulator]) -> Array:
    """Return the least torque [N m] of a rotation of each set, to four digits, by bisection."""
    rows = {name: np.array([getattr(p, name) for p in sets]) for name in SpeedRegulator.names()}
    high = np.array([max(theory.saddle_node_torques(p).values(), default=0.0) for p in sets])
    low = np.zeros(len(sets))
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        turns = theory_regimes(points(REFERENCE, **(rows | {"torque": middle}))) != REST
        low, high = np.where(turns, low, middle), np.where(turns, middle, high)
    return high


def candidates_of(sets: Sequence[SpeedRegulator]) -> list[str]:
    """Return what parameters give: the mean speed, and the least torque of a rotation."""
    words = []
    for p, torque in zip(sets, least_torques(sets), strict=True):
        speed = f"{rotation(p).mean_speed:.4f} rad/s" if p.torque > torque else "no rotation"
        words.append(f"{speed}; least torque of a rotation {torque:.4f} N m")
    return words


@SLOW
def test_least_torques_are_the_theorys_to_four_digits() -> None:
    ours, other = least_torques([EXAMPLE, EXAMPLE.replace(stiffness=8.0, damping=5.0)])
    assert ours == pytest.approx(least_torque(EXAMPLE).torque, rel=2e-4)
    assert other > ours


@SLOW
def test_missing_parameters() -> None:
    smaller = EXAMPLE.replace(
        crank_radius=0.1, rod_length=0.5, spring_rest=-0.5, torque=0.0512, stiffness=32.0
    )
    sets = [
        EXAMPLE,
        EXAMPLE.replace(flywheel_inertia=8.0),
        EXAMPLE.replace(flywheel_inertia=0.5),
        EXAMPLE.replace(rod_mass=2.0, slider_mass=4.0),
        EXAMPLE.replace(stiffness=8.0),
        EXAMPLE.replace(stiffness=128.0),
        smaller,
        smaller.replace(stiffness=200.0),
    ]
    holds(BY_NAME["missing_parameters"], candidates_of(sets))


def test_what_the_printed_speed_fixes() -> None:
    ours = EXAMPLE.torque / (EXAMPLE.damping * EXAMPLE.rod_length**2)
    average = ours / float(printed_mean_speed(EXAMPLE))
    low, high = 5.065 * average, 5.075 * average
    assert low < ours < high
    words = f"between {low:.5f} and {high:.5f} 1/s by (21), ours is {ours:.5f} 1/s"
    assert words in BY_NAME["missing_parameters"].reason


def test_damper_of_figure_4() -> None:
    words = []
    for c in DAMPINGS:
        cycle = rotation(damped(c, torque=EXAMPLE.torque * c / EXAMPLE.damping))
        words.append(
            f"{cycle.mean_speed:.4f} rad/s, multiplier {cycle.multiplier:.4f}, half of a deviation "
            f"gone in {-np.log(2) / np.log(cycle.multiplier):.0f} turns"
        )
    holds(BY_NAME["damper_of_figure_4"], words)


@SLOW
def test_reference_of_the_spring() -> None:
    r, l = EXAMPLE.crank_radius, EXAMPLE.rod_length
    places = (-l, -(r + l), -float(np.sqrt(l**2 - r**2)), 0.0)
    sets = [EXAMPLE.replace(spring_rest=place) for place in places]
    words = []
    for p, text in zip(sets, candidates_of(sets), strict=True):
        rests: Mapping[str, float] = found_equilibria(p)
        listed = ", ".join(f"{name} {angle:.2f}" for name, angle in rests.items())
        words.append(f"{text}; equilibria [rad]: {listed}")
    holds(BY_NAME["spring_reference"], words)
    assert rounds_to(rotation(EXAMPLE).mean_speed, PRINTED_SPEED)


@SLOW
def test_braking_of_figure_6() -> None:
    sets = [
        damped(4.0, torque=0.04),
        damped(2.0, torque=0.0),
        damped(14.0),
        damped(8.0),
        damped(4.0),
    ]
    holds(BY_NAME["braking_of_figure_6"], candidates_of(sets))


@SLOW
def test_axes_of_figure_3() -> None:
    dampers = (1.0, *DAMPINGS, 8.0)
    words = []
    for c, least in zip(dampers, least_torques([damped(c) for c in dampers]), strict=True):
        p = [damped(c, torque=torque) for torque in (2 * float(least), TORQUE[1])]
        off = [float(printed_mean_speed(item)) / rotation(item).mean_speed - 1 for item in p]
        words.append(
            f"begins at {least:.4f} N m; (21) off by {off[0]:+.1%} at twice that, {off[1]:+.2%} "
            f"at {TORQUE[1]:g} N m"
        )
    holds(BY_NAME["axes_of_figure_3"], words)


@SLOW
def test_tolerance_of_the_solver() -> None:
    """As far as they do not hang on the last bits of the start, which coarse tolerances blow up."""
    derivative = get_scene(SCENE).right_hand_side(EXAMPLE)
    times = np.array([200.0, 240.0])
    starts = 6.0 * (1 + 1e-14 * np.arange(5))
    speeds, spreads = [], []
    for method in ("RK45", "RK23"):
        for tolerance in (1e-3, 1e-4, 1e-6):
            ends = [
                solve_ivp(
                    derivative,
                    (0, times[1]),
                    [0.0, start],
                    method,
                    times,
                    rtol=tolerance,
                    atol=1e-6,
                ).y[0]
                for start in starts
            ]
            found = np.ptp(ends, axis=1) / np.ptp(times)
            speeds.append(float(found[0]))
            spreads.append(float(np.ptp(found)))
    row = BY_NAME["tolerance_of_the_solver"]
    told = [float(text.split()[0]) for text in row.candidates.values()]
    sharp = np.array(spreads) < 1e-3
    np.testing.assert_array_equal(sharp, [False, False, True, False, True, True])
    np.testing.assert_allclose(np.array(told)[sharp], np.array(speeds)[sharp], atol=2e-4)
    assert rounds_to(speeds[2], PRINTED_SPEED)


def test_starts_of_figure_4() -> None:
    starts = [(phi, speed) for speed in (0.0, 0.6, 0.8, 2.0, 8.0) for phi in (0.0, np.pi)]
    holds(BY_NAME["starts_of_figure_4"], [end_of(*start) for start in starts])


def end_of(phi: float, speed: float) -> str:
    """Return what the example does from a start: whether it comes round three times."""
    derivative = get_scene(SCENE).right_hand_side(EXAMPLE)

    def back(t: float, x: Array) -> float:
        return float(x[1]) + 1e-12

    def round_(t: float, x: Array) -> float:
        return float(x[0]) - phi - 6 * np.pi

    back.terminal = round_.terminal = True  # type: ignore[attr-defined]
    back.direction = -1  # type: ignore[attr-defined]
    run = solve_ivp(derivative, (0, 200), [phi, speed], "DOP853", events=[back, round_])
    return "rotation" if len(run.t_events[1]) else "rest"


def test_vibrations_about_rest() -> None:
    words = ", ".join(
        f"{name} {frequencies(SCENE, about=name, engine=REFERENCE).modes[0].omega:.3f} rad/s"
        for name in ("right", "left")
    )
    (row,) = (row for row in ROWS if row.name == "resonance")
    assert row.reference == words
    assert row.reason.endswith(words)

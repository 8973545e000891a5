"""Rotations of speed_regulator near the homoclinic torque, and the budget of their theory."""

from __future__ import annotations

import pytest

from mbcheck.reference.cost import within
from mbcheck.reference.errors import UsageError
from mbcheck.reference.orbits import find_orbit
from mbcheck.reference.speed_regulator import SCENE, theory
from mbcheck.reference.speed_regulator.equations import SpeedRegulator

DEFAULT = SpeedRegulator()


@pytest.mark.parametrize(
    ("torque", "period"), [(0.055, 11.1256656), (0.053, 14.9408182), (0.05262, 21.7068219)]
)
def test_a_slow_rotation_near_the_homoclinic_torque_is_found(torque: float, period: float) -> None:
    """From a guess of the state it is not: errors grow by 3000 in the period of the last one."""
    orbit = find_orbit(SCENE, DEFAULT.replace(torque=torque))
    assert orbit.stable
    assert orbit.period == pytest.approx(period, abs=1e-7)


@pytest.mark.slow
def test_a_slow_rotation_in_gravity_is_found() -> None:
    """By motions over long times alone, the last turn of which is timed over the crank angle."""
    orbit = find_orbit(SCENE, DEFAULT.replace(torque=0.055, gravity_x=1e-9))
    assert orbit.period == pytest.approx(11.1256656, abs=1e-6)


def test_a_crank_that_creeps_ends_with_the_budget() -> None:
    """Strong damping takes an explicit method more steps than anyone waits for."""
    p = DEFAULT.replace(damping=1e6, torque=1.1)
    with pytest.raises(UsageError, match="budget"), within(0.01):
        theory.rotation(p)

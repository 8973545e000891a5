"""The homoclinic limit of the speed_regulator as a curve, against motions in time."""

from __future__ import annotations

import math

import pytest

from mbcheck.reference.speed_regulator.equations import SpeedRegulator
from mbcheck.reference.speed_regulator.homoclinic import FINE, homoclinic_limit, orbit_of
from mbcheck.reference.speed_regulator.theory import (
    Threshold,
    least_torque,
    rotates,
    saddle_node_torques,
)


@pytest.mark.parametrize("changes", [{"damping": 2.0}, {"damping": 20.0, "stiffness": 8.0}])
def test_the_limit_is_where_rotations_begin(changes: dict[str, float]) -> None:
    """Motions in time know on which side of it they are, a hundred bounds away and far off."""
    p = SpeedRegulator(**changes)
    limit = homoclinic_limit(p)
    assert limit is not None
    assert limit.error < 1e-8 * limit.torque
    for room in (max(100 * limit.error, 1e-9 * limit.torque), 1e-3 * limit.torque):
        assert rotates(p.replace(torque=limit.torque + room))
        assert not rotates(p.replace(torque=limit.torque - room))


@pytest.mark.slow
@pytest.mark.parametrize("damping", [1.0, 8.0, 40.0])
def test_the_limit_is_that_of_the_bisection_in_time(damping: float) -> None:
    p = SpeedRegulator(damping=damping)
    limit, other = homoclinic_limit(p), least_torque(p)
    assert limit is not None
    assert isinstance(other, Threshold)
    assert abs(limit.torque - other.torque) <= limit.error + other.error
    assert abs(limit.torque - other.torque) < 1e-10  # far below the bisection's bound


def test_the_upper_saddle_has_no_orbit_past_the_lower_one() -> None:
    p = SpeedRegulator()
    assert orbit_of(p, "top", FINE) != orbit_of(p, "top", FINE)  # NaN


def test_a_strong_damper_has_no_homoclinic_orbit() -> None:
    """The rotation then begins as the last saddle vanishes."""
    assert homoclinic_limit(SpeedRegulator(damping=64.0)) is None
    assert homoclinic_limit(SpeedRegulator(stiffness=0.0)) is None


@pytest.mark.slow
def test_the_homoclinic_limit_meets_the_saddle_node_at_52_69() -> None:
    """Just below the torque at which the saddle vanishes there is a rotation up to there."""
    p = SpeedRegulator()
    last = max(saddle_node_torques(p).values())
    near = {c: rotates(p.replace(damping=c, torque=last * (1 - 1e-8))) for c in (52.68, 52.70)}
    assert near == {52.68: True, 52.70: False}


def test_a_limit_that_is_found_once_has_no_bound() -> None:
    limit = homoclinic_limit(SpeedRegulator(damping=52.5))
    assert limit is not None
    assert limit.torque > 0
    assert limit.error == math.inf

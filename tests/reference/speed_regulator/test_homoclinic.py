"""The homoclinic limit of the speed_regulator as a curve, against whole turns."""

from __future__ import annotations

import math

import pytest

from mbcheck.reference.speed_regulator.equations import SpeedRegulator
from mbcheck.reference.speed_regulator.theory import (
    least_torque,
    orbit_of,
    rotates,
    saddle_node_torques,
)


@pytest.mark.parametrize("changes", [{"damping": 2.0}, {"damping": 20.0, "stiffness": 8.0}])
def test_the_limit_is_where_rotations_begin(changes: dict[str, float]) -> None:
    """Whole turns know on which side of it they are, a hundred bounds away and far off."""
    p = SpeedRegulator(**changes)
    limit = least_torque(p)
    assert limit.error < 1e-8 * limit.torque
    for room in (max(100 * limit.error, 1e-9 * limit.torque), 1e-3 * limit.torque):
        assert rotates(p.replace(torque=limit.torque + room))
        assert not rotates(p.replace(torque=limit.torque - room))


def test_the_upper_saddle_has_no_orbit_past_the_lower_one() -> None:
    p = SpeedRegulator()
    assert orbit_of(p, "top", True) != orbit_of(p, "top", True)  # NaN


def test_without_a_spring_any_torque_turns_the_crank() -> None:
    assert least_torque(SpeedRegulator(stiffness=0.0)).torque == 0


@pytest.mark.slow
def test_the_homoclinic_limit_meets_the_saddle_node_at_52_69() -> None:
    """Just below the torque at which the saddle vanishes there is a rotation up to there."""
    p = SpeedRegulator()
    last = max(saddle_node_torques(p).values())
    near = {c: rotates(p.replace(damping=c, torque=last * (1 - 1e-8))) for c in (52.68, 52.70)}
    assert near == {52.68: True, 52.70: False}


def test_a_limit_that_is_found_once_has_no_bound() -> None:
    limit = least_torque(SpeedRegulator(damping=52.5))
    assert limit.torque > 0
    assert limit.error == math.inf

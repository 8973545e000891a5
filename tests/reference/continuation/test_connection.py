"""Homoclinic orbits by a condition in time, against shooting over the crank angle."""

from __future__ import annotations

import numpy as np
import pytest

from mbcheck.reference import get_scene
from mbcheck.reference.continuation.along import ConnectionAlong
from mbcheck.reference.errors import NoOrbitError
from mbcheck.reference.scene import Array
from mbcheck.reference.speed_regulator.theory import least_torque

REGULATOR = get_scene("speed_regulator")


def sought(
    damping: float, torque: float, rest: str = "bottom", offset: float = 0.01
) -> ConnectionAlong:
    p = REGULATOR.parameters().replace(damping=damping, torque=torque)
    return ConnectionAlong(REGULATOR, p, "homoclinic", "torque", rest, offset)


def found(along: ConnectionAlong) -> tuple[float, float]:
    """Return the torque, and its bound [N m]."""
    point = along.solution[1]
    return along.value(point.z[-1]), along.unit * point.bound[1]


@pytest.mark.slow
@pytest.mark.parametrize(("damping", "torque"), [(2.0, 0.0525), (20.0, 0.515)])
def test_the_torque_is_that_of_shooting_over_the_angle(damping: float, torque: float) -> None:
    """But for what straight directions of the saddle leave, the third power of the distance."""
    along = sought(damping, torque)
    limit = least_torque(along.parameters)
    off = []
    for offset in (0.02, 0.01):
        value, bound = found(sought(damping, torque, offset=offset))
        assert bound < 1e-11
        off.append(value / limit.torque - 1)
    assert 0 < off[1] < 4e-7
    assert off[0] / off[1] == pytest.approx(8, rel=0.05)


@pytest.mark.slow
def test_it_does_not_depend_on_where_it_is_sought_from() -> None:
    (one, bound), (other, its) = found(sought(2.0, 0.0525)), found(sought(2.0, 0.0523))
    assert bound + its < 1e-11
    assert abs(one - other) < bound + its


def test_where_there_is_none_it_says_so() -> None:
    """A position of rest that is stable; a torque by which nothing comes round; steps astray."""
    with pytest.raises(NoOrbitError, match="'right' of speed_regulator is no saddle"):
        _ = sought(2.0, 0.0525, "right").solution
    with pytest.raises(NoOrbitError, match="no motion from the saddle"):
        _ = sought(2.0, 0.03).solution
    along = sought(2.0, 0.0525)

    def nowhere(p: object, state: Array) -> Array:
        return state + 1.0

    assert along.root(nowhere, 0.5, slope=1.0) is None
    assert along.root(lambda p, state: np.full(2, np.nan), 0.5) is None

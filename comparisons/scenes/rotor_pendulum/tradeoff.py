"""What models of `rotor_pendulum` may leave out."""

from __future__ import annotations

from ....models.rotor_pendulum.mjcf import INERTIA_FLOOR
from ....reference.rotor_pendulum import SCENE
from ...checks.truth import permitted_horizon
from ...faults.variants import EXUDYN, MUJOCO
from ..tradeoff import LeftOutRows, PairNumbers, inertia_floor, redundant, without_solver

STARTUP = SCENE.case("case_2_startup")


def floor() -> PairNumbers:
    """Bound what the least inertia of MuJoCo changes; the equations have no such inertia."""
    p = STARTUP.parameters
    share = INERTIA_FLOOR / (p.rotor_mass * p.eccentricity**2)
    compared = f"none, the floor of {INERTIA_FLOOR:g} kg m^2: a bound, its share times growth"
    return inertia_floor(STARTUP, compared, share * max(1.0, permitted_horizon(STARTUP)[1]))


LEFT_OUT: LeftOutRows = {
    MUJOCO: (floor, without_solver(STARTUP, 0.5)),
    EXUDYN: redundant(STARTUP, "kinematic_tree", 0.5),
}

"""Cases of `speed_regulator`."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..parameters import BoundarySearch
from ..scene import Case
from .equations import SpeedRegulator
from .rest import equilibrium

DEFAULT = SpeedRegulator()
CONSERVATIVE = DEFAULT.replace(torque=0.0, damping=0.0)
MASSLESS = DEFAULT.replace(rod_mass=0.0, slider_mass=0.0)
LONG_CRANK = DEFAULT.replace(crank_radius=0.4, rod_length=0.5, spring_rest=-0.5, torque=1.5)
SWINGING = CONSERVATIVE.replace(gravity_x=4.0, gravity_y=-9.0)
HEAVY_ROD = DEFAULT.replace(rod_mass=3.0, slider_mass=0.2, flywheel_inertia=0.5, torque=0.6)
WEIGHED = DEFAULT.replace(gravity_x=4.0, gravity_y=-9.0)
STRETCHED = DEFAULT.replace(spring_rest=-1.1, stiffness=80.0, torque=0.5)
COEXISTENCE = DEFAULT.replace(flywheel_inertia=0.25, torque=0.4)
ROTATING = {"phi_dot": 5.07}
FREE_RUN = ("algebra", "trajectory", "order")


def _case(
    name: str, p: SpeedRegulator, state: dict[str, float], horizon: float, *kinds: str
) -> Case:
    return Case("speed_regulator", name, p, state, horizon, kinds)


def _full(
    name: str, p: SpeedRegulator, state: dict[str, float], horizon: float, *kinds: str
) -> Case:
    return replace(_case(name, p, state, horizon, *kinds), full_only=True)


def _ending(name: str, state: dict[str, float], horizon: float) -> Case:
    case = _case(name, COEXISTENCE, state, horizon, "stability")
    return replace(case, watch="outcome", methods="best")


CASES = (
    _case("rotation", DEFAULT, ROTATING, 2.0, *FREE_RUN),
    _case("startup", DEFAULT, {"phi": 0.5}, 2.0, "trajectory"),
    _case("dead_centre", DEFAULT, {"phi": np.pi / 2, **ROTATING}, 1.0, "trajectory"),
    _case("conservative", CONSERVATIVE, {"phi_dot": 2.0}, 2.0, "trajectory", "energy"),
    _case("massless_rod_and_slider", MASSLESS, ROTATING, 2.0, "algebra", "trajectory"),
    _case("long_crank", LONG_CRANK, {"phi_dot": 6.0}, 1.0, "algebra", "trajectory"),
    replace(_case("opened_loop", DEFAULT, ROTATING, 1.0, "trajectory"), inconsistency={"y": 1e-3}),
    _case("limit_cycle", DEFAULT, ROTATING, 1.25, "stability"),
    _full("limit_cycle_c4", DEFAULT.replace(damping=4.0), ROTATING, 1.25, "stability"),
    replace(
        _full("least_torque", DEFAULT.replace(torque=0.0525), ROTATING, 1.25, "stability"),
        boundary=BoundarySearch("homoclinic", "torque", 4.7),
    ),
    _ending("settles_to_rest", {"phi_dot": 1.0}, 30.0),
    _ending("settles_to_rotation", {"phi_dot": 5.0}, 30.0),
    replace(_case("weighed", WEIGHED, ROTATING, 0.5, "algebra", "trajectory"), methods="best"),
    replace(_case("swinging", SWINGING, ROTATING, 0.5, "energy"), methods="best"),
    _full("heavy_rod", HEAVY_ROD, ROTATING, 2.0, *FREE_RUN),
    _full("stretched_spring", STRETCHED, {"phi": 2.0, "phi_dot": 4.0}, 2.0, *FREE_RUN),
    *(
        _case(f"rest_{name}", DEFAULT, equilibrium(name, DEFAULT), 0.5, "frequency")
        for name in ("right", "top", "left")
    ),
)

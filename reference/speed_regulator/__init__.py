"""The scene `speed_regulator`."""

from __future__ import annotations

from functools import partial

import numpy as np

from ..parameters import BoundarySearch
from ..scene import Paper, PeriodicOrbit, Scene, case_maker, with_placements
from .equations import (
    UNITS,
    SpeedRegulator,
    accelerations,
    assembled,
    coefficients,
    damping_matrix,
    energy,
    forces,
    mass_matrix,
    outputs,
    powers,
)
from .motions import (
    EQUILIBRIA,
    ORBIT_UNITS,
    equilibrium,
    orbit_guesses,
    orbit_quantities,
    outcome,
    period,
)
from .theory import cycle_start, torque_limit

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


case = case_maker("speed_regulator")

CASES = (
    case("rotation", DEFAULT, ROTATING, 2.0, *FREE_RUN),
    case("startup", DEFAULT, {"phi": 0.5}, 2.0, "trajectory"),
    case("dead_centre", DEFAULT, {"phi": np.pi / 2, **ROTATING}, 1.0, "trajectory"),
    case("conservative", CONSERVATIVE, {"phi_dot": 2.0}, 2.0, "trajectory", "energy"),
    case("massless_rod_and_slider", MASSLESS, ROTATING, 2.0, "algebra", "trajectory"),
    case("long_crank", LONG_CRANK, {"phi_dot": 6.0}, 1.0, "algebra", "trajectory"),
    case("opened_loop", DEFAULT, ROTATING, 1.0, "trajectory", inconsistency={"y": 1e-3}),
    case("limit_cycle", DEFAULT, ROTATING, 1.25, "stability"),
    case(
        "limit_cycle_c4", DEFAULT.replace(damping=4.0), ROTATING, 1.25, "stability", full_only=True
    ),
    case(
        "least_torque",
        DEFAULT.replace(torque=0.0525),
        ROTATING,
        1.25,
        "stability",
        full_only=True,
        boundary=BoundarySearch("homoclinic", "torque", "bottom"),
    ),
    *(
        case(
            f"settles_to_{end}",
            COEXISTENCE,
            {"phi_dot": speed},
            30.0,
            "stability",
            watch="outcome",
            methods="best",
        )
        for end, speed in (("rest", 1.0), ("rotation", 5.0))
    ),
    case("weighed", WEIGHED, ROTATING, 0.5, "algebra", "trajectory", methods="best"),
    case("swinging", SWINGING, ROTATING, 0.5, "energy", methods="best"),
    case("heavy_rod", HEAVY_ROD, ROTATING, 2.0, *FREE_RUN, full_only=True),
    case(
        "stretched_spring", STRETCHED, {"phi": 2.0, "phi_dot": 4.0}, 2.0, *FREE_RUN, full_only=True
    ),
    *(
        case(f"rest_{name}", DEFAULT, equilibrium(name, DEFAULT), 0.5, "frequency")
        for name in ("right", "top", "left")
    ),
)


SCENE = Scene(
    name="speed_regulator",
    title="speed regulator: a slider-crank with a sprung and damped slider",
    paper=Paper(
        "S. Vlase, M. Mihalcica, M. L. Scutaru",
        "Determining the Functional Parameters of a Simple Speed Regulator",
        "",
        2018,
        "",
    ),
    parameters=SpeedRegulator,
    coordinates=("phi",),
    units=UNITS,
    coefficients=coefficients,
    mass_matrix=mass_matrix,
    forces=forces,
    accelerations=accelerations,
    damping_matrix=damping_matrix,
    energy=energy,
    powers=powers,
    equilibria={name: partial(equilibrium, name) for name in EQUILIBRIA},
    rotations_per_period={"phi": 1},
    period=period,
    orbit=PeriodicOrbit(
        orbit_guesses,
        "phi",
        orbit_quantities,
        ORBIT_UNITS,
        limit=("torque", torque_limit),
        known=cycle_start,
    ),
    cases=CASES,
    placed=with_placements(CASES[0], "algebra", "trajectory"),
    outputs=outputs,
    observed=("y", "y_dot"),
    invariants=lambda p: {"energy": energy},
    outcome=outcome,
    assembled=assembled,
)

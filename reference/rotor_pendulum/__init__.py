"""The scene `rotor_pendulum`, and the paper's reduced equations beside it."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from ..parameters import BoundarySearch
from ..scene import Paper, PeriodicOrbit, Scene, case_maker, with_placements, with_rates
from .equations import (
    RotorPendulum,
    accelerations,
    coefficients,
    damping_matrix,
    energy,
    forces,
    invariants,
    mass_matrix,
    period,
    powers,
    rest,
    unforced,
)
from .outcome import outcome
from .phase import ORBIT_UNITS, orbit_guesses, orbit_quantities

CASE_1 = RotorPendulum()
CASE_2 = RotorPendulum(platform_stiffness=65969.0, rod_stiffness=1053.0)
CASE_3 = CASE_2.replace(installation_angle=np.pi / 2)
RELATIVE = CASE_2.replace(motor_placement="relative")
CONSERVATIVE = unforced(CASE_2).replace(platform_damping=0.0, rod_damping=0.0)
FREE = CONSERVATIVE.replace(platform_stiffness=0.0)
SPINNING = {
    "x": 0.01,
    "phi_1": 0.3,
    "phi_2": -0.8,
    "phi_3": 0.2,
    "x_dot": 0.5,
    "phi_1_dot": 40.0,
    "phi_2_dot": 30.0,
    "phi_3_dot": -2.0,
}
STEEP = CASE_2.replace(installation_angle=1.1)
WEIGHED = CASE_2.replace(gravity_x=6.0, gravity_y=-8.0)
SWINGING = CONSERVATIVE.replace(gravity_x=6.0, gravity_y=-8.0)
AT_SPEED = {"phi_1_dot": 153.8, "phi_2_dot": 153.8}


case = case_maker("rotor_pendulum")

CASES = (
    case("case_1_startup", CASE_1, {}, 1.0, "algebra", "trajectory", methods="best"),
    case("case_2_startup", CASE_2, {}, 1.0, "algebra", "trajectory", "order"),
    case("case_3_startup", CASE_3, {}, 1.0, "algebra", "trajectory", "order", methods="best"),
    case("relative_motor", RELATIVE, {}, 0.25, "algebra", "trajectory", methods="best"),
    case("conservative", CONSERVATIVE, SPINNING, 0.2, "energy"),
    case("free_platform", FREE, SPINNING, 0.2, "energy", methods="best"),
    case("weighed", WEIGHED, SPINNING, 0.2, "algebra", "trajectory", methods="best"),
    case("swinging", SWINGING, SPINNING, 0.2, "energy", methods="best"),
    case("hanging", SWINGING, {}, 0.5, "frequency", about="rest"),
    case("modes_at_rest", CASE_1, {}, 0.5, "frequency", about="rest"),
    case("modes_at_speed", CASE_1, {}, 0.5, "frequency", about="synchronous"),
    case("case_1_synchronous", CASE_1, {}, 0.5, "stability", methods="best"),
    case("case_2_synchronous", CASE_2, {}, 0.5, "stability"),
    case(
        "fold_of_synchronism",
        STEEP,
        {},
        0.5,
        "stability",
        boundary=BoundarySearch("fold", "installation_angle"),
    ),
    case(
        "case_2_settles",
        CASE_2,
        {"phi_1": 1.06, **AT_SPEED},
        5.5,
        "stability",
        watch="outcome",
        methods="best",
    ),
    case(
        "case_1_antiphase_settles",
        CASE_1,
        {"phi_1": -2.13, **AT_SPEED},
        10.5,
        "stability",
        watch="outcome",
        methods="best",
        full_only=True,
    ),
)
"""The synchronous motion of case 2 ends at an installation angle of 1.114, where it meets an
unstable one (a fold). The last two start one radian off the stable phase difference, 0.064 and
-3.129 rad, with the rotors at speed; they last a little longer than `outcome` must watch them. No
case of section 5.2 is watched from rest: in case 1 both rotors start beside the unstable phase."""


SCENE = Scene(
    name="rotor_pendulum",
    title="synchronising rotors on a platform and a pendulum rod",
    paper=Paper(
        "P. Fang, Y. Hou, Y. Nan, L. Yu",
        "Study of synchronization for a rotor-pendulum system with Poincare method",
        "Journal of Vibroengineering 17(5)",
        2015,
        "",  # the journal gave none then
        "www.extrica.com/article/15915",
    ),
    parameters=RotorPendulum,
    coordinates=("x", "phi_1", "phi_2", "phi_3"),
    units=with_rates(x="m", phi_1="rad", phi_2="rad", phi_3="rad"),
    coefficients=coefficients,
    mass_matrix=mass_matrix,
    forces=forces,
    accelerations=accelerations,
    damping_matrix=damping_matrix,
    energy=energy,
    powers=powers,
    equilibria={name: partial(rest, name) for name in ("synchronous", "rest")},
    steady_coordinates={"synchronous": ("phi_1", "phi_2")},
    rotations_per_period={"phi_1": 1, "phi_2": 1},
    period=period,
    orbit=PeriodicOrbit(orbit_guesses, "phi_1", orbit_quantities, ORBIT_UNITS),
    unforced=unforced,
    invariants=invariants,
    outcome=outcome,
    cases=CASES,
    placed=with_placements(CASES[3], "algebra", "trajectory"),
)

REDUCED = replace(
    SCENE,
    title="the same, equations (11): B -> beta after deriving",
    mass_matrix=lambda q, c, xp=np: mass_matrix(q, c, xp, c.beta),
    forces=lambda u, q, v, c, xp=np: forces(u, q, v, c, xp, c.beta),
    accelerations=lambda u, q, v, c, xp=np: accelerations(u, q, v, c, xp, c.beta),
)
"""The paper's (11), the sign in its fourth line corrected. Its energy is that of the exact
equations, which it does not conserve; no other quadratic form of these M is conserved either."""

SCENE = replace(SCENE, variants={"reduced": REDUCED})

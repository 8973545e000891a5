"""Cases of `rigid_body`."""

from __future__ import annotations

from ..scene import case_maker
from .equations import RigidBody

HEAVY = RigidBody()
WEIGHTLESS = HEAVY.replace(gravity_z=0.0)
FREE = WEIGHTLESS.replace(centre_x=0.0, centre_y=0.0, centre_z=0.0)
ALIGNED = FREE.replace(axes_x=0.0, axes_y=0.0, axes_z=0.0)
LAGRANGE = HEAVY.replace(
    centre_x=0.0, centre_y=0.0, axes_x=0.0, axes_y=0.0, axes_z=0.0, moment_2=0.004, moment_3=0.005
)
KOVALEVSKAYA = LAGRANGE.replace(
    mass=1.0, centre_x=0.1, centre_z=0.0, moment_1=0.05, moment_2=0.04, moment_3=0.015
)
TILTED = {"q_w": 0.9, "q_x": 0.3, "q_y": -0.3, "q_z": 0.1}  # of length 1
TUMBLING = {"omega_x": 6.0, "omega_y": -4.0, "omega_z": 9.0}
SPINNING = {"q_w": 0.96, "q_x": 0.28, "omega_x": 0.5, "omega_y": 1.0, "omega_z": 60.0}
ABOUT_MIDDLE = {"omega_x": 0.02, "omega_y": 10.0, "omega_z": 0.01}


MOTION = ("trajectory", "energy")

case = case_maker("rigid_body")

CASES = (
    case("heavy_tumbling", HEAVY, TILTED | TUMBLING, 1.0, "algebra", "order", *MOTION),
    case("free_euler", FREE, TILTED | TUMBLING, 2.0, "algebra", "order", *MOTION),
    case("intermediate_axis", ALIGNED, ABOUT_MIDDLE, 4.0, *MOTION, methods="best"),
    case("lagrange_top", LAGRANGE, SPINNING, 1.0, *MOTION, methods="best"),
    case("rest_hanging", HEAVY, {}, 0.5, "frequency", about="hanging"),
    case("kovalevskaya_top", KOVALEVSKAYA, TILTED | {"omega_z": 8.0}, 2.0, *MOTION, full_only=True),
    case("free_euler_long", FREE, TILTED | TUMBLING, 32.0, *MOTION, full_only=True),
)
"""`intermediate_axis` leaves its axis and turns over; it and `free_euler` have closed forms."""

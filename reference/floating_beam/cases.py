"""Cases of `floating_beam`."""

from __future__ import annotations

from ..scene import case_maker
from .equations import FloatingBeam

DAMPED = FloatingBeam()
WEIGHED = DAMPED.replace(gravity_x=3.0, gravity_y=-5.0, gravity_z=-7.0)
CONSERVATIVE = DAMPED.replace(hinge_damping=0.0)
PLANAR = DAMPED.replace(centre_z=0.0, axes_x=0.0, axes_y=0.0, axes_z=0.0, twist=0.0)
"""All axes along z and all centres of mass in one plane, which then holds the motion for ever."""

TUMBLING = {
    "x_dot": 0.9, "y_dot": -0.3, "z_dot": 0.5, "theta_1": 0.3, "theta_2": -0.5, "theta_3": 0.7,
    "q_w": 0.9, "q_x": 0.3, "q_y": -0.3, "q_z": 0.1,
    "theta_1_dot": -3.0, "theta_2_dot": 5.0, "theta_3_dot": 4.0,
    "omega_x": 2.0, "omega_y": -3.0, "omega_z": 4.0,
}  # fmt: skip

IN_PLANE = {
    "x_dot": 0.4, "y_dot": -0.3, "theta_1": 0.3, "theta_2": -0.5, "theta_3_dot": 4.0, "omega_z": 3.0
}  # fmt: skip


case = case_maker("floating_beam")

CASES = (
    case("tumbling", WEIGHED, TUMBLING, 0.0625, "algebra", "trajectory", methods="best"),
    case("afloat", DAMPED, {}, 0.5, "frequency", about="afloat"),
    case(
        "conservative", CONSERVATIVE, TUMBLING, 0.5, "order", "trajectory", "energy", full_only=True
    ),
    case("falling", WEIGHED.replace(hinge_damping=0.0), TUMBLING, 0.25, "energy", full_only=True),
    case("planar", PLANAR, IN_PLANE, 0.5, "trajectory", "order", full_only=True),
)

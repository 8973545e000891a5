"""Cases of `floating_platform`."""

from __future__ import annotations

from ..scene import case_maker
from .equations import FloatingPlatform

DRIVEN = FloatingPlatform()
CONSERVATIVE = DRIVEN.replace(motor_slope=0.0, rod_damping=0.0)
FALLING = CONSERVATIVE.replace(gravity_x=3.0, gravity_y=-5.0, gravity_z=-7.0)
PLANAR = DRIVEN.replace(
    centre_z=0.0, axes_x=0.0, axes_y=0.0, axes_z=0.0, rotor_height=0.0, tilt=0.0
)
"""All axes along z and all centres of mass in one plane, which then holds the motion for ever."""

TUMBLING = {
    "x_dot": 0.9, "y_dot": -0.3, "z_dot": 0.5, "phi": 0.7, "theta": 0.3,
    "q_w": 0.9, "q_x": 0.3, "q_y": -0.3, "q_z": 0.1, "phi_dot": 40.0, "theta_dot": -3.0,
    "omega_x": 2.0, "omega_y": -3.0, "omega_z": 4.0,
}  # fmt: skip

IN_PLANE = {"x_dot": 0.4, "y_dot": -0.3, "theta": 0.3, "phi_dot": 40.0, "omega_z": 3.0}


case = case_maker("floating_platform")

CASES = (
    case("tumbling", DRIVEN, TUMBLING, 0.125, "algebra", "trajectory", "energy", methods="best"),
    case("afloat", DRIVEN, {}, 0.5, "frequency", about="afloat"),
    case(
        "conservative", CONSERVATIVE, TUMBLING, 0.5, "order", "trajectory", "energy", full_only=True
    ),
    case("falling", FALLING, TUMBLING, 0.5, "algebra", "energy", full_only=True),
    case("planar", PLANAR, IN_PLANE, 0.5, "trajectory", "order", full_only=True),
)
"""Of `tumbling` *energy* looks at the momenta alone: the motor drives, and the rod is damped."""

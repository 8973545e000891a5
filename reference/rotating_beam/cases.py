"""Cases of `rotating_beam`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..scene import case_maker
from .parameters import RotatingBeam, steady_speed

TIP_MASS = 0.4
"""[kg], the smallest of section 3.1: figures 4 and 5 do not name theirs."""

FIGURE_4 = RotatingBeam(mass=TIP_MASS)
FIGURE_5 = RotatingBeam(mass=TIP_MASS, drive="torque")
QUICK = FIGURE_4.replace(angular_speed=1.0, ramp_time=3.0, segments=12)
PULSE = FIGURE_5.replace(torque_amplitude=20.0, torque_period=1.5, segments=12)
STEADY = RotatingBeam(angular_speed=4.0, ramp_time=0.0)
ABOVE_CRITICAL = RotatingBeam(angular_speed=4.0, ramp_time=3.0, segments=8)


STEADY_CASES: Mapping[str, Mapping[str, Any]] = {
    "steady_at_rest": {"angular_speed": 0.0},
    "steady_4": {"angular_speed": steady_speed(4)},
    "steady_4_chain_b": {"angular_speed": steady_speed(4), "scheme": "B"},
    "steady_4_hub_radius": {"angular_speed": steady_speed(4), "hub_radius": 8.0},
    "steady_4_tip_mass": {"angular_speed": steady_speed(4), "mass": 1.6, "hub_radius": 1.0},
    "steady_4_geometrically_exact": {
        "angular_speed": steady_speed(4),
        "element": "geometrically_exact",
    },
    "steady_12": {"angular_speed": steady_speed(12), "segments": 24},
    "steady_12_chain_b": {"angular_speed": steady_speed(12), "segments": 24, "scheme": "B"},
}
"""Steady rotation by dimensionless speed; chains need 24 rods at 12 for asymptotic errors."""


TURNING = PULSE.replace(hub_radius=0.5, segments=8)
BENT = {
    "theta": 0.4,
    "theta_dot": 2.0566,
    "b_1": -0.019211,
    "b_2": -0.051338,
    "b_3": -0.072797,
    "b_4": -0.090474,
    "b_5": -0.10287,
    "b_6": -0.11001,
    "b_7": -0.11313,
    "b_8": -0.11414,
    "b_1_dot": -0.050977,
    "b_2_dot": -0.14061,
    "b_3_dot": -0.20361,
    "b_4_dot": -0.25695,
    "b_5_dot": -0.29581,
    "b_6_dot": -0.31933,
    "b_7_dot": -0.32985,
    "b_8_dot": -0.33326,
}
"""A straight beam at 1.8 rad/s after 0.5 s of the pulse: a start that shakes nothing in it."""

WEIGHED = TURNING.replace(gravity_x=3.0, gravity_y=-9.0)
HANGING = WEIGHED.replace(hub_radius=1.0, torque_amplitude=0.0)

case = case_maker("rotating_beam")

CASES = (
    case("spin_up_quick", QUICK, {}, 4.0, "algebra", "trajectory"),
    case("pulse_quick", PULSE, {}, 2.0, "trajectory", "energy", methods="best"),
    case("spin_up", FIGURE_4, {}, 17.0, "trajectory", full_only=True, methods="best"),
    case("pulse", FIGURE_5, {}, 12.0, "trajectory", full_only=True, methods="best"),
    case(
        "turning", TURNING, BENT, 1.0, "trajectory", start_time=0.5, full_only=True, methods="best"
    ),
    case("weighed", WEIGHED, {"theta": 0.4}, 0.125, "algebra", methods="best"),
    case(
        "hanging", HANGING, {}, 0.5, "frequency", about="hanging", watch="elements", full_only=True
    ),
    *(
        case(
            name,
            STEADY.replace(**changes),
            {},
            0.5,
            "frequency",
            "order",
            about="rotation",
            watch="elements",
        )
        for name, changes in STEADY_CASES.items()
    ),
    case("above_critical", ABOVE_CRITICAL, {}, 8.0, "stability", watch="outcome", methods="best"),
)
"""``spin_up`` and ``pulse`` are figures 4 and 5, the quick ones bend the beam as far in less time.
``above_critical`` turns faster than the zero-order model can stand, `critical_speed`."""

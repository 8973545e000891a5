"""floating_platform as MJCF: which parameter goes where."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from ..body import BODY, free_motion
from ..mjcf import Mjcf

HINGES = ("phi", "theta")

MODELS = {
    "free": Mjcf(
        path=Path(__file__).with_name("floating_platform.xml"),
        bindings={
            **BODY,
            ("body:rotor", "pos"): lambda p: (0, 0, p.rotor_height),
            ("body:rotor/inertial", "pos"): lambda p: (p.eccentricity, 0, 0),
            ("body:rotor/inertial", "mass"): lambda p: p.rotor_mass,
            ("body:rotor/inertial", "diaginertia"): lambda p: (
                p.cross_moment,
                p.cross_moment,
                p.polar_moment,
            ),
            ("body:rod", "pos"): lambda p: (p.rod_place, 0, 0),
            ("body:rod", "euler"): lambda p: (p.tilt, 0, p.installation_angle),
            ("body:rod/inertial", "pos"): lambda p: (p.rod_length, 0, 0),
            ("body:rod/inertial", "mass"): lambda p: p.rod_mass,
            ("body:rod/inertial", "diaginertia"): lambda p: (p.rod_moment,) * 3,
            ("joint:theta", "stiffness"): lambda p: p.rod_stiffness,
            ("joint:theta", "damping"): lambda p: p.rod_damping,
            ("geom:rod", "fromto"): lambda p: (0, 0, 0, p.rod_length, 0, 0),
            ("general:motor", "biasprm"): lambda p: (
                p.motor_slope * p.synchronous_speed,
                0,
                -p.motor_slope,
            ),
        },
        joints=partial(free_motion, HINGES),
    ),
}

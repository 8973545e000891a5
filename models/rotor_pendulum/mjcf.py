"""rotor_pendulum as MJCF: which parameter goes where, and how the rod carries rotor 2."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ...reference.rotor_pendulum.equations import RotorPendulum
from ..mjcf import Mjcf, Motion

INERTIA_FLOOR = 2e-15
"""Moment of inertia of a point mass [kg m^2]: MuJoCo refuses less than 1e-15."""

INERTIA_SHARE = 5e-11
"""Largest share of that in m r^2: half of the largest permitted error of an acceleration."""


def joints(p: RotorPendulum, time: float, state: Mapping[str, float]) -> Motion:
    """Return the motion of the joints: that of rotor 2 is relative to the rod."""
    return {
        **{name: (state[name], state[f"{name}_dot"]) for name in ("x", "phi_1", "phi_3")},
        "theta_2": (state["phi_2"] - state["phi_3"], state["phi_2_dot"] - state["phi_3_dot"]),
    }


def motor(p: RotorPendulum) -> tuple[float, float, float]:
    """Torque of motor and bearing: its constant part, and per angle and rate."""
    return (p.motor_slope * p.synchronous_speed, 0.0, -(p.motor_slope + p.friction))


def unsupported_reason(p: RotorPendulum) -> str | None:
    """Return the reason where the least inertia of MuJoCo is too large for a rotor, or None."""
    share = INERTIA_FLOOR / (p.rotor_mass * p.eccentricity**2)
    if share <= INERTIA_SHARE:
        return None
    return (
        f"MuJoCo has no point masses: the least inertia it takes is {share:.1g} of the rotors' "
        "rotor_mass * eccentricity^2"
    )


BINDINGS = {
    ("option", "gravity"): lambda p: (p.gravity_x, p.gravity_y, 0),
    ("body:platform/inertial", "mass"): lambda p: p.platform_mass,
    ("joint:x", "stiffness"): lambda p: p.platform_stiffness,
    ("joint:x", "damping"): lambda p: p.platform_damping,
    ("body:rotor_1/inertial", "pos"): lambda p: (-p.eccentricity, 0, 0),
    ("body:rotor_1/inertial", "mass"): lambda p: p.rotor_mass,
    ("geom:rotor_1", "fromto"): lambda p: (0, 0, 0, -p.eccentricity, 0, 0),
    ("body:rod", "euler"): lambda p: (0, 0, p.installation_angle),
    ("body:rod/inertial", "pos"): lambda p: (p.rod_length, 0, 0),
    ("body:rod/inertial", "mass"): lambda p: p.rod_mass,
    ("joint:phi_3", "stiffness"): lambda p: p.rod_stiffness,
    ("joint:phi_3", "damping"): lambda p: p.rod_damping,
    ("geom:rod", "fromto"): lambda p: (0, 0, 0, p.rod_length, 0, 0),
    ("body:rotor_2", "pos"): lambda p: (p.rod_length, 0, 0),
    ("body:rotor_2", "euler"): lambda p: (0, 0, -p.installation_angle),
    ("body:rotor_2/inertial", "pos"): lambda p: (p.eccentricity, 0, 0),
    ("body:rotor_2/inertial", "mass"): lambda p: p.rotor_mass,
    ("geom:rotor_2", "fromto"): lambda p: (0, 0, 0, p.eccentricity, 0, 0),
    ("general:motor_1", "biasprm"): motor,
    ("general:motor_2", "biasprm"): motor,
    ("general:motor_2", "tendon"): lambda p: {"absolute": "phi_2", "relative": "theta_2"}[
        p.motor_placement
    ],
}
"""Attribute of the MJCF -> its value."""

MODELS = {
    "tree": Mjcf(
        path=Path(__file__).with_name("rotor_pendulum.xml"),
        bindings=BINDINGS,
        joints=joints,
        readout={"phi_2": {"phi_3": 1.0, "theta_2": 1.0}},
        unsupported_reason=unsupported_reason,
    ),
}

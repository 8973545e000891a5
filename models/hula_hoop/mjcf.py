"""hula_hoop as MJCF: which parameter goes where, and how its clock starts."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ...reference.hula_hoop.equations import SCENE, HulaHoop, coefficients
from ...reference.scene import EquationsOfMotion
from ..clock import foot_bindings, foot_motion
from ..mjcf import Mjcf, Motion, Wave, coordinates_alone

INERTIA_FLOOR = 2e-15
"""Moment of inertia of a point mass [kg m^2]: MuJoCo refuses less than 1e-15."""


def inertia(p: HulaHoop) -> tuple[float, float, float]:
    """Moment of inertia of the free mass about its centre; only that about z counts."""
    about_centre = max(p.inertia_ratio * p.free_mass * p.rod_length**2, INERTIA_FLOOR)
    return (about_centre, about_centre, about_centre)


def equations(p: HulaHoop) -> tuple[EquationsOfMotion, HulaHoop]:
    """Return the scene with the inertia ratio that the free mass has in the model."""
    floor = INERTIA_FLOOR / (p.free_mass * p.rod_length**2)
    return SCENE, p.replace(inertia_ratio=max(p.inertia_ratio, floor))


def joints(p: HulaHoop, time: float, state: Mapping[str, float]) -> Motion:
    """Return the motion of the coordinates and of the spring's foot, (F/k) cos(omega t)."""
    foot = foot_motion(coefficients(p), time)
    return {**coordinates_alone(p, time, state), "foot": foot}


MECHANISM = {
    ("option", "gravity"): lambda p: (p.gravity_x, p.gravity_y, 0),
    ("body:main_mass/inertial", "mass"): lambda p: p.main_mass,
    ("joint:y", "damping"): lambda p: coefficients(p).damping,
    ("body:rod/inertial", "pos"): lambda p: (p.rod_length, 0, 0),
    ("body:rod/inertial", "mass"): lambda p: p.free_mass,
    ("body:rod/inertial", "diaginertia"): inertia,
    ("joint:theta", "damping"): lambda p: coefficients(p).hinge_damping,
    ("geom:rod", "fromto"): lambda p: (0, 0, 0, p.rod_length, 0, 0),
    ("geom:free_mass", "pos"): lambda p: (p.rod_length, 0, 0),
}
"""Attribute of the MJCF -> its value, of both files."""

MODELS = {
    "tree": Mjcf(
        path=Path(__file__).with_name("hula_hoop.xml"),
        bindings={**MECHANISM, **foot_bindings(coefficients)},
        joints=joints,
        equations=equations,
    ),
    "forced": Mjcf(
        path=Path(__file__).with_name("forced.xml"),
        bindings={**MECHANISM, ("joint:y", "stiffness"): lambda p: p.stiffness},
        equations=equations,
        controls=lambda p: {"force": Wave(coefficients(p).force, coefficients(p).omega, 0.0)},
    ),
}

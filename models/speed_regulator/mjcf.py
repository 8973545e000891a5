"""speed_regulator as MJCF: which parameter goes where, and how the loop is closed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from ...reference.scene import EquationsOfMotion
from ...reference.soft_constraint import SOLIMP, SOLREF
from ...reference.speed_regulator.equations import SpeedRegulator
from ...reference.speed_regulator.soft import embedding, soft_scene
from ..mjcf import Binding, Mjcf, Motion, coordinates_alone

HARD_SOLREF = (-2.5e5, -1e3)
HARD_SOLIMP = (0.9999, 0.9999, 0.001, 0.5, 2.0)
"""The hardest stable closure at the file's timestep; the file tells why."""

WAIVER = " <!-- mbcheck: allow repeated_default, closure: it tells how far the loop opens -->"
"""The comment in the file about its softness."""


def joints(p: SpeedRegulator, time: float, state: Mapping[str, float]) -> Motion:
    """Return the motion of all joints: the loop closed, where the state does not say else."""
    return coordinates_alone(p, time, {**embedding(p, state), **state})


def closure_lacks_mass(p: SpeedRegulator) -> str | None:
    """Return the reason why a soft closure cannot model these parameters, or None."""
    massless = [name for name in ("rod_mass", "slider_mass") if getattr(p, name) == 0]
    if not massless:
        return None
    return (
        f"{' and '.join(massless)} 0: MuJoCo takes no joint without inertia, and scales the "
        "hardness of a closure with the masses that it joins"
    )


def transmission_carries_mass(p: SpeedRegulator) -> str | None:
    """Return the reason why the transmission cannot model these parameters, or None."""
    if p.rod_mass == 0 and p.slider_mass == 0:
        return None
    return (
        "MuJoCo's slider-crank transmission has no inertia: rod_mass and slider_mass must be 0, "
        f"not {p.rod_mass:g} and {p.slider_mass:g} kg"
    )


COMMON: Mapping[tuple[str, str], Binding] = {
    ("option", "gravity"): lambda p: (p.gravity_x, p.gravity_y, 0),
    ("body:crank/inertial", "diaginertia"): lambda p: (p.flywheel_inertia,) * 3,
    ("geom:crank", "fromto"): lambda p: (0, 0, 0, p.crank_radius, 0, 0),
    ("general:motor", "biasprm"): lambda p: (p.torque, 0, 0),
}

LOOP: Mapping[tuple[str, str], Binding] = {
    **COMMON,
    ("body:rod", "pos"): lambda p: (p.crank_radius, 0, 0),
    ("body:rod", "euler"): lambda p: (0, 0, embedding(p, {})["pin_angle"]),
    ("body:rod/inertial", "pos"): lambda p: (0, -p.rod_length / 2, 0),
    ("body:rod/inertial", "mass"): lambda p: p.rod_mass,
    ("body:rod/inertial", "diaginertia"): lambda p: (p.rod_mass * p.rod_length**2 / 12,) * 3,
    ("joint:pin_angle", "ref"): lambda p: embedding(p, {})["pin_angle"],
    ("geom:rod", "fromto"): lambda p: (0, 0, 0, 0, -p.rod_length, 0),
    ("site:rod_end", "pos"): lambda p: (0, -p.rod_length, 0),
    ("body:slider", "pos"): lambda p: (0, embedding(p, {})["y"], 0),
    ("body:slider/inertial", "mass"): lambda p: p.slider_mass,
    ("joint:y", "ref"): lambda p: embedding(p, {})["y"],
    ("joint:y", "springref"): lambda p: p.spring_rest,
    ("joint:y", "stiffness"): lambda p: p.stiffness,
    ("joint:y", "damping"): lambda p: p.damping,
}

TRANSMISSION: Mapping[tuple[str, str], Binding] = {
    **COMMON,
    ("site:crank_pin", "pos"): lambda p: (p.crank_radius, 0, 0),
    ("general:slider", "cranklength"): lambda p: p.rod_length,
    ("general:slider", "biasprm"): lambda p: (
        p.stiffness * p.spring_rest,
        -p.stiffness,
        -p.damping,
    ),
}
"""Attribute of the MJCF -> its value."""


REACTIONS: Mapping[str, tuple[str, int]] = {
    "reaction_a_x": ("body:rod", 0),
    "reaction_a_y": ("body:rod", 1),
    "reaction_b_x": ("connect:closure", 0),
    "reaction_b_y": ("connect:closure", 1),
}
"""On the crank at A, and on the rod at B."""


def closed_by(solref: tuple[float, float], solimp: tuple[float, ...]) -> Mjcf:
    """Return the model whose loop is closed this softly."""

    def equations(p: SpeedRegulator) -> tuple[EquationsOfMotion, SpeedRegulator]:
        return soft_scene(solref, solimp), p

    def expand(text: str, p: SpeedRegulator) -> str:
        """Return the text; the waiver stays with MuJoCo's default softness alone."""
        return text if (solref, solimp) == (SOLREF, SOLIMP) else text.replace(WAIVER, "")

    softness: Mapping[tuple[str, str], Binding] = {
        ("connect:closure", "solref"): lambda p: solref,
        ("connect:closure", "solimp"): lambda p: solimp,
    }
    return Mjcf(
        path=Path(__file__).with_name("connect.xml"),
        bindings={**LOOP, **softness},
        joints=joints,
        closed=True,
        longest_step=solref[0] / 2 if solref[0] > 0 else math.inf,  # beyond, `refsafe` softens
        reactions=REACTIONS,
        equations=equations,
        unsupported_reason=closure_lacks_mass,
        expand=expand,
    )


def closed_within(time: float) -> Mjcf:
    """Return the hard closure, critically damped with another time constant [s].

    It is written as stiffness and damping, which MuJoCo takes as they are at any step.
    """
    return closed_by((-(time**-2), -2 / time), HARD_SOLIMP)


MODELS = {
    "connect": closed_by(SOLREF, SOLIMP),
    "connect_hard": replace(closed_by(HARD_SOLREF, HARD_SOLIMP), softened=closed_within),
    "transmission": Mjcf(
        path=Path(__file__).with_name("transmission.xml"),
        bindings=TRANSMISSION,
        unsupported_reason=transmission_carries_mass,
    ),
}
"""Models by name, default first; `connect.xml` has MuJoCo's default softness."""

"""The scene `ball_hoop`, and its cases."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ..body.mistakes import with_mistakes
from ..body.parameters import inexact_numbers
from ..body.rotation import (
    COORDINATES,
    QUATERNION,
    RATES,
    ROTATION,
    UNITS,
    accelerations_by,
    inexact_accelerations,
)
from ..hula_hoop import SCENE as HULA_HOOP
from ..scene import Scene, case_maker, with_placements, with_rates
from .equations import (
    FIRST,
    BallHoop,
    accelerations,
    along_slide,
    body_accelerations,
    coefficients,
    coefficients_of,
    damping_matrix,
    energy,
    forces,
    mass_matrix,
    outputs,
    powers,
    rest,
    weightless,
)
from .mistakes import COUPLINGS


def invariants(p: BallHoop) -> Mapping[str, Callable[..., Any]]:
    """Return the energy without dampers, and the angular momentum that gravity leaves.

    The latter without friction in the joint, also while a force drives the slide.
    """
    known: dict[str, Callable[..., Any]] = {}
    if not np.any(p.damping) and not np.any(p.joint_damping):
        known["energy"] = energy
    if not np.any(p.gravity[[0, 2]]) and not np.any(p.joint_damping):
        known["momentum"] = along_slide
    return known


WEIGHED = BallHoop(gravity_x=3.0, gravity_y=-5.0, gravity_z=-7.0)
CONSERVATIVE = WEIGHED.replace(damping=0.0, joint_damping=0.0, force_amplitude=0.0)
ALONG = CONSERVATIVE.replace(gravity_x=0.0, gravity_z=0.0)
FREELY = BallHoop(joint_damping=0.0)
PLANAR = BallHoop(
    mass=0.45, centre_x=0.15, centre_y=0.0, centre_z=0.0, axes_x=0.0, axes_y=0.0, axes_z=0.0
)
"""Turns about z for ever where it does so at the start, as the rod of `hula_hoop` does."""

SPINNING = {
    "y": 0.02, "q_w": 0.9, "q_x": 0.3, "q_y": -0.3, "q_z": 0.1,
    "omega_x": 5.0, "omega_y": -4.0, "omega_z": 8.0,
}  # fmt: skip


case = case_maker("ball_hoop")

CASES = (
    case("weighed", WEIGHED, SPINNING, 0.25, "algebra", "trajectory", methods="best"),
    case("hanging", WEIGHED, {}, 0.5, "frequency", about="hanging"),
    case("driven", FREELY, SPINNING, 0.5, "order", "trajectory", "energy", full_only=True),
    case("conservative", CONSERVATIVE, SPINNING, 0.5, "energy", full_only=True),
    case("gravity_along", ALONG, SPINNING, 2.0, "trajectory", "energy", full_only=True),
    case("planar", PLANAR, {"omega_z": 18.0}, 0.5, "trajectory", "order", full_only=True),
)
"""Of `driven` *energy* looks at the angular momentum about the slide alone."""

SCENE = Scene(
    name="ball_hoop",
    title="rigid body on a ball joint that a sprung mass drives",
    paper=HULA_HOOP.paper,
    parameters=BallHoop,
    coordinates=("y", *COORDINATES),
    quaternions=(QUATERNION,),
    units=with_rates(y="m", **dict.fromkeys(COORDINATES, "1")) | UNITS,
    coefficients=coefficients,
    inexact_numbers=inexact_numbers,
    inexact_accelerations=lambda change: inexact_accelerations(body_accelerations, FIRST, change),
    drive=HULA_HOOP.drive,
    drive_form="force on y: F cos(2 pi f t), largest at t = 0, whenever a run starts",
    mass_matrix=mass_matrix,
    forces=forces,
    accelerations=accelerations,
    damping_matrix=damping_matrix,
    energy=energy,
    powers=powers,
    outputs=outputs,
    observed=(*ROTATION, *RATES),
    equilibria={
        "hanging": lambda p: rest(p, 1.0),
        "inverted": lambda p: rest(p, -1.0),
        "weightless": weightless,
    },
    period=HULA_HOOP.period,
    unforced=lambda p: p.replace(force_amplitude=0.0),
    invariants=invariants,
    cases=CASES,
    placed=with_placements(CASES[0], "algebra")[:1],  # a mirror has other quaternions
)

SCENE = replace(
    SCENE,
    mistakes={
        **with_mistakes(SCENE, body_accelerations, coefficients_of),
        **{
            words: replace(SCENE, accelerations=accelerations_by(accelerate, FIRST), cases=())
            for words, accelerate in COUPLINGS.items()
        },
    },
)

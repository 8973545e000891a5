"""The scene `ball_hoop`, and its cases."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ..body.mistakes import with_mistakes
from ..body.rotation import COORDINATES, QUATERNION, RATES, ROTATION, UNITS, accelerations_by
from ..scene import Case, Paper, Scene, with_rates
from .equations import (
    FIRST,
    BallHoop,
    accelerations,
    along_slide,
    body_accelerations,
    coefficients,
    coefficients_of,
    damping_matrix,
    drive,
    energy,
    forces,
    mass_matrix,
    outputs,
    period,
    powers,
    rest,
    weightless,
)
from .mistakes import COUPLINGS


def invariants(p: BallHoop) -> Mapping[str, Callable[..., Any]]:
    """Return the energy without a damper, and the angular momentum that gravity leaves.

    The latter also while a force drives the slide.
    """
    known: dict[str, Callable[..., Any]] = {} if np.any(p.damping) else {"energy": energy}
    return known if np.any(p.gravity[[0, 2]]) else known | {"momentum": along_slide}


WEIGHED = BallHoop(gravity_x=3.0, gravity_y=-5.0, gravity_z=-7.0)
CONSERVATIVE = WEIGHED.replace(damping=0.0, force_amplitude=0.0)
ALONG = CONSERVATIVE.replace(gravity_x=0.0, gravity_z=0.0)
PLANAR = BallHoop(
    mass=0.45, centre_x=0.15, centre_y=0.0, centre_z=0.0, axes_x=0.0, axes_y=0.0, axes_z=0.0
)
"""Turns about z for ever where it does so at the start, as the rod of `hula_hoop` does."""

SPINNING = {
    "y": 0.02, "q_w": 0.9, "q_x": 0.3, "q_y": -0.3, "q_z": 0.1,
    "omega_x": 5.0, "omega_y": -4.0, "omega_z": 8.0,
}  # fmt: skip


def _case(name: str, p: BallHoop, state: dict[str, float], horizon: float, *kinds: str) -> Case:
    return Case("ball_hoop", name, p, state, horizon, kinds)


def _best(name: str, p: BallHoop, state: dict[str, float], horizon: float, *kinds: str) -> Case:
    return replace(_case(name, p, state, horizon, *kinds), methods="best")


CASES = (
    _best("driven", BallHoop(), SPINNING, 0.5, "algebra", "order", "trajectory", "energy"),
    _best("weighed", WEIGHED, SPINNING, 0.5, "algebra", "trajectory"),
    _best("conservative", CONSERVATIVE, SPINNING, 0.5, "energy"),
    replace(_case("hanging", WEIGHED, {}, 0.5, "frequency"), about="hanging"),
    replace(_best("gravity_along", ALONG, SPINNING, 2.0, "trajectory", "energy"), full_only=True),
    replace(_case("planar", PLANAR, {"omega_z": 18.0}, 0.5, "trajectory", "order"), full_only=True),
)
"""Of `driven` *energy* looks at the angular momentum about the slide alone."""

SCENE = Scene(
    name="ball_hoop",
    title="rigid body on a ball joint that a sprung mass drives",
    paper=Paper(
        "C. X. Lu, C. C. Wang, C. K. Sung, P. C. P. Chao",
        "Dynamic Analysis of a Motion Transformer Mimicking a Hula Hoop",
        "Journal of Vibration and Acoustics 133, 014501",
        2011,
        "10.1115/1.4001839",
    ),
    parameters=BallHoop,
    coordinates=("y", *COORDINATES),
    quaternions=(QUATERNION,),
    units=with_rates(y="m", **dict.fromkeys(COORDINATES, "1")) | UNITS,
    coefficients=coefficients,
    drive=drive,
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
    period=period,
    unforced=lambda p: p.replace(force_amplitude=0.0),
    invariants=invariants,
    cases=CASES,
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

"""The scene `floating_beam`."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..body.floating_mistakes import chain_mistakes
from ..body.floating_scene import floating_scene
from ..rotating_beam import SCENE as ROTATING_BEAM
from .cases import CASES
from .equations import (
    ANGLES,
    TREE,
    FloatingBeam,
    coefficients,
    coefficients_of,
    damping_matrix,
    powers,
)


def period(p: FloatingBeam) -> Any:
    """Return the period [s] of a clamped beam, 1 s if it has no stiffness.

    Rayleigh's: 33/140 of its mass move with the tip.
    """
    moving = (33 / 140 * p.beam_mass + p.tip_mass) * p.length**3 / 3
    stiff = np.where(np.asarray(p.bending_stiffness) > 0, p.bending_stiffness, np.inf)
    return np.where(np.isfinite(stiff), 2 * np.pi * np.sqrt(moving / stiff), 1.0)


SCENE = floating_scene(
    TREE,
    coefficients_of,
    lambda p: not np.any(p.hinge_damping),
    placed=CASES[0],
    name="floating_beam",
    title="hub afloat in space with a twisted beam as a chain of rods",
    paper=ROTATING_BEAM.paper,
    parameters=FloatingBeam,
    coordinates=ANGLES,
    units=dict.fromkeys(ANGLES, "rad"),
    coefficients=coefficients,
    damping_matrix=damping_matrix,
    powers=powers,
    period=period,
    cases=CASES,
)

SCENE = replace(SCENE, mistakes={**SCENE.mistakes, **chain_mistakes(SCENE, TREE)})

"""The scene `rigid_body`."""

from __future__ import annotations

from dataclasses import replace

from ..body.mistakes import with_mistakes
from ..body.parameters import inexact_numbers
from ..body.rotation import (
    COORDINATES,
    QUATERNION,
    RATES,
    ROTATION,
    UNITS,
    inexact_accelerations,
    rest_attitude,
)
from ..scene import Paper, Scene, with_placements, with_rates
from .cases import CASES
from .equations import (
    RigidBody,
    accelerations,
    body_accelerations,
    coefficients,
    coefficients_of,
    damping_matrix,
    energy,
    forces,
    mass_matrix,
    outputs,
    period,
)
from .integrals import invariants

SCENE = Scene(
    name="rigid_body",
    title="rigid body turning about a fixed point",
    paper=Paper(
        "L. D. Landau, E. M. Lifshitz",
        "Mechanics",
        "Butterworth-Heinemann, 3rd edition, sections 32-37",
        1976,
        "",  # a book
    ),
    parameters=RigidBody,
    coordinates=COORDINATES,
    quaternions=(QUATERNION,),
    units=with_rates(**dict.fromkeys(COORDINATES, "1")) | UNITS,
    coefficients=coefficients,
    inexact_numbers=inexact_numbers,
    inexact_accelerations=lambda change: inexact_accelerations(body_accelerations, 0, change),
    mass_matrix=mass_matrix,
    forces=forces,
    accelerations=accelerations,
    damping_matrix=damping_matrix,
    energy=energy,
    outputs=outputs,
    observed=(*ROTATION, *RATES),
    equilibria={
        "hanging": lambda p: rest_attitude(p, 1.0),
        "upright": lambda p: rest_attitude(p, -1.0),
    },
    period=period,
    invariants=invariants,
    cases=CASES,
    placed=with_placements(CASES[0], "algebra")[:1],  # a mirror has other quaternions
)

SCENE = replace(SCENE, mistakes=with_mistakes(SCENE, body_accelerations, coefficients_of))

"""The scene `rigid_body`."""

from __future__ import annotations

from dataclasses import replace

from ..scene import Paper, Scene, with_rates
from .cases import CASES
from .equations import (
    COORDINATES,
    MOMENTUM,
    QUATERNION,
    RATES,
    ROTATION,
    RigidBody,
    accelerations,
    coefficients,
    damping_matrix,
    energy,
    forces,
    mass_matrix,
    outputs,
    period,
    powers,
    rest_attitude,
)
from .integrals import invariants
from .mistakes import with_mistakes

UNITS = {
    **with_rates(**dict.fromkeys(COORDINATES, "1")),
    **dict.fromkeys(ROTATION, "1"),
    **dict.fromkeys(RATES, "rad/s"),
    **dict.fromkeys(MOMENTUM, "kg m^2/s"),
    "energy": "J",
    "norm": "1",
}

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
    units=UNITS,
    coefficients=coefficients,
    mass_matrix=mass_matrix,
    forces=forces,
    accelerations=accelerations,
    damping_matrix=damping_matrix,
    energy=energy,
    powers=powers,
    outputs=outputs,
    observed=(*ROTATION, *RATES),
    equilibria={
        "hanging": lambda p: rest_attitude(p, 1.0),
        "upright": lambda p: rest_attitude(p, -1.0),
    },
    period=period,
    invariants=invariants,
    cases=CASES,
)

SCENE = replace(SCENE, mistakes=with_mistakes(SCENE))

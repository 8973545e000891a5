"""The scene `floating_platform`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ..body.mistakes import with_mistakes
from ..body.rotation import (
    AXES,
    COORDINATES,
    MOMENTUM,
    QUATERNION,
    RATES,
    ROTATION,
    UNITS,
    rotation_outputs,
)
from ..errors import NoOrbitError
from ..rotor_pendulum import SCENE as ROTOR_PENDULUM
from ..scene import Scene, with_placements, with_rates
from .cases import CASES
from .equations import (
    Coefficients,
    FloatingPlatform,
    accelerations,
    angular_momentum,
    body_accelerations,
    coefficients,
    coefficients_of,
    damping_matrix,
    energy,
    forces,
    mass_matrix,
    momentum,
    powers,
)
from .mistakes import hinge_mistakes

LINEAR = tuple(f"linear_{name}" for name in MOMENTUM)
"""Components in the world of the linear momentum."""


def outputs(q: Any, v: Any, c: Coefficients, xp: Any = np) -> dict[str, Any]:
    """Return attitude, body rates, both momenta, energy, length of q.

    The angular momentum is that about the centre of mass.
    """
    rotation = rotation_outputs(q[-4:], v[-4:], angular_momentum(q, v, c), energy(q, v, c), xp)
    return rotation | dict(zip(LINEAR, momentum(q, v, c), strict=True))


def component(of: Callable[..., list[Any]], axis: int, q: Any, v: Any, c: Coefficients) -> Any:
    """Return one of the components of a vector."""
    return of(q, v, c)[axis]


def invariants(p: FloatingPlatform) -> Mapping[str, Callable[..., Any]]:
    """Return the angular momentum; without gravity the linear one; without motor, damper energy."""
    known: dict[str, Callable[..., Any]] = {}
    if not np.any(p.motor_slope) and not np.any(p.rod_damping):
        known["energy"] = energy
    for axis, (turning, moving) in enumerate(zip(MOMENTUM, LINEAR, strict=True)):
        known[turning] = partial(component, angular_momentum, axis)
        if not np.any(p.gravity):
            known[moving] = partial(component, momentum, axis)
    return known


def afloat(p: FloatingPlatform) -> dict[str, float]:
    """Return the state of rest, which is any place and attitude with the spring relaxed.

    Raises
    ------
    NoOrbitError
        If it falls.
    """
    if np.any(p.gravity):
        raise NoOrbitError("nothing holds floating_platform: with gravity it falls")
    return {}


def period(p: FloatingPlatform) -> Any:
    """Return the time [s] of a turn of the rotor at the motor's own speed, at most 1 s."""
    return 2 * np.pi / np.maximum(np.abs(p.synchronous_speed), 2 * np.pi)


SCENE = Scene(
    name="floating_platform",
    title="platform afloat in space with a rotor and a sprung pendulum",
    paper=ROTOR_PENDULUM.paper,
    parameters=FloatingPlatform,
    coordinates=("x", "y", "z", "phi", "theta", *COORDINATES),
    quaternions=(QUATERNION._replace(place=("x", "y", "z")),),
    units=with_rates(
        **dict.fromkeys(AXES, "m"), phi="rad", theta="rad", **dict.fromkeys(COORDINATES, "1")
    )
    | UNITS
    | dict.fromkeys(LINEAR, "kg m/s"),
    eliminates=True,
    coefficients=coefficients,
    mass_matrix=mass_matrix,
    forces=forces,
    accelerations=accelerations,
    damping_matrix=damping_matrix,
    energy=energy,
    powers=powers,
    outputs=outputs,
    observed=(*ROTATION, *RATES),
    equilibria={"afloat": afloat},
    period=period,
    unforced=lambda p: p.replace(motor_slope=0.0),
    invariants=invariants,
    cases=CASES,
    placed=with_placements(CASES[3], "algebra")[:1],  # a mirror has other quaternions
)

TURNING = {
    words: scene
    for words, scene in with_mistakes(SCENE, body_accelerations, coefficients_of).items()
    if "gravity" not in words  # of which no torque acts about the centre of mass
}

SCENE = replace(SCENE, mistakes=TURNING | hinge_mistakes(SCENE))

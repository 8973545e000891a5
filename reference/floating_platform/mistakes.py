"""Mistakes in what couples a free joint and hinges, by the words for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ..body.rotation import (
    AXES,
    COORDINATES,
    RATES,
    ROTATION,
    BodyAccelerations,
    Moment,
    accelerations_by,
    body_rates,
    into_body,
    sum_of,
)
from ..quaternions import cross, matrix
from ..scene import Scene
from .equations import (
    FIRST,
    HINGES,
    PLACE,
    TURN,
    Arm,
    Coefficients,
    FloatingPlatform,
    Sides,
    arms,
    around,
    central_accelerations,
    centre,
    coriolis,
    forces,
    mass_matrix,
    outward,
    sides_of,
    spun,
    symmetric_solution,
    torques,
)

Change = Callable[[Sides, tuple[Arm, Arm], Any, Coefficients], Sides]
"""From what drives bodies, those on hinges, (q, v, omega) and coefficients to something else."""


def without_reactions(sides: Sides, both: tuple[Arm, Arm], motion: Any, c: Coefficients) -> Sides:
    """Return them with torques at hinges that act on one of two bodies."""
    turning = sides.turning
    for one, torque in zip(both, torques(motion[0], motion[1], c), strict=True):
        turning = sum_of(turning, one.axis, torque)
    return sides._replace(turning=turning)


def reactions_of_world(sides: Sides, both: tuple[Arm, Arm], motion: Any, c: Coefficients) -> Sides:
    """Return them with reactions about axes whose components are taken for those in the world."""
    turning = without_reactions(sides, both, motion, c).turning
    for one, torque in zip(both, torques(motion[0], motion[1], c), strict=True):
        turning = sum_of(turning, into_body(motion[0][TURN], one.axis), -torque)
    return sides._replace(turning=turning)


def without_spin(sides: Sides, both: tuple[Arm, Arm], motion: Any, c: Coefficients) -> Sides:
    """Return them without the gyroscopic moments of bodies that spin on hinges."""
    turning = sides.turning
    for one, rate in zip(both, motion[1][HINGES], strict=True):
        moment = sum_of(spun(one, motion[2], rate), spun(one, motion[2], 0.0), -1.0)
        turning = sum_of(turning, moment)
    return sides._replace(turning=turning)


def without_coriolis(sides: Sides, both: tuple[Arm, Arm], motion: Any, c: Coefficients) -> Sides:
    """Return them without Coriolis's accelerations of centres of mass that move on the platform."""
    first, second = (
        sum_of(bent, coriolis(one, motion[2], rate), -1.0)
        for bent, one, rate in zip(sides.bent, both, motion[1][HINGES], strict=True)
    )
    return sides._replace(bent=(first, second))


def changed(change: Change = lambda sides, both, motion, c: sides) -> BodyAccelerations:
    """Return `equations.body_accelerations` with something else that drives."""

    def accelerate(u: Any, motion: Any, c: Coefficients, moment: Moment, xp: Any = np) -> list[Any]:
        both = arms(motion[0], c, xp)
        return central_accelerations(
            both, change(sides_of(both, motion, c, moment), both, motion, c), motion, c
        )

    return accelerate


def in_own_frame(u: Any, motion: Any, c: Coefficients, moment: Moment, xp: Any = np) -> list[Any]:
    """Return accelerations whose first are those of the velocity in the platform's frame."""
    q, v, omega = motion
    right = changed()(u, motion, c, moment, xp)
    inside = into_body(q[TURN], right[0:3])
    return [*sum_of(inside, cross(omega, v[PLACE]), -1.0), *right[3:]]


def of_centre(u: Any, motion: Any, c: Coefficients, moment: Moment, xp: Any = np) -> list[Any]:
    """Return accelerations whose first are those of the platform's centre of mass."""
    q, _, omega = motion
    right = changed()(u, motion, c, moment, xp)
    faster = sum_of(cross(right[5:8], centre(c)), around(omega, centre(c)))
    return [*sum_of(right[0:3], outward(q, faster)), *right[3:]]


def uncoupled_matrix(q: Any, c: Coefficients, xp: Any = np) -> list[list[Any]]:
    """Return the mass matrix without entries between hinges and anything else."""
    rows = mass_matrix(q, c, xp)
    hinges = range(HINGES.start, HINGES.stop)
    return [
        [entry if i == j or not {i, j} & {*hinges} else 0.0 for j, entry in enumerate(row)]
        for i, row in enumerate(rows)
    ]


def uncoupled(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> list[Any]:
    """Return the accelerations by that matrix."""
    return symmetric_solution(uncoupled_matrix(q, c, xp), forces(u, q, v, c, xp))


MISTAKES: Mapping[str, BodyAccelerations] = {
    "the platform does not bear the reactions of torques at hinges": changed(without_reactions),
    "reactions of torques at hinges act along axes of the world": changed(reactions_of_world),
    "bodies that spin on hinges lack their gyroscopic moments": changed(without_spin),
    "bodies that move on the turning platform lack Coriolis's force": changed(without_coriolis),
    "accelerations of the free joint are those in the frame of the platform": in_own_frame,
    "accelerations of the free joint are those of the platform's centre of mass": of_centre,
}

# Velocities of the free joint that are another thing

PLACES = ("p_x", "p_y", "p_z")


def placed_from(velocity: Callable[..., list[Any]]) -> Callable[..., dict[str, float]]:
    """Return what makes a state of one whose first rates are another velocity."""

    def embedding(p: FloatingPlatform, state: Mapping[str, float]) -> dict[str, float]:
        q, v = (
            [state[f"{name}{dot}"] for name in (*AXES, "phi", "theta", *COORDINATES)]
            for dot in ("", "_dot")
        )
        renamed = dict(zip((f"{name}_dot" for name in PLACES), velocity(p, q, v), strict=True))
        renamed |= dict(zip(PLACES, q, strict=False))
        gone = {f"{axis}{dot}" for axis in AXES for dot in ("", "_dot")}
        return {name: value for name, value in state.items() if name not in gone} | renamed

    return embedding


def swung(p: FloatingPlatform, q: Any, v: Any, sign: float) -> list[Any]:
    """Return the first three rates, with the velocity of the centre of mass by the turn or less."""
    omega = body_rates(q[TURN], v[TURN])[1]
    return sum_of(v[PLACE], outward(q, cross(omega, p.centre)), sign)


def from_centre(p: FloatingPlatform, q: Any, v: Any) -> list[Any]:
    """Return the velocity of the platform's point from that of its centre of mass."""
    return swung(p, q, v, -1.0)


def from_own_frame(p: FloatingPlatform, q: Any, v: Any) -> list[Any]:
    """Return the velocity in the world from that in the platform's frame."""
    return outward(q, v[PLACE])


def at_centre(q: Any, v: Any, c: Coefficients) -> list[Any]:
    """Return the velocity of the platform's centre of mass."""
    omega = body_rates(q[TURN], v[TURN])[1]
    return sum_of(v[PLACE], outward(q, cross(omega, centre(c))))


def in_frame(q: Any, v: Any, c: Coefficients) -> list[Any]:
    """Return the velocity of the platform's point in its frame."""
    return into_body(q[TURN], v[PLACE])


def with_velocities(
    scene: Scene, start: Callable[..., list[Any]], velocity: Callable[..., list[Any]]
) -> Scene:
    """Return a scene whose free joint's velocity is another, at the start and in what is seen."""

    def outputs(q: Any, v: Any, c: Coefficients, xp: Any = np) -> dict[str, Any]:
        rotation = dict(zip(ROTATION, (e for row in matrix(q[TURN]) for e in row), strict=True))
        rates = dict(zip(RATES, body_rates(q[TURN], v[TURN])[1], strict=True))
        moved = dict(zip((f"{axis}_dot" for axis in AXES), velocity(q, v, c), strict=True))
        return dict(zip(AXES, q, strict=False)) | moved | rotation | rates

    units = {f"{name}{dot}": f"m{dot and '/s'}" for name in PLACES for dot in ("", "_dot")}
    return replace(
        scene,
        coordinates=(*PLACES, *scene.coordinates[3:]),
        units=dict(scene.units) | units,
        embedding=placed_from(start),
        outputs=outputs,
        cases=(),
    )


def hinge_mistakes(scene: Scene) -> dict[str, Scene]:
    """Return the scene with each of these mistakes."""
    return {
        **{
            words: replace(scene, accelerations=accelerations_by(accelerate, FIRST), cases=())
            for words, accelerate in MISTAKES.items()
        },
        "the inertia that couples platform and hinges is lost": replace(
            scene, accelerations=uncoupled, mass_matrix=uncoupled_matrix, cases=()
        ),
        "the free joint's velocity is that of the platform's centre of mass": with_velocities(
            scene, from_centre, at_centre
        ),
        "the free joint's velocity is that in the frame of the platform": with_velocities(
            scene, from_own_frame, in_frame
        ),
    }

"""Mistakes in what couples a free joint and hinges, by the words for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ..quaternions import cross, matrix
from ..scene import Scene
from .floating import (
    HINGES,
    NOTHING,
    PLACE,
    TURN,
    FloatingTree,
    Link,
    Rates,
    Sides,
    around,
    centre,
    driven,
    outward,
    rates_of,
    spun,
    symmetric_solution,
)
from .rotation import (
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

Change = Callable[[Sides, list[Link], Any], Sides]
"""From what drives bodies, those on hinges and (q, v, omega) to something else."""


def roots(sides: Sides, links: list[Link]) -> list[tuple[list[Any], Any]]:
    """Return axes and torques of the hinges on the base."""
    both = zip(links, sides.hinges, strict=True)
    return [(one.axis, torque) for one, torque in both if not one.parent]


def without_reactions(sides: Sides, links: list[Link], motion: Any) -> Sides:
    """Return them with torques at hinges that act on one of two bodies."""
    turning = sides.turning
    for axis, torque in roots(sides, links):
        turning = sum_of(turning, axis, torque)
    return sides._replace(turning=turning)


def reactions_of_world(sides: Sides, links: list[Link], motion: Any) -> Sides:
    """Return them with reactions about axes whose components are taken for those in the world."""
    turning = without_reactions(sides, links, motion).turning
    for axis, torque in roots(sides, links):
        turning = sum_of(turning, into_body(motion[0][TURN], axis), -torque)
    return sides._replace(turning=turning)


def without_spin(sides: Sides, links: list[Link], motion: Any) -> Sides:
    """Return them without what the spin on hinges makes of gyroscopic moments on the base."""
    turning, still = sides.turning, Rates(NOTHING, NOTHING, NOTHING, NOTHING)
    for one, moment in zip(links, sides.moments.values(), strict=True):
        turning = sum_of(turning, sum_of(moment, spun(one, motion[2], still), -1.0))
    return sides._replace(turning=turning)


def without_coriolis(sides: Sides, links: list[Link], motion: Any) -> Sides:
    """Return them without Coriolis's accelerations of centres of mass that move on the base."""
    moving = rates_of(links, motion[1][HINGES])
    return sides._replace(bent={i: one.bent for i, one in enumerate(moving, 1)})


def with_still_axes(sides: Sides, links: list[Link], motion: Any) -> Sides:
    """Return them without what hinges make of each other by turning the axes beyond them."""
    moving = rates_of(links, motion[1][HINGES], turning=0.0)
    bent, moments = driven(links, motion[2], moving)
    return sides._replace(bent=bent, moments=moments)


def changed(
    tree: FloatingTree, change: Change = lambda sides, links, motion: sides
) -> BodyAccelerations:
    """Return the accelerations of a tree with something else that drives."""

    def accelerate(u: Any, motion: Any, c: Any, moment: Moment, xp: Any = np) -> list[Any]:
        links = tree.links(motion[0], c, xp)
        sides = change(tree.sides(links, motion, c, moment), links, motion)
        return tree.central(links, sides, motion, c)

    return accelerate


def in_own_frame(tree: FloatingTree) -> BodyAccelerations:
    """Return accelerations whose first are those of the velocity in the frame of the base."""

    def accelerate(u: Any, motion: Any, c: Any, moment: Moment, xp: Any = np) -> list[Any]:
        q, v, omega = motion
        right = tree.body_accelerations(u, motion, c, moment, xp)
        inside = into_body(q[TURN], right[0:3])
        return [*sum_of(inside, cross(omega, v[PLACE]), -1.0), *right[3:]]

    return accelerate


def of_centre(tree: FloatingTree) -> BodyAccelerations:
    """Return accelerations whose first are those of the centre of mass of the base."""

    def accelerate(u: Any, motion: Any, c: Any, moment: Moment, xp: Any = np) -> list[Any]:
        q, _, omega = motion
        right = tree.body_accelerations(u, motion, c, moment, xp)
        faster = sum_of(cross(right[-3:], centre(c)), around(omega, centre(c)))
        return [*sum_of(right[0:3], outward(q, faster)), *right[3:]]

    return accelerate


def uncoupled(scene: Scene) -> Scene:
    """Return a scene whose mass matrix has no entries between hinges and anything else."""

    def mass_matrix(q: Any, c: Any, xp: Any = np) -> list[list[Any]]:
        rows = scene.mass_matrix(q, c, xp)
        hinges = {*range(len(rows))[HINGES]}
        return [
            [entry if i == j or not {i, j} & hinges else 0.0 for j, entry in enumerate(row)]
            for i, row in enumerate(rows)
        ]

    def accelerations(u: Any, q: Any, v: Any, c: Any, xp: Any = np) -> list[Any]:
        return symmetric_solution(mass_matrix(q, c, xp), scene.forces(u, q, v, c, xp))

    return replace(scene, accelerations=accelerations, mass_matrix=mass_matrix, cases=())


def axes_as_opened(tree: FloatingTree) -> FloatingTree:
    """Return a tree in which hinges turn about the axes that they have at the angles 0."""

    def links(q: Any, c: Any, xp: Any = np) -> list[Link]:
        still = tree.links([*q[PLACE], *(0.0 * angle for angle in q[HINGES]), *q[TURN]], c, xp)
        both = zip(tree.links(q, c, xp), still, strict=True)
        return [one._replace(axis=other.axis) for one, other in both]

    return replace(tree, links=links)


def chain_mistakes(scene: Scene, tree: FloatingTree) -> dict[str, Scene]:
    """Return the scene of a chain, whose axes are not parallel, with mistakes in these."""
    first, opened = len(scene.coordinates) - len(COORDINATES), axes_as_opened(tree)
    return {
        "axes of hinges do not turn with the bodies that bear them": replace(
            scene,
            accelerations=accelerations_by(opened.body_accelerations, first),
            mass_matrix=opened.mass_matrix,
            cases=(),
        ),
        "accelerations lack what hinges make of each other by turning the axes beyond them": (
            replace(
                scene,
                accelerations=accelerations_by(changed(tree, with_still_axes), first),
                cases=(),
            )
        ),
    }


# Velocities of the free joint that are another thing

PLACES = ("p_x", "p_y", "p_z")


def placed_from(
    names: tuple[str, ...], velocity: Callable[..., list[Any]]
) -> Callable[..., dict[str, float]]:
    """Return what makes a state of one whose first rates are another velocity."""

    def embedding(p: Any, state: Mapping[str, float]) -> dict[str, float]:
        q, v = ([state[f"{name}{dot}"] for name in names] for dot in ("", "_dot"))
        renamed = dict(zip((f"{name}_dot" for name in PLACES), velocity(p, q, v), strict=True))
        renamed |= dict(zip(PLACES, q, strict=False))
        gone = {f"{axis}{dot}" for axis in AXES for dot in ("", "_dot")}
        return {name: value for name, value in state.items() if name not in gone} | renamed

    return embedding


def swung(p: Any, q: Any, v: Any, sign: float) -> list[Any]:
    """Return the first three rates, with the velocity of the centre of mass by the turn or less."""
    omega = body_rates(q[TURN], v[TURN])[1]
    return sum_of(v[PLACE], outward(q, cross(omega, p.centre)), sign)


def from_centre(p: Any, q: Any, v: Any) -> list[Any]:
    """Return the velocity of the point of the base from that of its centre of mass."""
    return swung(p, q, v, -1.0)


def from_own_frame(p: Any, q: Any, v: Any) -> list[Any]:
    """Return the velocity in the world from that in the frame of the base."""
    return outward(q, v[PLACE])


def at_centre(q: Any, v: Any, c: Any) -> list[Any]:
    """Return the velocity of the centre of mass of the base."""
    omega = body_rates(q[TURN], v[TURN])[1]
    return sum_of(v[PLACE], outward(q, cross(omega, centre(c))))


def in_frame(q: Any, v: Any, c: Any) -> list[Any]:
    """Return the velocity of the point of the base in its frame."""
    return into_body(q[TURN], v[PLACE])


def with_velocities(
    scene: Scene, start: Callable[..., list[Any]], velocity: Callable[..., list[Any]]
) -> Scene:
    """Return a scene whose free joint's velocity is another, at the start and in what is seen."""

    def outputs(q: Any, v: Any, c: Any, xp: Any = np) -> dict[str, Any]:
        rotation = dict(zip(ROTATION, (e for row in matrix(q[TURN]) for e in row), strict=True))
        rates = dict(zip(RATES, body_rates(q[TURN], v[TURN])[1], strict=True))
        moved = dict(zip((f"{axis}_dot" for axis in AXES), velocity(q, v, c), strict=True))
        return dict(zip(AXES, q, strict=False)) | moved | rotation | rates

    units = {f"{name}{dot}": f"m{dot and '/s'}" for name in PLACES for dot in ("", "_dot")}
    return replace(
        scene,
        coordinates=(*PLACES, *scene.coordinates[3:]),
        units=dict(scene.units) | units,
        embedding=placed_from(scene.coordinates, start),
        outputs=outputs,
        cases=(),
    )


def hinge_mistakes(scene: Scene, tree: FloatingTree) -> dict[str, Scene]:
    """Return the scene with each of these mistakes."""
    base = tree.base
    mistakes: Mapping[str, BodyAccelerations] = {
        f"the {base} does not bear the reactions of torques at hinges": changed(
            tree, without_reactions
        ),
        "reactions of torques at hinges act along axes of the world": changed(
            tree, reactions_of_world
        ),
        "bodies that spin on hinges lack their gyroscopic moments": changed(tree, without_spin),
        f"bodies that move on the turning {base} lack Coriolis's force": changed(
            tree, without_coriolis
        ),
        f"accelerations of the free joint are those in the frame of the {base}": in_own_frame(tree),
        f"accelerations of the free joint are those of the {base}'s centre of mass": of_centre(
            tree
        ),
    }
    first = len(scene.coordinates) - len(COORDINATES)
    velocities = {
        f"the free joint's velocity is that of the {base}'s centre of mass": with_velocities(
            scene, from_centre, at_centre
        ),
        f"the free joint's velocity is that in the frame of the {base}": with_velocities(
            scene, from_own_frame, in_frame
        ),
    }
    return {
        **{
            words: replace(scene, accelerations=accelerations_by(accelerate, first), cases=())
            for words, accelerate in mistakes.items()
        },
        f"the inertia that couples {base} and hinges is lost": uncoupled(scene),
        **velocities,
        **{
            f"{words}, in what it returns": replace(scene, outputs=one.outputs, cases=())
            for words, one in velocities.items()
        },
    }

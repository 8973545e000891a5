"""Scenes with a floating base: outputs, conserved quantities, rest, mistakes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ..errors import NoOrbitError
from ..quaternions import cross, matrix
from ..scene import Case, Scene, with_placements, with_rates
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
from .mistakes import with_mistakes
from .rotation import (
    AXES,
    COORDINATES,
    MOMENTUM,
    QUATERNION,
    RATES,
    ROTATION,
    UNITS,
    BodyAccelerations,
    Moment,
    accelerations_by,
    body_rates,
    into_body,
    rotation_outputs,
    sum_of,
)

Change = Callable[[Sides, list[Link], Any], Sides]
"""Function that returns changed `Sides`, from these, the links and (q, v, omega)."""


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
    """Return them without the gyroscopic moments on the base by spin on hinges."""
    turning, still = sides.turning, Rates(NOTHING, NOTHING, NOTHING, NOTHING)
    for one, moment in zip(links, sides.moments.values(), strict=True):
        turning = sum_of(turning, sum_of(moment, spun(one, motion[2], still), -1.0))
    return sides._replace(turning=turning)


def without_coriolis(sides: Sides, links: list[Link], motion: Any) -> Sides:
    """Return them without Coriolis's accelerations of centres of mass that move on the base."""
    moving = rates_of(links, motion[1][HINGES])
    return sides._replace(bent={i: one.bent for i, one in enumerate(moving, 1)})


def with_still_axes(sides: Sides, links: list[Link], motion: Any) -> Sides:
    """Return them without the accelerations that hinges cause by turning the axes beyond them."""
    moving = rates_of(links, motion[1][HINGES], turning=0.0)
    bent, moments = driven(links, motion[2], moving)
    return sides._replace(bent=bent, moments=moments)


def changed(
    tree: FloatingTree, change: Change = lambda sides, links, motion: sides
) -> BodyAccelerations:
    """Return the accelerations of a tree with changed right-hand sides."""

    def accelerate(u: Any, motion: Any, c: Any, moment: Moment, xp: Any = np) -> list[Any]:
        links = tree.links(motion[0], c, xp)
        sides = change(tree.sides(links, motion, c, moment), links, motion)
        return tree.central(links, sides, motion, c)

    return accelerate


def with_first(tree: FloatingTree, first: Callable[..., list[Any]]) -> BodyAccelerations:
    """Return accelerations whose first are others: of (q, v, omega), c and the right ones."""

    def accelerate(u: Any, motion: Any, c: Any, moment: Moment, xp: Any = np) -> list[Any]:
        right = tree.body_accelerations(u, motion, c, moment, xp)
        return [*first(motion, c, right), *right[3:]]

    return accelerate


def in_own_frame(motion: Any, c: Any, right: list[Any]) -> list[Any]:
    """Return the rates of the velocity in the frame of the base."""
    q, v, omega = motion
    return sum_of(into_body(q[TURN], right[0:3]), cross(omega, v[PLACE]), -1.0)


def of_centre(motion: Any, c: Any, right: list[Any]) -> list[Any]:
    """Return the acceleration of the centre of mass of the base."""
    q, _, omega = motion
    faster = sum_of(cross(right[-3:], centre(c)), around(omega, centre(c)))
    return sum_of(right[0:3], outward(q, faster))


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
        "accelerations lack the part that hinges cause by turning the axes beyond them": (
            replace(
                scene,
                accelerations=accelerations_by(changed(tree, with_still_axes), first),
                cases=(),
            )
        ),
    }


# Velocities of the free joint that are another thing

PLACES = ("p_x", "p_y", "p_z")


def swung(arm: Any, q: Any, v: Any, sign: float) -> list[Any]:
    """Return the velocity of a point of the base, by an arm (3,) from or to the one with x'."""
    omega = body_rates(q[TURN], v[TURN])[1]
    return sum_of(v[PLACE], outward(q, cross(omega, arm)), sign)


def with_velocities(
    scene: Scene, start: Callable[..., list[Any]], velocity: Callable[..., list[Any]]
) -> Scene:
    """Return a scene whose free joint has another velocity, at the start and in the outputs."""

    def embedding(p: Any, state: Mapping[str, float]) -> dict[str, float]:
        q, v = ([state[f"{name}{dot}"] for name in scene.coordinates] for dot in ("", "_dot"))
        renamed = dict(zip((f"{name}_dot" for name in PLACES), start(p, q, v), strict=True))
        renamed |= dict(zip(PLACES, q, strict=False))
        gone = {f"{axis}{dot}" for axis in AXES for dot in ("", "_dot")}
        return {name: value for name, value in state.items() if name not in gone} | renamed

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
        embedding=embedding,
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
        f"accelerations of the free joint are those in the frame of the {base}": with_first(
            tree, in_own_frame
        ),
        f"accelerations of the free joint are those of the {base}'s centre of mass": with_first(
            tree, of_centre
        ),
    }
    first = len(scene.coordinates) - len(COORDINATES)
    velocities = {
        f"the free joint's velocity is that of the {base}'s centre of mass": with_velocities(
            scene,
            lambda p, q, v: swung(p.centre, q, v, -1.0),
            lambda q, v, c: swung(centre(c), q, v, 1.0),
        ),
        f"the free joint's velocity is that in the frame of the {base}": with_velocities(
            scene,
            lambda p, q, v: outward(q, v[PLACE]),
            lambda q, v, c: into_body(q[TURN], v[PLACE]),
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
            f"{words}, in its results": replace(scene, outputs=one.outputs, cases=())
            for words, one in velocities.items()
        },
    }


LINEAR = tuple(f"linear_{name}" for name in MOMENTUM)
"""Components in the world of the linear momentum."""


def outputs(tree: FloatingTree, q: Any, v: Any, c: Any, xp: Any = np) -> dict[str, Any]:
    """Return attitude, body rates, both momenta, energy, length of q.

    The angular momentum is that about the centre of mass.
    """
    turning, energy = tree.angular_momentum(q, v, c), tree.energy(q, v, c)
    rotation = rotation_outputs(q[-4:], v[-4:], turning, energy, xp)
    return rotation | dict(zip(LINEAR, tree.momentum(q, v, c), strict=True))


def component(of: Callable[..., list[Any]], axis: int, q: Any, v: Any, c: Any) -> Any:
    """Return one of the components of a vector."""
    return of(q, v, c)[axis]


def invariants(
    tree: FloatingTree, keeps_energy: Callable[[Any], bool], p: Any
) -> Mapping[str, Callable[..., Any]]:
    """Return the angular momentum; without gravity the linear one; energy, if it is kept."""
    known: dict[str, Callable[..., Any]] = {}
    if keeps_energy(p):
        known["energy"] = tree.energy
    for axis, (turning, moving) in enumerate(zip(MOMENTUM, LINEAR, strict=True)):
        known[turning] = partial(component, tree.angular_momentum, axis)
        if not np.any(p.gravity):
            known[moving] = partial(component, tree.momentum, axis)
    return known


def afloat(name: str, p: Any) -> dict[str, float]:
    """Return the state of rest, which is any place and attitude with the springs relaxed.

    Raises
    ------
    NoOrbitError
        If it falls.
    """
    if np.any(p.gravity):
        raise NoOrbitError(f"nothing holds {name}: with gravity it falls")
    return {}


def floating_scene(
    tree: FloatingTree,
    coefficients_of: Callable[..., Any],
    keeps_energy: Callable[[Any], bool],
    placed: Case,
    **fields: Any,
) -> Scene:
    """Return the scene of a tree.

    Parameters
    ----------
    tree : FloatingTree
    coefficients_of : callable ``(parameters, inertia tensor) -> c``
    keeps_energy : callable ``(parameters) -> bool``
        Whether nothing drives it and nothing damps.
    placed : Case
        Case with a turned model in the default set; a mirror image has other quaternions.
    fields :
        Others of `Scene`; of ``coordinates`` and ``units`` those of the hinges alone.
    """
    hinges = fields.pop("coordinates")
    units = {**dict.fromkeys(AXES, "m"), **fields.pop("units"), **dict.fromkeys(COORDINATES, "1")}
    scene = Scene(
        coordinates=(*AXES, *hinges, *COORDINATES),
        quaternions=(QUATERNION._replace(place=tuple(AXES)),),
        units=with_rates(**units) | UNITS | dict.fromkeys(LINEAR, "kg m/s"),
        eliminates=True,
        mass_matrix=tree.mass_matrix,
        forces=tree.forces,
        accelerations=accelerations_by(tree.body_accelerations, 3 + len(hinges)),
        energy=tree.energy,
        outputs=partial(outputs, tree),
        observed=(*ROTATION, *RATES),
        equilibria={"afloat": partial(afloat, fields["name"])},
        invariants=partial(invariants, tree, keeps_energy),
        placed=with_placements(placed, "algebra")[:1],
        **fields,
    )
    turning = {
        words: one
        for words, one in with_mistakes(scene, tree.body_accelerations, coefficients_of).items()
        if "gravity" not in words  # of which no torque acts about the centre of mass
    }
    return replace(scene, mistakes=turning | hinge_mistakes(scene, tree))

"""An MJCF model in its own joints: what it holds, and the forces and inertias of each part.

Read from the text alone, by no engine: kinematics of a tree of hinges and slides (Featherstone,
*Rigid Body Dynamics Algorithms*, 2008, chapters 4 and 6), springs, dampers, tendons, actuators and
loops. It understands what the models here use, and refuses the rest.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np

from ..reference.errors import CannotJudgeError
from ..reference.scene import Array, Case

TINY = 1e-30
"""Step of complex differences: exact to rounding."""


@dataclass(frozen=True)
class Term:
    """A spring, damper, tendon or actuator: a force along a weighted sum of joints.

    Along the length ``L = sum(factor * joint)`` it acts with the generalised force
    ``constant + per_length L + per_rate L'`` (N or N m).

    Attributes
    ----------
    kind : {"spring", "damper", "tendon_spring", "tendon_damper", "actuator"}
    name : str
        Of the joint, tendon or actuator.
    joints : mapping of joint to factor
    constant, per_length, per_rate : float
    until : float or None
        Time [s] from which it no longer acts.
    """

    kind: str
    name: str
    joints: Mapping[str, float]
    constant: float = 0.0
    per_length: float = 0.0
    per_rate: float = 0.0
    until: float | None = None


@dataclass(frozen=True)
class Joint:
    """A hinge or a slide; its position is ``ref`` where the file places its body."""

    name: str
    hinge: bool
    axis: Array
    anchor: Array
    ref: float
    armature: float


@dataclass(frozen=True)
class Body:
    """A rigid body: its place in its parent's frame, its joint, its inertia (principal, at com)."""

    name: str
    parent: int
    position: Array
    rotation: Array
    joints: tuple[int, ...]
    mass: float
    centre: Array
    inertia: Array


@dataclass(frozen=True)
class Site:
    """A point of a body."""

    body: int
    position: Array


@dataclass(frozen=True)
class Closure:
    """Two points that a loop's constraint holds together."""

    name: str
    first: Site
    second: Site


@dataclass(frozen=True, eq=False)  # hashable: what is derived of it is kept by it
class Mechanism:
    """What an MJCF file holds, as far as it moves."""

    joints: tuple[Joint, ...]
    bodies: tuple[Body, ...]
    terms: tuple[Term, ...]
    closures: tuple[Closure, ...]
    gravity: Array


@dataclass(frozen=True, eq=False)
class System:
    """What an engine is to simulate: a model of a scene, with the parameters of a case.

    Attributes
    ----------
    case : Case
        Its ``scene``, ``name`` and ``parameters`` say what it is.
    model : str
        Name of the MJCF model; ``scene`` for an engine that reads none.
    joints : tuple of str
        Names of all joints, in the order of the file; all vectors here are in this order. For
        an engine that reads no MJCF, the scene's coordinates.
    positions, velocities : array (n,)
        The initial state (m, rad and 1/s of them).
    start_time : float
        Time of the initial state [s].
    mjcf : str
        Text of the file, parameters applied; empty for an engine that reads none.
    terms : tuple of Term
        Its springs, dampers, tendons and actuators, which include all forcing.
    armatures : mapping of joint to float
        Inertia added to the diagonal of the mass matrix (kg, kg m^2).
    closures : tuple of Closure
        Loops, held closed by constraints.
    """

    case: Case
    model: str
    joints: tuple[str, ...]
    positions: Array
    velocities: Array
    start_time: float = 0.0
    mjcf: str = ""
    terms: tuple[Term, ...] = ()
    armatures: Mapping[str, float] | None = None
    closures: tuple[Closure, ...] = ()

    def force(self, time: float, positions: Array, velocities: Array) -> Array:
        """Return the generalised force (n,) of all `terms` at a time [s] and state (n,), (n,)."""
        factors, constant, per_length, per_rate, until = self._rows
        along = constant + per_length * (factors @ positions) + per_rate * (factors @ velocities)
        found: Array = np.where(time < until, along, 0.0) @ factors
        return found

    @cached_property
    def _rows(self) -> tuple[Array, Array, Array, Array, Array]:
        """All terms together: factors (k, n), the numbers of each (k,), and when it ends (k,)."""
        numbers = np.array([(t.constant, t.per_length, t.per_rate) for t in self.terms])
        ends = [np.inf if t.until is None else t.until for t in self.terms]
        factors = [[t.joints.get(name, 0.0) for name in self.joints] for t in self.terms]
        shape = len(self.terms), len(self.joints)
        return np.reshape(factors, shape), *numbers.reshape(-1, 3).T, np.array(ends)


def term_force(term: Term, joints: tuple[str, ...], positions: Array, velocities: Array) -> Array:
    """Return the generalised force (n,) of one term."""
    factors = np.array([term.joints.get(name, 0.0) for name in joints])
    length, rate = factors @ positions, factors @ velocities
    return factors * (term.constant + term.per_length * length + term.per_rate * rate)


# Reading


@lru_cache(maxsize=64)
def mechanism(text: str) -> Mechanism:
    """Read MJCF.

    Raises
    ------
    CannotJudgeError
        If it holds what this module does not understand.
    """
    root = ET.fromstring(text)
    refuse_unknown(root)
    defaults = default_classes(root)
    joints: list[Joint] = []
    bodies: list[Body] = [
        Body("world", -1, np.zeros(3), np.eye(3), (), 0.0, np.zeros(3), np.zeros(3))
    ]
    sites: dict[str, Site] = {}
    terms: list[Term] = []

    def visit(element: ET.Element, parent: int, inherited: str) -> None:
        about = element.find("inertial")
        mine: list[int] = []
        number = len(bodies)
        here = element.get("childclass", inherited)
        for item in element.findall("joint"):
            told = settings(item, defaults, here)
            mine.append(len(joints))
            joints.append(joint(told))
            terms.extend(passive(told))
        placed = {} if about is None else dict(about.attrib)
        bodies.append(
            Body(
                element.get("name", ""),
                parent,
                vector(element.get("pos", "0 0 0")),
                euler(vector(element.get("euler", "0 0 0"))),
                tuple(mine),
                float(placed.get("mass", 0)),
                vector(placed.get("pos", "0 0 0")),
                vector(placed.get("diaginertia", "0 0 0")),
            )
        )
        children(element, number, here)

    def children(element: ET.Element, number: int, here: str) -> None:
        for item in element.findall("site"):
            if item.get("name"):
                sites[item.get("name", "")] = Site(number, vector(item.get("pos", "0 0 0")))
        for item in element.findall("body"):
            visit(item, number, here)

    world = root.find("worldbody")
    assert world is not None
    children(world, 0, "main")
    tendons = {}
    for item in root.iterfind("tendon/fixed"):
        told = settings(item, defaults, "main")
        reach = MappingProxyType(
            {part.get("joint", ""): float(part.get("coef", 1)) for part in item}
        )
        tendons[told["name"]] = reach
        terms.extend(sprung("tendon_", told, reach, told.get("springlength", "0")))
    for item in root.iterfind("actuator/general"):
        terms.append(actuator(settings(item, defaults, "main"), tendons))
    option = root.find("option")
    gravity = "0 0 -9.81" if option is None else option.get("gravity", "0 0 -9.81")
    return Mechanism(
        tuple(joints),
        tuple(bodies),
        tuple(terms),
        tuple(
            Closure(
                item.get("name", ""), sites[item.get("site1", "")], sites[item.get("site2", "")]
            )
            for item in root.iterfind("equality/connect")
        ),
        vector(gravity),
    )


KNOWN = {
    "worldbody//": {"body", "joint", "inertial", "site", "geom"},
    "tendon/": {"fixed"},
    "tendon/fixed/": {"joint"},
    "actuator/": {"general"},
    "equality/": {"connect"},
}
"""Elements that are understood, by their place."""


def refuse_unknown(root: ET.Element) -> None:
    """Refuse elements that would be passed over.

    Raises
    ------
    CannotJudgeError
    """
    for place, known in KNOWN.items():
        for item in root.iterfind(f"{place}*"):
            if item.tag not in known:
                raise CannotJudgeError(f"MJCF element {item.tag} is not understood")


def default_classes(root: ET.Element) -> dict[tuple[str, str], dict[str, str]]:
    """Return what each default class says of each tag, with what it inherits."""
    found: dict[tuple[str, str], dict[str, str]] = {}

    def visit(element: ET.Element, name: str, above: Mapping[str, dict[str, str]]) -> None:
        here = {tag: dict(said) for tag, said in above.items()}
        for item in element:
            if item.tag != "default":
                here.setdefault(item.tag, {}).update(item.attrib)
        found.update({(name, tag): said for tag, said in here.items()})
        for item in element.findall("default"):
            visit(item, item.get("class", ""), here)

    for top in root.findall("default"):
        visit(top, top.get("class", "main"), {})
    return found


def settings(
    item: ET.Element, defaults: Mapping[tuple[str, str], dict[str, str]], inherited: str
) -> dict[str, str]:
    """Return the attributes of an element, those of its default class included."""
    return {**defaults.get((item.get("class", inherited), item.tag), {}), **item.attrib}


def vector(text: str) -> Array:
    """Return the numbers in an attribute."""
    found = np.array([float(word) for word in text.split()])
    found.flags.writeable = False  # what is read is kept, and shown to engines
    return found


def euler(angles: Array) -> Array:
    """Return the rotation (3, 3) of MuJoCo's angles: about x, then the new y, the new z."""
    x, y, z = (turn(axis, angle) for axis, angle in zip(np.eye(3), angles, strict=True))
    found: Array = x @ y @ z
    return found


def joint(told: Mapping[str, str]) -> Joint:
    """Return a joint from its attributes."""
    kind = told.get("type", "hinge")
    if kind not in ("hinge", "slide"):
        raise CannotJudgeError(f"joint {told.get('name')} is a {kind}: hinges and slides only")
    axis = vector(told.get("axis", "0 0 1"))
    return Joint(
        told["name"],
        kind == "hinge",
        axis / np.linalg.norm(axis),
        vector(told.get("pos", "0 0 0")),
        float(told.get("ref", 0)),
        float(told.get("armature", 0)),
    )


def passive(told: Mapping[str, str]) -> Iterator[Term]:
    """Yield the spring and the damper of a joint."""
    yield from sprung("", told, MappingProxyType({told["name"]: 1.0}), told.get("springref", "0"))


def sprung(
    prefix: str, told: Mapping[str, str], reach: Mapping[str, float], rest: str
) -> Iterator[Term]:
    """Yield the spring and the damper that attributes speak of."""
    stiffness, damping = float(told.get("stiffness", 0)), float(told.get("damping", 0))
    if stiffness:
        pull = stiffness * float(rest)
        yield Term(f"{prefix}spring", told["name"], reach, pull, -stiffness)
    if damping:
        yield Term(f"{prefix}damper", told["name"], reach, per_rate=-damping)


def actuator(told: Mapping[str, str], tendons: Mapping[str, Mapping[str, float]]) -> Term:
    """Return an actuator whose force is an affine bias, without control."""
    name = told.get("name", "")
    if "joint" in told:
        reach: Mapping[str, float] = MappingProxyType({told["joint"]: 1.0})
    elif "tendon" in told:
        reach = tendons[told["tendon"]]
    else:
        raise CannotJudgeError(f"actuator {name} acts on no joint and no fixed tendon")
    if vector(told.get("gainprm", "1"))[0] != 0 or told.get("biastype") != "affine":
        raise CannotJudgeError(f"actuator {name} takes a control; only an affine bias is known")
    bias = vector(told["biasprm"])
    return Term("actuator", name, reach, *(float(value) for value in bias[:3]))


def switched_off(terms: Iterable[Term], time: float) -> tuple[Term, ...]:
    """Return the terms, all actuators switched off from a time [s] on."""
    return tuple(replace(t, until=time) if t.kind == "actuator" else t for t in terms)


# Kinematics


def turn(axis: Array, angle: Any) -> Array:
    """Return the rotation (3, 3) about a unit axis (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    found: Array = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return found


@dataclass(frozen=True)
class Placed:
    """A mechanism at one position: bodies' frames, joints' axes and anchors (n, 3) in the world."""

    whole: Mechanism
    rotations: list[Array]
    origins: list[Array]
    axes: Array
    anchors: Array

    def point(self, site: Site) -> Array:
        """Return a point in the world (3,)."""
        return self.origins[site.body] + self.rotations[site.body] @ site.position

    def jacobian(self, site: Site) -> Array:
        """Return the velocity (3, n) of a point per rate of each joint."""
        hinges, slides = movers(self.whole)[site.body]
        found = np.zeros_like(self.axes)
        found[slides] = self.axes[slides]
        found[hinges] = np.cross(self.axes[hinges], self.point(site) - self.anchors[hinges])
        return found.T

    def turning(self, body: int) -> Array:
        """Return the angular velocity (3, n) of a body per rate of each joint."""
        hinges, _ = movers(self.whole)[body]
        found = np.zeros_like(self.axes)
        found[hinges] = self.axes[hinges]
        return found.T


@lru_cache(maxsize=64)
def movers(whole: Mechanism) -> tuple[tuple[list[int], list[int]], ...]:
    """Return the hinges, and the slides, that move each body."""
    found: list[tuple[list[int], list[int]]] = []
    for body in whole.bodies:
        hinges, slides = found[body.parent] if body.parent >= 0 else ([], [])
        own = [i for i in body.joints if whole.joints[i].hinge]
        found.append(([*hinges, *own], [*slides, *(set(body.joints) - set(own))]))
    return tuple(found)


def place(whole: Mechanism, q: Array) -> Placed:
    """Return a mechanism at joint positions (n,), which may be complex."""
    rotations, origins = [np.eye(3)], [np.zeros(3)]
    axes, anchors = np.zeros((2, len(q), 3), dtype=q.dtype)
    for body in whole.bodies[1:]:
        rotation = rotations[body.parent] @ body.rotation
        origin = origins[body.parent] + rotations[body.parent] @ body.position
        for i in body.joints:
            one = whole.joints[i]
            moved = q[i] - one.ref
            axes[i], anchors[i] = rotation @ one.axis, origin + rotation @ one.anchor
            if one.hinge:
                rotation = rotation @ turn(one.axis, moved)
                origin = anchors[i] - rotation @ one.anchor
            else:
                origin = origin + moved * axes[i]
        rotations.append(rotation)
        origins.append(origin)
    return Placed(whole, rotations, origins, axes, anchors)


def inertias(whole: Mechanism, q: Array) -> dict[str, Array]:
    """Return what each part adds to the mass matrix (n, n): masses, inertias, armatures."""
    placed = place(whole, q)
    found: dict[str, Array] = {}
    for i, body in enumerate(whole.bodies):
        if not any(movers(whole)[i]):
            continue
        if body.mass:
            moving = placed.jacobian(Site(i, body.centre))
            found[f"mass.{body.name}"] = body.mass * moving.T @ moving
        if np.any(body.inertia):
            turning = placed.rotations[i].T @ placed.turning(i)
            found[f"inertia.{body.name}"] = turning.T @ (body.inertia[:, None] * turning)
    for i, one in enumerate(whole.joints):
        if one.armature:
            matrix = np.zeros((len(q), len(q)))
            matrix[i, i] = one.armature
            found[f"armature.{one.name}"] = matrix
    return found


def mass_matrix(whole: Mechanism, q: Array) -> Array:
    """Return the mass matrix (n, n) of all joints at positions (n,)."""
    found: Array = np.sum(list(inertias(whole, q).values()), axis=0)
    return found


def inertial_force(whole: Mechanism, q: Array, v: Array) -> Array:
    """Return Coriolis and centrifugal forces (n,): dM/dt v - grad(v M v)/2."""
    along = mass_matrix(whole, q + 1j * TINY * v).imag / TINY @ v
    slopes = [
        v @ (mass_matrix(whole, q + 1j * TINY * unit).imag / TINY) @ v for unit in np.eye(len(q))
    ]
    found: Array = along - np.array(slopes) / 2
    return found


def weight(whole: Mechanism, q: Array, gravity: Array) -> Array:
    """Return the generalised force (n,) of a gravity (3,) on all bodies."""
    placed = place(whole, q)
    found: Array = np.sum(
        [
            body.mass * gravity @ placed.jacobian(Site(i, body.centre))
            for i, body in enumerate(whole.bodies)
        ],
        axis=0,
    )
    return found


def gaps(whole: Mechanism, q: Array) -> Array:
    """Return how far each loop is open (3 k,) [m]."""
    placed = place(whole, q)
    open_by = [placed.point(one.first) - placed.point(one.second) for one in whole.closures]
    return np.concatenate(open_by) if open_by else np.zeros(0)


def gap_jacobian(whole: Mechanism, q: Array) -> Array:
    """Return the rate at which loops open (3 k, n) per rate of each joint."""
    placed = place(whole, q)
    rates = [placed.jacobian(one.first) - placed.jacobian(one.second) for one in whole.closures]
    return np.concatenate(rates) if rates else np.zeros((0, len(q)))


def gap_drift(whole: Mechanism, q: Array, v: Array) -> Array:
    """Return dJ/dt v (3 k,) of the loops [m/s^2]."""
    found: Array = gap_jacobian(whole, q + 1j * TINY * v).imag / TINY @ v
    return found

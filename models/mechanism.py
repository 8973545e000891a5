"""A mechanism read from the text of an MJCF file, by no engine.

Bodies in a tree of joints, springs, dampers, tendons, actuators and loops. The reader understands
what the models here use, and refuses the rest.
"""

from __future__ import annotations

import copyreg
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import cos
from types import MappingProxyType
from typing import Any

import numpy as np

from ..reference import quaternions
from ..reference.errors import CannotJudgeError
from ..reference.scene import Array
from .joints import SIZES, SPATIAL, JointLayout, layout_of


def read_only(values: dict[str, Any]) -> MappingProxyType[str, Any]:
    """Return a view of values that does not allow to change them."""
    return MappingProxyType(values)


copyreg.pickle(MappingProxyType, lambda proxy: (read_only, (dict(proxy),)))  # for processes


@dataclass(frozen=True)
class Term:
    """A spring, damper, tendon or actuator: a force along a weighted sum of joints.

    Along the length ``L = sum(factor * joint)`` it acts with the generalised force
    ``constant + per_length L + per_rate L' + amplitude cos(omega t + phase)`` (N or N m).

    Attributes
    ----------
    kind : {"spring", "damper", "tendon_spring", "tendon_damper", "actuator"}
    name : str
        Of the joint, tendon or actuator.
    joints : mapping of joint to factor
    constant, per_length, per_rate : float
    amplitude, omega, phase : float
        Force of an actuator that a control drives (N or N m, rad/s, rad).
    until : float or None
        Time [s] from which it no longer acts.
    """

    kind: str
    name: str
    joints: Mapping[str, float]
    constant: float = 0.0
    per_length: float = 0.0
    per_rate: float = 0.0
    amplitude: float = 0.0
    omega: float = 0.0
    phase: float = 0.0
    until: float | None = None

    def control(self, time: float) -> float:
        """Return the part of its force that depends on time alone (N or N m) at a time [s]."""
        on = self.until is None or time < self.until
        return self.amplitude * cos(self.omega * time + self.phase) if on else 0.0


@dataclass(frozen=True)
class Joint:
    """A joint; the position of a hinge or a slide is ``ref`` where the file places its body."""

    name: str
    kind: str
    axis: Array
    anchor: Array
    ref: float
    armature: float

    @property
    def hinge(self) -> bool:
        """Whether it is a hinge."""
        return self.kind == "hinge"


@dataclass(frozen=True)
class Body:
    """A rigid body: its place in its parent's frame, its joints, its inertia.

    The inertia tensor (3, 3) is about the centre of mass, in the frame of the body.
    """

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
    """Two points that a loop's constraint holds together.

    Attributes
    ----------
    name : str
    first, second : Site
    solref : array (2,)
        MJCF's softness: a time constant [s] and a damping ratio, or, below 0, minus the stiffness
        [1/s^2] and minus the damping [1/s].
    """

    name: str
    first: Site
    second: Site
    solref: Array


@dataclass(frozen=True, eq=False)  # hashable: a key of caches
class Mechanism:
    """The moving parts of an MJCF file."""

    joints: tuple[Joint, ...]
    bodies: tuple[Body, ...]
    terms: tuple[Term, ...]
    closures: tuple[Closure, ...]
    gravity: Array

    @cached_property
    def layout(self) -> JointLayout:
        """Places of its joints in vectors."""
        return layout_of(tuple(one.kind for one in self.joints))


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
        Body("world", -1, np.zeros(3), np.eye(3), (), 0.0, np.zeros(3), np.zeros((3, 3)))
    ]
    sites: dict[str, Site] = {}
    terms: list[Term] = []

    def visit(element: ET.Element, parent: int, inherited: str) -> None:
        about = element.find("inertial")
        mine: list[int] = []
        number = len(bodies)
        for _, attributes in own_joints(element, defaults, inherited):
            mine.append(len(joints))
            joints.append(joint(attributes))
            terms.extend(passive(attributes, joints[-1]))
        placed = {} if about is None else dict(about.attrib)
        bodies.append(
            Body(
                element.get("name", ""),
                parent,
                vector(element.get("pos", "0 0 0")),
                orientation(element.attrib),
                tuple(mine),
                float(placed.get("mass", 0)),
                vector(placed.get("pos", "0 0 0")),
                tensor(placed),
            )
        )
        children(element, number, element.get("childclass", inherited))

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
        attributes = settings(item, defaults, "main")
        reach = MappingProxyType(
            {part.get("joint", ""): float(part.get("coef", 1)) for part in item}
        )
        tendons[attributes["name"]] = reach
        terms.extend(sprung("tendon_", attributes, reach, attributes.get("springlength", "0")))
    for item in root.iterfind("actuator/*"):
        terms.append(actuator(item.tag, settings(item, defaults, "main"), tendons))
    option = root.find("option")
    gravity = "0 0 -9.81" if option is None else option.get("gravity", "0 0 -9.81")
    return Mechanism(
        tuple(joints),
        tuple(bodies),
        tuple(terms),
        tuple(
            Closure(
                item.get("name", ""),
                sites[item.get("site1", "")],
                sites[item.get("site2", "")],
                vector(item.get("solref", "0.02 1")),
            )
            for item in root.iterfind("equality/connect")
        ),
        vector(gravity),
    )


@lru_cache(maxsize=64)
def joint_places(text: str) -> Mapping[str, float | None]:
    """Return the place of each joint as the file opens, of a file that need not be understood.

    None of ball and free joints.
    """
    root, places = ET.fromstring(text), dict[str, float | None]()
    for world in root.findall("worldbody"):
        for item, said in each_joint(world, default_classes(root)):
            spatial = said.get("type") in SPATIAL
            places[item.get("name", "")] = None if spatial else float(said.get("ref", 0))
    return MappingProxyType(places)


def own_joints(
    element: ET.Element, defaults: Mapping[tuple[str, str], dict[str, str]], inherited: str
) -> Iterator[tuple[ET.Element, dict[str, str]]]:
    """Yield the joints of a body, each with its attributes and those of its default class."""
    here = element.get("childclass", inherited)
    for item in element:
        if item.tag == "joint":
            yield item, settings(item, defaults, here)
        elif item.tag == "freejoint":
            yield item, {**item.attrib, "type": "free"}


def each_joint(
    element: ET.Element, defaults: Mapping[tuple[str, str], dict[str, str]], inherited: str = "main"
) -> Iterator[tuple[ET.Element, dict[str, str]]]:
    """Yield `own_joints` of an element and of all bodies below it."""
    yield from own_joints(element, defaults, inherited)
    for item in element.findall("body"):
        yield from each_joint(item, defaults, element.get("childclass", inherited))


KNOWN = {
    "worldbody//": {"body", "joint", "freejoint", "inertial", "site", "geom"},
    "tendon/": {"fixed"},
    "tendon/fixed/": {"joint"},
    "actuator/": {"general", "motor"},
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
    """Return the attributes of each default class for each tag, inherited ones included."""
    defaults: dict[tuple[str, str], dict[str, str]] = {}

    def visit(element: ET.Element, name: str, above: Mapping[str, dict[str, str]]) -> None:
        here = {tag: dict(said) for tag, said in above.items()}
        for item in element:
            if item.tag != "default":
                here.setdefault(item.tag, {}).update(item.attrib)
        defaults.update({(name, tag): said for tag, said in here.items()})
        for item in element.findall("default"):
            visit(item, item.get("class", ""), here)

    for top in root.findall("default"):
        visit(top, top.get("class", "main"), {})
    return defaults


def settings(
    item: ET.Element, defaults: Mapping[tuple[str, str], dict[str, str]], inherited: str
) -> dict[str, str]:
    """Return the attributes of an element, those of its default class included."""
    return {**defaults.get((item.get("class", inherited), item.tag), {}), **item.attrib}


def vector(text: str) -> Array:
    """Return the numbers in an attribute."""
    numbers = np.array([float(word) for word in text.split()])
    numbers.flags.writeable = False  # what is read is kept, and shown to engines
    return numbers


def turn(axis: Array, angle: Any) -> Array:
    """Return the rotation (3, 3) about a unit axis (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)


def orientation(attributes: Mapping[str, str]) -> Array:
    """Return the rotation (3, 3) of a frame, from any attribute but ``axisangle``."""
    if "axisangle" in attributes:
        raise CannotJudgeError("MJCF attribute axisangle is not understood")
    if "quat" in attributes:
        return np.array(quaternions.matrix(vector(attributes["quat"])))
    if "zaxis" in attributes:  # the shortest way from z
        ahead = vector(attributes["zaxis"])
        cross = np.array([-ahead[1], ahead[0], 0.0])
        length = np.linalg.norm(cross)
        about = cross / length if length else np.eye(3)[0]
        return turn(about, np.arctan2(length, ahead[2]))
    if "xyaxes" in attributes:
        x, y = vector(attributes["xyaxes"]).reshape(2, 3)
        x = x / np.linalg.norm(x)
        y = y - (y @ x) * x
        y = y / np.linalg.norm(y)
        return np.column_stack([x, y, np.cross(x, y)])
    x, y, z = map(turn, np.eye(3), vector(attributes.get("euler", "0 0 0")))
    return np.asarray(x @ y @ z)  # about x, then the new y, the new z


def tensor(placed: Mapping[str, str]) -> Array:
    """Return an inertia tensor (3, 3) in the frame of its body."""
    if "fullinertia" in placed:
        xx, yy, zz, xy, xz, yz = vector(placed["fullinertia"])
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    principal = np.diag(vector(placed.get("diaginertia", "0 0 0")))
    axes = orientation(placed)
    return axes @ principal @ axes.T


def joint(attributes: Mapping[str, str]) -> Joint:
    """Return a joint from its attributes."""
    kind = attributes.get("type", "hinge")
    if kind not in SIZES:
        raise CannotJudgeError(f"joint {attributes.get('name')} is a {kind}, which MJCF has not")
    axis = vector(attributes.get("axis", "0 0 1"))
    return Joint(
        attributes["name"],
        kind,
        axis / np.linalg.norm(axis),
        vector(attributes.get("pos", "0 0 0")),
        float(attributes.get("ref", 0)),
        float(attributes.get("armature", 0)),
    )


def passive(attributes: Mapping[str, str], one: Joint) -> Iterator[Term]:
    """Yield the spring and the damper of a joint.

    Raises
    ------
    CannotJudgeError
        If it is a free joint, or a ball joint with a spring: their lengths are no sums of joints.
    """
    refused = {"ball": ("stiffness",), "free": ("stiffness", "damping")}.get(one.kind, ())
    for name in refused:
        if float(attributes.get(name, 0)):
            raise CannotJudgeError(f"the {one.kind} joint {one.name} has a {name}")
    reach = MappingProxyType({attributes["name"]: 1.0})
    yield from sprung("", attributes, reach, attributes.get("springref", "0"))


def sprung(
    prefix: str, attributes: Mapping[str, str], reach: Mapping[str, float], rest: str
) -> Iterator[Term]:
    """Yield the spring and the damper that attributes speak of."""
    stiffness, damping = float(attributes.get("stiffness", 0)), float(attributes.get("damping", 0))
    if stiffness:
        pull = stiffness * float(rest)
        yield Term(f"{prefix}spring", attributes["name"], reach, pull, -stiffness)
    if damping:
        yield Term(f"{prefix}damper", attributes["name"], reach, per_rate=-damping)


def actuator(
    tag: str, attributes: Mapping[str, str], tendons: Mapping[str, Mapping[str, float]]
) -> Term:
    """Return an actuator whose force is an affine bias, or a motor, whose force is its control."""
    name = attributes.get("name", "")
    if "joint" in attributes:
        reach: Mapping[str, float] = MappingProxyType({attributes["joint"]: 1.0})
    elif "tendon" in attributes:
        reach = tendons[attributes["tendon"]]
    else:
        raise CannotJudgeError(f"actuator {name} acts on no joint and no fixed tendon")
    if tag == "motor" and "gear" not in attributes:
        return Term("actuator", name, reach)
    if vector(attributes.get("gainprm", "1"))[0] != 0 or attributes.get("biastype") != "affine":
        raise CannotJudgeError(f"actuator {name} takes a control; only an affine bias is known")
    bias = vector(attributes["biasprm"])
    return Term("actuator", name, reach, *(float(value) for value in bias[:3]))


def switched_off(terms: Iterable[Term], time: float) -> tuple[Term, ...]:
    """Return the terms, all actuators switched off from a time [s] on."""
    return tuple(replace(t, until=time) if t.kind == "actuator" else t for t in terms)

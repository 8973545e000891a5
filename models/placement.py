"""A model placed in the world by a rotation, or as its mirror image: the text of MJCF, rewritten.

Each body and each site of the world is written with ``pos`` and ``quat``, and ``gravity`` is
turned with them. Joints and all attributes in the frame of a body stay as they are, so that
positions and rates of joints, and motions relative to the mechanism, are those of the model in the
file. A free joint alone has its place, its velocity and its quaternion in the world, and these are
turned.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from ..reference.errors import UsageError
from ..reference.quaternions import product
from ..reference.scene import Array
from .joints import SIZES, SPATIAL
from .mechanism import default_classes, each_joint, orientation, refuse_unknown, vector
from .mjcf import Motion, attribute_text

FORM = re.compile(r"(turned|mirrored):([0-9]{1,9})")

MIRROR = np.diag([1.0, -1.0, 1.0])
"""The mirror image: y is reversed in each frame, so that slides along it and hinges about x and z
are reversed. The x axis of a frame, along which outputs are measured, is not."""

UNEQUAL = (0.6, 0.7, 1.0)
"""Shares of a body's moments of inertia about x, y, z. The last one counts: in plane motion no
other is seen, unless an engine leaves the tensor behind as the body is turned."""

PLANE = 1e-12
"""Component of a unit axis below which it lies in the plane."""


@cache
def world_axes(placement: str) -> Array:
    """Return the matrix (3, 3) from the axes of a model to those of the world it is placed in.

    Parameters
    ----------
    placement : str
        ``turned:SEED``, a rotation drawn at random; ``mirrored:SEED``, that of the mirror image;
        empty: as in the file.

    Raises
    ------
    UsageError
        If it is none of these.
    """
    if not placement:
        return np.eye(3)
    match = FORM.fullmatch(placement)
    if match is None:
        raise UsageError(f"placement {placement!r}: write turned:SEED, mirrored:SEED or none")
    random = np.random.default_rng(int(match[2]))
    axes: Array = Rotation.from_quat(random.normal(size=4)).as_matrix()
    axes = axes if match[1] == "turned" else axes @ MIRROR
    axes.flags.writeable = False
    return axes


def right_handed(axes: Array) -> Array:
    """Return axes (3, 3) with the third turned over where they are a mirror's.

    A mechanism in the plane of x and y is symmetric to that plane: its mirror image is the same
    mechanism, turned.
    """
    return axes if np.linalg.det(axes) > 0 else axes * [1.0, 1.0, -1.0]


def placed(text: str, placement: str) -> str:
    """Return MJCF of the same model, placed in the world.

    Raises
    ------
    CannotJudgeError
        If it holds what this module does not understand.
    UsageError
        As of `world_axes`.
    """
    if not placement:
        return text
    axes = world_axes(placement)
    root = ET.fromstring(text)
    refuse_unknown(root)
    world = root.find("worldbody")
    assert world is not None
    defaults = default_classes(root)
    if is_plane(world, defaults):
        make_inertias_unequal(world)
    rotation = axes
    if np.linalg.det(axes) < 0:
        rotation = axes @ MIRROR
        mirror(world, defaults)
    for element in world:
        turn_points(element, rotation)
        write_orientation(element, rotation @ orientation(element.attrib))
    option = root.find("option")
    if option is None:
        option = ET.SubElement(root, "option")
    gravity = vector(option.get("gravity", "0 0 -9.81"))
    option.set("gravity", attribute_text(tuple(axes @ gravity)))
    return ET.tostring(root, encoding="unicode")


def turn_quaternion(axes: Array) -> Array:
    """Return the matrix (4, 4) by which a rotation (3, 3) turns a quaternion."""
    x, y, z, w = Rotation.from_matrix(axes).as_quat()
    return np.array([product([w, x, y, z], unit) for unit in np.eye(4)]).T


def placed_motion(motion: Motion, placement: str) -> Motion:
    """Return positions and velocities of joints of a model with this placement."""
    if not placement:
        return motion
    axes = world_axes(placement)
    return {
        name: (
            np.concatenate([axes @ q[:3], turn_quaternion(axes) @ q[3:]]),
            np.concatenate([axes @ v[:3], v[3:]]),
        )
        if np.size(q) == SIZES["free"][0]
        else (q, v)
        for name, (q, v) in motion.items()
    }


def unplaceable_reason(text: str, placement: str) -> str | None:
    """Return the reason why a model cannot be placed in the world in this way, or None."""
    root = ET.fromstring(text)
    world, defaults = root.find("worldbody"), default_classes(root)
    assert world is not None
    kinds = {attributes.get("type", "hinge") for _, attributes in each_joint(world, defaults)}
    spatial = kinds & {*SPATIAL}
    if spatial and np.linalg.det(world_axes(placement)) < 0:
        return f"its {min(spatial)} joint has a quaternion, which is another one in a mirror"
    return None


def axis_of(attributes: Mapping[str, str]) -> Array:
    """Return the axis (3,) of a joint."""
    return vector(attributes.get("axis", "0 0 1"))


def is_plane(world: ET.Element, defaults: Mapping[tuple[str, str], dict[str, str]]) -> bool:
    """Return True if all bodies move in the plane of x and y and turn about z."""
    if any(abs(orientation(body.attrib)[2, 2] - 1) > PLANE for body in world.iter("body")):
        return False
    for _, attributes in each_joint(world, defaults):
        axis = axis_of(attributes) / np.linalg.norm(axis_of(attributes))
        across = {"hinge": axis[:2], "slide": axis[2:]}.get(attributes.get("type", "hinge"))
        if across is None or np.max(np.abs(across)) > PLANE:
            return False
    return True


def make_inertias_unequal(world: ET.Element) -> None:
    """Write three moments of inertia where one is meant."""
    for item in world.iter("inertial"):
        moments = vector(item.get("diaginertia", "0 0 0"))
        if np.ptp(moments) == 0 and "quat" not in item.attrib:
            item.set("diaginertia", attribute_text(tuple(moments * UNEQUAL)))


def mirror(world: ET.Element, defaults: Mapping[tuple[str, str], dict[str, str]]) -> None:
    """Reverse y in the world, and in the frame of each body, joint axes with them.

    A slide's axis is a vector and turns over as points do; a hinge's is a pseudovector, the same
    rotation seen in the mirror, and has the opposite sign. A rotation B becomes ``S B S``.
    """
    for item, attributes in list(each_joint(world, defaults)):
        sign = 1.0 if attributes.get("type", "hinge") == "slide" else -1.0
        item.set("axis", attribute_text(tuple(sign * MIRROR @ axis_of(attributes) + 0.0)))
    for item in world.iter():
        if "fullinertia" in item.attrib:
            moments = vector(item.get("fullinertia", ""))
            item.set("fullinertia", attribute_text(tuple(moments * REVERSED)))
        turn_points(item, MIRROR)
        if ORIENTATIONS & item.attrib.keys():
            write_orientation(item, MIRROR @ orientation(item.attrib) @ MIRROR)


REVERSED = (1, 1, 1, -1, 1, -1)
"""Signs of xx, yy, zz, xy, xz, yz of a tensor in the mirror."""

ORIENTATIONS = {"quat", "euler", "xyaxes", "zaxis"}
"""Attributes that give a rotation."""


def turn_points(element: ET.Element, matrix: Array) -> None:
    """Multiply the points in an element's attributes."""
    for name in ("pos", "fromto"):
        if name in element.attrib:
            points = vector(element.get(name, "")).reshape(-1, 3) @ matrix.T + 0.0
            element.set(name, attribute_text(tuple(points.ravel())))


def write_orientation(element: ET.Element, rotation: Array) -> None:
    """Write a rotation (3, 3) as ``quat``, and in no other way."""
    for name in ORIENTATIONS & element.attrib.keys():
        del element.attrib[name]
    x, y, z, w = Rotation.from_matrix(rotation).as_quat()
    element.set("quat", attribute_text((w, x, y, z)))

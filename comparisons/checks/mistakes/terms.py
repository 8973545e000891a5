"""Terms that readers of files add to a model or drop, frames that they confuse, and the effects."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import combinations_with_replacement
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....models.kinematics import Placed, inertias, mass_matrix, movers, place
from ....models.mechanism import Body, Mechanism
from ....models.system import System, term_force
from ....reference.scene import Array
from .shares import Words, of_share

SAME = 1e-6
"""Relative difference of numbers that count as the same."""

NUMBERS = {
    "constant": "constant part",
    "per_length": "length gain",
    "per_rate": "rate gain",
    "amplitude": "control",
}
"""Words for the numbers of a term."""

UNITS = {
    "an armature": ("kg", "kg m^2"),
    "a damper": ("N s/m", "N m s/rad"),
    "dry friction": ("N", "N m"),
}
"""Units of a term on a slide, and on a joint that turns."""


class Inertia(NamedTuple):
    """A change of mass matrices.

    Attributes
    ----------
    name : str
    changed : callable
        A mechanism with it, by the mechanism and k numbers that are 0 where it follows the file.
    words : callable
    size : int
        k.
    """

    name: str
    changed: Callable[[Mechanism, Array], Mechanism]
    words: Words
    size: int = 1

    def at(self, whole: Mechanism, q: Array) -> Array:
        """Return the change of the mass matrix (k, n, n) at a position by a unit of each number."""
        each = [mass_matrix(self.changed(whole, unit), q) for unit in np.eye(self.size)]
        return np.array(each) - mass_matrix(whole, q)


def in_words(said: str, file: float, least: float, x: Array, moved: Array) -> str:
    """Return words for a number that exceeds that of the file, and the least."""
    return said.format(file + x[0]) if file + x[0] > least else ""


def if_whole(said: str, x: Array, moved: Array) -> str:
    """Return words for a mistake without a size."""
    return said if abs(x[0] - 1) < SAME else ""


def joints_of(whole: Mechanism) -> NDArray[np.str_]:
    """Return the name of the joint of each velocity."""
    widths = [own.stop - own.start for own in whole.layout.velocities]
    return np.repeat([one.name for one in whole.joints], widths)


def on_joints(whole: Mechanism, what: str, known: set[str]) -> Iterator[tuple[str, Array, Words]]:
    """Yield each joint that has none of it yet, and all of them: name, its rates (n,), words."""
    places = joints_of(whole)
    spans = [
        (one.name, 1.0 * (places == one.name), UNITS[what][one.kind != "slide"])
        for one in whole.joints
        if one.name not in known
    ]
    if len(whole.joints) > 1:
        spans.append(("every joint", np.ones(len(places)), "(SI units)"))
    for name, on, unit in spans:
        said = f"{what} of {{:.6g}} {unit} on {name}, which the file does not have"
        yield f"{what} on {name}", on, partial(in_words, said, 0.0, 0.0)


# Inertias


def with_armature(on: Array, one: Mechanism, x: Array) -> Mechanism:
    """Return a mechanism with more armature on the joints of some rates (n,)."""
    joints = [
        replace(joint, armature=joint.armature + x[0] * on[own.start])
        for joint, own in zip(one.joints, one.layout.velocities, strict=True)
    ]
    return replace(one, joints=tuple(joints))


def with_tensor(number: int, units: Array, one: Mechanism, x: Array) -> Mechanism:
    """Return a mechanism with multiples of tensors (k, 3, 3) beside that of a body."""
    bodies, body = list(one.bodies), one.bodies[number]
    bodies[number] = replace(body, inertia=body.inertia + np.tensordot(x, units, 1))
    return replace(one, bodies=tuple(bodies))


def added_inertias(whole: Mechanism, visible: tuple[str, ...]) -> Iterator[Inertia]:
    """Yield the inertias that a reader may add to mass matrices, besides the visible parts."""
    pairs = combinations_with_replacement(np.eye(3), 2)
    entries = np.array([np.outer(a, b) + np.outer(b, a) for a, b in pairs])
    file = inertias(whole, np.linspace(0.3, 1.3, whole.layout.size[0]))
    for i, body in enumerate(whole.bodies):
        name, own = body.name, body.centre
        if movers(whole)[i][0] and whole.layout.is_spatial:
            change, what = partial(with_tensor, i, entries), partial(of_entries, body, entries)
            yield Inertia(f"tensor.{name}", change, what, len(entries))
            moved = body.mass * (np.outer(own, own) - own @ own * np.eye(3))
            said = f"inertia tensor of {name} is about its origin, not its centre of mass"
            change = partial(with_tensor, i, moved[None])
            yield Inertia(f"origin.{name}", change, partial(if_whole, said))
        elif movers(whole)[i][0] and f"inertia.{name}" not in visible:
            size = float(np.max(file.get(f"inertia.{name}", 0.0)))
            said = f"inertia of {name} is {{:.6g}} kg m^2, where the file has {size:.6g}"
            change = partial(with_tensor, i, np.eye(3)[None])
            yield Inertia(f"tensor.{name}", change, partial(in_words, said, size, 0.0))
    armed = {one.name for one in whole.joints if one.armature}
    for name, on, words in on_joints(whole, "an armature", armed):
        yield Inertia(name, partial(with_armature, on), words)
    yield Inertia(
        "ref",
        lambda one, x: replace(one, joints=tuple(replace(j, ref=0.0) for j in one.joints)),
        partial(if_whole, "ref of joints is ignored"),
    )


def of_entries(body: Body, entries: Array, x: Array, moved: Array) -> str:
    """Return the meaning of a change of a body's inertia tensor, by its entries (6,), in words."""
    file, tensor, upper = (
        body.inertia,
        body.inertia + np.tensordot(x, entries, 1),
        np.triu_indices(3),
    )
    near = partial(np.allclose, rtol=SAME, atol=SAME * np.max(file))
    meanings = {
        "the orientation of its principal axes is ignored": near(tensor, np.diag(np.diag(tensor)))
        and near(np.sort(np.diag(tensor)), np.linalg.eigvalsh(file)),
        "its entries are exchanged": near(*(np.sort(np.abs(one[upper])) for one in (tensor, file))),
        "it is another one": True,
    }
    said = next(said for said, holds in meanings.items() if holds)
    return f"inertia tensor of {body.name}: {said}"


# Forces


def added_forces(
    whole: Mechanism, system: System
) -> Iterator[tuple[str, Callable[..., Array], Words]]:
    """Yield the forces that a reader may add to the file's parts.

    A name, forces (n,) by time, positions and velocities, and the meaning of their number.
    """
    damped = {name for one in system.terms if one.kind == "damper" for name in one.joints}
    for name, on, words in on_joints(whole, "a damper", damped):
        yield name, partial(lambda on, time, q, v: -on * v, on), words
    for name, on, words in on_joints(whole, "dry friction", set()):
        yield name, partial(lambda on, time, q, v: -on * np.sign(v), on), words
    for one in system.terms:
        of, rested = f"{one.kind.replace('_', ' ')} of {one.name}", one.kind.endswith("spring")
        if rested and not one.constant:
            longer = replace(one, constant=-one.per_length, per_length=0.0)
            said = f"rest length of {of} is {{:.6g}}, where the file has 0"
            words = partial(in_words, said, 0.0, -np.inf)
            yield f"rest length.{one.name}", partial(term_force, longer, system), words
        present = [name for name in NUMBERS if getattr(one, name)]
        for name in present if len(present) > 1 else ():
            none: dict[str, Any] = dict.fromkeys(set(NUMBERS) - {name}, 0.0)
            word = "rest length" if rested and name == "constant" else NUMBERS[name]
            force = partial(term_force, replace(one, **none), system)
            yield f"{name}.{one.kind}.{one.name}", force, partial(of_share, f"{word} of {of}")


# Frames


def as_placed(whole: Mechanism) -> Placed:
    """Return a mechanism as its file places it."""
    upright = {"ball": [1.0, 0.0, 0.0, 0.0], "free": [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]}
    return place(whole, np.concatenate([upright.get(one.kind, [one.ref]) for one in whole.joints]))


def with_axes_of_world(whole: Mechanism) -> Mechanism:
    """Return a mechanism whose joints have axes that were read as those in the world."""
    rotations, joints = as_placed(whole).rotations, list(whole.joints)
    for body, rotation in zip(whole.bodies, rotations, strict=True):
        for i in body.joints:
            joints[i] = replace(joints[i], axis=rotation.T @ joints[i].axis)
    return replace(whole, joints=tuple(joints))


def with_tensors_behind(whole: Mechanism, q: Array) -> Array:
    """Return a mass matrix (n, n) with inertia tensors along the world's axes as placed."""
    matrices, moved, start = inertias(whole, q), place(whole, q), as_placed(whole).rotations
    for i, body in enumerate(whole.bodies):
        name = f"inertia.{body.name}"
        if name in matrices and any(movers(whole)[i]):
            rates = start[i] @ moved.rotations[i].T @ moved.turning(i)
            matrices[name] = rates.T @ body.inertia @ rates
    return np.asarray(np.sum(list(matrices.values()), axis=0))

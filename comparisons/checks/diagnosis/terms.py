"""What readers of files add to a model or lose of it, by what it does to matrices or forces."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import combinations_with_replacement
from typing import Any, NamedTuple

import numpy as np

from ....models.kinematics import mass_matrix, movers, place
from ....models.mechanism import Body, Mechanism, Term
from ....models.system import System, term_force
from ....reference.scene import Array

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
    "slide": {"an armature": "kg", "a damper": "N s/m", "dry friction": "N"},
    "": dict.fromkeys(("an armature", "a damper", "dry friction"), "(SI units)"),
}
"""Units of what is added to a slide, and to all joints; a hinge has others."""

HINGE = {"an armature": "kg m^2", "a damper": "N m s/rad", "dry friction": "N m"}
"""Units of what is added to a joint that turns."""


class Addition(NamedTuple):
    """What is added to a model, by k numbers that are 0 where an engine follows the file.

    Attributes
    ----------
    name : str
    at : callable
        What it adds at a state: mass matrices (k, n, n) by positions, or forces (k, n) by time,
        positions and velocities.
    words : callable
        Meaning of the numbers (k,), empty where no reader does that.
    applied : callable
        Mechanism that has it.
    """

    name: str
    at: Callable[..., Array]
    words: Callable[[Array], str]
    applied: Callable[[Mechanism, Array], Mechanism] = lambda whole, x: whole


def on_joints(
    whole: Mechanism, what: str, known: set[str], at: Callable[..., Array]
) -> Iterator[Addition]:
    """Yield what acts on each joint that has none of it yet, and alike on all of them."""
    count = whole.layout.size[1]
    every = zip(whole.joints, whole.layout.velocities, strict=True)
    spans = [(one.name, one.kind, np.isin(np.arange(count), np.r_[own])) for one, own in every]
    if len(spans) > 1:
        spans.append(("every joint", "", np.ones(count, dtype=bool)))
    for name, kind, places in spans:
        unit = UNITS.get(kind, HINGE)[what]
        said = f"{what} of {{:.6g}} {unit} on {name}, which the file does not have"
        if name not in known:
            yield Addition(
                f"{what} on {name}",
                partial(at, places),
                partial(if_positive, said, 0.0),
            )


# Inertias


def added_inertias(whole: Mechanism, visible: tuple[str, ...]) -> Iterator[Addition]:
    """Yield what may be added to mass matrices, beside the parts that they show."""
    for i, body in enumerate(whole.bodies):
        if movers(whole)[i][0] and (
            whole.layout.is_spatial or f"inertia.{body.name}" not in visible
        ):
            yield of_tensor(whole, i)
        own = body.centre
        shift = body.mass * (own @ own * np.eye(3) - np.outer(own, own))
        if movers(whole)[i][0] and whole.layout.is_spatial and np.any(shift):
            said = f"inertia tensor of {body.name} is about its origin, not its centre of mass"
            yield of_change("origin", whole, i, -shift[None], partial(if_whole, said))
    armed = {one.name for one in whole.joints if one.armature}
    yield from on_joints(whole, "an armature", armed, lambda places, q: np.diag(1.0 * places)[None])
    straight = replace(whole, joints=tuple(replace(one, ref=0.0) for one in whole.joints))
    if any(one.ref for one in whole.joints):
        yield Addition(
            "ref",
            lambda q: (mass_matrix(straight, q) - mass_matrix(whole, q))[None],
            partial(if_whole, "ref of joints is ignored"),
            lambda whole, x: straight,
        )


def if_whole(said: str, x: Array) -> str:
    """Return words for what is either done or not."""
    return said if abs(x[0] - 1) < SAME else ""


def if_positive(said: str, file: float, x: Array) -> str:
    """Return words for what is added to a number of the file, and cannot be negative."""
    return said.format(file + x[0]) if file + x[0] > 0 else ""


def of_change(
    name: str, whole: Mechanism, number: int, units: Array, words: Callable[[Array], str]
) -> Addition:
    """Return what adds multiples of tensors (k, 3, 3) to that of a body."""

    def at(q: Array) -> Array:
        placed = place(whole, q)
        turning = placed.rotations[number].T @ placed.turning(number)
        return np.asarray(turning.T @ units @ turning)

    def applied(one: Mechanism, x: Array) -> Mechanism:
        bodies, body = list(one.bodies), whole.bodies[number]
        bodies[number] = replace(body, inertia=body.inertia + np.tensordot(x, units, 1))
        return replace(one, bodies=tuple(bodies))

    return Addition(f"{name}.{whole.bodies[number].name}", at, words, applied)


def of_tensor(whole: Mechanism, number: int) -> Addition:
    """Return what changes the inertia tensor of a body: all entries in space, one in a plane."""
    body = whole.bodies[number]
    if whole.layout.is_spatial:
        pairs = combinations_with_replacement(np.eye(3), 2)
        units = np.array([np.outer(a, b) + np.outer(b, a) for a, b in pairs])
        return of_change(
            "tensor",
            whole,
            number,
            units,
            lambda x: (
                f"inertia tensor of {body.name}: {of_entries(body, np.tensordot(x, units, 1))}"
            ),
        )
    start = place(whole, np.zeros(whole.layout.size[0]))
    axis = np.max(np.abs(start.rotations[number].T @ start.turning(number)), axis=1)
    file = float(axis @ body.inertia @ axis)
    said = f"inertia of {body.name} is {{:.6g}} kg m^2, where the file has {file:.6g}"
    return of_change(
        "tensor",
        whole,
        number,
        np.eye(3)[None],
        partial(if_positive, said, file),
    )


def of_entries(body: Body, change: Array) -> str:
    """Return what a change (3, 3) of the inertia tensor of a body means."""
    file, tensor, upper = body.inertia, body.inertia + change, np.triu_indices(3)
    near = partial(np.allclose, rtol=SAME, atol=SAME * np.max(file))
    if near(np.linalg.eigvalsh(tensor), np.linalg.eigvalsh(file)):
        if near(tensor, np.diag(np.diag(tensor))):
            return "the orientation of its principal axes is ignored"
        if near(tensor @ file, file @ tensor):
            return "its principal moments are exchanged"
    if near(*(np.sort(np.abs(one[upper])) for one in (tensor, file))):
        return "its entries are exchanged"
    return "it is another one"


# Forces


def added_forces(
    whole: Mechanism, system: System, share: Callable[[str], Callable[[Array], str]]
) -> Iterator[Addition]:
    """Yield what may be added to forces, beside the file's parts.

    Parameters
    ----------
    whole : Mechanism
    system : System
    share : callable
        Words for a share (1,) beside 1, by what it is of.
    """
    damped = {name for one in system.terms if one.kind == "damper" for name in one.joints}
    yield from on_joints(whole, "a damper", damped, lambda on, time, q, v: -(on * v)[None])
    yield from on_joints(
        whole, "dry friction", set(), lambda on, time, q, v: -(on * np.sign(v))[None]
    )
    for one in system.terms:
        called = f"{one.kind.replace('_', ' ')} of {one.name}"
        rested = one.kind.endswith("spring")
        if rested and not one.constant:
            longer = replace(one, constant=-one.per_length, per_length=0.0)
            words = partial(of_rest, called)
            yield Addition(f"rest length.{one.name}", partial(force_of, longer, system), words)
        present = [name for name in NUMBERS if getattr(one, name)]
        for name in present if len(present) > 1 else ():
            none: dict[str, Any] = dict.fromkeys(set(NUMBERS) - {name}, 0.0)
            part = replace(one, **none)
            word = "rest length" if rested and name == "constant" else NUMBERS[name]
            yield Addition(
                f"{name}.{one.kind}.{one.name}",
                partial(force_of, part, system),
                share(f"{word} of {called}"),
            )


def force_of(term: Term, system: System, time: float, q: Array, v: Array) -> Array:
    """Return the force (1, n) of a term."""
    return term_force(term, system, time, q, v)[None]


def of_rest(called: str, x: Array) -> str:
    """Return what the rest length (1,) of a spring means that has none."""
    return f"rest length of {called} is {x[0]:.6g}, where the file has 0"

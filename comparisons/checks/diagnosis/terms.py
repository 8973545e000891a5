"""What readers of files add to a model or lose of it, each by what it does to matrices or forces."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import combinations_with_replacement
from typing import NamedTuple

import numpy as np

from ....models.kinematics import mass_matrix, movers, place
from ....models.mechanism import Body, Mechanism, Term
from ....models.system import System, factors_of, term_force
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

UNITS = {"slide": ("kg", "N s/m", "N"), "hinge": ("kg m^2", "N m s/rad", "N m")}
"""Units of an armature, a damper and a friction, by the kind of a joint."""


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


def added(what: str, unit: str, where: str) -> Callable[[Array], str]:
    """Return the words for a number that the file has not, which cannot be negative."""
    said = "{} of {:.6g} {} on {}, which the file does not have"
    return lambda x: said.format(what, x[0], unit, where) if x[0] > 0 else ""


def units_of(kind: str) -> tuple[str, ...]:
    """Return the units of an armature, a damper and a friction on a joint of this kind."""
    return UNITS.get(kind, UNITS["hinge"])


def unit_rows(whole: Mechanism) -> Iterator[tuple[str, str, Array]]:
    """Yield names and kinds of joints, and which velocities (n,) they have; at last of all joints."""
    count = whole.layout.size[1]
    for one, own in zip(whole.joints, whole.layout.velocities, strict=True):
        chosen = np.zeros(count)
        chosen[own] = 1.0
        yield one.name, one.kind, chosen
    yield "", "", np.ones(count)


def of_joints(
    whole: Mechanism, what: str, number: int, known: set[str], at: Callable[..., Array]
) -> Iterator[Addition]:
    """Yield what acts on each joint that has none of it yet, and alike on all of them."""
    for name, kind, chosen in unit_rows(whole):
        unit = units_of(kind)[number] if name else "(SI units)"
        words = added(what, unit, name or "every joint")
        if name not in known and (name or len(whole.joints) > 1):
            yield Addition(f"added {what}.{name}", partial(at, chosen), words)


# Inertias


def inertial(whole: Mechanism, shown: tuple[str, ...]) -> Iterator[Addition]:
    """Yield what may be added to mass matrices, beside the parts that they show."""
    tensors = [
        of_tensor(whole, i, body)
        for i, body in enumerate(whole.bodies)
        if movers(whole)[i][0] and (whole.layout.is_spatial or f"inertia.{body.name}" not in shown)
    ]
    yield from tensors
    if len(tensors) > 1:
        yield all_of("inertia tensors", tensors)
    yield from of_joints(
        whole,
        "an armature",
        0,
        {one.name for one in whole.joints if one.armature},
        lambda chosen, q: np.diag(chosen)[None],
    )
    shifted = {i: parallel_axis(body) for i, body in enumerate(whole.bodies) if any(movers(whole)[i])}
    shifted = {i: change for i, change in shifted.items() if np.any(change)}
    if whole.layout.is_spatial:
        for i, change in shifted.items():
            yield of_point(whole, {i: change}, f"inertia tensor of {whole.bodies[i].name}")
        if len(shifted) > 1:
            yield of_point(whole, shifted, "each inertia tensor")
    straight = replace(whole, joints=tuple(replace(one, ref=0.0) for one in whole.joints))
    if any(one.ref for one in whole.joints):
        yield Addition(
            "ref",
            lambda q: (mass_matrix(straight, q) - mass_matrix(whole, q))[None],
            lambda x: "ref of joints is ignored" if abs(x[0] - 1) < SAME else "",
            lambda whole, x: straight,
        )


def all_of(name: str, several: list[Addition]) -> Addition:
    """Return several additions as one; each has as many numbers as the others."""

    def each(x: Array) -> Iterator[tuple[Addition, Array]]:
        rows = np.reshape(x, (len(several), -1))
        size = np.max(np.abs(rows))
        return ((one, y) for one, y in zip(several, rows, strict=True) if np.max(np.abs(y)) > SAME * size)

    def applied(whole: Mechanism, x: Array) -> Mechanism:
        for one, y in each(x):
            whole = one.applied(whole, y)
        return whole

    return Addition(
        name,
        lambda q: np.concatenate([one.at(q) for one in several]),
        lambda x: "; ".join(one.words(y) for one, y in each(x)),
        applied,
    )


def parallel_axis(body: Body) -> Array:
    """Return what an inertia tensor (3, 3) about the origin of a body has beside the central one."""
    own = body.centre
    return body.mass * (own @ own * np.eye(3) - np.outer(own, own))


def of_point(whole: Mechanism, shifted: dict[int, Array], called: str) -> Addition:
    """Return what takes tensors of some bodies for those about their origins."""

    def applied(one: Mechanism, x: Array) -> Mechanism:
        bodies = list(one.bodies)
        for i, change in shifted.items():
            bodies[i] = replace(bodies[i], inertia=whole.bodies[i].inertia - x[0] * change)
        return replace(one, bodies=tuple(bodies))

    def at(q: Array) -> Array:
        placed, total = place(whole, q), 0.0
        for i, change in shifted.items():
            turning = placed.rotations[i].T @ placed.turning(i)
            total = total - turning.T @ change @ turning
        return np.asarray(total)[None]

    said = f"{called} is taken about the origin of the body, not about its centre of mass"
    return Addition(
        f"point of {called}", at, lambda x: said if abs(x[0] - 1) < SAME else "", applied
    )


def of_tensor(whole: Mechanism, number: int, body: Body) -> Addition:
    """Return what changes the inertia tensor of a body: all entries of it in space, one in a plane."""
    pairs = list(combinations_with_replacement(range(3), 2))
    units = np.zeros((len(pairs), 3, 3))
    for unit, (i, j) in zip(units, pairs, strict=True):
        unit[i, j] = unit[j, i] = 1.0
    if not whole.layout.is_spatial:
        units = np.eye(3)[None]
        start = place(whole, np.zeros(whole.layout.size[0]))
        axis = np.sum(np.abs(start.rotations[number].T @ start.turning(number)), axis=1)
        axis /= np.linalg.norm(axis)

    def at(q: Array) -> Array:
        placed = place(whole, q)
        turning = placed.rotations[number].T @ placed.turning(number)
        return np.asarray(turning.T @ units @ turning)

    def applied(one: Mechanism, x: Array) -> Mechanism:
        bodies = list(one.bodies)
        bodies[number] = replace(body, inertia=body.inertia + np.tensordot(x, units, 1))
        return replace(one, bodies=tuple(bodies))

    def words(x: Array) -> str:
        tensor = body.inertia + np.tensordot(x, units, 1)
        if len(units) > 1:
            return f"inertia tensor of {body.name}: {of_entries(body, tensor)}"
        size, file = (float(axis @ one @ axis) for one in (tensor, body.inertia))
        said = f"inertia of {body.name} is {size:.6g} kg m^2, where the file has {file:.6g}"
        return said if size > 0 else ""

    return Addition(f"tensor.{body.name}", at, words, applied)


def of_entries(body: Body, tensor: Array) -> str:
    """Return what became of the inertia tensor of a body."""
    file, near = body.inertia, partial(np.allclose, rtol=SAME, atol=SAME * np.max(body.inertia))
    upper = np.triu_indices(3, 1)
    moments, products = np.diag(tensor), np.abs(tensor[upper])
    sizes = [np.linalg.eigvalsh(one) for one in (tensor, file)]
    if near(*sizes) and near(products, 0):
        return "the orientation of its principal axes is ignored"
    if near(tensor - file, parallel_axis(body)):
        return "it is moved to the origin of the body twice"
    if near(sorted(moments), sorted(np.diag(file))) and near(
        sorted(products), sorted(np.abs(file[upper]))
    ):
        return "its entries are exchanged"
    if near(sorted([*moments, *products]), sorted([*np.diag(file), *np.abs(file[upper])])):
        return "its entries are exchanged"
    if near(*sizes):
        same = near(tensor @ file, file @ tensor)
        return "its principal moments are exchanged" if same else "its axes are turned"
    if near(products, np.abs(file[upper])):
        both = (" ".join(f"{x:.6g}" for x in np.diag(one)) for one in (tensor, file))
        return "its moments are {} kg m^2, where the file has {}".format(*both)
    return "it is another one"


# Forces


def forces(whole: Mechanism, system: System, share: Callable[[str], Callable[[Array], str]]) -> Iterator[Addition]:
    """Yield what may be added to forces, beside the file's parts.

    Parameters
    ----------
    whole : Mechanism
    system : System
    share : callable
        Words for a share (1,) beside 1, by what it is of.
    """
    dampers = {name for one in system.terms if one.kind == "damper" for name in one.joints}
    yield from of_joints(
        whole, "a damper", 1, dampers, lambda chosen, time, q, v: -(chosen * v)[None]
    )
    yield from of_joints(
        whole, "dry friction", 2, set(), lambda chosen, time, q, v: -(chosen * np.sign(v))[None]
    )
    rested = [one for one in system.terms if one.kind.endswith("spring") and one.constant]
    if len(rested) > 1:
        yield Addition(
            "rest lengths",
            lambda time, q, v: np.sum([constant(one, -one.constant, system) for one in rested], 0),
            lambda x: "rest lengths of all springs are ignored" if abs(x[0] - 1) < SAME else "",
        )
    for one in system.terms:
        called = f"{one.kind.replace('_', ' ')} of {one.name}"
        if one.kind.endswith("spring"):
            yield Addition(
                f"rest length.{one.name}",
                lambda time, q, v, one=one: constant(one, -one.per_length, system),
                partial(of_rest, called, -one.constant / one.per_length),
            )
        elif sum(bool(getattr(one, name)) for name in NUMBERS) > 1:
            for name, word in NUMBERS.items():
                if getattr(one, name):
                    other = dict.fromkeys(set(NUMBERS) - {name}, 0.0)
                    yield Addition(
                        f"{name}.{one.kind}.{one.name}",
                        lambda time, q, v, part=replace(one, **other): along(part, system, time, q, v),
                        share(f"{word} of {called}"),
                    )


def along(term: Term, system: System, time: float, q: Array, v: Array) -> Array:
    """Return the force (1, n) of a term."""
    return term_force(term, system, time, q, v)[None]


def constant(term: Term, size: float, system: System) -> Array:
    """Return a force (1, n) of this size along a term."""
    return size * factors_of(term, system.joints, system.layout)


def of_rest(called: str, file: float, x: Array) -> str:
    """Return what a change of the rest length of a spring means."""
    rest = file + float(x[0])
    if file and abs(rest) < SAME * abs(file):
        return f"rest length of {called} is ignored"
    return f"rest length of {called} is {rest:.6g}, where the file has {file:.6g}"

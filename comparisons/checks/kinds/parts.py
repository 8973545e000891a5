"""Check kind *parts*: what an engine made of each part of the MJCF that it read.

Before any run: of its mass matrix and its accelerations at random states, by how much it counts
each mass, inertia and armature, spring, damper, tendon and actuator, Coriolis forces, gravity
and loop closures: 1 where it counts them as the file says, 0 where it has dropped them. The
shares follow by least squares from the generalised forces and inertias of the parts, which
`models.mechanism` has from the text of the file.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.linalg import null_space

from ....models.kinematics import (
    centrifugal_force,
    gap_drift,
    gap_jacobian,
    gyroscopic_forces,
    inertial_force,
    inertias,
    movers,
    weight,
    with_shares,
)
from ....models.mechanism import Mechanism, mechanism
from ....models.system import System, term_force
from ....reference.errors import CannotJudgeError, Unsupported
from ....reference.scene import Array
from ...engines.run import contained
from ...engines.setup import Setup
from ..tolerances import OPERATIONS, largest_inertias, matrix_rounding
from ..verdict import Finding, Inconclusive
from .algebra import ROUNDING, random_states

STATES = 6

VISIBLE = 1e-2
"""A share that rounding could move by more cannot be told."""

APART = 1e-6
"""Share of a part that others could stand for, above which they cannot all be told apart."""

UNITS = 8
"""Units of rounding of each inertial force in a row, all of which `ROUNDING` of its size holds."""

DISTINCT = 1e-9
"""Parts whose forces differ by less count as the same."""

GRAVITY = 9.81
"""In m/s^2: the unit of the share of a gravity that the file does not have."""

SPATIAL = {"products": "products of inertia", "gyroscopic": "gyroscopic term"}
"""Words for parts that only bodies in space have."""

GRAVITIES = ("gravity_1", "gravity_2", "gravity_3")
"""Along the axes of `gravity_axes`."""

APART_AXES = 1e-3
"""Share of a direction across those that are axes already, above which it gives one more."""


@dataclass(frozen=True)
class Share:
    """By how much an engine counts a part, and how well that is known."""

    value: float
    tolerance: float
    others: tuple[str, ...] = ()
    """Parts that would explain the same"""
    said: str = ""
    """What it means, where that takes more than a number"""


class Room(NamedTuple):
    """Relative error that rounding may leave of a row, and a unit of rounding."""

    error: float
    unit: float

    @classmethod
    def of(cls, epsilon: float) -> Room:
        """Return that of an engine's numbers, whose `Setup.epsilon` this is."""
        return cls(matrix_rounding(epsilon, ROUNDING), epsilon)


class JointStates(NamedTuple):
    """Times (k,), positions, velocities and an engine's accelerations (k, n) of joints."""

    times: Array
    positions: Array
    velocities: Array
    accelerations: Array


@dataclass(frozen=True)
class Shares:
    """The shares of parts, what they leave unexplained (relative), and what rounding may."""

    known: Mapping[str, Share]
    left: float
    granted: float


def readable(setup: Setup) -> System | None:
    """Return the model in joint coordinates, None of an engine that reads no MJCF of ours."""
    if not setup.engine.reads_mjcf or soft(setup):
        return None
    try:
        system = setup.engine.joint_system(setup.case, setup.model)
        mechanism(system.mjcf)
        return system
    except CannotJudgeError:
        return None


def soft(setup: Setup) -> bool:
    """Return whether constraints give way: their forces are none of the parts."""
    return setup.has_constraints and not setup.is_exact


@lru_cache(maxsize=64)
def inertial_names(whole: Mechanism) -> tuple[str, ...]:
    """Return the masses, inertias and armatures that show in a mass matrix."""
    generic = np.linspace(0.3, 1.3, whole.layout.size[0])
    parts = inertias(whole, generic)
    size = scale_of(np.sum(list(parts.values()), axis=0))
    shows = ROUNDING / VISIBLE * size
    return tuple(name for name, part in parts.items() if np.any(np.abs(part) > shows))


@lru_cache(maxsize=64)
def gyroscopic_names(whole: Mechanism) -> tuple[str, ...]:
    """Return the gyroscopic terms of bodies in space; in the plane there are none."""
    if not whole.layout.is_spatial:
        return ()
    count, rates = whole.layout.size
    return tuple(gyroscopic_forces(whole, np.linspace(0.3, 1.3, count), np.ones(rates)))


def as_counted(whole: Mechanism, findings: Iterable[Finding | Inconclusive]) -> Mechanism:
    """Return a mechanism with the masses and inertias that an engine's mass matrix shows.

    What they make of Coriolis forces and of weights is no fault of its own.
    """
    wrong = [one for one in findings if isinstance(one, Finding) and one.error > one.tolerance]
    return with_shares(whole, {one.quantity: one.value for one in wrong}) if wrong else whole


def inertial_forces(whole: Mechanism, q: Array, v: Array) -> dict[str, Array]:
    """Return Coriolis forces (n,), and in space gyroscopic ones apart, on the side of forces."""
    if not whole.layout.is_spatial:
        return {"coriolis": -inertial_force(whole, q, v)}
    turning = gyroscopic_forces(whole, q, v)
    return {"coriolis": -centrifugal_force(whole, q, v), **{n: -f for n, f in turning.items()}}


def scale_of(mass: Array) -> Array:
    """Return by what the entries of a mass matrix (n, n) are measured."""
    root = np.sqrt(np.diag(mass))
    size: Array = np.outer(root, root)
    return size


def quantities(setup: Setup) -> tuple[str, ...]:
    """Return the parts of the model, and what they leave unexplained; none without MJCF."""
    system = readable(setup)
    if system is None:
        return ()
    return (
        "mass_matrix",
        *inertial_names(mechanism(system.mjcf)),
        *(f"{term.kind}.{term.name}" for term in system.terms),
        "coriolis",
        *gyroscopic_names(mechanism(system.mjcf)),
        "gravity",
        *(f"closure.{one.name}" for one in system.closures),
        "unexplained",
    )


def measure(setup: Setup) -> list[Finding | Inconclusive]:
    """Judge the share of each part."""
    equations = setup.equations
    times, states = random_states(equations, setup.case, setup.coordinates)
    times, states = times[:STATES], states[:STATES]
    matrices, silence = None, ""
    with contained():
        system, q, v = setup.engine.joint_states(setup.case, setup.model, times, states)
        a = setup.engine.joint_accelerations(system, times, q, v)
        try:
            matrices = setup.engine.joint_mass_matrices(system, q)
        except Unsupported as error:
            silence = str(error)
    whole, room = mechanism(system.mjcf), Room.of(setup.epsilon)
    findings: list[Finding | Inconclusive] = []
    if matrices is None:
        findings.append(Inconclusive("mass_matrix", silence))
    else:
        findings += of_mass_matrix(whole, q, matrices, room)
    state = JointStates(times, q, v, a)
    findings += of_forces(system, as_counted(whole, findings), state, matrices, room)
    return findings + list(closures(whole, state, room))


def share_finding(name: str, share: Share) -> Finding:
    """Judge a share: 1 is right, but for a gravity beside that of the file."""
    right = 0.0 if name == "gravity" else 1.0
    error = abs(share.value - right)
    said = share.said or words(name, share.value, share.tolerance)
    if share.others:
        said += f", or it is {' or '.join(share.others)}: accelerations cannot tell"
    return Finding(name, "1", share.value, right, error, share.tolerance, said)


def part_of(name: str) -> str:
    """Return the words for a part."""
    kind, _, of = name.partition(".")
    return f"{SPATIAL.get(kind, kind.replace('_', ' '))} of {of}" if of else kind


def words(name: str, value: float, tolerance: float) -> str:
    """Say what a share means."""
    part = part_of(name)
    for right, said in (
        (0.0, "dropped"),
        (-1.0, "its sign is reversed"),
        (np.pi / 180, "degrees were taken for radians"),
        (180 / np.pi, "radians were taken for degrees"),
    ):
        if abs(value - right) <= max(tolerance, 1e-6 * abs(right)):
            return f"{part}: {said}"
    return f"{part}: counted {value:.6g} times"


def of_mass_matrix(
    whole: Mechanism, q: Array, matrices: Array, room: Room
) -> list[Finding | Inconclusive]:
    """Return the error of mass matrices (k, n, n), and the shares of masses and inertias."""
    names = inertial_names(whole)
    rows, columns = [], []
    every = [inertias(whole, position) for position in q]
    totals = np.array([np.sum(list(parts.values()), axis=0) for parts in every])
    turns = np.isin(range(len(totals[0])), [i for turning, _ in movers(whole) for i in turning])
    largest = np.sqrt(largest_inertias(totals, turns[:, None] == turns))
    summed = OPERATIONS * room.unit / room.error * np.outer(largest, largest)
    for parts, right, matrix in zip(every, totals, matrices, strict=True):
        size = np.maximum(scale_of(right), summed)
        rows.append(((matrix - right) / size).ravel())
        columns.append(np.array([(parts[name] / size).ravel() for name in names]).T)
    worst = float(np.max(np.abs(rows)))
    reason = f"largest error of an entry over {len(q)} positions, relative to the diagonal"
    whole_error = Finding("mass_matrix", "1", worst, 0.0, worst, room.error, reason)
    shares = solved(names, np.vstack(columns), np.concatenate(rows), room.error)
    return [whole_error, *findings_of(shares, "mass matrix is")]


def of_forces(
    system: System, whole: Mechanism, state: JointStates, matrices: Array | None, room: Room
) -> list[Finding | Inconclusive]:
    """Return the shares of forces, and of inertias where no mass matrix is given.

    Of ``M a = sum of forces`` projected on the motions that loops permit: each row relative to
    the sum of its parts.

    Parameters
    ----------
    system : System
    whole : Mechanism
        With the masses and inertias that the engine's mass matrix shows.
    state : JointStates
    matrices : array (k, n, n), or None
        The engine's mass matrices.
    room : Room
    """
    times, q, v, a = state
    masses = () if matrices is not None else inertial_names(whole)
    terms = tuple(f"{t.kind}.{t.name}" for t in system.terms)
    names = (*terms, "coriolis", *gyroscopic_names(mechanism(system.mjcf)), *masses, *GRAVITIES)
    permitted = [free_motions(whole, position) for position in q]
    axes = gravity_axes(whole, q, permitted)
    rows, columns = [], []
    for i, (time, position, rate) in enumerate(zip(times, q, v, strict=True)):
        parts = inertias(whole, position)
        right = np.sum(list(parts.values()), axis=0)
        forces = dict.fromkeys(names, np.zeros_like(rate))  # of what has no inertia left
        forces |= {
            f"{t.kind}.{t.name}": term_force(t, system, time, position, rate) for t in system.terms
        }
        forces |= inertial_forces(whole, position, rate)
        expected = np.sum(list(forces.values()), axis=0) + weight(whole, position, whole.gravity)
        free = permitted[i]
        forces |= {name: -parts[name] @ a[i] for name in masses}
        forces |= {
            name: weight(whole, position, GRAVITY * axis)
            for name, axis in zip(GRAVITIES, axes, strict=True)
        }
        parts_of_row = np.array([free.T @ forces[name] for name in names]).T
        present = parts_of_row[:, : -len(GRAVITIES)]
        size = np.sum(np.abs(present), axis=1) + np.abs(free.T @ right @ a[i])
        inertial = np.abs(free.T) @ np.abs(right) @ np.abs(a[i])
        alive = size > room.error * inertial  # below, inertial forces cancel but for rounding
        size = np.maximum(size, UNITS * len(rate) * room.unit / room.error * inertial)
        mass = right if matrices is None else matrices[i]
        rows.append((free.T @ (mass @ a[i] - expected))[alive] / size[alive])
        columns.append(parts_of_row[alive] / size[alive, None])
    shares = solved(names, np.vstack(columns), np.concatenate(rows), room.error)
    reason = "of the forces, relative: what no share of a part explains"
    last = Finding("unexplained", "1", shares.left, 0.0, shares.left, shares.granted, reason)
    return [*findings_of(shares, "forces are", axes @ whole.gravity), last]


def free_motions(whole: Mechanism, position: Array) -> Array:
    """Return the velocities (n, m) of joints that loops permit."""
    if not whole.closures:
        return np.eye(whole.layout.size[1])
    return np.asarray(null_space(gap_jacobian(whole, position), DISTINCT))


def gravity_axes(whole: Mechanism, q: Array, free: list[Array]) -> Array:
    """Return axes (3, 3) of gravities that act at positions (k, n_q), less of them followed by 0.

    The first is that of the file's gravity, so that one part stands for what is left of it, also
    where a plane in which all moves lies askew in the world. Those of the world if it has none.
    """
    units = np.eye(3)
    if not np.any(whole.gravity):
        return units
    pulls = [
        np.array([weight(whole, position, axis) @ motions for axis in units]).T
        for position, motions in zip(q, free, strict=True)
    ]
    _, sizes, ways = np.linalg.svd(np.vstack(pulls))
    acting = ways[: np.count_nonzero(sizes > DISTINCT * sizes[0])]
    axes = np.zeros((3, 3))
    number = 0
    for way in (whole.gravity, *units):
        rest = acting.T @ (acting @ way)
        rest = rest - axes.T @ (axes @ rest)
        left = float(np.linalg.norm(rest))
        if number < len(acting) and left > APART_AXES * float(np.linalg.norm(way)):
            axes[number] = rest / left
            number += 1
    return axes


def pull(known: dict[str, Share], gravity: Array) -> Share:
    """Return the size of what is beside a gravity (3,), which it takes from the shares of three."""
    axes = [known.pop(name) for name in GRAVITIES]
    seen = np.array([share.tolerance <= VISIBLE for share in axes])
    values = np.array([share.value for share in axes]) * seen
    tolerance = float(np.linalg.norm([share.tolerance for share in np.array(axes)[seen]]))
    return Share(
        float(np.linalg.norm(values)),
        tolerance if np.any(seen) else np.inf,
        said=of_gravity(GRAVITY * values, gravity * seen, GRAVITY * tolerance),
    )


def of_gravity(extra: Array, gravity: Array, tolerance: float) -> str:
    """Return what a gravity (3,) beside that of the file means [m/s^2]."""
    size, sum_of_both = float(np.linalg.norm(gravity)), float(np.linalg.norm(gravity + extra))
    if not size:
        return f"gravity of {float(np.linalg.norm(extra)):.4g} m/s^2, where the file has none"
    share = 1 + float(extra @ gravity) / size**2
    room = max(tolerance, 1e-6 * size)
    if np.linalg.norm(extra - (share - 1) * gravity) <= room:
        return words("gravity", share, room / size)
    if abs(sum_of_both - size) <= room:
        angle = np.degrees(np.arccos(np.clip((gravity + extra) @ gravity / size**2, -1, 1)))
        return f"gravity: its direction is off by {angle:.3g} degrees"
    return f"gravity of {sum_of_both:.4g} m/s^2 in another direction, where the file has {size:.4g}"


def findings_of(
    shares: Shares, of: str, gravity: Array | None = None
) -> Iterator[Finding | Inconclusive]:
    """Yield what a share of each part means, or why it cannot be told."""
    known = dict(shares.known)
    if gravity is not None:
        known["gravity"] = pull(known, gravity)
    for name, share in known.items():
        if shares.left > shares.granted:
            yield Inconclusive(name, f"the {of} not those of its parts in any shares")
        elif share.tolerance > VISIBLE:
            yield Inconclusive(
                name, f"{part_of(name)} does not act enough to be told from rounding"
            )
        else:
            yield share_finding(name, share)


def solved(names: tuple[str, ...], columns: Array, rows: Array, room: float) -> Shares:
    """Return the shares (1 + least squares) of all parts.

    Parameters
    ----------
    names : tuple of str, n of them
    columns : array (m, n)
        What each part adds to the rows, relative.
    rows : array (m,)
        What an engine has beside what it should have, relative.
    room : float
        What rounding may leave of a row.
    """
    size = np.max(np.abs(columns), axis=0, initial=0.0)
    acting = np.where(size > 0, size, 1.0)
    inverse = np.linalg.pinv(columns / acting, rcond=DISTINCT)
    extra = inverse @ rows / acting
    left = float(np.linalg.norm(rows - columns @ extra))
    granted = room * float(np.sqrt(len(rows)))
    resolution = inverse @ columns / acting
    mixed = np.max(np.abs(resolution - np.diag(np.diag(resolution)))) > APART
    others: dict[str, tuple[str, ...]] = {}
    if (mixed or left > granted) and np.linalg.norm(rows) > granted:
        extra, others = simplest(names, columns, rows, room, extra)
        left = float(np.linalg.norm(rows - columns @ extra))
    moved = room * np.sum(np.abs(inverse), axis=1) / acting
    shares = {
        name: Share(
            float(extra[i]) + (name not in GRAVITIES),
            float(moved[i]) if size[i] > 0 else np.inf,
            others.get(name, ()),
        )
        for i, name in enumerate(names)
    }
    return Shares(shares, left, granted)


def simplest(
    names: tuple[str, ...], columns: Array, rows: Array, room: float, extra: Array
) -> tuple[Array, dict[str, tuple[str, ...]]]:
    """Return shares by which one part alone, or one kind of parts, explains the rows.

    Of several the one that is changed least. A part that rounding could move as much is no
    explanation.

    Returns
    -------
    extra : array (n,)
        Shares beside the right ones; those given if no single part or kind explains the rows.
    others : mapping of part to parts
        Each of which would explain them as well.
    """
    granted = room * float(np.sqrt(len(rows)))
    kinds = [name.partition(".")[0] for name in names]
    groups = [[i] for i in range(len(names))]
    groups += [
        [i for i, other in enumerate(kinds) if other == kind]
        for kind in dict.fromkeys(kinds)
        if kinds.count(kind) > 1
    ]
    explained = []
    for group in groups:
        along = np.sum(columns[:, group], axis=1)
        weight = float(along @ along)
        if not weight or room * float(np.sum(np.abs(along))) / weight > VISIBLE:
            continue
        share = float(along @ rows) / weight
        if np.linalg.norm(rows - share * along) <= granted:
            explained.append((group, share))
    if not explained:
        return extra, {}
    group, share = min(explained, key=lambda one: (abs(one[1]), len(one[0])))
    extra = np.zeros(len(names))
    extra[group] = share
    singles = tuple(names[one[0]] for one, _ in explained if len(one) == 1 and one != group)
    return extra, {names[group[0]]: singles} if len(group) == 1 else {}


def closures(whole: Mechanism, state: JointStates, room: Room) -> Iterator[Finding]:
    """Yield by how much accelerations open each loop."""
    for i, one in enumerate(whole.closures):
        worst = 0.0
        for position, rate, acceleration in zip(*state[1:], strict=True):
            place = slice(3 * i, 3 * i + 3)
            opening = gap_jacobian(whole, position)[place] @ acceleration
            drift = gap_drift(whole, position, rate)[place]
            size = float(np.max(np.abs(opening)) + np.max(np.abs(drift)))
            worst = max(worst, float(np.max(np.abs(opening + drift))) / (size or 1.0))
        reason = f"closure of {one.name}: by how much of its ends' acceleration it opens"
        yield Finding(f"closure.{one.name}", "1", worst, 0.0, worst, room.error, reason)

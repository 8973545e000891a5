"""Check kind *parts*: what an engine made of each part of the MJCF that it read.

Before any run: of its mass matrix and its accelerations at random states, by how much it counts
each mass, inertia and armature, spring, damper, tendon and actuator, Coriolis forces, gravity
and loop closures: 1 where it counts them as the file says, 0 where it has dropped them. The
shares follow by least squares from the generalised forces and inertias of the parts, which
`models.mechanism` has from the text of the file.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space

from ....models.kinematics import (
    centrifugal_force,
    gap_drift,
    gap_jacobian,
    gyroscopic_forces,
    inertial_force,
    inertias,
    mass_matrix,
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
from ..diagnosis.shares import DISTINCT, VISIBLE, Effect, Explanation, explain
from ..diagnosis.terms import added_forces, added_inertias
from ..tolerances import OPERATIONS, largest_inertias, matrix_rounding
from ..verdict import Finding, Inconclusive
from .algebra import ROUNDING, random_states

STATES = 6

MORE = 16
"""States that are compared where fewer show that something is wrong, to tell what it is."""

UNITS = 8
"""Units of rounding of each inertial force in a row, all of which `ROUNDING` of its size holds."""

GRAVITY = 9.81
"""In m/s^2: the unit of the share of a gravity that the file does not have."""

SPATIAL = {"products": "products of inertia", "gyroscopic": "gyroscopic term"}
"""Words for parts that only bodies in space have."""

APART_AXES = 1e-3
"""Share of a direction across those that are axes already, above which it gives one more."""

WHOLE = {
    "mass_matrix": "largest error of an entry, relative to the diagonal",
    "unexplained": "of the forces, relative: what no share of a part explains",
}
"""Reasons of what is measured of all parts, where no part is named."""

MOST_JOINTS = 8
"""Most joints of which the forces on each are left out in turn."""


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
    """Judge the share of each part, at more states where one is wrong."""
    few = measure_at(setup, STATES)
    more = measure_at(setup, MORE) if any(map(deviates, few)) else few
    return more if any(map(deviates, more)) else few


def deviates(one: Finding | Inconclusive) -> bool:
    """Return whether a finding is beyond its tolerance."""
    return isinstance(one, Finding) and not one.error <= one.tolerance


def measure_at(setup: Setup, count: int) -> list[Finding | Inconclusive]:
    """Judge the share of each part at so many states."""
    equations = setup.equations
    times, states = random_states(equations, setup.case, setup.coordinates)
    times, states = times[:count], states[:count]
    matrices, silence = None, ""
    with contained():
        system, q, v = setup.engine.joint_states(setup.case, setup.model, times, states)
        a = setup.engine.joint_accelerations(system, times, q, v)
        try:
            matrices = setup.engine.joint_mass_matrices(system, q)
        except Unsupported as error:
            silence = str(error)
    whole, room = mechanism(system.mjcf), Room.of(setup.epsilon)
    counted = whole
    findings: list[Finding | Inconclusive] = []
    if matrices is None:
        findings.append(Inconclusive("mass_matrix", silence))
    else:
        of_matrix, counted = of_mass_matrix(whole, q, matrices, room)
        findings += of_matrix
    state = JointStates(times, q, v, a)
    findings += of_forces(system, counted, state, matrices, room)
    return findings + list(closures(whole, state, room))


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
    digits = 6 if value in (0.0, 1.0) else max(6, math.ceil(1 - math.log10(abs(value - 1))))
    return f"{part}: counted {value:.{min(digits, 16)}g} times"


def of_mass_matrix(
    whole: Mechanism, q: Array, matrices: Array, room: Room
) -> tuple[list[Finding | Inconclusive], Mechanism]:
    """Return the error of mass matrices (k, n, n) and the shares of masses and inertias.

    Returns
    -------
    findings : list of Finding or Inconclusive
    counted : Mechanism
        With the masses and inertias that the matrices show: what these make of Coriolis forces and
        of weights is no fault of its own.
    """
    names = inertial_names(whole)
    every = [inertias(whole, position) for position in q]
    right = np.array([np.sum(list(parts.values()), axis=0) for parts in every])
    turns = np.isin(range(len(right[0])), [i for turning, _ in movers(whole) for i in turning])
    largest = np.sqrt(largest_inertias(right, turns[:, None] == turns))
    summed = OPERATIONS * room.unit / room.error * np.outer(largest, largest)
    size = np.array([np.maximum(scale_of(one), summed) for one in right])

    def columns(matrices: Sequence[Array]) -> Array:
        each = zip(matrices, size, strict=True)
        return np.hstack([(one / scale).reshape(-1, scale.size) for one, scale in each]).T

    rows = ((matrices - right) / size).ravel()
    worst = float(np.max(np.abs(rows)))
    parts = [Effect(name, columns([one[name] for one in every]), share_of(name)) for name in names]
    additions = [*added_inertias(whole, names)] if worst > room.error else []
    candidates = [
        Effect(one.name, columns([one.at(at) for at in q]), one.words, added=True)
        for one in additions
    ]
    explained = explain(parts, candidates, rows, room.error)
    counted = with_shares(
        whole,
        {
            one.name: 1 + float(explained.values[one.name][0])
            for one in parts
            if np.any(np.abs(explained.values[one.name]) > explained.tolerances[one.name])
        },
    )
    for one in additions:
        if one.name in explained.values:
            counted = one.applied(counted, explained.values[one.name])
    reason = "; ".join(explained.added) or WHOLE["mass_matrix"]
    first = Finding("mass_matrix", "1", worst, 0.0, worst, room.error, reason)
    return [first, *findings_of(parts, explained, "mass matrix is")], counted


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
    file = mechanism(system.mjcf)
    masses = () if matrices is not None else inertial_names(whole)
    terms = {f"{one.kind}.{one.name}": one for one in system.terms}
    names = (*terms, "coriolis", *gyroscopic_names(file), *masses)
    permitted = [free_motions(whole, position) for position in q]
    axes = gravity_axes(whole, q, permitted)
    forces: dict[str, list[Array]] = {name: [] for name in names}
    pulls, rows, scales, joints = [], [], [], []
    for i, (time, position, rate) in enumerate(zip(times, q, v, strict=True)):
        right = mass_matrix(whole, position)
        here = dict.fromkeys(names, np.zeros_like(rate))  # of what has no inertia left
        here |= {n: term_force(one, system, time, position, rate) for n, one in terms.items()}
        here |= inertial_forces(whole, position, rate)
        acting = np.sum(list(here.values()), axis=0) + weight(whole, position, whole.gravity)
        here |= {name: needed(whole, name, position, rate, a[i]) for name in masses}
        for name, force in here.items():
            forces[name].append(force[None])
        pulls.append(np.array([weight(whole, position, GRAVITY * axis) for axis in axes]))
        free = permitted[i]
        size = np.sum([np.abs(free.T @ one) for one in here.values()], axis=0)
        size = size + np.abs(free.T @ right @ a[i])
        inertia = np.abs(free.T) @ np.abs(right) @ np.abs(a[i])
        alive = size > room.error * inertia  # below, inertial forces cancel but for rounding
        size = np.maximum(size, UNITS * len(rate) * room.unit / room.error * inertia)
        scales.append(free[:, alive] / size[alive])
        joints.append(np.flatnonzero(alive))
        mass = right if matrices is None else matrices[i]
        rows.append((mass @ a[i] - acting) @ scales[i])

    def columns(force: Sequence[Array]) -> Array:
        return np.hstack([one @ scale for one, scale in zip(force, scales, strict=True)]).T

    relative = np.concatenate(rows)
    parts = [Effect(name, columns(force), share_of(name)) for name, force in forces.items()]
    parts.append(
        Effect("gravity", columns(pulls), lambda x: pull(x, 0 * x, axes @ whole.gravity).reason)
    )
    candidates = []
    if np.max(np.abs(relative)) > room.error:
        for one in added_forces(file, system, share_of):
            at = [one.at(*three) for three in zip(times, q, v, strict=True)]
            candidates.append(Effect(one.name, columns(at), one.words, added=True))
        for one in added_inertias(file, inertial_names(file)) if matrices is None else ():
            at = [-one.at(position) @ rate for position, rate in zip(q, a, strict=True)]
            candidates.append(Effect(one.name, columns(at), one.words, added=True))
    explained = explain(parts, candidates, relative, room.error)
    said = "; ".join(explained.added)
    if not explained.unique and not whole.closures:
        explained, said = but_for_one_joint(file, parts, candidates, relative, joints, room)
    last = Finding(
        "unexplained",
        "1",
        explained.left,
        0.0,
        explained.left,
        explained.granted,
        said or WHOLE["unexplained"],
    )
    return [*findings_of(parts, explained, "forces are", axes @ whole.gravity), last]


def needed(whole: Mechanism, name: str, q: Array, v: Array, a: Array) -> Array:
    """Return what is left of all forces (n,) for accelerations by one inertia of a mechanism."""
    only = with_shares(whole, dict.fromkeys(set(inertias(whole, q)) - {name}, 0.0))
    own = inertias(whole, q)[name] @ a
    if name.startswith("armature."):
        return -own
    return np.asarray(weight(only, q, whole.gravity) - inertial_force(only, q, v) - own)


def but_for_one_joint(
    whole: Mechanism,
    parts: list[Effect],
    additions: list[Effect],
    rows: Array,
    velocities: Sequence[NDArray[np.int_]],
    room: Room,
) -> tuple[Explanation, str]:
    """Return what explains all forces but those on one joint, where there is one such joint."""
    along = zip(whole.joints, whole.layout.velocities, strict=True)
    names = np.concatenate([[one.name] * (own.stop - own.start) for one, own in along])
    of_rows = names[np.concatenate(velocities)]
    wrong = dict.fromkeys(of_rows[np.abs(rows) > room.error].tolist())
    granted, left = room.error * float(np.sqrt(len(rows))), float(np.linalg.norm(rows))
    none = explain(parts, (), rows, room.error)
    tried = []
    for joint in wrong if len(wrong) <= MOST_JOINTS else ():
        others = of_rows != joint
        some, more = (
            [one._replace(columns=one.columns[others]) for one in both]
            for both in (parts, additions)
        )
        rest = explain(some, more, rows[others], room.error)
        if rest.unique:
            said = "; ".join(
                [f"the force on {joint} is not the sum of its parts in any shares", *rest.added]
            )
            tried.append((rest._replace(left=left, granted=granted), said))
    return tried[0] if len(tried) == 1 else (none, WHOLE["unexplained"])


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


def pull(values: Array, tolerances: Array, gravity: Array) -> Finding:
    """Judge what is beside a gravity (3,), by shares of three."""
    seen = tolerances <= VISIBLE
    tolerance = float(np.linalg.norm(tolerances[seen])) if np.any(seen) else np.inf
    extra = float(np.linalg.norm(values[seen]))
    said = of_gravity(GRAVITY * values * seen, gravity * seen, GRAVITY * tolerance)
    return Finding("gravity", "1", extra, 0.0, extra, tolerance, said)


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
    parts: list[Effect], explained: Explanation, of: str, gravity: Array | None = None
) -> Iterator[Finding | Inconclusive]:
    """Yield what the share of each part means, or why it cannot be told."""
    for one in parts:
        name, value, tolerance = (
            one.name,
            explained.values[one.name],
            explained.tolerances[one.name],
        )
        if gravity is not None and name == "gravity":
            finding = pull(value, tolerance, gravity)
        else:
            said = words(name, 1 + float(value[0]), float(tolerance[0]))
            error = abs(float(value[0]))
            finding = Finding(name, "1", 1 + float(value[0]), 1.0, error, float(tolerance[0]), said)
        hidden = explained.left > explained.granted and not np.all(np.isfinite(tolerance))
        if not explained.unique or (hidden and name != "gravity"):
            yield Inconclusive(name, f"the {of} not those of its parts in any shares")
        elif finding.tolerance > VISIBLE:
            yield Inconclusive(
                name, f"{part_of(name)} does not act enough to be told from rounding"
            )
        else:
            others = explained.others.get(name, ())
            yield replace(finding, reason=", or ".join([finding.reason, *others]))


def share_of(name: str) -> Callable[[Array], str]:
    """Return the words for a share (1,) of a part beside 1."""
    return lambda x: words(name, 1 + float(x[0]), DISTINCT)


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

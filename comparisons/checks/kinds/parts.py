"""Check kind *parts*: the share of each part of the MJCF in an engine's model.

Before any run, the shares of each mass, inertia and armature, spring, damper, tendon and actuator,
of Coriolis forces, gravity and loop closures follow from the engine's mass matrix and accelerations
at random states: 1 for a part as in the file, 0 for one that was dropped. They are a least-squares
fit of the generalised forces and inertias of the parts, which `models.mechanism` computes from the
text of the file.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache, partial

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
from ..comparison import OPERATIONS, ROUNDING, Measured, largest_inertias, matrix_rounding
from ..mistakes.parts import (
    DISTINCT,
    VISIBLE,
    Effect,
    Explanation,
    added_forces,
    added_inertias,
    explain,
    joints_of,
    of_share,
    part_of,
)
from ..truth import random_states
from ..verdict import Finding, Inconclusive

STATES = 16

UNITS = 8
"""Units of round-off of each inertial force in a row, which `ROUNDING` of its size must cover."""

GRAVITY = 9.81
"""Unit [m/s^2] of the share of a gravity that the file does not have."""

WHOLE = {
    "mass_matrix": "largest error of an entry, relative to the diagonal",
    "unexplained": "relative size of the forces that no share of a part explains",
}
"""Reasons of the quantities of all parts together, if no part is named."""


def readable(setup: Setup) -> System | None:
    """Return the model in joint coordinates, None of an engine that reads no MJCF of ours."""
    # forces of what gives way are none of the parts
    soft = setup.bound.has_constraints or setup.engine.compliant_joints
    if (soft and not setup.bound.is_exact) or not setup.engine.reads_mjcf:
        return None
    try:
        system = setup.bound.system(setup.case)
        mechanism(system.mjcf)
        return system
    except CannotJudgeError:
        return None


@lru_cache(maxsize=64)
def inertial_names(whole: Mechanism) -> tuple[str, ...]:
    """Return the masses, inertias and armatures that show in a mass matrix."""
    generic = np.linspace(0.3, 1.3, whole.layout.size[0])
    parts = inertias(whole, generic)
    size = scale_of(np.sum(list(parts.values()), axis=0))
    shows = ROUNDING / VISIBLE * size
    return tuple(name for name, part in parts.items() if np.any(np.abs(part) > shows))


@lru_cache(maxsize=64)
def names_of_forces(whole: Mechanism) -> tuple[str, ...]:
    """Return the names of `inertial_forces`."""
    count, rates = whole.layout.size
    return tuple(inertial_forces(whole, np.linspace(0.3, 1.3, count), np.ones(rates)))


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
    """Return the names of the parts, and of the unexplained rest; none without MJCF."""
    system = readable(setup)
    if system is None:
        return ()
    return (
        "mass_matrix",
        *inertial_names(mechanism(system.mjcf)),
        *(f"{term.kind}.{term.name}" for term in system.terms),
        *names_of_forces(mechanism(system.mjcf)),
        "gravity",
        *(f"closure.{one.name}" for one in system.closures),
        "unexplained",
    )


def measure(setup: Setup) -> Measured:
    """Judge the share of each part."""
    equations = setup.bound.equations
    times, states = random_states(equations, setup.case, setup.bound.coordinates)
    times, states = times[:STATES], states[:STATES]
    matrices, silence = None, ""
    with contained():
        q, v = setup.bound.joint_states(times, states)
        a = setup.bound.joint_accelerations(times, q, v, setup.method)
        try:
            matrices = setup.bound.joint_mass_matrices(q, v.shape[1], setup.method)
        except Unsupported as error:
            silence = str(error)
    system = setup.bound.system(setup.case)
    whole, unit = mechanism(system.mjcf), setup.epsilon
    counted = whole
    findings: list[Finding | Inconclusive] = []
    if matrices is None:
        findings.append(Inconclusive("mass_matrix", silence))
    else:
        of_matrix, counted = of_mass_matrix(whole, q, matrices, unit)
        findings += of_matrix
    state = times, q, v, a
    findings += of_forces(system, counted, state, matrices, unit)
    return Measured([*findings, *closures(whole, state, matrix_rounding(unit, ROUNDING))])


def of_mass_matrix(
    whole: Mechanism, q: Array, matrices: Array, unit: float
) -> tuple[list[Finding | Inconclusive], Mechanism]:
    """Return the error of mass matrices (k, n, n) and the shares of masses and inertias.

    Returns
    -------
    findings : list of Finding or Inconclusive
    counted : Mechanism
        With the masses and inertias that the matrices show, so that their effect on Coriolis forces
        and weights is not a second fault.
    """
    room, names = matrix_rounding(unit, ROUNDING), inertial_names(whole)
    every = [inertias(whole, position) for position in q]
    right = np.array([np.sum(list(parts.values()), axis=0) for parts in every])
    turns = np.isin(range(len(right[0])), [i for turning, _ in movers(whole) for i in turning])
    largest = np.sqrt(largest_inertias(right, turns[:, None] == turns))
    summed = OPERATIONS * unit / room * np.outer(largest, largest)
    size = np.array([np.maximum(scale_of(one), summed) for one in right])

    def columns(matrices: Sequence[Array]) -> Array:
        each = zip(matrices, size, strict=True)
        return np.hstack([(one / scale).reshape(-1, scale.size) for one, scale in each]).T

    rows = ((matrices - right) / size).ravel()
    worst = float(np.max(np.abs(rows)))
    parts = [
        Effect(name, columns([one[name] for one in every]), partial(of_share, name))
        for name in names
    ]
    additions = [*added_inertias(whole, names)] if worst > room else []
    candidates = [
        Effect(one.name, columns([one.at(whole, at) for at in q]), one.words, added=True)
        for one in additions
    ]
    explained = explain(parts, candidates, rows, room)
    shares = {
        one.name: 1 + float(explained.values[one.name][0])
        for one in parts
        if np.any(np.abs(explained.values[one.name]) > explained.tolerances[one.name])
    }
    counted = with_shares(whole, shares)
    for one in additions:
        if one.name in explained.values:
            counted = one.changed(counted, explained.values[one.name])
    reason = "; ".join(explained.added) or WHOLE["mass_matrix"]
    first = Finding("mass_matrix", "1", worst, 0.0, worst, room, reason)
    return [first, *findings_of(parts, explained, "mass matrix is")], counted


def of_forces(
    system: System, whole: Mechanism, state: tuple[Array, ...], matrices: Array | None, unit: float
) -> list[Finding | Inconclusive]:
    """Return the shares of forces, and of inertias where no mass matrix is given.

    Of ``M a = sum of forces`` projected on the motions that loops permit: each row relative to
    the sum of its parts.

    Parameters
    ----------
    system : System
    whole : Mechanism
        With the masses and inertias that the engine's mass matrix shows.
    state : tuple of array
        Times (k,), positions, velocities and an engine's accelerations (k, n) of joints.
    matrices : array (k, n, n), or None
        The engine's mass matrices.
    unit : float
        Of rounding of the engine's numbers.
    """
    times, q, v, a = state
    room, file = matrix_rounding(unit, ROUNDING), mechanism(system.mjcf)
    masses = () if matrices is not None else inertial_names(whole)
    terms = {f"{one.kind}.{one.name}": one for one in system.terms}
    names = (*terms, *names_of_forces(file), *masses)
    permitted = [free_motions(whole, position) for position in q]
    axes = gravity_axes(whole, q, permitted)
    forces: dict[str, list[Array]] = {name: [] for name in names}
    pulls, rows, scales, velocities = [], [], [], []
    for i, (time, position, rate) in enumerate(zip(times, q, v, strict=True)):
        right = mass_matrix(whole, position)
        here = dict.fromkeys(names, np.zeros_like(rate))  # of what has no inertia left
        here |= {n: term_force(one, system, time, position, rate) for n, one in terms.items()}
        here |= inertial_forces(whole, position, rate)
        acting = np.sum(list(here.values()), axis=0) + weight(whole, position, whole.gravity)
        here |= {name: needed(whole, name, position, rate, a[i]) for name in masses}
        for name, force in here.items():
            forces[name].append(force)
        pulls.append(np.array([weight(whole, position, GRAVITY * axis) for axis in axes]))
        free = permitted[i]
        size = np.sum([np.abs(free.T @ one) for one in here.values()], axis=0)
        size = size + np.abs(free.T @ right @ a[i])
        inertia = np.abs(free.T) @ np.abs(right) @ np.abs(a[i])
        alive = size > room * inertia  # below, inertial forces cancel but for rounding
        size = np.maximum(size, UNITS * len(rate) * unit / room * inertia)
        scales.append(free[:, alive] / size[alive])
        velocities.append(np.flatnonzero(alive))
        mass = right if matrices is None else matrices[i]
        rows.append((mass @ a[i] - acting) @ scales[i])

    def columns(force: Iterable[Array]) -> Array:
        each = zip(force, scales, strict=True)
        return np.hstack([np.atleast_2d(one) @ scale for one, scale in each]).T

    relative = np.concatenate(rows)
    parts = [
        Effect(name, columns(force), partial(of_share, name)) for name, force in forces.items()
    ]
    parts.append(Effect("gravity", columns(pulls), partial(of_gravity, axes @ whole.gravity)))
    candidates = []
    if np.max(np.abs(relative)) > room:
        for name, at, said in added_forces(file, system):
            force = [at(*here) for here in zip(times, q, v, strict=True)]
            candidates.append(Effect(name, columns(force), said, added=True))
        for one in added_inertias(file, inertial_names(file)) if matrices is None else ():
            changed = [one.changed(file, unit) for unit in np.eye(one.size)]
            force = [
                np.array([need(other, *here) for other in changed]) - need(file, *here)
                for here in zip(q, v, a, strict=True)
            ]
            candidates.append(Effect(one.name, columns(force), one.words, added=True))
    explained = explain(parts, candidates, relative, room)
    if not explained.unique and not whole.closures:
        of_rows = joints_of(file)[np.concatenate(velocities)]
        explained = but_for_one_joint(parts, candidates, relative, of_rows, explained, room)
    reason = "; ".join(explained.added) or WHOLE["unexplained"]
    left, granted = explained.left, explained.granted
    last = Finding("unexplained", "1", left, 0.0, left, granted, reason)
    return [*findings_of(parts, explained, "forces are"), last]


def need(whole: Mechanism, q: Array, v: Array, a: Array) -> Array:
    """Return the sum of weights and forces of inertia (n,) at accelerations."""
    inertial = inertial_force(whole, q, v) + mass_matrix(whole, q) @ a
    return np.asarray(weight(whole, q, whole.gravity) - inertial)


def needed(whole: Mechanism, name: str, q: Array, v: Array, a: Array) -> Array:
    """Return the forces (n,) that one inertia of a mechanism needs for accelerations."""
    only = with_shares(whole, dict.fromkeys(set(inertias(whole, q)) - {name}, 0.0))
    own = inertias(whole, q)[name] @ a
    if name.startswith("armature."):
        return -own
    return np.asarray(weight(only, q, whole.gravity) - inertial_force(only, q, v) - own)


def but_for_one_joint(
    parts: list[Effect],
    additions: list[Effect],
    rows: Array,
    joints: NDArray[np.str_],
    explained: Explanation,
    room: float,
) -> Explanation:
    """Return the explanation of all forces but those on one joint, if there is one such joint."""
    tried = []
    for joint in {*joints[np.abs(rows) > room]}:
        others = joints != joint
        some, more = (
            [one._replace(columns=one.columns[others]) for one in several]
            for several in (parts, additions)
        )
        rest = explain(some, more, rows[others], room)
        if rest.unique:
            free = Effect(joint, np.zeros((len(rows), 0)), lambda x, moved: "", added=True)
            said = f"the force on {joint} is not the sum of its parts in any shares"
            tried.append(
                rest._replace(
                    effects=[free, *rest.effects],
                    said={joint: said} | rest.said,
                    left=explained.left,
                    granted=explained.granted,
                )
            )
    return tried[0] if len(tried) == 1 else explained


def free_motions(whole: Mechanism, position: Array) -> Array:
    """Return the velocities (n, m) of joints that loops permit."""
    if not whole.closures:
        return np.eye(whole.layout.size[1])
    return np.asarray(null_space(gap_jacobian(whole, position), DISTINCT))


def gravity_axes(whole: Mechanism, q: Array, free: list[Array]) -> Array:
    """Return axes (3, 3) of gravities that act at positions (k, n_q), less of them followed by 0.

    The first is that of the file's gravity, so that one number is its share, also if the plane of
    motion is inclined in the world.
    """
    pulls = [
        np.array([weight(whole, position, axis) @ motions for axis in np.eye(3)]).T
        for position, motions in zip(q, free, strict=True)
    ]
    _, sizes, ways = np.linalg.svd(np.vstack(pulls))
    acting = ways[: np.count_nonzero(sizes > DISTINCT * sizes[0])]
    first = np.column_stack([acting @ whole.gravity, np.eye(len(acting))])
    axes = np.linalg.qr(first)[0].T @ acting
    return np.vstack([axes, np.zeros((3 - len(acting), 3))])


def of_gravity(gravity: Array, x: Array, moved: Array) -> str:
    """Return the meaning of shares (3,) added to the gravity (3,) of the file [m/s^2], in words."""
    seen = moved <= VISIBLE
    extra, gravity = GRAVITY * x * seen, gravity * seen
    size, sum_of_both = float(np.linalg.norm(gravity)), float(np.linalg.norm(gravity + extra))
    if not size:
        return f"gravity of {float(np.linalg.norm(extra)):.4g} m/s^2, where the file has none"
    share = float(extra @ gravity) / size**2
    room = max(GRAVITY * float(np.linalg.norm(moved[seen])), 1e-6 * size)
    if np.linalg.norm(extra - share * gravity) <= room:
        return of_share("gravity", np.array([share]), np.array([room / size]))
    if abs(sum_of_both - size) <= room:
        angle = np.degrees(np.arccos(np.clip((gravity + extra) @ gravity / size**2, -1, 1)))
        return f"gravity: its direction is off by {angle:.3g} degrees"
    return f"gravity of {sum_of_both:.4g} m/s^2 in another direction, where the file has {size:.4g}"


def findings_of(
    parts: list[Effect], explained: Explanation, of: str
) -> Iterator[Finding | Inconclusive]:
    """Yield the finding on each part's share, or the reason why it cannot be determined."""
    for one in parts:
        x, moved = explained.values[one.name], explained.tolerances[one.name]
        seen, right = moved <= VISIBLE, float(one.name != "gravity")
        if not explained.unique:
            yield Inconclusive(one.name, f"the {of} not a sum of the parts in any shares")
        elif not np.any(seen):
            said = f"{part_of(one.name)} has too small an effect to be separated from round-off"
            yield Inconclusive(one.name, said)
        else:
            error, room = (float(np.linalg.norm(numbers[seen])) for numbers in (x, moved))
            value = right + (float(x[0]) if right else error)
            said = ", or ".join([one.words(x, moved), *explained.others.get(one.name, ())])
            yield Finding(one.name, "1", value, right, error, room, said)


def closures(whole: Mechanism, state: tuple[Array, ...], room: float) -> Iterator[Finding]:
    """Yield the opening of each loop by accelerations."""
    for i, one in enumerate(whole.closures):
        worst = 0.0
        for position, rate, acceleration in zip(*state[1:], strict=True):
            place = slice(3 * i, 3 * i + 3)
            opening = gap_jacobian(whole, position)[place] @ acceleration
            drift = gap_drift(whole, position, rate)[place]
            size = float(np.max(np.abs(opening)) + np.max(np.abs(drift)))
            worst = max(worst, float(np.max(np.abs(opening + drift))) / (size or 1.0))
        reason = f"closure of {one.name}: its opening, as a share of its ends' acceleration"
        yield Finding(f"closure.{one.name}", "1", worst, 0.0, worst, room, reason)

"""Mistakes in the parts of a model: wrong shares, added or dropped terms, confused frames."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations_with_replacement
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....models.kinematics import Placed, inertias, mass_matrix, movers, place
from ....models.mechanism import Body, Mechanism
from ....models.system import System, term_force
from ....reference.scene import Array

VISIBLE = 1e-2
"""A share that round-off could change by more than this is not judged."""

APART = 1e-6
"""Parts that differ by less than this share cannot be separated."""

DISTINCT = 1e-9
"""Parts whose forces differ by less count as the same."""

RUNNER_UP = 10.0
"""How many times rounding every other explanation leaves at least, where one is named."""

ROWS = 2
"""Least number of rows for each share where all are fitted together."""

MOST_OTHERS = 2
"""Most other explanations that are named with one; if there are more, none is."""

SPATIAL = {"products": "products of inertia", "gyroscopic": "gyroscopic term"}
"""Words for parts that only bodies in space have."""

SHARES = {
    0.0: "dropped",
    -1.0: "its sign is reversed",
    np.pi / 180: "degrees were taken for radians",
    180 / np.pi: "radians were taken for degrees",
}
"""Meanings of shares of a part."""

Words = Callable[[Array, Array], str]
"""Function of numbers (k,) and their round-off that returns their meaning, empty if no reader errs
so."""


class Effect(NamedTuple):
    """A part of a model, or a term that a reader of files may add or drop.

    Attributes
    ----------
    name : str
    columns : array (m, k)
        Its contribution to the rows by each of k numbers, all 0 if an engine follows the file.
    words : callable
    added : bool
        Whether it is none of the file's parts.
    members : tuple of str
        Parts that it represents, each by the same number.
    """

    name: str
    columns: Array
    words: Words
    added: bool = False
    members: tuple[str, ...] = ()


class Explanation(NamedTuple):
    """An explanation of the rows.

    Attributes
    ----------
    effects : tuple of Effect
        Whose numbers are fitted.
    values : mapping of str to array (k,)
        Deviation of the number of each part or addition from the file.
    tolerances : mapping of str to array (k,)
        Changes of these by round-off.
    said : mapping of str to str
        Meaning of the numbers of each effect.
    left, granted : float
        Norm of the rows that the shares of parts leave, and of round-off.
    unique : bool
        Whether this explains all, and nothing else does.
    others : mapping of str to tuple of str
        Descriptions of other effects that would explain the same.
    """

    effects: Sequence[Effect]
    values: dict[str, Array]
    tolerances: dict[str, Array]
    said: dict[str, str]
    left: float
    granted: float
    unique: bool
    others: Mapping[str, tuple[str, ...]] = MappingProxyType({})

    @property
    def added(self) -> tuple[str, ...]:
        """Additions and omissions of an engine beyond the parts of the file, in words."""
        names = [one.name for one in self.effects if one.added]
        return tuple(", or ".join([self.said[n], *self.others.get(n, ())]) for n in names)


def part_of(name: str) -> str:
    """Return the words for a part."""
    kind, _, of = name.partition(".")
    return f"{SPATIAL.get(kind, kind.replace('_', ' '))} of {of}" if of else kind


def of_share(name: str, x: Array, moved: Array) -> str:
    """Return the meaning of the deviation (1,) of a share of a part from 1, in words."""
    value, part = 1 + float(x[0]), part_of(name)
    for right, said in SHARES.items():
        if abs(value - right) <= max(float(moved[0]), APART * abs(right)):
            return f"{part}: {said}"
    digits = max(6, math.ceil(1 - math.log10(abs(x[0])))) if 0 < abs(x[0]) < 1 else 6
    return f"{part}: counted {value:.{min(digits, 16)}g} times"


def explain(
    parts: Sequence[Effect], additions: Sequence[Effect], rows: Array, room: float
) -> Explanation:
    """Explain rows (m,) by shares of parts, and by terms that readers of files add or drop.

    The explanation has the fewest numbers that leave no more than round-off, if all others as few
    leave `RUNNER_UP` times that: those of one candidate, of two, or of all parts.

    Parameters
    ----------
    parts, additions : sequence of Effect
    rows : array (m,)
        Difference of an engine from the file, relative.
    room : float
        Round-off of a row.
    """
    error, whole = float(np.linalg.norm(rows)), fitted(parts, rows, room)
    if error <= whole.granted:
        return whole._replace(unique=True)
    best, values = None, {name: np.zeros_like(x) for name, x in whole.values.items()}
    if RUNNER_UP * whole.granted < error < np.inf:
        best = simplest([*both(parts), *both(additions)], whole, rows, room)
    if best is None:
        return whole._replace(values=values, left=error, unique=False)
    values |= best.values
    left = float(np.linalg.norm(rows - sum(one.columns @ values[one.name] for one in parts)))
    return best._replace(values=values, tolerances=whole.tolerances | best.tolerances, left=left)


def both(effects: Sequence[Effect]) -> Iterator[Effect]:
    """Yield those that act, and all of each kind that has several, by one number."""
    acting = [one for one in effects if np.any(one.columns)]
    yield from acting
    for kind in dict.fromkeys(one.name.partition(".")[0] for one in acting):
        same = [one for one in acting if one.name.startswith(f"{kind}.")]
        if len(same) > 1 and same[0].columns.shape[1] == 1:
            yield together(kind, same)


def together(kind: str, same: Sequence[Effect]) -> Effect:
    """Return several effects by one number."""
    return Effect(
        kind,
        np.sum([one.columns for one in same], axis=0),
        lambda x, moved: "; ".join(one.words(x, moved) for one in same),
        same[0].added,
        tuple(one.name for one in same),
    )


def fitted(effects: Sequence[Effect], rows: Array, room: float) -> Explanation:
    """Fit some candidates by least squares; unique where no other numbers of them do the same."""
    columns = np.hstack([np.zeros((len(rows), 0)), *(one.columns for one in effects)])
    size = np.max(np.abs(columns), axis=0, initial=0.0)
    acting = np.where(size > 0, size, 1.0)
    inverse = np.linalg.pinv(columns / acting, rcond=DISTINCT) / acting[:, None]
    distinct = np.linalg.matrix_rank(columns / acting, APART) == np.count_nonzero(size)
    x, moved = inverse @ rows, room * np.sum(np.abs(inverse), axis=1)
    left = float(np.linalg.norm(rows - columns @ x))
    ends = np.cumsum([one.columns.shape[1] for one in effects])[:-1]
    both = np.split(x, ends), np.split(np.where(size > 0, moved, np.inf), ends)
    said = {one.name: one.words(*numbers) for one, *numbers in zip(effects, *both, strict=True)}
    values, tolerances = (
        {
            name: number
            for one, number in zip(effects, numbers, strict=True)
            for name in one.members or (one.name,)
        }
        for numbers in both
    )
    granted, meant = room * float(np.sqrt(len(rows))), bool(distinct and all(said.values()))
    return Explanation(effects, values, tolerances, said, left, granted, meant)


def simplest(
    every: Sequence[Effect], whole: Explanation, rows: Array, room: float
) -> Explanation | None:
    """Return the fewest candidates that explain all: one, of few numbers, two, or all parts.

    None where rows are too few to prove anything. A part that rounding could move by much is no
    explanation.
    """
    every = [
        one
        for one in every
        if one.added or min(map(np.min, fitted([one], rows, room).tolerances.values())) < VISIBLE
    ]
    counts = [np.count_nonzero(np.any(one.columns, axis=0)) for one in every]
    levels: list[list[tuple[Effect, ...]]] = [
        [(one,) for one, own in zip(every, counts, strict=True) if own == count]
        for count in sorted({*counts})
    ]
    for sets in (*levels, near_pairs(every, rows)):
        fits = [fitted(one, rows, room) for one in sets]
        fits = [fit for fit in fits if not is_trivial(fit, whole.effects)]
        if any(fit.unique and fit.left <= fit.granted for fit in fits):
            return the_only(fits)
    proven = whole.unique and len(rows) >= ROWS * sum(map(len, whole.values.values()))
    explains = whole.left <= whole.granted and not is_trivial(whole, whole.effects)
    return whole if proven and explains else None


def is_trivial(fit: Explanation, parts: Sequence[Effect]) -> bool:
    """Return True if inertias and forces are all dropped, which explains any accelerations.

    Inertias take their weights and their forces of inertia along.
    """
    acting = [
        one.name
        for one in parts
        if np.any(one.columns) and not one.name.startswith(("gravity", "coriolis", "gyroscopic"))
    ]
    has_inertias = any(name.startswith(("mass.", "inertia.")) for name in acting)
    dropped = {name for name, x in fit.values.items() if abs(x[0] + 1) < VISIBLE}
    return has_inertias and dropped.issuperset(acting)


def near_pairs(every: Sequence[Effect], rows: Array) -> list[tuple[Effect, ...]]:
    """Return the pairs of candidates of one number each that explain nearly all."""
    single = [one for one in every if one.columns.shape[1] == 1]
    units = [one.columns / np.linalg.norm(one.columns) for one in single]
    columns = np.hstack([np.zeros((len(rows), 0)), *units])
    along, same = columns.T @ rows, columns.T @ columns
    apart = np.maximum(1 - same**2, DISTINCT)
    explained = (along[:, None] ** 2 + along**2 - 2 * same * np.outer(along, along)) / apart
    near = (explained > (1 - APART) * float(rows @ rows)) & (apart > DISTINCT)
    return [(single[i], single[j]) for i, j in np.argwhere(np.triu(near, 1))]


def the_only(fits: Iterable[Explanation]) -> Explanation | None:
    """Return the fit that explains all, the smallest change of parts first.

    None where others explain as much that differ by more than one candidate.
    """
    first, *rivals = sorted(
        (fit for fit in fits if fit.unique and fit.left < RUNNER_UP * fit.granted),
        key=lambda fit: (
            fit.left > fit.granted,
            sum(one.added for one in fit.effects),
            not fit.effects[0].added and float(np.max(np.abs(next(iter(fit.values.values()))))),
        ),
    )
    others: dict[str, tuple[str, ...]] = {}
    for rival in rivals:
        mine = [name for name in first.said if name not in rival.said]
        theirs = [text for name, text in rival.said.items() if name not in first.said]
        if len(mine) != 1 or len(theirs) != 1:
            return None
        others[mine[0]] = (*others.get(mine[0], ()), *theirs)
    named = max(map(len, others.values()), default=0)
    return first._replace(others=others) if named <= MOST_OTHERS else None


# Terms and frames

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
    """Return a mechanism with multiples of tensors (k, 3, 3) added to that of a body."""
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
        "it differs otherwise": True,
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

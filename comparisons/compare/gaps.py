"""Quantities of two models that differ at the same states by more than round-off."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..documents.fields import Number, documented
from ..reports.words import number

EPS = float(np.finfo(float).eps)

OPERATIONS = 64
"""Roundings along the way to a quantity, in each of its terms: MuJoCo's sums over trees and
quaternions take some tens of them."""

QUANTITIES: Mapping[str, tuple[str, str]] = {
    "xpos": ("position", "body"),
    "xmat": ("orientation", "body"),
    "mass": ("mass matrix", "joint"),
    "gravity": ("force of gravity", "joint"),
    "bias": ("bias force", "joint"),
    "spring": ("spring force", "joint"),
    "damper": ("damper force", "joint"),
    "gravcomp": ("gravity compensation", "joint"),
    "fluid": ("fluid force", "joint"),
    "ten_length": ("length", "tendon"),
    "ten_velocity": ("velocity", "tendon"),
    "actuator_length": ("length", "output"),
    "actuator_force": ("force", "output"),
    "actuator": ("force of actuators", "joint"),
    "qacc_smooth": ("acceleration without constraints", "joint"),
    "qacc": ("acceleration", "joint"),
    "step_euler": ("step of Euler", "step"),
    "step_rk4": ("step of RK4", "step"),
    "step_implicit": ("step of implicit", "step"),
    "step_implicitfast": ("step of implicitfast", "step"),
}
"""Quantity of `probe.evaluated` -> its name, and the kind of its rows; causes before effects.

Rows of ``joint`` are degrees of freedom; those of ``step`` positions, velocities and activations.
"""

FORCES = ("bias", "spring", "damper", "actuator", "fluid")
"""Quantities that are terms of the equation of motion."""

COLLISION = 2e-6
"""Largest difference of two depths [m] that are both good to MuJoCo's ``ccd_tolerance``, 1e-6 m."""

CONTACT = {
    "depth": (slice(0, 1), COLLISION),
    "dimension": (slice(1, 2), 0.5),
    "margin": (slice(2, 3), COLLISION),
    "friction": (slice(15, 20), 1e-12),
    "solref": (slice(20, 22), 1e-12),
    "solimp": (slice(22, 27), 1e-12),
}
"""Quantity of a contact -> its columns, and its tolerance."""

GEOMETRY = [0, *range(3, 15)]
"""Columns of depth, position and frame of a contact."""

TINY = 1e-300


@dataclass(frozen=True)
class Gap:
    """A quantity that differs, where it differs most.

    Attributes
    ----------
    quantity : str
        which quantity
    element : str
        the element of A that it belongs to
    state : str
        the state in which it differs most
    a : float
        its value of A (SI)
    b : float
        its value of B (SI)
    tolerance : float
        what rounding explains (SI)
    """

    quantity: str
    element: str
    state: str
    a: Number
    b: Number
    tolerance: Number

    @property
    def id(self) -> str:
        """Quantity and element."""
        return f"{self.quantity} {self.element}"

    @property
    @documented
    def sentence(self) -> str:
        """The difference in words."""
        a, b = distinct([self.a], [self.b], 3)
        return f"{self.element}: {self.quantity} {a} and {b}, {self.state}"


def distinct(first: Sequence[Any], second: Sequence[Any], digits: int) -> tuple[str, str]:
    """Return two lists of values in words, in no fewer digits than it takes to differ."""
    for count in range(digits, 18):
        one, other = (
            " ".join(number(float(v), count) if isinstance(v, int | float) else str(v) for v in vs)
            for vs in (first, second)
        )
        if one != other:
            break
    return one or "none", other or "none"


def gaps_between(
    own: Sequence[Mapping[str, Any]],
    other: Sequence[Mapping[str, Any]],
    states: Sequence[str],
    labels: Mapping[str, Sequence[str]],
    eps: float = EPS,
) -> list[Gap]:
    """Return the largest gap of each quantity, in units of its tolerance.

    Parameters
    ----------
    own, other : sequence of mapping of str to array
        Answers of A and B at each state, in the order of A.
    states : sequence of str
        Names of the states.
    labels : mapping of str to sequence of str
        Labels of bodies, tendons and actuators, and of rows of ``joint`` and ``step``.
    eps : float
        Rounding unit of the numbers of both.
    """
    worst: dict[str, tuple[float, Gap]] = {}
    for a, b, state in zip(own, other, states, strict=True):
        arrays = (
            largest(QUANTITIES[key][0], labels[QUANTITIES[key][1]], state, a[key], b[key], limit)
            for key, limit in tolerances(a, b, eps)
            if a[key].size
        )
        for ratio, gap in (*arrays, *row_gaps(a, b, state)):
            if ratio > worst[gap.quantity][0] if gap.quantity in worst else ratio > 1:
                worst[gap.quantity] = ratio, gap
    order = [name for name, _ in QUANTITIES.values()]
    return sorted(
        (gap for _, gap in worst.values()),
        key=lambda gap: order.index(gap.quantity) if gap.quantity in order else -1,
    )


def largest(
    quantity: str, labels: Sequence[str], state: str, a: Any, b: Any, tolerance: Any
) -> tuple[float, Gap]:
    """Return the largest difference of two arrays over its tolerance, and where it is."""
    limit = np.broadcast_to(tolerance, a.shape)
    with np.errstate(invalid="ignore"):
        ratio = abs(a - b) / np.maximum(limit, TINY)
    lost = ~np.isfinite(a) & ~np.isfinite(b)  # in a step that overflows
    ratio = np.where(lost, 0.0, np.nan_to_num(ratio, nan=np.inf, posinf=np.inf))
    at = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
    values = (float(values[at]) for values in (a, b, limit))
    return float(ratio[at]), Gap(quantity, labels[int(at[0])], state, *values)


def collides_differently(a: Mapping[str, Any], b: Mapping[str, Any]) -> bool:
    """Return True if contacts differ by no more than the tolerance of collisions, or their order.

    Accelerations then differ by more than round-off, for no other reason.
    """
    for key, one in a.get("rows", {}).items():
        other = b.get("rows", {}).get(key)
        if one.first and other is not None:
            apart = abs(abs(one.geometry) - abs(other.geometry)).max()
            if one.first != other.first or OPERATIONS * EPS < apart < COLLISION:
                return True
    return False


def row_numbers(
    pos: float, aref: float, stiffness: float, frictionloss: float, inverse: float, jacobian: Any
) -> dict[str, tuple[Any, float]]:
    """Return the quantities of a row of a constraint, each with its values and its tolerance."""
    unit = OPERATIONS * EPS
    scale = max(1.0, abs(pos), abs(jacobian).max(initial=0.0))
    numbers = {
        "position": (pos, unit * scale),
        "reference acceleration": (aref, unit * (abs(aref) + stiffness * scale)),
        "friction loss": (frictionloss, unit * frictionloss),
        "regularised inverse inertia": (inverse, unit * inverse * max(1.0, len(jacobian))),
    }
    return {name: (np.array([value]), float(limit)) for name, (value, limit) in numbers.items()}


def row_gaps(a: Mapping[str, Any], b: Mapping[str, Any], state: str) -> Iterator[tuple[float, Gap]]:
    """Yield differences of rows of constraints and of contacts, over their tolerances."""
    for key in dict.fromkeys((*a["rows"], *b["rows"])) if "rows" in b else ():
        what, label, _ = key
        one, other = a["rows"].get(key), b["rows"].get(key)
        if one is None or other is None:
            yield np.inf, missing(what, label, state, one)
            continue
        for name, (values, limit) in one.numbers.items():
            if name == "depth" and one.first != other.first:
                continue  # MuJoCo's collision of convex shapes depends on their order
            labels, theirs = [label] * len(values), other.numbers[name][0]
            yield largest(f"{what}, {name}", labels, state, values, theirs, limit)


def missing(quantity: str, label: str, state: str, of_a: Any) -> Gap:
    """Return the gap of what A or B alone has: 1 where it is there, 0 where it is not."""
    there = float(of_a is not None)
    return Gap(quantity, label, state, there, 1.0 - there, 0.0)


def acceleration_roundoff(a: Mapping[str, Any], eps: float) -> Any:
    """Return the round-off of each acceleration (n,).

    Entries of the mass matrix M are good to the rounding unit of sqrt(M_ii M_jj), so that a joint
    with large accelerations does not hide one with small ones unless M couples them.
    """
    mass = np.nan_to_num(a["mass"])
    size = np.sqrt(abs(np.diag(mass)))
    of_rows = np.max(a["row_force"] / np.maximum(size, TINY), initial=0.0)
    scale = max(size @ abs(a["qacc"]), of_rows)
    return OPERATIONS * eps * (abs(np.linalg.pinv(mass)) @ size) * scale + 4 * a["qacc_floor"]


def tolerances(a: Mapping[str, Any], b: Mapping[str, Any], eps: float) -> Iterator[tuple[str, Any]]:
    """Yield the quantities that both have, and how far rounding may part them.

    Sums round by the largest of their terms; accelerations lose as many digits as the mass matrix
    has a condition number. With constraints the largest force of a row counts as well, and the
    difference of two runs of the solver.
    """
    unit, mass = OPERATIONS * eps, a["mass"]
    common = [key for key in QUANTITIES if key in a and key in b and a[key].shape == b[key].shape]
    size = {
        key: max(abs(np.nan_to_num(side[key], posinf=0)).max(initial=0.0) for side in (a, b))
        for key in common
    }
    force = sum(size.get(key, 0.0) for key in FORCES)
    condition: Any = 1.0
    norm: Any = 1.0
    if len(mass):
        finite = np.all(np.isfinite(mass))
        condition = np.linalg.cond(mass) if finite else np.inf
        norm = np.linalg.norm(mass, 2) if finite else 1.0
    smooth = unit * condition * max(size.get("qacc_smooth", 0.0), size.get("qacc", 0.0))
    of_rows = unit * condition * a["row_force"].max(initial=0.0) / norm
    own = {"xmat": unit, **dict.fromkeys((*FORCES, "gravity"), unit * force), "qacc_smooth": smooth}

    def floor(name: str) -> Any:
        floors = [abs(side[f"{name}_floor"]).max(initial=0.0) for side in (a, b)]
        return 4 * max(np.nan_to_num(floors, nan=np.inf))  # of a step that overflows

    own["qacc"] = smooth + floor("qacc") + of_rows
    collided = collides_differently(a, b)
    for key in common:
        if key.startswith("step_"):  # which is below 1 s
            own[key] = own["qacc"] + unit * size[key] + floor(key)
        if not (collided and (key == "qacc" or key.startswith("step_"))):
            yield key, own.get(key, unit * size[key])

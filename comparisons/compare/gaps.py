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
    "actuator_length": ("length", "actuator"),
    "actuator_force": ("force", "actuator"),
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

ROWS = {
    "pos": "position",
    "aref": "reference acceleration",
    "frictionloss": "friction loss",
    "inverse_inertia": "regularised inverse inertia",
}
"""Number of a row of a constraint -> its name."""

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
        for ratio, gap in (*array_gaps(a, b, state, labels, eps), *row_gaps(a, b, state)):
            if ratio > worst[gap.quantity][0] if gap.quantity in worst else ratio > 1:
                worst[gap.quantity] = ratio, gap
    order = [name for name, _ in QUANTITIES.values()]
    return sorted(
        (gap for _, gap in worst.values()),
        key=lambda gap: order.index(gap.quantity) if gap.quantity in order else -1,
    )


def array_gaps(
    a: Mapping[str, Any],
    b: Mapping[str, Any],
    state: str,
    labels: Mapping[str, Sequence[str]],
    eps: float,
) -> Iterator[tuple[float, Gap]]:
    """Yield the largest difference of each quantity over its tolerance, and where it is."""
    for key, tolerance in tolerances(a, b, eps):
        name, kind = QUANTITIES[key]
        limit = np.broadcast_to(tolerance, a[key].shape)
        if limit.size:
            lost = ~np.isfinite(a[key]) & ~np.isfinite(b[key])  # a step that overflows
            ratio = np.where(lost, 0.0, abs(a[key] - b[key]) / np.maximum(limit, TINY))
            ratio = np.where(np.isnan(ratio), np.inf, ratio)
            at = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
            values = (float(values[at]) for values in (a[key], b[key], limit))
            yield float(ratio[at]), Gap(name, labels[kind][int(at[0])], state, *values)


def collides_differently(a: Mapping[str, Any], b: Mapping[str, Any]) -> bool:
    """Return True if contacts differ by no more than the tolerance of collisions, or their order.

    Accelerations then differ by more than round-off, for no other reason.
    """
    for pair, one in a.get("contacts", {}).items():
        other = b.get("contacts", {}).get(pair)
        if other is not None:
            apart = abs(abs(one.numbers[GEOMETRY]) - abs(other.numbers[GEOMETRY])).max()
            if one.first != other.first or OPERATIONS * EPS < apart < COLLISION:
                return True
    return False


def row_gaps(a: Mapping[str, Any], b: Mapping[str, Any], state: str) -> Iterator[tuple[float, Gap]]:
    """Yield differences of rows of constraints and of contacts, over their tolerances."""
    if "rows" not in b:
        return
    unit = OPERATIONS * EPS
    for key in dict.fromkeys((*a["rows"], *b["rows"])):
        kind, label, _ = key
        what = f"{kind.replace('_', ' of ')} row"
        one, other = a["rows"].get(key), b["rows"].get(key)
        if one is None or other is None:
            yield np.inf, missing(what, label, state, one)
            continue
        scale = max(1.0, abs(one["pos"]), abs(one["jacobian"]).max(initial=0.0))
        limits = {
            "pos": unit * scale,
            "aref": unit * (abs(one["aref"]) + one["stiffness"] * scale),
            "frictionloss": unit * one["frictionloss"],
            "inverse_inertia": unit * one["inverse_inertia"] * max(1.0, len(one["jacobian"])),
        }
        for name, limit in limits.items():
            ratio = abs(one[name] - other[name]) / max(limit, TINY)
            yield ratio, Gap(f"{what}, {ROWS[name]}", label, state, one[name], other[name], limit)
    for pair in dict.fromkeys((*a["contacts"], *b["contacts"])):
        one, other = a["contacts"].get(pair), b["contacts"].get(pair)
        if one is None or other is None:
            yield np.inf, missing("contact", pair[0], state, one)
            continue
        for name, (columns, limit) in CONTACT.items():
            if name == "depth" and one.first != other.first:
                continue  # MuJoCo's collision of convex shapes depends on their order
            mine, theirs = one.numbers[columns], other.numbers[columns]
            apart = abs(mine - theirs)
            at = int(np.argmax(apart))
            values = float(mine[at]), float(theirs[at])
            yield float(apart[at]) / limit, Gap(f"contact, {name}", pair[0], state, *values, limit)


def missing(quantity: str, label: str, state: str, of_a: Any) -> Gap:
    """Return the gap of what A or B alone has: 1 where it is there, 0 where it is not."""
    there = float(of_a is not None)
    return Gap(quantity, label, state, there, 1.0 - there, 0.0)


def constraint_force(a: Mapping[str, Any]) -> float:
    """Return the largest generalised force that a row of a constraint may exert (SI)."""
    return max(
        (
            abs(one["jacobian"]).max(initial=0.0) * abs(one["aref"]) / one["inverse_inertia"]
            for one in a["rows"].values()
        ),
        default=0.0,
    )


def acceleration_roundoff(a: Mapping[str, Any], eps: float) -> Any:
    """Return the round-off of each acceleration (n,).

    Entries of the mass matrix M are good to the rounding unit of sqrt(M_ii M_jj), so that a joint
    with large accelerations does not hide one with small ones unless M couples them.
    """
    mass = np.nan_to_num(a["mass"])
    size = np.sqrt(abs(np.diag(mass)))
    scale = size @ abs(a["qacc"])
    for one in a["rows"].values():
        force = abs(one["jacobian"]) * abs(one["aref"]) / one["inverse_inertia"]
        scale = max(scale, np.max(force / np.maximum(size, TINY), initial=0.0))
    return OPERATIONS * eps * (abs(np.linalg.pinv(mass)) @ size) * scale + 4 * a["qacc_floor"]


def tolerances(a: Mapping[str, Any], b: Mapping[str, Any], eps: float) -> Iterator[tuple[str, Any]]:
    """Yield the quantities that both have, and how far rounding may part them.

    Sums round by the largest of their terms; accelerations lose as many digits as the mass matrix
    has a condition number. With constraints the largest force of a row counts as well, and the
    difference of two runs of the solver.
    """
    unit, n = OPERATIONS * eps, len(a["bias"])
    common = [key for key in QUANTITIES if key in a and key in b]
    size = {
        key: max(abs(np.nan_to_num(side[key], posinf=0)).max(initial=0.0) for side in (a, b))
        for key in common
    }
    force = sum(
        size[key] for key in ("bias", "spring", "damper", "actuator", "fluid") if key in size
    )
    finite = n and np.all(np.isfinite(a["mass"]))
    condition = np.linalg.cond(a["mass"]) if finite else np.inf if n else 1.0
    norm = np.linalg.norm(a["mass"], 2) if finite else 1.0
    constrained = [key for key in size if key == "qacc" or key.startswith("step_")]
    constrained *= collides_differently(a, b)
    own = {
        "xmat": 1.0,
        **{key: force for key in ("bias", "gravity", "actuator", "damper", "spring", "fluid")},
    }
    for key in size:
        if a[key].shape != b[key].shape or key in constrained:
            continue
        tolerance: Any = unit * own.get(key, size[key])
        if key in ("qacc_smooth", "qacc") or key.startswith("step_"):
            floor = max(abs(a["qacc_floor"]).max(initial=0), abs(b["qacc_floor"]).max(initial=0))
            largest = max(size[name] for name in ("qacc_smooth", "qacc") if name in size)
            tolerance = unit * condition * largest
            if key != "qacc_smooth":
                tolerance += 4 * floor + unit * condition * constraint_force(a) / norm
        if key.startswith("step_"):
            floors = [abs(side[key.replace("step", "floor")]).max(initial=0.0) for side in (a, b)]
            floor = max(np.nan_to_num(floors, nan=np.inf))  # of a step that overflows
            tolerance = tolerance + unit * size[key] + 4 * floor  # a step is below 1 s
        yield key, tolerance

"""Points of curves of periodic orbits: their multipliers, and where two bifurcations meet."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ..scene import Array
from .bifurcations import DOUBLING, FOLD, KINDS, LINE, NEIMARK_SACKER
from .curve import cubic

BRANCH_POINT, HOMOCLINIC = "branch_point", "homoclinic"
"""Kinds of curves of states of rest alone, see `rest`."""


class ParameterWindow(NamedTuple):
    """Two parameters and their ranges."""

    names: tuple[str, str]
    low: Array
    high: Array

    def parameters(self, base: Any) -> Callable[[Array], Any]:
        """Return the map from places (2, k) in the window, 0 to 1 each, to parameters."""
        size = self.high - self.low

        def at(place: Array) -> Any:
            values = self.low[:, None] + size[:, None] * place
            return base.replace(**dict(zip(self.names, values, strict=True)))

        return at


@dataclass(frozen=True)
class CurvePoint:
    """A point of a curve.

    Attributes
    ----------
    z, tangent : array (2 n + 2,)
        Unknowns in their sizes, the place in the window last.
    multipliers : complex array (2 n,)
        Of the map that the orbit is closed by, descending in modulus.
    critical : complex
        That, or one of those, which the bifurcation is of; NaN on a line.
    others : complex array
        The others, that of a shift in time left out.
    bound : array (2,)
        On the error of the place, on the plane across the tangent.
    side : array (2,)
        See `stable_side`.
    """

    z: Array
    tangent: Array
    multipliers: Any
    critical: complex
    others: Any
    bound: Array
    side: Array = field(default_factory=lambda: np.full(2, np.nan))

    @property
    def unstable(self) -> int:
        """How many others lie outside the unit circle."""
        return int(np.sum(np.abs(self.others) > 1))

    @property
    def place(self) -> Array:
        """Place (2,) in the window."""
        return self.z[-2:]


@dataclass
class BifurcationCurve:
    """A curve of orbits: of a bifurcation, or along a line.

    Attributes
    ----------
    kind : str
    parts : int
        See `Family`.
    points : list of CurvePoint
    ends : (str, str)
        Why it begins and ends where it does.
    doubled : bool
        Whether bifurcations were found on orbits of twice the length that part from it.
    shifts : list of array (2,)
        Of an engine: by how far each point lies off the reference's curve.
    """

    kind: str
    parts: int
    points: list[CurvePoint] = field(default_factory=list)
    ends: tuple[str, str] = ("", "")
    doubled: bool = False
    shifts: list[Array] = field(default_factory=list)

    def distance(self, place: Array) -> float:
        """Return how far a place (2,) of the window is from the curve."""
        path = smooth_path(self.points)
        start, way = path[:-1], np.diff(path, axis=0)
        share = np.sum((place - start) * way, axis=1) / np.maximum(np.sum(way**2, axis=1), 1e-300)
        nearest = start + np.clip(share, 0, 1)[:, None] * way
        return float(np.min(np.linalg.norm(nearest - place, axis=1), initial=np.inf))


def smooth_path(points: Any, count: int = 8) -> Array:
    """Return places (m, 2) along points, cubic with so many pieces between two of them."""
    if not points:
        return np.empty((0, 2))
    z, tangents = (np.array([getattr(p, name) for p in points]) for name in ("z", "tangent"))
    return np.vstack([cubic(z, tangents, np.arange(count) / count), z[-1:]])[:, -2:]


def critical_pair(multipliers: Any) -> tuple[int, int]:
    """Return which two multipliers have a product nearest to 1."""
    off = np.abs(np.outer(multipliers, multipliers) - 1)
    off[np.tril_indices(len(off))] = np.inf
    i, j = np.unravel_index(np.argmin(off), off.shape)
    return int(i), int(j)


def split(kind: str, multipliers: Any, has_shift: bool) -> tuple[complex, Any]:
    """Return the critical multiplier and the others, that of a shift in time left out."""
    others = np.array(multipliers)
    if has_shift:
        others = np.delete(others, np.argmin(np.abs(others - 1)))
    if kind == LINE:
        return complex(np.nan), others
    if kind == HOMOCLINIC:  # that of the direction on which it leaves the saddle
        return complex(others[0]), others[1:]
    if kind == NEIMARK_SACKER:
        i, j = critical_pair(others)
        return complex(others[i]), np.delete(others, [i, j])
    i = int(np.argmin(np.abs(others - (-1 if kind == DOUBLING else 1))))
    return complex(others[i]), np.delete(others, i)


def crossings(others: Any) -> dict[str, float]:
    """Return numbers, by kind of bifurcation, whose signs change where multipliers cross."""
    i, j = np.triu_indices(len(others), 1)
    products = (others - 1, others + 1, others[i] * others[j] - 1)
    return {
        kind: float(np.real(np.prod(value))) for kind, value in zip(KINDS, products, strict=True)
    }


def pair_sum(point: CurvePoint) -> float:
    """Return 2 cos of the angle of the critical pair, or the sum of two that are real."""
    return float((point.critical + 1 / point.critical).real)


CODIMENSION_2: Mapping[str, Callable[[CurvePoint], float]] = {
    "resonance_1_1": lambda point: 2 - pair_sum(point),
    "resonance_1_2": lambda point: 2 + pair_sum(point),
    "with_fold": lambda point: crossings(point.others)[FOLD],
    "with_period_doubling": lambda point: crossings(point.others)[DOUBLING],
    "with_neimark_sacker": lambda point: crossings(point.others)[NEIMARK_SACKER],
}
"""Where a curve ends since another bifurcation comes in, by a function that is 0 there.

The first two are of a pair of multipliers, and positive while it is complex."""


def meets(kind: str, before: CurvePoint, here: CurvePoint) -> str | None:
    """Return which of them lies between two points of a curve, or None."""
    for why, value in CODIMENSION_2.items():
        if not concerns(why, kind):
            continue
        a, b = value(before), value(here)
        if a > 0 > b or (a < 0 < b and not why.startswith("resonance")):
            return why
    return None


def meeting_gap(kind: str, point: CurvePoint) -> float:
    """Return how far multipliers are from another bifurcation at a point of a curve of a kind.

    Distance of the others from the unit circle, or of a pair from each other.
    """
    own = [point.critical.imag] if kind == NEIMARK_SACKER else []
    return float(np.min(np.abs([*own, *(np.abs(point.others) - 1)]), initial=np.inf))


def concerns(why: str, kind: str) -> bool:
    """Return whether curves of a kind end so: two multipliers of a pair alone may meet."""
    return kind == NEIMARK_SACKER or not why.startswith("resonance")


def end_beyond(why: str, kind: str) -> str:
    """Return why the curve that begins where another of a kind ends has its own end there.

    One that a homoclinic orbit ends on goes on both ways.
    """
    if kind == HOMOCLINIC:
        return why
    beyond = kind_beyond(why, kind)
    if beyond != NEIMARK_SACKER or kind == NEIMARK_SACKER:
        return f"with_{beyond if why.startswith('resonance') else kind}"
    if why == f"with_{NEIMARK_SACKER}":
        return f"with_{kind}"
    return "resonance_1_2" if why == f"with_{DOUBLING}" else "resonance_1_1"


def kind_beyond(why: str, kind: str) -> str:
    """Return the kind of the curve that begins where another of a kind ends.

    Two multipliers that meet at 1 or -1 leave it as a pair.
    """
    if why.startswith("resonance"):
        return FOLD if why.endswith("1_1") else DOUBLING
    new = why.removeprefix("with_")
    return NEIMARK_SACKER if new == kind or kind == BRANCH_POINT else new

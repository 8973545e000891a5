"""The document of ``boundary``: curves of bifurcations, and where the others start."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

Kind = Literal[
    "fold",
    "period_doubling",
    "neimark_sacker",
    "symmetry_breaking",
    "hopf",
    "branch_point",
    "homoclinic",
]

Subject = Literal["orbits", "equilibria"]

End = Literal[
    "window", "closed", "with_fold", "with_period_doubling", "with_neimark_sacker", "symmetric",
    "neutral", "unstable", "lost", "points",
]  # fmt: skip


@dataclass(frozen=True)
class BoundaryAxis:
    """An axis of the window.

    Attributes
    ----------
    name : str
        parameter
    low : float
        lower end of the window
    high : float
        upper end
    unit : str
        unit
    """

    name: str
    low: float
    high: float
    unit: str


@dataclass(frozen=True)
class BoundaryPoint:
    """A point of a curve.

    Attributes
    ----------
    x : float
        of the first axis, in its unit
    y : float
        of the second
    x_bound : float
        bound on the error of `x` at this `y`, large where it is flat
    y_bound : float
        bound on the error of `y` at this `x`, large where it is steep
    x_bound_across : float
        bound on the error of `x` on the line across the curve
    y_bound_across : float
        the same of `y`
    state : mapping of str to float
        of the orbit where its period begins, angles not wrapped [SI]; the equilibrium, or the
        saddle of a homoclinic orbit
    period : float or None
        after which the orbit closes [s]; null for an equilibrium
    multipliers : tuple of complex
        of the map over the `parts` of the curve, descending in modulus, that of a shift too; those
        over half a period have the multipliers over a period as their squares
    eigenvalues : tuple of complex
        of the equations about an equilibrium [1/s], descending in their real parts
    critical : complex
        that of them, or one of the pair, which lies on the unit circle or the imaginary axis; that
        with which a homoclinic orbit leaves its saddle
    unstable : int
        how many others are unstable: 0 on a stability boundary
    direction : tuple of float
        unit tangent: states, `x` and `y`, in the sizes that they have
    stable_side : tuple of float  or None
        unit vector, `x` and `y` in the size of the window, to the side on which what loses its
        stability is stable; null for branch points and homoclinic orbits
    shift_x : float or None
        of an engine: by how far the curve lies from that of the reference at the same `y`, in the
        unit of `x`; null for the reference, and where that has no point near
    shift_y : float or None
        the same in `y`
    """

    x: float
    y: float
    x_bound: float
    y_bound: float
    x_bound_across: float
    y_bound_across: float
    state: Mapping[str, float]
    period: float | None
    multipliers: tuple[complex, ...]
    eigenvalues: tuple[complex, ...]
    critical: complex
    unstable: int
    direction: tuple[float, ...]
    stable_side: tuple[float, ...] | None
    shift_x: float | None
    shift_y: float | None


@dataclass(frozen=True)
class BoundaryPlace:
    """A place in the window.

    Attributes
    ----------
    x : float
        of the first axis, in its unit
    y : float
        of the second
    """

    x: float
    y: float


@dataclass(frozen=True)
class BoundaryCurve:
    """A curve of bifurcations.

    Attributes
    ----------
    of : Subject
        what loses its stability, or ends
    kind : Kind
        what happens to it there
    parts : int
        after how many periods the orbit closes, or half periods if the equations of the scene have
        that symmetry
    doubled : bool
        whether more was found on the orbits of twice the length that part there
    begins : End
        why a curve ends: `window`: it leaves it; `closed`; `with_...`: another bifurcation comes
        in, whose curve begins there, or the saddle of a homoclinic orbit vanishes; `symmetric`:
        the orbits become symmetric; `neutral`, `unstable`: what lies beyond bounds no stability;
        `lost`: no further point was found; `points`: there are too many
    ends : End
        the same of its end
    points : tuple of BoundaryPoint
        along the curve
    """

    of: Subject
    kind: Kind
    parts: int
    doubled: bool
    begins: End
    ends: End
    points: tuple[BoundaryPoint, ...]


@dataclass(frozen=True)
class BoundaryStart:
    """Start of a curve not yet followed.

    Attributes
    ----------
    of : Subject
        as of a curve
    kind : Kind
        as of a curve
    parts : int
        as of a curve
    point : BoundaryPoint
        where it is to be followed from
    unknowns : tuple of float
        the point in the unknowns that are solved for: a run goes on from just these
    begins : End or None
        why the curve ends there, if the point is on another that ends there, too
    """

    of: Subject
    kind: Kind
    parts: int
    point: BoundaryPoint
    unknowns: tuple[float, ...]
    begins: End | None


@dataclass(frozen=True)
class BoundaryDocument:
    """Curves of bifurcations, and the starts of those not yet followed.

    Attributes
    ----------
    method : str
        integrator, as the engine spells it
    step : float or None
        longest step in the window [s]; null for the reference
    steps_per_period : int or None
        the same all along a curve; null for the reference
    x : BoundaryAxis
        first axis
    y : BoundaryAxis
        second axis
    lines : int
        on which `x` stays: bifurcations are looked for along them
    near : tuple of BoundaryPlace
        places through which lines are looked along as well
    of : tuple of Subject
        what was followed along them
    lines_done : int
        of these, and of those through places, of all subjects together
    lines_done_of : mapping of Subject to int
        of these, for each subject
    orbits : int
        that were solved for by the reference, equilibria among them
    engine_orbits : int
        that were solved for by the engine
    curves : tuple of BoundaryCurve
        in the order in which they were followed
    pending : tuple of BoundaryStart
        starts of curves not yet followed; empty when all is done
    doublings : tuple of BoundaryStart
        where orbits of twice the length are still to be followed along lines
    missing : int
        bifurcations of the reference near which the engine has none
    """

    scene: str
    engine: str
    model: str
    method: str
    step: float | None
    steps_per_period: int | None
    parameters: Mapping[str, float | str]
    x: BoundaryAxis
    y: BoundaryAxis
    lines: int
    near: tuple[BoundaryPlace, ...]
    of: tuple[Subject, ...]
    lines_done: int
    lines_done_of: Mapping[Subject, int]
    orbits: int
    engine_orbits: int
    curves: tuple[BoundaryCurve, ...]
    pending: tuple[BoundaryStart, ...]
    doublings: tuple[BoundaryStart, ...]
    missing: int
    versions: Mapping[str, str]

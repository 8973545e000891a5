"""The scene `rotating_beam`: its models of the beam, and how many coordinates they have."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, lru_cache, partial
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.linalg import eigh

from ..linear import linearise
from ..scene import Array, Continuum, Paper, RunQuantities, Scene, case_maker, with_placements
from .equations import (
    Equations,
    Tip,
    exact,
    exact_potential,
    exact_tip,
    prepare_exact,
    prepare_truncated,
    stiffness,
    truncated,
    truncated_potential,
    truncated_tip,
)
from .frequencies.stretching import frequencies
from .hub import Terms, dot, hub_fields, of
from .parameters import (
    Coefficients,
    RotatingBeam,
    coefficients,
    constrained_initial_values,
    drive_end_time,
    period,
    reach,
    steady_speed,
)
from .shapes import Shapes, polynomials, prolongation

TIP_MASS = 0.4
"""[kg], the smallest of section 3.1: figures 4 and 5 do not name theirs."""

FIGURE_4 = RotatingBeam(mass=TIP_MASS)
FIGURE_5 = RotatingBeam(mass=TIP_MASS, drive="torque")
QUICK = FIGURE_4.replace(angular_speed=1.0, ramp_time=3.0, segments=12)
PULSE = FIGURE_5.replace(torque_amplitude=20.0, torque_period=1.5, segments=12)
STEADY = RotatingBeam(angular_speed=4.0, ramp_time=0.0)
ABOVE_CRITICAL = RotatingBeam(angular_speed=4.0, ramp_time=3.0, segments=8)


STEADY_CASES: Mapping[str, Mapping[str, Any]] = {
    "steady_at_rest": {"angular_speed": 0.0},
    "steady_4": {"angular_speed": steady_speed(4)},
    "steady_4_chain_b": {"angular_speed": steady_speed(4), "scheme": "B"},
    "steady_4_hub_radius": {"angular_speed": steady_speed(4), "hub_radius": 8.0},
    "steady_4_tip_mass": {"angular_speed": steady_speed(4), "mass": 1.6, "hub_radius": 1.0},
    "steady_4_geometrically_exact": {
        "angular_speed": steady_speed(4),
        "element": "geometrically_exact",
    },
    "steady_12": {"angular_speed": steady_speed(12), "segments": 24},
    "steady_12_chain_b": {"angular_speed": steady_speed(12), "segments": 24, "scheme": "B"},
}
"""Steady rotation by dimensionless speed; chains need 24 rods at 12 for asymptotic errors."""


TURNING = PULSE.replace(hub_radius=0.5, segments=8)
BENT = {
    "theta": 0.4,
    "theta_dot": 2.0566,
    "b_1": -0.019211,
    "b_2": -0.051338,
    "b_3": -0.072797,
    "b_4": -0.090474,
    "b_5": -0.10287,
    "b_6": -0.11001,
    "b_7": -0.11313,
    "b_8": -0.11414,
    "b_1_dot": -0.050977,
    "b_2_dot": -0.14061,
    "b_3_dot": -0.20361,
    "b_4_dot": -0.25695,
    "b_5_dot": -0.29581,
    "b_6_dot": -0.31933,
    "b_7_dot": -0.32985,
    "b_8_dot": -0.33326,
}
"""A straight beam at 1.8 rad/s after 0.5 s of the pulse: a start that shakes nothing in it."""

WEIGHED = TURNING.replace(gravity_x=3.0, gravity_y=-9.0)
HANGING = WEIGHED.replace(hub_radius=1.0, torque_amplitude=0.0)

case = case_maker("rotating_beam")

CASES = (
    case("spin_up_quick", QUICK, {}, 4.0, "algebra", "trajectory"),
    case("pulse_quick", PULSE, {}, 2.0, "trajectory", "energy", methods="best"),
    case("spin_up", FIGURE_4, {}, 17.0, "trajectory", full_only=True, methods="best"),
    case("pulse", FIGURE_5, {}, 12.0, "trajectory", full_only=True, methods="best"),
    case(
        "turning", TURNING, BENT, 1.0, "trajectory", start_time=0.5, full_only=True, methods="best"
    ),
    case("weighed", WEIGHED, {"theta": 0.4}, 0.125, "algebra", methods="best"),
    case(
        "hanging", HANGING, {}, 0.5, "frequency", about="hanging", watch="elements", full_only=True
    ),
    *(
        case(
            name,
            STEADY.replace(**changes),
            {},
            0.5,
            "frequency",
            "order",
            about="rotation",
            watch="elements",
        )
        for name, changes in STEADY_CASES.items()
    ),
    case("above_critical", ABOVE_CRITICAL, {}, 8.0, "stability", watch="outcome", methods="best"),
)
"""``spin_up`` and ``pulse`` are figures 4 and 5, the quick ones bend the beam as far in less time.
``above_critical`` turns faster than the zero-order model can stand, `critical_speed`."""


RUN_UNITS = {"tip_peak": "m", "tip_peak_time": "s", "tip_rms_after": "m"}


def run_quantities(
    times: Any, values: Mapping[str, Any], p: RotatingBeam
) -> dict[str, tuple[float, float]]:
    """Largest deflection of the tip, its time, and the RMS value once nothing drives the hub.

    Between samples by cubics that have their rates. An error of the rate shifts the time of the
    peak by its share of the acceleration there.
    """
    tip = CubicHermiteSpline(times, values["tip_deflection"], values["tip_deflection_dot"])
    inner = tip.derivative().roots(extrapolate=False)
    at = np.concatenate([inner, [times[0], times[-1]]])
    peak = float(at[np.argmax(np.abs(tip(at)))])
    after = np.asarray(times) >= drive_end_time(p)
    rest = values["tip_deflection"][after] if np.any(after) else np.zeros(1)
    return {
        "tip_peak": (float(tip(peak)), 1.0),
        "tip_peak_time": (peak, 1 / max(abs(float(tip(peak, 2))), 1e-12)),
        "tip_rms_after": (float(np.sqrt(np.mean(rest**2))), 1.0),
    }


def outcome(times: Any, values: Mapping[str, Any], p: RotatingBeam) -> str:
    """Tell whether the deflection stays bounded.

    The first that holds of:

    1. *diverges*: the tip is farther beside the axis than the beam is long.
    2. *undecided*: a value is not finite; after the drive's end the run lasts less than
       `WATCH` times `period`.
    3. *diverges*: in the last third of that time the deflection swings `RISE` times as far
       as in the first. A vibration that goes on does not: nothing damps it, nothing drives it.
    4. *bounded*: all others.
    """
    t, tip = np.asarray(times, dtype=float), np.asarray(values["tip_deflection"], dtype=float)
    if np.any(np.abs(tip) > p.length * BEYOND):
        return "diverges"
    rest = t - (p.ramp_time if p.drive == "prescribed" else p.torque_period)
    if not (len(t) and np.all(np.isfinite(tip)) and rest[-1] >= WATCH * period(p)):
        return "undecided"
    first, last = (
        np.max(np.abs(tip[(rest >= start * rest[-1]) & (rest <= end * rest[-1])]), initial=0.0)
        for start, end in ((0, 1 / 3), (2 / 3, 1))
    )
    return "diverges" if last > RISE * first else "bounded"


WATCH = 2.0

BEYOND = 1.1
"""Tip's deflection over the length; no inextensible beam has more than 1."""

RISE = 3.0
"""Share of the first by which the last deflections may be larger: beats of two modes."""


PAPER = Paper(
    "Y. Yang, Y. Wang, H. Chen, M. Wu",
    "Dynamic Modeling and Response of a Rotating Cantilever Beam with a Concentrated Mass",
    "Shock and Vibration 2016, 8935247",
    2016,
    "10.1155/2016/8935247",
)


def spectrum(continuum: str, p: RotatingBeam, plane: str, count: int) -> tuple[Array, Array]:
    """Frequencies (count,) [rad/s] of a continuum that rotates steadily, and their bounds."""
    modes = frequencies(p, plane, count, continuum)
    return modes.omega, modes.bound


class Theory(NamedTuple):
    """Functions of one model of the beam.

    Attributes
    ----------
    potential : Callable[[Any, Any], Any]
        Of gravity.
    continuum : str | None
        Whose frequencies are known, see `frequencies.stretching`.
    tolerances : tuple[float, float]
        Of `solve`; waves along the beam, which no one sees, would cost much more.
    """

    title: str
    prepare: Callable[[Shapes, Coefficients], Any]
    equations: Callable[[Any, Any, Any], Equations]
    potential: Callable[[Any, Any], Any]
    tip: Callable[[Any, Any, Shapes], Tip]
    continuum: str | None = None
    tolerances: tuple[float, float] = (1e-11, 3e-12)


THEORIES = {
    "inextensible": Theory(
        "exact, inextensible", prepare_exact, exact, exact_potential, exact_tip, "inextensible"
    ),
    "extensible": Theory(
        "exact, extensible",
        prepare_exact,
        exact,
        exact_potential,
        exact_tip,
        "extensible",
        (1e-8, 1e-6),
    ),
    "second_order": Theory(
        "small deflection, the paper's, corrected",
        prepare_truncated,
        truncated,
        truncated_potential,
        truncated_tip,
    ),
    "zero_order": Theory(
        "small deflection without foreshortening",
        partial(prepare_truncated, foreshortening=False),
        truncated,
        truncated_potential,
        partial(truncated_tip, foreshortening=False),
    ),
}


@cache
def beam_scene(
    theory: str = "inextensible",
    n: int = 10,
    k: int = 0,
    shapes: Callable[[int, int, float], Shapes] = polynomials,
) -> Scene:
    """Return the scene with n bending and k stretching coordinates; one object for each.

    Parameters
    ----------
    theory : str
        Of `THEORIES`.
    n, k : int
    shapes : callable
        `polynomials`, or the `cantilever_modes` of the paper.
    """
    about = THEORIES[theory]

    @lru_cache(maxsize=64)
    def prepared(c: Coefficients) -> tuple[Shapes, Any, Any]:
        """Return shapes, what the theory needs of them, and the stiffness matrix."""
        at = shapes(n, k, float(c.place))
        return at, about.prepare(at, c), stiffness(at, c)

    def terms(q: Any, v: Any, c: Coefficients) -> Terms:
        """Mass matrix and forces of the free hub with its beam."""
        _, beam, matrix = prepared(c)
        mass, inertia = about.equations(q, v, beam)
        return Terms(mass, -inertia - of(matrix, q))

    def potential(q: Any, c: Coefficients) -> Any:
        """Strain energy and potential energy of gravity [J]."""
        _, beam, matrix = prepared(c)
        return dot(q, of(matrix, q)) / 2 + about.potential(q, beam)

    def tip(q: Any, v: Any, c: Coefficients) -> Tip:
        """Tip's displacement over L and its rate in the hub frame."""
        return about.tip(q, v, prepared(c)[0])

    bends = tuple(f"b_{i}" for i in range(1, n + 1))
    stretches = tuple(f"e_{i}" for i in range(1, k + 1))
    internal = dict.fromkeys(bends, "rad") | dict.fromkeys(stretches, "1")
    return Scene(
        **hub_fields(terms, potential, tip, internal),
        title=f"hub with a flexible beam and a concentrated mass ({about.title})",
        paper=PAPER,
        constrained_initial_values=constrained_initial_values,
        run_quantities=RunQuantities(run_quantities, RUN_UNITS),
        outcome=outcome,
        stiff=about.tolerances,
        continuum=Continuum(
            bends + stretches,
            partial(spectrum, about.continuum) if about.continuum else None,
            reach=reach,
        ),
        cases=CASES,
    )


def critical_speed(p: RotatingBeam) -> float:
    """Speed [rad/s] above which the zero-order model has no stable rotation.

    There its ``K - theta'^2 M`` of bending loses its definiteness: at the first natural
    frequency of the beam with its mass at rest, whatever the hub radius.
    """
    mass, _, k = linearise(ZERO_ORDER, p, ZERO_ORDER.state({}))
    bends = slice(1, BENDING + 1)
    return float(np.sqrt(eigh(k[bends, bends], mass[bends, bends], eigvals_only=True)[0]))


BENDING, STRETCHING = 8, 3
"""Coordinates of the reference: 10 bending ones change the tip of figure 4 by 4e-7 m, 2e-7 of
its deflection."""


def embedding(more: int, p: RotatingBeam, state: Mapping[str, float]) -> Mapping[str, float]:
    """Return the state of the reference's coordinates in so many bending ones: the same shape."""
    shape = dict(state)
    place = float(coefficients(p).place)
    for end in ("", "_dot"):
        values = np.array([state.get(f"b_{i}{end}", 0.0) for i in range(1, BENDING + 1)])
        if np.any(values):
            others = prolongation(BENDING, more, place) @ values
            shape |= {f"b_{i}{end}": float(b) for i, b in enumerate(others, 1)}
    return shape


def with_refinement(theory: str, k: int, times: int = 2) -> Scene:
    """Return a model of the beam, beside it the same with more coordinates, and so on."""
    n = BENDING + 2 * (2 - times)
    beam = beam_scene(theory, n, k)
    if not times:
        return beam
    refined = with_refinement(theory, k and k + 1, times - 1)
    refined = replace(refined, embedding=partial(embedding, n + 2))
    return replace(beam, continuum=replace(beam.continuum, refined=refined))


EXTENSIBLE, SECOND_ORDER, ZERO_ORDER = (
    with_refinement(theory, STRETCHING) for theory in ("extensible", "second_order", "zero_order")
)
SCENE = replace(
    with_refinement("inextensible", 0),
    placed=with_placements(
        CASES[0], "algebra", "step"
    ),  # of its motion the other kinds say as much
    drive_form="prescribed: theta'' = omega_0 / T (1 - cos(2 pi t / T)), (22), T the ramp_time; "
    "torque on the hub: tau_0 sin(2 pi t / T), (23), T the torque_period; either until t = T",
    variants={"extensible": EXTENSIBLE, "second_order": SECOND_ORDER, "zero_order": ZERO_ORDER},
)

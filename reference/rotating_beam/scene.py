"""The scene `rotating_beam`: its models of the beam, and how many coordinates they have."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, lru_cache, partial
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import eigh

from ..linear import linearise
from ..scene import Array, Continuum, Paper, RunQuantities, Scene, with_placements
from .cases import CASES
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
from .frequencies.continua import frequencies
from .hub import Terms, dot, hub_fields, of
from .outcome import RUN_UNITS, outcome, run_quantities
from .parameters import (
    Coefficients,
    RotatingBeam,
    coefficients,
    constrained_initial_values,
    reach,
)
from .shapes import Shapes, polynomials, prolongation

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
    """What one model of the beam is made of."""

    title: str
    prepare: Callable[[Shapes, Coefficients], Any]
    equations: Callable[[Any, Any, Any], Equations]
    potential: Callable[[Any, Any], Any]
    """Of gravity"""
    tip: Callable[[Any, Any, Shapes], Tip]
    continuum: str | None = None
    """Whose frequencies are known, see `frequencies.continua`"""
    tolerances: tuple[float, float] = (1e-11, 3e-12)
    """Of `solve`; waves along the beam, which no one sees, would cost much more"""


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

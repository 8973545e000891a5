"""The scene `rotating_beam`: its models of the beam, and how many coordinates they have."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, lru_cache, partial
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import eigh
from scipy.linalg.lapack import dgesv

from ..linear import linearise
from ..scene import Array, Continuum, Paper, RunQuantities, Scene, with_placements, with_rates
from .cases import CASES
from .equations import (
    OUTPUTS,
    Equations,
    Tip,
    dot,
    exact,
    exact_potential,
    exact_tip,
    of,
    prepare_exact,
    prepare_truncated,
    stiffness,
    truncated,
    truncated_potential,
    truncated_tip,
)
from .frequencies.continua import frequencies
from .outcome import RUN_UNITS, outcome, run_quantities
from .parameters import (
    EQUILIBRIA,
    Coefficients,
    RotatingBeam,
    coefficients,
    conserved,
    constrained_initial_values,
    drive,
    drive_end_time,
    period,
    reach,
    unforced,
)
from .shapes import Shapes, polynomials, prolongation, shapes_of

UNITS = with_rates(theta="rad", tip_deflection="m", tip_axial="m")

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


class Prepared(NamedTuple):
    """What does not change with the state."""

    c: Coefficients
    shapes: Shapes
    theory: Any
    stiffness: Any


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

    def prepare(c: Coefficients) -> Prepared:
        """Return what does not change with the state."""
        at = shapes_of(c.place, n, k, shapes)
        return Prepared(c, at, about.prepare(at, c), stiffness(at, c))

    prepare_one = lru_cache(64)(prepare)

    def prepared(c: Coefficients, axes: int) -> Prepared:
        """Return it for one set of numbers, or for arrays beside states of so many axes."""
        try:
            return prepare_one(c)
        except TypeError:  # arrays
            return prepare(Coefficients(*(lifted(value, axes - 1) for value in c)))

    def equations(u: Any, q: Any, v: Any, c: Coefficients) -> tuple[Any, Any, Equations]:
        """M and f with the hub's row as its drive has it, and `Equations`.

        Where the hub is prescribed, its row and column are those of the identity, and what its
        acceleration does to the others is part of f.
        """
        q, v = np.asarray(q).T, np.asarray(v).T
        beam = prepared(c, q.ndim)
        terms = about.equations(q, v, beam.theory)
        load = -terms.inertia - of(beam.stiffness, q)
        u, free = lifted(u, q.ndim - 1), np.asarray(1 - beam.c.prescribed)
        load -= np.asarray(u * beam.c.prescribed)[..., None] * terms.mass[..., 0]
        load[..., 0] = u + free * load[..., 0]
        mass = terms.mass.copy()
        mass[..., 0, :] *= free[..., None]
        mass[..., 1:, 0] *= free[..., None]
        mass[..., 0, 0] += beam.c.prescribed
        return mass, load, terms

    def mass_matrix(q: Any, c: Coefficients, xp: Any = np) -> Any:
        """M; the hub's row and column are those of the identity where it is prescribed."""
        mass, _, _ = equations(0.0, q, np.zeros_like(q), c)
        return mass.swapaxes(-1, -2).T

    def forces(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> Any:
        """Forces less the velocity-dependent inertia terms."""
        _, load, _ = equations(u, q, v, c)
        return load.T

    def accelerations(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> Any:
        """Solution of ``M a = forces``."""
        mass, load, _ = equations(u, q, v, c)
        if load.ndim == 1 and load.dtype == float:
            _, _, solution, failed = dgesv(mass, load)
            return solution if not failed else np.full_like(load, np.nan)
        return np.linalg.solve(mass, load[..., None])[..., 0].T

    def energy(q: Any, v: Any, c: Coefficients) -> Any:
        """Kinetic energy, strain energy and potential energy of gravity [J]."""
        q, v = np.asarray(q).T, np.asarray(v).T
        beam = prepared(c, q.ndim)
        mass = about.equations(q, v, beam.theory).mass
        inner = (dot(v, of(mass, v)) + dot(q, of(beam.stiffness, q))) / 2
        return (inner + about.potential(q, beam.theory)).T

    def momentum(q: Any, v: Any, c: Coefficients) -> Any:
        """Angular momentum of hub, beam and mass about the axis [kg m^2/s]."""
        q, v = np.asarray(q).T, np.asarray(v).T
        return dot(about.equations(q, v, prepared(c, q.ndim).theory).mass[..., 0, :], v).T

    def powers(u: Any, q: Any, v: Any, c: Coefficients) -> dict[str, Any]:
        """Power [W] of the torque on the hub: the given one, or what its motion takes."""
        mass, load, terms = equations(u, q, v, c)
        a = np.linalg.solve(mass, load[..., None])[..., 0]
        taken = (dot(terms.mass[..., 0, :], a) + terms.inertia[..., 0]).T
        return {"hub": (c.prescribed * taken + (1 - c.prescribed) * u) * v[0]}

    def outputs(q: Any, v: Any, c: Coefficients, xp: Any = np) -> dict[str, Any]:
        """Tip's displacement in the hub frame."""
        q, v = np.asarray(q).T, np.asarray(v).T
        tip = about.tip(q, v, prepared(c, q.ndim).shapes)
        return {name: c.length * value.T for name, value in zip(OUTPUTS, tip, strict=True)}

    def invariants(p: RotatingBeam) -> Mapping[str, Callable[..., Any]]:
        """What a beam keeps that nothing drives."""
        return conserved(p, energy, momentum)

    bends = tuple(f"b_{i}" for i in range(1, n + 1))
    stretches = tuple(f"e_{i}" for i in range(1, k + 1))
    internal = dict.fromkeys(bends, "rad") | dict.fromkeys(stretches, "1")
    return Scene(
        name="rotating_beam",
        title=f"hub with a flexible beam and a concentrated mass ({about.title})",
        paper=PAPER,
        parameters=RotatingBeam,
        coordinates=("theta", *bends, *stretches),
        units=UNITS | with_rates(**internal),
        coefficients=coefficients,
        drive=drive,
        mass_matrix=mass_matrix,
        forces=forces,
        accelerations=accelerations,
        damping_matrix=lambda c: np.zeros((1 + n + k, 1 + n + k)),
        energy=energy,
        powers=powers,
        equilibria=EQUILIBRIA,
        steady_coordinates=dict.fromkeys(EQUILIBRIA, ("theta",)),
        rotations_per_period={"theta": 1},
        period=period,
        unforced=unforced,
        constrained_initial_values=constrained_initial_values,
        outputs=outputs,
        observed=OUTPUTS[:3],
        invariants=invariants,
        run_quantities=RunQuantities(run_quantities, RUN_UNITS),
        outcome=outcome,
        stiff=about.tolerances,
        drive_end_time=drive_end_time,
        continuum=Continuum(
            bends + stretches,
            partial(spectrum, about.continuum) if about.continuum else None,
            reach=reach,
        ),
        cases=CASES,
    )


def lifted(value: Any, axes: int) -> Any:
    """A coefficient over points with their axes turned as those of the states, and as many."""
    if np.ndim(value) == 0:
        return value
    coefficient = np.asarray(value).T
    return coefficient.reshape(*coefficient.shape, *(1,) * (axes - coefficient.ndim))


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

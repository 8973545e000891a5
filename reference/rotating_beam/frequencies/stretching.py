"""Frequencies of a `rotating_beam` that stretches, in steady rotation, or hanging."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import block_diag, cholesky, eigh, solve_triangular

from ...errors import ParameterError, UnknownNameError
from ...scene import Array
from ..parameters import RotatingBeam
from .numbers import NaturalModes, Numbers, check, numbers, time_unit
from .ritz import at_mass, basis, converged, element_ends, gauss, gram, ritz


class Stretched(NamedTuple):
    """A beam that stretches in steady motion, at places: y = (a + X)/L, and N L^2/EI."""

    y: Array
    force: Array


def steady_state(n: Numbers, slenderness: float) -> Callable[[Array, Any], Stretched]:
    """Return ``(places, element numbers) -> Stretched``: ``y'' = -(gamma^2 y + weight)/s``.

    Parameters
    ----------
    n : Numbers
    slenderness : float
        s, EA L^2 / EI.

    Raises
    ------
    ParameterError
        If the beam is torn apart.
    """
    if n.weight:
        return hanging_state(n, slenderness)
    k = n.gamma / np.sqrt(slenderness)

    def sine(x: Any) -> Any:
        """sin(k x)/k."""
        return x * np.sinc(k * x / np.pi)

    # y = delta cos k x + b sin(k x)/k, less jump sin(k (x - beta))/k beyond the mass
    # where y' jumps by alpha k^2 y(beta); and y' = 1 at the end, beyond the mass
    beyond, square = np.cos(k * (1 - n.beta)), k**2
    per_b = np.cos(k) - n.alpha * square * sine(n.beta) * beyond
    if k >= np.pi / 2 or per_b <= 0:
        raise ParameterError("at this speed the beam stretches without end: EA is too small")
    at_mass = n.delta * np.cos(k * n.beta)
    b = (1 + n.delta * square * sine(1.0) + n.alpha * square * at_mass * beyond) / per_b
    at_mass += b * sine(n.beta)
    jump = n.alpha * square * at_mass

    def integral(x: Any, past: Any) -> Any:
        """Integral of y from 0 to x."""
        return n.delta * sine(x) + (b * sine(x / 2) ** 2 - jump * sine(past / 2) ** 2) * 2

    whole = integral(1.0, 1 - n.beta)

    def at(x: Array, element: Any) -> Stretched:
        beyond_mass = (element > 0) | (n.beta == 0)
        past = (x - n.beta) * beyond_mass
        force = whole - integral(x, past) + n.alpha * at_mass * ~beyond_mass
        y = n.delta * np.cos(k * x) + b * sine(x) - jump * sine(past)
        return Stretched(y, n.gamma**2 * force)

    return at


def hanging_state(n: Numbers, slenderness: float) -> Callable[[Array, Any], Stretched]:
    """Return the same of a beam at rest that its own weight and that of its mass stretch."""

    def at(x: Array, element: Any) -> Stretched:
        above = ~((element > 0) | (n.beta == 0))
        force = n.weight * (1 - x + n.alpha * above)
        stretch = x - x**2 / 2 + n.alpha * np.minimum(x, n.beta)
        return Stretched(n.delta + x + n.weight / slenderness * stretch, force)

    return at


def gyroscopic_frequencies(mass: Array, gyroscopic: Array, stiffness: Array, count: int) -> Array:
    """Lowest frequencies (count,) of ``M a + G v + K q = 0``, G skew.

    With M and K positive definite all are real; they are found as 1/omega of a Hermitian
    matrix, so that the lowest are the best determined.
    """
    k, m = cholesky(stiffness, lower=True), cholesky(mass, lower=True)
    w = solve_triangular(k, m, lower=True)
    g = solve_triangular(k, solve_triangular(k, gyroscopic, lower=True).T, lower=True).T
    size = len(mass)
    matrix = 1j * np.block([[-g, -w], [w.T, np.zeros((size, size))]])
    ends = (2 * size - count, 2 * size - 1)
    return np.asarray(1 / eigh(matrix, eigvals_only=True, subset_by_index=ends)[::-1])


def stretching(
    n: Numbers,
    slenderness: float,
    plane: str = "chordwise",
    count: int = 2,
    shear: float | None = None,
    rotary: float = 0.0,
) -> NaturalModes:
    """Frequencies of a beam that stretches, about its stretched state.

    Parameters
    ----------
    n : Numbers
    slenderness : float
        EA L^2 / EI.
    plane : {"chordwise", "flapwise"}
    count : int
    shear : float, optional
        k G A L^2 / EI; chordwise only. Without it, cross-sections stay normal.
    rotary : float
        I/(A L^2) of the cross-section, with ``shear`` only.
    """
    check(n, plane, count)
    if shear is not None and plane != "chordwise":
        raise ParameterError("the shear-flexible beam is solved in the plane of rotation only")
    ends = element_ends(n)
    state = steady_state(n, slenderness)
    number = np.arange(len(ends) - 1)
    square = n.gamma**2
    before, behind = (1 + state(ends[1:-1], number[:-1] + i).force / slenderness for i in (0, 1))
    times = 2 if shear is None else 1

    def solve(degree: int) -> Array:
        points = gauss(degree + 12)  # what is integrated is no polynomial
        v = basis(ends, degree, *points, times, behind / before)
        y, force = state(v.x, np.repeat(number, len(points[0])))
        steady = 1 + force / slenderness
        deflection_of_mass = at_mass(n, ends, degree, times)
        mass = gram(v.value, v.weight) + np.outer(deflection_of_mass, deflection_of_mass)
        spin = np.zeros_like(mass)
        if shear is None:  # the angle is v' over the stretch
            twist = v.curvature + v.slope * ((square * y + n.weight) / slenderness / steady)
            lateral = gram(twist, v.weight / steady**2) + gram(v.slope, v.weight * force / steady)
        else:  # the angle has the same basis as v
            shearing = gram(v.slope, shear * v.weight)
            mixed = gram(v.slope, v.weight * (force - shear * steady), v.value)
            angle = gram(v.slope, v.weight)
            angle += gram(v.value, v.weight * steady * (shear * steady - force))
            spin = rotary * gram(v.value, v.weight)
            lateral = np.block([[shearing, mixed], [mixed.T, angle]])
        if plane == "flapwise":
            inverse = eigh(mass, lateral, eigvals_only=True)
            return np.asarray(1 / np.sqrt(inverse[::-1][:count]))
        size = len(mass)
        lateral[:size, :size] -= square * mass
        if shear is not None and rotary == 0:  # the angle follows v at once
            follows = np.linalg.solve(lateral[size:, size:], lateral[size:, :size])
            lateral = lateral[:size, :size] - lateral[:size, size:] @ follows
        elif shear is not None:
            mass = block_diag(mass, spin)
        u = basis(ends, degree, *points, 1)
        carried = at_mass(n, ends, degree, 1)
        axial_mass = gram(u.value, u.weight) + np.outer(carried, carried)
        axial = gram(u.slope, slenderness * u.weight) - square * axial_mass
        turn = np.zeros((len(mass), len(axial)))
        turn[:size] = (
            2 * n.gamma * (gram(v.value, u.weight, u.value) + np.outer(deflection_of_mass, carried))
        )
        skew = block_diag(np.zeros_like(axial), np.zeros_like(mass))
        skew[len(axial) :, : len(axial)], skew[: len(axial), len(axial) :] = turn, -turn.T
        return gyroscopic_frequencies(
            block_diag(axial_mass, mass), skew, block_diag(axial, lateral), count
        )

    stiffest = 10 + (shear or 0.0) / 50  # as springs in series, it costs digits
    return converged(solve, count, lambda omega: stiffest * (1 + square / omega**2))


CONTINUA = ("inextensible", "extensible", "shear_flexible")


def frequencies(
    p: RotatingBeam,
    plane: str = "chordwise",
    count: int = 2,
    continuum: str = "inextensible",
    shear_stiffness: float | None = None,
    rotary_inertia: bool = False,
) -> NaturalModes:
    """Lowest natural frequencies [rad/s] of the beam that rotates at ``angular_speed``.

    Parameters
    ----------
    p : RotatingBeam
    plane : {"chordwise", "flapwise"}
        In the plane of rotation (the hub's speed prescribed), or out of it.
    count : int
    continuum : {"inextensible", "extensible", "shear_flexible"}
        The last one chordwise only.
    shear_stiffness : float, optional
        k G A [N] of the shear-flexible beam.
    rotary_inertia : bool
        Of the shear-flexible beam's cross-sections.
    """
    if continuum not in CONTINUA:
        raise UnknownNameError("continuum", continuum, CONTINUA)
    n, unit = numbers(p), time_unit(p)
    if continuum == "inextensible":
        modes = ritz(n, plane, count)
    else:
        section = p.second_moment / (p.area * p.length**2)
        if continuum == "extensible":
            modes = stretching(n, 1 / section, plane, count)
        elif shear_stiffness is None:
            raise ParameterError("the shear-flexible beam needs its shear_stiffness (k G A)")
        else:
            shear = shear_stiffness * p.length**2 / (p.youngs_modulus * p.second_moment)
            rotary = section if rotary_inertia else 0.0
            modes = stretching(n, 1 / section, plane, count, shear, rotary)
    return NaturalModes(modes.omega / unit, modes.bound / unit)

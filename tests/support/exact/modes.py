"""Eigenvalues about a state of rest in many digits, from energies as the papers draw them.

Kinetic energy is that of points and of homogeneous rods; nothing of the modules' equations is used.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import mpmath
from mpmath import mp

DIGITS = 80


class Rest(NamedTuple):
    """A state of rest: kinetic energy of speeds, dampings and stiffnesses."""

    kinetic: Callable[[Sequence[Any]], Any]
    damping: Sequence[Any]
    stiffness: Sequence[Any]


def exact(p: Any) -> Any:
    """Return a namespace of the parameters in many digits; words stay."""
    values = p.as_dict()
    return type("Exact", (), {k: v if isinstance(v, str) else mp.mpf(v) for k, v in values.items()})


def squares(*parts: Any) -> Any:
    return mp.fsum(part**2 for part in parts)


def hula_hoop(p: Any, about: str) -> Rest:
    p = exact(p)
    sin, cos = (1, 0) if about == "rod_aligned" else (0, 1)
    natural = mp.sqrt(p.stiffness / (p.main_mass + p.free_mass))

    def kinetic(v: Sequence[Any]) -> Any:
        free = squares(v[0] + p.rod_length * cos * v[1], p.rod_length * sin * v[1])
        spin = p.inertia_ratio * (p.rod_length * v[1]) ** 2
        return (p.main_mass * v[0] ** 2 + p.free_mass * (free + spin)) / 2

    hinge = p.hinge_damping_ratio * p.free_mass * p.rod_length**2 * natural
    slide = 2 * p.damping_ratio * (p.main_mass + p.free_mass) * natural
    return Rest(kinetic, (slide, hinge), (p.stiffness, mp.mpf(0)))


def rotor_pendulum(p: Any, about: str) -> Rest:
    p = exact(p)
    sin, cos = mp.sin(p.installation_angle), mp.cos(p.installation_angle)

    def kinetic(v: Sequence[Any]) -> Any:
        x, first, second, rod = v if len(v) == 4 else (v[0], 0, 0, v[1])
        end = x - p.rod_length * sin * rod, p.rod_length * cos * rod
        bodies = (
            (p.platform_mass, x, 0),
            (p.rotor_mass, x, p.eccentricity * first),  # the arms point along x
            (p.rotor_mass, end[0], end[1] + p.eccentricity * second),
            (p.rod_mass, *end),
        )
        return mp.fsum(mass * squares(*speeds) for mass, *speeds in bodies) / 2

    still = (mp.mpf(0),) * (2 if about == "rest" else 0)
    return Rest(
        kinetic,
        (p.platform_damping, *still, p.rod_damping),
        (p.platform_stiffness, *still, p.rod_stiffness),
    )


def speed_regulator(p: Any, about: str, near: float) -> Rest:
    p = exact(p)
    r, l = p.crank_radius, p.rod_length

    def slider(phi: Any) -> tuple[Any, Any, Any]:
        """y and two derivatives, by hand."""
        h = mp.sqrt(l**2 - (r * mp.cos(phi)) ** 2)
        slope = r**2 * mp.sin(phi) * mp.cos(phi) / h
        bend = r**2 * (mp.cos(2 * phi) - (slope / r) ** 2) / h
        return r * mp.sin(phi) - h, r * mp.cos(phi) - slope, -r * mp.sin(phi) - bend

    def torque(phi: Any) -> Any:
        y, slope, _ = slider(phi)
        return p.stiffness * slope * (y - p.spring_rest) - p.torque

    phi = mpmath.findroot(torque, mp.mpf(near), tol=mp.mpf(10) ** (-1.5 * DIGITS), verify=False)
    y, slope, bend = slider(phi)

    def kinetic(v: Sequence[Any]) -> Any:
        pin = -r * mp.sin(phi) * v[0], r * mp.cos(phi) * v[0]
        end = slope * v[0]
        rod = squares(*pin) + pin[1] * end + end**2
        return (
            p.flywheel_inertia * v[0] ** 2 / 2 + p.rod_mass * rod / 6 + p.slider_mass * end**2 / 2
        )

    return Rest(
        kinetic,
        (p.damping * slope**2,),
        (p.stiffness * (bend * (y - p.spring_rest) + slope**2),),
    )


def eigenvalues(rest: Rest, damped: bool = True) -> list[Any]:
    """Return all eigenvalues that are not zero, from the characteristic polynomial."""
    size = len(rest.damping)
    unit = [[mp.mpf(int(i == j)) for j in range(size)] for i in range(size)]

    def both(i: int, j: int) -> Any:
        """Return an entry of the mass matrix."""
        together = [a + b for a, b in zip(unit[i], unit[j], strict=True)]
        return rest.kinetic(together) - rest.kinetic(unit[i]) - rest.kinetic(unit[j])

    mass = [[both(i, j) for j in range(size)] for i in range(size)]

    def entry(i: int, j: int) -> list[Any]:
        if i != j:
            return [mp.mpf(0), mp.mpf(0), mass[i][j]]
        return [rest.stiffness[i], rest.damping[i] * damped, mass[i][i]]

    terms = determinant([[entry(i, j) for j in range(size)] for i in range(size)])
    lowest = next(k for k, term in enumerate(terms) if term)
    terms = terms[lowest:]
    degree = len(terms) - 1
    if not degree:
        return []
    unit_rate = abs(terms[0] / terms[-1]) ** (mp.mpf(1) / degree)
    scaled = [term * unit_rate**k for k, term in enumerate(terms)]
    scaled = [term / scaled[-1] for term in scaled]
    roots = mpmath.polyroots(scaled[::-1], maxsteps=2000, extraprec=40 * DIGITS)
    return [unit_rate * root for root in roots]


def determinant(matrix: list[list[list[Any]]]) -> list[Any]:
    """Return the determinant of a matrix of polynomials, ascending, along its first row."""
    if not matrix:
        return [mp.mpf(1)]
    total = [mp.mpf(0)] * (2 * len(matrix) + 1)
    for j, factor in enumerate(matrix[0]):
        minor = determinant([row[:j] + row[j + 1 :] for row in matrix[1:]])
        for a, one in enumerate(factor):
            for b, other in enumerate(minor):
                total[a + b] += (-1) ** j * one * other
    return total

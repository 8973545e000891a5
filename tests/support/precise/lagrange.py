"""Equations of motion from positions and energies alone, by SymPy."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

import sympy as sp

from mbcheck.tests.support.precise.program import Program, compile_expressions


class Mechanism(NamedTuple):
    """A mechanical system: its coordinates, energies and loads.

    Attributes
    ----------
    time, q, v : sympy symbols
    masses : list of (mass, position)
        Point masses, a position being a list of expressions in q.
    turning : list of (moment of inertia, angle)
    potential : expression
    loads : list of expressions
        Generalised forces beside those of the potential.
    """

    time: Any
    q: tuple[Any, ...]
    v: tuple[Any, ...]
    masses: list[tuple[Any, list[Any]]]
    turning: list[tuple[Any, Any]]
    potential: Any
    loads: list[Any]


def mass_and_load(system: Mechanism) -> tuple[Any, Any]:
    """Return M and f of ``M(q) a = f(t, q, v)`` by Lagrange's equations of the second kind."""
    q, v = system.q, system.v

    def rate(value: Any) -> Any:
        return sum(value.diff(x) * speed for x, speed in zip(q, v, strict=True))

    kinetic = sum(m / 2 * sum(rate(x) ** 2 for x in at) for m, at in system.masses)
    kinetic += sum(j / 2 * rate(angle) ** 2 for j, angle in system.turning)
    lagrangian = kinetic - system.potential
    momenta = [lagrangian.diff(speed) for speed in v]
    mass = [[tidy(p.diff(speed)) for speed in v] for p in momenta]
    load = [
        tidy(lagrangian.diff(x) - rate(p)) + Q
        for x, p, Q in zip(q, momenta, system.loads, strict=True)
    ]
    return mass, load


def tidy(expression: Any) -> Any:
    """Return an expression with squares of sine and cosine of one angle added up."""
    return sp.trigsimp(sp.expand(expression))


def symbols_of(names: str) -> tuple[Any, ...]:
    """Return positive parameters by name."""
    return tuple(sp.Symbol(name, real=True) for name in names.split())


def hula_hoop() -> Mechanism:
    """Return a main mass that slides along y, and a free mass on a rod hinged to it.

    Lu, Wang, Sung, Chao (2011): the dampers by rho and zeta_m of (7), (8).
    """
    t, y, theta, y_dot, theta_dot = sp.symbols("t y theta y_dot theta_dot", real=True)
    main, free, rod, k, rho, zeta, ratio, force, hertz = symbols_of(
        "main_mass free_mass rod_length stiffness damping_ratio hinge_damping_ratio "
        "inertia_ratio force_amplitude force_frequency"
    )
    natural = sp.sqrt(k / (main + free))
    moment = free * rod**2
    return Mechanism(
        t,
        (y, theta),
        (y_dot, theta_dot),
        [(main, [0 * y, y]), (free, [rod * sp.cos(theta), y + rod * sp.sin(theta)])],
        [(ratio * moment, theta)],
        k * y**2 / 2,
        [
            force * sp.cos(2 * sp.pi * hertz * t) - 2 * rho * (main + free) * natural * y_dot,
            -zeta * moment * natural * theta_dot,
        ],
    )


MECHANISMS: Mapping[str, Any] = {"hula_hoop": hula_hoop}


@cache
def program_of(scene: str) -> tuple[int, Program]:
    """Return the number of coordinates and the program t, q, v -> M, f of a scene."""
    system = MECHANISMS[scene]()
    mass, load = mass_and_load(system)
    entries = [sp.sympify(entry) for row in mass for entry in row]
    return len(system.q), compile_expressions(
        (system.time, *system.q, *system.v), [*entries, *load]
    )

"""Equations of motion from positions and energies alone, by SymPy."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, partial
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
    """Return an expression with squares of sine and cosine of one angle added up.

    That takes a minute where there are roots of them, and is left there.
    """
    roots = [power for power in expression.atoms(sp.Pow) if power.exp.is_Rational]
    if any(not power.exp.is_integer and power.atoms(sp.sin, sp.cos) for power in roots):
        return expression
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


def speed_regulator() -> Mechanism:
    """Return a crank, a homogeneous rod and a damped slider on the y axis, by the crank's angle.

    Vlase, Mihalcica, Scutaru (2018): the rod hangs below the crank's pin, so that its angle b has
    a positive cosine. Its kinetic energy is that of two thirds of its mass in the middle and one
    sixth at each end, which has the same mass, centre and moment of inertia.
    """
    t, phi, phi_dot = sp.symbols("t phi phi_dot", real=True)
    r, l, flywheel, rod, slider, k, c, torque, rest = symbols_of(
        "crank_radius rod_length flywheel_inertia rod_mass slider_mass stiffness damping "
        "torque spring_rest"
    )
    pin = [r * sp.cos(phi), r * sp.sin(phi)]
    end = [sp.S.Zero, pin[1] - sp.sqrt(l**2 - pin[0] ** 2)]
    middle = [(a + b) / 2 for a, b in zip(pin, end, strict=True)]
    lever = end[1].diff(phi)
    return Mechanism(
        t,
        (phi,),
        (phi_dot,),
        [(2 * rod / 3, middle), (rod / 6, pin), (rod / 6, end), (slider, end)],
        [(flywheel, phi)],
        k * (end[1] - rest) ** 2 / 2,
        [torque - c * lever**2 * phi_dot],
    )


def rotor_pendulum(relative: bool) -> Mechanism:
    """Return a platform on a spring, a rotor on it, and one at the end of a rod hinged to it.

    Fang, Hou, Nan, Yu (2015). The second motor turns against the rod (`relative`) or against the
    ground; both lose torque with speed, as their bearings do.
    """
    t = sp.Symbol("t", real=True)
    q = sp.symbols("x phi_1 phi_2 phi_3", real=True)
    v = sp.symbols("x_dot phi_1_dot phi_2_dot phi_3_dot", real=True)
    platform, rotor, rod, r, l, k_x, f_x, k_phi, f_phi, beta, slope, speed, friction = symbols_of(
        "platform_mass rotor_mass rod_mass eccentricity rod_length platform_stiffness "
        "platform_damping rod_stiffness rod_damping installation_angle motor_slope "
        "synchronous_speed friction"
    )
    x, phi_1, phi_2, phi_3 = q
    end = [x + l * sp.cos(beta + phi_3), l * sp.sin(beta + phi_3)]
    slips = v[1], v[2] - v[3] if relative else v[2]
    first, second = (slope * (speed - slip) - friction * slip for slip in slips)
    return Mechanism(
        t,
        q,
        v,
        [
            (platform, [x, 0 * x]),
            (rotor, [x - r * sp.cos(phi_1), r * sp.sin(phi_1)]),
            (rod, end),
            (rotor, [end[0] + r * sp.cos(phi_2), end[1] + r * sp.sin(phi_2)]),
        ],
        [],
        (k_x * x**2 + k_phi * phi_3**2) / 2,
        [-f_x * v[0], first, second, -f_phi * v[3] - (second if relative else 0)],
    )


MECHANISMS: Mapping[tuple[str, str], Callable[[], Mechanism]] = {
    ("hula_hoop", ""): hula_hoop,
    ("speed_regulator", ""): speed_regulator,
    ("rotor_pendulum", "absolute"): partial(rotor_pendulum, False),
    ("rotor_pendulum", "relative"): partial(rotor_pendulum, True),
}
"""Mechanisms by scene and by what a parameter says in words."""


@cache
def program_of(scene: str, word: str) -> tuple[int, Program]:
    """Return the number of coordinates and the program t, q, v -> M, f of a scene."""
    system = MECHANISMS[scene, word]()
    mass, load = mass_and_load(system)
    entries = [sp.sympify(entry) for row in mass for entry in row]
    inputs = (system.time, *system.q, *system.v)
    return len(system.q), compile_expressions(inputs, [*entries, *load])

"""Trees of bodies on a free joint as power series in time.

The equations are the scenes' own, which `tests/reference` holds against others; their numbers are
computed anew from the parameters.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import gmpy2
import sympy as sp

from mbcheck.reference import floating_beam as beam
from mbcheck.reference import floating_platform as platform
from mbcheck.reference.body.rotation import PLACES
from mbcheck.tests.support.precise.body import Body
from mbcheck.tests.support.precise.program import Program, compile_expressions
from mbcheck.tests.support.precise.series import Lagrangian


@cache
def program(equations: Any, size: int) -> Program:
    """Return the program t, q, v -> M, f of so many coordinates."""
    t, *state = sp.symbols(f"t state:{2 * size}", real=True)
    c = equations.Coefficients(*sp.symbols(equations.Coefficients._fields, real=True))
    q, v = state[:size], state[size:]
    rows = [
        *(entry for row in equations.TREE.mass_matrix(q, c, sp) for entry in row),
        *equations.TREE.forces(0, q, v, c, sp),
    ]
    entries = [sp.sympify(row) for row in rows]
    whole = [one.xreplace({x: sp.Rational(x) for x in one.atoms(sp.Float)}) for one in entries]
    return compile_expressions((t, *state), whole)


def numbers(p: Any) -> dict[str, Any]:
    """Return the parameters with more digits."""
    return {name: gmpy2.mpfr(x) for name, x in p.as_dict().items()}


def base_numbers(p: Any, bits: int, others: Any) -> list[Any]:
    """Return the numbers of the body on the free joint, with the mass of all others."""
    still = p.replace(centre_x=0.0, centre_y=0.0, centre_z=0.0)  # about the centre of mass
    body, value = Body(still, bits), numbers(p)
    tensor = [body.inertia[i][j] for i, j in PLACES]
    inverse = [body.inverse[i][j] for i, j in PLACES]
    own = [value[name] for name in ("mass", "centre_x", "centre_y", "centre_z")]
    whole = value["mass"] + others
    return [*body.arm, *tensor, *inverse, *body.gravity, sum(tensor[:3]), whole, *own]


def lagrangian(equations: Any, size: int, values: list[Any]) -> Lagrangian:
    """Return the equations with these numbers."""
    named = dict(zip(equations.Coefficients._fields, values, strict=True))
    return Lagrangian(size, program(equations, size), named)


def floating_platform(p: Any, bits: int) -> Lagrangian:
    """Return the equations with these parameters."""
    value = numbers(p)
    values = [
        *base_numbers(p, bits, value["rotor_mass"] + value["rod_mass"]),
        *(value[name] for name in ("rotor_mass", "eccentricity", "polar_moment")),
        value["polar_moment"] / 2 + value["depth_moment"],
        *(value[name] for name in ("rotor_height", "rod_mass", "rod_length", "rod_moment")),
        *(value["rod_place"], -gmpy2.sin(value["tilt"]), gmpy2.cos(value["tilt"])),
        *(value[name] for name in ("installation_angle", "rod_stiffness", "rod_damping")),
        *(value["motor_slope"], value["synchronous_speed"]),
    ]
    return lagrangian(platform, 9, values)


def floating_beam(p: Any, bits: int) -> Lagrangian:
    """Return the equations with these parameters."""
    value = numbers(p)
    mass, h, tip = value["beam_mass"] / beam.RODS, value["length"] / beam.RODS, value["tip_mass"]
    across, whole, k = (
        mass * h**2 / 12 + value["polar_moment"] / 2,
        mass + tip,
        value["bending_stiffness"] / h,
    )
    values = [
        *base_numbers(p, bits, value["beam_mass"] + tip),
        *(mass, h / 2, across, whole, (mass / 2 + tip) * h / whole),
        across + mass * tip / whole * (h / 2) ** 2,
        *(value["polar_moment"], value["hub_radius"], h),
        *(gmpy2.cos(value["twist"]), gmpy2.sin(value["twist"]), 2 * k, k, value["hinge_damping"]),
    ]
    return lagrangian(beam, 7 + beam.RODS, values)

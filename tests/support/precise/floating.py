"""A platform on a free joint with bodies on hinges as power series in time.

The equations are the scene's own, which `tests/reference` holds against others; their numbers are
computed anew from the parameters.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import gmpy2
import sympy as sp

from mbcheck.reference.body.parameters import PLACES
from mbcheck.reference.floating_platform.equations import TREE, Coefficients
from mbcheck.tests.support.precise.body import Body
from mbcheck.tests.support.precise.program import Program, compile_expressions
from mbcheck.tests.support.precise.series import Lagrangian

SIZE = 9


@cache
def platform_program() -> Program:
    """Return the program t, q, v -> M, f."""
    t, *state = sp.symbols(f"t state:{2 * SIZE}", real=True)
    c = Coefficients(*sp.symbols(Coefficients._fields, real=True))
    q, v = state[:SIZE], state[SIZE:]
    rows = [
        *(entry for row in TREE.mass_matrix(q, c, sp) for entry in row),
        *TREE.forces(0, q, v, c, sp),
    ]
    entries = [sp.sympify(row) for row in rows]
    whole = [one.xreplace({x: sp.Rational(x) for x in one.atoms(sp.Float)}) for one in entries]
    return compile_expressions((t, *state), whole)


def floating_platform(p: Any, bits: int) -> Lagrangian:
    """Return the equations with these parameters."""
    still = p.replace(centre_x=0.0, centre_y=0.0, centre_z=0.0)  # about the centre of mass
    body, value = Body(still, bits), {name: gmpy2.mpfr(x) for name, x in p.as_dict().items()}
    tensor = [body.inertia[i][j] for i, j in PLACES]
    inverse = [body.inverse[i][j] for i, j in PLACES]
    numbers = [
        *(*body.arm, *tensor, *inverse, *body.gravity, sum(tensor[:3])),
        value["mass"] + value["rotor_mass"] + value["rod_mass"],
        *(value[name] for name in ("mass", "centre_x", "centre_y", "centre_z")),
        *(value[name] for name in ("rotor_mass", "eccentricity", "polar_moment")),
        value["polar_moment"] / 2 + value["depth_moment"],
        *(value[name] for name in ("rotor_height", "rod_mass", "rod_length", "rod_moment")),
        *(value["rod_place"], -gmpy2.sin(value["tilt"]), gmpy2.cos(value["tilt"])),
        *(value[name] for name in ("installation_angle", "rod_stiffness", "rod_damping")),
        *(value["motor_slope"], value["synchronous_speed"]),
    ]
    named = dict(zip(Coefficients._fields, numbers, strict=True))
    return Lagrangian(SIZE, platform_program(), named)

"""The scene `rotor_pendulum`, and the paper's reduced equations beside it."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from ..scene import Paper, PeriodicOrbit, Scene, with_placements, with_rates
from .cases import CASES
from .equations import (
    RotorPendulum,
    _accelerations,
    _forces,
    _mass_matrix,
    accelerations,
    coefficients,
    damping_matrix,
    energy,
    forces,
    invariants,
    mass_matrix,
    period,
    powers,
    rest,
    unforced,
)
from .outcome import outcome
from .phase import ORBIT_UNITS, orbit_guesses, orbit_quantities

SCENE = Scene(
    name="rotor_pendulum",
    title="synchronising rotors on a platform and a pendulum rod",
    paper=Paper(
        "P. Fang, Y. Hou, Y. Nan, L. Yu",
        "Study of synchronization for a rotor-pendulum system with Poincare method",
        "Journal of Vibroengineering 17(5), jvejournals.com/article/15915",
        2015,
        "",  # the journal gave none then
    ),
    parameters=RotorPendulum,
    coordinates=("x", "phi_1", "phi_2", "phi_3"),
    units=with_rates(x="m", phi_1="rad", phi_2="rad", phi_3="rad"),
    coefficients=coefficients,
    mass_matrix=mass_matrix,
    forces=forces,
    accelerations=accelerations,
    damping_matrix=damping_matrix,
    energy=energy,
    powers=powers,
    equilibria={name: partial(rest, name) for name in ("synchronous", "rest")},
    steady_coordinates={"synchronous": ("phi_1", "phi_2")},
    rotations_per_period={"phi_1": 1, "phi_2": 1},
    period=period,
    orbit=PeriodicOrbit(orbit_guesses, "phi_1", orbit_quantities, ORBIT_UNITS),
    unforced=unforced,
    invariants=invariants,
    outcome=outcome,
    cases=CASES,
    placed=with_placements(CASES[3], "algebra", "trajectory"),
)

REDUCED = replace(
    SCENE,
    title="the same, equations (11): B -> beta after deriving",
    mass_matrix=lambda q, c, xp=np: _mass_matrix(q, c.beta, c, xp),
    forces=lambda u, q, v, c, xp=np: _forces(q, v, c.beta, c, xp),
    accelerations=lambda u, q, v, c, xp=np: _accelerations(q, v, c.beta, c, xp),
)
"""The paper's (11), the sign in its fourth line corrected. Its energy is that of the exact
equations, which it does not conserve; no other quadratic form of these M is conserved either."""

SCENE = replace(SCENE, variants={"reduced": REDUCED})

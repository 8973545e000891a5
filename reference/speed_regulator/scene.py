"""The scene `speed_regulator`."""

from __future__ import annotations

from functools import partial

from ..scene import Paper, PeriodicOrbit, Scene, with_placements
from .cases import CASES
from .equations import (
    UNITS,
    SpeedRegulator,
    accelerations,
    assembled,
    coefficients,
    damping_matrix,
    energy,
    forces,
    mass_matrix,
    outputs,
    powers,
)
from .orbit import ORBIT_UNITS, orbit_guesses, orbit_quantities, period
from .outcome import outcome
from .rest import EQUILIBRIA, equilibrium
from .theory import connection, cycle_start

SCENE = Scene(
    name="speed_regulator",
    title="speed regulator: a slider-crank with a sprung and damped slider",
    paper=Paper(
        "S. Vlase, M. Mihalcica, M. L. Scutaru",
        "Determining the Functional Parameters of a Simple Speed Regulator",
        "",
        2018,
        "",
    ),
    parameters=SpeedRegulator,
    coordinates=("phi",),
    units=UNITS,
    coefficients=coefficients,
    mass_matrix=mass_matrix,
    forces=forces,
    accelerations=accelerations,
    damping_matrix=damping_matrix,
    energy=energy,
    powers=powers,
    equilibria={name: partial(equilibrium, name) for name in EQUILIBRIA},
    rotations_per_period={"phi": 1},
    period=period,
    orbit=PeriodicOrbit(
        orbit_guesses, "phi", orbit_quantities, ORBIT_UNITS, (), connection, cycle_start
    ),
    cases=CASES,
    placed=with_placements(CASES[0], "algebra", "trajectory"),
    outputs=outputs,
    observed=("y", "y_dot"),
    invariants=lambda p: {"energy": energy},
    outcome=outcome,
    assembled=assembled,
)

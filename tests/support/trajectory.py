"""A trajectory of hula_hoop to be judged."""

from typing import Any

import numpy as np

from mbcheck.comparisons.judge.judge import Judgement
from mbcheck.comparisons.queries.simulate import Simulation, simulate
from mbcheck.reference.scene import Array

CASE = "hula_hoop/spinning_3hz_60n"
START = {"y": 0.01, "theta": 0.3, "theta_dot": 18.0}
STEP: float = 2.0**-10
TIMES: Array = np.arange(0.0, 513.0, 4.0) * STEP

GOOD = "t,theta\n0,0.3\n0.1,1.9\n"
"""A file that can be judged."""

Columns = dict[str, Array]


def columns(simulation: Simulation) -> Columns:
    """Return the columns of a simulation's file."""
    return {"t": simulation.times, **simulation.observables}


def run(engine: str = "mujoco", method: str = "RK4", **how: Any) -> Simulation:
    """Simulate the trajectory by an engine."""
    return simulate(
        "hula_hoop", engine=engine, method=method, step=STEP, state=START, times=TIMES, **how
    )


def verdicts(judgement: Judgement) -> set[str]:
    """Return the verdicts of a judgement."""
    return {result.verdict for result in judgement.results}

"""Runs drawn at random, by whole numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from mbcheck.reference import get_scene
from mbcheck.reference.errors import MbcheckError
from mbcheck.tests.support.precise.kinds import (
    hula_hoop,
    rigid_body,
    rotating_beam,
    rotor_pendulum,
    speed_regulator,
)
from mbcheck.tests.support.precise.kinds.common import (
    SPACE,
    Kind,
    Run,
    corner,
    near,
    weighed,
    wide,
)

KINDS: Mapping[str, tuple[Kind, ...]] = {
    "hula_hoop": hula_hoop.KINDS,
    "rotating_beam": rotating_beam.KINDS,
    "rotor_pendulum": rotor_pendulum.KINDS,
    "speed_regulator": speed_regulator.KINDS,
    "rigid_body": rigid_body.KINDS,
    **{scene: (near, wide, corner, weighed, kind) for scene, kind in SPACE.items()},
}
"""Kinds of runs of each scene; draw i is of the kind i modulo their number."""


def run_of(scene: str, number: int) -> Run:
    """Return the run that a whole number stands for."""
    kind = KINDS[scene][number % len(KINDS[scene])]
    attempt = 0
    while True:
        seed = [sum(map(ord, scene)), number, attempt]
        rng = np.random.default_rng(seed)
        shares = np.sort(rng.uniform(0, 1, int(rng.integers(0, 5))))
        try:
            values = kind(scene, rng)
        except MbcheckError:  # values that contradict each other are drawn again
            attempt += 1
            continue
        return Run(scene, kind.__name__, shares=(*map(float, shares), 1.0), **values)


class Provocation(NamedTuple):
    """A run that is hard for a certain reason, and whether it takes long."""

    run: Run
    slow: bool = False


def provoking(
    scene: str, state: Mapping[str, float], horizon: float, shares: tuple[float, ...], **p: Any
) -> Run:
    """Return a run of the default parameters but for some."""
    parameters = get_scene(scene).parameters(**p)
    patience = 1000  # it is never shortened
    return Run(
        scene, "provocation", parameters, state, 0.0, horizon, shares=shares, patience=patience
    )


LINE = {"theta": 1.5707963267948966}
TOP = {"phi": 1.5707963267948966}
TENTHS = tuple(i / 10 for i in range(1, 11))
CRANK = {"crank_radius": 1.25 * (1 - 1e-10)}
RAMP = {"angular_speed": 0.5, "ramp_time": 1e-4}
WEIGHT = {"drive": "torque", "mass": 0.4, "hub_radius": 0.5, "gravity_x": 3.0, "gravity_y": -9.0}
SWING = {"theta": 0.5, "theta_dot": 0.8, "b_3": 0.2, "b_8": 0.3}
BALANCE = {"spring_rest": -3.7, "torque": 19.80204102886729}
PULSE = {"drive": "torque", "torque_amplitude": 1e3, "torque_period": 1e-5}

PROVOCATIONS: Mapping[str, Provocation] = {
    "invariant line": Provocation(provoking("hula_hoop", LINE, 10.0, TENTHS)),
    "chaos": Provocation(
        provoking("hula_hoop", {"theta": 0.3, "y": 0.01}, 10.0, TENTHS), slow=True
    ),
    "saddle": Provocation(provoking("speed_regulator", TOP, 60.0, TENTHS, torque=0.0)),
    "at rest between balanced forces": Provocation(
        provoking("speed_regulator", {}, 25.0, TENTHS, **BALANCE)
    ),
    "slow between balanced forces": Provocation(
        provoking("speed_regulator", {"phi": 1e-14}, 5.0, TENTHS, **BALANCE)
    ),
    "nearly as long as the rod": Provocation(
        provoking("speed_regulator", {"phi": 0.5, "phi_dot": 5.0}, 3.0, TENTHS, **CRANK)
    ),
    "short ramp": Provocation(provoking("rotating_beam", {}, 0.02, TENTHS, **RAMP)),
    "short ramp, long run": Provocation(
        provoking("rotating_beam", {}, 1.0, (0.1, 0.4, 0.7, 1.0), **RAMP), slow=True
    ),
    "gravity": Provocation(provoking("rotating_beam", SWING, 0.05, TENTHS, **WEIGHT)),
    "short pulse": Provocation(provoking("rotating_beam", {}, 0.02, TENTHS, **PULSE)),
    "short pulse, long run": Provocation(
        provoking("rotating_beam", {}, 1.0, (0.1, 0.4, 0.7, 1.0), **PULSE), slow=True
    ),
}
"""Runs whose errors were above their bounds."""

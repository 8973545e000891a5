"""Runs drawn at random, by whole numbers."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mbcheck.reference.errors import MbcheckError
from mbcheck.tests.support.precise.kinds import (
    hula_hoop,
    rotating_beam,
    rotor_pendulum,
    speed_regulator,
)
from mbcheck.tests.support.precise.kinds.common import Kind, Run

KINDS: Mapping[str, tuple[Kind, ...]] = {
    "hula_hoop": hula_hoop.KINDS,
    "rotating_beam": rotating_beam.KINDS,
    "rotor_pendulum": rotor_pendulum.KINDS,
    "speed_regulator": speed_regulator.KINDS,
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

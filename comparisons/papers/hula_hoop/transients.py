"""Measures of the transients from rest in figures 5 and 7 of the hula_hoop paper."""

from __future__ import annotations

import numpy as np

from ....reference import get_scene
from ...engines.registry import REFERENCE
from ...scenes.hula_hoop.floquet import EXACT
from ...scenes.hula_hoop.motion import MOTION_STEPS, NEAR, SAMPLES, SLACK, strongest
from ...scenes.hula_hoop.steps import step_counts
from ...scenes.quantity import Flow, Points
from ..ledger import Numbers
from ..session import Session
from .results import SCENE, grid, is_class, motion_map

TRANSIENT, PASSING, LASTING = 100, 4, 20
"""Periods of the force that count as transient, and that hula-hoop motion takes in it at least."""


def transients(session: Session, plate: bool = False) -> Numbers:
    """Return at which share of cyan o there is hula-hoop motion, as in the table, on the way there.

    For 4 and 20 periods: a turn in each, one way, and theta' oscillating most at 2 omega.
    """
    motion = motion_map(session, plate)
    rows, columns = np.nonzero(is_class(motion, "motion", "cyan_o"))
    if not len(rows):
        return {"passing": 0.0, "lasting": 0.0, "count": 0}
    hertz = motion.x.values[columns]
    p = grid(session, plate).replace(force_frequency=hertz, force_amplitude=motion.y.values[rows])
    places = np.stack([columns, rows], axis=1)
    points = Points(get_scene(SCENE), p, places, {}, REFERENCE, EXACT)
    spacing = 1 / (SAMPLES * hertz)
    begin = np.zeros((4, len(hertz)))
    path = Flow(points, points.scene)(
        np.arange(len(hertz)), begin, 0.0, spacing, TRANSIENT * SAMPLES,
        step_counts(points, spacing, MOTION_STEPS),
    )  # fmt: skip
    theta, speed = path[1] / (2 * np.pi), path[3]
    shares = {}
    for name, periods in (("passing", PASSING), ("lasting", LASTING)):
        there = np.zeros(len(hertz), dtype=bool)
        for start in range(TRANSIENT - periods):
            part = slice(start * SAMPLES, (start + periods) * SAMPLES)
            turns = theta[:, part.stop] - theta[:, part.start]
            one_way = np.all(np.sign(turns)[:, None] * speed[:, part] > 0, axis=1)
            locked = np.abs(np.abs(turns) - periods) < SLACK
            there |= locked & one_way & (np.abs(strongest(speed[:, part], periods) - 2) < NEAR)
        shares[name] = float(np.mean(there))
    return {**shares, "count": len(hertz)}


def transients_of_both(session: Session) -> Numbers:
    """Return these shares in figure 5, and as lists in figures 5 and 7."""
    first, second = (transients(session, plate) for plate in (False, True))
    return {**first, "both": [[one["passing"], one["lasting"]] for one in (first, second)]}

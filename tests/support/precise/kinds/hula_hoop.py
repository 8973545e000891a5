"""Kinds of runs of hula_hoop."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbcheck.tests.support.precise.kinds.common import (
    NEAR,
    Rng,
    any_state,
    corner,
    long,
    near,
    parameters_near,
    tiny,
    turns,
    wide,
)

HALF_PI = float(np.pi / 2)


def line(scene: str, rng: Rng) -> dict[str, Any]:
    """Return starts on the invariant line theta = pi/2, as near as a double comes."""
    p = parameters_near(scene, rng, float(rng.choice([0.0, NEAR])))
    state = {"theta": float(rng.choice([HALF_PI, -HALF_PI]))}
    if rng.random() < 0.5:
        state |= {"y": float(rng.normal() * 0.01), "y_dot": float(rng.normal() * 0.1)}
    horizon = float(rng.choice([0.3, 1.0, 3.0, 10.0], p=[0.4, 0.3, 0.2, 0.1]))
    return dict(parameters=p, state=state, horizon=horizon, patience=8)


def resting(scene: str, rng: Rng) -> dict[str, Any]:
    """Return starts at rest, or beside it."""
    p = parameters_near(scene, rng, NEAR, force_amplitude=0.0)
    state = {"theta": float(rng.choice([0.0, HALF_PI, rng.uniform(-3, 3)]))}
    if rng.random() < 0.6:
        size = 10.0 ** rng.uniform(-15, -3)
        state |= {"y": float(0.01 * size * rng.normal()), "theta_dot": float(size * rng.normal())}
    return dict(parameters=p, state=state, turns=turns(rng, 1, 20))


def nearly_singular(scene: str, rng: Rng) -> dict[str, Any]:
    """Return a free mass that is far heavier than the main mass, on a rod without inertia."""
    ratio = 10.0 ** -rng.uniform(3, 12)
    p = parameters_near(scene, rng, NEAR, inertia_ratio=0.0)
    p = p.replace(main_mass=p.free_mass * ratio)
    return dict(parameters=p, state=any_state(scene, rng, p), turns=turns(rng, 0.3, 4))


def conservative(scene: str, rng: Rng) -> dict[str, Any]:
    """Return motions without dampers, force or both."""
    p = parameters_near(scene, rng, NEAR, damping_ratio=0.0, hinge_damping_ratio=0.0)
    p = p.replace(force_amplitude=0.0) if rng.random() < 0.6 else p
    return dict(parameters=p, state=any_state(scene, rng, p), turns=turns(rng, 2, 30))


KINDS = (near, wide, corner, line, resting, long, tiny, nearly_singular, conservative, wide)

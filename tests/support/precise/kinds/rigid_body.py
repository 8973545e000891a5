"""Kinds of runs of rigid_body."""

from __future__ import annotations

from typing import Any

from mbcheck.tests.support.precise.kinds.common import (
    NEAR,
    Rng,
    any_state,
    corner,
    long,
    near,
    parameters_near,
    turns,
    wide,
)

STILL = {"centre_x": 0.0, "centre_y": 0.0, "centre_z": 0.0}


def free(scene: str, rng: Rng) -> dict[str, Any]:
    """Return bodies on which nothing acts."""
    p = parameters_near(scene, rng, NEAR, gravity_z=0.0, **STILL)
    return dict(parameters=p, state=any_state(scene, rng, p), turns=turns(rng, 1, 20))


def about_an_axis(scene: str, rng: Rng) -> dict[str, Any]:
    """Return rotations about a principal axis or beside it, the middle one among them."""
    level = {"axes_x": 0.0, "axes_y": 0.0, "axes_z": 0.0, "gravity_z": 0.0}
    p = parameters_near(scene, rng, NEAR, **level, **STILL)
    size = float(rng.choice([0.0, 10.0 ** rng.uniform(-12, -2)]))
    rates = size * rng.normal(size=3)
    rates[rng.integers(3)] = 10.0
    state = dict(zip(("omega_x", "omega_y", "omega_z"), map(float, rates), strict=True))
    return dict(parameters=p, state=state, turns=turns(rng, 1, 10))


def resting(scene: str, rng: Rng) -> dict[str, Any]:
    """Return starts at rest in any attitude."""
    p = parameters_near(scene, rng, NEAR)
    state = {name: value for name, value in any_state(scene, rng, p).items() if name[0] == "q"}
    return dict(parameters=p, state=state, turns=turns(rng, 0.3, 8))


KINDS = (  # a quaternion next to nothing is no start that is tiny
    near,
    wide,
    corner,
    free,
    about_an_axis,
    resting,
    long,
)

"""Kinds of runs of floating_platform."""

from __future__ import annotations

from typing import Any

from mbcheck.tests.support.precise.kinds.common import (
    NEAR,
    Rng,
    any_state,
    corner,
    near,
    parameters_near,
    turns,
    weighed,
    wide,
)


def conservative(scene: str, rng: Rng) -> dict[str, Any]:
    """Return motions without motor and damper."""
    p = parameters_near(scene, rng, NEAR, motor_slope=0.0, rod_damping=0.0)
    return dict(parameters=p, state=any_state(scene, rng, p), turns=turns(rng, 0.1, 2))


KINDS = (near, wide, corner, weighed, conservative)

"""Kinds of runs of ball_hoop."""

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
    """Return motions without force and dampers."""
    p = parameters_near(scene, rng, NEAR, damping=0.0, joint_damping=0.0, force_amplitude=0.0)
    return dict(parameters=p, state=any_state(scene, rng, p), turns=turns(rng, 1, 15))


KINDS = (near, wide, corner, weighed, conservative)

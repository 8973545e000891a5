"""Kinds of runs of floating_beam."""

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
    """Return motions without dampers."""
    p = parameters_near(scene, rng, NEAR, hinge_damping=0.0)
    return dict(parameters=p, state=any_state(scene, rng, p), turns=turns(rng, 0.1, 2))


KINDS = (near, wide, corner, weighed, conservative)

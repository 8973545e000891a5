"""Kinds of runs of speed_regulator."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbcheck.reference import get_scene
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


def saddle(scene: str, rng: Rng) -> dict[str, Any]:
    """Return starts at an equilibrium, mostly an unstable one, or beside it."""
    p = parameters_near(scene, rng, float(rng.choice([0.0, NEAR])))
    p = p.replace(torque=float(rng.choice([0.0, 0.01, 0.1])) * p.torque)
    name = str(rng.choice(["top", "top", "left", "bottom"]))
    state = dict(get_scene(scene).equilibria[name](p))
    if rng.random() < 0.3:
        state["phi"] += float(10.0 ** rng.uniform(-14, -4))
    return dict(parameters=p, state=state, turns=turns(rng, 1, 12))


def separatrix(scene: str, rng: Rng) -> dict[str, Any]:
    """Return starts with the energy of the unstable equilibrium at the top."""
    p = parameters_near(scene, rng, float(rng.choice([0.0, NEAR])), torque=0.0, damping=0.0)
    phi = float(rng.uniform(-3, 1))
    r, l, half_pi = p.crank_radius, p.rod_length, np.pi / 2
    height = lambda at: r * np.sin(at) - np.sqrt(l**2 - (r * np.cos(at)) ** 2)  # noqa: E731
    lever = float(np.imag(height(phi + 1e-30j)) / 1e-30)
    middle = (r * np.sin(phi)) ** 2 + (r * np.cos(phi) + lever) ** 2
    inertia = p.flywheel_inertia + p.rod_mass * (middle + r**2 + lever**2) / 6
    inertia += p.slider_mass * lever**2
    top, here = (p.stiffness * (height(at) - p.spring_rest) ** 2 for at in (half_pi, phi))
    speed = np.sqrt(max(top - here, 0.0) / inertia)
    state = {"phi": phi, "phi_dot": float(speed)}
    return dict(parameters=p, state=state, turns=turns(rng, 0.5, 10))


def nearly_singular(scene: str, rng: Rng) -> dict[str, Any]:
    """Return a crank that is hardly shorter than the rod."""
    p = parameters_near(scene, rng, NEAR)
    p = p.replace(crank_radius=p.rod_length * (1 - 10.0 ** -rng.uniform(3, 12)))
    phi = float(rng.choice([0.0, np.pi, rng.uniform(-3, 3)])) + 10.0 ** rng.uniform(-8, -1)
    state = {"phi": phi, "phi_dot": float(rng.normal() * 5)}
    return dict(parameters=p, state=state, turns=turns(rng, 0.3, 2))


def conservative(scene: str, rng: Rng) -> dict[str, Any]:
    """Return motions without damper, torque or both."""
    p = parameters_near(scene, rng, NEAR, damping=0.0)
    p = p.replace(torque=0.0) if rng.random() < 0.6 else p
    return dict(parameters=p, state=any_state(scene, rng, p), turns=turns(rng, 2, 30))


def massless(scene: str, rng: Rng) -> dict[str, Any]:
    """Return mechanisms with parts that weigh nothing, or hold nothing."""
    p = parameters_near(scene, rng, NEAR)
    for name in ("rod_mass", "slider_mass", "stiffness"):
        p = p.replace(**{name: 0.0}) if rng.random() < 0.5 else p
    return dict(parameters=p, state=any_state(scene, rng, p), turns=turns(rng, 0.3, 8))


KINDS = (
    near, wide, corner, saddle, separatrix, long, tiny, nearly_singular, conservative, massless,
)  # fmt: skip

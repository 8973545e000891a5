"""Kinds of runs of rotating_beam."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbcheck.reference import get_scene
from mbcheck.reference.rotating_beam import BENDING
from mbcheck.tests.support.precise.kinds.common import Rng, parameters_at, turns

NEAR, WIDE = 0.3, 1.0
"""Decades around the defaults that parameters are drawn from."""

MASSIVE = ("mass", "hub_radius")
"""Parameters [kg], [m] that are nothing in a share of the runs."""


def beam(scene: str, rng: Rng, decades: float, **changes: Any) -> Any:
    """Return a beam, its hub driven or prescribed, with a mass and without."""
    for name in MASSIVE:
        if rng.random() < 0.3:
            changes = {name: 0.0} | changes
    return parameters_at(scene, rng, decades, lambda: rng.uniform(-1, 1), **changes)


def start(scene: str, rng: Rng, p: Any) -> dict[str, float]:
    """Return a straight beam whose hub turns as its drive demands, or as it likes."""
    turning = {"theta": float(rng.uniform(-3, 3)), "theta_dot": float(rng.normal())}
    return turning | get_scene(scene).constrained_initial_values(p)


def shape(rng: Rng, size: float) -> dict[str, float]:
    """Return a bent beam: smooth, or of all modes."""
    names = [f"b_{i + 1}" for i in range(BENDING)]
    smooth = np.arange(1, BENDING + 1) / BENDING
    values = size * (smooth if rng.random() < 0.7 else 0.1 * rng.normal(size=BENDING))
    return dict(zip(names, map(float, values), strict=True))


def near(scene: str, rng: Rng) -> dict[str, Any]:
    """Return driven hubs with parameters near the defaults."""
    p = beam(scene, rng, NEAR)
    return dict(parameters=p, state=start(scene, rng, p), turns=turns(rng, 3, 300))


def wide(scene: str, rng: Rng) -> dict[str, Any]:
    """Return driven hubs with parameters far from the defaults, some from a later time on."""
    p = beam(scene, rng, WIDE)
    later = float(rng.uniform(0, 10)) if rng.random() < 0.3 else 0.0
    state = start(scene, rng, p)
    return dict(parameters=p, state=state, turns=turns(rng, 3, 300), start_time=later)


def corner(scene: str, rng: Rng) -> dict[str, Any]:
    """Return hubs with every parameter at an end of its range."""
    p = parameters_at(scene, rng, WIDE, lambda: float(rng.choice([-1.0, 1.0])))
    return dict(parameters=p, state=start(scene, rng, p), turns=turns(rng, 3, 300))


def pulse(scene: str, rng: Rng) -> dict[str, Any]:
    """Return torques that last from a microsecond to a tenth of a second."""
    lasts = 10.0 ** -rng.uniform(1, 6)
    size = float(rng.choice([1.0, 1e-2 / lasts, 1e3]))
    p = beam(scene, rng, NEAR, drive="torque", torque_period=lasts, torque_amplitude=size)
    state = {} if rng.random() < 0.5 else start(scene, rng, p)
    return dict(parameters=p, state=state, horizon=turns(rng, 1, 1000) * lasts, patience=2)


def ramp(scene: str, rng: Rng) -> dict[str, Any]:
    """Return hubs that come to their speed in a microsecond to a tenth of a second."""
    lasts = 10.0 ** -rng.uniform(1, 6)
    speed = float(rng.choice([0.5, 0.01, rng.normal()]))
    p = beam(scene, rng, NEAR, drive="prescribed", ramp_time=lasts, angular_speed=speed)
    return dict(parameters=p, state={}, horizon=turns(rng, 1, 1000) * lasts, patience=2)


def bent(scene: str, rng: Rng) -> dict[str, Any]:
    """Return starts with a bent beam, at most by half a turn; half of them in gravity."""
    p = beam(scene, rng, NEAR)
    state = start(scene, rng, p) | shape(rng, 10.0 ** rng.uniform(-4, 0.5))
    length = turns(rng, 3, 200)
    if rng.random() < 0.5:
        x, y = map(float, rng.normal(size=2) * 10.0 ** rng.uniform(-1, 2))
        p = p.replace(gravity_x=x, gravity_y=y)
    return dict(parameters=p, state=state, turns=length)


def long(scene: str, rng: Rng) -> dict[str, Any]:
    """Return runs over a good part of the slowest period."""
    p = beam(scene, rng, NEAR / 2)
    p = p.replace(ramp_time=float(rng.uniform(0.1, 1)), torque_period=float(rng.uniform(0.1, 1)))
    return dict(parameters=p, state=start(scene, rng, p), turns=turns(rng, 300, 3000), patience=2)


def tiny(scene: str, rng: Rng) -> dict[str, Any]:
    """Return motions that are next to nothing."""
    size = 10.0 ** -float(rng.choice([6, 12, 30, 120]))
    p = beam(scene, rng, NEAR, angular_speed=size, torque_amplitude=size)
    state = {"theta_dot": size} | get_scene(scene).constrained_initial_values(p)
    return dict(parameters=p, state=state | shape(rng, size), turns=turns(rng, 3, 100))


def steady(scene: str, rng: Rng) -> dict[str, Any]:
    """Return beams that turn steadily, some so fast that truncated models fail; or beside that."""
    speed = float(10.0 ** rng.uniform(-1, 1.5))
    p = beam(scene, rng, NEAR, drive="prescribed", ramp_time=0.0, angular_speed=speed)
    if rng.random() < 0.4:
        p = p.replace(drive="torque", torque_amplitude=0.0)
    state = {"theta_dot": speed}
    if rng.random() < 0.7:
        state |= shape(rng, 10.0 ** -rng.uniform(1, 14))
    return dict(parameters=p, state=state, turns=turns(rng, 3, 200))


def heavy(scene: str, rng: Rng) -> dict[str, Any]:
    """Return masses from far lighter to far heavier than the beam, and hubs that weigh nothing."""
    mass = 10.0 ** rng.uniform(-6, 4)
    hub = float(rng.choice([0.0, 1e-8, 1e4]))
    p = beam(scene, rng, NEAR, mass=mass, hub_inertia=hub)
    return dict(parameters=p, state=start(scene, rng, p), turns=turns(rng, 3, 200))


KINDS = (near, wide, corner, pulse, ramp, bent, long, tiny, steady, heavy)

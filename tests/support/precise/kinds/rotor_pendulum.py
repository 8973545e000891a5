"""Kinds of runs of rotor_pendulum."""

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
    tiny,
    turns,
    wide,
)

SOFT = {"platform_stiffness": 65969.0, "rod_stiffness": 1053.0}
"""[N/m], [N m/rad] of the second case of section 5.2, whose rotors synchronise near resonance."""


def startup(scene: str, rng: Rng) -> dict[str, Any]:
    """Return runs from rest."""
    changes = SOFT if rng.random() < 0.5 else {}
    p = parameters_near(scene, rng, NEAR, **changes)
    return dict(parameters=p, state={}, turns=turns(rng, 1, 20))


def at_speed(scene: str, rng: Rng) -> dict[str, Any]:
    """Return rotors that turn near their speed, in phase, against it, or in between."""
    changes = SOFT if rng.random() < 0.5 else {}
    p = parameters_near(scene, rng, NEAR / 4, **changes)
    speed = 0.98 * p.synchronous_speed
    phases = {"phi_1": float(rng.choice([0.064, -3.129, rng.uniform(-3, 3)]))}
    state = phases | {"phi_1_dot": speed, "phi_2_dot": speed}
    return dict(parameters=p, state=state, turns=turns(rng, 2, 20))


def resting(scene: str, rng: Rng) -> dict[str, Any]:
    """Return rotors without motors, at rest or beside it."""
    p = parameters_near(scene, rng, NEAR, motor_slope=0.0)
    state = any_state(scene, rng, p)
    size = float(rng.choice([0.0, 1e-15, 1e-9, 1e-4]))
    moving = {name: value * size for name, value in state.items() if name.endswith("_dot")}
    return dict(
        parameters=p,
        state={"phi_1": state["phi_1"], "phi_2": state["phi_2"]} | moving,
        turns=turns(rng, 1, 10),
    )


def nearly_singular(scene: str, rng: Rng) -> dict[str, Any]:
    """Return rotors that are far heavier than platform and rod."""
    p = parameters_near(scene, rng, NEAR)
    rotor = p.rotor_mass
    p = p.replace(platform_mass=rotor * 10.0 ** -rng.uniform(2, 10))
    p = p.replace(rod_mass=rotor * 10.0 ** -rng.uniform(2, 10))
    return dict(parameters=p, state=any_state(scene, rng, p), turns=turns(rng, 0.2, 2))


def conservative(scene: str, rng: Rng) -> dict[str, Any]:
    """Return motions without motors and dampers, on a spring or on none."""
    nothing = dict.fromkeys(("motor_slope", "friction", "platform_damping", "rod_damping"), 0.0)
    p = parameters_near(scene, rng, NEAR, **nothing)
    p = p.replace(platform_stiffness=0.0) if rng.random() < 0.5 else p
    return dict(parameters=p, state=any_state(scene, rng, p), turns=turns(rng, 1, 15))


KINDS = (
    near, wide, corner, startup, at_speed, long, tiny, nearly_singular, conservative, resting,
)  # fmt: skip

"""A run, and the kinds of runs that all scenes have."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mbcheck.reference import get_scene
from mbcheck.reference.scene import Array
from mbcheck.tests.support.draws import (
    drawn_fields,
    parameter_at,
    state_at,
    with_moments_of_a_body,
)

NEAR, WIDE = 0.5, 3.0
"""Decades around the defaults that parameters are drawn from."""

LARGE = 500
"""States are drawn by whole numbers between minus and plus this."""


@dataclass(frozen=True)
class Run:
    """What is solved.

    Attributes
    ----------
    scene : str
    kind : str
        A key of `KINDS` of the scene.
    parameters : Parameters
    state : mapping of name to value
    turns : float
        Length of the run in turns of the fastest motion at its start.
    horizon : float
        Length of the run [s]; 0 where `turns` says it.
    start_time : float
    shares : tuple of float
        Sample times as shares of the length.
    patience : float
        How many times more steps it may take than others before it is shortened.
    """

    scene: str
    kind: str
    parameters: Any
    state: Mapping[str, float]
    turns: float = 1.0
    horizon: float = 0.0
    start_time: float = 0.0
    shares: tuple[float, ...] = (0.3, 1.0)
    patience: float = 1.0

    def times(self, length: float) -> Array:
        """Return the sample times of a run of this length [s]."""
        return self.start_time + length * np.array(self.shares)


Rng = np.random.Generator
Kind = Callable[[str, Rng], dict[str, Any]]


def parameters_near(scene: str, rng: Rng, decades: float, **changes: Any) -> Any:
    """Return parameters over decades around the defaults, some of them set."""
    return parameters_at(scene, rng, decades, lambda: rng.uniform(-1, 1), **changes)


def parameters_at(
    scene: str, rng: Rng, decades: float, place: Callable[[], float], **changes: Any
) -> Any:
    """Return parameters at places from -1 to 1 of their ranges, some of them set; no gravity."""
    kind = get_scene(scene).parameters
    drawn = drawn_fields(get_scene(scene))
    values = {item.name: parameter_at(item, decades, place()) for item in drawn}
    return kind(**with_moments_of_a_body(get_scene(scene), values) | changes)


def any_state(scene: str, rng: Rng, parameters: Any) -> dict[str, float]:
    """Return angles on the whole circle, the others over decades."""
    known = get_scene(scene)
    places = tuple(int(i) for i in rng.integers(-LARGE, LARGE + 1, len(known.public_states)))
    return state_at(known, parameters, places)


def turns(rng: Rng, least: float, most: float) -> float:
    """Return a length of a run."""
    return float(np.exp(rng.uniform(np.log(least), np.log(most))))


def near(scene: str, rng: Rng) -> dict[str, Any]:
    """Return motions with parameters near the defaults."""
    p = parameters_near(scene, rng, NEAR)
    return dict(parameters=p, state=any_state(scene, rng, p), turns=turns(rng, 0.3, 8))


def wide(scene: str, rng: Rng) -> dict[str, Any]:
    """Return motions with parameters far from the defaults."""
    p = parameters_near(scene, rng, WIDE)
    start = float(rng.uniform(0, 10)) if rng.random() < 0.3 else 0.0
    state = any_state(scene, rng, p)
    return dict(parameters=p, state=state, turns=turns(rng, 0.3, 8), start_time=start)


def corner(scene: str, rng: Rng) -> dict[str, Any]:
    """Return motions with every parameter at an end of its range."""
    p = parameters_at(scene, rng, WIDE, lambda: float(rng.choice([-1.0, 1.0])))
    return dict(parameters=p, state=any_state(scene, rng, p), turns=turns(rng, 0.3, 8))


def long(scene: str, rng: Rng) -> dict[str, Any]:
    """Return long runs."""
    p = parameters_near(scene, rng, NEAR / 2)
    return dict(parameters=p, state=any_state(scene, rng, p), turns=turns(rng, 20, 80), patience=2)


def tiny(scene: str, rng: Rng) -> dict[str, Any]:
    """Return motions that start next to nothing."""
    p = parameters_near(scene, rng, NEAR)
    state = any_state(scene, rng, p)
    size = 10.0 ** -int(rng.choice([6, 12, 30, 120]))
    return dict(parameters=p, state={k: v * size for k, v in state.items()}, turns=turns(rng, 1, 5))


def weighed(scene: str, rng: Rng) -> dict[str, Any]:
    """Return motions under gravity of any direction in space."""
    p = parameters_near(scene, rng, NEAR)
    pull = {f"gravity_{axis}": float(10 * rng.normal()) for axis in "xyz"}
    state = any_state(scene, rng, p)
    return dict(parameters=p.replace(**pull), state=state, turns=turns(rng, 0.3, 8))


def without(least: float, most: float, **nothing: float) -> Kind:
    """Return the kind of motions, over so many turns, in which some parameters are 0."""

    def conservative(scene: str, rng: Rng) -> dict[str, Any]:
        p = parameters_near(scene, rng, NEAR, **nothing)
        return dict(parameters=p, state=any_state(scene, rng, p), turns=turns(rng, least, most))

    return conservative


SPACE: Mapping[str, Kind] = {
    "ball_hoop": without(1, 15, damping=0.0, joint_damping=0.0, force_amplitude=0.0),
    "floating_platform": without(0.1, 2, motor_slope=0.0, rod_damping=0.0),
    "floating_beam": without(0.1, 2, hinge_damping=0.0),
}
"""Scene of bodies on free joints or slides -> its motions that conserve energy."""

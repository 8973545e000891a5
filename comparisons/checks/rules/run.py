"""A planned run, and the facts on which rules depend."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ....reference import get_scene
from ....reference.equations import ModelEquations, scene_equations
from ....reference.scene import Array, Case
from ...engines.setup import Setup, shortest_period
from ..free_vibrations import Place, places, start_and_rests

QUARTERS = np.arange(4) * np.pi / 2
"""Angles [rad] of a turn at which loads and speeds are evaluated."""


@dataclass(frozen=True)
class RunConditions(Setup):
    """A planned run: a setup, and its horizon [s]."""

    horizon: float = field(kw_only=True)

    @cached_property
    def start(self) -> Array:
        """Initial state (2 n,) in the coordinates of the model's equations."""
        return self.bound.equations.start(self.case)

    @cached_property
    def places(self) -> tuple[Place, ...]:
        """States about which the model's equations are linearised; empty without a scheme."""
        return () if self.linear_scheme is None else places(self, self.linear_scheme)

    @cached_property
    def start_and_rests(self) -> tuple[Place, ...]:
        """Start and states of rest of the model's equations."""
        return start_and_rests(self.bound.equations, tuple(self.start[: len(self.start) // 2]))

    @cached_property
    def period(self) -> float:
        """Period of the drive, or of the orbit [s]."""
        return float(self.scene.period(self.case.parameters))

    def start_speeds(self, names: Iterable[str]) -> list[float]:
        """Return the initial speeds of coordinates of the scene, without their signs."""
        return [abs(self.case.state.get(f"{name}_dot", 0.0)) for name in names]

    @cached_property
    def fastest_turn(self) -> float:
        """Fastest turn, or drive [rad/s]."""
        if self.scene.discretisation_coordinates:  # whose period is that of its first mode
            return abs(float(self.start[len(self.start) // 2]))
        turning = self.scene.turning_speed(self.scene.state(self.case.state))
        speeds = self.start_speeds(self.scene.rotations_per_period)
        return max([2 * np.pi / self.period, turning, *speeds])

    @cached_property
    def ripple(self) -> float:
        """Largest angular acceleration of what turns, over the square of the speed.

        A uniform turn causes no error, except in methods in Cartesian coordinates.
        """
        scene, case = self.scene, replace(self.case, inconsistency={})
        turns = [scene.coordinates.index(name) for name in scene.rotations_per_period]
        if self.bound.has_constraints and self.bound.equations.scene is scene:
            return 1.0
        if scene.discretisation_coordinates or not turns or not self.fastest_turn > 0:
            return 0.0
        rate, n = scene.right_hand_side(case.parameters), len(scene.coordinates)
        starts = turning_starts(case, scene_equations(case))
        largest = max(np.max(np.abs(rate(case.start_time, at)[n:][turns])) for at in starts)
        return min(1.0, float(largest) / self.fastest_turn**2)

    @cached_property
    def speed(self) -> float:
        """Fastest circular frequency that the motion shows: turns, drive, modes [rad/s]."""
        return 2 * np.pi / shortest_period(self.case)


def turning_starts(case: Case, equations: ModelEquations) -> list[Array]:
    """Return the start, and turning at least at the orbit's speed, at four places of the turn."""
    scene = get_scene(case.scene)
    speed = 2 * np.pi / float(scene.period(case.parameters))
    starts = [equations.start(case)]
    for quarter in QUARTERS:
        state = dict(case.state)
        for name in scene.rotations_per_period:
            state[name] = float(quarter)
            state[f"{name}_dot"] = max(abs(state.get(f"{name}_dot", 0.0)), speed)
        starts.append(equations.start(replace(case, state=state)))
    return starts

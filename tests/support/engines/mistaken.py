"""Engines with one mistake of those that are named under *Located*."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from mbcheck.comparisons.engines.adapter import Adapter
from mbcheck.comparisons.engines.equations import ModelEquations
from mbcheck.comparisons.engines.protocol import Method
from mbcheck.comparisons.engines.run import Trajectory, grid_indices
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.engines.variants.catalogue import Wrapped
from mbcheck.reference import get_scene
from mbcheck.reference.scene import Array, Case, EquationsOfMotion
from mbcheck.reference.solve import schemes


class LateSamples(Wrapped):
    """An engine that returns each sample as it was one step before."""

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate, and look one step too early."""
        numbers = np.rint((times - case.start_time) / step).astype(int)
        needed = np.union1d(numbers - 1, numbers)[int(numbers[0] == 1) :]
        found = self.engine.simulate(case, model, method, step, case.start_time + needed * step)
        scene = get_scene(case.scene)
        first = scene.observe(scene.state(case.state), case.parameters)
        values = {
            name: np.array(
                [rows[needed == n - 1][0] if n > 1 else first.get(name, 0.0) for n in numbers]
            )
            for name, rows in found.values.items()
        }
        return replace(found, times=times, values=values, clock=times)


class Exchanged(Wrapped):
    """An engine that puts observables in each other's place."""

    def __init__(self, engine: Adapter, first: str, second: str) -> None:
        super().__init__(engine)
        self.pair = first, second

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate, and exchange two observables."""
        found = self.engine.simulate(case, model, method, step, times)
        first, second = (found.values[name] for name in self.pair)
        return replace(found, values={**found.values, self.pair[0]: second, self.pair[1]: first})


class Starting(Wrapped):
    """An engine that starts elsewhere than it is told: what is left of a start's values."""

    def __init__(self, engine: Adapter, keeps: Callable[[str], bool]) -> None:
        super().__init__(engine)
        self.keeps = keeps

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate from what is left."""
        state = {name: value for name, value in case.state.items() if self.keeps(name)}
        return self.engine.simulate(replace(case, state=state), model, method, step, times)


class OtherMethod(Wrapped):
    """An engine that integrates by another method than it is asked for."""

    def __init__(self, engine: Adapter, other: str) -> None:
        super().__init__(engine)
        self.other = other

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate by the other method."""
        (other,) = (one for one in self.engine.methods if one.name == self.other)
        return self.engine.simulate(case, model, other, step, times)


class Mistaken(Wrapped):
    """An engine that solves its model's equations with the mistake that these know of."""

    def mistaken(self, case: Case, model: str) -> tuple[ModelEquations, EquationsOfMotion]:
        """Return the right equations, and those that are solved."""
        right = self.engine.model_equations(case, model)
        assert right is not None
        (scene,) = right.scene.mistakes.values()
        return right, scene

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate the mistaken equations by the method's scheme."""
        right, scene = self.mistaken(case, model)
        scheme = Setup(self.engine, case, model, method).scheme
        numbers = grid_indices(times, case.start_time, step)
        scalar = schemes.ScalarEquations(scene, right.parameters)
        start = right.start(case)
        states = schemes.integrate(scalar, str(scheme), start, step, numbers, case.start_time)
        values = scene.observe(states, right.parameters)
        return Trajectory(times, values, times, int(numbers[-1]))

    def compute(self, method: Callable[..., Any], case: Case, model: str, *rest: Any) -> Any:
        """Return accelerations of the mistaken equations."""
        if method.__name__ != "accelerations":
            return method(case, model, *rest)
        right, scene = self.mistaken(case, model)
        slopes, n = scene.right_hand_side(right.parameters), len(scene.coordinates)
        names = get_scene(case.scene).state_names
        states = [dict(zip(names, map(float, state), strict=True)) for state in rest[1]]
        starts = [right.start(replace(case, state=state)) for state in states]
        places = [scene.coordinates.index(name) for name in get_scene(case.scene).coordinates]
        return np.array([slopes(0.0, x)[n:][places] for x in starts])


class Restarting(Wrapped):
    """An engine that goes back to its start half-way without a word, and goes on from there."""

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate to half of the samples, and again from the start."""
        half = len(times) // 2
        found = self.engine.simulate(case, model, method, step, times[: max(1, half)])
        if not half:
            return found
        again = replace(case, start_time=float(times[half - 1]))
        rest = self.engine.simulate(again, model, method, step, times[half:])
        values = {name: np.append(rows, rest.values[name]) for name, rows in found.values.items()}
        steps = found.steps + rest.steps
        return replace(found, times=times, values=values, clock=times, steps=steps)

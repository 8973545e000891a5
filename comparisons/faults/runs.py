"""Engines whose runs are wrong, whatever engine computes them: late, reset, exchanged."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...reference import get_scene
from ...reference.scene import Array, Case
from ..engines.adapter import Adapter, BoundModel
from ..engines.protocol import Method
from ..engines.run import Trajectory
from .variants import Wrapped


class LateForce(Wrapped):
    """An engine that evaluates the force one step late."""

    def simulate(
        self, model: BoundModel, case: Case, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate with the force of a step before."""
        earlier = replace(case, start_time=case.start_time - step)
        trajectory = model.simulate(earlier, method, step, times - step)
        return replace(trajectory, times=times, clock=times)


class LateSamples(Wrapped):
    """An engine that returns each sample as it was one step before."""

    def simulate(
        self, model: BoundModel, case: Case, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate, and look one step too early."""
        numbers = np.rint((times - case.start_time) / step).astype(int)
        needed = np.union1d(numbers - 1, numbers)[int(numbers[0] == 1) :]
        trajectory = model.simulate(case, method, step, case.start_time + needed * step)
        scene = get_scene(case.scene)
        first = scene.observe(scene.state(case.state), case.parameters)
        values = {
            name: np.array(
                [rows[needed == n - 1][0] if n > 1 else first.get(name, 0.0) for n in numbers]
            )
            for name, rows in trajectory.values.items()
        }
        return replace(trajectory, times=times, values=values, clock=times)


class Resetting(Wrapped):
    """An engine that silently sets itself to zero half-way, and stays there."""

    def simulate(
        self, model: BoundModel, case: Case, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate the first half."""
        before = max(1, len(times) // 2)
        trajectory = model.simulate(case, method, step, times[:before])
        scene = get_scene(case.scene)
        zero = scene.observe(np.zeros(len(scene.state_names)), case.parameters)
        values = {
            name: np.append(rows, np.full(len(times) - before, zero.get(name, 0.0)))
            for name, rows in trajectory.values.items()
        }
        steps = round((times[-1] - case.start_time) / step)
        return replace(trajectory, times=times, values=values, clock=times, steps=steps)


class Restarting(Wrapped):
    """An engine that silently goes back to its start half-way, and goes on from there."""

    def simulate(
        self, model: BoundModel, case: Case, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate to half of the samples, and again from the start."""
        half = len(times) // 2
        trajectory = model.simulate(case, method, step, times[: max(1, half)])
        if not half:
            return trajectory
        again = replace(case, start_time=float(times[half - 1]))
        rest = model.simulate(again, method, step, times[half:])
        values = {
            name: np.append(rows, rest.values[name]) for name, rows in trajectory.values.items()
        }
        steps = trajectory.steps + rest.steps
        return replace(trajectory, times=times, values=values, clock=times, steps=steps)


class Altered(Wrapped):
    """An engine whose runs are altered when they are over."""

    def __init__(self, engine: Adapter, alter: Callable[[Trajectory, Case], Trajectory]) -> None:
        super().__init__(engine)
        self.alter = alter

    def simulate(
        self, model: BoundModel, case: Case, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate, and alter the result."""
        return self.alter(model.simulate(case, method, step, times), case)


class Exchanged(Altered):
    """An engine that puts observables in each other's place."""

    def __init__(self, engine: Adapter, first: str, second: str) -> None:
        def exchange(run: Trajectory, case: Case) -> Trajectory:
            values = {first: run.values[second], second: run.values[first]}
            return replace(run, values={**run.values, **values})

        super().__init__(engine, exchange)


class Starting(Wrapped):
    """An engine that keeps only some values of the initial state."""

    def __init__(self, engine: Adapter, keeps: Callable[[str], bool]) -> None:
        super().__init__(engine)
        self.keeps = keeps

    def simulate(
        self, model: BoundModel, case: Case, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate from these values."""
        state = {name: value for name, value in case.state.items() if self.keeps(name)}
        return model.simulate(replace(case, state=state), method, step, times)


class OtherMethod(Wrapped):
    """An engine that integrates by another method than requested."""

    def __init__(self, engine: Adapter, other: str) -> None:
        super().__init__(engine)
        self.other = other

    def simulate(
        self, model: BoundModel, case: Case, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate by the other method."""
        (other,) = (one for one in self.engine.methods if one.name == self.other)
        return model.simulate(case, other, step, times)

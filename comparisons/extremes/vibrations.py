"""Free vibrations of a small amplitude, by runs of an engine and by amplification matrices.

About a state of rest, without forces and dampers, in the shape of the mode that a method bears
least. A run counts as unstable if an observable comes to `GROWTH` times the size that it really
has, or if the guard stops it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from ...reference import get_scene
from ...reference.amplification import AMPLIFICATION, DEFECT, GROWTH, first_order, spectral_radius
from ...reference.differences import by_complex_step
from ...reference.errors import EngineError
from ...reference.scene import Array, Case
from ..checks.free_vibrations import START, Critical, Place, critical, places
from ..engines.setup import Setup
from ..scenes.extremes import FreeVibration

PERIODS = 20
"""Of the limiting mode, over which a vibration must stay bounded."""

AMPLITUDE = 1e-7
"""Of the start (m, rad): what is not linear in it lies far below what a bisection resolves. A soft
closure hardens within MuJoCo's ``width`` of 1e-3 m."""

SEEN = 256
"""Times at which a run is looked at, at most."""

BEYOND = 1.02
"""Steps beyond its limit that show which mode a scheme bears least."""


def free_case(scene_name: str, free: FreeVibration, model: str, **changes: Any) -> Case:
    """Return a scene without forces and dampers."""
    scene = get_scene(scene_name)
    p = scene.unforced(scene.parameters()).replace(**free.undamped)
    p = p.replace(**{**free.of_models.get(model, {}), **changes})
    return Case(scene_name, "free_vibration", p, {})


@dataclass(frozen=True)
class Vibration:
    """A mode about a state of rest, and how it starts.

    Attributes
    ----------
    setup : Setup
    at : Place
    mode : Critical
    departure : array (2 n,)
        Of the model equations' state from rest, at the start.
    """

    setup: Setup
    at: Place
    mode: Critical
    departure: Array

    @property
    def case(self) -> Case:
        """The case that starts off a state of rest as the vibration does."""
        setup, own = self.setup, self.setup.equations.scene
        values = dict(zip(own.state_names, (self.at.state + self.departure).tolist(), strict=True))
        if own is setup.scene or setup.scene.discretisation_coordinates:
            return replace(setup.case, state=values)
        # a soft loop: the scene's own coordinates, and how far the others are from closing it
        names = setup.scene.state_names
        case = replace(setup.case, state={name: values[name] for name in names})
        closed = dict(zip(own.state_names, setup.equations.start(case).tolist(), strict=True))
        apart = {name: values[name] - closed[name] for name in values if name not in names}
        return replace(case, inconsistency=apart)

    @cached_property
    def measure(self) -> Measure:
        """What is looked at.

        Where something is free to drift, angles that turn do with what rounding gives their
        speed, and only their rates are looked at.
        """
        at, equations, scene = self.at, self.setup.equations, self.setup.scene
        drifting = scene.rotations_per_period if np.any(at.rates == 0) else ()
        known = set(equations.scene.observables) - set(drifting)
        names = tuple(name for name in scene.observables if name in known)

        def observe(states: Any) -> Any:
            values = equations.scene.observe(states, equations.parameters)
            return np.array([np.broadcast_to(values[name], states.shape[1:]) for name in names])

        rest, slopes = by_complex_step(observe, at.state)
        matrix = first_order(at.matrices)[np.ix_(self.rows, self.rows)]
        advance = expm(matrix * (2 * np.pi / fastest_rate(at) / 16))
        x, size = self.departure, np.abs(slopes @ self.departure)
        for _ in range(32):
            x = advance @ x
            size = np.maximum(size, np.abs(slopes @ x))
        return Measure(names, rest, slopes, size)

    @property
    def rows(self) -> list[int]:
        """Rows of the matrices' states that are the model's, a drive's left out."""
        n, width = len(self.departure) // 2, len(self.at.coordinates)
        return [*range(n), *range(width, width + n)]

    def by_run(self, step: float, horizon: float) -> float:
        """Run the engine and return the largest departure, in the size that it really has.

        Raises
        ------
        EngineError
            Of the engine or the guard.
        """
        run = self.setup.with_case(self.case).simulate(step, step_numbers(step, horizon))
        return self.measure.largest(run.matrix(self.measure.names) - self.measure.rest[:, None])

    def by_matrix(self, scheme: str, step: float, horizon: float) -> float:
        """Return the largest departure by a scheme's amplification matrix."""
        matrices = self.at.matrices
        matrix = AMPLIFICATION[scheme](matrices, step)
        width, x = len(self.at.coordinates), np.zeros(len(matrix))
        x[self.rows] = self.departure
        if len(matrix) > 2 * width:  # generalized-alpha carries accelerations
            x[2 * width :] = (first_order(matrices) @ x[: 2 * width])[width:]
        numbers = step_numbers(step, horizon)
        with np.errstate(all="ignore"):
            advance = np.linalg.matrix_power(matrix, int(numbers[0]))
            states = (advance @ x)[:, None]
            while states.shape[1] < len(numbers):  # twice as many each time
                states = np.hstack([states, advance @ states])
                advance = advance @ advance
            return self.measure.largest(self.measure.slopes @ states[self.rows, : len(numbers)])

    def grows_in_run(self, step: float, horizon: float) -> bool:
        """Run the engine and tell whether the vibration grows, or the guard stops it.

        Raises
        ------
        EngineError
            ``step``, where the engine refuses it.
        """
        try:
            return self.by_run(step, horizon) > GROWTH
        except EngineError as error:
            if error.kind == "step":
                raise
            return True


class Measure(NamedTuple):
    """What is looked at: observables, linear in the departure, and the size that they have."""

    names: tuple[str, ...]
    rest: Array
    slopes: Array
    size: Array

    def largest(self, values: Array) -> float:
        """Return the largest departure (names, n_t) of an observable, in the size that it has."""
        size = np.where(self.size > 1e-6 * np.max(self.size), self.size, np.inf)
        if not np.all(np.isfinite(values)):
            return np.inf
        with np.errstate(all="ignore"):
            return float(np.max(np.abs(values) / size[:, None]))


def fastest_rate(at: Place) -> float:
    """Return the largest modulus of the eigenvalues about a place [1/s]."""
    return float(np.max(np.abs(at.rates)))


def vibration(setup: Setup, scheme: str, step: float | None = None) -> Vibration:
    """Return the vibration that a scheme bears least, at a step or at its limit."""
    everywhere = places(setup, scheme)
    at = max([at for at in everywhere if at.name != START] or everywhere, key=fastest_rate)
    fastest = fastest_rate(at)
    if step is None:
        step = step_limit(scheme, at, PERIODS * 2 * np.pi / fastest)
    n, width = len(setup.equations.scene.coordinates), len(at.coordinates)
    if np.isfinite(step) and spectral_radius(scheme, at.modes, BEYOND * step) > 1 + DEFECT:
        values, vectors = np.linalg.eig(AMPLIFICATION[scheme](at.matrices, BEYOND * step))
        mode = critical(scheme, at, BEYOND * step)
        shape = vectors[:, np.argmax(np.abs(values))].real
        shape = np.concatenate([shape[:n], shape[width : width + n]])
    else:
        values, vectors = np.linalg.eig(first_order(at.matrices))
        row = int(np.argmax(np.abs(values) * (values.imag >= 0)))
        place = int(np.argmax(np.abs(vectors[:width, row])))
        mode = Critical(float(abs(values[row])), at.coordinates[place])
        shape = np.concatenate([(vectors[:n, row] / vectors[place, row]).real, np.zeros(n)])
    size = max(np.max(np.abs(shape[:n])), np.max(np.abs(shape[n:])) / fastest)
    return Vibration(setup, at, mode, AMPLITUDE * shape / size)


def step_numbers(step: float, horizon: float) -> NDArray[np.int_]:
    """Return at which steps a run is looked at: evenly spread, at most `SEEN`."""
    count = max(2, math.ceil(horizon / step))
    every = math.ceil(count / SEEN)
    return every * np.arange(1, count // every + 1)

"""The periodic orbit of an engine: Newton's method on the period map that it computes.

An orbit is sought with a whole number of steps per period, so that the engine's discrete
flow itself closes; it differs from the true orbit by the error of the engine's method.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...reference.errors import NoOrbitError, UsageError
from ...reference.orbits import Orbit, find_orbit, state_scale, trivial_multiplier, turn
from ...reference.scene import Array, Scene
from ..engines.setup import Setup

STENCIL = ((-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12))
"""Central difference of order 4: (place, weight)."""

PERTURBATION = 2e-4
"""Step of that difference, in the size of each state on the orbit.

Rounding of a period map, 1e-14 of the states, is divided by the step; truncation grows with
its fourth power times fifth derivatives of the map, 1e4 on the hula hoop's orbit. Both are
then below 1e-10 and nearly equal (measured: 4e-11 with RK4 and RK67 at small steps).
"""

CLOSED = 1e-9
"""Largest Newton correction, in the size of each state, of an orbit that counts as found."""

MOST_ITERATIONS = 20
LARGEST_CORRECTION = 0.1
"""Of the size of each state; longer Newton corrections are shortened to it."""

FEWEST_STEPS = 16
"""Steps per period below which the harmonics up to order 6 cannot be told apart."""


@dataclass(frozen=True)
class EngineOrbit:
    """A periodic orbit as an engine computes it.

    Attributes
    ----------
    period : float [s]
    step : float
        The period divided by the number of steps [s].
    state : array (2 n,)
        Where the period begins, turning coordinates in [0, 2 pi).
    multipliers : complex array (2 n,)
        Floquet multipliers of the engine's period map, descending in modulus.
    monodromy : array (2 n, 2 n)
        Jacobian of the engine's period map, by differences.
    samples : array (2 n, n_steps)
        States at every step of one period, its end left out.
    trivial : int or None
        Which multiplier is that of a shift in time.
    """

    period: float
    step: float
    state: Array
    multipliers: Any
    monodromy: Array
    samples: Array
    trivial: int | None


@dataclass(frozen=True)
class PeriodMap:
    """An engine's flow over one period, from t = 0.

    Attributes
    ----------
    engine : Adapter
    case : Case
        Gives parameters; its state is not used.
    model : str
    method : Method
    period : float [s]
    steps : int
        Steps per period.
    """

    setup: Setup
    period: float
    steps: int

    @property
    def scene(self) -> Scene:
        """The scene of the case."""
        return self.setup.scene

    @property
    def step(self) -> float:
        """Step [s]."""
        return self.period / self.steps

    def states(self, start: Array, numbers: NDArray[np.int_]) -> Array:
        """Return states (2 n, k) after these numbers of steps from a state (2 n,)."""
        names = self.scene.state_names
        state = dict(zip(names, map(float, start), strict=True))
        case = replace(self.setup.case, state=state, start_time=0.0)
        return self.setup.with_case(case).simulate(self.step, numbers).matrix(names)

    def __call__(self, start: Array) -> Array:
        """Return the state (2 n,) one period after a state."""
        return self.states(start, np.array([self.steps]))[:, 0]

    def samples(self, start: Array) -> Array:
        """Return states (2 n, n_steps) at every step of a period, its end left out."""
        return self.states(start, np.arange(self.steps))

    def jacobian(self, state: Array, scale: Array) -> Array:
        """Return d map_i / d state_j (2 n, 2 n) by central differences of order 4.

        Parameters
        ----------
        state : array (2 n,)
        scale : array (2 n,)
            Size of each state.
        """
        columns = []
        for unit, size in zip(np.eye(len(state)), PERTURBATION * scale, strict=True):
            slope = [w * self(state + place * size * unit) for place, w in STENCIL]
            columns.append(np.sum(slope, axis=0) / size)
        return np.array(columns).T


def steps_per_period(setup: Setup, period: float) -> int:
    """Return the number of steps in a period [s], from the setup's step or by default.

    Raises
    ------
    UsageError
        If the step does not divide the period, or is too long.
    """
    step = setup.step
    if step is None:
        return max(FEWEST_STEPS, int(np.ceil(period / setup.default_step)))
    ratio = period / step
    count = round(ratio)
    if count < FEWEST_STEPS:
        raise UsageError(
            f"step {step:.12g} s is too long for an orbit of period {period:.12g} s; "
            f"the longest that serves is {period / FEWEST_STEPS!r}"
        )
    if abs(ratio - count) > 1e-9 * count:
        low = int(np.floor(ratio))
        raise UsageError(
            f"step {step:.12g} s does not divide the period {period:.12g} s; the nearest that "
            f"do are {period / low!r} and {period / (low + 1)!r}"
        )
    return count


def find_engine_orbit(setup: Setup) -> EngineOrbit:
    """Find the periodic orbit of an engine, starting from that of the reference.

    Parameters
    ----------
    setup : Setup
        The state of its case is not used; its step is a whole fraction of the period.

    Raises
    ------
    NoOrbitError
        If reference or engine has none.
    EngineError
        If a run of the engine failed.
    UsageError
        If the step does not divide the period.
    """
    scene = setup.scene
    known = find_orbit(scene, setup.case.parameters)
    flow = PeriodMap(setup, known.period, steps_per_period(setup, known.period))
    flow, state, monodromy = closed(flow, known)
    for row, name in enumerate(scene.coordinates):
        if name in scene.turning:
            state[row] %= 2 * np.pi
    multipliers = np.linalg.eigvals(monodromy).astype(complex)
    multipliers = multipliers[np.argsort(-np.abs(multipliers))]
    trivial = trivial_multiplier(scene, multipliers)
    return EngineOrbit(
        period=flow.period,
        step=flow.step,
        state=state,
        multipliers=multipliers,
        monodromy=monodromy,
        samples=flow.samples(state),
        trivial=None if trivial is None else int(trivial),
    )


def closed(flow: PeriodMap, known: Orbit) -> tuple[PeriodMap, Array, Array]:
    """Return the period map, the state (2 n,) that it closes on, and its Jacobian there.

    Where nothing drives the scene, the period changes with the length of the steps, and the
    section's coordinate stays.

    Raises
    ------
    NoOrbitError
        If Newton's method does not converge.
    """
    scene = flow.scene
    state = known.state
    scale = state_scale(scene, state, 2 * np.pi / known.period)
    advance = turn(scene)
    row = None if scene.section is None else scene.coordinates.index(scene.section)
    for _ in range(MOST_ITERATIONS):
        jacobian = flow.jacobian(state, scale)
        matrix = jacobian * scale / scale[:, None] - np.eye(len(state))
        if row is not None:
            ends = [
                (replace(flow, period=flow.period * (1 + place * PERTURBATION))(state), weight)
                for place, weight in STENCIL
            ]
            slope = np.sum([weight * end for end, weight in ends], axis=0)
            matrix[:, row] = slope / PERTURBATION / scale
        residual = (flow(state) - state - advance) / scale
        change = -np.linalg.lstsq(matrix, residual, rcond=None)[0]
        size = float(np.max(np.abs(change)))
        change *= min(1.0, LARGEST_CORRECTION / size if size else 1.0)
        if row is not None:
            flow = replace(flow, period=flow.period * (1 + float(change[row])))
            change[row] = 0.0
        state = state + change * scale
        if size < CLOSED:
            return flow, state, jacobian
    raise NoOrbitError(
        f"{flow.setup.engine.name} {flow.setup.integrator.name} has no periodic orbit of "
        f"{flow.scene.name} near the reference's with {flow.steps} steps per period; "
        "a smaller step may have one"
    )

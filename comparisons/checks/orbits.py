"""The periodic orbits of an engine: Newton's method on the period map that it computes.

An orbit is sought with a whole number of steps per period, so that the engine's discrete
flow itself closes; it differs from the true orbit by the error of the engine's method. Where
orbits lose their stability, Newton's method takes slopes from the reference's equations, which
secants mend, so that a point costs an engine the runs of one difference for each iteration.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np

from ...reference import get_scene
from ...reference.continuation.bifurcations import half_period_signs
from ...reference.continuation.tracing import Stepper, Tracer
from ...reference.differences import balanced_step
from ...reference.errors import EngineError, NoOrbitError, UsageError
from ...reference.newton import Effort, Rows
from ...reference.orbits import (
    Orbit,
    PeriodMap,
    find_orbit,
    period_advance,
    section_row,
    state_scale,
    trivial_multiplier,
    wrapped_rotations,
)
from ...reference.scene import Array, Case
from ..engines.setup import Setup, run_many, shortest_period
from .comparison import ORBIT_STEPS

EFFORT = Effort(jacobians=20)

ORDER = 4
PERTURBATION = balanced_step(ORDER, rounding=1e-14, roughness=1e4)
"""Step of the differences, in the size of each state on the orbit.

Rounding of a period map is 1e-14 of the states; its fifth derivatives are 1e4 on the hula hoop's
orbit. The error of both is then below 1e-10 (measured: 4e-11 with RK4 and RK67 at small steps).
"""

FEWEST_STEPS = 16
"""Steps per period needed to resolve the harmonics up to order 6."""


def engine_paths(
    setup: Setup, parameters: Sequence[Any], states: Array, steps: Array, times: Array
) -> tuple[Array, dict[int, str]]:
    """Follow many states through an engine, each with its parameters.

    Parameters
    ----------
    setup : Setup
        Its case and its step are not used.
    parameters : sequence of Parameters, k of them
    states : array (2 n, k)
        At the first of the times.
    steps : array (k,) [s]
    times : array (k, 1 + n_t) [s]

    Returns
    -------
    paths : array (2 n, k, n_t)
        At the other times; NaN where the engine failed.
    problems : dict
        Rows where it did, and how.
    """
    names, problems = setup.scene.state_names, {}
    paths = np.full((*states.shape, times.shape[1] - 1), np.nan)
    cases = [
        Case(setup.case.scene, "point", p, dict(zip(names, state, strict=True)), start_time=start)
        for p, state, start in zip(parameters, states.T.tolist(), times[:, 0].tolist(), strict=True)
    ]
    for row, result in enumerate(run_many(setup, cases, steps, times[:, 1:])):
        if isinstance(result, EngineError):
            problems[row] = str(result)
        else:
            paths[:, row] = result.matrix(names)
    return paths, problems


@dataclass
class EngineFlow:
    """An engine's flow over parts of a period, from t = 0.

    Attributes
    ----------
    setup : Setup
        Its case and its step are not used.
    steps : int
        Steps in a part: half a period of a symmetric scene, or else a period.
    problems : list of str
        Reasons of failed runs.
    """

    setup: Setup
    steps: int
    problems: list[str] = field(default_factory=list)

    def __call__(self, at: Any, states: Array, spans: Array, parts: int) -> Array:
        """Return states (2 n, k) that spans (k,) [s] of so many parts later."""
        p, _, rows = at
        here = [p.at(int(row)) for row in rows]
        ends = np.asarray(spans, dtype=float)
        times = np.stack([np.zeros_like(ends), ends], axis=1)
        paths, problems = engine_paths(self.setup, here, states, ends / (parts * self.steps), times)
        self.problems += problems.values()
        return paths[..., 0]


def engine_tracer(reference: Tracer, setup: Setup, per_period: int) -> tuple[Tracer, EngineFlow]:
    """Return a tracer of an engine's orbits, with so many steps in a period, and the flow."""
    halves = 1 if half_period_signs(reference.scene) is None else 2
    flow = EngineFlow(setup, per_period // halves)
    stepper = Stepper(flow, ORDER, PERTURBATION)
    return Tracer(reference.scene, reference.parameters, stepper, reference.steps), flow


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
        Index of the multiplier of a shift in time.
    """

    period: float
    step: float
    state: Array
    multipliers: Any
    monodromy: Array
    samples: Array
    trivial: int | None


@dataclass(frozen=True)
class WholeSteps:
    """An engine's flow from t = 0, a period of which has a whole number of steps.

    Attributes
    ----------
    setup : Setup
        The state of its case is not used.
    steps : int
        Steps per period.
    """

    setup: Setup
    steps: int

    def __call__(self, rows: Rows, states: Array, periods: Array) -> Array:
        """Return states (2 n, k) one period (k,) after states (2 n, k)."""
        end = np.array([self.steps])
        lanes = zip(states.T, periods, strict=True)
        return np.column_stack([self.states(start, period, end) for start, period in lanes])

    def states(self, start: Array, period: float, numbers: Rows) -> Array:
        """Return states (2 n, k) after these numbers of steps from a state (2 n,)."""
        names = self.setup.scene.state_names
        state = dict(zip(names, map(float, start), strict=True))
        setup = self.setup.with_case(replace(self.setup.case, state=state, start_time=0.0))
        return setup.simulate(float(period) / self.steps, numbers).matrix(names)

    def period_map(self, near: Orbit) -> PeriodMap:
        """Return the engine's period map about an orbit of the reference."""
        scene = self.setup.scene
        state, period = near.state[:, None], np.array([near.period])
        scale = state_scale(scene, state, 2 * np.pi / period)
        advance, section = period_advance(scene), section_row(scene)
        return PeriodMap(self, state, period, scale, advance, section, ORDER, PERTURBATION)


@lru_cache(maxsize=16)
def true_orbit(scene: str, parameters: Any) -> Orbit:
    """Return the periodic orbit of the reference."""
    return find_orbit(get_scene(scene), parameters)


def orbit_step(setup: Setup) -> float:
    """Return the longest step [s] that an orbit is followed with to begin with."""
    per_period = ORBIT_STEPS[min(setup.integrator.order, max(ORBIT_STEPS))]
    return min(shortest_period(setup.case) / per_period, setup.stable_step_bound / 2)


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


def find_engine_orbit(setup: Setup, effort: Effort = EFFORT) -> EngineOrbit:
    """Find the periodic orbit of an engine, starting from that of the reference.

    Parameters
    ----------
    setup : Setup
        The state of its case is not used; its step is a whole fraction of the period.
    effort : Effort

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
    flow = WholeSteps(setup, steps_per_period(setup, known.period))
    orbits = flow.period_map(known).close(effort)
    if not orbits.closed[0]:
        raise NoOrbitError(
            f"{setup.engine.name} {setup.integrator.name} has no periodic orbit of {scene.name} "
            f"near the reference's with {flow.steps} steps per period; a smaller step may have one"
        )
    state = wrapped_rotations(scene, orbits.states[:, 0])
    period, multipliers = float(orbits.periods[0]), orbits.multipliers[:, 0]
    trivial = trivial_multiplier(scene, multipliers)
    return EngineOrbit(
        period=period,
        step=period / flow.steps,
        state=state,
        multipliers=multipliers,
        monodromy=orbits.monodromy[0] * orbits.scale / orbits.scale.T,
        samples=flow.states(state, period, np.arange(flow.steps)),
        trivial=None if trivial is None else int(trivial),
    )

"""``simulate``: a trajectory of a scene, by the reference or by an engine."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np

from ...reference import get_scene
from ...reference.cost import expected_end, keep_steps
from ...reference.equations import ModelEquations
from ...reference.errors import EngineError, UnknownNameError, UsageError
from ...reference.scene import Array, Case
from ...reference.solve.single import solve
from ...reference.solve.solution import Solution, sample_times
from ..checks.rules.cautions import Caution, cautions, explained
from ..checks.truth import truncated, truth_of
from ..documents import document
from ..documents.fields import takes_fields_of
from ..engines.registry import REFERENCE
from ..engines.run import VIOLATIONS, grid_indices
from ..engines.setup import Setup, run
from .query import Origin, described, floats, seconds_of_a_step
from .request import SimulateRequest

VIOLATION_UNITS = dict(zip(VIOLATIONS, ("m", "m/s"), strict=True))

SHORTEST_STEP = 1 / 1024
"""Times that need a step below this share of the default step have no common spacing."""

SHORTEST_RUN = 1e-150
"""Shortest run [s]; the squares of its steps would be too small for numbers."""

MOST_STEPS = 10**8
"""A default step that needs more steps is refused, since the run would take hours; a step that the
user gives may need more."""

RATIONAL = 8 * float(np.finfo(float).eps)
"""Relative distance within which a time is taken for a rational number."""


@dataclass(frozen=True)
class Simulation(Origin):
    """A trajectory, with the settings that repeat it.

    Attributes
    ----------
    step : float or None
        fixed step [s]; null for the reference, whose error control chooses its steps
    times : array (n_t,)
        sample times [s], increasing
    observables : mapping of str to array (n_t,)
        values at `times`: every state (coordinates and their `_dot`; the internal ones of a
        continuum, which differ between models, only on request), the usual outputs of the scene,
        those of `--observe`, and `position_violation`, `velocity_violation` of an engine's model
        with closed loops; null from `lost_from` on
    units : mapping of str to str
        of the observables
    error_bound : mapping of str to float, or None
        bound on the error of each observable, in its unit, the largest over the times before
        `lost_from`; null for an engine, which states none, and where all is lost
    work : mapping
        cost of the run: `steps` that the engine counted; `rhs_evaluations` of the forces, null if
        the engine does not count them; `seconds` of wall time
    cautions : tuple of Caution
        warnings of rules from case, model, method and step alone, also on standard error; empty for
        the reference
    lost_from : float or None
        first of the times [s] at which the motion is unknown: round-off and the error of the method
        have grown to its size; null if there is none
    """

    method: str
    step: float | None
    times: Array
    observables: Mapping[str, Array]
    units: Mapping[str, str]
    error_bound: Mapping[str, float] | None
    work: Mapping[str, float | None]
    cautions: tuple[Caution, ...] = ()
    lost_from: float | None = None

    @property
    def lost(self) -> str:
        """The loss of the motion to round-off, in words; empty if there is none."""
        if self.lost_from is None:
            return ""
        return (
            f"lost from t = {self.lost_from:.10g} s: round-off has grown to the "
            "size of the motion, and no numbers are given from there on"
        )

    def as_json(self) -> dict[str, Any]:
        """Return the ``simulate`` document of docs/json.md."""
        return document("simulate", self)


@takes_fields_of(SimulateRequest)
def simulate(asked: SimulateRequest) -> Simulation:
    """Simulate a scene from t = 0; takes the fields of `SimulateRequest`.

    Raises
    ------
    UsageError
        For unknown names, impossible values, or times off the engine's grid.
    EngineError
        If the engine failed.
    """
    setup = asked.setup()
    names, times = wanted_observables(setup.case, asked.observe), times_array(asked.times)
    if setup.engine.name == REFERENCE:
        return reference_simulation(setup, times, names)
    return engine_simulation(setup, times, names, "all" in asked.observe)


def wanted_observables(case: Case, observe: Sequence[str]) -> tuple[str, ...]:
    """Return the scene's observables, and the requested outputs.

    Raises
    ------
    UnknownNameError
        If the scene has no such output.
    """
    scene = get_scene(case.scene)
    known = tuple(name for name in scene.units if name not in scene.observables)
    for name in observe:
        if name not in (*scene.units, "all"):
            raise UnknownNameError(f"output of {case.scene}", name, (*known, "all"))
    more = known if "all" in observe else tuple(name for name in known if name in observe)
    return (*scene.observables, *more)


def reference_simulation(setup: Setup, times: Array, names: tuple[str, ...]) -> Simulation:
    """Return the reference's solution of a case with its error bound."""
    case, equations = setup.case, setup.bound.equations
    state = tuple(equations.scene.state(case.state))

    def solved(one: ModelEquations, at: tuple[float, ...], times: Array) -> Solution:
        with expected_end(float(times[-1])):
            return solve(one.scene, one.parameters, np.array(at), times, case.start_time)

    begin = perf_counter()
    solution = solved(equations, state, times)
    seconds = perf_counter() - begin
    sure = solution.before_lost
    values, bound = np.full((len(names), len(times)), np.nan), None

    if sure.times.size:
        again = partial(solved, times=sure.times)
        truth = truncated(equations, state, truth_of(equations, sure, names), names, again)
        values[:, : sure.times.size] = truth.values
        bound = floats(dict(zip(names, truth.bound, strict=True)))
    work = {"steps": solution.steps, "rhs_evaluations": solution.rhs_evaluations}
    return Simulation(
        **described(setup),
        method=setup.integrator.name,
        step=None,
        times=times,
        observables=dict(zip(names, values, strict=True)),
        units=units_of(case, names),
        error_bound=bound,
        work={**work, "seconds": seconds},
        lost_from=solution.lost_from,
    )


def engine_simulation(
    setup: Setup, times: Array, names: tuple[str, ...], complete: bool
) -> Simulation:
    """Run a case with an engine; ``complete`` accepts any missing observables.

    Raises
    ------
    UsageError
        If times lie off the grid, or the engine lacks a requested observable.
    EngineError
        If the engine failed.
    """
    case = setup.case
    step = step_for(times, setup.default_step) if setup.step is None else setup.step
    setup = setup.with_step(step)
    grid = grid_indices(times, case.start_time, step) * step
    # the guard of clocks distinguishes round-off from times off the grid: engines get the grid
    times = np.where(np.abs(grid - times) <= RATIONAL * times, times, grid)
    beforehand = cautions(setup, float(grid[-1]))
    try:
        keep_steps(grid[-1] / step, lambda: seconds_of_a_step(setup))
        trajectory = run(setup, grid)
    except EngineError as error:
        raise EngineError(error.kind, explained(error.message, beforehand)) from error
    values = trajectory.values
    missing = [name for name in names if name not in values]
    if missing and not complete:
        raise UsageError(
            f"{setup.engine.name} does not return {', '.join(missing)} of {case.scene}; the "
            "reference does"
        )
    observables = {name: values[name] for name in (*names, *VIOLATIONS) if name in values}
    return Simulation(
        **described(setup),
        method=setup.integrator.name,
        step=step,
        times=times,
        observables=observables,
        units=units_of(case, observables),
        error_bound=None,
        work={
            "steps": trajectory.steps,
            "rhs_evaluations": trajectory.rhs_evaluations,
            "seconds": trajectory.seconds,
        },
        cautions=tuple(beforehand),
    )


def units_of(case: Case, names: Iterable[str]) -> dict[str, str]:
    """Return the units of observables, residuals of closed loops included."""
    units = VIOLATION_UNITS | dict(get_scene(case.scene).units)
    return {name: units[name] for name in names}


# Sample times, and the step on whose grid they lie


def times_array(times: Iterable[float]) -> Array:
    """Return sample times as an array (n_t,).

    Raises
    ------
    UsageError
        If they are not numbers in one row, finite, increasing and not negative, the last
        positive.
    """
    try:
        row = np.asarray(times, dtype=float)
    except (TypeError, ValueError):
        raise UsageError("sample times must be numbers") from None
    if row.ndim != 1:
        raise UsageError("sample times must be one row of numbers")
    row = sample_times(row, 0.0)
    if row[-1] < SHORTEST_RUN:
        raise UsageError(
            f"nothing to simulate: the last sample time must be {SHORTEST_RUN:g} s or more"
        )
    return row


def step_for(times: Array, longest: float) -> float:
    """Return the longest step [s], up to a limit, on whose grid from 0 all times lie.

    Raises
    ------
    UsageError
        If the common spacing of the times is far shorter, or steps are too many.
    """
    if not times[-1] / MOST_STEPS <= longest:
        raise UsageError(
            f"the fastest motion here needs steps of {longest:.3g} s, more than "
            f"{MOST_STEPS:.0e} of them; choose other parameters, a shorter run, or give the step"
        )
    spacing = common_spacing(times)
    step = float(spacing / math.ceil(spacing / longest))
    if step < SHORTEST_STEP * longest:
        raise UsageError(
            f"these times need a step of {step:.3g} s, far shorter than the method's "
            f"{longest:.3g} s; choose times on a coarser grid, or give the step"
        )
    return step


def common_spacing(times: Array) -> Fraction:
    """Return the greatest common divisor of times taken as rational numbers."""
    exact = [rational(float(time)) for time in times]
    unit = math.lcm(*(time.denominator for time in exact))
    return Fraction(math.gcd(*(int(time * unit) for time in exact)), unit)


def rational(value: float) -> Fraction:
    """Return a rational number of small denominator that rounds to a value."""
    exact = Fraction(value)
    for digits in range(1, 16):
        near = exact.limit_denominator(10**digits)
        if abs(near - exact) <= RATIONAL * exact:
            return near
    return exact

"""A reference that can be trusted at an extreme: two integrators that share nothing must agree.

The one is `reference.solve.single.solve`: DOP853, or Gauss collocation where vibrations or decays
are stiff. The other is LSODA, a multistep method (Adams, or backward differentiation where that is
cheaper), or Radau's of order 5 for a continuum.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import LSODA, Radau, solve_ivp

from ...reference.differences import by_complex_step
from ...reference.errors import MbcheckError
from ...reference.scene import Array, Case, Dynamics
from ...reference.solve.single import solve
from ...reference.solve.solution import Solution, state_size
from ..checks.tolerances import CAP
from ..checks.truth import VIBRATION_GROWTH, Truth, truncated, truth_of
from ..engines.equations import ModelEquations

TOLERANCES = {LSODA: (1e-11, 1e-9), Radau: (1e-8, 1e-6)}
"""Relative tolerances of the two runs of the second integrator: the answer, and its check."""

STIFF = 3e3
"""Decay rate times horizon from which explicit methods take longer than implicit ones."""

GAUSS_TOLERANCES = (1e-11, 1e-9)
"""Relative tolerances of Gauss collocation where it stands in for DOP853."""

AGREED = 1e-9
"""Relative difference of two integrators that needs no explanation."""

SHARPEST = CAP / 50
"""Largest relative bound of a reference that still judges."""

LONGEST, LONGEST_IMPLICIT = 1e3, 2e4
"""Vibration [rad] over a horizon that both integrators follow in some seconds; more of it where
they are implicit, and the fastest modes hardly move."""

PERTURBATION = 1e-7
"""Relative change of the start by which the growth of errors is measured."""


class UncertifiedError(MbcheckError):
    """No reference can be certified here."""


class Certified(NamedTuple):
    """A reference that two integrators agree on.

    Attributes
    ----------
    truth : Truth
        Its bound counts what the two differ by.
    bound, routes : float
        That bound, and this difference, relative to the sizes of the quantities, the largest.
    growth : float
        What a small error of the start grows to over the run, in the sizes of the states.
    """

    truth: Truth
    bound: float
    routes: float
    growth: float


class InitialValueProblem(NamedTuple):
    """An initial value problem, and what is wanted of its solution.

    Attributes
    ----------
    equations : ModelEquations
    state : tuple of float
        At the start.
    start : float
        [s]
    times : tuple of float
        [s]
    names : tuple of str
        Observables.
    stiff : bool
        Whether something decays so fast that explicit methods take too long.
    """

    equations: ModelEquations
    state: tuple[float, ...]
    start: float
    times: tuple[float, ...]
    names: tuple[str, ...]
    stiff: bool

    @classmethod
    def of(
        cls, equations: ModelEquations, case: Case, times: Array, names: tuple[str, ...]
    ) -> InitialValueProblem:
        """Return the problem of a case."""
        start, state = case.start_time, tuple(equations.start(case).tolist())
        stiff = rates(equations, case)[0] * float(times[-1] - start) > STIFF
        return cls(equations, state, start, tuple(times.tolist()), names, stiff)


def jacobian(scene: Dynamics, parameters: Any, time: float, state: Array) -> Array:
    """Return the derivative (2 n, 2 n) of the rates by the state, by complex steps."""
    rate = scene.right_hand_side(parameters)
    return by_complex_step(lambda x: rate(np.full(len(state), time), x), state)[1]


def rates(equations: ModelEquations, case: Case) -> tuple[float, float]:
    """Return the fastest decay [1/s] and the fastest vibration [rad/s] of model equations.

    Linearised at the start, and with what turns in the case's scene turned by 90 degrees; a speed
    of rotation is a vibration too.
    """
    scene, start = equations.scene, equations.start(case)
    decay = vibration = 0.0
    for angle in (0.0, np.pi / 2):
        state = start.copy()
        for name in scene.rotations_per_period:
            state[scene.state_names.index(name)] += angle
        with np.errstate(all="ignore"):
            slopes = jacobian(scene, equations.parameters, case.start_time, state)
        if not np.all(np.isfinite(slopes)):
            continue
        eigenvalues = np.linalg.eigvals(slopes)
        decay = max(decay, float(np.max(-eigenvalues.real)))
        vibration = max(vibration, float(np.max(np.abs(eigenvalues.imag))))
    speeds = [
        abs(float(start[scene.state_names.index(f"{name}_dot")]))
        for name in scene.rotations_per_period
    ]
    return decay, max([vibration, *speeds])


def longest_horizon(case: Case, equations: ModelEquations) -> float:
    """Return the horizon [s] over which model equations can be model_solution in some seconds."""
    vibration = rates(equations, case)[1]
    longest = LONGEST_IMPLICIT if equations.scene.stiff else LONGEST
    return longest / vibration if vibration > 0 else np.inf


def model_solution(
    equations: ModelEquations, case: Case, times: Array, names: tuple[str, ...]
) -> Truth:
    """Return a solution with the bound of one integrator; remembered within a process.

    What predicts is not certified: what it predicts must agree with what is.

    Raises
    ------
    UncertifiedError
        If the integrator fails.
    """
    return _solved(InitialValueProblem.of(equations, case, times, names))[0]


@lru_cache(maxsize=64)
def _solved(problem: InitialValueProblem) -> tuple[Truth, Solution]:
    def first(one: ModelEquations, begin: tuple[float, ...]) -> Solution:
        implicit = problem.stiff and one.scene.stiff is None
        scene = replace(one.scene, stiff=GAUSS_TOLERANCES) if implicit else one.scene
        return solve(scene, one.parameters, np.array(begin), np.array(problem.times), problem.start)

    equations, state, names = problem.equations, problem.state, problem.names
    try:
        solution = first(equations, state)
        truth = truth_of(equations, solution, names)
        return truncated(equations, state, truth, names, first), solution
    except (MbcheckError, ValueError, np.linalg.LinAlgError) as error:
        raise UncertifiedError(f"no reference: {error}") from error


def certified(
    equations: ModelEquations, case: Case, times: Array, names: tuple[str, ...]
) -> Certified:
    """Return a solution that two integrators agree on; remembered within a process.

    Raises
    ------
    UncertifiedError
        If an integrator fails, or the two differ by more than their bounds or `SHARPEST` allows.
    """
    return _certified(InitialValueProblem.of(equations, case, times, names))


@lru_cache(maxsize=64)
def _certified(problem: InitialValueProblem) -> Certified:
    truth, solution = _solved(problem)
    other = second(problem, np.array(problem.state))
    size = state_size(solution)
    apart = np.max(np.abs(solution.states - other.states), axis=1)
    routes = float(np.max(apart / size))
    bound = float(np.max((solution.error_bound + other.error_bound) / size))
    if not (routes <= max(bound, AGREED) and bound <= SHARPEST):
        raise UncertifiedError(
            f"two integrators differ by {routes:.2g} of the size of the states, with bounds of "
            f"{bound:.2g}: no reference is certified here"
        )
    between = truth_of(problem.equations, replace(solution, error_bound=apart), problem.names)
    truth = replace(truth, bound=truth.bound + between.bound)
    bound = float(np.max(truth.bound / truth.size))
    return Certified(truth, bound, routes, growth(problem, solution))


def second(problem: InitialValueProblem, state: Array) -> Solution:
    """Return the solution from a state by the second integrator.

    Its bound is the change from a tolerance.
    """
    scene, parameters = problem.equations.scene, problem.equations.parameters
    derivative, times = scene.right_hand_side(parameters), np.array(problem.times)
    method = Radau if scene.stiff else LSODA
    span = float(times[-1] - problem.start)
    n = len(state) // 2

    def slopes(t: float, x: Array) -> Array:
        return jacobian(scene, parameters, t, x)

    def sized(values: Array, unit: float) -> Array:
        scale = np.max(np.abs(values), axis=1)
        scale[n:] = np.maximum(scale[n:], scale[:n] / span)
        return np.where(scale > 0, scale, unit)

    def integrated(rtol: float, atol: Array) -> Any:
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # LSODA's, of failures that it also returns
            where = derivative, (problem.start, times[-1]), state, method, times
            result = solve_ivp(*where, rtol=rtol, atol=atol, jac=slopes)
        if not result.success or not np.all(np.isfinite(result.y)):
            raise UncertifiedError(f"the second integrator fails: {result.message}")
        return result

    rough = sized(state[:, None], 1e-9)
    scale = sized(np.column_stack([integrated(1e-6, 1e-6 * rough).y, state]), 1.0)
    fine, check = (integrated(rtol, rtol * scale) for rtol in TOLERANCES[method])
    difference = np.max(np.abs(fine.y - check.y), axis=1)
    worst = float(np.max(difference / scale))  # a state that passes through 0 is no better
    return Solution(times, fine.y, np.maximum(difference, worst * scale / 3), 0, fine.nfev)


def growth(problem: InitialValueProblem, solution: Solution) -> float:
    """Return what a change of the start grows to, in the sizes of the states.

    Of a continuum the constant that `checks.truth` takes.
    """
    if problem.equations.scene.discretisation_coordinates:
        return VIBRATION_GROWTH
    size = state_size(solution)
    signs = np.where(np.arange(len(size)) % 2, -1.0, 1.0)
    try:
        states = second(problem, np.array(problem.state) + PERTURBATION * size * signs).states
    except UncertifiedError:
        return np.inf
    return max(1.0, float(np.max(np.abs(states - solution.states) / size[:, None])) / PERTURBATION)

"""A reference that can be trusted at an extreme: two integrators that share nothing must agree.

The one is `reference.solve.single`: DOP853, or Gauss collocation where vibrations or decays are
stiff. The other is LSODA, a multistep method (Adams, or backward differentiation where that is
cheaper), or Radau's of order 5 for a continuum.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import LSODA, Radau, solve_ivp

from ...reference.errors import MbcheckError
from ...reference.scene import Array, Case, EquationsOfMotion
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

NUDGE = 1e-7
"""Relative change of the start by which the growth of errors is measured."""

PROBE = 1e-40
"""Complex step of Jacobians."""


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


def jacobian(scene: EquationsOfMotion, parameters: Any, time: float, state: Array) -> Array:
    """Return the derivative (2 n, 2 n) of the rates by the state, by complex steps."""
    lanes = np.repeat(np.asarray(state, dtype=complex)[:, None], len(state), axis=1)
    lanes[np.arange(len(state)), np.arange(len(state))] += 1j * PROBE
    slopes = scene.right_hand_side(parameters)(np.full(len(state), time), lanes)
    return np.asarray(slopes.imag / PROBE)


def rates(own: ModelEquations, case: Case) -> tuple[float, float]:
    """Return the fastest decay [1/s] and the fastest vibration [rad/s] of a claim.

    Of its equations linearised at the start, and with what turns in the case's scene turned by 90
    degrees; a speed of rotation is a vibration too.
    """
    start = own.start(case)
    decay = vibration = 0.0
    for turn in (0.0, np.pi / 2):
        state = start.copy()
        for name in own.scene.rotations_per_period:
            state[own.scene.state_names.index(name)] += turn
        with np.errstate(all="ignore"):
            slopes = jacobian(own.scene, own.parameters, case.start_time, state)
        if not np.all(np.isfinite(slopes)):
            continue
        found = np.linalg.eigvals(slopes)
        decay = max(decay, float(np.max(-found.real)))
        vibration = max(vibration, float(np.max(np.abs(found.imag))))
    turning = [f"{name}_dot" for name in own.scene.rotations_per_period]
    speeds = [abs(start[own.scene.state_names.index(name)]) for name in turning]
    return decay, max([vibration, *map(float, speeds)])


def longest_horizon(case: Case, own: ModelEquations) -> float:
    """Return the horizon [s] over which a claim's reference can be had in some seconds."""
    vibration = rates(own, case)[1]
    longest = LONGEST_IMPLICIT if own.scene.stiff else LONGEST
    return longest / vibration if vibration > 0 else np.inf


def is_stiff(own: ModelEquations, case: Case, times: Array) -> bool:
    """Return whether something decays so fast that explicit methods take too long."""
    return rates(own, case)[0] * float(times[-1] - case.start_time) > STIFF


def solved(own: ModelEquations, case: Case, times: Array, names: tuple[str, ...]) -> Truth:
    """Return a claim's solution with the bound of one integrator; remembered within a process.

    What predicts is not certified: what it predicts must agree with what is.

    Raises
    ------
    UncertifiedError
        If the integrator fails.
    """
    state = tuple(float(value) for value in own.start(case))
    where = case.start_time, tuple(map(float, times)), names
    return _solved(own, state, *where, is_stiff(own, case, times))[0]


@lru_cache(maxsize=64)
def _solved(
    own: ModelEquations,
    state: tuple[float, ...],
    start: float,
    times: tuple[float, ...],
    names: tuple[str, ...],
    stiff: bool,
) -> tuple[Truth, Solution]:
    def first(one: ModelEquations, begin: tuple[float, ...]) -> Solution:
        implicit = stiff and one.scene.stiff is None
        scene = replace(one.scene, stiff=GAUSS_TOLERANCES) if implicit else one.scene
        return solve(scene, one.parameters, np.array(begin), np.array(times), start)

    try:
        solution = first(own, state)
        return truncated(own, state, truth_of(own, solution, names), names, first), solution
    except (MbcheckError, ValueError, np.linalg.LinAlgError) as error:
        raise UncertifiedError(f"no reference: {error}") from error


def certified(own: ModelEquations, case: Case, times: Array, names: tuple[str, ...]) -> Certified:
    """Return a claim's solution that two integrators agree on; remembered within a process.

    Raises
    ------
    UncertifiedError
        If an integrator fails, or the two differ by more than their bounds or `SHARPEST` allows.
    """
    state = tuple(float(value) for value in own.start(case))
    where = case.start_time, tuple(map(float, times)), names
    return _certified(own, state, *where, is_stiff(own, case, times))


@lru_cache(maxsize=64)
def _certified(
    own: ModelEquations,
    state: tuple[float, ...],
    start: float,
    times: tuple[float, ...],
    names: tuple[str, ...],
    stiff: bool,
) -> Certified:
    at, begin = np.array(times), np.array(state)
    truth, solution = _solved(own, state, start, times, names, stiff)
    other = second(own, begin, at, start)
    size = state_size(solution)
    apart = np.max(np.abs(solution.states - other.states), axis=1)
    routes = float(np.max(apart / size))
    bound = float(np.max((solution.error_bound + other.error_bound) / size))
    if not (routes <= max(bound, AGREED) and bound <= SHARPEST):
        raise UncertifiedError(
            f"two integrators differ by {routes:.2g} of the size of the states, with bounds of "
            f"{bound:.2g}: no reference is certified here"
        )
    truth = replace(
        truth, bound=truth.bound + truth_of(own, replace(solution, error_bound=apart), names).bound
    )
    return Certified(
        truth=truth,
        bound=float(np.max(truth.bound / truth.size)),
        routes=routes,
        growth=growth(own, begin, at, start, solution),
    )


def second(own: ModelEquations, state: Array, times: Array, start: float) -> Solution:
    """Return the solution by the second integrator, its bound the change from a tolerance."""
    derivative = own.scene.right_hand_side(own.parameters)
    method = Radau if own.scene.stiff else LSODA
    span = float(times[-1] - start)
    n = len(state) // 2

    def slopes(t: float, x: Array) -> Array:
        return jacobian(own.scene, own.parameters, t, x)

    def sized(values: Array, unit: float) -> Array:
        scale = np.max(np.abs(values), axis=1)
        scale[n:] = np.maximum(scale[n:], scale[:n] / span)
        return np.where(scale > 0, scale, unit)

    def solved(rtol: float, atol: Array) -> Any:
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # LSODA's, of failures that it also returns
            where = derivative, (start, times[-1]), state, method, times
            found = solve_ivp(*where, rtol=rtol, atol=atol, jac=slopes)
        if not found.success or not np.all(np.isfinite(found.y)):
            raise UncertifiedError(f"the second integrator fails: {found.message}")
        return found

    rough = sized(state[:, None], 1e-9)
    scale = sized(np.column_stack([solved(1e-6, 1e-6 * rough).y, state]), 1.0)
    fine, check = (solved(rtol, rtol * scale) for rtol in TOLERANCES[method])
    difference = np.max(np.abs(fine.y - check.y), axis=1)
    worst = float(np.max(difference / scale))  # a state that passes through 0 is no better
    return Solution(times, fine.y, np.maximum(difference, worst * scale / 3), 0, fine.nfev)


def growth(
    own: ModelEquations, state: Array, times: Array, start: float, solution: Solution
) -> float:
    """Return what a change of the start grows to, in the sizes of the states.

    Of a continuum the constant that `prediction` takes.
    """
    if own.scene.discretisation_coordinates:
        return VIBRATION_GROWTH
    size = state_size(solution)
    signs = np.where(np.arange(len(state)) % 2, -1.0, 1.0)
    try:
        moved = second(own, state + NUDGE * size * signs, times, start).states
    except UncertifiedError:
        return np.inf
    return max(1.0, float(np.max(np.abs(moved - solution.states) / size[:, None])) / NUDGE)

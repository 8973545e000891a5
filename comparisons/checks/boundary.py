"""Check kind *stability* at a boundary: where an engine's orbits lose their stability.

With a fixed number of steps in a period the discrete flow of an engine has other periodic orbits,
whose multiplier comes to the unit circle at another parameter than that of the true orbits. This
shift is measured with h, h/2 and h/4, as all of *stability* is: the change between them predicts
it, and what the three extrapolate to must be the reference's point.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ...reference import get_scene
from ...reference.continuation.along import BoundaryAlong, ConnectionAlong
from ...reference.continuation.bifurcations import HOMOCLINIC
from ...reference.continuation.curve import correct
from ...reference.errors import CannotJudgeError, EngineError, NoOrbitError
from ...reference.parameters import BoundarySearch
from ...reference.scene import Array
from ..engines.run import EPS
from ..engines.setup import Setup
from .comparison import CAP, NEXT_ORDERS, ORBIT_REFINEMENTS, converging, richardson
from .orbits import engine_paths, engine_tracer, orbit_step
from .truth import rounding
from .verdict import Finding, Inconclusive

SETTLED = 0.25
"""Change of the order seen from one halving to the next below which it is another than declared."""


def quantities(setup: Setup) -> tuple[str, ...]:
    """Return the names of the quantities; none for a model with other equations than the scene."""
    same = setup.bound.is_exact and setup.bound.coordinates == setup.scene.coordinates
    return ("boundary", "extrapolated") if same else ()


@lru_cache(maxsize=16)
def true_boundary(scene: str, parameters: Any, point: BoundarySearch) -> BoundaryAlong:
    """Return where the orbits of the reference lose their stability."""
    if point.kind == HOMOCLINIC:
        return ConnectionAlong(get_scene(scene), parameters, *point)
    return BoundaryAlong(get_scene(scene), parameters, point.kind, point.parameter)


@dataclass(frozen=True)
class EnginePoint:
    """Point at which an engine's orbits lose stability, with a number of steps per period.

    Attributes
    ----------
    z : array (2 n + 2,)
        Unknowns; the place in the window is the last.
    bound : float
        What rounding and differences leave of the place, by differences of two steps.
    is_solved : bool
        Whether Newton's method has come there; else it is where its first step leads from the
        point of the reference.
    """

    z: Array
    bound: float
    is_solved: bool


def engine_point(setup: Setup, sought: BoundaryAlong, count: int, guess: Array) -> EnginePoint:
    """Return the point of an engine with so many steps in a period.

    Raises
    ------
    EngineError
        If it fails on the orbit of the reference.
    """
    if isinstance(sought, ConnectionAlong):
        return engine_connection(setup, sought, count, guess)
    reference, true = sought.solution
    tracer, flow = engine_tracer(reference, setup, count)
    curve = tracer.curve(sought.kind, 1)
    solved = correct(curve.equations, guess, sought.row, 0.0)
    try:
        if solved is not None:
            bound = tracer.rate(curve, solved)[0].bound
            return EnginePoint(solved.z, float(bound[1] + true.bound[1]), True)
        with np.errstate(all="ignore"):
            residual, jacobian = curve.equations.linearise(true.z)
            again = curve.values(tracer.second(curve), true.z[:, None])[0][:, 0]
        inverse = np.linalg.inv(np.vstack([jacobian, sought.row]))[:, :-1]
    except np.linalg.LinAlgError:  # what a run that failed has left
        again = np.full(1, np.nan)
    if not np.all(np.isfinite(again)):
        why = flow.problems[-1] if flow.problems else "the run returned no number"
        raise EngineError("boundary", f"on the reference's orbit: {why}")
    step, other = inverse @ residual, inverse @ again
    return EnginePoint(true.z - step, float(true.bound[1] + 2 * abs(step - other)[-1]), False)


def engine_connection(
    setup: Setup, sought: ConnectionAlong, count: int, guess: Array
) -> EnginePoint:
    """Return where the saddle has a homoclinic orbit by an engine, with so many steps along it.

    What steps round of the energy is what the parameter's work is off by, relative.

    Raises
    ------
    EngineError
        If it fails on the orbit of the reference.
    """
    known, true = sought.solution
    problems: list[str] = []

    def ends(p: Any, state: Array) -> Array:
        step, times = np.array([sought.span / count]), np.array([[0.0, sought.span]])
        paths, why = engine_paths(setup, [p], state[:, None], step, times)
        problems.extend(why.values())
        return np.asarray(paths[:, 0, 0])

    root = sought.root(ends, float(guess[-1]), known.slope)
    noise = rounding(count, 1.0, setup.epsilon) * abs(sought.here) / sought.unit
    bound = float(true.bound[1]) + noise
    if root is not None:
        return EnginePoint(np.array([0.5, root.place]), bound + root.change, True)
    gap = sought.gap(float(true.z[-1]), ends)
    if not np.isfinite(gap):
        why = problems[-1] if problems else "the run returned no number"
        raise EngineError("boundary", f"on the reference's orbit: {why}")
    return EnginePoint(true.z - np.array([0.0, gap / known.slope]), bound, False)


def measure(setup: Setup) -> list[Finding | Inconclusive]:
    """Find the engine's boundary with three steps, and compare.

    Raises
    ------
    CannotJudgeError
        If the reference has no such boundary near, or these steps are too long for it.
    """
    case, order = setup.case, setup.integrator.order
    assert case.boundary is not None
    if setup.epsilon > EPS:
        raise CannotJudgeError("numbers of 32 bits are too coarse for the slopes of a period")
    try:
        sought = true_boundary(case.scene, case.parameters, case.boundary)
        true = sought.solution[1]
    except NoOrbitError as none:
        raise CannotJudgeError(str(none)) from none
    first, points = 2 * int(np.ceil(sought.span / orbit_step(setup) / 2)), dict[int, EnginePoint]()
    ratios: list[float] = []
    for refinement in range(ORBIT_REFINEMENTS):
        count, guess = first * 2**refinement, true.z
        for number in (count, 2 * count, 4 * count):
            if number not in points:
                points[number] = engine_point(setup, sought, number, guess)
            guess = true.z + (points[number].z - true.z) / 2**order
        runs = [points[count * k] for k in (1, 2, 4)]
        solved = all(run.is_solved for run in runs)
        floor = sought.unit * max(run.bound for run in runs)
        estimate = richardson([np.array([sought.value(run.z[-1])]) for run in runs], order)
        shrinks = estimate.shrinks(floor)
        ratios.append(estimate.ratio)
        if shrinks and solved:
            break
    truth, here = (sought.value(point.z[-1]) for point in (true, runs[0]))
    unit = case.parameters.unit_of(sought.parameter)
    what, error = f"{sought.kind.replace('_', ' ')} over {sought.parameter}", abs(here - truth)
    note = (
        f"{what}, shifted by {shift(here - truth, unit)} with {count} steps {sought.where}; "
        f"halving divides the shift by {estimate.ratio:.3g}, {2**order} expected"
    )
    # rounding of two runs is in the limit, and weighs most where the order is low
    room = NEXT_ORDERS * float(estimate.moved[0]) + floor * (1 + 2 / (2**order - 1))
    limit = float(estimate.limit[0])
    off = abs(limit - truth)
    small = estimate.predicted <= CAP * abs(truth) and (solved or off > room)
    if shrinks and not small:
        why = "steps are too coarse: no such boundary nearby"
        if estimate.predicted <= CAP * abs(truth):
            why = "Newton's method does not converge: runs scatter, or steps are too coarse"
        raise CannotJudgeError(f"{why}: {note}")
    moving = len(ratios) > 1 and abs(np.log2(ratios[-1] / ratios[-2])) > SETTLED
    finding = Finding("boundary", unit, here, truth, error, 0.0, note)
    shifted = converging(finding, estimate, floor, shrinks, moving)
    if not estimate.is_regular(floor):
        silence = "shifts do not shrink with the declared order, so that nothing is extrapolated"
        return [shifted, Inconclusive("extrapolated", silence)]
    reason = f"{what}, extrapolated to h -> 0: shifted by {shift(limit - truth, unit)}"
    return [shifted, Finding("extrapolated", unit, limit, truth, off, room, reason)]


def shift(size: float, unit: str) -> str:
    """Return the shift of a boundary point in words."""
    return f"{size:.3g}" if unit == "1" else f"{size:.3g} {unit}"

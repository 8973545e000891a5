"""Kinds *parameters*, *starts* and *failures*: one run at an extreme against the reference.

Nothing is refused beforehand, and no part of the run is left out for its large error: the error of
a right run is at most that predicted by its method, step and model, and at most `LOST`.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ....reference.differences import by_complex_step
from ....reference.equations import ModelEquations, scene_equations
from ....reference.errors import CannotJudgeError, EngineError, MbcheckError, Unsupported
from ....reference.scene import Array, Case
from ....reference.solve.solution import run_sizes
from ...engines.run import VIOLATIONS
from ...engines.setup import Setup
from ..comparison import (
    CAP,
    RICHARDSON_SAFETY,
    SAFETY,
    VIOLATION,
    Measured,
    Part,
    ideal_rows,
    sample_numbers,
)
from ..rules.cautions import cautions, noticing_rules
from ..truth import VIBRATION_GROWTH, Truth, rounding, truth_to_the_end
from ..verdict import HALVING, REFERENCE, Finding

QUANTITY = "motion_error"

ORDER_SLACK = 0.5
"""Largest distance of the order shown by halved steps below the declared one."""

LOST = 2 * CAP
"""Relative errors above this are wrong, however well they are predicted; rules and halved steps
should warn from half of it on."""

FLOOR = 1e-9
"""Relative change under halved steps below which no order is measured."""

FEWEST = 4
"""Fewest steps over which a run can be judged."""

SAMPLES = 32

STIFF = 3e3
"""Decay rate times horizon from which explicit methods take longer than implicit ones."""

GAUSS_TOLERANCES = (1e-11, 1e-9)
"""Relative tolerances of Gauss collocation in place of DOP853."""

SHARPEST = CAP / 50
"""Largest relative bound of a reference by which a run is right."""

LONGEST, LONGEST_IMPLICIT = 1e3, 2e4
"""Vibration [rad] over a horizon that the reference follows in some seconds; more of it where its
method is implicit, and the fastest modes hardly move."""

PERTURBATION = 1e-7
"""Relative change of the start by which the growth of errors is measured."""


class Sampled(NamedTuple):
    """A setup, and the step numbers (n_t,) at which it is sampled."""

    setup: Setup
    samples: Any

    @classmethod
    def over(cls, setup: Setup, horizon: float) -> Sampled:
        """Return it sampled over a horizon [s]."""
        return cls(setup, sample_numbers(horizon, setup.step_size, SAMPLES))

    @property
    def times(self) -> Array:
        """Sample times [s]."""
        return np.asarray(self.setup.case.start_time + self.samples * self.setup.step_size)

    def values(self, division: int = 1) -> Array:
        """Run it, or with a fraction of the step, through the guard."""
        step = self.setup.step_size / division
        return self.setup.simulate(step, self.samples * division).matrix(
            self.setup.bound.observables
        )

    def solution(self, equations: ModelEquations, state: Array | None = None) -> Truth:
        """Return the solution of equations of motion, from the case's start or another state.

        Raises
        ------
        CannotJudgeError
            If there is none.
        """
        case, names = self.setup.case, self.setup.bound.observables
        state = equations.start(case) if state is None else state
        span = float(self.times[-1] - case.start_time)
        if equations.scene.stiff is None and rates(equations, case)[0] * span > STIFF:
            stiff = replace(equations.scene, stiff=GAUSS_TOLERANCES)
            equations = equations._replace(scene=stiff)
        try:
            return truth_to_the_end(equations, state, case.start_time, self.times, names)
        except (MbcheckError, ValueError, np.linalg.LinAlgError) as error:
            raise CannotJudgeError(f"not judged: no reference: {error}") from error


def quantities(setup: Setup) -> tuple[str, ...]:
    """Return the name of the measured quantity: the largest error of all observables."""
    return (QUANTITY,)


def measure(setup: Setup) -> Measured:
    """Run a case at an extreme with the setup's step, and judge the largest error of all."""
    case, step = setup.case, setup.step_size
    run = Sampled.over(setup, case.horizon)
    try:
        values = run.values()
    except EngineError as error:
        if error.kind != "raised" or builds(setup):
            raise
        raise Unsupported(f"the engine refuses: {error}") from error
    exact = scene_equations(case)
    reachable = longest_horizon(exact, case)
    if reachable < FEWEST * step:
        steps = f"{reachable / step:.2g} steps"
        raise CannotJudgeError(f"not judged: the reference can follow {reachable:.2g} s, {steps}")
    if reachable < case.horizon:
        run = Sampled.over(setup, reachable)
        values = run.values()
    right = run.solution(exact)
    model = right  # in place of model equations that are too stiff to be solved
    span = float(run.times[-1] - case.start_time)
    if not setup.bound.is_exact and span <= longest_horizon(setup.bound.equations, case):
        model = run.solution(setup.bound.equations)
    finding = compare_run(run, values, right, model)
    bound = float(np.max(right.bound / sizes(setup.bound.observables, right)))
    if finding.error <= finding.tolerance and not bound <= SHARPEST:
        raise CannotJudgeError(f"not judged: the reference may be off by {bound:.2g} of a size")
    return Measured([finding])


def builds(setup: Setup) -> bool:
    """Return True if the engine builds a model of the case at all."""
    state = setup.scene.state(setup.case.state)[None]
    try:
        setup.bound.mass_matrices(state)
    except MbcheckError:
        return True
    except Exception:  # whatever a foreign engine raises while it compiles
        return False
    return True


def compare_run(run: Sampled, values: Array, exact: Truth, model: Truth) -> Finding:
    """Compare a run with the reference, the model's own solution, and runs with halved steps."""
    setup, names = run.setup, run.setup.bound.observables
    size = sizes(names, exact)
    opening = np.array([name.endswith("_violation") for name in names])
    runs, failure = [values], ""
    for division in (2, 4):
        try:
            runs.append(run.values(division))
        except EngineError as failed:
            failure = f"with h/{division} the engine fails ({failed.kind})"
            break
    changes = [relative((a - b)[~opening], size[~opening]) for a, b in pairwise(runs)]
    errors_grow = growth(run, exact)
    room = rounding(int(run.samples[-1]), errors_grow)
    order = setup.integrator.order
    halving = failure or halving_shows(changes, order, max(FLOOR, 10 * room))
    if setup.scheme:
        ideal = ideal_rows(setup, [Part(setup.case, run.samples)], setup.step_size, names)
        integration = np.abs(ideal - model.values)
        safety = SAFETY
    else:  # what does not shrink as declared cannot be predicted
        integration, safety = 0 * values, RICHARDSON_SAFETY
        gain = 2**order - 1
        if not halving or (not failure and changes[0] > CAP / 2):
            change = np.abs(values - runs[1]) * (gain + 1) / gain
            integration = np.maximum.accumulate(change, axis=1)
    integration = integration + error_of_elements(run, values)
    off = np.abs(model.values - exact.values)
    away = np.abs(values - exact.values)
    allowed = safety * largest(integration) + largest(off) + exact.bound + model.bound
    allowed = allowed + np.where(opening, max(room, VIOLATION), room) * size
    error, predicted = (
        relative(one[~opening], size[~opening]) for one in (away, integration + off)
    )
    worst = int(np.argmax(largest(away) / allowed))
    most = float(largest(away)[worst] / size[worst])
    tolerance = float(allowed[worst] / size[worst]) if predicted < LOST else 0.0
    reason = (
        f"error {error:.2g}, predicted {predicted:.2g}, the largest share of its tolerance in "
        f"{names[worst]}; {halving or f'halving the step shows {changes[0]:.1g}, as it should'}; "
        f"errors of the start grow by {errors_grow:.3g}"
    )
    said = [] if most <= tolerance else cautions(setup, setup.case.horizon)
    noticed = (*noticing_rules(said), *((HALVING,) if halving else ()), REFERENCE)
    return Finding(QUANTITY, "1", most, 0.0, most, tolerance, reason, noticed_by=noticed)


# The reference ------------------------------------------------------------------------------


def rates(equations: ModelEquations, case: Case) -> tuple[float, float]:
    """Return the fastest decay [1/s] and the fastest vibration [rad/s] of model equations.

    Linearised at the start, and with what turns in the case's scene turned by 90 degrees; a speed
    of rotation is a vibration too.
    """
    scene, start = equations.scene, equations.start(case)
    rate, times = scene.right_hand_side(equations.parameters), np.full(len(start), case.start_time)
    turns = [scene.state_names.index(name) for name in scene.rotations_per_period]
    decay = vibration = 0.0
    for angle in (0.0, np.pi / 2):
        state = start.copy()
        state[turns] += angle
        with np.errstate(all="ignore"):
            slopes = by_complex_step(lambda x: rate(times, x), state)[1]
        if not np.all(np.isfinite(slopes)):
            continue
        eigenvalues = np.linalg.eigvals(slopes)
        decay = max(decay, float(np.max(-eigenvalues.real)))
        vibration = max(vibration, float(np.max(np.abs(eigenvalues.imag))))
    speeds = np.abs(start[len(start) // 2 :][turns])
    return decay, float(np.max(speeds, initial=vibration))


def longest_horizon(equations: ModelEquations, case: Case) -> float:
    """Return the horizon [s] over which equations can be solved in some seconds."""
    vibration = rates(equations, case)[1]
    longest = LONGEST_IMPLICIT if equations.scene.stiff else LONGEST
    return longest / vibration if vibration > 0 else np.inf


def growth(run: Sampled, exact: Truth) -> float:
    """Return the growth factor of a change of the start, in the sizes of the states."""
    equations = scene_equations(run.setup.case)
    if equations.scene.discretisation_coordinates:
        return VIBRATION_GROWTH
    size = run_sizes(exact.states, exact.times[-1] - exact.times[0])
    signs = np.where(np.arange(len(size)) % 2, -1.0, 1.0)
    moved = equations.start(run.setup.case) + PERTURBATION * size * signs
    try:
        states = run.solution(equations, moved).states
    except CannotJudgeError:
        return np.inf
    return max(1.0, float(np.max(np.abs(states - exact.states) / size[:, None])) / PERTURBATION)


# What is compared ---------------------------------------------------------------------------


def error_of_elements(run: Sampled, values: Array) -> Any:
    """Return the discretisation error (k, n_t) of elements, by a run with half as many.

    None is granted if that run fails, nor to a model with other equations than the scene.
    """
    setup = run.setup
    order = setup.bound.description.element_order if setup.bound.approximates_continuum else 0
    if not order:
        return 0.0
    try:
        halved = run._replace(setup=setup.with_segments(0.5)).values()
    except EngineError:
        return 0.0
    return np.maximum.accumulate(np.abs(values - halved) / (2**order - 1), axis=1)


def sizes(names: tuple[str, ...], truth: Truth) -> Array:
    """Return the sizes (k,) of observables; a rate's is no less than its coordinate's over the run.

    Otherwise errors of a coordinate at rest would be relative to round-off.
    """
    span = float(truth.times[-1] - truth.times[0]) or 1.0
    known = dict(zip(names, map(float, truth.size), strict=True))
    bases = {name: name.removesuffix("_dot") for name in names if name.endswith("_dot")}
    bases |= dict([VIOLATIONS[::-1]])
    return np.array(
        [max(size, known.get(bases.get(name, ""), 0.0) / span) for name, size in known.items()]
    )


def halving_shows(changes: list[float], order: int, floor: float) -> str:
    """Return the fault in the changes from h to h/2, and from h/2 to h/4, in words."""
    change, next_change = changes
    if not change <= CAP / 2:
        return f"halving the step changes it by {change:.2g}"
    if change > floor and change < 2 ** (order - ORDER_SLACK) * next_change:
        observed = np.log2(change / next_change)
        return f"halved steps show order {observed:.1f} instead of {order}"
    return ""


def largest(values: Array) -> Array:
    """Return the largest of each row; NaN counts as infinite."""
    return np.asarray(np.max(np.nan_to_num(np.abs(values), nan=np.inf, posinf=np.inf), axis=1))


def relative(values: Array, size: Array) -> float:
    """Return the largest of rows (k, n_t), relative to their sizes (k,)."""
    return float(np.max(largest(values) / size))

"""One run at an extreme: what came of it, and who notices."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ...reference.errors import EngineError, MbcheckError
from ...reference.scene import Array
from ..checks.tolerances import (
    CAP,
    RICHARDSON_SAFETY,
    SAFETY,
    VIOLATION,
    rounding,
    rows,
    sample_numbers,
)
from ..checks.truth import Truth
from ..engines.equations import scene_equations
from ..engines.run import VIOLATIONS
from ..engines.setup import Setup
from .certify import Certified, UncertifiedError, certified, longest_horizon, model_solution
from .row import ENGINE, HALVING, REFERENCE, RIGHT, WRONG, Row, rules_against

ORDER_SLACK = 0.5
"""By how much the order that halved steps show may lie below the declared one."""

LOST = 2 * CAP
"""Relative errors above this are wrong, however well they are predicted; rules and halved steps
are to speak from half of it on."""

FLOOR = 1e-9
"""Relative change under halved steps in which nobody looks for an order."""

FEWEST = 4
"""Steps over which a run can be judged at least."""

SAMPLES = 32


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

    @property
    def span(self) -> float:
        """Time from the start to the last sample [s]."""
        return float(self.times[-1] - self.setup.case.start_time)

    def values(self, division: int = 1) -> Array:
        """Run it, or with a fraction of the step, through the guard."""
        step = self.setup.step_size / division
        return self.setup.simulate(step, self.samples * division).matrix(self.setup.observables)


def judge(
    row: Row,
    setup: Setup,
    horizon: float | None = None,
    reference: Callable[[], AbstractContextManager[None]] = nullcontext,
) -> Row:
    """Run a case at an extreme, and tell what came of it and who notices.

    Parameters
    ----------
    row : Row
        To be filled; see `Row.of`.
    setup : Setup
        Its method is None where none can run the model, which then says why.
    horizon : float, optional
        Length of the run [s], by default that of the case. Where the reference cannot follow so
        long, a run that does not fail is judged over a part of it.
    reference : callable
        Returns a context for the reference's work; one that limits its time raises
        `UncertifiedError`.

    Returns
    -------
    Row
    """
    case = setup.case
    if setup.why_not is not None:
        return row.refused(f"the adapter refuses: {setup.why_not}")
    step = setup.step_size
    horizon = max(case.horizon if horizon is None else horizon, FEWEST * step)
    rules = rules_against(setup, horizon)
    run = Sampled.over(setup, horizon)
    try:
        values = run.values()
    except EngineError as error:
        if error.kind != "raised" or builds(setup):
            return row.failed(error, rules)
        return row.refused(f"the engine refuses: {error}", (ENGINE, *rules))
    try:
        reachable = longest_horizon(case, scene_equations(case))
        if reachable < horizon:
            if reachable < FEWEST * step:
                raise UncertifiedError(
                    f"the reference can follow {reachable:.2g} s, {reachable / step:.2g} steps"
                )
            run = Sampled.over(setup, reachable)
            values = run.values()
        with reference():
            exact = certified(scene_equations(case), case, run.times, setup.observables)
        model = exact.truth  # stands for model equations that are too stiff to be model_solution
        if not setup.is_exact and run.span <= longest_horizon(case, setup.equations):
            with reference():
                model = model_solution(setup.equations, case, run.times, setup.observables)
    except UncertifiedError as error:
        return row.skipped(f"not judged: {error}", rules)
    except EngineError as error:
        return row.failed(error, rules)
    return filled(row, run, values, exact, run_errors(run, values, exact, model), rules)


def filled(
    row: Row,
    run: Sampled,
    values: Array,
    exact: Certified,
    errors: RunErrors,
    rules: tuple[str, ...],
) -> Row:
    """Return a row with its verdict and the numbers that it comes from."""
    numbers = {
        "horizon": run.span,
        "steps": float(run.samples[-1]),
        "reference_bound": exact.bound,
        "reference_routes": exact.routes,
        "growth": exact.growth,
        "model_error": errors.model,
    }
    names = run.setup.observables
    if VIOLATIONS[0] in names:
        numbers["opening"] = float(np.max(values[names.index(VIOLATIONS[0])]))
    row = replace(row, error=errors.error, predicted=errors.predicted, values=numbers)
    reason = f"error {errors.error:.2g}, predicted {errors.predicted:.2g}"
    if errors.right:
        cautioned = f"; cautioned all the same by {', '.join(rules)}" if rules else ""
        return replace(row, outcome=RIGHT, reason=reason + cautioned)
    if errors.predicted < LOST:
        reason += f"; {errors.worst}"
    as_it_should = f"halving the step shows {errors.change:.1g}, as it should"
    reason += f"; {errors.halving or as_it_should}"
    noticed = (*rules, *((HALVING,) if errors.halving else ()))
    if not noticed:
        reason += ": only the reference sees it"
    return replace(row, outcome=WRONG, noticed_by=(*noticed, REFERENCE), reason=reason)


def builds(setup: Setup) -> bool:
    """Return whether the engine makes a model of the case at all."""
    state = setup.scene.state(setup.case.state)[None]
    try:
        setup.engine.mass_matrices(setup.case, setup.model, state)
    except MbcheckError:
        return True
    except Exception:  # whatever a foreign engine raises while it compiles
        return False
    return True


@dataclass(frozen=True)
class RunErrors:
    """A run against the references.

    Attributes
    ----------
    error, predicted, model, change : float
        Relative, the largest of all observables but the openings of loops: of the run; of a
        correct engine; between the model's equations and the scene's; between the runs with h
        and h/2.
    right : bool
    worst : str
        Which observable is farthest from what is predicted.
    halving : str
        How halved steps show that the run is wrong; empty if they do not.
    """

    error: float
    predicted: float
    model: float
    change: float
    right: bool
    worst: str
    halving: str


def run_errors(run: Sampled, values: Array, exact: Certified, model: Truth) -> RunErrors:
    """Compare a run with the references, and with runs of halved steps.

    ``model`` is the solution of the model's equations.
    """
    setup, names = run.setup, run.setup.observables
    size = sizes(names, exact.truth)
    failure = ""
    runs = [values]
    for division in (2, 4):
        try:
            runs.append(run.values(division))
        except EngineError as error:
            failure = f"with h/{division} the engine fails ({error.kind})"
            break
    opening = np.array([name.endswith("_violation") for name in names])
    changes = [relative((a - b)[~opening], size[~opening]) for a, b in pairwise(runs)]
    room = rounding(int(run.samples[-1]), exact.growth)
    order = setup.integrator.order
    halving = failure or halving_shows(changes, order, max(FLOOR, 10 * room))
    if setup.scheme:
        states = setup.scheme_states(setup.step_size, run.samples)
        integration = np.abs(rows(setup.equations, states, names) - model.values)
        safety = SAFETY
    else:  # what does not shrink as declared cannot be predicted
        integration, safety = 0 * values, RICHARDSON_SAFETY
        gain = 2**order - 1
        if not halving or (not failure and changes[0] > CAP / 2):
            change = np.abs(values - runs[1]) * (gain + 1) / gain
            integration = np.maximum.accumulate(change, axis=1)
    integration = integration + of_elements(run, values)
    off = np.abs(model.values - exact.truth.values)
    away = np.abs(values - exact.truth.values)
    allowed = safety * largest(integration) + largest(off) + exact.truth.bound + model.bound
    allowed = allowed + np.where(opening, max(room, VIOLATION), room) * size
    relative_error, predicted = (
        relative(errors[~opening], size[~opening]) for errors in (away, integration + off)
    )
    excess = largest(away) / allowed
    worst = int(np.argmax(excess))
    return RunErrors(
        error=relative_error,
        predicted=predicted,
        model=relative(off, size),
        change=changes[0] if changes else np.inf,
        right=bool(excess[worst] <= 1 and predicted < LOST),
        worst=f"{names[worst]} errs {excess[worst]:.2g} times what is predicted",
        halving=halving,
    )


def of_elements(run: Sampled, values: Array) -> Any:
    """Return the error (k, n_t) that elements leave of a run, by a run with half as many.

    None is granted where that run fails, nor to a model that solves equations of its own.
    """
    setup = run.setup
    order = setup.element_order if setup.approximates_continuum else 0
    if not order:
        return 0.0
    try:
        halved = run._replace(setup=setup.with_segments(0.5)).values()
    except EngineError:
        return 0.0
    return np.maximum.accumulate(np.abs(values - halved) / (2**order - 1), axis=1)


def sizes(names: tuple[str, ...], truth: Truth) -> Array:
    """Return the sizes (k,) of observables; a rate's is no less than its coordinate's over the run.

    So that nothing that stands still measures errors in units of rounding.
    """
    span = float(truth.times[-1] - truth.times[0]) or 1.0
    known = dict(zip(names, map(float, truth.size), strict=True))
    bases = {name: name.removesuffix("_dot") for name in names if name.endswith("_dot")}
    bases |= dict([VIOLATIONS[::-1]])
    return np.array(
        [max(size, known.get(bases.get(name, ""), 0.0) / span) for name, size in known.items()]
    )


def halving_shows(changes: list[float], order: int, floor: float) -> str:
    """Tell what is wrong with the changes from h to h/2, and from there to h/4."""
    change, next_change = changes
    if not change <= CAP / 2:
        return f"halving the step changes it by {change:.2g}"
    if change > floor and change < 2 ** (order - ORDER_SLACK) * next_change:
        observed = np.log2(change / next_change)
        return f"halved steps show order {observed:.1f} instead of {order}"
    return ""


def largest(values: Array) -> Array:
    """Return the largest of each row; what is not a number is infinite."""
    return np.asarray(np.max(np.nan_to_num(np.abs(values), nan=np.inf, posinf=np.inf), axis=1))


def relative(values: Array, size: Array) -> float:
    """Return the largest of rows (k, n_t), relative to their sizes (k,)."""
    return float(np.max(largest(values) / size))

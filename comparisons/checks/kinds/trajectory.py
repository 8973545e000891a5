"""Check kind *trajectory*: a free run of the engine against the reference.

A method whose scheme is published must make exactly the error of that scheme
(`scheme_residual`); for the others the error is predicted from three steps, and what they
extrapolate to must be the reference (`extrapolated`). If the model's equations are not the scene's,
all these are compared with the model's own, and `model_error` is the distance between the two
without the error of the step.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ....reference.equations import scene_equations
from ....reference.errors import CannotJudgeError, EngineError
from ....reference.scene import Array
from ...engines.setup import Setup
from ..comparison import (
    CAP,
    REFINEMENTS,
    RICHARDSON_SAFETY,
    Measured,
    Part,
    RunComparison,
    by_extrapolation,
    by_scheme,
    conclusion,
    ideal_rows,
    last_trusted_sample,
    richardson,
    sample_numbers,
    unfollowed_vibrations,
)
from ..truth import permitted_horizon, rounding, simulated_horizon, truth
from ..verdict import Finding, Inconclusive

SAMPLES, RUN_SAMPLES = 32, 256
"""Samples of a run; more if its peak between them is estimated."""


@dataclass(frozen=True)
class FreeRun(RunComparison):
    """A run from the case's start compared with the truth, and runs with smaller steps.

    Attributes
    ----------
    finer : list of array (k, n_t)
        With half and a quarter of the step; empty of a published scheme.
    coarse : array (k, n_t), or None
        With half as many elements.
    """

    finer: list[Array]
    coarse: Array | None = None

    @property
    def note(self) -> str:
        """Over what time the run is compared, and how errors grow in it."""
        longest, growth = permitted_horizon(self.setup.case, self.step, self.setup.epsilon)
        ((_, numbers),) = self.parts
        return (
            f"h = {self.step:.3g} s over {numbers[self.seen - 1] * self.step:.3g} s; errors "
            f"grow by a factor of {growth:.3g} within {longest:.3g} s"
        )


def quantities(setup: Setup) -> tuple[str, ...]:
    """Return the names of the measured quantities: observables, and the test of the method."""
    last = "scheme_residual" if setup.scheme else "extrapolated"
    scene = setup.scene
    whole = tuple(scene.run_quantities.units) if scene.run_quantities else ()
    names = (*setup.bound.observables, *whole, last)
    return names if setup.bound.is_exact else (*names, "model_error")


def measure(setup: Setup) -> Measured:
    """Run the case with the method's default step and judge every observable."""
    run = in_window(in_space(refined(setup)))
    note, size, prediction = run.note, run.right.size, run.prediction

    def describe(row: int, worst: int) -> str:
        error = abs(run.values[row, worst] - run.right.values[row, worst])
        return (
            f"worst at t = {run.right.times[worst]:.3g} s; {note}; predicted error "
            f"{prediction.errors[row, worst]:.3g}, relative error {error / size[row]:.2g}"
        )

    findings = run.observables(describe, over_time=True)
    if setup.scene.run_quantities and not setup.scheme:
        findings += run_quantities(run)
    away = run.largest(prediction.limit - run.right.values)
    name = "scheme_residual" if setup.scheme else "extrapolated"
    findings.append(run.limit(name, away, 0.0, f"{note}; {prediction.reason}"))
    if not setup.bound.is_exact:
        exact = truth(scene_equations(setup.case), setup.case, run.right.times, run.names).values
        off, expected = (run.largest(one - exact) for one in (prediction.limit, run.right.values))
        reason = f"the model differs from the scene by {expected:.2g} of the range at any step: "
        findings.append(
            run.limit(
                "model_error", off, expected, reason + setup.bound.solved_equations.scene.title
            )
        )
    return Measured(findings, run.runs)


def refined(setup: Setup) -> FreeRun:
    """Return the run with the longest step, of some halved ones, whose error can be predicted."""
    for refinement in range(REFINEMENTS):
        try:
            run = with_step(setup, setup.default_step / 2**refinement)
        except EngineError as failure:
            if failure.kind != "solver" or refinement == REFINEMENTS - 1:
                raise
            continue  # too coarse for Newton's method
        if run.prediction.shrinks and run.seen:
            break
    return run


def with_step(setup: Setup, step: float) -> FreeRun:
    """Run a case with a step [s], and predict the error.

    Raises
    ------
    CannotJudgeError
        If round-off alone may hide a mistake.
    """
    case, scheme, names = setup.case, setup.scheme, setup.bound.observables
    horizon = simulated_horizon(case, step, scheme, setup.epsilon)
    numbers = sample_numbers(horizon, step, RUN_SAMPLES if setup.scene.run_quantities else SAMPLES)
    _, growth = permitted_horizon(case, step, setup.epsilon)
    room = rounding(int(numbers[-1]), growth, setup.epsilon)
    if room > CAP:
        raise CannotJudgeError(f"round-off may reach {room:.2g} of each observable: not judged")
    right = truth(setup.bound.solved_equations, case, case.start_time + numbers * step, names)
    values, finer = setup.simulate(step, numbers).matrix(names), list[Array]()
    parts, units = [Part(case, numbers)], setup.scene.units
    if scheme:
        ideal = ideal_rows(setup, parts, step, names)
        prediction = by_scheme(scheme, values, ideal, right)
    else:
        finer = [setup.simulate(step / k, numbers * k).matrix(names) for k in (2, 4)]
        prediction = by_extrapolation(setup.integrator.order, [values, *finer], right, names)
    seen = last_trusted_sample(prediction.errors / right.size[:, None])
    return FreeRun(names, units, values, right, prediction, room, seen, setup, step, parts, finer)


def in_space(run: FreeRun) -> FreeRun:
    """Return a run with the error of its elements, by one with half as many; none are too few."""
    setup = run.setup
    if (
        not setup.bound.approximates_continuum
        or setup.bound.discrete
        or not setup.bound.description.element_order
    ):
        return run
    ((_, numbers),) = run.parts
    coarse = setup.with_segments(0.5).simulate(run.step, numbers).matrix(run.names)
    prediction = run.prediction.with_elements(
        run.values - coarse, setup.bound.description.element_order
    )
    seen = last_trusted_sample(prediction.errors / run.right.size[:, None])
    return replace(run, coarse=coarse, prediction=prediction, seen=seen)


def in_window(run: FreeRun) -> FreeRun:
    """Return a run whose error is granted as the largest predicted for its first samples.

    Raises
    ------
    CannotJudgeError
        If its steps do not follow what the start excites.
    EngineError
        ``step``, if no sample has an error that leaves something to be seen.
    """
    setup, prediction, step = run.setup, run.prediction, run.step
    if setup.bound.discrete and not (prediction.shrinks and run.seen):
        horizon = simulated_horizon(setup.case, step, setup.scheme, setup.epsilon)
        lost = unfollowed_vibrations(setup, step, horizon, run.right, run.room)
        prediction = replace(prediction, unfollowed=lost)
    if not run.seen and prediction.unfollowed:
        raise CannotJudgeError(f"too coarse to tell: {prediction.unfollowed}")
    if not run.seen:
        raise EngineError("step", f"h = {step:.3g} s is too coarse to be judged over any time")
    most = np.max(prediction.errors[:, : run.seen], axis=1, keepdims=True)
    errors = np.broadcast_to(most, prediction.errors.shape)
    return replace(run, prediction=replace(prediction, errors=errors))


def run_quantities(run: FreeRun) -> list[Finding | Inconclusive]:
    """Judge quantities derived from runs with h, h/2, h/4 and, for elements, half as many.

    Errors that halved steps predict are granted only where they shrink as declared.
    """
    setup, right = run.setup, run.right
    scene, prediction = setup.scene, run.prediction
    assert scene.run_quantities is not None
    every = [right.values, run.values, *run.finer, *([] if run.coarse is None else [run.coarse])]
    derived = [
        scene.run_quantities.evaluate(
            right.times, dict(zip(run.names, one, strict=True)), setup.case.parameters
        )
        for one in every
    ]
    trust = float(np.max(right.bound + run.room * right.size))
    findings: list[Finding | Inconclusive] = []
    for name, unit in scene.run_quantities.units.items():
        reference, gain = derived[0][name]
        values = [np.array(item[name][0]) for item in derived[1:4]]
        estimate, value = richardson(values, setup.integrator.order), float(values[0])
        predicted = estimate.predicted / RICHARDSON_SAFETY
        reason = f"predicted error {predicted:.3g} from half the step"
        if run.coarse is not None:
            predicted += abs(value - derived[4][name][0]) / (
                2**setup.bound.description.element_order - 1
            )
            reason = f"predicted error {predicted:.3g} from half the step and half the elements"
        granted = prediction.shrinks * RICHARDSON_SAFETY * predicted + gain * trust
        error = abs(value - reference)
        finding = Finding(name, unit, value, reference, error, granted, reason)
        change = abs(value - float(values[1]))
        findings.append(conclusion(finding, change, prediction.unfollowed))
    return findings

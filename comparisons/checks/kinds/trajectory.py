"""Check kind *trajectory*: a free run of the engine against the reference.

A method whose scheme is published must make exactly the error of that scheme
(`scheme_residual`); for the others the error is predicted from three steps, and what they
extrapolate to must be the reference (`extrapolated`). Where the model's equations are not
the scene's, all that is against the model's own, and `model_error` is what remains between
the two when the step's error is taken away.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ....reference import get_scene
from ....reference.equations import scene_equations
from ....reference.errors import CannotJudgeError, EngineError
from ....reference.scene import Array, Case
from ...engines.setup import Setup
from ..free_vibrations import excitation
from ..tolerances import (
    CAP,
    OPEN,
    RICHARDSON_SAFETY,
    SAFETY,
    VIOLATION,
    last_trusted_sample,
    richardson,
    rounding,
    rows,
    sample_numbers,
)
from ..truth import Truth, permitted_horizon, simulated_horizon, truth
from ..verdict import PROFILES, Finding, Inconclusive, Series

SAMPLES, RUN_SAMPLES = 32, 256
"""Samples of a run; more where its peak is looked for between them."""

REFINEMENTS = 4
"""Times that a step is halved until errors shrink with it as the order says."""


def quantities(setup: Setup) -> tuple[str, ...]:
    """Return the names of what is measured: every observable, and the test of the method."""
    last = "scheme_residual" if setup.scheme else "extrapolated"
    scene = setup.scene
    whole = tuple(scene.run_quantities.units) if scene.run_quantities else ()
    names = (*setup.bound.observables, *whole, last)
    return names if setup.bound.is_exact else (*names, "model_error")


def measure(setup: Setup) -> list[Finding | Inconclusive]:
    """Run the case with the method's default step and judge every observable."""
    scene = setup.scene
    units = scene.units
    names = setup.bound.observables
    equations = setup.bound.solved_equations
    scheme, epsilon = setup.scheme, setup.epsilon
    count = RUN_SAMPLES if scene.run_quantities else SAMPLES
    by_elements = setup.bound.approximates_continuum and not setup.bound.discrete
    in_space = setup.bound.description.element_order if by_elements else 0
    for refinement in range(REFINEMENTS):
        step = setup.default_step / 2**refinement
        horizon = simulated_horizon(setup.case, step, scheme, epsilon)
        samples = sample_numbers(horizon, step, count)
        longest, growth = permitted_horizon(setup.case, step, epsilon)
        room = rounding(int(samples[-1]), growth, epsilon)
        if room > CAP:
            raise CannotJudgeError(f"rounding may leave {room:.2g} of each size: nothing is known")
        times = setup.case.start_time + samples * step
        right = truth(equations, setup.case, times, names)
        try:
            values = setup.simulate(step, samples).matrix(names)
        except EngineError as failure:
            if failure.kind != "solver" or refinement == REFINEMENTS - 1:
                raise
            continue  # too coarse for Newton's method
        if scheme:
            ideal = rows(equations, setup.scheme_states(step, samples), names)
            prediction = by_scheme(scheme, values, ideal, right)
        else:
            finer = [setup.simulate(step / k, samples * k).matrix(names) for k in (2, 4)]
            prediction = by_extrapolation(setup.integrator.order, [values, *finer], right, names)
        size = right.size
        if prediction.shrinks and last_trusted_sample(prediction.errors / size[:, None]):
            break
    if in_space:
        coarse = setup.with_segments(0.5).simulate(step, samples).matrix(names)
        prediction = prediction.with_elements(values - coarse, in_space)
    seen = last_trusted_sample(prediction.errors / size[:, None])
    if setup.bound.discrete and not (prediction.shrinks and seen):
        unfollowed = unfollowed_vibrations(setup, step, horizon, right, room)
        prediction = replace(prediction, unfollowed=unfollowed)
    if not seen and prediction.unfollowed:
        raise CannotJudgeError(f"too coarse to tell: {prediction.unfollowed}")
    if not seen:
        raise EngineError("step", f"h = {step:.3g} s is too coarse to be judged over any time")
    note = (
        f"h = {step:.3g} s over {samples[seen - 1] * step:.3g} s; errors grow by {growth:.3g} "
        f"in {longest:.3g} s"
    )
    findings: list[Finding | Inconclusive] = []
    for i, name in enumerate(names):
        worst = int(np.argmax(np.abs(values[i] - right.values[i])[:seen]))
        value, reference = float(values[i, worst]), float(right.values[i, worst])
        error = abs(value - reference)
        predicted = float(np.max(prediction.errors[i, :seen]))
        floor = max(room, VIOLATION) if name.endswith("_violation") else room
        tolerance = prediction.safety * predicted + right.bound[i] + floor * right.scale[i]
        reason = (
            f"worst at t = {right.times[worst]:.3g} s; {note}; predicted error {predicted:.3g}, "
            f"relative error {error / size[i]:.2g}"
        )
        unit = unit_of(setup.case, name)
        series = Series("time", right.times[:seen], values[i, :seen], right.values[i, :seen])
        finding = Finding(name, unit, value, reference, error, tolerance, reason, series)
        change = float(np.max(prediction.change[i, :seen]))
        findings.append(conclusion(finding, change, prediction.unfollowed))
    if scene.run_quantities and not scheme:
        runs = [values, *finer] + ([coarse] if in_space else [])
        findings += run_quantities(setup, runs, right, in_space, prediction, room)
    states = [i for i, name in enumerate(names) if name in units]
    window = Window(size, states, seen)
    away = window.largest(prediction.limit - right.values)
    spread = window.largest(prediction.spread)
    granted = min(spread, CAP**2) + room
    granted += float(np.max(right.bound[states] / size[states]))
    last = "scheme_residual" if scheme else "extrapolated"
    reason = f"{note}; {prediction.reason}"
    # what halving leaves open beyond all that is ever granted can tell neither right nor wrong
    open_to = granted + max(0.0, spread - CAP**2)
    silence = (
        f"halving steps and elements leaves {open_to:.2g} open, and no more than {CAP**2:.2g} is "
        "granted: choose more of them"
    )

    def relative_finding(
        name: str, value: float, reference: float, why: str
    ) -> Finding | Inconclusive:
        error = abs(value - reference)
        if granted < error <= open_to:
            return Inconclusive(name, silence)
        finding = Finding(name, "1", value, reference, error, granted, why)
        return conclusion(finding, window.largest(prediction.change), prediction.unfollowed)

    findings.append(relative_finding(last, away, 0.0, reason))
    if not setup.bound.is_exact:
        exact = truth(scene_equations(setup.case), setup.case, times, names).values
        off, expected = (
            window.largest(values - exact) for values in (prediction.limit, right.values)
        )
        reason = f"the model is off the scene by {expected:.2g} of the range at any step: "
        reason += equations.scene.title
        findings.append(relative_finding("model_error", off, expected, reason))
    return findings


def run_quantities(
    setup: Setup,
    runs: list[Array],
    right: Truth,
    in_space: int,
    prediction: Prediction,
    room: float,
) -> list[Finding | Inconclusive]:
    """Judge what a scene derives of a run with h, h/2, h/4 and, of elements, half as many.

    Errors that halved steps predict are granted only where they shrink as declared.
    """
    scene, case, names, order = (
        setup.scene,
        setup.case,
        setup.bound.observables,
        setup.integrator.order,
    )
    assert scene.run_quantities is not None
    derived = [
        scene.run_quantities.evaluate(
            right.times, dict(zip(names, run, strict=True)), case.parameters
        )
        for run in [right.values, *runs]
    ]
    trust = float(np.max(right.bound + room * right.size))
    findings: list[Finding | Inconclusive] = []
    for name, unit in scene.run_quantities.units.items():
        reference, gain = derived[0][name]
        values = [np.array(item[name][0]) for item in derived[1:4]]
        estimate, value = richardson(values, order), float(values[0])
        predicted = estimate.predicted / RICHARDSON_SAFETY
        if in_space:
            predicted += abs(value - derived[4][name][0]) / (2**in_space - 1)
        finding = Finding(
            name,
            unit,
            value,
            reference,
            abs(value - reference),
            prediction.shrinks * RICHARDSON_SAFETY * predicted + gain * trust,
            f"predicted error {predicted:.3g} from half the step"
            + (" and half the elements" if in_space else ""),
        )
        change = abs(value - float(values[1]))
        findings.append(conclusion(finding, change, prediction.unfollowed))
    return findings


def unfollowed_vibrations(
    setup: Setup, step: float, horizon: float, right: Truth, room: float
) -> str:
    """Return which vibrations a start excites that steps [s] do not follow, "" if none is seen."""
    lost, count = excitation(setup, step, horizon), len(setup.scene.observables)
    seen = lost.amplitudes / right.size[:count] > room + (right.bound / right.size)[:count]
    return (
        f"the start shakes vibrations above {lost.omega:.3g} rad/s, which steps of {step:.3g} s do "
        f"not follow over {horizon:.3g} s"
        if np.any(seen)
        else ""
    )


def conclusion(finding: Finding, change: float, unfollowed: str) -> Finding | Inconclusive:
    """Return a finding, or nothing where it may come from vibrations that steps do not resolve.

    ``change`` is by how much the quantity moves when the step is halved.
    """
    least = PROFILES["strict"] * finding.tolerance
    if unfollowed and least < finding.error < OPEN * change:
        return Inconclusive(finding.quantity, f"too coarse to tell: {unfollowed}")
    return finding


def unit_of(case: Case, name: str) -> str:
    """Return the unit of an observable or of a violation."""
    return get_scene(case.scene).units.get(name, "m" if name.startswith("position") else "m/s")


@dataclass(frozen=True)
class Window:
    """What of a run is compared: the rows that are states, their sizes, and the first samples.

    Attributes
    ----------
    size : array (k,)
        To which errors are related.
    states : list of int
        Rows.
    seen : int
        Samples.
    """

    size: Array
    states: list[int]
    seen: int

    def largest(self, errors: Array) -> float:
        """Return the largest of errors (k, n_t), relative to their sizes."""
        shares = np.abs(errors)[:, : self.seen] / self.size[:, None]
        return float(np.max(shares[self.states]))


@dataclass(frozen=True)
class Prediction:
    """What a correct engine would do.

    Attributes
    ----------
    errors : array (k, n_t)
        Predicted error of each state at each sample.
    safety : float
        Factor on them.
    limit : array (k, n_t)
        The engine's values without the error of its step: the truth if the engine is right.
    spread : array (k, n_t)
        By how much it may still differ from 0, rounding apart.
    shrinks : bool
        Whether the error shrinks with the step as declared; no error is granted if not.
    reason : str
    change : array (k, n_t)
        By how much each state moves when the step is halved.
    unfollowed : str
        Why no right engine's error shrinks as declared; "" if one's does.
    """

    errors: Array
    safety: float
    limit: Array
    spread: Array
    shrinks: bool
    reason: str
    change: Array
    unfollowed: str = ""

    def with_elements(self, change: Array, order: int) -> Prediction:
        """Return it with the error in space that halving the elements showed (k, n_t)."""
        share = np.maximum.accumulate(np.abs(change), axis=1) / (2**order - 1)
        return replace(
            self,
            errors=self.errors + share,
            spread=self.spread + self.safety * share,
            reason=f"{self.reason}; elements are off by up to {float(np.max(share)):.2g}",
        )


def by_scheme(scheme: str, values: Array, ideal: Array, right: Truth) -> Prediction:
    """Predict errors by the method's own scheme on the claimed equations of motion."""
    error = ideal - right.values
    return Prediction(
        errors=np.abs(error),
        safety=SAFETY,
        limit=values - error,
        spread=np.zeros_like(values),
        shrinks=True,
        reason=f"distance from {scheme} on the equations of motion",
        change=np.zeros_like(values),
    )


def by_extrapolation(
    order: int, runs: list[Array], right: Truth, names: tuple[str, ...]
) -> Prediction:
    """Predict errors from h, h/2, h/4 (Richardson), if they shrink as declared."""
    change, size = np.abs(runs[0] - runs[1]), right.size[:, None]
    predicted = change * 2**order / (2**order - 1)
    seen = max(1, last_trusted_sample(np.maximum.accumulate(predicted / size, axis=1)))
    states = [i for i, name in enumerate(names) if not name.endswith("_violation")]
    whole = richardson(runs, order)
    estimate = richardson([(run / size)[states, :seen] for run in runs], order)
    shrinks = estimate.shrinks(float(np.max(right.bound / right.size)))
    return Prediction(
        errors=np.maximum.accumulate(predicted, axis=1) if shrinks else 0 * predicted,
        safety=RICHARDSON_SAFETY,
        limit=whole.limit,
        spread=whole.moved if shrinks else 0 * predicted,
        shrinks=shrinks,
        reason=f"value extrapolated to h -> 0; halving divides the error by "
        f"{estimate.ratio:.3g}, {2**order} expected",
        change=change,
    )

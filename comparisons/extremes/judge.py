"""One run at an extreme: what came of it, and who notices."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from ...reference import get_scene
from ...reference.errors import EngineError, MbcheckError
from ...reference.scene import Array, Case
from ..checks.rules.cautions import cautions
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
from ..engines.adapter import Adapter
from ..engines.equations import ModelEquations, scene_equations
from ..engines.protocol import Method
from ..engines.run import VIOLATIONS
from ..engines.setup import Setup
from .certify import Certified, UncertifiedError, certified, longest_horizon, solved
from .row import (
    ENGINE,
    FAILED,
    HALVING,
    REFERENCE,
    REFUSED,
    RIGHT,
    RULE,
    SKIPPED,
    WRONG,
    Row,
    noticer,
)

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


@dataclass(frozen=True)
class Sampled:
    """A setup, and the step numbers at which it is sampled."""

    setup: Setup
    samples: Any

    @property
    def times(self) -> Array:
        """Sample times [s]."""
        return np.asarray(self.setup.case.start_time + self.samples * self.setup.step_size)

    def values(self, names: tuple[str, ...], finer: int = 1) -> Array:
        """Run it, or with a fraction of the step, through the guard."""
        step = self.setup.step_size / finer
        return self.setup.simulate(step, self.samples * finer).matrix(names)


def judge(
    section: str,
    name: str,
    engine: Adapter,
    case: Case,
    model: str,
    method: Method | None,
    step: float | None,
    changed: Mapping[str, float | str],
    *,
    horizon: float | None = None,
    reference: Callable[[], AbstractContextManager[None]] = nullcontext,
) -> Row:
    """Run a case at an extreme, and tell what came of it and who notices.

    Parameters
    ----------
    section, name : str
        Of the row.
    engine, case, model
    method : Method or None
        None where no method can run the model, which then says why.
    step : float or None
        [s]
    changed : mapping of str to float or str
        What provokes the extreme.
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
    told = None if method is None else method.name

    def row(outcome: str, noticed: tuple[str, ...], reason: str, **more: Any) -> Row:
        more = {"error": None, "predicted": None, **more}
        return Row(
            section, case.scene, name, engine.name, model, told, step, changed, outcome, noticed,
            reason=reason, **more,
        )  # fmt: skip

    reason = engine.why_not(case, model, method)
    if reason is not None:
        return row(REFUSED, (ENGINE,), f"the adapter refuses: {reason}")
    assert method is not None
    assert step is not None
    horizon = case.horizon if horizon is None else horizon
    if horizon < FEWEST * step:
        horizon = FEWEST * step
    warned = tuple(
        f"{RULE}{item}"
        for item in dict.fromkeys(
            caution.rule for caution in cautions(Setup(engine, case, model, method, step), horizon)
        )
    )
    setup = Setup(engine, case, model, method, step)
    own, names = setup.equations, setup.observables
    setting = Sampled(setup, sample_numbers(horizon, step, SAMPLES))
    try:
        values = setting.values(names)
    except EngineError as error:
        if error.kind == "raised" and not builds(engine, case, model):
            return row(REFUSED, (ENGINE, *warned), f"the engine refuses: {error}")
        return row(FAILED, (noticer(error), *warned), f"{error.kind}: {error}")
    try:
        reachable = longest_horizon(case, scene_equations(case))
        if reachable < horizon:
            if reachable < FEWEST * step:
                raise UncertifiedError(
                    f"the reference can follow {reachable:.2g} s, {reachable / step:.2g} steps"
                )
            setting = replace(setting, samples=sample_numbers(reachable, step, SAMPLES))
            values = setting.values(names)
        with reference():
            exact = certified(scene_equations(case), case, setting.times, names)
        claimed = exact.truth  # stands for a claim that is too stiff to be solved
        span = float(setting.times[-1] - case.start_time)
        if not own.is_exact_for(case) and span <= longest_horizon(case, own):
            with reference():
                claimed = solved(own, case, setting.times, names)
    except UncertifiedError as error:
        return row(SKIPPED, warned, f"not judged: {error}")
    except EngineError as error:
        return row(FAILED, (noticer(error), *warned), f"{error.kind}: {error}")
    found = measured(setting, own, names, values, exact, claimed)
    numbers = {
        "horizon": float(setting.times[-1] - case.start_time),
        "steps": float(setting.samples[-1]),
        "reference_bound": exact.bound,
        "reference_routes": exact.routes,
        "growth": exact.growth,
        "model_error": found.model,
    }
    if VIOLATIONS[0] in names:
        numbers["opening"] = float(np.max(values[names.index(VIOLATIONS[0])]))
    said = f"error {found.error:.2g}, predicted {found.predicted:.2g}"
    more = {"error": found.error, "predicted": found.predicted, "values": numbers}
    if found.right:
        if warned:
            said += f"; cautioned all the same by {', '.join(warned)}"
        return row(RIGHT, (), said, **more)
    halving = (HALVING,) if found.halving else ()
    if found.predicted < LOST:
        said += f"; {found.worst}"
    shown = f"halving the step shows {found.change:.1g}, as it should"
    why = f"{said}; {found.halving or shown}"
    if not warned and not halving:
        why += ": only the reference sees it"
    return row(WRONG, (*warned, *halving, REFERENCE), why, **more)


def builds(engine: Adapter, case: Case, model: str) -> bool:
    """Return whether the engine makes a model of the case at all."""
    try:
        engine.mass_matrices(case, model, get_scene(case.scene).state(case.state)[None])
    except MbcheckError:
        return True
    except Exception:  # whatever a foreign engine raises while it compiles
        return False
    return True


@dataclass(frozen=True)
class Measured:
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


def measured(
    setting: Sampled,
    own: ModelEquations,
    names: tuple[str, ...],
    values: Array,
    exact: Certified,
    claimed: Truth,
) -> Measured:
    """Compare a run with the references, and with runs of halved steps."""
    setup, method = setting.setup, setting.setup.integrator
    size = sizes(names, exact.truth)
    failure = ""
    runs = [values]
    for finer in (2, 4):
        try:
            runs.append(setting.values(names, finer))
        except EngineError as failed:
            failure = f"with h/{finer} the engine fails ({failed.kind})"
            break
    closed = np.array([not name.endswith("_violation") for name in names])
    changes = [relative((a - b)[closed], size[closed]) for a, b in pairwise(runs)]
    room = rounding(int(setting.samples[-1]), exact.growth)
    floor = max(FLOOR, 10 * room)
    halving = failure or halving_shows(changes, method.order, floor)
    if setup.scheme:
        ideal = rows(own, setup.scheme_states(setup.step_size, setting.samples), names)
        integration, safety = np.abs(ideal - claimed.values), SAFETY
    else:  # what does not shrink as declared cannot be predicted
        integration, safety = 0 * values, RICHARDSON_SAFETY
        gain = 2**method.order - 1
        if not halving or (not failure and changes[0] > CAP / 2):
            change = np.abs(values - runs[1]) * (gain + 1) / gain
            integration = np.maximum.accumulate(change, axis=1)
    in_space = setup.element_order if setup.approximates_continuum else 0
    if in_space:
        try:
            halved = replace(setting, setup=setup.with_segments(0.5)).values(names)
            change = np.abs(values - halved) / (2**in_space - 1)
            integration = integration + np.maximum.accumulate(change, axis=1)
        except EngineError:
            pass  # no error in space is granted
    off = np.abs(claimed.values - exact.truth.values)
    away = np.abs(values - exact.truth.values)
    rooms = np.array([max(room, VIOLATION) if n.endswith("_violation") else room for n in names])
    allowed = safety * largest(integration) + largest(off)
    allowed = allowed + exact.truth.bound + claimed.bound + rooms * size
    error, predicted = (
        relative(values[closed], size[closed]) for values in (away, integration + off)
    )
    excess = largest(away) / allowed
    worst = int(np.argmax(excess))
    return Measured(
        error=error,
        predicted=predicted,
        model=relative(off, size),
        change=changes[0] if changes else np.inf,
        right=bool(excess[worst] <= 1 and predicted < LOST),
        worst=f"{names[worst]} errs {excess[worst]:.2g} times what is predicted",
        halving=halving,
    )


def sizes(names: tuple[str, ...], truth: Truth) -> Array:
    """Return the sizes (k,) of observables; a rate's is no less than its coordinate's over the run.

    So that nothing that stands still measures errors in units of rounding.
    """
    span = float(truth.times[-1] - truth.times[0]) or 1.0
    found = dict(zip(names, map(float, truth.size), strict=True))
    bases = {name: name.removesuffix("_dot") for name in names if name.endswith("_dot")}
    bases |= dict([VIOLATIONS[::-1]])
    return np.array(
        [max(size, found.get(bases.get(name, ""), 0.0) / span) for name, size in found.items()]
    )


def halving_shows(changes: list[float], order: int, floor: float) -> str:
    """Tell what is wrong with the changes from h to h/2, and from there to h/4."""
    change, finer = changes
    if not change <= CAP / 2:
        return f"halving the step changes it by {change:.2g}"
    if change > floor and change < 2 ** (order - ORDER_SLACK) * finer:
        shown = np.log2(change / finer)
        return f"halved steps show order {shown:.1f} instead of {order}"
    return ""


def largest(values: Array) -> Array:
    """Return the largest of each row; what is not a number is infinite."""
    return np.asarray(np.max(np.nan_to_num(np.abs(values), nan=np.inf, posinf=np.inf), axis=1))


def relative(values: Array, size: Array) -> float:
    """Return the largest of rows (k, n_t), relative to their sizes (k,)."""
    return float(np.max(largest(values) / size))

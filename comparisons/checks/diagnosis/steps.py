"""Mistakes in single steps from right states: a force, a method, an order."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ....reference.errors import CannotJudgeError, EngineError
from ....reference.scene import Array, Case
from ....reference.solve.schemes import TABLEAUS
from ...engines.setup import Setup, power_of_two
from ..kinds import algebra, one_step
from ..tolerances import rows
from ..units import EXPLAINED
from ..verdict import Finding, judge
from .motions import Part, explanation, looked_at

FEW = 3
"""Steps after which a force that is held shows whether it is late as well: in the first of a run
there is none before."""

PARTS = (2, 4, 8, 16)
"""Into how many steps the longest is divided, to see by what order its error shrinks."""

SETTLED_PARTS = tuple(one_step.SETTLED * parts for parts in (1, 2, 4))
"""The same of a method that is no published scheme."""

CLEAR = 0.2
"""An order is told where what is measured is as near as that to a whole number."""

LEAST = 1e-11
"""Relative error that is no rounding of so few steps."""

ANOTHER_MODEL = (
    "it converges with its order, but to another motion: the model differs, not the method"
)
"""Of steps whose changes shrink as declared where they are halved, and whose limit is off."""

ANOTHER_MOTION = (
    "it converges with its order, but to another motion, though its accelerations are right"
)
"""The same where accelerations at random states have been compared."""

UNMOVED = 1e-3
"""Share of an error of rates by which they would move positions in some steps, were they used."""


def of_steps(setup: Setup) -> str:
    """Return the mistake in few steps or one; those of elements of others take long to predict."""
    if setup.discrete:
        return ""
    step = setup.default_step
    cases = one_step.starts(setup, step, setup.scheme)
    in_time = one_step.driven_in_time(setup, setup.equations)
    places = range(len(setup.scene.observables))
    for count in (FEW, 1) if in_time else (1,):
        answer = one_step.after(setup, cases, count * step, count)
        parts = [Part(one, np.array([count])) for one in cases]
        if said := explanation(looked_at(setup, parts, answer[places])):
            return said
    return ""


def of_order(setup: Setup) -> str:
    """Return that steps are not those of the declared scheme, or not of the declared order.

    Only where halved steps lead to what is right: then the equations of motion are.
    """
    if setup.discrete or not one_step.quantities(setup):
        return ""
    order, scheme = setup.integrator.order, setup.scheme
    counts = PARTS if scheme else SETTLED_PARTS
    length = (one_step.LONGER if scheme else one_step.SETTLED) * setup.default_step
    if scheme:
        length = min(length, power_of_two(setup.stable_step_bound))
    equations, names = setup.solved_equations, setup.scene.observables
    cases = one_step.starts(setup, length, scheme)
    right = one_step.truths(equations, cases, length, names)
    away, answers = [], []
    for parts in counts:
        answers.append(one_step.after(setup, cases, length, parts)[: len(names)])
        should = by_scheme(setup, cases, length, parts) if scheme else right.values
        errors = np.max(np.abs(answers[-1] - should), axis=1) / right.size
        away.append(float(np.max(errors)))
    rates = rates_of(setup)
    if said := half_a_step(setup, cases, length, counts[-1], answers[-1]):
        return said
    if np.max(errors) > LEAST and np.all(errors[~rates] < UNMOVED * np.max(errors)):
        return "positions are right, and the rates that are told with them are not"
    off = float(np.max(np.max(np.abs(answers[-1] - right.values), axis=1) / right.size))
    wrong = wrong_forces(setup)
    if converges(answers, right.size, order, off):
        return ANOTHER_MOTION if wrong is False else ANOTHER_MODEL
    measured = order_of(away)
    if not measured or (not scheme and measured >= order) or wrong:
        return ""
    if not scheme:
        return f"{setup.integrator.name} is of order {measured}, where {order} is declared"
    said = f"its steps are not those of {scheme}"
    if scheme in TABLEAUS:
        in_time = one_step.driven_in_time(setup, equations)
        said += ": its coefficients differ" + (", or the times of its force" if in_time else "")
    if measured >= order:
        return f"{said}, though it is of order {order}"
    return f"{said}, and it is of order {measured}, where {order} is declared"


def converges(answers: list[Array], size: Array, order: int, off: float) -> bool:
    """Return whether observables (k, n) of halved steps converge, to what is `off` by much more.

    With each halving their changes shrink as the order says, or are rounding.
    """
    changes = [
        float(np.max(np.max(np.abs(coarse - fine), axis=1) / size))
        for coarse, fine in pairwise(answers)
    ]
    *_, before, last = changes
    shrinks = last < LEAST or before > 2 ** (order - CLEAR) * last
    return bool(shrinks and last < EXPLAINED * off and off > LEAST)


def rates_of(setup: Setup) -> NDArray[np.bool_]:
    """Return which observables (k,) are rates, with which a run goes on if it is one of them.

    Rates that a run goes on with would have changed its positions.
    """
    scene = setup.scene
    turning = {rate for one in scene.quaternions for rate in one.rates}
    return np.array([name.endswith("_dot") or name in turning for name in scene.observables])


def half_a_step(setup: Setup, cases: list[Case], length: float, parts: int, answer: Array) -> str:
    """Return that rates after so many parts of a time [s] are those of another instant."""
    equations, names, rates = setup.solved_equations, setup.scene.observables, rates_of(setup)
    for share, word in ((0.0, ""), (-0.5, "behind"), (0.5, "ahead of")):
        right = one_step.truths(equations, cases, length * (1 + share / parts), names)
        error = float(np.max(np.abs(answer - right.values)[rates] / right.size[rates, None]))
        if not share:
            least = EXPLAINED * error
        elif LEAST < error < least:
            return f"rates are half a step {word} positions, as those of a leapfrog are"
    return ""


def by_scheme(setup: Setup, cases: list[Case], length: float, parts: int) -> Array:
    """Return observables (k, n) that the declared scheme reaches in so many steps."""
    names, samples = setup.scene.observables, np.array([parts])
    ideal = [setup.with_case(one).scheme_states(length / parts, samples) for one in cases]
    return np.hstack([rows(setup.equations, states, names) for states in ideal])


def order_of(errors: list[float]) -> int:
    """Return by what order errors shrink as steps are halved, 0 where that is not clear."""
    slopes = [float(np.log2(coarse / fine)) for coarse, fine in pairwise(errors) if fine > LEAST]
    whole = round(slopes[-1]) if slopes else 0
    clear = len(slopes) > 1 and all(abs(slope - whole) < CLEAR for slope in slopes[-2:])
    return whole if clear and whole > 0 else 0


def wrong_forces(setup: Setup) -> bool | None:
    """Return whether accelerations at random states are wrong, None if an engine tells none."""
    try:
        findings = algebra.measure(setup)
    except (CannotJudgeError, EngineError):
        return None
    return any(isinstance(one, Finding) and judge(one, 1.0)[0] == "deviation" for one in findings)

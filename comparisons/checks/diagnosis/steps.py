"""Mistakes in single steps from right states: a force, a method, an order."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ....reference.errors import CannotJudgeError, EngineError
from ....reference.scene import Array
from ....reference.solve.schemes import TABLEAUS
from ...engines.setup import Setup, power_of_two
from ..kinds import algebra, one_step
from ..units import EXPLAINED
from ..verdict import Finding, judge
from .motions import Part, Seen, explanation, looked_at

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

UNMOVED = 1e-3
"""Share of an error of rates by which they would move positions in some steps, were they used."""


def of_steps(setup: Setup) -> str:
    """Return the mistake in few steps or one; those of elements of others take long to predict."""
    if setup.bound.discrete:
        return ""
    in_time = one_step.driven_in_time(setup, setup.bound.equations)
    every = (explanation(after_steps(setup, count)) for count in ((FEW, 1) if in_time else (1,)))
    return next(filter(None, every), "")


def after_steps(setup: Setup, count: int) -> Seen:
    """Return what an engine computes in so many steps from each start."""
    step = setup.default_step
    cases = one_step.starts(setup, step, setup.scheme)
    answer = one_step.after(setup, cases, count * step, count)[: len(setup.scene.observables)]
    return looked_at(setup, [Part(one, np.array([count])) for one in cases], answer)


def of_order(setup: Setup) -> str:
    """Return that steps are not those of the declared scheme, or not of the declared order.

    Only where halved steps lead to what is right: then the equations of motion are.
    """
    if setup.bound.discrete or not one_step.quantities(setup):
        return ""
    order, scheme = setup.integrator.order, setup.scheme
    counts = PARTS if scheme else SETTLED_PARTS
    length = (one_step.LONGER if scheme else one_step.SETTLED) * setup.default_step
    if scheme:
        length = min(length, power_of_two(setup.stable_step_bound))
    equations, names = setup.bound.solved_equations, setup.scene.observables
    cases = one_step.starts(setup, length, scheme)
    right = one_step.truths(equations, cases, length, names)

    def relative(change: Array) -> float:
        """Return the largest change, relative to the size of each observable."""
        return float(np.max(np.abs(change) / right.size[:, None]))

    away, answers = [], []
    for parts in counts:
        answers.append(one_step.after(setup, cases, length, parts)[: len(names)])
        should = one_step.ideal(setup, cases, length, parts, names) if scheme else right.values
        errors = np.max(np.abs(answers[-1] - should), axis=1) / right.size
        away.append(float(np.max(errors)))
    turning = {rate for one in setup.scene.quaternions for rate in one.rates}
    rates = np.array([name.endswith("_dot") or name in turning for name in names])
    half = one_step.truths(equations, cases, length * (1 - 0.5 / counts[-1]), names)
    behind = np.max((np.abs(answers[-1] - half.values) / right.size[:, None])[rates], initial=0.0)
    if behind < EXPLAINED * np.max(errors[rates], initial=0.0):
        return "rates are half a step behind positions, as those of a leapfrog are"
    if np.max(errors) > LEAST and np.all(errors[~rates] < UNMOVED * np.max(errors)):
        return "positions are right, and the rates that are told with them are not"
    off = relative(answers[-1] - right.values)
    *_, before, last = (relative(coarse - fine) for coarse, fine in pairwise(answers))
    shrinks = last < LEAST or before > 2 ** (order - CLEAR) * last
    wrong = wrong_forces(setup)
    if shrinks and last < EXPLAINED * off and off > LEAST:
        return "" if wrong is False else ANOTHER_MODEL
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

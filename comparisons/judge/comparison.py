"""A trajectory beside its reference, as far as it can be judged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ...reference.cost import expected_end
from ...reference.errors import UsageError
from ...reference.scene import Array, Case
from ..checks.tolerances import CAP
from ..checks.truth import MOST_STEPS, moves, permitted_horizon, truth_to_the_end
from ..engines.equations import scene_equations
from .method_error import Problem, Scheme
from .recording import Recording

GRID = 256
"""Times, beside those of the trajectory, at which the reference is looked at."""

LONGEST = 10.0
"""A trajectory may be so many times as long as its case; a longer one is a slip of units."""

ON_START = 1e-9
"""Distance, in the span of a trajectory, within which its first row stands at the start."""


@dataclass(frozen=True)
class Comparison:
    """A trajectory beside its reference.

    Attributes
    ----------
    case : Case
    names : tuple of str, k of them
    times : array (n_t,)
    values, reference : array (k, n_t)
        The reference is NaN from where nothing can be judged.
    states : array (2 n, n_t)
        Of the reference.
    bound, size, slope : array (k,)
        On the reference's error; its largest value, and that of its rate.
    seen : int
        Number of samples, from the first, that can be judged.
    growth : float
        Of an initial error.
    predicted : array (k,), or None
        Errors that are granted of a method's order.
    notes : tuple of str
    """

    case: Case
    names: tuple[str, ...]
    times: Array
    values: Array
    reference: Array
    states: Array
    bound: Array
    size: Array
    slope: Array
    seen: int
    growth: float
    predicted: Array | None
    notes: tuple[str, ...]


def compare(
    file: Recording,
    case: Case,
    names: tuple[str, ...],
    basis: Mapping[str, float],
    most_steps: int = MOST_STEPS,
) -> Comparison:
    """Solve the case at the times of a trajectory, as far as errors grow slowly.

    A scheme that predicts the error takes `most_steps` steps at most.

    Raises
    ------
    UsageError
        If nothing moves, or nothing can be judged.
    """
    start, equations = case.start_time, scene_equations(case)
    times = np.maximum(file.times, start)
    span = float(times[-1] - start)
    horizon, growth = permitted_horizon(replace(case, horizon=span))
    seen = int(np.searchsorted(times, start + horizon * (1 + ON_START), side="right"))
    notes = []
    if seen < len(times):
        notes.append(
            f"errors grow too fast to be told from the method's after t = {start + horizon:.4g} s: "
            f"{len(times) - seen} of {len(times)} samples lie after that and are not judged"
        )
    scheme = Scheme.of(basis, horizon, most_steps) if "order" in basis else None
    marks = start + scheme.marks if scheme else np.empty(0)
    grid = start + horizon * np.arange(GRID + 1) / GRID
    every = np.unique([*times[:seen], *grid, *marks])
    with expected_end(float(every[-1])):
        right = truth_to_the_end(equations, equations.start(case), start, every, names)
    if not moves(right.states[: len(right.states) // 2]):
        raise UsageError(
            f"nothing moves in {case.scene}/{case.name}: it cannot judge a trajectory; choose "
            "another case, or give --state"
        )
    predicted = None
    if scheme:
        predicted, reach = scheme.errors(Problem(equations, case, right, names))
        within = int(np.searchsorted(times, start + reach * (1 + ON_START), side="right"))
        if within < seen:
            notes.append(
                f"a method of order {scheme.order} with h = {scheme.step:.3g} s may be off by more "
                f"than {CAP:.0%} after t = {start + reach:.4g} s: {len(times) - within} of "
                f"{len(times)} samples lie after that and are not judged"
            )
            seen = within
    if not seen or times[seen - 1] <= start:
        raise UsageError(f"no sample lies where it can be judged; {'; '.join(notes) or 'none'}")
    at = np.searchsorted(right.times, times[:seen])
    on_grid = right.values[:, np.searchsorted(right.times, grid)]
    return Comparison(
        case=case,
        names=names,
        times=times[:seen],
        values=np.array([file.columns[name][:seen] for name in names]),
        reference=right.values[:, at],
        states=right.states[:, at],
        bound=right.bound,
        size=right.size,
        slope=np.max(np.abs(np.gradient(on_grid, grid, axis=1)), axis=1),
        seen=seen,
        growth=growth,
        predicted=predicted,
        notes=tuple(notes),
    )


def refuse_outside(times: Array, case: Case) -> None:
    """Refuse times before a case begins, or long after it ends.

    Raises
    ------
    UsageError
    """
    start, span = case.start_time, float(times[-1] - case.start_time)
    if times[0] < start - ON_START * abs(span):
        raise UsageError(
            f"the first time is {times[0]:.6g} s, but {case.scene}/{case.name} begins at "
            f"t = {start:.6g} s"
        )
    if span <= 0:
        raise UsageError(f"no sample lies after the start of the case, t = {start:.6g} s")
    if span > LONGEST * case.horizon:
        raise UsageError(
            f"times go on to {times[-1]:.6g} s, but {case.scene}/{case.name} lasts "
            f"{case.horizon:.6g} s: are they in seconds? If they are, cut the file at "
            f"{start + LONGEST * case.horizon:.6g} s"
        )

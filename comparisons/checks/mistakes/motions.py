"""Mistakes in a motion: each is compared by the motion that it predicts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ....reference.equations import ModelEquations
from ....reference.scene import Array, Case
from ....reference.solve import schemes
from ...engines.setup import Setup
from ..comparison import EngineRuns, Part
from ..truth import rows, truth
from .observables import EXPLAINED, SEEN, limited, otherwise_observed

LONG = 32
"""Steps of a continuum that take long to predict."""

PARTS = 8
"""Steps of RK44 in one step of a method without a published scheme."""

FOLLOWED = 256
"""Steps in which a reset is looked for."""

STRETCH, MOST_STRETCH = 1e-7, 1e-3
"""Shares by which steps are tried to be longer, and up to which motions change in proportion."""

SHARES = (32, 8, 2, 1)
"""Divisors of the number of samples of a run: the first share of them is compared before the
next."""

SAMPLED: tuple[tuple[str, dict[str, Any]], ...] = (
    ("the force is constant in each step, as at its start", {"frozen": 0.0}),
    ("the force is constant in each step, as in its middle", {"frozen": 0.5}),
    ("the force is constant in each step, as at its end", {"frozen": 1.0}),
    *(
        (
            "the force is constant in each step, as at the start of the step before",
            {"frozen": 0.0, "late": 1.0, "waits": waits},
        )
        for waits in (False, True)  # in the middle of it is hardly told from late alone
    ),
    *(
        (
            "the force is constant over several steps, as at the start of the first",
            {"frozen": 0.0, "hold": count},
        )
        for count in (2, 3, 4, 5, 8, 10, 16, 20)
    ),
)
"""Ways in which engines and controllers of a lower rate sample a force."""

SHIFTED: tuple[tuple[str, dict[str, Any]], ...] = (
    ("the force is one step late", {"late": 1.0}),
    ("the force is one step late", {"late": 1.0, "waits": True}),
    ("the force is one step early", {"late": -1.0}),
)
"""Shifts of the force in time."""

SUBSTEPS = {
    2: "two of half the size",
    3: "three of a third of the size",
    4: "four of a quarter of the size",
    5: "five of a fifth of the size",
    8: "eight of an eighth of the size",
    10: "ten of a tenth of the size",
}
"""Steps by which an engine may replace each one that it was given."""

STARTS: dict[str, Callable[[str], bool]] = {
    "": bool,
    "the rates of the start are ignored: it moves as from rest": lambda name: (
        not name.endswith("_dot")
    ),
    "the coordinates of the start are ignored: it moves as from the origin": lambda name: (
        name.endswith("_dot")
    ),
    "the start is ignored: it moves as from the origin, at rest": lambda name: False,
}
"""Which values of a start are kept; all of them first, by no mistake."""


class ChangedDrive(schemes.ScalarEquations):
    """Equations whose drive is that at one time, begins with one, or is switched off at one."""

    time: float | None = None
    begin = -np.inf
    end = np.inf

    def drive(self, t: float, q: Sequence[Any]) -> Any:
        """Return the drive, none from its end on."""
        at = max(t if self.time is None else self.time, self.begin)
        return super().drive(at, q) if at < self.end else 0.0


@dataclass(frozen=True)
class Hypothesis:
    """The motion that an engine with a mistake would compute from the start of a case.

    Attributes
    ----------
    case : Case
    numbers : array (n,)
        Of steps.
    scheme : str, optional
        In place of the setup's.
    scene : optional
        Equations in place of the model's.
    late : float
        Number of steps by which the drive is late.
    waits : bool
        Whether the drive keeps its initial value until then.
    end : float
        Time [s] at which the drive ends all the same.
    frozen : float or None
        Time in each step at which a sampled drive is evaluated: 0 is its start, 1 its end.
    hold : int
        Number of steps over which a sampled drive is constant.
    stretch : float
        Relative excess of the length of steps.
    parts : int
        Number of shorter steps that replace each one.
    """

    case: Case
    numbers: Any
    scheme: str | None = None
    scene: Any = None
    late: float = 0.0
    waits: bool = False
    end: float = np.inf
    frozen: float | None = None
    hold: int = 1
    stretch: float = 0.0
    parts: int = 1

    def rows_of(self, runs: EngineRuns) -> Array:
        """Return observables (k, n) in place of those of runs."""
        return self.rows(runs.setup, runs.step, runs.names)

    def rows(self, setup: Setup, step: float, names: tuple[str, ...]) -> Array:
        """Return observables (k, n) after these numbers of steps [s]."""
        scene = self.scene or setup.bound.equations.scene
        own = ModelEquations(scene, setup.bound.equations.parameters)
        scheme, parts = self.scheme or setup.scheme, self.parts
        step = step * (1 + self.stretch)
        if scheme is None:
            scheme, parts = "RK44", PARTS
        begin, x = self.case.start_time - self.late * step, own.start(self.case)
        first = self.case.start_time if self.waits else -np.inf
        if self.frozen is None:
            scalar = ChangedDrive(scene, own.parameters, setup.bound.integrates_drive)
            scalar.begin, scalar.end = first, self.end - self.late * step
            counts = parts * self.numbers
            return rows(
                own, schemes.integrate(scalar, scheme, x, step / parts, counts, begin), names
            )
        frozen, states = ChangedDrive(scene, own.parameters), [x]
        frozen.begin = first
        for i in range(int(np.max(self.numbers))):
            frozen.time = begin + (i // self.hold * self.hold + self.frozen) * step
            x = schemes.integrate(frozen, scheme, x, step / parts, np.array([parts]))[:, 0]
            states.append(x)
        return rows(own, np.array(states)[self.numbers].T, names)


def smallest_rest(seen: EngineRuns, change: Callable[[Part], Hypothesis], most: float) -> float:
    """Return the largest difference of runs from those of an engine with a mistake.

    It is infinite if it is not below ``most``, which the beginning of a part mostly shows.
    """
    left, first = 0.0, 0
    for part in seen.parts:
        count = len(part.numbers)
        for samples in sorted({-(-count // share) for share in SHARES}):
            values = seen.values[:, first : first + samples]
            beginning = part._replace(numbers=part.numbers[:samples])
            rest = seen.away(values, change(beginning).rows_of(seen))
            if not rest < most:
                return np.inf
        left, first = max(left, rest), first + count
    return left


def mistakes(seen: EngineRuns) -> Iterator[tuple[str, Callable[[Part], Hypothesis]]]:
    """Yield the likely mistakes, each with the motion of a part that it predicts."""
    setup = seen.setup
    starts = []
    for words, keeps in STARTS.items():
        states = [
            {name: value for name, value in part.case.state.items() if value and keeps(name)}
            for part in seen.parts
        ]
        if words and states not in starts:
            yield words, partial(changed, keeps=keeps)
        starts.append(states)
    for words, scene in setup.bound.equations.scene.mistakes.items():
        yield words, partial(changed, scene=scene)
    if setup.scheme is None and setup.integrator.order < 2:
        return  # the error of a right one is of the size of what follows
    if stretch := longer_steps(seen):
        words = f"its steps are {'longer' if stretch > 0 else 'shorter'} than the given one"
        yield f"{words}, by {abs(stretch):.3g} of it", partial(changed, stretch=stretch)
    yield "samples are one step late", partial(changed, ahead=-1)
    yield "samples are one step early", partial(changed, ahead=1)
    if setup.bound.equations.scene.drive is not None:
        end = float(setup.scene.drive_end_time(setup.case.parameters)) or np.inf
        for until in sorted({end, np.inf}):
            for words, how in SHIFTED:
                yield words, partial(changed, end=until, **how)
        for words, how in SAMPLED:
            if setup.scheme or "hold" not in how:  # else it is hardly told from late alone
                yield words, partial(changed, **how)
        yield (
            "the time of the start is ignored: the force begins as at t = 0",
            lambda part: changed(part, late=part.case.start_time / seen.step),
        )
    for count, words in SUBSTEPS.items() if setup.scheme else ():
        yield f"each step is made of {words}", partial(changed, parts=count)
    for scheme in schemes.SCHEMES:
        if setup.scheme not in (None, scheme):
            yield f"its steps are those of {scheme}", partial(changed, scheme=scheme)


def longer_steps(seen: EngineRuns) -> float:
    """Return the relative excess of the length of steps that explains the results best."""
    parts = (changed(part, stretch=STRETCH) for part in seen.parts)
    slope = (np.hstack([one.rows_of(seen) for one in parts]) - seen.right) / STRETCH / seen.size
    size = float(np.sum(slope**2))
    stretch = float(np.sum(slope * (seen.values - seen.right) / seen.size)) / size if size else 0.0
    return stretch if abs(stretch) < MOST_STRETCH else 0.0


def changed(
    part: Part, keeps: Callable[[str], bool] = bool, ahead: int = 0, **how: Any
) -> Hypothesis:
    """Return the motion of a part from some values of its start, sampled some steps ahead."""
    state = {name: value for name, value in part.case.state.items() if keeps(name)}
    return Hypothesis(replace(part.case, state=state), part.numbers + ahead, **how)


def with_expected(setup: Setup, step: float, parts: Sequence[Part], values: Array) -> EngineRuns:
    """Return an engine's results (k, n) with a step [s], and the expected ones."""
    names = setup.scene.observables
    if takes_long(setup, parts):  # as the check itself has solved it
        ((case, numbers),) = parts
        right = truth(
            setup.bound.solved_equations, case, case.start_time + numbers * step, names
        ).values
    else:
        right = np.hstack([Hypothesis(*part).rows(setup, step, names) for part in parts])
    return EngineRuns.of(setup, step, parts, values, right)


def takes_long(setup: Setup, parts: Sequence[Part]) -> bool:
    """Return True if predicting parts of a run takes long: many steps of a continuum."""
    longest = max(np.max(part.numbers) for part in parts)
    return bool(setup.scene.discretisation_coordinates) and longest > LONG


def explanation(seen: EngineRuns) -> str:
    """Return the mistake that alone explains the results; empty if there is none."""
    error = seen.error
    if not SEEN < error < np.inf:
        return ""
    words = [*otherwise_observed(seen)]
    if not takes_long(seen.setup, seen.parts):
        left: dict[str, float] = {}
        for said, change in mistakes(seen):
            rest = smallest_rest(seen, change, EXPLAINED * error)
            left[said] = min(rest, left.get(said, np.inf))
        left = {said: rest for said, rest in left.items() if rest < np.inf}
        second = min(sorted(left.values())[1:], default=np.inf)
        words += [said for said, rest in left.items() if rest < EXPLAINED * second] or left
    words = words or [*limited(seen)] or [*after_drive(seen)]
    return words[0] if len(words) == 1 else ""


def after_drive(seen: EngineRuns) -> Iterator[str]:
    """Yield a sentence if only the motion after the end of the drive is wrong."""
    case = seen.setup.case
    end = float(seen.setup.scene.drive_end_time(case.parameters))
    times = [part.case.start_time + part.numbers * seen.step for part in seen.parts]
    early = np.concatenate(times) <= end * (1 + SEEN)
    off = np.max(np.abs(seen.values - seen.right) / seen.size, axis=0)
    if np.any(early) and not np.all(early) and np.max(off[early]) < EXPLAINED * np.max(off):
        yield f"it is right until the drive ends at t = {end:.4g} s, and wrong after that"


def reset(seen: EngineRuns) -> str:
    """Return the time of a reset to the start or the origin that explains all; empty if none."""
    if seen.setup.scene.discretisation_coordinates:
        return ""
    ((case, numbers),) = seen.parts
    off = np.max(np.abs(seen.values - seen.right) / seen.size, axis=0)
    first = int(np.argmax(off > EXPLAINED * np.max(off)))
    if first < 2 or np.max(off[:first]) > EXPLAINED * np.min(off[first:]):
        return ""
    least, words = EXPLAINED * float(np.max(off)), []
    before, after = (case.start_time + int(numbers[i]) * seen.step for i in (first - 1, first))
    values, later = seen.values[:, first:], numbers[first:]
    states = {"its start": dict(case.state)} | ({"the origin": {}} if case.state else {})
    for where, state in states.items():
        begin = replace(case, state=state)

        def left(number: int, count: int | None, begin: Case = begin) -> float:
            """Return the samples after a restart, or all."""
            there = replace(begin, start_time=case.start_time + number * seen.step)
            return seen.away(
                values[:, :count], Hypothesis(there, later[:count] - number).rows_of(seen)
            )

        if seen.away(values, Hypothesis(begin, np.array([0])).rows_of(seen)) < least:
            when = f"between t = {before:.4g} s and {after:.4g} s"
            words.append(f"it is reset to {where} {when}, and stays there")
            continue
        earliest = max(int(numbers[first - 1]), int(later[0]) - FOLLOWED)
        best = min(range(earliest, int(later[0]) + 1), key=lambda number: left(number, 1))
        if left(best, None) < least:
            at = case.start_time + best * seen.step
            words.append(f"it is reset to {where} at t = {at:.4g} s")
    return words[0] if len(words) == 1 else ""

"""Where a deviation comes from: known mistakes of engines, tried one by one on what they predict.

A mistake is named where it alone explains what an engine computes, to a small share of its error.
Where none does, or more than one, nothing is said but what was measured.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from ...reference.linear import linearise
from ...reference.scene import Array, Case
from ...reference.solve import schemes
from ..engines.equations import ModelEquations
from ..engines.run import EPS, call_engine
from ..engines.setup import Setup
from .kinds import algebra, frequency, one_step, stability
from .placement import of_placement
from .tolerances import rows, sample_numbers
from .truth import simulated_horizon, truth
from .units import EXPLAINED, other_measure

SHORT = 512
"""Steps of a run whose first part is looked at before the whole."""

SEEN = 1e-9
"""Relative error below which nothing is asked of a motion."""

PARTS = 8
"""Steps of RK44 in one of a method that is no published scheme."""

ENTRY = 1e-8
"""Part of a matrix by which an entry is off that is no rounding."""

DISTINCT = 8
"""Numbers that are not taken for numbers of 32 bits by chance."""

FOLLOWED = 256
"""Steps in which a reset is looked for."""

INSIDE_STEP = {0.0: "at the start", 0.5: "in the middle", 1.0: "at the end"}
"""Where a step evaluates a force that it holds."""

Steps = Any
"""Numbers of steps, int array (n,)."""


def cause(setup: Setup, kind: str, verdicts: Mapping[str, str]) -> str:
    """Return where a check's deviations come from, empty where a search for that fails.

    Parameters
    ----------
    setup : Setup
    kind : str
    verdicts : mapping of str to str
        On each quantity that was measured.
    """
    looks: dict[str, Callable[[Setup], str]] = {
        "algebra": of_accelerations,
        "frequency": of_matrices,
        "step": of_steps,
    }
    motions = ("trajectory", "order", "stability", "energy")
    try:
        if kind in motions and setup.method is not None and setup.case.watch != "elements":
            looks |= dict.fromkeys(motions, of_runs)
            looks["stability"] = of_orbits
        said = of_placement(setup, kind)
        said = said or (looks[kind](setup) if kind in looks else "")
        said = said or of_numbers(setup)
    except (Exception, SystemExit):  # the engine runs again, which may do anything
        said = ""
    return said or limit_of(kind, verdicts)


def limit_of(kind: str, verdicts: Mapping[str, str]) -> str:
    """Return what halved steps lead to, of kinds that halve them."""
    if kind not in ("order", "stability") or "extrapolated" not in verdicts:
        return ""
    if verdicts["extrapolated"] == "pass":
        return "extrapolated to h -> 0 it is right"
    return (
        "it converges as declared, but to another motion"
        if (kind == "order" and verdicts["order"] == "pass")
        else ""
    )


def of_numbers(setup: Setup) -> str:
    """Return that an engine's numbers have 32 bits, of one that does not declare it."""
    if setup.epsilon > EPS:
        return ""
    if setup.method is None:
        times, states = algebra.random_states(setup.solved_equations, setup.case, setup.coordinates)
        answer = call_engine(
            lambda: setup.engine.accelerations(setup.case, setup.model, times, states)
        ).T
    else:
        step = setup.default_step
        answer = setup.simulate(step, np.arange(1, DISTINCT + 1)).matrix(setup.scene.public_states)
    for row in answer:
        varied = len(np.unique(row)) >= DISTINCT / 2
        if varied and np.array_equal(row.astype(np.float32).astype(float), row):
            return (
                'its numbers have 32 bits: an engine that means to declares precision = "float32"'
            )
    return ""


# Accelerations and matrices


def of_accelerations(setup: Setup) -> str:
    """Return the mistake in the equations of motion that accelerations show."""
    case, equations, names = setup.case, setup.solved_equations, setup.coordinates
    times, states = algebra.random_states(equations, case, names)
    answer = call_engine(lambda: setup.engine.accelerations(case, setup.model, times, states))

    def off(one: ModelEquations) -> float:
        right = algebra.expected(case, one, times, states, names, ())["accelerations"]
        return algebra.distance(answer, right, right)

    error = off(equations)
    words = [
        said
        for said, scene in equations.scene.mistakes.items()
        if scene.coordinates == equations.scene.coordinates
        if off(ModelEquations(scene, equations.parameters)) < EXPLAINED * error
    ]
    return words[0] if len(words) == 1 else ""


def of_matrices(setup: Setup) -> str:
    """Return which of M, C and K are off, and where one alone is."""
    if setup.scene.continuum.spectrum:
        return ""
    scene, parameters, state, _ = frequency.resting(setup.case)
    still = setup.with_case(replace(setup.case, parameters=parameters))
    answer = call_engine(lambda: still.engine.linearise(still.case, still.model, state))
    exact = linearise(scene, frequency.inertial(still), state)
    unit = 1 / np.sqrt(np.diag(exact[0]))
    names, off = scene.coordinates, dict[str, tuple[str, ...]]()
    powers = {"M": 1.0, "C": 0.5, "K": 0.0}
    size = float(np.linalg.norm(exact[2] * np.outer(unit, unit))) or 1.0
    for (letter, power), matrix, right in zip(powers.items(), answer, exact, strict=True):
        change = (np.asarray(matrix) - right) * np.outer(unit, unit) * size ** (power - 1)
        if np.max(np.abs(change)) > ENTRY:
            off[letter] = tuple(
                f"({names[i]}, {names[j]})" for i, j in np.argwhere(np.abs(change) > ENTRY)
            )
    if not off:
        return ""
    sound = " and ".join(letter for letter in powers if letter not in off)
    (places, *more) = off.values()
    where = f" at {' and '.join(places)}" if not more and len(places) <= 2 else ""
    said = f"{' and '.join(off)} {'are' if more else 'is'} off{where}"
    return f"{said}, {sound} {'is' if more else 'are'} right" if sound else said


# Motions


class Part(NamedTuple):
    """A run, or part of it: the case that it starts from, and the numbers of its steps (n,)."""

    case: Case
    numbers: Steps


@dataclass(frozen=True)
class Seen:
    """What an engine computed in some parts, and what it should have.

    Attributes
    ----------
    setup : Setup
    step : float
        Step [s].
    parts : list of Part
    names : tuple of str
    values, right : array (k, n)
        All parts side by side.
    size : array (k, 1)
    """

    setup: Setup
    step: float
    parts: list[Part]
    names: tuple[str, ...]
    values: Array
    right: Array
    size: Array

    def away(self, values: Array, other: Array) -> float:
        """Return the largest difference, relative to the size of each row."""
        return float(np.max(np.abs(values - other) / self.size))

    def predicted(self, change: Callable[[Part], Hypothesis]) -> Array:
        """Return what an engine with a mistake would have computed."""
        return np.hstack([self.rows_of(change(part)) for part in self.parts])

    def rows_of(self, motion: Hypothesis) -> Array:
        """Return observables (k, n) of a motion."""
        return motion.rows(self.setup, self.step, self.names)


class FrozenDrive(schemes.ScalarEquations):
    """Equations whose drive is that at one time."""

    time = 0.0

    def drive(self, t: float, q: Sequence[Any]) -> Any:
        """Return the drive at that time."""
        return super().drive(self.time, q)


@dataclass(frozen=True)
class Hypothesis:
    """What an engine would compute: a motion from the start of a case.

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
        By how many steps the drive is late.
    frozen : float or None
        Where in each step the drive that is held over it is evaluated: 0 is its start, 1 its end.
    """

    case: Case
    numbers: Steps
    scheme: str | None = None
    scene: Any = None
    late: float = 0.0
    frozen: float | None = None

    def rows(self, setup: Setup, step: float, names: tuple[str, ...]) -> Array:
        """Return observables (k, n) after these numbers of steps [s]."""
        equations = setup.with_case(self.case).equations
        scene = self.scene or equations.scene
        own = ModelEquations(scene, equations.parameters)
        scheme, parts = self.scheme or setup.scheme, 1
        if scheme is None:
            scheme, parts = "RK44", PARTS
        begin, x = self.case.start_time - self.late * step, own.start(self.case)
        if self.frozen is None:
            scalar = schemes.ScalarEquations(scene, own.parameters, setup.integrates_drive)
            counts = parts * self.numbers
            return rows(
                own, schemes.integrate(scalar, scheme, x, step / parts, counts, begin), names
            )
        frozen, states = FrozenDrive(scene, own.parameters), [x]
        for i in range(int(np.max(self.numbers))):
            frozen.time = begin + (i + self.frozen) * step
            x = schemes.integrate(frozen, scheme, x, step / parts, np.array([parts]))[:, 0]
            states.append(x)
        return rows(own, np.array(states)[self.numbers].T, names)


def mistakes(seen: Seen) -> Iterator[tuple[str, Callable[[Part], Hypothesis]]]:
    """Yield the mistakes that are tried, each with the motion that it makes of a part."""
    setup = seen.setup
    starts: list[list[dict[str, float]]] = [[dict(part.case.state) for part in seen.parts]]
    for words, keeps in (
        ("the rates of the start are ignored: it moves as from rest", positions),
        ("the coordinates of the start are ignored: it moves as from the origin", rates),
        ("the start is ignored: it moves as from the origin, at rest", nothing),
    ):
        states = [keeps(part.case) for part in seen.parts]
        if not any(same_motion(states, known) for known in starts):
            starts.append(states)
            yield words, partial(changed, keeps=keeps)
    for words, scene in setup.equations.scene.mistakes.items():
        yield words, partial(changed, scene=scene)
    if setup.scheme is None and setup.integrator.order < 2:
        return  # the error of a right one is of the size of what follows
    yield "samples are one step late", partial(changed, ahead=-1)
    yield "samples are one step early", partial(changed, ahead=1)
    if setup.equations.scene.drive is not None:
        yield "the force is one step late", partial(changed, late=1.0)
        yield "the force is one step early", partial(changed, late=-1.0)
        for place, where in INSIDE_STEP.items():
            said = f"the force is held: that {where} of each step"
            yield said, partial(changed, frozen=place)
        yield (
            "the time of the start is ignored: the force begins as at t = 0",
            lambda part: changed(part, late=part.case.start_time / seen.step),
        )
    for scheme in schemes.SCHEMES:
        if setup.scheme not in (None, scheme):
            yield f"its steps are those of {scheme}", partial(changed, scheme=scheme)


def changed(
    part: Part, keeps: Callable[[Case], dict[str, float]] | None = None, ahead: int = 0, **how: Any
) -> Hypothesis:
    """Return the motion of a part from what is left of its start, seen some steps ahead."""
    case = part.case if keeps is None else replace(part.case, state=keeps(part.case))
    return Hypothesis(case, part.numbers + ahead, **how)


def nothing(case: Case) -> dict[str, float]:
    """Return no value of a start."""
    return {}


def same_motion(states: list[dict[str, float]], others: list[dict[str, float]]) -> bool:
    """Return whether starts are the same, but for what is 0."""
    return all(
        {name: value for name, value in one.items() if value}
        == {name: value for name, value in other.items() if value}
        for one, other in zip(states, others, strict=True)
    )


def positions(case: Case) -> dict[str, float]:
    """Return the coordinates of a start."""
    return {name: value for name, value in case.state.items() if not name.endswith("_dot")}


def rates(case: Case) -> dict[str, float]:
    """Return the rates of a start."""
    return {name: value for name, value in case.state.items() if name.endswith("_dot")}


def of_steps(setup: Setup) -> str:
    """Return the mistake in single steps; those of elements of others take long to predict."""
    if setup.discrete:
        return ""
    step = setup.default_step
    cases = one_step.starts(setup.case, setup.solved_equations, step, setup.scheme)
    answer = one_step.after(setup, cases, step, 1)
    places = range(len(setup.scene.observables))
    return explanation(
        looked_at(setup, [Part(one, np.array([1])) for one in cases], answer[places])
    )


def of_orbits(setup: Setup) -> str:
    """Return the mistake in a run that starts on the periodic orbit of the reference."""
    case = setup.case
    if case.watch != "outcome":
        orbit = stability.true_orbit(case.scene, case.parameters)
        state = stability.by_name(setup.scene.state_names, orbit.state)
        setup = setup.with_case(replace(case, state=state))
    return of_runs(setup)


def of_runs(setup: Setup) -> str:
    """Return the mistake in a free run: in its first part, if that is wrong, or in the whole."""
    step = setup.default_step
    horizon = simulated_horizon(setup.case, step, setup.scheme)
    beam = bool(setup.scene.discretisation_coordinates)
    for length in (horizon,) if beam else (min(horizon, SHORT * step), horizon):
        numbers = sample_numbers(length, step)
        answer = setup.simulate(step, numbers).matrix(setup.scene.observables)
        seen = looked_at(setup, [Part(setup.case, numbers)], answer)
        if seen.away(seen.values, seen.right) > SEEN:
            return explanation(seen) or reset(seen)
    return ""


def looked_at(setup: Setup, parts: list[Part], values: Array) -> Seen:
    """Return what an engine computed beside what it should have."""
    step, names = setup.default_step, setup.scene.observables
    if takes_long(setup, parts):  # as the check itself has solved it
        ((case, numbers),) = parts
        right = truth(setup.solved_equations, case, case.start_time + numbers * step, names).values
    else:
        right = np.hstack([Hypothesis(*part).rows(setup, step, names) for part in parts])
    size = np.max(np.abs(right), axis=1, keepdims=True)
    return Seen(setup, step, parts, names, values, right, np.where(size > 0, size, 1.0))


def takes_long(setup: Setup, parts: list[Part]) -> bool:
    """Return whether it takes long to predict parts of a run: many steps of a continuum."""
    return bool(setup.scene.discretisation_coordinates) and max(map(len_of, parts)) > 1


def len_of(part: Part) -> int:
    """Return the number of steps of a part."""
    return int(np.max(part.numbers))


def explanation(seen: Seen) -> str:
    """Return the only mistake that explains what is seen, if there is one."""
    error = seen.away(seen.values, seen.right)
    if not SEEN < error < np.inf:
        return ""
    words = [*exchanged(seen, error), *measured(seen)]
    if not takes_long(seen.setup, seen.parts):
        words += [
            said
            for said, change in mistakes(seen)
            if seen.away(seen.values, seen.predicted(change)) < EXPLAINED * error
        ]
    words = words or [*after_drive(seen)]
    return words[0] if len(words) == 1 else ""


def after_drive(seen: Seen) -> Iterator[str]:
    """Yield that only what follows the end of the drive is wrong."""
    case = seen.setup.case
    end = float(seen.setup.scene.drive_end_time(case.parameters))
    times = [part.case.start_time + part.numbers * seen.step for part in seen.parts]
    early = np.concatenate(times) <= end * (1 + SEEN)
    off = np.max(np.abs(seen.values - seen.right) / seen.size, axis=0)
    if np.any(early) and not np.all(early) and np.max(off[early]) < EXPLAINED * np.max(off):
        yield f"it is right until the drive ends at t = {end:.4g} s, and wrong after that"


def exchanged(seen: Seen, error: float) -> Iterator[str]:
    """Yield which observables stand in each other's place."""
    scale = np.max(np.abs(seen.right)) or 1.0
    distances = np.max(np.abs(seen.values[:, None] - seen.right[None]), axis=2) / scale
    _, order = linear_sum_assignment(np.log(distances + SEEN))
    moved = [i for i, j in enumerate(order) if i != j]
    values = np.empty_like(seen.values)
    values[order] = seen.values
    if moved and seen.away(values, seen.right) < EXPLAINED * error:
        pairs = [f"{seen.names[i]} is {seen.names[order[i]]}" for i in moved]
        yield f"observables are exchanged: {', '.join(pairs)}"


def measured(seen: Seen) -> Iterator[str]:
    """Yield in what other unit, or with which sign, all that deviates is given."""
    said = []
    for name, one, right, size in zip(seen.names, seen.values, seen.right, seen.size, strict=True):
        if np.max(np.abs(one - right)) > EXPLAINED * size[0]:
            unit = seen.setup.scene.units[name]
            said.append(other_measure(name, unit, one, right, float(size[0])))
    if said and all(said):
        yield "; ".join(said)


def reset(seen: Seen) -> str:
    """Return when a run is put back to its start, or to the origin, if that is all that it does."""
    if seen.setup.scene.discretisation_coordinates:
        return ""
    ((case, numbers),) = seen.parts
    off = np.max(np.abs(seen.values - seen.right) / seen.size, axis=0)
    first = int(np.argmax(off > EXPLAINED * np.max(off)))
    if first < 2 or np.max(off[:first]) > EXPLAINED * np.min(off[first:]):
        return ""
    error, words = float(np.max(off)), []
    before, after = (case.start_time + int(numbers[i]) * seen.step for i in (first - 1, first))
    when = f"between t = {before:.4g} s and {after:.4g} s"
    values, later = seen.values[:, first:], numbers[first:]
    for where, state in (("its start", dict(case.state)), ("the origin", {})):
        if state == dict(case.state) and where != "its start":
            continue
        begin = replace(case, state=state)
        still = seen.rows_of(Hypothesis(begin, np.array([0])))
        if seen.away(values, still) < EXPLAINED * error:
            words.append(f"it is put back to {where} {when}, and stays there")
            continue
        best = (np.inf, 0)
        earliest = max(int(numbers[first - 1]), int(later[0]) - FOLLOWED)
        for number in range(earliest, int(later[0]) + 1):
            there = restarted(begin, number, seen.step)
            one = seen.rows_of(Hypothesis(there, later[:1] - number))
            best = min(best, (seen.away(values[:, :1], one), number))
        there = restarted(begin, best[1], seen.step)
        if best[0] < EXPLAINED * error:
            whole = seen.rows_of(Hypothesis(there, later - best[1]))
            if seen.away(values, whole) < EXPLAINED * error:
                words.append(f"it is put back to {where} at t = {there.start_time:.4g} s")
    return words[0] if len(words) == 1 else ""


def restarted(case: Case, number: int, step: float) -> Case:
    """Return a case that starts so many steps [s] later."""
    return replace(case, start_time=case.start_time + number * step)

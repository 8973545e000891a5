"""Causes of deviations: known mistakes of engines, each compared with what it would predict.

A mistake is named if it alone explains an engine's results to a small share of their error, or to a
small share of the error that the next best mistake leaves. Otherwise no cause is named.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import pairwise, permutations

import numpy as np

from ...models.kinematics import mass_matrix
from ...models.mechanism import mechanism
from ...models.placement import world_axes
from ...reference.equations import ModelEquations
from ...reference.errors import CannotJudgeError, EngineError, Unsupported
from ...reference.linear import linearise
from ...reference.scene import Array, EquationsOfMotion
from ...reference.solve.schemes import TABLEAUS
from ..engines.run import EPS, call_engine
from ..engines.setup import Setup, power_of_two
from .comparison import (
    ROUNDING,
    EngineRuns,
    Measured,
    Part,
    ideal_rows,
    matrix_rounding,
    sample_numbers,
)
from .kinds import algebra, frequency, one_step
from .mistakes.motions import LONG, explanation, reset, with_expected
from .mistakes.observables import EXPLAINED, SEEN
from .mistakes.parts import with_axes_of_world, with_tensors_behind
from .orbits import true_orbit
from .truth import after_starts, random_states, simulated_horizon
from .verdict import Finding, judge

DISTINCT = 8
"""So many numbers do not fit 32 bits by chance."""

SHORT = 512
"""Steps in the first part of a run, which is examined before the whole."""

FEW = 3
"""Steps after which a sampled force shows if it is late as well: the first step of a run has no
earlier sample."""

PARTS = (2, 4, 8, 16)
"""Divisions of the longest step by which the order of its error is measured."""

SETTLED_PARTS = tuple(one_step.SETTLED * parts for parts in (1, 2, 4))
"""The same for a method without a published scheme."""

CLEAR = 0.2
"""A measured order counts as a whole number within this distance."""

LEAST = 1e-11
"""Relative error above round-off of so few steps."""

ANOTHER_MODEL = (
    "it converges with its order, but to another motion: the model differs, not the method"
)
"""Cause if changes by halving the step shrink as declared, and the limit is wrong."""

UNMOVED = 1e-3
"""Share of an error of rates by which they would move positions in some steps, were they used."""


@dataclass(frozen=True)
class Deviation:
    """A check that deviates.

    Attributes
    ----------
    setup : Setup
    measure : callable ``(setup) -> Measured``
        The measurement of its kind.
    verdicts : mapping of str to str
        On each quantity that was measured.
    runs : EngineRuns or None
        What was measured.
    asks_forces : bool
        Whether its kind asks for accelerations.
    """

    setup: Setup
    measure: Callable[[Setup], Measured]
    verdicts: Mapping[str, str]
    runs: EngineRuns | None
    asks_forces: bool

    def repeated(self) -> Array:
        """Return accelerations at random states, or observables of a short run, row by row."""
        setup = self.setup
        if self.asks_forces:
            _, times, states = algebra.measured_states(setup)
            ask = setup.bound.accelerations
            return np.asarray(call_engine(lambda: ask(times, states, setup.method))).T
        run = setup.simulate(setup.default_step, np.arange(1, DISTINCT + 1))
        return run.matrix(setup.scene.public_states)

    @cached_property
    def numbers(self) -> Array:
        """The first result of `repeated`."""
        return self.repeated()


Search = Callable[[Deviation], str]
"""Function that returns the mistake that explains a deviation in words, empty if none does."""


def cause(deviation: Deviation, searches: Sequence[Search]) -> str:
    """Return the cause of a check's deviations by the first search that finds one."""
    for search in searches:
        try:
            said = search(deviation)
        except (Exception, SystemExit):  # the engine runs again, which may do anything
            said = ""
        if said:
            return said
    return ""


# One free run, and few steps


def of_run(deviation: Deviation) -> str:
    """Return the mistake in a free run: in its first part, if it is wrong, or in the whole."""
    return mistake_in_run(deviation.setup, deviation.runs)


def of_orbit(deviation: Deviation) -> str:
    """Return the mistake in a run that starts on the periodic orbit of the reference."""
    setup, case = deviation.setup, deviation.setup.case
    if case.watch != "outcome":
        orbit = true_orbit(case.scene, case.parameters)
        state = dict(zip(setup.scene.state_names, map(float, orbit.state), strict=True))
        setup = setup.with_case(replace(case, state=state))
    return mistake_in_run(setup)


def mistake_in_run(setup: Setup, runs: EngineRuns | None = None) -> str:
    """Return the mistake in a free run, of which these runs, if any, are the whole."""
    if setup.method is None or setup.case.watch == "elements":
        return ""
    step = setup.default_step if runs is None else runs.step
    beam = bool(setup.scene.discretisation_coordinates)
    horizon, short = simulated_horizon(setup.case, step, setup.scheme), SHORT * step
    if beam:
        short = LONG * step
    for length in (min(horizon, short), horizon):
        whole = runs if length == horizon else None
        seen = whole or free_run(setup, step, length)
        if seen.error > SEEN:
            said = explanation(seen) or reset(seen)
            if said or not beam:
                return said
    return ""


def free_run(setup: Setup, step: float, length: float) -> EngineRuns:
    """Run an engine freely with a step over a length [s]."""
    numbers = sample_numbers(length, step)
    answer = setup.simulate(step, numbers).matrix(setup.scene.observables)
    return with_expected(setup, step, [Part(setup.case, numbers)], answer)


def of_steps(deviation: Deviation) -> str:
    """Return the mistake in few steps or one; those of elements of others take long to predict."""
    setup, one = deviation.setup, deviation.runs
    if setup.bound.discrete or one is None:
        return ""
    in_time = one_step.driven_in_time(setup, setup.bound.equations)
    few = explanation(after_steps(setup, FEW)) if in_time else ""
    return few or explanation(one)


def after_steps(setup: Setup, count: int) -> EngineRuns:
    """Run an engine for so many steps from each start."""
    step = setup.default_step
    cases = one_step.starts(setup, step, setup.scheme)
    answer = one_step.after(setup, cases, count * step, count)[: len(setup.scene.observables)]
    return with_expected(setup, step, [Part(one, np.array([count])) for one in cases], answer)


# Schemes and orders


def of_order(deviation: Deviation) -> str:
    """Return a sentence if steps are not of the declared scheme, or not of the declared order.

    Only if halved steps converge to the reference: then the equations of motion are right. Errors
    of a single step may be too small to be explained; those of the longest steps here are not.
    """
    setup = deviation.setup
    if setup.bound.discrete or not one_step.quantities(setup):
        return ""
    order, scheme = setup.integrator.order, setup.scheme
    counts = PARTS if scheme else SETTLED_PARTS
    length = (one_step.LONGER if scheme else one_step.SETTLED) * setup.default_step
    if scheme:
        length = min(length, power_of_two(setup.stable_step_bound))
    equations, names = setup.bound.solved_equations, setup.scene.observables
    cases = one_step.starts(setup, length, scheme)
    right = after_starts(equations, cases, length, names)

    def relative(change: Array) -> float:
        """Return the largest change, relative to the size of each observable."""
        return float(np.max(np.abs(change) / right.size[:, None]))

    away, answers = [], []
    for parts in counts:
        answers.append(one_step.after(setup, cases, length, parts)[: len(names)])
        should = right.values
        if scheme:
            steps = [Part(one, np.array([parts])) for one in cases]
            should = ideal_rows(setup, steps, length / parts, names)
        errors = np.max(np.abs(answers[-1] - should), axis=1) / right.size
        away.append(float(np.max(errors)))
    turning = {rate for one in setup.scene.quaternions for rate in one.rates}
    rates = np.array([name.endswith("_dot") or name in turning for name in names])
    half = after_starts(equations, cases, length * (1 - 0.5 / counts[-1]), names)
    behind = np.max((np.abs(answers[-1] - half.values) / right.size[:, None])[rates], initial=0.0)
    if behind < EXPLAINED * np.max(errors[rates], initial=0.0):
        return "rates are half a step behind positions, as those of a leapfrog are"
    if np.max(errors) > LEAST and np.all(errors[~rates] < UNMOVED * np.max(errors)):
        return "positions are right, and the rates returned with them are wrong"
    off = relative(answers[-1] - right.values)
    *_, before, last = (relative(coarse - fine) for coarse, fine in pairwise(answers))
    shrinks = last < LEAST or before > 2 ** (order - CLEAR) * last
    wrong = wrong_forces(setup)
    if shrinks and last < EXPLAINED * off and off > LEAST:
        return "" if wrong is False else ANOTHER_MODEL
    if scheme:
        coarse = [Part(one, np.array([counts[0]])) for one in cases]
        if named := explanation(with_expected(setup, length / counts[0], coarse, answers[0])):
            return named
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
    """Return the order at which errors shrink as steps are halved, 0 if it is no whole number."""
    slopes = [float(np.log2(coarse / fine)) for coarse, fine in pairwise(errors) if fine > LEAST]
    whole = round(slopes[-1]) if slopes else 0
    clear = len(slopes) > 1 and all(abs(slope - whole) < CLEAR for slope in slopes[-2:])
    return whole if clear and whole > 0 else 0


def wrong_forces(setup: Setup) -> bool | None:
    """Return True if accelerations at random states are wrong, None if an engine has none."""
    try:
        findings = algebra.measure(setup).findings
    except (CannotJudgeError, EngineError):
        return None
    return any(isinstance(one, Finding) and judge(one, 1.0)[0] == "deviation" for one in findings)


# Any numbers


def of_limit(deviation: Deviation) -> str:
    """Return a sentence on the limit of halved steps, for kinds that halve them."""
    verdicts = deviation.verdicts
    if verdicts.get("extrapolated") == "pass":
        return "extrapolated to h -> 0 it is right"
    right = verdicts.get("order") == "pass" and "extrapolated" in verdicts
    return ANOTHER_MODEL if right else ""


def of_repetition(deviation: Deviation) -> str:
    """Return a sentence if two identical calls of an engine differ."""
    first, second = deviation.numbers, deviation.repeated()
    size = np.max(np.abs(first), axis=1, keepdims=True)
    apart = float(np.max(np.abs(second - first) / np.where(size > 0, size, 1.0)))
    if apart > matrix_rounding(deviation.setup.epsilon, ROUNDING):
        return f"it does not repeat itself: two identical calls differ by {apart:.2g} of their size"
    return ""


def of_numbers(deviation: Deviation) -> str:
    """Return a sentence if an engine's numbers have 32 bits and it does not declare them."""
    if deviation.setup.epsilon > EPS:
        return ""
    with np.errstate(over="ignore"):  # what no 32 bits hold
        rows = deviation.numbers
        single = rows.astype(np.float32).astype(float)
    fit = (
        np.array_equal(row, rounded)
        for row, rounded in zip(rows, single, strict=True)
        if len(np.unique(row)) >= DISTINCT / 2
    )
    said = 'its numbers have 32 bits: if that was intended, declare precision = "float32"'
    return said if any(fit) else ""


# Mistakes in a model

ENTRY = 1e-8
"""Relative error of an entry of a matrix above which it is no round-off."""

FEW_JOINTS = 4
"""Up to so many joints every order is tried."""

MOST_JOINTS = 8
"""Up to so many joints each exchange of a pair is tried."""

RIGHT = 1e-3
"""Relative error below which an order of joints explains the results."""


# Accelerations and matrices


def accelerations_of(setup: Setup, factor: float = 1.0) -> tuple[Array, Array]:
    """Return accelerations at random states (k, n), an engine's and those of its equations.

    All rates are so many times those of the states.
    """
    case, (names, times, states) = setup.case, algebra.measured_states(setup)
    states = states * np.repeat([1.0, factor], len(names))
    answer = call_engine(lambda: setup.bound.accelerations(times, states, setup.method))
    right = algebra.expected(case, setup.bound.solved_equations, times, states, names, ())
    return np.asarray(answer), right["accelerations"]


def error_of(setup: Setup) -> float:
    """Return the relative error of accelerations at random states."""
    answer, right = accelerations_of(setup)
    return algebra.distance(answer, right, right)


def of_accelerations(deviation: Deviation) -> str:
    """Return the mistake in the equations of motion that accelerations show."""
    setup, answer = deviation.setup, deviation.numbers.T
    names, times, states = algebra.measured_states(setup)
    scene, parameters = setup.bound.solved_equations

    def right_of(one: EquationsOfMotion) -> Array:
        equations = ModelEquations(one, parameters)
        rows = algebra.expected(setup.case, equations, times, states, names, ())
        return rows["accelerations"]

    def error_from(right: Array) -> float:
        return algebra.distance(answer, right, right)

    right = right_of(scene)
    error = error_from(right)
    words = [
        said
        for said, one in scene.mistakes.items()
        if one.coordinates == scene.coordinates
        if error_from(right_of(one)) < EXPLAINED * error
    ]
    if words:
        return words[0] if len(words) == 1 else ""
    return of_softness(setup, error) or of_motion(setup, answer, right)


def of_parts(deviation: Deviation) -> str:
    """Return the same for a model with forces that no share of a part explains."""
    wrong = deviation.verdicts.get("unexplained") == "deviation"
    return of_accelerations(deviation) if wrong else ""


def of_softness(setup: Setup, closed: float) -> str:
    """Name the wrong stiffness or damping of a soft loop; closed it has this error."""
    _, times, states = algebra.measured_states(setup)
    both = call_engine(lambda: algebra.opened(setup, times, states))
    if both is None:
        return ""
    halves = (np.array_split(one, 2) for one in both)
    errors = [algebra.distance(a, b, both[1]) for a, b in zip(*halves, strict=True)]
    if not closed < EXPLAINED * max(errors):
        return ""
    words = zip(("stiffness", "damping"), errors, strict=True)
    granted = matrix_rounding(setup.epsilon, ROUNDING)
    wrong = " and ".join(word for word, error in words if error > granted)
    return (
        f"the loop has another {wrong} than the file says (solref, solimp): "
        "accelerations are right where it is closed, and wrong where it is open"
    )


def of_motion(setup: Setup, moved: Array, right_moved: Array) -> str:
    """Return a sentence if accelerations are right at rest and wrong in motion; empty otherwise.

    Empty too if no force acts at rest.
    """
    (answer, right), back = (accelerations_of(setup, by) for by in (0.0, -1.0))
    acts = np.max(np.abs(right)) > ROUNDING * np.max(np.abs(right_moved))
    there, away = moved - right_moved, np.subtract(*back)
    most = EXPLAINED * float(np.max(np.abs(there)))
    if not acts or not np.max(np.abs(answer - right)) < most:
        return ""
    ends = {
        "by the same in either direction: Coriolis forces are missing or wrong": there - away,
        "by the opposite in the other direction: dampers are missing or wrong": there + away,
    }
    words = [said for said, rest in ends.items() if np.max(np.abs(rest)) < most]
    return " ".join(["accelerations are right at rest, and wrong in motion", *words])


def of_matrices(deviation: Deviation) -> str:
    """Return the names of those of M, C and K that are wrong, and the entries if one alone is."""
    setup = deviation.setup
    if setup.scene.continuum.spectrum:
        return ""
    scene, parameters, state, _ = frequency.resting(setup.case)
    still = setup.with_case(replace(setup.case, parameters=parameters))
    answer = call_engine(lambda: still.bound.linearise(state))
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


# Frames and joints

PLACED = {"turned": "rotated in space", "mirrored": "mirrored"}
"""Words for placements."""


def of_placement(deviation: Deviation) -> str:
    """Return the mistake in how a model is turned; empty if the unturned model deviates too."""
    setup = deviation.setup
    if not setup.case.placement:
        return ""
    how = setup.case.placement.partition(":")[0]
    stands = setup.with_case(replace(setup.case, placement=""))
    if stands.unsupported_reason is not None:
        return ""
    findings = deviation.measure(stands).findings
    if any(isinstance(one, Finding) and judge(one, 1.0)[0] == "deviation" for one in findings):
        return ""
    said = of_reactions(setup) if deviation.measure is algebra.measure else ""
    return (
        said
        or of_frames(setup)
        or f"right for the model as in its file, and wrong for the same model {PLACED[how]}"
    )


def of_frames(setup: Setup) -> str:
    """Return the confusion of frames that alone explains a mass matrix; empty if none does."""
    if not setup.engine.reads_mjcf:
        return ""
    times, states = random_states(setup.bound.equations, setup.case, setup.bound.coordinates)
    q, _ = setup.bound.joint_states(times, states)
    whole = mechanism(setup.bound.text)
    try:
        answer = call_engine(
            lambda: setup.bound.joint_mass_matrices(q, whole.layout.size[1], setup.method)
        )
    except Unsupported:
        return ""

    def off(matrix: Callable[[Array], Array]) -> float:
        right = np.array([matrix(row) for row in q])
        return algebra.distance(answer, right, right)

    error = off(partial(mass_matrix, whole))
    mistakes: dict[str, Callable[[Array], Array]] = {
        "axes of joints are taken in the frame of the world, not of their bodies": partial(
            mass_matrix, with_axes_of_world(whole)
        ),
        "inertia tensors are not turned with their bodies": partial(with_tensors_behind, whole),
    }
    words = [said for said, matrix in mistakes.items() if off(matrix) < EXPLAINED * error]
    return words[0] if len(words) == 1 else ""


def of_reactions(setup: Setup) -> str:
    """Return a sentence if reactions are those in the frame of the world; empty otherwise."""
    case, equations, names = setup.case, setup.bound.solved_equations, setup.bound.coordinates
    reactions = setup.bound.reaction_names
    if not reactions:
        return ""
    times, states = random_states(equations, case, names)
    answer = call_engine(lambda: setup.bound.reactions(times, states))
    right = algebra.expected(case, equations, times, states, names, reactions)
    axes = world_axes(case.placement)[:2, :2]
    firsts = [name for name in reactions if name.endswith("_x")]
    for pair in [(name, f"{name[:-1]}y") for name in firsts if f"{name[:-1]}y" in reactions]:
        values = np.array([answer[name] for name in pair])
        force = np.array([right[name][:, 0] for name in pair])
        error = np.max(np.abs(values - force))
        if not error > 0 or np.max(np.abs(values - axes @ force)) > EXPLAINED * error:
            return ""
    return "reactions have their components along the axes of the world, not of the model"


def of_joints(deviation: Deviation) -> str:
    """Return the exchange of joints that explains wrong accelerations or single steps."""
    setup = deviation.setup
    if setup.scene.discretisation_coordinates or not setup.engine.reads_mjcf:
        return ""
    away = error_of if deviation.asks_forces else (lambda one: after_steps(one, 1).error)
    error = away(setup)
    joints = setup.bound.system(setup.case).joints
    if error < EXPLAINED or len(joints) > MOST_JOINTS:
        return ""
    words: dict[int, list[str]] = {}
    for order in permutations(range(len(joints))):
        moved = [i for i, j in enumerate(order) if i != j]
        if not moved or (len(moved) > 2 and len(joints) > FEW_JOINTS):
            continue
        for inputs_too in (True, False):
            try:
                left = away(replace(setup, engine=setup.engine.reordered(order, inputs_too)))
            except Unsupported:
                return ""
            if left < RIGHT and left < EXPLAINED * error:
                where = "" if inputs_too else " in its results"
                others = (f"{joints[i]} is {joints[order[i]]}" for i in moved)
                said = f"joints are in another order: {', '.join(others)}"
                if len(moved) == 2:
                    said = f"joints {joints[moved[0]]} and {joints[moved[1]]} are exchanged"
                words.setdefault(len(moved), []).append(f"{said}{where}")
    fewest = words[min(words)] if words else []
    return fewest[0] if len(fewest) == 1 else ""

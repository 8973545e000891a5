"""Mistakes in a model: accelerations, matrices, frames and the order of joints show them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import permutations

import numpy as np

from ....models.kinematics import mass_matrix
from ....models.mechanism import mechanism
from ....models.placement import world_axes
from ....reference.equations import ModelEquations
from ....reference.errors import Unsupported
from ....reference.linear import linearise
from ....reference.scene import Array, EquationsOfMotion
from ...engines.run import call_engine
from ...engines.setup import Setup
from ..comparison import ROUNDING, matrix_rounding
from ..kinds import algebra, frequency
from ..mistakes.observables import EXPLAINED
from ..mistakes.terms import with_axes_of_world, with_tensors_behind
from ..truth import random_states
from ..verdict import Finding, judge
from .runs import Deviation, after_steps

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


def of_placement(deviation: Deviation) -> str:
    """Return the mistake in how a model is turned; empty if the unturned model deviates too."""
    setup = deviation.setup
    if not setup.case.placement:
        return ""
    stands = setup.with_case(replace(setup.case, placement=""))
    if stands.unsupported_reason is not None:
        return ""
    findings = deviation.measure(stands).findings
    if any(isinstance(one, Finding) and judge(one, 1.0)[0] == "deviation" for one in findings):
        return ""
    said = of_reactions(setup) if deviation.measure is algebra.measure else ""
    return said or of_frames(setup) or "it is right as the model stands, and wrong where it turns"


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
                where = "" if inputs_too else " in what it returns"
                others = (f"{joints[i]} is {joints[order[i]]}" for i in moved)
                said = f"joints are in another order: {', '.join(others)}"
                if len(moved) == 2:
                    said = f"joints {joints[moved[0]]} and {joints[moved[1]]} are exchanged"
                words.setdefault(len(moved), []).append(f"{said}{where}")
    fewest = words[min(words)] if words else []
    return fewest[0] if len(fewest) == 1 else ""

"""Mistakes in the equations of motion, which accelerations and matrices show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ....reference.linear import linearise
from ....reference.scene import Array
from ...engines.equations import ModelEquations
from ...engines.run import call_engine
from ...engines.setup import Setup
from ..kinds import algebra, frequency
from ..tolerances import matrix_rounding
from ..units import EXPLAINED

ENTRY = 1e-8
"""Part of a matrix by which an entry is off that is no rounding."""


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
    if words:
        return words[0] if len(words) == 1 else ""
    return of_softness(setup, times, states, error) or of_motion(setup, times, states)


def of_softness(setup: Setup, times: Array, states: Array, closed: float) -> str:
    """Return what of a loop that gives way is wrong; closed it has this error."""
    both = call_engine(lambda: algebra.opened(setup, times, states))
    if both is None:
        return ""
    (answer, right), half = both, len(states) // 2
    parts = slice(None, half), slice(half, None)
    errors = [algebra.distance(answer[part], right[part], right) for part in parts]
    if not closed < EXPLAINED * max(errors):
        return ""
    granted = matrix_rounding(setup.epsilon, algebra.ROUNDING)
    both_words = zip(("stiffness", "damping"), errors, strict=True)
    wrong = [word for word, error in both_words if error > granted]
    return (
        f"the loop has another {' and '.join(wrong)} than the file says (solref, solimp): "
        "accelerations are right where it is closed, and wrong where it is open"
    )


def of_motion(setup: Setup, times: Array, states: Array) -> str:
    """Return that accelerations are right at rest and wrong in motion, where that is so."""
    case, n = setup.case, states.shape[1] // 2

    def error_at(factor: float) -> Array:
        """Return errors (k, n) where all rates are so many times those of the states."""
        there = states * np.repeat([1.0, factor], n)
        answer = call_engine(lambda: setup.engine.accelerations(case, setup.model, times, there))
        names = setup.coordinates
        right = algebra.expected(case, setup.solved_equations, times, there, names, ())
        return np.asarray(answer) - right["accelerations"]

    moving, resting, back = (error_at(factor) for factor in (1.0, 0.0, -1.0))
    most = EXPLAINED * float(np.max(np.abs(moving)))
    if not np.max(np.abs(resting)) < most:
        return ""
    said = "accelerations are right at rest, and wrong in motion"
    if np.max(np.abs(moving - back)) < most:
        return f"{said} by the same in either direction: Coriolis forces are missing or wrong"
    if np.max(np.abs(moving + back)) < most:
        return f"{said} by the opposite in the other direction: dampers are missing or wrong"
    return said


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

"""Mistakes in the equations of motion, which accelerations and matrices show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ....reference.equations import ModelEquations
from ....reference.linear import linearise
from ....reference.scene import Array
from ...engines.run import call_engine
from ...engines.setup import Setup
from ..kinds import algebra, frequency
from ..tolerances import matrix_rounding
from ..units import EXPLAINED

ENTRY = 1e-8
"""Part of a matrix by which an entry is off that is no rounding."""


def accelerations_of(
    setup: Setup, equations: ModelEquations | None = None, factor: float = 1.0
) -> tuple[Array, Array]:
    """Return accelerations at random states (k, n), an engine's and those of equations.

    The model's own by default; all rates are so many times those of the states.
    """
    case, (names, times, states) = setup.case, algebra.measured_states(setup)
    states = states * np.repeat([1.0, factor], len(names))
    answer = call_engine(lambda: setup.bound.accelerations(times, states))
    equations = equations or setup.bound.solved_equations
    right = algebra.expected(case, equations, times, states, names, ())["accelerations"]
    return np.asarray(answer), right


def error_of(setup: Setup, equations: ModelEquations | None = None) -> float:
    """Return the relative error of accelerations at random states."""
    answer, right = accelerations_of(setup, equations)
    return algebra.distance(answer, right, right)


def of_accelerations(setup: Setup) -> str:
    """Return the mistake in the equations of motion that accelerations show."""
    equations, error = setup.bound.solved_equations, error_of(setup)
    words = [
        said
        for said, scene in equations.scene.mistakes.items()
        if scene.coordinates == equations.scene.coordinates
        if error_of(setup, ModelEquations(scene, equations.parameters)) < EXPLAINED * error
    ]
    if words:
        return words[0] if len(words) == 1 else ""
    return of_softness(setup, error) or of_motion(setup)


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
    granted = matrix_rounding(setup.epsilon, algebra.ROUNDING)
    wrong = " and ".join(word for word, error in words if error > granted)
    return (
        f"the loop has another {wrong} than the file says (solref, solimp): "
        "accelerations are right where it is closed, and wrong where it is open"
    )


def of_motion(setup: Setup) -> str:
    """Return that accelerations are right at rest and wrong in motion, where that is so.

    Where nothing acts at rest there is nothing to be right.
    """
    moving, (answer, right), back = (accelerations_of(setup, factor=by) for by in (1.0, 0.0, -1.0))
    acts = np.max(np.abs(right)) > algebra.ROUNDING * np.max(np.abs(moving[1]))
    there, away = np.subtract(*moving), np.subtract(*back)
    most = EXPLAINED * float(np.max(np.abs(there)))
    if not acts or not np.max(np.abs(answer - right)) < most:
        return ""
    ends = {
        "by the same in either direction: Coriolis forces are missing or wrong": there - away,
        "by the opposite in the other direction: dampers are missing or wrong": there + away,
    }
    words = [said for said, rest in ends.items() if np.max(np.abs(rest)) < most]
    return " ".join(["accelerations are right at rest, and wrong in motion", *words])


def of_matrices(setup: Setup) -> str:
    """Return which of M, C and K are off, and where one alone is."""
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

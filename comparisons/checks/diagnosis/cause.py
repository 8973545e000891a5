"""Where a check's deviations come from, by its kind."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import permutations

import numpy as np

from ....reference.errors import Unsupported
from ....reference.scene import Array
from ...engines.run import EPS
from ...engines.setup import Setup
from ..kinds import algebra, stability
from ..tolerances import matrix_rounding, sample_numbers
from ..truth import simulated_horizon
from ..units import EXPLAINED
from .equations import accelerations_of, error_of, of_accelerations, of_matrices
from .motions import LONG, SEEN, Part, explanation, looked_at, reset
from .placement import of_placement
from .steps import ANOTHER_MODEL, after_steps, of_order, of_steps

SHORT = 512
"""Steps of a run whose first part is looked at before the whole; a continuum's take long."""

DISTINCT = 8
"""Numbers that are not taken for numbers of 32 bits by chance."""

FEW_JOINTS = 4
"""Joints of which every order is tried."""

MOST_JOINTS = 8
"""Joints of which each pair is tried."""

RIGHT = 1e-3
"""Relative error that other joints' numbers do not leave."""


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
        "parts": lambda setup: (
            of_accelerations(setup) if verdicts.get("unexplained") == "deviation" else ""
        ),
        "frequency": of_matrices,
        "step": of_steps,
    }
    motions = ("trajectory", "order", "stability", "energy")
    try:
        if kind in motions and setup.method is not None and setup.case.watch != "elements":
            looks |= dict.fromkeys(motions, of_runs)
            looks["stability"] = of_orbits
        said = "" if kind == "frequency" else of_repetition(setup)
        said = said or of_placement(setup, kind)
        said = said or (looks[kind](setup) if kind in looks else "")
        said = said or of_numbers(setup)
        if kind in ("parts", "algebra"):
            said = said or of_joints(setup)
        elif kind in looks and kind in ("step", "trajectory", "order"):
            said = said or of_joints(setup) or of_order(setup)
    except (Exception, SystemExit):  # the engine runs again, which may do anything
        said = ""
    return said or limit_of(kind, verdicts)


def limit_of(kind: str, verdicts: Mapping[str, str]) -> str:
    """Return what halved steps lead to, of kinds that halve them."""
    if kind not in ("order", "stability") or "extrapolated" not in verdicts:
        return ""
    if verdicts["extrapolated"] == "pass":
        return "extrapolated to h -> 0 it is right"
    return ANOTHER_MODEL if kind == "order" and verdicts["order"] == "pass" else ""


def numbers_of(setup: Setup) -> Array:
    """Return accelerations at random states, or observables of a short run, row by row."""
    if setup.method is None:
        return accelerations_of(setup)[0].T
    run = setup.simulate(setup.default_step, np.arange(1, DISTINCT + 1))
    return run.matrix(setup.scene.public_states)


def of_repetition(setup: Setup) -> str:
    """Return that an engine does not repeat itself."""
    first, second = numbers_of(setup), numbers_of(setup)
    size = np.max(np.abs(first), axis=1, keepdims=True)
    apart = float(np.max(np.abs(second - first) / np.where(size > 0, size, 1.0)))
    if apart > matrix_rounding(setup.epsilon, algebra.ROUNDING):
        return f"it does not repeat itself: two identical calls differ by {apart:.2g} of their size"
    return ""


def of_numbers(setup: Setup) -> str:
    """Return that an engine's numbers have 32 bits, of one that does not declare it."""
    if setup.epsilon > EPS:
        return ""
    with np.errstate(over="ignore"):  # what no 32 bits hold
        rows = numbers_of(setup)
        single = rows.astype(np.float32).astype(float)
    fit = (
        np.array_equal(row, rounded)
        for row, rounded in zip(rows, single, strict=True)
        if len(np.unique(row)) >= DISTINCT / 2
    )
    said = 'its numbers have 32 bits: an engine that means to declares precision = "float32"'
    return said if any(fit) else ""


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
    for length in (min(horizon, (LONG if beam else SHORT) * step), horizon):
        numbers = sample_numbers(length, step)
        answer = setup.simulate(step, numbers).matrix(setup.scene.observables)
        seen = looked_at(setup, [Part(setup.case, numbers)], answer)
        if seen.error > SEEN:
            said = explanation(seen) or reset(seen)
            if said or not beam:
                return said
    return ""


def of_joints(setup: Setup) -> str:
    """Return which joints are exchanged, if that explains wrong accelerations or single steps."""
    scene = setup.scene
    if scene.discretisation_coordinates or not setup.engine.reads_mjcf:
        return ""
    away = error_of if setup.method is None else (lambda one: after_steps(one, 1).error)
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

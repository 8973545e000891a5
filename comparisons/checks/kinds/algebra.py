"""Check kind *algebra*: accelerations, mass matrix and reactions at random states."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ....reference import get_scene
from ....reference.equations import ModelEquations, scene_equations
from ....reference.errors import Unsupported
from ....reference.scene import Array, Case
from ....reference.solve.bounds import sensitivities
from ...engines.run import EPS, contained
from ...engines.setup import Setup
from ..comparison import (
    OPERATIONS,
    ROUNDING,
    Measured,
    largest_inertias,
    matrix_rounding,
    model_error,
)
from ..truth import RANDOM_STATES, random_states
from ..verdict import Finding, Inconclusive

OPEN = 1e-3
"""Opening of a soft loop (m, rad, and these per second) at which it is judged."""

CANCELLED = 1e-4
"""`ROUNDING` of so small an entry is 45 units of rounding of the terms that it is the sum of."""


def quantities(setup: Setup) -> tuple[str, ...]:
    """Return the names of the measured quantities."""
    names = ("accelerations", "mass_matrix", *setup.bound.reaction_names)
    return (*names, "model_error") if comparable(setup.bound.equations, setup.case) else names


def comparable(equations: ModelEquations, case: Case) -> bool:
    """Return True if a model has other equations than the scene in the same coordinates."""
    return not equations.is_exact_for(case) and not get_scene(case.scene).discretisation_coordinates


def measured_states(setup: Setup) -> tuple[tuple[str, ...], Array, Array]:
    """Return the names of a model's coordinates (n,), random times (k,) and states (k, 2 n)."""
    equations = setup.bound.solved_equations
    names = equations.scene.coordinates if setup.bound.discrete else setup.bound.coordinates
    return names, *random_states(equations, setup.case, names)


def expected(
    case: Case,
    equations: ModelEquations,
    times: Array,
    states: Array,
    names: tuple[str, ...],
    reactions: tuple[str, ...],
) -> dict[str, Array]:
    """Return the quantities of model equations at states (k, 2 n) of some of their coordinates."""
    scene = equations.scene
    derivative = scene.right_hand_side(equations.parameters)
    n, c = len(scene.coordinates), scene.coefficients(equations.parameters)
    inertia = inertias(case, equations, names)
    places = [scene.coordinates.index(name) for name in names]
    keys = (*names, *(f"{name}_dot" for name in names))
    rows: dict[str, list[Array]] = {
        name: [] for name in ("accelerations", "mass_matrix", *reactions)
    }
    for time, state in zip(times, states, strict=True):
        values = dict(zip(keys, map(float, state), strict=True))
        x = equations.start(replace(case, state=values, inconsistency={}))
        rows["accelerations"].append(derivative(time, x)[n:][places])
        rows["mass_matrix"].append(inertia(x))
        if reactions:
            outputs = scene.outputs(x[:n], x[n:], c, np)
            for name in reactions:
                rows[name].append(np.array([outputs[name]]))
    return {name: np.array(values) for name, values in rows.items()}


def opened(setup: Setup, times: Array, states: Array) -> tuple[Array, Array] | None:
    """Return accelerations (k, n) with a loop open, an engine's and those that it should have.

    In the first half of the states (k, 2 n) positions violate the loop, whose stiffness acts; in
    the other half rates do, and its damping acts. None for a rigid loop, or if the engine names no
    joints.
    """
    case, equations = setup.case, setup.bound.equations
    if not (setup.bound.has_soft_closure and setup.engine.reads_mjcf) or case.placement:
        return None
    names, keys = equations.scene.coordinates, setup.bound.coordinates
    keys = (*keys, *(f"{name}_dot" for name in keys))
    off = [{f"{name}{rate}": OPEN for name in names if name not in keys} for rate in ("", "_dot")]
    cases = [
        replace(
            case,
            state=dict(zip(keys, map(float, state), strict=True)),
            start_time=float(time),
            inconsistency=off[2 * i >= len(times)],
        )
        for i, (time, state) in enumerate(zip(times, states, strict=True))
    ]
    systems = [setup.bound.system(one) for one in cases]
    if not {*names} <= {*systems[0].joints}:
        return None
    places = [systems[0].joints.index(name) for name in names]
    q, v = (
        np.array(one)
        for one in zip(*((one.positions, one.velocities) for one in systems), strict=True)
    )
    answer = setup.bound.joint_accelerations(times, q, v, setup.method)
    derivative = equations.scene.right_hand_side(equations.parameters)
    right = [derivative(one.start_time, equations.start(one))[len(names) :] for one in cases]
    return np.asarray(answer)[:, places], np.array(right)


def inertias(
    case: Case, equations: ModelEquations, names: tuple[str, ...]
) -> Callable[[Array], Array]:
    """Return the mass matrix of some coordinates as a function of states (2 n,) of model equations.

    A loop closed by other equations still has the scene's inertia. For some of the model's
    coordinates, with the others at rest, it follows from the energy.
    """
    if names == equations.scene.coordinates:
        scene, p = equations.scene, equations.parameters
    else:
        scene, p = get_scene(case.scene), case.parameters
    c, n = scene.coefficients(p), len(scene.coordinates)
    places = [equations.scene.coordinates.index(name) for name in scene.coordinates]
    units = np.eye(n)[[scene.coordinates.index(name) for name in names]]

    def inertia(x: Array) -> Array:
        q = x[places]
        if names == scene.coordinates:
            return np.array(scene.mass_matrix(q, c), dtype=float)

        def kinetic(v: Array) -> float:
            return float(scene.energy(q, v, c) - scene.energy(q, 0 * v, c))

        return np.array([[kinetic(a + b) - kinetic(a) - kinetic(b) for a in units] for b in units])

    return inertia


def measure(setup: Setup) -> Measured:
    """Compare with the closed form of the model's equations, and these with the scene's."""
    equations = setup.bound.solved_equations
    names, times, states = measured_states(setup)
    reactions = setup.bound.reaction_names
    findings: list[Finding | Inconclusive] = []
    with contained():
        answers = {"accelerations": setup.bound.accelerations(times, states, setup.method)}
        try:
            answers["mass_matrix"] = setup.bound.mass_matrices(states, setup.method)
        except Unsupported as silence:
            findings.append(Inconclusive("mass_matrix", str(silence)))
        if reactions:
            forces = setup.bound.reactions(times, states)
            answers |= {name: np.asarray(forces[name])[:, None] for name in reactions}
        both = opened(setup, times, states)
    truths = expected(setup.case, equations, times, states, names, reactions)
    reason = f"relative error over {RANDOM_STATES} random states"
    room = matrix_rounding(setup.epsilon, ROUNDING)
    cancelled = max(CANCELLED, CANCELLED * ROUNDING / EPS * setup.epsilon / room)
    units = np.array([equations.scene.units.get(name, "1") for name in names])
    for name, reference in truths.items():
        if name not in answers:
            continue
        scale = reference
        if name == "mass_matrix":
            largest = np.sqrt(largest_inertias(reference, units[:, None] == units))
            summed = OPERATIONS * setup.epsilon / room * np.outer(largest, largest)
            # an entry of terms that cancel is not smaller than so many of its two inertias' mean
            inertia = np.sqrt(np.abs(np.diagonal(reference, axis1=1, axis2=2)))
            mean = inertia[:, :, None] * inertia[:, None, :]
            scale = np.maximum(np.maximum(np.abs(reference), cancelled * mean), summed)
        error = distance(answers[name], reference, scale)
        granted = room
        if name == "accelerations":
            granted = max(granted, rounding_of_rates(equations, setup, times, states, reference))
            error = max(error, distance(*both, both[1]) if both else 0.0)
        findings.append(Finding(name, "1", error, 0.0, error, granted, reason))
    if comparable(equations, setup.case):
        exact = expected(setup.case, scene_equations(setup.case), times, states, names, reactions)
        measured, predicted = (
            max(distance(item[name], exact[name], exact[name]) for name in answers)
            for item in (answers, truths)
        )
        reason = f"{reason}: distance of the model from the scene at any step, and its prediction"
        findings.append(model_error(measured, predicted, room, reason))
    return Measured(findings)


def rounding_of_rates(
    equations: ModelEquations, setup: Setup, times: Array, states: Array, accelerations: Array
) -> float:
    """Return the round-off of accelerations (k, n) from that of parameters, states and terms.

    It is relative to the largest of each, see `distance`; in double precision it is far below
    `ROUNDING`.
    """
    if setup.epsilon == EPS or len(states[0]) != 2 * len(equations.scene.coordinates):
        return 0.0
    n = len(equations.scene.coordinates)
    noise = sensitivities(equations.scene, equations.parameters, times, states.T).noise[n:]
    size = np.max(np.abs(accelerations), axis=0)
    return float(OPERATIONS * setup.epsilon * np.max(np.max(noise, axis=1) / (size + (size == 0))))


def distance(values: Array, reference: Array, scale: Array) -> float:
    """Return the largest difference, relative to the largest value of each entry."""
    size = np.max(np.abs(scale), axis=0)
    return float(np.max(np.abs(values - reference) / np.where(size > 0, size, np.max(size) or 1.0)))

"""Rules about an engine's model: its distance from the scene."""

from __future__ import annotations

import dataclasses
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any

import numpy as np

from ....reference.equations import ModelEquations, scene_equations
from ....reference.errors import EngineError
from ....reference.linear import linearise, modes
from ....reference.scene import Case
from ...engines.adapter import Adapter
from ...engines.run import EPS, attempt
from ...engines.setup import Setup
from ..free_vibrations import place
from . import conditions
from .conditions import Statement
from .run import RunConditions, turning_starts

FLOOR = 1e-9
"""Part of an inertia that an engine may add."""

FREQUENCY = 1e-2
"""Part by which the first frequency of a continuum may be off."""

STEADY = "rotation"
"""The steady motion of a continuum about which its frequencies are compared."""


def inertia_floor(run: RunConditions) -> Statement | None:
    """Look for inertias that the model adds to the scene, or that the engine refuses."""
    engine, scene, p = run.engine, run.scene, run.case.parameters
    for item in dataclasses.fields(p):
        value, unit = getattr(p, item.name), item.metadata["unit"]
        if unit in ("kg", "kg m^2") and value > 0:
            least = engine.min_inertia
            refused = conditions.inertia_floor(item.name, value, unit, least, engine.name)
            if refused:
                return refused
    if run.bound.equations.scene is not scene or run.bound.equations.parameters == p:
        return None
    q = scene.state(run.case.state)[: len(scene.coordinates)]
    model, exact = (
        np.diag(np.array(scene.mass_matrix(q, scene.coefficients(one), np), dtype=float))
        for one in (run.bound.equations.parameters, p)
    )
    more = np.abs(model - exact) / exact
    worst = int(np.argmax(more))
    if more[worst] <= FLOOR:
        return None
    return Statement(
        f"the model's inertia of {scene.coordinates[worst]} is {more[worst]:.2g} too large: "
        f"{engine.name} has no point masses"
    )


def closure_softness(run: RunConditions) -> Statement | None:
    """Estimate how far a soft closure opens, from the residual's acceleration and its spring."""
    equations, scene = run.bound.equations, run.scene
    more = len(equations.scene.coordinates) - len(scene.coordinates)
    if equations.scene is scene or equations.scene.discretisation_coordinates or more <= 0:
        return None
    starts = turning_starts(replace(run.case, inconsistency={}), equations)
    opening = max(_opening(equations, tuple(start)) for start in starts)
    closure, size = f"the closure of {run.model}", shortest_length(run.case.parameters)
    return conditions.closure_softness(closure, opening, size, unit="m")


def shortest_length(parameters: Any) -> float:
    """Return the least of the parameters that are positive lengths [m], or 1 m."""
    lengths = (
        getattr(parameters, item.name)
        for item in dataclasses.fields(parameters)
        if item.metadata["unit"] == "m" and item.metadata["bound"] == "positive"
    )
    return min(lengths, default=1.0)


@lru_cache(maxsize=1024)
def _opening(equations: ModelEquations, state: tuple[float, ...]) -> float:
    """Return the opening of the loop under the constant load at a state [m]."""
    scene, parameters = equations
    x, n = np.array(state), len(state) // 2
    moment = 1e-6
    later = x + moment * scene.right_hand_side(parameters)(0.0, x)
    later[:n] += moment**2 / 2 * (later[n:] - x[n:]) / moment
    residual = scene.observe(later, parameters)["velocity_violation"] / moment
    rest = np.concatenate([x[:n], np.zeros(n)])
    fastest = np.sort(np.abs(place(equations, "", rest, False, False).rates))[-4:]
    return float(residual / np.exp(np.mean(np.log(fastest))) ** 2)


def discretisation(run: RunConditions) -> Statement | None:
    """Compare the first frequency of a discretised continuum with the continuum's."""
    if not run.bound.description.element_order:
        return None
    p = run.case.parameters.without_gravity()
    speeds = run.start_speeds(run.scene.steady_coordinates[STEADY])
    if p.drive == "prescribed":  # a torque knows no speed
        speeds.append(abs(p.angular_speed))
    steady = p.replace(drive="prescribed", angular_speed=max(speeds))
    error = frequency_error(run.engine, run.model, run.case.scene, steady)
    if error is None or not abs(error) > FREQUENCY:
        return None
    return Statement(
        f"{p.segments:g} segments put the first frequency {error:+.2g} off that of the continuum",
        "take more",
    )


@lru_cache(maxsize=256)
def frequency_error(engine: Adapter, model: str, scene: str, steady: Any) -> float | None:
    """Return the relative error of the first frequency about steady rotation.

    None if the engine fails to linearise, which a run reports.
    """
    setup = Setup(engine, Case(scene, "", steady), model)
    case, equations = setup.case, setup.bound.equations
    if not setup.bound.approximates_continuum:
        return first_frequency(equations) / first_frequency(scene_equations(case)) - 1
    state = np.array([0.0, steady.angular_speed])
    matrices = attempt(partial(setup.bound.linearise, state))
    if isinstance(matrices, EngineError):
        return None
    omega = min(mode.omega for mode in modes(*matrices) if mode.omega > 0)
    return omega / first_frequency(equations) - 1


def first_frequency(equations: ModelEquations) -> float:
    """Return the first natural frequency about steady rotation [rad/s]."""
    scene, parameters = equations
    state = scene.state(scene.equilibria[STEADY](parameters))
    steady = [scene.coordinates.index(name) for name in scene.steady_coordinates[STEADY]]
    rates = modes(*linearise(scene, parameters, state), steady)
    return min(mode.omega for mode in rates if mode.omega > 0)


def ill_conditioned(run: RunConditions) -> Statement | None:
    """Judge the condition of the scaled mass matrix, and the spread of the modes.

    Stiffness that acts through coordinates of its own costs no digits, however large; in
    redundant coordinates it acts through differences.
    """
    for at in run.start_and_rests:
        m, _, k, _ = at.matrices
        statement = conditions.ill_conditioned(m, f"about {at.name}")
        if statement:
            return statement
        rates = modes(m, 0 * m, k) if run.bound.has_constraints else ()
        omega = [mode.omega for mode in rates if mode.omega > 0]
        lost = EPS * (max(omega) / min(omega)) ** 2 if omega else 0.0
        if lost > conditions.DIGITS:
            return Statement(
                f"modes about {at.name} range from {min(omega):.2g} to {max(omega):.2g} rad/s in "
                "redundant coordinates: rounding of the fast ones leaves the slow ones wrong by "
                f"{lost:.1g}"
            )
    return None

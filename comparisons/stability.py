"""Check kind *stability*: the engine on the periodic orbit of the reference.

Each quantity is measured at h, h/2 and h/4. The change between them predicts the error at
h; what they extrapolate to must be the reference's. The same measurement of the reference's
own flow tells how much of a difference the measurement itself makes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from ..reference import get_scene
from ..reference.periodic import (
    Orbit,
    find_orbit,
    follow_orbit,
    harmonics,
    mean_powers,
    orbit_samples,
    state_scale,
    turn,
)
from ..reference.scene import Array, Case
from ..reference.solver import solve_many
from .engine import EPS, Engine, Method
from .prediction import CAP, SAFETY, effective_parameters, richardson, shortest_period
from .trajectory import simulate
from .verdict import Finding

STEPS_PER_PERIOD = {1: 1024, 2: 128, 3: 96, 4: 64, 5: 48, 6: 32}
"""Steps in the shortest period, by order of the method."""

SAMPLES = 64
PERIODS = 4
"""Periods over which a perturbation is watched."""

PERTURBATION = 1e-4
"""Of the size of each state. Differences are central, so that curvature leaves 1e-8, while
rounding is 1e-12 of the difference."""

NEXT_ORDERS = 3.0
"""On the error of an extrapolated value: the terms of the next two orders may nearly cancel
in the one halving that it is estimated from."""

QUANTITIES = ("closure", "second_harmonic", "power_balance", "multipliers", "growth")

Flow = Callable[[Array, Array], Array]
"""(state (2 n,), times (n_t,) in periods) -> states (2 n, n_t)."""


def quantities(case: Case, method: Method | None) -> tuple[str, ...]:
    """Return the names of what is measured."""
    return (*QUANTITIES, "extrapolated")


def leading_directions(orbit: Orbit, scale: Array) -> tuple[Array, Any]:
    """Return the leading real direction (2 n,) and left eigenvector (2 n,), scaled states."""
    matrix = orbit.monodromy * scale / scale[:, None]
    values, right = np.linalg.eig(matrix)
    left = np.linalg.inv(right)
    first = int(np.argmax(np.abs(values)))
    direction = right[:, first].real
    return direction / np.max(np.abs(direction)), left[first]


def measure_orbit(case: Case, orbit: Orbit, flow: Flow) -> Mapping[str, Array]:
    """Measure everything on the orbit that `QUANTITIES` names; dimensionless arrays."""
    scene = get_scene(case.scene)
    scale = state_scale(scene, orbit.state, 2 * np.pi / orbit.period)
    one = np.array([1.0])
    phases = np.arange(1, SAMPLES + 1) / SAMPLES
    around = flow(orbit.state, phases)
    samples = np.column_stack([orbit.state, around[:, :-1]])
    powers = mean_powers(scene, case.parameters, orbit, samples)
    columns = []
    for i in range(len(scale)):
        step = np.zeros(len(scale))
        step[i] = PERTURBATION * scale[i]
        ends = flow(orbit.state + step, one) - flow(orbit.state - step, one)
        columns.append(ends[:, 0] / scale / (2 * PERTURBATION))
    direction, left = leading_directions(orbit, scale)
    step = PERTURBATION * direction * scale
    marks = np.array([float(PERIODS)])
    apart = flow(orbit.state + step, marks) - flow(orbit.state - step, marks)
    ratio = abs(left @ (apart[:, 0] / scale)) / abs(left @ (2 * step / scale))
    return {
        "closure": (around[:, -1] - orbit.state - turn(scene)) / scale,
        "second_harmonic": np.array([ripple(case, samples)]),
        "power_balance": np.array([sum(powers.values()) / max(map(abs, powers.values()))]),
        "multipliers": matched(np.linalg.eigvals(np.array(columns).T), orbit.multipliers),
        "growth": np.array([ratio ** (1 / PERIODS)]),
    }


def ripple(case: Case, samples: Array) -> float:
    """Return the second-harmonic amplitude of the first turning coordinate [rad]."""
    scene = get_scene(case.scene)
    name, turns = next(iter(scene.turning.items()))
    return harmonics(samples[scene.coordinates.index(name)], turns)[1][1].amplitude


def matched(found: Any, wanted: Any) -> Any:
    """Return eigenvalues in the order of those that they come closest to."""
    rows, columns = linear_sum_assignment(np.abs(wanted[:, None] - found[None, :]))
    return found[columns[np.argsort(rows)]]


def true_values(case: Case, orbit: Orbit) -> Mapping[str, Array]:
    """Return what `measure_orbit` would give without perturbations of finite size."""
    scene = get_scene(case.scene)
    return {
        "closure": np.zeros(len(orbit.state)),
        "second_harmonic": np.array([ripple(case, orbit_samples(scene, case.parameters, orbit))]),
        "power_balance": np.zeros(1),
        "multipliers": orbit.multipliers,
        "growth": np.abs(orbit.multipliers[:1]),
    }


@lru_cache(maxsize=16)
def _reference(scene: str, parameters: Any) -> tuple[Orbit, Any, Any]:
    """Orbit, true values, and the same measured through the reference's flow."""
    orbit = find_orbit(get_scene(scene), parameters)
    case = Case(scene, "", parameters)

    def flow(state: Array, times: Array) -> Array:
        solution = solve_many(
            get_scene(scene), parameters, state, times * orbit.period, tolerance=1e-12
        )
        return solution.states

    return orbit, true_values(case, orbit), measure_orbit(case, orbit, flow)


@lru_cache(maxsize=16)
def _moved(scene: str, parameters: Any, effective: Any) -> Mapping[str, float]:
    """By how much the model's own floor moves each quantity on the true orbit."""
    orbit, truth, _ = _reference(scene, parameters)
    near = follow_orbit(get_scene(scene), effective, orbit)
    values = true_values(Case(scene, "", effective), near)
    size = state_scale(get_scene(scene), orbit.state, 2 * np.pi / orbit.period)
    away = float(np.max(np.abs(near.state - orbit.state) / size))
    growth = float(np.linalg.norm(orbit.monodromy * size / size[:, None], 2))
    return {
        name: float(np.max(np.abs(values[name] - truth[name]))) + away * growth for name in truth
    }


def measure(engine: Engine, case: Case, model: str, method: Method | None) -> list[Finding]:
    """Follow the orbit and its neighbours with three steps, and compare."""
    assert method is not None
    orbit, truth, mirrored = _reference(case.scene, case.parameters)
    per_period = STEPS_PER_PERIOD[min(method.order, max(STEPS_PER_PERIOD))]
    per_orbit = per_period * orbit.period / shortest_period(case)
    count = SAMPLES * int(np.ceil(per_orbit / SAMPLES))
    runs = [through(engine, case, model, method, orbit, count * k) for k in (1, 2, 4)]
    floors = floor(engine, case, model, orbit, truth, mirrored, count)
    estimates = {name: richardson([run[name] for run in runs], method.order) for name in QUANTITIES}
    clear = [name for name in QUANTITIES if estimates[name].change > 100 * floors[name]]
    share = max((estimates[name].spread / estimates[name].change for name in clear), default=0.0)
    together = richardson(
        [np.concatenate([run[name] for name in QUANTITIES]) for run in runs], method.order
    )
    shrinks = together.shrinks(max(floors.values()))
    findings = []
    worst = (0.0, 1.0)
    for name, estimate in estimates.items():
        error = float(np.max(np.abs(runs[0][name] - truth[name])))
        tolerance = min(estimate.predicted, CAP) if shrinks else 0.0
        findings.append(
            Finding(
                name,
                "1" if name != "second_harmonic" else "rad",
                float(np.max(np.abs(runs[0][name]))),
                float(np.max(np.abs(truth[name]))),
                error,
                tolerance + floors[name],
                f"{count} steps per period; halving divides the error by {together.ratio:.3g}, "
                f"{2**method.order} expected",
            )
        )
        away = float(np.max(np.abs(estimate.limit - truth[name])))
        room = min(NEXT_ORDERS * share * estimate.change, CAP**2) + floors[name]
        worst = max(worst, (away, room), key=lambda pair: pair[0] / pair[1])
    away, room = worst
    reason = "all of these extrapolated to h -> 0, the worst for its tolerance"
    return [*findings, Finding("extrapolated", "1", away, 0.0, away, room, reason)]


def through(
    engine: Engine, case: Case, model: str, method: Method, orbit: Orbit, count: int
) -> Mapping[str, Array]:
    """Measure the orbit through the engine with ``count`` steps per period."""
    scene = get_scene(case.scene)

    def flow(state: Array, times: Array) -> Array:
        start = replace(case, state=dict(zip(scene.state_names, map(float, state), strict=True)))
        samples = np.rint(times * count).astype(int)
        trajectory = simulate(engine, start, model, method, orbit.period / count, samples)
        return trajectory.matrix(scene.state_names)

    return measure_orbit(case, orbit, flow)


def floor(
    engine: Engine,
    case: Case,
    model: str,
    orbit: Orbit,
    truth: Mapping[str, Array],
    mirrored: Mapping[str, Array],
    count: int,
) -> Mapping[str, float]:
    """Return what measurement, rounding and the model's own floor cost each quantity."""
    growth = float(np.linalg.norm(orbit.monodromy, 2))
    noise = EPS * (16 + np.sqrt(PERIODS * 4 * count)) * max(growth, 1.0)
    room = {name: SAFETY * float(np.max(np.abs(mirrored[name] - truth[name]))) for name in truth}
    room = {
        name: value + noise / (PERTURBATION if name in ("multipliers", "growth") else 1.0)
        for name, value in room.items()
    }
    effective = effective_parameters(engine, case, model)
    if effective != case.parameters:
        moved = _moved(case.scene, case.parameters, effective)
        room = {name: value + SAFETY * moved[name] for name, value in room.items()}
    return room

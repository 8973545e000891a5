"""Check kind *stability*: the engine on the periodic orbit of the reference.

Each quantity is measured at h, h/2 and h/4. The change between them predicts the error at
h; what they extrapolate to must be the reference's, on which the same measurement is made.
A case with an outcome must end in the same motion as the reference's. A case with a boundary is
judged by that in place of the orbit (`boundary`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from ....reference import get_scene
from ....reference.equations import ModelEquations, scene_equations
from ....reference.errors import CannotJudgeError, NoOrbitError
from ....reference.orbits import (
    Orbit,
    mean_powers,
    period_advance,
    state_scale,
)
from ....reference.periodic import harmonics
from ....reference.scene import Array, Case
from ....reference.solve.batched import solve_many
from ....reference.solve.single import solve
from ...engines.setup import Setup, shortest_period
from .. import boundary
from ..comparison import (
    CAP,
    CLEAR,
    NEXT_ORDERS,
    ORBIT_REFINEMENTS,
    Measured,
    Richardson,
    converging,
    model_error,
    richardson,
    sample_numbers,
)
from ..orbits import orbit_step, true_orbit
from ..verdict import Finding, Inconclusive

SAMPLES = 64
PERIODS = 2
"""Periods over which a perturbation is followed."""

PERTURBATION = 1e-4
"""Perturbation, relative to the size of each state. Differences are central, so that the error by
curvature is 1e-8, while round-off is 1e-12 of the difference."""

QUANTITIES = ("closure", "second_harmonic", "power_balance", "multipliers", "growth")

Flow = Callable[[Array, Array], Array]
"""(states (2 n, m), times (n_t,) in periods) -> states (2 n, m, n_t)."""


def quantities(setup: Setup) -> tuple[str, ...]:
    """Return the names of the measured quantities."""
    if setup.case.boundary is not None:
        return boundary.quantities(setup)
    if setup.case.watch == "outcome":
        return ("outcome",)
    names = (*QUANTITIES, *setup.scene.orbit.units, "extrapolated")
    return names if setup.bound.is_exact else (*names, "model_error")


def leading_directions(orbit: Orbit, scale: Array) -> tuple[Array, Any]:
    """Return the leading real direction (2 n,) and left eigenvector (2 n,), scaled states."""
    matrix = orbit.monodromy * scale / scale[:, None]
    values, right = np.linalg.eig(matrix)
    left = np.linalg.inv(right)
    moduli = np.abs(values)
    if orbit.trivial is not None:
        moduli[np.argmin(np.abs(values - orbit.multipliers[orbit.trivial]))] = 0.0
    first = int(np.argmax(moduli))
    direction = right[:, first].real
    return direction / np.max(np.abs(direction)), left[first]


def measure_orbit(case: Case, orbit: Orbit, flow: Flow) -> Mapping[str, Array]:
    """Measure everything on the orbit that `quantities` names; angles as exp(i angle)."""
    scene = get_scene(case.scene)
    scale = state_scale(scene, orbit.state, 2 * np.pi / orbit.period)
    phases = np.arange(1, SAMPLES + 1) / SAMPLES
    around = flow(orbit.state[:, None], phases)[:, 0]
    samples = np.column_stack([orbit.state, around[:, :-1]])
    powers = mean_powers(scene, samples, scene.coefficients(case.parameters), orbit.period)
    shifts = PERTURBATION * np.diag(scale)
    ends = flow(orbit.state[:, None] + np.hstack([shifts, -shifts]), np.array([1.0]))[..., 0]
    slopes = (ends[:, : len(scale)] - ends[:, len(scale) :]) / scale[:, None] / (2 * PERTURBATION)
    direction, left = leading_directions(orbit, scale)
    step = PERTURBATION * direction * scale
    pair = np.column_stack([orbit.state + step, orbit.state - step])
    apart = flow(pair, np.array([float(PERIODS)]))[..., 0] @ [1, -1]
    ratio = abs(left @ (apart / scale)) / abs(left @ (2 * step / scale))
    equations = scene.orbit.quantities(samples, scene.coefficients(case.parameters))
    name, turns = next(iter(scene.rotations_per_period.items()))
    second = harmonics(samples[scene.coordinates.index(name)], turns)[1][1]
    values = np.linalg.eigvals(slopes)
    _, columns = linear_sum_assignment(np.abs(orbit.multipliers[:, None] - values))
    return {
        "closure": (around[:, -1] - orbit.state - period_advance(scene)[:, 0]) / scale,
        "second_harmonic": np.array([second.amplitude]),
        "power_balance": np.array([sum(powers.values()) / max(map(abs, powers.values()))]),
        "multipliers": values[columns],
        "growth": np.array([ratio ** (1 / PERIODS)]),
        **{
            name: np.array([np.exp(1j * equations[name]) if unit == "rad" else equations[name]])
            for name, unit in scene.orbit.units.items()
        },
    }


@lru_cache(maxsize=16)
def model_orbit(
    equations: ModelEquations, scene: str, parameters: Any
) -> tuple[Mapping[str, Array], float]:
    """Return the orbit as measured through the flow of a model's equations.

    Second comes the bound on the error of that flow, relative to the size of each state.
    """
    orbit = true_orbit(scene, parameters)
    case = Case(scene, "", parameters)
    names = get_scene(scene).state_names
    scale = state_scale(get_scene(scene), orbit.state, 2 * np.pi / orbit.period)
    worst = 0.0

    def flow(states: Array, times: Array) -> Array:
        nonlocal worst
        cases = [replace(case, state=by_name(names, state)) for state in states.T]
        starts = np.column_stack([equations.start(item) for item in cases])
        times = times * orbit.period
        if equations.scene is get_scene(scene):
            parameters = equations.parameters
            solution = solve_many(equations.scene, parameters, starts, times, tolerance=1e-12)
            ends, bound = solution.states, solution.error_bound
        else:  # stiff closures are better followed one by one, with error control
            solutions = [
                solve(equations.scene, equations.parameters, start, times) for start in starts.T
            ]
            ends = np.stack([item.states for item in solutions], axis=1)
            bound = np.stack([item.error_bound for item in solutions], axis=1)
        rows = [equations.scene.state_names.index(name) for name in names]
        worst = max(worst, float(np.max(bound[rows] / scale[:, None])))
        return ends[rows]

    return measure_orbit(case, orbit, flow), worst


@dataclass(frozen=True)
class OrbitRuns:
    """The orbit of an engine with three steps, and of its model's equations.

    Attributes
    ----------
    runs : list of three mappings
        At h, h/2 and h/4.
    estimates : mapping of str to Richardson
    floors : mapping of str to float
        Errors of each quantity by round-off and by the reference.
    sizes : mapping of str to float
    share : float
        Part of the change with the step that the next order makes.
    ratio : float
        Factor by which halving the step divides the error.
    shrinks : bool
        Whether the errors shrink as declared.
    small : bool
        Whether the step changes no quantity by more than `CAP`.
    """

    runs: list[Mapping[str, Array]]
    estimates: Mapping[str, Richardson]
    floors: Mapping[str, float]
    sizes: Mapping[str, float]
    share: float
    ratio: float
    shrinks: bool
    small: bool

    @property
    def regular(self) -> list[str]:
        """Names of quantities that converge with the declared order, and so can be extrapolated."""
        return [name for name, one in self.estimates.items() if one.is_regular(self.floors[name])]

    @property
    def lost_in_roundoff(self) -> list[str]:
        """Names of quantities of which round-off may exceed `CAP`."""
        return [name for name in self.floors if self.floors[name] > CAP * self.sizes[name]]

    def room(self, name: str) -> float:
        """Return the tolerance of a value extrapolated to h -> 0."""
        step = NEXT_ORDERS * self.share * self.estimates[name].change
        return min(step, CAP**2 * self.sizes[name]) + self.floors[name]


def measured(
    setup: Setup, orbit: Orbit, right: Mapping[str, Array], bound: float, count: int
) -> OrbitRuns:
    """Follow the orbit with ``count`` steps per period, twice and four times as many."""
    runs = [through(setup, orbit, count * k) for k in (1, 2, 4)]
    growth = max(float(np.linalg.norm(orbit.monodromy, 2)), 1.0)
    noise = setup.epsilon * (16 + np.sqrt(PERIODS * 4 * count)) * growth + 2 * bound
    moved = {"multipliers": noise / PERTURBATION, "growth": noise / PERTURBATION}
    floors = {name: size_of(name, right) * moved.get(name, noise) for name in right}
    estimates = {
        name: richardson([run[name] for run in runs], setup.integrator.order) for name in right
    }
    clear = [name for name in right if estimates[name].change > CLEAR * floors[name]]
    share = max(
        (float(np.max(estimates[name].moved)) / estimates[name].change for name in clear),
        default=0.0,
    )
    sizes = {name: size_of(name, right) for name in right}
    together = richardson(
        [np.concatenate([run[name] / sizes[name] for name in right]) for run in runs],
        setup.integrator.order,
    )
    shrinks = together.shrinks(max(floors[name] / sizes[name] for name in right))
    small = all(estimates[name].predicted <= CAP * sizes[name] for name in right)
    return OrbitRuns(runs, estimates, floors, sizes, share, together.ratio, shrinks, small)


def measure(setup: Setup) -> Measured:
    """Measure an orbit, a stability boundary or the outcome of a run, as the case says."""
    if setup.case.boundary is not None:
        return Measured(boundary.measure(setup))
    if setup.case.watch == "outcome":
        return Measured([outcome(setup)])
    return Measured(of_orbit(setup))


def of_orbit(setup: Setup) -> list[Finding | Inconclusive]:
    """Follow the orbit and its neighbours with three steps, and compare."""
    scene = setup.scene
    try:
        orbit = true_orbit(setup.case.scene, setup.case.parameters)
    except NoOrbitError as none:
        raise CannotJudgeError(str(none)) from none
    equations = setup.bound.equations
    right, bound = model_orbit(equations, setup.case.scene, setup.case.parameters)
    longest = orbit_step(setup)
    count = SAMPLES * int(np.ceil(orbit.period / longest / SAMPLES))
    for refinement in range(ORBIT_REFINEMENTS):
        orbits = measured(setup, orbit, right, bound, count * 2**refinement)
        if orbits.shrinks and orbits.small:
            break
    if not orbits.small:
        steps = count * 2**refinement
        raise CannotJudgeError(f"errors with {steps} steps per period exceed {CAP:.0%}")
    units = {"second_harmonic": "rad"} | dict(scene.orbit.units)
    findings: list[Finding | Inconclusive] = []
    note = (
        f"{count * 2**refinement} steps per period; halving divides the error by "
        f"{orbits.ratio:.3g}, {2**setup.integrator.order} expected"
    )
    for name, estimate in orbits.estimates.items():
        if name in orbits.lost_in_roundoff:
            share = orbits.floors[name] / orbits.sizes[name]
            findings.append(Inconclusive(name, f"round-off may reach {share:.2g} of its size"))
            continue
        value = orbits.runs[0][name]
        finding = Finding(
            name,
            units.get(name, "1"),
            number_of(value, name, units),
            number_of(right[name], name, units),
            float(np.max(np.abs(value - right[name]))),
            0.0,
            note,
        )
        findings.append(converging(finding, estimate, orbits.floors[name], orbits.shrinks))
    regular = [name for name in orbits.regular if name not in orbits.lost_in_roundoff]
    if not regular:
        silence = "no quantity converges with the declared order, so that none is extrapolated"
        names = ("extrapolated",) if setup.bound.is_exact else ("extrapolated", "model_error")
        return findings + [Inconclusive(name, silence) for name in names]
    limits = {name: orbits.estimates[name].limit for name in regular}
    away = {name: float(np.max(np.abs(limit - right[name]))) for name, limit in limits.items()}
    worst = max(away, key=lambda name: away[name] / orbits.room(name))
    reason = f"all of these extrapolated to h -> 0, the worst ({worst}) for its tolerance"
    if irregular := [name for name in right if name not in limits]:
        reason += f"; without {', '.join(irregular)}, not in the asymptotic range yet"
    findings.append(
        Finding("extrapolated", "1", away[worst], 0.0, away[worst], orbits.room(worst), reason)
    )
    if not setup.bound.is_exact:
        exact, _ = model_orbit(scene_equations(setup.case), setup.case.scene, setup.case.parameters)
        off, predicted = (
            max(
                float(np.max(np.abs(item[name] - exact[name]))) / orbits.sizes[name]
                for name in limits
            )
            for item in (limits, right)
        )
        granted = max(orbits.room(name) / orbits.sizes[name] for name in limits)
        reason = f"distance of the model's orbit from the scene's: {equations.scene.title}"
        findings.append(model_error(off, predicted, granted, reason))
    return findings


def by_name(names: tuple[str, ...], state: Array) -> dict[str, float]:
    """Return the values of a state (2 n,) by name."""
    return dict(zip(names, map(float, state), strict=True))


def size_of(name: str, right: Mapping[str, Array]) -> float:
    """Return the size to which an error is related: 1, or that of a quantity of the scene."""
    return 1.0 if name in QUANTITIES else float(np.max(np.abs(right[name]))) or 1.0


def number_of(values: Any, name: str, units: Mapping[str, str]) -> float:
    """Return the number that represents values in a report."""
    if name not in QUANTITIES and units[name] == "rad":
        return float(np.angle(values[0]))
    return float(np.max(np.abs(values))) if name in QUANTITIES else float(values[0])


def through(setup: Setup, orbit: Orbit, count: int) -> Mapping[str, Array]:
    """Measure the orbit through the engine with ``count`` steps per period."""
    scene = setup.scene

    def flow(states: Array, times: Array) -> Array:
        samples = np.rint(times * count).astype(int)
        step = orbit.period / count
        runs = []
        for state in states.T:
            start = replace(setup.case, state=by_name(scene.state_names, state))
            runs.append(setup.with_case(start).simulate(step, samples))
        return np.stack([run.matrix(scene.state_names) for run in runs], axis=1)

    return measure_orbit(setup.case, orbit, flow)


OUTCOME_TOLERANCES = (1e-9, 1e-7)
"""Tolerances of a reference of which only the final motion counts."""

LOOKS = 16
"""Samples in the shortest period of a run of which only the outcome counts."""


def outcome(setup: Setup) -> Finding:
    """Compare where the run ends, in one of the scene's long-term motions.

    Raises
    ------
    CannotJudgeError
        If the reference itself is undecided.
    """
    scene, case = setup.scene, setup.case
    assert scene.outcome is not None
    step = setup.default_step
    count = int(np.ceil(LOOKS * case.horizon / shortest_period(setup.case)))
    samples = sample_numbers(case.horizon, step, count)
    times = case.start_time + samples * step
    solution = solve(
        scene,
        case.parameters,
        scene.state(case.state),
        times,
        case.start_time,
        OUTCOME_TOLERANCES,
    )
    wanted = scene.outcome(times, scene.observe(solution.states, case.parameters), case.parameters)
    if wanted == "undecided":
        raise CannotJudgeError("the reference itself has not settled within the horizon")
    outcome = scene.outcome(times, setup.simulate(step, samples).values, case.parameters)
    wrong = float(outcome != wanted)
    return Finding(
        "outcome",
        "1",
        wrong,
        0.0,
        wrong,
        0.25,
        f"after {case.horizon:.3g} s the engine is {outcome!r}, the reference {wanted!r}",
    )

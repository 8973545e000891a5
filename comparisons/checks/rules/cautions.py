"""Warnings of rules before a run.

They follow from the case, from the linearised equations of the model, and from the effect of the
method on free vibrations.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Any

import numpy as np
from scipy.linalg import eigh

from ....reference.amplification import excess, numerical_modes
from ....reference.differences import PROBE, probed
from ....reference.equations import ModelEquations, scene_equations
from ....reference.errors import EngineError
from ....reference.linear import linearise, modes
from ....reference.scene import Case, Dynamics
from ...engines.adapter import Adapter
from ...engines.run import EPS, attempt
from ...engines.setup import Setup
from ..comparison import CAP
from ..free_vibrations import place, stable_step, start_and_rests
from ..truth import MOST_AMPLIFICATION
from ..verdict import RULE
from . import conditions
from .conditions import MEANINGS, Statement
from .run import QUARTERS, RunConditions, turning_starts

# Step, method and motion

PHASE, TURN = CAP, 0.2 * np.pi
"""Acceptable phase errors [rad] at the end of a run: of a mode, where it is known exactly, and of a
turn, where only its order of magnitude is known."""

LOSS = CAP
"""Relative change of an amplitude that a method may cause."""

VISIBLE = 1.5
"""Modes faster than this many times the fastest that the exact motion has are not seen in it."""

NEWTON = 1e-6
"""Largest acceptable tolerance of Newton's method, as a share of the motion."""

REST = 1e-9
"""How far [rad, m] from a state of rest a run counts as started there."""

LONG, STEPS = 12, 24
"""Periods over which the variational equations are solved to learn how errors grow, and steps in
each."""

PASSING = 1e-2
"""Part of a passage of the singular position that may be lost."""


def step_limit(run: RunConditions) -> Statement | None:
    """Compare the step with the longest that keeps free vibrations bounded."""
    scheme, horizon = str(run.linear_scheme), run.horizon
    unsafe = any(excess(scheme, at.modes, run.step_size, horizon) > 0 for at in run.places)
    bound = stable_step(run, horizon) if unsafe else None
    if bound is None:
        return None
    limit, at, mode = bound
    place, name = f"{mode.coordinate} about {at.name}", run.integrator.name
    return conditions.step_limit(run.step_size, limit, mode.omega, place, name)


def mode_errors(run: RunConditions) -> list[tuple[float, float, float]]:
    """Return the errors of the method in the modes of the motion, at the end of the run.

    They are the modulus of the eigenvalue [1/s], the phase error [rad], and the logarithm of the
    growth factor of the amplitude of each mode. A mode counts until its own damping ends it.
    """
    errors = []
    for at in run.places:
        for exact, numerical in numerical_modes(str(run.linear_scheme), at.modes, run.step_size):
            if abs(exact) <= VISIBLE * run.speed:
                span = min(run.horizon, 1 / -exact.real if exact.real < 0 else np.inf)
                off = (numerical - exact) * span
                errors.append((abs(exact), abs(off.imag), off.real))
    return errors


def coarse_step(run: RunConditions) -> Statement | None:
    """Estimate the phase that the method loses, of modes and of turns."""
    p, turn = run.integrator.order, run.fastest_turn

    def estimate(omega: float) -> float:
        """Return the phase error of a motion of this circular frequency [rad/s]."""
        share = (run.step_size * omega) ** p / math.factorial(p + 1)
        return float(share * omega * run.horizon)

    late = [(TURN, turn, run.ripple * estimate(turn))]
    if run.linear_scheme is None:
        late.append((TURN, run.speed, estimate(run.speed)))
    late += [(PHASE, omega, phase) for omega, phase, _ in mode_errors(run)]
    most, omega, phase = max(late, key=lambda item: item[2] / item[0])
    period = 2 * np.pi / omega if omega else math.inf
    method = f"{run.integrator.name}, order {p}, after {run.horizon:.4g} s"
    return conditions.coarse_step(run.step_size, period, phase, most, method)


def numerical_damping(run: RunConditions) -> Statement | None:
    """Compare the numerical damping of a mode with its own damping."""
    errors = mode_errors(run) or [(0.0, 0.0, 0.0)]
    omega, _, gain = max(errors, key=lambda error: abs(error[2]))
    if abs(gain) <= LOSS:
        return None
    return Statement(
        f"{run.integrator.name} itself {'loses' if gain < 0 else 'gains'} "
        f"{abs(np.expm1(gain)):.2g} of the amplitude of the mode of {omega:.4g} rad/s within "
        f"{run.horizon:.4g} s",
        "shorten the step",
    )


def clock_rounding(run: RunConditions) -> Statement | None:
    """Count the rounding of a clock that adds up its steps."""
    if not run.engine.accumulates_clock:
        return None
    end = abs(run.case.start_time) + run.horizon
    steps, clock = run.horizon / run.step_size, f"the clock of {run.engine.name}"
    return conditions.clock_rounding(run.step_size, clock, steps, end, run.speed)


def newton_tolerance(run: RunConditions) -> Statement | None:
    """Compare where Newton's method stops with the size of the motion."""
    tolerance = run.engine.newton_tolerance
    if not tolerance or run.integrator.scheme is not None:
        return None
    sizes = {name: size for name, size in motion_size(run).items() if size > 0}
    name = min(sizes, key=lambda one: sizes[one], default="")
    if not sizes or tolerance <= NEWTON * sizes[name]:
        return None
    unit = run.scene.units.get(name, "rad")
    return Statement(
        f"Newton's method stops at increments of {tolerance:.2g}, {tolerance / sizes[name]:.2g} of "
        f"the motion of {name} ({sizes[name]:.2g} {unit})",
        "tighten newton_tolerance",
    )


def motion_size(run: RunConditions) -> dict[str, float]:
    """Return the least amplitude of each coordinate of the exact scene; 1 rad if it turns.

    It follows from initial positions, initial speeds in a mode, and deflections by static loads.
    """
    scene = run.scene
    q, v = np.split(scene.state(run.case.state), 2)
    c = scene.coefficients(run.case.parameters)
    load = np.zeros(len(q))
    for quarter in QUARTERS if scene.drive else QUARTERS[:1]:
        time = run.case.start_time + quarter / 2 / np.pi * run.period
        u = scene.drive(time, c, np) if scene.drive else 0.0
        load = np.maximum(load, np.abs(scene.forces(u, q, v, c, np)))
    at_rest = start_and_rests(scene_equations(run.case), tuple(q))[0]
    mass, _, stiffness, _ = (np.abs(np.diag(matrix)) for matrix in at_rest.matrices)
    resist = np.maximum(stiffness, mass * run.speed**2)
    sizes = np.maximum(np.maximum(np.abs(q), load / resist), np.abs(v) * np.sqrt(mass / resist))
    return {
        name: max(1.0, size) if name in scene.rotations_per_period else float(size)
        for name, size in zip(scene.coordinates, sizes, strict=True)
        if name not in scene.discretisation_coordinates
    }


def engine_range(run: RunConditions) -> Statement | None:
    """Compare expected positions, rates and accelerations with the largest that an engine takes."""
    largest, n = run.engine.max_value, len(run.start) // 2
    if not math.isfinite(largest):
        return None
    rate = run.bound.equations.scene.right_hand_side(run.bound.equations.parameters)
    m, _, k, _ = run.start_and_rests[0].matrices
    squares, shapes = eigh((k + k.T) / 2, (m + m.T) / 2)
    share = np.abs(shapes.T @ m @ run.start[n:])
    deflected = rate(run.case.start_time, np.concatenate([run.start[:n], np.zeros(n)]))[n:]
    swing = np.sqrt(np.abs(squares)) * share + np.abs(shapes.T @ m @ deflected)
    values = (run.start, rate(run.case.start_time, run.start), np.abs(shapes) @ swing)
    expected = max(float(np.max(np.abs(value))) for value in values)
    if not expected > largest:
        return None
    return Statement(
        f"accelerations of {expected:.2g} (SI) are to be expected, and {run.engine.name} "
        f"takes values above {largest:g} for a failure",
        "choose other units, or a softer model",
    )


# The motion itself


def dead_centre(run: RunConditions) -> Statement | None:
    """Compare the step with the time in which the mechanism passes its singular position."""
    scene, n = run.scene, len(run.scene.coordinates)
    if "cos_b" not in scene.units:
        return None
    turn = np.zeros((2 * n, 257))
    turn[0] = np.linspace(0, 2 * np.pi, 257)
    outputs = scene.outputs(turn[:n], turn[n:], scene.coefficients(run.case.parameters))
    least = float(np.min(outputs["cos_b"]))
    speed = max(run.start_speeds(scene.rotations_per_period)) or 2 * np.pi / run.period
    p = run.integrator.order
    lost = max((run.step_size * speed / least) ** p / math.factorial(p + 1), EPS / least**2)
    if lost <= PASSING:
        return None
    return Statement(
        f"the rod comes as near to its singular position as cos b = {least:.2g}, and passes it in "
        f"{least / speed:.2g} s, with steps of {run.step_size:.2g} s: about {lost:.2g} of it is "
        "lost each time",
        "shorten the step, or the crank",
    )


def inconsistent_start(run: RunConditions) -> Statement | None:
    """Report a start that violates the constraints of the scene."""
    if not run.case.inconsistency:
        return None
    offsets = ", ".join(
        f"{name} by {offset:g} {run.scene.units.get(name, '')}".rstrip()
        for name, offset in run.case.inconsistency.items()
    )
    return Statement(
        f"the start is off the scene's constraints on purpose ({offsets}): a soft closure pulls it "
        "together within its time constant, and the motion afterwards is another one"
    )


def unstable_start(run: RunConditions) -> Statement | None:
    """Look for a start at an unstable state of rest."""
    (scene, parameters), n = run.bound.equations, len(run.start) // 2
    growing = float(np.max(run.start_and_rests[0].rates.real))
    if np.any(run.start[n:]) or not growing * run.horizon > 1:
        return None
    rate, period = scene.right_hand_side(parameters), float(scene.period(parameters))
    times = [run.case.start_time + part * period for part in (0.0, 0.19, 0.41)]
    moved = max(float(np.max(np.abs(rate(time, run.start)[n:]))) for time in times)
    if moved > REST * growing**2:
        return None
    return Statement(
        f"the start is a state of rest that a disturbance leaves at {growing:.3g} /s: round-off "
        "alone decides where the run goes, and when",
        "start at a known distance from it",
    )


def amplification(run: RunConditions) -> Statement | None:
    """Estimate the growth of an initial error within the first `LONG` periods.

    Later growth shows only in the reference.
    """
    case, scene = run.case, run.scene
    if scene.discretisation_coordinates:
        return None
    seen = min(run.horizon, LONG * 2 * np.pi / run.speed)
    start = tuple(scene.state(case.state).tolist())
    growth = _growth(scene, case.parameters, start, (case.start_time, seen), run.speed)
    if growth is None or growth <= MOST_AMPLIFICATION:
        return None
    return Statement(
        f"an initial error grows by a factor of {growth:.2g} within {seen:.4g} s: no method "
        "can follow this motion to its end"
    )


@lru_cache(maxsize=256)
def _growth(
    scene: Dynamics,
    parameters: Any,
    state: tuple[float, ...],
    span: tuple[float, float],
    speed: float,
) -> float | None:
    """Return the growth of a small initial error, by RK4 with complex steps: to a few percent.

    Coordinates and rates are relative to their sizes in the run, by its fastest frequency. None if
    the motion is too stiff for these steps.
    """
    (t, seen), n = span, len(state) // 2
    rate, x = scene.right_hand_side(parameters), probed(np.array(state))
    steps = math.ceil(seen * speed / (2 * np.pi) * STEPS)
    h, largest, marks = seen / steps, np.abs(state), []
    for i in range(steps):
        first = rate(t, x)
        second = rate(t + h / 2, x + h / 2 * first)
        third = rate(t + h / 2, x + h / 2 * second)
        x = x + h / 6 * (first + 2 * (second + third) + rate(t + h, x + h * third))
        t, largest = span[0] + (i + 1) * h, np.maximum(largest, np.abs(x.real[:, 0]))
        if i % STEPS == 0 or i == steps - 1:
            marks.append(x.imag / PROBE)
    size = np.maximum(largest[:n], largest[n:] / speed)
    size = np.where(size > REST, size, 1.0)
    size = np.concatenate([size, size * speed])
    slopes = np.array(marks) * size / size[:, None]
    if not np.all(np.isfinite(slopes)):
        return None
    return float(np.max(np.linalg.norm(slopes, 2, axis=(1, 2))))


# The model

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


# All rules


@dataclass(frozen=True)
class Caution:
    """The warning of a rule before a run.

    Attributes
    ----------
    rule : str
        name of the rule
    message : str
        the problem, with its numbers, and a remedy
    """

    rule: str
    message: str


@dataclass(frozen=True)
class Rule:
    """The meaning of a rule, and the function that finds a violation in a run."""

    meaning: str
    find: Callable[[RunConditions], Statement | None]


RULES: Mapping[str, Rule] = {
    "step_limit": Rule(MEANINGS["step_limit"], step_limit),
    "coarse_step": Rule(MEANINGS["coarse_step"], coarse_step),
    "numerical_damping": Rule("the method adds or removes energy of the motion", numerical_damping),
    "inertia_floor": Rule(MEANINGS["inertia_floor"], inertia_floor),
    "newton_tolerance": Rule(
        "Newton's method stops too early for so small a motion", newton_tolerance
    ),
    "closure_softness": Rule(MEANINGS["closure_softness"], closure_softness),
    "discretisation": Rule("too few segments for the first frequency", discretisation),
    "dead_centre": Rule("the mechanism passes near a singular position", dead_centre),
    "inconsistent_start": Rule("the start violates constraints", inconsistent_start),
    "unstable_start": Rule("the start is an unstable state of rest", unstable_start),
    "amplification": Rule("the motion is chaotic, or nearly so", amplification),
    "clock_rounding": Rule(MEANINGS["clock_rounding"], clock_rounding),
    "engine_range": Rule("values that the engine takes for a failure", engine_range),
    "ill_conditioned": Rule(MEANINGS["ill_conditioned"], ill_conditioned),
}


def cautions(setup: Setup, horizon: float, rules: Mapping[str, Rule] = RULES) -> list[Caution]:
    """Return the warnings of rules about a run over a horizon [s]."""
    with np.errstate(all="ignore"):
        run = RunConditions(
            setup.engine, setup.case, setup.model, setup.method, setup.step, horizon=horizon
        )
        said = {name: rule.find(run) for name, rule in rules.items()}
    return [Caution(name, one.sentence) for name, one in said.items() if one is not None]


def noticing_rules(cautions: list[Caution]) -> tuple[str, ...]:
    """Return the rules that warn of a run, each once, as witnesses."""
    return tuple(dict.fromkeys(f"{RULE}{one.rule}" for one in cautions))


def explained(reason: str, cautions: list[Caution]) -> str:
    """Append the warnings of rules to a reason."""
    return "; ".join([reason, *(f"rule {one.rule}: {one.message}" for one in cautions)])

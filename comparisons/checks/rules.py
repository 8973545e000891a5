"""Rules that tell before a run what it cannot be last_trusted_sample in.

They need no run: what they say follows from the case, from the equations that the model claims,
linearised, and from what the method makes of free vibrations.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from scipy.linalg import eigh

from ...reference import get_scene
from ...reference.amplification import numerical_modes
from ...reference.linear import linearise, modes
from ...reference.scene import Array, Case, Scene
from ..engines.adapter import Adapter
from ..engines.equations import ModelEquations, scene_equations
from ..engines.run import EPS
from ..engines.setup import Setup, shortest_period
from .free_vibrations import Place, place, places, rest_states, stable_step, unstable
from .tolerances import CAP
from .truth import MOST_AMPLIFICATION

PHASE, TURN = CAP, 0.2 * np.pi
"""Angles [rad] by which a motion may be late at the end of a run, where that is known exactly, of a
mode, and where only its order of magnitude is."""

LOSS = CAP
"""Part of an amplitude that a method may take or add."""

FLOOR = 1e-9
"""Part of an inertia that an engine may add."""

NEWTON = 1e-6
"""Where Newton's method may stop, as a share of the motion."""

OPENING = 1e-3
"""How far a loop may open, in its shortest length."""

FREQUENCY = 1e-2
"""Part by which the first frequency of a continuum may be off."""

CLOCK = 1e-9
"""Phase [rad] by which an engine's clock may be off."""

DIGITS = 1e-6
"""Rounding error that matrices may leave."""

REST = 1e-9
"""How far [rad, m] from a state of rest a run counts as started there."""

LONG, STEPS = 12, 24
"""Periods over which the variational equations are solved to learn how errors grow, and steps in
each."""

QUARTERS = np.arange(4) * np.pi / 2


@dataclass(frozen=True)
class Caution:
    """What a rule says of a run that is to be made.

    Attributes
    ----------
    rule : str
        Its name.
    message : str
        One sentence: what is wrong, with its numbers, and what to do.
    """

    rule: str
    message: str


@dataclass(frozen=True)
class Run:
    """A run that is to be made: its setup, and its horizon [s]."""

    setup: Setup
    horizon: float

    @property
    def case(self) -> Case:
        """The case."""
        return self.setup.case

    @property
    def step(self) -> float:
        """Step [s]."""
        return self.setup.step_size

    @property
    def equations(self) -> ModelEquations:
        """The equations that the model has."""
        return self.setup.equations

    @property
    def scheme(self) -> str | None:
        """What the method is on free vibrations."""
        return self.setup.linear_scheme

    @cached_property
    def places(self) -> tuple[Place, ...]:
        """Where the equations are linearised for the scheme."""
        assert self.scheme is not None
        return places(self.setup, self.scheme)

    @cached_property
    def claimed_places(self) -> tuple[Place, ...]:
        """Start and states of rest of the claim."""
        return _exact_places(self.equations, tuple(self.equations.start(self.case)))

    @cached_property
    def exact_places(self) -> tuple[Place, ...]:
        """Start and states of rest of the exact equations."""
        return _exact_places(
            scene_equations(self.case), tuple(scene_equations(self.case).start(self.case))
        )

    @cached_property
    def turning(self) -> float:
        """Fastest turn, or drive [rad/s]."""
        scene = get_scene(self.case.scene)
        if scene.internal:  # whose period is that of its first mode
            return max(
                abs(float(self.equations.start(self.case)[len(self.equations.scene.coordinates)])),
                0.0,
            )
        turns = [abs(self.case.state.get(f"{name}_dot", 0.0)) for name in scene.turning]
        return max(2 * np.pi / float(scene.period(self.case.parameters)), *turns)

    @cached_property
    def ripple(self) -> float:
        """Largest angular acceleration of what turns, over the square of the speed.

        A uniform turn costs no method anything, but one that sees bodies move on circles.
        """
        scene = get_scene(self.case.scene)
        if self.setup.has_constraints and self.equations.scene is scene:
            return 1.0
        if scene.internal or not scene.turning or not self.turning > 0:
            return 0.0
        rows = [scene.coordinates.index(name) for name in scene.turning]
        rate = scene.right_hand_side(self.case.parameters)
        n = len(scene.coordinates)
        found = [
            np.max(np.abs(rate(self.case.start_time, state)[n:][rows]))
            for state in turned_starts(
                replace(self.case, inconsistency={}), scene_equations(self.case)
            )
        ]
        return min(1.0, float(np.max(found)) / self.turning**2)

    @cached_property
    def speed(self) -> float:
        """Fastest circular frequency that the motion shows: turns, drive, modes [rad/s]."""
        return 2 * np.pi / _shortest_period(self.case)


@lru_cache(maxsize=256)
def _exact_places(equations: ModelEquations, start: tuple[float, ...]) -> tuple[Place, ...]:
    n = len(equations.scene.coordinates)
    states = {"start": np.array([*start[:n], *[0.0] * n])} | rest_states(equations)
    return tuple(place(equations, name, state, False, False) for name, state in states.items())


def _shortest_period(case: Case) -> float:
    start = tuple(sorted(case.state.items()))
    return _kept_period(case.scene, case.parameters, start)


@lru_cache(maxsize=256)
def _kept_period(scene: str, parameters: Any, start: tuple[tuple[str, float], ...]) -> float:
    return shortest_period(Case(scene, "", parameters, dict(start)))


# Step and method ----------------------------------------------------------------------------


def step_limit(run: Run) -> str | None:
    """Compare the step with the longest that keeps free vibrations bounded."""
    if run.scheme is None:
        return None
    if not any(unstable(run.scheme, at, run.step, run.horizon) for at in run.places):
        return None
    found = stable_step(run.setup, run.horizon)
    if found is None or run.step <= found.step:
        return None
    limit, at, mode = found
    return (
        f"a step of {run.step:.3g} s is unstable: the mode of {mode.coordinate} "
        f"({mode.omega:.4g} rad/s about {at.name}) has h omega = {run.step * mode.omega:.3g}, and "
        f"{run.setup.integrator.name} bears {limit * mode.omega:.3g}; take at most {limit:.3g} s"
    )


def shown_modes(run: Run) -> list[tuple[float, float, float]]:
    """Return (omega, phase error [rad], gain) at the end of modes that the motion shows.

    A mode counts for as long as its own damping leaves it.
    """
    assert run.scheme is not None
    found = []
    for at in run.places:
        for mode in numerical_modes(run.scheme, at.modes, run.step):
            if abs(mode.exact) > SHOWN * run.speed:
                continue
            span = min(run.horizon, 1 / -mode.exact.real if mode.exact.real < 0 else np.inf)
            off = mode.numerical - mode.exact
            found.append((abs(mode.exact), abs(off.imag) * span, off.real * span))
    return found


SHOWN = 1.5
"""Modes faster than this many times the fastest that the exact motion has are not seen in it."""


def coarse_step(run: Run) -> str | None:
    """Estimate the phase that the method loses, of modes and of turns."""
    p, turn = run.setup.integrator.order, run.turning
    slow = run.ripple * (run.step * turn) ** p / math.factorial(p + 1) * turn * run.horizon
    late = [(slow / TURN, turn, slow)]
    if run.scheme is None:
        off = (run.step * run.speed) ** p / math.factorial(p + 1) * run.speed * run.horizon
        late.append((off / TURN, run.speed, off))
    else:
        late += [(phase / PHASE, omega, phase) for omega, phase, _ in shown_modes(run)]
    share, omega, phase = max(late)
    if share <= 1:
        return None
    return (
        f"{2 * np.pi / omega / run.step:.3g} steps per period of {2 * np.pi / omega:.3g} s: "
        f"{run.setup.integrator.name}, order {p}, is off by about "
        f"{phase / (2 * np.pi):.2g} periods after {run.horizon:.4g} s; stable, but wrong"
    )


def numerical_damping(run: Run) -> str | None:
    """Compare what the method takes from a mode with what its own damping does."""
    if run.scheme is None:
        return None
    gains = [(omega, gain) for omega, _, gain in shown_modes(run)]
    if not gains:
        return None
    omega, gain = max(gains, key=lambda item: abs(item[1]))
    if abs(gain) <= LOSS:
        return None
    does = "loses" if gain < 0 else "gains"
    return (
        f"{run.setup.integrator.name} itself {does} {abs(math.expm1(gain)):.2g} of the amplitude "
        f"of the mode of {omega:.4g} rad/s within {run.horizon:.4g} s; shorten the step"
    )


def clock_rounding(run: Run) -> str | None:
    """Count the rounding of a clock that adds up its steps."""
    if not run.setup.engine.accumulates_clock:
        return None
    if math.frexp(run.step)[0] == 0.5:
        return None
    steps = run.horizon / run.step
    late = steps * EPS * (abs(run.case.start_time) + run.horizon)
    if late * run.speed <= CLOCK:
        return None
    return (
        f"{run.setup.engine.name} adds up its clock: after {steps:.3g} steps that are no power of "
        f"two it may be off by {late:.2g} s, {late * run.speed:.2g} rad of the motion; take a "
        f"step of {2.0 ** math.floor(math.log2(run.step)):g} s"
    )


# Model and engine ---------------------------------------------------------------------------


def inertia_floor(run: Run) -> str | None:
    """Look for masses that the model has and the scene has not, or that the engine refuses."""
    least = run.setup.engine.least_inertia
    for item in dataclasses.fields(run.case.parameters):
        value = getattr(run.case.parameters, item.name)
        if item.metadata["unit"] in ("kg", "kg m^2") and 0 < value <= least:
            return (
                f"{item.name} = {value:.3g} {item.metadata['unit']} is below what "
                f"{run.setup.engine.name} takes, {least:g}"
            )
    scene = get_scene(run.case.scene)
    if run.equations.scene is not scene or run.equations.parameters == run.case.parameters:
        return None
    q = scene.state(run.case.state)[: len(scene.coordinates)]
    mine, right = (
        np.diag(np.array(scene.mass_matrix(q, scene.coefficients(p), np), dtype=float))
        for p in (run.equations.parameters, run.case.parameters)
    )
    more = np.abs(mine - right) / right
    worst = int(np.argmax(more))
    if more[worst] <= FLOOR:
        return None
    return (
        f"the model's inertia of {scene.coordinates[worst]} is {more[worst]:.2g} too large: "
        f"{run.setup.engine.name} has no point masses"
    )


def newton_tolerance(run: Run) -> str | None:
    """Compare where Newton's method stops with the size of the motion."""
    tolerance = run.setup.engine.newton_tolerance
    if not tolerance or run.setup.integrator.scheme is not None:
        return None
    sizes = {name: size for name, size in motion_size(run).items() if size > 0}
    if not sizes:
        return None
    name = min(sizes, key=lambda one: sizes[one])
    if tolerance <= NEWTON * sizes[name]:
        return None
    unit = get_scene(run.case.scene).units.get(name, "rad")
    return (
        f"Newton's method stops at increments of {tolerance:.2g}, {tolerance / sizes[name]:.2g} of "
        f"the motion of {name} ({sizes[name]:.2g} {unit}); tighten newton_tolerance"
    )


def motion_size(run: Run) -> dict[str, float]:
    """Return how far each coordinate of the exact scene goes, at least; 1 rad if it turns.

    Starts, what speeds at the start make of them in a mode, and deflections under static loads.
    """
    scene = get_scene(run.case.scene)
    n = len(scene.coordinates)
    start = scene.state(run.case.state)
    at = run.exact_places[0]
    c = scene.coefficients(run.case.parameters)
    load = np.zeros(n)
    for quarter in QUARTERS if scene.drive else QUARTERS[:1]:
        time = run.case.start_time + quarter / 2 / np.pi * float(scene.period(run.case.parameters))
        u = scene.drive(time, c, np) if scene.drive else 0.0
        load = np.maximum(load, np.abs(scene.forces(u, start[:n], start[n:], c, np)))
    stiffness = np.abs(np.diag(at.matrices.stiffness))
    inertia = np.diag(at.matrices.mass)
    resist = np.maximum(stiffness, inertia * run.speed**2)
    found = np.maximum(np.abs(start[:n]), load / resist)
    found = np.maximum(found, np.abs(start[n:]) * np.sqrt(inertia / resist))
    return {
        name: max(1.0, size) if name in scene.turning else float(size)
        for name, size in zip(scene.coordinates, found, strict=True)
        if name not in scene.internal
    }


def closure_softness(run: Run) -> str | None:
    """Estimate how far a soft closure opens, from the residual's acceleration and its spring."""
    equations, scene = run.equations, get_scene(run.case.scene)
    more = len(equations.scene.coordinates) - len(scene.coordinates)
    if equations.scene is scene or equations.scene.internal or more <= 0:
        return None
    length = shortest_length(run.case.parameters)
    closed = replace(run.case, inconsistency={})
    opening = max(_openings(equations, tuple(one)) for one in turned_starts(closed, equations))
    if not opening > OPENING * length:
        return None
    return (
        f"the closure of {run.setup.model} opens by about {opening:.2g} m under its load, "
        f"{opening / length:.2g} of the shortest length; take a harder one"
    )


def shortest_length(parameters: Any) -> float:
    """Return the smallest parameter that is a length and positive by its nature [m]."""
    return min(
        getattr(parameters, item.name)
        for item in dataclasses.fields(parameters)
        if item.metadata["unit"] == "m" and item.metadata["bound"] == "positive"
    )


def turned_starts(case: Case, equations: ModelEquations) -> list[Array]:
    """Return the start, and turning at least at the orbit's speed, at four places of the turn."""
    scene = get_scene(case.scene)
    speed = 2 * np.pi / float(scene.period(case.parameters))
    found = [equations.start(case)]
    for quarter in QUARTERS:
        state = dict(case.state)
        for name in scene.turning:
            state[name] = float(quarter)
            state[f"{name}_dot"] = max(abs(state.get(f"{name}_dot", 0.0)), speed)
        found.append(equations.start(replace(case, state=state)))
    return found


@lru_cache(maxsize=1024)
def _openings(equations: ModelEquations, state: tuple[float, ...]) -> float:
    """Return how far the loop would open if the load at a state stayed [m]."""
    x, n = np.array(state), len(state) // 2
    moment = 1e-6
    advanced = x + moment * equations.scene.right_hand_side(equations.parameters)(0.0, x)
    advanced[:n] += moment**2 / 2 * (advanced[n:] - x[n:]) / moment
    residual = (
        equations.scene.observe(advanced, equations.parameters)["velocity_violation"] / moment
    )
    rest = np.concatenate([x[:n], np.zeros(n)])
    fastest = np.sort(np.abs(place(equations, "", rest, False, False).rates))[-4:]
    return float(residual / np.exp(np.mean(np.log(fastest))) ** 2)


def discretisation(run: Run) -> str | None:
    """Compare the first frequency of a discretised continuum with the continuum's."""
    if not run.setup.element_order:
        return None
    scene, p = get_scene(run.case.scene), run.case.parameters
    speeds = [abs(run.case.state.get(f"{name}_dot", 0.0)) for name in scene.held[STEADY]]
    if p.drive == "prescribed":  # a torque knows no speed
        speeds.append(abs(p.angular_speed))
    steady = p.replace(drive="prescribed", angular_speed=max(speeds))
    error = frequency_error(run.setup.engine, run.setup.model, run.case.scene, steady)
    if not abs(error) > FREQUENCY:
        return None
    return (
        f"{p.segments:g} segments put the first frequency {error:+.2g} off that of the continuum; "
        "take more"
    )


@lru_cache(maxsize=256)
def frequency_error(engine: Adapter, model: str, scene: str, steady: Any) -> float:
    """Return the relative error of the first frequency about steady rotation."""
    setup = Setup(engine, Case(scene, "", steady), model)
    case, equations = setup.case, setup.equations
    if not setup.approximates_continuum:
        return first_frequency(equations) / first_frequency(scene_equations(case)) - 1
    state = np.array([0.0, steady.angular_speed])
    matrices = engine.linearise(case, model, state)
    omega = min(mode.omega for mode in modes(*matrices) if mode.omega > 0)
    return omega / first_frequency(equations) - 1


STEADY = "rotation"


def first_frequency(equations: ModelEquations) -> float:
    """Return the first natural frequency about steady rotation [rad/s]."""
    state = equations.scene.state(equations.scene.equilibria[STEADY](equations.parameters))
    held = [equations.scene.coordinates.index(name) for name in equations.scene.held[STEADY]]
    found = modes(*linearise(equations.scene, equations.parameters, state), held)
    return min(mode.omega for mode in found if mode.omega > 0)


# Motion -------------------------------------------------------------------------------------


def dead_centre(run: Run) -> str | None:
    """Compare the step with the time in which the mechanism passes its singular position."""
    scene = get_scene(run.case.scene)
    if "cos_b" not in scene.units:
        return None
    n = len(scene.coordinates)
    turn = np.zeros((2 * n, 257))
    turn[0] = np.linspace(0, 2 * np.pi, 257)
    least = float(
        np.min(scene.outputs(turn[:n], turn[n:], scene.coefficients(run.case.parameters))["cos_b"])
    )
    speed = max(
        abs(run.case.state.get(f"{name}_dot", 0.0)) for name in scene.turning
    ) or 2 * np.pi / float(scene.period(run.case.parameters))
    passed = run.step * speed / least
    p = run.setup.integrator.order
    lost = max(passed**p / math.factorial(p + 1), EPS / least**2)
    if lost <= PASSING:
        return None
    return (
        f"the rod comes as near to its singular position as cos b = {least:.2g}, and passes it in "
        f"{least / speed:.2g} s, with steps of {run.step:.2g} s: about {lost:.2g} of it is lost "
        "each time; shorten the step, or the crank"
    )


PASSING = 1e-2
"""Part of a passage of the singular position that may be lost."""


def inconsistent_start(run: Run) -> str | None:
    """Tell what is declared: a start off the constraints of the scene."""
    if not run.case.inconsistency:
        return None
    units = get_scene(run.case.scene).units
    told = ", ".join(
        f"{name} by {offset:g} {units.get(name, '')}".rstrip()
        for name, offset in run.case.inconsistency.items()
    )
    return (
        f"the start is off the scene's constraints on purpose ({told}): a soft closure pulls it "
        "together in its own time, and the motion after that is another one"
    )


def unstable_start(run: Run) -> str | None:
    """Look for a start that is a state of rest, and from which something grows."""
    equations, start = run.equations, run.equations.start(run.case)
    n = len(equations.scene.coordinates)
    if np.any(start[n:]):
        return None
    growing = float(np.max(run.claimed_places[0].rates.real))
    if not growing * run.horizon > 1:
        return None
    rate = equations.scene.right_hand_side(equations.parameters)
    period = float(equations.scene.period(equations.parameters))
    moved = max(
        float(np.max(np.abs(rate(run.case.start_time + part * period, start)[n:])))
        for part in (0.0, 0.19, 0.41)
    )
    if moved > REST * growing**2:
        return None
    return (
        f"the start is a state of rest that a disturbance leaves with {growing:.3g} /s: rounding "
        "alone decides where the run goes, and when; start it off by a known amount"
    )


def amplification(run: Run) -> str | None:
    """Ask how much an initial error grows within the first `LONG` periods.

    Later than that only the reference can tell.
    """
    scene = get_scene(run.case.scene)
    if scene.internal:
        return None
    seen = min(run.horizon, LONG * _shortest_period(run.case))
    start = tuple(scene.state(run.case.state).tolist())
    growth = _growth(scene, run.case.parameters, start, run.case.start_time, seen, run.speed)
    if growth <= MOST_AMPLIFICATION:
        return None
    return (
        f"an initial error grows {growth:.2g} times within {seen:.4g} s: no method can follow this "
        "motion to its end"
    )


@lru_cache(maxsize=256)
def _growth(
    scene: Scene, parameters: Any, state: tuple[float, ...], start: float, seen: float, speed: float
) -> float:
    """Return the growth of a small initial error, by RK4 with complex steps: to a few percent.

    Coordinates and rates are measured in what the run has of either, by its fastest frequency.
    """
    n = len(state) // 2
    probe = 1e-40
    rate = scene.right_hand_side(parameters)
    x = np.array(state)[:, None] + 1j * probe * np.eye(2 * n)
    steps = math.ceil(seen * speed / (2 * np.pi) * STEPS)
    h = seen / steps
    largest, marks = np.abs(x.real[:, 0]), []
    for i in range(steps):
        t = start + i * h
        first = rate(t, x)
        second = rate(t + h / 2, x + h / 2 * first)
        third = rate(t + h / 2, x + h / 2 * second)
        x = x + h / 6 * (first + 2 * (second + third) + rate(t + h, x + h * third))
        largest = np.maximum(largest, np.abs(x.real[:, 0]))
        if i % STEPS == 0 or i == steps - 1:
            marks.append(x.imag / probe)
    size = np.maximum(largest[:n], largest[n:] / speed)
    size = np.where(size > REST, size, 1.0)
    size = np.concatenate([size, size * speed])
    return float(max(np.linalg.norm(mark * size / size[:, None], 2) for mark in marks))


def engine_range(run: Run) -> str | None:
    """Compare expected positions, rates and accelerations with what the engine bears."""
    largest = run.setup.engine.largest_value
    if not math.isfinite(largest):
        return None
    equations, start = run.equations, run.equations.start(run.case)
    n = len(equations.scene.coordinates)
    at = run.claimed_places[0]
    expected = np.max(np.abs(start))
    rate = equations.scene.right_hand_side(equations.parameters)
    expected = max(expected, float(np.max(np.abs(rate(run.case.start_time, start)))))
    m, _, k, _ = at.matrices
    squares, shapes = eigh((k + k.T) / 2, (m + m.T) / 2)
    omega = np.sqrt(np.abs(squares))
    share = np.abs(shapes.T @ m @ start[n:])
    deflected = rate(run.case.start_time, np.concatenate([start[:n], np.zeros(n)]))[n:]
    swing = omega * share + np.abs(shapes.T @ m @ deflected)
    expected = max(expected, float(np.max(np.abs(shapes) @ swing)))
    if not expected > largest:
        return None
    return (
        f"accelerations of {expected:.2g} (SI) are to be expected, and {run.setup.engine.name} "
        f"takes what is above {largest:g} for a failure; choose other units, or a softer model"
    )


def ill_conditioned(run: Run) -> str | None:
    """Look at the condition of the scaled mass matrix, and at the spread of the modes.

    Stiffness that acts through coordinates of its own costs no digits, however large; in
    redundant coordinates it acts through differences.
    """
    redundant = run.setup.has_constraints
    for at in run.claimed_places:
        m, _, k, _ = at.matrices
        root = 1 / np.sqrt(np.diag(m))
        condition = float(np.linalg.cond(m * np.outer(root, root)))
        if EPS * condition > DIGITS:
            return (
                f"the mass matrix about {at.name} has the condition {condition:.2g}: rounding "
                f"leaves accelerations wrong by {EPS * condition:.1g}"
            )
        omega = [mode.omega for mode in modes(m, 0 * m, k) if mode.omega > 0] if redundant else []
        if omega and EPS * (max(omega) / min(omega)) ** 2 > DIGITS:
            return (
                f"modes about {at.name} range from {min(omega):.2g} to {max(omega):.2g} rad/s in "
                "redundant coordinates: rounding of the fast ones leaves the slow ones wrong by "
                f"{EPS * (max(omega) / min(omega)) ** 2:.1g}"
            )
    return None


@dataclass(frozen=True)
class Rule:
    """What a rule means, and how it is found: its message, or None."""

    meaning: str
    find: Callable[[Run], str | None]


RULES: Mapping[str, Rule] = {
    "step_limit": Rule("the step is longer than the method bears", step_limit),
    "coarse_step": Rule("stable, but the phase is lost", coarse_step),
    "numerical_damping": Rule(
        "the method damps, or feeds, what the motion keeps", numerical_damping
    ),
    "inertia_floor": Rule("the engine takes no inertia as small as the scene's", inertia_floor),
    "newton_tolerance": Rule(
        "Newton's method stops too early for so small a motion", newton_tolerance
    ),
    "closure_softness": Rule("a loop opens under its load", closure_softness),
    "discretisation": Rule("too few segments for the first frequency", discretisation),
    "dead_centre": Rule("the mechanism passes near a singular position", dead_centre),
    "inconsistent_start": Rule("it starts off its constraints", inconsistent_start),
    "unstable_start": Rule("it starts on an unstable state of rest", unstable_start),
    "amplification": Rule("the motion is chaotic, or as good as", amplification),
    "clock_rounding": Rule("the engine's clock adds up rounded steps", clock_rounding),
    "engine_range": Rule("values that the engine takes for a failure", engine_range),
    "ill_conditioned": Rule("rounding leaves few digits", ill_conditioned),
}


def cautions(setup: Setup, horizon: float) -> list[Caution]:
    """Return what all rules say of a run over a horizon [s]."""
    found = []
    with np.errstate(all="ignore"):
        run = Run(setup, horizon)
        for name, rule in RULES.items():
            try:
                message = rule.find(run)
            except Exception:  # an engine or a reference that fails says so when it runs
                continue
            if message is not None:
                found.append(Caution(name, message))
    return found


def explained(reason: str, found: list[Caution]) -> str:
    """Append to a reason what rules say."""
    return "; ".join([reason, *(f"rule {one.rule}: {one.message}" for one in found)])

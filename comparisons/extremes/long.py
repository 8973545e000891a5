"""Long horizons: what a thousand periods leave of energy, phase, closure and clock.

Each drift is held against what the method predicts:

* a small *free vibration* about a state of rest against the powers of the method's amplification
  matrix, which are exact there;
* *conservative* motion and the *locked* rotation on the periodic orbit against the method's scheme
  on the claimed equations, run over a part of the horizon; what grows there is extrapolated;
* where a method has no published scheme, against the engine's own runs with half and a quarter of
  the step over that part, with the error that these have by their order. A loss of energy then is
  the engine's word against its own; a phase is not, for its limit must be the reference's.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from typing import Any

import numpy as np
from scipy.linalg import eigh

from ...reference import get_scene
from ...reference.amplification import AMPLIFICATION, Vibrations, first_order
from ...reference.errors import CannotJudgeError, EngineError, MbcheckError
from ...reference.linear import linearise
from ...reference.orbits import Orbit, find_orbit
from ...reference.scene import Array, Case
from ..checks.free_vibrations import place
from ..checks.kinds.energy import drifts
from ..checks.rules.cautions import cautions
from ..checks.tolerances import SAFETY, VIOLATION, rounding, rows
from ..engines.adapter import Adapter
from ..engines.equations import ModelEquations, scene_equations
from ..engines.protocol import Method
from ..engines.registry import get_engine
from ..engines.run import EPS, VIOLATIONS, Trajectory
from ..engines.setup import Setup, default_step, shortest_period, stable_step_bound
from .row import FAILED, REFERENCE, RIGHT, RULE, SKIPPED, WRONG, Row, noticer
from .task import Task

SECTION = "long"

FREE, CONSERVATIVE, LOCKED, AFTER_PULSE = "free", "conservative", "locked", "after_pulse"

PERIODS: Mapping[str, tuple[int, int]] = {
    "hula_hoop": (1_000, 10_000),
    "rotor_pendulum": (1_000, 10_000),
    "rotating_beam": (100, 1_000),
    "speed_regulator": (1_000, 10_000),
}
"""By default, and in full."""

LONGEST = 100_000
"""Periods in full of locked rotations that are cheap enough, by one method."""

LONGEST_OF = ("hula_hoop", "speed_regulator")

PART, PART_STEPS = 100, 1 << 14
"""Periods over which a scheme is run, or halved steps; fewer if they took more steps than that."""

MOST_STEPS, MOST_CONSTRAINED = 1 << 20, 1 << 18
"""Runs that would take more steps are cut, those in full at more; constraints make steps dear."""

DEAR: Mapping[tuple[str, str], int] = {("exudyn", "rotor_pendulum"): 1 << 15}
"""The same of an engine and scene whose steps take a tenth of a millisecond and more."""

COARSER: Mapping[int, float] = {1: 8.0, 2: 4.0, 3: 2.0, 4: 2.0, 5: 2.0, 6: 2.0}
"""Steps in those by default, by order: long runs are made with coarse steps."""

WINDOW = 32
"""Samples of a period at the start and at the end of a free vibration."""

AMPLITUDE, AMONG_FREE = 1e-4, 1e-6
"""Of free vibrations, in the size of the scene (1 rad, its shortest length): what is not linear
changes frequencies by its square. Where a coordinate has no spring the vibration pushes it away
with a force of second order, all the time: there the amplitude is less."""

LOSS = 0.1
"""Part of an amplitude, or of a period, whose loss makes a motion wrong though as predicted."""

UNTOLD = 10.0
"""A drift within a slack so many times what is predicted says nothing of the prediction."""

TELLING: Mapping[str, tuple[str, ...]] = {
    "mujoco": ("RK4", "implicitfast", "discrete"),
    "exudyn": ("RK67", "RK44", "GeneralizedAlpha", "TrapezoidalIndex2"),
}
"""Methods that are run, if they take the model: the best, and those that tell most. Without
constraints the last of Exudyn's is the trapezoidal rule, and left out; models beside the default
one that have none are run by the best alone."""

BEST: Mapping[str, tuple[str, ...]] = {
    "mujoco": ("RK4",),
    "exudyn": ("RK44", "GeneralizedAlpha"),
}
"""The reduced set."""


@dataclass(frozen=True)
class Motion:
    """What is followed for long.

    Attributes
    ----------
    kind : str
        `FREE`, `CONSERVATIVE`, `LOCKED` or `AFTER_PULSE`.
    case : str
        Of the scene; gives the parameters and, but for `FREE` and `LOCKED`, the start.
    segments : int
        Of a continuum, 0 for the case's own.
    """

    kind: str
    case: str
    segments: int = 0

    def of(self, scene: str) -> Case:
        """Return the case."""
        case = get_scene(scene).case(self.case)
        if not self.segments:
            return case
        return replace(case, parameters=case.parameters.replace(segments=self.segments))


MOTIONS: Mapping[str, tuple[Motion, ...]] = {
    "hula_hoop": (
        Motion(FREE, "free_undamped"),
        Motion(CONSERVATIVE, "free_undamped"),
        Motion(LOCKED, "spinning_3hz_60n"),
    ),
    "rotor_pendulum": (
        Motion(FREE, "conservative"),
        Motion(CONSERVATIVE, "conservative"),
        Motion(LOCKED, "case_1_synchronous"),
    ),
    "rotating_beam": (Motion(AFTER_PULSE, "pulse_quick", segments=8),),
    "speed_regulator": (
        Motion(FREE, "conservative"),
        Motion(CONSERVATIVE, "conservative"),
        Motion(LOCKED, "limit_cycle"),
    ),
}


def tasks(scenes: tuple[str, ...], engines: tuple[str, ...], full: bool) -> list[Task]:
    """Return the tasks of the section: one for each motion, engine and model."""
    found = []
    for scene in scenes:
        for engine_name in engines:
            engine = get_engine(engine_name)
            for model in engine.models(scene):
                for motion in MOTIONS[scene]:
                    if not runs(engine, scene, model, motion, full):
                        continue
                    call = partial(rows_of, engine_name, scene, model, motion, full)
                    name = f"{motion.kind}, {model}"
                    found.append(Task(SECTION, scene, name, engine_name, call))
    return found


def rows_of(engine_name: str, scene: str, model: str, motion: Motion, full: bool) -> list[Row]:
    """Return a row for each method that follows a motion on a model."""
    engine = get_engine(engine_name)
    return [
        follow(engine, scene, model, motion, method, periods)
        for method, periods in runs(engine, scene, model, motion, full)
    ]


def runs(
    engine: Adapter, scene: str, model: str, motion: Motion, full: bool
) -> list[tuple[str, int]]:
    """Return (method, periods) of what is run of a motion on a model."""
    case = motion.of(scene)
    if engine.why_not(case, model, None):
        return []
    known = [
        method.name
        for method in engine.methods
        if not engine.why_not(case, model, method)
        if method.name != "TrapezoidalIndex2" or Setup(engine, case, model).has_constraints
        if motion.kind != FREE or predictable(engine, case, model, method)
    ]
    telling = [name for name in TELLING.get(engine.name, known) if name in known]
    if model != engine.models(scene)[0] and not Setup(engine, case, model).has_constraints:
        telling = telling[:1]
    chosen = [(name, PERIODS[scene][full]) for name in telling]
    if full and motion.kind == LOCKED and scene in LONGEST_OF:
        chosen += [(name, LONGEST) for name in BEST.get(engine.name, known[:1])]
    return [(name, periods) for name, periods in chosen if name in known]


def predictable(engine: Adapter, case: Case, model: str, method: Method) -> bool:
    """Return whether the amplification matrix of a method is known on a model.

    What `discrete` makes of soft closures is none: it takes only springs at the end of a step.
    """
    if method.linear == "implicit_euler" and Setup(engine, case, model).has_soft_closure:
        return False
    return Setup(engine, case, model, method).linear_scheme is not None


# --- What is followed ----------------------------------------------------------------------


@dataclass(frozen=True)
class Long:
    """A motion of one engine, model and method over a number of periods.

    Attributes
    ----------
    engine, case, model, method
    step, period : float
        [s]
    periods : int
    kind : str
    mode : Mode or None
        Of a free vibration.
    """

    engine: Adapter
    case: Case
    model: str
    method: Method
    step: float
    period: float
    periods: int
    kind: str
    mode: Mode | None = None

    @property
    def setup(self) -> Setup:
        """What is run."""
        return Setup(self.engine, self.case, self.model, self.method, self.step)

    @property
    def own(self) -> ModelEquations:
        """The equations that the model has."""
        return self.setup.equations

    @property
    def names(self) -> tuple[str, ...]:
        """What is observed."""
        return self.setup.observables

    def simulate(self, samples: Any, finer: int = 1) -> Trajectory:
        """Run the engine and record it at these step numbers, with a fraction of the step."""
        return self.setup.simulate(self.step / finer, samples * finer)

    def by_scheme(self, scheme: str, samples: Any) -> dict[str, Array]:
        """Return the observables (n_t,) of a published scheme on the model's equations."""
        states = self.setup.scheme_states(self.step, samples, scheme)
        return dict(zip(self.names, rows(self.own, states, self.names), strict=True))


@dataclass(frozen=True)
class Mode:
    """An undamped mode about a state of rest of a scene.

    Attributes
    ----------
    about : str
    rest : array (2 n,)
    omega : float
        [rad/s]
    shape : array (n,)
        Normed by the mass matrix.
    mass : array (n, n)
    pushed : float
        0 where every coordinate has a spring; else the ratio of the largest inertia to the least,
        with which the forces of second order push one that has none.
    """

    about: str
    rest: Array
    omega: float
    shape: Array
    mass: Array
    pushed: float

    @property
    def amplitude(self) -> float:
        """`AMPLITUDE`, or less."""
        return AMONG_FREE if self.pushed else AMPLITUDE

    def amplitudes(self, states: Array) -> Any:
        """Return ``a - i a'/omega`` (n_t,), which turns with ``exp(i omega t)``."""
        q, v = np.split(states - self.rest[:, None], 2)
        shape = self.shape @ self.mass
        return shape @ q - 1j * (shape @ v) / self.omega


@dataclass(frozen=True)
class Drift:
    """One drift: what was measured, what is predicted, and by how much they may differ."""

    measured: float
    predicted: float
    slack: float

    @property
    def agrees(self) -> bool:
        """Whether it is as predicted."""
        return abs(self.measured - self.predicted) <= self.slack

    def __str__(self) -> str:
        """Return it in words."""
        said = f"{self.measured:.3g} (predicted {self.predicted:.3g} within ± {self.slack:.2g}"
        untold = self.slack > UNTOLD * abs(self.predicted) and abs(self.measured) <= self.slack
        return f"{said}, below what can be told)" if untold else f"{said})"


@dataclass(frozen=True)
class Found:
    """All drifts of a run by name, and what they come from."""

    drifts: Mapping[str, Drift]
    numbers: Mapping[str, float] = field(default_factory=dict)


def follow(
    engine: Adapter, scene: str, model: str, motion: Motion, method_name: str, periods: int
) -> Row:
    """Follow one motion with a coarse step, and tell what it leaves."""
    method = {item.name: item for item in engine.methods}[method_name]
    case = motion.of(scene)
    name, asked, cut = f"{motion.kind}, {periods} periods", periods, ""

    def row(outcome: str, noticed: tuple[str, ...], reason: str, **more: Any) -> Row:
        more = {"step": None, "error": None, "predicted": None, **more}
        return Row(
            SECTION, scene, name, engine.name, model, method_name,
            changed={"case": motion.case}, outcome=outcome, noticed_by=noticed,
            reason=reason + cut, **more,
        )  # fmt: skip

    try:
        long = prepared(engine, case, model, method, motion, periods)
        if periods >= PERIODS[scene][False]:
            most = most_steps(long, periods / PERIODS[scene][False])
            periods = min(periods, int(most * long.step / long.period))
            long = replace(long, periods=periods)
            name = f"{motion.kind}, {periods} periods"
            cut = f"; cut from {asked} periods for cost" if periods < asked else ""
    except MbcheckError as error:
        return row(SKIPPED, (), f"cannot be predicted: {error}")
    horizon = periods * long.period
    warned = tuple(
        dict.fromkeys(
            f"{RULE}{item.rule}"
            for item in cautions(Setup(engine, long.case, model, method, long.step), horizon)
        )
    )
    try:
        found = MEASURES[motion.kind](long)
    except EngineError as error:
        return row(FAILED, (noticer(error), *warned), f"{error.kind}: {error}", step=long.step)
    except CannotJudgeError as error:
        return row(SKIPPED, warned, str(error), step=long.step)
    values = {"periods": float(periods), "asked": float(asked), "period": long.period}
    values |= found.numbers
    for what, drift in found.drifts.items():
        values[f"{what}_drift"], values[f"{what}_predicted"] = drift.measured, drift.predicted
        values[f"{what}_slack"] = drift.slack
    wrong = {what: drift for what, drift in found.drifts.items() if not drift.agrees}
    said = ", ".join(f"{what} {drift}" for what, drift in (wrong or found.drifts).items())
    limits = {"energy": 2 * LOSS, "phase": 2 * np.pi * LOSS}
    lost = [
        what
        for what, limit in limits.items()
        if what in found.drifts and abs(found.drifts[what].measured) > limit
    ]
    told = next(found.drifts[what] for what in limits if what in found.drifts)
    more = {
        "error": abs(told.measured),
        "predicted": abs(told.predicted),
        "step": long.step,
        "values": values,
    }
    if wrong:
        return row(WRONG, (*warned, REFERENCE), f"not as predicted: {said}", **more)
    if lost:
        reason = f"as predicted, and wrong: {said}; {' and '.join(lost)} lost"
        return row(WRONG, (*warned, REFERENCE), reason, **more)
    return row(RIGHT, (), f"as predicted: {said}", **more)


def most_steps(long: Long, longer: float) -> float:
    """Return where a run is cut that has so many times the periods of the default."""
    dear = DEAR.get((long.engine.name, long.case.scene))
    if dear is not None:
        return dear * min(longer, 10.0)
    if VIOLATIONS[0] in long.names:
        return MOST_CONSTRAINED * min(longer, 10.0)
    return MOST_STEPS * min(longer, 16.0)


def prepared(
    engine: Adapter, case: Case, model: str, method: Method, motion: Motion, periods: int
) -> Long:
    """Return a motion with its start, period and step.

    Raises
    ------
    MbcheckError
        If the scene has no such motion.
    """
    if motion.kind == FREE:
        mode = free_mode(case)
        case = replace(case, state=started(case, mode), start_time=0.0)
        period = 2 * np.pi / mode.omega
        step = min(coarse(engine, case, model, method), 2.0 ** np.floor(np.log2(period / WINDOW)))
        return Long(engine, case, model, method, float(step), period, periods, FREE, mode)
    if motion.kind == LOCKED:
        scene = get_scene(case.scene)
        orbit = known_orbit(case.scene, case.parameters)
        state = dict(zip(scene.state_names, map(float, orbit.state), strict=True))
        case = replace(case, state=state, start_time=0.0)
        longest = coarse(engine, case, model, method)
        if not Setup(
            engine, case, model
        ).has_soft_closure:  # its vibrations are faster than its turns
            longest = max(longest, min(4 * longest, orbit.period / 128))
        step = orbit.period / int(np.ceil(orbit.period / longest))
        return Long(engine, case, model, method, step, orbit.period, periods, LOCKED)
    step = coarse(engine, case, model, method)
    period = shortest_period(case)
    return Long(engine, case, model, method, step, period, periods, motion.kind)


@lru_cache(maxsize=8)
def known_orbit(scene: str, parameters: Any) -> Orbit:
    """Return the reference's periodic orbit, remembered within a process."""
    return find_orbit(get_scene(scene), parameters)


def coarse(engine: Adapter, case: Case, model: str, method: Method) -> float:
    """Return a long step [s], a power of two, that the model's own equations bear."""
    bearable = stable_step_bound(case, Setup(engine, case, model).equations)
    bearable = 2.0 ** np.floor(np.log2(bearable)) if np.isfinite(bearable) else np.inf
    factor = COARSER[min(method.order, 6)]
    if get_scene(case.scene).internal:  # Newton's method finds no solution far beyond the default
        factor = min(factor, 2.0)
    return float(min(factor * default_step(case, method), bearable))


def part_of(long: Long) -> int:
    """Return the periods over which drifts are predicted."""
    return int(np.clip(PART_STEPS * long.step / long.period, 8, min(PART, long.periods)))


# --- Free vibrations -----------------------------------------------------------------------


def free_mode(case: Case) -> Mode:
    """Return the fastest mode about the first stable state of rest.

    Raises
    ------
    MbcheckError
        If there is no stable one.
    """
    scene = get_scene(case.scene)
    for about, where in scene.equilibria.items():
        rest = scene.state(where(case.parameters))
        mass, _, stiffness = linearise(scene, case.parameters, rest)
        squares, shapes = eigh((stiffness + stiffness.T) / 2, mass)
        if squares[0] > -1e-9 * squares[-1] and squares[-1] > 0:
            scaled = mass * np.outer(sizes(case), sizes(case))
            pushed = float(np.linalg.cond(scaled)) if squares[0] < 1e-9 * squares[-1] else 0.0
            return Mode(about, rest, float(np.sqrt(squares[-1])), shapes[:, -1], mass, pushed)
    raise MbcheckError(f"{case.scene} has no stable state of rest here")


def started(case: Case, mode: Mode) -> dict[str, float]:
    """Return the state at the largest displacement of a mode."""
    scene = get_scene(case.scene)
    share = mode.amplitude / np.max(np.abs(mode.shape) / sizes(case))
    n = len(scene.coordinates)
    state = mode.rest + np.concatenate([share * mode.shape, np.zeros(n)])
    return dict(zip(scene.state_names, map(float, state), strict=True))


def sizes(case: Case) -> Array:
    """Return the size (n,) of each coordinate: 1 rad, or the shortest length."""
    scene = get_scene(case.scene)
    angles = [scene.units[name] == "rad" for name in scene.coordinates]
    return np.where(angles, 1.0, length(case.parameters))


def length(parameters: Any) -> float:
    """Return the shortest length of a scene [m]."""
    return min(
        value
        for name, value in parameters.as_dict().items()
        if isinstance(value, float)
        and value > 0
        and name.endswith(("length", "radius", "eccentricity"))
    )


def free_vibration(long: Long) -> Found:
    """Compare energy and phase of a mode with the powers of the amplification matrix."""
    mode = long.mode
    assert mode is not None
    scheme = Setup(long.engine, long.case, long.model, long.method).linear_scheme
    if scheme is None:
        raise CannotJudgeError(f"{long.method.name} is no known scheme")
    samples = windows(long)
    trajectory = long.simulate(samples)
    names = get_scene(long.case.scene).state_names
    own = long.own
    start = own.start(long.case)
    at_rest = replace(long.case, state=dict(zip(names, map(float, mode.rest), strict=True)))
    rest = settled(own, own.start(at_rest))
    soft = Setup(long.engine, long.case, long.model).has_soft_closure
    at = place(own, mode.about, rest, False, scheme == "semi_implicit_euler" or soft)
    powers = AMPLIFICATION[scheme](at.matrices, long.step)
    change = start - rest
    if len(powers) > len(change):
        change = np.append(change, (first_order(at.matrices) @ change)[len(change) // 2 :])
    ideal = rest[:, None] + propagated(powers, change, samples)[: len(rest)]
    mode = replace(mode, rest=rows(own, rest[:, None], names)[:, 0])
    wanted = mode.amplitudes(rows(own, ideal, names))
    seen = mode.amplitudes(trajectory.matrix(names))
    turns = mode.omega * samples * long.step
    steps = int(samples[-1])
    noise = rounding(steps, 1.0) + newton_noise(long) / mode.amplitude
    bend = mode.amplitude**2 * turns[-1] * max(1.0, mode.pushed * turns[-1])
    half = len(samples) // 2
    energy = [
        float(np.mean(np.abs(z[half:]) ** 2) / np.mean(np.abs(z[:half]) ** 2) - 1)
        for z in (seen, wanted)
    ]
    phase = [
        float(
            np.angle(
                np.mean(z[half:] * np.exp(-1j * turns[half:]))
                / np.mean(z[:half] * np.exp(-1j * turns[:half]))
            )
        )
        for z in (seen, wanted)
    ]
    # the angle between the two is small though each may have turned often
    apart = float(np.angle(np.exp(1j * (phase[0] - phase[1]))))
    whole = expected_phase(powers, mode.omega, long.step, steps)
    found = {
        "energy": Drift(
            energy[0], energy[1], (SAFETY - 1) * abs(energy[1]) + noise + mode.amplitude + bend
        ),
        "phase": Drift(whole + apart, whole, (SAFETY - 1) * min(abs(whole), 1.0) + noise + bend),
    }
    return Found(found | closure(long, trajectory) | clock(long, trajectory))


def settled(own: ModelEquations, near: Array) -> Array:
    """Return a claim's own state of rest (2 n,): soft closures give way to what holds it."""
    c, n = own.scene.coefficients(own.parameters), len(own.scene.coordinates)
    rest = np.array(near)
    for _ in range(8):
        _, _, stiffness = linearise(own.scene, own.parameters, rest)
        force = np.array(own.scene.forces(0.0, rest[:n], rest[n:], c, np), dtype=float)
        rest[:n] += np.linalg.lstsq(stiffness, force, rcond=1e-10)[0]
    return rest


def windows(long: Long) -> Any:
    """Return step numbers over the first and over the last period."""
    last = int(long.periods * long.period / long.step)
    count = int(long.period / long.step)
    every = max(1, count // WINDOW)
    begin = np.arange(1, count + 1, every)
    return np.concatenate([begin, last - begin[::-1] + 1])


def propagated(matrix: Array, start: Array, samples: Any) -> Array:
    """Return the states (k, n_t) after these numbers of steps of a linear map."""
    out, state, done = [], start, 0
    powers: dict[int, Array] = {}
    for number in samples:
        ahead = int(number) - done
        if ahead not in powers:
            powers[ahead] = np.linalg.matrix_power(matrix, ahead)
        state, done = powers[ahead] @ state, int(number)
        out.append(state)
    return np.array(out).T


def expected_phase(matrix: Array, omega: float, step: float, steps: int) -> float:
    """Return N arg mu - omega T [rad] of the eigenvalue mu that turns as the mode does."""
    with np.errstate(all="ignore"):
        turns = np.angle(np.linalg.eigvals(matrix)) / step
    return float((turns[np.argmin(np.abs(turns - omega))] - omega) * step * steps)


def newton_noise(long: Long) -> float:
    """Return what an implicit method's iteration leaves in a step [m, rad]."""
    tolerance = long.engine.newton_tolerance
    return 0.0 if long.method.scheme else float(tolerance) * long.periods


# --- Over a part, and on -------------------------------------------------------------------


def marks(long: Long, periods: float, count: int) -> Any:
    """Return about ``count`` step numbers, evenly spread over some periods."""
    last = round(periods * long.period / long.step)
    return np.unique(np.round(np.linspace(0, last, count + 1)[1:]).astype(int))


def conservative(long: Long) -> Found:
    """Compare the drift of the energy with the rate that it has over a part."""
    part = part_of(long)
    near, far = marks(long, part, 8 * part), marks(long, long.periods, 8 * part)
    trajectory = long.simulate(far)

    def energy(samples: Any, values: Mapping[str, Array]) -> Array:
        times = long.case.start_time + samples * long.step
        return drifts(scene_equations(long.case), long.case, times, values)["energy"]

    scheme = Setup(long.engine, long.case, long.model, long.method).scheme
    if scheme:
        rates, spread = rate(near, energy(near, long.by_scheme(scheme, near)))
    else:
        half, quarter = (rate(near, energy(near, long.simulate(near, k).values)) for k in (2, 4))
        rates, spread = coarser(long, half, quarter)
    seen = energy(far, trajectory.values)
    last = float(np.mean(seen[-len(seen) // 8 :]))
    centre = float(np.mean(far[-len(far) // 8 :]))
    wave = float(np.max(np.abs(seen[: len(seen) // 8] - np.mean(seen[: len(seen) // 8]))))
    predicted = float(np.expm1(np.clip(rates * centre, -50, 50)))
    slack = (SAFETY - 1) * abs(predicted) + spread * centre + wave + rounding(int(far[-1]), 1.0)
    return Found(
        {"energy": Drift(last, predicted, slack)}
        | closure(long, trajectory)
        | clock(long, trajectory)
    )


def rate(samples: Any, drift: Array) -> tuple[float, float]:
    """Return the rate of ln(1 + drift) per step, and its standard error from eight parts."""
    logs = np.log1p(np.maximum(drift, -1 + EPS))
    slope = float(np.polyfit(samples, logs, 1)[0])
    means = np.array([[np.mean(x) for x in np.array_split(row, 8)] for row in (samples, logs)])
    slopes = np.diff(means[1]) / np.diff(means[0])
    return slope, float(np.std(slopes) / np.sqrt(len(slopes)))


def coarser(
    long: Long, half: tuple[float, float], quarter: tuple[float, float]
) -> tuple[float, float]:
    """Return the rate with the whole step from those with a half and a quarter.

    Where the claim conserves, it shrinks with a power of the step, at least the order.
    """
    gain = 2.0**long.method.order
    if Setup(long.engine, long.case, long.model).has_soft_closure:
        return half[0] + gain * (half[0] - quarter[0]), half[1] + gain * (half[1] + quarter[1])
    ratio = half[0] / quarter[0] if quarter[0] else gain
    ratio = ratio if gain / 2**0.5 < ratio < 4 * gain**2 else gain
    return half[0] * ratio, half[1] * ratio


def after_pulse(long: Long) -> Found:
    """Compare the drift of energy and momentum after the drive with the rate over a part."""
    own = long.own
    part = min(max(8, part_of(long) // 4), long.periods)
    pushed = marks(long, own.scene.driven_until(own.parameters) / long.period, WINDOW)
    near, far = (
        np.union1d(pushed, marks(long, periods, 8 * part)) for periods in (part, long.periods)
    )
    trajectory = long.simulate(far)
    half, quarter = (long.simulate(near, k) for k in (2, 4))
    found = {}
    series = [
        drifts(own, long.case, long.case.start_time + samples * long.step, values.values)
        for samples, values in ((far, trajectory), (near, half), (near, quarter))
    ]
    for name, seen in series[0].items():
        quiet_far, quiet_near = far[-len(seen) :], near[-len(series[1][name]) :]
        rates, spread = coarser(
            long, rate(quiet_near, series[1][name]), rate(quiet_near, series[2][name])
        )
        span = float(quiet_far[-1] - quiet_far[0])
        predicted = float(np.expm1(np.clip(rates * span, -50, 50)))
        wave = float(np.max(np.abs(series[1][name] - series[2][name])))
        slack = (SAFETY - 1) * abs(predicted) + spread * span + wave + rounding(int(far[-1]), 1.0)
        found[name] = Drift(float(seen[-1]), predicted, slack)
    return Found(found | closure(long, trajectory) | clock(long, trajectory))


# --- Locked rotation -----------------------------------------------------------------------


def locked(long: Long) -> Found:
    """Compare the phase on the periodic orbit with that of the scheme, and count slips."""
    scene = get_scene(long.case.scene)
    turns = next(iter(scene.turning))
    per_period = round(long.period / long.step)
    part = part_of(long)
    near = per_period * np.arange(1, part + 1)
    far = np.unique(np.round(np.linspace(1, long.periods, 64)).astype(int)) * per_period
    trajectory = long.simulate(far)
    start = float(long.case.state[turns])

    def phase(samples: Any, values: Mapping[str, Array]) -> Array:
        whole = 2 * np.pi * scene.turning[turns] * samples / per_period
        return np.asarray(values[turns] - start - whole)

    scheme = Setup(long.engine, long.case, long.model, long.method).scheme
    if scheme:
        ideal, room = phase(near, long.by_scheme(scheme, near)), 0.0
    else:
        half, quarter = (phase(near, long.simulate(near, k).values) for k in (2, 4))
        gain = 2.0**long.method.order
        own_error = gain * gain / (gain - 1) * (half - quarter)
        room = float(np.max(np.abs(own_error))) / gain  # what the next order adds
        exact = long.own.is_exact_for(long.case)
        ideal = own_error + (0.0 if exact else phase(near, long.by_scheme(FINE, near)))
    seen = phase(far, trajectory.values)
    predicted = float(ideal[-1])
    if not scene.drive:
        later, unsettled = later_phase(long, ideal, far[-1] / per_period)
        predicted, room = predicted + later, room + unsettled
    elif long.engine.integrates_drive:
        predicted += late_drive(long, far[-1] - near[-1]) * float(long.case.state[f"{turns}_dot"])
    growth = rounding(int(far[-1]), 1.0) * 2 * np.pi * long.periods
    slack = (SAFETY - 1) * max(abs(predicted), float(np.max(np.abs(ideal)))) + room + growth
    slack += 0.0 if scene.drive or scheme else room * long.periods / part
    found = {"phase": Drift(float(seen[-1]), predicted, slack)}
    numbers = {
        "slips": float(round((seen[-1]) / (2 * np.pi))),
        "slips_predicted": float(round(predicted / (2 * np.pi))),
    }
    # where the phase is lost, a soft loop is seen at all places of a turn
    places = None if Setup(long.engine, long.case, long.model).has_soft_closure else near
    return Found(found | closure(long, trajectory, places) | clock(long, trajectory), numbers)


FINE = "RK44"
"""Scheme by which a claim is solved where its method has none."""


def later_phase(long: Long, phase: Array, end: float) -> tuple[float, float]:
    """Return by how much the phase (n,), known once a period, moves on, and how sure that is not.

    The start is the reference's orbit, and what differs from the engine's own dies out with the
    slowest Floquet multiplier mu: the phase moves by ``r (1 - mu^t)`` in a period, r to be found.

    Raises
    ------
    CannotJudgeError
        If what is known is too short.
    """
    orbit = known_orbit(long.case.scene, long.case.parameters)
    mu = max(abs(value) for i, value in enumerate(orbit.multipliers) if i != orbit.trivial)
    now, tail = len(phase), max(2, len(phase) // 4)
    if end <= now:
        return 0.0, 0.0
    if now < -1 / np.log(mu):
        raise CannotJudgeError(
            f"{now} periods are too few to predict from: a disturbance lasts {-1 / np.log(mu):.3g}"
        )
    t = np.arange(now - tail + 1, now + 1)
    settled = 1 - float(np.mean(mu**t))
    pace = float(np.polyfit(t, phase[-tail:], 1)[0]) / settled
    later = pace * (end - now - mu**now * (1 - mu ** (end - now)) / -np.log(mu))
    return float(later), float(abs(later) * mu**now)


def late_drive(long: Long, steps: float) -> float:
    """Return by how much a drive that is a body of the model is late after so many steps [s]."""
    omega = 2 * np.pi / long.period
    scheme = Setup(long.engine, long.case, long.model, long.method).linear_scheme
    assert scheme is not None
    mass, damping, stiffness = (np.array([[value]]) for value in (1.0, 0.0, omega**2))
    matrix = AMPLIFICATION[scheme](Vibrations(mass, damping, stiffness, damping), long.step)
    return expected_phase(matrix, omega, long.step, 1) * steps / omega


# --- Closure and clock ---------------------------------------------------------------------


ENFORCED: Mapping[str, str] = {
    "generalized_alpha": VIOLATIONS[0],
    "trapezoidal": VIOLATIONS[1],
}
"""What an implicit method solves for at the end of each step, by its linear scheme: index 3 keeps
the constraints themselves, index 2 their rates, up to what Newton leaves. The other drifts."""


def closure(long: Long, trajectory: Trajectory, near: Any = None) -> dict[str, Drift]:
    """Compare how far a loop is open at most with what the claim, or a part, shows.

    ``near`` are the step numbers of that part, at the same places of a period.
    """
    if VIOLATIONS[0] not in long.names:
        return {}
    if near is None:
        part = part_of(long)
        early = np.rint((trajectory.times - long.case.start_time) / long.step).astype(int)
        near = marks(long, part, 4 * part)
        near = np.union1d(near, early[early <= near[-1]])
    scheme = Setup(long.engine, long.case, long.model, long.method).scheme
    found = {}
    expected = long.by_scheme(scheme, near) if scheme else long.simulate(near).values
    size = length(long.case.parameters)
    for name in VIOLATIONS:
        seen = float(np.max(np.abs(trajectory.values[name])))
        opened = np.abs(expected[name])
        top = float(np.max(opened))
        room = top
        if not scheme:  # what is not kept grows with time, at most linearly from the start
            room *= float(long.periods * long.period / long.step / near[-1])
            slope = max(0.0, float(np.polyfit(near, opened, 1)[0]))
            top += slope * float(long.periods * long.period / long.step - near[-1])
        floor = VIOLATION * size * (1.0 if name == VIOLATIONS[0] else 2 * np.pi / long.period)
        kept = not scheme and ENFORCED.get(long.method.linear or "") == name
        found[name] = Drift(seen, 0.0, floor) if kept else Drift(seen, top, room + floor)
    return found


def clock(long: Long, trajectory: Trajectory) -> dict[str, Drift]:
    """Compare the engine's clock with n h: exact for steps of 2^-n, n eps t else."""
    late = float(np.max(np.abs(trajectory.clock - trajectory.times)))
    dyadic = np.frexp(long.step)[0] == 0.5
    end = float(trajectory.times[-1])
    return {"clock": Drift(late, 0.0, 0.0 if dyadic else EPS * trajectory.steps * end)}


MEASURES = {
    FREE: free_vibration,
    CONSERVATIVE: conservative,
    LOCKED: locked,
    AFTER_PULSE: after_pulse,
}

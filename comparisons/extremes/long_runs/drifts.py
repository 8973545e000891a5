"""What long motions leave of energy, phase, closure and clock, beside what is predicted.

* Small *free* vibrations are held against the powers of the amplification matrix, exact there.
* *Conservative* motion and the *locked* rotation on the periodic orbit are held against the
  method's scheme on the model's equations, run over a part of the horizon; what grows there is
  extrapolated.
* Where a method has no published scheme, they are held against the engine's own runs with half and
  a quarter of the step over that part, with the error that these have by their order. A loss of
  energy then is the engine's word against its own; a phase is not, for its limit must be the
  reference's.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.linalg import eigh

from ....reference import get_scene
from ....reference.amplification import AMPLIFICATION, Vibrations, first_order
from ....reference.errors import CannotJudgeError, MbcheckError
from ....reference.linear import linearise
from ....reference.scene import Array, Case
from ...checks.free_vibrations import late_joints_alone, place
from ...checks.kinds.energy import drifts
from ...checks.tolerances import SAFETY, VIOLATION, rounding, rows
from ...engines.equations import ModelEquations, scene_equations
from ...engines.run import EPS, VIOLATIONS, Trajectory
from .long_run import Drift, Drifts, FreeMode, LongRun, known_orbit, shortest_length

WINDOW = 32
"""Samples of a period at the start and at the end."""


def free_mode(case: Case) -> FreeMode:
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
            ratio = float(np.linalg.cond(mass * np.outer(sizes(case), sizes(case))))
            push = ratio if squares[0] < 1e-9 * squares[-1] else 0.0
            return FreeMode(about, rest, float(np.sqrt(squares[-1])), shapes[:, -1], mass, push)
    raise MbcheckError(f"{case.scene} has no stable state of rest here")


def started(case: Case, mode: FreeMode) -> Case:
    """Return the case that starts at the largest displacement of a mode."""
    scene = get_scene(case.scene)
    share = mode.amplitude / np.max(np.abs(mode.shape) / sizes(case))
    state = mode.rest + np.append(share * mode.shape, 0 * mode.shape)
    return replace(
        case, state=dict(zip(scene.state_names, state.tolist(), strict=True)), start_time=0.0
    )


def sizes(case: Case) -> Array:
    """Return the size (n,) of each coordinate: 1 rad, or the shortest length."""
    scene = get_scene(case.scene)
    angles = [scene.units[name] == "rad" for name in scene.coordinates]
    return np.where(angles, 1.0, shortest_length(case.parameters))


def free_vibration(run: LongRun) -> Drifts:
    """Compare energy and phase of a mode with the powers of the amplification matrix."""
    setup, mode = run.setup, run.mode
    scheme, equations = setup.linear_scheme, setup.equations
    if scheme is None or mode is None:
        raise CannotJudgeError(f"{setup.integrator.name} is no known scheme")
    samples = windows(run)
    trajectory = run.simulate(samples)
    names = setup.scene.state_names
    at_rest = replace(setup.case, state=dict(zip(names, mode.rest.tolist(), strict=True)))
    rest = rest_of(equations, equations.start(at_rest))
    at = place(equations, mode.about, rest, False, late_joints_alone(setup, scheme))
    powers = AMPLIFICATION[scheme](at.matrices, run.step)
    departure = equations.start(setup.case) - rest
    if len(powers) > len(departure):
        slopes = first_order(at.matrices) @ departure
        departure = np.append(departure, slopes[len(departure) // 2 :])
    ideal = rest[:, None] + propagated(powers, departure, samples)[: len(rest)]
    mode = replace(mode, rest=rows(equations, rest[:, None], names)[:, 0])
    angle = mode.omega * samples * run.step
    measured, expected = (
        change_of(mode.amplitudes(states), angle)
        for states in (trajectory.matrix(names), rows(equations, ideal, names))
    )
    steps = int(samples[-1])
    tolerance = 0.0 if setup.integrator.scheme else setup.engine.newton_tolerance
    noise = rounding(steps, 1.0) + tolerance * run.periods / mode.amplitude
    bend = mode.amplitude**2 * angle[-1] * max(1.0, mode.push * angle[-1])
    # the angle between the two is small though each may have turned often
    apart = float(np.angle(np.exp(1j * (measured[1] - expected[1]))))
    whole = expected_phase(powers, mode.omega, run.step, steps)
    energy_slack = (SAFETY - 1) * abs(expected[0]) + noise + mode.amplitude + bend
    phase_slack = (SAFETY - 1) * min(abs(whole), 1.0) + noise + bend
    drifts = {"energy": Drift(measured[0], expected[0], energy_slack)}
    left = np.sqrt(max(1 + expected[0], 0.0))
    if left > noise + mode.amplitude:  # what is smaller than its own distortion has no phase
        drifts["phase"] = Drift(whole + apart, whole, phase_slack)
    return Drifts(trajectory, drifts)


def change_of(amplitudes: Any, angle: Array) -> tuple[float, float]:
    """Return the relative change of the energy and the phase [rad] from first to last window.

    Parameters
    ----------
    amplitudes : complex array (n_t,)
        The first half of the first window.
    angle : array (n_t,)
        By which the mode turns [rad].
    """
    first, last = np.split(amplitudes, [len(angle) // 2])
    before, after = np.split(np.exp(-1j * angle), [len(angle) // 2])
    energy = np.mean(np.abs(last) ** 2) / np.mean(np.abs(first) ** 2) - 1
    return float(energy), float(np.angle(np.mean(last * after) / np.mean(first * before)))


def rest_of(equations: ModelEquations, near: Array) -> Array:
    """Return a state of rest (2 n,) of model equations: soft closures give way to what holds it."""
    scene, parameters = equations
    c, n = scene.coefficients(parameters), len(scene.coordinates)
    rest = np.array(near)
    for _ in range(8):
        _, _, stiffness = linearise(scene, parameters, rest)
        force = np.array(scene.forces(0.0, rest[:n], rest[n:], c, np), dtype=float)
        rest[:n] += np.linalg.lstsq(stiffness, force, rcond=1e-10)[0]
    return rest


def windows(run: LongRun) -> Any:
    """Return step numbers over the first and over the last period."""
    last = int(run.periods * run.period / run.step)
    count = int(run.period / run.step)
    begin = np.arange(1, count + 1, max(1, count // WINDOW))
    return np.concatenate([begin, last - begin[::-1] + 1])


def propagated(matrix: Array, start: Array, samples: Any) -> Array:
    """Return the states (k, n_t) after these numbers of steps of a linear map."""
    states, state = [], start
    powers: dict[int, Array] = {}
    for ahead in np.diff(samples, prepend=0).tolist():
        if ahead not in powers:
            powers[ahead] = np.linalg.matrix_power(matrix, ahead)
        state = powers[ahead] @ state
        states.append(state)
    return np.array(states).T


def expected_phase(matrix: Array, omega: float, step: float, steps: float) -> float:
    """Return N arg mu - omega T [rad] of the eigenvalue mu that turns as the mode does."""
    with np.errstate(all="ignore"):
        rates = np.angle(np.linalg.eigvals(matrix)) / step
    return float((rates[np.argmin(np.abs(rates - omega))] - omega) * step * steps)


PULSE_SAMPLES = 32
"""Samples while a drive still acts."""

FINE = "RK44"
"""Scheme by which model equations are solved where the method has none."""

Rate = tuple[float, float]
"""A rate, and its standard error."""


def conservative(run: LongRun) -> Drifts:
    """Compare the drift of the energy with the rate that it has over a part."""
    part, setup = run.part, run.setup
    near, far = run.marks(part, 8 * part), run.marks(run.periods, 8 * part)
    trajectory = run.simulate(far)

    def energy(samples: Any, values: Mapping[str, Array]) -> Array:
        times = setup.case.start_time + samples * run.step
        return drifts(scene_equations(setup.case), setup.case, times, values)["energy"]

    if setup.scheme:
        slope, spread = rate(near, energy(near, run.by_scheme(setup.scheme, near)))
    else:
        half, quarter = (rate(near, energy(near, run.simulate(near, k).values)) for k in (2, 4))
        slope, spread = whole_step_rate(run, half, quarter)
    measured = energy(far, trajectory.values)
    eighth = len(measured) // 8
    last, centre = (float(np.mean(row[-len(row) // 8 :])) for row in (measured, far))
    wave = float(np.max(np.abs(measured[:eighth] - np.mean(measured[:eighth]))))
    return Drifts(
        trajectory, {"energy": extrapolated(last, (slope, spread), centre, wave, int(far[-1]))}
    )


def extrapolated(measured: float, rate: Rate, steps: float, wave: float, last: int) -> Drift:
    """Return a drift beside what its rate makes of so many steps, of ``last`` in all."""
    predicted = float(np.expm1(np.clip(rate[0] * steps, -50, 50)))
    slack = (SAFETY - 1) * abs(predicted) + rate[1] * steps + wave + rounding(last, 1.0)
    return Drift(measured, predicted, slack)


def rate(samples: Any, drift: Array) -> Rate:
    """Return the rate of ln(1 + drift) per step, and its standard error from eight parts."""
    logs = np.log1p(np.maximum(drift, -1 + EPS))
    slope = float(np.polyfit(samples, logs, 1)[0])
    means = np.array([[np.mean(x) for x in np.array_split(row, 8)] for row in (samples, logs)])
    slopes = np.diff(means[1]) / np.diff(means[0])
    return slope, float(np.std(slopes) / np.sqrt(len(slopes)))


def whole_step_rate(run: LongRun, half: Rate, quarter: Rate) -> Rate:
    """Return the rate with the whole step from those with a half and a quarter.

    Where the model's equations conserve, it shrinks with a power of the step, at least the order.
    """
    gain = 2.0**run.setup.integrator.order
    if run.setup.has_soft_closure:
        return half[0] + gain * (half[0] - quarter[0]), half[1] + gain * (half[1] + quarter[1])
    ratio = half[0] / quarter[0] if quarter[0] else gain
    ratio = ratio if gain / 2**0.5 < ratio < 4 * gain**2 else gain
    return half[0] * ratio, half[1] * ratio


def after_pulse(run: LongRun) -> Drifts:
    """Compare the drift of energy and momentum after the drive with the rate over a part."""
    equations, case = run.setup.equations, run.setup.case
    part = min(max(8, run.part // 4), run.periods)
    end = equations.scene.drive_end_time(equations.parameters) / run.period
    driven = run.marks(end, PULSE_SAMPLES)
    near, far = (
        np.union1d(driven, run.marks(periods, 8 * part)) for periods in (part, run.periods)
    )
    trajectory = run.simulate(far)
    half, quarter = (run.simulate(near, k) for k in (2, 4))
    series = [
        drifts(equations, case, case.start_time + samples * run.step, one.values)
        for samples, one in ((far, trajectory), (near, half), (near, quarter))
    ]
    compared = {}
    for name, measured in series[0].items():
        by_parts = [one[name] for one in series[1:]]
        quiet_far, quiet_near = far[-len(measured) :], near[-len(by_parts[0]) :]
        slopes = whole_step_rate(run, *(rate(quiet_near, one) for one in by_parts))
        span = float(quiet_far[-1] - quiet_far[0])
        wave = float(np.max(np.abs(by_parts[0] - by_parts[1])))
        compared[name] = extrapolated(float(measured[-1]), slopes, span, wave, int(far[-1]))
    return Drifts(trajectory, compared)


def locked(run: LongRun) -> Drifts:
    """Compare the phase on the periodic orbit with that of the scheme, and count slips."""
    setup, part = run.setup, run.part
    scene, case = setup.scene, setup.case
    angle, turns = next(iter(scene.rotations_per_period.items()))
    per_period = round(run.period / run.step)
    near = per_period * np.arange(1, part + 1)
    far = np.unique(np.round(np.linspace(1, run.periods, 64)).astype(int)) * per_period
    trajectory = run.simulate(far)

    def phase(samples: Any, values: Mapping[str, Array]) -> Array:
        whole = 2 * np.pi * turns * samples / per_period
        return np.asarray(values[angle] - float(case.state[angle]) - whole)

    if setup.scheme:
        ideal, room = phase(near, run.by_scheme(setup.scheme, near)), 0.0
    else:
        half, quarter = (phase(near, run.simulate(near, k).values) for k in (2, 4))
        gain = 2.0**setup.integrator.order
        ideal = gain * gain / (gain - 1) * (half - quarter)
        room = float(np.max(np.abs(ideal))) / gain  # what the next order adds
        if not setup.is_exact:
            ideal = ideal + phase(near, run.by_scheme(FINE, near))
    measured = phase(far, trajectory.values)
    predicted = float(ideal[-1])
    if not scene.drive:
        later, unsettled = later_phase(run, ideal, far[-1] / per_period)
        predicted, room = predicted + later, room + unsettled
    elif setup.integrates_drive:
        predicted += late_drive(run, far[-1] - near[-1]) * float(case.state[f"{angle}_dot"])
    growth = rounding(int(far[-1]), 1.0) * 2 * np.pi * run.periods
    slack = (SAFETY - 1) * max(abs(predicted), float(np.max(np.abs(ideal)))) + room + growth
    slack += 0.0 if scene.drive or setup.scheme else room * run.periods / part
    last = float(measured[-1])
    slips = {"slips": last, "slips_predicted": predicted}
    return Drifts(
        trajectory,
        {"phase": Drift(last, predicted, slack)},
        # where the phase is lost, a soft loop is seen at all places of a turn
        None if setup.has_soft_closure else near,
        {name: float(round(value / (2 * np.pi))) for name, value in slips.items()},
    )


def later_phase(run: LongRun, phase: Array, end: float) -> tuple[float, float]:
    """Return by how much the phase (n,), known once a period, moves on, and how unsure that is.

    The start is the reference's orbit, and what differs from the engine's own dies out with the
    slowest Floquet multiplier mu: the phase moves by ``r (1 - mu^t)`` in a period, with r fitted.

    Raises
    ------
    CannotJudgeError
        If what is known is too short.
    """
    orbit = known_orbit(run.setup.scene.name, run.setup.case.parameters)
    mu = max(abs(value) for i, value in enumerate(orbit.multipliers) if i != orbit.trivial)
    now, tail = len(phase), max(2, len(phase) // 4)
    if end <= now:
        return 0.0, 0.0
    if now < -1 / np.log(mu):
        raise CannotJudgeError(
            f"{now} periods are too few to predict from: a disturbance lasts {-1 / np.log(mu):.3g}"
        )
    t = np.arange(now - tail + 1, now + 1)
    pace = float(np.polyfit(t, phase[-tail:], 1)[0]) / (1 - float(np.mean(mu**t)))
    later = pace * (end - now - mu**now * (1 - mu ** (end - now)) / -np.log(mu))
    return float(later), float(abs(later) * mu**now)


def late_drive(run: LongRun, steps: float) -> float:
    """Return by how much a drive that is a body of the model is late after so many steps [s]."""
    omega = 2 * np.pi / run.period
    scheme = run.setup.linear_scheme
    assert scheme is not None
    mass, damping, stiffness = (np.array([[value]]) for value in (1.0, 0.0, omega**2))
    matrix = AMPLIFICATION[scheme](Vibrations(mass, damping, stiffness, damping), run.step)
    return expected_phase(matrix, omega, run.step, 1) * steps / omega


ENFORCED: Mapping[str, str] = {
    "generalized_alpha": VIOLATIONS[0],
    "trapezoidal": VIOLATIONS[1],
}
"""What an implicit method solves for at the end of each step, by its linear scheme: index 3 keeps
the constraints themselves, index 2 their rates, up to what Newton leaves. The other drifts."""


def closure(run: LongRun, trajectory: Trajectory, near: Any = None) -> dict[str, Drift]:
    """Compare how far a loop is open at most with what the model's equations, or a part, show.

    ``near`` are the step numbers of that part, at the same places of a period.
    """
    setup = run.setup
    if not setup.has_constraints:
        return {}
    if near is None:
        early = np.rint((trajectory.times - setup.case.start_time) / run.step).astype(int)
        near = run.marks(run.part, 4 * run.part)
        near = np.union1d(near, early[early <= near[-1]])
    expected = run.by_scheme(setup.scheme, near) if setup.scheme else run.simulate(near).values
    steps = run.periods * run.period / run.step
    compared = {}
    for name, unit in zip(VIOLATIONS, (1.0, 2 * np.pi / run.period), strict=True):
        opening = np.abs(expected[name])
        predicted = room = float(np.max(opening))
        if not setup.scheme:  # what is not enforced grows with time, at most linearly
            room *= float(steps / near[-1])
            predicted += max(0.0, float(np.polyfit(near, opening, 1)[0])) * float(steps - near[-1])
            if ENFORCED.get(setup.integrator.linear or "") == name:
                predicted = room = 0.0
        floor = VIOLATION * shortest_length(setup.case.parameters) * unit
        compared[name] = Drift(
            float(np.max(np.abs(trajectory.values[name]))), predicted, room + floor
        )
    return compared


def clock(run: LongRun, trajectory: Trajectory) -> dict[str, Drift]:
    """Compare the engine's clock with n h: exact for steps of 2^-n, n eps t else."""
    late = float(np.max(np.abs(trajectory.clock - trajectory.times)))
    dyadic = np.frexp(run.step)[0] == 0.5
    end = float(trajectory.times[-1])
    return {"clock": Drift(late, 0.0, 0.0 if dyadic else EPS * trajectory.steps * end)}

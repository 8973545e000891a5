"""Kind *long*: energy, phase, closure and clock after hundreds of periods.

Every drift of a right engine vanishes with the step: a second run with half the step predicts it. A
motion also counts as lost if a tenth of its amplitude or of its period is gone, however well that
is predicted. A soft closure dissipates energy at any step: its drift is not judged, its loss is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import eigh

from ....reference import get_scene
from ....reference.equations import invariants_of, scene_equations
from ....reference.errors import MbcheckError
from ....reference.linear import linearise
from ....reference.scene import Array, Case
from ...engines.run import EPS, VIOLATIONS, Trajectory
from ...engines.setup import Setup, shortest_period
from ..comparison import RICHARDSON_SAFETY, VIOLATION, Measured, drifts
from ..orbits import true_orbit
from ..rules.cautions import cautions, noticing_rules
from ..truth import rounding
from ..verdict import REFERENCE, Finding, Inconclusive

FREE, CONSERVATIVE, LOCKED, AFTER_PULSE = "free", "conservative", "locked", "after_pulse"
"""Motions, as the `watch` of a case: small free vibrations about a state of rest; motion without
forces and dampers; rotation on the periodic orbit; motion after a drive has ended."""

AMPLITUDE, AMPLITUDE_IF_PUSHED = 1e-4, 1e-6
"""Amplitudes of free vibrations, in the size of the scene (1 rad, its shortest length): nonlinear
terms change frequencies by their square. The second is for scenes with a coordinate without a
spring, which a vibration pushes away by a constant force of second order."""

WINDOW = 32
"""Samples of a period at the start and at the end."""

MARKS = 512
"""Samples of a run whose energy is followed."""

LOSS = 0.1
"""Part of an amplitude, or of a period, whose loss makes a motion wrong although predicted."""

MOST_LOST = {"energy": 2 * LOSS, "phase": 2 * np.pi * LOSS}
"""The same of each quantity: relative, and [rad]."""

Drifts = dict[str, tuple[float, float]]
"""Drift of each quantity over a run, and its floor by round-off and the size of the motion."""


@dataclass(frozen=True)
class LongRun:
    """A long run of a setup, and the drifts that it shows.

    Attributes
    ----------
    setup : Setup
        With its step; its case starts the motion and has the horizon.
    period : float
        [s]
    samples : int array (n_t,)
        Step numbers.
    drifts : callable ``(trajectory) -> Drifts``
    """

    setup: Setup
    period: float
    samples: Any
    drifts: Callable[[Trajectory], Drifts]

    def drifts_of(self, trajectory: Trajectory) -> Drifts:
        """Return the drifts of a trajectory, and how far loops were open."""
        by_name = self.drifts(trajectory)
        length = shortest_length(self.setup.case.parameters)
        if has_rigid_loops(self.setup):
            for name, unit in zip(VIOLATIONS, (1.0, 2 * np.pi / self.period), strict=True):
                opening = float(np.max(np.abs(trajectory.values[name])))
                by_name[name] = opening, VIOLATION * length * unit
        return by_name


def conserves(setup: Setup) -> bool:
    """Return True if the model takes nothing from a motion: a soft closure does."""
    return bool(setup.scene.discretisation_coordinates) or not setup.bound.has_soft_closure


def has_rigid_loops(setup: Setup) -> bool:
    """Return True if the model closes loops by constraints that do not give way."""
    return setup.bound.has_constraints and conserves(setup)


def followed(setup: Setup) -> tuple[str, ...]:
    """Return the names of the drifts of a run."""
    if setup.case.watch == AFTER_PULSE:
        return tuple(invariants_of(setup.bound.equations))
    return {FREE: ("energy", "phase"), LOCKED: ("phase",)}.get(setup.case.watch, ("energy",))


def quantities(setup: Setup) -> tuple[str, ...]:
    """Return the names of the measured quantities."""
    names = followed(setup)
    drifting = [f"{name}_drift" for name in names if conserves(setup)]
    lost = [f"{name}_lost" for name in names if name in MOST_LOST]
    return (*drifting, *lost, *(VIOLATIONS if has_rigid_loops(setup) else ()), "clock")


def measure(setup: Setup) -> Measured:
    """Follow a motion with the step and with half of it, and judge what drifts."""
    run = RUNS[setup.case.watch](setup)
    step, horizon = run.setup.step_size, run.setup.case.horizon
    whole, half = (run.setup.simulate(step / k, run.samples * k) for k in (1, 2))
    first, second = run.drifts_of(whole), run.drifts_of(half)
    gain = 2**run.setup.integrator.order
    span = f"after {horizon / run.period:.4g} periods with h = {step:.3g} s"
    findings = []
    for name, (drift, floor) in first.items():
        other = second.get(name, (np.inf, 0.0))[0]
        reason = f"{name} {drift:.3g} {span}, {other:.3g} with half of it"
        left, left_by_half = drift, other
        if name == "energy":  # its rate of loss, which goes with the step, shows in the logarithm
            left, left_by_half = (float(np.log1p(max(one, -1 + EPS))) for one in (drift, other))
        tolerance = RICHARDSON_SAFETY * gain / (gain - 1) * abs(left - left_by_half) + floor
        quantity = name if name in VIOLATIONS else f"{name}_drift"
        findings.append(Finding(quantity, "1", left, 0.0, abs(left), tolerance, reason))
        if name in MOST_LOST:
            lost, most = max(abs(drift), abs(other)), MOST_LOST[name]
            findings.append(Finding(f"{name}_lost", "1", lost, 0.0, lost, most, reason))
    late = float(np.max(np.abs(whole.clock - whole.times)))
    dyadic = np.frexp(step)[0] == 0.5
    granted = 0.0 if dyadic else EPS * whole.steps * float(whole.times[-1])
    findings.append(Finding("clock", "s", late, 0.0, late, granted, f"{late:.2g} s off {span}"))
    noticed: tuple[str, ...] = ()
    if any(not one.error <= one.tolerance for one in findings):
        noticed = (*noticing_rules(cautions(run.setup, horizon)), REFERENCE)
    asked = {one.quantity: replace(one, noticed_by=noticed) for one in findings}
    gone = "the motion has decayed below its distortion"
    return Measured([asked.get(name, Inconclusive(name, gone)) for name in quantities(setup)])


# Free vibrations ----------------------------------------------------------------------------


class FreeMode(NamedTuple):
    """An undamped mode about a state of rest of a scene.

    Attributes
    ----------
    rest : array (2 n,)
    omega : float
        [rad/s]
    shape : array (n,)
        Normed by the mass matrix.
    mass : array (n, n)
    push : float
        0 where every coordinate has a spring; else the ratio of the largest inertia to the least,
        with which the forces of second order push one that has none.
    amplitude : float
    """

    rest: Array
    omega: float
    shape: Array
    mass: Array
    push: float
    amplitude: float

    def amplitudes(self, states: Array) -> Any:
        """Return ``a - i a'/omega`` (n_t,), which turns with ``exp(i omega t)``."""
        q, v = np.split(states - self.rest[:, None], 2)
        shape = self.shape @ self.mass
        return shape @ q - 1j * (shape @ v) / self.omega


def free_mode(case: Case) -> FreeMode:
    """Return the fastest mode about the first stable state of rest.

    Raises
    ------
    MbcheckError
        If there is no stable one.
    """
    scene, size = get_scene(case.scene), sizes(case)
    for where in scene.equilibria.values():
        rest = scene.state(where(case.parameters))
        mass, _, stiffness = linearise(scene, case.parameters, rest)
        squares, shapes = eigh((stiffness + stiffness.T) / 2, mass)
        if squares[0] > -1e-9 * squares[-1] and squares[-1] > 0:
            ratio = float(np.linalg.cond(mass * np.outer(size, size)))
            omega, shape = float(np.sqrt(squares[-1])), shapes[:, -1]
            if squares[0] < 1e-9 * squares[-1]:
                return FreeMode(rest, omega, shape, mass, ratio, AMPLITUDE_IF_PUSHED)
            return FreeMode(rest, omega, shape, mass, 0.0, AMPLITUDE)
    raise MbcheckError(f"{case.scene} has no stable state of rest here")


def started(case: Case, mode: FreeMode) -> Case:
    """Return the case that starts at the largest displacement of a mode."""
    share = mode.amplitude / np.max(np.abs(mode.shape) / sizes(case))
    state = mode.rest + np.append(share * mode.shape, 0 * mode.shape)
    names = get_scene(case.scene).state_names
    return replace(case, state=dict(zip(names, state.tolist(), strict=True)), start_time=0.0)


def sizes(case: Case) -> Array:
    """Return the size (n,) of each coordinate: 1 rad, or the shortest length."""
    scene = get_scene(case.scene)
    angles = [scene.units[name] == "rad" for name in scene.coordinates]
    return np.where(angles, 1.0, shortest_length(case.parameters))


def shortest_length(parameters: Any) -> float:
    """Return the shortest length of a scene [m], 1 m if it has none."""
    endings = ("length", "radius", "eccentricity")
    lengths = [value for name, value in parameters.as_dict().items() if name.endswith(endings)]
    return min((value for value in lengths if isinstance(value, float) and value > 0), default=1.0)


def free_vibration(setup: Setup) -> LongRun:
    """Return the changes of energy and phase of the fastest mode over the run."""
    mode, step = free_mode(setup.case), setup.step_size
    period = 2 * np.pi / mode.omega
    count = int(period / step)
    begin = np.arange(1, count + 1, max(1, count // WINDOW))
    samples = np.concatenate([begin, int(setup.case.horizon / step) - begin[::-1] + 1])
    angle = mode.omega * samples * step
    rotation = np.exp(-1j * angle)
    tolerance = 0.0 if setup.integrator.scheme else setup.engine.newton_tolerance
    noise = rounding(int(samples[-1]), 1.0)
    noise += tolerance * setup.case.horizon / period / mode.amplitude
    bend = mode.amplitude**2 * angle[-1] * max(1.0, mode.push * angle[-1])

    def losses(trajectory: Trajectory) -> Drifts:
        amplitudes = mode.amplitudes(trajectory.matrix(setup.scene.state_names))
        first, last = np.split(amplitudes, 2)
        left = float(np.mean(np.abs(last) ** 2) / np.mean(np.abs(first) ** 2))
        before, after = (np.mean(part) for part in np.split(amplitudes * rotation, 2))
        by_name = {"energy": (left - 1, noise + mode.amplitude + bend)}
        if np.sqrt(left) > noise + mode.amplitude:
            by_name["phase"] = float(np.angle(after / before)), noise + bend
        return by_name

    return LongRun(setup, period, samples, losses)


# Motions of any size ------------------------------------------------------------------------


def conservative(setup: Setup) -> LongRun:
    """Return the loss of energy of a motion, or after a drive of all that it conserves.

    The loss is the mean over the last eighth; the variation in the first eighth is granted.
    """
    case, step = setup.case, setup.step_size
    after_drive = case.watch == AFTER_PULSE
    equations = setup.bound.equations if after_drive else scene_equations(case)
    end = equations.scene.drive_end_time(equations.parameters) if after_drive else 0.0
    samples = np.union1d(marks(end, step, WINDOW), marks(case.horizon, step, MARKS))

    def losses(trajectory: Trajectory) -> Drifts:
        by_name = {}
        for name, drift in drifts(equations, case, trajectory.times, trajectory.values).items():
            if name in followed(setup):
                first, *_, last = np.array_split(drift, 8)
                wave = float(np.max(np.abs(first - np.mean(first))))
                by_name[name] = float(np.mean(last)), wave + rounding(int(samples[-1]), 1.0)
        return by_name

    return LongRun(setup, shortest_period(case), samples, losses)


def marks(span: float, step: float, count: int) -> Any:
    """Return about so many step numbers, evenly spread over a span [s]."""
    numbers = np.unique(np.round(np.linspace(0, round(span / step), count + 1)).astype(int))
    return numbers[numbers > 0]


def locked(setup: Setup) -> LongRun:
    """Return the phase drift of a rotation on the periodic orbit."""
    scene, case, longest = setup.scene, setup.case, setup.step_size
    orbit = true_orbit(case.scene, case.parameters)
    per_period = int(np.ceil(orbit.period / longest))
    periods = int(case.horizon / orbit.period)
    state = dict(zip(scene.state_names, orbit.state.tolist(), strict=True))
    case = replace(case, state=state, start_time=0.0, horizon=periods * orbit.period)
    setup = setup.with_case(case).with_step(orbit.period / per_period)
    angle, turns = next(iter(scene.rotations_per_period.items()))
    samples = marks(periods, 1.0, 2 * WINDOW) * per_period
    floor = rounding(int(samples[-1]), 1.0) * 2 * np.pi * periods

    def losses(trajectory: Trajectory) -> Drifts:
        whole = 2 * np.pi * turns * periods
        return {"phase": (float(trajectory.values[angle][-1]) - state[angle] - whole, floor)}

    return LongRun(setup, orbit.period, samples, losses)


RUNS: Mapping[str, Callable[[Setup], LongRun]] = {
    FREE: free_vibration,
    CONSERVATIVE: conservative,
    LOCKED: locked,
    AFTER_PULSE: conservative,
}
"""`watch` of a case -> function that prepares its run."""

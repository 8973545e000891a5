"""Small free vibrations for long: against the powers of the amplification matrix, exact there."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.linalg import eigh

from ....reference import get_scene
from ....reference.amplification import AMPLIFICATION, first_order
from ....reference.errors import CannotJudgeError, MbcheckError
from ....reference.linear import linearise
from ....reference.scene import Array, Case
from ...checks.free_vibrations import late_joints_alone, place
from ...checks.tolerances import SAFETY, rounding, rows
from ...engines.equations import ModelEquations
from .long_run import Drift, Drifts, FreeMode, LongRun, shortest_length

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
    values = dict(zip(scene.state_names, state.tolist(), strict=True))
    return replace(case, state=values, start_time=0.0)


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
    drifts = {
        "energy": Drift(measured[0], expected[0], energy_slack),
        "phase": Drift(whole + apart, whole, phase_slack),
    }
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

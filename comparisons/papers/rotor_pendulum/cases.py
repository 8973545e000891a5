"""Measures of the rotor_pendulum paper's three cases, section 5.2, and of their starts.

(14) is the tangent at working speed. From rest it gives fifty times the working torque; what a
motor's own curve gives there, the text does not say.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from ....reference.rotor_pendulum import CASE_1, CASE_2, CASE_3, theory
from ....reference.rotor_pendulum.equations import (
    RotorPendulum,
    accelerations,
    coefficients,
    mass_matrix,
    operating_speed,
)
from ....reference.rotor_pendulum.phase import coupling_harmonics, forced_response, wrapped
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ..ledger import Numbers, half_unit
from ..session import Session
from .results import (
    CASES,
    PER_SECOND,
    PRINTED_RATIOS,
    SCENE,
    StartUp,
    from_rest,
    orbit_value,
    settled,
    synchronous_orbit,
)

LARGEST = 8.0
"""Largest torque of the motor's curve [N m]: about 2.6 times the working torque, as is usual."""
DURATION = 3.0
"""Of a start [s]: with that curve the slowest rotor is at working speed after 0.51 s."""
AT_SPEED = 0.9
"""Share of the working speed from which on a rotor no longer speeds up."""


def motor_curve(p: RotorPendulum, largest: float) -> Callable[[Any], Any]:
    """Return the torque [N m] over the speed [rad/s] of an induction motor, after Kloss.

    ``2 M s s_k / (s^2 + s_k^2)`` over the slip s, with the largest torque M at ``s_k``, which
    makes its slope at no torque that of (14).
    """
    speed = float(p.synchronous_speed)
    at = 2 * largest / (float(p.motor_slope) * speed)

    def torque(rate: Any) -> Any:
        slip = 1 - rate / speed
        return 2 * largest * slip * at / (slip**2 + at**2)

    return torque


def start_by_curve(session: Session, case: int, largest: float = LARGEST) -> StartUp:
    """Return the start of a case with motors that follow `motor_curve`."""
    p = CASES[case]
    c, curve = coefficients(p), motor_curve(p, largest)

    def derivative(time: float, state: Array) -> Array:
        q, v = state[:4], state[4:]
        more = [0.0, *(curve(rate) - c.slope * (c.speed - rate) for rate in v[1:3]), 0.0]
        matrix = np.array(mass_matrix(q, c), dtype=float)
        own = np.array(accelerations(0.0, q, v, c), dtype=float)
        return np.concatenate([v, own + np.linalg.solve(matrix, more)])

    def run() -> StartUp:
        times = np.arange(round(DURATION * PER_SECOND) + 1) / PER_SECOND
        solution = solve_ivp(
            derivative, times[[0, -1]], np.zeros(8), "DOP853", times, rtol=1e-8, atol=1e-9
        )
        return StartUp(p, times, solution.y)

    return session.once((SCENE, "start by curve", case, largest), run)


def starts(session: Session, case: int) -> tuple[StartUp, StartUp]:
    """Return a case's starts by (14) and by the motor's curve."""
    return from_rest(session, case), start_by_curve(session, case)


def time_to_speed(run: StartUp) -> float:
    """Return the time [s] at which the slower rotor first comes to its speed."""
    fast = run.states[5:7] > AT_SPEED * float(operating_speed(run.parameters))
    return float(run.times[np.argmax(fast, axis=1).max()])


def gap(run: StartUp) -> float:
    """Return the largest difference of the speeds until both rotors are at it, over it."""
    early = run.times <= time_to_speed(run)
    apart = np.abs(run.states[5] - run.states[6])[early]
    return float(apart.max() / operating_speed(run.parameters))


def gaps(session: Session, case: int) -> Numbers:
    """Return the largest differences of the rotors' speeds in a start, by both laws."""
    laws = [gap(run) for run in starts(session, case)]
    return {"laws": laws, "least": min(laws), "largest": max(laws)}


def stiffer_is_calmer(session: Session) -> Numbers:
    """Return the differences of the speeds in cases 1 and 2, by both laws, and their quotients."""
    first, second = (gaps(session, case)["laws"] for case in (1, 2))
    return {"first": first, "second": second, "ratios": np.divide(second, first)}


def differences(session: Session) -> Numbers:
    """Return how speeds and phase of cases 1 and 2 move from rest, and at the end.

    Largest differences of the speeds, over them; how far the phase moves in the first second,
    on the whole and in the last half second [rad], its mean over turns.
    """
    early, moves, rests, turn = [], [], [], round(PER_SECOND / 24)
    for case in (1, 2):
        phase = np.convolve(from_rest(session, case).phase, np.ones(turn) / turn, "valid")
        early.append(float(np.ptp(phase[:PER_SECOND])))
        moves.append(float(np.ptp(phase)))
        rests.append(float(np.ptp(phase[-PER_SECOND // 2 :])))
    return {
        "gaps": [gap(from_rest(session, case)) for case in (1, 2)],
        "early": early,
        "moves": moves,
        "rests": rests,
        "slows": np.divide(moves, rests),
    }


def larger_swing(session: Session) -> Numbers:
    """Return the rod's largest angle [rad] in the starts of cases 1 and 2, by both laws.

    And by how many times it, and the difference of the speeds, are larger in case 2.
    """
    swings = [
        [float(np.abs(run.states[3, run.times <= time_to_speed(run)]).max()) for run in both]
        for both in (starts(session, 1), starts(session, 2))
    ]
    return {
        "first": swings[0],
        "second": swings[1],
        "ratios": np.divide(swings[1], swings[0]),
        "differ": stiffer_is_calmer(session)["ratios"],
    }


def passages(session: Session) -> Numbers:
    """Return the largest x and phi_3 of case 2's start over those at its end, by both laws.

    And the times [s] after which both rotors are at working speed.
    """
    runs = starts(session, 2)
    ratios = []
    for run in runs:
        size = np.abs(run.states[[0, 3]])
        ratios.append(size[:, run.times < 1].max(axis=1) / size[:, run.last].max(axis=1))
    return {
        "linear": ratios[0],
        "curve": ratios[1],
        "largest": np.max(ratios),
        "times": [time_to_speed(run) for run in runs],
    }


def lead_of_rotor_1(session: Session) -> Numbers:
    """Return how much faster rotor 1 is in case 3 until both are at speed, by the curve [rad/s]."""
    run = start_by_curve(session, 3)
    early = run.times <= time_to_speed(run)
    return {"curve": float(np.mean((run.states[5] - run.states[6])[early]))}


def duration_of_case_1(session: Session) -> Numbers:
    """Return between which times [s] the phase of case 1 from rest rounds to the printed 3.10 rad.

    NaN if it never does.
    """
    run = from_rest(session, 1)
    size = np.abs((run.phase + np.pi) % (2 * np.pi) - np.pi)
    turns = round(PER_SECOND / 24)
    mean = np.convolve(size, np.ones(turns) / turns, "same")[turns:-turns]
    there = run.times[turns:-turns][np.abs(mean - 3.10) <= 0.005]
    return {"begin": there.min(initial=np.inf), "end": there.max(initial=-np.inf)}


PRINTED_POINTS = (("153.8", "3.08"), ("153.5", "3.23"))
"""Speeds [rad/s] and torques [N m] that section 5.2 prints for cases 1 and 2."""


def one_motor(session: Session) -> Numbers:
    """Return True if a line, or a motor's curve, goes through the points of cases 1 and 2.

    Ranges of the slope from the speed without load [N m s/rad] that rounding allows, by how much
    they overlap, and from which speed without load on they do [rad/s]; the range of the largest
    torque of such curves [N m].
    """
    speed, signs = float(CASES[1].synchronous_speed), (-1, 0, 1)
    boxes = [
        [
            (speed - float(rate) - i * half_unit(rate), float(torque) + j * half_unit(torque))
            for i in signs
            for j in signs
        ]
        for rate, torque in PRINTED_POINTS
    ]
    slopes = [[torque / slip for slip, torque in box] for box in boxes]
    (slip_1, low), (slip_2, high) = boxes[0][0], boxes[1][-1]
    onset = speed - (high * slip_1 - low * slip_2) / (high - low)
    largest = []
    for (slip_1, torque_1), (slip_2, torque_2) in product(*boxes):
        bend = torque_1 * slip_2 / (slip_1 * torque_2)
        square = (bend - 1) / ((slip_2 / speed) ** 2 - bend * (slip_1 / speed) ** 2)
        if square > 0:  # of 1/s_k
            slope = torque_1 / slip_1 * (1 + square * (slip_1 / speed) ** 2)
            largest.append(slope * speed / (2 * np.sqrt(square)))
    return {
        "first": [min(slopes[0]), max(slopes[0])],
        "second": [min(slopes[1]), max(slopes[1])],
        "onset": onset,
        "overlap": min(map(max, slopes)) - max(map(min, slopes)),
        "curves": [min(largest), max(largest)],
    }


WAVE = 2 * np.pi

CALIBRATED = CASE_1.replace(motor_slope=0.9391, friction=0.0199)
"""Case 1 with the motor and the friction that its printed speed and torque make, to all digits;
the scene's defaults are these, rounded."""

ORBITS = {**CASES, 1: CALIBRATED}
"""Parameters of the synchronous orbits that are held against section 5.2's numbers."""

# Synchronous orbits


def orbit_quantity(
    session: Session, who: str, case: int, quantity: str, sign: float = 1.0
) -> float:
    """Return a quantity of the synchronous orbit of a case."""
    return sign * orbit_value(synchronous_orbit(session, ORBITS[case], who), quantity)


def theoretical(session: Session, case: int, sign: float) -> Numbers:
    """Return the paper's theoretical phase [rad] at its own frequency ratios, and at ours."""
    n = PRINTED_RATIOS[case]
    return {
        "value": sign * float(theory.stable_phase_difference(n)),
        "as_printed": sign * float(theory.stable_phase_difference(n, as_printed=True)),
        "ours": float(theory.stable_phase_difference(theory.ratios(CASES[case]))),
    }


def phase_of_case_1(session: Session) -> Numbers:
    """Return what explains case 1's phase: the orbit's, and when the run from rest passes it."""
    return {**orbit_of_case_1(session), **duration_of_case_1(session)}


def orbit_of_case_1(session: Session) -> Numbers:
    """Return what explains the orbit of case 1.

    Its phase [rad], and the distance from 3.10 on the circle; its speed [rad/s]; the rod's
    amplitude [rad] by the linear response (16), and that with the printed sign of (11), by which
    rotor 2 drives the rod the other way.
    """
    phase = orbit_quantity(session, REFERENCE, 1, "phase_difference")
    swing = complex(forced_response(CALIBRATED, phase)[1])
    by_rotor_2 = complex(forced_response(CALIBRATED, 0.0)[1]) * np.exp(-1j * phase)  # alone
    return {
        "phase": phase,
        "circle": abs(float(wrapped(phase - 3.10))),
        "speed": orbit_quantity(session, REFERENCE, 1, "mean_speed"),
        "linear": abs(swing),
        "by_print": abs(swing - 2 * by_rotor_2),
    }


def rod_damper_of_case_2(session: Session) -> Numbers:
    """Return what the rod's damper takes in case 2 [W], and what there is with less of it.

    Orbits in words, and without the damper the amplitudes of x [m] and phi_3 [rad].
    """
    orbit = synchronous_orbit(session, CASE_2)
    undamped = CASE_2.replace(rod_damping=0.0)
    free, light = settled(session, [undamped, CASE_2.replace(rod_damping=3.0)])
    amplitudes = synchronous_orbit(session, undamped)
    return {
        "power": np.nan if orbit is None else -orbit.power["rod"],
        "free": free.words,
        "light": light.words,
        "platform": orbit_value(amplitudes, "platform_amplitude"),
        "rod": orbit_value(amplitudes, "rod_amplitude"),
    }


def excess_powers(session: Session, who: str) -> Numbers:
    """Return what (27) sets to zero: the motors' powers less their bearings', over the motors'.

    Of both rotors in cases 1 and 2, and in watts in case 2.
    """
    shares, watts = [], []
    for case in (1, 2):
        orbit = synchronous_orbit(session, ORBITS[case], who)
        power = {} if orbit is None else orbit.power
        for rotor in (1, 2):
            motor = power.get(f"motor_{rotor}", np.nan)
            watts.append(motor + power.get(f"friction_{rotor}", np.nan))
            shares.append(watts[-1] / motor)
    return {"shares": np.abs(shares), "watts": watts[2:]}


def from_theory(session: Session, case: int) -> Numbers:
    """Return the theory's phase [rad], and how far the orbit without f_phi is from it."""
    p = CASES[case]
    alpha = float(theory.stable_phase_difference(theory.ratios(p)))
    (free,) = settled(session, [p.replace(rod_damping=0.0)])
    return {"alpha": alpha, "free": abs(float(wrapped(free.phase - alpha)))}


def gap_to_theory(session: Session, who: str, case: int) -> float:
    """Return how far the phase of an orbit is from the theory's [rad]."""
    alpha = theory.stable_phase_difference(theory.ratios(CASES[case]))
    return float(abs(wrapped(orbit_quantity(session, who, case, "phase_difference") - alpha)))


def coupling_type(session: Session, case: int) -> Numbers:
    """Return both frequency ratios of a case: of its stiffnesses, and as printed."""
    n, printed = theory.ratios(CASES[case]), PRINTED_RATIOS[case]
    return {"ratios": [float(value) for value in (n.n_x, n.n_phi, printed.n_x, printed.n_phi)]}


def coupling_of_case_3(session: Session) -> Numbers:
    """Return the coupling torques of case 3 [N m], and its orbit without the rod's damper."""
    mean, first = (complex(value) for value in coupling_harmonics(CASE_3))
    case_2 = float(theory.coupling_amplitude(CASE_2))
    undamped = CASE_3.replace(platform_damping=0.0, rod_damping=0.0)
    own = float(theory.coupling_amplitude(undamped))
    return {
        "first": abs(first),
        "mean": abs(mean),
        "undamped": own,
        "case_2": case_2,
        "share": own / case_2,
        "free": settled(session, [CASE_3.replace(rod_damping=0.0)])[0].words,
    }


def orbit_of_case_3(session: Session) -> Numbers:
    """Return the kind of the synchronous orbit of case 3, in words too."""
    (orbit,) = settled(session, [CASE_3])
    return {"kind": orbit.kind, "words": orbit.words}


# Runs from rest


def turn_means(run: StartUp, values: Any) -> Array:
    """Return means over turns, about 42 samples each."""
    return by_turns(run, values).mean(axis=1)


def run_up_gap(session: Session, who: str, case: int) -> float:
    """Return the largest difference of the rotors' speeds in their run-up, over working speed."""
    return gap(from_rest(session, case, who))


def last_phase(session: Session, who: str, case: int) -> Numbers:
    """Return the phase [rad] of the last turn from rest, and how far it is from the orbit's."""
    run, orbit = from_rest(session, case, who), synchronous_orbit(session, CASES[case])
    target, end = orbit_value(orbit, "phase_difference"), float(turn_means(run, run.phase)[-1])
    return {
        "end": end,
        "target": target,
        "off": abs(wrapped(end - target)),
        "kind": "antiphase" if np.cos(end) < 0 else "synphase",
        "stable": bool(orbit and orbit.stable),
    }


def change_of_amplitudes(session: Session, who: str, case: int) -> float:
    """Return the largest relative change of the amplitudes of x and phi_3.

    They are taken over three turns each, in the last quarter of the run from rest.
    """
    run = from_rest(session, case, who)
    late = run.states[[0, 3], 3 * len(run.times) // 4 :]
    spans = np.ptp([by_turns(run, values, 3) for values in late], axis=2)
    return float(np.max(np.ptp(spans, axis=1) / np.mean(spans, axis=1)))


def by_turns(run: StartUp, values: Any, turns: int = 1) -> Array:
    """Return values (k, n) over turns, or some at a time, what is left at the end dropped."""
    size = turns * round(PER_SECOND * WAVE / float(operating_speed(run.parameters)))
    whole: Array = values[: len(values) // size * size]
    return whole.reshape(-1, size)


def fluctuations(session: Session, who: str, case: int = 2) -> Numbers:
    """Return half the range of both speeds in the last second [rad/s], and their ratio."""
    run = from_rest(session, case, who)
    first, second = np.ptp(run.states[5:7, run.last], axis=1) / 2
    return {"first": first, "second": second, "ratio": second / first}


def swings(session: Session) -> Numbers:
    """Return half the range of the rod's angle in the last second of cases 1 and 2 [rad]."""
    runs = (from_rest(session, case) for case in (1, 2))
    small, large = (float(np.ptp(run.states[3, run.last]) / 2) for run in runs)
    return {"small": small, "large": large, "swings": large / small}


def fluctuations_of_rotor_2(session: Session, who: str) -> Numbers:
    """Return the fluctuation of rotor 2 in cases 1 and 2 [rad/s], and their ratio."""
    first, second = (fluctuations(session, who, case)["second"] for case in (1, 2))
    return {"first": first, "second": second, "ratio": second / first}


def overshoot(session: Session, who: str) -> Numbers:
    """Return the largest x and phi_3 of case 2 in the first 0.5 s over those at the end."""
    run = from_rest(session, 2, who)
    size = abs(run.states[[0, 3]])
    return {"ratios": size[:, run.times < 0.5].max(axis=1) / size[:, run.last].max(axis=1)}


def slip(session: Session, who: str) -> Numbers:
    """Return how the rotors part in case 3.

    What rotor 1 gains on rotor 2 from 1 s on [rad], and in which time [s]; the range of what
    motor 2 gives more than motor 1, over turns [N m]; how much faster rotor 1 is in the first
    12 turns [rad/s], and how often.
    """
    run = from_rest(session, 3, who)
    gain = float(run.phase[-1] - run.phase[run.after(1.0)][0])
    first, second = (turn_means(run, torque) for torque in run.torques)
    more = (second - first)[8:]
    faster = turn_means(run, run.states[5] - run.states[6])[:12]
    return {
        "gain": gain,
        "size": abs(gain),
        "duration": float(run.times[-1]) - 1,
        "least": more.min(),
        "largest": more.max(),
        "mean": np.mean(faster),
        "first": faster[0],
        "ahead": np.mean(faster > 0),
    }

"""Starts of the rotor_pendulum paper's cases with the motor law (14), and with a motor's curve.

(14) is the tangent at working speed. From rest it gives fifty times the working torque; what a
motor's own curve gives there, the text does not say.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from ....reference.rotor_pendulum.equations import (
    RotorPendulum,
    accelerations,
    coefficients,
    mass_matrix,
    operating_speed,
)
from ....reference.scene import Array
from ..ledger import Numbers, half_unit
from ..session import Session
from .results import CASES, PER_SECOND, SCENE, StartUp, from_rest

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
    """Return whether a line, or a motor's curve, goes through the points of cases 1 and 2.

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

"""Measures of the rotor_pendulum paper's simulations: the three cases of section 5.2."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....reference.rotor_pendulum import theory
from ....reference.rotor_pendulum.cases import CASE_1, CASE_2, CASE_3
from ....reference.rotor_pendulum.equations import operating_speed
from ....reference.rotor_pendulum.phase import coupling_harmonics, forced_response, wrapped
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ..ledger import Numbers
from ..session import Session
from .results import (
    CASES,
    PER_SECOND,
    PRINTED_RATIOS,
    StartUp,
    from_rest,
    orbit_value,
    settled,
    synchronous_orbit,
)

WAVE = 2 * np.pi

# Synchronous orbits


def orbit_quantity(
    session: Session, who: str, case: int, quantity: str, sign: float = 1.0
) -> float:
    """Return a quantity of the synchronous orbit of a case."""
    return sign * orbit_value(synchronous_orbit(session, CASES[case], who), quantity)


def torque_of_slip(session: Session) -> Numbers:
    """Return the torque [N m] at the printed speed of case 1, and the speed of ours [rad/s]."""
    torque = 0.94 * (50 * np.pi - 153.8)
    return {"torque": torque, "speed": orbit_quantity(session, REFERENCE, 1, "mean_speed")}


def lost_sign(session: Session) -> Numbers:
    """Return the phase of case 1 [rad], and its distance from 3.10 on the circle."""
    phase = orbit_quantity(session, REFERENCE, 1, "phase_difference")
    return {"phase": phase, "circle": abs(float(wrapped(phase - 3.10)))}


def power_of_rod_damper(session: Session) -> Numbers:
    """Return what the rod's damper takes in case 2 [W], and orbits with less of it, in words."""
    orbit = synchronous_orbit(session, CASE_2)
    lighter = [CASE_2.replace(rod_damping=damping) for damping in (0.0, 3.0)]
    free, light = settled(session, lighter)
    power = np.nan if orbit is None else -orbit.power["rod"]
    return {"power": power, "free": free.words, "light": light.words}


def amplitudes_without_damper(session: Session) -> Numbers:
    """Return the amplitudes of case 2 without the rod's damper: x [m] and phi_3 [rad]."""
    free = synchronous_orbit(session, CASE_2.replace(rod_damping=0.0))
    return {name: orbit_value(free, f"{name}_amplitude") for name in ("platform", "rod")}


def linear_amplitude(session: Session) -> Numbers:
    """Return the rod's amplitude [rad] in case 1 by the linear response (16)."""
    phase = orbit_quantity(session, REFERENCE, 1, "phase_difference")
    return {"linear": abs(complex(forced_response(CASE_1, phase)[1]))}


def theoretical(session: Session, case: int, sign: float) -> Numbers:
    """Return the paper's theoretical phase [rad] at its own frequency ratios, and at ours."""
    n = PRINTED_RATIOS[case]
    return {
        "value": sign * float(theory.stable_phase_difference(n)),
        "as_printed": sign * float(theory.stable_phase_difference(n, as_printed=True)),
        "ours": float(theory.stable_phase_difference(theory.ratios(CASES[case]))),
    }


def from_theory(session: Session, case: int) -> Numbers:
    """Return the theory's phase [rad], and how far the orbit without f_phi is from it."""
    p = CASES[case]
    alpha = float(theory.stable_phase_difference(theory.ratios(p)))
    free = settled(session, [p.replace(rod_damping=0.0)])[0]
    return {"alpha": alpha, "free": abs(float(wrapped(free.phase - alpha)))}


def gap_to_theory(session: Session, who: str, case: int) -> float:
    """Return how far the phase of an orbit is from the theory's [rad]."""
    alpha = float(theory.stable_phase_difference(theory.ratios(CASES[case])))
    phase = orbit_quantity(session, who, case, "phase_difference")
    return float(abs(wrapped(phase - alpha)))


def coupling_type(session: Session, case: int) -> Numbers:
    """Return both frequency ratios of a case: of its stiffnesses, and as printed."""
    n, printed = theory.ratios(CASES[case]), PRINTED_RATIOS[case]
    return {"ratios": [float(value) for value in (n.n_x, n.n_phi, printed.n_x, printed.n_phi)]}


def coupling_of_case_3(session: Session) -> Numbers:
    """Return the coupling torques of case 3 [N m], and its orbit without the rod's damper."""
    mean, first = (complex(value) for value in coupling_harmonics(CASE_3))
    undamped = CASE_3.replace(platform_damping=0.0, rod_damping=0.0)
    return {
        "first": abs(first),
        "mean": abs(mean),
        "undamped": float(theory.coupling_amplitude(undamped)),
        "free": settled(session, [CASE_3.replace(rod_damping=0.0)])[0].words,
    }


def orbit_of_case_3(session: Session) -> Numbers:
    """Return the kind of the synchronous orbit of case 3, in words too."""
    orbit = settled(session, [CASE_3])[0]
    return {"kind": orbit.kind, "words": orbit.words}


# Runs from rest

RUN_UP = 0.02
"""Time [s] in which the motors speed up: four time constants m r^2 / (k_e + f)."""


def turn_means(run: StartUp, values: Any) -> Array:
    """Return means over turns, about 42 samples each."""
    turn = round(PER_SECOND * WAVE / float(operating_speed(run.parameters)))
    count = len(values) // turn
    means: Array = values[: count * turn].reshape(count, turn).mean(axis=1)
    return means


def run_up_gap(session: Session, who: str, case: int) -> float:
    """Return the largest difference of the rotors' speeds in their run-up, over working speed."""
    run = from_rest(session, case, who)
    gap = np.max(abs(run.states[5] - run.states[6])[run.times <= RUN_UP])
    return float(gap / operating_speed(run.parameters))


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
    parts = run.states[:, 3 * len(run.times) // 4 :]
    turn = 3 * round(PER_SECOND * WAVE / float(operating_speed(run.parameters)))
    count = parts.shape[1] // turn
    spans = np.ptp(parts[[0, 3], : count * turn].reshape(2, count, turn), axis=2)
    return float(np.max(np.ptp(spans, axis=1) / np.mean(spans, axis=1)))


def fluctuations(session: Session, who: str, case: int = 2) -> Numbers:
    """Return half the range of both speeds in the last second [rad/s], and their ratio."""
    run = from_rest(session, case, who)
    first, second = np.ptp(run.states[5:7, run.last], axis=1) / 2
    return {"first": first, "second": second, "ratio": second / first}


def swings(session: Session) -> Numbers:
    """Return half the range of the rod's angle in the last second of cases 1 and 2 [rad]."""
    runs = [from_rest(session, case) for case in (1, 2)]
    small, large = (float(np.ptp(run.states[3, run.last]) / 2) for run in runs)
    return {"small": small, "large": large, "swings": large / small}


def fluctuations_of_rotor_2(session: Session, who: str) -> Numbers:
    """Return the fluctuation of rotor 2 in cases 1 and 2 [rad/s], and their ratio."""
    first, second = (fluctuations(session, who, case)["second"] for case in (1, 2))
    return {"first": first, "second": second, "ratio": second / first}


def overshoot(session: Session, who: str) -> Numbers:
    """Return the largest x and phi_3 of case 2 in the first 0.5 s over those at the end."""
    run = from_rest(session, 2, who)
    moved = abs(run.states[[0, 3]])
    early, late = moved[:, run.times < 0.5], moved[:, run.last]
    return {"ratios": np.max(early, axis=1) / np.max(late, axis=1)}


def time_of_run_up(session: Session) -> Numbers:
    """Return the time [ms] after which a rotor of case 2 is at 90 % of its speed."""
    run = from_rest(session, 2)
    fast = run.times[np.argmax(run.states[5] > 0.9 * float(operating_speed(CASE_2)))]
    return {"milliseconds": 1e3 * fast}


def gain_of_rotor_1(session: Session, who: str) -> Numbers:
    """Return what rotor 1 gains on rotor 2 in case 3 from 1 s on [rad], and in which time [s]."""
    run = from_rest(session, 3, who)
    gain = float(run.phase[-1] - run.phase[run.after(1.0)][0])
    return {"gain": gain, "size": abs(gain), "duration": float(run.times[-1]) - 1}


def torque_gap(session: Session, who: str) -> Numbers:
    """Return the range of what motor 2 gives more than motor 1 in case 3, over turns [N m]."""
    run = from_rest(session, 3, who)
    first, second = (turn_means(run, torque) for torque in run.torques)
    gap = (second - first)[8:]
    return {"least": gap.min(), "largest": gap.max()}


def early_speed_gap(session: Session, who: str) -> Numbers:
    """Return how much faster rotor 1 is in the first 12 turns of case 3 [rad/s], and how often."""
    run = from_rest(session, 3, who)
    gap = turn_means(run, run.states[5] - run.states[6])[:12]
    return {"mean": np.mean(gap), "first": gap[0], "ahead": np.mean(gap > 0)}

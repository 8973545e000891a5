"""Measures of the rotor_pendulum paper's three cases, section 5.2, and of their starts.

(14) is the tangent at working speed. From rest it gives fifty times the working torque; the text
does not give the motor's own curve.
"""

from __future__ import annotations

from itertools import product
from operator import attrgetter

import numpy as np

from ....reference.rotor_pendulum import CASE_1, CASE_2, CASE_3, theory
from ....reference.rotor_pendulum.equations import operating_speed
from ....reference.rotor_pendulum.phase import coupling_harmonics, forced_response, wrapped
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ..ledger import Numbers, half_unit
from ..session import Session
from .derivation import PRINTED_SPEED, RATIOS, motor_slope, spring_inertias
from .results import (
    CASES,
    CURVE_SECONDS,
    LARGEST,
    PER_SECOND,
    PRINTED_RATIOS,
    REDUCED,
    StartUp,
    from_rest,
    kind_of,
    orbit_in_words,
    orbit_value,
    other_start,
    synchronous_orbit,
)

AT_SPEED = 0.9
"""Share of the working speed from which on a rotor no longer speeds up."""

CALIBRATED = CASE_1.replace(motor_slope=0.9391, friction=0.0199)
"""Case 1 with the motor and the friction that its printed speed and torque make, to all digits;
the scene's defaults are these, rounded."""

ORBITS = {**CASES, 1: CALIBRATED}
"""Parameters of the synchronous orbits that are compared with section 5.2's numbers."""

# Starts


def start_by_curve(session: Session, case: int) -> StartUp:
    """Return the start of a case with motors by Kloss's formula."""
    return other_start(session, case, CURVE_SECONDS, LARGEST)


def time_to_speed(run: StartUp) -> float:
    """Return the time [s] at which the slower rotor first reaches its speed."""
    fast = run.states[5:7] > AT_SPEED * float(operating_speed(run.parameters))
    return float(run.times[np.argmax(fast, axis=1).max()])


def speeding_up(run: StartUp) -> Array:
    """Return the states of a run until both rotors are at speed (8, k)."""
    return run.states[:, run.times <= time_to_speed(run)]


def gap(run: StartUp) -> float:
    """Return the largest difference of the speeds until both rotors are at it, over it."""
    early = speeding_up(run)
    return float(np.abs(early[5] - early[6]).max() / operating_speed(run.parameters))


def overshoots(run: StartUp) -> Array:
    """Return the largest x and phi_3 in the first second over those in the last one (2,)."""
    size = np.abs(run.states[[0, 3]])
    return np.asarray(size[:, :PER_SECOND].max(axis=1) / size[:, -PER_SECOND:].max(axis=1))


def starts(session: Session, case: int) -> Numbers:
    """Compare the starts of a case by (14) and by the motors' curve: pairs.

    The largest differences of the speeds, over them; when both rotors are at speed [s]; the rod's
    largest angle until then [rad]. By the curve alone the mean lead of rotor 1 in speed [rad/s],
    and `overshoots`.
    """
    runs = from_rest(session, case), start_by_curve(session, case)
    gaps, early = [gap(run) for run in runs], [speeding_up(run) for run in runs]
    curve = overshoots(runs[1])
    return {
        "gaps": gaps,
        "least": min(gaps),
        "largest": max(gaps),
        "times": [time_to_speed(run) for run in runs],
        "swings": [np.abs(states[3]).max() for states in early],
        "lead": np.mean(early[1][5] - early[1][6]),
        "curve": curve,
        "most": curve.max(),
    }


def starts_of_both_cases(session: Session) -> Numbers:
    """Compare the starts of cases 1 and 2 by both laws: differences of the speeds, swings [rad]."""
    first, second = (starts(session, case) for case in (1, 2))
    ratios = {name: np.divide(second[name], first[name]) for name in ("gaps", "swings")}
    return {"first": first, "second": second, **ratios}


def run_up_gap(session: Session, who: str, case: int) -> float:
    """Return the largest difference of the rotors' speeds in their run-up, over working speed."""
    return gap(from_rest(session, case, who))


def overshoot(session: Session, who: str) -> Numbers:
    """Return the largest x and phi_3 of case 2's start over those at its end."""
    return {"ratios": overshoots(from_rest(session, 2, who))}


def differences(session: Session) -> Numbers:
    """Return the changes of speeds and phase of cases 1 and 2 from rest, and at the end.

    Largest differences of the speeds, over them; ranges of the phase in the first second, on the
    whole and in the last half second [rad], its mean over turns.
    """
    runs = [from_rest(session, case) for case in (1, 2)]
    phases = [run.turn_means(run.phase) for run in runs]
    moves, rests = [np.ptp(phase) for phase in phases], [np.ptp(phase[-12:]) for phase in phases]
    return {
        "gaps": [gap(run) for run in runs],
        "early": [np.ptp(phase[:24]) for phase in phases],
        "moves": moves,
        "rests": rests,
        "slows": np.divide(moves, rests),
    }


PRINTED_POINTS = (("153.8", "3.08"), ("153.5", "3.23"))
"""Speeds [rad/s] and torques [N m] that section 5.2 prints for cases 1 and 2."""


def one_motor(session: Session) -> Numbers:
    """Test if a line, or a motor's curve, passes through the points of cases 1 and 2.

    Ranges of the slope from the speed without load [N m s/rad] that rounding allows, their
    overlap, and the speed without load from which on they overlap [rad/s]; the range of the largest
    torque of such curves [N m].
    """
    speed, signs = float(CASE_1.synchronous_speed), (-1, 0, 1)
    boxes = [
        [
            (1 - (float(rate) + i * half_unit(rate)) / speed, float(torque) + j * half_unit(torque))
            for i, j in product(signs, signs)
        ]
        for rate, torque in PRINTED_POINTS
    ]
    slopes = [[torque / (slip * speed) for slip, torque in box] for box in boxes]
    largest = []
    for (slip_1, torque_1), (slip_2, torque_2) in product(*boxes):
        bend = torque_1 * slip_2 / (slip_1 * torque_2)
        square = (bend - 1) / (slip_2**2 - bend * slip_1**2)  # of 1/s_k
        if square > 0:
            largest.append(torque_1 / slip_1 * (1 + square * slip_1**2) / (2 * np.sqrt(square)))
    (steep, low), (flat, high) = boxes[0][0], boxes[1][-1]
    return {
        "first": [min(slopes[0]), max(slopes[0])],
        "second": [min(slopes[1]), max(slopes[1])],
        "onset": speed * (1 - (high * steep - low * flat) / (high - low)),
        "overlap": min(map(max, slopes)) - max(map(min, slopes)),
        "curves": [min(largest), max(largest)],
    }


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
        "ours": theoretical_phase(case),
    }


def theoretical_phase(case: int) -> float:
    """Return the stable phase of (30), (36) for the stiffnesses of a case [rad]."""
    return float(theory.stable_phase_difference(theory.ratios(CASES[case])))


def orbit_of_case_1(session: Session) -> Numbers:
    """Return numbers that explain case 1's phase and the rod's amplitude.

    The orbit's phase [rad], and its distance from 3.10 on the circle; between which times [s] the
    phase of the run from rest rounds to 3.10 rad; the rod's amplitude [rad] by the linear response
    (16), and that with the printed sign of (11), by which rotor 2 drives the rod the other way.
    """
    phase = orbit_quantity(session, REFERENCE, 1, "phase_difference")
    rod = complex(forced_response(CALIBRATED, phase)[1])
    by_rotor_2 = complex(forced_response(CALIBRATED, 0.0)[1]) * np.exp(-1j * phase)  # alone
    run = from_rest(session, 1)
    size = np.abs(wrapped(run.turn_means(run.phase)))
    there = run.turn_means(run.times)[np.abs(size - 3.10) <= 0.005]
    return {
        "phase": phase,
        "circle": abs(float(wrapped(phase - 3.10))),
        "begin": there.min(initial=np.inf),
        "end": there.max(initial=-np.inf),
        "linear": abs(rod),
        "by_print": abs(rod - 2 * by_rotor_2),
    }


DAMPERS = (15.0, 3.0, 0.3, 0.0)
"""Dampers of the rod [N m s/rad] by which case 2 is computed; the first is printed."""
INERTIAS = (0.45, 0.49)
"""Moments of inertia J_3 of the rod [kg m^2], which (11) leaves out: m_3 l^2/2, and one with which
three numbers of case 2 come out."""


def other_rods(session: Session) -> Numbers:
    """Return case 2 with other `DAMPERS` of the rod, and with `INERTIAS`.

    Orbits by the damper in words. By the inertia [kg m^2] phase [rad], speed [rad/s], torque [N m]
    and amplitudes of platform and rod [m, rad] in the last second of a start, of the last inertia
    by name, too; and the range of the phase of case 3 with it in the last second of its start, and
    without it [rad].
    """
    runs = [other_start(session, 2, 4.0, inertia=own) for own in INERTIAS]
    upright = other_start(session, 3, 8.0, inertia=INERTIAS[-1]), from_rest(session, 3)
    ends = [(*run.ends, *run.half_ranges[[0, 3]]) for run in runs]
    return {
        "orbits": [orbit_in_words(session, CASE_2.replace(rod_damping=f)) for f in DAMPERS],
        "line": float(CASE_2.motor_slope * (CASE_2.synchronous_speed - 153.5)),
        "inertias": INERTIAS,
        "ends": ends,
        "moves": [np.ptp(run.turn_means(run.phase)[[-25, -1]]) for run in upright],
        **dict(zip(("phase", "speed", "torque", "platform", "rod"), ends[-1], strict=True)),
    }


def excess_powers(session: Session, who: str) -> Numbers:
    """Return the powers that (27) sets to zero: the motors' less their bearings', over the motors'.

    Of both rotors in cases 1 and 2; in case 2 in watts, with the power of the rod's damper.
    """
    shares, watts = [], []
    for case, rotor in product((1, 2), (1, 2)):
        orbit = synchronous_orbit(session, ORBITS[case], who)
        power = {} if orbit is None else orbit.power
        motor = power.get(f"motor_{rotor}", np.nan)
        watts.append(motor + power.get(f"friction_{rotor}", np.nan))
        shares.append(abs(watts[-1] / motor))
    return {"shares": shares, "watts": watts[2:], "rod": -power.get("rod", np.nan)}


def gap_to_theory(session: Session, who: str, case: int) -> Numbers:
    """Return the distance of an orbit's phase from the theory's [rad], and the theory's.

    With the rod's damper, and without it (``free``).
    """
    alpha, gaps = theoretical_phase(case), []
    undamped = CASES[case].replace(rod_damping=0.0)
    for p, engine in ((ORBITS[case], who), (undamped, REFERENCE)):
        phase = orbit_value(synchronous_orbit(session, p, engine), "phase_difference")
        gaps.append(float(abs(wrapped(phase - alpha))))
    return {"value": gaps[0], "free": gaps[1], "alpha": alpha}


def coupling_type(session: Session, case: int) -> Numbers:
    """Return both frequency ratios of a case: of its stiffnesses, and as printed."""
    n, printed = theory.ratios(CASES[case]), PRINTED_RATIOS[case]
    return {"ratios": [float(value) for value in (n.n_x, n.n_phi, printed.n_x, printed.n_phi)]}


def coupling_torques(session: Session) -> Numbers:
    """Return the torques by which vibration couples the rotors of each case [N m].

    Constant part and amplitude with the dampers; the amplitude by (34), without them; the largest
    torque (26) on a rotor, and its share of those of section 5.2; case 3's share of case 2's.
    """
    harmonics = [[complex(one) for one in coupling_harmonics(p)] for p in CASES.values()]
    undamped = np.array([float(theory.coupling_amplitude(p)) for p in CASES.values()])
    return {
        "mean": [mean.real for mean, _ in harmonics],
        "amplitude": [abs(first) for _, first in harmonics],
        "undamped": undamped,
        "of_case_3": undamped[2],
        "share": undamped[2] / undamped[1],
        "on_a_rotor": undamped[:2] / 2,
        "of_torque": undamped[:2] / 2 / (3.08, 3.23),
    }


def critical_point(session: Session) -> Numbers:
    """Return the stable root of (30) at beta = pi/2 [rad], and the jump of the phase there.

    And the orbits of case 3 without and with the rod's damper, in words.
    """
    n = PRINTED_RATIOS[3]
    around = theory.stable_phase_difference(n._replace(beta=np.pi / 2 + np.array([-1e-6, 1e-6])))
    return {
        "root": float(theory.stable_phase_difference(n)),
        "jump": float(abs(wrapped(around[1] - around[0]))),
        "free": orbit_in_words(session, CASE_3.replace(rod_damping=0.0)),
        "damped": orbit_in_words(session, CASE_3),
    }


def theory_of_cases(session: Session) -> Numbers:
    """Compare theory and orbits at the three cases.

    The kinds of synchronism by both, the number of cases in which they agree, and the distances
    of the phases of cases 1 and 2 [rad].
    """
    kinds = [kind_of(synchronous_orbit(session, p)) for p in CASES.values()]
    cosines = np.cos([theoretical_phase(case) for case in CASES])
    by_theory = ["synphase" if cosine > 0 else "antiphase" for cosine in cosines]
    return {
        "kinds": kinds,
        "by_theory": by_theory,
        "matches": sum(map(str.__eq__, kinds, by_theory)),
        "apart": [gap_to_theory(session, REFERENCE, case)["value"] for case in (1, 2)],
    }


# Runs from rest


def last_phase(session: Session, who: str, case: int) -> Numbers:
    """Return the phase [rad] of the last turn from rest, and its distance from the orbit's."""
    run, orbit = from_rest(session, case, who), synchronous_orbit(session, CASES[case])
    target, end = orbit_value(orbit, "phase_difference"), float(run.turn_means(run.phase)[-1])
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
    spans = np.ptp([run.by_turns(values, 3) for values in late], axis=2)
    return float(np.max(np.ptp(spans, axis=1) / np.mean(spans, axis=1)))


def fluctuations(session: Session, who: str = REFERENCE) -> Numbers:
    """Return half the range of both speeds at the end of case 2 [rad/s], and their ratio."""
    first, second = from_rest(session, 2, who).half_ranges[5:7]
    return {"first": first, "second": second, "ratio": second / first}


def swing_and_fluctuation(session: Session, who: str) -> Numbers:
    """Return the rod's amplitude [rad] and the fluctuation of rotor 2 [rad/s] in cases 1 and 2."""
    both = [from_rest(session, case, who).half_ranges[[3, 6]] for case in (1, 2)]
    swings, speeds = np.transpose(both)
    ratios = {"swing_ratio": swings[1] / swings[0], "speed_ratio": speeds[1] / speeds[0]}
    return {"swings": swings, "speeds": speeds, **ratios}


def slip(session: Session, who: str) -> Numbers:
    """Return the slip of the rotors in case 3.

    The gain of rotor 1 on rotor 2 from 1 s on [rad], and its duration [s]; the range of the torque
    by which motor 2 exceeds motor 1, over turns [N m]; the lead of rotor 1 in speed in the first
    12 turns [rad/s], and how often it leads.
    """
    run = from_rest(session, 3, who)
    gain = float(run.phase[-1] - run.phase[PER_SECOND])
    more = run.turn_means(run.torques[1] - run.torques[0])[8:]
    faster = run.turn_means(run.states[5] - run.states[6])[:12]
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


def theoretical_sign(session: Session) -> Numbers:
    """Return the residual of (30) at case 1's printed phase, and at its negative, by amplitude."""
    n = PRINTED_RATIOS[1]
    size = abs(float(theory.stability(n, theory.stable_phase_difference(n))))
    printed, right = (abs(float(theory.balance(n, a))) / size for a in (3.013, -3.013))
    return {"as_printed": printed, "corrected": right}


# Readings


def motor_constants(session: Session) -> Numbers:
    """Return case 1's speed and torque with motors and bearings, by each reading of (14).

    The torque at 153.8 rad/s, the speed of a rotor alone, and its torque there.
    """
    several = [CASE_1, CASE_1.replace(friction=0.0)]
    several += [CASE_1.replace(motor_slope=motor_slope(powers)) for powers in (1, 2)]
    slopes, speeds = (
        np.array([float(value(p)) for p in several])
        for value in (attrgetter("motor_slope"), operating_speed)
    )
    free = float(CASE_1.synchronous_speed)
    return {
        "torques": slopes * (free - 153.8),
        "speeds": speeds,
        "alone": slopes * (free - speeds),
        "orbit": orbit_in_words(session, CASE_1),
    }


def stiffness_or_ratio(session: Session, case: int) -> Numbers:
    """Return orbits by the printed stiffnesses, and by the printed ratios with both inertias."""
    p, n = CASES[case], PRINTED_RATIOS[case]
    speed, several = float(p.synchronous_speed), [p]
    for mass, moment in zip(*map(spring_inertias, RATIOS), strict=True):
        springs = mass * (speed / n.n_x) ** 2, moment * (speed / n.n_phi) ** 2
        several.append(p.replace(platform_stiffness=springs[0], rod_stiffness=springs[1]))
    return {"orbits": [orbit_in_words(session, own) for own in several]}


def hundred_kilograms(session: Session) -> Numbers:
    """Return results with 100 kg as the platform's mass, and as all that moves along x.

    The stiffnesses at n_x = 0.1 and 1 [N/m], the speeds that cases 1 and 2 require [rad/s], and
    the platform's amplitude in case 1 [m].
    """
    stiffnesses, speeds, amplitudes = [], [], []
    for platform in (100.0, 86.0):
        several = [p.replace(platform_mass=platform) for p in (CASE_1, CASE_2)]
        mass = spring_inertias("platform")[0] + platform - 100.0
        stiffnesses.append([mass * (PRINTED_SPEED / n) ** 2 for n in (0.1, 1.0)])
        ours = [float(theory.ratios(p, speed=1.0).n_x) for p in several]
        speeds.append([PRINTED_RATIOS[case].n_x / n for case, n in enumerate(ours, start=1)])
        orbit = synchronous_orbit(session, several[0])
        amplitudes.append(orbit_value(orbit, "platform_amplitude"))
    return {"stiffnesses": stiffnesses, "speeds": speeds, "amplitudes": amplitudes}


def both_cases(session: Session, placement: str = "absolute", model: str | None = None) -> str:
    """Return the orbits of cases 1 and 2 in words."""
    one, two = (
        orbit_in_words(session, p.replace(motor_placement=placement), model)
        for p in (CASE_1, CASE_2)
    )
    return f"case 1: {one}; case 2: {two}"


def motor_placement(session: Session) -> Numbers:
    """Return orbits with the second motor on the absolute angle of its rotor, and on the rod."""
    return {name: both_cases(session, name) for name in ("absolute", "relative")}


def equations_of_motion(session: Session) -> Numbers:
    """Return orbits by the exact equations and by (11), and ends of starts with its printed sign.

    Phases [rad], speeds [rad/s] and torques [N m] of cases 2 and 3 by the latter.
    """
    printed = [other_start(session, case, 4.0, as_printed=True).ends for case in (2, 3)]
    reduced = both_cases(session, model=REDUCED)
    return {"exact": both_cases(session), "reduced": reduced, "printed": printed}


def motor_curve(session: Session) -> Numbers:
    """Return starts of all cases by (14), and by motors with largest torques of 8, 12 and 20 N m.

    The largest differences of the speeds, over them, and when both rotors are at speed [s].
    """
    starts = [[from_rest(session, case) for case in CASES]]
    starts += [
        [other_start(session, case, 1.0, torque) for case in CASES] for torque in (8, 12, 20)
    ]
    return {
        "gaps": [[gap(run) for run in runs] for runs in starts],
        "times": [[time_to_speed(run) for run in runs] for runs in starts],
    }


def duration(session: Session) -> Numbers:
    """Return the modulus of the phase of case 1 from rest at 8, 10, ... 16 s [rad]."""
    run = from_rest(session, 1)
    sizes = np.abs(wrapped(run.turn_means(run.phase)))
    return {"phases": np.interp((8, 10, 12, 14, 16), run.turn_means(run.times), sizes)}

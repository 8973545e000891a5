"""What the rotor_pendulum paper leaves open, computed by each way of reading it."""

from __future__ import annotations

from operator import attrgetter

import numpy as np

from ....reference.rotor_pendulum import CASE_1, CASE_2, theory
from ....reference.rotor_pendulum.equations import operating_speed
from ....reference.rotor_pendulum.phase import wrapped
from ..ledger import Numbers
from ..session import Session
from .cases import gap, time_to_speed
from .derivation import PRINTED_SPEED, RATIOS, motor_slope, spring_inertias
from .regions import fold_curve
from .results import (
    BETAS,
    CASES,
    PRINTED_RATIOS,
    REDUCED,
    from_rest,
    orbit_in_words,
    orbit_value,
    other_start,
    synchronous_orbit,
)


def motor_constants(session: Session) -> Numbers:
    """Return case 1's speed and torque with motors and bearings, by each reading of (14).

    The torque at 153.8 rad/s, the speed of a rotor alone, and its torque there.
    """
    several = [
        CASE_1,
        CASE_1.replace(friction=0.0),
        CASE_1.replace(motor_slope=motor_slope(1)),
        CASE_1.replace(motor_slope=motor_slope(2)),
    ]
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
    speed = float(p.synchronous_speed)
    masses, moments = (spring_inertias(spring) for spring in RATIOS)
    by_ratios = [
        p.replace(
            platform_stiffness=mass * (speed / n.n_x) ** 2,
            rod_stiffness=moment * (speed / n.n_phi) ** 2,
        )
        for mass, moment in zip(masses, moments, strict=True)
    ]
    return {"orbits": [orbit_in_words(session, own) for own in (p, *by_ratios)]}


def hundred_kilograms(session: Session) -> Numbers:
    """Return what follows from 100 kg as the platform's mass, and as all that moves along x.

    The stiffnesses at n_x = 0.1 and 1 [N/m], the speeds that cases 1 and 2 ask for [rad/s], and
    the platform's amplitude in case 1 [m].
    """
    stiffnesses, speeds, amplitudes = [], [], []
    for platform in (100.0, 86.0):
        one, two = (p.replace(platform_mass=platform) for p in (CASE_1, CASE_2))
        mass = spring_inertias("platform")[0] + platform - 100.0
        stiffnesses.append([mass * (PRINTED_SPEED / n) ** 2 for n in (0.1, 1.0)])
        speeds.append([
            PRINTED_RATIOS[case].n_x / float(theory.ratios(p, speed=1.0).n_x)
            for case, p in ((1, one), (2, two))
        ])  # fmt: skip
        amplitudes.append(orbit_value(synchronous_orbit(session, one), "platform_amplitude"))
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
    return {
        "exact": both_cases(session),
        "reduced": both_cases(session, model=REDUCED),
        "printed": printed,
    }


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


def limits_of_synphase(session: Session, angle: str) -> Numbers:
    """Return where orbits leave synphase at n_x > 1: by the theory, and with the dampers.

    The n_phi of resonance at n_x = 7 and 2, and that at which the phase passes pi/2, from the sign
    of the cosine; n_x and n_phi of folds.
    """
    n_x, folds = fold_curve(session, angle)
    n_phi, antiphase = np.linspace(0.1, 7, 690_001), []
    for x in (n_x[-1], n_x[0]):
        alpha = theory.stable_phase_difference(theory.Ratios(x, n_phi, beta=BETAS[angle]))
        antiphase.append(n_phi[np.cos(alpha) < 0])
    return {
        "resonance": [own[0] for own in antiphase],
        "turn": antiphase[0][-1],
        "n_x": n_x,
        "folds": folds,
    }


def duration(session: Session) -> Numbers:
    """Return the modulus of the phase of case 1 from rest at 8, 10, ... 16 s [rad]."""
    run = from_rest(session, 1)
    sizes = np.abs(wrapped(run.turn_means(run.phase)))
    return {"phases": np.interp((8, 10, 12, 14, 16), run.turn_means(run.times), sizes)}

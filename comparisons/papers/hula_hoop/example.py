"""Measures of the hula_hoop paper's example, section 5.1: figures 2 and 3, at 3 Hz and 60 N."""

from __future__ import annotations

import numpy as np

from ....reference.hula_hoop.floquet import floquet_multipliers
from ....reference.hula_hoop.theory import paper_solution
from ..ledger import Numbers
from ..session import Session
from .results import (
    APPROXIMATIONS,
    EXAMPLE,
    SAMPLES,
    approximation_errors,
    example_from_rest,
    example_orbit,
    lock_in,
    second_harmonic,
)

OMEGA = 2 * np.pi * float(EXAMPLE.force_frequency)


def printed_solution(session: Session) -> Numbers:
    """Return the amplitudes of the printed solution [mm, rad], and its range of speeds [rad/s]."""
    solution = paper_solution(EXAMPLE)
    u_1 = abs(float(solution.u_1))
    return {
        "paper": 1e3 * abs(float(solution.q_1)) * float(EXAMPLE.rod_length),
        "u_1": u_1,
        "slowest": (1 - 2 * u_1) * OMEGA,
        "fastest": (1 + 2 * u_1) * OMEGA,
        "second": second_harmonic(example_orbit(session)),
    }


def rotation(session: Session, who: str) -> Numbers:
    """Return what the true rotation at 3 Hz and 60 N is like.

    Whether it is stable, and its largest multiplier; the mean slope of theta [rad/s], and how far
    it is from omega, relative to it; the mean of theta - omega t [rad]; the amplitude of y at the
    frequency of the force [mm]. The largest other harmonic of y and of theta over the first and
    the second, and the larger of both.
    """
    report = example_orbit(session, who)
    speed = report.mean_speed or 0.0
    first, *others = (term.amplitude for term in report.harmonics["y"].terms)
    angle = report.harmonics["theta"]
    phase, terms = angle.mean, angle.terms
    rest = max(others) / first
    theta = max(term.amplitude for term in terms if term.order != 2) / second_harmonic(report)
    return {
        "stable": report.stable,
        "multiplier": report.floquet_multipliers[0].modulus,
        "speed": speed,
        "off": abs(speed / OMEGA - 1),
        "mean_phase": float(phase),
        "first": 1e3 * first,
        "rest": rest,
        "theta": theta,
        "other": max(rest, theta),
    }


def motion_from_rest(session: Session, who: str) -> Numbers:
    """Return how the motion from rest locks in, and what its angular velocity does then.

    When it last slips and reverses [s], and how it turns then; the range of |theta'| in the last
    period [rad/s], and its width by omega; the frequency of the largest peak of theta' over the
    last 12 periods, by omega.
    """
    run, periods = example_from_rest(session, who), 12
    theta_dot = run.observables["theta_dot"]
    end = lock_in(run.times, run.observables["theta"], theta_dot)
    last = np.abs(theta_dot[-1 - SAMPLES :])
    window = theta_dot[-periods * SAMPLES :]
    spectrum = np.abs(np.fft.rfft((window - window.mean()) * np.hanning(len(window))))
    ratio = float(np.argmax(spectrum)) / periods
    return {
        "value": end.last_reversal,
        "slip": end.last_slip,
        "turns": abs(end.turns - 1),
        "least": end.least_speed,
        "settled": end.settled,
        "slow": last.min(),
        "fast": last.max(),
        "width": np.ptp(last) / OMEGA,
        "ratio": ratio,
        "off": abs(ratio - 2),
    }


def errors_of_solutions(session: Session) -> Numbers:
    """Return errors of the approximate solutions: y [mm], over its size, theta [rad].

    And how much of that of theta Newton's method leaves.
    """
    size = example_orbit(session).harmonics["y"].terms[0].amplitude
    errors = approximation_errors(session)
    left, left_with_phase = (
        errors[name][1] / errors["paper"][1] for name in ("refined", "corrected")
    )
    return {"left": left, "left_with_phase": left_with_phase} | {
        f"{name}{suffix}": error
        for name, (y, theta, *_) in errors.items()
        for suffix, error in (("", 1e3 * y), ("_share", y / size), ("_theta", theta))
    }


def multipliers(session: Session) -> Numbers:
    """Return the largest multipliers of approximate solutions, and with (55) as printed."""
    solutions = {name: APPROXIMATIONS[name](EXAMPLE) for name in ("paper", "corrected")}
    right = {name: floquet_multipliers(item, EXAMPLE) for name, item in solutions.items()}
    printed = floquet_multipliers(solutions["paper"], EXAMPLE, as_printed=True)
    return {name: abs(item[0]) for name, item in (right | {"printed": printed}).items()}

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


def harmonics_of_y(session: Session, who: str) -> Numbers:
    """Return the amplitude of y at the frequency of the force [mm], and the largest other share."""
    terms = example_orbit(session, who).harmonics["y"][1]
    first, rest = terms[0].amplitude, max(term.amplitude for term in terms[1:])
    return {"first": 1e3 * first, "rest": rest / first}


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


def mean_speed(session: Session, who: str) -> Numbers:
    """Return the mean slope of theta [rad/s], and how far it is from omega, relative to it."""
    speed = example_orbit(session, who).mean_speed or 0.0
    return {"speed": speed, "off": abs(speed / OMEGA - 1)}


def range_of_speed(session: Session, who: str) -> Numbers:
    """Return the range of |theta'| in the last period from rest [rad/s], and its width by omega."""
    last = example_from_rest(session, who).observables["theta_dot"][-1 - SAMPLES :]
    least, most = float(np.abs(last).min()), float(np.abs(last).max())
    return {"least": least, "most": most, "width": (most - least) / OMEGA}


def peak_of_spectrum(session: Session, who: str) -> Numbers:
    """Return the frequency of the largest peak of theta' over the last 12 periods, by omega."""
    periods = 12
    speed = example_from_rest(session, who).observables["theta_dot"][-periods * SAMPLES :]
    spectrum = np.abs(np.fft.rfft((speed - speed.mean()) * np.hanning(len(speed))))
    ratio = float(np.argmax(spectrum)) / periods
    return {"ratio": ratio, "off": abs(ratio - 2)}


def locking(session: Session, who: str) -> Numbers:
    """Return when the motion from rest last slips and reverses [s], and how it turns then."""
    run = example_from_rest(session, who)
    end = lock_in(run.times, run.observables["theta"], run.observables["theta_dot"])
    return {
        "value": end.last_reversal,
        "slip": end.last_slip,
        "turns": abs(end.turns - 1),
        "least": end.least_speed,
        "settled": end.settled,
    }


def errors_of_solutions(session: Session) -> Numbers:
    """Return errors of the approximate solutions: y [mm], over its size, theta [rad]."""
    size = example_orbit(session).harmonics["y"][1][0].amplitude
    return {
        f"{name}{suffix}": error
        for name, (y, theta, *_) in approximation_errors(session).items()
        for suffix, error in (("", 1e3 * y), ("_share", y / size), ("_theta", theta))
    }


def multipliers(session: Session) -> Numbers:
    """Return the largest multipliers of approximate solutions, and with (55) as printed."""
    solutions = {name: APPROXIMATIONS[name](EXAMPLE) for name in ("paper", "corrected")}
    right = {name: floquet_multipliers(item, EXAMPLE) for name, item in solutions.items()}
    printed = floquet_multipliers(solutions["paper"], EXAMPLE, as_printed=True)
    return {name: abs(item[0]) for name, item in (right | {"printed": printed}).items()}

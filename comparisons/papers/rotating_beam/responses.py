"""Measures of the rotating_beam paper's responses, section 3.2: figures 4 and 5."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import legendre

from ....reference.rotating_beam import FIGURE_4, FIGURE_5
from ....reference.rotating_beam.parameters import RotatingBeam, coefficients, drive
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ..ledger import Numbers
from ..session import Session
from .results import LOADS, MASSES, Response, beam_of, free, free_amplitude, response


def by_mass(
    session: Session, who: str, figure: int, measure: Callable[[Response, RotatingBeam], float]
) -> Array:
    """Return a measure of the motions of figure 4 or 5, by mass."""
    return np.array(
        [measure(response(session, figure, who, mass), beam_of(figure, mass)) for mass in MASSES]
    )


def speed_after_ramp(session: Session, who: str) -> float:
    """Return the hub's speed at the end of the ramp [rad/s]."""
    motion = response(session, 4, who, LOADS[0])
    return float(motion.values["theta_dot"][motion.times == FIGURE_4.ramp_time][0])


def pulse(session: Session) -> Numbers:
    """Return by how much the scene's torque misses (23), and its impulses [N m s].

    That of the whole pulse, and of its first half.
    """
    times, weights = legendre.leggauss(32)
    c, (amplitude, end) = coefficients(FIGURE_5), (1.0, 10.0)
    half = end / 4 * (times + 1)
    printed = [amplitude * np.sin(2 * np.pi / end * start) for start in (half, half + end / 2)]
    own = [drive(start, c) for start in (half, half + end / 2)]
    first, second = (float(end / 4 * weights @ torque) for torque in own)
    after = np.max(np.abs(drive(np.array([end, end + 1.0, 2 * end]), c)))
    return {
        "error": max(float(np.max(np.abs(np.subtract(own, printed)))), float(after)),
        "momentum": abs(first + second),
        "most": first,
    }


def against_none(
    session: Session, who: str, figure: int, measure: Callable[[Response, RotatingBeam], float]
) -> Numbers:
    """Return a measure by mass, by how much more it is than without mass, and whether it grows."""
    values = by_mass(session, who, figure, measure)
    return {
        "values": values,
        "more": values[1:] - values[0],
        "changes": np.diff(values),
        "shares": values[1:] / values[0],
        "least": np.min(values[1:] / values[0]),
        "most": np.max(values[1:] / values[0]),
        "percent": 100 * (values[1:] / values[0] - 1),
        "evenly": "evenly" if np.all(np.diff(values) > 0) else "not evenly",
    }


def angle_after_pulse(motion: Response, p: RotatingBeam) -> float:
    """Return the angle of the free end when the pulse ends [rad]."""
    return float(motion.values["tip_angle"][motion.times == p.torque_period][0])


def order_of_angles(session: Session) -> Numbers:
    """Return the time [s] from which on the angle falls with the mass, and how little it is then.

    The latter in percent of the angle after the pulse.
    """
    motions = [response(session, 5, REFERENCE, mass) for mass in MASSES]
    paths, times = np.array([motion.values["tip_angle"] for motion in motions]), motions[0].times
    wrong = np.any(np.diff(paths, axis=0) >= 0, axis=0) & (times <= FIGURE_5.torque_period)
    start = float(times[wrong][-1])
    little = np.max(paths[:, times == start]) / angle_after_pulse(motions[0], FIGURE_5)
    return {"start": start, "little": 100 * little}


def amplitude_ratio(motion: Response, p: RotatingBeam) -> float:
    """Return the amplitude of the second half of the free vibration over that of the first."""
    first, second = np.array_split(np.abs(free(motion, p)), 2)
    return float(np.max(second)) / float(np.max(first))


def decay(session: Session, who: str) -> Numbers:
    """Return that ratio after the pulse by mass, how far it is from 1, and amplitudes [m]."""
    ratios = by_mass(session, who, 5, amplitude_ratio)
    amplitudes = by_mass(session, who, 5, free_amplitude)
    return {"ratios": ratios, "off": np.abs(ratios - 1), "amplitudes": amplitudes}


def energy_drift(session: Session) -> Numbers:
    """Return the largest change of the energy after the pulse, over its largest value."""

    def drift(motion: Response, p: RotatingBeam) -> float:
        energy = motion.values["energy"]
        return float(np.ptp(energy[motion.times >= p.torque_period]) / np.max(energy))

    return {"drift": np.max(by_mass(session, REFERENCE, 5, drift))}

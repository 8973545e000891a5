"""Measures of the rotating_beam paper's responses, section 3.2: figures 4 and 5."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.linalg import eigh

from ....reference.linear import linearise
from ....reference.rotating_beam import FIGURE_4, FIGURE_5, SCENE, beam_scene, critical_speed
from ....reference.rotating_beam.frequencies.assumed_modes import best_mass_position, crossover
from ....reference.rotating_beam.frequencies.numbers import numbers
from ....reference.rotating_beam.parameters import RotatingBeam, coefficients, drive
from ....reference.rotating_beam.shapes import cantilever_modes
from ....reference.scene import Array, Scene
from ....reference.solve.single import states_at
from ...engines.registry import REFERENCE
from ..equations import Values
from ..ledger import Numbers
from ..session import Session
from .results import (
    BEAM,
    LOADS,
    MASSES,
    SAMPLES,
    Response,
    beam_of,
    crossed,
    free,
    free_amplitude,
    peak,
    response,
    with_angle,
)

Measure = Callable[[Response, RotatingBeam], float]


def driven(values: Values) -> Values:
    """Return the scene's drives (22), as an acceleration, and (23) at a time share T/2, and 2 T."""
    end, at = values["T"], np.array([values["share"] / 2, 2.0]) * values["T"]
    ramp = FIGURE_4.replace(angular_speed=values.get("omega_0", 1.0), ramp_time=end)
    pulse = FIGURE_5.replace(torque_amplitude=values.get("tau_0", 1.0), torque_period=end)
    accelerations, torques = (drive(at, coefficients(p)) for p in (ramp, pulse))
    return {
        "acceleration": float(accelerations[0]),
        "torque": float(torques[0]),
        "after": float(np.max(np.abs([accelerations[1], torques[1]]))),
    }


def by_mass(session: Session, who: str, figure: int, of: Measure) -> Array:
    """Return a measure of the motions of figure 4 or 5, by mass."""
    return np.array(
        [of(response(session, figure, who, mass), beam_of(figure, mass)) for mass in MASSES]
    )


def against_none(session: Session, who: str, figure: int, of: Measure) -> Numbers:
    """Return a measure by mass, its ratios to that without mass, and whether it grows evenly."""
    values = by_mass(session, who, figure, of)
    shares = values[1:] / values[0]
    return {
        "values": values,
        "changes": np.diff(values),
        "shares": shares,
        "least": np.min(shares),
        "most": np.max(shares),
        "percent": 100 * (shares - 1),
        "evenly": "evenly" if np.all(np.diff(values) > 0) else "not evenly",
    }


def angle_after_pulse(motion: Response, p: RotatingBeam) -> float:
    """Return the angle of the free end when the pulse ends [rad]."""
    return float(motion.values["tip_angle"][motion.times == p.torque_period][0])


def hub_after_pulse(motion: Response, p: RotatingBeam) -> float:
    """Return the angle of the hub when the pulse ends [rad]."""
    return float(motion.values["theta"][motion.times == p.torque_period][0])


def order_of_angles(session: Session) -> Numbers:
    """Return the time [s] from which on the angle falls with the mass, and its size then.

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


def energy_change(motion: Response, p: RotatingBeam) -> float:
    """Return the largest change of the energy after the pulse, over its largest value."""
    energy = motion.values["energy"]
    return float(np.ptp(energy[motion.times >= p.torque_period]) / np.max(energy))


def energy_drift(session: Session) -> Numbers:
    """Return that change, the largest of all masses."""
    return {"drift": np.max(by_mass(session, REFERENCE, 5, energy_change))}


# The pulse, linear about rest


def linear_pulse(p: RotatingBeam, times: Array, scene: Scene = SCENE) -> Response:
    """Return the motion under the pulse (23), linear about rest: mode by mode, in closed form."""
    size = len(scene.coordinates)
    mass, _, stiffness = linearise(scene, p.replace(drive="torque"), np.zeros(2 * size))
    squares, shapes = eigh(stiffness, mass)
    end, w = p.torque_period, 2 * np.pi / p.torque_period
    during, after = np.minimum(times, end), np.maximum(times - end, 0.0)
    q, v = np.zeros((2, size, len(times)))
    for square, shape in zip(squares, shapes.T, strict=True):
        omega = np.sqrt(max(square, 0.0))
        if omega < 1e-3 * w:  # the hub turns freely
            at = during / w - np.sin(w * during) / w**2
            rate = (1 - np.cos(w * during)) / w
        else:
            gain = 1 / (omega**2 - w**2)
            at = gain * (np.sin(w * during) - w / omega * np.sin(omega * during))
            rate = gain * w * (np.cos(w * during) - np.cos(omega * during))
        cos, sin, lag = np.cos(omega * after), np.sin(omega * after), np.sinc(omega / np.pi * after)
        push = shape[0] * p.torque_amplitude
        q += push * np.outer(shape, at * cos + rate * after * lag)
        v += push * np.outer(shape, rate * cos - omega * at * sin)
    return Response(times, with_angle(scene.observe(np.concatenate([q, v]), p), p))


def pulses(
    session: Session, hub_inertias: Sequence[float] = (10.0,), hub_radii: Sequence[float] = (0.0,)
) -> Numbers:
    """Return the results of figure 5 for several hubs, by hub and mass, linear about rest.

    The hub's angle after the pulse [rad], the largest deflection [m], its increase over that
    without mass [percent], and the largest deflection after the pulse [m].
    """
    times = np.linspace(0.0, 20.0, 641)
    angle, largest, left = np.zeros((3, len(hub_inertias) * len(hub_radii), len(MASSES)))
    hubs = [(inertia, radius) for inertia in hub_inertias for radius in hub_radii]
    for i, (inertia, radius) in enumerate(hubs):
        for j, mass in enumerate(MASSES):
            p = FIGURE_5.replace(hub_inertia=inertia, hub_radius=radius, mass=mass)
            motion = linear_pulse(p, times)
            angle[i, j], largest[i, j] = hub_after_pulse(motion, p), peak(motion, p)
            left[i, j] = free_amplitude(motion, p)
    growth = 100 * (largest[:, 1:] / largest[:, :1] - 1)
    most = np.max(growth, axis=1)
    return {
        "angle": angle,
        "largest": largest,
        "left": left,
        "growth": growth,
        "least_most": np.min(most),
        "most_most": np.max(most),
    }


# Readings


def peaks_by_mass(session: Session) -> Numbers:
    """Return the largest deflections [m] of figures 4 and 5, by mass."""
    return {f"figure_{figure}": by_mass(session, REFERENCE, figure, peak) for figure in (4, 5)}


def angles_by_mass(session: Session) -> Numbers:
    """Return the angles [rad] of the hub and of the free end after the pulse, by mass."""
    hub, free_end = (
        by_mass(session, REFERENCE, 5, of) for of in (hub_after_pulse, angle_after_pulse)
    )
    return {"hub": hub, "free_end": free_end}


def models_of_figure_4(session: Session) -> Numbers:
    """Return the largest deflections [m] of figure 4 with the least and the largest load.

    By the exact equations, and by (14) to (16) corrected, converged and with two modes; by how
    many percent the converged ones overshoot; the speed [rad/s] above which the beam diverges
    without the second-order coupling.
    """
    times, loads = np.arange(8 * SAMPLES + 1) / SAMPLES, (LOADS[0], LOADS[-1])
    scenes = {
        "exact": SCENE,
        "converged": beam_scene("second_order", 8, 0),
        "two_modes": beam_scene("second_order", 2, 1, cantilever_modes),
    }
    peaks: dict[str, list[float]] = {}
    for name, scene in scenes.items():
        for p in (beam_of(4, mass) for mass in loads):
            values = scene.observe(states_at(scene, p, scene.state({}), times), p)
            peaks.setdefault(name, []).append(peak(Response(times, values), p))
    over = 100 * (np.array(peaks["converged"]) / peaks["exact"] - 1)
    return {**peaks, "over": over, "critical": critical_speed(beam_of(4, loads[0]))}


def damped_shares(session: Session, ratios: Sequence[float]) -> Numbers:
    """Return the shares of the amplitude that damping ratios leave in 10 s, with 0.4 kg.

    And the frequency of the first mode with a free hub [rad/s].
    """
    p = FIGURE_5.replace(mass=LOADS[0])
    mass, _, stiffness = linearise(SCENE, p, np.zeros(2 * len(SCENE.coordinates)))
    omega = float(np.sqrt(eigh(stiffness, mass, eigvals_only=True)[1]))
    return {"omega": omega, "shares": np.exp(-np.array(ratios) * omega * 10)}


def hub_radii(session: Session, radii: Sequence[float]) -> Numbers:
    """Return `pulses` by hub radius [m], and the place where 0.4 kg cross the beam without mass.

    In words, of two modes and converged, with the best places; without a crossing there are none.
    """
    words: dict[str, list[str]] = {"two": [], "two_best": [], "converged": [], "best": []}
    for radius in radii:
        n = [numbers(BEAM.replace(hub_radius=radius, mass=mass)) for mass in LOADS]
        for name, own, modes in (("two", "two_best", 2), ("converged", "best", None)):
            place = crossover(n[0], modes=modes)
            words[name].append(crossed(place))
            best = [best_mass_position(one, modes) for one in n] if np.isfinite(place) else []
            words[own].append(", ".join(f"{one:.3g}" for one in best) or "none")
    return {**words, **pulses(session, hub_radii=radii)}

"""Frequencies, and the runs of figures 4 and 5, that the rows and figures of the paper share.

The paper names neither the speed of figures 2 and 3 nor the masses of figures 4 and 5; the
masses here are those of its section 3.1 and none.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from ....reference.errors import EngineError
from ....reference.rotating_beam import FIGURE_4, FIGURE_5, SCENE, run_quantities
from ....reference.rotating_beam.frequencies.assumed_modes import best_mass_position, matching_speed
from ....reference.rotating_beam.frequencies.numbers import Numbers, numbers, time_unit
from ....reference.rotating_beam.parameters import RotatingBeam, drive_end_time
from ....reference.scene import Array
from ....reference.solve.single import states_at
from ...engines.registry import REFERENCE
from ...maps.execute import on_this_machine
from ...maps.store import Map
from ...queries.simulate import simulate
from ..session import Session, once

MASSES = (0.0, 0.4, 0.8, 1.2)
"""Masses [kg]: none, and those of section 3.1."""

SPEED = 7.0
"""Speed of figure 3 [rad/s], at which two assumed modes have the printed maximum for 0.8 kg."""

FASTEST = 12.0
"""Dimensionless speed up to which figure 2 goes."""

HUB_RADIUS = 8.0
"""Radius of the hub in section 3.1 [m]."""

BEAM = RotatingBeam(hub_radius=HUB_RADIUS, angular_speed=SPEED, ramp_time=0.0)
"""Beam of figures 2 and 3."""

PRINTED_MAXIMA = {0.4: 0.442, 0.8: 0.429, 1.2: 0.42}

RODS, SPIN_UP_RODS, MANY_RODS = 16, 24, 32
"""Segments of the engines' models, those of figure 4, and those with ``--full``."""


def segments(session: Session) -> int:
    """Return the number of an engine's rods or elements."""
    return MANY_RODS if session.full else RODS


def frequencies(session: Session, x: Any, y: Any, engine: str, **more: Any) -> Map:
    """Return a map of frequencies of the beam of figures 2 and 3; ``more`` are parameters."""
    model = more.pop("model", None)
    parameters = {"hub_radius": HUB_RADIUS, **more, "segments": float(segments(session))}
    return session.map(
        SCENE.name, "frequency", x, y, engine=engine, model=model, parameters=parameters
    )


def by_speed(session: Session, engine: str = REFERENCE) -> Map:
    """Return frequencies over speed (columns) and mass at the tip (rows, `MASSES`)."""
    x = ("nondimensional_speed", 0.0, FASTEST, 49 if session.full else 25)
    return frequencies(session, x, ("mass", MASSES[0], MASSES[-1], len(MASSES)), engine)


def by_ratio(session: Session, engine: str = REFERENCE) -> Map:
    """Return frequencies over mass ratio at the tip (columns) and speed (rows)."""
    x = ("mass_ratio", 0.0, 2.0, 41 if session.full else 17)
    return frequencies(session, x, ("nondimensional_speed", 0.0, FASTEST, 4), engine)


def by_place(session: Session, engine: str = REFERENCE, model: str | None = None) -> Map:
    """Return frequencies over the mass's place (columns) and mass (rows), at `SPEED`.

    Places are ends of rods: there alone a chain converges with order 2.
    """
    places = (4 if engine == REFERENCE else 1) * segments(session)
    x = ("mass_position", 1 / places, 1.0, places)
    y = ("mass", MASSES[0], MASSES[-1], len(MASSES))
    return frequencies(session, x, y, engine, model=model, angular_speed=SPEED)


def maximum(place: Array, frequency: Array) -> float:
    """Return where a smooth curve through points inside (0, 1] is largest."""
    spline = CubicSpline(place, frequency)
    at = np.append(spline.derivative().roots(extrapolate=False), place[[0, -1]])
    return float(at[np.argmax(spline(at))])


# Runs ---------------------------------------------------------------------------------------


class Job(NamedTuple):
    """One motion of figure 4 or 5."""

    figure: int
    mass: float
    who: str
    horizon: float
    segments: int


class Response(NamedTuple):
    """Times [s], 0 included, and what was observed."""

    times: Array
    values: Mapping[str, Array]


CASES = {4: FIGURE_4, 5: FIGURE_5}
HORIZONS = {4: 20.0, 5: 16.0}
"""Durations of the runs [s]; the text names none."""

SAMPLES = 16
"""Samples of a run per second."""


def beam_of(figure: int, mass: float) -> RotatingBeam:
    """Return the beam of figure 4 or 5."""
    return CASES[figure].replace(mass=mass)


def simulated(job: Job) -> Response | str:
    """Return a motion, or why the engine has none."""
    times = np.arange(round(job.horizon * SAMPLES) + 1) / SAMPLES
    p = beam_of(job.figure, job.mass).replace(segments=job.segments)
    if job.who == REFERENCE:
        states = states_at(SCENE, p, SCENE.state({}), times)
        energy = SCENE.energy(*np.split(states, 2), SCENE.coefficients(p))
        return Response(times, with_angle({**SCENE.observe(states, p), "energy": energy}, p))
    try:
        motion = simulate(SCENE.name, engine=job.who, parameters=p.as_dict(), times=times)
    except EngineError as error:
        return f"failed: {error}"
    return Response(times, with_angle(motion.observables, p))


def with_angle(values: Mapping[str, Array], p: RotatingBeam) -> Mapping[str, Array]:
    """Return observables with the angle of the free end about the hub's axis [rad]."""
    along = p.hub_radius + p.length + values["tip_axial"]
    return {**values, "tip_angle": values["theta"] + np.arctan2(values["tip_deflection"], along)}


@once
def runs(session: Session, figure: int, who: str) -> dict[float, Response | str]:
    """Return the motions of figure 4 or 5 by the reference or an engine, by mass."""
    count = max(segments(session), SPIN_UP_RODS if figure == 4 else 0)
    horizon = HORIZONS[figure] * (2 if session.full else 1)
    jobs = [Job(figure, mass, who, horizon, count) for mass in MASSES]
    motions = {}
    for done, (i, motion) in enumerate(on_this_machine(session.workers)(simulated, jobs), start=1):
        motions[jobs[i].mass] = motion
        session.progress(f"{SCENE.name} figure {figure} {who}", done, len(jobs))
    return motions


def response(session: Session, figure: int, who: str, mass: float) -> Response:
    """Return one motion.

    Raises
    ------
    EngineError
        If the engine has none.
    """
    motion = runs(session, figure, who)[mass]
    if isinstance(motion, str):
        raise EngineError("failed", motion)
    return motion


# Measures -----------------------------------------------------------------------------------

LOADS = MASSES[1:]
UNIT = time_unit(BEAM)
FIRST_VARIABLE = "nondimensional_1"


def loaded(mass: float, speed: float = SPEED) -> Numbers:
    """Return the beam of figure 3 with a mass, at a speed [rad/s]."""
    return numbers(BEAM.replace(mass=mass, angular_speed=speed))


def curves_of_figure_3(session: Session, engine: str) -> tuple[Array, Array]:
    """Return places (k,) and first frequencies (masses, k)."""
    curves = by_place(session, engine)
    if curves.problems:
        raise EngineError("failed", curves.problems[0][2])
    return curves.x.values, curves.variables[FIRST_VARIABLE]


@once
def furthest(session: Session, mass: float) -> tuple[float, float]:
    """Return the converged maximum that lies farthest out, and its speed [rad/s]."""
    best = minimize_scalar(
        lambda w: -best_mass_position(loaded(mass, w)), bounds=(4, 15), options={"xatol": 0.2}
    )
    return -float(best.fun), float(best.x)


@once
def matched(session: Session, mass: float) -> float:
    """Return the speed [rad/s] at which two assumed modes have the printed maximum."""
    return matching_speed(loaded(mass), PRINTED_MAXIMA[mass], 2) / UNIT


def crossed(place: float) -> str:
    """Return the place where a mass has no effect, or ``nowhere``."""
    return f"{place:.3f}" if np.isfinite(place) else "nowhere"


def peak(motion: Response, p: RotatingBeam) -> float:
    """Return the largest deflection [m], whatever its sign."""
    return abs(run_quantities(motion.times, motion.values, p)["tip_peak"][0])


def top_speed(motion: Response, p: RotatingBeam) -> float:
    """Return the largest velocity of the tip in the hub frame [m/s]."""
    return float(np.max(np.abs(motion.values["tip_deflection_dot"])))


def free(motion: Response, p: RotatingBeam) -> Array:
    """Return the deflections [m] once nothing drives the hub."""
    return motion.values["tip_deflection"][motion.times >= drive_end_time(p)]


def free_amplitude(motion: Response, p: RotatingBeam) -> float:
    """Return the largest deflection [m] once nothing drives the hub, whatever its sign."""
    return float(np.max(np.abs(free(motion, p))))

"""Orbits, runs and maps that the figures and the ledger of the hula_hoop paper share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import label as connected

from ....reference.hula_hoop.equations import SEMICIRCLE, HulaHoop
from ....reference.hula_hoop.floquet import floquet_multipliers
from ....reference.hula_hoop.theory import corrected_solution, paper_solution, refined_solution
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ...maps.request import Axis
from ...maps.store import Map
from ...queries.orbit import OrbitReport, find
from ...queries.request import MethodQuery
from ...queries.simulate import Simulation, simulate
from ..session import Session, once

SCENE = "hula_hoop"
EXAMPLE = HulaHoop()
"""Parameters of section 5.1: 3 Hz, 60 N, point mass."""

NATURAL = float(EXAMPLE.omega_n) / (2 * np.pi)
"""Natural frequency of the main mass [Hz]."""

HERTZ, NEWTON = (1.0, 10.0), (5.0, 150.0)
"""Axes of figs. 4-7; the text does not give them."""
POINTS, ENGINE_POINTS, FULL_POINTS = 31, 11, 64
"""Points along an axis of the reference's maps, of the engines' (every third), and with --full."""

SAMPLES = 64
"""Samples of a motion in a period of the force."""
LOCKED = 0.03
"""Largest distance of turns per period from 1 while the phase still oscillates."""
LONG_RUN = 12.0
"""Duration of runs from rest [s]: eight times the transient of fig. 3."""

APPROXIMATIONS = {
    "paper": paper_solution,
    "refined": refined_solution,
    "corrected": corrected_solution,
}
STATES = ("y", "theta", "y_dot", "theta_dot")


def samples(seconds: float) -> Array:
    """Return sample times from 0 [s], whole fractions of the example's period."""
    rate = SAMPLES * EXAMPLE.force_frequency
    return np.arange(round(seconds * rate) + 1) / rate


# The example of section 5.1


@once
def example_orbit(session: Session, engine: str = REFERENCE) -> OrbitReport:
    """Return the true rotation."""
    return find(MethodQuery(SCENE, engine=engine), bounded=False)


@once
def example_from_rest(session: Session, engine: str = REFERENCE) -> Simulation:
    """Return the motion from rest."""
    return simulate(SCENE, engine=engine, times=samples(LONG_RUN))


@once
def example_rotation(session: Session, engine: str = REFERENCE) -> Simulation:
    """Return three periods of the true rotation."""
    state = dict(example_orbit(session, engine).state)
    return simulate(SCENE, engine=engine, state=state, times=samples(1.0))


def second_harmonic(report: OrbitReport) -> float:
    """Return the amplitude u_1 of theta at twice the frequency of the force [rad]."""
    return next(term.amplitude for term in report.harmonics["theta"].terms if term.order == 2)


def approximate_states(name: str) -> Array:
    """Return the states (4, n_t) of an approximate solution over three periods."""
    return APPROXIMATIONS[name](EXAMPLE).state(samples(1.0), EXAMPLE)


def states(run: Simulation) -> Array:
    """Return the states (4, n_t) of a run."""
    return np.array([run.observables[name] for name in STATES])


def apart(own: Array, truth: Array) -> Array:
    """Return |difference| of states (4, n_t), angles on the circle."""
    gap = own - truth
    gap[1] = (gap[1] + np.pi) % (2 * np.pi) - np.pi
    return np.abs(gap)


def approximation_errors(session: Session) -> dict[str, Array]:
    """Return the largest errors (4,) of the approximate solutions against the true rotation."""
    truth = states(example_rotation(session))
    return {name: apart(approximate_states(name), truth).max(axis=1) for name in APPROXIMATIONS}


def value_range(times: Array, values: Array) -> tuple[float, float]:
    """Return the smallest and the largest value of samples (n_t,), between them by splines."""
    spline = CubicSpline(times, values)
    every = np.concatenate([values, spline(spline.derivative().roots(extrapolate=False))])
    return float(every.min()), float(every.max())


@dataclass(frozen=True)
class LockIn:
    """How a motion from rest at 3 Hz, 60 N becomes a rotation.

    Attributes
    ----------
    last_slip : float
        Time until which the phase is more than half a turn from its final value [s].
    last_reversal : float
        Time at which the free mass last turns backwards [s].
    settled : float
        Time from which the phase stays within 0.5 rad of its final value [s].
    turns : float
        Turns per period, over the last eight.
    direction : int
    least_speed : float
        Smallest speed of the last period over omega, in the sense of rotation.
    """

    last_slip: float
    last_reversal: float
    settled: float
    turns: float
    direction: int
    least_speed: float


def lock_in(times: Array, theta: Array, speed: Array) -> LockIn:
    """Return the lock-in of a motion (n_t,) from rest."""
    omega = 2 * np.pi * EXAMPLE.force_frequency
    turns = (theta[-1] - theta[-1 - 8 * SAMPLES]) / (2 * np.pi * 8)
    direction = 1 if turns > 0 else -1
    stroboscopic = times[::SAMPLES]
    phase = (direction * theta - omega * times)[::SAMPLES]
    off = np.abs(phase - phase[-9:].mean())
    last = slice(-1 - SAMPLES, None)
    return LockIn(
        last_slip=float(np.max(stroboscopic[off > np.pi], initial=0.0)),
        last_reversal=float(np.max(times[direction * speed < 0], initial=0.0)),
        settled=float(np.max(stroboscopic[off > 0.5], initial=0.0)),
        turns=abs(turns),
        direction=direction,
        least_speed=value_range(times[last], direction * speed[last])[0] / omega,
    )


# Maps

PLATES = (False, True)
"""Without and with the plate's inertia: figures 4, 5 and figures 6, 7."""

AxisSpan = tuple[str, float, float, int]


def axes(session: Session, engine: str = REFERENCE) -> tuple[AxisSpan, AxisSpan]:
    """Return the axes of figs. 4-7."""
    count = POINTS if engine == REFERENCE else session.engine_points or ENGINE_POINTS
    count = session.points or (FULL_POINTS if session.full else count)
    return ("force_frequency", *HERTZ, count), ("force_amplitude", *NEWTON, count)


def changed(plate: bool) -> dict[str, float]:
    """Return the parameters of the free mass: a point, or the semicircular plate."""
    return {"inertia_ratio": SEMICIRCLE} if plate else {}


def stability_map(
    session: Session, plate: bool, engine: str = REFERENCE, model: str | None = None
) -> Map:
    """Return the stability of the rotation of figs. 4 (point mass) and 6 (plate)."""
    return _map(session, "floquet", plate, engine, model)


def motion_map(session: Session, plate: bool, engine: str = REFERENCE) -> Map:
    """Return the motion from rest of figs. 5 (point mass) and 7 (plate)."""
    return _map(session, "class", plate, engine, None)


def _map(session: Session, quantity: str, plate: bool, engine: str, model: str | None) -> Map:
    return session.map(
        SCENE,
        quantity,
        *axes(session, engine),
        engine=engine,
        model=model,
        parameters=changed(plate),
        refine=engine != REFERENCE and not session.full,
    )


def grid(session: Session, plate: bool) -> HulaHoop:
    """Return the parameters of all points (n_y, n_x) of figs. 4-7."""
    x, y = (np.linspace(*axis[1:]) for axis in axes(session))
    return HulaHoop(
        force_frequency=x[None, :],  # type: ignore[arg-type]
        force_amplitude=y[:, None],  # type: ignore[arg-type]
        **changed(plate),
    )


def is_class(plane: Map, variable: str, name: str) -> Any:
    """Return where (n_y, n_x) a variable of a map is this class."""
    return plane.variables[variable] == plane.about[variable].classes.index(name)


def moves(session: Session, plate: bool, name: str, engine: str = REFERENCE) -> Any:
    """Return where (n_y, n_x) the motion from rest is of this class."""
    return is_class(motion_map(session, plate, engine), "motion", name)


@once
def printed_multipliers(session: Session, plate: bool) -> Array:
    """Return the largest moduli (n_y, n_x) of multipliers by (55) as printed."""
    p = grid(session, plate)
    return np.abs(floquet_multipliers(paper_solution(p), p, as_printed=True)[0])


def stable(session: Session, plate: bool, which: str) -> Any:
    """Return where (n_y, n_x) a rotation is stable: "printed", or a model of the map."""
    if which == "printed":
        return printed_multipliers(session, plate) < 1
    return is_class(stability_map(session, plate, model=which), "stability", "stable")


def on_grid(session: Session, plane: Map, where: Any) -> Any:
    """Return values at the reference's points (n_y, n_x), taken at those of another map."""
    x, y = (Axis(*axis) for axis in axes(session))
    return where[np.ix_(y.nearest(plane.y.values), x.nearest(plane.x.values))]


STABILITIES = {
    "printed": "paper's solution, (55) as printed",
    "paper": "paper's solution, (55) corrected",
    "corrected": "with its phase, (55) corrected",
    "exact": "true rotation",
}


def regions(unstable: Any, least: int = 2) -> list[Any]:
    """Return the connected regions (n_y, n_x) of at least so many points, largest first."""
    labels, count = connected(unstable, np.ones((3, 3)))
    parts = sorted((labels == i for i in range(1, count + 1)), key=np.sum, reverse=True)
    return [part for part in parts if part.sum() >= least]


def agreement(session: Session, plate: bool, which: str) -> dict[str, float]:
    """Compare fig. 4 with fig. 5, or fig. 6 with fig. 7 (plate), on the robust points.

    ``share`` of the points at which "stable" and "class blue o" are both true or both false;
    ``trivial``, that which the better of "everywhere" and "nowhere" would reach; ``points``.
    """
    robust = motion_map(session, plate).robust
    hoop = moves(session, plate, "blue_o")[robust]
    return {
        "share": float(np.mean(hoop == stable(session, plate, which)[robust])),
        "trivial": float(max(hoop.mean(), 1 - hoop.mean())),
        "points": int(robust.sum()),
    }


def own_maps(session: Session, plate: bool, engine: str) -> tuple[Any, Any, Any]:
    """Return an engine's stability of its rotation, and its motion from rest.

    Three bool arrays (k,) over the points that it computed in both maps, its motion robust:
    the rotation is stable, hula-hoop motion from rest, and this repeats in each period.
    """
    calm, motion = stability_map(session, plate, engine), motion_map(session, plate, engine)
    known = (calm.computed == 1) & (motion.computed == 1) & motion.robust
    hoop = is_class(motion, "motion", "blue_o")
    first = hoop & (motion.variables["periods"] == 1)
    return is_class(calm, "stability", "stable")[known], hoop[known], first[known]

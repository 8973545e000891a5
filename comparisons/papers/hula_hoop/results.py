"""What the figures and the ledger of the hula_hoop paper are made of: orbits, runs, maps."""

from __future__ import annotations

from collections.abc import Mapping
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
from ..session import Session

SCENE = "hula_hoop"
EXAMPLE = HulaHoop()
"""Section 5.1: 3 Hz, 60 N, point mass."""

NATURAL = float(EXAMPLE.omega_n) / (2 * np.pi)
"""Of the main mass [Hz]."""

HERTZ, NEWTON = (1.0, 10.0), (5.0, 150.0)
"""Axes of figs. 4-7; the text does not give them."""
POINTS, ENGINE_POINTS, FULL_POINTS = 31, 11, 64
"""Of a map, along an axis: by the reference, by an engine (every third of these), by all."""

SAMPLES = 64
"""Of a motion, in a period of the force."""
LOCKED = 0.03
"""How far turns per period may be from 1 while the phase still oscillates."""
LONG_RUN = 12.0
"""From rest [s]: eight times what fig. 3 calls the transient."""

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


def example_orbit(session: Session, engine: str = REFERENCE) -> OrbitReport:
    """Return the true rotation."""
    query = MethodQuery(SCENE, engine=engine)
    return session.once((SCENE, "orbit", engine), lambda: find(query, bounded=False))


def example_from_rest(session: Session, engine: str = REFERENCE) -> Simulation:
    """Return the motion from rest."""
    return session.once(
        (SCENE, "rest", engine), lambda: simulate(SCENE, engine=engine, times=samples(LONG_RUN))
    )


def example_rotation(session: Session, engine: str = REFERENCE) -> Simulation:
    """Return three periods of the true rotation."""
    state = dict(example_orbit(session, engine).state)
    return session.once(
        (SCENE, "rotation", engine),
        lambda: simulate(SCENE, engine=engine, state=state, times=samples(1.0)),
    )


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


def extremes(times: Array, values: Array) -> tuple[float, float]:
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
        Until when the phase is more than half a turn from where it ends [s].
    last_reversal : float
        When the free mass last turns backwards [s].
    settled : float
        From when on the phase stays within 0.5 rad of where it ends [s].
    turns : float
        Per period, over the last eight.
    direction : int
    least_speed : float
        Of the last period, by omega, in the sense of the turning.
    """

    last_slip: float
    last_reversal: float
    settled: float
    turns: float
    direction: int
    least_speed: float


def lock_in(times: Array, theta: Array, speed: Array) -> LockIn:
    """Return how a motion (n_t,) from rest locks into rotation."""
    omega = 2 * np.pi * EXAMPLE.force_frequency
    turns = (theta[-1] - theta[-1 - 8 * SAMPLES]) / (2 * np.pi * 8)
    direction = 1 if turns > 0 else -1
    stroboscopic = times[::SAMPLES]
    phase = (direction * theta - omega * times)[::SAMPLES]
    off = np.abs(phase - phase[-9:].mean())
    return LockIn(
        last_slip=float(np.max(stroboscopic[off > np.pi], initial=0.0)),
        last_reversal=float(np.max(times[direction * speed < 0], initial=0.0)),
        settled=float(np.max(stroboscopic[off > 0.5], initial=0.0)),
        turns=abs(turns),
        direction=direction,
        least_speed=extremes(times[-1 - SAMPLES :], direction * speed[-1 - SAMPLES :])[0] / omega,
    )


# Maps


AxisSpan = tuple[str, float, float, int]


def axes(session: Session, engine: str = REFERENCE) -> tuple[AxisSpan, AxisSpan]:
    """Return the axes of figs. 4-7."""
    count = POINTS if engine == REFERENCE else session.engine_points or ENGINE_POINTS
    count = session.points or (FULL_POINTS if session.full else count)
    return ("force_frequency", *HERTZ, count), ("force_amplitude", *NEWTON, count)


def changed(plate: bool) -> Mapping[str, float]:
    """Return the parameters of the free mass: a point, or the semicircular plate."""
    return {"inertia_ratio": SEMICIRCLE} if plate else {}


def stability_map(
    session: Session, plate: bool, engine: str = REFERENCE, model: str | None = None
) -> Map:
    """Return the stability of the rotation of figs. 4 (point mass) and 6 (plate)."""
    return _map(session, "floquet", plate, engine, model)


def motion_map(
    session: Session, plate: bool, engine: str = REFERENCE, model: str | None = None
) -> Map:
    """Return the motion from rest of figs. 5 (point mass) and 7 (plate)."""
    return _map(session, "class", plate, engine, model)


def _map(session: Session, quantity: str, plate: bool, engine: str, model: str | None) -> Map:
    fewer = () if engine == REFERENCE or not session.engine_points else (session.engine_points,)
    return session.once(
        (SCENE, quantity, plate, engine, model, *fewer),
        lambda: session.map(
            SCENE,
            quantity,
            *axes(session, engine),
            engine=engine,
            model=model,
            parameters=changed(plate),
            refine=engine != REFERENCE and not session.full,
        ),
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


def stable(session: Session, plate: bool, which: str) -> Any:
    """Return where (n_y, n_x) a rotation is stable: "printed", or a model of the map."""
    if which == "printed":
        p = grid(session, plate)
        multiplier = session.once(
            (SCENE, "as printed", plate),
            lambda: np.abs(floquet_multipliers(paper_solution(p), p, as_printed=True)[0]),
        )
        return multiplier < 1
    return is_class(stability_map(session, plate, model=which), "stability", "stable")


def on_grid(session: Session, plane: Map, where: Any) -> Any:
    """Return what is known at the reference's points (n_y, n_x) at those of another map."""
    x, y = (Axis(*axis) for axis in axes(session))
    return where[np.ix_(y.nearest(plane.y.values), x.nearest(plane.x.values))]


def alike(session: Session, plate: bool, engine: str) -> float:
    """Return at which share of its points an engine's rotation is stable as the true one is."""
    own = stability_map(session, plate, engine)
    true = on_grid(session, own, stable(session, plate, "exact"))
    return float(np.mean((is_class(own, "stability", "stable") == true)[own.computed == 1]))


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


@dataclass(frozen=True)
class Agreement:
    """How well a stability map tells where hula-hoop motion comes from rest.

    Attributes
    ----------
    share : float
        Of the robust points at which "stable" and "class blue o" are both true or both false.
    trivial : float
        Share that the better of "everywhere" and "nowhere" would reach.
    points : int
        Robust points.
    """

    share: float
    trivial: float
    points: int


def agreement(session: Session, plate: bool, which: str) -> Agreement:
    """Compare fig. 4 with fig. 5, or fig. 6 with fig. 7 (plate)."""
    motion = motion_map(session, plate)
    robust = motion.robust
    hoop = is_class(motion, "motion", "blue_o")[robust]
    calm = stable(session, plate, which)[robust]
    return Agreement(
        share=float(np.mean(hoop == calm)),
        trivial=float(max(hoop.mean(), 1 - hoop.mean())),
        points=int(robust.sum()),
    )


def own_maps(session: Session, plate: bool, engine: str) -> tuple[Any, Any, Any]:
    """Return what an engine says of its rotation, and of the motion from rest.

    Three bool arrays (k,) over the points that it computed in both maps, its motion robust:
    the rotation is stable, hula-hoop motion from rest, and this repeats in each period.
    """
    calm, motion = stability_map(session, plate, engine), motion_map(session, plate, engine)
    known = (calm.computed == 1) & (motion.computed == 1) & motion.robust
    hoop = is_class(motion, "motion", "blue_o")
    once = hoop & (motion.variables["periods"] == 1)
    return is_class(calm, "stability", "stable")[known], hoop[known], once[known]

"""Runs and maps that the figures and the ledger of the speed_regulator paper share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from ....reference import get_scene
from ....reference.scene import Array
from ....reference.speed_regulator.equations import SpeedRegulator
from ...engines.registry import REFERENCE, get_engine
from ...maps.store import Map
from ...queries.simulate import Simulation, simulate
from ...scenes.quantity import Points
from ...scenes.speed_regulator.maps import QUANTITIES
from ..session import Session, once

SCENE = "speed_regulator"
EXAMPLE = SpeedRegulator()
"""Our choice of what the paper leaves open; c = 2 N s/m."""

DAMPINGS = (2.0, 3.0, 4.0)
"""Dampers of figure 5 [N s/m]."""
STARTS = (2.0, 4.0, 6.0, 8.0)
"""Speeds at phi = 0 for figure 4 [rad/s]; the text has none."""
SLOW_START = 0.6
"""Speed at which the crank does not come over the spring [rad/s]."""
SPACING = 0.125
"""Time between two samples of a run [s]."""


def damped(damping: float, **changes: float) -> SpeedRegulator:
    """Return the example with another damper."""
    return EXAMPLE.replace(damping=damping, **changes)


# Runs


@dataclass(frozen=True)
class Experiment:
    """One motion: parameters that differ from the example's, start, and duration [s]."""

    seconds: float
    state: Mapping[str, float]
    parameters: Mapping[str, float] = field(default_factory=dict)
    spacing: float = SPACING


FROM_STARTS = {
    f"start_{speed:g}": Experiment(200.0, {"phi_dot": speed}, spacing=SPACING / 2)
    for speed in STARTS
}
RUNS = {
    **FROM_STARTS,
    "start_slow": Experiment(120.0, {"phi_dot": SLOW_START}),
    "damping_2": FROM_STARTS["start_6"],
    **{
        f"damping_{c:g}": Experiment(100.0, {"phi_dot": 6.0}, {"damping": c}, SPACING / 2)
        for c in DAMPINGS[1:]
    },
    "from_below": Experiment(100.0, {"phi_dot": 1.5}, {"damping": 4.0}, SPACING / 2),
    "braked": Experiment(120.0, {"phi_dot": 5.07}, {"damping": 4.0, "torque": 0.04}, SPACING / 2),
    "frictionless": Experiment(16.0, {"phi_dot": 5.07}, {"damping": 0.0}, SPACING / 4),
}


@once
def recorded_motion(session: Session, name: str, engine: str = REFERENCE) -> Simulation:
    """Return a motion by the reference or an engine's default model."""
    run = RUNS[name]
    times = np.linspace(0, run.seconds, round(run.seconds / run.spacing) + 1)
    how = {"parameters": run.parameters, "state": run.state}
    return simulate(SCENE, engine=engine, times=times, **how)


def parameters_of(name: str) -> SpeedRegulator:
    """Return all parameters of a motion."""
    return EXAMPLE.replace(**RUNS[name].parameters)


def ending(session: Session, name: str, engine: str = REFERENCE) -> str:
    """Return the outcome of a motion: rotation or rest."""
    own = recorded_motion(session, name, engine)
    outcome = get_scene(SCENE).outcome
    assert outcome is not None
    return outcome(own.times, own.observables, parameters_of(name))


def turn_speeds(motion: Simulation) -> Array:
    """Return the mean speed [rad/s] of each whole turn of a motion that goes forward."""
    phi = motion.observables["phi"]
    marks = np.arange(np.ceil(phi[0] / (2 * np.pi)), np.floor(phi[-1] / (2 * np.pi)) + 1)
    return 2 * np.pi / np.diff(np.interp(2 * np.pi * marks, phi, motion.times))


TURN = 2 * np.pi
ANGLES = np.linspace(0, TURN, 121)
"""Crank angles of a turn."""


def last_turn(motion: Simulation, names: tuple[str, ...] = ("y", "y_dot")) -> Array:
    """Return observables (n, 121) over the crank angle of the last whole turn."""
    phi = motion.observables["phi"]
    begin = TURN * (np.floor(phi[-1] / TURN) - 1)
    at = slice(int(np.searchsorted(phi, begin)) - 2, None)
    curves = [CubicSpline(phi[at], motion.observables[name][at]) for name in names]
    return np.array([curve(begin + ANGLES) for curve in curves])


def mean_over_turns(motion: Simulation, turns: int) -> Array:
    """Return the mean speed of turns so many at a time, the first at the start."""
    phi = motion.observables["phi"]
    passed = np.arange(0, np.floor((phi[-1] - phi[0]) / (2 * np.pi)) + 1, turns)
    times = np.interp(phi[0] + 2 * np.pi * passed, phi, motion.times)
    return 2 * np.pi * turns / np.diff(times)


# Rotations and maps


def points(engine: str, **values: Any) -> Points:
    """Return points of a map that are on no grid: the example with these values, arrays (k,)."""
    model = "" if engine == REFERENCE else get_engine(engine).models(SCENE)[0]
    arrays = dict(zip(values, np.broadcast_arrays(*values.values()), strict=True))
    arrays = {name: np.array(value, dtype=float) for name, value in arrays.items()}
    count = len(next(iter(arrays.values())))
    places = np.stack([np.arange(count), np.zeros(count, dtype=int)], axis=1)
    return Points(get_scene(SCENE), EXAMPLE.replace(**arrays), places, arrays, engine, model)


@once
def own_speeds(session: Session, engine: str = REFERENCE) -> Array:
    """Return the mean speed (3,) [rad/s] of an engine's rotation for c = 2, 3, 4."""
    at = points(engine, damping=np.array(DAMPINGS))
    return QUANTITIES["mean_speed"].evaluate(at).values["mean_speed"]


TORQUE = (0.04, 1.0)
"""Axis of figure 3 [N m]; the text gives none."""
COARSE_TORQUES, FINE_TORQUES = 17, 97


def speed_map(
    session: Session, engine: str = REFERENCE, fine: bool = False, model: str | None = None
) -> Map:
    """Return mean speeds over torque (columns) and the three dampers (rows)."""
    count = FINE_TORQUES if fine else COARSE_TORQUES
    return session.map(
        SCENE,
        "mean_speed",
        ("torque", *TORQUE, count),
        ("damping", DAMPINGS[0], DAMPINGS[-1], len(DAMPINGS)),
        engine=engine,
        model=model,
    )

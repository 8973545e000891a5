"""Measures of the speed_regulator paper, and the runs and maps that they and the figures share.

Its equations themselves are texts in ``claims.toml``. The torque below which rotations are braked,
figure 6, is a curve over the damper: by the reference's homoclinic orbits, by the work of weak
damping along the orbit of the spring alone, and by engines that start near the saddle.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.integrate import quad, solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq
from scipy.stats import linregress

from ....reference import get_scene
from ....reference.errors import NoOrbitError
from ....reference.scene import Array
from ....reference.speed_regulator.equations import (
    SpeedRegulator,
    coefficients,
    inertia,
    outputs,
    position,
)
from ....reference.speed_regulator.motions import found_equilibria, mean_speed, static_stiffness
from ....reference.speed_regulator.theory import (
    PRINTED_REMAINDER,
    Threshold,
    least_torque,
    printed_mean_speed,
    rotation,
)
from ...engines.registry import REFERENCE, get_engine
from ...engines.run import call_engine
from ...maps.store import Map
from ...queries.query import choose_engine
from ...queries.request import Query
from ...queries.simulate import Simulation, simulate
from ...scenes.quantity import Points
from ...scenes.speed_regulator.maps import QUANTITIES
from ..equations import Values
from ..ledger import Numbers, half_unit
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
    return simulate(SCENE, engine=engine, parameters=run.parameters, state=run.state, times=times)


def parameters_of(name: str) -> SpeedRegulator:
    """Return all parameters of a motion."""
    return EXAMPLE.replace(**RUNS[name].parameters)


def turn_speeds(motion: Simulation, turns: int = 0) -> Array:
    """Return the mean speed [rad/s] of each whole turn of a motion that goes forward.

    With ``turns``, that over so many turns at a time, the first from the start on.
    """
    phi = motion.observables["phi"]
    if turns:
        marks = phi[0] + 2 * np.pi * np.arange(0, (phi[-1] - phi[0]) // (2 * np.pi) + 1, turns)
    else:
        first, last = np.ceil(phi[0] / (2 * np.pi)), np.floor(phi[-1] / (2 * np.pi))
        marks = 2 * np.pi * np.arange(first, last + 1)
    return 2 * np.pi * (turns or 1) / np.diff(np.interp(marks, phi, motion.times))


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


# Sections 1 to 3, to equation (20) ----------------------------------------------------------------


SPEED = 5.07
"""Crank speed at which accelerations and reactions are compared [rad/s]."""

REACTIONS = {
    "X_A": "reaction_a_x",
    "Y_A": "reaction_a_y",
    "X_B": "reaction_b_x",
    "Y_B": "reaction_b_y",
}
"""Names of the paper's reactions in the scene."""


def motion(values: Values) -> Values:
    """Return the scene's acceleration and reactions at a point of equations (13)-(19)."""
    length = values["r"] + values["reach"]
    p = SpeedRegulator(
        crank_radius=values["r"],
        rod_length=length,
        flywheel_inertia=values["J_O"],
        rod_mass=values["m_b"],
        slider_mass=values["m"],
        stiffness=values["k"],
        damping=values["c"],
        torque=values["M_m"],
        spring_rest=-length,
    )
    c, phi, speed = coefficients(p), np.array([values["phi"]]), np.array([values["omega_1"]])
    rate = get_scene(SCENE).accelerations(0.0, [phi], [speed], c)[0]
    forces = outputs(phi[None], speed[None], c)
    own = {name: float(forces[key][0]) for name, key in REACTIONS.items()}
    return {"epsilon_1": float(rate[0]), **own}


# Introduction and section 2


def without_friction(session: Session, who: str) -> Numbers:
    """Return the least gain of speed [rad/s] from one turn to the next without friction.

    For the reference also the relative error of the energy, which gains the motor's work, and the
    share of the time in which the speed falls.
    """
    run = recorded_motion(session, "frictionless", who)
    value = {"value": np.min(np.diff(turn_speeds(run)))}
    if who != REFERENCE:
        return value
    phi, speed = (run.observables[k] for k in ("phi", "phi_dot"))
    energy = get_scene(SCENE).energy([phi[[0, -1]]], [speed[[0, -1]]], coefficients(damped(0.0)))
    error = abs((energy[1] - energy[0]) / (EXAMPLE.torque * (phi[-1] - phi[0])) - 1)
    return {**value, "error": error, "falls": np.mean(np.diff(speed) < 0)}


def opening(session: Session, who: str) -> Numbers | str:
    """Return the largest opening of an engine's loop [m]; no words if it has none."""
    violation = recorded_motion(session, "start_8", who).observables.get("position_violation")
    return "" if violation is None else {"opening": np.max(violation)}


def crank_angle_error(session: Session, who: str) -> float:
    """Return the largest error of the crank angle within 10 s from 8 rad/s [rad]."""
    truth, own = (recorded_motion(session, "start_8", name) for name in (REFERENCE, who))
    return float(np.max(abs(own.observables["phi"] - truth.observables["phi"])[truth.times <= 10]))


def largest_difference(own: Any, exact: Any) -> float:
    """Return the largest difference of two arrays, relative to the largest value of the second."""
    return float(np.max(np.abs(own - exact)) / np.max(np.abs(exact)))


def reactions(session: Session, who: str) -> Numbers | str:
    """Return the largest error of an engine's reactions, relative to the largest reaction."""
    if who == REFERENCE:
        return {}
    case, names = Query(SCENE).case, list(REACTIONS.values())
    engine, model = choose_engine(who, case, None)
    if not set(names) <= set(engine.bind(case, model).reaction_names):
        return "does not tell"
    states = np.array([[phi, SPEED] for phi in (0.3, 1.9, 4.4)])
    phi, speed = states.T[:, None]
    exact = outputs(phi, speed, coefficients(EXAMPLE))
    own = call_engine(lambda: engine.bind(case, model).reactions(np.zeros(len(states)), states))
    tables = (np.array([values[name] for name in names]) for values in (own, exact))
    return {"error": largest_difference(*tables)}


def accelerations(session: Session, who: str) -> Numbers:
    """Return the relative error of an engine's accelerations, and its model."""
    if who == REFERENCE:
        return {}
    case = Query(SCENE).case
    engine, model = choose_engine(who, case, None)
    states = np.array([np.linspace(0, 6, 16), SPEED * np.linspace(-1, 1, 16)]).T
    exact = get_scene(SCENE).accelerations(0.0, *states.T[:, None], coefficients(EXAMPLE))[0]
    own = call_engine(lambda: engine.bind(case, model).accelerations(np.zeros(len(states)), states))
    return {"error": largest_difference(own[:, 0], exact), "model": model}


def taken_up_again(session: Session) -> Numbers:
    """Return the change [rad] of a motion if it is interrupted and continued after a second."""
    times = np.arange(1, 17) / 8
    first = simulate(SCENE, state={"phi": 0.4, "phi_dot": SPEED}, times=times)
    half = {k: float(first.observables[k][7]) for k in ("phi", "phi_dot")}
    again = simulate(SCENE, state=half, times=times[:8])
    return {"error": np.max(abs(again.observables["phi"] - first.observables["phi"][8:]))}


def nonlinearity(session: Session) -> Numbers:
    """Return the bends of phi'' over the speed, and for twice the angle, which a line lacks."""
    phi, speed = np.array([0.7, 0.7, 0.7, 1.4]), np.array([0.0, 3.0, 6.0, 0.0])
    rates = get_scene(SCENE).accelerations(0.0, [phi], [speed], coefficients(EXAMPLE))[0]
    still, slow, fast, doubled = rates
    return {
        "bend": abs(fast - 2 * slow + still) / abs(slow - still),
        "uneven": abs(doubled - 2 * still),
    }


PROBE = 1e-30
"""Complex step, far below round-off."""


def halved_slope(session: Session) -> Numbers:
    """Return the effect of J' as (18) prints it on a free crank's energy, and on the limit cycle.

    The range of the energy in a turn, relative to its start; mean speeds [rad/s], as printed and
    corrected.
    """
    c, scene, speeds = coefficients(EXAMPLE), get_scene(SCENE), []

    def turn(speed: float, share: float) -> Array:
        """Return speed and time after a turn, with a share of J' phi'^2/J added to phi''."""

        def over_angle(phi: float, values: Array) -> list[float]:
            moment = inertia(position(phi + 1j * PROBE, c), c)
            rate = scene.accelerations(0.0, [phi], values[:1], c)[0]
            rate += share * moment.imag / PROBE / moment.real * values[0] ** 2
            return [rate / values[0], 1 / values[0]]

        run = solve_ivp(over_angle, (0, TURN), [speed, 0.0], rtol=1e-9, atol=1e-11)
        return np.asarray(run.y[:, -1])

    for share in (1 / 4, 0.0):
        start = brentq(lambda v, share=share: turn(v, share)[0] - v, 4.9, 5.3, xtol=1e-6)
        speeds.append(TURN / turn(start, share)[1])
    energy = np.sqrt(inertia(position(np.linspace(0, TURN, 513), c), c))
    return {"swing": np.ptp(energy) / energy[0], "speeds": speeds}


# Averages of section 3

SAMPLES = 4096
"""Samples of a turn; means of periodic functions are then exact to round-off to lambda = 0.98."""


def averages(session: Session, ratio: float = 0.2, value: str = "damper") -> Numbers:
    """Return means of section 3 over a turn of the crank, for lambda = r/l; one is the value.

    ``cos_squared``; ``remainder`` of t^2 sin^2 beta, and in closed form, ``exact``; ``damper`` of
    (r cos phi - l t sin beta)^2/l^2, as (20) has it, ``by_20``, and the relative error of that.
    """
    phi = 2 * np.pi * np.arange(SAMPLES) / SAMPLES
    sine = ratio * np.cos(phi)
    lever = ratio * np.sin(phi) / np.sqrt(1 - sine**2) * sine
    parts = {"cos_squared": np.cos(phi), "remainder": lever, "damper": sine - lever}
    means = {name: float(np.mean(part**2)) for name, part in parts.items()}
    by_20 = ratio**2 / 2 + PRINTED_REMAINDER
    return {
        **means,
        "value": means[value],
        "by_20": by_20,
        "error": abs(by_20 / means["damper"] - 1),
        "exact": exact_remainder(ratio),
    }


def exact_remainder(ratio: float) -> float:
    """Return the mean of t^2 sin^2 beta in closed form."""
    return 1 - math.sqrt(1 - ratio**2) - ratio**2 / 2


def remainder(session: Session) -> Numbers:
    """Return the mean of t^2 sin^2 beta at lambda = 0.2, and all lambda that round to the printed.

    These as the least and the largest.
    """
    half = half_unit(f"{PRINTED_REMAINDER:f}")
    ratios = [
        brentq(lambda ratio, mean=mean: exact_remainder(ratio) - mean, 0.1, 0.3)
        for mean in (PRINTED_REMAINDER - half, PRINTED_REMAINDER + half)
    ]
    return {**averages(session, value="remainder"), "ratios": ratios}


def remainder_everywhere(session: Session, ratios: Sequence[float]) -> Numbers:
    """Return that mean for several lambda, and the error of (21) by 0.000204."""
    sets = [EXAMPLE.replace(crank_radius=ratio * EXAMPLE.rod_length) for ratio in ratios]
    errors = [float(printed_mean_speed(p) / mean_speed(p) - 1) for p in sets]
    means = [averages(session, ratio)["remainder"] for ratio in ratios]
    return {
        "means": [f"{mean:.3g} at {ratio:g}" for mean, ratio in zip(means, ratios, strict=True)],
        "errors": errors,
        "largest": max(map(abs, errors)),
    }


# Sections 3 and 4: formula (21), figures 3 to 7 ---------------------------------------------------


# The stabilised speed: (21), figures 3 to 5


def own_rotations(session: Session, who: str) -> Numbers:
    """Return the mean speeds [rad/s] of the rotations for the dampers of figure 5.

    Changes of these, and damper times speed; errors of (21), and its change by the exact average;
    the least torques of a rotation [N m].
    """
    speeds = own_speeds(session, who)
    formula = np.array([float(printed_mean_speed(damped(c))) for c in DAMPINGS])
    exact = np.array([float(mean_speed(damped(c))) for c in DAMPINGS])
    errors = formula / speeds - 1
    return {
        "speeds": speeds,
        "changes": np.diff(speeds),
        "products": speeds * np.array(DAMPINGS),
        "errors": errors,
        "largest": np.max(abs(errors)),
        "change": np.max(abs(exact / formula - 1)),
        "least": [limit.torque for limit in limits(session)],
    }


def asymptote(session: Session, inertias: Sequence[float]) -> Numbers:
    """Return errors of the exact average with ever larger flywheels [kg m^2], and their order."""
    sets = [EXAMPLE.replace(flywheel_inertia=value) for value in inertias]
    errors = [rotation(p).mean_speed / float(mean_speed(p)) - 1 for p in sets]
    slope = np.log(errors[-1] / errors[-2]) / np.log(inertias[-1] / inertias[-2])
    return {"inertias": inertias, "errors": errors, "slope": slope, "off": abs(slope + 1)}


def spring_speeds(session: Session, stiffnesses: Sequence[float]) -> Numbers:
    """Return mean speeds [rad/s] of rotations with several springs [N/m]."""
    return {"speeds": [rotation(EXAMPLE.replace(stiffness=k)).mean_speed for k in stiffnesses]}


def linear_law(session: Session, who: str, away: float) -> Numbers:
    """Return the curvature of figure 3's curves, and the largest error of (21).

    From ``away`` times the least torque of a rotation on, and the curvature from that torque on.
    For an engine, the largest relative error of its speeds.
    """
    if who != REFERENCE:
        own, true = (speed_map(session, name).variables["mean_speed"] for name in (who, REFERENCE))
        return {"gap": np.nanmax(abs(own / true - 1))}
    fine, least = speed_map(session, fine=True), [limit.torque for limit in limits(session)]
    torque = fine.x.values
    speeds, errors = (fine.variables[name] for name in ("mean_speed", "error_as_printed"))

    def bend(begin: float) -> float:
        """Return the largest distance of a curve from a straight line, over its height."""
        off = []
        for speed, limit in zip(speeds, least, strict=True):
            there = np.isfinite(speed) & (torque >= begin * limit)
            line = linregress(torque[there], speed[there])
            gap = speed[there] - line.intercept - line.slope * torque[there]
            off.append(np.max(abs(gap)) / np.max(speed[there]))
        return float(max(off))

    apart = [abs(error[torque >= away * t]).max() for error, t in zip(errors, least, strict=True)]
    return {"bend": bend(away), "near": bend(1.0), "apart": max(apart), "least": least}


@once
def limits(session: Session) -> list[Threshold]:
    """Return the least torque of a rotation for each damper of figure 5, with its bound."""
    return [least_torque(damped(c)) for c in DAMPINGS]


def work_ratio(session: Session, who: str) -> Numbers:
    """Return the damper's work over the motor's in the last turn from 6 rad/s with c = 4.

    And the speed of this turn over that of the limit cycle, less 1.
    """
    p, run = parameters_of("damping_4"), recorded_motion(session, "damping_4", who)
    rate, speed = last_turn(run, ("y_dot", "phi_dot"))
    work = p.damping * rate**2 / speed  # over the crank angle
    ratio = float(np.mean(work[:-1]) / p.torque)
    faster = float(turn_speeds(run)[-1]) / rotation(p).mean_speed - 1
    return {"ratio": ratio, "error": abs(ratio - 1), "faster": faster}


def last_speeds(session: Session, who: str) -> Numbers:
    """Return the mean speeds of the last ten turns from each start of figure 4, and their range.

    And the relative change over these turns from the last start, 8 rad/s.
    """
    runs = [turn_speeds(recorded_motion(session, f"start_{v:g}", who)) for v in STARTS]
    speeds = [float(np.mean(turns[-10:])) for turns in runs]
    drift = float(abs(runs[-1][-1] / runs[-1][-11] - 1))
    return {"speeds": speeds, "spread": np.ptp(speeds), "drift": drift}


def variation_of_runs(session: Session, who: str) -> Numbers:
    """Return the range of the speed over its mean in the last turn of each run of figure 5."""
    runs = (recorded_motion(session, f"damping_{c:g}", who) for c in DAMPINGS)
    speeds = [last_turn(run, ("phi_dot",)) for run in runs]
    return {"last": [np.ptp(speed) / np.mean(speed) for speed in speeds]}


# Figures 6, 7, and conclusions


def braked(session: Session, who: str) -> Numbers:
    """Return the outcome of the braked run, and the number of its reversals.

    For the reference its parameters too, and the largest gain of energy besides the motor's work.
    """
    run, p, scene = (
        recorded_motion(session, "braked", who),
        parameters_of("braked"),
        get_scene(SCENE),
    )
    phi, speed = run.observables["phi"], run.observables["phi_dot"]
    assert scene.outcome is not None
    end = scene.outcome(run.times, run.observables, p)
    own = {"end": end, "reversals": int(np.sum(np.diff(speed > 0)))}
    if who != REFERENCE:
        return own
    energy = scene.energy([phi], [speed], coefficients(p))
    return {
        **own,
        "torque": p.torque,
        "damping": p.damping,
        "least": least_torque(p).torque,
        "gain": np.max(np.diff(energy - p.torque * phi)),
    }


def limit_cycles(session: Session) -> Numbers:
    """Return the multiplier of the limit cycle, and its distance from 1, for each damper.

    And the range of the speed in a turn over its mean.
    """
    cycles = [rotation(damped(c)) for c in DAMPINGS]
    ranges = [cycle.maximum_speed - cycle.minimum_speed for cycle in cycles]
    return {
        "multipliers": [cycle.multiplier for cycle in cycles],
        "lost": [1 - cycle.multiplier for cycle in cycles],
        "variation": [own / cycle.mean_speed for own, cycle in zip(ranges, cycles, strict=True)],
    }


def closing_in(session: Session, who: str) -> Numbers:
    """Return the gap of mean speeds from 6 and 1.5 rad/s in the first and the last turn."""
    above, below = (
        turn_speeds(recorded_motion(session, key, who)) for key in ("damping_4", "from_below")
    )
    first, last = float(above[0] - below[0]), float(above[-1] - below[-1])
    return {"first": first, "last": last, "left": abs(last / first)}


def decay(session: Session, who: str, turn: int) -> float:
    """Return the factor by which a deviation from the limit cycle falls in a turn, c = 4.

    Over ten turns of the run from 6 rad/s, from one by which it is near the limit cycle.
    """
    speeds = turn_speeds(recorded_motion(session, "damping_4", who)) - own_speeds(session, who)[-1]
    return float((speeds[turn + 10] / speeds[turn]) ** 0.1)


def designs(session: Session, speeds: Sequence[float]) -> Numbers:
    """Return the relative errors of the speeds [rad/s] that dampers by (21) give."""
    errors = []
    for omega in speeds:
        p = damped(EXAMPLE.damping * float(mean_speed(EXAMPLE)) / omega)
        try:
            errors.append(rotation(p).mean_speed / omega - 1)
        except NoOrbitError:
            errors.append(np.nan)
    words = [f"{error:+.1%}" if np.isfinite(error) else "no rotation" for error in errors]
    return {"errors": words, "second": abs(errors[1])}


START = 1e-4
"""Distance from the saddle at which an engine starts [rad]."""

SECONDS = 40.0
"""Time by which a crank that comes round from there has done so [s]."""

AROUND, HALVINGS = 0.04, 14
"""Share of the torque around the limit in which an engine's is looked for, and halvings of it."""

NEAR = 0.01
"""Relative distance of the torques below and above the limit at which motions are computed."""


def by_weak_damping(p: SpeedRegulator) -> float:
    """Return the torque [N m] whose work is the damper's along the orbit of the spring alone."""
    c = coefficients(p.replace(torque=0.0))

    def taken(phi: float) -> float:
        at, top = position(phi, c, math), position(math.pi / 2, c, math)
        stored = c.stiffness * ((top.y - c.rest) ** 2 - (at.y - c.rest) ** 2) / 2
        return c.damping * at.y_phi**2 * math.sqrt(2 * max(stored, 0.0) / inertia(at, c))

    halves = ((-math.pi / 2, math.pi / 2), (math.pi / 2, 3 * math.pi / 2))
    return float(sum(quad(taken, *ends, epsabs=1e-12)[0] for ends in halves)) / (2 * math.pi)


def comes_round(who: str, p: SpeedRegulator) -> bool:
    """Return True if a crank that leaves the lower saddle comes round to it, by an engine."""
    c = coefficients(p)
    saddle = found_equilibria(p)["bottom"]
    at = position(saddle, c, math)
    moment, damping = inertia(at, c), c.damping * at.y_phi**2
    softness = -static_stiffness(saddle, c, math)
    rate = (math.sqrt(damping**2 + 4 * moment * softness) - damping) / (2 * moment)
    run = simulate(
        SCENE,
        engine=who,
        parameters={"damping": p.damping, "torque": p.torque},
        state={"phi": saddle + START, "phi_dot": rate * START},
        times=np.linspace(0.0, SECONDS, 81),
    )
    return bool(np.max(run.observables["phi"]) > saddle + 2 * math.pi)


def braking(session: Session, who: str) -> Numbers | str:
    """Return limits [N m], bounds, errors of weak damping, and motions just below and above.

    For dampers of 2, 3 and 4 N s/m; the motions have the last of them. For an engine, the relative
    errors of its limits for the least and the largest damper alone, since each takes 16 runs.
    """
    torques = np.array([limit.torque for limit in limits(session)])
    if who == REFERENCE:
        last = damped(DAMPINGS[-1])
        weak = np.array([by_weak_damping(damped(c)) for c in DAMPINGS]) / torques - 1
        slower, faster = (
            comes_round(who, last.replace(torque=torques[-1] * (1 + side * NEAR)))
            for side in (-1, 1)
        )
        return {
            "own": torques,
            "torques": torques,
            "bound": max(limit.error for limit in limits(session)),
            "weak": weak,
            "slack": np.max(np.abs(weak)),
            "slower": slower,
            "faster": faster,
        }
    off = []
    for damping, torque in zip(DAMPINGS[::2], torques[::2], strict=True):
        low, high = (torque * (1 + side * AROUND / 2) for side in (-1, 1))
        if [comes_round(who, damped(damping, torque=end)) for end in (low, high)] != [False, True]:
            return f"more than {AROUND / 2:.0%} off"
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            round_ = comes_round(who, damped(damping, torque=middle))
            low, high = (low, middle) if round_ else (middle, high)
        off.append((low + high) / 2 / torque - 1)
    return {"off": off}


# Readings

SMALL = EXAMPLE.replace(crank_radius=0.1, rod_length=0.5, spring_rest=-0.5, torque=0.0512)

VARIANTS = {
    "missing_parameters": (
        EXAMPLE,
        EXAMPLE.replace(flywheel_inertia=8.0),
        EXAMPLE.replace(flywheel_inertia=0.5),
        EXAMPLE.replace(rod_mass=2.0, slider_mass=4.0),
        EXAMPLE.replace(stiffness=8.0),
        EXAMPLE.replace(stiffness=128.0),
        SMALL,
        SMALL.replace(stiffness=200.0),
    ),
    "spring_reference": tuple(
        EXAMPLE.replace(spring_rest=place) for place in (-1.25, -1.5, -math.sqrt(1.5), 0.0)
    ),
    "braking_of_figure_6": (
        damped(4.0, torque=0.04),
        damped(2.0, torque=0.0),
        damped(14.0),
        damped(8.0),
        damped(4.0),
    ),
}
"""Parameters that a reading tries, in the order of its candidates."""


def variants(session: Session, of: str) -> Numbers:
    """Return the results of a reading's parameters in words; ``average``, M_m/(c l^2) [1/s].

    The mean speed and the least torque of a rotation, and the equilibria [rad]. And the limits of
    M_m/(c l^2) by (21) for speeds that round to 5.07 rad/s.
    """
    words, rests = [], []
    for p in VARIANTS[of]:
        least = least_torque(p).torque
        turns = f"{rotation(p).mean_speed:.4f} rad/s" if p.torque > least else "no rotation"
        words.append(f"{turns}; least torque of a rotation {least:.4f} N m")
        rests.append(", ".join(f"{name} {at:.2f}" for name, at in found_equilibria(p).items()))
    average = EXAMPLE.torque / (EXAMPLE.damping * EXAMPLE.rod_length**2)
    limits = average / float(printed_mean_speed(EXAMPLE)) * np.array([5.065, 5.075])
    return {"words": words, "rests": rests, "average": average, "limits": limits}


def dampers_of_figure_4(session: Session) -> Numbers:
    """Return the limit cycle [rad/s] with its torque for each damper, and its multiplier.

    And the number of turns in which a deviation falls to a half.
    """
    torques = [EXAMPLE.torque * c / EXAMPLE.damping for c in DAMPINGS]
    cycles = [rotation(damped(c, torque=t)) for c, t in zip(DAMPINGS, torques, strict=True)]
    multipliers = np.array([cycle.multiplier for cycle in cycles])
    return {
        "speeds": [cycle.mean_speed for cycle in cycles],
        "multipliers": multipliers,
        "turns": -np.log(2) / np.log(multipliers),
    }


def axes_of_figure_3(session: Session, dampings: Sequence[float], torque: float) -> Numbers:
    """Return the least torque [N m] by damper, and errors of (21) at twice that and at a torque."""
    least = [least_torque(damped(c)).torque for c in dampings]
    sets = [
        [damped(c, torque=own) for own in (2 * limit, torque)]
        for c, limit in zip(dampings, least, strict=True)
    ]
    errors = [
        [float(printed_mean_speed(p)) / rotation(p).mean_speed - 1 for p in pair] for pair in sets
    ]
    return {"least": least, "errors": errors}


def starts(session: Session, speeds: Sequence[float]) -> Numbers:
    """Return the outcome of starts at phi = 0, and at pi, by speed [rad/s].

    It is rotation if the crank comes round three times within 40 s, and rest otherwise.
    """
    ends, times = [], np.linspace(0.0, SECONDS, 161)
    for speed in speeds:
        for phi in (0.0, math.pi):
            run = simulate(SCENE, state={"phi": phi, "phi_dot": speed}, times=times)
            round_ = np.max(run.observables["phi"]) > phi + 6 * math.pi
            ends.append("rotation" if round_ else "rest")
    return {"ends": ends}

"""Measures of the speed_regulator paper, and the runs and maps that they and the figures share.

Its equations themselves are texts in ``claims.toml``. The torque below which rotations are braked,
figure 6, is a curve over the damper: by the reference's homoclinic orbits, by the work of weak
damping along the orbit of the spring alone, and by engines that start near the saddle.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from scipy.integrate import quad, solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from ....reference import get_scene
from ....reference.scene import Array
from ....reference.speed_regulator.equations import (
    SpeedRegulator,
    coefficients,
    inertia,
    outputs,
    position,
)
from ....reference.speed_regulator.motions import found_equilibria, mean_speed
from ....reference.speed_regulator.theory import (
    PRINTED_REMAINDER,
    Threshold,
    least_torque,
    printed_mean_speed,
    rotates,
    rotation,
)
from ...engines.registry import REFERENCE
from ...engines.run import call_engine
from ...maps.request import Axis, Request, evaluate, resolved
from ...maps.store import Map
from ...queries.request import ModelQuery
from ...queries.simulate import Simulation, simulate
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


def damped(damping: float, **changes: float) -> SpeedRegulator:
    """Return the example with another damper."""
    return EXAMPLE.replace(damping=damping, **changes)


# Runs


def experiment(
    speed: float, seconds: float = 100.0, spacing: float = 1 / 16, **parameters: float
) -> Callable[..., Simulation]:
    """Return the simulation of a motion from phi = 0 with a speed [rad/s]; it takes an engine."""
    times, state = np.arange(0, seconds + spacing, spacing), {"phi_dot": speed}
    return partial(simulate, SCENE, parameters=parameters, state=state, times=times)


RUNS = {
    **{f"start_{speed:g}": experiment(speed, 200.0) for speed in STARTS},
    "start_slow": experiment(0.6, 120.0, 1 / 8),
    "damping_2": experiment(6.0, 200.0),
    "damping_3": experiment(6.0, damping=3.0),
    "damping_4": experiment(6.0, damping=4.0),
    "from_below": experiment(1.5, damping=4.0),
    "braked": experiment(5.07, 120.0, damping=4.0, torque=0.04),
    "frictionless": experiment(5.07, 16.0, 1 / 32, damping=0.0),
}
"""Motions by name; the slowest start does not come over the spring."""


@once
def recorded_motion(session: Session, name: str, engine: str = REFERENCE) -> Simulation:
    """Return a motion by the reference or an engine's default model."""
    return RUNS[name](engine=engine)


def turn_speeds(motion: Simulation, turns: int = 1) -> Array:
    """Return the mean speed [rad/s] of a motion over so many turns at a time."""
    phi = motion.observables["phi"]
    marks = np.arange(0, phi[-1], TURN * turns)
    return TURN * turns / np.diff(np.interp(marks, phi, motion.times))


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


@once
def own_speeds(session: Session, engine: str = REFERENCE) -> Array:
    """Return the mean speed (3,) [rad/s] of an engine's rotation for c = 2, 3, 4."""
    axes = Axis("damping", *DAMPINGS[::2], 3), Axis("torque", EXAMPLE.torque, 1.0, 2)
    row = Request(SCENE, "mean_speed", *axes, engine=engine)
    return evaluate(resolved(row), np.array([[0, 0], [1, 0], [2, 0]])).values["mean_speed"]


def speed_map(
    session: Session, engine: str = REFERENCE, count: int = 17, model: str | None = None
) -> Map:
    """Return mean speeds over torque (columns), whose range is ours, and dampers (rows)."""
    axes = ("torque", 0.04, 1.0, count), ("damping", *DAMPINGS[::2], 3)
    return session.map(SCENE, "mean_speed", *axes, engine=engine, model=model)


FINE = 97
"""Torques of the reference's curves."""


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

    The relative error of the energy, which gains the motor's work, and the share of the time in
    which the speed falls.
    """
    run = recorded_motion(session, "frictionless", who)
    phi, speed = (run.observables[name] for name in ("phi", "phi_dot"))
    energy = get_scene(SCENE).energy([phi[[0, -1]]], [speed[[0, -1]]], coefficients(damped(0.0)))
    return {
        "value": np.min(np.diff(turn_speeds(run))),
        "error": abs((energy[1] - energy[0]) / (EXAMPLE.torque * (phi[-1] - phi[0])) - 1),
        "falls": np.mean(np.diff(speed) < 0),
    }


def opening(session: Session, who: str) -> Numbers | str:
    """Return the largest opening of an engine's loop [m]; no words if it has none."""
    violation = recorded_motion(session, "start_8", who).observables.get("position_violation")
    return "" if violation is None else {"opening": np.max(violation)}


def largest_difference(own: Any, exact: Any) -> float:
    """Return the largest difference of two arrays, relative to the largest value of the second."""
    return float(np.max(np.abs(own - exact)) / np.max(np.abs(exact)))


def reactions(session: Session, who: str) -> Numbers | str:
    """Return the largest error of an engine's reactions, relative to the largest reaction."""
    if who == REFERENCE:
        return {}
    bound, names = ModelQuery(SCENE, engine=who).model_setup().bound, list(REACTIONS.values())
    if not set(names) <= set(bound.reaction_names):
        return "does not tell"
    states = np.array([[phi, SPEED] for phi in (0.3, 1.9, 4.4)])
    phi, speed = states.T[:, None]
    exact = outputs(phi, speed, coefficients(EXAMPLE))
    own = call_engine(lambda: bound.reactions(np.zeros(len(states)), states))
    tables = (np.array([values[name] for name in names]) for values in (own, exact))
    return {"error": largest_difference(*tables)}


def accelerations(session: Session, who: str) -> Numbers:
    """Return the relative error of an engine's accelerations, and its model."""
    if who == REFERENCE:
        return {}
    setup = ModelQuery(SCENE, engine=who).model_setup()
    states = np.array([np.linspace(0, 6, 16), SPEED * np.linspace(-1, 1, 16)]).T
    exact = get_scene(SCENE).accelerations(0.0, *states.T[:, None], coefficients(EXAMPLE))[0]
    own = call_engine(lambda: setup.bound.accelerations(np.zeros(len(states)), states))
    return {"error": largest_difference(own[:, 0], exact), "model": setup.model}


def taken_up_again(session: Session) -> Numbers:
    """Return the change [rad] of a motion if it is interrupted and continued after a second."""
    times = np.arange(1, 17) / 8
    first = simulate(SCENE, state={"phi": 0.4, "phi_dot": SPEED}, times=times)
    half = {name: float(first.observables[name][7]) for name in ("phi", "phi_dot")}
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


def halved_slope(session: Session) -> Numbers:
    """Return the effect of J' as (18) prints it on a free crank's energy, and on the limit cycle.

    The range of the energy in a turn, relative to its start; mean speeds [rad/s], as printed and
    corrected.
    """
    c, scene = coefficients(EXAMPLE), get_scene(SCENE)

    def over_angle(phi: float, values: Array) -> list[float]:
        """Return the slopes of speed and time over the angle, with half of J' in the first."""
        speeds = values[0] * np.array([1, -1, 0])
        rate, back, still = scene.accelerations(0.0, [np.full(3, phi)], [speeds], c)[0]
        rate -= (rate + back - 2 * still) / 4  # the bracket is -J' phi'^2/J
        return [rate / values[0], 1 / values[0]]

    def turn(speed: float) -> Array:
        run = solve_ivp(over_angle, (0, TURN), [speed, 0.0], rtol=1e-9, atol=1e-11)
        return np.asarray(run.y[:, -1])

    start = brentq(lambda speed: turn(speed)[0] - speed, 4.9, 5.3, xtol=1e-6)
    energy = np.sqrt(inertia(position(np.linspace(0, TURN, 513), c), c))
    return {
        "swing": np.ptp(energy) / energy[0],
        "speeds": [TURN / turn(start)[1], rotation(EXAMPLE).mean_speed],
    }


# Averages of section 3


def averages(session: Session, ratio: float = 0.2, value: str = "damper") -> Numbers:
    """Return means of section 3 over a turn of the crank, for lambda = r/l; one is the value.

    ``cos_squared``; ``remainder`` of t^2 sin^2 beta, and in closed form, ``exact``; ``damper`` of
    (r cos phi - l t sin beta)^2/l^2, as (20) has it, ``by_20``, and the relative error of that.
    """
    phi = np.linspace(0, TURN, 4096, endpoint=False)  # exact to round-off to lambda = 0.98
    sine, cosine = ratio * np.cos(phi), np.sqrt(1 - (ratio * np.cos(phi)) ** 2)
    lever = ratio * np.sin(phi) / cosine * sine
    parts = {"cos_squared": np.cos(phi), "remainder": lever, "damper": sine - lever}
    means = {name: float(np.mean(part**2)) for name, part in parts.items()}
    by_20 = ratio**2 / 2 + PRINTED_REMAINDER
    return {
        **means,
        "value": means[value],
        "by_20": by_20,
        "error": abs(by_20 / means["damper"] - 1),
        "exact": (1 - math.sqrt(1 - ratio**2)) ** 2 / 2,
    }


def remainder(session: Session) -> Numbers:
    """Return the mean of t^2 sin^2 beta at lambda = 0.2, and all lambda that round to the printed.

    The latter as the least and the largest.
    """
    means = PRINTED_REMAINDER + half_unit(f"{PRINTED_REMAINDER:f}") * np.array([-1, 1])
    ratios = np.sqrt(1 - (1 - np.sqrt(2 * means)) ** 2)
    return {**averages(session, value="remainder"), "ratios": ratios}


def remainder_everywhere(session: Session, ratios: Sequence[float]) -> Numbers:
    """Return that mean for several lambda, and the error of (21) by 0.000204."""
    sets = [EXAMPLE.replace(crank_radius=ratio * EXAMPLE.rod_length) for ratio in ratios]
    errors = [float(printed_mean_speed(p) / mean_speed(p) - 1) for p in sets]
    return {
        "means": [f"{averages(session, one)['remainder']:.3g} at {one:g}" for one in ratios],
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
    speeds, sets = own_speeds(session, who), EXAMPLE.replace(damping=np.array(DAMPINGS))
    formula = printed_mean_speed(sets)
    errors = formula / speeds - 1
    return {
        "speeds": speeds,
        "changes": np.diff(speeds),
        "products": speeds * sets.damping,
        "errors": errors,
        "largest": np.max(abs(errors)),
        "change": np.max(abs(mean_speed(sets) / formula - 1)),
        "least": [limit.torque for limit in limits(session)],
    }


def limit_cycles(session: Session, **values: Sequence[float]) -> Numbers:
    """Return properties of the limit cycles with several values of parameters.

    Those of figure 5 by default. Mean speeds [rad/s], and their errors relative to the exact
    average; multipliers, their distances from 1, and the number of turns in which a deviation falls
    to a half; the range of the speed in a turn over its mean.
    """
    values = values or {"damping": DAMPINGS}
    every = zip(*values.values(), strict=True)
    sets = [EXAMPLE.replace(**dict(zip(values, each, strict=True))) for each in every]
    cycles = [rotation(p) for p in sets]
    speeds = np.array([cycle.mean_speed for cycle in cycles])
    multipliers = np.array([cycle.multiplier for cycle in cycles])
    ranges = [cycle.maximum_speed - cycle.minimum_speed for cycle in cycles]
    return {
        **values,
        "speeds": speeds,
        "errors": speeds / [mean_speed(p) for p in sets] - 1,
        "multipliers": multipliers,
        "lost": 1 - multipliers,
        "turns": -np.log(2) / np.log(multipliers),
        "variation": ranges / speeds,
    }


def asymptote(session: Session, inertias: Sequence[float]) -> Numbers:
    """Return errors of the exact average with ever larger flywheels [kg m^2], and their order."""
    errors = limit_cycles(session, flywheel_inertia=inertias)["errors"]
    slope = np.log(errors[-1] / errors[-2]) / np.log(inertias[-1] / inertias[-2])
    return {"inertias": inertias, "errors": errors, "slope": slope, "off": abs(slope + 1)}


def bend(torque: Array, speed: Array) -> float:
    """Return the largest distance of a curve from a straight line, over its height."""
    line = np.polynomial.Polynomial.fit(torque, speed, 1)
    return float(np.max(np.abs(speed - line(torque))) / np.max(speed))


def linear_law(session: Session, away: float) -> Numbers:
    """Return the curvature of figure 3's curves, and the largest error of (21).

    From ``away`` times the least torque of a rotation on, and the curvature from that torque on.
    """
    fine, least = speed_map(session, count=FINE), [limit.torque for limit in limits(session)]
    torque, bends, apart = fine.x.values, [], []
    for speed, error, limit in zip(
        fine.variables["mean_speed"], fine.variables["error_as_printed"], least, strict=True
    ):
        far, near = (torque >= share * limit for share in (away, 1.0))
        bends.append([bend(torque[part], speed[part]) for part in (far, near)])
        apart.append(np.max(abs(error[far])))
    far, near = np.max(bends, axis=0)
    return {"bend": far, "near": near, "apart": max(apart), "least": least}


@once
def limits(session: Session) -> list[Threshold]:
    """Return the least torque of a rotation for each damper of figure 5, with its bound."""
    return [least_torque(damped(c)) for c in DAMPINGS]


def work_ratio(session: Session, who: str) -> Numbers:
    """Return the damper's work over the motor's in the last turn from 6 rad/s with c = 4.

    And the speed of this turn over that of the limit cycle, less 1.
    """
    p, run = damped(4.0), recorded_motion(session, "damping_4", who)
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


# Figures 6, 7, and conclusions


def braked(session: Session, who: str) -> Numbers:
    """Return the outcome of the braked run, and the number of its reversals.

    Its torque and damper, and the least torque of a rotation with this; the largest gain of energy
    besides the motor's work.
    """
    run, scene = recorded_motion(session, "braked", who), get_scene(SCENE)
    phi, speed = (run.observables[name] for name in ("phi", "phi_dot"))
    p = EXAMPLE.replace(**run.parameters)
    assert scene.outcome is not None
    return {
        "end": scene.outcome(run.times, run.observables, p),
        "reversals": int(np.sum(np.diff(speed > 0))),
        "torque": p.torque,
        "damping": p.damping,
        "least": limits(session)[-1].torque,
        "gain": np.max(np.diff(scene.energy([phi], [speed], coefficients(p)) - p.torque * phi)),
    }


def closing_in(session: Session, who: str) -> Numbers:
    """Return the gap of mean speeds from 6 and 1.5 rad/s in the first and the last turn."""
    runs = [recorded_motion(session, name, who) for name in ("damping_4", "from_below")]
    first, last = (float(np.subtract(*(turn_speeds(run)[i] for run in runs))) for i in (0, -1))
    return {"first": first, "last": last, "left": abs(last / first)}


def decay(session: Session, who: str, turn: int) -> float:
    """Return the factor by which a deviation from the limit cycle falls in a turn, c = 4.

    Over ten turns of the run from 6 rad/s, from one by which it is near the limit cycle.
    """
    speeds = turn_speeds(recorded_motion(session, "damping_4", who)) - own_speeds(session, who)[-1]
    return float((speeds[turn + 10] / speeds[turn]) ** 0.1)


def designs(session: Session, speeds: Sequence[float]) -> Numbers:
    """Return the relative errors of the speeds [rad/s] that dampers by (21) give."""
    sets = [damped(EXAMPLE.damping * float(mean_speed(EXAMPLE)) / omega) for omega in speeds]
    errors = [
        rotation(p).mean_speed / omega - 1 if rotates(p) else np.nan
        for p, omega in zip(sets, speeds, strict=True)
    ]
    words = [f"{error:+.1%}" if np.isfinite(error) else "no rotation" for error in errors]
    return {"errors": words, "second": abs(errors[1])}


def by_weak_damping(p: SpeedRegulator) -> float:
    """Return the torque [N m] whose work is the damper's along the orbit of the spring alone."""
    c = coefficients(p.replace(torque=0.0))
    top = position(math.pi / 2, c, math)

    def taken(phi: float) -> float:
        at = position(phi, c, math)
        stored = c.stiffness * ((top.y - c.rest) ** 2 - (at.y - c.rest) ** 2) / 2
        return c.damping * at.y_phi**2 * math.sqrt(2 * max(stored, 0.0) / inertia(at, c))

    ends = (-math.pi / 2, 3 * math.pi / 2)  # the orbit stands still at the top
    return float(quad(taken, *ends, points=[math.pi / 2], epsabs=1e-12)[0]) / TURN


def comes_round(
    p: SpeedRegulator, start: float, who: str, speed: float = 0, turns: int = 1
) -> bool:
    """Return True if a crank comes round so often within 40 s, from an angle with a speed [rad/s].

    Parameters besides damper and torque are the example's.
    """
    run = simulate(
        SCENE,
        engine=who,
        parameters={"damping": p.damping, "torque": p.torque},
        state={"phi": start, "phi_dot": speed},
        times=np.linspace(0.0, 40.0, 161),
    )
    return bool(np.max(run.observables["phi"]) > start + turns * TURN)


def leaves_for_good(p: SpeedRegulator, who: str = REFERENCE) -> bool:
    """Return True if a crank that leaves the lower saddle comes round to it."""
    return comes_round(p, found_equilibria(p)["bottom"] + 1e-4, who)


def braking(session: Session) -> Numbers:
    """Return limits [N m], bounds, errors of weak damping, and motions just below and above.

    For dampers of 2, 3 and 4 N s/m; the motions have the last of them.
    """
    torques = np.array([limit.torque for limit in limits(session)])
    weak = np.array([by_weak_damping(damped(c)) for c in DAMPINGS]) / torques - 1
    below, above = (damped(DAMPINGS[-1], torque=share * torques[-1]) for share in (0.99, 1.01))
    return {
        "torques": torques,
        "bound": max(limit.error for limit in limits(session)),
        "weak": weak,
        "slack": np.max(np.abs(weak)),
        "slower": leaves_for_good(below),
        "faster": leaves_for_good(above),
    }


def braking_error(session: Session, who: str) -> Numbers | str:
    """Return the relative errors of an engine's limits for the least and the largest damper."""
    if who == REFERENCE:
        return {}
    shares, off = np.linspace(0.98, 1.02, 2**14 + 1), []
    for c, limit in list(zip(DAMPINGS, limits(session), strict=True))[::2]:
        sets = [damped(c, torque=share * limit.torque) for share in shares]
        first = bisect_left(sets, True, key=lambda p: leaves_for_good(p, who))
        if not 0 < first < len(shares):
            return "more than 2% off"
        off.append((shares[first - 1] + shares[first]) / 2 - 1)
    return {"off": off}


# Readings


def variants(session: Session, sets: Sequence[Mapping[str, float]]) -> Numbers:
    """Return the results of changed parameters in words; ``average``, our M_m/(c l^2) [1/s].

    The mean speed and the least torque of a rotation, and the equilibria [rad]. And the limits of
    M_m/(c l^2) by (21) for speeds that round to 5.07 rad/s.
    """
    words, rests = [], []
    for p in (EXAMPLE.replace(**changes) for changes in sets):
        least = least_torque(p).torque
        turns = f"{rotation(p).mean_speed:.4f} rad/s" if p.torque > least else "no rotation"
        words.append(f"{turns}; least torque of a rotation {least:.4f} N m")
        rests.append(", ".join(f"{name} {at:.2f}" for name, at in found_equilibria(p).items()))
    average = EXAMPLE.torque / (EXAMPLE.damping * EXAMPLE.rod_length**2)
    limits = average / float(printed_mean_speed(EXAMPLE)) * np.array([5.065, 5.075])
    return {"words": words, "rests": rests, "average": average, "limits": limits}


def axes_of_figure_3(session: Session, dampings: Sequence[float], torque: float) -> Numbers:
    """Return the least torque [N m] by damper, and errors of (21) at twice that and at a torque."""
    least = [least_torque(damped(c)).torque for c in dampings]
    errors = []
    for c, limit in zip(dampings, least, strict=True):
        sets = [damped(c, torque=own) for own in (2 * limit, torque)]
        errors.append([float(printed_mean_speed(p)) / rotation(p).mean_speed - 1 for p in sets])
    return {"least": least, "errors": errors}


def starts(session: Session, speeds: Sequence[float]) -> Numbers:
    """Return the outcome of starts at phi = 0, and at pi, by speed [rad/s].

    It is rotation if the crank comes round three times, and rest otherwise.
    """
    return {
        "ends": [
            "rotation" if comes_round(EXAMPLE, phi, REFERENCE, speed, 3) else "rest"
            for speed in speeds
            for phi in (0.0, math.pi)
        ]
    }

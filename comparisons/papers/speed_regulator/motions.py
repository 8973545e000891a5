"""Measures of the speed_regulator paper's motions: formula (21), figures 3-7, conclusions.

The torque below which the rotation is braked, figure 6, is a curve over the damper: by the
reference's homoclinic orbits, by what weak damping takes of the orbit of the spring alone, and by
engines that start beside the saddle.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.integrate import quad
from scipy.stats import linregress

from ....reference import get_scene
from ....reference.errors import NoOrbitError
from ....reference.speed_regulator.equations import SpeedRegulator, coefficients, inertia, position
from ....reference.speed_regulator.motions import found_equilibria, mean_speed, static_stiffness
from ....reference.speed_regulator.theory import (
    Threshold,
    least_torque,
    printed_mean_speed,
    rotation,
)
from ...engines.registry import REFERENCE
from ...queries.simulate import simulate
from ..ledger import Numbers
from ..session import Session, once
from .results import (
    DAMPINGS,
    EXAMPLE,
    SCENE,
    STARTS,
    damped,
    ending,
    last_turn,
    own_speeds,
    parameters_of,
    recorded_motion,
    speed_map,
    turn_speeds,
)

# The stabilised speed: (21), figures 3 to 5


def own_rotations(session: Session, who: str) -> Numbers:
    """Return the mean speeds [rad/s] of the rotations for the dampers of figure 5.

    Changes of these, and damper times speed; errors of (21), and its change by the exact average.
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


def linear_law(session: Session, away: float) -> Numbers:
    """Return the curvature of figure 3's curves, and the largest error of (21).

    From ``away`` times the least torque of a rotation on, and the curvature from that torque on.
    """
    fine = speed_map(session, fine=True)
    torque, least = fine.x.values, least_torques(session)["least"]
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


def speeds_of_figure_3(session: Session, who: str) -> Numbers:
    """Return the largest relative error of the speeds of figure 3."""
    own, true = (speed_map(session, name).variables["mean_speed"] for name in (who, REFERENCE))
    return {"gap": np.nanmax(abs(own / true - 1))}


@once
def limits(session: Session) -> list[Threshold]:
    """Return the least torque of a rotation for each damper of figure 5, with its bound."""
    return [least_torque(damped(c)) for c in DAMPINGS]


def least_torques(session: Session) -> Numbers:
    """Return the least torque [N m] of a rotation for each damper."""
    return {"least": [limit.torque for limit in limits(session)]}


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
    observables = recorded_motion(session, "braked", who).observables
    phi, speed = observables["phi"], observables["phi_dot"]
    own: Numbers = {
        "end": ending(session, "braked", who),
        "reversals": int(np.sum(np.diff(speed > 0))),
    }
    if who != REFERENCE:
        return own
    p = parameters_of("braked")
    energy = get_scene(SCENE).energy([phi], [speed], coefficients(p))
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


def braking(session: Session) -> Numbers:
    """Return limits [N m], bounds, errors of weak damping, and motions just below and above.

    For dampers of 2, 3 and 4 N s/m; the motions have the last of them.
    """
    own, last = limits(session), damped(DAMPINGS[-1])
    torques = np.array([limit.torque for limit in own])
    weak = np.array([by_weak_damping(damped(c)) for c in DAMPINGS]) / torques - 1
    slower, faster = (
        comes_round(REFERENCE, last.replace(torque=torques[-1] * (1 + side * NEAR)))
        for side in (-1, 1)
    )
    return {
        "torques": torques,
        "bound": max(limit.error for limit in own),
        "weak": weak,
        "slack": np.max(np.abs(weak)),
        "slower": slower,
        "faster": faster,
    }


def braking_by(session: Session, who: str) -> Numbers | str:
    """Return the limits of the reference [N m], or the relative errors of an engine's limits.

    The engine's for the least and the largest damper alone, since each takes 16 runs.
    """
    torques = least_torques(session)["least"]
    if who == REFERENCE:
        return {"own": torques}
    off = []
    for damping, torque in zip(DAMPINGS[::2], torques[::2], strict=True):
        low, high = (torque * (1 + side * AROUND / 2) for side in (-1, 1))
        turns = [comes_round(who, damped(damping, torque=end)) for end in (low, high)]
        if turns != [False, True]:
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
        "torques": torques,
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

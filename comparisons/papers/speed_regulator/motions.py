"""Measures of the speed_regulator paper's motions: formula (21), figures 3-7, conclusions.

The torque below which the rotation is braked, figure 6, is a curve over the damper: by the
reference's homoclinic orbits, by what weak damping takes of the orbit of the spring alone, and by
engines that start beside the saddle.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import quad
from scipy.stats import linregress

from ....reference import get_scene
from ....reference.errors import NoOrbitError
from ....reference.scene import Array
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
from ..ledger import REPRODUCED, LedgerRow, Numbers, below, equal, holds, statement
from ..session import Session
from .figures import last_turn
from .results import (
    DAMPINGS,
    EXAMPLE,
    SCENE,
    STARTS,
    damped,
    ending,
    own_speeds,
    parameters_of,
    recorded_motion,
    speed_map,
    turn_speeds,
)

CLOSE = 0.02
"""Relative difference that a figure hides."""


# The stabilised speed: (21), figures 3 to 5


def own_rotations(session: Session, who: str) -> Numbers:
    """Return what the rotations for the dampers of figure 5 are like.

    Their mean speeds [rad/s], changes of these, and damper times speed; errors of (21), and what
    its exact average changes of it.
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


INERTIAS = (2.0, 8.0, 32.0, 128.0)
"""Of ever larger flywheels [kg m^2]."""


def asymptote(session: Session) -> Numbers:
    """Return errors of the exact average with ever larger flywheels, and their order in 1/J."""
    sets = [EXAMPLE.replace(flywheel_inertia=value) for value in INERTIAS]
    errors = [rotation(p).mean_speed / float(mean_speed(p)) - 1 for p in sets]
    slope = np.log(errors[-1] / errors[-2]) / np.log(INERTIAS[-1] / INERTIAS[-2])
    return {"inertias": INERTIAS, "errors": errors, "slope": slope, "off": abs(slope + 1)}


AWAY = 2.0
"""Times the least torque of a rotation: from there the linear law is judged."""


def linear_law(session: Session) -> Numbers:
    """Return how straight the curves of figure 3 are, and how far (21) is from them.

    Away from the least torque of a rotation, and straightness from that torque on.
    """
    fine = speed_map(session, fine=True)
    torque, least = fine.x.values, least_torques(session)
    speeds, errors = (fine.variables[name] for name in ("mean_speed", "error_as_printed"))

    def bend(speed: Array, begin: float) -> float:
        there = np.isfinite(speed) & (torque >= begin)
        line = linregress(torque[there], speed[there])
        off = speed[there] - line.intercept - line.slope * torque[there]
        return float(np.max(abs(off)) / np.max(speed[there]))

    away = [error[torque >= AWAY * t] for error, t in zip(errors, least, strict=True)]
    return {
        "bend": max(bend(speed, AWAY * t) for speed, t in zip(speeds, least, strict=True)),
        "near": max(bend(speed, t) for speed, t in zip(speeds, least, strict=True)),
        "apart": max(float(np.max(abs(error))) for error in away),
        "least": least,
    }


def speeds_of_figure_3(session: Session, who: str) -> Numbers:
    """Return how far the speeds of figure 3 are from the reference's, relative to them."""
    own, true = (speed_map(session, name).variables["mean_speed"] for name in (who, REFERENCE))
    return {"gap": np.nanmax(abs(own / true - 1))}


def least_torques(session: Session) -> Array:
    """Return the least torque (3,) [N m] of a rotation for each damper."""
    return session.once(
        (SCENE, "least torques"),
        lambda: np.array([least_torque(damped(c)).torque for c in DAMPINGS]),
    )


def least_torques_of_rotation(session: Session) -> Numbers:
    """Return the least torque of a rotation for each damper."""
    return {"least": least_torques(session)}


def work_ratio(session: Session, who: str) -> Numbers:
    """Return the damper's work over the motor's in the last turn from 6 rad/s with c = 4.

    And how much faster than the limit cycle this turn is.
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


def braked(session: Session) -> Numbers:
    """Return parameters of the braked run, and the largest gain of energy beside the motor's."""
    p, (phi, phi_dot) = parameters_of("braked"), states_of(session, "braked")
    energy = get_scene(SCENE).energy([phi], [phi_dot], coefficients(p))
    return {
        "torque": p.torque,
        "damping": p.damping,
        "least": least_torque(p).torque,
        "gain": np.max(np.diff(energy - p.torque * phi)),
    }


def states_of(session: Session, name: str, who: str = REFERENCE) -> tuple[Array, Array]:
    """Return crank angle and speed of a run."""
    observables = recorded_motion(session, name, who).observables
    return observables["phi"], observables["phi_dot"]


def end_of_braking(session: Session, who: str) -> Numbers:
    """Return what the braked run ends in, and how often it reverses."""
    forward = states_of(session, "braked", who)[1] > 0
    return {"end": ending(session, "braked", who), "reversals": int(np.sum(np.diff(forward)))}


def limit_cycles(session: Session) -> Numbers:
    """Return what a turn leaves of a deviation from the limit cycle, and loses, for each damper.

    And the range of the speed in a turn over its mean.
    """
    cycles = [rotation(damped(c)) for c in DAMPINGS]
    return {
        "multipliers": [cycle.multiplier for cycle in cycles],
        "lost": [1 - cycle.multiplier for cycle in cycles],
        "variation": [
            (cycle.maximum_speed - cycle.minimum_speed) / cycle.mean_speed for cycle in cycles
        ],
    }


def closing_in(session: Session, who: str) -> Numbers:
    """Return the gap of mean speeds from 6 and 1.5 rad/s in the first and the last turn."""
    above, below = (
        turn_speeds(recorded_motion(session, key, who)) for key in ("damping_4", "from_below")
    )
    first, last = float(above[0] - below[0]), float(above[-1] - below[-1])
    return {"first": first, "last": last, "left": abs(last / first)}


LATE = 20
"""Turn of a run from 6 rad/s with c = 4 by which it is near the limit cycle."""


def decay(session: Session, who: str) -> float:
    """Return by which factor a deviation from the limit cycle falls in a turn, c = 4."""
    speeds = turn_speeds(recorded_motion(session, "damping_4", who)) - own_speeds(session, who)[-1]
    return float((speeds[LATE + 10] / speeds[LATE]) ** 0.1)


WANTED = (5.07, 2.5, 1.5, 1.0)
"""Speeds to design for [rad/s]."""


def designs(session: Session) -> Numbers:
    """Return the relative errors of the speeds that dampers by (21) give, NaN without rotation."""
    errors = []
    for omega in WANTED:
        p = damped(EXAMPLE.damping * float(mean_speed(EXAMPLE)) / omega)
        try:
            errors.append(rotation(p).mean_speed / omega - 1)
        except NoOrbitError:
            errors.append(np.nan)
    words = [f"{error:+.1%}" if np.isfinite(error) else "no rotation" for error in errors]
    return {"errors": words, "second": abs(errors[1])}


BESIDE = 1e-4
"""Distance from the saddle at which an engine starts [rad]; the rest is what a direction errs."""

SECONDS = 40.0
"""In which a crank that comes round from there has done so [s]."""

AROUND, HALVINGS = 0.04, 14
"""Share of the torque around the limit in which an engine's is looked for, and halvings of it."""

NEAR = 0.01
"""Share of the torque below and above the limit at which motions are looked at."""


def limits(session: Session) -> list[Threshold]:
    """Return the reference's limit for each damper of figure 5."""
    return session.once(
        (SCENE, "homoclinic limits"), lambda: [least_torque(damped(c)) for c in DAMPINGS]
    )


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
        state={"phi": saddle + BESIDE, "phi_dot": rate * BESIDE},
        times=np.linspace(0.0, SECONDS, 81),
    )
    return bool(np.max(run.observables["phi"]) > saddle + 2 * math.pi)


def braking(session: Session) -> Numbers:
    """Return limits [N m], bounds, what weak damping gives, and what is just below and above.

    For dampers of 2, 3 and 4 N s/m; the motions have the last of them.
    """
    own, last = limits(session), damped(DAMPINGS[-1])
    weak = [by_weak_damping(damped(c)) for c in DAMPINGS]
    below_and_above = [
        comes_round(REFERENCE, last.replace(torque=own[-1].torque * (1 + side * NEAR)))
        for side in (-1, 1)
    ]
    return {
        "torques": [limit.torque for limit in own],
        "bound": max(limit.error for limit in own),
        "weak": [torque / limit.torque - 1 for torque, limit in zip(weak, own, strict=True)],
        "slack": max(abs(t / limit.torque - 1) for t, limit in zip(weak, own, strict=True)),
        "slower": below_and_above[0],
        "faster": below_and_above[1],
    }


def braking_by(session: Session, who: str) -> Numbers | str:
    """Return the limits of the reference [N m], or how far an engine's are from them, relative.

    The engine's for the least and the largest damper alone, since each takes 16 runs.
    """
    if who == REFERENCE:
        return {"own": [limit.torque for limit in limits(session)]}
    off = []
    for damping, limit in zip(DAMPINGS[::2], limits(session)[::2], strict=True):
        low, high = (limit.torque * (1 + side * AROUND / 2) for side in (-1, 1))
        if comes_round(who, damped(damping, torque=low)) or not comes_round(
            who, damped(damping, torque=high)
        ):
            return f"more than {AROUND / 2:.0%} off"
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            turns = comes_round(who, damped(damping, torque=middle))
            low, high = (low, middle) if turns else (middle, high)
        off.append((low + high) / 2 / limit.torque - 1)
    return {"off": off}


BRAKING: LedgerRow = statement(
    "braking_limit", "3, figure 6",
    "The motion is braked where the damper takes more than the motor gives.", REPRODUCED,
    "the two balance last in the slowest turn that comes over the spring, the homoclinic orbit of "
    "the lower saddle. It is at {torques:.7g} N m for c = 2, 3, 4 (bound {bound:.0e}): 1 % below "
    "it a crank that leaves the saddle does not come round, 1 % above it does. What weak damping "
    "takes of the spring's own orbit is off by {weak:.1e}. The averages (20), (21) have a speed at "
    "every torque, and no such limit",
    braking, braking_by, "{own:.5g} N m", "c = 2 and 4: off by {off:+.1e} of it",
    holds(equal("slower", False), equal("faster", True), below("slack", 0.01)), slow=True,
)  # fmt: skip

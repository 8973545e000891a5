"""Measures of the speed_regulator paper's motions: formula (21), figures 3-7, conclusions."""

from __future__ import annotations

import numpy as np
from scipy.stats import linregress

from ....reference import get_scene
from ....reference.errors import NoOrbitError
from ....reference.scene import Array
from ....reference.speed_regulator.equations import coefficients
from ....reference.speed_regulator.orbit import mean_speed
from ....reference.speed_regulator.theory import (
    least_torque,
    printed_mean_speed,
    regime,
    rotation,
    saddle_node_torques,
)
from ...engines.registry import REFERENCE
from ...scenes.speed_regulator.limit_cycles import REGIMES
from ...scenes.speed_regulator.maps import QUANTITIES
from ..ledger import Numbers
from ..session import Session
from .figures import last_turn
from .results import (
    DAMPINGS,
    EXAMPLE,
    SCENE,
    STARTS,
    agreement,
    damped,
    ending,
    own_speeds,
    parameters_of,
    points,
    recorded_motion,
    regime_map,
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


def linear_law(session: Session) -> Numbers:
    """Return how straight the curves of figure 3 are, and from which torque (21) is close."""
    fine = speed_map(session, fine=True)
    torque = fine.x.values
    bends, begins = [], []
    for speed, error in zip(
        fine.variables["mean_speed"], fine.variables["error_as_printed"], strict=True
    ):
        there = np.isfinite(speed)
        line = linregress(torque[there], speed[there])
        bends.append(
            np.nanmax(abs(speed - line.intercept - line.slope * torque)) / np.nanmax(speed)
        )
        far = np.flatnonzero(~(abs(error) < CLOSE))
        begins.append(torque[far[-1] + 1] if far.size else torque[0])
    return {"bend": max(bends), "begins": begins, "least": least_torques(session)[0]}


def speeds_of_figure_3(session: Session, who: str) -> Numbers:
    """Return how far the speeds of figure 3 are from the reference's, relative to them."""
    own, true = (speed_map(session, name).variables["mean_speed"] for name in (who, REFERENCE))
    return {"gap": np.nanmax(abs(own / true - 1))}


BELOW = 0.95
"""Share of the least torque at which there is no rotation any more."""


def least_torques(session: Session) -> Array:
    """Return the least torque (3,) [N m] of a rotation for each damper."""
    return session.once(
        (SCENE, "least torques"),
        lambda: np.array([least_torque(damped(c)).torque for c in DAMPINGS]),
    )


def least_torques_promised(session: Session) -> Numbers:
    """Return the least torque of a rotation for each damper, and the speed that (21) has there."""
    least = least_torques(session)
    sets = [damped(c, torque=torque) for c, torque in zip(DAMPINGS, least, strict=True)]
    return {"least": least, "promised": [float(printed_mean_speed(p)) for p in sets]}


def regimes_below(session: Session, who: str) -> Numbers:
    """Return the regime for each damper a little below the least torque of a rotation."""
    torques = BELOW * least_torques(session)
    if who == REFERENCE:
        kinds = [regime(damped(c, torque=t)) for c, t in zip(DAMPINGS, torques, strict=True)]
    else:
        at = points(who, damping=np.array(DAMPINGS), torque=torques)
        codes = QUANTITIES["regime"].evaluate(at).values["regime"]
        kinds = [REGIMES[int(code)] if code >= 0 else "failed" for code in codes]
    return {"regimes": kinds, "rotations": sum(kind != "rest" for kind in kinds)}


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


def slow_start(session: Session, who: str) -> Numbers:
    """Return what a start at 0.6 rad/s ends in, and how far the crank gets [rad]."""
    phi = recorded_motion(session, "start_slow", who).observables["phi"]
    return {"end": ending(session, "start_slow", who), "furthest": float(np.max(phi))}


def torques_of_rest(session: Session) -> Numbers:
    """Return the torques [N m] up to which positions of rest hold, by name."""
    torques = saddle_node_torques(EXAMPLE)
    return {"torques": torques, "largest": max(torques.values()), "torque": EXAMPLE.torque}


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


def regimes_over(session: Session, over: str) -> Numbers:
    """Return shares of the regimes over a parameter and the torque, and where none depends on it.

    Parameters
    ----------
    over : {"damping", "stiffness"}
    """
    plane = regime_map(session, over)
    regimes, shares = plane.variables["regime"], plane.shares()
    return {
        "shares": {name: share for name, share in shares.items() if share},
        "same": np.mean(np.all(regimes == regimes[:, :1], axis=1)),
        **shares,
    }


def agreement_over(session: Session, who: str, over: str) -> Numbers:
    """Return at which share of its robust points an engine has the reference's regime."""
    if who == REFERENCE:
        return {}
    share, count = agreement(session, over, who)
    return {"share": share, "count": count}


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

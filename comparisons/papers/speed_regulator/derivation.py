"""Measures of what the speed_regulator paper derives, sections 1-3 up to equation (20).

Its equations themselves are texts in ``claims.toml``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
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
from ....reference.speed_regulator.motions import mean_speed
from ....reference.speed_regulator.theory import PRINTED_REMAINDER, printed_mean_speed
from ...engines.registry import REFERENCE
from ...engines.run import call_engine
from ...queries.query import choose_engine
from ...queries.request import Query
from ...queries.simulate import simulate
from ..equations import Values
from ..ledger import Numbers, half_unit
from ..session import Session
from .results import EXAMPLE, SCENE, TURN, damped, recorded_motion, turn_speeds

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


def work_without_friction(session: Session) -> Numbers:
    """Return the relative error of the energy balance of a crank without damper.

    Its energy gains the motor's work. And the share of the time in which its speed falls.
    """
    phi, speed = (
        recorded_motion(session, "frictionless").observables[k] for k in ("phi", "phi_dot")
    )
    energy = get_scene(SCENE).energy([phi[[0, -1]]], [speed[[0, -1]]], coefficients(damped(0.0)))
    return {
        "error": abs((energy[1] - energy[0]) / (EXAMPLE.torque * (phi[-1] - phi[0])) - 1),
        "falls": np.mean(np.diff(speed) < 0),
    }


def slowest_gain(session: Session, who: str) -> float:
    """Return the least gain of speed [rad/s] from one turn to the next without friction."""
    return float(np.min(np.diff(turn_speeds(recorded_motion(session, "frictionless", who)))))


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
    """Return differences of phi'' that a linear law lacks: over the speed, and for twice the angle."""
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

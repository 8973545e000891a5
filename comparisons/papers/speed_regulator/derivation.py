"""Measures of what the speed_regulator paper derives, sections 1-3 up to equation (20).

Functions of (7)-(19), as printed and put right, take crank angles of any shape; rows of vectors
come first.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ....reference import get_scene
from ....reference.scene import Array
from ....reference.speed_regulator.equations import (
    SpeedRegulator,
    coefficients,
    outputs,
)
from ....reference.speed_regulator.motions import mean_speed
from ....reference.speed_regulator.theory import printed_mean_speed, rotation
from ...engines.registry import REFERENCE
from ...engines.run import call_engine
from ...queries.query import choose_engine
from ...queries.request import Query
from ...queries.simulate import simulate
from ..ledger import Numbers
from ..session import Session
from .results import EXAMPLE, SCENE, damped, recorded_motion, turn_speeds


class PrintedKinematics(NamedTuple):
    """Equations (2)-(12).

    Attributes
    ----------
    beta : array
    t, u : array
        (7), (10).
    places : array (5, ...)
        phi, x_C, y_C, -beta, y_B of (2), (3).
    a_1, a_2 : array (5, ...)
        (11), (12).
    """

    beta: Any
    t: Any
    u: Any
    places: Any
    a_1: Any
    a_2: Any


def kinematics(phi: Any, p: SpeedRegulator) -> PrintedKinematics:
    """Return what (2)-(12) say at crank angles, complex ones included."""
    r, l = p.crank_radius, p.rod_length
    ratio, sin, cos = r / l, np.sin(phi), np.cos(phi)
    beta = np.arcsin(ratio * cos)
    sin_b, cos_b = np.sin(beta), np.cos(beta)
    t = ratio * sin / cos_b
    u = ratio * cos / cos_b - t**2 * sin_b / cos_b
    places = [phi, r * cos - l / 2 * sin_b, r * sin - l / 2 * cos_b, -beta, r * sin - l * cos_b]
    a_1 = [
        1 + 0 * phi,
        -r * sin + l / 2 * t * cos_b,
        r * cos - l / 2 * t * sin_b,
        t,
        r * cos - l * t * sin_b,
    ]
    a_2 = [
        0 * phi,
        -r * cos + l / 2 * t**2 * sin_b + l / 2 * u * cos_b,
        -r * sin + l / 2 * t**2 * cos_b - l / 2 * u * sin_b,
        u,
        -r * sin + l * t**2 * cos_b - l * u * sin_b,
    ]
    return PrintedKinematics(beta, t, u, np.array(places), np.array(a_1), np.array(a_2))


def masses(p: SpeedRegulator) -> Array:
    """Return the diagonal of [m] in (13), the rod homogeneous."""
    rod = p.rod_mass * p.rod_length**2 / 12
    return np.array([p.flywheel_inertia, p.rod_mass, p.rod_mass, rod, p.slider_mass])


def reaction_matrix(phi: float, p: SpeedRegulator, printed: bool = False) -> Array:
    """Return [N] of (14) at one angle; row 4 as printed has lost the minus signs of (13)."""
    r, l = p.crank_radius, p.rod_length
    beta = float(kinematics(phi, p).beta)
    x, y = l / 2 * np.cos(beta), l / 2 * np.sin(beta) * (1 if printed else -1)
    return np.array(
        [
            [-r * np.sin(phi), r * np.cos(phi), 0, 0],
            [-1, 0, 1, 0],
            [0, -1, 0, 1],
            [x, y, x, y],
            [0, 0, 0, -1],
        ]
    )


def free_bodies(phi: float, speed: float, p: SpeedRegulator, printed: bool = False) -> Array:
    """Return phi'' and X_A, Y_A, X_B, Y_B by (14), its five rows solved together."""
    at = kinematics(phi, p)
    load = p.damping * at.a_1[4] * speed + spring(phi, p)
    external = np.array([p.torque, 0, 0, 0, -load])
    m = masses(p)
    matrix = np.column_stack([m * at.a_1, -reaction_matrix(phi, p, printed)])
    return np.asarray(np.linalg.solve(matrix, external - m * at.a_2 * speed**2))


def spring(phi: Any, p: SpeedRegulator) -> Any:
    """Return F_e: that of (13) where ``spring_rest`` is -l."""
    return p.stiffness * (kinematics(phi, p).places[4] - p.spring_rest)


def moment_of_inertia(phi: Any, p: SpeedRegulator) -> Any:
    """Return J(phi) of (18)."""
    a_1 = kinematics(phi, p).a_1
    return np.tensordot(masses(p), a_1 * a_1, 1)


def printed_slope(phi: Any, p: SpeedRegulator) -> Any:
    """Return J'(phi) as (18) prints it: half of the derivative."""
    at = kinematics(phi, p)
    return np.tensordot(masses(p), at.a_1 * at.a_2, 1)


def torque(phi: Any, speed: Any, p: SpeedRegulator) -> Any:
    """Return M of (19) by its first two lines."""
    y_phi = kinematics(phi, p).a_1[4]
    return p.torque - y_phi * (p.damping * speed * y_phi + spring(phi, p))


def acceleration(phi: Any, speed: Any, p: SpeedRegulator, factor: float = 2.0) -> Any:
    """Return phi'' by (17) with (18), (19); ``factor`` 1 takes J' as printed, 2 puts it right."""
    slope = factor * printed_slope(phi, p)
    return (torque(phi, speed, p) - slope * speed**2 / 2) / moment_of_inertia(phi, p)


SAMPLES = 4096
"""Of a turn; means of periodic functions are then exact to rounding up to lambda = 0.98."""


def averages(p: SpeedRegulator) -> dict[str, float]:
    """Return the means of section 3 over a turn of the crank.

    ``slope`` of J' over that of J; ``spring_19`` and ``spring_3`` of the spring's torque with the
    references of (19) and of section 3, over its amplitude; ``cos_squared``; ``remainder`` of
    t^2 sin^2 beta; ``mixed`` of t cos phi sin beta; ``damper`` of (r cos phi - l t sin beta)^2/l^2.
    """
    phi = 2 * np.pi * np.arange(SAMPLES) / SAMPLES
    at = kinematics(phi, p)
    y_phi, y, sin_b = at.a_1[4], at.places[4], np.sin(at.beta)
    near, far = y_phi * (p.rod_length + y), y_phi * (p.crank_radius + p.rod_length + y)
    means = {
        "slope": np.mean(printed_slope(phi, p)) / np.mean(moment_of_inertia(phi, p)),
        "spring_19": np.mean(near / np.max(abs(near))),
        "spring_3": np.mean(far / np.max(abs(far))),
        "cos_squared": np.mean(np.cos(phi) ** 2),
        "remainder": np.mean((at.t * sin_b) ** 2),
        "mixed": np.mean(at.t * np.cos(phi) * sin_b),
        "damper": np.mean(y_phi**2) / p.rod_length**2,
    }
    return {name: float(mean) for name, mean in means.items()}


ANGLES = 2 * np.pi * np.arange(64) / 64 + 0.05
SPEED = 5.07
PROBE = 1e-30
"""Complex step, far below rounding."""

RATIOS = tuple(
    EXAMPLE.replace(crank_radius=ratio * EXAMPLE.rod_length) for ratio in (0.05, 0.2, 0.5, 0.9)
)
"""The example with several lambda = r/l."""


def slope_of(values: Any) -> Any:
    """Return the derivative that a complex step has left in values."""
    return np.asarray(values).imag / PROBE


# Introduction and section 2


def work_without_friction(session: Session) -> Numbers:
    """Return by how much the energy that a crank without damper gains misses the motor's work.

    And the share of the time in which its speed falls.
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


def kinematic_error(session: Session) -> Numbers:
    """Compare (4)-(12) with derivatives of the positions, by complex steps, at two lambda.

    (5) with the speed 1, (8) with an acceleration of our choice.
    """
    errors, gain = [], 2.0
    for p in (EXAMPLE, EXAMPLE.replace(crank_radius=0.9)):
        at = kinematics(ANGLES, p)
        moved = kinematics(ANGLES + 1j * PROBE, p)
        r, l, sin_b, cos_b = p.crank_radius, p.rod_length, np.sin(at.beta), np.cos(at.beta)
        closure = r * np.cos(ANGLES) - l * sin_b
        in_5 = r * np.sin(ANGLES) + l * slope_of(moved.beta) * cos_b
        in_8 = r * gain * np.sin(ANGLES) + r * SPEED**2 * np.cos(ANGLES)
        in_8 -= l * (at.t * gain + at.u * SPEED**2) * cos_b + l * (at.t * SPEED) ** 2 * sin_b
        errors += [
            in_5,
            in_8 / SPEED**2,
            slope_of(moved.places) - at.a_1,
            slope_of(moved.a_1) - at.a_2,
            slope_of(moved.beta) + at.t,
            slope_of(moved.t) - at.u,
            closure,
        ]
    return {"error": max(float(np.max(abs(item))) for item in errors)}


def opening(session: Session, who: str) -> Numbers | str:
    """Return how far an engine's loop opens [m]; no words if it has none."""
    violation = recorded_motion(session, "start_8", who).observables.get("position_violation")
    return "" if violation is None else {"opening": np.max(violation)}


def slider_forces(session: Session) -> Numbers:
    """Compare F_a and F_e above (13) with the power of the damper and the slope of the energy.

    Both over the crank angle, relative to the largest.
    """
    p, c, scene = EXAMPLE, coefficients(EXAMPLE), get_scene(SCENE)
    r, l = p.crank_radius, p.rod_length
    at = kinematics(ANGLES, p)
    arm = r * np.cos(ANGLES) - l * at.t * np.sin(at.beta)
    spring = p.stiffness * (l + r * np.sin(ANGLES) - l * np.cos(at.beta)) * arm
    damper = p.damping * SPEED * arm * arm
    still = np.zeros_like(ANGLES)
    slope = slope_of(scene.energy([ANGLES + 1j * PROBE], [still], c))
    free = coefficients(p.replace(damping=0.0))
    rates = [scene.accelerations(0.0, [ANGLES], [still + SPEED], one)[0] for one in (free, c)]
    moment = moment_of_inertia(ANGLES, p)
    errors = spring - slope, damper - moment * (rates[0] - rates[1])
    sizes = np.max(np.abs(slope)), np.max(np.abs(damper))
    return {"error": max(np.max(np.abs(e)) / size for e, size in zip(errors, sizes, strict=True))}


def reactions(session: Session, who: str) -> Numbers | str:
    """Compare reactions with those of (13), its five rows solved together."""
    phi = np.array([0.3, 1.9, 4.4])
    exact = outputs(phi[None], np.full((1, 3), SPEED), coefficients(EXAMPLE))
    names = ("reaction_a_x", "reaction_a_y", "reaction_b_x", "reaction_b_y")
    if who == REFERENCE:
        solved = np.array([free_bodies(q, SPEED, EXAMPLE) for q in phi]).T
        own: Numbers = dict(zip(names, solved[1:], strict=True))
    else:
        case = Query(SCENE).case
        engine, model = choose_engine(who, case, None)
        if not set(names) <= set(engine.bind(case, model).reaction_names):
            return "does not tell"
        states = np.stack([phi, np.full(3, SPEED)], axis=1)
        own = call_engine(lambda: engine.bind(case, model).reactions(np.zeros(3), states))
    size = max(float(np.max(abs(exact[name]))) for name in names)
    return {"error": max(float(np.max(abs(own[name] - exact[name]))) for name in names) / size}


def work_of_reactions(as_printed: bool) -> Numbers:
    """Return the largest part of A_1^T [N], over the rod's length."""
    parts = [
        kinematics(phi, EXAMPLE).a_1 @ reaction_matrix(phi, EXAMPLE, as_printed)
        for phi in map(float, ANGLES)
    ]
    return {"work": float(np.max(np.abs(parts))) / EXAMPLE.rod_length}


def accelerations_17(session: Session, who: str) -> Numbers:
    """Compare accelerations with the reference's: by (17)-(19), or an engine's own."""
    phi = ANGLES[::4]
    speed = SPEED * np.linspace(-1, 1, len(phi))
    exact = get_scene(SCENE).accelerations(0.0, [phi], [speed], coefficients(EXAMPLE))[0]

    def error(values: Any) -> float:
        return float(np.max(abs(values - exact)) / np.max(abs(exact)))

    if who == REFERENCE:
        right, wrong = (acceleration(phi, speed, EXAMPLE, factor) for factor in (2, 1))
        return {"error": error(right), "as_printed": error(wrong)}
    case = Query(SCENE).case
    engine, model = choose_engine(who, case, None)
    states = np.stack([phi, speed], axis=1)
    own = call_engine(lambda: engine.bind(case, model).accelerations(np.zeros(len(phi)), states))
    return {"error": error(own[:, 0]), "model": model}


def crank_angle_error(session: Session, who: str) -> float:
    """Return how far the crank angle is from the reference's within 10 s from 8 rad/s [rad]."""
    truth, own = (recorded_motion(session, "start_8", name) for name in (REFERENCE, who))
    return float(np.max(abs(own.observables["phi"] - truth.observables["phi"])[truth.times <= 10]))


def taken_up_again(session: Session) -> Numbers:
    """Return how far a motion that is taken up again a second later is from the first [rad]."""
    times = np.arange(1, 17) / 8
    first = simulate(SCENE, state={"phi": 0.4, "phi_dot": SPEED}, times=times)
    half = {k: float(first.observables[k][7]) for k in ("phi", "phi_dot")}
    again = simulate(SCENE, state=half, times=times[:8])
    return {"error": np.max(abs(again.observables["phi"] - first.observables["phi"][8:]))}


def nonlinearity(session: Session) -> Numbers:
    """Return by how much equal steps of the speed, and twice the angle, change phi'' unequally."""

    def rate(phi: float, speed: float) -> float:
        return float(get_scene(SCENE).accelerations(0.0, [phi], [speed], coefficients(EXAMPLE))[0])

    still, slow, fast = (rate(0.7, speed) for speed in (0.0, 3.0, 6.0))
    return {
        "bend": abs(fast - 2 * slow + still) / abs(slow - still),
        "uneven": abs(rate(1.4, 0.0) - 2 * still),
    }


# Averages of section 3


def largest_mean(*names: str) -> Numbers:
    """Return the largest modulus of some means of section 3, for several lambda."""
    return {"mean": max(abs(averages(p)[name]) for p in RATIOS for name in names)}


def mean_spring(session: Session) -> Numbers:
    """Return the largest mean torque of the spring, and speeds [rad/s] with several springs."""
    speeds = [rotation(EXAMPLE.replace(stiffness=k)).mean_speed for k in (0.0, 32.0, 64.0)]
    return {**largest_mean("spring_19", "spring_3"), "speeds": speeds}


def remainder(session: Session) -> Numbers:
    """Return the mean of t^2 sin^2 beta, by samples and in closed form."""
    ratio = EXAMPLE.crank_radius / EXAMPLE.rod_length
    closed = 1 - math.sqrt(1 - ratio**2) - ratio**2 / 2
    return {"value": averages(EXAMPLE)["remainder"], "exact": closed}


def remainder_everywhere(session: Session) -> Numbers:
    """Return that mean for several lambda, and the error that 0.000204 makes of (21)."""
    means = {f"{p.crank_radius / p.rod_length:g}": averages(p)["remainder"] for p in RATIOS}
    errors = [float(printed_mean_speed(p) / mean_speed(p) - 1) for p in RATIOS]
    ratios = np.array([p.crank_radius / p.rod_length for p in RATIOS])
    exact = 1 - np.sqrt(1 - ratios**2)
    return {
        "closed": np.max(abs(np.array([averages(p)["damper"] for p in RATIOS]) / exact - 1)),
        "means": [f"{mean:.3g} at {ratio}" for ratio, mean in means.items()],
        "errors": errors,
        "largest": max(map(abs, errors)),
    }


def mean_damper(session: Session) -> Numbers:
    """Return the mean torque of the damper by (20), in c l^2 omega_1, and by samples."""
    mean = averages(EXAMPLE)["damper"]
    by_20 = 0.5 * (EXAMPLE.crank_radius / EXAMPLE.rod_length) ** 2 + 0.000204
    return {"mean": mean, "printed": by_20, "error": abs(by_20 / mean - 1)}

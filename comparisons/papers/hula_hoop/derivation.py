"""Measures of the hula_hoop paper's equations and approximate solutions, sections 1-4.

An identity is judged at one motion of the form (16), (17) that solves nothing, `TRIAL`.
"""

from __future__ import annotations

from dataclasses import replace
from math import factorial
from typing import Any

import numpy as np
from scipy.special import jv

from ....reference import get_scene
from ....reference.hula_hoop.equations import (
    SEMICIRCLE,
    coefficients,
    energy,
    orbit_guesses,
)
from ....reference.hula_hoop.floquet import floquet_multipliers, variational_coefficients
from ....reference.hula_hoop.theory import (
    ApproximateSolution,
    balance_residuals,
    corrected_solution,
    nondimensional,
    paper_solution,
    refined_solution,
)
from ....reference.scene import Array
from ...checks.kinds.algebra import random_states
from ...engines.equations import scene_equations
from ...engines.registry import REFERENCE
from ...engines.run import contained
from ...queries.query import Query, choose_engine
from ..ledger import Numbers
from ..session import Session
from .results import (
    APPROXIMATIONS,
    EXAMPLE,
    SCENE,
    apart,
    approximation_errors,
    example_rotation,
    grid,
    is_class,
    motion_map,
    own_maps,
    samples,
    stability_map,
    stable,
    states,
)

PHASES = 2 * np.pi * np.arange(256) / 256
LINEAR = np.random.default_rng(14).normal(size=(2, 3, 3))
FUNCTIONS = np.random.default_rng(18).normal(size=(4, 3))
"""Operators, and U_0, V_1, V_2, f, by which orders in p are told apart."""
TRIAL = ApproximateSolution(
    alpha=0.8, q_1=1.3, beta=0.5, u_1=0.3, gamma=0.7, theta_0=0.0, residual=np.nan
)


# Sections 1, 2


def uniform_rotation(session: Session) -> Numbers:
    """Return the largest errors of theta [rad] of the printed solution and a uniform rotation.

    And that of y, over its largest value.
    """
    truth = states(example_rotation(session))
    start = orbit_guesses(EXAMPLE)[0]
    turning = start[1] + start[3] * samples(1.0)
    gap = apart(np.array([0 * turning, turning, 0 * turning, 0 * turning + start[3]]), truth)
    (y_error, error, *_), uniform = approximation_errors(session)["paper"], gap[1].max()
    return {
        "y_error": y_error / np.abs(truth[0]).max(),
        "error": error,
        "uniform": uniform,
        "ratio": error / uniform,
    }


def equations_of_motion(session: Session, who: str) -> Numbers:
    """Return errors at random states: of (7), (8), or of the accelerations of an engine."""
    case = Query(SCENE).case
    scene = get_scene(SCENE)
    times, points = random_states(scene_equations(case), case, scene.coordinates)
    derivative = scene.right_hand_side(case.parameters)
    truth = np.array([derivative(t, x)[2:] for t, x in zip(times, points, strict=True)])
    if who == REFERENCE:
        return {"error": residual_of_7_8(times, points, truth), "count": len(times)}
    engine, model = choose_engine(who, case, None)
    with contained():
        own = engine.accelerations(case, model, times, points)
    return {"error": float(np.abs(own - truth).max() / np.abs(truth).max())}


def residual_of_7_8(times: Array, points: Array, rates: Array) -> float:
    """Return the largest residual of (7), (8), in q = y / R and tau = omega_n t.

    Parameters
    ----------
    times : array (n,) [s]
    points, rates : array (n, 4), (n, 2)
        States, and second derivatives of y and theta [m/s^2, rad/s^2].
    """
    c, p = nondimensional(EXAMPLE), EXAMPLE
    y, theta, y_dot, theta_dot = points.T
    length, rate = p.rod_length, p.omega_n
    q_2, theta_2 = rates[:, 0] / (length * rate**2), rates[:, 1] / rate**2
    coupling = theta_2 * np.cos(theta) - (theta_dot / rate) ** 2 * np.sin(theta)
    drive = c.force * np.cos(2 * np.pi * p.force_frequency * times)
    slide = q_2 + 2 * c.rho * y_dot / (length * rate) + y / length + c.epsilon * coupling - drive
    hinge = c.inertia * theta_2 + c.zeta_m * theta_dot / rate + q_2 * np.cos(theta)
    return float(np.abs([slide, hinge]).max() / (np.abs(q_2).max() + np.abs(theta_2).max()))


def plate_inertia(session: Session, expected: float = SEMICIRCLE) -> Numbers:
    """Return I_eq of the semicircular plate by quadrature over the half disc, and as it is used."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    radius, angle = (1 + nodes[:, None]) / 2, np.pi * (1 + nodes[None]) / 2
    share = weights[:, None] * weights[None] * radius  # of the area, in the polar plane
    centre = np.sum(share * radius * np.sin(angle)) / np.sum(share)
    ratio = np.sum(share * radius**2) / np.sum(share) / centre**2 - 1
    return {"ratio": ratio, "expected": expected, "error": abs(ratio - expected)}


# Section 3


def even_harmonics(session: Session) -> Numbers:
    """Return the largest even harmonic of the nonlinear terms of (7), over all of them."""
    motion = TRIAL.motion(PHASES / TRIAL.alpha)
    terms = motion.theta_dot**2 * np.sin(motion.theta), motion.theta_ddot * np.cos(motion.theta)
    spectra = np.abs(np.fft.rfft(terms))
    return {"share": np.max(np.max(spectra[:, 0:7:2], axis=1) / np.max(spectra, axis=1))}


def first_order(session: Session) -> Numbers:
    """Return by how much (36), (46) and (47) miss the harmonics of (7), (8) at small amplitudes.

    Over the amplitudes, to which they are of first order.
    """
    c, size = nondimensional(EXAMPLE), 1e-6
    a, q_1, u_1, b, g = c.alpha, TRIAL.q_1 * size, TRIAL.u_1 * size, TRIAL.beta, TRIAL.gamma
    small = replace(TRIAL, alpha=a, q_1=q_1, u_1=u_1)
    along, _, _, cosine, sine = balance_residuals(small, EXAMPLE)
    damped, heavy = 2 * c.zeta_m * u_1 * a, 4 * c.inertia * a**2 * u_1
    in_36 = q_1 * ((1 - a**2) * np.cos(b) + 2 * c.rho * a * np.sin(b))
    in_36 -= c.epsilon * a**2 * u_1 * np.cos(g) / 2 + c.force
    in_46 = -heavy * np.sin(g) - damped * np.cos(g) - q_1 * a**2 * np.sin(b) / 2
    in_47 = -heavy * np.cos(g) + damped * np.sin(g) - q_1 * a**2 * np.cos(b) / 2
    errors = {"(36)": along - in_36, "(46)": sine - in_46, "(47)": cosine - in_47}
    return {
        "errors": {name: float(abs(error)) / q_1 for name, error in errors.items()},
        "largest": float(max(abs(error) for error in errors.values())) / q_1,
    }


def correction_34(s: float, c: float, alpha: float) -> tuple[Array, Array]:
    """Return tau (400,), and V_1q of (34) with two derivatives; s, c stand with sine and cosine."""
    tau = np.linspace(0, 40, 400)
    scales = np.array([s * alpha, c, -s, -c])[:, None] / (1 - alpha**2)
    speeds = np.array([1, 1, alpha, alpha])[:, None]
    starts = np.array([0, np.pi / 2, 0, np.pi / 2])[:, None]  # sine, cosine, sine, cosine
    waves = [
        np.sum(scales * speeds**k * np.sin(speeds * tau + starts + k * np.pi / 2), axis=0)
        for k in range(3)
    ]
    return tau, np.array(waves)


def solution_34(session: Session) -> Numbers:
    """Return by how much (34) misses V'' + V = -(S sin(alpha tau) + C cos(alpha tau)), and rest."""
    alpha, s, c = float(nondimensional(EXAMPLE).alpha), 0.7, -0.4
    tau, (value, rate, bent) = correction_34(s, c, alpha)
    left = np.max(abs(bent + value + s * np.sin(alpha * tau) + c * np.cos(alpha * tau)))
    return {"error": float(max(left, abs(value[0]), abs(rate[0])))}


def approximation(session: Session) -> Numbers:
    """Return the largest correction (34) where (35), (36) hold, over q_1."""
    solution, c = paper_solution(EXAMPLE), nondimensional(EXAMPLE)
    alpha, q_1, beta = float(c.alpha), float(solution.q_1), float(solution.beta)
    spring, damper = (1 - alpha**2) * q_1, 2 * float(c.rho) * q_1 * alpha
    inertial = float(c.epsilon) * alpha**2
    s = spring * np.sin(beta) - damper * np.cos(beta) - inertial
    force = float(c.force)
    k = spring * np.cos(beta) + damper * np.sin(beta)
    k -= inertial * float(solution.u_1) * np.cos(float(solution.gamma)) / 2 + force
    return {"correction": np.max(np.abs(correction_34(s, k, alpha)[1][0])) / abs(q_1)}


def printed_energies(session: Session) -> Numbers:
    """Return by how much (1) and (2) miss the scene's energy at random states, relative."""
    p, random = EXAMPLE, np.random.default_rng(1)
    c, errors = coefficients(p), []
    for _ in range(16):
        (y, theta), (y_dot, turn) = random.normal(size=(2, 2)) * [[0.01, 1], [1, 20]]
        x_f = -p.rod_length * turn * np.sin(theta)
        y_f = y_dot + p.rod_length * turn * np.cos(theta)
        printed = p.main_mass * y_dot**2 + p.free_mass * (x_f**2 + y_f**2) + p.stiffness * y**2
        truth = energy((y, theta), (y_dot, turn), c)
        errors.append(abs(printed / 2 / truth - 1))
    return {"error": max(errors)}


def orders(p: Any, other: Any = 0.0, known: Any = FUNCTIONS[3]) -> Any:
    """Return (14) with (18) at p, with random operators and functions.

    These are matrices for L, products of sines for N. With what else stands in N, and without a
    known function, it is (15) with (19).
    """
    linear, mixing = LINEAR
    start, first, second, _ = FUNCTIONS
    v = start + p * first + p**2 * second
    nonlinear = mixing @ np.sin(v + other)
    return linear @ (v - start) + p * linear @ start + p * (nonlinear - known)


def homotopy(session: Session) -> Numbers:
    """Return by how much (11) differs from (10), and at p = 0, 1 from (12), (13).

    With random values for L(V), L(U_0), N(V) and f. And how much (21), (22) are off as the first
    two orders of (14), and (38), (39) as those of (15).
    """
    linear, start, nonlinear, force = np.random.default_rng(11).normal(size=4)

    def in_11(p: float) -> float:
        return float(linear - start + p * start + p * (nonlinear - force))

    def in_10(p: float) -> float:
        return float((1 - p) * (linear - start) + p * (linear + nonlinear - force))

    ends = in_11(0.0) - (linear - start), in_11(1.0) - (linear + nonlinear - force)
    (matrix, mixing), (initial, first, of_slide, force_of_14) = LINEAR, FUNCTIONS
    series = []
    for other, known in ((0.0, force_of_14), (of_slide, 0.0)):
        first_order = matrix @ first + mixing @ np.sin(initial + other) + matrix @ initial - known
        series.append(np.max(np.abs(orders(0.0, other, known))))
        own = orders(1e-30j, other, known).imag / 1e-30
        series.append(np.max(np.abs(own - first_order)))
    return {"error": max(abs(in_11(0.3) - in_10(0.3)), *map(abs, ends), *series)}


def second_order(as_printed: bool) -> float:
    """Return the error of the second order of (20), whose N is taken at V_1 as printed."""
    (matrix, mixing), (initial, first, second, _) = LINEAR, FUNCTIONS
    right = matrix @ second + mixing @ (np.cos(initial) * first)
    own = matrix @ second + mixing @ np.sin(first) if as_printed else right
    step = 1e-4
    truth = (orders(step) - 2 * orders(0.0) + orders(-step)) / step**2 / 2
    return float(np.max(np.abs(own - truth)))


def bessel_series(session: Session) -> Numbers:
    """Return the largest error of ten terms of (26) against J_0 ... J_5 at |u_1| = 0.5 and 2."""
    errors = [
        abs(
            (u / 2) ** n
            * sum((-(u**2) / 4) ** k / (factorial(k) * factorial(n + k)) for k in range(10))
            - jv(n, u)
        )
        for u in (0.5, 2.0)
        for n in range(6)
    ]
    return {"error": max(errors)}


def harmonic(values: Array, order: int) -> tuple[float, float]:
    """Return the coefficients of cosine and sine of one order in samples over `PHASES`."""
    wave = np.mean(2 * values * np.exp(1j * order * PHASES))
    return wave.real, wave.imag


def expansions(session: Session) -> Numbers:
    """Return errors of (28), of (31), and of (42) with its mean (44), at `TRIAL`."""
    motion = TRIAL.motion(PHASES / TRIAL.alpha)
    a, u, g, b = TRIAL.alpha, TRIAL.u_1, TRIAL.gamma, TRIAL.beta
    j, f = jv(np.arange(4), u), 2 * TRIAL.alpha
    sin, cos = np.sin(g), np.cos(g)
    square, mixed, bend = u**2 * f**2 / 2, -2 * a * u * f, -u * f**2
    both = (a**2 + square) * j[1] + mixed * (j[0] + j[2]) / 2 - square * (j[1] - j[3]) / 2
    in_28 = both * cos, (a**2 + square) * j[0] + both * sin + square * j[2]
    in_31 = bend * (j[0] - j[2]) / 2 * cos, -bend * j[1] + bend * (j[0] - j[2]) / 2 * sin
    half = -TRIAL.q_1 * a**2 / 2
    in_42 = (
        half * (j[0] * np.cos(b) - j[2] * np.cos(b - 2 * g))
        - half * j[1] * (np.sin(b + g) + np.sin(b - g)),
        half * (j[0] * np.sin(b) + j[2] * np.sin(b - 2 * g))
        + half * j[1] * (np.cos(b + g) - np.cos(b - g)),
    )
    torque = motion.q_ddot * np.cos(motion.theta)
    pairs = {
        "(28)": (in_28, harmonic(motion.theta_dot**2 * np.sin(motion.theta), 1)),
        "(31)": (in_31, harmonic(motion.theta_ddot * np.cos(motion.theta), 1)),
        "(42)": (in_42, harmonic(torque, 2)),
        "its mean": (half * (j[0] * np.cos(b) + j[1] * np.sin(b - g)), np.mean(torque)),
    }
    errors = {name: float(np.max(np.abs(np.subtract(*pair)))) for name, pair in pairs.items()}
    return {"errors": errors, "largest": max(errors.values())}


def variations(session: Session) -> Numbers:
    """Return by how much (57)-(61) miss a small change of `TRIAL` put into (7) and (8)."""
    tau, change = PHASES / TRIAL.alpha, 1e-5
    c, motion = nondimensional(EXAMPLE), TRIAL.motion(tau)
    shift, shift_1, shift_2 = np.cos(3 * tau), -3 * np.sin(3 * tau), -9 * np.cos(3 * tau)
    f_u, psi = 2 * TRIAL.alpha, 2 * PHASES - TRIAL.gamma
    sine, cosine = np.sin(motion.theta), np.cos(motion.theta)
    wave = -TRIAL.u_1 * f_u * np.sin(psi)
    p_1, p_2 = c.epsilon * cosine, -2 * c.epsilon * (wave + TRIAL.alpha) * sine
    bend = -TRIAL.u_1 * f_u**2 * np.cos(psi)
    p_3 = -c.epsilon * ((TRIAL.alpha + wave) ** 2 * cosine + bend * sine)
    p_4 = TRIAL.q_1 * TRIAL.alpha**2 * np.cos(PHASES - TRIAL.beta) * sine / c.inertia

    def slide(size: float) -> Array:
        theta = motion.theta + size * shift
        bent: Array = (motion.theta_ddot + size * shift_2) * np.cos(theta)
        return c.epsilon * (bent - (motion.theta_dot + size * shift_1) ** 2 * np.sin(theta))

    def hinge(size: float) -> Array:
        q_2 = motion.q_ddot + size * shift_2
        pull: Array = q_2 * np.cos(motion.theta + size * shift)
        return pull / c.inertia

    slopes = [(of(change) - of(-change)) / (2 * change) for of in (slide, hinge)]
    printed = (
        p_1 * shift_2 + p_2 * shift_1 + p_3 * shift,
        p_4 * shift + cosine / c.inertia * shift_2,
    )
    return {"error": float(np.max(np.abs(np.subtract(slopes, printed))))}


def bessel(session: Session) -> Numbers:
    """Return errors of the simplified Bessel functions (27) at |u_1| = 0.5."""
    u = 0.5
    errors = {
        "J_0": abs(1 / jv(0, u) - 1),
        "J_1": abs(u / 2 / jv(1, u) - 1),
        "J_2 against J_0": jv(2, u),
        "J_3 against J_0": jv(3, u),
    }
    return {"errors": errors, "largest": max(errors.values())}


def secular_terms(session: Session) -> Numbers:
    """Return how the correction after (34) grows, in each half of 3000 periods of the spring.

    It is what 2 rho q' of (34) drives, q'' + q = 2 rho (sin(tau) - alpha sin(alpha tau)), over
    rho and the coefficients of (34).
    """
    alpha = float(nondimensional(EXAMPLE).alpha)
    tau = np.linspace(0, 2e4, 200_001)
    resonant = (np.sin(tau) - tau * np.cos(tau)) / 2
    forced = alpha * (np.sin(alpha * tau) - alpha * np.sin(tau)) / (1 - alpha**2)
    wave = 2 * np.abs(resonant - forced) / abs(1 - alpha**2)
    early, late = (half.max() for half in np.split(wave[:-1], 2))
    return {"early": early, "late": late, "growth": late / early}


def mean_balance(session: Session) -> Numbers:
    """Return mean torques over the friction without and with theta_0, and what theta_0 gains."""
    c = nondimensional(EXAMPLE)
    torques = {
        name: float(abs(balance_residuals(APPROXIMATIONS[name](EXAMPLE), EXAMPLE)[2]))
        / float(c.zeta_m * c.alpha)
        for name in ("paper", "corrected")
    }
    errors = approximation_errors(session)
    return {
        **torques,
        "phase": float(corrected_solution(EXAMPLE).theta_0),
        "gain": errors["paper"][1] / errors["corrected"][1],
    }


def dropped_torque(session: Session) -> Numbers:
    """Return what terms of second order change of u_1 where |u_1| < 0.5 in figure 4.

    In the median and at most, and at which share of the points by a tenth or less.
    """
    paper, full = (solve(grid(session, False)).u_1 for solve in (paper_solution, refined_solution))
    gap = np.abs(np.abs(full / paper) - 1)[np.abs(paper) < 0.5]
    return {"median": np.median(gap), "largest": np.max(gap), "within": np.mean(gap <= 0.1)}


def closed_form(session: Session) -> Numbers:
    """Return the largest residual of (49)-(52) over the grids of figures 4 and 6."""
    residuals = [paper_solution(grid(session, plate)).residual for plate in (False, True)]
    return {"residual": np.max(residuals)}


# Section 4


def rate_moduli(solution: ApproximateSolution, count: int = 64) -> Array:
    """Return moduli of the eigenvalues of A(tau) of (62) over one period, (count, 4)."""
    c = nondimensional(EXAMPLE)
    tau = 2 * np.pi / c.alpha * np.arange(count) / count
    p_1, p_2, p_3, p_4, p_5 = variational_coefficients(solution, EXAMPLE, tau)
    one, none = np.ones(count), np.zeros(count)
    mass = np.array([[one, p_1], [p_5, one]])
    right = -np.array(
        [[one, p_3, 2 * c.rho * one, p_2], [none, p_4, none, c.zeta_m / c.inertia * one]]
    )
    lower = np.linalg.solve(np.moveaxis(mass, -1, 0), np.moveaxis(right, -1, 0))
    upper = np.broadcast_to(np.eye(2, 4, 2), (count, 2, 4))
    return np.abs(np.linalg.eigvals(np.concatenate([upper, lower], axis=1)))


def eigenvalues(session: Session) -> Numbers:
    """Return how often A(tau) has an eigenvalue above 1, and the largest multiplier."""
    solution = corrected_solution(EXAMPLE)
    return {
        "above": np.mean(rate_moduli(solution).max(axis=1) > 1),
        "largest": float(abs(floquet_multipliers(solution, EXAMPLE)[0])),
    }


def unstable_seen(session: Session) -> Numbers:
    """Count robust points of figure 5 with a periodic motion where a rotation is unstable."""
    motion = motion_map(session, False)
    hoop = is_class(motion, "motion", "blue_o") & motion.robust
    periodic = hoop & (motion.variables["periods"] == 1)
    counts = {
        name: int(np.sum(~stable(session, False, name) & periodic)) for name in ("paper", "exact")
    }
    total = int(periodic.sum())
    return {**counts, "count": counts["exact"], "total": total, "more": int(hoop.sum()) - total}


def unstable_seen_by(session: Session, who: str) -> Numbers:
    """Count the same by an engine's own maps."""
    if who == REFERENCE:
        return {}
    calm, _, periodic = own_maps(session, False, who)
    return {"count": np.sum(periodic & ~calm), "total": np.sum(periodic)}


def stable_elsewhere(session: Session) -> Numbers:
    """Return where motions from rest end that do not reach a stable true rotation.

    And the largest multiplier of these rotations.
    """
    motion = motion_map(session, False)
    here = stable(session, False, "exact") & motion.robust
    elsewhere = here & ~is_class(motion, "motion", "blue_o")
    return {
        "share": elsewhere.sum() / here.sum(),
        "multiplier": stability_map(session, False).variables["multiplier"][here].max(),
        "total": int(here.sum()),
        "kinds": {
            name.replace("_", " "): int(np.sum(elsewhere & is_class(motion, "motion", name)))
            for name in motion.about["motion"].classes[1:]
        },
    }

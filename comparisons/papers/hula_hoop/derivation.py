"""The ledger of the hula_hoop paper, sections 1-4: equations, approximate solutions, stability.

An identity is judged at one motion of the form (16), (17) that solves nothing, `TRIAL`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.special import jv

from ....reference import get_scene
from ....reference.hula_hoop.equations import SEMICIRCLE, HulaHoop, orbit_guesses
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
from ...engines.run import contained
from ...queries.query import Query, choose_engine
from ..ledger import CORRECTED, NOT_REPRODUCED, NOT_TESTABLE, Finding, Row, claimed
from ..session import Session
from .results import (
    EXAMPLE,
    SCENE,
    apart,
    approximation_errors,
    everyone,
    example_orbit,
    example_rotation,
    grid,
    is_class,
    motion_map,
    own_maps,
    samples,
    stable,
    states,
)

TESTS = "tests/test_hula_hoop_paper.py::"
THEORY_TESTS = "tests/test_hula_hoop_theory.py::"

ROUNDING = 1e-10
"""Relative residual below which an identity holds."""
SMALL = 0.1
"""Relative error that may be called an approximation."""

PHASES = 2 * np.pi * np.arange(256) / 256
TRIAL = ApproximateSolution(
    alpha=0.8, q_1=1.3, beta=0.5, u_1=0.3, gamma=0.7, theta_0=0.0, residual=np.nan
)


def misprint(printed: float, corrected: float, what: str, within: float = ROUNDING) -> Finding:
    """Judge a misprint: the printed formula fails an identity, the corrected one does not."""
    holds = corrected < within < SMALL * printed
    reason = f"{what}: off by {printed:.3g} as printed, by {corrected:.1g} corrected"
    return Finding(CORRECTED if holds else NOT_REPRODUCED, reason)


def per_engine(session: Session, find: Any) -> dict[str, str]:
    """Return what each engine says."""
    return {name: find(name) for name in session.engines}


# Sections 1, 2


def rotation_from_shaking(session: Session) -> Finding:
    """Linear motion of the main mass is turned into rotation."""
    reports = {name: example_orbit(session, name) for name in everyone(session)}
    words = {
        name: f"one turn per period, stable: {o.stable}, multiplier "
        f"{abs(o.floquet_multipliers[0]):.6f}"
        for name, o in reports.items()
    }
    truth = words.pop("reference")
    holds = all(report.stable for report in reports.values())
    reason = "a stable rotation exists at 3 Hz and 60 N"
    return claimed(holds, reason, reference=truth, engines=words)


def energy_scavenging(session: Session) -> Finding:
    """A generator could be driven."""
    power = example_orbit(session).power
    return Finding(
        NOT_TESTABLE,
        "the equations have no generator; the hinge friction, the only load there is, takes "
        f"{-power['hinge']:.3g} W of the {power['force']:.3g} W that the force puts in at "
        "3 Hz and 60 N",
        reference=f"{-power['hinge']:.3g} W",
        engines=per_engine(
            session, lambda name: f"{-example_orbit(session, name).power['hinge']:.3g} W"
        ),
    )


def better_than_simple(session: Session) -> Finding:
    """The homotopy method is chosen for better approximate solutions."""
    truth = states(example_rotation(session))
    start = orbit_guesses(EXAMPLE)[0]
    turning = start[1] + start[3] * samples(1.0)
    gap = apart(np.array([0 * turning, turning, 0 * turning, 0 * turning + start[3]]), truth)
    error = approximation_errors(session)["paper"][1]
    return claimed(
        bool(error < gap[1].max()),
        f"theta is off by up to {error:.2f} rad; a uniform rotation whose phase balances the "
        f"mean torque, with no oscillation at all, by {gap[1].max():.2f} rad. To first order "
        "the method is harmonic balance with the mean balance left out",
        reference=f"{error:.2f} rad",
    )


def equations_of_motion(session: Session) -> Finding:
    """Equations (1)-(8), by the accelerations of engines that know nothing of them."""
    case = Query(SCENE).case
    scene = get_scene(SCENE)
    own = scene_equations(case)
    times, points = random_states(own, case, scene.coordinates)
    derivative = scene.right_hand_side(case.parameters)
    truth = np.array([derivative(t, x)[2:] for t, x in zip(times, points, strict=True)])
    # (7), (8) in q = y / R and tau = omega_n t
    c, p = nondimensional(EXAMPLE), EXAMPLE
    y, theta, y_dot, theta_dot = points.T
    length, rate = p.rod_length, p.omega_n
    q_2, theta_2 = truth[:, 0] / (length * rate**2), truth[:, 1] / rate**2
    coupling = theta_2 * np.cos(theta) - (theta_dot / rate) ** 2 * np.sin(theta)
    drive = c.force * np.cos(2 * np.pi * p.force_frequency * times)
    slide = q_2 + 2 * c.rho * y_dot / (length * rate) + y / length + c.epsilon * coupling - drive
    hinge = c.inertia * theta_2 + c.zeta_m * theta_dot / rate + q_2 * np.cos(theta)
    size = np.abs(q_2).max() + np.abs(theta_2).max()
    residual = float(np.abs([slide, hinge]).max() / size)
    off: dict[str, float] = {}
    for name in session.engines:
        engine, model = choose_engine(name, case, None)
        with contained():
            found = engine.accelerations(case, model, times, points)
        off[name] = float(np.abs(found - truth).max() / np.abs(truth).max())
    return claimed(
        max([residual, *off.values()]) < 1e-8,
        f"(7), (8) hold to {residual:.1g} at {len(times)} random states",
        reference=f"residual of (7), (8) {residual:.1g}",
        engines={name: f"accelerations off by {value:.1g}" for name, value in off.items()},
    )


def lost_dots(session: Session) -> Finding:
    """Speed of the free mass and the damper's force, below fig. 1 and below (4)."""
    theta, speed = 0.7, 3.0
    change = 1e-6
    x_dot = (np.cos(theta + speed * change) - np.cos(theta - speed * change)) / (2 * change)
    printed, corrected = (abs(x_dot + s * np.sin(theta)) for s in (theta, speed))
    return misprint(
        float(printed),
        float(corrected),
        "d(cos theta)/dt is -theta' sin theta, and a damper's force is c y'; (1) and (5) have the "
        "dots, which our copy of the text may have lost",
        within=1e-8,
    )


def plate_inertia(session: Session) -> Finding:
    """I_eq of the semicircular plate, by quadrature over the half disc."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    radius, angle = (1 + nodes[:, None]) / 2, np.pi * (1 + nodes[None]) / 2
    share = weights[:, None] * weights[None] * radius  # of the area, in the polar plane
    centre = np.sum(share * radius * np.sin(angle)) / np.sum(share)
    about_pin = np.sum(share * radius**2) / np.sum(share)
    ratio = about_pin / centre**2 - 1
    return claimed(
        bool(abs(ratio - SEMICIRCLE) < ROUNDING),
        f"hinged at the middle of its straight edge, its centre of mass at R_m: {ratio:.5f} by "
        f"quadrature, 9 pi^2/32 - 1 = {SEMICIRCLE:.5f}",
        reference=f"{ratio:.5f}",
    )


# Section 3


def ansatz_harmonics(session: Session) -> Finding:
    """The ansatz (16), (17): y at omega, theta at 2 omega."""

    def shares(name: str) -> tuple[float, float]:
        y, theta = (
            {term.order: term.amplitude for term in example_orbit(session, name).harmonics[of][1]}
            for of in ("y", "theta")
        )
        return (
            max(a for order, a in y.items() if order != 1) / y[1],
            max(a for order, a in theta.items() if order != 2) / theta[2],
        )

    def words(name: str) -> str:
        return "next harmonic of y {:.2%}, of theta {:.2%}".format(*shares(name))

    return claimed(
        max(shares("reference")) < SMALL,
        "of the true rotation at 3 Hz and 60 N: y has odd harmonics alone, theta even ones",
        reference=words("reference"),
        engines=per_engine(session, words),
    )


def trial_terms() -> tuple[Array, Array, Array]:
    """Return theta, theta' and theta'' of the trial motion over one period."""
    motion = TRIAL.motion(PHASES / TRIAL.alpha)
    return motion.theta, motion.theta_dot, motion.theta_ddot


def no_even_harmonics(session: Session) -> Finding:
    """The nonlinear terms of (7) have no harmonic at 2 alpha."""
    theta, theta_1, theta_2 = trial_terms()
    terms = (theta_1**2 * np.sin(theta), theta_2 * np.cos(theta))
    shares = [np.abs(s[0:7:2]).max() / np.abs(s).max() for s in map(np.fft.rfft, terms)]
    return claimed(
        max(shares) < ROUNDING,
        f"nor any other even one: half a turn of theta in half a period turns their signs; "
        f"share {max(shares):.1g}",
        reference=f"{max(shares):.1g}",
    )


def equation_25(as_printed: bool) -> float:
    """Largest error of (25): its square has lost the factor alpha of the mixed term."""
    theta, theta_1, _ = trial_terms()
    psi, u, f_u = 2 * PHASES - TRIAL.gamma, TRIAL.u_1, 2 * TRIAL.alpha
    factor = 1.0 if as_printed else TRIAL.alpha
    square = TRIAL.alpha**2 - 2 * factor * u * f_u * np.sin(psi) + (u * f_u * np.sin(psi)) ** 2
    return float(np.abs(square * np.sin(theta) - theta_1**2 * np.sin(theta)).max())


def equation_30(as_printed: bool) -> float:
    """Largest error of (30), whose second bracket has lost sin(alpha tau), J_1 and J_3."""
    theta, _, theta_2 = trial_terms()
    psi, u = 2 * PHASES - TRIAL.gamma, TRIAL.u_1
    even = jv(0, u) - 2 * jv(2, u) * np.cos(2 * psi) + 2 * jv(4, u) * np.cos(4 * psi)
    odd = 2 * jv(1, u) * np.cos(psi) - 2 * jv(3, u) * np.cos(3 * psi)
    odd += 2 * jv(5, u) * np.cos(5 * psi)
    found = theta_2 * (np.cos(PHASES) * even - np.sin(PHASES) * odd)
    if as_printed:
        found = theta_2 * np.cos(PHASES) * even - theta_2 + 4 * jv(5, u) * np.cos(5 * psi)
    return float(np.abs(found - theta_2 * np.cos(theta)).max())


def equation_41(as_printed: bool) -> float:
    """Error of the coefficient of cos(2 alpha tau) of q'' cos(theta) in (41)."""
    motion = TRIAL.motion(PHASES / TRIAL.alpha)
    truth = np.mean(2 * motion.q_ddot * np.cos(motion.theta) * np.cos(2 * PHASES))
    u, beta, gamma = TRIAL.u_1, TRIAL.beta, TRIAL.gamma
    first = jv(1, u) + 2 * (-beta - gamma) if as_printed else jv(1, u) * np.sin(-beta - gamma)
    bracket = jv(0, u) * np.cos(beta) - jv(2, u) * np.cos(beta - 2 * gamma) + first
    bracket -= jv(1, u) * np.sin(beta - gamma)
    return float(abs(-TRIAL.q_1 * TRIAL.alpha**2 / 2 * bracket - truth))


def equation_45(as_printed: bool) -> float:
    """Residual of (39) for the correction that (45) makes of a torque cos(2 alpha tau)."""
    c = nondimensional(EXAMPLE)
    tau, f_u = np.linspace(0, 40, 400), 2 * c.alpha
    if as_printed:
        v_1 = (f_u * np.sin(f_u * tau) - np.sin(tau)) / (1 - f_u**2)
        v_2 = (f_u**2 * np.cos(f_u * tau) - np.cos(tau)) / (1 - f_u**2)
    else:
        response = -1 / (-(f_u**2) * c.inertia + 1j * c.zeta_m * f_u)
        wave = response * np.exp(1j * f_u * tau)
        v_1, v_2 = (1j * f_u * wave).real, (-(f_u**2) * wave).real
    return float(np.abs(c.inertia * v_2 + c.zeta_m * v_1 + np.cos(f_u * tau)).max())


def bessel(session: Session) -> Finding:
    """Simplified Bessel functions (27) for |u_1| < 0.5."""
    u = 0.5
    errors = {
        "J_0": abs(1 / jv(0, u) - 1),
        "J_1": abs(u / 2 / jv(1, u) - 1),
        "J_2 against J_0": jv(2, u),
        "J_3 against J_0": jv(3, u),
    }
    return claimed(
        max(errors.values()) < SMALL,
        "errors at |u_1| = 0.5: " + ", ".join(f"{n} {e:.1%}" for n, e in errors.items()),
        reference=f"{max(errors.values()):.1%}",
    )


def restored(p: HulaHoop) -> Array:
    """Return |u_1| (2, ...) of (35), (36), (46), (47), without and with what (35) has lost."""
    c = nondimensional(p)
    stiffness, damping = 1 - c.alpha**2, 2 * c.rho * c.alpha
    inertial, inertia = c.epsilon * c.alpha**2, 4 * c.alpha**2 * c.inertia
    friction, half = 2 * c.zeta_m * c.alpha, c.alpha**2 / 2
    found = []
    for lost in (0.0, inertial / 2):
        rows = (  # unknowns q_1 cos beta, q_1 sin beta, u_1 cos gamma, u_1 sin gamma
            (-damping, stiffness, 0, -lost),
            (stiffness, damping, -inertial / 2, 0),
            (0, -half, -friction, -inertia),
            (-half, 0, -inertia, friction),
        )
        shape = np.broadcast_shapes(np.shape(c.alpha), np.shape(c.force))
        matrix = np.array([[np.broadcast_to(value, shape) for value in row] for row in rows])
        right = np.array([np.broadcast_to(v, shape) for v in (inertial, c.force, 0, 0)])
        x = np.linalg.solve(
            np.moveaxis(matrix, (0, 1), (-2, -1)), np.moveaxis(right, 0, -1)[..., None]
        )
        found.append(np.hypot(x[..., 2, 0], x[..., 3, 0]))
    return np.array(found)


def equation_35(as_printed: bool) -> float:
    """Error of (35), by u_1, against the harmonic of (7) for a small u_1."""
    small = replace(TRIAL, u_1=1e-5)
    c = nondimensional(EXAMPLE)
    motion = small.motion(PHASES / small.alpha)
    coupling = motion.theta_ddot * np.cos(motion.theta)
    coupling = coupling - motion.theta_dot**2 * np.sin(motion.theta)
    slide = motion.q_ddot + 2 * c.rho * motion.q_dot + motion.q + c.epsilon * coupling
    truth = np.mean(2 * slide * np.sin(PHASES))
    inertial = c.epsilon * small.alpha**2
    printed = (1 - small.alpha**2) * small.q_1 * np.sin(small.beta)
    printed += -2 * c.rho * small.q_1 * small.alpha * np.cos(small.beta) - inertial
    lost = -inertial * small.u_1 * np.sin(small.gamma) / 2
    return float(abs(printed + (0 if as_printed else lost) - truth) / small.u_1)


def lost_term(session: Session) -> Finding:
    """(33) and (35) without the sine of the term whose cosine (36) has."""
    found = misprint(equation_35(True), equation_35(False), "sine harmonic of (7)", 1e-4)
    change = {}
    for name, p in (("3 Hz, 60 N", EXAMPLE), ("fig. 4 at most", grid(session, False))):
        without, with_it = restored(p)
        change[name] = float(np.max(np.abs(with_it / without - 1)))
    words = ", ".join(f"{name} {value:.2%}" for name, value in change.items())
    return replace(found, reason=f"{found.reason}; change of u_1: {words}")


def secular_terms(session: Session) -> Finding:
    """Why the coefficients of (34) and (45) are set to zero."""
    alpha = float(nondimensional(EXAMPLE).alpha)
    tau = np.linspace(0, 2e4, 200_001)
    wave = np.abs(np.cos(tau) - np.cos(alpha * tau)) / abs(1 - alpha**2)
    early, late = wave[: len(wave) // 2].max(), wave[len(wave) // 2 :].max()
    return claimed(
        bool(late > 1.5 * early),
        f"(34) has no secular term: at 3 Hz it stays below {late:.2f} times its coefficients "
        f"({early:.2f} in the first half of 3000 periods), since alpha is not 1. Setting them to "
        "zero is harmonic balance",
    )


def mean_balance(session: Session) -> Finding:
    """(44), derived and then dropped; theta has no constant phase."""
    c = nondimensional(EXAMPLE)
    friction = float(c.zeta_m * c.alpha)
    torque = {
        name: float(abs(balance_residuals(solve(EXAMPLE), EXAMPLE)[2])) / friction
        for name, solve in (("paper", paper_solution), ("corrected", corrected_solution))
    }
    errors = approximation_errors(session)
    ratio = errors["paper"][1] / errors["corrected"][1]
    phase = float(corrected_solution(EXAMPLE).theta_0)
    holds = torque["corrected"] < 1e-9 and torque["paper"] > 1 and ratio > 10
    return Finding(
        CORRECTED if holds else NOT_REPRODUCED,
        f"five conditions for four unknowns: with theta_0 = 0 the mean torque is off by "
        f"{torque['paper']:.0f} times the friction; with theta_0 = {phase:.2f} rad and (44) it is "
        f"balanced, and the largest error of theta falls {ratio:.0f} times",
        reference=f"theta_0 = {phase:.3f} rad",
        engines=per_engine(
            session,
            lambda name: f"mean of theta - omega t: {mean_phase(session, name):.3f} rad",
        ),
    )


def mean_phase(session: Session, name: str) -> float:
    """Return the mean of theta - omega t of the true rotation [rad]."""
    return float(example_orbit(session, name).harmonics["theta"][0])


def dropped_torque(session: Session) -> Finding:
    """Terms of (43) ignored for |u_1| < 0.5, and what that does to u_1."""
    paper, full = (solve(grid(session, False)) for solve in (paper_solution, refined_solution))
    small = np.abs(paper.u_1) < 0.5
    gap = np.abs(np.abs(full.u_1 / paper.u_1) - 1)[small]
    return claimed(
        bool(np.max(gap) < SMALL),
        f"with theta_0 = 0 and every term kept u_1 changes by {np.median(gap):.1%} in the median "
        f"of the points with |u_1| < 0.5 of fig. 4, and by {np.max(gap):.0%} at worst; {SMALL:.0%} "
        "would be small",
        reference=f"{np.max(gap):.0%}",
    )


def closed_form(session: Session) -> Finding:
    """(49)-(52) solve (35), (36), (46), (47)."""
    worst = max(
        float(paper_solution(grid(session, plate)).residual.max()) for plate in (False, True)
    )
    return claimed(
        worst < ROUNDING,
        f"largest residual over the grids of figs. 4 and 6: {worst:.1g}; the branch of the "
        "arctangent does not matter",
        reference=f"{worst:.1g}",
    )


# Section 4


def newton(session: Session) -> Finding:
    """Newton's method makes the solutions accurate."""
    errors = {name: error[1] for name, error in approximation_errors(session).items()}
    return claimed(
        bool(errors["refined"] < errors["paper"] / 2),
        "the closed form solves the printed equations exactly, so Newton's method can only be "
        f"meant for the untruncated ones; with it theta is off by {errors['refined']:.2f} rad, "
        f"without it by {errors['paper']:.2f} rad, with the phase theta_0 by "
        f"{errors['corrected']:.3f} rad",
        reference=f"{errors['refined']:.2f} rad",
    )


def variational(session: Session) -> Finding:
    """(55) has p_1 theta~' where p_1 theta~'' is meant."""
    found = misprint(equation_55(True), equation_55(False), "linearisation of (7)", 1e-8)
    paper = paper_solution(EXAMPLE)
    printed, corrected = (
        float(abs(floquet_multipliers(paper, EXAMPLE, as_printed)[0]))
        for as_printed in (True, False)
    )
    shares = {name: float(np.mean(stable(session, False, name))) for name in ("printed", "paper")}
    more = (
        f"the printed solution at 3 Hz and 60 N has the multiplier {printed:.3f} with it, and "
        f"{corrected:.3f} without; in fig. 4 {shares['printed']:.0%} of the points are stable "
        f"with it, and {shares['paper']:.0%} without"
    )
    return replace(found, reason=f"{found.reason}; {more}", reference=f"{corrected:.3f}")


def equation_55(as_printed: bool) -> float:
    """Error of (55) against a small change of the trial motion put into (7)."""
    c, change = nondimensional(EXAMPLE), 1e-5
    tau = PHASES / TRIAL.alpha
    motion = TRIAL.motion(tau)
    shift, shift_1, shift_2 = np.cos(3 * tau), -3 * np.sin(3 * tau), -9 * np.cos(3 * tau)

    def coupling(size: float) -> Array:
        theta = motion.theta + size * shift
        found: Array = (motion.theta_ddot + size * shift_2) * np.cos(theta)
        return found - (motion.theta_dot + size * shift_1) ** 2 * np.sin(theta)

    truth = c.epsilon * (coupling(change) - coupling(-change)) / (2 * change)
    p_1, p_2, p_3, _, _ = variational_coefficients(TRIAL, EXAMPLE, tau)
    first = shift_1 if as_printed else shift_2
    return float(np.abs(p_1 * first + p_2 * shift_1 + p_3 * shift - truth).max())


def rate_moduli(solution: ApproximateSolution, p: HulaHoop, count: int = 64) -> Array:
    """Return moduli of the eigenvalues of A(tau) of (62) over one period, (count, 4)."""
    c = nondimensional(p)
    tau = 2 * np.pi / c.alpha * np.arange(count) / count
    p_1, p_2, p_3, p_4, p_5 = variational_coefficients(solution, p, tau)
    one, none = np.ones(count), np.zeros(count)
    mass = np.array([[one, p_1], [p_5, one]])
    right = -np.array(
        [[one, p_3, 2 * c.rho * one, p_2], [none, p_4, none, c.zeta_m / c.inertia * one]]
    )
    lower = np.linalg.solve(np.moveaxis(mass, -1, 0), np.moveaxis(right, -1, 0))
    upper = np.broadcast_to(np.eye(2, 4, 2), (count, 2, 4))
    return np.abs(np.linalg.eigvals(np.concatenate([upper, lower], axis=1)))


def eigenvalues(session: Session) -> Finding:
    """Whose eigenvalues decide on stability."""
    solution = corrected_solution(EXAMPLE)
    moduli = rate_moduli(solution, EXAMPLE)
    largest = float(abs(floquet_multipliers(solution, EXAMPLE)[0]))
    true = float(abs(example_orbit(session).floquet_multipliers[0]))
    above = float(np.mean(moduli.max(axis=1) > 1))
    holds = above > 0 and largest < 1 and true < 1
    return Finding(
        CORRECTED if holds else NOT_REPRODUCED,
        f"A(tau) has an eigenvalue above 1 in modulus for {above:.0%} of the period though the "
        f"rotation is stable; those of the monodromy matrix decide: {largest:.4f}, of the true "
        f"rotation {true:.4f}",
        reference=f"{true:.6f}",
        engines=per_engine(
            session,
            lambda name: f"{abs(example_orbit(session, name).floquet_multipliers[0]):.6f}",
        ),
    )


def unstable_not_seen(session: Session) -> Finding:
    """An unstable rotation is not observed in the steady state."""
    motion = motion_map(session, False)
    hoop = is_class(motion, "motion", "blue_o") & (motion.variables["robust"] == 1)
    seen = hoop & (motion.variables["periods"] == 1)
    unstable = {name: ~stable(session, False, name) for name in ("paper", "exact")}
    counts = {name: int(np.sum(where & seen)) for name, where in unstable.items()}
    return claimed(
        counts["exact"] == 0,
        f"of {int(seen.sum())} robust points of fig. 5 with a periodic hula-hoop motion "
        f"{counts['exact']} lie where the true rotation is unstable, and {counts['paper']} where "
        f"the printed solution is; {int(np.sum(hoop & ~seen))} more have blue o without "
        "repeating in each period",
        reference=f"{counts['exact']} of {int(seen.sum())} points",
        engines=per_engine(session, lambda name: own_count(session, name)),
    )


def own_count(session: Session, engine: str) -> str:
    """Return the same by an engine's own maps."""
    calm, _, periodic = own_maps(session, False, engine)
    return f"{np.sum(periodic & ~calm)} of {np.sum(periodic)} points"


def stable_appears(session: Session) -> Finding:
    """Where the rotation is stable, hula-hoop motion appears."""
    motion = motion_map(session, False)
    here = stable(session, False, "exact") & (motion.variables["robust"] == 1)
    elsewhere = here & ~is_class(motion, "motion", "blue_o")
    share = float(elsewhere.sum() / here.sum())
    kinds = {
        name.replace("_", " "): int(np.sum(elsewhere & is_class(motion, "motion", name)))
        for name in motion.about["motion"].classes[1:]
    }
    return claimed(
        share == 0,
        f"stable does not mean reached: of {int(here.sum())} robust points with a stable true "
        f"rotation {share:.0%} end elsewhere from rest ("
        + ", ".join(f"{name} {count}" for name, count in kinds.items())
        + ")",
        reference=f"{share:.0%} elsewhere",
    )


ROWS: tuple[Row, ...] = (
    Row(
        "rotation_from_shaking",
        "claim",
        "abstract, 1",
        "Shaken along a line, the device turns the free mass round, in step with the force.",
        rotation_from_shaking,
        slow=True,
    ),
    Row(
        "energy_scavenging",
        "claim",
        "abstract, 6",
        "With coils and magnets it can harvest energy, and the results are design guidelines.",
        energy_scavenging,
    ),
    Row(
        "better_than_simple",
        "claim",
        "1",
        "The homotopy perturbation method gives better approximate solutions.",
        better_than_simple,
    ),
    Row(
        "equations_of_motion",
        "claim",
        "2, (1)-(8)",
        "Lagrange's equations of the two masses, and their nondimensional form.",
        equations_of_motion,
    ),
    Row(
        "lost_dots",
        "misprint",
        "2, below figure 1 and (4)",
        "The velocity of the free mass and the damper's force, as the text prints them.",
        lost_dots,
        test=TESTS + "test_velocity_and_damper_force_have_dots",
    ),
    Row(
        "plate_inertia",
        "number",
        "2, below (8)",
        "Inertia ratio I_eq of the semicircular plate.",
        plate_inertia,
        printed="9 pi^2/32 - 1",
    ),
    Row(
        "ansatz_harmonics",
        "claim",
        "3.2, (16), (17)",
        "The main mass moves at the frequency of the force, the angle oscillates at twice that.",
        ansatz_harmonics,
    ),
    Row(
        "no_even_harmonics",
        "claim",
        "3.2, below (27) and (30)",
        "The nonlinear terms of (7) have no harmonic at twice the frequency.",
        no_even_harmonics,
    ),
    Row(
        "square_25",
        "misprint",
        "equation (25)",
        "Mixed term of the square of theta'.",
        lambda session: misprint(equation_25(True), equation_25(False), "square of theta'"),
        printed="-2 u_1 f_u",
        test=TESTS + "test_25_lacks_alpha",
    ),
    Row(
        "expansion_30",
        "misprint",
        "equation (30)",
        "Neumann expansion of theta'' cos(theta).",
        lambda session: misprint(
            equation_30(True),
            equation_30(False),
            "theta'' cos(theta), where our copy of the text has lost sin(alpha tau), J_1 and J_3",
            within=1e-5,
        ),
        test=TESTS + "test_30_lacks_its_sine_part",
    ),
    Row(
        "bessel_27",
        "claim",
        "equations (27), (32)",
        "For |u_1| < 0.5 J_0 is about 1, J_1 about u_1/2, J_2 and J_3 about 0.",
        bessel,
    ),
    Row(
        "lost_term_35",
        "misprint",
        "equations (33), (35)",
        "Sine of the force balance of the main mass: -eps alpha^2 u_1 sin(gamma)/2 is missing.",
        lost_term,
        test=THEORY_TESTS + "test_sympy_derives_the_printed_conditions_and_what_they_drop",
    ),
    Row(
        "secular_terms",
        "claim",
        "3.2, below (34) and (45)",
        "Coefficients are set to zero because secular terms would follow.",
        secular_terms,
    ),
    Row(
        "product_41",
        "misprint",
        "equation (41)",
        "Harmonics of q'' cos(theta); (42) has them right.",
        lambda session: misprint(
            equation_41(True), equation_41(False), "coefficient of cos(2 alpha tau)"
        ),
        test=TESTS + "test_41_is_garbled_and_42_is_right",
    ),
    Row(
        "mean_balance_44",
        "misprint",
        "equations (17), (44)",
        "The mean torque balance is derived, then dropped; theta has no constant phase.",
        mean_balance,
        test=THEORY_TESTS
        + "test_closed_form_solves_its_own_four_equations_but_not_the_torque_balance",
    ),
    Row(
        "dropped_torque_43",
        "claim",
        "3.2, (43)-(47)",
        "Terms of second order in u_1 can be ignored while |u_1| < 0.5.",
        dropped_torque,
    ),
    Row(
        "kernel_45",
        "misprint",
        "equation (45)",
        "Correction of theta: its kernel and denominator belong to an angle with a spring.",
        lambda session: misprint(
            equation_45(True),
            equation_45(False),
            "(39) with the L of (42); (46), (47) are not touched",
        ),
        test=TESTS + "test_45_solves_another_equation",
    ),
    Row(
        "closed_form",
        "claim",
        "equations (49)-(52)",
        "The four unknowns in closed form.",
        closed_form,
    ),
    Row(
        "newton",
        "claim",
        "4",
        "Newton's method makes the approximate solutions accurate.",
        newton,
    ),
    Row(
        "variational_55",
        "misprint",
        "equation (55)",
        "First coupling term of the perturbed equation of the main mass.",
        variational,
        printed="p_1 theta~'",
        test=THEORY_TESTS + "test_misprint_in_55_changes_the_verdict",
        slow=True,
    ),
    Row(
        "eigenvalues_62",
        "misprint",
        "equation (62)",
        "Eigenvalues of the matrix A(tau), called the transition matrix, decide on stability.",
        eigenvalues,
        test=TESTS + "test_eigenvalues_of_62_do_not_decide",
    ),
    Row(
        "unstable_not_seen",
        "claim",
        "4",
        "With a multiplier above 1 the rotation cannot be observed in the steady state.",
        unstable_not_seen,
        slow=True,
    ),
    Row(
        "stable_appears",
        "claim",
        "4",
        "With all multipliers below 1 hula-hoop motion will appear.",
        stable_appears,
        slow=True,
    ),
)

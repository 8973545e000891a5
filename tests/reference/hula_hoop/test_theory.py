"""The paper's approximate rotations of hula_hoop against SymPy and quadrature."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import pytest
import sympy as sp
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.special import jv

from mbcheck.reference.errors import UnknownNameError
from mbcheck.reference.hula_hoop import theory
from mbcheck.reference.hula_hoop.equations import SEMICIRCLE, HulaHoop, accelerations, coefficients
from mbcheck.reference.hula_hoop.floquet import (
    floquet_multipliers,
    monodromy_matrix,
    variational_coefficients,
)
from mbcheck.reference.hula_hoop.theory import (
    ApproximateSolution,
    balance_residuals,
    corrected_solution,
    nondimensional,
    paper_solution,
    refined_solution,
)

Array = NDArray[np.float64]


PAPER_CASE = HulaHoop()  # 3 Hz, 60 N


GRID = HulaHoop(
    force_frequency=np.linspace(1, 10, 19)[:, None],  # type: ignore[arg-type]
    force_amplitude=np.linspace(5, 150, 8),  # type: ignore[arg-type]
)


alpha, eps, rho, zeta, inertia, force, tau = sp.symbols("alpha eps rho zeta I F tau", positive=True)


q_1, beta, u_1, gamma, theta_0 = sp.symbols("q_1 beta u_1 gamma theta_0", real=True)


def equation_7(q: Any, theta: Any, t: Any = tau) -> Any:
    d_theta = sp.diff(theta, t)
    coupling = sp.diff(theta, t, 2) * sp.cos(theta) - d_theta**2 * sp.sin(theta)
    linear = sp.diff(q, t, 2) + 2 * rho * sp.diff(q, t) + q
    return linear + eps * coupling - force * sp.cos(alpha * t)


def equation_8(q: Any, theta: Any, t: Any = tau) -> Any:
    rolling = inertia * sp.diff(theta, t, 2) + zeta * sp.diff(theta, t)
    return rolling + sp.diff(q, t, 2) * sp.cos(theta)


Q_ANSATZ = q_1 * sp.cos(alpha * tau - beta)


THETA_ANSATZ = alpha * tau + theta_0 + u_1 * sp.cos(2 * alpha * tau - gamma)


ANSATZ_RESIDUALS = equation_7(Q_ANSATZ, THETA_ANSATZ), equation_8(Q_ANSATZ, THETA_ANSATZ)


def random_points(n: int = 20) -> tuple[HulaHoop, ApproximateSolution]:
    """Parameters and motions of the form of the ansatz that solve nothing."""
    rng = np.random.default_rng(11)
    p = HulaHoop(
        force_frequency=rng.uniform(1, 10, n),  # type: ignore[arg-type]
        force_amplitude=rng.uniform(5, 150, n),  # type: ignore[arg-type]
        inertia_ratio=rng.uniform(0, 2, n),  # type: ignore[arg-type]
        damping_ratio=rng.uniform(0, 0.5, n),  # type: ignore[arg-type]
    )
    size, angle = rng.uniform(-1, 1, (2, n)), rng.uniform(-np.pi, np.pi, (3, n))
    solution = ApproximateSolution(
        nondimensional(p).alpha, 2 * size[0], angle[0], size[1], angle[1], angle[2], np.nan
    )
    return p, solution


def numbers(p: HulaHoop, solution: ApproximateSolution) -> dict[Any, Any]:
    c = nondimensional(p)
    return {
        alpha: c.alpha, eps: c.epsilon, rho: c.rho, zeta: c.zeta_m, inertia: c.inertia,
        force: c.force, q_1: solution.q_1, beta: solution.beta, u_1: solution.u_1,
        gamma: solution.gamma, theta_0: solution.theta_0,
    }  # fmt: skip


@functools.cache
def compiled(expression: Any) -> Any:
    names = [alpha, eps, rho, zeta, inertia, force, q_1, beta, u_1, gamma, theta_0, tau]
    return sp.lambdify(names, expression, "numpy", cse=True)


def evaluate(expression: Any, p: HulaHoop, solution: ApproximateSolution, at: Any) -> Any:
    return compiled(expression)(*numbers(p, solution).values(), at)


# --- The equations --------------------------------------------------------------------------


def test_equations_7_8_and_the_determinant_follow_from_5_6() -> None:
    M, m, R, k, c, c_m, I, F, omega, t = sp.symbols("M m R k c c_m J F omega t", positive=True)
    q, theta = sp.Function("q"), sp.Function("theta")
    omega_n = sp.sqrt(k / (M + m))
    y, angle = R * q(omega_n * t), theta(omega_n * t)
    d_angle = sp.diff(angle, t)
    coupling = sp.diff(angle, t, 2) * sp.cos(angle) - d_angle**2 * sp.sin(angle)
    spring = c * sp.diff(y, t) + k * y
    equation_5 = (M + m) * sp.diff(y, t, 2) + m * R * coupling + spring - F * sp.cos(omega * t)
    rolling = (m * R**2 + I) * sp.diff(angle, t, 2) + c_m * d_angle
    equation_6 = rolling + m * R * sp.diff(y, t, 2) * sp.cos(angle)
    scaled = {
        alpha: omega / omega_n, eps: m / (M + m), rho: c / (2 * (M + m) * omega_n),
        zeta: c_m / (m * R**2 * omega_n), inertia: 1 + I / (m * R**2), force: F / (k * R),
    }  # fmt: skip
    for dimensional, unit, reduced in (
        (equation_5, k * R, equation_7(q(tau), theta(tau))),
        (equation_6, m * R**2 * omega_n**2, equation_8(q(tau), theta(tau))),
    ):
        gap = dimensional.subs(t, tau / omega_n).doit() / unit - reduced.subs(scaled)
        assert sp.simplify(gap) == 0
    mass = sp.Matrix([[1, eps * sp.cos(theta_0)], [sp.cos(theta_0), inertia]])
    assert sp.expand(mass.det() - (inertia - eps * sp.cos(theta_0) ** 2)) == 0


def test_nondimensional_coefficients_belong_to_the_scene() -> None:
    p, solution = random_points()
    motion, c = solution.motion(0.7), nondimensional(p)
    y, theta, y_dot, theta_dot = solution.state([0.7 / p.omega_n], p)[..., 0]
    drive = np.cos(c.alpha * 0.7)
    y_ddot, theta_ddot = accelerations(drive, (y, theta), (y_dot, theta_dot), coefficients(p))
    q_2, theta_2 = y_ddot / (p.rod_length * p.omega_n**2), theta_ddot / p.omega_n**2
    coupling = theta_2 * np.cos(theta) - motion.theta_dot**2 * np.sin(theta)
    slide = q_2 + 2 * c.rho * motion.q_dot + motion.q + c.epsilon * coupling - c.force * drive
    hinge = c.inertia * theta_2 + c.zeta_m * motion.theta_dot + q_2 * np.cos(theta)
    np.testing.assert_allclose(slide, 0, atol=1e-13)
    np.testing.assert_allclose(hinge, 0, atol=1e-13)


# --- Harmonic balance -----------------------------------------------------------------------


def first_order(expression: Any) -> Any:
    """Taylor polynomial of degree 1 in u_1."""
    return expression.subs(u_1, 0) + u_1 * sp.diff(expression, u_1).subs(u_1, 0)


def mean(expression: Any) -> Any:
    """Mean over a forcing period, exact for trigonometric polynomials of degree below 12."""
    points = [expression.subs(tau, sp.pi * k / (6 * alpha)) for k in range(12)]
    return sp.simplify(sp.expand(sp.expand_trig(sum(points) / 12)))


def same(left: Any, right: Any) -> bool:
    return bool(sp.simplify(sp.expand(sp.expand_trig(left - right))) == 0)


def test_sympy_derives_the_printed_conditions_and_what_they_drop() -> None:
    ansatz = (Q_ANSATZ, THETA_ANSATZ.subs(theta_0, 0))
    slide, hinge = first_order(equation_7(*ansatz)), first_order(equation_8(*ansatz))
    q_cos, q_sin = q_1 * sp.cos(beta), q_1 * sp.sin(beta)
    u_cos, u_sin = u_1 * sp.cos(gamma), u_1 * sp.sin(gamma)
    printed_35 = (1 - alpha**2) * q_sin - 2 * rho * alpha * q_cos - eps * alpha**2
    printed_36 = (
        (1 - alpha**2) * q_cos + 2 * rho * alpha * q_sin - eps * alpha**2 * u_cos / 2 - force
    )
    printed_44 = zeta * alpha - q_1 * alpha**2 * (sp.cos(beta) + u_1 / 2 * sp.sin(beta - gamma)) / 2
    printed_46 = -4 * alpha**2 * inertia * u_sin - 2 * zeta * alpha * u_cos - alpha**2 * q_sin / 2
    printed_47 = -4 * alpha**2 * inertia * u_cos + 2 * zeta * alpha * u_sin - alpha**2 * q_cos / 2

    lost_term = -eps * alpha**2 * u_sin / 2
    derived_35 = mean(2 * slide * sp.sin(alpha * tau))
    assert same(derived_35, printed_35 + lost_term)
    assert not same(derived_35, printed_35)
    assert same(mean(2 * slide * sp.cos(alpha * tau)), printed_36)
    assert same(mean(hinge), printed_44)
    dropped_46 = -(alpha**2) * q_1 * u_1 / 4 * (sp.cos(beta + gamma) - sp.cos(beta - gamma))
    dropped_47 = alpha**2 * q_1 * u_1 / 4 * (sp.sin(beta + gamma) + sp.sin(beta - gamma))
    assert same(mean(2 * hinge * sp.sin(2 * alpha * tau)), printed_46 + dropped_46)
    assert same(mean(2 * hinge * sp.cos(2 * alpha * tau)), printed_47 + dropped_47)


def projections(p: HulaHoop, s: ApproximateSolution) -> Array:
    """Harmonics of the residuals of (7), (8) by quadrature; exact to rounding for 64 points."""
    phase = 2 * np.pi * np.arange(64)[:, None] / 64
    at = phase / nondimensional(p).alpha
    slide, hinge = (evaluate(residual, p, s, at) for residual in ANSATZ_RESIDUALS)
    turn = phase + s.theta_0
    return np.array(
        [
            np.mean(2 * slide * np.cos(turn), axis=0),
            np.mean(2 * slide * np.sin(turn), axis=0),
            np.mean(hinge, axis=0),
            np.mean(2 * hinge * np.cos(2 * turn), axis=0),
            np.mean(2 * hinge * np.sin(2 * turn), axis=0),
        ]
    )


def test_balances_are_the_projections_of_the_equations() -> None:
    p, s = random_points()
    np.testing.assert_allclose(balance_residuals(s, p), projections(p, s), atol=2e-12)


def test_a_lost_bessel_function_would_be_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    p, s = random_points()
    harmonics = theory._harmonics

    def without_j_1_in_the_slide(u: Any) -> tuple[Any, Any, Any]:
        _, cos_1, cos_3 = harmonics(u)
        return -1j * jv(0, np.abs(u)), cos_1, cos_3

    monkeypatch.setattr(theory, "_harmonics", without_j_1_in_the_slide)
    gap = np.abs(balance_residuals(s, p) - projections(p, s)).max(axis=1)
    assert gap[:2].min() > 1e-3
    assert gap[2:].max() < 2e-12


# --- The three solutions --------------------------------------------------------------------


def test_closed_form_solves_its_own_four_equations_but_not_the_torque_balance() -> None:
    for inertia_ratio in (0.0, SEMICIRCLE):
        p = GRID.replace(inertia_ratio=inertia_ratio)
        assert paper_solution(p).residual.max() < 1e-12
    c, solution = nondimensional(PAPER_CASE), paper_solution(PAPER_CASE)
    # The mean torque that nothing balances is thirty times the friction torque.
    assert abs(balance_residuals(solution, PAPER_CASE)[2]) > 20 * c.zeta_m * c.alpha


def test_refined_solution_solves_the_untruncated_four_and_changes_little() -> None:
    assert refined_solution(GRID).residual.max() < 1e-12
    p = HulaHoop(force_amplitude=np.array([5.0, 20.0, 60.0]))  # type: ignore[arg-type]
    refined, paper = refined_solution(p), paper_solution(p)
    assert np.all(refined.theta_0 == 0)
    np.testing.assert_allclose(refined.u_1, np.abs(paper.u_1), rtol=0.02)
    friction = nondimensional(p).zeta_m * nondimensional(p).alpha
    assert np.all(np.abs(balance_residuals(refined, p)[2]) > friction)


@pytest.mark.parametrize("branch", ["stable", "unstable"])
@pytest.mark.parametrize("inertia_ratio", [0.0, SEMICIRCLE])
def test_corrected_solution_solves_all_five(branch: Any, inertia_ratio: float) -> None:
    p = GRID.replace(inertia_ratio=inertia_ratio)
    solution = corrected_solution(p, branch)
    exists = np.isfinite(solution.residual)
    assert exists.mean() > 0.98
    assert solution.residual[exists].max() < 1e-12
    for i, j in np.argwhere(exists)[::50]:
        point = HulaHoop(
            force_frequency=p.force_frequency[i, 0],  # type: ignore[index]
            force_amplitude=p.force_amplitude[j],  # type: ignore[index]
            inertia_ratio=inertia_ratio,
        )
        alone = corrected_solution(point, branch)
        assert alone.theta_0 == pytest.approx(solution.theta_0[i, j], abs=1e-9)
        assert np.abs(projections(point, alone)).max() < 1e-12


def test_no_solution_below_the_fold() -> None:
    # Mean torque balance at 3 Hz: the force cannot carry the friction below 2.0586 N.
    p = HulaHoop(force_amplitude=np.array([0.0, 2.0, 2.05, 2.07, 60.0]))  # type: ignore[arg-type]
    stable, unstable = corrected_solution(p), corrected_solution(p, "unstable")
    for solution in (stable, unstable):
        assert np.isnan(solution.theta_0).tolist() == [True, True, True, False, False]
    gap = (stable.theta_0 - unstable.theta_0) % (2 * np.pi)
    assert gap[3] < 0.5  # close to the fold the two phases meet
    assert gap[4] == pytest.approx(np.pi, abs=0.1)  # far from it they are half a turn apart
    multipliers = floquet_multipliers(stable, p)
    assert np.isnan(multipliers).any(axis=0).tolist() == [True, True, True, False, False]


def test_unknown_branch_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'stable'"):
        corrected_solution(PAPER_CASE, "stabel")  # type: ignore[arg-type]


# --- Stability ------------------------------------------------------------------------------


@functools.cache
def sympy_coefficients() -> tuple[Any, ...]:
    """p_1, ..., p_5 by differentiating (7), (8); (8) divided by 1 + I_eq."""
    q, theta = sp.Function("q")(tau), sp.Function("theta")(tau)
    variables = [theta.diff(tau, 2), theta.diff(tau), theta, q.diff(tau, 2)]
    symbols = sp.symbols("theta_2 theta_1 theta_0_ q_2")
    swap = list(zip(variables, symbols, strict=True))
    slide, hinge = (e(q, theta).subs(swap) for e in (equation_7, equation_8))
    theta_2, theta_1, theta_, q_2 = symbols
    motion = {
        theta_2: THETA_ANSATZ.diff(tau, 2), theta_1: THETA_ANSATZ.diff(tau),
        theta_: THETA_ANSATZ, q_2: Q_ANSATZ.diff(tau, 2),
    }  # fmt: skip
    derivatives = (
        slide.diff(theta_2), slide.diff(theta_1), slide.diff(theta_),
        hinge.diff(theta_) / inertia, hinge.diff(q_2) / inertia,
    )  # fmt: skip
    return tuple(derivative.subs(motion) for derivative in derivatives)


def test_p_1_to_p_5_are_the_linearisation() -> None:
    p, solution = random_points()
    at = np.random.default_rng(5).uniform(0, 50, 20)
    ours = variational_coefficients(solution, p, at)
    for coefficient, expression in zip(ours, sympy_coefficients(), strict=True):
        np.testing.assert_allclose(
            coefficient, evaluate(expression, p, solution, at), rtol=1e-12, atol=1e-12
        )


def independent_monodromy(solution: ApproximateSolution, p: HulaHoop) -> Array:
    """(55), (56) with the correct p_1 theta~'', integrated adaptively from SymPy's p_i."""
    values = numbers(p, solution)
    p_of = sp.lambdify([tau], [e.subs(values) for e in sympy_coefficients()], "math")
    c = nondimensional(p)

    def rate(t: float, flat: Array) -> Array:
        p_1, p_2, p_3, p_4, p_5 = p_of(t)
        x = flat.reshape(4, 4)
        mass = np.array([[1, p_1], [p_5, 1]])
        damping = np.array([[2 * c.rho, p_2], [0, c.zeta_m / c.inertia]])
        stiffness = np.array([[1, p_3], [0, p_4]])
        acceleration = -np.linalg.solve(mass, damping @ x[2:] + stiffness @ x[:2])
        return np.concatenate([x[2:], acceleration]).ravel()

    period = 2 * np.pi / float(c.alpha)
    result = solve_ivp(
        rate, (0, period), np.eye(4).ravel(), method="DOP853", rtol=1e-12, atol=1e-13
    )
    return np.asarray(result.y[:, -1].reshape(4, 4))


def test_monodromy_is_that_of_the_linearisation() -> None:
    for p in (PAPER_CASE, HulaHoop(force_frequency=1.5, force_amplitude=40, damping_ratio=1.0)):
        solution = corrected_solution(p)
        reference = independent_monodromy(solution, p)
        ours = monodromy_matrix(solution, p)
        np.testing.assert_allclose(ours, reference, atol=1e-9 * np.abs(reference).max())


def test_misprint_in_55_changes_the_verdict() -> None:
    """With p_1 theta~' the closed form seems stable at 3 Hz, 60 N; it is not."""
    paper = paper_solution(PAPER_CASE)
    assert abs(floquet_multipliers(paper, PAPER_CASE)[0]) == pytest.approx(1.136, abs=1e-3)
    misprinted = floquet_multipliers(paper, PAPER_CASE, as_printed=True)
    assert abs(misprinted[0]) == pytest.approx(0.970, abs=1e-3)
    solution = corrected_solution(PAPER_CASE)
    gap = monodromy_matrix(solution, PAPER_CASE, as_printed=True) - independent_monodromy(
        solution, PAPER_CASE
    )
    assert np.abs(gap).max() > 0.1


def test_multipliers_are_sorted_and_vectorised() -> None:
    solution = corrected_solution(GRID)
    multipliers = floquet_multipliers(solution, GRID)
    assert multipliers.shape == (4, 19, 8)
    exists = np.isfinite(multipliers).all(axis=0)
    assert np.array_equal(exists, np.isfinite(solution.u_1))
    assert np.all(np.diff(np.abs(multipliers[:, exists]), axis=0) <= 0)
    i, j = 4, 3
    point = HulaHoop(
        force_frequency=GRID.force_frequency[i, 0],  # type: ignore[index]
        force_amplitude=GRID.force_amplitude[j],  # type: ignore[index]
    )
    alone = floquet_multipliers(corrected_solution(point), point)
    np.testing.assert_allclose(np.abs(alone), np.abs(multipliers[:, i, j]), rtol=1e-8)

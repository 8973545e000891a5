"""The misprints of the hula_hoop paper, proved: by SymPy, and by what identities leave over."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sp

from mbcheck.comparisons.papers.hula_hoop.derivation import (
    PHASES,
    TRIAL,
    rate_moduli,
    second_order,
)
from mbcheck.comparisons.papers.hula_hoop.results import EXAMPLE
from mbcheck.reference.hula_hoop.floquet import floquet_multipliers
from mbcheck.reference.hula_hoop.theory import (
    corrected_solution,
    nondimensional,
    paper_solution,
)

# By SymPy -----------------------------------------------------------------------------------

tau, alpha, u_1, gamma, q_1, beta = sp.symbols("tau alpha u_1 gamma q_1 beta", real=True)
PSI = 2 * alpha * tau - gamma
THETA = alpha * tau + u_1 * sp.cos(PSI)
POINT = {tau: 0.9, alpha: 0.7, u_1: 0.35, gamma: 1.1, q_1: 1.4, beta: 0.3}


def value(expression: Any) -> float:
    return float(sp.N(expression.subs(POINT)))


def test_velocity_and_damper_force_have_dots() -> None:
    t, c, R = sp.symbols("t c R")
    theta, y = sp.Function("theta")(t), sp.Function("y")(t)
    velocity = sp.diff(R * sp.cos(theta), t)
    assert sp.simplify(velocity + R * theta.diff(t) * sp.sin(theta)) == 0
    assert sp.simplify(velocity + R * theta * sp.sin(theta)) != 0
    # What is left out of (5) on both readings: only c y' takes energy out.
    force = {"printed": -c * y, "corrected": -c * y.diff(t)}
    power = {name: sp.expand(f * y.diff(t)) for name, f in force.items()}
    assert power["corrected"] == -c * y.diff(t) ** 2
    assert sp.simplify(power["printed"] - sp.diff(-c * y**2 / 2, t)) == 0


def test_25_lacks_alpha() -> None:
    f_u, sine = 2 * alpha, sp.sin(PSI)
    truth = sp.diff(THETA, tau) ** 2
    corrected = alpha**2 - 2 * alpha * u_1 * f_u * sine + (u_1 * f_u * sine) ** 2
    printed = alpha**2 - 2 * u_1 * f_u * sine + (u_1 * f_u * sine) ** 2
    assert sp.simplify(corrected - truth) == 0
    assert abs(value(printed - truth)) > 0.01


def test_30_lacks_its_sine_part() -> None:
    truth = sp.diff(THETA, tau, 2) * sp.cos(THETA)
    bend = -u_1 * (2 * alpha) ** 2 * sp.cos(PSI)
    j = [sp.besselj(n, u_1) for n in range(6)]
    even = j[0] - 2 * j[2] * sp.cos(2 * PSI) + 2 * j[4] * sp.cos(4 * PSI)
    odd = 2 * j[1] * sp.cos(PSI) - 2 * j[3] * sp.cos(3 * PSI) + 2 * j[5] * sp.cos(5 * PSI)
    corrected = bend * (sp.cos(alpha * tau) * even - sp.sin(alpha * tau) * odd)
    printed = bend * sp.cos(alpha * tau) * even - bend + 4 * j[5] * sp.cos(5 * PSI)
    assert abs(value(corrected - truth)) < 1e-6
    assert abs(value(printed - truth)) > 0.1


def test_41_is_garbled_and_42_is_right() -> None:
    """Coefficient of cos(2 alpha tau), by a sum over a period of q'' cos(theta)."""
    truth = sp.diff(q_1 * sp.cos(alpha * tau - beta), tau, 2) * sp.cos(THETA)
    count = 48
    harmonic = sum(
        value(
            (2 * truth * sp.cos(2 * alpha * tau) / count).subs(tau, 2 * sp.pi * k / (count * alpha))
        )
        for k in range(count)
    )
    j = [sp.besselj(n, u_1) for n in range(3)]
    common = j[0] * sp.cos(beta) - j[2] * sp.cos(beta - 2 * gamma) - j[1] * sp.sin(beta - gamma)
    factor = -q_1 * alpha**2 / 2
    in_42 = factor * (common + j[1] * sp.sin(-beta - gamma))
    in_41 = factor * (common + j[1] + 2 * (-beta - gamma))
    assert value(in_42) == pytest.approx(harmonic, abs=1e-10)
    assert abs(value(in_41) - harmonic) > 0.1


def test_45_solves_another_equation() -> None:
    """Its correction solves V'' + V = -cos 2 alpha tau; the angle has no spring."""
    v = (sp.cos(2 * alpha * tau) - sp.cos(tau)) / -(1 - 4 * alpha**2)
    torque = sp.cos(2 * alpha * tau)
    assert sp.simplify(sp.diff(v, tau, 2) + v + torque) == 0
    inertia, friction = sp.Rational(1), sp.Rational(1, 100)
    assert abs(value(inertia * sp.diff(v, tau, 2) + friction * sp.diff(v, tau) + torque)) > 0.1


def test_34_and_45_are_sums_and_functions_of_tau() -> None:
    """Their brackets are what the integral over t from 0 to tau makes of sine and cosine."""
    t, w, s, c = sp.symbols("t w s c", positive=True)
    load = s * sp.sin(w * t) + c * sp.cos(w * t)
    integral = sp.integrate(sp.expand(sp.sin(t - tau) * load, trig=True), (t, 0, tau))
    sine, cosine = w * sp.sin(tau) - sp.sin(w * tau), sp.cos(tau) - sp.cos(w * tau)
    point = {w: 1.7, s: 0.7, c: -0.4, tau: 2.3}

    def at(expression: Any) -> float:
        return float(sp.N(expression.subs(point)))

    assert at((s * sine + c * cosine) / (1 - w**2)) == pytest.approx(at(integral))
    assert abs(at(s * sine * c * cosine / (1 - w**2)) - at(integral)) > 0.1


def test_the_bessel_functions_are_simplified_in_27() -> None:
    """The first term of (26); (25) has the functions themselves, which differ from it."""
    for n, simple in ((0, 1), (1, u_1 / 2)):
        assert sp.limit(sp.besselj(n, u_1) / simple, u_1, 0) == 1
        assert abs(value(sp.besselj(n, u_1) - simple)) > 1e-3


def test_36_has_the_amplitude_of_the_force() -> None:
    """The harmonic of cos(alpha tau) of the force in (7) is what (36) holds for the solution."""
    c, solution = nondimensional(EXAMPLE), paper_solution(EXAMPLE)
    scale = EXAMPLE.rod_length * EXAMPLE.stiffness  # (M + m) R_m omega_n^2
    assert float(c.force) == pytest.approx(EXAMPLE.force_amplitude / scale)
    a, b, q, u = (float(v) for v in (c.alpha, solution.beta, solution.q_1, solution.u_1))
    rest = q * ((1 - a**2) * np.cos(b) + 2 * c.rho * a * np.sin(b))
    rest -= c.epsilon * a**2 * u * np.cos(float(solution.gamma)) / 2
    assert float(rest) == pytest.approx(float(c.force))


def test_eigenvalues_of_62_do_not_decide() -> None:
    """A(tau) of a stable rotation has an eigenvalue outside the unit circle all the time."""
    solution = corrected_solution(EXAMPLE)
    assert np.all(rate_moduli(solution).max(axis=1) > 1)
    assert abs(floquet_multipliers(solution, EXAMPLE)[0]) < 1


def test_the_second_order_of_20_is_a_derivative() -> None:
    """Of N(V_0 + p V_1 + p^2 V_2) times p, for any N."""
    p, v_0, v_1, v_2 = sp.symbols("p v_0 v_1 v_2")
    n = sp.Function("N")
    series = sp.diff(p * n(v_0 + p * v_1 + p**2 * v_2), p, 2).subs(p, 0).doit() / 2
    slope = sp.diff(n(v_0), v_0)
    assert sp.simplify(series - slope * v_1) == 0
    assert second_order(as_printed=False) < 1e-5 < 1e-2 < second_order(as_printed=True)


def test_the_nonlinear_term_of_8_has_both_arguments() -> None:
    q_dd, theta = sp.symbols("q_dd theta")
    term = q_dd * sp.cos(theta)
    assert term.free_symbols == {q_dd, theta}
    # with the trial motion for both, it has the harmonics of (42); with theta for q it has none
    motion = TRIAL.motion(PHASES / TRIAL.alpha)
    both = np.mean(motion.q_ddot * np.cos(motion.theta) * np.cos(2 * PHASES))
    alone = np.mean(motion.theta_ddot * np.cos(motion.theta) * np.cos(2 * PHASES))
    assert abs(both) > 0.1 > 1e-9 > abs(alone)

"""Misprints of the hula_hoop paper that are no equations, or follow from a solution."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sp

from mbcheck.comparisons.papers.hula_hoop.derivation import (
    PHASES,
    TRIAL,
)
from mbcheck.comparisons.papers.hula_hoop.results import EXAMPLE
from mbcheck.reference.hula_hoop.theory import (
    nondimensional,
    paper_solution,
)

tau, u_1 = sp.symbols("tau u_1", real=True)


def value(expression: Any) -> float:
    return float(sp.N(expression.subs(u_1, 0.35)))


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


def test_the_nonlinear_term_of_8_has_both_arguments() -> None:
    q_dd, theta = sp.symbols("q_dd theta")
    term = q_dd * sp.cos(theta)
    assert term.free_symbols == {q_dd, theta}
    # with the trial motion for both, it has the harmonics of (42); with theta for q it has none
    motion = TRIAL.motion(PHASES / TRIAL.alpha)
    both = np.mean(motion.q_ddot * np.cos(motion.theta) * np.cos(2 * PHASES))
    alone = np.mean(motion.theta_ddot * np.cos(motion.theta) * np.cos(2 * PHASES))
    assert abs(both) > 0.1 > 1e-9 > abs(alone)

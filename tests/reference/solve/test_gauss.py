"""Gauss collocation: its order, its answers on stiff vibrations, its dense output."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.integrate import DOP853, solve_ivp

from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.reference import get_scene
from mbcheck.reference.scene import Array
from mbcheck.reference.solve import gauss
from mbcheck.reference.solve.single import solve

SLOW, FAST = 2.0, 3e4


def vibrations(t: Any, x: Any) -> Any:
    """A slow and a fast oscillator, the fast one at rest."""
    return np.array([x[2], x[3], -(SLOW**2) * x[0], -(FAST**2) * x[1]])


def exact(t: Any) -> Array:
    return np.array([np.cos(SLOW * t), 0 * t, -SLOW * np.sin(SLOW * t), 0 * t])


def test_the_tableau_is_that_of_gauss() -> None:
    """Its simplifying conditions B(2 s) and C(s), which make the order 2 s."""
    nodes = (1 + gauss.POINTS) / 2
    for power in range(2 * gauss.STAGES):
        assert gauss.WEIGHTS @ nodes**power / 2 == pytest.approx(1 / (power + 1), rel=1e-13)
    for power in range(gauss.STAGES):
        wanted = nodes ** (power + 1) / (power + 1)
        np.testing.assert_allclose(gauss.A @ nodes**power, wanted, atol=1e-14)


def test_antiderivatives() -> None:
    x = np.linspace(-1, 1, 7)
    for degree, values in enumerate(gauss.antiderivatives(x).T):
        integral = legendre.Legendre.basis(degree).integ(lbnd=-1)
        np.testing.assert_allclose(values, integral(x) / 2, atol=1e-15)


@pytest.mark.parametrize("rtol", [1e-6, 1e-9, 1e-12])
def test_a_mode_at_rest_costs_nothing(rtol: float) -> None:
    times = np.linspace(0, 10, 173)
    found = solve_ivp(
        vibrations, (0, 10), exact(0.0), gauss.Gauss, times, rtol=rtol, atol=rtol * np.ones(4)
    )
    assert found.success
    assert np.max(np.abs(found.y - exact(times))) < 10 * rtol
    assert found.nfev < 10_000
    explicit = FAST * 10 / 6  # steps that stability leaves to DOP853
    assert found.nfev < explicit * DOP853.n_stages / 50


def test_a_fast_mode_that_moves_is_followed() -> None:
    fast = np.array([0.0, 1.0, 0.0, 0.0])
    times = np.linspace(0, 0.01, 50)
    found = solve_ivp(
        vibrations, (0, 0.01), fast, gauss.Gauss, times, rtol=1e-10, atol=[1, 1e-10, 1, 1e-6]
    )
    np.testing.assert_allclose(found.y[1], np.cos(FAST * times), atol=1e-8)


def test_what_cannot_be_followed_is_no_success() -> None:
    """The solution of x'' = 2 x x' that has x' = x^2 ends at t = 1."""

    def rates(t: Any, x: Any) -> Any:
        return np.array([x[1], 2 * x[0] * x[1]])

    with np.errstate(all="ignore"):
        found = solve_ivp(rates, (0, 2), [1.0, 1.0], gauss.Gauss, rtol=1e-8, atol=1e-8 * np.ones(2))
    assert not found.success or not np.all(np.isfinite(found.y))


@pytest.mark.parametrize("model", ["connect", "connect_hard"])
def test_a_stiff_reference_is_that_of_the_explicit_method(model: str) -> None:
    case = get_scene("speed_regulator").case("rotation")
    own = get_engine("mujoco").bind(case, model).equations
    assert own.scene.stiff
    times = np.linspace(0, 0.5, 40)[1:]
    found = solve(own.scene, own.parameters, own.start(case), times)
    explicit = solve_ivp(
        own.scene.right_hand_side(own.parameters), (0, 0.5), own.start(case), DOP853, times,
        rtol=1e-12, atol=1e-13,
    )  # fmt: skip
    apart = np.max(np.abs(found.states - explicit.y), axis=1)
    assert np.all(apart < found.error_bound + 1e-10)
    assert np.all(found.error_bound < 1e-8)

"""Linearised matrices and their modes."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from mbcheck.reference import get_scene, linear
from mbcheck.reference.errors import (
    MbcheckError,
)
from mbcheck.reference.hula_hoop.equations import (
    PLATE,
    HulaHoop,
    coefficients,
)
from mbcheck.reference.linear import linearise, modes
from mbcheck.reference.scene import Array

SCENE = get_scene("hula_hoop")


REST = SCENE.state({})


def chain(n: int, tie: float) -> Array:
    """Return the stiffness (n, n) of beads on a clamped rod, each tied to its mirror."""
    bend = np.diff(np.eye(n + 2), 2, axis=0)[:, 2:] * float(n**2)
    return bend.T @ bend + tie * (np.eye(n) - np.eye(n)[::-1])


# Modes ----------------------------------------------------------------------------------


def linear_modes(p: HulaHoop, theta: float, damped: bool = False) -> list[linear.Mode]:
    mass, damping, stiffness = linearise(SCENE, p, SCENE.state({"theta": theta}))
    return modes(mass, damping if damped else 0 * damping, stiffness)


@pytest.mark.parametrize("ratio", [0.0, 1.7])
@pytest.mark.parametrize("free_mass", [1e-6, 0.045, 1e4])
def test_undamped_modes(ratio: float, free_mass: float) -> None:
    p = HulaHoop(inertia_ratio=ratio, free_mass=free_mass)
    c = coefficients(p)
    across, aligned = (linear_modes(p, theta) for theta in (0.0, np.pi / 2))
    for found, square in (
        (across, c.stiffness * c.inertia / c.determinant),
        (aligned, c.stiffness / c.mass),
    ):
        assert [mode.omega for mode in found] == pytest.approx([0, np.sqrt(square)], rel=1e-7)
        assert [mode.damping_ratio for mode in found] == [None, pytest.approx(0, abs=1e-12)]
        assert found[1].hertz == found[1].omega / (2 * np.pi)
    if ratio == 0:
        assert across[1].omega == pytest.approx(np.sqrt(p.stiffness / p.main_mass), rel=1e-7)


def test_linearised_matrices() -> None:
    p = PLATE
    c = coefficients(p)
    mass, damping, stiffness = linearise(SCENE, p, SCENE.state({}))
    np.testing.assert_allclose(mass, [[c.mass, c.coupling], [c.coupling, c.inertia]], rtol=1e-15)
    np.testing.assert_allclose(damping, np.diag([c.damping, c.hinge_damping]), rtol=1e-15)
    np.testing.assert_allclose(stiffness, np.diag([c.stiffness, 0.0]), rtol=1e-15)


@pytest.mark.skipif(bool(np.finfo(np.longdouble).eps > 1e-18), reason="no extended precision here")
@pytest.mark.parametrize("share", [0.0, 0.1])
def test_a_slow_mode_keeps_the_digits_of_the_matrices(share: float) -> None:
    """Its square is 1e7 times smaller than that of the fastest, whose rounding LAPACK leaves."""
    n = 12
    stiffness = chain(n, 1e9)
    damping = share * chain(n, 0.0) / n**2 + share * np.diff(np.eye(n + 1), axis=1)[:n]
    slow = min(modes(np.eye(n), damping, stiffness), key=lambda mode: mode.omega)
    with mpmath.workdps(60):
        zero, one, k, c = (
            mpmath.matrix(matrix.tolist())
            for matrix in (np.zeros((n, n)), np.eye(n), stiffness, damping)
        )
        system = mpmath.matrix(2 * n, 2 * n)
        system[:n, :n], system[:n, n:], system[n:, :n], system[n:, n:] = zero, one, -k, -c
        right = min(mpmath.eig(system, left=False, right=False), key=abs)
    assert slow.omega == pytest.approx(float(abs(right)), rel=2e-12)
    assert slow.re == pytest.approx(float(right.real), abs=2e-12 * slow.omega)


def test_modes_that_grow() -> None:
    falling = modes(np.eye(1), np.zeros((1, 1)), -4 * np.eye(1))
    assert [(mode.re, mode.im, mode.damping_ratio) for mode in falling] == [(2, 0, -1)]


def test_modes_of_nothing_but_free_directions() -> None:
    zero = np.zeros((2, 2))
    assert [mode.omega for mode in modes(np.diag([1.0, 2.0]), zero, zero)] == [0, 0]


@pytest.mark.parametrize("damping", [np.zeros((2, 2)), np.eye(2)])
@pytest.mark.parametrize("mass", [np.ones((2, 2)), np.diag([1.0, 0.0]), np.diag([1.0, -1.0])])
def test_singular_mass_is_told(mass: Array, damping: Array) -> None:
    with pytest.raises(MbcheckError, match="not positive definite"):
        modes(mass, damping, np.eye(2))


def test_linearised_model_that_is_not_finite_is_told() -> None:
    with pytest.raises(MbcheckError, match="not finite"):
        modes(np.eye(2), np.full((2, 2), np.nan), np.eye(2))

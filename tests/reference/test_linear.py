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


@pytest.mark.parametrize("ratio", [0.0, 1.7])
def test_matrices_energy_and_accelerations_belong_together(ratio: float) -> None:
    rng = np.random.default_rng(5)
    p = HulaHoop(inertia_ratio=ratio)
    c = coefficients(p)
    q, v, u = rng.normal(size=(2, 50)), rng.normal(size=(2, 50)), rng.normal(size=50)
    force = np.array(SCENE.forces(u, q, v, c, np))
    a = np.array(SCENE.accelerations(u, q, v, c, np))
    for i in range(50):
        mass = np.array(SCENE.mass_matrix(q[:, i], c, np))
        np.testing.assert_allclose(a[:, i], np.linalg.solve(mass, force[:, i]), rtol=1e-10)
        energy = v[:, i] @ mass @ v[:, i] / 2 + c.stiffness * q[0, i] ** 2 / 2
        assert SCENE.energy(q[:, i], v[:, i], c) == pytest.approx(energy, rel=1e-12)
        power = -v[:, i] @ SCENE.damping_matrix(c) @ v[:, i]
        powers = SCENE.powers(u[i], q[:, i], v[:, i], c)
        assert powers["damper"] + powers["hinge"] == pytest.approx(power, rel=1e-12)
    _, damping, _ = linearise(SCENE, p, REST)
    np.testing.assert_allclose(SCENE.damping_matrix(c), damping, rtol=1e-14)


def test_damped_modes_with_the_rod_aligned() -> None:
    """There the two coordinates are not coupled: rho at omega_n, and a hinge that runs down."""
    p = HulaHoop()
    zero, hinge, slide = linear_modes(p, np.pi / 2, damped=True)
    assert zero.omega < 1e-9
    assert zero.damping_ratio is None
    assert hinge.re == pytest.approx(-p.hinge_damping_ratio * p.omega_n, rel=1e-9)
    assert hinge.im == 0
    assert hinge.damping_ratio == pytest.approx(1)
    assert slide.omega == pytest.approx(p.omega_n, rel=1e-9)
    assert slide.damping_ratio == pytest.approx(p.damping_ratio, rel=1e-9)
    assert slide.im > 0


def test_damped_modes_with_the_rod_across_are_roots_of_the_determinant() -> None:
    p = PLATE
    mass, damping, stiffness = linearise(SCENE, p, SCENE.state({}))
    for mode in linear_modes(p, 0.0, damped=True)[1:]:
        s = complex(mode.re, mode.im)
        matrix = s**2 * mass + s * damping + stiffness
        size = abs(s) ** 2 * mass + abs(s) * damping + stiffness
        assert abs(np.linalg.det(matrix)) < 1e-9 * np.prod(np.diag(size))
        assert mode.re < 0


def test_overdamped_slide_has_two_real_eigenvalues() -> None:
    p = HulaHoop(damping_ratio=2.0, hinge_damping_ratio=0.0)
    zero, slow, fast = linear_modes(p, np.pi / 2, damped=True)
    assert zero.omega == 0  # split off exactly, although it is double and defective
    roots = -p.omega_n * (2 + np.array([-1, 1]) * np.sqrt(3))
    np.testing.assert_allclose([slow.re, fast.re], roots, rtol=1e-12)
    assert slow.im == fast.im == 0


def test_a_free_direction_is_split_off() -> None:
    """c_m = 0 and c > 0: the double zero would cost the other modes nothing, itself half."""
    p = HulaHoop(hinge_damping_ratio=0.0)
    c = coefficients(p)
    zero, other = linear_modes(p, 0.0, damped=True)
    assert (zero.re, zero.im, zero.damping_ratio) == (0, 0, None)
    reduced = c.determinant / c.inertia
    assert other.omega == pytest.approx(np.sqrt(c.stiffness / reduced), rel=1e-12)
    assert other.re == pytest.approx(-c.damping / (2 * reduced), rel=1e-12)


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

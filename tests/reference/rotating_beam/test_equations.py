"""rotating_beam: equations of small deflections by Lagrange, shapes and drives."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad

from mbcheck.reference.errors import ParameterError, UnknownNameError
from mbcheck.reference.rotating_beam import (
    EXTENSIBLE,
    FIGURE_4,
    FIGURE_5,
    QUICK,
    SCENE,
    SECOND_ORDER,
    STEADY,
    ZERO_ORDER,
    beam_scene,
)
from mbcheck.reference.rotating_beam.parameters import RotatingBeam, coefficients, drive
from mbcheck.reference.rotating_beam.shapes import Shapes, cantilever_modes, pieces, polynomials
from mbcheck.reference.scene import EquationsOfMotion

UNIT = RotatingBeam(
    length=1.0,
    area=1.0,
    second_moment=1.0,
    density=1.0,
    youngs_modulus=1.0,
    ramp_time=0.0,
)
"""Dimensionless: EI = rho A = L = 1; with A = 1 it is as soft along as across."""


# Equations of motion ------------------------------------------------------------------------


def crafted(n: int, k: int, place: float) -> Shapes:
    """Two Gauss points and the mass, any numbers: the equations hold for all of them."""
    random = np.random.default_rng(5)
    return Shapes(
        angle=random.normal(size=(2, n)),
        curvature=random.normal(size=(2, n)),
        stretch=random.normal(size=(2, k)),
        integral=random.normal(size=(3, 2)),
        weights=np.array([0.3, 0.7]),
        stations=np.array([0.2, 0.6, place]),
    )


@pytest.fixture(scope="module", params=["second_order", "zero_order"])
def derived(request: pytest.FixtureRequest) -> tuple[EquationsOfMotion, Callable[..., Any]]:
    """Return a scene with n = 2, k = 1 and (q, v, c) -> M, f of its Lagrangian."""
    theory, k = request.param, 1
    at = crafted(2, k, 0.8)
    small = sp.Symbol("epsilon")
    a, v, q = (sp.symbols(f"{letter}0:{3 + k}") for letter in "avq")
    symbols = sp.symbols("d J B m EI EA g_x g_y u")
    delta, hub, beam, point, bending, axial, g_x, g_y, u = symbols

    def kept(value: Any) -> Any:
        """Return what is of second order in the displacements of the small deflections."""
        return sum(value.diff(small, i).subs(small, 0) / sp.factorial(i) for i in range(3))

    def rate(value: Any) -> Any:
        """Differentiate by time."""
        return sum(value.diff(x) * y for x, y in zip((*q, *v), (*v, *a), strict=True))

    bend, stretch = sp.Matrix(q[1:3]), sp.Matrix(q[3:])
    angle, curvature = (list(sp.Matrix(part) * bend) for part in (at.angle, at.curvature))
    strain = list(sp.Matrix(at.stretch) * stretch)
    integral = sp.Matrix(at.integral)
    # v, u are of first order and u_f of second: what is kept of T is of second order
    u_f = integral * sp.Matrix([-(slope**2) / 2 for slope in angle])
    u_1, across = integral * sp.Matrix(strain), integral * sp.Matrix(angle)
    keep = 0 if theory == "zero_order" else small**2
    places = [
        (delta + x + small * u_1[i] + keep * u_f[i], small * across[i])
        for i, x in enumerate(at.stations)
    ]
    kinetic, weight = hub * v[0] ** 2 / 2, sp.S(0)
    for mass, (x, y) in zip([*(beam * w for w in at.weights), point], places, strict=True):
        point_x = sp.cos(q[0]) * x - sp.sin(q[0]) * y
        point_y = sp.sin(q[0]) * x + sp.cos(q[0]) * y
        term = (rate(point_x) ** 2 + rate(point_y) ** 2).subs(q[0], 0)  # any angle is as good
        kinetic += mass * kept(term) / 2
        weight += mass * kept(g_x * point_x + g_y * point_y)
    lagrangian = (
        kinetic
        + weight
        - sum(
            w * (bending * x**2 + axial * e**2) / 2
            for w, x, e in zip(at.weights, curvature, strain, strict=True)
        )
    )
    momenta = [lagrangian.diff(speed) for speed in v]
    matrix = sp.Matrix([[item.diff(speed) for speed in v] for item in momenta])
    rest = sp.Matrix(
        [
            lagrangian.diff(x) - sum(item.diff(y) * speed for y, speed in zip(q, v, strict=True))
            for x, item in zip(q, momenta, strict=True)
        ]
    )
    rest[0] += u
    function = sp.lambdify((*q, *v, *symbols), (matrix, rest), cse=True)
    return beam_scene(theory, 2, k, crafted), function


def random_parameters(random: Any, **changes: Any) -> RotatingBeam:
    """Return parameters near 1, mass, hub and gravity included."""
    words = ("mass_position", "drive", "segments", "scheme", "element")
    names = [name for name in RotatingBeam.names() if name not in words]
    values = {name: 10 ** random.uniform(-0.5, 0.5) for name in names}
    return RotatingBeam(**values | {"mass_position": 0.8} | changes)


def test_hand_written_equations_are_those_of_lagrange(
    derived: tuple[EquationsOfMotion, Callable[..., Any]],
) -> None:
    scene, lagrange = derived
    random = np.random.default_rng(2)
    size = len(scene.coordinates)
    for kind in ("torque", "prescribed") * 10:
        p = random_parameters(random, drive=kind)
        c = scene.coefficients(p)
        q, v = random.normal(size=(2, size))
        u = random.normal()
        given = c.hub_ratio, c.hub, c.beam, c.point, c.bending, c.axial, c.gravity_x, c.gravity_y, u
        mass, rest = (np.array(item, dtype=float) for item in lagrange(*q, *v, *given))
        rest = rest[:, 0]
        if kind == "prescribed":
            rest -= u * mass[:, 0]
            mass[0], mass[:, 0], rest[0] = np.eye(size)[0], np.eye(size)[0], u
        np.testing.assert_allclose(scene.mass_matrix(q, c), mass, rtol=1e-12, atol=1e-12)
        scale = np.max(np.abs(rest))
        np.testing.assert_allclose(scene.forces(u, q, v, c), rest, atol=1e-12 * scale)
        wanted = np.linalg.solve(mass, rest)
        found = scene.accelerations(u, q, v, c)
        tolerance = 1e-14 * np.linalg.cond(mass) * np.max(np.abs(wanted)) + 1e-12
        np.testing.assert_allclose(found, wanted, atol=tolerance)


SCENES = [SCENE, EXTENSIBLE, SECOND_ORDER, ZERO_ORDER]


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.title)
@pytest.mark.parametrize("kind", ["prescribed", "torque"])
def test_power_is_the_rate_of_energy_and_torque_that_of_momentum(
    scene: EquationsOfMotion, kind: str
) -> None:
    random = np.random.default_rng(3)
    n = len(scene.coordinates)
    for place in (1.0, 0.4):
        p = random_parameters(random, drive=kind, mass_position=place)
        c = scene.coefficients(p)
        q, v = random.normal(size=(2, n)) / 5
        u = 3.0
        a = np.array(scene.accelerations(u, q, v, c))
        h = 1e-30
        rate = scene.energy(q + 1j * h * v, v + 1j * h * a, c).imag / h
        power = scene.powers(u, q, v, c)["hub"]
        size = np.sum(np.abs(v * np.array(scene.forces(u, q, v, c))))
        assert abs(rate - power) < 1e-10 * size
        c = scene.coefficients(level := p.replace(gravity_x=0.0, gravity_y=0.0))
        a, power = np.array(scene.accelerations(u, q, v, c)), scene.powers(u, q, v, c)["hub"]
        momentum = scene.invariants(level.replace(drive="torque"))["momentum"]  # type: ignore[misc]
        torque = momentum(q + 1j * h * v, v + 1j * h * a, c).imag / h
        assert abs(torque * v[0] - power) < 1e-10 * size
        if kind == "prescribed":
            assert a[0] == u


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.title)
def test_points_at_once_are_points_one_by_one(scene: EquationsOfMotion) -> None:
    """Every parameter an array, mass positions too; beside states with one axis more."""
    random = np.random.default_rng(4)
    n = len(scene.coordinates)
    single = [random_parameters(random, mass_position=place) for place in (0.3, 1.0, 0.3, 0.7)]
    single[3] = single[3].replace(mass=0.0)
    words = ("drive", "scheme", "element")
    names = [name for name in RotatingBeam.names() if name not in words]
    p = RotatingBeam().replace(
        **{name: np.array([getattr(one, name) for one in single]) for name in names}
    )
    x = random.normal(size=(2 * n, 3, 4)) / 5
    many = scene.right_hand_side(p)(0.3, x)
    c = scene.coefficients(p)
    energies = scene.energy(x[:n], x[n:], c)
    mass = np.array(scene.mass_matrix(x[:n], c))
    tips = scene.observe(x, p)["tip_axial_dot"]
    assert mass.shape == (n, n, 3, 4)
    for i, one in enumerate(single):
        derivative, single_c = scene.right_hand_side(one), scene.coefficients(one)
        for j in range(3):
            at = x[:, j, i].copy()
            wanted = derivative(0.3, at)
            scale = np.max(np.abs(wanted))
            np.testing.assert_allclose(many[:, j, i], wanted, rtol=1e-9, atol=1e-11 * scale)
            np.testing.assert_allclose(energies[j, i], scene.energy(at[:n], at[n:], single_c))
            np.testing.assert_allclose(
                mass[..., j, i], scene.mass_matrix(at[:n], single_c), atol=1e-14
            )
            np.testing.assert_allclose(tips[j, i], scene.observe(at, one)["tip_axial_dot"])


def test_tip_is_where_the_integral_leads() -> None:
    """By adaptive quadrature of the interpolated angle, and rates by a complex step."""
    for scene in SCENES:
        n = len(scene.coordinates)
        x = np.random.default_rng(6).normal(size=2 * n) / 5
        moved: Any = x + 1e-30j * np.concatenate([x[n:], np.zeros(n)])
        found, p = scene.observe(x, QUICK), QUICK
        rates = scene.observe(moved, p)
        for name in ("tip_deflection", "tip_axial"):
            np.testing.assert_allclose(found[f"{name}_dot"], rates[name].imag / 1e-30)
    at = polynomials(8, 0, 1.0)
    smooth = 1.5 * np.sin(np.pi / 2 * at.stations[:-1])
    bent = np.linalg.lstsq(at.angle, smooth, rcond=None)[0]
    found = SCENE.observe(np.concatenate([[0.3], bent, np.zeros(9)]), QUICK)
    for name, f in (("tip_deflection", np.sin), ("tip_axial", lambda z: np.cos(z) - 1)):
        wanted, _ = quad(lambda s, f=f: f(1.5 * np.sin(np.pi / 2 * s)), 0, 1, epsabs=1e-13)
        np.testing.assert_allclose(found[name], QUICK.length * wanted, rtol=1e-7)


# Shapes -------------------------------------------------------------------------------------


@pytest.mark.parametrize("place", [1.0, 0.95, 0.5, 0.1, 1 / 3])
@pytest.mark.parametrize("n", [2, 5, 8, 12])
def test_shapes_are_piecewise_polynomials_with_a_free_tip(n: int, place: float) -> None:
    at = polynomials(n, 4, place)
    parts = pieces(n, place)
    s = at.stations[:-1]
    assert at.angle.shape == (len(s), n)
    assert at.stretch.shape == (len(s), 4)
    assert at.stations[-1] == place
    assert np.sum(at.weights) == pytest.approx(1, abs=1e-14)
    assert np.linalg.matrix_rank(at.angle, 1e-6) == n
    assert np.max(np.abs(at.angle)) < 20
    np.testing.assert_allclose(at.integral @ np.cos(3 * s), np.sin(3 * at.stations) / 3, atol=1e-14)
    np.testing.assert_allclose((at.integral @ at.curvature)[:-1], at.angle, atol=1e-11)
    pieced = [(s > start) & (s < end) for start, end, _ in parts]
    slopes = []
    for (start, end, degree), inside in zip(parts, pieced, strict=True):
        fit = np.polynomial.legendre.Legendre.fit(
            s[inside], at.angle[inside][:, 0], degree, [start, end]
        )
        assert np.max(np.abs(fit(s[inside]) - at.angle[inside][:, 0])) < 1e-10
        slopes.append((fit.deriv()(start), fit.deriv()(end), fit(start), fit(end)))
    scale = np.max(np.abs(at.curvature[:, 0]))
    assert abs(slopes[0][2]) < 1e-10
    assert abs(slopes[-1][1]) < 1e-8 * scale
    if len(parts) == 2:
        assert abs(slopes[0][1] - slopes[1][0]) < 1e-8 * scale
        assert abs(slopes[0][3] - slopes[1][2]) < 1e-10


def test_cantilever_modes_are_orthogonal_and_have_the_known_frequencies() -> None:
    at = cantilever_modes(8, 2, 1.0)
    np.testing.assert_allclose((at.integral @ at.curvature)[:-1], at.angle, atol=1e-9)
    line = at.integral[:-1] @ at.angle
    mass, stiffness = (part.T * at.weights @ part for part in (line, at.curvature))
    size = np.sqrt(np.diag(mass))
    np.testing.assert_allclose(mass / np.outer(size, size), np.eye(8), atol=1e-9)
    roots = np.sqrt(np.sqrt(np.diag(stiffness) / np.diag(mass)))
    known = [1.875104068711961, 4.694091132974175, 7.854757438237613, 10.995540734875467]
    np.testing.assert_allclose(roots[:4], known, rtol=1e-9)


# Drives -------------------------------------------------------------------------------------


def test_drives_are_those_of_the_paper() -> None:
    """(22) by its integral; (23); both over afterwards."""
    c = coefficients(FIGURE_4)
    for end in (4.0, 15.0, 18.0):
        speed, _ = quad(lambda t: drive(t, c), 0, min(end, 15.0), epsabs=1e-12)
        t = min(end, 15.0)
        wanted = 10 / 15 * (t - 15 / (2 * np.pi) * np.sin(2 * np.pi * t / 15))
        assert speed == pytest.approx(wanted, rel=1e-10)
    c = coefficients(FIGURE_5)
    times = np.array([0.0, 2.5, 7.5, 10.0, 11.0])
    np.testing.assert_allclose(drive(times, c), [0, 1, -1, 0, 0], atol=1e-12)
    assert drive(0.3, coefficients(STEADY)) == 0
    np.testing.assert_allclose(drive(np.array([15.0, 99.0]), coefficients(FIGURE_4)), 0)


# The contract -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"mass_position": 1.2}, "at most 1"),
        ({"mass_position": 0.0}, "greater than 0"),
        ({"segments": 1}, "2 or greater"),
        ({"segments": 4.5}, "whole"),
        ({"hub_radius": -1.0}, "0 or greater"),
        ({"torque_period": 0.0}, "greater than 0"),
    ],
)
def test_impossible_parameters_are_refused(changes: dict[str, float], words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        RotatingBeam().replace(**changes)


def test_words_are_refused_by_name() -> None:
    for name in ("drive", "scheme", "element"):
        with pytest.raises(UnknownNameError, match="nonsense"):
            RotatingBeam().replace(**{name: "nonsense"})

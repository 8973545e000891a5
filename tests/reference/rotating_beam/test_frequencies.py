"""Frequencies of rotating_beam: routes against each other, against anchors, against the paper."""

from __future__ import annotations

from itertools import pairwise

import mpmath
import numpy as np
import pytest
from scipy.linalg import eigh

from mbcheck.reference.errors import MbcheckError, NoOrbitError, ParameterError, UnknownNameError
from mbcheck.reference.linear import linearise, modes
from mbcheck.reference.rotating_beam import beam_scene
from mbcheck.reference.rotating_beam.frequencies.assumed_modes import (
    assumed_modes,
    best_mass_position,
    crossover,
    matching_speed,
    rest_roots,
)
from mbcheck.reference.rotating_beam.frequencies.numbers import (
    PLANES,
    Numbers,
    time_unit,
)
from mbcheck.reference.rotating_beam.frequencies.ritz import ritz
from mbcheck.reference.rotating_beam.frequencies.stretching import (
    frequencies,
    steady_state,
    stretching,
)
from mbcheck.reference.rotating_beam.parameters import RotatingBeam
from mbcheck.tests.support.exact.shooting import shooting

PAPER = RotatingBeam(hub_radius=8.0)
UNIT = time_unit(PAPER)
RATIOS = [kg / (PAPER.density * PAPER.area * PAPER.length) for kg in (0.4, 0.8, 1.2)]

# Inextensible -------------------------------------------------------------------------------


def test_beam_at_rest() -> None:
    known = np.array([1.8751040687119611664, 4.6940911329741745764, 7.8547574382376125649])
    np.testing.assert_allclose(rest_roots(3), known, rtol=1e-14)
    for plane in PLANES:
        np.testing.assert_allclose(ritz(Numbers(), plane, 3).omega, known**2, rtol=1e-13)
    np.testing.assert_allclose(assumed_modes(Numbers(), 3, count=3), known**2, rtol=1e-12)


def test_rotating_beam_of_the_literature() -> None:
    """Wright, Smith, Thresher, Wang (1982), the paper's reference [3]: flapwise, no hub."""
    first = [3.5160, 3.6816, 4.1373, 4.7973, 5.5850, 6.4495, 7.3604]
    first += [8.2996, 9.2568, 10.2257, 11.2023, 12.1843, 13.1702]
    found = [ritz(Numbers(gamma=float(g)), "flapwise").omega for g in range(13)]
    np.testing.assert_allclose([omega[0] for omega in found], first, atol=6e-5)
    assert found[12][1] == pytest.approx(37.6031, abs=6e-5)


GRID = [
    Numbers(delta, 12.0, alpha, beta)
    for delta in (0.0, 1.0)
    for alpha, beta in ((0.0, 1.0), (0.5, 1.0), (2.0, 0.3), (1.0, 0.01), (1.0, 0.999))
]
QUICK = GRID[0], GRID[7]
"""Without hub and mass; with both, the mass inside."""


@pytest.mark.parametrize(
    "n", [n if n in QUICK else pytest.param(n, marks=pytest.mark.slow) for n in GRID]
)
def test_two_routes_agree(n: Numbers) -> None:
    found = ritz(n)
    other, bound = shooting(n)
    np.testing.assert_allclose(found.omega, other, rtol=2e-12)
    assert np.all(np.abs(found.omega - other) < found.bound + bound)
    assert np.all(found.bound < 1e-11 * found.omega)
    flap = ritz(n, "flapwise").omega
    np.testing.assert_allclose(found.omega**2, flap**2 - n.gamma**2, rtol=1e-11)


@pytest.mark.slow
def test_more_frequencies_and_high_speed() -> None:
    for n, count in ((Numbers(0.5, 1.0, 0.7, 0.6), 5), (Numbers(1.0, 30.0, 0.5, 0.4), 2)):
        found = ritz(n, "flapwise", count)
        other, bound = shooting(n, "flapwise", count)
        assert np.all(np.abs(found.omega - other) < found.bound + bound)


def test_a_bound_holds_in_many_digits() -> None:
    """The determinant at the tip with 40 digits, by one power series about the clamp."""
    n = Numbers(0.3, 9.0, 0.8, 1.0)
    with mpmath.workdps(40):
        square = mpmath.mpf(n.gamma) ** 2
        delta, alpha = mpmath.mpf(n.delta), mpmath.mpf(n.alpha)
        tau = delta + mpmath.mpf(1) / 2 + alpha * (delta + 1), -delta, -mpmath.mpf(1) / 2

        def determinant(load: mpmath.mpf) -> mpmath.mpf:
            ends = []
            for start in (2, 3):
                w = [mpmath.mpf(int(i == start)) for i in range(4)]
                for k in range(200):
                    # w'''' = load w + square (tau w')'
                    slopes = [
                        (i + 1) * w[i + 1] if 0 <= i < len(w) - 1 else 0 for i in range(k + 2)
                    ]
                    product = sum(tau[j] * slopes[k + 1 - j] for j in range(3) if k + 1 >= j)
                    factor = (k + 1) * (k + 2) * (k + 3) * (k + 4)
                    w.append((load * w[k] + square * (k + 1) * product) / factor)
                value = mpmath.fsum(w)
                slope = mpmath.fsum(k * c for k, c in enumerate(w))
                second = mpmath.fsum(k * (k - 1) * c for k, c in enumerate(w))
                third = mpmath.fsum(k * (k - 1) * (k - 2) * c for k, c in enumerate(w))
                pull = square * alpha * (delta + 1)
                ends.append((second, third - pull * slope + load * alpha * value))
            return ends[0][0] * ends[1][1] - ends[0][1] * ends[1][0]

        found = ritz(n, "flapwise")
        for omega, bound in zip(found.omega, found.bound, strict=True):
            exact = mpmath.sqrt(mpmath.findroot(determinant, mpmath.mpf(omega) ** 2))
            assert abs(exact - omega) < bound
            assert abs(exact - omega) < 1e-12 * omega


@pytest.mark.parametrize("place", [0.4, 1.0])
def test_the_nonlinear_scene_has_these_frequencies(place: float) -> None:
    """A third formulation: the angle as unknown, linearised by complex steps."""
    p = PAPER.replace(mass=0.8, mass_position=place, ramp_time=0.0, angular_speed=4 / UNIT)
    scene = beam_scene("inextensible", 18)
    found = modes(*linearise(scene, p, scene.state({"theta_dot": p.angular_speed})), steady=[0])
    omega = [mode.omega for mode in found[1:3]]
    np.testing.assert_allclose(omega, frequencies(p).omega, rtol=1e-8)


HANGING = Numbers(0.5, 0.0, 0.7, 0.6, weight=40.0)


@pytest.mark.parametrize("plane", PLANES)
def test_two_routes_agree_of_a_beam_that_hangs(plane: str) -> None:
    found, (other, bound) = ritz(HANGING, plane, 3), shooting(HANGING, plane, 3)
    assert np.all(np.abs(found.omega - other) < found.bound + bound)
    np.testing.assert_allclose(found.omega, other, rtol=1e-11)
    stiff = [stretching(HANGING, s, plane, 3).omega / found.omega - 1 for s in (1e6, 1e7)]
    np.testing.assert_allclose(stiff[0] / stiff[1], 10, rtol=0.05)
    assert np.all(np.abs(stiff[1]) < 1e-4)


def test_a_string_that_hangs_from_a_stiff_clamp() -> None:
    """Far heavier than it is stiff: Bessel's function's zeros."""
    omega = ritz(Numbers(weight=1e4), "flapwise").omega / 1e2
    np.testing.assert_allclose(omega, [2.404825557695773 / 2, 5.520078110286311 / 2], rtol=0.02)


@pytest.mark.parametrize("place", [0.4, 1.0])
def test_the_scene_that_hangs_has_these_frequencies(place: float) -> None:
    """Linearised by complex steps; and a stiff beam swings with a free hub as a pendulum does."""
    p = PAPER.replace(mass=0.8, mass_position=place, gravity_x=-3.0, gravity_y=9.0)
    p = p.replace(angular_speed=0.0)
    scene = beam_scene("inextensible", 18)
    hanging = scene.state(scene.equilibria["hanging"](p))
    found = modes(*linearise(scene, p, hanging), steady=[0])
    omega = [mode.omega for mode in found[1:3]]
    np.testing.assert_allclose(omega, frequencies(p).omega, rtol=1e-8)
    stiff = p.replace(drive="torque", youngs_modulus=1e4 * p.youngs_modulus)
    mass, _, stiffness = linearise(scene, stiff, hanging)
    slow = np.sqrt(1 / eigh(mass, stiffness, eigvals_only=True)[-1])
    line = p.density * p.area * p.length
    moment = line * (p.hub_radius + p.length / 2) + p.mass * (p.hub_radius + place * p.length)
    assert slow == pytest.approx(np.sqrt(np.hypot(3, 9) * moment / mass[0, 0]), rel=1e-3)


def test_gravity_leaves_rest_alone() -> None:
    p = PAPER.replace(gravity_x=9.81)
    for name, words in (("rotation", "no steady rotation"), ("hanging", "does not rest")):
        with pytest.raises(NoOrbitError, match=words):
            beam_scene().equilibria[name](p)
    with pytest.raises(NoOrbitError, match="hangs nowhere"):
        beam_scene().equilibria["hanging"](PAPER)


def test_mass_at_the_clamp_is_no_mass() -> None:
    bare = ritz(Numbers(0.5, 6.0)).omega
    np.testing.assert_allclose(ritz(Numbers(0.5, 6.0, 3.0, 0.0)).omega, bare, rtol=1e-13)
    np.testing.assert_allclose(ritz(Numbers(0.5, 6.0, 3.0, 1e-5)).omega, bare, rtol=1e-8)


# Continua that stretch ----------------------------------------------------------------------


@pytest.mark.parametrize("n", [Numbers(0.0, 12.0), Numbers(1.0, 6.0, 0.5, 0.4)])
def test_stiff_beams_do_not_stretch(n: Numbers) -> None:
    for plane in PLANES:
        exact = ritz(n, plane).omega
        gaps = [1 - stretching(n, slenderness, plane).omega / exact for slenderness in (1e6, 1e7)]
        assert np.all(gaps[1] > 0)
        np.testing.assert_allclose(gaps[0], 10 * gaps[1], rtol=1e-3)


@pytest.mark.parametrize("n", [Numbers(0.0, 12.0), Numbers(1.0, 6.0, 0.5, 0.4)])
def test_without_shear_the_stretched_beams_agree(n: Numbers) -> None:
    """Two formulations: angle from v', and an angle of its own; with a strong stretch."""
    normal = stretching(n, 1e4).omega
    soft, stiff = (stretching(n, 1e4, shear=shear).omega for shear in (1e5, 2e5))
    assert np.all(soft < stiff)
    np.testing.assert_allclose(2 * stiff - soft, normal, rtol=3e-7)  # the next order of 1/shear
    assert np.all(stretching(n, 1e4, shear=1e5, rotary=1e-4).omega < soft)
    plain = stretching(n, 1e4, shear=1e5, rotary=1e-9).omega
    np.testing.assert_allclose(plain, soft, rtol=1e-6)


def test_steady_state_is_in_balance() -> None:
    n, slenderness = Numbers(0.6, 9.0, 0.7, 0.4), 2e3
    state = steady_state(n, slenderness)
    for element, (a, b) in enumerate(pairwise((0.0, 0.4, 1.0))):
        x = np.linspace(a, b, 2001)
        y, force = state(x, np.full(len(x), element))
        slope = np.gradient(y, x, edge_order=2)
        np.testing.assert_allclose(slope, 1 + force / slenderness, rtol=1e-6)
        np.testing.assert_allclose(np.gradient(force, x, edge_order=2), -81 * y, rtol=1e-5)
    (start, _), (_, end) = (state(np.array([x]), np.array([e])) for x, e in ((0, 0), (1, 1)))
    assert start[0] == pytest.approx(0.6)
    assert abs(end[0]) < 1e-12
    inner, outer = (state(np.array([0.4]), np.array([e])) for e in (0, 1))
    assert inner.force[0] - outer.force[0] == pytest.approx(81 * 0.7 * inner.y[0])


def test_gap_between_continua_in_the_papers_beam() -> None:
    p = PAPER.replace(hub_radius=0.0, angular_speed=12 / UNIT)
    inextensible, extensible = (
        frequencies(p, continuum=name) for name in ("inextensible", "extensible")
    )
    gap = 1 - extensible.omega / inextensible.omega
    np.testing.assert_allclose(gap, [2.485e-4, 4.908e-5], rtol=2e-3)
    shear = p.youngs_modulus * p.area / 2.6 * 5 / 6
    soft = frequencies(p, continuum="shear_flexible", shear_stiffness=shear, rotary_inertia=True)
    assert np.all(soft.omega < extensible.omega)
    assert np.all(1 - soft.omega / extensible.omega < 3e-4)
    # the plain spectrum of the stretched state is not chordwise
    flap = frequencies(p, "flapwise", continuum="extensible")
    assert np.all(flap.omega > 1.05 * extensible.omega)


def test_what_cannot_be_asked() -> None:
    with pytest.raises(UnknownNameError):
        frequencies(PAPER, plane="edgewise")
    with pytest.raises(UnknownNameError):
        frequencies(PAPER, continuum="rigid")
    with pytest.raises(ParameterError, match="shear_stiffness"):
        frequencies(PAPER, continuum="shear_flexible")
    with pytest.raises(ParameterError, match="plane of rotation"):
        stretching(Numbers(), 1e5, "flapwise", shear=1e5)
    with pytest.raises(ParameterError, match="EA"):
        stretching(Numbers(0.0, 12.0), 50.0)
    for count in (0, 13):
        with pytest.raises(ParameterError, match="count"):
            ritz(Numbers(), count=count)
    with pytest.raises(ParameterError, match="modes"):
        assumed_modes(Numbers(), 1, count=2)
    with pytest.raises(MbcheckError, match="lower speed"):
        ritz(Numbers(gamma=1e5))


# The paper's assumed modes ------------------------------------------------------------------


def test_assumed_modes_come_from_above() -> None:
    n = Numbers(1.0, 8.0, 0.5, 0.4)
    exact = ritz(n).omega[0]
    found = np.array([assumed_modes(n, modes)[0] for modes in (1, 2, 4, 8, 16)])
    assert np.all(np.diff(found) < 0)
    assert 1e-6 < found[-1] / exact - 1 < 1e-2
    assert found[1] / exact - 1 > 0.01  # what the paper works with


@pytest.mark.slow
def test_figure_3_shows_two_assumed_modes() -> None:
    """Each printed place of the largest frequency: at some speed, never at one for all."""
    printed = (0.442, 0.429, 0.42)
    still = [Numbers(1.0, 0.0, alpha) for alpha in RATIOS]
    speeds = [matching_speed(n, b, 2) / UNIT for n, b in zip(still, printed, strict=True)]
    np.testing.assert_allclose(speeds, [7.757, 7.000, 6.766], atol=0.01)
    for n, place, speed in zip(still, printed, speeds, strict=True):
        n = n._replace(gamma=speed * UNIT)
        assert best_mass_position(n, 2) == pytest.approx(place, abs=1e-4)
        assert abs(best_mass_position(n, 3) - place) > 0.03
        assert abs(best_mass_position(n) - place) > 0.03
    assert np.isnan(matching_speed(still[0], printed[0], 3))


@pytest.mark.slow
def test_figure_3_without_bending_stiffness_has_no_speed() -> None:
    """(21) as printed: the frequency is proportional to the speed."""
    one, ten = (
        assumed_modes(Numbers(1.0, gamma, RATIOS[0], 0.4), 2, as_printed=True)[0]
        for gamma in (1.0, 10.0)
    )
    assert ten == pytest.approx(10 * one)
    grid = np.linspace(0.35, 0.5, 301)
    for alpha, place in zip(RATIOS, (0.4525, 0.4416, 0.4331), strict=True):
        found = [
            assumed_modes(Numbers(1.0, 1.0, alpha, beta), 2, as_printed=True)[0] for beta in grid
        ]
        assert grid[np.argmax(found)] == pytest.approx(place, abs=6e-4)


@pytest.mark.slow
def test_no_speed_gives_the_papers_maxima() -> None:
    for speed in (4.0, 7.0, 10.0):
        found = [best_mass_position(Numbers(1.0, speed * UNIT, alpha)) for alpha in RATIOS]
        assert np.all(np.diff(found) < 0)
        assert np.max(found) < 0.398
    assert np.isnan(matching_speed(Numbers(1.0, 0.0, RATIOS[1]), 0.6, 2))


def test_the_crossover_is_no_point() -> None:
    """It depends on the speed and on the masses; without rotation there is none."""
    at = {w: [crossover(Numbers(1.0, w * UNIT, a)) for a in RATIOS] for w in (4.0, 10.0)}
    np.testing.assert_allclose(at[4.0], [0.5564, 0.5518, 0.5479], atol=1e-4)
    np.testing.assert_allclose(at[10.0], [0.6568, 0.6510, 0.6468], atol=1e-4)
    assert np.isnan(crossover(Numbers(1.0, 0.0, RATIOS[0])))
    pair = crossover(Numbers(1.0, 10 * UNIT, RATIOS[2]), RATIOS[0])
    assert pair < at[10.0][2]
    two = [crossover(Numbers(1.0, 7.5 * UNIT, alpha), modes=2) for alpha in RATIOS]
    np.testing.assert_allclose(two, [0.6680, 0.6641, 0.6611], atol=1e-4)  # printed: 0.67


@pytest.mark.parametrize("alpha", [1e-2, 620.0, 1e12])
def test_frequencies_beside_a_heavy_tip_keep_their_digits(alpha: float) -> None:
    """The characteristic equation of a cantilever with a mass at its tip, in 40 digits."""
    found = ritz(Numbers(alpha=alpha), count=4)
    with mpmath.workdps(40):
        for omega, bound in zip(found.omega, found.bound, strict=True):
            root = mpmath.findroot(
                lambda k: (
                    (1 + mpmath.cos(k) * mpmath.cosh(k)) / (alpha * mpmath.cosh(k))
                    + k * (mpmath.cos(k) * mpmath.tanh(k) - mpmath.sin(k))
                ),
                mpmath.sqrt(float(omega)),
            )
            assert abs(omega - root**2) <= bound < 1e-12 * omega

"""Periodic orbits: they close, and their multipliers are those of differences."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbcheck.reference import get_scene
from mbcheck.reference.errors import (
    NoOrbitError,
)
from mbcheck.reference.hula_hoop.equations import (
    CONSERVATIVE,
    PLATE,
    UNFORCED,
    HulaHoop,
)
from mbcheck.reference.orbits import (
    Orbit,
    find_orbit,
    mean_powers,
    orbit_samples,
    period_advance,
    state_scale,
)
from mbcheck.reference.periodic import harmonics
from mbcheck.reference.scene import Array
from mbcheck.tests.support.points import point, random_parameters

SCENE = get_scene("hula_hoop")


# Periodic orbits ------------------------------------------------------------------------


@pytest.fixture(scope="module", params=[HulaHoop(), PLATE], ids=["point_mass", "plate"])
def orbit(request: pytest.FixtureRequest) -> SimpleNamespace:
    p = request.param
    found = find_orbit(SCENE, p)
    return SimpleNamespace(p=p, found=found, samples=orbit_samples(SCENE, p, found))


def one_period(p: HulaHoop, state: Array, period: float) -> Array:
    """State after a period, by SciPy alone."""
    run = solve_ivp(SCENE.right_hand_side(p), (0, period), state, "DOP853", rtol=3e-14, atol=1e-15)
    return np.asarray(run.y[:, -1])


def residual(p: HulaHoop, orbit: Orbit) -> float:
    """Largest scaled distance that the orbit leaves open, by an independent integration."""
    scale = state_scale(SCENE, orbit.state, 2 * np.pi / orbit.period)
    end = one_period(p, orbit.state, orbit.period)
    return float(np.max(np.abs(end - orbit.state - period_advance(SCENE)[:, 0]) / scale))


def test_orbit_closes(orbit: SimpleNamespace) -> None:
    assert orbit.found.period == 1 / 3
    assert residual(orbit.p, orbit.found) < 1e-12
    assert 0 <= orbit.found.state[1] < 2 * np.pi


def test_multipliers_by_finite_differences(orbit: SimpleNamespace) -> None:
    found = orbit.found
    scale = state_scale(SCENE, found.state, 2 * np.pi / found.period)
    columns = []
    for i in range(4):
        h = 1e-5 * scale[i] * np.eye(4)[i]
        ends = [one_period(orbit.p, found.state + s * h, found.period) for s in (1, -1)]
        columns.append((ends[0] - ends[1]) / (2e-5 * scale))
    other = np.array(columns).T
    weight = scale[None] / scale[:, None]
    np.testing.assert_allclose(found.monodromy * weight, other, atol=1e-7)
    values = np.sort_complex(np.linalg.eigvals(other))
    np.testing.assert_allclose(np.sort_complex(found.multipliers), values, atol=1e-6)
    assert np.all(np.diff(np.abs(found.multipliers)) <= 1e-12)
    assert found.stable


def test_orbit_has_the_symmetry_of_half_a_period(orbit: SimpleNamespace) -> None:
    """(y, theta, t) -> (-y, theta + pi, t + T/2): odd harmonics in y, even ones in theta."""
    half = orbit.samples.shape[1] // 2
    y, theta = orbit.samples[:2]
    np.testing.assert_allclose(y[half:], -y[:half], atol=1e-11)
    np.testing.assert_allclose(theta[half:], theta[:half] + np.pi, atol=1e-10)
    mean_y, terms_y = harmonics(y)
    _, terms_theta = harmonics(theta, turns=1)
    assert abs(mean_y) < 1e-11
    for term in (*terms_y[1::2], *terms_theta[::2]):
        assert term.amplitude < 1e-11
    for term in (*terms_y[:3:2], *terms_theta[1:4:2]):
        assert term.amplitude > 1e-6


def test_harmonics_sum_to_the_samples(orbit: SimpleNamespace) -> None:
    count = orbit.samples.shape[1]
    phase = 2 * np.pi * np.arange(count) / count
    for values, turns in zip(orbit.samples[:2], (0, 1), strict=True):
        mean, terms = harmonics(values, turns, highest=40)
        series = mean + turns * phase
        for term in terms:
            series = series + term.amplitude * np.cos(term.order * phase + term.phase)
        np.testing.assert_allclose(series, values, atol=1e-9)


def test_orbit_takes_in_the_power_that_it_loses(orbit: SimpleNamespace) -> None:
    powers = mean_powers(SCENE, orbit.samples, SCENE.coefficients(orbit.p), orbit.found.period)
    assert powers.keys() == {"force", "damper", "hinge"}
    assert powers["force"] > 0
    assert max(powers["damper"], powers["hinge"]) < 0
    assert abs(sum(powers.values())) < 1e-12 * powers["force"]
    assert np.mean(orbit.samples[3]) == pytest.approx(6 * np.pi, rel=1e-12)


@pytest.mark.slow
def test_orbit_at_100_newton_is_unstable() -> None:
    p = HulaHoop(force_amplitude=100.0)
    found = find_orbit(SCENE, p)
    assert not found.stable
    assert residual(p, found) < 1e-10


@pytest.mark.slow
def test_stability_is_lost_between_86_and_87_newton() -> None:
    """A pair of multipliers meets on the real axis, and one of them leaves through +1."""
    found = find_orbit(SCENE, HulaHoop(force_amplitude=85.5))
    assert found.stable
    for force in np.arange(86.0, 87.1, 0.25):
        before, found = found, find_orbit(SCENE, HulaHoop(force_amplitude=force))
        if not found.stable:
            break
    assert 86.5 < force <= 87.0
    assert before.stable
    assert found.multipliers[0].imag == 0
    assert 1 < found.multipliers[0].real < 1.2


@pytest.mark.parametrize(
    "p",
    [
        pytest.param(HulaHoop(force_amplitude=0.5), marks=pytest.mark.slow),
        CONSERVATIVE,
        pytest.param(UNFORCED, marks=pytest.mark.campaign),
        pytest.param(HulaHoop(hinge_damping_ratio=10.0), marks=pytest.mark.slow),
        pytest.param(
            HulaHoop(damping_ratio=100.0, hinge_damping_ratio=1.0), marks=pytest.mark.campaign
        ),
    ],
)
def test_no_orbit_is_told(p: HulaHoop) -> None:
    """Too little force, too much damping, or (CONSERVATIVE) a family instead of one orbit."""
    with pytest.raises(NoOrbitError, match="theta turning 1 time"):
        find_orbit(SCENE, p)


def test_guesses_at_undamped_resonance_are_finite() -> None:
    p = HulaHoop(damping_ratio=0.0, force_frequency=HulaHoop().omega_n / (2 * np.pi))
    assert all(np.all(np.isfinite(guess)) for guess in SCENE.orbit.guesses(p))


@pytest.mark.parametrize(
    ("count", "least"), [(4, 3), pytest.param(16, 12, marks=pytest.mark.campaign)]
)
def test_orbits_of_random_parameters_close(count: int, least: int) -> None:
    parameters = random_parameters(np.random.default_rng(3), count)
    found = 0
    for i in range(count):
        p = point(parameters, i)
        try:
            orbit = find_orbit(SCENE, p)
        except NoOrbitError:
            continue
        found += 1
        assert residual(p, orbit) < 1e-10
        np.testing.assert_allclose(np.sort(np.abs(orbit.multipliers))[::-1],
                                   np.abs(orbit.multipliers))  # fmt: skip
    assert found >= least

"""The reference: solutions against higher precision, orbits, modes, schemes, parameters."""

from __future__ import annotations

import dataclasses
import pickle
from collections.abc import Sequence
from dataclasses import replace
from importlib.util import find_spec
from types import SimpleNamespace
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import quad_vec, solve_ivp

from mbcheck.reference import get_scene, linear
from mbcheck.reference.errors import (
    EngineError,
    MbcheckError,
    NoOrbitError,
    ParameterError,
    UnknownNameError,
    UsageError,
)
from mbcheck.reference.hula_hoop import equations as hula_hoop
from mbcheck.reference.hula_hoop.equations import (
    CONSERVATIVE,
    PLATE,
    UNFORCED,
    HulaHoop,
    coefficients,
)
from mbcheck.reference.linear import linearise, modes
from mbcheck.reference.orbits import (
    Orbit,
    find_orbit,
    follow_orbit,
    harmonics,
    mean_powers,
    orbit_samples,
    period_advance,
    state_scale,
)
from mbcheck.reference.scene import Array
from mbcheck.reference.solve import batched, single
from mbcheck.reference.solve.batched import BatchMethod, solve_many
from mbcheck.reference.solve.flow import amplification, rk8_steps, transition_matrix
from mbcheck.reference.solve.schemes import DAMPING, SCHEMES, TABLEAUS, ScalarEquations, integrate
from mbcheck.reference.solve.single import solve

SCENE = get_scene("hula_hoop")
REST = SCENE.state({})
SPINNING = SCENE.state({"y": 0.01, "theta": 0.3, "theta_dot": 18.0})
needs_heyoka = pytest.mark.skipif(find_spec("heyoka") is None, reason="heyoka is not installed")
BACKENDS = ["numpy", pytest.param("heyoka", marks=needs_heyoka)]


def random_parameters(rng: np.random.Generator, count: int, factor: float = 1.4) -> Any:
    """Return defaults times log-uniform factors, as arrays (count,), half of them plates."""
    values: dict[str, Any] = {
        name: value * np.exp(rng.uniform(np.log(0.7), np.log(factor), count))
        for name, value in HulaHoop().as_dict().items()
    }
    values["inertia_ratio"] = np.where(np.arange(count) % 2, PLATE.inertia_ratio, 0.0)
    return HulaHoop(**values)


def point(parameters: HulaHoop, index: int) -> HulaHoop:
    """Return one point of parameters that are all arrays."""
    return HulaHoop(**{k: v[index] for k, v in parameters.as_dict().items()})


# Solutions ------------------------------------------------------------------------------


def high_precision(
    p: HulaHoop, state: Array, times: Sequence[float], step: float = 1 / 128, levels: int = 14
) -> Array:
    """States (4, n_t) by extrapolated midpoint steps with 40 digits: shares nothing but (5), (6).

    The coefficients are the rounded ones, which are what the reference solves with.
    """
    with mp.workdps(40):
        c = type(coefficients(p))(*(mp.mpf(float(value)) for value in coefficients(p)))

        def rates(t: Any, x: list[Any]) -> list[Any]:
            cos, sin = mp.cos(x[1]), mp.sin(x[1])
            load = c.force * mp.cos(c.omega * t) - c.damping * x[2] - c.stiffness * x[0]
            load += c.coupling * x[3] ** 2 * sin
            torque = -c.hinge_damping * x[3]
            determinant = c.determinant + (c.coupling * sin) ** 2
            return [
                x[2],
                x[3],
                (c.inertia * load - c.coupling * cos * torque) / determinant,
                (c.mass * torque - c.coupling * cos * load) / determinant,
            ]

        def midpoint(t: Any, x: list[Any], length: Any, count: int) -> list[Any]:
            h = length / count
            before = x
            now = [a + h * b for a, b in zip(x, rates(t, x), strict=True)]
            for i in range(1, count):
                slope = rates(t + i * h, now)
                before, now = now, [a + 2 * h * b for a, b in zip(before, slope, strict=True)]
            slope = rates(t + length, now)
            return [
                (a + b + h * s) / 2 for a, b, s in zip(now, before, slope, strict=True)
            ]  # smoothed: an expansion in h^2

        def advance(t: Any, x: list[Any], length: Any) -> list[Any]:
            table: list[list[Any]] = []
            for level in range(1, levels + 1):
                row = [midpoint(t, x, length, 2 * level)]
                for k in range(1, level):
                    weight = (mp.mpf(level) / (level - k)) ** 2 - 1
                    row.append(
                        [
                            a + (a - b) / weight
                            for a, b in zip(row[-1], table[-1][k - 1], strict=True)
                        ]
                    )
                table.append(row)
            return [*table[-1][-1]]

        t, x = mp.mpf(0), [mp.mpf(float(value)) for value in state]
        columns = []
        for end in times:
            count = int(mp.ceil((end - t) / step))
            length = (mp.mpf(end) - t) / count
            for _ in range(count):
                x = advance(t, x, length)
                t += length
            t = mp.mpf(end)
            columns.append([float(value) for value in x])
        return np.array(columns).T


TIMES = (0.125, 0.25)


@pytest.fixture(scope="module", params=["rest", "spinning", "plate"])
def exact(request: pytest.FixtureRequest) -> tuple[HulaHoop, Array, Array]:
    p = PLATE if request.param == "plate" else HulaHoop()
    state = REST if request.param == "rest" else SPINNING
    return p, state, high_precision(p, state, TIMES)


def test_solution_of_higher_precision_has_converged() -> None:
    coarse = high_precision(HulaHoop(), SPINNING, [1 / 32], step=1 / 64, levels=14)
    fine = high_precision(HulaHoop(), SPINNING, [1 / 32], step=1 / 128, levels=16)
    np.testing.assert_array_equal(coarse, fine)


@pytest.mark.parametrize("tolerances", [single.TOLERANCES, (1e-9, 1e-7), (1e-6, 1e-4)])
def test_bound_holds_and_is_no_wild_guess(
    exact: tuple[HulaHoop, Array, Array],
    tolerances: tuple[float, float],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    p, state, truth = exact
    monkeypatch.setattr(single, "TOLERANCES", tolerances)
    solution = solve(SCENE, p, state, TIMES)
    error = np.max(np.abs(solution.states - truth), axis=1)
    rounding = 1e-14 * np.max(np.abs(truth), axis=1)
    assert np.all(error <= solution.error_bound)
    assert np.all(solution.error_bound <= 1e4 * np.maximum(error, rounding))
    assert np.all(solution.error_bound <= 1e3 * tolerances[1] * np.max(np.abs(truth), axis=1))


@pytest.mark.parametrize("backend", BACKENDS)
def test_bound_of_many_holds_against_higher_precision(
    exact: tuple[HulaHoop, Array, Array], backend: str
) -> None:
    p, state, truth = exact
    solution = solve_many(SCENE, p, state, TIMES, method=BatchMethod(backend=backend))
    error = np.max(np.abs(solution.states - truth), axis=1)
    assert np.all(error <= solution.error_bound)
    assert np.all(solution.error_bound <= 1e-8 * np.max(np.abs(truth), axis=1))


def test_linear_response_on_the_invariant_line() -> None:
    state = SCENE.state({"y": 0.01, "theta": np.pi / 2, "y_dot": -0.4})
    start, times = 0.1, np.linspace(0.1, 0.4, 30)  # unstable: beyond, rounding leaves it
    c = coefficients(HulaHoop())
    forced = c.force / (c.stiffness - c.mass * c.omega**2 + 1j * c.damping * c.omega)
    root = (-c.damping + 1j * np.sqrt(4 * c.mass * c.stiffness - c.damping**2)) / (2 * c.mass)
    y_0, v_0 = (
        state[i] - (forced * (1j * c.omega) ** k * np.exp(1j * c.omega * start)).real
        for k, i in enumerate((0, 2))
    )
    free = y_0 - 1j * (v_0 - root.real * y_0) / root.imag
    y, v = (
        (
            forced * (1j * c.omega) ** k * np.exp(1j * c.omega * times)
            + free * root**k * np.exp(root * (times - start))
        ).real
        for k in (0, 1)
    )
    for solution in (
        solve(SCENE, HulaHoop(), state, times, start),
        solve_many(SCENE, HulaHoop(), state, times, start, method=BatchMethod(backend="numpy")),
    ):
        error = np.max(np.abs(solution.states[[0, 2]] - [y, v]), axis=1)
        assert np.all(error <= solution.error_bound[[0, 2]] + 1e-14)  # of the formula
        assert np.all(solution.error_bound[[0, 2]] < 1e-9)
        np.testing.assert_allclose(solution.states[1], np.pi / 2, rtol=0, atol=1e-12)


def test_bound_grows_with_chaos() -> None:
    p = HulaHoop(force_amplitude=100.0)
    short, long = (solve(SCENE, p, REST, [end]).error_bound for end in (0.5, 8.0))
    assert np.all(short < 1e-8)
    assert np.all(long > 1e4 * short)
    assert amplification(SCENE, p, REST, np.array([4.0])) > 1e2


@pytest.mark.parametrize(
    ("times", "start"),
    [
        ([], 0.0),
        (1.0, 0.0),
        ([0.0, np.nan], 0.0),
        ([np.inf], 0.0),
        ([0.2, 0.1], 0.0),
        ([0.1, 0.1], 0.0),
        ([0.1, 0.2], 0.15),
        ([0.1], np.nan),
        ([0.1], -np.inf),
    ],
)
def test_times_that_cannot_be_sampled(times: Any, start: float) -> None:
    for route in (solve, solve_many):
        with pytest.raises(UsageError, match=r"sample times|start of the run"):
            route(SCENE, HulaHoop(), REST, times, start)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_initial_states_that_are_not_finite(value: float) -> None:
    for route in (solve, solve_many):
        with pytest.raises(UsageError, match="finite"):
            route(SCENE, HulaHoop(), np.array([0, value, 0, 0]), [0.1])


@pytest.mark.parametrize("start", [0.0, 0.3])
def test_a_run_of_no_length(start: float) -> None:
    for route in (solve, solve_many):
        found = route(SCENE, HulaHoop(), SPINNING, [start], start)
        np.testing.assert_array_equal(found.states[:, 0], SPINNING)
        sampled = route(SCENE, HulaHoop(), SPINNING, [start, start + 0.1], start)
        np.testing.assert_array_equal(sampled.states[:, 0], SPINNING)


@pytest.mark.parametrize("backend", BACKENDS)
def test_two_routes_agree_to_1e_10(backend: str) -> None:
    rng = np.random.default_rng(1)
    parameters = random_parameters(rng, 6)
    states = rng.normal(size=(4, 6)) * [[0.01], [2.0], [0.3], [12.0]]
    start = 0.17
    times = start + np.linspace(0.1, 0.4, 3)[:, None] * rng.uniform(0.8, 1.2, 6)
    many = solve_many(SCENE, parameters, states, times, start, method=BatchMethod(backend=backend))
    assert many.states.shape == (4, 6, 3)
    assert many.error_bound.shape == (4, 6)
    assert many.times.shape == (3, 6)
    for i in range(6):
        one = solve(SCENE, point(parameters, i), states[:, i], times[:, i], start)
        size = np.max(np.abs(one.states), axis=1)
        difference = np.max(np.abs(many.states[:, i] - one.states), axis=1)
        assert np.all(difference <= 1e-10 * size)
        assert np.all(difference <= many.error_bound[:, i] + one.error_bound)


@pytest.mark.parametrize("backend", BACKENDS)
def test_points_broadcast(backend: str) -> None:
    p = HulaHoop(
        force_amplitude=np.array([[50.0], [60.0]]),  # type: ignore[arg-type]
        force_frequency=np.array([2.0, 3.0, 4.0]),  # type: ignore[arg-type]
    )
    states = np.stack([SPINNING, SPINNING, REST], axis=1)
    grid = solve_many(SCENE, p, states, [0.1, 0.2], method=BatchMethod(backend=backend))
    assert grid.states.shape == (4, 2, 3, 2)
    one = solve(SCENE, HulaHoop(force_amplitude=50.0, force_frequency=4.0), REST, [0.1, 0.2])
    np.testing.assert_allclose(grid.states[:, 0, 2], one.states, rtol=1e-9, atol=1e-11)
    single = solve_many(
        SCENE, HulaHoop(), SPINNING, [0.1, 0.2], method=BatchMethod(backend=backend)
    )
    assert single.states.shape == (4, 2)
    np.testing.assert_allclose(grid.states[:, 1, 1], single.states, rtol=1e-9, atol=1e-11)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("end", [0.3, 1.0])
def test_bounds_of_random_points_hold(backend: str, end: float) -> None:
    """One sample time each: where differences pass through zero, bounds used to be broken."""
    rng = np.random.default_rng(2)
    count = 60
    parameters = random_parameters(rng, count)
    states = rng.normal(size=(4, count)) * [[0.01], [2.0], [0.3], [15.0]]
    found = solve_many(SCENE, parameters, states, [end], method=BatchMethod(backend=backend))
    fine = rk8_steps(SCENE.right_hand_side(parameters), states, 0.0, end, 1024)
    finer = rk8_steps(SCENE.right_hand_side(parameters), states, 0.0, end, 1536)
    error = np.abs(found.states[..., 0] - finer)
    sure = error > 10 * np.abs(fine - finer)  # elsewhere the finer run knows no better
    assert np.all(error <= found.error_bound + 2 * np.abs(fine - finer))
    assert np.all(error[sure] <= found.error_bound[sure])
    assert np.count_nonzero(found.error_bound > 1e-7 * (1 + np.abs(finer))) < count // 10


def test_a_lost_point_keeps_its_bound_and_spoils_no_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """A point whose steps are too long blows up; its neighbours in the block must not notice."""
    monkeypatch.setattr(batched, "MOST_STEPS", 64)
    stiff = HulaHoop(damping_ratio=np.array([0.1, 1e5]))  # type: ignore[arg-type]
    found = solve_many(SCENE, stiff, SPINNING, [0.1], method=BatchMethod(backend="numpy"))
    assert np.all(np.isinf(found.error_bound[:, 1]) | (found.error_bound[:, 1] > 1))
    one = solve(SCENE, HulaHoop(), SPINNING, [0.1])
    error = np.abs(found.states[:, 0] - one.states)[:, 0]
    assert np.all(error <= found.error_bound[:, 0])
    assert np.all(error <= 1e-10 * np.abs(one.states[:, 0]).max())


@needs_heyoka
def test_a_chaotic_point_has_a_large_bound_beside_a_small_one() -> None:
    p = HulaHoop(force_amplitude=np.array([60.0, 100.0]))  # type: ignore[arg-type]
    found = solve_many(SCENE, p, REST, [20.0], method=BatchMethod(backend="heyoka"))
    assert np.all(found.error_bound[:, 0] < 1e-7)
    assert np.all(found.error_bound[:, 1] > 1e-4)


@needs_heyoka
def test_heyoka_solves_the_scene_that_it_is_given() -> None:
    free = dataclasses.replace(SCENE, drive=lambda t, c, xp: 0.0 * xp.cos(c.omega * t))
    found = solve_many(free, HulaHoop(), SPINNING, [0.2], method=BatchMethod(backend="heyoka"))
    truth = solve(SCENE, UNFORCED, SPINNING, [0.2])
    np.testing.assert_allclose(found.states, truth.states, rtol=1e-9)


def test_backend_that_is_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(UsageError, match="known: auto, numpy, heyoka"):
        solve_many(SCENE, HulaHoop(), REST, [0.1], method=BatchMethod(backend="jax"))
    monkeypatch.setattr(batched, "find_spec", lambda name: None)
    with pytest.raises(UsageError, match=r"mbcheck\[fast\]"):
        solve_many(SCENE, HulaHoop(), REST, [0.1], method=BatchMethod(backend="heyoka"))
    auto = solve_many(SCENE, HulaHoop(), REST, [0.1])
    numpy = solve_many(SCENE, HulaHoop(), REST, [0.1], method=BatchMethod(backend="numpy"))
    np.testing.assert_array_equal(auto.states, numpy.states)


# Linearised flow ------------------------------------------------------------------------


def field_jacobian(p: HulaHoop, t: float, x: Array) -> Array:
    """d f / d x by central differences of the fourth order."""
    f = SCENE.right_hand_side(p)
    columns = []
    for i in range(4):
        h = 1e-3 * np.eye(4)[i]
        near, far = (f(t, x + k * h) - f(t, x - k * h) for k in (1, 2))
        columns.append((8 * near - far) / 12e-3)
    return np.array(columns).T


@pytest.mark.parametrize("p", [HulaHoop(), PLATE])
def test_transition_matrix_solves_the_variational_equations(p: HulaHoop) -> None:
    start, end = 0.05, 0.3

    def rates(t: float, z: Array) -> Array:
        x, matrix = z[:4], z[4:].reshape(4, 4)
        slope = SCENE.right_hand_side(p)(t, x)
        return np.concatenate([slope, (field_jacobian(p, t, x) @ matrix).ravel()])

    z = np.concatenate([SPINNING, np.eye(4).ravel()])
    other = solve_ivp(rates, (start, end), z, "DOP853", rtol=1e-10, atol=1e-10).y[:, -1]
    flow, jacobian = transition_matrix(SCENE, p, SPINNING, end, start)
    np.testing.assert_allclose(flow, other[:4], rtol=1e-8, atol=1e-8)
    size = np.abs(jacobian).max(axis=1, keepdims=True)
    np.testing.assert_allclose(jacobian / size, other[4:].reshape(4, 4) / size, atol=1e-7)


def test_transition_matrix_is_the_slope_of_the_flow() -> None:
    scale = np.array([0.1, 6.0, 2.0, 20.0])
    _, jacobian = transition_matrix(SCENE, HulaHoop(), SPINNING, 0.3)
    offset = 1e-5 * np.diag(scale)
    starts = np.stack([SPINNING + offset, SPINNING - offset])  # (sign, state, entry)
    ends = solve_many(
        SCENE, HulaHoop(), np.moveaxis(starts, 2, 0), [0.3], method=BatchMethod(1e-13, "numpy")
    ).states[..., 0]
    slope = (ends[:, 0] - ends[:, 1]) / (2e-5 * scale)
    weight = scale[None] / scale[:, None]
    np.testing.assert_allclose(jacobian * weight, slope * weight, rtol=1e-6, atol=1e-6)


def test_volumes_shrink_by_the_trace() -> None:
    """Liouville's formula: det of the transition matrix is exp of the integrated divergence."""
    p, end = HulaHoop(damping_ratio=0.02), 0.3
    _, jacobian = transition_matrix(SCENE, p, SPINNING, end)
    dense = solve_ivp(
        SCENE.right_hand_side(p), (0, end), SPINNING, "DOP853", rtol=1e-12, atol=1e-12,
        dense_output=True,
    ).sol  # fmt: skip
    integral, _ = quad_vec(
        lambda t: np.trace(field_jacobian(p, t, dense(t))), 0, end, epsabs=1e-9, epsrel=1e-9
    )
    assert np.linalg.det(jacobian) == pytest.approx(np.exp(integral), rel=1e-7)
    assert integral < -0.1


def test_transition_matrices_of_many_points() -> None:
    frequencies = np.array([2.0, 3.0])
    p = HulaHoop(force_frequency=frequencies)  # type: ignore[arg-type]
    states = np.stack([SPINNING, REST], axis=1)
    flow, jacobian = transition_matrix(SCENE, p, states, 1 / frequencies)
    assert jacobian.shape == (4, 4, 2)
    for i, frequency in enumerate(frequencies):
        one = HulaHoop(force_frequency=frequency)
        alone = transition_matrix(SCENE, one, states[:, i], 1 / frequency)
        np.testing.assert_allclose(flow[:, i], alone[0], rtol=1e-10, atol=1e-11)
        np.testing.assert_allclose(jacobian[..., i], alone[1], rtol=1e-8, atol=1e-8)


def test_amplification_of_a_damped_oscillator_is_one() -> None:
    """Light mass on a long rod, no force: nothing grows but theta with its rate."""
    p = UNFORCED.replace(free_mass=1e-9, rod_length=1e3, damping_ratio=0.5)
    state = SCENE.state({"y": 0.1, "theta": 0.3, "theta_dot": 18.0})
    growth = amplification(SCENE, p, state, np.linspace(0, 0.5, 11))
    assert 1 <= growth < 3


def test_amplification_that_overflows_is_infinite() -> None:
    """Exponential growth at rest: e^(3e4 0.1) is no number."""

    def accelerations(u: Any, q: Any, v: Any, c: Any, xp: Any = np) -> list[Any]:
        return [9e8 * q[0], 9e8 * q[1]]

    unstable = replace(SCENE, accelerations=accelerations, drive=None)
    assert amplification(unstable, HulaHoop(), REST, np.array([0.1])) == np.inf


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
    assert np.all(orbit.found.error_bound < 1e-10)
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
    powers = mean_powers(SCENE, orbit.p, orbit.found, orbit.samples)
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


def test_stability_is_lost_between_86_and_87_newton() -> None:
    """A pair of multipliers meets on the real axis, and one of them leaves through +1."""
    found = find_orbit(SCENE, HulaHoop(force_amplitude=85.5))
    assert found.stable
    for force in np.arange(86.0, 87.1, 0.25):
        before = found
        found = follow_orbit(SCENE, HulaHoop(force_amplitude=force), before)
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
        pytest.param(UNFORCED, marks=pytest.mark.slow),
        pytest.param(HulaHoop(hinge_damping_ratio=10.0), marks=pytest.mark.slow),
        pytest.param(
            HulaHoop(damping_ratio=100.0, hinge_damping_ratio=1.0), marks=pytest.mark.slow
        ),
    ],
)
def test_no_orbit_is_told(p: HulaHoop) -> None:
    """Too little force, too much damping, or (CONSERVATIVE) a family instead of one orbit."""
    with pytest.raises(NoOrbitError, match="theta turning 1 time"):
        find_orbit(SCENE, p)


def test_guesses_at_undamped_resonance_are_finite() -> None:
    p = HulaHoop(damping_ratio=0.0, force_frequency=HulaHoop().omega_n / (2 * np.pi))
    assert all(np.all(np.isfinite(guess)) for guess in SCENE.orbit_guesses(p))


@pytest.mark.slow
def test_an_orbit_that_does_not_continue_is_told() -> None:
    near = find_orbit(SCENE, HulaHoop())
    with pytest.raises(NoOrbitError, match="does not continue"):
        follow_orbit(SCENE, HulaHoop(force_amplitude=0.5), near)


@pytest.mark.parametrize(("count", "least"), [(4, 3), pytest.param(16, 12, marks=pytest.mark.slow)])
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


# Schemes --------------------------------------------------------------------------------

ORDERS = {
    "ExplicitEuler": 1,
    "ExplicitMidpoint": 2,
    "RK33": 3,
    "RK44": 4,
    "DOPRI5": 5,
    "RK67": 6,
    "semi_implicit_euler": 1,
    "implicit_euler_dampers": 1,
    "implicit_euler_velocity": 1,
}


def rooted_trees(order: int) -> list[Any]:
    """Rooted trees of this order, each as the sorted tuple of its branches."""
    if order == 1:
        return [()]
    found = set()
    for small in range(1, order):
        for branch in rooted_trees(small):
            for rest in rooted_trees(order - small):
                found.add(tuple(sorted((*rest, branch))))
    return sorted(found)


def weight(tree: Any) -> tuple[int, int]:
    """Order and density gamma of a rooted tree."""
    order, density = 1, 1
    for branch in tree:
        size, gamma = weight(branch)
        order, density = order + size, density * gamma
    return order, density * order


def test_there_is_a_known_number_of_rooted_trees() -> None:
    assert [len(rooted_trees(order)) for order in range(1, 7)] == [1, 1, 2, 4, 9, 20]


@pytest.mark.parametrize("name", TABLEAUS)
def test_tableau_satisfies_every_order_condition(name: str) -> None:
    """Butcher: sum b Phi(tree) = 1/gamma(tree) for every rooted tree up to the order."""
    tableau = TABLEAUS[name]
    stages = len(tableau.b)
    a = np.zeros((stages, stages))
    for i, row in enumerate(tableau.a):
        a[i, : len(row)] = row

    def stage_weights(tree: Any) -> Array:
        result = np.ones(stages)
        for branch in tree:
            result = result * (a @ stage_weights(branch))
        return result

    def defect(tree: Any) -> float:
        return abs(float(np.dot(tableau.b, stage_weights(tree))) - 1 / weight(tree)[1])

    for order in range(1, ORDERS[name] + 1):
        assert max(defect(tree) for tree in rooted_trees(order)) < 1e-14
    assert max(defect(tree) for tree in rooted_trees(ORDERS[name] + 1)) > 1e-5


@pytest.mark.parametrize("clock", [False, True])
@pytest.mark.parametrize("name", SCHEMES)
def test_slope_of_a_scheme(name: str, clock: bool) -> None:
    start, end = 0.05, 0.25
    truth = solve(SCENE, PLATE, SPINNING, [end], start).states[:, 0]
    errors = []
    for count in (400, 800) if ORDERS[name] == 1 else (50, 100):
        samples: Any = np.array([0, count])
        step = (end - start) / count
        run = integrate(ScalarEquations(SCENE, PLATE, clock), name, SPINNING, step, samples, start)
        np.testing.assert_array_equal(run[:, 0], SPINNING)
        errors.append(np.max(np.abs(run[:, 1] - truth) / np.abs(truth)))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(ORDERS[name], abs=0.35)


@pytest.mark.parametrize("name", SCHEMES)
def test_an_unstable_scheme_ends_in_nan(name: str) -> None:
    samples: Any = np.arange(0, 200, 4)
    run = integrate(ScalarEquations(SCENE, HulaHoop()), name, SPINNING, 5.0, samples)
    assert np.all(np.isfinite(run) | np.isnan(run))
    lost = np.any(np.isnan(run), axis=0)
    assert not lost[0]
    assert np.all(np.diff(lost.astype(int)) >= 0)


def test_joint_damping_is_implicit_in_the_velocity() -> None:
    """On the line theta = pi/2 one step is ``v (1 + h c/m)^-1`` with the spring's force added."""
    c = coefficients(UNFORCED)
    state, h = SCENE.state({"y": 0.02, "theta": np.pi / 2, "y_dot": 0.3}), 0.01
    for name in DAMPING:
        run = integrate(ScalarEquations(SCENE, UNFORCED), name, state, h, np.array([1]))[:, 0]
        v = (c.mass * 0.3 - h * c.stiffness * 0.02) / (c.mass + h * c.damping)
        np.testing.assert_allclose(run[[0, 2]], [0.02 + h * v, v], rtol=1e-12)


# Parameters, cases, scenes, errors -----------------------------------------------------

NAMES = HulaHoop.names()
NON_NEGATIVE = {
    "damping_ratio", "hinge_damping_ratio", "inertia_ratio", "force_amplitude"
}  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    "value", [np.nan, np.inf, -np.inf, -1e-300, "heavy", None, 1j, [[1], [1, 2]]]
)
def test_impossible_value(name: str, value: Any) -> None:
    with pytest.raises(ParameterError, match=name):
        HulaHoop(**{name: value})


@pytest.mark.parametrize("name", NAMES)
def test_zero(name: str) -> None:
    if name in NON_NEGATIVE:
        assert getattr(HulaHoop(**{name: 0}), name) == 0.0
    else:
        with pytest.raises(ParameterError, match=f"{name} must be greater than 0"):
            HulaHoop(**{name: 0})


@pytest.mark.parametrize("name", NAMES)
def test_one_impossible_value_in_an_array(name: str) -> None:
    values: dict[str, Any] = {name: [1.0, 2.0]}
    good = HulaHoop(**values)
    np.testing.assert_array_equal(getattr(good, name), [1.0, 2.0])
    for bad in (-1.0, np.nan):
        with pytest.raises(ParameterError, match=name):
            HulaHoop(**(values | {name: [1.0, bad]}))


def test_parameters_are_frozen_and_hashable() -> None:
    p = HulaHoop(main_mass=1)
    assert type(p.main_mass) is float
    assert {p: 1}[HulaHoop(main_mass=1.0)] == 1
    assert p != HulaHoop()
    with pytest.raises(dataclasses.FrozenInstanceError):
        p.main_mass = 2.0  # type: ignore[misc]
    values = np.array([1.0, 2.0])
    several = HulaHoop(main_mass=values)  # type: ignore[arg-type]
    values[0] = -1
    np.testing.assert_array_equal(several.main_mass, [1.0, 2.0])
    with pytest.raises(ValueError, match="read-only"):
        several.main_mass[0] = -1  # type: ignore[index]


def test_replace() -> None:
    assert HulaHoop().replace(main_mass=2.0) == HulaHoop(main_mass=2.0)
    with pytest.raises(UnknownNameError, match=r"'main_mas'; did you mean 'main_mass'\?"):
        HulaHoop().replace(main_mas=2.0)
    with pytest.raises(UnknownNameError, match="known: main_mass, free_mass"):
        HulaHoop().replace(xyz=2.0)
    with pytest.raises(ParameterError, match="stiffness"):
        HulaHoop().replace(stiffness=-1.0)
    assert HulaHoop(**HulaHoop().as_dict()) == HulaHoop()


def test_defaults_are_those_of_table_1() -> None:
    assert HulaHoop().as_dict() == {
        "main_mass": 0.45,
        "free_mass": 0.045,
        "rod_length": 0.05,
        "stiffness": 1000.0,
        "damping_ratio": 0.1,
        "hinge_damping_ratio": 0.01,
        "inertia_ratio": 0.0,
        "force_amplitude": 60.0,
        "force_frequency": 3.0,
    }
    assert pytest.approx(9 * np.pi**2 / 32 - 1) == hula_hoop.SEMICIRCLE


def test_state_by_name() -> None:
    assert SCENE.state_names == ("y", "theta", "y_dot", "theta_dot")
    np.testing.assert_array_equal(SCENE.state({"theta_dot": 2, "y": 1}), [1, 0, 0, 2])
    with pytest.raises(UnknownNameError, match=r"'theta_dott'; did you mean 'theta_dot'\?"):
        SCENE.state({"theta_dott": 1.0})
    for value in (np.nan, np.inf, "fast", None):
        with pytest.raises(ParameterError, match="initial theta"):
            SCENE.state({"theta": value})


def test_cases_by_name() -> None:
    assert SCENE.case("rod_aligned").name == "rod_aligned"
    with pytest.raises(UnknownNameError, match=r"did you mean 'rod_aligned'\?"):
        SCENE.case("rod_alined")
    names = [case.name for case in SCENE.cases]
    assert len(set(names)) == len(names)
    for case in SCENE.cases:
        assert case.scene == SCENE.name
        assert case.horizon > 0
        assert SCENE.state(case.state).shape == (4,)
    with pytest.raises(UnknownNameError, match=r"scene 'hula_hop'; did you mean 'hula_hoop'\?"):
        get_scene("hula_hop")


@pytest.mark.parametrize(
    "error", [UnknownNameError("scene", "a", ["b"]), EngineError("clock", "it went back")]
)
def test_errors_survive_a_process_boundary(error: MbcheckError) -> None:
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is type(error)
    assert str(copy) == str(error)

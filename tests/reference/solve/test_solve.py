"""Solutions of one point and of many, against higher precision."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mbcheck.reference import get_scene
from mbcheck.reference.errors import (
    UsageError,
)
from mbcheck.reference.hula_hoop.equations import (
    PLATE,
    HulaHoop,
    coefficients,
)
from mbcheck.reference.scene import Array
from mbcheck.reference.solve import single
from mbcheck.reference.solve.batched import growths, solve_many
from mbcheck.reference.solve.rk8 import rk8_steps
from mbcheck.reference.solve.single import solve, states_at
from mbcheck.tests.support.points import point, random_parameters
from mbcheck.tests.support.precise.compare import precise_states
from mbcheck.tests.support.precise.kinds.common import Run
from mbcheck.tests.support.precise.series import Accuracy

SCENE = get_scene("hula_hoop")


REST = SCENE.state({})


SPINNING = SCENE.state({"y": 0.01, "theta": 0.3, "theta_dot": 18.0})


# Solutions ------------------------------------------------------------------------------


TIMES, PRECISE = (0.125, 0.25), Accuracy(112)


@pytest.fixture(scope="module", params=["rest", "spinning", "plate"])
def exact(request: pytest.FixtureRequest) -> tuple[HulaHoop, Array, Array]:
    p = PLATE if request.param == "plate" else HulaHoop()
    state = REST if request.param == "rest" else SPINNING
    run = Run(SCENE.name, "", p, {})
    return p, state, np.array(precise_states(run, state, np.array(TIMES), PRECISE), dtype=float).T


@pytest.mark.parametrize("tolerance", [single.OPTIONS.tolerance, 1e-9, 1e-6])
def test_bound_holds_and_is_no_wild_guess(
    exact: tuple[HulaHoop, Array, Array], tolerance: float
) -> None:
    p, state, truth = exact
    solution = solve(SCENE, p, state, TIMES, tolerances=(tolerance, 0.0))
    error = np.max(np.abs(solution.states - truth), axis=1)
    rounding = 1e-15 * np.max(np.abs(truth), axis=1)
    assert np.all(error <= solution.error_bound)
    assert np.all(solution.error_bound <= 300 * np.maximum(error, rounding))
    assert np.all(solution.error_bound <= 1e4 * tolerance * np.max(np.abs(truth), axis=1))


def test_what_rounding_makes_of_an_unstable_motion_is_lost() -> None:
    state = SCENE.state({"theta": np.pi / 2})
    solution = solve(SCENE, HulaHoop(), state, np.arange(1, 11) / 2)
    assert solution.lost_from == 2.5
    sure = solution.before_lost
    np.testing.assert_array_equal(sure.times, [0.5, 1.0, 1.5, 2.0])
    assert sure.lost_from is None
    assert np.all(sure.error_bound < 1e-2 * np.max(np.abs(solution.states), axis=1) + 1e-3)
    assert np.all(np.isinf(solution.error_bound))


def test_a_regular_motion_is_not_lost() -> None:
    for end in (0.01, 1.0, 10.0):
        assert solve(SCENE, HulaHoop(), REST, [end]).lost_from is None


def test_bound_of_many_holds_against_higher_precision(exact: tuple[HulaHoop, Array, Array]) -> None:
    p, state, truth = exact
    solution = solve_many(SCENE, p, state, TIMES)
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
    for solution, width in (
        (solve(SCENE, HulaHoop(), state, times, start), 1e-9),
        # of many, each state is as far off as what rounding of parameters makes of the line
        (solve_many(SCENE, HulaHoop(), state, times, start), 1e-8),
    ):
        error = np.max(np.abs(solution.states[[0, 2]] - [y, v]), axis=1)
        assert np.all(error <= solution.error_bound[[0, 2]] + 1e-14)  # of the formula
        assert np.all(solution.error_bound[[0, 2]] < width)
        np.testing.assert_allclose(solution.states[1], np.pi / 2, rtol=0, atol=1e-12)


def test_bound_grows_with_chaos() -> None:
    p = HulaHoop(force_amplitude=100.0)
    short, long = (solve(SCENE, p, REST, [end]).error_bound for end in (0.5, 8.0))
    assert np.all(short < 1e-8)
    assert np.all(long > 1e4 * short)
    assert growths(SCENE, p, REST, np.array([2.0, 4.0]))[-1] > 1e2


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


def test_two_routes_agree_to_1e_10() -> None:
    rng = np.random.default_rng(1)
    parameters = random_parameters(rng, 6)
    states = rng.normal(size=(4, 6)) * [[0.01], [2.0], [0.3], [12.0]]
    start = 0.17
    times = start + np.linspace(0.1, 0.4, 3)[:, None] * rng.uniform(0.8, 1.2, 6)
    many = solve_many(SCENE, parameters, states, times, start)
    assert many.states.shape == (4, 6, 3)
    assert many.error_bound.shape == (4, 6)
    assert many.times.shape == (3, 6)
    for i in range(6):
        one = solve(SCENE, point(parameters, i), states[:, i], times[:, i], start)
        size = np.max(np.abs(one.states), axis=1)
        difference = np.max(np.abs(many.states[:, i] - one.states), axis=1)
        assert np.all(difference <= 1e-10 * size)
        assert np.all(difference <= many.error_bound[:, i] + one.error_bound)


def test_points_broadcast() -> None:
    p = HulaHoop(
        force_amplitude=np.array([[50.0], [60.0]]),  # type: ignore[arg-type]
        force_frequency=np.array([2.0, 3.0, 4.0]),  # type: ignore[arg-type]
    )
    states = np.stack([SPINNING, SPINNING, REST], axis=1)
    grid = solve_many(SCENE, p, states, [0.1, 0.2])
    assert grid.states.shape == (4, 2, 3, 2)
    one = solve(SCENE, HulaHoop(force_amplitude=50.0, force_frequency=4.0), REST, [0.1, 0.2])
    np.testing.assert_allclose(grid.states[:, 0, 2], one.states, rtol=1e-9, atol=1e-11)
    single = solve_many(SCENE, HulaHoop(), SPINNING, [0.1, 0.2])
    assert single.states.shape == (4, 2)
    np.testing.assert_allclose(grid.states[:, 1, 1], single.states, rtol=1e-9, atol=1e-11)


@pytest.mark.parametrize("end", [0.3, 1.0])
def test_bounds_of_random_points_hold(end: float) -> None:
    """One sample time each: where differences pass through zero, bounds used to be broken."""
    rng = np.random.default_rng(2)
    count = 60
    parameters = random_parameters(rng, count)
    states = rng.normal(size=(4, count)) * [[0.01], [2.0], [0.3], [15.0]]
    found = solve_many(SCENE, parameters, states, [end])
    fine = rk8_steps(SCENE.right_hand_side(parameters), states, 0.0, end, 1024)
    finer = rk8_steps(SCENE.right_hand_side(parameters), states, 0.0, end, 1536)
    error = np.abs(found.states[..., 0] - finer)
    sure = error > 10 * np.abs(fine - finer)  # elsewhere the finer run knows no better
    assert np.all(error <= found.error_bound + 2 * np.abs(fine - finer))
    assert np.all(error[sure] <= found.error_bound[sure])
    assert np.count_nonzero(found.error_bound > 1e-7 * (1 + np.abs(finer))) < count // 10


def test_a_lost_point_keeps_its_bound_and_spoils_no_other() -> None:
    """A point whose steps are too long blows up; its neighbours in the block must not notice."""
    stiff = HulaHoop(damping_ratio=np.array([0.1, 1e5]))  # type: ignore[arg-type]
    found = solve_many(SCENE, stiff, SPINNING, [0.1], most_steps=64)
    assert np.all(np.isinf(found.error_bound[:, 1]) | (found.error_bound[:, 1] > 1))
    one = solve(SCENE, HulaHoop(), SPINNING, [0.1])
    error = np.abs(found.states[:, 0] - one.states)[:, 0]
    assert np.all(error <= found.error_bound[:, 0])
    assert np.all(error <= 1e-10 * np.abs(one.states[:, 0]).max())


def test_a_chaotic_point_has_a_large_bound_beside_a_small_one() -> None:
    p = HulaHoop(force_amplitude=np.array([60.0, 100.0]))  # type: ignore[arg-type]
    found = solve_many(SCENE, p, REST, [5.0], most_steps=1 << 12)
    assert np.all(found.error_bound[:, 0] < 1e-7)
    assert np.all(found.error_bound[:, 1] > 1e-4)


def test_upright_body_under_slanting_gravity_takes_few_steps() -> None:
    """One of its quaternion's coordinates is 0 but for rounding, which an unstable rest raises."""
    scene = get_scene("rigid_body")
    p = scene.parameters().replace(gravity_x=3.0, gravity_y=-2.0, gravity_z=6.0)
    start = scene.state(scene.equilibria["upright"](p))
    assert solve(scene, p, start, [0.5]).steps < 50


# Drives that end


@pytest.mark.parametrize("ramp_time", [1e-6, 1e-4, 1e-2, 0.05])
@pytest.mark.parametrize("together", [False, True], ids=["alone", "together"])
def test_no_step_leads_across_the_end_of_a_drive(ramp_time: float, together: bool) -> None:
    beam = get_scene("rotating_beam")
    p = beam.parameters().replace(angular_speed=0.5, ramp_time=ramp_time)
    rate, times = beam.state_names.index("theta_dot"), ramp_time + np.array([0.01, 0.05])
    if together:
        both = p.replace(
            ramp_time=np.array([ramp_time, ramp_time + 0.03]) / 10
        )  # its steps are equal
        solution = solve_many(beam, both, beam.state({}), times / 10)
        speeds, bound = solution.states[rate, 0], solution.error_bound[rate, 0]
    else:
        solution = solve(beam, p, beam.state({}), times)
        speeds, bound = solution.states[rate], solution.error_bound[rate]
    off = np.abs(speeds - 0.5)  # a step across the end leaves 1e-13 at least
    assert np.all(off <= 4 * np.finfo(float).eps)
    assert np.all(off <= bound)
    assert bound < 1e-8


@pytest.mark.parametrize("period", [1e-5, 1e-3])
def test_a_short_pulse_is_seen_whenever_it_is_sampled(period: float) -> None:
    beam = get_scene("rotating_beam")
    p = beam.parameters().replace(
        drive="torque", torque_period=period, torque_amplitude=1 / period**2
    )
    turned = beam.state_names.index("theta")
    alone = solve(beam, p, beam.state({}), np.array([0.05]))
    at_its_end = solve(beam, p, beam.state({}), np.array([period, 0.05]))
    assert abs(alone.states[turned, 0]) > 1e-4
    off = np.abs(alone.states[:, 0] - at_its_end.states[:, 1])
    assert np.all(off <= alone.error_bound + at_its_end.error_bound)


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("rotating_beam", {"drive": "torque", "torque_period": 0.03}),
        ("hula_hoop", {}),
    ],
)
def test_states_without_a_bound_are_the_same(name: str, changes: Any) -> None:
    scene, times = get_scene(name), np.array([0.01, 0.04, 0.05])
    p, start = scene.parameters().replace(**changes), scene.state({})
    for tolerances in (None, (1e-7, 1e-6)):
        whole = solve(scene, p, start, times, tolerances=tolerances).states
        alone = states_at(scene, p, start, times, tolerances)
        np.testing.assert_allclose(alone, whole, rtol=1e-12, atol=1e-15 * np.max(np.abs(whole)))

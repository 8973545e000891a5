"""Stated bounds against errors: runs drawn at random, solved in higher precision by a second route.

The figures of all draws are printed by ``python -m mbcheck.tests.support.precise SCENE 0 500``.
"""

from __future__ import annotations

import dataclasses
import tracemalloc
from collections.abc import Mapping
from functools import partial
from typing import Any

import gmpy2
import numpy as np
import pytest

from mbcheck.reference import SCENES, get_scene
from mbcheck.reference.scene import Array
from mbcheck.reference.solve import single
from mbcheck.reference.solve.batched import solve_many
from mbcheck.reference.solve.bounds import HALF_UNIT, OPTIONS, sensitivities, slopes_of
from mbcheck.reference.solve.single import solve, straightened
from mbcheck.tests.support.precise.beam import Beam
from mbcheck.tests.support.precise.compare import compare, precision, system_of
from mbcheck.tests.support.precise.figures import figures, median_margin
from mbcheck.tests.support.precise.runs import KINDS, PROVOCATIONS, run_of
from mbcheck.tests.support.precise.series import System

FEW: Mapping[str, tuple[int, ...]] = {
    "hula_hoop": (0, 1, 2, 3, 4, 65, 66, 7, 8, 9),
    "rotating_beam": (0, 1, 22, 3, 14, 15, 16, 407, 378, 19),
    "rotor_pendulum": (20, 21, 22, 3, 4, 45, 96, 67, 58, 9),
    "speed_regulator": (0, 1, 2, 3, 4, 5, 6, 7, 8, 9),
    "rigid_body": (0, 1, 2, 3, 4, 5, 6, 72),
    "ball_hoop": (5, 1, 2, 12, 3, 4),
    "floating_platform": (15, 1, 12, 18, 4),
    "floating_beam": (0, 1, 2, 3, 4),
}
"""Draws of each scene that take little time, one of each kind; of beams those that were hardest."""

LONG = {"floating_platform": (4, 15, 18), "floating_beam": (2, 4)}
BY_HAND = {"floating_beam": (0, 1, 3)}
"""Those of them that take longest, which are slow tests, or half a minute each."""

MANY, BLOCK = 500, 25

COMPARE = "mbcheck.tests.support.precise.compare.solve"

CLOSE = 30.0
"""Largest median of stated bound over error, of regular motions."""


@pytest.mark.parametrize("scene", FEW)
def test_few_draws_are_of_all_kinds(scene: str) -> None:
    assert set(FEW) == set(SCENES) == set(KINDS)
    assert {run_of(scene, number).kind for number in FEW[scene]} == {
        kind.__name__ for kind in KINDS[scene]
    }


@pytest.mark.parametrize(
    ("scene", "number"),
    [
        pytest.param(
            scene,
            number,
            marks=[
                mark
                for mark, numbers in ((pytest.mark.slow, LONG), (pytest.mark.campaign, BY_HAND))
                if number in numbers.get(scene, ())
            ],
        )
        for scene, few in FEW.items()
        for number in few
    ],
)
def test_no_error_is_above_its_bound(scene: str, number: int) -> None:
    shortened = dataclasses.replace(run_of(scene, number), patience=0.4)
    outcome = compare(shortened)
    assert not outcome.refusal
    assert outcome.excess <= 1
    assert outcome.excess_in_time <= 1


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow] if provocation.slow else [])
        for name, provocation in PROVOCATIONS.items()
    ],
)
def test_no_error_is_above_its_bound_where_that_is_hard(name: str) -> None:
    outcome = compare(PROVOCATIONS[name].run)
    assert not outcome.refusal
    assert outcome.excess <= 1
    assert outcome.excess_in_time <= 1


@pytest.mark.parametrize(
    ("scene", "number"),
    [("rigid_body", 72), pytest.param("ball_hoop", 32, marks=pytest.mark.slow)],
)
def test_bounds_of_many_count_the_rounding_of_a_tensor(
    monkeypatch: pytest.MonkeyPatch, scene: str, number: int
) -> None:
    """Their arms are long beside radii of gyration."""
    monkeypatch.setattr(COMPARE, partial(solve_many, tolerance=1e-14))
    assert compare(dataclasses.replace(run_of(scene, number), patience=0.3)).excess <= 1


def test_bounds_of_many_at_rest_count_the_rounding_of_forces() -> None:
    """The saddle's rate is 4.2 1/s: a unit of rounding of the forces grows by 1e9 in 5 s."""
    run = PROVOCATIONS["at rest between balanced forces"].run
    start = get_scene(run.scene).state(run.state)
    unit = solve(get_scene(run.scene), run.parameters, start, [5.0]).error_bound
    many = solve_many(get_scene(run.scene), run.parameters, start, [5.0])
    assert np.all(many.error_bound > unit / 10)


@pytest.mark.campaign
@pytest.mark.parametrize("first", range(0, MANY, BLOCK))
@pytest.mark.parametrize("scene", FEW)
def test_no_error_of_many_draws_is_above_its_bound(scene: str, first: int) -> None:
    outcomes = [compare(run_of(scene, number)) for number in range(first, first + BLOCK)]
    print(figures(outcomes))
    assert max(outcome.excess for outcome in outcomes) <= 1
    assert max(outcome.excess_in_time for outcome in outcomes) <= 1
    assert sum(bool(outcome.refusal) for outcome in outcomes) <= BLOCK // 5
    assert median_margin(outcomes) < CLOSE


def rounding_of(system: System, derivative: Any, time: Array, x: Array) -> Array:
    """Return what accelerations (n,) are off in 200 bits, at a time (1,) and a state (2 n, 1)."""
    rates = derivative(time, x)[len(x) // 2 :, 0]
    with precision(200):
        numbers = [gmpy2.mpfr(float(value)) for value in x[:, 0]]
        series = system.expand(gmpy2.mpfr(float(time[0])), numbers, 2)
        pairs = zip(rates, series, strict=True)
        return np.array([float(gmpy2.mpfr(float(a)) - 2 * row[2]) for a, row in pairs])


def test_accelerations_of_a_beam_are_rounded_as_its_bound_says() -> None:
    """Each mode of the mass matrix by its own standard deviation, of which five are counted."""
    scene, shares = get_scene("rotating_beam"), []
    n, rng = len(scene.coordinates), np.random.default_rng(1)
    for number in range(12):
        p = run_of("rotating_beam", number).parameters
        x = 10.0 ** rng.uniform(-6, 0) * rng.normal(size=(2 * n, 1))
        x[0], time = rng.uniform(-3, 3), np.array([rng.uniform(0, 1)])
        off = rounding_of(Beam(p, 200), scene.right_hand_side(p), time, x)
        effects = sensitivities(scene, p, time, x)
        mass = np.array(scene.mass_matrix(x[:n, 0], scene.coefficients(p)), dtype=float)
        modes = np.linalg.eigh(mass[1:, 1:])[1].T
        deviation = HALF_UNIT * np.linalg.norm(modes @ effects.directions[n + 1 :, :, 0], axis=1)
        shares.append(modes @ off[1:] / deviation)
    assert 0.3 < np.sqrt(np.mean(np.square(shares))) < 1.3
    assert np.max(np.abs(shares)) < OPTIONS.deviations


@pytest.mark.parametrize(
    ("scene", "corners"), [("rigid_body", (72, 93, 177)), ("ball_hoop", (2, 17, 32))]
)
def test_accelerations_of_a_body_are_rounded_as_its_bound_says(
    scene: str, corners: tuple[int, ...]
) -> None:
    """Where its arm is long beside radii of gyration, rounding of its tensor is all there is."""
    known, shares = get_scene(scene), []
    without = dataclasses.replace(
        known,
        inexact_numbers=lambda c, change: iter(()),
        inexact_accelerations=lambda change: iter(()),
    )
    for number in (*range(20), *corners):
        run = run_of(scene, number)
        x = known.state(run.state)[:, None]
        time = np.array([run.start_time])
        off = rounding_of(system_of(run, 200), known.right_hand_side(run.parameters), time, x)
        seen = np.flatnonzero(off)
        all_of_it, by_parameters = (
            np.abs(off[seen])
            / (HALF_UNIT * np.linalg.norm(effects.inputs[len(off) + seen, :, 0], axis=1))
            for effects in (sensitivities(one, run.parameters, time, x) for one in (known, without))
        )
        shares.extend(all_of_it)
        assert number not in corners or np.max(by_parameters) > 1e3
    assert 0.3 < np.sqrt(np.mean(np.square(shares))) < 1.3
    assert np.max(shares) < OPTIONS.deviations


@pytest.mark.parametrize("number", [0, 1, 9])
def test_accelerations_of_a_body_at_rest_are_rounded_as_its_bound_says(number: int) -> None:
    """What turns it about its arm is the rounding of products that balance, and nothing else."""
    scene, run = get_scene("rigid_body"), run_of("rigid_body", number)
    x = scene.state(scene.equilibria["hanging"](run.parameters))[:, None]
    off = rounding_of(system_of(run, 200), scene.right_hand_side(run.parameters), np.zeros(1), x)
    effects = sensitivities(scene, run.parameters, np.zeros(1), x)
    deviation = HALF_UNIT * np.linalg.norm(effects.inputs[len(off) :, :, 0], axis=1)
    assert np.all(np.abs(off) < OPTIONS.deviations * deviation)


def test_rounding_at_rest_pushes_in_one_direction() -> None:
    """What it makes of a rotation about the vertical grows with the square of time."""
    scene, run = get_scene("rigid_body"), run_of("rigid_body", 0)
    start = scene.state(scene.equilibria["hanging"](run.parameters))
    solution = solve(scene, run.parameters, start, [15.0, 60.0])
    assert solution.bounds is not None
    assert solution.bounds[3, 1] > 10 * solution.bounds[3, 0]


def test_slopes_of_a_continuum_take_little_memory() -> None:
    scene = get_scene("rotating_beam")
    states = 1e-3 * np.ones((len(scene.state_names), 500))
    tracemalloc.start()
    slopes = slopes_of(scene, scene.parameters(), np.zeros(500), states)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert np.all(np.ptp(slopes, axis=0) == 0)
    assert peak < 5e7


def test_states_are_looked_at_where_they_bend() -> None:
    nodes = np.array([0.0, 1.0, 3.0])
    assert straightened(nodes, lambda t: np.array([t, 2 - t])).tolist() == nodes.tolist()
    fine = straightened(nodes, lambda t: np.array([t, np.cos(2 * t)]))
    assert set(nodes) < set(fine)
    assert np.max(np.diff(fine)) == 0.25  # in 0.5, a sixth of a period, it is 0.12 off
    assert (
        len(straightened(nodes, lambda t: np.array([np.cos(1e3 * t)])))
        == 2 * single.OPTIONS.max_parts + 1
    )


def test_bound_that_is_too_small_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    def proud(*args: Any) -> Any:
        solution = solve(*args)
        bounds = None if solution.bounds is None else solution.bounds * 1e-9
        return dataclasses.replace(solution, bounds=bounds, error_bound=solution.error_bound * 1e-9)

    assert compare(run_of("hula_hoop", 0)).excess < 1
    monkeypatch.setattr(COMPARE, proud)
    assert compare(run_of("hula_hoop", 0)).excess > 1e3


@pytest.mark.parametrize("state", range(4))
def test_state_that_is_off_is_seen(monkeypatch: pytest.MonkeyPatch, state: int) -> None:
    def wrong(*args: Any) -> Any:
        solution = solve(*args)
        states = solution.states.copy()
        states[state, -1] += 2 * solution.error_bound[state]
        return dataclasses.replace(solution, states=states)

    monkeypatch.setattr(COMPARE, wrong)
    assert 1 < compare(run_of("hula_hoop", 0)).excess < 3.1


def test_draws_are_the_same_each_time() -> None:
    for scene in SCENES:
        one, other = run_of(scene, 11), run_of(scene, 11)
        assert one == other
        assert np.all(np.diff(one.times(1.0)) > 0)

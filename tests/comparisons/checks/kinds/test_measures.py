"""What kinds of check take for granted: each number against another way to compute it."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from scipy.linalg import null_space

from mbcheck.comparisons.checks import elements
from mbcheck.comparisons.checks.comparison import NEXT_ORDERS, ROUNDING, Richardson
from mbcheck.comparisons.checks.kinds import (
    energy,
    frequency,
    one_step,
    order,
    stability,
)
from mbcheck.comparisons.checks.mistakes.parts import Effect, explain
from mbcheck.comparisons.checks.verdict import Finding
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.models.rotating_beam.mjcf import side
from mbcheck.reference import get_scene
from mbcheck.reference.linear import modes
from mbcheck.reference.orbits import Orbit, Orbits, trivial_multiplier
from mbcheck.reference.rotating_beam import SCENE as BEAM
from mbcheck.reference.scene import Array
from mbcheck.tests.support.subjects import Subject, check_of


def matrices(seed: int) -> tuple[Array, Array, Array]:
    """Return M of unit inertias, C and K (3, 3), symmetric and positive definite."""
    random = np.random.default_rng(seed)
    m, c, k = (a @ a.T + np.eye(3) for a in random.normal(size=(3, 3, 3)))
    root = 1 / np.sqrt(np.diag(m))
    return m * np.outer(root, root), 0.3 * c, 20 * k


@pytest.mark.parametrize("seed", range(4))
def test_an_eigenvalue_moves_by_its_sensitivity_at_most_and_may_move_by_all_of_it(
    seed: int,
) -> None:
    """Theorem 5 of Tisseur (2000) is sharp: each matrix off along y x^H moves it by the bound."""
    m, c, k = matrices(seed)
    for mode in modes(m, c, k):
        s = complex(mode.re, mode.im)
        bound = frequency.sensitivity(m, c, k, mode, 1e-11)
        pencil = s**2 * m + s * c + k
        x, y = (null_space(one, rcond=1e-9)[:, 0] for one in (pencil, pencil.conj().T))
        worst = sum(
            abs(s) ** power * np.linalg.norm(matrix, 2)
            for power, matrix in ((2, m), (1, c), (0, k))
        ) / abs(y.conj() @ (2 * s * m + c) @ x)
        assert bound == pytest.approx(1e-11 * worst, rel=1e-6)
        units = np.array([1.0, 1e3, 1e-2])  # metres, millimetres, ...
        mass, damping, stiffness = (matrix * np.outer(units, units) for matrix in (m, c, k))
        assert frequency.sensitivity(mass, damping, stiffness, mode, 1e-11) == pytest.approx(
            bound, rel=1e-6
        )


@pytest.mark.parametrize(
    ("engine", "model", "method"),
    [("exudyn", "kinematic_tree", "GeneralizedAlpha"), ("mujoco", "tree", "implicit")],
)
def test_a_drift_is_predicted_and_no_more_is_granted(engine: str, model: str, method: str) -> None:
    """Half the step of a method of order p tells (2^p - 1) / 2^p of the drift."""
    subject = Subject("hula_hoop", engine, model, method)
    setup = check_of(subject, "energy", "free_undamped").setup()
    blind = replace(setup)
    blind.__dict__["scheme"] = None  # as if it were no published scheme
    (drift,) = energy.measure(blind).findings
    assert isinstance(drift, Finding)
    assert drift.error > 1e-9
    assert 1.2 < drift.tolerance / drift.error < 1.8


def orbit(*multipliers: float, trivial: int | None) -> Orbit:
    """Return an orbit of two states whose period map is diagonal."""
    values = np.array(multipliers)
    return Orbit(1.0, np.zeros(2), values, np.diag(values), trivial)


@pytest.mark.parametrize(
    ("one", "stable", "direction"),
    [
        (orbit(1.0000001, 0.5, trivial=0), True, [0, 1]),
        (orbit(0.5, 1.0000001, trivial=1), True, [1, 0]),
        (orbit(1.0000001, 0.5, trivial=None), False, [1, 0]),
        (orbit(0.9999999, 1.2, trivial=0), False, [0, 1]),
    ],
)
def test_a_shift_in_time_is_no_disturbance(
    one: Orbit, stable: bool, direction: list[float]
) -> None:
    assert one.stable == stable
    towards, left = stability.leading_directions(one, np.ones(2))
    np.testing.assert_array_equal(np.abs(towards), direction)
    np.testing.assert_array_equal(np.abs(left), direction)


def test_the_trivial_multiplier_is_the_one_nearest_to_1() -> None:
    values = np.array([[-1.01, 3.0], [0.9, 0.2], [0.5, 1.1]])
    np.testing.assert_array_equal(trivial_multiplier(get_scene("speed_regulator"), values), [1, 2])
    assert trivial_multiplier(get_scene("hula_hoop"), values) is None

    slopes = np.array([np.diag([*(column - 1), 0.0])[:3] for column in values.T])
    orbits = Orbits(
        states=np.zeros((3, 2)),
        periods=np.ones(2),
        closed=np.array([True, True]),
        correction=np.zeros(2),
        slopes=slopes,
        scale=np.ones((3, 2)),
        columns=np.array([3, 1, 2]),
    )
    np.testing.assert_allclose(orbits.leading, [1.01, 3.0])


def in_words(name: str, x: Array, moved: Array) -> str:
    """Return a name and its number (1,)."""
    return f"{name} {x[0]:.3g}"


def candidates(columns: Any, *names: str, added: bool = False) -> list[Effect]:
    """Return candidates of one number each."""
    return [
        Effect(name, column[:, None], partial(in_words, name), added)
        for name, column in zip(names, np.transpose(columns), strict=True)
    ]


def test_of_explanations_the_smallest_change_is_named_and_the_other_beside_it() -> None:
    """A row that a light part explains by 5 times its size, and a heavy one by 1 % of it."""
    columns, names = np.array([[1e-3, 0.5], [1e-3, 0.5]]), ("mass.light", "spring.heavy")
    for both in (candidates(columns, *names), candidates(columns, *names)[::-1]):
        found = explain(both, (), 5e-3 * np.ones(2), 1e-9)
        assert found.values["spring.heavy"] == pytest.approx(0.01)
        assert found.values["mass.light"] == 0
        assert found.others == {"spring.heavy": ("mass.light 5",)}


def test_several_parts_that_are_off_have_their_own_shares() -> None:
    """Whatever the size of their forces; no part alone explains the rows."""
    columns = np.random.default_rng(4).normal(size=(20, 4)) * [1e-3, 1.0, 0.1, 1.0]
    extra, names = np.array([0.5, -1.0, 0.0, 2.0]), ("mass.a", "spring.b", "damper.c", "spring.d")
    found = explain(candidates(columns, *names), (), columns @ extra, ROUNDING)
    assert found.left < found.granted
    values = np.concatenate([found.values[name] for name in names])
    np.testing.assert_allclose(values, extra, atol=1e-12)
    moved = ROUNDING * np.sum(np.abs(np.linalg.pinv(columns)), axis=1)
    np.testing.assert_allclose(np.concatenate([found.tolerances[n] for n in names]), moved)


def test_nothing_is_named_that_is_not_unique() -> None:
    """Two parts of five explain what one term does that is none of them, since rows are few."""
    columns = np.random.default_rng(1).normal(size=(5, 6))
    parts, rows = candidates(columns[:, :5], *"abcde"), columns[:, 5]
    assert not explain(parts, (), rows, 1e-10).unique
    found = explain(parts, candidates(columns[:, 5:], "f", added=True), 3 * rows, 1e-10)
    assert found.added == ("f 3",)
    assert all(found.values[name] == 0 for name in "abcde")
    assert found.left == pytest.approx(np.linalg.norm(3 * rows))
    twins = candidates(columns[:, [5, 5]], "f", "g", added=True)
    assert explain(parts, twins, 3 * rows, 1e-10).added == ("f 3, or g 3",)
    assert not explain(
        parts, candidates(columns[:, [5] * 4], *"fghi", added=True), rows, 1e-10
    ).unique
    near = columns[:, 5] + 2e-10 * columns[:, 0]  # explains nearly as much
    twins = candidates(np.array([columns[:, 5], near]).T, "f", "g", added=True)
    assert explain(parts, twins, 3 * rows, 1e-10).added == ("f 3, or g 3",)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"scheme": "A", "mass": 0.0}, -1),
        ({"scheme": "B", "mass": 0.0}, 1),
        ({"scheme": "A", "mass": 0.1, "mass_position": 1.0}, -1),
        ({"scheme": "B", "mass": 0.1, "mass_position": 1.0}, 1),
        ({"scheme": "A", "mass": 0.1, "mass_position": 0.5}, 0),
        ({"scheme": "B", "mass": 0.1, "mass_position": 0.5}, 0),
    ],
)
def test_the_side_of_a_chains_first_frequency(changes: dict[str, object], expected: int) -> None:
    """Of the discrete system itself, by the frequencies of both."""
    case = BEAM.case("steady_4")
    p = case.parameters.replace(segments=12, **changes)
    assert side(p) == expected
    setup = Setup(get_engine("mujoco"), replace(case, parameters=p), "chain")
    assert setup.bound.frequency_side == expected
    off = elements.of_model_equations(setup)[0] / elements.exact(setup.case)[0] - 1
    assert expected in (0, np.sign(off))


@pytest.mark.parametrize(
    ("change", "ratio", "regular"),
    [
        (50.0, 1.0, True),  # as small as rounding
        (1e3, 16.0, True),
        (1e3, 12.0, True),
        (1e3, 11.0, False),  # slower than the order less a half
        (1e3, 33.0, False),  # by chance
        (1e3, 1.0, False),
    ],
)
def test_what_converges_as_declared_can_be_extrapolated(
    change: float, ratio: float, regular: bool
) -> None:
    one = Richardson(0.0, np.zeros(1), np.full(1, 0.1 * change), change, ratio, 4)
    orbits = stability.OrbitRuns([], {"q": one}, {"q": 1.0}, {"q": 1e9}, 0.1, ratio, True, True)
    assert orbits.regular == ["q"] * regular
    assert orbits.room("q") == pytest.approx(NEXT_ORDERS * 0.1 * change + 1)


def test_an_order_that_is_not_met_yet_leaves_larger_errors() -> None:
    """Of the starts of a row the ratio is that of the largest changes, as one may vanish."""
    runs = [np.array([[0.0, 7.0]]), np.array([[0.0, 3.0]]), np.array([[0.0, 1.0]])]
    assert one_step.slower(runs, 1) == pytest.approx(1.0)
    ratio = 2**1.5  # the least that order 2 admits
    assert one_step.slower(runs, 2) == pytest.approx(ratio / (ratio - 1) * 3 / 4)


@pytest.mark.parametrize(
    ("first", "slopes", "decided"),
    [
        (1e-3, (2, 2, 2, 2), True),
        (1e-3, (2, 2, 2), False),  # too few
        (0.1, (2, 2, 2, 2), False),  # what is below may shrink by order 1
        (1e-3, (2, 2, 2, 1.5), False),
        (1e-3, (2, 2, 1.5, 2), False),
        (1e-3, (1.5, 1.5, 2, 2), True),
        (1.0, (2, 1, 1, 1), True),  # they have settled on another order
        (1.0, (2, 1, 1, 1.5), False),
        (1.0, (2, 1.5, 1.5, 1.5), False),  # which may come up yet
    ],
)
def test_steps_are_halved_until_the_order_is_decided(
    first: float, slopes: tuple[float, ...], decided: bool
) -> None:
    errors = first * 0.5 ** np.cumsum([0.0, *slopes])
    assert order.enough(list(errors), 2) is decided

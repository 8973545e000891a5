"""Newton's method on systems whose solutions are known in closed form."""

from __future__ import annotations

from itertools import cycle
from typing import Any

import numpy as np
import pytest

from mbcheck.reference.differences import by_complex_step, by_differences
from mbcheck.reference.newton import (
    CLOSED,
    ROUNDING,
    Effort,
    Rows,
    correction,
    linearisation,
    newton,
)
from mbcheck.reference.scene import Array

RADII = np.array([1.0, 2.0, 0.5, -1.0])
"""Of circles; the last one has no point."""


class Circles:
    """x^2 + y^2 = r |r| and x = y; counts how often each circle is asked."""

    def __init__(self) -> None:
        self.asked = np.zeros(len(RADII), dtype=int)

    def __call__(self, rows: Rows, x: Any) -> Any:
        radius = RADII[rows]
        np.add.at(self.asked, rows, x.size // (2 * len(rows)))
        return np.array([x[0] ** 2 + x[1] ** 2 - radius * abs(radius), x[0] - x[1]])


START = np.array([[0.8, 1.1, 0.4, 0.5], [0.7, 1.2, 0.3, 0.6]])


@pytest.mark.parametrize("rule", [by_complex_step, by_differences])
@pytest.mark.parametrize("chords", [0, 3])
def test_solutions_and_jacobians(rule: Any, chords: int) -> None:
    circles = Circles()
    roots = newton(circles, linearisation(circles, rule), START, Effort(20, chords))
    assert roots.closed.tolist() == [True, True, True, False]
    expected = np.abs(RADII[:3]) / np.sqrt(2)
    np.testing.assert_allclose(roots.unknowns[:, :3], [expected] * 2, rtol=1e-13)
    if not chords:
        slopes = [[[2 * x, 2 * x], [1, -1]] for x in expected]
        np.testing.assert_allclose(roots.jacobians[:3], slopes, atol=1e-9)


def test_what_is_solved_is_left_alone() -> None:
    circles = Circles()
    newton(circles, linearisation(circles, by_complex_step), START, Effort(40, longest=10.0))
    assert np.all(circles.asked[:3] < 20)
    assert circles.asked[3] == 2 * 40


def test_known_jacobians_serve_first() -> None:
    def none(rows: Rows, x: Array) -> tuple[Array, Array]:
        raise AssertionError

    circles = Circles()
    near = np.array([RADII[:2], RADII[:2]]) / np.sqrt(2) + 1e-5
    _, jacobians = linearisation(circles, by_complex_step)(np.arange(2), near)
    roots = newton(circles, none, near, Effort(1, chords=4), jacobians)
    assert np.all(roots.closed)
    assert np.max(roots.size) < ROUNDING


def test_a_singular_jacobian_solves_nothing_and_leaves_the_others_as_they_are() -> None:
    """y = 0 with slopes of nothing but x: the shortest correction leaves y, however small it is."""
    matrix = np.array([[[1.0, 0.0], [0.0, 0.0]], [[3.0, 1.0], [1.0, 7.0]]])
    left = np.array([[0.0, 0.3], [0.5, 0.7]])
    change, size = correction(matrix, left)
    assert change[:, 0].tolist() == [0.0, 0.0]
    assert size[0] == 0.5
    alone, _ = correction(matrix[1:], left[:, 1:])
    np.testing.assert_array_equal(change[:, 1:], alone)
    roots = newton(
        lambda rows, x: left[:, :1], lambda rows, x: (left[:, :1], matrix[:1]), left[:, :1]
    )
    assert not roots.closed[0]


def test_a_line_of_solutions_is_met_where_it_is_near() -> None:
    """x + y = 1 twice."""
    roots = newton(
        lambda rows, x: np.array([x[0] + x[1] - 1, 2 * (x[0] + x[1] - 1)]),
        lambda rows, x: (
            np.array([x[0] + x[1] - 1, 2 * (x[0] + x[1] - 1)]),
            np.array([[[1.0, 1.0], [2.0, 2.0]]]),
        ),
        np.array([[0.5], [0.4]]),
    )
    assert roots.closed[0]
    np.testing.assert_allclose(roots.unknowns[:, 0], [0.55, 0.45], atol=1e-12)


def test_rounding_ends_the_search_and_counts_below_the_tolerance() -> None:
    """Noise that no correction can go below: of a period map that an implicit method rounds."""
    noise = np.array([0.2, 20.0]) * CLOSED
    signs = cycle([1, -1])

    def residual(rows: Rows, x: Any) -> Any:
        return x - 1 + noise[rows] * next(signs)

    def linearise(rows: Rows, x: Array) -> tuple[Array, Array]:
        return residual(rows, x), np.ones((len(rows), 1, 1))

    roots = newton(residual, linearise, np.full((1, 2), 0.95), Effort(60))
    assert roots.closed.tolist() == [True, False]
    np.testing.assert_allclose(roots.unknowns[0], 1, atol=50 * CLOSED)


def test_long_corrections_are_shortened() -> None:
    circles = Circles()
    roots = newton(
        circles, linearisation(circles, by_complex_step), np.full((2, 2), 1e3), Effort(1)
    )
    np.testing.assert_allclose(roots.unknowns, 1e3 - 0.1, rtol=1e-12)
    assert np.all(roots.size > 400)


def test_singular_and_infinite_systems_are_lost_alone() -> None:
    def residual(rows: Rows, x: Any) -> Any:
        kind = np.array([0.0, 1.0, 2.0])[rows]
        return np.where(kind == 0, x - 3, np.where(kind == 1, 1 + 0 * x, np.inf * (1 + x)))

    with np.errstate(all="ignore"):
        roots = newton(residual, linearisation(residual, by_differences), np.zeros((1, 3)))
    assert roots.closed.tolist()[0]
    assert not roots.closed[2]
    assert roots.unknowns[0, 0] == pytest.approx(3)


def test_columns_choose_what_is_solved_for() -> None:
    """The second unknown's column is that of a parameter."""

    def linearise(rows: Rows, x: Array) -> tuple[Array, Array]:
        left = np.array([x[0] - 1.0, 2 * x[1] - 4.0])
        slopes = np.array([[[1.0, 7.0, 0.0], [0.0, 9.0, 2.0]]])
        return left, slopes

    roots = newton(
        lambda rows, x: linearise(rows, x)[0], linearise, np.zeros((2, 1)), Effort(60),
        columns=np.array([0, 2]),
    )  # fmt: skip
    np.testing.assert_allclose(roots.unknowns[:, 0], [1.0, 2.0])
    assert roots.jacobians.shape == (1, 2, 3)

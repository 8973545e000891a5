"""Continuation of curves that are known in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from mbcheck.reference.continuation.curve import (
    ContinuationOptions,
    CurveEquations,
    Node,
    between,
    correct,
    step_on,
    tangent_of,
)
from mbcheck.reference.scene import Array


def circle(z: Array) -> tuple[Array, Array]:
    return np.array([z @ z - 1]), 2 * z[None]


def sheared(z: Array) -> tuple[Array, Array]:
    """The same with slopes that are off by a tenth."""
    return np.array([z @ z - 1]), 2 * z[None] * 1.1 + 0.1


@pytest.mark.parametrize(("rule", "exact"), [(circle, True), (sheared, False)])
def test_a_circle_is_followed_past_its_turning_points(rule: object, exact: bool) -> None:
    neighbour = () if exact else (lambda z: sheared(z)[0], lambda z: sheared(z)[1])
    equations = CurveEquations(rule, *neighbour)  # type: ignore[arg-type]
    here = Node(np.array([1.0, 0.0]), np.array([0.0, 1.0]), np.empty(0))
    length, angle = 0.1, 0.0
    options = ContinuationOptions(ds_max=0.1, turn=0.2, max_turn=0.32)
    for _ in range(100):
        step = step_on(equations, here, length, options=options)
        assert step is not None
        ahead, length = step
        assert abs(ahead.z @ ahead.z - 1) < 1e-8
        middle = between(here, ahead, 0.5)
        assert not exact or abs(middle @ middle - 1) < 1e-4
        angle += float(np.arccos(np.clip(ahead.z @ here.z, -1, 1)))
        here = ahead
        if angle > 2 * np.pi:
            break
    assert angle > 2 * np.pi


def bends(z: Array) -> tuple[Array, Array]:
    """A curve that bends by a right angle at once, and beside it the line straight on."""
    root = np.hypot(z[0], 0.01)
    bend, line = z[1] - root, z[1] + z[0] + 0.1
    return np.array([bend * line]), np.array([[-z[0] / root * line + bend, line + bend]])


def test_steps_lead_to_no_curve_near_by() -> None:
    """The cubic leads straight on, to where the line is a fifth of the step away."""
    before, here = (
        None,
        Node(np.array([-2.0, 2.0]), np.array([1.0, -1.0]) / np.sqrt(2), np.empty(0)),
    )
    options = ContinuationOptions(ds=0.04, ds_max=0.35, turn=0.5)
    length, count = options.ds, 0
    while here.z[0] < 2:
        step = step_on(CurveEquations(bends), here, length, before, options)
        assert step is not None
        before, (here, length) = here, step
        assert abs(here.z[1] - np.hypot(here.z[0], 0.01)) < 1e-8
        count += 1
    assert count < 80


def test_newtons_method_says_where_there_is_no_point() -> None:
    assert correct(CurveEquations(circle), np.array([3.0, 0.1]), np.array([1.0, 0.0]), 3.0) is None


def test_steps_end_where_the_equations_do() -> None:
    """Beyond z_0 = 1 the equations are not defined."""

    def ends(z: Array) -> tuple[Array, Array]:
        with np.errstate(invalid="ignore"):
            return np.array([z[1] - np.sqrt(1 - z[0])]), np.array([[0.5 / np.sqrt(1 - z[0]), 1.0]])

    here = Node(np.array([0.5, np.sqrt(0.5)]), np.array([0.8, -0.6]), np.empty(0))
    length = 0.1
    for _ in range(200):
        step = step_on(CurveEquations(ends), here, length)
        if step is None:
            break
        here, length = step
    assert step is None
    assert here.z[0] == pytest.approx(1.0, abs=0.02)


def test_tangents_are_of_slopes_at_the_point_itself() -> None:
    """Not at the guess, with the secants that Newton's method has gathered from there."""

    def ellipse(z: Array) -> Array:
        return np.array([z[0] ** 2 + 9 * z[1] ** 2 - 1])

    def slopes(z: Array) -> Array:
        return np.array([[2 * z[0], 18 * z[1]]])

    row, point = np.array([1.0, 1.0]), np.array([0.6, 0.8 / 3])
    equations = CurveEquations(lambda z: (ellipse(z), slopes(z)), ellipse, slopes)
    solution = correct(equations, point + np.array([-0.1, 0.1]), row, float(row @ point))
    assert solution is not None
    assert solution.z == pytest.approx(point, abs=1e-8)
    across = tangent_of(solution.jacobian, row) @ slopes(point)[0]
    assert across == pytest.approx(0, abs=1e-7)

"""Stencils against their order conditions, and derivatives against closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mbcheck.reference import differences
from mbcheck.reference.differences import (
    balanced_step,
    by_complex_step,
    by_differences,
    stencil,
)
from mbcheck.reference.scene import Array

ORDERS = (1, 2, 4, 6, 8)


@pytest.mark.parametrize("order", ORDERS)
def test_a_stencil_is_exact_up_to_its_order_and_no_further(order: int) -> None:
    places, weights = stencil(order)
    reach = np.max(np.abs(places))
    moments = [float(weights @ (places / reach) ** power) for power in range(order + 2)]
    np.testing.assert_allclose(moments[: order + 1], np.eye(order + 1)[1] / reach, atol=1e-15)
    assert abs(moments[order + 1]) > 1e-6


@pytest.mark.parametrize("order", ORDERS)
def test_the_balanced_step_is_near_the_best(order: int) -> None:
    """No step a factor of 30 away makes an error much smaller."""

    def error(step: float) -> float:
        at = np.linspace(0.1, 1.4, 40)
        slope = differences.derivative(lambda t: np.exp(at + t), order, step)
        return float(np.max(np.abs(slope / np.exp(at) - 1)))

    own = balanced_step(order)
    assert error(own) < 5 * min(error(30 * own), error(own / 30), 1e-7)


def pendulum(x: Any) -> Any:
    """From (2, ...) to (3, ...)."""
    return np.array([np.sin(x[0]) * x[1], x[1] ** 2, np.cos(x[0])])


def slopes(x: Array) -> Array:
    zero = 0 * x[0]
    return np.array([[np.cos(x[0]) * x[1], np.sin(x[0])], [zero, 2 * x[1]], [-np.sin(x[0]), zero]])


@pytest.mark.parametrize("shape", [(2,), (2, 5), (2, 3, 4)])
def test_jacobians_of_one_point_and_of_many(shape: tuple[int, ...]) -> None:
    x = np.random.default_rng(3).normal(size=shape)
    for order, bound in ((1, 1e-6), (2, 1e-9), (4, 1e-11), (8, 1e-12)):
        value, jacobian = by_differences(pendulum, x, order)
        np.testing.assert_array_equal(value, pendulum(x))
        np.testing.assert_allclose(jacobian, slopes(x), atol=bound)
    value, jacobian = by_complex_step(pendulum, x)
    np.testing.assert_allclose(value, pendulum(x), rtol=1e-15)
    np.testing.assert_allclose(jacobian, slopes(x), rtol=1e-14, atol=1e-15)


def test_what_is_equal_on_either_side_has_no_slope() -> None:
    value, jacobian = by_differences(lambda x: np.cos(x), np.zeros(3))
    assert np.all(value == 1)
    assert np.all(jacobian == 0)


def test_stencils_of_order_4_and_8_are_those_of_the_tables() -> None:
    places, weights = stencil(4)
    assert dict(zip(places, weights, strict=True)) == pytest.approx(
        {1: 2 / 3, -1: -2 / 3, 2: -1 / 12, -2: 1 / 12}
    )
    assert stencil(8).weights[::2] == pytest.approx([4 / 5, -1 / 5, 4 / 105, -1 / 280])


def test_rounding_and_roughness_move_the_step_as_they_should() -> None:
    assert balanced_step(4, 1e-14, 1e4) == pytest.approx(1e-18**0.2)
    assert balanced_step(1, 1e-14) == pytest.approx(1e-7)

"""Schemes of engines satisfy the conditions of their order."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mbcheck.reference import get_scene
from mbcheck.reference.hula_hoop.equations import (
    PLATE,
    UNFORCED,
    HulaHoop,
    coefficients,
)
from mbcheck.reference.scene import Array
from mbcheck.reference.solve.schemes import DAMPING, SCHEMES, TABLEAUS, ScalarEquations, integrate
from mbcheck.reference.solve.single import solve

SCENE = get_scene("hula_hoop")


SPINNING = SCENE.state({"y": 0.01, "theta": 0.3, "theta_dot": 18.0})


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


def test_a_drive_is_a_function_of_time_unless_a_clock_is_asked_for() -> None:
    plain, clock = ScalarEquations(SCENE, HulaHoop()), ScalarEquations(SCENE, HulaHoop(), True)
    assert (plain.n, clock.n) == (2, 3)
    assert plain.drive(0.0, []) == pytest.approx(clock.drive(0.5, [0.0, 0.0, 1.0]))

"""The linearised flow: transition matrices and what they amplify."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from mbcheck.reference import get_scene
from mbcheck.reference.hula_hoop.equations import (
    UNFORCED,
    HulaHoop,
)
from mbcheck.reference.solve.batched import growths

SCENE = get_scene("hula_hoop")


REST = SCENE.state({})


SPINNING = SCENE.state({"y": 0.01, "theta": 0.3, "theta_dot": 18.0})


# Linearised flow ------------------------------------------------------------------------


def test_errors_of_a_damped_oscillator_do_not_grow() -> None:
    """Light mass on a long rod, no force: nothing grows but theta with its rate."""
    p = UNFORCED.replace(free_mass=1e-9, rod_length=1e3, damping_ratio=0.5)
    state = SCENE.state({"y": 0.1, "theta": 0.3, "theta_dot": 18.0})
    growth = growths(SCENE, p, state, np.linspace(0, 0.5, 9)[1:])[-1]
    assert 1 <= growth < 3


def test_growth_is_the_largest_stretching_so_far() -> None:
    """Of y'' = 9 y errors grow by e^3t where y and y' have the sizes 1 and 3; then they shrink."""

    def accelerations(u: Any, q: Any, v: Any, c: Any, xp: Any = np) -> list[Any]:
        return [9 * q[0], -q[1]]

    def settling(u: Any, q: Any, v: Any, c: Any, xp: Any = np) -> list[Any]:
        return [-9 * q[0] - 6 * v[0], -q[1] - 2 * v[1]]

    unstable = replace(SCENE, accelerations=accelerations, drive=None)
    times = np.array([0.5, 1.0, 2.0])
    start = np.array([1.0, 1.0, 3.0, 0.0])
    found = growths(unstable, HulaHoop(), start, times)
    np.testing.assert_allclose(found, np.exp(3 * times), rtol=2e-3)
    damped = replace(SCENE, accelerations=settling, drive=None)
    found = growths(damped, HulaHoop(), np.array([0.0, 0.0, 1.0, 1.0]), np.array([0.2, 5.0]))
    assert 1.01 < found[1] == found[0] < 1.3


def test_growth_that_overflows_is_infinite() -> None:
    """Exponential growth at rest: e^(3e4 0.1) is no number."""

    def accelerations(u: Any, q: Any, v: Any, c: Any, xp: Any = np) -> list[Any]:
        return [9e8 * q[0], 9e8 * q[1]]

    unstable = replace(SCENE, accelerations=accelerations, drive=None)
    assert growths(unstable, HulaHoop(), REST, np.array([0.1]))[-1] == np.inf

"""Rotations by harmonic balance against those of shooting, and against the equations."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mbcheck.reference import get_scene
from mbcheck.reference.hula_hoop.balance import Balance, Nodes
from mbcheck.reference.hula_hoop.equations import Coefficients, HulaHoop, coefficients
from mbcheck.reference.orbits import shoot
from mbcheck.reference.solve.rk8 import rk8_steps

SCENE = get_scene("hula_hoop")


def points(**values: Any) -> tuple[HulaHoop, Coefficients]:
    p = HulaHoop().replace(**{name: np.asarray(value, float) for name, value in values.items()})
    count = max(np.size(value) for value in values.values())
    c = coefficients(p)
    return p, Coefficients(*(np.array(np.broadcast_to(x, count), float) for x in c))


def balanced(c: Coefficients, nodes: Nodes, phi: Any) -> tuple[Any, Any]:
    which = np.arange(len(c.omega))
    balance = Balance(c, nodes)
    found, solved = balance.solve(which, np.repeat(phi[:, None], nodes.count, axis=1))
    return balance.states(which, found), solved


@pytest.mark.parametrize("half", [True, False])
def test_it_finds_what_shooting_finds(half: bool) -> None:
    p, c = points(force_frequency=[3.0, 9.0, 5.5], force_amplitude=[60.0, 40.0, 40.0])
    guess = SCENE.orbit.guesses(p)[0]
    states, solved = balanced(c, Nodes(32 if half else 64, half), guess[1])
    assert solved.all()
    shot = shoot(SCENE, p, states, steps=96)
    assert shot.closed.all()
    off = np.abs(shot.states - states) / shot.scale
    off[1] = np.minimum(off[1], np.abs(off[1] - 1))
    assert np.max(off) < 1e-8


def test_more_nodes_leave_less() -> None:
    """By how much the orbit fails to close, in a rough one: spectral convergence."""
    p, c = points(force_frequency=[1.6], force_amplitude=[60.0])
    left = []
    for count in (8, 16, 32):
        states, solved = balanced(c, Nodes(count, True), SCENE.orbit.guesses(p)[0][1])
        assert solved.all()
        end = rk8_steps(SCENE.right_hand_side(p), states, 0.0, SCENE.period(p), 400)
        left.append(np.max(np.abs(end - states - [[0], [2 * np.pi], [0], [0]])[:2]))
    assert left[1] < left[0] / 5
    assert left[2] < left[1] / 20


def test_where_nothing_turns_nothing_is_found() -> None:
    p, c = points(force_frequency=[3.0], force_amplitude=[0.3])
    _, solved = balanced(c, Nodes(16, True), SCENE.orbit.guesses(p)[0][1])
    assert not solved.any()

"""Where the rotation of speed_regulator begins, and what a run ends in."""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad, solve_ivp

from mbcheck.reference.errors import NoOrbitError
from mbcheck.reference.linear import linearise
from mbcheck.reference.solve.batched import growths
from mbcheck.reference.solve.single import solve
from mbcheck.reference.speed_regulator import COEXISTENCE, SCENE, theory
from mbcheck.reference.speed_regulator.equations import (
    SpeedRegulator,
    coefficients,
    inertia,
    position,
)
from mbcheck.reference.speed_regulator.motions import (
    found_equilibria,
    outcome,
)

Array = NDArray[np.float64]


DEFAULT = SpeedRegulator()


least_torque = functools.cache(theory.least_torque)


# --- Where the rotation begins ---------------------------------------------------------------


def comes_round(p: SpeedRegulator, saddle: float) -> bool:
    """Follow the unstable manifold by a multistep method, over a turn or until it turns back."""
    c = coefficients(p)
    mass, damping, stiffness = (m.item() for m in linearise(SCENE, p, np.array([saddle, 0.0])))
    rate = max(np.roots([mass, damping, stiffness]).real)
    events: list[Any] = [lambda t, x: x[1], lambda t, x: x[0] - saddle - 2 * np.pi]
    for event in events:
        event.terminal = True
    run = solve_ivp(
        lambda t, x: [x[1], SCENE.accelerations(0.0, x[:1], x[1:], c)[0]],
        (0, 1e3), [saddle + 1e-6, 1e-6 * rate], "LSODA", events=events, rtol=1e-10, atol=1e-13,
    )  # fmt: skip
    return bool(len(run.t_events[1]))


def test_the_homoclinic_torque_separates_what_an_independent_integration_does() -> None:
    found = least_torque(DEFAULT)
    assert found.kind == "homoclinic"
    assert found.error < 1e-6 * found.torque
    for share, expected in ((1 - 1e-6, False), (1 + 1e-6, True)):
        near = DEFAULT.replace(torque=share * found.torque)
        saddles = (found_equilibria(near)[name] for name in ("top", "bottom"))
        assert any(comes_round(near, saddle) for saddle in saddles) == expected
        assert theory.rotates(near) == expected


def test_the_homoclinic_torque_is_melnikovs_where_damping_is_weak() -> None:
    c = coefficients(DEFAULT)

    def loss(phi: float) -> float:
        at = position(phi, c, math)
        height = c.radius**2 - (at.y - c.rest) ** 2  # the barrier stands at y_0 +- r
        return float(at.y_phi**2 * math.sqrt(max(c.stiffness * height, 0) / inertia(at, c)))

    slope = quad(loss, -np.pi / 2, np.pi / 2, epsrel=1e-10)[0] / np.pi
    gaps = []
    for damping in (2.0, 4.0):
        found = least_torque(DEFAULT.replace(damping=damping))
        gaps.append(abs(found.torque / (damping * slope) - 1))
    assert gaps[0] < 1e-3
    assert math.log2(gaps[1] / gaps[0]) == pytest.approx(2, abs=0.2)


def test_strong_damping_makes_it_a_saddle_node_on_the_circle() -> None:
    p = DEFAULT.replace(damping=100.0)
    found = theory.least_torque(p)
    assert found.kind == "saddle-node on the circle"
    last = max(theory.saddle_node_torques(p).values())
    assert found.torque == pytest.approx(last, rel=1e-12)
    assert found.error <= 1e-5 * last
    assert not theory.rotates(p.replace(torque=0.999 * last))
    assert theory.rotates(p.replace(torque=1.001 * last))
    with pytest.raises(NoOrbitError, match="without damping"):
        theory.least_torque(DEFAULT.replace(damping=0.0))


@pytest.mark.parametrize(
    ("torque", "ends"),
    [
        (0.1, {"rest"}),
        (0.4, {"rest", "rotation"}),
        pytest.param(1.2, {"rotation"}, marks=pytest.mark.slow),
    ],
)
def test_regimes_are_what_runs_end_in(torque: float, ends: set[str]) -> None:
    p = COEXISTENCE.replace(torque=torque)
    assert theory.rotates(p) == ("rotation" in ends)
    seen = set()
    times = np.linspace(0, 60, 3001)
    for start in ([0.3, 0.0], [0.0, 1.0], [0.0, 9.0], [2.0, 5.0]):
        q, v = solve(SCENE, p, np.array(start), times, tolerances=(1e-7, 1e-5)).states
        seen.add(outcome(times, {"phi": q, "phi_dot": v}, p))
    assert seen == ends


# --- What a run ends in ----------------------------------------------------------------------


def run(p: SpeedRegulator, state: dict[str, float], horizon: float) -> tuple[Array, dict[str, Any]]:
    times = np.linspace(0, horizon, int(50 * horizon) + 1)
    states = solve(SCENE, p, SCENE.state(state), times).states
    return times, dict(zip(SCENE.state_names, states, strict=True))


def test_outcomes_are_told_apart_and_doubtful_ones_left_undecided() -> None:
    for name, expected in (("settles_to_rest", "rest"), ("settles_to_rotation", "rotation")):
        case = SCENE.case(name)
        times, values = run(case.parameters, dict(case.state), case.horizon)
        assert outcome(times, values, case.parameters) == expected
        early = {key: item[:150] for key, item in values.items()}
        assert outcome(times[:150], early, case.parameters) == "undecided"
        shifted = {"phi": values["phi"] - 40 * np.pi, "phi_dot": values["phi_dot"]}
        assert outcome(times, shifted, case.parameters) == expected
        broken = {"phi": values["phi"], "phi_dot": np.where(times > 29, np.nan, 1.0)}
        assert outcome(times, broken, case.parameters) == "undecided"
    times = np.linspace(0, 30, 301)
    for p in (DEFAULT, COEXISTENCE):  # an engine that reset itself and stays where it was born
        still = {"phi": np.zeros(301), "phi_dot": np.zeros(301)}
        assert outcome(times, still, p) == "undecided"
    top = np.full(301, found_equilibria(COEXISTENCE)["top"])
    assert outcome(times, {"phi": top, "phi_dot": 0 * top}, COEXISTENCE) == "undecided"


def test_a_rotation_that_slows_down_or_runs_away_is_none() -> None:
    slow = COEXISTENCE.replace(torque=0.1, flywheel_inertia=10.0)
    times, values = run(slow, {"phi_dot": 6.0}, 20.0)
    assert np.all(values["phi_dot"] > 0)
    assert outcome(times, values, slow) == "undecided"
    free = COEXISTENCE.replace(damping=0.0)
    times, values = run(free, {"phi_dot": 6.0}, 10.0)
    assert outcome(times, values, free) == "undecided"


# --- Cases -----------------------------------------------------------------------------------


@pytest.mark.parametrize("case", SCENE.cases, ids=lambda case: case.name)
def test_cases_can_be_compared(case: Any) -> None:
    state = SCENE.state(case.state)
    times = np.linspace(0, case.horizon, 9)[1:]
    assert growths(SCENE, case.parameters, state, times)[-1] < 100
    if "energy" in case.kinds:
        c = coefficients(case.parameters)
        assert SCENE.invariants is not None
        values = solve(SCENE, case.parameters, state, times).states
        kept = SCENE.invariants(case.parameters)["energy"](values[:1], values[1:], c)
        np.testing.assert_allclose(kept, kept[0], rtol=1e-9)
    if case.name.startswith("rest_"):
        assert np.max(np.abs(SCENE.right_hand_side(case.parameters)(0.0, state))) < 1e-14

"""speed_regulator: maps against the theory point by point, single runs, and broken engines."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.faults.variants import Misread
from mbcheck.comparisons.queries.simulate import simulate
from mbcheck.comparisons.scenes import quantity as motion
from mbcheck.comparisons.scenes.quantity import NO_VALUE, Points
from mbcheck.comparisons.scenes.speed_regulator.limit_cycles import (
    REGIMES,
    rotations,
    theory_regimes,
)
from mbcheck.comparisons.scenes.speed_regulator.maps import QUANTITIES
from mbcheck.comparisons.scenes.speed_regulator.runs import passings, settled, simulated_speed
from mbcheck.reference import get_scene
from mbcheck.reference.bounds.orbits import orbit_bounds
from mbcheck.reference.errors import NoOrbitError, ParameterError
from mbcheck.reference.orbits import find_orbit
from mbcheck.reference.speed_regulator import theory
from mbcheck.reference.speed_regulator.equations import SpeedRegulator, coefficients
from mbcheck.reference.speed_regulator.motions import found_equilibria, mean_speed, static_stiffness

SCENE = get_scene("speed_regulator")
HOMOCLINIC = 0.0526104
"""Least torque of a rotation with the defaults [N m]."""
SADDLE_NODE = 1.07576
"""Torque at which the last state of rest vanishes."""

Array = NDArray[np.float64]


def points(
    engine: str = "reference",
    model: str = "theory",
    step: float | None = None,
    **values: Any,
) -> Points:
    """Return points off any grid: the defaults with these values, arrays (k,)."""
    arrays = {
        name: np.array(value, dtype=float)
        for name, value in zip(values, np.broadcast_arrays(*values.values()), strict=True)
    }
    count = len(next(iter(arrays.values())))
    places = np.stack([np.arange(count), np.zeros(count, dtype=int)], axis=1)
    p = SpeedRegulator().replace(**arrays)
    return Points(SCENE, p, places, arrays, engine, model, step=step)


def regimes(where: Points) -> list[str]:
    """Return the names of the regimes."""
    found = QUANTITIES["regime"].evaluate(where).values["regime"]
    return [REGIMES[int(i)] if i != NO_VALUE else "failed" for i in found]


@pytest.mark.parametrize("name", QUANTITIES)
@pytest.mark.parametrize("model", ["theory", "direct"])
def test_gravity_is_refused(name: str, model: str) -> None:
    with pytest.raises(ParameterError, match="no gravity in maps"):
        QUANTITIES[name].evaluate(points(model=model, torque=[0.3], gravity_y=[-9.0]))


def test_the_printed_formula_refuses_gravity() -> None:
    with pytest.raises(ParameterError, match="no gravity in the paper"):
        theory.printed_mean_speed(SpeedRegulator(gravity_x=1.0))


# --- Theory ----------------------------------------------------------------------------------

CORNERS: dict[str, dict[str, Any]] = {
    "ordinary": {"damping": [0.5, 2.0, 8.0], "torque": [0.03, 0.32, 1.2]},
    "strong dampers": {"damping": [30.0, 100.0, 100.0], "torque": [0.9, 1.07, 1.08]},
    "springs": {"stiffness": [0.0, 2.0, 200.0, 200.0], "torque": [0.05, 0.05, 0.05, 0.5]},
    "no torque, no damper": {"torque": [0.0, -0.5, -2.0, 0.3], "damping": [2.0, 2.0, 2.0, 0.0]},
    "lengths": {"crank_radius": [0.05, 0.6, 1.1], "torque": [0.32, 0.32, 3.0]},
    "spring off its place": {"spring_rest": [-1.5, -1.0, 0.0], "torque": [0.2, 0.2, 0.2]},
    "near the homoclinic torque": {"torque": HOMOCLINIC * np.array([1 - 1e-5, 1 + 1e-5])},
    "near the saddle-node": {"torque": SADDLE_NODE * np.array([1 - 1e-5, 1 + 1e-5])},
}


@pytest.mark.parametrize("name", CORNERS)
def test_regimes_are_those_of_the_theory_point_by_point(name: str) -> None:
    where = points(**CORNERS[name])
    for place, p in zip(theory_regimes(where), map(where.one, range(len(where))), strict=True):
        c = coefficients(p)
        rests = any(static_stiffness(phi, c) > 0 for phi in found_equilibria(p).values())
        regime = REGIMES[int(place)]
        assert (regime in ("rest", "coexistence")) == rests
        assert (regime in ("rotation", "coexistence")) == theory.rotates(p)


QUICK = ("ordinary", "no torque, no damper", "lengths")


@pytest.mark.slow
def test_a_mean_speed_near_the_homoclinic_torque_has_a_bound() -> None:
    p = SpeedRegulator(torque=0.0527)
    cycles, orbit = rotations(points(torque=[p.torque])), find_orbit(SCENE, p)
    away = 2 * np.pi / orbit.period**2 * orbit_bounds(SCENE, p, orbit).period
    assert abs(cycles.mean_speed[0] - 2 * np.pi / orbit.period) < cycles.bound[0] + away < 1e-8


@pytest.mark.parametrize(
    "name",
    [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in CORNERS],
)
def test_mean_speeds_are_those_of_the_theory(name: str) -> None:
    where = points(**CORNERS[name])
    found = rotations(where)
    values = QUANTITIES["mean_speed"].evaluate(where).values
    np.testing.assert_array_equal(values["mean_speed"], found.mean_speed)
    for i in range(len(where)):
        p = where.one(i)
        try:
            exact = theory.rotation(p)
        except NoOrbitError:
            assert all(math.isnan(value[i]) for value in (*found, *values.values()))
            continue
        assert found.start_speed[i] == pytest.approx(exact.start_speed, rel=1e-8)
        assert found.mean_speed[i] == pytest.approx(exact.mean_speed, rel=1e-8)
        assert found.multiplier[i] == pytest.approx(exact.multiplier, rel=1e-7)
        error = float(mean_speed(p)) / exact.mean_speed - 1
        assert values["error_exact"][i] == pytest.approx(error, abs=1e-8)
        error = float(theory.printed_mean_speed(p)) / exact.mean_speed - 1
        assert values["error_as_printed"][i] == pytest.approx(error, abs=1e-8)


def test_what_is_near_a_boundary_is_not_robust() -> None:
    torques = np.array([0.5, 1 - 5e-4, 1 + 5e-4, 2.0]) * HOMOCLINIC
    torques = np.append(torques, np.array([1 - 5e-4, 1 + 5e-4, 1.1]) * SADDLE_NODE)
    found = QUANTITIES["regime"].evaluate(points(torque=torques)).values
    assert found["robust"].tolist() == [1, 0, 0, 1, 0, 0, 1]


def test_a_map_does_not_depend_on_its_blocks() -> None:
    torques = np.array([0.02, 0.32, 1.4])
    whole = rotations(points(torque=torques)).mean_speed
    parts = [rotations(points(torque=[torque])).mean_speed[0] for torque in torques]
    np.testing.assert_allclose(whole, parts, rtol=1e-9)
    again = rotations(points(torque=torques)).mean_speed
    np.testing.assert_array_equal(whole, again)


# --- Runs ------------------------------------------------------------------------------------


def test_runs_of_the_reference_end_as_the_theory_says() -> None:
    values: dict[str, Any] = {"damping": [4.0, 8.0, 4.0, 2.0], "torque": [0.08, 0.32, 1.2, -0.5]}
    expected = regimes(points(**values))
    assert set(expected) == {"rest", "coexistence", "rotation"}
    where = points(model="direct", **values)
    found = QUANTITIES["regime"].evaluate(where)
    assert [REGIMES[int(i)] for i in found.values["regime"]] == expected
    assert np.all(found.values["robust"] == 1)
    assert not found.problems
    speeds = QUANTITIES["mean_speed"].evaluate(where).values["mean_speed"]
    np.testing.assert_allclose(speeds, rotations(where).mean_speed, rtol=1e-6)


@pytest.mark.parametrize(
    ("engine", "model", "within"),
    [
        ("mujoco", "connect", 3e-3),
        pytest.param("mujoco", "connect_hard", 1e-5, marks=pytest.mark.slow),
        ("exudyn", "redundant", 3e-4),
        pytest.param("exudyn", "one_dof", 1e-7, marks=pytest.mark.slow),
    ],
)
def test_engines_map(engine: str, model: str, within: float) -> None:
    pytest.importorskip(engine)
    values: dict[str, Any] = {"damping": [8.0, 8.0], "torque": [0.15, 1.2]}
    found = QUANTITIES["regime"].evaluate(points(engine, model, **values))
    assert [REGIMES[int(i)] for i in found.values["regime"]] == ["rest", "rotation"]
    speed = QUANTITIES["mean_speed"].evaluate(points(engine, model, damping=[4.0], torque=[0.32]))
    truth = theory.rotation(SpeedRegulator(damping=4.0)).mean_speed
    assert speed.values["mean_speed"][0] == pytest.approx(truth, rel=within)
    assert not found.problems
    assert not speed.problems


@pytest.mark.slow
def test_the_own_rotation_of_a_soft_closure_is_where_a_long_run_ends() -> None:
    pytest.importorskip("mujoco")
    own = simulated_speed(points("mujoco", "connect", damping=[4.0])).values["mean_speed"][0]
    times = np.linspace(0, 160, 2561)
    start = {"phi_dot": float(rotations(points(damping=[4.0])).start_speed[0])}
    run = simulate(
        "speed_regulator", engine="mujoco", parameters={"damping": 4.0}, state=start, times=times
    )
    phi = run.observables["phi"]
    marks = 2 * np.pi * np.array([phi[-1] // (2 * np.pi) - 20, phi[-1] // (2 * np.pi)])
    passed = np.interp(marks, phi, times)
    assert own == pytest.approx(40 * np.pi / np.ptp(passed), rel=5e-5)
    exact = theory.rotation(SpeedRegulator(damping=4.0)).mean_speed
    assert abs(own / exact - 1) > 1e-3  # it is another mechanism


@pytest.mark.parametrize(
    ("wrong", "factor", "torques", "expected"),
    [
        pytest.param("torque", 0.5, [0.08], ["rest"], marks=pytest.mark.slow),
        pytest.param("damping", 2.0, [0.08], ["rest"], marks=pytest.mark.slow),
        ("stiffness", 2.0, [1.2], ["coexistence"]),
    ],
)
def test_broken_engines_show(
    monkeypatch: pytest.MonkeyPatch,
    wrong: str,
    factor: float,
    torques: list[float],
    expected: list[str],
) -> None:
    pytest.importorskip("exudyn")
    right = regimes(points(torque=torques))
    broken = Misread(
        get_engine("exudyn"), lambda p: p.replace(**{wrong: factor * getattr(p, wrong)})
    )
    monkeypatch.setattr(motion, "choose_engine", lambda *_: (broken, "redundant"))
    assert right != expected
    assert regimes(points("exudyn", "redundant", torque=torques)) == expected


def test_a_failed_engine_has_no_value() -> None:
    pytest.importorskip("mujoco")
    where = points("mujoco", "connect", step=0.05, torque=[0.06, 0.32])
    for name, quantity in QUANTITIES.items():
        found = quantity.evaluate(where)
        first = found.values[next(iter(quantity.variables))]
        assert np.all(first == NO_VALUE) if name == "regime" else np.all(np.isnan(first))
        assert set(found.problems) == {0, 1}
        assert "softens the closure" in found.problems[0]


def test_passings_are_interpolated_to_many_digits() -> None:
    spacing = 0.05
    times = spacing * np.arange(200)
    phi, rate = 2 * times + 0.3 * np.sin(times), 2 + 0.3 * np.cos(times)
    seen, speeds = passings(phi, rate, spacing, 2)
    for mark, (time, speed) in enumerate(zip(seen, speeds, strict=True)):
        assert 2 * time + 0.3 * math.sin(time) == pytest.approx(2 * np.pi * mark, abs=1e-10)
        assert speed == pytest.approx(2 + 0.3 * math.cos(time), abs=1e-8)
    rate[70:] = -1.0  # it turned back on its second turn
    seen, speeds = passings(phi, rate, spacing, 2)
    assert np.isfinite(seen).tolist() == [True, True, False]
    rate[:] = np.nan
    assert np.isnan(passings(phi, rate, spacing, 2)[0][1:]).all()


def test_settled_tells_what_is_still_to_come() -> None:
    turns = np.arange(6)
    periods = {
        "done": 1 + 0 * turns,
        "nearly": 1 + 0.01 * 0.5**turns,
        "far": 1 + 0.3 * 0.95**turns,
        "running away": 1 + 0.2 * turns,
    }
    times = np.array([np.concatenate([[0], np.cumsum(item)]) for item in periods.values()])
    assert settled(times).tolist() == [True, True, False, False]

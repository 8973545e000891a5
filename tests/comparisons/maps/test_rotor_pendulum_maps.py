"""Maps of rotor_pendulum: against theory, single orbits and runs, and with broken engines."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.engines.adapter import Adapter
from mbcheck.comparisons.queries.simulate import simulate
from mbcheck.comparisons.scenes.quantity import NO_VALUE, Points, QuantityValues
from mbcheck.comparisons.scenes.rotor_pendulum import phase
from mbcheck.comparisons.scenes.rotor_pendulum.maps import AXES, QUANTITIES
from mbcheck.comparisons.scenes.rotor_pendulum.phase import (
    NONE,
    PHASES,
    SYNPHASE,
    UNSTABLE,
    orbits_of,
)
from mbcheck.comparisons.scenes.rotor_pendulum.synchronism import OUTCOMES
from mbcheck.reference.errors import ParameterError
from mbcheck.reference.orbits import shoot
from mbcheck.reference.rotor_pendulum import CASE_1, CASE_2, CASE_3, SCENE, theory
from mbcheck.reference.rotor_pendulum.equations import RotorPendulum, operating_speed
from mbcheck.reference.rotor_pendulum.phase import balanced_phase, orbit_guesses, wrapped

CASES = (CASE_1, CASE_2, CASE_3)


def points(several: Any, engine: str = "reference", model: Any = "exact", **how: Any) -> Points:
    """Return points of these parameters, which are no neighbours."""
    numbers = {
        name: np.array([getattr(p, name) for p in several])
        for name in RotorPendulum.names()
        if name != "motor_placement"
    }
    places = 100 * np.arange(len(several))[:, None] * np.array([1, 0])
    return Points(SCENE, several[0].replace(**numbers), places, {}, engine, model, **how)


def at(p: RotorPendulum, **ratios: float) -> RotorPendulum:
    """Return parameters with these frequency ratios."""
    for name, value in ratios.items():
        p = AXES[name].apply(p, np.array(value))
    return p


def grid(count: int, beta: float = np.pi / 6, model: str = "theory", **how: Any) -> Points:
    """Return points over the frequency ratios of the paper's figures."""
    values = np.linspace(0.1, 7, count)
    n_x, n_phi = (axis.ravel() for axis in np.meshgrid(values, values))
    p = CASE_1.replace(installation_angle=beta, **how)
    for name, value in (("n_x", n_x), ("n_phi", n_phi)):
        p = AXES[name].apply(p, value)
    row, column = np.indices((count, count)).reshape(2, -1)
    places = np.stack([column, row], axis=1)
    return Points(SCENE, p, places, {"n_x": n_x, "n_phi": n_phi}, "reference", model)


def evaluate(quantity: str, where: Points) -> QuantityValues:
    found = QUANTITIES[quantity].evaluate(where)
    assert set(found.values) == set(QUANTITIES[quantity].variables)
    for name, value in found.values.items():
        assert value.shape == (len(where),)
        whole = name in ("class", "robust")
        assert value.dtype.kind == ("i" if whole else "f")
    return found


def test_axes_are_the_inverse_of_the_ratios() -> None:
    where = grid(5, rotor_mass=3.0, motor_slope=0.5)
    n = theory.ratios(where.parameters)
    np.testing.assert_allclose(n.n_x, where.values["n_x"], rtol=1e-14)
    np.testing.assert_allclose(n.n_phi, where.values["n_phi"], rtol=1e-14)


def test_coupling_is_the_theorys() -> None:
    where = grid(9, model="corrected")
    found = evaluate("coupling", where)
    assert next(iter(found.values)) == "mu_1"
    ratios = theory.Ratios(where.values["n_x"], where.values["n_phi"])
    for wrong, model in ((False, "corrected"), (True, "paper")):
        mu = theory.coupling_coefficients(ratios, wrong)
        values = evaluate("coupling", replace(where, model=model)).values
        for name in mu._fields:
            np.testing.assert_allclose(values[name], getattr(mu, name), rtol=1e-9)
    loose = points([CASE_1.replace(platform_stiffness=0.0)], model="corrected")
    assert np.isnan(evaluate("coupling", loose).values["mu_1"][0])


def test_theories_satisfy_what_they_claim() -> None:
    where = grid(12, beta=np.pi / 3)
    n = theory.ratios(where.parameters)
    found = evaluate("phase", where).values
    alpha = found["phase_difference"]
    assert np.max(abs(theory.balance(n, alpha)) / abs(theory.stability(n, alpha))) < 1e-9
    assert np.all(theory.stability(n, alpha) > 0)
    np.testing.assert_array_equal(found["class"] == SYNPHASE, abs(alpha) < np.pi / 2)
    printed = evaluate("phase", replace(where, model="paper")).values
    assert np.all((printed["phase_difference"] > 0) & (printed["phase_difference"] < np.pi))
    assert np.mean(printed["class"] == UNSTABLE) > 0.5
    damped = evaluate("phase", replace(where, model="damped")).values
    np.testing.assert_allclose(damped["phase_difference"], balanced_phase(where.parameters))
    assert np.any(damped["class"] == NONE)
    assert np.all(evaluate("phase", replace(where, model="damped")).values["robust"] <= 1)


def test_a_theory_near_the_change_of_class_is_not_robust() -> None:
    n_phi = 1 / np.cos(np.pi / 6)  # where the phase passes pi/2
    near, far = (at(CASE_2, n_x=3.0, n_phi=value) for value in (n_phi * (1 + 1e-4), 2.0))
    assert evaluate("phase", points([near, far], model="theory")).values["robust"].tolist() == [
        0,
        1,
    ]


SEVERAL = (
    *CASES,
    CASE_2.replace(rod_damping=0.0),
    CASE_3.replace(rod_damping=0.0),
    CASE_2.replace(installation_angle=0.0),
    CASE_1.replace(motor_slope=6.0),
)


def test_orbits_are_those_of_shooting() -> None:
    found = evaluate("phase", points(SEVERAL)).values
    kinds = [PHASES[kind] for kind in found["class"]]
    assert kinds[:5] == ["antiphase", "synphase", "none", "synphase", "antiphase"]
    assert np.all(found["robust"] == 1)
    for i in (0, 3, 6):
        p = SEVERAL[i]
        one = shoot(SCENE, p, orbit_guesses(p)[0][:, None], steps=32)
        assert np.all(one.closed)
        assert found["mean_speed"][i] == pytest.approx(2 * np.pi / one.periods[0], rel=1e-9)
        moduli = np.sort(np.abs(one.multipliers.ravel()))
        assert found["multiplier"][i] == pytest.approx(moduli[-2], abs=1e-5)
    missing = [i for i, kind in enumerate(kinds) if kind == "none"]
    assert np.all(np.isnan(found["phase_difference"][missing]))


@pytest.mark.slow
def test_orbits_close_and_balance_their_power() -> None:
    """An identity that no shooting knows: what motors and dampers do adds up to nothing."""
    where = grid(4, beta=0.0, model="exact")
    maps, orbits = orbits_of(where)
    flow, steps = maps.flow, maps.steps
    rows = np.flatnonzero(orbits.closed)
    assert 7 < len(rows) < 16
    for i in rows:
        some = orbits.states[:, [i]], orbits.periods[[i]]
        path = flow(np.array([i]), some[0], 0.0, some[1] / 64, 64, max(1, steps[i] // 64))
        c = SCENE.coefficients(where.one(int(i)))
        powers = SCENE.powers(0.0, path[:4, 0], path[4:, 0], c)
        total = sum(float(np.mean(value)) for value in powers.values())
        assert abs(total) < 1e-6 * abs(float(np.mean(powers["motor_1"])))
        assert 2 * np.pi / orbits.periods[i] < operating_speed(CASE_1) + 0.5


@pytest.mark.slow
def test_the_reduced_equations_have_their_own_orbit() -> None:
    exact, reduced = (
        evaluate("phase", points([CASE_2], model=model)).values for model in ("exact", "reduced")
    )
    one = shoot(SCENE.variants["reduced"], CASE_2, orbit_guesses(CASE_2)[0][:, None], steps=32)
    assert reduced["mean_speed"][0] == pytest.approx(2 * np.pi / one.periods[0], rel=1e-9)
    assert 1e-4 < abs(reduced["phase_difference"][0] - exact["phase_difference"][0]) < 1e-3


def stiffnesses(p: RotorPendulum) -> dict[str, float]:
    return {
        "platform_stiffness": float(p.platform_stiffness),
        "rod_stiffness": float(p.rod_stiffness),
    }


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["mujoco", "exudyn"])
def test_engines_have_orbits_of_their_own(engine: str) -> None:
    found = evaluate("phase", points([CASE_2, CASE_3], engine, None))
    assert not found.problems
    truth = evaluate("phase", points([CASE_2, CASE_3])).values
    np.testing.assert_array_equal(found.values["class"], truth["class"])
    gap = abs(found.values["phase_difference"][0] - truth["phase_difference"][0])
    assert 0 < gap < 1e-5
    coarse = evaluate("phase", points([CASE_2], engine, None, step=1.3e-3))
    assert abs(coarse.values["phase_difference"][0] - truth["phase_difference"][0]) > gap


def test_an_engine_with_another_damper_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    truth = evaluate("phase", points([CASE_2])).values["phase_difference"][0]
    light(monkeypatch)
    found = evaluate("phase", points([CASE_2], "mujoco", None))
    assert wrapped(found.values["phase_difference"][0] - truth) < -0.4


def light(monkeypatch: pytest.MonkeyPatch) -> None:
    """Take most of the rod's damper from MuJoCo."""
    plain = Adapter.bind

    def changed(self: Any, case: Any, model: str) -> Any:
        return plain(self, without_damper(case), model)

    monkeypatch.setattr(Adapter, "bind", changed)


def without_damper(case: Any) -> Any:
    return replace(case, parameters=case.parameters.replace(rod_damping=3.0))


def test_a_failing_engine_leaves_no_value(monkeypatch: pytest.MonkeyPatch) -> None:
    """A step far too long for the platform's spring: MuJoCo's run diverges."""
    stiff = at(CASE_2, n_x=0.01)
    where = points([CASE_2, stiff], "mujoco", None, step=1.3e-3)
    unstable = replace(where, method="RK4")
    monkeypatch.setattr(phase, "step_counts", lambda where, *_: np.full(len(where), phase.SAMPLES))
    found = evaluate("phase", unstable)
    assert list(found.problems) == [1]
    assert found.values["class"][1] == NO_VALUE
    assert found.values["robust"].tolist() == [1, 0]
    assert np.isnan(found.values["phase_difference"][1])
    assert found.values["class"][0] == SYNPHASE


STRONG = at(CASE_2, n_x=3.0, n_phi=4.0)
RESONANT = at(CASE_2, n_x=3.0, n_phi=1.1)
SLOW = at(CASE_1, n_x=0.1)
"""Settles within 5 s, never, and too slowly to be told."""


@pytest.fixture(scope="module")
def ends() -> QuantityValues:
    return evaluate("sync", points([STRONG, RESONANT, SLOW]))


@pytest.mark.slow
def test_sync_tells_the_three_ends_apart(ends: QuantityValues) -> None:
    found = ends.values
    kinds = [OUTCOMES[kind] for kind in found["class"]]
    assert kinds == ["synchronised", "not synchronised", "undecided"]
    assert found["robust"].tolist() == [1, 1, 0]
    orbit = evaluate("phase", points([STRONG])).values
    assert found["phase_difference"][0] == pytest.approx(orbit["phase_difference"][0], abs=0.02)
    assert found["mean_speed"][0] == pytest.approx(orbit["mean_speed"][0], rel=1e-3)
    assert np.all(np.isnan(found["phase_difference"][1:]))
    assert found["duration"][2] < 2 < found["duration"][0] < 17


@pytest.mark.slow
def test_sync_ends_as_the_single_run_does(ends: QuantityValues) -> None:
    duration = float(ends.values["duration"][0])
    spacing = 2 * np.pi / float(operating_speed(STRONG)) / 10
    times = [spacing * i for i in range(round(duration / spacing) + 1)]
    run = simulate("rotor_pendulum", engine="mujoco", parameters=stiffnesses(STRONG), times=times)
    assert SCENE.outcome is not None
    assert SCENE.outcome(times, run.observables, STRONG) == "synchronised"


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["mujoco", "exudyn"])
def test_sync_by_engines(engine: str, ends: QuantityValues) -> None:
    found = evaluate("sync", points([STRONG, RESONANT, SLOW], engine, None)).values
    np.testing.assert_array_equal(found["class"], ends.values["class"])
    assert abs(found["phase_difference"][0] - ends.values["phase_difference"][0]) < 1e-3


@pytest.mark.parametrize("model", phase.THEORIES)
def test_theories_refuse_gravity(model: str) -> None:
    with pytest.raises(ParameterError, match="no gravity"):
        phase.phase(points([CASE_1.replace(gravity_x=1.0)], model=model))

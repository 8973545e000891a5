"""*stability* at a boundary: honest engines, faults of 0.1 %, wrong orders, what is skipped."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.checks.boundary import true_boundary
from mbcheck.comparisons.checks.suite import Check, plan, run_check
from mbcheck.comparisons.checks.table import KINDS
from mbcheck.comparisons.checks.verdict import Result
from mbcheck.comparisons.engines.adapter import Adapter
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.faults.variants import Misread
from mbcheck.reference import get_scene
from mbcheck.reference.parameters import BoundarySearch
from mbcheck.reference.scene import Case
from mbcheck.reference.speed_regulator.theory import least_torque
from mbcheck.tests.support.engines.solved import Single, Solved

HOOP = get_scene("hula_hoop").case("loss_of_symmetry_5hz")
ROTORS = get_scene("rotor_pendulum").case("fold_of_synchronism")
REGULATOR = get_scene("speed_regulator").case("least_torque")


def check_of(case: Case, engine: Any) -> Check:
    """Return the check of an engine's first model and method."""
    model, method = engine.models(case.scene)[0], engine.methods[0]
    names = KINDS["stability"].quantities(Setup(engine, case, model, method))
    return Check("stability", case, engine.name, model, method, names)


def found(case: Case, engine: Any) -> dict[str, Result]:
    """Return the results of an engine by quantity, with the narrowest tolerances."""
    return {item.quantity: item for item in run_check(check_of(case, engine), "strict", engine)}


def scheme(name: str, order: int, **more: Any) -> Adapter:
    """Return an engine that is a published scheme on the scene's own equations."""
    return Adapter(Solved(mbcheck.Method(name, order), name, **more))


def default_check(case: Case, engine: str) -> Check:
    """Return the one check of a boundary in the default set."""
    (check,) = plan([case.scene], [engine], ["stability"], ids=[f"*/{case.name}/*"])
    return check


@pytest.mark.parametrize(("engine", "method"), [("mujoco", "RK4"), ("exudyn", "RK67")])
@pytest.mark.parametrize("case", [HOOP, ROTORS], ids=lambda case: case.scene)
def test_honest_engines_pass_by_their_best_method(case: Case, engine: str, method: str) -> None:
    pytest.importorskip(engine, exc_type=ImportError)
    check = default_check(case, engine)
    assert check.subject.method == method
    assert case.boundary is not None
    unit = case.parameters.__dataclass_fields__[case.boundary.parameter].metadata["unit"]
    results = run_check(check, "strict")
    assert [item.quantity for item in results] == ["boundary", "extrapolated"]
    for item in results:
        assert (item.verdict, item.unit) == ("pass", unit)
        assert item.error is not None
        assert item.reference is not None
        assert 0 < item.error < 1e-5 * item.reference
    assert f" {unit} with" in results[0].reason


@pytest.mark.parametrize(
    ("name", "order"),
    [
        pytest.param("semi_implicit_euler", 1, marks=pytest.mark.slow),
        ("ExplicitMidpoint", 2),
        ("RK33", 3),
        ("RK44", 4),
    ],
)
def test_published_schemes_pass(name: str, order: int) -> None:
    results = found(HOOP, scheme(name, order))
    assert {item.verdict for item in results.values()} == {"pass"}


def test_an_engine_of_others_passes() -> None:
    pytest.importorskip("mujoco", exc_type=ImportError)
    from mbcheck.examples.mujoco_engine import MujocoPlugin

    results = found(HOOP, Adapter(MujocoPlugin()))
    assert {item.verdict for item in results.values()} == {"pass"}


@pytest.mark.parametrize(
    ("case", "name"),
    [
        (HOOP, "stiffness"),
        pytest.param(HOOP, "free_mass", marks=pytest.mark.slow),
        pytest.param(ROTORS, "rod_mass", marks=pytest.mark.slow),
    ],
    ids=lambda value: value if isinstance(value, str) else value.scene,
)
def test_a_tenth_of_a_per_cent_is_a_shift_of_its_size(case: Case, name: str) -> None:
    """A wrong mass or spring shifts the engine's boundary by what it shifts the reference's."""
    pytest.importorskip("mujoco", exc_type=ImportError)
    check, value = default_check(case, "mujoco"), 1.001 * getattr(case.parameters, name)
    wrong = Misread(get_engine("mujoco"), {name: value})
    results = {item.quantity: item for item in run_check(check, "loose", wrong)}
    assert {item.verdict for item in results.values()} == {"deviation"}
    assert case.boundary is not None
    places = []
    for p in (case.parameters, case.parameters.replace(**{name: value})):
        along = true_boundary(case.scene, p, case.boundary)
        places.append(along.value(along.solution[1].z[-1]))
    limit = results["extrapolated"]
    assert limit.value is not None
    assert limit.reference == pytest.approx(places[0], rel=1e-9)
    assert limit.value - places[0] == pytest.approx(places[1] - places[0], rel=1e-3)


@pytest.mark.parametrize(
    ("name", "order"), [("RK44", 4), pytest.param("ExplicitMidpoint", 2, marks=pytest.mark.slow)]
)
def test_least_torques_are_those_of_the_homoclinic_orbit(name: str, order: int) -> None:
    results = found(REGULATOR, scheme(name, order))
    assert {item.verdict for item in results.values()} == {"pass"}
    assert "steps along it; halving divides the shift by" in results["boundary"].reason
    limit = least_torque(REGULATOR.parameters)
    assert results["extrapolated"].reference == pytest.approx(limit.torque, rel=4e-7)
    assert results["extrapolated"].value == pytest.approx(limit.torque, rel=1e-6)


def test_a_stiffer_spring_shifts_the_least_torque_by_as_much() -> None:
    """Of weak damping it goes with the root of the stiffness."""
    wrong = scheme("RK44", 4, change=lambda p: p.replace(stiffness=1.001 * p.stiffness))
    results = found(REGULATOR, wrong)
    assert {item.verdict for item in results.values()} == {"deviation"}
    limit = results["extrapolated"]
    assert limit.value is not None
    assert limit.reference is not None
    assert limit.value / limit.reference - 1 == pytest.approx(5e-4, rel=0.01)


@pytest.mark.slow
def test_a_closed_loop_has_the_least_torque() -> None:
    pytest.importorskip("exudyn", exc_type=ImportError)
    ids = ["*/least_torque/*/GeneralizedAlpha/*"]
    (check,) = plan([REGULATOR.scene], ["exudyn"], ["stability"], ids=ids, full=True)
    for item in run_check(check, "strict"):
        assert item.verdict == "pass"
        assert item.error is not None
        assert 0 < item.error < 1e-5


def test_another_order_than_declared_deviates() -> None:
    wrong = Adapter(Solved(mbcheck.Method("RK44", 4), "ExplicitMidpoint"))
    results = found(HOOP, wrong)
    assert results["boundary"].verdict == "deviation"
    assert results["extrapolated"].verdict == "skipped"


def test_an_engine_whose_boundary_is_far_deviates() -> None:
    """Twice the spring: no such bifurcation is near, and halved steps change nothing."""
    far = scheme("RK44", 4, change=lambda p: p.replace(stiffness=2 * p.stiffness))
    results = found(HOOP, far)
    assert results["boundary"].verdict == "deviation"


def test_what_cannot_be_judged_is_skipped() -> None:
    single = Adapter(Single(mbcheck.Method("RK44", 4, precision="float32"), "RK44"))
    elsewhere = replace(HOOP, boundary=BoundarySearch("fold", "force_amplitude"))
    for case, engine, words in (
        (HOOP, single, "32 bits"),
        (elsewhere, scheme("RK44", 4), "no fold near force_amplitude = 95"),
    ):
        for item in found(case, engine).values():
            assert item.verdict == "skipped"
            assert words in item.reason


class Late(Solved):
    """An engine that fails after some runs."""

    name = "late"

    def simulate(self, system: Any, method: Any, step: float, times: Any) -> mbcheck.Motion:
        self.runs = getattr(self, "runs", 0) + 1
        if self.runs > 40:
            raise RuntimeError("it broke")
        return super().simulate(system, method, step, times)


def test_an_engine_that_fails_on_the_way_is_told_how() -> None:
    engine = Adapter(Late(mbcheck.Method("RK44", 4), "RK44"))
    for item in found(HOOP, engine).values():
        assert item.verdict == "error"
        assert "it broke" in item.reason


class Rounding(Solved):
    """An engine that tells 8 digits."""

    name = "rounding"

    def simulate(self, system: Any, method: Any, step: float, times: Any) -> mbcheck.Motion:
        motion = super().simulate(system, method, step, times)
        q, v = (
            np.vectorize(lambda x: float(f"{x:.8g}"))(part)
            for part in (motion.positions, motion.velocities)
        )
        return replace(motion, positions=q, velocities=v)


def test_a_scatter_of_runs_is_not_called_a_shift() -> None:
    engine = Adapter(Rounding(mbcheck.Method("RK44", 4), "RK44"))
    for item in found(HOOP, engine).values():
        assert item.verdict == "skipped"


def test_models_with_other_equations_are_left_out() -> None:
    """Without its own inertia MuJoCo's free mass has the least that MuJoCo takes."""
    pytest.importorskip("mujoco", exc_type=ImportError)
    case = replace(HOOP, parameters=HOOP.parameters.replace(inertia_ratio=0.0))
    engine = get_engine("mujoco")
    setup = Setup(engine, case, engine.models(case.scene)[0], engine.methods[0])
    assert KINDS["stability"].quantities(setup) == ()


def test_points_do_not_depend_on_where_they_are_sought_from() -> None:
    places = []
    for angle in (1.0, 1.1):
        along = true_boundary(
            ROTORS.scene, ROTORS.parameters.replace(installation_angle=angle), ROTORS.boundary
        )
        _, point = along.solution
        places.append((along.value(point.z[-1]), along.unit * point.bound[1]))
    (one, bound), (other, its) = places
    assert bound + its < 1e-10
    assert np.abs(one - other) < bound + its

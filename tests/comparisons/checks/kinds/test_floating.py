"""A platform afloat: right engines pass, faults in what couples it to hinges are named."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.checks.kinds.energy import sensor_gaps
from mbcheck.comparisons.checks.suite import plan_cases, run_check
from mbcheck.comparisons.engines.adapter import adapt
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.faults.catalogue import scaled
from mbcheck.comparisons.faults.exudyn import Rebuilt
from mbcheck.models import exudyn_body
from mbcheck.models.floating_platform import exudyn_model
from mbcheck.models.floating_platform.exudyn_model import rods
from mbcheck.reference import get_scene
from mbcheck.reference.body.parameters import without_products
from mbcheck.reference.quaternions import of_rotation, product
from mbcheck.tests.support.draws import case_near, some_are_slow
from mbcheck.tests.support.engines.floating import floating
from mbcheck.tests.support.example import by_quantity, seen

SCENE = get_scene("floating_platform")
TUMBLING, CONSERVATIVE = SCENE.case("tumbling"), SCENE.case("conservative")


def results(fault: str, kind: str, case: Any = TUMBLING) -> dict[str, Any]:
    """Return the results of a kind of check of an engine with a fault, by quantity."""
    return by_quantity(adapt(fault or "right", floating(fault)), kind, case, "free")


FAULTS = [
    ("gyroscopic_lost", "parts", "gyroscopic.body", "gyroscopic term of body: dropped"),
    ("products", "parts", "products.body", "products of inertia of body: dropped"),
    ("products", "algebra", "mass_matrix", "products of inertia are dropped"),
    ("reaction_lost", "algebra", "accelerations", "does not bear the reactions of torques"),
    ("reaction_in_world", "algebra", "accelerations", "hinges act along axes of the world"),
    ("spin_lost", "algebra", "accelerations", "spin on hinges lack their gyroscopic moments"),
    ("coriolis_lost", "algebra", "accelerations", "turning platform lack Coriolis's force"),
    ("coupling_lost", "algebra", "accelerations", "inertia that couples platform and hinges"),
    ("coupling_lost", "algebra", "mass_matrix", "inertia that couples platform and hinges"),
    ("velocity_of_centre", "algebra", "accelerations", "those of the platform's centre of mass"),
    ("velocity_in_body", "algebra", "accelerations", "those in the frame of the platform"),
]

TURNED = (("from_file", "algebra", "accelerations", "right as the model stands, and wrong where"),)
"""Of a model that is placed otherwise."""


@pytest.mark.parametrize(("fault", "kind", "quantity", "words"), [*FAULTS, *TURNED])
def test_a_fault_is_named(fault: str, kind: str, quantity: str, words: str) -> None:
    (placed,) = SCENE.placed
    result = results(fault, kind, placed if fault == "from_file" else TUMBLING)[quantity]
    assert result.verdict == "deviation"
    assert words in result.reason


@pytest.mark.parametrize("kind", ["parts", "algebra"])
@pytest.mark.parametrize("has_mass_matrix", [True, False])
def test_a_right_engine_passes(kind: str, has_mass_matrix: bool) -> None:
    engine = floating("")
    engine.has_mass_matrix = has_mass_matrix
    found = by_quantity(adapt("right", engine), kind, TUMBLING, "free")
    verdicts = {result.verdict for result in found.values()}
    assert verdicts <= {"pass", "skipped"}
    assert "pass" in verdicts


@pytest.mark.parametrize("seed", some_are_slow(range(40)))
def test_it_passes_with_other_parameters(seed: int) -> None:
    case = case_near(TUMBLING, seed)
    for kind in ("parts", "algebra"):
        assert {one.verdict for one in results("", kind, case).values()} <= {"pass", "skipped"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("velocity_of_centre", "velocity is that of the platform's centre of mass"),
        ("world_update", "turned by rates of the world's frame"),
        ("reaction_lost", "does not bear the reactions of torques at hinges"),
        ("", ""),
    ],
)
def test_a_step_tells_what_is_wrong(fault: str, words: str) -> None:
    """Of velocities, rates and forces one each; `FAULTS` names the others by their equations."""
    found = results(fault, "step")
    assert found["x"].verdict == ("deviation" if words else "pass")
    assert words in found["x"].reason


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["", "dragged"])
def test_both_momenta_are_looked_at_while_a_motor_drives(fault: str) -> None:
    """What brakes a platform against the world, as no force between bodies does, shows there."""
    found = results(fault, "energy")
    names = {f"{kind}momentum_{axis}_drift" for kind in ("", "linear_") for axis in "xyz"}
    assert set(found) == names
    assert {one.verdict for one in found.values()} == {"deviation" if fault else "pass"}


@pytest.mark.slow
@pytest.mark.parametrize(("fault", "verdict"), [("", "pass"), ("order_two", "deviation")])
def test_the_order_of_the_free_joint_is_looked_at(fault: str, verdict: str) -> None:
    """Hinges by themselves would keep the fourth."""
    case = replace(CONSERVATIVE, horizon=0.0625)
    assert results(fault, "order", case)["order"].verdict == verdict


def tilted_last(p: Any) -> tuple[Any, Any]:
    """Return the hinges, that of the rod turned by its two angles in the wrong order."""
    rotor, rod = rods(p)
    ahead, tilt = of_rotation([0, 0, p.installation_angle]), of_rotation([p.tilt, 0, 0])
    return rotor, rod._replace(frame=np.array(product(ahead, tilt)))


ONLY_TURNED = "it is right as the model stands, and wrong where it turns"

BUILT: Mapping[str, tuple[Callable[[], Any], str, str, str]] = {
    "mass": (scaled("mass").make["exudyn"], "tumbling", "algebra", ""),
    "rotor": (scaled("eccentricity").make["exudyn"], "tumbling", "algebra", ""),
    "motor": (scaled("motor_slope").make["exudyn"], "tumbling", "algebra", ""),
    "spring": (scaled("rod_stiffness").make["exudyn"], "afloat", "frequency", "K is off at"),
    "damper": (scaled("rod_damping", 1.01).make["exudyn"], "afloat", "frequency", "C is off at"),
    "gravity": (scaled("gravity_z", -1.0).make["exudyn"], "falling", "algebra", ""),
    "products": (
        lambda: Rebuilt(exudyn_body, body_inertia=without_products),
        "tumbling", "algebra", "products of inertia are dropped",
    ),
    "hinge": (
        lambda: Rebuilt(exudyn_model, rods=tilted_last), "tumbling", "algebra", "",
    ),
    "attitude": (
        lambda: Rebuilt(exudyn_body, turn_quaternion=lambda axes: np.eye(4)),
        "falling+turned-1", "algebra", ONLY_TURNED,
    ),
}  # fmt: skip
"""Wrong Exudyn models, the case and the kind of check that show it, and what these say."""


@pytest.mark.parametrize("name", BUILT)
def test_what_is_wrong_in_the_exudyn_model_shows(name: str) -> None:
    pytest.importorskip("exudyn", exc_type=ImportError)
    make, label, kind, words = BUILT[name]
    (case,) = (one for one in (*SCENE.cases, *SCENE.placed) if one.label == label)
    (check,) = plan_cases([case], ["exudyn"], [kind], full=True)
    found = [one for one in run_check(check, engine=make()) if one.verdict != "pass"]
    assert {one.verdict for one in found} == {"deviation"}
    assert any(words in one.reason for one in found)


LOOKED_AT = ("parts", "algebra", "frequency")

EARNED: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "tumbling": ("reaction_of_motor_lost", ("algebra",)),
    "afloat": ("inertia_as_opened", ("frequency",)),
    "falling+turned-1": ("from_file", ("parts", "algebra")),
}
"""Cases of the default set, a fault that nothing else there shows, and which kinds show it."""


@pytest.mark.parametrize("case", EARNED)
def test_a_case_shows_what_no_other_shows(case: str) -> None:
    fault, kinds = EARNED[case]
    found = seen(floating(fault), SCENE.name, LOOKED_AT)
    assert {(case, kind) for kind in kinds} <= found
    assert {label for label, _ in found} == {case}


def test_every_case_shows_something_and_a_right_engine_passes() -> None:
    default = {case.label for case in (*SCENE.cases, *SCENE.placed) if not case.full_only}
    assert default == set(EARNED)
    assert seen(floating(""), SCENE.name, LOOKED_AT) == set()


@pytest.mark.parametrize("engine", ["mujoco", "exudyn"])
def test_an_engine_passes_what_needs_no_motion(engine: str) -> None:
    pytest.importorskip(engine, exc_type=ImportError)
    cases = (*SCENE.cases, *SCENE.placed)
    checks = plan_cases(cases, [engine], ("parts", "algebra", "frequency"))
    found = [result for check in checks for result in run_check(check)]
    assert {result.verdict for result in found} <= {"pass", "skipped"}
    assert sum(result.verdict == "pass" for result in found) >= 9


@pytest.mark.parametrize("told", [0.0, 1e-18, 1e-3])
def test_a_momentum_that_is_zero_may_be_told(told: float) -> None:
    """In a plane it is 0 but for rounding, and has no size to which it could be related."""
    case = replace(SCENE.case("planar"), state={})
    setup = Setup(adapt("right", floating("")), case, "free", None)
    values = {name: np.zeros(2) for name in SCENE.state_names}
    values |= {"q_w": np.ones(2), "theta_dot": np.full(2, 10.0), "momentum_x": np.full(2, told)}
    assert sensor_gaps(setup, 1e-3, values)["momentum_x"] == pytest.approx(told, abs=1e-15)

"""A body on a ball joint: right engines pass, and what engines have got wrong there is named."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.checks.diagnosis.motions import Part, explanation, looked_at
from mbcheck.comparisons.checks.suite import plan_cases, run_check
from mbcheck.comparisons.engines.adapter import adapt
from mbcheck.comparisons.engines.equations import ModelEquations
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.reports.run.located import located
from mbcheck.examples.mujoco_engine import MujocoPlugin
from mbcheck.reference import get_scene
from mbcheck.reference.quaternions import matrix
from mbcheck.tests.support.engines.turning import Turning, turning
from mbcheck.tests.support.example import by_quantity, seen

TUMBLING = get_scene("rigid_body").case("heavy_tumbling")


def results(engine: Any, kind: str) -> dict[str, Any]:
    """Return the results of a kind of check on the ball joint, by quantity."""
    return by_quantity(engine, kind, TUMBLING, "ball")


FAULTS = [
    ("gyroscopic_lost", "parts", "gyroscopic.body", "gyroscopic term of body: dropped"),
    ("gyroscopic_sign", "parts", "gyroscopic.body", "its sign is reversed"),
    ("products", "parts", "products.body", "products of inertia of body: dropped"),
    ("gravity_sign", "parts", "gravity", "gravity: its sign is reversed"),
    ("gravity_size", "parts", "gravity", "gravity: counted 1.01 times"),
    ("gyroscopic_lost", "algebra", "accelerations", "gyroscopic term omega x (J omega) is lost"),
    ("gyroscopic_sign", "algebra", "accelerations", "has the wrong sign"),
    ("standing_tensor", "algebra", "accelerations", "tensor does not turn with the body"),
    ("products", "algebra", "accelerations", "products of inertia are dropped"),
    ("gravity_sign", "algebra", "accelerations", "gravity has the wrong sign"),
    ("gravity_frame", "algebra", "accelerations", "gravity turns with the body"),
    ("gravity_frame", "parts", "unexplained", "gravity turns with the body"),
]


@pytest.mark.parametrize(("fault", "kind", "quantity", "words"), FAULTS)
def test_a_fault_is_named(fault: str, kind: str, quantity: str, words: str) -> None:
    result = results(adapt(fault, turning(fault)), kind)[quantity]
    assert result.verdict == "deviation"
    assert words in result.reason


@pytest.mark.parametrize(
    ("fault", "line"),
    [
        ("products", "products of inertia of body: dropped (rigid_body)"),
        ("gravity_frame", "gravity turns with the body (rigid_body; 2 checks)"),
    ],
)
def test_a_fault_is_located_in_one_line(fault: str, line: str) -> None:
    engine = adapt(fault, turning(fault))
    found = [one for kind in ("parts", "algebra") for one in results(engine, kind).values()]
    assert located(found)[1:] == [f"  {line}"]


def test_a_part_that_does_not_act_is_named() -> None:
    """Of a free top, which is accelerated by its gyroscopic term alone."""
    top = get_scene("rigid_body").case("free_euler")
    found = by_quantity(adapt("right", turning("")), "parts", top, "ball")
    reasons = [one.reason for one in found.values() if one.verdict == "skipped"]
    assert reasons == [
        f"{name} does not act enough to be told from rounding" for name in ("coriolis", "gravity")
    ]


@pytest.mark.parametrize("scene", ["rigid_body", "ball_hoop", "floating_platform", "floating_beam"])
def test_each_mistake_can_start_from_each_case(scene: str) -> None:
    known = get_scene(scene)
    for case in known.cases:
        for one in known.mistakes.values():
            start = ModelEquations(one, case.parameters).start(case)
            assert np.all(np.isfinite(start))


class Outside(Turning):
    """A right body whose angular velocity is told in the world's frame, in what runs return."""

    def simulate(self, *arguments: Any) -> Any:
        motion = super().simulate(*arguments)
        outside = [
            np.array(matrix(q)) @ v
            for q, v in zip(motion.positions, motion.velocities, strict=True)
        ]
        return replace(motion, velocities=np.array(outside))


TOLD_OUTSIDE = "rates are those of the world's frame, in what it returns"


def test_rates_that_are_told_outside_explain_a_run() -> None:
    engine, numbers = adapt("out", Outside()), np.arange(1, 4)
    setup = Setup(engine, TUMBLING, "ball", engine.methods[0])
    values = setup.simulate(setup.default_step, numbers).matrix(setup.scene.observables)
    seen = looked_at(setup, [Part(TUMBLING, numbers)], values)
    assert explanation(seen) == TOLD_OUTSIDE


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["step", "trajectory"])
def test_rates_that_are_told_outside_are_named(kind: str) -> None:
    found = [one for one in results(adapt("out", Outside()), kind).values() if one.cause]
    assert {one.cause for one in found} == {TOLD_OUTSIDE}
    assert {one.quantity for one in found} >= {"omega_x", "omega_y", "omega_z"}


@pytest.mark.parametrize("kind", ["parts", "algebra"])
@pytest.mark.parametrize("has_mass_matrix", [True, False])
def test_a_right_engine_passes(kind: str, has_mass_matrix: bool) -> None:
    engine = turning("")
    engine.has_mass_matrix = has_mass_matrix
    verdicts = {r.verdict for r in results(adapt("right", engine), kind).values()}
    assert verdicts <= {"pass", "skipped"}
    assert "pass" in verdicts


def test_a_quaternion_that_loses_its_length_is_an_error() -> None:
    found = results(adapt("long", turning("not_normalised")), "trajectory")
    assert {one.verdict for one in found.values()} == {"error"}
    assert "a quaternion has the length 1.00" in found["R_xx"].reason


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("world_update", "turned by rates of the world's frame"),
        ("world_rates", "rates are those of the world's frame"),
        ("", ""),
        ("other_sign", ""),
    ],
)
def test_a_step_tells_whose_rates_turn_a_quaternion(fault: str, words: str) -> None:
    found = results(adapt("step", turning(fault)), "step")
    verdict = "deviation" if words else "pass"
    assert found["R_xx"].verdict == found["omega_x"].verdict == verdict
    assert words in found["R_xx"].reason


class Principal(MujocoPlugin):
    """MuJoCo that takes the principal axes of a body on a free joint to be the body's."""

    def at(self, system: Any, *state: Any) -> Any:
        text = system.mjcf
        if "<freejoint" in text:
            text = re.sub(r'(<inertial [^>]*?) quat="[^"]*"', r"\1", text)
        return super().at(replace(system, mjcf=text), *state)


EARNED: Mapping[str, tuple[Any, tuple[str, ...]]] = {
    "heavy_tumbling": (turning("parallel_axes"), ("parts", "algebra", "trajectory")),
    "heavy_tumbling+turned-1": (turning("world_attitude"), ("parts", "algebra")),
    "free_euler": (Principal(), ("parts", "algebra", "trajectory")),
    "intermediate_axis": (turning("coarse_tolerance"), ("trajectory",)),
    "lagrange_top": (turning("largest_rate"), ("trajectory",)),
    "rest_hanging": (turning("weight_that_stands"), ("frequency",)),
}
"""Cases of the default set, a fault that nothing else there shows, and which kinds show it."""

LOOKED_AT = ("parts", "algebra", "trajectory", "frequency")


@pytest.mark.campaign  # of the choice of cases, when it changes
@pytest.mark.parametrize("case", EARNED)
def test_a_case_shows_what_no_other_shows(case: str) -> None:
    """But the same case placed otherwise, and frequencies, which do not tell what is wrong."""
    engine, kinds = EARNED[case]
    found = {
        place
        for place in seen(engine, "rigid_body", LOOKED_AT)
        if not place[0].startswith(f"{case}+")
    }
    wanted = {(case, kind) for kind in kinds}
    assert wanted <= found
    assert {kind for _, kind in found - wanted} <= {"frequency"}


@pytest.mark.parametrize(
    "engine",
    [pytest.param(turning(""), marks=pytest.mark.slow), MujocoPlugin()],
    ids=["turning", "mujoco"],
)
def test_right_engines_pass_all_cases(engine: Any) -> None:
    assert seen(engine, "rigid_body", LOOKED_AT) == set()


def test_every_case_shows_something() -> None:
    scene = get_scene("rigid_body")
    default = {case.label for case in (*scene.cases, *scene.placed) if not case.full_only}
    assert default == set(EARNED)


@pytest.mark.slow
@pytest.mark.parametrize(("fault", "slope"), [("", 4), ("order_two", 2)])
def test_an_order_that_drops_on_a_ball_joint_is_seen(fault: str, slope: int) -> None:
    found = results(adapt("order", turning(fault)), "order")
    assert found["order"].value == pytest.approx(slope, abs=0.1)
    assert found["order"].verdict == ("pass" if slope == 4 else "deviation")
    assert found["extrapolated"].verdict == "pass"


@pytest.mark.parametrize("engine", ["mujoco", "exudyn"])
def test_an_engine_passes_what_needs_no_motion(engine: str) -> None:
    pytest.importorskip(engine, exc_type=ImportError)
    cases = get_scene("rigid_body").cases
    checks = plan_cases(cases, [engine], ("parts", "algebra", "frequency"))
    found = [result for check in checks for result in run_check(check)]
    assert {result.verdict for result in found} <= {"pass", "skipped"}
    assert sum(result.verdict == "pass" for result in found) >= 8

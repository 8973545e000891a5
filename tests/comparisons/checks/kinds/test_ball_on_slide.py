"""A body on a ball joint on a slide: right engines pass, faults in what couples them are named."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.checks.suite import plan_cases, run_check
from mbcheck.comparisons.engines.adapter import adapt
from mbcheck.reference import get_scene
from mbcheck.tests.support.engines.sliding import sliding
from mbcheck.tests.support.example import by_quantity, seen

SCENE = get_scene("ball_hoop")
DRIVEN, WEIGHED = SCENE.case("driven"), SCENE.case("weighed")


def results(engine: Any, kind: str, case: Any = WEIGHED) -> dict[str, Any]:
    """Return the results of a kind of check, by quantity."""
    return by_quantity(engine, kind, case, "ball")


FAULTS = [
    ("gyroscopic_of_centre", "parts", "gyroscopic.body", "gyroscopic term of body: dropped"),
    ("products", "parts", "products.body", "products of inertia of body: dropped"),
    ("gravity_sign", "parts", "gravity", "gravity: its sign is reversed"),
    ("friction_lost", "parts", "damper.q", "damper of q: dropped"),
    ("gyroscopic_lost", "algebra", "accelerations", "gyroscopic term omega x (J omega) is lost"),
    ("products", "algebra", "accelerations", "products of inertia are dropped"),
    ("coupling_lost", "algebra", "accelerations", "inertia that couples slide and ball joint"),
    ("coupling_lost", "algebra", "mass_matrix", "inertia that couples slide and ball joint"),
    ("pull_lost", "algebra", "accelerations", "turning body does not pull at the slide"),
    ("slide_in_body", "algebra", "accelerations", "direction is taken in the frame of the body"),
    ("transport_lost", "algebra", "accelerations", "moving joint lacks v x p"),
    ("gravity_sign", "algebra", "accelerations", "gravity has the wrong sign"),
]


@pytest.mark.parametrize(("fault", "kind", "quantity", "words"), FAULTS)
def test_a_fault_is_named(fault: str, kind: str, quantity: str, words: str) -> None:
    result = results(adapt(fault, sliding(fault)), kind)[quantity]
    assert result.verdict == "deviation"
    assert words in result.reason


@pytest.mark.parametrize("kind", ["parts", "algebra"])
@pytest.mark.parametrize("has_mass_matrix", [True, False])
def test_a_right_engine_passes(kind: str, has_mass_matrix: bool) -> None:
    engine = sliding("")
    engine.has_mass_matrix = has_mass_matrix
    verdicts = {r.verdict for r in results(adapt("right", engine), kind).values()}
    assert verdicts <= {"pass", "skipped"}
    assert "pass" in verdicts


@pytest.mark.parametrize("seed", range(3))
def test_it_passes_with_other_parameters(seed: int) -> None:
    random = np.random.default_rng(seed)
    p = WEIGHED.parameters
    values = p.as_dict().items()
    p = p.replace(**{name: value * random.uniform(0.8, 1.2) for name, value in values})
    state = {name: value * random.uniform(0.8, 1.2) for name, value in WEIGHED.state.items()}
    case = replace(WEIGHED, parameters=p, state=state)
    for kind in ("parts", "algebra"):
        found = results(adapt("varied", sliding("")), kind, case)
        assert {result.verdict for result in found.values()} <= {"pass", "skipped"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("world_update", "turned by rates of the world's frame"),
        ("world_rates", "rates are those of the world's frame"),
        ("transport_lost", "moving joint lacks v x p"),
        ("", ""),
        ("other_sign", ""),
    ],
)
def test_a_step_tells_what_is_wrong(fault: str, words: str) -> None:
    found = results(adapt("step", sliding(fault)), "step")
    assert found["R_xx"].verdict == found["y"].verdict == ("deviation" if words else "pass")
    assert words in found["R_xx"].reason


@pytest.mark.slow
@pytest.mark.parametrize(("fault", "verdict"), [("", "pass"), ("slide_in_body", "deviation")])
def test_the_angular_momentum_about_the_slide_is_looked_at(fault: str, verdict: str) -> None:
    """Also while a force drives the slide and a damper brakes it."""
    found = results(adapt("momentum", sliding(fault)), "energy", DRIVEN)
    assert set(found) == {"momentum_drift"}
    assert found["momentum_drift"].verdict == verdict


LOOKED_AT = ("parts", "algebra", "trajectory", "frequency")

EARNED: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "weighed": ("coupling_lost", ("parts", "algebra", "trajectory")),
    "weighed+turned-1": ("slide_in_world", ("parts", "algebra")),
    "hanging": ("inertia_as_opened", ("frequency",)),
}
"""Cases of the default set, a fault that nothing else there shows, and which kinds show it."""


@pytest.mark.slow
@pytest.mark.parametrize("case", EARNED)
def test_a_case_shows_what_no_other_shows(case: str) -> None:
    """But the same case placed otherwise, and frequencies, which do not tell what is wrong."""
    fault, kinds = EARNED[case]
    found = seen(sliding(fault), SCENE.name, LOOKED_AT)
    wanted = {(case, kind) for kind in kinds}
    assert wanted <= found
    others = {place for place in found - wanted if not place[0].startswith(f"{case}+")}
    assert {kind for _, kind in others} <= {"frequency"}


def test_every_case_shows_something_and_a_right_engine_passes() -> None:
    default = {case.label for case in (*SCENE.cases, *SCENE.placed) if not case.full_only}
    assert default == set(EARNED)
    assert seen(sliding(""), SCENE.name, LOOKED_AT) == set()


@pytest.mark.parametrize("engine", ["mujoco", "exudyn"])
def test_an_engine_passes_what_needs_no_motion(engine: str) -> None:
    pytest.importorskip(engine, exc_type=ImportError)
    checks = plan_cases(SCENE.cases, [engine], ("parts", "algebra", "frequency"))
    found = [result for check in checks for result in run_check(check)]
    assert {result.verdict for result in found} <= {"pass", "skipped"}
    assert sum(result.verdict == "pass" for result in found) >= 9

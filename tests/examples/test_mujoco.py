"""MuJoCo through the door for everyone, beside the adapter that mbcheck has of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from mbcheck.comparisons.checks.suite import checks_of, kinds_of, run_check
from mbcheck.comparisons.checks.table import KINDS
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.examples import mujoco_engine
from mbcheck.examples.mujoco_engine import MujocoPlugin
from mbcheck.reference import SCENES, get_scene
from mbcheck.tests.support.example import bad, cases_of_all_kinds, results

METHODS = {method.name for method in MujocoPlugin.methods}

QUICK = {
    ("hula_hoop", "semicircle_3hz_60n"): ("algebra", "step"),
    ("speed_regulator", "rotation"): ("algebra", "step", "trajectory"),
    ("speed_regulator", "opened_loop"): ("trajectory",),
}


def beside(scene: str, case: str, kinds: tuple[str, ...]) -> None:
    """Compare both doors: no verdict is worse, and numbers agree to what the checks grant.

    At the same sample; the largest model error counts reactions of the built-in as well.
    """
    found = results(MujocoPlugin(), scene, kinds, case)
    assert not bad(found)
    own: dict[Any, Any] = {}
    known = get_scene(scene).case(case)
    for kind in kinds_of(known):
        for check in checks_of(kind, known, "mujoco") if kind in kinds else ():
            built_in = check.method is None or check.method.name in METHODS
            if built_in and not check.unsupported_reason:
                own |= {key(item): item for item in run_check(check, engine=get_engine("mujoco"))}
    both = [(item, own[key(item)]) for item in found if key(item) in own]
    assert both
    for item, other in both:
        comparable = item.value is not None and item.reference == other.reference
        if comparable and item.quantity != "model_error":
            assert abs(item.value - other.value) <= item.tolerance + other.tolerance


def key(item: Any) -> tuple[str, ...]:
    """Return what a result is about, the engine apart."""
    return item.kind, item.model, item.method, item.quantity


@pytest.mark.parametrize(("scene", "case"), QUICK)
def test_both_doors_lead_to_the_same_verdicts(scene: str, case: str) -> None:
    beside(scene, case, QUICK[scene, case])


LONGEST = {
    ("floating_beam", "tumbling"),
    ("rotating_beam", "pulse_quick"),
    ("speed_regulator", "limit_cycle"),
}
"""Cases that take longest, whose kinds others have: by hand."""


@pytest.mark.parametrize(
    ("scene", "case"),
    [
        pytest.param(*place, marks=pytest.mark.campaign if place in LONGEST else pytest.mark.slow)
        for name in SCENES
        for place in ((name, case) for case in cases_of_all_kinds(name))
    ],
)
def test_all_that_is_checked_passes(scene: str, case: str) -> None:
    beside(scene, case, tuple(KINDS))


class Rigid(MujocoPlugin):
    """Nothing said of how soft its loops are."""

    closure = "rigid"


def test_a_soft_closure_that_is_called_rigid_deviates() -> None:
    found = bad(results(Rigid(), "speed_regulator", ("algebra",), "rotation"))
    assert {item.quantity for item in found} >= {"accelerations"}


class Other(MujocoPlugin):
    """Loops are soft, and how is not said."""

    closure = "soft"


def test_loops_that_are_soft_by_another_rule_are_skipped_with_that_reason() -> None:
    found = results(Other(), "speed_regulator", ("algebra", "step", "trajectory"), "rotation")
    assert found
    assert {item.verdict for item in found} == {"skipped"}
    assert any("soft by a rule of its own" in item.reason for item in found)


def test_the_example_is_as_short_as_the_page_says() -> None:
    lines = Path(mujoco_engine.__file__).read_text(encoding="utf-8").splitlines()
    assert len([line for line in lines if line]) <= 40

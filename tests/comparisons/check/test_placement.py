"""Models that are turned, or mirrored: right engines pass, and those that only stand are named."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from mbcheck.comparisons.check.request import check, plan_checks
from mbcheck.comparisons.checks.request import CheckRequest
from mbcheck.comparisons.checks.suite import checks_of, kinds_of, plan_cases, run_check
from mbcheck.comparisons.checks.verdict import Result
from mbcheck.comparisons.engines.adapter import adapt
from mbcheck.comparisons.faults.mujoco import MujocoAdapter
from mbcheck.reference import SCENES, get_scene
from mbcheck.reference.errors import UsageError
from mbcheck.reference.scene import Case
from mbcheck.tests.support.engines.reading import Reader
from mbcheck.tests.support.example import all_checks, bad
from mbcheck.tests.support.placements import WRONG, WithReactionsAlongTheWorld

PLACEMENTS = ("turned:1", "mirrored:2")


def results(engine: Any, case: Case, kinds: tuple[str, ...]) -> list[Result]:
    """Return what some kinds of check say of a plug-in."""
    one = adapt("wrong", engine)
    return [
        item
        for kind in kinds_of(case)
        if kind in kinds
        for planned in all_checks(kind, case, one)
        for item in run_check(planned, engine=one)
    ]


def case_of(scene: str, placement: str) -> Case:
    """Return the case of a scene that the default set has placed, placed so."""
    return replace(get_scene(scene).placed[0], placement=placement)


@pytest.mark.parametrize("placement", PLACEMENTS)
@pytest.mark.parametrize("name", WRONG)
def test_what_only_stands_is_named(name: str, placement: str) -> None:
    engine, scene, words = WRONG[name]
    kinds = ("parts", "algebra")
    assert not bad(results(engine, case_of(scene, ""), kinds))
    found = bad(results(engine, case_of(scene, placement), kinds))
    placed = {"turned:1": "rotated in space", "mirrored:2": "mirrored"}[placement]
    assert words.format(placed=placed) in {item.cause for item in found}


@pytest.mark.parametrize("placement", PLACEMENTS)
def test_a_loop_that_turns_passes(placement: str) -> None:
    assert not bad(results(Reader, case_of("speed_regulator", placement), ("parts", "algebra")))


@pytest.mark.parametrize("placement", PLACEMENTS)
def test_reactions_along_the_axes_of_the_world_are_named(placement: str) -> None:
    case, engine = case_of("speed_regulator", placement), WithReactionsAlongTheWorld()
    (planned,) = (c for c in checks_of("algebra", case, "mujoco") if c.model == "connect")
    assert not bad(run_check(planned, engine=MujocoAdapter()))
    found = bad(run_check(planned, engine=engine))
    assert {item.quantity for item in found} >= {"reaction_a_x", "reaction_b_y"}
    assert {item.cause for item in found} == {
        "reactions have their components along the axes of the world, not of the model"
    }
    as_it_stands = replace(planned, case=case_of("speed_regulator", ""))
    assert not bad(run_check(as_it_stands, engine=engine))


def test_a_placement_is_part_of_new_ids_only() -> None:
    plain = [one.prefix for one in plan_checks(CheckRequest(placement="none")).checks]
    every = [one.prefix for one in plan_checks(CheckRequest()).checks]
    more = [prefix for prefix in every if prefix not in set(plain)]
    assert [prefix for prefix in every if prefix in set(plain)] == plain
    assert all("+turned-1/" in prefix or "+mirrored-2/" in prefix for prefix in more)
    assert {prefix.split("/")[1] for prefix in more} == set(SCENES)


@pytest.mark.parametrize("scene", SCENES)
def test_what_has_no_mirror_image_is_skipped_with_that_reason(scene: str) -> None:
    case = case_of(scene, "mirrored:3")
    checks = plan_cases([case], ("mujoco", "exudyn"), kinds=("algebra",))
    reasons = {one.model: one.unsupported_reason for one in checks}
    for model in set(reasons) & {"ball", "free"}:
        assert "joint has a quaternion, which is another one in a mirror" in str(reasons[model])
    assert reasons.get("euler_parameters") is None or "mirror" in str(reasons["euler_parameters"])
    assert checks


def test_all_models_can_be_placed() -> None:
    report = check(
        ["hula_hoop"], ["mujoco"], ["parts", "algebra"], placement="turned:7",
        ids=["*/point_mass_3hz_60n+*"],
    )  # fmt: skip
    assert report.exit_code == 0
    assert {item.case for item in report.results} == {"point_mass_3hz_60n+turned-7"}
    assert "--placement turned:7" in report.repeat("an id")


@pytest.mark.parametrize("placement", ["turned", "turned:-1", "turned:1.5", "left:1", "turned: 1"])
def test_a_placement_that_is_none_is_refused(placement: str) -> None:
    with pytest.raises(UsageError, match="placement"):
        plan_checks(CheckRequest(["hula_hoop"], placement=placement))

"""Exudyn's own models, turned and mirrored: right ones pass, those that only stand are named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mbcheck.comparisons.check.request import check
from mbcheck.comparisons.checks.suite import checks_of, run_check
from mbcheck.comparisons.checks.verdict import Result
from mbcheck.comparisons.engines.exudyn.engine import Exudyn
from mbcheck.comparisons.engines.protocol import System
from mbcheck.comparisons.engines.variants.exudyn import ExudynAdapter
from mbcheck.reference import get_scene
from mbcheck.reference.scene import Case
from mbcheck.tests.support import placements
from mbcheck.tests.support.example import bad

SEEDS = (*(f"turned:{seed}" for seed in range(1, 6)), "mirrored:2", "mirrored:3")
CASES = ("hula_hoop", "weighed"), ("rotor_pendulum", "weighed"), ("speed_regulator", "weighed")
PLACEMENTS = "turned:1", "mirrored:2", "turned:4"
ONLY_STANDS = "it is right as the model stands, and wrong where it turns"


def results(engine: ExudynAdapter, case: Case, kind: str, model: str) -> list[Result]:
    """Return what one kind of check says of a model, by its first method."""
    checks = [one for one in checks_of(kind, case, "exudyn") if one.model == model]
    ran = [run_check(one, engine=engine) for one in checks]
    return [item for found in ran for item in found if item.verdict != "skipped"]


@pytest.mark.parametrize("placement", SEEDS)
@pytest.mark.parametrize(("scene", "name"), CASES)
def test_bodies_in_space_accelerate_as_those_in_the_plane(
    scene: str, name: str, placement: str
) -> None:
    engine, names = Exudyn(), get_scene(scene).public
    case = get_scene(scene).case(name)
    q, v = np.random.default_rng(4).normal(size=(2, len(names)))
    answers = []
    for one in (case, replace(case, placement=placement)):
        state = System(one, "redundant", names, q, v), 0.3, q, v
        mass = engine.mass_matrix(state[0], q)
        answers.append((engine.accelerations(*state), mass, [*engine.reactions(*state).values()]))
    for stands, placed in zip(*answers, strict=True):
        size = np.max(np.abs(stands), initial=1e-300)
        np.testing.assert_allclose(placed, stands, rtol=0, atol=1e-10 * size)


@pytest.mark.slow
@pytest.mark.parametrize("placement", ["turned:3", "mirrored:4"])
@pytest.mark.parametrize("scene", ["hula_hoop", "speed_regulator"])
def test_runs_of_what_is_placed_pass(scene: str, placement: str) -> None:
    report = check([scene], ["exudyn"], ["step", "order", "energy"], placement=placement)
    assert report.exit_code == 0
    found = {
        item.kind for item in report.results if item.model == "redundant" and item.verdict == "pass"
    }
    assert found >= {"step", "order"}


WRONG = {
    "springs": (placements.springs_along_the_world, "hula_hoop", "semicircle_3hz_60n"),
    "weights": (placements.weights_along_the_world, "speed_regulator", "weighed"),
    "drives": (placements.drives_along_the_world, "hula_hoop", "semicircle_3hz_60n"),
}


@pytest.mark.parametrize(("name", "placement"), list(zip(WRONG, PLACEMENTS, strict=True)))
def test_what_only_stands_is_named(name: str, placement: str) -> None:
    change, scene, at = WRONG[name]
    case, engine = get_scene(scene).case(at), placements.Rebuilt(change)
    assert not bad(results(engine, case, "algebra", "redundant"))
    placed = replace(case, placement=placement)
    assert not bad(results(ExudynAdapter(), placed, "algebra", "redundant"))
    found = bad(results(engine, placed, "algebra", "redundant"))
    assert {item.cause for item in found} == {ONLY_STANDS}


def test_reactions_along_the_axes_of_the_world_are_named() -> None:
    case = get_scene("speed_regulator").placed[0]
    engine = placements.WithExudynsReactionsAlongTheWorld()
    found = bad(results(engine, case, "algebra", "redundant"))
    assert {item.quantity for item in found} >= {"reaction_a_x", "reaction_b_y"}
    assert {item.cause for item in found} == {
        "reactions are told along the axes of the world, not of the model"
    }
    assert not bad(results(engine, replace(case, placement=""), "algebra", "redundant"))


@pytest.mark.parametrize(
    ("scene", "model", "placement", "words"),
    [
        ("speed_regulator", "one_dof", "turned:1", "no place in the world"),
        ("rotating_beam", "elements", "turned:1", "plane elements"),
        ("ball_hoop", "euler_parameters", "mirrored:2", "no mirror images"),
        ("ball_hoop", "euler_parameters", "turned:1", None),
        ("hula_hoop", "kinematic_tree", "mirrored:2", None),
    ],
)
def test_what_is_not_placed_says_why(
    scene: str, model: str, placement: str, words: str | None
) -> None:
    case = replace(get_scene(scene).cases[0], placement=placement)
    reason = ExudynAdapter().why_not_placed(case, model)
    assert reason is None if words is None else words in str(reason)

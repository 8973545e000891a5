"""Exudyn's own models, turned and mirrored: right ones pass, those that only stand are named."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.check.request import check
from mbcheck.comparisons.checks.suite import checks_of, run_check
from mbcheck.comparisons.checks.verdict import Result
from mbcheck.comparisons.engines.exudyn.engine import Exudyn
from mbcheck.comparisons.engines.protocol import System
from mbcheck.comparisons.faults.exudyn import ExudynAdapter
from mbcheck.models.placement import right_handed, world_axes
from mbcheck.reference import get_scene
from mbcheck.reference.rotating_beam.elements import element_scene
from mbcheck.reference.scene import Array, Case
from mbcheck.tests.support import placements
from mbcheck.tests.support.example import bad

SEEDS = (*(f"turned:{seed}" for seed in range(1, 6)), "mirrored:2", "mirrored:3")
CASES = ("hula_hoop", "weighed"), ("rotor_pendulum", "weighed"), ("speed_regulator", "weighed")
PLACEMENTS = "turned:1", "mirrored:2", "turned:4"
ONLY_STANDS = "right for the model as in its file, and wrong for the same model "
HOW = {"turned": "rotated in space", "mirrored": "mirrored"}


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


class AcrossThePlane(Exudyn):
    """Exudyn that shows how far the nodes of elements leave their plane."""

    def system(self, case: Case, model: str) -> Any:
        """Return the assembled system of a case."""
        built = super().system(case, model)
        normal = right_handed(world_axes(case.placement))[:, 2]

        def outputs(coordinates: Array, rates: Array) -> dict[str, Array]:
            vectors = coordinates[1:-6].reshape(-1, 3, coordinates.shape[1])
            return {"across": np.max(np.abs(np.einsum("i,kij->kj", normal, vectors)), axis=0)}

        return replace(built, outputs=outputs)


@pytest.mark.parametrize("placement", PLACEMENTS)
def test_elements_in_space_move_as_those_in_the_plane(placement: str) -> None:
    engine, case = Exudyn(), get_scene("rotating_beam").case("weighed")
    names = element_scene(round(case.parameters.segments)).coordinates
    q, v = 1e-3 * np.random.default_rng(4).normal(size=(2, len(names)))
    straight, hub = np.zeros(len(names)), np.eye(len(names))[0]
    times: Array = np.arange(1, 9) / 32
    answers = []
    for one in (case, replace(case, placement=placement)):
        light = replace(one, parameters=one.parameters.replace(gravity_x=0.0, gravity_y=0.0))
        begin = System(one, "elements", names, 0.4 * hub, 1.3 * hub)
        answers.append(
            [
                engine.accelerations(begin, 0.3, q, v),
                engine.mass_matrix(begin, q),
                *engine.linearise(System(light, "elements", names, straight, hub)),
                engine.simulate(begin, engine.methods[-2], 2.0**-9, times).positions,
            ]
        )
    for stands, placed in zip(*answers, strict=True):
        np.testing.assert_allclose(placed, stands, rtol=0, atol=1e-10 * np.max(np.abs(stands)))
    seen = AcrossThePlane().simulate(begin, engine.methods[-2], 2.0**-9, times).observables
    assert 0.0 < np.max(seen["across"]) < 1e-12  # of 8 m, by rounding


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene", "placement", "ids"),
    [("hula_hoop", "turned:3", "*@redundant/*"), ("speed_regulator", "mirrored:4", "*")],
)
def test_runs_of_what_is_placed_pass(scene: str, placement: str, ids: str) -> None:
    kinds = ["step", "order", "energy"]
    report = check([scene], ["exudyn"], kinds, ids=[ids], placement=placement)
    assert report.exit_code == 0
    found = {
        item.kind for item in report.results if item.model == "redundant" and item.verdict == "pass"
    }
    assert found >= {"step", "order"}


WRONG = {
    "slides": (placements.slides_along_the_world, "hula_hoop", "semicircle_3hz_60n"),
    "weights": (placements.weights_along_the_world, "speed_regulator", "weighed"),
    "weights of elements": (placements.weights_along_the_world, "rotating_beam", "weighed"),
}


@pytest.mark.parametrize(
    ("name", "placement"), list(zip(WRONG, (*PLACEMENTS[:2], "turned:7"), strict=True))
)
def test_what_only_stands_is_named(name: str, placement: str) -> None:
    change, scene, at = WRONG[name]
    model = "elements" if scene == "rotating_beam" else "redundant"
    case, engine = get_scene(scene).case(at), ExudynAdapter(placements.Rebuilt(change))
    assert not bad(results(engine, case, "algebra", model))
    placed = replace(case, placement=placement)
    assert not bad(results(ExudynAdapter(), placed, "algebra", model))
    found = bad(results(engine, placed, "algebra", model))
    assert {item.cause for item in found} == {ONLY_STANDS + HOW[placement.partition(":")[0]]}


@pytest.mark.parametrize("factor", [1.0, 1.001])
def test_frequencies_of_elements_in_space_are_those_in_their_plane(factor: float) -> None:
    def scale(mbs: Any, axes: Array, p: Any) -> None:
        for item in range(mbs.systemData.NumberOfObjects()):
            if mbs.GetObject(item)["objectType"] == "ANCFCable":
                stiffness = factor * mbs.GetObjectParameter(item, "bendingStiffness")
                mbs.SetObjectParameter(item, "bendingStiffness", stiffness)

    case = get_scene("rotating_beam").case("steady_4_tip_mass")
    placed = replace(case, placement="turned:7")
    found = results(ExudynAdapter(placements.Rebuilt(scale)), placed, "frequency", "elements")
    assert found
    assert bool(bad(found)) == (factor != 1.0)


def test_reactions_along_the_axes_of_the_world_are_named() -> None:
    case = get_scene("speed_regulator").placed[0]
    engine = ExudynAdapter(placements.WithExudynsReactionsAlongTheWorld())
    found = bad(results(engine, case, "algebra", "redundant"))
    assert {item.quantity for item in found} >= {"reaction_a_x", "reaction_b_y"}
    assert {item.cause for item in found} == {
        "reactions have their components along the axes of the world, not of the model"
    }
    assert not bad(results(engine, replace(case, placement=""), "algebra", "redundant"))


@pytest.mark.parametrize(
    ("scene", "model", "placement", "words"),
    [
        ("speed_regulator", "one_dof", "turned:1", "no place in the world"),
        ("rotating_beam", "elements", "turned:1", None),
        ("ball_hoop", "euler_parameters", "mirrored:2", "no mirror images"),
        ("ball_hoop", "euler_parameters", "turned:1", None),
        ("hula_hoop", "kinematic_tree", "mirrored:2", None),
    ],
)
def test_what_is_not_placed_says_why(
    scene: str, model: str, placement: str, words: str | None
) -> None:
    case = replace(get_scene(scene).cases[0], placement=placement)
    reason = ExudynAdapter().bind(case, model).description.unplaceable_reason
    assert reason is None if words is None else words in str(reason)


def test_geometrically_exact_elements_are_not_placed() -> None:
    case = get_scene("rotating_beam").case("steady_4_geometrically_exact")
    model = ExudynAdapter().bind(replace(case, placement="turned:1"), "elements")
    assert "lie in a plane" in str(model.description.unplaceable_reason)

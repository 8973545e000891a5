"""A chain of rods afloat: right engines pass, faults in chains whose axes differ are named."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import pytest

from mbcheck.comparisons.checks.suite import plan_cases, run_check
from mbcheck.comparisons.engines.adapter import adapt
from mbcheck.comparisons.faults.catalogue import scaled
from mbcheck.comparisons.faults.exudyn import Rebuilt
from mbcheck.models.floating_beam import exudyn_model
from mbcheck.models.floating_beam.exudyn_model import rods
from mbcheck.reference import get_scene
from mbcheck.tests.support.draws import case_near, some_are_slow
from mbcheck.tests.support.engines.floating import floating
from mbcheck.tests.support.example import by_quantity, seen

SCENE = get_scene("floating_beam")
TUMBLING, PLANAR = SCENE.case("tumbling"), SCENE.case("planar")
PLATFORM = get_scene("floating_platform").case("tumbling")


def results(fault: str, kind: str, case: Any = TUMBLING) -> dict[str, Any]:
    """Return the results of a kind of check of an engine with a fault, by quantity."""
    return by_quantity(adapt(fault or "right", floating(fault)), kind, case, "free")


FAULTS = [
    ("axes_as_opened", "accelerations", "axes of hinges do not turn with the bodies that bear"),
    ("axes_as_opened", "mass_matrix", "axes of hinges do not turn with the bodies that bear"),
    ("axes_still", "accelerations", "make of each other by turning the axes beyond them"),
    ("reaction_lost", "accelerations", "the hub does not bear the reactions of torques"),
    ("coriolis_lost", "accelerations", "move on the turning hub lack Coriolis's force"),
    ("coupling_lost", "mass_matrix", "the inertia that couples hub and hinges is lost"),
]


@pytest.mark.parametrize(("fault", "quantity", "words"), FAULTS)
def test_a_fault_is_named(fault: str, quantity: str, words: str) -> None:
    result = results(fault, "algebra")[quantity]
    assert result.verdict == "deviation"
    assert words in result.reason


@pytest.mark.parametrize("case", [PLANAR, PLATFORM], ids=lambda case: case.scene)
@pytest.mark.parametrize("fault", ["axes_as_opened", "axes_still"])
def test_parallel_axes_and_hinges_side_by_side_do_not_show_it(fault: str, case: Any) -> None:
    assert {one.verdict for one in results(fault, "algebra", case).values()} == {"pass"}


@pytest.mark.parametrize("kind", ["parts", "algebra"])
def test_a_right_engine_passes(kind: str) -> None:
    verdicts = {result.verdict for result in results("", kind).values()}
    assert verdicts <= {"pass", "skipped"}
    assert "pass" in verdicts


@pytest.mark.parametrize("seed", some_are_slow(range(20)))
def test_it_passes_with_other_parameters(seed: int) -> None:
    case = case_near(TUMBLING, seed)
    for kind in ("parts", "algebra"):
        assert {one.verdict for one in results("", kind, case).values()} <= {"pass", "skipped"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("axes_still", "make of each other by turning the axes beyond them"),
        ("", ""),
    ],
)
def test_a_step_tells_what_is_wrong(fault: str, words: str) -> None:
    """As their accelerations do, of which `FAULTS` has more."""
    found = results(fault, "step")
    assert found["theta_3"].verdict == ("deviation" if words else "pass")
    assert words in found["theta_3"].reason


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["", "axes_still", "axes_as_opened"])
def test_momenta_and_energy_are_looked_at(fault: str) -> None:
    """Momenta are conserved by any accelerations that a force between bodies makes."""
    case = replace(SCENE.case("conservative"), horizon=0.125)
    found = results(fault, "energy", case)
    assert len(found) == 7
    assert {one.verdict for one in found.values()} & {"deviation"} == (
        {"deviation"} if fault else set()
    )


def twisted_last(p: Any) -> list[Any]:
    """Return the rods, the twist of the last one in the opposite sense."""
    *others, last = rods(p)
    return [*others, last._replace(frame=last.frame * [1, -1, -1, -1])]


def on_hub(p: Any) -> list[Any]:
    """Return the rods, those beyond the first of a length with the springs of the clamp."""
    found = rods(p)
    return [one._replace(spring=found[0].spring) for one in found]


BUILT: Mapping[str, tuple[Callable[[], Any], str, str, str]] = {
    "tip": (scaled("tip_mass").make["exudyn"], "tumbling", "algebra", ""),
    "twist": (lambda: Rebuilt(exudyn_model, rods=twisted_last), "tumbling", "algebra", ""),
    "springs": (
        lambda: Rebuilt(exudyn_model, rods=on_hub), "afloat", "frequency",
        "K is off at (theta_2, theta_2) and (theta_3, theta_3)",
    ),
}  # fmt: skip
"""Wrong Exudyn models, the case and the kind of check that show it, and what these say."""


@pytest.mark.parametrize("name", BUILT)
def test_what_is_wrong_in_the_exudyn_model_shows(name: str) -> None:
    pytest.importorskip("exudyn", exc_type=ImportError)
    make, label, kind, words = BUILT[name]
    (check,) = plan_cases([SCENE.case(label)], ["exudyn"], [kind], full=True)
    found = [one for one in run_check(check, engine=make()) if one.verdict != "pass"]
    assert {one.verdict for one in found} == {"deviation"}
    assert any(words in one.reason for one in found)


LOOKED_AT = ("parts", "algebra", "step", "frequency")

EARNED: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "tumbling": ("world_update", ("step",)),
    "afloat": ("inertia_as_opened", ("frequency",)),
    "tumbling+turned-1": ("from_file", ("parts", "algebra")),
}
"""Cases of the default set, a fault that nothing else there shows, and which kinds show it."""


@pytest.mark.campaign  # of the choice of cases, when it changes
@pytest.mark.parametrize("case", EARNED)
def test_a_case_shows_what_no_other_shows(case: str) -> None:
    fault, kinds = EARNED[case]
    found = seen(floating(fault), SCENE.name, LOOKED_AT)
    assert {(case, kind) for kind in kinds} <= found
    assert {label for label, _ in found} == {case}


@pytest.mark.slow
def test_every_case_shows_something_and_a_right_engine_passes() -> None:
    default = {case.label for case in (*SCENE.cases, *SCENE.placed) if not case.full_only}
    assert default == set(EARNED)
    assert seen(floating(""), SCENE.name, LOOKED_AT) == set()


@pytest.mark.campaign  # `mbcheck check`, which goes before the tests, does the same
@pytest.mark.parametrize("engine", ["mujoco", "exudyn"])
def test_an_engine_passes_what_needs_no_motion(engine: str) -> None:
    pytest.importorskip(engine, exc_type=ImportError)
    checks = plan_cases((*SCENE.cases, *SCENE.placed), [engine], LOOKED_AT)
    found = [result for check in checks for result in run_check(check)]
    assert {result.verdict for result in found} <= {"pass", "skipped"}
    assert sum(result.verdict == "pass" for result in found) >= 9

"""Where a deviation comes from: mistakes are named if they alone explain it, and else none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import pytest

from mbcheck.comparisons.checks.diagnosis import ANOTHER_MODEL
from mbcheck.comparisons.checks.suite import run_check
from mbcheck.comparisons.checks.verdict import Result
from mbcheck.comparisons.faults.catalogue import ENGINES, FAULTS
from mbcheck.comparisons.faults.mujoco import Controlled
from mbcheck.comparisons.faults.reference import Mistaken
from mbcheck.comparisons.faults.runs import (
    Exchanged,
    LateForce,
    LateSamples,
    OtherMethod,
    Resetting,
    Restarting,
    Starting,
)
from mbcheck.comparisons.reports.run.located import located
from mbcheck.reference import get_scene
from mbcheck.reference.speed_regulator.soft import NO_DRIFT
from mbcheck.tests.support.results import changed, result
from mbcheck.tests.support.subjects import Subject, check_of, label, results_of

HOOP = (
    Subject("hula_hoop", "mujoco", "tree", "RK4"),
    Subject("hula_hoop", "exudyn", "kinematic_tree", "RK67"),
    Subject("hula_hoop", "exudyn", "redundant", "GeneralizedAlpha"),
)
"""Published schemes, and a method whose error is predicted from half its step."""

LOOP = Subject("speed_regulator", "mujoco", "connect", "RK4")
ROTORS = Subject("rotor_pendulum", "mujoco", "tree", "RK4")
CASES = {"hula_hoop": "spinning_3hz_60n", "speed_regulator": "rotation"}
MOTIONS = ("step", "trajectory", "order")

MISTAKES: dict[str, tuple[Callable[[Any], Any], tuple[str, ...], str]] = {
    "observables exchanged": (
        lambda engine: Exchanged(engine, "y", "theta"),
        MOTIONS,
        "observables are exchanged: y is theta, theta is y",
    ),
    "samples late": (LateSamples, MOTIONS, "samples are one step late"),
    "force late": (LateForce, ("trajectory", "order"), "the force is one step late"),
    "start ignored": (
        lambda engine: Starting(engine, lambda name: False),
        MOTIONS,
        "the start is ignored: it moves as from the origin, at rest",
    ),
    "rates ignored": (
        lambda engine: Starting(engine, lambda name: not name.endswith("_dot")),
        MOTIONS,
        "the rates of the start are ignored: it moves as from rest",
    ),
    "silent reset": (Resetting, ("trajectory", "order"), "it is reset to the origin between"),
    "silent restart": (Restarting, ("trajectory", "order"), "it is reset to its start at t ="),
}


told_of = partial(results_of, explain=True)


def causes(results: list[Result]) -> set[str]:
    """Return what is named of the results that deviate, "" where nothing is."""
    return {item.cause or "" for item in results if item.verdict == "deviation"}


@pytest.mark.parametrize("name", MISTAKES)
@pytest.mark.parametrize(
    "subject", [*HOOP[:2], pytest.param(HOOP[2], marks=pytest.mark.slow)], ids=label
)
def test_a_mistake_is_named_by_every_kind_that_sees_it(subject: Subject, name: str) -> None:
    make, kinds, words = MISTAKES[name]
    for kind in kinds:
        found = told_of(subject, kind, make(ENGINES[subject.engine]()), CASES[subject.scene])
        (said,) = causes(found)
        assert said.startswith(words), kind
        assert all(item.reason.count(said) == 1 for item in found if item.cause)
    (first, *more) = located(found)
    assert first == f"{subject.engine}: its order of convergence is wrong"
    assert len(more) == 1
    assert more[0].startswith(f"  {words}")


@pytest.mark.slow
def test_of_a_beam_exchanged_observables_are_named() -> None:
    subject = Subject("rotating_beam", "mujoco", "chain", "RK4")
    wrong = Exchanged(ENGINES["mujoco"](), "tip_deflection", "tip_axial")
    late = LateSamples(ENGINES["mujoco"]())  # whose motion would take long to predict
    said = "tip_deflection is tip_axial, tip_axial is tip_deflection"
    case = replace(get_scene("rotating_beam").case("spin_up_quick"), horizon=1.0)
    found = told_of(subject, "trajectory", wrong, case)
    assert causes(found) == {f"observables are exchanged: {said}"}
    assert causes(told_of(subject, "trajectory", late, case)) == {""}


def test_a_force_that_is_held_is_named() -> None:
    """As control loops do it, through MuJoCo's ``ctrl``."""
    for kind in ("trajectory", "order"):
        found = told_of(HOOP[0], kind, Controlled(0.0), CASES["hula_hoop"])
        assert causes(found) == {"the force is constant in each step, as at its start"}


@pytest.mark.parametrize(
    ("kind", "case"), [("stability", "point_mass_3hz_60n"), ("energy", "free_undamped")]
)
def test_orbits_and_energy_name_it_too(kind: str, case: str) -> None:
    wrong = Starting(ENGINES["mujoco"](), lambda name: not name.endswith("_dot"))
    found = told_of(HOOP[0], kind, wrong, case)
    assert causes(found) == {"the rates of the start are ignored: it moves as from rest"}


@pytest.mark.parametrize("kind", ["algebra", *MOTIONS])
def test_a_constraint_without_its_drift_is_named_as_the_loops(kind: str) -> None:
    """MuJoCo up to 3.6; `test_releases` runs that itself."""
    found = told_of(LOOP, kind, Mistaken(ENGINES["mujoco"]()), "rotation")
    assert causes(found) == {NO_DRIFT}
    assert located(found)[1:] == [f"  {NO_DRIFT} (speed_regulator)"]


def test_another_method_than_is_asked_for_is_named() -> None:
    wrong = OtherMethod(ENGINES["exudyn"](), "ExplicitMidpoint")
    subject = HOOP[1]._replace(method="RK44")
    for kind in MOTIONS:
        found = told_of(subject, kind, wrong, CASES["hula_hoop"])
        assert causes(found) == {"its steps are those of ExplicitMidpoint"}


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("platform_stiffness_0.1_percent", "K is off at (x, x), M and C are right"),
        ("no_rod_damping", "C is off at (phi_3, phi_3), M and K are right"),
        ("rod_length_0.1_percent", "M is off, C and K are right"),
    ],
)
def test_frequencies_name_the_matrix(fault: str, words: str) -> None:
    wrong = FAULTS["rotor_pendulum"][fault].make["mujoco"]()
    found = told_of(ROTORS, "frequency", wrong, "modes_at_rest")
    assert causes(found) == {words}


def parameters_off() -> list[Any]:
    """Return all faults that are no mistake of those that are tried; most of them are slow."""
    quick = {("hula_hoop", "mujoco"), ("speed_regulator", "mujoco")}
    redundant = LOOP._replace(engine="exudyn", model="redundant", method="GeneralizedAlpha")
    return [
        pytest.param(subject, name, marks=[pytest.mark.slow][: subject[:2] not in quick])
        for subject in (*HOOP, ROTORS, LOOP, redundant)
        for name, fault in FAULTS[subject.scene].items()
        if name != "force_late_by_one_step" and (not fault.models or subject.model in fault.models)
    ]


@pytest.mark.parametrize(("subject", "name"), parameters_off(), ids=label)
def test_what_is_no_such_mistake_is_never_named_as_one(subject: Subject, name: str) -> None:
    """Masses, lengths and springs that are off, forces too many or too few."""
    wrong = FAULTS[subject.scene][name].make[subject.engine]()
    case = {"rotor_pendulum": "relative_motor"} | CASES
    for kind in ("step", "trajectory"):
        found = told_of(subject, kind, wrong, case[subject.scene])
        assert causes(found) <= {"", ANOTHER_MODEL}


class Counted(Exchanged):
    """Observables exchanged in runs that are counted."""

    count = 0

    def simulate(self, *arguments: Any) -> Any:
        """Count, and exchange."""
        self.count += 1
        return super().simulate(*arguments)


def test_a_cause_is_sought_in_the_run_that_was_measured() -> None:
    """Two short ones more tell whether the engine repeats itself."""
    engine = Counted(ENGINES["mujoco"](), "y", "theta")
    check = check_of(HOOP[0], "trajectory", CASES["hula_hoop"])
    for explain, count in ((False, 1), (True, 3)):
        engine.count = 0
        found = run_check(check, "loose", engine, explain)
        assert "deviation" in {item.verdict for item in found}
        assert engine.count == count


def test_what_passes_has_no_cause() -> None:
    found = run_check(check_of(HOOP[0], "trajectory", CASES["hula_hoop"]))
    assert {item.cause for item in found} == {None}


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("order", "its order of convergence"),
        ("frequency", "its linearised equations of motion"),
        ("energy", "its conservation of invariants"),
        ("stability", "its periodic or long motion"),
    ],
)
def test_every_kind_names_a_level(kind: str, words: str) -> None:
    right = [result(kind="algebra"), result(kind="trajectory")]
    wrong = result(verdict="deviation", kind=kind, quantity="q", error=0.25, reason="by itself")
    first, second = located([*right, wrong])
    sound = "algebra" if kind == "frequency" else "algebra and trajectory"
    assert first == f"mujoco: {words} is wrong, {sound} right"
    assert second == "  RK4 q off by 0.25 rad (hula_hoop)"
    partly = changed(result(kind="algebra", verdict="known"), known="issue 7")
    assert "algebra" not in located([*right, partly, wrong])[0].partition("is wrong")[2]


def test_counted_evaluations_are_located_first() -> None:
    steps = result(verdict="deviation", kind="step", quantity="q", error=0.25)
    reason = "work_count: the engine evaluated forces 8 times, 4 make 1 steps of 4 each"
    counted = result(verdict="error", error=None, kind="trajectory", reason=reason)
    head, *lines = located([steps, counted])
    assert head == "mujoco: a single step from a right state is wrong"
    assert lines == [f"  {reason} (hula_hoop)", "  RK4 q off by 0.25 rad (hula_hoop)"]


@pytest.mark.parametrize(
    ("reason", "traceback", "words"),
    [
        ("clock: it shows 1 s", None, "its clock does not show the requested times"),
        ("step_count: 2 steps", None, "it takes or counts other steps than requested"),
        ("ValueError: no", "Traceback", "it raised an exception"),
        ("branch: turned over", None, "a free run could not be judged"),
    ],
)
def test_a_header_fits_the_errors_below_it(reason: str, traceback: str | None, words: str) -> None:
    wrong = changed(result(verdict="error", error=None, reason=reason), traceback=traceback)
    assert located([wrong])[0] == f"mujoco: {words}"


def test_a_level_that_deviates_and_fails_says_both_and_deviations_first() -> None:
    failed = changed(result(verdict="error", error=None, reason="ValueError: no"), traceback="at")
    wrong = result(verdict="deviation", quantity="q", error=0.25, reason="by itself")
    first, *more = located([failed, wrong])
    assert first == "mujoco: a free run is wrong and it raised an exception"
    assert more == ["  RK4 q off by 0.25 rad (hula_hoop)", "  ValueError: no (hula_hoop)"]

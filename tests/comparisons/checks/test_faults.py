"""Wrong engines are caught by every kind of check that can see what is wrong; right ones pass."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import pytest

from mbcheck.comparisons.checks.suite import run_check
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.faults.catalogue import ENGINES, FAULTS, FLIPPED, Fault, scaled, wrapped
from mbcheck.comparisons.faults.reference import Impostor
from mbcheck.comparisons.faults.runs import Resetting
from mbcheck.tests.support.subjects import Subject, check_of, is_seen, label, results_of

SUBJECTS = (
    Subject("hula_hoop", "mujoco", "tree", "RK4"),
    Subject("hula_hoop", "exudyn", "kinematic_tree", "RK67"),
    Subject("rotor_pendulum", "mujoco", "tree", "RK4"),
    Subject("rotor_pendulum", "exudyn", "kinematic_tree", "RK67"),
    Subject("rotor_pendulum", "exudyn", "redundant", "GeneralizedAlpha"),
    Subject("speed_regulator", "mujoco", "connect", "RK4"),
    Subject("speed_regulator", "exudyn", "redundant", "GeneralizedAlpha"),
    Subject("speed_regulator", "exudyn", "one_dof", "RK44"),
)
"""With the most accurate method of each model whose order can be measured."""

CASES: Mapping[str, Mapping[str, str]] = {
    "hula_hoop": {
        "algebra": "point_mass_3hz_60n",
        "step": "spinning_3hz_60n",
        "trajectory": "spinning_3hz_60n",
        "order": "spinning_3hz_60n",
        "frequency": "rest_rod_across",
        "stability": "point_mass_3hz_60n",
        "energy": "free_undamped",
    },
    "rotor_pendulum": {
        "algebra": "case_2_startup",
        "step": "relative_motor",
        "trajectory": "relative_motor",
        "order": "case_2_startup",
        "frequency": "modes_at_rest",
        "stability": "case_2_synchronous",
        "energy": "conservative",
    },
    "speed_regulator": {
        "algebra": "rotation",
        "step": "rotation",
        "trajectory": "rotation",
        "order": "rotation",
        "frequency": "rest_right",
        "stability": "limit_cycle",
        "energy": "conservative",
    },
}
"""One case for each kind, enough to see a fault. What *parts* sees is in test_plugin."""

BLIND: Mapping[tuple[str, str], set[str]] = {
    # k / M and c_m / (m R^2): the length cancels
    ("hula_hoop", "rod_length_0.1_percent"): {"frequency"},
    # that case has no damping
    ("hula_hoop", "no_hinge_damping"): {"energy"},
    # no force, or no step
    ("hula_hoop", "force_late_by_one_step"): {"algebra", "frequency", "energy"},
    # a constant force moves no mode; Exudyn sees that the state is no rest
    ("hula_hoop", "gravity_along_the_slide"): {"mujoco/frequency"},
    # a rotor on its bearing counts by the part of its mass along its arm, however long that is
    ("rotor_pendulum", "eccentricity_0.1_percent"): {"frequency"},
    # the case of energy has no damping
    ("rotor_pendulum", "no_rod_damping"): {"energy"},
    # modes and energy are looked at with motors and bearings off
    ("rotor_pendulum", "no_friction"): {"frequency", "energy"},
    ("rotor_pendulum", "motor_on_the_other_angle"): {"frequency", "energy"},
    # at rest B is beta
    ("rotor_pendulum", "reduced_equations"): {"frequency"},
    # next to rest the square of a speed is nothing
    ("rotor_pendulum", "no_centrifugal_force_of_the_rod"): {"frequency"},
    ("speed_regulator", "factor_2_lost_in_the_slope_of_inertia"): {"frequency"},
    # the case of energy has no damping
    ("speed_regulator", "no_damping"): {"energy"},
    # half a gram beside the flywheel does less than the steps of a method of order 2
    ("speed_regulator", "rod_mass_0.1_percent"): {"redundant/order", "redundant/energy"},
    # the matrices are those of the mechanism with its loop closed
    ("speed_regulator", "soft_joint_passed_off_as_exact"): {"mujoco/frequency"},
}
"""Kinds (of an engine, of a model) that cannot see a fault, by physics."""

LONG = {
    ("hula_hoop", "free_mass_0.1_percent"),
    ("hula_hoop", "no_hinge_damping"),
    ("rotor_pendulum", "no_rod_damping"),
    ("rotor_pendulum", "motor_on_the_other_angle"),
    ("speed_regulator", "no_damping"),
    ("speed_regulator", "soft_joint_passed_off_as_exact"),
}
"""Faults that are shown to *stability* too: it takes longer than all others together."""


def of(scene: str, *models: str) -> list[Subject]:
    """Return the subjects of a scene, or those with these models."""
    return [item for item in SUBJECTS if item.scene == scene and item.model in (models or item)]


def case_of(subject: Subject, kind: str) -> str:
    """Return the case that shows a kind a fault."""
    return CASES[subject.scene][kind]


def combinations() -> Iterator[Any]:
    """Yield the subjects with the faults that they can have.

    With redundant coordinates those that all kinds are shown are slow, and that which they are
    partly blind to; the others, which the other models of the same engine have by default, are a
    campaign.
    """
    for subject in SUBJECTS:
        for name, fault in FAULTS[subject.scene].items():
            key, marks = (subject.scene, name), []
            if subject.model == "redundant":
                few = key in LONG or key == ("speed_regulator", "rod_mass_0.1_percent")
                marks = [pytest.mark.slow if few else pytest.mark.campaign]
            if not fault.models or subject.model in fault.models:
                yield pytest.param(subject, name, marks=marks)


@pytest.mark.parametrize(("subject", "fault"), list(combinations()), ids=label)
def test_every_kind_that_can_see_a_fault_does(subject: Subject, fault: str) -> None:
    wrong = FAULTS[subject.scene][fault].make[subject.engine]()
    blind = BLIND.get((subject.scene, fault), set())
    seen = {}
    for kind in CASES[subject.scene]:
        if kind == "stability" and (subject.scene, fault) not in LONG:
            continue
        seen[kind] = is_seen(results_of(subject, kind, wrong, case_of(subject, kind)))
    assert seen == {
        kind: not blind & {kind, f"{subject.engine}/{kind}", f"{subject.model}/{kind}"}
        for kind in seen
    }


@pytest.mark.parametrize(
    ("subject", "kind"),
    [(subject, kind) for subject in SUBJECTS for kind in CASES[subject.scene]],
    ids=label,
)
def test_a_right_engine_passes_under_the_strict_profile(subject: Subject, kind: str) -> None:
    results = run_check(check_of(subject, kind, case_of(subject, kind)), "strict")
    assert {item.verdict for item in results} == {"pass"}


@pytest.mark.parametrize(
    ("engine", "method"),
    [(name, item.name) for name in ENGINES for item in get_engine(name).methods],
)
def test_no_method_hides_a_late_force_behind_its_own_error(engine: str, method: str) -> None:
    model = get_engine(engine).models("hula_hoop")[0]
    subject = Subject("hula_hoop", engine, model, method)
    check = check_of(subject, "trajectory", case_of(subject, "trajectory"))
    if check.unsupported_reason:
        pytest.skip(check.unsupported_reason)
    late = FAULTS["hula_hoop"]["force_late_by_one_step"]
    assert not is_seen(run_check(check))
    assert is_seen(run_check(check, engine=late.make[engine](), explain=False))


@pytest.mark.parametrize("subject", of("rotor_pendulum"), ids=label)
def test_an_impostor_with_the_right_equations_passes(subject: Subject) -> None:
    """Else it would be caught for its methods."""
    impostor = Impostor(ENGINES[subject.engine](), lambda scene: scene)
    for kind in ("algebra", "trajectory", "frequency", "energy"):
        assert {
            item.verdict for item in results_of(subject, kind, impostor, case_of(subject, kind))
        } == {"pass"}


@pytest.mark.parametrize("subject", of("speed_regulator", *FLIPPED), ids=label)
def test_a_mechanism_put_together_the_other_way_round_is_an_error(subject: Subject) -> None:
    wrong = FLIPPED[subject.model]()
    for kind in ("trajectory", "order", "energy", "stability"):
        results = results_of(subject, kind, wrong, case_of(subject, kind))
        assert {item.verdict for item in results} == {"error"}
        assert results[0].reason.startswith("branch:")
    assert is_seen(results_of(subject, "algebra", wrong, case_of(subject, "algebra")))


@pytest.mark.parametrize(
    ("case", "fault", "outcome"),
    [
        ("settles_to_rest", scaled("torque", 2.0), "rotation"),
        ("settles_to_rotation", scaled("damping", 5.0), "rest"),
        ("settles_to_rotation", wrapped(Resetting), "undecided"),
        ("case_2_settles", wrapped(Resetting), "not synchronised"),
    ],
)
@pytest.mark.parametrize("engine", ENGINES)
def test_a_run_that_ends_in_another_motion_deviates(
    engine: str, case: str, fault: Fault, outcome: str
) -> None:
    scene = "rotor_pendulum" if case == "case_2_settles" else "speed_regulator"
    subject = next(item for item in of(scene) if item.engine == engine)
    (result,) = results_of(subject, "stability", fault.make[engine](), case)
    assert result.verdict == "deviation"
    assert f"the engine is {outcome!r}" in result.reason

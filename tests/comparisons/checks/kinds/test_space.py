"""Bodies in space: right engines pass, and what engines have got wrong there is named."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mbcheck.comparisons.checks.comparison import Part
from mbcheck.comparisons.checks.kinds.energy import sensor_gaps
from mbcheck.comparisons.checks.mistakes.motions import explanation, with_expected
from mbcheck.comparisons.checks.suite import plan_cases, run_check
from mbcheck.comparisons.engines.adapter import adapt
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.faults.catalogue import scaled
from mbcheck.comparisons.faults.exudyn import ExudynAdapter, ReboundExudyn, Rebuilt
from mbcheck.comparisons.reports.run.located import located
from mbcheck.examples.mujoco_engine import MujocoPlugin
from mbcheck.models import exudyn_mjcf
from mbcheck.reference import get_scene
from mbcheck.reference.body.rotation import central_inertia
from mbcheck.reference.equations import ModelEquations
from mbcheck.reference.quaternions import matrix
from mbcheck.reference.scene import Case
from mbcheck.tests.support.draws import case_near, some_are_slow
from mbcheck.tests.support.engines.floating import floating
from mbcheck.tests.support.engines.sliding import sliding
from mbcheck.tests.support.engines.turning import Turning, turning
from mbcheck.tests.support.example import by_quantity, seen

SLOW, CAMPAIGN = pytest.mark.slow, pytest.mark.campaign


class Space(NamedTuple):
    """A scene: its engine with a fault, a case that shows most, the model, and kinds of check."""

    make: Callable[[str], Any]
    case: str
    model: str
    kinds: tuple[str, ...]


SPACE: Mapping[str, Space] = {
    "rigid_body": Space(
        turning, "heavy_tumbling", "ball", ("parts", "algebra", "trajectory", "frequency")
    ),
    "ball_hoop": Space(sliding, "weighed", "ball", ("parts", "algebra", "trajectory", "frequency")),
    "floating_platform": Space(floating, "tumbling", "free", ("parts", "algebra", "frequency")),
    "floating_beam": Space(floating, "tumbling", "free", ("parts", "algebra", "step", "frequency")),
}


def results(scene: str, engine: Any, kind: str, case: str | Case | None = None) -> dict[str, Any]:
    """Return the results of a kind of check of an engine, or of one with a fault, by quantity."""
    space, known = SPACE[scene], get_scene(scene)
    case = case if isinstance(case, Case) else known.case(case or space.case)
    engine = space.make(engine) if isinstance(engine, str) else engine
    return by_quantity(adapt("tried", engine), kind, case, space.model)


FAULTS: Mapping[str, list[tuple[str, str, str, str]]] = {
    "rigid_body": [
        ("gyroscopic_lost", "parts", "gyroscopic.body", "gyroscopic term of body: dropped"),
        ("gyroscopic_sign", "parts", "gyroscopic.body", "its sign is reversed"),
        ("products", "parts", "products.body", "products of inertia of body: dropped"),
        ("gravity_sign", "parts", "gravity", "gravity: its sign is reversed"),
        ("gravity_size", "parts", "gravity", "gravity: counted 1.01 times"),
        ("gyroscopic_lost", "algebra", "accelerations", "term omega x (J omega) is lost"),
        ("gyroscopic_sign", "algebra", "accelerations", "has the wrong sign"),
        ("standing_tensor", "algebra", "accelerations", "tensor does not turn with the body"),
        ("products", "algebra", "accelerations", "products of inertia are dropped"),
        ("gravity_sign", "algebra", "accelerations", "gravity has the wrong sign"),
        ("gravity_frame", "algebra", "accelerations", "gravity turns with the body"),
        ("gravity_frame", "parts", "unexplained", "gravity turns with the body"),
    ],
    "ball_hoop": [
        ("gyroscopic_of_centre", "parts", "gyroscopic.body", "gyroscopic term of body: dropped"),
        ("products", "parts", "products.body", "products of inertia of body: dropped"),
        ("gravity_sign", "parts", "gravity", "gravity: its sign is reversed"),
        ("friction_lost", "parts", "damper.q", "damper of q: dropped"),
        ("gyroscopic_lost", "algebra", "accelerations", "term omega x (J omega) is lost"),
        ("products", "algebra", "accelerations", "products of inertia are dropped"),
        ("coupling_lost", "algebra", "accelerations", "inertia that couples slide and ball joint"),
        ("coupling_lost", "algebra", "mass_matrix", "inertia that couples slide and ball joint"),
        ("pull_lost", "algebra", "accelerations", "turning body does not pull at the slide"),
        ("slide_in_body", "algebra", "accelerations", "is taken in the frame of the body"),
        ("transport_lost", "algebra", "accelerations", "moving joint lacks v x p"),
        ("gravity_sign", "algebra", "accelerations", "gravity has the wrong sign"),
    ],
    "floating_platform": [
        ("gyroscopic_lost", "parts", "gyroscopic.body", "gyroscopic term of body: dropped"),
        ("products", "parts", "products.body", "products of inertia of body: dropped"),
        ("products", "algebra", "mass_matrix", "products of inertia are dropped"),
        ("reaction_lost", "algebra", "accelerations", "does not bear the reactions of torques"),
        ("reaction_in_world", "algebra", "accelerations", "hinges act along axes of the world"),
        ("spin_lost", "algebra", "accelerations", "spin on hinges lack their gyroscopic moments"),
        ("coriolis_lost", "algebra", "accelerations", "turning platform lack Coriolis's force"),
        ("coupling_lost", "algebra", "accelerations", "inertia that couples platform and hinges"),
        ("coupling_lost", "algebra", "mass_matrix", "inertia that couples platform and hinges"),
        ("velocity_of_centre", "algebra", "accelerations", "of the platform's centre of mass"),
        ("velocity_in_body", "algebra", "accelerations", "those in the frame of the platform"),
        (
            "from_file",
            "algebra",
            "accelerations",
            "right for the model as in its file, and wrong for",
        ),
    ],
    "floating_beam": [
        ("axes_as_opened", "algebra", "accelerations", "axes of hinges do not turn with"),
        ("axes_as_opened", "algebra", "mass_matrix", "axes of hinges do not turn with"),
        ("axes_still", "algebra", "accelerations", "hinges cause by turning the axes beyond them"),
        ("reaction_lost", "algebra", "accelerations", "the hub does not bear the reactions of"),
        ("coriolis_lost", "algebra", "accelerations", "turning hub lack Coriolis's force"),
        ("coupling_lost", "algebra", "mass_matrix", "that couples hub and hinges is lost"),
    ],
}
"""Of each scene: fault, kind and quantity that show it, and what is said."""


@pytest.mark.parametrize(
    ("scene", "fault", "kind", "quantity", "words"),
    [(scene, *row) for scene, rows in FAULTS.items() for row in rows],
)
def test_a_fault_is_named(scene: str, fault: str, kind: str, quantity: str, words: str) -> None:
    case = get_scene(scene).placed[0] if fault == "from_file" else None
    result = results(scene, fault, kind, case)[quantity]
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
    kinds = ("parts", "algebra")
    found = [one for kind in kinds for one in results("rigid_body", fault, kind).values()]
    assert located(found)[1:] == [f"  {line}"]


def test_a_part_that_does_not_act_is_named() -> None:
    """Of a free top, which is accelerated by its gyroscopic term alone."""
    found = results("rigid_body", "", "parts", "free_euler")
    reasons = [one.reason for one in found.values() if one.verdict == "skipped"]
    assert reasons == [
        f"{name} has too small an effect to be separated from round-off"
        for name in ("coriolis", "gravity")
    ]


@pytest.mark.parametrize(
    ("scene", "case"), [("floating_beam", "planar"), ("floating_platform", "")]
)
@pytest.mark.parametrize("fault", ["axes_as_opened", "axes_still"])
def test_parallel_axes_and_hinges_side_by_side_do_not_show_it(
    fault: str, scene: str, case: str
) -> None:
    assert {one.verdict for one in results(scene, fault, "algebra", case).values()} == {"pass"}


@pytest.mark.parametrize("kind", ["parts", "algebra"])
@pytest.mark.parametrize("has_mass_matrix", [True, False])
@pytest.mark.parametrize("scene", SPACE)
def test_a_right_engine_passes(scene: str, kind: str, has_mass_matrix: bool) -> None:
    engine = SPACE[scene].make("")
    engine.has_mass_matrix = has_mass_matrix
    verdicts = {result.verdict for result in results(scene, engine, kind).values()}
    assert verdicts <= {"pass", "skipped"}
    assert "pass" in verdicts


@pytest.mark.parametrize("seed", some_are_slow(range(40)))
@pytest.mark.parametrize("scene", ["ball_hoop", "floating_platform", "floating_beam"])
def test_it_passes_with_other_parameters(scene: str, seed: int) -> None:
    case = case_near(get_scene(scene).case(SPACE[scene].case), seed)
    for kind in ("parts", "algebra"):
        found = results(scene, "", kind, case).values()
        assert {one.verdict for one in found} <= {"pass", "skipped"}


STEPS: Mapping[str, tuple[tuple[str, ...], dict[str, str]]] = {
    "rigid_body": (
        ("R_xx", "omega_x"),
        {
            "world_update": "turned by rates of the world's frame",
            "world_rates": "rates are those of the world's frame",
            "other_sign": "",
        },
    ),
    "ball_hoop": (
        ("R_xx", "y"),
        {
            "world_update": "turned by rates of the world's frame",
            "world_rates": "rates are those of the world's frame",
            "transport_lost": "moving joint lacks v x p",
            "other_sign": "",
        },
    ),
    "floating_platform": (
        ("x",),
        {
            "velocity_of_centre": "velocity is that of the platform's centre of mass",
            "world_update": "turned by rates of the world's frame",
            "reaction_lost": "does not bear the reactions of torques at hinges",
        },
    ),
    "floating_beam": (
        ("theta_3",),
        {"axes_still": "hinges cause by turning the axes beyond them"},
    ),
}
"""Quantities of a step, and what is said of each fault; nothing of a right engine."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene", "fault"), [(scene, fault) for scene in STEPS for fault in ("", *STEPS[scene][1])]
)
def test_a_step_tells_what_is_wrong(scene: str, fault: str) -> None:
    """Of velocities, rates and forces one each; `FAULTS` names the others by their equations."""
    quantities, said = STEPS[scene]
    words, found = said.get(fault, ""), results(scene, fault, "step")
    assert {found[name].verdict for name in quantities} == {"deviation" if words else "pass"}
    assert words in found[quantities[0]].reason


MOMENTA = {f"{kind}momentum_{axis}_drift" for kind in ("", "linear_") for axis in "xyz"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene", "fault", "case", "names"),
    [
        # what brakes a platform against the world, as no force between bodies does, shows there
        *(("floating_platform", fault, "tumbling", MOMENTA) for fault in ("", "dragged")),
        # also while a force drives the slide and a damper brakes it
        *(("ball_hoop", fault, "driven", {"momentum_drift"}) for fault in ("", "slide_in_body")),
    ],
)
def test_momenta_are_looked_at_while_a_drive_acts(
    scene: str, fault: str, case: str, names: set[str]
) -> None:
    found = results(scene, fault, "energy", case)
    assert set(found) == names
    assert {one.verdict for one in found.values()} == {"deviation" if fault else "pass"}


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["", "axes_still", "axes_as_opened"])
def test_momenta_and_energy_are_looked_at(fault: str) -> None:
    """Momenta are conserved by any accelerations that a force between bodies makes."""
    case = replace(get_scene("floating_beam").case("conservative"), horizon=0.125)
    found = results("floating_beam", fault, "energy", case)
    assert len(found) == 7
    assert ("deviation" in {one.verdict for one in found.values()}) == bool(fault)


@pytest.mark.slow
@pytest.mark.parametrize(("fault", "verdict"), [("", "pass"), ("order_two", "deviation")])
def test_the_order_of_the_free_joint_is_looked_at(fault: str, verdict: str) -> None:
    """Hinges by themselves would keep the fourth."""
    case = replace(get_scene("floating_platform").case("conservative"), horizon=0.0625)
    assert results("floating_platform", fault, "order", case)["order"].verdict == verdict


@pytest.mark.slow
@pytest.mark.parametrize(("fault", "slope"), [("", 4), ("order_two", 2)])
def test_an_order_that_drops_on_a_ball_joint_is_seen(fault: str, slope: int) -> None:
    found = results("rigid_body", fault, "order")
    assert found["order"].value == pytest.approx(slope, abs=0.1)
    assert found["order"].verdict == ("pass" if slope == 4 else "deviation")
    assert found["extrapolated"].verdict == "pass"


def test_a_quaternion_that_loses_its_length_is_an_error() -> None:
    found = results("rigid_body", "not_normalised", "trajectory")
    assert {one.verdict for one in found.values()} == {"error"}
    assert "a quaternion has the length 1.00" in found["R_xx"].reason


@pytest.mark.parametrize("scene", SPACE)
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


TOLD_OUTSIDE = "rates are those of the world's frame, in its results"


def test_rates_that_are_told_outside_explain_a_run() -> None:
    engine, numbers = adapt("out", Outside()), np.arange(1, 4)
    tumbling = get_scene("rigid_body").case("heavy_tumbling")
    setup = Setup(engine, tumbling, "ball", engine.methods[0])
    values = setup.simulate(setup.default_step, numbers).matrix(setup.scene.observables)
    runs = with_expected(setup, setup.default_step, [Part(tumbling, numbers)], values)
    assert explanation(runs) == TOLD_OUTSIDE


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["step", "trajectory"])
def test_rates_that_are_told_outside_are_named(kind: str) -> None:
    found = [one for one in results("rigid_body", Outside(), kind).values() if one.cause]
    assert {one.cause for one in found} == {TOLD_OUTSIDE}
    assert {one.quantity for one in found} >= {"omega_x", "omega_y", "omega_z"}


# Exudyn's models


def tilted_last(p: Any) -> tuple[float, ...]:
    """Return the angles of the rod turned by its tilt and its angle in the wrong order."""
    turn = Rotation.from_euler("ZX", [p.installation_angle, p.tilt])
    return tuple(turn.as_euler("XYZ").tolist())


def central_moments(p: Any) -> tuple[float, ...]:
    """Return the moments of inertia of the body without its products."""
    return (*np.diag(central_inertia(p)).tolist(), 0.0, 0.0, 0.0)


ON_HUB: Mapping[tuple[str, str], Any] = {
    (f"joint:theta_{k}", "stiffness"): lambda p: p.springs[0] for k in (2, 3)
}
"""The springs of a chain that are all those of the clamp."""


def rebound(bindings: Mapping[tuple[str, str], Any]) -> ExudynAdapter:
    """Return Exudyn with other values in the MJCF that its models are built from."""
    return ExudynAdapter(ReboundExudyn(bindings))


def exudyn(name: str, factor: float = 1.001) -> Callable[[], Any]:
    """Return what makes Exudyn with a parameter multiplied."""
    return scaled(name, factor).make["exudyn"]


BUILT: list[tuple[str, Callable[[], Any], str, str, str]] = [
    ("floating_platform", exudyn("mass"), "tumbling", "algebra", ""),
    ("floating_platform", exudyn("eccentricity"), "tumbling", "algebra", ""),
    ("floating_platform", exudyn("motor_slope"), "tumbling", "algebra", ""),
    ("floating_platform", exudyn("rod_stiffness"), "afloat", "frequency", "K is off at"),
    ("floating_platform", exudyn("rod_damping", 1.01), "afloat", "frequency", "C is off at"),
    ("floating_platform", exudyn("gravity_z", -1.0), "falling", "algebra", ""),
    (
        "floating_platform",
        lambda: rebound({("body:body/inertial", "fullinertia"): central_moments}),
        "tumbling", "algebra", "products of inertia are dropped",
    ),
    (
        "floating_platform", lambda: rebound({("body:rod", "euler"): tilted_last}),
        "tumbling", "algebra", "",
    ),
    (
        "floating_platform",
        lambda: ExudynAdapter(Rebuilt(exudyn_mjcf, world_axes=lambda placement: np.eye(3))),
        "falling+turned-1", "algebra",
        "right for the model as in its file, and wrong for the same model rotated in space",
    ),
    ("floating_beam", exudyn("tip_mass"), "tumbling", "algebra", ""),
    (
        "floating_beam",
        lambda: rebound({("body:rod_3", "euler"): lambda p: (-p.twist, 0, 0)}),
        "tumbling", "algebra", "",
    ),
    (
        "floating_beam", lambda: rebound(ON_HUB),
        "afloat", "frequency", "K is off at (theta_2, theta_2) and (theta_3, theta_3)",
    ),
]  # fmt: skip
"""Scenes, wrong Exudyn models, the case and the kind of check that show it, and what is said."""


@pytest.mark.parametrize(("scene", "make", "label", "kind", "words"), BUILT)
def test_what_is_wrong_in_the_exudyn_model_shows(
    scene: str, make: Callable[[], Any], label: str, kind: str, words: str
) -> None:
    pytest.importorskip("exudyn", exc_type=ImportError)
    known = get_scene(scene)
    (case,) = (one for one in (*known.cases, *known.placed) if one.label == label)
    (check,) = plan_cases([case], ["exudyn"], [kind], full=True)
    found = [one for one in run_check(check, engine=make()) if one.verdict != "pass"]
    assert {one.verdict for one in found} == {"deviation"}
    assert any(words in one.reason for one in found)


# What each case is for


class Principal(MujocoPlugin):
    """MuJoCo that takes the principal axes of a body on a free joint to be the body's."""

    def at(self, system: Any, *state: Any) -> Any:
        text = system.mjcf
        if "<freejoint" in text:
            text = re.sub(r'(<inertial [^>]*?) quat="[^"]*"', r"\1", text)
        return super().at(replace(system, mjcf=text), *state)


EARNED: Mapping[str, Mapping[str, tuple[Any, tuple[str, ...]]]] = {
    "rigid_body": {
        "heavy_tumbling": ("parallel_axes", ("parts", "algebra", "trajectory")),
        "heavy_tumbling+turned-1": ("world_attitude", ("parts", "algebra")),
        "free_euler": (Principal(), ("parts", "algebra", "trajectory")),
        "intermediate_axis": ("coarse_tolerance", ("trajectory",)),
        "lagrange_top": ("largest_rate", ("trajectory",)),
        "rest_hanging": ("weight_that_stands", ("frequency",)),
    },
    "ball_hoop": {
        "weighed": ("coupling_lost", ("parts", "algebra", "trajectory")),
        "weighed+turned-1": ("slide_in_world", ("parts", "algebra")),
        "hanging": ("inertia_as_opened", ("frequency",)),
    },
    "floating_platform": {
        "tumbling": ("reaction_of_motor_lost", ("algebra",)),
        "afloat": ("inertia_as_opened", ("frequency",)),
        "falling+turned-1": ("from_file", ("parts", "algebra")),
    },
    "floating_beam": {
        "tumbling": ("world_update", ("step",)),
        "afloat": ("inertia_as_opened", ("frequency",)),
        "tumbling+turned-1": ("from_file", ("parts", "algebra")),
    },
}
"""Cases of the default set, a fault that nothing else there shows, and which kinds show it."""

MARKS = {"rigid_body": [CAMPAIGN], "floating_beam": [CAMPAIGN], "ball_hoop": [SLOW]}
"""How long they take; campaigns are of the choice of cases, when it changes."""


@pytest.mark.parametrize(
    ("scene", "case"),
    [
        pytest.param(scene, case, marks=MARKS.get(scene, []))
        for scene, cases in EARNED.items()
        for case in cases
    ],
)
def test_a_case_shows_what_no_other_shows(scene: str, case: str) -> None:
    """On ball joints but the same case placed otherwise, and frequencies, which tell no cause."""
    fault, kinds = EARNED[scene][case]
    space = SPACE[scene]
    found = seen(space.make(fault) if isinstance(fault, str) else fault, scene, space.kinds)
    wanted = {(case, kind) for kind in kinds}
    assert wanted <= found
    others = {place for place in found - wanted if place[0] != case or space.model == "ball"}
    if space.model == "ball":
        others = {one for one in others if not one[0].startswith(f"{case}+")}
        others = {one for one in others if one[1] != "frequency"}
    assert not others


@pytest.mark.parametrize("scene", SPACE)
def test_every_case_shows_something(scene: str) -> None:
    known = get_scene(scene)
    default = {case.label for case in (*known.cases, *known.placed) if not case.full_only}
    assert default == set(EARNED[scene])


@pytest.mark.parametrize(
    ("scene", "engine"),
    [
        pytest.param("rigid_body", turning(""), marks=SLOW),
        ("rigid_body", MujocoPlugin()),
        ("ball_hoop", sliding("")),
        ("floating_platform", floating("")),
        pytest.param("floating_beam", floating(""), marks=SLOW),
    ],
)
def test_right_engines_pass_all_cases(scene: str, engine: Any) -> None:
    assert seen(engine, scene, SPACE[scene].kinds) == set()


@pytest.mark.parametrize("told", [0.0, 1e-18, 1e-3])
def test_a_momentum_that_is_zero_may_be_told(told: float) -> None:
    """In a plane it is 0 but for rounding, and has no size to which it could be related."""
    scene = get_scene("floating_platform")
    case = replace(scene.case("planar"), state={})
    setup = Setup(adapt("right", floating("")), case, "free", None)
    values = {name: np.zeros(2) for name in scene.state_names}
    values |= {"q_w": np.ones(2), "theta_dot": np.full(2, 10.0), "momentum_x": np.full(2, told)}
    assert sensor_gaps(setup, 1e-3, values)["momentum_x"] == pytest.approx(told, abs=1e-15)

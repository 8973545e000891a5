"""Elements against their own equations: what they see, and right ones that were called wrong."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import pytest

from mbcheck.comparisons.check.custom import custom_case
from mbcheck.comparisons.checks.comparison import conclusion
from mbcheck.comparisons.checks.free_vibrations import excitation
from mbcheck.comparisons.checks.suite import checks_of, run_check
from mbcheck.comparisons.checks.verdict import Finding, Inconclusive, Result
from mbcheck.comparisons.engines.adapter import Adapter
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.faults.catalogue import ENGINES, scaled
from mbcheck.comparisons.faults.exudyn import ExudynAdapter, OtherItems, Rebuilt
from mbcheck.comparisons.faults.runs import Starting
from mbcheck.comparisons.faults.variants import Misread
from mbcheck.models.exudyn_system import items
from mbcheck.models.rotating_beam import exudyn_model
from mbcheck.reference.rotating_beam import SCENE
from mbcheck.reference.rotating_beam.parameters import RotatingBeam
from mbcheck.tests.support.subjects import is_seen

METHOD = "GeneralizedAlpha"
SLOW, CAMPAIGN = pytest.mark.slow, pytest.mark.campaign


def rebuilt(kind: str, name: str, factor: float) -> Callable[[], Adapter]:
    """Return how Exudyn is made with one number of its elements multiplied."""

    def made(**values: Any) -> Any:
        return getattr(items, kind)(**{**values, name: factor * values[name]})

    return lambda: ExudynAdapter(Rebuilt(exudyn_model, items=OtherItems(**{kind: made})))


EXACT, ANCF = "ObjectBeamGeometricallyExact2D", "ObjectANCFCable2D"
SMALL = 1 + 1e-5

FAULTS: Mapping[str, tuple[str, Callable[[], Adapter]]] = {
    "rotary_inertia_twice": ("geometrically_exact", rebuilt(EXACT, "crossSectionInertia", 2)),
    "shear_stiffness_10_percent": ("geometrically_exact", rebuilt(EXACT, "shearStiffness", 1.1)),
    "mass_per_length_1e-5": ("geometrically_exact", rebuilt(EXACT, "massPerLength", SMALL)),
    "cable_mass_per_length_1e-5": ("ancf", rebuilt(ANCF, "massPerLength", SMALL)),
    "cable_bending_stiffness_1e-5": ("ancf", rebuilt(ANCF, "bendingStiffness", SMALL)),
    "cable_axial_stiffness_0.1_percent": ("ancf", rebuilt(ANCF, "axialStiffness", 1.001)),
    "angular_speed_1e-5": ("ancf", scaled("angular_speed", SMALL).make["exudyn"]),
}

BLIND: Mapping[str, set[str]] = {
    # both beams shorten in the same way as they bend, and stretch by 1e-5 as they turn
    "cable_axial_stiffness_0.1_percent": {"frequency"},
    # frequencies are asked for at a speed
    "angular_speed_1e-5": {"frequency"},
    # the tip moves by 4e-6 of its deflection, of which the extrapolated step leaves 3e-6 open
    "shear_stiffness_10_percent": {"trajectory"},
}
"""Kinds that cannot see a fault."""


def results(kind: str, element: str, engine: Adapter | None, profile: str) -> list[Result]:
    """Return what a kind says of six elements."""
    name = "spin_up_quick"
    if kind == "frequency":
        name = "steady_4" if element == "ancf" else "steady_4_geometrically_exact"
    case = SCENE.case(name)
    p = case.parameters
    if kind != "frequency":
        p = p.replace(element=element, segments=6)
    (check,) = (
        check
        for check in checks_of(kind, replace(case, parameters=p), "exudyn")
        if check.method is None or check.method.name == METHOD
    )
    return run_check(check, profile, engine, explain=False)


def seen(kind: str, fault: str) -> bool:
    """Return whether a kind sees a fault."""
    element, make = FAULTS[fault]
    return is_seen(results(kind, element, make(), "loose"))


@pytest.mark.parametrize("fault", FAULTS)
def test_frequencies_see_one_number_of_an_element(fault: str) -> None:
    assert seen("frequency", fault) == ("frequency" not in BLIND.get(fault, set()))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["algebra", "trajectory"])
@pytest.mark.parametrize("fault", FAULTS)
def test_accelerations_and_runs_see_one_number_of_an_element(fault: str, kind: str) -> None:
    assert seen(kind, fault) == (kind not in BLIND.get(fault, set()))


@pytest.mark.parametrize(
    ("element", "kind"),
    [
        *(pytest.param("ancf", kind, marks=SLOW) for kind in ("algebra", "step", "trajectory")),
        *(pytest.param("geometrically_exact", k, marks=SLOW) for k in ("algebra", "trajectory")),
        pytest.param("geometrically_exact", "step", marks=CAMPAIGN),
    ],
)
def test_six_right_elements_pass(element: str, kind: str) -> None:
    """They are too few to be extrapolated, and need not be."""
    verdicts = {item.verdict for item in results(kind, element, None, "strict")}
    assert verdicts - {"skipped"} == {"pass"}


@pytest.mark.slow
def test_accelerations_see_1e_5_of_the_pulse() -> None:
    """A run shows half as much again as it grants, a single step nothing: their steps err more."""
    (check,) = checks_of("algebra", SCENE.case("weighed"), "exudyn")
    wrong = scaled("torque_amplitude", SMALL).make["exudyn"]()
    found = {item.quantity: item for item in run_check(check, "loose", wrong)}
    assert found["mass_matrix"].verdict == "pass"
    off = found["accelerations"]
    assert off.error is not None
    assert off.tolerance is not None
    assert off.error > 1000 * off.tolerance


def unmoved(p: RotatingBeam) -> RotatingBeam:
    """Put the clamp of a hub that a torque drives on its axis."""
    return p if p.drive == "prescribed" else p.replace(hub_radius=0.0)


@pytest.mark.parametrize("engine", ["mujoco", "exudyn"])
def test_only_weighed_shows_that_a_torque_moves_the_clamp(engine: str) -> None:
    """Of the default set: the hub of all frequencies is prescribed, and that of the other runs on
    its axis.
    """
    wrong = Misread(ENGINES[engine](), unmoved)
    (check,) = (
        one for one in checks_of("algebra", SCENE.case("weighed"), engine) if one.default_model
    )
    assert is_seen(run_check(check, "loose", wrong))
    drives = {
        (one.name, one.parameters.hub_radius > 0)
        for one in SCENE.cases
        if one.parameters.drive == "torque" and not one.full_only
    }
    assert drives == {("pulse_quick", False), ("weighed", True)}


KEPT: Mapping[str, Callable[[str], bool]] = {
    "shape": lambda name: name.startswith("theta"),
    "rates_of_the_shape": lambda name: name.startswith("theta") or not name.endswith("_dot"),
    "speed_of_the_hub": lambda name: name != "theta_dot",
}
"""What an engine ignores of a start, and which of its values it keeps."""


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["mujoco", "exudyn"])
@pytest.mark.parametrize("values", KEPT)
def test_a_step_sees_a_bent_turning_start_that_is_ignored(values: str, engine: str) -> None:
    wrong = Starting(ENGINES[engine](), KEPT[values])
    (check,) = (
        one
        for one in checks_of("step", SCENE.case("spin_up_quick"), engine)
        if one.default_model and not one.full_only
    )
    assert is_seen(run_check(check, "loose", wrong))


def shaking() -> Setup:
    """Return Exudyn's straight beam where a torque begins at once, with a mass inside the beam."""
    p = SCENE.case("turning").parameters.replace(
        hub_radius=0.46, mass=0.3, mass_position=0.877, torque_period=1.795
    )
    case = replace(SCENE.case("turning"), parameters=p, state={"theta_dot": 1.66}, horizon=0.125)
    (check,) = (
        one
        for one in checks_of("trajectory", case, "exudyn")
        if one.method is not None and one.method.name == METHOD
    )
    return check.setup()


def test_steps_follow_fewer_of_the_vibrations_that_a_sudden_torque_shakes() -> None:
    """What they do not follow falls more slowly than the step's square, most of all in speeds."""
    setup = shaking()
    place = setup.scene.observables.index("tip_deflection")
    lost = [excitation(setup, h, 1.0) for h in (2.0**-9, 2.0**-12)]
    assert lost[1].omega / lost[0].omega == pytest.approx(4, rel=0.3)
    deflection, speed = (lost[0].amplitudes / lost[1].amplitudes)[place : place + 2]
    assert 1 < speed < deflection < 64
    assert speed < 20
    assert excitation(setup, 1e-9, 1.0).omega == float("inf")
    assert not any(excitation(setup, 1e-9, 1.0).amplitudes)
    whole = max(lost[0].amplitudes[place : place + 2])
    bent = setup.with_case(SCENE.case("turning"))
    assert max(excitation(bent, 2.0**-9, 1.0).amplitudes[place : place + 2]) < 0.2 * whole


def test_what_may_vanish_with_the_step_is_called_neither_right_nor_wrong() -> None:
    finding, shaken = Finding("theta", "rad", 1.0, 1.1, 0.1, 0.01), "the start shakes it"
    assert isinstance(conclusion(finding, 0.05, shaken), Inconclusive)
    assert isinstance(conclusion(replace(finding, error=0.009), 0.05, shaken), Inconclusive)
    assert conclusion(finding, 0.01, shaken) is finding  # more than halving the step can explain
    assert isinstance(conclusion(replace(finding, error=0.005), 0.05, shaken), Finding)
    assert conclusion(finding, 0.05, "") is finding


@pytest.mark.slow
def test_a_torque_that_begins_at_once_is_no_defect_of_the_engine() -> None:
    """A variation of `turning`: speeds were 3,700 tolerances off, halved steps said nothing."""
    setup = shaking()
    (check,) = (
        one for one in checks_of("trajectory", setup.case, "exudyn") if one.method == setup.method
    )
    found = {item.quantity: item for item in run_check(check, "strict")}
    assert {item.verdict for item in found.values()} == {"pass", "skipped"}
    assert "the initial state excites modes above" in found["tip_deflection_dot"].reason


@pytest.mark.slow
@pytest.mark.parametrize(("engine", "method"), [("mujoco", "RK4"), ("exudyn", METHOD)])
def test_a_beam_may_start_bent_in_the_midst_of_a_pulse(engine: str, method: str) -> None:
    """Unstretched elements were full of waves, which GeneralizedAlpha damps: 12,000 tolerances."""
    found = [
        item
        for check in checks_of("trajectory", SCENE.case("turning"), engine)
        if check.default_model and check.method is not None and check.method.name == method
        for item in run_check(check, "strict")
    ]
    assert {item.verdict for item in found} == {"pass"}


OFF_THE_GRID: Mapping[str, Mapping[str, Any]] = {
    "ramp": {"ramp_time": 0.7, "angular_speed": 1.0, "segments": 6},
    "pulse": {"drive": "torque", "torque_period": 0.7, "torque_amplitude": 5.0, "segments": 6},
}
"""Drives that end between steps of a power of two, of few elements."""


PLACES = [
    (name, kind, *by)
    for name in OFF_THE_GRID
    for kind in ("parts", "step", "trajectory")
    for by in (("mujoco", "RK4"), ("exudyn", METHOD))
]


@pytest.mark.parametrize(
    ("name", "kind", "engine", "method"),
    [
        pytest.param(*place, marks=CAMPAIGN if place[:3] == ("pulse", "parts", "mujoco") else SLOW)
        for place in PLACES
    ],
)
def test_a_drive_may_end_at_any_time(name: str, kind: str, engine: str, method: str) -> None:
    """A tip that has hardly moved was held to rounding of its own size, hinges likewise."""
    case = custom_case(["rotating_beam"], OFF_THE_GRID[name], None, 2.0).case
    if kind != "parts":
        case = replace(case, horizon=0.8)
    found = [
        item
        for check in checks_of(kind, case, engine)
        if check.method is None or check.method.name == method
        for item in run_check(check, "strict")
    ]
    assert {item.verdict for item in found} <= {"pass", "skipped"}

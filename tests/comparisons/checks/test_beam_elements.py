"""Elements against their own equations: what they see, and right ones that were called wrong."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import pytest

from mbcheck.comparisons.check.custom import custom_case
from mbcheck.comparisons.checks.suite import checks_of, run_check
from mbcheck.comparisons.checks.verdict import Result
from mbcheck.comparisons.engines.adapter import Adapter
from mbcheck.models.exudyn_system import items
from mbcheck.models.rotating_beam import exudyn_model
from mbcheck.reference.rotating_beam.scene import SCENE
from mbcheck.tests.support.faults import OtherItems, RebuiltExudyn, scaled
from mbcheck.tests.support.subjects import is_seen

METHOD = "GeneralizedAlpha"


def rebuilt(kind: str, name: str, factor: float) -> Callable[[], Adapter]:
    """Return how Exudyn is made with one number of its elements multiplied."""

    def made(**values: Any) -> Any:
        return getattr(items, kind)(**{**values, name: factor * values[name]})

    return lambda: RebuiltExudyn(exudyn_model, items=OtherItems(**{kind: made}))


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
    return run_check(check, profile, engine)


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


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["algebra", "step", "trajectory"])
@pytest.mark.parametrize("element", ["ancf", "geometrically_exact"])
def test_six_right_elements_pass(element: str, kind: str) -> None:
    """They are too few to be extrapolated, and need not be."""
    verdicts = {item.verdict for item in results(kind, element, None, "strict")}
    assert verdicts - {"skipped"} == {"pass"}


OFF_THE_GRID: Mapping[str, Mapping[str, Any]] = {
    "ramp": {"ramp_time": 0.7, "angular_speed": 1.0},
    "pulse": {"drive": "torque", "torque_period": 0.7, "torque_amplitude": 5.0},
}
"""Drives that end between steps of a power of two."""


@pytest.mark.slow
@pytest.mark.parametrize(("engine", "method"), [("mujoco", "RK4"), ("exudyn", METHOD)])
@pytest.mark.parametrize("kind", ["parts", "step", "trajectory"])
@pytest.mark.parametrize("name", OFF_THE_GRID)
def test_a_drive_may_end_at_any_time(name: str, kind: str, engine: str, method: str) -> None:
    """A tip that has hardly moved was held to rounding of its own size, hinges likewise."""
    case = custom_case(["rotating_beam"], OFF_THE_GRID[name], None, 2.0).case
    if kind == "trajectory":
        case = replace(case, horizon=1.0)
    found = [
        item
        for check in checks_of(kind, case, engine)
        if check.method is None or check.method.name == method
        for item in run_check(check, "strict")
    ]
    assert {item.verdict for item in found} <= {"pass", "skipped"}

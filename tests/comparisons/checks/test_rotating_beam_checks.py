"""The checks of rotating_beam: every kind that can see what is wrong with an engine does.

What is wrong is only in what an engine computes: it claims the model of the right one.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.checks.elements import measure_frequencies, measure_order
from mbcheck.comparisons.checks.suite import checks_of, run_check
from mbcheck.comparisons.checks.truth import RATIO, truth
from mbcheck.comparisons.checks.verdict import PROFILES, Finding, judge
from mbcheck.comparisons.engines.adapter import NO_FILE, Adapter, BoundModel
from mbcheck.comparisons.engines.exudyn.engine import EXPLICIT
from mbcheck.comparisons.engines.protocol import Method
from mbcheck.comparisons.engines.reference import ExactEngine
from mbcheck.comparisons.engines.run import Trajectory, grid_indices
from mbcheck.comparisons.engines.setup import Setup, run
from mbcheck.comparisons.faults.catalogue import ENGINES, Fault, misread, scaled
from mbcheck.comparisons.faults.exudyn import ExudynAdapter, Rebuilt
from mbcheck.comparisons.faults.mujoco import MujocoAdapter, Rewritten
from mbcheck.comparisons.faults.reference import Impostor
from mbcheck.comparisons.faults.runs import Altered
from mbcheck.comparisons.faults.variants import Misread, Wrapped
from mbcheck.models.exudyn_system import items
from mbcheck.models.mjcf import Mjcf
from mbcheck.models.rotating_beam import exudyn_model
from mbcheck.reference.equations import ModelEquations, scene_equations
from mbcheck.reference.errors import EngineError
from mbcheck.reference.linear import linearise, modes
from mbcheck.reference.rotating_beam import SCENE, beam_scene
from mbcheck.reference.rotating_beam.parameters import RotatingBeam
from mbcheck.reference.scene import Array, Case
from mbcheck.tests.support.chain import scene_of
from mbcheck.tests.support.subjects import (
    Subject,
    check_of,
    is_seen,
    label,
    results_of,
)

CHAIN = Subject("rotating_beam", "mujoco", "chain", "RK4")
ELEMENTS = Subject("rotating_beam", "exudyn", "elements", "GeneralizedAlpha")
SUBJECTS = (CHAIN, ELEMENTS)

SPIN_UP = replace(SCENE.case("spin_up_quick"), horizon=1.0)
"""The first of its 4 s, which show as much: the reference of elements takes long."""

CASES: Mapping[str, str | Case] = {
    "algebra": SPIN_UP,
    "trajectory": SPIN_UP,
    "order": "steady_4_tip_mass",
    "frequency": "steady_4_tip_mass",
    "energy": "pulse_quick",
}
"""One case for each kind, all of them with the mass at the tip."""


# Ways to be wrong ---------------------------------------------------------------------------


def edited_mujoco(before: str, factor: float) -> Rewritten:
    """Return MuJoCo with one number of its MJCF multiplied.

    {n} in the text before the number is the number of the last rod.
    """

    def multiply(text: str, parameters: Any) -> str:
        found, count = re.subn(
            f'({before.format(n=int(parameters.segments))}")([^"]+)',
            lambda match: f"{match[1]}{factor * float(match[2])!r}",
            text,
        )
        assert count == 1
        return found

    return Rewritten(multiply)


class AboutRest(Wrapped):
    """An engine that linearises about rest and passes it off as rotation: nothing stiffens."""

    def compute(self, model: BoundModel, name: str, *arguments: Any) -> Any:
        """Return M, C, K about the state at rest."""
        factor = 0 if name == "linearise" else 1
        return super().compute(model, name, *(factor * one for one in arguments))


class PlainEigenvalues(Wrapped):
    """An engine that takes the spectrum of the stretched beam for that of the turning one."""

    def compute(self, model: BoundModel, name: str, *arguments: Any) -> Any:
        """Return M, 0, K without what the turning axes do to a beam that bends in their plane."""
        found = super().compute(model, name, *arguments)
        if name != "linearise":
            return found
        mass, damping, stiffness = found
        return mass, 0 * damping, stiffness + model.case.parameters.angular_speed**2 * mass


def fading(found: Trajectory, case: Case) -> Trajectory:
    """Take a share of all speeds and of what is conserved away once the drive is over."""
    after = np.maximum(0, found.times - SCENE.drive_end_time(case.parameters))
    faded = {
        name: values * np.exp(-1e-4 * after)
        for name, values in found.values.items()
        if name.endswith("_dot") or name in ("energy", "momentum")
    }
    return replace(found, values={**found.values, **faded})


class Stubborn(Wrapped):
    """An engine that takes no steps shorter than its own."""

    shortest = 2.0**-8

    def simulate(
        self, model: BoundModel, case: Case, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate with the longer step."""
        return model.simulate(case, method, max(step, self.shortest), times)


class Lying(Stubborn):
    """The same, but it says that the steps were those asked for."""

    def simulate(
        self, model: BoundModel, case: Case, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate with steps of its own."""
        found = super().simulate(model, case, method, step, times)
        return replace(found, steps=int(grid_indices(times, case.start_time, step)[-1]))


def limit(p: RotatingBeam) -> float:
    """Return the longest step [s] with which RK4 is stable for a chain at rest."""
    scene = scene_of(p)
    fastest = modes(*linearise(scene, p, scene.state({})), steady=[0])[-1].omega
    return float(2 * np.sqrt(2) / fastest)


right_clamp = exudyn_model.clamp


def whole_clamp(mbs: Any, rim: int, root: int) -> None:
    """Clamp an ANCF node by all its coordinates: the slope vector keeps its length too."""
    right_clamp(mbs, rim, root)
    nodes = 0, mbs.GetMarker(root)["nodeNumber"]  # any other node will do beside the clamp's
    markers = [mbs.AddMarker(items.MarkerNodeCoordinates(nodeNumber=node)) for node in nodes]
    mbs.AddObject(
        items.ObjectConnectorCoordinateVector(
            markerNumbers=markers,
            scalingMarker0=np.zeros((1, 1)),
            scalingMarker1=np.array([[0, 0, 2.0, 0]]),
            quadraticTermMarker1=np.array([[0, 0, 1.0, 1.0]]),
            offset=[0.0],
        )
    )


def mujoco(make: Callable[[], Any]) -> Fault:
    """Return a fault that only MuJoCo's model can have."""
    return Fault({"mujoco": make})


FAULTS: Mapping[str, Fault] = {
    "root_spring_of_a_whole_cell": mujoco(
        lambda: edited_mujoco('name="joint_1" stiffness=', 0.5),
    ),
    "last_rod_0.1_percent": mujoco(
        lambda: edited_mujoco('name="rod_{n}" [^>]*><inertial [^>]*mass=', 1.001),
    ),
    "mass_at_0.99": misread(lambda p: p.replace(mass_position=0.99)),
    "bending_stiffness_0.1_percent": scaled("second_moment"),
    "elements_of_order_2": Fault(
        {"exudyn": lambda: Misread(ExudynAdapter(), sheared)},
    ),
}


def sheared(p: RotatingBeam) -> RotatingBeam:
    """Geometrically exact elements for ANCF."""
    return p.replace(element="geometrically_exact")


BLIND: Mapping[tuple[str, str], set[str]] = {
    # 16 rods are off by ten times as much, and the next terms of that are about as large
    ("mujoco", "last_rod_0.1_percent"): {"order"},
    ("mujoco", "bending_stiffness_0.1_percent"): {"order"},
    # the energy that Exudyn tells is that of the beam that it has
    ("exudyn", "mass_at_0.99"): {"energy"},
    ("exudyn", "bending_stiffness_0.1_percent"): {"energy"},
    # algebra is an error: nodes have fewer coordinates there than are exchanged
    ("exudyn", "elements_of_order_2"): {"energy", "algebra"},
}
"""Kinds that cannot see a fault, by physics; MuJoCo's energy is by the formula of the claim."""


LONGEST = {
    ("mujoco", "bending_stiffness_0.1_percent"): pytest.mark.slow,
    ("exudyn", "bending_stiffness_0.1_percent"): pytest.mark.campaign,
    ("exudyn", "mass_at_0.99"): pytest.mark.slow,
    ("mujoco", "mass_at_0.99"): pytest.mark.campaign,
    ("mujoco", "root_spring_of_a_whole_cell"): pytest.mark.slow,
    ("mujoco", "last_rod_0.1_percent"): pytest.mark.slow,
}
"""Where both engines can have a fault, one of them is shown with it, and the other by hand."""


def combinations() -> Iterator[Any]:
    """Yield the subjects with the faults that they can have; those that take longest are slow."""
    for subject in SUBJECTS:
        for name, fault in FAULTS.items():
            if subject.engine in fault.make:
                yield pytest.param(subject, name, marks=LONGEST.get((subject.engine, name), ()))


@pytest.mark.parametrize(("subject", "fault"), list(combinations()), ids=label)
def test_every_kind_that_can_see_a_fault_does(subject: Subject, fault: str) -> None:
    wrong = FAULTS[fault].make[subject.engine]()
    seen = {kind: is_seen(results_of(subject, kind, wrong, case)) for kind, case in CASES.items()}
    blind = BLIND.get((subject.engine, fault), set())
    assert seen == {kind: kind not in blind for kind in CASES}


@pytest.mark.parametrize("kind", [*CASES, "stability"])
@pytest.mark.parametrize("subject", SUBJECTS, ids=label)
def test_a_right_engine_passes_under_the_strict_profile(subject: Subject, kind: str) -> None:
    case = CASES.get(kind, "above_critical")
    results = run_check(check_of(subject, kind, case), "strict")
    assert {item.verdict for item in results} == {"pass"}


@pytest.mark.slow
@pytest.mark.parametrize("subject", SUBJECTS, ids=label)
def test_an_outcome_does_not_tell_a_tenth_of_a_percent(subject: Subject) -> None:
    wrong = FAULTS["bending_stiffness_0.1_percent"].make[subject.engine]()
    assert not is_seen(results_of(subject, "stability", wrong, "above_critical"))


# Frequencies --------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["frequency", "order"])
@pytest.mark.parametrize("case", ["steady_at_rest", "steady_4", "steady_4_tip_mass", "steady_12"])
@pytest.mark.parametrize(
    ("subject", "wrong"),
    [(CHAIN, AboutRest), (ELEMENTS, AboutRest), (ELEMENTS, PlainEigenvalues)],
)
def test_frequencies_that_are_not_about_rotation_are_seen(
    subject: Subject, wrong: Callable[[Any], Any], case: str, kind: str
) -> None:
    found = results_of(subject, kind, wrong(ENGINES[subject.engine]()), case)
    if case == "steady_at_rest":
        assert {item.verdict for item in found} == {"pass"}
    else:
        assert is_seen(found)


@pytest.mark.parametrize(
    ("case", "profile", "seen"),
    [
        ("steady_at_rest", "strict", False),  # nothing stretches
        ("steady_4", "default", True),
        ("steady_4_tip_mass", "default", True),
        ("steady_4", "loose", True),
    ],
)
def test_a_clamp_that_keeps_the_slope_vector_costs_part_of_an_order(
    case: str, profile: str, seen: bool
) -> None:
    """It converges to the same beam from ten times as far; its elements have other frequencies."""
    wrong = ExudynAdapter(Rebuilt(exudyn_model, clamp=whole_clamp))
    assert is_seen(results_of(ELEMENTS, "order", wrong, case, profile)) == seen
    assert is_seen(results_of(ELEMENTS, "frequency", wrong, case, profile)) == seen


@pytest.mark.parametrize("place", [0.72, 0.9])
def test_an_order_that_right_elements_do_not_show_is_asked_of_none(place: float) -> None:
    """A mass within the beam is elsewhere in meshes of 8, 16 and 32: order 3.2 for 4."""
    case = SCENE.case("steady_4_tip_mass")
    case = replace(case, parameters=case.parameters.replace(mass_position=place))
    (check,) = checks_of("order", case, "exudyn")
    assert {item.verdict for item in run_check(check, "strict")} == {"pass"}
    order, *_ = run_check(check, "strict", FAULTS["elements_of_order_2"].make["exudyn"]())
    assert order.verdict == "deviation"


# Motion -------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("subject", SUBJECTS, ids=label)
def test_the_zero_order_model_does_not_pass_for_an_engine(subject: Subject) -> None:
    engine = Impostor(ENGINES[subject.engine](), lambda scene: beam_scene("zero_order", 4))
    assert is_seen(results_of(subject, "trajectory", engine, "spin_up_quick"))
    (result,) = results_of(subject, "stability", engine, "above_critical")
    assert result.verdict == "deviation"
    assert "the engine is 'diverges', the reference 'bounded'" in result.reason


@pytest.mark.slow
def test_rk4_above_its_limit_is_finite_wrong_and_seen() -> None:
    check = check_of(CHAIN, "trajectory", "spin_up_quick")
    rk4, p = check.method, check.case.parameters
    assert rk4 is not None
    softer = (1.04 * limit(p) / Stubborn.shortest) ** 2
    p = p.replace(second_moment=softer * p.second_moment)
    assert Stubborn.shortest == pytest.approx(1.04 * limit(p))
    case = replace(check.case, parameters=p, horizon=2.0)
    times = np.arange(1, 17) / 8
    right, wrong = (
        run(Setup(MujocoAdapter(), case, "chain", rk4, step), times).values["tip_deflection"]
        for step in (Stubborn.shortest / 4, Stubborn.shortest)
    )
    assert 1.05 < np.min(wrong) / np.min(right) < 1.06
    with pytest.raises(EngineError) as caught:
        run(Setup(Stubborn(MujocoAdapter()), case, "chain", rk4, Stubborn.shortest / 4), times)
    assert caught.value.kind == "step_count"
    check = replace(check, case=case)
    assert {item.verdict for item in run_check(check, "strict")} == {"pass"}
    # no step that it is asked for makes it better
    found = run_check(check, "loose", Lying(MujocoAdapter()))
    seen = {item.quantity: item.verdict for item in found}
    assert seen["tip_deflection"] == seen["extrapolated"] == "deviation"


@pytest.mark.slow
def test_explicit_solvers_are_refused_and_fail_when_forced() -> None:
    refused = {
        check.method.name: check
        for check in checks_of("trajectory", SCENE.case("spin_up_quick"), "exudyn")
        if check.method and check.unsupported_reason
    }
    assert set(refused) == {method.name for method in EXPLICIT}
    for check in refused.values():
        assert {item.verdict for item in run_check(check)} == {"skipped"}
        results = run_check(replace(check, unsupported_reason=None))
        assert {item.verdict for item in results} == {"error"}
        assert "constraints" in results[0].reason


# Energy -------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("subject", SUBJECTS, ids=label)
def test_motion_that_fades_after_the_pulse_loses_energy(subject: Subject) -> None:
    engine = Altered(ENGINES[subject.engine](), fading)
    results = results_of(subject, "energy", engine, "pulse_quick")
    # the pulse leaves next to no momentum that could fade
    assert {item.quantity: item.verdict for item in results}["energy_drift"] == "deviation"


@pytest.mark.parametrize("subject", SUBJECTS, ids=label)
def test_energy_that_the_drive_gives_is_not_judged(subject: Subject) -> None:
    """Another pulse is another motion, which conserves as much."""
    other = scaled("torque_amplitude", 1.1).make[subject.engine]()
    results = results_of(subject, "energy", other, "pulse_quick", "default")
    assert {item.verdict for item in results} == {"pass"}


# Elements -----------------------------------------------------------------------------------

Error = Callable[[float], float]
"""Number of segments -> relative error of the frequencies."""


class ModelOfElements(BoundModel):
    """A model whose frequencies are those of the continuum but for an error."""

    engine: Elements

    @property
    def described(self) -> tuple[mbcheck.ModelDescription, None]:
        """What it claims."""
        return mbcheck.ModelDescription(element_order=self.engine.order), None

    @property
    def frequency_side(self) -> int:
        """The side that is claimed."""
        return self.engine.which

    def linearise(self, state: Array, time: float = 0.0) -> tuple[Array, Array, Array]:
        """Return M, C, K with these frequencies."""
        assert SCENE.continuum.spectrum is not None
        omega, _ = SCENE.continuum.spectrum(self.case.parameters, "chordwise", 2)
        stiffness = np.diag((omega * (1 + self.engine.error(self.case.parameters.segments))) ** 2)
        return np.eye(2), np.zeros((2, 2)), stiffness


class Elements(Adapter):
    """An engine whose frequencies are those of the continuum but for an error."""

    bound = ModelOfElements

    def __init__(self, error: Error, order: int = 2, side: int = 0) -> None:
        super().__init__(ExactEngine())
        self.error, self.order, self.which = error, order, side

    def read_source(self, scene: str, model: str) -> Mjcf:
        """Return that it has no file."""
        return NO_FILE


Measure = Callable[[Setup], list[Finding]]


def judged(measure: Measure, engine: Elements) -> dict[str, str]:
    """Return the verdicts on invented elements."""
    findings = measure(Setup(engine, SCENE.case("steady_4"), ""))
    return {item.quantity: judge(item, PROFILES["default"])[0] for item in findings}


FINE = {"order": "pass", "extrapolated": "pass"}


@pytest.mark.parametrize(
    ("error", "claims", "verdicts"),
    [
        (lambda n: 0.5 / n**2, {}, FINE),
        (lambda n: 0.5 / n**2 + 5 / n**4, {}, FINE),
        (lambda n: 0.5 / n**4, {"order": 4}, FINE),
        (lambda n: 0.5 / n**4, {}, FINE),  # better than it claims
        (lambda n: 0.5 / n, {}, {"order": "deviation"}),
        (lambda n: 0.5 / n**2, {"order": 4}, {"order": "deviation"}),
        (lambda n: 0.5 / n**2 + 1e-5, {}, {"order": "pass", "extrapolated": "deviation"}),
        (lambda n: 0.5 / n**2, {"side": 1}, FINE | {"bracket": "pass"}),
        (lambda n: -0.5 / n**2, {"side": -1}, FINE | {"bracket": "pass"}),
        (lambda n: 0.5 / n**2, {"side": -1}, FINE | {"bracket": "deviation"}),
        (lambda n: 1.5e4 / n**6 - 0.5 / n**2, {"side": -1}, {"bracket": "deviation"}),
    ],
)
def test_order_limit_and_side_of_elements(
    error: Error, claims: dict[str, int], verdicts: dict[str, str]
) -> None:
    found = judged(measure_order, Elements(error, **claims))
    assert {name: found[name] for name in verdicts} == verdicts
    assert ("bracket" in found) == ("side" in claims)


@pytest.mark.parametrize(
    ("error", "verdict"),
    [
        (lambda n: 0.5 / n**2, "pass"),
        (lambda n: 0.5 / n**2 + 3e-3, "deviation"),
        (lambda n: 0.5 / n, "deviation"),
        (lambda n: 2e-7, "deviation"),
    ],
)
def test_frequencies_of_elements_may_be_off_by_what_halving_them_predicts(
    error: Error, verdict: str
) -> None:
    found = judged(measure_frequencies, Elements(error))
    assert found == dict.fromkeys(("omega_1", "omega_2", "model_error"), verdict)


def test_a_chain_with_half_its_root_spring_is_of_order_1() -> None:
    engine = FAULTS["root_spring_of_a_whole_cell"].make["mujoco"]()
    found = {
        item.quantity: item
        for item in measure_order(Setup(engine, SCENE.case("steady_4"), "chain"))
    }
    assert found["order"].value == pytest.approx(1, abs=0.1)
    right = {
        item.quantity: item
        for item in measure_order(Setup(MujocoAdapter(), SCENE.case("steady_4"), "chain"))
    }
    assert right["order"].value == pytest.approx(2, abs=0.05)


# The reference's own truncation -------------------------------------------------------------

SEEN = ("tip_deflection", "tip_deflection_dot", "tip_axial")


def straight(p: Any, state: Mapping[str, float]) -> dict[str, float]:
    """Return the start of a straight beam."""
    return {name: state.get(name, 0.0) for name in ("theta", "theta_dot")}


@pytest.mark.slow
def test_bounds_of_the_reference_hold_its_truncation() -> None:
    case = replace(SCENE.case("spin_up_quick"), horizon=1.0)
    times = np.arange(1, 5) / 4
    many = beam_scene("inextensible", 12)
    best = truth(ModelEquations(many, case.parameters), case, times, SEEN).values
    few = replace(beam_scene("inextensible", 3), embedding=straight)
    finer = replace(few, continuum=replace(few.continuum, refined=beam_scene("inextensible", 5)))
    alone, told, used = (
        truth(own, case, times, SEEN)
        for own in (
            ModelEquations(few, case.parameters),
            ModelEquations(finer, case.parameters),
            scene_equations(case),
        )
    )
    error = np.max(np.abs(told.values - best), axis=1)
    assert np.all(error > 10 * alone.bound)
    assert np.all(error < 1.1 * told.bound)
    assert np.all(told.bound < 1.1 / (1 - RATIO) * error)
    assert np.all(np.max(np.abs(used.values - best), axis=1) < used.bound)
    assert np.all(used.bound < 1e-3 * used.size)

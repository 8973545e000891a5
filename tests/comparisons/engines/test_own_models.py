"""Engines that read no MJCF and tell of models of their own: what follows for their checks."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.checks.suite import checks_of
from mbcheck.comparisons.engines import registry as engines
from mbcheck.comparisons.engines.adapter import Adapter, adapt
from mbcheck.comparisons.engines.registry import remote_plugin
from mbcheck.comparisons.engines.run import Trajectory
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.faults.runs import Altered
from mbcheck.reference import get_scene
from mbcheck.reference.equations import invariants_of, scene_equations
from mbcheck.reference.errors import UnknownNameError, UsageError
from mbcheck.reference.scene import Case
from mbcheck.reference.solve import schemes
from mbcheck.reference.speed_regulator.soft import soft_scene
from mbcheck.tests.support.engines.solved import Solved
from mbcheck.tests.support.example import bad, results
from mbcheck.tests.support.subjects import Subject, results_of

REGULATOR = get_scene("speed_regulator")
ROTATION = REGULATOR.case("rotation")
SOFT = soft_scene((0.01, 1.0))
REACTIONS = ("reaction_a_x", "reaction_a_y", "reaction_b_x", "reaction_b_y")


class Own(mbcheck.Engine):
    """An engine whose loops are closed exactly, softly as it tells, and softly as it does not."""

    name, version, reads_mjcf, closure = "own", "1", False, "soft"
    methods = (mbcheck.Method("RK4", 4, "RK44"),)
    tells = True

    def models(self, scene: str) -> tuple[str, ...]:
        return ("rigid", "soft", "unknown") if scene == REGULATOR.name else ("rigid",)

    def describe_model(self, system: Any) -> mbcheck.ModelDescription:
        if system.model == "rigid":
            return mbcheck.ModelDescription()
        if system.model == "unknown":
            return mbcheck.ModelDescription(constrained=True)
        equations = (SOFT, system.case.parameters) if self.tells else None
        return mbcheck.ModelDescription(True, REACTIONS, equations)

    def start(self, system: Any, q: Any, v: Any) -> tuple[Any, Any]:
        scene = SOFT if system.model == "soft" else get_scene(system.case.scene)
        names = (*system.joints, *(f"{name}_dot" for name in system.joints))
        values = dict(zip(names, map(float, (*q, *v)), strict=True))
        return scene, scene.state(scene.embedding(system.case.parameters, values))

    def accelerations(self, system: Any, time: float, q: Any, v: Any) -> Any:
        scene, state = self.start(system, q, v)
        return scene.right_hand_side(system.case.parameters)(time, state)[len(state) // 2 :][
            : len(q)
        ]

    def reactions(self, system: Any, time: float, q: Any, v: Any) -> dict[str, float]:
        scene, state = self.start(system, q, v)
        seen = scene.observe(state, system.case.parameters)
        return {name: seen[name] for name in REACTIONS}

    def simulate(self, system: Any, method: Any, step: float, times: Any) -> mbcheck.Motion:
        scene, state = self.start(system, system.positions, system.velocities)
        p = system.case.parameters
        counts = np.rint((times - system.start_time) / step).astype(int)
        equations = schemes.ScalarEquations(scene, p)
        states = schemes.integrate(equations, method.scheme, state, step, counts, system.start_time)
        n, half = len(system.joints), len(state) // 2
        wanted = (*system.observables, "position_violation", "velocity_violation")
        seen = {name: rows for name, rows in scene.observe(states, p).items() if name in wanted}
        return mbcheck.Motion(states[:n].T, states[half : half + n].T, observables=seen)


def of_model(model: str, *kinds: str, tells: bool = True) -> list[Any]:
    """Return what some kinds of check say of one model."""
    engine = Own()
    engine.tells = tells
    if not tells:
        engine.closure = "rigid"
    every = results(engine, REGULATOR.name, kinds, ROTATION.name)
    return [item for item in every if item.model == model]


@pytest.mark.parametrize("model", ["rigid", "soft"])
def test_several_models_are_each_held_against_their_own_equations(model: str) -> None:
    found = of_model(model, "algebra", "step")
    assert not bad(found)
    assert "pass" in {item.verdict for item in found}


def test_equations_of_another_scene_are_refused() -> None:
    """They are asked for a state of the scene before there is a check to blame for it."""

    class Everywhere(Own):
        def describe_model(self, system: Any) -> mbcheck.ModelDescription:
            return mbcheck.ModelDescription(equations=(SOFT, ROTATION.parameters))

    hoop = get_scene("hula_hoop")
    with pytest.raises(
        UsageError, match="describe_model: its equations for hula_hoop: they do not tell"
    ):
        adapt("own", Everywhere()).bind(hoop.cases[0], "rigid").unsupported_reason(
            hoop.cases[0], None
        )


@pytest.mark.parametrize("kind", ["algebra", "step", "trajectory"])
def test_what_equations_raise_while_in_use_is_laid_at_their_engines_door(kind: str) -> None:
    """It was told as if it were mbcheck's own; those of the scene are, and have no such words."""
    calls = iter(range(sys.maxsize))

    def failing(*arguments: Any) -> Any:
        if next(calls) > 40:
            raise ZeroDivisionError("no mass is left")
        return SOFT.accelerations(*arguments)

    class Failing(Own):
        def models(self, scene: str) -> tuple[str, ...]:
            return ("soft",)

        def describe_model(self, system: Any) -> mbcheck.ModelDescription:
            own = replace(SOFT, accelerations=failing)
            return mbcheck.ModelDescription(True, REACTIONS, (own, system.case.parameters))

    found = results(Failing(), REGULATOR.name, (kind,), ROTATION.name)
    (said,) = {(item.verdict, item.reason.partition(" (test_own_models.py:")[0]) for item in found}
    reason = "own: describe_model: accelerations of its equations: ZeroDivisionError"
    assert said == ("error", f"{reason}: no mass is left")
    assert all("(test_own_models.py:" in item.reason for item in found)
    assert "in failing" in (found[0].traceback or "")


def test_a_soft_closure_is_as_far_off_as_its_equations_say() -> None:
    right = {item.quantity: item for item in of_model("soft", "algebra")}
    assert set(REACTIONS) < set(right)
    assert right["model_error"].value > 1e-2
    assert right["model_error"].verdict == "pass"
    wrong = {item.quantity: item.verdict for item in of_model("soft", "algebra", tells=False)}
    assert wrong["accelerations"] == "deviation"


def test_loops_that_are_soft_by_no_told_rule_are_skipped() -> None:
    engine = adapt("own", Own())
    assert isinstance(engine, Adapter)
    assert "soft by a rule of its own" in str(
        engine.bind(ROTATION, "unknown").unsupported_reason(ROTATION, None)
    )
    opened = REGULATOR.case("opened_loop")
    assert engine.bind(opened, "soft").unsupported_reason(opened, None) is None
    assert "start open" in str(engine.bind(opened, "rigid").unsupported_reason(opened, None))
    assert Setup(engine, ROTATION, "soft").bound.has_soft_closure


@pytest.mark.parametrize("state", [{}, dict(get_scene("rigid_body").cases[0].state)])
def test_quaternions_start_as_the_scene_says(state: dict[str, float]) -> None:
    body = get_scene("rigid_body")
    case = replace(body.cases[0], state=state)
    system = adapt("own", Own()).bind(case, "rigid").system(case)
    assert system.joints == body.coordinates
    start = np.append(system.positions, system.velocities)
    np.testing.assert_array_equal(start, body.state(state))


def test_what_an_engine_declines_to_linearise_is_not_replaced() -> None:
    class Declining(Own):
        def linearise(self, system: Any) -> Any:
            raise mbcheck.Unsupported("beside weights")

    with pytest.raises(mbcheck.Unsupported, match="beside weights"):
        adapt("own", Declining()).bind(ROTATION, "rigid").linearise(np.zeros(2))


WRONG: dict[str, tuple[Any, str]] = {
    "nothing": (None, "describe_model must return a ModelDescription, not NoneType None"),
    "a word": (mbcheck.ModelDescription("no"), "constrained must be True or False"),  # type: ignore[arg-type]
    "reactions": (
        mbcheck.ModelDescription(reactions=("here",)),
        "reactions must be a tuple of names among",
    ),
    "no pair": (mbcheck.ModelDescription(equations=SOFT), "equations must be None or"),  # type: ignore[arg-type]
    "elements": (mbcheck.ModelDescription(elements=3), "elements must be None or"),  # type: ignore[arg-type]
    "order": (mbcheck.ModelDescription(element_order=-1), "element_order must be an order of 0"),
    "placed": (mbcheck.ModelDescription(unplaceable_reason=False), "must be None or a reason"),  # type: ignore[arg-type]
}


@pytest.mark.parametrize("name", WRONG)
def test_descriptions_that_have_no_sense_are_refused(name: str) -> None:
    answer, words = WRONG[name]

    class Babbling(Own):
        def describe_model(self, system: Any) -> Any:
            return answer

    with pytest.raises(UsageError, match=f"engine own: describe_model: .*{words}"):
        adapt("own", Babbling()).bind(ROTATION, "rigid").unsupported_reason(ROTATION, None)


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        ("rigid", "a tuple of names, 100 at most, not str 'rigid'"),
        (("rigid", "rigid"), "two models have the same name"),
        (("a/b",), "calls a model 'a/b'; a name has"),
        (3, "a tuple of names, 100 at most, not int 3"),
    ],
)
def test_names_of_models_that_have_no_sense_are_refused(answer: Any, words: str) -> None:
    class Babbling(Own):
        def models(self, scene: str) -> Any:
            return answer

    with pytest.raises(UsageError, match=f"engine own.*{words}"):
        adapt("own", Babbling()).models(REGULATOR.name)


def test_models_that_an_engine_has_not_are_skipped_with_its_reason() -> None:
    class Unable(Own):
        def describe_model(self, system: Any) -> mbcheck.ModelDescription:
            raise mbcheck.Unsupported("no loops")

    assert (
        adapt("own", Unable()).bind(ROTATION, "rigid").unsupported_reason(ROTATION, None)
        == "no loops"
    )
    found = results(Unable(), REGULATOR.name, ("algebra",), ROTATION.name)
    assert {(item.verdict, item.reason) for item in found} == {("skipped", "no loops")}


def test_reasons_of_an_engine_with_models_of_its_own_are_answers_too() -> None:
    class Babbling(Own):
        def unsupported_reason(self, system: Any, method: Any) -> Any:
            return False

    with pytest.raises(UsageError, match="unsupported_reason: unsupported_reason must return"):
        adapt("own", Babbling()).bind(ROTATION, "rigid").unsupported_reason(ROTATION, None)


def test_what_a_description_raises_is_told() -> None:
    class Overflowing(Own):
        def describe_model(self, system: Any) -> mbcheck.ModelDescription:
            raise OverflowError

    line = r"describe_model: OverflowError.* \(test_own_models.py, line \d+\)$"
    with pytest.raises(UsageError, match=f"engine own: {line}"):
        adapt("own", Overflowing()).bind(ROTATION, "rigid").unsupported_reason(ROTATION, None)


def test_scenes_that_an_engine_has_not_have_no_models() -> None:
    class OneScene(Own):
        def models(self, scene: str) -> tuple[str, ...]:
            if scene != REGULATOR.name:
                raise mbcheck.Unsupported("one scene alone")
            return ("rigid",)

    engine = adapt("own", OneScene())
    assert [engine.models(name) for name in (REGULATOR.name, "hula_hoop")] == [("rigid",), ()]


def test_equations_need_parameters_of_their_own() -> None:
    class Mixed(Own):
        def describe_model(self, system: Any) -> mbcheck.ModelDescription:
            return mbcheck.ModelDescription(equations=(SOFT, None))

    with pytest.raises(UsageError, match="EquationsOfMotion, its parameters"):
        adapt("own", Mixed()).bind(ROTATION, "rigid").unsupported_reason(ROTATION, None)


def test_an_energy_that_is_told_does_not_hide_what_states_lose() -> None:
    class Leaking(Solved):
        name = "leaking"

        def describe_model(self, system: Any) -> mbcheck.ModelDescription:
            return mbcheck.ModelDescription()

        def simulate(self, system: Any, method: Any, step: float, times: Any) -> mbcheck.Motion:
            motion = super().simulate(system, method, step, times)
            left = np.exp(-(times - system.start_time))[:, None]
            told = {"energy": np.ones(len(times))}
            return replace(
                motion,
                positions=left * motion.positions,
                velocities=left * motion.velocities,
                observables=told,
            )

    leaking = Leaking(mbcheck.Method("RK44", 4), "RK44")
    (drift,) = results(leaking, "hula_hoop", ("energy",), "free_undamped")
    assert drift.verdict == "deviation"


class Telling(Solved):
    """An engine that shows what its motion keeps, each invariant by the factor that it has."""

    name = "telling"

    def __init__(self, kinetic: float = 1.0, **factors: float) -> None:
        super().__init__(mbcheck.Method("RK44", 4), "RK44")
        self.kinetic, self.factors = kinetic, factors

    def simulate(self, system: Any, method: Any, step: float, times: Any) -> mbcheck.Motion:
        motion = super().simulate(system, method, step, times)
        scene, p = get_scene(system.case.scene), system.case.parameters
        q, v, c = motion.positions.T, motion.velocities.T, scene.coefficients(p)
        known = invariants_of(scene_equations(system.case))
        shown = {name: factor * known[name](q, v, c) for name, factor in self.factors.items()}
        still = scene.energy(q, 0 * v, c)
        shown["energy"] += (self.kinetic - 1) * (scene.energy(q, v, c) - still) + 7
        return replace(motion, observables=shown)


@pytest.mark.parametrize(
    ("engine", "verdict"),
    [
        (Telling(energy=1.0), "pass"),
        (Telling(0.99, energy=1.0), "error"),
        (Telling(energy=1.001), "error"),  # though it keeps that as well
    ],
)
def test_an_energy_that_is_told_is_that_of_the_states(engine: Telling, verdict: str) -> None:
    """Up to a constant, as that of a potential."""
    (drift,) = results(engine, "hula_hoop", ("energy",), "free_undamped")
    assert drift.verdict == verdict
    assert verdict == "pass" or "by the positions and velocities" in drift.reason


@pytest.mark.parametrize(("factor", "verdict"), [(1.0, "pass"), (1.001, "error")])
def test_a_momentum_that_is_told_is_that_of_the_states(factor: float, verdict: str) -> None:
    """It has no constant that could be chosen, and no change that could betray a factor."""
    found = results(Telling(energy=1, momentum=factor), "rigid_body", ("energy",), "free_euler")
    assert {item.verdict for item in found} == {verdict}


@pytest.mark.parametrize(
    ("name", "factor", "added", "verdict"),
    [
        ("energy", 1.0, 7.0, "pass"),
        ("energy", 1.001, 0.0, "error"),
        ("momentum", 1.0, 0.01, "error"),
        ("momentum", 1.001, 0.0, "error"),
    ],
)
def test_elements_show_the_integrals_of_their_own_states(
    name: str, factor: float, added: float, verdict: str
) -> None:
    """By the closed form of their strain energy; of a beam drifts were looked at alone."""

    def off(run: Trajectory, case: Case) -> Trajectory:
        return replace(run, values={**run.values, name: factor * run.values[name] + added})

    subject = Subject("rotating_beam", "exudyn", "elements", "GeneralizedAlpha")
    found = results_of(subject, "energy", Altered(engines.get_engine("exudyn"), off), "pulse_quick")
    assert {item.verdict for item in found} == {verdict}


def test_integrals_may_be_told_where_they_are_not_conserved() -> None:
    case = get_scene("rotating_beam").case("spin_up_quick")
    exudyn = engines.get_engine("exudyn")
    times = np.array([0.0, 2.0**-8])
    run = exudyn.bind(case, "elements").simulate(case, exudyn.methods[-2], 2.0**-8, times)
    assert {"energy", "momentum"} <= set(run.values)


def test_a_continuum_takes_equations_of_a_models_own() -> None:
    (case, *_) = get_scene("rotating_beam").cases
    assert "is a continuum" in str(
        adapt("own", Own()).bind(case, "rigid").unsupported_reason(case, None)
    )
    elements = engines.get_engine("exudyn").bind(case, "elements")
    assert elements.unsupported_reason(case, None) is None


def test_names_of_models_are_those_of_the_engine() -> None:
    engine = adapt("own", Own())
    assert engine.models(REGULATOR.name) == ("rigid", "soft", "unknown")
    assert engine.twins(REGULATOR.name) == ()
    with pytest.raises(UnknownNameError, match="own model of speed_regulator"):
        engine.bind(ROTATION, "sof")
    engines._named["own"] = engine
    try:
        models = {check.model for check in checks_of("algebra", ROTATION, "own")}
    finally:
        del engines._named["own"]
    assert models == {"rigid", "soft", "unknown"}


def test_equations_do_not_come_from_another_process(
    tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "elsewhere.py").write_text(
        "import mbcheck\nfrom mbcheck.reference.speed_regulator.soft import soft_scene\n\n\n"
        "class Own(mbcheck.Engine):\n"
        "    name, version, reads_mjcf = 'elsewhere', '1', False\n"
        "    methods = (mbcheck.Method('RK4', 4),)\n"
        "    def models(self, scene):\n        return ('rigid', 'soft')\n"
        "    def describe_model(self, system):\n"
        "        soft = (soft_scene(), system.case.parameters)\n"
        "        equations = soft if system.model == 'soft' else None\n"
        "        return mbcheck.ModelDescription(True, equations=equations)\n"
        "    def simulate(self, *call):\n        raise mbcheck.Unsupported('never')\n"
    )
    monkeypatch.chdir(tmp_path)
    engine = remote_plugin("elsewhere:Own")
    assert engine.models(REGULATOR.name) == ("rigid", "soft")
    assert engine.bind(ROTATION, "rigid").has_constraints
    with pytest.raises(UsageError, match="in this process"):
        assert engine.bind(ROTATION, "soft").own_equations

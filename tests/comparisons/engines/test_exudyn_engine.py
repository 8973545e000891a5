"""Exudyn's adapter: right models pass, wrong ones show, and no failure stays silent."""

import importlib
import warnings
from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from packaging.version import Version

from mbcheck.comparisons.engines.exudyn import engine as exudyn
from mbcheck.comparisons.engines.protocol import Method
from mbcheck.comparisons.engines.run import contained
from mbcheck.comparisons.engines.setup import Setup, run
from mbcheck.comparisons.faults.exudyn import ExudynAdapter
from mbcheck.reference.errors import EngineError, EngineUnavailableError, UnknownNameError
from mbcheck.reference.hula_hoop.equations import SCENE, SEMICIRCLE, HulaHoop
from mbcheck.reference.scene import Case
from mbcheck.reference.solve.single import solve

TREE, REDUNDANT = "kinematic_tree", "redundant"
POINT, PLATE = HulaHoop(), HulaHoop(inertia_ratio=SEMICIRCLE)
REST: dict[str, float] = {}
SPINNING = {"theta": 0.3, "theta_dot": 18.0, "y": 0.01}
TIMES = np.array([0.0, 0.125, 0.1875, 0.5])

EXPLICIT = ("ExplicitEuler", "ExplicitMidpoint", "RK33", "RK44", "DOPRI5", "RK67")


class Damaged(exudyn.Exudyn):
    """Exudyn with something done to its system before it runs."""

    def __init__(self, damage: Callable[[Any, Any], None]) -> None:
        super().__init__()
        self.damage = damage

    def system(self, case: Case, model: str) -> Any:
        system = super().system(case, model)
        self.damage(self.exudyn, system.mbs)
        return system


@pytest.fixture(scope="module")
def engine() -> ExudynAdapter:
    return ExudynAdapter()


def a_case(
    parameters: HulaHoop = POINT, state: Mapping[str, float] = REST, start_time: float = 0.0
) -> Case:
    return Case("hula_hoop", "test", parameters, state, 0.5, start_time=start_time)


def method(name: str) -> Method:
    return next(item for item in exudyn.Exudyn.methods if item.name == name)


def error(engine: ExudynAdapter, case: Case, model: str, name: str, step: float) -> float:
    """Return the largest error of a run, relative to the range of each state."""
    times = case.start_time + TIMES
    truth = solve(SCENE, case.parameters, SCENE.state(case.state), times, case.start_time).states
    states = run(Setup(engine, case, model, method(name), step), times).matrix(SCENE.state_names)
    return float(np.max(np.abs(states - truth) / np.max(np.abs(truth), axis=1, keepdims=True)))


def still(parameters: HulaHoop = POINT) -> Case:
    """Return a case without its force, to be linearised."""
    return a_case(parameters.replace(force_amplitude=0.0))


def test_it_names_its_models_and_methods(engine: ExudynAdapter) -> None:
    assert engine.models("hula_hoop") == (TREE, REDUNDANT)
    assert engine.models("no_such_scene") == ()
    assert {item.name for item in engine.methods} == {
        *EXPLICIT,
        "GeneralizedAlpha",
        "TrapezoidalIndex2",
    }
    with pytest.raises(UnknownNameError, match="did you mean 'redundant'"):
        engine.bind(a_case(), "redundent").accelerations(np.zeros(1), np.zeros((1, 4)))


@pytest.mark.parametrize("model", [TREE, REDUNDANT])
def test_explicit_solvers_are_declined_where_there_are_constraints(
    engine: ExudynAdapter, model: str
) -> None:
    declined = {
        m.name
        for m in engine.methods
        if engine.bind(a_case(), model).unsupported_reason(a_case(), m)
    }
    assert declined == (set(EXPLICIT) if model == REDUNDANT else set())


def test_high_order_reaches_the_reference(engine: ExudynAdapter) -> None:
    assert error(engine, a_case(PLATE, SPINNING), TREE, "RK67", 2**-10) < 1e-10


@pytest.mark.parametrize("start_time", [-0.25, 0.25, 1000.0])
def test_the_phase_of_the_force_follows_the_start_time(
    engine: ExudynAdapter, start_time: float
) -> None:
    assert error(engine, a_case(start_time=start_time), TREE, "RK67", 2**-10) < 1e-9


@pytest.mark.parametrize("model", [TREE, REDUNDANT])
def test_runs_repeat_to_the_bit_however_they_are_sampled(engine: ExudynAdapter, model: str) -> None:
    case, step = a_case(state=SPINNING), 2**-11
    for item in engine.methods:
        if engine.bind(case, model).unsupported_reason(case, item):
            continue
        first, again = (run(Setup(engine, case, model, item, step), TIMES) for _ in range(2))
        last = run(Setup(engine, case, model, item, step), TIMES[-1:])
        names = SCENE.state_names
        np.testing.assert_array_equal(first.matrix(names), again.matrix(names))
        np.testing.assert_array_equal(first.matrix(names)[:, -1:], last.matrix(names))


def test_it_runs_what_solve_dynamic_runs(engine: ExudynAdapter) -> None:
    case, step, item = a_case(state=SPINNING), 2**-11, method("GeneralizedAlpha")
    mine = run(Setup(engine, case, REDUNDANT, item, step), TIMES).matrix(SCENE.state_names)[:, -1]
    with engine.inner.opened(case, REDUNDANT) as system:
        exudyn.place_initial(engine.inner.exudyn, system, SCENE.state(case.state))
        settings = engine.inner.settings(item, 0.0, step)
        settings.timeIntegration.endTime = 0.5
        settings.timeIntegration.numberOfSteps = 0.5 / step
        system.mbs.SolveDynamic(settings)
        data = system.mbs.systemData
        theirs = [system.readout @ data.GetODE2Coordinates()]
        theirs += [system.readout @ data.GetODE2Coordinates_t()]
    np.testing.assert_array_equal(mine, np.concatenate(theirs))


def test_steps_and_evaluations_are_counted(engine: ExudynAdapter) -> None:
    step = 2**-10
    explicit = run(Setup(engine, a_case(), TREE, method("RK67"), step), TIMES)
    implicit = run(Setup(engine, a_case(), TREE, method("GeneralizedAlpha"), step), TIMES)
    assert explicit.steps == implicit.steps == 512
    assert explicit.rhs_evaluations == 7 * 512
    assert implicit.rhs_evaluations is not None
    assert 2 * 512 <= implicit.rhs_evaluations < 8 * 512


def test_dopri5_keeps_its_step_where_its_error_estimate_would_not(engine: ExudynAdapter) -> None:
    trajectory = run(
        Setup(engine, a_case(state=SPINNING), TREE, method("DOPRI5"), 0.025), np.array([0.5])
    )
    assert trajectory.steps == 20


@pytest.mark.parametrize(
    ("model", "state", "word"),
    [
        (TREE, [0.01, 0.0, 0.0, 0.0], "accelerates"),
        (REDUNDANT, [0.01, 0.0, 0.0, 0.0], "accelerates"),
        (REDUNDANT, [0.0, 0.0, 0.0, 1.0], "moves"),
    ],
)
def test_only_rest_states_are_linearised(
    engine: ExudynAdapter, model: str, state: list[float], word: str
) -> None:
    with pytest.raises(EngineError, match=word) as caught:
        engine.bind(still(), model).linearise(np.array(state))
    assert caught.value.kind == "not_at_rest"


@pytest.mark.parametrize("name", EXPLICIT)
def test_an_unstable_run_that_exudyn_calls_a_success_is_refused(
    engine: ExudynAdapter, name: str
) -> None:
    if name == "DOPRI5" and Version(engine.version) < Version("1.12"):
        pytest.skip("in Exudyn 1.10 and 1.11 an unstable run with DOPRI5 does not end")
    stiff = a_case(POINT.replace(stiffness=1e9), SPINNING)
    with contained():
        silent = engine.bind(stiff, TREE).simulate(stiff, method(name), 1e-3, np.array([0.1]))
    assert np.isnan(silent.values["y"][-1])
    with pytest.raises(EngineError, match="y is nan") as caught:
        run(Setup(engine, stiff, TREE, method(name), 1e-3), np.array([0.1]))
    assert caught.value.kind == "non_finite"


def test_steps_shortened_in_silence_are_refused(engine: ExudynAdapter) -> None:
    halving = ExudynAdapter()
    halving.inner.adaptive_step = True
    step, end = 0.05, np.array([0.5])
    with contained():
        silent = halving.bind(a_case(), TREE).simulate(
            a_case(state=SPINNING), method("GeneralizedAlpha"), step, end
        )
    assert np.all(np.isfinite(silent.matrix(SCENE.state_names)))
    with pytest.raises(EngineError, match="steps, 10 were requested") as caught:
        run(Setup(halving, a_case(state=SPINNING), TREE, method("GeneralizedAlpha"), step), end)
    assert caught.value.kind == "step_count"
    with pytest.raises(EngineError, match="found no solution") as caught:
        run(Setup(engine, a_case(state=SPINNING), TREE, method("GeneralizedAlpha"), step), end)
    assert caught.value.kind == "solver"


def test_a_changed_step_is_told() -> None:
    class Meddling(exudyn.Exudyn):
        def solver(self, method: Method) -> Any:
            return StepChanged(super().solver(method))

    class StepChanged:
        """A solver whose step is another one after each leg."""

        def __init__(self, solver: Any) -> None:
            self.solver = solver

        def __getattr__(self, name: str) -> Any:
            return getattr(self.solver, name)

        def SolveSteps(self, *arguments: Any) -> bool:
            finished = self.solver.SolveSteps(*arguments)
            self.solver.it.currentStepSize *= 0.5
            return bool(finished)

    with pytest.raises(EngineError, match=r"step \(0.00048828125 s instead of") as caught:
        run(Setup(ExudynAdapter(Meddling()), a_case(), TREE, method("RK44"), 2**-10), TIMES)
    assert caught.value.kind == "inputs_changed"


def test_an_exception_inside_a_solve_is_a_verdict() -> None:
    def force(mbs: Any, t: float, load: float) -> float:
        if t > 0.1:
            raise ValueError("sensor torn off")
        return load

    def damage(_: Any, mbs: Any) -> None:
        mbs.SetLoadParameter(0, "loadUserFunction", force)

    with pytest.raises(EngineError, match="Error") as caught:
        run(Setup(ExudynAdapter(Damaged(damage)), a_case(), TREE, method("RK44"), 2**-10), TIMES)
    assert caught.value.kind == "raised"


@pytest.mark.parametrize("model", [TREE, REDUNDANT])
def test_nothing_is_written_and_nothing_is_deprecated(engine: ExudynAdapter, model: str) -> None:
    state = np.zeros(4)
    shown = engine.inner.exudyn.config.printToConsole
    with warnings.catch_warnings(record=True) as caught, contained() as console:
        warnings.simplefilter("always")
        for item in engine.methods:
            if not engine.bind(a_case(), model).unsupported_reason(a_case(), item):
                engine.bind(a_case(), model).simulate(a_case(), item, 2**-10, TIMES)
        engine.bind(a_case(), model).accelerations(np.zeros(1), state[None])
        engine.bind(a_case(), model).mass_matrices(state[None])
        engine.bind(still(), model).linearise(state)
    assert not caught
    assert console.text == ""
    assert engine.inner.exudyn.config.printToConsole == shown


@pytest.mark.parametrize(
    ("failure", "cure"),
    [
        (ImportError("libGL.so.1: cannot open shared object file"), "apt-get install libgl1"),
        (ModuleNotFoundError("No module named 'exudyn'"), "pip install exudyn"),
    ],
)
def test_an_engine_that_cannot_be_imported_says_why(
    monkeypatch: pytest.MonkeyPatch, failure: Exception, cure: str
) -> None:
    def refuse(name: str) -> Any:
        raise failure

    monkeypatch.setattr(importlib, "import_module", refuse)
    with pytest.raises(EngineUnavailableError, match=cure) as caught:
        ExudynAdapter()
    assert str(failure) in str(caught.value)


@pytest.mark.parametrize("place", [0.0, 0.05, 2.0])
def test_a_spring_is_linearised_wherever_it_rests(place: float) -> None:
    engine = ExudynAdapter()
    items = importlib.import_module("mbcheck.models.exudyn_system").items
    container = engine.inner.exudyn.SystemContainer()
    mbs = container.AddSystem()
    node = mbs.AddNode(items.Node1D(referenceCoordinates=[0.0], initialCoordinates=[place]))
    mbs.AddObject(items.Mass1D(mass=2.0, nodeNumber=node))
    ground = mbs.AddNode(items.NodePointGround())
    markers = [
        mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=one, coordinate=0))
        for one in (ground, node)
    ]
    spring = {"stiffness": 1000.0, "damping": 3.0, "offset": place}
    mbs.AddObject(items.CoordinateSpringDamper(markerNumbers=markers, **spring))
    mbs.Assemble()
    settings = engine.inner.exudyn.SimulationSettings()
    coarse, fine = (
        engine.inner.linearised(SimpleNamespace(mbs=mbs), settings, step)
        for step in exudyn.LINEAR_STEPS
    )
    mass, stiffness, damping = (2 * fine - coarse)[:, 0, 0]
    np.testing.assert_allclose([mass, stiffness, damping], [2.0, 1000.0, 3.0], rtol=1e-11)

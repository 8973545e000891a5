"""MuJoCo's `simulate_many`: to the bit what `simulate` returns of each case alone."""

from __future__ import annotations

import multiprocessing
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.engines.mujoco import runs as mujoco_run
from mbcheck.comparisons.engines.mujoco.engine import MuJoCo, Order
from mbcheck.comparisons.engines.mujoco.runs import (
    THREADS,
    CompiledRun,
    batch_module,
    integrate,
    integrate_many,
    threads,
)
from mbcheck.comparisons.engines.run import Trajectory, run, run_many
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.engines.variants.catalogue import Misread
from mbcheck.comparisons.engines.variants.mujoco import MujocoAdapter
from mbcheck.models.system import System
from mbcheck.reference.errors import EngineError, UsageError
from mbcheck.reference.hula_hoop.equations import HulaHoop
from mbcheck.reference.rotating_beam.parameters import RotatingBeam
from mbcheck.reference.rotor_pendulum.equations import RotorPendulum
from mbcheck.reference.scene import Array, Case
from mbcheck.reference.speed_regulator.equations import SpeedRegulator

pytest.importorskip("mujoco.batch", reason="came with MuJoCo 3.17")

ENGINE = MujocoAdapter()
METHODS = {method.name: method for method in ENGINE.methods}
EVERY = (1, 2, 7, 40, 100)
"""Numbers of steps to the samples."""


def case(parameters: Any, state: dict[str, float] | None = None, start: float = 0.0) -> Case:
    module = type(parameters).__module__.split(".")[2]
    return Case(module, "test", parameters, state or {}, start_time=start)


HOOPS = [
    case(HulaHoop(), {"theta": 0.3, "theta_dot": 18.0}),
    case(HulaHoop(force_amplitude=40.0, force_frequency=3.2), {"y": 0.01}),
    case(HulaHoop(force_amplitude=40.0, force_frequency=3.2), {"y": 0.02}, start=0.1),
    case(HulaHoop(main_mass=0.3, rod_length=0.07, stiffness=700.0, inertia_ratio=0.4), start=-2.0),
]
ROTORS = [
    case(RotorPendulum().replace(**more), {"phi_2": 0.2, "phi_1_dot": 50.0})
    for more in ({}, {"rod_stiffness": 1053.0}, {"installation_angle": 0.5})
]
RELATIVE = [
    replace(item, parameters=item.parameters.replace(motor_placement="relative")) for item in ROTORS
]
STARTS = [{"phi": 0.4, "phi_dot": 5.0}, {"phi": -1.0, "phi_dot": 8.0}]
CRANKS = [
    case(SpeedRegulator().replace(**more), state)
    for more in ({}, {"torque": 2.0}, {"rod_length": 0.9})
    for state in STARTS
]
CRANKS.append(replace(CRANKS[0], inconsistency={"y": 1e-4, "y_dot": 1e-3}))
MASSLESS = [
    replace(item, parameters=item.parameters.replace(rod_mass=0.0, slider_mass=0.0))
    for item in CRANKS[:-1]
]
SHORT = RotatingBeam(segments=4, ramp_time=0.0625)
PULSE = SHORT.replace(drive="torque", torque_period=0.03125, hub_inertia=10.0, hub_radius=0.1)
BEAMS = [
    case(SHORT),
    case(SHORT, {"theta": 1.0}, start=0.03125),
    case(SHORT, start=0.0625),  # the drive is over
    case(SHORT.replace(ramp_time=1.0)),  # it does not end
    case(SHORT.replace(ramp_time=0.0), {"theta_dot": 10.0}),
    case(SHORT.replace(ramp_time=2.0**-9 * 20)),
    case(SHORT.replace(mass=0.1, mass_position=0.4)),
    case(SHORT.replace(mass=0.1, mass_position=0.9)),
    case(PULSE),
    case(PULSE.replace(scheme="B", torque_amplitude=2.0)),
]
GROUPS: dict[str, tuple[str, list[Case], float]] = {
    "hula_hoop": ("tree", HOOPS, 1e-3),
    "rotor_pendulum": ("tree", ROTORS, 1e-3),
    "relative": ("tree", RELATIVE, 1e-3),
    "connect": ("connect", CRANKS, 1e-4),
    "connect_hard": ("connect_hard", CRANKS, 1e-4),
    "transmission": ("transmission", MASSLESS, 1e-3),
    "rotating_beam": ("chain", BEAMS, 2.0**-9),
}
"""Model, cases of different parameters, starts and times, and a step."""


def alone(
    engine: Any, cases: Sequence[Case], model: str, method: str, steps: Array, times: Array
) -> list[Trajectory | EngineError]:
    """Return what `run` makes of each case, one after the other."""
    found: list[Trajectory | EngineError] = []
    for item, step, grid in zip(cases, steps, times, strict=True):
        try:
            found.append(run(Setup(engine, item, model, METHODS[method], float(step)), grid))
        except EngineError as error:
            found.append(error)
    return found


def content(result: Trajectory | EngineError) -> Any:
    """Return all that a result tells, but for its wall time, bit for bit."""
    if isinstance(result, EngineError):
        return result.kind, result.message
    values = {name: (rows.shape, rows.tobytes()) for name, rows in result.values.items()}
    return {**vars(result), "times": result.times.tobytes(), "values": values} | {
        "clock": result.clock.tobytes(),
        "seconds": None,
    }


def grid(cases: Sequence[Case], steps: Array, numbers: Any = EVERY) -> Array:
    """Return sample times (k, n_t) after these numbers of steps, the same or (k, n_t)."""
    starts = np.array([item.start_time for item in cases])
    return np.asarray(starts[:, None] + steps[:, None] * np.asarray(numbers))


def agree(
    engine: Any, cases: Sequence[Case], model: str, method: str, steps: Array, times: Array
) -> list[Any]:
    """Return what `run_many` and `run` both make of the cases; fail where they differ."""
    expected = [content(item) for item in alone(engine, cases, model, method, steps, times)]
    found = run_many(Setup(engine, cases[0], model, METHODS[method]), cases, steps, times)
    assert [content(item) for item in found] == expected
    return found


class Counting(MuJoCo):
    """MuJoCo that counts the models it compiles, and may read other texts."""

    def __init__(self, edit: Callable[[System], System]) -> None:
        super().__init__()
        self.edit, self.loaded = edit, 0

    def load(self, system: System) -> Any:
        self.loaded += 1
        return super().load(self.edit(system))


class Together(MujocoAdapter):
    """MuJoCo that counts the cases it runs alone, and the models it compiles."""

    def __init__(self, edit: Callable[[System], System] = lambda system: system) -> None:
        self.counting = Counting(edit)
        super().__init__(self.counting)
        self.alone = 0

    @property
    def loaded(self) -> int:
        return self.counting.loaded

    def simulate(self, *arguments: Any) -> Trajectory:
        self.alone += 1
        return super().simulate(*arguments)


# --- the same to the bit


@pytest.mark.parametrize("method", [m for m in METHODS if m != "discrete"])
@pytest.mark.parametrize("group", GROUPS)
def test_results_are_those_of_each_case_alone(group: str, method: str) -> None:
    model, cases, step = GROUPS[group]
    steps = np.full(len(cases), step)
    found = agree(ENGINE, cases, model, method, steps, grid(cases, steps))
    assert all(isinstance(item, Trajectory) for item in found)
    engine = Together()
    run_many(Setup(engine, cases[0], model, METHODS[method]), cases, steps, grid(cases, steps))
    assert engine.alone == 0
    assert engine.loaded == len({item.parameters for item in cases})


def test_discrete_runs_together_too() -> None:
    steps = np.full(len(ROTORS), 1e-3)
    agree(ENGINE, ROTORS, "tree", "discrete", steps, grid(ROTORS, steps))


def test_every_case_has_its_own_step() -> None:
    cases = HOOPS + HOOPS
    steps = np.array([1 / (64 * item.parameters.force_frequency) for item in cases])
    steps[len(HOOPS) :] /= 2
    found = agree(ENGINE, cases, "tree", "RK4", steps, grid(cases, steps))
    assert all(item.steps == EVERY[-1] for item in found)


@pytest.mark.parametrize("group", ["hula_hoop", "rotating_beam"])
def test_numbers_of_steps_between_samples_may_differ(group: str) -> None:
    model, cases, step = GROUPS[group]
    steps = np.full(len(cases), step)
    numbers = np.cumsum(1 + np.arange(4 * len(cases)).reshape(len(cases), 4) % 13, axis=1)
    agree(ENGINE, cases, model, "RK4", steps, grid(cases, steps, numbers))


def test_a_sample_may_lie_at_the_start() -> None:
    steps = np.full(len(CRANKS), 1e-4)
    found = agree(ENGINE, CRANKS, "connect", "RK4", steps, grid(CRANKS, steps, (0, 10)))
    assert found[-1].values["position_violation"][0] == pytest.approx(1e-4, rel=1e-6)


@pytest.mark.parametrize("count", [1, 3, 50])
def test_the_number_of_threads_does_not_matter(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(THREADS, str(count))
    steps = np.full(len(CRANKS), 1e-4)
    agree(ENGINE, CRANKS, "connect", "RK4", steps, grid(CRANKS, steps))


def test_models_are_kept_for_the_next_call() -> None:
    engine, steps = Together(), np.full(len(BEAMS), 2.0**-9)
    first = run_many(
        Setup(engine, BEAMS[0], "chain", METHODS["RK4"]), BEAMS, steps, grid(BEAMS, steps)
    )
    compiled = engine.loaded
    again = run_many(
        Setup(engine, BEAMS[0], "chain", METHODS["RK4"]), BEAMS, steps, grid(BEAMS, steps)
    )
    assert engine.loaded == compiled
    assert [content(item) for item in again] == [content(item) for item in first]
    run_many(Setup(engine, BEAMS[0], "chain", METHODS["Euler"]), BEAMS, steps, grid(BEAMS, steps))
    assert engine.loaded == 2 * compiled


def test_runs_that_start_as_the_model_opens() -> None:
    mujoco, times = ENGINE.inner.mujoco, np.array([1e-3, 1e-1])
    runs = []
    for item in HOOPS:
        system = ENGINE.joint_system(item, "tree")
        compiled = ENGINE.inner.compiled(Order(system, "RK4", 1e-3))
        runs.append(CompiledRun(compiled, compiled.qpos0, 0 * system.velocities, 0.0, times))
    found = integrate_many(mujoco, runs)
    for each, together in zip(runs, found, strict=True):
        data = mujoco.MjData(each.compiled)
        single = integrate(mujoco, each.compiled, data, times)
        assert together is not None
        assert np.array_equal(together.positions, single.positions)
        assert np.array_equal(together.velocities, single.velocities)


# --- failures


def test_a_run_that_diverges_fails_as_it_does_alone_and_harms_no_other() -> None:
    steps = np.array([1e-3, 1.0, 1e-3, 0.3])
    found = agree(ENGINE, HOOPS, "tree", "RK4", steps, grid(HOOPS, steps))
    kinds = [item.kind if isinstance(item, EngineError) else None for item in found]
    assert kinds == [None, "warning", None, "warning"]


def test_what_diverges_is_recorded_as_it_is_alone() -> None:
    cases = [replace(item, state={**item.state, "phi_dot": 1e9}) for item in CRANKS[:3]]
    cases += CRANKS
    steps = np.full(len(cases), 1e-4)
    times = grid(cases, steps)
    method = METHODS["RK4"]
    found = ENGINE.simulate_many(cases, "connect", method, steps, times)
    single = [
        ENGINE.simulate(item, "connect", method, 1e-4, row)
        for item, row in zip(cases, times, strict=True)
    ]
    assert not np.all(np.isfinite(single[0].values["phi"]))
    assert any(single[0].warnings.values())
    assert [content(item) for item in found] == [content(item) for item in single]


def test_a_step_that_softens_the_closure_is_refused_alone() -> None:
    longest = ENGINE.source(CRANKS[0], "connect").longest_step
    steps = np.full(len(CRANKS), longest)
    steps[2] *= 1.01
    found = agree(ENGINE, CRANKS, "connect", "RK4", steps, grid(CRANKS, steps))
    failed = [i for i, item in enumerate(found) if isinstance(item, EngineError)]
    assert failed == [2]
    assert found[2].kind == "step"


def edited(old: str, new: str) -> Together:
    """Return MuJoCo that reads another text where the spring is soft."""

    def edit(system: System) -> System:
        changed = system.mjcf.replace(old, new, 1)
        assert changed != system.mjcf
        return replace(system, mjcf=changed) if system.case.parameters.stiffness < 800 else system

    return Together(edit)


def test_a_model_that_mujoco_refuses_fails_alone() -> None:
    engine = edited('type="slide"', 'type="sliding"')
    steps = np.full(len(HOOPS), 1e-3)
    found = agree(engine, HOOPS, "tree", "RK4", steps, grid(HOOPS, steps))
    assert [isinstance(item, EngineError) for item in found] == [False, False, False, True]
    assert found[3].kind == "raised"
    assert engine.alone == len(HOOPS)  # those of `agree`


def test_errors_of_mujoco_while_it_steps_are_those_of_each_case_alone() -> None:
    memory = '<size memory="800"/><option'  # enough to compile the model, not for this method
    engine = edited("<option", memory)
    cases = HOOPS[-1:] * 2
    steps = np.full(2, 1e-3)
    found = agree(engine, cases, "tree", "implicit", steps, grid(cases, steps))
    assert [(item.kind, "FatalError" in item.message) for item in found] == [("raised", True)] * 2


def test_what_mujoco_gives_up_on_the_way_runs_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    module = batch_module()
    failures = []

    class Failing(module.Batch):  # type: ignore[name-defined]
        def step(self, rows: Any, nstep: int) -> None:
            super().step(rows, nstep)
            if rows[1]:
                failures.append(nstep)
                raise module.SimulationError(np.array([1]), "out of memory")

    monkeypatch.setattr(module, "Batch", Failing)
    engine, steps = Together(), np.full(len(HOOPS), 1e-3)
    agree(engine, HOOPS, "tree", "RK4", steps, grid(HOOPS, steps))
    assert engine.alone == len(HOOPS) + 1
    assert failures == [EVERY[0]]  # what is lost is not stepped any further


@pytest.mark.parametrize(
    ("group", "row", "number"), [("hula_hoop", 1, 7.5), ("rotating_beam", 5, 40)]
)
def test_what_is_off_the_grid_is_the_users_fault(group: str, row: int, number: float) -> None:
    model, cases, step = GROUPS[group]
    steps = np.full(len(cases), step)
    if group == "rotating_beam":  # the drive ends between two steps
        steps[row] *= 0.7
    times = grid(cases, steps)
    times[row, -2] = cases[row].start_time + number * steps[row]
    with pytest.raises(UsageError, match="grid"):
        alone(ENGINE, cases, model, "RK4", steps, times)
    with pytest.raises(UsageError, match="grid"):
        run_many(Setup(ENGINE, cases[0], model, METHODS["RK4"]), cases, steps, times)


# --- what cannot run together


@pytest.mark.parametrize(
    ("model", "cases"),
    [("chain", [case(SHORT), case(SHORT.replace(segments=3))]), ("tree", ROTORS + RELATIVE)],
)
def test_models_of_different_size_run_alone(model: str, cases: list[Case]) -> None:
    engine, steps = Together(), np.full(len(cases), 2.0**-10)
    agree(engine, cases, model, "RK4", steps, grid(cases, steps))
    assert engine.alone == 2 * len(cases)


def test_without_the_batch_module_cases_run_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco.batch", None)
    engine, steps = Together(), np.full(len(HOOPS), 1e-3)
    agree(engine, HOOPS, "tree", "RK4", steps, grid(HOOPS, steps))
    assert engine.alone == 2 * len(HOOPS)


def test_a_hook_in_python_is_called() -> None:
    engine, steps = Together(), np.full(len(HOOPS), 1e-3)
    free = run_many(
        Setup(engine, HOOPS[0], "tree", METHODS["RK4"]), HOOPS, steps, grid(HOOPS, steps)
    )

    def push(compiled: Any, data: Any) -> None:
        data.qfrc_passive[1] += 1.0  # the first joint is too heavy to feel it

    ENGINE.inner.mujoco.set_mjcb_passive(push)
    try:
        pushed = agree(engine, HOOPS, "tree", "RK4", steps, grid(HOOPS, steps))
    finally:
        ENGINE.inner.mujoco.set_mjcb_passive(None)
    assert engine.alone == 2 * len(HOOPS)
    assert all(isinstance(item, Trajectory) for item in pushed)
    assert all(content(a) != content(b) for a, b in zip(free, pushed, strict=True))


def test_nothing_to_run() -> None:
    assert (
        run_many(Setup(ENGINE, HOOPS[0], "tree", METHODS["RK4"]), [], np.empty(0), np.empty((0, 3)))
        == []
    )


# --- threads


def test_threads_are_those_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(THREADS, raising=False)
    assert threads() >= 1
    monkeypatch.setattr(mujoco_run, "parent_process", object)
    assert threads() == 1
    monkeypatch.setenv(THREADS, "3")
    assert threads() == 3
    for wrong in ("", "0", "many", "-2"):
        monkeypatch.setenv(THREADS, wrong)
        with pytest.raises(UsageError, match="number of threads"):
            threads()


def test_a_worker_process_has_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(THREADS, raising=False)
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, context) as pool:
        assert pool.submit(threads).result() == 1


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="counts threads in /proc")
def test_no_thread_is_left_over(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(THREADS, "4")
    before = len(list(Path("/proc/self/task").iterdir()))
    steps = np.full(len(HOOPS), 1e-3)
    ENGINE.simulate_many(HOOPS, "tree", METHODS["RK4"], steps, grid(HOOPS, steps))
    assert len(list(Path("/proc/self/task").iterdir())) <= before


def test_a_fault_that_is_wrapped_around_an_engine_acts_on_many_too() -> None:
    heavier = Misread(MujocoAdapter(), lambda p: p.replace(main_mass=2 * p.main_mass))
    steps = np.full(len(HOOPS), 1e-3)
    right = run_many(
        Setup(ENGINE, HOOPS[0], "tree", METHODS["RK4"]), HOOPS, steps, grid(HOOPS, steps)
    )
    wrong = agree(heavier, HOOPS, "tree", "RK4", steps, grid(HOOPS, steps))
    assert all(content(a) != content(b) for a, b in zip(right, wrong, strict=True))

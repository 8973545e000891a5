"""Long horizons: drifts are as the methods predict, and wrong engines are caught by them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.engines.protocol import Method
from mbcheck.comparisons.engines.run import Trajectory
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.engines.variants.catalogue import Misread, Wrapped
from mbcheck.comparisons.extremes.long_runs.follow import follow, motions, runs, tasks
from mbcheck.comparisons.extremes.long_runs.long_run import Drift
from mbcheck.comparisons.extremes.row import FAILED, GUARD, REFERENCE, RIGHT, SECTIONS, WRONG, Row
from mbcheck.comparisons.scenes.extremes import CONSERVATIVE, FREE, LOCKED, LongMotion
from mbcheck.reference import SCENES, get_scene
from mbcheck.reference.scene import Array, Case
from mbcheck.tests.support.faults import ENGINES

PERIODS = 20


def motion_of(scene: str, kind: str) -> LongMotion:
    return {motion.kind: motion for motion in motions(scene)}[kind]


HOOP = {kind: motion_of("hula_hoop", kind) for kind in (FREE, CONSERVATIVE, LOCKED)}


def followed(
    engine: Any,
    scene: str,
    motion: LongMotion,
    method: str,
    model: str = "",
    periods: int = PERIODS,
) -> Row:
    known = {item.name: item for item in engine.methods}
    setup = Setup(engine, motion.of(scene), model or engine.models(scene)[0], known[method])
    return follow(setup, motion, periods)


RIGHT_ONES = (
    ("mujoco", "hula_hoop", FREE, "RK4", ""),
    ("mujoco", "hula_hoop", FREE, "implicitfast", ""),
    ("mujoco", "hula_hoop", CONSERVATIVE, "RK4", ""),
    ("mujoco", "hula_hoop", LOCKED, "RK4", ""),
    ("mujoco", "speed_regulator", FREE, "RK4", "connect"),
    ("exudyn", "hula_hoop", FREE, "GeneralizedAlpha", "redundant"),
    ("exudyn", "hula_hoop", LOCKED, "RK67", ""),
    ("exudyn", "speed_regulator", FREE, "TrapezoidalIndex2", "redundant"),
    ("exudyn", "speed_regulator", LOCKED, "GeneralizedAlpha", "redundant"),
    ("exudyn", "rotor_pendulum", CONSERVATIVE, "RK44", ""),
)


@pytest.mark.parametrize(("engine", "scene", "kind", "method", "model"), RIGHT_ONES)
def test_right_engines_drift_as_predicted(
    engine: str, scene: str, kind: str, method: str, model: str
) -> None:
    motion = motion_of(scene, kind)
    periods = 4 if model == "connect" else PERIODS
    row = followed(ENGINES[engine](), scene, motion, method, model, periods)
    assert row.outcome == RIGHT, row.reason
    assert row.section in SECTIONS
    assert not row.noticed_by
    assert {"clock_drift", "clock_predicted", "clock_slack", "periods"} <= set(row.values)
    assert row.values["asked"] == row.values["periods"]
    assert row.error == abs(row.values["phase_drift" if kind == LOCKED else "energy_drift"])
    if kind == LOCKED:
        assert row.values["slips"] == 0
    assert ("position_violation_drift" in row.values) == (model in ("connect", "redundant"))


def test_what_dissipates_as_predicted_is_wrong_all_the_same() -> None:
    row = followed(ENGINES["mujoco"](), "hula_hoop", HOOP[FREE], "discrete")
    assert row.outcome == WRONG
    assert "rule:numerical_damping" in row.noticed_by
    assert "as predicted, and wrong" in row.reason
    assert row.values["energy_drift"] == pytest.approx(row.values["energy_predicted"], rel=1e-4)


def test_a_clock_with_dyadic_steps_is_exact_and_may_round_with_others() -> None:
    engine = ENGINES["mujoco"]()
    dyadic = followed(engine, "hula_hoop", HOOP[FREE], "RK4")
    other = followed(engine, "hula_hoop", HOOP[LOCKED], "RK4")
    assert dyadic.values["clock_drift"] == 0
    assert 0 < other.values["clock_drift"] < 1e-9


# Wrong engines


class Damped(Wrapped):
    """An engine that takes a share of all motion away over a run."""

    def __init__(self, engine: Any, share: float) -> None:
        super().__init__(engine)
        self.share = share

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        found = self.engine.simulate(case, model, method, step, times)
        rest = get_scene(case.scene).state({})
        factor = np.exp(-self.share * times)
        values = {
            name: rest[i] + (found.values[name] - rest[i]) * factor
            for i, name in enumerate(get_scene(case.scene).state_names)
        }
        return replace(found, values={**found.values, **values})


class FastClock(Wrapped):
    """An engine whose steps are longer than it tells."""

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        factor = 1 + 1e-4
        found = self.engine.simulate(case, model, method, step * factor, times * factor)
        return replace(found, times=times, clock=times)


class Slipping(Wrapped):
    """An engine that loses a turn on the way."""

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        found = self.engine.simulate(case, model, method, step, times)
        turns = next(iter(get_scene(case.scene).rotations_per_period))
        late = times > case.start_time + 0.6 * (times[-1] - case.start_time)
        return replace(
            found, values={**found.values, turns: found.values[turns] - 2 * np.pi * late}
        )


class Opening(Wrapped):
    """An engine whose loop opens slowly."""

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        found = self.engine.simulate(case, model, method, step, times)
        wider = found.values["position_violation"] + 1e-8 * np.asarray(times) ** 3
        return replace(found, values={**found.values, "position_violation": wider})


class LateClock(Wrapped):
    """An engine whose clock is off by less than the guard sees."""

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        found = self.engine.simulate(case, model, method, step, times)
        return replace(found, clock=found.clock * (1 + 1e-15))


class Broken(Wrapped):
    """An engine that comes to no number, and tells nobody."""

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        found = self.engine.simulate(case, model, method, step, times)
        return replace(found, values={n: np.nan * v for n, v in found.values.items()})


def stiffer(p: Any) -> Any:
    return p.replace(stiffness=1.001 * p.stiffness)


def heavier(p: Any) -> Any:
    return p.replace(main_mass=1.001 * p.main_mass)


WRONG_ONES: tuple[tuple[Callable[[Any], Any], str, str, str, str], ...] = (
    (lambda e: Misread(e, stiffer), "hula_hoop", FREE, "RK44", "phase"),
    (lambda e: Misread(e, heavier), "hula_hoop", FREE, "RK44", "phase"),
    (FastClock, "hula_hoop", FREE, "RK44", "phase"),
    (lambda e: Damped(e, 1e-3), "hula_hoop", FREE, "RK44", "energy"),
    (lambda e: Damped(e, 1e-3), "hula_hoop", CONSERVATIVE, "RK44", "energy"),
    (LateClock, "hula_hoop", FREE, "RK44", "clock"),
    (Slipping, "hula_hoop", LOCKED, "RK44", "phase"),
    (Slipping, "speed_regulator", LOCKED, "GeneralizedAlpha", "phase"),
    (Opening, "speed_regulator", LOCKED, "GeneralizedAlpha", "position_violation"),
    (
        lambda e: Misread(e, lambda p: p.replace(torque=1.01 * p.torque)),
        "speed_regulator", LOCKED, "GeneralizedAlpha", "phase",
    ),
)  # fmt: skip


@pytest.mark.parametrize(
    ("wrong", "scene", "kind", "method", "drift"),
    WRONG_ONES,
    ids=["spring", "mass", "step", "damped", "damped_turning", "clock", "slip", "slip_in_loop",
         "opening", "motor"],
)  # fmt: skip
def test_a_wrong_engine_is_caught(
    wrong: Callable[[Any], Any], scene: str, kind: str, method: str, drift: str
) -> None:
    motion = motion_of(scene, kind)
    row = followed(wrong(ENGINES["exudyn"]()), scene, motion, method)
    assert row.outcome == WRONG
    assert row.noticed_by[-1] == REFERENCE
    assert row.reason.startswith("not as predicted")
    assert drift in row.reason
    if isinstance(wrong, type) and wrong is Slipping:
        assert (row.values["slips"], row.values["slips_predicted"]) == (-1, 0)


def test_a_drift_agrees_within_its_slack() -> None:
    assert Drift(1.0, 1.1, 0.2).agrees
    assert not Drift(1.0, 1.3, 0.2).agrees
    assert not Drift(float("nan"), 0.0, 1.0).agrees


def test_a_slack_far_above_what_is_predicted_is_told() -> None:
    assert str(Drift(1e-6, 1e-7, 0.01)).endswith("within ± 0.01, below what can be told)")
    assert str(Drift(1.0, 1e-7, 0.01)).endswith("within ± 0.01)")
    assert str(Drift(1.0, 1.1, 0.2)) == "1 (predicted 1.1 within ± 0.2)"


def test_the_guard_notices_what_is_no_number() -> None:
    row = followed(Broken(ENGINES["mujoco"]()), "hula_hoop", HOOP[FREE], "RK4")
    assert (row.outcome, row.noticed_by[0]) == (FAILED, GUARD)


def test_a_horizon_that_is_cut_is_told() -> None:
    dear = replace(HOOP[FREE], most_steps={"mujoco": 2000})
    row = followed(ENGINES["mujoco"](), "hula_hoop", dear, "RK4", periods=1000)
    assert row.outcome == RIGHT
    assert row.values["periods"] < row.values["asked"] == 1000
    assert row.reason.endswith("cut from 1000 periods for cost")


# The table


def names(full: bool) -> Iterator[str]:
    for task in tasks(tuple(SCENES), tuple(ENGINES), full):
        yield f"{task.scene}/{task.engine}/{task.name}"


def test_every_motion_of_every_engine_is_followed() -> None:
    default = set(names(False))
    assert len(default) == len(list(names(False)))
    assert default == set(names(True))
    for scene in SCENES:
        for engine in ENGINES:
            for motion in motions(scene):
                assert any(n.startswith(f"{scene}/{engine}/{motion.kind}") for n in default)


def test_the_reduced_set_runs_100_000_periods_in_full() -> None:
    setup = Setup(ENGINES["exudyn"](), HOOP[LOCKED].of("hula_hoop"), "kinematic_tree")

    def listed(full: bool) -> list[tuple[str, int]]:
        every = runs(setup, HOOP[LOCKED], full)
        return [(one.integrator.name, periods) for one, periods in every]

    assert ("RK44", 100_000) in listed(True)
    assert ("RK67", 10_000) in listed(True)
    assert listed(False) == [(name, 1_000) for name in ("RK67", "RK44", "GeneralizedAlpha")]

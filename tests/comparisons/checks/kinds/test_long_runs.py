"""Long horizons: drifts are as the methods predict, and wrong engines are caught by them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.checks.kinds.long_runs import CONSERVATIVE, FREE, LOCKED
from mbcheck.comparisons.checks.suite import run_check
from mbcheck.comparisons.checks.verdict import GUARD, REFERENCE, Result
from mbcheck.comparisons.engines.adapter import BoundModel
from mbcheck.comparisons.engines.protocol import Method
from mbcheck.comparisons.engines.run import Trajectory
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.faults.catalogue import ENGINES
from mbcheck.comparisons.faults.runs import Altered
from mbcheck.comparisons.faults.variants import Misread, Wrapped
from mbcheck.comparisons.scenes.data import scene_data
from mbcheck.comparisons.scenes.extremes import LongMotion, check_of, prepared
from mbcheck.reference import get_scene
from mbcheck.reference.scene import Array, Case

PERIODS = 20

PASSES = {"pass", "skipped"}


def followed(
    engine: Any, scene: str, kind: str, method: str, model: str = "", periods: int = PERIODS
) -> dict[str, Result]:
    """Return what is said of a motion, by quantity."""
    motions: tuple[LongMotion, ...] = scene_data(scene, "extremes", "MOTIONS", ())
    motion = next(one for one in motions if one.kind == kind)
    known = {item.name: item for item in engine.methods}
    model = model or engine.models(scene)[0]
    setup = Setup(engine, motion.of(scene, periods), model, known[method])
    check = check_of("long", prepared(setup, motion, periods, False))
    return {one.quantity: one for one in run_check(check, engine=engine)}


def deviating(results: dict[str, Result]) -> set[str]:
    """Return the quantities that deviate."""
    return {name for name, one in results.items() if one.verdict == "deviation"}


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
def test_right_engines_drift_as_their_step_says(
    engine: str, scene: str, kind: str, method: str, model: str
) -> None:
    periods = 4 if model == "connect" else PERIODS
    results = followed(ENGINES[engine](), scene, kind, method, model, periods)
    assert {one.verdict for one in results.values()} == {"pass"}, results
    followed_quantity = "phase" if kind == LOCKED else "energy"
    assert {"clock", f"{followed_quantity}_lost"} <= set(results)
    assert (f"{followed_quantity}_drift" in results) == (model != "connect")
    assert ("position_violation" in results) == (model == "redundant")


def test_what_dissipates_as_its_step_says_is_wrong_all_the_same() -> None:
    results = followed(ENGINES["mujoco"](), "hula_hoop", FREE, "discrete")
    assert deviating(results) == {"energy_lost"}
    assert "rule:numerical_damping" in results["energy_lost"].noticed_by


def test_a_clock_with_dyadic_steps_is_exact_and_may_round_with_others() -> None:
    engine = ENGINES["mujoco"]()
    dyadic, other = (followed(engine, "hula_hoop", kind, "RK4")["clock"] for kind in (FREE, LOCKED))
    assert dyadic.error == 0
    assert other.error is not None
    assert 0 < other.error < 1e-9


# Wrong engines


class FastClock(Wrapped):
    """An engine whose steps are longer than it tells."""

    def simulate(
        self, model: BoundModel, case: Case, method: Method, step: float, times: Array
    ) -> Trajectory:
        factor = 1 + 1e-4
        found = model.simulate(case, method, step * factor, times * factor)
        return replace(found, times=times, clock=times)


def damped(found: Trajectory, case: Case) -> Trajectory:
    """Take a share of all motion away over a run."""
    rest, names = get_scene(case.scene).state({}), get_scene(case.scene).state_names
    factor = np.exp(-1e-3 * found.times)
    left = {n: at + (found.values[n] - at) * factor for n, at in zip(names, rest, strict=True)}
    return replace(found, values={**found.values, **left})


def slipping(found: Trajectory, case: Case) -> Trajectory:
    """Lose a turn on the way."""
    turns = next(iter(get_scene(case.scene).rotations_per_period))
    late = found.times > case.start_time + 0.6 * (found.times[-1] - case.start_time)
    return replace(found, values={**found.values, turns: found.values[turns] - 2 * np.pi * late})


def opening(found: Trajectory, case: Case) -> Trajectory:
    """Open the loop slowly."""
    wider = found.values["position_violation"] + 1e-8 * found.times**3
    return replace(found, values={**found.values, "position_violation": wider})


def late_clock(found: Trajectory, case: Case) -> Trajectory:
    """Let the clock be off by less than the guard sees."""
    return replace(found, clock=found.clock * (1 + 1e-15))


def broken(found: Trajectory, case: Case) -> Trajectory:
    """Come to no number, and tell nobody."""
    return replace(found, values={n: np.nan * v for n, v in found.values.items()})


def stiffer(p: Any) -> Any:
    return p.replace(stiffness=1.001 * p.stiffness)


def heavier(p: Any) -> Any:
    return p.replace(main_mass=1.001 * p.main_mass)


WRONG_ONES: tuple[tuple[Callable[[Any], Any], str, str, str, str], ...] = (
    (lambda e: Misread(e, stiffer), "hula_hoop", FREE, "RK44", "phase_drift"),
    (lambda e: Misread(e, heavier), "hula_hoop", FREE, "RK44", "phase_drift"),
    (FastClock, "hula_hoop", FREE, "RK44", "phase_drift"),
    (lambda e: Altered(e, damped), "hula_hoop", FREE, "RK44", "energy_drift"),
    (lambda e: Altered(e, damped), "hula_hoop", CONSERVATIVE, "RK44", "energy_drift"),
    (lambda e: Altered(e, late_clock), "hula_hoop", FREE, "RK44", "clock"),
    (lambda e: Altered(e, slipping), "hula_hoop", LOCKED, "RK44", "phase_drift"),
    (
        lambda e: Altered(e, slipping),
        "speed_regulator", LOCKED, "GeneralizedAlpha", "phase_drift",
    ),
    (
        lambda e: Altered(e, opening),
        "speed_regulator", LOCKED, "GeneralizedAlpha", "position_violation",
    ),
    (
        lambda e: Misread(e, lambda p: p.replace(torque=1.01 * p.torque)),
        "speed_regulator", LOCKED, "GeneralizedAlpha", "phase_drift",
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
    results = followed(wrong(ENGINES["exudyn"]()), scene, kind, method)
    assert drift in deviating(results), results
    assert results[drift].noticed_by[-1] == REFERENCE


def test_the_guard_notices_what_is_no_number() -> None:
    results = followed(Altered(ENGINES["mujoco"](), broken), "hula_hoop", FREE, "RK4")
    assert {one.verdict for one in results.values()} == {"error"}
    assert {one.noticed_by[0] for one in results.values()} == {GUARD}


def test_a_run_that_is_too_dear_is_cut() -> None:
    engine = ENGINES["mujoco"]()
    motion = LongMotion(CONSERVATIVE, "free_undamped", most_steps={"mujoco": 2000})
    rk4 = next(one for one in engine.methods if one.name == "RK4")
    setup = Setup(engine, motion.of("hula_hoop", 1000), engine.models("hula_hoop")[0], rk4)
    short, full = (prepared(setup, motion, 1000, full) for full in (False, True))
    assert short.case.horizon <= 2000 * short.step_size < full.case.horizon

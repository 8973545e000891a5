"""The least that meets a target: counts, closures and what may be left out, verified afresh."""

from __future__ import annotations

import json
import pickle
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.checks.kinds.elements import exact, of_engine
from mbcheck.comparisons.engines.adapter import Adapter
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.engines.variants.catalogue import Misread
from mbcheck.comparisons.tradeoff import left_out, minimal
from mbcheck.comparisons.tradeoff.minimal import (
    CLOSED,
    KINDS,
    SPIN_UP,
    STEADY,
    Measured,
    beam_of,
    climbed,
    fewest,
    joined,
    left_open,
    with_parts,
)
from mbcheck.comparisons.tradeoff.series import TARGETS
from mbcheck.reference import get_scene
from mbcheck.reference.scene import Array

CHAIN_A, CHAIN_B = KINDS["mujoco"]
ANCF, GEOMETRICALLY_EXACT = KINDS["exudyn"]
SHORT = (2, 4, 8, 16, 32), (2, 4, 8, 16)


def short(kind: Any) -> Any:
    """Return the kind, tried with few parts."""
    return replace(kind, counts=SHORT[0], tip_counts=SHORT[1])


def power_law(order: int, limit: float = 0.0, factor: float = 0.5) -> Measured:
    """Return a quantity 1 whose error falls with an order to a limit."""

    def measure(count: int) -> Array:
        return np.array([1 + limit + factor * float(count) ** -order])

    return Measured(measure, np.ones(1), 1.0, order)


# The search ---------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [1, 2, 4])
@pytest.mark.parametrize("target", [3e-2, 1e-3, 2e-4])
def test_the_search_finds_the_first_count_that_meets(order: int, target: float) -> None:
    """The count meets the target and one less does not; beyond the largest it is extrapolated."""
    measured = power_law(order)
    tried = climbed(measured, (2, 4, 8, 16, 32, 64), target)
    count, extrapolated = fewest(measured, tried, target)
    right = max(2, int(np.ceil((0.5 / target) ** (1 / order))))
    assert count == right
    assert extrapolated == (right > 64)


def test_a_limit_above_the_target_is_never_met() -> None:
    """A model with another limit meets no target below it, however fine; above it, it does."""
    measured = power_law(2, limit=5e-3)
    counts = (2, 4, 8, 16, 32, 64)
    assert fewest(measured, climbed(measured, counts, 1e-3), 1e-3) == (None, False)
    assert fewest(measured, climbed(measured, counts, 1e-2), 1e-2)[0] == 10


def test_an_error_that_passes_through_zero_does_not_count() -> None:
    """Coarse parts and a wrong limit cancel at one count; that is no way to meet a target."""
    measured = power_law(2, limit=0.5 / 64, factor=-0.5)
    assert measured.error(8) < 1e-12
    tried = climbed(measured, (2, 4, 8, 16, 32, 64), 1e-3)
    assert fewest(measured, tried, 1e-3) == (None, False)


def test_without_an_order_nothing_is_extrapolated() -> None:
    """Modes converge as they like: what the most do not meet stays open."""
    measured = replace(power_law(2), order=0)
    assert fewest(measured, climbed(measured, (1, 2, 4), 1e-3), 1e-3) == (None, False)


# The beam -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "target", "count"),
    [(CHAIN_A, 1e-2, 10), (CHAIN_B, 1e-2, 10), (ANCF, 1e-3, 3), (GEOMETRICALLY_EXACT, 1e-3, 5)],
    ids=lambda value: getattr(value, "name", value),
)
def test_fewest_parts_of_a_frequency_run_fresh(kind: Any, target: float, count: int) -> None:
    """So many parts meet the target and one less misses it, by the engine asked anew."""
    name = "mujoco" if kind.part == "rods" else "exudyn"
    engine = get_engine(name)
    (row,) = beam_of(engine, short(kind), "steady_4", (target,)).fewest
    assert row.count == count
    case = get_scene("rotating_beam").case("steady_4")
    case = replace(case, parameters=case.parameters.replace(**kind.choices))

    def error(parts: int) -> float:
        found = of_engine(Setup(engine, with_parts(case, parts), engine.models("rotating_beam")[0]))
        return float(abs(found[0] / exact(case)[0] - 1))

    assert error(count) == pytest.approx(row.error)
    assert error(count) <= target < error(count - 1)
    assert row.fewer == pytest.approx(error(count - 1))


def test_what_is_extrapolated_says_so() -> None:
    """Rods that are too many to run are told by their order, as such, and agree with the law."""
    (row,) = beam_of(get_engine("mujoco"), short(CHAIN_A), "steady_4", (1e-4,)).fewest
    assert row.extrapolated
    assert row.error is None
    assert row.cost is None
    assert row.count == pytest.approx(96, abs=1)  # found by running up to 128
    assert "extrapolated by order 2" in row.reason


def test_elements_of_another_beam_never_meet_the_finest_target() -> None:
    """At speed 12 the stretch is worth 2.5e-4: ANCF elements cannot meet 0.01 %, and say why."""
    found = beam_of(get_engine("exudyn"), replace(ANCF, counts=SHORT[1]), "steady_12", (1e-3, 1e-4))
    coarse, fine = found.fewest
    assert coarse.count == 7
    assert fine.count is None
    assert not fine.extrapolated
    assert fine.limit == pytest.approx(2.48e-4, rel=0.15)
    assert "extensible" in fine.reason


def test_a_chain_of_wrong_stiffness_never_meets_its_target() -> None:
    """2 % of stiffness are 0.7 % of the frequency: 1 % is met, 0.1 % by no number of rods."""
    wrong: Adapter = Misread(
        get_engine("mujoco"), lambda p: p.replace(youngs_modulus=1.02 * p.youngs_modulus)
    )
    rows = beam_of(wrong, short(CHAIN_A), "steady_at_rest", (1e-2, 1e-3)).fewest
    assert rows[1].count is None
    assert not rows[1].extrapolated
    assert rows[1].limit == pytest.approx(np.sqrt(1.02) - 1, rel=1e-3)
    assert "not what it claims" in rows[1].reason
    worse: Adapter = Misread(
        get_engine("mujoco"), lambda p: p.replace(youngs_modulus=1.05 * p.youngs_modulus)
    )
    (row,) = beam_of(worse, short(CHAIN_A), "steady_at_rest", (1e-2,)).fewest
    assert row.count is None
    assert "no number of rods" in row.reason


@pytest.mark.slow
def test_the_tip_of_a_chain_run_fresh() -> None:
    """Its count meets the target with the step that is told, and time adds next to nothing."""
    engine = get_engine("mujoco")
    (row,) = beam_of(engine, short(CHAIN_B), SPIN_UP, (1e-2,)).fewest
    assert row.count == 8
    assert row.fewer is not None
    assert row.fewer > 1e-2
    assert row.integration is not None
    assert row.integration < row.target / 10
    assert row.step is not None
    assert row.stable_step is not None
    assert row.step <= row.stable_step
    assert row.cost is not None
    assert row.cost.rhs_evaluations == pytest.approx(4 / row.step)


@pytest.mark.slow
@pytest.mark.parametrize("case", [*STEADY, SPIN_UP])
@pytest.mark.parametrize(
    ("engine", "kind"), [(name, kind) for name, kinds in KINDS.items() for kind in kinds]
)
def test_all_counts_of_a_kind(engine: str, kind: Any, case: str) -> None:
    """Every row keeps its promises: neighbours, limits, steps."""
    for row in minimal.beam(engine, kind, case).fewest:
        if row.count is None:
            assert row.reason
            continue
        if row.extrapolated:
            assert row.error is None
            continue
        assert row.error is not None
        assert row.error <= row.target
        assert row.fewer is None or row.fewer > row.target
        assert row.integration is None or row.integration < row.target / 10
        if row.step is not None and row.stable_step is not None:
            assert row.step <= row.stable_step


# The loop -----------------------------------------------------------------------------------


def test_the_softest_closure_meets_and_the_next_softer_does_not() -> None:
    """By the claimed equations solved anew; a run with the step that is told meets it too."""
    engine = get_engine("mujoco")
    hard = minimal.softest(
        "connect_hard", "closure_time", "s", minimal.CLOSURE_TIMES[28:38],
        lambda time: engine.with_option("closure_time", time), 1e-6,
    )  # fmt: skip
    assert hard.value is not None
    assert hard.softer is not None
    assert hard.value < hard.softer
    errors = [
        left_open(engine.with_option("closure_time", time), "connect_hard")
        for time in (hard.value, hard.softer)
    ]
    assert errors[0] <= 1e-6 < errors[1]
    assert hard.measured is not None
    assert hard.measured <= 1e-6
    assert hard.step is not None
    assert hard.stable_step is not None
    assert hard.step <= hard.stable_step


def test_the_default_closure_meets_one_percent_only() -> None:
    """MuJoCo's own softness leaves 2e-3, and says so where that is too much."""
    engine = get_engine("mujoco")
    rows = [minimal.as_it_is(engine, "connect", target) for target in (1e-2, 1e-3)]
    assert rows[0].step is not None
    assert rows[0].error == pytest.approx(1.9e-3, rel=0.05)
    assert rows[1].step is None
    assert "is left" in rows[1].reason


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["mujoco", "exudyn"])
def test_all_closures_of_an_engine(engine: str) -> None:
    """What is told meets its target, the next softer does not, harder ones cost more steps."""
    rows = minimal.loop(engine).closures
    assert {row.target for row in rows} == {*TARGETS, CLOSED}
    for row in rows:
        if row.step is None:
            assert row.reason
            continue
        assert row.measured is not None
        assert row.measured <= row.target
        assert row.error is not None
        assert row.error <= row.target
        assert row.softer_error is None or row.softer_error > row.target


# What may be left out -----------------------------------------------------------------------


def test_masses_of_rod_and_slider_are_required() -> None:
    """The transmission without them errs by percents: the verdict follows from the numbers."""
    row = left_out.judged(left_out.masses_of_the_loop(), TARGETS)
    assert row.error_without > 1e-2
    assert row.error_with is not None
    assert row.error_with < 1e-4
    assert set(row.required.values()) == {True}
    assert "required for 1 %" in row.verdict


def test_an_inertia_floor_is_not() -> None:
    """2e-15 kg m^2 change nothing that is seen; by the equations and by Exudyn alike."""
    made = [left_out.floor_of_hoop(), left_out.inertia_in_exudyn()]
    rows = [left_out.judged(row, TARGETS) for row in made]
    for row in rows:
        assert 1e-12 < row.error_without < 1e-9
        assert set(row.required.values()) == {False}
    assert rows[0].error_without == pytest.approx(rows[1].error_without, rel=0.1)


def test_a_third_dimension_changes_nothing_but_the_cost() -> None:
    """Bodies in space move as those in the plane, to rounding."""
    row = left_out.third_dimension()
    assert row.error_with == pytest.approx(row.error_without, rel=1e-6)
    assert row.cost_ratio is not None
    assert row.cost_ratio > 1


def test_a_verdict_needs_its_numbers() -> None:
    """An error above a target without it and below with it makes it required, else not."""

    def required(has: float, lacks: float, *targets: float) -> list[bool | None]:
        row = left_out.unjudged("s", "e", "x", "a, b", "c", (has, lacks), (2.0,), "steps")
        return list(left_out.judged(row, targets or TARGETS).required.values())

    assert required(1e-6, 5e-3) == [False, True, True]
    assert required(5e-4, 5e-3) == [False, True, None]
    assert required(0.1, 0.2) == [None, None, None]
    assert required(1e-6, 5e-3, 0.5, 1e-7) == [False, None]


# All of it ----------------------------------------------------------------------------------


def test_tasks_can_be_sent_and_parts_be_written() -> None:
    """Each piece is a callable for another process, its result plain values for JSON."""
    scenes = ("hula_hoop", "rotor_pendulum", "rotating_beam", "speed_regulator")
    tasks = minimal.tasks(scenes, ("mujoco", "exudyn"))
    assert pickle.loads(pickle.dumps(tasks))
    names = [name for name, _ in tasks]
    assert len(set(names)) == len(names)
    assert "rotating_beam mujoco chain A, spin_up_quick" in names
    one = minimal.Minimal(left_out=(left_out.floor_of_rotors(),))
    both = joined([one, one, minimal.loop("unheard_of")])
    assert len(both.left_out) == 2
    assert json.loads(json.dumps(both.as_dict()))["left_out"][0]["scene"] == "rotor_pendulum"


def test_targets_reach_every_piece() -> None:
    """What is asked for is what the rows tell; a loop is closed to 1e-6 as well."""
    pieces = dict(minimal.tasks(("rotating_beam", "speed_regulator"), ("mujoco",), (0.03,)))
    beam = pieces["rotating_beam mujoco chain A, steady_4"]().fewest
    assert [row.target for row in beam] == [0.03]
    out = pieces["rotating_beam mujoco left out"]().left_out
    assert {tuple(row.required) for row in out} == {("0.03",)}
    loop = pieces["speed_regulator mujoco closure"]
    assert isinstance(loop, partial)
    assert loop.args[1] == (0.03, CLOSED)


def test_a_target_that_no_step_meets_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """The equations meet it, no run does."""
    monkeypatch.setattr(minimal, "first_that_meets", lambda *asked: (None, []))
    row = minimal.as_it_is(get_engine("mujoco"), "connect", 1e-2)
    assert row.step is None
    assert "no step from" in row.reason


def test_the_loosest_tolerance_that_was_tried_says_so() -> None:
    """1 m is the first that is tried, and meets 1 %: there is no looser one to compare with."""
    row = minimal.loosest(get_engine("exudyn"), 1e-2)
    assert row.value == minimal.NEWTON_TOLERANCES[0]
    assert row.softer is None
    assert "the loosest that was tried" in row.reason

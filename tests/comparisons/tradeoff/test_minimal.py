"""The least that meets a target: counts, closures and what may be left out, verified afresh."""

from __future__ import annotations

import pickle
from dataclasses import replace
from functools import partial
from typing import Any

import msgspec
import numpy as np
import pytest

from mbcheck.comparisons.checks.kinds.elements import exact, of_engine
from mbcheck.comparisons.engines.adapter import Adapter
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.engines.variants.catalogue import Misread
from mbcheck.comparisons.scenes.hula_hoop.tradeoff import LEFT_OUT as OF_HOOP
from mbcheck.comparisons.scenes.rotating_beam.tradeoff import CONTINUUM, KINDS
from mbcheck.comparisons.scenes.rotor_pendulum.tradeoff import LEFT_OUT as OF_ROTORS
from mbcheck.comparisons.scenes.speed_regulator.tradeoff import LEFT_OUT as OF_REGULATOR
from mbcheck.comparisons.scenes.speed_regulator.tradeoff import LOOP
from mbcheck.comparisons.scenes.tradeoff import PairNumbers
from mbcheck.comparisons.tradeoff import minimal
from mbcheck.comparisons.tradeoff.closures import (
    CLOSED,
    LoopSetup,
    as_it_is,
    loosest,
    softest,
    with_cost,
)
from mbcheck.comparisons.tradeoff.elements import (
    Counting,
    Fewest,
    parts_of,
)
from mbcheck.comparisons.tradeoff.minimal import LeftOut, joined, row_of
from mbcheck.comparisons.tradeoff.search import Convergence, counts_to_target, fewest
from mbcheck.comparisons.tradeoff.series import TARGETS
from mbcheck.reference import get_scene
from mbcheck.reference.scene import Array

CHAIN_A, CHAIN_B = KINDS["mujoco"]
ANCF, GEOMETRICALLY_EXACT = KINDS["exudyn"]
SHORT = (2, 4, 8, 16, 32), (2, 4, 8, 16)
HARD, SOFT, DEFAULT, JOINTS = LOOP.closures
ROTATION = get_scene("speed_regulator").case(LOOP.case)


def short(kind: Any) -> Any:
    """Return the kind, tried with few parts."""
    return replace(kind, counts=SHORT[0], run_counts=SHORT[1])


def rows_of_kind(
    engine: Adapter, kind: Any, case: str, targets: tuple[float, ...]
) -> tuple[Fewest, ...]:
    """Return the rows of a kind of parts of the beam."""
    return parts_of(Counting.of("rotating_beam", engine, kind, case), targets)[1]


def power_law(order: int, limit: float = 0.0, factor: float = 0.5) -> Convergence:
    """Return a quantity 1 whose error falls with an order to a limit."""

    def measure(count: int) -> Array:
        return np.array([1 + limit + factor * float(count) ** -order])

    return Convergence(measure, np.ones(1), 1.0, order)


# The search ---------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [1, 2, 4])
@pytest.mark.parametrize("target", [3e-2, 1e-3, 2e-4])
def test_the_search_finds_the_first_count_that_meets(order: int, target: float) -> None:
    """The count meets the target and one less does not; beyond the largest it is extrapolated."""
    convergence = power_law(order)
    tried = counts_to_target(convergence, (2, 4, 8, 16, 32, 64), target)
    count, extrapolated = fewest(convergence, tried, target)
    right = max(2, int(np.ceil((0.5 / target) ** (1 / order))))
    assert count == right
    assert extrapolated == (right > 64)


def test_a_limit_above_the_target_is_never_met() -> None:
    """A model with another limit meets no target below it, however fine; above it, it does."""
    convergence = power_law(2, limit=5e-3)
    counts = (2, 4, 8, 16, 32, 64)
    assert fewest(convergence, counts_to_target(convergence, counts, 1e-3), 1e-3) == (None, False)
    assert fewest(convergence, counts_to_target(convergence, counts, 1e-2), 1e-2)[0] == 10


def test_an_error_that_passes_through_zero_does_not_count() -> None:
    """Coarse parts and a wrong limit cancel at one count; that is no way to meet a target."""
    convergence = power_law(2, limit=0.5 / 64, factor=-0.5)
    assert convergence.error(8) < 1e-12
    tried = counts_to_target(convergence, (2, 4, 8, 16, 32, 64), 1e-3)
    assert fewest(convergence, tried, 1e-3) == (None, False)


def test_without_an_order_nothing_is_extrapolated() -> None:
    """Modes converge as they like: what the most do not meet stays open."""
    modes = replace(power_law(2), order=0)
    assert fewest(modes, counts_to_target(modes, (1, 2, 4), 1e-3), 1e-3) == (None, False)


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
    (row,) = rows_of_kind(engine, short(kind), "steady_4", (target,))
    assert row.count == count
    case = get_scene("rotating_beam").case("steady_4")
    case = replace(case, parameters=case.parameters.replace(**kind.choices))

    def error(parts: int) -> float:
        finer = replace(case, parameters=case.parameters.replace(segments=float(parts)))
        found = of_engine(Setup(engine, finer, engine.models("rotating_beam")[0]))
        return float(abs(found[0] / exact(case)[0] - 1))

    assert error(count) == pytest.approx(row.error)
    assert error(count) <= target < error(count - 1)
    assert row.fewer == pytest.approx(error(count - 1))


def test_what_is_extrapolated_says_so() -> None:
    """Rods that are too many to run are told by their order, as such, and agree with the law."""
    (row,) = rows_of_kind(get_engine("mujoco"), short(CHAIN_A), "steady_4", (1e-4,))
    assert row.extrapolated
    assert row.error is None
    assert row.cost is None
    assert row.count == pytest.approx(96, abs=1)  # found by running up to 128
    assert "extrapolated by order 2" in row.reason


def test_elements_of_another_beam_never_meet_the_finest_target() -> None:
    """At speed 12 the stretch is worth 2.5e-4: ANCF elements cannot meet 0.01 %, and say why."""
    ancf = replace(ANCF, counts=SHORT[1])
    coarse, fine = rows_of_kind(get_engine("exudyn"), ancf, "steady_12", (1e-3, 1e-4))
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
    rows = rows_of_kind(wrong, short(CHAIN_A), "steady_at_rest", (1e-2, 1e-3))
    assert rows[1].count is None
    assert not rows[1].extrapolated
    assert rows[1].limit == pytest.approx(np.sqrt(1.02) - 1, rel=1e-3)
    assert "not what it claims" in rows[1].reason
    worse: Adapter = Misread(
        get_engine("mujoco"), lambda p: p.replace(youngs_modulus=1.05 * p.youngs_modulus)
    )
    (row,) = rows_of_kind(worse, short(CHAIN_A), "steady_at_rest", (1e-2,))
    assert row.count is None
    assert "no number of rods" in row.reason


@pytest.mark.slow
def test_the_tip_of_a_chain_run_fresh() -> None:
    """Its count meets the target with the step that is told, and time adds next to nothing."""
    engine = get_engine("mujoco")
    (row,) = rows_of_kind(engine, short(CHAIN_B), CONTINUUM.moving, (1e-2,))
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


@pytest.mark.parametrize(
    "case",
    [
        *(pytest.param(case, marks=pytest.mark.campaign) for case in CONTINUUM.steady),
        pytest.param(CONTINUUM.moving, marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize(
    ("engine", "kind"), [(name, kind) for name, kinds in KINDS.items() for kind in kinds]
)
def test_all_counts_of_a_kind(engine: str, kind: Any, case: str) -> None:
    """Every row keeps its promises: neighbours, limits, steps. Frequencies alone are by hand."""
    for row in parts_of(Counting.of("rotating_beam", get_engine(engine), kind, case))[1]:
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
    """By the model's equations solved anew; a run with the step of the row meets it too."""
    loop = LoopSetup.of(ROTATION, replace(HARD, values=HARD.values[28:38]))
    hard = softest(loop, 1e-6)
    assert hard.value is not None
    assert hard.softer is not None
    assert hard.value < hard.softer
    errors = [loop.with_value(time).model_error() for time in (hard.value, hard.softer)]
    assert errors[0] <= 1e-6 < errors[1]
    assert hard.measured is not None
    assert hard.measured <= 1e-6
    assert hard.step is not None
    assert hard.stable_step is not None
    assert hard.step <= hard.stable_step


def test_an_impedance_makes_a_closure_softer() -> None:
    """The option that the variant adds is that of the model's equations."""
    loop = LoopSetup.of(ROTATION, SOFT)
    errors = [loop.with_value(softness).model_error() for softness in (0.5, 0.05)]
    assert errors[1] < errors[0] / 5


def test_the_default_closure_meets_one_percent_only() -> None:
    """MuJoCo's own softness leaves 2e-3, and says so where that is too much."""
    default = LoopSetup.of(ROTATION, DEFAULT)
    rows = [as_it_is(default, target) for target in (1e-2, 1e-3)]
    assert rows[0].step is not None
    assert rows[0].error == pytest.approx(1.9e-3, rel=0.05)
    assert rows[1].step is None
    assert "is left" in rows[1].reason


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["mujoco", "exudyn"])
def test_all_closures_of_an_engine(engine: str) -> None:
    """What is told meets its target, the next softer does not, harder ones cost more steps."""
    rows = minimal.of_loop("speed_regulator", engine).closures
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
    row = row_of("speed_regulator", "mujoco", OF_REGULATOR["mujoco"][0], TARGETS)
    assert row.left_out == "masses of rod and slider"
    assert row.error_without > 1e-2
    assert row.error_with is not None
    assert row.error_with < 1e-4
    assert set(row.required.values()) == {True}
    assert "required for 1 %" in row.verdict


def test_an_inertia_floor_is_not() -> None:
    """2e-15 kg m^2 change nothing that is seen; by the equations and by Exudyn alike."""
    rows = [
        row_of("hula_hoop", engine, OF_HOOP[engine][0], TARGETS) for engine in ("mujoco", "exudyn")
    ]
    for row in rows:
        assert row.left_out == "point masses without inertia"
        assert 1e-12 < row.error_without < 1e-9
        assert set(row.required.values()) == {False}
    assert rows[0].error_without == pytest.approx(rows[1].error_without, rel=0.1)


def test_a_third_dimension_changes_nothing_but_the_cost() -> None:
    """Bodies in space move as those in the plane, to rounding; what they cost is measured."""
    row = row_of("hula_hoop", "exudyn", OF_HOOP["exudyn"][-1], TARGETS)
    assert row.left_out == "third dimension"
    assert row.error_with == pytest.approx(row.error_without, rel=1e-6)
    assert row.cost_ratio is not None


def verdict(has: float, lacks: float, *targets: float, ratio: float = 2.0) -> LeftOut:
    """Return the row of these numbers."""
    numbers = PairNumbers("x", "a, b", "c", (has, lacks), (ratio,), "steps")
    return row_of("s", "e", lambda: numbers, targets or TARGETS)


def test_a_verdict_needs_its_numbers() -> None:
    """An error above a target without it and below with it makes it required, else not."""

    def required(*numbers: float) -> list[bool | None]:
        return list(verdict(*numbers).required.values())

    assert required(1e-6, 5e-3) == [False, True, True]
    assert required(5e-4, 5e-3) == [False, True, None]
    assert required(0.1, 0.2) == [None, None, None]
    assert required(1e-6, 5e-3, 0.5, 1e-7) == [False, None]


def test_a_verdict_says_what_is_saved() -> None:
    assert verdict(1e-6, 5e-3, 1e-3).verdict == (
        "required for 0.1 % and finer: 0.005 without it, 1e-06 with it; leaving it out saves a "
        "factor of 2 in steps"
    )
    assert verdict(1e-6, 5e-3, ratio=0.5).verdict.endswith("costs a factor of 2 in steps")
    assert verdict(1e-6, 5e-3, ratio=1.01).verdict.endswith(
        "no difference in steps above the scatter"
    )


# All of it ----------------------------------------------------------------------------------


def test_tasks_can_be_sent_and_parts_be_written() -> None:
    """Each piece is a callable for another process, its result plain values for JSON."""
    scenes = ("hula_hoop", "rotor_pendulum", "rotating_beam", "speed_regulator")
    tasks = minimal.tasks(scenes, ("mujoco", "exudyn"))
    assert pickle.loads(pickle.dumps(tasks))
    names = [name for name, _ in tasks]
    assert len(set(names)) == len(names)
    assert "rotating_beam mujoco chain A, spin_up_quick" in names
    floor = row_of("rotor_pendulum", "mujoco", OF_ROTORS["mujoco"][0], TARGETS)
    one = minimal.Minimal(left_out=(floor,))
    both = joined([one, one, minimal.of_loop("speed_regulator", "unheard_of")])
    assert len(both.left_out) == 2
    assert msgspec.to_builtins(both)["left_out"][0]["scene"] == "rotor_pendulum"


def test_targets_reach_every_piece() -> None:
    """What is asked for is what the rows tell; a loop is closed to 1e-6 as well."""
    pieces = dict(minimal.tasks(("rotating_beam", "speed_regulator"), ("mujoco",), (0.03,)))
    beam = pieces["rotating_beam mujoco chain A, steady_4"]().fewest
    assert [row.target for row in beam] == [0.03]
    out = pieces["rotating_beam mujoco left out"]().left_out
    assert {tuple(row.required) for row in out} == {("0.03",)}
    loop = pieces["speed_regulator mujoco closure"]
    assert isinstance(loop, partial)
    assert loop.args[-1] == (0.03, CLOSED)


def test_a_target_that_no_step_meets_says_so() -> None:
    """The closure leaves 2e-3, whatever the step."""
    default = LoopSetup.of(ROTATION, DEFAULT)
    row = with_cost(default, default.row(1e-4))
    assert row.step is None
    assert "no step from" in row.reason


def test_the_loosest_tolerance_that_was_tried_says_so() -> None:
    """1 m is the first that is tried, and meets 1 %: there is no looser one to compare with."""
    row = loosest(LoopSetup.of(ROTATION, JOINTS), 1e-2)
    assert row.value == JOINTS.values[0]
    assert row.softer is None
    assert "the loosest that was tried" in row.reason

"""The smallest model that meets a target: counts, closures and what may be left out."""

from __future__ import annotations

import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.checks.kinds.elements import exact, of_engine
from mbcheck.comparisons.engines.adapter import Adapter
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.engines.setup import Setup, run
from mbcheck.comparisons.faults.variants import Misread
from mbcheck.comparisons.scenes.hula_hoop.tradeoff import LEFT_OUT as OF_HOOP
from mbcheck.comparisons.scenes.rotating_beam.tradeoff import CONTINUUM, KINDS
from mbcheck.comparisons.scenes.speed_regulator.tradeoff import LEFT_OUT as OF_REGULATOR
from mbcheck.comparisons.scenes.speed_regulator.tradeoff import LOOP
from mbcheck.comparisons.scenes.tradeoff import Pair, PairNumbers
from mbcheck.comparisons.tradeoff import smallest as module
from mbcheck.comparisons.tradeoff.smallest import (
    CLOSED,
    FINE,
    Ladder,
    closure_ladder,
    part_ladder,
    smallest,
    with_and_without,
    with_longest_step,
)
from mbcheck.comparisons.tradeoff.table import TARGETS, Choice, StepSeries
from mbcheck.reference import get_scene
from mbcheck.reference.scene import Array

CHAIN_A, CHAIN_B = KINDS["mujoco"]
ANCF, GEOMETRICALLY_EXACT = KINDS["exudyn"]
HARD, SOFT, DEFAULT, JOINTS = LOOP.closures


def chosen(engine: Adapter, kind: Any, case: str, target: float) -> Choice:
    """Return the fewest parts of a kind of the beam, tried with few."""
    kind = replace(kind, counts=(2, 4, 8, 16, 32), run_counts=(2, 4, 8, 16))
    return smallest(part_ladder("rotating_beam", engine, kind, case), target)


def power_law(
    order: int,
    limit: float = 0.0,
    factor: float = 0.5,
    tried: tuple[int, ...] = (2, 4, 8, 16, 32, 64),
) -> Ladder:
    """Return a quantity 1 whose error falls with an order to a limit."""

    def measure(count: int) -> Array:
        return np.array([1 + limit + factor * float(count) ** -(order or 2)])

    series = StepSeries("s", "c", "e", "m", "", order, {}, axis="parts", unit="1")
    return Ladder(series, range(tried[0], tried[-1] + 1), tried, measure, np.ones(1))


@pytest.mark.parametrize("order", [1, 2, 4])
@pytest.mark.parametrize("target", [3e-2, 1e-3, 2e-4])
def test_the_search_finds_the_first_count_that_meets(order: int, target: float) -> None:
    """The count meets the target and one less does not; beyond the largest it is extrapolated."""
    choice = smallest(power_law(order), target)
    right = max(2, int(np.ceil((0.5 / target) ** (1 / order))))
    assert choice.value == right
    assert choice.extrapolated == (right > 64)


def test_a_limit_above_the_target_is_never_met() -> None:
    """A model with another limit meets no target below it, however fine; above it, it does."""
    assert not smallest(power_law(2, limit=5e-3), 1e-3).met
    assert smallest(power_law(2, limit=5e-3), 1e-2).value == 10


def test_an_error_that_passes_through_zero_does_not_count() -> None:
    """Coarse parts and a wrong limit cancel at one count; that is no way to meet a target."""
    ladder = power_law(2, limit=0.5 / 64, factor=-0.5)
    assert ladder.error(8) < 1e-12
    assert not smallest(ladder, 1e-3).met


def test_without_an_order_nothing_is_extrapolated() -> None:
    assert not smallest(power_law(0, tried=(1, 2, 4)), 1e-3).met


# The beam -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "target", "count"),
    [(CHAIN_A, 1e-2, 10), (CHAIN_B, 1e-2, 10), (ANCF, 1e-3, 3), (GEOMETRICALLY_EXACT, 1e-3, 5)],
    ids=lambda value: getattr(value, "name", value),
)
def test_fewest_parts_of_a_frequency_run_fresh(kind: Any, target: float, count: int) -> None:
    """So many parts meet the target and one less misses it, by the engine asked anew."""
    engine = get_engine("mujoco" if kind.part == "rods" else "exudyn")
    choice = chosen(engine, kind, "steady_4", target)
    assert choice.value == count
    case = get_scene("rotating_beam").case("steady_4")
    case = replace(case, parameters=case.parameters.replace(**kind.choices))

    def error(parts: int) -> float:
        finer = replace(case, parameters=case.parameters.replace(segments=float(parts)))
        found = of_engine(Setup(engine, finer, engine.models("rotating_beam")[0]))
        return float(abs(found[0] / exact(case)[0] - 1))

    assert error(count) == pytest.approx(choice.error)
    assert error(count) <= target < error(count - 1)
    assert choice.smaller == pytest.approx(error(count - 1))


def test_what_is_extrapolated_says_so() -> None:
    """Rods that are too many to run are told by their order, as such, and agree with the law."""
    choice = chosen(get_engine("mujoco"), CHAIN_A, "steady_4", 1e-4)
    assert choice.extrapolated
    assert choice.error is None
    assert choice.cost is None
    assert choice.value == pytest.approx(96, abs=1)  # found by running up to 128
    assert "extrapolated by order 2" in choice.limit


def test_elements_of_another_beam_never_meet_the_finest_target() -> None:
    """At speed 12 the stretch is worth 2.5e-4: ANCF elements cannot meet 0.01 %, and say why."""
    assert chosen(get_engine("exudyn"), ANCF, "steady_12", 1e-3).value == 7
    fine = chosen(get_engine("exudyn"), replace(ANCF, counts=(2, 4, 8, 16)), "steady_12", 1e-4)
    assert not fine.met
    assert not fine.extrapolated
    assert fine.error == pytest.approx(2.48e-4, rel=0.15)
    assert "extensible" in fine.limit


def test_a_chain_of_wrong_stiffness_never_meets_its_target() -> None:
    """2 % of stiffness are 0.7 % of the frequency: 1 % is met, 0.1 % by no number of rods."""

    def stiffer(factor: float) -> Adapter:
        return Misread(
            get_engine("mujoco"), lambda p: p.replace(youngs_modulus=factor * p.youngs_modulus)
        )

    fine = chosen(stiffer(1.02), CHAIN_A, "steady_at_rest", 1e-3)
    assert not fine.met
    assert not fine.extrapolated
    assert fine.error == pytest.approx(np.sqrt(1.02) - 1, rel=1e-3)
    assert "not what it claims" in fine.limit
    assert chosen(stiffer(1.02), CHAIN_A, "steady_at_rest", 1e-2).met
    assert not chosen(stiffer(1.05), CHAIN_A, "steady_at_rest", 1e-2).met


@pytest.mark.slow
def test_the_tip_of_a_chain_run_fresh() -> None:
    """Its count meets the target with the step that is told, and time adds next to nothing."""
    kind = replace(CHAIN_B, run_counts=(2, 4, 8, 16))
    ladder = part_ladder("rotating_beam", get_engine("mujoco"), kind, CONTINUUM.moving)
    choice = smallest(ladder, 1e-2)
    assert choice.value == 8
    assert choice.smaller is not None
    assert choice.smaller > 1e-2
    assert choice.step is not None
    assert choice.margin is not None
    assert choice.margin >= 1
    assert choice.cost is not None
    assert choice.cost.rhs_evaluations == pytest.approx(4 / choice.step)
    assert ladder.setup_of is not None
    finer = run(ladder.setup_of(8).with_step(FINE / 4), ladder.truth.times)  # type: ignore[union-attr]
    change = ladder.error_of(finer.matrix((CONTINUUM.observable,))) - (choice.error or 0)
    assert abs(change) < 1e-3


# The loop -----------------------------------------------------------------------------------


def test_the_softest_closure_meets_and_the_next_softer_does_not() -> None:
    """By the model's equations solved anew; a run with the step of the row meets it too."""
    ladder = closure_ladder("speed_regulator", replace(HARD, values=HARD.values[28:38]))
    choice = smallest(ladder, 1e-6)
    assert choice.met
    assert choice.error is not None
    assert choice.smaller is not None
    assert choice.error <= 1e-6 < choice.smaller
    place = ladder.values.index(choice.value)
    fresh = closure_ladder("speed_regulator", HARD)
    assert fresh.error(ladder.values[place]) <= 1e-6 < fresh.error(ladder.values[place - 1])
    assert choice.margin is not None
    assert choice.margin >= 1


def test_an_impedance_makes_a_closure_softer() -> None:
    """The option that the variant adds is that of the model's equations."""
    ladder = closure_ladder("speed_regulator", SOFT)
    assert ladder.error(0.05) < ladder.error(0.5) / 5


def test_the_default_closure_meets_one_percent_only() -> None:
    """MuJoCo's own softness leaves 2e-3, whatever the step, and says so."""
    ladder = closure_ladder("speed_regulator", DEFAULT)
    coarse, fine = (smallest(ladder, target) for target in (1e-2, 1e-3))
    assert coarse.step is not None
    assert coarse.error == pytest.approx(1.9e-3, rel=0.05)
    assert not fine.met
    assert "is left" in fine.limit
    none = with_longest_step(ladder, replace(coarse, target=1e-4))
    assert not none.met
    assert "no step from" in none.limit


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["mujoco", "exudyn"])
def test_all_closures_of_an_engine(engine: str) -> None:
    """What is told meets its target, and the next softer does not."""
    choices = module.of_loop("speed_regulator", engine, (*TARGETS, CLOSED)).choices
    assert {one.target for one in choices} == {*TARGETS, CLOSED}
    for one in choices:
        assert one.limit
        if one.met:
            assert one.step is not None
            assert one.error is not None
            assert one.error <= one.target
            assert one.smaller is None or one.smaller > one.target


# What may be left out -----------------------------------------------------------------------


def test_masses_of_rod_and_slider_are_required() -> None:
    """The transmission without them errs by percents."""
    found = with_and_without("speed_regulator", "mujoco", OF_REGULATOR["mujoco"][0], TARGETS)
    lacks, has = (point.error for point in found.series[0].points)
    assert lacks is not None
    assert lacks > 1e-2
    assert has is not None
    assert has < 1e-4
    assert [one.value for one in found.choices] == [1, 1, 1]


def test_an_inertia_floor_is_not() -> None:
    """2e-15 kg m^2 change nothing that is seen; by the equations and by Exudyn alike."""
    errors = []
    for engine in ("mujoco", "exudyn"):
        found = with_and_without("hula_hoop", engine, OF_HOOP[engine][0], TARGETS)
        assert [one.value for one in found.choices] == [0, 0, 0]
        errors.append(found.series[0].points[0].error or 0.0)
    assert 1e-12 < errors[0] < 1e-9
    assert errors[0] == pytest.approx(errors[1], rel=0.1)


def test_a_third_dimension_changes_nothing_but_the_cost() -> None:
    """Bodies in space move as those in the plane: their errors differ by the step's order alone."""
    pair = OF_HOOP["exudyn"][-1]
    assert isinstance(pair, Pair)
    finer = replace(
        pair,
        has=replace(pair.has, step=pair.has.step / 2),
        lacks=replace(pair.lacks, step=pair.lacks.step / 2),
    )
    differences = []
    for one in (pair, finer):
        found = with_and_without("hula_hoop", "exudyn", one, TARGETS)
        lacks, has = (point.error or 0.0 for point in found.series[0].points)
        differences.append(has - lacks)
        assert has == pytest.approx(lacks, rel=0.2)
        assert "wall time" in found.choices[0].limit
    assert differences[0] / differences[1] == pytest.approx(4, rel=0.1)


@pytest.mark.parametrize(
    ("numbers", "needed", "words"),
    [
        ((1e-6, 5e-3, 2.0), [0, 1, 1], "saves a factor of 2 in steps"),
        ((5e-4, 5e-3, 0.5), [0, 1, None], "costs a factor of 2 in steps"),
        ((0.1, 0.2, 1.01), [None] * 3, "no difference in steps above the scatter"),
    ],
)
def test_what_is_needed_follows_from_the_numbers(
    numbers: tuple[float, float, float], needed: list[int | None], words: str
) -> None:
    """An error above a target without it and below with it makes it required, else not."""
    *errors, ratio = numbers
    pair = PairNumbers("x", "a, b", "c", (errors[0], errors[1]), (ratio,), "steps")
    choices = with_and_without("s", "e", lambda: pair, TARGETS).choices
    assert [one.value for one in choices] == needed
    assert words in choices[0].limit


def test_pieces_can_be_sent_and_targets_reach_them() -> None:
    """Each piece is a callable for another process; a loop is closed to 1e-6 as well."""
    scenes = ("hula_hoop", "rotor_pendulum", "rotating_beam", "speed_regulator")
    tasks = module.tasks(scenes, ("mujoco", "exudyn"), (0.03,))
    pieces = dict(pickle.loads(pickle.dumps(tasks)))
    assert len(pieces) == len(tasks)
    assert "rotating_beam mujoco chain A, spin_up_quick" in pieces
    beam = pieces["rotating_beam mujoco chain A, steady_4"]()
    assert [one.target for one in beam.choices] == [0.03]
    assert pieces["speed_regulator mujoco closure"].args[-1] == (0.03, CLOSED)

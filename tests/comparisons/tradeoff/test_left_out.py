"""What models may leave out, and what a step costs in stability."""

from __future__ import annotations

import io
import pickle
from dataclasses import replace
from pathlib import Path

import pytest
from rich.console import Console

from mbcheck.comparisons.checks import boundary
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.reports.sections import print_sections
from mbcheck.comparisons.reports.text import markdown_table
from mbcheck.comparisons.scenes.left_out import Pair
from mbcheck.comparisons.tradeoff import pages
from mbcheck.comparisons.tradeoff.left_out import LeftOut, compare, pairs_of
from mbcheck.comparisons.tradeoff.report import Tradeoff
from mbcheck.comparisons.tradeoff.request import TradeoffRequest
from mbcheck.comparisons.tradeoff.stability import StabilityShift, boundaries_of, shift
from mbcheck.comparisons.tradeoff.table import STEP, Cost, Point, StepSeries
from mbcheck.reference.errors import EngineError
from mbcheck.tests.support.documents import validated

DOCS = Path(__file__).parents[3] / "docs"
BOUNDARY = "loss_of_symmetry_5hz"


def pairs(scene: str, engine: str, left_out: str) -> list[Pair]:
    """Return the pairs of a scene in which this is left out."""
    return [pair for _, pair in pairs_of((scene,), (engine,)) if pair.left_out == left_out]


def test_masses_of_rod_and_slider_are_required() -> None:
    """The transmission without them errs by percents."""
    found = compare(pairs("speed_regulator", "mujoco", "masses of rod and slider")[0])
    assert found.error < 1e-4
    assert found.error_without > 1e-2
    assert "transmission rod_mass 0.0" in found.without


def test_a_third_dimension_changes_nothing_but_the_cost() -> None:
    """Bodies in space move as those in the plane: their errors differ by the step's order alone."""
    (pair,) = pairs("hula_hoop", "exudyn", "third dimension")
    differences = []
    for one in (pair, replace(pair, step=pair.step / 2)):
        found = compare(one)
        differences.append(found.error - found.error_without)
        assert found.error == pytest.approx(found.error_without, rel=0.2)
        assert found.cost == "wall time"
    assert differences[0] / differences[1] == pytest.approx(4, rel=0.1)


@pytest.mark.slow
def test_theories_are_compared_with_the_one_that_has_it() -> None:
    found = compare(pairs("rotating_beam", "mujoco", "large deflections")[0])
    assert found.error < 1e-9 < 1e-3 < found.error_without
    assert (found.engine, found.cost) == ("reference", "right-hand sides")


@pytest.mark.parametrize(
    ("ratios", "words"),
    [
        ((1.9, 2.0, 2.1), "saves a factor of 2 in wall time"),
        ((0.4, 0.5, 0.6), "costs 2 times in wall time"),
        ((0.9, 1.2, 1.5), "no wall time above the scatter"),
    ],
)
def test_a_saving_is_above_the_scatter(ratios: tuple[float, float, float], words: str) -> None:
    one = LeftOut("hula_hoop", "c", "exudyn", "x", "a", "b", 1e-6, 5e-3, ratios, "wall time")
    assert one.saving == words


@pytest.mark.parametrize(
    ("engine", "method", "order"),
    [("mujoco", "RK4", 4), ("mujoco", "Euler", 1), ("exudyn", "GeneralizedAlpha", 2)],
)
def test_boundaries_by_engines_converge_with_their_order(
    engine: str, method: str, order: int
) -> None:
    """The page has the same numbers."""
    model = get_engine(engine).models("hula_hoop")[0]
    found = shift("hula_hoop", BOUNDARY, engine, model, method, (40, 80))
    assert found.floor is not None
    assert found.floor < 1e-6
    assert found.slope == pytest.approx(order, abs=0.35)
    assert (found.order, found.unit, found.parameter) == (order, "N", "force_amplitude")
    heads, rows = pages.stability_table([found])
    row = markdown_table(heads[:7], [rows[0][:7]], pages.DIGITS).splitlines()[2]
    assert row in (DOCS / "tradeoff.md").read_text()


def test_where_an_engine_has_no_such_orbit_nothing_is_shifted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    right = boundary.engine_point

    def fails(setup: object, sought: object, count: int, guess: object) -> object:
        if count == 40:
            raise EngineError("boundary", "on the reference's orbit: no number came back")
        point = right(setup, sought, count, guess)  # type: ignore[arg-type]
        return replace(point, is_solved=count != 80)

    monkeypatch.setattr(boundary, "engine_point", fails)
    found = shift("hula_hoop", BOUNDARY, "mujoco", "tree", "RK4", (40, 80, 160))
    assert list(found.shifts.values())[:2] == [None, None]
    assert found.shifts["160"] == pytest.approx(4.5e-6, rel=0.02)
    assert found.slope is None
    assert found.problems == {"40": "on the reference's orbit: no number came back"}
    assert pages.stability_table([found])[1][0][5:7] == ("-", "-")


def test_all_that_is_measured_can_be_sent_and_written() -> None:
    """Each piece is a callable for another process; results stand in the document and the page."""
    scenes = ("hula_hoop", "rotating_beam", "speed_regulator")
    pieces = Tradeoff.of_request(TradeoffRequest(scenes, ("mujoco", "exudyn"))).pieces()
    assert pickle.loads(pickle.dumps(list(pieces))) == list(pieces)
    methods = [one.name for one in get_engine("exudyn").methods]
    names = [name for name, _ in boundaries_of(("hula_hoop",), ("exudyn",))]
    assert names == [f"hula_hoop exudyn {name}, {BOUNDARY}" for name in methods]
    assert set(names) < set(pieces)
    result = Tradeoff((0.01,), ("hula_hoop",), ("exudyn",))
    absolute = next(name for name in pieces if "absolute coordinates, kinematic_tree" in name)
    result.add(pieces[absolute][1]())
    result.add(shift("hula_hoop", BOUNDARY, "exudyn", "kinematic_tree", "RK44", (160, 320)))
    document = validated("tradeoff", result.as_json())
    assert document["left_out"][0]["left_out"] == "absolute coordinates"
    assert document["stability"][0]["shifts"]["160"] == pytest.approx(-4.84e-6, rel=0.01)
    page = pages.markdown(result)
    assert "## What may be left out" in page
    assert "| RK44 | 4 | -4.8e-06 | -3.1e-07 |" in page


def test_reports_fit_80_columns() -> None:
    """All tables of a scene: choices, parts that may be left out, limits, shifts of boundaries."""
    result = Tradeoff((1e-2, 1e-3), ("rotating_beam",), ("exudyn",))
    cost = Cost(1.23e-3, 1.2e-3, 1.4e-3, 640.0)
    points = tuple(Point(2.0**-k, 1e-3 * 2.0**-k, {}, cost, STEP, "step") for k in range(3, 7))
    for options in ({}, {"segments": 6.0}, {"newton_tolerance": 1e-4}):
        words = "rotating_beam", "steady_rotation", "exudyn", "elements", "GeneralizedAlpha"
        name = "spatial discretisation" if options else ""
        result.add(StepSeries(*words, 2, options, points, 2.0, 1e-4, name, 0.5))
    models = "absolute coordinates, kinematic_tree RK44", "minimal coordinates RK44"
    ratios = (1.9, 2.0, 2.1)
    result.add(LeftOut(*words[:3], "rotary inertia", *models, 1e-6, 5e-3, ratios, "wall time"))
    shifts = {str(count): -4.84e-6 for count in (40, 80, 160, 320, 640)}
    result.add(StabilityShift(*words, 4, "force_amplitude", "N", shifts, {}, 4.0, 1e-9))
    result.failures.append("rotating_beam exudyn elements: timeout: " + "it took too long " * 9)
    printed = io.StringIO()
    console = Console(file=printed, width=80, force_terminal=True, color_system=None)
    print_sections(console, pages.sections(result))
    titles = ["Cheapest settings", "Smallest models", "What may be left out", pages.LIMITS]
    assert [title for title in titles if title not in printed.getvalue()] == []
    assert [line for line in printed.getvalue().splitlines() if len(line) > 80] == []

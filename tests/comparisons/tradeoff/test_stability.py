"""What a step costs in stability: shifts of boundary points, their orders, page and pictures."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from mbcheck.comparisons.checks.kinds import boundary
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.reports.files import Destination
from mbcheck.comparisons.reports.text import markdown_table
from mbcheck.comparisons.tradeoff import pages
from mbcheck.comparisons.tradeoff.report import Tradeoff
from mbcheck.comparisons.tradeoff.stability import AXIS, boundary_shift, tasks
from mbcheck.comparisons.tradeoff.table import STEP, Cost, Point, StepSeries
from mbcheck.comparisons.tradeoff.verb import write
from mbcheck.reference import get_scene
from mbcheck.reference.errors import EngineError
from mbcheck.reference.scene import Case
from mbcheck.tests.support.documents import validated

DOCS = Path(__file__).parents[3] / "docs"


@pytest.fixture(scope="module")
def case() -> Case:
    return next(case for case in get_scene("hula_hoop").cases if case.boundary)


@pytest.mark.parametrize(
    ("engine", "method", "order"),
    [("mujoco", "RK4", 4), ("mujoco", "Euler", 1), ("exudyn", "GeneralizedAlpha", 2)],
)
def test_engines_converge_to_the_reference_with_their_order(
    engine: str, method: str, order: int, case: Case
) -> None:
    """The page has the same numbers."""
    pytest.importorskip(engine, exc_type=ImportError)
    model = get_engine(engine).models("hula_hoop")[0]
    found = boundary_shift(case, engine, model, method, (40, 80))
    assert all(point.bound is not None and point.bound < 1e-6 for point in found.points)
    assert found.slope == pytest.approx(order, abs=0.35)
    assert (found.order, found.unit, found.quantity) == (order, "N", "force_amplitude")
    row = markdown_table(("",) * 9, [pages.shift_cells(found)[:7]], pages.DIGITS).splitlines()[2]
    assert row in (DOCS / "tradeoff.md").read_text()


def test_methods_are_those_that_can_be_judged() -> None:
    """All of the engine's default model, where a case has a boundary."""
    pytest.importorskip("exudyn", exc_type=ImportError)
    names = [name for name, _ in tasks(("hula_hoop", "speed_regulator"), ("exudyn",))]
    case = next(case for case in get_scene("hula_hoop").cases if case.boundary)
    engine = get_engine("exudyn")
    assert names == [
        f"hula_hoop exudyn {method.name}, loss_of_symmetry_5hz"
        for method in engine.methods
        if engine.why_not(case, "kinematic_tree", method) is None
    ]


def test_where_there_is_no_point_it_says_why(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("mujoco", exc_type=ImportError)
    right = boundary.engine_point

    def fails(setup: object, sought: object, count: int, guess: object) -> object:
        if count == 40:
            raise EngineError("boundary", "on the reference's orbit: no number came back")
        point = right(setup, sought, count, guess)  # type: ignore[arg-type]
        return replace(point, is_solved=count != 80)

    monkeypatch.setattr(boundary, "engine_point", fails)
    found = boundary_shift(case, "mujoco", "tree", "RK4", (40, 80, 160))
    assert [point.error for point in found.points[:2]] == [None, None]
    assert found.points[2].error == pytest.approx(4.5e-6, rel=0.02)
    assert found.slope is None
    assert "no number came back" in found.points[0].reason


def shift(method: str, *shifts: float | None) -> StepSeries:
    points = tuple(
        Point(None, one, {} if one is None else {"force_amplitude": -one}, value=count, bound=1e-9)
        for count, one in zip((40, 80, 160, 320, 640), shifts, strict=True)
    )
    return StepSeries(
        "hula_hoop", "a case", "mujoco", "tree", method, 1, {}, points, 1.0, 1e-9,
        axis=AXIS, unit="N", quantity="force_amplitude",
    )  # fmt: skip


def test_a_page_shows_its_pictures(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    points = tuple(Point(2.0**-k, 4.0**-k, {}, Cost(1, 1, 1, 1), STEP) for k in (3, 4))
    series = StepSeries("hula_hoop", "a case", "mujoco", "tree", "RK4", 4, {}, points)
    shifts = [shift("RK4", 1.0, 0.5, 0.25, 0.125, 0.0625), shift("Euler", None, 2, 1, 0.5, 0.25)]
    result = Tradeoff((0.01,), ("hula_hoop",), ("mujoco",), series=[series, *shifts])
    document = validated("tradeoff", result.as_json())
    assert [point["error"] for point in document["series"][2]["points"]] == [None, 2, 1, 0.5, 0.25]
    page, plot = tmp_path / "page.md", tmp_path / "one.png"
    write(result, None, Destination("--markdown", str(page)), Destination("--plot", str(plot)))
    for name in ("one.png", "one_stability.png"):
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")
    title = "What a step costs in stability"
    assert f"## {title}\n\n![{title}](one_stability.png)\n\n| scene |" in page.read_text()
    assert "| Euler | 1 | - | -2 | -1 | -0.5 | -0.25 | 1 | 1e-09 |" in page.read_text()

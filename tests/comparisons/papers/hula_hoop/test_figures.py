"""The figures of the hula_hoop paper, drawn."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.engines.registry import REFERENCE
from mbcheck.comparisons.papers.hula_hoop import figures, results
from mbcheck.comparisons.papers.hula_hoop.figures import FIGURES
from mbcheck.comparisons.papers.session import Session
from mbcheck.comparisons.reports.drawing import save
from mbcheck.comparisons.scenes.hula_hoop.motion import MOTIONS

from .test_measures import ENGINES, made_up


def draw(number: int, session: Session) -> Any:
    return next(item for item in FIGURES if item.number == number).draw(session)


def test_captions_are_sentences() -> None:
    assert all(item.caption.endswith(".") for item in FIGURES)


@pytest.mark.parametrize(("number", "lines"), [pytest.param(2, 5, marks=pytest.mark.slow), (3, 4)])
def test_figures_of_motions(number: int, lines: int, tmp_path: Path) -> None:
    figure = draw(number, Session(engines=ENGINES))
    axes = np.reshape(figure.axes, (3, 2))
    for left, right in axes:
        assert len(left.lines) == lines
        assert right.get_yscale() == "log"
    save(figure, tmp_path / "figure.png")
    assert (tmp_path / "figure.png").stat().st_size > 10_000


def test_figure_of_stability() -> None:
    """With the printed solution in place of the true rotation, to save time."""
    session = Session(points=5)
    printed = results.stability_map(session, False, model="paper")
    session.cache[results.SCENE, "floquet", False, REFERENCE, None] = printed
    figure = draw(4, session)
    assert len(figure.axes) == 6
    counts = [sum(len(line.get_xdata()) for line in axes.lines) for axes in figure.axes[:4]]
    assert counts[:2] == [25, 25]  # the printed solution exists everywhere
    assert counts[3] == 25
    as_printed = results.stable(session, False, "printed")
    blue = sum(len(line.get_xdata()) for line in figure.axes[0].lines if filled(line))
    assert blue == as_printed.sum()
    regions = {text.get_text(): text.xy for text in figure.axes[0].texts}
    assert set(regions) == {"I", "II"}
    for number, (x, y) in regions.items():
        row, column = (
            int(np.argmin(abs(printed.y.values - y))),
            int(np.argmin(abs(printed.x.values - x))),
        )
        assert as_printed[row, column] == (number == "II")


def filled(line: Any) -> bool:
    return bool(line.get_markerfacecolor() == figures.BLUE)


def test_figure_of_motions_from_rest() -> None:
    session = made_up(*ENGINES)
    own = session.cache[results.SCENE, "class", False, "exudyn", None]
    own.variables["motion"][5, 5] = MOTIONS.index("cyan_plus")
    figure = draw(5, session)
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert "mujoco agrees at 100.0%" in titles[1]
    assert "exudyn agrees at 97.1%" in titles[2]
    markers = {line.get_marker(): len(line.get_xdata()) for line in figure.axes[0].lines
               if len(line.get_xdata())}  # fmt: skip
    assert markers == {"o": 18, "x": 18}
    apart = {line.get_label(): len(line.get_xdata()) for line in figure.axes[3].lines}
    assert apart == {"not robust": 1, "mujoco differs": 0, "exudyn differs": 1}

"""The figures of the speed_regulator paper, drawn."""

from __future__ import annotations

import pytest

from mbcheck.comparisons.papers.session import Session
from mbcheck.comparisons.papers.speed_regulator.figures import FIGURES
from mbcheck.tests.support.papers.shared import SharedSession, folder_of_all


def test_a_figure_is_drawn_without_engines() -> None:
    pytest.importorskip("matplotlib")
    figure = next(item for item in FIGURES if item.number == 6).draw(Session())
    assert len(figure.axes) == 4
    assert all(item.caption.count("our choice") for item in FIGURES)


@pytest.mark.slow
@pytest.mark.parametrize("number", [3, 4, 5, 6, 7])
def test_figures_are_drawn_with_all_engines(
    number: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    pytest.importorskip("matplotlib")
    engines = tuple(name for name in ("mujoco", "exudyn") if pytest.importorskip(name))
    figure = next(item for item in FIGURES if item.number == number)
    drawn = figure.draw(SharedSession(engines, folder=folder_of_all(tmp_path_factory)))
    words = {text.get_text() for text in drawn.legends[0].get_texts()}
    assert {"mujoco", "exudyn"} <= {word.partition(",")[0] for word in words}

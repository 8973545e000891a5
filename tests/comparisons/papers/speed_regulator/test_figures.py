"""The figures of the speed_regulator paper, drawn."""

from __future__ import annotations

import pytest

from mbcheck.comparisons.papers.session import Session
from mbcheck.comparisons.papers.speed_regulator.figures import FIGURES


def test_a_figure_is_drawn_without_engines() -> None:
    pytest.importorskip("matplotlib")
    figure = next(item for item in FIGURES if item.number == 6).draw(Session())
    assert len(figure.axes) == 4
    assert all(item.caption.count("our choice") for item in FIGURES)


@pytest.mark.slow
@pytest.mark.parametrize("number", [3, 4, 5, 6, 7])
def test_figures_are_drawn_with_all_engines(number: int, with_engines: Session) -> None:
    pytest.importorskip("matplotlib")
    for engine in ("mujoco", "exudyn"):
        pytest.importorskip(engine)
    figure = next(item for item in FIGURES if item.number == number)
    drawn = figure.draw(with_engines)
    words = {text.get_text() for text in drawn.legends[0].get_texts()}
    assert {"mujoco", "exudyn"} <= {word.partition(",")[0] for word in words}

"""The figures of the rotating_beam paper, drawn."""

from __future__ import annotations

from dataclasses import replace

import pytest

from mbcheck.comparisons.papers.rotating_beam.figures import FIGURES, MASS_COLOURS
from mbcheck.comparisons.papers.rotating_beam.results import MASSES
from mbcheck.comparisons.papers.session import Session


def test_captions_tell_what_the_text_leaves_open() -> None:
    assert tuple(MASS_COLOURS) == MASSES
    for figure in FIGURES:
        assert "text" in figure.caption  # says what is chosen


@pytest.mark.slow
@pytest.mark.parametrize("engines", [("exudyn",), ()], ids=["engine", "reference"])
def test_figures_are_drawn(engines: tuple[str, ...], with_engines: Session) -> None:
    pytest.importorskip("matplotlib")
    import matplotlib.pyplot as plt

    for figure in FIGURES if engines else FIGURES[:2]:
        drawn = figure.draw(replace(with_engines, engines=engines))
        lines = sum(len(axes.lines) for axes in drawn.axes)
        names = {text.get_text() for legend in drawn.legends for text in legend.get_texts()}
        assert names >= {f"reference, {mass}" for mass in ("no mass", "0.4 kg", "0.8 kg", "1.2 kg")}
        assert {"mujoco", "exudyn"} & names == set(engines)
        assert lines >= 8
        drawn.canvas.draw()
        plt.close(drawn)

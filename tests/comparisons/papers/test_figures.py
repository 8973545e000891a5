"""The figures of the papers, drawn."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import matplotlib.pyplot as plt
import pytest

from mbcheck.comparisons.papers.claims import read_paper, scenes_with_ledger
from mbcheck.comparisons.papers.session import Session

FIGURES = {
    (scene, figure.number): figure
    for scene in scenes_with_ledger()
    for figure in read_paper(scene).figures
}
QUICK = [("hula_hoop", 3), ("rotor_pendulum", 2), ("speed_regulator", 6)]
"""Figures that are drawn in a moment if no engine takes part."""

WITHOUT_ENGINES = {("rotor_pendulum", 2)}


def draw(key: tuple[str, int], session: Session) -> set[str]:
    """Draw a figure and return the words in it; only without engines a panel may be empty."""
    drawn = FIGURES[key].draw(session)
    panels = [axes for axes in drawn.axes if axes.get_visible()]
    assert panels[0].has_data()
    assert all(axes.has_data() for axes in panels) or not session.engines
    legends: list[Any] = [*drawn.legends, *(axes.get_legend() for axes in panels)]
    words = [text.get_text() for one in legends if one is not None for text in one.get_texts()]
    words += [axes.get_title(loc="left") for axes in panels]
    drawn.canvas.draw()
    plt.close(drawn)
    return set(words)


@pytest.mark.parametrize("key", QUICK)
def test_figure_is_drawn_without_engines(key: tuple[str, int], session: Session) -> None:
    words = " ".join(draw(key, replace(session, seconds=0.5)))
    assert not {name for name in ("mujoco", "exudyn") if name in words}


@pytest.mark.slow
@pytest.mark.parametrize("key", FIGURES)
def test_figure_is_drawn_with_all_engines(
    key: tuple[str, int], with_fewer: Callable[[str], Session]
) -> None:
    session = with_fewer(key[0])
    words = " ".join(draw(key, session))
    assert {name for name in session.engines if name in words} == (
        set() if key in WITHOUT_ENGINES else set(session.engines)
    )

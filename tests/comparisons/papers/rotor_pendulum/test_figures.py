"""The figures of the rotor_pendulum paper, drawn."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.papers.rotor_pendulum import figures, results
from mbcheck.comparisons.papers.rotor_pendulum.figures import FIGURES
from mbcheck.comparisons.papers.session import Session
from mbcheck.reference.rotor_pendulum import theory
from mbcheck.reference.rotor_pendulum.phase import wrapped


@pytest.mark.slow
@pytest.mark.parametrize("figure", FIGURES, ids=lambda figure: f"figure_{figure.number}")
def test_figures_are_drawn(figure: Any, with_fewer: Callable[[str], Session]) -> None:
    drawn = figure.draw(with_fewer("rotor_pendulum"))
    assert all(panel.has_data() for panel in drawn.axes[:6])


def test_figure_2_is_drawn() -> None:
    drawn = FIGURES[0].draw(Session())
    assert [panel.get_xlabel() for panel in drawn.axes[:4]] == ["$n_x$"] * 4


def test_figures_of_runs_are_drawn() -> None:
    drawn = FIGURES[3].draw(Session(("mujoco",), seconds=0.5))
    difference = drawn.axes[-2]
    names = [line.get_label() for line in difference.lines]
    assert names == ["mujoco", "the paper's (11)"]
    largest = [float(np.nanmax(line.get_ydata())) for line in difference.lines]
    assert largest[0] < 1e-6 < largest[1] < 1e-2


@pytest.mark.slow
def test_figure_3_is_drawn() -> None:
    session = Session(("mujoco",), points=2)
    drawn = figures.figure_3(session, {"pi/6": np.pi / 6})
    true = results.phase_map(session, np.pi / 6)
    own = results.phase_map(session, np.pi / 6, engine="mujoco")
    apart = figures.difference(own, true)
    assert np.nanmax(apart) < 1e-4
    by_theory, orbits, _ = (axes.get_title(loc="left") for axes in drawn.axes)
    assert by_theory.startswith("(a) The theory")
    jump, turn, *_ = drawn.axes[0].lines
    n_x, n_phi = jump.get_data()
    n = theory.Ratios(n_x, n_phi, beta=np.pi / 6)
    sides = [theory.stable_phase_difference(n._replace(n_phi=n_phi + s * 1e-3)) for s in (-1, 1)]
    here = np.isfinite(n_phi) & (abs(n_x - 1) > 0.1)
    assert np.median(abs(wrapped(sides[1] - sides[0]))[here]) == pytest.approx(np.pi, abs=0.05)
    assert turn.get_ydata()[0] == pytest.approx(2 / np.sqrt(3))
    assert orbits == f"Orbits, mujoco to {np.nanmax(apart):.1g} rad"
    shifted = own.variables["phase_difference"] + 0.1
    own.variables["phase_difference"][...] = shifted
    assert np.nanmin(figures.difference(own, true)) > 0.09

"""The ledger and the figures of the rotor_pendulum paper."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.papers.rotor_pendulum import derivation, figures, results
from mbcheck.comparisons.papers.rotor_pendulum import rows as paper
from mbcheck.comparisons.papers.session import Session
from mbcheck.reference import get_scene
from mbcheck.reference.rotor_pendulum import theory
from mbcheck.reference.rotor_pendulum.cases import CASE_1, CASE_2, CASE_3
from mbcheck.reference.rotor_pendulum.phase import wrapped


@pytest.fixture(scope="module")
def quick() -> Session:
    return Session()


@pytest.fixture(scope="module")
def complete(tmp_path_factory: pytest.TempPathFactory) -> Session:
    return Session(("mujoco", "exudyn"), folder=tmp_path_factory.mktemp("maps"))


@pytest.mark.slow
@pytest.mark.parametrize("figure", paper.FIGURES, ids=lambda figure: f"figure_{figure.number}")
def test_figures_are_drawn(figure: Any, complete: Session) -> None:
    drawn = figure.draw(complete)
    assert all(panel.has_data() for panel in drawn.axes[:6])


def test_figures_are_those_of_the_paper() -> None:
    assert [figure.number for figure in paper.FIGURES] == [2, 3, 4, 5, 6]


def test_figure_2_is_drawn(quick: Session) -> None:
    drawn = paper.FIGURES[0].draw(quick)
    assert [panel.get_xlabel() for panel in drawn.axes[:4]] == ["$n_x$"] * 4


def test_figures_of_runs_are_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(results, "HORIZONS", {2: 0.5})
    drawn = paper.FIGURES[3].draw(Session(("mujoco",)))
    difference = drawn.axes[-2]
    names = [line.get_label() for line in difference.lines]
    assert names == ["MuJoCo", "reduced, (11)"]
    largest = [float(np.nanmax(line.get_ydata())) for line in difference.lines]
    assert largest[0] < 1e-6 < largest[1] < 1e-2


def test_figure_3_is_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(results, "GRID", 4)
    monkeypatch.setattr(results, "ENGINE_GRID", 2)
    monkeypatch.setattr(figures, "BETAS", (np.pi / 6,))
    monkeypatch.setattr(figures, "BETA_NAMES", ("pi/6",))
    session = Session(("mujoco",))
    drawn = paper.FIGURES[1].draw(session)
    assert len(drawn.axes) == 4
    true = results.phase_map(session, np.pi / 6)
    found = results.phase_map(session, np.pi / 6, engine="mujoco")
    apart = figures.difference(found, true)
    assert np.nanmax(apart) < 1e-4
    assert np.isfinite(apart).any()
    shifted = found.variables["phase_difference"] + 0.1
    found.variables["phase_difference"][...] = shifted
    assert np.nanmin(figures.difference(found, true)) > 0.09


def test_shares_of_a_region() -> None:
    session = Session()
    shares, _ = shares_by_theory(session, 0.0, ((0.1, 1.0), (0.1, 7.0)))
    assert shares == {"synphase": 0.0, "antiphase": 1.0}
    shares, _ = shares_by_theory(session, np.pi / 3, ((1.0, 7.0), (1.0, 7.0)))
    assert shares["antiphase"] == pytest.approx(1 / 6, abs=0.02)  # n_phi < 2


def shares_by_theory(session: Session, beta: float, region: Any) -> Any:
    session.kept.clear()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(results, "GRID", 2)
        return paper.in_region(session, beta, region)


def test_settled_orbits_are_known() -> None:
    one, two, three = results.settled(Session(), [CASE_1, CASE_2, CASE_3])
    assert (one.kind, two.kind, three.kind) == ("antiphase", "synphase", "none")
    assert one.speed == pytest.approx(153.788, abs=1e-3)
    assert two.phase == pytest.approx(0.0636, abs=1e-4)
    assert three.words == "not there"


# Misprints ------------------------------------------------------------------------------------


def test_14_is_no_torque() -> None:
    """In V^2/ohm, a power; the torque is larger than section 5.2's by the electric speed."""
    ratio = derivation.motor_slope(1) / derivation.motor_slope(2)
    assert ratio == pytest.approx(100 * np.pi)  # an angular speed: the dimension that is missing
    slip = 50 * np.pi - 153.8
    assert derivation.motor_slope(1) * slip > 1000 * 3.08
    assert derivation.motor_slope(2) * slip > 5 * 3.08


def test_18_has_factors_that_are_not_eta() -> None:
    assert derivation.equation_18_residual(6.0) < 1e-14  # eta_21 = 1, eta_31 = 5
    for wrong in (25 * 6.0, 5 * 6.0, 5.0, 1.0):
        assert derivation.equation_18_residual(wrong) > 1e-3


def test_mu_1_is_swapped() -> None:
    assert derivation.equation_20_residual(False) < 1e-12 < derivation.equation_20_residual(True)


def test_the_first_panel_of_figure_2_is_mu_4() -> None:
    second, fourth = derivation.caption_errors()
    assert fourth == 0  # as printed, mu_1 and mu_4 are one expression
    assert second > 0.5


def test_35_as_printed_is_zero() -> None:
    printed, right = derivation.equation_35_derivatives()
    assert printed == 0
    assert right == pytest.approx(-float(theory.coupling_amplitude(derivation.UNDAMPED)), rel=1e-6)


def test_11_is_right_with_the_other_sign() -> None:
    assert derivation.equation_11_residual(-1) < 1e-12
    assert derivation.equation_11_residual(1) > 0.1


def test_table_1_takes_the_wrong_masses() -> None:
    high, low = (derivation.beyond_table(100.0, 9.9, 157.0, n) for n in (0.1, 7.0))
    assert high == pytest.approx((246490000, 24402510), rel=1e-9)
    assert low == pytest.approx((50307, 4980), rel=1e-4)


# Findings by another route ----------------------------------------------------------------------


def test_k_x_only_decides_between_opposite_phases() -> None:
    n_x = np.linspace(0.1, 7, 50)
    for beta in (0.3, np.pi / 6, 1.2):
        alpha = theory.stable_phase_difference(theory.Ratios(n_x, 2.5, beta=beta))
        assert np.max(abs(np.sin(alpha - alpha[0]))) < 1e-12
        assert np.max(abs(wrapped(alpha - alpha[0]))) == pytest.approx(np.pi)


def test_runs_are_the_same_whoever_solves_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(results, "HORIZONS", {2: 0.1})
    session = Session()
    truth, found = (results.from_rest(session, 2, name) for name in ("reference", "exudyn"))
    assert truth.states.shape == (8, len(truth.times)) == found.states.shape
    assert np.max(abs(truth.phase - found.phase)) < 1e-7
    first, second = truth.torques
    assert first[0] == second[0] == pytest.approx(0.94 * 50 * np.pi)
    assert get_scene("rotor_pendulum").state_names[:4] == ("x", "phi_1", "phi_2", "phi_3")

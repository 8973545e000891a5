"""What rows of the rotor_pendulum paper are made of: orbits, runs from rest, shares of regions."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.engines.registry import REFERENCE
from mbcheck.comparisons.papers.assess import assess
from mbcheck.comparisons.papers.ledger import NOT_REPRODUCED
from mbcheck.comparisons.papers.rotor_pendulum import cases, regions, results
from mbcheck.comparisons.papers.rotor_pendulum.rows import ROWS
from mbcheck.comparisons.papers.session import Session
from mbcheck.reference import get_scene
from mbcheck.reference.rotor_pendulum import theory
from mbcheck.reference.rotor_pendulum.cases import CASE_1, CASE_2, CASE_3
from mbcheck.reference.rotor_pendulum.phase import wrapped

BY_NAME = {row.name: row for row in ROWS}


def test_shares_of_a_region() -> None:
    whole = ((0.1, 1.0), (0.1, 7.0))
    numbers = shares_by_theory(0.0, whole)
    assert (numbers["synphase"], numbers["antiphase"]) == ([0.0], [1.0])
    assert numbers["theory"] == [{"synphase": 0.0, "antiphase": 1.0}]
    numbers = shares_by_theory(np.pi / 3, ((1.0, 7.0), (1.0, 7.0)))
    assert numbers["antiphase"] == [pytest.approx(1 / 6, abs=0.02)]  # n_phi < 2


def shares_by_theory(beta: float, region: Any) -> Any:
    return regions.kinds_in_regions(Session(points=2), REFERENCE, beta, (region,))


def test_settled_orbits_are_known() -> None:
    one, two, three = results.settled(Session(), [CASE_1, CASE_2, CASE_3])
    assert (one.kind, two.kind, three.kind) == ("antiphase", "synphase", "none")
    assert one.speed == pytest.approx(153.788, abs=1e-3)
    assert two.phase == pytest.approx(0.0636, abs=1e-4)
    assert three.words == "not there"


def test_curve_of_the_motor_has_the_slope_of_14_and_its_largest_torque() -> None:
    curve = cases.motor_curve(CASE_1, 8.0)
    speed = float(CASE_1.synchronous_speed)
    assert curve(speed) == 0
    assert curve(speed - 1e-4) / 1e-4 == pytest.approx(float(CASE_1.motor_slope), rel=1e-6)
    assert np.max(curve(np.linspace(0, speed, 100_001))) == pytest.approx(8.0)
    assert curve(0.0) < 2  # where (14) has 148 N m


def test_calibrated_case_1_has_the_printed_speed_and_torque() -> None:
    (orbit,) = results.settled(Session(), [cases.CALIBRATED])
    assert orbit.speed == pytest.approx(153.8, abs=1e-3)
    assert orbit.torque == pytest.approx(3.08, abs=1e-3)


def test_k_x_only_decides_between_opposite_phases() -> None:
    n_x = np.linspace(0.1, 7, 50)
    for beta in (0.3, np.pi / 6, 1.2):
        alpha = theory.stable_phase_difference(theory.Ratios(n_x, 2.5, beta=beta))
        assert np.max(abs(np.sin(alpha - alpha[0]))) < 1e-12
        assert np.max(abs(wrapped(alpha - alpha[0]))) == pytest.approx(np.pi)


def test_runs_are_the_same_whoever_solves_them() -> None:
    session = Session(seconds=0.1)
    truth, own = (results.from_rest(session, 2, name) for name in ("reference", "exudyn"))
    assert truth.states.shape == (8, len(truth.times)) == own.states.shape
    assert np.max(abs(truth.phase - own.phase)) < 1e-7
    first, second = truth.torques
    assert first[0] == second[0] == pytest.approx(0.94 * 50 * np.pi)
    assert get_scene("rotor_pendulum").state_names[:4] == ("x", "phi_1", "phi_2", "phi_3")


def test_without_an_orbit_nothing_is_reproduced() -> None:
    session = Session()
    for p in (CASE_1, cases.CALIBRATED):
        session.cache[results.SCENE, "orbit", p, REFERENCE, None] = None
    for name in ("case_1_speed", "case_1_platform_amplitude", "case_1_agreement"):
        assert assess(BY_NAME[name], session).verdict == NOT_REPRODUCED, name
    assert np.isnan(cases.gap_to_theory(session, REFERENCE, 1))


def test_rotor_on_the_rod_fluctuates_more() -> None:
    assert cases.fluctuations(Session(seconds=2.0), REFERENCE, 2)["ratio"] > 2


@pytest.mark.slow
@pytest.mark.parametrize("angle", ["pi/6", "pi/3"])
def test_orbits_begin_at_the_fold(angle: str, session: Session) -> None:
    """Sought from the theory's phase, an orbit is there just above the fold, and not below it."""
    n_x, n_phi = (float(values[1]) for values in regions.fold_curve(session, angle))
    beta = results.BETAS[angle]
    near = [regions.at_ratios(n_x, n_phi * factor, beta) for factor in (0.998, 1.004)]
    before, after = results.settled(session, near)
    assert (before.kind, after.kind) == ("none", "synphase")


def test_dampers_of_table_1_move_the_fold(session: Session) -> None:
    """A wrong damper, 1 % weaker, shows as a shift of the limit that its bound is far below."""
    (one,) = regions.folds(session, "pi/6")[1:2]
    wrong = replace(one, parameters=one.parameters.replace(rod_damping=0.99 * 15.0))
    here, there = (regions.ratio_of(item, item.solution[1].place[1]) for item in (one, wrong))
    assert 1e-4 < abs(there - here) < 0.1

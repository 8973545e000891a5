"""What rows of the rotor_pendulum paper are computed from: orbits, starts, regions, folds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mbcheck.comparisons.checks.boundary import engine_point
from mbcheck.comparisons.engines.registry import REFERENCE
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.papers.assess import assess
from mbcheck.comparisons.papers.claims import read_paper
from mbcheck.comparisons.papers.ledger import DEPENDS, NOT_REPRODUCED, REPRODUCED
from mbcheck.comparisons.papers.rotor_pendulum import measures
from mbcheck.comparisons.papers.session import Session
from mbcheck.comparisons.queries.query import choose_engine, choose_method
from mbcheck.comparisons.scenes.rotor_pendulum.phase import PHASES
from mbcheck.reference.rotor_pendulum import CASE_1, CASE_2, theory
from mbcheck.reference.rotor_pendulum.phase import coupling_torque
from mbcheck.reference.scene import Case

BY_NAME = {row.name: row for row in read_paper("rotor_pendulum").rows}


def test_shares_of_a_region() -> None:
    session, before = Session(points=2), (0.1, 1.0)
    level = measures.kinds_in_regions(session, REFERENCE, "0", [(before, (0.1, 7.0))])
    assert (level["synphase"], level["antiphase"]) == ([0.0], [1.0])
    steep = measures.kinds_in_regions(session, REFERENCE, "pi/3", [((1.0, 7.0), (1.0, 7.0))])
    assert steep["antiphase"] == pytest.approx(0.9 / 5.9, abs=0.005)  # n_phi from 1.1 to 2
    strip = measures.kinds_in_regions(session, REFERENCE, "pi/6", [(before, before)])
    assert strip["lesser_anywhere"] > 0.02
    assert strip["lesser"] == strip["synphase"] == [0.0]


def test_rows_of_figure_3_fail_where_the_other_kind_is_stable(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    row, right = BY_NAME["fig_3c_antiphase"], theory.stable_phase_difference
    assert assess(row, Session(points=2)).verdict == REPRODUCED
    monkeypatch.setattr(theory, "stable_phase_difference", lambda *n: right(*n) + np.pi)
    assert assess(row, Session(points=2)).verdict == NOT_REPRODUCED


def test_coupling_is_absent_by_one_measure() -> None:
    rows = [BY_NAME[name] for name in ("case_3_no_coupling", "critical_conclusion")]
    assert all(row.judgement == BY_NAME["level_rod_coupling"].judgement for row in rows)


def test_an_upright_rod_has_a_stable_orbit_with_the_springs_of_case_1() -> None:
    p = CASE_1.replace(installation_angle=np.pi / 2)
    assert measures.kind_of(measures.synchronous_orbit(Session(), p)) == "antiphase"
    assert assess(BY_NAME["critical_phase"], Session()).verdict == DEPENDS


def test_curve_of_the_motor_has_the_slope_of_14_and_its_largest_torque() -> None:
    speed = float(CASE_1.synchronous_speed)
    rest, slow, none = measures.motor_torque(CASE_1, 8.0, np.array([0.0, speed - 1e-4, speed]))
    assert none == 0
    assert slow / 1e-4 == pytest.approx(float(CASE_1.motor_slope), rel=1e-6)
    rates = np.linspace(0, speed, 100_001)
    assert np.max(measures.motor_torque(CASE_1, 8.0, rates)) == pytest.approx(8.0)
    assert rest < 2
    assert measures.motor_torque(CASE_1, None, rates)[0] == pytest.approx(0.94 * 50 * np.pi)


def test_calibrated_case_1_has_the_printed_speed_and_torque() -> None:
    """Which is why the rows of both are not testable."""
    orbit = measures.synchronous_orbit(Session(), measures.CALIBRATED)
    assert measures.orbit_value(orbit, "mean_speed") == pytest.approx(153.8, abs=1e-3)
    assert measures.orbit_value(orbit, "motor_torque_1") == pytest.approx(3.08, abs=1e-3)


def test_runs_are_the_same_whoever_solves_them() -> None:
    session = Session(seconds=0.1)
    truth, own = (measures.from_rest(session, 2, name) for name in (REFERENCE, "exudyn"))
    assert truth.states.shape == (8, len(truth.times)) == own.states.shape
    assert np.max(abs(truth.phase - own.phase)) < 1e-7
    reduced = measures.from_rest(session, 2, measures.REDUCED)
    other = measures.other_start(session, 2, 0.1)
    assert np.max(abs(reduced.phase - other.phase)) < 1e-6
    for changed in ({"inertia": 0.49}, {"as_printed": True}):
        moved = measures.other_start(session, 2, 0.1, **changed)
        assert np.max(abs(moved.states[3] - other.states[3])) > 1e-3


def test_without_an_orbit_nothing_is_reproduced() -> None:
    session = Session()
    for p in (CASE_1, CASE_1.replace(rod_damping=0.0), measures.CALIBRATED):
        session.cache["rotor_pendulum.synchronous_orbit", p, REFERENCE, None] = None
    for name in ("case_1_platform_amplitude", "case_1_agreement"):
        assert assess(BY_NAME[name], session).verdict == NOT_REPRODUCED, name
    assert measures.kind_of(None) == "none"


def test_coupling_cannot_be_as_large_as_the_torques_of_section_5() -> None:
    """The vibration's mean power on both rotors, undamped, at 720 phase differences."""
    alpha = np.linspace(-np.pi, np.pi, 720)
    bounds = measures.coupling_torques(Session())["on_a_rotor"]
    for case, bound, printed in zip((CASE_1, CASE_2), bounds, (3.08, 3.23), strict=True):
        free = case.replace(platform_damping=0.0, rod_damping=0.0)
        assert np.max(abs(coupling_torque(free, alpha))) / 2 == pytest.approx(bound, rel=1e-3)
        assert 3 * bound < printed


def test_table_1_takes_the_wrong_masses() -> None:
    for ratio, platform, rod in ((0.1, 246490000, 24402510), (7.0, 50307, 4980)):
        for spring, printed in (("platform", platform), ("rod", rod)):
            mistaken = measures.stiffness(Session(), ratio, spring)["mistaken"]
            assert mistaken == pytest.approx(printed, rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("angle", ["pi/6", "pi/3"])
def test_orbits_end_before_resonance_and_begin_at_the_fold(angle: str, session: Session) -> None:
    n_x, n_phi = (float(values[1]) for values in measures.fold_curve(session, angle))
    columns, beta = ("n_x", n_x, n_x + 1e-6, 2), {"installation_angle": measures.BETAS[angle]}
    for ends, kinds in (
        ((0.8, 0.95), ["synphase", "none"]),
        ((0.998 * n_phi, 1.004 * n_phi), ["none", "synphase"]),
    ):
        rows = ("n_phi", *ends, 2)
        plane = session.map(
            "rotor_pendulum", "phase", columns, rows, model="exact", parameters=beta
        )
        assert [PHASES[int(kind)] for kind in plane.variables["class"][:, 0]] == kinds


def test_dampers_of_table_1_move_the_fold(session: Session) -> None:
    """A wrong damper, 1 % weaker, shows as a shift of the limit that its bound is far below."""
    (one,) = measures.folds(session, "pi/6")[1:2]
    wrong = replace(one, parameters=one.parameters.replace(rod_damping=0.99 * 15.0))
    here, there = (measures.ratio_of(item, item.solution[1].place[1]) for item in (one, wrong))
    assert 1e-4 < abs(there - here) < 0.1


ENGINE_SHIFTS = {"mujoco": (5e-5, 0.07), "exudyn": (6e-7, 0.07)}
"""Of folds with 40 steps in a period, as docs/boundaries.md has them: n_phi, k_phi [N m/rad]."""


@pytest.mark.slow
@pytest.mark.parametrize("engine", sorted(ENGINE_SHIFTS))
def test_engines_have_the_folds_of_figure_3(engine: str) -> None:
    shifts = []
    for angle in measures.STARTS:
        for one in measures.folds(Session(), angle):
            case = Case("rotor_pendulum", "point", one.parameters)
            its, model = choose_engine(engine, case, None)
            setup = Setup(its, case, model, choose_method(its, case, model, None))
            true = one.solution[1].z
            own = engine_point(setup, one, 40, true).z
            places = [measures.ratio_of(one, z[-1]) for z in (own, true)]
            shifts.append((abs(places[0] - places[1]), one.unit * abs(own[-1] - true[-1])))
    largest, most = np.max(shifts, axis=0), ENGINE_SHIFTS[engine]
    assert 0.5 * most[0] < largest[0] < 1.2 * most[0]
    assert largest[1] < 1.2 * most[1]

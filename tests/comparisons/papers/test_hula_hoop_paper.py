"""The hula_hoop paper reproduced: its rows, the misprints behind them, and its figures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp

from mbcheck.comparisons.maps.run import Axis, Map
from mbcheck.comparisons.papers.hula_hoop import derivation, figures, readings, results
from mbcheck.comparisons.papers.hula_hoop import regions as claims
from mbcheck.comparisons.papers.hula_hoop import rows as paper
from mbcheck.comparisons.papers.ledger import CORRECTED, NOT_REPRODUCED, REPRODUCED, VERDICTS
from mbcheck.comparisons.papers.session import Session
from mbcheck.comparisons.queries.query import choose_engine
from mbcheck.comparisons.reports.drawing import save
from mbcheck.comparisons.scenes.hula_hoop.motion import MOTION_VARIABLES, MOTIONS
from mbcheck.reference.hula_hoop.equations import SEMICIRCLE, HulaHoop
from mbcheck.reference.hula_hoop.floquet import floquet_multipliers
from mbcheck.reference.hula_hoop.theory import corrected_solution, nondimensional

ENGINES = ("mujoco", "exudyn")

ROWS = {row.name: row for row in paper.ROWS}


@pytest.fixture(scope="module")
def session() -> Session:
    return Session(engines=ENGINES)


# --- Rows -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name", ["mean_slope", "eigenvalues_62", "transient_end", "equations_of_motion"]
)
def test_engines_answer_where_they_can(session: Session, name: str) -> None:
    assert set(ROWS[name].find(session).engines) == set(ENGINES)


# --- Rows can fail --------------------------------------------------------------------------


def test_a_wrong_engine_fails_the_equations(monkeypatch: pytest.MonkeyPatch) -> None:
    class Wrong:
        def __init__(self, engine: Any) -> None:
            self.engine = engine

        def accelerations(self, *args: Any) -> Any:
            return 1.001 * self.engine.accelerations(*args)

    def chosen(*args: Any) -> Any:
        engine, model = choose_engine(*args)
        return Wrong(engine), model

    monkeypatch.setattr(derivation, "choose_engine", chosen)
    found = derivation.equations_of_motion(Session(engines=("mujoco",)))
    assert found.verdict == NOT_REPRODUCED


def test_a_wrong_plate_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(derivation, "SEMICIRCLE", SEMICIRCLE + 1e-3)
    assert derivation.plate_inertia(Session()).verdict == NOT_REPRODUCED


def test_a_formula_that_is_right_as_printed_is_no_misprint() -> None:
    assert derivation.misprint(1e-16, 1e-16, "").verdict == NOT_REPRODUCED
    assert derivation.misprint(1.0, 1e-3, "").verdict == NOT_REPRODUCED
    assert derivation.misprint(1.0, 1e-12, "").verdict == CORRECTED


# --- Misprints ------------------------------------------------------------------------------

tau, alpha, u_1, gamma, q_1, beta = sp.symbols("tau alpha u_1 gamma q_1 beta", real=True)
PSI = 2 * alpha * tau - gamma
THETA = alpha * tau + u_1 * sp.cos(PSI)
POINT = {tau: 0.9, alpha: 0.7, u_1: 0.35, gamma: 1.1, q_1: 1.4, beta: 0.3}


def value(expression: Any) -> float:
    return float(sp.N(expression.subs(POINT)))


def test_velocity_and_damper_force_have_dots() -> None:
    t, c, R = sp.symbols("t c R")
    theta, y = sp.Function("theta")(t), sp.Function("y")(t)
    velocity = sp.diff(R * sp.cos(theta), t)
    assert sp.simplify(velocity + R * theta.diff(t) * sp.sin(theta)) == 0
    assert sp.simplify(velocity + R * theta * sp.sin(theta)) != 0
    # What is left out of (5) on both readings: only c y' takes energy out.
    force = {"printed": -c * y, "corrected": -c * y.diff(t)}
    power = {name: sp.expand(f * y.diff(t)) for name, f in force.items()}
    assert power["corrected"] == -c * y.diff(t) ** 2
    assert sp.simplify(power["printed"] - sp.diff(-c * y**2 / 2, t)) == 0


def test_25_lacks_alpha() -> None:
    f_u, sine = 2 * alpha, sp.sin(PSI)
    truth = sp.diff(THETA, tau) ** 2
    corrected = alpha**2 - 2 * alpha * u_1 * f_u * sine + (u_1 * f_u * sine) ** 2
    printed = alpha**2 - 2 * u_1 * f_u * sine + (u_1 * f_u * sine) ** 2
    assert sp.simplify(corrected - truth) == 0
    assert abs(value(printed - truth)) > 0.01


def test_30_lacks_its_sine_part() -> None:
    truth = sp.diff(THETA, tau, 2) * sp.cos(THETA)
    bend = -u_1 * (2 * alpha) ** 2 * sp.cos(PSI)
    j = [sp.besselj(n, u_1) for n in range(6)]
    even = j[0] - 2 * j[2] * sp.cos(2 * PSI) + 2 * j[4] * sp.cos(4 * PSI)
    odd = 2 * j[1] * sp.cos(PSI) - 2 * j[3] * sp.cos(3 * PSI) + 2 * j[5] * sp.cos(5 * PSI)
    corrected = bend * (sp.cos(alpha * tau) * even - sp.sin(alpha * tau) * odd)
    printed = bend * sp.cos(alpha * tau) * even - bend + 4 * j[5] * sp.cos(5 * PSI)
    assert abs(value(corrected - truth)) < 1e-6
    assert abs(value(printed - truth)) > 0.1


def test_41_is_garbled_and_42_is_right() -> None:
    """Coefficient of cos(2 alpha tau), by a sum over a period of q'' cos(theta)."""
    truth = sp.diff(q_1 * sp.cos(alpha * tau - beta), tau, 2) * sp.cos(THETA)
    count = 48
    harmonic = sum(
        value(
            (2 * truth * sp.cos(2 * alpha * tau) / count).subs(tau, 2 * sp.pi * k / (count * alpha))
        )
        for k in range(count)
    )
    j = [sp.besselj(n, u_1) for n in range(3)]
    common = j[0] * sp.cos(beta) - j[2] * sp.cos(beta - 2 * gamma) - j[1] * sp.sin(beta - gamma)
    factor = -q_1 * alpha**2 / 2
    in_42 = factor * (common + j[1] * sp.sin(-beta - gamma))
    in_41 = factor * (common + j[1] + 2 * (-beta - gamma))
    assert value(in_42) == pytest.approx(harmonic, abs=1e-10)
    assert abs(value(in_41) - harmonic) > 0.1


def test_45_solves_another_equation() -> None:
    """Its correction solves V'' + V = -cos 2 alpha tau; the angle has no spring."""
    v = (sp.cos(2 * alpha * tau) - sp.cos(tau)) / -(1 - 4 * alpha**2)
    torque = sp.cos(2 * alpha * tau)
    assert sp.simplify(sp.diff(v, tau, 2) + v + torque) == 0
    inertia, friction = sp.Rational(1), sp.Rational(1, 100)
    assert abs(value(inertia * sp.diff(v, tau, 2) + friction * sp.diff(v, tau) + torque)) > 0.1


def test_eigenvalues_of_62_do_not_decide() -> None:
    """A(tau) of a stable rotation has an eigenvalue outside the unit circle all the time."""
    p = HulaHoop()
    solution = corrected_solution(p)
    moduli = derivation.rate_moduli(solution, p)
    assert np.all(moduli.max(axis=1) > 1)
    assert abs(floquet_multipliers(solution, p)[0]) < 1


# --- What rows are made of ------------------------------------------------------------------


def test_lock_in_sees_slips_reversals_and_the_direction() -> None:
    times = results.samples(12.0)
    omega = 6 * np.pi
    for sign in (1, -1):
        theta = sign * (omega * times - 2 * np.pi / (1 + np.exp(40 * (times - 2))))
        speed = np.gradient(theta, times)
        speed[times < 1.0] *= -1
        found = results.lock_in(times, theta, speed)
        assert found.direction == sign
        assert found.turns == pytest.approx(1)
        assert 1.5 < found.last_slip <= 2.0
        assert found.last_reversal == pytest.approx(1.0, abs=0.01)
        assert found.settled <= 2.34
        assert found.least_speed == pytest.approx(1, abs=1e-6)


def test_second_harmonic_and_errors_are_those_of_the_orbit(session: Session) -> None:
    run = results.example_rotation(session)
    theta = run.observables["theta"][:-1] - 6 * np.pi * run.times[:-1]
    amplitude = 2 * abs(np.fft.rfft(theta)[6]) / len(theta)  # three periods
    assert results.second_harmonic(results.example_orbit(session)) == pytest.approx(amplitude)
    errors = results.approximation_errors(session)
    assert errors["paper"][1] > 1.4 > 0.1 > errors["corrected"][1]


def test_difference_of_angles_is_taken_on_the_circle() -> None:
    gap = results.apart(np.array([[1.0], [7.0], [0], [0]]), np.array([[0.5], [0.5], [0], [0]]))
    assert gap[:2, 0] == pytest.approx([0.5, 6.5 - 2 * np.pi])


def test_regions_are_connected_and_sorted() -> None:
    where = np.zeros((6, 8), dtype=bool)
    where[0, 0] = where[1, 1] = where[2, 2] = True  # by their corners
    where[0:5, 5] = True
    where[5, 0] = True  # one point alone
    assert [int(region.sum()) for region in results.regions(where)] == [5, 3]
    assert claims.near(where, 1)[5, 1]
    assert not claims.near(where, 1)[5, 3]


def synthetic(count: int = 6) -> Map:
    """Fig. 5 with hula-hoop motion in the lower half, one point of it not robust."""
    motion = np.full((count, count), MOTIONS.index("red_x"), np.int8)
    motion[: count // 2] = MOTIONS.index("blue_o")
    robust = np.ones_like(motion)
    robust[0, 0] = 0
    variables: dict[str, Any] = {"motion": motion, "label": 0 * motion, "robust": robust}
    for name in ("turns", "f_u", "min_speed", "periods"):
        variables[name] = np.ones((count, count))
    return Map(
        Axis("force_frequency", 1.0, 10.0, count),
        Axis("force_amplitude", 5.0, 150.0, count),
        variables,
        MOTION_VARIABLES,
        np.ones((count, count), dtype=bool),
        {"scene": "hula_hoop", "quantity": "class", "engine": "reference", "model": "exact",
         "method": None},
    )  # fmt: skip


def test_agreement_counts_robust_points(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(results, "motion_map", lambda *args: synthetic())
    said = np.zeros((6, 6), dtype=bool)
    said[:4] = True  # six points too many; the one that is not robust would be right
    monkeypatch.setattr(results, "stable", lambda *args: said)
    found = results.agreement(Session(), False, "paper")
    assert found.points == 35
    assert found.share == pytest.approx(29 / 35)
    assert found.stable_only == pytest.approx(6 / 35)
    assert found.motion_only == 0
    assert found.trivial == pytest.approx(18 / 35)


@pytest.mark.filterwarnings("ignore:An input array is constant")
def test_rows_on_regions_read_the_maps(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a grid of 6 x 6 points, the motion from rest made up."""

    def motion_map(session: Session, plate: bool, engine: str = "") -> Map:
        found = synthetic()
        if plate:  # a row more of hula-hoop motion
            found.variables["motion"][3] = MOTIONS.index("blue_o")
        return found

    def cheap(session: Session, plate: bool, engine: str = "", model: str | None = None) -> Map:
        return real(session, plate, model=model or "corrected")

    real = results.stability_map
    monkeypatch.setattr(results, "POINTS", 6)
    monkeypatch.setattr(results, "HERTZ", (4.0, 10.0))  # slow drives take many steps
    for module in (results, claims, derivation):
        monkeypatch.setattr(module, "motion_map", motion_map, raising=False)
        monkeypatch.setattr(module, "stability_map", cheap, raising=False)
    small = Session()
    found = {row.name: row.find(small) for row in claims.ROWS}
    assert all(item.verdict in VERDICTS and item.reason for item in found.values())
    assert found["easier_with_inertia"].verdict == REPRODUCED
    assert found["easier_with_inertia"].reference == "50.0% to 66.7%"
    assert found["fewer_red"].verdict == REPRODUCED
    assert found["fewer_cyan"].verdict == NOT_REPRODUCED
    assert found["region_3"].verdict == NOT_REPRODUCED
    calm = results.stable(small, False, "exact")
    assert found["large_set"].reference.startswith(f"{np.mean(calm):.0%}")
    robust = synthetic().variables["robust"] == 1
    hoop = np.arange(6)[:, None] < 3
    share = np.mean((results.stable(small, False, "paper") == hoop)[robust])
    assert found["good_agreement_4_5"].reference == f"{share:.1%}"


def test_readings_of_the_damping(session: Session) -> None:
    """The nondimensional reading locks in as `simulate` says, 0.1 N s/m does not."""
    ours, other = readings.from_rest(
        HulaHoop(damping_ratio=np.array([0.1, 0.1 / (2 * 0.495 * 44.947)]))  # type: ignore[arg-type]
    )
    run = results.example_from_rest(session)
    single = results.lock_in(run.times, run.observables["theta"], run.observables["theta_dot"])
    assert ours == single or ours.last_reversal == pytest.approx(single.last_reversal, abs=0.01)
    assert abs(other.turns - 1) > results.LOCKED


def test_one_eleventh(session: Session) -> None:
    assert ROWS["mass_ratio"].find(session).reference == "0.090909"
    assert nondimensional(HulaHoop()).epsilon == pytest.approx(1 / 11)


# --- Figures --------------------------------------------------------------------------------


def drawn(number: int) -> Any:
    return next(item for item in figures.FIGURES if item.number == number)


def test_figures_are_2_to_7() -> None:
    assert [item.number for item in paper.FIGURES] == [2, 3, 4, 5, 6, 7]
    assert all(item.caption.endswith(".") for item in paper.FIGURES)


@pytest.mark.parametrize(("number", "lines"), [(2, 5), (3, 4)])
def test_figures_of_motions(session: Session, number: int, lines: int, tmp_path: Path) -> None:
    figure = drawn(number).draw(session)
    axes = np.reshape(figure.axes, (3, 2))
    for left, right in axes:
        assert len(left.lines) == lines
        assert right.get_yscale() == "log"
    save(figure, tmp_path / "figure.png")
    assert (tmp_path / "figure.png").stat().st_size > 10_000


def test_figure_of_stability(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the printed solution in place of the true rotation, to save time."""

    def cheap(session: Session, plate: bool, engine: str = "", model: str | None = None) -> Map:
        return results.stability_map(session, plate, model=model or "paper")

    monkeypatch.setattr(results, "POINTS", 5)
    monkeypatch.setattr(results, "HERTZ", (4.0, 10.0))
    monkeypatch.setattr(figures, "stability_map", cheap)
    small = Session()
    figure = drawn(4).draw(small)
    assert len(figure.axes) == 6
    shown = [sum(len(line.get_xdata()) for line in axes.lines) for axes in figure.axes[:4]]
    assert shown[:2] == [25, 25]  # the printed solution exists everywhere
    assert shown[2] == 25
    as_printed = results.stable(small, False, "printed")
    blue = sum(len(line.get_xdata()) for line in figure.axes[0].lines if filled(line))
    assert blue == as_printed.sum()


def filled(line: Any) -> bool:
    return bool(line.get_markerfacecolor() == figures.BLUE)


def test_figure_of_motions_from_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    def motion_map(session: Session, plate: bool, engine: str = "reference") -> Map:
        found = synthetic()
        if engine == "exudyn":
            found.variables["motion"][5, 5] = MOTIONS.index("cyan_plus")
        return found

    monkeypatch.setattr(figures, "motion_map", motion_map)
    figure = drawn(5).draw(Session(engines=ENGINES))
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert "MuJoCo, 100.0%" in titles[1]
    assert "Exudyn, 97.1%" in titles[2]
    markers = {line.get_marker(): len(line.get_xdata()) for line in figure.axes[0].lines
               if len(line.get_xdata())}  # fmt: skip
    assert markers == {"o": 18, "x": 18}
    apart = {line.get_label(): len(line.get_xdata()) for line in figure.axes[3].lines}
    assert apart == {"not robust": 1, "MuJoCo differs": 0, "Exudyn differs": 1}

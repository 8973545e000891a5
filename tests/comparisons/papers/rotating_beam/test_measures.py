"""What rows of the rotating_beam paper are made of, and that they can fail."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from mbcheck.comparisons.engines.registry import REFERENCE
from mbcheck.comparisons.papers.assess import assess
from mbcheck.comparisons.papers.claims import read_paper
from mbcheck.comparisons.papers.ledger import NOT_REPRODUCED
from mbcheck.comparisons.papers.rotating_beam import measures
from mbcheck.comparisons.papers.session import Session
from mbcheck.reference.errors import EngineError
from mbcheck.reference.rotating_beam import FIGURE_5, beam_scene
from mbcheck.reference.rotating_beam.frequencies.numbers import numbers, tension
from mbcheck.reference.rotating_beam.frequencies.stretching import frequencies as natural_modes
from mbcheck.tests.support.papers.shared import row_of
from mbcheck.tests.support.words import agree

BY_NAME = {row.name: row for row in read_paper("rotating_beam").rows}


@pytest.mark.slow
def test_responses_are_those_that_were_measured(with_engines: Session) -> None:
    peaks, own = (measures.by_mass(with_engines, who, 4)["peak"] for who in (REFERENCE, "exudyn"))
    np.testing.assert_allclose(peaks, [1.083, 1.864, 2.456, 3.332], atol=6e-4)
    np.testing.assert_allclose(own, peaks, rtol=1e-3)


def test_wrong_roots_are_not_reproduced(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(measures, "rest_roots", lambda count: np.arange(count) + 2.0)
    assert assess(BY_NAME["asymptote"], Session()).verdict == NOT_REPRODUCED
    wrong = replace(BY_NAME["root_2"], printed="4.695")
    assert assess(wrong, Session()).verdict == NOT_REPRODUCED


def test_an_engine_that_fails_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*args: Any, **more: Any) -> Any:
        raise EngineError("clock", "went back")

    monkeypatch.setattr(measures, "simulate", fails)
    failure = measures.simulate_beam(FIGURE_5, "exudyn", 1.0)
    assert isinstance(failure, str)
    session = Session(engines=("exudyn",))
    still = measures.Response(FIGURE_5, np.zeros(1), {"theta": np.zeros(1)})
    for who, motion in (("exudyn", failure), (REFERENCE, still)):
        session.cache["rotating_beam.runs", 5, who] = {0.4: motion}
    row = row_of("a", each=lambda session, who: len(measures.response(session, 5, who, 0.4).times))
    assert "went back" in assess(row, session).engines["exudyn"]


def test_maximum_of_a_curve() -> None:
    at = np.linspace(0.1, 1.0, 16)
    assert measures.maximum(at, -((at - 0.4217) ** 2)) == pytest.approx(0.4217)
    assert measures.maximum(at, at) == 1.0


def test_string_is_the_beam_without_bending_stiffness() -> None:
    """By shooting from both ends: tau phi' jumps at the mass by its inertia."""
    n = numbers(measures.BEAM.replace(mass=0.4, mass_position=0.5))

    def shoot(square: float, start: float, values: list[float]) -> Any:
        def slopes(x: float, y: Any) -> list[float]:
            return [y[1] / tension(n, x), -square * y[0]]

        end = n.beta + (1e-12 if start > n.beta else -1e-12)
        return solve_ivp(slopes, (start, end), values, rtol=1e-10, atol=1e-12).y[:, -1]

    def jump(square: float) -> float:
        near = 1e-6  # the tip, where the tension vanishes, is left by a series
        tip = square / (1 + n.delta)
        outer = shoot(square, 1 - near, [1 - tip * near, square * near])
        inner = shoot(square, 0.0, [0.0, 1.0])
        return float(
            inner[1] * outer[0] - outer[1] * inner[0] - square * n.alpha * inner[0] * outer[0]
        )

    omega = n.gamma * np.sqrt(brentq(jump, 2.0, 3.0, xtol=1e-9) - 1)
    assert measures.string_frequency(n) == pytest.approx(omega, rel=1e-6)


def test_linear_pulse_solves_the_equations() -> None:
    scene, p = beam_scene("inextensible", 3), FIGURE_5.replace(mass=0.4, torque_amplitude=0.1)
    times = np.linspace(0.0, 15.0, 61)
    right = solve_ivp(
        scene.right_hand_side(p),
        (0, 15),
        scene.state({}),
        "DOP853",
        times,
        rtol=1e-9,
        atol=1e-12,
        max_step=1.0,
    )
    wanted, found = scene.observe(right.y, p), measures.linear_pulse(p, times, scene).values
    for name in ("theta", "theta_dot", "tip_deflection", "tip_deflection_dot"):
        size = np.max(np.abs(wanted[name]))
        np.testing.assert_allclose(found[name], wanted[name], atol=1e-4 * size)


def test_what_cannot_be_tested_tells_right_numbers() -> None:
    places = [measures.crossings(speed)[0] for speed in (4.0, measures.SPEED, 15.0)]
    words = "{:.3f} at 4 rad/s, {:.3f} at 7 rad/s, {:.3f} at 15 rad/s".format(*places)
    assert agree(BY_NAME["better_prediction"].reason.partition("converged: ")[2], words)
    best = measures.best(measures.SPEED)
    assert agree(BY_NAME["value_of_6"].reference, f"{best[-1]:.3f} to {best[0]:.3f}")
    p = measures.BEAM.replace(angular_speed=0.0)
    at_rest = [
        natural_modes(one, count=1).omega[0] for one in (p, p.replace(mass=0.4, mass_position=0.4))
    ]
    words = "from {:.4g} to {:.4g} rad/s".format(*at_rest)
    assert words in BY_NAME["coupling_of_6"].reason


def test_corrected_conditions_of_10_belong_together() -> None:
    """Both are in the constants of (9), so that they vanish at once at the first root."""
    from sympy import Matrix, symbols
    from sympy.parsing.sympy_parser import (
        implicit_multiplication,
        parse_expr,
        standard_transformations,
    )

    rules = (*standard_transformations, implicit_multiplication)
    errata = (BY_NAME[name].erratum for name in ("swapped_constants", "free_end"))
    rows = Matrix([parse_expr(one.corrected, transformations=rules) for one in errata if one])
    matrix = rows.jacobian(symbols("B_1 B_2")).subs({"beta_2": 1.8751040687, "L": 1.0})
    assert rows.shape == (2, 1)
    assert abs(matrix.det()) < 1e-8
    assert abs(matrix[0, 0]) > 1

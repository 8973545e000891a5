"""The misprints of the rotating_beam paper, proved.

Each by one number that the reference, which has its equations from Lagrange's, gives by another
route. (5), (10)-(12), (14) and (16) as a whole are rows that compute.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

from mbcheck.comparisons.papers.rotating_beam.derivation import (
    BENDING,
    bending_modes,
    dimensionless,
    lagrange,
    matrices_16,
    stations,
)
from mbcheck.comparisons.papers.rotating_beam.derivation import LOADED as LOADED_16
from mbcheck.comparisons.papers.rotating_beam.rows import MISPRINTS, SYMBOLS
from mbcheck.comparisons.papers.session import Session
from mbcheck.reference.rotating_beam.cases import FIGURE_5
from mbcheck.reference.rotating_beam.scene import beam_scene
from mbcheck.tests.support.papers import rotating_beam as formulas
from mbcheck.tests.support.papers.rotating_beam import linear_pulse
from mbcheck.tests.support.words import agree


@pytest.mark.parametrize(
    "row",
    [
        pytest.param(row, id=row.name, marks=[pytest.mark.slow] * (row.name == "hub_alone"))
        for row in MISPRINTS
    ],
)
def test_corrected_formula_gives_what_the_reference_does(row: Any, session: Session) -> None:
    printed, corrected, reference, within = getattr(formulas, row.name)(session)
    room = within * max(abs(printed), abs(corrected), abs(reference))
    assert abs(corrected - reference) <= room < abs(printed - reference)
    _, words = row.reason.split(": as printed ")
    unit = words.partition(", corrected ")[2].partition(" ")[2]
    assert agree(words, f"{printed:.5g}, corrected {corrected:.5g} {unit}".strip())
    assert agree(row.reference, f"{reference:.5g} {unit}".strip())


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
    wanted, found = scene.observe(right.y, p), linear_pulse(p, times, scene)
    for name in ("theta", "theta_dot", "tip_deflection", "tip_deflection_dot"):
        size = np.max(np.abs(wanted[name]))
        np.testing.assert_allclose(found[name], wanted[name], atol=1e-4 * size)


def test_misprints_of_symbols() -> None:
    """The hub's acceleration drives a bending mode; rotating axes see no angle of the beam."""
    straight = np.zeros(5)
    push = lagrange(straight, straight, np.eye(5)[0], LOADED_16).sum(axis=0)[BENDING]
    x, masses = stations(LOADED_16)
    wanted = bending_modes(x, LOADED_16)[0] @ (masses * (x + LOADED_16.hub_radius))  # U_12 + a U_20
    np.testing.assert_allclose(push, wanted, rtol=1e-12)
    assert np.min(np.abs(push)) > 1
    # one hub: its inertia stands with theta'' alone
    heavy = LOADED_16.replace(hub_inertia=LOADED_16.hub_inertia + 1)
    assert lagrange(straight, straight, np.eye(5)[0], heavy).sum(axis=0)[0] == pytest.approx(
        1 + lagrange(straight, straight, np.eye(5)[0], LOADED_16).sum(axis=0)[0]
    )
    # cos(beta_1 x) = 0 at L, and not everywhere
    assert np.cos(np.pi / 2) == pytest.approx(0)
    assert np.cos(np.pi / 4) > 0.5
    # (21): numbers without dimension have the frequency f = T omega
    found = dimensionless(Session())
    assert found["error"] < 1e-12
    # the square of (3) is of degree two in the rates: no term such as x v theta'
    rates = sp.symbols("u' u_f' v' theta'")
    u, u_f, w, x, scale = sp.symbols("u u_f v x lambda")
    faster = [scale * rate for rate in rates]
    energy = (faster[0] + faster[1] - w * faster[3]) ** 2
    energy += (faster[2] + (x + u + u_f) * faster[3]) ** 2
    assert sp.Poly(sp.expand(energy), scale).monoms() == [(2,)]
    # M_1, M_2 of Q_theta are M_11, M_22
    assert matrices_16(Session())["corrected"] < 1e-12
    assert [row.name for row in SYMBOLS] == [
        "axial_condition",
        "lost_rates",
        "symbols_of_16",
        "drive_of_17",
        "substitution_21",
        "hub_symbols",
        "angle_of_notations",
    ]

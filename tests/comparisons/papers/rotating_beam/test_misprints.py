"""The misprints of the rotating_beam paper, proved.

Each by one number that the reference, which has its equations from Lagrange's, gives by another
route, and the formulas by SymPy or a quadrature.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad, solve_ivp

from mbcheck.comparisons.papers.rotating_beam.derivation import (
    BENDING,
    bending_modes,
    dimensionless,
    lagrange,
    matrices_16,
    stations,
)
from mbcheck.comparisons.papers.rotating_beam.derivation import LOADED as LOADED_16
from mbcheck.comparisons.papers.rotating_beam.misprints import MISPRINTS, SYMBOLS
from mbcheck.comparisons.papers.rotating_beam.results import BEAM
from mbcheck.comparisons.papers.session import Session
from mbcheck.reference.rotating_beam import FIGURE_5, beam_scene
from mbcheck.reference.rotating_beam.frequencies.assumed_modes import rest_modes, rest_roots
from mbcheck.reference.rotating_beam.frequencies.numbers import numbers
from mbcheck.tests.support.papers.rotating_beam import (
    FORMULAS,
    LOADED,
    axial_frequency,
    axial_pull,
    coupling_energy,
    determinant,
    driving_vector,
    frequency_formula,
    gravity,
    hub_energy,
    hub_radius,
    linear_pulse,
    mass_twice,
    mode_argument,
    one_mode,
    strain_energy,
    swapped_constants,
    third_row,
    third_row_mass,
)
from mbcheck.tests.support.words import agree


def test_every_misprint_is_shown() -> None:
    assert [row.name for row in MISPRINTS] == list(FORMULAS)


@pytest.mark.parametrize(
    "row",
    [
        pytest.param(row, id=row.name, marks=[pytest.mark.slow] * (row.name == "hub_alone"))
        for row in MISPRINTS
    ],
)
def test_corrected_formula_gives_what_the_reference_does(row: Any, session: Session) -> None:
    what, printed, corrected, reference, unit, within = FORMULAS[row.name](session)
    room = within * max(abs(printed), abs(corrected), abs(reference))
    assert abs(corrected - reference) <= room < abs(printed - reference)
    reason = f"{what}: as printed {printed:.5g}, corrected {corrected:.5g} {unit}".strip()
    assert agree(row.reason, reason)
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


# By SymPy and by quadrature ---------------------------------------------------------------------

X, A, D, M, J, EPS = sp.symbols("x a d m J epsilon", positive=True)


def test_misprints_of_the_energies(session: Session) -> None:
    beam = BEAM
    line, length = beam.density * beam.area, beam.length
    for u, of in ((1, "corrected"), (2, "printed")):
        energy = sp.integrate((EPS * X).diff(X, u) ** 2 / 2, (X, 0, length)).subs(EPS, 1e-4)
        shown = getattr(strain_energy(session), of)
        assert float(energy) * beam.youngs_modulus * beam.area == pytest.approx(shown)
    for radius, of in ((8.0, "corrected"), (0.0, "printed")):
        energy = quad(lambda x, radius=radius: line * (radius + x) ** 2 / 2, 0, length)[0]
        assert energy == pytest.approx(getattr(hub_radius(session), of))
    # a kinetic energy has the degree 2 in the rates; (4) adds theta'^2 v' to it
    omega, rate, scale = sp.symbols("omega r s")
    for power, degree in ((1, True), (2, False)):
        energy = omega**2 + rate**2 + omega**power * rate
        double = energy.subs({omega: scale * omega, rate: scale * rate}, simultaneous=True)
        assert (sp.expand(double - scale**2 * energy) == 0) == degree
    coupling = coupling_energy(session)
    assert coupling.printed != pytest.approx(coupling.corrected, rel=1e-3)
    theta, weight = sp.symbols("theta w")
    torque = -(weight * (A + D) * sp.sin(theta)).diff(theta).subs(theta, 0)
    assert torque == -weight * (A + D)
    assert gravity(session).printed == pytest.approx(-line * length * 9.80665 * length)
    place, radius, rate = sp.symbols("d a omega")
    once = (radius + place) ** 2 * rate**2 / 2
    for energy, of in ((once, "corrected"), (once + place**2 * rate**2 / 2, "printed")):
        value = float(energy.subs({radius: 8, place: 8, rate: 1})) * 0.4
        assert getattr(mass_twice(session), of) == pytest.approx(value)
    hub = hub_energy(session)
    assert hub.corrected - hub.printed == pytest.approx(FIGURE_5.hub_inertia / 2)


def test_misprints_of_the_modes(session: Session) -> None:
    k, x = sp.symbols("k x", positive=True)
    sine, cosine = sp.symbols("B_1 B_2")  # of (9)
    mode = sine * (sp.sin(k * x) - sp.sinh(k * x)) + cosine * (sp.cos(k * x) - sp.cosh(k * x))
    rows = [mode.diff(x, i).subs(x, 1) / k**i for i in (2, 3)]
    matrix = sp.Matrix([[row.coeff(b) for b in (cosine, sine)] for row in map(sp.expand, rows)])
    cos, sin, cosh, sinh = sp.cos(k), sp.sin(k), sp.cosh(k), sp.sinh(k)
    assert (matrix[0, :] + sp.Matrix([[cos + cosh, sin + sinh]])).is_zero_matrix
    assert sp.expand(matrix[1, 1] + cos + cosh) == 0  # (10) prints cos - cosh
    # (10) prints the columns the other way round; with its second row it has no root
    swapped = sp.Matrix([[cos + cosh, sin + sinh], [-(sin - sinh), cos - cosh]])
    assert sp.simplify((swapped.det() + 2 * sinh**2).rewrite(sp.exp)) == 0
    exact = sp.simplify((matrix.det() - 2 * (1 + cos * cosh)).rewrite(sp.exp))
    assert exact == 0
    printed = (cos + cosh) * (cosh - cos) - (sin + sinh) * (sinh - sin)
    assert sp.simplify((printed - 2 * sin**2).rewrite(sp.exp)) == 0
    root = rest_roots(1)[0]
    assert determinant(session).printed == pytest.approx(2 * np.sin(root) ** 2)
    # the moment's row of (10) gives the sign and the argument of xi
    ratio = sp.solve(rows[0], sine)[0] / cosine
    assert float(ratio.subs(k, root)) == pytest.approx(
        -(np.cos(root) + np.cosh(root)) / (np.sin(root) + np.sinh(root))
    )
    assert swapped_constants(session).corrected == pytest.approx(float(ratio.subs(k, root)))
    whole = mode.subs({sine: ratio, cosine: 1}).subs(k, root)
    middle, end = (float(whole.subs(x, place)) for place in (sp.Rational(1, 2), 1))
    assert mode_argument(session).corrected == pytest.approx(middle / end)
    # u'' = -(omega/c)^2 u with u'(L) = 0 has cos = 0
    axial = axial_frequency(session)
    assert np.cos(axial.reference / axial.printed * np.pi / 2) == pytest.approx(0, abs=1e-7)
    assert frequency_formula(session).corrected == pytest.approx(2.9107, abs=1e-4)


def one_mode_equations() -> tuple[list[sp.Expr], dict[str, sp.Symbol]]:
    """Lagrange's equations of one axial mode x, one bending mode x^2, a beam of length 1."""
    names = ("theta", "b1", "b2")
    q, v, w = ([sp.Symbol(name + dots) for name in names] for dots in ("", "'", "''"))
    small = sp.Symbol("epsilon")

    def energy(x: Any) -> sp.Expr:
        u, bend, foreshortening = q[1] * x, q[2] * x**2, -sp.Rational(2, 3) * x**3 * q[2] ** 2
        along = A + x + small * u + small**2 * foreshortening
        across = small * bend
        rates = [
            sum(part.diff(c) * r for c, r in zip(q, v, strict=True)) for part in (along, across)
        ]
        square = (rates[0] - across * v[0]) ** 2 + (rates[1] + along * v[0]) ** 2
        return sum(sp.expand(square).coeff(small, i) for i in range(3)) / 2

    x = sp.Symbol("s")
    kinetic = sp.integrate(sp.expand(energy(x)), (x, 0, 1)) + M * energy(D) + J * v[0] ** 2 / 2
    rows = []
    for c, rate in zip(q, v, strict=True):
        momentum = kinetic.diff(rate)
        change = sum(momentum.diff(a) * b for a, b in zip((*q, *v), (*v, *w), strict=True))
        rows.append(sp.expand(change - kinetic.diff(c)))
    symbols = {s.name: s for s in (*q, *v, *w)}
    return rows, symbols


def test_misprints_of_the_equations_of_motion(session: Session) -> None:
    (hub, axial, bend), s = one_mode_equations()
    still = {s[name]: 0 for name in ("b1", "b2", "b1'", "b2'")}
    third, quarter = sp.Rational(1, 3), sp.Rational(1, 4)
    # row 2: + theta'' of beam and mass, and of the mass's stiffness (a + d) H - phi^2
    driving = bend.subs(still).coeff(s["theta''"])
    assert sp.expand(driving - (A * third + quarter + M * (A + D) * D**2)) == 0
    stiffness = bend.coeff(s["b2"]).coeff(s["theta'"], 2).coeff(M)
    assert sp.expand(stiffness - ((A + D) * sp.Rational(4, 3) * D**3 - D**4)) == 0
    whole = bend.coeff(s["theta''"]) - driving
    assert sp.expand(whole - s["b1"] * (quarter + M * D**3)) == 0
    # row 3: what stands with theta'', and row 1: what pulls along the beam
    inertia = hub.subs(still).coeff(s["theta''"])
    assert sp.expand(inertia - (J + ((A + 1) ** 3 - A**3) / 3 + M * (A + D) ** 2)) == 0
    pull = -axial.subs(still).coeff(s["theta'"], 2)
    assert sp.expand(pull - (third + M * D**2 + A * (sp.Rational(1, 2) + M * D))) == 0
    # all of the mass in row 3, at d: phi_1 = d, phi_2 = d^2, H = 4/3 d^3
    one, two, along, across = s["b1"], s["b2"], (A + D) * D, D**2
    turn = (A + D) * sp.Rational(4, 3) * D**3
    inner = (A + D) ** 2 + (one * D) ** 2 + (two * across) ** 2 + 2 * along * one - turn * two**2
    rates = (along + one * D**2) * s["b1'"] + (across**2 - turn) * two * s["b2'"]
    pushes = ((A + D) * across + one * D**3) * s["b2''"] - two * D**3 * s["b1''"]
    of_mass = s["theta''"] * inner + pushes + 2 * s["theta'"] * rates
    assert sp.expand(hub.coeff(M) - of_mass) == 0
    # the same structure with the paper's modes
    p = LOADED
    n, parts = numbers(p), one_mode(p)
    value, slope = (part[0, 0] for part in rest_modes(n.beta, 1)[:2])
    assert slope > 0
    turned = quad(lambda x: rest_modes(np.array([x]), 1)[1][0, 0] ** 2, 0, n.beta)[0]
    assert parts.pull[1] == pytest.approx(n.alpha * (n.delta + n.beta) * turned)
    assert parts.across[1] == pytest.approx(n.alpha * (n.delta + n.beta) * value)
    whole = quad(
        lambda x: (
            (n.delta + x) * quad(lambda z: rest_modes(np.array([z]), 1)[1][0, 0] ** 2, 0, x)[0]
        ),
        0,
        1,
        epsabs=1e-6,
    )[0]
    assert parts.pull[0] == pytest.approx(whole, rel=1e-5)
    hub_row = third_row(session)
    assert hub_row.corrected - hub_row.printed == pytest.approx(
        p.hub_inertia + p.mass * (p.hub_radius + p.mass_position * p.length) ** 2
    )
    alone = third_row_mass(session)
    assert alone.corrected / alone.printed == pytest.approx(p.mass)
    short = axial_pull(session)
    lost = n.alpha * n.delta * np.sin(np.pi / 2 * n.beta)
    assert short.corrected - short.printed == pytest.approx(lost)
    # (7) alone: the double integral of the pulse over the hub's own inertia
    pulse = FIGURE_5.torque_amplitude * FIGURE_5.torque_period**2 / (2 * np.pi)
    angle = linear_pulse(FIGURE_5.replace(mass=0.0), np.array([10.0]))["theta"][0]
    beam = BEAM
    line = beam.density * beam.area * beam.length**3 / 3
    assert angle == pytest.approx(pulse / (FIGURE_5.hub_inertia + line), rel=0.01)
    assert pulse / FIGURE_5.hub_inertia > 4 * angle


def test_misprints_of_the_frequency_equation(session: Session) -> None:
    vector, loaded = driving_vector(session), numbers(LOADED)
    at_mass = rest_modes(loaded.beta, 1)[0][0, 0]
    lost = loaded.alpha * (loaded.delta + loaded.beta - 1) * at_mass
    assert vector.corrected - vector.printed == pytest.approx(lost)


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

"""The ledger and figures of the paper on rotating_beam; misprints, by SymPy and by quadrature."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad, solve_ivp

from mbcheck.comparisons.papers.ledger import CORRECTED, NOT_REPRODUCED, REPRODUCED
from mbcheck.comparisons.papers.rotating_beam import misprints, results
from mbcheck.comparisons.papers.rotating_beam.figures import MASS_COLOURS
from mbcheck.comparisons.papers.rotating_beam.rows import FIGURES
from mbcheck.comparisons.papers.session import Session
from mbcheck.reference.errors import EngineError
from mbcheck.reference.rotating_beam.cases import FIGURE_5
from mbcheck.reference.rotating_beam.frequencies.assumed_modes import rest_modes, rest_roots
from mbcheck.reference.rotating_beam.frequencies.numbers import numbers
from mbcheck.reference.rotating_beam.frequencies.shooting import shooting
from mbcheck.reference.rotating_beam.scene import beam_scene

ENGINES = ("mujoco", "exudyn")


@pytest.fixture(scope="module")
def session() -> Session:
    return Session()


@pytest.fixture(scope="module")
def with_engines() -> Session:
    return Session(engines=ENGINES)


# The ledger ---------------------------------------------------------------------------------


@pytest.mark.slow
def test_responses_are_those_that_were_measured(with_engines: Session) -> None:
    peaks, words = results.told_by_mass(with_engines, 4, results.peak)
    np.testing.assert_allclose(peaks, [1.083, 1.864, 2.456, 3.332], atol=6e-4)
    assert [float(value) for value in words["exudyn"].split(",")] == pytest.approx(peaks, rel=1e-3)


def test_quick_rows_can_fail(session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    """A wrong root, a printed formula that is right, and a corrected one that is wrong."""
    shown = misprints.Shown("something", 1.0, 2.0, 2.0)
    assert misprints.judged(shown).verdict == CORRECTED
    assert misprints.judged(shown._replace(printed=2.0)).verdict == REPRODUCED
    assert misprints.judged(shown._replace(corrected=3.0)).verdict == NOT_REPRODUCED
    from mbcheck.comparisons.papers.rotating_beam import rows as rotating_beam

    monkeypatch.setattr(rotating_beam, "rest_roots", lambda count: np.arange(count) + 2.0)
    assert rotating_beam.asymptote(session).verdict == NOT_REPRODUCED
    found = rotating_beam.root(session, 2, "4.695")
    assert found.verdict == NOT_REPRODUCED


def test_an_engine_that_fails_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*args: Any, **more: Any) -> Any:
        raise EngineError("clock", "went back")

    monkeypatch.setattr(results, "simulate", fails)
    job = results.Job(5, 0.4, "exudyn", 1.0, 4)
    failed = results.carried_out(job)
    assert isinstance(failed, str)
    held = Session(engines=("exudyn",))
    held.kept["rotating_beam", "runs", 5] = {("exudyn", 0.4): failed}
    assert (
        "went back"
        in results.by_engine(held, lambda name: str(results.run(held, 5, name, 0.4)))["exudyn"]
    )


def test_maximum_of_a_curve() -> None:
    at = np.linspace(0.1, 1.0, 16)
    assert results.maximum(at, -((at - 0.4217) ** 2)) == pytest.approx(0.4217)
    assert results.maximum(at, at) == 1.0


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
    wanted, found = scene.observe(right.y, p), misprints.linear_pulse(p, times, scene)
    for name in ("theta", "theta_dot", "tip_deflection", "tip_deflection_dot"):
        size = np.max(np.abs(wanted[name]))
        np.testing.assert_allclose(found[name], wanted[name], atol=1e-4 * size)


# Misprints ----------------------------------------------------------------------------------

X, A, D, M, J, EPS = sp.symbols("x a d m J epsilon", positive=True)


def test_misprints_of_the_energies(session: Session) -> None:
    beam = results.BEAM
    line, length = beam.density * beam.area, beam.length
    for u, of in ((1, "corrected"), (2, "printed")):
        energy = sp.integrate((EPS * X).diff(X, u) ** 2 / 2, (X, 0, length)).subs(EPS, 1e-4)
        shown = getattr(misprints.strain_energy(session), of)
        assert float(energy) * beam.youngs_modulus * beam.area == pytest.approx(shown)
    for radius, of in ((8.0, "corrected"), (0.0, "printed")):
        energy = quad(lambda x, radius=radius: line * (radius + x) ** 2 / 2, 0, length)[0]
        assert energy == pytest.approx(getattr(misprints.hub_radius(session), of))
    # a kinetic energy has the degree 2 in the rates; (4) adds theta'^2 v' to it
    omega, rate, scale = sp.symbols("omega r s")
    for power, degree in ((1, True), (2, False)):
        energy = omega**2 + rate**2 + omega**power * rate
        double = energy.subs({omega: scale * omega, rate: scale * rate}, simultaneous=True)
        assert (sp.expand(double - scale**2 * energy) == 0) == degree
    coupling = misprints.coupling_energy(session)
    assert coupling.printed != pytest.approx(coupling.corrected, rel=1e-3)
    theta, weight = sp.symbols("theta w")
    torque = -(weight * (A + D) * sp.sin(theta)).diff(theta).subs(theta, 0)
    assert torque == -weight * (A + D)
    assert misprints.gravity(session).printed == pytest.approx(-line * length * 9.80665 * length)
    hub = misprints.hub_energy(session)
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
    exact = sp.simplify((matrix.det() - 2 * (1 + cos * cosh)).rewrite(sp.exp))
    assert exact == 0
    printed = (cos + cosh) * (cosh - cos) - (sin + sinh) * (sinh - sin)
    assert sp.simplify((printed - 2 * sin**2).rewrite(sp.exp)) == 0
    root = rest_roots(1)[0]
    assert misprints.determinant(session).printed == pytest.approx(2 * np.sin(root) ** 2)
    # the moment's row of (10) gives the sign and the argument of xi
    ratio = sp.solve(rows[0], sine)[0] / cosine
    assert float(ratio.subs(k, root)) == pytest.approx(
        -(np.cos(root) + np.cosh(root)) / (np.sin(root) + np.sinh(root))
    )
    whole = mode.subs({sine: ratio, cosine: 1}).subs(k, root)
    middle, end = (float(whole.subs(x, place)) for place in (sp.Rational(1, 2), 1))
    assert misprints.mode_argument(session).corrected == pytest.approx(middle / end)
    # u'' = -(omega/c)^2 u with u'(L) = 0 has cos = 0
    axial = misprints.axial_frequency(session)
    assert np.cos(axial.reference / axial.printed * np.pi / 2) == pytest.approx(0, abs=1e-7)
    assert misprints.frequency_formula(session).corrected == pytest.approx(2.9107, abs=1e-4)
    square = quad(lambda s: rest_modes(np.array([s]), 1)[0][0, 0] ** 2, 0, 1)[0]
    beam = results.BEAM
    line = beam.density * beam.area * beam.length
    assert misprints.normalisation(session).corrected == pytest.approx(line * square)
    assert misprints.orthogonality(session).corrected == pytest.approx(-4 * 0.4 / line)


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
    # row 3: what stands with theta'', and row 1: what pulls along the beam
    inertia = hub.subs(still).coeff(s["theta''"])
    assert sp.expand(inertia - (J + ((A + 1) ** 3 - A**3) / 3 + M * (A + D) ** 2)) == 0
    pull = -axial.subs(still).coeff(s["theta'"], 2)
    assert sp.expand(pull - (third + M * D**2 + A * (sp.Rational(1, 2) + M * D))) == 0
    # the same structure with the paper's modes
    p = misprints.LOADED
    n, parts = numbers(p), misprints.one_mode(p)
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
    hub_row = misprints.third_row(session)
    assert hub_row.corrected - hub_row.printed == pytest.approx(
        p.hub_inertia + p.mass * (p.hub_radius + p.mass_position * p.length) ** 2
    )
    short = misprints.axial_pull(session)
    lost = n.alpha * n.delta * np.sin(np.pi / 2 * n.beta)
    assert short.corrected - short.printed == pytest.approx(lost)
    # (7) alone: the double integral of the pulse over the hub's own inertia
    pulse = FIGURE_5.torque_amplitude * FIGURE_5.torque_period**2 / (2 * np.pi)
    angle = misprints.linear_pulse(FIGURE_5.replace(mass=0.0), np.array([10.0]))["theta"][0]
    beam = results.BEAM
    line = beam.density * beam.area * beam.length**3 / 3
    assert angle == pytest.approx(pulse / (FIGURE_5.hub_inertia + line), rel=0.01)
    assert pulse / FIGURE_5.hub_inertia > 4 * angle


def test_misprints_of_the_frequency_equation(session: Session) -> None:
    n = numbers(results.BEAM)
    twice = misprints.hub_twice(session)
    right, _ = shooting(n, count=1)
    wider, _ = shooting(n._replace(delta=2 * n.delta), count=1)
    assert twice.corrected == pytest.approx(right[0], rel=1e-3)
    assert twice.printed == pytest.approx(wider[0], rel=1e-3)
    vector, loaded = misprints.driving_vector(session), numbers(misprints.LOADED)
    at_mass = rest_modes(loaded.beta, 1)[0][0, 0]
    lost = loaded.alpha * (loaded.delta + loaded.beta - 1) * at_mass
    assert vector.corrected - vector.printed == pytest.approx(lost)


# Figures ------------------------------------------------------------------------------------


def test_figures_are_those_of_the_paper() -> None:
    assert [figure.number for figure in FIGURES] == [2, 3, 4, 5]
    assert list(MASS_COLOURS) == list(results.MASSES)
    for figure in FIGURES:
        assert "text" in figure.caption  # says what is chosen


@pytest.mark.slow
@pytest.mark.parametrize("figure", FIGURES, ids=lambda figure: str(figure.number))
@pytest.mark.parametrize("engines", [True, False])
def test_figures_are_drawn(figure: Any, engines: bool, with_engines: Session) -> None:
    pytest.importorskip("matplotlib")
    import matplotlib.pyplot as plt

    drawn = figure.draw(with_engines if engines else Session(kept=with_engines.kept))
    lines = sum(len(axes.lines) for axes in drawn.axes)
    names = {text.get_text() for legend in drawn.legends for text in legend.get_texts()}
    assert names >= {"no mass", "0.4 kg", "0.8 kg", "1.2 kg"}
    assert ({"MuJoCo", "Exudyn"} <= names) == engines
    assert lines >= 8
    drawn.canvas.draw()
    plt.close(drawn)

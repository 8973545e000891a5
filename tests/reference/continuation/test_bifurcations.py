"""Bifurcations of orbits against closed forms, and against a second formulation."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.special import mathieu_a, mathieu_b

from mbcheck.reference import get_scene
from mbcheck.reference.continuation.bifurcations import (
    DOUBLING,
    FOLD,
    LINE,
    NEIMARK_SACKER,
    BifurcationCurve,
    Family,
    OrbitCurve,
    ParameterWindow,
    bialternate,
    bifurcation_function,
    kind_beyond,
    margin,
    reference_flow,
)
from mbcheck.reference.continuation.curve import correct, tangent_of
from mbcheck.reference.continuation.network import CurveSearch, CurveStart, Line, Network
from mbcheck.reference.continuation.tracing import Tracer, closes
from mbcheck.reference.orbits import period_advance, shoot
from mbcheck.reference.parameters import Parameters, quantity
from mbcheck.reference.scene import EquationsOfMotion
from mbcheck.reference.solve.rk8 import rk8_steps
from mbcheck.tests.support.exact.harmonic import multipliers, residual


@dataclass(frozen=True)
class Hill(Parameters):
    """Parameters of Mathieu's equation ``x'' + (delta + epsilon cos t) x = 0``."""

    delta: float = quantity(0.25, "delta", "1", "chosen", "mean stiffness", "any")
    epsilon: float = quantity(0.1, "epsilon", "1", "chosen", "its modulation", "any")


MATHIEU = EquationsOfMotion(
    name="mathieu",
    title="Mathieu's equation",
    parameters=Hill,
    coordinates=("x",),
    units={"x": "m", "x_dot": "m/s"},
    coefficients=lambda p: SimpleTuple(p.delta, p.epsilon, 1.0),
    mass_matrix=lambda q, c, xp=np: [[1.0]],
    forces=lambda u, q, v, c, xp=np: [-(c.delta + c.epsilon * u) * q[0]],
    accelerations=lambda u, q, v, c, xp=np: [-(c.delta + c.epsilon * u) * q[0]],
    damping_matrix=lambda c: np.zeros((1, 1)),
    energy=lambda q, v, c: 0.0,
    powers=lambda u, q, v, c: {},
    drive=lambda t, c, xp=np: xp.cos(t),
    equilibria={},
    period=lambda p: 2 * np.pi,
)


class SimpleTuple(tuple):  # type: ignore[type-arg]
    """Coefficients by name."""

    def __new__(cls, *values: Any) -> Any:
        return super().__new__(cls, values)

    delta = property(lambda self: self[0])
    epsilon = property(lambda self: self[1])
    omega = property(lambda self: self[2])


def mathieu(kind: str) -> OrbitCurve:
    def at(place: Any) -> Any:
        return Hill(delta=place[0], epsilon=place[1])

    flow = reference_flow(MATHIEU, 64)
    return OrbitCurve(Family(MATHIEU, at, flow, np.ones(2), 1.0), kind)


@pytest.mark.parametrize("epsilon", [0.02, 0.1, 0.4])
@pytest.mark.parametrize(
    ("kind", "order", "characteristic"),
    [
        (DOUBLING, 1, mathieu_a),
        (DOUBLING, 1, mathieu_b),
        (FOLD, 2, mathieu_a),
        (FOLD, 2, mathieu_b),
    ],
)
def test_tongues_of_mathieus_equation(
    kind: str, order: int, characteristic: Any, epsilon: float
) -> None:
    """With t = 2 s it is y'' + (a - 2 q cos 2 s) y = 0, a = 4 delta, q = -2 epsilon."""
    delta = float(characteristic(order, 2 * epsilon)) / 4
    guess = np.array([0.0, 0.0, delta + 1e-3 * epsilon, epsilon])
    solution = correct(mathieu(kind).equations, guess, np.eye(4)[3], epsilon)
    assert solution is not None
    assert solution.z[2] == pytest.approx(delta, abs=1e-9)


def test_the_bialternate_product_has_the_products_of_eigenvalues() -> None:
    matrix = np.random.default_rng(1).normal(size=(1, 4, 4))
    values = np.linalg.eigvals(matrix[0])
    products = [values[i] * values[j] for i in range(4) for j in range(i)]
    got = np.linalg.eigvals(bialternate(matrix)[0])
    np.testing.assert_allclose(np.sort_complex(got), np.sort_complex(products), atol=1e-12)


def test_functions_vanish_where_multipliers_cross() -> None:
    turn = np.array([[np.cos(1), -np.sin(1)], [np.sin(1), np.cos(1)]])
    zero = np.zeros((2, 2))
    for kind, block in ((FOLD, np.diag([1, 0.3])), (DOUBLING, np.diag([-1, 0.3]))):
        phi = np.block([[block, zero], [zero, 0.5 * turn]])[None]
        assert abs(bifurcation_function(kind, phi - np.eye(4), phi)[0]) < 1e-15
    phi = np.block([[turn, zero], [zero, np.diag([0.2, 0.3])]])[None]
    assert abs(bifurcation_function(NEIMARK_SACKER, phi - np.eye(4), phi)[0]) < 1e-15


# Against a second formulation -----------------------------------------------------------------

HULA_HOOP = get_scene("hula_hoop")
WINDOW = ParameterWindow(
    ("force_frequency", "force_amplitude"), np.array([1.0, 5.0]), np.array([10.0, 150.0])
)

STARTS = (
    (FOLD, 1, 0.0),
    (DOUBLING, 1, 0.5),
    (DOUBLING, 2, 0.5),
    (NEIMARK_SACKER, 1, 1.0),
)
"""Kind, half periods, and the line on which the network meets it."""


def search() -> CurveSearch:
    """Return what looks for bifurcations of the window, or follows one."""
    tracer = Tracer(HULA_HOOP, WINDOW.parameters(HULA_HOOP.parameters()))
    return CurveSearch(tracer, tracer)


@pytest.fixture(scope="module")
def starts() -> list[CurveStart]:
    """Bifurcations on three lines, and on the orbits of twice the length that part from one."""
    lines, doubled = search(), search()
    for place in (0.0, 0.5, 1.0):
        lines.look_along(Line(place))
    first = next(
        one for one in lines.outcome.starts if one.kind == DOUBLING and one.point.place[0] == 0.5
    )
    doubled.switch(1, first.point)
    return [*lines.outcome.starts, *doubled.outcome.starts]


@pytest.mark.parametrize(("kind", "parts", "line"), STARTS)
def test_points_are_critical_by_collocation_too(
    starts: list[CurveStart], kind: str, parts: int, line: float
) -> None:
    """Shooting and Fourier collocation find the same multiplier on the unit circle, to 1e-8."""
    point = next(
        start.point
        for start in starts
        if (start.kind, start.parts) == (kind, parts) and abs(start.point.place[0] - line) < 1e-9
    )
    assert np.all(point.bound * (WINDOW.high - WINDOW.low) < 1e-8)
    p = WINDOW.parameters(HULA_HOOP.parameters())(point.place[:, None])
    p = p.replace(
        force_frequency=float(p.force_frequency[0]), force_amplitude=float(p.force_amplitude[0])
    )
    period, count = 1 / p.force_frequency, 129
    scale, _ = search().reference.units
    state, samples = point.z[:4] * scale, []
    for i in range(count):
        samples.append(state)
        start, end = period * i / count, period * (i + 1) / count
        state = rk8_steps(HULA_HOOP.right_hand_side(p), state, start, end, 8)
    turns = period_advance(HULA_HOOP)[:, 0]
    left, slopes = residual(HULA_HOOP, p, np.array(samples).T, period, turns)
    assert left < 1e-8
    whole = multipliers(slopes, period)
    # over half a period the multiplier is -1: over all of it, 1
    wanted = point.critical**2 if parts == 1 else point.critical
    assert np.min(np.abs(whole - wanted)) < 1e-8
    assert abs(abs(wanted) - 1) < 1e-8


@pytest.mark.parametrize(("kind", "parts", "line"), STARTS)
def test_orbits_are_stable_on_the_side_that_is_told(
    starts: list[CurveStart], kind: str, parts: int, line: float
) -> None:
    """There they are, and both of those that meet at a fold; on the other side none is stable."""
    tracer, row = search().reference, np.eye(6)[5]
    start = next(
        one
        for one in starts
        if (one.kind, one.parts) == (kind, parts) and abs(one.point.place[0] - line) < 1e-9
    )
    z, side = start.point.z, start.point.side
    if kind == FOLD:
        along = tracer.curve(LINE, parts, 0, z[4])
        way = tangent_of(along.linearise(z)[1], np.ones(6))
        for guess in (z + 0.05 * way, z - 0.05 * way):
            orbit = correct(along.equations, guess, way, float(way @ guess))
            assert orbit is not None
            assert (orbit.z[5] - z[5]) * side[1] > 1e-4
        return
    for sign in (1, -1):
        x, y = z[4:] + 1e-3 * sign * side
        curve = tracer.curve(LINE, parts, 0, x)
        orbit = correct(curve.equations, np.array([*z[:4], x, y]), row, y, 30)
        assert orbit is not None
        values = tracer.rate(curve, orbit)[0].multipliers
        assert sign * (np.max(np.abs(values)) - 1) < 0


def test_curves_end_at_the_edge_or_where_another_begins(starts: list[CurveStart]) -> None:
    start, task = next(item for item in starts if item.kind == NEIMARK_SACKER), search()
    task.follow(start)
    curve = task.outcome.curve
    assert curve is not None
    assert not task.outcome.starts
    assert curve.ends == ("window", "window")
    assert all(point.unstable == 0 for point in curve.points)
    assert all(abs(abs(point.critical) - 1) < 1e-8 for point in curve.points)
    assert Network([], 2, curves=[curve]).curve_through(start) is curve


def test_a_closed_curve_is_seen_as_one() -> None:
    def at(angle: float) -> Any:
        z = np.array([np.cos(angle), np.sin(angle)])
        return SimpleNamespace(z=z, tangent=np.array([-z[1], z[0]]))

    first = at(0.0)
    assert closes(first, at(-0.1), at(0.1))
    assert not closes(first, at(3.0), at(3.2))
    assert not closes(first, at(0.1), at(0.3))


def test_which_curve_begins_where_two_bifurcations_meet() -> None:
    def at(critical: complex, *others: complex) -> Any:
        return SimpleNamespace(critical=critical, others=np.array(others))

    assert kind_beyond(NEIMARK_SACKER, at(1.0, 0.3)) == FOLD
    assert kind_beyond(NEIMARK_SACKER, at(-1.0, 0.3)) == DOUBLING
    assert kind_beyond(NEIMARK_SACKER, at(0.6 + 0.8j, 1.0, 0.3)) == FOLD
    assert kind_beyond(NEIMARK_SACKER, at(0.6 + 0.8j, 0.8 + 0.6j, 0.8 - 0.6j)) == NEIMARK_SACKER
    assert kind_beyond(FOLD, at(1.0, 1.0, 0.2)) == NEIMARK_SACKER
    assert kind_beyond(FOLD, at(1.0, -1.0, 0.2)) == DOUBLING
    assert kind_beyond(DOUBLING, at(-1.0, -1.0, 0.2)) == NEIMARK_SACKER
    assert kind_beyond(DOUBLING, at(-1.0, 1.0, 0.2)) == FOLD
    assert kind_beyond(DOUBLING, at(-1.0, 0.6 + 0.8j, 0.6 - 0.8j)) == NEIMARK_SACKER
    assert margin(DOUBLING, at(-1.0, 0.9, 0.1)) == pytest.approx(0.1)
    assert margin(DOUBLING, at(-1.0, 1.1, 0.1)) == pytest.approx(-0.1)
    assert margin(NEIMARK_SACKER, at(0.6 + 0.8j, 0.1)) == pytest.approx(0.8)
    assert margin(NEIMARK_SACKER, at(2.0, 0.1)) == pytest.approx(-0.5)
    assert BifurcationCurve(LINE, 1).distance(np.zeros(2)) == np.inf


@pytest.mark.slow
def test_rotors_lose_their_synchronous_orbit_at_a_fold() -> None:
    """Nothing drives the scene: on one side of the fold orbits close nearby, on the other none."""
    scene = get_scene("rotor_pendulum")
    low, high = np.array([1e6, 1e4]), np.array([4e6, 6e4])
    window = ParameterWindow(("platform_stiffness", "rod_stiffness"), low, high)
    tracer = Tracer(scene, window.parameters(scene.parameters()))
    task = CurveSearch(tracer, tracer)
    task.look_along(Line(0.0))
    start = next(item for item in task.outcome.starts if item.kind == FOLD)
    assert start.point.critical == pytest.approx(1, abs=1e-5)
    scale, unit = tracer.units
    state, period = start.point.z[:8] * scale, np.array([start.point.z[1] * unit])
    state[1] = 0.0
    closed = []
    for change in (-1e-3, 1e-3):
        p = tracer.parameters(start.point.place[:, None])
        p = p.replace(rod_stiffness=(1 + change) * p.rod_stiffness)
        orbits = shoot(scene, p, state[:, None], steps=96, period=period)
        near = np.max(np.abs(orbits.states[:, 0] - state) / scale) < 0.2
        closed.append(bool(orbits.closed[0] and near))
    assert sorted(closed) == [False, True]

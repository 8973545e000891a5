"""Power series in higher precision against other routes, and against themselves."""

from __future__ import annotations

from typing import Any

import gmpy2
import mpmath as mp
import numpy as np
import pytest
import sympy as sp

from mbcheck.reference import SCENES, get_scene
from mbcheck.reference.rotating_beam import BENDING
from mbcheck.reference.rotating_beam.parameters import RotatingBeam
from mbcheck.reference.rotating_beam.shapes import polynomials
from mbcheck.tests.support.precise.beam import HAS_EXTENDED, Beam, table_of
from mbcheck.tests.support.precise.compare import (
    EXTENDED,
    Plain,
    differences,
    exact,
    precise_states,
    precision,
    system_of,
)
from mbcheck.tests.support.precise.kinds.common import Run
from mbcheck.tests.support.precise.lagrange import MECHANISMS, mass_and_load
from mbcheck.tests.support.precise.runs import run_of
from mbcheck.tests.support.precise.series import Accuracy, StepLimitError, integrate


def start_of(run: Run) -> Any:
    return get_scene(run.scene).state(run.state)


@pytest.mark.parametrize("number", range(10))
@pytest.mark.parametrize("scene", SCENES)
def test_both_routes_have_the_same_rates(scene: str, number: int) -> None:
    run = run_of(scene, number)
    start = start_of(run)
    random = np.random.default_rng(number)
    x = start + 0.1 * np.abs(start) * random.normal(size=len(start))
    x[: len(x) // 2] += 1e-3 * random.normal(size=len(x) // 2)
    known = get_scene(scene)
    stated = known.right_hand_side(run.parameters)(run.start_time, x)
    with precision(200):
        time, state = gmpy2.mpfr(run.start_time), [gmpy2.mpfr(float(value)) for value in x]
        series = system_of(run, 200).expand(time, state, 2)
        rate = [float(row[1]) for row in series] + [float(2 * row[2]) for row in series]
    mass = np.array(known.mass_matrix(x[: len(x) // 2], known.coefficients(run.parameters)))
    digits = 1e-12 * min(np.linalg.cond(mass), 1e9)
    np.testing.assert_allclose(rate, stated, rtol=digits, atol=digits * np.max(np.abs(stated)))


@pytest.mark.parametrize(
    "mechanism",
    [
        pytest.param(mechanism, marks=[] if mechanism[0] == SCENES[0] else [pytest.mark.slow])
        for mechanism in MECHANISMS
    ],
    ids="-".join,
)
def test_series_are_those_of_mpmath(mechanism: tuple[str, str]) -> None:
    scene, word = mechanism
    run = next(
        run
        for run in map(lambda number: run_of(scene, number), range(0, 200, 10))
        if word in (*run.parameters.as_dict().values(), "")
    )
    system = MECHANISMS[mechanism]()
    start, numbers = start_of(run), run.parameters.as_dict()
    names = [name for name, value in numbers.items() if not isinstance(value, str)]
    mass, load = mass_and_load(system)
    inputs = (system.time, *system.q, *system.v, *(sp.Symbol(n, real=True) for n in names))
    entries = sp.lambdify(inputs, [mass, load], "mpmath")
    n = len(system.q)
    length = 2e-2 / Plain(run).fastest(0.0, start, np.where(start == 0, 1.0, np.abs(start)))
    with mp.workdps(40):
        values = [mp.mpf(numbers[name]) for name in names]

        def rates(t: Any, x: list[Any]) -> list[Any]:
            m, f = entries(t, *x, *values)
            return [*x[n:], *mp.lu_solve(mp.matrix(m), mp.matrix(f))]

        flow = mp.odefun(rates, 0, [mp.mpf(float(value)) for value in start], tol=mp.mpf(10) ** -34)
        second = [gmpy2.mpfr(str(value), 140) for value in flow(mp.mpf(length))]
    first = precise_states(run, start, np.array([length]), Accuracy(112))
    apart = differences(first, [second])[0]
    size = np.abs([float(value) for value in second])
    assert np.all(apart < 1e-28 * (size + np.max(size)))


LONG = ("floating_platform", "floating_beam")


@pytest.mark.parametrize(
    "scene",
    [pytest.param(scene, marks=[pytest.mark.slow] if scene in LONG else []) for scene in SCENES],
)
def test_error_is_that_of_the_accuracy(scene: str) -> None:
    run = run_of(scene, 0)
    start = start_of(run)
    length = 0.5 / Plain(run).fastest(0.0, start, np.where(start == 0, 1.0, np.abs(start)))
    times = np.array([0.5, 1.0]) * length
    finest = precise_states(run, start, times, Accuracy(220))
    for accuracy in (Accuracy(88), Accuracy(88, 20), Accuracy(160)):
        apart = differences(precise_states(run, start, times, accuracy), finest)
        size = np.abs([[float(value) for value in row] for row in finest])
        assert np.all(apart <= 2.0 ** (8 - accuracy.bits) * (size + np.max(size)))
        assert np.max(apart) > 0


@pytest.mark.skipif(not HAS_EXTENDED, reason="NumPy has no numbers of 64 bits here")
@pytest.mark.parametrize(
    "number",
    [
        1,
        pytest.param(8, marks=pytest.mark.slow),
        *(pytest.param(i, marks=pytest.mark.campaign) for i in (0, 3, 5, 9)),
    ],
)
def test_numbers_of_64_bits_do_for_the_beam(number: int) -> None:
    run = run_of("rotating_beam", number)
    start = start_of(run)
    length = 3 / Plain(run).fastest(0.0, start, np.where(start == 0, 1.0, np.abs(start)))
    times = run.start_time + np.array([0.3, 1.0]) * length
    better = precise_states(run, start, times, Accuracy(90))
    size = np.max(np.abs([[float(value) for value in row] for row in better]), axis=0)
    n = len(size) // 2
    size[1:n], size[n + 1 :] = max(size[1:n]), max(size[n + 1 :])
    known = get_scene("rotating_beam")
    mass = np.array(known.mass_matrix(start[:n], known.coefficients(run.parameters)))
    digits = max(1e-15, 2.0**-64 * np.linalg.cond(mass))
    for accuracy in EXTENDED:
        states = precise_states(run, start, times, accuracy)
        assert np.all(differences(states, better) <= digits * (size + 1e-300))


def test_numbers_of_64_bits_are_taken_as_they_are() -> None:
    with precision(106):
        third = np.longdouble(1) / 3
        assert float(abs(3 * exact(third) - 1)) <= 3 * float(np.finfo(np.longdouble).eps)
        assert exact(np.longdouble(0.1)) == gmpy2.mpfr(0.1)


@pytest.mark.parametrize("place", [1.0, 0.6])
def test_shapes_are_those_of_the_reference(place: float) -> None:
    table = table_of(place, 160)
    known = get_scene("rotating_beam")
    p = RotatingBeam(mass=0.4, mass_position=place, hub_radius=0.7, drive="torque")
    beam = Beam(p, 160)
    beam.to_float()
    at = np.random.default_rng(3).normal(size=9)
    turned = beam.jacobian @ at
    mass = beam.jacobian.T @ (
        beam.masses * np.cos(np.subtract.outer(turned, turned)) @ beam.jacobian
    )
    mass[0, 0] += beam.hub
    at[0] = 0.0
    straight = beam.jacobian[:, 1:] @ at[1:]
    mass = beam.jacobian.T @ (
        beam.masses * np.cos(np.subtract.outer(straight, straight)) @ beam.jacobian
    )
    mass[0, 0] += beam.hub
    stated = known.mass_matrix(at, known.coefficients(p))
    np.testing.assert_allclose(mass, stated, rtol=1e-12, atol=1e-12 * np.max(np.abs(stated)))
    assert abs(float(sum(table.weights)) - 1) < 1e-15
    stated_shapes = polynomials(BENDING, 0, place)
    for name in ("angle", "curvature", "integral"):  # rounded once, in many digits before
        exact_entries = np.array(getattr(table, name), dtype=float)
        off = np.abs(getattr(stated_shapes, name) - exact_entries)
        assert np.max(off / np.max(np.abs(exact_entries), axis=0)) < 1.2e-16


@pytest.mark.parametrize("kind", ["torque", "prescribed"])
def test_drive_ends_where_it_should(kind: str) -> None:
    p = RotatingBeam(
        drive=kind, ramp_time=1e-4, torque_period=1e-4, angular_speed=0.5, hub_inertia=1e3
    )
    run = Run("rotating_beam", "", p, {})
    rows = precise_states(run, start_of(run), np.array([5e-5, 1e-4, 2e-4]), EXTENDED[0])
    speeds = [float(row[9]) for row in rows]
    if kind == "prescribed":
        np.testing.assert_allclose(speeds, [0.25, 0.5, 0.5], rtol=1e-13)
    else:  # the pulse is a whole sine: what it gives it takes back
        assert abs(speeds[1]) < 1e-3 * speeds[0]
        beam = Beam(p, 128)
        assert beam.driven(gmpy2.mpfr(1e-4), 3) == [0, 0, 0]


def test_energy_of_a_free_beam_is_constant() -> None:
    known = get_scene("rotating_beam")
    p = RotatingBeam(drive="torque", torque_amplitude=0.0, mass=0.4, mass_position=0.7)
    state = {"theta_dot": 2.0, **{f"b_{i}": 0.1 * i for i in range(1, 9)}}
    run = Run("rotating_beam", "", p, state)
    rows = precise_states(run, start_of(run), np.array([0.01, 0.02]), EXTENDED[1])
    c = known.coefficients(p)
    states = [start_of(run), *(np.array([float(value) for value in row]) for row in rows)]
    energies = [known.energy(x[:9], x[9:], c) for x in states]
    assert known.invariants is not None
    momentum = known.invariants(p)["momentum"]
    momenta = [momentum(x[:9], x[9:], c) for x in states]
    np.testing.assert_allclose(energies, energies[0], rtol=1e-13)
    np.testing.assert_allclose(momenta, momenta[0], rtol=1e-13)


def test_run_that_takes_too_many_steps_says_how_far_it_came() -> None:
    run = run_of("hula_hoop", 0)
    plain = Plain(run)
    with pytest.raises(StepLimitError, match="more than 3 steps") as raised:
        integrate(plain.system, start_of(run).tolist(), 0.0, [1e3], Accuracy(44, 16), 3)
    assert 0 < raised.value.reached < 1e3

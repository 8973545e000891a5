"""Power series in higher precision against other routes, and against themselves."""

from __future__ import annotations

from typing import Any

import gmpy2
import numpy as np
import pytest

from mbcheck.reference import SCENES, get_scene
from mbcheck.reference.rotating_beam import BENDING
from mbcheck.reference.rotating_beam.parameters import RotatingBeam
from mbcheck.reference.rotating_beam.shapes import polynomials
from mbcheck.tests.support.precise.beam import Beam, table_of
from mbcheck.tests.support.precise.compare import (
    Plain,
    precision,
    system_of,
)
from mbcheck.tests.support.precise.kinds.common import Run
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


def test_run_that_takes_too_many_steps_says_how_far_it_came() -> None:
    run = run_of("hula_hoop", 0)
    plain = Plain(run)
    with pytest.raises(StepLimitError, match="more than 3 steps") as raised:
        integrate(plain.system, start_of(run).tolist(), 0.0, [1e3], Accuracy(44, 16), 3)
    assert 0 < raised.value.reached < 1e3

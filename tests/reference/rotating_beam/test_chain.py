"""The chain of rotating_beam, and what it converges to."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mbcheck.reference.errors import UnknownNameError
from mbcheck.reference.rotating_beam.chain import chain_scene, embedding, layout
from mbcheck.reference.rotating_beam.frequencies.numbers import time_unit
from mbcheck.reference.rotating_beam.frequencies.stretching import frequencies
from mbcheck.reference.rotating_beam.parameters import RotatingBeam
from mbcheck.tests.support.chain import chain_frequencies, scene_of

STEADY = RotatingBeam(ramp_time=0.0)
UNIT = time_unit(STEADY)


def test_points_at_once_and_complex_ones() -> None:
    places = np.array([0.2, 0.55, 1.0])
    x = np.random.default_rng(3).normal(size=(12, 3)) / 3
    for scheme in "AB":
        scene = chain_scene(5, scheme)
        many = scene.right_hand_side(RotatingBeam(mass=1.0, mass_position=places))  # type: ignore[arg-type]
        for i, place in enumerate(places):
            one = scene.right_hand_side(RotatingBeam(mass=1.0, mass_position=place))
            np.testing.assert_allclose(many(3.0, x)[:, i], one(3.0, x[:, i]), rtol=1e-10)
            probe = one(3.0, x[:, i] + 1e-30j * x[:, 0])
            step = 1e-6
            ahead, behind = (one(3.0, x[:, i] + s * x[:, 0]) for s in (step, -step))
            np.testing.assert_allclose(
                probe.imag / 1e-30, (ahead - behind) / (2 * step), rtol=1e-5, atol=1e-3
            )


def test_a_hub_without_inertia_can_be_prescribed() -> None:
    p = RotatingBeam(hub_inertia=0.0)
    assert np.all(np.isfinite(scene_of(p).right_hand_side(p)(1.0, np.zeros(34))))


@pytest.mark.parametrize("drive", ["prescribed", "torque"])
def test_what_is_kept_is_kept(drive: str) -> None:
    p = STEADY.replace(drive=drive, torque_amplitude=0.0, hub_radius=1.0, mass=0.4)
    scene = chain_scene(6, "B")
    random = np.random.default_rng(2)
    q, v = random.normal(size=(2, 7)) / 3
    c = scene.coefficients(p)
    a = np.array(scene.accelerations(0.0, q, v, c))
    assert scene.invariants is not None
    found = scene.invariants(p)
    assert set(found) == ({"jacobi"} if drive == "prescribed" else {"energy", "momentum"})
    for value in found.values():
        rate = value(q + 1e-30j * v, v + 1e-30j * a, c).imag / 1e-30
        assert abs(rate) < 1e-10 * np.max(np.abs(a)) * abs(value(q, v, c))


def test_tip_is_where_the_rods_end() -> None:
    random = np.random.default_rng(4)
    for scheme in "AB":
        scene, p = chain_scene(4, scheme), RotatingBeam(hub_radius=2.0)
        x = random.normal(size=10)
        angles = x[0] + np.cumsum(x[1:5])
        start = 1.0 if scheme == "B" else 0.0
        lengths = [2.0, 2.0, 2.0, 1.0 if scheme == "B" else 2.0]
        tip = (2 + start) * np.exp(1j * x[0]) + np.sum(lengths * np.exp(1j * angles))
        inside = tip * np.exp(-1j * x[0])
        found = scene.observe(x, p)
        assert found["tip_deflection"] == pytest.approx(inside.imag)
        assert found["tip_axial"] == pytest.approx(inside.real - 10)
        moved = scene.observe(x.astype(complex) + 1e-30j * np.r_[x[5:], np.zeros(5)], p)
        for name in ("tip_deflection", "tip_axial"):
            assert found[f"{name}_dot"] == pytest.approx(moved[name].imag / 1e-30)
        assert set(scene.observed) <= set(found)


def test_a_chain_starts_straight_and_is_one_object() -> None:
    p = RotatingBeam(segments=8, scheme="B")
    scene = scene_of(p)
    assert scene is chain_scene(8, "B")
    state = scene.state(embedding(p, {"theta": 0.3, "theta_dot": 2.0}))
    assert state[0] == 0.3
    assert state[9] == 2.0
    assert np.count_nonzero(state) == 2
    with pytest.raises(UnknownNameError):
        chain_scene(4, "C")


def test_no_mass_is_lost_or_counted_twice() -> None:
    """At rest and straight, the inertia about the axis is the beam's and the mass's."""
    for n in (3, 8, 12, 24, 48, 49):
        for scheme in "AB":
            for place in (1e-3, 0.25, 1 / 3, 0.5, 5 / 6, 1.0):
                p = RotatingBeam(hub_radius=1.0, mass=2.0, mass_position=place, drive="torque")
                scene = chain_scene(n, scheme)
                mass = scene.mass_matrix(np.zeros(n + 1), scene.coefficients(p))
                line = p.density * p.area
                whole = 10.0 + line * (9.0**3 - 1) / 3 + 2.0 * (1 + 8 * place) ** 2
                assert mass[0][0] == pytest.approx(whole, rel=1e-12)


def errors(p: RotatingBeam, scheme: str, sizes: tuple[int, ...]) -> Any:
    exact = frequencies(p).omega
    scenes = [chain_scene(n, scheme) for n in sizes]
    return np.array([chain_frequencies(p, 2, scene) / exact - 1 for scene in scenes])


@pytest.mark.parametrize(("gamma", "delta", "alpha"), [(0, 0, 0), (4, 0, 0), (4, 1, 1), (12, 0, 0)])
def test_schemes_bracket_the_beam_and_are_of_second_order(
    gamma: float, delta: float, alpha: float
) -> None:
    p = STEADY.replace(
        hub_radius=8 * delta,
        angular_speed=gamma / UNIT,
        mass=alpha * STEADY.density * STEADY.area * STEADY.length,
    )
    below, above = (errors(p, scheme, (24, 48)) for scheme in "AB")
    assert np.all(below[:, 0] < 0)
    assert np.all(above[:, 0] > 0)
    for found in (below, above):
        np.testing.assert_allclose(np.log2(found[0] / found[1]), 2, atol=0.1)


def mass_offset(p: RotatingBeam) -> float:
    """Return the distance of the mass from the nearest end of a rod, over h; 0 without a mass.

    The error of a chain is smooth in h along numbers of segments with the same offset on the
    same side of a hinge; from one offset to another it jumps.
    """
    n = int(p.segments)
    if not p.mass:
        return 0.0
    shape = layout(n, p.scheme)
    ends = np.array([*shape.hinges, 1.0])
    return float(np.min(np.abs(ends - p.mass_position)) * n)


def test_the_error_depends_on_where_in_its_rod_the_mass_sits() -> None:
    p = STEADY.replace(hub_radius=8.0, mass=1.0, mass_position=0.5, angular_speed=4 / UNIT)
    assert mass_offset(p.replace(segments=12)) == 0
    assert mass_offset(p.replace(segments=9)) == pytest.approx(0.5)
    assert mass_offset(p.replace(segments=9, scheme="B")) == pytest.approx(0, abs=1e-12)
    assert mass_offset(p.replace(segments=9, mass=0.0)) == 0
    at_end, inside = (errors(p, "A", sizes)[:, 1] for sizes in ((16, 32), (17, 51)))
    assert np.log2(at_end[0] / at_end[1]) == pytest.approx(2, abs=0.05)
    assert at_end[0] * inside[0] < 0  # the second frequency's error changes sign

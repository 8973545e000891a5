"""Known motions and frequencies of rotating_beam, what is conserved, and what a run ends in."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbcheck.reference.linear import linearise, modes
from mbcheck.reference.rotating_beam import (
    ABOVE_CRITICAL,
    PULSE,
    QUICK,
    SCENE,
    ZERO_ORDER,
    beam_scene,
    critical_speed,
    outcome,
)
from mbcheck.reference.rotating_beam.parameters import RotatingBeam
from mbcheck.reference.scene import Array, EquationsOfMotion

UNIT = RotatingBeam(
    length=1.0,
    area=1.0,
    second_moment=1.0,
    density=1.0,
    youngs_modulus=1.0,
    ramp_time=0.0,
)
"""Dimensionless: EI = rho A = L = 1; with A = 1 it is as soft along as across."""


# Anchors ------------------------------------------------------------------------------------


def steady_frequencies(scene: EquationsOfMotion, p: RotatingBeam) -> Array:
    """Return the circular frequencies about steady rotation, the hub held."""
    state = scene.state(scene.equilibria["rotation"](p))
    mass, damping, stiffness = linearise(scene, p, state)
    return np.array([mode.omega for mode in modes(mass, damping, stiffness, steady=(0,))[1:]])


def test_zero_order_loses_stability_at_the_frequency_at_rest() -> None:
    assert critical_speed(UNIT) == pytest.approx(3.51601526850015, rel=1e-7)
    loaded = UNIT.replace(mass=1.0, hub_radius=2.0)
    assert critical_speed(loaded) == pytest.approx(1.247917**2, rel=1e-5)
    for p in (UNIT, loaded):
        for factor, stable in ((0.999, True), (1.001, False)):
            turning = p.replace(angular_speed=factor * critical_speed(p), area=1e4, density=1e-4)
            state = ZERO_ORDER.state(ZERO_ORDER.equilibria["rotation"](turning))
            _, _, k = linearise(ZERO_ORDER, turning, state)
            bends = slice(1, 1 + 8)
            assert np.all(np.linalg.eigvalsh(k[bends, bends]) > 0) == stable
            assert np.all(np.isreal(steady_frequencies(SCENE, turning)))
    assert critical_speed(ABOVE_CRITICAL) < ABOVE_CRITICAL.angular_speed


def follow(
    scene: EquationsOfMotion, p: RotatingBeam, end: float, samples: int = 40, **start: float
) -> Any:
    """Return times and everything observed."""
    times = np.linspace(0, end, samples + 1)
    found = solve_ivp(
        scene.right_hand_side(p),
        (0, end),
        scene.state(start),
        "DOP853",
        times,
        rtol=1e-10,
        atol=1e-12,
    )
    return times, scene.observe(found.y, p), found.y


def test_reference_converges_in_coordinates() -> None:
    runs = [
        follow(beam_scene("inextensible", n), QUICK, 2.0)[1]["tip_deflection"] for n in (4, 6, 8)
    ]
    errors = [np.max(np.abs(run - runs[-1])) for run in runs[:-1]]
    assert np.max(np.abs(runs[-1])) > 0.25 * QUICK.length
    assert errors[0] < 1e-2
    assert errors[1] < errors[0] / 20


def test_a_stiffer_stretch_leads_to_the_inextensible_beam() -> None:
    """Two formulations, two sets of coordinates: the gap is proportional to 1 / EA."""
    slender = QUICK.replace(area=QUICK.area / 100, density=QUICK.density * 100)
    end, gaps = 1.0, []
    rigid = follow(beam_scene("inextensible", 5), slender, end)[1]["tip_deflection"]
    for factor in (1.0, 10.0):
        p = slender.replace(area=slender.area * factor, density=slender.density / factor)
        gaps.append(
            np.max(
                np.abs(follow(beam_scene("extensible", 5, 2), p, end)[1]["tip_deflection"] - rigid)
            )
        )
    assert gaps[0] / gaps[1] == pytest.approx(10, rel=0.2)
    assert gaps[1] < 1e-3 * np.max(np.abs(rigid))


@pytest.mark.slow
def test_second_order_model_errs_with_the_square_of_the_deflection() -> None:
    ratios = []
    for speed in (0.5, 1.0):
        p = QUICK.replace(angular_speed=speed)
        exact = follow(beam_scene("inextensible", 6), p, 3.0)[1]["tip_deflection"]
        paper = follow(beam_scene("second_order", 6), p, 3.0)[1]["tip_deflection"]
        size = np.max(np.abs(exact))
        ratios.append((np.max(np.abs(paper)) / size - 1) * (p.length / size) ** 2)
    assert 0.2 < ratios[0] < 0.4
    assert ratios[1] == pytest.approx(ratios[0], rel=0.25)


def test_a_rigid_beam_turns_as_one_body() -> None:
    p = PULSE.replace(youngs_modulus=1e20, mass_position=0.5, hub_radius=1.0)
    beam = p.density * p.area * p.length
    inertia = p.hub_inertia + beam * (p.length**2 / 12 + 5**2) + p.mass * 5**2
    a = SCENE.accelerations(7.0, [0.0] * 9, [0.0] * 9, SCENE.coefficients(p))
    c = SCENE.coefficients(p)
    assert np.array(SCENE.mass_matrix(np.zeros(9), c))[0, 0] == pytest.approx(inertia)
    assert a[0] > 7.0 / inertia  # the beam lags behind
    momentum = SCENE.invariants(p)["momentum"]  # type: ignore[misc]
    spin = np.array([2.0] + [0.0] * 8)
    assert momentum(np.zeros(9), spin, c) == pytest.approx(2 * inertia)


def test_a_hub_at_constant_speed_conserves_the_energy_in_its_frame() -> None:
    p = QUICK.replace(ramp_time=0.5)
    scene = beam_scene("inextensible", 5)
    times, _, states = follow(scene, p, 2.0)
    (value,) = scene.invariants(p).values()  # type: ignore[misc]
    path = value(states[:6], states[6:], scene.coefficients(p))
    assert np.ptp(path[times >= 0.5]) < 1e-8 * np.max(np.abs(path))
    assert np.ptp(path) > 0.01 * np.max(np.abs(path))


# What a run ends in -------------------------------------------------------------------------


def test_the_zero_order_model_diverges_and_the_others_do_not() -> None:
    p = ABOVE_CRITICAL
    case = SCENE.case("above_critical")
    for theory, wanted in (("inextensible", "bounded"), ("zero_order", "diverges")):
        times, seen, _ = follow(beam_scene(theory, 4), p, case.horizon, 100)
        assert outcome(times, seen, p) == wanted


def test_outcome_is_undecided_without_evidence() -> None:
    p = ABOVE_CRITICAL
    times = np.linspace(0, 8, 81)
    tip = np.sin(5 * times)
    assert outcome(times, {"tip_deflection": tip}, p) == "bounded"
    assert outcome(times, {"tip_deflection": 0 * tip}, p) == "bounded"
    assert outcome(times[:60], {"tip_deflection": tip[:60]}, p) == "undecided"
    assert outcome(times, {"tip_deflection": np.where(times > 7, np.nan, tip)}, p) == "undecided"
    assert outcome(times, {"tip_deflection": 0.01 * np.exp(times)}, p) == "diverges"
    assert outcome(times, {"tip_deflection": 1e-3 * np.exp(times)}, p) == "diverges"

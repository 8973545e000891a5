"""Frequencies of rotating beams from free vibration: a second way to what *frequency* finds."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from mbcheck.comparisons.checks import elements
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.engines.setup import Setup, run
from mbcheck.reference.rotating_beam import SCENE
from mbcheck.reference.rotating_beam.parameters import RotatingBeam, steady_speed
from mbcheck.reference.scene import Array, Case
from mbcheck.reference.solve.single import solve

SLOW_SPIN_UP = RotatingBeam(angular_speed=steady_speed(4), ramp_time=20.0, segments=8)
"""So slow that the beam is left with a vibration of millimetres."""

PERIODS = 6
STEADY = Case("rotating_beam", "steady", SLOW_SPIN_UP, about="rotation")
METHODS = {"mujoco": ("chain", "RK4", 2.0**-9), "exudyn": ("elements", "GeneralizedAlpha", 2.0**-9)}


def ring_down(times: Array, deflection: Array, rate: Array) -> tuple[float, float]:
    """Return circular frequency and amplitude from the zeros of the rate, between samples."""
    zeros = CubicHermiteSpline(times, rate, np.gradient(rate, times)).roots(extrapolate=False)
    turns = deflection_at(times, deflection, rate, zeros)
    return float(np.pi * (len(zeros) - 1) / (zeros[-1] - zeros[0])), float(np.ptp(turns) / 2)


def deflection_at(times: Array, deflection: Array, rate: Array, at: Array) -> Any:
    return CubicHermiteSpline(times, deflection, rate)(at)


def vibration_times(omega: float, step: float) -> Array:
    """Return times [s] on the grid of a step, from the end of the ramp on."""
    length = PERIODS * 2 * np.pi / omega
    every = int(0.02 / step)
    first = int(SLOW_SPIN_UP.ramp_time / step)
    return np.asarray(step * np.arange(first, first + int(length / step), every), dtype=float)


TOLERANCE = 1e-5
"""Relative: traces of the second mode. The amplitude itself shifts the frequency by less than
0.3 (v / L)^2, 1e-7; EI that is 0.1 % off by 3e-4."""


def test_the_references_own_vibration() -> None:
    assert SCENE.continuum.spectrum is not None
    (omega,), _ = SCENE.continuum.spectrum(SLOW_SPIN_UP, "chordwise", 1)
    times = vibration_times(omega, 2.0**-9)
    found = solve(SCENE, SLOW_SPIN_UP, SCENE.state({}), times, tolerances=(1e-9, 1e-7))
    values = SCENE.observe(found.states, SLOW_SPIN_UP)
    measured, amplitude = ring_down(times, values["tip_deflection"], values["tip_deflection_dot"])
    assert 1e-3 < amplitude < 5e-3
    assert measured == pytest.approx(omega, rel=TOLERANCE)


@pytest.mark.parametrize("name", ["mujoco", pytest.param("exudyn", marks=pytest.mark.slow)])
def test_an_engine_rings_with_the_frequency_of_its_own_matrices(name: str) -> None:
    """With the step's error taken off by Richardson's extrapolation."""
    engine = get_engine(name)
    model, method_name, step = METHODS[name]
    method = next(item for item in engine.methods if item.name == method_name)
    omega = elements.of_engine(Setup(engine, STEADY, model))[0]
    times = vibration_times(omega, step)
    coarse, fine = (
        ring_down(times, found["tip_deflection"], found["tip_deflection_dot"])[0]
        for found in (
            run(Setup(engine, STEADY, model, method, h), times).values for h in (step, step / 2)
        )
    )
    measured = fine + (fine - coarse) / (2**method.order - 1)
    assert measured == pytest.approx(omega, rel=TOLERANCE)
    assert abs(coarse / omega - 1) < 1e-3

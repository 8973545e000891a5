"""Functions of one period, from uniform samples: harmonics, extremes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .scene import Array


@dataclass(frozen=True)
class Harmonic:
    """One term ``amplitude cos(order Omega t + phase)`` of a Fourier series."""

    order: int
    amplitude: float
    phase: float


def harmonics(
    values: Array, turns: int = 0, highest: int = 6
) -> tuple[float, tuple[Harmonic, ...]]:
    """Mean and harmonics of one observable sampled uniformly over one period.

    Parameters
    ----------
    values : array (count,)
        ``count`` even, the end of the period left out.
    turns : int
        Turns per period, whose secular part ``turns Omega t`` is removed first.
    highest : int
        Highest order returned.
    """
    spectrum = spectrum_of(values, turns)
    terms = tuple(
        Harmonic(k, float(2 * abs(spectrum[k])), float(np.angle(spectrum[k])))
        for k in range(1, highest + 1)
    )
    return float(spectrum[0].real), terms


def spectrum_of(values: Array, turns: int = 0) -> Any:
    """Fourier coefficients (count/2 + 1,) of one observable without its secular part."""
    count = len(values)
    return np.fft.rfft(values - 2 * np.pi * turns * np.arange(count) / count) / count


REFINEMENT = 16
"""Points that a trigonometric interpolant puts in place of one sample."""


def extremes(samples: Array) -> tuple[float, float]:
    """Smallest and largest value of a periodic function from uniform samples of one period.

    Those of the trigonometric interpolant, by Newton's method from the extremes on a finer grid.
    """
    count = REFINEMENT * len(samples)
    spectrum = np.fft.rfft(samples) / len(samples)
    fine = count * np.fft.irfft(spectrum, count)
    orders = np.arange(len(spectrum))
    weights = np.where(orders > 0, 2.0, 1.0) * spectrum
    weights[-1] /= 2 - len(samples) % 2
    values: list[float] = []
    for i in (int(np.argmin(fine)), int(np.argmax(fine))):
        value, phase = float(fine[i]), 2 * np.pi * i / count
        for _ in range(2):
            slope, bend = (
                float(np.sum((weights * (1j * orders) ** k * np.exp(1j * orders * phase)).real))
                for k in (1, 2)
            )
            phase -= slope / bend if bend else 0.0
        nearer = float(np.sum((weights * np.exp(1j * orders * phase)).real))
        values.append(min(value, nearer) if not values else max(value, nearer))
    return values[0], values[1]

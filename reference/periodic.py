"""Functions of one period, from uniform samples: harmonics, extremes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .scene import Array


@dataclass(frozen=True)
class Harmonic:
    """One term ``amplitude cos(order Omega t + phase)`` of a Fourier series.

    Attributes
    ----------
    order : int
        multiple of Omega
    amplitude : float
        in the unit of the observable
    phase : float
        [rad]
    """

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
    """Smallest and largest value of a periodic function from uniform samples of one period."""
    low, high = lowest(np.array([samples, -samples]))
    return float(low), float(-high)


def lowest(samples: Array) -> Array:
    """Return the least values (k,) of periodic functions from uniform samples of a period (k, n).

    Of their trigonometric interpolants, by Newton's method from the least on a finer grid.
    """
    count = REFINEMENT * samples.shape[1]
    spectra = np.fft.rfft(samples, axis=1) / samples.shape[1]
    fine = count * np.fft.irfft(spectra, count, axis=1)
    orders = np.arange(spectra.shape[1])
    weights = np.where(orders > 0, 2.0, 1.0) * spectra
    weights[:, -1] /= 2 - samples.shape[1] % 2
    phase = 2 * np.pi * np.argmin(fine, axis=1)[:, None] / count
    for _ in range(2):
        waves = weights * np.exp(1j * orders * phase)
        slope, bend = (np.sum((waves * (1j * orders) ** k).real, axis=1) for k in (1, 2))
        phase = phase - np.divide(slope, bend, out=np.zeros_like(slope), where=bend > 0)[:, None]
    nearer: Array = np.sum((weights * np.exp(1j * orders * phase)).real, axis=1)
    return np.minimum(np.min(fine, axis=1), nearer)

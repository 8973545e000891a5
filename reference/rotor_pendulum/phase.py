"""Phase of the rotors of `rotor_pendulum`: the torque that couples them, and where it vanishes.

The Poincare method of the paper, (16) and (26), with the dampers that it neglects; what the search
for the synchronous orbit starts from, and what that orbit is measured by.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..periodic import extremes
from ..scene import Array
from .equations import Coefficients, RotorPendulum, coefficients, motor_rates, operating_speed


def forced_response(
    p: RotorPendulum, phase_difference: ArrayLike, speed: Any = None
) -> tuple[Any, Any]:
    """Steady x and phi_3 with both rotors turning uniformly, to first order.

    This is (16), with the dampers that it neglects. The rotors' masses count at their axes.

    Parameters
    ----------
    p : RotorPendulum
    phase_difference : array_like
        phi_1 - phi_2 [rad].
    speed : float or array, optional
        Of the rotors [rad/s], by default `operating_speed`.

    Returns
    -------
    X, Phi : complex
        Amplitudes, ``x = Re(X e^{i phi_1})`` [m] and ``phi_3 = Re(Phi e^{i phi_1})`` [rad].
    """
    c = coefficients(p)
    w = operating_speed(p) if speed is None else speed
    alpha = np.asarray(phase_difference)
    lift = c.end_mass * c.length * np.sin(c.beta) * w**2
    rod_damping = c.rod_damping + c.relative * c.loss
    platform = c.stiffness - c.mass * w**2 + 1j * w * c.damping
    rod = c.rod_stiffness - c.end_mass * c.length**2 * w**2 + 1j * w * rod_damping
    push = c.unbalance * w**2 * (np.exp(-1j * alpha) - 1)
    swing = -1j * c.unbalance * c.length * w**2 * np.exp(-1j * (alpha + c.beta))
    determinant = platform * rod - lift**2
    return (rod * push - lift * swing) / determinant, (platform * swing - lift * push) / determinant


def coupling_torque(p: RotorPendulum, phase_difference: ArrayLike, speed: Any = None) -> Any:
    """Mean torque by which the vibration drives rotor 1 ahead of rotor 2 [N m].

    The difference of the two averages in (26), with the dampers. It has the form
    ``c_0 + c_1 sin(alpha - alpha_0)``; without dampers c_0 = 0 and its zeros are those of (30).

    Parameters
    ----------
    p : RotorPendulum
    phase_difference : array_like
        alpha = phi_1 - phi_2 [rad].
    speed : float or array, optional
        Of the rotors [rad/s], by default `operating_speed`.
    """
    c = coefficients(p)
    w = operating_speed(p) if speed is None else speed
    alpha = np.asarray(phase_difference)
    x, phi_3 = forced_response(p, alpha, w)
    push = np.imag(x) + np.imag(x * np.exp(1j * alpha))
    swing = c.length * np.real(phi_3 * np.exp(1j * (alpha + c.beta)))
    return -c.unbalance * w**2 / 2 * (push + swing)


def coupling_harmonics(p: RotorPendulum, speed: Any = None) -> tuple[Any, Any]:
    """Return c_0 and complex C_1 of ``coupling_torque = c_0 + Re(C_1 e^{i alpha})`` [N m]."""
    w = operating_speed(p) if speed is None else speed
    at_0, at_quarter, at_half = (coupling_torque(p, k * np.pi / 2, w) for k in range(3))
    mean = (at_0 + at_half) / 2
    return mean, (at_0 - at_half) / 2 - 1j * (at_quarter - mean)


def balanced_phase(p: RotorPendulum, speed: Any = None) -> Any:
    """Stable phase difference [rad] by the Poincare method, dampers included.

    Where the damper torque is too large to be balanced (NaN), there is none.
    """
    mean, first = coupling_harmonics(p, speed)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.angle(np.exp(1j * (np.arccos(-mean / abs(first)) - np.angle(first))))


def settling_rate(p: RotorPendulum, phase_difference: Any, speed: Any = None) -> Any:
    """Rate [1/s] at which the phase settles near this phase difference; < 0 where it runs away.

    The slow root of ``m r^2 alpha'' + (k_e + f) alpha' = coupling_torque``, linearised.
    """
    _, first = coupling_harmonics(p, speed)
    return _slow_root(np.imag(first * np.exp(1j * np.asarray(phase_difference))), coefficients(p))


def _slow_root(stiffness: Any, c: Coefficients) -> Any:
    """Decay rate [1/s] of ``m r^2 alpha'' + (k_e + f) alpha' + stiffness alpha = 0``."""
    inertia = c.unbalance * c.eccentricity
    root = np.sqrt(np.asarray(c.loss**2 - 4 * inertia * stiffness, dtype=complex))
    return (2 * stiffness / (c.loss + root)).real


EVENLY = np.arange(8) * np.pi / 4
"""Phase differences tried beside the theory's, which knows no ripple of the rotors."""


def orbit_guesses(p: RotorPendulum) -> list[Array]:
    """Uniform rotation with the linear response, at phi_1 = 0.

    At the stable phase difference of the Poincare method, where it has one (the nearest
    zero otherwise), then `EVENLY`.

    Returns
    -------
    list of arrays of shape (8, ...)
    """
    mean, first = coupling_harmonics(p)
    stable = np.where(
        abs(mean) < abs(first), np.nan_to_num(balanced_phase(p)), -np.angle(first) + np.pi / 2
    )
    return [uniform_rotation(p, alpha) for alpha in (stable, *EVENLY)]


def uniform_rotation(p: RotorPendulum, phase_difference: Any) -> Array:
    """Return uniform rotation with the linear response (8, ...), at phi_1 = 0."""
    w, alpha = operating_speed(p), np.asarray(phase_difference)
    x, phi_3 = forced_response(p, alpha)
    q = (x.real, 0.0, -alpha % (2 * np.pi), phi_3.real)
    v = (-w * x.imag, w, w, -w * phi_3.imag)
    return np.array(np.broadcast_arrays(*q, *v), dtype=float)


def wrapped(angle: Any) -> Any:
    """Angle in (-pi, pi]."""
    return np.pi - (np.pi - np.asarray(angle)) % (2 * np.pi)


def mean_phase(alpha: Array, weights: Array | None = None) -> float:
    """Mean of angles on the circle, in (-pi, pi]."""
    return float(wrapped(np.angle(np.average(np.exp(1j * alpha), weights=weights))))


ORBIT_UNITS = {
    "mean_speed": "rad/s",
    "phase_difference": "rad",
    "motor_torque_1": "N m",
    "motor_torque_2": "N m",
    "platform_amplitude": "m",
    "rod_amplitude": "rad",
}


def orbit_quantities(states: Array, c: Coefficients) -> dict[str, float]:
    """Mean speed and phase difference, mean motor torques, amplitudes (half of the range)."""
    first, second = (np.mean(c.slope * (c.speed - rate)) for rate in motor_rates(states[4:], c))
    return {
        "mean_speed": float(np.mean(states[5])),  # over time: 2 pi / T
        "phase_difference": mean_phase(states[1] - states[2]),
        "motor_torque_1": float(first),
        "motor_torque_2": float(second),
        "platform_amplitude": half_range(states[0]),
        "rod_amplitude": half_range(states[3]),
    }


def half_range(samples: Array) -> float:
    """Half of the range of a periodic function from samples of one period."""
    low, high = extremes(samples)
    return (high - low) / 2


def phase_rate(p: RotorPendulum, speed: Any = None) -> Any:
    """Rate [1/s] by which a run is judged long enough.

    Where there is a stable phase difference, the rate at which it settles. Where there is
    none, half of the circular frequency of the slips: two of them fit into a watch.
    """
    mean, first = coupling_harmonics(p, speed)
    square = abs(first) ** 2 - mean**2
    return _slow_root(np.sqrt(abs(square)), coefficients(p)) * np.where(square > 0, 1.0, 0.5)

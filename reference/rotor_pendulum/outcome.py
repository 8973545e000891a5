"""Long-term motion of a run of `rotor_pendulum`: synchronised or not."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..scene import Array
from .equations import RotorPendulum, coefficients, operating_speed
from .phase import mean_phase, phase_rate, settling_rate, wrapped

WATCH = 8.0
"""Times 1/rate that must be watched: what was one radian away is then 0.3 mrad away."""

LEAST_TURNS = 40
"""Turns watched at least, however fast the phase settles: ten in each quarter, of which
Hann's weights leave 1e-3 of the ripple within a turn."""

LEAST_SAMPLES = 8
"""Samples in each turn; with fewer a rotor's turn may look like its standing still."""

JUMP = 0.5
"""Largest difference [rad] of a coordinate from the integral of its rate between two samples.
The ripple of a rotor makes 0.01 at 8 samples a turn; a reset to rest makes anything."""

STALLED = 0.1
"""Share of `operating_speed` below which a rotor does not turn, although its motor is on."""

STALL_TIME = 50.0
"""Motor time constants m r^2 / (k_e + f) that a rotor is given to start."""

DRIFT = 0.01
"""Largest last drift of the phase over the rate at which it settles [rad]: about the
remaining difference from the settled phase."""

DECAY = 0.25
"""Largest last drift over the one half a watch before. Of a settling phase e^-4 = 0.02 is
left; an escape has made it grow; a slow passage between two slips leaves it much as it was."""

AT_REST = 1e-4
"""Drift [rad] that counts as zero: ripple and the engine's own errors hide whether it grows. There
the slope of the coupling torque decides."""


def outcome(times: Any, values: Mapping[str, Any], p: RotorPendulum) -> str:
    """Return the long-term motion of a run: synchronised, not synchronised, or undecided.

    The end of the run is watched for ``WATCH / rate`` with the rate at which the phase
    settles by the Poincare method (`phase_rate`), and for `LEAST_TURNS` turns at least.
    The first that holds of:

    1. *undecided*: a value is not finite; nothing resists the rotors.
    2. *not synchronised*: a rotor stands still at the end, having had the time to start
       (`STALLED`, `STALL_TIME`). Two rotors at rest share phase and speed.
    3. *undecided*: the run is shorter than the watch, or has fewer than `LEAST_SAMPLES`
       samples to a turn.
    4. *not synchronised*: a rotor stands still at any sample of the watch.
    5. *undecided*: an angle jumps away from its rate (`JUMP`): a reset.
    6. *not synchronised*: in the second half of the watch one rotor gains a turn on the other.
    7. *undecided*: the phase drifts by more than `DRIFT` times the rate, or its drift does
       not decay (`DECAY`) although it is not `AT_REST`: still settling, about to slip, or
       escaping from the unstable phase difference.
    8. *undecided*: the phase rests where the coupling torque drives it away. Small errors
       hold it there for a while, not for ever.
    9. *synchronised*: all others.

    Phases are averaged on the circle, over each quarter of the watch; drifts are what they
    change by from the first to the second quarter, and from the third to the last.

    Parameters
    ----------
    times : array (n,)
        Sample times [s], increasing.
    values : mapping
        ``phi_1``, ``phi_2`` [rad, wrapped or not], ``phi_1_dot``, ``phi_2_dot`` [rad/s].
    p : RotorPendulum

    Returns
    -------
    {"synchronised", "not synchronised", "undecided"}
    """
    t = np.asarray(times, dtype=float)
    angles = np.array([values["phi_1"], values["phi_2"]], dtype=float)
    rates = np.array([values["phi_1_dot"], values["phi_2_dot"]], dtype=float)
    c = coefficients(p)
    if len(t) < 2 or not np.all(np.isfinite([t, *angles, *rates])) or c.loss == 0:
        return "undecided"
    start = STALL_TIME * c.unbalance * c.eccentricity / c.loss
    slowest = STALLED * float(operating_speed(p))
    if t[-1] - t[0] >= start and np.any(np.mean(rates[:, t >= t[-1] - start], axis=1) < slowest):
        return "not synchronised"
    speed = float(np.max(np.mean(rates[:, t >= (t[0] + t[-1]) / 2], axis=1)))
    rate = float(phase_rate(p, speed))
    if not (speed > 0 and rate > 0):
        return "undecided"
    watch = max(WATCH / rate, LEAST_TURNS * 2 * np.pi / speed)
    seen = t >= t[-1] - watch
    if watch > t[-1] - t[0] or np.max(np.diff(t[seen])) * speed > 2 * np.pi / LEAST_SAMPLES:
        return "undecided"
    t, angles, rates = t[seen], angles[:, seen], rates[:, seen]
    if np.any(rates < slowest):
        return "not synchronised"
    steps = np.diff(t) * (rates[:, 1:] + rates[:, :-1]) / 2
    if np.max(abs(wrapped(np.diff(angles, axis=1) - steps))) > JUMP:
        return "undecided"
    if abs(np.sum((steps[0] - steps[1])[t[1:] > t[-1] - watch / 2])) > 2 * np.pi:
        return "not synchronised"
    phases = _quarterly_phases(t, angles[0] - angles[1], watch)
    early, last = abs(wrapped(phases[1::2] - phases[::2]))
    if last > min(DRIFT * rate * watch / 4, max(DECAY * early, AT_REST)):
        return "undecided"
    return "synchronised" if settling_rate(p, phases[3], speed) > 0 else "undecided"


def _quarterly_phases(t: Array, alpha: Array, watch: float) -> Array:
    """Mean phase in each quarter of the watch, with Hann's weights."""
    place = 4 * (1 - (t[-1] - t) / watch)  # 0 to 4
    weights = np.sin(np.pi * place) ** 2 * np.gradient(t)
    parts = [(place >= i) & (place <= i + 1) for i in range(4)]
    return np.array([mean_phase(alpha[part], weights[part]) for part in parts])

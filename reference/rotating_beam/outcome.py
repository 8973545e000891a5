"""What a run of `rotating_beam` is judged by, and whether its deflection stays bounded."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from .parameters import RotatingBeam, drive_end_time, period

RUN_UNITS = {"tip_peak": "m", "tip_peak_time": "s", "tip_rms_after": "m"}


def run_quantities(
    times: Any, values: Mapping[str, Any], p: RotatingBeam
) -> dict[str, tuple[float, float]]:
    """Largest deflection of the tip, its time, and the RMS value once nothing drives the hub.

    Between samples by cubics that have their rates. An error of the rate shifts the time of the
    peak by its share of the acceleration there.
    """
    tip = CubicHermiteSpline(times, values["tip_deflection"], values["tip_deflection_dot"])
    inner = tip.derivative().roots(extrapolate=False)
    at = np.concatenate([inner, [times[0], times[-1]]])
    peak = float(at[np.argmax(np.abs(tip(at)))])
    after = np.asarray(times) >= drive_end_time(p)
    rest = values["tip_deflection"][after] if np.any(after) else np.zeros(1)
    return {
        "tip_peak": (float(tip(peak)), 1.0),
        "tip_peak_time": (peak, 1 / max(abs(float(tip(peak, 2))), 1e-12)),
        "tip_rms_after": (float(np.sqrt(np.mean(rest**2))), 1.0),
    }


def outcome(times: Any, values: Mapping[str, Any], p: RotatingBeam) -> str:
    """Tell whether the deflection stays bounded.

    The first that holds of:

    1. *diverges*: the tip is farther beside the axis than the beam is long.
    2. *undecided*: a value is not finite; after the drive's end the run lasts less than
       `WATCH` times `period`.
    3. *diverges*: in the last third of that time the deflection swings `RISE` times as far
       as in the first. A vibration that goes on does not: nothing damps it, nothing drives it.
    4. *bounded*: what is left.
    """
    t, tip = np.asarray(times, dtype=float), np.asarray(values["tip_deflection"], dtype=float)
    if np.any(np.abs(tip) > p.length * BEYOND):
        return "diverges"
    rest = t - (p.ramp_time if p.drive == "prescribed" else p.torque_period)
    if not (len(t) and np.all(np.isfinite(tip)) and rest[-1] >= WATCH * period(p)):
        return "undecided"
    first, last = (
        np.max(np.abs(tip[(rest >= start * rest[-1]) & (rest <= end * rest[-1])]), initial=0.0)
        for start, end in ((0, 1 / 3), (2 / 3, 1))
    )
    return "diverges" if last > RISE * first else "bounded"


WATCH = 2.0

BEYOND = 1.1
"""Tip's deflection over the length; no inextensible beam has more than 1."""

RISE = 3.0
"""Share of the first by which the last deflections may be larger: beats of two modes."""

"""The foot of a spring that moves harmonically: a drive without controls, in MJCF.

An undamped oscillator, so heavy that nothing else moves it, starts at its largest excursion: the
spring between it and a slide pulls as a force F cos(omega t) on the slide would.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import cos, sin
from typing import Any

from .mjcf import Binding

CLOCK_INERTIA = 2.0**60
"""Armature of the spring's foot [kg]; the file of hula_hoop tells why."""


def foot_motion(c: Any, time: float) -> tuple[float, float]:
    """Return position and velocity of the foot, (F/k) cos(omega t), from coefficients."""
    amplitude, phase = c.force / c.stiffness, c.omega * time
    return amplitude * cos(phase), -amplitude * c.omega * sin(phase)


def foot_bindings(coefficients: Callable[[Any], Any]) -> Mapping[tuple[str, str], Binding]:
    """Return the bindings of the foot and of its spring, from a scene's coefficients."""
    return {
        ("joint:foot", "ref"): lambda p: coefficients(p).force / coefficients(p).stiffness,
        ("joint:foot", "stiffness"): lambda p: CLOCK_INERTIA * coefficients(p).omega ** 2,
        ("fixed:spring", "stiffness"): lambda p: coefficients(p).stiffness,
    }

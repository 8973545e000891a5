"""Extremes of `rigid_body`: its free vibrations."""

from __future__ import annotations

from ..extremes import FreeVibration

FREE_VIBRATION = FreeVibration(undamped={}, stiffness=None, damping=None, speed=None)
"""Swings about hanging; no parameter makes them as fast as one likes."""

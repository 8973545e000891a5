"""Extremes of `ball_hoop`: its free vibrations."""

from __future__ import annotations

from ..extremes import FreeVibration

FREE_VIBRATION = FreeVibration(
    undamped={"damping": 0.0, "joint_damping": 0.0},
    stiffness="stiffness",
    damping="damping",
    speed=None,
)
"""The slide with the body, that may turn as it likes."""

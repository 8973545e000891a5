"""Extremes of `floating_platform`: its free vibrations."""

from __future__ import annotations

from ..extremes import FreeVibration

FREE_VIBRATION = FreeVibration(
    undamped={"rod_damping": 0.0},
    stiffness="rod_stiffness",
    damping="rod_damping",
    speed=None,
)
"""The rod on its torsion spring against a platform that nothing holds."""

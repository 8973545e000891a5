"""Extremes of `floating_beam`: its free vibrations."""

from __future__ import annotations

from ..extremes import FreeVibration

FREE_VIBRATION = FreeVibration(
    undamped={"hinge_damping": 0.0},
    stiffness="bending_stiffness",
    damping="hinge_damping",
    speed=None,
)
"""The rods on their torsion springs against a hub that nothing holds."""

"""The chain of rotating_beam, and its frequencies by its linearised equations."""

from __future__ import annotations

import numpy as np

from mbcheck.reference.linear import linearise, modes
from mbcheck.reference.rotating_beam.chain import chain_scene
from mbcheck.reference.rotating_beam.parameters import RotatingBeam, hanging, rotation
from mbcheck.reference.scene import Array, EquationsOfMotion


def scene_of(p: RotatingBeam) -> EquationsOfMotion:
    """Return the chain of these ``segments`` and this ``scheme``."""
    return chain_scene(int(p.segments), p.scheme)


def chain_frequencies(
    p: RotatingBeam, count: int = 2, scene: EquationsOfMotion | None = None
) -> Array:
    """Return the lowest chordwise frequencies (count,) [rad/s] in steady rotation, or hanging.

    The hub's motion is prescribed, whatever drives it.
    """
    scene = scene_of(p) if scene is None else scene
    state = scene.state((hanging if p.has_gravity else rotation)(p))
    mass, damping, stiffness = linearise(scene, p.replace(drive="prescribed"), state)
    vibrations = modes(mass, damping, stiffness, steady=[0])[1:]
    return np.array([mode.omega for mode in vibrations[:count]])

"""rotor_pendulum as Exudyn models: a kinematic tree, and bodies joined by constraints."""

from __future__ import annotations

from collections.abc import Mapping

from ..exudyn_mjcf import build_plane, build_tree, model_of
from ..exudyn_system import Model
from .mjcf import MODELS as MJCF

MODELS: Mapping[str, Model] = {
    "kinematic_tree": model_of("rotor_pendulum", MJCF["tree"], build_tree),
    "redundant": model_of("rotor_pendulum", MJCF["tree"], build_plane),
}
"""Models by name, default first."""

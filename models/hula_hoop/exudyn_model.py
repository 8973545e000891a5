"""hula_hoop as Exudyn models: a kinematic tree, and bodies joined by constraints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ...reference.hula_hoop.equations import HulaHoop
from ..exudyn_mjcf import build_plane, build_tree, model_of
from ..exudyn_system import Model
from ..mjcf import Mjcf
from .mjcf import MODELS as MJCF


def inertia(p: HulaHoop) -> tuple[float, float, float]:
    """Return the moment of inertia of the free mass about its centre; Exudyn takes any."""
    return (p.inertia_ratio * p.free_mass * p.rod_length**2,) * 3


def of_points(source: Mjcf) -> Mjcf:
    """Return the model with this moment of inertia."""
    exact = {("body:rod/inertial", "diaginertia"): inertia}
    return replace(source, bindings={**source.bindings, **exact})


MODELS: Mapping[str, Model] = {
    "kinematic_tree": model_of("hula_hoop", of_points(MJCF["tree"]), build_tree),
    "redundant": model_of("hula_hoop", of_points(MJCF["tree"]), build_plane),
}
"""Models by name, default first."""

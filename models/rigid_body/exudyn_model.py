"""rigid_body as an Exudyn model: a body with Euler parameters, fixed at a point."""

from __future__ import annotations

from collections.abc import Mapping

from ..exudyn_mjcf import build_space, model_of
from ..exudyn_system import Model
from .mjcf import MODELS as MJCF

MODELS: Mapping[str, Model] = {
    "euler_parameters": model_of("rigid_body", MJCF["ball"], build_space),
}
"""Models by name, default first."""

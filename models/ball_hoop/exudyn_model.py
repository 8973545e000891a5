"""ball_hoop as an Exudyn model: a mass on a slide, and a body with Euler parameters."""

from __future__ import annotations

from collections.abc import Mapping

from ..exudyn_mjcf import build_space, model_of
from ..exudyn_system import Model
from .mjcf import MODELS as MJCF

MODELS: Mapping[str, Model] = {
    "euler_parameters": model_of("ball_hoop", MJCF["ball"], build_space),
}
"""Models by name, default first."""

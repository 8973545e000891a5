"""floating_platform as an Exudyn model: three bodies with Euler parameters, two hinges."""

from __future__ import annotations

from collections.abc import Mapping

from ..exudyn_mjcf import build_space, model_of
from ..exudyn_system import Model
from .mjcf import MODELS as MJCF

MODELS: Mapping[str, Model] = {
    "euler_parameters": model_of("floating_platform", MJCF["free"], build_space),
}
"""Models by name, default first."""

"""``export``: the MJCF of a scene at a user's parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...models import mjcf
from .query import known_name, user_case


def mjcf_text(
    scene: str, parameters: Mapping[str, Any] | None = None, model: str | None = None
) -> str:
    """Return the MJCF of a scene with these parameters.

    Raises
    ------
    UsageError
        For unknown names, impossible values, or a scene without MJCF.
    """
    case, models = user_case(scene, parameters), mjcf.models(scene)
    name = known_name(f"MJCF model of {scene}", model, tuple(models))
    return mjcf.export(models[name], case.parameters)

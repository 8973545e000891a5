"""What a scene's folder tells the features: tables that it fills, and that are empty elsewhere."""

from __future__ import annotations

from importlib import import_module
from typing import TypeVar

from ...reference import SCENES
from ...reference.errors import UnknownNameError

T = TypeVar("T")


def scene_data(scene: str, feature: str, table: str, empty: T) -> T:
    """Return a table of ``comparisons/scenes/<scene>/<feature>.py``.

    Parameters
    ----------
    scene, feature, table : str
        Scene, module and name in it.
    empty : object
        What a scene without this table has.

    Raises
    ------
    UnknownNameError
        If there is no such scene.
    """
    if scene not in SCENES:
        raise UnknownNameError("scene", scene, SCENES)
    name = f"{__package__}.{scene}.{feature}"
    try:
        module = import_module(name)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{name}.".startswith(f"{error.name}."):
            raise
        return empty
    filled: T = vars(module).get(table, empty)
    return filled

"""Tables in a scene's folder, which are empty for other scenes."""

from __future__ import annotations

from typing import TypeVar

from ...models.tables import table_of
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
    return table_of(f"{__package__}.{scene}.{feature}", table, empty)

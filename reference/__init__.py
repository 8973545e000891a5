"""The truth: parameters, equations of motion, solvers, orbits. Imports no engine."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from .errors import UnknownNameError

if TYPE_CHECKING:
    from .scene import Scene

SCENES = (
    "hula_hoop",
    "rotor_pendulum",
    "rotating_beam",
    "speed_regulator",
    "rigid_body",
    "ball_hoop",
    "floating_platform",
    "floating_beam",
)
"""The scenes, registered here and nowhere else; each is a module of this package with a
`SCENE`, and a folder of the same name in `models`."""


def get_scene(name: str) -> Scene:
    """Return the scene of this name.

    Raises
    ------
    UnknownNameError
        If there is none.
    """
    if name not in SCENES:
        raise UnknownNameError("scene", name, SCENES)
    scene: Scene = import_module(f".{name}", __name__).SCENE
    return scene

"""What is true of floating_beam: a chain of rods on a hub that floats, cases, mistakes in it."""

from .scene import SCENE

__all__ = ["SCENE"]

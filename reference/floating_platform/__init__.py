"""What is true of floating_platform: equations of motion, momenta, cases, mistakes in it."""

from .scene import SCENE

__all__ = ["SCENE"]

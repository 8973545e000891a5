"""What is true of ball_hoop: equations of motion, cases, mistakes in it."""

from .scene import SCENE

__all__ = ["SCENE"]

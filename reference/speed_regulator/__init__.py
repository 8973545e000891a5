"""What is true of speed_regulator: equations of motion, cases, theory."""

from .scene import SCENE

__all__ = ["SCENE"]

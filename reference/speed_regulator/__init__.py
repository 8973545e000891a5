"""What is true of speed_regulator: equations of motion, cases, theory."""

from .equations import SCENE

__all__ = ["SCENE"]

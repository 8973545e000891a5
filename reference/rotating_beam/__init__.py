"""What is true of rotating_beam: equations of motion, cases, theory."""

from .scene import SCENE

__all__ = ["SCENE"]

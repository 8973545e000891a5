"""What is true of rotating_beam: equations of motion, cases, theory."""

from .equations import SCENE

__all__ = ["SCENE"]

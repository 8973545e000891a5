"""The scene `hula_hoop`: equations of motion, cases, theory."""

from .equations import SCENE

__all__ = ["SCENE"]

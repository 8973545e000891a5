"""What is true of rigid_body: equations of motion, cases, integrals."""

from .scene import SCENE

__all__ = ["SCENE"]

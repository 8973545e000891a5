"""What is true of rotor_pendulum: equations of motion, cases, theory."""

from .equations import SCENE

__all__ = ["SCENE"]

"""What is true of rotor_pendulum: equations of motion, cases, theory."""

from .scene import SCENE

__all__ = ["SCENE"]

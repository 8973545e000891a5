"""MuJoCo with a closure of another impedance, and without its machinery for constraints."""

from __future__ import annotations

from typing import Any

from ....models import mjcf
from ....models.speed_regulator.mjcf import closed_by
from ....reference.scene import Case
from ....reference.speed_regulator.soft import SOLIMP, SOLREF
from ..mujoco import MujocoEngine


class Softened(MujocoEngine):
    """MuJoCo with the default ``solref`` and a constant impedance in the loop's closure.

    Attributes
    ----------
    softness : float
        1 less the impedance.
    """

    softness = 1 - SOLIMP[1]

    def source(self, case: Case, model: str) -> mjcf.Mjcf:
        """Return the named MJCF model, ``connect`` with this impedance."""
        if model != "connect":
            return super().source(case, model)
        impedance = 1 - self.softness
        return closed_by(SOLREF, (impedance, impedance, *SOLIMP[2:]))


def softened(softness: float) -> Softened:
    """Return MuJoCo with this softness of the closure."""
    engine = Softened()
    engine.softness = softness
    return engine


class Bare(MujocoEngine):
    """MuJoCo with constraints disabled, for models that have none."""

    def load(self, case: Case, model: str) -> Any:
        """Return the compiled model of a case with the flag set."""
        compiled = super().load(case, model)
        compiled.opt.disableflags |= self.mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        return compiled

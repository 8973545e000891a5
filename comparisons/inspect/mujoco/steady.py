"""A steady motion of an MJCF model: one hinge turns, and all else keeps its place beside it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....reference.errors import UnknownNameError, UsageError
from ....reference.scene import Array
from .linear import RANK, LinearProbe, slopes
from .model import Loaded, Numbers, State

NEWTON_STEPS = 60
SETTLED = 1e-12
"""Share of the forces that a steady motion leaves unbalanced."""

LONGEST_CHANGE = 0.5
"""Largest change of a coordinate in one of Newton's steps [rad, m]."""

STEADY = 1e-6
"""Share by which forces may change as a steady rotation goes on."""

TURNS = (0.4, 1.1, 2.3)
"""Angles [rad] at which that is looked at."""


def steady_rotation(loaded: Loaded, joint: str, speed: float | str) -> State:
    """Find the steady motion in which a hinge turns and all else keeps its place beside it.

    From the first keyframe, or `qpos0`, by Newton's method; the hinge is held at its speed.

    Raises
    ------
    UsageError
        If there is no such hinge, or no such motion.
    """
    dof = hinge(loaded, joint)
    if isinstance(speed, str) or not np.isfinite(speed):
        raise UsageError(f"the speed of {joint} must be a finite number [rad/s], not {speed}")
    hinge_alone = np.eye(loaded.model.nv)[dof]
    first = loaded.states[min(1, len(loaded.states) - 1)]
    name = f"{joint} at {speed:g} rad/s"
    state = first._replace(keys=(name,), velocity=np.where(hinge_alone, speed, 0.0))
    rest = Rest(LinearProbe(loaded, state), np.flatnonzero(hinge_alone == 0))
    position, excess = state.position, np.inf
    for _ in range(NEWTON_STEPS):
        excess = rest.unbalanced(position)
        if excess <= SETTLED:
            break
        position = rest.probe.displaced(rest.change(position), position)
    if not excess <= SETTLED:
        raise UsageError(
            f"no steady motion was found with {name}: a share of {excess:.2g} "
            "of the forces is left unbalanced; start nearer to it, with a keyframe"
        )
    for angle in TURNS:
        change = rest.unbalanced(rest.probe.displaced(angle * hinge_alone, position))
        if change > STEADY:
            raise UsageError(
                f"a rotation of {joint} is not steady: {angle:g} rad on, a share of {change:.2g} "
                "of the forces is unbalanced (gravity across the axis does that)"
            )
    return state._replace(position=position)


def hinge(loaded: Loaded, joint: str) -> int:
    """Return the degree of freedom of a hinge.

    Raises
    ------
    UsageError
        If there is none of this name.
    """
    names = [loaded.name("joint", i) for i in range(loaded.model.njnt)]
    if joint not in names:
        raise UnknownNameError("joint", joint, names)
    if not loaded.of_kind("jnt_type", "hinge")[names.index(joint)]:
        raise UsageError(f"{joint} is no hinge, and only a hinge can turn steadily")
    return int(loaded.model.jnt_dofadr[names.index(joint)])


class Rest(NamedTuple):
    """What moves with a joint that turns steadily: a probe in that motion, and the other dofs."""

    probe: LinearProbe
    others: Numbers

    def forces(self, position: Array) -> tuple[Array, Array]:
        """Return forces (k,) that are not balanced, and how large they may be."""
        velocity = self.probe.state.velocity
        self.probe.put(position, velocity)
        inertia, passive, actuator, _ = self.probe.forces(np.zeros_like(velocity))
        if self.probe.data.ne:
            raise UsageError("a model with closed loops does not rotate steadily")
        size = np.abs(inertia) + np.abs(passive) + np.abs(actuator)
        size += np.diag(self.probe.mass()) * max(1.0, float(np.max(velocity**2)))
        return (inertia - passive - actuator)[self.others], size[self.others]

    def unbalanced(self, position: Array) -> float:
        """Return the largest share of the forces that is not balanced."""
        left, size = self.forces(position)
        return float(np.max(np.abs(left / size), initial=0.0))

    def change(self, position: Array) -> Array:
        """Return Newton's change (nv,) of the other coordinates, of bounded size.

        It moves none of those that float freely.
        """
        others = np.eye(len(self.probe.scale))[:, self.others]

        def shifted(displacement: Array) -> Array:
            return self.forces(self.probe.displaced(others @ displacement, position))[0][None]

        slope = slopes(shifted, self.probe.scale[self.others])[0]
        largest = np.max(np.abs(slope), axis=1, keepdims=True)
        largest[largest == 0] = 1.0
        left = -self.forces(position)[0] / largest[:, 0]
        change = np.linalg.lstsq(slope / largest, left, rcond=RANK)[0]
        return np.asarray(others @ change * min(1.0, LONGEST_CHANGE / np.max(np.abs(change))))

"""Steady rotations of an MJCF model: one hinge turns, all other joints keep their positions."""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

from ....reference.errors import UnknownNameError, UsageError
from ....reference.scene import Array
from ..tuning import NUMERICS
from .linear import LinearProbe
from .model import Loaded, State


def steady_rotation(loaded: Loaded, joint: str, speed: float | str) -> State:
    """Find the steady motion in which a hinge turns and all other joints keep their positions.

    The search starts from the first keyframe, or `qpos0`, and uses the method of Levenberg and
    Marquardt, which does not move bodies that float freely; the hinge keeps its speed.

    Raises
    ------
    UsageError
        If there is no such hinge, or no such motion.
    """
    m, names = loaded.model, [loaded.name("joint", i) for i in range(loaded.model.njnt)]
    if joint not in names:
        raise UnknownNameError("joint", joint, names)
    if not loaded.of_kind("jnt_type", "hinge")[names.index(joint)]:
        raise UsageError(f"{joint} is not a hinge: give a hinge, which alone can turn steadily")
    if isinstance(speed, str) or not np.isfinite(speed):
        raise UsageError(f"the speed of {joint} must be a finite number [rad/s], not {speed}")
    axes, dof = np.eye(m.nv), int(m.jnt_dofadr[names.index(joint)])
    turn, others = axes[dof], np.delete(axes, dof, axis=1)
    first = loaded.states[min(1, len(loaded.states) - 1)]
    name = f"{joint} at {speed:g} rad/s"
    state = first._replace(keys=(name,), velocity=turn * speed)
    probe = LinearProbe(loaded, state)

    def moved(x: Array, angle: float = 0.0) -> Array:
        return probe.displaced(probe.scale * (others @ x) + angle * turn)

    def unbalanced(x: Array, angle: float = 0.0) -> float:
        left, size = unbalanced_forces(probe, moved(x, angle))
        return float(np.max(np.abs(left / size) @ others, initial=0.0))

    x, exact = np.zeros(others.shape[1]), dict.fromkeys(("xtol", "ftol", "gtol"), 1e-15)
    _, size = unbalanced_forces(probe, moved(x))
    if x.size:
        x = least_squares(
            lambda x: (unbalanced_forces(probe, moved(x))[0] / size) @ others,
            x,
            "3-point",
            method="lm",
            **exact,
        ).x
    excess = unbalanced(x)
    if not excess <= NUMERICS.balanced:
        raise UsageError(
            f"no steady motion was found with {name}: a share of {excess:.2g} of the forces is "
            "unbalanced; start nearer to it, with a keyframe"
        )
    for angle in NUMERICS.steady_angles:
        change = unbalanced(x, angle)
        if change > NUMERICS.steady:
            raise UsageError(
                f"a rotation of {joint} is not steady: after {angle:g} rad a share of {change:.2g} "
                "of the forces is unbalanced (gravity across the axis has this effect)"
            )
    return state._replace(position=moved(x))


def unbalanced_forces(probe: LinearProbe, position: Array) -> tuple[Array, Array]:
    """Return the unbalanced forces (nv,) in a steady motion, and the size of the acting ones."""
    velocity = probe.state.velocity
    probe.put(position, velocity)
    inertia, passive, actuator, _ = probe.forces(np.zeros_like(velocity))
    if probe.data.ne:
        raise UsageError("a model with closed loops does not rotate steadily")
    size = np.abs(inertia) + np.abs(passive) + np.abs(actuator)
    size += np.diag(probe.mass()) * max(1.0, float(np.max(velocity**2)))
    return inertia - passive - actuator, size

"""Rotations without quaternions: rotation vectors from the last attitude, a second formulation.

Iserles, Munthe-Kaas, Norsett, Zanna (2000), Acta Numerica 9, 215-365, section 3.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from mbcheck.reference.scene import Array

CHARTS = 20
"""In a second."""


def by_rotation_vector(
    accelerate: Callable[[float, Array, Array, Array, Array], tuple[Array, Array]],
    rotation: Array,
    omega: Array,
    times: Array,
    others: Array,
) -> tuple[Array, Array, Array]:
    """Return rotations (k, 3, 3), body rates (k, 3) and other states (k, 2 m) at times (k,).

    Parameters
    ----------
    accelerate : callable ``(t, rotation, omega, positions, velocities) -> (accelerations, omega')``
        Of m other coordinates, and of the angular velocity in the frame of the body.
    rotation, omega : array (3, 3), (3,)
        At t = 0.
    times : array (k,)
    others : array (2 m,)
        Positions and velocities at t = 0.
    """

    def rates(t: float, start: Array, x: Array) -> Array:
        vector, spin, rest = x[:3], x[3:6], x[6:]
        angle = float(np.linalg.norm(vector))
        near = 1 / 12 + angle**2 / 720 + angle**4 / 30240
        share = near if angle < 1e-2 else (1 - angle / 2 / np.tan(angle / 2)) / angle**2
        turn = np.cross(vector, spin)
        here = start @ Rotation.from_rotvec(vector).as_matrix()
        positions, velocities = np.split(rest, 2)
        faster, twist = accelerate(t, here, spin, positions, velocities)
        bent = spin + turn / 2 + share * np.cross(vector, turn)
        return np.concatenate([bent, twist, velocities, faster])

    rows, now = [], 0.0
    for time in times:
        for start, end in pairwise(np.linspace(now, time, int(np.ceil((time - now) * CHARTS)) + 1)):
            solution = solve_ivp(
                lambda t, x, at=rotation: rates(t, at, x),
                (start, end),
                np.concatenate([np.zeros(3), omega, others]),
                "DOP853",
                rtol=1e-13,
                atol=1e-14,
            )
            vector, omega, others = np.split(solution.y[:, -1], [3, 6])
            rotation = rotation @ Rotation.from_rotvec(vector).as_matrix()
        now = time
        rows.append((rotation, omega, others))
    return tuple(np.array(column) for column in zip(*rows, strict=True))  # type: ignore[return-value]

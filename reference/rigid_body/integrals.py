"""What a turning rigid body conserves.

Landau, Lifshitz, Mechanics, sections 35 and 37; Whittaker, Analytical Dynamics, sections 69-72;
Goldstein, Poole, Safko, Classical Mechanics, sections 5.6 and 5.7.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..body.parameters import body_inertia
from ..body.rotation import body_rates, momentum_of, times
from ..quaternions import matrix
from ..scene import Array
from .equations import RigidBody, energy

SAME = 1e-12
"""Relative difference of moments that count as the same."""


def magnitude(q: Any, v: Any, c: Any) -> Any:
    """Return the size of the angular momentum [kg m^2/s]."""
    return np.sqrt(sum(part * part for part in momentum_of(q, v, c)))


def along_gravity(q: Any, v: Any, c: Any) -> Any:
    """Return the angular momentum along gravity [kg m^2/s]."""
    g = np.array([c.g_x, c.g_y, c.g_z])
    return sum(a * b for a, b in zip(momentum_of(q, v, c), g / np.linalg.norm(g), strict=True))


def about_figure(q: Any, v: Any, c: Any) -> Any:
    """Return the angular momentum about the line to the centre of mass: of Lagrange's top."""
    arm = np.array(c[0:3]) / np.linalg.norm(c[0:3])
    return sum(a * b for a, b in zip(times(c[3:9], body_rates(q, v)[1]), arm, strict=True))


def kovalevskaya(q: Any, v: Any, c: Any) -> Any:
    """Return Kovalevskaya's integral [1/s^4] of a top with J_x = J_y = 2 J_z and C on the x axis.

    Whittaker, section 72: ``|(omega_x + i omega_y)^2 - nu (gamma_x + i gamma_y)|^2`` with
    nu = s g / J_z and the upward vertical gamma in the frame of the body.
    """
    omega, rows = body_rates(q, v)[1], matrix(q)
    g = np.array([c.g_x, c.g_y, c.g_z])
    up = [-sum(rows[i][j] * g[i] for i in range(3)) * c.s_x / c.inertia_zz for j in range(2)]
    real = omega[0] ** 2 - omega[1] ** 2 - up[0]
    imaginary = 2 * omega[0] * omega[1] - up[1]
    return real**2 + imaginary**2


def invariants(p: RigidBody) -> Mapping[str, Callable[..., Any]]:
    """Return energy and angular momentum, and the fourth integral of the tops that have one."""
    tensor, arm = body_inertia(p), p.centre
    known: dict[str, Callable[..., Any]] = {"energy": energy}
    if not np.any(arm) or not np.any(p.gravity):
        return known | {"momentum": magnitude}
    known["momentum"] = along_gravity
    if is_symmetric(tensor, arm):
        known["spin"] = about_figure
    if is_kovalevskaya(tensor, arm):
        known["kovalevskaya"] = kovalevskaya
    return known


def is_symmetric(tensor: Array, arm: Array) -> bool:
    """Return whether a tensor (3, 3) is the same about all axes across an arm (3,)."""
    e = arm / np.linalg.norm(arm)
    along = e @ tensor @ e
    across = (np.trace(tensor) - along) / 2
    symmetric = across * np.eye(3) + (along - across) * np.outer(e, e)
    return bool(np.max(np.abs(tensor - symmetric)) <= SAME * across)


def is_kovalevskaya(tensor: Array, arm: Array) -> bool:
    """Return whether J = diag(2, 2, 1) J_z, with the centre of mass on the x axis."""
    right = tensor[2, 2] * np.diag([2.0, 2.0, 1.0])
    return not np.any(arm[1:]) and bool(np.max(np.abs(tensor - right)) <= SAME * tensor[0, 0])

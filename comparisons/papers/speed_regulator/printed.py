"""Equations (7)-(19) of the speed_regulator paper as printed, and put right.

All functions take crank angles of any shape; rows of vectors come first.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ....reference.scene import Array
from ....reference.speed_regulator.equations import SpeedRegulator


class PrintedKinematics(NamedTuple):
    """Equations (2)-(12).

    Attributes
    ----------
    beta : array
    t, u : array
        (7), (10).
    places : array (5, ...)
        phi, x_C, y_C, -beta, y_B of (2), (3).
    a_1, a_2 : array (5, ...)
        (11), (12).
    """

    beta: Any
    t: Any
    u: Any
    places: Any
    a_1: Any
    a_2: Any


def kinematics(phi: Any, p: SpeedRegulator) -> PrintedKinematics:
    """Return what (2)-(12) say at crank angles, complex ones included."""
    r, l = p.crank_radius, p.rod_length
    ratio, sin, cos = r / l, np.sin(phi), np.cos(phi)
    beta = np.arcsin(ratio * cos)
    sin_b, cos_b = np.sin(beta), np.cos(beta)
    t = ratio * sin / cos_b
    u = ratio * cos / cos_b - t**2 * sin_b / cos_b
    places = [phi, r * cos - l / 2 * sin_b, r * sin - l / 2 * cos_b, -beta, r * sin - l * cos_b]
    a_1 = [
        1 + 0 * phi,
        -r * sin + l / 2 * t * cos_b,
        r * cos - l / 2 * t * sin_b,
        t,
        r * cos - l * t * sin_b,
    ]
    a_2 = [
        0 * phi,
        -r * cos + l / 2 * t**2 * sin_b + l / 2 * u * cos_b,
        -r * sin + l / 2 * t**2 * cos_b - l / 2 * u * sin_b,
        u,
        -r * sin + l * t**2 * cos_b - l * u * sin_b,
    ]
    return PrintedKinematics(beta, t, u, np.array(places), np.array(a_1), np.array(a_2))


def masses(p: SpeedRegulator) -> Array:
    """Return the diagonal of [m] in (13), the rod homogeneous."""
    rod = p.rod_mass * p.rod_length**2 / 12
    return np.array([p.flywheel_inertia, p.rod_mass, p.rod_mass, rod, p.slider_mass])


def reaction_matrix(phi: float, p: SpeedRegulator, printed: bool = False) -> Array:
    """Return [N] of (14) at one angle; row 4 as printed has lost the minus signs of (13)."""
    r, l = p.crank_radius, p.rod_length
    beta = float(kinematics(phi, p).beta)
    x, y = l / 2 * np.cos(beta), l / 2 * np.sin(beta) * (1 if printed else -1)
    return np.array(
        [
            [-r * np.sin(phi), r * np.cos(phi), 0, 0],
            [-1, 0, 1, 0],
            [0, -1, 0, 1],
            [x, y, x, y],
            [0, 0, 0, -1],
        ]
    )


def free_bodies(phi: float, speed: float, p: SpeedRegulator, printed: bool = False) -> Array:
    """Return phi'' and X_A, Y_A, X_B, Y_B by (14), its five rows solved together."""
    at = kinematics(phi, p)
    load = p.damping * at.a_1[4] * speed + spring(phi, p)
    external = np.array([p.torque, 0, 0, 0, -load])
    m = masses(p)
    matrix = np.column_stack([m * at.a_1, -reaction_matrix(phi, p, printed)])
    return np.asarray(np.linalg.solve(matrix, external - m * at.a_2 * speed**2))


def spring(phi: Any, p: SpeedRegulator) -> Any:
    """Return F_e: that of (13) where ``spring_rest`` is -l."""
    return p.stiffness * (kinematics(phi, p).places[4] - p.spring_rest)


def moment_of_inertia(phi: Any, p: SpeedRegulator) -> Any:
    """Return J(phi) of (18)."""
    a_1 = kinematics(phi, p).a_1
    return np.tensordot(masses(p), a_1 * a_1, 1)


def printed_slope(phi: Any, p: SpeedRegulator) -> Any:
    """Return J'(phi) as (18) prints it: half of the derivative."""
    at = kinematics(phi, p)
    return np.tensordot(masses(p), at.a_1 * at.a_2, 1)


def torque(phi: Any, speed: Any, p: SpeedRegulator) -> Any:
    """Return M of (19) by its first two lines."""
    y_phi = kinematics(phi, p).a_1[4]
    return p.torque - y_phi * (p.damping * speed * y_phi + spring(phi, p))


def acceleration(phi: Any, speed: Any, p: SpeedRegulator, factor: float = 2.0) -> Any:
    """Return phi'' by (17) with (18), (19); ``factor`` 1 takes J' as printed, 2 puts it right."""
    slope = factor * printed_slope(phi, p)
    return (torque(phi, speed, p) - slope * speed**2 / 2) / moment_of_inertia(phi, p)


SAMPLES = 4096
"""Of a turn; means of periodic functions are then exact to rounding up to lambda = 0.98."""


def averages(p: SpeedRegulator) -> dict[str, float]:
    """Return the means of section 3 over a turn of the crank.

    ``slope`` of J' over that of J; ``spring_19`` and ``spring_3`` of the spring's torque with the
    references of (19) and of section 3, over its amplitude; ``cos_squared``; ``remainder`` of
    t^2 sin^2 beta; ``mixed`` of t cos phi sin beta; ``damper`` of (r cos phi - l t sin beta)^2/l^2.
    """
    phi = 2 * np.pi * np.arange(SAMPLES) / SAMPLES
    at = kinematics(phi, p)
    y_phi, y, sin_b = at.a_1[4], at.places[4], np.sin(at.beta)
    near, far = y_phi * (p.rod_length + y), y_phi * (p.crank_radius + p.rod_length + y)
    means = {
        "slope": np.mean(printed_slope(phi, p)) / np.mean(moment_of_inertia(phi, p)),
        "spring_19": np.mean(near / np.max(abs(near))),
        "spring_3": np.mean(far / np.max(abs(far))),
        "cos_squared": np.mean(np.cos(phi) ** 2),
        "remainder": np.mean((at.t * sin_b) ** 2),
        "mixed": np.mean(at.t * np.cos(phi) * sin_b),
        "damper": np.mean(y_phi**2) / p.rod_length**2,
    }
    return {name: float(mean) for name, mean in means.items()}

"""speed_regulator as Exudyn models: bodies whose joints close the loop, and one coordinate.

Both are put together from the mechanism's masses, lengths, spring and damper (SI units).
The equations of motion of the bodies are Exudyn's own. It has none for a closed loop in one
coordinate, so that model brings its equation along, as Python functions: Exudyn 1.13 takes no
symbolic function for a mass matrix.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ...reference.differences import PROBE
from ...reference.scene import Array
from ...reference.speed_regulator.equations import SpeedRegulator
from ..exudyn_mjcf import build_plane, model_of
from ..exudyn_system import ExudynSystem, Model, exudyn, items
from .mjcf import MODELS as MJCF


def one_dof(p: SpeedRegulator, placement: str = "") -> ExudynSystem:
    """Return phi alone: ``J phi_ddot = M_m - y' (c y' phi_dot + k (y - y_0)) - J'/2 phi_dot^2``.

    Dashes are derivatives by phi; J sums mass times squared velocity per crank speed.
    """
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    node = mbs.AddNode(
        items.NodeGenericODE2(
            referenceCoordinates=[0],
            initialCoordinates=[0],
            initialCoordinates_t=[0],
            numberOfODE2Coordinates=1,
        )
    )
    masses = inertias(p)

    def inertia(mbs: Any, t: float, item: int, q: Any, q_t: Any) -> list[list[float]]:
        at = kinematics(p, q[0])
        return [[sum(m * u * u for m, u in zip(masses, at.velocities, strict=True))]]

    def torque(phi: Any, speed: Any, xp: Any = math) -> Any:
        at = kinematics(p, phi, xp)
        y, y_phi = at.positions[5], at.velocities[5]
        bends = zip(masses, at.velocities, at.accelerations, strict=True)
        half_slope = sum(m * u * bend for m, u, bend in bends)
        slider = p.damping * y_phi * speed + p.stiffness * (y - p.spring_rest)
        weight = p.slider_mass * p.gravity_y * y_phi
        weight += p.rod_mass * (p.gravity_x * at.velocities[1] + p.gravity_y * at.velocities[2])
        return p.torque - y_phi * slider - half_slope * speed * speed + weight

    def force(mbs: Any, t: float, item: int, q: Any, q_t: Any) -> list[float]:
        return [torque(q[0], q_t[0])]

    def jacobian(*call: Any) -> Array:
        *_, q, q_t, by_q, by_q_t = call
        along_q = torque(q[0] + 1j * PROBE, q_t[0], np).imag / PROBE
        along_q_t = torque(q[0], q_t[0] + 1j * PROBE).imag / PROBE
        return np.array([[-by_q * along_q - by_q_t * along_q_t]])

    mbs.AddObject(
        items.ObjectGenericODE2(
            nodeNumbers=[node],
            massMatrix=np.eye(1),  # gives way to the function
            massMatrixUserFunction=inertia,
            forceUserFunction=force,
            jacobianUserFunction=jacobian,  # Exudyn's own differences keep seven digits
        )
    )
    mbs.Assemble()

    def outputs(coordinates: Array, rates: Array) -> dict[str, Array]:
        at = kinematics(p, coordinates[0], np)
        return {"y": at.positions[5], "y_dot": at.velocities[5] * rates[0]}

    return ExudynSystem(mbs, lambda q, v: (q, v), np.eye(1), container, outputs=outputs)


class Kinematics(NamedTuple):
    """The coordinates of `redundant`, and their first and second derivatives by phi."""

    positions: tuple[Any, ...]
    velocities: tuple[Any, ...]
    accelerations: tuple[Any, ...]


def inertias(p: SpeedRegulator) -> tuple[float, ...]:
    """Masses and moments of inertia of the same coordinates."""
    rod = p.rod_mass * p.rod_length**2 / 12
    return (p.flywheel_inertia, p.rod_mass, p.rod_mass, rod, p.slider_mass, p.slider_mass)


def kinematics(p: SpeedRegulator, phi: Any, xp: Any = math) -> Kinematics:
    """Return all coordinates as functions of phi, the loop closed with B below A.

    The height h of A above B is ``l cos theta``; the sine of theta is that of -b.
    """
    r = p.crank_radius
    sin, cos = xp.sin(phi), xp.cos(phi)
    h = xp.sqrt(p.rod_length**2 - r * r * cos * cos)
    h_slope = r * r * sin * cos / h
    h_bend = (r * r * (cos * cos - sin * sin) - h_slope * h_slope) / h
    turn = r * sin / h
    y, slide, slide_bend = r * sin - h, r * cos - h_slope, -r * sin - h_bend
    return Kinematics(
        (phi, r * cos / 2, (r * sin + y) / 2, -xp.atan(r * cos / h), 0.0, y),
        (1.0, -r * sin / 2, (r * cos + slide) / 2, turn, 0.0, slide),
        (
            0.0,
            -r * cos / 2,
            (slide_bend - r * sin) / 2,
            (r * cos - turn * h_slope) / h,
            0.0,
            slide_bend,
        ),
    )


MODELS: Mapping[str, Model] = {
    "redundant": model_of("speed_regulator", MJCF["connect"], build_plane),
    "one_dof": Model(
        one_dof,
        constrained=False,
        unplaceable_reason=lambda p: (
            "one_dof has no place in the world: an angle and our equation are all of it"
        ),
    ),
}
"""Models by name, default first: the one whose mechanics are Exudyn's."""

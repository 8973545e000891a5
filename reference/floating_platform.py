r"""floating_platform: the platform of `rotor_pendulum` afloat, with a rotor and a pendulum.

::

                 e_1 (z of the platform)      o m_3      q: from the frame of the platform
                  |    o m_1               l /              to that of the world
              h --O---' r                   / B = beta + theta
                  |                        /
        .---------+------------- a -------O  e_3 = (0, -sin tau, cos tau)
        | platform: m, c, J               |  torsion spring k, damper d
        '---------------------------------'  x: its point O_0 in the world

Source: a textbook example on the mechanism of Fang, Hou, Nan, Yu (2015), J. Vibroengineering 17(5),
whose platform slides on a sprung guide in a plane; nothing holds it here. The equations are those
of `.body.floating`, with two hinges side by side on the platform. Rotor and pendulum are bodies of
revolution about the axes of their hinges, and the torques are

    tau_1 = k_e (omega_s - phi')  of the motor,    tau_3 = -k theta - d theta'.
"""

from __future__ import annotations

from collections import namedtuple
from dataclasses import dataclass
from typing import Any

import numpy as np

from .body.floating import BASE_NUMBERS, FloatingTree, Link, base_numbers
from .body.floating_scene import floating_scene
from .body.rotation import BodyParameters
from .parameters import quantity
from .rotor_pendulum import SCENE as ROTOR_PENDULUM
from .scene import Array, case_maker


@dataclass(frozen=True)
class FloatingPlatform(BodyParameters):
    """Parameters of `floating_platform` (SI units)."""

    rotor_mass: float = quantity(0.4, "m_1", "kg", "chosen", "of the rotor")
    eccentricity: float = quantity(0.03, "r", "m", "chosen", "of the rotor's mass", "non-negative")
    polar_moment: float = quantity(4e-4, "I_1", "kg m^2", "chosen", "of the rotor, about its axis")
    depth_moment: float = quantity(
        5e-5, "Z_1", "kg m^2", "chosen", "sum of the rotor's m z^2 along its axis", "non-negative"
    )
    rotor_height: float = quantity(0.05, "h", "m", "chosen", "of the rotor over the point", "any")
    rod_mass: float = quantity(0.3, "m_3", "kg", "chosen", "at the end of the rod")
    rod_length: float = quantity(0.12, "l", "m", "chosen", "of the rod", "non-negative")
    rod_moment: float = quantity(2e-4, "I_3", "kg m^2", "chosen", "of its mass, about any axis")
    rod_place: float = quantity(0.1, "a", "m", "chosen", "of the rod's hinge along x", "any")
    tilt: float = quantity(0.6, "tau", "rad", "chosen", "of the rod's hinge about x", "any")
    installation_angle: float = quantity(0.5, "beta", "rad", "chosen", "rod, spring relaxed", "any")
    rod_stiffness: float = quantity(4.0, "k", "N m/rad", "chosen", "torsion spring", "non-negative")
    rod_damping: float = quantity(
        0.004, "d", "N m s/rad", "chosen", "torsion damper", "non-negative"
    )
    motor_slope: float = quantity(
        0.01, "k_e", "N m s/rad", "chosen", "motor's torque per slip", "non-negative"
    )
    synchronous_speed: float = quantity(60.0, "omega_s", "rad/s", "chosen", "at no torque", "any")

    @property
    def cross_moment(self) -> Any:
        """The moment of the rotor across its axis [kg m^2], that of a flat disc and more."""
        return self.polar_moment / 2 + self.depth_moment


NUMBERS = (
    *BASE_NUMBERS,
    *("rotor", "eccentricity", "polar", "crosswise", "height"),
    *("rod", "length", "moment", "place", "axis_y", "axis_z"),
    *("beta", "stiffness", "damping", "slope", "speed"),
)

Coefficients: Any = namedtuple("Coefficients", NUMBERS)  # type: ignore[misc]
"""Numbers of (1)-(4): those of `base_numbers`, then rotor, rod, spring, damper and motor."""


def coefficients(p: FloatingPlatform, tensor: Array | None = None) -> Any:
    """Return the numbers of the equations; the inertia tensor (3, 3, ...) may be another."""
    rotor = [p.rotor_mass, p.eccentricity, p.polar_moment, p.cross_moment, p.rotor_height]
    rod = [p.rod_mass, p.rod_length, p.rod_moment, p.rod_place, -np.sin(p.tilt), np.cos(p.tilt)]
    others = [p.installation_angle, p.rod_stiffness, p.rod_damping]
    others += [p.motor_slope, p.synchronous_speed]
    base = base_numbers(p, tensor, p.rotor_mass + p.rod_mass)
    return Coefficients(*base, *rotor, *rod, *others)


def links(q: Any, c: Any, xp: Any = np) -> list[Link]:
    """Return rotor and pendulum."""
    cos, sin = (c.eccentricity * one(q[3]) for one in (xp.cos, xp.sin))
    up, y, z = [0, 0, 1], c.axis_y, c.axis_z
    rotor = Link(0, c.rotor, c.polar, c.crosswise, up, up, [0, 0, c.height], [cos, sin, 0])
    cos, sin = (c.length * one(c.beta + q[4]) for one in (xp.cos, xp.sin))
    arm = [cos, sin * z, -sin * y]
    tilted = [0, y, z]
    return [rotor, Link(0, c.rod, c.moment, c.moment, tilted, tilted, [c.place, 0, 0], arm)]


def torques(q: Any, v: Any, c: Any) -> list[Any]:
    """Return those of the motor, and of spring and damper of the rod."""
    return [c.slope * (c.speed - v[3]), -c.stiffness * q[4] - c.damping * v[4]]


def strain(q: Any, c: Any) -> Any:
    """Return the energy of the spring [J]."""
    return c.stiffness * q[4] ** 2 / 2


TREE = FloatingTree("platform", links, torques, strain)


def damping_matrix(c: Any) -> Array:
    """Return diag(0, 0, 0, 0, d, 0, 0, 0, 0): the motor is no joint damping."""
    return np.diag([*[0.0] * 4, c.damping, *[0.0] * 4])


def powers(u: Any, q: Any, v: Any, c: Any) -> dict[str, Any]:
    """Return the powers [W] of the motor and of the rod's damper."""
    return {"motor": torques(q, v, c)[0] * v[3], "damper": -c.damping * v[4] ** 2}


DRIVEN = FloatingPlatform()
CONSERVATIVE = DRIVEN.replace(motor_slope=0.0, rod_damping=0.0)
FALLING = CONSERVATIVE.replace(gravity_x=3.0, gravity_y=-5.0, gravity_z=-7.0)
PLANAR = DRIVEN.replace(
    centre_z=0.0, axes_x=0.0, axes_y=0.0, axes_z=0.0, rotor_height=0.0, tilt=0.0
)
"""All axes along z and all centres of mass in one plane, which then holds the motion for ever."""

TUMBLING = {
    "x_dot": 0.9, "y_dot": -0.3, "z_dot": 0.5, "phi": 0.7, "theta": 0.3,
    "q_w": 0.9, "q_x": 0.3, "q_y": -0.3, "q_z": 0.1, "phi_dot": 40.0, "theta_dot": -3.0,
    "omega_x": 2.0, "omega_y": -3.0, "omega_z": 4.0,
}  # fmt: skip

IN_PLANE = {"x_dot": 0.4, "y_dot": -0.3, "theta": 0.3, "phi_dot": 40.0, "omega_z": 3.0}


case = case_maker("floating_platform")

CASES = (
    case("tumbling", DRIVEN, TUMBLING, 0.125, "algebra", "trajectory", "energy", methods="best"),
    case("afloat", DRIVEN, {}, 0.5, "frequency", about="afloat"),
    case(
        "conservative", CONSERVATIVE, TUMBLING, 0.5, "order", "trajectory", "energy", full_only=True
    ),
    case("falling", FALLING, TUMBLING, 0.5, "algebra", "energy", full_only=True),
    case("planar", PLANAR, IN_PLANE, 0.5, "trajectory", "order", full_only=True),
)
"""The *energy* check of `tumbling` examines the momenta alone: there are a motor and a damper."""


def keeps_energy(p: FloatingPlatform) -> bool:
    """Return True if the motor is off and the rod undamped."""
    return not np.any(p.motor_slope) and not np.any(p.rod_damping)


def period(p: FloatingPlatform) -> Any:
    """Return the time [s] of a turn of the rotor at the motor's own speed, at most 1 s."""
    return 2 * np.pi / np.maximum(np.abs(p.synchronous_speed), 2 * np.pi)


SCENE = floating_scene(
    TREE,
    coefficients,
    keeps_energy,
    placed=CASES[3],
    name="floating_platform",
    title="platform afloat in space with a rotor and a sprung pendulum",
    paper=ROTOR_PENDULUM.paper,
    parameters=FloatingPlatform,
    coordinates=("phi", "theta"),
    units={"phi": "rad", "theta": "rad"},
    coefficients=coefficients,
    damping_matrix=damping_matrix,
    powers=powers,
    period=period,
    unforced=lambda p: p.replace(motor_slope=0.0),
    cases=CASES,
)

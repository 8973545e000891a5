r"""speed_regulator: a crank driven by a constant torque against a damped slider.

::

               A        O at the origin, OA = r, AB = l, C in the middle of AB
          r  / |        phi of the crank from the x axis
    M_m -> O   |        b of the rod from the y axis: l sin b = r cos phi
      J        C  m_b   B slides on the y axis, at y = r sin phi - l cos b
               |
               | /      lambda = r / l < 1: cos b never vanishes
               B  m
            k /=/ c     spring at rest at y_0

Source: Vlase, Mihalcica, Scutaru (2018), "Determining the Functional Parameters of a Simple
Speed Regulator", equations (1)-(21). One degree of freedom,
``J(phi) phi'' + J'(phi)/2 phi'^2 = M_m - y_phi (c y_phi phi' + k (y - y_0))``, which is (17)
with the ``J' = 2 A_1^T m A_2`` that (18) lacks the 2 of.

With ``h = l cos b = sqrt(l^2 - r^2 + r^2 sin^2 phi)``, in which nothing is subtracted that
nearly cancels, ``y_phi = -r y cos(phi) / h``. The homogeneous rod, J_C = m_b l^2 / 12, has the
kinetic energy ``m_b/6 (v_A^2 + v_A v_B + v_B^2)`` of its ends' velocities.

The paper has no gravity. A gravity g, 0 by default, has the potential -m_b g C - m g_y y; the crank
with its flywheel is balanced about O.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..errors import ParameterError
from ..parameters import Parameters, gravity, quantity
from ..scene import Array, with_rates


@dataclass(frozen=True)
class SpeedRegulator(Parameters):
    """Parameters of `speed_regulator` (SI units).

    The paper gives 0.000204, the mean of t^2 sin^2 beta, which is that of lambda = 0.2; c = 2, 3, 4
    and the speed 5.07 rad/s. They fix M_m / (c l^2); the other values are a choice.
    """

    crank_radius: float = quantity(0.25, "r", "m", "derived: 0.000204", "O to A")
    rod_length: float = quantity(1.25, "l", "m", "chosen", "A to B")
    flywheel_inertia: float = quantity(2.0, "J", "kg m^2", "chosen", "crank and flywheel about O")
    rod_mass: float = quantity(0.5, "m_b", "kg", "chosen", "homogeneous rod", "non-negative")
    slider_mass: float = quantity(1.0, "m", "kg", "chosen", "slider", "non-negative")
    stiffness: float = quantity(32.0, "k", "N/m", "chosen", "spring of the slider", "non-negative")
    damping: float = quantity(
        2.0, "c", "N s/m", "figure 5: 2, 3, 4", "damper of the slider", "non-negative"
    )
    torque: float = quantity(
        0.32, "M_m", "N m", "calibrated: 5.07 rad/s", "constant motor torque", "any"
    )
    spring_rest: float = quantity(-1.25, "y_0", "m", "derived: (19), -l", "slider at rest", "any")
    gravity_x: float = gravity("x", "across the slide")
    gravity_y: float = gravity("y", "along the slide")

    def validate(self) -> None:
        """Refuse a rod no longer than the crank.

        Raises
        ------
        ParameterError
        """
        ratio = np.max(np.asarray(self.crank_radius) / self.rod_length)
        if ratio >= 1:
            raise ParameterError(
                f"lambda = crank_radius / rod_length must be less than 1, not {ratio:.6g}: the "
                f"crank could not turn; shorten crank_radius or lengthen rod_length"
            )


class Coefficients(NamedTuple):
    """Coefficients of (17), SI units; the two lumped masses stand for the homogeneous rod.

    Attributes
    ----------
    gap : float or array
        l^2 - r^2.
    inertia : float or array
        J + m_b r^2 / 3.
    coupling : float or array
        m_b r / 6.
    mass : float or array
        m + m_b / 3.
    """

    radius: Any
    length: Any
    gap: Any
    inertia: Any
    coupling: Any
    mass: Any
    rod_mass: Any
    rod_inertia: Any
    slider_mass: Any
    stiffness: Any
    damping: Any
    torque: Any
    rest: Any
    gravity_x: Any
    gravity_y: Any


def coefficients(p: SpeedRegulator) -> Coefficients:
    """Coefficients of (13) and (17) from the parameters."""
    r, l = p.crank_radius, p.rod_length
    return Coefficients(
        radius=r,
        length=l,
        gap=(l - r) * (l + r),
        inertia=p.flywheel_inertia + p.rod_mass * r**2 / 3,
        coupling=p.rod_mass * r / 6,
        mass=p.slider_mass + p.rod_mass / 3,
        rod_mass=p.rod_mass,
        rod_inertia=p.rod_mass * l**2 / 12,
        slider_mass=p.slider_mass,
        stiffness=p.stiffness,
        damping=p.damping,
        torque=p.torque,
        rest=p.spring_rest,
        gravity_x=p.gravity_x,
        gravity_y=p.gravity_y,
    )


class Position(NamedTuple):
    """The mechanism at one phi: h = l cos b, the slider's y and its derivatives by phi."""

    sin: Any
    cos: Any
    h: Any
    y: Any
    y_phi: Any
    y_phi_phi: Any


def position(phi: Any, c: Coefficients, xp: Any = np) -> Position:
    """Solve the loop (3), (4) on its branch cos b > 0, with the derivatives (11), (12)."""
    r, sin, cos = c.radius, xp.sin(phi), xp.cos(phi)
    h = xp.sqrt(c.gap + r * r * sin * sin)
    y = r * sin - h
    y_phi = -r * y * cos / h
    y_phi_phi = (r * y * sin - y_phi * (r * cos + r * r * sin * cos / h)) / h
    return Position(sin, cos, h, y, y_phi, y_phi_phi)


def inertia(at: Position, c: Coefficients) -> Any:
    """Return J(phi) of (18) [kg m^2]."""
    return c.inertia + 2 * c.coupling * at.cos * at.y_phi + c.mass * at.y_phi * at.y_phi


def inertia_slope(at: Position, c: Coefficients) -> Any:
    """Return dJ/dphi [kg m^2], which is twice what (18) prints."""
    coupled = at.cos * at.y_phi_phi - at.sin * at.y_phi
    return 2 * (c.coupling * coupled + c.mass * at.y_phi * at.y_phi_phi)


def mass_matrix(q: Any, c: Coefficients, xp: Any = np) -> list[list[Any]]:
    """J(phi) of (18)."""
    return [[inertia(position(q[0], c, xp), c)]]


def forces(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> list[Any]:
    """Right-hand side of (17): the torque (19), damper kept, less J' phi'^2 / 2."""
    return [_forces(position(q[0], c, xp), v[0], c)]


def _forces(at: Position, speed: Any, c: Coefficients) -> Any:
    slider = c.damping * at.y_phi * speed + c.stiffness * (at.y - c.rest)
    inertial = inertia_slope(at, c) * speed * speed / 2
    return c.torque - at.y_phi * slider - inertial + weight_torque(at, c)


def weight_torque(at: Position, c: Coefficients) -> Any:
    """Return the torque of the weights of rod and slider on the crank [N m]."""
    rod = c.gravity_y * (c.radius * at.cos + at.y_phi) - c.gravity_x * c.radius * at.sin
    return c.rod_mass / 2 * rod + c.slider_mass * c.gravity_y * at.y_phi


def accelerations(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> list[Any]:
    """Equation (17) solved for the acceleration."""
    at = position(q[0], c, xp)
    return [_forces(at, v[0], c) / inertia(at, c)]


def damping_matrix(c: Coefficients) -> Array:
    """Zero: the damper acts on the slider, c y_phi^2 on phi is no constant."""
    return np.zeros((1, 1))


def energy(q: Any, v: Any, c: Coefficients) -> Any:
    """Kinetic energy plus that of spring and gravity [J]; the motor's torque is a power."""
    at = position(q[0], c)
    inner = (inertia(at, c) * v[0] ** 2 + c.stiffness * (at.y - c.rest) ** 2) / 2
    rod = c.gravity_x * c.radius * at.cos + c.gravity_y * (c.radius * at.sin + at.y)
    return inner - (c.rod_mass / 2 * rod + c.slider_mass * c.gravity_y * at.y)


def powers(u: Any, q: Any, v: Any, c: Coefficients) -> dict[str, Any]:
    """Powers [W] of the motor and of the damper."""
    slider_speed = position(q[0], c).y_phi * v[0]
    return {"motor": c.torque * v[0], "damper": -c.damping * slider_speed**2}


def outputs(q: Any, v: Any, c: Coefficients, xp: Any = np) -> dict[str, Any]:
    """Slider, rod, and the reactions of (13).

    ``reaction_a`` acts on the crank at A, its opposite on the rod; ``reaction_b`` acts on
    the rod at B, its opposite on the slider, whose guide takes the x component. ``rod_angle``
    is b, so that the rod turns with omega_2 = -b' (1).
    """
    at = position(q[0], c, xp)
    r, l, speed = c.radius, c.length, v[0]
    acceleration = _forces(at, speed, c) / inertia(at, c)
    sin_b, cos_b = r * at.cos / l, at.h / l
    turn = r * at.sin / at.h  # t of (7); u of (10) is its derivative
    turn_slope = r * at.cos / at.h - turn * turn * sin_b / cos_b
    y_ddot = at.y_phi * acceleration + at.y_phi_phi * speed * speed
    rod_x_ddot = -r / 2 * (at.sin * acceleration + at.cos * speed * speed)
    rod_y_ddot = (r * (at.cos * acceleration - at.sin * speed * speed) + y_ddot) / 2
    rod_spin = turn * acceleration + turn_slope * speed * speed
    y_dot = at.y_phi * speed
    load = c.damping * y_dot + c.stiffness * (at.y - c.rest)
    b_y = -load - c.slider_mass * (y_ddot - c.gravity_y)
    a_y = b_y - c.rod_mass * (rod_y_ddot - c.gravity_y)
    sideways = c.rod_mass * (rod_x_ddot - c.gravity_x)
    both_x = (2 * c.rod_inertia * rod_spin / l + sin_b * (a_y + b_y)) / cos_b
    return {
        "y": at.y,
        "y_dot": y_dot,
        "rod_angle": xp.atan(sin_b / cos_b),
        "rod_angle_dot": -turn * speed,
        "rod_x": r * at.cos / 2,
        "rod_y": (r * at.sin + at.y) / 2,
        "rod_x_dot": -r * at.sin * speed / 2,
        "rod_y_dot": (r * at.cos * speed + y_dot) / 2,
        "cos_b": cos_b,
        "reaction_a_x": (both_x - sideways) / 2,
        "reaction_a_y": a_y,
        "reaction_b_x": (both_x + sideways) / 2,
        "reaction_b_y": b_y,
    }


UNITS = with_rates(phi="rad", y="m", rod_angle="rad", rod_x="m", rod_y="m") | {
    "cos_b": "1",
    "reaction_a_x": "N",
    "reaction_a_y": "N",
    "reaction_b_x": "N",
    "reaction_b_y": "N",
}


def assembled(values: Mapping[str, Any], p: SpeedRegulator) -> Any:
    """Whether cos b > 0: the slider is below the crank pin."""
    height = p.crank_radius * np.sin(values["phi"]) - values["y"]
    return np.asarray(height / p.rod_length) > 0

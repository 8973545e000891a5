r"""rotating_beam: a hub with a flexible beam and a concentrated mass, in a horizontal plane.

::

            y                 theta of the hub frame x, y; O its axis, clamp at x = a
            |     __.--o  m   psi(s) the beam's angle in that frame, psi(0) = 0
      ( O )-+--.-'            d / L the mass's place, 1 at the tip
       J_h  a       L  -> x   no gravity

Source: Yang, Wang, Chen, Wu (2016), "Dynamic Modeling and Response of a Rotating Cantilever
Beam with a Concentrated Mass", equations (1)-(23). Four models of one beam, in the hub frame,
lengths over L (the strain energy of all is EI/2 times the squared curvature, and EA/2 times
the squared stretch):

- exact, inextensible: ``x + i y = a + int exp(i psi) ds`` with ``psi = sum b_i P_i(s)`` and the
  curvature psi';
- exact, ``extensible``: ``x + i y = a + int (1 + e) exp(i psi) ds`` with ``e = sum e_j Q_j(s)``
  and the curvature psi' as geometrically exact beams have it, by the unstretched length;
- ``second_order``: the paper's. With ``v' = sum b_i P_i`` and ``u' = sum e_j Q_j``, x = a + s +
  u - int v'^2/2 and y = v, and of the kinetic energy what is of second order in v and u;
- ``zero_order``: the same without the foreshortening int v'^2/2, which loses its stability where
  the hub turns at the first natural frequency of the beam at rest.

Misprints, against Lagrange's equations of the second-order model: (2) has u_xx for u_x; (3)
lacks the hub radius; (4), (5) print gravity; in (14) signs are wrong (theta'' in the row of
B_2, theta'^2 in the term with H); in (16), M_theta_theta lacks J_h, Q_theta lacks tau, U_10
lacks the mass; (12) is no eigenmode as printed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..errors import ParameterError
from ..parameters import Parameters, choice, quantity

DRIVES = ("prescribed", "torque")
SCHEMES = ("A", "B")
ELEMENTS = ("ancf", "geometrically_exact")


MOST_SEGMENTS = 2000
"""Of a model, whose matrices are dense."""


@dataclass(frozen=True)
class RotatingBeam(Parameters):
    """Parameters of `rotating_beam` (SI units); the last three are models' settings.

    The defaults are those of figure 4 without the concentrated mass; the paper gives no
    hub inertia.
    """

    length: float = quantity(8.0, "L", "m", "section 3", "of the beam")
    hub_radius: float = quantity(
        0.0, "a", "m", "figure 4; figures 2, 3: 8 m", "axis to clamp", "non-negative"
    )
    hub_inertia: float = quantity(
        10.0, "J_h", "kg m^2", "chosen", "of the hub about its axis", "non-negative"
    )
    area: float = quantity(7.2968e-5, "A", "m^2", "section 3", "of the cross section")
    second_moment: float = quantity(8.2189e-9, "I", "m^4", "section 3", "of the cross section")
    density: float = quantity(2766.7, "rho", "kg/m^3", "section 3", "of the beam")
    youngs_modulus: float = quantity(6.8952e10, "E", "N/m^2", "section 3", "of the beam")
    mass: float = quantity(
        0.0,
        "m",
        "kg",
        "chosen: none; figure 3 has 0.4, 0.8, 1.2 kg",
        "concentrated mass",
        "non-negative",
    )
    mass_position: float = quantity(1.0, "d/L", "1", "figures 4, 5", "of the mass from the clamp")
    drive: str = choice(DRIVES, "(22), (23)", "the hub's motion, or the torque on it")
    angular_speed: float = quantity(
        10.0, "omega_0", "rad/s", "figure 4", "of the prescribed hub after the ramp", "any"
    )
    ramp_time: float = quantity(
        15.0, "T", "s", "figure 4", "to get there; 0: constant speed from the start", "non-negative"
    )
    torque_amplitude: float = quantity(1.0, "tau_0", "N m", "figure 5", "of the pulse", "any")
    torque_period: float = quantity(10.0, "T", "s", "figure 5", "of the pulse")
    segments: float = quantity(16, "n", "1", "chosen", "of a model: rods or elements")
    scheme: str = choice(
        SCHEMES, "chosen", "of a chain: first hinge at the clamp, or half a rod on"
    )
    element: str = choice(ELEMENTS, "chosen", "of a model of finite elements")

    def validate(self) -> None:
        """Refuse a mass beyond the tip, and segments that cannot be counted.

        Raises
        ------
        ParameterError
        """
        if np.any(np.asarray(self.mass_position) > 1):
            raise ParameterError(
                f"mass_position is d / L and must be at most 1 (the tip), not {self.mass_position}"
            )
        segments = np.asarray(self.segments)
        if np.any(segments != np.round(segments)) or np.any(segments < 2):
            raise ParameterError(
                f"segments must be a whole number, 2 or greater, not {self.segments}"
            )
        if np.any(segments > MOST_SEGMENTS):
            raise ParameterError(
                f"segments must be at most {MOST_SEGMENTS}, not {self.segments:g}: a matrix of so "
                f"many has {8 * float(np.max(segments)) ** 2:.2g} bytes"
            )


class Coefficients(NamedTuple):
    """Coefficients, SI units; lengths over L."""

    length: Any
    hub_ratio: Any
    """a / L"""
    place: Any
    """d / L of the mass; 1 where there is none"""
    hub: Any
    """J_h"""
    beam: Any
    """rho A L^3"""
    point: Any
    """m L^2"""
    bending: Any
    """E I / L"""
    axial: Any
    """E A L"""
    prescribed: Any
    """1 where the hub's motion is prescribed, 0 where a torque drives it"""
    ramp: Any
    """omega_0 / T of (22); 0 without a ramp"""
    ramp_time: Any
    ramp_omega: Any
    torque: Any
    torque_time: Any
    torque_omega: Any


def coefficients(p: RotatingBeam) -> Coefficients:
    """Return the coefficients of the equations of motion."""
    mass = p.density * p.area * p.length
    ramp = np.where(np.asarray(p.ramp_time) > 0, p.ramp_time, np.inf)
    return Coefficients(
        length=p.length,
        hub_ratio=p.hub_radius / p.length,
        place=np.where(np.asarray(p.mass) > 0, p.mass_position, 1.0)[()],
        hub=p.hub_inertia,
        beam=mass * p.length**2,
        point=p.mass * p.length**2,
        bending=p.youngs_modulus * p.second_moment / p.length,
        axial=p.youngs_modulus * p.area * p.length,
        prescribed=float(p.drive == "prescribed"),
        ramp=(p.angular_speed / ramp)[()],
        ramp_time=p.ramp_time,
        ramp_omega=(2 * np.pi / ramp)[()],
        torque=p.torque_amplitude,
        torque_time=p.torque_period,
        torque_omega=2 * np.pi / p.torque_period,
    )


def drive(t: Any, c: Coefficients, xp: Any = np) -> Any:
    """Angular acceleration of the hub by (22) [rad/s^2], or the torque (23) on it [N m].

    Both are zero from their end on; a sine of 2 pi is not, in floating point.
    """
    half = np.sin(c.ramp_omega / 2 * np.minimum(t, c.ramp_time))
    speeding = 2 * c.ramp * half * half  # 1 - cos without its lost digits
    speeding = speeding * (np.real(t) < c.ramp_time)
    torque = c.torque * np.sin(c.torque_omega * np.minimum(t, c.torque_time))
    torque = torque * (np.real(t) < c.torque_time)
    return c.prescribed * speeding + (1 - c.prescribed) * torque


def period(p: RotatingBeam) -> Any:
    """Period [s] of the first bending mode at rest, without the mass."""
    line = p.density * p.area
    bending = p.youngs_modulus * p.second_moment
    return 2 * np.pi / FIRST * np.sqrt(line * np.asarray(p.length) ** 4 / bending)


FIRST = 3.516015268500150
"""1.8751^2 of the cantilever."""


def unforced(p: RotatingBeam) -> RotatingBeam:
    """No torque; a prescribed hub turns at its speed."""
    return p.replace(torque_amplitude=0.0, ramp_time=0.0)


def drive_end_time(p: RotatingBeam) -> Any:
    """End of the ramp or of the pulse [s]."""
    return p.torque_period if p.drive == "torque" else p.ramp_time


def reach(p: RotatingBeam) -> float:
    """Distance [m] of the straight beam's tip from the axis."""
    return float(p.hub_radius + p.length)


def rotation(p: RotatingBeam) -> dict[str, float]:
    """Straight beam that turns with ``angular_speed``."""
    return {"theta_dot": p.angular_speed}


def constrained_initial_values(p: RotatingBeam) -> dict[str, float]:
    """Speed of a hub whose motion is prescribed: 0, or that of the rotation without a ramp."""
    if p.drive == "torque":
        return {}
    return {"theta_dot": p.angular_speed if p.ramp_time == 0 else 0.0}


def steady_speed(number: float) -> float:
    """Speed [rad/s] of the default beam of this dimensionless speed."""
    return float(number * 2 * np.pi / period(RotatingBeam()) / FIRST)

r"""rotating_beam: a hub with a flexible beam and a concentrated mass, in a horizontal plane.

::

            y                 theta of the hub frame x, y; O its axis, clamp at x = a
            |     __.--o  m   psi(s) the beam's angle in that frame, psi(0) = 0
      ( O )-+--.-'            d / L the mass's place, 1 at the tip
       J_h  a       L  -> x

Source: Yang, Wang, Chen, Wu (2016), "Dynamic Modeling and Response of a Rotating Cantilever
Beam with a Concentrated Mass", equations (1)-(23). Four models of one beam, in the hub frame,
lengths over L (the strain energy of all is EI/2 times the squared curvature, and EA/2 times
the squared stretch):

- exact, inextensible: ``x + i y = a + int exp(i psi) ds`` with ``psi = sum b_i P_i(s)`` and the
  curvature psi';
- exact, ``extensible``: ``x + i y = a + int (1 + e) exp(i psi) ds`` with ``e = sum e_j Q_j(s)``
  and the curvature psi' as geometrically exact beams have it, by the unstretched length;
- ``second_order``: the paper's. With ``v' = sum b_i P_i`` and ``u' = sum e_j Q_j``, x = a + s +
  u - int v'^2/2 and y = v, and the kinetic energy to second order in v and u;
- ``zero_order``: the same without the foreshortening int v'^2/2, which loses its stability where
  the hub turns at the first natural frequency of the beam at rest.

The paper's plane is horizontal. A gravity g, 0 by default, lies in the plane; its axes are those of
theta = 0. In the hub frame it is ``g_x' = g_x cos(theta) + g_y sin(theta)`` along x and ``g_y' =
g_y cos(theta) - g_x sin(theta)`` across, and its potential ``-int (g_x' x + g_y' y) dm``, with the
x and y of the model: for small deflections to second order in v and u, so that gravity
along the beam stiffens it, or softens it, by the foreshortening as the rotation does.

Misprints, against Lagrange's equations of the second-order model: (2) has u_xx for u_x; (3)
lacks the hub radius; (4), (5) print gravity; in (14) signs are wrong (theta'' in the row of
B_2, theta'^2 in the term with H); in (16), M_theta_theta lacks J_h, Q_theta lacks tau, U_10
lacks the mass; (12) is no eigenmode as printed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..errors import NoOrbitError, ParameterError
from ..parameters import Parameters, choice, gravity, quantity

DRIVES = ("prescribed", "torque")
SCHEMES = ("A", "B")
ELEMENTS = ("ancf", "geometrically_exact")


MOST_SEGMENTS = 2000
"""Largest number of segments of a model, whose matrices are dense."""


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
    gravity_x: float = gravity("x", "along the beam at theta = 0")
    gravity_y: float = gravity("y", "across it")
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


Invariant = Callable[..., Any]


class Coefficients(NamedTuple):
    """Coefficients, SI units; lengths over L.

    Attributes
    ----------
    hub_ratio : float or array
        a / L.
    place : float or array
        d / L of the mass; 1 where there is none.
    hub : float or array
        J_h.
    beam : float or array
        rho A L^3.
    point : float or array
        m L^2.
    bending : float or array
        E I / L.
    axial : float or array
        E A L.
    prescribed : float or array
        1 where the hub's motion is prescribed, 0 where a torque drives it.
    push : float or array
        omega_0 / T of (22), 0 without a ramp; or tau_0 of (23).
    end : float or array
        T of either.
    drive_omega : float or array
        2 pi / T; 0 without a ramp.
    gravity_x : float or array
        g_x / L.
    """

    length: Any
    hub_ratio: Any
    place: Any
    hub: Any
    beam: Any
    point: Any
    bending: Any
    axial: Any
    prescribed: Any
    push: Any
    end: Any
    drive_omega: Any
    gravity_x: Any
    gravity_y: Any


def coefficients(p: RotatingBeam) -> Coefficients:
    """Return the coefficients of the equations of motion."""
    mass = p.density * p.area * p.length
    end = drive_end_time(p)
    lasts = np.where(np.asarray(end) > 0, end, np.inf)
    push = p.torque_amplitude if p.drive == "torque" else (p.angular_speed / lasts)[()]
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
        push=push,
        end=end,
        drive_omega=(2 * np.pi / lasts)[()],
        gravity_x=p.gravity_x / p.length,
        gravity_y=p.gravity_y / p.length,
    )


def drive(t: Any, c: Coefficients, xp: Any = np) -> Any:
    """Angular acceleration of the hub by (22) [rad/s^2], or the torque (23) on it [N m].

    Both are zero from their end on; a sine of 2 pi is not, in floating point.
    """
    t = np.minimum(t, c.end)
    half = np.sin(c.drive_omega / 2 * t)
    # 1 - cos without its lost digits
    wave = c.prescribed * (2 * half * half) + (1 - c.prescribed) * np.sin(c.drive_omega * t)
    return c.push * wave * (np.real(t) < c.end)


def hub_gravity(theta: Any, c: Coefficients, xp: Any = np) -> tuple[Any, Any]:
    """Gravity over L along and across the axes of the hub [1/s^2]."""
    cos, sin = xp.cos(theta), xp.sin(theta)
    return c.gravity_x * cos + c.gravity_y * sin, c.gravity_y * cos - c.gravity_x * sin


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
    """Straight beam that turns with ``angular_speed``.

    Raises
    ------
    NoOrbitError
        If there is gravity, in which no beam turns steadily.
    """
    if p.has_gravity:
        raise NoOrbitError(
            "in gravity rotating_beam has no steady rotation; it rests hanging (--about hanging)"
        )
    return {"theta_dot": p.angular_speed}


def hanging(p: RotatingBeam) -> dict[str, float]:
    """Straight beam that hangs at rest.

    Raises
    ------
    NoOrbitError
        If there is no gravity, or a prescribed hub turns.
    """
    if not p.has_gravity:
        raise NoOrbitError("without gravity rotating_beam hangs nowhere")
    if p.drive == "prescribed" and p.angular_speed:
        raise NoOrbitError("a hub with an angular_speed does not rest: set it 0, or drive=torque")
    return {"theta": float(np.arctan2(p.gravity_y, p.gravity_x))}


def conserved(p: RotatingBeam, energy: Invariant, momentum: Invariant) -> dict[str, Invariant]:
    """Return the conserved quantities of an undriven beam, from its functions of ``(q, v, c)``.

    Energy, and without gravity the momentum about the axis, of a hub on its own; without gravity
    ``E - theta' H``, the energy in the turning frame [J] with the centrifugal potential, of one
    that keeps its speed.
    """

    def jacobi(q: Any, v: Any, c: Coefficients) -> Any:
        return energy(q, v, c) - v[0] * momentum(q, v, c)

    if p.drive == "prescribed":
        return {} if p.has_gravity else {"jacobi": jacobi}
    return {"energy": energy} if p.has_gravity else {"energy": energy, "momentum": momentum}


EQUILIBRIA = {"rotation": rotation, "hanging": hanging}


def constrained_initial_values(p: RotatingBeam) -> dict[str, float]:
    """Speed of a hub whose motion is prescribed: 0, or that of the rotation without a ramp."""
    if p.drive == "torque":
        return {}
    return {"theta_dot": p.angular_speed if p.ramp_time == 0 else 0.0}


def steady_speed(number: float) -> float:
    """Speed [rad/s] of the default beam of this dimensionless speed."""
    return float(number * 2 * np.pi / period(RotatingBeam()) / FIRST)

r"""rotor_pendulum: two unbalanced rotors, one on a sprung platform, one on a pendulum rod.

::

                                          o m        x_1 = x - r cos(phi_1), y_1 = r sin(phi_1)
      |\/\/\/|  k_x                 m_3  / phi_2     x_3 = x + l cos(B),     y_3 = l sin(B)
    --|      |----[ m_0 ]-----------(o)-'            x_2 = x_3 + r cos(phi_2), ...
      |=[ ]==|  f_x  /`o m    l  .-'
                    r phi_1   .-'  B = beta + phi_3 from the x axis; torsion spring k_phi,
              ---> x      o-'      f_phi between platform and rod

Source: Fang, Hou, Nan, Yu (2015), J. Vibroengineering 17(5), equations (7)-(14) and section
5.2, which have no gravity. A gravity g, 0 by default, pulls at all masses.
The geometry is the one that gives the printed kinetic energy (7); phi_1 and phi_2 turn
opposite ways and are absolute angles; rotors and rod are point masses.

The equations are Lagrange's of (7)-(9), nothing dropped. The paper's own (11) puts
``B -> beta`` after deriving, which drops one of two terms of the same order, so that it
does not conserve energy: it is the variant ``reduced``. Its fourth line is printed with
``+ phi_2'^2 sin(phi_2 - beta)``, a sign error that (12) does not repeat.

The motors of (14) are dimensionally broken and friction is not given. They are read as
``k_e (omega_s - w) - f w``: a torque linear in the speed w, less bearing friction, with k_e
and f from the torque and speed that case 1 of section 5.2 settles at. In the paper's equations the
second motor's torque works on the absolute angle phi_2 and leaves the rod alone
(``absolute``); between rod and rotor (``relative``), w is phi_2' - phi_3' and the rod bears the
reaction.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from ..errors import NoOrbitError
from ..parameters import Parameters, choice, gravity, quantity
from ..scene import Array

PLACEMENTS = ("absolute", "relative")


@dataclass(frozen=True)
class RotorPendulum(Parameters):
    """Parameters of `rotor_pendulum` (SI units); defaults from table 1 and case 1 of section 5.2.

    The printed frequency ratios do not belong to the printed stiffnesses; the stiffnesses
    reproduce the paper's runs.
    """

    platform_mass: float = quantity(100.0, "m_0", "kg", "table 1", "sprung platform")
    rotor_mass: float = quantity(2.0, "m", "kg", "table 1", "each rotor's unbalanced mass")
    rod_mass: float = quantity(10.0, "m_3", "kg", "table 1", "at the end of the pendulum rod")
    eccentricity: float = quantity(0.05, "r", "m", "table 1", "rotor axis to its mass")
    rod_length: float = quantity(0.3, "l", "m", "table 1", "hinge to the second rotor's axis")
    platform_stiffness: float = quantity(
        9859600.0, "k_x", "N/m", "section 5.2, 1)", "platform spring", "non-negative"
    )
    platform_damping: float = quantity(
        1064.0, "f_x", "N s/m", "table 1", "platform damper", "non-negative"
    )
    rod_stiffness: float = quantity(
        976100.0, "k_phi", "N m/rad", "section 5.2, 1)", "torsion spring", "non-negative"
    )
    rod_damping: float = quantity(
        15.0, "f_phi", "N m s/rad", "table 1", "torsion damper", "non-negative"
    )
    installation_angle: float = quantity(
        np.pi / 6, "beta", "rad", "section 5.2", "rod from the x axis, spring relaxed", "any"
    )
    motor_slope: float = quantity(
        0.94, "k_e", "N m s/rad", "calibrated: case 1's torque", "torque per slip", "non-negative"
    )
    synchronous_speed: float = quantity(
        50 * np.pi, "omega_s", "rad/s", "chosen: 50 Hz, 2 pole pairs", "motor's speed at no torque"
    )
    friction: float = quantity(
        0.02,
        "f",
        "N m s/rad",
        "calibrated: case 1's speed",
        "of each rotor's bearing",
        "non-negative",
    )
    gravity_x: float = gravity("x", "along the slide")
    gravity_y: float = gravity("y", "across the slide")
    motor_placement: str = choice(PLACEMENTS, "(11)", "what the second motor turns against")


class Coefficients(NamedTuple):
    """Parameters under short names, the words as numbers; ``relative`` is 0 or 1."""

    platform: Any
    rotor: Any
    rod: Any
    eccentricity: Any
    length: Any
    stiffness: Any
    damping: Any
    rod_stiffness: Any
    rod_damping: Any
    beta: Any
    slope: Any
    speed: Any
    friction: Any
    gravity_x: Any
    gravity_y: Any
    relative: Any

    @property
    def mass(self) -> Any:
        """M, all that moves with x [kg]."""
        return self.platform + self.rod + 2 * self.rotor

    @property
    def unbalance(self) -> Any:
        """Unbalance m r [kg m]."""
        return self.rotor * self.eccentricity

    @property
    def end_mass(self) -> Any:
        """Mass at the rod's end, m + m_3 [kg]."""
        return self.rotor + self.rod

    @property
    def loss(self) -> Any:
        """Torque lost per speed, k_e + f [N m s/rad]."""
        return self.slope + self.friction


def coefficients(p: RotorPendulum) -> Coefficients:
    """Return the parameters as they stand in the equations."""
    *numbers, placement = (getattr(p, name) for name in p.names())
    return Coefficients._make([*numbers, float(PLACEMENTS.index(placement))])


def motor_rates(v: Any, c: Coefficients) -> tuple[Any, Any]:
    """Speeds [rad/s] that the motors and bearings see."""
    return v[1], v[2] - c.relative * v[3]


def mass_matrix(q: Any, c: Coefficients, xp: Any = np, rod: Any = None) -> list[list[Any]]:
    """Mass matrix of Lagrange's equations of (7), q = (x, phi_1, phi_2, phi_3).

    ``rod`` is the rod's angle B, by default beta + phi_3.
    """
    rod = c.beta + q[3] if rod is None else rod
    inertia = c.unbalance * c.eccentricity
    first = c.unbalance * xp.sin(q[1])
    second = -c.unbalance * xp.sin(q[2])
    lift = -c.end_mass * c.length * xp.sin(rod)
    coupling = c.unbalance * c.length * xp.cos(q[2] - rod)
    return [
        [c.mass, first, second, lift],
        [first, inertia, 0.0, 0.0],
        [second, 0.0, inertia, coupling],
        [lift, 0.0, coupling, c.end_mass * c.length**2],
    ]


def forces(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np, rod: Any = None) -> list[Any]:
    """Right-hand side of ``M(q) a = f``; the motors' torques stand in it."""
    rod = c.beta + q[3] if rod is None else rod
    first, second, reaction = _torques(v, c)
    swing = c.unbalance * c.length * xp.sin(q[2] - rod)
    rotors = xp.cos(q[2]) * v[2] * v[2] - xp.cos(q[1]) * v[1] * v[1]
    weight_x, weight_1, weight_2, weight_3 = _weights(q, rod, c, xp)
    return [
        c.unbalance * rotors
        + c.end_mass * c.length * xp.cos(rod) * v[3] * v[3]
        - c.damping * v[0]
        - c.stiffness * q[0]
        + weight_x,
        first + weight_1,
        second - swing * v[3] * v[3] + weight_2,
        swing * v[2] * v[2] - c.rod_damping * v[3] - c.rod_stiffness * q[3] - reaction + weight_3,
    ]


def _weights(q: Any, rod: Any, c: Coefficients, xp: Any) -> tuple[Any, Any, Any, Any]:
    """Generalised forces of gravity."""
    return (
        c.mass * c.gravity_x,
        c.unbalance * (c.gravity_x * xp.sin(q[1]) + c.gravity_y * xp.cos(q[1])),
        c.unbalance * (c.gravity_y * xp.cos(q[2]) - c.gravity_x * xp.sin(q[2])),
        c.end_mass * c.length * (c.gravity_y * xp.cos(rod) - c.gravity_x * xp.sin(rod)),
    )


def _torques(v: Any, c: Coefficients) -> tuple[Any, Any, Any]:
    """Torques of motor and bearing on phi_1, phi_2, and what the rod bears of the second."""
    first, second = (c.slope * c.speed - c.loss * rate for rate in motor_rates(v, c))
    return first, second, c.relative * second


def accelerations(
    u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np, rod: Any = None
) -> list[Any]:
    """Lagrange's equations of (7)-(9) solved for the accelerations.

    Solve for x'' and phi_3'' with the rotors eliminated, then for the rotors. A rotor on its
    bearing acts by its torque over r and by the part of its mass that lies along its arm. The
    2 x 2 mass matrix and its determinant are sums of squares, so that no digits are lost where the
    rotors are far heavier than platform and rod.
    """
    rod = c.beta + q[3] if rod is None else rod
    m, m_3, r, l = c.rotor, c.rod, c.eccentricity, c.length
    cos_1, sin_1, cos_2, sin_2 = xp.cos(q[1]), xp.sin(q[1]), xp.cos(q[2]), xp.sin(q[2])
    cos_rod, sin_rod = xp.cos(rod), xp.sin(rod)
    cos_arm, sin_arm = xp.cos(q[2] - rod), xp.sin(q[2] - rod)
    spin_1, spin_2, swing = v[1] * v[1], v[2] * v[2], v[3] * v[3]
    first, second, reaction = _torques(v, c)
    g_x, g_y = c.gravity_x, c.gravity_y
    along_1, along_2 = g_x * cos_1 - g_y * sin_1, g_x * cos_2 + g_y * sin_2

    m_xx = c.platform + m_3 + m * (cos_1 * cos_1 + cos_2 * cos_2)
    m_x3 = m * cos_2 * sin_arm - m_3 * sin_rod  # over l
    m_33 = m_3 + m * sin_arm * sin_arm  # over l^2
    determinant = (c.platform + m * cos_1 * cos_1) * m_33 + m_3 * c.end_mass * cos_rod * cos_rod
    f_x = (
        (sin_2 * second - sin_1 * first) / r
        + m * r * (cos_2 * spin_2 - cos_1 * spin_1)
        + l * (m_3 * cos_rod + m * cos_2 * cos_arm) * swing
        - c.damping * v[0]
        - c.stiffness * q[0]
        + ((c.platform + m_3) * g_x + m * (cos_1 * along_1 + cos_2 * along_2))
    )
    f_3 = (
        m * sin_arm * (r * spin_2 + l * cos_arm * swing)
        - cos_arm / r * second
        - (c.rod_damping * v[3] + c.rod_stiffness * q[3] + reaction) / l
        + (m_3 * (g_y * cos_rod - g_x * sin_rod) + m * sin_arm * along_2)
    )  # over l
    a_x = (m_33 * f_x - m_x3 * f_3) / determinant
    a_3 = (m_xx * f_3 - m_x3 * f_x) / (l * determinant)
    return [
        a_x,
        (first / (m * r) - sin_1 * a_x + (g_x * sin_1 + g_y * cos_1)) / r,
        (
            second / (m * r)
            + sin_2 * a_x
            - l * (cos_arm * a_3 + sin_arm * swing)
            + (g_y * cos_2 - g_x * sin_2)
        )
        / r,
        a_3,
    ]


def damping_matrix(c: Coefficients) -> Array:
    """Dampers of platform and rod; motors and bearings are no joint damping."""
    return np.diag([c.damping, 0.0, 0.0, c.rod_damping])


def energy(q: Any, v: Any, c: Coefficients) -> Any:
    """Kinetic energy (7) plus potential energy (8) and that of gravity [J]."""
    kinetic = sum(
        v[i] * v[j] * entry
        for i, row in enumerate(mass_matrix(q, c))
        for j, entry in enumerate(row)
    )
    inner = (kinetic + c.stiffness * q[0] ** 2 + c.rod_stiffness * q[3] ** 2) / 2
    rod, arm, lever = c.beta + q[3], c.unbalance, c.end_mass * c.length
    moment_x = c.mass * q[0] + arm * (np.cos(q[2]) - np.cos(q[1])) + lever * np.cos(rod)
    moment_y = arm * (np.sin(q[1]) + np.sin(q[2])) + lever * np.sin(rod)
    return inner - (c.gravity_x * moment_x + c.gravity_y * moment_y)


def momentum(q: Any, v: Any, c: Coefficients) -> Any:
    """Momentum along x [kg m/s]."""
    return sum(rate * entry for rate, entry in zip(v, mass_matrix(q, c)[0], strict=True))


def powers(u: Any, q: Any, v: Any, c: Coefficients) -> dict[str, Any]:
    """Powers [W] of the motors, their bearings and the two dampers."""
    first, second = motor_rates(v, c)
    return {
        "motor_1": c.slope * (c.speed - first) * first,
        "motor_2": c.slope * (c.speed - second) * second,
        "friction_1": -c.friction * first**2,
        "friction_2": -c.friction * second**2,
        "platform": -c.damping * v[0] ** 2,
        "rod": -c.rod_damping * v[3] ** 2,
    }


def invariants(p: RotorPendulum) -> Mapping[str, Callable[..., Any]]:
    """Energy always; momentum along x where no spring and no weight act on the platform."""
    if np.any(p.platform_stiffness) or np.any(p.gravity_x):
        return {"energy": energy}
    return {"energy": energy, "momentum": momentum}


def rest(name: str, p: RotorPendulum) -> dict[str, float]:
    """Return the state of rest of this name: with gravity the rotors hang, and the springs give.

    Raises
    ------
    NoOrbitError
        If gravity keeps rotors from turning steadily, or no spring holds the platform.
    """
    if not p.has_gravity:
        return {}
    if name != "rest":
        raise NoOrbitError("no rotor of rotor_pendulum turns steadily in gravity")
    if p.gravity_x and not p.platform_stiffness:
        raise NoOrbitError("no spring holds the platform of rotor_pendulum against its weight")
    c, down = coefficients(p), float(np.arctan2(p.gravity_y, p.gravity_x))
    lever = c.end_mass * c.length
    most = lever * float(np.hypot(p.gravity_x, p.gravity_y))

    def unbalanced(swing: float) -> float:
        return float(c.rod_stiffness * swing - most * np.sin(down - c.beta - swing))

    # between the relaxed spring and the rod that hangs, their torques balance
    hangs = (down - c.beta + np.pi) % (2 * np.pi) - np.pi
    rounding = 4 * np.finfo(float).eps * most
    is_upright = bool(p.rod_stiffness) and abs(unbalanced(0.0)) <= rounding
    swing = 0.0 if is_upright else hangs
    if c.rod_stiffness * abs(hangs) > rounding and not is_upright:  # else the rod hangs
        swing = brentq(unbalanced, min(0.0, hangs), max(0.0, hangs), xtol=1e-15)
    return {
        "x": float(c.mass * p.gravity_x / p.platform_stiffness) if p.gravity_x else 0.0,
        "phi_1": float(np.arctan2(p.gravity_y, -p.gravity_x)),
        "phi_2": down,
        "phi_3": float(swing),
    }


def unforced(p: RotorPendulum) -> RotorPendulum:
    """Motors and bearing friction off."""
    return p.replace(motor_slope=0.0, friction=0.0)


def operating_speed(p: RotorPendulum) -> Any:
    """Speed [rad/s] at which motor and bearing balance; the motor's own where it is off."""
    share = np.divide(
        p.motor_slope,
        p.motor_slope + np.asarray(p.friction),
        where=np.asarray(p.motor_slope) > 0,
        out=np.ones(np.broadcast_shapes(np.shape(p.motor_slope), np.shape(p.friction))),
    )
    return p.synchronous_speed * share


def period(p: RotorPendulum) -> Any:
    """Guess of a turn's time [s]: the dampers slow the rotors down a little more."""
    return 2 * np.pi / operating_speed(p)

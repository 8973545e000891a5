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
whose platform slides on a sprung guide in a plane; nothing holds it here. Featherstone, *Rigid Body
Dynamics Algorithms* (2008), chapter 9, calls it a floating base.

A hinge k = 1, 3 is at p_k on the platform and turns about the unit axis e_k by phi or theta. The
centre of mass of its body, m_k, is off the hinge by rho_k across the axis; I_k is its tensor about
it, of a body of revolution about e_k, and t_k = e_k x rho_k. In the frame of the platform, whose
angular velocity is omega, d_i is the place of the centre of mass of body i = 0, 1, 3 from that of
all, and J their tensor about that. With beta_k = 2 phi_k' omega x t_k - phi_k'^2 rho_k and its mean
b = (m_1 beta_1 + m_3 beta_3) / M

    J omega' + sum phi_k'' (m_k d_k x t_k + I_k e_k)
        = -omega x (I_0 omega) - sum N_k - sum m_i d_i x (omega x (omega x d_i) + beta_i)    (1)
    (m_k d_k x t_k + I_k e_k) . omega' + (m_k rho_k^2 + I_k) phi_k''
        - m_k t_k . sum phi_l'' m_l t_l / M
        = tau_k - e_k . N_k - m_k t_k . (omega x (omega x d_k) + beta_k - b)                 (2)
    N_k = phi_k' I_k (omega x e_k) + w_k x (I_k w_k),    w_k = omega + phi_k' e_k
    x'' = g - R (omega' x r + omega x (omega x r) + sum m_k t_k phi_k'' / M + b)             (3)
    q' = q (0, omega) / 2                                                                    (4)

where r is the place of the centre of mass of all from the platform's point, and tau_1 = k_e
(omega_s - phi') of the motor and tau_3 = -k theta - d theta' act between bodies: no torque at a
hinge changes the momenta of the whole. The velocity x' stands nowhere: that is Galileo's principle.
The quaternion may have any length, see `..body.rotation`; without motor and damper these are
Lagrange's equations, whose mass matrix is that about the platform's point.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..body.parameters import BodyParameters, body_inertia, body_numbers, central_inertia
from ..body.rotation import (
    Moment,
    accelerations_by,
    body_rates,
    euler,
    inner,
    into_body,
    rotation_columns,
    sum_of,
    times,
    turned_forces,
    turned_inertia,
)
from ..parameters import quantity
from ..quaternions import cross, matrix, square
from ..scene import Array


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


class Coefficients(NamedTuple):
    """Numbers of (1)-(4): those of `body_numbers` about the platform's centre of mass, then others.

    M, mass and centre of the platform, rotor, rod, spring, damper and motor.
    """

    s_x: Any
    s_y: Any
    s_z: Any
    inertia_xx: Any
    inertia_yy: Any
    inertia_zz: Any
    inertia_xy: Any
    inertia_xz: Any
    inertia_yz: Any
    inverse_xx: Any
    inverse_yy: Any
    inverse_zz: Any
    inverse_xy: Any
    inverse_xz: Any
    inverse_yz: Any
    g_x: Any
    g_y: Any
    g_z: Any
    radial: Any
    mass: Any
    platform: Any
    centre_x: Any
    centre_y: Any
    centre_z: Any
    rotor: Any
    eccentricity: Any
    polar: Any
    crosswise: Any
    height: Any
    rod: Any
    length: Any
    moment: Any
    place: Any
    axis_y: Any
    axis_z: Any
    beta: Any
    stiffness: Any
    damping: Any
    slope: Any
    speed: Any


def coefficients(p: FloatingPlatform) -> Coefficients:
    """Return the numbers of (1)-(4)."""
    return coefficients_of(p, body_inertia(p))


def coefficients_of(p: FloatingPlatform, tensor: Array) -> Coefficients:
    """Return these numbers of an inertia tensor (3, 3, ...) of the platform about its point."""
    central = central_inertia(p) + (tensor - body_inertia(p))  # exact where nothing is changed
    own = [p.mass + p.rotor_mass + p.rod_mass, p.mass, p.centre_x, p.centre_y, p.centre_z]
    rotor = [p.rotor_mass, p.eccentricity, p.polar_moment, p.cross_moment, p.rotor_height]
    rod = [p.rod_mass, p.rod_length, p.rod_moment, p.rod_place, -np.sin(p.tilt), np.cos(p.tilt)]
    others = [p.installation_angle, p.rod_stiffness, p.rod_damping]
    others += [p.motor_slope, p.synchronous_speed]
    still = p.replace(centre_x=0.0, centre_y=0.0, centre_z=0.0)
    return Coefficients(*(body_numbers(still, central) + own + rotor + rod + others))


PLACE = slice(0, 3)
HINGES = slice(3, 5)
FIRST = 5
"""Place of the quaternion among the coordinates."""

TURN = slice(FIRST, FIRST + 4)


class Arm(NamedTuple):
    """A body on a hinge of the platform, in the platform's frame.

    Attributes
    ----------
    mass, polar, crosswise :
        And its moments about the hinge's axis, and across it, about its centre of mass.
    axis, arm, place, lever : lists of 3
        e, rho, r and t = e x rho.
    """

    mass: Any
    polar: Any
    crosswise: Any
    axis: list[Any]
    arm: list[Any]
    place: list[Any]
    lever: list[Any]

    def spread(self, w: Any) -> list[Any]:
        """Return I w."""
        along = (self.polar - self.crosswise) * inner(self.axis, w)
        return [self.crosswise * a + along * b for a, b in zip(w, self.axis, strict=True)]

    def coupling(self, place: list[Any]) -> list[Any]:
        """Return what couples hinge and platform about a point, m d x t + I e."""
        own = [self.polar * part for part in self.axis]
        return sum_of(own, cross(place, self.lever), self.mass)

    @property
    def inertia(self) -> Any:
        """About the hinge."""
        return self.mass * inner(self.arm, self.arm) + self.polar


def arms(q: Any, c: Coefficients, xp: Any = np) -> tuple[Arm, Arm]:
    """Return rotor and pendulum."""
    cos, sin = (c.eccentricity * one(q[3]) for one in (xp.cos, xp.sin))
    rotor = Arm(
        c.rotor, c.polar, c.crosswise,
        [0, 0, 1], [cos, sin, 0], [cos, sin, c.height], [-sin, cos, 0],
    )  # fmt: skip
    cos, sin = (c.length * one(c.beta + q[4]) for one in (xp.cos, xp.sin))
    y, z = c.axis_y, c.axis_z
    rod = Arm(
        c.rod, c.moment, c.moment,
        [0, y, z], [cos, sin * z, -sin * y], [cos + c.place, sin * z, -sin * y],
        [-sin, cos * z, -cos * y],
    )  # fmt: skip
    return rotor, rod


def torques(q: Any, v: Any, c: Coefficients) -> tuple[Any, Any]:
    """Return those of the motor, and of spring and damper of the rod."""
    return c.slope * (c.speed - v[3]), -c.stiffness * q[4] - c.damping * v[4]


def middle(both: tuple[Arm, Arm], c: Coefficients) -> list[Any]:
    """Return r, the centre of mass of all from the platform's point."""
    rotor, rod = both
    return [
        (c.platform * a + rotor.mass * b + rod.mass * d) / c.mass
        for a, b, d in zip(centre(c), rotor.place, rod.place, strict=True)
    ]


def centre(c: Coefficients) -> list[Any]:
    """Return the centre of mass of the platform in its frame."""
    return [c.centre_x, c.centre_y, c.centre_z]


def whole_tensor(both: tuple[Arm, Arm], places: list[list[Any]], c: Coefficients) -> list[Any]:
    """Return xx, yy, zz, xy, xz, yz of the tensor of all, with bodies at places from a point."""
    entries = list(c[3:9])
    for m, (x, y, z) in zip((c.platform, *(one.mass for one in both)), places, strict=True):
        own = [y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z]
        entries = sum_of(entries, own, m)
    for one in both:
        (e, f, g), d, p = one.axis, one.crosswise, one.polar - one.crosswise
        own = [d + p * e * e, d + p * f * f, d + p * g * g, p * e * f, p * e * g, p * f * g]
        entries = sum_of(entries, own)
    return entries


def from_point(both: tuple[Arm, Arm], c: Coefficients) -> list[list[Any]]:
    """Return the centres of mass of platform, rotor and rod from the platform's point."""
    return [centre(c), *(one.place for one in both)]


def from_middle(both: tuple[Arm, Arm], c: Coefficients) -> list[list[Any]]:
    """Return d, the same from the centre of mass of all, by their distances from each other."""
    masses, places = (c.platform, *(one.mass for one in both)), from_point(both, c)
    apart = []
    for here in places:
        away = [0, 0, 0]
        for mass, there in zip(masses, places, strict=True):
            if there is not here:
                away = [d + mass * (a - b) for d, a, b in zip(away, here, there, strict=True)]
        apart.append([d / c.mass for d in away])
    return apart


def mass_matrix(q: Any, c: Coefficients, xp: Any = np) -> list[list[Any]]:
    """Return the mass matrix of (1)-(3) in the coordinates."""
    both, rows, turn = arms(q, c, xp), matrix(q[TURN]), q[TURN]
    moment = [c.mass * part for part in middle(both, c)]
    swings = [[one.mass * inner(row, one.lever) for one in both] for row in rows]
    mixed = [*(cross(moment, row) for row in rows), *(one.coupling(one.place) for one in both)]
    first, second = zip(*swings, strict=True)
    others = [
        *([c.mass if i == j else 0 for j in range(3)] + swings[i] for i in range(3)),
        [*first, both[0].inertia, 0],
        [*second, 0, both[1].inertia],
    ]
    columns, size = rotation_columns(turn), square(turn)
    sides = [[2 * inner(column, one) / size for column in columns] for one in mixed]
    block = turned_inertia(turn, whole_tensor(both, from_point(both, c), c), c.radial)
    return [
        *([*row, *side] for row, side in zip(others, sides, strict=True)),
        *([side[i] for side in sides] + block[i] for i in range(4)),
    ]


class Sides(NamedTuple):
    """What drives (1), (2) beside the masses' motion, in the frame of the platform.

    Attributes
    ----------
    bent : two vectors
        beta, by which bodies on hinges accelerate on the platform where no rate changes.
    hinges : two numbers
        tau - e . N.
    turning : vector
        -omega x (I_0 omega) - sum N.
    """

    bent: tuple[list[Any], list[Any]]
    hinges: list[Any]
    turning: list[Any]


def around(omega: Any, place: Any) -> list[Any]:
    """Return omega x (omega x d)."""
    return cross(omega, cross(omega, place))


def coriolis(one: Arm, omega: Any, rate: Any) -> list[Any]:
    """Return 2 phi' omega x t."""
    return [2 * rate * part for part in cross(omega, one.lever)]


def spun(one: Arm, omega: Any, rate: Any) -> list[Any]:
    """Return N, the rate of a body's spin about its centre of mass where no velocity changes."""
    whole = sum_of(omega, one.axis, rate)
    faster = one.spread(cross(omega, one.axis))
    return sum_of(cross(whole, one.spread(whole)), faster, rate)


def sides_of(both: tuple[Arm, Arm], motion: Any, c: Coefficients, moment: Moment = euler) -> Sides:
    """Return what drives (1), (2), of (q, v, omega)."""
    q, v, omega = motion
    turning = moment(q[TURN], omega, times(c[3:9], omega), c)
    bent, hinges = [], []
    for one, rate, torque in zip(both, v[HINGES], torques(q, v, c), strict=True):
        rest = spun(one, omega, rate)
        bent.append(sum_of(coriolis(one, omega, rate), one.arm, -rate * rate))
        hinges.append(torque - inner(one.axis, rest))
        turning = sum_of(turning, rest, -1.0)
    return Sides((bent[0], bent[1]), hinges, turning)


def forces(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> list[Any]:
    """Return the right-hand side of ``M(q) a = f``."""
    both = arms(q, c, xp)
    rho, omega = body_rates(q[TURN], v[TURN])
    bent, hinges, turning = sides_of(both, (q, v, omega), c)
    pull = into_body(q[TURN], c[15:18])
    masses, push = (c.platform, *(one.mass for one in both)), [0, 0, 0]
    for k, (mass, place) in enumerate(zip(masses, from_point(both, c), strict=True)):
        swing = around(omega, place)
        swing = sum_of(swing, bent[k - 1]) if k else swing
        force = [mass * (a - b) for a, b in zip(pull, swing, strict=True)]
        push, turning = sum_of(push, force), sum_of(turning, cross(place, force))
        if k:
            hinges[k - 1] = hinges[k - 1] + inner(both[k - 1].lever, force)
    moved = [c.mass * part for part in cross(omega, middle(both, c))]
    push = sum_of(push, moved, 2 * rho)
    push_hinges = [
        force + 2 * rho * inner(one.coupling(one.place), omega)
        for force, one in zip(hinges, both, strict=True)
    ]
    momentum = times(whole_tensor(both, from_point(both, c), c), omega)
    rest = turned_forces(q[TURN], v[TURN], turning, momentum, c.radial)
    return [*(inner(row, push) for row in matrix(q[TURN])), *push_hinges, *rest]


def symmetric_solution(rows: list[list[Any]], right: list[Any]) -> list[Any]:
    """Return x of A x = b for a positive definite A, by its upper triangle (Cholesky, L D L^T)."""
    rows, right, n = [list(row) for row in rows], list(right), len(right)
    for k in range(n):
        for i in range(k + 1, n):
            factor = rows[k][i] / rows[k][k]
            for j in range(i, n):
                rows[i][j] = rows[i][j] - factor * rows[k][j]
            right[i] = right[i] - factor * right[k]
    for k in reversed(range(n)):
        for j in range(k + 1, n):
            right[k] = right[k] - rows[k][j] * right[j]
        right[k] = right[k] / rows[k][k]
    return right


def central_accelerations(
    both: tuple[Arm, Arm], sides: Sides, motion: Any, c: Coefficients
) -> list[Any]:
    """Return x'', phi'', theta'' and omega' by (1)-(3), of (q, v, omega)."""
    q, _, omega = motion
    (one, two), (first, second) = both, sides.bent
    apart = from_middle(both, c)
    swings = [around(omega, place) for place in apart]
    bent = [swings[0], sum_of(swings[1], first), sum_of(swings[2], second)]
    turning = sides.turning
    for mass, place, swing in zip((c.platform, one.mass, two.mass), apart, bent, strict=True):
        turning = sum_of(turning, cross(place, swing), -mass)
    shares = one.mass / c.mass, two.mass / c.mass
    mean = [shares[0] * a + shares[1] * b for a, b in zip(first, second, strict=True)]
    right = [
        force - body.mass * (inner(body.lever, swing) - inner(body.lever, mean))
        for force, body, swing in zip(sides.hinges, both, bent[1:], strict=True)
    ]
    others = c.platform + two.mass, c.platform + one.mass
    inertias = [
        body.mass * inner(body.arm, body.arm) * other / c.mass + body.polar
        for body, other in zip(both, others, strict=True)
    ]
    joined = -one.mass * shares[1] * inner(one.lever, two.lever)
    xx, yy, zz, xy, xz, yz = whole_tensor(both, apart, c)
    rows = [
        [inertias[0], joined, *one.coupling(apart[1])],
        [0.0, inertias[1], *two.coupling(apart[2])],
        [0.0, 0.0, xx, xy, xz],
        [0.0, 0.0, 0.0, yy, yz],
        [0.0, 0.0, 0.0, 0.0, zz],
    ]
    a, b, *faster = symmetric_solution(rows, [*right, *turning])
    place = middle(both, c)
    moved = sum_of(sum_of(cross(faster, place), around(omega, place)), mean)
    moved = sum_of(sum_of(moved, one.lever, shares[0] * a), two.lever, shares[1] * b)
    pulled = [g - part for g, part in zip(c[15:18], outward(q, moved), strict=True)]
    return [*pulled, a, b, *faster]


def body_accelerations(
    u: Any, motion: Any, c: Coefficients, moment: Moment, xp: Any = np
) -> list[Any]:
    """Return x'', phi'', theta'' and omega' by (1)-(3)."""
    both = arms(motion[0], c, xp)
    return central_accelerations(both, sides_of(both, motion, c, moment), motion, c)


accelerations = accelerations_by(body_accelerations, FIRST)


def damping_matrix(c: Coefficients) -> Array:
    """Return diag(0, 0, 0, 0, d, 0, 0, 0, 0): the motor is no joint damping."""
    return np.diag([*[0.0] * 4, c.damping, *[0.0] * 4])


def energy(q: Any, v: Any, c: Coefficients) -> Any:
    """Return kinetic and potential energy [J], that of the length of q included."""
    rows = mass_matrix(q, c)
    kinetic = sum(v[i] * v[j] * entry for i, row in enumerate(rows) for j, entry in enumerate(row))
    place = sum_of(q[PLACE], outward(q, middle(arms(q, c), c)))
    return (kinetic + c.stiffness * q[4] ** 2) / 2 - c.mass * inner(c[15:18], place)


def outward(q: Any, vector: Any) -> list[Any]:
    """Return the components in the world of a vector of the platform."""
    return [inner(row, vector) for row in matrix(q[TURN])]


def momentum(q: Any, v: Any, c: Coefficients) -> list[Any]:
    """Return the linear momentum in the world [kg m/s]."""
    both, omega = arms(q, c), body_rates(q[TURN], v[TURN])[1]
    inside = [c.mass * part for part in cross(omega, middle(both, c))]
    for one, rate in zip(both, v[HINGES], strict=True):
        inside = sum_of(inside, one.lever, one.mass * rate)
    return [c.mass * a + b for a, b in zip(v, outward(q, inside), strict=False)]


def angular_momentum(q: Any, v: Any, c: Coefficients) -> list[Any]:
    """Return the angular momentum about the centre of mass of all, in the world [kg m^2/s]."""
    both, omega = arms(q, c), body_rates(q[TURN], v[TURN])[1]
    apart = from_middle(both, c)
    inside = times(whole_tensor(both, apart, c), omega)
    for one, place, rate in zip(both, apart[1:], v[HINGES], strict=True):
        inside = sum_of(inside, one.coupling(place), rate)
    return outward(q, inside)


def powers(u: Any, q: Any, v: Any, c: Coefficients) -> dict[str, Any]:
    """Return the powers [W] of the motor and of the rod's damper."""
    return {"motor": torques(q, v, c)[0] * v[3], "damper": -c.damping * v[4] ** 2}

r"""floating_beam: the hub of `rotating_beam` afloat, with a twisted beam as a chain of rods.

::

        e_1 (z of the hub)      e_2 = z, turned by tau about x    q: from the frame of the hub
         |                       \            e_3                    to that of the world
    .----+----.                   \          __.--o m_t           x: its point O_0 in the world
    |  hub    +-- a --O---- h -----O---- h -'
    | m, c, J |       2k           k          theta_k: of rod k to the one before
    '---------'

Source: a textbook example on the mechanism of Yang, Wang, Chen, Wu (2016), Shock and Vibration
8935247, whose hub turns about a fixed axis; nothing holds it here. The equations are those of
`.body.floating`. The beam is a chain in the scheme A of `.rotating_beam.chain`: three rods of
h = L/3, with torsion springs k = EI/h in their hinges, of 2k at the clamp. A rod of mass m has
m h^2/12 + I_r/2 across its length and I_r about it, the last one a point mass at its end as well.
The axis of a hinge is that of the hinge before it turned by tau about the rod between them: with
tau = 0 the chain bends in one plane, else, as a twisted blade, in two.
"""

from __future__ import annotations

from collections import namedtuple
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .body.floating import BASE_NUMBERS, FloatingTree, Link, base_numbers
from .body.floating_scene import chain_mistakes, floating_scene
from .body.rotation import BodyParameters
from .parameters import quantity
from .rotating_beam import SCENE as ROTATING_BEAM
from .scene import Array, case_maker

RODS = 3
ANGLES = tuple(f"theta_{k}" for k in range(1, RODS + 1))


@dataclass(frozen=True)
class FloatingBeam(BodyParameters):
    """Parameters of `floating_beam` (SI units)."""

    hub_radius: float = quantity(0.05, "a", "m", "chosen", "of the clamp along x", "any")
    length: float = quantity(0.45, "L", "m", "chosen", "of the beam")
    beam_mass: float = quantity(0.36, "m_b", "kg", "chosen", "of the beam")
    polar_moment: float = quantity(3.2e-5, "I_r", "kg m^2", "chosen", "of a rod, about its length")
    tip_mass: float = quantity(0.06, "m_t", "kg", "chosen", "at the tip", "non-negative")
    bending_stiffness: float = quantity(
        0.15, "EI", "N m^2", "chosen", "of the beam", "non-negative"
    )
    hinge_damping: float = quantity(
        0.002, "d", "N m s/rad", "chosen", "torsion damper of each hinge", "non-negative"
    )
    twist: float = quantity(0.9, "tau", "rad", "chosen", "of a hinge's axis to the next", "any")

    @property
    def rod_length(self) -> Any:
        """The length h of a rod [m]."""
        return self.length / RODS

    @property
    def springs(self) -> tuple[Any, ...]:
        """Stiffness of the hinges [N m/rad]."""
        k = self.bending_stiffness / self.rod_length
        return (2 * k, *(k,) * (RODS - 1))

    @property
    def rods(self) -> tuple[tuple[Any, Any, Any], ...]:
        """Mass [kg], arm of the centre of mass [m] and moment across [kg m^2] of each rod."""
        mass, h = self.beam_mass / RODS, self.rod_length
        across, whole = mass * h**2 / 12 + self.polar_moment / 2, mass + self.tip_mass
        apart = mass * self.tip_mass / whole * (h / 2) ** 2
        last = whole, (mass / 2 + self.tip_mass) * h / whole, across + apart
        return (*((mass, h / 2, across),) * (RODS - 1), last)


NUMBERS = (
    *BASE_NUMBERS,
    *("rod", "arm", "across", "last", "last_arm", "last_across"),
    *("polar", "radius", "length", "cos_twist", "sin_twist", "root", "stiffness", "damping"),
)

Coefficients: Any = namedtuple("Coefficients", NUMBERS)  # type: ignore[misc]
"""Numbers of the equations: those of `base_numbers`, then rods, twist, springs and damper."""


def coefficients(p: FloatingBeam, tensor: Array | None = None) -> Any:
    """Return the numbers of the equations; the inertia tensor (3, 3, ...) may be another."""
    rods = [number for rod in p.rods[-2:] for number in rod]
    own = [p.polar_moment, p.hub_radius, p.rod_length, np.cos(p.twist), np.sin(p.twist)]
    base = base_numbers(p, tensor, p.beam_mass + p.tip_mass)
    return Coefficients._make([*base, *rods, *own, *p.springs[:2], p.hinge_damping])


def links(q: Any, c: Any, xp: Any = np) -> list[Link]:
    """Return the rods."""
    x, y, z = np.eye(3, dtype=int).tolist()
    offset, rods = [c.radius, 0, 0], []
    for k, angle in enumerate(q[3 : 3 + RODS]):
        if k:
            y, z = turn_axes(y, z, c.cos_twist, c.sin_twist)
            offset = [c.length * part for part in x]
        x, y = turn_axes(x, y, xp.cos(angle), xp.sin(angle))
        mass, arm, across = c[24:27] if k < RODS - 1 else c[27:30]
        rods.append(Link(k, mass, c.polar, across, x, z, offset, [arm * part for part in x]))
    return rods


def turn_axes(a: list[Any], b: list[Any], cos: Any, sin: Any) -> tuple[list[Any], list[Any]]:
    """Return two axes after a turn from the first to the second."""
    both = list(zip(a, b, strict=True))
    return [cos * p + sin * q for p, q in both], [cos * q - sin * p for p, q in both]


def torques(q: Any, v: Any, c: Any) -> list[Any]:
    """Return those of springs and dampers."""
    return [-(c.stiffness if k else c.root) * q[3 + k] - c.damping * v[3 + k] for k in range(RODS)]


def strain(q: Any, c: Any) -> Any:
    """Return the energy of the springs [J]."""
    return sum((c.stiffness if k else c.root) * q[3 + k] ** 2 for k in range(RODS)) / 2


TREE = FloatingTree("hub", links, torques, strain)


def damping_matrix(c: Any) -> Array:
    """Return the damping of the hinges."""
    return np.diag([*[0.0] * 3, *[c.damping] * RODS, *[0.0] * 4])


def powers(u: Any, q: Any, v: Any, c: Any) -> dict[str, Any]:
    """Return the power [W] of the dampers."""
    return {"dampers": -c.damping * sum(rate**2 for rate in v[3 : 3 + RODS])}


DAMPED = FloatingBeam()
WEIGHED = DAMPED.replace(gravity_x=3.0, gravity_y=-5.0, gravity_z=-7.0)
CONSERVATIVE = DAMPED.replace(hinge_damping=0.0)
PLANAR = DAMPED.replace(centre_z=0.0, axes_x=0.0, axes_y=0.0, axes_z=0.0, twist=0.0)
"""All axes along z and all centres of mass in one plane, which then holds the motion for ever."""

TUMBLING = {
    "x_dot": 0.9, "y_dot": -0.3, "z_dot": 0.5, "theta_1": 0.3, "theta_2": -0.5, "theta_3": 0.7,
    "q_w": 0.9, "q_x": 0.3, "q_y": -0.3, "q_z": 0.1,
    "theta_1_dot": -3.0, "theta_2_dot": 5.0, "theta_3_dot": 4.0,
    "omega_x": 2.0, "omega_y": -3.0, "omega_z": 4.0,
}  # fmt: skip

IN_PLANE = {
    "x_dot": 0.4, "y_dot": -0.3, "theta_1": 0.3, "theta_2": -0.5, "theta_3_dot": 4.0, "omega_z": 3.0
}  # fmt: skip


case = case_maker("floating_beam")

CASES = (
    case("tumbling", WEIGHED, TUMBLING, 0.0625, "algebra", "trajectory", methods="best"),
    case("afloat", DAMPED, {}, 0.5, "frequency", about="afloat"),
    case(
        "conservative", CONSERVATIVE, TUMBLING, 0.5, "order", "trajectory", "energy", full_only=True
    ),
    case("falling", WEIGHED.replace(hinge_damping=0.0), TUMBLING, 0.25, "energy", full_only=True),
    case("planar", PLANAR, IN_PLANE, 0.5, "trajectory", "order", full_only=True),
)


def period(p: FloatingBeam) -> Any:
    """Return the period [s] of a clamped beam, 1 s if it has no stiffness.

    Rayleigh's: 33/140 of its mass move with the tip.
    """
    moving = (33 / 140 * p.beam_mass + p.tip_mass) * p.length**3 / 3
    stiff = np.where(np.asarray(p.bending_stiffness) > 0, p.bending_stiffness, np.inf)
    return np.where(np.isfinite(stiff), 2 * np.pi * np.sqrt(moving / stiff), 1.0)


SCENE = floating_scene(
    TREE,
    coefficients,
    lambda p: not np.any(p.hinge_damping),
    placed=CASES[0],
    name="floating_beam",
    title="hub afloat in space with a twisted beam as a chain of rods",
    paper=ROTATING_BEAM.paper,
    parameters=FloatingBeam,
    coordinates=ANGLES,
    units=dict.fromkeys(ANGLES, "rad"),
    coefficients=coefficients,
    damping_matrix=damping_matrix,
    powers=powers,
    period=period,
    cases=CASES,
)

SCENE = replace(SCENE, mistakes={**SCENE.mistakes, **chain_mistakes(SCENE, TREE)})

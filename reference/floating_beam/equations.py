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
`..body.floating`. The beam is a chain in the scheme A of `..rotating_beam.chain`: three rods of
h = L/3, with torsion springs k = EI/h in their hinges, of 2k at the clamp. A rod of mass m has
m h^2/12 + I_r/2 across its length and I_r about it, the last one a point mass at its end as well.
The axis of a hinge is that of the hinge before it turned by tau about the rod between them: with
tau = 0 the chain bends in one plane, else, as a twisted blade, in two.
"""

from __future__ import annotations

from collections import namedtuple
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..body.floating import BASE_NUMBERS, FloatingTree, Link, base_numbers
from ..body.parameters import BodyParameters, body_inertia
from ..parameters import quantity
from ..scene import Array

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
        """Of the hinges [N m/rad]."""
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


def coefficients(p: FloatingBeam) -> Any:
    """Return the numbers of the equations."""
    return coefficients_of(p, body_inertia(p))


def coefficients_of(p: FloatingBeam, tensor: Array) -> Any:
    """Return these numbers of an inertia tensor (3, 3, ...) of the hub about its point."""
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

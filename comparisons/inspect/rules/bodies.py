"""Rules about bodies: inertia against mass and size, densities, parts that lie in each other."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ....reference.scene import Array
from ...checks.rules.conditions import NEAR_FLOOR
from ...engines.mujoco.engine import MuJoCo
from ..mujoco.facts import DRAWS
from ..subject import Hit, InspectedModel

LARGE = 2.0
"""Radius of gyration, in the reach of a body's geoms, beyond which no body of that size has it."""

SMALL = 0.01
"""And below which it is a point in them: inertia in a unit that is too large."""

OFF = 2.0
"""Distance of a centre of mass from the middle of the geoms, in their reach."""

DENSEST, THINNEST = 25_000.0, 0.5
"""Densities [kg/m^3]: osmium has 22,600, air 1.2."""

UNEVEN = 1e4
"""Times its own mass that a body may carry beyond a joint."""


class Extent(NamedTuple):
    """What the geoms of a body fill that moves by itself, in its own frame.

    Attributes
    ----------
    body : int
    middle : array (3,)
    reach : float
        From there to the farthest point [m].
    volume : float
        Of the boxes that hold the geoms, the most that they can have [m^3].
    stated : bool
        Whether the body has an ``<inertial>`` that counts.
    """

    body: int
    middle: Array
    reach: float
    volume: float
    stated: bool


def extents(s: InspectedModel) -> Iterator[Extent]:
    """Yield what the geoms of moving bodies fill that are alone in their rigid piece.

    Where contact is off, geoms are drawings, and tell no size.
    """
    m = s.model
    rigid = np.bincount(m.body_weldid, minlength=m.nbody)
    alone = (m.body_weldid == np.arange(m.nbody)) & (rigid == 1) & (m.body_mass > 0)
    solid = ~s.loaded.of_kind("geom_type", "plane", "hfield") & s.facts.options.contact
    sizes = 2 * m.geom_aabb.reshape(-1, 6)[:, 3:]
    for body in range(1, m.nbody):
        own = np.flatnonzero(solid & (m.geom_bodyid == body))
        if not (alone[body] and len(own)):
            continue
        places, radii = m.geom_pos[own], m.geom_rbound[own]
        middle = (np.min(places - radii[:, None], 0) + np.max(places + radii[:, None], 0)) / 2
        element = s.loaded.places.get(("body", body))
        tags = {child.tag for child in element.children} if element else set[str]()
        yield Extent(
            body=body,
            middle=middle,
            reach=float(np.max(np.linalg.norm(places - middle, axis=1) + radii)),
            volume=float(np.sum(np.prod(sizes[own], axis=1))),
            stated="inertial" in tags and s.setting("inertiafromgeom") != "true",
        )


def odd_inertia(s: InspectedModel) -> Iterator[Hit]:
    m = s.model
    for body, _, reach, _, stated in extents(s):
        gyration = float(np.sqrt(np.max(m.body_inertia[body]) / m.body_mass[body]))
        share = gyration / reach
        if not stated or np.min(m.body_inertia[body]) <= NEAR_FLOOR * MuJoCo.min_inertia:
            continue  # a point, of which `inertia_floor` speaks
        if not SMALL < share < LARGE:
            size = "larger" if share >= LARGE else "smaller"
            message = (
                f"its inertia of {np.max(m.body_inertia[body]):.3g} kg m^2 with a mass of "
                f"{m.body_mass[body]:.4g} kg has a radius of gyration of {gyration:.3g} m, "
                f"{size} than a body that reaches {reach:.3g} m can have"
            )
            yield s.hit("body", body, message)


def far_centre(s: InspectedModel) -> Iterator[Hit]:
    for body, middle, reach, _, stated in extents(s):
        off = float(np.linalg.norm(s.model.body_ipos[body] - middle))
        if stated and off > OFF * reach:
            message = (
                f"its centre of mass is {off:.3g} m from the middle of its geoms, which reach "
                f"{reach:.3g} m"
            )
            yield s.hit("body", body, message)


def odd_density(s: InspectedModel) -> Iterator[Hit]:
    m = s.model
    for body, _, _, volume, _ in extents(s):
        density = float(m.body_mass[body]) / volume if volume > 0 else 1.0
        if not THINNEST < density < DENSEST:
            what = "osmium" if density >= DENSEST else "air"
            side = "more than" if density >= DENSEST else "less than"
            message = (
                f"its mass of {m.body_mass[body]:.4g} kg in the box of its geoms is "
                f"{density:.3g} kg/m^3, {side} {what}"
            )
            yield s.hit("body", body, message)


def uneven_masses(s: InspectedModel) -> Iterator[Hit]:
    m = s.model
    rigid = np.zeros(m.nbody)
    np.add.at(rigid, m.body_weldid, m.body_mass)
    for body in range(1, m.nbody):
        above = int(m.body_weldid[m.body_parentid[body]])
        if m.body_weldid[body] != body or above == 0 or rigid[above] == 0:
            continue
        ratio = float(m.body_subtreemass[body] / rigid[above])
        inertia = float(np.max(m.dof_armature[m.dof_bodyid == above], initial=0.0))
        if ratio > UNEVEN and inertia == 0:
            message = (
                f"it and what hangs on it weigh {ratio:.3g} times as much as "
                f"{s.loaded.name('body', above)}, which carries it, and whose joints have no "
                "armature"
            )
            yield s.hit("body", body, message)


def overlapping(s: InspectedModel, always: bool) -> Iterator[Hit]:
    """Yield the pairs of geoms of one mechanism that lie in each other always, or sometimes."""
    for pair, count in sorted(s.meetings.items()):
        if (count == DRAWS) == always:
            names = " and ".join(s.loaded.name("geom", geom) for geom in pair)
            message = (
                f"{names} lie in each other in {'all' if always else count} of {DRAWS} random "
                f"positions within the ranges of the joints"
                f"{': the contact never ends' if always else ''}"
            )
            yield s.hit("geom", pair[0], message)

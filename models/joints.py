"""Joints in vectors of positions and of velocities, which differ where a joint has a quaternion."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from ..reference import quaternions
from ..reference.scene import Array

SIZES: Mapping[str, tuple[int, int]] = MappingProxyType(
    {"hinge": (1, 1), "slide": (1, 1), "ball": (4, 3), "free": (7, 6)}
)
"""How many numbers of a position, and of a velocity, a joint of each kind has."""

SPATIAL = ("ball", "free")
"""Kinds of joints whose position has a quaternion: its last four numbers."""


@lru_cache(maxsize=256)
def layout_of(kinds: tuple[str, ...]) -> JointLayout:
    """Return the layout of joints of these kinds, the same object each time."""
    return JointLayout(kinds)


class JointLayout:
    """Places of joints in vectors of positions (n_q,) and of velocities (n_v,).

    The position of a ball is the unit quaternion (w, x, y, z) from the frame of its body to the
    frame of the body's parent, its velocity the angular velocity in the frame of the body. A
    free joint has a place in the world, and its velocity there, before these.

    Attributes
    ----------
    kinds : tuple of str
    positions, velocities : tuple of slice
        Place of each joint in a vector of positions, and in one of velocities.
    quaternions : tuple of slice
        Places of quaternions in a vector of positions.
    size : (int, int)
        Numbers n_q of positions and n_v of velocities.
    is_spatial : bool
        Whether a joint turns about any axis.
    """

    def __init__(self, kinds: tuple[str, ...]) -> None:
        self.kinds = kinds
        self.positions, self.velocities = (slices(SIZES[kind][i] for kind in kinds) for i in (0, 1))
        places = zip(self.positions, kinds, strict=True)
        ends = [at.stop for at, kind in places if kind in SPATIAL]
        self.quaternions = tuple(slice(end - 4, end) for end in ends)
        count, rates = (sum(SIZES[kind][i] for kind in kinds) for i in (0, 1))
        self.size, self.is_spatial = (count, rates), bool(ends)

    def rates(self, q: Array, v: Array) -> Array:
        """Return the rates of positions (n_q,) by velocities (n_v,)."""
        if not self.is_spatial:
            return v
        rates = np.zeros(len(q), dtype=np.result_type(q, v))
        for kind, at, own in zip(self.kinds, self.positions, self.velocities, strict=True):
            here, speed = q[at], v[own]
            if kind in SPATIAL:
                turn = quaternions.product(here[-4:], [0.0, *(speed[-3:] / 2)])
                rates[at] = np.concatenate([speed[:-3], turn])
            else:
                rates[at] = speed
        return rates

    def displaced(self, q: Array, change: Array) -> Array:
        """Return positions (n_q,) after constant velocities that add up to a change (n_v,).

        A quaternion turns about an axis fixed in its body, and keeps the length 1.
        """
        if not self.is_spatial:
            return np.asarray(q + change)
        moved = np.array(q, dtype=float)
        for kind, at, own in zip(self.kinds, self.positions, self.velocities, strict=True):
            here, step = q[at], change[own]
            if kind in SPATIAL:
                turn = quaternions.product(here[-4:], quaternions.of_rotation(step[-3:]))
                unit = np.array(turn) / np.linalg.norm(turn)
                moved[at] = np.concatenate([here[:-4] + step[:-3], unit])
            else:
                moved[at] = here + step
        return moved


def slices(sizes: Iterable[int]) -> tuple[slice, ...]:
    """Return the places of parts of these sizes in a vector."""
    ends = np.cumsum([0, *sizes]).tolist()
    return tuple(slice(*both) for both in pairwise(ends))

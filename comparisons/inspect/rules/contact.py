"""Which geoms of a model can touch each other, by MuJoCo's filters."""

from __future__ import annotations

from collections import Counter

import numpy as np

from ..mujoco.model import Loaded

DRAWS = 40
"""Random positions within the ranges of joints."""

DEEP = 1e-3
"""How deep bodies may lie in each other, in the model's size."""

MOST_DOFS = 200
"""With more degrees of freedom none are drawn."""


def can_touch(loaded: Loaded, contact: bool) -> np.ndarray:
    """Return which geoms (ngeom,) can touch another, if contact is on."""
    m = loaded.model
    if not contact:
        return np.zeros(m.ngeom, dtype=bool)
    geoms = np.any(partners(loaded, excluded=True), axis=1)[kinds_of_geom(loaded)[1]]
    geoms[np.concatenate([m.pair_geom1, m.pair_geom2]).astype(int)] = True
    if m.nflex:  # a flex is no geom, and may touch all of them
        geoms |= (m.geom_contype | m.geom_conaffinity) != 0
    return np.asarray(geoms)


def kinds_of_geom(loaded: Loaded) -> tuple[np.ndarray, np.ndarray]:
    """Return the kinds (k, 3) of geoms by body, contype, conaffinity, and each one's (ngeom,)."""
    m = loaded.model
    columns = np.stack([m.geom_bodyid, m.geom_contype, m.geom_conaffinity], axis=1)
    kinds, which = np.unique(columns, axis=0, return_inverse=True)
    return kinds, which.reshape(-1)


def exclusions(loaded: Loaded) -> list[tuple[int, int]]:
    """Return the pairs of bodies that are excluded from contact."""
    return [divmod(int(pair), 1 << 16) for pair in loaded.model.exclude_signature]


def partners(loaded: Loaded, excluded: bool) -> np.ndarray:
    """Return which kinds of geoms (k, k) can touch, by MuJoCo's filters."""
    m = loaded.model
    bodies, types, affinities = kinds_of_geom(loaded)[0].T
    welded = m.body_weldid[bodies]
    asked = (types[:, None] & affinities) != 0
    pairs = (asked | asked.T) & (welded[:, None] != welded)
    if not loaded.disabled("filterparent"):
        child = m.body_weldid[m.body_parentid[welded]][:, None] == welded
        child &= (welded != 0) & (welded[:, None] != 0)
        pairs &= ~(child | child.T)
    for one, other in exclusions(loaded) if excluded else ():
        both = (bodies[:, None] == one) & (bodies == other)
        pairs &= ~(both | both.T)
    return np.asarray(pairs)


def meetings(loaded: Loaded) -> dict[tuple[int, int], int]:
    """Return in how many of `DRAWS` positions two geoms of one tree lie in each other.

    Random ones, within the ranges of the joints; pairs that never do are left out.
    """
    m, lib, draw = loaded.model, loaded.mujoco, np.random.default_rng(2)
    if not m.nv or m.nv > MOST_DOFS:
        return {}
    data, size = lib.MjData(m), float(m.stat.extent)
    moved = np.flatnonzero(loaded.of_kind("jnt_type", "hinge", "slide"))
    free = np.where(loaded.of_kind("jnt_type", "hinge"), np.pi, 0.1 * size)
    low, high = np.where(m.jnt_limited != 0, np.asarray(m.jnt_range).T, [-free, free])
    counts: Counter[tuple[int, int]] = Counter()
    for _ in range(DRAWS):
        data.qpos[:] = m.qpos0
        data.qpos[m.jnt_qposadr[moved]] = draw.uniform(low[moved], high[moved])
        lib.mj_kinematics(m, data)
        lib.mj_comPos(m, data)
        lib.mj_collision(m, data)
        counts.update(
            {
                (int(contact.geom[0]), int(contact.geom[1]))
                for contact in data.contact
                if -float(contact.dist) > DEEP * size and contact.geom[0] >= 0
            }
        )
    trees = m.body_treeid[m.geom_bodyid]
    return {pair: n for pair, n in counts.items() if trees[pair[0]] == trees[pair[1]] >= 0}

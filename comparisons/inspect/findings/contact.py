"""Which geoms of a model can touch each other, by MuJoCo's filters."""

from __future__ import annotations

import numpy as np

from ..mujoco.mujoco_model import Loaded


def touching(loaded: Loaded, contact: bool) -> np.ndarray:
    """Return which geoms (ngeom,) can touch another, if contact is on."""
    m = loaded.model
    if not contact:
        return np.zeros(m.ngeom, dtype=bool)
    found = np.any(partners(loaded, excluded=True), axis=1)[kinds_of_geom(loaded)[1]]
    found[np.concatenate([m.pair_geom1, m.pair_geom2]).astype(int)] = True
    if m.nflex:  # a flex is no geom, and may touch all of them
        found |= (m.geom_contype | m.geom_conaffinity) != 0
    return np.asarray(found)


def kinds_of_geom(loaded: Loaded) -> tuple[np.ndarray, np.ndarray]:
    """Return the kinds (k, 3) of geoms by body, contype, conaffinity, and each one's (ngeom,)."""
    m = loaded.model
    columns = np.stack([m.geom_bodyid, m.geom_contype, m.geom_conaffinity], axis=1)
    kinds, which = np.unique(columns, axis=0, return_inverse=True)
    return kinds, which.reshape(-1)


def partners(loaded: Loaded, excluded: bool) -> np.ndarray:
    """Return which kinds of geoms (k, k) can touch, by MuJoCo's filters."""
    m = loaded.model
    bodies, types, affinities = kinds_of_geom(loaded)[0].T
    welded = m.body_weldid[bodies]
    parents = m.body_weldid[m.body_parentid[welded]]
    asked = (types[:, None] & affinities) | (types & affinities[:, None])
    found = (asked != 0) & (welded[:, None] != welded)
    if not loaded.disabled("filterparent"):
        child = (parents[:, None] == welded) & (welded != 0) & (welded[:, None] != 0)
        found &= ~(child | child.T)
    if excluded:
        for signature in np.asarray(m.exclude_signature):
            one, other = int(signature) >> 16, int(signature) & 0xFFFF
            both = (bodies[:, None] == one) & (bodies == other)
            found &= ~(both | both.T)
    return np.asarray(found)

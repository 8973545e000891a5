"""Rows of MuJoCo's constraints as the springs and dampers that they are near a state.

A row pulls with ``D (a_ref - J a)``, ``a_ref = -b v - d k r``. Its k and b follow from ``solref``:
a positive time constant below two timesteps is raised to that (`refsafe`), so that

    b(h) = f b(0),   k(h) = f^2 k(0),   f = min(1, T / (2 h))

for the time constant T of the file. ``discrete`` leaves T as it is.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ....reference.scene import Array
from ..spectrum import SHORT
from .model import Flags, Loaded, State

LONG = 1e3
"""Step [s] at which all time constants are raised that can be."""

SAME = 1e-9
"""Share by which a damper may change without being raised."""


class Soft(NamedTuple):
    """What MuJoCo's constraints add to small motions in a state.

    Attributes
    ----------
    jacobian : array (rows, nv)
    weight, damping, stiffness : array (rows,)
        1 / R, b [1/s] and d k [1/s^2] of each row, no time constant raised.
    constant : array (rows,)
        The time constants T [s] that may be raised; 0 of those that are not.
    dry : array (rows,)
        Which of them are dry friction that holds.
    names : tuple of str
    contacts, limits : int
        That are active.
    """

    jacobian: Array
    weight: Array
    damping: Array
    stiffness: Array
    constant: Array
    dry: Flags
    names: tuple[str, ...]
    contacts: int
    limits: int

    def at(self, step: float) -> Soft:
        """Return them as MuJoCo takes them at a step [s]."""
        raised = (self.constant > 0) & (self.constant < 2 * step)
        share = np.where(raised, self.constant / (2 * step), 1.0)
        return self._replace(damping=share * self.damping, stiffness=share**2 * self.stiffness)

    def sliding(self) -> Soft:
        """Return them where all that dry friction holds slides."""
        parts = ("jacobian", "weight", "damping", "stiffness", "constant", "dry")
        left = {part: getattr(self, part)[~self.dry] for part in parts}
        names = tuple(name for name, dry in zip(self.names, self.dry, strict=True) if not dry)
        return self._replace(**left, names=names)

    @property
    def raised_from(self) -> float:
        """The step [s] from which on a time constant is raised; infinite if none is."""
        return float(np.min(self.constant[self.constant > 0], initial=np.inf)) / 2


def jacobian_rows(model: Any, data: Any) -> Array:
    """Return the Jacobian (nefc, nv) of all constraints; its buffer may be longer."""
    count = int(data.nefc)
    return np.array(data.efc_J)[: count * model.nv].reshape(count, model.nv)


def soft_rows(loaded: Loaded, state: State) -> Soft:
    """Return the constraints that push or hold in a state, linear as they are there."""
    model, types = loaded.sharp(), loaded.mujoco.mjtConstraint
    data = loaded.data(state, model)
    loaded.mujoco.mj_forward(model, data)
    nefc = int(data.nefc)
    kinds = np.array(data.efc_type)[:nefc]
    rows = acting(loaded, data, kinds)
    jacobian, weight = jacobian_rows(model, data)[rows], np.array(data.efc_D)[:nefc][rows]
    names = tuple(row_name(loaded, data, int(row), int(kinds[row])) for row in np.flatnonzero(rows))
    contacts = sum(contact.efc_address >= 0 for contact in data.contact)
    most = springs(loaded, state, LONG)
    spring, damper, impedance, _ = springs(loaded, state, SHORT)[rows].T
    with np.errstate(all="ignore"):
        share = np.nan_to_num(most[rows, 1] / damper, nan=1.0, posinf=1.0)
    limits = [types.mjCNSTR_LIMIT_JOINT, types.mjCNSTR_LIMIT_TENDON]
    return Soft(
        jacobian=jacobian,
        weight=weight,
        damping=damper,
        stiffness=impedance * spring,
        constant=np.where(np.abs(share - 1) > SAME, 2 * LONG * share, 0.0),
        dry=np.asarray(is_dry(loaded, kinds[rows])),
        names=names,
        contacts=contacts,
        limits=int(np.sum(np.isin(kinds[rows], [int(kind) for kind in limits]))),
    )


def springs(loaded: Loaded, state: State, step: float) -> Array:
    """Return stiffness, damping and impedance of each row (nefc, 4) at a step [s]."""
    model = loaded.sharp()
    model.opt.timestep = step
    data = loaded.data(state, model)
    loaded.mujoco.mj_forward(model, data)
    return np.array(data.efc_KBIP).reshape(-1, 4)[: int(data.nefc)]


def is_dry(loaded: Loaded, kinds: Array) -> Flags:
    """Return which rows are dry friction of joints and tendons."""
    types = loaded.mujoco.mjtConstraint
    dry = (int(types.mjCNSTR_FRICTION_DOF), int(types.mjCNSTR_FRICTION_TENDON))
    return np.asarray(np.isin(kinds, dry))


def row_name(loaded: Loaded, data: Any, row: int, kind: int) -> str:
    """Return whose row one is."""
    word = loaded.mujoco.mjtConstraint(kind).name.removeprefix("mjCNSTR_").lower()
    number = int(data.efc_id[row])
    if word == "equality":
        return f"equality {loaded.name('equality', number)}"
    if word.startswith("contact"):
        pair = [int(geom) for geom in data.contact[number].geom]
        return "contact of " + " and ".join(
            loaded.name("geom", geom) if geom >= 0 else "a flex" for geom in pair
        )
    what, _, where = word.partition("_")
    if where == "dof":
        return f"{what} of {loaded.joint_names[number]}"
    return f"{what} of {loaded.name(where, number)}"


def acting(loaded: Loaded, data: Any, kinds: Array) -> Array:
    """Return which rows (nefc,) give way in proportion, neither open nor sliding."""
    types = loaded.mujoco.mjtConstraint
    force, most = np.array(data.efc_force), np.array(data.efc_frictionloss)
    holds = np.abs(force) < most
    rows = (kinds == int(types.mjCNSTR_EQUALITY)) | np.where(
        is_dry(loaded, kinds), holds, force != 0
    )
    for contact in data.contact:  # those of an elliptic cone act together
        first, count = int(contact.efc_address), int(contact.dim)
        if first >= 0 and kinds[first] == int(types.mjCNSTR_CONTACT_ELLIPTIC):
            rows[first : first + count] = force[first] != 0
    return np.asarray(rows)


def with_soft_rows(soft: Soft, mass: Array, matrix: Array, rate: Array) -> Array:
    """Return C or K (nv, nv) with constraints as soft as MuJoCo has them, by their b or d k.

    Their forces are ``D (a_ref - J a)``, so that ``(M + J^T D J) a = f + J^T D a_ref``.
    """
    if not len(soft.weight):
        return matrix
    root = 1 / np.sqrt(np.diag(mass))
    scale, rows = np.outer(root, root), soft.jacobian * root
    left = mass * scale + rows.T @ (soft.weight[:, None] * rows)
    right = matrix * scale + rows.T @ ((soft.weight * rate)[:, None] * rows)
    return np.asarray(mass @ (root[:, None] * np.linalg.solve(left, right)) / root)

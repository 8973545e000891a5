"""What MuJoCo simulates beside a model's smooth forces: soft constraints, and parts taken late."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ....reference.scene import Array
from ..spectrum import Motion
from .model import Loaded, State


class Soft(NamedTuple):
    """What MuJoCo's constraints add to small motions in a state; arrays (rows, nv) and (rows,)."""

    jacobian: Array
    weight: Array
    """1 / R of each row"""
    damping: Array
    """b [1/s]"""
    stiffness: Array
    """d k [1/s^2]"""
    contacts: int
    limits: int


class Parts(NamedTuple):
    """Parts (nv, nv) of the damping and the stiffness, and the whole of each."""

    bias: Array
    passive: Array
    actuator: Array
    spring: Array
    servo: Array
    damping: Array
    stiffness: Array


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
    spring, damper, impedance, _ = np.array(data.efc_KBIP).reshape(-1, 4)[:nefc][rows].T
    limits = [types.mjCNSTR_LIMIT_JOINT, types.mjCNSTR_LIMIT_TENDON]
    return Soft(
        jacobian=jacobian_rows(model, data)[rows],
        weight=np.array(data.efc_D)[:nefc][rows],
        damping=damper,
        stiffness=impedance * spring,
        contacts=sum(contact.efc_address >= 0 for contact in data.contact),
        limits=int(np.sum(np.isin(kinds[rows], [int(kind) for kind in limits]))),
    )


def acting(loaded: Loaded, data: Any, kinds: Array) -> Array:
    """Return which rows (nefc,) give way in proportion, neither open nor sliding."""
    types = loaded.mujoco.mjtConstraint
    force, most = np.array(data.efc_force), np.array(data.efc_frictionloss)
    dry = np.isin(kinds, (int(types.mjCNSTR_FRICTION_DOF), int(types.mjCNSTR_FRICTION_TENDON)))
    rows = (kinds == int(types.mjCNSTR_EQUALITY)) | np.where(dry, np.abs(force) < most, force != 0)
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


def by_integrator(loaded: Loaded, mass: Array, parts: Parts, soft: Soft) -> dict[str, Motion]:
    """Return small motions as simulated, with what each integrator takes at the end of its step.

    MuJoCo's documentation ("Computation", numerical integration): Euler has the dampers of
    joints, ``implicit`` all forces but those of constraints, ``implicitfast`` the symmetric part
    of these without the bias forces, both within the sparsity of the mass matrix. ``discrete``
    adds springs and what constraints are, in all of their parts that dissipate or hold.
    """
    damping = with_soft_rows(soft, mass, parts.damping, soft.damping)
    stiffness = with_soft_rows(soft, mass, parts.stiffness, soft.stiffness)
    sparse, nothing = related(np.asarray(loaded.model.dof_parentid)), np.zeros_like(mass)
    smooth, gyroscopic = parts.passive + parts.actuator, np.where(standalone(loaded), parts.bias, 0)
    dampers = holding(parts.passive) + holding(parts.actuator) + damping - parts.damping
    springs = holding(parts.spring) + holding(parts.servo) + stiffness - parts.stiffness
    off = loaded.disabled("eulerdamp") or loaded.disabled("damper")
    joints = nothing if off else np.diag(np.asarray(loaded.model.dof_damping, dtype=float))
    late = {
        "Euler": (joints, nothing),
        "implicit": (np.where(sparse, parts.bias + smooth, 0), nothing),
        "implicitfast": (np.where(sparse, (smooth + smooth.T) / 2, 0) + gyroscopic, nothing),
        "RK4": (nothing, nothing),
        "discrete": (dampers + gyroscopic, springs),
    }
    return {name: Motion(mass, damping, stiffness, *pair) for name, pair in late.items()}


def related(parents: Array) -> Array:
    """Return whether two degrees of freedom (nv, nv) lie on one branch of the tree."""
    branch = np.eye(len(parents), dtype=bool)
    for dof, parent in enumerate(parents):
        if parent >= 0:
            branch[dof] |= branch[parent]
    return np.asarray(branch | branch.T)


def standalone(loaded: Loaded) -> Array:
    """Return where the rows and columns (nv, nv) of free bodies without jointed children are."""
    m = loaded.model
    same = m.body_treeid[m.dof_bodyid][:, None] == m.body_treeid[m.dof_bodyid]
    free = loaded.of_kind("jnt_type", "free")[m.dof_jntid]
    return np.asarray(same & free & (np.sum(same, axis=1) == 6))


def holding(matrix: Array) -> Array:
    """Return the symmetric part without directions in which it is negative."""
    if not matrix.size or not np.any(matrix):
        return matrix
    scale = np.sqrt(np.maximum(np.abs(np.diag(matrix)), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh((matrix + matrix.T) / 2 / np.outer(scale, scale))
    return np.asarray((vectors * np.maximum(values, 0)) @ vectors.T * np.outer(scale, scale))

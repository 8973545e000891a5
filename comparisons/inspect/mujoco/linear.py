r"""Small motions about a state of an MJCF model, from MuJoCo's own forces.

``M a + C v + K q = 0`` for small departures from a state in which constant forces would hold the
model: where it rests anyhow, there are none. What floats freely is not held but falls, with the
acceleration a_0. Positions are displaced in the tangent space (`mj_integratePos`), so that ball and
free joints have as many coordinates as degrees of freedom. With the exact forces lambda_0 of closed
loops,

    F(q, v) = M(q) a_0 + bias - passive - actuator - J(q)^T lambda_0,   K = dF/dq, C = dF/dv,

and small motions that leave the loops closed are Z z with J Z = 0. As *simulated*, loops,
limits, contacts and dry friction are the springs and dampers that MuJoCo has in their place, in the
directions that they have in the state.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import null_space

from ....reference.differences import by_differences, derivative
from ....reference.scene import Array
from ..spectrum import LinearMotion
from .model import Loaded, NotFiniteError, State


class Soft(NamedTuple):
    """What MuJoCo's constraints add to small motions in a state.

    Attributes
    ----------
    jacobian : array (rows, nv)
    weight, damping, stiffness : array (rows,)
        1 / R, b [1/s] and d k [1/s^2] of each row.
    contacts, limits : int
        That are active.
    """

    jacobian: Array
    weight: Array
    damping: Array
    stiffness: Array
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


def by_integrator(loaded: Loaded, mass: Array, parts: Parts, soft: Soft) -> dict[str, LinearMotion]:
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
    return {name: LinearMotion(mass, damping, stiffness, *pair) for name, pair in late.items()}


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


DIFFERENCE = 1e-3
"""Step of differences [rad], and share of the model's size [m]."""

ROUNDING = 64 * float(np.finfo(float).eps)
"""What values leave in a difference, as a share of them."""

RANK = 1e-9
"""A row of a scaled Jacobian that is a share of this of the others says nothing new."""


class Linear(NamedTuple):
    """Small motions about a state, arrays (nv, nv).

    Attributes
    ----------
    mass, damping, stiffness
        Loops closed exactly; contacts, limits and dry friction left out.
    free : array (nv, k)
        Directions in which closed loops let it move.
    simulated : mapping of str to Motion
        By integrator: all of MuJoCo's constraints, as soft as they are, and what it takes late.
    acceleration : array (nv,)
        In the state, loops closed exactly.
    rows : int
        Constraints that give way in the state.
    closed : int
        Independent directions that closed loops take away.
    contacts, limits : int
        That are active in the state.
    """

    mass: Array
    damping: Array
    stiffness: Array
    free: Array
    simulated: Mapping[str, LinearMotion]
    acceleration: Array
    rows: int
    closed: int
    contacts: int
    limits: int


class LinearProbe:
    """Forces near a state; loops only are constraints.

    Parameters
    ----------
    loaded : Loaded
    state : State
    """

    def __init__(self, loaded: Loaded, state: State) -> None:
        self.lib, self.state = loaded.mujoco, state
        self.model = loaded.sharp("contact", "limit", "frictionloss")
        self.data = loaded.data(state, self.model)
        self.scale = slide_scale(loaded)

    def put(self, position: Array, velocity: Array) -> None:
        """Set a state."""
        self.data.qpos[:], self.data.qvel[:] = position, velocity

    def displaced(self, direction: Array, position: Array | None = None) -> Array:
        """Return positions moved along a direction (nv,) of the tangent space."""
        moved: Array = np.array(self.state.position if position is None else position)
        self.lib.mj_integratePos(self.model, moved, direction, 1.0)
        return moved

    def forces(self, acceleration: Array) -> tuple[Array, Array, Array, Array]:
        """Return inertia and bias forces (nv,), passive and actuator forces, and J (rows, nv)."""
        data = self.data
        data.qacc[:] = acceleration
        self.lib.mj_inverse(self.model, data)
        self.lib.mj_fwdActuation(self.model, data)
        inertia = data.qfrc_inverse + data.qfrc_constraint + data.qfrc_passive
        loops = data.efc_type == int(self.lib.mjtConstraint.mjCNSTR_EQUALITY)
        jacobian = jacobian_rows(self.model, data)[loops]
        return inertia, data.qfrc_passive.copy(), np.array(data.qfrc_actuator), jacobian

    def mass(self) -> Array:
        """Return the mass matrix (nv, nv) where the data is."""
        mass = np.empty((self.model.nv, self.model.nv))
        for row, unit in zip(mass, np.eye(len(mass)), strict=True):  # mj_fullM is versions apart
            self.lib.mj_mulM(self.model, self.data, row, unit)
        return mass


def slide_scale(loaded: Loaded) -> Array:
    """Return by what steps of differences are multiplied (nv,): lengths share the model's size."""
    m = loaded.model
    size = min(1.0, float(m.stat.extent)) or 1.0
    slide, free = (loaded.of_kind("jnt_type", kind)[m.dof_jntid] for kind in ("slide", "free"))
    first = np.arange(m.nv) - m.jnt_dofadr[m.dof_jntid] < 3
    return np.where(slide | (free & first), size, 1.0)


class Solved(NamedTuple):
    """Accelerations (nv,) and forces (rows,) of loops that are closed exactly."""

    acceleration: Array
    multipliers: Array
    jacobian: Array
    mass: Array


def solved(probe: LinearProbe) -> Solved:
    """Solve for the accelerations in the state of a probe.

    Raises
    ------
    NotFiniteError
    """
    name, nothing = probe.state.name, np.zeros(probe.model.nv)
    probe.put(probe.state.position, probe.state.velocity)
    bias, passive, actuator, jacobian = probe.forces(nothing)
    mass = probe.mass()
    applied = passive + actuator - bias
    if not (np.all(np.isfinite(applied)) and np.all(np.isfinite(mass))):
        raise NotFiniteError(f"forces are not finite in the state {name!r}")
    root = 1 / np.sqrt(np.diag(mass))
    if not np.all(np.isfinite(root)):
        raise NotFiniteError(f"the mass matrix is not positive in the state {name!r}")
    scaled = mass * np.outer(root, root)
    free = np.linalg.solve(scaled, root * applied)
    rows = jacobian * root
    if not len(rows):
        return Solved(root * free, np.zeros(0), jacobian, mass)
    inverse = np.linalg.pinv(rows @ np.linalg.solve(scaled, rows.T), rcond=RANK, hermitian=True)
    forces = -inverse @ (rows @ free + curvature(probe))
    return Solved(root * (free + np.linalg.solve(scaled, rows.T @ forces)), forces, jacobian, mass)


def curvature(probe: LinearProbe) -> Array:
    """Return ``dJ/dt v`` (rows,) in the state of a probe."""
    velocity = probe.state.velocity
    step = DIFFERENCE / (np.max(np.abs(velocity), initial=0.0) or 1.0)

    def rates(time: float) -> Array:
        probe.put(probe.displaced(time * velocity), velocity)
        return np.asarray(probe.forces(np.zeros_like(velocity))[-1] @ velocity)

    return np.asarray(derivative(rates, step=step))


def linearise(loaded: Loaded, state: State) -> Linear:
    """Linearise a model about a state.

    Raises
    ------
    NotFiniteError
        If forces are not finite there.
    """
    probe = LinearProbe(loaded, state)
    at = solved(probe)
    fall = falling(loaded, at.jacobian)

    def by_position(displacement: Array) -> Array:
        probe.put(probe.displaced(displacement), state.velocity)
        inertia, passive, actuator, jacobian = probe.forces(fall)
        left = inertia - passive - actuator - jacobian.T @ at.multipliers
        return np.array([left, -probe.data.qfrc_spring, -actuator])

    def by_velocity(change: Array) -> Array:
        probe.put(state.position, state.velocity + change)
        inertia, passive, actuator, _ = probe.forces(fall)
        return np.array([inertia, -passive, -actuator])

    stiffness, spring, servo = slopes(by_position, probe.scale, np.abs(at.mass) @ np.abs(fall))
    bias, passive, actuator = slopes(by_velocity, probe.scale)
    damping = bias + passive + actuator
    parts = Parts(bias, passive, actuator, spring, servo, damping, stiffness)
    if not all(np.all(np.isfinite(matrix)) for matrix in parts):
        raise NotFiniteError(f"forces near the state {state.name!r} are not finite")
    free, rows = unconstrained(at), soft_rows(loaded, state)
    return Linear(
        mass=at.mass,
        damping=damping,
        stiffness=stiffness,
        free=free,
        simulated=by_integrator(loaded, at.mass, parts, rows),
        acceleration=at.acceleration,
        rows=len(rows.weight),
        closed=loaded.model.nv - free.shape[1],
        contacts=rows.contacts,
        limits=rows.limits,
    )


def falling(loaded: Loaded, jacobian: Array) -> Array:
    """Return the accelerations (nv,) of what floats freely in gravity, no loop tying it."""
    m, accelerations = loaded.model, np.zeros(loaded.model.nv)
    dofs = m.jnt_dofadr[loaded.of_kind("jnt_type", "free")][:, None] + np.arange(3)
    tied = np.any(jacobian[:, dofs], axis=(0, 2)) | loaded.disabled("gravity")
    accelerations[dofs[~tied]] = m.opt.gravity
    return accelerations


def slopes(
    function: Callable[[Array], Array], scale: Array, cancelled: Array | float = 0.0
) -> Array:
    """Return the derivatives (count, n, n) of a function (count, n) of a displacement (n,), at 0.

    What may be rounding is 0: of the values, and of what has cancelled in them (n,).
    """
    sizes = []

    def at_places(x: Array) -> Array:
        values = np.array([function(scale * place) for place in x.T])
        sizes.append(np.max(np.abs(values), axis=0))
        return values.reshape(len(values), -1).T

    slope = by_differences(at_places, np.zeros(len(scale)), step=DIFFERENCE)[1] / scale
    noise = ROUNDING * np.maximum(sizes[0], cancelled)[:, :, None] / (DIFFERENCE * scale)
    slope = slope.reshape(noise.shape)
    return np.where(np.abs(slope) > noise, slope, 0.0)


def unconstrained(at: Solved) -> Array:
    """Return the directions (nv, k) in which closed loops let a model move."""
    root = 1 / np.sqrt(np.diag(at.mass))
    rows = at.jacobian * root
    norms = np.linalg.norm(rows, axis=1)
    rows = rows[norms > 0] / norms[norms > 0, None]
    return (
        np.asarray(root[:, None] * null_space(rows, rcond=RANK)) if len(rows) else np.eye(len(root))
    )

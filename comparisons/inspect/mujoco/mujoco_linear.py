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

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import null_space

from ....reference.errors import UnknownNameError, UsageError
from ....reference.scene import Array
from .mujoco_model import Loaded, NotFiniteError, State

STENCIL = ((1, 2 / 3), (2, -1 / 12))
"""Central difference of order 4: (place, weight) of f(place) - f(-place)."""

DIFFERENCE = 1e-3
"""Step of that difference [rad], and share of the model's size [m]."""

ROUNDING = 64 * float(np.finfo(float).eps)
"""What values leave in a difference, as a share of them."""

RANK = 1e-9
"""A row of a scaled Jacobian that is a share of this of the others says nothing new."""

NEWTON_STEPS = 60
SETTLED = 1e-12
"""Share of the forces that a steady motion leaves."""

LONGEST_CHANGE = 0.5
"""Of a coordinate in one of Newton's steps [rad, m]."""

STEADY = 1e-6
"""Share by which forces may change as a steady rotation goes on."""

TURNS = (0.4, 1.1, 2.3)
"""Angles [rad] at which that is looked at."""


class Late(NamedTuple):
    """What an integrator takes at the end of its step: parts (nv, nv) of C and K."""

    damping: Array
    stiffness: Array


class Linear(NamedTuple):
    """Small motions about a state, arrays (nv, nv).

    Attributes
    ----------
    mass, damping, stiffness
        Loops closed exactly; contacts, limits and dry friction left out.
    free : array (nv, k)
        Directions in which closed loops let it move.
    simulated_damping, simulated_stiffness
        All of MuJoCo's constraints, as soft as they are.
    late : dict of str to Late
        By integrator, of what is simulated.
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
    simulated_damping: Array
    simulated_stiffness: Array
    late: dict[str, Late]
    acceleration: Array
    rows: int
    closed: int
    contacts: int
    limits: int


class Probe:
    """Forces near a state; loops only are constraints.

    Parameters
    ----------
    loaded : Loaded
    state : State
    """

    def __init__(self, loaded: Loaded, state: State) -> None:
        self.lib = loaded.mujoco
        self.loaded = loaded
        self.state = state
        self.model = loaded.sharp("contact", "limit", "frictionloss")
        self.data = loaded.data(state, self.model)
        self.scale = slide_scale(loaded)

    def put(self, position: Array, velocity: Array) -> None:
        """Set a state."""
        self.data.qpos[:] = position
        self.data.qvel[:] = velocity

    def displaced(self, direction: Array, position: Array | None = None) -> Array:
        """Return positions moved along a direction (nv,) of the tangent space."""
        moved: Array = np.array(self.state.position if position is None else position)
        self.lib.mj_integratePos(self.model, moved, direction, 1.0)
        return moved

    def forces(self, acceleration: Array) -> tuple[Array, Array, Array, Array]:
        """Return inertia and bias forces (nv,), passive and actuator forces, and J (rows, nv)."""
        self.data.qacc[:] = acceleration
        self.lib.mj_inverse(self.model, self.data)
        self.lib.mj_fwdActuation(self.model, self.data)
        inertia = self.data.qfrc_inverse + self.data.qfrc_constraint + self.data.qfrc_passive
        return inertia, self.data.qfrc_passive.copy(), actuation(self.data), self.jacobian()

    def jacobian(self) -> Array:
        """Return the Jacobian (rows, nv) of the loops where the data is."""
        loops = self.data.efc_type == int(self.lib.mjtConstraint.mjCNSTR_EQUALITY)
        return rows_of(self.data, self.model)[loops]

    def mass(self) -> Array:
        """Return the mass matrix (nv, nv) where the data is."""
        return mass_matrix(self.loaded, self.model, self.data)


def rows_of(data: Any, model: Any) -> Array:
    """Return the Jacobian (nefc, nv) of all constraints; its buffer may be longer."""
    count = int(data.nefc)
    return np.array(data.efc_J)[: count * model.nv].reshape(count, model.nv)


def actuation(data: Any) -> Array:
    """Return the forces (nv,) of actuators."""
    return np.array(data.qfrc_actuator)


def mass_matrix(loaded: Loaded, model: Any, data: Any) -> Array:
    """Return the mass matrix (nv, nv) of data whose positions have been computed."""
    found = np.empty((model.nv, model.nv))
    for row, unit in zip(found, np.eye(model.nv), strict=True):  # mj_fullM is versions apart
        loaded.mujoco.mj_mulM(model, data, row, unit)
    return found


def slide_scale(loaded: Loaded) -> Array:
    """Return by what steps of differences are multiplied (nv,): lengths share the model's size."""
    lib, model = loaded.mujoco, loaded.model
    size = min(1.0, float(model.stat.extent)) or 1.0
    kinds = model.jnt_type[loaded.joint_of] if model.nv else np.zeros(0)
    scale = np.where(kinds == int(lib.mjtJoint.mjJNT_SLIDE), size, 1.0)
    for dof, (joint, kind) in enumerate(zip(loaded.joint_of, kinds, strict=True)):
        if kind == int(lib.mjtJoint.mjJNT_FREE) and dof - model.jnt_dofadr[joint] < 3:
            scale[dof] = size
    return scale


class Solved(NamedTuple):
    """Accelerations (nv,) and forces (rows,) of loops that are closed exactly."""

    acceleration: Array
    multipliers: Array
    jacobian: Array
    mass: Array


def solved(probe: Probe) -> Solved:
    """Solve for the accelerations in the state of a probe.

    Raises
    ------
    NotFiniteError
    """
    probe.put(probe.state.position, probe.state.velocity)
    nothing = np.zeros(probe.model.nv)
    bias, passive, actuator, jacobian = probe.forces(nothing)
    mass = probe.mass()
    applied = passive + actuator - bias
    if not (np.all(np.isfinite(applied)) and np.all(np.isfinite(mass))):
        raise NotFiniteError(f"forces are not finite in the state {probe.state.name!r}")
    root = 1 / np.sqrt(np.diag(mass)) if len(mass) else nothing
    if not np.all(np.isfinite(root)):
        raise NotFiniteError(f"the mass matrix is not positive in the state {probe.state.name!r}")
    scaled = mass * np.outer(root, root)
    free = np.linalg.solve(scaled, root * applied)
    rows = jacobian * root
    if not len(rows):
        return Solved(root * free, np.zeros(0), jacobian, mass)
    drift = curvature(probe)
    compliance = rows @ np.linalg.solve(scaled, rows.T)
    forces = -np.linalg.pinv(compliance, rcond=RANK, hermitian=True) @ (rows @ free + drift)
    return Solved(root * (free + np.linalg.solve(scaled, rows.T @ forces)), forces, jacobian, mass)


def curvature(probe: Probe) -> Array:
    """Return ``dJ/dt v`` (rows,) in the state of a probe."""
    velocity = probe.state.velocity
    largest = np.max(np.abs(velocity), initial=0.0)
    if largest == 0:
        return np.zeros(len(probe.jacobian()))
    step = DIFFERENCE / largest

    def rates(time: float) -> Array:
        probe.put(probe.displaced(time * velocity), velocity)
        *_, jacobian = probe.forces(np.zeros(probe.model.nv))
        return np.asarray(jacobian @ velocity)

    found: Array = sum(
        (weight / step * (rates(place * step) - rates(-place * step)) for place, weight in STENCIL),
        np.zeros(1),
    )
    return found


def linearise(loaded: Loaded, state: State) -> Linear:
    """Linearise a model about a state.

    Raises
    ------
    NotFiniteError
        If forces are not finite there.
    """
    probe = Probe(loaded, state)
    nv = loaded.model.nv
    at = solved(probe)
    kept = falling(loaded, at.jacobian)

    def by_position(displacement: Array) -> Array:
        probe.put(probe.displaced(displacement), state.velocity)
        inertia, passive, actuator, jacobian = probe.forces(kept)
        left = inertia - passive - actuator - jacobian.T @ at.multipliers
        return np.array([left, -probe.data.qfrc_spring, -actuator])

    def by_velocity(change: Array) -> Array:
        probe.put(state.position, state.velocity + change)
        inertia, passive, actuator, _ = probe.forces(kept)
        return np.array([inertia, -passive, -actuator])

    stiffness, spring, servo = slopes(by_position, probe.scale, 3, np.abs(at.mass) @ np.abs(kept))
    bias, passive, actuator = slopes(by_velocity, probe.scale, 3)
    damping = bias + passive + actuator
    parts = Parts(bias, passive, actuator, spring, servo, damping, stiffness)
    if not all(np.all(np.isfinite(matrix)) for matrix in parts):
        raise NotFiniteError(f"forces near the state {state.name!r} are not finite")
    free = unconstrained(at)
    rows = soft_rows(loaded, state)
    soft = softly(rows, at.mass, damping, stiffness)
    return Linear(
        mass=at.mass,
        damping=damping,
        stiffness=stiffness,
        free=free,
        simulated_damping=soft[0],
        simulated_stiffness=soft[1],
        late=late_parts(loaded, parts, soft),
        acceleration=at.acceleration,
        rows=len(rows.weight),
        closed=nv - free.shape[1],
        contacts=rows.contacts,
        limits=rows.limits,
    )


class Parts(NamedTuple):
    """Parts (nv, nv) of the damping and the stiffness, and the whole of each."""

    bias: Array
    passive: Array
    actuator: Array
    spring: Array
    servo: Array
    damping: Array
    stiffness: Array


def falling(loaded: Loaded, jacobian: Array) -> Array:
    """Return the accelerations (nv,) of what floats freely in gravity, no loop tying it."""
    lib, m = loaded.mujoco, loaded.model
    found = np.zeros(m.nv)
    for joint in np.flatnonzero(m.jnt_type == int(lib.mjtJoint.mjJNT_FREE)):
        dofs = int(m.jnt_dofadr[joint]) + np.arange(3)
        if not (np.any(jacobian[:, dofs]) or loaded.disabled("gravity")):
            found[dofs] = m.opt.gravity
    return found


def slopes(
    function: Callable[[Array], Array], scale: Array, count: int, cancelled: Array | float = 0.0
) -> Array:
    """Return the derivatives (count, nv, nv) of a function of a displacement (nv,), at 0.

    Values are subtracted in pairs, and what may be rounding is 0: of the values themselves, and
    of what has cancelled in them (nv,).
    """
    nv = len(scale)
    found = np.zeros((count, nv, nv))
    size = np.zeros((count, nv)) + cancelled
    for column in range(nv):
        unit = np.zeros(nv)
        unit[column] = scale[column] * DIFFERENCE
        for place, weight in STENCIL:
            ahead, behind = function(place * unit), function(-place * unit)
            found[:, :, column] += weight / unit[column] * (ahead - behind)
            size = np.maximum(size, np.maximum(np.abs(ahead), np.abs(behind)))
    noise = ROUNDING * size[:, :, None] / (DIFFERENCE * scale)
    return np.where(np.abs(found) > noise, found, 0.0)


def unconstrained(at: Solved) -> Array:
    """Return the directions (nv, k) in which closed loops let a model move."""
    nv = len(at.mass)
    if not len(at.jacobian):
        return np.eye(nv)
    root = 1 / np.sqrt(np.diag(at.mass))
    rows = at.jacobian * root
    norms = np.linalg.norm(rows, axis=1)
    rows = rows[norms > 0] / norms[norms > 0, None]
    return np.asarray(root[:, None] * null_space(rows, rcond=RANK)) if len(rows) else np.eye(nv)


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


def soft_rows(loaded: Loaded, state: State) -> Soft:
    """Return the constraints that push or hold in a state, linear as they are there."""
    lib = loaded.mujoco
    model = loaded.sharp()
    data = loaded.data(state, model)
    lib.mj_forward(model, data)
    nefc = int(data.nefc)
    kinds = np.array(data.efc_type)[:nefc]
    rows = acting(loaded, data, kinds)
    types = lib.mjtConstraint
    limits = (int(types.mjCNSTR_LIMIT_JOINT), int(types.mjCNSTR_LIMIT_TENDON))
    spring, damper, impedance, _ = np.array(data.efc_KBIP).reshape(-1, 4)[:nefc][rows].T
    return Soft(
        jacobian=rows_of(data, model)[rows],
        weight=np.array(data.efc_D)[:nefc][rows],
        damping=damper,
        stiffness=impedance * spring,
        contacts=sum(contact.efc_address >= 0 for contact in data.contact),
        limits=int(np.sum(np.isin(kinds[rows], limits))),
    )


def acting(loaded: Loaded, data: Any, kinds: Array) -> Array:
    """Return which rows (nefc,) give way in proportion, neither open nor sliding."""
    types = loaded.mujoco.mjtConstraint
    force, most = np.array(data.efc_force), np.array(data.efc_frictionloss)
    dry = np.isin(kinds, (int(types.mjCNSTR_FRICTION_DOF), int(types.mjCNSTR_FRICTION_TENDON)))
    found = (
        (kinds == int(types.mjCNSTR_EQUALITY))
        | (dry & (np.abs(force) < most))
        | (~dry & (force != 0))
    )
    for contact in data.contact:  # those of an elliptic cone act together
        first, rows = int(contact.efc_address), int(contact.dim)
        if first >= 0 and kinds[first] == int(types.mjCNSTR_CONTACT_ELLIPTIC):
            found[first : first + rows] = force[first] != 0
    return np.asarray(found)


def softly(soft: Soft, mass: Array, damping: Array, stiffness: Array) -> tuple[Array, Array]:
    """Return C and K (nv, nv) with constraints as soft as MuJoCo has them.

    Their forces are ``D (a_ref - J a)``, so that ``(M + J^T D J) a = f + J^T D a_ref``.
    """
    if not len(soft.weight):
        return damping, stiffness
    root = 1 / np.sqrt(np.diag(mass))
    rows = soft.jacobian * root
    left = mass * np.outer(root, root) + rows.T @ (soft.weight[:, None] * rows)
    found = []
    for matrix, rate in ((damping, soft.damping), (stiffness, soft.stiffness)):
        pulled = rows.T @ ((soft.weight * rate)[:, None] * rows)
        right = matrix * np.outer(root, root) + pulled
        found.append(mass @ (root[:, None] * np.linalg.solve(left, right)) / root)
    return found[0], found[1]


def late_parts(loaded: Loaded, parts: Parts, soft: tuple[Array, Array]) -> dict[str, Late]:
    """Return what each integrator takes at the end of its step.

    MuJoCo's documentation ("Computation", numerical integration): Euler has the dampers of
    joints, ``implicit`` all forces but those of constraints, ``implicitfast`` the symmetric part
    of these without the bias forces, both within the sparsity of the mass matrix. ``discrete``
    adds springs and what constraints are, in all of their parts that dissipate or hold.
    """
    nothing = np.zeros_like(parts.damping)
    sparse = related(np.asarray(loaded.model.dof_parentid))
    smooth = parts.passive + parts.actuator
    gyroscopic = np.where(standalone(loaded), parts.bias, 0)
    dampers = holding(parts.passive) + holding(parts.actuator) + soft[0] - parts.damping
    springs = holding(parts.spring) + holding(parts.servo) + soft[1] - parts.stiffness
    joints = np.diag(np.asarray(loaded.model.dof_damping, dtype=float))
    if loaded.disabled("eulerdamp") or loaded.disabled("damper"):
        joints = nothing
    return {
        "Euler": Late(joints, nothing),
        "implicit": Late(np.where(sparse, parts.bias + smooth, 0), nothing),
        "implicitfast": Late(np.where(sparse, symmetric(smooth), 0) + gyroscopic, nothing),
        "RK4": Late(nothing, nothing),
        "discrete": Late(dampers + gyroscopic, springs),
    }


def related(parents: Array) -> Array:
    """Return whether two degrees of freedom (nv, nv) lie on one branch of the tree."""
    nv = len(parents)
    found = np.eye(nv, dtype=bool)
    for dof in range(nv):
        above = int(parents[dof])
        if above >= 0:
            found[dof] |= found[above]
            found[dof, above] = True
    return np.asarray(found | found.T)


def standalone(loaded: Loaded) -> Array:
    """Return where the rows and columns (nv, nv) of free bodies without jointed children are."""
    lib, model = loaded.mujoco, loaded.model
    found = np.zeros((model.nv, model.nv), dtype=bool)
    for joint in np.flatnonzero(model.jnt_type == int(lib.mjtJoint.mjJNT_FREE)):
        first = int(model.jnt_dofadr[joint])
        root = model.body_treeid[model.jnt_bodyid[joint]]
        if np.sum(model.body_treeid[model.dof_bodyid] == root) == 6:
            found[first : first + 6, first : first + 6] = True
    return found


def symmetric(matrix: Array) -> Array:
    """Return the symmetric part."""
    return np.asarray((matrix + matrix.T) / 2)


def holding(matrix: Array) -> Array:
    """Return the symmetric part without directions in which it is negative."""
    if not matrix.size or not np.any(matrix):
        return matrix
    scale = np.sqrt(np.maximum(np.abs(np.diag(matrix)), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(symmetric(matrix) / np.outer(scale, scale))
    kept = (vectors * np.maximum(values, 0)) @ vectors.T
    return np.asarray(kept * np.outer(scale, scale))


# A steady rotation


def steady_rotation(loaded: Loaded, joint: str, speed: float) -> State:
    """Find the steady motion in which a hinge turns and all else keeps its place beside it.

    From the first keyframe, or `qpos0`, by Newton's method; the hinge is held at its speed.

    Raises
    ------
    UsageError
        If there is no such hinge, or no such motion.
    """
    model = loaded.model
    dof = hinge(loaded, joint)
    if not np.isfinite(speed):
        raise UsageError(f"the speed of {joint} must be a finite number [rad/s], not {speed}")
    velocity = np.zeros(model.nv)
    velocity[dof] = speed
    first = loaded.states[min(1, len(loaded.states) - 1)]
    state = first._replace(keys=(f"{joint} at {speed:g} rad/s",), velocity=velocity)
    rest = Rest(Probe(loaded, state), np.delete(np.arange(model.nv), dof))
    position, excess = state.position, np.inf
    for _ in range(NEWTON_STEPS):
        excess = float(np.max(np.abs(rest.unbalanced(position)), initial=0.0))
        if excess <= SETTLED:
            break
        change = rest.change(position)
        step = np.zeros(model.nv)
        step[rest.others] = change * min(1.0, LONGEST_CHANGE / np.max(np.abs(change)))
        position = rest.probe.displaced(step, position)
    if not excess <= SETTLED:
        raise UsageError(
            f"no steady motion was found with {joint} at {speed:g} rad/s: a share of {excess:.2g} "
            "of the forces is left unbalanced; start nearer to it, with a keyframe"
        )
    for angle in TURNS:
        turned = np.zeros(model.nv)
        turned[dof] = angle
        change = np.abs(rest.unbalanced(rest.probe.displaced(turned, position)))
        if np.max(change, initial=0.0) > STEADY:
            raise UsageError(
                f"a rotation of {joint} is not steady: {angle:g} rad on, a share of "
                f"{np.max(change):.2g} of the forces is unbalanced (gravity across the axis does "
                "that)"
            )
    return state._replace(position=position)


def hinge(loaded: Loaded, joint: str) -> int:
    """Return the degree of freedom of a hinge.

    Raises
    ------
    UsageError
        If there is none of this name.
    """
    lib, model = loaded.mujoco, loaded.model
    number = lib.mj_name2id(model, loaded.object_types["joint"], joint)
    if number < 0:
        raise UnknownNameError("joint", joint, [loaded.name("joint", i) for i in range(model.njnt)])
    if model.jnt_type[number] != int(lib.mjtJoint.mjJNT_HINGE):
        raise UsageError(f"{joint} is no hinge, and only a hinge can turn steadily")
    return int(model.jnt_dofadr[number])


class Rest(NamedTuple):
    """What moves with a joint that turns steadily: a probe in that motion, and the other dofs."""

    probe: Probe
    others: Array

    def left(self, position: Array) -> tuple[Array, Array]:
        """Return forces (k,) that are not balanced, and how large they may be."""
        probe, state = self.probe, self.probe.state
        probe.put(position, state.velocity)
        inertia, passive, actuator, jacobian = probe.forces(np.zeros(probe.model.nv))
        if len(jacobian):
            raise UsageError("a model with closed loops does not rotate steadily")
        size = np.abs(inertia) + np.abs(passive) + np.abs(actuator)
        size += np.diag(probe.mass()) * max(1.0, float(np.max(state.velocity**2)))
        return (inertia - passive - actuator)[self.others], size[self.others]

    def unbalanced(self, position: Array) -> Array:
        """Return the share (k,) of the forces that is not balanced."""
        left, size = self.left(position)
        return np.asarray(left / size)

    def change(self, position: Array) -> Array:
        """Return Newton's change (k,) of the other coordinates; none of those that float freely."""
        nv = self.probe.model.nv

        def shifted(displacement: Array) -> Array:
            whole = np.zeros(nv)
            whole[self.others] = displacement
            return self.left(self.probe.displaced(whole, position))[0][None]

        slope = slopes(shifted, self.probe.scale[self.others], 1)[0]
        largest = np.max(np.abs(slope), axis=1)
        largest[largest == 0] = 1.0
        left = self.left(position)[0] / largest
        return np.asarray(np.linalg.lstsq(slope / largest[:, None], -left, rcond=RANK)[0])

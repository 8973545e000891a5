r"""Small motions about a state of an MJCF model, from MuJoCo's own forces.

``M a + C v + K q = 0`` for small departures from a state that constant forces keep at rest; in a
state of rest they vanish. Bodies that float freely are not kept at rest but fall, with the
acceleration a_0. Positions are displaced in the tangent space (`mj_integratePos`), so that ball and
free joints have as many coordinates as degrees of freedom. With the exact forces lambda_0 of closed
loops,

    F(q, v) = M(q) a_0 + bias - passive - actuator - J(q)^T lambda_0,   K = dF/dq, C = dF/dv,

and small motions that leave the loops closed are Z z with J Z = 0. As *simulated*, loops, limits,
contacts and dry friction are MuJoCo's springs and dampers, in the directions of the state. A row of
a constraint pulls with ``D (a_ref - J a)``, ``a_ref = -b v - d k r``. Its k and b follow from
``solref``: a positive time constant below two timesteps is raised to that (`refsafe`), so that

    b(h) = f b(0),   k(h) = f^2 k(0),   f = min(1, T / (2 h))

for the time constant T of the file; the integrator ``discrete`` leaves T as it is.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import null_space

from ....reference.amplification import ComplexArray, Vibrations
from ....reference.differences import by_differences, derivative
from ....reference.scene import Array
from ..tuning import NUMERICS
from .model import Flags, Loaded, NotFiniteError, State

# Constraints as springs and dampers ----------------------------------------------------------


class Soft(NamedTuple):
    """Springs and dampers that MuJoCo's constraints add to small motions in a state.

    Attributes
    ----------
    jacobian : array (rows, nv)
    weight, damping, stiffness : array (rows,)
        1 / R, b [1/s] and d k [1/s^2] of each row, before time constants are raised.
    constant : array (rows,)
        Time constants T [s] that may be raised; 0 for all others.
    dry : array (rows,)
        True for dry friction that sticks.
    names : tuple of str
    contacts, limits : int
        Number of active ones.
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
        """Return the rows as MuJoCo uses them at a step [s]."""
        raised = (self.constant > 0) & (self.constant < 2 * step)
        share = np.where(raised, self.constant / (2 * step), 1.0)
        return self._replace(damping=share * self.damping, stiffness=share**2 * self.stiffness)

    def sliding(self) -> Soft:
        """Return the rows without dry friction, which then slides."""
        parts = ("jacobian", "weight", "damping", "stiffness", "constant", "dry")
        left = {part: getattr(self, part)[~self.dry] for part in parts}
        names = tuple(name for name, dry in zip(self.names, self.dry, strict=True) if not dry)
        return self._replace(**left, names=names)

    @property
    def raised_from(self) -> float:
        """Step [s] from which on a time constant is raised; infinite if none is."""
        return float(np.min(self.constant[self.constant > 0], initial=np.inf)) / 2


def jacobian_rows(model: Any, data: Any) -> Array:
    """Return the Jacobian (nefc, nv) of all constraints; its buffer may be longer."""
    count = int(data.nefc)
    return np.array(data.efc_J)[: count * model.nv].reshape(count, model.nv)


def soft_rows(loaded: Loaded, state: State) -> Soft:
    """Return the active constraints of a state, linearised there."""
    model, types = loaded.sharp(), loaded.mujoco.mjtConstraint
    data = loaded.data(state, model)
    loaded.mujoco.mj_forward(model, data)
    nefc = int(data.nefc)
    kinds = np.array(data.efc_type)[:nefc]
    rows = acting(loaded, data, kinds)
    jacobian, weight = jacobian_rows(model, data)[rows], np.array(data.efc_D)[:nefc][rows]
    names = tuple(row_name(loaded, data, int(row), int(kinds[row])) for row in np.flatnonzero(rows))
    contacts = sum(contact.efc_address >= 0 for contact in data.contact)
    long = NUMERICS.long_step
    most = springs(loaded, state, long)
    spring, damper, impedance, _ = springs(loaded, state, NUMERICS.short_step)[rows].T
    with np.errstate(all="ignore"):
        share = np.nan_to_num(most[rows, 1] / damper, nan=1.0, posinf=1.0)
    limits = [types.mjCNSTR_LIMIT_JOINT, types.mjCNSTR_LIMIT_TENDON]
    return Soft(
        jacobian=jacobian,
        weight=weight,
        damping=damper,
        stiffness=impedance * spring,
        constant=np.where(np.abs(share - 1) > NUMERICS.same_damper, 2 * long * share, 0.0),
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
    """Return the rows that are dry friction of joints and tendons."""
    types = loaded.mujoco.mjtConstraint
    dry = (int(types.mjCNSTR_FRICTION_DOF), int(types.mjCNSTR_FRICTION_TENDON))
    return np.asarray(np.isin(kinds, dry))


def row_name(loaded: Loaded, data: Any, row: int, kind: int) -> str:
    """Return the name of the constraint to which a row belongs."""
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
    """Return the rows (nefc,) that yield in proportion to the load, neither open nor sliding."""
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
    """Return C or K (nv, nv) with MuJoCo's soft constraints, by their b or d k.

    Their forces are ``D (a_ref - J a)``, so that ``(M + J^T D J) a = f + J^T D a_ref``.
    """
    if not len(soft.weight):
        return matrix
    root = 1 / np.sqrt(np.diag(mass))
    scale, rows = np.outer(root, root), soft.jacobian * root
    left = mass * scale + rows.T @ (soft.weight[:, None] * rows)
    right = matrix * scale + rows.T @ ((soft.weight * rate)[:, None] * rows)
    return np.asarray(mass @ (root[:, None] * np.linalg.solve(left, right)) / root)


# Small motions --------------------------------------------------------------------------------


class LinearMotion(NamedTuple):
    """Small motions, and the parts that an integrator treats implicitly; arrays (..., n, n)."""

    mass: Array
    damping: Array
    stiffness: Array
    late_damping: Array
    late_stiffness: Array

    def vibrations(self, step: float) -> Vibrations:
        """Return the vibrations on which semi-implicit Euler with a step [s] is this integrator.

        An implicit stiffness K_1 acts within a step h as an implicit damping h K_1, and the total
        damping grows by the same: ``(M + h C_1 + h^2 K_1) v+ = (M - h (C - C_1)) v - h K q``.
        """
        more = step * self.late_stiffness
        return Vibrations(self.mass, self.damping + more, self.stiffness, self.late_damping + more)


class Parts(NamedTuple):
    """Parts (nv, nv) of the damping and the stiffness, and their sums."""

    bias: Array
    passive: Array
    actuator: Array
    spring: Array
    servo: Array
    damping: Array
    stiffness: Array


class Linear(NamedTuple):
    """Small motions about a state.

    As simulated, they have all of MuJoCo's constraints, which are soft, see `motion`; with loops
    closed exactly, without contacts, limits and dry friction, they are mass, damping and stiffness
    in the directions ``free``.

    Attributes
    ----------
    loaded : Loaded
    mass : array (nv, nv)
    parts : Parts
        Damping and stiffness, and their parts.
    rows : Soft
        Active constraints of the state.
    free : array (nv, k)
        Directions in which closed loops let it move.
    acceleration : array (nv,)
        Accelerations in the state, loops closed exactly.
    """

    loaded: Loaded
    mass: Array
    parts: Parts
    rows: Soft
    free: Array
    acceleration: Array

    @property
    def closed(self) -> int:
        """Number of independent directions that closed loops block."""
        return int(self.free.shape[0] - self.free.shape[1])

    def motion(self, integrator: str, step: float, sliding: bool = False) -> LinearMotion:
        """Return the motions, with the parts that an integrator treats implicitly in a step [s].

        MuJoCo's documentation ("Computation", numerical integration): Euler treats the dampers of
        joints implicitly, ``implicit`` all forces but those of constraints, ``implicitfast`` the
        symmetric part of these without the bias forces, both within the sparsity of the mass
        matrix. ``discrete`` adds springs and constraints, in all parts that dissipate or resist.
        ``sliding`` leaves out dry friction that sticks.
        """
        loaded, mass, parts = self.loaded, self.mass, self.parts
        soft = self.rows.sliding() if sliding else self.rows
        if integrator != "discrete" and not loaded.disabled("refsafe"):
            soft = soft.at(step)
        damping = with_soft_rows(soft, mass, parts.damping, soft.damping)
        stiffness = with_soft_rows(soft, mass, parts.stiffness, soft.stiffness)
        late = late_parts(loaded, parts, integrator)
        if integrator == "discrete":
            late = (late[0] + damping - parts.damping, late[1] + stiffness - parts.stiffness)
        return LinearMotion(mass, damping, stiffness, *late)

    def setting_row(self, vector: ComplexArray, omega: float, sliding: bool) -> str | None:
        """Return the constraint that resists a mode (nv,) most, if constraints dominate."""
        soft = self.rows.sliding() if sliding else self.rows
        if not len(soft.weight):
            return None
        late = [
            with_soft_rows(soft, self.mass, x, rate)
            for x, rate in (
                (self.parts.damping, soft.damping),
                (self.parts.stiffness, soft.stiffness),
            )
        ]
        own = (self.parts.damping, self.parts.stiffness)
        all_of, of_rows = (
            sum(
                scale * abs(np.vdot(vector, matrix @ vector))
                for matrix, scale in zip(matrices, (omega, 1.0), strict=True)
            )
            for matrices in (late, [a - b for a, b in zip(late, own, strict=True)])
        )
        if not of_rows > NUMERICS.constraint_share * all_of:
            return None
        pulls = np.abs(soft.jacobian @ vector) ** 2 * soft.weight
        return soft.names[int(np.argmax(pulls * (omega * soft.damping + soft.stiffness)))]

    def raised_from(self, integrator: str) -> float:
        """Return the step [s] from which on constraints depend on the step."""
        raises = integrator != "discrete" and not self.loaded.disabled("refsafe")
        return self.rows.raised_from if raises else np.inf


def late_parts(loaded: Loaded, parts: Parts, integrator: str) -> tuple[Array, Array]:
    """Return the damping and stiffness (nv, nv) that an integrator treats implicitly.

    Constraints are not among them, see `Linear.motion`.
    """
    nothing = np.zeros_like(parts.damping)
    sparse = related(np.asarray(loaded.model.dof_parentid))
    smooth = parts.passive + parts.actuator
    gyroscopic = np.where(standalone(loaded), parts.bias, 0)
    if integrator == "Euler":
        off = loaded.disabled("eulerdamp") or loaded.disabled("damper")
        return nothing if off else np.diag(np.array(loaded.model.dof_damping, float)), nothing
    if integrator == "implicit":
        return np.where(sparse, parts.bias + smooth, 0), nothing
    if integrator == "implicitfast":
        return np.where(sparse, (smooth + smooth.T) / 2, 0) + gyroscopic, nothing
    if integrator == "discrete":
        dampers = nonnegative_part(parts.passive) + nonnegative_part(parts.actuator)
        return dampers + gyroscopic, nonnegative_part(parts.spring) + nonnegative_part(parts.servo)
    return nothing, nothing


def related(parents: Array) -> Array:
    """Return True for pairs of degrees of freedom (nv, nv) on one branch of the tree."""
    branch = np.eye(len(parents), dtype=bool)
    for dof, parent in enumerate(parents):
        if parent >= 0:
            branch[dof] |= branch[parent]
    return np.asarray(branch | branch.T)


def standalone(loaded: Loaded) -> Array:
    """Return True for rows and columns (nv, nv) of free bodies without jointed children."""
    m = loaded.model
    same = m.body_treeid[m.dof_bodyid][:, None] == m.body_treeid[m.dof_bodyid]
    free = loaded.of_kind("jnt_type", "free")[m.dof_jntid]
    return np.asarray(same & free & (np.sum(same, axis=1) == 6))


def nonnegative_part(matrix: Array) -> Array:
    """Return the symmetric part without directions in which it is negative."""
    if not matrix.size or not np.any(matrix):
        return matrix
    half = (matrix + matrix.T) / 2
    own, rows = np.abs(np.diag(half)), np.max(np.abs(half), axis=1)
    own = np.where(
        own > NUMERICS.rank * rows, own, rows
    )  # a force that turns along has no diagonal
    scale = np.sqrt(np.where(own > 0, own, 1.0))
    values, vectors = np.linalg.eigh(half / np.outer(scale, scale))
    return np.asarray((vectors * np.maximum(values, 0)) @ vectors.T * np.outer(scale, scale))


class LinearProbe:
    """Forces near a state, with loops as the only constraints.

    Parameters
    ----------
    loaded : Loaded
    state : State
    """

    def __init__(self, loaded: Loaded, state: State) -> None:
        self.lib, self.state = loaded.mujoco, state
        self.model = loaded.sharp("contact", "limit", "frictionloss")
        self.data = loaded.data(state, self.model)
        self.lib.mj_fwdPosition(self.model, self.data)
        self.closed = tuple(self.loop_rows())
        size = min(1.0, float(loaded.model.stat.extent)) or 1.0
        self.scale = np.where(loaded.sliding_dofs, size, 1.0)
        self.lift_limits()

    def lift_limits(self) -> None:
        """Lift the limits that actuator forces do not reach in the state, but in a difference."""
        m, data = self.model, self.data
        self.forces(np.zeros(m.nv))
        on_joints = data.qfrc_actuator[m.jnt_dofadr]
        outputs = getattr(m, "actuator_outnum", 1)  # an actuator may have several since 4.0
        for limited, bounds, force, count in (
            (m.actuator_forcelimited, m.actuator_forcerange, data.actuator_force, outputs),
            (m.jnt_actfrclimited, m.jnt_actfrcrange, on_joints, 1),
        ):
            owner = np.repeat(np.arange(len(bounds)), count)
            reached = (force <= bounds[owner, 0]) | (bounds[owner, 1] <= force)
            limited[np.setdiff1d(owner, owner[reached])] = 0

    def put(self, position: Array, velocity: Array) -> None:
        """Set a state."""
        self.data.qpos[:], self.data.qvel[:] = position, velocity

    def displaced(self, direction: Array, position: Array | None = None) -> Array:
        """Return positions moved along a direction (nv,) of the tangent space."""
        moved: Array = np.array(self.state.position if position is None else position)
        self.lib.mj_integratePos(self.model, moved, direction, 1.0)
        return moved

    def forces(self, acceleration: Array) -> tuple[Array, Array, Array, Array]:
        """Return inertia and bias forces (nv,), passive and actuator forces, and J (rows, nv).

        The rows of J are those of closed loops in the state of the probe.
        """
        data = self.data
        data.qacc[:] = acceleration
        self.lib.mj_inverse(self.model, data)
        self.lib.mj_fwdActuation(self.model, data)
        inertia = data.qfrc_inverse + data.qfrc_constraint + data.qfrc_passive
        rows, open_row = self.loop_rows(), np.zeros(self.model.nv)
        jacobian = np.reshape([rows.get(row, open_row) for row in self.closed], (-1, len(open_row)))
        return inertia, data.qfrc_passive.copy(), np.array(data.qfrc_actuator), jacobian

    def loop_rows(self) -> dict[tuple[int, int], Array]:
        """Return the Jacobian's row (nv,) of each equality and component at the current data.

        MuJoCo leaves out an equality whose Jacobian is zero, so that the rows vary with the
        position; `forces` keeps those of the state.
        """
        owners = np.array(self.data.efc_id)[: self.data.ne]
        components = np.arange(len(owners)) - np.searchsorted(owners, owners)
        keys = zip(owners.tolist(), components.tolist(), strict=True)
        return dict(zip(keys, jacobian_rows(self.model, self.data), strict=False))

    def mass(self) -> Array:
        """Return the mass matrix (nv, nv) at the current data."""
        mass = np.empty((self.model.nv, self.model.nv))
        for row, unit in zip(
            mass, np.eye(len(mass)), strict=True
        ):  # the arguments of mj_fullM depend on the version
            self.lib.mj_mulM(self.model, self.data, row, unit)
        return mass


class Solved(NamedTuple):
    """Accelerations (nv,) and forces (rows,) of loops that are closed exactly."""

    acceleration: Array
    multipliers: Array
    jacobian: Array
    mass: Array


def solved(probe: LinearProbe) -> Solved:
    """Solve for the accelerations in the state of a probe."""
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
    inverse = np.linalg.pinv(
        rows @ np.linalg.solve(scaled, rows.T), rcond=NUMERICS.rank, hermitian=True
    )
    forces = -inverse @ (rows @ free + curvature(probe))
    return Solved(root * (free + np.linalg.solve(scaled, rows.T @ forces)), forces, jacobian, mass)


def curvature(probe: LinearProbe) -> Array:
    """Return ``dJ/dt v`` (rows,) in the state of a probe."""
    velocity = probe.state.velocity
    step = NUMERICS.difference / (np.max(np.abs(velocity), initial=0.0) or 1.0)

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
    if loaded.model.opt.density or loaded.model.opt.viscosity:
        # drag as |v| v has no slope at rest, where differences show one in proportion to their step
        half = slopes(by_velocity, probe.scale, step=NUMERICS.difference / 2)
        bias, passive, actuator = 2 * half - np.array([bias, passive, actuator])
    damping = bias + passive + actuator
    parts = Parts(bias, passive, actuator, spring, servo, damping, stiffness)
    if not all(np.all(np.isfinite(matrix)) for matrix in parts):
        raise NotFiniteError(f"forces near the state {state.name!r} are not finite")
    rows = soft_rows(loaded, state)
    return Linear(loaded, at.mass, parts, rows, unconstrained(at), at.acceleration)


def falling(loaded: Loaded, jacobian: Array) -> Array:
    """Return the accelerations (nv,) of bodies that float freely in gravity, outside of loops."""
    m, accelerations = loaded.model, np.zeros(loaded.model.nv)
    dofs = m.jnt_dofadr[loaded.of_kind("jnt_type", "free")][:, None] + np.arange(3)
    tied = np.any(jacobian[:, dofs], axis=(0, 2)) | loaded.disabled("gravity")
    accelerations[dofs[~tied]] = m.opt.gravity
    return accelerations


def slopes(
    function: Callable[[Array], Array],
    scale: Array,
    cancelled: Array | float = 0.0,
    step: float = NUMERICS.difference,
) -> Array:
    """Return the derivatives (count, n, n) of a function (count, n) of a displacement (n,), at 0.

    Derivatives within the round-off of the values, and of ``cancelled`` terms (n,), are 0.
    """
    sizes = []

    def at_places(x: Array) -> Array:
        values = np.array([function(scale * place) for place in x.T])
        sizes.append(np.max(np.abs(values), axis=0))
        return values.reshape(len(values), -1).T

    slope = by_differences(at_places, np.zeros(len(scale)), step=step)[1] / scale
    noise = (
        NUMERICS.difference_roundoff * np.maximum(sizes[0], cancelled)[:, :, None] / (step * scale)
    )
    slope = slope.reshape(noise.shape)
    return np.where(np.abs(slope) > noise, slope, 0.0)


def unconstrained(at: Solved) -> Array:
    """Return the directions (nv, k) in which closed loops let a model move."""
    root = 1 / np.sqrt(np.diag(at.mass))
    rows = at.jacobian * root
    norms = np.linalg.norm(rows, axis=1)
    rows = rows[norms > 0] / norms[norms > 0, None]
    return (
        np.asarray(root[:, None] * null_space(rows, rcond=NUMERICS.rank))
        if len(rows)
        else np.eye(len(root))
    )

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
from typing import NamedTuple

import numpy as np
from scipy.linalg import null_space

from ....reference.amplification import ComplexArray
from ....reference.differences import by_differences, derivative
from ....reference.scene import Array
from ..spectrum import LinearMotion
from .model import Loaded, NotFiniteError, State
from .rows import Soft, jacobian_rows, soft_rows, with_soft_rows


class Parts(NamedTuple):
    """Parts (nv, nv) of the damping and the stiffness, and the whole of each."""

    bias: Array
    passive: Array
    actuator: Array
    spring: Array
    servo: Array
    damping: Array
    stiffness: Array


MOSTLY = 0.5
"""Share of what resists a mode from which on constraints set it."""


class Simulated(NamedTuple):
    """Small motions as MuJoCo's integrators see them: mass (nv, nv), forces, and constraints."""

    loaded: Loaded
    mass: Array
    parts: Parts
    rows: Soft

    def motion(self, integrator: str, step: float, sliding: bool = False) -> LinearMotion:
        """Return them with what an integrator takes at the end of a step [s].

        MuJoCo's documentation ("Computation", numerical integration): Euler has the dampers of
        joints, ``implicit`` all forces but those of constraints, ``implicitfast`` the symmetric
        part of these without the bias forces, both within the sparsity of the mass matrix.
        ``discrete`` adds springs and what constraints are, in all of their parts that dissipate or
        hold. ``sliding`` leaves out dry friction that holds.
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
        """Return the constraint that holds most of a mode (nv,), if constraints hold most of it."""
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
        if not of_rows > MOSTLY * all_of:
            return None
        pulls = np.abs(soft.jacobian @ vector) ** 2 * soft.weight
        return soft.names[int(np.argmax(pulls * (omega * soft.damping + soft.stiffness)))]

    def raised_from(self, integrator: str) -> float:
        """Return the step [s] from which on constraints depend on the step."""
        raises = integrator != "discrete" and not self.loaded.disabled("refsafe")
        return self.rows.raised_from if raises else np.inf


def late_parts(loaded: Loaded, parts: Parts, integrator: str) -> tuple[Array, Array]:
    """Return the damping and stiffness (nv, nv) that an integrator takes late, constraints apart.

    See `Simulated.motion`.
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
        dampers = holding(parts.passive) + holding(parts.actuator)
        return dampers + gyroscopic, holding(parts.spring) + holding(parts.servo)
    return nothing, nothing


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
    half = (matrix + matrix.T) / 2
    own, rows = np.abs(np.diag(half)), np.max(np.abs(half), axis=1)
    own = np.where(own > RANK * rows, own, rows)  # a force that turns along has no diagonal
    scale = np.sqrt(np.where(own > 0, own, 1.0))
    values, vectors = np.linalg.eigh(half / np.outer(scale, scale))
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
    simulated : Simulated
        With all of MuJoCo's constraints, as soft as they are, and what integrators take late.
    acceleration : array (nv,)
        In the state, loops closed exactly.
    rows : Soft
        Constraints that give way in the state.
    closed : int
        Independent directions that closed loops take away.
    """

    mass: Array
    damping: Array
    stiffness: Array
    free: Array
    simulated: Simulated
    acceleration: Array
    rows: Soft
    closed: int


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
        self.lib.mj_fwdPosition(self.model, self.data)
        self.closed = tuple(self.loop_rows())
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
        """Return inertia and bias forces (nv,), passive and actuator forces, and J (rows, nv).

        The rows of J are those that closed loops have in the probe's state.
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
        """Return the Jacobian's row (nv,) of each equality and component, where the data is.

        MuJoCo leaves out an equality whose Jacobian is zero, so that rows come and go with the
        position; `forces` keeps those that the state has.
        """
        owners = np.array(self.data.efc_id)[: self.data.ne]
        components = np.arange(len(owners)) - np.searchsorted(owners, owners)
        keys = zip(owners.tolist(), components.tolist(), strict=True)
        return dict(zip(keys, jacobian_rows(self.model, self.data), strict=False))

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
    if loaded.model.opt.density or loaded.model.opt.viscosity:
        # drag as |v| v has no slope at rest, where differences see one in proportion to their step
        half = slopes(by_velocity, probe.scale, step=DIFFERENCE / 2)
        bias, passive, actuator = 2 * half - np.array([bias, passive, actuator])
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
        simulated=Simulated(loaded, at.mass, parts, rows),
        acceleration=at.acceleration,
        rows=rows,
        closed=loaded.model.nv - free.shape[1],
    )


def falling(loaded: Loaded, jacobian: Array) -> Array:
    """Return the accelerations (nv,) of what floats freely in gravity, no loop tying it."""
    m, accelerations = loaded.model, np.zeros(loaded.model.nv)
    dofs = m.jnt_dofadr[loaded.of_kind("jnt_type", "free")][:, None] + np.arange(3)
    tied = np.any(jacobian[:, dofs], axis=(0, 2)) | loaded.disabled("gravity")
    accelerations[dofs[~tied]] = m.opt.gravity
    return accelerations


def slopes(
    function: Callable[[Array], Array],
    scale: Array,
    cancelled: Array | float = 0.0,
    step: float = DIFFERENCE,
) -> Array:
    """Return the derivatives (count, n, n) of a function (count, n) of a displacement (n,), at 0.

    What may be rounding is 0: of the values, and of what has cancelled in them (n,).
    """
    sizes = []

    def at_places(x: Array) -> Array:
        values = np.array([function(scale * place) for place in x.T])
        sizes.append(np.max(np.abs(values), axis=0))
        return values.reshape(len(values), -1).T

    slope = by_differences(at_places, np.zeros(len(scale)), step=step)[1] / scale
    noise = ROUNDING * np.maximum(sizes[0], cancelled)[:, :, None] / (step * scale)
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

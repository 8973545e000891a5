"""Facts about an MJCF model: its tree, its counts, its options, and the geoms that can touch."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...documents.fields import Number
from ..tuning import EFFORT, NUMERICS
from .model import Loaded

DOFS = {"free": 6, "ball": 3, "slide": 1, "hinge": 1}
"""Type of a joint -> number of degrees of freedom."""

COUNTED = {
    "nq": "nq",
    "nv": "nv",
    "bodies": "nbody",
    "joints": "njnt",
    "geoms": "ngeom",
    "sites": "nsite",
    "tendons": "ntendon",
    "equalities": "neq",
    "actuators": "nu",
    "sensors": "nsensor",
    "keyframes": "nkey",
    "meshes": "nmesh",
    "flexes": "nflex",
}
"""Name of a count -> field of ``MjModel``; the world does not count as a body."""

INTEGRATORS = ("Euler", "implicit", "implicitfast", "RK4", "discrete")
"""Integrators as MJCF spells them; old releases of MuJoCo lack the last."""


@dataclass(frozen=True)
class JointFacts:
    """A joint.

    Attributes
    ----------
    name : str
        name, or kind and number if it has none
    kind : {"free", "ball", "slide", "hinge"}
        type
    dofs : int
        degrees of freedom
    axis : tuple (3,) or None
        axis of a slide or hinge in the frame of the body; null for other joints
    stiffness : float
        stiffness [N/m, Nm/rad]; null if not finite
    damping : float
        damping [Ns/m, Nms/rad] of the first degree of freedom; null if not finite
    armature : float
        armature [kg, kg m^2]; null if not finite
    range : tuple (2,) or None
        limits [m, rad]; null if there are none
    """

    name: str
    kind: str
    dofs: int
    axis: tuple[float, ...] | None
    stiffness: Number
    damping: Number
    armature: Number
    range: tuple[Number, ...] | None


@dataclass(frozen=True)
class BodyFacts:
    """A body.

    Attributes
    ----------
    name : str
        name, or kind and number if it has none
    parent : str
        name of the parent, or world
    depth : int
        number of bodies between it and the world
    mass : float
        mass [kg]
    centre : tuple (3,)
        centre of mass in the frame of the body [m]
    inertia : tuple (3,)
        principal moments of inertia [kg m^2]
    joints : tuple of JointFacts
        joints between it and its parent
    """

    name: str
    parent: str
    depth: int
    mass: float
    centre: tuple[float, ...]
    inertia: tuple[float, ...]
    joints: tuple[JointFacts, ...]


@dataclass(frozen=True)
class Options:
    """Options with which the file is simulated.

    Attributes
    ----------
    integrator : str
        integrator, as MJCF spells it
    timestep : float
        timestep [s]
    solver : str
        solver of constraints
    tolerance : float
        tolerance of the solver
    iterations : int
        largest number of iterations of the solver
    cone : str
        type of the friction cone
    jacobian : str
        dense, sparse or auto
    gravity : tuple (3,)
        gravity [m/s^2]; 0 if it is switched off
    energy : bool
        true if energy is computed
    autoreset : bool
        true if a run that diverges is reset to its start
    contact : bool
        true if contacts are computed
    refsafe : bool
        true if constraints with time constants below two timesteps are softened
    """

    integrator: str
    timestep: float
    solver: str
    tolerance: float
    iterations: int
    cone: str
    jacobian: str
    gravity: tuple[float, ...]
    energy: bool
    autoreset: bool
    contact: bool
    refsafe: bool


@dataclass(frozen=True)
class Facts:
    """Content of a model.

    Attributes
    ----------
    file : str
        the file, as it was given
    files : tuple of str
        the file, and the files that it includes
    name : str
        name of the model; empty if the file gives none
    options : Options
        options with which the file is simulated
    counts : mapping of str to int
        number of positions nq, degrees of freedom nv, bodies, joints, geoms, ...
    mass : float
        mass of all bodies [kg]
    size : float
        MuJoCo's extent [m]
    bodies : tuple of BodyFacts
        bodies in the order of the tree, without the world
    """

    file: str
    files: tuple[str, ...]
    name: str
    options: Options
    counts: Mapping[str, int]
    mass: float
    size: float
    bodies: tuple[BodyFacts, ...]


def facts(loaded: Loaded, file: str) -> Facts:
    """Return the content of a model that was read from a file, as it was given."""
    m, lib = loaded.model, loaded.mujoco
    counts = {name: int(getattr(m, field)) for name, field in COUNTED.items()}
    counts["actuators"] = len(m.actuator_trntype)
    depths = [-1]  # the world; a parent comes before its children
    for parent in m.body_parentid[1:]:
        depths.append(depths[parent] + 1)
    return Facts(
        file=file,
        files=loaded.source.files,
        name=loaded.source.root.attributes.get("model", ""),
        options=Options(
            integrator=integrator(loaded),
            timestep=float(m.opt.timestep),
            solver=word(lib.mjtSolver, m.opt.solver),
            tolerance=float(m.opt.tolerance),
            iterations=int(m.opt.iterations),
            cone=word(lib.mjtCone, m.opt.cone).lower(),
            jacobian=word(lib.mjtJacobian, m.opt.jacobian).lower(),
            gravity=(0.0, 0.0, 0.0) if loaded.disabled("gravity") else floats(m.opt.gravity),
            energy=loaded.enabled("energy"),
            autoreset=not loaded.disabled("autoreset"),
            contact=not (loaded.disabled("contact") or loaded.disabled("constraint")),
            refsafe=not loaded.disabled("refsafe"),
        ),
        counts=counts | {"bodies": m.nbody - 1},
        mass=float(np.sum(m.body_mass[1:])),
        size=float(m.stat.extent),
        bodies=tuple(
            BodyFacts(
                name=loaded.name("body", i),
                parent=loaded.name("body", m.body_parentid[i]) if depths[i] else "world",
                depth=depths[i],
                mass=float(m.body_mass[i]),
                centre=floats(m.body_ipos[i]),
                inertia=floats(m.body_inertia[i]),
                joints=tuple(joint(loaded, int(j)) for j in np.flatnonzero(m.jnt_bodyid == i)),
            )
            for i in range(1, m.nbody)
        ),
    )


def joint(loaded: Loaded, number: int) -> JointFacts:
    """Return a joint."""
    m = loaded.model
    kind = word(loaded.mujoco.mjtJoint, m.jnt_type[number]).lower()
    dof = int(m.jnt_dofadr[number])
    return JointFacts(
        name=loaded.name("joint", number),
        kind=kind,
        dofs=DOFS[kind],
        axis=floats(m.jnt_axis[number]) if DOFS[kind] == 1 else None,
        stiffness=float(m.jnt_stiffness[number]),
        damping=float(m.dof_damping[dof]),
        armature=float(m.dof_armature[dof]),
        range=floats(m.jnt_range[number]) if m.jnt_limited[number] else None,
    )


def integrator(loaded: Loaded) -> str:
    """Return the integrator of the file, as MJCF spells it."""
    name = word(loaded.mujoco.mjtIntegrator, loaded.model.opt.integrator)
    return next((one for one in INTEGRATORS if one.upper() == name), name.lower())


def integrators(loaded: Loaded) -> list[str]:
    """Return the integrators of this release of MuJoCo."""
    kinds = loaded.mujoco.mjtIntegrator
    return [name for name in INTEGRATORS if hasattr(kinds, f"mjINT_{name.upper()}")]


def word(kinds: Any, value: int) -> str:
    """Return the last word of the name of an enumeration's value."""
    return str(kinds(int(value)).name).rpartition("_")[2]


def floats(values: Any) -> tuple[float, ...]:
    """Return plain floats, without the sign of a zero."""
    return tuple(float(value) + 0.0 for value in values)


# Which geoms can touch each other, by MuJoCo's filters ---------------------------------------


def can_touch(loaded: Loaded, contact: bool) -> np.ndarray:
    """Return the geoms (ngeom,) that can touch another one; none if contact is off."""
    m = loaded.model
    if not contact:
        return np.zeros(m.ngeom, dtype=bool)
    geoms = np.any(partners(loaded, excluded=True), axis=1)[kinds_of_geom(loaded)[1]]
    geoms[np.concatenate([m.pair_geom1, m.pair_geom2]).astype(int)] = True
    if m.nflex:  # a flex is not a geom, and may touch all of them
        geoms |= (m.geom_contype | m.geom_conaffinity) != 0
    return np.asarray(geoms)


def kinds_of_geom(loaded: Loaded) -> tuple[np.ndarray, np.ndarray]:
    """Return kinds (k, 3) of geoms: body, contype, conaffinity; and the kind of each (ngeom,)."""
    m = loaded.model
    columns = np.stack([m.geom_bodyid, m.geom_contype, m.geom_conaffinity], axis=1)
    kinds, which = np.unique(columns, axis=0, return_inverse=True)
    return kinds, which.reshape(-1)


def exclusions(loaded: Loaded) -> list[tuple[int, int]]:
    """Return the pairs of bodies that are excluded from contact."""
    return [divmod(int(pair), 1 << 16) for pair in loaded.model.exclude_signature]


def partners(loaded: Loaded, excluded: bool) -> np.ndarray:
    """Return the pairs of kinds of geoms (k, k) that can touch, by MuJoCo's filters."""
    m = loaded.model
    bodies, types, affinities = kinds_of_geom(loaded)[0].T
    welded = m.body_weldid[bodies]
    matching = (types[:, None] & affinities) != 0
    pairs = (matching | matching.T) & (welded[:, None] != welded)
    if not loaded.disabled("filterparent"):
        child = m.body_weldid[m.body_parentid[welded]][:, None] == welded
        child &= (welded != 0) & (welded[:, None] != 0)
        pairs &= ~(child | child.T)
    for one, other in exclusions(loaded) if excluded else ():
        both = (bodies[:, None] == one) & (bodies == other)
        pairs &= ~(both | both.T)
    return np.asarray(pairs)


def meetings(loaded: Loaded) -> dict[tuple[int, int], int]:
    """Count the random positions, of `EffortLimits.draws`, in which two geoms of one tree overlap.

    Positions lie within the ranges of the joints; pairs that never overlap are left out.
    """
    m, lib, draw = loaded.model, loaded.mujoco, np.random.default_rng(2)
    if not m.nv or m.nv > EFFORT.max_overlap_dofs:
        return {}
    data, size = lib.MjData(m), float(m.stat.extent)
    moved = np.flatnonzero(loaded.of_kind("jnt_type", "hinge", "slide"))
    free = np.where(loaded.of_kind("jnt_type", "hinge"), np.pi, 0.1 * size)
    low, high = np.where(m.jnt_limited != 0, np.asarray(m.jnt_range).T, [-free, free])
    counts: Counter[tuple[int, int]] = Counter()
    for _ in range(EFFORT.draws):
        data.qpos[:] = m.qpos0
        data.qpos[m.jnt_qposadr[moved]] = draw.uniform(low[moved], high[moved])
        lib.mj_kinematics(m, data)
        lib.mj_comPos(m, data)
        lib.mj_collision(m, data)
        counts.update(
            {
                (int(contact.geom[0]), int(contact.geom[1]))
                for contact in data.contact
                if -float(contact.dist) > NUMERICS.deep * size and contact.geom[0] >= 0
            }
        )
    trees = m.body_treeid[m.geom_bodyid]
    return {pair: n for pair, n in counts.items() if trees[pair[0]] == trees[pair[1]] >= 0}

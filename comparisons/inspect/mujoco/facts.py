"""What is in an MJCF model: its tree, its counts, its options, and which geoms can touch."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...documents.fields import Number
from .model import Loaded

DOFS = {"free": 6, "ball": 3, "slide": 1, "hinge": 1}
"""Type of a joint -> its degrees of freedom."""

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
"""Name of a count -> MuJoCo's; the world is no body here."""

DRAWS = 40
"""Random positions within the ranges of joints."""

DEEP = 1e-3
"""How deep bodies may lie in each other, in the model's size."""

MOST_DOFS = 200
"""With more degrees of freedom none are drawn."""

INTEGRATORS = ("Euler", "implicit", "implicitfast", "RK4", "discrete")
"""As MJCF spells them; an old MuJoCo lacks the last."""


@dataclass(frozen=True)
class JointFacts:
    """A joint.

    Attributes
    ----------
    name : str
        name, or kind and number
    kind : {"free", "ball", "slide", "hinge"}
        type
    dofs : int
        degrees of freedom
    axis : tuple (3,) or None
        of a slide or hinge, in the body's frame; null of the others
    stiffness : float
        [N/m, Nm/rad]; null if not finite
    damping : float
        [Ns/m, Nms/rad], of its first degree of freedom; null if not finite
    armature : float
        [kg, kg m^2]; null if not finite
    range : tuple (2,) or None
        limits [m, rad]; null without any
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
        name, or kind and number
    parent : str
        name of the parent; world
    depth : int
        bodies between it and the world
    mass : float
        [kg]
    centre : tuple (3,)
        centre of mass in its frame [m]
    inertia : tuple (3,)
        principal moments of inertia [kg m^2]
    joints : tuple of JointFacts
        its joints
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
    """How the file is simulated.

    Attributes
    ----------
    integrator : str
        as MJCF spells it
    timestep : float
        [s]
    solver : str
        of constraints
    tolerance : float
        of the solver
    iterations : int
        of the solver
    cone : str
        of friction
    jacobian : str
        dense, sparse or auto
    gravity : tuple (3,)
        [m/s^2]; 0 if it is switched off
    energy : bool
        whether energy is computed
    autoreset : bool
        whether a run that fails starts anew
    contact : bool
        whether bodies can touch at all
    refsafe : bool
        whether constraints that are faster than two timesteps are softened
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
    """What is in a model.

    Attributes
    ----------
    name : str
        Of the model, in the file.
    bodies : tuple of Body
        In the order of the tree, without the world.
    counts : dict of str to int
    mass : float
        Of all bodies [kg].
    size : float
        MuJoCo's ``extent`` [m].
    options : Options
    """

    name: str
    bodies: tuple[BodyFacts, ...]
    counts: dict[str, int]
    mass: float
    size: float
    options: Options


def facts(loaded: Loaded) -> Facts:
    """Return what is in a model."""
    m = loaded.model
    counts = {name: int(getattr(m, field)) for name, field in COUNTED.items()}
    depths = [-1]  # of the world; a parent comes before its children
    for parent in m.body_parentid[1:]:
        depths.append(depths[parent] + 1)
    return Facts(
        name=loaded.source.root.attributes.get("model", ""),
        bodies=tuple(body(loaded, number, depths[number]) for number in range(1, m.nbody)),
        counts=counts | {"bodies": m.nbody - 1},
        mass=float(np.sum(m.body_mass[1:])),
        size=float(m.stat.extent),
        options=options(loaded),
    )


def body(loaded: Loaded, number: int, depth: int) -> BodyFacts:
    """Return a body with its joints."""
    m = loaded.model
    return BodyFacts(
        name=loaded.name("body", number),
        parent=loaded.name("body", m.body_parentid[number]) if depth else "world",
        depth=depth,
        mass=float(m.body_mass[number]),
        centre=floats(m.body_ipos[number]),
        inertia=floats(m.body_inertia[number]),
        joints=tuple(joint(loaded, int(i)) for i in np.flatnonzero(m.jnt_bodyid == number)),
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


def options(loaded: Loaded) -> Options:
    """Return how a file is simulated."""
    lib, opt = loaded.mujoco, loaded.model.opt
    return Options(
        integrator=integrator(loaded),
        timestep=float(opt.timestep),
        solver=word(lib.mjtSolver, opt.solver),
        tolerance=float(opt.tolerance),
        iterations=int(opt.iterations),
        cone=word(lib.mjtCone, opt.cone).lower(),
        jacobian=word(lib.mjtJacobian, opt.jacobian).lower(),
        gravity=(0.0, 0.0, 0.0) if loaded.disabled("gravity") else floats(opt.gravity),
        energy=loaded.enabled("energy"),
        autoreset=not loaded.disabled("autoreset"),
        contact=not (loaded.disabled("contact") or loaded.disabled("constraint")),
        refsafe=not loaded.disabled("refsafe"),
    )


def integrator(loaded: Loaded) -> str:
    """Return the integrator of the file as MJCF spells it."""
    name = word(loaded.mujoco.mjtIntegrator, loaded.model.opt.integrator)
    return next((one for one in INTEGRATORS if one.upper() == name), name.lower())


def integrators(loaded: Loaded) -> list[str]:
    """Return the integrators that this MuJoCo has."""
    kinds = loaded.mujoco.mjtIntegrator
    return [name for name in INTEGRATORS if hasattr(kinds, f"mjINT_{name.upper()}")]


def word(kinds: Any, value: int) -> str:
    """Return the last word of the member of an enumeration that has a value."""
    return str(kinds(int(value)).name).rpartition("_")[2]


def floats(values: Any) -> tuple[float, ...]:
    """Return plain floats, without the sign of a zero."""
    return tuple(float(value) + 0.0 for value in values)


# Which geoms can touch each other, by MuJoCo's filters ---------------------------------------


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

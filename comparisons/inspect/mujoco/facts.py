"""What is in an MJCF model: its tree, its counts, its options."""

from __future__ import annotations

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

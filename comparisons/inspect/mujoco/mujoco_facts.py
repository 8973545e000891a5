"""What is in an MJCF model: its tree, its counts, its options."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .mujoco_model import Loaded

JOINTS = {"mjJNT_FREE": ("free", 6), "mjJNT_BALL": ("ball", 3), "mjJNT_SLIDE": ("slide", 1)}
HINGE = ("hinge", 1)

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


@dataclass(frozen=True)
class Joint:
    """A joint: ``axis`` (3,) of a slide or hinge, else None; ``range`` None if not limited.

    ``stiffness``, ``damping`` and ``armature`` are those of its first degree of freedom, SI.
    """

    name: str
    kind: str
    dofs: int
    axis: tuple[float, ...] | None
    stiffness: float
    damping: float
    armature: float
    range: tuple[float, float] | None


@dataclass(frozen=True)
class Body:
    """A body: mass [kg], centre of mass [m] in its frame, principal inertias [kg m^2].

    ``depth`` counts bodies from the world down, 0 for those that stand in the world itself.
    """

    name: str
    parent: str
    depth: int
    mass: float
    centre: tuple[float, ...]
    inertia: tuple[float, ...]
    joints: tuple[Joint, ...]


@dataclass(frozen=True)
class Options:
    """How the file is simulated; ``timestep`` [s], ``gravity`` [m/s^2], flags as booleans."""

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
    bodies: tuple[Body, ...]
    counts: dict[str, int]
    mass: float
    size: float
    options: Options


def facts(loaded: Loaded) -> Facts:
    """Return what is in a model."""
    model = loaded.model
    counts = {name: int(getattr(model, field)) for name, field in COUNTED.items()}
    counts["bodies"] -= 1
    return Facts(
        name=loaded.source.root.attributes.get("model", ""),
        bodies=tuple(body(loaded, number) for number in range(1, model.nbody)),
        counts=counts,
        mass=float(np.sum(model.body_mass[1:])),
        size=float(model.stat.extent),
        options=options(loaded),
    )


def body(loaded: Loaded, number: int) -> Body:
    """Return a body with its joints."""
    model = loaded.model
    first, count = int(model.body_jntadr[number]), int(model.body_jntnum[number])
    parent = int(model.body_parentid[number])
    depth, above = 0, parent
    while above:
        depth, above = depth + 1, int(model.body_parentid[above])
    return Body(
        name=loaded.name("body", number),
        parent="world" if parent == 0 else loaded.name("body", parent),
        depth=depth,
        mass=float(model.body_mass[number]),
        centre=floats(model.body_ipos[number]),
        inertia=floats(model.body_inertia[number]),
        joints=tuple(joint(loaded, i) for i in range(first, first + count)),
    )


def joint(loaded: Loaded, number: int) -> Joint:
    """Return a joint."""
    lib, model = loaded.mujoco, loaded.model
    known = {int(getattr(lib.mjtJoint, key)): word for key, word in JOINTS.items()}
    kind, dofs = known.get(int(model.jnt_type[number]), HINGE)
    dof = int(model.jnt_dofadr[number])
    low, high = floats(model.jnt_range[number])
    return Joint(
        name=loaded.name("joint", number),
        kind=kind,
        dofs=dofs,
        axis=floats(model.jnt_axis[number]) if dofs == 1 else None,
        stiffness=float(model.jnt_stiffness[number]),
        damping=float(model.dof_damping[dof]),
        armature=float(model.dof_armature[dof]),
        range=(low, high) if model.jnt_limited[number] else None,
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


SPELLED = {"EULER": "Euler", "IMPLICIT": "implicit", "IMPLICITFAST": "implicitfast"}


def integrator(loaded: Loaded) -> str:
    """Return the integrator of the file as MJCF spells it."""
    found = word(loaded.mujoco.mjtIntegrator, loaded.model.opt.integrator)
    return SPELLED.get(found, "RK4" if found == "RK4" else found.lower())


def word(kinds: Any, value: int) -> str:
    """Return the last word of the member of an enumeration that has a value."""
    return str(kinds(int(value)).name).rpartition("_")[2]


def floats(values: Any) -> tuple[float, ...]:
    """Return plain floats, without the sign of a zero."""
    return tuple(float(value) + 0.0 for value in values)

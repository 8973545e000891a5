"""DART plugged into mbcheck: trees under its own semi-implicit Euler.

    pip install dartpy
    mbcheck check --engine mbcheck.examples.dart_engine:DartEngine

What the MJCF reader of DART 6.20 reads and drops, and how it is completed here:

- joints and their ``damping`` are read, and dampers act: they are left out of what `System.force`
  adds, and are implicit in a step,
- inertia tensors are dropped silently, every body has 1 kg m^2 about each axis; so are mass and
  centre of mass of a body without a geom, which has 1 kg: all are read from the file here, and set,
- ``euler`` and ``quat`` of a body without ``pos`` are dropped silently: here each body has one,
- ``gravity`` is dropped; its own 9.81 m/s^2 is replaced by what the file says,
- ``stiffness``, tendons and actuators are dropped: `System.force` has the forces among them,
- ``armature`` is dropped, and DART has none: of a slide on the world it is mass, with other joints
  the model is refused,
- a ball joint has a rotation vector in place of a quaternion, and the body's angular velocity,
- loops are not run: DART closes them by impulses, softer or harder with the step.
"""

from __future__ import annotations

import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

import mbcheck


class DartEngine(mbcheck.Engine):
    """Trees in a DART `World`, stepped by `World.step`."""

    name = "dart"
    methods = (mbcheck.Method("World.step", 1, "semi_implicit_euler", evaluations_per_step=1),)

    def __init__(self) -> None:
        try:
            import dartpy
        except ImportError as error:
            raise mbcheck.EngineUnavailableError(
                "dartpy cannot be imported; install it with: pip install dartpy"
            ) from error
        self.dart, self.version = dartpy, dartpy.__version__
        self.loaded: tuple[str, Any, list[Any]] | None = None
        self.force: Callable[..., Any]

    def load(self, system: mbcheck.System) -> tuple[Any, list[Any]]:
        """Return the world and its skeletons.

        Raises
        ------
        mbcheck.Unsupported
            For a loop, and for other joints than those of the file.
        """
        if system.closures:
            raise mbcheck.Unsupported("DART closes loops by impulses that depend on the step")
        if "free" in system.kinds:
            raise mbcheck.Unsupported("free joints, whose velocities DART has in the body's frame")
        explicit = tuple(term for term in system.terms if term.kind != "damper")
        self.force = replace(system, terms=explicit).force
        if self.loaded is None or self.loaded[0] != system.mjcf:
            with tempfile.TemporaryDirectory() as folder:
                file = Path(folder, "model.xml")
                file.write_text(with_positions(system.mjcf), encoding="utf-8")
                world = self.dart.utils.MjcfParser.readWorld(f"file://{file}")
            skeletons = [world.getSkeleton(i) for i in range(world.getNumSkeletons())]
            self.complete(system, world, skeletons)
            self.loaded = system.mjcf, world, skeletons
        return self.loaded[1:]

    def complete(self, system: mbcheck.System, world: Any, skeletons: list[Any]) -> None:
        """Give gravity, inertias and armatures, which the reader drops.

        Raises
        ------
        mbcheck.Unsupported
        """
        root = ET.fromstring(system.mjcf)
        option = root.find("option")
        gravity = "0 0 -9.81" if option is None else option.get("gravity", "0 0 -9.81")
        world.setGravity(vector(gravity))
        bodies = [one.getBodyNode(i) for one in skeletons for i in range(one.getNumBodyNodes())]
        joints = [body.getParentJoint() for body in bodies if body.getParentJoint().getNumDofs()]
        if tuple(joint.getName() for joint in joints) != system.joints:
            raise mbcheck.Unsupported(f"DART read {[joint.getName() for joint in joints]}")
        inertials: dict[Any, Any] = {
            body.get("name"): body.find("inertial") for body in root.iter("body")
        }
        for body in bodies:
            joint = body.getParentJoint()
            armature = (system.armatures or {}).get(joint.getName(), 0.0)
            if armature and not (
                joint.getType() == "PrismaticJoint" and body.getParentBodyNode() is None
            ):
                raise mbcheck.Unsupported("DART has no armature")
            body.setGravityMode(
                not armature
            )  # which has no weight, and leaves none to a mass of 1 g
            inertial = inertials.get(body.getName())
            if inertial is None:
                raise mbcheck.Unsupported(f"body {body.getName()} has no inertial to read it from")
            mass, place = float(inertial.get("mass")) + armature, vector(inertial.get("pos"))
            body.setInertia(self.dart.dynamics.Inertia(mass, place, tensor(inertial)))

    def put(self, system: mbcheck.System, time: float, q: Any, v: Any) -> tuple[Any, list[Any]]:
        """Put a state into the world, and the forces that act in it at this time [s]."""
        world, skeletons = self.load(system)
        places = zip(system.kinds, system.layout.positions, strict=True)
        coordinates = np.concatenate(
            [rotation_vector(q[at]) if kind == "ball" else q[at] for kind, at in places]
        )
        force, begin = self.force(time, q, v), 0
        for one in skeletons:
            of_one = slice(begin, begin := begin + one.getNumDofs())
            one.setPositions(coordinates[of_one])
            one.setVelocities(v[of_one])
            one.setForces(force[of_one])
        return world, skeletons

    def state(self, system: mbcheck.System, skeletons: list[Any]) -> tuple[Any, Any]:
        """Return positions (n_q,) and velocities (n,)."""
        rows = iter(np.concatenate([one.getPositions() for one in skeletons]))
        parts = [
            quaternion([next(rows) for _ in range(3)]) if kind == "ball" else [next(rows)]
            for kind in system.kinds
        ]
        return np.concatenate(parts), np.concatenate([one.getVelocities() for one in skeletons])

    def accelerations(self, system: mbcheck.System, time: float, q: Any, v: Any) -> Any:
        """Return accelerations (n,) at positions (n_q,) and velocities (n,)."""
        _, skeletons = self.put(system, time, q, v)
        for one in skeletons:
            one.setTimeStep(0.0)  # of forward dynamics, in which dampers are implicit
            one.computeForwardDynamics()
        return np.concatenate([one.getAccelerations() for one in skeletons])

    def mass_matrix(self, system: mbcheck.System, q: Any) -> Any:
        """Return the mass matrix (n, n)."""
        _, skeletons = self.put(system, system.start_time, q, np.zeros(system.layout.size[1]))
        return block_diag(*(one.getMassMatrix() for one in skeletons))

    def simulate(
        self, system: mbcheck.System, method: mbcheck.Method, step: float, times: Any
    ) -> mbcheck.Motion:
        """Step the world, with the forces at the beginning of each step."""
        q, v, done, rows = system.positions, system.velocities, 0, []
        world = self.load(system)[0]
        world.setTimeStep(step)
        world.setTime(system.start_time)
        for time in times:
            while system.start_time + (done + 0.5) * step < time:
                world, skeletons = self.put(system, world.getTime(), q, v)
                world.step()
                q, v = self.state(system, skeletons)
                done += 1
            rows.append((q, v, world.getTime()))
        positions, velocities, clock = (np.array(part) for part in zip(*rows, strict=True))
        return mbcheck.Motion(positions, velocities, clock, done, rhs_evaluations=done)


def with_positions(text: str) -> str:
    """Return MJCF in which each body has a ``pos``."""
    root = ET.fromstring(text)
    for body in root.iter("body"):
        body.set("pos", body.get("pos", "0 0 0"))
    return ET.tostring(root, encoding="unicode")


def vector(words: str) -> Any:
    """Return the numbers of an attribute."""
    return np.array(words.split(), dtype=float)


def tensor(inertial: Any) -> Any:
    """Return the inertia (3, 3) of an ``inertial`` [kg m^2]."""
    if "diaginertia" in inertial.attrib:
        return np.diag(vector(inertial.get("diaginertia")))
    xx, yy, zz, xy, xz, yz = vector(inertial.get("fullinertia"))
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def rotation_vector(quaternion: Any) -> Any:
    """Return the rotation vector (3,) of a quaternion (w, x, y, z)."""
    return Rotation.from_quat(quaternion, scalar_first=True).as_rotvec()


def quaternion(vector: Any) -> Any:
    """Return the quaternion (w, x, y, z) of a rotation vector (3,)."""
    return Rotation.from_rotvec(vector).as_quat(scalar_first=True)

"""Pinocchio plugged into mbcheck: it reads the MJCF, and its loop closures, by itself.

    pip install "mbcheck[pinocchio]"
    mbcheck check --engine pinocchio

What Pinocchio 4.1 reads and drops of MJCF, and how it is completed here:

- of the bodies in ``worldbody`` it reads the first and drops the others silently: all are put
  below one body fixed to the world,
- ``gravity`` is dropped; its own 9.81 m/s^2 is replaced by what the file says,
- ``armature``, ``ref`` and site-based ``connect`` are read; ``damping`` is read and does not act;
  springs, tendons and actuators are dropped: `System.force` has them all,
- a ball joint's quaternion is (x, y, z, w) in place of (w, x, y, z), its velocity the same; a free
  joint, whose velocity it has in the frame of the body, is refused here,
- loops are closed by `constraintDynamics`, which leaves 1e-16 of an acceleration after 3 proximal
  iterations; nothing pulls back what an integrator lets drift.
"""

from __future__ import annotations

import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np

import mbcheck

PROXIMAL = (1e-16, 1e-8, 50)
"""Accuracy, regularisation and most iterations of the solver of loops."""


class PinocchioEngine(mbcheck.Engine):
    """Pinocchio's dynamics with the classical Runge-Kutta method."""

    name = "pinocchio"
    methods = (mbcheck.Method("RK4", 4, "RK44"),)

    def __init__(self) -> None:
        try:
            import pinocchio
        except ImportError as error:
            raise mbcheck.EngineUnavailableError(
                "pinocchio cannot be imported; install it with: pip install pin"
            ) from error
        self.pin, self.version = pinocchio, pinocchio.__version__
        self.loaded: tuple[str, Any, Any, Any, Any] | None = None

    def load(self, system: mbcheck.System) -> tuple[Any, Any, Any, Any]:
        """Return model and data, and the models and data of its loops.

        Raises
        ------
        mbcheck.Unsupported
            For a free joint, or if Pinocchio reads other joints.
        """
        if "free" in system.kinds:
            raise mbcheck.Unsupported(
                "free joints, whose velocities Pinocchio has in the body's frame"
            )
        if self.loaded is None or self.loaded[0] != system.mjcf:
            pin = self.pin
            with tempfile.TemporaryDirectory() as folder:
                file = Path(folder, "model.xml")
                file.write_text(below_one_body(system.mjcf), encoding="utf-8")
                model, loops = pin.buildModelAndLegacyConstraintsFromMJCF(str(file))[:2]
            model.gravity = pin.Motion(np.array(gravity(system.mjcf)), np.zeros(3))
            if tuple(model.names)[1:] != system.joints:
                raise mbcheck.Unsupported(f"Pinocchio read the joints {list(model.names)[1:]}")
            data, loop_data = model.createData(), pin.StdVec_RigidConstraintData()
            for loop in loops:
                loop_data.append(loop.createData())
            pin.initConstraintDynamics(model, data, loops, loop_data)
            self.loaded = system.mjcf, model, data, loops, loop_data
        return self.loaded[1:]

    def accelerations(self, system: mbcheck.System, time: float, q: Any, v: Any) -> Any:
        """Return accelerations (n,) at positions (n,) and velocities (n,)."""
        pin = self.pin
        model, data, loops, loop_data = self.load(system)
        force, q = system.force(time, q, v), scalar_last(system, q)
        if not system.closures:
            return pin.aba(model, data, q, v, force).copy()
        settings = pin.ProximalSettings(*PROXIMAL)
        return pin.constraintDynamics(model, data, q, v, force, loops, loop_data, settings).copy()

    def mass_matrix(self, system: mbcheck.System, q: Any) -> Any:
        """Return the mass matrix (n, n) of the open tree."""
        model, data, *_ = self.load(system)
        upper = np.triu(self.pin.crba(model, data, scalar_last(system, q)))
        return upper + np.triu(upper, 1).T

    def simulate(
        self, system: mbcheck.System, method: mbcheck.Method, step: float, times: Any
    ) -> mbcheck.Motion:
        """Integrate with a fixed step of the classical method of order 4."""
        q, v, steps = system.positions, system.velocities, 0
        states = []
        for time in times:
            while system.start_time + (steps + 0.5) * step < time:
                now = system.start_time + steps * step
                q, v = self.runge_kutta(system, now, q, v, step)
                steps += 1
            states.append((q, v, system.start_time + steps * step))
        positions, velocities, clock = (np.array(part) for part in zip(*states, strict=True))
        return mbcheck.Motion(positions, velocities, clock, steps)

    def runge_kutta(
        self, system: mbcheck.System, t: float, q: Any, v: Any, h: float
    ) -> tuple[Any, Any]:
        """Take one step; quaternions are of length 1 wherever slopes are taken, and in the end."""

        def slopes(time: float, q: Any, v: Any) -> tuple[Any, Any]:
            q = system.displaced(q, 0 * v)
            return system.layout.rates(q, v), self.accelerations(system, time, q, v)

        r1, a1 = slopes(t, q, v)
        r2, a2 = slopes(t + h / 2, q + h / 2 * r1, v + h / 2 * a1)
        r3, a3 = slopes(t + h / 2, q + h / 2 * r2, v + h / 2 * a2)
        r4, a4 = slopes(t + h, q + h * r3, v + h * a3)
        v = v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        return system.displaced(q + h / 6 * (r1 + 2 * r2 + 2 * r3 + r4), 0 * v), v


def scalar_last(system: mbcheck.System, q: Any) -> Any:
    """Return positions (n_q,) with quaternions in Pinocchio's order (x, y, z, w)."""
    q = np.array(q, dtype=float)
    for at in system.layout.quaternions:
        q[at] = np.roll(q[at], -1)
    return q


def below_one_body(text: str) -> str:
    """Return MJCF with all bodies of the world below a fixed one."""
    root = ET.fromstring(text)
    world = root.find("worldbody")
    assert world is not None
    bodies = world.findall("body")
    for body in bodies:
        world.remove(body)
    ET.SubElement(world, "body", name="base").extend(bodies)
    return ET.tostring(root, encoding="unicode")


def gravity(text: str) -> list[float]:
    """Return the gravity (3,) that MJCF tells."""
    option = ET.fromstring(text).find("option")
    told = {} if option is None else option.attrib
    return [float(word) for word in told.get("gravity", "0 0 -9.81").split()]

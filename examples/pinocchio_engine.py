"""Pinocchio plugged into mbcheck: it reads the MJCF, and its loop closures, by itself.

    pip install "mbcheck[pinocchio]"
    mbcheck check --engine pinocchio

What Pinocchio 4.1 makes of MJCF, and what is done about it here:

- of the bodies in ``worldbody`` it reads the first and drops the others silently: all are put
  below one body that is fixed to the world,
- ``gravity`` is dropped; its own 9.81 m/s^2 is replaced by what the file says,
- ``armature``, ``ref`` and site-based ``connect`` are read; ``damping`` is read and does not act;
  springs, tendons and actuators are dropped: `System.force` has them all,
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
        """Return model and data, and the models and data of its loops."""
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
        force = system.force(time, q, v)
        if not system.closures:
            return pin.aba(model, data, q, v, force).copy()
        settings = pin.ProximalSettings(*PROXIMAL)
        return pin.constraintDynamics(model, data, q, v, force, loops, loop_data, settings).copy()

    def mass_matrix(self, system: mbcheck.System, q: Any) -> Any:
        """Return the mass matrix (n, n) of the open tree."""
        model, data, *_ = self.load(system)
        upper = np.triu(self.pin.crba(model, data, q))
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
        """Take one step."""
        a1 = self.accelerations(system, t, q, v)
        v2 = v + h / 2 * a1
        a2 = self.accelerations(system, t + h / 2, q + h / 2 * v, v2)
        v3 = v + h / 2 * a2
        a3 = self.accelerations(system, t + h / 2, q + h / 2 * v2, v3)
        v4 = v + h * a3
        a4 = self.accelerations(system, t + h, q + h * v3, v4)
        return q + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)


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

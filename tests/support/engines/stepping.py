"""Steps of order 1 by MuJoCo's accelerations, right or wrong, by an engine that only runs."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import mujoco
import numpy as np

import mbcheck
from mbcheck.examples.mujoco_engine import MujocoPlugin
from mbcheck.models.joints import SPATIAL
from mbcheck.reference.scene import Array


class Stepping(MujocoPlugin):
    """An engine that tells runs alone.

    Parameters
    ----------
    scheme : str or None
        That it declares.
    way : str
        How it steps, see `Stepping.after`.
    fault : str
        ``last`` or ``zero``: the accelerations of the first step are those of the run before, or 0.
        ``slope``: implicit steps leave out what actuators resist with. ``gyroscopic`` or
        ``coriolis``: these forces are counted ``factor`` times; ``derivative``: the derivative of
        all forces of inertia is, in implicit steps.
    """

    methods: Any

    def __init__(
        self, scheme: str | None = None, way: str = "semi", fault: str = "", factor: float = 0.0
    ) -> None:
        self.methods = (mbcheck.Method("step", 1, scheme),)
        self.way, self.fault, self.factor = way, fault, factor
        self.last: Any = None
        self.first = True

    def accelerations(self, system: Any, time: float, q: Array, v: Array) -> Array:
        """Tell none."""
        raise mbcheck.Unsupported("runs alone")

    def mass_matrix(self, system: Any, q: Array) -> Array:
        """Tell none."""
        raise mbcheck.Unsupported("runs alone")

    def balance(self, system: Any, time: float, q: Array, v: Array) -> tuple[Array, Array]:
        """Return the mass matrix and the forces, those of inertia included."""
        a, mass = super().accelerations(system, time, q, v), np.empty((len(v), len(v)))
        mujoco.mj_fullM(self.model, self.data, mass)
        return mass, mass @ a

    def inertial(self, system: Any, time: float, q: Array, v: Array) -> Array:
        """Return the forces of inertia that rates make."""
        moving, still = (self.balance(system, time, q, one)[1] for one in (v, 0 * v))
        driven, resting = (system.force(time, q, one) for one in (v, 0 * v))
        return moving - still - (driven - resting)

    def pushed(self, system: Any, time: float, q: Array, v: Array) -> tuple[Array, Array]:
        """Return mass matrix and forces, with a fault."""
        mass, forces = self.balance(system, time, q, v)
        if self.fault in ("gyroscopic", "coriolis"):
            spin = np.zeros(len(v), dtype=bool)
            for kind, own in zip(system.layout.kinds, system.layout.velocities, strict=True):
                spin[range(len(v))[own][-3:] if kind in SPATIAL else []] = True
            part = self.inertial(system, time, q, v * spin)
            if self.fault == "coriolis":
                others = self.inertial(system, time, q, v * ~spin)
                part = self.inertial(system, time, q, v) - part - others
            forces = forces - (1 - self.factor) * part
        return mass, forces

    def damping(self, system: Any, time: float, q: Array, v: Array) -> Array:
        """Return the damping matrix of an implicit step: forces are of degree 2 in rates."""
        terms = [one for one in system.terms if self.fault != "slope" or one.kind != "actuator"]
        told, columns = replace(system, terms=tuple(terms)), []
        for unit in np.eye(len(v)) / 2:
            ahead, behind = v + unit, v - unit
            column = told.force(time, q, behind) - told.force(time, q, ahead)
            if self.way == "implicit":
                share = self.factor if self.fault == "derivative" else 1.0
                near, far = (
                    self.balance(system, time, q, one)[1] - system.force(time, q, one)
                    for one in (behind, ahead)
                )
                column = column + share * (near - far)
            columns.append(column)
        return np.transpose(columns)

    def after(self, system: Any, time: float, q: Array, v: Array, h: float) -> tuple[Array, Array]:
        """Return the state after a step, of accelerations that a fault may leave as they were."""
        mass, forces = self.pushed(system, time, q, v)
        if self.way in ("implicit", "dampers"):
            mass = mass + h * self.damping(system, time, q, v)
        a = np.linalg.solve(mass, forces)
        if self.fault == "zero" and self.first:
            a = 0 * a
        if self.fault == "last" and self.first and self.last:
            a = np.linalg.solve(*self.pushed(*self.last))
        self.first = False
        before, v = v, v + h * a
        if self.way == "end":  # accelerations at the end of the step
            for _ in range(5):
                mass, forces = self.pushed(system, time + h, system.displaced(q, h * v), v)
                v = before + h * np.linalg.solve(mass, forces)
        q = system.displaced(q, h * (before if self.way == "explicit" else v))
        self.last = system, time + h, q, v
        return q, v

    def simulate(self, system: Any, method: Any, step: float, times: Any) -> Any:
        """Run."""
        q, v, count, rows = system.positions, system.velocities, 0, []
        parts, self.first = 3 if self.way == "substeps" else 1, True
        late: Any = 0.0
        for time in times:
            while (now := system.start_time + count * step) + step / 2 < time:
                for part in range(parts):
                    q, v = self.after(system, now + part * step / parts, q, v, step / parts)
                count += 1
            if self.way == "staggered":  # rates are told half a step behind the positions
                late = step / 2 * np.linalg.solve(*self.pushed(*self.last))
            rows.append((q, v - late))
        positions, velocities = map(np.array, zip(*rows, strict=True))
        if self.precision == "float32":
            positions, velocities = (
                one.astype(np.float32).astype(float) for one in (positions, velocities)
            )
        return mbcheck.Motion(positions, velocities, times, count)


class Single(Stepping):
    """The same, whose numbers have 32 bits."""

    precision = "float32"

"""An engine that integrates the scenes' own equations."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import mbcheck
from mbcheck.reference import get_scene
from mbcheck.reference.solve import schemes

STAGES = {"semi_implicit_euler": 1, "ExplicitMidpoint": 2, "RK33": 3, "RK44": 4, "DOPRI5": 6}


class Solved(mbcheck.Engine):
    """The scenes' equations, maybe with other parameters, by a method with or without its scheme.

    Attributes
    ----------
    scheme : str
    change : callable or None
        Parameters that the equations have instead of those of the case.
    substeps : int
        Equal parts of a step.
    """

    name, version, reads_mjcf = "solved", "1", False

    def __init__(
        self,
        method: mbcheck.Method,
        scheme: str = "RK44",
        change: Callable[[Any], Any] | None = None,
        substeps: int = 1,
    ) -> None:
        self.methods, self.scheme = (method,), scheme
        self.change, self.substeps = change or (lambda p: p), substeps

    def accelerations(self, system: Any, time: float, q: Any, v: Any) -> Any:
        """Return accelerations (n,)."""
        scene = get_scene(system.case.scene)
        slopes = scene.right_hand_side(self.change(system.case.parameters))
        return slopes(time, np.concatenate([q, v]))[len(q) :]

    def simulate(self, system: Any, method: Any, step: float, times: Any) -> mbcheck.Motion:
        """Integrate, and count the evaluations."""
        scene, n = get_scene(system.case.scene), len(system.joints)
        counts = np.rint((times - system.start_time) / step).astype(int)
        states = schemes.integrate(
            schemes.ScalarEquations(scene, self.change(system.case.parameters)),
            self.scheme,
            np.concatenate([system.positions, system.velocities]),
            step / self.substeps,
            counts * self.substeps,
            system.start_time,
        ).T
        work = STAGES[self.scheme] * self.substeps * counts[-1]
        return mbcheck.Motion(states[:, :n], states[:, n:], rhs_evaluations=int(work))


class Single(Solved):
    """The same with numbers of 32 bits, by the classical method of Runge and Kutta or Euler's."""

    name, precision = "single", "float32"

    def rates(self, system: Any) -> Any:
        """Return the rates of states as a function of time and state, all in 32 bits."""
        scene = get_scene(system.case.scene)
        c = scene.coefficients(self.change(system.case.parameters))
        return scene.derivative(type(c)(*map(np.float32, c)))

    def accelerations(self, system: Any, time: float, q: Any, v: Any) -> Any:
        """Return accelerations (n,)."""
        state = np.concatenate([q, v]).astype(np.float32)
        return self.rates(system)(np.float32(time), state)[len(q) :]

    def simulate(self, system: Any, method: Any, step: float, times: Any) -> mbcheck.Motion:
        """Integrate, each number rounded to 32 bits."""
        rates, one = self.rates(system), np.float32
        h, n, steps, rows = one(step), len(system.joints), 0, []
        x = np.concatenate([system.positions, system.velocities]).astype(one)
        for time in times:
            while system.start_time + (steps + 0.5) * step < time:
                t = one(system.start_time + steps * step)
                k1 = rates(t, x)
                if method.order == 1:
                    x = x + h * k1
                else:
                    k2 = rates(t + h / one(2), x + h / one(2) * k1)
                    k3 = rates(t + h / one(2), x + h / one(2) * k2)
                    k4 = rates(t + h, x + h * k3)
                    x = x + h / one(6) * (k1 + one(2) * (k2 + k3) + k4)
                steps += 1
            rows.append(x)
        states = np.array(rows)
        return mbcheck.Motion(states[:, :n], states[:, n:], steps=steps)

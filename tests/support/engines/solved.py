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

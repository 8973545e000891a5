"""One bifurcation of a periodic orbit, sought along one parameter from those of a case."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from ..errors import NoOrbitError
from ..orbits import section_row
from ..scene import Array, EquationsOfMotion
from .bifurcations import LINE
from .curve import correct
from .points import CurvePoint
from .tracing import Tracer

REACH = 0.2
"""How far the parameter may be off that of the case, in its size."""


@dataclass(frozen=True)
class BoundaryAlong:
    """Where the orbits of a scene lose their stability along one parameter.

    The window that curves are followed in is the parameter's reach; its first axis is idle.

    Attributes
    ----------
    scene : EquationsOfMotion
    parameters : Parameters
        Of a case near by.
    kind : str
        Of a bifurcation.
    parameter : str
        What is varied.
    """

    scene: EquationsOfMotion
    parameters: Any
    kind: str
    parameter: str

    where: ClassVar[str] = "in a period"
    """What steps divide, in words."""

    @property
    def here(self) -> float:
        """The parameter at the case."""
        return float(getattr(self.parameters, self.parameter))

    @property
    def unit(self) -> float:
        """Size of the window, in the parameter's unit."""
        return 2 * REACH * abs(self.here)

    def value(self, place: Any) -> Any:
        """Return the parameter at places of the window, 0 to 1."""
        return self.here + self.unit * (place - 0.5)

    @property
    def span(self) -> float:
        """Time [s] of the orbit, its period, which steps divide."""
        tracer, point = self.solution
        section = section_row(self.scene)
        return tracer.units[1] * (1.0 if section is None else float(point.z[section]))

    @property
    def row(self) -> Array:
        """The plane (2 n + 2,) on which the window's idle axis stays."""
        return np.eye(2 * len(self.scene.coordinates) + 2)[-2]

    def tracer(self) -> Tracer:
        """Return what solves for the orbits of the reference."""

        def at(place: Array) -> Any:
            return self.parameters.replace(**{self.parameter: self.value(place[1])})

        return Tracer(self.scene, at)

    @cached_property
    def solution(self) -> tuple[Tracer, CurvePoint]:
        """What solves for the orbits, and the point.

        Raises
        ------
        NoOrbitError
            If there is none.
        """
        tracer = self.tracer()
        line, guess = tracer.curve(LINE, 1, 1, 0.5), tracer.starts(np.array([0.0, 0.5]))[0]
        orbit = correct(line.equations, guess, self.row, 0.0, 30)
        curve = tracer.curve(self.kind, 1)
        near = orbit and correct(curve.equations, orbit.z, self.row, 0.0, 30)
        point = None
        if near is not None:
            _, point = tracer.adapt(curve, *tracer.rate(curve, near, self.row))
        if point is None or not 0 <= point.place[1] <= 1:
            words = self.kind.replace("_", " ")
            raise NoOrbitError(
                f"{self.scene.name} has no {words} near {self.parameter} = {self.here:g}"
            )
        return tracer, point

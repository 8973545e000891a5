"""Request of a boundary: a window of two parameters, and the engine."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Literal

import numpy as np

from ...reference import get_scene
from ...reference.continuation.bifurcations import ParameterWindow
from ...reference.continuation.rest import RestTracer, is_undriven
from ...reference.continuation.tracing import Tracer
from ...reference.errors import (
    MbcheckError,
    NoOrbitError,
    ParameterError,
    UsageError,
)
from ...reference.orbits import why_none
from ...reference.parameters import GRAVITY
from ...reference.scene import NO_CONTINUUM, Array, Scene
from ..checks.orbits import FEWEST_STEPS
from ..documents.fields import OptionMark, number_from
from ..engines.registry import REFERENCE
from ..engines.setup import Setup
from ..queries.axis import ParameterRange, refuse_axes
from ..queries.request import MethodQuery

ORBITS, EQUILIBRIA = "orbits", "equilibria"
SUBJECTS = (ORBITS, EQUILIBRIA)
"""Subjects of boundaries; homoclinic orbits, which end orbits, are followed with equilibria."""


def place_from(text: str, flag: str) -> tuple[float, ...]:
    """Return the place X,Y of the window.

    Raises
    ------
    UsageError
        If the text is none.
    """
    place = tuple(number_from(part, f"{flag}: a place") for part in text.split(","))
    if len(place) != 2:
        raise UsageError(f"{flag} needs X,Y, not {text!r}")
    return place


@dataclass(frozen=True)
class BoundaryRequest(MethodQuery):
    """Everything that a boundary depends on.

    Attributes
    ----------
    step : float or None
        Longest step in the window [s].
    x, y : ParameterRange
        A parameter, and its range in the window.
    lines : int
        On which x stays, its bounds included: bifurcations are looked for along them.
    of : {"orbits", "equilibria"} or None
        One of them alone.
    near : tuple of (x, y)
        Look along x = X as well, from the orbit at X and Y.
    """

    x: Annotated[ParameterRange, OptionMark("NAME=LO:HI", parse=ParameterRange.parse)]
    y: Annotated[ParameterRange, OptionMark("NAME=LO:HI", parse=ParameterRange.parse)]
    lines: Annotated[int, OptionMark("N", least=1)] = 13
    of: Annotated[Literal["orbits", "equilibria"] | None, OptionMark()] = None
    near: Annotated[
        tuple[tuple[float, float], ...], OptionMark("X,Y", ("--near",), place_from)
    ] = ()

    @property
    def equations(self) -> Scene:
        """The scene."""
        return get_scene(self.scene)

    @cached_property
    def middle(self) -> Setup:
        """Who follows the orbits, amid the window."""
        values = {axis.name: (axis.low + axis.high) / 2 for axis in (self.x, self.y)}
        parameters = {**(self.parameters or {}), **values}
        names = {name: getattr(self, name) for name in ("engine", "model", "method", "step")}
        return MethodQuery(self.scene, **names, parameters=parameters).setup()

    @property
    def window(self) -> ParameterWindow:
        """The window."""
        ends = np.array([[axis.low, axis.high] for axis in (self.x, self.y)])
        return ParameterWindow((self.x.name, self.y.name), *ends.T)

    @cached_property
    def longest_period(self) -> float:
        """The longest period of the drive in the window, or guess of one [s]."""
        corners = np.array([[0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]])
        at = self.window.parameters(self.middle.case.parameters)(corners)
        return float(np.max(self.equations.period(at)))

    @cached_property
    def steps_per_period(self) -> int | None:
        """Steps of an engine in a period: an even number, that halves may have as many."""
        if self.engine == REFERENCE:
            return None
        steps = self.longest_period / self.middle.step_size
        return 2 * math.ceil(max(steps, FEWEST_STEPS) / 2 - 1e-9)

    @property
    def longest_step(self) -> float | None:
        """Longest step of an engine in the window [s]."""
        return self.steps_per_period and self.longest_period / self.steps_per_period

    @property
    def size(self) -> Array:
        """How large the window is (2,)."""
        return self.window.high - self.window.low

    def tracer(self, subject: str = ORBITS) -> Tracer:
        """Return the tracer of the reference's orbits, or equilibria."""
        parameters = self.window.parameters(self.middle.case.parameters)
        if subject == ORBITS:
            return Tracer(self.equations, parameters)
        return RestTracer(self.equations, parameters, window=self.window)

    @cached_property
    def subjects(self) -> list[str]:
        """Subjects to be followed.

        Raises
        ------
        UsageError
        NoOrbitError
        """
        reasons = {ORBITS: why_no_orbits, EQUILIBRIA: why_no_equilibria}
        asked = SUBJECTS if self.of is None else (self.of,)
        errors = [reasons[subject](self) for subject in asked]
        if all(errors):
            raise errors[0]  # type: ignore[misc]
        return [subject for subject, error in zip(asked, errors, strict=True) if error is None]


def refuse_impossible(asked: BoundaryRequest) -> None:
    """Refuse what cannot be followed.

    Raises
    ------
    UsageError
    NoOrbitError
    """
    scene = asked.equations
    names = scene.parameters.numeric_names()
    refuse_axes(f"a boundary of {scene.name}", asked.x, asked.y, names, asked.parameters or {})
    if asked.lines < 2:
        raise UsageError(f"--lines must be 2 or more, not {asked.lines}")
    for place in asked.near:
        for axis, value in zip((asked.x, asked.y), place, strict=True):
            if not axis.low <= value <= axis.high:
                raise UsageError(
                    f"--near: {axis.name} = {value:g} is not in the window, {axis.low:g} to "
                    f"{axis.high:g}"
                )
    setup = asked.middle
    for ends in ((asked.x.low, asked.y.low), (asked.x.high, asked.y.high)):
        setup.case.parameters.replace(**dict(zip((asked.x.name, asked.y.name), ends, strict=True)))
    if setup.engine.name == REFERENCE and setup.bound.equations[0] is not scene:
        raise UsageError(f"the reference follows the equations of {scene.name}, not {setup.model}")
    _ = asked.subjects


def why_no_orbits(asked: BoundaryRequest) -> MbcheckError | None:
    """Return the reason why there are no orbits to follow, None if there are."""
    scene, setup = asked.equations, asked.middle
    weighed = setup.case.parameters.has_gravity or {asked.x.name, asked.y.name} & {*GRAVITY}
    if scene.orbit.mirror and weighed:
        return UsageError(
            f"orbits of {scene.name} are closed over half a period, after which gravity is not the "
            "same: leave it 0"
        )
    if not scene.orbit.guesses(setup.case.parameters):
        return NoOrbitError(f"{scene.name} has no periodic orbit to follow: {why_none(scene)}")
    if setup.engine.name != REFERENCE and setup.bound.coordinates != scene.coordinates:
        return UsageError(
            f"{setup.engine.name} {setup.model} has other coordinates than {scene.name}: its "
            "orbits cannot be followed"
        )
    return None


def why_no_equilibria(asked: BoundaryRequest) -> MbcheckError | None:
    """Return the reason why there are no equilibria to follow, None if there are."""
    scene = asked.equations
    if asked.middle.engine.name != REFERENCE:
        return UsageError(
            "equilibria are followed by the reference alone: an engine of the same forces has the "
            "same, whatever its step"
        )
    if scene.quaternions or scene.continuum is not NO_CONTINUUM:
        return UsageError(
            f"equilibria of {scene.name} are not followed: it has no coordinates "
            "that are all free to be varied"
        )
    if undriven(asked):
        return None
    free = [name for name in scene.parameters.numeric_names() if name not in asked.window.names]
    names = [name for name in free if undriven(asked, **{name: 0.0})]
    advice = (
        f": --set {names[0]}=0" if names else "; no parameter off the axes ends that by being 0"
    )
    return UsageError(f"{scene.name} is driven, and so has no equilibria{advice}")


def undriven(asked: BoundaryRequest, **changes: float) -> bool:
    """Return True if a scene with some other parameters is undriven all over the window."""
    try:
        parameters = asked.middle.case.parameters.replace(**changes)
    except ParameterError:
        return False
    corners = np.array([[0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]])
    with np.errstate(all="ignore"):
        return is_undriven(asked.equations, asked.window.parameters(parameters)(corners), 4)

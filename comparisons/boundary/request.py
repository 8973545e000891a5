"""What a boundary is asked for: a window of two parameters, and who follows the orbits."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, Any, Literal

import numpy as np

from ...reference import get_scene
from ...reference.continuation.bifurcations import ParameterWindow
from ...reference.continuation.rest import RestTracer, is_undriven
from ...reference.continuation.tracing import Tracer
from ...reference.errors import (
    MbcheckError,
    NoOrbitError,
    ParameterError,
    UnknownNameError,
    UsageError,
)
from ...reference.orbits import why_none
from ...reference.parameters import GRAVITY
from ...reference.scene import NO_CONTINUUM, Array, Scene
from ..checks.orbits import FEWEST_STEPS
from ..documents.fields import OptionMark, number_from
from ..engines.registry import REFERENCE
from ..engines.setup import Setup
from ..queries.axis import ParameterRange
from ..queries.query import MethodQuery

ORBITS, EQUILIBRIA = "orbits", "equilibria"
SUBJECTS = (ORBITS, EQUILIBRIA)
"""What boundaries are of; homoclinic orbits, which end orbits, are followed with equilibria."""


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
class BoundaryRequest:
    """Everything that a boundary depends on.

    Attributes
    ----------
    scene : str
        Name of the scene.
    x, y : ParameterRange
        A parameter, and its range in the window.
    engine : str
        Who follows the curves.
    model : str or None
        One of the engine's models of the scene.
    method : str or None
        Integrator as the engine spells it; by default that of highest order.
    step : float or None
        Longest step in the window [s].
    parameters : mapping
        Change a parameter from its default, SI units.
    lines : int
        On which x stays, its bounds included: bifurcations are looked for along them.
    of : {"orbits", "equilibria"} or None
        One of them alone.
    near : tuple of (x, y)
        Look along x = X as well, from the orbit at X and Y.
    """

    scene: Annotated[str, OptionMark(flags=())]
    x: Annotated[ParameterRange, OptionMark("NAME=LO:HI", parse=ParameterRange.parse)]
    y: Annotated[ParameterRange, OptionMark("NAME=LO:HI", parse=ParameterRange.parse)]
    engine: Annotated[str, OptionMark("ENGINE")] = REFERENCE
    model: Annotated[str | None, OptionMark("NAME")] = None
    method: Annotated[str | None, OptionMark("METHOD")] = None
    step: Annotated[float | None, OptionMark("H")] = None
    parameters: Annotated[Mapping[str, Any], OptionMark("NAME=VALUE", ("--set",))] = field(
        default_factory=dict
    )
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
    def setup(self) -> Setup:
        """Who follows the orbits, amid the window."""
        middle = {axis.name: (axis.low + axis.high) / 2 for axis in (self.x, self.y)}
        changed = {**self.parameters, **middle}
        return MethodQuery(
            self.scene,
            engine=self.engine,
            model=self.model,
            method=self.method,
            step=self.step,
            parameters=changed,
        ).setup()

    @property
    def window(self) -> ParameterWindow:
        """The window."""
        ends = np.array([[axis.low, axis.high] for axis in (self.x, self.y)])
        return ParameterWindow((self.x.name, self.y.name), *ends.T)

    @property
    def places(self) -> list[float]:
        """Lines through the window on which x stays: where, 0 to 1."""
        return list(np.linspace(0, 1, self.lines).tolist())

    @cached_property
    def longest_period(self) -> float:
        """The longest period of the drive in the window, or guess of one [s]."""
        corners = np.array([[0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]])
        at = self.window.parameters(self.setup.case.parameters)(corners)
        return float(np.max(self.equations.period(at)))

    @cached_property
    def steps_per_period(self) -> int | None:
        """Steps of an engine in a period: an even number, that halves may have as many."""
        if self.engine == REFERENCE:
            return None
        steps = self.longest_period / self.setup.step_size
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
        """Return what follows the reference's orbits, or equilibria."""
        parameters = self.window.parameters(self.setup.case.parameters)
        if subject == ORBITS:
            return Tracer(self.equations, parameters)
        return RestTracer(self.equations, parameters, window=self.window)

    @cached_property
    def subjects(self) -> list[str]:
        """What is followed.

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
    if asked.x.name == asked.y.name:
        raise UsageError(f"both axes are {asked.x.name}: a boundary needs two parameters")
    names = scene.parameters.numeric_names()
    for axis in (asked.x, asked.y):
        if axis.name not in names:
            raise UnknownNameError(f"parameter of {asked.scene}", axis.name, names)
        if axis.name in asked.parameters:
            raise UsageError(f"{axis.name} is on an axis, and so cannot be set as well")
    if asked.lines < 2:
        raise UsageError(f"--lines must be 2 or more, not {asked.lines}")
    for place in asked.near:
        for axis, value in zip((asked.x, asked.y), place, strict=True):
            if not axis.low <= value <= axis.high:
                raise UsageError(
                    f"--near: {axis.name} = {value:g} is not in the window, {axis.low:g} to "
                    f"{axis.high:g}"
                )
    setup = asked.setup
    for ends in ((asked.x.low, asked.y.low), (asked.x.high, asked.y.high)):
        setup.case.parameters.replace(**dict(zip((asked.x.name, asked.y.name), ends, strict=True)))
    if setup.engine.name == REFERENCE and setup.equations[0] is not scene:
        raise UsageError(f"the reference follows the equations of {scene.name}, not {setup.model}")
    _ = asked.subjects


def why_no_orbits(asked: BoundaryRequest) -> MbcheckError | None:
    """Return why there are no orbits to follow, None if there are."""
    scene, setup = asked.equations, asked.setup
    weighed = setup.case.parameters.has_gravity or {asked.x.name, asked.y.name} & {*GRAVITY}
    if scene.orbit.mirror and weighed:
        return UsageError(
            f"orbits of {scene.name} are closed over half a period, after which gravity is not the "
            "same: leave it 0"
        )
    if not scene.orbit.guesses(setup.case.parameters):
        return NoOrbitError(f"{scene.name} has no periodic orbit to follow: {why_none(scene)}")
    if setup.engine.name != REFERENCE and setup.coordinates != scene.coordinates:
        return UsageError(
            f"{setup.engine.name} {setup.model} has other coordinates than {scene.name}: its "
            "orbits cannot be followed"
        )
    return None


def why_no_equilibria(asked: BoundaryRequest) -> MbcheckError | None:
    """Return why there are no equilibria to follow, None if there are."""
    scene = asked.equations
    if asked.setup.engine.name != REFERENCE:
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
    """Return whether a scene with some other parameters is driven nowhere in the window."""
    try:
        parameters = asked.setup.case.parameters.replace(**changes)
    except ParameterError:
        return False
    corners = np.array([[0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]])
    with np.errstate(all="ignore"):
        return is_undriven(asked.equations, asked.window.parameters(parameters)(corners), 4)

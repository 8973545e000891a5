"""What a step costs in stability: by how much methods shift where an orbit loses it.

With a fixed number of steps in a period an engine's discrete flow has orbits of its own, which lose
their stability at another parameter than that of the reference.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np

from ...reference import get_scene
from ...reference.continuation.bifurcations import KINDS
from ...reference.errors import EngineError
from ...reference.scene import Case
from ..checks.kinds import boundary
from ..engines.registry import get_engine
from ..engines.run import EPS
from ..engines.setup import Setup

STEPS = (40, 80, 160, 320, 640)
"""In a period."""

CLEAR = 10
"""Bounds above which a shift tells the order."""


@dataclass(frozen=True)
class BoundaryShift:
    """By how much a method shifts the boundary point of a case, over steps in a period.

    Attributes
    ----------
    scene, case, engine, model, method : str
    order : int
        Declared.
    parameter, unit : str
        At which the orbit loses its stability.
    steps : tuple of int
        In a period.
    shifts, bounds : tuple of float or None
        Its value less the reference's, and what rounding and differences leave of that; None where
        the engine has no such point near.
    slope : float or None
        Order of the last halving above the bounds.
    reason : str
        Why there is none.
    """

    scene: str
    case: str
    engine: str
    model: str
    method: str
    order: int
    parameter: str
    unit: str
    steps: tuple[int, ...]
    shifts: tuple[float | None, ...]
    bounds: tuple[float | None, ...]
    slope: float | None
    reason: str = ""

    @property
    def floor(self) -> float | None:
        """What rounding and differences leave with the most steps that have a point."""
        return next((bound for bound in reversed(self.bounds) if bound is not None), None)


def tasks(
    scenes: Sequence[str], engines: Sequence[str]
) -> Iterator[tuple[str, Callable[[], BoundaryShift]]]:
    """Yield methods of the engines' default models, each ready for a process of its own."""
    cases = [
        case
        for scene in scenes
        for case in get_scene(scene).cases
        if case.boundary and case.boundary.kind in KINDS
    ]
    for case in cases:
        for engine in engines:
            its = get_engine(engine)
            for model, method in product(its.models(case.scene)[:1], its.methods):
                if is_measurable(Setup(its, case, model, method)):
                    name = f"{case.scene} {engine} {method.name}, {case.name}"
                    yield name, partial(boundary_shift, case, engine, model, method.name)


def is_measurable(setup: Setup) -> bool:
    """Return whether a method can run a case, with the scene's equations and all 64 bits."""
    if setup.engine.why_not(setup.case, setup.model, setup.integrator) is not None:
        return False
    return bool(boundary.quantities(setup)) and setup.epsilon <= EPS


def boundary_shift(
    case: Case, engine: str, model: str, method: str, steps: Sequence[int] = STEPS
) -> BoundaryShift:
    """Return by how much a method shifts the boundary of a case.

    Raises
    ------
    NoOrbitError
        If the reference has no such point.
    """
    assert case.boundary is not None
    sought = boundary.true_boundary(case.scene, case.parameters, case.boundary)
    its = get_engine(engine)
    integrator = next(one for one in its.methods if one.name == method)
    setup, true = Setup(its, case, model, integrator), sought.solution[1]
    shifts: list[float | None] = []
    bounds: list[float | None] = []
    reason = ""
    for count in steps:
        shift = bound = None
        try:
            point = boundary.engine_point(setup, sought, count, true.z)
            if point.is_solved:
                shift = sought.unit * float(point.z[-1] - true.z[-1])
                bound = sought.unit * point.bound
        except EngineError as failure:
            reason = failure.message
        shifts.append(shift)
        bounds.append(bound)
    return BoundaryShift(
        scene=case.scene,
        case=case.name,
        engine=engine,
        model=model,
        method=method,
        order=integrator.order,
        parameter=sought.parameter,
        unit=case.parameters.unit_of(sought.parameter),
        steps=tuple(steps),
        shifts=tuple(shifts),
        bounds=tuple(bounds),
        slope=order_of(shifts, bounds),
        reason=reason,
    )


def order_of(shifts: Sequence[float | None], bounds: Sequence[float | None]) -> float | None:
    """Return the order that the last halving above the bounds shows, None where there is none."""
    clear = [
        place
        for place, (shift, bound) in enumerate(zip(shifts, bounds, strict=True))
        if shift is not None and bound is not None and abs(shift) > CLEAR * bound
    ]
    if len(clear) < 2 or clear[-1] - clear[-2] != 1:
        return None
    before, last = (shifts[place] or np.nan for place in clear[-2:])
    return float(np.log2(abs(before / last)))

"""What a step costs in stability: by how much methods shift where an orbit loses it.

With a fixed number of steps in a period an engine's discrete flow has orbits of its own, which lose
their stability at another parameter than that of the reference.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import product

from ...reference import get_scene
from ...reference.continuation.bifurcations import KINDS
from ...reference.errors import EngineError
from ...reference.scene import Case
from ..checks.kinds import boundary
from ..engines.registry import get_engine
from ..engines.run import EPS
from ..engines.setup import Setup
from .table import ROUND_OFF, STEP, Point, StepSeries, slope_of

AXIS = "steps in a period"

STEPS = (40, 80, 160, 320, 640)
"""In a period."""

CLEAR = 10
"""Bounds above which a shift tells the order."""


def tasks(
    scenes: Sequence[str], engines: Sequence[str]
) -> Iterator[tuple[str, Callable[[], StepSeries]]]:
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
) -> StepSeries:
    """Return by how much a method shifts the boundary of a case, over steps in a period.

    The errors are shifts of the parameter; under its name in ``errors`` they have a sign.

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
    points = []
    for count in steps:
        one = Point(None, None, value=count)
        try:
            point = boundary.engine_point(setup, sought, count, true.z)
            if point.is_solved:
                shift = sought.unit * float(point.z[-1] - true.z[-1])
                bound = sought.unit * point.bound
                label = STEP if abs(shift) > CLEAR * bound else ROUND_OFF
                signed = {sought.parameter: shift}
                one = Point(None, abs(shift), signed, label=label, value=count, bound=bound)
        except EngineError as failure:
            one = replace(one, reason=failure.message)
        points.append(one)
    clear = [one for one in points if one.label == STEP]
    return StepSeries(
        case.scene, case.name, engine, model, method, integrator.order, {}, tuple(points),
        slope=slope_of(clear[-2:]),
        plateau=next((one.bound for one in reversed(points) if one.bound is not None), None),
        plateau_name="round-off",
        axis=AXIS,
        unit=case.parameters.unit_of(sought.parameter),
        quantity=sought.parameter,
    )  # fmt: skip

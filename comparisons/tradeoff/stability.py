"""The cost of a step in stability: shifts of the parameter at which an orbit loses it.

With a fixed number of steps in a period, orbits of an engine's discrete flow lose their stability
at another parameter than orbits of the reference.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import log2

from ...reference import get_scene
from ...reference.continuation.bifurcations import KINDS
from ...reference.errors import EngineError
from ..checks import boundary
from ..engines.registry import get_engine
from ..engines.run import EPS
from ..engines.setup import Setup
from ..queries.query import choose_method
from .table import MeasuredCase
from .tuning import SWEEP


@dataclass(frozen=True)
class StabilityShift(MeasuredCase):
    """Shift of a boundary of stability by a method.

    Attributes
    ----------
    model : str
        The engine's model of the scene.
    method : str
        Integrator.
    order : int
        Declared order.
    parameter : str
        Parameter of the boundary.
    unit : str
        Unit of the parameter.
    shifts : mapping of str to float or None
        Number of steps in a period -> shift of the parameter; null if the engine has no such orbit.
    problems : mapping of str to str
        Number of steps in a period -> failure of the engine.
    slope : float or None
        Order of the last halving with shifts above the floor; null if there are fewer than two.
    floor : float or None
        Largest shift by round-off with the most steps; null if there is no shift.
    """

    model: str
    method: str
    order: int
    parameter: str
    unit: str
    shifts: Mapping[str, float | None]
    problems: Mapping[str, str]
    slope: float | None
    floor: float | None


def boundaries_of(
    scenes: Sequence[str], engines: Sequence[str]
) -> Iterator[tuple[str, tuple[str, str, str, str, str]]]:
    """Yield name and arguments of each `shift`: methods that can find a boundary of a case.

    Each engine runs its default model.
    """
    cases = [
        case
        for scene in scenes
        for case in get_scene(scene).cases
        if case.boundary and case.boundary.kind in KINDS
    ]
    for case, name in product(cases, engines):
        engine = get_engine(name)
        for model, method in product(engine.models(case.scene)[:1], engine.methods):
            setup = Setup(engine, case, model, method)
            if not setup.unsupported_reason and boundary.quantities(setup) and setup.epsilon <= EPS:
                names = case.scene, case.name, name, model, method.name
                yield f"{case.scene} {name} {method.name}, {case.name}", names


def shift(
    scene: str,
    case_name: str,
    name: str,
    model: str,
    method: str,
    steps: Sequence[int] = SWEEP.steps_in_period,
) -> StabilityShift:
    """Return the shift of a boundary of a case by a method, over steps in a period.

    Raises
    ------
    NoOrbitError
        If the reference has no such point.
    """
    case, engine = get_scene(scene).case(case_name), get_engine(name)
    assert case.boundary is not None
    sought = boundary.true_boundary(scene, case.parameters, case.boundary)
    integrator = choose_method(engine, case, model, method)
    setup, true = Setup(engine, case, model, integrator), sought.solution[1]
    shifts, problems = dict[str, float | None](), dict[str, str]()
    clear, floor = list[float](), None
    for count in steps:
        shifts[str(count)] = None
        try:
            point = boundary.engine_point(setup, sought, count, true.z)
        except EngineError as failure:
            problems[str(count)] = failure.message
            continue
        if point.is_solved:
            moved = sought.unit * float(point.z[-1] - true.z[-1])
            shifts[str(count)], floor = moved, sought.unit * point.bound
            clear += [abs(moved)] if abs(moved) > SWEEP.clear_shift * floor else []
    return StabilityShift(
        scene, case.name, name, model, method, integrator.order, sought.parameter,
        case.parameters.unit_of(sought.parameter), shifts, problems,
        log2(clear[-2] / clear[-1]) if len(clear) > 1 else None, floor,
    )  # fmt: skip

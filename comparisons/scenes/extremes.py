"""Extremes of a scene, and the checks that follow from them.

Parameters are pushed at a step that suits them and at the usual one; so are starts. Every known
failure of an engine is provoked where a scene can.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ...reference import get_scene
from ...reference.errors import UnknownNameError
from ...reference.scene import Case
from ..checks.kinds.long_runs import FREE, LOCKED, WINDOW, free_mode, started
from ..checks.kinds.pushed import FEWEST
from ..checks.suite import Check, best_method, matching
from ..checks.table import EXTREMES
from ..engines.registry import REFERENCE, get_engine, resolve_selection
from ..engines.setup import Setup, default_step, power_of_two, shortest_period
from ..faults.variants import EXTRA_METHODS, LONG_METHODS, Variant
from .data import scene_data


@dataclass(frozen=True, kw_only=True)
class Extreme:
    """A case of a scene with parameters or a start that ask much of an engine.

    Attributes
    ----------
    name : str
    case : str
        Of the scene; what follows does not name, it gives.
    changes : mapping of parameter to value
        (SI)
    state : mapping of str to float, or None
        Initial values in place of those of the case.
    offset : mapping of str to float
        By how much a loop is open at the start.
    models : tuple of str
        Models that are run where an engine has them, in place of its default.
    horizon : float or None
        [s]; None for a few periods.
    full : bool
        Whether it is left out of the default set.
    """

    name: str
    case: str
    changes: Mapping[str, Any] = field(default_factory=dict)
    state: Mapping[str, float] | None = None
    offset: Mapping[str, float] = field(default_factory=dict)
    models: tuple[str, ...] = ()
    horizon: float | None = None
    full: bool = False

    def altered(self, scene: str) -> Case:
        """Return the case at the extreme."""
        case = get_scene(scene).case(self.case)
        return replace(
            case,
            name=self.name,
            parameters=case.parameters.replace(**self.changes),
            state=case.state if self.state is None else self.state,
            inconsistency=self.offset or case.inconsistency,
            full_only=self.full,
            placement="",
        )

    @property
    def alterations(self) -> dict[str, Any]:
        """Changed parameters and initial values, and the opening of the loop."""
        opened = {f"{name} off by": value for name, value in self.offset.items()}
        return {**self.changes, **(self.state or {}), **opened}


@dataclass(frozen=True, kw_only=True)
class EngineFailure(Extreme):
    """One way to fail, or a run beside it that does not, by one method of one engine.

    Attributes
    ----------
    engine : Variant
    method : str
    step : float
        [s]
    settings : mapping of str to float or str
        Settings of the variant, in words of the engine.
    harmless : bool
        Whether it is right: with these versions and in this scene the failure does not come about.
    """

    engine: Variant
    method: str
    step: float
    settings: Mapping[str, float | str] = field(default_factory=dict)
    harmless: bool = False

    @property
    def alterations(self) -> dict[str, Any]:
        """Changed parameters, initial values and settings of the engine."""
        return {**super().alterations, **self.settings}


@dataclass(frozen=True)
class LongMotion:
    """A long motion.

    Attributes
    ----------
    kind : str
        `FREE`, `CONSERVATIVE`, `LOCKED` or `AFTER_PULSE`.
    case : str
        Of the scene; gives the parameters and, but for `FREE` and `LOCKED`, the start.
    segments : int
        Of a continuum, 0 for the case's own.
    periods : (int, int)
        How long it is followed: by default, and in full.
    most_steps : mapping of engine to int
        Where the steps of an engine take so long that a run is cut earlier than others.
    """

    kind: str
    case: str
    segments: int = 0
    periods: tuple[int, int] = (1_000, 10_000)
    most_steps: Mapping[str, int] = field(default_factory=dict)

    def of(self, scene: str, periods: int) -> Case:
        """Return the case, named after its kind of motion."""
        case = replace(get_scene(scene).case(self.case), watch=self.kind, placement="")
        if self.segments:
            case = replace(case, parameters=case.parameters.replace(segments=self.segments))
        return replace(case, name=f"{self.kind}_{periods}_periods")


# The checks that follow ---------------------------------------------------------------------

PERIODS = 4
"""Shortest periods that a run lasts."""

MOST_STEPS = {1: 8192, 2: 4096}
"""Most steps of a run, by order of the method, 2048 without; those of order 1 need many."""

USUAL_STEPS = 100
"""Fewest usual steps that a run with the usual step lasts."""

START_LONGER = 4
"""Factor on the most steps of runs from a start."""

LONG_STEPS, LONG_STEPS_CONSTRAINED = 1 << 20, 1 << 18
"""Most steps of a long run by default, ten times as many in full; constraints make steps dear."""

COARSER: Mapping[int, float] = {1: 8.0, 2: 4.0, 3: 2.0, 4: 2.0, 5: 2.0, 6: 2.0}
"""Steps in those by default, by order: long runs are made with coarse steps."""

COARSEST_ELEMENTS = 2.0
"""The same of a continuum: Newton's method finds no solution far beyond the default."""

FINEST_TURN = 128
"""Steps in a period of a rotation that a coarse step leaves, at least."""


def extreme_checks(
    scenes: Sequence[str] = (),
    engines: Sequence[str] = (),
    kinds: Sequence[str] = (),
    methods: Sequence[str] = (),
    ids: Sequence[str] = (),
    full: bool = False,
) -> list[Check]:
    """Return the checks of extremes that match, as `checks.suite.plan` does of others.

    Failures of the reference belong to all engines.

    Raises
    ------
    UsageError
        For an unknown name, a missing engine, or an empty selection.
    """
    for name in kinds:
        if name not in EXTREMES:
            raise UnknownNameError("kind of extreme", name, tuple(EXTREMES))
    scenes, engines = resolve_selection(scenes, engines)
    checks = [
        check
        for kind in EXTREMES
        if kind in (kinds or EXTREMES)
        for scene in scenes
        for engine in (*engines, REFERENCE)
        for check in PLANS[kind](kind, scene, engine)
    ]
    return matching(checks, engines, methods, ids, full)


def check_of(
    kind: str, setup: Setup, extreme: Extreme | None = None, variant: Variant | None = None
) -> Check:
    """Return the check of a setup at an extreme."""
    changes = extreme.alterations.items() if extreme else ()
    words = (f"{k}={v:.10g}" if isinstance(v, float) else f"{k}={v}" for k, v in changes)
    return Check(
        kind=kind,
        case=setup.case,
        engine=setup.engine.name,
        model=setup.model,
        method=setup.method,
        quantities=EXTREMES[kind].quantities(setup),
        default_model=setup.model == setup.engine.models(setup.case.scene)[0],
        full_only=setup.case.full_only,
        unsupported_reason=setup.unsupported_reason,
        step=setup.step,
        variant=variant,
        provoked_by=", ".join(words),
    )


def pushed(kind: str, scene: str, engine: str) -> Iterator[Check]:
    """Yield the checks of parameters or starts at extremes."""
    table: tuple[Extreme, ...] = scene_data(scene, "extremes", kind.upper(), ())
    for extreme in table if engine != REFERENCE else ():
        adapter, case = get_engine(engine), extreme.altered(scene)
        known = adapter.models(scene)
        for model in [name for name in extreme.models if name in known] or known[:1]:
            setup = Setup(adapter, case, model)
            best = replace(setup, method=best_method(setup))
            if best.method is None:
                yield check_of(kind, best, extreme)
                continue
            runs = parameter_runs if kind == "parameters" else start_runs
            yield from (check_of(kind, one, extreme) for one in runs(best, extreme))


def parameter_runs(best: Setup, extreme: Extreme) -> Iterator[Setup]:
    """Yield runs with a step that suits the parameters, and with the one that a user leaves."""
    case = best.case
    usual = get_scene(case.scene).case(extreme.case)
    extra = () if best.scene.discretisation_coordinates else EXTRA_METHODS.get(best.engine.name, ())
    others = [one for one in best.engine.methods if one.name in extra and one != best.method]
    for setup in (best, *(replace(best, method=method) for method in others)):
        if setup.unsupported_reason is not None:
            continue
        horizon = extreme.horizon or PERIODS * shortest_period(case)
        steps = {"": setup.default_step, "_kept_step": setup.with_case(usual).default_step}
        if steps[""] == steps["_kept_step"]:
            del steps["_kept_step"]
        for suffix, step in steps.items():
            longest = MOST_STEPS.get(setup.integrator.order, 2048) * step
            most = max(min(horizon, longest), USUAL_STEPS * step if suffix else FEWEST * step)
            named = replace(case, name=case.name + suffix, horizon=most)
            yield setup.with_case(named).with_step(step)


def start_runs(best: Setup, extreme: Extreme) -> Iterator[Setup]:
    """Yield the run from a start, with a step that suits it."""
    step = best.default_step
    longest = START_LONGER * MOST_STEPS.get(best.integrator.order, 2048) * step
    horizon = max(min(extreme.horizon or longest, longest), FEWEST * step)
    yield best.with_case(replace(best.case, horizon=horizon)).with_step(step)


def failures(kind: str, scene: str, engine: str) -> Iterator[Check]:
    """Yield the checks of failures that are provoked."""
    table: tuple[EngineFailure, ...] = scene_data(scene, "extremes", "FAILURES", ())
    for failure in table:
        if failure.engine.engine == engine:
            made = failure.engine.make()
            method = next(one for one in made.methods if one.name == failure.method)
            case = failure.altered(scene)
            horizon = max(failure.horizon or case.horizon, FEWEST * failure.step)
            case = replace(case, horizon=horizon)
            setup = Setup(made, case, failure.models[0], method, failure.step)
            yield check_of(kind, setup, failure, failure.engine)


def limits(kind: str, scene: str, engine: str) -> Iterator[Check]:
    """Yield the checks of the largest stable step of each method of each model.

    The scene vibrates freely: without forces and dampers, and with what its table
    `FREE_VIBRATION` changes of all models (named "") or of one.
    """
    table: Mapping[str, Mapping[str, Any]] = scene_data(scene, "extremes", "FREE_VIBRATION", {})
    adapter, known = get_engine(engine), get_scene(scene)
    p = known.unforced(known.parameters())
    p = p.replace(**{name: 0.0 for name in p.names() if "damping" in name}, **table.get("", {}))
    for model in adapter.distinct_models(scene) if engine != REFERENCE else ():
        case = Case(scene, "free_vibration", p.replace(**table.get(model, {})))
        setup = Setup(adapter, case, model)
        if not setup.bound.approximates_continuum:
            for method in adapter.methods:
                yield check_of(kind, replace(setup, method=method))


def long_runs(kind: str, scene: str, engine: str) -> Iterator[Check]:
    """Yield the checks of motions that are followed for long.

    A model beside the default one that has no constraints is run by the best method alone.
    """
    table: tuple[LongMotion, ...] = scene_data(scene, "extremes", "MOTIONS", ())
    adapter = get_engine(engine)
    for model in adapter.distinct_models(scene) if engine != REFERENCE else ():
        for motion in table:
            for full, periods in enumerate(motion.periods):
                setup = Setup(adapter, motion.of(scene, periods), model)
                if setup.unsupported_reason:
                    continue
                every = [replace(setup, method=method) for method in adapter.methods]
                usable = {one.integrator.name: one for one in every if is_followed(one)}
                names = [name for name in LONG_METHODS.get(engine, usable) if name in usable]
                if model != adapter.models(scene)[0] and not setup.bound.has_constraints:
                    names = names[:1]
                for name in names:
                    one = prepared(usable[name], motion, periods, bool(full))
                    yield check_of(kind, one)


def is_followed(setup: Setup) -> bool:
    """Return True if a method follows a motion, and tells something new.

    Without constraints the method of index 2 is the trapezoidal rule. What an implicit Euler makes
    of soft closures is not known: it takes only springs at the end of a step.
    """
    linear = setup.integrator.linear_scheme
    if setup.unsupported_reason or (linear == "trapezoidal" and not setup.bound.has_constraints):
        return False
    late = linear == "implicit_euler" and setup.bound.has_soft_closure
    return setup.case.watch != FREE or (setup.linear_scheme is not None and not late)


def prepared(setup: Setup, motion: LongMotion, periods: int, full: bool) -> Setup:
    """Return a motion with its start, its coarse step and its horizon, cut where it is dear."""
    case, step = setup.case, coarse_step(setup)
    period = shortest_period(case)
    if motion.kind == FREE:
        mode = free_mode(case)
        case, period = started(case, mode), 2 * np.pi / mode.omega
        setup = setup.with_case(case)
        step = min(coarse_step(setup), power_of_two(period / WINDOW))
    if motion.kind == LOCKED:
        period = float(setup.scene.period(case.parameters))
        if not setup.bound.has_soft_closure:  # its vibrations are faster than its turns
            step = max(step, min(4 * step, period / FINEST_TURN))
    most = LONG_STEPS_CONSTRAINED if setup.bound.has_constraints else LONG_STEPS
    most = motion.most_steps.get(setup.engine.name, most) * (10 if full else 1)
    horizon = min(periods, int(most * step / period)) * period
    case = replace(case, horizon=horizon, full_only=full)
    return setup.with_case(case).with_step(step)


def coarse_step(setup: Setup) -> float:
    """Return a long step [s], a power of two, that the model's own equations bear."""
    factor = COARSER[min(setup.integrator.order, 6)]
    if setup.scene.discretisation_coordinates:
        factor = min(factor, COARSEST_ELEMENTS)
    bound = setup.stable_step_bound
    step = factor * default_step(setup.case, setup.integrator)
    return float(min(step, power_of_two(bound) if np.isfinite(bound) else np.inf))


PLANS: Mapping[str, Callable[[str, str, str], Iterator[Check]]] = {
    "limits": limits,
    "parameters": pushed,
    "starts": pushed,
    "long": long_runs,
    "failures": failures,
}
"""Function that yields the checks of each kind."""

"""The table of checks, and how it is run. CLI, pytest and reports all read from here."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from fnmatch import fnmatchcase
from time import perf_counter
from typing import TypeVar

from ...reference import get_scene
from ...reference.equations import function_that_raised
from ...reference.errors import (
    BrokenEngineError,
    CannotJudgeError,
    EngineError,
    MbcheckError,
    UnknownNameError,
    Unsupported,
    UsageError,
)
from ...reference.scene import Case
from ..engines.adapter import Adapter
from ..engines.protocol import Method
from ..engines.registry import (
    ENGINES,
    broken_engines,
    get_engine,
    resolve_selection,
)
from ..engines.run import describe, excerpt, noting, place_of, traceback_of
from ..engines.setup import Setup
from ..faults.variants import Variant
from .comparison import Measured
from .diagnosis import Deviation, cause
from .mistakes.observables import other_measures
from .refusals import refuse_undriven
from .rules.cautions import Caution, cautions, explained, noticing_rules
from .table import EVERY_KIND, EXTREMES, KINDS, Kind
from .verdict import (
    ENGINE,
    PROFILES,
    REFERENCE,
    Finding,
    Result,
    Subject,
    detected_by,
)


class Task(ABC):
    """One measurement of one quantity or several, as `run_checks` runs it.

    Attributes
    ----------
    engine : str
        Name of the engine.
    quantities : tuple of str
    loaded_as : str or None
        ``package.module:Class`` of an engine that was given so.
    """

    engine: str
    quantities: tuple[str, ...]
    loaded_as: str | None = None

    @property
    @abstractmethod
    def subject(self) -> Subject:
        """The subject of its results."""

    @property
    def effort(self) -> float:
        """Approximate duration relative to others, for estimates."""
        return 0.2 if not self.integrates else 5.0 if self.takes_long else 1.0

    @property
    @abstractmethod
    def group(self) -> tuple[str, str, str]:
        """Owner, scene and case: tasks of one group run in the same process.

        A third-party engine owns its tasks, by its name: its code may change others in the same
        process. The owner of all other tasks is empty.
        """

    @property
    def integrates(self) -> bool:
        """Whether it follows a motion; what does not is cheap, and comes first."""
        return True

    @property
    @abstractmethod
    def takes_long(self) -> bool:
        """Whether it is to start early."""

    @abstractmethod
    def run(self, profile: str) -> list[Result]:
        """Return its results, whatever goes wrong."""

    @property
    def participants(self) -> tuple[str, ...]:
        """The engines that take part."""
        return (self.engine,)

    @property
    def prefix(self) -> str:
        """The common part of the ids of its results."""
        return self.subject.prefix

    @property
    def ids(self) -> tuple[str, ...]:
        """Ids of its results."""
        return tuple(f"{self.prefix}/{name}" for name in self.quantities)

    @property
    def extreme(self) -> bool:
        """Whether it is of an extreme: the engine may crash or hang."""
        return False

    def failed(
        self, reason: str, traceback: str = "", noticed_by: tuple[str, ...] = (ENGINE,)
    ) -> list[Result]:
        """Return an error for each quantity, where foreign code raised it, and who noticed."""
        where = excerpt(traceback) or None
        return [
            self.subject.result(name, "error", reason, traceback=where, noticed_by=noticed_by)
            for name in self.quantities
        ]

    def skipped(self, reason: str, noticed_by: tuple[str, ...] = ()) -> list[Result]:
        """Return that no quantity is judged, why, and who noticed."""
        return [
            self.subject.result(name, "skipped", reason, noticed_by=noticed_by)
            for name in self.quantities
        ]


@dataclass(frozen=True)
class Check(Task):
    """Case x kind x engine x model x method: one measurement, several quantities.

    Attributes
    ----------
    kind, engine, model : str
    case : Case
    method : Method or None
        None for kinds that use no integrator.
    quantities : tuple of str
    default_model : bool
        Whether the model is the engine's first.
    full_only : bool
        Left out of the default set.
    unsupported_reason : str or None
        Why it cannot run, in which case it is skipped.
    loaded_as : str or None
        ``package.module:Class`` of an engine that was given so.
    step : float or None
        Step of a run at an extreme [s].
    variant : Variant or None
        What is run in place of the engine of this name.
    provoked_by : str
        What an extreme changes, in words.
    """

    kind: str
    case: Case
    engine: str
    model: str
    method: Method | None
    quantities: tuple[str, ...]
    default_model: bool = True
    full_only: bool = False
    unsupported_reason: str | None = None
    loaded_as: str | None = None
    step: float | None = None
    variant: Variant | None = None
    provoked_by: str = ""

    def setup(self, engine: Adapter | None = None) -> Setup:
        """Return the setup of the check, of the engine of this name or of another one."""
        if engine is None and self.variant is not None:
            engine = self.variant.make()
        engine = engine or get_engine(self.loaded_as or self.engine)
        return Setup(engine, self.case, self.model, self.method, self.step)

    @property
    def extreme(self) -> bool:
        """Whether it is of an extreme."""
        return self.kind in EXTREMES

    @property
    def subject(self) -> Subject:
        """The subject of its results."""
        how, method = self.model, None
        if self.method is not None:
            method = self.method.name
            how = method if self.default_model else f"{method}@{self.model}"
        scene, case = self.case.scene, self.case.label
        prefix = f"verification/{scene}/{case}/{self.kind}/{self.engine}/{how}"
        return Subject(
            prefix, "verification", self.engine, scene, case, self.kind, self.model, method
        )

    @property
    def group(self) -> tuple[str, str, str]:
        """Owner, scene and case; checks of one group share the reference of the case."""
        owner = "" if self.engine in ENGINES else self.engine
        return owner, self.case.scene, self.case.name

    @property
    def integrates(self) -> bool:
        """Whether its kind integrates."""
        return EVERY_KIND[self.kind].integrates

    @property
    def takes_long(self) -> bool:
        """Whether it follows an orbit, or the motion of a stiff scene."""
        stiff = get_scene(self.case.scene).stiff is not None
        return self.kind in ("stability", "long") or (stiff and self.kind == "trajectory")

    def run(self, profile: str) -> list[Result]:
        """Return its results, see `run_check`, and what provoked them."""
        results = run_check(self, profile)
        if not self.provoked_by:
            return results
        return [replace(one, reason=f"{self.provoked_by}: {one.reason}") for one in results]


def plan(
    scenes: Sequence[str] = (),
    engines: Sequence[str] = (),
    kinds: Sequence[str] = (),
    methods: Sequence[str] = (),
    ids: Sequence[str] = (),
    full: bool = False,
) -> list[Check]:
    """Return the checks that match; empty sequences mean all.

    Parameters
    ----------
    scenes, engines, kinds, methods : sequence of str
    ids : sequence of str
        Shell patterns (``*``, ``?``) for ids.
    full : bool
        Include checks beyond the default set.

    Raises
    ------
    UsageError
        For an unknown name, a missing engine, or if no check matches.
    """
    scenes, engines = resolve_selection(scenes, engines)
    every = [get_scene(scene) for scene in scenes]
    cases = [case for scene in every for case in (*scene.cases, *scene.placed)]
    return plan_cases(cases, engines, kinds, methods, ids, full)


def plan_cases(
    cases: Iterable[Case],
    engines: Sequence[str],
    kinds: Sequence[str] = (),
    methods: Sequence[str] = (),
    ids: Sequence[str] = (),
    full: bool = False,
) -> list[Check]:
    """Return the checks of some cases and engines that match; the rest as of `plan`."""
    for name in kinds:
        if name not in KINDS:
            raise UnknownNameError("kind of check", name, tuple(KINDS))
    checks = [
        check
        for case in cases
        for kind in kinds_of(case)
        if not kinds or kind in kinds
        for engine in engines
        for check in planned(kind, case, engine)
    ]
    return matching(checks, engines, methods, ids, full)


def matching(
    checks: Sequence[Check],
    engines: Sequence[str],
    methods: Sequence[str],
    ids: Sequence[str],
    full: bool,
) -> list[Check]:
    """Return those of some checks of engines that match; see `plan`."""
    failed = broken_engines(engines)
    sound = [get_engine(name) for name in engines if name not in failed]
    every = [method.name for engine in sound for method in engine.methods]
    for name in methods:
        if sound and name not in every:
            raise UnknownNameError("method", name, every)
    checks = [
        check
        for check in checks
        if (check.loaded_as or check.engine) not in failed
        and (not methods or (check.method is not None and check.method.name in methods))
    ]
    if failed or not engines:
        checks = [check for check in checks if full or not check.full_only]
        return [check for check in checks if not ids or matches(check, ids)]
    checks = narrowed(checks, "these scenes, kinds and methods", lambda one: True)
    checks = narrowed(checks, f"--id {' '.join(ids)}", lambda one: not ids or matches(one, ids))
    return narrowed(checks, "a run without --full", lambda one: full or not one.full_only)


T = TypeVar("T", bound=Task)


def narrowed(tasks: Sequence[T], option: str, keeps: Callable[[T], bool]) -> list[T]:
    """Return the tasks that an option keeps.

    Raises
    ------
    UsageError
        If it keeps none; the message names the option, and the nearest ids.
    """
    left = [task for task in tasks if keeps(task)]
    if left:
        return left
    ids = [name for task in tasks for name in task.ids]
    near = get_close_matches(option.partition(" ")[2].replace("*", ""), ids, cutoff=0)
    hint = f"nearest ids: {', '.join(near)}" if near else "`mbcheck list` shows what there is"
    raise UsageError(f"no check matches: none is left by {option}; {hint}")


def planned(kind: str, case: Case, engine_name: str) -> list[Check]:
    """Return the checks of `checks_of`; none if the engine fails."""
    try:
        return list(checks_of(kind, case, engine_name))
    except BrokenEngineError:
        if not broken_engines([engine_name]):
            raise
        return []  # `execution.unavailable` tells it


def quick(checks: Sequence[Check]) -> list[Check]:
    """Return checks that give a quick answer: each level once, in its first case.

    *parts*, *algebra* and *step* of each model but twins, *step* also of twins with another case
    than the default model's, and *trajectory* by the best method of the default model; one of each
    scene that an engine does not support, which says why.
    """
    seen, first, steps = set[tuple[str, ...]](), list[Check](), set[tuple[str, ...]]()
    for check in checks:
        level = check.case.scene, check.engine, check.kind
        here = *level, check.case.label
        key = level if check.kind == "trajectory" else (*level, check.model)
        if not KINDS[check.kind].quick or key in seen or check.unsupported_reason is not None:
            continue
        twins = check.setup().engine.twins(check.case.scene)
        if check.model in twins and not (check.kind == "step" and here in steps):
            continue
        if check.kind == "trajectory" and check.method != best_method(check.setup()):
            continue
        seen.add(key)
        steps.add(here)
        first.append(check)
    supported = {
        (check.case.scene, check.engine) for check in checks if check.unsupported_reason is None
    }
    refused = {(check.case.scene, check.engine): check for check in reversed(checks)}
    return [*first, *(check for pair, check in refused.items() if pair not in supported)]


def kinds_of(case: Case) -> tuple[str, ...]:
    """Return the kinds of check of a case, from its parts to its motion."""
    return tuple(
        name
        for name, kind in KINDS.items()
        if name in case.kinds or (kind.follows in case.kinds and case.watch != "elements")
    )


def checks_of(kind: str, case: Case, engine_name: str) -> Iterator[Check]:
    """Yield the checks of one kind, case and engine.

    The default set has all kinds of the engine's default model. Of other models it has trajectories
    by the best method, and no orbits, which take longest. Of a boundary it has that of the default
    model by the best method. A model with another drive has the kinds of a quick answer alone, by
    the best method in the first case, and in cases with a torque. Of single steps it has the best
    method of each model, of elements, whose reference takes long, in one of the scene's cases.
    """
    engine = get_engine(engine_name)
    what = KINDS[kind]
    models = engine.models(case.scene)
    # where a run ends is the scene's doing: one model of each engine will do
    twins = engine.twins(case.scene)
    for model in models[:1] if case.watch == "outcome" else models:
        if model in twins and (
            not what.quick or engine.bind(case, model).unsupported_reason(case, None)
        ):
            continue
        beside, top = model != models[0], best_method(Setup(engine, case, model))
        for method in integrators(Setup(engine, case, model), kind):
            setup = Setup(engine, case, model, method)
            left = kind == "stability" and (beside or (case.boundary is not None and method != top))
            if kind == "step" or (kind == "trajectory" and beside):
                left = method != top
            if kind == "step" and setup.bound.discrete:
                left = left or case.name in later_motions(case.scene)
            if model in twins and case.methods != "best":
                left = left or case.name in later_motions(case.scene)
            if quantities := what.quantities(setup):
                yield Check(
                    kind,
                    case,
                    engine.name,
                    model,
                    method,
                    quantities,
                    not beside,
                    case.full_only or left,
                    setup.unsupported_reason,
                    engine_name if engine_name != engine.name else None,
                )


def later_motions(scene: str) -> list[str]:
    """Return the cases of a scene that are simulated, but for the first."""
    return [one.name for one in get_scene(scene).cases if "trajectory" in one.kinds][1:]


def integrators(setup: Setup, kind: str) -> tuple[Method | None, ...]:
    """Return the methods that a kind of check is made with.

    If the solvers of an engine differ in accelerations, each is checked.
    """
    case = setup.case
    if not KINDS[kind].integrates or case.watch == "elements":
        by_method = KINDS[kind].asks_forces and setup.engine.takes_method
        return setup.engine.methods if by_method else (None,)
    if case.methods == "best" and kind != "order":
        best = best_method(setup)
        return () if best is None else (best,)
    return setup.engine.methods


def best_method(setup: Setup) -> Method | None:
    """Return the method of highest order that a model takes."""
    reason, case = setup.bound.unsupported_reason, setup.case
    methods = [method for method in setup.engine.methods if reason(case, method) is None]
    return max(methods, key=lambda method: method.order, default=None)


def matches(check: Task, patterns: Iterable[str]) -> bool:
    """Return True if a pattern matches one of the check's ids."""
    return any(fnmatchcase(name, pattern) for name in check.ids for pattern in patterns)


def run_check(
    check: Check, profile: str = "default", engine: Adapter | None = None, explain: bool = True
) -> list[Result]:
    """Run one check; whatever goes wrong becomes results, one for each of its quantities.

    With ``explain`` they say where deviations may come from, which may run the engine again.
    """
    if check.unsupported_reason is not None:
        return check.skipped(check.unsupported_reason, (ENGINE,))
    begin, kind = perf_counter(), EVERY_KIND[check.kind]
    setup: Setup | None = None
    try:
        setup = check.setup(engine)
        if setup.engine.reads_mjcf and not setup.bound.integrates_drive:
            refuse_undriven(setup)
        if kind.refuse:
            kind.refuse(setup)
        with noting() as notes:
            measured = kind.measure(setup)
    except CannotJudgeError as error:
        said = cautioned(setup) if check.step is not None else []
        refused = (ENGINE,) if isinstance(error, Unsupported) else ()
        return check.skipped(str(error), (*refused, *noticing_rules(said)))
    except EngineError as error:
        said = cautioned(setup if explain else None)
        reason = explained(f"{error.kind}: {error.message}", said)
        return check.failed(reason, error.traceback, (detected_by(error), *noticing_rules(said)))
    except MbcheckError as error:
        return check.failed(str(error), error.traceback)
    except (Exception, SystemExit) as error:  # must not take the other checks along
        reason = origin(setup, error) + describe(error) + place_of(error)
        return check.failed(reason, traceback_of(error))
    work = {"seconds": perf_counter() - begin}
    about, results = check.subject, list[Result]()
    for finding in measured.findings:
        result = about.with_verdict(finding, PROFILES[profile], work=work)
        if isinstance(finding, Finding):
            noticed = () if result.verdict == "pass" else finding.noticed_by or (REFERENCE,)
            reason = "; ".join([result.reason, *(f"note: {text}" for text in notes)])
            result = replace(result, reason=reason, noticed_by=noticed)
        results.append(result)
    lost = set(check.quantities) - {item.quantity for item in results}
    results += [about.result(name, "error", "was not measured") for name in sorted(lost)]
    return with_causes(results, setup, kind, measured) if explain else results


def with_causes(
    results: list[Result], setup: Setup, kind: Kind, measured: Measured
) -> list[Result]:
    """Return results; those that deviate name their cause and the rules that warn of the run.

    If no mistake alone explains all, the unit or sign of each observable may explain it.
    """
    verdicts = {one.quantity: one.verdict for one in results if one.verdict != "skipped"}
    if "deviation" not in verdicts.values() or not kind.level:
        return results
    where = cause(
        Deviation(setup, kind.measure, verdicts, measured.runs, kind.asks_forces), kind.searches
    )
    said, measures = cautioned(setup), dict[str, str]()
    if measured.runs and not where:
        measures = other_measures(measured.runs, least=0.0)
    rules, explained_results = noticing_rules(said), []
    for one in results:
        if one.verdict == "deviation":
            words = filter(None, (one.reason, measures.get(one.quantity), where))
            reason = explained("; ".join(words), said)
            one = replace(one, reason=reason, cause=where or None)
        noticed = (*rules, REFERENCE) if one.noticed_by == (REFERENCE,) else one.noticed_by
        explained_results.append(replace(one, noticed_by=noticed))
    return explained_results


def origin(setup: Setup | None, error: BaseException) -> str:
    """Return the engine and function whose own equations raised an exception, for messages."""
    try:
        if setup is None or setup.bound.is_exact:
            return ""
        own = setup.bound.discrete, setup.bound.equations
    except Exception:  # an engine that fails in telling them, too
        return ""
    for equations in filter(None, own):
        if function := function_that_raised(equations, error):
            return f"{setup.engine.name}: describe_model: {function} of its equations: "
    return ""


def cautioned(setup: Setup | None) -> list[Caution]:
    """Return the cautions against a run with the setup's step."""
    if setup is None or setup.method is None:
        return []
    try:
        return cautions(setup, setup.case.horizon)
    except (EngineError, CannotJudgeError):  # of an engine that fails in this too
        return []

"""``check``: what is asked for, and the checks that follow from it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from typing import Any

from ...models.placement import world_axes
from ...reference import get_scene
from ...reference.errors import UnknownNameError, UsageError
from ..checks import known as known_deviations
from ..checks import suite
from ..checks.execution import Execution, run_checks, unavailable
from ..checks.refusals import narrowed
from ..checks.verdict import PROFILES, Result
from ..engines.protocol import Engine
from ..engines.registry import LENT, checked_engines, lent, resolve_selection
from ..queries.environment import environment, versions
from ..reports.run.outcome import Report, Run
from .custom import NAME as CUSTOM
from .custom import CustomCase, applied, custom_case

SOURCES = ("verification", "validation")
"""What results are about: engines, or papers. The first is checked by default."""

AS_THEY_STAND = "none"
"""The placement of models that are not placed."""

PLACED = re.compile(r"@((?:turned|mirrored):[0-9]+)/")
"""In an id, how a model is placed."""

HERE = "mbcheck.check(engines=[...], ids=[the id]), or mbcheck check --in-process --id ID"
"""What repeats a check of an engine that ran in this process."""

Progress = Callable[[int, int, list[Result]], None]
"""Called as each check ends with the number of checks done, that of all, and the results."""


@dataclass(frozen=True)
class CheckRequest:
    """What is to be checked, and what the results are held against.

    Attributes
    ----------
    scenes, engines, kinds, methods : sequence of str
        Names; empty sequences mean all.
    ids : sequence of str
        Shell patterns for ids of results.
    profile : {"strict", "default", "loose"}
        Scales every tolerance.
    full : bool
        Include the cases left out of the default set.
    known : str or None
        A file of known deviations, see docs/ci.md.
    strict_known : bool
        Whether its stale entries fail.
    quick : bool
        Leave out all but what `suite.quick` chooses.
    parameters, state : mapping
        Parameters that differ from the scene's defaults; initial values, otherwise 0. Any of
        these two or a horizon makes a case of the user's own, in place of the scene's.
    horizon : float or None
        Of that case [s].
    source : {"verification", "validation"}
        Engines against the reference, or all of them against the papers.
    placement : str
        How all models are placed in the world, see `world_axes`; ``none``: as they stand, those
        apart that the default set has placed otherwise; empty: these too.
    extremes : bool
        Checks at extremes, in place of the usual ones; so is a kind or an id of an extreme.
    """

    scenes: Sequence[str] = ()
    engines: Sequence[str] = ()
    kinds: Sequence[str] = ()
    methods: Sequence[str] = ()
    ids: Sequence[str] = ()
    profile: str = "default"
    full: bool = False
    known: str | None = None
    strict_known: bool = False
    parameters: Mapping[str, Any] = field(default_factory=dict)
    state: Mapping[str, float] = field(default_factory=dict)
    horizon: float | None = None
    source: str = SOURCES[0]
    quick: bool = False
    placement: str = ""
    extremes: bool = False

    @property
    def of_extremes(self) -> bool:
        """Whether checks at extremes are asked for: so, by their kind, or by an id with one."""
        named = any(f"/{kind}/" in name for kind in suite.EXTREMES for name in self.ids)
        return self.extremes or named or any(kind in suite.EXTREMES for kind in self.kinds)

    @property
    def is_custom(self) -> bool:
        """Whether engines are checked at the user's own parameters."""
        return bool(self.parameters or self.state) or self.horizon is not None

    @property
    def axes(self) -> str:
        """The placement of all models; empty where they stand as in their files."""
        return "" if self.placement == AS_THEY_STAND else self.placement

    @property
    def selection(self) -> dict[str, Any]:
        """What is asked for, as `Run` tells it."""
        names = ("scenes", "engines", "kinds", "methods", "ids")
        lists = {name: tuple(getattr(self, name)) for name in names}
        selection = {**lists, "profile": self.profile, "full": self.full}
        if self.source != SOURCES[0]:
            selection["source"] = self.source
        if self.quick:
            selection["quick"] = True
        if self.placement:
            selection["placement"] = self.placement
        if self.extremes:
            selection["extremes"] = True
        if self.is_custom:
            own = {"parameters": dict(self.parameters), "state": dict(self.state)}
            selection |= {**own, "horizon": self.horizon}
        return selection

    def select(self, custom: CustomCase | None = None) -> Sequence[suite.Task]:
        """Return the checks that match, of the scenes' cases or of a case of the user's own.

        Raises
        ------
        UsageError
            For unknown names, an engine asked for that is not there, or if no check matches.
        """
        if self.source not in SOURCES:
            raise UnknownNameError("source", self.source, SOURCES)
        if self.quick and (self.full or self.source != SOURCES[0]):
            raise UsageError("--quick is of engines, and contradicts --full")
        world_axes(self.axes)  # which refuses what is none
        if self.of_extremes:
            if self.quick or self.is_custom or self.placement or self.source != SOURCES[0]:
                raise UsageError(
                    "--quick, --set, --state, --horizon, --placement and --source choose among "
                    "usual checks, not among those of extremes"
                )
            from ..scenes.extremes import extreme_checks

            names = (self.kinds, self.methods, self.ids, self.full)
            return extreme_checks(self.scenes, self.engines, *names)
        if self.source == SOURCES[0]:
            checks = matching_checks(self, custom)
            return quick_checks(self, custom, checks) if self.quick and checks else checks
        if self.engines or self.methods or self.is_custom or self.placement:
            raise UsageError(
                "--engine, --method, --set, --state, --horizon and --placement choose among checks "
                "of engines; what papers say is held against the reference and every engine"
            )
        from ..papers.plan import plan

        return plan(self.scenes, self.kinds, self.ids, self.full)

    def plan(self) -> CheckPlan:
        """Return the checks that match.

        Raises
        ------
        UsageError
            For unknown names, an engine asked for that cannot be imported, a file of known
            deviations that makes no sense, parameters at which no reference can judge, or if no
            check matches.
        """
        if self.profile not in PROFILES:
            raise UnknownNameError("profile", self.profile, PROFILES)
        if self.strict_known and self.known is None:
            raise UsageError("--strict-known needs a file of known deviations: --known FILE")
        listing = known_deviations.Listing()
        if self.known is not None:
            listing = known_deviations.read(self.known)
        custom = None
        if self.is_custom:
            custom = custom_case(self.scenes, self.parameters, self.state, self.horizon)
        checks = tuple(self.select(custom))
        return CheckPlan(checks, self, listing, custom)


def matching_checks(request: CheckRequest, custom: CustomCase | None) -> list[suite.Check]:
    """Return the checks that match, of the scenes' cases or of the user's own."""
    names = (request.kinds, request.methods, request.ids, request.full)
    if custom is None and not request.placement:
        return suite.plan(request.scenes, request.engines, *names)
    scenes, engines = resolve_selection(() if custom else request.scenes, request.engines)
    if custom is not None:
        cases = custom.cases(request.full)
    else:
        cases = tuple(case for name in scenes for case in get_scene(name).cases)
    cases = tuple(replace(case, placement=request.axes) for case in cases)
    checks = suite.plan_cases(cases, engines, *names)
    return checks if custom is None else applied(checks, custom)


def quick_checks(
    request: CheckRequest, custom: CustomCase | None, checks: Sequence[suite.Check]
) -> list[suite.Check]:
    """Return those of a quick answer; of an id that names none of these, all that it names."""
    every = matching_checks(replace(request, ids=()), custom) if request.ids else checks
    quick = {check.prefix for check in suite.quick(every)}
    prefixes = set[str]() if request.ids else quick
    for pattern in request.ids:
        named = {check.prefix for check in checks if suite.matches(check, [pattern])}
        prefixes |= quick & named or named
    return narrowed(checks, "--quick", lambda one: one.prefix in prefixes)


@dataclass(frozen=True)
class CheckPlan:
    """Checks that are to run, and what their results will be held against.

    Attributes
    ----------
    checks : tuple of Task
    request : CheckRequest
    listing : known.Listing
    custom : CustomCase or None
        The user's own case, if that is what they are of.
    """

    checks: tuple[suite.Task, ...]
    request: CheckRequest
    listing: known_deviations.Listing
    custom: CustomCase | None = None

    def run(
        self, execution: Execution | None = None, progress: Progress | None = None
    ) -> list[Result]:
        """Run the checks, see `check`."""
        done = 0

        def on_result(results: list[Result]) -> None:
            nonlocal done
            done += 1
            if progress:
                progress(done, len(self.checks), results)

        settle = self.listing.settle
        return run_checks(self.checks, self.request.profile, execution, on_result, settle)

    def report(self, results: Iterable[Result]) -> Report:
        """Return the report of results, of all the checks or of those that were reached."""
        request, reported = self.request, list(results)
        if request.engines or not request.ids:
            reported += unavailable(request.engines, request.source)
        engines = tuple(dict.fromkeys(check.loaded_as or check.engine for check in self.checks))
        names = {check.engine for check in self.checks}

        @cache
        def ids(full: bool) -> list[str]:
            names = engines if request.source == SOURCES[0] else ()
            every = CheckRequest(
                engines=names, full=full, source=request.source, extremes=request.of_extremes
            )
            return [name for one in every.select(self.custom) for name in one.ids]

        every = partial(ids, request.full), partial(ids, True)
        uses = self.listing.uses(reported, *every, set(checked_engines()) - names)
        about = Run(
            planned=len(self.checks),
            selection=request.selection,
            environment=environment(),
            known_file=self.listing.file,
            uses=tuple(map(self.without_others, uses)),
            strict_known=request.strict_known,
            command=HERE if LENT.get() else None,
            reference=None if self.custom is None else self.custom.reference,
        )
        participants = (name for check in self.checks for name in check.participants)
        return Report(tuple(reported), versions(participants), about)

    def without_others(self, use: known_deviations.Use) -> known_deviations.Use:
        """Return an entry's use, open where it is stale and of other parameters than this run."""
        id, run = use.entry.id, self.request.axes
        own = f"/{CUSTOM}/" in id or f"/{CUSTOM}@" in id
        elsewhere = PLACED.search(id)
        if elsewhere is not None and elsewhere[1] != run:
            return replace(use, state="open", why="its model is placed otherwise than in this run")
        if use.state != "stale" or own == (self.custom is not None):
            return use
        return replace(use, state="open", why="it is not of the parameters of this run")


def check(
    scenes: Sequence[str] = (),
    engines: Sequence[str | Engine | type[Engine]] = (),
    kinds: Sequence[str] = (),
    methods: Sequence[str] = (),
    ids: Sequence[str] = (),
    profile: str = "default",
    jobs: int = 1,
    full: bool = False,
    fail_fast: bool = False,
    progress: Progress | None = None,
    time_limit: float | None = None,
    memory_limit: float | None = None,
    known: str | None = None,
    strict_known: bool = False,
    parameters: Mapping[str, Any] | None = None,
    state: Mapping[str, float] | None = None,
    horizon: float | None = None,
    source: str = SOURCES[0],
    quick: bool = False,
    placement: str = "",
    extremes: bool = False,
) -> Report:
    """Check engines against the reference; empty sequences mean all.

    Parameters
    ----------
    scenes, kinds, methods : sequence of str
    engines : sequence of str or Engine
        Names, ``package.module:Class``, or engines themselves. These run in this process, one
        check after the other, where a debugger reaches them; no limits hold for them.
    ids : sequence of str
        Shell patterns for ids of results.
    profile : {"strict", "default", "loose"}
        Scales every tolerance.
    jobs : int
        Worker processes; the results do not depend on it.
    full : bool
        Include the cases left out of the default set.
    fail_fast : bool
        Stop at the first deviation or error that is not known.
    progress : callable ``(done, total, results)``, optional
        Called as each check ends, with its results.
    time_limit, memory_limit : float, optional
        What each check may take [s], and map beside what its process has mapped [MiB]: one
        that takes more is an error, and the others go on. Memory can be limited on Linux.
    known : str, optional
        A file of known deviations, see docs/ci.md.
    strict_known : bool
        Whether its stale entries fail.
    parameters, state : mapping, optional
        Check the one scene that is named at these parameters, otherwise its defaults, and from
        these initial values, otherwise 0, in place of its own cases.
    horizon : float, optional
        Of that run [s]; by default as many periods as the scene's first case.
    source : {"verification", "validation"}
        With the latter, hold what the papers say against the reference and all engines.
    quick : bool
        Leave out all but the first levels, each in one case of a scene, and one trajectory.
    placement : str
        Place all models in the world by a rotation, ``turned:SEED``, or mirrored and turned,
        ``mirrored:SEED``; ``none``: as they stand only.
    extremes : bool
        Check engines at extremes, in place of the usual cases.

    Raises
    ------
    UsageError
        For unknown names, an engine asked for that cannot be imported, limits that cannot be
        kept, a file of known deviations that makes no sense, parameters at which no reference
        can judge, or if no check matches.
    """
    execution = Execution(jobs, fail_fast, time_limit, memory_limit)
    with lent(engines) as names:
        request = CheckRequest(
            scenes, names, kinds, methods, ids, profile, full, known, strict_known,
            parameters or {}, state or {}, horizon, source, quick, placement, extremes,
        )  # fmt: skip
        with execution.limited():
            plan = request.plan()
        return plan.report(plan.run(execution, progress))


def check_engine(engine: Engine | type[Engine], **options: Any) -> Report:
    """Check an engine of this program; see `check`, which takes the options, e.g. ``quick=True``.

    Raises
    ------
    UsageError
        As of `check`.
    """
    return check(engines=[engine], **options)

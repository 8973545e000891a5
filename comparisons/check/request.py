"""The plan of a run of checks: from a request to checks, and from results to a report."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Annotated, Any

from ...models.placement import world_axes
from ...reference import get_scene
from ...reference.errors import UnknownNameError, UsageError
from ..checks import known as known_deviations
from ..checks import suite
from ..checks.execution import run_checks, unavailable
from ..checks.request import SOURCES, CheckRequest, Execution
from ..checks.table import EXTREMES
from ..checks.verdict import PROFILES, Result
from ..documents.fields import OptionMark, takes_fields_of
from ..engines.protocol import Engine
from ..engines.registry import LENT, checked_engines, lent, resolve_selection
from ..queries.environment import environment, versions
from ..reports.run.outcome import Report
from .custom import NAME as CUSTOM
from .custom import CustomCase, applied, custom_case

PLACED = re.compile(r"@((?:turned|mirrored):[0-9]+)/")
"""Placement of the model in an id."""

HERE = "mbcheck.check(engines=[...], ids=[the id]), or mbcheck check --in-process --id ID"
"""Command that repeats a check of an engine that ran in this process."""

Progress = Callable[[int, int, list[Result]], None]
"""Called as each check ends with the number of checks done, that of all, and the results."""


def select(request: CheckRequest, custom: CustomCase | None = None) -> Sequence[suite.Task]:
    """Return the checks that match, of the scenes' cases or of the user's own case.

    Raises
    ------
    UsageError
        For unknown names, a missing engine, or if no check matches.
    """
    if request.source not in SOURCES:
        raise UnknownNameError("source", request.source, SOURCES)
    if request.quick and (request.full or request.source != SOURCES[0]):
        raise UsageError("--quick checks engines only, and contradicts --full")
    world_axes(request.axes)  # which refuses what is none
    if of_extremes(request):
        if request.quick or request.is_custom or request.placement or request.source != SOURCES[0]:
            raise UsageError(
                "--quick, --set, --state, --horizon, --placement and --source choose among "
                "usual checks, not among those of extremes"
            )
        from ..scenes.extremes import extreme_checks

        names = (request.kinds, request.methods, request.ids, request.full)
        return extreme_checks(request.scenes, request.engines, *names)
    if request.source == SOURCES[0]:
        checks = matching_checks(request, custom)
        if not (request.quick and checks):
            return checks
        # those of a quick answer; of an id that names none of these, all that it names
        every = matching_checks(replace(request, ids=()), custom) if request.ids else checks
        quick = {check.prefix for check in suite.quick(every)}
        prefixes = set[str]() if request.ids else quick
        for pattern in request.ids:
            named = {check.prefix for check in checks if suite.matches(check, [pattern])}
            prefixes |= quick & named or named
        return suite.narrowed(checks, "--quick", lambda one: one.prefix in prefixes)
    if request.engines or request.methods or request.is_custom or request.placement:
        raise UsageError(
            "--engine, --method, --set, --state, --horizon and --placement choose among checks of "
            "engines; --source validation compares papers with the reference and every engine"
        )
    from ..papers.plan import plan

    return plan(request.scenes, request.kinds, request.ids, request.full)


def of_extremes(request: CheckRequest) -> bool:
    """Return True if checks at extremes are wanted: so, by their kind, or by an id with one."""
    named = any(f"/{kind}/" in name for kind in EXTREMES for name in request.ids)
    return request.extremes or named or any(kind in EXTREMES for kind in request.kinds)


def plan_checks(request: CheckRequest) -> CheckPlan:
    """Return the checks that match.

    Raises
    ------
    UsageError
        For unknown names, a requested engine that cannot be imported, an invalid file of known
        deviations, parameters at which no reference can judge, or if no check matches.
    """
    if request.profile not in PROFILES:
        raise UnknownNameError("profile", request.profile, PROFILES)
    if request.strict_known and request.known is None:
        raise UsageError("--strict-known needs a file of known deviations: --known FILE")
    listing = known_deviations.Listing()
    if request.known is not None:
        listing = known_deviations.read(request.known)
    custom = None
    if request.is_custom:
        custom = custom_case(request.scenes, request.parameters, request.state, request.horizon)
    return CheckPlan(tuple(select(request, custom)), request, listing, custom)


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


@dataclass(frozen=True)
class CheckPlan:
    """The checks of a run, and the known deviations that its results may match.

    Attributes
    ----------
    checks : tuple of Task
    request : CheckRequest
    listing : known.Listing
    custom : CustomCase or None
        The user's own case, if its checks run.
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
                engines=names, full=full, source=request.source, extremes=of_extremes(request)
            )
            return [name for one in select(every, self.custom) for name in one.ids]

        every = partial(ids, request.full), partial(ids, True)
        uses = self.listing.uses(reported, *every, set(checked_engines()) - names)
        participants = (name for check in self.checks for name in check.participants)
        return Report(
            tuple(reported),
            versions(participants),
            planned=len(self.checks),
            selection=request,
            environment=environment(),
            known=tuple(map(self.without_others, uses)),
            command=HERE if LENT.get() else None,
            reference=None if self.custom is None else self.custom.reference,
        )

    def without_others(self, use: known_deviations.Use) -> known_deviations.Use:
        """Return an entry's use, open where it is stale and of other parameters than this run."""
        id, run = use.entry.id, self.request.axes
        own = f"/{CUSTOM}/" in id or f"/{CUSTOM}@" in id
        elsewhere = PLACED.search(id)
        if elsewhere is not None and elsewhere[1] != run:
            return replace(use, state="open", why="the model is placed otherwise in this run")
        if use.state != "stale" or own == (self.custom is not None):
            return use
        return replace(use, state="open", why="it has other parameters than this run")


@dataclass(frozen=True)
class CheckRun(CheckRequest, Execution):
    """Which checks are to run, and how.

    Attributes
    ----------
    engines : sequence of str or Engine
        Only this engine, or package.module:Class; in Python also engines themselves, which run in
        this process, one check after the other, where no limits hold.
    progress : callable ``(done, total, results)``, optional
        Called as each check ends, with its results.
    """

    engines: Annotated[Sequence[str | Engine | type[Engine]], OptionMark("ENGINE")] = ()  # type: ignore[assignment]
    progress: Progress | None = None


@takes_fields_of(CheckRun)
def check(asked: CheckRun) -> Report:
    """Check engines against the reference; takes the fields of `CheckRun`.

    Raises
    ------
    UsageError
        For unknown names, a requested engine that cannot be imported, limits that cannot be kept,
        an invalid file of known deviations, parameters at which no reference can judge, or if no
        check matches.
    """
    with lent(asked.engines) as names:
        asked = replace(asked, engines=names)
        with asked.limited():
            plan = plan_checks(asked)
        return plan.report(plan.run(asked, asked.progress))


def check_engine(engine: Engine | type[Engine], **options: Any) -> Report:
    """Check an engine of this program; see `check`, which takes the options, e.g. ``quick=True``.

    Raises
    ------
    UsageError
        As of `check`.
    """
    return check(engines=[engine], **options)

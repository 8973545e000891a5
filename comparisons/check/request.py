"""``check``: what is asked for, and the checks that follow from it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from ...reference.errors import UnknownNameError, UsageError
from ..checks import known as known_deviations
from ..checks import suite
from ..checks.verdict import PROFILES, Result
from ..engines.registry import checked_engines, get_engine
from ..queries.environment import environment, versions
from ..reports.run.outcome import Report, Run

SOURCES = ("verification", "validation")
"""What results are about: engines, or papers. The first is checked by default."""

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
    source : {"verification", "validation"}
        Engines against the reference, or all of them against the papers.
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
    source: str = SOURCES[0]

    @property
    def selection(self) -> dict[str, Any]:
        """What is asked for, as `Run` tells it."""
        names = ("scenes", "engines", "kinds", "methods", "ids")
        lists = {name: tuple(getattr(self, name)) for name in names}
        source = {} if self.source == SOURCES[0] else {"source": self.source}
        return {**lists, "profile": self.profile, "full": self.full, **source}

    def select(self) -> Sequence[suite.Task]:
        """Return the checks that match.

        Raises
        ------
        UsageError
            For unknown names, an engine asked for that is not there, or if no check matches.
        """
        if self.source not in SOURCES:
            raise UnknownNameError("source", self.source, SOURCES)
        if self.source == SOURCES[0]:
            return suite.plan(
                self.scenes, self.engines, self.kinds, self.methods, self.ids, self.full
            )
        if self.engines or self.methods:
            raise UsageError(
                "--engine and --method choose among checks of engines; what papers say is held "
                "against the reference and every engine"
            )
        from ..papers.plan import plan

        return plan(self.scenes, self.kinds, self.ids, self.full)

    def plan(self) -> CheckPlan:
        """Return the checks that match.

        Raises
        ------
        UsageError
            For unknown names, an engine asked for that cannot be imported, a file of known
            deviations that makes no sense, or if no check matches.
        """
        if self.profile not in PROFILES:
            raise UnknownNameError("profile", self.profile, PROFILES)
        if self.strict_known and self.known is None:
            raise UsageError("--strict-known needs a file of known deviations: --known FILE")
        listing = listing_of(self.known)
        checks = tuple(self.select())
        for engine in {check.engine for check in checks}:
            own = [name for check in checks if check.engine == engine for name in check.ids]
            listing.refuse_unordered(engine, own)
        return CheckPlan(checks, self, listing)


def listing_of(file: str | None) -> known_deviations.Listing:
    """Return the known deviations of a file; none without one."""

    def version_of(name: str) -> str:
        return get_engine(name).version

    if file is None:
        return known_deviations.Listing()
    return known_deviations.read(file, version_of)


@dataclass(frozen=True)
class Execution:
    """How checks are run.

    Attributes
    ----------
    jobs : int
        Worker processes; the results do not depend on it.
    fail_fast : bool
        Stop at the first deviation or error that is not known.
    time_limit, memory_limit : float or None
        What each check may take [s], and map beside what its process has mapped [MiB].
    """

    jobs: int = 1
    fail_fast: bool = False
    time_limit: float | None = None
    memory_limit: float | None = None


@dataclass(frozen=True)
class CheckPlan:
    """Checks that are to run, and what their results will be held against.

    Attributes
    ----------
    checks : tuple of Task
    request : CheckRequest
    listing : known.Listing
    """

    checks: tuple[suite.Task, ...]
    request: CheckRequest
    listing: known_deviations.Listing

    def run(
        self, execution: Execution | None = None, progress: Progress | None = None
    ) -> list[Result]:
        """Run the checks, see `check`."""
        how, done = execution or Execution(), 0

        def on_result(results: list[Result]) -> None:
            nonlocal done
            done += 1
            if progress:
                progress(done, len(self.checks), results)

        return suite.run_checks(
            self.checks,
            self.request.profile,
            how.jobs,
            how.fail_fast,
            on_result,
            how.time_limit,
            how.memory_limit,
            self.listing.settle,
        )

    def report(self, results: Iterable[Result]) -> Report:
        """Return the report of results, of all the checks or of those that were reached."""
        request, reported = self.request, list(results)
        if request.engines or not request.ids:
            reported += suite.unavailable(request.engines, request.source)
        engines = tuple(dict.fromkeys(check.loaded_as or check.engine for check in self.checks))
        names = {check.engine for check in self.checks}

        def ids(full: bool) -> dict[str, str]:
            names = engines if request.source == SOURCES[0] else ()
            checks = CheckRequest(engines=names, full=full, source=request.source).select()
            return {name: check.engine for check in checks for name in check.ids}

        uses = self.listing.uses(
            reported,
            cache(lambda: ids(request.full)),
            cache(lambda: ids(True)),
            set(checked_engines()) - names,
        )
        run = Run(
            planned=len(self.checks),
            selection=request.selection,
            environment=environment(),
            known_file=self.listing.file,
            uses=uses,
            strict_known=request.strict_known,
        )
        participants = (name for check in self.checks for name in check.participants)
        return Report(tuple(reported), versions(participants), run)


def check(
    scenes: Sequence[str] = (),
    engines: Sequence[str] = (),
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
    source: str = SOURCES[0],
) -> Report:
    """Check engines against the reference; empty sequences mean all.

    Parameters
    ----------
    scenes, engines, kinds, methods : sequence of str
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
    source : {"verification", "validation"}
        With the latter, hold what the papers say against the reference and all engines.

    Raises
    ------
    UsageError
        For unknown names, an engine asked for that cannot be imported, limits that cannot be
        kept, a file of known deviations that makes no sense, or if no check matches.
    """
    request = CheckRequest(
        scenes, engines, kinds, methods, ids, profile, full, known, strict_known, source
    )
    plan = request.plan()
    execution = Execution(jobs, fail_fast, time_limit, memory_limit)
    return plan.report(plan.run(execution, progress))

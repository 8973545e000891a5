"""Execution of checks: one after the other, or in worker processes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

from ...reference.cost import keep_budget
from ...reference.errors import (
    EngineError,
    EngineUnavailableError,
    UnknownNameError,
    UsageError,
)
from ..engines.isolation import HANGING, isolated, refuse_limits
from ..engines.registry import (
    ENGINES,
    LENT,
    broken_engines,
    checked_engines,
    get_engine,
    installed,
)
from ..engines.run import excerpt
from .request import Execution
from .suite import Task
from .verdict import FAILURES, NOT_APPLICABLE, PROFILES, Result, Subject, Verdict

Progress = Callable[[list[Result]], None]


def run_checks(
    checks: Sequence[Task],
    profile: str = "default",
    execution: Execution | None = None,
    on_result: Progress | None = None,
    settle: Callable[[Result], Result] = lambda result: result,
) -> list[Result]:
    """Run checks and return their results in the order of the checks.

    Parameters
    ----------
    checks : sequence of Task
    profile : {"strict", "default", "loose"}
    execution : Execution, optional
    on_result : callable, optional
        Called with the results of each check as it ends.
    settle : callable, optional
        Returns the reported result, which may be a known deviation.

    Raises
    ------
    UsageError
        For an unknown profile, fewer than one job, or limits that cannot be kept; when the budget
        is over.
    """
    how = execution or Execution()
    if profile not in PROFILES:
        raise UnknownNameError("profile", profile, PROFILES)
    if how.jobs < 1:
        raise UsageError(f"the number of jobs must be 1 or more, not {how.jobs}")
    limits = how.time_limit, how.memory_limit
    refuse_limits(*limits)
    here = any(check.engine in LENT.get() for check in checks)
    if here and limits != (None, None):
        raise UsageError("engines that are given as objects run in this process, without limits")
    results_of: dict[int, list[Result]] = {}
    # those that follow no motion need no reference of it, and are groups of their own
    groups: dict[Group, list[int]] = {}
    for index, check in enumerate(checks):
        groups.setdefault((*check.group, check.integrates), []).append(index)
    in_turn = sorted(range(len(checks)), key=lambda index: checks[index].integrates)
    arriving = (
        ((index, checks[index].run(profile)) for index in in_turn)
        if here
        or (min(how.jobs, len(groups)) == 1 and limits == (None, None) and not foreign(checks))
        else _in_processes(checks, groups, profile, how.jobs, limits)
    )
    for index, arrived in arriving:
        keep_budget(1.0)  # before what it has cut short is taken for a failure
        results_of[index] = results = [settle(item) for item in arrived]
        if on_result:
            on_result(results)
        if how.fail_fast and any(item.verdict in FAILURES for item in results):
            break
    return [item for index in sorted(results_of) for item in results_of[index]]


def unavailable(requested: Sequence[str] = (), source: str = "verification") -> list[Result]:
    """Return a result for each engine, requested or of all, that cannot be used here.

    An engine is skipped if it is not installed, and an error if it is, lest half a run pass for a
    whole one.
    """
    reasons: dict[str, EngineUnavailableError] = dict(broken_engines(requested))
    for name in () if requested else checked_engines():
        try:
            get_engine(name)
        except EngineUnavailableError as error:
            reasons[name] = error
    missing = []
    for name, reason in reasons.items():
        prefix = "/".join([source, *[NOT_APPLICABLE] * 3, name, NOT_APPLICABLE])
        verdict: Verdict = "error" if requested or installed(name) else "skipped"
        about, where = Subject(prefix, source, name), excerpt(reason.traceback) or None
        missing.append(about.result(NOT_APPLICABLE, verdict, str(reason), traceback=where))
    return missing


def foreign(checks: Sequence[Task]) -> bool:
    """Return True if an engine is not ours, or at an extreme: its end must not be this one's."""
    return any(check.engine not in ENGINES or check.extreme for check in checks)


Group = tuple[str, str, str, bool]


def _in_processes(
    checks: Sequence[Task],
    groups: dict[Group, list[int]],
    profile: str,
    jobs: int,
    limits: tuple[float | None, float | None],
) -> Iterator[tuple[int, list[Result]]]:
    """Run checks in worker processes; those of a group share the reference of their case.

    A fault of the model shows before any motion is followed. Of the rest what takes longest comes
    first, or others wait for it in the end: orbits and stiff runs.
    """

    def weight(item: tuple[Group, list[int]]) -> tuple[bool, bool, int]:
        long = any(checks[index].takes_long for index in item[1])
        return not checks[item[1][0]].integrates, long, len(item[1])

    calls = [partial(check.run, profile) for check in checks]
    longest = sorted(groups.items(), key=weight, reverse=True)
    owners, order = [owner for (owner, *_), _ in longest], [group for _, group in longest]
    seconds, megabytes = limits
    if seconds is None and foreign(checks):
        seconds = HANGING
    for index, outcome in isolated(calls, jobs, seconds, megabytes, order, owners):
        if isinstance(outcome, EngineError):
            reason = f"{outcome.kind}: {outcome.message}"
            yield index, checks[index].failed(reason, outcome.traceback)
        else:
            yield index, outcome

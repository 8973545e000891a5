"""The pytest plugin: ``pytest --pyargs mbcheck.tests.conformance`` runs what `mbcheck check` runs.

pytest loads it in every run of everyone who has mbcheck installed: it imports only small modules of
mbcheck, and prints nothing until the checks are requested or collected.
"""

from __future__ import annotations

import sys
from collections.abc import Generator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from ..documents.fields import option_fields
from ..engines import use_one_thread

if TYPE_CHECKING:
    from ..check.request import CheckPlan
    from ..checks.suite import Check
    from ..checks.verdict import Result
    from ..reports.run.outcome import Report

PACKAGE = "mbcheck.tests.conformance"
FOLDER = Path(__file__).resolve().parents[2] / "tests" / "conformance"

OPTIONS: dict[str, Any] = {
    "engines": "linelist",
    "scenes": None,
    "kinds": None,
    "ids": None,
    "profile": "string",
    "full": None,
    "known": "paths",
    "strict_known": "bool",
}
"""Fields of `CheckRequest` that are options here, and their type in the ini file, if any."""

PLAN: pytest.StashKey[CheckPlan] = pytest.StashKey()
RESULTS: pytest.StashKey[list[Result]] = pytest.StashKey()
DOCUMENTS: pytest.StashKey[list[dict[str, Any]]] = pytest.StashKey()
REPORT: pytest.StashKey[Report] = pytest.StashKey()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options of `mbcheck check` that choose checks, and those for known deviations."""
    from ..checks.request import CheckRequest

    group = parser.getgroup("mbcheck", "checks of multibody engines (mbcheck)")
    for field in option_fields(CheckRequest):
        if field.name in OPTIONS:
            how: dict[str, Any] = {"metavar": field.mark.metavar}
            if field.is_repeatable:
                how = {"action": "append", "default": [], "metavar": field.word.upper()}
            elif field.kind is bool:
                how = {"action": "store_true"}
            group.addoption(f"--mbcheck-{field.word}", help=field.help, **how)
            if kind := OPTIONS[field.name]:
                parser.addini(f"mbcheck_{field.word.replace('-', '_')}", field.help, kind, None)
    add = group.addoption
    add("--mbcheck-json", metavar="FILE", help="Write the JSON document of `mbcheck check`.")


def requested(config: pytest.Config) -> bool:
    """Return True if the user requests checks: by an option, or by the folder of the tests."""

    def ours(argument: str) -> bool:
        place = Path(argument.split("::")[0]).resolve()
        return argument.startswith(PACKAGE) or place == FOLDER or FOLDER in place.parents

    options = vars(config.option).items()
    return any(value for name, value in options if name.startswith("mbcheck_")) or any(
        map(ours, config.args)
    )


def is_worker(config: pytest.Config) -> bool:
    """Return True in a worker process of pytest-xdist."""
    return hasattr(config, "workerinput")


def check_plan(config: pytest.Config) -> CheckPlan:
    """Return the checks that the options choose; planned once."""
    if PLAN not in config.stash:
        from ..check.request import plan_checks
        from ..checks.request import CheckRequest

        values = {
            field.name: option(config, field.word)
            for field in option_fields(CheckRequest)
            if field.name in OPTIONS
        }
        if isinstance(values["known"], list):  # of the ini file
            values["known"] = next(map(str, values["known"]), None)
        request = CheckRequest(**{name: value for name, value in values.items() if value})
        config.stash[PLAN] = plan_checks(request)
    return config.stash[PLAN]


def option(config: pytest.Config, word: str) -> Any:
    """Return an option from the command line, else from the ini file; None without the plugin."""
    name = f"mbcheck_{word.replace('-', '_')}"
    if value := config.getoption(name, None):
        return value
    try:
        return config.getini(name)
    except (KeyError, ValueError):  # an option that has no place there
        return None


def pytest_configure(config: pytest.Config) -> None:
    """Refuse at once what cannot be checked."""
    if not requested(config) or config.option.help:
        return
    use_one_thread()
    if is_worker(config):
        return
    from ...reference.errors import UsageError
    from ..reports.files import Destination

    try:
        check_plan(config)
        if config.option.mbcheck_json:
            Destination("--mbcheck-json", config.option.mbcheck_json)
    except UsageError as error:
        raise pytest.UsageError(f"mbcheck: {error}") from None


def pytest_report_header(config: pytest.Config) -> list[str]:
    """Return the versions, and the file of known deviations."""
    return described(config) if requested(config) else []


def pytest_report_collectionfinish(config: pytest.Config) -> list[str]:
    """Do the same if the checks were collected without a request."""
    return described(config) if PLAN in config.stash and not requested(config) else []


def described(config: pytest.Config) -> list[str]:
    """Return one line with the versions, and one with the known deviations if there is a file."""
    from ..queries.environment import versions

    plan = check_plan(config)
    by_name = versions(check.engine for check in plan.checks)
    lines = ["mbcheck: " + ", ".join(f"{name} {text}" for name, text in by_name.items())]
    if plan.listing.file:
        count = len(plan.listing.entries)
        lines.append(f"mbcheck: known deviations from {plan.listing.file} ({count} entries)")
    return lines


# The tests


def parametrize(metafunc: pytest.Metafunc) -> None:
    """Make a test of each check; for the module of the tests."""
    from ...reference.errors import UsageError

    try:
        checks = check_plan(metafunc.config).checks
    except UsageError as error:
        raise pytest.Collector.CollectError(f"mbcheck: {error}") from None
    metafunc.parametrize("check", checks, ids=[check.prefix for check in checks])


def run_test(check: Check, node: pytest.Item) -> None:
    """Run a check as a test: fails, or is skipped or expected to fail, with its reasons."""
    from ..checks import suite
    from ..checks.verdict import FAILURES
    from ..reports.run.outcome import Report
    from ..reports.run.results import why_known

    plan = check_plan(node.config)
    fresh = suite.run_check(check, plan.request.profile)
    results = node.stash[RESULTS] = [plan.listing.settle(result) for result in fresh]
    as_if_unknown = node.config.getoption("runxfail", False)
    bad = (*FAILURES, *(("known",) if as_if_unknown else ()))
    failed = [result for result in results if result.verdict in bad]
    if failed:
        as_failures = [
            replace(r, verdict="deviation") if r.verdict == "known" else r for r in failed
        ]
        report = Report(tuple(as_failures), {}, selection=plan.request)
        pytest.fail(report.text(1), pytrace=False)
    reasons = dict.fromkeys(why_known(r) for r in results if r.verdict == "known")
    if reasons:
        pytest.xfail(f"known deviation: {'; '.join(reasons)}")
    if all(result.verdict == "skipped" for result in results):
        pytest.skip(results[0].reason)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Send results along with the report, which may cross processes."""
    made = yield
    if call.when == "call" and RESULTS in item.stash:
        from ..documents.core import as_plain
        from ..reports.run.outcome import with_lost_numbers

        made.mbcheck = [as_plain(with_lost_numbers(result)) for result in item.stash[RESULTS]]  # type: ignore[attr-defined]
    return made


# The report


class Collecting:
    """Gathers results in the process that reports."""

    def __init__(self, config: pytest.Config) -> None:
        self.documents = config.stash.setdefault(DOCUMENTS, [])

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Take the results of a test."""
        self.documents += getattr(report, "mbcheck", [])


def pytest_sessionstart(session: pytest.Session) -> None:
    """Gather results, but not in workers."""
    if not is_worker(session.config):
        session.config.pluginmanager.register(Collecting(session.config))


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Write the document, and fail if nothing ran or an entry is stale that must not be."""
    config = session.config
    ran = requested(config) or bool(config.stash.get(DOCUMENTS, None))
    if is_worker(config) or config.option.collectonly or PLAN not in config.stash or not ran:
        return
    from ..checks.verdict import result_from
    from ..reports import github
    from ..reports.files import Destination, collect_unwritten
    from ..reports.run.sections import run_summary
    from ..terminal.program import json_text

    plan = check_plan(config)
    order = {name: place for place, check in enumerate(plan.checks) for name in check.ids}
    results = [result_from(item) for item in config.stash[DOCUMENTS]]  # as workers happened to end
    results.sort(key=lambda result: order[result.id])
    outcome = config.stash[REPORT] = plan.report(results)
    with collect_unwritten() as unwritten:
        if config.option.mbcheck_json:
            Destination("--mbcheck-json", config.option.mbcheck_json).write(
                json_text(outcome.as_json())
            )
    github.append_step_summary(run_summary(outcome))
    if session.exitstatus in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED):
        session.exitstatus = outcome.exit_code or int(bool(unwritten))
    for words in unwritten:
        print(f"mbcheck: {words}", file=sys.stderr)


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, config: pytest.Config
) -> None:
    """Print the report of `mbcheck check`."""
    if REPORT not in config.stash:
        return
    outcome = config.stash[REPORT]
    terminalreporter.section("mbcheck")
    terminalreporter.write(outcome.text())
    if not outcome.results:
        terminalreporter.line(f"no check ran: add --pyargs {PACKAGE}, or see why above", red=True)

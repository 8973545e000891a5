"""The outcome of a run of checks: its results, its selection, and its exit code."""

from __future__ import annotations

import io
import math
import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from ...checks.known import Use
from ...checks.request import CheckRequest
from ...checks.verdict import FAILURES, Result, Verdict
from ...documents import document
from ...documents.fields import HIDDEN, documented
from ..words import assignments, plural, with_unit
from .results import MEASURES, grouped, ran, reasons, summary, worst

WORDS = ("PASS", "FAIL", "NOTHING RAN")
"""Meanings of exit codes."""


@dataclass(frozen=True)
class CustomReference:
    """The reference of a run at a user's own parameters.

    Attributes
    ----------
    horizon : float
        horizon of the run [s]
    horizon_source : str
        origin of the horizon
    permitted : float
        part of it over which an initial error stays small enough [s]
    growth : float
        amplification of an initial error over that part
    error_bound : mapping of str to float
        bound on the error of each observable over the times
    units : mapping of str to str
        of the observables
    """

    horizon: float
    horizon_source: str
    permitted: float
    growth: float
    error_bound: Mapping[str, float]
    units: Mapping[str, str]

    @property
    def line(self) -> str:
        """How far and how well the reference can judge, in one line."""
        bounds = (
            f"{name} {with_unit(bound, self.units[name], 2)}"
            for name, bound in self.error_bound.items()
        )
        cut = "" if self.permitted >= self.horizon else f", judged to t = {self.permitted:.4g} s"
        return (
            f"over {self.horizon:.6g} s ({self.horizon_source}){cut}, in which an initial error "
            f"grows by a factor of {self.growth:.3g}; error bounds of the reference: "
            f"{', '.join(bounds)}"
        )


@dataclass(frozen=True)
class Checks:
    """Number of checks, of several results each.

    Attributes
    ----------
    planned : int
        planned, including those that cannot run
    ran : int
        with a judged result
    skipped : int
        without one
    not_reached : int
        not started, since the run was stopped
    """

    planned: int
    ran: int
    skipped: int
    not_reached: int


@dataclass(frozen=True)
class SkipReason:
    """Why results of an engine were skipped.

    Attributes
    ----------
    reason : str
        why
    results : int
        how many
    """

    engine: str
    reason: str
    results: int


@dataclass(frozen=True)
class Report:
    """The results of a run of checks.

    Attributes
    ----------
    environment : mapping of str to str
        Python, system, machine, processor and libc, on which round-off may depend.
    selection : CheckRequest
        Options of `mbcheck check`; empty lists mean all.
    reference : CustomReference or None
        The reference of a run at a user's own parameters; null for other runs.
    known : tuple of Use
        Use of the known deviations, in the order of the file.
    results : tuple of Result
        one for each quantity of each check, in the order of the checks whatever `-j` was
    planned : int or None
        Number of checks that were to run; None if only those that ran are known.
    interrupted : bool
        True if the run was interrupted, so that results are missing.
    command : str or None
        Command that repeats the run, if its checks cannot be repeated by id.
    """

    environment: Mapping[str, str] = field(default_factory=dict, kw_only=True)
    selection: CheckRequest = field(default_factory=CheckRequest, kw_only=True)
    reference: CustomReference | None = field(default=None, kw_only=True)
    known: tuple[Use, ...] = field(default=(), kw_only=True)
    results: tuple[Result, ...]
    versions: Mapping[str, str]
    planned: int | None = field(default=None, kw_only=True, metadata=HIDDEN)
    interrupted: bool = field(default=False, kw_only=True, metadata=HIDDEN)
    command: str | None = field(default=None, kw_only=True, metadata=HIDDEN)

    @property
    @documented
    def summary(self) -> dict[str, int]:
        """Number of results by verdict, and their `total`."""
        return summary(self.results)

    @property
    @documented
    def checks(self) -> Checks:
        """Number of checks, of several results each."""
        groups = grouped(ran(self.results), lambda r: (r.check_id,)).values()
        skipped = sum(all(r.verdict == "skipped" for r in members) for members in groups)
        planned = len(groups) if self.planned is None else self.planned
        return Checks(planned, len(groups) - skipped, skipped, max(0, planned - len(groups)))

    @property
    @documented
    def skipped(self) -> list[SkipReason]:
        """Why results were skipped."""
        return [
            SkipReason(engine, reason, len(members))
            for (engine, reason), members in reasons(self.results, "skipped").items()
        ]

    @property
    def header(self) -> str:
        """Scene, parameters and start of a run at a user's own parameters; empty for others."""
        if self.reference is None:
            return ""
        (scene,), asked = self.selection.scenes, self.selection
        changes = assignments(asked.parameters) or "its default parameters"
        start = f" from {assignments(asked.state)}" if asked.state else ""
        return f"{scene} at {changes}{start} {self.reference.line}"

    @property
    def stale(self) -> tuple[Use, ...]:
        """The entries that no result needs any more."""
        return tuple(use for use in self.known if use.state == "stale")

    @property
    def check_command(self) -> str:
        """Beginning of a command that repeats a check of the run."""
        asked, plain = self.selection, CheckRequest()
        words = ["mbcheck check"]
        words += [] if asked.source == plain.source else [f"--source {asked.source}"]
        words += [f"--engine {shlex.quote(word)}" for word in asked.engines if ":" in word]
        if self.reference is not None:
            words += asked.scenes
            words += [
                f"{option} {shlex.quote(f'{key}={value}')}"
                for option, values in (("--set", asked.parameters), ("--state", asked.state))
                for key, value in values.items()
            ]
            words += [] if asked.horizon is None else [f"--horizon {asked.horizon}"]
        words += [f"--placement {asked.placement}"] if asked.placement else []
        words += [] if asked.profile == plain.profile else [f"--profile {asked.profile}"]
        return " ".join([*words, *(["--full"] if asked.full else [])])

    def repeat(self, id: str) -> str:
        """Return the shell command that repeats the check of an id, and no other."""
        quoted = id.replace("'", "'\\''")
        return self.command or f"{self.check_command} --id '{quoted}'"

    def stale_line(self, use: Use) -> str:
        """Return a stale entry, and why it is stale, in one line."""
        return f"stale: {self.selection.known}, {use.entry.place}, {use.entry.id!r}: {use.why}"

    @property
    def exit_code(self) -> int:
        """0 if all is well, 1 for any deviation or error, 2 if nothing ran.

        1 for stale known deviations too, with --strict-known. A requested engine without any passed
        result counts as one that did not run.
        """
        counts = self.summary
        if counts["skipped"] == counts["total"]:
            return 2
        stale = self.selection.strict_known and bool(self.stale)
        if counts["deviation"] or counts["error"] or stale:
            return 1
        passed = {r.engine for r in self.results if r.verdict in ("pass", "known")}
        return 2 if len(set(self.selection.engines)) > len(passed) else 0

    @property
    def word(self) -> str:
        """The exit code in a word; a run that was interrupted passes nothing."""
        return "INTERRUPTED" if self.interrupted else WORDS[self.exit_code]

    @property
    def verdict(self) -> Verdict:
        """The worst verdict, a deviation where stale entries alone fail."""
        verdict = worst(self.results)
        fails = self.exit_code == 1 and verdict not in FAILURES
        return "deviation" if fails else verdict

    @property
    def counts_line(self) -> str:
        """How many checks ran, in one line."""
        counts = self.checks
        parts = [f"{plural(counts.planned, 'check')}: {counts.ran} ran"]
        parts += [f"{counts.skipped} skipped"] if counts.skipped else []
        parts += [f"{counts.not_reached} not reached"] if counts.not_reached else []
        return ", ".join(parts)

    @property
    def summary_line(self) -> str:
        """The whole run in one line."""
        counts = self.summary
        parts = [f"{counts['pass']} passed"]
        parts += [plural(counts["deviation"], "deviation"), plural(counts["error"], "error")]
        parts += [f"{counts[name]} {name}" for name in ("known", "skipped") if counts[name]]
        if self.stale:
            parts.append(f"{len(self.stale)} of the known deviations stale")
        return f"{self.word}: {', '.join(parts)}"

    def text(self, verbosity: int = 0) -> str:
        """Return the text of the command line: 1 adds every result, -1 is the last line alone."""
        from rich.console import Console

        from .sections import print_report

        console = Console(file=io.StringIO(), width=80, highlight=False)
        with console.capture() as printed:
            print_report(console, self, verbosity)
        return printed.get()

    def as_json(self) -> dict[str, Any]:
        """Return the ``check`` document of docs/json.md; it holds no NaN and no infinity."""
        return document("check", self, results=list(map(with_lost_numbers, self.results)))


def with_lost_numbers(result: Result) -> Result:
    """Return a result whose reason names the numbers that JSON cannot hold."""
    numbers = ((name, getattr(result, name)) for name in MEASURES)
    lost = [
        f"{name} was {float(value)}"
        for name, value in numbers
        if value is not None and not math.isfinite(value)
    ]
    return replace(result, reason="; ".join(filter(None, [result.reason, *lost])))

"""Common functions of reports on results: the worst, sizes of errors, groups."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence

from ...checks.verdict import NOT_APPLICABLE, Result, Verdict
from ..words import number, with_unit

VERDICTS: tuple[Verdict, ...] = ("pass", "deviation", "known", "skipped", "error")
"""The verdicts, in the order of the summary."""

SEVERITY: tuple[Verdict, ...] = ("error", "deviation", "known", "pass", "skipped")
"""A group of results is as good as the first of these that it holds."""

FATES: Mapping[str, str] = {"deviation": "deviate", "error": "in error", "known": "known"}
"""Words for results that do not pass, in the cells of a matrix of verdicts."""

MEASURES = ("value", "reference", "error", "tolerance")
"""Fields of a result that are numbers."""


def summary(results: Sequence[Result]) -> dict[str, int]:
    """Return the number of results by verdict, and their ``total``."""
    counts: dict[str, int] = {v: sum(r.verdict == v for r in results) for v in VERDICTS}
    return counts | {"total": len(results)}


def worst(results: Sequence[Result]) -> Verdict:
    """Return the worst verdict of results; ``skipped`` if nothing ran."""
    present = {result.verdict for result in results}
    return next((verdict for verdict in SEVERITY if verdict in present), "skipped")


def tally(results: Sequence[Result]) -> str:
    """Return the fate of the results that were judged: "ok 13", "8 of 21 deviate"."""
    counts = summary(results)
    count = counts["total"] - counts["skipped"]
    if not count:
        return worst(results)
    if counts["pass"] == count:
        return f"ok {count}"
    first, *more = [f"{counts[name]} {word}" for name, word in FATES.items() if counts[name]]
    return ", ".join([first.replace(" ", f" of {count} ", 1), *more])


def ran(results: Iterable[Result]) -> list[Result]:
    """Return the results of checks; an engine that cannot be imported has none."""
    return [result for result in results if result.kind != "-"]


def grouped(
    results: Iterable[Result], key: Callable[[Result], tuple[str, ...]]
) -> dict[tuple[str, ...], list[Result]]:
    """Return results by key, in the order in which keys first appear."""
    groups: dict[tuple[str, ...], list[Result]] = {}
    for result in results:
        groups.setdefault(key(result), []).append(result)
    return groups


def reasons(results: Iterable[Result], verdict: Verdict) -> dict[tuple[str, ...], list[Result]]:
    """Return the results of a verdict, ``known`` or ``skipped``, by engine and reason."""
    return grouped(
        (result for result in results if result.verdict == verdict),
        lambda r: (r.engine, why_known(r) if verdict == "known" else r.reason),
    )


def why_known(result: Result) -> str:
    """Return the reason that a user has given for a known deviation."""
    return result.known or "no reason given"


def method_of(result: Result) -> str:
    """Return the method segment of a result's id, with the model."""
    return NOT_APPLICABLE if result.source == "validation" else result.id.split("/")[-2]


# Sizes of errors


def error_size(result: Result) -> float:
    """Return the error of a result; infinite where it has none."""
    return math.inf if result.error is None or math.isnan(result.error) else result.error


def ratio(result: Result) -> float:
    """Return error / tolerance of a result; infinite where it has none."""
    error, tolerance = error_size(result), result.tolerance
    if math.isinf(error) or tolerance is None or not math.isfinite(tolerance):
        return math.inf
    if tolerance > 0:
        return error / tolerance
    return math.inf if error > 0 else 0.0


# In words


def measured(result: Result) -> str:
    """Return value, reference, error and tolerance in one line; empty if nothing was measured."""
    if all(getattr(result, name) is None for name in MEASURES):
        return ""
    digits = digits_to_differ(result)
    value, reference = (
        with_unit(item, result.unit, digits) for item in (result.value, result.reference)
    )
    error, tolerance = (with_unit(item, result.unit) for item in (result.error, result.tolerance))
    times = "" if result.error is None else f" ({number(ratio(result))} x its tolerance)"
    return (
        f"{result.quantity} = {value}, reference {reference}; error {error}, tolerance {tolerance}"
        f"{times}"
    )


def digits_to_differ(result: Result) -> int:
    """Return the number of significant digits in which value and reference differ."""
    value, error = result.value or math.nan, result.error or math.nan
    if not 0 < abs(value) / error < math.inf:
        return 3
    return min(17, max(3, 2 + math.ceil(math.log10(abs(value) / error))))

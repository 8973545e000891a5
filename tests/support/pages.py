"""A run whose page has all that a page can have, and how a parser sees it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime
from html.parser import HTMLParser
from typing import Any, NamedTuple

import numpy as np

from mbcheck.comparisons.checks.known import Entry, Use
from mbcheck.comparisons.checks.verdict import Result, Series, Verdict, result_from
from mbcheck.comparisons.reports.run import page
from mbcheck.comparisons.reports.run.outcome import Report, Run
from mbcheck.comparisons.reports.run.results import MEASURES
from mbcheck.reference.scene import Array

WHEN = datetime(2026, 1, 2, 3, 4, tzinfo=UTC)

HOSTILE = "<script>alert(1)</script>\"'&{{7*7}}{% raw %} $x_{^ \x1b[31m\x00\ud800</td></table>"
"""What an engine might call itself."""

STALE = Use(Entry(1, "verification/*/gone/*", HOSTILE), 0, "stale", f"matches nothing {HOSTILE}")


def made(
    verdict: Verdict, quantity: str, kind: str = "trajectory", scene: str = "a", **more: Any
) -> Result:
    engine = more.pop("engine", "mujoco")
    measured = None if verdict in ("skipped", "error") else {"value": 2.0, "reference": 1.5}
    numbers = {**(measured or {}), **({"error": 0.5, "tolerance": 1e-3} if measured else {})}
    series = more.pop("series", None)
    fields = {
        "id": f"verification/{scene}/case/{kind}/{engine}/RK4/{quantity}",
        "scene": scene,
        "case": "case",
        "kind": kind,
        "source": "verification",
        "engine": engine,
        "model": "tree",
        "method": "RK4",
        "quantity": quantity,
        "unit": "m",
        **dict.fromkeys(MEASURES),
        **numbers,
        "verdict": verdict,
        "reason": f"why {quantity}",
        "work": {"seconds": 0.25},
        **more,
    }
    return replace(result_from(fields), series=series)


def over_time(count: int = 20) -> Series:
    times = np.linspace(0.1, 2, count)
    return Series("time", times, np.sin(times) + 1e-3 * times**2, np.sin(times))


def over_step() -> Series:
    steps: Array = 2.0 ** -np.arange(4.0, 10.0)
    return Series("step", steps, steps**2, steps**2)


HOSTILE_RESULT = made(
    "deviation", HOSTILE, engine=HOSTILE, reason=HOSTILE, series=over_time(), case=HOSTILE,
    unit=HOSTILE, scene=HOSTILE,
)  # fmt: skip

RESULTS = (
    made("pass", "x"),
    made("deviation", "y", series=over_time(), tolerance=1e-6),
    made("deviation", "y_dot", series=over_time()),
    made("error", "accelerations", kind="algebra", reason="raised: it broke"),
    made("error", "mass_matrix", kind="algebra", reason="raised: it broke"),
    made("known", "z", scene="b", known="issue 12"),
    made("skipped", "w", scene="b", engine="exudyn", reason="cannot do that"),
    made("deviation", "order", kind="order", scene="b", series=over_step()),
    HOSTILE_RESULT,
)


UNDRAWN = tuple(replace(result, series=None) for result in RESULTS)


def outcome(results: Sequence[Result] = RESULTS, **run: Any) -> Report:
    about = {"environment": {"machine": "x86_64", "system": HOSTILE}, "uses": (STALE,), **run}
    return Report(tuple(results), {"mbcheck": "0.1", "mujoco": HOSTILE}, Run(**about))


def text_of(results: Sequence[Result] = RESULTS, **run: Any) -> str:
    return page.check_page(outcome(results, **run), when=WHEN)


class Seen(NamedTuple):
    """A page as a parser sees it."""

    tags: list[tuple[str, dict[str, str]]]
    words: str

    def all(self, tag: str) -> list[dict[str, str]]:
        return [found for name, found in self.tags if name == tag]


class Reader(HTMLParser):
    """Collects tags and text, and refuses tags that are not closed in their order."""

    VOID = ("meta", "img", "br", "link", "input")

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.tags: list[tuple[str, dict[str, str]]] = []
        self.words: list[str] = []
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, {name: value or "" for name, value in attrs}))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] != "style":
            self.words.append(data)


def seen(text: str) -> Seen:
    reader = Reader()
    reader.feed(text)
    reader.close()
    assert not reader.open
    return Seen(reader.tags, " ".join(" ".join(reader.words).split()))

"""The page of a run: what a reader finds on it, and what it never does."""

import os
import re
from collections import Counter
from dataclasses import replace
from datetime import UTC, datetime
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.checks import suite
from mbcheck.comparisons.checks.known import Entry, Use
from mbcheck.comparisons.checks.request import CheckRequest
from mbcheck.comparisons.checks.verdict import Result, Series
from mbcheck.comparisons.faults.catalogue import FAULTS
from mbcheck.comparisons.reports import drawing
from mbcheck.comparisons.reports.run.outcome import Report
from mbcheck.comparisons.reports.run.page import check_page
from mbcheck.comparisons.reports.words import printable
from mbcheck.reference.errors import UsageError
from mbcheck.tests.support.command import invoke
from mbcheck.tests.support.results import MIXED, changed, result

WHEN = datetime(2026, 1, 2, 3, 4, tzinfo=UTC)

HOSTILE = "<script>alert(1)</script>\"'&{{7*7}}{% raw %} $x_{^ \x1b[31m\x00\ud800</td></table>"
"""What an engine might call itself."""

STALE = Use(Entry(1, "verification/*/gone/*", HOSTILE), 0, "stale", f"matches nothing {HOSTILE}")
TIMES = np.linspace(0.1, 2, 20)
OVER_TIME = Series("time", TIMES, np.sin(TIMES) + 1e-3 * TIMES**2, np.sin(TIMES))
OVER_STEP = Series("step", 2.0 ** -np.arange(4.0, 10.0), TIMES[:6], TIMES[:6])
DRAWN = [
    replace(result("m1", "deviation", error=1e-3), series=OVER_TIME),
    replace(result("m2", "deviation", kind="order", error=1e-4), series=OVER_STEP),
]
STRANGE = changed(
    result("m3", "deviation", error=1e-5, reason=HOSTILE),
    quantity=HOSTILE, engine=HOSTILE, case=HOSTILE, unit=HOSTILE, scene=HOSTILE,
)  # fmt: skip
RESULTS = [*MIXED, *DRAWN, replace(STRANGE, series=OVER_TIME)]


def page_of(results: list[Result], most_figures: int = 24, **run: Any) -> str:
    about = {"environment": {"machine": "x86_64", "system": HOSTILE}, "known": (STALE,), **run}
    report = Report(tuple(results), {"mbcheck": "0.1", "mujoco": HOSTILE}, **about)
    return check_page(report, WHEN, most_figures)


@pytest.fixture(scope="module")
def text() -> str:
    return page_of(RESULTS)


class Page(HTMLParser):
    """The tags and the words of a page; refuses tags that are not closed in their order."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.tags: list[tuple[str, dict[str, str]]] = []
        self.parts: list[str] = []
        self.open: list[str] = []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, {name: value or "" for name, value in attrs}))
        if tag not in ("meta", "img"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] != "style":
            self.parts.append(data)

    @property
    def words(self) -> str:
        return " ".join(" ".join(self.parts).split())

    def all(self, tag: str) -> list[dict[str, str]]:
        return [attributes for name, attributes in self.tags if name == tag]


def test_nothing_is_loaded_and_nothing_runs(text: str) -> None:
    page = Page(text)
    assert not {"script", "link", "iframe", "object", "form"} & {tag for tag, _ in page.tags}
    for _, attributes in page.tags:
        assert not any(name.startswith("on") for name in attributes)
        for name in ("src", "href"):
            assert attributes.get(name, "#").startswith(("#", "data:image/svg+xml;base64,"))
    assert "default-src 'none'" in text
    assert not re.search(r"@import|url\(", text)


def test_every_link_has_its_target(text: str) -> None:
    page = Page(text)
    ids = Counter(attributes["id"] for _, attributes in page.tags if "id" in attributes)
    assert set(ids.values()) == {1}
    links = [attributes["href"][1:] for attributes in page.all("a")]
    assert len(links) > 10
    assert set(links) <= set(ids)


def test_text_from_outside_is_text(text: str) -> None:
    assert "<script" not in text
    assert "49" not in re.findall(r"alert\(1\).{0,40}", text)
    shown = " ".join(printable(HOSTILE).split())
    assert Page(text).words.count(shown) >= 8
    text.encode()  # no surrogates
    assert not re.search("[\x00-\x08\x0b-\x1f\x7f]", text)


def test_what_a_reader_finds(text: str) -> None:
    words = Page(text).words
    for part in (
        "FAIL: 2 passed", "checks: ", "2026-01-02 03:04 UTC",
        "the default set of checks", "Deviations and errors (5)", "Located:",
        "DEVIATION verification/hula_hoop/point_mass_3hz_60n/trajectory/mujoco/Euler",
        "theta rad 5e-05 0 5e-05 2e-06 25", "exudyn tree RK67 1 listed",
        "exudyn tree RK44, RK33 2 no such model", "verification/*/gone/*",
    ):  # fmt: skip
        assert part in words, part
    for one in MIXED:
        assert f"mbcheck check --id '{one.id}'" in words
    images = Page(text).all("img")
    assert [image["alt"].split(" over ")[0] for image in images[:1]] == ["theta of mujoco"]
    assert len(images) == 3


def test_a_run_that_failed_nowhere_and_one_that_was_interrupted() -> None:
    clean = page_of([result()], known=())
    assert "<title>PASS</title>" in clean
    for word in ("Stale", "Known deviations", "Skipped"):
        assert word not in clean
    chosen = CheckRequest(("a",), profile="loose", full=True)
    stopped = page_of([result()], planned=7, interrupted=True, selection=chosen)
    assert "<title>INTERRUPTED</title>" in stopped
    assert "6 not reached" in stopped
    assert "The run was interrupted" in stopped
    assert "scenes a; profile loose; with --full" in stopped


def test_so_many_are_drawn_and_the_page_stays_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    assert page_of(DRAWN) == page_of(DRAWN)
    assert len(Page(page_of(DRAWN, most_figures=1)).all("img")) == 1

    def missing() -> None:
        raise UsageError("figures need matplotlib; pip install 'mbcheck[plot]'")

    monkeypatch.setattr(drawing, "import_pyplot", missing)
    page = Page(page_of(DRAWN))
    assert not page.all("img")
    assert "figures need matplotlib; pip install 'mbcheck[plot]'" in page.words


@pytest.mark.slow
@pytest.mark.parametrize(
    "series",
    [
        Series("time", np.array([0.1, 0.2]), np.array([1.0, 2.0]), np.array([1.0, 2.0])),
        Series("time", np.array([0.1, 0.2]), np.array([np.nan, np.inf]), np.array([1.0, 2.0])),
        Series("time", np.array([0.1]), np.array([3.0]), np.array([1.0])),
        Series("step", np.array([0.1, 0.05]), np.array([1.0, np.nan]), np.array([1.0, 0.5])),
    ],
)
@pytest.mark.filterwarnings("error")
def test_odd_series_are_drawn(series: Series) -> None:
    drawn = replace(result(verdict="deviation"), series=series)
    assert len(Page(page_of([drawn])).all("img")) == 1


def test_real_deviations_have_series() -> None:
    wrong = FAULTS["hula_hoop"]["free_mass_0.1_percent"].make["mujoco"]()
    results = []
    for check in suite.plan(["hula_hoop"], ["mujoco"], ids=["*/spinning_3hz_60n/*/RK4/*"]):
        results += suite.run_check(check, engine=wrong, explain=False)
    assert {r.verdict for r in results if r.kind in ("trajectory", "order")} == {"deviation"}
    assert [bool(r.series) for r in results].count(True) == 5
    theta = next(r for r in results if (r.kind, r.quantity) == ("trajectory", "theta"))
    assert theta.series is not None
    assert np.max(np.abs(theta.series.value - theta.series.reference)) == theta.error


# The command line


ONE = ["check", "hula_hoop", "--engine", "mujoco", "--kind", "algebra", "-j", "1"]
ONE += ["--profile", "strict"]


@pytest.mark.usefixtures("own_folder")
def test_a_folder_is_made_and_written_again() -> None:
    for _ in range(2):
        done = invoke("", *ONE, "--html", "deep/pages")
        assert done.exit_code == 0, done.output
    found = Path("deep/pages/index.html").read_text(encoding="utf-8")
    assert "<title>PASS</title>" in found
    assert "mbcheck check --profile strict --id" in found
    assert os.listdir("deep/pages") == ["index.html"]


@pytest.mark.usefixtures("own_folder")
@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--html", "file"], "cannot write into 'file': it is no folder"),
        (["--html", "file/pages"], "cannot write into 'file/pages': it is no folder"),
        (["--html", "mine"], "exists and is no page of mbcheck"),
        (["--html", "-"], "--html needs the name of a folder"),
        (["--html", "a\0b"], "cannot write into"),
        (["--html", "out", "--json", "out/index.html"], "cannot both go to"),
    ],
)
def test_a_folder_that_is_refused(options: list[str], words: str) -> None:
    Path("file").write_text("")
    Path("mine").mkdir()
    Path("mine/index.html").write_text("<title>my home</title>")
    done = invoke("", *ONE, *options)
    assert done.exit_code == 2
    assert words in done.stderr
    assert Path("mine/index.html").read_text() == "<title>my home</title>"


@pytest.mark.usefixtures("own_folder")
def test_a_trajectory_has_a_page_too() -> None:
    Path("my run.csv").write_text("t,theta\n0,0.3\n0.1,1.8\n0.2,4\n")
    line = ["judge", "my run.csv", "--case", "hula_hoop/spinning_3hz_60n"]
    done = invoke("", *line, "--html", "out")
    assert "--html needs verdicts" in done.stderr
    options = "--tolerance 1e-3 --set free_mass=0.05 --html out --junit -"
    done = invoke("", *line, *options.split())
    assert done.exit_code == 1, done.output
    command = (
        "mbcheck judge 'my run.csv' --case hula_hoop/spinning_3hz_60n "
        "--set free_mass=0.05 --tolerance 0.001"
    )
    page = Page(Path("out/index.html").read_text(encoding="utf-8"))
    assert command in page.words
    assert "mbcheck check --id" not in page.words
    assert command in done.stdout
    assert len(page.all("img")) == 1

"""The page of a run: what is on it, and what a browser makes of it."""

import base64
import json
import os
import re
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from html.parser import HTMLParser
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.checks import suite
from mbcheck.comparisons.checks.known import Entry, Use
from mbcheck.comparisons.checks.verdict import Result, Series, Verdict, result_from
from mbcheck.comparisons.reports import drawing
from mbcheck.comparisons.reports.run import figures, page
from mbcheck.comparisons.reports.run.outcome import Report, Run
from mbcheck.comparisons.reports.run.results import MEASURES
from mbcheck.comparisons.reports.words import printable
from mbcheck.reference.errors import UsageError
from mbcheck.reference.scene import Array
from mbcheck.tests.support.command import invoke
from mbcheck.tests.support.faults import FAULTS

WHEN = datetime(2026, 1, 2, 3, 4, tzinfo=UTC)

HOSTILE = "<script>alert(1)</script>\"'&{{7*7}}{% raw %} $x_{^ \x1b[31m\x00\ud800</td></table>"
"""What an engine might call itself."""

STALE = Use(Entry(1, 3, "verification/*/gone/*", HOSTILE), 0, "stale", f"matches nothing {HOSTILE}")


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
    return Series("step", steps, steps**2, steps**2, 1e-3 / steps)


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


@pytest.fixture(scope="module")
def text() -> str:
    return text_of()


# What is on it


def test_nothing_is_loaded_and_nothing_runs(text: str) -> None:
    found = seen(text)
    assert not {"script", "link", "iframe", "object", "form"} & {tag for tag, _ in found.tags}
    for _, attributes in found.tags:
        assert not any(name.startswith("on") for name in attributes)
        for name in ("src", "href"):
            assert attributes.get(name, "#").startswith(("#", "data:image/svg+xml;base64,"))
    assert "@import" not in text
    assert "url(" not in text
    assert "default-src 'none'" in text
    for image in pictures(found):
        assert b"<script" not in image
        assert set(re.findall(rb"href=\"([^#\"]+)", image)) == set()


def pictures(found: Seen) -> list[bytes]:
    return [base64.b64decode(image["src"].partition(",")[2]) for image in found.all("img")]


def test_every_link_has_its_target(text: str) -> None:
    found = seen(text)
    ids = Counter(attributes["id"] for _, attributes in found.tags if "id" in attributes)
    assert set(ids.values()) == {1}
    links = [attributes["href"][1:] for attributes in found.all("a")]
    assert len(links) > 10
    assert set(links) <= set(ids)


def test_text_from_outside_is_text(text: str) -> None:
    assert "alert(1)" in text
    assert "<script" not in text
    shown = printable(HOSTILE)
    assert seen(text).words.count(" ".join(shown.split())) >= 8
    assert "49" not in re.findall(r"alert\(1\).{0,40}", text)
    text.encode()  # no surrogates
    assert not re.search("[\x00-\x08\x0b-\x1f\x7f]", text)


def test_failures_come_first_and_the_worst_of_them(text: str) -> None:
    words = seen(text).words
    places = [words.index(name) for name in ("/algebra/mujoco/RK4", "a/case/trajectory/mujoco")]
    assert places == sorted(places)  # the error, then the deviation
    assert "mujoco: its accelerations or its mass matrix is wrong" in words
    assert words.index("Deviations and errors (6)") < words.index("why y") < words.index("issue 12")
    assert "error 0.5" not in words  # numbers stand in cells
    assert "accelerations, mass_matrix : raised: it broke" in words
    assert "mbcheck check --id 'verification/a/case/trajectory/mujoco/RK4/y'" in words


def test_every_result_stands_with_its_command(text: str) -> None:
    words = seen(text).words
    for result in RESULTS[:-1]:
        assert f"mbcheck check --id '{result.id}'" in words


def test_the_matrix_counts(text: str) -> None:
    labels = [attributes["aria-label"] for attributes in seen(text).all("a") if
              "aria-label" in attributes]  # fmt: skip
    assert "a, mujoco, trajectory: 1 of 3 passed, 2 deviations" in labels
    assert "a, mujoco, algebra: 0 of 2 passed, 2 errors" in labels
    assert "b, exudyn, trajectory: 1 skipped" in labels


def test_known_stale_and_skipped_are_told(text: str) -> None:
    words = seen(text).words
    assert "mujoco issue 12 1" in words
    assert "Stale entries" in words
    assert "entry 1 (line 3) verification/*/gone/* matches nothing" in words
    assert "exudyn cannot do that 1" in words
    clean = text_of([made("pass", "x", error=1e-4)], uses=())
    for word in ("Stale", "Known deviations", "Skipped"):
        assert word not in clean
    assert "None." in seen(clean).words


def test_what_was_checked(text: str) -> None:
    words = seen(text).words
    for part in ("6 checks: 5 ran, 1 skipped", "2026-01-02 03:04 UTC", "2 s, all checks together",
                 "mbcheck 0.1", "machine x86_64", "everything that is checked by default",
                 ):  # fmt: skip
        assert part in words
    chosen = {"scenes": ("a",), "ids": (), "profile": "loose", "full": True}
    assert "scenes a; profile loose; with --full" in seen(text_of(UNDRAWN, selection=chosen)).words


@pytest.mark.parametrize(
    ("results", "run", "title", "worst"),
    [
        ([made("pass", "x")], {"uses": ()}, "PASS", "pass"),
        ([made("skipped", "x")], {"uses": ()}, "NOTHING RAN", "skipped"),
        ([], {"uses": ()}, "NOTHING RAN", "skipped"),
        ([made("pass", "x")], {"strict_known": True}, "FAIL", "deviation"),
        (UNDRAWN, {}, "FAIL", "error"),
    ],
)
def test_the_title_is_the_verdict(
    results: list[Result], run: dict[str, Any], title: str, worst: str
) -> None:
    found = text_of(results, **run)
    assert f"<title>{title}</title>" in found
    assert f'<p class="badge {worst}">{title}: ' in found


def test_an_interrupted_run_says_so() -> None:
    found = page.check_page(outcome(RESULTS[:1], planned=7, interrupted=True), WHEN)
    assert "<title>INTERRUPTED</title>" in found
    assert "6 not reached" in found
    assert "The run was interrupted" in found


def test_the_same_run_gives_the_same_page(text: str) -> None:
    assert text_of(UNDRAWN) == text_of(UNDRAWN)
    assert figures.deviation(RESULTS[1]).uri in text


# Pictures


def test_pictures_tell_in_words_what_they_show(text: str) -> None:
    images = seen(text).all("img")
    assert len(images) == 4  # two trajectories, an order, and work over precision
    assert all(len(image["alt"]) > 30 and int(image["width"]) > 300 for image in images)
    assert images[0]["alt"].startswith("y of mujoco over time beside the reference, and their")
    assert any("finest slope 2, expected 1.5" in image["alt"] for image in images)
    assert any("Error over step and over wall time" in image["alt"] for image in images)


def test_only_so_many_are_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page, "MOST_FIGURES", 1)
    found = seen(text_of())
    assert len(found.all("img")) == 2  # the worst, and work over precision
    assert "The worst 1 are drawn, 2 more are not." in found.words


def test_without_matplotlib(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing() -> None:
        raise UsageError("figures need matplotlib; pip install 'mbcheck[plot]'")

    monkeypatch.setattr(drawing, "import_pyplot", missing)
    found = seen(text_of())
    assert not found.all("img")
    assert "There are no pictures: figures need matplotlib; pip install 'mbcheck[plot]'." in (
        found.words
    )
    assert "There are no pictures" not in text_of(RESULTS[:1])


@pytest.mark.slow
@pytest.mark.parametrize(
    "series",
    [
        Series("time", np.array([0.1, 0.2]), np.array([1.0, 2.0]), np.array([1.0, 2.0])),
        Series("time", np.array([0.1, 0.2]), np.array([np.nan, np.inf]), np.array([1.0, 2.0])),
        Series("time", np.array([0.1]), np.array([3.0]), np.array([1.0])),
        Series("step", np.array([0.1, 0.05]), np.array([1.0, np.nan]), np.array([1.0, 0.5])),
        replace(over_step(), seconds=np.zeros(6)),
        replace(over_step(), seconds=None),
    ],
)
@pytest.mark.filterwarnings("error")
def test_odd_series_are_drawn(series: Series) -> None:
    kind = "order" if series.over == "step" else "trajectory"
    found = seen(text_of([made("deviation", "q", kind=kind, series=series)]))
    assert len(found.all("img")) == (2 if kind == "order" else 1)


def test_real_deviations_have_series() -> None:
    wrong = FAULTS["hula_hoop"]["free_mass_0.1_percent"].make["mujoco"]()
    results = []
    for check in suite.plan(ids=["verification/hula_hoop/spinning_3hz_60n/*/mujoco/RK4/*"]):
        results += suite.run_check(check, engine=wrong)
    assert {r.verdict for r in results if r.kind in ("trajectory", "order")} == {"deviation"}
    assert [bool(r.series) for r in results].count(True) == 5
    order = next(r for r in results if r.quantity == "order")
    assert order.series is not None
    assert order.series.seconds is not None
    assert np.all(order.series.seconds > 0)
    assert order.series.value[0] == order.series.reference[0]
    theta = next(r for r in results if (r.kind, r.quantity) == ("trajectory", "theta"))
    assert theta.series is not None
    assert np.max(np.abs(theta.series.value - theta.series.reference)) == theta.error


@pytest.mark.slow
def test_series_cross_processes_and_stay_out_of_documents() -> None:
    arguments: dict[str, Any] = {
        "engines": ["mujoco"],
        "ids": ["*/spinning_3hz_60n/trajectory/mujoco/RK4/*"],
    }
    alone = mbcheck.check(**arguments)
    limited = mbcheck.check(**arguments, time_limit=60)
    for one, other in zip(alone.results, limited.results, strict=True):
        assert (one.series is None) == (other.series is None)
        if one.series and other.series:
            assert np.array_equal(one.series.value, other.series.value)
    assert any(result.series for result in alone.results)
    assert "series" not in json.dumps(alone.as_json())
    assert replace(alone.results[0], series=None) == alone.results[0]


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
        (["--html", "mine"], "is there already, and no page of mbcheck"),
        (["--html", "-"], "--html needs the name of a folder"),
        (["--html", ""], "--html needs the name of a folder"),
        (["--html", "a\0b"], "cannot write into"),
        (["--html", "out", "--json", "out/index.html"], "cannot both go to"),
        (["--html", "x" * 300], "cannot write into"),
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
@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_cannot_be_written() -> None:
    Path("closed").mkdir(mode=0o500)
    done = invoke("", *ONE, "--html", "closed")
    assert done.exit_code == 2
    assert "--html: cannot write" in done.stderr


@pytest.mark.usefixtures("own_folder")
def test_an_interrupted_run_writes_what_it_has(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(checks: Any, *rest: Any) -> list[Result]:
        for item in rest:
            if callable(item) and getattr(item, "__name__", "") == "on_result":
                item([made("pass", "x")])
        raise KeyboardInterrupt

    monkeypatch.setattr(suite, "run_checks", interrupted)
    done = invoke("", *ONE, "--html", "out")
    assert done.exit_code == 130
    found = Path("out/index.html").read_text(encoding="utf-8")
    assert "<title>INTERRUPTED</title>" in found
    assert "verification/a/case/trajectory/mujoco/RK4/x" in found


@pytest.mark.usefixtures("own_folder")
def test_a_trajectory_has_a_page_too() -> None:
    Path("my run.csv").write_text("t,theta\n0,0.3\n0.1,1.8\n0.2,4\n")
    line = ["check", "--trajectory", "my run.csv", "--case", "hula_hoop/spinning_3hz_60n"]
    done = invoke("", *line, "--html", "out")
    assert "--html needs verdicts" in done.stderr
    options = "--tolerance 1e-3 --set free_mass=0.05 --html out --junit -"
    done = invoke("", *line, *options.split())
    assert done.exit_code == 1, done.output
    command = (
        "mbcheck judge 'my run.csv' --case hula_hoop/spinning_3hz_60n "
        "--set free_mass=0.05 --tolerance 0.001"
    )
    found = seen(Path("out/index.html").read_text(encoding="utf-8"))
    assert command in found.words
    assert "mbcheck check --id" not in found.words
    assert command in done.stdout
    assert len(found.all("img")) == 1


# A browser

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
BROWSER = next(filter(None, map(shutil.which, NAMES)), None)
QUIET = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
    "--allow-file-access-from-files",
)

PROBE = """<!DOCTYPE html><meta charset="utf-8"><title>probe</title>
<iframe id="f" src="index.html" style="border:0;width:{width}px;height:800px"></iframe>
<pre id="out"></pre>
<script>
const frame = document.getElementById("f");
frame.onload = () => {{
  const page = frame.contentDocument, view = frame.contentWindow, found = {{}};
  found.width = page.documentElement.scrollWidth;
  found.wide = [...page.querySelectorAll(".wide")].filter(e => e.scrollWidth > e.clientWidth + 1)
    .every(e => view.getComputedStyle(e).overflowX === "auto");
  found.images = [...page.images].map(i => i.complete && i.naturalWidth > 0);
  found.links = [...page.querySelectorAll("a")].map(a => {{
    for (const d of page.querySelectorAll("details")) d.open = false;
    a.click();
    const target = page.getElementById(a.hash.slice(1));
    return target !== null && target.getClientRects().length > 0;
  }});
  found.requests = view.performance.getEntriesByType("resource").map(e => e.name)
    .filter(name => !name.startsWith("data:"));
  document.getElementById("out").textContent = JSON.stringify(found);
}};
</script>
"""


@pytest.fixture(scope="module")
def browser(text: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Lend a function that runs the browser in a folder that holds the page."""
    if BROWSER is None:
        pytest.skip(f"there is no browser: none of {', '.join(NAMES)}")
    folder = tmp_path_factory.mktemp("browser")
    (folder / "index.html").write_text(text, encoding="utf-8")

    def run(*arguments: str, name: str = "index.html") -> str:
        profile = folder / "profile"
        profile.mkdir(exist_ok=True)
        place = f"{(folder / name).as_uri()}"
        done = subprocess.run(
            [BROWSER, *QUIET, f"--user-data-dir={profile}", *arguments, place],
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=120,
            check=True,
        )
        return done.stdout

    yield run, folder
    shutil.rmtree(folder / "profile", ignore_errors=True)


@pytest.mark.parametrize("width", [390, pytest.param(1280, marks=pytest.mark.slow)])
def test_in_a_browser(browser: Any, width: int) -> None:
    run, folder = browser
    (folder / "probe.html").write_text(PROBE.format(width=width), encoding="utf-8")
    dumped = run("--virtual-time-budget=10000", "--dump-dom", name="probe.html")
    told = re.search(r'<pre id="out">(.+?)</pre>', dumped)
    assert told, dumped[-2000:]
    found = json.loads(told[1])
    assert found["width"] <= width
    assert found["wide"]
    assert found["images"]
    assert all(found["images"])
    assert found["links"]
    assert all(found["links"]), "a link must open what it leads to"
    assert found["requests"] == []


@pytest.mark.slow
def test_it_is_drawn_and_printed(browser: Any) -> None:
    from PIL import Image

    run, folder = browser
    run("--window-size=1280,1600", f"--screenshot={folder / 'page.png'}")
    with Image.open(folder / "page.png") as image:
        assert image.size == (1280, 1600)
        assert len(image.convert("RGB").getcolors(1 << 20) or []) > 50
    run("--no-pdf-header-footer", f"--print-to-pdf={folder / 'page.pdf'}")
    assert (folder / "page.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.slow
def test_the_probe_sees_a_page_that_is_too_wide(browser: Any) -> None:
    run, folder = browser
    whole = (folder / "index.html").read_text(encoding="utf-8")
    try:
        broken = whole.replace("overflow-x: auto", "overflow-x: visible").replace(
            'id="verdicts"', 'id="elsewhere"'
        )
        (folder / "index.html").write_text(broken, encoding="utf-8")
        (folder / "probe.html").write_text(PROBE.format(width=390), encoding="utf-8")
        dumped = run("--virtual-time-budget=10000", "--dump-dom", name="probe.html")
    finally:
        (folder / "index.html").write_text(whole, encoding="utf-8")
    found = json.loads(re.search(r'<pre id="out">(.+?)</pre>', dumped)[1])  # type: ignore[index]
    assert found["width"] > 390
    assert not all(found["links"])


def test_imported_only_when_wanted(tmp_path: Path) -> None:
    loaded = (
        "import sys; from mbcheck.comparisons.cli import group as cli; "
        "print(sorted({'jinja2', 'matplotlib'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", loaded], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"

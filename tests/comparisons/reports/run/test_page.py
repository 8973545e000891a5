"""The page of a run: what is on it."""

import base64
import json
import os
import re
import subprocess
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.check import request
from mbcheck.comparisons.checks import suite
from mbcheck.comparisons.checks.request import CheckRequest
from mbcheck.comparisons.checks.verdict import Result, Series
from mbcheck.comparisons.reports import drawing
from mbcheck.comparisons.reports.run import figures, page
from mbcheck.comparisons.reports.words import printable
from mbcheck.reference.errors import UsageError
from mbcheck.tests.support.command import invoke
from mbcheck.tests.support.faults import FAULTS
from mbcheck.tests.support.pages import (
    HOSTILE,
    RESULTS,
    UNDRAWN,
    WHEN,
    Seen,
    made,
    outcome,
    over_step,
    seen,
    text_of,
)


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
    assert "mujoco: its accelerations or its mass matrix could not be judged" in words
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
    chosen = CheckRequest(("a",), profile="loose", full=True)
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
    assert len(images) == 3  # two trajectories and an order
    assert all(len(image["alt"]) > 30 and int(image["width"]) > 300 for image in images)
    assert images[0]["alt"].startswith("y of mujoco over time beside the reference, and their")
    assert any("finest slope 2, expected 1.5" in image["alt"] for image in images)


def test_only_so_many_are_drawn() -> None:
    found = seen(page.check_page(outcome(), WHEN, most_figures=1))
    assert len(found.all("img")) == 1  # the worst
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
        over_step(),
    ],
)
@pytest.mark.filterwarnings("error")
def test_odd_series_are_drawn(series: Series) -> None:
    kind = "order" if series.over == "step" else "trajectory"
    found = seen(text_of([made("deviation", "q", kind=kind, series=series)]))
    assert len(found.all("img")) == 1


def test_real_deviations_have_series() -> None:
    wrong = FAULTS["hula_hoop"]["free_mass_0.1_percent"].make["mujoco"]()
    results = []
    for check in suite.plan(["hula_hoop"], ["mujoco"], ids=["*/spinning_3hz_60n/*/RK4/*"]):
        results += suite.run_check(check, engine=wrong, explain=False)
    assert {r.verdict for r in results if r.kind in ("trajectory", "order")} == {"deviation"}
    assert [bool(r.series) for r in results].count(True) == 5
    order = next(r for r in results if r.quantity == "order")
    assert order.series is not None
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

    monkeypatch.setattr(request, "run_checks", interrupted)
    done = invoke("", *ONE, "--html", "out")
    assert done.exit_code == 130
    found = Path("out/index.html").read_text(encoding="utf-8")
    assert "<title>INTERRUPTED</title>" in found
    assert "verification/a/case/trajectory/mujoco/RK4/x" in found


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
    found = seen(Path("out/index.html").read_text(encoding="utf-8"))
    assert command in found.words
    assert "mbcheck check --id" not in found.words
    assert command in done.stdout
    assert len(found.all("img")) == 1


def test_imported_only_when_wanted(tmp_path: Path) -> None:
    loaded = (
        "import sys; from mbcheck.comparisons.cli import group as cli; "
        "print(sorted({'jinja2', 'matplotlib'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", loaded], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"

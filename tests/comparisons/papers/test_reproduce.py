"""The runner of the ledgers: failures, resuming, pages."""

from __future__ import annotations

import json
import re
from collections import Counter
from dataclasses import replace
from html import unescape
from pathlib import Path
from typing import Any

import pytest

from mbcheck.comparisons.papers import ledger, pages, reproduce
from mbcheck.comparisons.papers.assess import assess
from mbcheck.comparisons.papers.claims import PaperData
from mbcheck.comparisons.papers.ledger import PaperFigure
from mbcheck.comparisons.papers.session import Session
from mbcheck.comparisons.reports import drawing
from mbcheck.reference import get_scene
from mbcheck.reference.errors import EngineError, UsageError
from mbcheck.tests.support.command import invoke
from mbcheck.tests.support.documents import validated
from mbcheck.tests.support.papers.shared import SharedSession, row_of

# The runner


def drawn(session: Session) -> Any:
    figure, axes = drawing.new_figure()
    axes[0, 0].plot([0, 1], [0, 1])
    return figure


def crash(session: Session) -> Any:
    raise EngineError("non_finite", "the state <b>exploded</b> | at once")


def crash_unforeseen(session: Session) -> Any:
    raise ZeroDivisionError("a slip of ours")


TOY_FIGURES = (
    PaperFigure(2, "a line", "Drawn with k = 1 <N/m>.", drawn),
    PaperFigure(3, "nothing", "Of no use.", crash),
)
SPEED = row_of("speed", lambda session: {"value": 2.01}, kind="number", printed="2.0 m/s")
TOY_ROWS = (
    SPEED,
    row_of("broken", crash, claim="it <i>works</i>"),
    row_of("slip", crash_unforeseen),
    row_of(
        "units",
        kind="reading",
        verdict=ledger.READ,
        claim="a | unit",
        reason="none given",
        candidates={"m": "1", "km": "2"},
    ),
)


def replace_papers(monkeypatch: pytest.MonkeyPatch, figures: Any, rows: Any) -> None:
    """Let scenes have another paper."""
    for module in (reproduce, pages):
        monkeypatch.setattr(module, "read_paper", lambda scene: PaperData(figures, rows))


@pytest.fixture
def _toys(monkeypatch: pytest.MonkeyPatch) -> None:
    replace_papers(monkeypatch, TOY_FIGURES, TOY_ROWS)


@pytest.mark.usefixtures("_toys")
def test_what_fails_is_told_and_the_rest_goes_on(tmp_path: Path) -> None:
    steps: list[tuple[int, int, str]] = []
    found = reproduce.reproduce(
        ["hula_hoop"], out=tmp_path, progress=lambda *step: steps.append(step)
    )
    verdicts = [item.verdict for item in found.rows]
    assert verdicts == [ledger.REPRODUCED, ledger.ERROR, ledger.ERROR, ledger.READ]
    assert len(found.failures) == 3
    assert "exploded" in found.failures[0]
    assert "ZeroDivisionError" in found.failures[2]
    assert steps[-1][:2] == (6, 6)
    assert {path.name for path in (tmp_path / "figures").iterdir()} == {
        "hula_hoop_2.png",
        "hula_hoop_2.svg",
    }


@pytest.mark.usefixtures("_toys")
def test_interrupted_run_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[str] = []

    def once(session: Session) -> dict[str, float]:
        calls.append("speed")
        return {"value": 2.01}

    def interrupted(session: Session) -> dict[str, float]:
        raise KeyboardInterrupt

    rows = (replace(SPEED, numbers=once), TOY_ROWS[3])
    stopped = row_of("stop", interrupted)
    replace_papers(monkeypatch, TOY_FIGURES[:1], (*rows, stopped))
    with pytest.raises(KeyboardInterrupt):
        reproduce.reproduce(["hula_hoop"], out=tmp_path)
    replace_papers(monkeypatch, TOY_FIGURES[:1], rows)
    again = reproduce.reproduce(["hula_hoop"], out=tmp_path, resume=True)
    assert calls == ["speed"]
    assert [(item.verdict, item.reason, item.thresholds) for item in again.rows] == [
        (found.verdict, found.reason, found.thresholds)
        for found in (assess(row, Session()) for row in rows)
    ]
    assert calls == ["speed"] * 2
    reproduce.reproduce(["hula_hoop"], out=tmp_path)
    assert calls == ["speed"] * 3


def test_sessions_of_tests_share_what_one_has_computed(tmp_path: Path) -> None:
    """But not what hangs on fewer points, or on shorter runs."""
    calls: list[float] = []

    def produce() -> float:
        calls.append(float(len(calls)))
        return calls[-1]

    def value(**changes: Any) -> float:
        return SharedSession(shared=tmp_path, **changes).once(("scene", "run"), produce)

    assert [value(), value(engines=("mujoco",)), value(points=2), value(seconds=1.0), value()] == [
        0, 0, 1, 2, 0
    ]  # fmt: skip
    equations = get_scene("hula_hoop")
    assert SharedSession(shared=tmp_path).once("equations", lambda: equations) is equations


@pytest.mark.usefixtures("_toys")
def test_pages_show_everything_and_escape_it(tmp_path: Path) -> None:
    found = reproduce.reproduce(["hula_hoop"], out=tmp_path)
    pages.write_pages(found, tmp_path)
    page = (tmp_path / "hula_hoop.html").read_text(encoding="utf-8")
    tags = Counter(re.findall(r"<(\w+)", page))
    assert [tags[name] for name in ("img", "table", "i", "b", "script")] == [1, 4, 0, 0, 0]
    shown = unescape(re.sub(r"<[^>]*>", "", page))
    for words in (
        "Figure 2",
        "a line",
        "it <i>works</i>",
        "<b>exploded</b> | at once",
        "a | unit",
        "k = 1 <N/m>",
    ):
        assert words in shown
    index = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert 'href="hula_hoop.html"' in index
    assert "(hula_hoop.md)" in (tmp_path / "index.md").read_text(encoding="utf-8")


@pytest.mark.usefixtures("_toys")
def test_verb_exits_with_1_if_something_failed(tmp_path: Path) -> None:
    line = ["reproduce", "hula_hoop", "--out", str(tmp_path), "--json", str(tmp_path / "a.json")]
    done = invoke("", *line)
    assert done.exit_code == 1
    assert "exploded" in done.stderr
    assert re.match(r"\d+ figures? and \d+ rows? of hula_hoop: about ", done.stderr)
    found = validated("reproduce", json.loads((tmp_path / "a.json").read_text()))
    assert found["rows"][0]["verdict"] == ledger.REPRODUCED
    assert (tmp_path / "summary.md").exists()


@pytest.mark.usefixtures("_toys")
def test_one_figure_alone(tmp_path: Path) -> None:
    found = reproduce.reproduce(["hula_hoop"], out=tmp_path, figure=2)
    assert not found.failures
    assert found.rows == ()
    with pytest.raises(UsageError, match="there is no figure 9; there are 2, 3"):
        reproduce.reproduce(["hula_hoop"], out=tmp_path, figure=9)


def test_a_scene_without_a_paper_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="rigid_body has no paper to reproduce"):
        reproduce.reproduce(["rigid_body"], out=tmp_path)


@pytest.mark.usefixtures("_toys")
def test_rows_and_figures_alone_take_their_place_in_what_is_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    reproduce.reproduce(["hula_hoop"], out=tmp_path)
    other = (replace(SPEED, numbers=lambda session: {"value": 3.0}), *TOY_ROWS[1:])
    replace_papers(monkeypatch, TOY_FIGURES, other)
    found = reproduce.reproduce(["hula_hoop"], out=tmp_path, rows=["speed"])
    assert [item.name for item in found.rows] == ["speed"]
    assert found.figures == ()
    both = reproduce.reproduce(["hula_hoop"], out=tmp_path, figure=2, rows=["units"])
    assert [len(both.figures), len(both.rows)] == [1, 1]
    whole = reproduce.contents(tmp_path)
    assert [item.name for item in whole.rows] == [row.name for row in TOY_ROWS]
    assert whole.rows[0].verdict == ledger.NOT_REPRODUCED
    assert [item.number for item in whole.figures] == [2, 3]
    pages.write_pages(whole, tmp_path)
    page = (tmp_path / "hula_hoop.md").read_text(encoding="utf-8")
    assert "#### `units`" in page
    assert "3 m/s" in page
    with pytest.raises(UsageError, match="did you mean 'speed'"):
        reproduce.reproduce(["hula_hoop"], out=tmp_path, rows=["sped"])


@pytest.mark.usefixtures("_toys")
def test_what_other_versions_found_is_kept_apart(tmp_path: Path) -> None:
    reproduce.reproduce(["hula_hoop"], out=tmp_path)
    file = tmp_path / "findings.json"
    older = json.loads(file.read_text("utf-8"))
    older["runs"][0]["versions"]["mbcheck"] = "0.0.1"
    file.write_text(json.dumps(older), "utf-8")
    reproduce.reproduce(["hula_hoop"], out=tmp_path, rows=["speed"], resume=True)
    runs = reproduce.contents(tmp_path).runs
    assert sorted(run.versions["mbcheck"] == "0.0.1" for run in runs) == [False, True]


@pytest.mark.usefixtures("_toys")
def test_a_damaged_file_is_replaced(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "findings.json").write_text('{"rows": 3}', "utf-8")
    reproduce.reproduce(["hula_hoop"], out=tmp_path, rows=["speed"])
    assert "is damaged, or another document" in caplog.text
    assert len(reproduce.contents(tmp_path).rows) == 1


@pytest.mark.usefixtures("_toys")
def test_a_row_alone_is_printed(tmp_path: Path) -> None:
    done = invoke("", "reproduce", "hula_hoop", "--row", "speed", "--out", str(tmp_path))
    assert done.exit_code == 0
    assert "hula_hoop speed: reproduced" in done.stdout
    assert "printed 2.0 m/s; reference 2.01 m/s" in done.stdout


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("hula_hop", "did you mean 'hula_hoop'"),
        ("--figure 99", "there is no figure 99"),
        ("hula_hoop --row mean_slop", "did you mean 'mean_slope'"),
        ("--figure two", "not a valid integer"),
        ("--out /proc/nowhere", "cannot write"),
    ],
)
def test_misuse_is_told_in_one_line(line: str, words: str, tmp_path: Path) -> None:
    out = [] if "--out" in line else ["--out", str(tmp_path)]
    done = invoke(f"reproduce {line}", *out)
    assert done.exit_code == 2
    assert words in " ".join(done.stderr.split())

"""The ledger and its runner: verdicts, failures, resuming, pages; and the committed summary."""

from __future__ import annotations

import json
import re
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

from mbcheck.comparisons.engines.registry import available
from mbcheck.comparisons.papers import ledger, pages, reproduce
from mbcheck.comparisons.papers.figure import Figure
from mbcheck.comparisons.papers.ledger import Finding, Row
from mbcheck.comparisons.papers.session import Session
from mbcheck.comparisons.reports import drawing
from mbcheck.reference import SCENES
from mbcheck.reference.errors import EngineError, UsageError
from mbcheck.tests.support.command import invoke
from mbcheck.tests.support.documents import validated

ROOT = Path(__file__).resolve().parents[3]
SUMMARY = ROOT / "docs" / "ledger.md"


# Verdicts


@pytest.mark.parametrize(
    ("printed", "value", "verdict"),
    [
        ("3.10", 3.1049, ledger.REPRODUCED),
        ("3.10", 3.0951, ledger.REPRODUCED),
        ("3.10", 3.1051, ledger.NOT_REPRODUCED),
        ("153.8", 153.74, ledger.NOT_REPRODUCED),
        ("0.000204", 0.0002044, ledger.REPRODUCED),
        ("7e-4", 7.6e-4, ledger.NOT_REPRODUCED),
        ("-0.515", -0.5154, ledger.REPRODUCED),
        ("-0.515", 0.515, ledger.NOT_REPRODUCED),
        ("5", float("nan"), ledger.NOT_REPRODUCED),
    ],
)
def test_number_is_reproduced_if_it_rounds_to_what_is_printed(
    printed: str, value: float, verdict: str
) -> None:
    assert ledger.number(printed, value).verdict == verdict


def test_corrected_equation_is_told_apart() -> None:
    assert ledger.number("2.0", 2.01, corrected=True).verdict == ledger.CORRECTED
    assert ledger.number("2.0", 2.1, corrected=True).verdict == ledger.NOT_REPRODUCED
    assert ledger.claimed(True, "", corrected=True).verdict == ledger.CORRECTED
    assert ledger.claimed(False, "", corrected=True).verdict == ledger.NOT_REPRODUCED


# The tables of the papers


def all_rows() -> list[tuple[str, Row]]:
    return [(scene, row) for scene in SCENES for row in reproduce.tables(scene)[1]]


@pytest.mark.parametrize("scene", SCENES)
def test_tables_are_complete(scene: str) -> None:
    figures, rows = reproduce.tables(scene)
    wanted = {
        "hula_hoop": range(2, 8),
        "rotor_pendulum": range(2, 7),
        "rotating_beam": range(2, 6),
        "speed_regulator": range(3, 8),
    }
    assert [figure.number for figure in figures] == list(wanted[scene])
    assert len({row.name for row in rows}) == len(rows) >= 20
    assert {row.kind for row in rows} == set(ledger.KINDS)
    for row in rows:
        assert re.fullmatch(r"[a-z0-9_]+", row.name)
        assert row.kind in ledger.KINDS
        assert row.section
        assert row.claim
        assert bool(row.test) >= (row.kind == "misprint")
        assert bool(row.printed) or row.kind != "number"


@pytest.mark.parametrize("row", [row for _, row in all_rows() if row.kind == "misprint"])
def test_misprint_has_a_test_that_shows_it(row: Row) -> None:
    path, _, name = row.test.partition("::")
    text = (ROOT / path).read_text(encoding="utf-8")
    assert re.search(rf"^def {re.escape(name)}\(", text, re.MULTILINE), row.test


def committed() -> dict[tuple[str, str], str]:
    """Return the verdicts of the committed summary."""
    found, scene = {}, ""
    for line in SUMMARY.read_text(encoding="utf-8").splitlines():
        if line.startswith("## "):
            scene = line[3:]
        elif line.startswith("| `") and scene:
            cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
            found[scene, cells[0].strip("`")] = cells[-1]
    return found


def test_summary_has_every_row() -> None:
    assert set(committed()) == {(scene, row.name) for scene, row in all_rows()}
    assert set(committed().values()) <= set(ledger.VERDICTS)


def test_counts_are_those_of_the_rows() -> None:
    for scene in SCENES:
        number = Counter(verdict for (own, _), verdict in committed().items() if own == scene)
        line = f"| `{scene}` | {' | '.join(str(number[name]) for name in ledger.VERDICTS)} |"
        assert line in SUMMARY.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def alone() -> Session:
    return Session()


@pytest.fixture(scope="module")
def with_engines(tmp_path_factory: pytest.TempPathFactory) -> Session:
    """At the size of ``mbcheck reproduce``."""
    return Session(available(), folder=tmp_path_factory.mktemp("maps"))


def judged(scene: str, row: Row, session: Session) -> None:
    """Judge a row: its verdict is the committed one, and what it says fits it."""
    finding = row.find(session)
    assert finding.verdict == committed()[scene, row.name], finding.reason
    assert finding.reason
    assert "\n" not in finding.reason
    assert "nan" not in f"{finding.reason} {finding.reference} {finding.engines}".split()
    assert set(finding.engines) <= set(session.engines)
    assert bool(finding.candidates) == (row.kind == "reading")
    if row.kind == "number" and finding.reason.startswith("off by"):
        ours, printed = float(finding.reference.split()[0]), row.printed.split()[0]
        near = abs(ours - float(printed)) <= 1.01 * ledger.half_unit(printed)
        assert near == (finding.verdict != ledger.NOT_REPRODUCED)


def cases(slow_too: bool) -> list[Any]:
    return [
        pytest.param(scene, row, id=f"{scene}-{row.name}")
        for scene, row in all_rows()
        if slow_too or not row.slow
    ]


@pytest.mark.parametrize(("scene", "row"), cases(slow_too=False))
def test_quick_row_without_engines(scene: str, row: Row, alone: Session) -> None:
    judged(scene, row, alone)


@pytest.mark.slow
@pytest.mark.parametrize(("scene", "row"), cases(slow_too=True))
def test_row_with_engines(scene: str, row: Row, with_engines: Session) -> None:
    judged(scene, row, with_engines)


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
    Figure(2, "a line", "Drawn with k = 1 <N/m>.", drawn),
    Figure(3, "nothing", "Of no use.", crash),
)
TOY_ROWS = (
    Row("speed", "number", "5", "a speed", lambda s: ledger.number("2.0", 2.01, "m/s"), "2.0 m/s"),
    Row("broken", "claim", "6", "it <i>works</i>", crash),
    Row("slip", "claim", "6", "no slip", crash_unforeseen),
    Row(
        "units",
        "reading",
        "table 1",
        "a | unit",
        lambda s: Finding(ledger.NOT_TESTABLE, "none given", candidates=(("m", "1"), ("km", "2"))),
    ),
)


@pytest.fixture
def _toys(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reproduce, "tables", lambda scene: (TOY_FIGURES, TOY_ROWS))


@pytest.mark.usefixtures("_toys")
def test_what_fails_is_told_and_the_rest_goes_on(tmp_path: Path) -> None:
    steps: list[tuple[int, int, str]] = []
    found = reproduce.reproduce(
        ["hula_hoop"], out=tmp_path, progress=lambda *step: steps.append(step)
    )
    verdicts = [item.finding.verdict for item in found.rows["hula_hoop"]]
    assert verdicts == [ledger.REPRODUCED, ledger.ERROR, ledger.ERROR, ledger.NOT_TESTABLE]
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
    seen: list[str] = []

    def once(session: Session) -> Finding:
        seen.append("speed")
        return ledger.number("2.0", 2.01, "m/s")

    def interrupted(session: Session) -> Finding:
        raise KeyboardInterrupt

    rows = (Row("speed", "number", "5", "a speed", once, "2.0"),)
    stopped = Row("stop", "claim", "6", "stops", interrupted)
    monkeypatch.setattr(reproduce, "tables", lambda scene: (TOY_FIGURES[:1], (*rows, stopped)))
    with pytest.raises(KeyboardInterrupt):
        reproduce.reproduce(["hula_hoop"], out=tmp_path)
    monkeypatch.setattr(reproduce, "tables", lambda scene: (TOY_FIGURES[:1], rows))
    again = reproduce.reproduce(["hula_hoop"], out=tmp_path, resume=True)
    assert seen == ["speed"]
    assert again.rows["hula_hoop"][0].finding == ledger.number("2.0", 2.01, "m/s")
    reproduce.reproduce(["hula_hoop"], out=tmp_path)
    assert seen == ["speed", "speed"]


class Tags(HTMLParser):
    """The tags of a page, and its text."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: Counter[str] = Counter()
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags[tag] += 1

    def handle_data(self, data: str) -> None:
        self.text += data


@pytest.mark.usefixtures("_toys")
def test_pages_show_everything_and_escape_it(tmp_path: Path) -> None:
    found = reproduce.reproduce(["hula_hoop"], out=tmp_path)
    pages.write_pages(found, tmp_path)
    page = Tags()
    page.feed((tmp_path / "hula_hoop.html").read_text(encoding="utf-8"))
    assert page.tags["img"] == 1
    assert page.tags["table"] == 4
    assert not page.tags["i"]
    assert not page.tags["b"]
    assert not page.tags["script"]
    for words in ("it <i>works</i>", "<b>exploded</b> | at once", "a | unit", "k = 1 <N/m>"):
        assert words in page.text
    index = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert 'href="hula_hoop.html"' in index
    assert "(hula_hoop.md)" in (tmp_path / "index.md").read_text(encoding="utf-8")


@pytest.mark.usefixtures("_toys")
def test_verb_exits_with_1_if_something_failed(tmp_path: Path) -> None:
    line = ["reproduce", "hula_hoop", "--out", str(tmp_path), "--json", str(tmp_path / "a.json")]
    done = invoke("", *line)
    assert done.exit_code == 1
    assert "exploded" in done.stderr
    found = validated("reproduce", json.loads((tmp_path / "a.json").read_text()))
    assert found["rows"][0]["verdict"] == ledger.REPRODUCED
    assert (tmp_path / "summary.md").exists()


@pytest.mark.usefixtures("_toys")
def test_one_figure_alone(tmp_path: Path) -> None:
    found = reproduce.reproduce(["hula_hoop"], out=tmp_path, figure=2)
    assert not found.failures
    assert found.rows["hula_hoop"] == ()
    with pytest.raises(UsageError, match="there is no figure 9; there are 2, 3"):
        reproduce.reproduce(["hula_hoop"], out=tmp_path, figure=9)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("hula_hop", "did you mean 'hula_hoop'"),
        ("--figure 99", "there is no figure 99"),
        ("--figure two", "not a valid integer"),
        ("--out /proc/nowhere", "cannot write"),
    ],
)
def test_misuse_is_told_in_one_line(line: str, words: str, tmp_path: Path) -> None:
    out = [] if "--out" in line else ["--out", str(tmp_path)]
    done = invoke(f"reproduce {line}", *out)
    assert done.exit_code == 2
    assert words in " ".join(done.stderr.split())

"""What CI services see: Markdown, annotations, JUnit; and the workflow files."""

from __future__ import annotations

import fnmatch
import io
import json
import os
import re
import shutil
import subprocess
import tomllib
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.version import Version
from rich.console import Console

from mbcheck.comparisons.check import request
from mbcheck.comparisons.checks import known, suite
from mbcheck.comparisons.checks.known import Entry, Use
from mbcheck.comparisons.checks.request import CheckRequest
from mbcheck.comparisons.checks.verdict import Result
from mbcheck.comparisons.reports import github
from mbcheck.comparisons.reports.run.outcome import Checks, Report
from mbcheck.comparisons.reports.run.sections import print_report, run_annotations, run_summary
from mbcheck.comparisons.reports.run.sections import run_junit as junit
from mbcheck.tests.support.command import invoke
from mbcheck.tests.support.documents import validated
from mbcheck.tests.support.results import HOSTILE, MIXED, VERSIONS, changed, result

yaml = pytest.importorskip("yaml")

ROOT = Path(__file__).resolve().parents[4]
WORKFLOWS = [*ROOT.glob("docs/*workflow.yml"), *ROOT.glob(".github/workflows/*.yml")]
RUN = "check hula_hoop --engine mujoco --kind frequency -j 1"

STALE = Use(Entry(2, "*/RK9/*", "gone"), 0, "stale", "no check has such an id")
USED = Use(Entry(1, "*/RK67/*", "listed"), 1, "used")


pytestmark = pytest.mark.usefixtures("own_folder")


def outcome(results: list[Result], strict: bool = False, **run: Any) -> Report:
    return Report(
        tuple(results),
        VERSIONS,
        environment={"machine": "x86_64"},
        selection=CheckRequest(known="k.toml", strict_known=strict),
        known=(USED, STALE),
        **run,
    )


def workflow_commands(report: Report) -> list[str]:
    """Return the annotations of a run."""
    return github.workflow_commands(run_annotations(report))


# What every report tells


def test_every_report_tells_what_ran_and_why_not() -> None:
    found = outcome(MIXED, planned=9)
    document = found.as_json()
    validated("check", document)
    assert document["checks"] == {"planned": 9, "ran": 4, "skipped": 2, "not_reached": 3}
    assert document["skipped"] == [{"engine": "exudyn", "reason": "no such model", "results": 2}]
    line = "9 checks: 4 ran, 2 skipped, 3 not reached"
    raw = io.StringIO()
    print_report(Console(file=raw, width=80), found)
    texts = {
        "console": raw.getvalue(),
        "markdown": run_summary(found),
        "annotations": "\n".join(workflow_commands(found)),
    }
    for name, text in texts.items():
        assert line in text, name
        assert "no such model" in text, name
        assert "RK9" in text, name
    cases = ET.fromstring(junit(found))
    assert len(cases.findall(".//skipped[@message='no such model']")) == 2
    assert cases.find(".//property[@name='mujoco']") is not None


def test_a_check_is_repeated_as_it_was_run() -> None:
    plain = CheckRequest(engines=("mujoco",))
    assert Report((), {}, selection=plain).check_command == "mbcheck check"
    odd = CheckRequest(engines=("mujoco", "a.b:C d"), profile="strict", full=True)
    assert (
        Report((), {}, selection=odd).check_command
        == "mbcheck check --engine 'a.b:C d' --profile strict --full"
    )


def test_an_engine_that_is_not_there_is_no_check() -> None:
    blank = changed(
        result(verdict="skipped", kind="-"), id="verification/-/-/-/exudyn/-/-", scene="-"
    )
    assert Report((blank,), {}).checks == Checks(0, 0, 0, 0)


@pytest.mark.parametrize(("strict", "code"), [(False, 0), (True, 1)])
def test_stale_entries_fail_if_they_are_to(strict: bool, code: int) -> None:
    assert outcome([result()], strict).exit_code == code
    assert outcome([result(verdict="skipped")], strict).exit_code == 2


# Markdown


def columns(text: str) -> set[int]:
    """Return the numbers of cells in the rows of each table."""
    tables = re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE)
    return {
        len({len(re.findall(r"(?<!\\)\|", line)) for line in table.splitlines()})
        for table in tables
    }


def test_the_summary_has_what_failed_first() -> None:
    text = run_summary(outcome(MIXED))
    heads = re.findall(r"^#+ (.*)$", text.replace("\\_", "_"), re.MULTILINE)
    assert heads == [
        "mbcheck: FAIL: 2 passed, 1 deviation, 1 error, 1 known, 2 skipped, "
        "1 of the known deviations stale",
        "Located:",
        f"DEVIATION {MIXED[2].check_id}  1 of 2 quantities",
        f"ERROR {MIXED[6].check_id}",
        "Verdicts",
        "Accuracy",
        "Known deviations (1)",
        "Stale known deviations",
        "Skipped (2)",
    ]
    assert "| theta | rad | 5e-05 | 0 | 5e-05 | 2e-06 | 25 |" in text
    assert re.search(
        r"^\| +exudyn \| 1 of 1 known \| \*\*1 of 1 in error\*\* \|$", text, re.MULTILINE
    )
    assert columns(text) == {1}


def test_the_summary_of_thousands_is_short() -> None:
    many = [result(f"m{i}", "deviation", reason="x" * 500) for i in range(3000)]
    text = run_summary(outcome(many))
    assert len(text) < 2**17
    assert "and 2950 more checks" in text


def test_hostile_text_does_not_leave_its_cell() -> None:
    odd = changed(
        result(verdict="deviation", reason=HOSTILE + "</table>\n\n# `x` @someone [a](b)"),
        id=HOSTILE.replace("\ud800", ""),
        engine=HOSTILE,
        scene=HOSTILE,
    )
    text = run_summary(Report((odd,), {HOSTILE: HOSTILE}))
    assert columns(text) == {1}
    outside = re.sub("`.*?`", "", re.sub(r"\\.", "", text))
    assert "<" not in outside
    assert "@s" not in outside
    assert "](" not in outside
    assert not re.search(r"[\x00-\x09\x0b-\x1f]", text)


def test_the_summary_of_github_grows(monkeypatch: pytest.MonkeyPatch) -> None:
    Path("summary.md").write_text("before\n")
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", "summary.md")
    done = invoke(f"{RUN} -q --markdown own.md")
    assert done.exit_code == 0
    own = Path("own.md").read_text()
    assert re.match("## mbcheck: PASS: [1-9][0-9]* passed", own)
    assert Path("summary.md").read_text() == f"before\n{own}\n"
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", "nowhere/summary.md")
    done = invoke(f"{RUN} -q")
    assert done.exit_code == 0
    assert done.stderr == (
        "Warning: GITHUB_STEP_SUMMARY: cannot write 'nowhere/summary.md': "
        "No such file or directory\n"
    )


# Annotations

COMMAND = re.compile(r"^::(error|warning|notice) ((?:[a-z]+=[^,:\n\r]*,?)+)::([^\n\r]*)$")


def obeyed(line: str) -> tuple[str, dict[str, str], str]:
    """Return what GitHub's runner makes of a line."""
    found = COMMAND.match(line)
    assert found, line

    def plain(text: str) -> str:
        for code, sign in (("%0D", "\r"), ("%0A", "\n"), ("%3A", ":"), ("%2C", ","), ("%25", "%")):
            text = text.replace(code, sign)
        return text

    pairs = (pair.partition("=")[::2] for pair in found[2].split(","))
    return found[1], {name: plain(text) for name, text in pairs}, plain(found[3])


def test_annotations() -> None:
    lines = [obeyed(line) for line in workflow_commands(outcome(MIXED))]
    assert [line[0] for line in lines] == ["error", "error", "error", "warning", "notice"]
    assert lines[0][1]["title"] == "mbcheck: located"
    assert lines[0][2].splitlines()[0] == "mujoco: a free run is wrong"
    assert lines[1][1]["title"] == f"deviation: {MIXED[2].check_id}"
    assert lines[2][1]["title"] == f"error: {MIXED[6].check_id}"
    assert lines[1][2].splitlines() == [
        "theta = 5e-05 rad, reference 0 rad; error 5e-05 rad, tolerance 2e-06 rad "
        "(25 x its tolerance)",
        f"mbcheck check --id '{MIXED[2].id}'",
    ]
    assert lines[3][1] == {"file": "k.toml", "line": "1", "title": "stale known deviation"}
    strict = [obeyed(line) for line in workflow_commands(outcome(MIXED, strict=True))]
    assert [line[0] for line in strict] == ["error", "error", "error", "error", "notice"]


def test_no_more_annotations_than_github_shows() -> None:
    many = [result(f"m{i}", "deviation", error=1e-5 * (i + 1)) for i in range(40)]
    lines = [obeyed(line) for line in workflow_commands(outcome(many, strict=True))]
    errors = [line for line in lines if line[0] == "error"]
    assert len(errors) == 10
    assert "stale" in errors[0][1]["title"]
    assert errors[1][1]["title"] == "mbcheck: located"
    assert errors[2][1]["title"].endswith("/m39")
    assert errors[-1][2].startswith("33 more")


def test_nothing_that_ran_is_an_error() -> None:
    lines = workflow_commands(outcome([result(verdict="skipped")]))
    (error,) = [line for line in map(obeyed, lines) if line[0] == "error"]
    assert "NOTHING RAN" in error[2]


def test_annotations_are_escaped() -> None:
    text = f"{HOSTILE}100% a:b,c\n::error::me\r::warning::too %0A%25"
    odd = changed(result(verdict="deviation", reason=text), id=text.replace("\ud800", ""))
    found = Report((odd,), {}, selection=CheckRequest(known=text), known=(STALE,))
    lines = "\n".join(workflow_commands(found)).split("\n")
    assert len(lines) == 4
    level, properties, message = obeyed(lines[1])
    assert level == "error"
    assert properties["title"].startswith("deviation: [bold red]\\[/] ]]> <a b='c'>")
    assert "100% a:b,c ::error::me ::warning::too %0A%25" in properties["title"]
    assert "100% a:b,c\n::error::me\n::warning::too %0A%25" in message


def test_annotations_where_github_reads(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "::" not in invoke(RUN).stdout
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    lines = invoke(RUN).stdout.splitlines()
    token = lines[0].removeprefix("::stop-commands::")
    assert re.fullmatch("[0-9a-f]{32}", token)
    assert lines[-2] == f"::{token}::"  # from here on GitHub obeys
    assert re.match("PASS: [1-9][0-9]* passed", obeyed(lines[-1])[2])
    assert "::" not in invoke(f"{RUN} --no-annotations").stdout
    done = invoke(f"{RUN} --json -")
    assert json.loads(done.stdout)["summary"]["pass"] > 0
    assert "::notice" in done.stderr


def test_an_engine_cannot_give_github_orders(monkeypatch: pytest.MonkeyPatch) -> None:
    bad = result(verdict="error", error=None, reason="::set-env name=PATH::/tmp")
    monkeypatch.setattr(request, "run_checks", lambda *_: [bad])
    lines = invoke(f"{RUN} --annotations").stdout.splitlines()
    (stop,) = [i for i, line in enumerate(lines) if line.startswith("::stop-commands::")]
    go = lines.index(f"::{lines[stop].rpartition(':')[2]}::")
    orders = [i for i, line in enumerate(lines) if line.lstrip().startswith("::set-env")]
    assert orders
    assert all(stop < i < go for i in orders)


# Workflow files


def loaded(path: Path) -> dict[Any, Any]:
    found: dict[Any, Any] = yaml.safe_load(path.read_text(encoding="utf-8"))
    return found


def steps(path: Path) -> Iterator[dict[str, Any]]:
    for job in loaded(path)["jobs"].values():
        assert job["runs-on"]
        yield from job["steps"]


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.name)
def test_workflows_are_well_formed(path: Path) -> None:
    found = loaded(path)
    assert True in found  # YAML's name for `on`
    for step in steps(path):
        assert ("run" in step) != ("uses" in step), step
        if "run" in step and shutil.which("bash"):
            text = re.sub(r"\$\{\{.*?\}\}", "x", step["run"])
            subprocess.run(["bash", "-n"], input=text, text=True, check=True)
    for job in found["jobs"].values():
        matrix = job.get("strategy", {}).get("matrix", {})
        names = {*matrix, *(name for row in matrix.get("include", ()) for name in row)}
        assert set(re.findall(r"matrix\.(\w+)", json.dumps(job))) <= names
        assert set([job["needs"]] if "needs" in job else []) <= set(found["jobs"])


def commands(path: Path) -> list[str]:
    lines = (line.strip() for step in steps(path) for line in step.get("run", "").splitlines())
    return [line for line in lines if line.startswith("mbcheck ")]


def test_the_workflow_to_copy_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    check, diff = commands(ROOT / "docs" / "workflow.yml")
    Path("mbcheck-known.toml").write_text("")
    small = RUN.partition(" ")[2]
    assert invoke(f"{check.partition(' ')[2]} {small}").exit_code == 0
    os.mkdir("main-branch")
    shutil.copy("new.json", "main-branch")
    assert invoke(diff.partition(" ")[2]).exit_code == 0
    (kept,) = [step for step in steps(ROOT / "docs" / "workflow.yml") if "path" in str(step)]
    assert {name for name in kept["with"]["path"].split() if Path(name).exists()} == {
        "new.json", "report.xml",
    }  # fmt: skip


def test_the_workflow_for_a_model_runs() -> None:
    inspect, *compares = commands(ROOT / "docs" / "model_workflow.yml")
    os.mkdir("main-branch")
    for file in ("robot.xml", "main-branch/robot.xml"):
        assert invoke(f"export hula_hoop -o {file}").exit_code == 0
    Path("intended.toml").write_text("")
    assert invoke(inspect.partition(" ")[2]).exit_code == 0
    with_main, with_release = compares
    assert invoke(with_main.partition(" ")[2]).exit_code == 0
    assert Path("inspect.sarif").exists()
    assert Path("compare.sarif").exists()
    assert with_release.split()[2:] == ["robot.xml", "robot.xml@mujoco==3.6.0", "--install"]


def test_the_matrix_has_what_is_supported() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    jobs = loaded(ROOT / ".github/workflows/test.yml")["jobs"]
    pythons = SpecifierSet(project["requires-python"])
    every = [f"3.{i}" for i in range(40) if f"3.{i}" in pythons]
    assert jobs["test"]["strategy"]["matrix"]["python"] == every
    rows = jobs["engines"]["strategy"]["matrix"]["include"]
    assert [row["age"] for row in rows] == ["oldest", "between", "newest"]
    required = {Requirement(text).name: Requirement(text) for text in project["dependencies"]}
    for engine in ("mujoco", "exudyn"):
        (oldest,) = [item for item in required[engine].specifier if item.operator == ">="]
        assert Version(oldest.version) in SpecifierSet(rows[0][engine])
        assert rows[-1][engine] == str(oldest)


def test_what_is_known_of_older_engines_is_about_checks_that_there_are() -> None:
    every = [name for check in suite.plan() for name in check.ids]
    for entry in known.read(str(ROOT / ".github" / "known.toml")).entries:
        assert fnmatch.filter(every, entry.id), entry.place
    rows = loaded(ROOT / ".github/workflows/test.yml")["jobs"]["engines"]["strategy"]["matrix"]
    assert [row["age"] for row in rows["include"] if "known" in row] == ["oldest"]

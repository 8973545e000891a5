"""Reports: what they count, that hostile text survives, and that documents fit the schemas."""

import io
import json
import math
import re
import shlex
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from mbcheck.comparisons.checks.known import Entry, Use
from mbcheck.comparisons.checks.request import CheckRequest
from mbcheck.comparisons.checks.verdict import Result, Verdict
from mbcheck.comparisons.reports import drawing
from mbcheck.comparisons.reports.run.outcome import Report
from mbcheck.comparisons.reports.run.sections import print_report, run_badge, run_sarif
from mbcheck.comparisons.reports.run.sections import run_junit as junit
from mbcheck.tests.support.documents import results_of_sarif, validated
from mbcheck.tests.support.results import HOSTILE, MIXED, VERSIONS, changed, result


def outcome(
    results: Sequence[Result], versions: Mapping[str, str] = VERSIONS, **run: Any
) -> Report:
    return Report(tuple(results), versions, **run)


# Summary and exit code


def test_summary_counts_every_verdict() -> None:
    counts = outcome(MIXED).summary
    assert counts == {
        "pass": 2, "deviation": 1, "known": 1, "skipped": 2, "error": 1, "total": 7
    }  # fmt: skip


@pytest.mark.parametrize(
    ("verdicts", "code"),
    [
        ([], 2),
        (["skipped"], 2),
        (["pass"], 0),
        (["known", "skipped"], 0),
        (["pass", "deviation"], 1),
        (["error"], 1),
        (["skipped", "error"], 1),
    ],
)
def test_exit_code(verdicts: list[Verdict], code: int) -> None:
    assert outcome([result(verdict=verdict) for verdict in verdicts]).exit_code == code


@pytest.mark.parametrize(
    ("engines", "code"), [((), 0), (("mujoco",), 0), (("mujoco", "exudyn"), 2)]
)
def test_every_engine_that_was_asked_for_must_pass_something(
    engines: tuple[str, ...], code: int
) -> None:
    results = [result("RK4"), result("RK67", "skipped", engine="exudyn")]
    assert outcome(results, selection=CheckRequest(engines=engines)).exit_code == code


# JSON


def test_engine_that_cannot_be_imported_fits_the_schema() -> None:
    blank = changed(
        result(verdict="skipped", reason="exudyn cannot be imported"),
        id="verification/-/-/-/exudyn/-/-", scene="-", case="-", kind="-", engine="exudyn",
        model="-", method=None, quantity="-",
    )  # fmt: skip
    validated("check", outcome([blank], {}).as_json())
    text = printed([blank], 0)
    assert "exudyn cannot be imported" in text
    assert "NOTHING RAN" in text


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_json_has_no_nan(bad: float) -> None:
    failed = replace(result(verdict="error", work={"seconds": math.nan}), value=bad, error=bad)
    document = outcome([failed], VERSIONS).as_json()
    validated("check", document)
    (entry,) = document["results"]
    assert entry["value"] is None
    assert entry["error"] is None
    assert entry["tolerance"] == 2e-6
    assert entry["work"] == {"seconds": None}
    assert f"value was {bad}; error was {bad}" in entry["reason"]


# JUnit


def test_junit_counts() -> None:
    root = ET.fromstring(junit(outcome(MIXED)))
    assert root.tag == "testsuites"
    assert {name: root.get(name) for name in ("tests", "failures", "errors", "skipped")} == {
        "tests": "7", "failures": "1", "errors": "1", "skipped": "3"
    }  # fmt: skip
    assert [suite.get("name") for suite in root] == [
        "hula_hoop/mujoco/trajectory",
        "hula_hoop/exudyn/trajectory",
        "hula_hoop/exudyn/order",
    ]
    for suite in root:
        cases = suite.findall("testcase")
        assert suite.get("tests") == str(len(cases))
        assert suite.get("failures") == str(len(suite.findall("testcase/failure")))
        assert suite.get("errors") == str(len(suite.findall("testcase/error")))
        assert suite.get("skipped") == str(len(suite.findall("testcase/skipped")))
    assert {case.get("name") for case in root.iter("testcase")} == {r.id for r in MIXED}


def test_junit_tells_what_deviates() -> None:
    root = ET.fromstring(junit(outcome(MIXED)))
    (failure,) = root.iter("failure")
    assert failure.get("message") == "error is 25 x its tolerance"
    assert f"mbcheck check --id '{MIXED[2].id}'" in (failure.text or "")
    known = "known deviation: listed; error is 50 x its tolerance"
    assert len(root.findall(f"testsuite/testcase/skipped[@message='{known}']")) == 1
    case = next(case for case in root.iter("testcase") if case.get("name") == MIXED[2].id)
    properties = {item.get("name"): item.get("value") for item in case.iter("property")}
    assert float(properties["error"] or "nan") == 5e-5
    assert {"value", "reference", "error", "tolerance", "unit", "verdict"} <= set(properties)


def test_junit_counts_the_time_of_a_check_once() -> None:
    results = [result(quantity=name, work={"seconds": 0.6}) for name in ("y", "theta", "y_dot")]
    root = ET.fromstring(junit(outcome([*results, result("Euler", work={"seconds": math.inf})])))
    assert float(root.get("time", "")) == pytest.approx(0.6)
    times = [float(case.get("time", "")) for case in root.iter("testcase")]
    assert times == pytest.approx([0.2, 0.2, 0.2, 0.0])


def test_junit_without_results_parses() -> None:
    assert ET.fromstring(junit(outcome([]))).get("tests") == "0"


@pytest.mark.parametrize("verdict", ["pass", "deviation", "known", "skipped", "error"])
def test_hostile_text_survives(verdict: Verdict) -> None:
    nasty = changed(result(verdict=verdict), quantity=HOSTILE, reason=HOSTILE, engine=HOSTILE)
    nasty = changed(nasty, id=f"{nasty.id}{HOSTILE}")
    xml = junit(outcome([nasty])).encode()
    (case,) = ET.fromstring(xml).iter("testcase")
    assert "]]>" in case.get("name", "")
    assert "🦀" in case.get("name", "")
    for verbosity in (-1, 0, 1):
        text = printed([nasty], verbosity, versions={HOSTILE: HOSTILE})
        assert not re.search(r"[\x00-\x09\x0b-\x1f\x7f\ud800-\udfff]", text)
        if verbosity >= 0:
            assert "[bold red]\\[/] ]]>" in " ".join(text.split())
    json.dumps(outcome([nasty], {}).as_json(), allow_nan=False)
    results_of_sarif(run_sarif(outcome([nasty])))


# SARIF


def test_sarif_has_what_failed_and_what_is_stale() -> None:
    stale = Use(Entry(2, "*/RK9/*", "gone"), 0, "stale", "no check has such an id")
    asked = CheckRequest(known="ci/known list.toml")
    made = outcome(MIXED, known=(stale,), selection=asked)
    deviation, error, last = results_of_sarif(run_sarif(made))
    assert [one["ruleId"] for one in (deviation, error, last)] == [
        "trajectory", "order", "stale_known"
    ]  # fmt: skip
    assert [one["level"] for one in (deviation, error, last)] == ["error", "error", "warning"]
    (place,) = deviation["locations"]
    assert place["logicalLocations"] == [{"fullyQualifiedName": MIXED[2].id}]
    assert place["physicalLocation"]["artifactLocation"]["uri"] == "hula_hoop/mujoco/trajectory"
    assert f"mbcheck check --id '{MIXED[2].id}'" in deviation["message"]["text"]
    assert deviation["properties"]["error"] == 5e-5
    assert deviation["properties"]["tolerance"] == 2e-6
    where = last["locations"][0]["physicalLocation"]
    assert where["artifactLocation"]["uri"] == "ci/known%20list.toml"
    asked = replace(asked, strict_known=True)
    strict = results_of_sarif(run_sarif(outcome([MIXED[0]], known=(stale,), selection=asked)))
    assert [one["level"] for one in strict] == ["error"]


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_sarif_has_no_nan(bad: float) -> None:
    (one,) = results_of_sarif(run_sarif(outcome([replace(MIXED[2], error=bad)])))
    assert "error" not in one["properties"]


# Badge


def test_a_badge_says_in_a_word_how_a_run_went() -> None:
    def badge(*results: Result, **run: Any) -> tuple[str, str]:
        made = json.loads(run_badge(outcome(list(results), **run)))
        assert (made.pop("schemaVersion"), made.pop("label")) == (1, "mbcheck")
        return made.pop("message"), made.pop("color")

    assert badge(result()) == ("1 passed", "brightgreen")
    assert badge(*MIXED) == ("2 passed, 1 known, 1 deviation, 1 error", "red")
    assert badge(result(verdict="skipped")) == ("nothing ran", "lightgrey")
    assert badge(result(), interrupted=True) == ("interrupted", "lightgrey")


# Console


def printed(
    results: list[Result],
    verbosity: int,
    versions: dict[str, str] = VERSIONS,
    encoding: str = "utf-8",
    **run: Any,
) -> str:
    """Return what is printed in 80 columns."""
    raw = io.BytesIO()
    log = io.TextIOWrapper(raw, encoding=encoding, newline="\n")
    console = Console(file=log, width=80, color_system=None)
    print_report(console, outcome(results, versions, **run), verbosity)
    log.flush()
    return raw.getvalue().decode(encoding)


def test_quiet_report_is_one_line() -> None:
    assert printed(MIXED, -1) == ("FAIL: 2 passed, 1 deviation, 1 error, 1 known, 2 skipped\n")
    assert printed([], -1) == "NOTHING RAN: 0 passed, 0 deviations, 0 errors\n"


def test_report_begins_with_what_is_wrong() -> None:
    text = printed(MIXED, 0)
    lines = text.splitlines()
    assert lines[:2] == ["Located:", "  mujoco: a free run is wrong"]
    assert f"DEVIATION {MIXED[2].check_id} 1 of 2 quantities" in " ".join(text.split())
    assert re.search(r"^theta +rad +5e-05 +0 +5e-05 +2e-06 +25$", text, re.MULTILINE)
    place = lines.index("  mbcheck check \\")
    assert lines[place + 1] == f"      --id '{MIXED[2].id}'"
    assert f"ERROR {MIXED[6].check_id}" in lines
    assert lines[-1].startswith("FAIL: ")
    assert "mbcheck 0.1.0, mujoco 4.0.0" in lines


def test_matrix_reads_without_colour() -> None:
    text = printed(MIXED, 0)
    assert re.search(r"mujoco +1 of 3 deviate +- *$", text, re.MULTILINE)
    assert re.search(r"exudyn +1 of 1 known +1 of 1 in error *$", text, re.MULTILINE)
    assert re.search(r"mujoco +ok 1 *$", printed([result()], 0), re.MULTILINE)
    assert re.search(r"mujoco +skipped *$", printed([result(verdict="skipped")], 0), re.MULTILINE)


def test_report_groups_reasons_and_names_the_best_method() -> None:
    text = printed(MIXED, 0)
    lines = [line.split() for line in text.splitlines()]
    assert ["exudyn", "tree", "RK44,", "RK33", "2", "no", "such", "model"] in lines
    assert ["exudyn", "tree", "RK67", "1", "listed"] in lines
    assert "hula_hoop mujoco: error of theta 1.23e-06 rad (RK4) to 5e-05 rad (Euler)" in text


def test_verbose_report_has_every_result() -> None:
    text = printed(MIXED, 1)
    rows = [" ".join(line.split()) for line in text.splitlines()]
    assert "hula_hoop/mujoco/trajectory: 1 of 3 deviate" in rows
    case = MIXED[0].case
    assert f"ok {case} RK4 theta 1.23e-06 rad 2e-06 rad 0.617" in rows
    assert f"deviation {case} Euler theta 5e-05 rad 2e-06 rad 25" in rows
    assert f"error {case} RK33 theta" in rows
    assert sum(f" {case} " in row for row in rows) == 7


@pytest.mark.parametrize("verbosity", [-1, 0, 1])
def test_report_fits_a_terminal_of_80_columns(verbosity: int) -> None:
    kinds = ("algebra", "trajectory", "order", "frequency", "stability", "energy")
    results = [
        result("GeneralizedAlpha@redundant", verdict, kind=kind, engine=engine, reason="why " * 60)
        for kind in kinds
        for engine in ("mujoco", "exudyn")
        for verdict in ("pass", "deviation")
        for _ in range(100)
    ]
    assert "\x1b" not in printed(results, verbosity)
    lines = printed(results, verbosity).splitlines()
    assert all(len(line) <= 80 or len(line.split()[-1]) > 70 for line in lines)


def test_report_in_an_old_encoding() -> None:
    assert "1 of 1 deviate" in printed(
        [result(verdict="deviation", reason="σ")], 0, encoding="ascii"
    )


def test_rerun_command_keeps_options_and_quotes() -> None:
    odd = changed(result(verdict="deviation"), id="a/b/c/d/e/f/it's", quantity="it's")
    selection = CheckRequest(full=True, profile="strict", placement="turned:7")
    text = printed([odd], 0, selection=selection).replace("\\\n", " ")
    assert shlex.split(text[text.index("mbcheck check") :].splitlines()[0]) == [
        *["mbcheck", "check", "--placement", "turned:7", "--profile", "strict", "--full", "--id"],
        "a/b/c/d/e/f/it's",
    ]


def test_drawings_are_saved_as_svg(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    drawing.save(drawing.import_pyplot().figure(), tmp_path / "a.svg")
    svg = ET.fromstring((tmp_path / "a.svg").read_text(encoding="utf-8"))
    assert svg.tag.endswith("svg")


def test_an_interrupted_run_passes_nothing() -> None:
    assert outcome([], interrupted=True).summary_line.startswith("INTERRUPTED")

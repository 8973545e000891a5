"""Known deviations: what an entry covers, when it is stale, and every mistake in the file."""

from __future__ import annotations

import fnmatch
import json
import re
import tomllib
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from mbcheck.comparisons.check import request
from mbcheck.comparisons.check.request import check
from mbcheck.comparisons.checks import known, suite
from mbcheck.comparisons.checks.execution import run_checks
from mbcheck.comparisons.checks.known import Entry, Listing
from mbcheck.comparisons.checks.request import Execution
from mbcheck.comparisons.checks.verdict import Result, Verdict
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.faults.catalogue import FAULTS
from mbcheck.reference.errors import UsageError
from mbcheck.tests.support.command import invoke, refusal
from mbcheck.tests.support.documents import validated
from mbcheck.tests.support.results import HOSTILE, changed, result

RUN = "check hula_hoop --engine mujoco --kind frequency -j 1"
WRONG = "verification/hula_hoop/rest_rod_across/frequency/mujoco/tree/undamped_omega_2"
"""What a spring that is 0.1 % too stiff changes, beside others."""

ENTRY = """
[[known]]
id = "*/hula_hoop/*/frequency/mujoco/*"
reason = "the spring is too stiff: issue 12"
"""


pytestmark = pytest.mark.usefixtures("own_folder")


@pytest.fixture
def _wrong_engine(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let MuJoCo's model have a spring that is 0.1 % too stiff."""
    wrong = FAULTS["hula_hoop"]["spring_0.1_percent"].make["mujoco"]()

    def chosen(name: str) -> Any:
        return wrong if name == "mujoco" else get_engine(name)

    monkeypatch.setattr(suite, "get_engine", chosen)


def listing(*entries: Entry) -> Listing:
    return Listing("known.toml", entries)


def file(text: str, name: str = "known.toml") -> str:
    Path(name).write_text(text, encoding="utf-8")
    return name


# Reading


def test_a_file_is_read() -> None:
    text = f"""# ours
{ENTRY}
[[known]]
id = "*/RK4/*"
reason = "ünïcødé 🦀"
max_error = 2
"""
    first, second = known.read(file(text)).entries
    assert (first.number, first.max_error) == (1, None)
    assert second == Entry(2, "*/RK4/*", "ünïcødé 🦀", 2)
    assert known.read(file("")).entries == ()


def test_one_reason_may_hold_for_many_ids() -> None:
    text = """[[known]]
reason = "issue 12"
[known.id]
"*/RK4/*" = 0.5
"*/Euler/*" = inf
"""
    assert known.read(file(text)).entries == (
        Entry(1, "*/RK4/*", "issue 12", 0.5),
        Entry(1, "*/Euler/*", "issue 12", None),
    )


def test_failures_of_one_cause_are_drafted_with_one_reason() -> None:
    failures = [
        *(replace(result(name, "deviation"), cause="exchanged") for name in ("RK4", "Euler")),
        *(result(name, "error", error=None, reason="crashed") for name in ("implicit", "RK4")),
        result("RK67", "deviation", kind="parts", reason="error is 3 x its tolerance; dropped"),
        result("RK44", "deviation", kind="parts", reason="error is 9 x its tolerance; dropped"),
        *(result("RK33", "deviation", quantity=name) for name in ("x", "y")),
    ]
    drafted = tomllib.loads(known.draft(failures))["known"]
    assert [len(item["id"]) for item in drafted] == [2, 2, 2, 2]


ONE = '[[known]]\nid = "a"\n'
MANY = "[[known]]\nreason = 'r'\n[known.id]\n"
BROKEN = [
    ("[[known]\n", "is not TOML"),
    ("[known]\nid = 'a'\n", "two brackets"),
    ("known = 3\n", "two brackets"),
    ("known = ['a']\n", "two brackets"),
    ("[[knwon]]\nid = 'a'\n", "unknown key 'knwon'"),
    (ONE, "entry 1: reason is missing"),
    ("\n[[known]]\nreason = 'r'\n", "entry 1: id is missing"),
    (f"{ONE}reason = ''\n", "reason must be a string with something in it"),
    (f"{ONE}reason = 3\n", "reason must be a string"),
    ("[[known]]\nid = ['a']\nreason = 'r'\n", "id must be a string"),
    (f"{ONE}reason = 'r'\nmax_eror = 1\n", "did you mean 'max_error'?"),
    (f"{ONE}reason = 'r'\nversions = '>4'\n", "unknown key 'versions'"),
    (f"{MANY}'a' = 0\n", "max_error must be a positive number, not 0"),
    (f"{MANY}'' = 1\n", "id must be a string with something in it"),
    ("[[known]]\nmax_error = 2\nreason = 'r'\n[known.id]\n'a' = 1\n", "remove max_error"),
]


@pytest.mark.parametrize(("text", "words"), BROKEN)
def test_a_broken_file_is_one_line(text: str, words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(request, "run_checks", None)  # it must not come to that
    message = refusal(f"{RUN} --known {file(text)}")
    assert message.startswith("Error: --known: 'known.toml'")
    assert words in message


def test_a_file_that_is_not_there() -> None:
    assert refusal(f"{RUN} --known nowhere.toml") == (
        "Error: --known: cannot read 'nowhere.toml': No such file or directory"
    )
    Path("latin.toml").write_bytes(b"# \xff\n")
    assert "is not TOML" in refusal(f"{RUN} --known latin.toml")
    assert "--strict-known needs" in refusal(f"{RUN} --strict-known")


def test_the_example_of_the_page_is_read(clone: Path) -> None:
    page = (clone / "docs" / "ci.md").read_text(encoding="utf-8")
    text = page.partition("```toml\n")[2].partition("```")[0]
    entries = known.read(file(text)).entries
    assert [item.max_error is None for item in entries] == [False, True]
    every = [name for check in suite.plan(full=True) for name in check.ids]
    assert all(fnmatch.filter(every, item.id) for item in entries)


# What an entry covers

DEVIATES = result("RK4", "deviation", reason="error is 25 x its tolerance")
FAILED = result("RK4", "error", error=None, reason="non_finite: y")


@pytest.mark.parametrize(
    ("entry", "covered", "what"),
    [
        (Entry(1, DEVIATES.id, "r"), True, DEVIATES),
        (Entry(1, "*/mujoco/*", "r"), True, DEVIATES),
        (Entry(1, "*/MuJoCo/*", "r"), False, DEVIATES),
        (Entry(1, "mujoco", "r"), False, DEVIATES),
        (Entry(1, "*", "r"), True, FAILED),
        (Entry(1, "*", "r"), False, result("RK4", "pass")),
        (Entry(1, "*", "r"), False, result("RK4", "skipped")),
    ],
)
def test_what_an_entry_covers(entry: Entry, covered: bool, what: Result) -> None:
    settled = listing(entry).settle(what)
    assert settled == (replace(what, verdict="known", known="r") if covered else what)
    assert listing(entry).settle(settled) == settled


def test_the_first_entry_tells_why() -> None:
    both = listing(Entry(1, "*/RK4/*", "first"), Entry(2, "*", "second"))
    assert both.settle(DEVIATES).known == "first"
    assert [use.state for use in uses(both, [both.settle(DEVIATES)])] == ["used", "used"]


def test_an_error_that_grows_and_a_crash_are_news() -> None:
    entry = Entry(1, "*", "issue 7", max_error=0.5)
    small, large = (replace(DEVIATES, error=error) for error in (0.5, 0.6))
    assert listing(entry).settle(small).verdict == "known"
    settled = listing(entry).settle(large)
    assert settled.verdict == "deviation"
    assert settled.reason.startswith("known up to an error of 0.5")
    for crash in (FAILED, replace(FAILED, error=0.1)):
        assert listing(entry).settle(crash).verdict == "error"
    wider = Entry(2, "*", "issue 8", max_error=0.7)
    assert listing(entry, wider).settle(large).known == "issue 8"


# What is stale

IDS = [result(method).id for method in ("RK4", "Euler", "implicit")]
EVERY = [*IDS, result("RK4@other").id]


def uses(found: Listing, results: list[Result]) -> tuple[known.Use, ...]:
    return found.uses(results, lambda: IDS, lambda: EVERY, ["exudyn"])


@pytest.mark.parametrize(
    ("id", "verdicts", "state"),
    [
        ("*/RK4/*", {"RK4": "pass"}, "stale"),
        ("*/RK4/*", {"RK4": "deviation"}, "used"),
        ("*/RK4/*", {"RK4": "error"}, "used"),
        ("*/RK4/*", {"RK4": "skipped"}, "open"),
        ("*/RK4/*", {"Euler": "pass"}, "open"),
        ("*", {"RK4": "pass"}, "open"),
        ("*", {"RK4": "pass", "Euler": "pass", "implicit": "skipped"}, "stale"),
        ("*/RK44/*", {"RK4": "pass"}, "stale"),
        ("*/RK4@other/*", {"RK4": "pass"}, "open"),
        ("*/exudyn/RK67/*", {"RK4": "pass"}, "open"),
        ("*/exudin/*", {"RK4": "pass"}, "stale"),
    ],
)
def test_when_an_entry_is_stale(id: str, verdicts: dict[str, Verdict], state: str) -> None:
    found = listing(Entry(1, id, "r"))
    results = [result(method, verdict) for method, verdict in verdicts.items()]
    (use,) = uses(found, [found.settle(item) for item in results])
    assert use.state == state
    assert use.results == (state == "used")
    assert bool(use.why) == (state != "used")


# For real


def document(line: str) -> tuple[int, dict[str, Any]]:
    """Run a command; return its exit code and its JSON document, which fits the schema."""
    done = invoke(f"{line} --json r.json")
    assert not done.stderr, done.stderr
    found: dict[str, Any] = json.loads(Path("r.json").read_text())
    validated("check", found)
    return done.exit_code, found


@pytest.mark.usefixtures("_wrong_engine")
def test_a_known_deviation_does_not_fail() -> None:
    code, found = document(RUN)
    bad = {item["id"] for item in found["results"] if item["verdict"] == "deviation"}
    assert code == 1
    assert WRONG in bad
    code, found = document(f"{RUN} --known {file(ENTRY)} --strict-known --junit r.xml")
    assert code == 0
    items = {item["id"]: item for item in found["results"] if item["verdict"] == "known"}
    assert set(items) == bad
    assert items[WRONG]["known"] == "the spring is too stiff: issue 12"
    assert "x its tolerance" in items[WRONG]["reason"]
    (entry,) = found["known"]
    assert (entry["state"], entry["results"]) == ("used", len(bad))
    skipped = ET.parse("r.xml").findall(".//skipped")
    assert len(skipped) == len(bad)
    assert all("issue 12" in item.get("message", "") for item in skipped)


def test_an_entry_whose_checks_pass_is_stale() -> None:
    text = file(ENTRY.replace("hula_hoop", "rest_rod_across"))
    code, found = document(f"{RUN} --known {text} --junit r.xml")
    assert code == 0
    assert found["known"][0]["state"] == "stale"
    (message,) = [str(item.get("message")) for item in ET.parse("r.xml").findall(".//skipped")]
    assert message.startswith("stale: known.toml, entry 1, ")
    assert message.endswith(f"{found['known'][0]['why']}; remove it")
    done = invoke(f"{RUN} --known {text} --strict-known --junit r.xml --annotations -q")
    assert done.exit_code == 1
    assert "stale: known.toml, entry 1, '*/rest_rod_across/*" in done.stdout
    assert re.search("FAIL: [0-9]+ passed, 0 deviations, 0 errors, 1 of the known", done.stdout)
    assert "::error file=known.toml,line=1,title=stale known deviation::" in done.stdout
    root = ET.parse("r.xml").getroot()
    assert root.get("failures") == "1"
    assert len(root.findall(".//failure")) == 1


def test_a_filtered_run_does_not_call_stale_what_it_left_out() -> None:
    broad = file(ENTRY.replace("frequency", "*"))
    assert invoke(f"{RUN} --known {broad} --strict-known").exit_code == 0
    slip = file(ENTRY.replace("frequency", "frequencies"))
    done = invoke(f"{RUN} --known {slip} --strict-known")
    assert done.exit_code == 1
    assert "no check has such an id" in " ".join(done.stdout.split())


def test_fail_fast_goes_on_after_a_known_deviation() -> None:
    checks = suite.plan(["hula_hoop"], ["mujoco"], ["frequency"])
    wrong = FAULTS["hula_hoop"]["spring_0.1_percent"].make["mujoco"]()
    original = suite.run_check

    def run(check: Any, profile: str) -> list[Result]:
        return original(check, profile, wrong)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(suite, "run_check", run)
        few = run_checks(checks, execution=Execution(fail_fast=True))
        every = run_checks(
            checks,
            execution=Execution(fail_fast=True),
            settle=listing(Entry(1, "*", "r")).settle,
        )
    assert len(few) < len(every) == sum(len(check.ids) for check in checks)


# Writing


@pytest.mark.usefixtures("_wrong_engine")
def test_a_team_adopts_it() -> None:
    assert invoke(f"{RUN} --write-known new.toml").exit_code == 1
    entries = tomllib.loads(Path("new.toml").read_text())["known"]
    assert entries
    assert all(item["reason"].startswith("TODO") for item in entries)
    assert "the reason is still 'TODO: why does it deviate?'" in refusal(f"{RUN} --known new.toml")
    file(Path("new.toml").read_text().replace(known.TODO, "issue 12"), "new.toml")
    code, found = document(f"{RUN} --known new.toml --strict-known")
    assert code == 0
    assert found["summary"]["known"] > 0
    assert found["summary"]["pass"] > 0
    assert "exists already" in refusal(f"{RUN} --write-known new.toml")


def test_what_is_written_is_read_whatever_it_says() -> None:
    odd = changed(DEVIATES, id=f"a/b[0]/c*/{HOSTILE}\x7f\\/", reason=HOSTILE)
    odd = changed(odd, id=known.plain_line(odd.id))
    error = changed(FAILED, id="x/y/z", reason="'''\"\"\"\nid = 3")
    text = known.draft([odd, error, result("Euler", "pass")]).replace(known.TODO, "issue 12")
    Path("k.toml").write_bytes(text.encode())
    found = known.read("k.toml")
    assert [item.max_error is None for item in found.entries] == [False, True]
    assert found.settle(odd).verdict == "known"
    assert found.settle(error).verdict == "known"
    assert found.settle(changed(odd, id=odd.id.replace("[0]", "0"))).verdict == "deviation"


def test_an_interrupted_run_writes_no_entries(monkeypatch: pytest.MonkeyPatch) -> None:
    def run(checks: Any, *options: Any) -> None:
        on_result: Callable[[list[Result]], None] = options[2]
        on_result([DEVIATES])
        raise KeyboardInterrupt

    monkeypatch.setattr(request, "run_checks", run)
    done = invoke(f"{RUN} --write-known new.toml --json r.json --known {file(ENTRY)}")
    assert done.exit_code == 130
    assert not Path("new.toml").exists()
    found = json.loads(Path("r.json").read_text())
    assert found["checks"]["not_reached"] == found["checks"]["planned"] - 1 > 0
    assert found["known"][0]["state"] == "open"


def test_python_takes_the_file_too() -> None:
    found = check(["hula_hoop"], ["mujoco"], ["frequency"], known=file(ENTRY))
    assert [use.state for use in found.stale] == ["stale"]
    with pytest.raises(UsageError, match="needs a file"):
        check(["hula_hoop"], strict_known=True)


@pytest.mark.parametrize("value", ["-1", "0", "true", "nan", '"1"'])
def test_a_largest_error_is_a_positive_number(value: str) -> None:
    with pytest.raises(UsageError, match="max_error must be a positive number"):
        known.read(file(f'[[known]]\nid = "*"\nreason = "r"\nmax_error = {value}\n'))

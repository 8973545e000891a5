"""What changed between two runs: every sort of change, what is noise, and every mistake."""

from __future__ import annotations

import io
import json
import re
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from mbcheck.comparisons.checks import suite
from mbcheck.comparisons.checks.request import CheckRequest
from mbcheck.comparisons.checks.verdict import Result, Verdict
from mbcheck.comparisons.diff import report as printed
from mbcheck.comparisons.diff.changes import (
    FACTOR,
    REGRESSIONS,
    SHARE,
    SORTS,
    Diff,
    compare,
    read,
)
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.faults.catalogue import FAULTS
from mbcheck.comparisons.reports.run.outcome import Report
from mbcheck.reference.errors import UsageError
from mbcheck.tests.support.command import invoke, refusal
from mbcheck.tests.support.documents import validated
from mbcheck.tests.support.results import HOSTILE, changed, result

VERSIONS = {"mbcheck": "0.1.0", "mujoco": "3.6.0"}
T = 2e-6
"""Tolerance of all results here."""

ANCHOR = result("Euler", quantity="anchor")
"""A result that never changes: something must be there to compare."""


pytestmark = pytest.mark.usefixtures("own_folder")


def write(
    name: str,
    results: list[Result],
    versions: dict[str, str] = VERSIONS,
    planned: int | None = None,
    environment: dict[str, str] | None = None,
    **selection: Any,
) -> str:
    report = Report(
        (ANCHOR, *results),
        versions,
        planned=planned,
        selection=CheckRequest(**selection),
        environment=environment or {"machine": "x86_64"},
    )
    Path(name).write_text(json.dumps(report.as_json()))
    return name


def changes(old: list[Result], new: list[Result], **options: Any) -> Diff:
    before, after = write("old.json", old), write("new.json", new, **options)
    return compare(read(before), read(after))


def one(method: str, verdict: Verdict, error: float | None = 1e-6, **more: Any) -> Result:
    known = "listed" if verdict == "known" else None
    return replace(result(method, verdict, error=error, **more), known=known)


# Sorts of change

VERDICTS: tuple[Verdict, ...] = ("pass", "deviation", "known", "error", "skipped")
BECAME: dict[Verdict, tuple[str | None, ...]] = {
    "pass": (None, "new_deviation", "now_known", "new_error", "now_skipped"),
    "deviation": ("fixed", None, "now_known", "new_error", "now_skipped"),
    "known": ("fixed", "new_deviation", None, "new_error", "now_skipped"),
    "error": ("fixed", "other_failure", "now_known", None, "now_skipped"),
    "skipped": ("now_runs", "new_deviation", "now_known", "new_error", None),
}
"""Verdict that was -> the sort of change to each of `VERDICTS`."""


@pytest.mark.parametrize("old", VERDICTS)
@pytest.mark.parametrize("new", VERDICTS)
def test_every_pair_of_verdicts(old: Verdict, new: Verdict) -> None:
    sort = BECAME[old][VERDICTS.index(new)]
    errors = {"error": None, "skipped": None}
    found = changes(*([one("RK4", word, errors.get(word, 1e-6))] for word in (old, new)))
    assert [change.sort for change in found.changes] == ([sort] if sort else [])
    assert found.compared == 2
    assert found.same == (1 if sort else 2)
    assert found.exit_code == (sort in REGRESSIONS)
    validated("diff", found.as_json())


@pytest.mark.parametrize(
    ("verdict", "sort"),
    [
        ("pass", "appeared"),
        ("known", "appeared"),
        ("skipped", "appeared"),
        ("deviation", "new_deviation"),
        ("error", "new_error"),
    ],
)
def test_ids_that_appear(verdict: Verdict, sort: str) -> None:
    found = changes([], [one("RK4", verdict)])
    assert [change.sort for change in found.changes] == [sort]
    assert found.changes[0].old is None
    validated("diff", found.as_json())


@pytest.mark.parametrize(
    ("options", "sort"),
    [
        ({}, "vanished"),
        ({"scenes": ("hula_hoop",), "kinds": ("trajectory",)}, "vanished"),
        ({"methods": ("RK4", "Euler"), "engines": ("mujoco",)}, "vanished"),
        ({"ids": ("*/RK4/theta", "*/anchor")}, "vanished"),
        ({"ids": ("*/RK4/y", "*/anchor")}, "left_out"),
        ({"scenes": ("rotor_pendulum",)}, "left_out"),
        ({"kinds": ("energy",)}, "left_out"),
        ({"methods": ("Euler",)}, "left_out"),
        ({"engines": ("exudyn",)}, "vanished"),  # the anchor is MuJoCo's: it took part
        ({"planned": 9}, "left_out"),
    ],
)
def test_ids_that_vanish(options: dict[str, Any], sort: str) -> None:
    found = changes([one("RK4", "pass")], [], **options)
    assert [change.sort for change in found.changes] == [sort]
    assert found.exit_code == (sort == "vanished")
    validated("diff", found.as_json())


def test_what_did_not_run_before_is_no_loss() -> None:
    found = changes([one("RK4", "skipped")], [])
    assert [change.sort for change in found.changes] == ["dropped"]
    assert found.exit_code == 0


def test_a_smaller_set_than_before_is_told() -> None:
    old = write("old.json", [one("RK4", "pass")], full=True)
    found = compare(read(old), read(write("new.json", [])))
    assert [change.sort for change in found.changes] == ["left_out"]
    assert "selection: full true -> false" in found.notes


def test_an_engine_that_is_lost_is_a_regression() -> None:
    lost = one("RK67", "pass", engine="exudyn")
    blank = changed(
        result("-", "skipped", kind="-", engine="exudyn", reason="no libGL.so.1"),
        id="verification/-/-/-/exudyn/-/-", scene="-",
    )  # fmt: skip
    found = changes([lost], [blank])
    assert [change.sort for change in found.changes] == ["vanished"]
    assert "engine exudyn is in the old run only" in found.notes
    assert any("could not be imported in the new run: no libGL.so.1" in n for n in found.notes)
    left = changes([lost], [], engines=("mujoco",))
    assert [change.sort for change in left.changes] == ["left_out"]


# Noise


@pytest.mark.parametrize(
    ("old", "new", "sort"),
    [
        (5e-16, 5e-14, None),  # rounding, whatever the factor
        (0.0, SHARE * T, None),
        (0.0, SHARE * T * 1.01, "grew"),
        (0.3 * T, 0.9 * T, "grew"),
        (0.9 * T, 0.3 * T, "shrank"),
        (10 * T, 10 * FACTOR * T, None),
        (10 * T, 10.1 * FACTOR * T, "grew"),
        (10.1 * FACTOR * T, 10 * T, "shrank"),
        (1e-6, 1e-6, None),
    ],
)
@pytest.mark.parametrize("verdict", ["pass", "known", "deviation"])
def test_what_is_noise(old: float, new: float, sort: str | None, verdict: Verdict) -> None:
    found = changes([one("RK4", verdict, old)], [one("RK4", verdict, new)])
    assert [change.sort for change in found.changes] == ([sort] if sort else [])
    assert found.exit_code == (sort == "grew")


def test_what_matters_most_comes_first() -> None:
    old = [one(name, "pass", 1e-7) for name in ("a", "b", "c", "d", "e", "f")]
    old.append(one("g", "pass", 4e-7))
    new = [
        one("a", "pass", 1.9e-6),
        one("g", "pass", 1.9e-6),  # as near to its tolerance, which it was nearer to before
        one("b", "deviation", 1e-5),
        one("c", "deviation", 1e-3),
        one("d", "skipped"),
        one("e", "error", None),
    ]
    found = changes(old, new)
    order = [(change.sort, change.result.method) for change in found.changes]
    assert order == [
        ("new_error", "e"),
        ("new_deviation", "c"),
        ("new_deviation", "b"),
        ("grew", "a"),
        ("grew", "g"),
        ("vanished", "f"),
        ("now_skipped", "d"),
    ]


# What a reader sees


def text_of(found: Diff, verbose: bool = False) -> str:
    raw = io.StringIO()
    printed.print_diff(Console(file=raw, width=80), found, verbose)
    return raw.getvalue()


def test_hundreds_of_changes_fit_on_a_screen() -> None:
    kinds = ("algebra", "trajectory", "order", "frequency", "stability", "energy")
    ids = [
        (f"m{i}", kind, engine)
        for i in range(50)
        for kind in kinds
        for engine in ("mujoco", "exudyn")
    ]
    old = [one(m, "pass", 1e-6, kind=k, engine=e) for m, k, e in ids]
    new = [one(m, "deviation", 1e-4, kind=k, engine=e) for m, k, e in ids]
    worst = one("m7", "deviation", 1e-2, kind="order")
    new = [worst if item.id == worst.id else item for item in new]
    found = changes(old, new)
    lines = text_of(found).splitlines()
    assert len(lines) < 40
    assert "new deviations (600)" in lines
    assert "  mujoco order: 50 in hula_hoop (50)" in lines
    assert f"    worst: {worst.id}" in lines
    assert lines[-1] == "REGRESSED: 600 new deviations; 1 of 601 the same"
    every = text_of(found, verbose=True)
    assert all(item.id in every for item in new)
    assert len(printed.markdown(found)) < 100_000


def test_hostile_text_survives() -> None:
    odd = changed(one("RK4", "pass"), quantity=HOSTILE, engine=HOSTILE, scene=HOSTILE)
    odd = changed(odd, id=odd.id + HOSTILE.encode("utf-8", "replace").decode())
    bad = replace(odd, verdict="deviation", reason=HOSTILE)
    found = changes([odd], [bad], versions={HOSTILE: HOSTILE})
    assert not re.search(r"[\x00-\x09\x0b-\x1f\x7f\ud800-\udfff]", text_of(found))
    assert "<a b" not in printed.markdown(found)


def test_the_runs_are_described() -> None:
    old = write("old.json", [], environment={"machine": "x86_64", "libc": "glibc 2.36"})
    new = write("new.json", [], VERSIONS | {"mujoco": "4.0.0"}, environment={"machine": "arm64"})
    found = compare(read(old), read(new))
    assert found.notes[:3] == (
        "mujoco: 3.6.0 -> 4.0.0", "machine: x86_64 -> arm64", "libc: glibc 2.36 -> none",
    )  # fmt: skip
    assert "old old.json: 1 result; mbcheck 0.1.0, mujoco 3.6.0" in text_of(found)


# The verb


def test_the_same_file_twice() -> None:
    old = write("old.json", [one("RK4", "deviation"), one("RK3", "error", None)])
    done = invoke(f"diff {old} {old}")
    assert done.exit_code == 0
    assert done.stdout.splitlines()[-1] == "NO CHANGE: 3 results, the same in both"


def test_a_wrong_engine_is_a_regression(monkeypatch: pytest.MonkeyPatch) -> None:
    check = "check hula_hoop --engine mujoco --kind frequency -q -j 1"
    assert invoke(f"{check} --json old.json").exit_code == 0
    wrong = FAULTS["hula_hoop"]["spring_0.1_percent"].make["mujoco"]()
    monkeypatch.setattr(
        suite, "get_engine", lambda name: wrong if name == "mujoco" else get_engine(name)
    )
    assert invoke(f"{check} --json new.json").exit_code == 1
    done = invoke("diff old.json new.json --json diff.json --markdown diff.md")
    assert done.exit_code == 1
    assert done.stdout.splitlines()[-1].startswith("REGRESSED: ")
    found = json.loads(Path("diff.json").read_text())
    validated("diff", found)
    assert found["regressions"] == found["summary"]["new_deviation"] > 0
    assert {"frequency"} <= {item["new"]["kind"] for item in found["changes"]}
    assert "### new deviations" in Path("diff.md").read_text()
    back = invoke("diff new.json old.json")
    assert back.exit_code == 0
    assert "NO REGRESSION" in back.stdout
    assert "fixed" in back.stdout


def test_standard_output_is_pure() -> None:
    old = write("old.json", [])
    done = invoke(f"diff {old} {old} --json -")
    validated("diff", json.loads(done.stdout))
    assert invoke(f"diff {old} {old} --markdown -").stdout.startswith("## mbcheck diff: NO CHANGE")


def test_a_document_of_an_earlier_release() -> None:
    found = json.loads(Path(write("new.json", [one("RK4", "pass")])).read_text())
    del found["selection"]["extremes"]
    for item in found["results"]:
        del item["noticed_by"]
    Path("old.json").write_text(json.dumps(found))
    assert invoke("diff old.json new.json").exit_code == 0


GOOD = Report((ANCHOR,), VERSIONS).as_json()


def spoiled(**changed: Any) -> str:
    found = deepcopy(GOOD)
    for name, value in changed.items():
        found["results"][0][name] = value
    return json.dumps(found)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is not JSON"),
        ("{", "is not JSON"),
        ("[" * 100_000, "is not JSON"),
        ("\xff", "is not JSON"),
        (json.dumps(GOOD)[:-1] + ', "x": NaN}', "NaN is no JSON"),
        ("[]", "is no document of mbcheck"),
        ("{}", "is no document of mbcheck"),
        (json.dumps(GOOD | {"schema": 1}), "has schema 1; this mbcheck reads schema 2"),
        ('{"schema": 2}', "is not what `mbcheck check --json` writes"),
        (json.dumps(GOOD | {"results": [3]}), "is not what"),
        (json.dumps(GOOD | {"versions": []}), "is not what"),
        (json.dumps(GOOD | {"results": GOOD["results"] * 2}), "stands twice"),
        (json.dumps(GOOD | {"results": []}), "nothing to compare"),
        (spoiled(verdict="passed"), "Invalid enum value 'passed'"),
        (spoiled(verdict=[]), "is not what"),
        (spoiled(error="small"), "is not what"),
        (spoiled(id=3), "Expected `str`, got `int`"),
    ],
)
def test_what_cannot_be_read(text: str, words: str) -> None:
    Path("bad.json").write_text(text, encoding="latin-1")
    good = write("good.json", [])
    for line in (f"diff bad.json {good}", f"diff {good} bad.json"):
        assert words in refusal(line)


def mutants(found: Any) -> Iterator[Any]:
    """Yield a document with each of its values in turn replaced by those of other types."""

    def places(value: Any, path: tuple[Any, ...]) -> Iterator[tuple[Any, ...]]:
        items = value.items() if isinstance(value, dict) else enumerate(value)
        for key, item in items:
            yield (*path, key)
            if isinstance(item, dict | list):
                yield from places(item, (*path, key))

    for path in places(found, ()):
        for other in (None, 5, "x", [3], {"a": 3}, 10**400):
            changed = deepcopy(found)
            item = changed
            for key in path[:-1]:
                item = item[key]
            item[path[-1]] = other
            yield changed


def test_a_diff_of_documents_with_wrong_types() -> None:
    """Each is compared, or refused in one line."""
    asked = CheckRequest(["hula_hoop"], ids=["*"])
    full = Report((ANCHOR,), VERSIONS, planned=1, selection=asked).as_json()
    Path("good.json").write_text(json.dumps(full))
    refused = 0
    for document in mutants(full):
        Path("other.json").write_text(json.dumps(document))
        for names in (("good.json", "other.json"), ("other.json", "good.json")):
            try:
                result = compare(*map(read, names))
                printed.markdown(result)
                json.dumps(result.as_json())
            except UsageError:
                refused += 1
    assert refused > 100


def test_other_misuse() -> None:
    good = write("good.json", [])
    assert "No such file" in refusal(f"diff {good} nowhere.json")
    assert "it is a folder" in refusal(f"diff {good} .")
    assert "NEW.json" in refusal(f"diff {good}")
    assert "both go to" in refusal(f"diff {good} {good} --json - --markdown -")


def test_nothing_to_compare() -> None:
    Path("other.json").write_text(json.dumps(Report((one("RK4", "pass"),), VERSIONS).as_json()))
    assert "no result in common" in refusal(f"diff {write('old.json', [])} other.json")
    with pytest.raises(UsageError, match="nothing to compare"):
        compare(read("old.json"), read("other.json"))


def test_the_page_tells_every_sort(clone: Path) -> None:
    page = (clone / "docs" / "ci.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(\w+)` \| (yes)? *\|", page, re.MULTILINE)
    told = [(name, bool(yes)) for name, yes in rows if name in SORTS]
    assert told == [(name, name in REGRESSIONS) for name in SORTS]

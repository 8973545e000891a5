"""What failed, check by check: a cause once, the first level first, ten of them."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import replace

import pytest

from mbcheck.comparisons.reports.run.located import blocks, located
from mbcheck.comparisons.reports.run.outcome import Report
from mbcheck.comparisons.reports.run.sections import MOST
from mbcheck.comparisons.reports.run.sections import run_junit as junit
from mbcheck.tests.support.results import MIXED, changed, result


def test_quantities_of_a_check_stand_together() -> None:
    (one,) = blocks(
        [
            replace(result(verdict="deviation", error=1.0), quantity="extrapolated", unit="1"),
            result(verdict="deviation", error=1e-5),
            result(quantity="y"),
        ]
    )
    assert [item.quantity for item in one.failed] == ["theta", "extrapolated"]
    assert one.title == f"DEVIATION {one.worst.check_id}  2 of 3 quantities"
    assert [row[0].strip() for row in one.rows] == ["theta", "extrapolated"]


def test_the_first_level_that_is_wrong_comes_first() -> None:
    late = result("A", "error", kind="stability", error=None)
    early = result("B", "deviation", kind="algebra")
    assert [one.worst.kind for one in blocks([late, early])] == ["algebra", "stability"]


def test_the_same_cause_is_told_once() -> None:
    causes = [
        replace(result(f"m{i}", "deviation", error=1e-5 * (i + 1)), cause="gravity is lost")
        for i in range(5)
    ]
    raised = [result(f"e{i}", "error", error=None, reason="KeyError: 'foot'") for i in range(3)]
    other = result("x", "deviation")
    found = blocks([*causes, *raised, other])
    assert [len(one.alike) for one in found] == [2, 4, 0]
    assert found[1].worst.method == "m4"
    assert found[1].reasons[-1].startswith("the same in 4 more checks: ")


def test_ten_are_shown_and_all_with_v() -> None:
    many = Report(tuple(result(f"m{i}", "deviation") for i in range(14)), {})
    text = many.text()
    assert text.startswith("Located:\n")
    assert text.count("DEVIATION ") == MOST
    assert "and 4 more checks with other failures: -v shows them" in text
    assert many.text(1).count("DEVIATION ") == 14


def test_junit_tells_where_it_is_wrong() -> None:
    suites = ET.fromstring(junit(Report(tuple(MIXED), {})).encode()).iter("testsuite")
    said = {suite.get("name"): suite.findtext("system-out") for suite in suites}
    assert said["hula_hoop/mujoco/trajectory"] == (
        "Located:\nmujoco: a free run is wrong\n  Euler theta off by 5e-05 rad (hula_hoop)"
    )
    assert said["hula_hoop/exudyn/trajectory"] is None


@pytest.mark.parametrize(
    ("reason", "told"),
    [("mine has no accelerations(...)", True), ("a step leaves less than is known", False)],
)
def test_who_gives_no_accelerations_is_told_what_they_would_tell(reason: str, told: bool) -> None:
    wrong = result(verdict="deviation", engine="mine", kind="step")
    other = result(verdict="deviation", kind="step")
    without = result(verdict="skipped", engine="mine", kind="algebra", reason=reason)
    hint = "  its accelerations would show which part of the model: docs/engines.md"
    lines = located([wrong, without, other])
    assert (hint in lines) == told
    assert not told or lines.index(hint) == 2
    assert hint not in located([changed(wrong, cause="damper of y: counted 0.99 times"), without])
    raised = result(verdict="error", engine="mine", kind="step", reason="KeyError: 'foot'")
    assert hint not in located([raised, without, other])


def test_forces_beyond_the_parts_are_not_called_unexplained_beside_their_cause() -> None:
    said = "a damper of 0.3 N m s/rad on theta, which the file does not have"
    reason = f"error is 9 x its tolerance; {said}"
    (one,) = blocks(
        [result(verdict="deviation", kind="parts", quantity="unexplained", reason=reason)]
    )
    assert one.rows[0][0] == "unexplained by shares"
    assert one.reasons == [said]

"""The comparisons as tests: what ``mbcheck check`` runs, one test for each check."""

from __future__ import annotations

import pytest

from mbcheck.comparisons.suite import Check, plan, run_check

BAD = ("deviation", "error")


@pytest.mark.parametrize("check", plan(), ids=lambda check: check.prefix)
def test_check(check: Check) -> None:
    if check.why_not:
        pytest.skip(check.why_not)
    results = run_check(check)
    assert len(results) == len(check.quantities)
    failures = [f"{item.id}: {item.reason}" for item in results if item.verdict in BAD]
    assert not failures, "\n".join(failures)
    if all(item.verdict == "skipped" for item in results):
        pytest.skip(results[0].reason)

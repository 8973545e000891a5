"""`check` as a function: its report, its progress, and what it refuses."""

from typing import Any

import pytest

import mbcheck
from mbcheck.comparisons.checks import execution, suite
from mbcheck.comparisons.engines import registry as engines
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.reference.errors import EngineUnavailableError
from mbcheck.tests.support.documents import validated


def test_check() -> None:
    seen: list[tuple[int, int, int]] = []
    report = mbcheck.check(
        engines=["mujoco"],
        kinds=["frequency"],
        progress=lambda done, total, results: seen.append((done, total, len(results))),
    )
    document = validated("check", report.as_json())
    assert document["summary"] == report.summary
    assert report.summary["total"] == sum(n for _, _, n in seen)
    assert report.summary["pass"] == report.summary["total"] - report.summary["skipped"] > 0
    assert [done for done, _, _ in seen] == list(range(1, seen[0][1] + 1))
    assert report.exit_code == 0
    assert "exudyn" not in report.versions


def test_an_engine_not_asked_for_may_be_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    def without_exudyn(name: str) -> Any:
        if name == "exudyn":
            raise EngineUnavailableError("exudyn cannot be imported; install libgl1")
        return get_engine(name)

    for module in (engines, execution, suite):
        monkeypatch.setattr(module, "get_engine", without_exudyn)
    monkeypatch.setattr(execution, "installed", lambda name: False)
    report = mbcheck.check(kinds=["frequency"])
    missing = [item for item in report.results if "libgl1" in item.reason]
    assert [(item.engine, item.verdict) for item in missing] == [("exudyn", "skipped")]
    assert report.exit_code == 0
    validated("check", report.as_json())
    with pytest.raises(EngineUnavailableError, match="libgl1"):
        mbcheck.check(engines=["exudyn"])

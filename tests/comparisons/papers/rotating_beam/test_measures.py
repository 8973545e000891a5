"""What rows of the rotating_beam paper are made of, and that they can fail."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.engines.registry import REFERENCE
from mbcheck.comparisons.papers.assess import assess
from mbcheck.comparisons.papers.ledger import NOT_REPRODUCED, REPRODUCED, statement
from mbcheck.comparisons.papers.rotating_beam import frequencies, responses, results
from mbcheck.comparisons.papers.rotating_beam.rows import ROWS
from mbcheck.comparisons.papers.session import Session
from mbcheck.reference.errors import EngineError

BY_NAME = {row.name: row for row in ROWS}


@pytest.mark.slow
def test_responses_are_those_that_were_measured(with_engines: Session) -> None:
    peaks, own = (
        responses.by_mass(with_engines, who, 4, results.peak) for who in (REFERENCE, "exudyn")
    )
    np.testing.assert_allclose(peaks, [1.083, 1.864, 2.456, 3.332], atol=6e-4)
    np.testing.assert_allclose(own, peaks, rtol=1e-3)


def test_wrong_roots_are_not_reproduced(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(frequencies, "rest_roots", lambda count: np.arange(count) + 2.0)
    assert assess(BY_NAME["asymptote"], Session()).verdict == NOT_REPRODUCED
    wrong = replace(BY_NAME["root_2"], printed="4.695")
    assert assess(wrong, Session()).verdict == NOT_REPRODUCED


def test_an_engine_that_fails_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*args: Any, **more: Any) -> Any:
        raise EngineError("clock", "went back")

    monkeypatch.setattr(results, "simulate", fails)
    job = results.Job(5, 0.4, "exudyn", 1.0, 4)
    failure = results.simulated(job)
    assert isinstance(failure, str)
    session = Session(engines=("exudyn",))
    still = results.Response(np.zeros(1), {"theta": np.zeros(1)})
    for who, motion in (("exudyn", failure), (REFERENCE, still)):
        session.cache["rotating_beam", "runs", 5, who] = {0.4: motion}
    row = statement(
        "a", "1", "a", REPRODUCED,
        each=lambda session, who: len(results.response(session, 5, who, 0.4).times),
    )  # fmt: skip
    assert "went back" in assess(row, session).engines["exudyn"]


def test_maximum_of_a_curve() -> None:
    at = np.linspace(0.1, 1.0, 16)
    assert results.maximum(at, -((at - 0.4217) ** 2)) == pytest.approx(0.4217)
    assert results.maximum(at, at) == 1.0

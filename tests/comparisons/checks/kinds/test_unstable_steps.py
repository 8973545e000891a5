"""Explicit methods are not run at default steps that a rule calls unstable."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.checks.free_vibrations import stable_step
from mbcheck.comparisons.checks.refusals import refuse_unstable
from mbcheck.comparisons.checks.suite import plan
from mbcheck.comparisons.checks.table import KINDS
from mbcheck.comparisons.checks.truth import truth
from mbcheck.comparisons.engines.adapter import adapt
from mbcheck.comparisons.engines.setup import Setup, power_of_two, run
from mbcheck.reference import get_scene
from mbcheck.reference.errors import CannotJudgeError, EngineError
from mbcheck.tests.support.campaigns.seeded import Plugged
from mbcheck.tests.support.example import results

EULER = mbcheck.Method("Euler", 1, "ExplicitEuler")
MIDPOINT = mbcheck.Method("midpoint", 2, "ExplicitMidpoint")
CASE = get_scene("rotating_beam").case("spin_up_quick")


class Explicit(Plugged):
    """MuJoCo's accelerations, integrated by an explicit method of its own."""

    def __init__(self, *methods: mbcheck.Method) -> None:
        super().__init__()
        self.methods = methods

    def simulate(self, system: Any, method: Any, step: float, times: Any) -> Any:
        """Integrate from sample to sample."""
        q, v, steps, rows = system.positions, system.velocities, 0, []
        for time in times:
            while system.start_time + (steps + 0.5) * step < time:
                now = system.start_time + steps * step
                a, half, rate = self.accelerations(system, now, q, v), step / 2, v
                if method.order == 2:
                    rate = v + half * a
                    a = self.accelerations(system, now + half, q + half * v, rate)
                q, v, steps = q + step * rate, v + step * a, steps + 1
            rows.append((q, v))
        positions, velocities = (np.array(row) for row in zip(*rows, strict=True))
        return mbcheck.Motion(positions, velocities, steps=steps)


@pytest.mark.parametrize("kind", [name for name, kind in KINDS.items() if kind.refuse])
def test_such_runs_are_skipped_with_the_step_that_would_do(kind: str) -> None:
    names = {"energy": "pulse_quick", "stability": "above_critical"}
    found = results(Explicit(EULER), "rotating_beam", (kind,), names.get(kind, CASE.name))
    assert found
    assert {item.verdict for item in found} == {"skipped"}
    for item in found:
        assert item.reason.startswith("not run with its default step; rule step_limit: a step of")
        assert "; take at most " in item.reason


def test_that_step_does_and_the_default_does_not() -> None:
    case = replace(CASE, horizon=0.5)
    engine = adapt("unstable:Explicit", Explicit(EULER))
    setup = Setup(engine, case, engine.models("rotating_beam")[0], EULER)
    limit = stable_step(setup, case.horizon)
    assert limit is not None
    with pytest.raises(CannotJudgeError, match=f"take at most {limit.step:.3g} s"):
        refuse_unstable(setup)
    samples = np.array([case.horizon])
    with pytest.raises(EngineError, match="the run is unstable"), np.errstate(all="ignore"):
        run(setup, samples)
    right = truth(setup.bound.equations, case, samples, setup.bound.observables)
    shorter = setup.with_step(power_of_two(limit.step))
    refuse_unstable(shorter)
    off = np.abs(run(shorter, samples).matrix(setup.bound.observables) - right.values)
    assert np.max(off / right.size[:, None]) < 0.05


def test_what_grows_and_stays_small_is_judged() -> None:
    found = results(Explicit(MIDPOINT), "rotating_beam", ("energy",), "pulse_quick")
    assert {item.verdict for item in found} == {"pass"}


def test_no_engine_that_comes_with_mbcheck_is_concerned() -> None:
    for check in plan(["rotating_beam"], kinds=["trajectory", "energy", "stability"], full=True):
        if check.unsupported_reason is None:
            refuse_unstable(check.setup())

"""Remainder steps are noted; engines that take other steps are caught."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.engines.adapter import adapt
from mbcheck.comparisons.engines.run import noting
from mbcheck.comparisons.engines.setup import Setup, off_grid_times, run
from mbcheck.reference import get_scene
from mbcheck.reference.errors import EngineError
from mbcheck.reference.solve import schemes
from mbcheck.tests.support.engines.solved import STAGES, Solved
from mbcheck.tests.support.example import results

STEP = 0.1 / 64  # which no clock can add up without rounding
METHOD = mbcheck.Method("ExplicitMidpoint", 2, evaluations_per_step=2)


class Stopping(Solved):
    """Goes to each time that is asked for as a simulator does that adds up its clock.

    Attributes
    ----------
    parts : int
        Of each step.
    more : int
        Steps more than there should be between two samples, all of them shorter for it.
    """

    def __init__(self, parts: int = 1, more: int = 0, work: bool = False) -> None:
        super().__init__(METHOD, "ExplicitMidpoint")
        self.parts, self.more, self.work = parts, more, work

    def simulate(self, system: Any, method: Any, step: float, times: Any) -> mbcheck.Motion:
        """Integrate, and count every step that is taken, remainder steps too."""
        scene, n = get_scene(system.case.scene), len(system.joints)
        equations = schemes.ScalarEquations(scene, self.change(system.case.parameters))
        state = np.concatenate([system.positions, system.velocities])
        now, steps, rows = system.start_time, 0, []
        for time in times:
            count = max(1, round((time - now) / step))
            h = step * count / (self.parts * count + self.more)
            while now < time:
                size = h if now + h <= time else time - now
                state = schemes.integrate(equations, self.scheme, state, size, np.array([1]), now)[
                    :, 0
                ]
                steps, now = steps + 1, now + size
            rows.append(state)
        q, v = np.split(np.array(rows), [n], axis=1)
        told = steps * STAGES[self.scheme] if self.work else None
        return mbcheck.Motion(q, v, times, None if self.work else steps, rhs_evaluations=told)


def setup_of(engine: Stopping, step: float = STEP, start: float = 0.0) -> Setup:
    """Return a run of hula_hoop."""
    case = replace(get_scene("hula_hoop").case("spinning_3hz_60n"), start_time=start)
    return Setup(adapt("remainders:Stopping", engine), case, "scene", METHOD, step)


def outcome(engine: Stopping, samples: Any, step: float = STEP, start: float = 0.0) -> Any:
    """Return the kind of error of a run, or what is noted of it."""
    with noting() as notes:
        try:
            run(setup_of(engine, step, start), start + step * np.asarray(samples))
        except EngineError as error:
            return error.kind
    return list(notes)


@pytest.mark.parametrize("work", [False, True])
@pytest.mark.parametrize("every", [1, 7, 32])
def test_remainder_steps_are_noted(every: int, work: bool) -> None:
    samples = np.arange(every, 225, every)
    assert off_grid_times(setup_of(Stopping()), STEP * samples)
    said = outcome(Stopping(work=work), samples)
    # a sample may cost an evaluation anyway, which leaves room for few remainder steps
    assert said == [] if work and every != 7 else "remainder steps" in said[0]


def test_a_remainder_of_a_single_step_is_noted() -> None:
    def misses(start: float) -> int:
        setup = setup_of(Stopping(), start=start)
        return off_grid_times(setup, np.array([start + STEP]))

    assert outcome(Stopping(), [1], start=next(n / 7 for n in range(99) if not misses(n / 7))) == []
    with noting() as notes:  # of a time that lies an ulp after the clock
        run(setup_of(Stopping()), np.array([np.nextafter(STEP, 1)]))
    assert list(notes)


def test_nothing_is_said_where_no_clock_rounds() -> None:
    assert outcome(Stopping(), np.arange(1, 65), step=2.0**-9) == []


OTHERS = {
    "halved": Stopping(parts=2),
    "one more from sample to sample": Stopping(more=1),
    "thirds": Stopping(parts=3),
}


@pytest.mark.parametrize("every", [1, 2, 32])
@pytest.mark.parametrize("step", [STEP, 2.0**-9])
@pytest.mark.parametrize("engine", OTHERS.values(), ids=OTHERS)
def test_other_steps_are_an_error(engine: Stopping, step: float, every: int) -> None:
    assert outcome(engine, np.arange(every, 225, every), step) == "step_count"


def test_halved_steps_are_an_error_by_their_work_too() -> None:
    assert outcome(Stopping(parts=2, work=True), np.arange(1, 65)) == "work_count"


def test_a_check_passes_and_tells_of_remainder_steps() -> None:
    found = results(Stopping(), "hula_hoop", ("stability",), "point_mass_3hz_60n")
    assert found
    assert {item.verdict for item in found} == {"pass"}
    assert any("note: the engine counts remainder steps" in item.reason for item in found)

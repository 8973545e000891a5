"""Many cases of a scene: each has the result that it has alone, and a failure is its own."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.engines.setup import Setup, run, run_many
from mbcheck.reference import get_scene
from mbcheck.reference.errors import EngineError, UsageError
from mbcheck.reference.scene import Array, Case

NUMBERS = np.array([1, 7, 40])


def cases_of(scene: str, name: str, **values: tuple[float, ...]) -> list[Case]:
    """Return the case with each of some values of a parameter."""
    case = get_scene(scene).case(name)
    ((parameter, each),) = values.items()
    return [replace(case, parameters=case.parameters.replace(**{parameter: one})) for one in each]


def many(setup: Setup, cases: list[Case], steps: Array) -> list[Any]:
    """Return the results of some cases together, each of which is what it is alone."""
    starts = np.array([case.start_time for case in cases])
    times = starts[:, None] + steps[:, None] * NUMBERS
    found = run_many(setup, cases, steps, times)
    for case, step, grid, result in zip(cases, steps.tolist(), times, found, strict=True):
        here = replace(setup, case=case, step=step)
        if isinstance(result, EngineError):
            with pytest.raises(EngineError, match=re.escape(result.message)):
                run(here, grid)
        else:
            names = tuple(result.values)
            assert np.array_equal(result.matrix(names), run(here, grid).matrix(names))
    return found


@pytest.mark.parametrize("engine", ["mujoco", "exudyn"])
def test_each_case_has_its_own_parameters_and_step(engine: str) -> None:
    cases = cases_of("hula_hoop", "spinning_3hz_60n", main_mass=(0.3, 0.5, 0.9))
    adapter = get_engine(engine)
    method = next(one for one in adapter.methods if one.order == 4)
    setup = Setup(adapter, cases[0], adapter.models("hula_hoop")[0], method)
    found = many(setup, cases, np.array([1e-3, 2e-3, 5e-4]))
    assert len({float(one.values["theta"][-1]) for one in found}) == 3


def test_what_fails_fails_alone() -> None:
    cases = cases_of("hula_hoop", "spinning_3hz_60n", stiffness=(1000.0, 1053.0, 900.0))
    setup = Setup(get_engine("mujoco"), cases[0], "tree", get_engine("mujoco").methods[0])
    found = many(setup, cases, np.array([1e-3, 10.0, 1e-3]))
    assert [isinstance(one, EngineError) for one in found] == [False, True, False]
    assert run_many(setup, [], np.empty(0), np.empty((0, 3))) == []
    with pytest.raises(UsageError, match="grid"):
        run_many(setup, cases[:1], np.array([1e-3]), np.array([[0.0015]]))


def test_a_step_that_softens_the_closure_is_refused_alone() -> None:
    cases = cases_of("speed_regulator", "rotation", torque=(1.0, 2.0))
    adapter = get_engine("mujoco")
    setup = Setup(adapter, cases[0], "connect", adapter.methods[0])
    longest = adapter.bind(cases[0], "connect").source.longest_step
    first, second = many(setup, cases, np.array([longest / 4, longest * 1.01]))
    assert not isinstance(first, EngineError)
    assert second.kind == "step"

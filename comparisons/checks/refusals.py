"""What is not checked, through no fault of an engine: default steps too long, drives not taken."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...reference.errors import CannotJudgeError, MbcheckError
from ...reference.scene import Array
from ..engines.run import call_engine
from ..engines.setup import Setup
from .free_vibrations import drowns
from .rules.cautions import RULES, cautions, explained

UNDRIVEN = 8
"""Steps in which a drive would be seen."""


def refuse_undriven(setup: Setup) -> None:
    """Refuse an engine that has no part of a force that stands in no file.

    Raises
    ------
    CannotJudgeError
        If it moves as without the drive, to the last digit.
    """
    case = setup.case
    still = replace(case, parameters=setup.scene.unforced(case.parameters))
    steps = np.arange(1, UNDRIVEN + 1)

    def seen(one: Setup) -> Array:
        if setup.method is None:
            step = float(setup.scene.period(case.parameters)) / (2 * UNDRIVEN)
            times = np.asarray(case.start_time + step * steps, dtype=float)
            states: Array = np.zeros((UNDRIVEN, 2 * len(setup.coordinates)))
            ask = one.engine.accelerations
            return call_engine(lambda: ask(one.case, one.model, times, states))
        return one.simulate(setup.default_step, steps).matrix(setup.scene.observables)

    if np.array_equal(seen(setup), seen(setup.with_case(still))):
        raise CannotJudgeError(
            "it moves as without the drive, a force in time that stands in system.force(...) and "
            "system.controls(...), and in no file; see docs/engines.md"
        )


def refuse_unstable(setup: Setup) -> None:
    """Refuse a run whose default step, which is our choice, makes rounding as large as the motion.

    Raises
    ------
    CannotJudgeError
        With what the rule says, and the step that would do.
    """
    horizon = setup.case.horizon
    try:
        if setup.method is None or not drowns(setup, horizon):
            return
        said = cautions(setup, horizon, {"step_limit": RULES["step_limit"]})
    except MbcheckError:  # the run itself will tell
        return
    raise CannotJudgeError(explained("not run with its default step", said))

"""Checks that are skipped: unstable default steps, engines without forces in time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...reference.errors import CannotJudgeError, EngineError, MbcheckError
from ...reference.scene import Array
from ..engines.run import call_engine
from ..engines.setup import Setup
from .free_vibrations import drowns
from .kinds import algebra
from .rules.cautions import RULES, cautions, explained
from .truth import roundoff_reference
from .verdict import Finding

UNDRIVEN = 8
"""Steps within which a drive shows."""


def refuse_undriven(setup: Setup) -> None:
    """Refuse an engine that ignores a force in time, which is in no file.

    Raises
    ------
    CannotJudgeError
        If it moves as without the drive, to the last digit.
    EngineError
        ``drive``, if it moves alike with and without the drive, but not as without.
    """
    case = setup.case
    still = replace(case, parameters=setup.scene.unforced(case.parameters))
    steps = np.arange(1, UNDRIVEN + 1)

    def seen(one: Setup) -> Array:
        if setup.method is None:
            step = float(setup.scene.period(case.parameters)) / (2 * UNDRIVEN)
            times = np.asarray(case.start_time + step * steps, dtype=float)
            states: Array = np.zeros((UNDRIVEN, 2 * len(setup.bound.coordinates)))
            return call_engine(lambda: one.bound.accelerations(times, states))
        return one.simulate(setup.default_step, steps).matrix(setup.scene.observables)

    undriven = setup.with_case(still)
    with_drive, motion = seen(setup), seen(undriven)  # in this order: an engine may keep the first
    if not np.array_equal(with_drive, motion):
        return
    if is_driven(setup, undriven, motion, steps):
        raise EngineError(
            "drive",
            "it moves alike with and without this case's drive, and not as without it: the drive "
            "of an earlier case is still applied, unless models without controls deviate too; read "
            "system.terms and system.controls(time) of each system anew, since systems with the "
            "same file differ in them",
        )
    raise CannotJudgeError(
        "it moves as without the drive, a force in time given by system.force(...) and "
        "system.controls(...), and in no file; see docs/engines.md"
    )


def is_driven(setup: Setup, undriven: Setup, motion: Array, steps: NDArray[np.int_]) -> bool:
    """Return True if a motion (k, n_t) after so many default steps is a driven one.

    It lies closer to the reference with the drive than to that without. An engine without a method
    computes accelerations once more, at other times.
    """
    if setup.method is None:
        findings = algebra.measure(undriven).findings
        return any(isinstance(one, Finding) and one.error > one.tolerance for one in findings)
    names = setup.scene.observables
    times = np.asarray(setup.case.start_time + setup.default_step * steps, dtype=float)
    driven, still = (
        roundoff_reference(one.bound.solved_equations, one.case, times, names).values
        for one in (setup, undriven)
    )
    change = np.max(np.abs(driven - still), axis=1)
    seen = change > 0
    from_still, from_driven = (
        np.linalg.norm((motion - one)[seen] / change[seen, None]) for one in (still, driven)
    )
    return bool(from_driven < from_still)


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

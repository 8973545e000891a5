"""Stepping Exudyn from sample to sample."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..protocol import EngineError

Array = NDArray[np.float64]


def integrate_samples(
    mbs: Any, solver: Any, settings: Any, step: float, times: Array
) -> tuple[Array, Array, Array, Array, int]:
    """Run an initialised solver from sample to sample.

    One solver does all: its memory (the algorithmic accelerations of GeneralizedAlpha) goes
    on through a sample, which therefore does not act on the motion. It counts its steps and
    its time from the start of each leg, which is where its own clock stood.

    Returns
    -------
    coordinates, rates : arrays (n_t, N)
    angles : array (n_t, h)
        Exudyn's data coordinates, which count the turns of hinges.
    clock : array (n_t,)
    steps : int

    Raises
    ------
    EngineError
        ``solver``, if Exudyn gave up.
    """
    data, progress = mbs.systemData, solver.it
    indices = np.rint((times - progress.startTime) / step).astype(int)
    legs = np.diff(indices, prepend=0).tolist()
    size = len(data.GetODE2Coordinates())
    coordinates, rates = np.empty((len(times), size)), np.empty((len(times), size))
    angles, clock = np.empty((len(times), len(data.GetDataCoordinates()))), np.empty(len(times))
    steps = 0
    for row, leg in enumerate(legs):
        if leg:
            progress.startTime = begin = data.GetTime()
            progress.endTime = begin + leg * step
            finished = solver.SolveSteps(mbs, settings)
            steps += progress.currentStepIndex - 1
            if not finished:
                raise EngineError("solver", gave_up(solver))
        coordinates[row] = data.GetODE2Coordinates()
        rates[row] = data.GetODE2Coordinates_t()
        angles[row] = data.GetDataCoordinates()
        clock[row] = data.GetTime()
    return coordinates, rates, angles, clock, steps


def gave_up(solver: Any) -> str:
    """Return where a solver stopped, and Exudyn's words for it."""
    reason = " ".join(str(solver.GetErrorString()).split()) or "no reason given"
    return (
        f"Exudyn's solver found no solution at t = {solver.it.currentTime:.9g} s; "
        f"try a smaller step (Exudyn: {reason})"
    )


def changes(solver: Any, step: float) -> tuple[str, ...]:
    """Return what the solver changed on its own.

    Fixed steps stay the same to the bit; one that may adapt also shrinks by rounding where
    a leg ends.
    """
    taken = float(solver.it.currentStepSize)
    same = taken == step or (solver.it.adaptiveStep and abs(taken - step) <= 1e-9 * step)
    return () if same else (f"step ({taken:.9g} s instead of {step:.9g} s)",)

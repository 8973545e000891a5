"""A check that deviates, and the search for the one mistake that explains it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....reference.scene import Array
from ...engines.run import call_engine
from ...engines.setup import Setup
from ..comparison import Measured, Runs
from ..kinds import algebra

DISTINCT = 8
"""Numbers that are not taken for numbers of 32 bits by chance."""


@dataclass(frozen=True)
class Deviation:
    """A check that deviates.

    Attributes
    ----------
    setup : Setup
    measure : callable ``(setup) -> Measured``
        The measurement of its kind.
    verdicts : mapping of str to str
        On each quantity that was measured.
    runs : Runs or None
        What was measured.
    """

    setup: Setup
    measure: Callable[[Setup], Measured]
    verdicts: Mapping[str, str]
    runs: Runs | None

    def repeated(self) -> Array:
        """Return accelerations at random states, or observables of a short run, row by row."""
        setup = self.setup
        if setup.method is None:
            _, times, states = algebra.measured_states(setup)
            ask = setup.engine.accelerations
            return np.asarray(call_engine(lambda: ask(setup.case, setup.model, times, states))).T
        run = setup.simulate(setup.default_step, np.arange(1, DISTINCT + 1))
        return run.matrix(setup.scene.public_states)

    @cached_property
    def numbers(self) -> Array:
        """What `repeated` returned first."""
        return self.repeated()


Search = Callable[[Deviation], str]
"""The mistake that explains a deviation, in words, empty if none of those that it tries does."""


def cause(deviation: Deviation, searches: Sequence[Search]) -> str:
    """Return where a check's deviations come from, by the first search that finds it."""
    for search in searches:
        try:
            found = search(deviation)
        except (Exception, SystemExit):  # the engine runs again, which may do anything
            found = ""
        if found:
            return found
    return ""

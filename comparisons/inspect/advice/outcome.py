"""What runs of a user's model come to: settings with their errors and times, and the choice."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf
from typing import Any

import numpy as np

from ....reference.errors import UsageError
from ..rules.remedies import PREFERRED
from .converged import Converged
from .runs import Setting

EVALUATIONS = {"RK4": 4}
"""Times that an integrator evaluates forces in a step, where that is more than once."""

CHEAPEST = ("Euler", *PREFERRED)
"""Integrators by what a step costs beside the forces, the cheapest first."""

MARGIN = 0.5
"""Share of the target that a recommended setting may use: with other controls it errs otherwise."""

ALIKE = 1e-3
"""Share by which errors may differ that count as the same."""

RELIABLE = 1.02
"""A step above this many times a limit is one that the limit calls unstable."""


@dataclass(frozen=True)
class Question:
    """What is asked of a model.

    Attributes
    ----------
    target, horizon, budget : float
        Relative error, and times [s].
    seed : int
        Of the moving controls.
    observed : tuple of str
        Joints and sites; all joints if there are none.
    exact : bool
        Whether runs are compared with closures that are closed exactly.
    resume : str or None
        File that keeps runs.
    """

    target: float = 0.01
    horizon: float = 1.0
    budget: float = 120.0
    seed: int = 1
    observed: tuple[str, ...] = ()
    exact: bool = False
    resume: str | None = None

    def refuse_nonsense(self) -> None:
        """Refuse numbers that make no sense.

        Raises
        ------
        UsageError
        """
        for name in ("target", "horizon", "budget"):
            value = vars(self)[name]
            if not 0 < value < inf:
                raise UsageError(f"--{name} must be a positive number, not {value:g}")
        if self.target >= 1:
            raise UsageError(f"--target is a relative error below 1, not {self.target:g}")


@dataclass(frozen=True)
class Trial:
    """What a setting costs and how well it does, over all starts.

    Attributes
    ----------
    setting : Setting
    error : float
        The largest of all starts, relative; infinite where the state was lost.
    bound : float
        Of the converged runs there.
    energy : float
        Largest difference of the energy, in the largest kinetic energy.
    violation : float
        Largest residual of an equality (m, rad).
    seconds : float
        Processor time [s/s], the median of all runs.
    failed : str
        Where the state was lost, and when; empty if it was not.
    limit : float
        The largest stable step of small motions [s]; infinite if there is none, or none is known.
    """

    setting: Setting
    error: float
    bound: float
    energy: float
    violation: float
    seconds: float
    failed: str
    limit: float

    @property
    def integrator(self) -> str:
        """Of the setting."""
        return self.setting.integrator

    @property
    def step(self) -> float:
        """Of the setting [s]."""
        return self.setting.step

    @property
    def work(self) -> float:
        """Evaluations of forces in a simulated second [1/s]: times scatter, and this does not."""
        return EVALUATIONS.get(self.integrator, 1) / self.step


@dataclass
class Outcome:
    """What accuracy costs of one model, and what follows for its setting.

    Attributes
    ----------
    file : str
    asked : Question
    truths : list of Converged
    trials : list of Trial
    unknown : list of str
        Starts that were left out, each with its reason.
    complete : bool
        Whether the time was enough.
    missed : mapping of Setting to float
        What would have been recommended, and its error from other starts, or with other controls.
    proved : bool
        Whether what is recommended met the target from other starts and with other controls.
    elsewhere : float
        Its error there.
    unproved : list of str
        Of these, the starts without a converged run, each with its reason.
    period : float
        After which runs are compared [s].
    version : str
        MuJoCo's.
    """

    file: str
    asked: Question = field(default_factory=Question)
    truths: list[Converged] = field(default_factory=list)
    trials: list[Trial] = field(default_factory=list)
    unknown: list[str] = field(default_factory=list)
    complete: bool = True
    missed: dict[Setting, float] = field(default_factory=dict)
    proved: bool = False
    elsewhere: float = 0.0
    unproved: list[str] = field(default_factory=list)
    period: float = 0.0
    version: str = ""

    @property
    def front(self) -> list[Trial]:
        """What nothing beats in both error and time, the fastest first."""
        front: list[Trial] = []
        for one in sorted(self.trials, key=lambda trial: (trial.seconds, trial.error)):
            if one.error < min((other.error for other in front), default=inf):
                front.append(one)
        return [one for one in front if one.error < 1]

    @property
    def choice(self) -> Trial | None:
        """The setting of least work that meets the target with a margin, as shorter steps do."""
        good = [one for one in self.trials if one.error <= MARGIN * self.asked.target]
        steady = [
            one
            for one in good
            if all(
                other.error <= self.asked.target
                for other in self.trials
                if other.setting.alike(one.setting) and other.step < one.step
            )
            and one.step <= RELIABLE * one.limit
            and not {one.setting, one.setting._replace(iterations=None)} & self.missed.keys()
        ]
        return min(steady, key=self.preference, default=None)

    def preference(self, one: Trial) -> tuple[float, ...]:
        """Return the key that orders settings, the best first."""
        own = self.trials[0].setting
        changes = sum(option is not None for option in one.setting[2:])
        cost = CHEAPEST.index(one.integrator)
        return one.work, one.setting != own, changes, one.integrator != own.integrator, cost

    @property
    def least_iterations(self) -> tuple[Trial, int] | None:
        """A setting whose iterations were varied, and the fewest that leave its error as it is."""
        for base in self.trials:
            same = [
                int(one.setting.iterations or 0)
                for one in self.trials
                if one.setting._replace(iterations=None) == base.setting
                and one is not base
                and abs(one.error - base.error) <= ALIKE * base.error
            ]
            if same:
                return base, min(same)
        return None

    @property
    def telling(self) -> list[Trial]:
        """Trials without those whose iterations change nothing, unless one is the choice."""
        least = self.least_iterations
        return [
            one
            for one in self.trials
            if one is self.choice
            or not (least and one.setting.iterations and one.step == least[0].step)
            or one.integrator != least[0].integrator
            or abs(one.error - least[0].error) > ALIKE * least[0].error
        ]

    @property
    def own(self) -> Trial | None:
        """The file's own setting, which is tried first."""
        return self.trials[0] if self.trials else None

    @property
    def counts(self) -> list[int]:
        """Periods over which each start is compared."""
        return [truth.count(self.asked.target) for truth in self.truths]

    @property
    def compared(self) -> float:
        """Time over which all starts are compared [s]."""
        return min(self.counts, default=0) * self.period

    def largest(self, field: str) -> float:
        """Return the largest of a field of all converged runs, as long as they are compared."""
        both = zip(self.truths, self.counts, strict=True)
        return max(
            (float(np.max(vars(one)[field][:n], initial=0.0)) for one, n in both), default=0.0
        )

    @property
    def softens(self) -> bool:
        """Whether there are closures whose softness was tried."""
        return any(len(one.softness) for one in self.truths)


def trial_document(one: Trial) -> dict[str, Any]:
    """Return a trial as a document holds it."""
    return {**vars(one), **one.setting._asdict(), "setting": one.setting.name}

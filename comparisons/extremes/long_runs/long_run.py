"""A motion that is followed for long, and one drift of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from ....reference import get_scene
from ....reference.orbits import Orbit, find_orbit
from ....reference.scene import Array
from ...checks.tolerances import rows
from ...engines.run import Trajectory
from ...engines.setup import Setup

PART, PART_STEPS = 100, 1 << 14
"""Periods over which a scheme is run, or halved steps; fewer if they took more steps than that."""

AMPLITUDE, AMPLITUDE_IF_PUSHED = 1e-4, 1e-6
"""Of free vibrations, in the size of the scene (1 rad, its shortest length): what is not linear
changes frequencies by its square. Where a coordinate has no spring the vibration pushes it away
with a force of second order, all the time: there the amplitude is less."""

BLURRED = 10.0
"""A drift within a slack so many times what is predicted says nothing of the prediction."""


@dataclass(frozen=True)
class FreeMode:
    """An undamped mode about a state of rest of a scene.

    Attributes
    ----------
    about : str
    rest : array (2 n,)
    omega : float
        [rad/s]
    shape : array (n,)
        Normed by the mass matrix.
    mass : array (n, n)
    push : float
        0 where every coordinate has a spring; else the ratio of the largest inertia to the least,
        with which the forces of second order push one that has none.
    """

    about: str
    rest: Array
    omega: float
    shape: Array
    mass: Array
    push: float

    @property
    def amplitude(self) -> float:
        """`AMPLITUDE`, or less."""
        return AMPLITUDE_IF_PUSHED if self.push else AMPLITUDE

    def amplitudes(self, states: Array) -> Any:
        """Return ``a - i a'/omega`` (n_t,), which turns with ``exp(i omega t)``."""
        q, v = np.split(states - self.rest[:, None], 2)
        shape = self.shape @ self.mass
        return shape @ q - 1j * (shape @ v) / self.omega


@dataclass(frozen=True)
class LongRun:
    """A motion of a setup over a number of periods.

    Attributes
    ----------
    setup : Setup
        With its step.
    kind : str
        As of `Motion`.
    period : float
        [s]
    periods : int
    mode : FreeMode or None
        Of a free vibration.
    """

    setup: Setup
    kind: str
    period: float
    periods: int
    mode: FreeMode | None = None

    @property
    def step(self) -> float:
        """The step [s]."""
        return self.setup.step_size

    @property
    def part(self) -> int:
        """Periods over which drifts are predicted."""
        return int(np.clip(PART_STEPS * self.step / self.period, 8, min(PART, self.periods)))

    def simulate(self, samples: Any, division: int = 1) -> Trajectory:
        """Run the engine and record it at these step numbers, with a fraction of the step."""
        return self.setup.simulate(self.step / division, samples * division)

    def by_scheme(self, scheme: str, samples: Any) -> dict[str, Array]:
        """Return the observables (n_t,) of a published scheme on the model's equations."""
        states, names = self.setup.scheme_states(self.step, samples, scheme), self.setup.observables
        return dict(zip(names, rows(self.setup.equations, states, names), strict=True))

    def marks(self, periods: float, count: int) -> Any:
        """Return about ``count`` step numbers, evenly spread over some periods."""
        last = round(periods * self.period / self.step)
        return np.unique(np.round(np.linspace(0, last, count + 1)[1:]).astype(int))


@dataclass(frozen=True)
class Drift:
    """One drift: what was measured, what is predicted, and by how much they may differ."""

    measured: float
    predicted: float
    slack: float

    @property
    def agrees(self) -> bool:
        """Whether it is as predicted."""
        return abs(self.measured - self.predicted) <= self.slack

    def __str__(self) -> str:
        """Return it in words."""
        words = f"{self.measured:.3g} (predicted {self.predicted:.3g} within ± {self.slack:.2g}"
        blurred = self.slack > BLURRED * abs(self.predicted) and abs(self.measured) <= self.slack
        return f"{words}, below what can be told)" if blurred else f"{words})"


@dataclass(frozen=True)
class Drifts:
    """What was measured of a long run.

    Attributes
    ----------
    trajectory : Trajectory
    drifts : mapping of str to Drift
    near : int array or None
        Step numbers at which a part shows how far a loop is open; None for evenly spread ones.
    numbers : mapping of str to float
        More of the row's values.
    """

    trajectory: Trajectory
    drifts: Mapping[str, Drift]
    near: Any = None
    numbers: Mapping[str, float] = field(default_factory=dict)


@lru_cache(maxsize=8)
def known_orbit(scene: str, parameters: Any) -> Orbit:
    """Return the reference's periodic orbit, remembered within a process."""
    return find_orbit(get_scene(scene), parameters)


def shortest_length(parameters: Any) -> float:
    """Return the shortest length of a scene [m], 1 m if it has none."""
    endings = ("length", "radius", "eccentricity")
    lengths = [value for name, value in parameters.as_dict().items() if name.endswith(endings)]
    return min((value for value in lengths if isinstance(value, float) and value > 0), default=1.0)

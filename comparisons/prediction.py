"""The error that a correct engine makes with its method and step."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ..reference import get_scene, schemes
from ..reference.errors import MbcheckError
from ..reference.linear import linearise, modes
from ..reference.scene import Array, Case
from ..reference.solver import Solution, amplification, solve
from .engine import EPS, Engine, Method

SAFETY = 1.2
"""On an error predicted with the engine's own scheme: rounding, and the profile `strict`."""

RICHARDSON_SAFETY = 1.5
"""On an error predicted from two steps: what the next order adds to it."""

STEPS_PER_PERIOD = {1: 800, 2: 300, 3: 150, 4: 100, 5: 60, 6: 40}
"""Steps in the shortest period of a scene, by order of the method."""

CAP = 0.05
"""No predicted error above this share of a quantity's range is granted as tolerance."""

MOST_AMPLIFICATION = 1e3
"""Horizons are cut so that an initial error grows by no more than this."""


def shortest_period(case: Case) -> float:
    """Return the shortest of the drive's period and the natural periods [s]."""
    scene = get_scene(case.scene)
    omega = [2 * np.pi / float(scene.period(case.parameters))]
    for place in scene.equilibria.values():
        state = scene.state(place(case.parameters))
        mass, _, stiffness = linearise(scene, case.parameters, state)
        omega += [mode.omega for mode in modes(mass, 0 * mass, stiffness)]
    omega += [abs(case.state.get(f"{name}_dot", 0.0)) for name in scene.turning]
    return 2 * np.pi / max(omega)


def default_step(case: Case, method: Method) -> float:
    """Return a step [s] for a method: a power of two, so that no clock has to round."""
    count = STEPS_PER_PERIOD[min(method.order, max(STEPS_PER_PERIOD))]
    return 2.0 ** np.floor(np.log2(shortest_period(case) / count))


@lru_cache(maxsize=256)
def _truth(key: tuple[Any, ...], times: tuple[float, ...]) -> Solution:
    name, parameters, state, start = key
    return solve(get_scene(name), parameters, np.array(state), np.array(times), start)


def reference_solution(case: Case, times: Array) -> Solution:
    """Return the reference of a case at sample times; remembered within a process."""
    state = tuple(get_scene(case.scene).state(case.state))
    key = (case.scene, case.parameters, state, case.start_time)
    return _truth(key, tuple(float(t) for t in times))


@lru_cache(maxsize=64)
def _permitted(key: tuple[Any, ...], horizon: float) -> tuple[float, float]:
    name, parameters, state, start = key
    scene = get_scene(name)
    for _ in range(10):
        times = start + np.linspace(0, horizon, 33)[1:]
        growth = amplification(scene, parameters, np.array(state), times, start)
        if growth <= MOST_AMPLIFICATION:
            return horizon, growth
        horizon /= 2
    raise MbcheckError(
        f"errors grow by {growth:.3g} within {horizon:.3g} s: no trajectory can be compared"
    )


def permitted_horizon(case: Case) -> tuple[float, float]:
    """Return the horizon [s] that error growth permits, and the amplification over it."""
    state = tuple(get_scene(case.scene).state(case.state))
    return _permitted((case.scene, case.parameters, state, case.start_time), case.horizon)


def effective_parameters(engine: Engine, case: Case, model: str) -> Any:
    """Return the parameters that the engine's model really has.

    They differ from the case's where an engine cannot express a value, such as a moment of
    inertia of zero.
    """
    tell = getattr(engine, "effective_parameters", None)
    return tell(case, model) if tell else case.parameters


def scheme_states(
    engine: Engine, case: Case, model: str, method: Method, step: float, samples: Array
) -> Array:
    """States (2 n, n_t) that a correct engine reaches with this scheme at step numbers."""
    assert method.scheme is not None
    scene = get_scene(case.scene)
    clock = bool(getattr(engine, "integrates_drive", False))
    return schemes.integrate(
        scene,
        effective_parameters(engine, case, model),
        method.scheme,
        scene.state(case.state),
        step,
        samples,
        case.start_time,
        clock,
    )


def rounding(steps: int, growth: float) -> float:
    """Relative error that rounding may leave after so many steps, errors growing so much."""
    return 8 * EPS * (16 + steps) * max(growth, 1.0)


def trusted(predicted: Array) -> int:
    """Return up to which sample the predicted relative errors (..., n_t) stay below `CAP`.

    A coarse method is judged as far as its own error leaves something to be seen.
    """
    worst = np.maximum.accumulate(np.max(np.atleast_2d(predicted), axis=0))
    return int(np.searchsorted(worst, CAP / RICHARDSON_SAFETY, side="right"))


def sample_numbers(horizon: float, step: float, count: int = 32) -> Array:
    """Return up to ``count`` step numbers spread over the horizon, the last included."""
    last = max(1, round(horizon / step))
    return np.unique(np.rint(np.linspace(0, last, count + 1)[1:]).astype(int))


@dataclass(frozen=True)
class Richardson:
    """What three runs at h, h/2, h/4 say of a quantity.

    Attributes
    ----------
    predicted : float
        Error at h, with `RICHARDSON_SAFETY`.
    limit : array
        Value extrapolated to h -> 0 from the finer two.
    spread : float
        By how much that moved when the step was halved.
    change, ratio : float
        Change from h to h/2, and how many times larger it is than that from h/2 to h/4.
    order : int
    """

    predicted: float
    limit: Array
    spread: float
    change: float
    ratio: float
    order: int

    def shrinks(self, floor: float) -> bool:
        """Return whether the error shrinks as declared, or is down at the floor."""
        return self.ratio > 2 ** (self.order - 0.5) or self.change < 10 * floor


def richardson(values: list[Array], order: int) -> Richardson:
    """Extrapolate a quantity measured at h, h/2 and h/4."""
    coarse, half, quarter = values
    gain = 2**order - 1
    limit, before = quarter + (quarter - half) / gain, half + (half - coarse) / gain
    change = float(np.max(np.abs(coarse - half)))
    finer = float(np.max(np.abs(half - quarter)))
    return Richardson(
        predicted=RICHARDSON_SAFETY * change * (gain + 1) / gain,
        limit=limit,
        spread=float(np.max(np.abs(limit - before))),
        change=change,
        ratio=change / finer if finer > 0 else np.inf,
        order=order,
    )

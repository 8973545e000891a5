"""What a correct engine computes with its model, its method and its step.

Three layers are told apart. The scene's equations are *exact*. An engine's model may have
others, which it *claims* to solve: the difference is model error, and no step removes it.
What the method makes of those is integration error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...reference import get_scene
from ...reference.errors import MbcheckError, NoOrbitError
from ...reference.linear import linearise, modes
from ...reference.scene import Array, Case, Scene
from ...reference.solve import schemes
from ...reference.solve.batched import solve_many
from ...reference.solve.flow import growths
from ...reference.solve.single import solve
from ...reference.solve.solution import Solution, state_size
from ..engines.protocol import EPS, VIOLATIONS, Engine, Method

SAFETY = 1.2
"""On an error predicted with the engine's own scheme: rounding, and the profile `strict`."""

RICHARDSON_SAFETY = 1.5
"""On an error predicted from two steps: what the next order adds to it."""

STEPS_PER_PERIOD = {1: 800, 2: 300, 3: 150, 4: 100, 5: 60, 6: 40}
"""Steps in the shortest period of a scene, by order of the method."""

CAP = 0.05
"""No predicted error above this share of a quantity's range is granted as tolerance."""

VIOLATION = 1e-9
"""Residual of a closed loop that is no drift, in the size of its lengths: what an iteration
that stops at 1e-11 of its increments leaves, with a margin."""

MOST_STEPS = 1 << 13
"""Longer runs with a method's default step are cut: what it does wrong shows before. An
eighth of it where the error is predicted by runs with half and a quarter of the step, unless
the scene's bodies bend, which takes long to show: then none is cut of cases for `--full`."""

KEPT = 256
"""Least number of times over a case's horizon at which its reference is kept."""

MOST_AMPLIFICATION = 1e5
"""Horizons are cut so that an initial error grows by no more than this."""

VIBRATION_GROWTH = 1e3
"""What an initial error of a beam may grow to over its case, in the sizes of its states: 741 by
the variational equations of its spin-up, which cost more than all that they permit."""

MARKS = 8
"""Places where a horizon may be cut."""


class Claim(NamedTuple):
    """The equations of motion that an engine's model has."""

    scene: Scene
    parameters: Any

    def start(self, case: Case) -> Array:
        """Return the initial state of a case in the claim's own coordinates."""
        names = get_scene(case.scene).state_names
        values = dict.fromkeys(names, 0.0) | dict(case.state)
        own = dict(self.scene.embedding(self.parameters, values))
        # an unknown name is kept, for `Scene.state` to refuse
        own |= {
            name: value
            for name, value in case.state.items()
            if name in self.scene.state_names or name not in names
        }
        if self.scene is not get_scene(case.scene):  # the scene itself cannot be off
            for name, offset in case.inconsistency.items():
                own[name] = own.get(name, 0.0) + offset
        return self.scene.state(own)

    def stands_for(self, case: Case) -> bool:
        """Return whether these are the exact equations of the case."""
        return self.scene is get_scene(case.scene) and self.parameters == case.parameters


def exactly(case: Case) -> Claim:
    """Return the scene's own equations."""
    return Claim(get_scene(case.scene), case.parameters)


def claim(engine: Engine, case: Case, model: str) -> Claim:
    """Return what an engine's model claims to solve: the exact equations unless it tells."""
    tell = getattr(engine, "claim", None)
    own = tell(case, model) if tell else None
    return exactly(case) if own is None else Claim(*own)


def exchanged(engine: Engine, case: Case, model: str) -> tuple[str, ...]:
    """Return the coordinates in which an engine takes states, and gives matrices."""
    tell = getattr(engine, "coordinates", None)
    return tuple(tell(case, model)) if tell else get_scene(case.scene).public


def discretised(engine: Engine, case: Case, model: str) -> bool:
    """Return whether a model claims to converge to a continuum, not to solve its own equations."""
    own = claim(engine, case, model).scene
    return bool(own.internal) and exchanged(engine, case, model) != own.coordinates


def element_order(engine: Engine, case: Case, model: str) -> int:
    """Return the order of convergence with `segments` that a model claims, 0 without any."""
    tell = getattr(engine, "element_order", None)
    return tell(case, model) if tell else 0


def with_segments(case: Case, factor: float) -> Case:
    """Return the case with so many times the segments."""
    p = case.parameters
    return replace(case, parameters=p.replace(segments=max(2, round(factor * p.segments))))


def constrained(engine: Engine, case: Case, model: str) -> bool:
    """Return whether constraints close loops of a model."""
    tell = getattr(engine, "constrained", None)
    return bool(tell and tell(case, model))


def observables(engine: Engine, case: Case, model: str) -> tuple[str, ...]:
    """Return what is compared of a run; closed loops also show how far they are open."""
    names = get_scene(case.scene).observables
    return (*names, *VIOLATIONS) if constrained(engine, case, model) else names


def shortest_period(case: Case) -> float:
    """Return the shortest of the orbit's period and the natural periods [s]."""
    scene = get_scene(case.scene)
    omega = [2 * np.pi / float(scene.period(case.parameters))]
    if scene.internal:  # whose modes have no end
        return 2 * np.pi / omega[0]
    for place in scene.equilibria.values():
        try:
            state = scene.state(place(case.parameters))
        except NoOrbitError:
            continue
        mass, _, stiffness = linearise(scene, case.parameters, state)
        omega += [mode.omega for mode in modes(mass, 0 * mass, stiffness)]
    omega += [abs(case.state.get(f"{name}_dot", 0.0)) for name in scene.turning]
    return 2 * np.pi / max(omega)


STIFF = 0.5
"""Longest step times the fastest rate of a model's closure: a quarter of what explicit
methods can bear."""


def bearable_step(case: Case, own: Claim) -> float:
    """Return the longest step [s] that a model's own equations bear; a continuum bears any."""
    if own.scene is get_scene(case.scene) or own.scene.finer:
        return np.inf
    matrices = linearise(own.scene, own.parameters, own.start(case))
    return STIFF / max(mode.omega for mode in modes(*matrices))


def power_of_two(most: float) -> float:
    """Return the largest power of two that is not above a number; no clock has to round it."""
    return float(2.0 ** np.floor(np.log2(most)))


def default_step(case: Case, method: Method, own: Claim | None = None) -> float:
    """Return a step [s] for a method: a power of two, so that no clock has to round."""
    count = STEPS_PER_PERIOD[min(method.order, max(STEPS_PER_PERIOD))]
    longest = np.inf if own is None else bearable_step(case, own)
    return power_of_two(min(shortest_period(case) / count, longest))


@dataclass(frozen=True)
class Truth:
    """A claim's solution at sample times, as rows of observables.

    Attributes
    ----------
    times : array (n_t,)
    values : array (k, n_t)
    bound : array (k,)
        On the error of the reference.
    size : array (k,)
        To which errors are related.
    states : array (2 n, n_t)
        Of the claim's own coordinates.
    """

    times: Array
    values: Array
    bound: Array
    size: Array
    states: Array


def sample_spacing(horizon: float) -> float:
    """Return the spacing [s] of the times at which a case's reference is kept.

    A power of two, as steps are, so that all methods can be sampled at some of them.
    """
    return power_of_two(horizon / KEPT)


@lru_cache(maxsize=64)
def _kept(own: Claim, state: tuple[float, ...], start: float, horizon: float) -> Solution:
    spacing = sample_spacing(horizon)
    times = start + spacing * np.arange(1, int(horizon / spacing) + 1)
    return solve(own.scene, own.parameters, np.array(state), times, start)


def _solved(
    own: Claim, state: tuple[float, ...], start: float, times: Array, horizon: float
) -> Solution:
    """Solve, or look up in what was solved before."""
    spacing = sample_spacing(horizon)
    numbers = np.rint((times - start) / spacing).astype(int)
    on_grid = np.array_equal(start + spacing * numbers, times)
    if not on_grid or numbers[0] < 1 or numbers[-1] * spacing > horizon:
        return solve(own.scene, own.parameters, np.array(state), times, start)
    whole = _kept(own, state, start, horizon)
    return replace(whole, times=times, states=whole.states[:, numbers - 1])


@lru_cache(maxsize=256)
def _truth(
    own: Claim,
    state: tuple[float, ...],
    start: float,
    times: tuple[float, ...],
    horizon: float,
    names: tuple[str, ...],
) -> Truth:
    def solved(one: Claim, at: tuple[float, ...]) -> Solution:
        return _solved(one, at, start, np.array(times), horizon)

    return truncated(own, state, truth_of(own, solved(own, state), names), names, solved)


def truncated(
    own: Claim,
    state: tuple[float, ...],
    found: Truth,
    names: tuple[str, ...],
    solved: Callable[[Claim, tuple[float, ...]], Solution],
) -> Truth:
    """Return a solution whose bound counts what more coordinates of a continuum change."""
    if own.scene.finer is None:
        return found
    finer = Claim(own.scene.finer, own.parameters)
    values = dict(zip(own.scene.state_names, state, strict=True))
    at = tuple(values.get(name, 0.0) for name in finer.scene.state_names)
    other = truth_of(finer, solved(finer, at), names)
    change = np.max(np.abs(other.values - found.values), axis=1)
    return replace(found, bound=found.bound + other.bound + change)


def truth_of(own: Claim, solution: Solution, names: tuple[str, ...]) -> Truth:
    """Return a solution as rows of observables; bounds of outputs follow from the states'."""
    scene, parameters = own.scene, own.parameters
    found = scene.observe(solution.states, parameters)
    units = dict(zip(VIOLATIONS, ("m", "m/s"), strict=True)) | dict(scene.units)
    bounds = dict(zip(scene.state_names, solution.error_bound, strict=True))
    sizes = dict(zip(scene.state_names, state_size(solution), strict=True))
    for name in set(found) - set(sizes):
        sizes[name] = float(np.max(np.abs(found[name]))) or 1.0
        bounds[name] = 8 * EPS * sizes[name]
    for row, bound in enumerate(solution.error_bound):
        probed = solution.states.astype(complex)
        probed[row] += 1e-40j
        slopes = scene.observe(probed, parameters)
        for name in set(found) - set(scene.state_names):
            bounds[name] += float(np.max(np.abs(slopes[name].imag / 1e-40))) * bound
    for name in set(names) & set(VIOLATIONS):
        sizes[name] = max(
            (sizes[other] for other in sizes if other not in VIOLATIONS
             and units[other] == units[name]), default=1.0,
        )  # fmt: skip
    zero = np.zeros(len(solution.times))
    return Truth(
        times=solution.times,
        values=np.array([found.get(name, zero) for name in names]),
        bound=np.array([bounds.get(name, 0.0) for name in names]),
        size=np.array([sizes[name] for name in names]),
        states=solution.states,
    )


def truth(own: Claim, case: Case, times: Any, names: tuple[str, ...]) -> Truth:
    """Return a claim's solution of a case; remembered within a process."""
    state = tuple(float(value) for value in own.start(case))
    times = tuple(float(t) for t in times)
    return _truth(own, state, case.start_time, times, permitted_horizon(case)[0], names)


def sharp_truth(own: Claim, case: Case, times: Array, names: tuple[str, ...]) -> Truth:
    """Return a claim's solution over a short time, down to round-off unless it is stiff."""
    if own.scene.stiff:
        return truth(own, case, times, names)
    return _sharp(own, tuple(own.start(case)), case.start_time, tuple(times), names)


@lru_cache(maxsize=64)
def _sharp(
    own: Claim,
    state: tuple[float, ...],
    start: float,
    times: tuple[float, ...],
    names: tuple[str, ...],
) -> Truth:
    at = np.array(state), np.array(times), start
    return truth_of(own, solve_many(own.scene, own.parameters, *at, tolerance=1e-14), names)


@lru_cache(maxsize=64)
def _permitted(
    scene: Scene, parameters: Any, state: tuple[float, ...], start: float, horizon: float
) -> tuple[float, float]:
    for _ in range(4):
        times = start + horizon * np.arange(1, MARKS + 1) / MARKS
        growth = growths(scene, parameters, np.array(state), times, start)
        bearable = np.flatnonzero(growth <= MOST_AMPLIFICATION)
        if bearable.size:
            last = int(bearable[-1])
            return float(times[last] - start), float(growth[last])
        horizon /= MARKS
    raise MbcheckError(
        f"errors grow by {growth[0]:.3g} within {horizon:.3g} s: no trajectory can be compared"
    )


def permitted_horizon(case: Case) -> tuple[float, float]:
    """Return the horizon [s] that error growth permits, and the amplification over it."""
    scene = get_scene(case.scene)
    if scene.internal:
        return case.horizon, VIBRATION_GROWTH
    state = tuple(scene.state(case.state))
    return _permitted(scene, case.parameters, state, case.start_time, case.horizon)


def affordable(case: Case, step: float, scheme: str | None) -> float:
    """Return the part of the permitted horizon [s] that is run with this step."""
    horizon, _ = permitted_horizon(case)
    if get_scene(case.scene).internal:
        return horizon if case.full_only else min(horizon, MOST_STEPS * step)
    return min(horizon, (MOST_STEPS if scheme else MOST_STEPS // 8) * step)


def scheme_of(engine: Engine, case: Case, model: str, method: Method) -> str | None:
    """Return the published scheme that a method is on this model, None if it is none."""
    tell = getattr(engine, "scheme", None)
    found: str | None = tell(case, model, method) if tell else method.scheme
    return found


def scheme_states(
    engine: Engine, case: Case, own: Claim, scheme: str, step: float, samples: Any
) -> Array:
    """States (2 n, n_t) that a correct engine reaches with a scheme at step numbers."""
    clock = bool(getattr(engine, "integrates_drive", False))
    start = own.start(case)
    return schemes.integrate(
        own.scene, own.parameters, scheme, start, step, samples, case.start_time, clock
    )


def rows(own: Claim, states: Array, names: tuple[str, ...]) -> Array:
    """Return observables (k, n_t) of states (2 n, n_t) of a claim."""
    found = own.scene.observe(states, own.parameters)
    zero = np.zeros(states.shape[1:])
    return np.array([found.get(name, zero) for name in names])


def rounding(steps: int, growth: float) -> float:
    """Relative error that rounding may leave after so many steps, errors growing so much."""
    return 8 * EPS * (16 + steps) * max(growth, 1.0)


def trusted(predicted: Array) -> int:
    """Return up to which sample the predicted relative errors (..., n_t) stay below `CAP`.

    A coarse method is judged as far as its own error leaves something to be seen.
    """
    worst = np.maximum.accumulate(np.max(np.atleast_2d(predicted), axis=0))
    return int(np.searchsorted(worst, CAP / RICHARDSON_SAFETY, side="right"))


def sample_numbers(horizon: float, step: float, count: int = 32) -> NDArray[np.int_]:
    """Return about ``count`` step numbers spread evenly over a horizon.

    With a step that is a power of two, their times are those that references are kept at.
    """
    every = max(1, int(2.0 ** np.round(np.log2(max(1.0, horizon / step / count)))))
    return every * np.arange(1, max(1, int(horizon / step / every * (1 + 1e-12))) + 1)


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
        predicted=RICHARDSON_SAFETY
        * max(change * (gain + 1) / gain, float(np.max(np.abs(coarse - limit)))),
        limit=limit,
        spread=float(np.max(np.abs(limit - before))),
        change=change,
        ratio=change / finer if finer > 0 else np.inf,
        order=order,
    )

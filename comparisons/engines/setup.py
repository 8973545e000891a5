"""A setup: an engine's model of a case, with a method and its step, and what follows from these."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from ...reference import get_scene
from ...reference.amplification import AMPLIFICATION
from ...reference.errors import NoOrbitError, UsageError
from ...reference.linear import linearise, modes
from ...reference.scene import Array, Case, Scene
from ...reference.solve import schemes
from .adapter import Adapter
from .equations import ModelEquations, scene_equations
from .protocol import Method
from .run import VIOLATIONS, Trajectory, run

STEPS_PER_PERIOD = {1: 800, 2: 300, 3: 150, 4: 100, 5: 60, 6: 40}
"""Steps in the shortest period of a scene, by order of the method."""

FAR = 20.0
"""How many times faster than all else the turning of an orbit is where a run may never get near it:
a motor with hardly any damper takes long to its working speed."""

PLACES = 16
"""Places around a turn where its acceleration is looked at."""

STIFF = 0.5
"""Longest step times the fastest rate of a model's closure: a quarter of the stability limit of
explicit methods."""


@dataclass(frozen=True)
class Setup:
    """An engine's model of a case, with a method and its step.

    Attributes
    ----------
    engine : Adapter
    case : Case
    model : str
        One of the engine's models of the case's scene.
    method : Method or None
        None where nothing is integrated.
    step : float or None
        Step [s]; None for `default_step`.
    """

    engine: Adapter
    case: Case
    model: str
    method: Method | None = None
    step: float | None = None

    @property
    def scene(self) -> Scene:
        """The scene of the case."""
        return get_scene(self.case.scene)

    @property
    def integrator(self) -> Method:
        """The method, of a setup that integrates.

        Raises
        ------
        UsageError
            If it has none.
        """
        if self.method is None:
            raise UsageError(f"{self.engine.name} {self.model} was given no method to integrate by")
        return self.method

    @property
    def epsilon(self) -> float:
        """Distance from 1 to the next of the numbers that the method, or the engine, has."""
        own = self.method.precision if self.method else None
        return float(np.finfo(own or self.engine.precision).eps)

    @property
    def step_size(self) -> float:
        """Step [s]: the one that was set, or the default."""
        return self.default_step if self.step is None else self.step

    @cached_property
    def equations(self) -> ModelEquations:
        """The equations of motion that the model has."""
        equations = self.engine.model_equations(self.case, self.model)
        return scene_equations(self.case) if equations is None else equations

    @cached_property
    def discrete(self) -> ModelEquations | None:
        """The equations of the model's elements, where it has any and the engine tells them."""
        return self.engine.discrete_equations(self.case, self.model)

    @property
    def solved_equations(self) -> ModelEquations:
        """What runs converge to as steps are halved: its elements' equations, or the model's."""
        return self.discrete or self.equations

    @property
    def is_exact(self) -> bool:
        """Whether these are the equations of the scene."""
        return self.equations.is_exact_for(self.case)

    @cached_property
    def scheme(self) -> str | None:
        """The published scheme that the method is on this model, None if it is none."""
        return self.engine.scheme(self.case, self.model, self.integrator)

    @property
    def linear_scheme(self) -> str | None:
        """The scheme of `AMPLIFICATION` that the method is on free vibrations of the model."""
        if self.approximates_continuum:
            return None
        scheme = self.integrator.linear or self.integrator.scheme
        return scheme if scheme in AMPLIFICATION else None

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The coordinates in which the engine takes states and gives matrices."""
        return self.engine.coordinates(self.case, self.model)

    @property
    def integrates_drive(self) -> bool:
        """Whether the drive is a body of the model, integrated like the rest."""
        return self.engine.integrates_drive(self.case, self.model)

    @property
    def has_constraints(self) -> bool:
        """Whether constraints close loops of the model."""
        return self.engine.has_constraints(self.case, self.model)

    @property
    def has_soft_closure(self) -> bool:
        """Whether a constraint closes a loop of the model, and gives way."""
        return self.has_constraints and self.equations.scene is not self.scene

    @property
    def approximates_continuum(self) -> bool:
        """Whether the model converges to a continuum, and does not solve equations of its own."""
        scene = self.equations.scene
        return bool(scene.discretisation_coordinates) and self.coordinates != scene.coordinates

    @property
    def element_order(self) -> int:
        """The order of convergence with the number of elements, 0 without any."""
        return self.engine.element_order(self.case, self.model)

    @property
    def frequency_side(self) -> int:
        """On which side of the continuum the first frequency lies, 0 where none is known."""
        return self.engine.frequency_side(self.case, self.model)

    @property
    def observables(self) -> tuple[str, ...]:
        """What is compared of a run; closed loops also show how far they are open."""
        names = self.scene.observables
        return (*names, *VIOLATIONS) if self.has_constraints else names

    @cached_property
    def default_step(self) -> float:
        """A step [s] for the method: a power of two, so that no clock has to round."""
        return default_step(self.case, self.integrator, self.stable_step_bound)

    @cached_property
    def stable_step_bound(self) -> float:
        """The longest step [s] for the equations of a closure; a continuum sets none."""
        return stable_step_bound(self.case, self.equations)

    @property
    def why_not(self) -> str | None:
        """Why the engine cannot run this, or None."""
        fixed = self.engine.why_not_placed(self.case, self.model) if self.case.placement else None
        return fixed or self.engine.why_not(self.case, self.model, self.method)

    def with_case(self, case: Case) -> Setup:
        """Return the setup of another case."""
        return replace(self, case=case)

    def with_step(self, step: float) -> Setup:
        """Return the setup with a step [s]."""
        return replace(self, step=step)

    def with_option(self, name: str, value: float) -> Setup:
        """Return the setup with an option of its engine set."""
        return replace(self, engine=self.engine.with_option(name, value))

    def with_segments(self, factor: float) -> Setup:
        """Return the setup with so many times the segments of a continuum."""
        p = self.case.parameters
        segments = max(2, round(factor * p.segments))
        return self.with_case(replace(self.case, parameters=p.replace(segments=segments)))

    def simulate(self, step: float, samples: Any) -> Trajectory:
        """Run the engine with a step [s] and record it at these step numbers, see `run`."""
        return run(self.with_step(step), self.case.start_time + samples * step)

    def scheme_states(self, step: float, samples: Any, scheme: str | None = None) -> Array:
        """Return states (2 n, n_t) that a correct engine reaches by a scheme at step numbers.

        Parameters
        ----------
        step : float
            Step [s].
        samples : int array (n_t,)
        scheme : str, optional
            The method's own by default.
        """
        scheme = scheme or self.scheme
        if scheme is None:
            raise UsageError(f"{self.integrator.name} of {self.engine.name} is no published scheme")
        equations, case = self.equations, self.case
        scalar = schemes.ScalarEquations(
            equations.scene, equations.parameters, self.integrates_drive
        )
        start = equations.start(case)
        return schemes.integrate(scalar, scheme, start, step, samples, case.start_time)


def power_of_two(most: float) -> float:
    """Return the largest power of two that is not above a number; no clock has to round it."""
    return float(2.0 ** np.floor(np.log2(most)))


def default_step(case: Case, method: Method, bound: float = np.inf) -> float:
    """Return a step [s] for a method, not above a bound [s].

    It is a power of two, or where that would step over the end of a drive a fraction of the time
    until then.
    """
    order = min(method.order, max(STEPS_PER_PERIOD))
    step = power_of_two(min(shortest_period(case) / STEPS_PER_PERIOD[order], bound))
    end = float(get_scene(case.scene).drive_end_time(case.parameters)) - case.start_time
    return step if end <= 0 or end % step == 0 else end * power_of_two(step / end)


@lru_cache(maxsize=64)
def shortest_period(case: Case) -> float:
    """Return the shortest of the orbit's period and the natural periods [s]."""
    scene = get_scene(case.scene)
    whole = 2 * np.pi / float(scene.period(case.parameters))
    if scene.discretisation_coordinates:  # whose modes have no end
        return 2 * np.pi / whole
    omega: list[float] = []
    for place in scene.equilibria.values():
        try:
            state = scene.state(place(case.parameters))
        except NoOrbitError:
            continue
        mass, _, stiffness = linearise(scene, case.parameters, state)
        omega += [mode.omega for mode in modes(mass, 0 * mass, stiffness)]
    omega += [abs(case.state.get(f"{name}_dot", 0.0)) for name in scene.rotations_per_period]
    omega.append(scene.turning_speed(scene.state(case.state)))
    others = max(omega)
    if not scene.drive and whole > FAR * others > 0:
        whole = min(whole, max(others, reachable_speed(case)))
    return 2 * np.pi / max(whole, others)


def reachable_speed(case: Case) -> float:
    """Return what a motor may bring a coordinate to within the horizon of a case [rad/s].

    The largest acceleration at places all around, at the speed of the start, for the whole time.
    """
    scene = get_scene(case.scene)
    slopes, start = scene.right_hand_side(case.parameters), scene.state(case.state)
    n = len(scene.coordinates)
    turns = np.linspace(0, 2 * np.pi, PLACES, endpoint=False)
    states = np.array([np.concatenate([start[:n] + turn, start[n:]]) for turn in turns])
    faster = [np.max(np.abs(slopes(case.start_time, state)[n:])) for state in states]
    return float(np.max(np.abs(start[n:])) + max(faster) * case.horizon)


def stable_step_bound(case: Case, equations: ModelEquations) -> float:
    """Return the longest step [s] for the equations of a closure; a continuum sets none."""
    if equations.scene is get_scene(case.scene) or equations.scene.continuum.refined:
        return np.inf
    matrices = linearise(equations.scene, equations.parameters, equations.start(case))
    return STIFF / max(mode.omega for mode in modes(*matrices))

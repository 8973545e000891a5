"""A scene: equations of motion, knowledge of their motions, and the cases of a paper.

`Dynamics` is what solvers need. `EquationsOfMotion` adds rest states, orbits and invariants; a
model may have others than its scene. `Scene` adds the paper, its cases, and what runs are judged
by; there is one in each reference module.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .errors import ParameterError, UnknownNameError
from .parameters import BoundarySearch, Parameters
from .quaternions import Quaternion, product, spin
from .solve.kernel import RightHandSide, written_out

Array = NDArray[np.float64]


class Paper(NamedTuple):
    """Bibliographic data of a scene's source; ``url`` where it has no DOI."""

    authors: str
    title: str
    journal: str
    year: int
    doi: str
    url: str = ""


@dataclass(frozen=True)
class Case:
    """Parameters, an initial state and a horizon, under a name that explains itself.

    Attributes
    ----------
    scene, name : str
    parameters : Parameters
    state : mapping of str to float
        Initial values of coordinates (SI) and of their ``_dot``; absent ones are 0.
    horizon : float
        Time simulated [s].
    kinds : tuple of str
        The kinds of check that this case feeds.
    start_time : float
        Time at which the run starts [s]; shifts the phase of the drive.
    full_only : bool
        Left out of the default set of checks.
    watch : {"orbit", "outcome", "elements"}
        What the kind *stability* looks at: the periodic orbit, or what the run ends in
        (`Scene.outcome`); *order* looks at elements in place of steps.
    methods : {"all", "best"}
        Whether it is run with every method, or (the kind *order* apart) with the one of
        highest order of each model: others would take long, or hide the effect.
    about : str or None
        The equilibrium (of `EquationsOfMotion.equilibria`) that the kind *frequency* looks at,
        instead of ``state``.
    inconsistency : mapping of str to float
        By how much a model with more coordinates than the scene starts off them, on
        purpose: observable -> offset (SI).
    placement : str
        How models are placed in the world (`models.placement`); empty: as they stand.
    boundary : BoundarySearch or None
        What the kind *stability* seeks in place of the orbit; by default with the best method.
    """

    scene: str
    name: str
    parameters: Any
    state: Mapping[str, float] = field(default_factory=dict)
    horizon: float = 1.0
    kinds: tuple[str, ...] = ()
    start_time: float = 0.0
    full_only: bool = False
    watch: str = "orbit"
    methods: str = "all"
    about: str | None = None
    inconsistency: Mapping[str, float] = field(default_factory=dict)
    placement: str = ""
    boundary: BoundarySearch | None = None

    def __hash__(self) -> int:
        """Return a hash of what can be hashed: mappings of states cannot."""
        return hash((self.scene, self.name, self.placement, self.start_time))

    @property
    def label(self) -> str:
        """Its name in ids, with its placement."""
        return f"{self.name}+{self.placement.replace(':', '-')}" if self.placement else self.name


def case_maker(scene: str) -> Callable[..., Case]:
    """Return the function that makes cases of a scene, with their kinds last."""

    def case(
        name: str,
        parameters: Any,
        state: Mapping[str, float],
        horizon: float,
        *kinds: str,
        **others: Any,
    ) -> Case:
        return Case(scene, name, parameters, state, horizon, kinds, **others)

    return case


def with_placements(case: Case, *kinds: str) -> tuple[Case, ...]:
    """Return a case for models that are turned, and for mirror images, by the best method.

    The motion has been seen by then, so that of the mirror images a step is left.
    """
    one = replace(case, methods="best", full_only=False)
    return (
        replace(one, placement="turned:1", kinds=kinds),
        replace(one, placement="mirrored:2", kinds=("algebra", "step")),
    )


def coefficients_at(c: Any, rows: Any) -> Any:
    """Return the coefficients of some points; those that all points share stay as they are."""
    return type(c)(*(value[rows] if np.ndim(value) else value for value in c))


def with_rates(**units: str) -> dict[str, str]:
    """Return units of coordinates, and of their ``_dot``: m and m/s, 1 and 1/s."""
    return units | {f"{name}_dot": f"{unit}/s" for name, unit in units.items()}


@dataclass(frozen=True)
class Continuum:
    """Discretisation of a continuum.

    Attributes
    ----------
    discretisation_coordinates : tuple of str
        Coordinates that no one sets or compares.
    spectrum : callable ``(parameters, plane, count) -> (omega (count,), bound (count,))``, or None
        Natural frequencies [rad/s] about the state of rest or steady motion, with bounds.
    refined : EquationsOfMotion or None
        The same with more of these coordinates, by which the error of the reference is bounded.
    reach : callable ``(parameters) -> r`` [m]
        Largest distance from the origin of what outputs are displacements of, 0 without any.
    has_waves : bool
        Whether waves run through it many times from sample to sample, so that no linearised flow
        in between exists: the bound of a run is then its difference from another one.
    """

    discretisation_coordinates: tuple[str, ...] = ()
    spectrum: Callable[[Any, str, int], tuple[Array, Array]] | None = None
    refined: EquationsOfMotion | None = None
    reach: Callable[[Any], float] = lambda p: 0.0
    has_waves: bool = False


NO_CONTINUUM = Continuum()


class OrbitLimit(NamedTuple):
    """The least value of a parameter at which there is a periodic orbit.

    Attributes
    ----------
    value, error : float
        It, and a bound on its error.
    saddle : mapping of str to float, or None
        The state of rest on which the orbit ends; None where that vanishes at the same value.
    """

    value: float
    error: float
    saddle: Mapping[str, float] | None


@dataclass(frozen=True)
class PeriodicOrbit:
    """Starts of the search for a periodic orbit, and its quantities.

    Attributes
    ----------
    guesses : callable ``(parameters) -> list of states (2 n,)``
        Where to start the search; none where nothing drives the motion on.
    section_coordinate : str or None
        Without a drive: the coordinate that vanishes (modulo 2 pi) where a period begins.
    quantities : callable ``(states (2 n, k), c) -> {name: value}``
        From uniform samples of one period.
    units : mapping
        Their units; an angle in rad is compared on the circle.
    mirror : tuple of str
        Coordinates whose signs change in a symmetry: half a period of the drive later, and with
        what turns half a turn on, the equations of motion are the same. Empty without it.
    limit : (str, callable ``(parameters) -> OrbitLimit``), or None
        The parameter at whose least value the orbit ends on a saddle, and what solves for that.
    known : callable ``(parameters) -> (state (2 n,), period) or None``
        The orbit by another method, which the search then begins with; raises `NoOrbitError` where
        that method proves that there is none.
    """

    guesses: Callable[[Any], list[Array]] = lambda p: []
    section_coordinate: str | None = None
    quantities: Callable[..., dict[str, float]] = lambda states, c: {}
    units: Mapping[str, str] = field(default_factory=dict)
    mirror: tuple[str, ...] = ()
    limit: tuple[str, Callable[[Any], OrbitLimit]] | None = None
    known: Callable[[Any], tuple[Array, float] | None] = lambda p: None


@dataclass(frozen=True)
class RunQuantities:
    """Quantities of a run with a drive that ends, in addition to its samples.

    Attributes
    ----------
    evaluate : callable ``(times, {name: values}, parameters) -> {name: (value, gain)}``
        ``gain`` is what an error of the observables may be multiplied by in it.
    units : mapping
    """

    evaluate: Callable[..., dict[str, tuple[float, float]]]
    units: Mapping[str, str]


@dataclass(frozen=True, eq=False, kw_only=True)  # hashable: what is compiled for it is kept by it
class Dynamics:
    """The equations ``M(q) a = forces(u, q, v)`` with the drive ``u(t)``, as functions.

    ``c`` stands for the coefficients that `coefficients` derives from the parameters;
    each may be an array over parameter points, and ``q``, ``v`` then have shape
    ``(n, ...)``. ``xp`` is the module whose functions are used (NumPy, SymPy, heyoka).

    Attributes
    ----------
    name : str
    coordinates : tuple of str
        The generalised coordinates q; a state is (q, q_dot).
    units : mapping of observable or output to str
    coefficients : callable ``(parameters) -> c``
        A NamedTuple of numbers.
    mass_matrix : callable ``(q, c, xp) -> nested list (n, n)``
    forces : callable ``(u, q, v, c, xp) -> list (n,)``
        Generalised forces less the velocity-dependent inertia terms.
    accelerations : callable ``(u, q, v, c, xp) -> list (n,)``
        The same equations solved for a.
    damping_matrix : callable ``(c) -> array (n, n)``
        Linear joint damping alone.
    energy : callable ``(q, v, c) -> E``
        Kinetic plus potential energy [J].
    powers : callable ``(u, q, v, c) -> dict``
        Of each non-conservative force [W], none by default; they add up to dE/dt.
    drive : callable ``(t, c, xp) -> u``, or None
        The external input, harmonic with the circular frequency ``c.omega``.
    drive_end_time : callable ``(parameters) -> t`` [s]
        After which nothing drives it, and what the unforced motion conserves is constant.
    outputs : callable ``(q, v, c, xp) -> dict``
        What else follows from the state, by name.
    observed : tuple of str
        Outputs of every trajectory.
    stiff : (float, float) or None
        Tolerances of an implicit method, where modes that hardly move are much the fastest.
    continuum : Continuum
    quaternions : tuple of Quaternion
    eliminates : bool
        Whether accelerations come of eliminating a mass matrix of rounded sums.
    inexact_numbers : callable ``(c, change) -> iterator of c``
        Each with one number off by this share of its terms, as rounding of these leaves it.
    inexact_accelerations : callable ``change -> iterator of accelerations``
        Each with one product off by this share: where products balance, no number moves one alone.
    """

    name: str
    coordinates: tuple[str, ...]
    units: Mapping[str, str]
    coefficients: Callable[[Any], Any]
    mass_matrix: Callable[..., Any]
    forces: Callable[..., Any]
    accelerations: Callable[..., Any]
    damping_matrix: Callable[[Any], Array]
    energy: Callable[..., Any]
    powers: Callable[..., dict[str, Any]] = lambda u, q, v, c: {}
    drive: Callable[..., Any] | None = None
    drive_end_time: Callable[[Any], Any] = lambda p: 0.0
    outputs: Callable[..., dict[str, Any]] = lambda q, v, c, xp=np: {}
    observed: tuple[str, ...] = ()
    stiff: tuple[float, float] | None = None
    continuum: Continuum = NO_CONTINUUM
    quaternions: tuple[Quaternion, ...] = ()
    eliminates: bool = False
    inexact_numbers: Callable[[Any, float], Iterator[Any]] = lambda c, change: iter(())
    inexact_accelerations: Callable[[float], Iterator[Any]] = lambda change: iter(())

    @property
    def discretisation_coordinates(self) -> tuple[str, ...]:
        """Coordinates that stand for a continuum: no one sets or compares them."""
        return self.continuum.discretisation_coordinates

    @property
    def state_names(self) -> tuple[str, ...]:
        """Coordinates, then their rates."""
        return (*self.coordinates, *(f"{name}_dot" for name in self.coordinates))

    @property
    def observables(self) -> tuple[str, ...]:
        """Names in every trajectory: the states but quaternions, then the observed outputs."""
        hidden = {name for one in self.quaternions for name in one.coordinates}
        states = (name for name in self.public_states if name.removesuffix("_dot") not in hidden)
        return (*states, *self.observed)

    @property
    def initial_states(self) -> tuple[str, ...]:
        """Names that an initial state may have."""
        return (*self.public_states, *(name for one in self.quaternions for name in one.rates))

    def completed(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return all states by name: 0 where they are absent, of quaternions those of no rotation.

        Angular velocities become rates of quaternions. Other names are kept.
        """
        places = {one.coordinates[0]: 1.0 for one in self.quaternions}
        states = dict.fromkeys(self.state_names, 0.0) | places | dict(values)
        for one in self.quaternions:
            spin = [states.pop(name, None) for name in one.rates]
            if any(rate is not None for rate in spin):
                turn = [states[name] for name in one.coordinates]
                rates = product(turn, [0.0, *((rate or 0.0) / 2 for rate in spin)])
                states |= {f"{n}_dot": r for n, r in zip(one.coordinates, rates, strict=True)}
        return states

    @property
    def public(self) -> tuple[str, ...]:
        """Coordinates that are the scene's and not the reference's own."""
        hidden = {*self.discretisation_coordinates}
        return tuple(name for name in self.coordinates if name not in hidden)

    @property
    def public_states(self) -> tuple[str, ...]:
        """These coordinates, then their rates."""
        return (*self.public, *(f"{name}_dot" for name in self.public))

    def observe(self, states: Array, parameters: Any) -> dict[str, Any]:
        """Return states (2 n, ...) and all outputs by name."""
        q, v = np.split(np.asarray(states), 2)
        named = dict(zip(self.state_names, states, strict=True))
        return named | self.outputs(q, v, self.coefficients(parameters), np)

    def turning_speed(self, state: Array) -> float:
        """Return the largest angular speed [rad/s] that quaternions have in a state (2 n,)."""
        speeds = [0.0]
        for one in self.quaternions:
            places = [self.coordinates.index(name) for name in one.coordinates]
            q, rates = state[places], state[len(self.coordinates) + np.array(places)]
            speeds.append(2 * float(np.linalg.norm(spin(q, rates)[1:])))
        return max(speeds)

    def on_unit_quaternions(self, states: Array) -> Array:
        """Return states (k, 2 n) with quaternions of the length 1, which they keep."""
        states = np.array(states)
        for one in self.quaternions:
            places = np.array([self.coordinates.index(name) for name in one.coordinates])
            q = states[:, places] / np.linalg.norm(states[:, places], axis=1)[:, None]
            rates = states[:, len(self.coordinates) + places]
            states[:, places] = q
            rates = rates - np.sum(q * rates, axis=1)[:, None] * q
            states[:, len(self.coordinates) + places] = rates
        return states

    def state(self, values: Mapping[str, Any]) -> Array:
        """Return the state vector (2 n,) from values by name; see `completed` for absent ones.

        Raises
        ------
        UnknownNameError
            If a name is no state of this scene.
        ParameterError
            If a value is not finite, or a quaternion is far from a rotation's.
        """
        known = {*self.state_names, *self.initial_states}
        for name, value in values.items():
            if name not in known:
                raise UnknownNameError(f"state of {self.name}", name, self.state_names)
            try:
                finite = math.isfinite(value)
            except TypeError:
                finite = False
            if not finite:
                raise ParameterError(f"initial {name} must be a finite number, not {value!r}")
        states = self.completed(values)
        for one in self.quaternions:
            if not 1e-3 < (length := math.hypot(*(states[k] for k in one.coordinates))) < 1e3:
                raise ParameterError(
                    f"the quaternion {one.name} has the length {length:g}: one from 0.001 to 1000 "
                    "is brought to 1"
                )
        return np.array([float(states[name]) for name in self.state_names])

    def right_hand_side(self, parameters: Any) -> RightHandSide:
        """Return ``f(t, x) -> dx/dt`` for these parameters, x of shape (2 n, ...)."""
        return self.derivative(self.coefficients(parameters))

    def derivative(self, c: Any) -> RightHandSide:
        """Return ``f(t, x) -> dx/dt`` for these coefficients, x of shape (2 n, ...)."""
        rates, numbers = self._rates(c, partial(_accelerations, self, c)), None
        if all(np.ndim(value) == 0 for value in c):
            single = type(c)(*map(float, c))
            numbers = self._rates(single, scalar_accelerations(self, single))
        return RightHandSide(rates, numbers, self.continuum is NO_CONTINUUM)

    def _rates(self, c: Any, accelerations: Callable[..., Any]) -> Callable[..., Any]:
        """Return the accelerations ``(t, q, v, xp)``, from those of the drive."""

        def rates(t: Any, q: Any, v: Any, xp: Any) -> Any:
            u = self.drive(t, c, xp) if self.drive else 0.0
            return accelerations(u, q, v, xp)

        return rates


def _accelerations(dynamics: Dynamics, c: Any, u: Any, q: Any, v: Any, xp: Any) -> Any:
    return dynamics.accelerations(u, q, v, c, xp)


@lru_cache(maxsize=64)
def scalar_accelerations(dynamics: Dynamics, c: Any) -> Callable[..., Any]:
    """Return the accelerations ``(u, q, v, xp)`` of plain numbers, as the coefficients are.

    Their source code is made once; none is made of a continuum, whose matrices it cannot write.
    """
    accelerations = partial(_accelerations, dynamics, c)
    return written_out(accelerations) if dynamics.continuum is NO_CONTINUUM else accelerations


@dataclass(frozen=True, eq=False, kw_only=True)
class EquationsOfMotion(Dynamics):
    """Equations of motion with their parameters, equilibria and periodic orbits.

    Attributes
    ----------
    title : str
    parameters : type
    equilibria : mapping of name to ``(parameters) -> dict``
        Rest states of the unforced system, the first is the default of ``--about``.
        Raises `NoOrbitError` where these parameters have none of that name.
    period : callable ``(parameters) -> T`` [s]
        Of the drive; without one, a guess of the orbit's, or of the slowest motion's.
    rotations_per_period : mapping of name to int
        Turns that a coordinate makes in one period of the periodic orbit.
    steady_coordinates : mapping of name to tuple of str
        Equilibria -> coordinates that keep their speed there, and count as zero modes.
    orbit : PeriodicOrbit
    unforced : callable ``(parameters) -> parameters``
        Forces and motors switched off: what modes are found of.
    invariants : callable ``(parameters) -> {name: (q, v, c) -> value}``
        What is constant without forces and dampers.
    embedding : callable ``(parameters, {name: value}) -> {name: value}``
        State in these coordinates from that of the scene whose model has these equations.
    mistakes : mapping of str to EquationsOfMotion
        The same with a mistake that engines have been seen to make, by the words for it.
    """

    title: str
    parameters: type[Parameters]
    equilibria: Mapping[str, Callable[[Any], dict[str, float]]]
    period: Callable[[Any], Any]
    rotations_per_period: Mapping[str, int] = field(default_factory=dict)
    steady_coordinates: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    orbit: PeriodicOrbit = PeriodicOrbit()
    unforced: Callable[[Any], Any] = lambda p: p
    invariants: Callable[[Any], Mapping[str, Callable[..., Any]]] | None = None
    embedding: Callable[[Any, Mapping[str, float]], Mapping[str, float]] = lambda p, state: state
    mistakes: Mapping[str, EquationsOfMotion] = field(default_factory=dict)


@dataclass(frozen=True, eq=False, kw_only=True)
class Scene(EquationsOfMotion):
    """One mechanical system, independent of any engine.

    Attributes
    ----------
    paper : Paper
    cases : tuple of Case
    variants : mapping of str to EquationsOfMotion
        The paper's own simplifications, shown beside the exact equations; no engine is
        compared with them.
    constrained_initial_values : callable ``(parameters) -> {name: value}``
        Initial values of states that the parameters leave no choice of.
    run_quantities : RunQuantities or None
    outcome : callable ``(times, {name: values}, parameters) -> str``, or None
        In which of its long-term motions a run ends: ``undecided`` if the run is too short.
    assembled : callable ``({name: values}, parameters) -> bool array``, or None
        Whether the mechanism is put together as meant.
    drive_form : str
        What drives it as a function of time, with its phase; empty if nothing does.
    placed : tuple of Case
        Those of which the default set has models that are placed otherwise than they stand.
    """

    paper: Paper
    cases: tuple[Case, ...] = ()
    variants: Mapping[str, EquationsOfMotion] = field(default_factory=dict)
    constrained_initial_values: Callable[[Any], dict[str, float]] = lambda p: {}
    run_quantities: RunQuantities | None = None
    outcome: Callable[..., str] | None = None
    assembled: Callable[..., Any] | None = None
    drive_form: str = ""
    placed: tuple[Case, ...] = ()

    def case(self, name: str) -> Case:
        """Return the case of this name.

        Raises
        ------
        UnknownNameError
            If there is none.
        """
        for case in self.cases:
            if case.name == name:
                return case
        raise UnknownNameError(f"case of {self.name}", name, [case.name for case in self.cases])

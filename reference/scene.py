"""What a scene is: parameters, equations of motion, cases. One `Scene` per reference module."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from .errors import ParameterError, UnknownNameError

Array = NDArray[np.float64]

BOUNDS: Mapping[str, tuple[Callable[[Any], Any], str]] = {
    "positive": (lambda value: value > 0, "greater than 0"),
    "non-negative": (lambda value: value >= 0, "0 or greater"),
    "any": (lambda value: value == value, "a number"),
}


def quantity(
    default: float, symbol: str, unit: str, source: str, meaning: str, bound: str = "positive"
) -> Any:
    """Declare one field of a `Parameters` class, with what `mbcheck list` prints of it."""
    about = dict(symbol=symbol, unit=unit, source=source, meaning=meaning, bound=bound)
    return field(default=default, metadata=about)


def choice(options: tuple[str, ...], source: str, meaning: str) -> Any:
    """Declare a field that is one of some words, the first by default."""
    about = dict(symbol="", unit="", source=source, meaning=meaning, bound=" or ".join(options))
    return field(default=options[0], metadata={**about, "options": options})


@dataclass(frozen=True)
class Parameters:
    """Base of the scenes' parameters: frozen, validated, SI units.

    A field is a float; where many parameter points are solved at once it may be an
    array, and all arrays broadcast against each other.

    Raises
    ------
    ParameterError
        If a value is not finite or outside its bound.
    """

    def __post_init__(self) -> None:
        for item in dataclasses.fields(self):
            value = getattr(self, item.name)
            if "options" in item.metadata:
                if value not in item.metadata["options"]:
                    raise UnknownNameError(item.name, str(value), item.metadata["options"])
                continue
            try:
                number = np.array(value, dtype=float)
            except (TypeError, ValueError):
                raise ParameterError(f"{item.name} must be a number, not {value!r}") from None
            inside, words = BOUNDS[item.metadata["bound"]]
            if not np.all(np.isfinite(number)):
                raise ParameterError(f"{item.name} must be finite, not {value!r}")
            if not np.all(inside(number)):
                raise ParameterError(f"{item.name} must be {words}, not {value!r}")
            number.flags.writeable = False
            object.__setattr__(self, item.name, float(number) if number.ndim == 0 else number)
        self.validate()

    def validate(self) -> None:
        """Check what no single value tells; for scenes to override.

        Raises
        ------
        ParameterError
            If the values contradict each other.
        """

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Names of the parameters, in order."""
        return tuple(item.name for item in dataclasses.fields(cls))

    @classmethod
    def choices(cls) -> dict[str, tuple[str, ...]]:
        """Words that a parameter may be, of those that are no number."""
        fields = dataclasses.fields(cls)
        return {f.name: f.metadata["options"] for f in fields if "options" in f.metadata}

    def replace(self, **changes: Any) -> Self:
        """Return a copy with some values changed.

        Raises
        ------
        UnknownNameError
            If a name is no parameter of this scene.
        ParameterError
            If a value is impossible.
        """
        for name in changes:
            if name not in self.names():
                raise UnknownNameError("parameter", name, self.names())
        return dataclasses.replace(self, **changes)

    def as_dict(self) -> dict[str, Any]:
        """Return the values by name, in SI units."""
        return dataclasses.asdict(self)


class Paper(NamedTuple):
    """Bibliographic data of a scene's source."""

    authors: str
    title: str
    journal: str
    year: int
    doi: str


@dataclass(frozen=True)
class Case:
    """Parameters, an initial state and a horizon, under a name that explains itself.

    Attributes
    ----------
    scene, name : str
    parameters : Parameters
    state : mapping of str to float
        Initial values of coordinates (SI) and of their ``_dot``; what is absent is 0.
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
        highest order of each model: others would take long, or hide what is to be seen.
    about : str or None
        The equilibrium (of `Scene.equilibria`) that the kind *frequency* looks at, instead
        of ``state``.
    inconsistency : mapping of str to float
        By how much a model with more coordinates than the scene starts off them, on
        purpose: observable -> offset (SI).
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


def coefficients_at(c: Any, rows: Any) -> Any:
    """Return the coefficients of some points; those that all points share stay as they are."""
    return type(c)(*(value[rows] if np.ndim(value) else value for value in c))


def no_outputs(q: Any, v: Any, c: Any, xp: Any = np) -> dict[str, Any]:
    """Return nothing: the states say it all."""
    return {}


def as_they_are(p: Any, values: Mapping[str, float]) -> Mapping[str, float]:
    """Return the values of the states: they are the model's own."""
    return values


@dataclass(frozen=True, eq=False)  # hashable: what is compiled for a scene is kept by it
class Scene:
    """One mechanical system: everything that is true of it, and no engine.

    The equations of motion are ``M(q) a = forces(u, q, v)`` with the drive ``u(t)``.
    ``c`` stands for the coefficients that `coefficients` derives from the parameters;
    each may be an array over parameter points, and ``q``, ``v`` then have shape
    ``(n, ...)``. ``xp`` is the module whose functions are used (NumPy, SymPy, heyoka).

    Attributes
    ----------
    coordinates : tuple of str
        Names of the generalised coordinates q; a state is (q, q_dot).
    units : mapping
        Unit of each observable, and of each output.
    coefficients : callable ``(parameters) -> c``
        A NamedTuple of numbers.
    drive : callable ``(t, c, xp) -> u``, or None
        The external input, harmonic with the circular frequency ``c.omega``.
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
        Power [W] of each non-conservative force; they add up to dE/dt.
    equilibria : mapping of name to ``(parameters) -> dict``
        Rest states of the unforced system, the first is the default of ``--about``.
        Raises `NoOrbitError` where these parameters have none of that name.
    turning : mapping of name to int
        Turns that a coordinate makes in one period of the periodic orbit.
    period : callable ``(parameters) -> T`` [s]
        Of the drive; without one, a guess of the orbit's.
    orbit_guesses : callable ``(parameters) -> list of states (2 n,)``
        Where to start the search for the periodic orbit.
    cases : tuple of Case
    section : str or None
        Without a drive: the coordinate that is 0 (modulo 2 pi) where a period begins.
    unforced : callable ``(parameters) -> parameters``
        Forces and motors switched off: what modes are found of.
    held : mapping of name to tuple of str
        Equilibria -> coordinates that keep their speed there, and count as zero modes.
    given : callable ``(parameters) -> {name: value}``
        Initial values of states that the parameters leave no choice of.
    outputs : callable ``(q, v, c, xp) -> dict``
        What else follows from the state, by name.
    observed : tuple of str
        Outputs that every trajectory shows; the others come on request.
    invariants : callable ``(parameters) -> {name: (q, v, c) -> value}``
        What is constant without forces and dampers.
    orbit_quantities : callable ``(states (2 n, k), c) -> {name: value}``
        What the periodic orbit is measured by, from uniform samples of one period.
    orbit_units : mapping
        Their units; an angle in rad is compared on the circle.
    run_quantities : callable ``(times, {name: values}, parameters) -> {name: (value, gain)}``
        What a run of a drive that ends is judged by beside its samples; ``gain`` is what an
        error of the observables may be multiplied by in it.
    run_units : mapping
        Their units.
    outcome : callable ``(times, {name: values}, parameters) -> str``, or None
        In which of its long-term motions a run ends: ``undecided`` if that cannot be told.
    assembled : callable ``({name: values}, parameters) -> bool array``, or None
        Whether the mechanism is put together as meant.
    embedding : callable ``(parameters, {name: value}) -> {name: value}``
        State in this scene's own coordinates from that of the scene it stands for.
    stiff : (float, float) or None
        Where modes that hardly move are much faster than the others: the tolerances with
        which `solve` takes an implicit method.
    internal : tuple of str
        Coordinates that stand for what is continuous: no one sets or compares them.
    spectrum : callable ``(parameters, plane, count) -> (omega (count,), bound (count,))``, or None
        Natural frequencies [rad/s] of a continuum about its state of rest or steady motion.
    driven_until : callable ``(parameters) -> t`` [s]
        After which nothing drives the scene; `invariants` of `unforced` hold from there.
    finer : Scene or None
        The same with more of these, by which the error of the reference is bounded.
    variants : mapping of str to Scene
        The paper's own simplifications, shown beside the exact equations; no engine is
        held against them.
    """

    name: str
    title: str
    paper: Paper
    parameters: type[Parameters]
    coordinates: tuple[str, ...]
    units: Mapping[str, str]
    coefficients: Callable[[Any], Any]
    mass_matrix: Callable[..., Any]
    forces: Callable[..., Any]
    accelerations: Callable[..., Any]
    damping_matrix: Callable[[Any], Array]
    energy: Callable[..., Any]
    powers: Callable[..., dict[str, Any]]
    equilibria: Mapping[str, Callable[[Any], dict[str, float]]]
    turning: Mapping[str, int]
    period: Callable[[Any], Any]
    orbit_guesses: Callable[[Any], list[Array]]
    cases: tuple[Case, ...] = ()
    drive: Callable[..., Any] | None = None
    section: str | None = None
    unforced: Callable[[Any], Any] = lambda p: p
    held: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    given: Callable[[Any], dict[str, float]] = lambda p: {}
    outputs: Callable[..., dict[str, Any]] = no_outputs
    observed: tuple[str, ...] = ()
    invariants: Callable[[Any], Mapping[str, Callable[..., Any]]] | None = None
    orbit_quantities: Callable[..., dict[str, float]] = lambda states, c: {}
    orbit_units: Mapping[str, str] = field(default_factory=dict)
    run_quantities: Callable[..., dict[str, tuple[float, float]]] | None = None
    run_units: Mapping[str, str] = field(default_factory=dict)
    outcome: Callable[..., str] | None = None
    assembled: Callable[..., Any] | None = None
    embedding: Callable[[Any, Mapping[str, float]], Mapping[str, float]] = as_they_are
    stiff: tuple[float, float] | None = None
    internal: tuple[str, ...] = ()
    spectrum: Callable[[Any, str, int], tuple[Array, Array]] | None = None
    driven_until: Callable[[Any], float] = lambda p: 0.0
    finer: Scene | None = None
    variants: Mapping[str, Scene] = field(default_factory=dict)

    @property
    def state_names(self) -> tuple[str, ...]:
        """Coordinates, then their rates."""
        return (*self.coordinates, *(f"{name}_dot" for name in self.coordinates))

    @property
    def observables(self) -> tuple[str, ...]:
        """What every trajectory shows: the states, then the observed outputs."""
        return (*self.public_states, *self.observed)

    @property
    def public(self) -> tuple[str, ...]:
        """Coordinates that are the scene's and not the reference's own."""
        return tuple(name for name in self.coordinates if name not in self.internal)

    @property
    def public_states(self) -> tuple[str, ...]:
        """These coordinates, then their rates."""
        return (*self.public, *(f"{name}_dot" for name in self.public))

    def observe(self, states: Array, parameters: Any) -> dict[str, Any]:
        """Return states (2 n, ...) and all outputs by name."""
        q, v = np.split(np.asarray(states), 2)
        found = dict(zip(self.state_names, states, strict=True))
        return found | self.outputs(q, v, self.coefficients(parameters), np)

    def state(self, values: Mapping[str, Any]) -> Array:
        """Return the state vector (2 n,) from values by name; what is absent is 0.

        Raises
        ------
        UnknownNameError
            If a name is no state of this scene.
        ParameterError
            If a value is not finite.
        """
        for name, value in values.items():
            if name not in self.state_names:
                raise UnknownNameError(f"state of {self.name}", name, self.state_names)
            try:
                finite = math.isfinite(value)
            except TypeError:
                finite = False
            if not finite:
                raise ParameterError(f"initial {name} must be a finite number, not {value!r}")
        return np.array([float(values.get(name, 0.0)) for name in self.state_names])

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

    def right_hand_side(self, parameters: Any) -> Callable[[Any, Any], Any]:
        """Return ``f(t, x) -> dx/dt`` for these parameters, x of shape (2 n, ...)."""
        return self.derivative(self.coefficients(parameters))

    def derivative(self, c: Any) -> Callable[[Any, Any], Any]:
        """Return ``f(t, x) -> dx/dt`` for these coefficients, x of shape (2 n, ...)."""
        n = len(self.coordinates)
        single = all(np.ndim(value) == 0 for value in c)
        numbers = type(c)(*(float(value) for value in c)) if single else c

        def right_hand_side(t: Any, x: Any) -> Any:
            if single and x.ndim == 1 and x.dtype == float:
                return one(float(t), x.tolist())
            u = self.drive(t, c, np) if self.drive else 0.0
            out = np.empty_like(x)
            out[:n] = x[n:]
            for row, value in enumerate(self.accelerations(u, x[:n], x[n:], c, np)):
                out[n + row] = value
            return out

        def one(t: float, x: list[float]) -> Array:
            """Return the same of a single state, with plain floats: several times faster."""
            try:
                u = self.drive(t, numbers, math) if self.drive else 0.0
                a = self.accelerations(u, x[:n], x[n:], numbers, math)
            except (OverflowError, ValueError, ZeroDivisionError):  # NumPy gives inf or nan
                a = [math.nan] * n
            return np.array([*x[n:], *a], dtype=float)

        return right_hand_side

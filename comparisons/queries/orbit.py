"""``orbit``: the periodic orbit of a scene, by the reference or by an engine."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...reference import get_scene
from ...reference.bounds.orbits import orbit_bounds
from ...reference.cost import keep_steps
from ...reference.errors import UsageError
from ...reference.orbits import Orbit, find_orbit, mean_powers, orbit_samples
from ...reference.periodic import Harmonic, harmonics
from ...reference.scene import Array
from ..checks.orbits import find_engine_orbit
from ..documents import document
from ..documents.fields import documented, takes_fields_of
from ..engines.registry import REFERENCE
from ..engines.setup import Setup, shortest_period
from .query import Origin, by_state, described, floats, seconds_of_a_step
from .request import MethodQuery

MOST_PERIODS = 10_000
"""Most periods of the fastest motion in one of the orbit; more would take hours."""

RUNS = 20
"""Approximate number of runs over a period that find an engine's orbit."""


@dataclass(frozen=True)
class Multiplier:
    """A Floquet multiplier of an orbit.

    Attributes
    ----------
    re, im : float
        real and imaginary part [1]
    trivial : bool
        whether it is the 1 of a shift in time, which one is where nothing drives it
    error_bound : float or None
        bound on its error in the complex plane [1]; null for an engine
    """

    re: float
    im: float
    trivial: bool
    error_bound: float | None

    @property
    @documented
    def modulus(self) -> float:
        """Modulus [1]; below 1 the perturbation decays."""
        return abs(complex(self.re, self.im))


@dataclass(frozen=True)
class OrbitSpectrum:
    """The Fourier series of an observable over a period of an orbit.

    Attributes
    ----------
    mean : float
        in the unit of the observable
    terms : tuple of Harmonic
        ascending in order
    error_bound : float or None
        bound on the error of `mean`, and of the complex amplitude of each term; null for an engine
    """

    mean: float
    terms: tuple[Harmonic, ...]
    error_bound: float | None


@dataclass(frozen=True)
class OrbitQuantity:
    """Another measure of the orbit of a scene.

    Attributes
    ----------
    value : float
        in `unit`
    unit : str
        its unit
    error_bound : float or None
        bound on the error of `value`; null for an engine
    """

    value: float
    unit: str
    error_bound: float | None


@dataclass(frozen=True)
class OrbitReport(Origin):
    """The periodic orbit of a scene.

    Attributes
    ----------
    step : float or None
        fixed step [s], a whole fraction of the period; null for the reference
    period : float
        period [s]
    period_bound : float or None
        bound on the error of `period` [s]; null for an engine
    state : mapping of str to float
        where the period begins, angles that turn in [0, 2 pi) [SI]: t = 0 modulo the period of the
        drive, or where the first angle that turns is 0
    floquet_multipliers : tuple of Multiplier
        eigenvalues of the monodromy matrix, descending in modulus
    harmonics : mapping of str to OrbitSpectrum
        Fourier series of each observable without its secular part: mean + sum of amplitude
        cos(order Omega t + phase), Omega = 2 pi / period
    power : mapping of str to float
        mean power of each non-conservative force [W]; their sum is 0
    power_bound : mapping of str to float, or None
        bound on the error of each `power` [W]; null for an engine
    quantities : mapping of str to OrbitQuantity
        further measures of the scene's orbit, see below
    error_bound : mapping of str to float, or None
        bound on the error of `state` [SI]; null for an engine
    """

    method: str
    step: float | None
    period: float
    period_bound: float | None
    state: Mapping[str, float]
    floquet_multipliers: tuple[Multiplier, ...]
    harmonics: Mapping[str, OrbitSpectrum]
    power: Mapping[str, float]
    power_bound: Mapping[str, float] | None
    quantities: Mapping[str, OrbitQuantity]
    error_bound: Mapping[str, float] | None

    @property
    @documented
    def mean_speed(self) -> float | None:
        """Mean speed of the coordinate that turns [rad/s]; null where none turns."""
        turns = next(iter(get_scene(self.scene).rotations_per_period.values()), None)
        return None if turns is None else 2 * math.pi * turns / self.period

    @property
    @documented
    def mean_speed_bound(self) -> float | None:
        """Bound on the error of `mean_speed` [rad/s]; null for an engine."""
        speed, bound = self.mean_speed, self.period_bound
        return None if speed is None or bound is None else speed * bound / self.period

    @property
    @documented
    def stable(self) -> bool:
        """True if every multiplier but the `trivial` one lies inside the unit circle."""
        return all(one.trivial or one.modulus < 1 for one in self.floquet_multipliers)

    def as_json(self) -> dict[str, Any]:
        """Return the ``orbit`` document of docs/json.md."""
        return document("orbit", self)


@takes_fields_of(MethodQuery)
def orbit(asked: MethodQuery) -> OrbitReport:
    """Find a periodic orbit, a stable one if the search finds one; takes a `MethodQuery`.

    Several may coexist: `mbcheck.reference.orbits.find_orbit` has the order of the search.

    An engine's orbit is that of its own discrete flow: where it closes after a whole
    number of steps.

    Raises
    ------
    NoOrbitError
        If there is none.
    UsageError
        For unknown names, impossible values, or a step that does not divide the period.
    EngineError
        If the engine failed.
    """
    return find(asked)


def find(query: MethodQuery, bounded: bool = True) -> OrbitReport:
    """Find a periodic orbit; bounds double the time."""
    setup = query.setup()
    if setup.engine.name == REFERENCE:
        period = float(setup.scene.period(setup.case.parameters))
        periods = period / shortest_period(setup.case)
        if not periods <= MOST_PERIODS:
            raise UsageError(
                f"the fastest motion here has {periods:.2g} periods in one of {period:.2g} s, and "
                f"the reference follows {MOST_PERIODS}: choose other parameters"
            )
        exact = find_orbit(*setup.bound.equations)
        return orbit_report(setup, exact, orbit_samples(*setup.bound.equations, exact), bounded)
    if setup.step is not None:
        steps = RUNS * float(setup.scene.period(setup.case.parameters)) / setup.step
        keep_steps(steps, lambda: seconds_of_a_step(setup))
    own = find_engine_orbit(setup)
    closed = Orbit(own.period, own.state, own.multipliers, own.monodromy, own.trivial)
    return orbit_report(setup.with_step(own.step), closed, own.samples, bounded=False)


def orbit_report(setup: Setup, orbit: Orbit, samples: Array, bounded: bool) -> OrbitReport:
    """Return an orbit with its harmonics and powers, from uniform samples (2 n, k)."""
    scene, parameters = setup.scene, setup.case.parameters
    c = scene.coefficients(parameters)
    quantities = scene.orbit.quantities(samples, c)
    error = orbit_bounds(*setup.bound.equations, orbit) if bounded else None
    bounds = {} if error is None else by_state(scene, error.harmonics)
    return OrbitReport(
        **described(setup),
        method=setup.integrator.name,
        step=setup.step,
        period=orbit.period,
        period_bound=None if error is None else error.period,
        state=floats(by_state(scene, orbit.state)),
        floquet_multipliers=tuple(
            Multiplier(
                float(value.real),
                float(value.imag),
                i == orbit.trivial,
                None if error is None else float(error.multipliers[i]),
            )
            for i, value in enumerate(orbit.multipliers)
        ),
        harmonics={
            name: OrbitSpectrum(
                *harmonics(values, scene.rotations_per_period.get(name, 0)),
                None if error is None else float(bounds[name]),
            )
            for name, values in by_state(scene, samples).items()
        },
        power=mean_powers(scene, samples, c, orbit.period),
        power_bound=None if error is None else error.power,
        quantities={
            name: OrbitQuantity(
                float(value),
                scene.orbit.units[name],
                None if error is None else error.quantities[name],
            )
            for name, value in quantities.items()
        },
        error_bound=None if error is None else floats(by_state(scene, error.state)),
    )

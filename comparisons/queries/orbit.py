"""``orbit``: the periodic orbit of a scene, by the reference or by an engine."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...reference import get_scene
from ...reference.bounds.orbits import orbit_bounds
from ...reference.cost import keep_steps
from ...reference.errors import UsageError
from ...reference.orbits import Orbit, find_orbit, mean_powers, orbit_samples
from ...reference.periodic import Harmonic, harmonics
from ...reference.scene import Array
from ..checks.orbits import find_engine_orbit
from ..documents import document
from ..engines.registry import REFERENCE
from ..engines.setup import Setup, shortest_period
from .query import Origin, Query, by_state, described, floats, seconds_of_a_step

MOST_PERIODS = 10_000
"""Periods of the fastest motion in one of the orbit; more take hours, and more than its steps."""

RUNS = 20
"""Runs over a period, about so many of which find an engine's orbit."""


@dataclass(frozen=True)
class Bounds:
    """Bounds on the errors of a periodic orbit, beside that of its state.

    Attributes
    ----------
    period : float [s]
    multipliers : tuple of float
        Of each multiplier in the complex plane.
    harmonics : mapping of str to float
        Of each observable's mean, and of the complex amplitude of each of its terms.
    power, quantities : mapping of str to float
    """

    period: float
    multipliers: tuple[float, ...]
    harmonics: Mapping[str, float]
    power: Mapping[str, float]
    quantities: Mapping[str, float]


@dataclass(frozen=True)
class OrbitReport(Origin):
    """The periodic orbit of a scene.

    Attributes
    ----------
    scene, engine, method, model : str
    step : float or None
        Fixed step [s], a whole fraction of the period; None for the reference.
    parameters : mapping of str to float or str
    period : float [s]
    state : mapping of str to float
        Where the period begins (t = 0 modulo the drive's period, or the scene's section),
        turning coordinates in [0, 2 pi).
    floquet_multipliers : tuple of complex
        Descending in modulus.
    trivial_multiplier : int or None
        Which of them is 1 because nothing drives the scene, so that time may shift.
    harmonics : mapping of str to (mean, terms)
        Of each observable, its secular part removed: mean + sum of
        ``amplitude cos(order Omega t + phase)``.
    power : mapping of str to float
        Mean power of each non-conservative force [W].
    quantities : mapping of str to (value, unit)
        What else the scene's orbit is measured by.
    error_bound : mapping of str to float, or None
        Bound on the error of ``state``; None for engines.
    bounds : Bounds or None
        On the errors of all else; None for engines.
    versions : mapping of str to str
    """

    method: str
    step: float | None
    period: float
    state: Mapping[str, float]
    floquet_multipliers: tuple[complex, ...]
    trivial_multiplier: int | None
    harmonics: Mapping[str, tuple[float, tuple[Harmonic, ...]]]
    power: Mapping[str, float]
    quantities: Mapping[str, tuple[float, str]]
    error_bound: Mapping[str, float] | None
    bounds: Bounds | None

    @property
    def mean_speed(self) -> float | None:
        """Mean speed of the coordinate that turns [rad/s]; None where none does."""
        turns = next(iter(get_scene(self.scene).rotations_per_period.values()), None)
        return None if turns is None else 2 * math.pi * turns / self.period

    @property
    def stable(self) -> bool:
        """Whether every multiplier but the trivial one lies inside the unit circle."""
        others = (
            value
            for i, value in enumerate(self.floquet_multipliers)
            if i != self.trivial_multiplier
        )
        return all(abs(value) < 1 for value in others)

    def as_json(self) -> dict[str, Any]:
        """Return the ``orbit`` document of docs/json.md."""
        bounds, speed = self.bounds, self.mean_speed
        multipliers = [
            {
                "re": value.real,
                "im": value.imag,
                "modulus": abs(value),
                "trivial": i == self.trivial_multiplier,
                "error_bound": bounds and bounds.multipliers[i],
            }
            for i, value in enumerate(self.floquet_multipliers)
        ]
        quantities = {
            name: {
                "value": value,
                "unit": unit,
                "error_bound": bounds and bounds.quantities[name],
            }
            for name, (value, unit) in self.quantities.items()
        }
        spectra = {
            name: {"mean": mean, "terms": terms, "error_bound": bounds and bounds.harmonics[name]}
            for name, (mean, terms) in self.harmonics.items()
        }
        return document(
            "orbit",
            self,
            floquet_multipliers=multipliers,
            harmonics=spectra,
            quantities=quantities,
            mean_speed=speed,
            stable=self.stable,
            period_bound=bounds and bounds.period,
            mean_speed_bound=bounds and speed and speed * bounds.period / self.period,
            power_bound=bounds and bounds.power,
        )


def orbit(
    scene: str,
    parameters: Mapping[str, Any] | None = None,
    engine: str = REFERENCE,
    method: str | None = None,
    step: float | None = None,
    model: str | None = None,
) -> OrbitReport:
    """Find the periodic orbit, a stable one where there is a choice.

    An engine's orbit is that of its own discrete flow: where it closes after a whole
    number of steps.

    Parameters
    ----------
    scene : str
    parameters : mapping of str to float, optional
    engine, method, model : str, optional
    step : float, optional
        Step [s] that divides the period; the reference takes none.

    Raises
    ------
    NoOrbitError
        If there is none.
    UsageError
        For unknown names, impossible values, or a step that does not divide the period.
    EngineError
        If the engine failed.
    """
    return find(Query(scene, engine, model, method, step, parameters))


def find(query: Query, bounded: bool = True) -> OrbitReport:
    """Find the periodic orbit that is asked for; bounds cost about as much again."""
    setup = query.setup()
    if setup.engine.name == REFERENCE:
        refuse_stiff(setup)
        exact = find_orbit(*setup.equations)
        return orbit_report(setup, exact, orbit_samples(*setup.equations, exact), bounded)
    if setup.step is not None:
        steps = RUNS * float(setup.scene.period(setup.case.parameters)) / setup.step
        keep_steps(steps, lambda: seconds_of_a_step(setup))
    own = find_engine_orbit(setup)
    unknown = np.full(len(own.state), np.nan)
    closed = Orbit(own.period, own.state, own.multipliers, own.monodromy, unknown, own.trivial)
    return orbit_report(setup.with_step(own.step), closed, own.samples, bounded=False)


def refuse_stiff(setup: Setup) -> None:
    """Refuse an orbit with more of the fastest motion in it than the reference's steps resolve.

    Raises
    ------
    UsageError
        With their number.
    """
    period = float(setup.scene.period(setup.case.parameters))
    periods = period / shortest_period(setup.case)
    if not periods <= MOST_PERIODS:
        raise UsageError(
            f"the fastest motion here has {periods:.2g} periods in one of {period:.2g} s, and the "
            f"reference follows {MOST_PERIODS}: choose other parameters"
        )


def orbit_report(setup: Setup, orbit: Orbit, samples: Array, bounded: bool) -> OrbitReport:
    """Return an orbit with its harmonics and powers, from uniform samples (2 n, k)."""
    scene, parameters = setup.scene, setup.case.parameters
    c = scene.coefficients(parameters)
    quantities = scene.orbit.quantities(samples, c)
    error = orbit_bounds(*setup.equations, orbit) if bounded else None
    return OrbitReport(
        **described(setup),
        method=setup.integrator.name,
        step=setup.step,
        period=orbit.period,
        state=floats(by_state(scene, orbit.state)),
        floquet_multipliers=tuple(complex(value) for value in orbit.multipliers),
        trivial_multiplier=orbit.trivial,
        harmonics={
            name: harmonics(values, scene.rotations_per_period.get(name, 0))
            for name, values in by_state(scene, samples).items()
        },
        power=mean_powers(scene, samples, c, orbit.period),
        quantities={
            name: (float(value), scene.orbit.units[name]) for name, value in quantities.items()
        },
        error_bound=None if error is None else floats(by_state(scene, error.state)),
        bounds=None
        if error is None
        else Bounds(
            period=error.period,
            multipliers=tuple(map(float, error.multipliers)),
            harmonics=floats(by_state(scene, error.harmonics)),
            power=error.power,
            quantities=error.quantities,
        ),
    )

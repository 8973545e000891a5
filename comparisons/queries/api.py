"""What a user asks of mbcheck, as functions: check, simulate, orbit, frequencies."""

from __future__ import annotations

import math
import platform
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from time import perf_counter
from typing import Any, TypeVar

import numpy as np

from ...models import mjcf
from ...reference import get_scene
from ...reference.errors import (
    EngineError,
    MbcheckError,
    ParameterError,
    UnknownNameError,
    UsageError,
)
from ...reference.linear import Mode, modes
from ...reference.orbits import Harmonic, Orbit, find_orbit, harmonics, mean_powers, orbit_samples
from ...reference.scene import Array, Case, Scene
from ...reference.solve.single import solve
from ...reference.solve.solution import Solution, sample_times
from ..checks import known, suite
from ..checks.kinds import elements
from ..checks.kinds.frequency import resting
from ..checks.orbits import find_engine_orbit
from ..checks.rules import Caution, cautions, explained
from ..checks.truth import truncated, truth_of
from ..checks.verdict import PROFILES, Result
from ..engines.adapter import Adapter
from ..engines.equations import ModelEquations
from ..engines.protocol import Method
from ..engines.reference import ReferenceEngine
from ..engines.registry import checked_engines, get_engine
from ..engines.run import VIOLATIONS, Console, contained, describe, grid_indices, run
from ..engines.setup import Setup
from ..reports import report

REFERENCE = "reference"

SHORTEST_STEP = 1 / 1024
"""Of the default step: times that need a shorter one share no spacing to speak of."""

MOST_STEPS = 10**8
"""More, by default, would take hours; a step that the user chose may take them."""

CONSISTENT = 1e-9
"""How close an initial value that follows from others must be to what follows (SI)."""

VIOLATION_UNITS = dict(zip(VIOLATIONS, ("m", "m/s"), strict=True))

RATIONAL = 8 * float(np.finfo(float).eps)
"""Relative distance within which a time is taken for a rational number."""


# What is returned


@dataclass(frozen=True)
class Simulation:
    """A trajectory, and all that is needed to repeat it.

    Attributes
    ----------
    scene, engine, method, model : str
    step : float or None
        Fixed step [s]; None for the reference, whose error control chooses its steps.
    parameters : mapping of str to float
        All of the scene's, SI units.
    times : array (n_t,)
        Sample times [s].
    observables : mapping of str to array (n_t,)
    units : mapping of str to str
        Of the observables.
    error_bound : mapping of str to float, or None
        Bound on the error of each observable, the largest over the times; None for
        engines, which state none.
    work : mapping
        ``steps``, ``rhs_evaluations`` (None if unknown), ``seconds``.
    versions : mapping of str to str
    cautions : tuple of Caution
        What rules say of the run from its case, model, method and step alone; none of the
        reference.
    """

    scene: str
    engine: str
    method: str
    model: str
    step: float | None
    parameters: Mapping[str, Any]
    times: Array
    observables: Mapping[str, Array]
    units: Mapping[str, str]
    error_bound: Mapping[str, float] | None
    work: Mapping[str, float | None]
    versions: Mapping[str, str]
    cautions: tuple[Caution, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """Return the ``simulate`` document of docs/json.md."""
        return document(self, cautions=[vars(item) for item in self.cautions])


@dataclass(frozen=True)
class OrbitReport:
    """The periodic orbit of a scene.

    Attributes
    ----------
    scene, engine, method, model : str
    step : float or None
        Fixed step [s], a whole fraction of the period; None for the reference.
    parameters : mapping of str to float
    period : float [s]
    state : mapping of str to float
        Where the period begins (t = 0 modulo the drive's period, or the scene's section),
        turning coordinates in [0, 2 pi).
    mean_speed : float or None
        Of the coordinate that turns [rad/s]; None where none does.
    stable : bool
        True if every multiplier but the trivial one lies inside the unit circle.
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
    versions : mapping of str to str
    """

    scene: str
    engine: str
    method: str
    model: str
    step: float | None
    parameters: Mapping[str, Any]
    period: float
    state: Mapping[str, float]
    mean_speed: float | None
    stable: bool
    floquet_multipliers: tuple[complex, ...]
    trivial_multiplier: int | None
    harmonics: Mapping[str, tuple[float, tuple[Harmonic, ...]]]
    power: Mapping[str, float]
    quantities: Mapping[str, tuple[float, str]]
    error_bound: Mapping[str, float] | None
    versions: Mapping[str, str]

    def as_json(self) -> dict[str, Any]:
        """Return the ``orbit`` document of docs/json.md."""
        multipliers = [
            {
                "re": value.real,
                "im": value.imag,
                "modulus": abs(value),
                "trivial": i == self.trivial_multiplier,
            }
            for i, value in enumerate(self.floquet_multipliers)
        ]
        quantities = {
            name: {"value": value, "unit": unit} for name, (value, unit) in self.quantities.items()
        }
        spectra = {
            name: {"mean": mean, "terms": [vars(term) for term in terms]}
            for name, (mean, terms) in self.harmonics.items()
        }
        found = document(
            self, floquet_multipliers=multipliers, harmonics=spectra, quantities=quantities
        )
        del found["trivial_multiplier"]
        return found


@dataclass(frozen=True)
class Frequencies:
    """The modes about a state of rest, forces and motors switched off.

    Attributes
    ----------
    scene, engine, model : str
    parameters : mapping of str to float
    undamped : bool
        True if damping was left out.
    about : str
        Name of the state of rest.
    plane : str or None
        In which a continuum vibrates.
    state : mapping of str to float
    modes : tuple of Mode
        Ascending in omega, zero modes listed.
    versions : mapping of str to str
    """

    scene: str
    engine: str
    model: str
    parameters: Mapping[str, Any]
    undamped: bool
    about: str
    plane: str | None
    state: Mapping[str, float]
    modes: tuple[Mode, ...]
    versions: Mapping[str, str]

    def as_json(self) -> dict[str, Any]:
        """Return the ``frequencies`` document of docs/json.md."""
        return document(self, modes=[vars(mode) for mode in self.modes])


@dataclass(frozen=True)
class Report:
    """The results of a run of checks.

    Attributes
    ----------
    results : tuple of Result
    versions : mapping of str to str
    run : report.Run
        What was asked for, where it ran, and what became of the known deviations.
    """

    results: tuple[Result, ...]
    versions: Mapping[str, str]
    run: report.Run = field(default_factory=report.Run)

    @property
    def summary(self) -> dict[str, int]:
        """Number of results by verdict, and their ``total``."""
        return report.summary(self.results)

    @property
    def exit_code(self) -> int:
        """0 if all is well, 1 for any deviation or error, 2 if nothing ran.

        1 for stale entries of the known deviations too, where they are to fail.
        """
        return report.exit_code(self.results, self.run)

    def as_json(self) -> dict[str, Any]:
        """Return the ``check`` document of docs/json.md."""
        return report.json_document(self.results, self.versions, self.run)

    def markdown(self) -> str:
        """Return a Markdown table with a line for each method of each engine."""
        return report.markdown(self.results)


def document(item: Any, **parts: Any) -> dict[str, Any]:
    """Return a JSON document of a dataclass; ``parts`` stand for fields of their name."""
    found: dict[str, Any] = json_value({"schema": report.SCHEMA, **vars(item), **parts})
    return found


def json_value(value: Any) -> Any:
    """Return a value as JSON can hold it; NaN and the infinities become None."""
    if isinstance(value, Mapping):
        return {name: json_value(item) for name, item in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [json_value(item) for item in value]
    if isinstance(value, float):
        return report.finite(float(value))
    return value


# The verbs


def check(
    scenes: Sequence[str] = (),
    engines: Sequence[str] = (),
    kinds: Sequence[str] = (),
    methods: Sequence[str] = (),
    ids: Sequence[str] = (),
    profile: str = "default",
    jobs: int = 1,
    full: bool = False,
    fail_fast: bool = False,
    progress: Callable[[int, int, list[Result]], None] | None = None,
    time_limit: float | None = None,
    memory_limit: float | None = None,
    known: str | None = None,
    strict_known: bool = False,
) -> Report:
    """Check engines against the reference; empty sequences mean all.

    Parameters
    ----------
    scenes, engines, kinds, methods : sequence of str
    ids : sequence of str
        Shell patterns for ids of results.
    profile : {"strict", "default", "loose"}
        Scales every tolerance.
    jobs : int
        Worker processes; the results do not depend on it.
    full : bool
        Include the cases left out of the default set.
    fail_fast : bool
        Stop at the first deviation or error that is not known.
    progress : callable ``(done, total, results)``, optional
        Called as each check ends, with what it found.
    time_limit, memory_limit : float, optional
        What each check may take [s], and map beside what its process has mapped [MiB]: one
        that takes more is an error, and the others go on. Memory can be limited on Linux.
    known : str, optional
        A file of known deviations, see docs/ci.md.
    strict_known : bool
        Whether its stale entries fail.

    Raises
    ------
    UsageError
        For unknown names, an engine asked for that cannot be imported, limits that cannot be
        kept, a file of known deviations that makes no sense, or if no check matches.
    """
    chosen = choose_checks(scenes, engines, kinds, methods, ids, profile, full, known, strict_known)
    results = chosen.run(jobs, fail_fast, progress, time_limit, memory_limit)
    return chosen.report(results)


@dataclass(frozen=True)
class ChosenChecks:
    """Checks that are to run, and what their results will be held against.

    Attributes
    ----------
    checks : tuple of Check
    selection : mapping
        As in `report.Run`.
    listing : known.Listing
    strict_known : bool
    """

    checks: tuple[suite.Check, ...]
    selection: Mapping[str, Any]
    listing: known.Listing
    strict_known: bool

    def run(
        self,
        jobs: int = 1,
        fail_fast: bool = False,
        progress: Callable[[int, int, list[Result]], None] | None = None,
        time_limit: float | None = None,
        memory_limit: float | None = None,
    ) -> list[Result]:
        """Run the checks, see `check`."""
        done = 0

        def on_result(results: list[Result]) -> None:
            nonlocal done
            done += 1
            if progress:
                progress(done, len(self.checks), results)

        return suite.run_checks(
            self.checks,
            self.selection["profile"],
            jobs,
            fail_fast,
            on_result,
            time_limit,
            memory_limit,
            self.listing.settle,
        )

    def report(self, results: Iterable[Result]) -> Report:
        """Return the report of results, of all the checks or of those that were reached."""
        found = list(results)
        if not (self.selection["engines"] or self.selection["ids"]):
            found += suite.unavailable()
        engines = tuple(dict.fromkeys(check.loaded_as or check.engine for check in self.checks))
        names = {check.engine for check in self.checks}

        def ids(full: bool) -> dict[str, str]:
            checks = suite.plan(engines=engines, full=full)
            return {name: check.engine for check in checks for name in check.ids}

        run = report.Run(
            planned=len(self.checks),
            selection=self.selection,
            environment=environment(),
            known_file=self.listing.file,
            uses=self.listing.uses(
                found,
                cache(lambda: ids(self.selection["full"])),
                cache(lambda: ids(True)),
                set(checked_engines()) - names,
            ),
            strict_known=self.strict_known,
        )
        return Report(tuple(found), versions(check.engine for check in self.checks), run)


def choose_checks(
    scenes: Sequence[str] = (),
    engines: Sequence[str] = (),
    kinds: Sequence[str] = (),
    methods: Sequence[str] = (),
    ids: Sequence[str] = (),
    profile: str = "default",
    full: bool = False,
    known: str | None = None,
    strict_known: bool = False,
) -> ChosenChecks:
    """Return the checks that match; arguments and what they raise as of `check`."""
    if profile not in PROFILES:
        raise UnknownNameError("profile", profile, PROFILES)
    if strict_known and known is None:
        raise UsageError("--strict-known needs a file of known deviations: --known FILE")
    listing = listed(known)
    checks = tuple(suite.plan(scenes, engines, kinds, methods, ids, full))
    for engine in {check.engine for check in checks}:
        own = [name for check in checks if check.engine == engine for name in check.ids]
        listing.refuse_unordered(engine, own)
    selection = {
        "scenes": tuple(scenes),
        "engines": tuple(engines),
        "kinds": tuple(kinds),
        "methods": tuple(methods),
        "ids": tuple(ids),
        "profile": profile,
        "full": full,
    }
    return ChosenChecks(checks, selection, listing, strict_known)


def listed(file: str | None) -> known.Listing:
    """Return the known deviations of a file; none without one."""

    def version_of(name: str) -> str:
        return get_engine(name).version

    return known.Listing() if file is None else known.read(file, version_of)


def simulate(
    scene: str,
    engine: str = REFERENCE,
    method: str | None = None,
    step: float | None = None,
    model: str | None = None,
    parameters: Mapping[str, Any] | None = None,
    state: Mapping[str, float] | None = None,
    observe: Sequence[str] = (),
    *,
    times: Sequence[float] | Array,
) -> Simulation:
    """Simulate a scene from t = 0.

    Parameters
    ----------
    scene, engine : str
    method : str, optional
        An integrator as the engine spells it; by default the one of highest order.
    step : float, optional
        Fixed step [s]. The default suits the method and is shortened to fit ``times``.
        The reference takes none.
    model : str, optional
        One of the engine's models of the scene.
    parameters, state : mapping, optional
        Parameters that differ from the scene's defaults; initial values, otherwise 0.
    observe : sequence of str
        Outputs of the scene to return beside its observables, "all" for all.
    times : sequence of float
        Sample times [s], increasing, not negative, the last positive.

    Raises
    ------
    UsageError
        For unknown names, impossible values, or times off the engine's grid.
    EngineError
        If the engine failed.
    """
    case = user_case(scene, parameters, state)
    times = times_array(times)
    chosen, model = choose_engine(engine, case, model)
    picked = choose_method(chosen, case, model, method)
    names = wanted_observables(case, observe)
    if chosen.name == REFERENCE:
        refuse_step(step)
        return reference_simulation(case, chosen, picked, model, times, names)
    if step is None:
        step = step_for(times, Setup(chosen, case, model, picked).default_step)
    step = valid_step(step)
    grid = grid_indices(times, case.start_time, step) * step
    # an engine's clock tells rounding from a sample beside the grid, so it gets the grid
    times = np.where(np.abs(grid - times) <= RATIONAL * times, times, grid)
    beforehand = cautions(Setup(chosen, case, model, picked, step), float(grid[-1]))
    try:
        trajectory = run(Setup(chosen, case, model, picked, step), grid)
    except EngineError as error:
        raise EngineError(error.kind, explained(error.message, beforehand)) from error
    return simulation(
        case,
        chosen,
        picked,
        model,
        step=step,
        times=times,
        observables=told(chosen, case, trajectory.values, names, "all" in observe),
        error_bound=None,
        work={
            "steps": trajectory.steps,
            "rhs_evaluations": trajectory.rhs_evaluations,
            "seconds": trajectory.seconds,
        },
        cautions=tuple(beforehand),
    )


def wanted_observables(case: Case, observe: Sequence[str]) -> tuple[str, ...]:
    """Return the scene's observables, and the outputs that are asked for.

    Raises
    ------
    UnknownNameError
        If the scene has no such output.
    """
    scene = get_scene(case.scene)
    known = tuple(name for name in scene.units if name not in scene.observables)
    for name in observe:
        if name not in (*scene.units, "all"):
            raise UnknownNameError(f"output of {case.scene}", name, (*known, "all"))
    more = known if "all" in observe else tuple(name for name in known if name in observe)
    return (*scene.observables, *more)


def told(
    engine: Adapter,
    case: Case,
    values: Mapping[str, Array],
    names: tuple[str, ...],
    whatever_there_is: bool,
) -> dict[str, Array]:
    """Return the observables that an engine returned, with what it tells of its constraints.

    Raises
    ------
    UsageError
        If it does not tell one that was asked for by its name.
    """
    missing = [name for name in names if name not in values]
    if missing and not whatever_there_is:
        raise UsageError(
            f"{engine.name} does not tell {', '.join(missing)} of {case.scene}; the reference does"
        )
    return {name: values[name] for name in (*names, *VIOLATIONS) if name in values}


def reference_simulation(
    case: Case, engine: Adapter, method: Method, model: str, times: Array, names: tuple[str, ...]
) -> Simulation:
    """Return the reference's solution of a case with its error bound."""
    own = equations(case, engine, model)
    begin = perf_counter()
    solution = solve(own.scene, own.parameters, own.scene.state(case.state), times, case.start_time)
    seconds = perf_counter() - begin

    def solved(one: ModelEquations, state: tuple[float, ...]) -> Solution:
        return solve(one.scene, one.parameters, np.array(state), times, case.start_time)

    state = tuple(own.scene.state(case.state))
    right = truncated(own, state, truth_of(own, solution, names), names, solved)
    return simulation(
        case,
        engine,
        method,
        model,
        step=None,
        times=times,
        observables=dict(zip(names, right.values, strict=True)),
        error_bound=floats(dict(zip(names, right.bound, strict=True))),
        work={
            "steps": solution.steps,
            "rhs_evaluations": solution.rhs_evaluations,
            "seconds": seconds,
        },
    )


def equations(case: Case, engine: Adapter, model: str) -> ModelEquations:
    """Return the equations that the reference solves: exact, or one of the simplifications."""
    assert isinstance(engine, ReferenceEngine)
    return ModelEquations(engine.equations(case, model), case.parameters)


def simulation(case: Case, engine: Adapter, method: Method, model: str, **found: Any) -> Simulation:
    """Return what was found, together with what it was found for."""
    units = {**VIOLATION_UNITS, **get_scene(case.scene).units}
    return Simulation(
        scene=case.scene,
        engine=engine.name,
        method=method.name,
        model=model,
        parameters=case.parameters.as_dict(),
        units={name: units[name] for name in found["observables"]},
        versions=versions([engine.name]),
        **found,
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
    case = user_case(scene, parameters, None)
    chosen, model = choose_engine(engine, case, model)
    picked = choose_method(chosen, case, model, method)
    if chosen.name == REFERENCE:
        refuse_step(step)
        exact = equations(case, chosen, model)
        found = find_orbit(*exact)
        samples = orbit_samples(*exact, found)
        bound = floats(by_state(exact.scene, found.error_bound))
        return orbit_report(case, chosen, picked, model, None, found, samples, bound)
    step = None if step is None else valid_step(step)
    own = find_engine_orbit(Setup(chosen, case, model, picked, step))
    unknown = np.full(len(own.state), np.nan)
    found = Orbit(own.period, own.state, own.multipliers, own.monodromy, unknown, own.trivial)
    return orbit_report(case, chosen, picked, model, own.step, found, own.samples, None)


def orbit_report(
    case: Case,
    engine: Adapter,
    method: Method,
    model: str,
    step: float | None,
    orbit: Orbit,
    samples: Array,
    error_bound: Mapping[str, float] | None,
) -> OrbitReport:
    """Return an orbit with its harmonics and powers, from uniform samples (2 n, k)."""
    scene = get_scene(case.scene)
    turns = next(iter(scene.turning.values()), None)
    return OrbitReport(
        scene=case.scene,
        engine=engine.name,
        method=method.name,
        model=model,
        step=step,
        parameters=case.parameters.as_dict(),
        period=orbit.period,
        state=floats(by_state(scene, orbit.state)),
        mean_speed=None if turns is None else 2 * math.pi * turns / orbit.period,
        stable=orbit.stable,
        floquet_multipliers=tuple(complex(value) for value in orbit.multipliers),
        trivial_multiplier=orbit.trivial,
        harmonics={
            name: harmonics(values, scene.turning.get(name, 0))
            for name, values in by_state(scene, samples).items()
        },
        power=mean_powers(scene, case.parameters, orbit, samples),
        quantities={
            name: (float(value), scene.orbit_units[name])
            for name, value in scene.orbit_quantities(
                samples, scene.coefficients(case.parameters)
            ).items()
        },
        error_bound=error_bound,
        versions=versions([engine.name]),
    )


def frequencies(
    scene: str,
    about: str | None = None,
    parameters: Mapping[str, Any] | None = None,
    engine: str = REFERENCE,
    model: str | None = None,
    undamped: bool = False,
    count: int | None = None,
    plane: str | None = None,
) -> Frequencies:
    """Find the modes about a state of rest or steady motion, forces and motors switched off.

    Parameters
    ----------
    scene : str
    about : str, optional
        Name of a state of rest; the scene's first by default.
    parameters : mapping of str to float, optional
    engine, model : str, optional
        Whose mass, damping and stiffness matrices are used.
    undamped : bool
        Leave damping out.
    count : int, optional
        Return the lowest so many modes; all by default, of a continuum `CONTINUUM_MODES`.
    plane : {"chordwise", "flapwise"}, optional
        In (the default) or out of the plane of rotation, of a beam that rotates.

    Raises
    ------
    UsageError
        For unknown names or impossible values.
    EngineError
        If the engine failed.
    """
    case = user_case(scene, parameters, None)
    chosen, model = choose_engine(engine, case, model)
    places = get_scene(scene).equilibria
    about = next(iter(places)) if about is None else about
    if about not in places:
        raise UnknownNameError(f"state of rest of {scene}", about, places)
    if count is not None and count < 1:
        raise UsageError(f"the number of modes must be 1 or more, not {count}")
    still = replace(case, parameters=get_scene(scene).unforced(case.parameters), about=about)
    scene_of_case = get_scene(scene)
    _, _, state, held = resting(still)
    if scene_of_case.spectrum:
        plane = plane or elements.PLANE
        found = continuum_modes(chosen, still, model, plane, count or CONTINUUM_MODES)
    elif plane is not None:
        raise UsageError(f"{scene} has no planes of vibration: leave the plane out")
    else:
        mass, damping, stiffness = answer(lambda: chosen.linearise(still, model, state))
        found = modes(mass, 0 * damping if undamped else damping, stiffness, held)
    values = by_state(scene_of_case, state)
    return Frequencies(
        scene=scene,
        engine=chosen.name,
        model=model,
        parameters=case.parameters.as_dict(),
        undamped=undamped,
        about=about,
        plane=plane,
        state=floats({name: values[name] for name in scene_of_case.public_states}),
        modes=tuple(without_minus_zero(mode) for mode in found[:count]),
        versions=versions([chosen.name]),
    )


CONTINUUM_MODES = 4
"""Modes of a continuum that are returned by default."""


def continuum_modes(
    engine: Adapter, case: Case, model: str, plane: str, count: int
) -> Sequence[Mode]:
    """Return the lowest modes of a continuum, or of what an engine makes of it.

    Raises
    ------
    UsageError
        For an unknown plane, or one that the model does not leave.
    EngineError
        If the engine failed.
    """
    if plane not in PLANES:
        raise UnknownNameError("plane", plane, PLANES)
    own = equations(case, engine, model) if engine.name == REFERENCE else None
    if own and own.scene.spectrum:
        omegas, _ = own.scene.spectrum(own.parameters, plane, count)
        return [Mode(0.0, w, w, w / (2 * np.pi), 0.0) for w in map(float, omegas)]
    if plane != elements.PLANE:
        raise UsageError(
            f"model {model} of {engine.name} stays in the plane of rotation; {plane} "
            "frequencies are known of the reference's exact models"
        )
    return answer(lambda: elements.engine_modes(Setup(engine, case, model)))[:count]


PLANES = ("chordwise", "flapwise")


Answer = TypeVar("Answer")


def answer(ask: Callable[[], Answer]) -> Answer:
    """Return what an engine answers.

    Raises
    ------
    EngineError
        If the engine raised.
    """
    console = Console()
    try:
        with contained() as console:
            return ask()
    except MbcheckError:
        raise
    except Exception as error:  # whatever a foreign engine raises is its failure, not ours
        raise EngineError("raised", describe(error, console.text)) from error


def without_minus_zero(mode: Mode) -> Mode:
    """Return a mode whose zeros have no sign."""
    ratio = None if mode.damping_ratio is None else mode.damping_ratio + 0.0
    return replace(mode, re=mode.re + 0.0, im=mode.im + 0.0, damping_ratio=ratio)


def mjcf_text(
    scene: str, parameters: Mapping[str, Any] | None = None, model: str | None = None
) -> str:
    """Return the MJCF of a scene with these parameters.

    Raises
    ------
    UsageError
        For unknown names, impossible values, or a scene without MJCF.
    """
    case = user_case(scene, parameters, None)
    known = mjcf.models(scene)
    model = known_name(f"MJCF model of {scene}", model, tuple(known))
    return mjcf.export(known[model], case.parameters)


# What was asked for, made sure of


def user_case(
    scene: str, parameters: Mapping[str, Any] | None, state: Mapping[str, float] | None
) -> Case:
    """Return the case that a user describes.

    Raises
    ------
    UsageError
        For unknown names or impossible values.
    """
    described = get_scene(scene)
    words = described.parameters.choices()
    changes = {
        name: value if name in words else number(name, value)
        for name, value in (parameters or {}).items()
    }
    values = {name: number(name, value) for name, value in (state or {}).items()}
    changed = described.parameters().replace(**changes)
    return Case(
        scene=scene, name="user", parameters=changed, state=consistent(described, changed, values)
    )


def consistent(scene: Scene, parameters: Any, values: Mapping[str, float]) -> dict[str, float]:
    """Return the initial values of the states; outputs must agree with them.

    Raises
    ------
    ParameterError
        If an output is given that follows otherwise from the states, or a state that the
        parameters fix.
    UnknownNameError
        If a state is the reference's own.
    """
    given = scene.given(parameters)
    states = {name: value for name, value in values.items() if name not in scene.observed}
    for name in states:
        if name not in scene.public_states:
            known = (*scene.public_states, *scene.observed)
            raise UnknownNameError(f"state of {scene.name}", name, known)
    found = scene.observe(scene.state(states | given), parameters)
    for name in set(values) & {*scene.observed, *given}:
        expected = float(found[name])
        if not abs(values[name] - expected) <= CONSISTENT * max(1.0, abs(expected)):
            raise ParameterError(
                f"initial {name} = {values[name]:.9g} {scene.units[name]} contradicts what else is "
                f"given, from which {name} = {expected:.9g} follows; leave it out"
            )
    return states | given


def number(name: str, value: Any) -> float:
    """Return a value as a float.

    Raises
    ------
    ParameterError
        If it is not one number.
    """
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise ParameterError(f"{name} must be a number, not {value!r}") from None


def times_array(times: Any) -> Array:
    """Return sample times as an array (n_t,).

    Raises
    ------
    UsageError
        If they are not numbers in one row, finite, increasing and not negative, the last
        positive.
    """
    try:
        found = np.asarray(times, dtype=float)
    except (TypeError, ValueError):
        raise UsageError("sample times must be numbers") from None
    if found.ndim != 1:
        raise UsageError("sample times must be one row of numbers")
    found = sample_times(found, 0.0)
    if found[-1] == 0:
        raise UsageError("nothing to simulate: the last sample time must be after t = 0")
    return found


def valid_step(step: Any) -> float:
    """Return a step [s].

    Raises
    ------
    UsageError
        If it is not a positive number.
    """
    value = number("step", step)
    if not (math.isfinite(value) and value > 0):
        raise ParameterError(f"step must be finite and greater than 0, not {step!r}")
    return value


def refuse_step(step: float | None) -> None:
    """Refuse a step for the reference.

    Raises
    ------
    UsageError
    """
    if step is not None:
        raise UsageError("the reference chooses its own steps: leave the step out")


def choose_engine(name: str, case: Case, model: str | None) -> tuple[Adapter, str]:
    """Return an engine and the name of one of its models of a case's scene.

    Raises
    ------
    UsageError
        For unknown names, an engine that cannot be imported or has no model of the scene.
    """
    engine = get_engine(name)
    what = f"{name} model of {case.scene}"
    return engine, known_name(what, model, engine.models(case.scene))


def known_name(kind: str, name: str | None, known: tuple[str, ...]) -> str:
    """Return a name, or the first of those known.

    Raises
    ------
    UsageError
        If it is not known, or none is.
    """
    if not known:
        raise UsageError(f"there is no {kind}")
    if name is not None and name not in known:
        raise UnknownNameError(kind, name, known)
    return known[0] if name is None else name


def choose_method(engine: Adapter, case: Case, model: str, name: str | None) -> Method:
    """Return a method by name, or the one of highest order that can run the case.

    Raises
    ------
    UsageError
        If it is unknown, or cannot run the case.
    """
    by_name = {method.name: method for method in engine.methods}
    if name is not None:
        if name not in by_name:
            raise UnknownNameError(f"method of {engine.name}", name, by_name)
        reason = engine.why_not(case, model, by_name[name])
        if reason is not None:
            raise UsageError(f"{engine.name} {name} cannot run this: {reason}")
        return by_name[name]
    for method in sorted(engine.methods, key=lambda item: -item.order):
        if engine.why_not(case, model, method) is None:
            return method
    raise UsageError(f"no method of {engine.name} can run {model} of {case.scene}")


def step_for(times: Array, longest: float) -> float:
    """Return the longest step [s], up to a limit, on whose grid from 0 all times lie.

    Raises
    ------
    UsageError
        If the times share no spacing that is not far shorter, or steps are too many.
    """
    if not times[-1] / MOST_STEPS <= longest:
        raise UsageError(
            f"the fastest motion here asks for steps of {longest:.3g} s, more than "
            f"{MOST_STEPS:.0e} of them; choose other parameters, a shorter run, or give the step"
        )
    spacing = common_spacing(times)
    step = float(spacing / math.ceil(spacing / longest))
    if step < SHORTEST_STEP * longest:
        raise UsageError(
            f"these times need a step of {step:.3g} s, far shorter than the method's "
            f"{longest:.3g} s; choose times on a coarser grid, or give the step"
        )
    return step


def common_spacing(times: Array) -> Fraction:
    """Return the greatest common divisor of times taken as rational numbers."""
    exact = [rational(float(time)) for time in times]
    unit = math.lcm(*(time.denominator for time in exact))
    return Fraction(math.gcd(*(int(time * unit) for time in exact)), unit)


def rational(value: float) -> Fraction:
    """Return a rational number of small denominator that rounds to a value."""
    exact = Fraction(value)
    for digits in range(1, 16):
        near = exact.limit_denominator(10**digits)
        if abs(near - exact) <= RATIONAL * exact:
            return near
    return exact


def by_state(scene: Scene, rows: Any) -> dict[str, Any]:
    """Return rows by the name of the state that each belongs to."""
    return dict(zip(scene.state_names, rows, strict=True))


def floats(values: Mapping[str, Any]) -> dict[str, float]:
    """Return plain floats by name."""
    return {name: float(value) for name, value in values.items()}


# What it was done with


def versions(engines: Iterable[str]) -> dict[str, str]:
    """Return the versions of mbcheck, NumPy, SciPy and of engines, by name."""
    found = {"mbcheck": own_version(), "numpy": version("numpy"), "scipy": version("scipy")}
    names = [name for name in dict.fromkeys(engines) if name != REFERENCE]
    return found | {name: get_engine(name).version for name in names}


def environment() -> dict[str, str]:
    """Return the machine and what computes on it: what rounding may depend on."""
    return {
        "python": platform.python_version(),
        "system": platform.system(),
        "machine": platform.machine(),
        "processor": processor(),
        "libc": " ".join(platform.libc_ver()).strip() or "unknown",
    }


def processor() -> str:
    """Return the name of the processor; ``unknown`` where nothing tells it."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:  # not Linux
        text = ""
    found = re.search(r"^model name\s*:\s*(.+)$", text, re.MULTILINE)
    return found[1].strip() if found else platform.processor() or "unknown"


def own_version() -> str:
    """Return the version of mbcheck as installed."""
    try:
        return version(__package__.partition(".")[0])
    except PackageNotFoundError:
        return "not installed"

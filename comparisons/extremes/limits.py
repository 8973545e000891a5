"""Where methods stop being stable: measured by bisection on runs, beside the theory.

Free vibrations of a small amplitude about a state of rest, without forces and dampers, start in
the shape of the mode that the method bears least. A run counts as unstable if an observable
comes to `GROWTH` times the size that it really has, or if the guard stops it. The theory is the
largest step of the amplification matrix; what is to be found exactly is the same bisection on
that matrix, from the same start, by the same measure.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from ...reference import SCENES, get_scene
from ...reference.amplification import AMPLIFICATION, DEFECT, GROWTH, first_order, spectral_radius
from ...reference.errors import EngineError, MbcheckError
from ...reference.scene import Array, Case
from ...reference.solve.single import solve
from ..checks.free_vibrations import START, Critical, Place, critical, places, step_limit
from ..checks.rules.cautions import cautions
from ..checks.suite import best_method
from ..checks.truth import Truth, truth_of
from ..engines.adapter import Adapter
from ..engines.equations import ModelEquations
from ..engines.protocol import Method
from ..engines.registry import get_engine
from ..engines.run import run
from ..engines.setup import Setup
from .row import ENGINE, FAILED, REFERENCE, REFUSED, RIGHT, RULE, SKIPPED, WRONG, Row, noticer
from .task import Task

PERIODS = 20
"""Of the limiting mode, over which a vibration must stay bounded."""

STEPS = 200
"""In place of them where a parameter is varied at a fixed step."""

AMPLITUDE = 1e-7
"""Of the start (m, rad): what is not linear in it lies far below `RESOLUTION`. A soft closure
hardens within MuJoCo's ``width`` of 1e-3 m."""

SEEN = 256
"""Times at which a run is looked at, at most."""

BEYOND = 1.02
"""Steps beyond its limit that show which mode a scheme bears least."""

RESOLUTION = 1e-3
"""Relative width in which the bisection ends."""

AGREEMENT = 2 * RESOLUTION
"""Largest relative distance of two limits that agree: each is known to `RESOLUTION`."""

UNLIMITED = (1000.0, 100.0, 10.0)
"""Periods of the fastest mode in a step that a method without a limit must bear; if not the first,
then which."""

WIDEST = 1e12
"""Factor up to which a parameter is raised."""

SPEED_ERROR = 0.1
"""Error, in the size of an observable, beyond which a speed is too high for a step."""

TURNS = 10.0
"""Over which it may arise."""


class Free(NamedTuple):
    """What makes a scene vibrate freely, and which parameters stand for its extremes."""

    undamped: Mapping[str, float | str]
    stiffness: str
    damping: str | None
    speed: str
    """A parameter, or the rate of a coordinate at the start"""


FREE: Mapping[str, Free] = {
    "hula_hoop": Free(
        {"damping_ratio": 0.0, "hinge_damping_ratio": 0.0},
        "stiffness",
        "damping_ratio",
        "theta_dot",
    ),
    "rotor_pendulum": Free(
        {"platform_damping": 0.0, "rod_damping": 0.0}, "rod_stiffness", "rod_damping", "phi_1_dot"
    ),
    "rotating_beam": Free(
        {"angular_speed": 0.0, "segments": 12.0}, "youngs_modulus", None, "angular_speed"
    ),
    "speed_regulator": Free({"damping": 0.0, "torque": 0.0}, "stiffness", "damping", "phi_dot"),
}

MASSLESS = {"rod_mass": 0.0, "slider_mass": 0.0}
OF_MODELS: Mapping[str, Mapping[str, float]] = {"transmission": MASSLESS}
"""Parameters that a model cannot do without."""

FEWER, MORE = 6.0, 24.0
"""Segments of a chain beside the default: its fastest mode goes with the square of them."""


@dataclass(frozen=True)
class Setting:
    """One engine, model and method on free vibrations of one scene."""

    engine: Adapter
    case: Case
    model: str
    method: Method

    def changed(self, **changes: float) -> Setting:
        """Return it with other parameters."""
        parameters = self.case.parameters.replace(**changes)
        return replace(self, case=replace(self.case, parameters=parameters))


def free_case(scene_name: str, model: str, **changes: Any) -> Case:
    """Return a scene without forces and dampers."""
    scene = get_scene(scene_name)
    p = scene.unforced(scene.parameters()).replace(**FREE[scene_name].undamped)
    p = p.replace(**{**OF_MODELS.get(model, {}), **changes})
    return Case(scene_name, "free_vibration", p, {})


class Vibration(NamedTuple):
    """A mode about a state of rest, and how it starts."""

    at: Place
    mode: Critical
    start: Array
    """Departure of the claim's state (2 n,) from rest"""


def vibration(of: Setting, scheme: str, horizon: float | None, step: float | None) -> Vibration:
    """Return the vibration that a scheme bears least, at a step or at its limit."""
    own = Setup(of.engine, of.case, of.model).equations
    found = [at for at in places(Setup(of.engine, of.case, of.model), scheme) if at.name != START]
    found = found or list(places(Setup(of.engine, of.case, of.model), scheme))
    at = max(found, key=lambda one: float(np.max(np.abs(one.rates))))
    fastest = float(np.max(np.abs(at.rates)))
    if step is None:
        step = step_limit(scheme, at, horizon or PERIODS * 2 * np.pi / fastest)
    n, width = len(own.scene.coordinates), len(at.coordinates)
    if np.isfinite(step) and spectral_radius(scheme, at.modes, BEYOND * step) > 1 + DEFECT:
        values, vectors = np.linalg.eig(AMPLIFICATION[scheme](at.matrices, BEYOND * step))
        mode = critical(scheme, at, BEYOND * step)
        shape = vectors[:, np.argmax(np.abs(values))].real
        shape = np.concatenate([shape[:n], shape[width : width + n]])
    else:
        values, vectors = np.linalg.eig(first_order(at.matrices))
        row = int(np.argmax(np.abs(values) * (values.imag >= 0)))
        place = int(np.argmax(np.abs(vectors[:width, row])))
        mode = Critical(float(abs(values[row])), at.coordinates[place])
        turned = vectors[:n, row] / vectors[place, row]
        shape = np.concatenate([turned.real, np.zeros(n)])
    size = max(np.max(np.abs(shape[:n])), np.max(np.abs(shape[n:])) / fastest)
    return Vibration(at, mode, AMPLITUDE * shape / size)


def started(of: Setting, at: Place, departure: Array) -> Case:
    """Return the case that starts off a state of rest by this much."""
    own = Setup(of.engine, of.case, of.model).equations
    scene = get_scene(of.case.scene)
    state = at.state + departure
    values = dict(zip(own.scene.state_names, state.tolist(), strict=True))
    if own.scene is scene or scene.internal:
        return replace(of.case, state=values)
    # a soft loop: the scene's own coordinates, and how far the others are from closing it
    case = replace(of.case, state={name: values[name] for name in scene.state_names})
    closed = dict(zip(own.scene.state_names, own.start(case).tolist(), strict=True))
    apart = {name: values[name] - closed[name] for name in values if name not in scene.state_names}
    return replace(case, inconsistency=apart)


class Measure(NamedTuple):
    """What is looked at: observables, linear in the departure, and the size that they have."""

    names: tuple[str, ...]
    rest: Array
    slopes: Array
    size: Array


def measure(of: Setting, at: Place, departure: Array) -> Measure:
    """Return the observables of a claim, their values at rest and sizes in the real vibration.

    Where something is free to drift, angles that turn do with what rounding gives their speed,
    and only their rates are looked at.
    """
    own = Setup(of.engine, of.case, of.model).equations
    scene = get_scene(of.case.scene)
    drifting = tuple(scene.turning) if np.any(at.rates == 0) else ()
    names = tuple(
        name for name in scene.observables if name in own.scene.observables and name not in drifting
    )
    probed = at.state[:, None] + 1e-40j * np.eye(len(at.state))
    found = own.scene.observe(probed, own.parameters)
    values = np.array([np.broadcast_to(found[name], len(at.state)) for name in names])
    rest, slopes = values[:, 0].real, values.imag / 1e-40
    n, width = len(own.scene.coordinates), len(at.coordinates)
    rows = [*range(n), *range(width, width + n)]
    matrix = first_order(at.matrices)[np.ix_(rows, rows)]
    fastest = float(np.max(np.abs(at.rates)))
    turn = expm(matrix * (2 * np.pi / fastest / 16))
    x, size = departure, np.abs(slopes @ departure)
    for _ in range(32):
        x = turn @ x
        size = np.maximum(size, np.abs(slopes @ x))
    return Measure(names, rest, slopes, size)


def largest(values: Array, of: Measure) -> float:
    """Return the largest departure (names, n_t) of an observable, in the size that it has."""
    seen = of.size > 1e-6 * np.max(of.size)
    size = np.where(seen, of.size, np.inf)
    if not np.all(np.isfinite(values)):
        return np.inf
    with np.errstate(all="ignore"):
        return float(np.max(np.abs(values) / size[:, None]))


def by_run(of: Setting, made: Vibration, step: float, horizon: float) -> float:
    """Run the engine and return the largest departure.

    Raises
    ------
    EngineError
        Of the engine or the guard.
    """
    case = started(of, made.at, made.start)
    seen = measure(of, made.at, made.start)
    times: Array = step * step_numbers(step, horizon).astype(float)
    found = run(Setup(of.engine, case, of.model, of.method, step), times)
    return largest(found.matrix(seen.names) - seen.rest[:, None], seen)


def unstable_run(of: Setting, made: Vibration, step: float, horizon: float) -> bool:
    """Run the engine and tell whether the vibration grows, or the guard stops it.

    Raises
    ------
    EngineError
        ``step``, where the engine refuses it.
    """
    try:
        return by_run(of, made, step, horizon) > GROWTH
    except EngineError as error:
        if error.kind == "step":
            raise
        return True


def by_matrix(of: Setting, scheme: str, made: Vibration, step: float, horizon: float) -> float:
    """Return the largest departure by the scheme's amplification matrix."""
    seen = measure(of, made.at, made.start)
    matrix = AMPLIFICATION[scheme](made.at.matrices, step)
    n, width = len(made.start) // 2, len(made.at.coordinates)
    x = np.zeros(len(matrix))
    x[:n], x[width : width + n] = np.split(made.start, 2)
    if len(matrix) > 2 * width:  # generalized-alpha carries accelerations
        x[2 * width :] = (first_order(made.at.matrices) @ x[: 2 * width])[width:]
    rows = [*range(n), *range(width, width + n)]
    numbers = step_numbers(step, horizon)
    with np.errstate(all="ignore"):
        advance = np.linalg.matrix_power(matrix, int(numbers[0]))
        states = (advance @ x)[:, None]
        while states.shape[1] < len(numbers):  # twice as many each time
            states = np.hstack([states, advance @ states])
            advance = advance @ advance
        return largest(seen.slopes @ states[rows, : len(numbers)], seen)


def unstable_matrix(of: Setting, scheme: str, made: Vibration, step: float, horizon: float) -> bool:
    """Tell whether the vibration grows by the scheme's amplification matrix."""
    return by_matrix(of, scheme, made, step, horizon) > GROWTH


def step_numbers(step: float, horizon: float) -> NDArray[np.int_]:
    """Return at which steps a run is looked at: evenly spread, at most `SEEN`."""
    count = max(2, math.ceil(horizon / step))
    every = math.ceil(count / SEEN)
    return every * np.arange(1, count // every + 1)


def bisected(bad: Callable[[float], bool], low: float, high: float) -> float:
    """Return the largest value that is not bad between two, in steps of the logarithm.

    They are moved by factors of 4 until the lower is good and the higher bad.

    Raises
    ------
    MbcheckError
        If there is no such pair.
    """
    for _ in range(12):
        if not bad(low):
            break
        low, high = low / 4, low
    else:
        raise MbcheckError(f"unstable even with {low:.3g}")
    for _ in range(12):
        if bad(high):
            break
        low, high = high, 4 * high
    else:
        raise MbcheckError(f"stable even with {high:.3g}")
    while high > low * (1 + RESOLUTION):
        middle = math.sqrt(low * high)
        low, high = (low, middle) if bad(middle) else (middle, high)
    return low


def tasks(scenes: tuple[str, ...], engines: tuple[str, ...], full: bool) -> list[Task]:
    """Return a task for each scene, engine and model."""
    found = []
    for scene in scenes or tuple(SCENES):
        for name in engines:
            for model in get_engine(name).models(scene):
                call = partial(limits, scene, name, model, full)
                found.append(Task("limits", scene, f"limits of {model}", name, call))
    return found


def limits(scene: str, engine_name: str, model: str, full: bool = False) -> list[Row]:
    """Return the limits of step, stiffness, damping and speed of all methods of a model."""
    engine = get_engine(engine_name)
    rows = [
        step_row(Setting(engine, free_case(scene, model), model, method))
        for method in engine.methods
    ]
    if scene == "rotating_beam" and engine_name == "mujoco":
        for segments in (FEWER, MORE) if full else (FEWER,):
            case = free_case(scene, model, segments=segments)
            method = best_method(Setup(engine, case, model))
            assert method is not None
            rows.append(step_row(Setting(engine, case, model, method), segments=segments))
    for method in explicit(engine, free_case(scene, model), model):
        setting = Setting(engine, free_case(scene, model), model, method)
        rows += parameter_rows(setting, full)
    return rows


def explicit(engine: Adapter, case: Case, model: str) -> Iterator[Method]:
    """Yield the best explicit method, and semi-implicit Euler, of those that a model takes."""
    fit = [m for m in engine.methods if m.scheme and engine.why_not(case, model, m) is None]
    top = max(fit, key=lambda method: method.order, default=None)
    for method in fit:
        if method is top or method.scheme == "semi_implicit_euler":
            yield method


def blank(of: Setting, name: str, changed: Mapping[str, float | str]) -> Row:
    """Return a row that is still to be filled."""
    return Row(
        "limits", of.case.scene, name, of.engine.name, of.model, of.method.name, None,
        changed, FAILED, (), None, None, "",
    )  # fmt: skip


def step_row(of: Setting, **changed: float) -> Row:
    """Return the largest stable step of a method, found and by theory, and who notices."""
    row = found_step(of, changed)
    if row.outcome not in (WRONG, FAILED) or row.step is None or "theory" in row.values:
        return row  # beside a limit all steps are coarse: no rule tells that it is a wrong one
    said = cautions(Setup(of.engine, of.case, of.model, of.method, row.step), STEPS * row.step)
    rules = tuple(f"{RULE}{caution.rule}" for caution in said)
    first, last = (row.noticed_by, rules) if row.outcome == FAILED else (rules, row.noticed_by)
    return replace(row, noticed_by=(*first, *last))


def found_step(of: Setting, changed: Mapping[str, float | str]) -> Row:
    """Return the largest stable step of a method, found and by theory."""
    row = blank(of, "step_limit", changed)
    reason = of.engine.why_not(of.case, of.model, of.method)
    if reason is not None:
        return replace(row, outcome=REFUSED, noticed_by=(ENGINE,), reason=reason)
    if Setup(of.engine, of.case, of.model).approximates_continuum:
        return elements_row(of, row)
    scheme = Setup(of.engine, of.case, of.model, of.method).linear_scheme
    if scheme is None:
        return replace(row, outcome=SKIPPED, reason="no theory of this method")
    made = vibration(of, scheme, None, None)
    omega = made.mode.omega
    horizon = PERIODS * 2 * np.pi / omega
    theory = step_limit(scheme, made.at, horizon)
    told = f"mode of {made.mode.coordinate}, {omega:.5g} rad/s about {made.at.name}"
    if not np.isfinite(theory):
        return unlimited(
            row,
            told,
            omega,
            lambda step: by_run(of, made, step, STEPS * step),
            lambda step: max(GROWTH, OVERSHOOT * by_matrix(of, scheme, made, step, STEPS * step)),
        )
    try:
        expected = bisected(
            lambda step: unstable_matrix(of, scheme, made, step, horizon), theory / 4, 4 * theory
        )
        found = bisected(lambda step: unstable_run(of, made, step, horizon), theory / 4, 4 * theory)
    except EngineError as error:
        values = {"theory": theory * omega, "omega": omega}
        return replace(
            row, outcome=REFUSED, noticed_by=(noticer(error),), values=values,
            reason=f"{error.message}; {told}, theory {theory:.4g} s",
        )  # fmt: skip
    except MbcheckError as error:
        return replace(row, outcome=WRONG, noticed_by=(REFERENCE,), reason=f"{told}: {error}")
    return judged(row, found, expected, told, theory, omega)


def judged(row: Row, found: float, expected: float, told: str, theory: float, omega: float) -> Row:
    """Return the row of a limit of the step."""
    apart = abs(found / expected - 1)
    right = apart <= AGREEMENT
    return replace(
        row,
        step=found,
        outcome=RIGHT if right else WRONG,
        noticed_by=() if right else (REFERENCE,),
        error=apart,
        predicted=AGREEMENT,
        reason=f"{told}: h omega = {found * omega:.4g}, theory {theory * omega:.4g}, from this "
        f"start {expected * omega:.4g}",
        values={
            "h_omega": found * omega,
            "theory": theory * omega,
            "expected": expected * omega,
            "omega": omega,
        },
    )


def unlimited(
    row: Row,
    told: str,
    omega: float,
    measured: Callable[[float], float],
    granted: Callable[[float], float] = lambda step: GROWTH,
) -> Row:
    """Return the row of a method without a limit, that must bear `UNLIMITED` periods in a step.

    Generalized-alpha is stable and yet multiplies a start before it settles: as much as its
    matrix does is granted. The step of the row is the shortest that is not borne, if there is
    one; ``borne`` is the longest that is [s].
    """
    told += ": none by theory"
    values = {"omega": omega}
    row = replace(row, outcome=RIGHT)
    for periods in UNLIMITED:
        step = periods * 2 * np.pi / omega
        told += f"; with {periods:g} periods in a step "
        try:
            found, most = measured(step), granted(step)
        except EngineError as error:
            told += f"{error.kind}: {error.message}"
            outcome = REFUSED if error.kind == "step" else FAILED
            row = replace(row, step=step, outcome=outcome, noticed_by=(noticer(error),))
            continue
        if found <= most:
            told += f"at most {found:.3g} times as large as it is"
            values["borne"] = step
            break
        told += f"{found:.3g} times as large as it is, {most:.3g} granted"
        row = replace(row, step=step, outcome=WRONG, noticed_by=(REFERENCE,))
    step = step if row.step is None else row.step
    return replace(row, step=step, reason=told, values={"h_omega": step * omega, **values})


OVERSHOOT = 1.01
"""On what the matrix makes of a start: rounding with steps of a thousand periods."""


def elements_row(of: Setting, row: Row) -> Row:
    """Return the row of a continuum by elements: a free hub that starts against its beam."""
    p = of.case.parameters.replace(drive="torque", torque_amplitude=0.0)
    case = replace(of.case, parameters=p, state={"theta_dot": AMPLITUDE})
    period = float(get_scene(case.scene).period(p))

    def measured(step: float) -> float:
        times = step * np.arange(1.0, STEPS + 1)
        tip = run(Setup(of.engine, case, of.model, of.method, step), times).values["tip_deflection"]
        return float(np.max(np.abs(tip))) / (AMPLITUDE * period * p.length)

    omega = 2 * np.pi / period
    return unlimited(row, f"first mode at rest, {omega:.5g} rad/s", omega, measured)


# Parameters at a given step -----------------------------------------------------------------


def parameter_rows(of: Setting, full: bool) -> list[Row]:
    """Return the largest stiffness, damping and speed at the default step.

    A spin with a soft loop, whose equations take a minute to solve, is left to ``full``.
    """
    scene = get_scene(of.case.scene)
    free = FREE[scene.name]
    default = Case(scene.name, "default", of.case.parameters, {})
    step = Setup(of.engine, default, of.model, of.method).default_step
    rows = [parameter_row(of, "stiffness_limit", free.stiffness, step)]
    if free.damping is not None:
        rows.append(parameter_row(of, "damping_limit", free.damping, step))
    if free.speed in scene.parameters.names():
        rows.append(parameter_row(of, "speed_limit", free.speed, step))
    elif full or not Setup(of.engine, of.case, of.model).has_soft_closure:
        rows.append(speed_row(of, free.speed, step))
    return rows


def parameter_row(of: Setting, name: str, parameter: str, step: float) -> Row:
    """Return the largest value of a parameter with which a step stays stable."""
    row = replace(blank(of, name, {}), step=step)
    scheme = Setup(of.engine, of.case, of.model, of.method).linear_scheme
    if scheme is None:
        return replace(row, outcome=SKIPPED, reason="no theory of this method")
    usual = getattr(get_scene(of.case.scene).parameters(), parameter)
    horizon = STEPS * step

    def at(value: float) -> tuple[Setting, Vibration]:
        setting = of.changed(**{parameter: value})
        return setting, vibration(setting, scheme, None, step)

    def bad_matrix(value: float) -> bool:
        setting, made = at(value)
        return unstable_matrix(setting, scheme, made, step, horizon)

    def bad_run(value: float) -> bool:
        setting, made = at(value)
        return unstable_run(setting, made, step, horizon)

    try:
        if not bad_matrix(WIDEST * usual):
            bad = bad_run(WIDEST * usual)
            return replace(
                row,
                changed={parameter: WIDEST * usual},
                outcome=WRONG if bad else RIGHT,
                noticed_by=(REFERENCE,) if bad else (),
                reason=f"none by theory; {'not ' if bad else ''}bounded with {parameter} = "
                f"{WIDEST * usual:.3g}",
                values={"found": WIDEST * usual},
            )
        expected = bisected(bad_matrix, usual, 4 * usual)
        found = bisected(bad_run, usual, 4 * usual)
    except EngineError as error:
        return replace(row, outcome=REFUSED, noticed_by=(noticer(error),), reason=error.message)
    except MbcheckError as error:
        return replace(row, outcome=WRONG, noticed_by=(REFERENCE,), reason=str(error))
    _, made = at(found)
    apart = abs(found / expected - 1)
    right = apart <= 2 * AGREEMENT  # a frequency goes with a root, or a rate with all of it
    return replace(
        row,
        changed={parameter: found},
        outcome=RIGHT if right else WRONG,
        noticed_by=() if right else (REFERENCE,),
        error=apart,
        predicted=2 * AGREEMENT,
        reason=f"{parameter} up to {found:.4g}, theory {expected:.4g}: then the mode of "
        f"{made.mode.coordinate} has h omega = {step * made.mode.omega:.4g} about {made.at.name}",
        values={
            "found": found,
            "theory": expected,
            "h_omega": step * made.mode.omega,
            "omega": made.mode.omega,
        },
    )


def speed_row(of: Setting, rate: str, step: float) -> Row:
    """Return the speed from which a free spin is off by `SPEED_ERROR` after `TURNS` turns.

    The theory is where the method's scheme is, on the claimed equations.
    """
    row = replace(blank(of, "speed_limit", {}), step=step)
    scheme = of.method.scheme
    assert scheme is not None
    coordinate = rate.removesuffix("_dot")
    names = tuple(n for n in get_scene(of.case.scene).public_states if not n.startswith(coordinate))
    names = (coordinate, *names)

    @cache
    def solution(speed: float) -> Truth:
        case, own, numbers = prepared(speed)
        start = own.start(case)
        return truth_of(
            own, solve(own.scene, own.parameters, start, numbers * step, 0.0, TOLERANCES), names
        )

    def off(values: Array, right: Truth) -> bool:
        size = np.maximum(right.size, SMALL * np.max(right.size))
        size[0] = 2 * np.pi  # of the angle: turns
        with np.errstate(all="ignore"):
            share = np.abs(values - right.values) / size[:, None]
        return bool(not np.all(share <= SPEED_ERROR))

    def prepared(speed: float) -> tuple[Case, ModelEquations, Array]:
        span = TURNS * 2 * np.pi / speed
        numbers = np.unique(np.rint(np.linspace(0, max(8, span / step), 17)[1:]).astype(int))
        case = replace(of.case, state={coordinate: 0.3, rate: speed}, horizon=numbers[-1] * step)
        return case, Setup(of.engine, case, of.model).equations, numbers

    def bad_scheme(speed: float) -> bool:
        case, own, numbers = prepared(speed)
        states = Setup(of.engine, case, of.model, of.method).scheme_states(step, numbers)
        found = own.scene.observe(states, own.parameters)
        return off(np.array([found[name] for name in names]), solution(speed))

    def bad_run(speed: float) -> bool:
        case, _, numbers = prepared(speed)
        try:
            found = run(Setup(of.engine, case, of.model, of.method, step), numbers * step)
        except EngineError:
            return True
        return off(found.matrix(names), solution(speed))

    first = SLOW / step
    try:
        expected = bisected(bad_scheme, first, 4 * first)
        found = bisected(bad_run, first, 4 * first)
    except MbcheckError as error:
        return replace(row, outcome=SKIPPED, reason=str(error))
    apart = abs(found / expected - 1)
    right = apart <= AGREEMENT
    return replace(
        row,
        changed={rate: found},
        outcome=RIGHT if right else WRONG,
        noticed_by=() if right else (REFERENCE,),
        error=apart,
        predicted=AGREEMENT,
        reason=f"{rate} up to {found:.4g} rad/s, its scheme {expected:.4g}: "
        f"{2 * np.pi / found / step:.3g} steps per turn leave {SPEED_ERROR:g} "
        f"after {TURNS:g} turns",
        values={"found": found, "theory": expected, "h_omega": step * found, "omega": found},
    )


TOLERANCES = (1e-8, 1e-7)
"""Of the solution that an error of `SPEED_ERROR` is told by."""

SLOW = 2 * np.pi / 100
"""Angle per step from which a limit is looked for."""

SMALL = 1e-3
"""Share of the largest size that counts as a size."""

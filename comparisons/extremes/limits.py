"""Where methods stop being stable: measured by bisection on runs, beside the theory.

The theory is the largest step of the amplification matrix; what is to be found exactly is the
same bisection on that matrix, from the same start, by the same measure (`vibrations`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, partial

import numpy as np

from ...reference import SCENES
from ...reference.amplification import GROWTH
from ...reference.errors import EngineError, MbcheckError
from ...reference.scene import Array, Case
from ...reference.solve.single import solve
from ..checks.free_vibrations import step_limit
from ..checks.suite import best_method
from ..checks.truth import Truth, truth_of
from ..engines.registry import get_engine
from ..engines.setup import Setup
from ..scenes.data import scene_data
from ..scenes.extremes import FreeVibration
from .judge import Sampled
from .row import (
    FAILED,
    REFERENCE,
    REFUSED,
    RIGHT,
    WRONG,
    Provocation,
    Row,
    detected_by,
    rules_against,
)
from .vibrations import AMPLITUDE, PERIODS, Vibration, free_case, vibration

SECTION = "limits"

STEPS = 200
"""In place of `PERIODS` where a parameter is varied at a fixed step."""

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

FEWER, MORE = 6.0, 24.0
"""Segments of a chain beside the default: its fastest mode goes with the square of them."""


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


def tasks(scenes: tuple[str, ...], engines: tuple[str, ...], full: bool) -> list[Provocation]:
    """Return a task for each scene that tells its free vibrations, engine and model."""
    return [
        Provocation(
            SECTION, scene, f"limits of {model}", name, partial(limits, scene, name, model, full)
        )
        for scene in scenes or tuple(SCENES)
        if free_vibration(scene)
        for name in engines
        for model in get_engine(name).distinct_models(scene)
    ]


def free_vibration(scene: str) -> FreeVibration | None:
    """Return what makes a scene vibrate freely, None if it does not tell."""
    return scene_data(scene, "extremes", "FREE_VIBRATION", None)


def free_setup(scene: str, engine_name: str, model: str, **changes: float) -> Setup:
    """Return a model of a scene without forces and dampers.

    Raises
    ------
    MbcheckError
        If the scene does not tell its free vibrations.
    """
    free = free_vibration(scene)
    if free is None:
        raise MbcheckError(f"{scene} does not tell its free vibrations")
    return Setup(get_engine(engine_name), free_case(scene, free, model, **changes), model)


def limits(scene: str, engine_name: str, model: str, full: bool = False) -> list[Row]:
    """Return the limits of step, stiffness, damping and speed of all methods of a model."""
    setup = free_setup(scene, engine_name, model)
    rows = [step_row(replace(setup, method=method)) for method in setup.engine.methods]
    if setup.element_order and not setup.approximates_continuum:  # a chain
        for segments in (FEWER, MORE) if full else (FEWER,):
            other = free_setup(scene, engine_name, model, segments=segments)
            rows.append(step_row(replace(other, method=best_method(other)), segments=segments))
    return rows + [row for one in explicit_setups(setup) for row in parameter_rows(one, full)]


def explicit_setups(setup: Setup) -> Iterator[Setup]:
    """Yield the best explicit method, and semi-implicit Euler, of those that a model takes."""
    all_methods = (replace(setup, method=method) for method in setup.engine.methods)
    fit = [one for one in all_methods if one.integrator.scheme and one.why_not is None]
    top = max(fit, key=lambda one: one.integrator.order, default=None)
    for one in fit:
        if one is top or one.integrator.scheme == "semi_implicit_euler":
            yield one


# Steps --------------------------------------------------------------------------------------


def step_row(setup: Setup, **changed: float) -> Row:
    """Return the largest stable step of a method, measured and by theory, and who notices."""
    row = step_limit_row(setup, Row.of(SECTION, "step_limit", setup, changed=changed))
    if row.outcome not in (WRONG, FAILED) or row.step is None or "theory" in row.values:
        return row  # beside a limit all steps are coarse: no rule tells that it is a wrong one
    rules = rules_against(setup.with_step(row.step), STEPS * row.step)
    first, last = (row.noticed_by, rules) if row.outcome == FAILED else (rules, row.noticed_by)
    return replace(row, noticed_by=(*first, *last))


def step_limit_row(setup: Setup, row: Row) -> Row:
    """Return the row of the largest stable step of a method, measured and by theory."""
    if setup.why_not is not None:
        return row.refused(setup.why_not)
    if setup.approximates_continuum:
        return elements_row(setup, row)
    scheme = setup.linear_scheme
    if scheme is None:
        return row.skipped("no theory of this method")
    free = vibration(setup, scheme)
    omega = free.mode.omega
    theory = step_limit(scheme, free.at, PERIODS * 2 * np.pi / omega)
    words = f"mode of {free.mode.coordinate}, {omega:.5g} rad/s about {free.at.name}"
    if not np.isfinite(theory):
        return unlimited(
            row,
            words,
            omega,
            lambda step: free.by_run(step, STEPS * step),
            lambda step: max(GROWTH, OVERSHOOT * free.by_matrix(scheme, step, STEPS * step)),
        )
    horizon, around = PERIODS * 2 * np.pi / omega, (theory / 4, 4 * theory)
    try:
        expected = bisected(lambda h: free.by_matrix(scheme, h, horizon) > GROWTH, *around)
        measured = bisected(lambda h: free.grows_in_run(h, horizon), *around)
    except EngineError as error:
        row = replace(row, values={"theory": theory * omega, "omega": omega})
        return row.refused(
            f"{error.message}; {words}, theory {theory:.4g} s", (detected_by(error),)
        )
    except MbcheckError as error:
        return replace(row, outcome=WRONG, noticed_by=(REFERENCE,), reason=f"{words}: {error}")
    return replace(
        row.compared(measured, expected, AGREEMENT),
        step=measured,
        reason=f"{words}: h omega = {measured * omega:.4g}, theory {theory * omega:.4g}, from this "
        f"start {expected * omega:.4g}",
        values={
            "h_omega": measured * omega,
            "theory": theory * omega,
            "expected": expected * omega,
            "omega": omega,
        },
    )


OVERSHOOT = 1.01
"""On what the matrix makes of a start: rounding with steps of a thousand periods."""


def unlimited(
    row: Row,
    words: str,
    omega: float,
    measured: Callable[[float], float],
    granted: Callable[[float], float] = lambda step: GROWTH,
) -> Row:
    """Return the row of a method without a limit, that must bear `UNLIMITED` periods in a step.

    Generalized-alpha is stable and yet multiplies a start before it settles: as much as its
    matrix does is ``granted``. The step of the row is the shortest that is not borne, if there is
    one; ``borne`` is the longest that is [s].
    """
    words += ": none by theory"
    values = {"omega": omega}
    row = replace(row, outcome=RIGHT)
    for periods in UNLIMITED:
        step = periods * 2 * np.pi / omega
        words += f"; with {periods:g} periods in a step "
        try:
            growth, most = measured(step), granted(step)
        except EngineError as error:
            words += f"{error.kind}: {error.message}"
            outcome = REFUSED if error.kind == "step" else FAILED
            row = replace(row, step=step, outcome=outcome, noticed_by=(detected_by(error),))
            continue
        if growth <= most:
            words += f"at most {growth:.3g} times as large as it is"
            values["borne"] = step
            break
        words += f"{growth:.3g} times as large as it is, {most:.3g} granted"
        row = replace(row, step=step, outcome=WRONG, noticed_by=(REFERENCE,))
    step = step if row.step is None else row.step
    return replace(row, step=step, reason=words, values={"h_omega": step * omega, **values})


def elements_row(setup: Setup, row: Row) -> Row:
    """Return the row of a continuum by elements: a free hub that starts against its beam."""
    free = free_vibration(setup.scene.name)
    if free is None or free.release is None:
        return row.skipped("no theory of these elements")
    release = free.release
    p = setup.case.parameters.replace(**release.changes)
    case = replace(setup.case, parameters=p, state={release.rate: AMPLITUDE})
    period = float(setup.scene.period(p))
    size = AMPLITUDE * period * getattr(p, release.length)
    omega = 2 * np.pi / period

    def growth(step: float) -> float:
        run = setup.with_case(case).simulate(step, np.arange(1.0, STEPS + 1))
        return float(np.max(np.abs(run.values[release.observable]))) / size

    return unlimited(row, f"first mode at rest, {omega:.5g} rad/s", omega, growth)


# Parameters at a given step -----------------------------------------------------------------


def parameter_rows(setup: Setup, full: bool) -> list[Row]:
    """Return the largest stiffness, damping and speed at the default step.

    A spin with a soft loop, whose equations take a minute to solve, is left to ``full``.
    """
    free = free_vibration(setup.scene.name)
    assert free is not None  # as for the setup
    default = setup.with_case(Case(setup.scene.name, "default", setup.case.parameters, {}))
    setup = setup.with_step(default.default_step)
    named = {"stiffness_limit": free.stiffness, "damping_limit": free.damping}
    rows = [parameter_row(setup, name, which) for name, which in named.items() if which]
    if free.speed is None:
        return rows
    if free.speed in setup.scene.parameters.names():
        rows.append(parameter_row(setup, "speed_limit", free.speed))
    elif full or not setup.has_soft_closure:
        rows.append(speed_row(setup, free.speed))
    return rows


def parameter_row(setup: Setup, name: str, parameter: str) -> Row:
    """Return the largest value of a parameter with which a step stays stable."""
    row = Row.of(SECTION, name, setup)
    scheme, step = setup.linear_scheme, setup.step_size
    if scheme is None:
        return row.skipped("no theory of this method")
    usual = getattr(setup.scene.parameters(), parameter)
    horizon = STEPS * step

    def at(value: float) -> Vibration:
        p = setup.case.parameters.replace(**{parameter: value})
        return vibration(setup.with_case(replace(setup.case, parameters=p)), scheme, step)

    def unstable_by_matrix(value: float) -> bool:
        return at(value).by_matrix(scheme, step, horizon) > GROWTH

    def unstable_by_run(value: float) -> bool:
        return at(value).grows_in_run(step, horizon)

    widest = WIDEST * usual
    try:
        if not unstable_by_matrix(widest):
            bad = unstable_by_run(widest)
            return replace(
                row,
                changed={parameter: widest},
                outcome=WRONG if bad else RIGHT,
                noticed_by=(REFERENCE,) if bad else (),
                reason=f"none by theory; {'not ' if bad else ''}bounded with {parameter} = "
                f"{widest:.3g}",
                values={"found": widest},
            )
        expected = bisected(unstable_by_matrix, usual, 4 * usual)
        measured = bisected(unstable_by_run, usual, 4 * usual)
    except EngineError as error:
        return row.refused(error.message, (detected_by(error),))
    except MbcheckError as error:
        return replace(row, outcome=WRONG, noticed_by=(REFERENCE,), reason=str(error))
    free = at(measured)
    omega = free.mode.omega
    return replace(
        row.compared(measured, expected, 2 * AGREEMENT),  # a frequency goes with a root, or a rate
        changed={parameter: measured},  # with all of it
        reason=f"{parameter} up to {measured:.4g}, theory {expected:.4g}: then the mode of "
        f"{free.mode.coordinate} has h omega = {step * omega:.4g} about {free.at.name}",
        values={"found": measured, "theory": expected, "h_omega": step * omega, "omega": omega},
    )


def speed_row(setup: Setup, rate: str) -> Row:
    """Return the speed from which a free spin is off by `SPEED_ERROR` after `TURNS` turns.

    The theory is where the method's scheme is, on the model's equations.
    """
    row, step = Row.of(SECTION, "speed_limit", setup), setup.step_size
    coordinate = rate.removesuffix("_dot")
    names = tuple(n for n in setup.scene.public_states if not n.startswith(coordinate))
    names = (coordinate, *names)

    def spin(speed: float) -> Sampled:
        span = TURNS * 2 * np.pi / speed
        samples = np.unique(np.rint(np.linspace(0, max(8, span / step), 17)[1:]).astype(int))
        case = replace(setup.case, state={coordinate: 0.3, rate: speed}, horizon=samples[-1] * step)
        return Sampled(setup.with_case(case), samples)

    @cache
    def solution(speed: float) -> Truth:
        at, samples = spin(speed)
        scene, parameters = at.equations.scene, at.equations.parameters
        solved = solve(
            scene, parameters, at.equations.start(at.case), samples * step, 0.0, TOLERANCES
        )
        return truth_of(at.equations, solved, names)

    def is_off(speed: float, values: Array) -> bool:
        right = solution(speed)
        size = np.maximum(right.size, SMALL * np.max(right.size))
        size[0] = 2 * np.pi  # of the angle: turns
        with np.errstate(all="ignore"):
            share = np.abs(values - right.values) / size[:, None]
        return bool(not np.all(share <= SPEED_ERROR))

    def bad_scheme(speed: float) -> bool:
        at, samples = spin(speed)
        observed = at.equations.scene.observe(
            at.scheme_states(step, samples), at.equations.parameters
        )
        return is_off(speed, np.array([observed[name] for name in names]))

    def bad_run(speed: float) -> bool:
        at, samples = spin(speed)
        try:
            run = at.simulate(step, samples)
        except EngineError:
            return True
        return is_off(speed, run.matrix(names))

    first = SLOW / step
    try:
        expected, measured = (bisected(bad, first, 4 * first) for bad in (bad_scheme, bad_run))
    except MbcheckError as error:
        return row.skipped(error)
    return replace(
        row.compared(measured, expected, AGREEMENT),
        changed={rate: measured},
        reason=f"{rate} up to {measured:.4g} rad/s, its scheme {expected:.4g}: "
        f"{2 * np.pi / measured / step:.3g} steps per turn leave {SPEED_ERROR:g} "
        f"after {TURNS:g} turns",
        values={
            "found": measured,
            "theory": expected,
            "h_omega": step * measured,
            "omega": measured,
        },
    )


TOLERANCES = (1e-8, 1e-7)
"""Of the solution that an error of `SPEED_ERROR` is told by."""

SLOW = 2 * np.pi / 100
"""Angle per step from which a limit is looked for."""

SMALL = 1e-3
"""Share of the largest size that counts as a size."""

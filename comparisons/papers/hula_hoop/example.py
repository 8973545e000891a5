"""Measures of the hula_hoop paper's motions: section 5.1, transients, and where region II ends."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from ....reference import get_scene
from ....reference.continuation.along import BoundaryAlong
from ....reference.hula_hoop.equations import PLATE, HulaHoop
from ....reference.hula_hoop.floquet import floquet_multipliers
from ....reference.hula_hoop.theory import corrected_solution, paper_solution
from ....reference.scene import Array, Case
from ...checks.boundary import engine_point
from ...engines.registry import REFERENCE
from ...engines.setup import Setup
from ...queries.query import choose_engine, choose_method
from ...scenes.hula_hoop import motion as motions
from ...scenes.hula_hoop.floquet import EXACT
from ...scenes.hula_hoop.steps import step_counts
from ...scenes.quantity import Flow, Points
from ..ledger import Numbers
from ..session import Session
from .results import (
    APPROXIMATIONS,
    EXAMPLE,
    SAMPLES,
    SCENE,
    approximation_errors,
    example_from_rest,
    example_orbit,
    example_rotation,
    grid,
    is_class,
    lock_in,
    motion_map,
    second_harmonic,
    value_range,
)

OMEGA = 2 * np.pi * float(EXAMPLE.force_frequency)


def printed_solution(session: Session) -> Numbers:
    """Return the amplitudes of the printed solution [mm, rad], and its range of speeds [rad/s]."""
    solution = paper_solution(EXAMPLE)
    u_1 = abs(float(solution.u_1))
    return {
        "paper": 1e3 * abs(float(solution.q_1)) * float(EXAMPLE.rod_length),
        "u_1": u_1,
        "slowest": (1 - 2 * u_1) * OMEGA,
        "fastest": (1 + 2 * u_1) * OMEGA,
        "second": second_harmonic(example_orbit(session)),
    }


def rotation(session: Session, who: str) -> Numbers:
    """Return what the true rotation at 3 Hz and 60 N is like.

    Whether it is stable, and its largest multiplier; the mean slope of theta [rad/s], and how far
    it is from omega, relative to it; the mean of theta - omega t [rad]; the amplitude of y at the
    frequency of the force [mm]. The largest other harmonic of y and of theta over the first and
    the second, and the larger of both. The range of theta' [rad/s], and its width by omega.
    """
    report, run = example_orbit(session, who), example_rotation(session, who)
    slow, fast = value_range(run.times, run.observables["theta_dot"])
    speed = report.mean_speed or 0.0
    first, *others = (term.amplitude for term in report.harmonics["y"].terms)
    angle = report.harmonics["theta"]
    phase, terms = angle.mean, angle.terms
    rest = max(others) / first
    theta = max(term.amplitude for term in terms if term.order != 2) / second_harmonic(report)
    return {
        "stable": report.stable,
        "multiplier": report.floquet_multipliers[0].modulus,
        "speed": speed,
        "off": abs(speed / OMEGA - 1),
        "mean_phase": float(phase),
        "first": 1e3 * first,
        "rest": rest,
        "theta": theta,
        "other": max(rest, theta),
        "slow": slow,
        "fast": fast,
        "width": (fast - slow) / OMEGA,
    }


def motion_from_rest(session: Session, who: str) -> Numbers:
    """Return how the motion from rest locks in, and what its angular velocity does then.

    When it last slips and reverses [s], and how it turns then; the least theta' of the last
    period, and the frequency of the largest peak of theta' over the last 12 periods, by omega.
    """
    run, periods = example_from_rest(session, who), 12
    theta_dot = run.observables["theta_dot"]
    end = lock_in(run.times, run.observables["theta"], theta_dot)
    window = theta_dot[-periods * SAMPLES :]
    spectrum = np.abs(np.fft.rfft((window - window.mean()) * np.hanning(len(window))))
    ratio = float(np.argmax(spectrum)) / periods
    return {
        "value": end.last_reversal,
        "slip": end.last_slip,
        "turns": abs(end.turns - 1),
        "least": end.least_speed,
        "settled": end.settled,
        "ratio": ratio,
        "off": abs(ratio - 2),
    }


def errors_of_solutions(session: Session) -> Numbers:
    """Return errors of the approximate solutions: y [mm], over its size, theta [rad].

    And how much of that of theta Newton's method leaves.
    """
    size = example_orbit(session).harmonics["y"].terms[0].amplitude
    errors = approximation_errors(session)
    left, left_with_phase = (
        errors[name][1] / errors["paper"][1] for name in ("refined", "corrected")
    )
    return {"left": left, "left_with_phase": left_with_phase} | {
        f"{name}{suffix}": error
        for name, (y, theta, *_) in errors.items()
        for suffix, error in (("", 1e3 * y), ("_share", y / size), ("_theta", theta))
    }


def multipliers(session: Session) -> Numbers:
    """Return the largest multipliers of approximate solutions, and with (55) as printed."""
    solutions = {name: APPROXIMATIONS[name](EXAMPLE) for name in ("paper", "corrected")}
    right = {name: floquet_multipliers(item, EXAMPLE) for name, item in solutions.items()}
    printed = floquet_multipliers(solutions["paper"], EXAMPLE, as_printed=True)
    return {name: abs(item[0]) for name, item in (right | {"printed": printed}).items()}


TRANSIENT, PASSING, LASTING = 100, 4, 20
"""Periods of the force that count as transient, and that hula-hoop motion takes in it at least."""


def transients(session: Session, plate: bool = False) -> Numbers:
    """Return at which share of cyan o there is hula-hoop motion, as in the table, on the way there.

    For 4 and 20 periods: a turn in each, one way, and theta' oscillating most at 2 omega.
    """
    motion = motion_map(session, plate)
    rows, columns = np.nonzero(is_class(motion, "motion", "cyan_o"))
    if not len(rows):
        return {"passing": 0.0, "lasting": 0.0, "count": 0}
    hertz = motion.x.values[columns]
    p = grid(session, plate).replace(force_frequency=hertz, force_amplitude=motion.y.values[rows])
    places = np.stack([columns, rows], axis=1)
    points = Points(get_scene(SCENE), p, places, {}, REFERENCE, EXACT)
    spacing = 1 / (motions.OPTIONS.samples * hertz)
    begin = np.zeros((4, len(hertz)))
    path = Flow(points, points.scene)(
        np.arange(len(hertz)), begin, 0.0, spacing, TRANSIENT * motions.OPTIONS.samples,
        step_counts(points, spacing, motions.OPTIONS.steps),
    )  # fmt: skip
    theta, speed = path[1] / (2 * np.pi), path[3]
    shares = {}
    for name, periods in (("passing", PASSING), ("lasting", LASTING)):
        there = np.zeros(len(hertz), dtype=bool)
        for start in range(TRANSIENT - periods):
            part = slice(
                start * motions.OPTIONS.samples, (start + periods) * motions.OPTIONS.samples
            )
            turns = theta[:, part.stop] - theta[:, part.start]
            one_way = np.all(np.sign(turns)[:, None] * speed[:, part] > 0, axis=1)
            locked = np.abs(np.abs(turns) - periods) < motions.OPTIONS.slack
            f_u = motions.strongest(speed[:, part], periods)
            there |= locked & one_way & (np.abs(f_u - 2) < motions.OPTIONS.near)
        shares[name] = float(np.mean(there))
    return {**shares, "count": len(hertz)}


def transients_of_both(session: Session) -> Numbers:
    """Return these shares in figure 5, and as lists in figures 5 and 7."""
    first, second = (transients(session, plate) for plate in (False, True))
    return {**first, "both": [[one["passing"], one["lasting"]] for one in (first, second)]}


LINES = (4.5, 5.0, 5.5, 6.0)
"""Frequencies [Hz] at which region II lies below region I."""

FORCES = np.linspace(5.0, 300.0, 119)
"""Of our axis and as far again, among which the last stable one is looked for [N]."""

NEAR = {False: (32.0, 28.0, 23.0, 18.0), True: (110.0, 95.0, 78.0, 61.0)}
"""Forces [N] near the end without and with inertia, from which it is sought."""

STEPS = 80
"""Of engines in a period."""

FORMULAS = {
    "printed": (paper_solution, True),
    "paper": (paper_solution, False),
    "corrected": (corrected_solution, False),
}


def ends(session: Session, plate: bool) -> list[BoundaryAlong]:
    """Return where the true symmetric rotation loses its stability on each line."""
    p = PLATE if plate else HulaHoop()
    starts = zip(LINES, NEAR[plate], strict=True)
    points = [
        BoundaryAlong(
            get_scene(SCENE),
            p.replace(force_frequency=line, force_amplitude=force),
            "period_doubling",
            "force_amplitude",
        )
        for line, force in starts
    ]
    return session.once((SCENE, "ends of region II", plate), lambda: points)


def formula_end(name: str, p: HulaHoop) -> float:
    """Return the force [N] at which a multiplier of an approximate solution leaves the unit circle.

    The last of `FORCES` where none does below it.
    """
    solution, as_printed = FORMULAS[name]

    def outside(force: Array | float) -> Array:
        here = p.replace(force_amplitude=force)
        return np.abs(floquet_multipliers(solution(here), here, as_printed=as_printed)[0]) - 1

    values = outside(FORCES)
    crossed = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
    if not crossed.size:
        return float(FORCES[-1])
    low, high = FORCES[crossed[0]], FORCES[crossed[0] + 1]
    return float(brentq(lambda force: float(outside(force)), low, high, xtol=1e-9))


def distances(session: Session, plate: bool) -> Numbers:
    """Return the ends by all formulas and the reference [N], and how far they are apart."""
    points = ends(session, plate)
    true = np.array([one.value(one.solution[1].z[-1]) for one in points])
    numbers: dict[str, object] = {"exact": true}
    for name in FORMULAS:
        own = np.array([formula_end(name, one.parameters) for one in points])
        numbers |= {
            name: np.max(np.abs(own - true)),
            f"{name}_share": np.max(np.abs(own - true) / true),
        }
    return numbers


def distances_by(session: Session, who: str, plate: bool) -> Numbers:
    """Return the ends of the reference [N], or how far those of an engine are from them."""
    points = ends(session, plate)
    if who == REFERENCE:
        return {"first": points[0].value(points[0].solution[1].z[-1]),
                "last": points[-1].value(points[-1].solution[1].z[-1])}  # fmt: skip
    off = []
    for one in points:
        case = Case(SCENE, "point", one.parameters)
        engine, model = choose_engine(who, case, None)
        setup = Setup(engine, case, model, choose_method(engine, case, model, None))
        true = one.solution[1].z
        off.append(one.unit * abs(engine_point(setup, one, STEPS, true).z[-1] - true[-1]))
    return {"off": max(off)}

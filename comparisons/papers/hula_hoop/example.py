"""Measures of the hula_hoop paper's motions: section 5.1, transients, and the end of region II."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from ....reference import get_scene
from ....reference.continuation.along import BoundaryAlong
from ....reference.hula_hoop.equations import PLATE, HulaHoop
from ....reference.hula_hoop.floquet import floquet_multipliers
from ....reference.hula_hoop.theory import corrected_solution, paper_solution
from ....reference.scene import Array, Case
from ....reference.solve.rk8 import rk8_steps
from ...checks.boundary import engine_point
from ...engines.registry import REFERENCE
from ...engines.setup import Setup
from ...queries.query import choose_engine, choose_method
from ...scenes.hula_hoop.floquet import EXACT
from ...scenes.hula_hoop.motion import OPTIONS, strongest
from ...scenes.hula_hoop.steps import step_counts
from ...scenes.quantity import Flow, Points
from ..ledger import Numbers
from ..session import Session, once
from .results import (
    APPROXIMATIONS,
    EXAMPLE,
    LOCKED,
    LONG_RUN,
    PLATES,
    SAMPLES,
    SCENE,
    LockIn,
    approximation_errors,
    example_from_rest,
    example_orbit,
    example_rotation,
    grid,
    lock_in,
    motion_map,
    moves,
    samples,
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
    """Return the properties of the true rotation at 3 Hz and 60 N.

    Whether it is stable, and its largest multiplier; the mean slope of theta [rad/s], and its
    relative distance from omega; the mean of theta - omega t [rad]; the amplitude of y at the
    frequency of the force [mm]. The largest other harmonic of y and of theta over the first and
    the second, and the larger of both. The range of theta' [rad/s], and its width by omega.
    """
    report, run = example_orbit(session, who), example_rotation(session, who)
    slow, fast = value_range(run.times, run.observables["theta_dot"])
    speed = report.mean_speed or 0.0
    first, *others = (term.amplitude for term in report.harmonics["y"].terms)
    angle = report.harmonics["theta"]
    rest = max(others) / first
    theta = max(one.amplitude for one in angle.terms if one.order != 2) / second_harmonic(report)
    return {
        "stable": report.stable,
        "multiplier": report.floquet_multipliers[0].modulus,
        "speed": speed,
        "off": abs(speed / OMEGA - 1),
        "mean_phase": float(angle.mean),
        "first": 1e3 * first,
        "rest": rest,
        "theta": theta,
        "other": max(rest, theta),
        "slow": slow,
        "fast": fast,
        "width": (fast - slow) / OMEGA,
    }


def motion_from_rest(session: Session, who: str) -> Numbers:
    """Return the lock-in of the motion from rest, and its angular velocity then.

    Times of the last slip and reversal [s], and turns per period; the least theta' of the last
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

    And the share of the printed solution's error of theta that Newton's method leaves.
    """
    size = example_orbit(session).harmonics["y"].terms[0].amplitude
    errors, numbers = approximation_errors(session), {}
    for name, (y, theta, *_) in errors.items():
        numbers |= {name: 1e3 * y, f"{name}_share": y / size, f"{name}_theta": theta}
    left = [errors[name][1] / errors["paper"][1] for name in ("refined", "corrected")]
    return {"left": left[0], "left_with_phase": left[1], **numbers}


def multipliers(session: Session) -> Numbers:
    """Return the largest multipliers of approximate solutions, and with (55) as printed."""
    cases = {
        "paper": ("paper", False),
        "corrected": ("corrected", False),
        "printed": ("paper", True),
    }
    return {
        name: abs(floquet_multipliers(APPROXIMATIONS[which](EXAMPLE), EXAMPLE, as_printed)[0])
        for name, (which, as_printed) in cases.items()
    }


def power(session: Session) -> Numbers:
    """Return the mean powers of the force and of the hinge's friction [W], true rotation."""
    powers = example_orbit(session).power
    return {"hinge": -powers["hinge"], "force": powers["force"]}


TRANSIENT, PASSING, LASTING = 100, 4, 20
"""Periods of the force that count as transient, and that hula-hoop motion takes in it at least."""


def transients(session: Session, plate: bool = False) -> Numbers:
    """Return the share of cyan o with passing hula-hoop motion, as in the table, on the way there.

    For 4 and 20 periods: a turn in each, one way, and theta' oscillating most at 2 omega.
    """
    motion, samples = motion_map(session, plate), OPTIONS.samples
    rows, columns = np.nonzero(moves(session, plate, "cyan_o"))
    if not len(rows):
        return {"passing": 0.0, "lasting": 0.0, "count": 0}
    hertz = motion.x.values[columns]
    p = grid(session, plate).replace(force_frequency=hertz, force_amplitude=motion.y.values[rows])
    places = np.stack([columns, rows], axis=1)
    points = Points(get_scene(SCENE), p, places, {}, REFERENCE, EXACT)
    spacing = 1 / (samples * hertz)
    path = Flow(points, points.scene)(
        np.arange(len(hertz)), np.zeros((4, len(hertz))), 0.0, spacing, TRANSIENT * samples,
        step_counts(points, spacing, OPTIONS.steps),
    )  # fmt: skip
    theta, speed = path[1] / (2 * np.pi), path[3]
    shares = {}
    for name, periods in (("passing", PASSING), ("lasting", LASTING)):
        there = np.zeros(len(hertz), dtype=bool)
        for start in range(TRANSIENT - periods):
            part = slice(start * samples, (start + periods) * samples)
            turns = theta[:, part.stop] - theta[:, part.start]
            one_way = np.all(np.sign(turns)[:, None] * speed[:, part] > 0, axis=1)
            locked = np.abs(np.abs(turns) - periods) < OPTIONS.slack
            f_u = strongest(speed[:, part], periods)
            there |= locked & one_way & (np.abs(f_u - 2) < OPTIONS.near)
        shares[name] = float(np.mean(there))
    return {**shares, "count": len(hertz)}


def transients_of_both(session: Session) -> Numbers:
    """Return these shares in figure 5, and as lists in figures 5 and 7."""
    first, second = (transients(session, plate) for plate in PLATES)
    return {**first, "both": [[one["passing"], one["lasting"]] for one in (first, second)]}


# The end of region II

LINES = (4.5, 5.0, 5.5, 6.0)
"""Frequencies [Hz] at which region II lies below region I."""

FORCES = np.linspace(5.0, 300.0, 119)
"""Forces among which the last stable one is sought [N]: our axis and as far again."""

NEAR = {False: (32.0, 28.0, 23.0, 18.0), True: (110.0, 95.0, 78.0, 61.0)}
"""Forces [N] near the end without and with inertia, from which it is sought."""

STEPS = 80
"""Steps of engines in a period."""

FORMULAS = {
    "printed": (paper_solution, True),
    "paper": (paper_solution, False),
    "corrected": (corrected_solution, False),
}


@once
def ends(session: Session, plate: bool) -> list[BoundaryAlong]:
    """Return where the true symmetric rotation loses its stability on each line."""
    p, kind = PLATE if plate else HulaHoop(), ("period_doubling", "force_amplitude")
    return [
        BoundaryAlong(
            get_scene(SCENE), p.replace(force_frequency=line, force_amplitude=force), *kind
        )
        for line, force in zip(LINES, NEAR[plate], strict=True)
    ]


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


def distances(session: Session, who: str, plate: bool) -> Numbers:
    """Return the first and last end [N], and the distances of all formulas from the ends.

    For an engine, the largest distance of its ends from those of the reference.
    """
    points = ends(session, plate)
    true = np.array([one.value(one.solution[1].z[-1]) for one in points])
    numbers = {"first": true[0], "last": true[-1]}
    for name in FORMULAS if who == REFERENCE else ():
        off = np.abs(np.array([formula_end(name, one.parameters) for one in points]) - true)
        numbers |= {name: np.max(off), f"{name}_share": np.max(off / true)}
    if who == REFERENCE:
        return numbers
    off = []
    for one in points:
        case = Case(SCENE, "point", one.parameters)
        engine, model = choose_engine(who, case, None)
        setup = Setup(engine, case, model, choose_method(engine, case, model, None))
        z = one.solution[1].z
        off.append(one.unit * abs(engine_point(setup, one, STEPS, z).z[-1] - z[-1]))
    return {"off": max(off)}


# Readings


def from_rest(p: HulaHoop, angles: Array | float = 0.0) -> list[LockIn]:
    """Return the lock-in of motions at 3 Hz from rest at some angles [rad], by the reference."""
    count = np.broadcast(p.damping_ratio, p.hinge_damping_ratio, angles).size
    times = samples(LONG_RUN)
    states = np.zeros((4, len(times), count))
    states[1, 0] = angles
    derivative = get_scene(SCENE).right_hand_side(p)
    for i in range(len(times) - 1):
        states[:, i + 1] = rk8_steps(derivative, states[:, i], times[i], times[i + 1], 1)
    return [lock_in(times, states[1, :, i], states[3, :, i]) for i in range(count)]


def in_words(end: LockIn) -> str:
    """Return a lock-in in words."""
    if abs(end.turns) < LOCKED:
        return "no lock-in, no turns in the end"
    if abs(end.turns - 1) > LOCKED:  # chaos: how many turns depends on the last digit
        return "no lock-in, irregular turns"
    sense = "forwards" if end.direction > 0 else "backwards"
    backwards = "reverses to the end" if end.least_speed < 0 else "last reversal"
    return (
        f"locks in, turning {sense}; last slip {end.last_slip:.2f} s, {backwards} "
        f"{end.last_reversal:.2f} s"
    )


def damping_units(session: Session) -> Numbers:
    """Return the lock-in from rest by each reading of the damping of table 1."""
    mass = EXAMPLE.main_mass + EXAMPLE.free_mass
    rho = 0.1 / float(2 * mass * EXAMPLE.omega_n)
    zeta = 0.01 / float(EXAMPLE.free_mass * EXAMPLE.rod_length**2 * EXAMPLE.omega_n)
    per_metre = zeta * EXAMPLE.rod_length**2
    ratios = [(0.1, 0.01), (rho, zeta), (rho, 0.01), (0.1, zeta), (rho, per_metre), (0.05, 0.01),
              (0.1, 0.02)]  # fmt: skip
    damping, hinge = np.array(ratios).T
    p = EXAMPLE.replace(damping_ratio=damping, hinge_damping_ratio=hinge)
    return {"ends": [in_words(end) for end in from_rest(p)]}


def starts(session: Session) -> Numbers:
    """Return the lock-in from rest at angles near 0, and the robust share of figure 5."""
    angles = np.array([0.0, 1e-6, -1e-6, 1e-3, -1e-3, 1e-2, -1e-2, 0.1, -0.1])
    ends = [in_words(end) for end in from_rest(EXAMPLE, angles)]
    return {"ends": ends, "robust": np.mean(motion_map(session, False).variables["robust"] == 1)}

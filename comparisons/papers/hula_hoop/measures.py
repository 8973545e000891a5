"""Measures of the hula_hoop paper, and the orbits, runs and maps that they and the figures share.

The paper's equations themselves are texts in ``claims.toml``. An identity is judged at one motion
of the form (16), (17) that solves nothing, `TRIAL`, with s = alpha tau; where no motion is needed,
values are random.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from itertools import product
from math import factorial
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import binary_dilation
from scipy.ndimage import label as connected
from scipy.optimize import brentq
from scipy.special import jv
from scipy.stats import spearmanr

from ....reference import get_scene
from ....reference.continuation.along import BoundaryAlong
from ....reference.equations import scene_equations
from ....reference.hula_hoop import floquet, theory
from ....reference.hula_hoop.equations import (
    PLATE,
    SEMICIRCLE,
    HulaHoop,
    coefficients,
    drive,
    energy,
)
from ....reference.scene import Array
from ....reference.solve.rk8 import rk8_steps
from ...checks.boundary import engine_point
from ...checks.truth import random_states
from ...engines.registry import REFERENCE
from ...engines.run import contained
from ...maps.request import Axis
from ...maps.store import Map
from ...queries.orbit import OrbitReport, find
from ...queries.request import MethodQuery
from ...queries.simulate import Simulation, simulate
from ...scenes.hula_hoop.floquet import EXACT
from ...scenes.hula_hoop.motion import OPTIONS, strongest
from ...scenes.hula_hoop.steps import step_counts
from ...scenes.quantity import Flow, Points
from ..claims import read_paper
from ..equations import Values
from ..ledger import Numbers
from ..session import Session, once

SCENE = "hula_hoop"
EXAMPLE = HulaHoop()
"""Parameters of section 5.1: 3 Hz, 60 N, point mass."""

NATURAL = float(EXAMPLE.omega_n) / (2 * np.pi)
"""Natural frequency of the main mass [Hz]."""

HERTZ, NEWTON = (1.0, 10.0), (5.0, 150.0)
"""Axes of figs. 4-7; the text does not give them."""
POINTS, ENGINE_POINTS, FULL_POINTS = 31, 11, 64
"""Points along an axis of the reference's maps, of the engines' (every third), and with --full."""

SAMPLES = 64
"""Samples of a motion in a period of the force."""
LOCKED = 0.03
"""Largest distance of turns per period from 1 while the phase still oscillates."""
LONG_RUN = 12.0
"""Duration of runs from rest [s]: eight times the transient of fig. 3."""

APPROXIMATIONS = {
    "paper": theory.paper_solution,
    "refined": theory.refined_solution,
    "corrected": theory.corrected_solution,
}
FORMULAS = {
    "printed": (theory.paper_solution, True),
    "paper": (theory.paper_solution, False),
    "corrected": (theory.corrected_solution, False),
}
"""Approximate solutions, and whether (55) is taken as printed."""
STATES = ("y", "theta", "y_dot", "theta_dot")


def samples(seconds: float) -> Array:
    """Return sample times from 0 [s], whole fractions of the example's period."""
    rate = SAMPLES * EXAMPLE.force_frequency
    return np.arange(round(seconds * rate) + 1) / rate


# The example of section 5.1


@once
def example_orbit(session: Session, engine: str = REFERENCE) -> OrbitReport:
    """Return the true rotation."""
    return find(MethodQuery(SCENE, engine=engine), bounded=False)


@once
def example_from_rest(session: Session, engine: str = REFERENCE) -> Simulation:
    """Return the motion from rest."""
    return simulate(SCENE, engine=engine, times=samples(LONG_RUN))


@once
def example_rotation(session: Session, engine: str = REFERENCE) -> Simulation:
    """Return three periods of the true rotation."""
    state = dict(example_orbit(session, engine).state)
    return simulate(SCENE, engine=engine, state=state, times=samples(1.0))


def second_harmonic(report: OrbitReport) -> float:
    """Return the amplitude u_1 of theta at twice the frequency of the force [rad]."""
    return next(term.amplitude for term in report.harmonics["theta"].terms if term.order == 2)


def approximate_states(name: str) -> Array:
    """Return the states (4, n_t) of an approximate solution over three periods."""
    return APPROXIMATIONS[name](EXAMPLE).state(samples(1.0), EXAMPLE)


def states(run: Simulation) -> Array:
    """Return the states (4, n_t) of a run."""
    return np.array([run.observables[name] for name in STATES])


def apart(own: Array, truth: Array) -> Array:
    """Return |difference| of states (4, n_t), angles on the circle."""
    gap = own - truth
    gap[1] = (gap[1] + np.pi) % (2 * np.pi) - np.pi
    return np.abs(gap)


def approximation_errors(session: Session) -> dict[str, Array]:
    """Return the largest errors (4,) of the approximate solutions against the true rotation."""
    truth = states(example_rotation(session))
    return {name: apart(approximate_states(name), truth).max(axis=1) for name in APPROXIMATIONS}


def value_range(times: Array, values: Array) -> tuple[float, float]:
    """Return the smallest and the largest value of samples (n_t,), between them by splines."""
    spline = CubicSpline(times, values)
    every = np.concatenate([values, spline(spline.derivative().roots(extrapolate=False))])
    return float(every.min()), float(every.max())


def lock_in(times: Array, theta: Array, speed: Array) -> dict[str, float]:
    """Describe in numbers the run (n_t,) from rest at 3 Hz, 60 N that becomes a rotation.

    ``value``, the time at which the free mass last turns backwards; ``slip``, until which the phase
    is more than half a turn from its final value; ``settled``, from which it stays within 0.5 rad
    of that [s]. Of the last eight periods the ``turns`` in each, negative against the first sense;
    of the last one the ``least`` speed in the sense of rotation, over omega.
    """
    omega = 2 * np.pi * EXAMPLE.force_frequency
    turns = (theta[-1] - theta[-1 - 8 * SAMPLES]) / (2 * np.pi * 8)
    direction = 1 if turns > 0 else -1
    stroboscopic = times[::SAMPLES]
    phase = (direction * theta - omega * times)[::SAMPLES]
    off = np.abs(phase - phase[-9:].mean())
    last = slice(-1 - SAMPLES, None)
    return {
        "value": float(np.max(times[direction * speed < 0], initial=0.0)),
        "slip": float(np.max(stroboscopic[off > np.pi], initial=0.0)),
        "settled": float(np.max(stroboscopic[off > 0.5], initial=0.0)),
        "turns": float(turns),
        "least": value_range(times[last], direction * speed[last])[0] / omega,
    }


# Maps

PLATES = (False, True)
"""Without and with the plate's inertia: figures 4, 5 and figures 6, 7."""

AxisSpan = tuple[str, float, float, int]


def axes(session: Session, engine: str = REFERENCE) -> tuple[AxisSpan, AxisSpan]:
    """Return the axes of figs. 4-7."""
    count = POINTS if engine == REFERENCE else session.engine_points or ENGINE_POINTS
    count = session.points or (FULL_POINTS if session.full else count)
    return ("force_frequency", *HERTZ, count), ("force_amplitude", *NEWTON, count)


def changed(plate: bool) -> dict[str, float]:
    """Return the parameters of the free mass: a point, or the semicircular plate."""
    return {"inertia_ratio": SEMICIRCLE} if plate else {}


def stability_map(
    session: Session,
    plate: bool,
    engine: str = REFERENCE,
    model: str | None = None,
    quantity: str = "floquet",
) -> Map:
    """Return the stability of the rotation of figs. 4 (point mass) and 6 (plate)."""
    return session.map(
        SCENE,
        quantity,
        *axes(session, engine),
        engine=engine,
        model=model,
        parameters=changed(plate),
        refine=engine != REFERENCE and not session.full,
    )


def motion_map(session: Session, plate: bool, engine: str = REFERENCE) -> Map:
    """Return the motion from rest of figs. 5 (point mass) and 7 (plate)."""
    return stability_map(session, plate, engine, quantity="class")


def parameters_on(plate: bool, x: Array, y: Array) -> HulaHoop:
    """Return the parameters (n_y, n_x) at frequencies [Hz] and forces [N]."""
    return HulaHoop(
        force_frequency=x[None, :],  # type: ignore[arg-type]
        force_amplitude=y[:, None],  # type: ignore[arg-type]
        **changed(plate),
    )


def grid(session: Session, plate: bool) -> HulaHoop:
    """Return the parameters of all points (n_y, n_x) of figs. 4-7."""
    return parameters_on(plate, *(np.linspace(*axis[1:]) for axis in axes(session)))


def multiplier(name: str, p: HulaHoop) -> Array:
    """Return the largest modulus (...) of the multipliers of a solution in `FORMULAS`."""
    solution, as_printed = FORMULAS[name]
    return np.abs(floquet.floquet_multipliers(solution(p), p, as_printed=as_printed)[0])


def is_class(plane: Map, variable: str, name: str) -> Any:
    """Return where (n_y, n_x) a variable of a map is this class."""
    return plane.variables[variable] == plane.about[variable].classes.index(name)


def moves(session: Session, plate: bool, name: str, engine: str = REFERENCE) -> Any:
    """Return where (n_y, n_x) the motion from rest is of this class."""
    return is_class(motion_map(session, plate, engine), "motion", name)


@once
def printed_multipliers(session: Session, plate: bool) -> Array:
    """Return the largest moduli (n_y, n_x) of multipliers by (55) as printed."""
    return multiplier("printed", grid(session, plate))


def stable(session: Session, plate: bool, which: str) -> Any:
    """Return where (n_y, n_x) a rotation is stable: "printed", or a model of the map."""
    if which == "printed":
        return printed_multipliers(session, plate) < 1
    return is_class(stability_map(session, plate, model=which), "stability", "stable")


def on_grid(session: Session, plane: Map, where: Any) -> Any:
    """Return values at the reference's points (n_y, n_x), taken at those of another map."""
    x, y = (Axis(*axis) for axis in axes(session))
    return where[np.ix_(y.nearest(plane.y.values), x.nearest(plane.x.values))]


STABILITIES = {
    "printed": "paper's solution, (55) as printed",
    "paper": "paper's solution, (55) corrected",
    "corrected": "with its phase, (55) corrected",
    "exact": "true rotation",
}


def regions(unstable: Any, least: int = 2) -> list[Any]:
    """Return the connected regions (n_y, n_x) of at least so many points, largest first."""
    labels, count = connected(unstable, np.ones((3, 3)))
    parts = sorted((labels == i for i in range(1, count + 1)), key=np.sum, reverse=True)
    return [part for part in parts if part.sum() >= least]


def number_of(where: Any) -> Any:
    """Return the number of points (..., n_y, n_x) at which something holds."""
    return np.sum(where, axis=(-2, -1))


def share_of(where: Any, among: Any = True) -> Any:
    """Return the share of points (..., n_y, n_x) at which something holds; NaN without points."""
    among = np.broadcast_to(among, np.shape(where))
    with np.errstate(invalid="ignore"):
        return number_of(where & among) / number_of(among)


def rank(one: Any, other: Any, where: Any) -> float:
    """Return the rank correlation of two variables over some points."""
    return float(spearmanr(one[where], other[where]).statistic)


@dataclass(frozen=True)
class Names:
    """Arrays over the points of figures 4 to 7 by name, for formulas.

    ``red_x_5`` is where the motion of figure 5 has this class; ``robust_5``, ``computed_5``,
    ``periods_5`` are variables of its map. ``stable_paper_4`` is where this solution is stable,
    ``paper_u_1_4`` a variable of its map; ``exact`` is the rotation of the reference or an engine.
    Names without a figure's number are of the point mass and the plate, (2, n_y, n_x).
    """

    session: Session
    who: str

    def __getitem__(self, name: str) -> Any:
        """Return the array of this name, (n_y, n_x) or (2, n_y, n_x)."""
        stem, _, figure = name.rpartition("_")
        if figure in ("4", "5", "6", "7"):
            return self.of(stem, figure in ("6", "7"))
        return np.array([self.of(name, plate) for plate in PLATES])

    def of(self, name: str, plate: bool) -> Any:
        """Return the array (n_y, n_x) of a name without a number."""
        session, who, (first, _, rest) = self.session, self.who, name.partition("_")
        if name == "frequency":
            return np.linspace(*axes(session, who)[0][1:])[None]
        if first == "stable" and rest != "exact":
            return on_grid(
                session, stability_map(session, plate, who), stable(session, plate, rest)
            )
        if first == "paper":
            return stability_map(session, plate, model=first).variables[rest]
        if rest == "exact":
            return is_class(stability_map(session, plate, who), "stability", first)
        by_exact = first == "exact"
        plane = (stability_map if by_exact else motion_map)(session, plate, who)
        name = rest if by_exact else name
        for variable in ("motion", "label"):
            if variable in plane.about and name in plane.about[variable].classes:
                return is_class(plane, variable, name)
        return getattr(plane, name) if name in ("robust", "computed") else plane.variables[name]


# Sections 1 to 4 ----------------------------------------------------------------------------------


PHASES = 2 * np.pi * np.arange(256) / 256
TRIAL = theory.ApproximateSolution(
    alpha=0.8, q_1=1.3, beta=0.5, u_1=0.3, gamma=0.7, theta_0=0.0, residual=np.nan
)

NUMBERS = {name: float(value) for name, value in theory.nondimensional(EXAMPLE)._asdict().items()}
ALONG = NUMBERS | {name: vars(TRIAL)[name] for name in ("alpha", "q_1", "beta", "u_1", "gamma")}
ALONG |= {"s": PHASES}
"""Coefficients of (7), (8), and with them the values of the trial motion over a turn."""

LONG_TIME = NUMBERS | {"t": np.linspace(0, 40, 400)}

BODIES = {"I_m": np.repeat([0.0, SEMICIRCLE], 8)}


def dimensional(values: Values) -> Values:
    """Return parameters, a state and accelerations of the scene [SI] at a point.

    It has ``I_m`` and ``t`` [s]; y, theta and their rates are of random size.
    """
    p = EXAMPLE.replace(inertia_ratio=values["I_m"])
    c, t = coefficients(p), values["t"]
    q, v = (0.01 * values["y"], values["theta"]), (values["y_v"], 20 * values["theta_v"])
    a = get_scene(SCENE).accelerations(drive(t, c), q, v, c)
    return {
        "M": p.main_mass, "m": p.free_mass, "R": p.rod_length,
        "k": p.stiffness, "rho": p.damping_ratio, "zeta_m": p.hinge_damping_ratio,
        "omega_n": float(p.omega_n), "F": p.force_amplitude, "f": p.force_frequency,
        "y": q[0], "theta": q[1], "y_v": v[0], "theta_v": v[1],
        "y_a": float(a[0]), "theta_a": float(a[1]), "energy": float(energy(q, v, c)),
    }  # fmt: skip


# Sections 1, 2


def plate_inertia(session: Session, expected: float = SEMICIRCLE) -> Numbers:
    """Return I_eq of the semicircular plate by quadrature over the half disc, and its error."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    radius, angle = (1 + nodes[:, None]) / 2, np.pi * (1 + nodes[None]) / 2
    share = weights[:, None] * weights[None] * radius  # of the area, in the polar plane
    centre = np.sum(share * radius * np.sin(angle)) / np.sum(share)
    ratio = np.sum(share * radius**2) / np.sum(share) / centre**2 - 1
    return {"ratio": ratio, "error": abs(ratio - expected)}


def equations_of_motion(session: Session, who: str) -> Numbers:
    """Return errors at random states: of (7), (8), or of the accelerations of an engine."""
    if who == REFERENCE:
        row = next(row for row in read_paper(SCENE).rows if row.name == "lagrange")
        assert row.equations is not None
        return {"error": row.equations()["(7), (8)"], "count": len(BODIES["I_m"])}
    setup, scene = MethodQuery(SCENE, engine=who).model_setup(), get_scene(SCENE)
    times, points = random_states(scene_equations(setup.case), setup.case, scene.coordinates)
    derivative = scene.right_hand_side(setup.case.parameters)
    truth = np.array([derivative(t, x)[2:] for t, x in zip(times, points, strict=True)])
    with contained():
        own = setup.bound.accelerations(times, points)
    return {"error": float(np.abs(own - truth).max() / np.abs(truth).max())}


# Section 3


def bessel(session: Session) -> Numbers:
    """Return relative errors of (27) for J_0 ... J_5 at |u_1| = 0.5, and J_2, J_3 over J_0."""
    u = 0.5
    simple = [u**n / (2**n * factorial(n)) for n in range(6)]
    errors = {f"J_{n}": abs(own / jv(n, u) - 1) for n, own in enumerate(simple)}
    errors |= {f"J_{n} against J_0": jv(n, u) / jv(0, u) for n in (2, 3)}
    return {"errors": errors, "largest": max(errors.values())}


def change_of_u_1(session: Session) -> Numbers:
    """Return the change of u_1 by the term that (35) has lost, at 3 Hz and 60 N and in figure 4.

    (35), (36), (46) and (47) are two complex equations for q_1 exp(i beta) and u_1 exp(i gamma),
    of which the first is eliminated. Without the term the second occurs with its real part alone.
    """
    changes = []
    for p in (EXAMPLE, grid(session, False)):
        c = theory.nondimensional(p)
        spring = 1 - c.alpha**2 - 2j * c.rho * c.alpha
        hinge = 4 * c.alpha**2 * c.inertia + 2j * c.zeta_m * c.alpha
        a, inertial = -spring * hinge / (c.alpha**2 / 2), c.epsilon * c.alpha**2
        whole = abs((c.force + 1j * inertial) / (a - inertial / 2))
        real = a.real - inertial / 2
        cosine, sine = c.force * a.real + inertial * a.imag, inertial * real - c.force * a.imag
        without = np.hypot(cosine, sine) / abs(real * a.real + a.imag**2)
        changes.append(float(np.max(np.abs(whole / without - 1))))
    return {"changes": changes}


# Section 4


# Section 5.1, transients, and the end of region II ------------------------------------------------


OMEGA = 2 * np.pi * float(EXAMPLE.force_frequency)


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
    """Return `lock_in` of the motion from rest, its turns less 1.

    And the frequency of the largest peak of theta' over the last 12 periods, by omega.
    """
    run, periods = example_from_rest(session, who), 12
    theta_dot = run.observables["theta_dot"]
    end = lock_in(run.times, run.observables["theta"], theta_dot)
    ratio = float(strongest(theta_dot[None, -periods * SAMPLES :], periods)[0])
    return {**end, "turns": abs(abs(end["turns"]) - 1), "ratio": ratio, "off": abs(ratio - 2)}


def errors_of_solutions(session: Session) -> Numbers:
    """Return errors of the approximate solutions: y [mm], over its size, theta [rad].

    And the share of the printed solution's error of theta that Newton's method leaves.
    """
    size = example_orbit(session).harmonics["y"].terms[0].amplitude
    errors, numbers = approximation_errors(session), dict[str, float]()
    for name, (y, theta, *_) in errors.items():
        numbers |= {name: 1e3 * y, f"{name}_share": y / size, f"{name}_theta": theta}
    left = [errors[name][1] / errors["paper"][1] for name in ("refined", "corrected")]
    return {"left": left[0], "left_with_phase": left[1], **numbers}


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


# The end of region II

LINES = (4.5, 5.0, 5.5, 6.0)
"""Frequencies [Hz] at which region II lies below region I."""

FORCES = np.linspace(5.0, 300.0, 119)
"""Forces among which the last stable one is sought [N]: our axis and as far again."""

NEAR = {False: (32.0, 28.0, 23.0, 18.0), True: (110.0, 95.0, 78.0, 61.0)}
"""Forces [N] near the end without and with inertia, from which it is sought."""

STEPS = 80
"""Steps of engines in a period."""


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

    def outside(force: Array | float) -> Array:
        return multiplier(name, p.replace(force_amplitude=force)) - 1

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
        setup = MethodQuery(SCENE, engine=who, parameters=one.parameters.as_dict()).setup()
        z = one.solution[1].z
        off.append(one.unit * abs(engine_point(setup, one, STEPS, z).z[-1] - z[-1]))
    return {"off": max(off)}


# Readings


def from_rest(p: HulaHoop, angles: Array | float = 0.0) -> list[str]:
    """Return the lock-in of motions at 3 Hz from rest at some angles [rad], in words."""
    count = np.broadcast(p.damping_ratio, p.hinge_damping_ratio, angles).size
    times = samples(LONG_RUN)
    states = np.zeros((4, len(times), count))
    states[1, 0] = angles
    derivative = get_scene(SCENE).right_hand_side(p)
    for i in range(len(times) - 1):
        states[:, i + 1] = rk8_steps(derivative, states[:, i], times[i], times[i + 1], 1)
    return [in_words(lock_in(times, states[1, :, i], states[3, :, i])) for i in range(count)]


def in_words(end: dict[str, float]) -> str:
    """Return a lock-in in words."""
    turns = abs(end["turns"])
    if turns < LOCKED:
        return "no lock-in, no turns in the end"
    if abs(turns - 1) > LOCKED:  # chaos: how many turns depends on the last digit
        return "no lock-in, irregular turns"
    sense = "forwards" if end["turns"] > 0 else "backwards"
    backwards = "reverses to the end" if end["least"] < 0 else "last reversal"
    return (
        f"locks in, turning {sense}; last slip {end['slip']:.2f} s, {backwards} "
        f"{end['value']:.2f} s"
    )


# Sections 5.2 and 6: figures 4 to 7 ---------------------------------------------------------------


CORRECTED = ("paper", "corrected")
"""Approximate solutions by (55) corrected: without and with theta_0."""


# Figures 4 and 6: stability


PARTS = ((0.0, 1.0), (0.1, 0.8), (0.0, 0.6), (0.2, 1.0))
"""Parts of each axis of figures 4 and 6 that regions are counted on."""


def part(where: Any, x: tuple[float, float], y: tuple[float, float]) -> Any:
    """Return the part (..., n, m) of points (..., n_y, n_x) between shares of both axes."""
    rows, columns = (
        slice(*(round(share * size) for share in ends))
        for ends, size in zip((y, x), where.shape[-2:], strict=True)
    )
    return where[..., rows, columns]


def on_parts(where: Any, among: Any = True) -> Any:
    """Return the shares (..., 16) at which something holds on parts of our axes, 0 of no points."""
    among = np.broadcast_to(among, where.shape)
    parts = [share_of(part(where, *ends), part(among, *ends)) for ends in product(PARTS, PARTS)]
    return np.nan_to_num(np.stack(parts, axis=-1))


def unstable_regions(session: Session, plate: bool, count: int) -> Numbers:
    """Count unstable regions by each solution on our axes and grid.

    And with other choices: on parts of our axes, at every other point, and of other least sizes;
    their range, and the share of them that has so many regions.
    """
    unstable = {name: ~stable(session, plate, name) for name in STABILITIES}
    choices = np.array(
        [
            len(regions(part(where, x, y)[::every, ::every], least))
            for where, x, y, every, least in product(
                unstable.values(), PARTS, PARTS, (1, 2), (1, 2, 3)
            )
        ]
    )
    return {
        "counts": {STABILITIES[name]: len(regions(where)) for name, where in unstable.items()},
        "least": choices.min(),
        "largest": choices.max(),
        "fitting": np.mean(choices == count),
    }


# Figures 5 and 7: motion from rest


def near(where: Any, cells: int = 2) -> Any:
    """Return the points (n_y, n_x) within some cells of others."""
    return binary_dilation(where, np.ones((3, 3)), iterations=cells)


def by_class(session: Session, plate: bool, among: Any = True) -> dict[str, int]:
    """Return the number of points of each class in figure 5, or 7 (plate), of all or some."""
    motion = motion_map(session, plate)
    return {
        name.replace("_", " "): number_of(is_class(motion, "motion", name) & among)
        for name in motion.about["motion"].classes
    }


def cyan_in_region_1(session: Session) -> dict[str, list[int]]:
    """Return the number of cyan o in region I of figures 5 and 7, by three solutions."""
    cyan = [moves(session, plate, "cyan_o") for plate in PLATES]
    return {
        STABILITIES[name]: [
            number_of(here & regions(~stable(session, plate, name))[0])
            for here, plate in zip(cyan, PLATES, strict=True)
        ]
        for name in (*CORRECTED, "exact")
    }


# Figures 4 and 5, 6 and 7


def agreements(session: Session, who: str, plate: bool) -> Numbers:
    """Return the share of the robust points at which stability predicts the motion from rest.

    By each solution; of an engine, by the stability of its rotation. ``trivial`` is the share that
    the better of "everywhere" and "nowhere" reaches, and ``parts`` the largest of the corrected
    solutions on parts of our axes.
    """
    of = partial(Names(session, who).of, plate=plate)
    there, hoop = of("exact_computed") & of("computed") & of("robust"), of("blue_o")
    if who != REFERENCE:
        return {"share": share_of(of("stable_exact") == hoop, there), "count": number_of(there)}
    right = {name: of(f"stable_{name}") == hoop for name in STABILITIES}
    shares = {name: share_of(where, there) for name, where in right.items()}
    return {
        **shares,
        "share": shares["paper"],
        "trivial": max(share_of(hoop, there), share_of(~hoop, there)),
        "points": number_of(there),
        "best": max(shares[name] for name in CORRECTED),
        "parts": max(np.max(on_parts(right[name], there)) for name in CORRECTED),
    }


# Readings


def axes_of_maps(session: Session) -> Numbers:
    """Return stable shares and numbers of unstable regions on other axes: of figures 4 and 6."""
    axes = [(HERTZ, NEWTON), (HERTZ, (5.0, 100.0)), ((1.0, 20.0), NEWTON), ((2.0, 8.0), NEWTON)]
    shares, counts = np.zeros((2, len(axes), 2))
    for (i, (hertz, newton)), plate in product(enumerate(axes), PLATES):
        p = parameters_on(plate, np.linspace(*hertz, POINTS), np.linspace(*newton, POINTS))
        modulus = multiplier("paper", p)
        shares[i, int(plate)] = np.mean(modulus < 1)
        counts[i, int(plate)] = len(regions(modulus >= 1))
    return {"shares": shares, "counts": counts}


def drawn_solution(session: Session) -> Numbers:
    """Return regions and agreement with the motion from rest, of figures 4 and 6, by solution."""
    return {
        name: {
            "counts": [len(regions(~stable(session, plate, name))) for plate in PLATES],
            "shares": [agreements(session, REFERENCE, plate)[name] for plate in PLATES],
        }
        for name in STABILITIES
    }


def class_definitions(session: Session) -> Numbers:
    """Return the shares of the classes of figure 5 with other limits between them."""
    values = motion_map(session, False).variables
    limits = {
        "ours": (0.5 / 120, 0.02, 0.0),
        "quarter": (0.25 / 120, 0.02, 0.0),
        "slack": (0.05, 0.02, 0.0),
        "wide": (0.5 / 120, 0.1, 0.0),
        "slow": (0.5 / 120, 0.02, -0.05),
    }
    shares = {}
    for name, (slack, near_two, least) in limits.items():
        turns = np.abs(values["turns"] - 1) < slack
        two, forward = np.abs(values["f_u"] - 2) < near_two, values["min_speed"] >= least
        shares[name] = {
            "blue o": share_of(turns & two & forward),
            "blue +": share_of(turns & two & ~forward),
            "cyan o": share_of(turns & ~two & forward),
            "cyan +": share_of(turns & ~two & ~forward),
            "red x": share_of(~turns),
        }
    return shares

"""Measures of the rotor_pendulum paper, and the orbits, runs and maps that the figures share.

Its equations themselves are texts in ``claims.toml``. (14) is the tangent at working speed: from
rest it gives fifty times the working torque; the text does not give the motor's own curve. The
theory of figure 3 has a phase everywhere; with the dampers of table 1 the synchronous orbit begins
at a fold, which is followed over n_x here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.stats import spearmanr

from ....reference import get_scene
from ....reference.continuation.along import BoundaryAlong
from ....reference.errors import NoOrbitError
from ....reference.rotor_pendulum import CASE_1, CASE_2, CASE_3, theory
from ....reference.rotor_pendulum import phase as vibration
from ....reference.rotor_pendulum.equations import RotorPendulum, coefficients, operating_speed
from ....reference.rotor_pendulum.phase import wrapped
from ....reference.scene import Array
from ....reference.solve.single import states_at
from ...engines.registry import REFERENCE
from ...maps.store import Map
from ...queries.orbit import OrbitReport, find
from ...queries.request import Query
from ...queries.simulate import simulate
from ...scenes.rotor_pendulum.phase import PHASES
from ..equations import Values
from ..ledger import Numbers, half_unit
from ..session import Session, once

SCENE = "rotor_pendulum"
REDUCED = "reduced"

CASES: Mapping[int, RotorPendulum] = {1: CASE_1, 2: CASE_2, 3: CASE_3}
PRINTED_RATIOS: Mapping[int, theory.Ratios] = {
    1: theory.Ratios(0.4943, 0.4943),
    2: theory.Ratios(5.916, 5.029),
    3: theory.Ratios(5.916, 5.029, beta=np.pi / 2),
}
"""Frequency ratios and installation angle printed for each case."""

BETAS = {"0": 0.0, "pi/6": np.pi / 6, "pi/3": np.pi / 3, "5 pi/12": 5 * np.pi / 12}
"""Installation angles [rad] of figure 3, by name."""
RANGE = (0.1, 7.0)
"""Range of both frequency ratios in figs. 2, 3, and table 2."""

GRID, FULL_GRID = 29, 64
ENGINE_GRID, ENGINE_FULL_GRID = 8, 22
"""Points along an axis: of the smaller grids, the engines' are a part of the reference's."""

HORIZONS: Mapping[int, float] = {1: 16.0, 2: 4.0, 3: 10.0}
"""Time [s] of the simulations, which the text does not give: in case 1 the rotors start
near the unstable phase and leave it at 0.5 1/s; in case 3 they slip by 1 rad/s."""

PER_SECOND = 1024
"""Samples of a run per second: 42 in a turn."""

STEP = 2.0**-12
"""Step of the engines [s], each with its method of highest order: 170 in a turn."""

RUN_TOLERANCES = {REFERENCE: (1e-10, 1e-8), REDUCED: (1e-7, 1e-6)}
"""Tolerances of a run and of its check: the runs are long, and (11) errs by more than that."""


@once
def synchronous_orbit(
    session: Session, p: RotorPendulum, engine: str = REFERENCE, model: str | None = None
) -> OrbitReport | None:
    """Return the synchronous orbit, or None if there is none."""
    query = Query(SCENE, engine=engine, model=model, parameters=p.as_dict())
    try:
        return find(query, bounded=False)
    except NoOrbitError:
        return None


def orbit_value(report: OrbitReport | None, quantity: str) -> float:
    """Return a quantity of an orbit, NaN without one."""
    return np.nan if report is None else report.quantities[quantity].value


def kind_of(report: OrbitReport | None) -> str:
    """Return the kind of synchronism, one of `mbcheck.comparisons.scenes.rotor_pendulum.PHASES`."""
    if report is None or not report.stable:
        return "none" if report is None else "unstable"
    return "synphase" if np.cos(orbit_value(report, "phase_difference")) > 0 else "antiphase"


def orbit_in_words(session: Session, p: RotorPendulum, model: str | None = None) -> str:
    """Return kind, phase, speed and torque of the synchronous orbit."""
    report = synchronous_orbit(session, p, model=model)
    phase, speed, torque = (
        orbit_value(report, name) for name in ("phase_difference", "mean_speed", "motor_torque_1")
    )
    words = f"{kind_of(report)}, {phase:.4f} rad at {speed:.2f} rad/s, {torque:.3g} N m"
    return "not there" if report is None else words


@dataclass(frozen=True)
class StartUp:
    """A run from rest.

    Attributes
    ----------
    parameters : RotorPendulum
    times : array (n,) [s]
    states : array (8, n)
    largest : float, optional
        Largest torque of the motors [N m], see `motor_torque`; by default they follow (14).
    """

    parameters: RotorPendulum
    times: Array
    states: Array
    largest: float | None = None

    @property
    def phase(self) -> Array:
        """phi_1 - phi_2 [rad], which starts at 0 and is not wrapped."""
        return self.states[1] - self.states[2]

    @property
    def torques(self) -> Array:
        """Torques of the two motors (2, n) [N m]."""
        return motor_torque(self.parameters, self.largest, self.states[5:7])

    @property
    def half_ranges(self) -> Array:
        """Half the range of each state in the last second (8,)."""
        return np.asarray(np.ptp(self.states[:, -PER_SECOND:], axis=1) / 2)

    def by_turns(self, values: Any, turns: int = 1) -> Array:
        """Return values (k, n) over each turn, or each few; an incomplete last one is dropped."""
        size = turns * round(PER_SECOND * 2 * np.pi / float(operating_speed(self.parameters)))
        whole: Array = values[: len(values) // size * size]
        return whole.reshape(-1, size)

    def turn_means(self, values: Any) -> Array:
        """Return means over turns, about 42 samples each."""
        return self.by_turns(values).mean(axis=1)

    @property
    def ends(self) -> list[float]:
        """Phase [rad], speed [rad/s] and torque [N m] of rotor 1 in the last second."""
        values = (self.phase, self.states[5], self.torques[0])
        return [float(self.turn_means(one)[-24:].mean()) for one in values]


@once
def from_rest(session: Session, case: int, who: str = REFERENCE) -> StartUp:
    """Return the start-up of a case: by the reference, its `REDUCED` equations, or an engine."""
    p, scene = CASES[case], get_scene(SCENE)
    times = np.arange(round((session.seconds or HORIZONS[case]) * PER_SECOND) + 1) / PER_SECOND
    if who in (REFERENCE, REDUCED):
        equations = scene.variants.get(who, scene)
        return StartUp(p, times, states_at(equations, p, np.zeros(8), times, RUN_TOLERANCES[who]))
    run = simulate(SCENE, engine=who, step=STEP, parameters=p.as_dict(), times=times)
    return StartUp(p, times, np.array([run.observables[name] for name in scene.state_names]))


LARGEST = 8.0
"""Largest torque of the motors' curve [N m]: about 2.6 times the working torque, as is usual."""
CURVE_SECONDS = 3.0
"""Duration of a start by that curve [s]: the slowest rotor is at working speed after 0.51 s."""


def motor_torque(p: RotorPendulum, largest: float | None, rates: Array) -> Array:
    """Return the torque of a motor [N m] at speeds [rad/s]: by (14), or by Kloss's formula.

    ``2 M s s_k / (s^2 + s_k^2)`` over the slip s, with the largest torque M at the slip ``s_k``
    that gives the curve the slope of (14) at no torque.
    """
    speed, slope = float(p.synchronous_speed), float(p.motor_slope)
    slip = 1 - rates / speed
    if largest is None:
        return slope * speed * slip
    at = 2 * largest / (slope * speed)
    return 2 * largest * slip * at / (slip**2 + at**2)


@once
def other_start(
    session: Session,
    case: int,
    seconds: float,
    largest: float | None = None,
    inertia: float = 0.0,
    as_printed: bool = False,
) -> StartUp:
    """Return a start from rest with another motor, another rod, or another sign.

    With the exact equations where the motor alone is another one, and else with (11), which the
    paper integrates.

    Parameters
    ----------
    seconds : float
        Duration [s].
    largest : float, optional
        Largest torque of the motors [N m]; by default (14) holds from rest on.
    inertia : float
        J_3 of (7) [kg m^2], which (11) leaves out.
    as_printed : bool
        Take the sign before phi_2'^2 in the fourth line of (11) as printed.
    """
    p, scene = CASES[case], get_scene(SCENE)
    equations, c = scene if largest else scene.variants[REDUCED], coefficients(p)

    def derivative(time: float, state: Array) -> Array:
        q, v = state[:4], state[4:]
        matrix = np.array(equations.mass_matrix(q, c), dtype=float)
        force = np.array(equations.forces(0.0, q, v, c), dtype=float)
        matrix[3, 3] += inertia
        force[1:3] += motor_torque(p, largest, v[1:3]) - motor_torque(p, None, v[1:3])
        if as_printed:
            force[3] -= 2 * c.unbalance * c.length * v[2] ** 2 * np.sin(q[2] - c.beta)
        return np.concatenate([v, np.linalg.solve(matrix, force)])

    times = np.arange(round(seconds * PER_SECOND) + 1) / PER_SECOND
    span, zero = times[[0, -1]], np.zeros(8)
    run = solve_ivp(derivative, span, zero, "DOP853", times, rtol=1e-7, atol=1e-9)
    return StartUp(p, times, run.y, largest)


def phase_map(session: Session, beta: float, who: str = REFERENCE) -> Map:
    """Return the phase of the synchronous orbits over n_x and n_phi."""
    fewer = session.engine_points or ENGINE_GRID
    counts = (GRID, FULL_GRID) if who == REFERENCE else (fewer, ENGINE_FULL_GRID)
    axis = (*RANGE, session.points or counts[session.full])
    parameters = {"installation_angle": beta}
    x, y = ("n_x", *axis), ("n_phi", *axis)
    model = "exact" if who == REFERENCE else None
    return session.map(SCENE, "phase", x, y, engine=who, model=model, parameters=parameters)


def theory_on(plane: Map, beta: float) -> Array:
    """Return the stable phase of (30), (36) at the points of a map (n_y, n_x) [rad]."""
    n = theory.Ratios(*np.meshgrid(plane.x.values, plane.y.values), beta=beta)
    return np.asarray(theory.stable_phase_difference(n))


def stable_phases(plane: Map) -> Array:
    """Return the phases (n_y, n_x) of a map [rad], NaN where there is no stable orbit."""
    unstable = plane.variables["class"] == PHASES.index("unstable")
    return np.where(unstable, np.nan, plane.variables["phase_difference"])


NEAR = 1e-9
"""Distance of a value from the end of a range that round-off may reach."""


def inside(plane: Map, x: tuple[float, float], y: tuple[float, float]) -> Any:
    """Return which points of a map lie between two n_x and two n_phi, ends included."""
    n_x, n_phi = np.meshgrid(plane.x.values, plane.y.values)
    in_x = (n_x > x[0] - NEAR) & (n_x < x[1] + NEAR)
    return in_x & (n_phi > y[0] - NEAR) & (n_phi < y[1] + NEAR)


def class_shares(plane: Map, where: Any = ...) -> dict[str, float]:
    """Return the share of each class that occurs among some points of a map."""
    classes, names = plane.variables["class"][where], plane.about["class"].classes
    shares = {name: float(np.mean(classes == i)) for i, name in enumerate(names)}
    return {name: share for name, share in shares.items() if share > 0}


# Sections 2 to 4, and tables ----------------------------------------------------------------------


def at_ratios(n_x: float, n_phi: float, beta: float) -> RotorPendulum:
    """Return the parameters of a point of figure 3, with the dampers of table 1."""
    c, speed = coefficients(CASE_1), float(operating_speed(CASE_1))
    return CASE_1.replace(
        installation_angle=beta,
        platform_stiffness=float(c.mass) * (speed / n_x) ** 2,
        rod_stiffness=float(c.end_mass * c.length**2) * (speed / n_phi) ** 2,
    )


LATTICE = np.linspace(*RANGE, 139) + 1e-3
"""Values of a frequency ratio, 0.05 apart; none is 1."""

CASE_2_RATIOS: Values = PRINTED_RATIOS[2]._asdict()
TURN = 2 * np.pi * np.arange(64) / 64
CASE_2_VALUES: Values = {**CASE_2_RATIOS, "t": TURN, "alpha_1": 0.9, "alpha_2": 0.2}
"""Parameters of case 2, and a turn of it, at which equations of the vibration are compared."""


def lattice(beta: float = np.pi / 6) -> theory.Ratios:
    """Return both frequency ratios over the range of the figures, (139, 139)."""
    return theory.Ratios(LATTICE[None], LATTICE[:, None], beta=beta)


# Section 2: model and equations

SYMBOLS = {
    "platform_mass": "m_0", "rotor_mass": "m", "rod_mass": "m_3", "eccentricity": "r",
    "rod_length": "l", "platform_stiffness": "k_x", "platform_damping": "f_x",
    "rod_stiffness": "k_phi", "rod_damping": "f_phi", "installation_angle": "beta",
}  # fmt: skip
"""Parameters of the scene and their symbols in the paper."""


def scene_at(values: Values) -> Values:
    """Return the scene's energy and accelerations at a state, in the symbols of (7) to (11).

    Without motors and bearings where the equations have none.
    """
    q, v = (np.array([values[f"{x}_{i}"] for i in range(4)], dtype=float) for x in ("q", "v"))
    p = RotorPendulum(
        **{name: values[symbol] for name, symbol in SYMBOLS.items()},
        motor_slope=values.get("k_e", 0.0),
        synchronous_speed=values.get("w_s", 1.0),
        friction=values.get("f", 0.0),
    )
    scene, c = get_scene(SCENE), coefficients(p)
    a = scene.accelerations(0.0, q, v, c)
    return {"energy": scene.energy(q, v, c)} | {f"a_{i}": float(one) for i, one in enumerate(a)}


MUTUAL, STATOR, RESISTANCE, VOLTAGE, POLES = 0.13, 0.1, 0.54, 220.0, 2
"""Table 1's induction motor [H, H, ohm, V, 1]."""


def motor_slope(electric_powers: int) -> float:
    """Return the slope of (14) over the mechanical speed [N m s/rad, if it is one].

    (14) divides by the electric speed once; a torque needs it twice. With the electric
    synchronous speed omega_s = n_p times the mechanical one, the slip is omega_s - n_p omega_m.
    """
    electric = POLES * float(CASE_1.synchronous_speed)
    scale = POLES * MUTUAL**2 * VOLTAGE**2 / (STATOR**2 * RESISTANCE)
    return float(POLES * scale / electric**electric_powers)


# Section 3: coupling coefficients, figure 2


def strength(session: Session) -> Numbers:
    """Return rank correlations of mu_3, and mu_1 where beta = 0 without mu_3.

    With the torque that couples the rotors, and with the rod's swing by rotor 1.
    """
    n = lattice()
    mu, level = theory.coupling_coefficients(n), theory.coupling_coefficients(lattice(0.0))
    sin, springs = np.sin(n.beta), (1 / n.n_x**2 - 1) * (1 / n.n_phi**2 - 1)
    swing = abs(n.r_m * sin / (springs - n.r_m * sin**2 / n.sigma))  # of (16), by Cramer's rule
    ranks = [
        float(spearmanr(abs(mu.mu_3).ravel(), other.ravel()).statistic)
        for other in (swing, torque_size(mu, n.beta))
    ]
    alone = 0.0 if np.any(level.mu_3) else np.max(abs(level.mu_1))
    return {"swing": ranks[0], "rank": ranks[1], "mu_1_alone": alone}


def torque_size(mu: theory.Coupling, beta: float) -> Array:
    """Return the amplitude of the coupling torque over the phase difference, without its scale."""
    return np.hypot(mu.mu_1 - mu.mu_3 * np.sin(beta), mu.mu_3 * np.cos(beta))


REGIONS = {"before": (0.1, 0.9), "at": (0.9, 1.1), "after": (1.1, 7.0)}
"""Ranges of a frequency ratio, as section 3 divides it."""


# Section 4: synchronisation and stability


# Tables 1, 2, and the frequency ratios of section 5.2


PRINTED_SPEED = 157.0
"""50 pi, rounded, from which table 1's ranges follow [rad/s]."""
SPEEDS = (151.5, 157.5)
"""Speeds that round to table 1's range of the rotors' speed [rad/s]."""


RATIOS = {"platform": "n_x", "rod": "n_phi"}
"""Frequency ratio of each spring."""


def spring_inertias(spring: str) -> tuple[float, float]:
    """Return the inertia on a spring, and the paper's value of it.

    Masses on the platform's spring [kg], or moments of inertia on the rod's [kg m^2].
    """
    c = coefficients(CASE_1)
    right, wrong = c.mass, c.platform
    if spring == "rod":
        right, wrong = c.end_mass * c.length**2, (c.platform + c.rod) * c.length**2
    return float(right), float(wrong)


def stiffness(session: Session, ratio: float, spring: str) -> Numbers:
    """Return the stiffness that belongs to a frequency ratio, and that by the paper's inertia."""
    square, (right, wrong) = (PRINTED_SPEED / ratio) ** 2, spring_inertias(spring)
    own = {"value": right * square, "mistaken": wrong * square}
    return {**own, "right": right, "wrong": wrong, "ratio": ratio}


def frequency_ratio(session: Session, case: int, spring: str) -> Numbers:
    """Return the frequency ratio of a printed stiffness, and speeds that make the printed one.

    It is taken at that speed of table 1's range that brings it nearest to the printed one.
    """
    printed = getattr(PRINTED_RATIOS[case], RATIOS[spring])
    per_speed = float(getattr(theory.ratios(CASES[case], speed=1.0), RATIOS[spring]))
    right, wrong = spring_inertias(spring)
    takes = printed / per_speed
    speed = float(np.clip(takes, *SPEEDS))
    return {
        "value": speed * per_speed,
        "speed": speed,
        "takes": (takes, takes * float(np.sqrt(right / wrong))),
        "inertias": (right, wrong),
    }


# Section 5.2: the three cases ---------------------------------------------------------------------


AT_SPEED = 0.9
"""Share of the working speed from which on a rotor no longer speeds up."""

CALIBRATED = CASE_1.replace(motor_slope=0.9391, friction=0.0199)
"""Case 1 with the motor and the friction that its printed speed and torque make, to all digits;
the scene's defaults are these, rounded."""

ORBITS = {**CASES, 1: CALIBRATED}
"""Parameters of the synchronous orbits that are compared with section 5.2's numbers."""

# Starts


def time_to_speed(run: StartUp) -> float:
    """Return the time [s] at which the slower rotor first reaches its speed."""
    fast = run.states[5:7] > AT_SPEED * float(operating_speed(run.parameters))
    return float(run.times[np.argmax(fast, axis=1).max()])


def speeding_up(run: StartUp) -> Array:
    """Return the states of a run until both rotors are at speed (8, k)."""
    return run.states[:, run.times <= time_to_speed(run)]


def gap(run: StartUp) -> float:
    """Return the largest difference of the speeds until both rotors are at it, over it."""
    early = speeding_up(run)
    return float(np.abs(early[5] - early[6]).max() / operating_speed(run.parameters))


def overshoots(run: StartUp) -> Array:
    """Return the largest x and phi_3 in the first second over those in the last one (2,)."""
    size = np.abs(run.states[[0, 3]])
    return np.asarray(size[:, :PER_SECOND].max(axis=1) / size[:, -PER_SECOND:].max(axis=1))


def compare_starts(session: Session, case: int) -> Numbers:
    """Compare the starts of a case by (14) and by the motors' curve: pairs.

    The largest differences of the speeds, over them; when both rotors are at speed [s]; the rod's
    largest angle until then [rad]. By the curve alone the mean lead of rotor 1 in speed [rad/s],
    and `overshoots`.
    """
    runs = from_rest(session, case), other_start(session, case, CURVE_SECONDS, LARGEST)
    gaps, early = [gap(run) for run in runs], [speeding_up(run) for run in runs]
    curve = overshoots(runs[1])
    return {
        "gaps": gaps,
        "least": min(gaps),
        "largest": max(gaps),
        "times": [time_to_speed(run) for run in runs],
        "swings": [np.abs(states[3]).max() for states in early],
        "lead": np.mean(early[1][5] - early[1][6]),
        "curve": curve,
        "most": curve.max(),
    }


def starts(session: Session, who: str, case: int) -> Numbers:
    """Return the largest difference of the speeds in the run-up of a case, and `overshoots`."""
    run = from_rest(session, case, who)
    others = compare_starts(session, case) if who == REFERENCE else {}
    return {"value": gap(run), "ratios": overshoots(run), **others}


def starts_of_both_cases(session: Session) -> Numbers:
    """Compare the starts of cases 1 and 2 by both laws: differences of the speeds, swings [rad]."""
    first, second = (compare_starts(session, case) for case in (1, 2))
    ratios = {name: np.divide(second[name], first[name]) for name in ("gaps", "swings")}
    return {"first": first, "second": second, **ratios}


PRINTED_POINTS = (("153.8", "3.08"), ("153.5", "3.23"))
"""Speeds [rad/s] and torques [N m] that section 5.2 prints for cases 1 and 2."""


def one_motor(session: Session) -> Numbers:
    """Test if a line, or a motor's curve, passes through the points of cases 1 and 2.

    Ranges of the slope from the speed without load [N m s/rad] that rounding allows, their
    overlap, and the speed without load from which on they overlap [rad/s]; the range of the largest
    torque of such curves [N m].
    """
    speed, signs = float(CASE_1.synchronous_speed), (-1, 0, 1)
    boxes = [
        [
            (1 - (float(rate) + i * half_unit(rate)) / speed, float(torque) + j * half_unit(torque))
            for i, j in product(signs, signs)
        ]
        for rate, torque in PRINTED_POINTS
    ]
    slopes = [[torque / (slip * speed) for slip, torque in box] for box in boxes]
    largest = []
    for (slip_1, torque_1), (slip_2, torque_2) in product(*boxes):
        bend = torque_1 * slip_2 / (slip_1 * torque_2)
        square = (bend - 1) / (slip_2**2 - bend * slip_1**2)  # of 1/s_k
        if square > 0:
            largest.append(torque_1 / slip_1 * (1 + square * slip_1**2) / (2 * np.sqrt(square)))
    (steep, low), (flat, high) = boxes[0][0], boxes[1][-1]
    return {
        "first": [min(slopes[0]), max(slopes[0])],
        "second": [min(slopes[1]), max(slopes[1])],
        "onset": speed * (1 - (high * steep - low * flat) / (high - low)),
        "overlap": min(map(max, slopes)) - max(map(min, slopes)),
        "curves": [min(largest), max(largest)],
    }


# Synchronous orbits


def orbit_quantity(
    session: Session, who: str, case: int, quantity: str, sign: float = 1.0
) -> float:
    """Return a quantity of the synchronous orbit of a case."""
    return sign * orbit_value(synchronous_orbit(session, ORBITS[case], who), quantity)


def theoretical_phase(case: int) -> float:
    """Return the stable phase of (30), (36) for the stiffnesses of a case [rad]."""
    return float(theory.stable_phase_difference(theory.ratios(CASES[case])))


DAMPERS = (15.0, 3.0, 0.3, 0.0)
"""Dampers of the rod [N m s/rad] by which case 2 is computed; the first is printed."""
INERTIAS = (0.45, 0.49)
"""Moments of inertia J_3 of the rod [kg m^2], which (11) leaves out: m_3 l^2/2, and one with which
three numbers of case 2 come out."""


def other_rods(session: Session) -> Numbers:
    """Return case 2 with other `DAMPERS` of the rod, and with `INERTIAS`.

    Orbits by the damper in words. By the inertia [kg m^2] phase [rad], speed [rad/s], torque [N m]
    and amplitudes of platform and rod [m, rad] in the last second of a start, of the last inertia
    by name, too; and the range of the phase of case 3 with it in the last second of its start, and
    without it [rad].
    """
    runs = [other_start(session, 2, 4.0, inertia=own) for own in INERTIAS]
    upright = other_start(session, 3, 8.0, inertia=INERTIAS[-1]), from_rest(session, 3)
    ends = [(*run.ends, *run.half_ranges[[0, 3]]) for run in runs]
    return {
        "orbits": [orbit_in_words(session, CASE_2.replace(rod_damping=f)) for f in DAMPERS],
        "line": float(CASE_2.motor_slope * (CASE_2.synchronous_speed - 153.5)),
        "inertias": INERTIAS,
        "ends": ends,
        "moves": [np.ptp(run.turn_means(run.phase)[[-25, -1]]) for run in upright],
        **dict(zip(("phase", "speed", "torque", "platform", "rod"), ends[-1], strict=True)),
    }


def excess_powers(session: Session, who: str) -> Numbers:
    """Return the powers that (27) sets to zero: the motors' less their bearings', over the motors'.

    Of both rotors in cases 1 and 2; in case 2 in watts, with the power of the rod's damper.
    """
    shares, watts = [], []
    for case, rotor in product((1, 2), (1, 2)):
        orbit = synchronous_orbit(session, ORBITS[case], who)
        power = {} if orbit is None else orbit.power
        motor = power.get(f"motor_{rotor}", np.nan)
        watts.append(motor + power.get(f"friction_{rotor}", np.nan))
        shares.append(abs(watts[-1] / motor))
    return {"shares": shares, "watts": watts[2:], "rod": -power.get("rod", np.nan)}


def gap_to_theory(session: Session, who: str, case: int) -> Numbers:
    """Return the distance of an orbit's phase from the theory's [rad], and the theory's.

    With the rod's damper, and without it (``free``).
    """
    alpha, gaps = theoretical_phase(case), []
    undamped = CASES[case].replace(rod_damping=0.0)
    for p, engine in ((ORBITS[case], who), (undamped, REFERENCE)):
        phase = orbit_value(synchronous_orbit(session, p, engine), "phase_difference")
        gaps.append(float(abs(wrapped(phase - alpha))))
    return {"value": gaps[0], "free": gaps[1], "alpha": alpha}


def coupling_torques(session: Session) -> Numbers:
    """Return the torques by which vibration couples the rotors of each case [N m].

    Constant part and amplitude with the dampers; the amplitude by (34), without them; the largest
    torque (26) on a rotor, and its share of those of section 5.2; case 3's share of case 2's.
    """
    harmonics = [[complex(one) for one in vibration.coupling_harmonics(p)] for p in CASES.values()]
    undamped = np.array([float(theory.coupling_amplitude(p)) for p in CASES.values()])
    return {
        "mean": [mean.real for mean, _ in harmonics],
        "amplitude": [abs(first) for _, first in harmonics],
        "undamped": undamped,
        "share": undamped[2] / undamped[1],
        "on_a_rotor": undamped[:2] / 2,
        "of_torque": undamped[:2] / 2 / (3.08, 3.23),
    }


# Runs from rest


def last_phase(session: Session, who: str, case: int) -> Numbers:
    """Return the phase [rad] of the last turn from rest, and its distance from the orbit's."""
    run, orbit = from_rest(session, case, who), synchronous_orbit(session, CASES[case])
    target, end = orbit_value(orbit, "phase_difference"), float(run.turn_means(run.phase)[-1])
    return {
        "end": end,
        "target": target,
        "off": abs(wrapped(end - target)),
        "kind": "antiphase" if np.cos(end) < 0 else "synphase",
        "stable": bool(orbit and orbit.stable),
    }


def change_of_amplitudes(session: Session, who: str, case: int) -> float:
    """Return the largest relative change of the amplitudes of x and phi_3.

    They are taken over three turns each, in the last quarter of the run from rest.
    """
    run = from_rest(session, case, who)
    late = run.states[[0, 3], 3 * len(run.times) // 4 :]
    spans = np.ptp([run.by_turns(values, 3) for values in late], axis=2)
    return float(np.max(np.ptp(spans, axis=1) / np.mean(spans, axis=1)))


def fluctuations(session: Session, who: str = REFERENCE) -> Numbers:
    """Return half the range of both speeds at the end of case 2 [rad/s], and their ratio."""
    first, second = from_rest(session, 2, who).half_ranges[5:7]
    return {"first": first, "second": second, "ratio": second / first}


def slip(session: Session, who: str) -> Numbers:
    """Return the slip of the rotors in case 3.

    The gain of rotor 1 on rotor 2 from 1 s on [rad], and its duration [s]; the range of the torque
    by which motor 2 exceeds motor 1, over turns [N m]; the lead of rotor 1 in speed in the first
    12 turns [rad/s], and how often it leads.
    """
    run = from_rest(session, 3, who)
    gain = float(run.phase[-1] - run.phase[PER_SECOND])
    more = run.turn_means(run.torques[1] - run.torques[0])[8:]
    faster = run.turn_means(run.states[5] - run.states[6])[:12]
    return {
        "gain": gain,
        "size": abs(gain),
        "duration": float(run.times[-1]) - 1,
        "least": more.min(),
        "largest": more.max(),
        "mean": np.mean(faster),
        "first": faster[0],
        "ahead": np.mean(faster > 0),
    }


# Readings


def both_cases(session: Session, placement: str = "absolute", model: str | None = None) -> str:
    """Return the orbits of cases 1 and 2 in words."""
    one, two = (
        orbit_in_words(session, p.replace(motor_placement=placement), model)
        for p in (CASE_1, CASE_2)
    )
    return f"case 1: {one}; case 2: {two}"


# Section 5.1: figure 3 ----------------------------------------------------------------------------


SMALL = 0.1
"""Points nearer to resonance in n_x than this are not judged."""
FINE = 400
"""Values along each side of a region at which the theory is evaluated."""

Span = tuple[float, float]
BEFORE, AFTER, ANY = (0.1, 1.0), (1.0, 7.0), (0.0, 8.0)
"""Ranges of a frequency ratio: before and after resonance, and all."""


def kinds_in_regions(
    session: Session, who: str, angle: str, regions: Sequence[tuple[Span, Span]]
) -> Numbers:
    """Return shares of the kinds of synchronism, for each region of (n_x, n_phi).

    By the orbits of the reference or an engine, and by theory, which alone is judged: in the whole
    region, ``theory``, and away from resonance, ``apart``, and there with mu_1 as printed. Other
    shares are those away from resonance, but for ``lesser_anywhere``, of the less frequent kind.
    """
    beta = BETAS[angle]
    plane = phase_map(session, beta, who)
    places = [inside(plane, *region) for region in regions]
    shares = [class_shares(plane, where) if np.any(where) else "no point there" for where in places]
    if who != REFERENCE:
        return {"orbits": shares}
    synphase: list[list[float]] = []  # of each region in whole, and away from resonance
    for region in regions:
        n_x, n_phi = np.meshgrid(*(np.linspace(*ends, FINE + 2)[1:-1] for ends in region))
        far = (abs(n_x - 1) > SMALL) & (abs(n_phi - 1) > SMALL)
        n = theory.Ratios(n_x, n_phi, beta=beta)
        own, by_print = (
            np.cos(theory.stable_phase_difference(n, how)) > 0 for how in (False, True)
        )
        synphase.append([np.mean(own), np.mean(own[far]), np.mean(by_print[far])])
    whole, apart, printed = np.array(synphase).T
    kinds = {
        name: [{"synphase": one, "antiphase": 1 - one} for one in own]
        for name, own in (("theory", whole), ("apart", apart), ("by_print", printed))
    }
    return {
        "orbits": shares,
        **kinds,
        "turn": 1 / np.cos(beta),
        "synphase": apart,
        "antiphase": 1 - apart,
        "printed_synphase": printed,
        "printed_antiphase": 1 - printed,
        "lesser": np.minimum(apart, 1 - apart),
        "printed_lesser": np.minimum(printed, 1 - printed),
        "lesser_anywhere": np.minimum(whole, 1 - whole),
    }


def level_orbits(session: Session, who: str) -> Numbers:
    """Return the properties of orbits at beta = 0, and for the reference the theory's phases.

    Shares of their kinds before and after the platform's resonance; the spread of their phases
    along n_phi [rad]; and the share of points without any. By theory the largest distance of the
    phases from pi before, and from 0 after resonance; their spread; and one as printed [rad].
    """
    plane = phase_map(session, 0.0, who)
    off_resonance = abs(plane.x.values - 1) > SMALL
    orbits = {
        "before": class_shares(plane, inside(plane, BEFORE, ANY)),
        "after": class_shares(plane, inside(plane, AFTER, ANY)),
        "spread": spread(plane.variables["phase_difference"][:, off_resonance]),
        "lost": np.mean(plane.variables["class"] == PHASES.index("none")),
    }
    if who != REFERENCE:
        return orbits
    n = lattice(0.0)
    alpha, before = theory.stable_phase_difference(n), n.n_x[0] < 1
    printed = theory.stable_phase_difference(theory.Ratios(0.5, 2.0, beta=0.0), as_printed=True)
    return orbits | {
        "off": max(np.max(abs(wrapped(alpha[:, before] - np.pi))), np.max(abs(alpha[:, ~before]))),
        "by_theory": spread(alpha),
        "printed": float(printed),
    }


def spread(phases: Array) -> float:
    """Return the largest distance of phases from the mean of their column [rad]."""
    unit = np.exp(1j * phases)
    return float(np.nanmax(abs(np.angle(unit / np.nanmean(unit, axis=0)))))


def figure_3(session: Session, who: str) -> Numbers:
    """Return the properties of the orbits over figure 3, for each beta.

    Shares of their kinds, and the largest of each; shares of points at which the theory has the
    same kind, and of those without a stable orbit; the median difference of the phases [rad]; and
    the least and largest mean speed of all [rad/s].
    """
    shares, agree, lost, gaps, speeds = [], [], [], [], []
    for beta in BETAS.values():
        plane = phase_map(session, beta, who)
        alpha, phase = theory_on(plane, beta), stable_phases(plane)
        shares.append(class_shares(plane))
        agree.append(np.mean(np.cos(alpha) * np.cos(phase) > 0))
        lost.append(np.mean(np.isnan(phase)))
        gaps.append(np.nanmedian(abs(wrapped(alpha - phase))))
        speeds.append(plane.variables["mean_speed"][np.isfinite(phase)])
    there = np.concatenate(speeds)
    return {
        "shares": shares,
        **{kind: max(item.get(kind, 0.0) for item in shares) for kind in PHASES},
        "agree": agree,
        "lost": lost,
        "gaps": gaps,
        "least": there.min(initial=np.inf),
        "largest": there.max(initial=-np.inf),
    }


STARTS: Mapping[str, Mapping[float, float]] = {
    "pi/6": {2.0: 1.7, 3.0: 1.8, 7.0: 2.0},
    "pi/3": {2.0: 2.1, 3.0: 2.65, 7.0: 3.4},
}
"""Installation angle -> n_x -> an n_phi with an orbit, near the fold at which it begins."""


@once
def folds(session: Session, angle: str) -> list[BoundaryAlong]:
    """Return where the synchronous orbit begins along k_phi, for each n_x."""
    scene, points = get_scene(SCENE), STARTS[angle].items()
    return [
        BoundaryAlong(scene, at_ratios(n_x, n_phi, BETAS[angle]), "fold", "rod_stiffness")
        for n_x, n_phi in points
    ]


def ratio_of(one: BoundaryAlong, place: float) -> float:
    """Return n_phi at a place of the window."""
    p = one.parameters.replace(rod_stiffness=one.value(place))
    return float(theory.ratios(p).n_phi)


def fold_curve(session: Session, angle: str) -> tuple[Array, Array]:
    """Return n_x and n_phi of the points at which the synchronous orbit begins."""
    places = [ratio_of(one, one.solution[1].place[1]) for one in folds(session, angle)]
    return np.array(list(STARTS[angle])), np.array(places)


SMALLER = (1.0, 1 / 4, 1 / 16, 1 / 64)
"""Factors of rotor masses and dampers: the small parameter."""


def small_parameter(session: Session) -> Numbers:
    """Return distances of orbits from the theory [rad] as rotors get lighter, and the order.

    And that with the rod's mass and spring smaller, too, and dampers weaker still.
    Case 2, dampers in proportion to the masses, motors and bearings to their square, as
    the torque by which vibration couples them.
    """

    def lighter(**powers: int) -> list[RotorPendulum]:
        """Return case 2 with parameters times powers of the small parameter."""
        return [
            CASE_2.replace(**{name: getattr(CASE_2, name) * mu**n for name, n in powers.items()})
            for mu in SMALLER
        ]

    rotors = {"rotor_mass": 1, "motor_slope": 2, "friction": 2}
    sets = lighter(**rotors, platform_damping=1, rod_damping=1)
    light = lighter(**rotors, platform_damping=2, rod_damping=3, rod_mass=1, rod_stiffness=1)[-1]
    apart = []
    for p in (*sets, light):
        phase = orbit_value(synchronous_orbit(session, p), "phase_difference")
        apart.append(float(abs(wrapped(phase - theory.stable_phase_difference(theory.ratios(p))))))
    *gaps, other = apart
    order = np.log(gaps[-2] / gaps[-1]) / np.log(SMALLER[-2] / SMALLER[-1])
    return {
        "factors": SMALLER,
        "gaps": gaps,
        "order": order,
        "off": abs(order - 1),
        "other": other,
        "kind": kind_of(synchronous_orbit(session, light)),
    }

"""Orbits, runs and maps that the figures and the ledger of the rotor_pendulum paper share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from ....reference import get_scene
from ....reference.errors import NoOrbitError
from ....reference.rotor_pendulum import CASE_1, CASE_2, CASE_3, theory
from ....reference.rotor_pendulum.equations import RotorPendulum, coefficients, operating_speed
from ....reference.scene import Array
from ....reference.solve.single import states_at
from ...engines.registry import REFERENCE
from ...maps.store import Map
from ...queries.orbit import OrbitReport, find
from ...queries.request import Query
from ...queries.simulate import simulate
from ...scenes.rotor_pendulum.phase import PHASES
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

r"""speed_regulator: a crank driven by a constant torque, held back by a damped slider; no gravity.

::

               A        O at the origin, OA = r, AB = l, C in the middle of AB
          r  / |        phi of the crank from the x axis
    M_m -> O   |        b of the rod from the y axis: l sin b = r cos phi
      J        C  m_b   B slides on the y axis, at y = r sin phi - l cos b
               |
               | /      lambda = r / l < 1: cos b never vanishes
               B  m
            k /=/ c     spring at rest at y_0

Source: Vlase, Mihalcica, Scutaru (2018), "Determining the Functional Parameters of a Simple
Speed Regulator", equations (1)-(21). One degree of freedom,
``J(phi) phi'' + J'(phi)/2 phi'^2 = M_m - y_phi (c y_phi phi' + k (y - y_0))``, which is (17)
with the ``J' = 2 A_1^T m A_2`` that (18) lacks the 2 of.

With ``h = l cos b = sqrt(l^2 - r^2 + r^2 sin^2 phi)``, in which nothing is subtracted that
nearly cancels, ``y_phi = -r y cos(phi) / h``. The homogeneous rod, J_C = m_b l^2 / 12, has the
kinetic energy ``m_b/6 (v_A^2 + v_A v_B + v_B^2)`` of its ends' velocities.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from ..errors import NoOrbitError, ParameterError
from ..scene import Array, Case, Paper, Parameters, Scene, quantity


@dataclass(frozen=True)
class SpeedRegulator(Parameters):
    """Parameters of `speed_regulator` (SI units).

    The paper gives lambda = 0.2, c = 2, 3, 4 and the speed 5.07 rad/s, which fix
    M_m / (c l^2); the other values are a choice.
    """

    crank_radius: float = quantity(0.25, "r", "m", "lambda = 0.2", "O to A")
    rod_length: float = quantity(1.25, "l", "m", "lambda = 0.2", "A to B")
    flywheel_inertia: float = quantity(2.0, "J", "kg m^2", "chosen", "crank and flywheel about O")
    rod_mass: float = quantity(0.5, "m_b", "kg", "chosen", "homogeneous rod", "non-negative")
    slider_mass: float = quantity(1.0, "m", "kg", "chosen", "slider", "non-negative")
    stiffness: float = quantity(32.0, "k", "N/m", "chosen", "spring of the slider", "non-negative")
    damping: float = quantity(
        2.0, "c", "N s/m", "figure 5: 2, 3, 4", "damper of the slider", "non-negative"
    )
    torque: float = quantity(0.32, "M_m", "N m", "5.07 rad/s", "constant motor torque", "any")
    spring_rest: float = quantity(-1.25, "y_0", "m", "(19): -l", "slider at rest", "any")

    def validate(self) -> None:
        """Refuse a rod that is not longer than the crank.

        Raises
        ------
        ParameterError
        """
        ratio = np.max(np.asarray(self.crank_radius) / self.rod_length)
        if ratio >= 1:
            raise ParameterError(
                f"lambda = crank_radius / rod_length must be less than 1, not {ratio:.6g}: the "
                f"crank could not turn; shorten crank_radius or lengthen rod_length"
            )


class Coefficients(NamedTuple):
    """Coefficients of (17), SI units; the two lumped masses stand for the homogeneous rod."""

    radius: Any
    length: Any
    gap: Any
    """l^2 - r^2"""
    inertia: Any
    """J + m_b r^2 / 3"""
    coupling: Any
    """m_b r / 6"""
    mass: Any
    """m + m_b / 3"""
    rod_mass: Any
    rod_inertia: Any
    slider_mass: Any
    stiffness: Any
    damping: Any
    torque: Any
    rest: Any


def coefficients(p: SpeedRegulator) -> Coefficients:
    """Coefficients of (13) and (17) from the parameters."""
    r, l = p.crank_radius, p.rod_length
    return Coefficients(
        radius=r,
        length=l,
        gap=(l - r) * (l + r),
        inertia=p.flywheel_inertia + p.rod_mass * r**2 / 3,
        coupling=p.rod_mass * r / 6,
        mass=p.slider_mass + p.rod_mass / 3,
        rod_mass=p.rod_mass,
        rod_inertia=p.rod_mass * l**2 / 12,
        slider_mass=p.slider_mass,
        stiffness=p.stiffness,
        damping=p.damping,
        torque=p.torque,
        rest=p.spring_rest,
    )


class Position(NamedTuple):
    """The mechanism at one phi: h = l cos b, the slider's y and its derivatives by phi."""

    sin: Any
    cos: Any
    h: Any
    y: Any
    y_phi: Any
    y_phi_phi: Any


def position(phi: Any, c: Coefficients, xp: Any = np) -> Position:
    """Solve the loop (3), (4) on its branch cos b > 0, with the derivatives (11), (12)."""
    r, sin, cos = c.radius, xp.sin(phi), xp.cos(phi)
    h = xp.sqrt(c.gap + r * r * sin * sin)
    y = r * sin - h
    y_phi = -r * y * cos / h
    y_phi_phi = (r * y * sin - y_phi * (r * cos + r * r * sin * cos / h)) / h
    return Position(sin, cos, h, y, y_phi, y_phi_phi)


def inertia(at: Position, c: Coefficients) -> Any:
    """Return J(phi) of (18) [kg m^2]."""
    return c.inertia + 2 * c.coupling * at.cos * at.y_phi + c.mass * at.y_phi * at.y_phi


def inertia_slope(at: Position, c: Coefficients) -> Any:
    """Return dJ/dphi [kg m^2], which is twice what (18) prints."""
    coupled = at.cos * at.y_phi_phi - at.sin * at.y_phi
    return 2 * (c.coupling * coupled + c.mass * at.y_phi * at.y_phi_phi)


def mass_matrix(q: Any, c: Coefficients, xp: Any = np) -> list[list[Any]]:
    """J(phi) of (18)."""
    return [[inertia(position(q[0], c, xp), c)]]


def forces(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> list[Any]:
    """Right-hand side of (17): the torque (19), damper kept, less J' phi'^2 / 2."""
    return [_forces(position(q[0], c, xp), v[0], c)]


def _forces(at: Position, speed: Any, c: Coefficients) -> Any:
    slider = c.damping * at.y_phi * speed + c.stiffness * (at.y - c.rest)
    return c.torque - at.y_phi * slider - inertia_slope(at, c) * speed * speed / 2


def accelerations(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> list[Any]:
    """Equation (17) solved for the acceleration."""
    at = position(q[0], c, xp)
    return [_forces(at, v[0], c) / inertia(at, c)]


def damping_matrix(c: Coefficients) -> Array:
    """Zero: the damper acts on the slider, c y_phi^2 on phi is no constant."""
    return np.zeros((1, 1))


def energy(q: Any, v: Any, c: Coefficients) -> Any:
    """Kinetic energy plus that of the spring [J]; the motor's torque is a power."""
    at = position(q[0], c)
    return (inertia(at, c) * v[0] ** 2 + c.stiffness * (at.y - c.rest) ** 2) / 2


def powers(u: Any, q: Any, v: Any, c: Coefficients) -> dict[str, Any]:
    """Powers [W] of the motor and of the damper."""
    slider_speed = position(q[0], c).y_phi * v[0]
    return {"motor": c.torque * v[0], "damper": -c.damping * slider_speed**2}


def outputs(q: Any, v: Any, c: Coefficients, xp: Any = np) -> dict[str, Any]:
    """Slider, rod, and the reactions of (13).

    ``reaction_a`` acts on the crank at A, its opposite on the rod; ``reaction_b`` acts on
    the rod at B, its opposite on the slider, whose guide takes the x component. ``rod_angle``
    is b, so that the rod turns with omega_2 = -b' (1).
    """
    at = position(q[0], c, xp)
    r, l, speed = c.radius, c.length, v[0]
    acceleration = _forces(at, speed, c) / inertia(at, c)
    sin_b, cos_b = r * at.cos / l, at.h / l
    turn = r * at.sin / at.h  # t of (7); u of (10) is its derivative
    turn_slope = r * at.cos / at.h - turn * turn * sin_b / cos_b
    y_ddot = at.y_phi * acceleration + at.y_phi_phi * speed * speed
    rod_x_ddot = -r / 2 * (at.sin * acceleration + at.cos * speed * speed)
    rod_y_ddot = (r * (at.cos * acceleration - at.sin * speed * speed) + y_ddot) / 2
    rod_spin = turn * acceleration + turn_slope * speed * speed
    y_dot = at.y_phi * speed
    load = c.damping * y_dot + c.stiffness * (at.y - c.rest)
    b_y = -load - c.slider_mass * y_ddot
    a_y = b_y - c.rod_mass * rod_y_ddot
    both_x = (2 * c.rod_inertia * rod_spin / l + sin_b * (a_y + b_y)) / cos_b
    return {
        "y": at.y,
        "y_dot": y_dot,
        "rod_angle": xp.atan(sin_b / cos_b),
        "rod_angle_dot": -turn * speed,
        "rod_x": r * at.cos / 2,
        "rod_y": (r * at.sin + at.y) / 2,
        "rod_x_dot": -r * at.sin * speed / 2,
        "rod_y_dot": (r * at.cos * speed + y_dot) / 2,
        "cos_b": cos_b,
        "reaction_a_x": (both_x - c.rod_mass * rod_x_ddot) / 2,
        "reaction_a_y": a_y,
        "reaction_b_x": (both_x + c.rod_mass * rod_x_ddot) / 2,
        "reaction_b_y": b_y,
    }


UNITS = {
    "phi": "rad",
    "phi_dot": "rad/s",
    "y": "m",
    "y_dot": "m/s",
    "rod_angle": "rad",
    "rod_angle_dot": "rad/s",
    "rod_x": "m",
    "rod_y": "m",
    "rod_x_dot": "m/s",
    "rod_y_dot": "m/s",
    "cos_b": "1",
    "reaction_a_x": "N",
    "reaction_a_y": "N",
    "reaction_b_x": "N",
    "reaction_b_y": "N",
}


def assembled(values: Mapping[str, Any], p: SpeedRegulator) -> Any:
    """Whether cos b > 0: the slider is below the crank pin."""
    height = p.crank_radius * np.sin(values["phi"]) - values["y"]
    return np.asarray(height / p.rod_length) > 0


# --- Rest ----------------------------------------------------------------------------------


def static_torque(phi: Any, c: Coefficients, xp: Any = np) -> Any:
    """Torque k y_phi (y - y_0) that holds the crank against the spring [N m]."""
    at = position(phi, c, xp)
    return c.stiffness * at.y_phi * (at.y - c.rest)


def static_stiffness(phi: Any, c: Coefficients, xp: Any = np) -> Any:
    """Slope of `static_torque` [N m/rad]: an equilibrium is stable where it is positive."""
    at = position(phi, c, xp)
    return c.stiffness * (at.y_phi_phi * (at.y - c.rest) + at.y_phi * at.y_phi)


EQUILIBRIA = ("right", "top", "left", "bottom")
ARC_SAMPLES = 512


def static_arcs(p: SpeedRegulator) -> dict[str, tuple[float, float]]:
    """Return the arc (phi, phi) on which each equilibrium moves as the torque changes.

    Without torque the crank rests where the slider is at y_0 (right and left), and at the
    dead centres of the slider (top and bottom). Along the arc about such a position, up to
    the next extremum of `static_torque` on either side, that torque is monotone; at its
    ends the equilibrium meets its neighbour and both vanish. Where the slider never comes
    to y_0 there is no right and no left.
    """
    c = coefficients(p)
    if p.stiffness == 0:
        return {}
    sine = ((p.spring_rest - c.length) * (p.spring_rest + c.length) + c.radius**2) / (
        2 * c.radius * (p.spring_rest or -math.inf)
    )  # law of cosines
    anchors = {"top": math.pi / 2, "bottom": 3 * math.pi / 2}
    if p.spring_rest < 0 and abs(sine) < 1:
        anchors |= {"right": math.asin(sine), "left": math.pi - math.asin(sine)}
    order = sorted(anchors, key=lambda name: anchors[name])
    ring = [anchors[order[-1]] - 2 * math.pi, *(anchors[name] for name in order)]
    ends = [_extremum(start, stop, c) for start, stop in pairwise(ring)]
    ends.append(ends[0] + 2 * math.pi)
    arcs = {name: (ends[i], ends[i + 1]) for i, name in enumerate(order)}
    return {name: arcs[name] for name in EQUILIBRIA if name in arcs}


def _extremum(start: float, stop: float, c: Coefficients) -> float:
    """Where between two of its zeros the static torque is largest in magnitude."""
    grid = np.linspace(start, stop, ARC_SAMPLES)
    i = int(np.argmax(np.abs(static_torque(grid, c))))
    near = grid[max(i - 1, 0)], grid[min(i + 1, ARC_SAMPLES - 1)]
    fit = minimize_scalar(
        lambda phi: -abs(static_torque(phi, c, math)), bounds=near, options={"xatol": 1e-12}
    )
    return float(fit.x)


def equilibrium(name: str, p: SpeedRegulator) -> dict[str, float]:
    """Return the rest position of this name.

    Raises
    ------
    NoOrbitError
        If these parameters have none.
    """
    arcs = static_arcs(p)
    if not arcs:
        raise NoOrbitError(
            "without a spring (stiffness 0) speed_regulator has no position of rest of its own"
        )
    if name not in arcs:
        r, l = p.crank_radius, p.rod_length
        raise NoOrbitError(
            f"speed_regulator has no equilibrium {name!r}: the slider never comes to spring_rest "
            f"{p.spring_rest:.6g} m; put it between {-r - l:.6g} and {r - l:.6g} m"
        )
    c = coefficients(p)
    low, high = sorted(static_torque(phi, c, math) for phi in arcs[name])
    if not low < p.torque < high:
        raise NoOrbitError(
            f"speed_regulator has no equilibrium {name!r}: the spring holds torques from "
            f"{low:.6g} to {high:.6g} N m there, not {p.torque:.6g} N m"
        )
    return {"phi": _balanced(arcs[name], c)}


def _balanced(arc: tuple[float, float], c: Coefficients) -> float:
    return float(brentq(lambda phi: static_torque(phi, c, math) - c.torque, *arc, xtol=1e-15))


def found_equilibria(p: SpeedRegulator) -> dict[str, float]:
    """Return the crank angle [rad] of each equilibrium that exists."""
    c = coefficients(p)
    found = {}
    for name, arc in static_arcs(p).items():
        low, high = sorted(static_torque(phi, c, math) for phi in arc)
        if low < p.torque < high:
            found[name] = _balanced(arc, c)
    return found


# --- Rotation ------------------------------------------------------------------------------


def mean_speed(p: SpeedRegulator) -> Any:
    """Speed [rad/s] at which the damper takes the motor's power: (21) with its exact average.

    The mean of y_phi^2 over a turn is ``l^2 (1 - sqrt(1 - lambda^2))``, of which the printed
    ``l^2 (0.5 lambda^2 + 0.000204)`` is the value near lambda = 0.2. Infinite without damping.
    """
    ratio = p.crank_radius / p.rod_length
    square = p.crank_radius**2 / (1 + np.sqrt((1 - ratio) * (1 + ratio)))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.divide(p.torque, p.damping * square)


def _guessed_speed(p: SpeedRegulator) -> Any:
    """`mean_speed` where that is a rotation, else 1 rad/s."""
    speed = mean_speed(p)
    return np.where(np.isfinite(speed) & (speed > 0), speed, 1.0)


def period(p: SpeedRegulator) -> Any:
    """Return the guess 2 pi / omega, omega from (21) [s]."""
    return 2 * np.pi / _guessed_speed(p)


GUESSED_HEADROOM = (0.02, 0.3, 1.0)
"""Kinetic energy at the hardest point of a turn, as shares of the spring's barrier."""


def orbit_guesses(p: SpeedRegulator) -> list[Array]:
    """States (phi = 0, phi') that may be near the rotation.

    The speed of (21), first as it is, then with the kinetic energy shared with the spring;
    and speeds that just clear the spring's barrier, as the slow rotations do.

    Returns
    -------
    list of arrays of shape (2, ...)
    """
    c = coefficients(p)
    speed = _guessed_speed(p)
    phi = np.linspace(0, 2 * np.pi, 64, endpoint=False).reshape(-1, *(1,) * np.ndim(speed))
    spring = c.stiffness / 2 * (position(phi, c).y - c.rest) ** 2
    climb = np.max(spring - c.torque * phi, axis=0) - spring[0]
    shared = np.mean(spring, axis=0) - spring[0]
    mass = inertia(position(0.0, c), c)
    squares = [speed**2, np.maximum(speed**2 + 2 * shared / mass, 0.01 * speed**2)]
    squares += [2 * climb * (1 + share) / mass for share in GUESSED_HEADROOM]
    return [
        np.array(np.broadcast_arrays(0.0, np.sqrt(square)), dtype=float)
        for square in np.broadcast_arrays(*squares)
    ]


REFINEMENT = 16
"""Points that a trigonometric interpolant puts in place of one sample."""


def extremes(samples: Array) -> tuple[float, float]:
    """Smallest and largest value of a periodic function from uniform samples of one period.

    The trigonometric interpolant, and a parabola through its three points about each extreme.
    """
    count = REFINEMENT * len(samples)
    fine = REFINEMENT * np.fft.irfft(np.fft.rfft(samples), count)
    found = []
    for i in (int(np.argmin(fine)), int(np.argmax(fine))):
        before, at, after = fine[i - 1], fine[i], fine[(i + 1) % count]
        bend = before - 2 * at + after
        found.append(float(at - (after - before) ** 2 / (8 * bend)) if bend else float(at))
    return found[0], found[1]


ORBIT_UNITS = {
    "mean_speed": "rad/s",
    "minimum_speed": "rad/s",
    "maximum_speed": "rad/s",
    "irregularity": "1",
    "damper_work_ratio": "1",
}


def orbit_quantities(states: Array, c: Coefficients) -> dict[str, float]:
    """Return the speed's mean and extremes, and the damper's share of the motor's work."""
    speed = states[1]
    mean = float(np.mean(speed))  # over time: 2 pi / T
    low, high = extremes(speed)
    power = c.damping * np.mean((position(states[0], c).y_phi * speed) ** 2)
    motor = c.torque * mean
    return {
        "mean_speed": mean,
        "minimum_speed": low,
        "maximum_speed": high,
        "irregularity": (high - low) / mean,
        "damper_work_ratio": float(power / motor) if motor else math.nan,
    }


# --- What a run ends in --------------------------------------------------------------------

TURNS_SEEN = 3
STEADY = 0.02
"""Largest relative change of the speed still to come of a rotation that counts as settled."""
RESTING = 1e-3
"""Largest energy of a state of rest, as a share of the depth of its well."""
LAST_PART = 0.1
"""Share of the run in which a state of rest is asked for."""


def outcome(times: Array, values: Mapping[str, Array], p: SpeedRegulator) -> str:
    """Return what a run ends in.

    ``rotation``: three full turns forward without a pause, whose mean speeds, extrapolated
    as a geometric sequence, have settled. ``rest``: through the last tenth of the run, next
    to nothing of the energy that it takes to leave the well of a stable equilibrium. A model
    that stands still anywhere else has not come to rest, and is ``undecided``.
    """
    phi, speed = (np.asarray(values[name], dtype=float) for name in ("phi", "phi_dot"))
    if not (np.all(np.isfinite(phi)) and np.all(np.isfinite(speed)) and len(phi) > 1):
        return "undecided"
    if _rests(np.asarray(times), phi, speed, p):
        return "rest"
    return "rotation" if _rotates(np.asarray(times), phi, speed) else "undecided"


def _rests(times: Array, phi: Array, speed: Array, p: SpeedRegulator) -> bool:
    c = coefficients(p)
    last = times >= times[-1] - LAST_PART * (times[-1] - times[0])
    phi, speed = phi[last], speed[last]

    def free_energy(phi: Any, speed: Any = 0.0) -> Any:
        return energy([phi], [speed], c) - c.torque * phi

    angles = list(found_equilibria(p).values())
    saddles = np.array([angle for angle in angles if static_stiffness(angle, c, math) < 0])
    barriers = np.concatenate([saddles + 2 * np.pi * turn for turn in (-2, -1, 0, 1, 2)])
    for centre in angles:
        if static_stiffness(centre, c, math) <= 0:
            continue
        walls = np.max(barriers[barriers < centre]), np.min(barriers[barriers > centre])
        depth = min(free_energy(wall) for wall in walls) - free_energy(centre)
        near = phi - 2 * np.pi * np.round((phi[-1] - centre) / (2 * np.pi))
        inside = np.all((near > walls[0]) & (near < walls[1]))
        excess = free_energy(near, speed) - free_energy(centre)
        if inside and np.all(excess < RESTING * depth):
            return True
    return False


def _rotates(times: Array, phi: Array, speed: Array) -> bool:
    marks = phi[-1] - 2 * np.pi * np.arange(TURNS_SEEN, -1, -1)
    if phi[0] >= marks[0]:
        return False
    begin = int(np.flatnonzero(phi < marks[0])[-1])
    if np.any(speed[begin:] <= 0) or np.any(np.diff(phi[begin:]) <= 0):
        return False
    passed = np.interp(marks, phi[begin:], times[begin:])
    speeds = 2 * np.pi / np.diff(passed)
    before, now = np.abs(np.diff(speeds))[-2:]
    ratio = now / before if before > now else 0.0
    remaining = now / (1 - ratio)
    return bool(remaining < STEADY * speeds[-1])


# --- Cases ---------------------------------------------------------------------------------

DEFAULT = SpeedRegulator()
CONSERVATIVE = DEFAULT.replace(torque=0.0, damping=0.0)
MASSLESS = DEFAULT.replace(rod_mass=0.0, slider_mass=0.0)
LONG_CRANK = DEFAULT.replace(crank_radius=0.4, rod_length=0.5, spring_rest=-0.5, torque=1.5)
HEAVY_ROD = DEFAULT.replace(rod_mass=3.0, slider_mass=0.2, flywheel_inertia=0.5, torque=0.6)
STRETCHED = DEFAULT.replace(spring_rest=-1.1, stiffness=80.0, torque=0.5)
COEXISTENCE = DEFAULT.replace(flywheel_inertia=0.25, torque=0.4)
ROTATING = {"phi_dot": 5.07}
FREE_RUN = ("algebra", "trajectory", "order")


def _case(
    name: str, p: SpeedRegulator, state: dict[str, float], horizon: float, *kinds: str
) -> Case:
    return Case("speed_regulator", name, p, state, horizon, kinds)


def _full(
    name: str, p: SpeedRegulator, state: dict[str, float], horizon: float, *kinds: str
) -> Case:
    return replace(_case(name, p, state, horizon, *kinds), full_only=True)


def _ending(name: str, state: dict[str, float], horizon: float) -> Case:
    case = _case(name, COEXISTENCE, state, horizon, "stability")
    return replace(case, watch="outcome", methods="best")


CASES = (
    _case("rotation", DEFAULT, ROTATING, 2.0, *FREE_RUN),
    _case("startup", DEFAULT, {"phi": 0.5}, 2.0, "trajectory"),
    _case("dead_centre", DEFAULT, {"phi": np.pi / 2, **ROTATING}, 1.0, "trajectory"),
    _case("conservative", CONSERVATIVE, {"phi_dot": 2.0}, 2.0, "trajectory", "energy"),
    _case("massless_rod_and_slider", MASSLESS, ROTATING, 2.0, "algebra", "trajectory"),
    _case("long_crank", LONG_CRANK, {"phi_dot": 6.0}, 1.0, "algebra", "trajectory"),
    replace(_case("opened_loop", DEFAULT, ROTATING, 1.0, "trajectory"), inconsistency={"y": 1e-3}),
    _case("limit_cycle", DEFAULT, ROTATING, 1.25, "stability"),
    _full("limit_cycle_c4", DEFAULT.replace(damping=4.0), ROTATING, 1.25, "stability"),
    _ending("settles_to_rest", {"phi_dot": 1.0}, 30.0),
    _ending("settles_to_rotation", {"phi_dot": 5.0}, 30.0),
    _full("heavy_rod", HEAVY_ROD, ROTATING, 2.0, *FREE_RUN),
    _full("stretched_spring", STRETCHED, {"phi": 2.0, "phi_dot": 4.0}, 2.0, *FREE_RUN),
    *(
        _case(f"rest_{name}", DEFAULT, equilibrium(name, DEFAULT), 0.5, "frequency")
        for name in ("right", "top", "left")
    ),
)

SCENE = Scene(
    name="speed_regulator",
    title="speed regulator: a slider-crank with a sprung and damped slider",
    paper=Paper(
        "S. Vlase, M. Mihalcica, M. L. Scutaru",
        "Determining the Functional Parameters of a Simple Speed Regulator",
        "",
        2018,
        "",
    ),
    parameters=SpeedRegulator,
    coordinates=("phi",),
    units=UNITS,
    coefficients=coefficients,
    mass_matrix=mass_matrix,
    forces=forces,
    accelerations=accelerations,
    damping_matrix=damping_matrix,
    energy=energy,
    powers=powers,
    equilibria={name: partial(equilibrium, name) for name in EQUILIBRIA},
    turning={"phi": 1},
    section="phi",
    period=period,
    orbit_guesses=orbit_guesses,
    cases=CASES,
    outputs=outputs,
    observed=("y", "y_dot"),
    invariants=lambda p: {"energy": energy},
    orbit_quantities=orbit_quantities,
    orbit_units=ORBIT_UNITS,
    outcome=outcome,
    assembled=assembled,
)

r"""rotor_pendulum: two unbalanced rotors, one on a sprung platform, one on a pendulum rod.

::

                                          o m        x_1 = x - r cos(phi_1), y_1 = r sin(phi_1)
      |\/\/\/|  k_x                 m_3  / phi_2     x_3 = x + l cos(B),     y_3 = l sin(B)
    --|      |----[ m_0 ]-----------(o)-'            x_2 = x_3 + r cos(phi_2), ...
      |=[ ]==|  f_x  /`o m    l  .-'
                    r phi_1   .-'  B = beta + phi_3 from the x axis; torsion spring k_phi,
              ---> x      o-'      f_phi between platform and rod

Source: Fang, Hou, Nan, Yu (2015), J. Vibroengineering 17(5), equations (7)-(14) and section
5.2. No gravity.
The geometry is the one that gives the printed kinetic energy (7); phi_1 and phi_2 turn
opposite ways and are absolute angles; rotors and rod are point masses.

The equations are Lagrange's of (7)-(9), nothing dropped. The paper's own (11) puts
``B -> beta`` after deriving, which drops one of two terms of the same order, so that it
does not conserve energy: it is the variant ``reduced``. Its fourth line is printed with
``+ phi_2'^2 sin(phi_2 - beta)``, a sign error that (12) does not repeat.

The motors of (14) are dimensionally broken and friction is not given. They are read as
``k_e (omega_s - w) - f w``: a torque linear in the speed w, less bearing friction, with k_e
and f from the torque and speed that case 1 of section 5.2 settles at. In the paper's equations the
second motor's torque works on the absolute angle phi_2 and leaves the rod alone
(``absolute``); between rod and rotor (``relative``), w is phi_2' - phi_3' and the rod bears the
reaction.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..scene import Array, Case, Paper, Parameters, Scene, choice, quantity

PLACEMENTS = ("absolute", "relative")


@dataclass(frozen=True)
class RotorPendulum(Parameters):
    """Parameters of `rotor_pendulum` (SI units); defaults from table 1 and case 1 of section 5.2.

    The printed frequency ratios do not belong to the printed stiffnesses; the stiffnesses
    reproduce the paper's runs.
    """

    platform_mass: float = quantity(100.0, "m_0", "kg", "table 1", "sprung platform")
    rotor_mass: float = quantity(2.0, "m", "kg", "table 1", "each rotor's unbalanced mass")
    rod_mass: float = quantity(10.0, "m_3", "kg", "table 1", "at the end of the pendulum rod")
    eccentricity: float = quantity(0.05, "r", "m", "table 1", "rotor axis to its mass")
    rod_length: float = quantity(0.3, "l", "m", "table 1", "hinge to the second rotor's axis")
    platform_stiffness: float = quantity(
        9859600.0, "k_x", "N/m", "section 5.2, 1)", "platform spring", "non-negative"
    )
    platform_damping: float = quantity(
        1064.0, "f_x", "N s/m", "table 1", "platform damper", "non-negative"
    )
    rod_stiffness: float = quantity(
        976100.0, "k_phi", "N m/rad", "section 5.2, 1)", "torsion spring", "non-negative"
    )
    rod_damping: float = quantity(
        15.0, "f_phi", "N m s/rad", "table 1", "torsion damper", "non-negative"
    )
    installation_angle: float = quantity(
        np.pi / 6, "beta", "rad", "section 5.2", "rod from the x axis, spring relaxed", "any"
    )
    motor_slope: float = quantity(
        0.94, "k_e", "N m s/rad", "case 1's torque", "torque per slip", "non-negative"
    )
    synchronous_speed: float = quantity(
        50 * np.pi, "omega_s", "rad/s", "50 Hz, 2 pole pairs", "motor's speed at no torque"
    )
    friction: float = quantity(
        0.02, "f", "N m s/rad", "case 1's speed", "of each rotor's bearing", "non-negative"
    )
    motor_placement: str = choice(PLACEMENTS, "(11)", "what the second motor turns against")


class Coefficients(NamedTuple):
    """Parameters under short names, the words as numbers; ``relative`` is 0 or 1."""

    platform: Any
    rotor: Any
    rod: Any
    eccentricity: Any
    length: Any
    stiffness: Any
    damping: Any
    rod_stiffness: Any
    rod_damping: Any
    beta: Any
    slope: Any
    speed: Any
    friction: Any
    relative: Any

    @property
    def mass(self) -> Any:
        """M, all that moves with x [kg]."""
        return self.platform + self.rod + 2 * self.rotor

    @property
    def unbalance(self) -> Any:
        """Unbalance m r [kg m]."""
        return self.rotor * self.eccentricity

    @property
    def end_mass(self) -> Any:
        """Mass at the rod's end, m + m_3 [kg]."""
        return self.rotor + self.rod

    @property
    def loss(self) -> Any:
        """Torque lost per speed, k_e + f [N m s/rad]."""
        return self.slope + self.friction


def coefficients(p: RotorPendulum) -> Coefficients:
    """Return the parameters as they stand in the equations."""
    *numbers, placement = (getattr(p, name) for name in p.names())
    return Coefficients._make([*numbers, float(PLACEMENTS.index(placement))])


def motor_rates(v: Any, c: Coefficients) -> tuple[Any, Any]:
    """Speeds [rad/s] that the motors and bearings see."""
    return v[1], v[2] - c.relative * v[3]


def mass_matrix(q: Any, c: Coefficients, xp: Any = np) -> list[list[Any]]:
    """Mass matrix of Lagrange's equations of (7), q = (x, phi_1, phi_2, phi_3)."""
    return _mass_matrix(q, c.beta + q[3], c, xp)


def _mass_matrix(q: Any, rod: Any, c: Coefficients, xp: Any) -> list[list[Any]]:
    inertia = c.unbalance * c.eccentricity
    first = c.unbalance * xp.sin(q[1])
    second = -c.unbalance * xp.sin(q[2])
    lift = -c.end_mass * c.length * xp.sin(rod)
    coupling = c.unbalance * c.length * xp.cos(q[2] - rod)
    return [
        [c.mass, first, second, lift],
        [first, inertia, 0.0, 0.0],
        [second, 0.0, inertia, coupling],
        [lift, 0.0, coupling, c.end_mass * c.length**2],
    ]


def forces(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> list[Any]:
    """Right-hand side of ``M(q) a = f``; the motors' torques stand in it."""
    return _forces(q, v, c.beta + q[3], c, xp)


def _forces(q: Any, v: Any, rod: Any, c: Coefficients, xp: Any) -> list[Any]:
    first, second, reaction = _torques(v, c)
    swing = c.unbalance * c.length * xp.sin(q[2] - rod)
    rotors = xp.cos(q[2]) * v[2] * v[2] - xp.cos(q[1]) * v[1] * v[1]
    return [
        c.unbalance * rotors
        + c.end_mass * c.length * xp.cos(rod) * v[3] * v[3]
        - c.damping * v[0]
        - c.stiffness * q[0],
        first,
        second - swing * v[3] * v[3],
        swing * v[2] * v[2] - c.rod_damping * v[3] - c.rod_stiffness * q[3] - reaction,
    ]


def _torques(v: Any, c: Coefficients) -> tuple[Any, Any, Any]:
    """Torques of motor and bearing on phi_1, phi_2, and what the rod bears of the second."""
    first, second = (c.slope * c.speed - c.loss * rate for rate in motor_rates(v, c))
    return first, second, c.relative * second


def accelerations(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> list[Any]:
    """Lagrange's equations of (7)-(9) solved for the accelerations."""
    return _accelerations(q, v, c.beta + q[3], c, xp)


def _accelerations(q: Any, v: Any, rod: Any, c: Coefficients, xp: Any) -> list[Any]:
    """Solve for x'' and phi_3'' with the rotors eliminated, then for the rotors.

    A rotor on its bearing acts by its torque over r and by the part of its mass that lies
    along its arm. The 2 x 2 mass matrix and its determinant are sums of squares, so that no
    digits are lost where the rotors are far heavier than platform and rod.
    """
    m, m_3, r, l = c.rotor, c.rod, c.eccentricity, c.length
    cos_1, sin_1, cos_2, sin_2 = xp.cos(q[1]), xp.sin(q[1]), xp.cos(q[2]), xp.sin(q[2])
    cos_rod, sin_rod = xp.cos(rod), xp.sin(rod)
    cos_arm, sin_arm = xp.cos(q[2] - rod), xp.sin(q[2] - rod)
    spin_1, spin_2, swing = v[1] * v[1], v[2] * v[2], v[3] * v[3]
    first, second, reaction = _torques(v, c)

    m_xx = c.platform + m_3 + m * (cos_1 * cos_1 + cos_2 * cos_2)
    m_x3 = m * cos_2 * sin_arm - m_3 * sin_rod  # over l
    m_33 = m_3 + m * sin_arm * sin_arm  # over l^2
    determinant = (c.platform + m * cos_1 * cos_1) * m_33 + m_3 * c.end_mass * cos_rod * cos_rod
    f_x = (
        (sin_2 * second - sin_1 * first) / r
        + m * r * (cos_2 * spin_2 - cos_1 * spin_1)
        + l * (m_3 * cos_rod + m * cos_2 * cos_arm) * swing
        - c.damping * v[0]
        - c.stiffness * q[0]
    )
    f_3 = (
        m * sin_arm * (r * spin_2 + l * cos_arm * swing)
        - cos_arm / r * second
        - (c.rod_damping * v[3] + c.rod_stiffness * q[3] + reaction) / l
    )  # over l
    a_x = (m_33 * f_x - m_x3 * f_3) / determinant
    a_3 = (m_xx * f_3 - m_x3 * f_x) / (l * determinant)
    return [
        a_x,
        (first / (m * r) - sin_1 * a_x) / r,
        (second / (m * r) + sin_2 * a_x - l * (cos_arm * a_3 + sin_arm * swing)) / r,
        a_3,
    ]


def damping_matrix(c: Coefficients) -> Array:
    """Dampers of platform and rod; motors and bearings are no joint damping."""
    return np.diag([c.damping, 0.0, 0.0, c.rod_damping])


def energy(q: Any, v: Any, c: Coefficients) -> Any:
    """Kinetic energy (7) plus potential energy (8) [J]."""
    kinetic = sum(
        v[i] * v[j] * entry
        for i, row in enumerate(mass_matrix(q, c))
        for j, entry in enumerate(row)
    )
    return (kinetic + c.stiffness * q[0] ** 2 + c.rod_stiffness * q[3] ** 2) / 2


def momentum(q: Any, v: Any, c: Coefficients) -> Any:
    """Momentum along x [kg m/s]."""
    return sum(rate * entry for rate, entry in zip(v, mass_matrix(q, c)[0], strict=True))


def powers(u: Any, q: Any, v: Any, c: Coefficients) -> dict[str, Any]:
    """Powers [W] of the motors, their bearings and the two dampers."""
    first, second = motor_rates(v, c)
    return {
        "motor_1": c.slope * (c.speed - first) * first,
        "motor_2": c.slope * (c.speed - second) * second,
        "friction_1": -c.friction * first**2,
        "friction_2": -c.friction * second**2,
        "platform": -c.damping * v[0] ** 2,
        "rod": -c.rod_damping * v[3] ** 2,
    }


def invariants(p: RotorPendulum) -> Mapping[str, Callable[..., Any]]:
    """Energy always; momentum along x where no spring holds the platform."""
    if np.any(p.platform_stiffness):
        return {"energy": energy}
    return {"energy": energy, "momentum": momentum}


def unforced(p: RotorPendulum) -> RotorPendulum:
    """Motors and bearing friction off."""
    return p.replace(motor_slope=0.0, friction=0.0)


def operating_speed(p: RotorPendulum) -> Any:
    """Speed [rad/s] at which motor and bearing balance; the motor's own where it is off."""
    share = np.divide(
        p.motor_slope,
        p.motor_slope + np.asarray(p.friction),
        where=np.asarray(p.motor_slope) > 0,
        out=np.ones(np.broadcast_shapes(np.shape(p.motor_slope), np.shape(p.friction))),
    )
    return p.synchronous_speed * share


def period(p: RotorPendulum) -> Any:
    """Guess of a turn's time [s]: the dampers slow the rotors down a little more."""
    return 2 * np.pi / operating_speed(p)


# Phase of the rotors ------------------------------------------------------------------------


def forced_response(
    p: RotorPendulum, phase_difference: ArrayLike, speed: Any = None
) -> tuple[Any, Any]:
    """Steady x and phi_3 with both rotors turning uniformly, to first order.

    This is (16), with the dampers that it neglects. The rotors' masses count at their axes.

    Parameters
    ----------
    p : RotorPendulum
    phase_difference : array_like
        phi_1 - phi_2 [rad].
    speed : float or array, optional
        Of the rotors [rad/s], by default `operating_speed`.

    Returns
    -------
    X, Phi : complex
        Amplitudes, ``x = Re(X e^{i phi_1})`` [m] and ``phi_3 = Re(Phi e^{i phi_1})`` [rad].
    """
    c = coefficients(p)
    w = operating_speed(p) if speed is None else speed
    alpha = np.asarray(phase_difference)
    lift = c.end_mass * c.length * np.sin(c.beta) * w**2
    rod_damping = c.rod_damping + c.relative * c.loss
    platform = c.stiffness - c.mass * w**2 + 1j * w * c.damping
    rod = c.rod_stiffness - c.end_mass * c.length**2 * w**2 + 1j * w * rod_damping
    push = c.unbalance * w**2 * (np.exp(-1j * alpha) - 1)
    swing = -1j * c.unbalance * c.length * w**2 * np.exp(-1j * (alpha + c.beta))
    determinant = platform * rod - lift**2
    return (rod * push - lift * swing) / determinant, (platform * swing - lift * push) / determinant


def coupling_torque(p: RotorPendulum, phase_difference: ArrayLike, speed: Any = None) -> Any:
    """Mean torque by which the vibration drives rotor 1 ahead of rotor 2 [N m].

    The difference of the two averages in (26), with the dampers. It has the form
    ``c_0 + c_1 sin(alpha - alpha_0)``; without dampers c_0 = 0 and its zeros are those of (30).

    Parameters
    ----------
    p : RotorPendulum
    phase_difference : array_like
        alpha = phi_1 - phi_2 [rad].
    speed : float or array, optional
        Of the rotors [rad/s], by default `operating_speed`.
    """
    c = coefficients(p)
    w = operating_speed(p) if speed is None else speed
    alpha = np.asarray(phase_difference)
    x, phi_3 = forced_response(p, alpha, w)
    push = np.imag(x) + np.imag(x * np.exp(1j * alpha))
    swing = c.length * np.real(phi_3 * np.exp(1j * (alpha + c.beta)))
    return -c.unbalance * w**2 / 2 * (push + swing)


def coupling_harmonics(p: RotorPendulum, speed: Any = None) -> tuple[Any, Any]:
    """Return c_0 and complex C_1 of ``coupling_torque = c_0 + Re(C_1 e^{i alpha})`` [N m]."""
    w = operating_speed(p) if speed is None else speed
    at_0, at_quarter, at_half = (coupling_torque(p, k * np.pi / 2, w) for k in range(3))
    mean = (at_0 + at_half) / 2
    return mean, (at_0 - at_half) / 2 - 1j * (at_quarter - mean)


def balanced_phase(p: RotorPendulum, speed: Any = None) -> Any:
    """Stable phase difference [rad] by the Poincare method, dampers included.

    Where the damper torque is too large to be balanced (NaN), there is none.
    """
    mean, first = coupling_harmonics(p, speed)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.angle(np.exp(1j * (np.arccos(-mean / abs(first)) - np.angle(first))))


def settling_rate(p: RotorPendulum, phase_difference: Any, speed: Any = None) -> Any:
    """Rate [1/s] at which the phase settles near this phase difference; < 0 where it runs away.

    The slow root of ``m r^2 alpha'' + (k_e + f) alpha' = coupling_torque``, linearised.
    """
    _, first = coupling_harmonics(p, speed)
    return _slow_root(np.imag(first * np.exp(1j * np.asarray(phase_difference))), coefficients(p))


def _slow_root(stiffness: Any, c: Coefficients) -> Any:
    """Decay rate [1/s] of ``m r^2 alpha'' + (k_e + f) alpha' + stiffness alpha = 0``."""
    inertia = c.unbalance * c.eccentricity
    root = np.sqrt(np.asarray(c.loss**2 - 4 * inertia * stiffness, dtype=complex))
    return (2 * stiffness / (c.loss + root)).real


EVENLY = np.arange(8) * np.pi / 4
"""Phase differences tried beside the theory's, which knows no ripple of the rotors."""


def orbit_guesses(p: RotorPendulum) -> list[Array]:
    """Uniform rotation with the linear response, at phi_1 = 0.

    At the stable phase difference of the Poincare method, where it has one (the nearest
    zero otherwise), then `EVENLY`.

    Returns
    -------
    list of arrays of shape (8, ...)
    """
    w = operating_speed(p)
    mean, first = coupling_harmonics(p)
    stable = np.where(
        abs(mean) < abs(first), np.nan_to_num(balanced_phase(p)), -np.angle(first) + np.pi / 2
    )
    guesses = []
    for alpha in (stable, *EVENLY):
        x, phi_3 = forced_response(p, alpha)
        q = (x.real, 0.0, -alpha % (2 * np.pi), phi_3.real)
        v = (-w * x.imag, w, w, -w * phi_3.imag)
        guesses.append(np.array(np.broadcast_arrays(*q, *v), dtype=float))
    return guesses


def wrapped(angle: Any) -> Any:
    """Angle in (-pi, pi]."""
    return np.pi - (np.pi - np.asarray(angle)) % (2 * np.pi)


def mean_phase(alpha: Array, weights: Array | None = None) -> float:
    """Mean of angles on the circle, in (-pi, pi]."""
    return float(wrapped(np.angle(np.average(np.exp(1j * alpha), weights=weights))))


ORBIT_UNITS = {
    "mean_speed": "rad/s",
    "phase_difference": "rad",
    "motor_torque_1": "N m",
    "motor_torque_2": "N m",
    "platform_amplitude": "m",
    "rod_amplitude": "rad",
}


def orbit_quantities(states: Array, c: Coefficients) -> dict[str, float]:
    """Mean speed and phase difference, mean motor torques, amplitudes (half of the range)."""
    first, second = (np.mean(c.slope * (c.speed - rate)) for rate in motor_rates(states[4:], c))
    return {
        "mean_speed": float(np.mean(states[5])),  # over time: 2 pi / T
        "phase_difference": mean_phase(states[1] - states[2]),
        "motor_torque_1": float(first),
        "motor_torque_2": float(second),
        "platform_amplitude": float(np.ptp(states[0]) / 2),
        "rod_amplitude": float(np.ptp(states[3]) / 2),
    }


# What a run ends in -------------------------------------------------------------------------

WATCH = 8.0
"""Times 1/rate that must be watched: what was one radian away is then 0.3 mrad away."""

LEAST_TURNS = 40
"""Turns watched at least, however fast the phase settles: ten in each quarter, of which
Hann's weights leave 1e-3 of the ripple within a turn."""

LEAST_SAMPLES = 8
"""Samples in each turn; with fewer a rotor's turn may look like its standing still."""

JUMP = 0.5
"""Angle [rad] by which a coordinate may miss what its rate makes of it between two samples.
The ripple of a rotor makes 0.01 at 8 samples a turn; a reset to rest makes anything."""

STALLED = 0.1
"""Share of `operating_speed` below which a rotor does not turn, although its motor is on."""

STALL_TIME = 50.0
"""Motor time constants m r^2 / (k_e + f) that a rotor is given to start."""

DRIFT = 0.01
"""Largest last drift of the phase over the rate at which it settles [rad]: about what is
still missing to the settled phase."""

DECAY = 0.25
"""Largest last drift over the one half a watch before. Of a settling phase e^-4 = 0.02 is
left; an escape has made it grow; a slow passage between two slips leaves it much as it was."""

AT_REST = 1e-4
"""Drift [rad] that is none: ripple and the engine's own errors hide whether it grows. There
the slope of the coupling torque decides."""


def outcome(times: Any, values: Mapping[str, Any], p: RotorPendulum) -> str:
    """Tell what a run ends in: synchronised, not synchronised, or undecided.

    The end of the run is watched for ``WATCH / rate`` with the rate at which the phase
    settles by the Poincare method (`phase_rate`), and for `LEAST_TURNS` turns at least.
    The first that holds of:

    1. *undecided*: a value is not finite; nothing resists the rotors.
    2. *not synchronised*: a rotor stands still at the end, having had the time to start
       (`STALLED`, `STALL_TIME`). Two rotors at rest share phase and speed.
    3. *undecided*: the run is shorter than the watch, or has fewer than `LEAST_SAMPLES`
       samples to a turn.
    4. *not synchronised*: a rotor stands still at any sample of the watch.
    5. *undecided*: an angle jumps away from its rate (`JUMP`): a reset.
    6. *not synchronised*: in the second half of the watch one rotor gains a turn on the other.
    7. *undecided*: the phase drifts by more than `DRIFT` times the rate, or its drift does
       not decay (`DECAY`) although it is not `AT_REST`: still settling, about to slip, or
       escaping from the unstable phase difference.
    8. *undecided*: the phase rests where the coupling torque drives it away. Small errors
       hold it there for a while, not for ever.
    9. *synchronised*: what is left.

    Phases are averaged on the circle, over each quarter of the watch; drifts are what they
    change by from the first to the second quarter, and from the third to the last.

    Parameters
    ----------
    times : array (n,)
        Sample times [s], increasing.
    values : mapping
        ``phi_1``, ``phi_2`` [rad, wrapped or not], ``phi_1_dot``, ``phi_2_dot`` [rad/s].
    p : RotorPendulum

    Returns
    -------
    {"synchronised", "not synchronised", "undecided"}
    """
    t = np.asarray(times, dtype=float)
    angles = np.array([values["phi_1"], values["phi_2"]], dtype=float)
    rates = np.array([values["phi_1_dot"], values["phi_2_dot"]], dtype=float)
    c = coefficients(p)
    if len(t) < 2 or not np.all(np.isfinite([t, *angles, *rates])) or c.loss == 0:
        return "undecided"
    start = STALL_TIME * c.unbalance * c.eccentricity / c.loss
    slowest = STALLED * float(operating_speed(p))
    if t[-1] - t[0] >= start and np.any(np.mean(rates[:, t >= t[-1] - start], axis=1) < slowest):
        return "not synchronised"
    speed = float(np.max(np.mean(rates[:, t >= (t[0] + t[-1]) / 2], axis=1)))
    rate = float(phase_rate(p, speed))
    if not (speed > 0 and rate > 0):
        return "undecided"
    watch = max(WATCH / rate, LEAST_TURNS * 2 * np.pi / speed)
    seen = t >= t[-1] - watch
    if watch > t[-1] - t[0] or np.max(np.diff(t[seen])) * speed > 2 * np.pi / LEAST_SAMPLES:
        return "undecided"
    t, angles, rates = t[seen], angles[:, seen], rates[:, seen]
    if np.any(rates < slowest):
        return "not synchronised"
    steps = np.diff(t) * (rates[:, 1:] + rates[:, :-1]) / 2
    if np.max(abs(wrapped(np.diff(angles, axis=1) - steps))) > JUMP:
        return "undecided"
    if abs(np.sum((steps[0] - steps[1])[t[1:] > t[-1] - watch / 2])) > 2 * np.pi:
        return "not synchronised"
    phases = _quarterly_phases(t, angles[0] - angles[1], watch)
    early, last = abs(wrapped(phases[1::2] - phases[::2]))
    if last > min(DRIFT * rate * watch / 4, max(DECAY * early, AT_REST)):
        return "undecided"
    return "synchronised" if settling_rate(p, phases[3], speed) > 0 else "undecided"


def _quarterly_phases(t: Array, alpha: Array, watch: float) -> Array:
    """Mean phase in each quarter of the watch, with Hann's weights."""
    place = 4 * (1 - (t[-1] - t) / watch)  # 0 to 4
    weights = np.sin(np.pi * place) ** 2 * np.gradient(t)
    parts = [(place >= i) & (place <= i + 1) for i in range(4)]
    return np.array([mean_phase(alpha[part], weights[part]) for part in parts])


def phase_rate(p: RotorPendulum, speed: Any = None) -> Any:
    """Rate [1/s] by which a run is judged long enough.

    Where there is a stable phase difference, the rate at which it settles. Where there is
    none, half of the circular frequency of the slips: two of them fit into a watch.
    """
    mean, first = coupling_harmonics(p, speed)
    square = abs(first) ** 2 - mean**2
    return _slow_root(np.sqrt(abs(square)), coefficients(p)) * np.where(square > 0, 1.0, 0.5)


# Cases --------------------------------------------------------------------------------------

CASE_1 = RotorPendulum()
CASE_2 = RotorPendulum(platform_stiffness=65969.0, rod_stiffness=1053.0)
CASE_3 = CASE_2.replace(installation_angle=np.pi / 2)
RELATIVE = CASE_2.replace(motor_placement="relative")
CONSERVATIVE = unforced(CASE_2).replace(platform_damping=0.0, rod_damping=0.0)
FREE = CONSERVATIVE.replace(platform_stiffness=0.0)
SPINNING = {
    "x": 0.01,
    "phi_1": 0.3,
    "phi_2": -0.8,
    "phi_3": 0.2,
    "x_dot": 0.5,
    "phi_1_dot": 40.0,
    "phi_2_dot": 30.0,
    "phi_3_dot": -2.0,
}
AT_SPEED = {"phi_1_dot": 153.8, "phi_2_dot": 153.8}


def _case(
    name: str, p: RotorPendulum, state: dict[str, float], horizon: float, *kinds: str
) -> Case:
    return Case("rotor_pendulum", name, p, state, horizon, kinds)


def _settling(name: str, p: RotorPendulum, phi_1: float, horizon: float) -> Case:
    start = _case(name, p, {"phi_1": phi_1, **AT_SPEED}, horizon, "stability")
    return replace(start, watch="outcome", methods="best")


CASES = (
    replace(_case("case_1_startup", CASE_1, {}, 1.0, "algebra", "trajectory"), methods="best"),
    _case("case_2_startup", CASE_2, {}, 1.0, "algebra", "trajectory", "order"),
    replace(
        _case("case_3_startup", CASE_3, {}, 1.0, "algebra", "trajectory", "order"), methods="best"
    ),
    replace(_case("relative_motor", RELATIVE, {}, 0.25, "algebra", "trajectory"), methods="best"),
    _case("conservative", CONSERVATIVE, SPINNING, 0.2, "energy"),
    replace(_case("free_platform", FREE, SPINNING, 0.2, "energy"), methods="best"),
    replace(_case("modes_at_rest", CASE_1, {}, 0.5, "frequency"), about="rest"),
    replace(_case("modes_at_speed", CASE_1, {}, 0.5, "frequency"), about="synchronous"),
    replace(_case("case_1_synchronous", CASE_1, {}, 0.5, "stability"), methods="best"),
    _case("case_2_synchronous", CASE_2, {}, 0.5, "stability"),
    _settling("case_2_settles", CASE_2, 1.06, 5.5),
    replace(_settling("case_1_antiphase_settles", CASE_1, -2.13, 10.5), full_only=True),
)
"""The last two start one radian off the stable phase difference, 0.064 and -3.129 rad, with
the rotors at speed; they last a little longer than `outcome` must watch them. No case of
section 5.2 is watched from rest: in case 1 both rotors start beside the unstable phase."""

SCENE = Scene(
    name="rotor_pendulum",
    title="synchronising rotors on a platform and a pendulum rod",
    paper=Paper(
        "P. Fang, Y. Hou, Y. Nan, L. Yu",
        "Study of synchronization for a rotor-pendulum system with Poincare method",
        "Journal of Vibroengineering 17(5), jvejournals.com/article/15915",
        2015,
        "",  # the journal gave none then
    ),
    parameters=RotorPendulum,
    coordinates=("x", "phi_1", "phi_2", "phi_3"),
    units={
        "x": "m",
        "phi_1": "rad",
        "phi_2": "rad",
        "phi_3": "rad",
        "x_dot": "m/s",
        "phi_1_dot": "rad/s",
        "phi_2_dot": "rad/s",
        "phi_3_dot": "rad/s",
    },
    coefficients=coefficients,
    mass_matrix=mass_matrix,
    forces=forces,
    accelerations=accelerations,
    damping_matrix=damping_matrix,
    energy=energy,
    powers=powers,
    equilibria={"synchronous": lambda p: {}, "rest": lambda p: {}},
    held={"synchronous": ("phi_1", "phi_2")},
    turning={"phi_1": 1, "phi_2": 1},
    section="phi_1",
    period=period,
    orbit_guesses=orbit_guesses,
    orbit_quantities=orbit_quantities,
    orbit_units=ORBIT_UNITS,
    unforced=unforced,
    invariants=invariants,
    outcome=outcome,
    cases=CASES,
)

REDUCED = replace(
    SCENE,
    title="the same, equations (11): B -> beta after deriving",
    mass_matrix=lambda q, c, xp=np: _mass_matrix(q, c.beta, c, xp),
    forces=lambda u, q, v, c, xp=np: _forces(q, v, c.beta, c, xp),
    accelerations=lambda u, q, v, c, xp=np: _accelerations(q, v, c.beta, c, xp),
)
"""The paper's (11), the sign in its fourth line corrected. Its energy is that of the exact
equations, which it does not conserve; no other quadratic form of these M is conserved either."""

SCENE = replace(SCENE, variants={"reduced": REDUCED})

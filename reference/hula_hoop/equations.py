r"""hula_hoop: a sprung main mass with a free mass on a rod hinged to it.

::

      |\/\/\/|  k          /  m, I   y_f = y + R sin(theta)
    --|      |----[ M ]---o------    x_f =     R cos(theta)
      |=[ ]==|  c    \    theta from the x axis, damped by c_m
                      ---> y, driven by F cos(omega t)

Source: Lu, Wang, Sung, Chao (2011), J. Vib. Acoust. 133, 014501, equations (1)-(8).
The x axis is perpendicular to the slide: at theta = 0 the rod stands across it, at
theta = pi/2 it is aligned with it.

The paper has no gravity. A gravity g, 0 by default, has the potential
``-(M + m) g_y y - m R (g_x cos(theta) + g_y sin(theta))``: g_y acts along the slide, g_x across it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ..errors import NoOrbitError
from ..parameters import BoundarySearch, Parameters, gravity, quantity
from ..scene import (
    Array,
    Paper,
    PeriodicOrbit,
    Scene,
    case_maker,
    with_placements,
    with_rates,
)


@dataclass(frozen=True)
class HulaHoop(Parameters):
    """Parameters of `hula_hoop` (SI units); defaults from table 1 of the paper.

    The two damping entries of table 1 are read as the nondimensional rho and zeta_m of
    equations (7), (8): no other reading locks into rotation at 3 Hz and 60 N.
    """

    main_mass: float = quantity(0.45, "M", "kg", "table 1", "sprung main mass")
    free_mass: float = quantity(0.045, "m", "kg", "table 1", "free mass at the rod's end")
    rod_length: float = quantity(0.05, "R_m", "m", "table 1", "hinge to free mass")
    stiffness: float = quantity(1000.0, "k", "N/m", "table 1", "spring of the main mass")
    damping_ratio: float = quantity(
        0.1,
        "rho",
        "1",
        "table 1, (7)",
        "c / (2 (M + m) omega_n), omega_n = sqrt(k / (M + m))",
        "non-negative",
    )
    hinge_damping_ratio: float = quantity(
        0.01, "zeta_m", "1", "table 1, (8)", "c_m / (m R_m^2 omega_n)", "non-negative"
    )
    inertia_ratio: float = quantity(
        0.0, "I_eq", "1", "(8)", "I / (m R_m^2); 9 pi^2/32 - 1 for the plate", "non-negative"
    )
    force_amplitude: float = quantity(
        60.0, "F", "N", "section 5.1", "amplitude of the force on M", "non-negative"
    )
    force_frequency: float = quantity(3.0, "omega / 2 pi", "Hz", "section 5.1", "of the force")
    gravity_x: float = gravity("x", "across the slide")
    gravity_y: float = gravity("y", "along the slide")

    @property
    def omega_n(self) -> Any:
        """Natural frequency sqrt(k / (M + m)) [rad/s]."""
        return np.sqrt(self.stiffness / (self.main_mass + self.free_mass))


class Coefficients(NamedTuple):
    """Coefficients of (5), (6) in SI units."""

    mass: Any
    coupling: Any
    inertia: Any
    stiffness: Any
    damping: Any
    hinge_damping: Any
    force: Any
    omega: Any
    determinant: Any
    weight: Any
    moment_x: Any
    moment_y: Any


def coefficients(p: HulaHoop) -> Coefficients:
    """Coefficients of (5), (6): M + m, m R, m R^2 + I, k, c, c_m, F, omega, det M(theta = 0).

    And the weights (M + m) g_y, m R g_x, m R g_y.

    The determinant is formed without subtracting, so that it keeps its digits where the
    free mass is far heavier than the main mass.
    """
    mass = p.main_mass + p.free_mass
    moment = p.free_mass * p.rod_length**2
    return Coefficients(
        mass=mass,
        coupling=p.free_mass * p.rod_length,
        inertia=moment * (1 + p.inertia_ratio),
        stiffness=p.stiffness,
        damping=2 * p.damping_ratio * mass * p.omega_n,
        hinge_damping=p.hinge_damping_ratio * moment * p.omega_n,
        force=p.force_amplitude,
        omega=2 * np.pi * p.force_frequency,
        determinant=moment * (p.main_mass + mass * p.inertia_ratio),
        weight=mass * p.gravity_y,
        moment_x=p.free_mass * p.rod_length * p.gravity_x,
        moment_y=p.free_mass * p.rod_length * p.gravity_y,
    )


def drive(t: Any, c: Coefficients, xp: Any = np) -> Any:
    """Normalised force cos(omega t)."""
    return xp.cos(c.omega * t)


def mass_matrix(q: Any, c: Coefficients, xp: Any = np) -> list[list[Any]]:
    """Mass matrix of (5), (6) for q = (y, theta)."""
    off_diagonal = c.coupling * xp.cos(q[1])
    return [[c.mass, off_diagonal], [off_diagonal, c.inertia]]


def forces(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> list[Any]:
    """Right-hand side of ``M(q) a = f``, equations (5), (6)."""
    cos, sin = xp.cos(q[1]), xp.sin(q[1])
    swing = c.coupling * sin * v[1] * v[1]
    return [
        c.force * u - c.damping * v[0] - c.stiffness * q[0] + swing + c.weight,
        -c.hinge_damping * v[1] + (c.moment_y * cos - c.moment_x * sin),
    ]


def accelerations(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> list[Any]:
    """Equations (5), (6) solved for the accelerations."""
    coupling_cos, coupling_sin = c.coupling * xp.cos(q[1]), c.coupling * xp.sin(q[1])
    f_y, f_theta = forces(u, q, v, c, xp)
    determinant = c.determinant + coupling_sin * coupling_sin
    return [
        (c.inertia * f_y - coupling_cos * f_theta) / determinant,
        (c.mass * f_theta - coupling_cos * f_y) / determinant,
    ]


def damping_matrix(c: Coefficients) -> Array:
    """diag(c, c_m)."""
    return np.diag([c.damping, c.hinge_damping])


def energy(q: Any, v: Any, c: Coefficients) -> Any:
    """Kinetic energy (1) plus potential energy (2) and that of gravity [J]."""
    kinetic = c.mass * v[0] ** 2 + c.inertia * v[1] ** 2
    inner = (kinetic + c.stiffness * q[0] ** 2) / 2 + c.coupling * v[0] * v[1] * np.cos(q[1])
    return inner - (c.weight * q[0] + c.moment_x * np.cos(q[1]) + c.moment_y * np.sin(q[1]))


def powers(u: Any, q: Any, v: Any, c: Coefficients) -> dict[str, Any]:
    """Powers [W] of the force, the damper and the hinge friction."""
    return {
        "force": c.force * u * v[0],
        "damper": -c.damping * v[0] ** 2,
        "hinge": -c.hinge_damping * v[1] ** 2,
    }


def period(p: HulaHoop) -> Any:
    """Forcing period [s]."""
    return 1 / np.asarray(p.force_frequency)


def orbit_guesses(p: HulaHoop) -> list[Array]:
    """Rotations to zeroth order in u_1, at t = 0: theta = omega t + theta_0, y harmonic.

    The mean torque balance gives two phases theta_0; where it has no solution the
    nearest phase stands for both.

    Returns
    -------
    list of arrays of shape (4, ...)
    """
    c = coefficients(p)
    impedance = c.stiffness - c.mass * c.omega**2 + 1j * c.damping * c.omega
    impedance = np.where(impedance == 0, 1e-2 * c.stiffness, impedance)  # undamped resonance
    inertial = c.coupling * c.omega**2
    cosine = 2 * c.hinge_damping / (c.coupling * c.omega) - np.imag(inertial / impedance)
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = np.nan_to_num(cosine * abs(impedance) / c.force, nan=0.0)
    half_angle = np.arccos(np.clip(cosine, -1, 1))
    guesses = []
    for sign in (1, -1):
        theta = sign * half_angle - np.angle(impedance)
        response = (c.force - 1j * inertial * np.exp(1j * theta)) / impedance
        state = (response.real, theta % (2 * np.pi), -c.omega * response.imag, c.omega)
        guesses.append(np.array(np.broadcast_arrays(*state), dtype=float))
    return guesses


def rest(name: str, p: HulaHoop) -> dict[str, float]:
    """Return the state of rest of this name: the rod across the slide, aligned, hanging, inverted.

    Raises
    ------
    NoOrbitError
        If gravity turns the rod from there, or there is none in which it could hang.
    """
    size = float(np.hypot(p.gravity_x, p.gravity_y))
    y = p.gravity_y / p.omega_n**2 if p.gravity_y else 0.0
    if name in ACROSS_AND_ALIGNED:
        theta = ACROSS_AND_ALIGNED[name]
        turning = p.gravity_y * np.cos(theta) - p.gravity_x * np.sin(theta)
        if abs(turning) > 1e-15 * size:
            raise NoOrbitError(f"gravity turns the rod from {name}; it rests hanging, or inverted")
    elif size:
        theta = float(np.arctan2(p.gravity_y, p.gravity_x))
        theta += np.pi if name == "inverted" else 0.0
    else:
        raise NoOrbitError("without gravity the rod of hula_hoop hangs nowhere")
    return {key: value for key, value in (("theta", theta), ("y", float(y))) if value}


ACROSS_AND_ALIGNED = {"rod_across": 0.0, "rod_aligned": np.pi / 2}
EQUILIBRIA = (*ACROSS_AND_ALIGNED, "hanging", "inverted")

SEMICIRCLE = 9 * np.pi**2 / 32 - 1
"""Inertia ratio I_eq of the semicircular plate, below (8)."""

PLATE = HulaHoop(inertia_ratio=SEMICIRCLE)
UNFORCED = HulaHoop(force_amplitude=0.0)
CONSERVATIVE = UNFORCED.replace(damping_ratio=0.0, hinge_damping_ratio=0.0)
WEIGHED = PLATE.replace(gravity_x=7.0, gravity_y=-5.0)
SWINGING = CONSERVATIVE.replace(inertia_ratio=SEMICIRCLE, gravity_x=7.0, gravity_y=-5.0)
SPINNING = {"y": 0.01, "theta": 0.3, "theta_dot": 18.0}
ALIGNED = {"theta": np.pi / 2}


SYMMETRIC = PLATE.replace(force_amplitude=95.0, force_frequency=5.0)
FREE_RUN = ("algebra", "trajectory", "order")
SLOW = HulaHoop(stiffness=100.0, force_amplitude=10.0, force_frequency=1.0)
FAST = PLATE.replace(force_amplitude=100.0, force_frequency=8.0)

case = case_maker("hula_hoop")

CASES = (
    case("point_mass_3hz_60n", HulaHoop(), {}, 1.0, "algebra", "trajectory", "stability"),
    case("semicircle_3hz_60n", PLATE, {}, 1.0, "algebra", "trajectory", "stability"),
    case(
        "point_mass_3hz_100n", HulaHoop(force_amplitude=100.0), {}, 0.5, "stability", methods="best"
    ),
    case(
        "loss_of_symmetry_5hz",
        SYMMETRIC,
        {},
        0.5,
        "stability",
        boundary=BoundarySearch("period_doubling", "force_amplitude"),
    ),
    case("spinning_3hz_60n", HulaHoop(), SPINNING, 0.5, "trajectory", "order"),
    case("spinning_unforced", UNFORCED, SPINNING, 0.5, "trajectory", "order"),
    case("rod_aligned", HulaHoop(), ALIGNED, 1.0, "trajectory"),
    case("free_undamped", CONSERVATIVE, SPINNING, 1.0, "trajectory", "energy"),
    case("heavy_free_mass", HulaHoop(free_mass=0.45), SPINNING, 0.3, *FREE_RUN, full_only=True),
    case("soft_spring_1hz_10n", SLOW, SPINNING, 1.0, *FREE_RUN, full_only=True),
    case("plate_8hz_100n", FAST, SPINNING, 0.3, *FREE_RUN, full_only=True),
    case(
        "overdamped_hinge",
        HulaHoop(hinge_damping_ratio=2.0),
        SPINNING,
        0.3,
        *FREE_RUN,
        full_only=True,
    ),
    case(
        "semicircle_3hz_30n",
        PLATE.replace(force_amplitude=30.0),
        {},
        0.5,
        "stability",
        full_only=True,
    ),
    case(
        "point_mass_3hz_80n", HulaHoop(force_amplitude=80.0), {}, 0.5, "stability", full_only=True
    ),
    case("weighed", WEIGHED, SPINNING, 0.25, "algebra", "trajectory", methods="best"),
    case("swinging", SWINGING, {"theta": 1.0}, 0.5, "energy", methods="best"),
    case("hanging", SWINGING, {}, 0.5, "frequency", about="hanging"),
    case("rest_rod_across", UNFORCED, {}, 0.5, "frequency"),
    case("rest_rod_aligned", UNFORCED, ALIGNED, 0.5, "frequency"),
)
"""`rod_aligned` starts on the invariant line theta = pi/2, where y is linear. At 5 Hz the rotation
of the plate loses its symmetry at 95.1 N, by a period doubling of the map over half a period."""

SCENE = Scene(
    name="hula_hoop",
    title="motion transformer mimicking a hula hoop",
    paper=Paper(
        "C. X. Lu, C. C. Wang, C. K. Sung, P. C. P. Chao",
        "Dynamic Analysis of a Motion Transformer Mimicking a Hula Hoop",
        "Journal of Vibration and Acoustics 133, 014501",
        2011,
        "10.1115/1.4001839",
    ),
    parameters=HulaHoop,
    coordinates=("y", "theta"),
    units=with_rates(y="m", theta="rad"),
    coefficients=coefficients,
    drive=drive,
    drive_form="force on y: F cos(omega t), largest at t = 0, whenever a run starts",
    mass_matrix=mass_matrix,
    forces=forces,
    accelerations=accelerations,
    damping_matrix=damping_matrix,
    energy=energy,
    powers=powers,
    equilibria={name: partial(rest, name) for name in EQUILIBRIA},
    rotations_per_period={"theta": 1},
    period=period,
    orbit=PeriodicOrbit(orbit_guesses, mirror=("y",)),
    unforced=lambda p: p.replace(force_amplitude=0.0),
    cases=CASES,
    placed=with_placements(CASES[1], "algebra", "trajectory"),  # the plate, whose inertia counts
)

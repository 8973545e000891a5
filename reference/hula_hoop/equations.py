r"""hula_hoop: a sprung main mass with a free mass on a rod hinged to it; no gravity.

::

      |\/\/\/|  k          /  m, I   y_f = y + R sin(theta)
    --|      |----[ M ]---o------    x_f =     R cos(theta)
      |=[ ]==|  c    \    theta from the x axis, damped by c_m
                      ---> y, driven by F cos(omega t)

Source: Lu, Wang, Sung, Chao (2011), J. Vib. Acoust. 133, 014501, equations (1)-(8).
The x axis is perpendicular to the slide: at theta = 0 the rod stands across it, at
theta = pi/2 it is aligned with it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ..parameters import Parameters, quantity
from ..scene import Array, Case, Paper, PeriodicOrbit, Scene, with_placements, with_rates


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
        0.1, "rho", "1", "table 1, (7)", "c / (2 (M + m) omega_n)", "non-negative"
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


def coefficients(p: HulaHoop) -> Coefficients:
    """Coefficients of (5), (6): M + m, m R, m R^2 + I, k, c, c_m, F, omega, det M(theta = 0).

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
    return _forces(u, q, v, c, c.coupling * xp.sin(q[1]))


def _forces(u: Any, q: Any, v: Any, c: Coefficients, coupling_sin: Any) -> list[Any]:
    return [
        c.force * u - c.damping * v[0] - c.stiffness * q[0] + coupling_sin * v[1] * v[1],
        -c.hinge_damping * v[1],
    ]


def accelerations(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> list[Any]:
    """Equations (5), (6) solved for the accelerations."""
    coupling_cos, coupling_sin = c.coupling * xp.cos(q[1]), c.coupling * xp.sin(q[1])
    f_y, f_theta = _forces(u, q, v, c, coupling_sin)
    determinant = c.determinant + coupling_sin * coupling_sin
    return [
        (c.inertia * f_y - coupling_cos * f_theta) / determinant,
        (c.mass * f_theta - coupling_cos * f_y) / determinant,
    ]


def damping_matrix(c: Coefficients) -> Array:
    """diag(c, c_m)."""
    return np.diag([c.damping, c.hinge_damping])


def energy(q: Any, v: Any, c: Coefficients) -> Any:
    """Kinetic energy (1) plus potential energy (2) [J]."""
    kinetic = c.mass * v[0] ** 2 + c.inertia * v[1] ** 2
    return (kinetic + c.stiffness * q[0] ** 2) / 2 + c.coupling * v[0] * v[1] * np.cos(q[1])


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


SEMICIRCLE = 9 * np.pi**2 / 32 - 1
"""Inertia ratio I_eq of the semicircular plate, below (8)."""

PLATE = HulaHoop(inertia_ratio=SEMICIRCLE)
UNFORCED = HulaHoop(force_amplitude=0.0)
CONSERVATIVE = UNFORCED.replace(damping_ratio=0.0, hinge_damping_ratio=0.0)
SPINNING = {"y": 0.01, "theta": 0.3, "theta_dot": 18.0}
ALIGNED = {"theta": np.pi / 2}


def _case(name: str, p: HulaHoop, state: dict[str, float], horizon: float, *kinds: str) -> Case:
    return Case("hula_hoop", name, p, state, horizon, kinds)


def _full(name: str, p: HulaHoop, state: dict[str, float], horizon: float, *kinds: str) -> Case:
    return replace(_case(name, p, state, horizon, *kinds), full_only=True)


FREE_RUN = ("algebra", "trajectory", "order")
SLOW = HulaHoop(stiffness=100.0, force_amplitude=10.0, force_frequency=1.0)
FAST = PLATE.replace(force_amplitude=100.0, force_frequency=8.0)

CASES = (
    _case("point_mass_3hz_60n", HulaHoop(), {}, 1.0, "algebra", "trajectory", "stability"),
    _case("semicircle_3hz_60n", PLATE, {}, 1.0, "algebra", "trajectory", "stability"),
    replace(
        _case("point_mass_3hz_100n", HulaHoop(force_amplitude=100.0), {}, 0.5, "stability"),
        methods="best",
    ),
    _case("spinning_3hz_60n", HulaHoop(), SPINNING, 0.5, "trajectory", "order"),
    _case("spinning_unforced", UNFORCED, SPINNING, 0.5, "trajectory", "order"),
    _case("rod_aligned", HulaHoop(), ALIGNED, 1.0, "trajectory"),
    _case("free_undamped", CONSERVATIVE, SPINNING, 1.0, "trajectory", "energy"),
    _full("heavy_free_mass", HulaHoop(free_mass=0.45), SPINNING, 0.3, *FREE_RUN),
    _full("soft_spring_1hz_10n", SLOW, SPINNING, 1.0, *FREE_RUN),
    _full("plate_8hz_100n", FAST, SPINNING, 0.3, *FREE_RUN),
    _full("overdamped_hinge", HulaHoop(hinge_damping_ratio=2.0), SPINNING, 0.3, *FREE_RUN),
    _full("semicircle_3hz_30n", PLATE.replace(force_amplitude=30.0), {}, 0.5, "stability"),
    _full("point_mass_3hz_80n", HulaHoop(force_amplitude=80.0), {}, 0.5, "stability"),
    _case("rest_rod_across", UNFORCED, {}, 0.5, "frequency"),
    _case("rest_rod_aligned", UNFORCED, ALIGNED, 0.5, "frequency"),
)
"""`rod_aligned` starts on the invariant line theta = pi/2, where y is linear."""

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
    equilibria={"rod_across": lambda p: {}, "rod_aligned": lambda p: {"theta": np.pi / 2}},
    rotations_per_period={"theta": 1},
    period=period,
    orbit=PeriodicOrbit(orbit_guesses, mirror=("y",)),
    unforced=lambda p: p.replace(force_amplitude=0.0),
    cases=CASES,
    placed=with_placements(CASES[1], "algebra", "trajectory"),  # the plate, whose inertia counts
)

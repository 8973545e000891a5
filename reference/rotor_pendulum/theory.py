r"""Phase difference of the rotors of `rotor_pendulum`, equations (15)-(36) of the paper.

With uniformly turning rotors, small angles and no dampers, x and phi_3 follow (16) in steady
vibration, (21) with the coupling coefficients (22). The mean torque of that vibration on
each rotor, (26), must vanish: (30); and it must push a disturbed phase back: (36).

What is misprinted, and what follows from it:

- in mu_1 of (22), n_x and n_phi are swapped. The right one, ``sigma n_x^2 (n_phi^2 - 1)/N``,
  gives the paper's own numbers, so that it is a slip of the pen only;
- with it, (30) becomes ``kappa sin(alpha) + sin(beta) cos(beta) cos(alpha) = 0`` with
  ``kappa = cos^2(beta) - 1/n_phi^2``, times ``1/N``, whose sign (36) needs. Hence one stable
  and one unstable root, at every beta: (31) only divides by cos(beta), and ``beta = pi/2``
  is no critical point of (30). Where the rod is upright, synchronism is lost for another
  reason, the power that f_phi takes: see `equations.balanced_phase`;
- the arccot of (33) gives the stable root or the one opposite, as the branch will have it;
- case 1 of section 5.2 has 3.013 rad, which is the modulus: the root is -3.013 rad.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .equations import RotorPendulum, operating_speed
from .phase import wrapped

LEVEL = 1e-15
"""Sine of a multiple of pi, to rounding, as an installation angle may be."""


class Ratios(NamedTuple):
    """Dimensionless parameters (15), (19); each an array of broadcast shape.

    Attributes
    ----------
    n_x, n_phi : array
        Rotors' speed over the natural frequencies of platform and rod, greater than 0;
        infinite where there is no spring.
    sigma : array
        1/(1 + m_3/m); the defaults of `RotorPendulum` have 1/6, printed 0.17.
    r_m : array
        m/M with M all the mass that moves with x: 2/114, printed 0.02.
    beta : array
        Installation angle [rad].
    """

    n_x: Any
    n_phi: Any
    sigma: Any = 1 / 6
    r_m: Any = 2 / 114
    beta: Any = np.pi / 6


def ratios(p: RotorPendulum, speed: ArrayLike | None = None) -> Ratios:
    """Dimensionless parameters from masses, lengths and stiffnesses.

    The frequency ratios printed in section 5.2 do not belong to the stiffnesses printed
    beside them: they take 100 kg or 114 kg for M, and 9.9 or 1.08 kg m^2 for the rod.

    Parameters
    ----------
    p : RotorPendulum
    speed : array_like, optional
        Of the rotors [rad/s], by default `operating_speed`.

    Raises
    ------
    ParameterError
        If there is gravity.
    """
    p.refuse_gravity("the paper's theory of rotor_pendulum")
    speed = operating_speed(p) if speed is None else np.asarray(speed)
    end_mass = p.rotor_mass + p.rod_mass
    mass = p.platform_mass + end_mass + p.rotor_mass
    with np.errstate(divide="ignore"):
        return Ratios(
            n_x=speed * np.sqrt(np.divide(mass, p.platform_stiffness)),
            n_phi=speed * p.rod_length * np.sqrt(np.divide(end_mass, p.rod_stiffness)),
            sigma=p.rotor_mass / end_mass,
            r_m=p.rotor_mass / mass,
            beta=p.installation_angle,
        )


class Coupling(NamedTuple):
    """Coupling coefficients (22)."""

    mu_1: Any
    mu_2: Any
    mu_3: Any
    mu_4: Any


def coupling_coefficients(n: Ratios, as_printed: bool = False) -> Coupling:
    """Coupling coefficients (22); not finite where N = 0, at resonance.

    Parameters
    ----------
    n : Ratios
        Finite n_x and n_phi.
    as_printed : bool
        Take mu_1 with n_x and n_phi swapped.
    """
    x, phi, sin = np.square(n.n_x), np.square(n.n_phi), np.sin(n.beta)
    with np.errstate(divide="ignore", invalid="ignore"):
        over_n = np.divide(1, n.sigma * (1 - x) * (1 - phi) - n.r_m * x * phi * sin**2)
        mu_4 = n.sigma * (x - 1) * phi * over_n
        return Coupling(
            mu_1=mu_4 if as_printed else n.sigma * x * (phi - 1) * over_n,
            mu_2=n.r_m * x * phi * sin * over_n,
            mu_3=n.sigma * x * phi * sin * over_n,
            mu_4=mu_4,
        )


def balance(n: Ratios, alpha: ArrayLike, as_printed: bool = False) -> Any:
    """Left-hand side of (30), zero at a synchronous phase difference alpha [rad]."""
    mu = coupling_coefficients(n, as_printed)
    return mu.mu_1 * np.sin(alpha) + mu.mu_3 * np.cos(alpha + np.asarray(n.beta))


def stability(n: Ratios, alpha: ArrayLike, as_printed: bool = False) -> Any:
    """Left-hand side of (36), the derivative of (30): positive where alpha [rad] is stable."""
    mu = coupling_coefficients(n, as_printed)
    return mu.mu_1 * np.cos(alpha) - mu.mu_3 * np.sin(alpha + np.asarray(n.beta))


def stable_phase_difference(n: Ratios, as_printed: bool = False) -> Any:
    """Return the one root alpha of (30) that satisfies (36), in (-pi, pi] [rad].

    In closed form, for every n_x, n_phi (infinite too) and beta. NaN only at resonance,
    N = 0, across which the phase jumps by pi.

    Parameters
    ----------
    n : Ratios
    as_printed : bool
        Take mu_1 with n_x and n_phi swapped (n_x and n_phi finite).

    Returns
    -------
    array of broadcast shape
    """
    if as_printed:
        mu = coupling_coefficients(n, as_printed)
        cosine, sine = mu.mu_1 - mu.mu_3 * np.sin(n.beta), -mu.mu_3 * np.cos(n.beta)
        return wrapped(np.arctan2(sine, cosine))
    x, phi = np.divide(1, np.square(n.n_x)), np.divide(1, np.square(n.n_phi))
    sin, cos = np.sin(n.beta), np.cos(n.beta)
    level = abs(sin) < LEVEL  # then N has the factor of cosine: x alone decides
    resonance = np.where(level, x - 1, n.sigma * (x - 1) * (phi - 1) - n.r_m * sin**2)
    cosine = np.where(level, -1.0, (1 - phi) - sin**2)
    sign = np.where(resonance == 0, np.nan, np.sign(resonance))
    return wrapped(np.arctan2(-sign * sin * cos, sign * cosine))


def printed_phase_difference(n: Ratios) -> Any:
    """(33) to the letter, with arccot in (0, pi) and mu_1 as printed; NaN where cos(beta) = 0."""
    mu = coupling_coefficients(n, as_printed=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        cotangent = (mu.mu_3 * np.sin(n.beta) - mu.mu_1) / (mu.mu_3 * np.cos(n.beta))
        return np.arctan2(1, cotangent)


def coupling_amplitude(p: RotorPendulum, speed: ArrayLike | None = None) -> Any:
    """Amplitude W of the torque (34) that couples the rotors [N m].

    ``P_1 - P_2`` is minus ``W sin(alpha - alpha_0)`` with the stable alpha_0, besides the torques
    of motors and bearings at different speeds.
    """
    speed = operating_speed(p) if speed is None else np.asarray(speed)
    mu = coupling_coefficients(ratios(p, speed))
    beta = p.installation_angle
    size = np.hypot(mu.mu_1 - mu.mu_3 * np.sin(beta), mu.mu_3 * np.cos(beta))
    mass = p.platform_mass + p.rod_mass + 2 * p.rotor_mass
    return p.rotor_mass**2 / mass * (p.eccentricity * speed) ** 2 * size

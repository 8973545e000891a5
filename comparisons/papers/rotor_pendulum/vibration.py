"""Measures of the rotor_pendulum paper's equations (12) and (15)-(29): the vibration, its torques.

Where speeds, frequencies and stiffnesses do not matter omega is 1, and lengths are over l.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ....reference.rotor_pendulum import CASE_1, CASE_2, theory
from ....reference.rotor_pendulum.equations import coefficients
from ....reference.scene import Array
from ..ledger import REPRODUCED, LedgerRow, Numbers, below, holds, statement
from ..session import Session
from .derivation import lattice
from .results import PRINTED_RATIOS

IDENTITY = 1e-9
"""Relative residual below which an identity holds."""

Residual = Callable[[bool], float]
"""Of an identity, relative, with a formula as printed (true) or corrected."""

TIMES = 2 * np.pi * np.arange(64) / 64
"""Over a turn, times omega."""
STARTS = 0.9, 0.2
"""alpha_1 and alpha_2 of (23) [rad]."""


def lines_of_16(
    x: Any, swing: Any, rates: tuple[Any, Any], pushes: tuple[Any, Any], n: theory.Ratios
) -> Array:
    """Return (16), all to the left, with x'' and phi_3'' (``rates``), and f_1, f_2 (``pushes``)."""
    (a_x, a_3), (f_1, f_2), sin = rates, pushes, np.sin(n.beta)
    return np.array(
        [
            a_x + x / n.n_x**2 - f_1 - n.r_m * sin / n.sigma * a_3,
            a_3 + swing / n.n_phi**2 - sin * a_x + f_2,
        ]
    )


def steady_equations(session: Session) -> Numbers:
    """Return by how much (16) misses the lines 1 and 4 of (12), and (17) is not of (16).

    With rotors that turn uniformly, no dampers, and random x, phi_3 and accelerations; (17) with
    exponentials, whose accelerations are s^2 times themselves. Relative to the largest terms.
    """
    c, speed, random = coefficients(CASE_2), 153.0, np.random.default_rng(16)
    x, swing, a_x, a_3, phi_1, phi_2 = random.normal(size=6)
    arm, sin, length = c.end_mass * c.length, np.sin(c.beta), c.length
    pull, n = c.unbalance * speed**2, theory.ratios(CASE_2, speed)
    lines = (
        (c.mass * a_x, c.stiffness * x, pull * np.cos(phi_1), -pull * np.cos(phi_2),
         -arm * a_3 * sin),
        (arm * length * a_3, c.rod_stiffness * swing, -arm * a_x * sin,
         -pull * length * np.sin(phi_2 - c.beta)),
    )  # fmt: skip
    r_l = c.eccentricity / length
    f_1 = c.rotor / c.mass * r_l * (np.cos(phi_2) - np.cos(phi_1))
    f_2 = -c.rotor / c.end_mass * r_l * np.sin(phi_2 - c.beta)
    rates = a_x / (length * speed**2), a_3 / speed**2
    in_16 = lines_of_16(x / length, swing, rates, (f_1, f_2), n)
    scales = c.mass * length * speed**2, arm * length * speed**2
    errors = [
        abs(sum(terms) - scale * line) / max(map(abs, terms))
        for terms, scale, line in zip(lines, scales, in_16, strict=True)
    ]
    s, x_s, phi_s, in_f = 0.7j, 0.4 + 0.1j, -0.2 + 0.3j, (0.5j - 1, 0.8 + 0.2j)
    off = lines_of_16(x_s, phi_s, (s**2 * x_s, s**2 * phi_s), in_f, n)
    off -= [sum(terms) for terms in terms_of_17(s, x_s, phi_s, in_f, n)]
    return {"errors": errors, "transform": np.max(np.abs(off))}


def terms_of_17(
    s: complex, x: Any, phi: Any, pushes: tuple[Any, Any], n: theory.Ratios
) -> tuple[tuple[Any, ...], ...]:
    """Return the terms of both lines of (17), all to the left."""
    sin = np.sin(n.beta)
    return (
        ((s**2 + 1 / n.n_x**2) * x, -pushes[0], -n.r_m * s**2 * sin / n.sigma * phi),
        ((s**2 + 1 / n.n_phi**2) * phi, -(s**2) * sin * x, pushes[1]),
    )


def equation_18(factor: float) -> float:
    """Return the largest residual of (18) in both lines of (17), relative to their largest terms.

    ``factor`` stands before r_m s^2 F_2 sin(beta), printed eta_21 + eta_31.
    """
    s, n, (f_1, f_2) = 0.7j, theory.Ratios(0.77, 1.25, beta=0.6), (0.4 + 0.1j, -0.2 + 0.3j)
    sin, w_x, w_phi = np.sin(n.beta), 1 / n.n_x, 1 / n.n_phi
    g = (s**2 + w_x**2) * (s**2 + w_phi**2) - n.r_m * s**4 * sin**2 / n.sigma
    x = ((s**2 + w_phi**2) * f_1 - factor * n.r_m * s**2 * f_2 * sin) / g
    phi = (s**2 * f_1 * sin - (s**2 + w_x**2) * f_2) / g
    lines = terms_of_17(s, x, phi, (f_1, f_2), n)
    return max(float(abs(sum(terms)) / max(map(abs, terms))) for terms in lines)


def mass_ratios_of_18(session: Session) -> Numbers:
    """Return what (18) leaves with eta_21 = m_2/m_1 and eta_31 = m_3/m_1, and their factor."""
    eta_21, eta_31 = 1.0, float(CASE_1.rod_mass / CASE_1.rotor_mass)
    factor = eta_21 + eta_31
    return {"factor": factor, "error": equation_18(factor)}


def turning() -> tuple[Array, Array]:
    """Return f_1 and f_2 of (15), over r_l, with the rotors of (23) over a turn, at case 2."""
    n, (phi_1, phi_2) = PRINTED_RATIOS[2], (TIMES + start for start in STARTS)
    return n.r_m * (-np.cos(phi_1) + np.cos(phi_2)), -n.sigma * np.sin(phi_2 - n.beta)


def by_20() -> Array:
    """Return x over r and phi_3 over r_l of (20) as printed, at case 2, (2, n)."""
    n, (f_1, f_2) = PRINTED_RATIOS[2], turning()
    x, phi, sin = n.n_x**2, n.n_phi**2, np.sin(n.beta)
    below = n.sigma * (1 - x) * (1 - phi) - n.r_m * x * phi * sin**2
    first = n.sigma * (1 - x) * phi * f_1 + n.r_m * x * phi * f_2 * sin
    return np.array([first, -n.sigma * x * phi * f_1 * sin + n.sigma * (x - 1) * phi * f_2]) / below


def by_24(as_printed: bool) -> Array:
    """Return the same by (24) with (22)."""
    n, mu = PRINTED_RATIOS[2], theory.coupling_coefficients(PRINTED_RATIOS[2], as_printed)
    phi_1, phi_2 = (TIMES + start for start in STARTS)
    wave, other = np.cos(phi_1) - np.cos(phi_2), np.sin(phi_2 - n.beta)
    return np.array(
        [
            mu.mu_1 * n.r_m * wave - mu.mu_2 * n.sigma * other,
            mu.mu_3 * n.r_m * wave - mu.mu_4 * n.sigma * other,
        ]
    )


def by_16() -> Array:
    """Return the steady solution of (16), likewise; its accelerations are minus itself."""
    n, pushes = PRINTED_RATIOS[2], turning()
    columns = [lines_of_16(x, phi, (-x, -phi), (0, 0), n) for x, phi in np.eye(2)]
    right = -lines_of_16(0, 0, (0, 0), pushes, n)
    return np.asarray(np.linalg.solve(np.transpose(columns), right))


def equation_20(as_printed: bool) -> float:
    """Return by how much x of (24) with (22) misses (16), relative to its largest value."""
    steady = by_16()[0]
    return float(np.max(abs(by_24(as_printed)[0] - steady)) / np.max(abs(steady)))


def rod_of_20(session: Session) -> Numbers:
    """Return by how much phi_3 of (24) misses (16), and (24) both lines of (20), as printed."""
    steady, own = by_16()[1], by_24(as_printed=True)
    return {
        "error": float(np.max(abs(own[1] - steady)) / np.max(abs(steady))),
        "apart": float(np.max(abs(by_20() - own) / np.max(abs(own), axis=1, keepdims=True))),
    }


# Mean torques


def mean_torques(n: theory.Ratios, alpha: Any, as_printed: bool) -> tuple[Array, Array]:
    """Return means over a turn of the torques of (21) on both rotors, over m r^2 omega^2.

    At phase differences alpha (...); what is of second order in the rod's swing is left out.
    """
    mu, beta = theory.coupling_coefficients(n, as_printed), np.asarray(n.beta)
    mu_1, mu_2, mu_3, mu_4 = (one[..., None] for one in np.broadcast_arrays(*mu))
    phi_2 = TIMES + STARTS[1]
    phi_1 = TIMES + (STARTS[1] + np.asarray(alpha))[..., None]
    wave, other = np.cos(phi_1) - np.cos(phi_2), np.sin(phi_2 - beta)
    x, phi_3 = (  # accelerations by (21), over r omega^2 and r_l omega^2
        -(first * n.r_m * wave - second * n.sigma * other)
        for first, second in ((mu_1, mu_2), (mu_3, mu_4))
    )
    on_1 = np.mean(-x * np.sin(phi_1), axis=-1)
    on_2 = np.mean(x * np.sin(phi_2) - phi_3 * np.cos(phi_2 - beta), axis=-1)
    return on_1, on_2


def error_of_26(as_printed: bool) -> float:
    """Return the larger error of the two brackets of (26), relative, over phase differences."""
    n, alpha = PRINTED_RATIOS[2], np.linspace(-np.pi, np.pi, 37)
    on_1, on_2 = mean_torques(n, alpha, as_printed)
    mu, beta, sin, cos = theory.coupling_coefficients(n, as_printed), n.beta, np.sin, np.cos
    one = mu.mu_1 * n.r_m * sin(alpha) + mu.mu_2 * n.sigma * cos(alpha + beta)
    two = mu.mu_1 * n.r_m * sin(alpha) + mu.mu_2 * n.sigma * cos(beta)
    two += mu.mu_3 * n.r_m * cos(alpha + beta) - mu.mu_3 * n.r_m * cos(beta)
    left = np.concatenate([on_1 + one / 2, on_2 - two / 2])
    return float(np.max(abs(left)) / np.max(abs(one)))


def equation_26(session: Session) -> Numbers:
    """Return that error with mu_1 as printed and corrected, at case 2's ratios."""
    return {"errors": [error_of_26(as_printed) for as_printed in (True, False)]}


def identity_29(session: Session) -> Numbers:
    """Return by how much mu_3 r_m = mu_2 sigma is missed, relative to it.

    And, at the roots of (30), what is left of both conditions (28), and of the mean torques that
    they are of, over the amplitude; with mu_1 as printed and corrected, over table 2's range.
    """
    n = lattice()
    mu = theory.coupling_coefficients(n)
    left, right = mu.mu_3 * n.r_m, mu.mu_2 * n.sigma
    conditions, torques, few = [], [], (slice(None, None, 23),) * 2
    rough = n._replace(n_x=n.n_x[:, ::23], n_phi=n.n_phi[::23])
    for as_printed in (True, False):
        mu = theory.coupling_coefficients(n, as_printed)
        alpha = theory.stable_phase_difference(n, as_printed)
        own, wave = mu.mu_1 * n.r_m * np.sin(alpha), np.cos(alpha + n.beta)
        rest = (mu.mu_3 * n.r_m - mu.mu_2 * n.sigma) * np.cos(n.beta)
        lines = own + mu.mu_2 * n.sigma * wave, own + mu.mu_3 * n.r_m * wave - rest
        size = n.r_m * np.hypot(mu.mu_1, mu.mu_3)
        conditions.append(np.max(np.abs(lines) / size))
        means = mean_torques(rough, alpha[few], as_printed)
        torques.append(np.max(np.abs(means) / size[few]))
    return {
        "error": np.max(abs(left - right) / abs(right)),
        "conditions": max(conditions),
        "torques": max(torques),
    }


VIBRATION: tuple[LedgerRow, ...] = (
    statement(
        "equations_15_17", "equations (12), (15)-(17)",
        "Equations of the vibration with rotors that turn uniformly, and their transform.",
        REPRODUCED,
        "(16) against the lines 1 and 4 of (12) at a random state: off by {errors:.0e}; (17) "
        "against (16) with exponentials: {transform:.0e}",
        steady_equations,
        judgement=holds(below("errors", IDENTITY), below("transform", IDENTITY)),
    ),
    statement(
        "equation_18", "equations (17), (18)", "Laplace transform of the motion.", REPRODUCED,
        "eta_21 and eta_31 are not defined. With m_2/m_1 and m_3/m_1, as eta of (15) suggests, "
        "their sum is {factor:g} = 1/sigma, and so is eta_21 (1 + eta_31), should a bracket be "
        "lost; then (18) solves both lines of (17) to {error:.0e}",
        mass_ratios_of_18, judgement=holds(below("error", IDENTITY)),
    ),
    statement(
        "rod_of_20", "equations (19)-(24)", "The rod's vibration, by mu_3 and mu_4.",
        REPRODUCED,
        "phi_3 of (24) with (22), over a turn, against the steady solution of (16) with (19), at "
        "case 2: off by {error:.0e}; (20), (21) and (24), x included, are one as printed, to "
        "{apart:.0e}: of x see mu_1",
        rod_of_20, judgement=holds(below("error", IDENTITY), below("apart", IDENTITY)),
    ),
    statement(
        "equation_26", "equations (25), (26)", "Mean torques of the vibration (21) on each rotor.",
        REPRODUCED,
        "its brackets, at alpha = alpha_1 - alpha_2, against averages over a turn, with mu_1 as "
        "printed and corrected: off by {errors:.0e}",
        equation_26, judgement=holds(below("errors", IDENTITY)),
    ),
    statement(
        "identity_29", "equations (28), (29)",
        "The balance conditions of the two rotors are one.",
        REPRODUCED,
        "off by {error:.0e} at most; so the two conditions (28) are one, and vibration passes no "
        "power on where there are no dampers: at the stable phase of (30) they leave "
        "{conditions:.0e} of its amplitude, and the mean torques of (21) {torques:.0e}",
        identity_29,
        judgement=holds(
            below("error", IDENTITY), below("conditions", IDENTITY), below("torques", IDENTITY)
        ),
    ),
)  # fmt: skip

"""Equations (12) and (15)-(29) of the rotor_pendulum paper: the vibration, and its torques.

Where speeds, frequencies and stiffnesses do not matter omega is 1, and lengths are over l.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ....reference.rotor_pendulum import theory
from ....reference.rotor_pendulum.cases import CASE_1
from ..equations import Identities
from ..ledger import REPRODUCED, LedgerRow, Numbers, below, holds, statement
from ..session import Session
from .derivation import lattice
from .results import PRINTED_RATIOS

IDENTITY = 1e-9
"""Relative residual below which an identity holds."""

VIBRATING = """
    phi_1 = t + alpha_1
    phi_2 = t + alpha_2
    wave = cos(phi_1) - cos(phi_2)
    other = sin(phi_2 - beta)
    f_1 = -r_m*wave
    f_2 = -sigma*other
    free_x = 1/n_x**2 - 1
    free_phi = 1/n_phi**2 - 1
    below = free_x*free_phi - r_m*sin(beta)**2/sigma
    x = (f_1*free_phi + r_m*sin(beta)/sigma*f_2)/below
    phi_3 = -(free_x*f_2 + sin(beta)*f_1)/below
    N = sigma*(1 - n_x**2)*(1 - n_phi**2) - r_m*n_x**2*n_phi**2*sin(beta)**2
    mu_1 = sigma*n_x**2*(n_phi**2 - 1)/N
    mu_2 = r_m*n_x**2*n_phi**2*sin(beta)/N
    mu_3 = sigma*n_x**2*n_phi**2*sin(beta)/N
    mu_4 = sigma*(n_x**2 - 1)*n_phi**2/N
    size = sqrt(at(x, t, 0)**2 + at(x, t, pi/2)**2)
    """
"""(23), f_1 and f_2 of (15) over r_l, the steady solution of (16), and (22) put right."""

CASE_2_VALUES = PRINTED_RATIOS[2]._asdict() | {
    "t": 2 * np.pi * np.arange(64) / 64, "alpha_1": 0.9, "alpha_2": 0.2,
}  # fmt: skip

IDENTITIES: Mapping[str, Identities] = {
    "mu_1": Identities(
        """
        x/size = (mu_1*r_m*wave - mu_2*sigma*other)/size
        printed = (mu_4*r_m*wave - mu_2*sigma*other)/size
        """,
        VIBRATING, CASE_2_VALUES,
    ),
    "rod_of_20": Identities(
        """
        error: phi_3 = mu_3*r_m*wave - mu_4*sigma*other
        apart: mu_4*r_m*wave - mu_2*sigma*other = (sigma*(1 - n_x**2)*n_phi**2*f_1
            + r_m*n_x**2*n_phi**2*f_2*sin(beta))/N
        apart: mu_3*r_m*wave - mu_4*sigma*other = (-sigma*n_x**2*n_phi**2*f_1*sin(beta)
            + sigma*(n_x**2 - 1)*n_phi**2*f_2)/N
        """,
        VIBRATING,
    ),
    "equations_15_17": Identities(
        """
        line 1: (M*a_x + k*x + m*r*w**2*(cos(phi_1) - cos(phi_2)) - E*l*a_3*sin(beta))/(M*l*w**2)
            = rate_x + x/l/n_x**2 - f_1 - r_m*sin(beta)/sigma*rate_3
        line 4: (E*l**2*a_3 + k_phi*phi_3 - E*l*a_x*sin(beta) - m*r*w**2*l*sin(phi_2 - beta))
            /(E*l**2*w**2) = rate_3 + phi_3/n_phi**2 - sin(beta)*rate_x + f_2
        transform: s**2*X + X/n_x**2 - F_1 - r_m*sin(beta)/sigma*s**2*P
            = (s**2 + 1/n_x**2)*X - F_1 - r_m*s**2*sin(beta)/sigma*P
        transform: s**2*P + P/n_phi**2 - sin(beta)*s**2*X + F_2
            = (s**2 + 1/n_phi**2)*P - s**2*sin(beta)*X + F_2
        """,
        """
        n_x = sqrt(w**2*M/k)
        n_phi = sqrt(w**2*E*l**2/k_phi)
        r_m = m/M
        sigma = m/E
        rate_x = a_x/(l*w**2)
        rate_3 = a_3/w**2
        f_1 = r_m*r/l*(cos(phi_2) - cos(phi_1))
        f_2 = -sigma*r/l*sin(phi_2 - beta)
        """,
    ),
    "equation_18": Identities(
        """
        F_1 = (s**2 + w_x**2)*X - r_m*s**2*sin(beta)/sigma*P
        -F_2 = (s**2 + w_phi**2)*P - s**2*sin(beta)*X
        """,
        """
        eta_21 = 1
        eta_31 = m_3/m_1
        sigma = 1/(1 + m_3/m_1)
        G = (s**2 + w_x**2)*(s**2 + w_phi**2) - r_m*s**4*sin(beta)**2/sigma
        X = ((s**2 + w_phi**2)*F_1 - (eta_21 + eta_31)*r_m*s**2*F_2*sin(beta))/G
        P = (s**2*F_1*sin(beta) - (s**2 + w_x**2)*F_2)/G
        """,
    ),
    "equation_26": Identities(
        """
        first: mean(-x_a*sin(phi_1), t) = -(mu_1*r_m*sin(alpha) + mu_2*sigma*cos(alpha + beta))/2
        second: mean(x_a*sin(phi_2) - phi_a*cos(phi_2 - beta), t) = (mu_1*r_m*sin(alpha)
            + mu_2*sigma*cos(beta) + mu_3*r_m*cos(alpha + beta) - mu_3*r_m*cos(beta))/2
        """,
        """
        phi_1 = t + alpha_2 + alpha
        phi_2 = t + alpha_2
        wave = cos(phi_1) - cos(phi_2)
        other = sin(phi_2 - beta)
        x_a = -(mu_1*r_m*wave - mu_2*sigma*other)
        phi_a = -(mu_3*r_m*wave - mu_4*sigma*other)
        """,
    ),
}  # fmt: skip
"""Those of a row, by its name; (26) holds with any mu."""


def equation_18(session: Session) -> Numbers:
    """Return what (18) leaves with eta_21 = m_2/m_1 and eta_31 = m_3/m_1, and their sum."""
    factor = 1 + float(CASE_1.rod_mass / CASE_1.rotor_mass)
    return {**IDENTITIES["equation_18"](session), "factor": factor}


def identity_29(session: Session) -> Numbers:
    """Return by how much mu_3 r_m = mu_2 sigma is missed, relative to it.

    And, at the roots of (30), what is left of both conditions (28), and of the mean torques (26)
    that they are of, over the amplitude; with mu_1 as printed and corrected, over table 2's range.
    """
    n = lattice()
    mu = theory.coupling_coefficients(n)
    left, right = mu.mu_3 * n.r_m, mu.mu_2 * n.sigma
    conditions = []
    for as_printed in (True, False):
        mu = theory.coupling_coefficients(n, as_printed)
        alpha = theory.stable_phase_difference(n, as_printed)
        own, wave = mu.mu_1 * n.r_m * np.sin(alpha), np.cos(alpha + n.beta)
        rest = (mu.mu_3 * n.r_m - mu.mu_2 * n.sigma) * np.cos(n.beta)
        lines = own + mu.mu_2 * n.sigma * wave, own + mu.mu_3 * n.r_m * wave - rest
        conditions.append(np.max(np.abs(lines) / (n.r_m * np.hypot(mu.mu_1, mu.mu_3))))
    return {
        "error": np.max(abs(left - right) / abs(right)),
        "conditions": max(conditions),
        "torques": max(conditions) / 2,
    }


VIBRATION: tuple[LedgerRow, ...] = (
    statement(
        "equations_15_17", "equations (12), (15)-(17)",
        "Equations of the vibration with rotors that turn uniformly, and their transform.",
        REPRODUCED,
        "(16) against the lines 1 and 4 of (12) at a random state: off by {errors[line 1]:.0e}, "
        "{errors[line 4]:.0e}; (17) "
        "against (16) with exponentials: {transform:.0e}",
        IDENTITIES["equations_15_17"],
        judgement=holds(below("largest", IDENTITY), below("transform", IDENTITY)),
    ),
    statement(
        "equation_18", "equations (17), (18)", "Laplace transform of the motion.", REPRODUCED,
        "eta_21 and eta_31 are not defined. With m_2/m_1 and m_3/m_1, as eta of (15) suggests, "
        "their sum is {factor:g} = 1/sigma, and so is eta_21 (1 + eta_31), should a bracket be "
        "lost; then (18) solves both lines of (17) to {error:.0e}",
        equation_18, judgement=holds(below("error", IDENTITY)),
    ),
    statement(
        "rod_of_20", "equations (19)-(24)", "The rod's vibration, by mu_3 and mu_4.",
        REPRODUCED,
        "phi_3 of (24) with (22), over a turn, against the steady solution of (16) with (19), at "
        "case 2: off by {error:.0e}; (20), (21) and (24), x included, are one as printed, to "
        "{apart:.0e}: of x see mu_1",
        IDENTITIES["rod_of_20"],
        judgement=holds(below("error", IDENTITY), below("apart", IDENTITY)),
    ),
    statement(
        "equation_26", "equations (25), (26)", "Mean torques of the vibration (21) on each rotor.",
        REPRODUCED,
        "its brackets, at alpha = alpha_1 - alpha_2, against averages over a turn, with mu_1 as "
        "printed and corrected: off by {first:.0e}, {second:.0e}",
        IDENTITIES["equation_26"], judgement=holds(below("largest", IDENTITY)),
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

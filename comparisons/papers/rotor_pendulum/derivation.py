"""Measures of the rotor_pendulum paper's model and theory: sections 2-4, figure 2, tables."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.stats import spearmanr

from ....reference.rotor_pendulum import theory
from ....reference.rotor_pendulum.cases import CASE_1, CASE_2
from ....reference.rotor_pendulum.equations import coefficients, operating_speed
from ....reference.rotor_pendulum.phase import coupling_harmonics, coupling_torque, wrapped
from ....reference.scene import Array
from ..ledger import Numbers
from ..session import Session
from .results import (
    BETAS,
    CASES,
    RANGE,
    REDUCED,
    from_rest,
    orbit_value,
    synchronous_orbit,
)

LATTICE = np.linspace(*RANGE, 139)
"""Values of a frequency ratio, 0.05 apart; none is 1."""

UNDAMPED = CASE_2.replace(platform_damping=0.0, rod_damping=0.0)


def lattice(beta: float = np.pi / 6) -> theory.Ratios:
    """Return both frequency ratios over the range of the figures, (139, 139)."""
    values = LATTICE + 1e-3
    return theory.Ratios(values[None], values[:, None], beta=beta)


# Section 2: model and equations


def reduction(session: Session) -> Numbers:
    """Compare phases [rad] of (11) with those of the exact equations: of runs and an orbit."""
    gaps = [
        np.max(abs(from_rest(session, case, REDUCED).phase - from_rest(session, case).phase))
        for case in CASES
    ]
    exact, reduced = (
        orbit_value(synchronous_orbit(session, CASE_2, model=model), "phase_difference")
        for model in (None, REDUCED)
    )
    return {"gaps": gaps, "exact": exact, "reduced": reduced}


# Section 3: coupling coefficients, figure 2


def mirror_images(session: Session) -> Numbers:
    """Return the median difference of mu_1 and mu_4, and that after n_x and n_phi are swapped."""
    n = lattice()
    mu = theory.coupling_coefficients(n)
    size = np.maximum(abs(mu.mu_1), abs(mu.mu_4))
    swapped = theory.coupling_coefficients(n._replace(n_x=n.n_phi, n_phi=n.n_x))
    return {
        "apart": np.median(abs(mu.mu_1 - mu.mu_4) / size),
        "mirrored": np.max(abs(swapped.mu_4 - mu.mu_1) / size),
    }


def level_rod(session: Session) -> Numbers:
    """Return the largest mu_2 and mu_3 where beta = 0, and the coupling torque there [N m]."""
    mu = theory.coupling_coefficients(lattice(0.0))
    return {
        "largest": max(np.max(abs(mu.mu_2)), np.max(abs(mu.mu_3))),
        "torque": float(theory.coupling_amplitude(UNDAMPED.replace(installation_angle=0.0))),
    }


def strength(session: Session) -> Numbers:
    """Return the rank correlation of mu_3 with the torque, and mu_1 where beta = 0 without mu_3."""
    n = lattice()
    mu, level = theory.coupling_coefficients(n), theory.coupling_coefficients(lattice(0.0))
    return {
        "rank": float(spearmanr(abs(mu.mu_3).ravel(), torque_size(mu, n.beta).ravel()).statistic),
        "mu_1_alone": 0.0 if np.any(level.mu_3) else np.max(abs(level.mu_1)),
    }


def torque_size(mu: theory.Coupling, beta: float) -> Array:
    """Return the amplitude of the coupling torque over the phase difference, without its scale."""
    return np.hypot(mu.mu_1 - mu.mu_3 * np.sin(beta), mu.mu_3 * np.cos(beta))


def identity_29(session: Session) -> Numbers:
    """Return by how much mu_3 r_m = mu_2 sigma is missed, relative to it."""
    n = lattice()
    mu = theory.coupling_coefficients(n)
    left, right = mu.mu_3 * n.r_m, mu.mu_2 * n.sigma
    return {"error": np.max(abs(left - right) / abs(right))}


REGIONS = {
    "before": (0.1, 0.9),
    "at": (0.9, 1.1),
    "after": (1.1, 7.0),
}
"""Of a frequency ratio, as section 3 divides it."""


def peaks(session: Session) -> Numbers:
    """Return medians of |mu_1| ... |mu_4| where both ratios are in a region, and least rise."""
    fine = theory.Ratios(*np.meshgrid(*[np.linspace(*RANGE, 1381) + 1e-4] * 2))
    mu = theory.coupling_coefficients(fine)
    typical = {}
    for name, (low, high) in REGIONS.items():
        here = (fine.n_x > low) & (fine.n_x < high) & (fine.n_phi > low) & (fine.n_phi < high)
        typical[name] = np.array([np.median(abs(one[here])) for one in mu])
    rise = min(np.min(typical["at"] / typical[name]) for name in ("before", "after"))
    return {**typical, "rise": rise}


def coupling_types(session: Session) -> Numbers:
    """Return the share of the plane without a type, and coupling torques [N m] of each type."""
    named = sum(high - low for low, high in (REGIONS["before"], REGIONS["after"]))

    def torque(ratio: float) -> float:
        """Return the coupling torque where both frequency ratios are this."""
        stiffness = (float(operating_speed(CASE_2)) / ratio) ** 2
        p = CASE_2.replace(platform_stiffness=114 * stiffness, rod_stiffness=1.08 * stiffness)
        return float(theory.coupling_amplitude(p))

    before, at, after = torque(0.5), torque(1.01), torque(3.0)
    return {
        "unnamed": 1 - (named / (RANGE[1] - RANGE[0])) ** 2,
        "torques": (before, at, after),
        "rises": (at - before, at - after),
    }


# Section 4: synchronisation and stability


def coupling_error(as_printed: bool) -> float:
    """Return by how much (34) misses the mean coupling torque, relative to its amplitude."""
    p, alpha = UNDAMPED, np.linspace(-np.pi, np.pi, 73)
    n, truth = theory.ratios(p), coupling_torque(p, alpha)
    scale = p.rotor_mass * (p.eccentricity * float(operating_speed(p))) ** 2 * n.r_m
    error = scale * theory.balance(n, alpha, as_printed) + truth
    return float(np.max(abs(error)) / np.max(abs(truth)))


def equation_34(session: Session) -> Numbers:
    """Return errors of (34), and the constant part and the amplitude of case 2's torque [N m]."""
    mean, first = map(complex, coupling_harmonics(CASE_2))
    return {
        "as_printed": coupling_error(True),
        "corrected": coupling_error(False),
        "mean": mean.real,
        "amplitude": abs(first),
    }


def roots(session: Session) -> Numbers:
    """Return residuals of (30) at its stable roots, and (36) at the opposite ones, by amplitude."""
    residuals, opposite = [], []
    for beta in (*BETAS.values(), np.pi / 2):
        n = lattice(beta)
        alpha = theory.stable_phase_difference(n)
        size = torque_size(theory.coupling_coefficients(n), beta)
        residuals.append(np.max(abs(theory.balance(n, alpha) / size)))
        opposite.append(np.max(theory.stability(n, alpha + np.pi) / size))
    return {"residual": max(residuals), "opposite": opposite}


def springs_decide(session: Session) -> Numbers:
    """Return how far each spring moves the phase but for half turns [rad], and flips by k_x."""
    alpha = theory.stable_phase_difference(lattice())
    doubled = np.exp(2j * alpha)
    return {
        "by_x": np.max(abs(np.angle(doubled / doubled[:, :1]))) / 2,
        "by_phi": np.ptp(np.unwrap(np.angle(doubled[:, 0])) / 2),
        "flips": np.mean(abs(wrapped(alpha - alpha[:, :1])) > np.pi / 2),
    }


# Tables 1, 2, and the frequency ratios of section 5.2


PRINTED_SPEED = 157.0
"""50 pi, rounded, from which table 1's ranges follow [rad/s]."""


def inertias(rod: bool) -> tuple[float, float]:
    """Return the inertia that a spring swings, and the one that the paper takes for it.

    Masses of the platform [kg], or moments of inertia of the rod [kg m^2].
    """
    c = coefficients(CASE_1)
    if rod:
        return float(c.end_mass * c.length**2), float((c.platform + c.rod) * c.length**2)
    return float(c.mass), float(c.platform)


def stiffness(session: Session, ratio: float, rod: bool) -> Numbers:
    """Return the stiffness that belongs to a frequency ratio, and that by the paper's inertia."""
    square = (PRINTED_SPEED / ratio) ** 2
    right, wrong = inertias(rod)
    return {
        "value": right * square,
        "mistaken": wrong * square,
        "right": right,
        "wrong": wrong,
        "ratio": ratio,
    }


def frequency_ratio(session: Session, case: int, rod: bool, printed: str) -> Numbers:
    """Return the frequency ratio of a printed stiffness, and speeds that make the printed one."""
    p = CASES[case]
    n, spring = theory.ratios(p), p.rod_stiffness if rod else p.platform_stiffness
    right, wrong = (float(printed) * float(np.sqrt(spring / inertia)) for inertia in inertias(rod))
    return {
        "value": float(n.n_phi if rod else n.n_x),
        "speed": float(operating_speed(p)),
        "takes": (right, wrong),
        "inertias": inertias(rod),
    }


def dimensionless(session: Session, value: Any) -> Numbers:
    """Return an entry of table 2."""
    return {"value": float(value)}

"""Measures of the hula_hoop paper's equations and approximate solutions, sections 1-4.

An identity is judged at one motion of the form (16), (17) that solves nothing, `TRIAL`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ....reference.hula_hoop.equations import (
    SEMICIRCLE,
    orbit_guesses,
)
from ....reference.hula_hoop.floquet import floquet_multipliers, variational_coefficients
from ....reference.hula_hoop.theory import (
    ApproximateSolution,
    balance_residuals,
    corrected_solution,
    nondimensional,
    paper_solution,
    refined_solution,
)
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ..ledger import Numbers
from ..session import Session
from .results import (
    APPROXIMATIONS,
    EXAMPLE,
    apart,
    approximation_errors,
    example_rotation,
    grid,
    is_class,
    motion_map,
    own_maps,
    samples,
    stability_map,
    stable,
    states,
)

PHASES = 2 * np.pi * np.arange(256) / 256
LINEAR = np.random.default_rng(14).normal(size=(2, 3, 3))
FUNCTIONS = np.random.default_rng(18).normal(size=(4, 3))
"""Operators, and U_0, V_1, V_2, f, by which orders in p are told apart."""
TRIAL = ApproximateSolution(
    alpha=0.8, q_1=1.3, beta=0.5, u_1=0.3, gamma=0.7, theta_0=0.0, residual=np.nan
)


# Sections 1, 2


def uniform_rotation(session: Session) -> Numbers:
    """Return the largest errors of theta [rad] of the printed solution and a uniform rotation.

    And that of y, over its largest value.
    """
    truth = states(example_rotation(session))
    start = orbit_guesses(EXAMPLE)[0]
    turning = start[1] + start[3] * samples(1.0)
    gap = apart(np.array([0 * turning, turning, 0 * turning, 0 * turning + start[3]]), truth)
    (y_error, error, *_), uniform = approximation_errors(session)["paper"], gap[1].max()
    return {
        "y_error": y_error / np.abs(truth[0]).max(),
        "error": error,
        "uniform": uniform,
        "ratio": error / uniform,
    }


def plate_inertia(session: Session, expected: float = SEMICIRCLE) -> Numbers:
    """Return I_eq of the semicircular plate by quadrature over the half disc, and as it is used."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    radius, angle = (1 + nodes[:, None]) / 2, np.pi * (1 + nodes[None]) / 2
    share = weights[:, None] * weights[None] * radius  # of the area, in the polar plane
    centre = np.sum(share * radius * np.sin(angle)) / np.sum(share)
    ratio = np.sum(share * radius**2) / np.sum(share) / centre**2 - 1
    return {"ratio": ratio, "expected": expected, "error": abs(ratio - expected)}


# Section 3


def even_harmonics(session: Session) -> Numbers:
    """Return the largest even harmonic of the nonlinear terms of (7), over all of them."""
    motion = TRIAL.motion(PHASES / TRIAL.alpha)
    terms = motion.theta_dot**2 * np.sin(motion.theta), motion.theta_ddot * np.cos(motion.theta)
    spectra = np.abs(np.fft.rfft(terms))
    return {"share": np.max(np.max(spectra[:, 0:7:2], axis=1) / np.max(spectra, axis=1))}


def orders(p: Any, other: Any = 0.0, known: Any = FUNCTIONS[3]) -> Any:
    """Return (14) with (18) at p, with random operators and functions.

    These are matrices for L, products of sines for N. With what else stands in N, and without a
    known function, it is (15) with (19).
    """
    linear, mixing = LINEAR
    start, first, second, _ = FUNCTIONS
    v = start + p * first + p**2 * second
    nonlinear = mixing @ np.sin(v + other)
    return linear @ (v - start) + p * linear @ start + p * (nonlinear - known)


def homotopy(session: Session) -> Numbers:
    """Return by how much (11) differs from (10), and at p = 0, 1 from (12), (13).

    With random values for L(V), L(U_0), N(V) and f. And how much (21), (22) are off as the first
    two orders of (14), and (38), (39) as those of (15).
    """
    linear, start, nonlinear, force = np.random.default_rng(11).normal(size=4)

    def in_11(p: float) -> float:
        return float(linear - start + p * start + p * (nonlinear - force))

    def in_10(p: float) -> float:
        return float((1 - p) * (linear - start) + p * (linear + nonlinear - force))

    ends = in_11(0.0) - (linear - start), in_11(1.0) - (linear + nonlinear - force)
    (matrix, mixing), (initial, first, of_slide, force_of_14) = LINEAR, FUNCTIONS
    series = []
    for other, known in ((0.0, force_of_14), (of_slide, 0.0)):
        first_order = matrix @ first + mixing @ np.sin(initial + other) + matrix @ initial - known
        series.append(np.max(np.abs(orders(0.0, other, known))))
        own = orders(1e-30j, other, known).imag / 1e-30
        series.append(np.max(np.abs(own - first_order)))
    return {"error": max(abs(in_11(0.3) - in_10(0.3)), *map(abs, ends), *series)}


def second_order(session: Session) -> Numbers:
    """Return errors of the second order of (20), whose N is taken at V_1 as printed."""
    (matrix, mixing), (initial, first, second, _) = LINEAR, FUNCTIONS
    step = 1e-4
    truth = (orders(step) - 2 * orders(0.0) + orders(-step)) / step**2 / 2
    printed, right = (
        float(np.max(np.abs(matrix @ second + mixing @ nonlinear - truth)))
        for nonlinear in (np.sin(first), np.cos(initial) * first)
    )
    return {"as_printed": printed, "corrected": right, "share": right / printed}


def secular_terms(session: Session) -> Numbers:
    """Return how the correction after (34) grows, in each half of 3000 periods of the spring.

    It is what 2 rho q' of (34) drives, q'' + q = 2 rho (sin(tau) - alpha sin(alpha tau)), over
    rho and the coefficients of (34). And what damping in the kernel would leave of its cos(tau) and
    sin(tau) in some periods.
    """
    c = nondimensional(EXAMPLE)
    alpha, periods = float(c.alpha), 10
    tau = np.linspace(0, 2e4, 200_001)
    resonant = (np.sin(tau) - tau * np.cos(tau)) / 2
    forced = alpha * (np.sin(alpha * tau) - alpha * np.sin(tau)) / (1 - alpha**2)
    wave = 2 * np.abs(resonant - forced) / abs(1 - alpha**2)
    early, late = (half.max() for half in np.split(wave[:-1], 2))
    left = np.exp(-float(c.rho) * 2 * np.pi * periods)
    return {"growth": late / early, "damped": left, "periods": periods}


def mean_balance(session: Session) -> Numbers:
    """Return mean torques over the friction without and with theta_0, and what theta_0 gains."""
    c = nondimensional(EXAMPLE)
    torques = {
        name: float(abs(balance_residuals(APPROXIMATIONS[name](EXAMPLE), EXAMPLE)[2]))
        / float(c.zeta_m * c.alpha)
        for name in ("paper", "corrected")
    }
    errors = approximation_errors(session)
    return {
        **torques,
        "phase": float(corrected_solution(EXAMPLE).theta_0),
        "gain": errors["paper"][1] / errors["corrected"][1],
    }


def dropped_torque(session: Session) -> Numbers:
    """Return what terms of second order change of u_1 where |u_1| < 0.5 in figure 4.

    In the median and at most, and at which share of the points by a tenth or less.
    """
    paper, full = (solve(grid(session, False)).u_1 for solve in (paper_solution, refined_solution))
    gap = np.abs(np.abs(full / paper) - 1)[np.abs(paper) < 0.5]
    return {"median": np.median(gap), "largest": np.max(gap), "within": np.mean(gap <= 0.1)}


def closed_form(session: Session) -> Numbers:
    """Return the largest residual of (49)-(52) over the grids of figures 4 and 6."""
    residuals = [paper_solution(grid(session, plate)).residual for plate in (False, True)]
    return {"residual": np.max(residuals)}


# Section 4


def rate_moduli(solution: ApproximateSolution, count: int = 64) -> Array:
    """Return moduli of the eigenvalues of A(tau) of (62) over one period, (count, 4)."""
    c = nondimensional(EXAMPLE)
    tau = 2 * np.pi / c.alpha * np.arange(count) / count
    p_1, p_2, p_3, p_4, p_5 = variational_coefficients(solution, EXAMPLE, tau)
    one, none = np.ones(count), np.zeros(count)
    mass = np.array([[one, p_1], [p_5, one]])
    right = -np.array(
        [[one, p_3, 2 * c.rho * one, p_2], [none, p_4, none, c.zeta_m / c.inertia * one]]
    )
    lower = np.linalg.solve(np.moveaxis(mass, -1, 0), np.moveaxis(right, -1, 0))
    upper = np.broadcast_to(np.eye(2, 4, 2), (count, 2, 4))
    return np.abs(np.linalg.eigvals(np.concatenate([upper, lower], axis=1)))


def eigenvalues(session: Session) -> Numbers:
    """Return how often A(tau) has an eigenvalue above 1, and the largest multiplier."""
    solution = corrected_solution(EXAMPLE)
    return {
        "above": np.mean(rate_moduli(solution).max(axis=1) > 1),
        "largest": float(abs(floquet_multipliers(solution, EXAMPLE)[0])),
    }


def unstable_seen(session: Session) -> Numbers:
    """Count robust points of figure 5 with a periodic motion where a rotation is unstable."""
    motion = motion_map(session, False)
    hoop = is_class(motion, "motion", "blue_o") & motion.robust
    periodic = hoop & (motion.variables["periods"] == 1)
    counts = {
        name: int(np.sum(~stable(session, False, name) & periodic)) for name in ("paper", "exact")
    }
    total = int(periodic.sum())
    return {**counts, "count": counts["exact"], "total": total, "more": int(hoop.sum()) - total}


def unstable_seen_by(session: Session, who: str) -> Numbers:
    """Count the same by an engine's own maps."""
    if who == REFERENCE:
        return {}
    calm, _, periodic = own_maps(session, False, who)
    return {"count": np.sum(periodic & ~calm), "total": np.sum(periodic)}


def stable_elsewhere(session: Session) -> Numbers:
    """Return where motions from rest end that do not reach a stable true rotation.

    And the largest multiplier of these rotations.
    """
    motion = motion_map(session, False)
    here = stable(session, False, "exact") & motion.robust
    elsewhere = here & ~is_class(motion, "motion", "blue_o")
    return {
        "share": elsewhere.sum() / here.sum(),
        "multiplier": stability_map(session, False).variables["multiplier"][here].max(),
        "total": int(here.sum()),
        "kinds": {
            name.replace("_", " "): int(np.sum(elsewhere & is_class(motion, "motion", name)))
            for name in motion.about["motion"].classes[1:]
        },
    }

"""Measures of the rotor_pendulum paper's model and theory: sections 2-4, figure 2, tables."""

from __future__ import annotations

import operator
from itertools import product
from typing import Any

import numpy as np
from scipy.stats import spearmanr

from ....reference import get_scene
from ....reference.differences import lagrange_terms
from ....reference.rotor_pendulum import CASE_1, CASE_2, theory
from ....reference.rotor_pendulum.equations import coefficients, energy, operating_speed
from ....reference.rotor_pendulum.phase import coupling_harmonics, coupling_torque, wrapped
from ....reference.scene import Array
from ..ledger import Numbers
from ..session import Session
from .results import (
    BETAS,
    CASES,
    PRINTED_RATIOS,
    RANGE,
    REDUCED,
    SCENE,
    class_shares,
    from_rest,
    orbit_value,
    phase_map,
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


def printed_kinetic(q: Any, v: Any, c: Any) -> Any:
    """Return (7) without J_i, which 2.2 neglects."""
    rod, swing, sin, cos = c.beta + q[3], c.length * v[3], np.sin, np.cos
    first, second = c.eccentricity * v[1], c.eccentricity * v[2]
    masses = (
        (c.platform, v[0], 0.0),
        (c.rotor, v[0] + first * sin(q[1]), first * cos(q[1])),
        (
            c.rotor,
            v[0] - second * sin(q[2]) - swing * sin(rod),
            second * cos(q[2]) + swing * cos(rod),
        ),
        (c.rod, v[0] - swing * sin(rod), swing * cos(rod)),
    )
    return sum(mass * (x**2 + y**2) for mass, x, y in masses) / 2


def printed_potential(q: Any, c: Any) -> Any:
    """Return (8)."""
    return (c.stiffness * q[0] ** 2 + c.rod_stiffness * q[3] ** 2) / 2


def random_states() -> list[Array]:
    """Return random coordinates and rates (2, 4), 16 of them."""
    random = np.random.default_rng(18)
    scales = np.array([[0.01, 1, 1, 0.1], [1, 100, 100, 5]])
    return [np.asarray(random.normal(size=(2, 4)) * scales) for _ in range(16)]


def printed_energy(session: Session) -> Numbers:
    """Return by how much (7) and (8) differ from the scene's energy at random states, relative."""
    c = coefficients(CASE_2)
    errors = [
        abs((printed_kinetic(q, v, c) + printed_potential(q, c)) / energy(q, v, c) - 1)
        for q, v in random_states()
    ]
    return {"error": max(errors)}


def equation_10(session: Session) -> Numbers:
    """Return what the scene's accelerations leave of (10), relative to its largest term.

    With (7), (8), the dampers of (9) that table 1 has, and the motors' torques less those of the
    bearings, at random states.
    """
    c, errors = coefficients(CASE_2), []
    for q, v in random_states():
        a = np.array(get_scene(SCENE).accelerations(0.0, q, v, c))
        terms = lagrange_terms(
            lambda q, v: printed_kinetic(q, v, c), lambda q: printed_potential(q, c), q, v, a
        )
        motors = [c.slope * (c.speed - rate) - c.friction * rate for rate in v[1:3]]
        forces = np.array([-c.damping * v[0], *motors, -c.rod_damping * v[3]])
        every = np.array([*terms, -forces])
        errors.append(np.max(abs(every.sum(axis=0)) / abs(every).max(axis=0)))
    return {"error": max(errors)}


def lines_of_11(sign: int = -1) -> Array:
    """Return residuals of the lines of (11) with Lagrange's accelerations, where phi_3 = 0.

    Each relative to its largest term; ``sign`` stands before phi_2'^2 in line 4, printed +1.
    """
    scene, p = get_scene(SCENE), CASE_2
    c = coefficients(p)
    q, v = np.array([1e-3, 0.4, 1.1, 0.0]), np.array([0.1, 150.0, 155.0, 2.0])
    a = scene.accelerations(0.0, q, v, c)
    arm, first, second = c.end_mass * c.length, np.sin(q[1]), np.sin(q[2])
    torques = [c.slope * (c.speed - rate) - c.friction * rate for rate in v[1:3]]
    lines = (
        (
            c.mass * a[0],
            c.damping * v[0],
            c.stiffness * q[0],
            c.unbalance * (a[1] * first + v[1] ** 2 * np.cos(q[1])),
            -c.unbalance * (a[2] * second + v[2] ** 2 * np.cos(q[2])),
            -arm * (a[3] * np.sin(c.beta) + v[3] ** 2 * np.cos(c.beta)),
        ),
        (c.unbalance * c.eccentricity * a[1], -torques[0], c.unbalance * a[0] * first),
        (
            c.unbalance * c.eccentricity * a[2],
            -torques[1],
            -c.unbalance * a[0] * second,
            c.unbalance * c.length * a[3] * np.cos(c.beta - q[2]),
            -c.unbalance * c.length * v[3] ** 2 * np.sin(c.beta - q[2]),
        ),
        (
            arm * c.length * a[3],
            c.rod_damping * v[3],
            -arm * a[0] * np.sin(c.beta),
            c.unbalance * c.length * a[2] * np.cos(q[2] - c.beta),
            sign * c.unbalance * c.length * v[2] ** 2 * np.sin(q[2] - c.beta),
        ),
    )
    return np.array([abs(sum(terms)) / max(map(abs, terms)) for terms in lines])


def other_lines_of_11(session: Session) -> Numbers:
    """Return what the lines 1 to 3 of (11) leave with Lagrange's accelerations at phi_3 = 0."""
    return {"left": lines_of_11()[:3]}


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


def level_mu_1(session: Session) -> Numbers:
    """Return the largest mu_1 where beta = 0 and n_x < 1, right and as printed."""
    n = lattice(0.0)
    before = np.broadcast_to(n.n_x < 1, (len(LATTICE), len(LATTICE)))
    right, printed = (
        float(np.max(theory.coupling_coefficients(n, as_printed).mu_1[before]))
        for as_printed in (False, True)
    )
    return {"right": right, "printed": printed}


def strength(session: Session) -> Numbers:
    """Return rank correlations of mu_3, and mu_1 where beta = 0 without mu_3.

    With the torque that couples the rotors, and with what the rod's swing owes to rotor 1.
    """
    n = lattice()
    mu, level = theory.coupling_coefficients(n), theory.coupling_coefficients(lattice(0.0))
    sin, springs = np.sin(n.beta), (1 / n.n_x**2 - 1) * (1 / n.n_phi**2 - 1)
    swing = abs(n.r_m * sin / (springs - n.r_m * sin**2 / n.sigma))  # of (16), by Cramer's rule
    return {
        "swing": float(spearmanr(abs(mu.mu_3).ravel(), swing.ravel()).statistic),
        "rank": float(spearmanr(abs(mu.mu_3).ravel(), torque_size(mu, n.beta).ravel()).statistic),
        "mu_1_alone": 0.0 if np.any(level.mu_3) else np.max(abs(level.mu_1)),
    }


def torque_size(mu: theory.Coupling, beta: float) -> Array:
    """Return the amplitude of the coupling torque over the phase difference, without its scale."""
    return np.hypot(mu.mu_1 - mu.mu_3 * np.sin(beta), mu.mu_3 * np.cos(beta))


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


def equations_31_36(session: Session) -> Numbers:
    """Return by how much (31) is missed at the stable roots of (30), and (36) by (34)'s slope.

    The first relative to the cosecant; both over the range of figure 3 at its angles, with mu_1
    as printed and corrected.
    """
    roots_left, slopes_left = [], []
    for beta, as_printed in product(BETAS.values(), (True, False)):
        n = lattice(beta)
        mu = theory.coupling_coefficients(n, as_printed)
        alpha = theory.stable_phase_difference(n, as_printed)
        size = torque_size(mu, beta)
        left = (mu.mu_3 * np.sin(beta) - mu.mu_1) * np.sin(alpha)
        roots_left.append(np.max(abs(left - mu.mu_3 * np.cos(beta) * np.cos(alpha)) / size))
        step, a = 1e-5, 0.7
        ends = (theory.balance(n, a + way * step, as_printed) for way in (1, -1))
        slope = operator.sub(*ends) / (2 * step)
        slopes_left.append(np.max(abs(slope - theory.stability(n, a, as_printed)) / size))
    return {"root": max(roots_left), "slope": max(slopes_left)}


def branch_of_33(session: Session) -> Numbers:
    """Return shares of figure 3's range where (33) with values in (0, pi) is the unstable root.

    And by how much the cotangent of the stable root is missed, see `equations_31_36`.
    """
    shares = {
        f"beta = {name}": class_shares(phase_map(session, beta, "paper"), Ellipsis).get(
            "unstable", 0.0
        )
        for name, beta in BETAS.items()
    }
    return {"shares": shares, "error": equations_31_36(session)["root"]}


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
    """Return residuals of (30) at its stable roots, and (36) at the opposite ones, by amplitude.

    With mu_1 as printed and corrected.
    """
    residuals, opposite = [], []
    for beta, as_printed in product((*BETAS.values(), np.pi / 2), (True, False)):
        n = lattice(beta)
        alpha = theory.stable_phase_difference(n, as_printed)
        size = torque_size(theory.coupling_coefficients(n, as_printed), beta)
        residuals.append(np.max(abs(theory.balance(n, alpha, as_printed) / size)))
        opposite.append(np.max(theory.stability(n, alpha + np.pi, as_printed) / size))
    return {"residual": max(residuals), "opposite": opposite}


def springs_decide(session: Session) -> Numbers:
    """Return how far each spring moves the phase but for half turns [rad], and flips by k_x.

    And how far k_phi and k_x do with mu_1 as printed, at the least of the other ratio.
    """
    alpha = theory.stable_phase_difference(lattice())
    doubled = np.exp(2j * alpha)
    by_print = np.exp(2j * theory.stable_phase_difference(lattice(), as_printed=True))
    printed = [np.ptp(np.unwrap(np.angle(one)) / 2) for one in (by_print[:, 0], by_print[0])]
    return {
        "printed": printed,
        "most": max(printed),
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


SPEEDS = (151.5, 157.5)
"""What rounds to table 1's range of the rotors' speed [rad/s]."""


def frequency_ratio(session: Session, case: int, rod: bool, printed: str) -> Numbers:
    """Return the frequency ratio of a printed stiffness, and speeds that make the printed one.

    It is taken at that speed of table 1's range that brings it nearest to the printed one.
    """
    p = CASES[case]
    n, spring = theory.ratios(p, speed=1.0), p.rod_stiffness if rod else p.platform_stiffness
    right, wrong = (float(printed) * float(np.sqrt(spring / inertia)) for inertia in inertias(rod))
    speed = float(np.clip(right, *SPEEDS))
    return {
        "value": speed * float(n.n_phi if rod else n.n_x),
        "speed": speed,
        "takes": (right, wrong),
        "inertias": inertias(rod),
    }


def speeds_of_ratios(session: Session) -> Numbers:
    """Return the speeds [rad/s] that section 5.2's stiffnesses and frequency ratios ask for.

    Of n_x and n_phi in cases 1 and 2, with that of both inertias that comes nearer table 1's range.
    """
    asked = []
    for case, rod in product((1, 2), (False, True)):
        n = PRINTED_RATIOS[case]
        takes = frequency_ratio(session, case, rod, str(n.n_phi if rod else n.n_x))["takes"]
        asked.append(min(takes, key=lambda speed: abs(speed - np.mean(SPEEDS))))
    return {"asked": asked, "slowest": min(asked), "fastest": max(asked)}


def dimensionless(session: Session, value: Any) -> Numbers:
    """Return an entry of table 2."""
    return {"value": float(value)}

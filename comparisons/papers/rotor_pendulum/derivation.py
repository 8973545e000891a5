"""Measures of the rotor_pendulum paper's model and theory: sections 2-4, figure 2, tables.

Its equations themselves are texts in ``claims.toml``.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from scipy.stats import spearmanr

from ....reference import get_scene
from ....reference.rotor_pendulum import CASE_1, CASE_2, theory
from ....reference.rotor_pendulum.equations import RotorPendulum, coefficients, operating_speed
from ....reference.scene import Array
from ..equations import Values
from ..ledger import Numbers
from ..session import Session
from .results import (
    BETAS,
    CASES,
    PRINTED_RATIOS,
    RANGE,
    REDUCED,
    SCENE,
    from_rest,
    orbit_value,
    synchronous_orbit,
)


def at_ratios(n_x: float, n_phi: float, beta: float) -> RotorPendulum:
    """Return the parameters of a point of figure 3, with the dampers of table 1."""
    c, speed = coefficients(CASE_1), float(operating_speed(CASE_1))
    return CASE_1.replace(
        installation_angle=beta,
        platform_stiffness=float(c.mass) * (speed / n_x) ** 2,
        rod_stiffness=float(c.end_mass * c.length**2) * (speed / n_phi) ** 2,
    )


LATTICE = np.linspace(*RANGE, 139) + 1e-3
"""Values of a frequency ratio, 0.05 apart; none is 1."""

CASE_2_RATIOS: Values = PRINTED_RATIOS[2]._asdict()
TURN = 2 * np.pi * np.arange(64) / 64
CASE_2_VALUES: Values = {**CASE_2_RATIOS, "t": TURN, "alpha_1": 0.9, "alpha_2": 0.2}
"""Parameters of case 2, and a turn of it, at which equations of the vibration are compared."""


def lattice(beta: float = np.pi / 6) -> theory.Ratios:
    """Return both frequency ratios over the range of the figures, (139, 139)."""
    return theory.Ratios(LATTICE[None], LATTICE[:, None], beta=beta)


# Section 2: model and equations

SYMBOLS = {
    "platform_mass": "m_0", "rotor_mass": "m", "rod_mass": "m_3", "eccentricity": "r",
    "rod_length": "l", "platform_stiffness": "k_x", "platform_damping": "f_x",
    "rod_stiffness": "k_phi", "rod_damping": "f_phi", "installation_angle": "beta",
}  # fmt: skip
"""Parameters of the scene and their symbols in the paper."""


def scene_at(values: Values) -> Values:
    """Return the scene's energy and accelerations at a state, in the symbols of (7) to (11).

    Without motors and bearings where the equations have none.
    """
    q, v = (np.array([values[f"{x}_{i}"] for i in range(4)], dtype=float) for x in ("q", "v"))
    p = RotorPendulum(
        **{name: values[symbol] for name, symbol in SYMBOLS.items()},
        motor_slope=values.get("k_e", 0.0),
        synchronous_speed=values.get("w_s", 1.0),
        friction=values.get("f", 0.0),
    )
    scene, c = get_scene(SCENE), coefficients(p)
    a = scene.accelerations(0.0, q, v, c)
    return {"energy": scene.energy(q, v, c)} | {f"a_{i}": float(one) for i, one in enumerate(a)}


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


MUTUAL, STATOR, RESISTANCE, VOLTAGE, POLES = 0.13, 0.1, 0.54, 220.0, 2
"""Table 1's induction motor [H, H, ohm, V, 1]."""


def motor_slope(electric_powers: int) -> float:
    """Return the slope of (14) over the mechanical speed [N m s/rad, if it is one].

    (14) divides by the electric speed once; a torque needs it twice. With the electric
    synchronous speed omega_s = n_p times the mechanical one, the slip is omega_s - n_p omega_m.
    """
    electric = POLES * float(CASE_1.synchronous_speed)
    scale = POLES * MUTUAL**2 * VOLTAGE**2 / (STATOR**2 * RESISTANCE)
    return float(POLES * scale / electric**electric_powers)


def equation_14(session: Session) -> Numbers:
    """Return the result of (14) at 153.8 rad/s: a power [W], with omega_m^2 a torque [N m].

    And the relative distance of the torque from the 3.08 N m of section 5.2; and the torque with
    the two inductances exchanged [N m].
    """
    slip = 50 * np.pi - 153.8
    power, torque = motor_slope(1) * slip, motor_slope(2) * slip
    exchanged = torque * (STATOR / MUTUAL) ** 4
    return {"power": power, "torque": torque, "off": abs(torque / 3.08 - 1), "exchanged": exchanged}


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


def level_coupling(session: Session) -> Numbers:
    """Return mu_1, and mu_2 and mu_3, where beta = 0.

    The largest mu_1 for n_x < 1, right and as printed; the largest mu_2 and mu_3; the coupling
    torque with case 2's springs [N m].
    """
    n = lattice(0.0)
    mu, printed = (theory.coupling_coefficients(n, as_printed) for as_printed in (False, True))
    before = np.broadcast_to(n.n_x < 1, mu.mu_1.shape)
    return {
        "right": np.max(mu.mu_1[before]),
        "printed": np.max(printed.mu_1[before]),
        "largest": max(np.max(abs(mu.mu_2)), np.max(abs(mu.mu_3))),
        "torque": float(theory.coupling_amplitude(CASE_2.replace(installation_angle=0.0))),
    }


def strength(session: Session) -> Numbers:
    """Return rank correlations of mu_3, and mu_1 where beta = 0 without mu_3.

    With the torque that couples the rotors, and with the rod's swing by rotor 1.
    """
    n = lattice()
    mu, level = theory.coupling_coefficients(n), theory.coupling_coefficients(lattice(0.0))
    sin, springs = np.sin(n.beta), (1 / n.n_x**2 - 1) * (1 / n.n_phi**2 - 1)
    swing = abs(n.r_m * sin / (springs - n.r_m * sin**2 / n.sigma))  # of (16), by Cramer's rule
    ranks = [
        float(spearmanr(abs(mu.mu_3).ravel(), other.ravel()).statistic)
        for other in (swing, torque_size(mu, n.beta))
    ]
    alone = 0.0 if np.any(level.mu_3) else np.max(abs(level.mu_1))
    return {"swing": ranks[0], "rank": ranks[1], "mu_1_alone": alone}


def torque_size(mu: theory.Coupling, beta: float) -> Array:
    """Return the amplitude of the coupling torque over the phase difference, without its scale."""
    return np.hypot(mu.mu_1 - mu.mu_3 * np.sin(beta), mu.mu_3 * np.cos(beta))


REGIONS = {"before": (0.1, 0.9), "at": (0.9, 1.1), "after": (1.1, 7.0)}
"""Ranges of a frequency ratio, as section 3 divides it."""


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
    torques = [
        float(theory.coupling_amplitude(at_ratios(ratio, ratio, np.pi / 6)))
        for ratio in (0.5, 1.01, 3.0)
    ]
    return {
        "unnamed": 1 - (named / (RANGE[1] - RANGE[0])) ** 2,
        "torques": torques,
        "rises": (torques[1] - torques[0], torques[1] - torques[2]),
    }


# Section 4: synchronisation and stability


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
    """Return the change of the phase by each spring but for half turns [rad], and flips by k_x.

    And the changes by k_phi and k_x with mu_1 as printed, at the least of the other ratio.
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
        "flips": np.mean(np.cos(alpha - alpha[:, :1]) < 0),
    }


# Tables 1, 2, and the frequency ratios of section 5.2


PRINTED_SPEED = 157.0
"""50 pi, rounded, from which table 1's ranges follow [rad/s]."""
SPEEDS = (151.5, 157.5)
"""Speeds that round to table 1's range of the rotors' speed [rad/s]."""


RATIOS = {"platform": "n_x", "rod": "n_phi"}
"""Frequency ratio of each spring."""


def spring_inertias(spring: str) -> tuple[float, float]:
    """Return the inertia on a spring, and the paper's value of it.

    Masses on the platform's spring [kg], or moments of inertia on the rod's [kg m^2].
    """
    c = coefficients(CASE_1)
    right, wrong = c.mass, c.platform
    if spring == "rod":
        right, wrong = c.end_mass * c.length**2, (c.platform + c.rod) * c.length**2
    return float(right), float(wrong)


def stiffness(session: Session, ratio: float, spring: str) -> Numbers:
    """Return the stiffness that belongs to a frequency ratio, and that by the paper's inertia."""
    square, (right, wrong) = (PRINTED_SPEED / ratio) ** 2, spring_inertias(spring)
    own = {"value": right * square, "mistaken": wrong * square}
    return {**own, "right": right, "wrong": wrong, "ratio": ratio}


def frequency_ratio(session: Session, case: int, spring: str) -> Numbers:
    """Return the frequency ratio of a printed stiffness, and speeds that make the printed one.

    It is taken at that speed of table 1's range that brings it nearest to the printed one.
    """
    printed = getattr(PRINTED_RATIOS[case], RATIOS[spring])
    per_speed = float(getattr(theory.ratios(CASES[case], speed=1.0), RATIOS[spring]))
    right, wrong = spring_inertias(spring)
    takes = printed / per_speed
    speed = float(np.clip(takes, *SPEEDS))
    return {
        "value": speed * per_speed,
        "speed": speed,
        "takes": (takes, takes * float(np.sqrt(right / wrong))),
        "inertias": (right, wrong),
    }


def speeds_of_ratios(session: Session) -> Numbers:
    """Return the speeds [rad/s] that section 5.2's stiffnesses and frequency ratios require.

    Of n_x and n_phi in cases 1 and 2, with that of both inertias that comes nearer table 1's range.
    """
    takes = [
        frequency_ratio(session, case, spring)["takes"] for case, spring in product((1, 2), RATIOS)
    ]
    needed = [min(pair, key=lambda speed: abs(speed - np.mean(SPEEDS))) for pair in takes]
    return {"needed": needed, "slowest": min(needed), "fastest": max(needed)}


def electric_speed(session: Session) -> Numbers:
    """Return case 2's n_x by (19): with the rotors' speed, and with that below (14)."""
    electric = POLES * float(CASE_1.synchronous_speed)
    mechanical, printed = (theory.ratios(CASE_2, speed=w).n_x for w in (electric / POLES, electric))
    return {"corrected": float(mechanical), "as_printed": float(printed), "electric": electric}


def dimensionless(session: Session, name: str) -> Numbers:
    """Return an entry of table 2: eta, sigma or r_m."""
    n = theory.ratios(CASE_1)
    entries = {"eta": CASE_1.rod_mass / CASE_1.rotor_mass, "sigma": n.sigma, "r_m": n.r_m}
    return {"value": float(entries[name])}

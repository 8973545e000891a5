"""Measures of the hula_hoop paper's equations and approximate solutions, sections 1-4.

Its equations themselves are texts in ``claims.toml``. An identity is judged at one motion of the
form (16), (17) that solves nothing, `TRIAL`, with s = alpha tau; where no motion is needed, values
are random.
"""

from __future__ import annotations

from math import factorial
from typing import Any

import numpy as np
from scipy.special import jv

from ....reference import get_scene
from ....reference.equations import scene_equations
from ....reference.hula_hoop.equations import (
    SEMICIRCLE,
    coefficients,
    drive,
    energy,
    orbit_guesses,
)
from ....reference.hula_hoop.floquet import floquet_multipliers, variational_coefficients
from ....reference.hula_hoop.theory import (
    ApproximateSolution,
    balance_residuals,
    corrected_solution,
    nondimensional,
    paper_solution,
    printed_residuals,
    refined_solution,
)
from ....reference.scene import Array
from ...checks.truth import random_states
from ...engines.registry import REFERENCE
from ...engines.run import contained
from ...queries.query import choose_engine
from ...queries.request import Query
from ..claims import read_paper
from ..equations import Values
from ..ledger import Numbers
from ..session import Session
from .results import (
    APPROXIMATIONS,
    EXAMPLE,
    PLATES,
    SCENE,
    apart,
    approximation_errors,
    example_rotation,
    grid,
    samples,
    stable,
    states,
)

PHASES = 2 * np.pi * np.arange(256) / 256
LINEAR, MIXING = np.random.default_rng(14).normal(size=(2, 3, 3))
START, FIRST, SECOND, FORCE = np.random.default_rng(18).normal(size=(4, 3))
"""Random operators, and U_0, V_1, V_2, f, by which orders in p are distinguished."""
TRIAL = ApproximateSolution(
    alpha=0.8, q_1=1.3, beta=0.5, u_1=0.3, gamma=0.7, theta_0=0.0, residual=np.nan
)

NUMBERS = {name: float(value) for name, value in nondimensional(EXAMPLE)._asdict().items()}
ALONG = NUMBERS | {name: vars(TRIAL)[name] for name in ("alpha", "q_1", "beta", "u_1", "gamma")}
ALONG |= {"s": PHASES}
"""Coefficients of (7), (8), and with them the values of the trial motion over a turn."""

LONG_TIME = NUMBERS | {"t": np.linspace(0, 40, 400)}

BODIES = {"I_m": np.repeat([0.0, SEMICIRCLE], 8)}


def dimensional(values: Values) -> Values:
    """Return parameters, a state and accelerations of the scene [SI] at a point.

    It has ``I_m`` and ``t`` [s]; y, theta and their rates are of random size.
    """
    p = EXAMPLE.replace(inertia_ratio=values["I_m"])
    c, t = coefficients(p), values["t"]
    q, v = (0.01 * values["y"], values["theta"]), (values["y_v"], 20 * values["theta_v"])
    a = get_scene(SCENE).accelerations(drive(t, c), q, v, c)
    return {
        "M": p.main_mass, "m": p.free_mass, "R": p.rod_length,
        "k": p.stiffness, "rho": p.damping_ratio, "zeta_m": p.hinge_damping_ratio,
        "omega_n": float(p.omega_n), "F": p.force_amplitude, "f": p.force_frequency,
        "y": q[0], "theta": q[1], "y_v": v[0], "theta_v": v[1],
        "y_a": float(a[0]), "theta_a": float(a[1]), "energy": float(energy(q, v, c)),
    }  # fmt: skip


# Sections 1, 2


def uniform_rotation(session: Session) -> Numbers:
    """Return the largest errors of theta [rad] of the printed solution and a uniform rotation.

    And that of y, over its largest value.
    """
    truth = states(example_rotation(session))
    start = orbit_guesses(EXAMPLE)[0]
    angle = start[1] + start[3] * samples(1.0)
    gap = apart(np.array([0 * angle, angle, 0 * angle, 0 * angle + start[3]]), truth)
    (y_error, error, *_), uniform = approximation_errors(session)["paper"], gap[1].max()
    return {
        "y_error": y_error / np.abs(truth[0]).max(),
        "error": error,
        "uniform": uniform,
        "ratio": error / uniform,
    }


def plate_inertia(session: Session, expected: float = SEMICIRCLE) -> Numbers:
    """Return I_eq of the semicircular plate by quadrature over the half disc, and its error."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    radius, angle = (1 + nodes[:, None]) / 2, np.pi * (1 + nodes[None]) / 2
    share = weights[:, None] * weights[None] * radius  # of the area, in the polar plane
    centre = np.sum(share * radius * np.sin(angle)) / np.sum(share)
    ratio = np.sum(share * radius**2) / np.sum(share) / centre**2 - 1
    return {"ratio": ratio, "error": abs(ratio - expected)}


def equations_of_motion(session: Session, who: str) -> Numbers:
    """Return errors at random states: of (7), (8), or of the accelerations of an engine."""
    if who == REFERENCE:
        row = next(row for row in read_paper(SCENE).rows if row.name == "lagrange")
        assert row.equations is not None
        return {"error": row.equations()["(7), (8)"], "count": len(BODIES["I_m"])}
    case, scene = Query(SCENE).case, get_scene(SCENE)
    times, points = random_states(scene_equations(case), case, scene.coordinates)
    derivative = scene.right_hand_side(case.parameters)
    truth = np.array([derivative(t, x)[2:] for t, x in zip(times, points, strict=True)])
    engine, model = choose_engine(who, case, None)
    with contained():
        own = engine.bind(case, model).accelerations(times, points)
    return {"error": float(np.abs(own - truth).max() / np.abs(truth).max())}


def mass_ratio(session: Session) -> Numbers:
    """Return m/(M + m) of table 1."""
    return {"value": NUMBERS["epsilon"]}


# Section 3


def even_harmonics(session: Session) -> Numbers:
    """Return the largest even harmonic of the nonlinear terms of (7), over all of them."""
    motion = TRIAL.motion(PHASES / TRIAL.alpha)
    terms = motion.theta_dot**2 * np.sin(motion.theta), motion.theta_ddot * np.cos(motion.theta)
    spectra = np.abs(np.fft.rfft(terms))
    return {"share": np.max(np.max(spectra[:, 0:7:2], axis=1) / np.max(spectra, axis=1))}


def orders(p: Any, other: Any = 0.0, known: Any = FORCE) -> Any:
    """Return (14) with (18) at p, with random operators and functions.

    These are matrices for L, products of sines for N. With the other argument of N, and without a
    known function, it is (15) with (19).
    """
    v = START + p * FIRST + p**2 * SECOND
    nonlinear = MIXING @ np.sin(v + other)
    return LINEAR @ (v - START) + p * LINEAR @ START + p * (nonlinear - known)


def homotopy(session: Session) -> Numbers:
    """Return the largest difference of (11) from (10), and at p = 0, 1 from (12), (13).

    With random values for L(V), L(U_0), N(V) and f. It also covers the errors of (21), (22) as the
    first two orders of (14), and of (38), (39) as those of (15).
    """
    linear, start, nonlinear, force = np.random.default_rng(11).normal(size=4)

    def in_11(p: float) -> float:
        return float(linear - start + p * start + p * (nonlinear - force))

    in_10 = 0.7 * (linear - start) + 0.3 * (linear + nonlinear - force)
    ends = in_11(0.0) - (linear - start), in_11(1.0) - (linear + nonlinear - force)
    series = [abs(in_11(0.3) - in_10), *map(abs, ends)]
    for other, known in ((0.0, FORCE), (SECOND, 0.0)):
        first_order = LINEAR @ FIRST + MIXING @ np.sin(START + other) + LINEAR @ START - known
        series.append(np.max(np.abs(orders(0.0, other, known))))
        slope = orders(1e-30j, other, known).imag / 1e-30
        series.append(np.max(np.abs(slope - first_order)))
    return {"error": max(series)}


def second_order(session: Session) -> Numbers:
    """Return errors of the second order of (20), whose N is taken at V_1 as printed."""
    step = 1e-4
    truth = (orders(step) - 2 * orders(0.0) + orders(-step)) / step**2 / 2
    printed, right = (
        float(np.max(np.abs(LINEAR @ SECOND + MIXING @ nonlinear - truth)))
        for nonlinear in (np.sin(FIRST), np.cos(START) * FIRST)
    )
    return {"as_printed": printed, "corrected": right, "share": right / printed}


def bessel_series(session: Session) -> Numbers:
    """Return the largest error of ten terms of (26) against J_0 ... J_5 at |u_1| = 0.5 and 2."""
    errors = [
        abs(
            (u / 2) ** n
            * sum((-(u**2) / 4) ** k / (factorial(k) * factorial(n + k)) for k in range(10))
            - jv(n, u)
        )
        for u in (0.5, 2.0)
        for n in range(6)
    ]
    return {"error": max(errors)}


def bessel(session: Session) -> Numbers:
    """Return relative errors of (27) for J_0 ... J_5 at |u_1| = 0.5, and J_2, J_3 over J_0."""
    u = 0.5
    simple = [u**n / (2**n * factorial(n)) for n in range(6)]
    errors = {f"J_{n}": abs(own / jv(n, u) - 1) for n, own in enumerate(simple)}
    errors |= {f"J_{n} against J_0": jv(n, u) / jv(0, u) for n in (2, 3)}
    return {"errors": errors, "largest": max(errors.values())}


def change_of_u_1(session: Session) -> Numbers:
    """Return the change of u_1 by the term that (35) has lost, at 3 Hz and 60 N and in figure 4.

    (35), (36), (46) and (47) are two complex equations for q_1 exp(i beta) and u_1 exp(i gamma),
    of which the first is eliminated. Without the term the second occurs with its real part alone.
    """
    changes = []
    for p in (EXAMPLE, grid(session, False)):
        c = nondimensional(p)
        spring = 1 - c.alpha**2 - 2j * c.rho * c.alpha
        hinge = 4 * c.alpha**2 * c.inertia + 2j * c.zeta_m * c.alpha
        a, inertial = -spring * hinge / (c.alpha**2 / 2), c.epsilon * c.alpha**2
        whole = abs((c.force + 1j * inertial) / (a - inertial / 2))
        real = a.real - inertial / 2
        cosine, sine = c.force * a.real + inertial * a.imag, inertial * real - c.force * a.imag
        without = np.hypot(cosine, sine) / abs(real * a.real + a.imag**2)
        changes.append(float(np.max(np.abs(whole / without - 1))))
    return {"changes": changes}


def approximations(session: Session) -> Numbers:
    """Return bounds of the corrections (34) and (45) by (49)-(52), over q_1 and u_1.

    The residuals of (35), (36), (46), (47) are their coefficients of sine and cosine.
    """
    plate = EXAMPLE.replace(inertia_ratio=SEMICIRCLE)
    solution = paper_solution(plate)
    left = np.abs(printed_residuals(solution, plate)).reshape(2, 2).max(axis=1)
    a = np.array([1, 2]) * float(solution.alpha)
    of_q, of_theta = left * (a + 3) / abs(1 - a**2) / np.abs([solution.q_1, solution.u_1])
    return {"of_q": of_q, "of_theta": of_theta}


def secular_terms(session: Session) -> Numbers:
    """Return the growth of the correction after (34), in each half of 3000 periods of the spring.

    It is the response to 2 rho q' of (34), q'' + q = 2 rho (sin(tau) - alpha sin(alpha tau)), over
    rho and the coefficients of (34). ``damped`` is the share of its cos(tau) and sin(tau) that
    damping in the kernel would leave after some periods.
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
    """Return mean torques over the friction without and with theta_0, and the gain by theta_0."""
    c, errors = nondimensional(EXAMPLE), approximation_errors(session)
    torques = {
        name: float(abs(balance_residuals(APPROXIMATIONS[name](EXAMPLE), EXAMPLE)[2]))
        / float(c.zeta_m * c.alpha)
        for name in ("paper", "corrected")
    }
    return {
        **torques,
        "phase": float(corrected_solution(EXAMPLE).theta_0),
        "gain": errors["paper"][1] / errors["corrected"][1],
    }


def dropped_torque(session: Session) -> Numbers:
    """Return the change of u_1 by terms of second order where |u_1| < 0.5 in figure 4.

    The median, the largest, and the share of the points at which it is a tenth or less.
    """
    paper, full = (solve(grid(session, False)).u_1 for solve in (paper_solution, refined_solution))
    gap = np.abs(np.abs(full / paper) - 1)[np.abs(paper) < 0.5]
    return {"median": np.median(gap), "largest": np.max(gap), "within": np.mean(gap <= 0.1)}


def closed_form(session: Session) -> Numbers:
    """Return the largest residual of (49)-(52) over the grids of figures 4 and 6."""
    residuals = [paper_solution(grid(session, plate)).residual for plate in PLATES]
    return {"residual": np.max(residuals)}


# Section 4


def effect_of_55(session: Session) -> Numbers:
    """Return multipliers and stable shares of figure 4 with (55) as printed, and corrected."""
    solution = paper_solution(EXAMPLE)
    multipliers = [
        float(abs(floquet_multipliers(solution, EXAMPLE, as_printed)[0]))
        for as_printed in (True, False)
    ]
    shares = [float(np.mean(stable(session, False, name))) for name in ("printed", "paper")]
    return {"multipliers": multipliers, "shares": shares}


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
    """Return the share of the period with an eigenvalue of A(tau) above 1; the multiplier."""
    solution = corrected_solution(EXAMPLE)
    return {
        "above": np.mean(rate_moduli(solution).max(axis=1) > 1),
        "largest": float(abs(floquet_multipliers(solution, EXAMPLE)[0])),
    }

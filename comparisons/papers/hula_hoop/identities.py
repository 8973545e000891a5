"""Measures of the hula_hoop paper's equations (1)-(8), (16)-(61): each against what it comes from.

Expansions are taken at one motion of the form (16), (17) that solves nothing, `TRIAL`, whose
derivatives are those of its Fourier series.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from math import factorial
from typing import Any

import numpy as np
from scipy.special import jv

from ....reference import get_scene
from ....reference.differences import lagrange_terms
from ....reference.hula_hoop.equations import SEMICIRCLE, HulaHoop, coefficients, drive, energy
from ....reference.hula_hoop.theory import balance_residuals, nondimensional, paper_solution
from ....reference.scene import Array
from ..ledger import Numbers
from ..session import Session
from .derivation import PHASES, TRIAL, residual_of_7_8
from .results import EXAMPLE, SCENE

PLATE = EXAMPLE.replace(inertia_ratio=SEMICIRCLE)
BODIES = (EXAMPLE, PLATE)


# Section 2


def printed_kinetic(q: Any, v: Any, p: HulaHoop) -> Any:
    """Return T of (1), multiplied out as in its second line."""
    own = v[0] ** 2 + 2 * p.rod_length * v[0] * v[1] * np.cos(q[1]) + (p.rod_length * v[1]) ** 2
    inertia = p.inertia_ratio * p.free_mass * p.rod_length**2
    return (p.main_mass * v[0] ** 2 + p.free_mass * own + inertia * v[1] ** 2) / 2


def printed_potential(q: Any, p: HulaHoop) -> Any:
    """Return V of (2)."""
    return p.stiffness * q[0] ** 2 / 2


def random_motions() -> list[Array]:
    """Return y, theta and their rates (2, 2), 16 of them."""
    random = np.random.default_rng(1)
    scales = np.array([[0.01, 1], [1, 20]])
    return [np.asarray(random.normal(size=(2, 2)) * scales) for _ in range(16)]


def printed_energies(session: Session) -> Numbers:
    """Return by how much both lines of (1), with (2), miss the scene's energy, relative."""
    errors = []
    for p in BODIES:
        for (y, theta), (y_dot, turn) in random_motions():
            x_f = -p.rod_length * turn * np.sin(theta)
            y_f = y_dot + p.rod_length * turn * np.cos(theta)
            spin = p.inertia_ratio * p.free_mass * (p.rod_length * turn) ** 2
            first = (p.main_mass * y_dot**2 + p.free_mass * (x_f**2 + y_f**2) + spin) / 2
            second = printed_kinetic((y, theta), (y_dot, turn), p)
            truth = energy((y, theta), (y_dot, turn), coefficients(p))
            stored = printed_potential((y,), p)
            errors += [abs((kinetic + stored) / truth - 1) for kinetic in (first, second)]
    return {"error": max(errors)}


def lagrange(session: Session) -> Numbers:
    """Return what the scene's accelerations leave of (3)-(8) at random states.

    Of (3), (4) with (1), (2) and the forces below them, and of (5), (6), over the largest term of
    each in all states; and of (7), (8).
    """
    left: dict[str, float] = {"(3), (4)": 0.0, "(5), (6)": 0.0, "(7), (8)": 0.0}
    for p in BODIES:
        c, arm = coefficients(p), p.free_mass * p.rod_length
        damping = 2 * p.damping_ratio * (p.main_mass + p.free_mass) * p.omega_n  # below (8)
        friction = p.hinge_damping_ratio * arm * p.rod_length * p.omega_n
        kinetic, potential = partial(printed_kinetic, p=p), partial(printed_potential, p=p)
        terms: dict[str, list[Any]] = {"(3), (4)": [], "(5), (6)": []}
        for i, (q, v) in enumerate(random_motions()):
            time = 0.11 * i
            a = np.array(get_scene(SCENE).accelerations(drive(time, c), q, v, c))
            push = p.force_amplitude * np.cos(2 * np.pi * p.force_frequency * time)
            forces = np.array([push - damping * v[0], -friction * v[1]])
            cos, sin = np.cos(q[1]), np.sin(q[1])
            printed = (
                ((p.main_mass + p.free_mass) * a[0], arm * p.rod_length * a[1]),
                (arm * a[1] * cos, p.inertia_ratio * arm * p.rod_length * a[1]),
                (-arm * v[1] ** 2 * sin, arm * a[0] * cos),
                (p.stiffness * q[0], 0.0),
            )
            own = lagrange_terms(kinetic, potential, q, v, a)
            terms["(3), (4)"].append([*own, -forces])
            terms["(5), (6)"].append([*printed, -forces])
            state, rates = np.concatenate([q, v])[None], a[None]
            in_7_8 = residual_of_7_8(np.array([time]), state, rates, p)
            left["(7), (8)"] = max(left["(7), (8)"], in_7_8)
        for name, every in terms.items():
            sizes = np.max(np.abs(every), axis=(0, 1))
            worst = np.max(np.abs(np.sum(every, axis=1)) / sizes)
            left[name] = max(left[name], float(worst))
    return {"left": left, "largest": max(left.values())}


# Section 3: terms of (7), (8) along the trial motion


def slopes(values: Any) -> tuple[Array, Array]:
    """Return two derivatives in tau of samples (..., n) over `PHASES`, by their Fourier series."""
    spectrum = np.fft.rfft(values)
    factor = 1j * TRIAL.alpha * np.arange(spectrum.shape[-1])
    first, second = (np.fft.irfft(spectrum * factor**k, len(PHASES)) for k in (1, 2))
    return first, second


def printed_trial() -> tuple[Array, Array]:
    """Return q and theta by (53), (54) without the perturbations: (16), (17), (37), (48)."""
    f_q, f_u, tau = TRIAL.alpha, 2 * TRIAL.alpha, PHASES / TRIAL.alpha
    q = TRIAL.q_1 * np.cos(f_q * tau - TRIAL.beta)
    return q, TRIAL.alpha * tau + TRIAL.u_1 * np.cos(f_u * tau - TRIAL.gamma)


def trial() -> tuple[Array, Array, Array, Array, Array, Array]:
    """Return q, q', q'', theta, theta', theta'' of it."""
    q, theta = printed_trial()
    turn, bend = slopes(theta - PHASES)
    return q, *slopes(q), theta, TRIAL.alpha + turn, bend


def linear_terms(session: Session) -> Numbers:
    """Return by how much linear terms of (32) and (42) miss those of (7), (8) along (23), (40)."""
    c, (q, q_1, q_2, _, turn, bend) = nondimensional(PLATE), trial()
    a, size, u, b, g = TRIAL.alpha, TRIAL.q_1, TRIAL.u_1, TRIAL.beta, TRIAL.gamma
    f_u, inertia, friction = 2 * a, c.inertia, c.zeta_m
    in_32 = -size * a**2 * np.cos(PHASES - b) - 2 * c.rho * size * a * np.sin(PHASES - b)
    in_32 += size * np.cos(PHASES - b)
    sine, cosine = np.sin(2 * PHASES), np.cos(2 * PHASES)
    in_42 = -inertia * u * f_u**2 * (np.cos(g) * cosine + np.sin(g) * sine) + friction * a
    in_42 += -friction * u * f_u * np.cos(g) * sine + friction * u * f_u * np.sin(g) * cosine
    slide, hinge = q_2 + 2 * c.rho * q_1 + q, inertia * bend + friction * turn
    return {"error": np.max(np.abs([slide - in_32, hinge - in_42]))}


def products(session: Session) -> Numbers:
    """Return by how much the lines of (24) and (29) miss theta'^2 sin(theta), theta'' cos(theta).

    The last line of (24) with what it has lost.
    """
    _, _, _, theta, turn, bend = trial()
    a, u, f_u, psi = TRIAL.alpha, TRIAL.u_1, 2 * TRIAL.alpha, 2 * PHASES - TRIAL.gamma
    wave, sine, cosine = u * f_u * np.sin(psi), np.sin(PHASES), np.cos(PHASES)
    even, odd = np.cos(u * np.cos(psi)), np.sin(u * np.cos(psi))
    square, swing = a**2 - 2 * a * wave + wave**2, -u * f_u**2 * np.cos(psi)
    in_24 = (
        (a - wave) ** 2 * np.sin(PHASES + u * np.cos(psi)),
        square * (sine * even + cosine * odd),
        square * sine * even + square * cosine * odd,
    )
    in_29 = (
        swing * np.cos(PHASES + u * np.cos(psi)),
        swing * (cosine * even - sine * odd),
        swing * cosine * even - swing * sine * odd,
    )
    errors = [one - turn**2 * np.sin(theta) for one in in_24]
    errors += [one - bend * np.cos(theta) for one in in_29]
    return {"error": np.max(np.abs(errors))}


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


def harmonic(values: Array, order: int) -> tuple[float, float]:
    """Return the coefficients of cosine and sine of one order in samples over `PHASES`."""
    wave = np.mean(2 * values * np.exp(1j * order * PHASES))
    return wave.real, wave.imag


def expansions(session: Session) -> Numbers:
    """Return errors of (28), of (31), and of (42) with its mean (44), at `TRIAL`."""
    _, _, pull, theta, turn, bent = trial()
    a, u, g, b = TRIAL.alpha, TRIAL.u_1, TRIAL.gamma, TRIAL.beta
    j, f = jv(np.arange(4), u), 2 * TRIAL.alpha
    sin, cos = np.sin(g), np.cos(g)
    square, mixed, bend = u**2 * f**2 / 2, -2 * a * u * f, -u * f**2
    both = (a**2 + square) * j[1] + mixed * (j[0] + j[2]) / 2 - square * (j[1] - j[3]) / 2
    in_28 = both * cos, (a**2 + square) * j[0] + both * sin + square * j[2]
    in_31 = bend * (j[0] - j[2]) / 2 * cos, -bend * j[1] + bend * (j[0] - j[2]) / 2 * sin
    half = -TRIAL.q_1 * a**2 / 2
    in_42 = (
        half * (j[0] * np.cos(b) - j[2] * np.cos(b - 2 * g))
        - half * j[1] * (np.sin(b + g) + np.sin(b - g)),
        half * (j[0] * np.sin(b) + j[2] * np.sin(b - 2 * g))
        + half * j[1] * (np.cos(b + g) - np.cos(b - g)),
    )
    torque = pull * np.cos(theta)
    pairs: dict[str, tuple[Any, Any]] = {
        "(28)": (in_28, harmonic(turn**2 * np.sin(theta), 1)),
        "(31)": (in_31, harmonic(bent * np.cos(theta), 1)),
        "(42)": (in_42, harmonic(torque, 2)),
        "its mean": (half * (j[0] * np.cos(b) + j[1] * np.sin(b - g)), np.mean(torque)),
    }
    errors = {name: float(np.max(np.abs(np.subtract(*pair)))) for name, pair in pairs.items()}
    return {"errors": errors, "largest": max(errors.values())}


def first_order(session: Session) -> Numbers:
    """Return by how much (36), (46) and (47) miss the harmonics of (7), (8) at small amplitudes.

    Over the amplitudes, to which they are of first order.
    """
    c, size = nondimensional(PLATE), 1e-6
    a, q_1, u_1, b, g = c.alpha, TRIAL.q_1 * size, TRIAL.u_1 * size, TRIAL.beta, TRIAL.gamma
    small = replace(TRIAL, alpha=a, q_1=q_1, u_1=u_1)
    along, _, _, cosine, sine = balance_residuals(small, PLATE)
    damped, heavy = 2 * c.zeta_m * u_1 * a, 4 * c.inertia * a**2 * u_1
    in_36 = q_1 * ((1 - a**2) * np.cos(b) + 2 * c.rho * a * np.sin(b))
    in_36 -= c.epsilon * a**2 * u_1 * np.cos(g) / 2 + c.force
    in_46 = -heavy * np.sin(g) - damped * np.cos(g) - q_1 * a**2 * np.sin(b) / 2
    in_47 = -heavy * np.cos(g) + damped * np.sin(g) - q_1 * a**2 * np.cos(b) / 2
    errors = {"(36)": along - in_36, "(46)": sine - in_46, "(47)": cosine - in_47}
    return {
        "errors": {name: float(abs(error)) / q_1 for name, error in errors.items()},
        "largest": float(max(abs(error) for error in errors.values())) / q_1,
    }


def correction(s: float, c: float, alpha: float) -> tuple[Array, Array]:
    """Return tau (400,), and (34) or (45) with two derivatives; s, c stand with sine and cosine."""
    tau = np.linspace(0, 40, 400)
    scales = np.array([s * alpha, c, -s, -c])[:, None] / (1 - alpha**2)
    speeds = np.array([1, 1, alpha, alpha])[:, None]
    starts = np.array([0, np.pi / 2, 0, np.pi / 2])[:, None]  # sine, cosine, sine, cosine
    waves = [
        np.sum(scales * speeds**k * np.sin(speeds * tau + starts + k * np.pi / 2), axis=0)
        for k in range(3)
    ]
    return tau, np.array(waves)


def solution_34(session: Session) -> Numbers:
    """Return by how much (34) misses V'' + V = -(S sin(alpha tau) + C cos(alpha tau)), and rest."""
    alpha, s, c = float(nondimensional(PLATE).alpha), 0.7, -0.4
    tau, (value, rate, bent) = correction(s, c, alpha)
    left = np.max(abs(bent + value + s * np.sin(alpha * tau) + c * np.cos(alpha * tau)))
    return {"error": float(max(left, abs(value[0]), abs(rate[0])))}


def approximations(session: Session) -> Numbers:
    """Return the largest corrections (34) and (45) by (49)-(52), over q_1 and u_1."""
    solution, c = paper_solution(PLATE), nondimensional(PLATE)
    a, q_1, u_1, b, g = (
        float(getattr(solution, name)) for name in ("alpha", "q_1", "u_1", "beta", "gamma")
    )
    spring, damper, inertial = (1 - a**2) * q_1, 2 * c.rho * q_1 * a, c.epsilon * a**2
    in_34 = (
        spring * np.sin(b) - damper * np.cos(b) - inertial,
        spring * np.cos(b) + damper * np.sin(b) - inertial * u_1 * np.cos(g) / 2 - c.force,
    )
    heavy, friction = 4 * c.inertia * a**2 * u_1, 2 * c.zeta_m * u_1 * a
    in_45 = (
        -heavy * np.sin(g) - friction * np.cos(g) + q_1 * a**2 * np.sin(-b) / 2,
        -heavy * np.cos(g) + friction * np.sin(g) - q_1 * a**2 * np.cos(-b) / 2,
    )
    of_q, of_theta = correction(*in_34, a)[1][0], correction(*in_45, 2 * a)[1][0]
    return {"of_q": np.max(np.abs(of_q / q_1)), "of_theta": np.max(np.abs(of_theta / u_1))}


# Section 4


def variations(session: Session) -> Numbers:
    """Return by how much (55), put right, and (56)-(61) miss (7), (8) along (53) and (54).

    The perturbations are two waves of our choice, and so small that their squares vanish.
    """
    c, tiny = nondimensional(PLATE), 1e-30
    q_wave, theta_wave = np.cos(3 * PHASES + 0.2), np.sin(PHASES) - 0.7 * np.cos(4 * PHASES)
    waves = q_wave, *slopes(q_wave), theta_wave, *slopes(theta_wave)
    q, q_1, q_2, theta, turn, bend = (
        base + 1j * tiny * wave for base, wave in zip(trial(), waves, strict=True)
    )
    coupling = bend * np.cos(theta) - turn**2 * np.sin(theta)
    slide = q_2 + 2 * c.rho * q_1 + q + c.epsilon * coupling
    hinge = bend + (c.zeta_m * turn + q_2 * np.cos(theta)) / c.inertia
    f_q, f_u = TRIAL.alpha, 2 * TRIAL.alpha
    psi, eta = 2 * PHASES - TRIAL.gamma, PHASES - TRIAL.beta
    theta_b, wave = PHASES + TRIAL.u_1 * np.cos(psi), -TRIAL.u_1 * f_u * np.sin(psi)
    p_1, p_2 = c.epsilon * np.cos(theta_b), -2 * c.epsilon * (wave + f_q) * np.sin(theta_b)
    square = f_q**2 + wave**2 + 2 * f_q * wave
    bent = -TRIAL.u_1 * f_u**2 * np.cos(psi)
    p_3 = -c.epsilon * (square * np.cos(theta_b) + bent * np.sin(theta_b))
    p_4 = TRIAL.q_1 * f_q**2 * np.cos(eta) * np.sin(theta_b) / c.inertia
    p_5 = np.cos(theta_b) / c.inertia
    a, a_1, a_2, b, b_1, b_2 = waves  # q~ and theta~ with their derivatives
    in_55 = a_2 + 2 * c.rho * a_1 + a + p_1 * b_2 + p_2 * b_1 + p_3 * b
    in_56 = b_2 + c.zeta_m / c.inertia * b_1 + p_4 * b + p_5 * a_2
    off = [slide.imag / tiny - in_55, hinge.imag / tiny - in_56]
    return {"error": np.max(np.abs(off)) / np.max(np.abs(in_55))}

"""Equations of the hula_hoop paper: (1)-(8), (24)-(61) as printed, put right and derived.

They are taken along one motion of the form (16), (17) that solves nothing, `TRIAL`, with
s = alpha tau. Where a motion is not needed, values are random.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import factorial

import numpy as np
from scipy.special import jv

from ....reference import get_scene
from ....reference.equations import scene_equations
from ....reference.hula_hoop.equations import (
    SEMICIRCLE,
    coefficients,
    drive,
    energy,
)
from ....reference.hula_hoop.theory import nondimensional, paper_solution, printed_residuals
from ...checks.truth import random_states
from ...engines.registry import REFERENCE
from ...engines.run import contained
from ...queries.query import choose_engine
from ...queries.request import Query
from ..equations import Identities, Values
from ..ledger import Numbers
from ..session import Session
from .derivation import PHASES, TRIAL
from .results import EXAMPLE, SCENE

PLATE = EXAMPLE.replace(inertia_ratio=SEMICIRCLE)


def motion(q: str = "q_1*cos(eta)", theta: str = "s + u_1*cos(psi)") -> str:
    """Return (16), (17), (37), (48), and the left-hand sides of (7), (8) along them."""
    return f"""
        f_u = 2*alpha
        psi = 2*s - gamma
        eta = s - beta
        q = {q}
        theta = {theta}
        pull = alpha**2*d(q, s, 2)
        turn = alpha*d(theta, s)
        bend = alpha**2*d(theta, s, 2)
        coupling = bend*cos(theta) - turn**2*sin(theta)
        slide = pull + 2*rho*alpha*d(q, s) + q + epsilon*coupling
        hinge = inertia*bend + zeta_m*turn + pull*cos(theta)
        """


def moved(theta_wave: str) -> str:
    """Return the same with perturbations of size h, (53), (54), and the coefficients (57)-(61)."""
    return f"""
        q_wave = cos(3*s + 0.2)
        theta_wave = {theta_wave}
        {motion("q_1*cos(eta) + h*q_wave", "s + u_1*cos(psi) + h*theta_wave").strip()}
        theta_b = s + u_1*cos(psi)
        wave = -u_1*f_u*sin(psi)
        p_1 = epsilon*cos(theta_b)
        p_2 = -2*epsilon*(wave + alpha)*sin(theta_b)
        p_3 = -epsilon*((alpha**2 + wave**2 + 2*alpha*wave)*cos(theta_b)
            - u_1*f_u**2*cos(psi)*sin(theta_b))
        p_4 = q_1*alpha**2*cos(eta)*sin(theta_b)/inertia
        p_5 = cos(theta_b)/inertia
        """


NUMBERS = {name: float(value) for name, value in nondimensional(EXAMPLE)._asdict().items()}
ALONG = NUMBERS | {name: vars(TRIAL)[name] for name in ("alpha", "q_1", "beta", "u_1", "gamma")}
ALONG |= {"s": PHASES}
"""Coefficients of (7), (8), and with them the values of the trial motion over a turn."""

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


BODY = """
    mass = M + m
    T = (M*y_v**2 + m*(y_v**2 + 2*R*y_v*theta_v*cos(theta) + (R*theta_v)**2)
        + I_m*m*R**2*theta_v**2)/2
    V = k*y**2/2
    push = F*cos(2*pi*f*t) - 2*rho*mass*omega_n*y_v
    friction = zeta_m*m*R**2*omega_n*theta_v
    p_y = d(T, y_v)
    p_theta = d(T, theta_v)
    q_a = y_a/(R*omega_n**2)
    turn = theta_v/omega_n
    bend = theta_a/omega_n**2
    """
"""(1) as its second line has it, (2), the forces below (4), momenta, and rates in tau."""

IDENTITIES: Mapping[str, Identities] = {
    "lost_dots": Identities(
        """
        at(d(cos(a + v*t), t), t, 0) = -v*sin(a)
        printed = -a*sin(a)
        """,
        values={"a": 0.7, "v": 3.0},
    ),
    "square_25": Identities(
        """
        turn**2 * sin(theta) = (alpha**2 - 2*alpha*u_1*f_u*sin(psi)
            + (u_1*f_u*sin(psi))**2)*sin(theta)
        printed = (alpha**2 - 2*u_1*f_u*sin(psi) + (u_1*f_u*sin(psi))**2)*sin(theta)
        """,
        motion(), ALONG,
    ),
    "expansion_30": Identities(
        """
        bend*cos(theta) = bend*(cos(s)*even - sin(s)*odd)
        printed = bend*cos(s)*even - bend + 4*J(5, u_1)*cos(5*psi)
        """,
        motion() + """
        even = J(0, u_1) - 2*J(2, u_1)*cos(2*psi) + 2*J(4, u_1)*cos(4*psi)
        odd = 2*J(1, u_1)*cos(psi) - 2*J(3, u_1)*cos(3*psi) + 2*J(5, u_1)*cos(5*psi)
        """,
        ALONG,
    ),
    "lost_term_35": Identities(
        """
        linear(2*mean(slide*sin(s), s), u_1)/u_1 = (balance - epsilon*alpha**2*u_1*sin(gamma)/2)/u_1
        printed = balance/u_1
        """,
        motion() + """
        balance = (1 - alpha**2)*q_1*sin(beta) - 2*rho*q_1*alpha*cos(beta) - epsilon*alpha**2
        """,
        ALONG | {"s": 0.0},
    ),
    "product_41": Identities(
        """
        2*mean(pull*cos(theta)*cos(2*s), s) = -q_1*alpha**2/2*(J(0, u_1)*cos(beta)
            - J(2, u_1)*cos(beta - 2*gamma) + J(1, u_1)*sin(-beta - gamma)
            - J(1, u_1)*sin(beta - gamma))
        printed = -q_1*alpha**2/2*(J(0, u_1)*cos(beta) - J(2, u_1)*cos(beta - 2*gamma)
            + J(1, u_1) + 2*(-beta - gamma) - J(1, u_1)*sin(beta - gamma))
        """,
        motion(), ALONG | {"s": 0.0},
    ),
    "kernel_45": Identities(
        """
        -cos(f*t) = inertia*d(right, t, 2) + zeta_m*d(right, t)
        printed = inertia*d(wrong, t, 2) + zeta_m*d(wrong, t)
        """,
        """
        f = 2*alpha
        wrong = -(cos(f*t) - cos(t))/(1 - f**2)
        right = (f*inertia*cos(f*t) - zeta_m*sin(f*t))/(f*((f*inertia)**2 + zeta_m**2))
        """,
        NUMBERS | {"t": np.linspace(0, 40, 400)},
    ),
    "variational_55": Identities(
        """
        at(d(epsilon*coupling, h), h, 0) = p_1*alpha**2*d(theta_wave, s, 2)
            + p_2*alpha*d(theta_wave, s) + p_3*theta_wave
        printed = (p_1 + p_2)*alpha*d(theta_wave, s) + p_3*theta_wave
        """,
        moved("cos(3*s/alpha)"), ALONG,
    ),
    "energies": Identities(
        """
        (1): energy/T = (M*y_v**2/2 + m*((R*theta_v*sin(theta))**2
            + (y_v + R*theta_v*cos(theta))**2)/2 + I_m*m*(R*theta_v)**2/2 + V)/T
        (1): energy/T = (T + V)/T
        """,
        BODY, BODIES, dimensional,
    ),
    "lagrange": Identities(
        """
        (3), (4): push/force = (d(p_y, theta)*theta_v + d(p_y, y_v)*y_a + d(p_y, theta_v)*theta_a
            - d(T, y) + d(V, y))/force
        (3), (4): -friction/torque = (d(p_theta, theta)*theta_v + d(p_theta, y_v)*y_a
            + d(p_theta, theta_v)*theta_a - d(T, theta) + d(V, theta))/torque
        (5), (6): push/force = (mass*y_a + m*R*(theta_a*cos(theta) - theta_v**2*sin(theta))
            + k*y)/force
        (5), (6): -friction/torque = ((1 + I_m)*m*R**2*theta_a + m*R*y_a*cos(theta))/torque
        (7), (8): F/(mass*R*omega_n**2)*cos(2*pi*f*t)/q_a = (q_a + 2*rho*y_v/(R*omega_n) + y/R
            + m/mass*(bend*cos(theta) - turn**2*sin(theta)))/q_a
        (7), (8): -q_a*cos(theta)/bend = ((1 + I_m)*bend + zeta_m*turn)/bend
        """,
        BODY + """
    force = mass*y_a
    torque = m*R**2*theta_a
    """,
        BODIES, dimensional,
    ),
    "linear_terms": Identities(
        """
        slide - epsilon*coupling = -q_1*alpha**2*cos(eta) - 2*rho*q_1*alpha*sin(eta) + q_1*cos(eta)
        hinge - pull*cos(theta) = -inertia*u_1*f_u**2*(cos(gamma)*cos(2*s) + sin(gamma)*sin(2*s))
            + zeta_m*alpha - zeta_m*u_1*f_u*cos(gamma)*sin(2*s)
            + zeta_m*u_1*f_u*sin(gamma)*cos(2*s)
        """,
        motion(),
    ),
    "products": Identities(
        """
        turn**2 * sin(theta) = (alpha - wave)**2*sin(s + u_1*cos(psi))
        turn**2 * sin(theta) = square*(sin(s)*even + cos(s)*odd)
        turn**2 * sin(theta) = square*sin(s)*even + square*cos(s)*odd
        bend*cos(theta) = swing*cos(s + u_1*cos(psi))
        bend*cos(theta) = swing*(cos(s)*even - sin(s)*odd)
        bend*cos(theta) = swing*cos(s)*even - swing*sin(s)*odd
        """,
        motion() + """
        wave = u_1*f_u*sin(psi)
        square = alpha**2 - 2*alpha*wave + wave**2
        swing = -u_1*f_u**2*cos(psi)
        even = cos(u_1*cos(psi))
        odd = sin(u_1*cos(psi))
        """,
    ),
    "expansions": Identities(
        """
        (28): 2*mean(turn**2*sin(theta)*cos(s), s) = both*cos(gamma)
        (28): 2*mean(turn**2*sin(theta)*sin(s), s) = (alpha**2 + square)*J(0, u_1)
            + both*sin(gamma) + square*J(2, u_1)
        (31): 2*mean(bend*cos(theta)*cos(s), s) = -u_1*f_u**2*(J(0, u_1) - J(2, u_1))/2*cos(gamma)
        (31): 2*mean(bend*cos(theta)*sin(s), s) = u_1*f_u**2*J(1, u_1)
            - u_1*f_u**2*(J(0, u_1) - J(2, u_1))/2*sin(gamma)
        (42): 2*mean(pull*cos(theta)*cos(2*s), s) = half*(J(0, u_1)*cos(beta)
            - J(2, u_1)*cos(beta - 2*gamma) - J(1, u_1)*(sin(beta + gamma) + sin(beta - gamma)))
        (42): 2*mean(pull*cos(theta)*sin(2*s), s) = half*(J(0, u_1)*sin(beta)
            + J(2, u_1)*sin(beta - 2*gamma) + J(1, u_1)*(cos(beta + gamma) - cos(beta - gamma)))
        its mean: mean(pull*cos(theta), s) = half*(J(0, u_1)*cos(beta)
            + J(1, u_1)*sin(beta - gamma))
        """,
        motion() + """
        square = u_1**2*f_u**2/2
        half = -q_1*alpha**2/2
        both = (alpha**2 + square)*J(1, u_1) - alpha*u_1*f_u*(J(0, u_1) + J(2, u_1))
            - square*(J(1, u_1) - J(3, u_1))/2
        """,
    ),
    "first_order": Identities(
        """
        (36): at(d(2*mean(slide*cos(s), s), h), h, 0) = q_1*((1 - alpha**2)*cos(beta)
            + 2*rho*alpha*sin(beta)) - epsilon*alpha**2*u_1*cos(gamma)/2
        (46): at(d(2*mean(hinge*sin(2*s), s), h), h, 0) = -4*inertia*alpha**2*u_1*sin(gamma)
            - 2*zeta_m*u_1*alpha*cos(gamma) - q_1*alpha**2*sin(beta)/2
        (47): at(d(2*mean(hinge*cos(2*s), s), h), h, 0) = -4*inertia*alpha**2*u_1*cos(gamma)
            + 2*zeta_m*u_1*alpha*sin(gamma) - q_1*alpha**2*cos(beta)/2
        """,
        motion("h*q_1*cos(eta)", "s + h*u_1*cos(psi)"),
    ),
    "solution_34": Identities(
        """
        -(S*sin(a*t) + C*cos(a*t)) = d(v, t, 2) + v
        0*t = at(v, t, 0)
        0*t = at(d(v, t), t, 0)
        """,
        "v = (S*(a*sin(t) - sin(a*t)) + C*(cos(t) - cos(a*t)))/(1 - a**2)",
    ),
    "coefficients_57": Identities(
        """
        at(d(slide, h), h, 0) = alpha**2*d(q_wave, s, 2) + 2*rho*alpha*d(q_wave, s) + q_wave
            + p_1*alpha**2*d(theta_wave, s, 2) + p_2*alpha*d(theta_wave, s) + p_3*theta_wave
        at(d(hinge/inertia, h), h, 0) = alpha**2*d(theta_wave, s, 2)
            + zeta_m/inertia*alpha*d(theta_wave, s) + p_4*theta_wave
            + p_5*alpha**2*d(q_wave, s, 2)
        """,
        moved("sin(s) - 0.7*cos(4*s)"),
    ),
}  # fmt: skip
"""Those of a row, by its name."""


def equations_of_motion(session: Session, who: str) -> Numbers:
    """Return errors at random states: of (7), (8), or of the accelerations of an engine."""
    if who == REFERENCE:
        error = IDENTITIES["lagrange"](session)["(7), (8)"]
        return {"error": error, "count": len(BODIES["I_m"])}
    case, scene = Query(SCENE).case, get_scene(SCENE)
    times, points = random_states(scene_equations(case), case, scene.coordinates)
    derivative = scene.right_hand_side(case.parameters)
    truth = np.array([derivative(t, x)[2:] for t, x in zip(times, points, strict=True)])
    engine, model = choose_engine(who, case, None)
    with contained():
        own = engine.bind(case, model).accelerations(times, points)
    return {"error": float(np.abs(own - truth).max() / np.abs(truth).max())}


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


def approximations(session: Session) -> Numbers:
    """Return bounds of the corrections (34) and (45) by (49)-(52), over q_1 and u_1.

    The residuals of (35), (36), (46), (47) are their coefficients of sine and cosine.
    """
    solution = paper_solution(PLATE)
    left = np.abs(printed_residuals(solution, PLATE)).reshape(2, 2).max(axis=1)
    a = np.array([1, 2]) * float(solution.alpha)
    of_q, of_theta = left * (a + 3) / abs(1 - a**2) / np.abs([solution.q_1, solution.u_1])
    return {"of_q": of_q, "of_theta": of_theta}

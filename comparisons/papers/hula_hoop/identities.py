"""Equations of the hula_hoop paper: (1)-(8), (24)-(61) as printed, put right and derived.

They are taken along one motion of the form (16), (17) that solves nothing, `TRIAL`, with
s = alpha tau. Where a motion is not needed, values are random.
"""

from __future__ import annotations

from math import factorial

import numpy as np
from scipy.special import jv

from ....reference import get_scene
from ....reference.hula_hoop.equations import SEMICIRCLE, HulaHoop, coefficients, drive, energy
from ....reference.hula_hoop.floquet import floquet_multipliers
from ....reference.hula_hoop.theory import nondimensional, paper_solution, printed_residuals
from ....reference.scene import Array
from ...checks.kinds.algebra import random_states
from ...engines.equations import scene_equations
from ...engines.registry import REFERENCE
from ...engines.run import contained
from ...queries.query import choose_engine
from ...queries.request import Query
from ..claims import equations_of
from ..equations import Values
from ..ledger import Numbers
from ..session import Session
from .derivation import PHASES, TRIAL
from .results import EXAMPLE, SCENE, grid, stable

PLATE = EXAMPLE.replace(inertia_ratio=SEMICIRCLE)


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


def restored(p: HulaHoop) -> Array:
    """Return |u_1| (2, ...) of (35), (36), (46), (47), without and with what (35) has lost."""
    c = nondimensional(p)
    stiffness, damping = 1 - c.alpha**2, 2 * c.rho * c.alpha
    inertial, inertia = c.epsilon * c.alpha**2, 4 * c.alpha**2 * c.inertia
    friction, half = 2 * c.zeta_m * c.alpha, c.alpha**2 / 2
    sizes = []
    for lost in (0.0, inertial / 2):
        rows = (  # unknowns q_1 cos beta, q_1 sin beta, u_1 cos gamma, u_1 sin gamma
            (-damping, stiffness, 0, -lost),
            (stiffness, damping, -inertial / 2, 0),
            (0, -half, -friction, -inertia),
            (-half, 0, -inertia, friction),
        )
        shape = np.broadcast_shapes(np.shape(c.alpha), np.shape(c.force))
        matrix = np.array([[np.broadcast_to(value, shape) for value in row] for row in rows])
        right = np.array([np.broadcast_to(v, shape) for v in (inertial, c.force, 0, 0)])
        x = np.linalg.solve(
            np.moveaxis(matrix, (0, 1), (-2, -1)), np.moveaxis(right, 0, -1)[..., None]
        )
        sizes.append(np.hypot(x[..., 2, 0], x[..., 3, 0]))
    return np.array(sizes)


def change_of_u_1(session: Session) -> Numbers:
    """Return by how much what (35) has lost changes u_1, at 3 Hz and 60 N and in figure 4."""
    changes = []
    for p in (EXAMPLE, grid(session, False)):
        without, with_it = restored(p)
        changes.append(float(np.max(np.abs(with_it / without - 1))))
    return {"changes": changes}


def effect_of_55(session: Session) -> Numbers:
    """Return multipliers and stable shares of figure 4 with (55) as printed, and corrected."""
    solution = paper_solution(EXAMPLE)
    multipliers = [
        float(abs(floquet_multipliers(solution, EXAMPLE, as_printed)[0]))
        for as_printed in (True, False)
    ]
    shares = [float(np.mean(stable(session, False, name))) for name in ("printed", "paper")]
    return {"multipliers": multipliers, "shares": shares}


def mass_ratio(session: Session) -> Numbers:
    """Return m/(M + m) of table 1."""
    return {"value": float(nondimensional(HulaHoop()).epsilon)}


def equations_of_motion(session: Session, who: str) -> Numbers:
    """Return errors at random states: of (7), (8), or of the accelerations of an engine."""
    if who == REFERENCE:
        error = equations_of(SCENE, "lagrange")(session)["(7), (8)"]
        return {"error": error, "count": len(BODIES["I_m"])}
    case, scene = Query(SCENE).case, get_scene(SCENE)
    times, points = random_states(scene_equations(case), case, scene.coordinates)
    derivative = scene.right_hand_side(case.parameters)
    truth = np.array([derivative(t, x)[2:] for t, x in zip(times, points, strict=True)])
    engine, model = choose_engine(who, case, None)
    with contained():
        own = engine.accelerations(case, model, times, points)
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

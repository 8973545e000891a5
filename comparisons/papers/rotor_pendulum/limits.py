"""Limits of the rotor_pendulum paper's theory: where orbits begin, speeds, small parameters.

The theory of figure 3 has a phase everywhere. With the dampers of table 1 the synchronous orbit
begins at a fold, which is followed over n_x here.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ....reference import get_scene
from ....reference.continuation.along import BoundaryAlong
from ....reference.rotor_pendulum import CASE_1, CASE_2, theory
from ....reference.rotor_pendulum.equations import RotorPendulum, coefficients, operating_speed
from ....reference.rotor_pendulum.phase import wrapped
from ....reference.scene import Array
from ..ledger import REPRODUCED, Numbers, below, holds, statement
from ..session import Session
from .results import BETAS, CASES, SCENE, orbit_value, settled, synchronous_orbit

STARTS: Mapping[str, Mapping[float, float]] = {
    "pi/6": {2.0: 1.7, 3.0: 1.8, 7.0: 2.0},
    "pi/3": {2.0: 2.1, 3.0: 2.65, 7.0: 3.4},
}
"""By installation angle and n_x: an n_phi with an orbit, near the fold at which it begins."""


def at_ratios(n_x: float, n_phi: float, beta: float) -> RotorPendulum:
    """Return the parameters of a point of figure 3, with the dampers of table 1."""
    c, speed = coefficients(CASE_1), float(operating_speed(CASE_1))
    return CASE_1.replace(
        installation_angle=beta,
        platform_stiffness=float(c.mass) * (speed / n_x) ** 2,
        rod_stiffness=float(c.end_mass * c.length**2) * (speed / n_phi) ** 2,
    )


def folds(session: Session, angle: str) -> list[BoundaryAlong]:
    """Return where the synchronous orbit begins along k_phi, for each n_x."""
    return session.once(
        (SCENE, "folds", angle),
        lambda: [
            BoundaryAlong(
                get_scene(SCENE), at_ratios(n_x, n_phi, BETAS[angle]), "fold", "rod_stiffness"
            )
            for n_x, n_phi in STARTS[angle].items()
        ],
    )


def ratio_of(one: BoundaryAlong, place: float) -> float:
    """Return n_phi at a place of the window."""
    p = one.parameters.replace(rod_stiffness=one.value(place))
    return float(theory.ratios(p).n_phi)


def fold_curve(session: Session, angle: str) -> tuple[Array, Array]:
    """Return n_x and n_phi of the points at which the synchronous orbit begins."""
    places = [ratio_of(one, one.solution[1].place[1]) for one in folds(session, angle)]
    return np.array(list(STARTS[angle])), np.array(places)


SMALLER = (1.0, 1 / 4, 1 / 16, 1 / 64)
"""Factors of rotor masses and dampers: the small parameter."""


def small_parameter(session: Session) -> Numbers:
    """Return how far orbits are from the theory's phase [rad] as rotors get lighter, and the order.

    And that with the rod's mass and spring smaller, too, and dampers weaker still.
    Case 2, dampers in proportion to the masses, motors and bearings to their square, as
    the torque by which vibration couples them.
    """
    sets = [
        CASE_2.replace(
            rotor_mass=CASE_2.rotor_mass * mu,
            platform_damping=CASE_2.platform_damping * mu,
            rod_damping=CASE_2.rod_damping * mu,
            motor_slope=CASE_2.motor_slope * mu**2,
            friction=CASE_2.friction * mu**2,
        )
        for mu in SMALLER
    ]
    phases = [float(theory.stable_phase_difference(theory.ratios(p))) for p in sets]
    orbits = settled(session, sets)
    gaps = [abs(float(wrapped(o.phase - alpha))) for o, alpha in zip(orbits, phases, strict=True)]
    light = sets[-1].replace(
        rod_mass=CASE_2.rod_mass * SMALLER[-1],
        rod_stiffness=CASE_2.rod_stiffness * SMALLER[-1],
        rod_damping=CASE_2.rod_damping * SMALLER[-1] ** 3,
        platform_damping=CASE_2.platform_damping * SMALLER[-1] ** 2,
    )
    (other,) = settled(session, [light])
    alpha = float(theory.stable_phase_difference(theory.ratios(light)))
    order = np.log(gaps[-2] / gaps[-1]) / np.log(SMALLER[-2] / SMALLER[-1])
    return {"gaps": gaps, "order": order, "off": abs(order - 1), "factors": SMALLER,
            "other": abs(float(wrapped(other.phase - alpha))), "kind": other.kind}  # fmt: skip


def speed_and_phase(session: Session) -> Numbers:
    """Return what (26) and (30), (36) have: speeds and stable phases of cases 1 and 2, how many.

    And the mean speeds of the orbits [rad/s].
    """
    c = coefficients(CASE_1)
    rates = np.linspace(0, float(CASE_1.synchronous_speed), 4097)
    excess = c.slope * (c.speed - rates) - c.friction * rates
    alpha, phases = np.linspace(-np.pi, np.pi, 4098), []
    for case in (1, 2):
        n = theory.ratios(CASES[case])
        crossings = np.diff(np.sign(theory.balance(n, alpha))) != 0
        phases.append(int(np.sum(crossings & (theory.stability(n, alpha[1:]) > 0))))
    orbits = [orbit_value(synchronous_orbit(session, CASES[i]), "mean_speed") for i in (1, 2)]
    return {
        "speeds": float(operating_speed(CASE_1)),
        "orbits": orbits,
        "roots": int(np.sum(np.diff(np.sign(excess)) != 0)),
        "phases": phases,
    }


SMALL_PARAMETER = statement(
    "small_parameter", "equations (1)-(6)",
    "For a small enough parameter a root of (4) that satisfies (6) belongs to a stable motion.",
    REPRODUCED,
    "phase of the stable orbit less that of the theory, case 2 with the rotors' masses and the "
    "dampers times {factors:.3g}, motors and bearings times the squares of these, as the torque "
    "that couples them: {gaps:.2g} rad, falling with the order {order:.2f}. It is 2.2's m_1, m_2 "
    "that must be small: with the rod as light as the rotors, and dampers weaker still, the last "
    "gap is {other:.2g} rad ({kind}). With table 1's masses and dampers the parameter is not small",
    small_parameter, judgement=holds(below("off", 0.05)), slow=True,
)  # fmt: skip

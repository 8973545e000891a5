"""The ledger of the speed_regulator paper: what it derives, sections 1-3 up to equation (20)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.integrate import quad

from ....reference import get_scene
from ....reference.errors import NoOrbitError
from ....reference.speed_regulator.equations import coefficients, inertia, outputs, position
from ....reference.speed_regulator.orbit import mean_speed
from ....reference.speed_regulator.rest import static_torque
from ....reference.speed_regulator.theory import least_torque, printed_mean_speed, rotation
from ...queries.query import Query, call_engine, choose_engine
from ...queries.simulate import simulate
from ..ledger import CORRECTED, NOT_REPRODUCED, Finding, Row, claimed, number
from ..session import Session
from . import printed
from .results import EXAMPLE, REFERENCE, SCENE, damped, everyone, run, turn_speeds

TESTS = "tests/test_speed_regulator_paper.py::"
EQUATION_TESTS = "tests/test_speed_regulator.py::"

ANGLES = 2 * np.pi * np.arange(64) / 64 + 0.05
SPEED = 5.07
ROUNDING = 1e-12
SEEN = 1e-3
"""Relative error from which on a misprint changes results."""
PROBE = 1e-30
"""Complex step, far below rounding."""


def misprint(as_printed: float, corrected: float, what: str, **more: Any) -> Finding:
    """Judge a misprint: the printed formula fails an identity, the corrected one does not."""
    holds = corrected < ROUNDING and as_printed > SEEN
    reason = f"{what}: off by {as_printed:.3g} as printed, by {corrected:.1g} corrected"
    return Finding(CORRECTED if holds else NOT_REPRODUCED, reason, **more)


def told(session: Session, tell: Any) -> dict[str, Any]:
    """Return what the reference and the engines say, as fields of a finding."""
    words = {name: tell(name) for name in everyone(session)}
    return {"reference": words.pop(REFERENCE), "engines": words}


def slope_of(values: Any) -> Any:
    """Return the derivative that a complex step has left in values."""
    return np.asarray(values).imag / PROBE


# Introduction and section 2


def numerical_only(session: Session) -> Finding:
    """The energy integral without a damper; what follows without solving."""
    p = damped(0.0)
    found = run(session, "frictionless")
    c = coefficients(p)
    phi, speed = (found.observables[name] for name in ("phi", "phi_dot"))
    at = position(phi, c)
    gained = p.torque * phi - p.stiffness * ((at.y - c.rest) ** 2 - (at.y[0] - c.rest) ** 2) / 2
    start = inertia(position(phi[0], c), c) * speed[0] ** 2
    closed = np.sqrt((start + 2 * gained) / inertia(at, c))
    off = float(np.max(abs(closed / speed - 1)))
    threshold, weak = least_torque(EXAMPLE).torque, EXAMPLE.damping * melnikov()
    return claimed(
        off > 1e-9,
        f"without a damper the energy integral gives phi' over phi in closed form (off from the "
        f"solver by {off:.0e}), and with one, phi'^2 over phi obeys an equation of first order "
        f"from which follows, unsolved, that there is at most one rotation, that it is stable, "
        f"and where it begins: for weak damping a quadrature gives {weak:.5f} N m, "
        f"the solution {threshold:.5f} N m",
    )


def melnikov() -> float:
    """Return the homoclinic torque over the damping, where that is weak, by a quadrature."""
    c = coefficients(EXAMPLE)

    def loss(phi: float) -> float:
        at = position(phi, c, math)
        height = c.radius**2 - (at.y - c.rest) ** 2
        return float(at.y_phi**2 * math.sqrt(max(c.stiffness * height, 0) / inertia(at, c)))

    return float(quad(loss, -np.pi / 2, np.pi / 2, epsrel=1e-10)[0] / np.pi)


def slow_variation(session: Session) -> Finding:
    """Averaging presumes little change in a turn."""
    shares = {c: 1 - rotation(damped(c)).multiplier for c in (2.0, 3.0, 4.0)}
    words = ", ".join(f"{share:.1%}" for share in shares.values())
    return claimed(
        max(shares.values()) < 0.2,
        f"of a deviation from the limit cycle, {words} is lost in a turn for c = 2, 3, 4; near "
        f"the least torque, where a turn takes long, the premise fails",
        reference=words,
    )


def frictionless_turns(session: Session) -> Finding:
    """Each turn without friction is faster."""

    def least_gain(name: str) -> float:
        return float(np.min(np.diff(turn_speeds(run(session, "frictionless", name)))))

    gains = {name: least_gain(name) for name in everyone(session)}
    phi, speed = (run(session, "frictionless").observables[k] for k in ("phi", "phi_dot"))
    c = coefficients(damped(0.0))
    energy = get_scene(SCENE).energy([phi[[0, -1]]], [speed[[0, -1]]], c)
    work = EXAMPLE.torque * (phi[-1] - phi[0])
    return claimed(
        min(gains.values()) > 0,
        f"a crank that turns gains the motor's work, 2 pi M_m in every turn (balance off by "
        f"{abs((energy[1] - energy[0]) / work - 1):.0e})",
        **told(session, lambda name: f"slowest gain {gains[name]:.4f} rad/s per turn"),
    )


def frictionless_always(session: Session) -> Finding:
    """Not within a turn, and not from every start."""

    def shares(name: str) -> tuple[float, float]:
        speed = run(session, "frictionless", name).observables["phi_dot"]
        slow = run(session, "frictionless_slow", name).observables["phi"]
        return float(np.mean(np.diff(speed) < 0)), float(np.max(slow))

    found = {name: shares(name) for name in everyone(session)}
    return claimed(
        all(falls == 0 for falls, _ in found.values()),
        "within a turn the speed also falls, with the spring and the moment of inertia; and from "
        "rest at phi = 0 the crank never gets round, friction or not, as the spring holds it",
        **told(
            session,
            lambda name: "falls in {:.0%} of the time; from rest up to {:.2f} rad".format(
                *found[name]
            ),
        ),
    )


def holonomic(session: Session) -> Finding:
    """(1)-(12): derivatives of the positions, by complex steps."""
    off = 0.0
    for p in (EXAMPLE, EXAMPLE.replace(crank_radius=0.9)):
        found = printed.kinematics(ANGLES, p)
        moved = printed.kinematics(ANGLES + 1j * PROBE, p)
        pairs = (
            (slope_of(moved.places), found.a_1),
            (slope_of(moved.a_1), found.a_2),
            (-slope_of(moved.beta), found.t),
            (slope_of(moved.t), found.u),
        )
        off = max(off, *(float(np.max(abs(one - other))) for one, other in pairs))
        closure = p.crank_radius * np.cos(ANGLES) - p.rod_length * np.sin(found.beta)
        off = max(off, float(np.max(abs(closure))))

    def opened(name: str) -> str:
        violation = run(session, "start_8", name).observables.get("position_violation")
        return "" if violation is None else f"loop open by up to {np.max(violation):.1g} m"

    return claimed(
        off < ROUNDING,
        f"speeds and accelerations of all bodies are the derivatives of their positions to "
        f"{off:.0e}, at two ratios lambda",
        reference=f"{off:.0e}",
        engines={name: opened(name) for name in session.engines},
    )


def dots_of_12(session: Session) -> Finding:
    """The last row of (12), the third and last of (13)."""
    phi, speed, rate = 0.7, SPEED, 1.3
    found = printed.kinematics(phi, EXAMPLE)
    right = found.a_1[4] * rate + found.a_2[4] * speed**2
    moved = printed.kinematics(phi + 1j * PROBE * speed, EXAMPLE)
    a_1 = found.a_1[4] + slope_of(moved.a_1[4]) * 1j * PROBE
    second = slope_of(a_1 * (speed + 1j * PROBE * rate))
    first = found.a_1[4] * speed
    return misprint(
        abs(first / right - 1),
        abs(float(second) / right - 1),
        "the right-hand side is the second derivative of y_B",
    )


def slider_equation(session: Session) -> Finding:
    """The slider's momentum: x_B is zero, and the reaction is that at B."""
    phi = 0.7
    free = printed.free_bodies(phi, SPEED, EXAMPLE)
    found = printed.kinematics(phi, EXAMPLE)
    load = EXAMPLE.damping * found.a_1[4] * SPEED + printed.spring(phi, EXAMPLE)
    y_b = found.a_1[4] * free[0] + found.a_2[4] * SPEED**2
    x_b = EXAMPLE.crank_radius * np.cos(phi) - EXAMPLE.rod_length * np.sin(found.beta)
    force = -load - free[4]
    return misprint(
        abs(EXAMPLE.slider_mass * x_b - force) / abs(force),
        abs(EXAMPLE.slider_mass * y_b - force) / abs(force),
        "the slider, B, stays at x = 0 and moves along y: m y_B'' = -F_a - F_e - Y_B, as in (13)",
    )


def free_bodies_13(session: Session) -> Finding:
    """(13) by a solution of its five rows."""
    phi = np.array([0.3, 1.9, 4.4])
    told_ = outputs(phi[None], np.full((1, 3), SPEED), coefficients(EXAMPLE))
    names = ("reaction_a_x", "reaction_a_y", "reaction_b_x", "reaction_b_y")
    exact = np.array([told_[name] for name in names])
    solved = np.array([printed.free_bodies(q, SPEED, EXAMPLE) for q in phi]).T
    off = float(np.max(abs(solved[1:] - exact)) / np.max(abs(exact)))

    def from_engine(name: str) -> str:
        case = Query(SCENE).case
        engine, model = choose_engine(name, case, None)
        tell = getattr(engine, "reactions", None)
        if tell is None:
            return "does not tell"
        states = np.stack([phi, np.full(3, SPEED)], axis=1)
        found = call_engine(lambda: tell(case, model, np.zeros(3), states))
        values = np.array([found[name] for name in names if name in found])
        if len(values) != len(names):
            return "does not tell"
        return f"reactions within {np.max(abs(values - exact)) / np.max(abs(exact)):.1g}"

    return claimed(
        off < ROUNDING,
        f"the signs of (13) are right: its five rows give the reactions and the acceleration "
        f"(off by {off:.0e}); dots are missing on y_C and y_B, see the row on (12)",
        reference=f"{off:.0e}",
        engines={name: from_engine(name) for name in session.engines},
    )


def work_of_reactions(as_printed: bool) -> float:
    """Return the largest part of A_1^T [N], over the rod's length."""
    parts = [
        printed.kinematics(phi, EXAMPLE).a_1 @ printed.reaction_matrix(phi, EXAMPLE, as_printed)
        for phi in map(float, ANGLES)
    ]
    return float(np.max(np.abs(parts))) / EXAMPLE.rod_length


def row_4_of_14(session: Session) -> Finding:
    """Signs of the moments about C."""
    wrong, right = (
        printed.free_bodies(0.3, SPEED, EXAMPLE, as_printed)[0] for as_printed in (True, False)
    )
    found = misprint(
        work_of_reactions(True),
        work_of_reactions(False),
        "(16) asks that the reactions do no work; Y_A and Y_B need minus signs, as in (13)",
    )
    words = f"; as printed phi'' at 0.3 rad would be {wrong:.3g} instead of {right:.3g} rad/s^2"
    return Finding(found.verdict, found.reason + words)


def first_row_of_14(session: Session) -> Finding:
    """A_1 in (14) has four rows, [m] has five."""
    a_1 = printed.kinematics(0.7, EXAMPLE).a_1
    m = printed.masses(EXAMPLE)
    lost = len(m) - len(a_1[1:])
    crank = m[0] * a_1[0] / EXAMPLE.flywheel_inertia
    return claimed(
        lost == 1 and abs(crank - 1) < ROUNDING,
        f"as printed {len(a_1[1:])} rows meet a matrix of {len(m)}; with the 1 of (11) in front, "
        "the first row is the crank's J eps_1 again",
        corrected=True,
    )


def reactions_do_no_work(session: Session) -> Finding:
    """(16), and the line above it."""
    return claimed(
        work_of_reactions(False) < ROUNDING,
        f"A_1^T [N] is 0 to {work_of_reactions(False):.0e} with the signs of (14) put right "
        "(the line above (16) lacks a transpose)",
        corrected=True,
        reference=f"{work_of_reactions(False):.0e}",
    )


def equation_multiplied(session: Session) -> Finding:
    """It is (15) that gives (17)."""
    phi = 0.9
    free = printed.free_bodies(phi, SPEED, EXAMPLE)
    found = printed.kinematics(phi, EXAMPLE)
    load = EXAMPLE.damping * found.a_1[4] * SPEED + printed.spring(phi, EXAMPLE)
    external = np.array([EXAMPLE.torque, 0, 0, 0, -load])
    inertial = printed.masses(EXAMPLE) * (found.a_1 * free[0] + found.a_2 * SPEED**2)
    off = abs(found.a_1 @ (inertial - external)) / EXAMPLE.torque
    changed = printed.free_bodies(phi, SPEED, EXAMPLE.replace(torque=2 * EXAMPLE.torque))
    return claimed(
        off < 1e-10 and changed[0] != free[0],
        f"A_1^T times (15) is the equation of motion (off by {off:.0e}); (5) relates two speeds, "
        f"has no forces, and cannot give a motion that depends on the torque",
        corrected=True,
    )


def inertia_slope_18(as_printed: bool) -> float:
    """Return how far J' is from the derivative of J, over the largest slope."""
    moved = slope_of(printed.moment_of_inertia(ANGLES + 1j * PROBE, EXAMPLE))
    given = (1 if as_printed else 2) * printed.printed_slope(ANGLES, EXAMPLE)
    return float(np.max(abs(given - moved)) / np.max(abs(moved)))


def factor_of_18(session: Session) -> Finding:
    """J' of (18)."""
    found = misprint(inertia_slope_18(True), inertia_slope_18(False), "J' = 2 A_1^T [m] A_2")
    p = EXAMPLE.replace(torque=0.0, damping=0.0, stiffness=0.0)
    drift = energy_drift(p)
    words = f"; with J' as printed the energy of a free crank would swing by {drift:.2%} in a turn"
    return Finding(found.verdict, found.reason + words)


def energy_drift(p: Any) -> float:
    """Return the range of the energy over a turn with (17) and J' as printed, no forces."""
    phi = np.linspace(0, 2 * np.pi, 513)
    moment = printed.moment_of_inertia(phi, p)
    # phi'' = -J' phi'^2 / (2 J) with half the slope: phi'^2 goes as J^(-1/2), not 1 / J
    energy = moment * moment**-0.5
    return float(np.ptp(energy) / energy[0])


def last_line_of_19(session: Session) -> Finding:
    """M(phi) without the damper."""
    c = coefficients(EXAMPLE)
    missing = c.damping * SPEED * position(ANGLES, c).y_phi ** 2
    full = c.torque - static_torque(ANGLES, c) - missing
    last = printed.torque_last_line(ANGLES, EXAMPLE)
    scale = np.max(abs(full))
    found = misprint(
        float(np.max(abs(last - full)) / scale),
        float(np.max(abs(last - missing - full)) / scale),
        "the last line has lost - c omega_1 (r cos phi - l t sin beta)^2",
    )
    try:
        rotation(damped(0.0))
        words = ""
    except NoOrbitError:
        words = "; without it there would be no steady rotation to stabilise at"
    return Finding(found.verdict, found.reason + words)


def equation_17(session: Session) -> Finding:
    """(17)-(19) by the accelerations of engines that know nothing of them."""
    phi = ANGLES[::4]
    speed = SPEED * np.linspace(-1, 1, len(phi))
    exact = printed.acceleration(phi, speed, EXAMPLE)
    wrong = printed.acceleration(phi, speed, EXAMPLE, factor=1.0)
    own = get_scene(SCENE).accelerations(0.0, [phi], [speed], coefficients(EXAMPLE))[0]
    size = np.max(abs(own))
    off = float(np.max(abs(exact - own)) / size)

    def by_engine(name: str) -> str:
        case = Query(SCENE).case
        engine, model = choose_engine(name, case, None)
        states = np.stack([phi, speed], axis=1)
        found = call_engine(lambda: engine.accelerations(case, model, np.zeros(len(phi)), states))
        return f"{model}: accelerations off by {np.max(abs(found[:, 0] - own)) / size:.1g}"

    return claimed(
        off < ROUNDING,
        f"with the 2 that (18) lacks; without it the accelerations are off by "
        f"{np.max(abs(wrong - own)) / size:.2g}. A soft closure resists late, which is its model's "
        "error and no one's misprint",
        corrected=True,
        reference=f"{off:.0e}",
        engines={name: by_engine(name) for name in session.engines},
    )


def one_degree_of_freedom(session: Session) -> Finding:
    """Bodies with joints move as the one equation says."""
    truth = run(session, "start_8")
    until = truth.times <= 10.0

    def off(name: str) -> float:
        gap = run(session, "start_8", name).observables["phi"] - truth.observables["phi"]
        return float(np.max(abs(gap[until])))

    gaps = {name: off(name) for name in session.engines}
    return claimed(
        max(gaps.values(), default=0.0) < 0.1,
        "crank, rod and slider as three bodies with joints follow the one equation: difference "
        "of the crank angle over 10 s from 8 rad/s",
        reference="exact by construction",
        engines={name: f"{gap:.1g} rad" for name, gap in gaps.items()},
    )


def autonomous(session: Session) -> Finding:
    """Nothing depends on time."""
    times = np.arange(1, 17) / 8
    state = {"phi": 0.4, "phi_dot": SPEED}
    first = simulate(SCENE, state=state, times=times)
    half = {k: float(first.observables[k][7]) for k in ("phi", "phi_dot")}
    again = simulate(SCENE, state=half, times=times[:8])
    off = float(np.max(abs(again.observables["phi"] - first.observables["phi"][8:])))
    return claimed(
        off > 1e-6,
        f"nothing in (17) depends on time: a motion taken up again a second later is the same "
        f"(to {off:.0e} rad)",
    )


def linear_system(session: Session) -> Finding:
    """The first-order form is no linear system, and its moment has lost the speed."""
    phi = 0.7
    c = coefficients(EXAMPLE)
    rates = [get_scene(SCENE).accelerations(0.0, [phi], [v], c)[0] for v in (0.0, 3.0, 6.0)]
    bend = abs(rates[2] - 2 * rates[1] + rates[0]) / abs(rates[1] - rates[0])
    linear = abs(get_scene(SCENE).accelerations(0.0, [2 * phi], [0.0], c)[0] - 2 * rates[0])
    return claimed(
        bend < 1e-6 and linear < 1e-6,
        f"it is of first order and not linear: from 3 to 6 rad/s phi'' changes otherwise than from "
        f"0 to 3 rad/s, by {bend:.0%} of that. It also has x_1 = alpha for phi, and M(x_1) "
        "for M(x_1, x_2): the damper needs the speed",
    )


# Averages


def mean_slope(session: Session) -> Finding:
    """The mean of J'."""
    worst = max(abs(printed.averages(p).slope) for p in ratios())
    return claimed(
        worst < 1e-14,
        f"0 to {worst:.0e} for lambda = 0.05 to 0.9: J' is the derivative of a periodic function",
        reference=f"{worst:.0e}",
    )


def ratios() -> list[Any]:
    """Return the example with several lambda."""
    return [
        EXAMPLE.replace(crank_radius=ratio * EXAMPLE.rod_length) for ratio in (0.05, 0.2, 0.5, 0.9)
    ]


def mean_spring(session: Session) -> Finding:
    """The mean of the spring's torque."""
    means = [printed.averages(p) for p in ratios()]
    worst = max(max(abs(item.spring_19), abs(item.spring_3)) for item in means)
    speeds = [rotation(EXAMPLE.replace(stiffness=k)).mean_speed for k in (0.0, 32.0, 64.0)]
    return claimed(
        worst < 1e-13,
        f"0 to {worst:.0e} over a turn, with either reference of the spring, so that k is not in "
        f"(21); the limit cycle feels it a little: {speeds[0]:.4f}, {speeds[1]:.4f}, "
        f"{speeds[2]:.4f} rad/s with k = 0, 32, 64 N/m",
        reference=f"{worst:.0e}",
    )


def spring_of_section_3(session: Session) -> Finding:
    """Section 3 averages another spring than (19) has."""
    phi = np.array([0.3, 1.0, 2.0])
    p = EXAMPLE
    found = printed.kinematics(phi, p)
    force_19 = p.stiffness * (p.rod_length + found.places[4])
    force_3 = p.stiffness * (p.crank_radius + p.rod_length + found.places[4])
    true = printed.spring(phi, p)
    size = p.stiffness * p.crank_radius
    return misprint(
        float(np.max(abs(force_3 - true)) / size),
        float(np.max(abs(force_19 - true)) / size),
        "(19) and F_e have the spring at rest at y = -l, the averages at -(r + l), one spring "
        "force over k r. Both average to 0, so that (20) stands",
    )


def half(session: Session) -> Finding:
    """Mean of cos^2."""
    return number("0.5", printed.averages(EXAMPLE).cos_squared)


def remainder(session: Session) -> Finding:
    """Mean of t^2 sin^2 beta."""
    value = printed.averages(EXAMPLE).remainder
    ratio = EXAMPLE.crank_radius / EXAMPLE.rod_length
    exact = 1 - math.sqrt(1 - ratio**2) - ratio**2 / 2
    return number(
        "0.000204", value, because=f"exactly 1 - sqrt(1 - lambda^2) - lambda^2/2 = {exact:.9f}"
    )


def remainder_everywhere(session: Session) -> Finding:
    """The number stands for lambda = 0.2."""
    means = [(p.crank_radius / p.rod_length, printed.averages(p).remainder) for p in ratios()]
    words = ", ".join(f"{value:.3g} at {ratio:g}" for ratio, value in means)
    errors = [float(printed_mean_speed(p) / mean_speed(p) - 1) for p in ratios()]
    wrong = ", ".join(f"{error:+.2%}" for error in errors)
    return claimed(
        max(abs(error) for error in errors) < 0.005,
        f"t^2 sin^2 beta has the mean {words}; (21) with 0.000204 is then off by {wrong}. For any "
        f"lambda: omega = M_m / (c l^2 (1 - sqrt(1 - lambda^2)))",
        reference=words,
    )


def mixed_mean(session: Session) -> Finding:
    """Mean of t cos phi sin beta."""
    worst = max(abs(printed.averages(p).mixed) for p in ratios())
    return claimed(worst < 1e-15, f"odd in phi: {worst:.0e}", reference=f"{worst:.0e}")


def mean_damper(session: Session) -> Finding:
    """Mean of the damper's torque, hence (20)."""
    value = printed.averages(EXAMPLE).damper
    ratio = EXAMPLE.crank_radius / EXAMPLE.rod_length
    given = 0.5 * ratio**2 + 0.000204
    off = abs(given / value - 1)
    return claimed(
        off < 1e-5,
        f"over the angle, at constant speed: {value:.9f} c l^2 omega_1, printed {given:.6f} "
        f"(off by {off:.0e}) at lambda = 0.2",
        reference=f"{value:.9f}",
    )


ROWS = (
    Row(
        "one_degree_of_freedom", "claim", "abstract, 2",
        "The mechanism has one degree of freedom.", one_degree_of_freedom, slow=True,
    ),
    Row(
        "numerical_only", "claim", "1",
        "Its equations can only be solved numerically, and tell nothing without that.",
        numerical_only, slow=True,
    ),
    Row(
        "slow_variation", "claim", "1",
        "Amplitude and speed vary slowly, so that averaging applies.", slow_variation,
    ),
    Row(
        "frictionless_turns", "claim", "2",
        "Without friction the constant torque makes the crank faster.", frictionless_turns,
        slow=True,
    ),
    Row(
        "frictionless_always", "claim", "2",
        "Without friction the speed increases all the time.", frictionless_always, slow=True,
    ),
    Row(
        "kinematics", "claim", "equations (1)-(12)",
        "Links are holonomic; speeds and accelerations follow from the crank's.", holonomic,
        slow=True,
    ),
    Row(
        "dots_of_12", "misprint", "equations (12), (13)",
        "Left-hand sides: y_B (and y_C) with one dot.", dots_of_12, printed="y_B'",
        test=TESTS + "test_the_left_of_12_is_a_second_derivative",
    ),
    Row(
        "slider_equation", "misprint", "2, above (13)",
        "Momentum of the slider, along x and with a reaction at C.", slider_equation,
        printed="m x_B'' = ... - Y_C", test=TESTS + "test_the_slider_moves_along_y",
    ),
    Row(
        "free_bodies_13", "claim", "equation (13)",
        "Momentum and moment of momentum of crank, rod and slider.", free_bodies_13,
    ),
    Row(
        "row_4_of_14", "misprint", "equation (14)",
        "Moments of Y_A and Y_B about the rod's centre.", row_4_of_14, printed="+l cos, +l sin",
        test=EQUATION_TESTS + "test_14_needs_minus_signs_and_16_says_so",
    ),
    Row(
        "first_row_of_14", "misprint", "equation (14)",
        "The vector A_1 without its first row.", first_row_of_14, printed="4 rows",
        test=TESTS + "test_the_first_row_of_14_is_the_cranks",
    ),
    Row(
        "reactions_do_no_work", "claim", "equation (16)",
        "Reactions of ideal joints do no work.", reactions_do_no_work,
    ),
    Row(
        "equation_multiplied", "misprint", "2, above (17)",
        "Which equation is multiplied by A_1^T.", equation_multiplied, printed="(5)",
        test=TESTS + "test_15_and_not_5_gives_the_equation_of_motion",
    ),
    Row(
        "equation_17", "claim", "equations (17)-(19)",
        "The equation of motion.", equation_17,
    ),
    Row(
        "factor_of_18", "misprint", "equation (18)",
        "Derivative of the moment of inertia.", factor_of_18, printed="A_1^T [m] A_2",
        test=EQUATION_TESTS + "test_18_lacks_a_factor_2",
    ),
    Row(
        "last_line_of_19", "misprint", "equation (19)",
        "Generalised torque, multiplied out.", last_line_of_19, printed="no c in the last line",
        test=TESTS + "test_the_last_line_of_19_has_lost_the_damper",
    ),
    Row(
        "linear_system", "claim", "3, below (21)",
        "In x_1, x_2 the equation is called a linear system.", linear_system,
        printed="M(x_1)",
    ),
    Row(
        "autonomous", "claim", "4",
        "The mechanism is called non-autonomous.", autonomous,
    ),
    Row("mean_slope", "claim", "3", "J' averages to 0 over a turn.", mean_slope),
    Row("mean_spring", "claim", "3", "The spring's torque averages to 0.", mean_spring),
    Row(
        "spring_of_section_3", "misprint", "3",
        "Where the spring is at rest.", spring_of_section_3, printed="r + l",
        test=TESTS + "test_section_3_averages_another_spring",
    ),
    Row("mean_cos_squared", "number", "3", "Mean of cos^2 phi.", half, printed="0.5"),
    Row("remainder", "number", "3", "Mean of t^2 sin^2 beta.", remainder, printed="0.000204"),
    Row(
        "remainder_everywhere", "claim", "equations (20), (21)",
        "That number serves for any lambda.", remainder_everywhere, printed="0.000204",
        test=EQUATION_TESTS
        + "test_21_takes_the_exact_mean_and_the_printed_one_holds_at_one_fifth",
    ),
    Row("mixed_mean", "claim", "3", "t cos phi sin beta averages to 0.", mixed_mean),
    Row("mean_damper", "claim", "equation (20)", "Mean of the damper's torque.", mean_damper),
)  # fmt: skip

"""The paper on speed_regulator reproduced: its figures, and its ledger; here sections 3 and 4.

S. Vlase, M. Mihalcica, M. L. Scutaru, "Determining the Functional Parameters of a Simple Speed
Regulator" (2018).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.stats import linregress

from ....reference import get_scene
from ....reference.errors import NoOrbitError
from ....reference.scene import Array
from ....reference.speed_regulator.equations import SpeedRegulator, coefficients
from ....reference.speed_regulator.orbit import mean_speed
from ....reference.speed_regulator.rest import found_equilibria
from ....reference.speed_regulator.theory import (
    least_torque,
    printed_mean_speed,
    regime,
    rotation,
    saddle_node_torques,
)
from ...queries.frequencies import frequencies
from ...scenes.speed_regulator.limit_cycles import REGIMES
from ...scenes.speed_regulator.maps import QUANTITIES
from ..figure import Figure as Figure
from ..ledger import (
    NOT_REPRODUCED,
    NOT_TESTABLE,
    REPRODUCED,
    Finding,
    Row,
    claimed,
    half_unit,
    number,
)
from ..session import Session
from . import derivation as speed_regulator_derivation
from .derivation import TESTS, told
from .figures import FIGURES as FIGURES
from .figures import last_turn
from .results import (
    DAMPINGS,
    EXAMPLE,
    REFERENCE,
    SCENE,
    STARTS,
    TORQUE,
    agreement,
    damped,
    ending,
    everyone,
    least_torques,
    own_speeds,
    parameters_of,
    points,
    regime_map,
    run,
    speed_map,
    turn_speeds,
)

PRINTED_SPEED = "5.07"
CLOSE = 0.02
"""Relative difference that a figure hides."""


def speeds_said(values: Mapping[str, Any], unit: str = "rad/s") -> dict[str, Any]:
    """Return numbers of the reference and the engines as fields of a finding."""
    words = {
        name: ", ".join(f"{value:.4f}" for value in np.atleast_1d(found)) + f" {unit}"
        for name, found in values.items()
    }
    return {"reference": words.pop(REFERENCE), "engines": words}


# The stabilised speed: (21), figures 3 to 5


def stabilised_speed(session: Session) -> Finding:
    """Figure 4, below."""
    engines = {name: float(own_speeds(session, name)[0]) for name in session.engines}
    return number(
        PRINTED_SPEED,
        float(own_speeds(session)[0]),
        "rad/s",
        engines,
        f"with M_m/(c l^2) chosen to have it; (21) gives {float(mean_speed(EXAMPLE)):.4f} rad/s",
    )


def unit_of_the_speed(session: Session) -> Finding:
    """In metres the number would depend on the unit of length."""
    factor = 10.0
    p = EXAMPLE
    rescaled = p.replace(
        crank_radius=p.crank_radius * factor,
        rod_length=p.rod_length * factor,
        torque=p.torque * factor**2,
    )
    kept = abs(float(mean_speed(rescaled) / mean_speed(p)) - 1)
    circumference = float(mean_speed(p)) * p.crank_radius
    return claimed(
        kept < 1e-12,
        f"M_m/(c l^2) is a rate: (21) gives {float(mean_speed(p)):.2f} in any unit of length, and "
        f"the text below says rad/s; a speed in m/s, that of the crank pin, would be "
        f"{circumference:.2f} with r = {p.crank_radius:g} m",
        corrected=True,
    )


def formula_21(session: Session) -> Finding:
    """(21) against the limit cycle."""
    formula = np.array([float(printed_mean_speed(damped(c))) for c in DAMPINGS])
    errors = {name: formula / own_speeds(session, name) - 1 for name in everyone(session)}
    exact = [float(mean_speed(damped(c)) / printed_mean_speed(damped(c))) - 1 for c in DAMPINGS]
    return claimed(
        bool(np.max(abs(errors[REFERENCE])) < CLOSE),
        f"(21) over the limit cycle's speed, less 1, for c = 2, 3, 4; its exact average would "
        f"change that by {max(map(abs, exact)):.0e} only. The rest is the speed's variation in a "
        "turn, which averaging leaves out, and grows as the speed falls",
        **told(session, lambda name: ", ".join(f"{error:+.2%}" for error in errors[name])),
    )


def asymptote(session: Session) -> Finding:
    """(21) is the limit of a large flywheel."""
    inertias = (2.0, 8.0, 32.0, 128.0)
    errors = []
    for value in inertias:
        p = EXAMPLE.replace(flywheel_inertia=value)
        errors.append(rotation(p).mean_speed / float(mean_speed(p)) - 1)
    slope = np.log(errors[-1] / errors[-2]) / np.log(inertias[-1] / inertias[-2])
    words = ", ".join(f"{error:.1e}" for error in errors)
    return claimed(
        bool(abs(slope + 1) < 0.05),
        f"with J = {', '.join(f'{value:g}' for value in inertias)} kg m^2 the limit cycle is "
        f"faster than the exact average by {words}: an asymptote, its error going as J^{slope:.2f}",
        reference=words,
    )


def linear_law(session: Session) -> Finding:
    """Figure 3: whether the limit cycle's speed is linear in the torque, and where."""
    fine = speed_map(session, fine=True)
    torque = fine.x.values
    words = []
    worst = 0.0
    for row, c in enumerate(DAMPINGS):
        speed = fine.variables["mean_speed"][row]
        there = np.isfinite(speed)
        off = abs(fine.variables["error_as_printed"][row])
        bad = np.flatnonzero(~(off < CLOSE))
        line = linregress(torque[there], speed[there])
        bend = np.max(abs(speed[there] - line.intercept - line.slope * torque[there]))
        worst = max(worst, float(bend / np.max(speed[there])))
        start = torque[bad[-1] + 1] if bad.size else torque[0]
        words.append(f"c = {c:g}: from {start:.2f} N m on")
    least = least_torque(EXAMPLE).torque

    def told_(name: str) -> str:
        own, true = speed_map(session, name), speed_map(session)
        gap = own.variables["mean_speed"] / true.variables["mean_speed"] - 1
        return f"within {np.nanmax(abs(gap)):.1e} of the reference"

    return claimed(
        worst < CLOSE,
        f"over {TORQUE[0]:g} to {TORQUE[1]:g} N m each curve lies within {worst:.1%} of its "
        f"height of a straight line, and within {CLOSE:.0%} of (21) for "
        f"{'; '.join(words)}. Below, the curve bends down "
        f"and ends at the least torque, {least:.4f} N m for c = 2",
        reference="; ".join(words),
        engines={name: told_(name) for name in session.engines},
    )


def linear_law_everywhere(session: Session) -> Finding:
    """(21) promises a speed at any torque."""
    least = {c: least_torque(damped(c)).torque for c in DAMPINGS}
    words = ", ".join(f"{value:.4f}" for value in least.values())
    promised = ", ".join(
        f"{float(printed_mean_speed(damped(c, torque=value))):.2f}" for c, value in least.items()
    )
    below = {c: regime(damped(c, torque=0.95 * value)) for c, value in least.items()}

    def by_engine(name: str) -> str:
        found = QUANTITIES["regime"].evaluate(
            points(
                name,
                damping=np.array(DAMPINGS),
                torque=0.95 * np.array(list(least.values())),
            )
        )
        return "5 % below: " + ", ".join(
            REGIMES[int(i)] if i >= 0 else "failed" for i in found.values["regime"]
        )

    return claimed(
        any(found != "rest" for found in below.values()),
        f"there is no rotation below {words} N m for c = 2, 3, 4, where (21) still promises "
        f"{promised} rad/s: the crank does not come over the spring. The least torque is that of a "
        "homoclinic orbit, at which the speed falls to 0 with a vertical slope",
        reference="5 % below: " + ", ".join(below.values()),
        engines={name: by_engine(name) for name in session.engines},
    )


def energy_balance(session: Session) -> Finding:
    """The damper takes what the motor gives."""

    def ratio(name: str) -> float:
        found = run(session, "damping_4", name)
        p = parameters_of("damping_4")
        rate, speed = last_turn(found, ("y_dot", "phi_dot"))
        work = p.damping * rate**2 / speed  # over the crank angle
        return float(np.mean(work[:-1]) / p.torque)

    ratios = {name: ratio(name) for name in everyone(session)}
    left = rotation(parameters_of("damping_4")).mean_speed
    slower = float(turn_speeds(run(session, "damping_4"))[-1]) / left - 1
    return claimed(
        max(abs(value - 1) for value in ratios.values()) < CLOSE,
        f"the damper's work over the motor's in the last turn of the run from 6 rad/s with c = 4, "
        f"which is {slower:.1%} faster than the limit cycle yet",
        **told(session, lambda name: f"{ratios[name]:.3f}"),
    )


def stabilises(session: Session) -> Finding:
    """A constant torque ends in a constant mean speed."""

    def drift(name: str) -> float:
        speeds = turn_speeds(run(session, "start_8", name))
        return float(abs(speeds[-1] / speeds[-11] - 1))

    drifts = {name: drift(name) for name in everyone(session)}
    return claimed(
        max(drifts.values()) < 1e-2,
        f"change of the mean speed over the last ten turns of "
        f"{run(session, 'start_8').times[-1]:g} s from 8 rad/s; a deviation falls by "
        f"{rotation(EXAMPLE).multiplier:.4f} in each turn",
        **told(session, lambda name: f"{drifts[name]:.1e}"),
    )


def last_speeds(session: Session, name: str) -> Array:
    """Return the mean speed of the last ten turns from each start of figure 4 [rad/s]."""
    return np.array(
        [float(np.mean(turn_speeds(run(session, f"start_{v:g}", name))[-10:])) for v in STARTS]
    )


def independent_of_start(session: Session) -> Finding:
    """Figure 4."""
    found = {name: last_speeds(session, name) for name in everyone(session)}
    spread = {name: float(np.ptp(values)) for name, values in found.items()}
    begin, multiplier = STARTS[-1] - STARTS[0], rotation(EXAMPLE).multiplier
    return claimed(
        max(spread.values()) < 0.01 * begin,
        f"from {', '.join(f'{v:g}' for v in STARTS)} rad/s, a spread of {begin:g} rad/s; after 200 "
        f"s it is {spread[REFERENCE]:.3f} rad/s, and falls by {1 - multiplier:.1%} in each turn",
        **speeds_said(found),
    )


def every_start(session: Session) -> Finding:
    """Not from every start: rest coexists."""
    held = saddle_node_torques(EXAMPLE)
    ends = {name: ending(session, "start_slow", name) for name in everyone(session)}
    seen = {
        name: float(np.max(run(session, "start_slow", name).observables["phi"]))
        for name in everyone(session)
    }
    return claimed(
        all(end == "rotation" for end in ends.values()),
        f"a crank that starts too slowly does not come over the spring: at rest it can be held up "
        f"to {max(held.values()):.4f} N m ({', '.join(f'{k} {v:.4f}' for k, v in held.items())}), "
        f"so that rest and rotation coexist at {EXAMPLE.torque:g} N m",
        **told(
            session, lambda name: f"from 0.6 rad/s: no further than {seen[name]:.2f} rad of phi"
        ),
    )


def damping_slows(session: Session) -> Finding:
    """Figure 5."""
    found = {name: own_speeds(session, name) for name in everyone(session)}
    products = found[REFERENCE] * np.array(DAMPINGS)
    return claimed(
        all(bool(np.all(np.diff(values) < 0)) for values in found.values()),
        f"for c = 2, 3, 4; by (21) in inverse proportion: c times the speed is "
        f"{', '.join(f'{value:.2f}' for value in products)} N/m",
        **speeds_said(found),
    )


def quasi_uniform(session: Session) -> Finding:
    """How uniform the rotation is."""

    def spread(name: str) -> Array:
        speeds = [last_turn(run(session, f"damping_{c:g}", name), ("phi_dot",)) for c in DAMPINGS]
        return np.array([np.ptp(speed) / np.mean(speed) for speed in speeds])

    cycles = [rotation(damped(c)) for c in DAMPINGS]
    exact = [(item.maximum_speed - item.minimum_speed) / item.mean_speed for item in cycles]
    return claimed(
        max(exact) < 0.1,
        f"the speed varies in a turn by {', '.join(f'{value:.1%}' for value in exact)} of its mean "
        "for c = 2, 3, 4; below, in the last turn of the runs of figure 5",
        **told(session, lambda name: ", ".join(f"{v:.1%}" for v in spread(name))),
    )


# Figures 6, 7, and conclusions


def braked(session: Session) -> Finding:
    """Figure 6."""
    p = parameters_of("braked")
    ends = {name: ending(session, "braked", name) for name in everyone(session)}
    truth = run(session, "braked")
    energy = get_scene(SCENE).energy(
        [truth.observables["phi"]], [truth.observables["phi_dot"]], coefficients(p)
    )
    free = energy - p.torque * truth.observables["phi"]

    def reversals(name: str) -> int:
        forward = run(session, "braked", name).observables["phi_dot"] > 0
        return int(np.sum(forward[1:] != forward[:-1]))

    return claimed(
        all(end == "rest" for end in ends.values()) and bool(np.all(np.diff(free) < 1e-9)),
        f"with {p.torque:g} N m and c = {p.damping:g} N s/m, below the least torque of a rotation, "
        f"{least_torque(p).torque:.4f} N m: turns get slower, the last one does not come over the "
        "spring, and a damped vibration about a position of rest is left",
        **told(session, lambda name: f"{ends[name]} after {reversals(name)} reversals"),
    )


def phase_space(session: Session) -> Finding:
    """Figure 7."""
    multiplier = rotation(parameters_of("damping_4")).multiplier

    def gaps(name: str) -> tuple[float, float]:
        above, below = (turn_speeds(run(session, key, name)) for key in ("damping_4", "from_below"))
        return float(above[0] - below[0]), float(above[-1] - below[-1])

    found = {name: gaps(name) for name in everyone(session)}
    return claimed(
        all(abs(last) < 0.02 * abs(first) for first, last in found.values()),
        f"trajectories of the slider from 6 and 1.5 rad/s close in on one curve, c = 4: gap of "
        f"their mean speeds in the first and last turn of 100 s (multiplier {multiplier:.4f})",
        **told(session, lambda name: "{:.3f} to {:.3f} rad/s".format(*found[name])),
    )


LATE = 20
"""Turn of a run from 6 rad/s with c = 4 by which it is near the limit cycle."""


def limit_cycle_stable(session: Session) -> Finding:
    """Stability of the limit cycles."""
    cycles = {c: rotation(damped(c)) for c in DAMPINGS}
    words = ", ".join(f"{item.multiplier:.5f}" for item in cycles.values())

    def rate(name: str) -> str:
        speeds = turn_speeds(run(session, "damping_4", name)) - own_speeds(session, name)[-1]
        factor = (speeds[LATE + 10] / speeds[LATE]) ** 0.1
        return f"c = 4: a deviation falls by {factor:.3f} in each turn"

    return claimed(
        all(0 < item.multiplier < 1 for item in cycles.values()),
        "Floquet multipliers for c = 2, 3, 4; they are exp(-integral of c y_phi^2/(J omega)) < 1 "
        "for every damper. The paper shows trajectories and no criterion; the engines' factors are "
        "from their runs",
        reference=words,
        engines={name: rate(name) for name in session.engines},
    )


def conditions(session: Session) -> Finding:
    """Where the uniform motion exists over damper and torque."""
    return region(
        session,
        "damping",
        "over c = 0.5 to 16 N s/m and M_m = 0.02 to 1.4 N m, (20) is met everywhere, and the "
        "motion that it promises",
    )


def spring_and_torque(session: Session) -> Finding:
    """Where it exists over spring and torque."""
    regimes = regime_map(session, "stiffness").variables["regime"]
    same = float(np.mean(np.all(regimes == regimes[:, :1], axis=1)))
    return region(
        session,
        "stiffness",
        f"k is not in (20); over k = 2 to 64 N/m and M_m = 0.02 to 1.4 N m the regime is the same "
        f"for all springs at {same:.0%} of the torques. The uniform motion",
        same == 1,
    )


def region(session: Session, over: str, words: str, holds: bool = False) -> Finding:
    """Say where rest and rotation are, by all."""
    found = {name: regime_map(session, over, name) for name in everyone(session)}
    shares = found[REFERENCE].shares()
    engines = {}
    for name in session.engines:
        share, count = agreement(session, over, name)
        engines[name] = f"{share:.1%} of {count} robust points agree"
    return claimed(
        holds or shares["rotation"] == 1,
        f"{words} has no alternative in {shares['rotation']:.0%} of the map; in "
        f"{shares['coexistence']:.0%} the crank can also stay at rest, and in "
        f"{shares['rest']:.0%} there is no rotation",
        reference=", ".join(f"{name} {share:.1%}" for name, share in shares.items() if share),
        engines=engines,
    )


def design(session: Session) -> Finding:
    """Choosing the damper for a speed by (21)."""
    wanted = (5.07, 2.5, 1.5, 1.0)
    reached = []
    for omega in wanted:
        p = damped(EXAMPLE.damping * float(mean_speed(EXAMPLE)) / omega)
        try:
            reached.append(f"{rotation(p).mean_speed / omega - 1:+.1%}")
        except NoOrbitError:
            reached.append("no rotation")
    top = damped(EXAMPLE.damping * float(mean_speed(EXAMPLE)) / wanted[1])
    return claimed(
        abs(rotation(top).mean_speed / wanted[1] - 1) < CLOSE,
        "the damper that (21) asks for, tried on the equation of motion: off by "
        + "; ".join(f"{a} at {w:g} rad/s" for a, w in zip(reached, wanted, strict=True))
        + ". Good while a turn is much shorter than the crank's swing on the spring",
        reference=", ".join(reached),
    )


def resonance(session: Session) -> Finding:
    """Resonance."""
    modes = {
        name: frequencies(SCENE, name, engine=REFERENCE).modes[0] for name in ("right", "left")
    }
    words = ", ".join(f"{name} {mode.omega:.3f} rad/s" for name, mode in modes.items())
    return Finding(
        NOT_TESTABLE,
        "named in the conclusions; no equation, number or figure is about it. The crank's own "
        f"vibrations about its positions of rest, without torque and damper: {words}",
        reference=words,
        engines={
            name: ", ".join(
                f"{place} {frequencies(SCENE, place, engine=name).modes[0].omega:.3f} rad/s"
                for place in modes
            )
            for name in session.engines
        },
    )


# Readings


def candidates_of(sets: Mapping[str, SpeedRegulator]) -> list[tuple[str, str]]:
    """Return what parameters give: the mean speed, and the least torque of a rotation."""
    least = least_torques(list(sets.values()))
    found = []
    for (name, p), torque in zip(sets.items(), least, strict=True):
        speed = f"{rotation(p).mean_speed:.4f} rad/s" if p.torque > torque else "no rotation"
        found.append((name, f"{speed}; least torque of a rotation {torque:.4f} N m"))
    return found


def missing_parameters(session: Session) -> Finding:
    """The set of parameters."""
    average = float(EXAMPLE.torque / (EXAMPLE.damping * EXAMPLE.rod_length**2))
    average /= float(printed_mean_speed(EXAMPLE))
    low, high = (
        (float(PRINTED_SPEED) + sign * half_unit(PRINTED_SPEED)) * average for sign in (-1, 1)
    )
    ours = EXAMPLE.torque / (EXAMPLE.damping * EXAMPLE.rod_length**2)
    smaller = EXAMPLE.replace(
        crank_radius=0.1, rod_length=0.5, spring_rest=-0.5, torque=0.0512, stiffness=32.0
    )
    sets = {
        "ours: J = 2, m_b = 0.5, m = 1 kg, k = 32 N/m, l = 1.25 m": EXAMPLE,
        "J = 8 kg m^2": EXAMPLE.replace(flywheel_inertia=8.0),
        "J = 0.5 kg m^2": EXAMPLE.replace(flywheel_inertia=0.5),
        "m_b = 2, m = 4 kg": EXAMPLE.replace(rod_mass=2.0, slider_mass=4.0),
        "k = 8 N/m": EXAMPLE.replace(stiffness=8.0),
        "k = 128 N/m": EXAMPLE.replace(stiffness=128.0),
        "l = 0.5, r = 0.1 m, M_m = 0.0512 N m": smaller,
        "the same with k = 200 N/m": smaller.replace(stiffness=200.0),
    }
    return Finding(
        REPRODUCED if low < ours < high else NOT_REPRODUCED,
        f"lambda = 0.2 and 5.07 rad/s fix M_m/(c l^2) between {low:.5f} and {high:.5f} 1/s by "
        f"(21), ours is {ours:.5f} 1/s; J, masses, spring and the size of l do not enter (21). The "
        "limit cycle feels them in the third digit, and they decide where the rotation begins",
        reference=f"{ours:.5f} 1/s",
        candidates=tuple(candidates_of(sets)),
    )


def damper_of_figure_4(session: Session) -> Finding:
    """With which of the dampers 5.07 rad/s belongs."""
    found = []
    for c in DAMPINGS:
        torque = EXAMPLE.torque * c / EXAMPLE.damping
        p = damped(c, torque=torque)
        cycle = rotation(p)
        found.append(
            (
                f"c = {c:g} N s/m, so M_m = {torque:g} N m",
                f"{cycle.mean_speed:.4f} rad/s, multiplier {cycle.multiplier:.4f}, "
                f"half of a deviation gone in {-np.log(2) / np.log(cycle.multiplier):.0f} turns",
            )
        )
    return Finding(
        NOT_TESTABLE,
        "figure 4 has no damper in its text: we take the first of figure 5. Any of them has "
        "5.07 rad/s with its own torque, and settles in its own time",
        reference="c = 2 N s/m",
        candidates=tuple(found),
    )


def spring_reference(session: Session) -> Finding:
    """Where the spring is at rest."""
    r, l = EXAMPLE.crank_radius, EXAMPLE.rod_length
    places = {
        "-l, as in F_e and (19) (ours)": -l,
        "-(r + l), as in the averages": -(r + l),
        "-sqrt(l^2 - r^2), the slider at phi = 0": -float(np.sqrt(l**2 - r**2)),
        "0, at the crank's axle": 0.0,
    }
    sets = {name: EXAMPLE.replace(spring_rest=place) for name, place in places.items()}
    found = []
    for name, words in candidates_of(sets):
        rests = ", ".join(f"{k} {v:.2f}" for k, v in found_equilibria(sets[name]).items())
        found.append((name, f"{words}; equilibria [rad]: {rests}"))
    close = abs(rotation(EXAMPLE).mean_speed - float(PRINTED_SPEED)) < half_unit(PRINTED_SPEED)
    return Finding(
        REPRODUCED if close else NOT_REPRODUCED,
        "F_e above (13), and (19), say -l, the averages -(r + l); (21) does not depend on it, the "
        "positions of rest and the least torque do",
        reference=f"{-l:g} m",
        candidates=tuple(found),
    )


def braking_of_figure_6(session: Session) -> Finding:
    """How the motion of figure 6 is braked."""
    sets = {
        "less torque: 0.04 N m with c = 4 (ours)": damped(4.0, torque=0.04),
        "no motor, c = 2": damped(2.0, torque=0.0),
        "a stronger damper: c = 14 at 0.32 N m": damped(14.0),
        "a stronger damper: c = 8 at 0.32 N m": damped(8.0),
        "c = 4 at 0.32 N m, as in figure 5": damped(4.0),
    }
    found = candidates_of(sets)
    return Finding(
        NOT_TESTABLE,
        "the text has no values. That the damper takes more than the motor gives is so in every "
        "run that slows down; it comes to rest only below the least torque of a rotation",
        reference=found[0][1],
        candidates=tuple(found),
    )


def axes_of_figure_3(session: Session) -> Finding:
    """Dampers and torques of figure 3."""
    dampers = (1.0, *DAMPINGS, 8.0)
    found = []
    for c, least in zip(dampers, least_torques([damped(c) for c in dampers]), strict=True):
        p = [damped(c, torque=torque) for torque in (2 * float(least), TORQUE[1])]
        off = [float(printed_mean_speed(item)) / rotation(item).mean_speed - 1 for item in p]
        words = f"{off[0]:+.1%} at twice that, {off[1]:+.2%} at {TORQUE[1]:g} N m"
        found.append((f"c = {c:g} N s/m", f"begins at {least:.4f} N m; (21) off by {words}"))
    return Finding(
        NOT_TESTABLE,
        f"the text names neither: we take the dampers of figure 5 and "
        f"{TORQUE[0]:g} to {TORQUE[1]:g} N m. How straight the curves look depends on how near the "
        "least torque the axis begins",
        reference="c = 2, 3, 4 N s/m",
        candidates=tuple(found),
    )


def tolerance_of_the_solver(session: Session) -> Finding:
    """What Runge-Kutta pairs show of the stabilised speed."""
    derivative = get_scene(SCENE).right_hand_side(EXAMPLE)
    seen = np.array([200.0, 240.0])
    found = []
    for method in ("RK45", "RK23"):
        for tolerance in (1e-3, 1e-4, 1e-6):
            run_ = solve_ivp(
                derivative, (0, seen[1]), [0.0, 6.0], method, seen, rtol=tolerance, atol=1e-6
            )
            found.append((f"{method}, {tolerance:g}", float(np.ptp(run_.y[0]) / np.ptp(seen))))
    close = abs(found[2][1] - float(PRINTED_SPEED)) < half_unit(PRINTED_SPEED)
    return Finding(
        REPRODUCED if close else NOT_REPRODUCED,
        "the paper names Matlab's Runge-Kutta solvers, and no tolerance: mean speed from 200 to "
        "240 s after a start at 6 rad/s, by pairs of the same orders and their relative "
        "tolerance. With 1e-3, where Matlab starts, the third digit would be the solver's",
        reference=f"{found[2][1]:.4f} rad/s",
        candidates=tuple((name, f"{speed:.4f} rad/s") for name, speed in found),
    )


def starts_of_figure_4(session: Session) -> Finding:
    """Initial conditions of figure 4."""
    found = []
    for speed in (0.0, 0.6, 0.8, 2.0, 8.0):
        for phi in (0.0, np.pi):
            found.append((f"phi = {phi:.2f} rad, {speed:g} rad/s", end_of(phi, speed)))
    return Finding(
        NOT_TESTABLE,
        "the text has none: we start at phi = 0 with speeds on both sides of 5.07 rad/s",
        reference=f"{', '.join(f'{v:g}' for v in STARTS)} rad/s at phi = 0",
        candidates=tuple(found),
    )


def end_of(phi: float, speed: float) -> str:
    """Return what the example does from a start: whether it comes round three times."""
    derivative = get_scene(SCENE).right_hand_side(EXAMPLE)

    def back(t: float, x: Array) -> float:
        return float(x[1]) + 1e-12

    def round_(t: float, x: Array) -> float:
        return float(x[0]) - phi - 6 * np.pi

    back.terminal = round_.terminal = True  # type: ignore[attr-defined]
    back.direction = -1  # type: ignore[attr-defined]
    found = solve_ivp(derivative, (0, 200), [phi, speed], "DOP853", events=[back, round_])
    return "rotation" if len(found.t_events[1]) else "rest"


ROWS = (
    *speed_regulator_derivation.ROWS,
    Row(
        "formula_21", "claim", "equation (21)",
        "Stabilised speed from torque, damper and lengths.", formula_21, slow=True,
    ),
    Row(
        "asymptote", "claim", "1, 4",
        "Averaging in van der Pol's manner gives the speed.", asymptote, slow=True,
    ),
    Row(
        "linear_law", "claim", "3, figure 3",
        "The stabilised speed grows linearly with the torque, for several dampers.", linear_law,
        slow=True,
    ),
    Row(
        "linear_law_everywhere", "claim", "3, below (21)",
        "The linear law holds for the engine's torque without a limit.", linear_law_everywhere,
        slow=True,
    ),
    Row(
        "energy_balance", "claim", "3, 4",
        "At the operating speed the damper takes what the motor gives.", energy_balance, slow=True,
    ),
    Row(
        "stabilised_speed", "number", "3, figure 4",
        "Speed at which the motion stabilises.", stabilised_speed,
        printed=f"{PRINTED_SPEED} rad/s", slow=True,
    ),
    Row(
        "unit_of_the_speed", "misprint", "caption of figure 4",
        "Unit of the stabilised angular speed.", unit_of_the_speed, printed="m/s",
        test=TESTS + "test_the_stabilised_speed_is_no_length_per_time",
    ),
    Row(
        "stabilises", "claim", "2, 3",
        "Under a constant torque the speed becomes constant on average.", stabilises, slow=True,
    ),
    Row(
        "independent_of_start", "claim", "3, figure 4",
        "Different initial conditions end at the same speed.", independent_of_start, slow=True,
    ),
    Row(
        "every_start", "claim", "3, figure 4",
        "Initial conditions do not matter at all.", every_start, slow=True,
    ),
    Row(
        "damping_slows", "claim", "3, figure 5",
        "A stronger damper stabilises at a lower speed, from the same start.", damping_slows,
        printed="c = 2, 3, 4", slow=True,
    ),
    Row(
        "quasi_uniform", "claim", "abstract, 4",
        "The stabilised rotation is nearly uniform.", quasi_uniform, slow=True,
    ),
    Row(
        "braked", "claim", "3, figure 6",
        "Where the damper takes more than the motor gives, a damped vibration results.", braked,
        slow=True,
    ),
    Row(
        "phase_space", "claim", "3, figure 7",
        "Trajectories of the slider in its phase plane go to a limit cycle.", phase_space,
        slow=True,
    ),
    Row(
        "limit_cycle_stable", "claim", "abstract, 4",
        "Limit cycles and their stability are established.", limit_cycle_stable, slow=True,
    ),
    Row(
        "conditions", "claim", "abstract, 4",
        "Conditions of the nearly uniform motion are those of (20).", conditions, slow=True,
    ),
    Row(
        "spring_and_torque", "claim", "3, 4",
        "They do not depend on the spring.", spring_and_torque, slow=True,
    ),
    Row(
        "design", "claim", "4",
        "A damper for an imposed speed can be chosen by the formula.", design,
    ),
    Row("resonance", "claim", "4", "Resonance conditions are studied.", resonance),
    Row(
        "missing_parameters", "reading", "3",
        "Masses, lengths, spring and torque are not given.", missing_parameters, slow=True,
    ),
    Row(
        "damper_of_figure_4", "reading", "figure 4",
        "To which damper 5.07 rad/s belongs.", damper_of_figure_4,
        printed=f"{PRINTED_SPEED} rad/s",
    ),
    Row(
        "spring_reference", "reading", "2, 3",
        "Where the spring is at rest.", spring_reference, slow=True,
    ),
    Row(
        "axes_of_figure_3", "reading", "figure 3",
        "Dampers and range of torques.", axes_of_figure_3, slow=True,
    ),
    Row(
        "tolerance_of_the_solver", "reading", "3",
        "Solver and tolerance of the numerical integration.", tolerance_of_the_solver,
        printed=f"{PRINTED_SPEED} rad/s", slow=True,
    ),
    Row(
        "starts_of_figure_4", "reading", "figure 4",
        "Initial conditions.", starts_of_figure_4,
    ),
    Row(
        "braking_of_figure_6", "reading", "figure 6",
        "How the motion is braked.", braking_of_figure_6, slow=True,
    ),
)  # fmt: skip

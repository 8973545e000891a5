"""What the paper on `rotating_beam` leaves open, and what each way of reading it gives."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.linalg import eigh

from ....reference.linear import linearise
from ....reference.rotating_beam.cases import FIGURE_5
from ....reference.rotating_beam.frequencies.assumed_modes import best_mass_position, crossover
from ....reference.rotating_beam.frequencies.numbers import numbers
from ....reference.rotating_beam.parameters import RotatingBeam
from ....reference.rotating_beam.scene import SCENE, beam_scene, critical_speed
from ....reference.rotating_beam.shapes import cantilever_modes
from ....reference.solve.single import solve
from ...engines.registry import REFERENCE
from ..ledger import NOT_REPRODUCED, NOT_TESTABLE, Finding, Row
from .misprints import linear_pulse
from .results import (
    BEAM,
    FIRST_VARIABLE,
    HUB_RADIUS,
    LOADS,
    MASSES,
    PRINTED_MAXIMA,
    SPEED,
    Run,
    beam_of,
    by_ratio,
    by_speed,
    crossed,
    listed,
    loaded,
    matched,
    peak,
    run,
    told_by_mass,
    yes,
)

if TYPE_CHECKING:
    from ..session import Session


def speed_of_figure_3(session: Session) -> Finding:
    """Show maxima and crossovers at several speeds."""
    speeds = [matched(session, mass) for mass in LOADS]
    candidates = []
    for speed in (4.0, speeds[2], SPEED, speeds[0], 10.0, 15.0):
        two, mine = (
            [best_mass_position(loaded(m, speed), modes) for m in LOADS] for modes in (2, None)
        )
        crossed = crossover(loaded(LOADS[0], speed), modes=2), crossover(loaded(LOADS[0], speed))
        candidates.append(
            (
                f"{speed:.4g} rad/s",
                f"maxima {listed(two, 3)} with two assumed modes, {listed(mine, 3)} converged; "
                f"crossover of 0.4 kg {crossed[0]:.3f} and {crossed[1]:.3f}",
            )
        )
    reason = (
        f"no one speed gives all three maxima: two assumed modes have them at {listed(speeds)} "
        f"rad/s; taken here: {SPEED:g} rad/s"
    )
    return Finding(NOT_REPRODUCED, reason, f"{SPEED:g} rad/s", candidates=tuple(candidates))


def modes_of_figure_3(session: Session) -> Finding:
    """Show the maxima by the number of assumed modes."""
    printed = np.array(list(PRINTED_MAXIMA.values()))
    off, candidates = {}, []
    for modes in (1, 2, 3, 4, None):
        found = np.array([best_mass_position(loaded(mass), modes) for mass in LOADS])
        name = f"{modes} assumed mode{'s' if modes != 1 else ''}" if modes else "converged"
        off[name] = float(np.max(np.abs(found - printed)))
        candidates.append((name, f"{listed(found)}: off by up to {off[name]:.4f}"))
    best = min(off, key=lambda name: off[name])
    reason = (
        f"the text only says n; at {SPEED:g} rad/s {best} come nearest to the printed maxima, "
        f"within {off[best]:.4f}, and are not converged"
    )
    return Finding(NOT_TESTABLE, reason, best, candidates=tuple(candidates))


def axis_of_figure_2(session: Session) -> Finding:
    """Show that what is said of figure 2 holds on either axis."""
    by_mass = by_speed(session).variables[FIRST_VARIABLE]
    along = by_ratio(session).variables[FIRST_VARIABLE]
    lower, less = np.diff(by_mass, axis=0) < 0, np.diff(along, 2, axis=1) > 0
    return Finding(
        NOT_TESTABLE,
        "the text names neither the axis nor its range; both are drawn",
        candidates=(
            ("speed, curves by mass", f"lowered by each further 0.4 kg: {yes(lower)}"),
            ("mass ratio, curves by speed", f"lowered, and less and less: {yes(less)}"),
        ),
    )


def masses_of_responses(session: Session) -> Finding:
    """Show what each mass does in figures 4 and 5."""
    peaks, pulses = (told_by_mass(session, figure, peak)[0] for figure in (4, 5))
    candidates = tuple(
        (f"{mass:g} kg", f"largest deflection {a:.4g} m in figure 4, {b:.3g} m in figure 5")
        for mass, a, b in zip(MASSES, peaks, pulses, strict=True)
    )
    reason = "the text names none; taken here: those of section 3.1, and none"
    return Finding(NOT_TESTABLE, reason, candidates=candidates)


class Pulse(NamedTuple):
    """What figure 5 would show, by mass."""

    angle: list[float]
    """After the pulse [rad]"""
    largest: list[float]
    """Deflection [m]"""
    left: list[float]
    """Deflection after the pulse [m]"""

    def __str__(self) -> str:
        """Return it in words."""
        return (
            f"angle after 10 s {listed(self.angle, 3)} rad, largest deflection "
            f"{listed(self.largest, 3)} m, left after the pulse {listed(self.left, 2)} m"
        )


def pulse(p: RotatingBeam) -> Pulse:
    """Return it for these parameters, linear about rest."""
    times = np.linspace(0.0, 20.0, 641)
    shown_by_mass = Pulse([], [], [])
    for mass in MASSES:
        found = linear_pulse(p.replace(mass=mass), times)
        tip = np.abs(found["tip_deflection"])
        shown_by_mass.angle.append(float(found["theta"][times == p.torque_period][0]))
        shown_by_mass.largest.append(float(np.max(tip)))
        shown_by_mass.left.append(float(np.max(tip[times > p.torque_period])))
    return shown_by_mass


def hub_of_figure_5(session: Session) -> Finding:
    """Show figure 5 for several hubs."""
    found = {j: pulse(FIGURE_5.replace(hub_inertia=j)) for j in (0.0, 10.0, 100.0)}
    alike = all(
        np.all(np.diff(one.angle) < 0) and np.all(np.diff(one.largest) > 0)
        for one in found.values()
    )
    reason = "the text gives none, and prints no value that would tell; taken here: 10 kg m^2. " + (
        "With all of them the angle falls and the deflection grows with the mass"
        if alike
        else "What is said of the figure does not hold for all of them"
    )
    candidates = tuple((f"J_h = {j:g} kg m^2", str(one)) for j, one in found.items())
    return Finding(NOT_TESTABLE, reason, "10 kg m^2", candidates=candidates)


def hub_radius_of_figures(session: Session) -> Finding:
    """Show what the hub radius does to figures 3 and 5."""
    candidates = []
    for radius in (0.0, HUB_RADIUS):
        n = [numbers(BEAM.replace(hub_radius=radius, mass=mass)) for mass in LOADS]
        crossing = [crossed(crossover(n[0], modes=modes)) for modes in (2, None)]
        shapes = ", ".join(
            f"{words} maxima {listed([best_mass_position(one, modes) for one in n], 3)}"
            for words, modes in (("two assumed modes'", 2), ("converged", None))
            if crossing[0] != "nowhere"
        )
        candidates.append(
            (
                f"a = {radius:g} m",
                f"at {SPEED:g} rad/s: crossover of 0.4 kg {crossing[0]} with two assumed modes, "
                f"{crossing[1]} converged; {shapes or 'no maxima'}; figure 5: "
                f"{pulse(FIGURE_5.replace(hub_radius=radius))}",
            )
        )
    reason = (
        "8 m in section 3.1, 0 for figure 4, none for figure 5; taken here: 8 m for frequencies, 0 "
        "for both responses"
    )
    return Finding(NOT_TESTABLE, reason, "8 m and 0", candidates=tuple(candidates))


def model_of_figure_4(session: Session) -> Finding:
    """Show the peaks of figure 4 by several models."""
    times = np.arange(1, 8 * 16 + 1) / 16
    scenes = {
        "exact, any deflection": SCENE,
        "(14) to (16) corrected, converged": beam_scene("second_order", 8, 0),
        "(14) to (16) corrected, two modes": beam_scene("second_order", 2, 1, cantilever_modes),
    }
    peaks: dict[str, list[float]] = {}
    for name, scene in scenes.items():
        peaks[name] = []
        for mass in (LOADS[0], LOADS[-1]):
            p = beam_of(4, mass)
            values = scene.observe(solve(scene, p, scene.state({}), times).states, p)
            peaks[name].append(peak(Run(times, values), p))
    exact, converged, _ = peaks.values()
    off = [100 * (b / a - 1) for a, b in zip(exact, converged, strict=True)]
    candidates = [(name, f"{listed(found)} m with 0.4 and 1.2 kg") for name, found in peaks.items()]
    critical = critical_speed(beam_of(4, LOADS[0]))
    candidates.append(
        (
            "without the second-order coupling",
            f"none: it diverges above {critical:.3g} rad/s with 0.4 kg, and the hub gets to 10",
        )
    )
    reason = (
        f"the second-order equations overshoot the largest deflection by {listed(off, 2)} % with "
        "0.4 and 1.2 kg; the text prints no value that would tell; taken here: the exact ones"
    )
    return Finding(NOT_TESTABLE, reason, f"{listed(exact)} m", candidates=tuple(candidates))


def damping(session: Session) -> Finding:
    """Show what damping would do in the free part of figure 5."""
    p = FIGURE_5.replace(mass=LOADS[0])
    size = len(SCENE.coordinates)
    mass, _, stiffness = linearise(SCENE, p, np.zeros(2 * size))
    omega = float(np.sqrt(eigh(stiffness, mass, eigvals_only=True)[1]))
    candidates = tuple(
        (
            f"{100 * ratio:g} % of critical",
            f"{np.exp(-ratio * omega * 10):.3g} of the amplitude is left after 10 s more",
        )
        for ratio in (0.0, 0.001, 0.01)
    )
    reason = (
        f"the text names none and (14) to (16) have none; taken here: none. First mode with a free "
        f"hub and 0.4 kg: {omega:.3g} rad/s"
    )
    return Finding(NOT_TESTABLE, reason, "none", candidates=candidates)


def angle_of_figure_5(session: Session) -> Finding:
    """Show the angle of the hub, and that of the free end."""
    candidates: Mapping[str, Any] = {"of the hub, theta": [], "of the free end from the axis": []}
    for mass in MASSES:
        found = run(session, 5, REFERENCE, mass)
        end = found.times == FIGURE_5.torque_period
        along = FIGURE_5.length + found.values["tip_axial"]
        lag = np.arctan2(found.values["tip_deflection"], along)
        for part, angle in zip(candidates.values(), (0 * lag, lag), strict=True):
            part.append(float((found.values["theta"] + angle)[end][0]))
    holds = all(np.all(np.diff(found) < 0) for found in candidates.values())
    reason = (
        "the text speaks of the free end's angular displacement; drawn here: the hub's; after 10 s "
        + ("both fall with the mass" if holds else "they do not both fall with the mass")
    )
    return Finding(
        NOT_TESTABLE,
        reason,
        candidates=tuple((name, f"{listed(found)} rad") for name, found in candidates.items()),
    )


def reading(
    name: str, where: str, words: str, find: Callable[[Session], Finding], slow: bool = True
) -> Row:
    """Return the row of what the text leaves open."""
    return Row(name, "reading", where, words, find, slow=slow)


READINGS = (
    reading("speed_of_figure_3", "3.1", "angular speed of figure 3", speed_of_figure_3),
    reading("modes_of_figure_3", "3.1", "number n of assumed modes", modes_of_figure_3),
    reading("axis_of_figure_2", "figure 2", "what figure 2 is drawn over", axis_of_figure_2),
    reading("masses_of_responses", "3.2", "masses of figures 4 and 5", masses_of_responses),
    reading("model_of_figure_4", "3.2", "equations behind figure 4", model_of_figure_4),
    reading("hub_of_figure_5", "3.2", "hub inertia of figure 5", hub_of_figure_5, slow=False),
    reading("hub_radius_of_figures", "3", "hub radius of each figure", hub_radius_of_figures),
    reading("damping", "3.2", "damping of figures 4 and 5", damping, slow=False),
    reading("angle_of_figure_5", "figure 5", "whose angle figure 5 (a) shows", angle_of_figure_5),
)

"""What readings of the rotating_beam paper give, computed anew: the texts of the ledger hold."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.linalg import eigh

from mbcheck.comparisons.engines.registry import REFERENCE
from mbcheck.comparisons.papers.rotating_beam.readings import READINGS
from mbcheck.comparisons.papers.rotating_beam.responses import by_mass
from mbcheck.comparisons.papers.rotating_beam.results import (
    BEAM,
    FIRST_VARIABLE,
    HUB_RADIUS,
    LOADS,
    MASSES,
    PRINTED_MAXIMA,
    SPEED,
    Response,
    beam_of,
    by_ratio,
    by_speed,
    crossed,
    loaded,
    matched,
    peak,
    response,
)
from mbcheck.comparisons.papers.rotating_beam.rows import ROWS
from mbcheck.comparisons.papers.session import Session
from mbcheck.reference.linear import linearise
from mbcheck.reference.rotating_beam.cases import FIGURE_5
from mbcheck.reference.rotating_beam.frequencies.assumed_modes import best_mass_position, crossover
from mbcheck.reference.rotating_beam.frequencies.continua import frequencies
from mbcheck.reference.rotating_beam.frequencies.numbers import numbers
from mbcheck.reference.rotating_beam.parameters import RotatingBeam
from mbcheck.reference.rotating_beam.scene import SCENE, beam_scene, critical_speed
from mbcheck.reference.rotating_beam.shapes import cantilever_modes
from mbcheck.reference.solve.single import states_at
from mbcheck.tests.support.papers.rotating_beam import linear_pulse
from mbcheck.tests.support.papers.shared import holds

BY_NAME = {row.name: row for row in READINGS}
SLOW = pytest.mark.slow


def listed(values: Any, digits: int = 4) -> str:
    return ", ".join(f"{value:.{digits}g}" for value in values)


@SLOW
def test_speed_of_figure_3(session: Session) -> None:
    speeds = [matched(session, mass) for mass in LOADS]
    words = []
    for speed in (4.0, speeds[2], SPEED, speeds[0], 10.0, 15.0):
        two, converged = (
            [best_mass_position(loaded(m, speed), modes) for m in LOADS] for modes in (2, None)
        )
        places = crossover(loaded(LOADS[0], speed), modes=2), crossover(loaded(LOADS[0], speed))
        words.append(
            f"maxima {listed(two, 3)} with two assumed modes, {listed(converged, 3)} converged; "
            f"crossover of 0.4 kg {places[0]:.3f} and {places[1]:.3f}"
        )
    holds(BY_NAME["speed_of_figure_3"], words)
    assert f"at {listed(speeds)} rad/s" in BY_NAME["speed_of_figure_3"].reason
    assert np.ptp(speeds) > 0.1  # no one speed


@SLOW
def test_modes_of_figure_3() -> None:
    printed = np.array(list(PRINTED_MAXIMA.values()))
    off, words = [], []
    for modes in (1, 2, 3, 4, None):
        places = np.array([best_mass_position(loaded(mass), modes) for mass in LOADS])
        off.append(float(np.max(np.abs(places - printed))))
        words.append(f"{listed(places)}: off by up to {off[-1]:.4f}")
    holds(BY_NAME["modes_of_figure_3"], words)
    assert np.argmin(off) == 1  # two assumed modes
    assert f"within {off[1]:.4f}" in BY_NAME["modes_of_figure_3"].reason


@SLOW
def test_axis_of_figure_2(session: Session) -> None:
    assert np.all(np.diff(by_speed(session).variables[FIRST_VARIABLE], axis=0) < 0)
    assert np.all(np.diff(by_ratio(session).variables[FIRST_VARIABLE], 2, axis=1) > 0)


@SLOW
def test_masses_of_responses(session: Session) -> None:
    peaks = zip(*(by_mass(session, REFERENCE, figure, peak) for figure in (4, 5)), strict=True)
    words = [f"largest deflection {a:.4g} m in figure 4, {b:.3g} m in figure 5" for a, b in peaks]
    holds(BY_NAME["masses_of_responses"], words)


class Pulse(NamedTuple):
    """What figure 5 would show, by mass."""

    angle: list[float]
    """After the pulse [rad]"""
    largest: list[float]
    """Deflection [m]"""
    left: list[float]
    """Deflection after the pulse [m]"""

    def __str__(self) -> str:
        return (
            f"angle after 10 s {listed(self.angle, 3)} rad, largest deflection "
            f"{listed(self.largest, 3)} m, left after the pulse {listed(self.left, 2)} m"
        )


def pulse(p: RotatingBeam) -> Pulse:
    """Return it for these parameters, linear about rest."""
    times = np.linspace(0.0, 20.0, 641)
    by_mass = Pulse([], [], [])
    for mass in MASSES:
        motion = linear_pulse(p.replace(mass=mass), times)
        tip = np.abs(motion["tip_deflection"])
        by_mass.angle.append(float(motion["theta"][times == p.torque_period][0]))
        by_mass.largest.append(float(np.max(tip)))
        by_mass.left.append(float(np.max(tip[times > p.torque_period])))
    return by_mass


def test_hub_of_figure_5() -> None:
    pulses = [pulse(FIGURE_5.replace(hub_inertia=inertia)) for inertia in (0.0, 10.0, 100.0)]
    holds(BY_NAME["hub_of_figure_5"], [str(item) for item in pulses])
    for item in pulses:
        assert np.all(np.diff(item.angle) < 0)
        assert np.all(np.diff(item.largest) > 0)


@SLOW
def test_hub_radius_of_figures() -> None:
    words = []
    for radius in (0.0, HUB_RADIUS):
        n = [numbers(BEAM.replace(hub_radius=radius, mass=mass)) for mass in LOADS]
        crossing = [crossed(crossover(n[0], modes=modes)) for modes in (2, None)]
        shapes = ", ".join(
            f"{name} maxima {listed([best_mass_position(one, modes) for one in n], 3)}"
            for name, modes in (("two assumed modes'", 2), ("converged", None))
            if crossing[0] != "nowhere"
        )
        words.append(
            f"at {SPEED:g} rad/s: crossover of 0.4 kg {crossing[0]} with two assumed modes, "
            f"{crossing[1]} converged; {shapes or 'no maxima'}; figure 5: "
            f"{pulse(FIGURE_5.replace(hub_radius=radius))}"
        )
    holds(BY_NAME["hub_radius_of_figures"], words)


@SLOW
def test_model_of_figure_4() -> None:
    times = np.arange(1, 8 * 16 + 1) / 16
    scenes = (
        SCENE,
        beam_scene("second_order", 8, 0),
        beam_scene("second_order", 2, 1, cantilever_modes),
    )
    peaks: list[list[float]] = []
    for scene in scenes:
        peaks.append([])
        for mass in (LOADS[0], LOADS[-1]):
            p = beam_of(4, mass)
            values = scene.observe(states_at(scene, p, scene.state({}), times), p)
            peaks[-1].append(peak(Response(times, values), p))
    words = [f"{listed(item)} m with 0.4 and 1.2 kg" for item in peaks]
    critical = critical_speed(beam_of(4, LOADS[0]))
    words.append(
        f"none: it diverges above {critical:.3g} rad/s with 0.4 kg, and the hub gets to 10"
    )
    holds(BY_NAME["model_of_figure_4"], words)
    off = [100 * (b / a - 1) for a, b in zip(peaks[0], peaks[1], strict=True)]
    assert f"by {listed(off, 2)} %" in BY_NAME["model_of_figure_4"].reason


def test_damping() -> None:
    p = FIGURE_5.replace(mass=LOADS[0])
    mass, _, stiffness = linearise(SCENE, p, np.zeros(2 * len(SCENE.coordinates)))
    omega = float(np.sqrt(eigh(stiffness, mass, eigvals_only=True)[1]))
    left = [np.exp(-ratio * omega * 10) for ratio in (0.0, 0.001, 0.01)]
    holds(
        BY_NAME["damping"],
        [f"{share:.3g} of the amplitude is left after 10 s more" for share in left],
    )
    assert f"0.4 kg: {omega:.3g} rad/s" in BY_NAME["damping"].reason


@SLOW
def test_angle_of_figure_5(session: Session) -> None:
    hub, free_end = [], []
    for mass in MASSES:
        motion = response(session, 5, REFERENCE, mass)
        end = motion.times == FIGURE_5.torque_period
        along = FIGURE_5.length + motion.values["tip_axial"]
        lag = np.arctan2(motion.values["tip_deflection"], along)
        hub.append(float(motion.values["theta"][end][0]))
        free_end.append(float((motion.values["theta"] + lag)[end][0]))
    holds(BY_NAME["angle_of_figure_5"], [f"{listed(angles)} rad" for angles in (hub, free_end)])
    assert np.all(np.diff([hub, free_end]) < 0)


def test_what_cannot_be_tested_tells_right_numbers() -> None:
    reasons = {row.name: row.reason for row in ROWS}
    places = [f"{crossover(loaded(LOADS[0], w)):.3f} at {w:g} rad/s" for w in (4.0, SPEED, 15.0)]
    assert ", ".join(places) in reasons["better_prediction"]
    p = BEAM.replace(mass=0.4, angular_speed=0.0)
    bare, inner = (
        frequencies(p.replace(**change), count=1).omega[0]
        for change in ({"mass": 0.0}, {"mass_position": 0.4})
    )
    assert f"from {bare:.4g} to {inner:.4g} rad/s" in reasons["coupling_of_6"]

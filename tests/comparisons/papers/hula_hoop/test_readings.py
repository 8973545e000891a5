"""What readings of the hula_hoop paper give, computed anew: the texts of the ledger hold."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.papers.hula_hoop.results import (
    EXAMPLE,
    HERTZ,
    LOCKED,
    LONG_RUN,
    NEWTON,
    SCENE,
    STABILITIES,
    LockIn,
    agreement,
    changed,
    example_from_rest,
    example_orbit,
    is_class,
    lock_in,
    motion_map,
    regions,
    samples,
    stability_map,
    stable,
)
from mbcheck.comparisons.papers.outcomes import tables
from mbcheck.comparisons.papers.session import Session
from mbcheck.reference import get_scene
from mbcheck.reference.hula_hoop.equations import HulaHoop
from mbcheck.reference.hula_hoop.floquet import floquet_multipliers
from mbcheck.reference.hula_hoop.theory import paper_solution
from mbcheck.reference.solve.rk8 import rk8_steps
from mbcheck.tests.support.papers.shared import holds
from mbcheck.tests.support.words import agree

pytestmark = pytest.mark.slow

LEDGER = tables(SCENE)[1]
ROWS = {row.name: row for row in LEDGER if row.kind == "reading"}


def from_rest(p: HulaHoop, angles: Any = 0.0) -> list[LockIn]:
    """Return how motions at 3 Hz from rest at some angles [rad] lock in, by the reference."""
    count = np.broadcast(p.damping_ratio, p.hinge_damping_ratio, angles).size
    times = samples(LONG_RUN)
    states = np.zeros((4, len(times), count))
    states[1, 0] = angles
    derivative = get_scene(SCENE).right_hand_side(p)
    for i in range(len(times) - 1):
        states[:, i + 1] = rk8_steps(derivative, states[:, i], times[i], times[i + 1], 1)
    return [lock_in(times, states[1, :, i], states[3, :, i]) for i in range(count)]


def lock_words(end: LockIn) -> str:
    """Return how a motion locks in."""
    if abs(end.turns) < LOCKED:
        return "no lock-in, no turns in the end"
    if abs(end.turns - 1) > LOCKED:  # chaos: how many turns depends on the last digit
        return "no lock-in, irregular turns"
    words = "forwards" if end.direction > 0 else "backwards"
    backwards = "reverses to the end" if end.least_speed < 0 else "last reversal"
    return (
        f"locks in, turning {words}; last slip {end.last_slip:.2f} s, {backwards} "
        f"{end.last_reversal:.2f} s"
    )


def test_units_of_the_damping(session: Session) -> None:
    """The nondimensional reading locks in as `simulate` says, 0.1 N s/m does not."""
    mass = EXAMPLE.main_mass + EXAMPLE.free_mass
    rho = 0.1 / float(2 * mass * EXAMPLE.omega_n)
    zeta = 0.01 / float(EXAMPLE.free_mass * EXAMPLE.rod_length**2 * EXAMPLE.omega_n)
    ratios = [
        (0.1, 0.01),
        (rho, zeta),
        (rho, 0.01),
        (0.1, zeta),
        (rho, zeta * EXAMPLE.rod_length**2),
        (0.05, 0.01),
        (0.1, 0.02),
    ]
    damping, hinge = np.array(ratios).T
    ends = from_rest(EXAMPLE.replace(damping_ratio=damping, hinge_damping_ratio=hinge))
    holds(ROWS["damping_units"], [lock_words(end) for end in ends])
    assert agree(ROWS["damping_units"].reference, lock_words(ends[0]))
    run = example_from_rest(session)
    single = lock_in(run.times, run.observables["theta"], run.observables["theta_dot"])
    assert ends[0].last_reversal == pytest.approx(single.last_reversal, abs=0.01)
    assert abs(ends[0].turns - 1) < LOCKED < abs(ends[2].turns - 1)


def test_starts_near_rest() -> None:
    angles = np.array([0.0, 1e-6, -1e-6, 1e-3, -1e-3, 1e-2, -1e-2, 0.1, -0.1])
    words = [lock_words(end) for end in from_rest(EXAMPLE, angles)]
    holds(ROWS["start"], words)
    assert all(word.startswith("locks in") for word in words)


def test_robust_points_of_figure_5(session: Session) -> None:
    """The others hang on the last bit, which moves one in a hundred of all points."""
    robust = float(np.mean(motion_map(session, False).variables["robust"] == 1))
    told = re.search(r"In fig\. 5 (\d+)% of", ROWS["start"].reason)
    assert told is not None
    assert int(told[1]) == pytest.approx(100 * robust, abs=1.5)


def test_axes_of_the_maps() -> None:
    axes = [(HERTZ, NEWTON), (HERTZ, (5.0, 100.0)), ((1.0, 20.0), NEWTON), ((2.0, 8.0), NEWTON)]
    words = []
    for hertz, newton in axes:
        parts = []
        for plate in (False, True):
            p = HulaHoop(
                force_frequency=np.linspace(*hertz, 24)[None, :],  # type: ignore[arg-type]
                force_amplitude=np.linspace(*newton, 24)[:, None],  # type: ignore[arg-type]
                **changed(plate),
            )
            multiplier = np.abs(floquet_multipliers(paper_solution(p), p)[0])
            count = len(regions(multiplier >= 1))
            parts.append(f"{np.mean(multiplier < 1):.0%} stable, {count} unstable regions")
        words.append(f"fig. 4 {parts[0]}; fig. 6 {parts[1]}")
    holds(ROWS["axes_of_maps"], words)


def test_solution_that_figures_were_drawn_with(session: Session) -> None:
    words = []
    for name in STABILITIES:
        parts = []
        for plate in (False, True):
            match = agreement(session, plate, name).share
            count = len(regions(~stable(session, plate, name)))
            parts.append(f"{count} unstable regions, {match:.0%} like fig. {7 if plate else 5}")
        words.append(f"fig. 4 {parts[0]}; fig. 6 {parts[1]}")
    holds(ROWS["drawn_solution"], words)


def test_limits_between_classes(session: Session) -> None:
    values = motion_map(session, False).variables
    limits = [
        (0.5 / 120, 0.02, 0.0),
        (0.25 / 120, 0.02, 0.0),
        (0.05, 0.02, 0.0),
        (0.5 / 120, 0.1, 0.0),
        (0.5 / 120, 0.02, -0.05),
    ]

    def shares(slack: float, near_two: float, least: float) -> str:
        with np.errstate(invalid="ignore"):
            turns = np.abs(values["turns"] - 1) < slack
            two = np.abs(values["f_u"] - 2) < near_two
            forward = values["min_speed"] >= least
        classes = {
            "blue o": turns & two & forward,
            "blue +": turns & two & ~forward,
            "cyan o": turns & ~two & forward,
            "cyan +": turns & ~two & ~forward,
            "red x": ~turns,
        }
        return ", ".join(f"{name} {np.mean(where):.0%}" for name, where in classes.items())

    holds(ROWS["class_definitions"], [shares(*item) for item in limits])


def test_power_that_a_generator_could_take(session: Session) -> None:
    power = example_orbit(session).power
    words = f"takes {-power['hinge']:.3g} W of the {power['force']:.3g} W"
    (row,) = (row for row in LEDGER if row.name == "energy_scavenging")
    assert words in row.reason
    assert row.reference == f"{-power['hinge']:.3g} W"


def test_definition_of_hula_hoop_motion(session: Session) -> None:
    motion, plane = motion_map(session, False), stability_map(session, False)
    u_1 = plane.variables["u_1"][is_class(plane, "stability", "stable")]
    words = [f"{np.mean(u_1 == 0):.1%}; the least u_1 is {np.min(u_1):.4f} rad"]
    kinds = ("blue_o", "blue_plus", "cyan_o", "cyan_plus")
    for several in (kinds[:1], kinds[:2], kinds):
        shares = [np.mean(is_class(motion, "motion", name)) for name in several]
        words.append(f"{sum(shares):.0%}")
    holds(ROWS["definition"], words)

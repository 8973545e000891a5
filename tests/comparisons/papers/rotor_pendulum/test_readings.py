"""What readings of the rotor_pendulum paper give, computed anew: the texts of the ledger hold."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from mbcheck.comparisons.papers.ledger import REPRODUCED, rounds_to
from mbcheck.comparisons.papers.rotor_pendulum.readings import READINGS
from mbcheck.comparisons.papers.rotor_pendulum.results import (
    CASES,
    PRINTED_RATIOS,
    REDUCED,
    Settled,
    settled,
)
from mbcheck.comparisons.papers.session import Session
from mbcheck.reference.rotor_pendulum.cases import CASE_1, CASE_2
from mbcheck.reference.rotor_pendulum.equations import RotorPendulum, coefficients, operating_speed
from mbcheck.tests.support.words import agree

from .test_misprints import motor_slope

pytestmark = pytest.mark.slow

ROWS = {row.name: row for row in READINGS}


def holds(name: str, words: Sequence[str], reproduced: bool) -> None:
    """Assert that candidates give these words, and whether the first has the printed value."""
    row = ROWS[name]
    for given, computed in zip(row.candidates.values(), words, strict=True):
        assert agree(given, computed)
    assert agree(row.reference, words[0])
    assert (row.verdict == REPRODUCED) == reproduced


def orbits(*several: RotorPendulum, model: str = "exact") -> list[Settled]:
    return settled(Session(), several, model)


def test_motor_constants() -> None:
    readings = (
        CASE_1,
        CASE_1.replace(friction=0.0),
        CASE_1.replace(motor_slope=motor_slope(1)),
        CASE_1.replace(motor_slope=motor_slope(2)),
    )
    words = []
    for p in readings:
        slope, speed = float(p.motor_slope), float(operating_speed(p))
        words.append(
            f"{slope * (50 * np.pi - 153.8):.3g} N m at 153.8 rad/s; alone it turns at "
            f"{speed:.2f} rad/s with {slope * (50 * np.pi - speed):.3g} N m"
        )
    (orbit,) = orbits(CASE_1)
    holds("motor_constants", words, rounds_to(orbit.speed, "153.8"))
    assert agree(ROWS["motor_constants"].reason.partition("orbit is then ")[2], orbit.words)


def test_stiffness_or_ratio() -> None:
    for case, printed in ((1, "153.8"), (2, "153.5")):
        p, n = CASES[case], PRINTED_RATIOS[case]
        c, w = coefficients(p), float(p.synchronous_speed)

        def with_ratios(mass: float, inertia: float) -> RotorPendulum:
            return p.replace(  # noqa: B023
                platform_stiffness=mass * (w / n.n_x) ** 2,  # noqa: B023
                rod_stiffness=inertia * (w / n.n_phi) ** 2,  # noqa: B023
            )

        found = orbits(
            p,
            with_ratios(c.mass, c.end_mass * c.length**2),
            with_ratios(c.platform, (c.platform + c.rod) * c.length**2),
        )
        words = [orbit.words for orbit in found]
        holds(f"stiffness_or_ratio_{case}", words, rounds_to(found[0].speed, printed))


def test_placement_of_the_motor() -> None:
    words = []
    for placement in ("absolute", "relative"):
        one, two = (
            orbits(CASES[case].replace(motor_placement=placement))[0].words for case in (1, 2)
        )
        words.append(f"case 1: {one}; case 2: {two}")
    holds("motor_placement", words, True)


def test_exact_or_reduced_equations() -> None:
    words = []
    for model in ("exact", REDUCED):
        one, two = (orbits(CASES[case], model=model)[0].words for case in (1, 2))
        words.append(f"case 1: {one}; case 2: {two}")
    holds("equations", words, True)


def test_damper_of_the_rod() -> None:
    found = orbits(*(CASE_2.replace(rod_damping=value) for value in (15.0, 3.0, 0.3, 0.0)))
    words = [orbit.words for orbit in found]
    holds("rod_damper", words, rounds_to(found[0].phase, "-0.515"))
    torque = float(CASE_2.motor_slope) * (50 * np.pi - 153.5)
    assert f"makes {torque:.2f} N m of 153.5 rad/s" in ROWS["rod_damper"].reason

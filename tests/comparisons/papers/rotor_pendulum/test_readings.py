"""What readings of the rotor_pendulum paper give, computed anew: the texts of the ledger hold."""

from __future__ import annotations

import numpy as np
import pytest

from mbcheck.comparisons.checks.boundary import engine_point
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.papers.rotor_pendulum import regions
from mbcheck.comparisons.papers.rotor_pendulum.cases import (
    gap,
    start_by_curve,
    time_to_speed,
    turn_means,
)
from mbcheck.comparisons.papers.rotor_pendulum.readings import READINGS
from mbcheck.comparisons.papers.rotor_pendulum.results import (
    BETAS,
    CASES,
    PRINTED_RATIOS,
    REDUCED,
    Settled,
    from_rest,
    orbit_value,
    settled,
    synchronous_orbit,
)
from mbcheck.comparisons.papers.rotor_pendulum.rows import (
    MUTUAL,
    STATOR,
    equation_14,
    motor_slope,
)
from mbcheck.comparisons.papers.session import Session
from mbcheck.comparisons.queries.query import choose_engine, choose_method
from mbcheck.reference.rotor_pendulum import CASE_1, CASE_2, theory
from mbcheck.reference.rotor_pendulum.equations import RotorPendulum, coefficients, operating_speed
from mbcheck.reference.rotor_pendulum.phase import wrapped
from mbcheck.reference.scene import Case
from mbcheck.tests.support.papers.shared import holds
from mbcheck.tests.support.words import agree

pytestmark = pytest.mark.slow

ROWS = {row.name: row for row in READINGS}


def test_the_first_reading_is_ours() -> None:
    for row in READINGS:
        assert row.reference in ("", next(iter(row.candidates.values())))


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
    holds(ROWS["motor_constants"], words)
    assert agree(ROWS["motor_constants"].reason.partition("orbit is then ")[2], orbit.words)


def test_hundred_kilograms() -> None:
    words = []
    for platform in (100.0, 86.0):
        masses = [case.replace(platform_mass=platform) for case in (CASE_1, CASE_2)]
        mass = float(coefficients(masses[0]).mass)
        springs = " and ".join(f"{mass * (157 / n) ** 2:.0f} N/m" for n in (0.1, 1.0))
        asked = (
            PRINTED_RATIOS[case].n_x / float(theory.ratios(p, speed=1.0).n_x)
            for case, p in enumerate(masses, start=1)
        )
        orbit = synchronous_orbit(Session(), masses[0])
        size = 1e4 * orbit_value(orbit, "platform_amplitude")
        speeds = " and ".join(f"{speed:.1f}" for speed in asked)
        words.append(f"{springs} at 157 rad/s; {speeds} rad/s; {size:.2f}e-4 m")
    holds(ROWS["hundred_kilograms"], words)


def test_inductances() -> None:
    torque = equation_14(Session())["torque"]
    exchanged = torque * (STATOR / MUTUAL) ** 4
    holds(ROWS["inductances"], [f"{value:.3g} N m" for value in (torque, exchanged)])
    assert MUTUAL > STATOR


def test_stiffness_or_ratio() -> None:
    for case in (1, 2):
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
        holds(ROWS[f"stiffness_or_ratio_{case}"], words)


def test_placement_of_the_motor() -> None:
    words = []
    for placement in ("absolute", "relative"):
        one, two = (
            orbits(CASES[case].replace(motor_placement=placement))[0].words for case in (1, 2)
        )
        words.append(f"case 1: {one}; case 2: {two}")
    holds(ROWS["motor_placement"], words)


def test_exact_or_reduced_equations() -> None:
    words = []
    for model in ("exact", REDUCED):
        one, two = (orbits(CASES[case], model=model)[0].words for case in (1, 2))
        words.append(f"case 1: {one}; case 2: {two}")
    holds(ROWS["equations"], words)


def test_damper_of_the_rod() -> None:
    found = orbits(*(CASE_2.replace(rod_damping=value) for value in (15.0, 3.0, 0.3, 0.0)))
    words = [orbit.words for orbit in found]
    holds(ROWS["rod_damper"], words)
    torque = float(CASE_2.motor_slope) * (50 * np.pi - 153.5)
    assert f"makes {torque:.2f} N m of 153.5 rad/s" in ROWS["rod_damper"].reason


def test_motor_curve(session: Session) -> None:
    words = []
    for largest in (None, 8.0, 12.0, 20.0):
        runs = [
            start_by_curve(session, case, largest) if largest else from_rest(session, case)
            for case in (1, 2, 3)
        ]
        gaps = ", ".join(f"{gap(run):.1%}" for run in runs)
        times = ", ".join(f"{time_to_speed(run):.3f}" for run in runs)
        words.append(f"{gaps}; {times} s")
    holds(ROWS["motor_curve"], words)


@pytest.mark.parametrize(("panel", "angle"), [("b", "pi/6"), ("c", "pi/3")])
def test_dampers_of_figure_3(panel: str, angle: str) -> None:
    """By the theory from the sign of cos(alpha); by orbits at folds, and on both sides of them."""
    beta, session = BETAS[angle], Session()
    n_x, places = regions.fold_curve(session, angle)
    n_phi, ends = np.linspace(0.1, 7, 690_001), []
    for x in (n_x[-1], n_x[0]):
        alpha = theory.stable_phase_difference(theory.Ratios(x, n_phi, beta=beta))
        ends.append(n_phi[np.cos(alpha) < 0][[0, -1]])
    (first, last), (later, same) = ends
    assert same == last
    by_theory = (
        f"synphase but for n_phi from resonance, {first:.3f} to {later:.3f} for n_x = {n_x[-1]:g} "
        f"to {n_x[0]:g}, to {last:.4f}"
    )
    words = (
        f"the fold is at n_phi = {', '.join(f'{place:.4f}' for place in places)} for n_x = "
        f"{', '.join(f'{value:g}' for value in n_x)}"
    )
    holds(ROWS[f"limit_3{panel}"], [by_theory, words])
    sides = [regions.at_ratios(x, y, beta) for x in n_x for y in (0.5, 0.8, 0.95, 1.05)]
    found = [orbit.kind for orbit in settled(session, sides)]
    assert found == [*(["synphase"] * 2), *(["none"] * 2)] * len(n_x)


ENGINE_SHIFTS = {"mujoco": (5e-5, 0.07), "exudyn": (6e-7, 0.07)}
"""Of folds with 40 steps in a period, as docs/boundaries.md has them: n_phi, k_phi [N m/rad]."""


@pytest.mark.parametrize("engine", sorted(ENGINE_SHIFTS))
def test_engines_have_the_folds_of_figure_3(engine: str) -> None:
    shifts = []
    for angle in regions.STARTS:
        for one in regions.folds(Session(), angle):
            case = Case("rotor_pendulum", "point", one.parameters)
            its, model = choose_engine(engine, case, None)
            setup = Setup(its, case, model, choose_method(its, case, model, None))
            true = one.solution[1].z
            own = engine_point(setup, one, 40, true).z
            places = [regions.ratio_of(one, z[-1]) for z in (own, true)]
            shifts.append((abs(places[0] - places[1]), one.unit * abs(own[-1] - true[-1])))
    largest, most = np.max(shifts, axis=0), ENGINE_SHIFTS[engine]
    assert 0.5 * most[0] < largest[0] < 1.2 * most[0]
    assert largest[1] < 1.2 * most[1]


def test_duration(session: Session) -> None:
    run = from_rest(session, 1)
    turns = np.abs(wrapped(turn_means(run, run.phase)))
    times = turn_means(run, run.times)
    words = [f"{np.interp(time, times, turns):.2f} rad" for time in (8, 10, 12, 14, 16)]
    holds(ROWS["duration"], words)

"""The ledger of the hula_hoop paper: what its text leaves open, and what each reading gives."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....reference import get_scene
from ....reference.hula_hoop.equations import HulaHoop
from ....reference.hula_hoop.floquet import floquet_multipliers
from ....reference.hula_hoop.theory import paper_solution
from ....reference.solve.flow import rk8_steps
from ..ledger import NOT_REPRODUCED, NOT_TESTABLE, REPRODUCED, Finding, Row
from ..session import Session
from .results import (
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
    lock_in,
    motion_map,
    regions,
    samples,
    stable,
)


def from_rest(p: HulaHoop, angles: Any = 0.0) -> list[LockIn]:
    """Return how motions at 3 Hz from rest at some angles [rad] lock in, by the reference."""
    count = np.broadcast(p.damping_ratio, p.hinge_damping_ratio, angles).size
    times = samples(LONG_RUN)
    found = np.zeros((4, len(times), count))
    found[1, 0] = angles
    derivative = get_scene(SCENE).right_hand_side(p)
    for i in range(len(times) - 1):
        found[:, i + 1] = rk8_steps(derivative, found[:, i], times[i], times[i + 1], 1)
    return [lock_in(times, found[1, :, i], found[3, :, i]) for i in range(count)]


def lock_words(found: LockIn) -> str:
    """Return how a motion locks in."""
    if abs(found.turns - 1) > LOCKED:
        return f"no lock-in: {found.turns:.2f} turns per period in the end"
    words = "forwards" if found.direction > 0 else "backwards"
    backwards = "reverses to the end" if found.least_speed < 0 else "last reversal"
    return (
        f"locks in, turning {words}; last slip {found.last_slip:.2f} s, {backwards} "
        f"{found.last_reversal:.2f} s"
    )


def damping_units(session: Session) -> Finding:
    """The two damping entries of table 1 have no units."""
    mass = EXAMPLE.main_mass + EXAMPLE.free_mass
    rho = 0.1 / float(2 * mass * EXAMPLE.omega_n)
    zeta = 0.01 / float(EXAMPLE.free_mass * EXAMPLE.rod_length**2 * EXAMPLE.omega_n)
    candidates = {
        "rho = 0.1 and zeta_m = 0.01 of (7), (8)": (0.1, 0.01),
        "c = 0.1 N s/m, c_m = 0.01 N m s/rad": (rho, zeta),
        "c = 0.1 N s/m, zeta_m = 0.01": (rho, 0.01),
        "rho = 0.1, c_m = 0.01 N m s/rad": (0.1, zeta),
        "c = 0.1 N s/m, c_m/R_m^2 = 0.01 N s/m": (rho, zeta * EXAMPLE.rod_length**2),
        "2 rho = 0.1, zeta_m = 0.01": (0.05, 0.01),
        "rho = 0.1, zeta_m/2 = 0.01": (0.1, 0.02),
    }
    damping, hinge = np.array(list(candidates.values())).T
    found = from_rest(EXAMPLE.replace(damping_ratio=damping, hinge_damping_ratio=hinge))
    words = [lock_words(item) for item in found]
    return Finding(
        REPRODUCED if abs(found[0].turns - 1) < LOCKED else NOT_REPRODUCED,
        "the motion from rest at 3 Hz and 60 N; the first reading is ours, since the table calls "
        "both entries ratios (its C_m, and s_m, xi_m and zeta_m elsewhere, are one symbol)",
        words[0],
        candidates=tuple(zip(candidates, words, strict=True)),
    )


def start(session: Session) -> Finding:
    """The start at rest, and what is close to it."""
    angles = np.array([0.0, 1e-6, -1e-6, 1e-3, -1e-3, 1e-2, -1e-2, 0.1, -0.1])
    words = [lock_words(item) for item in from_rest(EXAMPLE, angles)]
    motion = motion_map(session, False)
    robust = float(np.mean(motion.variables["robust"] == 1))
    return Finding(
        REPRODUCED if all(word.startswith("locks in") for word in words) else NOT_REPRODUCED,
        "fig. 3 by starts near rest: direction and transient depend on them. In fig. 5 "
        f"{robust:.0%} of the points keep their class when the start is off by 1e-6 and the step "
        "is doubled; only these are compared",
        words[0],
        candidates=tuple(
            (f"theta(0) = {angle:g} rad", word) for angle, word in zip(angles, words, strict=True)
        ),
    )


OTHER_AXES = (
    (HERTZ, NEWTON),
    (HERTZ, (5.0, 100.0)),
    ((1.0, 20.0), NEWTON),
    ((2.0, 8.0), NEWTON),
)


def axes_of_maps(session: Session) -> Finding:
    """Axes of figs. 4-7."""
    words = []
    for hertz, newton in OTHER_AXES:
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
    names = [f"{a:g}-{b:g} Hz, {c:g}-{d:g} N" for (a, b), (c, d) in OTHER_AXES]
    return Finding(
        NOT_TESTABLE,
        "the text gives no axes; the first are ours. The paper has 4 unstable regions in fig. 4, "
        "3 in fig. 6",
        words[0],
        candidates=tuple(zip(names, words, strict=True)),
    )


def drawn_solution(session: Session) -> Finding:
    """Which solution, and which (55), figs. 4 and 6 were drawn with."""
    candidates = []
    for name, words in STABILITIES.items():
        parts = []
        for plate in (False, True):
            where = stable(session, plate, name)
            match = agreement(session, plate, name).share
            count = len(regions(~where))
            parts.append(f"{count} unstable regions, {match:.0%} like fig. {7 if plate else 5}")
        candidates.append((words, f"fig. 4 {parts[0]}; fig. 6 {parts[1]}"))
    return Finding(
        NOT_TESTABLE,
        "the text counts 4 unstable regions in fig. 4 and 3 in fig. 6: with the misprint of (55) "
        "they are not found, so that it is one of print, not of the figures",
        candidates[1][1],
        candidates=tuple(candidates),
    )


def class_definitions(session: Session) -> Finding:
    """Limits between the classes of figs. 5, 7."""
    motion = motion_map(session, False)
    values = motion.variables
    definitions = {
        "ours: half a turn in 120 periods, f_u within 1 %": (0.5 / 120, 0.02, 0.0),
        "a quarter of a turn": (0.25 / 120, 0.02, 0.0),
        "5 % of the turns": (0.05, 0.02, 0.0),
        "f_u within 5 %": (0.5 / 120, 0.1, 0.0),
        "reversals slower than 5 % of omega do not count": (0.5 / 120, 0.02, -0.05),
    }

    def shares(slack: float, near_two: float, least: float) -> str:
        with np.errstate(invalid="ignore"):
            turns = np.abs(values["turns"] - 1) < slack
            two = np.abs(values["f_u"] - 2) < near_two
            forward = values["min_speed"] >= least
        found = {
            "blue o": turns & two & forward,
            "blue +": turns & two & ~forward,
            "cyan o": turns & ~two & forward,
            "cyan +": turns & ~two & ~forward,
            "red x": ~turns,
        }
        return ", ".join(f"{name} {np.mean(where):.1%}" for name, where in found.items())

    words = [shares(*limits) for limits in definitions.values()]
    return Finding(
        NOT_TESTABLE,
        "the paper writes 'about equal' in its table; shares of fig. 5 by each reading",
        words[0],
        candidates=tuple(zip(definitions, words, strict=True)),
    )


ROWS: tuple[Row, ...] = (
    Row(
        "damping_units",
        "reading",
        "table 1",
        "Units of the damping entries 0.1 and 0.01.",
        damping_units,
        slow=True,
    ),
    Row(
        "start",
        "reading",
        "table 1, figures 3, 5, 7",
        "Start exactly at rest; how far the motion depends on it.",
        start,
        slow=True,
    ),
    Row(
        "axes_of_maps",
        "reading",
        "figures 4-7",
        "Ranges of frequency and amplitude.",
        axes_of_maps,
        slow=True,
    ),
    Row(
        "drawn_solution",
        "reading",
        "figures 4, 6",
        "Solution and equation (55) that the figures were drawn with.",
        drawn_solution,
        slow=True,
    ),
    Row(
        "class_definitions",
        "reading",
        "figures 5, 7",
        "Limits between the classes.",
        class_definitions,
        slow=True,
    ),
)

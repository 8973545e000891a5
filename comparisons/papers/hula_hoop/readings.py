"""What the readings of the hula_hoop paper give: each way to read what the text leaves open."""

from __future__ import annotations

from itertools import product

import numpy as np

from ....reference import get_scene
from ....reference.hula_hoop.equations import HulaHoop
from ....reference.hula_hoop.floquet import floquet_multipliers
from ....reference.hula_hoop.theory import paper_solution
from ....reference.scene import Array
from ....reference.solve.rk8 import rk8_steps
from ..ledger import Numbers
from ..session import Session
from .results import (
    EXAMPLE,
    HERTZ,
    LOCKED,
    LONG_RUN,
    NEWTON,
    POINTS,
    SCENE,
    STABILITIES,
    LockIn,
    agreement,
    changed,
    example_orbit,
    is_class,
    lock_in,
    motion_map,
    regions,
    samples,
    stability_map,
    stable,
)

PLATES = (False, True)


def from_rest(p: HulaHoop, angles: Array | float = 0.0) -> list[LockIn]:
    """Return how motions at 3 Hz from rest at some angles [rad] lock in, by the reference."""
    count = np.broadcast(p.damping_ratio, p.hinge_damping_ratio, angles).size
    times = samples(LONG_RUN)
    states = np.zeros((4, len(times), count))
    states[1, 0] = angles
    derivative = get_scene(SCENE).right_hand_side(p)
    for i in range(len(times) - 1):
        states[:, i + 1] = rk8_steps(derivative, states[:, i], times[i], times[i + 1], 1)
    return [lock_in(times, states[1, :, i], states[3, :, i]) for i in range(count)]


def in_words(end: LockIn) -> str:
    """Return how a motion locks in."""
    if abs(end.turns) < LOCKED:
        return "no lock-in, no turns in the end"
    if abs(end.turns - 1) > LOCKED:  # chaos: how many turns depends on the last digit
        return "no lock-in, irregular turns"
    sense = "forwards" if end.direction > 0 else "backwards"
    backwards = "reverses to the end" if end.least_speed < 0 else "last reversal"
    return (
        f"locks in, turning {sense}; last slip {end.last_slip:.2f} s, {backwards} "
        f"{end.last_reversal:.2f} s"
    )


def damping_units(session: Session) -> Numbers:
    """Return how the motion from rest locks in by each reading of the damping of table 1."""
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
    p = EXAMPLE.replace(damping_ratio=damping, hinge_damping_ratio=hinge)
    return {"ends": [in_words(end) for end in from_rest(p)]}


def starts(session: Session) -> Numbers:
    """Return how motions from rest at angles beside 0 lock in, and the robust share of figure 5."""
    angles = np.array([0.0, 1e-6, -1e-6, 1e-3, -1e-3, 1e-2, -1e-2, 0.1, -0.1])
    ends = [in_words(end) for end in from_rest(EXAMPLE, angles)]
    return {"ends": ends, "robust": np.mean(motion_map(session, False).variables["robust"] == 1)}


def axes_of_maps(session: Session) -> Numbers:
    """Return stable shares and numbers of unstable regions on other axes: of figures 4 and 6."""
    axes = [(HERTZ, NEWTON), (HERTZ, (5.0, 100.0)), ((1.0, 20.0), NEWTON), ((2.0, 8.0), NEWTON)]
    shares, counts = np.zeros((2, len(axes), 2))
    for (i, (hertz, newton)), plate in product(enumerate(axes), PLATES):
        p = HulaHoop(
            force_frequency=np.linspace(*hertz, POINTS)[None, :],  # type: ignore[arg-type]
            force_amplitude=np.linspace(*newton, POINTS)[:, None],  # type: ignore[arg-type]
            **changed(plate),
        )
        multiplier = np.abs(floquet_multipliers(paper_solution(p), p)[0])
        shares[i, int(plate)] = np.mean(multiplier < 1)
        counts[i, int(plate)] = len(regions(multiplier >= 1))
    return {"shares": shares, "counts": counts}


def drawn_solution(session: Session) -> Numbers:
    """Return regions and agreement with the motion from rest, of figures 4 and 6, by solution."""
    return {
        name: {
            "counts": [len(regions(~stable(session, plate, name))) for plate in PLATES],
            "shares": [agreement(session, plate, name).share for plate in PLATES],
        }
        for name in STABILITIES
    }


def class_definitions(session: Session) -> Numbers:
    """Return the shares of the classes of figure 5 with other limits between them."""
    values = motion_map(session, False).variables
    limits = {
        "ours": (0.5 / 120, 0.02, 0.0),
        "quarter": (0.25 / 120, 0.02, 0.0),
        "slack": (0.05, 0.02, 0.0),
        "wide": (0.5 / 120, 0.1, 0.0),
        "slow": (0.5 / 120, 0.02, -0.05),
    }
    shares = {}
    for name, (slack, near_two, least) in limits.items():
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
        shares[name] = {one: float(np.mean(where)) for one, where in classes.items()}
    return shares


def definition(session: Session) -> Numbers:
    """Return shares of figure 5 with hula-hoop motion by wider definitions, and of an ideal one."""
    motion, plane = motion_map(session, False), stability_map(session, False)
    u_1 = plane.variables["u_1"][is_class(plane, "stability", "stable")]
    kinds = ("blue_o", "blue_plus", "cyan_o", "cyan_plus")
    shares = [float(np.mean(is_class(motion, "motion", name))) for name in kinds]
    return {
        "ideal": np.mean(u_1 == 0),
        "least": np.min(u_1),
        "shares": [shares[0], sum(shares[:2]), sum(shares)],
    }


def power(session: Session) -> Numbers:
    """Return the mean power of the force, and what the hinge takes [W], of the true rotation."""
    powers = example_orbit(session).power
    return {"hinge": -powers["hinge"], "force": powers["force"]}

"""Where region II of the hula_hoop paper's figures 4 and 6 ends, in newtons."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from ....reference import get_scene
from ....reference.continuation.along import BoundaryAlong
from ....reference.hula_hoop.equations import PLATE, HulaHoop
from ....reference.hula_hoop.floquet import floquet_multipliers
from ....reference.hula_hoop.theory import corrected_solution, paper_solution
from ....reference.scene import Array, Case
from ...checks.kinds.boundary import engine_point
from ...engines.registry import REFERENCE
from ...engines.setup import Setup
from ...queries.query import choose_engine, choose_method
from ..ledger import Numbers
from ..session import Session
from .results import SCENE

LINES = (4.5, 5.0, 5.5, 6.0)
"""Frequencies [Hz] at which region II lies below region I."""

FORCES = np.linspace(5.0, 300.0, 119)
"""Of our axis and as far again, among which the last stable one is looked for [N]."""

NEAR = {False: (32.0, 28.0, 23.0, 18.0), True: (110.0, 95.0, 78.0, 61.0)}
"""Forces [N] near the end without and with inertia, from which it is sought."""

STEPS = 80
"""Of engines in a period."""

FORMULAS = {
    "printed": (paper_solution, True),
    "paper": (paper_solution, False),
    "corrected": (corrected_solution, False),
}


def ends(session: Session, plate: bool) -> list[BoundaryAlong]:
    """Return where the true symmetric rotation loses its stability on each line."""
    p = PLATE if plate else HulaHoop()
    starts = zip(LINES, NEAR[plate], strict=True)
    points = [
        BoundaryAlong(
            get_scene(SCENE),
            p.replace(force_frequency=line, force_amplitude=force),
            "period_doubling",
            "force_amplitude",
        )
        for line, force in starts
    ]
    return session.once((SCENE, "ends of region II", plate), lambda: points)


def formula_end(name: str, p: HulaHoop) -> float:
    """Return the force [N] at which a multiplier of an approximate solution leaves the unit circle.

    The last of `FORCES` where none does below it.
    """
    solution, as_printed = FORMULAS[name]

    def outside(force: Array | float) -> Array:
        here = p.replace(force_amplitude=force)
        return np.abs(floquet_multipliers(solution(here), here, as_printed=as_printed)[0]) - 1

    values = outside(FORCES)
    crossed = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
    if not crossed.size:
        return float(FORCES[-1])
    low, high = FORCES[crossed[0]], FORCES[crossed[0] + 1]
    return float(brentq(lambda force: float(outside(force)), low, high, xtol=1e-9))


def distances(session: Session, plate: bool) -> Numbers:
    """Return the ends by all formulas and the reference [N], and how far they are apart."""
    points = ends(session, plate)
    true = np.array([one.value(one.solution[1].z[-1]) for one in points])
    numbers: dict[str, object] = {"exact": true}
    for name in FORMULAS:
        own = np.array([formula_end(name, one.parameters) for one in points])
        numbers |= {
            name: np.max(np.abs(own - true)),
            f"{name}_share": np.max(np.abs(own - true) / true),
        }
    return numbers


def distances_by(session: Session, who: str, plate: bool) -> Numbers:
    """Return the ends of the reference [N], or how far those of an engine are from them."""
    points = ends(session, plate)
    if who == REFERENCE:
        return {"first": points[0].value(points[0].solution[1].z[-1]),
                "last": points[-1].value(points[-1].solution[1].z[-1])}  # fmt: skip
    off = []
    for one in points:
        case = Case(SCENE, "point", one.parameters)
        engine, model = choose_engine(who, case, None)
        setup = Setup(engine, case, model, choose_method(engine, case, model, None))
        true = one.solution[1].z
        off.append(one.unit * abs(engine_point(setup, one, STEPS, true).z[-1] - true[-1]))
    return {"off": max(off)}

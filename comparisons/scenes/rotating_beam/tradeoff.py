"""How many parts a model of `rotating_beam` needs, and what it may leave out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache, partial
from typing import Any

import numpy as np

from ....reference.rotating_beam import SCENE, beam_scene
from ....reference.rotating_beam.chain import chain_frequencies
from ....reference.rotating_beam.shapes import cantilever_modes, polynomials
from ....reference.scene import Array, Scene
from ....reference.solve.single import solve
from ...checks.kinds.elements import engine_modes, exact, of_continuum
from ...engines.registry import REFERENCE
from ...engines.setup import Setup
from ...faults.variants import EXUDYN, MUJOCO, exudyn, mujoco
from ..tradeoff import (
    ContinuumParts,
    LeftOutRows,
    Pair,
    PairedRun,
    PairNumbers,
    PartKind,
    sample_times,
)

SPIN_UP = SCENE.case("spin_up_quick")
TIP = "tip_deflection"

# Parts --------------------------------------------------------------------------------------

RODS = (2, 4, 8, 16, 32, 64, 128), (2, 4, 8, 16, 32, 48)
FINITE = (2, 4, 8, 16, 32), (2, 4, 8, 16, 32)
MODES = tuple(range(1, 9)), tuple(range(1, 7))


def modal(shapes: Callable[..., Any], count: int) -> Scene:
    """Return the equations of the exact beam with so many modes."""
    return beam_scene("inextensible", count, 0, shapes)


KINDS: Mapping[str, tuple[PartKind, ...]] = {
    MUJOCO: tuple(
        PartKind(f"chain {scheme}", "rods", *RODS, {"scheme": scheme}) for scheme in "AB"
    ),
    EXUDYN: tuple(
        PartKind(element, "elements", *FINITE, {"element": element})
        for element in ("ancf", "geometrically_exact")
    ),
    REFERENCE: tuple(
        PartKind(shapes.__name__, "modes", *MODES, equations=partial(modal, shapes))
        for shapes in (polynomials, cantilever_modes)
    ),
}

CONTINUUM = ContinuumParts(
    kinds=KINDS,
    steady=("steady_at_rest", "steady_4", "steady_12"),
    moving=SPIN_UP.name,
    observable=TIP,
    first_frequency=lambda p, equations: chain_frequencies(p, 1, equations),
)

# What may be left out -----------------------------------------------------------------------


@lru_cache(maxsize=8)
def tip_of(theory: str) -> tuple[Array, int]:
    """Return the tip's deflection [m] by a theory of the reference, and its right-hand sides."""
    scene = SCENE.variants.get(theory, SCENE)
    times = sample_times(SPIN_UP, 2.0**-4)
    solution = solve(scene, SPIN_UP.parameters, scene.state({}), times)
    tip = scene.observe(solution.states, SPIN_UP.parameters)[TIP]
    return np.asarray(tip), solution.rhs_evaluations


def theories(left_out: str, has: str, lacks: str) -> PairNumbers:
    """Compare two theories of the beam by the tip, over its range.

    The one that has it is the truth.
    """
    right = tip_of(has)[0]
    errors = [float(np.max(np.abs(tip_of(one)[0] - right)) / np.ptp(right)) for one in (has, lacks)]
    ratio = tip_of(has)[1] / tip_of(lacks)[1]
    compared = f"{has}, {lacks}"
    return PairNumbers(
        left_out, compared, SPIN_UP.name, (errors[0], errors[1]), (ratio,), "right-hand sides"
    )


def stretch_of_chains(name: str) -> PairNumbers:
    """Tell what rods that do not stretch leave out of the first frequency, and save in steps.

    An explicit method's step goes with the highest frequency: elements that stretch have waves
    along the beam.
    """
    case = SCENE.case(name)
    setups = [
        Setup(engine, case, engine.models(SCENE.name)[0])
        for engine in (exudyn().make(), mujoco().make())
    ]
    error = float(abs(of_continuum(setups[0])[0] / exact(case)[0] - 1))
    fastest = [max(mode.omega for mode in engine_modes(setup)) for setup in setups]
    return PairNumbers(
        "stretch along the beam",
        f"{case.parameters.segments:g} ANCF elements, as many rods: first and highest frequency",
        name,
        (0.0, error),
        (fastest[0] / fastest[1],),
        "steps of an explicit method",
    )


by_elements = partial(PairedRun, exudyn(), "elements", "GeneralizedAlpha", step=2.0**-8)

LEFT_OUT: LeftOutRows = {
    REFERENCE: (
        partial(theories, "stretch along the beam", "extensible", "exact"),
        partial(theories, "large deflections", "exact", "second_order"),
        partial(theories, "foreshortening", "second_order", "zero_order"),
    ),
    MUJOCO: tuple(partial(stretch_of_chains, name) for name in ("steady_4", "steady_12")),
    EXUDYN: (
        Pair(
            "shear and rotary inertia of cross sections",
            f"geometrically_exact, ancf: {SPIN_UP.parameters.segments:g} elements, "
            "GeneralizedAlpha",
            SPIN_UP,
            by_elements({"element": "geometrically_exact"}),
            by_elements({"element": "ancf"}),
        ),
    ),
}

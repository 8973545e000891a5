"""What models of `hula_hoop` may leave out."""

from __future__ import annotations

from dataclasses import replace

from ....models.hula_hoop.mjcf import INERTIA_FLOOR
from ....reference.hula_hoop import SCENE
from ...checks.truth import roundoff_reference
from ...engines.equations import scene_equations
from ...engines.setup import Setup
from ...faults.variants import EXUDYN, MUJOCO, exudyn, mujoco
from ..tradeoff import (
    LeftOutRows,
    Pair,
    PairedRun,
    PairNumbers,
    inertia_floor,
    redundant,
    relative_error,
    sample_times,
    without_solver,
)

SPINNING = SCENE.case("spinning_3hz_60n")
PLATE = replace(
    SCENE.case("semicircle_3hz_60n"),
    name="semicircle_3hz_60n, spinning",
    state=SPINNING.state,
)
"""A free body with inertia, which bodies in space need."""

FLOOR_RATIO = INERTIA_FLOOR / (SPINNING.parameters.free_mass * SPINNING.parameters.rod_length**2)


def floor() -> PairNumbers:
    """Tell what the least inertia that MuJoCo takes changes, by its equations."""
    times = sample_times(SPINNING, 2.0**-7)
    model_equations = Setup(mujoco().make(), SPINNING, "tree").equations
    right, floored = (
        roundoff_reference(equations, SPINNING, times, SCENE.observables)
        for equations in (scene_equations(SPINNING), model_equations)
    )
    compared = f"none, the floor of {INERTIA_FLOOR:g} kg m^2: their equations"
    return inertia_floor(SPINNING, compared, relative_error(floored.values, right))


LEFT_OUT: LeftOutRows = {
    MUJOCO: (floor, without_solver(SPINNING, 0.5)),
    EXUDYN: (
        Pair(
            "point masses without inertia",
            "none, MuJoCo's floor: RK67",
            SPINNING,
            PairedRun(exudyn(), "kinematic_tree", "RK67"),
            PairedRun(exudyn(), "kinematic_tree", "RK67", {"inertia_ratio": FLOOR_RATIO}),
            0.5,
        ),
        *redundant(SPINNING, "kinematic_tree", 0.5),
        Pair(
            "third dimension",
            "bodies in space, plane bodies: GeneralizedAlpha",
            PLATE,
            PairedRun(exudyn("Spatial"), "spatial", "GeneralizedAlpha"),
            PairedRun(exudyn(), "redundant", "GeneralizedAlpha"),
            0.5,
        ),
    ),
}

"""Parts of `speed_regulator` that models may leave out."""

from __future__ import annotations

from ....reference.speed_regulator import SCENE
from ...faults.variants import mujoco
from ..left_out import Pair, PairedModel, absolute_coordinates

ROTATION = SCENE.case("rotation")

LEFT_OUT = (
    Pair(
        "masses of rod and slider",
        ROTATION,
        PairedModel(mujoco(), "connect_hard", "RK4"),
        PairedModel(mujoco(), "transmission", "RK4", {"rod_mass": 0.0, "slider_mass": 0.0}),
    ),
    *absolute_coordinates(ROTATION, "one_dof", 1.0),
)

"""Parts of `rotor_pendulum` that models may leave out."""

from __future__ import annotations

from ....reference.rotor_pendulum import SCENE
from ..left_out import absolute_coordinates

LEFT_OUT = absolute_coordinates(SCENE.case("case_2_startup"), "kinematic_tree", 0.5)

"""Parts of `hula_hoop` that models may leave out."""

from __future__ import annotations

from dataclasses import replace

from ....reference.hula_hoop import SCENE
from ...faults.variants import exudyn
from ..left_out import Pair, PairedModel, absolute_coordinates

SPINNING = SCENE.case("spinning_3hz_60n")
PLATE = replace(SCENE.case("semicircle_3hz_60n"), state=SPINNING.state)
"""A free body with inertia, which bodies in space need."""

LEFT_OUT = (
    *absolute_coordinates(SPINNING, "kinematic_tree", 0.5),
    Pair(
        "third dimension",
        PLATE,
        PairedModel(exudyn("Spatial"), "spatial", "GeneralizedAlpha"),
        PairedModel(exudyn(), "redundant", "GeneralizedAlpha"),
        0.5,
    ),
)

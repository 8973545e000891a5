"""Parts of `rotating_beam` that models may leave out."""

from __future__ import annotations

from functools import partial

from ....reference.rotating_beam import SCENE
from ...faults.variants import exudyn
from ..left_out import Pair, PairedModel, simpler_theory

SPIN_UP = SCENE.case("spin_up_quick")

by_elements = partial(PairedModel, exudyn(), "elements", "GeneralizedAlpha")

LEFT_OUT = (
    simpler_theory("stretch along the beam", SPIN_UP, "extensible", "exact"),
    simpler_theory("large deflections", SPIN_UP, "exact", "second_order"),
    simpler_theory("foreshortening", SPIN_UP, "second_order", "zero_order"),
    Pair(
        "shear and rotary inertia of cross sections",
        SPIN_UP,
        by_elements({"element": "geometrically_exact"}),
        by_elements({"element": "ancf"}),
        step=2.0**-8,
    ),
)

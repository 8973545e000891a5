"""Maps of `hula_hoop`: stability of its rotation, and what it does from rest."""

from __future__ import annotations

from collections.abc import Mapping

from ..quantity import Quantity
from .floquet import EXACT, FLOQUET_VARIABLES, SOLUTIONS, floquet
from .motion import MOTION_VARIABLES, motion

QUANTITIES: Mapping[str, Quantity] = {
    "floquet": Quantity(
        about="stability of the rotation that turns once in a period of the force (figs. 4, 6)",
        variables=FLOQUET_VARIABLES,
        evaluate=floquet,
        models=(EXACT, *SOLUTIONS),
        compilable_models=(EXACT,),
        block=4096,
        engine_block=64,
    ),
    "class": Quantity(
        about="what comes of the scene from rest (figs. 5, 7)",
        variables=MOTION_VARIABLES,
        evaluate=motion,
        of_start=True,
        models=(EXACT, "paper", "corrected"),
        compilable_models=(EXACT,),
        block=1024,
        engine_block=8,
    ),
}

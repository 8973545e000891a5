"""What models of `speed_regulator` may leave out, and how softly its loop may be closed."""

from __future__ import annotations

from ....models.mjcf import Mjcf
from ....models.speed_regulator.mjcf import closed_by
from ....reference.soft_constraint import SOLIMP, SOLREF
from ....reference.speed_regulator import SCENE
from ...faults.variants import EXUDYN, MUJOCO, exudyn, mujoco
from ..tradeoff import ClosureOption, LeftOutRows, LoopClosures, Pair, PairedRun, redundant

ROTATION = SCENE.case("rotation")

LEFT_OUT: LeftOutRows = {
    MUJOCO: (
        Pair(
            "masses of rod and slider",
            "connect_hard, transmission: RK4",
            ROTATION,
            PairedRun(mujoco(), "connect_hard", "RK4"),
            PairedRun(mujoco(), "transmission", "RK4", {"rod_mass": 0.0, "slider_mass": 0.0}),
        ),
    ),
    EXUDYN: redundant(ROTATION, "one_dof", 1.0),
}

CLOSURE_TIMES = tuple(2.0 ** (-k / 4) for k in range(-8, 41))
"""Of MuJoCo's hard closure [s], from soft to hard."""

SOFTNESSES = tuple(2.0 ** (-k / 2) for k in range(2, 27))
"""Of an impedance: 1 - d; MuJoCo's hardest is 1e-4."""

NEWTON_TOLERANCES = tuple(10.0**-k for k in range(12))


def softened(softness: float) -> Mjcf:
    """Return ``connect`` with the default ``solref`` and a constant impedance of 1 less this."""
    impedance = 1 - softness
    return closed_by(SOLREF, (impedance, impedance, *SOLIMP[2:]))


LOOP = LoopClosures(
    "rotation",
    (
        ClosureOption(mujoco(), "connect_hard", "closure_time", "s", CLOSURE_TIMES),
        ClosureOption(
            mujoco("Softened", "connect", softened), "connect", "softness", "1", SOFTNESSES
        ),
        ClosureOption(mujoco(), "connect"),
        ClosureOption(
            exudyn(), "redundant", "newton_tolerance", "m, rad", NEWTON_TOLERANCES, exact=True
        ),
    ),
)

"""Extremes of `speed_regulator`: parameters, starts, long motions, and failures of engines."""

from __future__ import annotations

from functools import partial
from math import pi

import numpy as np

from ....models.speed_regulator.mjcf import closed_by
from ....reference.errors import ParameterError
from ....reference.scene import Case
from ....reference.speed_regulator import SCENE
from ....reference.speed_regulator.equations import SpeedRegulator
from ....reference.speed_regulator.rest import equilibrium
from ...engines.run import contained
from ...engines.variants.catalogue import (
    MUJOCO,
    Observation,
    exudyn,
    mujoco,
)
from ..extremes import (
    CONSERVATIVE,
    FREE,
    LOCKED,
    EngineFailure,
    EngineProbe,
    Extreme,
    FreeVibration,
    LongMotion,
)

crank = partial(Extreme, case="rotation")

PARAMETERS = (
    *(
        crank(name=f"slider_mass_ratio_{r:.0e}", changes={"slider_mass": 0.5 * r})
        for r in (1e-6, 1e-3, 1e3, 1e6)
    ),
    crank(name="rod_mass_ratio_1e-06", changes={"rod_mass": 1e-6}),
    *(crank(name=f"stiffness_{k:.0e}", changes={"stiffness": k}) for k in (1e6, 1e9, 1e12)),
    *(crank(name=f"damping_{c:.0e}", changes={"damping": c}) for c in (1e3, 1e6, 1e9)),
    crank(
        name="rod_length_1e-09",
        changes={"crank_radius": 2e-10, "rod_length": 1e-9, "spring_rest": -1e-9},
    ),
    crank(
        name="massless_rod_and_slider",
        changes={"rod_mass": 0.0, "slider_mass": 0.0},
        models=("connect", "connect_hard", "transmission", "redundant", "one_dof"),
    ),
    *(
        crank(
            name=f"lambda_1-{gap:.0e}",
            changes={"crank_radius": 1.25 * (1 - gap)},
            state={"phi": 1.0, "phi_dot": 5.07},
            horizon=1.0,
            models=("connect", "connect_hard", "redundant", "one_dof"),
        )
        for gap in (1e-1, 1e-3, 1e-9)
    ),
    crank(name="flywheel_1e6", changes={"flywheel_inertia": 1e6}),
    crank(name="speed_1e4", state={"phi_dot": 1e4}),
    crank(name="spring_at_resonance", changes={"stiffness": 5.07**2}),
)
"""Of *mass ratio* to the rod's."""

closed = partial(crank, models=("connect_hard", "redundant"))
opened = partial(
    crank,
    state={"phi_dot": 5.07},
    horizon=1.0,
    models=("connect", "connect_hard", "redundant"),
)
DEFAULT = SpeedRegulator()

STARTS = (
    closed(name="upper_dead_centre", state={"phi": pi / 2, "phi_dot": 5.07}, horizon=1.0),
    closed(name="lower_dead_centre", state={"phi": -pi / 2, "phi_dot": 5.07}, horizon=1.0),
    closed(name="upper_dead_centre_at_rest", state={"phi": pi / 2}, horizon=1.0),
    *(
        closed(name=f"rest_{name}", state=equilibrium(name, DEFAULT), horizon=4.0)
        for name in ("right", "top", "left", "bottom")
    ),
    closed(name="unstable_rest_for_long", state=equilibrium("top", DEFAULT), horizon=12.0),
    *(opened(name=f"open_by_{d:g}_m", offset={"y": d}) for d in (1e-6, 1e-3, 0.1)),
    opened(name="open_by_a_rate", offset={"y_dot": 0.1}),
)

FREE_VIBRATION = FreeVibration(
    {"damping": 0.0, "torque": 0.0},
    "stiffness",
    "damping",
    "phi_dot",
    of_models={"transmission": {"rod_mass": 0.0, "slider_mass": 0.0}},
)

MOTIONS = (
    LongMotion(FREE, "conservative"),
    LongMotion(CONSERVATIVE, "conservative"),
    LongMotion(LOCKED, "limit_cycle", longest=100_000),
)

HARDER = (1 - 1e-8, 1 - 1e-8, 0.001, 0.5, 2.0)
"""An impedance above the 0.9999 that MuJoCo takes."""

loop = partial(
    EngineFailure,
    engine=mujoco(),
    case="rotation",
    models=("connect",),
    method="RK4",
    step=2**-10,
    horizon=2.0,
)
hard = partial(loop, models=("connect_hard",))
joints = partial(loop, engine=exudyn(), models=("redundant",))

FAILURES = (
    # MuJoCo: closed loops
    loop(
        name="default_closure",
        engine=mujoco("WithoutEquations"),
        settings={"solref": "0.02 1", "claims": "a joint"},
    ),
    loop(
        name="closure_softened_by_the_step",
        step=2**-5,
        engine=mujoco("Willing"),
        settings={"solref": "0.02 1"},
    ),
    loop(name="closure_softened_refused", step=2**-5),
    loop(
        name="impedance_clamped",
        engine=mujoco("WithoutEquations", closed_by, (0.02, 1.0), HARDER),
        settings={"solimp": "1-1e-8", "claims": "a joint"},
    ),
    hard(name="hard_closure_long_step", step=2**-7),
    *(
        hard(
            name=f"cg_at_{power}",
            engine=mujoco("Edited", ('tolerance="1e-30"', f'tolerance="{value:g}" solver="CG"')),
            settings={"solver": "CG", "tolerance": value},
        )
        for power, value in (("1e-8", 1e-8), ("1e-2", 1e-2))
    ),
    loop(
        name="closed_loop_without_mass",
        case="massless_rod_and_slider",
        engine=mujoco("WithoutEquations"),
    ),
    loop(name="transmission_carries_no_mass", models=("transmission",), engine=mujoco("Willing")),
    # Exudyn
    joints(name="explicit_with_joints", method="RK44", engine=exudyn("Unrestricted")),
    joints(name="explicit_with_joints_refused", method="RK44"),
    joints(
        name="drift_over_many_turns",
        method="TrapezoidalIndex2",
        step=2**-7,
        horizon=30.0,
        harmless=True,
    ),
    joints(
        name="through_the_dead_centre",
        method="GeneralizedAlpha",
        step=2**-8,
        horizon=1.0,
        changes={"crank_radius": 1.25 * (1 - 1e-9)},
        state={"phi": 1.0, "phi_dot": 5.07},
    ),
)


def too_long_crank(case: Case, model: str) -> Observation:
    """Give the slider-crank transmission a rod that is shorter than the crank."""
    short = 0.8 * case.parameters.crank_radius
    engine = mujoco("Edited", ('cranklength="1.25"', f'cranklength="{short}"')).make()
    method = next(one for one in engine.methods if one.name == "RK4")
    with contained():
        run = engine.simulate(case, model, method, 2**-10, np.array([1.0, 2.0]))
    finite = all(np.all(np.isfinite(values)) for values in run.values.values())
    silently = (
        f"; MuJoCo runs it without a word, and turns to phi = {run.values['phi'][-1]:.3g} rad"
    )
    changed = {"rod_length": short}
    try:
        case.parameters.replace(**changed)
    except ParameterError as error:
        silent = finite and not any(run.warnings.values())
        return Observation(
            "refused", f"the adapter refuses: {error}{silently if silent else ''}", changed=changed
        )
    return Observation("wrong", "nobody refuses a crank longer than its rod", changed=changed)


PROBES = (
    EngineProbe(
        name="crank_longer_than_rod",
        engine=MUJOCO,
        case=SCENE.case("massless_rod_and_slider"),
        model="transmission",
        method="RK4",
        observe=too_long_crank,
    ),
)

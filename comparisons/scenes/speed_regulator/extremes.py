"""Extremes of `speed_regulator`: parameters, starts, long motions, and failures of engines."""

from __future__ import annotations

from functools import partial
from math import pi

from ....models.speed_regulator.mjcf import closed_by
from ....reference.speed_regulator.equations import SpeedRegulator
from ....reference.speed_regulator.motions import equilibrium
from ...checks.kinds.long_runs import CONSERVATIVE, FREE, LOCKED
from ...faults.variants import exudyn, mujoco
from ..extremes import EngineFailure, Extreme, LongMotion

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
"""Extremes of parameters; *mass ratio* is that to the rod."""

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

FREE_VIBRATION = {
    "": {"torque": 0.0},
    "transmission": {"rod_mass": 0.0, "slider_mass": 0.0},
}

MOTIONS = (
    LongMotion(FREE, "conservative"),
    LongMotion(CONSERVATIVE, "conservative"),
    LongMotion(LOCKED, "limit_cycle"),
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

"""Extremes of `hula_hoop`: parameters, starts, long motions, and failures of engines."""

from __future__ import annotations

from functools import partial
from math import pi

from ...checks.kinds.long_runs import CONSERVATIVE, FREE, LOCKED
from ...faults.variants import (
    AUTOMATIC_STEPS,
    DEFAULT_NEWTON,
    DEFAULT_STEPS,
    NEWMARK,
    NO_DAMPING,
    OWN_ERROR_CONTROL,
    exudyn,
    mujoco,
)
from ..extremes import EngineFailure, Extreme, LongMotion

OMEGA = (1000 / 0.495) ** 0.5
"""Natural frequency of main and free mass together [rad/s]."""

AMONG_ALL = 0.045 * 0.0025 * OMEGA
"""Hinge damping [N m s/rad] of the damping ratio 1."""

unforced = partial(
    Extreme,
    case="spinning_unforced",
    state={"y": 0.0, "theta": 0.3, "theta_dot": 18.0},  # suits any stiffness and length
)
driven = partial(Extreme, case="spinning_3hz_60n")

PARAMETERS = (
    *(
        unforced(name=f"mass_ratio_{r:.0e}", changes={"free_mass": 0.45 * r})
        for r in (1e-6, 1e-3, 1e3, 1e6)
    ),
    *(driven(name=f"stiffness_{k:.0e}", changes={"stiffness": k}) for k in (1e6, 1e9, 1e12)),
    *(
        unforced(name=f"damping_{c:.0e}", changes={"damping_ratio": c / (2 * 0.495 * OMEGA)})
        for c in (1e3, 1e6, 1e9)
    ),
    unforced(name="hinge_damping_1e9", changes={"hinge_damping_ratio": 1e9 / AMONG_ALL}),
    *(unforced(name=f"rod_length_{r:.0e}", changes={"rod_length": r}) for r in (1e-3, 1e-6, 1e-9)),
    unforced(name="speed_1e4", state={"theta_dot": 1e4}),
    driven(name="force_at_resonance", changes={"force_frequency": OMEGA / 2 / pi}),
    driven(
        name="force_at_resonance_undamped",
        changes={"force_frequency": OMEGA / 2 / pi, "damping_ratio": 0.0},
    ),
    driven(name="soft_spring_at_resonance", changes={"stiffness": 0.495 * (6 * pi) ** 2}),
)

point_mass = partial(Extreme, case="point_mass_3hz_60n")

STARTS = (
    point_mass(name="rod_across_at_rest", state={}, horizon=1.0),
    point_mass(name="rod_aligned_at_rest", state={"theta": pi / 2}, horizon=1.0),
    point_mass(name="rod_aligned_at_rest_for_long", state={"theta": pi / 2}, horizon=6.0),
    point_mass(name="rod_aligned_nudged", state={"theta": pi / 2 + 1e-6}, horizon=2.0),
    point_mass(name="unforced_at_rest", state={}, horizon=1.0, changes={"force_amplitude": 0.0}),
    point_mass(name="open_by_0.001_m", state={}, horizon=0.5, offset={"y": 1e-3}),
)

MOTIONS = (
    LongMotion(FREE, "free_undamped"),
    LongMotion(CONSERVATIVE, "free_undamped"),
    LongMotion(LOCKED, "spinning_3hz_60n"),
)

hoop = partial(
    EngineFailure,
    engine=mujoco(),
    case="spinning_3hz_60n",
    models=("tree",),
    method="RK4",
    step=2**-10,
    horizon=0.5,
)
tree = partial(hoop, engine=exudyn(), models=("kinematic_tree",), method="GeneralizedAlpha")
redundant = partial(tree, models=("redundant",), step=2**-12)

AUTORESET = mujoco("Edited", (' autoreset="disable"', ""))
OVERDAMPED = {"damping_ratio": 1e4 / (2 * 0.495 * OMEGA)}
CHAOS = {
    "force_amplitude": 10.0,
    "force_frequency": 30 / (2 * pi),
    "damping_ratio": 0.1 / (2 * 0.495 * OMEGA),
    "hinge_damping_ratio": 1e-5 / AMONG_ALL,
}
"""c = 0.1 N s/m and c_m = 1e-5 N m s/rad."""

UNDAMPED = (
    ("generalized_alpha_undamped", "GeneralizedAlpha", NO_DAMPING, {"spectralRadius": 1.0}),
    ("newmark_index_3", "TrapezoidalIndex2", NEWMARK, {"useIndex2Constraints": "False"}),
)
"""Methods of index 3 without numerical damping: name, method, changes, settings."""

FAILURES = (
    # MuJoCo: forces and time
    *(
        hoop(name=name, engine=mujoco("Controlled", *arguments), settings={"ctrl": words})
        for name, arguments, words in (
            ("force_through_ctrl_at_step_start", (0.0,), "at the start of the step"),
            ("force_through_ctrl_at_midpoint", (0.5,), "at the middle of the step"),
            ("ctrl_not_a_number", (0.0, float("nan")), "nan"),
            ("ctrl_huge", (0.0, 1e13), 6e14),
        )
    ),
    hoop(
        name="ctrl_huge_unwarned",
        engine=mujoco("Unwarned", mujoco("Controlled", 0.0, 1e13)),
        settings={"ctrl": 6e14, "warnings": "not read"},
    ),
    hoop(name="step_no_power_of_two", step=1e-3, harmless=True),
    # MuJoCo: instability
    hoop(
        name="automatic_reset",
        method="Euler",
        step=2**-3,
        horizon=25.0,
        engine=AUTORESET,
        settings={"autoreset": "enable"},
    ),
    hoop(
        name="automatic_reset_unwarned",
        method="Euler",
        step=2**-3,
        horizon=25.0,
        engine=mujoco("Unwarned", AUTORESET),
        settings={"autoreset": "enable", "warnings": "not read"},
    ),
    hoop(name="huge_damping_explicit", changes=OVERDAMPED),
    hoop(
        name="huge_damping_implicit",
        method="Euler",
        step=2**-13,
        changes=OVERDAMPED,
        harmless=True,
    ),
    hoop(
        name="acceleration_above_1e10",
        case="spinning_unforced",
        step=2**-25,
        horizon=2**-15,
        changes={"stiffness": 1e12},
        state={"y": 0.1},
    ),
    hoop(
        name="speed_above_1e10",
        case="spinning_unforced",
        step=2**-46,
        horizon=2**-36,
        state={"theta_dot": 2e10},
    ),
    # MuJoCo: discrete
    hoop(name="discrete_dissipates", case="free_undamped", method="discrete"),
    hoop(name="discrete_refused_with_a_clock", method="discrete"),
    hoop(name="discrete_damps_the_clock", method="discrete", engine=mujoco("Willing")),
    # MuJoCo: inertia
    hoop(
        name="no_inertia",
        engine=mujoco("Edited", ("2e-15 2e-15 2e-15", "0 0 0")),
        settings={"diaginertia": 0.0},
    ),
    hoop(
        name="inertia_floor",
        step=2**-13,
        horizon=0.05,
        changes={"rod_length": 1e-4, "free_mass": 1e-5},
    ),
    hoop(
        name="short_frame_taken_for_none",
        case="spinning_unforced",
        changes={"rod_length": 9e-7, "inertia_ratio": 1.0},
        state={"theta": 0.3, "theta_dot": 18.0},
    ),
    # Exudyn: explicit solvers
    tree(name="unstable_is_success", method="RK44", changes={"stiffness": 1e9}),
    tree(name="velocity_verlet", method="VelocityVerlet", engine=exudyn("Unrestricted")),
    tree(name="dverk6", method="DVERK6", engine=exudyn("Unrestricted")),
    tree(
        name="dopri5_error_control",
        method="DOPRI5",
        step=0.025,
        engine=exudyn("Changed", OWN_ERROR_CONTROL),
        settings={"absoluteTolerance": 1e-8},
    ),
    tree(
        name="dopri5_automatic_steps",
        method="DOPRI5",
        step=0.025,
        engine=exudyn("Changed", AUTOMATIC_STEPS),
        settings={"automaticStepSize": "True"},
    ),
    # Exudyn: Newton's method
    tree(
        name="halved_steps",
        step=0.05,
        engine=exudyn("Changed", DEFAULT_STEPS),
        settings={"adaptiveStep": "True"},
    ),
    tree(name="halved_steps_switched_off", step=0.05),
    redundant(
        name="residual_of_a_light_mass",
        changes={"free_mass": 4.5e-7},
        engine=exudyn("Changed", DEFAULT_NEWTON),
        settings={"newton.absoluteTolerance": 1e-10},
        harmless=True,
    ),
    # Exudyn: constraints
    *(
        redundant(
            name=f"{name}_{how}",
            method=method,
            engine=exudyn("Changed", change | newton),
            settings={**settings, "newton": how},
        )
        for how, newton in (("increments", {}), ("residuals", DEFAULT_NEWTON))
        for name, method, change, settings in UNDAMPED
    ),
    # both: chaos
    *(
        of(
            name="chaos",
            method=method,
            step=step,
            horizon=3.0,
            changes=CHAOS,
            state={"theta": 0.3, "theta_dot": 30.0},
        )
        for of, method, step in ((hoop, "RK4", 2**-8), (tree, "RK67", 2**-7))
    ),
)

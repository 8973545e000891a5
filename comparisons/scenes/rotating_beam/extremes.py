"""Extremes of `rotating_beam`: parameters, starts, a long motion, and failures of engines."""

from __future__ import annotations

from functools import partial

from ....reference.rotating_beam import SCENE
from ....reference.rotating_beam.parameters import steady_speed
from ....reference.rotating_beam.scene import critical_speed
from ...checks.kinds.long_runs import AFTER_PULSE
from ...engines.registry import REFERENCE
from ...faults.variants import DEFAULT_STEPS, Variant, exudyn
from ..extremes import EngineFailure, Extreme, LongMotion

LINE = 2766.7 * 7.2968e-5
"""Mass per length [kg/m]."""

SLENDER = 7.2968e-5 / 8.2189e-9
"""EA/EI [1/m^2]."""


def slender(ratio: float) -> dict[str, float]:
    """Return the modulus and the second moment that make EA/EI this [1/m^2] and keep EI."""
    factor = ratio / SLENDER
    return {"youngs_modulus": 6.8952e10 * factor, "second_moment": 8.2189e-9 / factor}


pulse = partial(Extreme, case="pulse_quick", horizon=1.0)

PARAMETERS = (
    *(pulse(name=f"slenderness_{r:.0e}", changes=slender(r)) for r in (1e6, 1e9)),
    pulse(name="tip_mass_ratio_1e3", changes={"mass": 1e3 * 8 * LINE}),
    pulse(name="nondimensional_speed_50", state={"theta_dot": steady_speed(50)}),
    pulse(name="hub_inertia_1e6", changes={"hub_inertia": 1e6, "torque_amplitude": 2e6}),
    pulse(name="flexible_1e-6", changes={"youngs_modulus": 6.8952e4}, full=True),
)

STARTS = (
    Extreme(name="straight_in_rotation", case="steady_4", state={"theta_dot": 3.3}, horizon=0.0625),
)

FREE_VIBRATION = {"": {"angular_speed": 0.0, "segments": 12.0}}

MOTIONS = (LongMotion(AFTER_PULSE, "pulse_quick", segments=8, periods=(100, 1_000)),)

FAST = SCENE.case("above_critical").parameters

FAILURES = (
    EngineFailure(
        name="no_second_order_coupling",
        engine=Variant(REFERENCE, "Undeclared"),  # no engine leaves it out
        case="above_critical",
        models=("zero_order",),
        method="DOP853",
        step=2.0**-6,
        horizon=2.0,
        settings={"angular_speed": FAST.angular_speed, "critical_speed": critical_speed(FAST)},
    ),
    EngineFailure(
        name="stalled_newton",
        engine=exudyn("Changed", DEFAULT_STEPS),
        case="spin_up_quick",
        models=("elements",),
        method="GeneralizedAlpha",
        step=2**-8,
        horizon=0.0625,
        changes={**slender(1e9), "segments": 16.0},
        settings={"adaptiveStep": "True", "newton.absoluteTolerance": 1e-10},
    ),
)

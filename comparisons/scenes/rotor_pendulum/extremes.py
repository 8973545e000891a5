"""Extremes of `rotor_pendulum`: parameters, starts and long motions."""

from __future__ import annotations

from functools import partial

import numpy as np

from ....reference.rotor_pendulum import AT_SPEED, CASE_2
from ....reference.rotor_pendulum.equations import operating_speed
from ....reference.rotor_pendulum.phase import coupling_harmonics
from ...checks.kinds.long_runs import CONSERVATIVE, FREE, LOCKED
from ...faults.variants import EXUDYN
from ..extremes import Extreme, LongMotion

MASS = 114.0
"""All that moves with the platform [kg]."""

startup = partial(Extreme, case="case_2_startup")
rotors = partial(startup, state={"phi_1": 1.06, **AT_SPEED})

PARAMETERS = (
    *(
        rotors(name=f"mass_ratio_{r:.0e}", changes={"rotor_mass": 100 * r})
        for r in (1e-6, 1e-3, 1e3, 1e6)
    ),
    *(
        rotors(name=f"{part}_stiffness_{k:.0e}", changes={f"{part}_stiffness": k})
        for part in ("platform", "rod")
        for k in (1e9, 1e12)
    ),
    *(rotors(name=f"{p}_damping_1e9", changes={f"{p}_damping": 1e9}) for p in ("platform", "rod")),
    *(rotors(name=f"rod_length_{r:.0e}", changes={"rod_length": r}) for r in (1e-3, 1e-6, 1e-9)),
    rotors(
        name="speed_1e4",
        changes={"synchronous_speed": 1e4},
        state={"phi_1": 1.06, "phi_1_dot": 1e4, "phi_2_dot": 1e4},
    ),
    rotors(name="platform_at_resonance", changes={"platform_stiffness": MASS * 153.8**2}),
)
"""Extremes of parameters; *mass ratio* is that of a rotor to the platform."""


def unstable_phase() -> dict[str, float]:
    """Return rotors that turn together with the phase difference that repels them, in case 2."""
    mean, first = coupling_harmonics(CASE_2)
    # where the coupling torque rises with the phase difference
    phase = float(-np.arccos(-mean / abs(first)) - np.angle(first))
    speed = float(operating_speed(CASE_2))
    return {"phi_1": phase, "phi_1_dot": speed, "phi_2_dot": speed}


STARTS = (
    startup(name="at_rest", state={}, horizon=0.25),
    startup(name="unstable_phase", state=unstable_phase(), horizon=0.5),
    startup(name="open_by_0.001_m", state={}, horizon=0.1, offset={"x": 1e-3}),
)

motion = partial(LongMotion, most_steps={EXUDYN: 1 << 15})

MOTIONS = (
    motion(FREE, "conservative"),
    motion(CONSERVATIVE, "conservative"),
    motion(LOCKED, "case_1_synchronous"),
)

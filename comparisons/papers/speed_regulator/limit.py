"""Where the speed_regulator paper's rotation ends: the torque below which it is braked, figure 6.

The limit is a curve of the torque over the damper, by the reference's homoclinic orbits, by what
weak damping takes of the orbit of the spring alone, and by engines that start beside the saddle.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import quad

from ....reference.speed_regulator.equations import SpeedRegulator, coefficients, inertia, position
from ....reference.speed_regulator.motions import found_equilibria, static_stiffness
from ....reference.speed_regulator.theory import Threshold, least_torque
from ...engines.registry import REFERENCE
from ...queries.simulate import simulate
from ..ledger import REPRODUCED, LedgerRow, Numbers, below, equal, holds, statement
from ..session import Session
from .results import DAMPINGS, SCENE, damped

BESIDE = 1e-4
"""Distance from the saddle at which an engine starts [rad]; the rest is what a direction errs."""

SECONDS = 40.0
"""In which a crank that comes round from there has done so [s]."""

AROUND, HALVINGS = 0.04, 14
"""Share of the torque around the limit in which an engine's is looked for, and halvings of it."""

NEAR = 0.01
"""Share of the torque below and above the limit at which motions are looked at."""


def limits(session: Session) -> list[Threshold]:
    """Return the reference's limit for each damper of figure 5."""
    return session.once(
        (SCENE, "homoclinic limits"), lambda: [least_torque(damped(c)) for c in DAMPINGS]
    )


def by_weak_damping(p: SpeedRegulator) -> float:
    """Return the torque [N m] whose work is the damper's along the orbit of the spring alone."""
    c = coefficients(p.replace(torque=0.0))

    def taken(phi: float) -> float:
        at, top = position(phi, c, math), position(math.pi / 2, c, math)
        stored = c.stiffness * ((top.y - c.rest) ** 2 - (at.y - c.rest) ** 2) / 2
        return c.damping * at.y_phi**2 * math.sqrt(2 * max(stored, 0.0) / inertia(at, c))

    halves = ((-math.pi / 2, math.pi / 2), (math.pi / 2, 3 * math.pi / 2))
    return float(sum(quad(taken, *ends, epsabs=1e-12)[0] for ends in halves)) / (2 * math.pi)


def comes_round(who: str, p: SpeedRegulator) -> bool:
    """Return whether a crank that leaves the lower saddle comes round to it, by an engine."""
    c = coefficients(p)
    saddle = found_equilibria(p)["bottom"]
    at = position(saddle, c, math)
    moment, damping = inertia(at, c), c.damping * at.y_phi**2
    softness = -static_stiffness(saddle, c, math)
    rate = (math.sqrt(damping**2 + 4 * moment * softness) - damping) / (2 * moment)
    run = simulate(
        SCENE,
        engine=who,
        parameters={"damping": p.damping, "torque": p.torque},
        state={"phi": saddle + BESIDE, "phi_dot": rate * BESIDE},
        times=np.linspace(0.0, SECONDS, 81),
    )
    return bool(np.max(run.observables["phi"]) > saddle + 2 * math.pi)


def braking(session: Session) -> Numbers:
    """Return limits [N m], bounds, what weak damping gives, and what is just below and above.

    For dampers of 2, 3 and 4 N s/m; the motions have the last of them.
    """
    own, last = limits(session), damped(DAMPINGS[-1])
    weak = [by_weak_damping(damped(c)) for c in DAMPINGS]
    below_and_above = [
        comes_round(REFERENCE, last.replace(torque=own[-1].torque * (1 + side * NEAR)))
        for side in (-1, 1)
    ]
    return {
        "torques": [limit.torque for limit in own],
        "bound": max(limit.error for limit in own),
        "weak": [torque / limit.torque - 1 for torque, limit in zip(weak, own, strict=True)],
        "slack": max(abs(t / limit.torque - 1) for t, limit in zip(weak, own, strict=True)),
        "slower": below_and_above[0],
        "faster": below_and_above[1],
    }


def braking_by(session: Session, who: str) -> Numbers | str:
    """Return the limits of the reference [N m], or how far an engine's are from them, relative.

    The engine's for the least and the largest damper alone, since each takes 16 runs.
    """
    if who == REFERENCE:
        return {"own": [limit.torque for limit in limits(session)]}
    off = []
    for damping, limit in zip(DAMPINGS[::2], limits(session)[::2], strict=True):
        low, high = (limit.torque * (1 + side * AROUND / 2) for side in (-1, 1))
        if comes_round(who, damped(damping, torque=low)) or not comes_round(
            who, damped(damping, torque=high)
        ):
            return f"more than {AROUND / 2:.0%} off"
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            turns = comes_round(who, damped(damping, torque=middle))
            low, high = (low, middle) if turns else (middle, high)
        off.append((low + high) / 2 / limit.torque - 1)
    return {"off": off}


BRAKING: LedgerRow = statement(
    "braking_limit", "3, figure 6",
    "The motion is braked where the damper takes more than the motor gives.", REPRODUCED,
    "the two balance last in the slowest turn that comes over the spring, the homoclinic orbit of "
    "the lower saddle. It is at {torques:.7g} N m for c = 2, 3, 4 (bound {bound:.0e}): 1 % below "
    "it a crank that leaves the saddle does not come round, 1 % above it does. What weak damping "
    "takes of the spring's own orbit is off by {weak:.1e}. The averages (20), (21) have a speed at "
    "every torque, and no such limit",
    braking, braking_by, "{own:.5g} N m", "c = 2 and 4: off by {off:+.1e} of it",
    holds(equal("slower", False), equal("faster", True), below("slack", 0.01)), slow=True,
)  # fmt: skip

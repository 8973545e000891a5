"""Rules that hold for a run of a scene and for any MJCF file, as functions of plain numbers.

Each rule has one condition, one threshold and one sentence. `cautions` applies them to an engine's
run of a scene, whose equations, horizon and reference are known; `mbcheck inspect` to a file,
without horizon and reference: where that matters, a rule has a threshold for either.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ....reference.scene import Array
from ...engines.run import EPS
from ...engines.setup import power_of_two

FEW_STEPS = 10
"""Steps in a period below which a mode is no more than stable, whatever the method: they show its
amplitude to 5 % only. Used where no horizon is known over which the phase error could add up."""

OPENING = 1e-3
"""How far a loop may open, in the size of its mechanism, or in rad: beyond, it moves as another."""

NEAR_FLOOR = 100.0
"""Multiple of the least inertia of an engine below which an inertia only replaces 0."""

CLOCK = 1e-9
"""Phase [rad] by which an engine's clock may be off: what a truth with nine digits shows."""

DIGITS = 1e-6
"""Share of an acceleration that rounding may change where it is compared with a reference."""

FEW_DIGITS = 1e12 * EPS
"""Share of an acceleration that rounding may change in any model: four digits are left."""

MEANINGS: Mapping[str, str] = {
    "step_limit": "the step is beyond the method's stability limit",
    "coarse_step": "too few steps in a period: stable, but the phase is lost",
    "closure_softness": "a loop opens under its load",
    "inertia_floor": "an inertia near the least that the engine accepts",
    "clock_rounding": "the clock adds up rounded steps",
    "ill_conditioned": "rounding leaves few digits of accelerations",
}
"""Meaning of each of these rules, in few words."""


@dataclass(frozen=True)
class Statement:
    """The statement of a rule about a model or a run.

    Attributes
    ----------
    message : str
        The problem, with its numbers.
    fix : str
        The remedy; empty if there is none.
    """

    message: str
    fix: str = ""

    @property
    def sentence(self) -> str:
        """Both in one sentence."""
        return "; ".join(filter(None, (self.message, self.fix)))


def step_limit(step: float, limit: float, omega: float, mode: str, method: str) -> Statement | None:
    """Compare a step [s] with the longest that keeps free vibrations bounded.

    Parameters
    ----------
    step, limit : float
        The step, and the longest stable one [s].
    omega : float
        Circular frequency, or rate, of the mode that sets the limit [1/s].
    mode, method : str
        The mode and the method, in words.
    """
    if step <= limit:
        return None
    return Statement(
        f"a step of {step:.3g} s is unstable: the mode of {mode} has h omega = {step * omega:.3g} "
        f"({omega:.4g} rad/s), and {method} is stable up to {limit * omega:.3g}",
        f"take at most {limit:.3g} s",
    )


def coarse_step(
    step: float, period: float, phase: float | None = None, most: float = 0.0, method: str = ""
) -> Statement | None:
    """Judge if a step [s] resolves a motion of this period [s].

    The criterion is the phase error in a run if it is known, else `FEW_STEPS`.

    Parameters
    ----------
    step, period : float
    phase, most : float, optional
        The phase error of the method, and the largest acceptable one [rad].
    method : str
        The method and the run, in words.
    """
    message = f"{period / step:.3g} steps per period of {period:.4g} s"
    if phase is None:
        fix = f"take a step of {period / 20:.2g} s if that motion matters"
        return Statement(message, fix) if period < FEW_STEPS * step else None
    if phase <= most:
        return None
    return Statement(
        f"{message}: {method} is off by about {phase / (2 * np.pi):.2g} periods; stable, but wrong",
        "shorten the step",
    )


def closure_softness(
    closure: str,
    opening: float,
    size: float,
    load: str = "its load",
    unit: str = "",
    turn: float | None = None,
) -> Statement | None:
    """Compare how far a soft closure opens under its load with the size of its mechanism.

    Parameters
    ----------
    closure, load : str
        The closure and its load, in words.
    opening, size : float
        Opening, and the size with which it is compared [m, or 1 rad].
    unit : str
        Of these, where one is known.
    turn : float, optional
        Angle by which it opens as well [rad].
    """
    if not (opening > OPENING * size or (turn or 0.0) > OPENING):
        return None
    words = f"{opening:.3g} {unit}".rstrip() + ("" if turn is None else f" and {turn:.2g} rad")
    return Statement(
        f"{closure} opens by about {words} under {load}, {opening / size:.2g} of the size of the "
        "mechanism",
        "close it harder",
    )


def inertia_floor(
    what: str, inertia: float, unit: str, least: float, engine: str, near: float = 1.0
) -> Statement | None:
    """Compare an inertia with the largest that an engine refuses, times a factor ``near``."""
    if inertia > near * least:
        return None
    place = "below" if inertia <= least else "next to"
    return Statement(f"{what} of {inertia:.3g} {unit} is {place} the least of {engine}, {least:g}")


def clock_rounding(
    step: float, clock: str, steps: float | None = None, end: float = 0.0, speed: float = 0.0
) -> Statement | None:
    """Count the rounding of a clock that adds up steps which are no power of two.

    Parameters
    ----------
    step : float
        [s]
    clock : str
        The clock, in words.
    steps, end, speed : float, optional
        Of a run: how many steps it has, the largest time that its clock shows [s], and the fastest
        circular frequency of its motion [rad/s].
    """
    late, words = EPS * end * (steps or 0.0), ""
    if math.frexp(step)[0] == 0.5 or (steps is not None and late * speed <= CLOCK):
        return None
    if steps is not None:
        phase = f"{late * speed:.2g} rad of the motion"
        words = f": after {steps:.3g} steps it may be off by {late:.2g} s, {phase}"
    return Statement(
        f"{clock} adds up steps of {step:g} s, which is no power of two{words}",
        f"take a step of {power_of_two(step):.17g} s",
    )


def ill_conditioned(mass: Array, place: str, most: float = DIGITS) -> Statement | None:
    """Compare what rounding changes of accelerations with the share ``most``.

    Parameters
    ----------
    mass : array (n, n)
        Mass matrix. Its condition counts in units of its own diagonal, so that light and heavy
        parts side by side cost nothing.
    place : str
        The state, in words.
    most : float
    """
    root = 1 / np.sqrt(np.diag(mass))
    condition = float(np.linalg.cond(mass * np.outer(root, root)))
    if not EPS * condition > most:
        return None
    return Statement(
        f"the mass matrix {place} has the condition {condition:.2g}: rounding leaves accelerations "
        f"wrong by {EPS * condition:.1g}"
    )

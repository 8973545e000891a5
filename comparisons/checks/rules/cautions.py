"""What rules say of a run that is to be made.

They need no run: what they say follows from the case, from the equations that the model has,
linearised, and from what the method makes of free vibrations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ...engines.setup import Setup
from ..verdict import RULE
from . import method, model
from .conditions import MEANINGS, Statement
from .run import RunConditions


@dataclass(frozen=True)
class Caution:
    """What a rule says of a run that is to be made.

    Attributes
    ----------
    rule : str
        name of the rule
    message : str
        what is wrong, with its numbers, and what to do
    """

    rule: str
    message: str


@dataclass(frozen=True)
class Rule:
    """What a rule means, and what it says of a run, if anything."""

    meaning: str
    find: Callable[[RunConditions], Statement | None]


RULES: Mapping[str, Rule] = {
    "step_limit": Rule(MEANINGS["step_limit"], method.step_limit),
    "coarse_step": Rule(MEANINGS["coarse_step"], method.coarse_step),
    "numerical_damping": Rule(
        "the method damps, or feeds, what the motion keeps", method.numerical_damping
    ),
    "inertia_floor": Rule(MEANINGS["inertia_floor"], model.inertia_floor),
    "newton_tolerance": Rule(
        "Newton's method stops too early for so small a motion", method.newton_tolerance
    ),
    "closure_softness": Rule(MEANINGS["closure_softness"], model.closure_softness),
    "discretisation": Rule("too few segments for the first frequency", model.discretisation),
    "dead_centre": Rule("the mechanism passes near a singular position", method.dead_centre),
    "inconsistent_start": Rule("it starts off its constraints", method.inconsistent_start),
    "unstable_start": Rule("it starts on an unstable state of rest", method.unstable_start),
    "amplification": Rule("the motion is chaotic, or as good as", method.amplification),
    "clock_rounding": Rule(MEANINGS["clock_rounding"], method.clock_rounding),
    "engine_range": Rule("values that the engine takes for a failure", method.engine_range),
    "ill_conditioned": Rule(MEANINGS["ill_conditioned"], model.ill_conditioned),
}


def cautions(setup: Setup, horizon: float, rules: Mapping[str, Rule] = RULES) -> list[Caution]:
    """Return what rules say of a run over a horizon [s] that the engine does not refuse."""
    with np.errstate(all="ignore"):
        run = RunConditions(
            setup.engine, setup.case, setup.model, setup.method, setup.step, horizon=horizon
        )
        said = {name: rule.find(run) for name, rule in rules.items()}
    return [Caution(name, one.sentence) for name, one in said.items() if one is not None]


def noticing_rules(cautions: list[Caution]) -> tuple[str, ...]:
    """Return the rules that warn of a run, each once, as who notices."""
    return tuple(dict.fromkeys(f"{RULE}{one.rule}" for one in cautions))


def explained(reason: str, cautions: list[Caution]) -> str:
    """Append to a reason what rules say."""
    return "; ".join([reason, *(f"rule {one.rule}: {one.message}" for one in cautions)])

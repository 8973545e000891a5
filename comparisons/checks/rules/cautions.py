"""Warnings of rules before a run.

They follow from the case, from the linearised equations of the model, and from the effect of the
method on free vibrations.
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
    """The warning of a rule before a run.

    Attributes
    ----------
    rule : str
        name of the rule
    message : str
        the problem, with its numbers, and a remedy
    """

    rule: str
    message: str


@dataclass(frozen=True)
class Rule:
    """The meaning of a rule, and the function that finds a violation in a run."""

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
    """Return the warnings of rules about a run over a horizon [s]."""
    with np.errstate(all="ignore"):
        run = RunConditions(
            setup.engine, setup.case, setup.model, setup.method, setup.step, horizon=horizon
        )
        said = {name: rule.find(run) for name, rule in rules.items()}
    return [Caution(name, one.sentence) for name, one in said.items() if one is not None]


def noticing_rules(cautions: list[Caution]) -> tuple[str, ...]:
    """Return the rules that warn of a run, each once, as witnesses."""
    return tuple(dict.fromkeys(f"{RULE}{one.rule}" for one in cautions))


def explained(reason: str, cautions: list[Caution]) -> str:
    """Append the warnings of rules to a reason."""
    return "; ".join([reason, *(f"rule {one.rule}: {one.message}" for one in cautions)])

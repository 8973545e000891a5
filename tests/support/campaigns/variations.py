"""Honest variations of checks: other parameters, states and steps of right engines.

`python -m mbcheck.tests.support.campaigns.variations SCENE FIRST COUNT` prints false alarms.
"""

from __future__ import annotations

import dataclasses
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np

from mbcheck.comparisons.check.custom import place_of_rest
from mbcheck.comparisons.checks.suite import Check, checks_of, kinds_of, run_check
from mbcheck.comparisons.checks.verdict import Result
from mbcheck.comparisons.engines.adapter import Adapter
from mbcheck.comparisons.engines.setup import Setup, power_of_two
from mbcheck.comparisons.faults.catalogue import ENGINES
from mbcheck.reference import get_scene
from mbcheck.reference.errors import MbcheckError
from mbcheck.reference.scene import Case
from mbcheck.tests.support.draws import with_moments_of_a_body

SEEDS = (
    "hula_hoop",
    "rotating_beam",
    "rotor_pendulum",
    "speed_regulator",
    "rigid_body",
    "ball_hoop",
    "floating_platform",
    "floating_beam",
)
"""Draws of a scene follow from its place here."""

SPREAD = 0.3
ORBITS = 0.25
"""Part of the orbits drawn that are kept: they take ten times as long as all else."""

FACTORS = (0.25, 0.5, 1.0, 2.0)
"""On the default step, as long as that is not what stability permits at most."""


@dataclass(frozen=True)
class Stepped(Check):
    """A check with another step than its method's default."""

    factor: float = 1.0

    def setup(self, engine: Adapter | None = None) -> Setup:
        """Return the setup with that step."""
        setup = super().setup(engine)
        if setup.method is not None:
            longest = power_of_two(max(1.0, setup.stable_step_bound / setup.default_step))
            vars(setup)["default_step"] *= min(longest, self.factor)
        return setup


def variation(scene: str, number: int) -> Stepped:
    """Return the check with this number of a scene, the same one at any time."""
    random = np.random.default_rng([SEEDS.index(scene), number])
    while True:
        try:
            cases = get_scene(scene).cases
            case = varied(cases[random.integers(len(cases))], random)
            checks = list(possible(case, random))
        except MbcheckError:  # parameters that do not fit each other
            continue
        if checks and (checks[0].kind != "stability" or random.random() < ORBITS):
            check = checks[random.integers(len(checks))]
            fields = {item.name: getattr(check, item.name) for item in dataclasses.fields(check)}
            return Stepped(**fields, factor=float(random.choice(FACTORS)))


def varied(case: Case, random: np.random.Generator) -> Case:
    """Return a case whose parameters and initial values are each off by up to 30 %."""
    values: dict[str, Any] = {}
    for item in dataclasses.fields(case.parameters):
        value = getattr(case.parameters, item.name)
        if "options" not in item.metadata and item.name != "segments":
            values[item.name] = value * random.uniform(1 - SPREAD, 1 + SPREAD)
    state = {
        name: value * random.uniform(1 - SPREAD, 1 + SPREAD) for name, value in case.state.items()
    }
    values = with_moments_of_a_body(get_scene(case.scene), values)
    return replace(case, parameters=case.parameters.replace(**values), state=state)


def possible(case: Case, random: np.random.Generator) -> Iterator[Check]:
    """Yield the checks of one kind of a case by one engine."""
    engine, kind = str(random.choice(list(ENGINES))), str(random.choice(kinds_of(case)))
    if kind == "frequency" and case.watch != "elements":  # where rest is depends on parameters
        case = replace(case, about=case.about or place_of_rest(case))
    for check in checks_of(kind, case, engine):
        if check.unsupported_reason is None:
            yield check


def alarms(check: Stepped) -> list[Result]:
    """Return what deviates, or is an error, where nothing is wrong."""
    return [item for item in run_check(check, "strict") if item.verdict in ("deviation", "error")]


if __name__ == "__main__":
    scene, first, count = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    verdicts: Counter[str] = Counter()
    for number in range(first, first + count):
        begin, check = perf_counter(), variation(scene, number)
        for result in (results := run_check(check, "strict")):
            if result.verdict in ("deviation", "error"):
                print(f"  {result.quantity}: {result.verdict}: {result.reason}", flush=True)
        verdicts.update(result.verdict for result in results)
        seconds = f"{perf_counter() - begin:.1f} s"
        print(f"{number} {check.prefix} x {check.factor} {seconds}", flush=True)
    print(scene, count, dict(verdicts))

"""Right engines are accused of nothing, whatever the parameters, states and steps."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.checks.kinds.one_step import limit_of_steps
from mbcheck.comparisons.checks.verdict import Inconclusive
from mbcheck.reference import SCENES
from mbcheck.tests.support.campaigns.variations import alarms, variation

BLOCK, FEW, MANY = 5, 20, 200
"""Variations in a short and in a long test, and of each scene in the campaign."""

SHORT: Any = ()
SLOW, CAMPAIGN = pytest.mark.slow, pytest.mark.campaign

MARKS = {
    "rotating_beam": (SHORT, CAMPAIGN),  # minutes
    "floating_platform": (SLOW, CAMPAIGN),
    "floating_beam": (SLOW, CAMPAIGN),
}
"""How the first and the second block of scenes are run whose checks take long; of others the first
is a default test, and the second a slow one.
"""


def blocks() -> Iterator[Any]:
    """Yield scenes with the first number and the count of some variations."""
    for scene in SCENES:
        marks = (*MARKS.get(scene, (SHORT, SLOW)), CAMPAIGN, CAMPAIGN)
        for first, mark in zip(range(0, FEW, BLOCK), marks, strict=True):
            yield pytest.param(scene, first, BLOCK, marks=mark)
        for first in range(FEW, MANY, FEW):
            yield pytest.param(scene, first, FEW, marks=CAMPAIGN)


@pytest.mark.parametrize(("scene", "first", "count"), list(blocks()))
def test_right_engines_are_accused_of_nothing(scene: str, first: int, count: int) -> None:
    checks = [variation(scene, number) for number in range(first, first + count)]
    found = {check.prefix: alarms(check) for check in checks}
    assert not {prefix: items for prefix, items in found.items() if items}


@pytest.mark.slow
def test_vibrations_that_steps_do_not_follow_are_no_defect_of_their_limit() -> None:
    """Also where they make errors as regular by chance as those of order 2."""
    setup = variation("rotating_beam", 9).setup()
    case = replace(setup.case, parameters=setup.case.parameters.replace(segments=6.0))
    unknown = np.zeros(len(setup.bound.observables))
    found = limit_of_steps(setup.with_case(case), [case], setup.default_step / 2, unknown)
    assert isinstance(found, Inconclusive)
    assert "the initial state excites modes above" in found.reason

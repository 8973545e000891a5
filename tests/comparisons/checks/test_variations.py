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
"""Variations of each scene by default, and in the campaign."""

BRIEF = {
    "rotating_beam": pytest.mark.campaign,  # minutes
    "rigid_body": pytest.mark.slow,
    "ball_hoop": pytest.mark.slow,
    "floating_platform": pytest.mark.slow,
    "floating_beam": pytest.mark.slow,
}
"""Scenes that have their first block alone by default, and how the others of the few are run."""

LONGEST = ("floating_platform", "floating_beam")
"""Those of them whose first block is a slow test, too."""


def blocks() -> Iterator[Any]:
    """Yield scenes with the first number and the count of some variations."""
    for scene in SCENES:
        for first in range(0, FEW, BLOCK):
            marks = [BRIEF[scene]] if scene in (BRIEF if first else LONGEST) else []
            yield pytest.param(scene, first, BLOCK, marks=marks)
        for first in range(FEW, MANY, FEW):
            yield pytest.param(scene, first, FEW, marks=pytest.mark.campaign)


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
    unknown = np.zeros(len(setup.observables))
    found = limit_of_steps(setup.with_case(case), [case], setup.default_step / 2, unknown)
    assert isinstance(found, Inconclusive)
    assert "the start shakes vibrations above" in found.reason

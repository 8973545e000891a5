"""Right engines are accused of nothing, whatever the parameters, states and steps."""

from __future__ import annotations

import pytest

from mbcheck.reference import SCENES
from mbcheck.tests.support.campaigns.variations import alarms, variation

FEW, MANY = 20, 200
"""Variations of each scene by default, and in the campaign."""

BLOCKS = [
    *(pytest.param(first, 5) for first in range(0, FEW, 5)),
    *(pytest.param(first, 20, marks=pytest.mark.campaign) for first in range(FEW, MANY, 20)),
]


@pytest.mark.parametrize(("first", "count"), BLOCKS)
@pytest.mark.parametrize("scene", SCENES)
def test_right_engines_are_accused_of_nothing(scene: str, first: int, count: int) -> None:
    checks = [variation(scene, number) for number in range(first, first + count)]
    found = {check.prefix: alarms(check) for check in checks}
    assert not {prefix: items for prefix, items in found.items() if items}

"""Seeded faults of 0.1 % are caught, and on the level where they are."""

from __future__ import annotations

import pytest

from mbcheck.tests.support.campaigns.seeded import Seeded, judged, level_of, seeded

MANY = 100


def level(fault: Seeded) -> str:
    return level_of(judged(fault))


@pytest.mark.parametrize("number", [*(pytest.param(i, marks=pytest.mark.slow) for i in (5, 6)), 7])
def test_a_seeded_fault_is_named(number: int) -> None:
    fault = seeded(number)
    assert level(fault) in fault.levels, fault.what


@pytest.mark.campaign
def test_seeded_faults_are_caught_and_named() -> None:
    faults = [seeded(number) for number in range(MANY)]
    levels = [level(fault) for fault in faults]
    missed = [one.what for one, found in zip(faults, levels, strict=True) if not found]
    elsewhere = [
        one.what for one, found in zip(faults, levels, strict=True) if found not in one.levels
    ]
    print(f"{MANY} faults: {missed} missed, {elsewhere} not on their level")
    assert len(missed) <= 0.02 * MANY
    assert len(elsewhere) <= 0.05 * MANY

"""Bugs of importers: each is named by element and attribute, and an edit closes the gap."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from mbcheck.comparisons.compare.comparison import compared
from mbcheck.comparisons.compare.reading import Operand, Reading
from mbcheck.tests.support.mjcf.import_bugs import GRIPPER, IMPORT_BUGS

QUICK = ("damping in degrees", "kp read as a motor's gear", "actuator on the wrong joint")


@pytest.fixture(scope="module")
def gripper(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Reading]:
    path = tmp_path_factory.mktemp("gripper") / "gripper.xml"
    path.write_text(GRIPPER)
    with Reading(Operand(str(path), "mujoco"), sys.executable) as reading:
        yield reading


@pytest.mark.parametrize(
    "bug",
    [one if one in QUICK else pytest.param(one, marks=pytest.mark.slow) for one in IMPORT_BUGS],
)
def test_the_bug_is_named_and_an_edit_closes_the_gap(
    gripper: Reading, bug: str, tmp_path: Path
) -> None:
    right, wrong, element, attribute = IMPORT_BUGS[bug]
    assert right in GRIPPER
    path = tmp_path / "wrong.xml"
    path.write_text(GRIPPER.replace(right, wrong, 1))
    with Reading(Operand(str(path), "mujoco"), sys.executable) as reading:
        result = compared(gripper, reading, ("a", "b"))
    assert result.exit_code == 1
    assert (element, attribute) in {(one.element, one.attribute) for one in result.differences}
    assert result.gaps
    assert result.closed

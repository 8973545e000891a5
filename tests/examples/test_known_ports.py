"""Known deviations of MuJoCo's algorithms on other hardware."""

from __future__ import annotations

import fnmatch
from pathlib import Path

import pytest

from mbcheck.comparisons.checks import known
from mbcheck.comparisons.engines.adapter import adapt
from mbcheck.reference import get_scene
from mbcheck.tests.support.example import all_checks

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
CASES_KNOWN = {"mjx": {"rotation", "long_crank", "weighed"}, "mujoco_warp": {"rotation"}}


@pytest.mark.parametrize("name", CASES_KNOWN)
def test_known_deviations_are_of_ids_that_there_are(name: str) -> None:
    """Of its methods and models, which are those of MuJoCo plugged in; it need not be there."""
    plugin = pytest.importorskip("mbcheck.examples.mujoco_engine").MujocoPlugin
    stand_in = adapt(name, type("Ids", (plugin,), {"name": name})())
    scene = get_scene("speed_regulator")
    ids = {
        id: case.name
        for case in (*scene.cases, *scene.placed)
        if "algebra" in case.kinds
        for check in all_checks("algebra", case, stand_in)
        for id in check.ids
    }
    entries = known.read(str(EXAMPLES / f"{name}_known.toml")).entries
    about = [{ids[id] for id in fnmatch.filter(ids, entry.id)} for entry in entries]
    assert all(about)
    assert set.union(*about) == CASES_KNOWN[name]
    assert all(entry.max_error for entry in entries)

"""Releases of engines in environments of their own: what a diff between them shows."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

import pytest

from mbcheck.comparisons.checks.diagnosis import ANOTHER_MODEL
from mbcheck.comparisons.checks.verdict import result_from
from mbcheck.comparisons.reports.run.located import located
from mbcheck.reference.speed_regulator.soft import NO_DRIFT
from mbcheck.tests.support.packaging import copy_sources, output

pytestmark = pytest.mark.foreign

LOOP = {"connect", "connect_hard"}
"""Models of the speed regulator whose loop MuJoCo closes."""

ALGEBRA = "verification/speed_regulator/rotation/algebra/mujoco/connect/accelerations"


@pytest.fixture(scope="module")
def wheel(clone: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the package of this clone."""
    folder = tmp_path_factory.mktemp("wheel")
    sources = copy_sources(clone, folder / "sources")
    pip = (sys.executable, "-m", "pip", "--disable-pip-version-check")
    build = ("wheel", "--no-deps", "--wheel-dir", folder)
    output(*pip, *build, ".", cwd=sources)
    (found,) = folder.glob("*.whl")
    return found


def recipe(clone: Path, wheel: Path, engine: str, selection: str) -> str:
    """Return the commands of the document for an engine, with fewer checks, for this Python."""
    text = (clone / "docs/versions.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```sh\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    (block,) = (found for found in blocks if f"--engine {engine} " in found)
    for old, new in (
        ("python3", sys.executable),
        ("path/to/mbcheck", str(wheel)),
        ("mbcheck check", f"mbcheck check {selection}"),
    ):
        assert old in block
        block = block.replace(old, new)
    return block


def difference(old: str, new: str, cwd: Path, code: int) -> dict[str, Any]:
    """Return the document of a diff of two runs."""
    mbcheck = cwd / new.removesuffix(".json") / "bin/mbcheck"
    output(mbcheck, "diff", old, new, "--json", "diff.json", cwd=cwd, codes=(code,))
    found: dict[str, Any] = json.loads((cwd / "diff.json").read_text())
    return found


def test_releases_of_mujoco_differ_where_loops_are_closed(
    clone: Path, wheel: Path, tmp_path: Path
) -> None:
    selection = "hula_hoop speed_regulator --kind algebra --kind order"
    commands = recipe(clone, wheel, "mujoco", selection)
    output("bash", "-c", commands, cwd=tmp_path)
    old, middle, new = (f"mujoco-{release}.json" for release in ("3.6", "3.12", "4.0"))

    forward = difference(old, new, tmp_path, 0)
    assert forward["old"]["versions"]["mujoco"].startswith("3.6.")
    assert forward["new"]["versions"]["mujoco"].startswith("4.")
    assert not forward["regressions"]
    fixed = {item["id"]: item for item in forward["changes"] if item["sort"] == "fixed"}
    others = [item for item in forward["changes"] if item["sort"] != "fixed"]
    assert {(item["new"]["scene"], item["new"]["model"]) for item in fixed.values()} == {
        ("speed_regulator", model) for model in LOOP
    }
    assert {(item["sort"], item["new"]["method"]) for item in others} == {("appeared", "discrete")}
    assert fixed[ALGEBRA]["old"]["error"] > 0.1  # relative
    assert fixed[ALGEBRA]["new"]["error"] < 1e-10
    assert all(item["old"]["verdict"] == "deviation" for item in fixed.values())

    results = [result_from(item) for item in json.loads((tmp_path / old).read_text())["results"]]
    causes = {item.cause for item in results if item.verdict == "deviation"}
    assert NO_DRIFT in causes <= {NO_DRIFT, ANOTHER_MODEL, None}
    checks = {item.check_id for item in results if item.cause == NO_DRIFT}
    assert located(results) == [
        "mujoco: its accelerations or its mass matrix is wrong",
        f"  {NO_DRIFT} (speed_regulator; {len(checks)} checks)",
    ]

    back = difference(new, old, tmp_path, 1)
    worse = {item["id"] for item in back["changes"] if item["sort"] == "new_deviation"}
    assert worse == set(fixed)

    later = difference(middle, new, tmp_path, 0)
    assert {(item["sort"], item["new"]["method"]) for item in later["changes"]} == {
        ("appeared", "discrete")
    }


def test_an_older_exudyn_runs_what_it_can(clone: Path, wheel: Path, tmp_path: Path) -> None:
    commands = recipe(clone, wheel, "exudyn", "--kind algebra --kind energy")
    output("bash", "-c", commands, cwd=tmp_path)
    found = difference("exudyn-1.10.json", "exudyn-1.13.json", tmp_path, 0)
    assert {(item["sort"], item["new"]["scene"]) for item in found["changes"]} == {
        ("now_runs", "speed_regulator"),
        ("appeared", "speed_regulator"),  # of a case that runs each model's best method alone
        ("now_runs", "rotating_beam"),  # `weighed`, whose clamp is off the axis
    }
    document = json.loads((tmp_path / "exudyn-1.10.json").read_text())
    verdicts = {result["verdict"] for result in document["results"]}
    assert verdicts == {"pass", "skipped"}

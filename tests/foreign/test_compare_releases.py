"""Models as older releases of MuJoCo read them: what the table of docs/versions.md says.

``python -m mbcheck.tests.foreign.test_compare_releases`` writes docs/releases.json anew, and
``python docs/build.py`` the table from it.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import mujoco
import pytest

from mbcheck import compare
from mbcheck.models import mjcf
from mbcheck.tests.foreign.packages import unpacked
from mbcheck.tests.support.mjcf.import_bugs import GRIPPER
from mbcheck.tests.support.mjcf.losses import WHOLE

RELEASES = ("3.2.7", "3.3.7", "3.6.0")

RESULTS = Path(__file__).resolve().parents[2] / "docs" / "releases.json"

CHEETAH = "gymnasium/envs/mujoco/assets/half_cheetah.xml"

pytestmark = pytest.mark.foreign


def models(folder: Path) -> Iterator[tuple[str, Path]]:
    """Yield the models of the table by name, the last from a public package."""
    scenes = ("speed_regulator", "ball_hoop")
    texts = {name: next(iter(mjcf.models(name).values())).path.read_text() for name in scenes}
    for name, text in {"arm with free body": WHOLE, **texts, "gripper": GRIPPER}.items():
        path = folder / f"{name.replace(' ', '_')}.xml"
        path.write_text(text)
        yield name, path
    yield "half_cheetah of gymnasium", unpacked("gymnasium", folder) / CHEETAH


def compared(folder: Path) -> dict[str, Any]:
    """Return the findings of each model in each release."""
    rows = []
    for name, path in models(folder):
        for release in RELEASES:
            found = compare(str(path), f"{path}@mujoco=={release}", install=True)
            rows.append(
                {
                    "model": name,
                    "release": release,
                    "exit_code": found.exit_code,
                    "findings": [one.sentence for one in found.findings],
                    "idle_defaults": list(found.idle_defaults),
                }
            )
    return {"mujoco": mujoco.__version__, "rows": rows}


def test_the_table_of_the_page_is_what_is_found(tmp_path: Path) -> None:
    assert compared(tmp_path) == json.loads(RESULTS.read_text(encoding="utf-8"))


if __name__ == "__main__":
    with TemporaryDirectory() as place:
        RESULTS.write_text(json.dumps(compared(Path(place)), indent=1) + "\n", encoding="utf-8")

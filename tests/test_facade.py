"""The names that `import mbcheck` offers."""

import subprocess
import sys
from pathlib import Path

import pytest

import mbcheck
from mbcheck.comparisons.queries.simulate import simulate


@pytest.mark.parametrize(
    ("module", "heavy"),
    [
        ("mbcheck", {"numpy", "mujoco", "exudyn"}),
        ("mbcheck.comparisons.cli.group", {"scipy", "mujoco", "exudyn"}),
    ],
)
def test_import_is_cheap(tmp_path: Path, module: str, heavy: set[str]) -> None:
    loaded = f"import {module}, sys; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", loaded], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


def test_public_names() -> None:
    assert set(mbcheck.__all__) <= set(dir(mbcheck))
    assert mbcheck.simulate is simulate
    assert isinstance(mbcheck.__version__, str)
    with pytest.raises(AttributeError, match="simulat"):
        mbcheck.simulat  # noqa: B018

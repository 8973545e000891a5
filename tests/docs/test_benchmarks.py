"""The benchmarks run, with few points."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("maps", marks=pytest.mark.slow),
        pytest.param("speed", marks=pytest.mark.campaign),
        pytest.param("benchmark", marks=pytest.mark.campaign),
    ],
)
def test_a_benchmark_runs(name: str, clone: Path) -> None:
    script = str(clone / "benchmarks" / f"{name}.py")
    done = subprocess.run(
        [sys.executable, script, "--quick"], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "ratio" in done.stdout

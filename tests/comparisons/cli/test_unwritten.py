"""Documents that cannot be written."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from mbcheck.tests.support.command import MAIN, invoke


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is full")
def test_what_cannot_be_written_keeps_nothing_else_from_being_written(tmp_path: Path) -> None:
    """Other documents and the console; exit code 1, with the reason."""
    others = {name: tmp_path / name for name in ("junit", "markdown", "write-known")}
    options = " ".join(f"--{name} {path}" for name, path in others.items())
    done = invoke(f"check hula_hoop --engine mujoco --kind parts --json /dev/full {options}")
    assert done.exit_code == 1
    assert done.stderr == "Error: --json: cannot write '/dev/full': No space left on device\n"
    assert "PASS: " in done.stdout
    assert all(path.stat().st_size for path in others.values())
    line = f"check hula_hoop --engine mujoco --kind parts --json - --junit {tmp_path / 'two'}"
    with open("/dev/full", "w") as full:
        told = subprocess.run(
            [*MAIN, *line.split()], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert told.returncode == 1
    assert "Error: --json: cannot write '-': No space left on device" in told.stderr
    assert (tmp_path / "two").stat().st_size

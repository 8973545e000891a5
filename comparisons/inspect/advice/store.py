"""What a file keeps of runs, so that a later call goes on where an earlier one ended."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np

from ....reference.errors import UsageError
from ...documents.reading import read_document
from ...reports.files import write_or_collect
from .converged import Converged
from .runs import SampledRun, Setting, Start

OFTEN = 2.0
"""Seconds between two times at which the file is written."""

ERRORS = frozenset({"seconds", "failed", "error", "bound", "energy", "violation"})
"""What there is of a setting from a start."""

PURPOSE = "runs of mbcheck tradeoff"
"""First word of the file, by which it is told from others."""


class RunStore:
    """Results by what they are of, in memory and, if there is a path, in a file.

    Attributes
    ----------
    path : Path or None
    about : dict
        What all results hang on: another model or another question has others.
    entries : dict
        Results as JSON has them.
    """

    def __init__(self, path: str | None, model: bytes, **about: Any) -> None:
        self.path = Path(path) if path else None
        digest = hashlib.sha256(model).hexdigest()
        self.about: dict[str, Any] = json.loads(json.dumps({"model": digest, **about}))
        self.entries: dict[str, Any] = self.read()
        self.written = monotonic()

    def read(self) -> dict[str, Any]:
        """Return what the file has.

        Raises
        ------
        UsageError
            If it is no such file, or one of another model or another question.
        """
        if self.path is None or not self.path.exists():
            return {}
        _, content = read_document(self.path, "JSON", json.loads, "--resume: ")
        try:
            purpose, about, entries = (content[key] for key in ("what", "about", "entries"))
        except (KeyError, TypeError):
            raise UsageError(f"--resume {self.path}: that holds no {PURPOSE}") from None
        whole = isinstance(about, dict) and isinstance(entries, dict)
        if purpose != PURPOSE or not whole or any(map(is_broken, entries.values())):
            raise UsageError(f"--resume {self.path}: that holds no {PURPOSE}")
        for key, value in self.about.items():
            if about.get(key) != value:
                was = "" if key == "model" else f": {about.get(key)}, not {value}"
                raise UsageError(f"--resume {self.path} is of another {key}{was}")
        return entries

    def put(self, key: str, value: Any) -> None:
        """Keep a result; the file is written now and then."""
        self.entries[key] = value
        if monotonic() - self.written > OFTEN:
            self.write()

    def write(self) -> None:
        """Write the file, if there is one."""
        if self.path is not None:
            content = {"what": PURPOSE, "about": self.about, "entries": self.entries}
            write_or_collect(self.path, (json.dumps(content) + "\n").encode())
        self.written = monotonic()


def is_broken(entry: Any) -> bool:
    """Return whether an entry is no converged run, no reason for none, and no setting's errors."""
    if not isinstance(entry, dict):
        return not isinstance(entry, str)
    run = entry.get("run")
    known = isinstance(run, dict) and run.keys() == {item.name for item in fields(SampledRun)}
    return not (entry.keys() == {item.name for item in fields(Converged)} and known) and (
        entry.keys() != ERRORS
    )


def packed(truth: Converged | str) -> Any:
    """Return a converged run, or why there is none, as JSON has it."""
    if isinstance(truth, str):
        return truth
    values = {**vars(truth), "start": None, "run": vars(truth.run)}
    return json.loads(json.dumps(values, default=shaped))


def shaped(array: Any) -> dict[str, Any]:
    """Return an array as JSON has it."""
    return {"shape": array.shape, "values": np.ravel(array).tolist()}


def unpacked(value: Any, start: Start) -> Converged | str:
    """Return what was packed."""
    if isinstance(value, str):
        return value
    run = SampledRun(**with_arrays(value["run"]))
    rest = with_arrays(value) | {"setting": Setting(*value["setting"]), "start": start}
    return Converged(**rest | {"run": run})


def with_arrays(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values with what was an array as one again."""
    return {
        name: np.reshape(x["values"], x["shape"]) if isinstance(x, dict) and "shape" in x else x
        for name, x in values.items()
    }

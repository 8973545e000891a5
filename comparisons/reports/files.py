"""Where documents go: a file that is written whole or not at all, or standard output."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from secrets import token_hex

from ...reference.errors import MbcheckError, UsageError

STDOUT = "-"


@dataclass(frozen=True)
class Destination:
    """A file, or standard output for ``-``.

    Attributes
    ----------
    option : str
        What it was given for, for messages.
    name : str
        As the user gave it.

    Raises
    ------
    UsageError
        If nothing can be written there; this is found before any work is done.
    """

    option: str
    name: str

    def __post_init__(self) -> None:
        if self.standard_output:
            return
        try:
            self._probe()
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise UsageError(f"{self.option}: cannot write {self.name!r}: {reason}") from None

    @property
    def standard_output(self) -> bool:
        """True for ``-``."""
        return self.name == STDOUT

    @property
    def path(self) -> Path:
        """The file, links followed."""
        return Path(os.path.realpath(self.name))

    def _probe(self) -> None:
        if not self.name:
            raise ValueError("the name is empty")
        if self.path.is_dir():
            raise ValueError("it is a folder")
        if self.path.exists():
            if not os.access(self.path, os.W_OK):
                raise ValueError("it is read-only")
            if not self.path.is_file():  # a device or a pipe has no folder to write in
                return
        with tempfile.NamedTemporaryFile(dir=self.path.parent):
            pass

    def write(self, text: str) -> None:
        """Write a text, see `write_bytes`."""
        self.write_bytes(text.encode())

    def write_bytes(self, data: bytes) -> None:
        """Write bytes: to a file beside it first, which then takes its place.

        Raises
        ------
        UsageError
            If the file cannot be written after all.
        """
        if self.standard_output:
            write_out(data)
            return
        try:
            if self.path.exists() and not self.path.is_file():
                self.path.write_bytes(data)
            else:
                replace(self.path, data)
        except OSError as error:
            raise UsageError(
                f"{self.option}: cannot write {self.name!r}: {error.strerror}"
            ) from None


def replace(path: Path, data: bytes) -> None:
    """Write a file that is there whole or not at all.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    beside = path.with_name(f".{path.name[:200]}.{token_hex(8)}.tmp")
    try:
        with beside.open("xb") as file:  # what nobody can have put there, a link for one
            file.write(data)
        if path.exists():
            shutil.copymode(path, beside)
        os.replace(beside, path)
    finally:
        beside.unlink(missing_ok=True)


def write_whole(path: Path, data: bytes) -> None:
    """Do what `replace` does.

    Raises
    ------
    MbcheckError
        If the file cannot be written.
    """
    try:
        replace(path, data)
    except OSError as error:
        raise MbcheckError(f"cannot write {path}: {error.strerror}") from None


def write_out(data: bytes) -> None:
    """Write to standard output, which takes it piece by piece if Python does not buffer it."""
    sys.stdout.flush()
    rest = memoryview(data)
    while rest:
        rest = rest[sys.stdout.buffer.write(rest) :]
    sys.stdout.buffer.flush()


def refuse_conflicts(*destinations: Destination | None) -> None:
    """Refuse destinations of which one would overwrite another.

    Raises
    ------
    UsageError
    """
    seen: dict[str | Path, Destination] = {}
    for item in destinations:
        if item is None:
            continue
        key = STDOUT if item.standard_output else item.path
        if key in seen:
            where = "standard output" if item.standard_output else repr(item.name)
            raise UsageError(f"{seen[key].option} and {item.option} cannot both go to {where}")
        seen[key] = item

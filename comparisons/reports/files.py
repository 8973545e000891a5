"""Destinations of documents: a file, written whole or not at all, or standard output."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from secrets import token_hex

from ...reference.errors import MbcheckError, UsageError

STDOUT = "-"

UNWRITTEN: ContextVar[dict[str, OSError] | None] = ContextVar("UNWRITTEN", default=None)
"""Failed writes with their errors, while `collect_unwritten` is active."""


@dataclass(frozen=True)
class Destination:
    """A file, or standard output for ``-``.

    Attributes
    ----------
    option : str
        Option of the destination, for messages.
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

    def write(self, text: str) -> bool:
        """Write a text, see `write_or_collect`."""
        return self.write_bytes(text.encode())

    def write_bytes(self, data: bytes) -> bool:
        """Write bytes, see `write_or_collect`."""
        place = None if self.standard_output else self.path
        return write_or_collect(place, data, f"{self.option}: cannot write {self.name!r}")


@contextmanager
def collect_unwritten() -> Iterator[dict[str, OSError]]:
    """Yield failed writes with their errors, which do not prevent other writes.

    A command reports them at its end.
    """
    unwritten: dict[str, OSError] = {}
    before = UNWRITTEN.set(unwritten)
    try:
        yield unwritten
    finally:
        UNWRITTEN.reset(before)


def write_or_collect(path: Path | None, data: bytes, failure: str = "") -> bool:
    """Write bytes to a file, as `replace` does, or to standard output; return True on success.

    Parameters
    ----------
    path : Path or None
        None for standard output.
    data : bytes
    failure : str
        Beginning of the message of a failed write, if a longer one.

    Raises
    ------
    UsageError
        If it cannot be written outside `collect_unwritten`.
    """
    try:
        if path is None:
            write_out(data)
        elif path.exists() and not path.is_file():
            path.write_bytes(data)
        else:
            replace(path, data)
    except OSError as error:
        unwritten = UNWRITTEN.get()
        words = f"{failure or f'cannot write {str(path)!r}'}: {error.strerror}"
        if unwritten is None:
            raise UsageError(words) from None
        unwritten[words] = error
        if path is None:
            discard_output()
        return False
    return True


def discard_output() -> None:
    """Discard the text that standard output has not flushed."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def replace(path: Path, data: bytes) -> None:
    """Replace a file whole or not at all; through a link, its target.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    path = Path(os.path.realpath(path))
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
    """Refuse destinations of which one would overwrite another."""
    seen: dict[str | Path, Destination] = {}
    for item in destinations:
        if item is None:
            continue
        key = STDOUT if item.standard_output else item.path
        if key in seen:
            where = "standard output" if item.standard_output else repr(item.name)
            raise UsageError(f"{seen[key].option} and {item.option} cannot both go to {where}")
        seen[key] = item

"""Small files that users name: read within a limit, and parsed without a traceback."""

from __future__ import annotations

import os
import stat
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from ...reference.errors import UsageError

T = TypeVar("T")

MAX_BYTES = 256 * 2**20
"""Largest size [bytes] of an input file; no file of a user is larger."""

STDIN = "-"


def read_bytes(name: str | Path, option: str = "", label: str = "") -> bytes:
    """Return the content of a regular file of at most `MAX_BYTES`, or of standard input for ``-``.

    Parameters
    ----------
    name : str or Path
    option : str
        Beginning of the message: ``"--known: "``.
    label : str
        Name of the file in the message, if another.

    Raises
    ------
    UsageError
        If it cannot be read, is no regular file (a pipe or a device may never end), or is larger.
    """
    try:
        if name == STDIN:
            data = sys.stdin.buffer.read(MAX_BYTES + 1)
        else:
            mode = os.stat(name).st_mode
            if not stat.S_ISREG(mode):
                raise ValueError(f"it is {'a folder' if stat.S_ISDIR(mode) else 'no regular file'}")
            with open(name, "rb") as file:
                data = file.read(MAX_BYTES + 1)
        if len(data) > MAX_BYTES:
            raise ValueError(f"it has more than {MAX_BYTES // 2**20} MiB")
    except (OSError, ValueError) as error:  # a null byte in a name is a ValueError
        why = getattr(error, "strerror", None) or error
        raise UsageError(f"{option}cannot read {label or repr(str(name))}: {why}") from None
    return data


def read_document(
    name: str | Path,
    kind: str,
    parser: Callable[[str], T],
    option: str = "",
    label: str = "",
) -> tuple[str, T]:
    """Return the text of such a file, in UTF-8, and the result of a parser.

    Raises
    ------
    UsageError
        If it cannot be read, is not of its kind, or is nested too deeply for the parser.
    """
    data, why = read_bytes(name, option, label), "it is nested too deeply"
    try:
        text = data.decode("utf-8-sig")
        return text, parser(text)
    except RecursionError:
        pass
    except ValueError as error:
        why = str(error)
    raise UsageError(f"{option}{label or repr(str(name))} is not {kind}: {why}")

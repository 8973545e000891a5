"""Messages between processes; those of a process that runs third-party code are plain data.

docs/engines.md describes their format: JSON that any language can write. Reading one makes
numbers, text, arrays and objects of the classes listed here, and runs nothing.
"""

from __future__ import annotations

import json
import pickle
from base64 import b64decode, b64encode
from collections.abc import Mapping
from contextlib import suppress
from inspect import signature
from multiprocessing.connection import Connection
from threading import Thread
from typing import Any

import numpy as np

from ...reference.errors import (
    BrokenEngineError,
    CannotJudgeError,
    EngineError,
    EngineUnavailableError,
    MbcheckError,
    Unsupported,
    UsageError,
)
from .protocol import Method, ModelDescription, Motion, Option
from .run import describe, engine_error, excerpt, printable_text
from .validation import in_short

CLASSES: dict[str, type] = {
    one.__name__: one
    for one in (
        Method, Motion, Option, ModelDescription, BrokenEngineError, EngineUnavailableError,
        UsageError, Unsupported, CannotJudgeError, EngineError, MbcheckError,
    )
}  # fmt: skip
"""Classes whose objects a message may hold, each before those that it derives from."""

MAX_BYTES, MAX_VALUES, MAX_TEXT = 1 << 28, 1 << 22, 2000
"""Length of a message, and number of values outside its arrays, above which it is refused before
memory is taken for it; characters that are kept of a text, of a traceback there are more."""

SECONDS = 20.0
"""Time in which a message must have come that has begun."""


def as_plain(value: Any) -> Any:
    """Return an object, an error, a mapping or an array in the form that JSON can hold.

    Raises
    ------
    TypeError
        For anything else.
    """
    if isinstance(value, Exception) and not isinstance(value, MbcheckError):
        value = engine_error(value)
    for name, kind in CLASSES.items():
        if isinstance(value, kind):
            return {"type": name} | {
                part: getattr(value, part) for part in signature(kind).parameters
            }
    if isinstance(value, Mapping):
        return dict(value)
    array = np.asarray(value)
    if array.ndim and array.dtype.kind == "O":
        return array.tolist()
    if array.dtype.kind not in "biuf" or np.ma.is_masked(value):
        raise TypeError(
            f"{in_short(value)} is no plain data: check the engine in this process, with "
            "--in-process or mbcheck.check_engine"
        )
    if not array.ndim and array.dtype.kind != "f":
        return array.item()
    data = b64encode(array.astype("<f8").tobytes()).decode()
    return {"type": "array", "shape": array.shape, "data": data}


def from_plain(value: Any) -> Any:
    """Return the value of a part of a message; text is cut, and escaped for a terminal.

    Raises
    ------
    ValueError, TypeError, KeyError, RecursionError
        If it has another form.
    """
    if isinstance(value, str):
        return printable_text(value, MAX_TEXT)
    if isinstance(value, list):
        return tuple(map(from_plain, value))
    if not isinstance(value, dict):
        return value
    name = value.pop("type", None)
    if name == "array":
        data = b64decode(value["data"], validate=True)
        return np.frombuffer(data, "<f8").reshape(value["shape"])
    parts = {
        printable_text(key, MAX_TEXT): excerpt(part) if key == "traceback" else from_plain(part)
        for key, part in value.items()
    }
    return parts if name is None else CLASSES[name](**parts)


def encoded(message: tuple[bool, Any], plain: bool) -> bytes:
    """Return a message as bytes: whether a call has ended, and its result.

    An `EngineError` is put in place of a result that cannot be sent.
    """
    try:
        data = json.dumps(message, default=as_plain).encode() if plain else pickle.dumps(message)
        if len(data) > MAX_BYTES:
            raise ValueError(f"{len(data)} bytes are more than {MAX_BYTES}")
        return data
    except BaseException as error:  # of whatever the result is made of
        reason = f"its answer cannot be sent: {describe(error)}"
        return encoded((True, EngineError("returned", reason)), plain)


def decoded(data: bytes, plain: bool) -> tuple[bool, Any]:
    """Return a message from bytes; an `EngineError` where they are none."""
    try:
        if not plain:
            return pickle.loads(data)
        if sum(map(data.count, (b",", b"[", b"{"))) > MAX_VALUES:
            raise ValueError(f"more than {MAX_VALUES} values outside arrays")
        ended, result = json.loads(data)
        return bool(ended), from_plain(result)
    except Exception as error:  # whatever broken bytes lead to
        reason = f"what its process sent is no answer: {describe(error)}"
        return True, EngineError("returned", reason)


def received(pipe: Connection, plain: bool) -> tuple[bool, Any]:
    """Return the message whose first bytes have come, see `decoded`.

    A thread reads it: nothing makes sure that the rest of it ever comes.

    Raises
    ------
    EOFError
        If the pipe is closed, or the message too long, or not complete in time.
    """
    messages: list[bytes] = []

    def read() -> None:
        with suppress(EOFError, OSError):
            messages.append(pipe.recv_bytes(MAX_BYTES))

    reader = Thread(target=read, daemon=True)
    reader.start()
    reader.join(SECONDS)
    if not messages:
        raise EOFError
    return decoded(messages[0], plain)


def sent(pipe: Connection, data: bytes) -> None:
    """Send bytes; a thread does it, since nothing makes sure that they are ever read."""

    def write() -> None:
        with suppress(OSError):  # it has died
            pipe.send_bytes(data)

    Thread(target=write, daemon=True).start()

"""Messages between processes; those of a process that runs foreign code are plain data.

docs/engines.md describes their format: JSON that any language can write. Reading one makes
numbers, text, arrays and objects of the classes listed here, and runs nothing.
"""

from __future__ import annotations

import json
from base64 import b64decode, b64encode
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import fields
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
from .plugin.validation import in_short
from .protocol import Method, Motion, Option, OwnModel
from .run import describe, engine_error, excerpt, in_sight

OBJECTS = {one.__name__: one for one in (Method, Motion, Option, OwnModel)}
"""Classes of the protocol whose objects a message may hold."""

ERRORS: dict[str, type[MbcheckError]] = {
    one.__name__: one
    for one in (BrokenEngineError, EngineUnavailableError, Unsupported, CannotJudgeError)
} | {"EngineError": EngineError, "UsageError": UsageError}
"""Errors that a message may hold; a subclass comes before its base."""

MAX_BYTES = 1 << 28
"""Length of a message above which it is refused before memory is taken for it."""

MAX_VALUES = 1 << 22
"""Number of values outside arrays above which a message is refused before it is parsed."""

MAX_TEXT = 2000
"""Characters that are kept of a text."""

SECONDS = 20.0
"""Time in which a message must have come that has begun."""

Message = tuple[bool, Any]
"""Whether a call has ended, and its result."""


def encode(message: Message) -> bytes:
    """Return a message of foreign code as JSON.

    Raises
    ------
    TypeError
        For what is no plain data.
    """
    return json.dumps(message, default=as_plain).encode()


def as_plain(value: Any) -> Any:
    """Return an object of the protocol, an error, a mapping or an array as JSON can hold it.

    Raises
    ------
    TypeError
        For anything else.
    """
    for name, kind in OBJECTS.items():
        if isinstance(value, kind):
            return {"type": name} | {one.name: getattr(value, one.name) for one in fields(kind)}
    if isinstance(value, Exception):
        error = value if isinstance(value, MbcheckError) else engine_error(value)
        name = next((name for name, kind in ERRORS.items() if isinstance(error, kind)), "UsageError")
        texts = {"message": in_sight(f"{error}", MAX_TEXT), "traceback": excerpt(error.traceback)}
        return {"type": name, "kind": error.kind if name == "EngineError" else "", **texts}
    if isinstance(value, Mapping):
        return dict(value)
    array = np.asarray(value)
    if array.dtype.kind not in "biuf" or np.ma.is_masked(value):
        if array.dtype.kind == "O" and array.ndim:
            return array.tolist()
        raise TypeError(f"{in_short(value)} is no plain data")
    if not array.ndim:
        return float(array) if array.dtype.kind == "f" else array.item()
    data = b64encode(array.astype("<f8").tobytes()).decode()
    return {"type": "array", "shape": array.shape, "data": data}


def decode(message: bytes) -> Message:
    """Return the message that JSON holds.

    Raises
    ------
    ValueError, TypeError, KeyError, RecursionError
        If it has another form.
    """
    if sum(map(message.count, (b",", b"[", b"{"))) > MAX_VALUES:
        raise ValueError(f"more than {MAX_VALUES} values outside arrays")
    ended, result = json.loads(message)
    return bool(ended), from_plain(result)


def from_plain(value: Any) -> Any:
    """Return what a part of a message stands for; text is cut, and escaped for a terminal.

    Raises
    ------
    ValueError, TypeError, KeyError
        If it has another form.
    """
    if isinstance(value, str):
        return in_sight(value, MAX_TEXT)
    if isinstance(value, list):
        return tuple(map(from_plain, value))
    if not isinstance(value, dict):
        return value
    name = value.pop("type", None)
    if name == "array":
        data = b64decode(value["data"], validate=True)
        return np.frombuffer(data, "<f8").reshape(value["shape"])
    parts = {in_sight(key, MAX_TEXT): from_plain(part) for key, part in value.items()}
    if name is None:
        return parts
    if name in OBJECTS:
        return OBJECTS[name](**parts)
    told = f"{parts['message']}", excerpt(value["traceback"])
    return EngineError(f"{parts['kind']}", *told) if name == "EngineError" else ERRORS[name](*told)


def encoded(encoder: Callable[[Message], bytes], message: Message) -> bytes:
    """Return a message as bytes; an `EngineError` in place of a result that cannot be sent."""
    try:
        data = encoder(message)
        if len(data) > MAX_BYTES:
            raise ValueError(f"{len(data)} bytes are more than {MAX_BYTES}")
        return data
    except BaseException as error:  # of whatever the result is made of
        reason = f"its answer cannot be sent: {describe(error, '')}"
        return encoder((True, EngineError("returned", reason)))


def received(pipe: Connection, decoder: Callable[[bytes], Message]) -> Message:
    """Return the message whose first bytes have come; an `EngineError` of one that is no answer.

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
    try:
        return decoder(messages[0])
    except Exception as error:  # whatever broken bytes lead to
        reason = f"what its process sent is no answer: {describe(error, '')}"
        return True, EngineError("returned", reason)


def sent(pipe: Connection, data: bytes) -> None:
    """Send bytes; a thread does it, since nothing makes sure that they are ever read."""

    def write() -> None:
        with suppress(OSError):  # it has died
            pipe.send_bytes(data)

    Thread(target=write, daemon=True).start()

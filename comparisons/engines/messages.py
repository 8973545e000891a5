"""Messages from a process that runs foreign code: data, and nothing that runs as it is read.

Python's pickle runs what a message asks for, and imports the modules that it names, so that an
answer could end the program with exit code 0, or bring the engine's module into it.
"""

from __future__ import annotations

import io
import pickle
from contextlib import suppress
from multiprocessing.connection import Connection
from threading import Thread
from typing import Any

from ...reference.errors import EngineError, MbcheckError, UnknownNameError
from .run import excerpt, in_sight

OURS = f"{__package__.partition('.')[0]}."
"""What the names of modules begin with whose classes a message may hold."""

PLAIN = {
    "builtins": {"bytearray", "complex", "frozenset", "range", "set", "slice"},
    "collections": {"Counter", "OrderedDict", "deque"},
    "fractions": {"Fraction"},
    "numpy": {"dtype", "ndarray"},
    "numpy._core.multiarray": {"_reconstruct", "scalar"},
    "numpy._core.numeric": {"_frombuffer"},
}
"""What else it may hold, by module."""

MOST_BYTES = 1 << 30
"""Longer messages are no answers."""

LONGEST = 2000
"""Characters of what an error says."""

SECONDS = 20.0
"""Time in which a message must have come that has begun."""


class DataUnpickler(pickle.Unpickler):
    """An unpickler of data alone."""

    def find_class(self, module: str, name: str) -> Any:
        """Return a class that a message may hold.

        Raises
        ------
        UnpicklingError
            For anything else.
        """
        if name in PLAIN.get(module, ()):
            return super().find_class(module, name)
        if module.startswith(OURS) or module == "numpy.dtypes":
            named = super().find_class(module, name)
            if isinstance(named, type) and named.__module__ == module:
                return named
        raise pickle.UnpicklingError(f"{module}.{name} is no data")


def decoded(message: bytes) -> Any:
    """Return what a message holds; an `EngineError` where it is no data."""
    try:
        return DataUnpickler(io.BytesIO(message)).load()
    except BaseException as error:  # whatever broken bytes lead to
        text = " ".join(str(error).split())[:200]
        return True, EngineError("returned", f"what its process sent is no answer: {text}")


def encoded(message: tuple[bool, Any]) -> bytes:
    """Return a message as bytes; an `EngineError` in place of a result that cannot be sent."""
    try:
        return pickle.dumps(message, pickle.HIGHEST_PROTOCOL)
    except BaseException as error:  # of whatever the result is made of
        reason = f"its answer cannot be sent: {type(error).__name__}"
        return pickle.dumps((True, EngineError("returned", reason)))


def received(pipe: Connection) -> Any:
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
            messages.append(pipe.recv_bytes(MOST_BYTES))

    reader = Thread(target=read, daemon=True)
    reader.start()
    reader.join(SECONDS)
    if not messages:
        raise EOFError
    return decoded(messages[0])


def sent(pipe: Connection, call: Any) -> None:
    """Send a call; a thread does it, since nothing makes sure that it is ever read."""
    data = pickle.dumps(call, pickle.HIGHEST_PROTOCOL)

    def write() -> None:
        with suppress(OSError):  # it has died
            pipe.send_bytes(data)

    Thread(target=write, daemon=True).start()


def as_ours(error: MbcheckError) -> MbcheckError:
    """Return an error, of a foreign class too, as one of the class of ours that it derives from.

    What it says is limited, and escaped where a terminal might obey it.
    """
    if isinstance(error, EngineError):
        message = in_sight(f"{error.message}", LONGEST)
        return EngineError(in_sight(f"{error.kind}", LONGEST), message, excerpt(error.traceback))
    kinds = [one for one in type(error).__mro__ if one.__module__.startswith(OURS)]
    kind = kinds[kinds[0] is UnknownNameError]  # which is made of more than its message
    plain: MbcheckError = MbcheckError.__new__(kind, in_sight(f"{error}", LONGEST))
    plain.traceback = excerpt(error.traceback)
    return plain

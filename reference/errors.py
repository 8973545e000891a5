"""The errors that mbcheck raises on purpose; their messages are meant for the user."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class MbcheckError(Exception):
    """Base of every error that mbcheck raises on purpose.

    Parameters
    ----------
    message : str
    traceback : str, optional
        Where foreign code raised what led to it, for its author; empty if none did.
    """

    def __init__(self, message: str = "", traceback: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.traceback = traceback


class UsageError(MbcheckError):
    """The request cannot be carried out; the message says what to do."""


class ParameterError(UsageError):
    """A parameter has an impossible value."""


class UnknownNameError(UsageError):
    """A name that nothing answers to.

    Parameters
    ----------
    kind : str
        What was looked for, e.g. ``"parameter of hula_hoop"``.
    name : str
        The name that was given.
    known : iterable of str
        The names that exist.
    """

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        names = list(known)
        close = difflib.get_close_matches(name, names, n=1, cutoff=0.5)
        hint = f"did you mean {close[0]!r}?" if close else f"known: {', '.join(names) or 'none'}"
        super().__init__(f"unknown {kind} {name!r}; {hint}")
        self._arguments = kind, name, names

    def __reduce__(self) -> tuple[type[UnknownNameError], tuple[str, str, list[str]]]:
        """Pickle by all arguments, so that the error survives a process boundary."""
        return type(self), self._arguments


class NoOrbitError(MbcheckError):
    """No periodic orbit of the wanted kind was found."""


class CannotJudgeError(MbcheckError):
    """A check has nothing to say here, through no fault of the engine; it is skipped."""


class Unsupported(CannotJudgeError):
    """An engine cannot do this; for engines that others plug in to raise, with the reason."""


class EngineError(MbcheckError):
    """An engine failed; ``kind`` names how.

    Parameters
    ----------
    kind : str
        One word for the failure, e.g. ``"non_finite"`` or ``"clock"``.
    message : str
        What was seen, where, and what to try.
    traceback : str, optional
        As of `MbcheckError`.
    """

    def __init__(self, kind: str, message: str, traceback: str = "") -> None:
        super().__init__(message, traceback)
        self.kind = kind

    def __reduce__(self) -> tuple[type[EngineError], tuple[str, str, str]]:
        """Pickle by all arguments, so that the error survives a process boundary."""
        return type(self), (self.kind, self.message, self.traceback)


class EngineUnavailableError(UsageError):
    """An engine cannot be imported on this machine."""


class BrokenEngineError(EngineUnavailableError):
    """An installed engine fails while it is loaded, or while its checks are planned."""

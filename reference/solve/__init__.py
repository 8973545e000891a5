"""Initial value problems: single, batched, stiff; equal steps by NumPy or compiled by heyoka."""

from importlib.util import find_spec

from ..errors import UnknownNameError, UsageError

HEYOKA = "heyoka"
BACKENDS = ("auto", "numpy", HEYOKA)
"""Libraries that take equal steps of many points; "auto" takes heyoka where it is installed."""


def takes_heyoka(backend: str) -> bool:
    """Return True if heyoka is installed and chosen by a backend.

    Raises
    ------
    UsageError
        If there is no such backend, or heyoka is chosen and not installed.
    """
    if backend not in BACKENDS:
        raise UnknownNameError("backend", backend, BACKENDS)
    spec = find_spec(HEYOKA)
    installed = spec is not None and spec.origin is not None  # no folder of that name
    if backend == HEYOKA and not installed:
        raise UsageError("heyoka is not installed; pip install 'mbcheck[fast]'")
    return backend != "numpy" and installed

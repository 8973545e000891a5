"""mbcheck: a validation suite for multibody engines.

`check`, `simulate`, `orbit` and `frequencies` return, typed, what the command line prints.
They are loaded when first used, and engines when first asked for.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .comparisons.api import check, frequencies, orbit, simulate

    __version__: str

__all__ = ["__version__", "check", "frequencies", "orbit", "simulate"]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from .comparisons import api

    return api.own_version() if name == "__version__" else getattr(api, name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])

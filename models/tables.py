"""Tables that a scene's folder may have."""

from __future__ import annotations

from importlib import import_module
from typing import TypeVar, cast

T = TypeVar("T")


def table_of(name: str, table: str, empty: T) -> T:
    """Return a table of a module, by its full name.

    ``empty`` where the module, its folder or the table is missing; what else a module misses as it
    is imported is raised.
    """
    try:
        module = import_module(name)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{name}.".startswith(f"{error.name}."):
            raise
        return empty
    return cast(T, vars(module).get(table, empty))

"""The option of the time that a verb may take."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import click

from .options import NUMBER
from .program import progress_bar

QUERY, MAP = 600.0, 86400.0
"""Time [s] that a query and a map may take, unless the user gives more."""


def budget_option(seconds: float) -> Callable[[Any], Any]:
    """Return the option, with its default [s]."""
    return click.option(
        "--budget",
        type=NUMBER,
        default=seconds,
        show_default=True,
        metavar="SECONDS",
        help="Refuse what is seen to take longer, with an estimate.",
    )


@contextmanager
def budgeted(seconds: float, what: str) -> Iterator[None]:
    """Do something within a budget [s], and tell how far it is, on a terminal or line by line."""
    from ...reference.cost import within

    with (
        progress_bar(True, f"parts of {what}", lines=True) as advance,
        within(seconds, lambda share, _: advance(round(100 * share), 100)),
    ):
        yield

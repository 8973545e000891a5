"""The option of the time that a verb may take."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import click

from .options import NUMBER
from .program import progress_bar

QUERY, MAP = 600.0, 86400.0
"""Default budgets of a query and of a map [s]."""


def budget_option(seconds: float) -> Callable[[Any], Any]:
    """Return the option, with its default [s]."""
    return click.option(
        "--budget",
        type=NUMBER,
        default=seconds,
        show_default=True,
        metavar="SECONDS",
        help="Refuse work with a longer estimated time.",
    )


@contextmanager
def budgeted(seconds: float, what: str) -> Iterator[None]:
    """Work within a budget [s], and show progress on a terminal or line by line."""
    from ...reference.cost import within

    with (
        progress_bar(True, f"parts of {what}", lines=True) as advance,
        within(seconds, lambda share, _: advance(round(100 * share), 100)),
    ):
        yield

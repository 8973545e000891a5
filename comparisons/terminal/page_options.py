"""The option ``--html`` of `mbcheck check`; the page itself is made when it is wanted."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from ..reports.files import Destination

if TYPE_CHECKING:
    from ..reports.run.outcome import Report


def page_of(
    context: click.Context, option: click.Parameter, name: str | None
) -> Destination | None:
    """Return the page in a folder; refuse at once what cannot be written."""
    if name is None:
        return None
    from ..reports.run.page import page_file

    return page_file(name)


HTML = click.option(
    "--html",
    "html_file",
    callback=page_of,
    metavar="DIR",
    help="Write a page into a folder: DIR/index.html, with pictures of what deviates.",
)


def write_page(place: Destination, outcome: Report) -> None:
    """Write the page of a run."""
    from ..reports.run.page import check_page

    place.write(check_page(outcome))

"""Pages of HTML from the templates beside this module."""

from __future__ import annotations

from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from .words import printable


def render(template: str, **content: Any) -> str:
    """Return a page of ``templates/``; all text in it is escaped but `Markup`."""
    environment = Environment(
        loader=PackageLoader(__package__, "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=holdable,
        trim_blocks=False,
    )
    return environment.get_template(template).render(**content) + "\n"


def holdable(value: Any) -> Any:
    """Return text without control characters, which no page can hold."""
    return printable(value) if isinstance(value, str) and not isinstance(value, Markup) else value

"""Pages of HTML and Markdown from the templates in this folder."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
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


def render_markdown(
    template: str, filters: Mapping[str, Callable[..., object]], **content: Any
) -> str:
    """Return a page of Markdown of ``templates/``, whose paragraphs one empty line divides.

    Text in it is escaped by the filters that the template names.
    """
    environment = Environment(
        loader=PackageLoader(__package__, "templates"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(filters)
    text = environment.get_template(template).render(**content)
    return re.sub(r"\n{3,}", "\n\n", text).strip() + "\n"


def holdable(value: Any) -> Any:
    """Return text without control characters, which no page can hold."""
    return printable(value) if isinstance(value, str) and not isinstance(value, Markup) else value

"""The pages that ``mbcheck reproduce`` writes: Markdown, and the same as HTML.

The templates ``papers.md``, ``paper.md`` and ``ledger.md`` order their chapters and tables. The
words on a paper are written by hand, in its ``claims.toml``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from html import unescape
from itertools import pairwise
from operator import attrgetter
from pathlib import Path
from types import SimpleNamespace

from markupsafe import Markup

from ...reference import get_scene
from ..engines.registry import REFERENCE
from ..reports.files import write_or_collect
from ..reports.html import render, render_markdown
from ..reports.text import markdown_table
from ..reports.words import Markdown, code, number, plain, with_unit
from .assess import fill
from .claims import read_paper
from .equations import Formulas
from .formulas import Formula, typeset
from .ledger import ERROR, VERDICTS, RowThreshold
from .outcomes import FigureEntry, Findings, RowEntry

STATEMENTS = ("number", "claim")
"""Kinds of rows that the verdict on a paper counts; misprints and readings have chapters."""

DIGITS = 5

FORMULA = re.compile(r"`= (.+?)`"), re.compile(r"<code>= (.+?)</code>")
"""A formula on a page before it is typeset: in Markdown, and as HTML has it."""

LINK = re.compile(r"\[\[(\w+)\]\]")
"""A link to a row, in a verdict."""


def write_pages(result: Findings, out: Path) -> None:
    """Write a page for each paper and one that leads to them, as Markdown and as HTML."""
    pages = {scene: scene_page(result, scene) for scene in result.scenes}
    papers = {scene: get_scene(scene).paper for scene in result.scenes}
    pages["index"] = render_markdown("papers.md", FILTERS, **counted(result), papers=papers)
    for name, text in pages.items():
        write_or_collect(out / f"{name}.md", markdown(text).encode())
        write_or_collect(out / f"{name}.html", html(text).encode())
    write_or_collect(out / "summary.md", summary(result).encode())


def formula(text: str) -> Markdown:
    """Return a formula still to be typeset, or the words that stand in its place."""
    return code(f"= {text}") if typeset(text) else plain(text)


def markdown(text: str) -> str:
    """Return a page with its formulas as LaTeX."""
    return FORMULA[0].sub(lambda match: f"$`{typed(match[1]).latex}`$", text)


def typed(text: str) -> Formula:
    """Return a formula, typeset, that `formula` has accepted."""
    one = typeset(text)
    assert one is not None, text
    return one


def html(text: str) -> str:
    """Return a page as HTML: links lead to pages of the same kind, formulas are MathML."""
    from markdown_it import MarkdownIt

    reader = MarkdownIt("commonmark", {"html": False}).enable("table")
    tokens = reader.parse(text)
    for token, inside in pairwise(tokens):
        if token.type == "heading_open":
            token.attrSet("id", anchor(inside.content))
    body = str(reader.renderer.render(tokens, reader.options, {}))
    body = FORMULA[1].sub(lambda match: typed(unescape(match[1])).mathml, body)
    for part, page in (
        (r'\.md"', '.html"'),
        (r"<table>", '<div class="wide"><table>'),
        (r"</table>", "</table></div>"),
        (r'<p><a href="([^"]*\.png)">', r'<p class="wide"><a href="\1">'),
        *(
            (f"<strong>{name}</strong>", f'<strong class="verdict v{i}">{name}</strong>')
            for i, name in enumerate((*VERDICTS, ERROR))
        ),
    ):
        body = re.sub(part, page, body)
    title = text.partition("\n")[0].lstrip("# ")
    return render("paper.html", title=title, body=Markup(body))


def anchor(heading: str) -> str:
    """Return the name that links give a heading, as GitHub does."""
    return re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-")


def summary(result: Findings) -> str:
    """Return the verdicts alone, which are the same on every machine."""
    return render_markdown("ledger.md", FILTERS, **counted(result))


def counted(result: Findings) -> dict[str, object]:
    """Return the values that fill the table of counts of verdicts."""
    return {"result": result, "verdicts": (*VERDICTS, *([ERROR] if result.failures else []))}


def scene_page(result: Findings, scene: str) -> str:
    """Return the page of one paper, its formulas not typeset yet."""
    own, record = get_scene(scene), read_paper(scene)
    defaults = own.parameters()
    items, figures = result.rows_of(scene), result.figures_of(scene)
    entries: list[FigureEntry | RowEntry] = [*figures, *items]
    return render_markdown(
        "paper.md",
        FILTERS,
        scene=scene,
        paper=own.paper,
        runs=result.runs,
        latest=max((result.runs[item.run] for item in entries), key=attrgetter("date")),
        entries=entries,
        items=items,
        whole=len(record.rows),
        verdict=verdict(scene, items),
        verdicts=(*VERDICTS, ERROR),
        names=Markdown(record.names),
        defaults=defaults,
        parameters=fields(defaults),
        figures=figures,
        numbers=[item.number for item in figures if not item.error],
        causes=record.causes,
        ledger=[item for item in items if item.kind in STATEMENTS],
        errata=[item for item in items if item.erratum],
        readings=[item for item in items if item.kind == "reading"],
    )


# The verdict --------------------------------------------------------------------------------


def verdict(scene: str, items: Sequence[RowEntry]) -> str:
    """Return the verdict that was written by hand, with the numbers of its rows and links to them.

    Empty where one of these rows was not judged.
    """
    text = read_paper(scene).verdict
    known = {
        item.name: SimpleNamespace(**{"printed": item.printed, **item.numbers.get(REFERENCE, {})})
        for item in items
        if not item.failure
    }
    if not set(LINK.findall(text)) <= known.keys():
        return ""
    try:
        parts = LINK.split(fill(text, known))
    except (AttributeError, LookupError):
        return ""
    return "".join(row_links([part]) if i % 2 else plain(part) for i, part in enumerate(parts))


def row_links(names: Iterable[str]) -> str:
    """Return links to rows."""
    return ", ".join(f"[{code(name)}](#{name})" for name in names)


def figures_of(section: str) -> list[int]:
    """Return the figures that a row is about.

    >>> places = "figures 2(a), 3(a)", "figure 4, 5.2", "equation (4), section 5", "figures 2-5"
    >>> list(map(figures_of, places))
    [[2, 3], [4], [], [2, 3, 4, 5]]
    """
    numbers: list[int] = []
    for text in re.findall(r"figures? (\d(?:[\d. ,()a-z-]|and)*)", section):
        for first, last in re.findall(r"(?<![\d.])(\d+)(?:-(\d+))?(?![\d.])", text):
            numbers += range(int(first), int(last or first) + 1)
    return numbers


# Rows ---------------------------------------------------------------------------------------


def sentence(text: str) -> str:
    """Return text that ends as a sentence does."""
    return text if text.endswith(".") else f"{text}."


def values(row: RowEntry) -> str:
    """Return the printed value of a row, and those of the reference and of engines."""
    ours = {REFERENCE: row.reference, **row.engines}
    printed = [f"printed **{plain(row.printed)}**"] if row.printed else []
    return "; ".join([*printed, *(f"{name} {plain(own)}" for name, own in ours.items() if own)])


def measures_of(entry: RowEntry) -> Markdown:
    """Return the names of the functions that compute a row's numbers, besides its equations."""
    rows = [row for row in read_paper(entry.scene).rows if row.name == entry.name]
    calls = [call for row in rows for call in (row.numbers, row.each) if call]
    names = (
        "formulas" if isinstance(call, Formulas) else code(getattr(call, "func", call).__name__)
        for call in calls
    )
    return Markdown(" and ".join(names))


def threshold(item: RowThreshold) -> str:
    """Return the limit that a row is judged by, and its distance from the number."""
    ours = " (our limit)" if item.ours else ""
    met = "met" if item.holds else "missed"
    if item.value is None or item.limit is None or item.distance is None:
        return f"*{item.verdict}*: condition on {code(item.quantity)} {met}{ours}"
    condition = f"{code(item.quantity)} {plain(f'{item.relation} {item.limit:.{DIGITS}g}')}{ours}"
    return (
        f"*{item.verdict}* if {condition}: {item.value:.{DIGITS}g}, {met} "
        f"by {abs(item.distance):.2g}"
    )


FILTERS: Mapping[str, Callable[..., object]] = {
    "plain": plain,
    "code": code,
    "sentence": sentence,
    "links": row_links,
    "values": values,
    "threshold": threshold,
    "measures": measures_of,
    "number": number,
    "with_unit": with_unit,
    "formula": formula,
    "table": markdown_table,
    "figures_of": figures_of,
    "about": lambda rows, n: [row for row in rows if n in figures_of(row.section)],
}
"""Filters of the templates."""

"""The pages that ``mbcheck reproduce`` writes: Markdown, and the same as HTML."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

from markupsafe import Markup

from ...reference import get_scene
from ..reports.files import write_or_collect
from ..reports.html import render
from ..reports.text import markdown_table
from ..reports.words import code
from . import chapters
from .ledger import ERROR, VERDICTS
from .outcomes import Made, Reproduction, RowOutcome, tables


def write_pages(result: Reproduction, out: Path) -> None:
    """Write a page for each paper and one that leads to them, as Markdown and as HTML."""
    for scene in result.figures:
        write(out, scene, scene_page(result, scene))
    write(out, "index", index_page(result))
    write_or_collect(out / "summary.md", summary(result).encode())


def write(out: Path, name: str, text: str) -> None:
    """Write one page twice."""
    write_or_collect(out / f"{name}.md", text.encode())
    write_or_collect(out / f"{name}.html", html(text).encode())


def html(text: str) -> str:
    """Return a page of Markdown as HTML; links lead to pages of the same kind."""
    from markdown_it import MarkdownIt

    reader = MarkdownIt("commonmark", {"html": False}).enable("table")
    tokens = reader.parse(text)
    for token, inside in pairwise(tokens):
        if token.type == "heading_open":
            token.attrSet("id", anchor(inside.content))
    body = str(reader.renderer.render(tokens, reader.options, {}))
    for markdown, page in (
        (r'\.md"', '.html"'),
        (r"<table>", '<div class="wide"><table>'),
        (r"</table>", "</table></div>"),
        *((f"<strong>{name}</strong>", badge(name)) for name in (*VERDICTS, ERROR)),
    ):
        body = re.sub(markdown, page, body)
    title = text.partition("\n")[0].lstrip("# ")
    return render("paper.html", title=title, body=Markup(body))


def badge(verdict: str) -> str:
    """Return a verdict in its colour."""
    return f'<strong class="verdict v{(*VERDICTS, ERROR).index(verdict)}">{verdict}</strong>'


def anchor(heading: str) -> str:
    """Return the name that links give a heading, as GitHub does."""
    return re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-")


def index_page(result: Reproduction) -> str:
    """Return the page that leads to the others."""
    parts = [
        "# The papers, reproduced",
        "\n\n".join(
            f"- [{get_scene(scene).paper.title}]({scene}.md), {get_scene(scene).paper.authors} "
            f"({get_scene(scene).paper.year}): `{scene}`"
            for scene in result.figures
        ),
    ]
    if any(result.rows.values()):
        parts += ["## What holds", counts(result), MEANINGS]
    parts += ["## How it was made", *how_made(result)]
    return "\n\n".join(parts) + "\n"


MEANINGS = """\
- **reproduced**: a printed number is what ours rounds to; a claim meets its conditions.
- **reproduced, unconverged**: by the paper's own truncation; it converges to something else.
- **reproduced with a corrected equation**: with a misprint put right, which the errata show.
- **not reproduced**: computed, and otherwise than printed; the row gives the reason.
- **depends on what is not printed**: it holds with some values of what the paper does not give.
- **open**: our number is within 5 % of a limit that is ours, so that it decides nothing.
- **not testable**: nothing in the paper could be computed and compared."""


def how_made(result: Reproduction, scene: str = "") -> Iterator[str]:
    """Yield versions, sizes and run times of what a page shows."""
    name = f" {scene}" if scene else ""
    for made in result.runs(scene):
        own = [
            outcome
            for items in (result.figures, result.rows)
            for key, outcomes in items.items()
            for outcome in outcomes
            if key == scene or not scene
        ]
        mine = [outcome for outcome in own if outcome.made.run == made.run]
        seconds = sum(outcome.made.seconds for outcome in mine)
        yield (
            f"{len(mine)} figures and rows by "
            f"`mbcheck reproduce{name}{' --full' if made.full else ''}` in {duration(seconds)}, "
            f"maps that were there already not counted, with {with_versions(made)}."
        )


def duration(seconds: float) -> str:
    """Return a run time in words."""
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} min"


def with_versions(made: Made) -> str:
    """Return versions in one line."""
    return ", ".join(f"{name} {version}" for name, version in made.versions.items())


def counts(result: Reproduction) -> str:
    """Return how many rows of each paper have which verdict, and how many causes."""
    named = [*VERDICTS, *([ERROR] if result.failures else [])]
    numbers, causes = result.verdicts, result.causes
    rows = [
        [name, *(with_causes(numbers[scene][name], causes[scene][name]) for scene in numbers)]
        for name in named
    ]
    heads = ["Verdict", *(code(scene) for scene in numbers)]
    return f"{NOTE}\n\n{markdown_table(heads, rows)}"


NOTE = (
    "Rows, those of misprints too; in brackets, where several share one, their causes. Readings "
    "have no verdict, and are not counted."
)


def with_causes(rows: int, causes: int) -> str:
    """Return a number of rows, and of their causes if there are fewer."""
    return f"{rows} ({causes})" if causes < rows else str(rows)


def scene_page(result: Reproduction, scene: str) -> str:
    """Return the page of one paper."""
    paper = get_scene(scene).paper
    where = ", ".join(filter(None, [paper.journal, str(paper.year)]))
    link = f", [doi:{paper.doi}](https://doi.org/{paper.doi})" if paper.doi else ""
    figures, items = result.figures[scene], result.rows.get(scene, ())
    parts = [f"# {scene}: {paper.title}", f"{paper.authors}, {where}{link}. [All papers](index.md)"]
    parts += chapter("Verdict", [*missing(scene, items), *verdict(scene, items)])
    parts += chapter("Parameters", [chapters.parameters(scene)])
    parts += chapter(
        "Figures",
        [part for item in figures for part in chapters.figure_part(scene, item, items)],
    )
    drawn = [item.figure.number for item in figures if not item.failed]
    for title, kinds, head in (
        ("Ledger", ("number", "claim"), ledger_head),
        ("Errata", ("misprint",), lambda scene, _: [chapters.errata(items)]),
        ("What the text leaves open", ("reading",), lambda scene, items: []),
    ):
        own = [item for item in items if item.row.kind in kinds]
        each = [part for item in own for part in chapters.row_part(scene, item, drawn)]
        parts += chapter(title, [*head(scene, own), *each] if own else [])
    parts += chapter("How it was made", list(how_made(result, scene)))
    return "\n\n".join(parts) + "\n"


def chapter(title: str, parts: Sequence[str]) -> list[str]:
    """Return a chapter, nothing if there is nothing in it."""
    return [f"## {title}", *parts] if parts else []


def missing(scene: str, items: Sequence[RowOutcome]) -> list[str]:
    """Return a warning if rows of the paper have not been judged yet."""
    whole = len(tables(scene)[1])
    if len(items) == whole:
        return []
    return [f"*{len(items)} of {whole} rows are judged here; `mbcheck reproduce {scene}`.*"]


def verdict(scene: str, items: Sequence[RowOutcome]) -> list[str]:
    """Return the verdict in sentences, one a line."""
    if not items:
        return []
    return ["\n".join(f"{i}. {text}" for i, text in enumerate(chapters.verdict(scene, items), 1))]


def ledger_head(scene: str, items: Sequence[RowOutcome]) -> list[str]:
    """Return what comes before the rows: how to read them, all of them at a glance, causes."""
    table = chapters.cause_table(scene, items)
    return list(filter(None, [LEGEND, table, chapters.overview(items)]))


LEGEND = (
    "Each row is something that the paper prints or claims, in our words. A printed number "
    "is *reproduced* if ours rounds to it. Values are computed, none is tuned to agree where "
    "the row does not say so; what cannot be tested is text."
)
"""How to read the ledger."""


def summary(result: Reproduction) -> str:
    """Return the verdicts alone: what stays the same from machine to machine."""
    parts = [
        "# Ledger: what of the papers holds",
        "Generated by `mbcheck reproduce`, which also gives values, reasons and figures. A test "
        "keeps the verdicts true.",
        counts(result),
    ]
    for scene, items in result.rows.items():
        parts += [
            f"## {scene}",
            markdown_table(
                ["Row", "Where", "What", "Printed", "Verdict"],
                [
                    [
                        f"`{item.row.name}`",
                        item.row.section,
                        item.row.summary,
                        item.row.printed,
                        item.assessment.verdict,
                    ]
                    for item in items
                ],
            ),
        ]
    return "\n\n".join(parts) + "\n"

"""The pages that ``mbcheck reproduce`` writes: Markdown, and the same as HTML."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from markupsafe import Markup

from ...reference import get_scene
from ..reports.files import write_whole
from ..reports.html import render
from ..reports.text import markdown_table
from .ledger import ERROR, VERDICTS
from .reproduce import FigureOutcome, Reproduction, RowOutcome

KIND_TITLES = {
    "number": "Printed numbers",
    "claim": "Claims",
    "misprint": "Misprints",
    "reading": "What the text leaves open",
}


def write_pages(result: Reproduction, out: Path) -> None:
    """Write a page for each paper and one that leads to them, as Markdown and as HTML."""
    for scene in result.figures:
        write(out, scene, scene_page(result, scene))
    write(out, "index", index_page(result))
    write_whole(out / "summary.md", summary(result).encode())


def write(out: Path, name: str, text: str) -> None:
    """Write one page twice; links lead to pages of the same kind."""
    from markdown_it import MarkdownIt

    write_whole(out / f"{name}.md", text.encode())
    body = MarkdownIt("commonmark", {"html": False}).enable("table").render(text)
    for markdown, html in (
        ('.md"', '.html"'),
        ("<table>", '<div class="wide"><table>'),
        ("</table>", "</table></div>"),
    ):
        body = body.replace(markdown, html)
    title = text.partition("\n")[0].lstrip("# ")
    page = render("base.html", title=title, body=Markup(body))
    write_whole(out / f"{name}.html", page.encode())


def index_page(result: Reproduction) -> str:
    """Return the page that leads to the others."""
    versions = ", ".join(f"{name} {version}" for name, version in result.versions.items())
    size = "full size" if result.full else "default size; `--full` takes finer maps, longer runs"
    parts = [
        "# The papers, reproduced",
        f"Made by `mbcheck reproduce` ({size}) with {versions}.",
        "\n\n".join(
            f"- [{get_scene(scene).paper.title}]({scene}.md), {get_scene(scene).paper.authors} "
            f"({get_scene(scene).paper.year}): `{scene}`"
            for scene in result.figures
        ),
    ]
    if any(result.rows.values()):
        parts += ["## What holds", counts(result)]
    return "\n\n".join(parts) + "\n"


def counts(result: Reproduction) -> str:
    """Return how many rows of each paper have which verdict, and how many causes."""
    named = [*VERDICTS, *([ERROR] if result.failures else [])]
    rows = [
        [f"`{scene}`", *(with_causes(number[name], result.causes[scene][name]) for name in named)]
        for scene, number in result.verdicts.items()
    ]
    return f"{COUNTED}\n\n{markdown_table(['Paper', *named], rows)}"


COUNTED = (
    "Rows; in brackets, where several share one, their causes. Readings have no verdict, and are "
    "not counted."
)


def with_causes(rows: int, causes: int) -> str:
    """Return a number of rows, and of their causes if there are fewer."""
    return f"{rows} ({causes})" if causes < rows else str(rows)


def scene_page(result: Reproduction, scene: str) -> str:
    """Return the page of one paper."""
    paper = get_scene(scene).paper
    where = ", ".join(filter(None, [paper.journal, str(paper.year)]))
    link = f", [doi:{paper.doi}](https://doi.org/{paper.doi})" if paper.doi else ""
    parts = [
        f"# {scene}: {paper.title}",
        f"{paper.authors}, {where}{link}. [All papers](index.md)",
    ]
    if items := result.rows.get(scene):
        parts += ["## Ledger", LEGEND, *sections(items)]
    if figures := result.figures[scene]:
        parts += ["## Figures", *(figure_part(scene, item) for item in figures)]
    return "\n\n".join(parts) + "\n"


LEGEND = (
    "Each row is something that the paper prints or claims, in our words. A printed number "
    "is *reproduced* if ours rounds to it. Values are computed, none is tuned to agree; what "
    "cannot be tested, what the text leaves open, and most misprints, which tests prove, are "
    "text."
)
"""How to read the ledger."""


def sections(items: Sequence[RowOutcome]) -> Iterable[str]:
    """Yield the tables of a ledger, one for each kind of row."""
    for kind, title in KIND_TITLES.items():
        chapter = [item for item in items if item.row.kind == kind]
        if not chapter:
            continue
        yield f"### {title}"
        yield markdown_table(
            ["Where", "What", "Printed", "Reference", "Engines", "Verdict", "Why"],
            [ledger_line(item) for item in chapter],
        )
        for row, assessment in chapter:
            if assessment.candidates:
                yield f"What the candidates give, *{row.summary}*"
                yield markdown_table(
                    ["Reading", "Gives"], [list(pair) for pair in assessment.candidates]
                )


def ledger_line(item: RowOutcome) -> list[str]:
    """Return the cells of a row."""
    row, assessment = item
    engines = "; ".join(f"{name} {value}" for name, value in assessment.engines.items())
    reason = f"{assessment.reason} ({row.test})" if row.test else assessment.reason
    return [
        row.section,
        row.summary,
        row.printed,
        assessment.reference,
        engines,
        f"**{assessment.verdict}**" if assessment.verdict else "",
        reason,
    ]


def figure_part(scene: str, item: FigureOutcome) -> str:
    """Return a figure with its caption."""
    figure, error = item
    head = f"### Figure {figure.number}: {figure.title}"
    if error:
        return f"{head}\n\nNot drawn: {plain(error)}"
    name = f"figures/{scene}_{figure.number}"
    return f"{head}\n\n![{plain(figure.title)}]({name}.png)\n\n{figure.caption} ([SVG]({name}.svg))"


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
                    [f"`{row.name}`", row.section, row.summary, row.printed, assessment.verdict]
                    for row, assessment in items
                ],
            ),
        ]
    return "\n\n".join(parts) + "\n"


def plain(text: str) -> str:
    """Return text that keeps to one cell of a table."""
    return " ".join(text.split()).replace("|", "\\|")

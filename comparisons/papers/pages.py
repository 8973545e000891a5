"""The pages that ``mbcheck reproduce`` writes: Markdown, and the same as HTML.

The template ``paper.md`` orders the chapters of a paper; its tables are made here. The words on a
paper are written by hand, in its ``claims.toml``.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import fields
from html import unescape
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

from markupsafe import Markup

from ...reference import get_scene
from ...reference.scene import Paper
from ..engines.registry import REFERENCE
from ..reports.files import write_or_collect
from ..reports.html import render, render_markdown
from ..reports.text import markdown_table
from ..reports.words import Markdown, code, number, plain, with_unit
from .assess import fill
from .claims import read_paper
from .formulas import Formula, typeset
from .ledger import DEPENDS, ERROR, VERDICTS, RowThreshold
from .outcomes import Findings, Made, RowEntry

STATEMENTS = ("number", "claim")
"""Kinds of rows that the verdict on a paper counts; misprints and readings have chapters."""

FAULTS = {"print": "of print", "reasoning": "of reasoning", "wording": "of wording or a symbol"}

PROVENANCE = ("chosen", "calibrated", "derived")
"""Words before the colon of a parameter's source; without one it is printed."""

DIGITS = 5

MEANINGS = f"""\
- **reproduced**: our number rounds to the printed one; a claim meets its conditions.
- **reproduced, unconverged**: by the paper's own truncation; it converges to something else.
- **reproduced with a corrected equation**: with a misprint corrected, which the errata show.
- **not reproduced**: computed, and otherwise than printed; the row gives the reason.
- **{DEPENDS}**: it holds with some values of the quantities that the paper does not give.
- **open**: our number is within 5 % of a limit of ours, so that it decides nothing.
- **not testable**: nothing in the paper could be computed and compared."""

NOTE = (
    "Numbers of rows, misprints included; in brackets, where several rows share one, the numbers "
    "of causes. Readings have no verdict, and are not counted. The page of a paper counts its "
    "printed numbers and claims alone."
)

FORMULA = re.compile(r"`= (.+?)`"), re.compile(r"<code>= (.+?)</code>")
"""A formula on a page before it is typeset: in Markdown, and as HTML has it."""

LINK = re.compile(r"\[\[(\w+)\]\]")
"""A link to a row, in a verdict."""

SOURCE = "mbcheck developers, *mbcheck: a validation suite for multibody engines*"
"""Work that a page is cited as part of."""


def write_pages(result: Findings, out: Path) -> None:
    """Write a page for each paper and one that leads to them, as Markdown and as HTML."""
    pages = {scene: scene_page(result, scene) for scene in result.scenes}
    for name, text in (pages | {"index": index_page(result)}).items():
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


def index_page(result: Findings) -> str:
    """Return the page that leads to the others."""
    papers = [(scene, get_scene(scene).paper) for scene in result.scenes]
    parts = [
        "# The papers, reproduced",
        *(f"- [{p.title}]({scene}.md), {p.authors} ({p.year}): `{scene}`" for scene, p in papers),
    ]
    if result.rows:
        parts += ["## What holds", counts(result), MEANINGS]
    parts += ["## How it was made", *how_made(result)]
    return "\n\n".join(parts) + "\n"


def summary(result: Findings) -> str:
    """Return the verdicts alone, which are the same on every machine."""
    parts = [
        "# Ledger: what of the papers holds",
        "Generated by `mbcheck reproduce`, which also gives values, reasons and figures.",
        counts(result),
    ]
    heads = ["Row", "Where", "What", "Printed", "Verdict"]
    for scene in result.scenes:
        rows = [
            [f"`{row.name}`", row.section, row.claim, row.printed, row.verdict]
            for row in result.rows_of(scene)
        ]
        parts += [f"## {scene}", markdown_table(heads, rows)]
    return "\n\n".join(parts) + "\n"


def counts(result: Findings) -> str:
    """Return the numbers of rows and causes of each paper with each verdict."""
    by_scene = [(result.verdicts(one), result.causes_by_verdict(one)) for one in result.scenes]
    lines = [
        [
            name,
            *(
                f"{rows[name]} ({own[name]})" if own[name] < rows[name] else str(rows[name])
                for rows, own in by_scene
            ),
        ]
        for name in (*VERDICTS, *([ERROR] if result.failures else []))
    ]
    return f"{NOTE}\n\n{markdown_table(['Verdict', *map(code, result.scenes)], lines)}"


def how_made(result: Findings, scene: str = "") -> Iterator[str]:
    """Yield versions, sizes and run times of the figures and rows on a page."""
    name = f" {scene}" if scene else ""
    every = [item for item in result.entries if item.scene == scene or not scene]
    for run in dict.fromkeys(item.run for item in every):
        made, mine = result.runs[run], [item for item in every if item.run == run]
        seconds = sum(item.seconds for item in mine)
        duration = f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} min"
        versions = ", ".join(f"{name} {version}" for name, version in made.versions.items())
        yield (
            f"{len(mine)} figures and rows by "
            f"`mbcheck reproduce{name}{' --full' if made.full else ''}`{when(made)} in {duration}, "
            f"without the time of maps that earlier runs had computed, with {versions}."
        )


def when(made: Made) -> str:
    """Return date and commit of a run, as far as they are known."""
    parts = [("on", made.date), ("at commit", code(made.commit) if made.commit else "")]
    return "".join(f" {word} {text}" for word, text in parts if text)


def link(paper: Paper) -> str:
    """Return a link to a paper."""
    doi = paper.doi and f"[doi:{paper.doi}](https://doi.org/{paper.doi})"
    return doi or (paper.url and f"[{paper.url}](https://{paper.url})")


def citation(result: Findings, scene: str) -> str:
    """Return the citation of a page, by version, date and commit of its latest run."""
    runs = [result.runs[item.run] for item in result.entries if item.scene == scene]
    made = max(runs, key=lambda run: run.date)
    version = made.versions.get("mbcheck", "unknown")
    made_when = when(made) and f", made{when(made)}"
    return f"Cite as: {SOURCE}, version {version}, page {code(scene)}{made_when}."


def scene_page(result: Findings, scene: str) -> str:
    """Return the page of one paper, its formulas not typeset yet."""
    paper = get_scene(scene).paper
    items, whole = result.rows_of(scene), len(read_paper(scene).rows)
    short = f"*{len(items)} of {whole} rows are judged here; `mbcheck reproduce {scene}`.*"
    ledger = [item for item in items if item.kind in STATEMENTS]
    return render_markdown(
        "paper.md",
        {
            "plain": plain,
            "code": code,
            "sentence": sentence,
            "links": row_links,
            "lines": row_lines,
            "table": markdown_table,
            "figures_of": figures_of,
            "about": lambda rows, n: [row for row in rows if n in figures_of(row.section)],
        },
        scene=scene,
        paper=paper,
        where=", ".join(filter(None, [paper.journal, str(paper.year)])),
        link=link(paper),
        citation=citation(result, scene),
        items=items,
        missing=short if len(items) < whole else "",
        verdict=verdict(scene, items),
        verdict_table=verdict_table(ledger),
        names=Markdown(read_paper(scene).names),
        parameters=parameters(scene),
        figures=result.figures_of(scene),
        numbers=[item.number for item in result.figures_of(scene) if not item.error],
        ledger=ledger,
        cause_table=cause_table(scene, ledger),
        overview=overview(ledger),
        errata=[item for item in items if item.erratum],
        places=places(items),
        certain=errata(items, in_copy=False),
        copied=errata(items, in_copy=True),
        readings=[item for item in items if item.kind == "reading"],
        made="\n\n".join(how_made(result, scene)),
    )


def table_or_nothing(heads: Sequence[str], lines: Sequence[Sequence[object]]) -> str:
    """Return a table, or nothing if it has no lines."""
    return markdown_table(heads, lines) if lines else ""


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


def verdict_table(rows: Sequence[RowEntry]) -> str:
    """Return the numbers of printed numbers and claims with each verdict."""
    count = Counter((row.verdict, row.kind) for row in rows)
    lines = [
        [Markdown(f"**{name}**"), *(count[name, kind] for kind in STATEMENTS)]
        for name in (*VERDICTS, ERROR)
        if any(count[name, kind] for kind in STATEMENTS)
    ]
    return table_or_nothing(["Verdict", "Printed numbers", "Claims"], lines)


def places(items: Sequence[RowEntry]) -> str:
    """Return the numbers of places to correct, and of those that may be faults of our copy."""
    errata = [item.erratum for item in items if item.erratum]
    lines = []
    for kind, words in FAULTS.items():
        mine = [one for one in errata if one.kind == kind]
        sizes = [sum(len(one.equations) for one in mine if one.copy or not copy) for copy in (0, 1)]
        lines += [[words, *sizes]] if mine else []
    heads = ["Places to correct", "All", "Of these perhaps faults of our copy"]
    return table_or_nothing(heads, lines)


def row_links(names: Iterable[str]) -> str:
    """Return links to rows."""
    return ", ".join(f"[{code(name)}](#{name})" for name in names)


# Parameters ---------------------------------------------------------------------------------


def parameters(scene: str) -> str:
    """Return the table of the parameters' values and their sources."""
    defaults = get_scene(scene).parameters()
    rows = []
    for item in fields(defaults):
        about, value = item.metadata, getattr(defaults, item.name)
        how, _, where = about["source"].partition(":")
        if how not in PROVENANCE:
            how, where = "printed", about["source"]
        words = value if isinstance(value, str) else with_unit(value, about["unit"], 10)
        source = ": ".join(filter(None, (how, where.strip())))
        rows.append([about["symbol"], words, source, about["meaning"], code(item.name)])
    return markdown_table(["Symbol", "Value", "Source", "What", "Name"], rows)


def figures_of(section: str) -> list[int]:
    """Return the figures that a row is about.

    >>> [figures_of(text) for text in ("5.1, figures 2(a), 3(a)", "equation (4)", "figures 2-5")]
    [[2, 3], [], [2, 3, 4, 5]]
    """
    numbers: list[int] = []
    for text in re.findall(r"figures? (\d(?:[\d. ,()a-z-]|and)*)", section):
        for first, last in re.findall(r"(?<![\d.])(\d+)(?:-(\d+))?(?![\d.])", text):
            numbers += range(int(first), int(last or first) + 1)
    return numbers


# The ledger and the errata --------------------------------------------------------------------


def overview(items: Sequence[RowEntry]) -> str:
    """Return the table of all rows, each with a link to its result."""
    rows = [
        [Markdown(row_links([row.name])), row.section, row.printed, Markdown(f"**{row.verdict}**")]
        for row in items
    ]
    return markdown_table(["Row", "Where", "Printed", "Verdict"], rows)


def errata(items: Sequence[RowEntry], in_copy: bool) -> str:
    """Return the table of errata that are certain, or that may be faults of our copy."""
    heads = ["Where", "Printed", "Corrected", "Why", "Effect", *["Our copy"] * in_copy, "Row"]
    lines = [
        [
            ", ".join(one.equations),
            formula(row.printed),
            formula(one.corrected),
            *map(plain, (one.why, one.effect, *[one.copy] * in_copy)),
            Markdown(row_links([row.name])),
        ]
        for row in items
        if (one := row.erratum) and bool(one.copy) == in_copy
    ]
    return table_or_nothing(heads, lines)


def cause_table(scene: str, items: Sequence[RowEntry]) -> str:
    """Return the table of the causes that several rows share."""
    there = {row.name for row in items}
    shared = [
        [cause.summary, Markdown(row_links(own))]
        for cause in read_paper(scene).causes
        if (own := [name for name in cause.rows if name in there])
    ]
    return table_or_nothing(["Cause", "Rows"], shared)


def sentence(text: str) -> str:
    """Return text that ends as a sentence does."""
    return text if text.endswith(".") else f"{text}."


def row_lines(row: RowEntry) -> Iterator[str]:
    """Yield the values of a row, its limits, its cause and its command."""
    ours = {REFERENCE: row.reference, **row.engines}
    values = [f"{name} {plain(value)}" for name, value in ours.items() if value]
    printed = [f"printed **{plain(row.printed)}**"] if row.printed else []
    if printed or values:
        yield "; ".join([*printed, *values])
    yield from map(threshold, row.thresholds)
    for cause in read_paper(row.scene).causes:
        if cause.name == row.cause:
            yield f"cause, shared with other rows: {plain(sentence(cause.summary))}"
    if row.thresholds or row.failure:
        seconds = f" ({number(row.seconds, 2)} s)" if row.seconds >= 1 else ""
        functions = [code(name) for name in functions_of(row)]
        words = f", numbers by {' and '.join(functions)}" if functions else ""
        yield f"{code(f'mbcheck reproduce {row.scene} --row {row.name}')}{seconds}{words}"


def functions_of(entry: RowEntry) -> list[str]:
    """Return the names of the functions that compute a row's numbers, besides its equations."""
    rows = [row for row in read_paper(entry.scene).rows if row.name == entry.name]
    calls = [call for row in rows for call in (row.numbers, row.each) if call]
    return [getattr(call, "func", call).__name__ for call in calls]


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

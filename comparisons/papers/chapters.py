"""The chapters of a paper's page: verdict, parameters, figures, ledger, errata, readings."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import fields

from ...reference import get_scene
from ..engines.registry import REFERENCE
from ..reports.text import markdown_table
from ..reports.words import Markdown, code, number, plain, plural, with_unit
from .assess import RowThreshold
from .ledger import (
    CORRECTED,
    DEPENDS,
    NOT_REPRODUCED,
    NOT_TESTABLE,
    OPEN,
    REPRODUCED,
    UNCONVERGED,
    VERDICTS,
)
from .outcomes import FigureOutcome, RowOutcome, cause_of, causes, conclusions

STATEMENTS = ("number", "claim")
"""Kinds of rows that the verdict on a paper counts; misprints and readings have chapters."""

HOLDS = (REPRODUCED, CORRECTED)

ROUGHLY = "come out only with as few assumed modes as are not converged"

PROVENANCE = ("chosen", "calibrated", "derived")
"""Of a parameter: the word before the colon of its source; without one it is printed."""

DIGITS = 5


# The verdict in five sentences --------------------------------------------------------------


def verdict(scene: str, items: Sequence[RowOutcome]) -> Iterator[str]:
    """Yield what holds of a paper, what does not, and why: five sentences made of its rows."""
    rows = [item for item in items if item.row.kind in STATEMENTS]
    count = Counter(item.assessment.verdict for item in rows)
    numbers = [item for item in rows if item.row.kind == "number"]
    right = sum(item.assessment.verdict in HOLDS for item in numbers)
    rough = sum(item.assessment.verdict == UNCONVERGED for item in numbers)
    each = "; ".join(f"{count[name]} {name}" for name in VERDICTS if count[name])
    yield (
        f"Misprints (see 4) apart, {len(rows)} numbers and claims were judged: {each}; of the "
        f"{plural(len(numbers), 'printed number')} {right} come out"
        f"{f', and {rough} {ROUGHLY}' * bool(rough)}."
    )
    yield of_conclusions(scene, rows)
    yield of_causes(scene, rows)
    yield of_errata(items)
    yield of_gaps(rows, items)


def of_conclusions(scene: str, rows: Sequence[RowOutcome]) -> str:
    """Return what holds of the paper's abstract and conclusions."""
    own = [item for item in rows if is_conclusion(scene, item.row.section)]
    groups = {
        "there hold": [item for item in own if item.assessment.verdict in HOLDS],
        ROUGHLY: [item for item in own if item.assessment.verdict == UNCONVERGED],
        "do not hold": [item for item in own if item.assessment.verdict == NOT_REPRODUCED],
        "cannot be told": [
            item for item in own if item.assessment.verdict in (OPEN, DEPENDS, NOT_TESTABLE)
        ],
    }
    parts = [
        f"**{word}** ({len(group)}): {', '.join(summary_link(item) for item in group)}"
        for word, group in groups.items()
        if group
    ]
    return f"Of its abstract and conclusions {'; '.join(parts) or 'nothing was judged'}."


def is_conclusion(scene: str, section: str) -> bool:
    """Return whether something stands in the abstract or the conclusions."""
    words = re.sub(r"(figure|equation|table)s? .*", "", section).split(", ")
    return bool({"abstract", conclusions(scene)} & set(words) or "conclusion" in section)


def summary_link(item: RowOutcome) -> str:
    """Return what a row says, as a link to it."""
    text = item.row.summary.rstrip(".")
    lower = text[:1].lower() + text[1:] if text[1:2].islower() else text
    return f"[{plain(lower)}](#{item.row.name})"


def row_links(names: Iterable[str]) -> str:
    """Return links to rows."""
    return ", ".join(f"[{code(name)}](#{name})" for name in names)


def of_causes(scene: str, rows: Sequence[RowOutcome]) -> str:
    """Return why rows are not reproduced: causes that several share, and the others."""
    failed = [item.row.name for item in rows if item.assessment.verdict == NOT_REPRODUCED]
    shared = [
        (cause, own)
        for cause in causes(scene)
        if (own := [name for name in failed if name in cause.rows])
    ]
    alone = [name for name in failed if not cause_of(scene, name)]
    parts = [
        f"{plain(cause.summary.rstrip('.'))} ({plural(len(own), 'row')}: {row_links(own)})"
        for cause, own in shared
    ]
    if alone:
        each = "each " * (len(alone) > 1)
        parts.append(f"{each}with a reason of its own: {row_links(alone)}")
    if not parts:
        return "No row fails."
    count = len(shared) + len(alone)
    has = "has" if len(failed) == 1 else "have"
    return (
        f"The {plural(len(failed), 'row')} not reproduced {has} {plural(count, 'cause')}: "
        f"{'; '.join(parts)}."
    )


def of_errata(items: Sequence[RowOutcome]) -> str:
    """Return how many misprints there are, and what becomes of the paper with them put right."""
    errata = [item for item in items if item.row.erratum]
    effects = [item.row.erratum.effect for item in errata if item.row.erratum]
    harmless = sum(text.startswith("none") for text in effects)
    rows = [item for item in items if item.row.kind in STATEMENTS]
    saved = [item.row.name for item in rows if item.assessment.verdict == CORRECTED]
    effect = f", {harmless} of them without an effect shown on its results" if harmless else ""
    rest = f"; {plural(len(saved), 'row')} hold with them put right ({row_links(saved)})"
    by_row = [equations_of(item.row.section) for item in errata]
    numbers = set().union(*by_row)
    places = f" in equations {', '.join(f'({one})' for one in sorted(numbers))}" if numbers else ""
    elsewhere = sum(not own for own in by_row)
    places += f", {elsewhere} of them elsewhere" if elsewhere else ""
    return f"It has {plural(len(errata), 'misprint')}{places}{effect}{rest * bool(saved)}."


def equations_of(section: str) -> set[int]:
    """Return the equations that something stands in, not those that it stands beside.

    >>> [equations_of(text) for text in ("(4), (5)", "2, above (17)", "2, (13), below (21)")]
    [{4, 5}, set(), {13}]
    """
    inside = re.sub(r"(above|after|below|from) [^,]*", "", section)
    return set(map(int, re.findall(r"\((\d+)\)", inside)))


def of_gaps(rows: Sequence[RowOutcome], items: Sequence[RowOutcome]) -> str:
    """Return what cannot be decided, since it is not in the paper."""
    by_verdict = {
        name: [item.row.name for item in rows if item.assessment.verdict == name]
        for name in (DEPENDS, OPEN, NOT_TESTABLE)
    }
    parts = [
        f"{plural(len(names), 'row')} {'is' if len(names) == 1 else 'are'} {name} "
        f"({row_links(names)})".replace("is depends", "depends").replace("are depends", "depend")
        for name, names in by_verdict.items()
        if names
    ]
    left = [item.row.name for item in items if item.row.kind == "reading"]
    parts.append(f"the text leaves open {len(left)} things that had to be chosen here")
    return f"Not decided by what is printed: {'; '.join(parts)}."


# Parameters ---------------------------------------------------------------------------------


def parameters(scene: str) -> str:
    """Return the table of the parameters' values, and where each is from."""
    defaults = get_scene(scene).parameters()
    rows = []
    for item in fields(defaults):
        about = item.metadata
        word, colon, rest = about["source"].partition(":")
        known = word in PROVENANCE
        how = word if known else "printed"
        where = rest.strip() if known and colon else "" if known else about["source"]
        value = getattr(defaults, item.name)
        words = value if isinstance(value, str) else with_unit(value, about["unit"], 10)
        rows.append([about["symbol"], words, how, where, about["meaning"], code(item.name)])
    heads = ["Symbol", "Value", "Provenance", "Where", "What", "Name"]
    return markdown_table(heads, rows)


# Figures ------------------------------------------------------------------------------------


def figure_part(scene: str, item: FigureOutcome, rows: Sequence[RowOutcome]) -> Iterator[str]:
    """Yield a figure with its caption, and the rows that are about it."""
    figure, error, _ = item
    yield f"### Figure {figure.number}"
    yield f"**{plain(figure.title)}**"
    if error:
        yield f"Not drawn: {plain(error)}"
        return
    yield f"![{plain(figure.title)}](figures/{scene}_{figure.number}.png)"
    about = [item.row.name for item in rows if figure.number in figures_of(item.row.section)]
    yield plain(figure.caption) + (f" Rows about it: {row_links(about)}." if about else "")


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


# The ledger ---------------------------------------------------------------------------------


def overview(items: Sequence[RowOutcome]) -> str:
    """Return the table of all rows, each with a link to what was found."""
    return markdown_table(
        ["Row", "Where", "Printed", "Verdict"],
        [
            [
                Markdown(f"[{code(item.row.name)}](#{item.row.name})"),
                item.row.section,
                item.row.printed,
                Markdown(f"**{item.assessment.verdict}**"),
            ]
            for item in items
        ],
    )


def row_part(scene: str, item: RowOutcome, drawn: Sequence[int]) -> Iterator[str]:
    """Yield what was found of one row."""
    row, assessment, _ = item
    yield f"#### {code(row.name)}"
    where = [f"[figure {n}](#figure-{n})" for n in figures_of(row.section) if n in drawn]
    place = ("section " if row.section[0].isdigit() else "") + plain(row.section)
    place += f" (see {', '.join(where)})" if where else ""
    yield f"{place}: {plain(sentence(row.summary))}"
    head = f"**{assessment.verdict}**" if assessment.verdict else ""
    why = plain(sentence(assessment.reason)) if assessment.reason else ""
    if head or why:
        yield ": ".join(filter(None, [head, why]))
    yield "\n".join(f"- {line}" for line in row_lines(scene, item))
    if assessment.candidates:
        yield markdown_table(["Reading", "Gives"], [list(pair) for pair in assessment.candidates])


def sentence(text: str) -> str:
    """Return text that ends as a sentence does."""
    return text if text.endswith(".") else f"{text}."


def row_lines(scene: str, item: RowOutcome) -> Iterator[str]:
    """Yield the values of a row, its limits, its cause, its erratum and its command."""
    row, assessment, made = item
    ours = {REFERENCE: assessment.reference, **assessment.engines}
    values = [f"{name} {plain(value)}" for name, value in ours.items() if value]
    printed = [f"printed **{plain(row.printed)}**"] if row.printed else []
    if printed or values:
        yield "; ".join([*printed, *values])
    yield from map(threshold, assessment.thresholds)
    if cause := next((one for one in causes(scene) if row.name in one.rows), None):
        others = [name for name in cause.rows if name != row.name]
        yield f"cause: {plain(sentence(cause.summary))} Shared with {row_links(others)}"
    if row.erratum:
        for word, text in (
            ("corrected", row.erratum.corrected),
            ("why", row.erratum.why),
            ("effect", row.erratum.effect),
            ("our copy", row.erratum.copy),
        ):
            if text:
                yield f"{word}: {plain(text)}"
        if row.erratum.test:
            yield f"shown by the test {code(row.erratum.test)}"
    if not row.is_text:
        seconds = f" ({number(made.seconds, 2)} s)" if made.seconds >= 1 else ""
        yield f"{code(f'mbcheck reproduce {scene} --row {row.name}')}{seconds}"


def threshold(item: RowThreshold) -> str:
    """Return by which limit a row is judged, and how far it is from that."""
    ours = " (our limit)" if item.ours else ""
    met = "met" if item.holds else "missed"
    if item.value is None or item.limit is None or item.distance is None:
        return f"condition for *{item.verdict}*: {code(item.quantity)} {met}{ours}"
    text = f"{item.value:.{DIGITS}g} {item.relation} {item.limit:.{DIGITS}g}"
    return (
        f"condition for *{item.verdict}*: {code(item.quantity)} {plain(text)}{ours}, {met} "
        f"by {abs(item.distance):.2g}"
    )


# Errata -------------------------------------------------------------------------------------


def errata(items: Sequence[RowOutcome]) -> str:
    """Return the table of misprints: where, and what should stand there."""
    return markdown_table(
        ["Where", "What is wrong", "Corrected", "Row"],
        [
            [
                item.row.section,
                item.row.summary,
                item.row.erratum.corrected,
                Markdown(f"[{code(item.row.name)}](#{item.row.name})"),
            ]
            for item in items
            if item.row.erratum
        ],
    )


def cause_table(scene: str, items: Sequence[RowOutcome]) -> str:
    """Return the table of what several rows have in common, empty if none have."""
    there = {item.row.name for item in items}
    shared = [
        [cause.summary, Markdown(row_links(own))]
        for cause in causes(scene)
        if (own := [name for name in cause.rows if name in there])
    ]
    return markdown_table(["Cause", "Rows"], shared) if shared else ""

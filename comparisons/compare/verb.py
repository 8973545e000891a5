"""The verb ``mbcheck compare``."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

from ...reference.errors import EngineError
from ..reports.files import Destination, refuse_conflicts
from ..reports.words import plural
from ..terminal.options import with_options_of
from ..terminal.program import (
    JSON,
    JUNIT,
    MARKDOWN,
    MISUSED,
    SARIF,
    complain,
    console,
    examples,
    json_text,
    to_stdout,
)
from .request import CompareRequest

if TYPE_CHECKING:
    from ..reports.item import ReportItem
    from ..reports.sections import Section
    from .comparison import Difference, ModelComparison
    from .gaps import Gap

RULES = {
    "compare": ("a difference between two readings of one model", "the model moves differently"),
    "waiver_unused": ("a waiver that waives nothing", "the difference that it allowed is gone"),
}
"""Rule -> its meaning, and the reason for it, in SARIF."""


@click.command(
    epilog=examples(
        "mbcheck compare old.xml new.xml",
        "mbcheck compare model.xml model.xml@mujoco==3.3.7 --install",
        "mbcheck compare model.xml model.xml@/opt/other/bin/python --json -",
        "mbcheck compare model.xml model.xml@my_engine:MyEngine --waivers known.toml",
    ),
)
@with_options_of(CompareRequest)
@JSON
@JUNIT
@SARIF
@MARKDOWN
def compare_models(
    a: str,
    b: str,
    install: bool,
    waivers: str | None,
    annotations: bool | None,
    json_file: Destination | None,
    junit_file: Destination | None,
    sarif_file: Destination | None,
    markdown_file: Destination | None,
) -> int:
    """Compare two readings of one model, and name the elements that differ.

    The compiled models are compared by element and attribute, renamed and reordered elements
    matched; then what both do at the same states, and whether editing A by the differences makes
    it move like B. Exit code 0 if they are alike, 1 if they differ, 2 if one cannot be read.
    """
    documents = json_file, junit_file, sarif_file, markdown_file
    refuse_conflicts(*documents)
    from ..queries.environment import versions
    from ..reports.github import annotated, append_step_summary
    from ..reports.junit import junit
    from ..reports.sarif import sarif
    from ..reports.sections import markdown_sections, print_sections
    from .comparison import compare

    items: list[ReportItem] = []
    with annotated(lambda: items, annotations, to_stdout(*documents)):
        try:
            result = compare(a, b, install, waivers)
        except EngineError as error:
            return complain(str(error), MISUSED)
        items += result.items()
        title = f"mbcheck compare: {verdict(result)}"
        report = list(sections(result))
        if json_file:
            json_file.write(json_text(result.as_json()))
        if junit_file:
            junit_file.write(junit(items))
        if sarif_file:
            sarif_file.write(sarif(items, RULES, versions(())["mbcheck"]))
        if markdown_file:
            markdown_file.write(markdown_sections(title, report))
        append_step_summary(markdown_sections(title, report))
        if not to_stdout(*documents):
            print_sections(console(), report)
        return result.exit_code


def verdict(result: ModelComparison) -> str:
    """Return one line: alike, or how many elements differ."""
    if not result.exit_code:
        return "alike"
    open_ones = [one for one in result.differences if one.id not in result.waived]
    if not open_ones:
        return "read alike, and different at states"
    elements = {one.element for one in open_ones}
    return f"{plural(len(open_ones), 'difference')} in {plural(len(elements), 'element')}"


def sections(result: ModelComparison) -> Iterator[Section]:
    """Yield the parts of the report: what differs, what that does, and what explains it."""
    from ..reports.sections import Section
    from ..reports.words import number
    from .gaps import distinct

    yield Section(lines=[f"A: {result.a} ({result.versions['a']})",
                         f"B: {result.b} ({result.versions['b']})"])  # fmt: skip
    if result.conventions:
        yield Section("Conventions of the engine, accounted for", lines=result.conventions)
    if result.renamed:
        yield Section("Renamed or reordered, compared all the same", lines=result.renamed)
    if result.differences:
        seen = [f" (seen: {one.seen})" if one.seen else "" for one in result.differences]
        rows = [
            [
                one.sentence + waived_words(result, one),
                "-" if one.effect is None else number(one.effect, 2) + also,
            ]
            for one, also in zip(result.differences, seen, strict=True)
        ]
        heads = ("difference", "effect on accelerations")
        yield Section("Read differently", heads, rows)
    if result.gaps:
        title = "What they do at the same state, where they differ most"
        places = [(g.quantity, g.element, *distinct([g.a], [g.b], 4), g.state) for g in result.gaps]
        yield Section(title, ("quantity", "element", "A", "B", "state"), places)
    yield Section(lines=list(conclusion(result)))


def waived_words(result: ModelComparison, one: Difference | Gap) -> str:
    """Return the reason for which a finding is waived, in words."""
    return f" (waived: {result.waived[one.id]})" if one.id in result.waived else ""


def conclusion(result: ModelComparison) -> Iterator[str]:
    """Yield what explains the gap, what was not compared, and the verdict."""
    if result.why_no_states:
        yield f"Not compared at states: {result.why_no_states}."
    elif result.closed:
        single = len(result.differences) == 1
        edits = "This edit of A closes" if single else "These edits of A together close"
        yield f"{edits} the gap: both then agree to rounding at all states."
    elif result.closed is False:
        yield "Edits of A by these differences leave open:"
        yield from (f"  {gap.sentence}{waived_words(result, gap)}" for gap in result.left)
    elif result.differences:
        yield f"At the {len(result.states)} states that were tried, both move alike."
    for one in result.idle_defaults:
        yield f"A default that changed between the releases, without effect here: {one}."
    if result.rounded:
        yield f"The six digits of a text explain {plural(result.rounded, 'further difference')}."
    if result.not_compared:
        yield f"Fields of one release alone, not compared: {', '.join(result.not_compared)}."
    yield from (*result.unused_waivers, *result.idle_waivers)
    yield verdict(result).capitalize() + "."

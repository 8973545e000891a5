"""The pages of the papers: their links, and that the committed ones are what a run writes."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace
from html import unescape
from xml.etree import ElementTree

import pytest

from mbcheck.comparisons.papers import pages
from mbcheck.comparisons.papers.claims import PaperData, read_paper, scenes_with_ledger
from mbcheck.comparisons.papers.formulas import typeset
from mbcheck.reference import get_scene
from mbcheck.tests.support.papers.shared import expected_findings


@pytest.mark.parametrize("scene", scenes_with_ledger())
def test_links_lead_to_one_heading_each(scene: str) -> None:
    text = pages.scene_page(expected_findings(scene), scene)
    anchors = Counter(map(pages.anchor, re.findall(r"^#+ (.*)$", text, re.MULTILINE)))
    wanted = set(re.findall(r"\]\(#([^)]*)\)", text))
    assert wanted <= set(anchors)
    assert {name for name in wanted if anchors[name] > 1} == set()
    shown = pages.html(text)
    assert set(re.findall(r'href="#([^"]*)"', shown)) == wanted
    assert wanted <= set(re.findall(r'id="([^"]*)"', shown))


PLACES = r"(?i)\b(figure|section|case|table|row|conclusion)s? ?[\d.]+(, [\d.]+)*( (and|to) \d+)?"
"""Numbers in a verdict that are none of results."""


@pytest.mark.parametrize("scene", scenes_with_ledger())
def test_numbers_of_the_verdict_are_those_of_rows(scene: str) -> None:
    """Computed ones are filled in from templates of rows; others stand in the paper."""
    text, rows = read_paper(scene).verdict, read_paper(scene).rows
    assert len(re.sub(r"\{.*?\}|\[\[.*?\]\]", "x", text).split()) <= 150
    templates = {row.name: row.reason + row.reference for row in rows}
    assert set(pages.LINK.findall(text)) <= templates.keys()
    for name, number in re.findall(r"\{(\w+)\.(\w+)", text):
        assert re.search(rf"\{{{number}\b", templates[name]) or number == "printed", (name, number)
    words = re.sub(PLACES, "", re.sub(r"\{.*?\}|\[\[.*?\]\]", "", text))
    there = [f"{row.section} {row.claim} {row.printed} {row.reason} {row.erratum}" for row in rows]
    numbers, known = (re.findall(r"\d[\d.]*(?<!\.)", one) for one in (words, " ".join(there)))
    assert set(numbers) <= set(known)


def test_verdict_shows_numbers_and_links_and_nothing_if_a_row_is_missing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rows = [
        replace(row, numbers={"reference": {"value": 0.0909}})
        for row in expected_findings("hula_hoop").rows
        if row.name == "mass_ratio"
    ]
    paper = PaperData(verdict="It is {mass_ratio.value:.2f}, [[mass_ratio]].")
    monkeypatch.setattr(pages, "read_paper", lambda scene: paper)
    assert pages.verdict("hula_hoop", rows) == "It is 0.09, [`mass_ratio`](#mass_ratio)."
    assert pages.verdict("hula_hoop", []) == ""


def test_counts_of_the_errata_are_those_of_places() -> None:
    found = expected_findings("hula_hoop")
    errata = [row.erratum for row in found.rows if row.erratum]
    numbers = re.findall(r"\| of .* \| (\d+) \| (\d+) \|", pages.scene_page(found, "hula_hoop"))
    assert sum(int(one) for one, _ in numbers) == sum(len(one.equations) for one in errata)
    assert sum(int(one) for _, one in numbers) == sum(
        len(one.equations) for one in errata if one.copy
    )


FORMS = {
    text
    for scene in scenes_with_ledger()
    for row in read_paper(scene).rows
    if row.erratum
    for text in (row.printed, row.erratum.corrected)
}


def test_formulas_of_errata_are_typeset() -> None:
    typed = [one for one in map(typeset, FORMS) if one]
    assert len(typed) >= 10
    for one in typed:
        assert "qq" not in one.latex + one.mathml
        ElementTree.fromstring(unescape(one.mathml).replace("&", "&amp;"))


def test_terms_of_a_formula_keep_their_order_and_words_stay() -> None:
    one = typeset("q~'' + p_1 theta~' = -eps/2 + J_1(u_1)")
    assert one is not None
    assert one.latex == (
        r"\tilde{q}'' + p_{1} \tilde{\theta}' = \frac{- \epsilon}{2} + J_{1}{\left(u_{1} \right)}"
    )
    assert "<mover><mi>\u03b8</mi><mo>~</mo></mover>" in one.mathml
    assert typeset("a lost prime") is None
    page = pages.html(f"# A page\n\n{pages.formula('x_1 = 2')}, {pages.formula('none of it')}\n")
    assert "<msub><mi>x</mi><mi>1</mi></msub><mo>=</mo><mn>2</mn>" in page
    assert "none of it" in page


@pytest.mark.parametrize("scene", scenes_with_ledger())
def test_every_parameter_has_a_provenance(scene: str) -> None:
    page = pages.scene_page(expected_findings(scene), scene)
    for name in vars(get_scene(scene).parameters()):
        (line,) = re.findall(rf"^.*\| `{name}` \|$", page, re.MULTILINE)
        source = line.split("|")[3].strip().split(":")[0]
        assert source in ("printed", "chosen", "calibrated", "derived")

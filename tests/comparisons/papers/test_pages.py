"""The pages of the papers: their links, and that the committed ones are what a run writes."""

from __future__ import annotations

import re
from collections import Counter

import pytest

from mbcheck.comparisons.papers import chapters, pages
from mbcheck.comparisons.papers.assess import Assessment
from mbcheck.comparisons.papers.outcomes import (
    FigureOutcome,
    Reproduction,
    RowOutcome,
    scenes_with_ledger,
    tables,
)
from mbcheck.reference import get_scene


def expected(scene: str) -> Reproduction:
    """Return all of a paper, with the verdicts that its rows expect."""
    figures, rows = tables(scene)
    return Reproduction(
        {scene: tuple(FigureOutcome(figure) for figure in figures)},
        {scene: tuple(RowOutcome(row, Assessment(row.verdict, "why")) for row in rows)},
        full=False,
        versions={},
    )


@pytest.mark.parametrize("scene", scenes_with_ledger())
def test_links_lead_to_one_heading_each(scene: str) -> None:
    text = pages.scene_page(expected(scene), scene)
    anchors = Counter(map(pages.anchor, re.findall(r"^#+ (.*)$", text, re.MULTILINE)))
    wanted = set(re.findall(r"\]\(#([^)]*)\)", text))
    assert wanted <= set(anchors)
    assert {name for name in wanted if anchors[name] > 1} == set()
    shown = pages.html(text)
    assert set(re.findall(r'href="#([^"]*)"', shown)) == wanted
    assert wanted <= set(re.findall(r'id="([^"]*)"', shown))


@pytest.mark.parametrize("scene", scenes_with_ledger())
def test_verdict_is_five_sentences_made_of_the_rows(scene: str) -> None:
    sentences = list(chapters.verdict(scene, expected(scene).rows[scene]))
    assert len(sentences) == 5
    none = list(chapters.verdict(scene, ()))
    assert len(none) == 5
    assert set(none) & set(sentences) <= {"No row fails."}


@pytest.mark.parametrize("scene", scenes_with_ledger())
def test_every_parameter_has_a_provenance(scene: str) -> None:
    table = chapters.parameters(scene)
    for name in vars(get_scene(scene).parameters()):
        (line,) = re.findall(rf"^.*\| `{name}` \|$", table, re.MULTILINE)
        assert line.split("|")[3].strip() in ("printed", *chapters.PROVENANCE)


def test_figures_of_a_row() -> None:
    assert chapters.figures_of("5.1, figures 2(a), 3(a)") == [2, 3]
    assert chapters.figures_of("figures 2-5") == [2, 3, 4, 5]
    assert chapters.figures_of("caption of figure 4") == [4]
    assert chapters.figures_of("figure 4, 5.2") == [4]
    assert chapters.figures_of("equation (4), section 5") == []


def test_conclusions_are_told_from_figures() -> None:
    scene = "hula_hoop"  # its conclusions are section 6
    own = ("abstract, 1", "6", "abstract, 6", "1, 6")
    assert all(chapters.is_conclusion(scene, section) for section in own)
    others = ("5.2, figures 4, 6", "figure 6", "equation (6)", "5.2")
    assert not any(chapters.is_conclusion(scene, section) for section in others)
    assert chapters.is_conclusion("rotating_beam", "conclusion 2")

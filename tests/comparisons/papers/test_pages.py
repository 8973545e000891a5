"""The pages of the papers: their links, and that the committed ones are what a run writes."""

from __future__ import annotations

import re
from collections import Counter

import pytest

from mbcheck.comparisons.papers import pages
from mbcheck.comparisons.papers.outcomes import scenes_with_ledger
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


@pytest.mark.parametrize("scene", scenes_with_ledger())
def test_verdict_is_five_sentences_made_of_the_rows(scene: str) -> None:
    sentences = list(pages.verdict(scene, expected_findings(scene).rows))
    assert len(sentences) == 5
    none = list(pages.verdict(scene, ()))
    assert len(none) == 5
    assert set(none) & set(sentences) <= {"No row fails."}


@pytest.mark.parametrize("scene", scenes_with_ledger())
def test_every_parameter_has_a_provenance(scene: str) -> None:
    table = pages.parameters(scene)
    for name in vars(get_scene(scene).parameters()):
        (line,) = re.findall(rf"^.*\| `{name}` \|$", table, re.MULTILINE)
        assert line.split("|")[3].strip() in ("printed", *pages.PROVENANCE)


def test_figures_of_a_row() -> None:
    assert pages.figures_of("5.1, figures 2(a), 3(a)") == [2, 3]
    assert pages.figures_of("figures 2-5") == [2, 3, 4, 5]
    assert pages.figures_of("caption of figure 4") == [4]
    assert pages.figures_of("figure 4, 5.2") == [4]
    assert pages.figures_of("equation (4), section 5") == []


def test_conclusions_are_told_from_figures() -> None:
    scene = "hula_hoop"  # its conclusions are section 6
    own = ("abstract, 1", "6", "abstract, 6", "1, 6")
    assert all(pages.is_conclusion(scene, section) for section in own)
    others = ("5.2, figures 4, 6", "figure 6", "equation (6)", "5.2")
    assert not any(pages.is_conclusion(scene, section) for section in others)
    assert pages.is_conclusion("rotating_beam", "conclusion 2")

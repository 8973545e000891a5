"""The pages of the papers in `docs/papers`: what `mbcheck reproduce` found there, and finds now."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from mbcheck.comparisons.papers import ledger, pages
from mbcheck.comparisons.papers.assess import Assessment, assess
from mbcheck.comparisons.papers.claims import read_paper, scenes_with_ledger
from mbcheck.comparisons.papers.ledger import NOT_REPRODUCED, LedgerRow, half_unit
from mbcheck.comparisons.papers.outcomes import Findings, RowEntry
from mbcheck.comparisons.papers.reproduce import FINDINGS, contents
from mbcheck.comparisons.papers.session import Session
from mbcheck.tests.support.words import POINTS, agree, agree_by_chance

ROWS = [(scene, row) for scene in scenes_with_ledger() for row in read_paper(scene).rows]
MOST_BYTES = 3e6
WIDE = 1600
"""Points across a picture."""


@pytest.fixture(scope="module")
def folder(clone: Path) -> Path:
    return clone / "docs" / "papers"


@pytest.fixture(scope="module")
def found(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Findings:
    """Return what is committed, read in another folder."""
    copy = tmp_path_factory.mktemp("papers")
    shutil.copy(folder / FINDINGS, copy)
    return contents(copy)


def test_all_rows_and_figures_are_there(found: Findings, folder: Path) -> None:
    """One that is new comes with ``mbcheck reproduce SCENE --row NAME --out docs/papers``."""
    assert [(item.scene, item.name) for item in found.rows] == [
        (scene, row.name) for scene, row in ROWS
    ]
    assert found.failures == []
    for scene in scenes_with_ledger():
        numbers = [item.number for item in found.figures_of(scene)]
        assert numbers == [figure.number for figure in read_paper(scene).figures]
        assert all((folder / "figures" / f"{scene}_{n}.png").exists() for n in numbers)


def test_pages_show_what_was_found(found: Findings, folder: Path, tmp_path: Path) -> None:
    pages.write_pages(found, tmp_path)
    for name in ("index", *scenes_with_ledger()):
        for suffix in ("md", "html"):
            path = f"{name}.{suffix}"
            assert (folder / path).read_text("utf-8") == (tmp_path / path).read_text("utf-8"), path


def test_verdicts_are_the_expected_ones(found: Findings) -> None:
    for item, (_, row) in zip(found.rows, ROWS, strict=True):
        assert item.verdict == row.verdict, item.name


def test_links_and_pictures_are_there_and_small(folder: Path) -> None:
    from PIL import Image

    for path in folder.glob("*.md"):
        for target in re.findall(r"\]\(([^)#:]+)\)", path.read_text("utf-8")):
            assert (folder / target).exists(), f"{path.name} links to {target}"
    for path in folder.glob("figures/*.png"):
        with Image.open(path) as picture:
            assert picture.width >= WIDE
    kept = [*folder.glob("*.md"), *folder.glob("*.html"), *folder.glob("*.json")]
    size = sum(path.stat().st_size for path in (*kept, *folder.glob("figures/*.png")))
    assert size < MOST_BYTES


def entry_of(found: Findings, scene: str, name: str) -> RowEntry:
    return next(item for item in found.rows_of(scene) if item.name == name)


def texts(assessment: Assessment) -> dict[str, str]:
    """Return what a page says of a row."""
    candidates = "; ".join(f"{way}: {gives}" for way, gives in assessment.candidates)
    own = {"reason": assessment.reason, "reference": assessment.reference}
    return own | {"candidates": candidates}


def expected(row: LedgerRow, session: Session) -> Assessment:
    """Assess a row: its verdict is the expected one, and what it says fits it."""
    assessment = assess(row, session)
    assert assessment.verdict == row.verdict, assessment.reason
    assert bool(assessment.reason) or row.kind == "number"
    assert "\n" not in assessment.reason
    texts = (assessment.reason, assessment.reference, *assessment.engines.values())
    assert not re.search(r"\bnan\b|[{}]", " ".join(texts))
    assert set(assessment.engines) <= set(session.engines)
    if row.kind == "number" and assessment.reason.startswith("off by"):
        ours, printed = float(assessment.reference.split()[0]), row.printed.split()[0]
        near = abs(ours - float(printed)) <= 1.01 * half_unit(printed)
        if assessment.verdict not in (ledger.OPEN, ledger.DEPENDS, ledger.UNCONVERGED):
            assert near == (assessment.verdict != NOT_REPRODUCED)
    return assessment


def cases(slow: bool) -> list[Any]:
    return [
        pytest.param(scene, row.name, id=f"{scene}-{row.name}")
        for scene, row in ROWS
        if not row.is_text and (slow or not row.slow)
    ]


def row_named(scene: str, name: str) -> Any:
    return next(row for own, row in ROWS if (own, row.name) == (scene, name))


FROM_REST = {
    "adequate", "class_definitions", "class_table", "definition", "drawn_solution",
    "easier_with_inertia", "fewer_cyan", "fewer_red", "good_agreement_4_5", "good_agreement_6_7",
    "larger_reversal", "left_of_region_1", "less_accurate", "red_x_is_at_rest", "red_zone",
    "region_1", "region_2", "region_3", "region_3_in_7", "region_3_shrinks",
    "rotation_from_shaking", "stable_appears", "start", "transient_hoop", "transition",
    "unstable_not_seen",
}  # fmt: skip
"""Rows that count the points of figures 5 and 7, in which a part of the motions is chaotic."""

ALL_POINTS, FEW = 961, 10
"""Points of these figures, and how many are no sample that shares are taken of."""


@pytest.mark.parametrize(
    ("other", "same"),
    [
        ("blue o 191, cyan o 17, 39% of 290 points, of (55)", True),
        ("blue o 250, cyan o 18, 38% of 290 points, of (55)", False),
        ("blue o 190, cyan o 28, 38% of 290 points, of (55)", False),
        ("blue o 190, cyan o 18, 45% of 290 points, of (55)", False),
        ("blue o 190, cyan x 18, 38% of 290 points, of (55)", False),
    ],
)
def test_counts_of_chaotic_motions_agree_as_chance_allows(other: str, same: bool) -> None:
    text = "blue o 190, cyan o 18, 38% of 290 points, of (55)"
    assert agree_by_chance(text, other, 290) == same


def is_published(found: Findings, scene: str, name: str, session: Session) -> None:
    """Assess a row: the verdict and the words are those of the page."""
    published = entry_of(found, scene, name)
    now = expected(row_named(scene, name), session)
    assert now.verdict == published.verdict
    points = next((n for n in map(int, POINTS.findall(now.reason)) if n > FEW), ALL_POINTS)
    for part, text in texts(published).items():
        if name in FROM_REST:
            assert agree_by_chance(text, texts(now)[part], points), part
        else:
            assert agree(text, texts(now)[part]), part


@pytest.mark.parametrize(("scene", "name"), cases(slow=False))
def test_quick_row_is_what_a_run_gives(
    scene: str, name: str, found: Findings, session: Session
) -> None:
    is_published(found, scene, name, session)


@pytest.mark.slow
@pytest.mark.parametrize(("scene", "name"), cases(slow=True))
def test_row_is_what_a_run_gives(
    scene: str, name: str, found: Findings, with_fewer: Callable[[str], Session]
) -> None:
    is_published(found, scene, name, with_fewer(scene))

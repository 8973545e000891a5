"""Equations of the papers: right ones hold at random points, printed and perturbed ones do not."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest

from mbcheck.comparisons.papers.claims import read_paper, scenes_with_ledger
from mbcheck.comparisons.papers.equations import Identities, sides

EXACT = 1e-14
"""Largest error of an equation that a scene's double precision leaves; by SymPy alone 1e-25."""

TRUNCATED = {"expansion_30": 1e-3}
"""Equations that are series, which are printed with dots at their ends."""


def identities_of(scene: str) -> Mapping[str, Identities]:
    return {row.name: row.equations for row in read_paper(scene).rows if row.equations}


TABLE: dict[tuple[str, str], Identities] = {
    (scene, name): identities
    for scene in scenes_with_ledger()
    for name, identities in identities_of(scene).items()
}


def everywhere(identities: Identities) -> list[Any]:
    """Return random points, parameters and motions included."""
    return identities.points({}, seed=2)


@pytest.mark.parametrize(("scene", "name"), TABLE)
def test_corrected_form_holds_and_a_perturbed_one_does_not(scene: str, name: str) -> None:
    """Each term of each equation is changed by a millionth of itself."""
    identities = TABLE[scene, name]
    points = everywhere(identities)
    for one in identities.equations:
        right = identities.error(one.corrected, one.derived, points)
        assert right < TRUNCATED.get(name, EXACT)
        terms = one.corrected.expand().as_ordered_terms()
        for term in terms if name not in TRUNCATED else ():
            wrong = identities.error(one.corrected + term / 10**6, one.derived, points)
            assert wrong > 1e3 * EXACT or not term.free_symbols, term


PRINTED = [
    pytest.param(identities, one, id=f"{scene}-{name}")
    for (scene, name), identities in TABLE.items()
    for one in identities.equations
    if one.printed is not None
]


@pytest.mark.parametrize(("identities", "equation"), PRINTED)
def test_printed_form_of_a_misprint_does_not_hold(identities: Identities, equation: Any) -> None:
    for points in (everywhere(identities), identities.points(identities.values)):
        assert identities.error(equation.printed, equation.derived, points) > 1e-3


def test_a_derived_side_is_no_copy_of_the_right_one() -> None:
    for key, identities in TABLE.items():
        for left, right in sides(identities.text):
            assert left.rpartition(": ")[2] != right, key

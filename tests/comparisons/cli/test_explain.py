"""``mbcheck explain`` explains every word that a report of checks may have."""

from __future__ import annotations

from typing import get_args

import pytest

from mbcheck.comparisons.boundary.document import Kind
from mbcheck.comparisons.checks.rules.cautions import RULES as CAUTIONS
from mbcheck.comparisons.checks.suite import plan
from mbcheck.comparisons.checks.table import EVERY_KIND, KINDS
from mbcheck.comparisons.checks.verdict import PROFILES, Verdict
from mbcheck.comparisons.cli.explain import explanations, glossary
from mbcheck.comparisons.inspect.rules.table import RULES as FINDINGS
from mbcheck.comparisons.papers.ledger import VERDICTS
from mbcheck.tests.support.command import invoke, succeeds


def test_every_kind_and_verdict_has_an_entry() -> None:
    kinds = glossary()["kind of check"]
    assert {*kinds} == {*EVERY_KIND}
    assert [kind for kind in kinds if kind in KINDS] == list(KINDS)
    assert {*glossary()["verdict"]} == {*get_args(Verdict)}


def test_the_glossary_has_forty_entries_at_most() -> None:
    assert sum(map(len, glossary().values())) <= 40


def test_every_quantity_of_a_check_is_explained() -> None:
    pytest.importorskip("mujoco")
    quantities = {name.rpartition("/")[2] for check in plan(full=True) for name in check.ids}
    assert not {name for name in quantities if not explanations(name)}


@pytest.mark.parametrize(
    ("term", "words"),
    [
        ("trajectory", "Does a run agree with the reference?"),
        ("Located", "start there"),
        ("damper.theta", "damper.theta (quantity of the check parts)"),
        ("energy_drift", "*_drift (quantity)"),
        ("theta_dot", "hula_hoop [rad/s]"),
        ("step_limit", FINDINGS["step_limit"].why),
        ("dead_centre", CAUTIONS["dead_centre"].meaning),
    ],
)
def test_a_term_is_explained(term: str, words: str) -> None:
    assert words in " ".join(succeeds("explain", term).split())


def test_all_rules_are_listed() -> None:
    listed = succeeds("explain").replace(",", " ").split()
    assert {*CAUTIONS, *FINDINGS} <= {*listed}


def test_an_unknown_term_is_refused_with_the_nearest() -> None:
    ended = invoke("explain", "step_limt")
    assert ended.exit_code == 2
    assert ended.stderr == "Error: unknown term 'step_limt'; did you mean 'step_limit'?\n"


def test_a_word_like_no_term_gets_no_suggestion() -> None:
    ended = invoke("explain", "viscosity")
    assert ended.stderr == "Error: unknown term 'viscosity'; mbcheck explain lists all terms\n"


@pytest.mark.parametrize(
    "words", [*VERDICTS, *get_args(Kind), "row", "erratum", "symmetry breaking", "Neimark-Sacker"]
)
def test_words_of_papers_and_curves_are_explained(words: str) -> None:
    assert explanations(words.lower())


def test_factors_of_profiles_are_those_of_the_code() -> None:
    for name, factor in PROFILES.items():
        assert f"`{name}` {factor:g}" in glossary()["term"]["profile"]

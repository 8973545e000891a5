"""``mbcheck explain`` explains every word that a report of checks may have."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import get_args

import pytest

from mbcheck.comparisons.boundary.document import Kind
from mbcheck.comparisons.checks.rules.cautions import RULES as CAUTIONS
from mbcheck.comparisons.checks.suite import plan
from mbcheck.comparisons.checks.table import EVERY_KIND, KINDS
from mbcheck.comparisons.checks.verdict import PROFILES, Verdict
from mbcheck.comparisons.cli.explain import by_sort, explanations, glossary
from mbcheck.comparisons.compare.gaps import QUANTITIES
from mbcheck.comparisons.diff.changes import SORTS
from mbcheck.comparisons.inspect.batch import Sandbox
from mbcheck.comparisons.inspect.rules.table import RULES as FINDINGS
from mbcheck.comparisons.inspect.views import Kind as ModeKind
from mbcheck.comparisons.papers.ledger import VERDICTS
from mbcheck.comparisons.reports import sections, text
from mbcheck.comparisons.reports.item import Level
from mbcheck.comparisons.reports.run.located import HEADS
from mbcheck.comparisons.reports.run.sections import REASON_HEADS, RESULT_HEADS
from mbcheck.comparisons.tradeoff import pages, table
from mbcheck.comparisons.tradeoff.report import Tradeoff
from mbcheck.tests.support.command import SMALL, invoke, succeeds


def test_every_kind_and_verdict_has_an_entry() -> None:
    kinds = glossary()["kind of check"]
    assert {*kinds} == {*EVERY_KIND}
    assert [kind for kind in kinds if kind in KINDS] == list(KINDS)
    assert {*glossary()["verdict"]} == {*get_args(Verdict)}


def test_the_glossary_has_forty_entries_at_most() -> None:
    sorts = glossary()
    assert sum(len(sorts[sort]) for sort in sorts if sort != "names") <= 40


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
        ("energy_drift", "energy_drift (quantity of the check energy)"),
        ("unexplained", "relative to all forces"),
        ("coriolis", "0 dropped"),
        ("extrapolated", "The columns have this distance and 0"),
        ("turned:7", "rotated as a whole in space"),
        ("theta_dot", "hula_hoop [rad/s]"),
        ("step_limit", FINDINGS["step_limit"].why),
        ("dead_centre", CAUTIONS["dead_centre"].meaning),
        ("tree", "without loops"),
        ("forced", "function of time"),
        ("bound", "in the same row"),
        ("synphase", "within 90 degrees of 0"),
        ("chordwise", "in the plane of its rotation"),
        ("none met", "still reduced the error"),
        ("T/40", "40 steps per period"),
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
        assert f"`{name}` {factor:g}" in by_sort()["term"]["profile"]


def test_quantities_of_parts_differ_in_their_explanations() -> None:
    names = ("mass.rod", "damper.theta", "coriolis", "gravity", "closure.pin", "unexplained")
    assert len({text.partition(": ")[2] for name in names for text in explanations(name)}) == 6


LOOP = """<mujoco><worldbody>
  <body name="a"><joint name="p" axis="0 1 0"/><geom size="0.1" pos="0 0 -1" contype="0"/></body>
  <body name="b" pos="1 0 0"><joint name="q" axis="0 1 0"/>
    <geom size="0.1" pos="0 0 -1" contype="0"/></body>
  </worldbody><equality><connect body1="a" body2="b" anchor="0 0 -1"/></equality></mujoco>"""
"""Two pendulums that a loop joins: every table of `inspect` has rows."""

NAMES = {"force_frequency", "force_amplitude"}
"""Parameters, which `mbcheck list SCENE` explains."""


def words_of(heads: Iterable[str]) -> set[str]:
    """Return the words of heads of tables, but for units, numbers, files and parameters."""
    words = {re.sub(r" *(\[.*\]|\(.*\))", "", part) for head in heads for part in head.split(", ")}
    return {word for word in words if word and not word.isdigit() and word not in NAMES}


@pytest.mark.parametrize(
    "line",
    [
        "list",
        "list hula_hoop",
        "orbit hula_hoop",
        "frequencies rotor_pendulum",
        "inspect {a} --full",
        "judge {run} --case hula_hoop/rod_aligned --tolerance 1e-3",
        pytest.param(SMALL, marks=pytest.mark.slow),
    ],
)
def test_every_head_of_a_table_is_explained(
    line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("mujoco")
    heads, files = list[str](), {name: tmp_path / f"{name}.xml" for name in ("a", "run")}
    files["a"].write_text(LOOP)
    if "{run}" in line:
        succeeds(f"simulate hula_hoop --times 0:0.1:0.01 --csv {files['run']}")
    for module in (text, sections):
        monkeypatch.setattr(module, "print_rows", lambda _, row, *more: heads.extend(row))
    monkeypatch.setattr(Sandbox, "run", lambda _, work, alone: work())
    invoke(line.format(**files))
    assert heads
    assert not {word for word in words_of(heads) if not explanations(word)}


def test_every_word_of_tradeoff_check_compare_and_diff_is_explained() -> None:
    heads = [*pages.CHOICE, *pages.LIMIT, *pages.RUNS, *pages.LEFT_OUT, *HEADS, *RESULT_HEADS]
    heads += [*REASON_HEADS, *pages.stability_table([])[0]]
    heads += pages.steps_table(Tradeoff((0.01, 1e-4), (), ()))[0]
    heads += ["difference", "effect on accelerations", "element, A, B", "state"]  # of compare
    words = words_of(heads) | {*get_args(Level), *get_args(ModeKind), *SORTS.values()}
    words |= {table.STEP, table.MODEL, table.ROUND_OFF, table.FAILED, table.percent(None)}
    words |= {name for name, _ in QUANTITIES.values()}
    assert not {word for word in words if not explanations(word)}


def test_a_term_that_shares_a_row_is_explained_alone() -> None:
    assert "sub-steps" not in succeeds("explain scheme_residual")
    assert "pair" not in succeeds("explain fold")
    assert all(explanations(word) for word in ("discrete", "keyframe", "horizon", "seed"))

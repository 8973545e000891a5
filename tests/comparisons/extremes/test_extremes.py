"""Checks at extremes: what is planned, what comes of them, and how the verb shows it."""

from __future__ import annotations

import json
import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from mbcheck.comparisons.check.request import select
from mbcheck.comparisons.checks.request import CheckRequest
from mbcheck.comparisons.checks.suite import Check
from mbcheck.comparisons.checks.table import EXTREMES
from mbcheck.comparisons.checks.verdict import REFERENCE, Result
from mbcheck.comparisons.cli.group import program
from mbcheck.comparisons.extremes import page
from mbcheck.comparisons.scenes.data import scene_data
from mbcheck.comparisons.scenes.extremes import PLANS, EngineFailure, extreme_checks
from mbcheck.reference import SCENES
from mbcheck.tests.support import results
from mbcheck.tests.support.documents import validated

ENGINES = ("mujoco", "exudyn")

HIDDEN = {
    "default_closure", "impedance_clamped", "cg_at_1e-8", "transmission_carries_no_mass",
    "no_second_order_coupling",
}  # fmt: skip
"""Failures that only the reference notices; no parameter and no start is such a one."""

QUICK = (
    "hula_hoop/stiffness_1e+12/parameters/mujoco/RK4",
    "hula_hoop/stiffness_1e+09/parameters/exudyn/RK67",
    "speed_regulator/massless_rod_and_slider/parameters/exudyn/RK67@one_dof",
    "hula_hoop/rod_aligned_at_rest/starts/exudyn/RK67",
    "rotor_pendulum/at_rest/starts/mujoco/RK4",
    "speed_regulator/open_by_0.001_m/starts/exudyn/redundant",
    "hula_hoop/force_through_ctrl_at_step_start/failures/mujoco/RK4",
    "hula_hoop/no_inertia/failures/mujoco/RK4",
    "hula_hoop/inertia_floor/failures/mujoco/RK4",
    "hula_hoop/dverk6/failures/exudyn/DVERK6",
    "hula_hoop/halved_steps/failures/exudyn/GeneralizedAlpha",
    "speed_regulator/through_the_dead_centre/failures/exudyn/GeneralizedAlpha",
    "speed_regulator/closure_softened_refused/failures/mujoco/RK4",
    "speed_regulator/default_closure/failures/mujoco/RK4",
)
"""Checks of the default run, by the prefix of their ids."""


def checks(scene: str, kind: str, engine: str) -> list[Check]:
    """Return the checks of one kind of the default set."""
    return list(PLANS[kind](kind, scene, engine))


def check_named(name: str) -> Check:
    """Return the check of a prefix."""
    scene, _, kind, engine, _ = name.split("/")
    return next(one for one in checks(scene, kind, engine) if one.prefix == f"verification/{name}")


def failing(name: str) -> EngineFailure:
    """Return the failure of a name."""
    every = (
        scene_data(scene, "extremes", "FAILURES", tuple[EngineFailure, ...]()) for scene in SCENES
    )
    return next(one for several in every for one in several if one.name == name)


def test_every_kind_is_planned_of_both_engines_once() -> None:
    found = extreme_checks(SCENES, ENGINES, full=True)
    assert len({one.prefix for one in found}) == len(found)
    assert {(one.kind, one.engine) for one in found} >= {(k, e) for k in EXTREMES for e in ENGINES}
    assert {one.case.scene for one in found if one.kind == "limits"} == set(SCENES)
    assert all(pickle.loads(pickle.dumps(one)) for one in found)


@pytest.mark.parametrize("name", QUICK)
def test_what_breaks_is_noticed(name: str) -> None:
    watch(check_named(name))


@pytest.mark.parametrize(
    "share", [pytest.param(11, marks=pytest.mark.slow), pytest.param(1, marks=pytest.mark.campaign)]
)
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("kind", EXTREMES)
@pytest.mark.parametrize("scene", SCENES)
def test_all_that_breaks_is_noticed(scene: str, kind: str, engine: str, share: int) -> None:
    for check in checks(scene, kind, engine)[::share]:
        if not check.full_only:
            watch(check)


def watch(check: Check) -> None:
    """Run a check: what is wrong is noticed by more than the reference, but for `HIDDEN`."""
    found = check.run("default")
    outcomes = {page.outcome(one) for one in found}
    assert outcomes <= set(page.OUTCOMES)
    broken = [one for one in found if one.verdict not in ("pass", "skipped")]
    hidden = any(map(page.is_hidden, found))
    assert hidden == (check.case.name in HIDDEN)
    if check.kind == "failures":
        assert (outcomes == {page.RIGHT}) == failing(check.case.name).harmless
    if check.kind == "limits":
        assert all("none by theory" in one.reason for one in broken)
    if check.kind == "long":
        lost = {one.quantity for one in broken}
        assert all(quantity.endswith("_lost") for quantity in lost), found


def test_extremes_are_chosen_by_option_kind_or_id() -> None:
    every = select(CheckRequest(("hula_hoop",), ("mujoco",), extremes=True))
    assert {one.kind for one in every if isinstance(one, Check)} == set(EXTREMES)
    limits = select(CheckRequest(("hula_hoop",), ("mujoco",), kinds=("limits",)))
    assert {one.kind for one in limits if isinstance(one, Check)} == {"limits"}
    (prefix,) = {one.prefix for one in limits if one.prefix.endswith("RK4")}
    (one,) = select(CheckRequest(ids=(f"{prefix}/*",)))
    assert one.prefix == prefix
    usual = select(CheckRequest(("hula_hoop",), ("mujoco",)))
    assert not any(isinstance(one, Check) and one.extreme for one in usual)


def result(**changes: Any) -> Result:
    usual = {"verdict": "deviation", "noticed_by": (REFERENCE,), "reason": "y=0.1: error 1"}
    return replace(results.result(kind="starts"), **usual | changes)


def test_the_page_shows_what_breaks_and_what_only_the_reference_notices() -> None:
    seen = result(noticed_by=("rule:step_limit", REFERENCE))
    refused = result(verdict="skipped", noticed_by=("engine",))
    text = page.markdown([result(), seen, refused], False)
    hidden = text.partition("## Only the reference notices")[2].partition("##")[0]
    assert hidden.count(result().id) == 1
    table = text.partition("## mujoco: what breaks")[2]
    assert "| wrong | rule:step_limit, reference |" in table
    assert "| y=0.1 |" in table
    assert [row for row in page.counts([result(), seen, refused]) if row[0] == "starts"] == [
        ("starts", 0, 2, 0, 1, 0)
    ]


def test_places_of_files_stay_out_of_the_page() -> None:
    """Exudyn names the Python file that called it, which is another on every machine."""
    reason = "no solver [Python file '/home/x/engine.py', line 15]\n in sight"
    assert page.one_line(reason) == "no solver in sight"


def test_a_check_that_dies_takes_no_other_along_and_fails_the_run(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    chosen = [check_named("hula_hoop/no_inertia/failures/mujoco/RK4")]
    dying = replace(chosen[0], case=replace(chosen[0].case, name="dies"), quantities=("x",))
    dying = replace(dying, variant=replace(dying.variant, engine="dies"))  # type: ignore[type-var]
    monkeypatch.setattr(
        "mbcheck.comparisons.scenes.extremes.extreme_checks", lambda *_: [*chosen, dying]
    )
    file = tmp_path / "found.json"
    asked = ["extremes", "hula_hoop", "--kind", "failures", "--json", str(file)]
    assert program.exit_code(args=asked) == 0
    document = json.loads(file.read_text())
    validated("check", document)
    assert document["selection"]["extremes"] is True
    verdicts = [one["verdict"] for one in document["results"]]
    assert verdicts == ["skipped", "error"]
    assert "2 results" in capsys.readouterr().out
    assert page.died(result(verdict="error", reason="crashed: SIGSEGV"))
    assert not page.died(result(verdict="error", reason="non_finite: y"))

"""`check --quick`: what it leaves out, in which order checks run, and what is told meanwhile."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from mbcheck.comparisons.check.request import plan_checks, select
from mbcheck.comparisons.checks.execution import run_checks
from mbcheck.comparisons.checks.request import CheckRequest
from mbcheck.comparisons.checks.suite import plan, quick
from mbcheck.comparisons.checks.table import KINDS
from mbcheck.comparisons.terminal import program
from mbcheck.comparisons.terminal.program import PAUSE, progress_lines, time_left
from mbcheck.reference import SCENES, get_scene
from mbcheck.tests.support.command import refusal, succeeds


def test_each_level_is_checked_once_in_each_scene() -> None:
    chosen = plan_checks(CheckRequest(engines=("mujoco",), quick=True)).checks
    every = {check.prefix for check in plan(engines=["mujoco"])}
    assert {check.prefix for check in chosen} <= every
    assert not any("+" in check.prefix for check in chosen)
    for scene in SCENES:
        mine = [check for check in chosen if check.subject.scene == scene]
        kinds = [check.subject.kind for check in mine]
        assert kinds.count("trajectory") == 1
        wanted = {name for name, kind in KINDS.items() if kind.quick}
        assert set(kinds) == wanted - ({"parts"} if scene == "speed_regulator" else set())
    # a loop has several models, each of which has its own steps
    loops = [name for name in SCENES if get_scene(name).assembled]
    models = {
        (check.subject.kind, check.subject.model)
        for check in chosen
        if check.subject.scene in loops
    }
    assert len([one for one in models if one[0] == "step"]) > 1


def test_the_trajectory_is_that_of_the_best_method() -> None:
    (one,) = [
        check for check in quick(plan(["hula_hoop"], ["exudyn"])) if check.kind == "trajectory"
    ]
    assert one.method is not None
    assert one.method.order == max(method.order for method in one.setup().engine.methods)


def test_a_scene_that_is_not_supported_is_listed_with_its_reason() -> None:
    checks = [
        replace(check, unsupported_reason="only hoops" * (check.case.scene != "hula_hoop") or None)
        for check in plan(["hula_hoop", "rotor_pendulum"], ["mujoco"])
    ]
    refused = [check for check in quick(checks) if check.unsupported_reason]
    assert [check.case.scene for check in refused] == ["rotor_pendulum"]


def test_it_is_told_of() -> None:
    document = json.loads(
        succeeds("check hula_hoop --engine mujoco --quick --kind algebra --json -")
    )
    assert document["selection"]["quick"] is True
    assert document["checks"]["planned"] == 1


@pytest.mark.parametrize(
    ("id", "count"),
    [
        ("*@forced/*", 1),  # of a quick answer, beside another model's
        ("*/spinning_3hz_60n/order/mujoco/RK4/*", 1),  # of none
        ("verification/hula_hoop/*", 5),
    ],
)
def test_what_an_id_names_is_run(id: str, count: int) -> None:
    request = CheckRequest(("hula_hoop",), ("mujoco",), ids=(id,), quick=True)
    chosen = {check.prefix for check in select(request)}
    assert len(chosen) == count
    every = {check.prefix for check in select(replace(request, ids=()))}
    assert (chosen <= every) == ("order" not in id)


def test_what_leaves_nothing_is_named() -> None:
    line = "check --quick hula_hoop --engine mujoco"
    assert "none is left by --quick" in refusal(f"{line} --kind order")
    said = refusal(f"{line} --id */point_mass_3hz_60n/stepp/*")
    assert "none is left by --id */point_mass_3hz_60n/stepp/*; nearest ids: verif" in said
    assert "/point_mass_3hz_60n/step/" in said
    assert "none is left by a run without --full" in refusal(f"{line} --id */heavy_free_mass/*")


@pytest.mark.parametrize("other", ["--full", "--source validation"])
def test_what_contradicts_it_is_refused(other: str) -> None:
    assert "--quick" in refusal(f"check --quick {other}")


def test_what_follows_no_motion_comes_first() -> None:
    few = plan(
        ["hula_hoop"],
        ["mujoco"],
        ["algebra", "step"],
        ids=["*/point_mass*", "*/semicircle_3hz_60n/*"],
    )
    few = [check for check in few if check.default_model]
    arrived: list[str] = []
    results = run_checks(few, on_result=lambda items: arrived.append(items[0].kind))
    assert arrived == ["algebra", "algebra", "step", "step"]
    assert [item.kind for item in results] != sorted(item.kind for item in results)  # as planned


def test_progress_is_told_seldom_and_with_an_estimate(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(program, "monotonic", lambda: 100.0)
    with progress_lines("checks", 100.0 - PAUSE) as advance:
        advance(3, 10, share=0.25)
        advance(4, 10, share=0.5)
    (line,) = capfd.readouterr().err.splitlines()
    assert line == "3 of 10 checks, 10 s, about 30 s left"
    with progress_lines("checks", 100.0) as advance:
        advance(3, 10)
    assert not capfd.readouterr().err


def test_nothing_is_estimated_of_nothing() -> None:
    assert time_left(10.0, 0.0) == ""
    assert time_left(600.0, 0.5) == "about 10 min left"

"""Models that nobody here wrote: those of packages, unpacked and never imported."""

from __future__ import annotations

import io
import math
import statistics
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from mbcheck.comparisons.inspect.batch import print_inspection
from mbcheck.comparisons.inspect.inspection import Inspection, inspect
from mbcheck.comparisons.inspect.views import View, step_limit_of
from mbcheck.comparisons.tradeoff.model import ModelTradeoff, setting_of
from mbcheck.comparisons.tradeoff.request import TradeoffRequest
from mbcheck.reference.errors import UsageError
from mbcheck.tests.foreign.packages import unpacked

PACKAGES = ("gymnasium", "playground")

pytestmark = pytest.mark.foreign


@pytest.fixture(scope="module")
def inspected(tmp_path_factory: pytest.TempPathFactory) -> list[Inspection]:
    """Return what is found in all files that compile alone."""
    folder = tmp_path_factory.mktemp("wheels")
    return [one for package in PACKAGES for one in reports(unpacked(package, folder))]


def reports(folder: Path) -> Iterator[Inspection]:
    for path in sorted(folder.rglob("*.xml")):
        if "<mujoco" in path.read_text(errors="replace"):
            try:
                yield inspect(path)
            except UsageError:  # a part of another file, or one whose meshes are elsewhere
                continue


def test_good_models_are_left_in_peace(inspected: list[Inspection]) -> None:
    assert len(inspected) > 30
    assert statistics.median(one.summary["warning"] for one in inspected) <= 1
    assert [one.file for one in inspected if one.exit_code] == []


def test_reports_are_short(inspected: list[Inspection]) -> None:
    lengths = []
    for one in inspected:
        printed = io.StringIO()
        print_inspection(Console(file=printed, width=100), one, full=False)
        lengths.append(len(printed.getvalue().splitlines()))
    assert statistics.median(lengths) < 40


def grows(view: View, integrator: str, step: float, steps: int) -> bool:
    """Return whether a small departure grows where constant forces hold the state."""
    assert view.linear is not None
    loaded = view.linear.loaded
    lib, model = loaded.mujoco, loaded.sharp("warmstart")
    model.opt.timestep = step
    model.opt.integrator = getattr(lib.mjtIntegrator, f"mjINT_{integrator.upper()}")
    data = loaded.data(view.state, model)
    lib.mj_forward(model, data)
    force, moved = np.empty(model.nv), np.empty(model.nv)
    lib.mj_mulM(model, data, force, data.qacc)
    data.qfrc_applied[:] = -force
    draw = np.random.default_rng(0).standard_normal
    lib.mj_integratePos(model, data.qpos, 1e-8 * draw(model.nv), 1.0)
    data.qvel[:] += 1e-8 / step * draw(model.nv)
    for _ in range(steps // 20):
        lib.mj_step(model, data, 20)
        lib.mj_differentiatePos(model, moved, 1.0, view.state.position, data.qpos)
        if not np.all(np.abs(moved) < 3e-3):
            return True
    return False


def test_limits_are_those_of_runs(inspected: list[Inspection]) -> None:
    """No run blows up 2 % below a limit, and 95 % do 2 % above it, where the state is smooth.

    A joint that stands at its limit holds a run that blows up otherwise: no such state is smooth.
    """
    fails = []
    for one in inspected:
        m, view = one.loaded.model, one.views[0]
        rough = one.loaded.of_kind("jnt_type", "free", "ball").any() or m.dof_frictionloss.any()
        rough |= bool(m.na or one.loaded.at_limits(view.state))
        if rough or view.linear is None or view.linear.rows.contacts or view.linear.rows.limits:
            continue
        if "unstable" in {mode.kind for mode in view.modes}:
            continue
        for integrator in ("Euler", "implicitfast", "RK4"):
            limit = step_limit_of(one.loaded, integrator, [view]).limit
            if 0 < limit < math.inf:
                assert not grows(view, integrator, 0.98 * limit, 2000), one.file
                fails.append(grows(view, integrator, 1.02 * limit, 8000))
    assert len(fails) > 15
    assert statistics.mean(fails) >= 0.95


SEEDS = (1, 9)


def test_what_is_recommended_meets_its_target_again(inspected: list[Inspection]) -> None:
    """With other controls; of models in which something moves, the smallest first."""
    moving = sorted(
        (one for one in inspected if 0 < one.model.nv <= 12), key=lambda one: one.model.nv
    )
    answers = []
    for one in moving[:16]:
        first, second = (
            ModelTradeoff(
                TradeoffRequest((str(one.loaded.path),), horizon=0.2, budget=1e4, seed=seed)
            )
            for seed in SEEDS
        )
        for advice in (first, second):
            assert [*advice.work()]
        if first.choice is None or not second.trials:
            assert first.sentence
            continue
        chosen = setting_of(first.choice)
        again = [item for item in second.trials if setting_of(item) == chosen]
        answers += [(one.file, chosen.name, item.error) for item in again]
    assert len(answers) >= 8
    assert [answer for answer in answers if answer[2] > first.request.target] == []

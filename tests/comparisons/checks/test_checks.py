"""The checks pass right engines whatever the parameters, and run the same however they are run."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.checks import execution, suite
from mbcheck.comparisons.checks.comparison import Measured
from mbcheck.comparisons.checks.execution import run_checks
from mbcheck.comparisons.checks.request import Execution
from mbcheck.comparisons.checks.suite import Check, plan, run_check
from mbcheck.comparisons.checks.table import KINDS
from mbcheck.comparisons.checks.verdict import Finding, judge
from mbcheck.comparisons.engines import registry as engines
from mbcheck.comparisons.engines.adapter import Adapter, BoundModel
from mbcheck.comparisons.engines.protocol import Method
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.engines.run import Trajectory
from mbcheck.comparisons.faults.variants import Delegating, Wrapped
from mbcheck.reference import SCENES
from mbcheck.reference.errors import EngineUnavailableError, UsageError
from mbcheck.reference.hula_hoop.equations import HulaHoop
from mbcheck.reference.scene import Array, Case
from mbcheck.tests.support.command import process
from mbcheck.tests.support.draws import some_are_slow
from mbcheck.tests.support.example import bad

ACCURATE = {"mujoco": "RK4", "exudyn": "RK67"}
CASES = {
    "algebra": "point_mass_3hz_60n",
    "trajectory": "spinning_3hz_60n",
    "order": "spinning_3hz_60n",
    "frequency": "rest_rod_across",
    "stability": "point_mass_3hz_60n",
    "energy": "free_undamped",
}
"""One case of hula_hoop for each kind."""


def one_check(engine: str, kind: str, method: str | None = None) -> Check:
    """Return the check of an engine's default model for a kind."""
    name = method or ACCURATE[engine]
    found = [
        check
        for check in plan(engines=[engine], kinds=[kind])
        if check.case.name == CASES[kind]
        and check.default_model
        and (check.method is None or check.method.name == name)
    ]
    assert len(found) == 1
    return found[0]


def random_cases(count: int, seed: int) -> list[Case]:
    """Return cases with every parameter between half and twice its default."""
    random = np.random.default_rng(seed)
    cases = []
    for number in range(count):
        factors = 2 ** random.uniform(-1, 1, len(HulaHoop.names()))
        base = HulaHoop(inertia_ratio=random.choice([0, 1.8]))
        values = base.as_dict().items()
        p = HulaHoop(**{name: v * f for (name, v), f in zip(values, factors, strict=True)})
        state = {"theta": random.uniform(-3, 3), "theta_dot": random.uniform(-25, 25)}
        kinds = ("algebra", "trajectory", "order")
        cases.append(Case("hula_hoop", f"random_{number}", p, state, 0.5, kinds))
    return cases


@pytest.mark.parametrize(
    "case", [*random_cases(1, 11), *some_are_slow(random_cases(20, 12))], ids=lambda case: case.name
)
@pytest.mark.parametrize("engine", ACCURATE)
def test_right_engines_pass_with_other_parameters(engine: str, case: Case) -> None:
    for kind in case.kinds:
        for check in suite.checks_of(kind, case, engine):
            assert not bad(run_check(check)), check.prefix


@pytest.mark.parametrize("order_claimed", [3, 6])
def test_a_wrong_order_is_found(order_claimed: int) -> None:
    check = one_check("exudyn", "order", "RK44")
    assert check.method is not None
    claim = replace(check, method=replace(check.method, order=order_claimed, scheme=None))
    verdicts = {item.quantity: item.verdict for item in run_check(claim)}
    assert verdicts["order"] == ("deviation" if order_claimed > 4 else "pass")


CHEAP = (
    "*/point_mass_3hz_60n/algebra/*",
    "*/point_mass_3hz_60n/parts/*",
    "*/rod_aligned/step/*/RK*",
    "*/rest_rod_across/frequency/*",
    "*/free_undamped/energy/*/RK*",
    "*/modes_at_*/frequency/*",
    "*/conservative/energy/exudyn/RK*",
    "*/weighed/algebra/*",
    "*/relative_motor/algebra/*",
    "*/heavy_tumbling/algebra/*",
    "*/rotation/order/exudyn/*",
    "*/massless_rod_and_slider/trajectory/*",
    "*/steady_at_rest/*",
    "*/rest_hanging/frequency/*",
    "*/afloat/frequency/*",
    "*/hanging/frequency/*",
)
"""Ids of quick checks of all scenes, engines and kinds but stability; some are skipped."""


@pytest.mark.slow
def test_results_do_not_depend_on_the_number_of_processes() -> None:
    checks = plan(ids=CHEAP)
    assert {check.case.scene for check in checks} == set(SCENES)
    assert {check.kind for check in checks} == set(KINDS) - {"stability"}
    assert any(check.unsupported_reason for check in checks)
    alone, shared = (
        [replace(item, work={}) for item in run_checks(checks, execution=Execution(jobs=jobs))]
        for jobs in (1, 2)
    )
    assert alone == shared
    assert not bad(alone)  # right engines
    assert len(alone) == sum(len(check.ids) for check in checks)


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="cores cannot be chosen here")
def test_results_do_not_depend_on_cores_and_threads() -> None:
    """Sums have another order with other threads; no error moves by 1e-4 of its tolerance."""
    ids = " ".join(f"--id {one}" for one in (*CHEAP, "*/steady_4*/*"))
    cores = os.sched_getaffinity(0)
    found = []
    for count, where in ((1, {min(cores)}), (4, cores)):
        os.sched_setaffinity(0, where)  # processes that are started inherit it
        try:
            done = process(f"check {ids} --json -", OPENBLAS_NUM_THREADS=f"{count}")
        finally:
            os.sched_setaffinity(0, cores)
        assert not done.returncode
        found.append(json.loads(done.stdout)["results"])
    for one, other in zip(*found, strict=True):
        assert (one["id"], one["verdict"]) == (other["id"], other["verdict"])
        if one["tolerance"]:
            assert abs(one["error"] - other["error"]) < 1e-4 * one["tolerance"], one["id"]


@dataclass(frozen=True)
class Bomb(Case):
    """A case that kills the process that reads it."""

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[int]]:
        return os._exit, (3,)


def test_a_check_that_kills_its_process_takes_no_other_along() -> None:
    good = [
        item
        for item in plan(kinds=["frequency"], engines=["mujoco"])
        if not item.unsupported_reason
    ]
    deadly = replace(good[0], case=Bomb("hula_hoop", "bomb", HulaHoop()))
    results = run_checks([deadly, *good], execution=Execution(jobs=2))
    verdicts = {item.case: item.verdict for item in results}
    assert verdicts.pop("bomb") == "error"
    assert set(verdicts.values()) == {"pass"}
    assert "took its process down" in results[0].reason


def test_whatever_an_engine_raises_is_an_error_for_each_of_its_quantities() -> None:
    class Broken(Delegating):
        def __getattr__(self, name: str) -> Any:
            raise RuntimeError("out of order")

    check = one_check("mujoco", "trajectory")
    results = run_check(check, engine=Broken())
    assert [item.id for item in results] == list(check.ids)
    assert {item.verdict for item in results} == {"error"}
    assert "out of order" in results[0].reason


def test_a_quantity_that_was_not_measured_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    forgetful = replace(KINDS["algebra"], measure=lambda setup: Measured([]))
    monkeypatch.setitem(KINDS, "algebra", forgetful)
    results = run_check(one_check("mujoco", "algebra"))
    assert {item.verdict for item in results} == {"error"}
    assert len(results) == 3


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_a_finding_that_is_not_a_number_is_never_a_pass(value: float) -> None:
    assert judge(Finding("y", "m", value, 0.0, value, 1.0), 1.0)[0] == "error"
    assert judge(Finding("y", "m", 0.0, 0.0, 0.0, value), 1.0)[0] == "error"


class Exact(Wrapped):
    """An engine without an error of its steps: it returns the reference's motion."""

    def simulate(
        self, model: BoundModel, case: Case, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Return the reference's motion, with the engine's own steps."""
        motion = get_engine("reference").bind(case, "exact").simulate(case, method, step, times)
        steps = round((float(times[-1]) - case.start_time) / step)
        return replace(motion, steps=steps)


def test_an_engine_as_good_as_the_reference_is_not_judged_on_order() -> None:
    results = run_check(one_check("exudyn", "order"), engine=Exact(get_engine("exudyn")))
    assert {item.verdict for item in results} == {"skipped"}
    assert "round-off" in results[0].reason


def test_every_id_is_there_once_and_says_what_it_is() -> None:
    checks = plan()
    ids = [name for check in checks for name in check.ids]
    assert len(ids) == len(set(ids))
    assert "verification/hula_hoop/point_mass_3hz_60n/trajectory/mujoco/RK4/theta" in ids
    assert any("/GeneralizedAlpha@redundant/" in name for name in ids)
    assert {check.kind for check in checks} == set(KINDS)


def test_an_id_selects_its_own_check() -> None:
    wanted = plan()[5].ids[0]
    assert [check.ids[0] for check in plan(ids=[wanted])] == [wanted]


@pytest.mark.parametrize(
    ("asked", "answer"),
    [
        ({"scenes": ["hula_hop"]}, "did you mean 'hula_hoop'"),
        ({"engines": ["mujoko"]}, "did you mean 'mujoco'"),
        ({"kinds": ["energie"]}, "did you mean 'energy'"),
        ({"methods": ["RK5"]}, "did you mean"),
        ({"ids": ["nothing/*"]}, "no check matches"),
        ({"engines": ["reference"]}, "checked against"),
    ],
)
def test_what_cannot_be_planned_is_told(asked: dict[str, list[str]], answer: str) -> None:
    with pytest.raises(UsageError, match=answer):
        plan(**asked)  # type: ignore[arg-type]


def test_half_a_run_is_not_green(tmp_path: Path) -> None:
    library = "libGL.so.1: cannot open shared object file: No such file or directory"
    (tmp_path / "exudyn").mkdir()
    (tmp_path / "exudyn" / "__init__.py").write_text(f"raise ImportError({library!r})\n")
    path = os.pathsep.join(filter(None, (str(tmp_path), os.environ.get("PYTHONPATH"))))
    few = "check hula_hoop --kind frequency --json -"
    whole = process(few, PYTHONPATH=path)
    results = json.loads(whole.stdout)["results"]
    reasons = {item["engine"]: item["reason"] for item in results if item["verdict"] == "error"}
    assert list(reasons) == ["exudyn"]
    assert "apt-get install libgl1" in reasons["exudyn"]
    assert {item["verdict"] for item in results if item["engine"] == "mujoco"} == {"pass"}
    assert whole.returncode == 1
    assert process(f"{few} --engine mujoco", PYTHONPATH=path).returncode == 0


def test_fail_fast_stops_at_the_first_deviation(monkeypatch: pytest.MonkeyPatch) -> None:
    failing = Measured([Finding("energy_drift", "1", 1.0, 0.0, 1.0, 0.5)])
    monkeypatch.setitem(KINDS, "energy", replace(KINDS["energy"], measure=lambda setup: failing))
    checks = plan(scenes=["hula_hoop"], kinds=["energy"], engines=["mujoco"])
    able = [check for check in checks if not check.unsupported_reason]
    assert len(run_checks(able, execution=Execution(fail_fast=True))) == 1
    assert len(run_checks(able)) == len(able) > 1


def test_fail_fast_does_not_stop_at_what_is_skipped() -> None:
    checks = plan(scenes=["speed_regulator"], kinds=["frequency"], engines=["mujoco"])
    assert any(check.unsupported_reason for check in checks)
    assert len(run_checks(checks, execution=Execution(fail_fast=True))) == sum(
        len(check.ids) for check in checks
    )


@pytest.mark.parametrize(("installed", "verdict"), [(False, "skipped"), (True, "error")])
def test_an_engine_that_cannot_be_imported(
    monkeypatch: pytest.MonkeyPatch, installed: bool, verdict: str
) -> None:
    def without_exudyn(name: str) -> Adapter:
        if name == "exudyn":
            raise EngineUnavailableError("exudyn cannot be imported: libGL.so.1; libgl1")
        return get_engine(name)

    for module in (engines, execution):
        monkeypatch.setattr(module, "get_engine", without_exudyn)
    monkeypatch.setattr(execution, "installed", lambda name: installed)
    assert {check.engine for check in plan()} == {"mujoco"}
    assert [item.verdict for item in execution.unavailable()] == [verdict]
    with pytest.raises(EngineUnavailableError, match="libgl1"):
        plan(engines=["exudyn"])

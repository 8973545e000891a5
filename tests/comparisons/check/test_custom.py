"""Checks at a user's own parameters: what passes, what is seen, and what is refused."""

from __future__ import annotations

import json
import shlex
import tomllib
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.check import custom
from mbcheck.comparisons.check.custom import (
    USUAL_PERIODS,
    custom_case,
    why_inapplicable,
    with_horizon,
)
from mbcheck.comparisons.check.request import matching_checks
from mbcheck.comparisons.checks import suite
from mbcheck.comparisons.checks.known import TODO
from mbcheck.comparisons.checks.request import CheckRequest
from mbcheck.comparisons.checks.truth import MOST_AMPLIFICATION
from mbcheck.comparisons.checks.verdict import Result
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.engines.setup import shortest_period
from mbcheck.comparisons.faults.catalogue import FAULTS
from mbcheck.comparisons.queries.request import Query
from mbcheck.reference import SCENES, get_scene
from mbcheck.reference.errors import UsageError
from mbcheck.tests.support.command import invoke, refusal, succeeds
from mbcheck.tests.support.documents import validated

pytestmark = pytest.mark.usefixtures("own_folder")

OWN: dict[str, dict[str, Any]] = {
    "hula_hoop": {
        "parameters": {"force_amplitude": 80.0, "stiffness": 1500.0},
        "state": {"theta": 0.3, "theta_dot": 12.0},
        "horizon": 0.4,
    },
    "rotor_pendulum": {
        "parameters": {"platform_stiffness": 50000.0, "rod_stiffness": 900.0},
        "state": {"phi_1_dot": 30.0, "phi_3": 0.1},
        "horizon": 0.1,
    },
    "speed_regulator": {
        "parameters": {"crank_radius": 0.3, "rod_mass": 1.0},
        "state": {"phi_dot": 6.0},
        "horizon": 1.5,
    },
}
"""Parameters, initial values and a horizon [s] that are those of no case."""

SEEN = {
    "hula_hoop": "free_mass_0.1_percent",
    "rotor_pendulum": "rotor_mass_0.1_percent",
    "speed_regulator": "rod_mass_0.1_percent",
}
"""Scene -> a fault that changes a mass by 0.1 %."""

KINDS = ("algebra", "trajectory")
LINE = (
    "check hula_hoop --set force_amplitude=80 --state theta=0.3 --horizon 0.4 --engine mujoco "
    "--method RK4 --kind trajectory -j 1"
)


def by_verdict(results: Iterable[Result]) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for result in results:
        found.setdefault(result.verdict, []).append(f"{result.id}: {result.reason}")
    return found


@pytest.mark.parametrize("engine", ["mujoco", "exudyn"])
@pytest.mark.parametrize("scene", OWN)
def test_a_correct_engine_passes(scene: str, engine: str) -> None:
    report = mbcheck.check([scene], [engine], ["parts", *KINDS, "step", "frequency"], **OWN[scene])
    verdicts = by_verdict(report.results)
    assert set(verdicts) <= {"pass", "skipped"}, verdicts
    assert len(verdicts["pass"]) > 20
    prefixes = {result.id.rpartition(f"/{result.kind}/")[0] for result in report.results}
    assert prefixes == {f"verification/{scene}/custom"}
    assert report.exit_code == 0


@pytest.mark.parametrize("engine", ["mujoco", "exudyn"])
@pytest.mark.parametrize("scene", OWN)
def test_a_mass_that_is_off_by_a_thousandth_is_seen(scene: str, engine: str) -> None:
    wrong = FAULTS[scene][SEEN[scene]].make[engine]()
    request = CheckRequest([scene], [engine], KINDS, **OWN[scene])
    checks = matching_checks(request, custom_case([scene], *OWN[scene].values()))
    checks = [check for check in checks if check.default_model and check.unsupported_reason is None]
    best = suite.best_method(checks[0].setup())
    for kind in KINDS:
        (check,) = (one for one in checks if one.kind == kind and one.method in (None, best))
        verdicts = {
            result.verdict for result in suite.run_check(check, engine=wrong, explain=False)
        }
        assert "deviation" in verdicts, kind


@pytest.mark.parametrize(
    "engine",
    [
        pytest.param("mujoco", marks=pytest.mark.slow),
        pytest.param("exudyn", marks=pytest.mark.campaign),
    ],
)
def test_a_correct_beam_passes(engine: str) -> None:
    own = {"angular_speed": 1.5, "ramp_time": 2.0, "segments": 8.0}
    report = mbcheck.check(["rotating_beam"], [engine], parameters=own, horizon=2.5)
    verdicts = by_verdict(report.results)
    assert set(verdicts) <= {"pass", "skipped"}, verdicts
    assert {result.kind for result in report.results if result.verdict == "pass"} >= {
        "algebra",
        "trajectory",
        "frequency",
    }


# What is told ---------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def document(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    path = tmp_path_factory.mktemp("own") / "own.json"
    assert invoke(f"{LINE} -q --json {path}").exit_code == 0
    return validated("check", json.loads(path.read_text()))


def test_the_document_holds_what_was_asked_for(document: dict[str, Any]) -> None:
    selection, reference = document["selection"], document["reference"]
    assert selection["parameters"] == {"force_amplitude": 80.0}
    assert selection["state"] == {"theta": 0.3}
    assert selection["horizon"] == reference["horizon"] == reference["permitted"] == 0.4
    assert set(reference["error_bound"]) == {"y", "theta", "y_dot", "theta_dot"}
    assert all(0 < bound < 1e-7 for bound in reference["error_bound"].values())
    assert reference["growth"] > 1
    assert {result["case"] for result in document["results"]} == {"custom"}


def test_the_bound_is_that_of_the_reference(document: dict[str, Any]) -> None:
    times = list(np.arange(1, 257) * 2.0**-10)
    truth = mbcheck.simulate(
        "hula_hoop", parameters={"force_amplitude": 80.0}, state={"theta": 0.3}, times=times
    )
    assert truth.error_bound is not None
    for name, bound in document["reference"]["error_bound"].items():
        assert bound < 1e3 * truth.error_bound[name]


def test_a_run_of_the_scenes_own_cases_has_no_such_reference() -> None:
    report = mbcheck.check(["hula_hoop"], ["mujoco"], ["frequency"])
    document = validated("check", report.as_json())
    assert document["reference"] is None
    assert document["selection"]["parameters"] == {}


def test_the_console_names_parameters_horizon_and_bound() -> None:
    words = " ".join(succeeds(LINE).split())
    assert "hula_hoop at force_amplitude=80 from theta=0.3 over 0.4 s (as given), in which" in words
    assert "error bounds of the reference: y " in words
    text = succeeds(f"{LINE} --markdown -")
    assert "force\\_amplitude=80" in text


def test_python_and_the_command_line_agree(document: dict[str, Any]) -> None:
    report = mbcheck.check(
        ["hula_hoop"],
        ["mujoco"],
        ["trajectory"],
        ["RK4"],
        parameters={"force_amplitude": 80.0},
        state={"theta": 0.3},
        horizon=0.4,
    )
    assert [result["id"] for result in document["results"]] == [r.id for r in report.results]
    for told, result in zip(document["results"], report.results, strict=True):
        assert told["error"] == result.error


# A wrong engine on the command line -------------------------------------------------------------


@pytest.fixture
def _wrong_engine(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let MuJoCo's free mass be off by 0.1 %."""
    wrong = FAULTS["hula_hoop"]["free_mass_0.1_percent"].make["mujoco"]()

    def engine_of(name: str) -> Any:
        return wrong if name == "mujoco" else get_engine(name)

    monkeypatch.setattr(suite, "get_engine", engine_of)


@pytest.mark.usefixtures("_wrong_engine")
def test_the_command_that_is_told_repeats_the_check() -> None:
    done = invoke(f"{LINE} --junit a.xml")
    assert done.exit_code == 1
    (command,) = {
        " ".join(line.split())
        for line in done.stdout.replace("\\\n", "").splitlines()
        if line.startswith("  mbcheck ") and line.endswith("/theta'")
    }
    words = shlex.split(command)[1:]
    assert words[:2] == ["check", "hula_hoop"]
    again = invoke("", *words, "--json", "again.json")
    assert again.exit_code == 1
    results = json.loads(Path("again.json").read_text())["results"]
    assert {result["kind"] for result in results} == {"trajectory"}
    assert {result["method"] for result in results} == {"RK4"}
    failures = ET.parse("a.xml").findall(".//failure")
    assert any(command in (failure.text or "") for failure in failures)


@pytest.mark.usefixtures("_wrong_engine")
def test_known_deviations_of_own_parameters() -> None:
    assert invoke(f"{LINE} --write-known known.toml").exit_code == 1
    text = Path("known.toml").read_text()
    Path("known.toml").write_text(text.replace(TODO, "issue 12"))
    entries = tomllib.loads(text)["known"]
    ids = [name for entry in entries for name in entry["id"]]
    assert ids
    assert all(name.startswith("verification/hula_hoop/custom/") for name in ids)
    assert invoke(f"{LINE} --known known.toml --strict-known").exit_code == 0


ENTRY = """[[known]]
id = "verification/hula_hoop/{case}/trajectory/mujoco/RK4/theta"
reason = "issue 12"
"""


@pytest.mark.parametrize(("case", "code"), [("custom", 1), ("rod_aligned", 0)])
def test_an_entry_is_stale_only_in_runs_of_its_parameters(case: str, code: int) -> None:
    Path("known.toml").write_text(ENTRY.format(case=case))
    own = invoke(f"{LINE} --known known.toml --strict-known")
    assert own.exit_code == code, own.output
    named = f"check --id */{'rod_aligned'}/trajectory/mujoco/RK4/* -j 1"
    other = invoke(f"{named} --known known.toml --strict-known")
    assert other.exit_code == 1 - code, other.output


def test_two_runs_are_compared(document: dict[str, Any]) -> None:
    Path("old.json").write_text(json.dumps(document))
    line = LINE.replace("force_amplitude=80", "force_amplitude=81")
    assert invoke(f"{line} -q --json new.json").exit_code == 0
    assert "force_amplitude" in succeeds("diff old.json new.json")
    assert "selection" not in succeeds("diff old.json old.json")


# Horizons ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("scene", SCENES)
def test_the_default_horizon_is_that_of_the_first_case_in_its_periods(scene: str) -> None:
    described = get_scene(scene)
    case, source = with_horizon(Query(scene).case, None)
    first = described.cases[0]
    usual = first.horizon / float(described.period(first.parameters))
    usual *= float(described.period(case.parameters))
    most = USUAL_PERIODS * shortest_period(case)
    assert case.horizon == pytest.approx(min(usual, most))
    assert (first.name in source) == (usual <= most)


# What is refused, and what is skipped -------------------------------------------------------------

DEAD = "--set flywheel_inertia=1e-12 --set rod_mass=0 --state phi=1.5707963267948966"


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("--set free_mass=1", "need exactly one scene: name it"),
        ("hula_hoop rotor_pendulum --horizon 1", "need exactly one scene: name it"),
        ("hula_hop --set free_mass=1", "did you mean 'hula_hoop'?"),
        ("hula_hoop --set free_mas=1", "did you mean 'free_mass'?"),
        ("hula_hoop --set free_mass=-1", "must be greater than 0"),
        ("hula_hoop --set free_mass=a", "must be a number"),
        ("hula_hoop --set free_mass", "needs NAME=VALUE"),
        ("hula_hoop --state thet=1", "did you mean 'theta'?"),
        ("hula_hoop --state theta=nan", "must be a finite number"),
        ("speed_regulator --state y=3", "contradicts the other values"),
        ("rigid_body --state omega_x=1 --state q_w_dot=1", "initial q_w_dot = 1 1/s contradicts"),
        ("rotating_beam --state theta_dot=3", "contradicts the other values"),
        ("speed_regulator --set crank_radius=2", "the crank could not turn"),
        ("hula_hoop --horizon 1e-6", "choose 0.0333 to 27.2 s"),
        ("hula_hoop --horizon 1e6", "0.25 to 204 periods of the fastest motion here"),
        ("hula_hoop --horizon nan", "choose 0.0333 to 27.2 s"),
        ("hula_hoop --horizon x", "not a valid float"),
        (f"speed_regulator {DEAD}", "starts in a singular position (a dead centre"),
        ("hula_hoop --set free_mass=1 --kind stabilty", "did you mean 'stability'?"),
        ("hula_hoop --set free_mass=1 --id nothing", "no check matches"),
    ],
)
def test_refused(line: str, words: str) -> None:
    assert words in refusal(f"check {line}")


def test_errors_that_grow_too_fast_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(custom, "permitted_horizon", lambda case: (0.03, 9e4))
    with pytest.raises(UsageError, match=r"grow too fast for a reference: by 9e\+04 in 0\.03 s"):
        custom_case(["hula_hoop"], None, {"theta": 0.3}, None)


@pytest.mark.slow
def test_chaos_is_judged_as_far_as_errors_grow_little() -> None:
    found = custom_case(["hula_hoop"], {"force_amplitude": 1e6}, None, None)
    assert found.reference.permitted < found.case.horizon
    assert 1e3 < found.reference.growth <= MOST_AMPLIFICATION


@pytest.mark.parametrize("damping", [1e-1, 1e-3, 1e-6])
def test_steps_suit_a_motor_that_takes_long_to_its_working_speed(damping: float) -> None:
    case = custom_case(["speed_regulator"], {"damping": damping}, None, None).case
    assert shortest_period(case) == pytest.approx(5.9, rel=0.01)
    fast = replace(case, state={"phi_dot": 100.0})
    assert shortest_period(fast) <= 2 * np.pi / 100


@pytest.mark.slow
def test_a_weak_damper_accuses_no_engine() -> None:
    report = mbcheck.check(["speed_regulator"], parameters={"damping": 1e-3})
    verdicts = by_verdict(report.results)
    assert set(verdicts) <= {"pass", "skipped"}, verdicts
    assert report.summary["pass"] > 100


@pytest.mark.slow
def test_without_an_orbit_the_other_kinds_run() -> None:
    weak: dict[str, Any] = {
        "parameters": {"torque": 0.01},
        "state": {"phi_dot": 2.0},
        "horizon": 3.5,
    }
    kinds = ["stability", "frequency"]
    report = mbcheck.check(["speed_regulator"], ["mujoco"], kinds, **weak)
    skipped = [result for result in report.results if result.kind == "stability"]
    assert {result.verdict for result in skipped} == {"skipped"}
    assert "speed_regulator has no steady rotation forward" in skipped[0].reason
    assert report.exit_code == 0
    assert report.summary["pass"] > 0


@pytest.mark.parametrize(
    ("own", "reasons"),
    [
        (
            {"parameters": {"force_amplitude": 0.0}},
            {"trajectory": "nothing moves", "energy": "nothing moves"},
        ),
        ({"state": {"theta_dot": 10.0}}, {"energy": "energy is not conserved"}),
        (
            {
                "parameters": dict.fromkeys(
                    ("force_amplitude", "damping_ratio", "hinge_damping_ratio"), 0.0
                ),
                "state": {"theta_dot": 10.0, "y": 0.01},
            },
            {},
        ),
    ],
)
def test_kinds_that_do_not_apply(own: dict[str, Any], reasons: dict[str, str]) -> None:
    mine = custom_case(["hula_hoop"], own.get("parameters"), own.get("state"), 0.5)
    kinds = ("algebra", "trajectory", "energy", "frequency")
    told = {kind: why for kind in kinds if (why := why_inapplicable(mine, kind))}
    assert set(told) == set(reasons)
    for kind, words in reasons.items():
        assert words in told[kind]

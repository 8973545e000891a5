"""The verbs on the scenes that nothing drives: words, outputs on request, unknown periods."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

import mbcheck
from mbcheck.comparisons import catalogue
from mbcheck.comparisons.suite import KINDS, judged
from mbcheck.reference import SCENES, get_scene
from mbcheck.reference.errors import ParameterError, UnknownNameError, UsageError
from mbcheck.reference.speed_regulator import SpeedRegulator
from mbcheck.tests.test_api import validated
from mbcheck.tests.test_cli import mbcheck as command
from mbcheck.tests.test_cli import succeeds

ENGINES = ("mujoco", "exudyn")
ROTATING = {"phi_dot": 5.07}


@pytest.fixture(autouse=True)
def _own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_outputs_come_on_request() -> None:
    plain = mbcheck.simulate("speed_regulator", state=ROTATING, times=[0.5])
    assert list(plain.observables) == ["phi", "phi_dot", "y", "y_dot"]
    asked = mbcheck.simulate(
        "speed_regulator", state=ROTATING, times=[0.5], observe=["reaction_a_x"]
    )
    assert list(asked.observables) == [*plain.observables, "reaction_a_x"]
    whole = mbcheck.simulate("speed_regulator", state=ROTATING, times=[0.5], observe=["all"])
    assert set(whole.observables) == set(get_scene("speed_regulator").units)
    document = validated("simulate", whole.as_json())
    assert document["units"]["reaction_a_x"] == "N"
    assert all(0 < bound < 1e-9 for bound in document["error_bound"].values())


@pytest.mark.parametrize("engine", ENGINES)
def test_an_engine_shows_what_it_can(engine: str) -> None:
    whole = mbcheck.simulate(
        "speed_regulator", state=ROTATING, times=[0.5], engine=engine, observe=["all"]
    )
    truth = mbcheck.simulate("speed_regulator", state=ROTATING, times=[0.5])
    violations = {"position_violation", "velocity_violation"}
    assert set(whole.observables) == set(truth.observables) | violations
    for name, values in truth.observables.items():
        assert whole.observables[name] == pytest.approx(values, abs=2e-3), name
    with pytest.raises(UsageError, match="does not tell rod_x"):
        mbcheck.simulate(
            "speed_regulator", state=ROTATING, times=[0.5], engine=engine, observe=["rod_x"]
        )


def test_an_unknown_output_is_said_so() -> None:
    with pytest.raises(UnknownNameError, match="reaction_a_x"):
        mbcheck.simulate("speed_regulator", times=[0.5], observe=["reaction_ax"])


@pytest.mark.parametrize("engine", ["reference", *ENGINES])
def test_a_start_that_contradicts_itself_is_refused(engine: str) -> None:
    p = SpeedRegulator()
    folded = -math.sqrt(p.rod_length**2 - p.crank_radius**2)
    mbcheck.simulate("speed_regulator", state={"y": folded}, times=[0.5], engine=engine)
    with pytest.raises(UsageError, match=r"y.*-1\.22"):
        mbcheck.simulate("speed_regulator", state={"y": -1.2}, times=[0.5], engine=engine)
    with pytest.raises(UsageError, match="y_dot"):
        mbcheck.simulate("speed_regulator", state={"y_dot": 1.0}, times=[0.5], engine=engine)


@pytest.mark.parametrize("engine", ["reference", *ENGINES])
def test_a_rod_that_is_no_longer_than_the_crank_is_refused(engine: str) -> None:
    with pytest.raises(ParameterError, match="rod_length"):
        mbcheck.simulate(
            "speed_regulator", parameters={"crank_radius": 1.25}, times=[0.5], engine=engine
        )


def test_a_word_is_a_parameter() -> None:
    runs = {
        word: mbcheck.simulate(
            "rotor_pendulum",
            parameters={"motor_placement": word, "rod_stiffness": 1e3},
            times=[0.25],
        )
        for word in ("absolute", "relative")
    }
    assert runs["relative"].as_json()["parameters"]["motor_placement"] == "relative"
    speeds = [run.observables["phi_2_dot"][0] for run in runs.values()]
    assert abs(speeds[0] - speeds[1]) > 1e-3
    with pytest.raises(UnknownNameError, match="did you mean 'absolute'"):
        mbcheck.simulate("rotor_pendulum", parameters={"motor_placement": "abslute"}, times=[0.25])
    with pytest.raises(ParameterError, match="rod_mass"):
        mbcheck.simulate("rotor_pendulum", parameters={"rod_mass": "heavy"}, times=[0.25])


def test_the_reduced_equations_are_shown_and_judge_no_one() -> None:
    exact, reduced = (
        mbcheck.simulate("rotor_pendulum", times=[0.5], model=model)
        for model in ("exact", "reduced")
    )
    assert exact.error_bound is not None
    apart = abs(exact.observables["phi_1"][0] - reduced.observables["phi_1"][0])
    assert apart > 100 * exact.error_bound["phi_1"]
    with pytest.raises(UnknownNameError, match="reduced"):
        mbcheck.simulate("rotor_pendulum", times=[0.5], engine="mujoco", model="reduced")


def test_orbits_of_unknown_period() -> None:
    found = validated("orbit", mbcheck.orbit("speed_regulator").as_json())
    assert found["period"] == pytest.approx(1.2389934, abs=1e-7)
    assert found["state"]["phi"] == 0
    marked = [item["modulus"] for item in found["floquet_multipliers"] if item["trivial"]]
    others = [item["modulus"] for item in found["floquet_multipliers"] if not item["trivial"]]
    assert marked == pytest.approx([1.0], abs=1e-9)
    assert others == pytest.approx([0.96297], abs=1e-5)
    assert found["quantities"]["damper_work_ratio"]["value"] == pytest.approx(1, abs=1e-9)
    assert found["quantities"]["minimum_speed"]["value"] == pytest.approx(5.0515, abs=1e-4)
    assert found["quantities"]["maximum_speed"]["unit"] == "rad/s"


def test_an_engine_finds_its_own_period() -> None:
    exact = mbcheck.orbit("speed_regulator").as_json()
    own = mbcheck.orbit("speed_regulator", engine="exudyn", model="one_dof", method="RK44")
    found = validated("orbit", own.as_json())
    assert found["period"] == pytest.approx(exact["period"], rel=1e-7)
    assert found["period"] != exact["period"]
    assert sum(item["trivial"] for item in found["floquet_multipliers"]) == 1
    for name, item in exact["quantities"].items():
        assert found["quantities"][name]["value"] == pytest.approx(item["value"], rel=1e-5), name


def test_coverage_has_no_empty_cell_without_a_reason() -> None:
    found = catalogue.coverage()
    cells = {(c["scene"], c["engine"], c["kind"]): c for c in found["cells"]}
    assert len(cells) == len(found["cells"]) == len(SCENES) * len(judged()) * len(KINDS)
    assert all(c["checks"] > 0 or c["reason"] for c in cells.values())
    assert json.loads(succeeds("list --coverage --json -")) == json.loads(json.dumps(found))
    lines = succeeds("list --coverage").splitlines()
    assert max(map(len, lines)) <= 80
    row = next(line for line in lines if line.startswith("speed_regulator mujoco"))
    assert row.split()[2:] == [
        str(cells["speed_regulator", "mujoco", kind]["checks"]) for kind in KINDS
    ]
    assert command("list hula_hoop --coverage").exit_code == 2


@pytest.mark.parametrize("scene", SCENES)
def test_wide_tables_fit_the_console(scene: str) -> None:
    text = succeeds(f"simulate {scene} --times 0.125 --observe all")
    rows = [line for line in text.splitlines() if line.strip().startswith(("t [s]", "0.125"))]
    assert len(rows) >= 2
    assert max(map(len, rows)) <= 80
    observables = mbcheck.simulate(scene, times=[0.125], observe=["all"]).observables
    assert sum(len(line.split()) - 1 for line in rows if "t [s]" not in line) == len(observables)

"""The verbs on the scenes that nothing drives: words, outputs on request, unknown periods."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.checks.table import KINDS
from mbcheck.comparisons.checks.truth import truth_of
from mbcheck.comparisons.cli import catalogue
from mbcheck.comparisons.engines.registry import checked_engines
from mbcheck.reference import SCENES, get_scene
from mbcheck.reference.equations import scene_equations
from mbcheck.reference.errors import ParameterError, UnknownNameError, UsageError
from mbcheck.reference.rotating_beam import beam_scene
from mbcheck.reference.scene import Case
from mbcheck.reference.solve.single import solve
from mbcheck.reference.speed_regulator.equations import SpeedRegulator
from mbcheck.tests.support.command import invoke, on_a_terminal, succeeds
from mbcheck.tests.support.documents import validated

ENGINES = ("mujoco", "exudyn")
ROTATING = {"phi_dot": 5.07}


pytestmark = pytest.mark.usefixtures("own_folder")


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
    with pytest.raises(UsageError, match="does not return rod_x"):
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
    assert len(cells) == len(found["cells"]) == len(SCENES) * len(checked_engines()) * len(KINDS)
    assert all(c["checks"] > 0 or c["reason"] for c in cells.values())
    assert json.loads(succeeds("list --coverage --json -")) == json.loads(json.dumps(found))
    lines = on_a_terminal("list --coverage").splitlines()
    assert max(map(len, lines)) <= 80
    scene = next(i for i, line in enumerate(lines) if line.split() == ["speed_regulator"])
    row = next(line for line in lines[scene:] if line.startswith("  mujoco"))
    assert row.split()[1:] == [
        str(cells["speed_regulator", "mujoco", kind]["checks"] or "-") for kind in KINDS
    ]
    assert invoke("list hula_hoop --coverage").exit_code == 2


@pytest.mark.parametrize("scene", SCENES)
def test_wide_tables_fit_the_console(scene: str) -> None:
    text = on_a_terminal(f"simulate {scene} --times 0.125 --observe all")
    rows = [line for line in text.splitlines() if line.strip().startswith(("t [s]", "0.125"))]
    assert len(rows) >= 2
    assert max(map(len, rows)) <= 80
    observables = mbcheck.simulate(scene, times=[0.125], observe=["all"]).observables
    assert sum(len(line.split()) - 1 for line in rows if "t [s]" not in line) == len(observables)


def test_frequencies_of_a_rotating_beam_in_both_planes() -> None:
    """Of the inextensible beam chordwise^2 = flapwise^2 - Omega^2."""
    speed = 3.0
    planes = {
        plane: mbcheck.frequencies(
            "rotating_beam",
            about="rotation",
            parameters={"angular_speed": speed},
            plane=plane,
            count=3,
        )
        for plane in ("chordwise", "flapwise")
    }
    chordwise, flapwise = ([mode.omega for mode in found.modes] for found in planes.values())
    for one, other in zip(chordwise, flapwise, strict=True):
        assert one**2 == pytest.approx(other**2 - speed**2, rel=1e-10)
    document = validated("frequencies", planes["flapwise"].as_json())
    assert document["plane"] == "flapwise"
    assert document["state"] == {"theta": 0.0, "theta_dot": speed}
    default = mbcheck.frequencies("rotating_beam", parameters={"angular_speed": speed}).modes
    assert [mode.omega for mode in default[:3]] == chordwise


@pytest.mark.parametrize(("engine", "error"), [("mujoco", 2e-2), ("exudyn", 1e-4)])
def test_frequencies_of_a_beam_by_an_engine(engine: str, error: float) -> None:
    exact, found = (
        mbcheck.frequencies(
            "rotating_beam", about="rotation", parameters={"angular_speed": 3.0}, engine=who
        )
        for who in ("reference", engine)
    )
    for one, other in zip(exact.modes[:2], found.modes[:2], strict=True):
        assert other.omega == pytest.approx(one.omega, rel=error)
        assert other.omega != one.omega
    with pytest.raises(UsageError, match="flapwise"):
        mbcheck.frequencies("rotating_beam", engine=engine, plane="flapwise")


def test_planes_are_of_beams() -> None:
    with pytest.raises(UsageError, match="no planes"):
        mbcheck.frequencies("hula_hoop", plane="flapwise")
    with pytest.raises(UnknownNameError, match="chordwise"):
        mbcheck.frequencies("rotating_beam", plane="chordwize")


@pytest.mark.parametrize("engine", ["reference", *ENGINES])
def test_a_prescribed_speed_leaves_no_choice(engine: str) -> None:
    steady = {"ramp_time": 0.0, "angular_speed": 2.0, "segments": 4}
    found = mbcheck.simulate("rotating_beam", parameters=steady, times=[0.5], engine=engine)
    assert found.observables["theta"] == pytest.approx([1.0], abs=1e-9)
    with pytest.raises(ParameterError, match="theta_dot = 2 follows"):
        mbcheck.simulate(
            "rotating_beam",
            parameters=steady,
            state={"theta_dot": 1.0},
            times=[0.5],
            engine=engine,
        )
    with pytest.raises(UnknownNameError, match="theta_dot"):
        mbcheck.simulate("rotating_beam", state={"b_1": 0.1}, times=[0.5], engine=engine)


def test_a_beam_has_no_orbit() -> None:
    done = invoke("orbit rotating_beam")
    assert done.exit_code == 1
    assert "no periodic orbit" in done.stderr


@pytest.mark.slow
def test_a_bound_counts_the_coordinates_left_out() -> None:
    p = {"angular_speed": 2.0, "ramp_time": 1.0, "mass": 0.4}
    exact = mbcheck.simulate("rotating_beam", parameters=p, times=[0.5, 1.0])
    assert exact.error_bound is not None
    scene = get_scene("rotating_beam")
    case = Case("rotating_beam", "test", scene.parameters().replace(**p))
    alone = solve(scene, case.parameters, scene.state({}), np.array([0.5, 1.0]))
    bound = truth_of(scene_equations(case), alone, ("tip_deflection",)).bound[0]
    assert exact.error_bound["tip_deflection"] > bound
    best = solve(beam_scene(n=12), case.parameters, np.zeros(26), np.array([0.5, 1.0]))
    tip = beam_scene(n=12).observe(best.states, case.parameters)["tip_deflection"]
    apart = np.max(np.abs(exact.observables["tip_deflection"] - tip))
    assert apart < exact.error_bound["tip_deflection"] < 1e-5
    assert set(exact.observables) == {*scene.public_states, *scene.observed}


@pytest.mark.parametrize("period", [0.1, pytest.param(0.01, marks=pytest.mark.slow)])
def test_a_bound_counts_the_modes_that_a_short_pulse_excites(period: float) -> None:
    p = {"drive": "torque", "torque_amplitude": 100.0, "torque_period": period}
    times = [0.02, 0.05, 0.1]
    pulse = mbcheck.simulate("rotating_beam", parameters=p, times=times)
    finer = beam_scene(n=16)
    parameters = get_scene("rotating_beam").parameters().replace(**p)
    states = solve(finer, parameters, np.zeros(34), np.array(times)).states
    finest = finer.observe(states, parameters)
    assert pulse.error_bound is not None
    for name, values in pulse.observables.items():
        apart = np.max(np.abs(finest[name] - values))
        assert apart <= pulse.error_bound[name] <= 30 * apart

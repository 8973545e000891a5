"""Trajectories computed elsewhere: what passes, what deviates, and what is said of mistakes."""

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import ANY

import mujoco  # noqa: F401
import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.judge import comparison
from mbcheck.comparisons.judge.comparison import compare
from mbcheck.comparisons.judge.judge import judge_trajectory
from mbcheck.comparisons.judge.recording import recording
from mbcheck.comparisons.queries.simulate import Simulation, simulate
from mbcheck.comparisons.reports.queries import csv_text
from mbcheck.reference import get_scene
from mbcheck.reference.errors import EngineError, UsageError
from mbcheck.tests.support.command import invoke
from mbcheck.tests.support.documents import validated
from mbcheck.tests.support.trajectory import (
    CASE,
    GOOD,
    START,
    STEP,
    TIMES,
    Columns,
    columns,
    run,
    verdicts,
)

pytestmark = pytest.mark.usefixtures("own_folder")

METHOD: dict[str, Any] = {"order": 4, "step": STEP}


# What passes


def test_the_reference_passes_its_own_judgement() -> None:
    start = " ".join(f"--state {name}={value}" for name, value in START.items())
    assert invoke(f"simulate hula_hoop --times 0:0.5:0.003 {start} --csv a.csv").exit_code == 0
    done = invoke(f"judge a.csv --case {CASE} --tolerance 1e-9")
    assert done.exit_code == 0, done.output
    assert "PASS: 4 passed" in done.stdout
    assert "167 of 167 samples" in done.stdout


@pytest.mark.parametrize(
    ("engine", "method", "order"),
    [
        ("mujoco", "RK4", 4),
        ("mujoco", "Euler", 1),
        ("exudyn", "TrapezoidalIndex2", 2),
        pytest.param("mujoco", "implicitfast", 1, marks=pytest.mark.slow),
        pytest.param("exudyn", "ExplicitEuler", 1, marks=pytest.mark.slow),
        pytest.param("exudyn", "ExplicitMidpoint", 2, marks=pytest.mark.slow),
        pytest.param("exudyn", "RK33", 3, marks=pytest.mark.slow),
        pytest.param("exudyn", "DOPRI5", 5, marks=pytest.mark.slow),
        pytest.param("exudyn", "RK67", 6, marks=pytest.mark.slow),
    ],
)
def test_a_method_passes_by_its_order(engine: str, method: str, order: int) -> None:
    pytest.importorskip(engine, exc_type=ImportError)
    found = judge_trajectory(columns(run(engine, method)), CASE, order=order, step=STEP)
    assert verdicts(found) == {"pass"}, found.results
    finer = judge_trajectory(columns(run(engine, method)), CASE, order=order, step=STEP / 64)
    assert "deviation" in verdicts(finer), "a much shorter step must tell them apart"


def test_times_need_no_grid(truth: Simulation) -> None:
    times = np.sort(np.random.default_rng(1).uniform(0, 0.5, 300))
    found = simulate("hula_hoop", state=START, times=times)
    assert verdicts(judge_trajectory(columns(found), CASE, tolerance=1e-10)) == {"pass"}


def test_outputs_are_judged_too() -> None:
    times = np.linspace(0, 2, 41)
    found = columns(simulate("speed_regulator", times=times, observe=["all"],
                                 state={"phi_dot": 5.07}))  # fmt: skip
    case = "speed_regulator/rotation"
    assert verdicts(judge_trajectory(found, case, tolerance=1e-9)) == {"pass"}
    found["reaction_a_x"] = 1.01 * found["reaction_a_x"]
    wrong = judge_trajectory(found, case, tolerance=1e-9)
    assert [r.quantity for r in wrong.results if r.verdict == "deviation"] == ["reaction_a_x"]


def test_parameters_and_state_make_another_reference(truth: Simulation) -> None:
    heavier = {"free_mass": 0.051}
    state = START | {"theta": 0.31}
    found = columns(simulate("hula_hoop", parameters=heavier, state=state, times=TIMES))
    assert verdicts(judge_trajectory(found, CASE, tolerance=1e-9)) == {"deviation"}
    judged = judge_trajectory(found, CASE, heavier, {"theta": 0.31}, tolerance=1e-9)
    assert verdicts(judged) == {"pass"}
    assert judged.case == "user"
    assert all("/user/" in result.id for result in judged.results)


# What deviates


@pytest.mark.parametrize(
    ("name", "factor"), [("free_mass", 1.001), ("hinge_damping_ratio", 0.5), ("damping_ratio", 0.5)]
)
def test_a_wrong_model_deviates(name: str, factor: float) -> None:
    default = float(run().parameters[name])
    found = judge_trajectory(columns(run(parameters={name: factor * default})), CASE, **METHOD)
    assert verdicts(found) == {"deviation"}
    assert found.exit_code == 1


@pytest.mark.parametrize(("shift", "word"), [(STEP, "late"), (-STEP, "early")])
def test_times_off_by_a_step_deviate(simulated: Simulation, shift: float, word: str) -> None:
    moved = {name: values[1:] for name, values in columns(simulated).items()}
    moved["t"] = moved["t"] + shift
    found = judge_trajectory(moved, CASE, **METHOD)
    assert verdicts(found) == {"deviation"}
    (note,) = found.notes
    assert re.search(rf"the times look 0\.0009[78]\d* s {word}", note)


Change = Callable[[Columns], Any]
SLIPS: list[tuple[Change, str]] = [
    (lambda c: c.update(theta=np.degrees(c["theta"])), "theta fits if it is in degrees"),
    (lambda c: c.update(theta_dot=c["theta_dot"] * 30 / np.pi), "theta_dot fits if it is in rpm"),
    (lambda c: c.update(y=1e3 * c["y"]), "y fits if it is in millimetres"),
    (lambda c: c.update(y=-c["y"]), "y fits with the opposite sign"),
    (lambda c: c.update(theta=np.remainder(c["theta"], 2 * np.pi)), "up to whole turns"),
    (lambda c: c.update(theta=c["theta"] + 0.1), "starts with theta = 0.4, the case with 0.3"),
    (lambda c: c.update(y=c["theta"], theta=c["y"]), "exchanged: y is theta, theta is y"),
]


@pytest.mark.parametrize(("change", "words"), SLIPS)
def test_a_slip_is_named(simulated: Simulation, change: Change, words: str) -> None:
    changed = columns(simulated)
    change(changed)
    found = judge_trajectory(changed, CASE, **METHOD)
    assert len(found.notes) == 1
    assert words in found.notes[0]
    assert [words in result.reason for result in found.results] == [
        result.verdict == "deviation" for result in found.results
    ]


def test_a_right_trajectory_has_no_slips(simulated: Simulation) -> None:
    assert judge_trajectory(columns(simulated), CASE, **METHOD).notes == ()
    wrong = columns(run(parameters={"damping_ratio": 0.05}))
    assert judge_trajectory(wrong, CASE, **METHOD).notes == ()  # a model is no slip


def test_a_run_that_blew_up_is_an_error(simulated: Simulation) -> None:
    lost = columns(simulated)
    lost["y"] = np.where(lost["t"] > 0.25, np.nan, lost["y"])
    found = judge_trajectory(lost, CASE, **METHOD)
    assert {r.quantity for r in found.results if r.verdict == "error"} == {"y"}
    assert "non_finite: y is nan at t = 0.253906 s" in found.results[0].reason
    assert found.exit_code == 1
    with pytest.raises(EngineError, match="y is nan"):
        judge_trajectory(lost, CASE)


# How much is granted


def test_a_tolerance_is_a_share_of_the_largest_value(truth: Simulation) -> None:
    off = columns(truth)
    off["theta"] = off["theta"] + 1e-3 * np.max(off["theta"]) * (off["t"] > 0.2)
    assert verdicts(judge_trajectory(off, CASE, tolerance=1.01e-3)) == {"pass"}
    tight = judge_trajectory(off, CASE, tolerance=0.99e-3)
    assert [r.quantity for r in tight.results if r.verdict == "deviation"] == ["theta"]
    loose = judge_trajectory(off, CASE, tolerance=0.99e-3, profile="loose")
    assert verdicts(loose) == {"pass"}


@pytest.mark.parametrize("form", ["%.6f", "%.7g"])
def test_digits_of_a_file_are_granted_and_no_more(form: str, simulated: Simulation) -> None:
    def through_text(found: Simulation) -> str:
        np.savetxt("a.txt", np.array(list(columns(found).values())).T, form,
                   header=" ".join(columns(found)))  # fmt: skip
        return "a.txt"

    found = judge_trajectory(through_text(simulated), CASE, **METHOD)
    assert verdicts(found) == {"pass"}
    assert "for the file's digits" in found.results[0].reason
    exact = judge_trajectory(columns(simulated), CASE, **METHOD)
    assert "digits" not in exact.results[0].reason
    heavier = run(parameters={"free_mass": 1.001 * float(simulated.parameters["free_mass"])})
    assert verdicts(judge_trajectory(through_text(heavier), CASE, **METHOD)) == {"deviation"}


def test_what_stands_still_is_not_excused_by_its_few_digits() -> None:
    still = {"t": np.linspace(0, 0.5, 6), "theta": np.full(6, 0.3), "theta_dot": np.full(6, 18.0)}
    found = judge_trajectory(still, CASE, **METHOD)
    assert {r.quantity: r.verdict for r in found.results} == {
        "y": "skipped",
        "theta": "deviation",
        "y_dot": "skipped",
        "theta_dot": "deviation",
    }


def test_a_coarse_method_is_judged_as_far_as_it_can_be(truth: Simulation) -> None:
    found = judge_trajectory(columns(truth), CASE, order=1, step=2e-3)
    assert 1 < found.judged < found.samples
    assert any("may be off by more than 5%" in note for note in found.notes)
    with pytest.raises(UsageError, match="choose a shorter step"):
        judge_trajectory(columns(truth), CASE, order=1, step=0.1)


def test_many_steps_are_scaled_by_the_order(simulated: Simulation) -> None:
    scene = get_scene("hula_hoop")
    case = replace(scene.case("spinning_3hz_60n"), state=START)
    problem = recording(columns(simulated)), case, scene.state_names, METHOD
    direct, scaled = (compare(*problem, *steps).prediction.errors for steps in ((), (200,)))
    assert direct is not None
    assert scaled == pytest.approx(direct, rel=0.35)
    with pytest.raises(UsageError, match="cannot be scaled"):
        compare(*problem, 25)


def test_what_errors_grow_into_is_not_judged(
    truth: Simulation, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(comparison, "permitted_horizon", lambda case: (0.25, 1e5))
    late = columns(truth)
    late["y"] = late["y"] + (late["t"] > 0.25)
    found = judge_trajectory(late, CASE, tolerance=1e-9)
    assert verdicts(found) == {"pass"}
    assert (found.judged, found.until) == (65, 0.25)
    assert "64 of 129 samples lie after that and are not judged" in found.notes[0]
    with pytest.raises(UsageError, match="no sample lies where it can be judged"):
        judge_trajectory({k: v[65:] for k, v in late.items()}, CASE, tolerance=1e-9)


# What is left out


def test_columns_that_are_missing_or_too_many(truth: Simulation) -> None:
    found = columns(truth)
    found["energy"] = found["t"]
    found["thetadot"] = found.pop("theta_dot")
    judged = judge_trajectory(found, CASE, tolerance=1e-9)
    assert judged.notes == ("not compared: energy, thetadot",)
    assert judged.summary["skipped"] == 1
    assert judged.results[3].reason == (
        "the file has no column theta_dot; is it its column 'thetadot'?"
    )


def test_internal_states_are_no_ones_business() -> None:
    times = np.array([0.1, 0.2])
    found = columns(simulate("rotating_beam", times=times))
    case = "rotating_beam/spin_up_quick"
    assert "not compared: b_1" in judge_trajectory(found | {"b_1": times}, case).notes
    with pytest.raises(UsageError, match="modes far faster"):
        judge_trajectory(found, case, order=2, step=1e-3)


# Cases and options


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("--case hula_hop/rod_aligned", "did you mean 'hula_hoop/rod_aligned'?"),
        ("--case hula_hoop/rod_alined", "did you mean 'rod_aligned'?"),
        ("--case spinning_3hz_60n", "did you mean 'hula_hoop/spinning_3hz_60n'?"),
        ("--case hula_hoop", "CASE being one of point_mass_3hz_60n, "),
        ("--case hula_hoop/rest_rod_across", "nothing moves in hula_hoop/rest_rod_across"),
        (f"--case {CASE} --set free_mas=1", "did you mean 'free_mass'?"),
        (f"--case {CASE} --state z=1", "unknown state of hula_hoop 'z'"),
        (f"--case {CASE} --tolerance 0", "must lie between 0 and 1, not 0"),
        (f"--case {CASE} --tolerance nan", "must lie between 0 and 1, not nan"),
        (f"--case {CASE} --tolerance 1", "a share of each observable's largest value"),
        (f"--case {CASE} --tolerance 0.1 --order 2", "not both"),
        (f"--case {CASE} --order 4", "an order needs the step"),
        (f"--case {CASE} --step 0.1", "a step the method's order"),
        (f"--case {CASE} --order 9 --step 0.1", "order 1 to 6, not 9"),
        (f"--case {CASE} --order 0 --step 0.1", "order 1 to 6, not 0"),
        (f"--case {CASE} --order 4 --step -1", "greater than 0, not -1"),
        (f"--case {CASE} --order x --step 1", "not a valid integer"),
        (f"--case {CASE} --tolerance 0.1 --profile lose", "did you mean 'loose'?"),
        (f"--case {CASE} --junit -", "--junit needs verdicts"),
    ],
)
def test_options_that_are_refused(options: str, words: str) -> None:
    Path("a.csv").write_text(GOOD)
    done = invoke(f"judge a.csv {options}")
    assert done.exit_code == 2
    assert words in done.stderr
    assert "Traceback" not in done.stderr


def test_a_file_that_is_not_there() -> None:
    done = invoke(f"judge a.csv --case {CASE}")
    assert done.exit_code == 2
    assert done.stderr == "Error: cannot read a.csv: No such file or directory\n"


# Documents


def test_without_a_tolerance_the_error_is_told(simulated: Simulation) -> None:
    text = csv_text(simulated)
    done = invoke(f"judge - --case {CASE}", stdin=text)
    assert done.exit_code == 0
    assert "nothing is judged without --tolerance" in done.stdout
    assert "an initial error grows by a factor of 11.7" in " ".join(done.stdout.split())
    assert "PASS" not in done.stdout
    found = judge_trajectory(columns(simulated), CASE)
    assert found.results == ()
    assert found.exit_code == 0
    worst = max(found.errors, key=lambda error: error.relative)
    assert worst.error == abs(worst.value - worst.reference)
    assert 0 < worst.relative < 1e-6


@pytest.mark.parametrize("how", [{}, {"tolerance": 1e-9}, METHOD])
def test_the_document(simulated: Simulation, how: Any) -> None:
    found = judge_trajectory(columns(simulated), CASE, **how)
    document = validated("judge", found.as_json())
    assert document["tolerance"] == ({"relative": 1e-9} if "tolerance" in how else how)
    assert len(document["errors"]) == 4
    assert len(document["results"]) == (4 if how else 0)
    assert document["case"] == "spinning_3hz_60n"


def test_the_command_line_writes_what_the_function_returns(simulated: Simulation) -> None:
    Path("my run.csv").write_text(csv_text(simulated))
    line = ["judge", "my run.csv", "--case", CASE, "--json", "-", "--junit", "a.xml"]
    done = invoke("", *line, "--tolerance", "1e-9")
    assert done.exit_code == 1
    judgement = mbcheck.judge_trajectory("my run.csv", CASE, tolerance=1e-9)
    assert json.loads(done.stdout) == json.loads(json.dumps(judgement.as_json()))
    text = Path("a.xml").read_text()
    assert "/trajectory/my_run/file/theta" in text
    assert f"mbcheck judge 'my run.csv' --case {CASE} --tolerance 1e-09" in text
    assert "FAIL: 0 passed, 4 deviations" in done.stderr


def test_the_command_that_is_told_judges_the_same_again(simulated: Simulation) -> None:
    Path("a.csv").write_text(csv_text(simulated))
    options = "--set free_mass=0.051 --state theta=0.31 --order 4 --step 0.0009765625"
    first = invoke(f"judge a.csv --case {CASE} {options} --profile strict --junit a.xml")
    command = re.search(r"mbcheck judge [^<]*", Path("a.xml").read_text())
    assert command is not None
    again = invoke(command[0].strip().removeprefix("mbcheck "))
    assert (again.exit_code, again.stdout) == (first.exit_code, first.stdout) == (1, ANY)


def test_a_judge_needs_a_case() -> None:
    done = invoke("judge a.csv")
    assert done.exit_code == 2
    assert "judge needs --case SCENE/CASE; `mbcheck list SCENE` shows them" in done.stderr


def test_quietly() -> None:
    Path("a.csv").write_text(GOOD)
    done = invoke(f"judge a.csv --case {CASE} --tolerance 0.5 -q")
    assert done.stdout == "PASS: 1 passed, 0 deviations, 0 errors, 3 skipped\n"

"""The command line: every verb, every mistake in one line, and pure standard output."""

import csv
import json
import os
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from mbcheck.comparisons.check import request
from mbcheck.comparisons.checks.request import Execution
from mbcheck.comparisons.checks.verdict import Result as Judged
from mbcheck.comparisons.checks.verdict import Subject
from mbcheck.comparisons.engines import THREADS
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.queries.request import times_from
from mbcheck.comparisons.queries.simulate import simulate
from mbcheck.comparisons.reports import files as destinations
from mbcheck.reference.errors import EngineError, EngineUnavailableError, UsageError
from mbcheck.reference.hula_hoop.equations import HulaHoop
from mbcheck.tests.support.command import MAIN, invoke, process, refusal, succeeds
from mbcheck.tests.support.documents import validated

SIMULATE = "simulate hula_hoop --times 0:0.1:0.05"


pytestmark = pytest.mark.usefixtures("own_folder")


# Help and lists


@pytest.mark.parametrize("threads", ["1", "3"])
def test_linear_algebra_has_one_thread_unless_the_user_wants_more(threads: str) -> None:
    code = "import atexit, os; atexit.register(lambda: print(os.environ['OMP_NUM_THREADS']));"
    environment = {k: v for k, v in os.environ.items() if k not in THREADS}
    if threads != "1":
        environment["OMP_NUM_THREADS"] = threads
    ended = subprocess.run(
        [*MAIN[:2], f"{code} {MAIN[2]}", "list"],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    assert ended.stdout.splitlines()[-1] == threads


def test_no_verb_is_misuse() -> None:
    done = invoke("")
    assert done.exit_code == 2
    assert "Usage:" in done.stderr
    assert not done.stdout


def test_version_names_the_engines() -> None:
    text = succeeds("--version")
    assert text.startswith("mbcheck ")
    assert f"mujoco: {mujoco.__version__}" in text
    assert "exudyn: " in text


def test_list() -> None:
    text = succeeds("list")
    for word in ("hula_hoop", "implicitfast (1)", "RK67", "mujoco", "stability"):
        assert word in text


def test_list_as_json() -> None:
    overview = json.loads(succeeds("list --json -"))
    assert [engine["name"] for engine in overview["engines"]] == ["reference", "mujoco", "exudyn"]
    sheet = json.loads(succeeds("list hula_hoop --json -"))
    assert [item["name"] for item in sheet["parameters"]] == list(HulaHoop.names())
    assert {item["name"]: item["default"] for item in sheet["parameters"]} == HulaHoop().as_dict()


def test_an_engine_that_is_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> Any:
        if name == "exudyn":
            raise EngineUnavailableError("exudyn cannot be imported; apt-get install libgl1")
        return get_engine(name)

    for module in ("queries.query", "cli.catalogue", "checks.suite"):
        monkeypatch.setattr(f"mbcheck.comparisons.{module}.get_engine", missing)
    assert "libgl1" in succeeds("--version")
    assert "libgl1" in " ".join(succeeds("list").split())
    for line in ("check --engine exudyn", f"{SIMULATE} --engine exudyn"):
        assert refusal(line) == "Error: exudyn cannot be imported; apt-get install libgl1"


# Simulate


def csv_rows(text: str) -> list[list[str]]:
    """Return the rows of a CSV file below its comments."""
    return list(csv.reader(line for line in text.splitlines() if not line.startswith("#")))


def test_simulate_csv_has_every_digit() -> None:
    rows = csv_rows(succeeds(f"{SIMULATE} --csv -"))
    assert rows[0] == ["t", "y", "theta", "y_dot", "theta_dot"]
    found = simulate("hula_hoop", times=[0, 0.05, 0.1])
    values = np.array([[float(cell) for cell in row] for row in rows[1:]])
    np.testing.assert_array_equal(values.T, [found.times, *found.observables.values()])


def test_simulate_json_is_the_api() -> None:
    line = f"{SIMULATE} --engine mujoco --set rod_length=0.06 --state theta=0.5 --json -"
    document = validated("simulate", json.loads(succeeds(line)))
    found = simulate(
        "hula_hoop",
        engine="mujoco",
        parameters={"rod_length": 0.06},
        state={"theta": 0.5},
        times=[0, 0.05, 0.1],
    ).as_json()
    for name in set(document) - {"work"}:
        assert document[name] == found[name]


def test_a_long_table_is_cut() -> None:
    text = succeeds("simulate hula_hoop --times 0:1:0.01")
    assert "..." in text
    assert len(text.splitlines()) < 60


@pytest.mark.parametrize(
    ("text", "times"),
    [
        ("1", [1.0]),
        ("0.1, 0.25", [0.1, 0.25]),
        ("0:0.3:0.1", [0.0, 0.1, 0.2, 0.3]),
        ("0.5:1:0.25", [0.5, 0.75, 1.0]),
        ("0:1:0.4", [0.0, 0.4, 0.8]),
        ("0:1:0.33333333333333", [0.0, 0.33333333333333, 0.66666666666666, 0.99999999999999]),
        ("0:0.99999999999:0.333333333334", [0.0, 0.333333333334, 0.666666666668, 1.000000000002]),
        ("1e-3:2e-3:1e-3", [0.001, 0.002]),
        ("2:2:1", [2.0]),
    ],
)
def test_times(text: str, times: list[float]) -> None:
    assert times_from(text, "--times") == times


def test_a_long_range_does_not_drift() -> None:
    times = times_from("0:100:0.001", "--times")
    assert times == [i / 1000 for i in range(100_001)]


# Orbit, frequencies, export


def test_orbit() -> None:
    text = succeeds("orbit hula_hoop --json orbit.json")
    assert "Floquet multiplier" in text
    validated("orbit", json.loads(Path("orbit.json").read_text()))


def test_no_orbit() -> None:
    done = invoke("orbit hula_hoop --set force_amplitude=0.5 --json orbit.json")
    assert done.exit_code == 1
    assert done.stderr.startswith("Error: no periodic orbit of hula_hoop")
    assert len(done.stderr.splitlines()) == 1
    assert not os.listdir()


def test_frequencies() -> None:
    assert "47.14045208" in succeeds("frequencies hula_hoop --undamped")
    document = json.loads(succeeds("frequencies hula_hoop --about rod_aligned --count 2 --json -"))
    validated("frequencies", document)
    assert len(document["modes"]) == 2


def test_export() -> None:
    assert succeeds("export hula_hoop --set rod_length=0.06 -o hoop.xml") == ""
    text = Path("hoop.xml").read_text()
    assert succeeds("export hula_hoop --set rod_length=0.06 -o -") == text
    model = mujoco.MjModel.from_xml_string(text)
    assert 0.06 in model.body_ipos


# Check


def test_check_quietly_and_at_length() -> None:
    line = "check hula_hoop --engine mujoco --kind frequency"
    assert "frequency" in succeeds(line)
    short = succeeds(f"{line} -q").splitlines()
    assert any(row.startswith("PASS") for row in short)
    assert len(short) <= 2
    assert "undamped_omega_1" in succeeds(f"{line} -v")


def test_one_id_runs_one_check() -> None:
    name = "verification/hula_hoop/rest_rod_across/frequency/mujoco/tree/undamped_omega_2"
    document = json.loads(succeeds(f"check --id {name} --json -"))
    assert name in [result["id"] for result in document["results"]]
    assert {result["kind"] for result in document["results"]} == {"frequency"}


def judged(verdict: Any) -> Judged:
    """Return a made-up result."""
    prefix = "verification/hula_hoop/free_undamped/energy/mujoco/RK4"
    about = Subject(
        prefix, "verification", "mujoco", "hula_hoop", "free_undamped", "energy", "tree", "RK4"
    )
    numbers = {"value": 1.0, "reference": 0.0, "error": 1.0, "tolerance": 0.5}
    return about.result("drift", verdict, "twice its tolerance", unit="J", **numbers)


def pretend(monkeypatch: pytest.MonkeyPatch, run: Callable[..., Any]) -> None:
    """Let checks be run by this function."""
    monkeypatch.setattr(request, "run_checks", run)


def test_options_reach_the_suite(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Any] = []

    def run(checks: Any, profile: str, how: Execution, *_: Any) -> list[Judged]:
        seen.append(({check.method.name for check in checks}, profile, how.jobs, how.fail_fast))
        return [judged("pass")]

    pretend(monkeypatch, run)
    succeeds("check --kind order --method RK4 --method RK44 -j 2 --fail-fast --profile loose")
    assert seen == [({"RK4", "RK44"}, "loose", 2, True)]


def test_interrupted(monkeypatch: pytest.MonkeyPatch) -> None:
    def run(checks: Any, profile: str, how: Execution, on_result: Any, *_: Any) -> None:
        on_result([judged("pass")])
        raise KeyboardInterrupt

    pretend(monkeypatch, run)
    done = invoke("check --json r.json")
    assert done.exit_code == 130
    assert done.stderr == "Error: interrupted\n"
    assert "1 passed" in done.stdout
    assert json.loads(Path("r.json").read_text())["summary"]["total"] == 1


def test_an_engine_cannot_swallow_an_interrupt(monkeypatch: pytest.MonkeyPatch) -> None:
    def run(checks: Any, profile: str, how: Execution, on_result: Any, *_: Any) -> None:
        on_result([judged("pass")])
        try:
            os.kill(os.getpid(), signal.SIGINT)
        except KeyboardInterrupt:
            on_result([judged("error")])
        raise AssertionError("went on")

    pretend(monkeypatch, run)
    before = signal.getsignal(signal.SIGINT)
    done = invoke("check --json r.json")
    assert done.exit_code == 130
    assert json.loads(Path("r.json").read_text())["summary"]["error"] == 0
    assert signal.getsignal(signal.SIGINT) is before


def test_an_interrupt_that_ends_as_an_engine_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def stopped(**_: Any) -> None:
        try:
            os.kill(os.getpid(), signal.SIGINT)
        except KeyboardInterrupt:
            raise EngineError("raised", "SystemError") from None

    monkeypatch.setattr("mbcheck.comparisons.queries.simulate.simulate", stopped)
    assert invoke(SIMULATE).exit_code == 130


# Mistakes


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("chek", "did you mean 'check'?"),
        ("check --egine mujoco", "--engine"),
        ("check hula_hop", "did you mean 'hula_hoop'?"),
        ("check --engine mujco", "did you mean 'mujoco'?"),
        ("check --kind ordr", "did you mean 'order'?"),
        ("check --method RK5", "did you mean 'RK"),
        ("check --profile lose", "did you mean 'loose'?"),
        ("check --id nothing*", "no check"),
        ("check -q -v", "contradict"),
        ("check -j 0", "x>=1"),
        ("check -j two", "--jobs"),
        ("check --json - --junit -", "both go to standard output"),
        ("check --json r --junit ./r", "both go to"),
        ("check --json nowhere/r.json", "No such file or directory"),
        ("check --json .", "it is a folder"),
        ("simulate", "SCENE"),
        ("simulate hula_hoop", "--times"),
        ("simulate hula_hop --times 1", "did you mean 'hula_hoop'?"),
        ("simulate hula_hoop --times a", "not 'a'"),
        ("simulate hula_hoop --times 1,,2", "not ''"),
        ("simulate hula_hoop --times nan", "finite"),
        ("simulate hula_hoop --times -1,1", "before the start"),
        ("simulate hula_hoop --times 1,1", "increase"),
        ("simulate hula_hoop --times 0:1", "START:STOP:STEP"),
        ("simulate hula_hoop --times 0:1:0", "STEP must be positive"),
        ("simulate hula_hoop --times 1:0:1", "STOP not before START"),
        ("simulate hula_hoop --times 0:inf:1", "finite"),
        ("simulate hula_hoop --times 0:1e400:1", "finite"),
        ("simulate hula_hoop --times 0:x:1", "not 'x'"),
        ("simulate hula_hoop --times 0:1e9:1e-9", "more than"),
        (f"{SIMULATE} --engine mujco", "did you mean 'mujoco'?"),
        (f"{SIMULATE} --engine mujoco --method RK5", "did you mean 'RK4'?"),
        (f"{SIMULATE} --engine mujoco --step 0", "greater than 0"),
        (f"{SIMULATE} --engine mujoco --step nan", "finite"),
        (f"{SIMULATE} --engine mujoco --step 0.03", "nearest that fit are 0.03 and 0.06"),
        (f"{SIMULATE} --step 0.01", "its own steps"),
        (f"{SIMULATE} --engine exudyn --model redundnt", "did you mean 'redundant'?"),
        (f"{SIMULATE} --set main_mas=1", "did you mean 'main_mass'?"),
        (f"{SIMULATE} --set main_mass", "NAME=VALUE"),
        (f"{SIMULATE} --set =1", "NAME=VALUE"),
        (f"{SIMULATE} --set main_mass=heavy", "must be a number, not 'heavy'"),
        (f"{SIMULATE} --set main_mass=nan", "finite"),
        (f"{SIMULATE} --set main_mass=-1", "greater than 0"),
        (f"{SIMULATE} --set rod_length=0", "greater than 0"),
        (f"{SIMULATE} --set rod_length=1e300 --engine mujoco", "range of numbers"),
        (f"{SIMULATE} --set force_frequency=1e300 --engine mujoco", "steps of"),
        (f"{SIMULATE} --set free_mass=1 --set free_mass=2", "free_mass is given twice"),
        (f"{SIMULATE} --state thet=1", "did you mean 'theta'?"),
        (f"{SIMULATE} --state theta=inf", "finite"),
        (f"{SIMULATE} --state theta=1 --state theta=1", "given twice"),
        (f"{SIMULATE} --csv - --json -", "both go to standard output"),
        (f"{SIMULATE} --csv nowhere/x.csv", "cannot write 'nowhere/x.csv'"),
        ("orbit hula_hoop --engine mujoco --step 0.001", "does not divide the period"),
        ("frequencies hula_hoop --about rod", "rod_across"),
        ("frequencies hula_hoop --count 0", "x>=1"),
        ("export hula_hoop", "--output"),
        ("export hula_hoop --model tee -o x.xml", "did you mean 'tree'?"),
        ("export hula_hoop --set rod_length=-1 -o x.xml", "greater than 0"),
        ("export rigid_body --model free -o x.xml", "gravity_x, _y, _z and centre_x"),
        ("list hula_hop", "did you mean 'hula_hoop'?"),
    ],
)
def test_one_line_and_exit_2(line: str, words: str) -> None:
    message = refusal(line)
    assert message.startswith("Error: ")
    assert words in message


def test_a_failed_engine_is_exit_1() -> None:
    done = invoke("simulate hula_hoop --engine mujoco --step 0.5 --times 5 --csv x.csv")
    assert done.exit_code == 1
    assert len(done.stderr.splitlines()) == 1
    assert not os.listdir()


# Files


def test_a_file_is_replaced_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    Path("r.json").write_text("old")
    where = destinations.Destination("--json", "r.json")

    def full(*_: Any) -> None:
        raise OSError(28, "disk full")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(UsageError, match="disk full"):
        where.write("new")
    assert Path("r.json").read_text() == "old"
    assert sorted(os.listdir()) == ["r.json"]


def test_links_and_modes_are_kept() -> None:
    Path("r.json").write_text("old")
    Path("r.json").chmod(0o640)
    Path("link.json").symlink_to("r.json")
    destinations.Destination("--json", "link.json").write("new")
    assert Path("link.json").is_symlink()
    assert Path("r.json").read_text() == "new"
    assert Path("r.json").stat().st_mode & 0o777 == 0o640
    assert sorted(os.listdir()) == ["link.json", "r.json"]


@pytest.mark.skipif(not Path(os.devnull).exists(), reason="no device to write to")
def test_a_device_is_written_in_place() -> None:
    succeeds(f"{SIMULATE} --csv {os.devnull}")
    assert not Path(os.devnull).is_file()


# As a process


@pytest.mark.parametrize("engine", ["mujoco", "exudyn"])
def test_standard_output_is_pure(engine: str) -> None:
    done = process(f"{SIMULATE} --engine {engine} --json -")
    assert done.returncode == 0
    assert done.stderr == ""
    assert json.loads(done.stdout)["engine"] == engine
    assert not os.listdir()


def test_the_report_leaves_standard_output_to_the_document() -> None:
    done = process("check hula_hoop --kind frequency --json -")
    assert done.returncode == 0
    assert json.loads(done.stdout)["summary"]["error"] == 0
    assert "PASS" in done.stderr


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_reader_that_leaves(unbuffered: str) -> None:
    writer = subprocess.Popen(
        [*MAIN, "simulate", "hula_hoop", "--times", "0:1:0.0001", "--csv", "-"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONUNBUFFERED": unbuffered},
    )
    assert writer.stdout is not None
    assert writer.stdout.readline().startswith(b"# hula_hoop by reference")
    writer.stdout.close()
    _, errors = writer.communicate()
    assert (writer.returncode, errors) == (141, b"")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is full")
def test_a_full_disk() -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [*MAIN, "list"], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert (done.returncode, done.stderr) == (1, "Error: No space left on device\n")

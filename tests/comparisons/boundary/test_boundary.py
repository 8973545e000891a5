"""`mbcheck boundary`: by the reference, by engines, its document, and what it refuses."""

from __future__ import annotations

import json
import operator
import re
import subprocess
from functools import partial
from itertools import islice
from pathlib import Path
from time import sleep
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.boundary.request import BoundaryRequest
from mbcheck.comparisons.boundary.run import Boundary, executor
from mbcheck.comparisons.queries.axis import ParameterRange
from mbcheck.reference.continuation.bifurcations import DOUBLING, BifurcationCurve, CurvePoint
from mbcheck.reference.continuation.network import CurveStart
from mbcheck.reference.cost import within
from mbcheck.reference.errors import EngineError, UsageError
from mbcheck.reference.scene import Array
from mbcheck.tests.support.command import MAIN, SMALL, invoke, refusal, succeeds
from mbcheck.tests.support.documents import validated


def request(**changes: Any) -> BoundaryRequest:
    """Return what is asked for, about a loss of symmetry."""
    x, y = ("force_frequency", 5.0, 6.0), ("force_amplitude", 15.0, 35.0)
    return BoundaryRequest("hula_hoop", ParameterRange(*x), ParameterRange(*y), **changes)


# The document


def test_a_curve_crosses_the_window(folder: Path, printed: str, small: dict[str, Any]) -> None:
    (curve,) = small["curves"]
    assert curve["kind"] == "symmetry_breaking"
    assert {curve["begins"], curve["ends"]} == {"window"}
    assert not small["pending"]
    assert small["lines_done"] == small["lines"] == 2
    assert small["lines_done_of"] == {"orbits": 2}
    for point in curve["points"]:
        assert point["unstable"] == 0
        assert point["critical"]["re"] == pytest.approx(-1, abs=1e-8)
        assert max(point["x_bound_across"], point["y_bound_across"]) < 1e-8
        assert point["shift_y"] is None
        steep = abs(point["direction"][-1] * 20 / point["direction"][-2])
        vertical = point["y_bound_across"] + steep * point["x_bound_across"]
        assert point["y_bound"] == pytest.approx(vertical)
    assert re.search(r"^symmetry .*\nbreaking ", printed, re.MULTILINE)
    assert (folder / "small.png").stat().st_size > 5000


def test_a_finished_file_stays_as_it_is(folder: Path, small: dict[str, Any]) -> None:
    before = (folder / "small.json").read_bytes()
    succeeds(SMALL, "-o", folder / "small.json")
    assert (folder / "small.json").read_bytes() == before


@pytest.mark.slow
def test_a_file_does_not_depend_on_the_number_of_processes(
    folder: Path, small: dict[str, Any]
) -> None:
    succeeds(f"{SMALL} --workers 2", "-o", folder / "two.json")
    assert (folder / "two.json").read_bytes() == (folder / "small.json").read_bytes()


def test_processes_do_first_what_is_asked_for_first() -> None:
    """Also what was begun ahead; a failure is raised where it is asked for."""
    index: Any = operator.index
    numbers = [partial(index, one) for one in (0, 1, "none", 2)]
    call: Any = operator.call
    execute: Any = executor(call, 2)
    assert [execute(numbers[place:]) for place in (0, 1, 3)] == [0, 1, 2]
    with pytest.raises(EngineError, match="integer"):
        execute([partial(index, "none")])


ISLAND = "boundary hula_hoop --x force_frequency=6:7.75 --y force_amplitude=10:120 --lines 2"
"""With the tip of the island of figure 4, which lines along the window's edges pass by."""


@pytest.mark.slow
@pytest.mark.usefixtures("own_folder")
def test_an_island_is_found_from_a_place_in_it() -> None:
    """On the window's edge, from which the line goes in and, beyond a fold, out in one step."""
    missed = succeeds(f"{ISLAND} -o island.json")
    before = json.loads(Path("island.json").read_text())
    assert not any(curve["kind"] == "fold" for curve in before["curves"]), missed
    line = "map hula_hoop --quantity floquet --x force_frequency=6:7.75:9"
    line += " --y force_amplitude=10:120:9 -o map.nc --boundary island.json"
    told = succeeds(line)
    near = re.search(r"--near ([\d.,]+) looks", told)
    assert near, told
    succeeds(f"{ISLAND} -o island.json --near {near[1]}")
    after = validated("boundary", json.loads(Path("island.json").read_text()))
    ends = {curve["kind"]: {curve["begins"], curve["ends"]} for curve in after["curves"]}
    assert ends["fold"] == {"window", "with_neimark_sacker"}
    assert ends["neimark_sacker"] == {"window", "with_fold"}
    assert "but for 0 of" in succeeds(line)
    whole = Path("island.json").read_bytes()
    succeeds(f"{ISLAND} -o island.json --near {near[1]}")
    assert Path("island.json").read_bytes() == whole


def test_a_file_of_another_boundary_is_left_alone(folder: Path, small: dict[str, Any]) -> None:
    other = SMALL.replace("15:24", "15:23")
    done = invoke(other, "-o", folder / "small.json")
    assert done.exit_code == 2
    assert "another boundary (y)" in done.stderr
    assert "looks for" not in done.stderr
    assert json.loads((folder / "small.json").read_text()) == small


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("boundary hula_hoop --x torque=1:2 --y force_amplitude=5:150", "torque"),
        ("boundary hula_hoop --x force_frequency=2:2 --y force_amplitude=5:150", "lower"),
        ("boundary hula_hoop --x force_frequency=1 --y force_amplitude=5:150", "NAME=LO:HI"),
        ("boundary hula_hoop --x stiffness=1:2 --y stiffness=5:150", "two parameters"),
        ("boundary hula_hoop --x stiffness=-1:2 --y force_amplitude=5:9", "greater than 0"),
        ("boundary rotating_beam --x tip_mass=1:2 --y beam_length=5:9", "rotating_beam"),
        ("boundary nothing --x a=1:2 --y b=5:9", "nothing"),
        (f"{SMALL} --engine nobody", "nobody"),
        (f"{SMALL} --lines 1", "2 or more"),
        (f"{SMALL} --workers 0", "workers"),
        (f"{SMALL} --near 5.8", "X,Y"),
        (f"{SMALL} --near 5.8,a", "number"),
        (f"{SMALL} --near 5.8,99", "force_amplitude = 99 is not in the window, 15 to 24"),
        (f"{SMALL} --step 0.01", "reference"),
        (f"{SMALL} --set force_amplitude=3", "on an axis"),
        (f"{SMALL} --budget 0", "budget"),
        (f"{SMALL} --set gravity_x=1", "gravity"),
        (f"{SMALL} --of equilibria", "driven, and so has no equilibria; no parameter off the axes"),
        (
            "boundary hula_hoop --of equilibria --x stiffness=500:1500 --y gravity_x=-5:6",
            "no equilibria: --set force_amplitude=0",
        ),
        (f"{SMALL} --of nothing", "equilibria"),
        (
            "boundary speed_regulator --of equilibria --engine mujoco --step 0.01 --x damping=1:2 "
            "--y torque=1:2",
            "reference alone",
        ),
        (
            "boundary rigid_body --of equilibria --x mass=1:2 --y gravity_y=1:2",
            "equilibria of rigid_body are not followed",
        ),
        ("boundary hula_hoop --x gravity_x=-5:5 --y force_amplitude=15:24", "gravity"),
        (
            "boundary rotor_pendulum --model reduced --x platform_mass=9:99 --y rotor_mass=1:2",
            "reduced",
        ),
    ],
)
@pytest.mark.usefixtures("own_folder")
def test_misuse_is_one_line(line: str, words: str) -> None:
    assert words in refusal(line)


@pytest.mark.usefixtures("own_folder")
def test_a_window_without_curves_says_so() -> None:
    line = "boundary hula_hoop --x force_frequency=5.6:5.7 --y force_amplitude=15:15.5 --lines 2"
    said = "no stability changes along 2 lines"
    assert said in succeeds(f"{line} -o none.json")
    assert said in succeeds(f"{line} -o none.json")


@pytest.mark.usefixtures("own_folder")
def test_a_window_without_orbits_says_so() -> None:
    line = "boundary hula_hoop --x force_frequency=1:1.01 --y force_amplitude=1:1.1 --lines 2"
    for _ in range(2):  # the second goes on with what the first has left
        done = invoke(f"{line} -o none.json")
        assert done.exit_code == 1, done.output
        assert "no periodic orbit" in done.stderr


def test_what_was_not_looked_at_is_not_lost() -> None:
    """Bifurcations that an engine has not, and points that the reference has not."""
    pytest.importorskip("mujoco", exc_type=ImportError)
    asked = request(engine="mujoco", method="RK4", step=0.005)
    first, unit = Boundary(asked), np.eye(6)
    point = CurvePoint(unit[4] / 2, unit[5], np.zeros(4), 0j, np.zeros(3), np.zeros(2))
    first.networks["orbits"].curves.append(
        BifurcationCurve(DOUBLING, 1, [point], ("window", "window"), shifts=[np.full(2, np.nan)])
    )
    first.networks["orbits"].missing = 1
    before = validated("boundary", first.as_json())
    assert before["curves"][0]["points"][0]["shift_y"] is None
    second = Boundary(asked)
    second.restore(before)
    assert second.as_json()["missing"] == 1
    (curve,) = second.networks["orbits"].curves
    assert np.all(np.isnan(curve.shifts))


def test_a_curve_that_begins_where_another_ends_is_gone_on_with() -> None:
    first, second, unit = Boundary(request(lines=2)), Boundary(request(lines=2)), np.eye(6)
    side = np.array([0.6, 0.8])
    point = CurvePoint(unit[4] / 2, unit[5], np.zeros(4), 0j, np.zeros(3), np.zeros(2), side)
    first.networks["orbits"].starts.append(CurveStart(DOUBLING, 1, point, "with_fold"))
    before = validated("boundary", first.as_json())
    second.restore(before)
    (start,) = second.networks["orbits"].starts
    assert start.begins == before["pending"][0]["begins"] == "with_fold"
    np.testing.assert_array_equal(start.point.side, side)


@pytest.mark.usefixtures("own_folder")
def test_a_broken_file_is_refused() -> None:
    Path("broken.json").write_text("{}")
    assert "--output: 'broken.json' is no boundary" in refusal(f"{SMALL} -o broken.json")
    window = "--x force_frequency=5.6:6:6 --y force_amplitude=15:24:6"
    line = f"map hula_hoop --quantity floquet {window} -o map.nc --boundary"
    assert "--boundary: cannot read '.'" in refusal(f"{line} .")
    assert "--boundary: 'broken.json' is no boundary" in refusal(f"{line} broken.json")


# Equilibria

REST = (
    "boundary hula_hoop --x stiffness=500:1500 --y gravity_x=-5:6 --set force_amplitude=0 --lines 2"
)
"""Where gravity turns the rod over."""


@pytest.mark.usefixtures("own_folder")
def test_equilibria_are_followed_and_gone_on_with() -> None:
    printed = succeeds(f"{REST} -o rest.json --plot rest.png")
    assert "branch point of equilibria" in printed
    before = Path("rest.json").read_bytes()
    text = validated("boundary", json.loads(before))
    assert text["of"] == ["equilibria"]
    (curve,) = text["curves"]
    assert {curve["begins"], curve["ends"]} == {"window"}
    for point in curve["points"]:
        assert point["y"] == pytest.approx(0, abs=1e-12)
        assert (point["period"], point["multipliers"]) == (None, [])
        assert abs(point["critical"]["re"]) < 1e-9
        assert min(value["re"] for value in point["eigenvalues"]) < -0.1
    succeeds(f"{REST} -o rest.json")
    assert Path("rest.json").read_bytes() == before
    asked = BoundaryRequest(
        "hula_hoop",
        ParameterRange("stiffness", 500.0, 1500.0),
        ParameterRange("gravity_x", -5.0, 6.0),
        parameters={"force_amplitude": 0.0},
        lines=2,
    )
    half = Boundary(asked)
    next(half.work())
    state = half.as_json()
    start = state["pending"][0]
    assert start["of"] == "equilibria"
    rest = Boundary(asked)
    rest.restore(state)
    assert [*rest.work()]
    ends = [p["x"] for p in rest.as_json()["curves"][0]["points"]]
    assert ends == pytest.approx([p["x"] for p in curve["points"]])


# Engines


@pytest.mark.slow
@pytest.mark.parametrize(
    ("engine", "shift", "room"), [("mujoco", 1.87e-6, 2e-8), ("exudyn", 0, 2e-9)]
)
def test_the_lower_bound_of_figure_6_is_followed_by_engines(
    engine: str, shift: float, room: float
) -> None:
    """The end of the lower bound of figure 6, with 200 steps in a period."""
    pytest.importorskip(engine, exc_type=ImportError)
    x, y = ("force_frequency", 9.0, 10.0), ("force_amplitude", 15.0, 60.0)
    asked = BoundaryRequest(
        "hula_hoop", ParameterRange(*x), ParameterRange(*y), engine=engine, step=1 / 9 / 200,
        parameters={"inertia_ratio": 1.7758262}, lines=2,
    )  # fmt: skip
    assert asked.steps_per_period == 200
    result = Boundary(asked)
    for _ in result.work():
        if result.networks["orbits"].curves:
            break
    points = result.as_json()["curves"][0]["points"]
    (last,) = (point for point in points if abs(point["x"] - 10) < 1e-9)
    assert last["y"] == pytest.approx(44.92653, abs=1e-4)
    assert last["shift_y"] == pytest.approx(shift, abs=room)


Pair = tuple[float, float]

STRETCHES = (
    pytest.param("symmetry_breaking", (4.8, 5.2), (22.0, 34.0), (), marks=pytest.mark.slow),
    pytest.param("period_doubling", (5.2, 5.6), (24.0, 38.0), (), marks=pytest.mark.slow),
    pytest.param("neimark_sacker", (8.0, 9.0), (7.0, 16.0), (), marks=pytest.mark.slow),
    pytest.param("fold", (6.65, 6.75), (120.0, 138.0), ((6.7, 135.0),), marks=pytest.mark.campaign),
)
"""Of curves of figure 4, windows that they cross, and places of orbits that no guess is near; folds
of engines are those of figure 3 of rotor_pendulum in slow tests.
"""


@pytest.mark.parametrize(("kind", "x", "y", "near"), STRETCHES)
def test_all_of_an_engines_curve_converges_with_its_order(
    kind: str, x: Pair, y: Pair, near: tuple[Pair, ...]
) -> None:
    pytest.importorskip("mujoco", exc_type=ImportError)
    places, shifts = zip(*(stretch(kind, x, y, near, steps) for steps in (40, 80)), strict=True)
    orders = np.log2(shifts[0] / np.interp(places[0], places[1], shifts[1]))
    assert len(orders) > 2
    np.testing.assert_allclose(orders, 4, atol=0.4)


def stretch(kind: str, x: Pair, y: Pair, near: tuple[Pair, ...], steps: int) -> tuple[Array, Array]:
    """Return x along a curve by RK4 with so many steps in the longest period, and shifts of y."""
    axes = ParameterRange("force_frequency", *x), ParameterRange("force_amplitude", *y)
    asked = BoundaryRequest(
        "hula_hoop", *axes, engine="mujoco", step=1 / x[0] / steps, lines=2, near=near
    )
    assert asked.middle.integrator.name == "RK4"
    assert asked.steps_per_period == steps
    result = Boundary(asked)
    assert [*result.work()]
    curves = validated("boundary", result.as_json())["curves"]
    (curve,) = (item for item in curves if item["kind"] == kind)
    pairs = sorted((point["x"], point["shift_y"]) for point in curve["points"])
    return np.array(pairs).T[0], np.array(pairs).T[1]


# A kill


@pytest.mark.slow
def test_a_killed_run_keeps_what_it_had_and_ends_the_same(
    folder: Path, small: dict[str, Any], tmp_path: Path
) -> None:
    """A curve that was only begun is followed from just the same numbers: the same to the byte."""
    path = tmp_path / "killed.json"
    begun = subprocess.Popen([*MAIN, *SMALL.split(), "-o", str(path)])
    while not path.exists():
        assert begun.poll() is None
        sleep(0.01)
    begun.kill()
    begun.wait()
    before = validated("boundary", json.loads(path.read_text()))
    assert before["lines_done"] > 0
    succeeds(SMALL, "-o", path)
    assert path.read_bytes() == (folder / "small.json").read_bytes()


def test_what_was_written_between_two_parts_leads_to_the_same(small: dict[str, Any]) -> None:
    """The last curve of a window is followed from its start on, as the file has it."""
    asked = BoundaryRequest(
        "hula_hoop",
        ParameterRange("force_frequency", 5.6, 6.0),
        ParameterRange("force_amplitude", 15.0, 24.0),
        lines=2,
    )
    first = Boundary(asked)
    assert len([*islice(first.work(), 2)]) == 2  # both lines
    state = json.loads(json.dumps(first.as_json()))
    assert state["pending"]
    second = Boundary(asked)
    second.restore(state)
    assert json.loads(json.dumps(second.as_json()))["pending"] == state["pending"]
    next(second.work())
    curve = json.loads(json.dumps(second.as_json()))["curves"][0]
    assert curve == small["curves"][0]


def test_states_of_rest_are_sought_within_the_budget() -> None:
    x, y = ParameterRange("damping", 1.0, 1e6), ParameterRange("torque", 0.01, 1e3)
    asked = BoundaryRequest("speed_regulator", x, y, of="equilibria")
    with pytest.raises(UsageError, match="budget"), within(1e-6):
        _ = asked.tracer("equilibria").units

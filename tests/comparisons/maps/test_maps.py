"""Maps as such: blocks, executors, files, resuming, refinement, comparison."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from multiprocessing import active_children
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.maps import compare, execute, run, store
from mbcheck.comparisons.maps.request import Axis, Request, quantities, resolved
from mbcheck.comparisons.maps.store import Map
from mbcheck.comparisons.scenes.quantity import Quantity, QuantityValues, Variable
from mbcheck.reference import solve as backends
from mbcheck.reference.errors import MbcheckError, UnknownNameError, UsageError
from mbcheck.tests.support.command import MAIN, invoke
from mbcheck.tests.support.documents import validated

X, Y = Axis("force_frequency", 1.0, 10.0, 12), Axis("force_amplitude", 5.0, 150.0, 12)
FLOQUET = resolved(Request("hula_hoop", "floquet", X, Y, model="paper", block=9))
LINE = (
    "map hula_hoop --quantity floquet --x force_frequency=1:10:12 --y force_amplitude=5:150:12 "
    "--block 9 --model paper"
)


@pytest.fixture(scope="module")
def serial() -> Map:
    return run.compute(FLOQUET)


def misused(line: str) -> str:
    done = invoke(line)
    assert done.exit_code == 2, done.output
    assert "Traceback" not in done.output
    return " ".join(done.stderr.split())


# Executors


def children() -> list[int]:
    return [child.pid for child in active_children() if child.pid]


def test_work_that_kills_every_process_is_given_up() -> None:
    with pytest.raises(MbcheckError, match="died 3 times"):
        list(execute.in_processes(2, os.system, ["kill -9 $PPID"] * 2))


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as found:
        yield found


@pytest.mark.slow
def test_cluster_with_a_killed_worker_gives_the_serial_map(
    cluster: Any, serial: Map, tmp_path: Path
) -> None:
    done: list[int] = []
    nannies = [nanny.pid for nanny in cluster.workers.values()]

    def kill_one(points: int, total: int) -> None:
        if len(done) == 2:
            os.kill(nannies[0], signal.SIGKILL)
        done.append(points)

    found = run.compute(FLOQUET, dask=cluster.scheduler_address, progress=kill_one)
    assert store.to_bytes(found) == store.to_bytes(serial)
    assert done[-1] == 144
    wait_for(lambda: [nanny.pid for nanny in cluster.workers.values()] != nannies)  # it did die


def test_cluster_that_is_not_there() -> None:
    cluster = execute.on_cluster("tcp://127.0.0.1:9", patience=0.5)
    with pytest.raises(UsageError, match="no Dask scheduler answers"):
        cluster.__enter__()


def test_processes_give_the_serial_map_with_one_killed(serial: Map) -> None:
    killed: list[int] = []

    def kill_one(points: int, total: int) -> None:
        if not killed:
            killed.append(children()[0])
            os.kill(killed[0], signal.SIGKILL)

    found = run.compute(FLOQUET, workers=2, progress=kill_one)
    assert killed
    assert store.to_bytes(found) == store.to_bytes(serial)


# Files


def test_file_is_read_back(serial: Map, tmp_path: Path) -> None:
    path = tmp_path / "map.nc"
    serial.save(path)
    found = mbcheck.read_map(path)
    assert (found.x, found.y, found.settings) == (serial.x, serial.y, serial.settings)
    assert dict(found.about) == dict(serial.about)
    for name, values in serial.variables.items():
        np.testing.assert_array_equal(found.variables[name], values)
    assert np.all(found.computed)


def test_file_opens_in_xarray_with_units_and_classes(serial: Map, tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray")
    path = tmp_path / "map.nc"
    path.write_bytes(store.to_bytes(serial))
    with xarray.open_dataset(path) as found:
        assert found["multiplier"].dims == ("force_amplitude", "force_frequency")
        assert found["force_frequency"].units == "Hz"
        assert found["stability"].flag_meanings.split()[1:3] == ["stable", "unstable"]
        assert list(found["stability"].flag_values[:2]) == [-1, 0]
        near = found["multiplier"].sel(force_frequency=3, force_amplitude=60, method="nearest")
        assert np.isfinite(near)


@pytest.mark.parametrize("content", [b"", b"CDF\x02 broken", b"text", None])
def test_broken_file_is_refused(content: bytes | None, tmp_path: Path) -> None:
    path = tmp_path / "map.nc"
    if content is not None:
        path.write_bytes(content)
    assert str(path) in misused(f"compare-maps {path} {path}")


# Interruption


def wait_for(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def interrupted(asked: Request, unfinished: Path, points: int) -> Map:
    """Return what a map has kept that was interrupted after so many points."""

    def interrupt(done: int, total: int) -> None:
        if done > points:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run.compute(asked, unfinished=unfinished, progress=interrupt)
    return store.read(unfinished)


def test_interrupted_map_is_resumed(
    serial: Map, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, unfinished = tmp_path / "map.nc", tmp_path / "map.nc.unfinished"
    kept = interrupted(FLOQUET, unfinished, 50)
    assert 40 < kept.computed.sum() < 60
    line = f"{LINE} -o {path}"
    assert "--resume" in misused(line)
    assert "of another map (y)" in misused(line.replace("=5:150", "=6:150") + " --resume")
    assert "of another map (parameters)" in misused(f"{line} --set inertia_ratio=1 --resume")
    done = invoke(line, "--resume")
    assert done.exit_code == 0, done.output
    assert path.read_bytes() == store.to_bytes(serial)
    assert not unfinished.exists()
    run.compute(FLOQUET, unfinished=unfinished)
    monkeypatch.setattr(run, "evaluate", lambda *_: pytest.fail("computed again"))
    again = run.compute(FLOQUET, unfinished=unfinished, resume=True)
    assert store.to_bytes(again) == store.to_bytes(serial)


@pytest.mark.slow
@pytest.mark.parametrize("kill", [signal.SIGKILL, signal.SIGINT])
def test_a_killed_map_is_resumed(kill: signal.Signals, tmp_path: Path) -> None:
    path, unfinished = tmp_path / "map.nc", tmp_path / "map.nc.unfinished"
    line = f"{LINE} -o {path}".replace("--model paper", "--engine mujoco").replace(":12", ":6")
    begun = subprocess.Popen(
        [*MAIN, *line.split()],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # a job may ignore it
    )
    wait_for(unfinished.exists)
    begun.send_signal(kill)
    _, words = begun.communicate(timeout=60)
    assert begun.returncode == (130 if kill == signal.SIGINT else -signal.SIGKILL)
    assert "Traceback" not in words
    assert not path.exists()
    assert 0 < store.read(unfinished).computed.sum() < 36
    whole = tmp_path / "whole.nc"
    for words in (f"{line} --resume", line.replace(str(path), str(whole))):
        assert invoke(words).exit_code == 0
    assert path.read_bytes() == whole.read_bytes()
    assert not unfinished.exists()


# Refinement


def half_plane(points: Any) -> QuantityValues:
    """Return a disc, which no real quantity is so cheap as."""
    x, y = points.values["force_frequency"], points.values["force_amplitude"]
    inside = np.hypot(x - 5, (y - 70) / 16) < 3
    return QuantityValues({"inside": inside.astype(int), "radius": np.hypot(x - 5, (y - 70) / 16)})


DISC = Quantity(
    "a disc",
    {"inside": Variable("1", "of the disc", ("no", "yes")), "radius": Variable("1", "from it")},
    half_plane,
)


@pytest.fixture
def disc(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Request]:
    monkeypatch.setitem(dict_of("hula_hoop"), "disc", DISC)

    def asked(count: int, **more: Any) -> Request:
        axes = Axis("force_frequency", 1, 10, count), Axis("force_amplitude", 5, 150, count)
        return resolved(Request("hula_hoop", "disc", *axes, **more))

    return asked


def dict_of(scene: str) -> dict[str, Quantity]:
    found = quantities(scene)
    assert isinstance(found, dict)
    return found


@pytest.mark.parametrize("count", [30, 64, 129, 257])
def test_refined_map_equals_the_whole_one(count: int, disc: Callable[..., Request]) -> None:
    whole = run.compute(disc(count))
    refined = run.compute(disc(count, refine=True))
    np.testing.assert_array_equal(refined.variables["inside"], whole.variables["inside"])
    shown = refined.computed
    np.testing.assert_array_equal(
        refined.variables["radius"][shown], whole.variables["radius"][shown]
    )
    assert np.mean(shown) < {30: 0.45, 64: 0.25, 129: 0.15, 257: 0.08}[count]
    assert refined.shares() != whole.shares()  # of the computed points alone


def test_an_interrupted_refinement_goes_on_to_the_same(
    disc: Callable[..., Request], tmp_path: Path
) -> None:
    asked = disc(129, refine=True)
    whole = run.compute(asked)
    kept = interrupted(asked, tmp_path / "a", 1300)
    assert 1000 < kept.computed.sum() < whole.computed.sum()
    again = run.compute(asked, unfinished=tmp_path / "a", resume=True)
    assert store.to_bytes(again) == store.to_bytes(whole)


def test_a_thin_arm_is_followed_by_many_cells_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is a cell wide: a coarse lattice sees no more of it than the disc at its end."""
    counts: list[int] = []

    def arm(points: Any) -> QuantityValues:
        x, y = points.values["force_frequency"] - 5, (points.values["force_amplitude"] - 70) / 16
        radius, angle = np.hypot(x, y), np.arctan2(y, x)
        on_arm = (abs(radius - 3) < 0.01) & (angle > -2)
        counts.append(len(x))
        return QuantityValues({"inside": (on_arm | (np.hypot(x + 3, y) < 0.6)).astype(int)})

    inside = {"inside": Variable("1", "of the arm", ("no", "yes"))}
    monkeypatch.setitem(dict_of("hula_hoop"), "arm", Quantity("an arm", inside, arm))
    axes = Axis("force_frequency", 1, 10, 513), Axis("force_amplitude", 5, 150, 513)
    whole = run.compute(resolved(Request("hula_hoop", "arm", *axes)))
    counts.clear()
    refined = run.compute(resolved(Request("hula_hoop", "arm", *axes, refine=True)))
    np.testing.assert_array_equal(refined.variables["inside"], whole.variables["inside"])
    assert len(counts) < 100  # 372 without
    assert sum(counts) < 0.1 * whole.computed.size


def test_refining_what_has_no_classes_is_refused() -> None:
    axes = Axis("n_x", 2, 3, 4), Axis("n_phi", 2, 3, 4)
    with pytest.raises(UsageError, match="follows the boundaries of classes"):
        resolved(Request("rotor_pendulum", "coupling", *axes, refine=True))


# Comparison


def test_map_agrees_with_itself(serial: Map) -> None:
    found = compare.compare(serial, serial)
    assert found.agreement == 1
    assert found.offsets.size == 0
    assert sum(sum(row.values()) for row in found.confusion.values()) == found.points == 144
    validated("compare_maps", found.as_json())
    numbers = compare.compare(serial, serial, "multiplier").as_json()
    assert validated("compare_maps", numbers)["difference"]["largest"] == 0


def test_shifted_boundary_is_measured(disc: Callable[..., Request]) -> None:
    whole = run.compute(disc(65))
    moved = dict(whole.variables)
    moved["inside"] = np.roll(whole.variables["inside"], 3, axis=1)
    other = Map(whole.x, whole.y, moved, whole.about, whole.computed, whole.settings)
    found = compare.compare(whole, other)
    wrong = int(np.sum(whole.variables["inside"] != moved["inside"]))
    assert found.agreement == pytest.approx(1 - wrong / 65**2)
    assert found.confusion["yes"]["no"] + found.confusion["no"]["yes"] == wrong
    assert np.max(found.offsets) == 3
    assert found.as_json()["confusion"]["yes"]["no"] == wrong / 2


def test_points_that_are_not_robust_count_apart(serial: Map) -> None:
    values = dict(serial.variables)
    values["stability"] = serial.variables["stability"].copy()
    values["robust"] = np.ones_like(serial.variables["robust"])
    values["stability"][0, 0] = 1 - values["stability"][0, 0] % 2
    values["robust"][0, 0] = 0
    other = Map(serial.x, serial.y, values, serial.about, serial.computed, serial.settings)
    found = compare.compare(serial, other)
    assert found.agreement is not None
    assert found.agreement < 1
    assert found.robust_agreement == 1


def test_coarse_and_fine_grids_share_points(disc: Callable[..., Request]) -> None:
    fine, coarse = run.compute(disc(65)), run.compute(disc(17))
    found = compare.compare(fine, coarse)
    assert found.one.shape == (17, 17)
    assert found.agreement == 1
    with pytest.raises(UsageError, match="no point in common"):
        compare.compare(fine, _elsewhere(coarse))


def _elsewhere(found: Map) -> Map:
    x = Axis(found.x.name, 1.01, 10.01, found.x.count)
    return Map(x, found.y, found.variables, found.about, found.computed, found.settings)


def test_angles_are_compared_on_the_circle() -> None:
    x = np.array([0.0, 1.0])
    off = compare.MapComparison(
        "alpha", "rad", (), x, x[:1], np.array([[3.1, 0.0]]), np.array([[-3.1, 0.1]]),
        np.ones((1, 2), bool), np.ones((1, 2), bool), ("a", "b"),
    )  # fmt: skip
    np.testing.assert_allclose(off.differences, [2 * np.pi - 6.2, 0.1])


def test_maps_of_other_things_are_refused(serial: Map, disc: Callable[..., Request]) -> None:
    with pytest.raises(UsageError, match="not of the same quantity"):
        compare.compare(serial, run.compute(disc(12)))
    with pytest.raises(UnknownNameError, match="did you mean 'multiplier'"):
        compare.compare(serial, serial, "multiplyer")


# Engines' failures


def test_failed_points_are_told(tmp_path: Path) -> None:
    """An oscillation far too fast for the step: MuJoCo's clock body explodes, and says so."""
    axes = Axis("force_frequency", 1.0, 40.0, 2), Axis("force_amplitude", 5.0, 150.0, 2)
    asked = resolved(
        Request("hula_hoop", "floquet", *axes, engine="mujoco", method="Euler", step=0.06)
    )
    found = run.compute(asked)
    assert len(found.problems) >= 1
    path = tmp_path / "map.nc"
    path.write_bytes(store.to_bytes(found))
    assert store.read(path).problems == found.problems


# Misuse


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ("hula_hop", "did you mean 'hula_hoop'"),
        ("--quantity floket", "did you mean 'floquet'"),
        ("--engine mujco", "did you mean 'mujoco'"),
        ("--model exakt", "did you mean 'exact'"),
        ("--method RK4", "the reference has none"),
        ("--x force_frequency=1:10", "NAME=LO:HI:N"),
        ("--x force_frequency=1:ten:3", "must be a number"),
        ("--x force_frequency=10:1:3", "lower to a higher"),
        ("--x force_frequency=1:nan:3", "lower to a higher"),
        ("--x force_frequency=1:1_0:3", "must be a number"),
        ("--x force_frequency=1:10:\u0663", "whole number N"),
        ("--x force_frequency=1:10:1", "2 values or more"),
        ("--x force_frequency=-1:10:3", "greater than 0"),
        ("--x frequency=1:10:3", "did you mean 'force_frequency'"),
        ("--x force_amplitude=1:10:3", "both axes"),
        ("--x force_frequency=1:10:99999", "more points"),
        ("--set force_frequency=3", "is on an axis"),
        ("--set rod_length=-1", "greater than 0"),
        ("--block 0", "1 point or more"),
        ("--step -1", "greater than 0"),
        ("--plot a.jpg", "ends in .png or .svg"),
        ("--workers 2 --dask tcp://127.0.0.1:9", "contradict"),
    ],
)
def test_misuse_is_told_in_one_line(
    changed: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    line = (
        LINE.replace(":12", ":99999") + " -o map.nc" if "99999" in changed else f"{LINE} -o map.nc"
    )
    option, _, value = changed.partition(" ")
    if option.startswith("--"):
        line = f"{line} {option} {value}"
    else:
        line = line.replace("hula_hoop", changed)
    assert words in misused(line)
    assert not list(tmp_path.iterdir())


def test_a_backend_that_is_not_there_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(UsageError, match="known: auto, numpy, heyoka"):
        backends.takes_heyoka("jax")
    monkeypatch.setattr(backends, "find_spec", lambda name: None)
    with pytest.raises(UsageError, match=r"mbcheck\[fast\]"):
        backends.takes_heyoka("heyoka")
    assert not backends.takes_heyoka("auto")


@pytest.mark.skipif(find_spec("heyoka") is None, reason="heyoka is not installed")
def test_compiled_steps_keep_the_bounds_of_a_map_which_says_so() -> None:
    axes = Axis("force_frequency", 2, 9, 4), Axis("force_amplitude", 20, 140, 4)
    made = [
        run.compute(resolved(Request("hula_hoop", "floquet", *axes, backend=backend)))
        for backend in ("numpy", "heyoka")
    ]
    plain, compiled = (one.variables for one in made)
    np.testing.assert_array_equal(plain["stability"], compiled["stability"])
    for name in ("multiplier", "u_1", "min_speed"):
        off = np.abs(plain[name] - compiled[name])
        assert np.nanmax(off / (plain[f"{name}_bound"] + compiled[f"{name}_bound"])) < 1
    assert [one.settings.get("backend") for one in made] == [None, "heyoka"]


def test_a_map_that_does_not_begin_leaves_nothing(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    assert "no Dask scheduler" in misused(f"{LINE} -o {tmp_path / 'map.nc'} --dask garbage")
    assert list(tmp_path.iterdir()) == []

"""Engines that crash, hang or eat memory are contained, and the others go on."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from multiprocessing import active_children, forkserver
from multiprocessing.util import get_temp_dir
from pathlib import Path
from threading import Timer
from typing import Any

import pytest

from mbcheck.comparisons.check.request import check
from mbcheck.comparisons.engines import THREADS, isolation
from mbcheck.comparisons.engines.isolation import isolated
from mbcheck.reference.errors import EngineError, UsageError
from mbcheck.tests.support.engines import hostile

LINUX = pytest.mark.skipif(not isolation.STATM.exists(), reason="memory cannot be limited here")

SECONDS, MEGABYTES = 300.0, 256.0
"""Limits of calls; that of the time ends what hangs by mistake."""


@pytest.fixture(autouse=True)
def _no_engine_of_another_test() -> None:
    """End processes that hold engines for tests that ran before."""
    for child in active_children():
        child.kill()
        child.join()


def told(found: Any) -> tuple[str, str]:
    assert isinstance(found, EngineError), found
    return found.kind, found.message


def hold(calls: list[Callable[[], Any]], **options: Any) -> list[Any]:
    """Return the results in the order of the calls."""
    found = dict(isolated(calls, **options))
    assert not active_children()
    assert len(found) == len(calls)
    return [found[index] for index in range(len(calls))]


ONE_THREAD = """
import functools, os, numpy
from mbcheck.comparisons.engines.isolation import isolated
if __name__ == "__main__":
    threads = functools.partial(os.getenv, "OPENBLAS_NUM_THREADS")
    print(dict(isolated([threads], 1))[0], threads())
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no server of processes")
def test_processes_of_a_caller_with_more_threads_have_one() -> None:
    environment = {k: v for k, v in os.environ.items() if k not in THREADS}
    done = subprocess.run(
        [sys.executable, "-c", ONE_THREAD],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split() == ["1", "None"]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no server of processes")
def test_a_temporary_folder_may_have_a_long_name(tmp_path: Path) -> None:
    scratch = tmp_path / ("long" * 25)
    scratch.mkdir()
    done = subprocess.run(
        [sys.executable, "-c", ONE_THREAD],
        env=os.environ | {"TMPDIR": str(scratch)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")


@LINUX
def test_each_is_told_and_the_others_go_on() -> None:
    calls: list[Callable[[], Any]] = [
        os.getpid, os.abort, os.getpid, hostile.eat, hostile.leave,
        hostile.read_nothing, partial(int, "x"), os.getpid,
    ]  # fmt: skip
    first, abort, second, eaten, left, fault, raised, last = hold(
        calls, jobs=2, seconds=SECONDS, megabytes=MEGABYTES
    )
    assert all(isinstance(pid, int) and pid != os.getpid() for pid in (first, second, last))
    assert told(abort)[0] == "crashed"
    assert "SIGABRT" in told(abort)[1]
    assert told(eaten)[0] == "memory"
    assert "limited to 256 MB" in told(eaten)[1]
    assert told(left) == ("crashed", "the engine took its process down with it: exit code 3")
    assert "SIGSEGV (its memory was limited to 256 MB" in told(fault)[1]
    assert told(raised)[0] == "raised"
    assert "ValueError" in told(raised)[1]


@LINUX
def test_what_does_not_end_is_stopped_and_the_others_go_on() -> None:
    first, spin, last = hold([os.getpid, hostile.spin, os.getpid], jobs=1, seconds=2.0)
    assert all(isinstance(pid, int) and pid != os.getpid() for pid in (first, last))
    assert told(spin) == ("timeout", "stopped: it had not ended after 2 s")


def test_a_process_is_used_again_and_a_group_stays_with_it() -> None:
    found = hold([os.getpid] * 3, jobs=1)
    assert len(set(found)) == 1
    groups = [[0, 2], [1, 3]]
    pids = dict(isolated([os.getpid] * 4, jobs=2, groups=groups))
    assert pids[0] == pids[2] != pids[1] == pids[3]
    assert not active_children()


@LINUX
def test_the_limit_of_memory_is_of_each_call() -> None:
    lengths = hold([partial(hostile.megabytes, 200)] * 3, jobs=1, megabytes=MEGABYTES)
    assert lengths == [200 << 20] * 3


def test_nothing_is_left_when_the_caller_goes_away() -> None:
    arriving = isolated([os.getpid, hostile.hang, hostile.hang], jobs=2)
    next(arriving)
    assert active_children()
    arriving.close()
    assert not active_children()


@pytest.mark.parametrize(
    "limits", [{"seconds": 0.0}, {"seconds": float("nan")}, {"megabytes": -1.0}]
)
def test_impossible_limits_are_refused(limits: dict[str, Any]) -> None:
    with pytest.raises(UsageError, match="limit must be greater than 0"):
        list(isolated([os.getpid], jobs=1, **limits))


def test_where_memory_cannot_be_limited_it_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(isolation, "STATM", Path("/nowhere"))
    with pytest.raises(UsageError, match="on Linux only"):
        check(["hula_hoop"], ["mujoco"], memory_limit=100.0)


# The same through the command line, in processes that know the engine


@pytest.fixture
def environment(tmp_path: Path) -> dict[str, str]:
    """Return the environment in which every Python process knows the hostile engine."""
    (tmp_path / "sitecustomize.py").write_text(
        "from mbcheck.tests.support.engines.hostile import register\nregister()\n"
    )
    path = os.pathsep.join(filter(None, (str(tmp_path), os.environ.get("PYTHONPATH"))))
    return os.environ | {"PYTHONPATH": path}


def command(*options: str) -> list[str]:
    main = "from mbcheck.comparisons.cli import main; main()"
    case = ("check", "--engine", "hostile", "--id", "*/spinning_unforced/trajectory/*/theta")
    return [sys.executable, "-c", main, *case, *options]


def verdicts(environment: dict[str, str], *options: str) -> tuple[dict[str, tuple[str, str]], int]:
    report = Path(environment["PYTHONPATH"].split(os.pathsep)[0]) / "report.json"
    done = subprocess.run(
        command("--json", str(report), *options), env=environment, capture_output=True, text=True
    )
    said = [line for line in done.stderr.splitlines() if " checks, " not in line]  # its progress
    assert not said, done.stderr
    results = json.loads(report.read_text())["results"]
    return {
        item["method"]: (item["verdict"], item["reason"])
        for item in results
        if item["quantity"] == "theta"
    }, done.returncode


@LINUX
@pytest.mark.slow
def test_checks_of_a_hostile_engine(environment: dict[str, str]) -> None:
    limits = ("--time-limit", "8", "--memory-limit", "400", "-j", "3")
    found, code = verdicts(environment, *limits)
    assert code == 1
    assert found.pop("RK4")[0] == "pass"
    assert {verdict for verdict, _ in found.values()} == {"error"}
    words = {
        "abort": "crashed: the engine took its process down with it: SIGABRT",
        "leave": "exit code 3",
        "hang": "timeout: stopped: it had not ended after 8 s",
        "spin": "timeout",
        "eat": "MemoryError",
    }
    for method, reason in words.items():
        assert reason in found[method][1]


def test_one_process_without_limits_is_this_one(environment: dict[str, str]) -> None:
    found, code = verdicts(environment, "--method", "RK4", "-j", "1")
    assert (found["RK4"][0], code) == ("pass", 0)


def alive(session: int) -> list[int]:
    """Return the processes of a session that have not ended."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # it has just gone
            state, _, _, itself = stat.read_text().rpartition(")")[2].split()[:4]
            found += [int(stat.parent.name)] if int(itself) == session and state != "Z" else []
    return found


@LINUX
@pytest.mark.slow
@pytest.mark.parametrize(
    ("how", "code"),
    [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGKILL, -signal.SIGKILL)],
)
def test_no_process_outlives_the_program(
    environment: dict[str, str], how: signal.Signals, code: int, tmp_path: Path
) -> None:
    report = tmp_path / "report.json"
    line = command("--method", "hang", "--time-limit", "600", "--json", str(report))
    begun = subprocess.Popen(line, env=environment, stderr=subprocess.PIPE, start_new_session=True)
    while len(alive(begun.pid)) < 4:  # itself, the fork server, its tracker, the worker
        time.sleep(0.1)
    time.sleep(2)
    os.kill(begun.pid, how)
    assert begun.wait(60) == code
    if code > 0:  # what was done is written
        assert json.loads(report.read_text())["results"] == []
    late = time.monotonic() + 60
    while alive(begun.pid):  # the fork server sees that nobody is left, and goes
        assert time.monotonic() < late
        time.sleep(0.1)


CHILDREN = {
    "its own": ("exec", {}),
    "in a session of its own": ("exec", {"start_new_session": True}),
    "whose parent has ended": ("setsid", {}),
}


def sleeping_child(how: str) -> int:
    """Return the number of a process that this one has started and left behind."""
    prefix, options = CHILDREN[how]
    line = f"{prefix} {sys.executable} -c 'import os, time; print(os.getpid()); time.sleep(600)'"
    text = f"{line} &" if prefix == "setsid" else line
    child = subprocess.Popen(["sh", "-c", text], stdout=subprocess.PIPE, text=True, **options)  # type: ignore[call-overload]
    return int(child.stdout.readline())


@LINUX
@pytest.mark.parametrize("how", CHILDREN)
def test_children_of_an_engine_end_with_its_process(how: str) -> None:
    (child,) = hold([partial(sleeping_child, how)], jobs=1)
    late = time.monotonic() + 60
    while (
        Path(f"/proc/{child}/stat").exists()
        and " Z " not in Path(f"/proc/{child}/stat").read_text()
    ):
        assert time.monotonic() < late
        time.sleep(0.05)


def lose_socket() -> None:
    """Empty the temporary folder in which the server of processes listens."""
    for one in Path(get_temp_dir()).iterdir():
        one.unlink()


def end_server() -> None:
    """Stop the server of processes, and end it while it is waited for."""
    pid = forkserver._forkserver._forkserver_pid  # type: ignore[attr-defined]
    os.kill(pid, signal.SIGSTOP)
    Timer(0.5, os.kill, (pid, signal.SIGKILL)).start()


@LINUX
@pytest.mark.parametrize("deed", [lose_socket, end_server])
def test_processes_start_without_their_server(deed: Callable[[], None]) -> None:
    """What it raised was taken for Ctrl-C, or was a traceback."""
    assert len(hold([os.getpid], jobs=1)) == 1
    try:
        deed()
        assert len(hold([os.getpid], jobs=1)) == 1
    finally:
        with suppress(FileNotFoundError):
            forkserver._forkserver._stop()  # type: ignore[attr-defined]


@pytest.mark.parametrize("end", [KeyboardInterrupt, SystemExit, GeneratorExit])
def test_whatever_an_engine_raises_is_its_error(end: type[BaseException]) -> None:
    (error,) = hold([partial(hostile.throw, end)], jobs=1)
    assert told(error)[0] == "raised"
    assert end.__name__ in told(error)[1]

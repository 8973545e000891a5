"""Calls in separate processes: a crash, a hang or an excess of memory ends one call alone.

An engine is C code: it may abort, loop for ever, or allocate without end, and raises no exception.
Python's own pools give up all their work when a process dies, and have no time limit. Pebble
(https://pebble.readthedocs.io) has one; but its workers share a pipe, so one that dies while it
reads its call breaks the pool, and no pool limits memory. Hence a pipe for each process here.
"""

from __future__ import annotations

import atexit
import ctypes
import math
import os
import pickle
import sys
from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from copy import copy
from functools import partial
from multiprocessing import forkserver, get_all_start_methods, get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.util import get_temp_dir
from pathlib import Path
from signal import SIG_DFL, SIGINT, Signals, signal
from time import monotonic
from typing import Any, Self, TypeVar

from ...reference.cost import keep_budget, time_left
from ...reference.errors import BrokenEngineError, EngineError, MbcheckError, UsageError
from . import THREADS, use_one_thread
from .messages import encoded, received, sent
from .protocol import Engine, Method
from .run import call_engine, describe, engine_error, traceback_of
from .validation import ATTRIBUTES, CALLS

try:
    import fcntl
    import resource
except ImportError:  # Windows
    resource = None  # type: ignore[assignment]

T = TypeVar("T")

STATM = Path("/proc/self/statm")
"""File with the memory that a process maps; Linux alone has it, and limits the memory."""

MEMORY = 4096.0 if STATM.exists() else None
"""Memory that a task may map in addition to that of its process, where it can be limited [MiB]."""

SIGKILL = 9
"""Absent from `signal` on Windows, which has no groups of processes to send it to."""

SERVING = "MBCHECK_WORKER"
"""Variable of the environment of a process that makes calls for another one: its folder."""

NEEDED = f"{__package__.rpartition('.')[0]}.checks.suite"
"""Module that imports what checks need, and no engine."""

PATHS = ("PYTHONPATH", "PYTHONSAFEPATH")
"""Variables of the environment by which Python finds modules."""

START, GRACE = 60.0, 5.0
"""Time [s] in which a process must have read its call, and in which one whose pipe is broken must
have ended."""

HANGING = 900.0
"""Time [s] after which a call of an engine of others counts as hanging, unless a limit is set."""

LIMITS: ContextVar[tuple[float | None, float | None]] = ContextVar("limits", default=(None, None))
"""Time [s] and memory [MiB] of what this process does for another one, or for the user."""


def unheard(message: Any) -> None:
    """Ignore a message."""


TELL: ContextVar[Callable[[Any], None]] = ContextVar("TELL", default=unheard)
"""Sends a message of a call to the process that waits for it."""

Local = Callable[[tuple[tuple[str, float], ...]], Engine]

SECONDS_TO_LOAD = 120.0
"""Time in which an engine must have been imported and created."""

Groups = Sequence[Sequence[int]]


def isolated(
    calls: Sequence[Callable[[], T]],
    jobs: int,
    seconds: float | None = None,
    megabytes: float | None = None,
    groups: Groups | None = None,
    owners: Sequence[str] | None = None,
) -> Generator[tuple[int, T | EngineError], None, None]:
    """Make calls in worker processes; yield the number and the result of each as it ends.

    No process is left when the iterator is closed.

    Parameters
    ----------
    calls : sequence of callable
        No arguments; picklable, and so are their results.
    jobs : int
        Processes at a time.
    seconds : float, optional
        Time limit of each call [s], the start of its process apart.
    megabytes : float, optional
        Memory that each call may map in addition to that of its process [MiB].
    groups : sequence of sequences of int, optional
        Numbers of calls that are made one after the other by one process, which keeps what they
        share; as long as it lives.
    owners : sequence of str, optional
        Whose code each group runs: a process runs that of one alone.

    Yields
    ------
    (int, result)
        Of a call that failed an `EngineError` of the kind ``crashed``, ``timeout``, ``memory`` or
        ``raised``, or the one that it raised.

    Raises
    ------
    UsageError
        For limits that are not positive, or that this platform does not have; when the budget is
        over.
    """
    refuse_limits(seconds, megabytes)
    alone: Groups = [[index] for index in range(len(calls))]
    groups = alone if groups is None else groups
    owners = [""] * len(groups) if owners is None else owners
    waiting = deque((owner, deque(group)) for owner, group in zip(owners, groups, strict=True))
    crew: dict[Worker, tuple[str, deque[int]]] = {}
    try:
        while waiting or crew:
            while waiting and len(crew) < jobs:
                worker = Worker()
                crew[worker] = waiting.popleft()
                worker.begin(calls[crew[worker][1][0]], seconds, megabytes)
            for worker in ready(crew):
                (owner, group), result = crew.pop(worker), worker.outcome
                index, alive = group.popleft(), worker.process.is_alive()
                if not group and alive and waiting and waiting[0][0] == owner:
                    _, group = waiting.popleft()
                if group and alive:
                    crew[worker] = owner, group
                    worker.begin(calls[group[0]], seconds, megabytes)
                else:
                    worker.end()
                    if group:
                        waiting.appendleft((owner, group))
                yield index, result
    finally:
        for worker in crew:
            worker.end()


@contextmanager
def within_limits(seconds: float | None, megabytes: float | None) -> Iterator[None]:
    """Limit time [s] and memory [MiB] of each call of an engine of others, unless less is left.

    Raises
    ------
    UsageError
        For limits that are not positive, or that this platform does not have.
    """
    refuse_limits(seconds, megabytes)
    pairs = zip(LIMITS.get(), (seconds, megabytes), strict=True)
    time, memory = (min(filter(None, pair), default=None) for pair in pairs)
    before = LIMITS.set((time, memory))
    try:
        yield
    finally:
        LIMITS.reset(before)


def await_call(worker: Worker, call: Callable[[], T], most: float) -> T | EngineError:
    """Return the result of a worker's call, or the `EngineError` of its failure.

    Parameters
    ----------
    worker : Worker
    call : callable
    most : float
        Time that it may take [s]. What this process does for another one or for the user has
        limits, which hold for the call too.
    """
    longest, megabytes = LIMITS.get()
    if longest is None:
        longest = HANGING
    worker.begin(call, min(longest, most), megabytes)
    while not ready({worker: deque()}):
        pass
    return worker.outcome


def process_context() -> Any:
    """Return the context that starts processes: a server without engines, where there is one.

    The server has loaded the modules that all of them need, which would take each process a second,
    and linear algebra has one thread in it. A process that serves another one has loaded no engine
    either: it is forked.
    """
    if "forkserver" not in get_all_start_methods():  # Windows has no fork
        return get_context("spawn")
    if SERVING in os.environ:
        return get_context("fork")
    context = get_context("forkserver")
    context.set_forkserver_preload([NEEDED])
    before = {name: os.environ.get(name) for name in (*PATHS, *THREADS)}
    # what it loads is what the program has loaded, and nothing that lies in the working directory
    set_variables(dict(zip(PATHS, (os.pathsep.join(filter(None, sys.path)), "1"), strict=True)))
    use_one_thread()  # that of a caller who has loaded NumPy is the caller's own choice
    try:
        forkserver.ensure_running()
    except OSError:  # the path of the temporary folder is too long for a socket
        return get_context("spawn")
    finally:
        set_variables(before)
    return context


def set_variables(values: Mapping[str, str | None]) -> None:
    """Set variables of the environment, or take them out of it."""
    for name, value in values.items():
        os.environ.pop(name, None)
        if value is not None:
            os.environ[name] = value


class Worker:
    """A process that makes one call at a time.

    That of an engine has its folder, and answers in plain data.

    Attributes
    ----------
    heard : callable
        Receives the messages that a call sends before it ends, see `tell`.
    """

    def __init__(self, folder: Path | None = None) -> None:
        context = process_context()
        self.plain = folder is not None
        self.pipe, theirs = context.Pipe()
        lifeline, self.lifeline = context.Pipe(duplex=False)
        # a daemon may start no process, and one that makes checks starts one for each engine
        inner = SERVING in os.environ
        paths = {name: os.environ.get(name) for name in PATHS}
        arguments = theirs, lifeline, folder, paths
        try:
            self.process = context.Process(target=serve, args=arguments, daemon=inner)
            self.process.start()
        except (OSError, EOFError):  # an engine has ended the server, or removed its socket
            self.process = get_context("spawn").Process(target=serve, args=arguments, daemon=inner)
            self.process.start()
        self.heard: Callable[[Any], None] = unheard
        atexit.register(self.end)
        theirs.close()
        lifeline.close()

    def begin(
        self, call: Callable[[], Any], seconds: float | None, megabytes: float | None
    ) -> None:
        """Have a call made, as long as the budget lasts."""
        self.seconds = min((x for x in (seconds, time_left()) if x is not None), default=math.inf)
        self.deadline = monotonic() + START + self.seconds
        self.megabytes = megabytes
        sent(self.pipe, pickle.dumps((call, seconds, megabytes)))

    def ended(self) -> bool:
        """Return True if the call has ended, with its result in ``outcome``."""
        try:
            while self.pipe.poll():
                done, self.outcome = received(self.pipe, self.plain)
                if done:
                    return True
                self.deadline = min(self.deadline, monotonic() + self.seconds)
                if self.outcome is not None:
                    self.heard(self.outcome)
        except (EOFError, OSError):
            self.process.join(GRACE)
            end_group(self.process.pid)
            self.process.kill()
            self.process.join()
        if self.process.is_alive() and monotonic() < self.deadline:
            return False
        if self.process.is_alive():
            reason = f"stopped: it had not ended after {self.seconds:g} s"
            self.outcome = EngineError("timeout", reason)
        else:
            reason = f"the engine took its process down with it: {self.death}"
            self.outcome = EngineError("crashed", reason)
        self.end()
        keep_budget(1.0)
        return True

    @property
    def death(self) -> str:
        """The cause of the process's death."""
        code = self.process.exitcode or 0
        if code >= 0:
            return f"exit code {code}"
        limit = "" if self.megabytes is None else (
            f" (its memory was limited to {self.megabytes:g} MB: C code that gets none may die so)"
        )  # fmt: skip
        known = {int(one): one.name for one in Signals}
        return known.get(-code, f"signal {-code}") + limit

    def end(self) -> None:
        """Kill the process, whatever it does, and those that it has started."""
        end_group(self.process.pid)
        self.process.kill()
        self.process.join()
        self.pipe.close()
        self.lifeline.close()
        os.makedirs(get_temp_dir(), exist_ok=True)  # which an engine may have removed, as it ends
        atexit.unregister(self.end)


def ready(crew: Mapping[Worker, Any]) -> list[Worker]:
    """Wait a while; return the workers whose calls have ended."""
    patience = min(worker.deadline for worker in crew) - monotonic()
    wait(
        [sign for worker in crew for sign in (worker.pipe, worker.process.sentinel)],
        None if math.isinf(patience) else max(0.0, patience),
    )
    return [worker for worker in crew if worker.ended()]


def serve(
    pipe: Connection, lifeline: Connection, folder: Path | None, paths: Mapping[str, str | None]
) -> None:
    """Make the calls that come through a pipe, until there are no more; end at once on Ctrl-C.

    What is sent back is whether the call has ended, and its result: first that it was read,
    which imports what it needs.
    """
    if SERVING in os.environ:
        forget_files(pipe.fileno(), lifeline.fileno())
    if folder:
        os.chdir(folder)
        os.dup2(2, 1)  # standard output is for documents
    set_variables(paths)
    os.environ[SERVING] = str(Path.cwd())
    signal(SIGINT, SIG_DFL)
    lead_group()
    end_with_program(lifeline)
    with suppress(OSError):  # third-party code has closed the pipe
        while True:
            answer_next(pipe, folder is not None)


def answer_next(pipe: Connection, plain: bool) -> None:
    """Make the next call that comes through a pipe, or end this process if there is none."""
    try:
        call, *limits = pipe.recv()
    except EOFError:
        raise BrokenPipeError from None
    except BaseException as error:  # whatever a third-party module raises as it is imported
        pipe.send_bytes(encoded((True, engine_error(error)), plain))
    else:
        pipe.send_bytes(encoded((False, None), plain))
        TELL.set(lambda message: pipe.send_bytes(encoded((False, message), plain)))
        pipe.send_bytes(encoded((True, outcome(call, *limits)), plain))


def tell(message: Any) -> None:
    """Send what a call of this process has to say before it ends, to `Worker.heard`."""
    TELL.get()(message)


def forget_files(*needed: int) -> None:
    """Let go of all files that the process had open of which this one is a copy.

    It would hold both ends of its own pipes, and could write into those of the other.
    """
    nothing = os.open(os.devnull, os.O_RDWR)
    for place in map(int, os.listdir("/dev/fd")):
        if place > 2 and place not in needed:
            with suppress(OSError):  # that of the list itself
                os.fstat(place)
                os.dup2(nothing, place)


def lead_group() -> None:
    """Make this process the leader of a group, by which its children are ended with it.

    On Linux those that lose their parent become its own.
    """
    if hasattr(os, "setpgid"):  # not on Windows
        with suppress(OSError):
            os.setpgid(0, 0)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(36, 1, 0, 0, 0)  # PR_SET_CHILD_SUBREAPER


def end_group(leader: int | None) -> None:
    """Kill what a worker has started: its group, and on Linux sessions of their own."""
    if leader is None or not hasattr(os, "killpg"):
        return
    family = [leader]
    for one in family:
        with suppress(OSError):  # it has ended, or the system does not list them
            for thread in Path(f"/proc/{one}/task").iterdir():
                family += map(int, (thread / "children").read_text().split())
    for end, one in ((os.killpg, leader), *((os.kill, one) for one in family[1:])):
        with suppress(OSError):  # none is left
            end(one, SIGKILL)


def end_with_program(lifeline: Connection) -> None:
    """Have the kernel kill this process and its children when the program ends, however it does.

    Of ``lifeline`` the program holds the other end, and never writes. A thread that waits would
    not do: C code may keep Python's lock for ever. On Linux alone.
    """
    if sys.platform == "linux":
        place = lifeline.fileno()
        fcntl.fcntl(place, fcntl.F_SETOWN, -os.getpgrp())
        fcntl.fcntl(place, fcntl.F_SETSIG, SIGKILL)
        fcntl.fcntl(place, fcntl.F_SETFL, fcntl.fcntl(place, fcntl.F_GETFL) | os.O_ASYNC)
        if lifeline.poll():  # it has ended meanwhile
            os._exit(1)


def outcome(call: Callable[[], Any], seconds: float | None, megabytes: float | None) -> Any:
    """Return the result of a call, or the `EngineError` of its failure."""
    LIMITS.set((seconds, megabytes))
    try:
        with limited_memory(megabytes):
            return call()
    except EngineError as error:
        return error
    except MemoryError as error:
        limit = "" if megabytes is None else f", limited to {megabytes:g} MB"
        reason = f"no more memory{limit}: {describe(error)}"
        return EngineError("memory", reason, traceback_of(error))
    except BaseException as error:  # whatever it is, the other calls go on
        return engine_error(error)


@contextmanager
def limited_memory(megabytes: float | None) -> Iterator[None]:
    """Let this process map so much additional memory [MiB]."""
    if megabytes is None:
        yield
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    mapped = int(STATM.read_text().split()[0]) * resource.getpagesize()
    limit = mapped + int(megabytes * 2**20)
    limit = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
    resource.setrlimit(resource.RLIMIT_AS, (limit, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def refuse_limits(seconds: float | None, megabytes: float | None) -> None:
    """Refuse limits that cannot be kept.

    Raises
    ------
    UsageError
    """
    for what, value in (("time", seconds), ("memory", megabytes)):
        if value is not None and not 0 < value < math.inf:
            raise UsageError(f"the {what} limit must be greater than 0, not {value:g}")
    if megabytes is not None and not (resource and STATM.exists()):
        raise UsageError("memory can be limited on Linux only: leave the memory limit out")


class RemoteEngine(Engine):
    """An engine whose code runs in another process.

    Parameters
    ----------
    describe : callable
        Returns the engine's attributes by name, and as ``functions`` the names of the functions
        that it defines, and as ``by_method`` those that take a method; called in that
        process.
    local : callable ``(options) -> Engine``
        Returns the engine itself, with options (name, value) set; called in that process.

    Raises
    ------
    BrokenEngineError
        If the engine fails as it is loaded, in whatever way.
    """

    def __init__(self, describe: Callable[[], dict[str, Any]], local: Local) -> None:
        self.local = local
        self.settings: tuple[tuple[str, float], ...] = ()
        self.folder = Path(os.environ.get(SERVING) or Path.cwd())
        self.worker: Worker | None = None
        try:
            about = self.call(describe, SECONDS_TO_LOAD)
            vars(self).update({name: about[name] for name in ATTRIBUTES})
            self.functions = (set(CALLS) - {"with_option"}) & set(about["functions"])
            self.by_method = frozenset(about.get("by_method", ()))
        except EngineError as error:
            reason = f"it cannot be loaded: {error.message}"
            raise BrokenEngineError(reason, error.traceback) from error
        except (KeyError, TypeError) as error:
            raise BrokenEngineError("what its process sent is no description of it") from error
        self.connect()

    def connect(self) -> None:
        """Replace each function that the engine defines by a call in its process."""
        for name in self.functions:
            ask = self.ask_by_method if name in self.by_method else self.ask
            setattr(self, name, partial(ask, name))

    def call(self, work: Callable[[], Any], most: float = math.inf) -> Any:
        """Return the result of some work in the engine's process, within a time limit [s].

        Raises
        ------
        EngineError
            If the process has ended, or not ended in time, or the engine raised.
        MbcheckError
            That the work raised.
        """
        if self.worker is None or not self.worker.process.is_alive():
            self.worker = Worker(self.folder)
        outcome = await_call(self.worker, partial(guarded, work), most)
        if isinstance(outcome, MbcheckError):
            raise outcome
        return outcome

    def with_option(self, name: str, value: float) -> Self:
        """Return the engine with an option set."""
        other = copy(self)
        other.settings = (*self.settings, (name, value))
        other.connect()
        return other

    def ask(self, function: str, *arguments: Any, **how: Any) -> Any:
        """Return the answer of a function of the engine."""
        return self.call(partial(asked, self.local, self.settings, function, arguments, how))

    def ask_by_method(self, function: str, *arguments: Any, method: Method | None = None) -> Any:
        """Return the answer of a function of the engine for a method."""
        return self.ask(function, *arguments, method=method)


def asked(
    local: Local,
    settings: tuple[tuple[str, float], ...],
    function: str,
    arguments: tuple[Any, ...],
    how: Mapping[str, Any],
) -> Any:
    """Return the answer of a function of an engine in this process."""
    call = getattr(local(settings), function)
    return call_engine(lambda: call(*arguments, **how))


def guarded(work: Callable[[], Any]) -> Any:
    """Return the result of some work, or the `MbcheckError` that it raises."""
    try:
        return work()
    except MbcheckError as error:
        return error

"""Where blocks are computed: in this process, in others, or on a Dask cluster.

An executor is a function ``(function, items) -> iterator of (number of the item, result)``,
in the order in which results arrive. The results do not depend on which one it is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import active_children
from signal import SIG_DFL, SIGINT, signal
from typing import Any, TypeVar

from ...reference.errors import MbcheckError, UsageError
from ..engines.isolation import process_context

Item = TypeVar("Item")
Result = TypeVar("Result")
Executor = Callable[[Callable[[Any], Any], Sequence[Any]], Iterator[tuple[int, Any]]]

MOST_CRASHES = 3
"""How often workers may die before it is taken for the fault of what they compute."""

CONNECT_SECONDS = 10


def in_turn(
    function: Callable[[Item], Result], items: Sequence[Item]
) -> Iterator[tuple[int, Result]]:
    """Compute one item after the other here."""
    for i, item in enumerate(items):
        yield i, function(item)


@contextmanager
def in_processes(workers: int) -> Iterator[Executor]:
    """Lend an executor with this many processes.

    If one dies, the items that were not finished are given to new ones.
    """
    pool = worker_pool(workers)

    def execute(
        function: Callable[[Item], Result], items: Sequence[Item]
    ) -> Iterator[tuple[int, Result]]:
        nonlocal pool
        waiting = set(range(len(items)))
        for _ in range(MOST_CRASHES):
            futures = {pool.submit(function, items[i]): i for i in sorted(waiting)}
            for future in as_completed(futures):
                try:
                    result = future.result()
                except BrokenProcessPool:
                    continue
                waiting.discard(futures[future])
                yield futures[future], result
            if not waiting:
                return
            pool.shutdown()
            pool = worker_pool(workers)
        raise MbcheckError(
            f"worker processes died {MOST_CRASHES} times, with {len(waiting)} blocks to go; "
            "--workers 1 would show what of"
        )

    try:
        yield execute
    except BaseException:
        for child in active_children():
            child.terminate()
        raise
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def worker_pool(jobs: int) -> ProcessPoolExecutor:
    """Return a pool whose workers end at once on Ctrl-C."""
    return ProcessPoolExecutor(
        jobs, process_context(), initializer=signal, initargs=(SIGINT, SIG_DFL)
    )


@contextmanager
def on_cluster(address: str, patience: float = CONNECT_SECONDS) -> Iterator[Executor]:
    """Lend an executor on the Dask cluster whose scheduler has this address.

    Dask itself gives the work of a worker that died to another. The scheduler must answer within
    `patience` seconds.

    Raises
    ------
    UsageError
        If Dask is not installed, or no scheduler answers.
    """
    try:
        from distributed import Client, KilledWorker
        from distributed import as_completed as arriving
    except ImportError:
        raise UsageError("--dask needs dask.distributed; pip install 'mbcheck[cluster]'") from None
    try:
        client = Client(address, timeout=patience)
    except (OSError, ValueError) as error:
        raise UsageError(f"no Dask scheduler answers at {address!r}: {error}") from None

    def execute(
        function: Callable[[Item], Result], items: Sequence[Item]
    ) -> Iterator[tuple[int, Result]]:
        futures = client.map(function, items, pure=False, retries=MOST_CRASHES)
        number = {future.key: i for i, future in enumerate(futures)}
        try:
            for future in arriving(futures):
                yield number[future.key], future.result()
        except KilledWorker as error:
            raise MbcheckError(f"workers of the cluster died of a block: {error}") from None
        finally:
            client.cancel(futures)

    with client:
        yield execute

"""Executors of blocks: this process, other processes, or a Dask cluster.

An executor is a function ``(function, items) -> iterator of (number of the item, result)``,
in the order in which results arrive. The results do not depend on which one it is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any, TypeVar

from ...reference.errors import EngineError, MbcheckError, UsageError
from ..engines.isolation import isolated

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


def in_processes(
    workers: int, function: Callable[[Item], Result], items: Sequence[Item]
) -> Iterator[tuple[int, Result]]:
    """Compute items in so many processes; those of processes that die are given to new ones.

    Raises
    ------
    EngineError
        If the function raises.
    MbcheckError
        If processes keep dying.
    """
    waiting = list(range(len(items)))
    for _ in range(MOST_CRASHES):
        lost = []
        calls = [partial(function, items[i]) for i in waiting]
        for place, result in isolated(calls, workers):
            if not isinstance(result, EngineError):
                yield waiting[place], result
            elif result.kind == "crashed":
                lost.append(waiting[place])
            else:
                raise result
        if not lost:
            return
        waiting = lost
    raise MbcheckError(
        f"worker processes died {MOST_CRASHES} times, with {len(waiting)} blocks to go; "
        "--workers 1 would show what of"
    )


def on_this_machine(workers: int) -> Executor:
    """Return the executor that has so many workers here."""
    return in_turn if workers == 1 else partial(in_processes, workers)


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

"""Computing a map: its grid in blocks, all of it or only near the boundaries of classes."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from time import monotonic
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...reference.cost import keep_budget
from ...reference.errors import UsageError
from ..engines.registry import REFERENCE
from ..reports.files import write_whole
from ..scenes.quantity import NO_VALUE, QuantityValues
from .execute import Executor, in_turn, on_cluster, on_this_machine
from .request import Axis, Request, evaluate, resolved
from .store import Map, read, to_bytes


class RefinementOptions(NamedTuple):
    """How refinement shares its work, and how often an unfinished map is written.

    Attributes
    ----------
    coarse_cells : int
        Cells along an axis that refinement starts with on a large grid; a quarter of a small one.
    few : int
        Points that take about as long as a single one, computed together.
    shares : int
        Blocks of a pass of refinement, at least where it has many points.
    often : float
        Time [s] between two times at which an unfinished map is written.
    rarely : float
        Or so many times as long as that takes.
    """

    coarse_cells: int = 32
    few: int = 512
    shares: int = 4
    often: float = 2.0
    rarely: float = 20.0


OPTIONS = RefinementOptions()


Places = NDArray[np.int_]
Progress = Callable[[int, int], None]


def compute(
    request: Request,
    *,
    workers: int = 1,
    dask: str | None = None,
    unfinished: Path | None = None,
    resume: bool = False,
    progress: Progress = lambda done, total: None,
) -> Map:
    """Compute a map.

    Parameters
    ----------
    request : Request
        Result of `resolved`.
    workers : int
        Processes; 1 stays in this one. The map does not depend on it, nor on ``dask``.
    dask : str, optional
        Address of the scheduler of a Dask cluster, instead of processes here.
    unfinished : Path, optional
        File that keeps the map while it is not complete.
    resume : bool
        Continue the map in ``unfinished``.
    progress : callable ``(points done, points in all)``

    Raises
    ------
    UsageError
        If ``unfinished`` is another map, or ``resume`` is False.
    MbcheckError
        If workers keep dying.
    """
    if workers < 1:
        raise UsageError(f"the number of workers must be 1 or more, not {workers}")
    if dask is not None and workers > 1:
        raise UsageError("--workers and --dask contradict each other")
    grid = Grid(request, progress, unfinished, resume)
    lent = on_cluster(dask) if dask is not None else nullcontext(on_this_machine(workers))
    try:
        with lent as execute:
            for places in refined(grid) if request.refine else [everywhere(request)]:
                grid.fill(places, execute)
    finally:  # at its end, too: the map itself may not be written
        grid.save()
    return grid.map()


def compute_map(
    scene: str,
    quantity: str,
    x: tuple[str, float, float, int],
    y: tuple[str, float, float, int],
    *,
    workers: int = 1,
    dask: str | None = None,
    **options: Any,
) -> Map:
    """Compute a map of a scene.

    Parameters
    ----------
    scene, quantity : str
        See ``mbcheck list SCENE``.
    x, y : (name, low, high, count)
        Axes.
    workers, dask
        As in `compute`. With more than one worker a script needs the usual guard
        ``if __name__ == "__main__":``.
    **options
        Other fields of `Request`.

    Raises
    ------
    UsageError
        If a name is unknown, a value impossible, or the engine cannot do it.
    """
    request = Request(scene, quantity, Axis(*x), Axis(*y), **options)
    return compute(resolved(request), workers=workers, dask=dask)


class Grid:
    """A map while it is computed.

    Attributes
    ----------
    request : Request
    progress : callable
    unfinished : Path or None
        File that keeps the map meanwhile.
    before : Map or None
        What that had before.
    variables : dict of str to array (n_y, n_x)
    computed : bool array (n_y, n_x)
    problems : list of (x, y, reason)
    """

    def __init__(
        self, request: Request, progress: Progress, unfinished: Path | None, resume: bool
    ) -> None:
        self.request, self.progress, self.unfinished = request, progress, unfinished
        self.variables: dict[str, Any] = {
            name: np.full(request.shape, NO_VALUE, np.int8)
            if item.classes or name == "robust"
            else np.full(request.shape, np.nan)
            for name, item in request.mapped.variables.items()
        }
        self.computed = np.zeros(request.shape, dtype=bool)
        self.problems: list[tuple[float, float, str]] = []
        self.done = self.total = 0
        self.saved, self.pause, self.is_new = monotonic(), OPTIONS.often, False
        self.settings = json.loads(json.dumps(request.as_dict()))
        self.before = self.read_unfinished(resume)

    def read_unfinished(self, resume: bool) -> Map | None:
        """Return the map in the file of the unfinished map, if there is one.

        Raises
        ------
        UsageError
            If it must not be resumed, or is of another map.
        """
        if self.unfinished is None or not self.unfinished.exists():
            return None
        if not resume:
            raise UsageError(
                f"{self.unfinished} is an unfinished map: go on with --resume, or delete it"
            )
        try:
            before = read(self.unfinished)
        except UsageError as error:
            raise UsageError(f"--resume: {error}: delete it to begin anew") from None
        others = [
            name for name, value in self.settings.items() if before.settings.get(name) != value
        ]
        others += ["its variables"] if set(before.variables) != set(self.variables) else []
        if others:
            raise UsageError(
                f"--resume: {self.unfinished} is of another map ({', '.join(others)}); ask for the "
                "same, or delete it"
            )
        self.problems += before.problems
        return before

    def map(self) -> Map:
        """Return the map as far as it is computed."""
        return Map(
            self.request.x,
            self.request.y,
            self.variables,
            about=dict(self.request.mapped.variables),
            computed=self.computed,
            settings=self.settings,
            problems=tuple(sorted(self.problems)),
        )

    def save(self) -> None:
        """Write the computed points to the file of the unfinished map, if it lacks any."""
        if self.unfinished is None or not self.is_new:
            return
        begin = monotonic()
        write_whole(self.unfinished, to_bytes(self.map()))
        self.saved, self.is_new = monotonic(), False
        self.pause = max(OPTIONS.often, OPTIONS.rarely * (self.saved - begin))

    def fill(self, places: Places, execute: Executor) -> None:
        """Compute places (k, 2), columns and rows, or take them from what was kept."""
        self.total += len(places)
        missing, size = [], self.request.block or len(places)
        if self.request.refine:  # to be shared, however many there are to share it
            size = min(size, max(OPTIONS.few, -(-len(places) // OPTIONS.shares)))
        for block in split(places, size):
            column, row = block.T
            if self.before is not None and np.all(self.before.computed[row, column]):
                values = {name: item[row, column] for name, item in self.before.variables.items()}
                self.place(block, QuantityValues(values))
            else:
                missing.append(block)
        if len(missing) == 1 and self.request.engine == REFERENCE:
            execute = in_turn  # to begin a process takes longer than what it would share
        for i, block_values in execute(partial(evaluate, self.request), missing):
            self.place(missing[i], block_values)
            self.is_new = True
            if monotonic() - self.saved > self.pause:
                self.save()
            keep_budget(self.done / self.total)

    def place(self, block: Places, result: QuantityValues) -> None:
        """Put a finished block where it belongs."""
        column, row = block.T
        for name, values in self.variables.items():
            values[row, column] = result.values[name]
        for i, words in result.problems.items():
            x, y = self.request.x.values[column[i]], self.request.y.values[row[i]]
            self.problems.append((float(x), float(y), words))
        self.computed[row, column] = True
        self.done += len(block)
        self.progress(self.done, self.total)


def everywhere(request: Request, spacing: int = 1) -> Places:
    """Return all places (n, 2) of a map, or those of a lattice on it."""
    rows, columns = (lattice(count, spacing) for count in request.shape)
    return np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)


def split(places: Places, size: int) -> Iterator[Places]:
    """Share places among blocks of at most ``size``: square patches, so that they are near.

    Sparse patches share a block.
    """
    edge = max(1, int(np.sqrt(size)))
    patch = places // edge
    order = np.lexsort((places[:, 0], places[:, 1], patch[:, 0], patch[:, 1]))
    places, patch = places[order], patch[order]
    starts = np.flatnonzero(np.any(np.diff(patch, axis=0, prepend=-1), axis=1))
    begin = 0
    for start, end in zip(starts, [*starts[1:], len(places)], strict=True):
        if end - begin > size:
            yield places[begin:start]
            begin = int(start)
    if begin < len(places):
        yield places[begin:]


# Refinement


def refined(grid: Grid) -> Iterator[Places]:
    """Yield places to compute, having seen what the last ones are.

    A coarse lattice first. Then, with half its spacing each time, until it is the whole grid:
    points not computed take the values of the nearest computed one; where corners of a cell have
    different classes, those that are not computed are computed, until none is left. So the
    boundary is followed where it leads, and what lies far from it is never computed; an island
    that fits between the points of the coarse lattice is missed.
    """
    request = grid.request
    key = next(name for name, item in request.mapped.variables.items() if item.classes)
    count = min(request.shape) - 1
    cells = max(1, min(OPTIONS.coarse_cells, count / 4))
    spacing = 1 << max(0, int(np.floor(np.log2(count / cells))))
    yield everywhere(request, spacing)
    while True:
        spread(grid, spacing)
        if spacing == 1:
            return
        spacing //= 2
        while (places := uncertain(grid.variables[key], grid.computed, spacing)).size:
            yield places


def lattice(count: int, spacing: int) -> Places:
    """Return every ``spacing``-th of ``count`` places, and the last."""
    return np.union1d(np.arange(0, count, spacing), [count - 1])


def spread(grid: Grid, spacing: int) -> None:
    """Give each place not yet computed the values of the nearest point of a lattice."""
    near_row, near_column = (
        known[np.argmin(abs(np.arange(count)[:, None] - known), axis=1)]
        for count in grid.request.shape
        for known in [lattice(count, spacing)]
    )
    for values in grid.variables.values():
        values[...] = np.where(grid.computed, values, values[np.ix_(near_row, near_column)])


def uncertain(classes: Any, computed: Any, spacing: int) -> Places:
    """Return the corners (k, 2), not computed, of a lattice's cells whose classes differ."""
    rows, columns = (lattice(count, spacing) for count in classes.shape)
    values, left = classes[np.ix_(rows, columns)], ~computed[np.ix_(rows, columns)]
    height, width = len(rows) - 1, len(columns) - 1
    corners = [np.s_[i : i + height, j : j + width] for i, j in np.ndindex(2, 2)]
    mixed = np.ptp([values[corner] for corner in corners], axis=0) > 0
    wanted = np.zeros(values.shape, dtype=bool)
    for corner in corners:
        wanted[corner] |= mixed
    row, column = np.nonzero(wanted & left)
    return np.stack([columns[column], rows[row]], axis=1)

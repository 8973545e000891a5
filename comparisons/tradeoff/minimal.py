"""The least that meets a target: parts of a continuum, hardness of a loop, what may be left out.

Every number is computed when it is asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from functools import partial
from itertools import chain

from ...reference import get_scene
from ..engines.registry import REFERENCE
from ..scenes.data import scene_data
from ..scenes.tradeoff import LoopClosures, PartKind
from .closures import CLOSED, LoopClosure, closures
from .elements import Curve, Fewest, continuum_of, count_parts
from .left_out import LeftOut, left_out_table, rows_of
from .series import TARGETS


@dataclass(frozen=True)
class Minimal:
    """The least that meets targets, and what may be left out."""

    curves: tuple[Curve, ...] = ()
    fewest: tuple[Fewest, ...] = ()
    closures: tuple[LoopClosure, ...] = ()
    left_out: tuple[LeftOut, ...] = ()


def joined(parts: Sequence[Minimal]) -> Minimal:
    """Return all parts as one."""
    return Minimal(
        *(
            tuple(chain.from_iterable(getattr(part, item.name) for part in parts))
            for item in fields(Minimal)
        )
    )


def of_parts(
    scene: str, engine: str, kind: PartKind, case: str, targets: Sequence[float]
) -> Minimal:
    """Return how many parts of one kind are needed in one case."""
    curve, rows = count_parts(scene, engine, kind, case, targets)
    return Minimal(curves=(curve,), fewest=rows)


def of_loop(scene: str, engine: str, targets: Sequence[float] = (*TARGETS, CLOSED)) -> Minimal:
    """Return how softly an engine may close the loop of a scene."""
    loop = loop_of(scene)
    case = get_scene(scene).case(loop.case)
    mine = (option for option in loop.closures if option.engine.engine == engine)
    return Minimal(
        closures=tuple(row for option in mine for row in closures(case, option, targets))
    )


def of_left_out(scene: str, engine: str, targets: Sequence[float] = TARGETS) -> Minimal:
    """Return what may be left out of an engine's models of a scene."""
    return Minimal(left_out=tuple(rows_of(scene, engine, targets)))


def loop_of(scene: str) -> LoopClosures:
    """Return how the closed loop of a scene is compared."""
    return scene_data(scene, "tradeoff", "LOOP", LoopClosures("", ()))


Piece = tuple[str, Callable[[], Minimal]]


def tasks(
    scenes: Sequence[str], engines: Sequence[str], targets: Sequence[float] = TARGETS
) -> list[Piece]:
    """Return the pieces with their names, each ready for a process of its own."""
    return [
        piece
        for engine in (*engines, REFERENCE)
        for scene in scenes
        for piece in pieces(scene, engine, targets)
    ]


def pieces(scene: str, engine: str, targets: Sequence[float]) -> Iterator[Piece]:
    """Yield the pieces of one scene and engine."""
    continuum = continuum_of(scene)
    for kind in continuum.kinds.get(engine, ()):
        for case in (*continuum.steady, continuum.moving):
            name = f"{scene} {engine} {kind.name}, {case}"
            yield name, partial(of_parts, scene, engine, kind, case, targets)
    if any(option.engine.engine == engine for option in loop_of(scene).closures):
        all_targets = tuple(dict.fromkeys((*targets, CLOSED)))
        yield f"{scene} {engine} closure", partial(of_loop, scene, engine, all_targets)
    if engine in left_out_table(scene):
        yield f"{scene} {engine} left out", partial(of_left_out, scene, engine, targets)

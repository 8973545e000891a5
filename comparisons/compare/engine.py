"""An engine as the reader of a file: accelerations and mass matrices, in MuJoCo's conventions."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import compress, product
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ...models.joints import JointLayout, layout_of
from ...models.mechanism import Term
from ...models.system import System
from ...reference.errors import EngineError, MbcheckError, UsageError
from ...reference.scene import Array, Case
from ..engines.registry import get_engine
from ..engines.run import call_engine
from ..engines.validation import numbers
from .elements import Compiled, levels
from .gaps import OPERATIONS
from .reading import MUJOCO, Answer, Edit, Operand, Reading, State

TRIED_STATES = 4
"""Number of states at which an engine's conventions are tried."""

CLEARER = 0.5
"""A convention is tried if it reduces the error of accelerations to this share or less."""

FILE_ORDER = "the order of the file"


DEPARTURES = SCALAR_LAST, WORLD_RATES, BODY_VELOCITIES, ANGULAR_FIRST = (
    "quaternions as (x, y, z, w)",
    "angular velocities in the frame of the world",
    "velocities of free joints in the frame of the body",
    "angular before linear velocities of free joints",
)
"""Departures from the protocol of engines, the last two of free joints alone."""


@dataclass(frozen=True)
class Convention:
    """The order of joints, and the coordinates of ball and free joints, of an engine.

    Attributes
    ----------
    order : str
        Order of the joints in all vectors.
    joints : tuple of int
        Numbers of the joints in this order.
    departures : tuple of str
        Some of `DEPARTURES`.
    """

    order: str
    joints: tuple[int, ...]
    departures: tuple[str, ...]

    @property
    def sentences(self) -> list[str]:
        """The departures from the protocol of engines, in words."""
        order = [f"joints in {self.order}"] if self.order != FILE_ORDER else []
        return [*order, *self.departures]

    def positions(self, layout: JointLayout, q: Array) -> Array:
        """Return positions (n_q,) in the convention of the engine."""
        q = q.copy()
        for rows in layout.quaternions if SCALAR_LAST in self.departures else ():
            q[rows] = np.roll(q[rows], -1)
        return np.concatenate([q[layout.positions[i]] for i in self.joints])

    def velocity_map(self, layout: JointLayout, q: Array, v: Array) -> tuple[Array, Array]:
        """Return T (n, n) and c (n,): the engine has velocities T v and accelerations T a + c."""
        blocks, rest = [np.zeros((0, len(v)))], [np.zeros(0)]
        for i in self.joints:
            at = layout.velocities[i]
            block, drift = np.eye(len(v))[at], np.zeros(at.stop - at.start)
            if layout.kinds[i] in ("ball", "free"):
                turn = q[layout.positions[i]][-4:]
                body = Rotation.from_quat(np.roll(turn, -1)).as_matrix()
                if WORLD_RATES in self.departures:
                    block[-3:] = body @ block[-3:]
            if layout.kinds[i] == "free":
                if BODY_VELOCITIES in self.departures:
                    block[:3] = body.T @ block[:3]
                    drift[:3] = -np.cross(v[at][3:], block[:3] @ v)
                if ANGULAR_FIRST in self.departures:
                    block, drift = np.roll(block, 3, axis=0), np.roll(drift, 3)
            blocks.append(block)
            rest.append(drift)
        return np.vstack(blocks), np.concatenate(rest)


def conventions(model: Compiled, layout: JointLayout) -> Iterator[Convention]:
    """Yield conventions in which an engine may differ from the protocol, the protocol's first."""
    names, bodies = model.names["joint"], model.field("jnt_bodyid").tolist()
    depth = {i: level for level, bodies_ in enumerate(levels(model)) for i in bodies_}
    keys: dict[str, Callable[[int], Any]] = {
        FILE_ORDER: lambda i: i,
        "breadth-first order": lambda i: depth[bodies[i]],
        "alphabetical order": lambda i: names[i],
        "reversed order": lambda i: -i,
    }
    orders: dict[tuple[int, ...], str] = {}
    for name, key in keys.items():
        orders.setdefault(tuple(sorted(range(len(names)), key=key)), name)
    possible = DEPARTURES[: 4 if "free" in layout.kinds else 2 if layout.is_spatial else 0]
    for joints, name in orders.items():
        for flags in product((False, True), repeat=len(possible)):
            yield Convention(name, joints, tuple(compress(possible, flags)))


class EngineReading(Reading):
    """A file that an engine reads through the public door; MuJoCo reads its names and ranges.

    Parameters
    ----------
    operand : Operand

    Raises
    ------
    UsageError
        If there is no such engine, or it reads no MJCF.
    """

    likely: Sequence[Convention] = ()
    """Conventions that may be the engine's, the one in which it answers first."""

    def __init__(self, operand: Operand) -> None:
        self.engine = get_engine(operand.reader)
        if not self.engine.reads_mjcf:
            raise UsageError(f"{operand.reader} reads no MJCF: compare an engine that does")
        super().__init__(replace(operand, reader=MUJOCO), sys.executable)
        if self.engine.precision == "float32":
            self.eps = float(np.finfo(np.float32).eps)
        kinds = tuple(self.model.field("jnt_type").tolist())
        self.layout = layout_of(kinds)
        self.system = System(
            case=Case(Path(operand.file).stem, "file", None),
            model="file",
            joints=tuple(self.model.names["joint"]),
            positions=self.model.field("qpos0").astype(float),
            velocities=np.zeros(self.layout.size[1]),
            mjcf=self.text,
            path=str(Path(operand.file).resolve()),
            kinds=kinds,
        )

    @property
    def conventions(self) -> list[str]:
        """Departures from the protocol of engines, in words."""
        return self.likely[0].sentences if self.likely else []

    @property
    def version(self) -> str:
        """Name and version of the engine."""
        return f"{self.engine.name} {self.engine.version}"

    def ask_engine(self, function: str, state: State, convention: Convention) -> Array:
        """Return accelerations (n,) or a mass matrix (n, n) at a state, in MuJoCo's convention.

        Raises
        ------
        EngineError
            If the engine cannot evaluate the file, or fails.
        """
        q, v = (np.array(state[name], dtype=float) for name in ("qpos", "qvel"))
        turn, drift = convention.velocity_map(self.layout, q, v)
        names = self.model.names["actuator"]
        terms = tuple(
            Term("actuator", name, {}, amplitude=state["ctrl"][rows.start])
            for name, rows in zip(names, self.model.columns("key_ctrl"), strict=True)
        )
        moves = function == "accelerations"
        position = convention.positions(self.layout, q)
        arguments: tuple[Any, ...] = (0.0, position, turn @ v) if moves else (position,)
        by_method = self.engine.by_method(function, None)
        ask = partial(by_method, replace(self.system, terms=terms), *arguments)
        shape = v.shape if moves else turn.shape
        try:
            answer = numbers(function, call_engine(ask), shape, finite=True)
        except MbcheckError as error:
            message = f"{self.engine.name} cannot evaluate {self.operand.file}: {error}"
            raise EngineError("engine", message, error.traceback) from error
        if moves:
            return np.asarray(np.linalg.solve(turn, answer - drift), dtype=float)
        return np.asarray(turn.T @ answer @ turn)

    def likely_conventions(
        self, states: Sequence[State], wanted: Sequence[Array]
    ) -> list[Convention]:
        """Return the convention in which the engine has MuJoCo's accelerations.

        If there is none, return the protocol's and, if its errors are much smaller, another one:
        the edits that explain the rest then decide.
        """
        errors: dict[Convention, float] = {}
        for one in conventions(self.model, self.layout):
            answers = [self.ask_engine("accelerations", state, one) for state in states]
            errors[one] = float(np.linalg.norm(np.subtract(answers, wanted)))
            if errors[one] <= OPERATIONS * self.eps * np.linalg.norm(wanted):
                return [one]
        first, best = next(iter(errors)), min(errors, key=lambda one: errors[one])
        return [first, best][: 1 + (errors[best] < CLEARER * errors[first])]

    def at(
        self, states: Sequence[State], edits: Sequence[Edit] = (), brief: bool = False
    ) -> list[Answer]:
        """Return accelerations and mass matrices at states, as the engine returns them.

        Where MuJoCo has no row of a constraint, accelerations are those without constraints too.
        """
        mujoco = super().at(states)
        smooth = [i for i, one in enumerate(mujoco) if not len(one["row_type"])]
        if not self.likely:
            sample = (smooth or range(len(states)))[-TRIED_STATES:]
            quiet = [{**states[i], "ctrl": [0.0] * len(states[i]["ctrl"])} for i in sample]
            wanted = [one["qacc"] for one in super().at(quiet, (), brief=True)]
            self.likely = self.likely_conventions(quiet, wanted)
        convention = self.likely[0]
        answers: list[Answer] = []
        for i, state in enumerate(states):
            qacc = self.ask_engine("accelerations", state, convention)
            answers.append({"qacc": qacc, "qacc_floor": np.zeros_like(qacc)})
            if i in smooth:
                answers[i]["qacc_smooth"] = qacc
            if "mass_matrix" in self.engine.functions:
                answers[i]["mass"] = self.ask_engine("mass_matrix", state, convention)
        return answers

"""States at which two models are compared, and the rows of vectors that correspond."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from .elements import SWITCHES, Compiled, Match
from .gaps import CONTACT, GEOMETRY, QUANTITIES, row_numbers
from .reading import Reading, State

SEED = 1

PARTS = {"qpos": "joint", "qvel": "joint", "act": "actuator", "ctrl": "actuator"}
"""Part of a state -> the kind of the elements to which its rows belong."""

ANGLE, LENGTH = 1.0, 0.3
"""Half of the range in which joints without limits are put [rad, m]."""

BEYOND = 1e-3
"""Share of its range by which a joint is beyond its limit."""

DRAWS, TOUCHING = 4, 3
"""States that are drawn at random, and states with contacts."""

BEYOND_RANGE = 2.0
"""Force of an actuator without a range of controls, relative to the largest force allowed."""

TRIED = 200
"""States in which contacts are looked for."""

ROUNDING_DEPTH = 1e-7
"""Depth of a contact [m] from which on rounding does not decide whether it is there."""


class Row(NamedTuple):
    """A row of a constraint, or a contact.

    ``numbers`` are quantity -> values and tolerance; of a contact ``first`` is the geom with which
    MuJoCo's collision begins, and ``geometry`` are depth, position and frame (13,).
    """

    numbers: Mapping[str, tuple[Any, float]]
    first: str = ""
    geometry: Any = None


@dataclass(frozen=True)
class Side:
    """One of two models: its elements, and the rows of its vectors, in the order of A.

    Attributes
    ----------
    model : Compiled
    labels : mapping of str to dict of int to str
        Kind of element -> number in this model -> label in A.
    rows : mapping of str to list of int
        Rows of ``qpos``, ``qvel``, ``act`` and ``ctrl``.
    """

    model: Compiled
    labels: Mapping[str, dict[int, str]]
    rows: Mapping[str, list[int]]

    @cached_property
    def vectors(self) -> dict[str, dict[int, str]]:
        """Kind of rows, see `gaps.QUANTITIES` -> rows in the order of A, each with its label."""
        parts = dict[str, dict[int, str]]()
        for part, rows in self.rows.items():
            columns, labels = self.model.columns(f"key_{part}"), self.labels[PARTS[part]]
            owners = {row: label for i, label in labels.items() for row in columns[i]}
            parts[part] = {row: owners[row] for row in rows}
        starts = np.cumsum([0, self.model.field("nq"), self.model.field("nv")]).tolist()
        step = {
            start + row: label
            for start, part in zip(starts, ("qpos", "qvel", "act"), strict=True)
            for row, label in parts[part].items()
        }
        actuators = self.labels["actuator"].items()
        outputs = {row: label for i, label in actuators for row in self.model.outputs[i]}
        return {**self.labels, "output": outputs, "joint": parts["qvel"], "step": step}

    def in_order(self, answer: Mapping[str, Any]) -> dict[str, Any]:
        """Return the answer at a state with the elements of A, in the order of A."""
        rows = {kind: list(vector) for kind, vector in self.vectors.items()}
        dofs = rows["joint"]
        own = {
            name: value[rows[QUANTITIES.get(name.removesuffix("_floor"), ("", "joint"))[1]]]
            for name, value in answer.items()
            if not name.startswith(("row_", "contact_"))
        }
        if "mass" in own:
            own["mass"] = own["mass"][:, dofs]
        if "row_type" not in answer:
            return own
        own["rows"] = numbered([*self.constraint_rows(answer), *self.contacts(answer)])
        force = abs(answer["row_aref"]) / answer["row_inverse_inertia"]
        own["row_force"] = abs(answer["row_jacobian"][:, dofs]) * force[:, None]
        own["row_force"] = own["row_force"][~np.char.startswith(answer["row_type"], "contact")]
        return own

    def constraint_rows(self, answer: Mapping[str, Any]) -> Iterator[tuple[str, str, Row]]:
        """Yield the rows of constraints, but those of contacts, each with kind and label."""
        numbers = ("pos", "aref", "stiffness", "frictionloss", "inverse_inertia", "jacobian")
        columns = [answer[f"row_{name}"] for name in numbers]
        for kind, element, *row in zip(
            answer["row_type"].tolist(), answer["row_id"].tolist(), *columns, strict=True
        ):
            of = kind.rpartition("_")[2]
            if of == "dof":
                of, element = "joint", int(self.model.field("dof_jntid")[element])
            if not kind.startswith("contact"):
                label = self.labels[of].get(element, self.model.labels[of][element])
                yield f"{kind.replace('_', ' of ')} row", label, Row(row_numbers(*row))

    def contacts(self, answer: Mapping[str, Any]) -> Iterator[tuple[str, str, Row]]:
        """Yield the contacts, each with the labels of its geoms."""
        numbers = zip(answer["contact_geoms"].tolist(), answer["contact_numbers"], strict=True)
        for geoms, values in sorted(numbers, key=lambda pair: tuple(pair[1][3:6])):
            labels = [self.labels["geom"].get(one, f"geom number {one}") for one in geoms]
            row = {name: (values[columns], limit) for name, (columns, limit) in CONTACT.items()}
            yield "contact", " and ".join(sorted(labels)), Row(row, labels[0], values[GEOMETRY])


def numbered(rows: Sequence[tuple[str, str, Row]]) -> dict[tuple[str, str, int], Row]:
    """Return rows by kind and label, and their count of both."""
    by_key: dict[tuple[str, str, int], Row] = {}
    for kind, label, row in rows:
        by_key[kind, label, sum(key[:2] == (kind, label) for key in by_key)] = row
    return by_key


def sides_of(one: Compiled, other: Compiled, match: Match) -> tuple[Side, Side] | str:
    """Return the sides of two models, or why no state of A is one of B."""
    apart = [e.label for e in (*match.gone, *match.new) if e.kind == "joint"]
    apart += [
        a.label
        for a, b in match.pairs
        if a.kind == "joint" and a.attributes["type"].values != b.attributes["type"].values
    ]
    if apart:
        return f"their states are not the same: {', '.join(apart[:4])}"
    sides = tuple(
        Side(model, {kind: {} for kind in model.names}, {part: [] for part in PARTS})
        for model in (one, other)
    )
    for pair in match.pairs:
        for side, element in zip(sides, pair, strict=True):
            side.labels[element.kind][element.number] = pair[0].label
    for part in PARTS:
        columns = [
            [side.model.columns(f"key_{part}")[i] for i in side.labels[PARTS[part]]]
            for side in sides
        ]
        for spans in zip(*columns, strict=True):
            for rows in zip(*spans, strict=False):  # activations that both have
                for side, row in zip(sides, rows, strict=True):
                    side.rows[part].append(row)
    return sides[0], sides[1]


def translated(state: State, mine: Side, theirs: Side) -> State:
    """Return the state of A as one of B; components that A does not have are as B opens."""
    own = {name: np.array(values) for name, values in empty_state(theirs.model).items()}
    for name, values in own.items():
        values[theirs.rows[name]] = np.array(state[name])[mine.rows[name]]
    return {name: values.tolist() for name, values in own.items()}


def empty_state(model: Compiled) -> dict[str, Any]:
    """Return the state in which a model opens."""
    sizes = {"qvel": "nv", "act": "na", "ctrl": "nu"}
    zeros = {part: [0.0] * int(model.field(size)) for part, size in sizes.items()}
    return {"qpos": model.field("qpos0").tolist(), **zeros}


def states_of(reading: Reading, sides: tuple[Side, Side]) -> dict[str, State]:
    """Return states by name: as opened, keyframes, random ones, beyond ranges, with contacts."""
    model = reading.model
    states: dict[str, State] = {"as opened": empty_state(model)}
    for i, name in enumerate(model.names["key"]):
        key = {part: model.field(f"key_{part}")[i].tolist() for part in PARTS}
        states[f"keyframe {name or i}"] = key
    random = np.random.default_rng(SEED)
    drawn = [draw(model, random) for _ in range(TRIED)]
    states |= {f"random state {i + 1}": one for i, one in enumerate(drawn[:DRAWS])}
    outside = (*beyond_controls(sides, drawn[0]), *beyond_limits(sides, drawn[0]))
    states |= dict((*outside, *in_contact(reading, drawn)))
    return {
        name: state
        for name, state in states.items()
        if all(np.all(np.isfinite(part)) for part in state.values())
    }


def in_contact(reading: Reading, drawn: Sequence[State]) -> Iterator[tuple[str, State]]:
    """Yield those of some states in which geoms touch, each other ones as far as there are."""
    model = reading.model
    if not (np.any(model.field("geom_contype")) or model.names["pair"]):
        return
    contacts = reading.ask(touching=list(drawn))
    left = contacts["geoms"] & (contacts["shallowest"] > ROUNDING_DEPTH)[:, None]
    for k in range(TOUCHING):
        best = int(np.argmax(left.sum(axis=1)))
        if not left[best].any():
            return
        yield f"contact {k + 1}", drawn[best]
        left = left & ~left[best]


SIGNS = np.array([-1.0, 1.0])
"""Directions out of a range at its two ends."""


def ends_of(model: Compiled, ranges: str) -> Any:
    """Return the ends of ranges (n, 2), NaN where there are none."""
    values = np.asarray(model.field(ranges), dtype=float)
    limited = np.asarray(model.field(SWITCHES[ranges]), dtype=bool)[:, None]
    return np.where(limited & np.isfinite(values), values, np.nan)


def outer_ends(sides: tuple[Side, Side], kind: str, ranges: str) -> Any:
    """Return the outer ends (n, 2) of the ranges of A and of B, for elements or controls of A."""
    ends, other = (ends_of(side.model, ranges) for side in sides)
    mine, theirs = (
        side.rows[kind] if kind in side.rows else list(side.labels[kind]) for side in sides
    )
    ends[mine] = SIGNS * np.fmax(SIGNS * ends[mine], SIGNS * other[theirs])
    return ends


def owned(model: Compiled, part: str, values: Any) -> Any:
    """Return a value of each element for each component of a part of a state."""
    counts = np.array([len(columns) for columns in model.columns(f"key_{part}")], dtype=int)
    return np.repeat(values, counts, axis=0)


def draw(model: Compiled, random: np.random.Generator) -> State:
    """Return a random state inside the ranges of a model."""
    state = empty_state(model)
    position = np.array(state["qpos"])
    joints = zip(
        model.field("jnt_type").tolist(), model.columns("key_qpos"), ends_of(model, "jnt_range"),
        strict=True,
    )  # fmt: skip
    for kind, rows, limits in joints:
        if kind in ("ball", "free"):
            turn = random.normal(size=4)
            position[rows[-4:]] = turn / np.linalg.norm(turn)
            position[rows[:-4]] += random.uniform(-LENGTH, LENGTH, len(rows) - 4)
        elif np.all(np.isfinite(limits)):
            position[rows] = random.uniform(*limits)
        else:
            position[rows] += random.uniform(-1, 1) * (ANGLE if kind == "hinge" else LENGTH)
    velocity = random.normal(size=int(model.field("nv")))
    ends = {
        "act": owned(model, "act", ends_of(model, "actuator_actrange")),
        "ctrl": ends_of(model, "actuator_ctrlrange"),
    }
    within = {
        part: np.asarray(random.uniform(*np.where(np.isnan(values), SIGNS, values).T)).tolist()
        for part, values in ends.items()
    }
    return {"qpos": position.tolist(), "qvel": velocity.tolist(), **within}


def beyond_controls(sides: tuple[Side, Side], state: State) -> Iterator[tuple[str, State]]:
    """Yield states with controls and forces beyond their ranges in both models, if there are any.

    A control without a range is so large that the actuator's force is beyond its range, and that of
    its joint.
    """
    model = sides[0].model
    force = abs(outer_ends(sides, "actuator", "actuator_forcerange")).max(axis=1)
    on_joint = np.isin(model.field("actuator_trntype"), ("joint", "jointinparent"))
    joints = model.field("actuator_trnid")[on_joint, 0]
    first = [span.start for span in model.outputs]
    gear, gain = (
        abs(values[:, 0])
        for values in (model.field("actuator_gear")[first], model.field("actuator_gainprm"))
    )
    of_joints = abs(outer_ends(sides, "joint", "jnt_actfrcrange")).max(axis=1)[joints]
    force[on_joint] = np.fmax(force[on_joint], of_joints / np.where(gear, gear, 1.0)[on_joint])
    alone = SIGNS * (1 + BEYOND_RANGE * np.nan_to_num(force) / np.where(gain, gain, 1.0))[:, None]
    controls = outer_ends(sides, "ctrl", "actuator_ctrlrange")
    activations = outer_ends(sides, "actuator", "actuator_actrange")
    outside = controls + SIGNS * np.diff(controls)
    free = owned(model, "ctrl", np.nan_to_num(activations) + alone)
    ctrl = np.where(np.isnan(outside), free, outside)
    act = owned(model, "act", np.where(np.isnan(activations), alone, activations))
    for end, name in enumerate(("below", "above") if len(ctrl) else ()):
        both = {"ctrl": ctrl[:, end].tolist(), "act": act[:, end].tolist()}
        yield f"controls {name} their ranges", {**state, **both}


def beyond_limits(sides: tuple[Side, Side], state: State) -> Iterator[tuple[str, State]]:
    """Yield states in which all joints are a little beyond their lower, or their upper, limits."""
    model, ends = sides[0].model, outer_ends(sides, "joint", "jnt_range")
    kinds, rows, dofs = (model.field(f"jnt_{name}") for name in ("type", "qposadr", "dofadr"))
    beyond = BEYOND * np.nan_to_num(ends[:, 1] - ends[:, 0], nan=1.0)
    for end, name in enumerate(("lower", "upper")):
        position, velocity = np.array(state["qpos"]), np.array(state["qvel"])
        for i in (limited := np.flatnonzero(np.isfinite(ends[:, end]))):
            if kinds[i] == "ball":
                half, axis = (ends[i, 1] + beyond[i]) / 2, position[rows[i] + 1 : rows[i] + 4]
                axis *= np.sin(half) / np.linalg.norm(axis)
                position[rows[i]] = np.cos(half)
            else:
                position[rows[i]] = ends[i, end] + SIGNS[end] * beyond[i]
                velocity[dofs[i]] = SIGNS[end] * abs(velocity[dofs[i]])  # into the limit
        if len(limited):
            yield (
                f"joints at their {name} limits",
                {**state, "qpos": position.tolist(), "qvel": velocity.tolist()},
            )

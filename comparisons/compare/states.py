"""States at which two models are compared, and the rows of vectors that correspond."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from .elements import Compiled, Match
from .reading import Reading, State

SEED = 1

ANGLE, LENGTH = 1.0, 0.3
"""Half of the range in which joints without limits are put [rad, m]."""

BEYOND = 1e-3
"""Share of its range by which a joint stands beyond its limit."""

DRAWS, AT_LIMITS, TOUCHING = 4, 6, 3
"""States that are drawn at random, of joints at their limits, and with contacts."""

BEYOND_RANGE = 3.0
"""Controls of one state, over those of a random one: ranges of controls and forces cut them."""

TRIED = 200
"""States in which contacts are looked for."""

ROUNDING_DEPTH = 1e-7
"""Depth of a contact [m] from which on rounding does not decide whether it is there."""


@dataclass(frozen=True)
class StateRows:
    """Which rows of vectors of A are those of B.

    Attributes
    ----------
    rows : mapping of str to (array of int, array of int)
        The rows of ``qpos``, ``qvel``, ``act`` and ``ctrl`` in A and in B.
    labels : list of str
        The joints of A at these rows of ``qvel``.
    """

    rows: Mapping[str, tuple[Any, Any]]
    labels: list[str]

    def translated(self, state: State, other: Compiled) -> State:
        """Return the state of A as one of B; what A does not have is as B opens."""
        own: dict[str, Any] = empty_state(other)
        for name, (mine, theirs) in self.rows.items():
            own[name] = np.array(own[name])
            own[name][theirs] = np.array(state[name])[mine]
        return {name: np.asarray(value).tolist() for name, value in own.items()}


def layout(one: Compiled, other: Compiled, match: Match) -> StateRows | str:
    """Return which rows are the same, or why no state of A is one of B."""
    apart = [e.label for e in (*match.gone, *match.new) if e.kind == "joint"]
    apart += [
        a.label
        for a, b in match.pairs
        if a.kind == "joint" and a.attributes["type"].values != b.attributes["type"].values
    ]
    if apart:
        return f"their states are not the same: {', '.join(apart[:4])}"
    rows: dict[str, list[tuple[int, int]]] = {"qpos": [], "qvel": [], "act": [], "ctrl": []}
    labels: list[str] = []
    for a, b in match.pairs:
        if a.kind == "joint":
            for name, address, count in (
                ("qpos", "jnt_qposadr", "nq"),
                ("qvel", "jnt_dofadr", "nv"),
            ):
                mine = span(one, address, count, a.number)
                rows[name] += zip(mine, span(other, address, count, b.number), strict=True)
                labels += [a.label] * len(mine) if name == "qvel" else []
        if a.kind == "actuator":
            rows["ctrl"].append((control_of(one, a.number), control_of(other, b.number)))
            starts = [int(m.field("actuator_actadr")[e.number]) for m, e in ((one, a), (other, b))]
            if min(starts) >= 0:
                rows["act"].append((starts[0], starts[1]))
    arrays = {name: np.array(pairs, dtype=int).reshape(-1, 2).T for name, pairs in rows.items()}
    return StateRows({name: (pair[0], pair[1]) for name, pair in arrays.items()}, labels)


def span(model: Compiled, address: str, count: str, number: int) -> range:
    """Return the rows of an element in a vector."""
    starts = [*model.field(address).tolist(), int(model.field(count))]
    return range(starts[number], starts[number + 1])


def control_of(model: Compiled, number: int) -> int:
    """Return the row of an actuator's control."""
    return int(model.answer.get("model.actuator_ctrladr", np.arange(number + 1))[number])


def empty_state(model: Compiled) -> dict[str, Any]:
    """Return the state in which a model opens."""
    return {
        "qpos": model.field("qpos0").tolist(),
        "qvel": [0.0] * int(model.field("nv")),
        "act": [0.0] * int(model.field("na")),
        "ctrl": [0.0] * int(model.field("nu")),
    }


def states_of(reading: Reading) -> dict[str, State]:
    """Return states by name: as it opens, keyframes, random ones, at limits and with contacts."""
    model = reading.model
    states: dict[str, State] = {"as opened": empty_state(model)}
    for i, name in enumerate(model.names["key"]):
        states[f"keyframe {name or i}"] = {
            part: model.field(f"key_{part}")[i].tolist() for part in ("qpos", "qvel", "act", "ctrl")
        }
    random = np.random.default_rng(SEED)
    drawn = [draw(model, random) for _ in range(TRIED)]
    states |= {f"random state {i + 1}": one for i, one in enumerate(drawn[:DRAWS])}
    if states["random state 1"]["ctrl"]:
        beyond = [BEYOND_RANGE * value for value in drawn[0]["ctrl"]]
        states["controls beyond their ranges"] = {**drawn[0], "ctrl": beyond}
    states |= dict(at_limits(model, drawn[0]))
    states |= dict(in_contact(reading, drawn))
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


def draw(model: Compiled, random: np.random.Generator) -> State:
    """Return a random state inside the ranges of a model."""
    state = empty_state(model)
    position = np.array(state["qpos"])
    for number, kind in enumerate(model.types("jnt_type")):
        at = span(model, "jnt_qposadr", "nq", number)
        rows = slice(at.start, at.stop)
        if kind in ("ball", "free"):
            turn = random.normal(size=4)
            position[at.stop - 4 : at.stop] = turn / np.linalg.norm(turn)
            if kind == "free":
                position[at.start : at.start + 3] += random.uniform(-LENGTH, LENGTH, 3)
        elif is_limited(model, number):
            position[rows] = random.uniform(*model.field("jnt_range")[number])
        else:
            position[rows] += random.uniform(-1, 1) * (ANGLE if kind == "hinge" else LENGTH)
    low, high = bounds(model, "actuator_ctrlrange", "actuator_ctrllimited")
    act_low, act_high = bounds(model, "actuator_actrange", "actuator_actlimited")
    na = int(model.field("na"))
    return {
        "qpos": position.tolist(),
        "qvel": random.normal(size=int(model.field("nv"))).tolist(),
        "act": random.uniform(np.resize(act_low, na), np.resize(act_high, na)).tolist(),
        "ctrl": random.uniform(low, high).tolist(),
    }


def is_limited(model: Compiled, number: int) -> bool:
    """Return True if a joint has finite limits."""
    limits = model.field("jnt_range")[number]
    return bool(model.field("jnt_limited")[number] and np.all(np.isfinite(limits)))


def bounds(model: Compiled, ranges: str, limited: str) -> tuple[Any, Any]:
    """Return the ends of ranges, -1 and 1 where there are none."""
    on = model.field(limited).astype(bool)[:, None]
    known = on & np.isfinite(model.field(ranges))
    low, high = np.where(known, model.field(ranges), [-1.0, 1.0]).T.reshape(2, -1)
    return np.minimum(low, high), np.maximum(low, high)


def at_limits(model: Compiled, state: State) -> Iterator[tuple[str, State]]:
    """Yield states in which one joint after the other stands a little beyond a limit."""
    kinds = model.types("jnt_type")
    limited = [
        i for i, kind in enumerate(kinds) if kind in ("hinge", "slide") and is_limited(model, i)
    ]
    for k, number in enumerate(limited[:AT_LIMITS]):
        low, high = model.field("jnt_range")[number]
        row, dof = (int(model.field(name)[number]) for name in ("jnt_qposadr", "jnt_dofadr"))
        position, velocity = np.array(state["qpos"]), np.array(state["qvel"])
        position[row] = high + BEYOND * (high - low) if k % 2 else low - BEYOND * (high - low)
        velocity[dof] = abs(velocity[dof]) * (1 if k % 2 else -1)  # into the limit
        yield (
            f"{model.labels['joint'][number]} at its limit",
            {**state, "qpos": position.tolist(), "qvel": velocity.tolist()},
        )


class Contact(NamedTuple):
    """The geom with which MuJoCo's collision begins, and the numbers of a contact."""

    first: str
    numbers: Any


@dataclass(frozen=True)
class Side:
    """The rows of one of two models in the answers of `probe.evaluated`.

    Attributes
    ----------
    model : Compiled
    labels : mapping of str to mapping of int to str
        Kind of element -> number in this model -> label in A, in the order of A.
    rows : mapping of str to array of int
        Rows of ``qpos`` and ``qvel`` in the order of A.
    """

    model: Compiled
    labels: Mapping[str, Mapping[int, str]]
    rows: Mapping[str, Any]

    def in_order(self, answer: Mapping[str, Any]) -> dict[str, Any]:
        """Return the answer at a state with the elements of A, in the order of A."""
        dofs, own = self.rows["qvel"], dict[str, Any]()
        for name, value in answer.items():
            kind = {"xpos": "body", "xmat": "body"}.get(name, name.partition("_")[0])
            kind = {"ten": "tendon"}.get(kind, kind)
            if name == "mass":
                own[name] = value[np.ix_(dofs, dofs)]
            elif name.startswith(("step_", "floor_")):
                positions = len(value) - len(dofs)
                own[name] = np.concatenate([value[self.rows["qpos"]], value[positions + dofs]])
            elif name.startswith(("row_", "contact_")):
                continue
            elif kind in self.labels and (name != "actuator"):
                own[name] = value[list(self.labels[kind])]
            elif value.shape == dofs.shape:
                own[name] = value[dofs]
        if "row_type" not in answer:
            return own
        return own | {"rows": self.constraint_rows(answer), "contacts": self.contacts(answer)}

    def constraint_rows(self, answer: Mapping[str, Any]) -> dict[tuple[str, str, int], Any]:
        """Return the rows of constraints, but those of contacts: type, element, count -> row."""
        dof_joint = self.model.field("dof_jntid")
        rows: dict[tuple[str, str, int], Any] = {}
        for i, number in enumerate(answer["row_type"].tolist()):
            kind = self.model.word("mjtConstraint", number)
            if kind.startswith("contact"):
                continue
            element, of = int(answer["row_id"][i]), "joint"
            if kind == "friction_dof":
                element = int(dof_joint[element])
            elif kind.endswith("tendon"):
                of = "tendon"
            elif kind == "equality":
                of = "equality"
            label = self.labels[of].get(element, self.model.labels[of][element])
            count = sum(key[:2] == (kind, label) for key in rows)
            rows[kind, label, count] = {
                name: float(answer[f"row_{name}"][i]) for name in ROW_NUMBERS
            } | {"jacobian": answer["row_jacobian"][i][self.rows["qvel"]]}
        return rows

    def contacts(self, answer: Mapping[str, Any]) -> dict[tuple[str, int], Contact]:
        """Return the contacts: labels of their geoms, count -> contact."""
        rows: dict[tuple[str, int], Contact] = {}
        numbers = zip(answer["contact_geoms"].tolist(), answer["contact_numbers"], strict=True)
        for geoms, values in sorted(numbers, key=lambda pair: tuple(pair[1][3:6])):
            labels = [self.labels["geom"].get(one, f"geom number {one}") for one in geoms]
            label = " and ".join(sorted(labels))
            rows[label, sum(key[0] == label for key in rows)] = Contact(labels[0], values)
        return rows


ROW_NUMBERS = ("pos", "inverse_inertia", "aref", "frictionloss", "stiffness")
"""Numbers of a row of a constraint, as `probe.constraint_rows` names them."""

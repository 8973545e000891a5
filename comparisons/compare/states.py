"""States at which two models are compared, and the rows of vectors that correspond."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from .elements import SWITCHES, Compiled, Match
from .gaps import QUANTITIES
from .reading import Reading, State

SEED = 1

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


class Contact(NamedTuple):
    """The geom with which MuJoCo's collision begins, and the numbers of a contact."""

    first: str
    numbers: Any


@dataclass(frozen=True)
class Side:
    """One of two models: its elements, and the rows of its vectors, in the order of A.

    Attributes
    ----------
    model : Compiled
    labels : mapping of str to mapping of int to str
        Kind of element -> number in this model -> label in A, in the order of A.
    rows : mapping of str to list of int
        Rows of ``qpos``, ``qvel``, ``act`` and ``ctrl`` in the order of A.
    """

    model: Compiled
    labels: Mapping[str, Mapping[int, str]]
    rows: Mapping[str, list[int]]

    def in_order(self, answer: Mapping[str, Any]) -> dict[str, Any]:
        """Return the answer at a state with the elements of A, in the order of A."""
        nq, nv = (int(self.model.field(name)) for name in ("nq", "nv"))
        dofs, acts = np.array(self.rows["qvel"], dtype=int), np.array(self.rows["act"], dtype=int)
        rows: dict[str, Any] = {kind: list(one) for kind, one in self.labels.items()}
        rows |= {"joint": dofs, "step": [*self.rows["qpos"], *(nq + dofs), *(nq + nv + acts)]}
        own = {
            name: value[rows[QUANTITIES.get(name.replace("floor_", "step_"), ("", "joint"))[1]]]
            for name, value in answer.items()
            if not name.startswith(("row_", "contact_"))
        }
        if "mass" in own:
            own["mass"] = own["mass"][:, dofs]
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
    models = one, other
    labels: list[dict[str, dict[int, str]]] = [
        {
            kind: {pair[i].number: pair[0].label for pair in match.pairs if pair[0].kind == kind}
            for kind in one.labels
        }
        for i in (0, 1)
    ]
    both = zip(models, labels, strict=True)
    starts = np.array([m.field("actuator_actadr")[[*own["actuator"]]] for m, own in both])
    active = starts[:, (starts >= 0).all(axis=0)]
    first, second = (
        Side(
            model,
            own,
            {
                "qpos": [row for i in own["joint"] for row in span(model, "jnt_qposadr", "nq", i)],
                "qvel": [row for i in own["joint"] for row in span(model, "jnt_dofadr", "nv", i)],
                "act": acts.tolist(),
                "ctrl": [control_of(model, i) for i in own["actuator"]],
            },
        )
        for model, own, acts in zip(models, labels, active, strict=True)
    )
    return first, second


def labels_of_rows(side: Side) -> dict[str, list[str]]:
    """Return the labels of the rows of quantities of A, by their kinds, see `gaps.QUANTITIES`."""
    labels = {kind: list(one.values()) for kind, one in side.labels.items()}
    joints, actuators = (side.model.labels[kind] for kind in ("joint", "actuator"))
    dofs = [joints[i] for i in side.model.field("dof_jntid")[side.rows["qvel"]]]
    address = side.model.field("jnt_qposadr")
    positions = [joints[np.searchsorted(address, row, "right") - 1] for row in side.rows["qpos"]]
    acts = side.model.field("actuator_actadr").tolist()
    active = [actuators[acts.index(row)] for row in side.rows["act"]]
    return {**labels, "joint": dofs, "step": [*positions, *dofs, *active]}


def translated(state: State, mine: Side, theirs: Side) -> State:
    """Return the state of A as one of B; components that A does not have are as B opens."""
    own = {name: np.array(values) for name, values in empty_state(theirs.model).items()}
    for name, values in own.items():
        values[theirs.rows[name]] = np.array(state[name])[mine.rows[name]]
    return {name: values.tolist() for name, values in own.items()}


def span(model: Compiled, address: str, count: str, number: int) -> range:
    """Return the rows of an element in a vector."""
    starts = [*model.field(address).tolist(), int(model.field(count))]
    return range(starts[number], starts[number + 1])


def control_of(model: Compiled, number: int) -> int:
    """Return the row of an actuator's control."""
    return int(model.answer.get("actuator_ctrladr", np.arange(number + 1))[number])


def empty_state(model: Compiled) -> dict[str, Any]:
    """Return the state in which a model opens."""
    return {
        "qpos": model.field("qpos0").tolist(),
        "qvel": [0.0] * int(model.field("nv")),
        "act": [0.0] * int(model.field("na")),
        "ctrl": [0.0] * int(model.field("nu")),
    }


def states_of(reading: Reading, sides: tuple[Side, Side]) -> dict[str, State]:
    """Return states by name: as opened, keyframes, random ones, beyond ranges, with contacts."""
    model = reading.model
    states: dict[str, State] = {"as opened": empty_state(model)}
    for i, name in enumerate(model.names["key"]):
        states[f"keyframe {name or i}"] = {
            part: model.field(f"key_{part}")[i].tolist() for part in ("qpos", "qvel", "act", "ctrl")
        }
    random = np.random.default_rng(SEED)
    drawn = [draw(model, random) for _ in range(TRIED)]
    states |= {f"random state {i + 1}": one for i, one in enumerate(drawn[:DRAWS])}
    states |= dict(beyond_controls(sides, drawn[0]))
    states |= dict(beyond_limits(sides, drawn[0]))
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
    limits = ends_of(model, "jnt_range")
    for number, kind in enumerate(model.types("jnt_type")):
        at = span(model, "jnt_qposadr", "nq", number)
        rows = slice(at.start, at.stop)
        if kind in ("ball", "free"):
            turn = random.normal(size=4)
            position[at.stop - 4 : at.stop] = turn / np.linalg.norm(turn)
            if kind == "free":
                position[at.start : at.start + 3] += random.uniform(-LENGTH, LENGTH, 3)
        elif np.all(np.isfinite(limits[number])):
            position[rows] = random.uniform(*limits[number])
        else:
            position[rows] += random.uniform(-1, 1) * (ANGLE if kind == "hinge" else LENGTH)
    low, high = np.nan_to_num(ends_of(model, "actuator_ctrlrange") * SIGNS, nan=1.0).T
    act_low, act_high = np.nan_to_num(ends_of(model, "actuator_actrange") * SIGNS, nan=1.0).T
    na = int(model.field("na"))
    return {
        "qpos": position.tolist(),
        "qvel": random.normal(size=int(model.field("nv"))).tolist(),
        "act": random.uniform(-np.resize(act_low, na), np.resize(act_high, na)).tolist(),
        "ctrl": random.uniform(-low, high).tolist(),
    }


SIGNS = np.array([-1.0, 1.0])
"""Directions out of a range at its two ends."""


def ends_of(model: Compiled, ranges: str) -> Any:
    """Return the ends of ranges (n, 2), NaN where there are none."""
    values = np.asarray(model.field(ranges), dtype=float)
    limited = np.asarray(model.field(SWITCHES[ranges]), dtype=bool)[:, None]
    return np.where(limited & np.isfinite(values), values, np.nan)


def outer_ends(sides: tuple[Side, Side], kind: str, ranges: str) -> Any:
    """Return the outer ends (n, 2) of the ranges of A and of B, for the elements of A."""
    ends = ends_of(sides[0].model, ranges)
    mine, theirs = (list(side.labels[kind]) for side in sides)
    other = ends_of(sides[1].model, ranges)[theirs]
    ends[mine] = SIGNS * np.fmax(SIGNS * ends[mine], SIGNS * other)
    return ends


def beyond_controls(sides: tuple[Side, Side], state: State) -> Iterator[tuple[str, State]]:
    """Yield states with controls and forces beyond their ranges in both models, if there are any.

    A control without a range is so large that the actuator's force is beyond its range, and that of
    its joint.
    """
    model, rows = sides[0].model, list(sides[0].labels["actuator"])
    force = abs(outer_ends(sides, "actuator", "actuator_forcerange")).max(axis=1)
    on_joint = np.isin(model.types("actuator_trntype"), ("joint", "jointinparent"))
    joints = model.field("actuator_trnid")[on_joint, 0]
    gear, gain = (abs(model.field(f"actuator_{name}")[:, 0]) for name in ("gear", "gainprm"))
    of_joints = abs(outer_ends(sides, "joint", "jnt_actfrcrange")).max(axis=1)[joints]
    force[on_joint] = np.fmax(force[on_joint], of_joints / np.where(gear, gear, 1.0)[on_joint])
    alone = 1 + BEYOND_RANGE * np.nan_to_num(force) / np.where(gain, gain, 1.0)
    controls, activations = (
        outer_ends(sides, "actuator", f"actuator_{name}") for name in ("ctrlrange", "actrange")
    )
    address = model.field("actuator_actadr")
    for end, name in enumerate(("below", "above") if rows else ()):
        ctrl, act, sign = np.array(state["ctrl"]), np.array(state["act"]), SIGNS[end]
        outside = controls[:, end] + sign * (controls[:, 1] - controls[:, 0])
        edge = activations[:, end]
        free = np.nan_to_num(edge) + sign * alone
        ctrl[sides[0].rows["ctrl"]] = np.where(np.isnan(outside), free, outside)[rows]
        act[address[address >= 0]] = np.where(np.isnan(edge), free, edge)[address >= 0]
        yield f"controls {name} their ranges", {**state, "ctrl": ctrl.tolist(), "act": act.tolist()}


def beyond_limits(sides: tuple[Side, Side], state: State) -> Iterator[tuple[str, State]]:
    """Yield states in which all joints are a little beyond their lower, or their upper, limits."""
    model, ends = sides[0].model, outer_ends(sides, "joint", "jnt_range")
    kinds = model.types("jnt_type")
    beyond = BEYOND * np.nan_to_num(ends[:, 1] - ends[:, 0], nan=1.0)
    for end, name in enumerate(("lower", "upper")):
        position, velocity = np.array(state["qpos"]), np.array(state["qvel"])
        for i in (limited := np.flatnonzero(np.isfinite(ends[:, end]))):
            row, dof = (int(model.field(address)[i]) for address in ("jnt_qposadr", "jnt_dofadr"))
            if kinds[i] == "ball":
                half, axis = (ends[i, 1] + beyond[i]) / 2, position[row + 1 : row + 4]
                axis *= np.sin(half) / np.linalg.norm(axis)
                position[row] = np.cos(half)
            else:
                position[row] = ends[i, end] + SIGNS[end] * beyond[i]
                velocity[dof] = SIGNS[end] * abs(velocity[dof])  # into the limit
        if len(limited):
            yield (
                f"joints at their {name} limits",
                {**state, "qpos": position.tolist(), "qvel": velocity.tolist()},
            )

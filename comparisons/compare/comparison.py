"""`compare`: the differences of two readings of a model, and the edits that close the gap."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ...reference.errors import MbcheckError, UsageError
from ..documents import document
from ..documents.fields import HIDDEN, documented
from ..documents.waivers import Waiver, waivers_of
from ..reports.item import ReportItem
from .elements import (
    REFERENCES,
    SWITCHES,
    Attribute,
    Compiled,
    Match,
    ModelElement,
    difference_share,
    match_elements,
    names_of_both,
    touches_nothing,
)
from .engine import EngineReading
from .explain import INERTIAL, OPEN_SHARE, Guess, find_edits, guesses
from .gaps import Gap, acceleration_roundoff, distinct, gaps_between
from .reading import Edit, Operand, Reading
from .states import Side, sides_of, states_of, translated

EQUAL = 1e-9
"""Share by which numbers of two files may differ in rounding."""

WRITTEN = 1e-3
"""The same of a file and its copy by MuJoCo, which writes six digits; a larger one is a loss."""

SINGLE = 1e-6
"""The same of fields that MuJoCo keeps in numbers of 32 bits."""

CCD = ("ccd_iterations", "ccd_tolerance")
"""Options of the routine of collisions between convex shapes."""

NEVER_SAVED = re.compile(r"\b(euler|axisangle|xyaxes|zaxis|fromto|dampratio)\s*=|<include\b")
"""Words of MJCF that MuJoCo never writes, since it computes other attributes from them."""

MEASURED = 60
"""Differences whose effects are measured at the most."""

RULE, UNUSED = "compare", "waiver_unused"
"""Rules of reports: a difference, and a waiver that waives nothing."""

MIN_FORCE = 1e-6
"""Share of the largest force below which the force of a joint counts as that large."""

MASS_WEIGHT = 1e4
"""Weight of errors of a mass matrix relative to those of forces: edits explain the former first."""

MAX_VALUES = 6
"""Numbers of an attribute that are shown at the most."""

NEUTRAL: Mapping[str, Mapping[str, float]] = {
    "geom": {"geom_contype": 0, "geom_conaffinity": 0},
    "equality": {"eq_active0": 0},
    "actuator": {"actuator_gear": 0},
    "tendon": {
        "tendon_stiffness": 0, "tendon_damping": 0, "tendon_frictionloss": 0, "tendon_limited": 0,
    },
}  # fmt: skip
"""Kind of element -> values of its fields with which it does nothing."""

TYPES = ("actuator_gaintype", "actuator_biastype", "actuator_dyntype")
"""Fields of types that can be edited in a compiled model; others cannot."""

RETARGETED = ("actuator_trnid", "eq_obj1id", "eq_obj2id")
"""References to elements that can be edited in a compiled model."""

WITH = {"body_inertia": "body_iquat"}
"""Field -> another that says in which frame it is."""


@dataclass(frozen=True)
class Difference:
    """An attribute in which two compiled models differ.

    Attributes
    ----------
    element : str
        which element, as A names it
    attribute : str
        which attribute, as MJCF spells it; empty if the whole element is lost or new
    before : str
        its value in A
    after : str
        its value in B
    effect : float or None
        by how much the acceleration of a joint changes with this edit of A alone, relative to its
        largest at the states; 0 if by no more than round-off, null if it cannot be tried
    seen : str
        if the effect is 0, a quantity that this edit changes all the same, and the state
    unit : str
        Unit of its values where files have another: angles are in radians.
    edits : list of Edit
        Edits that give A's model the values of B.
    share : float
        The largest difference of its numbers, in the largest of them; infinite of words.
    written : float
        The same, of positions in no less than a meter: a sum of written numbers may be next to 0.
    """

    element: str
    attribute: str
    before: str
    after: str
    effect: float | None = None
    seen: str = ""
    unit: str = field(default="", metadata=HIDDEN)
    edits: Sequence[Edit] = field(default=(), metadata=HIDDEN)
    share: float = field(default=math.inf, metadata=HIDDEN)
    written: float = field(default=math.inf, metadata=HIDDEN)

    @property
    def id(self) -> str:
        """Element and attribute."""
        return f"{self.element} {self.attribute}".strip()

    @property
    @documented
    def sentence(self) -> str:
        """The difference in words."""
        if not self.attribute:
            return f"{self.element} {'lost' if self.after == 'lost' else 'is new'}"
        before, after = (
            f"{words} {self.unit}" if self.unit and words[-1:].isdigit() else words
            for words in (self.before, self.after)
        )
        dropped = self.after in ("none", "no limit") or set(self.after.split()) == {"0"}
        words = (self.attribute, before, "dropped" if dropped else f"read as {after}")
        return f"{self.element}: {' '.join(filter(None, words))}"


@dataclass(frozen=True)
class ModelComparison:
    """The differences of two readings of one model.

    Attributes
    ----------
    a : str
        the first model, and who reads it
    b : str
        the second
    versions : mapping of str to str
        the reader of each, with its version
    conventions : sequence of str
        departures of an engine from the protocol of engines, which are accounted for
    renamed : sequence of str
        elements that have another name, or another place in the order, in B
    differences : sequence of Difference
        what was compiled differently, the largest effect first
    idle_defaults : sequence of str
        defaults of options that changed between two releases, without effect on this model
    gaps : sequence of Gap
        what they do differently at states
    left : sequence of Gap
        gaps that remain after A is edited by all differences
    states : sequence of str
        names of the states; none if they have no states in common
    why_no_states : str
        why not
    rounded : int
        number of attributes that differ by the digits of a text alone
    not_compared : sequence of str
        fields that are in one release of MuJoCo alone
    waived : mapping of str to str
        reasons of waivers, by element and attribute
    unused_waivers : sequence of str
        waivers of this model that waive nothing
    idle_waivers : sequence of str
        waivers that waive nothing here, and may concern other models
    """

    a: str
    b: str
    versions: Mapping[str, str]
    conventions: Sequence[str]
    renamed: Sequence[str]
    differences: Sequence[Difference]
    idle_defaults: Sequence[str]
    gaps: Sequence[Gap]
    left: Sequence[Gap]
    states: Sequence[str]
    why_no_states: str
    rounded: int
    not_compared: Sequence[str]
    waived: Mapping[str, str] = field(default_factory=dict)
    unused_waivers: Sequence[str] = ()
    idle_waivers: Sequence[str] = ()

    @property
    @documented
    def closed(self) -> bool | None:
        """Whether the edits close the gap to rounding; null if there is no gap."""
        return not self.left if self.gaps else None

    @property
    def findings(self) -> list[Difference | Gap]:
        """Differences, and gaps that they do not explain, but for those that are waived."""
        every: list[Difference | Gap] = [*self.differences, *self.left]
        return [one for one in every if one.id not in self.waived]

    @property
    def exit_code(self) -> int:
        """1 if a difference is not waived."""
        return int(bool(self.findings))

    def as_json(self) -> dict[str, Any]:
        """Return the ``compare`` document of docs/json.md."""
        return document("compare", self)

    def items(self) -> list[ReportItem]:
        """Return an item for each finding, and one for each waiver that waives nothing."""
        file = self.a.rpartition("@")[0] or self.a
        items = []
        for one in self.findings:
            numbers, message = dict[str, object](), one.sentence
            if isinstance(one, Gap):
                message += ", and no edit explains it"
            else:
                numbers = {"before": one.before, "after": one.after, "effect": one.effect}
            items.append(
                ReportItem(
                    id=one.id, rule=RULE, suite=self.b, outcome="failure", severity="error",
                    message=message, file=file, numbers=numbers,
                )
            )  # fmt: skip
        items += [
            ReportItem(one, UNUSED, self.b, "skipped", "warning", one, file=file)
            for one in self.unused_waivers
        ]
        return items or [ReportItem(RULE, RULE, self.b, "pass", None, "", file=file)]


def compare(
    a: str | Path, b: str | Path, install: bool = False, waivers: str | Path | None = None
) -> ModelComparison:
    """Compare two readings of one model.

    Parameters
    ----------
    a, b : str or Path
        ``FILE``, or ``FILE@READER``: ``mujoco``, ``mujoco==3.3.7``, or a path of a Python that has
        MuJoCo and NumPy.
    install : bool
        Make an environment for a missing release, in the user's cache.
    waivers : str or Path, optional
        File of waivers, each with its reason.

    Raises
    ------
    UsageError
        If a file cannot be read, or there is no such reader.
    EngineError
        If a process that reads a file ends, or does not answer in time.
    """
    names = str(a), str(b)
    operands = [Operand.parse(text) for text in names]
    if operands[0].is_engine:
        raise UsageError(
            f"an engine is compared with MuJoCo: mbcheck compare {operands[0].file} {a}"
        )
    allowed = waivers_of(Path(waivers), operands[0].file, (RULE,)) if waivers else ()
    with ExitStack() as stack:
        first, second = (
            stack.enter_context(
                EngineReading(one) if one.is_engine else Reading(one, one.python(install))
            )
            for one in operands
        )
        return with_waivers(compared(first, second, names), allowed)


def with_waivers(result: ModelComparison, waivers: Sequence[Waiver]) -> ModelComparison:
    """Return a comparison whose findings are waived, and waivers that waive nothing."""
    waived, idle = dict[str, str](), list(waivers)
    for one in result.findings:
        waiver = next((w for w in waivers if w.covers(RULE, *names_in_waivers(one))), None)
        if waiver:
            waived[one.id] = waiver.reason
            idle = [other for other in idle if other is not waiver]
    words = {w: f"{w.file}, line {w.line}: {w.pattern or 'all'}" for w in idle}
    return replace(
        result,
        waived=waived,
        unused_waivers=[f"{words[w]} is alike, remove the waiver" for w in idle if w.required],
        idle_waivers=[f"{words[w]} waives nothing here" for w in idle if not w.required],
    )


def names_in_waivers(one: Difference | Gap) -> list[str]:
    """Return the names of a finding: its id, its element as here and as `inspect` spells it."""
    kind, _, name = one.element.partition(" ")
    elements = [one.element, f"{kind}:{name}", name]
    ending = f" {one.attribute}" if isinstance(one, Difference) else ""
    return [one.id, *elements, *(element + ending for element in elements)]


def compared(first: Reading, second: Reading, names: tuple[str, str]) -> ModelComparison:
    """Return the differences of two readings."""
    one, other = first.model, second.model
    match = match_elements(one, other)
    every = list(differences_of(one, other, match))
    rounding = rounded(first, second, every)
    differences = [each for each in every if each not in rounding]
    sides = sides_of(one, other, match)
    trial, gaps, left, idle = None, list[Gap](), list[Gap](), list[Difference]()
    if not isinstance(sides, str):
        trial = EditTrial(first, second, match, sides, edits_in(rounding))
        if isinstance(second, EngineReading):
            trial, lost = read_by_engine(trial, second, edits_in(differences))
            differences += lost
        gaps = trial.gaps()
        left = trial.gaps(edits_in(differences)) if gaps else []
        differences = [*map(trial.measured, differences[:MEASURED]), *differences[MEASURED:]]
        differences.sort(key=lambda d: -1.0 if d.effect is None else d.effect, reverse=True)
        idle = [d for d in differences if (d.effect, d.seen) == (0, "") and why_idle(one, other, d)]
        differences = [d for d in differences if d not in idle]
    physical = [
        {*m.fields, *(key for key in m.answer if key.startswith("opt."))} for m in (one, other)
    ]
    return ModelComparison(
        a=names[0],
        b=names[1],
        versions={"a": first.version, "b": second.version},
        conventions=second.conventions if isinstance(second, EngineReading) else [],
        renamed=list(renamed(one, other, match)),
        differences=differences,
        idle_defaults=[f"{d.sentence} ({why_idle(one, other, d)})" for d in idle],
        gaps=gaps,
        left=left,
        states=list(trial.states) if trial else [],
        why_no_states=sides if isinstance(sides, str) else "",
        rounded=sum(d.share > EQUAL for d in rounding),
        not_compared=sorted(physical[0] ^ physical[1]),
    )


def read_by_engine(
    trial: EditTrial, engine: EngineReading, before: Sequence[Edit]
) -> tuple[EditTrial, list[Difference]]:
    """Return a trial in the convention of an engine, and what the engine read differently.

    A convention other than the protocol's counts only if edits close the gap in it, and do not in
    the protocol's.
    """
    lost = list(trial.read_differently(before)) if trial.gaps() else []
    if len(engine.likely) > 1 and trial.gaps([*before, *edits_in(lost)]):
        protocol, other = engine.likely
        engine.likely = [other]
        another = EditTrial(trial.first, engine, trial.match, trial.sides, trial.always)
        explained = list(another.read_differently(before))
        if not another.gaps([*before, *edits_in(explained)]):
            return another, explained
        engine.likely = [protocol]
    return trial, lost


def edits_in(differences: Sequence[Difference]) -> list[Edit]:
    """Return all edits of some differences."""
    return [edit for one in differences for edit in one.edits]


def why_idle(one: Compiled, other: Compiled, difference: Difference) -> str:
    """Return the reason why a changed default of an option does nothing; empty if it may."""
    name, models = difference.attribute, (one, other)
    is_default = [
        np.array_equal(m.answer.get(f"opt.{name}", ()), m.answer.get(f"default.{name}", ()))
        for m in models
    ]
    if difference.element == "option" and all(is_default):
        flags = {flag for m in models for flag in m.options.attribute("enableflags").values}
        if name == "sleep_tolerance" and "sleep" not in flags:
            return "sleep is off"
        if name in CCD and not any(m.collides_convexly for m in models):
            return "no geoms that collide as convex shapes"
    return ""


# What was compiled ---------------------------------------------------------------------------


def differences_of(one: Compiled, other: Compiled, match: Match) -> Iterator[Difference]:
    """Yield the attributes that differ, were it in the last digit."""
    common = set(one.answer) & set(other.answer)
    for mine, theirs in match.pairs:
        for name in names_of_both(mine, theirs):
            pair = [side.attribute(name) for side in (mine, theirs)]
            fields = [key for attribute in pair for key in attribute.rows]
            if not common.issuperset(fields):
                continue
            single = any(one.answer[key].dtype == np.float32 for key in fields)
            before, after = (attribute.values for attribute in pair)
            share = difference_share(before, after, 1.0 if mine.kind == "key" else 0.0)
            if name == "kv" and share:  # computed from kp where a file has dampratio
                ratios = damping_ratio(one, mine), damping_ratio(other, theirs)
                apart = abs(ratios[1] - ratios[0]) / ratios[0] if all(ratios) else 1.0
                share = min(share, max(apart, EQUAL))  # rounding, whose edit is made
                if share <= EQUAL and mine.attribute("kp").values != theirs.attribute("kp").values:
                    continue  # the edit of kp has both
            if share:
                share = min(share, EQUAL) if single and share <= SINGLE else share
                least = 1.0 if name.endswith("pos") else 0.0
                yield Difference(
                    mine.label,
                    name,
                    *distinct(*printed_values(one, other, pair), 6),
                    unit=unit_of(mine, name),
                    edits=list(edits_of(one, other, pair)),
                    share=share,
                    written=min(share, difference_share(before, after, least)),
                )
    for element, word in [(e, "lost") for e in match.gone] + [(e, "new") for e in match.new]:
        if element.kind == "geom" and touches_nothing(element.attributes):
            continue  # drawn only
        edits = list(neutral(one, element)) if word == "lost" else []
        yield Difference(element.label, "", "", word, edits=edits)


def unit_of(element: ModelElement, attribute: str) -> str:
    """Return the unit of an angle of a joint, which files give in degrees or radians."""
    kinds = element.attribute("type").values
    is_angle = element.kind == "joint" and attribute in ("range", "ref", "springref")
    return "rad" if is_angle and kinds[0] in ("hinge", "ball") else ""


def damping_ratio(model: Compiled, element: ModelElement) -> float:
    """Return ``dampratio`` of a servo on a joint, gear kv / (2 sqrt(kp M)); zero of others.

    M is the joint's diagonal entry of the mass matrix as the file opens. Source: MuJoCo's XML
    reference, actuator/position.
    """
    row = element.number
    if "kp" not in element.attributes or model.field("actuator_trntype")[row] != "joint":
        return 0.0
    kp, kv = (element.attributes[name].values[0] for name in ("kp", "kv"))
    joint, gear = (model.field(f"actuator_{name}")[row, 0] for name in ("trnid", "gear"))
    mass = model.field("dof_M0")[model.field("jnt_dofadr")[joint]]
    return float(abs(gear) * kv / (2 * math.sqrt(kp * mass))) if kp * mass > 0 else 0.0


def edits_of(one: Compiled, other: Compiled, pair: Sequence[Attribute]) -> Iterator[Edit]:
    """Yield edits that give A's element the values of B's, as far as a compiled model allows."""
    values = pair[1].values
    for name, rows in pair[0].rows.items():
        theirs = pair[1].rows.get(name) or ()
        if rows is None:
            yield name, None, other.field(name).tolist()
        elif name in TYPES:
            if name != "actuator_dyntype" or one.field("actuator_actadr")[rows[0]] >= 0:
                yield name, rows, values
        elif name in RETARGETED and theirs:
            targets = np.full_like(one.field(name)[rows], -1)
            targets.flat[: len(values)] = [number_of(one, label) for label in values]
            yield name, rows, targets.tolist()
        elif name in REFERENCES or name.startswith("sensor_") or len(theirs) != len(rows):
            continue
        elif one.field(name).dtype.kind != "U":
            for own in (name, WITH.get(name, ""), SWITCHES.get(name, "")):
                if own in one.answer:
                    yield own, rows, other.field(own)[theirs].tolist()


def number_of(model: Compiled, label: str) -> int:
    """Return the number of an element, -1 if there is none of this label."""
    listed = next((one for one in model.labels.values() if label in one), [])
    return listed.index(label) if listed else -1


def neutral(model: Compiled, element: ModelElement) -> Iterator[Edit]:
    """Yield what leaves an element without effect."""
    for name, value in NEUTRAL.get(element.kind, {}).items():
        rows = element.attribute(name.partition("_")[2]).rows.get(name, [element.number])
        yield name, list(rows), np.full(model.field(name)[rows].shape, value).tolist()


def renamed(one: Compiled, other: Compiled, match: Match) -> Iterator[str]:
    """Yield elements that have another name in B, and kinds of which the order is another."""
    for mine, theirs in match.pairs:
        names = one.names[mine.kind][mine.number], other.names[theirs.kind][theirs.number]
        if names[0] != names[1]:
            yield f"{mine.label} is {other.labels[theirs.kind][theirs.number]} in B"
    for kind in one.labels:
        order = [b.number for a, b in match.pairs if a.kind == kind]
        if order != sorted(order):
            yield f"the order of {kind} elements is another"


def printed_values(one: Compiled, other: Compiled, pair: Sequence[Attribute]) -> tuple[Any, Any]:
    """Return the values of an attribute to be printed: quaternions in place of rotations."""
    for name in pair[0].rows.keys() & pair[1].rows.keys():
        if name.endswith("_quat"):
            mine, theirs = (
                np.ravel(model.field(name)[side.rows[name]])
                for model, side in zip((one, other), pair, strict=True)
            )
            return mine.tolist(), (theirs if mine @ theirs >= 0 else -theirs).tolist()
    return shortened(pair[0].values, pair[1].values)


def shortened(before: Sequence[Any], after: Sequence[Any]) -> tuple[Sequence[Any], Sequence[Any]]:
    """Return the values that differ where there are many, else all up to the last that differs."""
    if len(before) != len(after):
        return before[:MAX_VALUES], after[:MAX_VALUES]
    floats = [abs(v) for v in (*before, *after) if isinstance(v, float) and math.isfinite(v)]
    size = EQUAL * max(floats, default=0.0)
    before, after = (
        [0.0 if isinstance(v, float) and abs(v) <= size else v for v in values]
        for values in (before, after)
    )
    apart = [i for i, (x, y) in enumerate(zip(before, after, strict=True)) if x != y]
    last = apart[-1] + 1 if apart else 1
    if last > MAX_VALUES:
        return [before[i] for i in apart[:MAX_VALUES]], [after[i] for i in apart[:MAX_VALUES]]
    return before[:last], after[:last]


def is_saved_by_mujoco(text: str) -> bool:
    """Return True if a file is written as MuJoCo writes it: radians, numbers of six digits."""
    text = re.sub(r"<!--.*?-->|<config\b[^>]*>", "", text, flags=re.DOTALL)
    if not re.search(r'angle\s*=\s*"radian"', text) or NEVER_SAVED.search(text):
        return False
    numbers = re.findall(r"(?<![\w.+-])[-+]?\d*\.\d+(?:[eE][-+]?\d+)?(?![\w.])", text)
    return all(one == f"{float(one):.6g}" for one in numbers)


def rounded(first: Reading, second: Reading, differences: Sequence[Difference]) -> list[Difference]:
    """Return the differences that rounding explains.

    If MuJoCo has saved one of the files, so are those that vanish once it writes the other.
    """
    pairs = list[tuple[Compiled, Compiled]]()
    if first.text != second.text and any(
        one.share > EQUAL and one.written <= WRITTEN for one in differences
    ):
        if is_saved_by_mujoco(second.text):
            pairs.append((first.written(), second.model))
        if is_saved_by_mujoco(first.text):
            pairs.append((first.model, second.written()))
    left = [
        {d.id for d in differences_of(one, other, match_elements(one, other)) if d.share > EQUAL}
        for one, other in pairs
    ]
    return [
        one
        for one in differences
        if one.share <= EQUAL
        or (one.written <= WRITTEN and any(one.id not in still for still in left))
    ]


# What they do --------------------------------------------------------------------------------


class EditTrial:
    """States at which A, with edits, is compared with B.

    Parameters
    ----------
    first, second : Reading
    match : Match
    sides : tuple of Side
    always : sequence of Edit
        Edits of A that are always made: attributes that differ by the digits of a text.
    """

    def __init__(
        self,
        first: Reading,
        second: Reading,
        match: Match,
        sides: tuple[Side, Side],
        always: Sequence[Edit],
    ) -> None:
        self.first, self.match, self.sides, self.always = first, match, sides, always
        self.states = states_of(first, sides)
        if isinstance(second, EngineReading):  # which has no activations
            rest = [0.0] * int(first.model.field("na"))
            self.states = {name: {**one, "act": rest} for name, one in self.states.items()}
        self.eps = max(first.eps, second.eps)
        theirs = [translated(state, *sides) for state in self.states.values()]
        self.other = [sides[1].in_order(one) for one in second.at(theirs)]
        self.own = self.answers(())
        self.accelerations = np.array([one["qacc"] for one in self.own])

    def answers(self, edits: Sequence[Edit], brief: bool = False) -> list[dict[str, Any]]:
        """Return the answers of A after edits; in brief accelerations and mass matrices alone."""
        answers = self.first.at(list(self.states.values()), [*self.always, *edits], brief)
        return [self.sides[0].in_order(one) for one in answers]

    def gaps(self, edits: Sequence[Edit] = ()) -> list[Gap]:
        """Return the gaps between A, with edits, and B; edits that cannot be made close none."""
        try:
            own = self.answers(edits) if edits else self.own
        except MbcheckError:
            own = self.own
        return self.gaps_of(self.other, own)

    def gaps_of(self, answers: Any, own: Any = None) -> list[Gap]:
        """Return the gaps between answers and those of A, or others."""
        labels = {kind: list(one.values()) for kind, one in self.sides[0].vectors.items()}
        return gaps_between(own or self.own, answers, list(self.states), labels, self.eps)

    def misfit(self, edits: Sequence[Edit], weight: float) -> Any:
        """Return the errors of A, after edits, in the accelerations and mass matrices of B.

        First the forces M (a_B - a_A), relative to the largest of each joint, which are linear in
        inertias and forces of A where there are no constraints; then the differences of mass
        matrices, as far as B has these, in units of sqrt(M_ii M_jj), times a weight.
        """
        size = abs(np.array([one["mass"] @ one["qacc"] for one in self.own])).max(axis=0)
        scale = np.maximum(size, MIN_FORCE * size.max(initial=0.0) or 1.0)
        forces, masses = list[Any](), list[Any]()
        for own, one, other in zip(self.own, self.answers(edits, True), self.other, strict=True):
            forces.append(one["mass"] @ (other["qacc"] - one["qacc"]) / scale)
            unit = np.sqrt(np.diag(own["mass"]))
            masses.append((one["mass"] - other.get("mass", one["mass"])) / np.outer(unit, unit))
        return np.concatenate([np.ravel(forces), weight * np.ravel(masses)])

    def read_differently(self, before: Sequence[Edit]) -> Iterator[Difference]:
        """Yield the attributes that an engine lost or scaled, after edits that are known."""
        picks = self.explanation(before)
        elements = {one.label: one for one, _ in self.match.pairs}
        for one, factor in picks:
            values, read = one.cells(factor)
            cells = distinct(*shortened(values, read), 6) if values else ("", str(read[0]))
            unit = unit_of(elements.get(one.element, self.match.pairs[0][0]), one.attribute)
            edits = [one.edit(factor)]
            yield Difference(one.element, one.attribute, *cells, unit=unit, edits=edits)

    def explanation(self, before: Sequence[Edit]) -> list[tuple[Guess, float]]:
        """Return the attributes that an engine multiplied, with their factors.

        Masses, inertias and armatures are among them only if the mass matrices then agree, or, of
        an engine that has none, if no gap is left. If one is left, it distorts the factors of the
        fit, and other attributes are named only if lost completely.
        """
        candidates = list(guesses(self.first.model, [pair[0] for pair in self.match.pairs]))

        def explained_by(weight: float, candidates: Sequence[Guess]) -> list[tuple[Guess, float]]:
            return find_edits(
                lambda edits: self.misfit([*before, *edits], weight),
                lambda edits: not self.gaps([*before, *edits]),
                candidates,
            )

        def edits_of(picks: Sequence[tuple[Guess, float]]) -> list[Edit]:
            return [*before, *(one.edit(factor) for one, factor in picks)]

        picks = explained_by(MASS_WEIGHT, candidates)
        left = {gap.quantity for gap in self.gaps(edits_of(picks))}
        if left and ("mass" not in self.other[0] or "mass matrix" in left):
            picks = explained_by(0.0, [one for one in candidates if one.field not in INERTIAL])
            left = {gap.quantity for gap in self.gaps(edits_of(picks))}
        if left:
            inertial = [one for one in picks if one[0].field in INERTIAL]
            picks = [one for one in picks if one in inertial or one[0].is_lost(one[1])]
            ends = [np.linalg.norm(self.misfit(edits, 0.0)) for edits in (before, edits_of(picks))]
            return picks if ends[1] <= OPEN_SHARE * ends[0] else inertial
        return picks

    def measured(self, difference: Difference) -> Difference:
        """Return a difference with its effect on accelerations."""
        if not difference.edits:
            return difference
        try:
            edited = np.array([one["qacc"] for one in self.answers(difference.edits, brief=True)])
        except MbcheckError:
            return difference
        apart, least = abs(edited - self.accelerations), self.roundoff
        scale = np.maximum(abs(self.accelerations).max(axis=0, initial=0.0), least)
        effect = np.max(np.where(apart > least, apart / scale, 0.0), initial=0.0)
        if effect == 0.0:
            other = self.gaps_of(self.answers(difference.edits))
            seen = f"{other[0].quantity}, {other[0].state}" if other else ""
            return replace(difference, effect=0.0, seen=seen)
        return replace(difference, effect=float(effect) if math.isfinite(effect) else None)

    @cached_property
    def roundoff(self) -> Any:
        """Round-off of each acceleration at each state (states, n)."""
        return np.array([acceleration_roundoff(one, self.eps) for one in self.own])

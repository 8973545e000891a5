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
from ..reports.words import number
from .elements import (
    ENUMERATIONS,
    REFERENCES,
    SWITCHES,
    Attribute,
    Compiled,
    Match,
    ModelElement,
    difference_share,
    field_key,
    match_elements,
    names_of_both,
    touches_nothing,
)
from .engine import EngineReading
from .explain import find_edits, guesses
from .gaps import Gap, gaps_between
from .reading import Edit, Operand, Reading
from .states import Side, StateRows, layout, states_of

EQUAL = 1e-9
"""Share by which numbers of two files may differ in rounding."""

SIX_DIGITS = 1e-5
"""The same of a file that was written with six digits, as MuJoCo writes them, beside one with more:
half a unit of the sixth digit, and what follows from several such numbers."""

SINGLE = 1e-6
"""The same of fields that MuJoCo keeps in numbers of 32 bits."""

NEVER_SAVED = re.compile(r"\b(euler|axisangle|xyaxes|zaxis|fromto|dampratio|include)\b")
"""Words of MJCF that MuJoCo never writes, since it computes other attributes from them."""

MEASURED = 60
"""Differences whose effects are measured at the most."""

RULE, UNUSED = "compare", "waiver_unused"
"""Rules of reports: a difference, and a waiver that waives nothing."""

MIN_FORCE = 1e-6
"""Share of the largest force below which the force of a joint counts as that large."""

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

OPTION_WORDS = {
    "integrator": "mjtIntegrator",
    "cone": "mjtCone",
    "solver": "mjtSolver",
    "jacobian": "mjtJacobian",
}
FLAGS = {"disableflags": "mjtDisableBit", "enableflags": "mjtEnableBit"}
"""Option -> the enumeration of its number, or of its bits."""

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
        by how much accelerations change with this edit of A alone, relative to the largest; null
        if it cannot be tried
    edits : list of Edit
        Edits that give A's model the values of B.
    share : float
        The largest difference of its numbers, in the largest of them; infinite of words.
    """

    element: str
    attribute: str
    before: str
    after: str
    effect: float | None = None
    edits: Sequence[Edit] = field(default=(), metadata=HIDDEN)
    share: float = field(default=math.inf, metadata=HIDDEN)

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
        dropped = self.after in ("none", "no limit") or set(self.after.split()) == {"0"}
        words = (self.attribute, self.before, "dropped" if dropped else f"read as {self.after}")
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
    """

    a: str
    b: str
    versions: Mapping[str, str]
    conventions: Sequence[str]
    renamed: Sequence[str]
    differences: Sequence[Difference]
    gaps: Sequence[Gap]
    left: Sequence[Gap]
    states: Sequence[str]
    why_no_states: str
    rounded: int
    not_compared: Sequence[str]
    waived: Mapping[str, str] = field(default_factory=dict)
    unused_waivers: Sequence[str] = ()

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


def compare(a: str, b: str, install: bool = False, waivers: str | None = None) -> ModelComparison:
    """Compare two readings of one model.

    Parameters
    ----------
    a, b : str
        ``FILE``, or ``FILE@READER``: ``mujoco``, ``mujoco==3.3.7``, or a path of a Python that has
        MuJoCo and NumPy.
    install : bool
        Make an environment for a missing release, in the user's cache.
    waivers : str or None
        File of waivers, each with its reason.

    Raises
    ------
    UsageError
        If a file cannot be read, or there is no such reader.
    EngineError
        If a process that reads a file ends, or does not answer in time.
    """
    operands = [Operand.parse(text) for text in (a, b)]
    if operands[0].is_engine:
        raise UsageError(
            f"an engine is compared with MuJoCo: mbcheck compare {operands[0].file} {a}"
        )
    allowed = waivers_of(Path(waivers), operands[0].file, (RULE,)) if waivers else ()
    with ExitStack() as stack:
        first, second = (stack.enter_context(opened(one, install)) for one in operands)
        return with_waivers(compared(first, second, (a, b)), allowed)


def with_waivers(result: ModelComparison, waivers: Sequence[Waiver]) -> ModelComparison:
    """Return a comparison whose findings are waived, and waivers that waive nothing."""
    waived, used = dict[str, str](), set[Waiver]()
    for one in result.findings:
        waiver = next((w for w in waivers if w.covers(RULE, one.id)), None)
        if waiver:
            waived[one.id] = waiver.reason
            used.add(waiver)
    unused = [
        f"{one.file}, line {one.line}: {one.pattern or 'all'} is alike, remove the waiver"
        for one in waivers
        if one.required and one not in used
    ]
    return replace(result, waived=waived, unused_waivers=unused)


def opened(operand: Operand, install: bool) -> Reading:
    """Return a file as its reader reads it."""
    if operand.is_engine:
        return EngineReading(operand)
    return Reading(operand, operand.python(install))


def compared(first: Reading, second: Reading, names: tuple[str, str]) -> ModelComparison:
    """Return the differences of two readings."""
    one, other = first.model, second.model
    match = match_elements(one, other)
    share = SIX_DIGITS if is_saved_by_mujoco(first) != is_saved_by_mujoco(second) else EQUAL
    every = list(differences_of(one, other, match))
    differences = [d for d in every if d.share > share]
    rounding = [d for d in every if d.share <= share]
    rows = layout(one, other, match)
    gaps, left, states = list[Gap](), list[Gap](), list[str]()
    if isinstance(rows, StateRows):
        trial = EditTrial(first, second, match, rows, [e for d in rounding for e in d.edits])
        states = list(trial.states)
        gaps = trial.gaps(())
        if gaps and isinstance(second, EngineReading):
            differences += trial.read_differently([e for d in differences for e in d.edits])
        differences = [*map(trial.measured, differences[:MEASURED]), *differences[MEASURED:]]
        differences.sort(key=lambda d: -1.0 if d.effect is None else d.effect, reverse=True)
        left = trial.left([e for d in differences for e in d.edits], gaps) if gaps else []
    return ModelComparison(
        a=names[0],
        b=names[1],
        versions={"a": first.version, "b": second.version},
        conventions=second.conventions,
        renamed=list(renamed(one, other, match)),
        differences=differences,
        gaps=gaps,
        left=left,
        states=states,
        why_no_states="" if isinstance(rows, StateRows) else rows,
        rounded=sum(d.share > EQUAL for d in rounding),
        not_compared=sorted(physical_names(one) ^ physical_names(other)),
    )


def physical_names(model: Compiled) -> set[str]:
    """Return the fields and options of a release."""
    options = {key for key in model.answer if key.startswith("opt.")}
    return {*model.fields, *options}


# What was compiled ---------------------------------------------------------------------------


def differences_of(one: Compiled, other: Compiled, match: Match) -> Iterator[Difference]:
    """Yield the attributes that differ, were it in the last digit."""
    common = set(one.answer) & set(other.answer)
    for mine, theirs in [(option_element(one), option_element(other)), *match.pairs]:
        for name in names_of_both(mine, theirs):
            pair = [side.attribute(name) for side in (mine, theirs)]
            fields = [field_key(key) for attribute in pair for key in attribute.rows]
            if not common.issuperset(fields):
                continue
            single = any(one.answer[key].dtype == np.float32 for key in fields)
            before, after = (attribute.values for attribute in pair)
            share = difference_share(before, after, 1.0 if mine.kind == "key" else 0.0)
            if share:
                share = min(share, EQUAL) if single and share <= SINGLE else share
                edits = list(edits_of(one, other, pair))
                yield Difference(
                    mine.label, name, *cells_of(before, after), edits=edits, share=share
                )
    for element, word in [(e, "lost") for e in match.gone] + [(e, "new") for e in match.new]:
        if element.kind == "geom" and touches_nothing(element.attributes):
            continue  # drawn only
        edits = list(neutral(one, element)) if word == "lost" else []
        yield Difference(element.label, "", "", word, edits=edits)


def option_element(model: Compiled) -> ModelElement:
    """Return the options of a model as one element, its flags by their names."""
    attributes = {}
    for key, value in model.answer.items():
        group, _, name = key.partition(".")
        if group != "opt" or name.startswith("o_"):
            continue
        values: list[Any] = np.ravel(value).tolist()
        if name in OPTION_WORDS:
            values = [model.word(OPTION_WORDS[name], int(value))]
        if name in FLAGS:
            numbers, words = (
                model.answer[f"{part}.{FLAGS[name]}"] for part in ("numbers", "words")
            )
            bits = zip(words.tolist(), numbers.tolist(), strict=True)
            values = [word for word, bit in bits if word and int(value) & bit]
        attributes[name] = Attribute(values, {key: None})
    return ModelElement("option", 0, "option", attributes)


def edits_of(one: Compiled, other: Compiled, pair: Sequence[Attribute]) -> Iterator[Edit]:
    """Yield what gives A's element the values of B's; references to elements are left alone."""
    for name, rows in pair[0].rows.items():
        if name.startswith("opt."):
            yield name, None, np.asarray(other.answer[name]).tolist()
            continue
        theirs = pair[1].rows.get(name, ())
        if name in RETARGETED and len(theirs):
            numbers = [number_of(one, label) for label in pair[1].values]
            width = np.size(one.field(name)[rows])
            numbers += [-1] * (width - len(numbers))
            shape = np.shape(one.field(name)[rows])
            yield f"model.{name}", rows.tolist(), np.reshape(numbers, shape).tolist()
            continue
        fixed = name in (*ENUMERATIONS, *REFERENCES) or name.startswith("sensor_")
        if fixed or len(theirs) != len(rows):
            continue
        for own in (name, WITH.get(name), SWITCHES.get(name)):
            if own and f"model.{own}" in one.answer:
                yield f"model.{own}", rows.tolist(), other.field(own)[theirs].tolist()


def number_of(model: Compiled, label: str) -> int:
    """Return the number of an element, -1 if there is none of this label."""
    listed = next((one for one in model.labels.values() if label in one), [])
    return listed.index(label) if listed else -1


def neutral(model: Compiled, element: ModelElement) -> Iterator[Edit]:
    """Yield what leaves an element without effect."""
    for name, value in NEUTRAL.get(element.kind, {}).items():
        shape = model.field(name)[[element.number]].shape
        yield f"model.{name}", [element.number], np.full(shape, value).tolist()


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


def cells_of(before: Sequence[Any], after: Sequence[Any]) -> tuple[str, str]:
    """Return two lists of values in words, in so many digits that they differ."""
    for digits in (6, 12, 17):
        cells = tuple(
            " ".join(number(float(v), digits) if isinstance(v, int | float) else str(v) for v in vs)
            or "none"
            for vs in shortened(before, after)
        )
        if cells[0] != cells[1]:
            break
    return cells[0], cells[1]


def shortened(before: Sequence[Any], after: Sequence[Any]) -> tuple[Sequence[Any], Sequence[Any]]:
    """Return the values that differ where there are many, else all up to the last that differs."""
    if len(before) != len(after):
        return before[:MAX_VALUES], after[:MAX_VALUES]
    apart = [i for i, (x, y) in enumerate(zip(before, after, strict=True)) if x != y]
    last = apart[-1] + 1 if apart else 1
    if last > MAX_VALUES:
        return [before[i] for i in apart[:MAX_VALUES]], [after[i] for i in apart[:MAX_VALUES]]
    return before[:last], after[:last]


def is_saved_by_mujoco(reading: Reading) -> bool:
    """Return True if a file is written as MuJoCo writes it: radians, numbers of six digits."""
    with open(reading.operand.file, encoding="utf-8", errors="replace") as file:
        text = re.sub(r"<!--.*?-->", "", file.read(), flags=re.DOTALL)
    if not re.search(r'angle\s*=\s*"radian"', text) or NEVER_SAVED.search(text):
        return False
    numbers = re.findall(r"(?<![\w.+-])[-+]?\d*\.?\d+(?:[eE][-+]?\d+)?(?![\w.])", text)
    return all(one in (f"{float(one):.6g}", f"{float(one):.0f}") for one in numbers)


# What they do --------------------------------------------------------------------------------


class EditTrial:
    """States at which A, with edits, is compared with B.

    Parameters
    ----------
    first, second : Reading
    match : Match
    rows : StateRows
    always : sequence of Edit
        Edits of A that are always made: attributes that differ by the digits of a text.
    """

    def __init__(
        self, first: Reading, second: Reading, match: Match, rows: StateRows, always: Sequence[Edit]
    ) -> None:
        self.first, self.second, self.rows, self.always = first, second, rows, always
        self.states = states_of(first)
        if isinstance(second, EngineReading):  # which has no activations
            rest = [0.0] * int(first.model.field("na"))
            self.states = {name: {**one, "act": rest} for name, one in self.states.items()}
        self.elements = [pair[0] for pair in match.pairs]
        self.sides = [side_of(first.model, 0, match, rows), side_of(second.model, 1, match, rows)]
        theirs = [rows.translated(state, second.model) for state in self.states.values()]
        self.other = [self.sides[1].in_order(one) for one in second.at(theirs)]
        self.own = self.answers(())

    def answers(self, edits: Sequence[Edit], brief: bool = False) -> list[dict[str, Any]]:
        """Return the answers of A after edits; in brief its accelerations alone."""
        answers = self.first.at(list(self.states.values()), [*self.always, *edits], brief)
        if brief:
            return [{"qacc": one["qacc"][self.rows.rows["qvel"][0]]} for one in answers]
        return [self.sides[0].in_order(one) for one in answers]

    def gaps(self, edits: Sequence[Edit]) -> list[Gap]:
        """Return in what A, with edits, and B differ beyond rounding."""
        own = self.answers(edits) if edits else self.own
        labels = {kind: list(one.values()) for kind, one in self.sides[0].labels.items()}
        labels["joint"] = self.rows.labels
        eps = max(self.first.eps, self.second.eps)
        return gaps_between(own, self.other, list(self.states), labels, eps)

    @cached_property
    def force_scale(self) -> Any:
        """Largest force of each joint (n,) at the states, and no less than a share of all."""
        forces = np.array([one["mass"] @ one["qacc"] for one in self.own])
        size = abs(forces).max(axis=0)
        return np.maximum(size, MIN_FORCE * size.max(initial=0.0) or 1.0)

    def force_gap(self, edits: Sequence[Edit]) -> Any:
        """Return the differences of accelerations as forces, relative to each joint's largest."""
        apart = [
            mine["mass"] @ (theirs["qacc"] - edited["qacc"])
            for mine, theirs, edited in zip(
                self.own, self.other, self.answers(edits, brief=True), strict=True
            )
        ]
        return np.ravel(np.array(apart) / self.force_scale)

    def read_differently(self, before: Sequence[Edit]) -> list[Difference]:
        """Return the attributes that an engine lost or scaled, after edits that are known."""
        elements = [option_element(self.first.model), *self.elements]
        picks = find_edits(
            lambda edits: self.force_gap([*before, *edits]),
            lambda edits: not self.gaps([*before, *edits]),
            list(guesses(self.first.model, elements)),
        )
        differences = []
        for one, factor in picks:
            values = one.cells(factor)
            before_cell, after_cell = cells_of(*values) if values[0] else ("", values[1][0])
            edits = [one.edit(factor)]
            differences.append(
                Difference(one.element, one.attribute, before_cell, after_cell, edits=edits)
            )
        return differences

    def left(self, edits: Sequence[Edit], gaps: list[Gap]) -> list[Gap]:
        """Return the gaps that edits leave; all of them if the edits cannot be made."""
        try:
            return self.gaps(edits)
        except MbcheckError:
            return gaps

    def measured(self, difference: Difference) -> Difference:
        """Return a difference with its effect on accelerations."""
        if not difference.edits:
            return difference
        try:
            changed = self.answers(difference.edits, brief=True)
        except MbcheckError:
            return difference
        size = max((abs(one["qacc"]).max(initial=0.0) for one in self.own), default=0.0)
        apart = [
            abs(b["qacc"] - a["qacc"]).max(initial=0.0)
            for a, b in zip(self.own, changed, strict=True)
        ]
        effect = float(np.max(apart, initial=0.0)) / size if size else math.nan
        return replace(difference, effect=effect if math.isfinite(effect) else None)


def side_of(model: Compiled, side: int, match: Match, rows: StateRows) -> Side:
    """Return the rows of a model; ``side`` is 0 for A and 1 for B."""
    labels: dict[str, dict[int, str]] = {kind: {} for kind in model.labels}
    for pair in match.pairs:
        labels[pair[0].kind][pair[side].number] = pair[0].label
    return Side(model, labels, {name: both[side] for name, both in rows.rows.items()})

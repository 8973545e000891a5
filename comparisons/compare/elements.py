"""The elements of a compiled model, their physical attributes in MJCF's words, and who is who.

All arrays of ``MjModel`` count but those that are drawn, that index others, or that follow from
the rest. What two files write differently and MuJoCo simulates alike has one form here: tensors in
the place of principal axes, rotations in that of quaternions, names in that of numbers.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial.transform import Rotation

Values = Sequence[Any]
"""Numbers or words of an attribute."""

KINDS: Mapping[str, str] = {
    "mesh": "",
    "hfield": "",
    "body": "body_parentid",
    "joint": "jnt_bodyid",
    "geom": "geom_bodyid",
    "site": "site_bodyid",
    "flex": "",
    "tendon": "",
    "equality": "eq_type",
    "actuator": "actuator_trnid",
    "sensor": "sensor_objid",
    "key": "",
    "pair": "pair_geom2",
    "exclude": "exclude_signature",
}
"""Kind of element -> the field that distinguishes elements without a name.

Kinds that others refer to come first."""

ROWS: Mapping[str, tuple[str, str]] = {
    **{{"joint": "jnt", "equality": "eq"}.get(kind, kind): (kind, "") for kind in KINDS},
    "dof": ("joint", "jnt_dofadr"),
    "qpos0": ("joint", "jnt_qposadr"),
    "qpos_spring": ("joint", "jnt_qposadr"),
    "wrap": ("tendon", "tendon_adr"),
    "mesh_vert": ("mesh", "mesh_vertadr"),
    "hfield_data": ("hfield", "hfield_adr"),
    "actuator_ctrlrange": ("actuator", "actuator_ctrladr"),
    "actuator_gear": ("actuator", "actuator_outadr"),
    "actuator_lengthrange": ("actuator", "actuator_outadr"),
}
"""Field, or its first word -> the kind of element of its rows, and the field of their addresses."""

COLUMNS: Mapping[str, tuple[str, str, int]] = {
    "key_qpos": ("joint", "jnt_qposadr", 1),
    "key_qvel": ("joint", "jnt_dofadr", 1),
    "key_act": ("actuator", "actuator_actadr", 1),
    "key_ctrl": ("actuator", "actuator_ctrladr", 1),
    "key_mpos": ("body", "body_mocapid", 3),
    "key_mquat": ("body", "body_mocapid", 4),
}
"""Field of keyframes -> the kind of the elements of its columns, the field of their addresses, and
the columns of each address."""

REFERENCES = {
    "body_parentid": "body",
    "jnt_bodyid": "body",
    "geom_bodyid": "body",
    "site_bodyid": "body",
    "pair_geom1": "geom",
    "pair_geom2": "geom",
    "geom_dataid": "geom_type",
    "eq_obj1id": "eq_objtype",
    "eq_obj2id": "eq_objtype",
    "actuator_trnid": "actuator_trntype",
    "sensor_objid": "sensor_objtype",
    "sensor_refid": "sensor_reftype",
    "wrap_objid": "wrap_type",
}
"""Field of numbers of elements -> their kind, or the field of their kinds."""

REFERRED = {
    "jointinparent": "joint",
    "so3": "joint",
    "slidercrank": "site",
    "sphere": "geom",
    "cylinder": "geom",
    "xbody": "body",
    "sdf": "mesh",
}
"""Kind of a reference -> the kind of its element, where MuJoCo has two words."""

SIZES = {"plane": 0, "sphere": 1, "capsule": 2, "cylinder": 2}
"""Type of a geom or site -> how many of its three sizes count, where not all do."""

ANALYTIC = ("plane", "sphere", "capsule", "box")
"""Types of geoms of which any two collide by a formula, in place of the convex routine."""

WORDS = {
    "jnt_solref": "solreflimit",
    "jnt_solimp": "solimplimit",
    "jnt_actfrcrange": "actuatorfrcrange",
    "jnt_actgravcomp": "actuatorgravcomp",
    "dof_solref": "solreffriction",
    "dof_solimp": "solimpfriction",
    "qpos0": "ref",
    "qpos_spring": "springref",
    "body_parentid": "parent",
    "body_ipos": "inertial pos",
    "jnt_bodyid": "body",
    "geom_bodyid": "body",
    "site_bodyid": "body",
    "geom_dataid": "mesh",
    "geom_fluid": "fluidcoef",
    "eq_active0": "active",
    "eq_obj1id": "first element",
    "eq_obj2id": "second element",
    "actuator_trnid": "target",
    "actuator_trntype": "transmission",
    "tendon_lengthspring": "springlength",
    "tendon_solref_lim": "solreflimit",
    "tendon_solimp_lim": "solimplimit",
    "tendon_solref_fri": "solreffriction",
    "tendon_solimp_fri": "solimpfriction",
    "tendon_actfrcrange": "actuatorfrcrange",
    "wrap_objid": "path",
    "wrap_prm": "coef",
    "wrap_type": "path types",
    "pair_dim": "condim",
    "exclude_signature": "bodies",
    "key_mpos": "mocap pos",
    "key_mquat": "mocap quat",
}
"""Field -> the attribute of MJCF, if it has another name."""

EQUALITY_DATA = {"connect": "anchor", "weld": "relpose", "joint": "polycoef", "tendon": "polycoef"}
"""Type of an equality -> what its numbers are."""

SWITCHES = {
    "jnt_range": "jnt_limited",
    "jnt_actfrcrange": "jnt_actfrclimited",
    "tendon_range": "tendon_limited",
    "tendon_actfrcrange": "tendon_actfrclimited",
    "actuator_ctrlrange": "actuator_ctrllimited",
    "actuator_forcerange": "actuator_forcelimited",
    "actuator_actrange": "actuator_actlimited",
    "eq_type": "eq_active0",
}
"""Field -> the field that switches it on."""

DATA_WIDTHS = {"anchor": 6, "relpose": 11, "polycoef": 5}
"""Attribute of an equality -> the count of its numbers; releases reserve more."""

CONTACT = (
    "condim", "friction", "solref", "solimp", "solmix", "margin", "gap", "priority", "adhesion",
    "surfacevel",
)  # fmt: skip
"""Attributes that do nothing on a geom that touches nothing."""

NOT_PHYSICAL = re.compile(
    r"^_|^(cam|light|mat|tex|text|tuple|numeric|skin|bvh|oct|name|tree|ten|flexedge|efm0|efmC|[BDM])_"
    r"|^map|^names|^paths|^dof_(bodyid|jntid|parentid|length)$|^body_(contype|conaffinity|margin)$"
    r"|^(mesh|hfield)_(?!vert$|data$|size$)|_(iquat|group|rgba|matid|castshadow|user|width|flatskin"
    r"|texcoord|objtype|reftype|rootid|weldid|treeid|treenum|actuatorid|sameframe|simple|simplenum"
    r"|subtreemass|invweight0|M0|Madr|acc0|length0|aabb|rbound|needstage|datatype|ctrlspec|plugin)$"
    r"|limited$|^pair_signature$|(adr|num)$"
)
"""Fields that are drawn, that index others, or that follow from the rest."""


@dataclass(frozen=True)
class Attribute:
    """A physical attribute of an element.

    Attributes
    ----------
    values : sequence of float or str
        Values in a form in which equal physics is equal.
    rows : mapping of str to array or None
        Fields of the compiled model that hold it, and their rows; None for all of an option.
    """

    values: Values
    rows: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class ModelElement:
    """An element of a compiled model; ``label`` names it in reports: ``joint elbow``."""

    kind: str
    number: int
    label: str
    attributes: Mapping[str, Attribute]

    def attribute(self, name: str) -> Attribute:
        """Return an attribute, one of no numbers and no field where it has none."""
        return self.attributes.get(name, Attribute(["none"]))


class Compiled:
    """A compiled model as `probe` tells it.

    Parameters
    ----------
    answer : mapping of str to array
    """

    def __init__(self, answer: Mapping[str, Any]) -> None:
        self.answer = answer
        self.version = str(answer["version"])
        self.names: dict[str, list[str]] = {
            kind: answer[f"names.{kind}"].tolist() for kind in KINDS
        }
        self.names["option"] = [""]

    def field(self, name: str) -> Any:
        """Return a field of ``MjModel``, or a number of its elements."""
        return self.answer[name]

    @cached_property
    def fields(self) -> list[str]:
        """Physical fields, those of joints before those of their degrees of freedom."""
        physical = [
            name
            for name in self.answer
            if "." not in name and np.ndim(self.field(name)) and not NOT_PHYSICAL.search(name)
        ]
        return sorted(physical, key=lambda name: (name.startswith("dof_"), name))

    def spans(self, kind: str, address: str, size: int) -> list[range]:
        """Return the rows of each element in an array, by the field of their addresses."""
        starts = self.answer.get(address, np.arange(len(self.names[kind]))).tolist()
        ends = iter([*[one for one in starts if one >= 0][1:], size])
        return [range(one, next(ends)) if one >= 0 else range(0) for one in starts]

    def columns(self, name: str) -> list[range]:
        """Return the columns of each element in a field of keyframes, as in a state."""
        kind, address, width = COLUMNS[name]
        spans = self.spans(kind, address, self.field(name).shape[1] // width)
        return [range(one.start * width, one.stop * width) for one in spans]

    @property
    def outputs(self) -> list[range]:
        """The forces of each actuator: several since MuJoCo 4.0."""
        return self.spans("actuator", "actuator_outadr", len(self.field("actuator_gear")))

    @cached_property
    def labels(self) -> dict[str, list[str]]:
        """Names of all elements by their kinds, with words for those that have none."""
        labels: dict[str, list[str]] = {}
        for kind, owner in KINDS.items():
            labels[kind], seen = [], dict[str, int]()
            for i, name in enumerate(self.names[kind]):
                if not name:
                    of = " and ".join(self.described(labels, owner, i)) if owner else "the model"
                    seen[of] = seen.get(of, 0) + 1
                    name = f"{seen[of]} of {of}"
                labels[kind].append(f"{kind} {name}")
        return labels

    def described(self, labels: Mapping[str, Sequence[str]], name: str, row: int) -> list[str]:
        """Return a type, or the elements that a field refers to, in words."""
        values = np.ravel(self.field(name)[row])
        if values.dtype.kind == "U":
            return [str(values[0])]
        if name == "exclude_signature":
            values = np.array(divmod(values[0], 1 << 16))
        kind = REFERENCES.get(name, "body")
        if kind in self.answer:
            kind = str(self.field(kind)[row])
        if name.startswith("eq_obj") and self.field("eq_type")[row] in ("joint", "tendon"):
            kind = str(self.field("eq_type")[row])
        listed = labels.get(REFERRED.get(kind, kind), [])
        words = [listed[i] if 0 <= i < len(listed) else f"number {i}" for i in values.tolist()]
        words = [word for word in words if word != "number -1"]
        return sorted(words) if name == "exclude_signature" else words

    def elements(self, kind: str, labels: Mapping[str, Sequence[str]]) -> list[ModelElement]:
        """Return the elements of a kind; references name others by ``labels``."""
        tables: list[dict[str, Attribute]] = [{} for _ in self.labels[kind]]
        for name in self.fields if tables else ():
            own, address = ROWS.get(name) or ROWS.get(name.partition("_")[0]) or ("", "")
            if own == kind:
                values = self.comparable(name, labels)
                spans = self.spans(kind, address, len(values))
                for table, rows in zip(tables, map(list, spans), strict=True):
                    self.add(table, name, rows, values, labels)
        named = zip(self.labels[kind], tables, strict=True)
        return [ModelElement(kind, i, label, folded(t, kind)) for i, (label, t) in enumerate(named)]

    def add(
        self,
        table: dict[str, Attribute],
        name: str,
        rows: list[int],
        values: Any,
        labels: Mapping[str, Sequence[str]],
    ) -> None:
        """Add the rows of a field to the attributes of an element."""
        attribute = WORDS.get(name) or name.partition("_")[2]
        if name in COLUMNS:
            for label, columns in zip(labels[COLUMNS[name][0]], self.columns(name), strict=True):
                if columns:
                    table[f"{attribute} of {label}"] = Attribute(values[rows[0]][columns].tolist())
            return
        if name == "eq_data":
            attribute = EQUALITY_DATA.get(self.field("eq_type")[rows[0]], "data")
        attribute = name if attribute in table else attribute
        width = DATA_WIDTHS.get(attribute)
        flat = [one for row in rows for one in np.ravel(values[row]).tolist()[:width]]
        table[attribute] = Attribute(flat, {name: rows})

    def comparable(self, name: str, labels: Mapping[str, Sequence[str]]) -> Any:
        """Return a field in a form in which equal physics is equal."""
        values = self.field(name)
        if values.dtype.kind == "U" or name in REFERENCES or name == "exclude_signature":
            return [self.described(labels, name, row) for row in range(len(values))]
        limited = self.answer.get(f"{name.removesuffix('range')}limited")
        if limited is not None and name.endswith("range"):
            return [list(v) if on else ["no limit"] for v, on in zip(values, limited, strict=True)]
        if name == "wrap_prm":  # of a geom the number of the site on whose side the tendon runs
            sides = np.isin(self.field("wrap_type"), ("sphere", "cylinder")) & (values >= 0)
            sites = labels["site"]
            return [sites[int(v)] if on else v for v, on in zip(values, sides, strict=True)]
        if name == "body_mocapid":
            return values >= 0
        if name == "body_inertia":
            axes = rotations(self.field("body_iquat"))
            tensors = axes * values[:, None] @ axes.transpose(0, 2, 1)
            return tensors[:, [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        if name in ("geom_size", "site_size"):
            kinds = self.field(name.replace("size", "type")).tolist()
            return values * np.less.outer(np.arange(3), [SIZES.get(kind, 3) for kind in kinds]).T
        if name == "geom_quat":
            return self.axes()
        return rotations(values) if name.endswith("_quat") else values

    @cached_property
    def options(self) -> ModelElement:
        """The options as one element."""
        attributes = {
            key.removeprefix("opt."): Attribute(np.ravel(value).tolist(), {key: None})
            for key, value in self.answer.items()
            if key.startswith("opt.") and not key.startswith("opt.o_")
        }
        return ModelElement("option", 0, "option", attributes)

    @cached_property
    def collides_convexly(self) -> bool:
        """True if contacts or distances of geoms may be computed by the convex routine."""
        touch = self.field("geom_contype") | self.field("geom_conaffinity")
        shapes = self.field("geom_type")[(touch != 0) | bool(self.names["pair"])]
        distances = np.char.startswith(self.field("sensor_type"), "geom")
        return bool(self.names["flex"] or distances.any() or set(shapes) - set(ANALYTIC))

    def axes(self) -> Any:
        """Return the orientation of geoms: the axis of round ones, nothing of a sphere."""
        axes, kinds = rotations(self.field("geom_quat")), self.field("geom_type")
        lines = np.where(kinds == "sphere", 0.0, 1.0)[:, None] * axes[:, :, 2]
        round_ = np.isin(kinds, ("sphere", "capsule", "cylinder"))
        both = lines[:, :, None] * lines[:, None]
        return np.where(round_[:, None, None], both, axes)


def rotations(quaternions: Any) -> Any:
    """Return rotation matrices (n, 3, 3) of MuJoCo's quaternions (n, 4), which have two signs."""
    quaternions = np.asarray(quaternions, dtype=float).reshape(-1, 4)
    if not len(quaternions):
        return np.zeros((0, 3, 3))
    return Rotation.from_quat(quaternions[:, [1, 2, 3, 0]]).as_matrix()


def folded(table: dict[str, Attribute], kind: str) -> dict[str, Attribute]:
    """Return the attributes of an element, without those that do nothing on it."""
    if kind == "geom" and touches_nothing(table):
        return {name: one for name, one in table.items() if name not in CONTACT}
    if kind == "joint" and table["type"].values[0] in ("free", "ball"):
        idle = ["ref"] * (table["type"].values == ["free"])  # which its body has
        idle += ["springref"] * (table["stiffness"].values == [0.0])
        return {name: one for name, one in table.items() if name not in idle}
    if kind == "tendon" and set(table["path types"].values) == {"joint"}:
        path, coefficients = table["path"], table["coef"]
        order = np.argsort(path.values, kind="stable")
        for name, one in (("path", path), ("coef", coefficients)):
            rows = {field: [numbers[i] for i in order] for field, numbers in one.rows.items()}
            table[name] = Attribute([one.values[i] for i in order], rows)
    if kind == "pair":
        both = [value for name in ("geom1", "geom2") for value in table.pop(name).values]
        table["geoms"] = Attribute(sorted(both))
    if kind == "actuator":
        gain, bias = table["gainprm"].values, table["biasprm"].values
        rows = {**table["gainprm"].rows, **table["biasprm"].rows}
        servo, speed = bias[1] == -gain[0], bias[1] == 0 and bias[2] == -gain[0]
        if table["gaintype"].values == ["fixed"] and gain[0] and (servo or speed):
            table["kv"] = Attribute([-bias[2]], rows)
            if servo:
                table["kp"] = Attribute([gain[0]], rows)
    return table


def touches_nothing(table: Mapping[str, Attribute]) -> bool:
    """Return True if a geom takes part in no contact but those of pairs."""
    return not any(any(table[name].values) for name in ("contype", "conaffinity"))


GAINS = ("gainprm", "biasprm"), ("kp", "kv")
"""Attributes of an actuator, and those of a servo of position or speed, which say the same."""


def names_of_both(one: ModelElement, other: ModelElement) -> list[str]:
    """Return the attributes in which two elements are compared."""
    mine, theirs = ({*GAINS[1]} & side.attributes.keys() for side in (one, other))
    left_out = GAINS[0] if mine and mine == theirs else GAINS[1]
    names = dict.fromkeys((*one.attributes, *other.attributes))
    return [name for name in names if name not in left_out]


# Which element of one model is which of the other --------------------------------------------


@dataclass(frozen=True)
class Match:
    """Pairs of elements of two models, and those that have no partner."""

    pairs: Sequence[tuple[ModelElement, ModelElement]]
    gone: Sequence[ModelElement]
    new: Sequence[ModelElement]


def match_elements(one: Compiled, other: Compiled) -> Match:
    """Return the pairs of corresponding elements of two models.

    They are matched by name; those without a partner of their name so that as many as possible are
    at the same place (their parent, or the elements to which they refer), and that as few
    attributes as possible differ.
    """
    labels = {kind: list(listed) for kind, listed in other.labels.items()}
    contents = contents_of(one), contents_of(other)
    pairs = [(one.options, other.options)]
    gone: list[ModelElement] = []
    new: list[ModelElement] = []
    for kind in KINDS:
        names, others = one.names[kind], other.names[kind]
        partners = {
            i: others.index(name)
            for i, name in enumerate(names)
            if name and others.count(name) == names.count(name) == 1
        }
        mine = one.elements(kind, one.labels)
        for numbers in levels(one) if kind == "body" else [range(len(mine))]:
            rename(labels, one, kind, partners)
            theirs = other.elements(kind, labels)
            left = [mine[i] for i in numbers if i not in partners]
            right = [each for each in theirs if each.number not in partners.values()]
            partners |= dict(assigned(left, right, contents))
        rename(labels, one, kind, partners)
        theirs = other.elements(kind, labels)
        pairs += [(mine[i], theirs[j]) for i, j in sorted(partners.items())]
        gone += [element for element in mine if element.number not in partners]
        new += [element for element in theirs if element.number not in partners.values()]
    return Match(pairs, gone, new)


def rename(
    labels: Mapping[str, list[str]], one: Compiled, kind: str, partners: Mapping[int, int]
) -> None:
    """Give elements the labels of their partners."""
    for i, j in partners.items():
        labels[kind][j] = one.labels[kind][i]


def levels(model: Compiled) -> list[list[int]]:
    """Return the numbers of bodies, those at each depth of the tree in turn."""
    depth = [0]
    for parent in model.field("body_parentid")[1:].tolist():
        depth.append(depth[parent] + 1)
    return [[i for i, own in enumerate(depth) if own == d] for d in range(max(depth) + 1)]


PLACE = ("parent", "body", "type", "transmission", "target", "first element", "geoms", "objid")
"""Attributes that say where an element is."""

ELSEWHERE = 1e3
"""Number of differing attributes for which another place counts."""


def spelled(element: ModelElement) -> set[str]:
    """Return the attributes of an element as words, numbers in five digits of the largest."""
    words = set()
    for name, one in element.attributes.items():
        values = list(one.values)
        if not any(isinstance(value, str) for value in values):
            numbers = np.array(values, dtype=float)
            size = abs(numbers[np.isfinite(numbers)]).max(initial=0.0)
            values = [f"{size:.4e}", *(np.round(numbers / (size or 1.0), 5) + 0.0).tolist()]
        words.add(f"{element.kind} {name} {values}")
    return words


def contents_of(model: Compiled) -> list[Counter[str]]:
    """Return the attributes, as words, of all joints and geoms on each body and below it."""
    contents = [Counter[str]() for _ in model.labels["body"]]
    for kind in ("joint", "geom"):
        owners = model.field(KINDS[kind]).tolist()
        for element in model.elements(kind, model.labels):
            own = {n: a for n, a in element.attributes.items() if not {*a.rows} & {*REFERENCES}}
            contents[owners[element.number]].update(spelled(replace(element, attributes=own)))
    for i, parent in reversed(list(enumerate(model.field("body_parentid").tolist()))):
        if i:
            contents[parent] += contents[i]
    return contents


def assigned(
    left: Sequence[ModelElement],
    right: Sequence[ModelElement],
    contents: tuple[Sequence[Counter[str]], Sequence[Counter[str]]],
) -> Iterator[tuple[int, int]]:
    """Yield pairs of numbers so that as few attributes as possible differ, in order if equal.

    The share of differing ``contents`` counts as one attribute of bodies.
    """
    words, others = ([spelled(element) for element in side] for side in (left, right))
    costs = np.zeros((len(left), len(right)))
    for (a, one), (b, other) in product(enumerate(left), enumerate(right)):
        apart = any(one.attribute(name).values != other.attribute(name).values for name in PLACE)
        costs[a, b] = len(words[a] ^ others[b]) / 2 + ELSEWHERE * apart + 1e-6 * abs(a - b)
        if one.kind == "body":
            mine, theirs = contents[0][one.number], contents[1][other.number]
            every = (mine | theirs).total()
            costs[a, b] += 1 - (mine & theirs).total() / every if every else 0.0
    for a, b in zip(*linear_sum_assignment(costs), strict=True):
        yield left[a].number, right[b].number


def difference_share(one: Values, other: Values, least: float = 0.0) -> float:
    """Return the largest difference of numbers in the largest of them, infinite of other words.

    Numbers below ``least`` count as that large.
    """
    if len(one) != len(other):
        return np.inf
    if any(isinstance(value, str) for value in (*one, *other)):
        return 0.0 if list(one) == list(other) else np.inf
    first, second = np.array(one, dtype=float), np.array(other, dtype=float)
    same = (first == second) | (np.isnan(first) & np.isnan(second))
    finite = np.isfinite(first) & np.isfinite(second)
    if not np.all(same | finite):
        return np.inf
    size = max(np.abs(side[finite]).max(initial=least) for side in (first, second))
    return float(np.abs(first[~same] - second[~same]).max(initial=0.0)) / (size or 1.0)

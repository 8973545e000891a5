"""What differs between two inspections: physical fields, frequencies, stable steps, findings.

All arrays of ``MjModel`` count, but those that are drawn, that index others, or that follow from
the rest. What two files write differently and MuJoCo simulates alike has one form here: tensors in
the place of principal axes, rotations in that of quaternions, names in that of numbers.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ..reports.words import number
from .inspection import Inspection, ModelFinding
from .mujoco.facts import options, word
from .mujoco.model import KINDS, Loaded

EQUAL = 1e-9
"""Share by which numbers of the file may differ in rounding."""

ALIKE = 1e-6
"""The same for what is computed of differences of forces."""

LONG, FEW = 9, 6
"""Numbers of a field from which on only those are shown that differ, and so many of them."""

Value = object
Row = tuple[str, Value, Value]


@dataclass(frozen=True)
class ModelDifference:
    """What differs: ``rows`` of (what, before, now), and findings that are new or gone."""

    rows: tuple[Row, ...]
    new: tuple[ModelFinding, ...]
    gone: tuple[ModelFinding, ...]

    def __bool__(self) -> bool:
        """Return whether anything differs."""
        return bool(self.rows or self.new or self.gone)


def model_difference(old: Inspection, new: Inspection) -> ModelDifference:
    """Return what differs between two inspections of what is meant to be one model."""
    before, now = ({(f.rule, f.element) for f in one.unwaived} for one in (old, new))
    return ModelDifference(
        rows=tuple(rows_of(old, new)),
        new=tuple(f for f in new.unwaived if (f.rule, f.element) not in before),
        gone=tuple(f for f in old.unwaived if (f.rule, f.element) not in now),
    )


def rows_of(old: Inspection, new: Inspection) -> Iterator[Row]:
    """Yield what differs in numbers: (what, before, now)."""
    before, now = (physical_fields(one.loaded) for one in (old, new))
    for label in dict.fromkeys((*before, *now)):
        if label in before and label in now:
            yield from changes(label, before[label], now[label])
        else:
            yield (label, "there", "gone") if label in before else (label, "not there", "new")
    for what, table in (("largest stable step,", limits_of), ("state", frequencies_of)):
        yield from changes(what, table(old), table(new), ALIKE)


def limits_of(one: Inspection) -> dict[str, Value]:
    """Return the largest stable step of each integrator [s]."""
    return {f"{limit.integrator} [s]": limit.limit for limit in one.steps}


def frequencies_of(one: Inspection) -> dict[str, Value]:
    """Return the circular frequencies of the modes in each state, ascending [rad/s]."""
    return {
        f"{view.state.name}, mode {i} [rad/s]": mode.omega
        for view in one.views
        for i, mode in enumerate((m for m in view.modes if m.kind != "rigid"), 1)
    }


def changes(
    what: str, old: Mapping[str, Value], new: Mapping[str, Value], rel: float = EQUAL
) -> Iterator[Row]:
    """Yield the values that differ, of keys that both have, and keys that one has."""
    for key in dict.fromkeys((*old, *new)):
        before, now = old.get(key), new.get(key)
        if not same(before, now, rel):
            if isinstance(before, list) and isinstance(now, list) and len(now) > LONG:
                pairs = [p for p in zip(before, now, strict=False) if not same(*p, rel)][:FEW]
                before, now = zip(*pairs, strict=True) if pairs else (len(before), len(now))
            cells = shown_as(before), shown_as(now)
            if cells[0] == cells[1]:
                cells = shown_as(before, 12), shown_as(now, 12)
            yield (f"{what} {key}".strip(), *cells)


def same(one: Value, other: Value, rel: float) -> bool:
    """Return whether two values are equal, numbers to rounding."""
    if isinstance(one, tuple | list) and isinstance(other, tuple | list):
        size = max((abs(x) for x in (*one, *other) if isinstance(x, float)), default=0.0)
        return len(one) == len(other) and all(
            same(a, b, rel) or (isinstance(a, float) and abs(a - b) <= rel * size)
            for a, b in zip(one, other, strict=True)
        )
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=rel)
    return one == other


def shown_as(value: Value, digits: int = 6) -> str:
    """Return a value in a cell."""
    if isinstance(value, tuple | list):
        return " ".join(shown_as(one, digits) for one in value)
    if value is None:
        return "-"
    if isinstance(value, float) and math.isinf(value):
        return "no limit"
    return number(value, digits) if isinstance(value, float) else str(value)


# Physical fields of a compiled model ----------------------------------------------------------

Labels = dict[str, list[str]]

ELEMENTS = {
    "body": "body_parentid",
    "joint": "jnt_bodyid",
    "geom": "geom_bodyid",
    "site": "site_bodyid",
    "mesh": "",
    "hfield": "",
    "flex": "",
    "tendon": "",
    "equality": "eq_type",
    "actuator": "actuator_trnid",
    "sensor": "sensor_objid",
    "key": "",
    "pair": "pair_geom2",
    "exclude": "exclude_signature",
}
"""Kind of element -> the field by which those without a name are told apart."""

SHORT = {"joint": "jnt", "equality": "eq"}
"""Kind of element -> how its fields begin, where that is another word."""

ROWS = {SHORT.get(kind, kind): (kind, "") for kind in ELEMENTS} | {
    "dof": ("joint", "jnt_dofadr"),
    "qpos0": ("joint", "jnt_qposadr"),
    "qpos_spring": ("joint", "jnt_qposadr"),
    "wrap": ("tendon", "tendon_adr"),
    "mesh_vert": ("mesh", "mesh_vertadr"),
}
"""Field, or its first word -> the kind of element of its rows, and the field of their addresses."""

COLUMNS = {"key_qpos": "qpos0", "key_qvel": "dof", "key_ctrl": "actuator"}
"""Field of keyframes -> one of `ROWS` that tells whose its columns are."""

REFERENCES = {
    "body_parentid": "body",
    "jnt_bodyid": "body",
    "geom_bodyid": "body",
    "site_bodyid": "body",
    "pair_geom1": "geom",
    "pair_geom2": "geom",
    "geom_dataid": "geom_type",
    "eq_obj1id": "eq_type",
    "eq_obj2id": "eq_type",
    "actuator_trnid": "actuator_trntype",
    "sensor_objid": "sensor_objtype",
    "sensor_refid": "sensor_reftype",
    "wrap_objid": "wrap_type",
}
"""Field of numbers of elements -> their kind, or the field of their kinds."""

REFERRED = {
    "jointinparent": "joint",
    "slidercrank": "site",
    "sphere": "geom",
    "cylinder": "geom",
    "xbody": "body",
    "sdf": "mesh",
}
"""Kind of a reference -> that of the element that it is to, where that is another word."""

SIZES = {"plane": 0, "sphere": 1, "capsule": 2, "cylinder": 2}
"""Type of a geom or site -> how many of its three sizes count, where not all do."""

NOT_PHYSICAL = re.compile(
    r"^_|^(cam|light|mat|tex|text|tuple|numeric|skin|bvh|oct|name|tree|ten|flexedge|efm0|efmC|[BDM])_"
    r"|^map|^names|^paths|^dof_(bodyid|jntid|parentid|length)$|^body_(contype|conaffinity|margin)$"
    r"|^mesh_(?!vert$)|_(iquat|group|rgba|matid|castshadow|user|width|flatskin|texcoord|objtype"
    r"|reftype|rootid|weldid|treeid|treenum|actuatorid|sameframe|simple|simplenum|subtreemass"
    r"|invweight0|M0|Madr|acc0|length0|aabb|rbound|needstage|datatype|ctrlspec|plugin)$|(adr|num)$"
)
"""Fields that are drawn, that index others, or that follow from the rest."""


def physical_fields(loaded: Loaded) -> dict[str, dict[str, Any]]:
    """Return the physical fields of a model: element -> name of a field -> list of values."""
    m, labels = loaded.model, labels_of(loaded)
    fields = {label: dict[str, Any]() for listed in labels.values() for label in listed}
    fields["option"] = option_fields(loaded)
    for name in sorted(dir(m), key=lambda one: one.startswith("dof_")):  # joints' own names first
        if NOT_PHYSICAL.search(name) or not isinstance(getattr(m, name), np.ndarray):
            continue
        values = comparable(loaded, labels, name)
        rest = name if name in ROWS else name.partition("_")[2]
        for label, piece in pieces(loaded, labels, name, values):
            own = fields[label]
            if name in COLUMNS:
                columns = pieces(loaded, labels, COLUMNS[name], piece.T)
                own |= {f"{rest} of {one}": part.ravel().tolist() for one, part in columns}
            else:
                own[name if rest in own else rest] = np.ravel(piece).tolist()
    return fields


def pieces(loaded: Loaded, labels: Labels, name: str, values: Any) -> list[tuple[str, Any]]:
    """Return the values of a field by element; a field of the whole model is one element."""
    kind, address = ROWS.get(name) or ROWS.get(name.partition("_")[0]) or ("model", "")
    starts = getattr(loaded.model, address) if address else np.arange(len(labels[kind]))
    return list(zip(labels[kind], np.split(values, starts[1:]), strict=False))


def labels_of(loaded: Loaded) -> Labels:
    """Return the names of all elements by their kinds, with words for those that have none."""
    labels: Labels = {"model": ["model"]}
    for kind, owner in ELEMENTS.items():
        labels[kind], seen = [], Counter[str]()
        for i in range(len(getattr(loaded.model, f"name_{SHORT.get(kind, kind)}adr"))):
            name = loaded.name(kind, i)
            if name == f"{kind} {i}":
                of = described(loaded, labels, owner, i) if owner else ["the model"]
                seen[" and ".join(of)] += 1
                name = f"{seen[' and '.join(of)]} of {' and '.join(of)}"
            labels[kind].append(f"{kind} {name}")
    return labels


def described(loaded: Loaded, labels: Labels, name: str, row: int) -> list[str]:
    """Return a kind, or the elements that a field refers to, in words."""
    m, values = loaded.model, np.ravel(getattr(loaded.model, name)[row]).astype(int)
    if name in KINDS:
        return [word(getattr(loaded.mujoco, KINDS[name][0]), values[0]).lower()]
    kind = REFERENCES.get(name, "body")
    if name == "exclude_signature":
        values = np.array(divmod(values[0], 1 << 16))
    if kind in KINDS:
        (kind,) = described(loaded, labels, kind, row)
    if kind in ("connect", "weld"):
        kind = word(loaded.mujoco.mjtObj, m.eq_objtype[row]).lower()
    listed = labels.get(REFERRED.get(kind, kind), [])
    words = [listed[i] if 0 <= i < len(listed) else f"number {i}" for i in values.tolist()]
    return sorted(words) if name == "exclude_signature" else words


def comparable(loaded: Loaded, labels: Labels, name: str) -> Any:
    """Return a field in a form in which equal physics is equal."""
    m, values = loaded.model, getattr(loaded.model, name)
    if name in KINDS or name in REFERENCES or name == "exclude_signature":
        return np.array([described(loaded, labels, name, row) for row in range(len(values))])
    limited = getattr(m, name.removesuffix("range") + "limited", None)
    if limited is not None and name.endswith("range"):
        return values * limited[:, None]
    if name == "body_mocapid":
        return values >= 0
    if name == "body_inertia":
        axes = rotations(m.body_iquat)
        return axes * values[:, None] @ axes.transpose(0, 2, 1)
    if name in ("geom_size", "site_size"):
        kinds = np.ravel(comparable(loaded, labels, name.replace("size", "type")))
        return values * np.less.outer(np.arange(3), [SIZES.get(kind, 3) for kind in kinds]).T
    if name == "geom_quat":  # what is round has an axis alone, and a sphere has none
        axes, ball = rotations(values), loaded.of_kind("geom_type", "sphere")
        round_ = loaded.of_kind("geom_type", "sphere", "capsule", "cylinder")[:, None, None]
        axis = np.multiply.outer(~ball, np.array([0, 0, 1]))
        ends = (axes * axis[:, None]) @ axes.transpose(0, 2, 1)
        return np.where(round_, ends, axes)
    return rotations(values) if name.endswith("_quat") else values


def rotations(quaternions: Any) -> Any:
    """Return rotation matrices (n, 3, 3) of MuJoCo's quaternions (n, 4), which have two signs."""
    return Rotation.from_quat(quaternions[:, [1, 2, 3, 0]]).as_matrix()


def option_fields(loaded: Loaded) -> dict[str, Any]:
    """Return the options of a model, its flags by their names."""
    opt, lib, own = loaded.model.opt, loaded.mujoco, vars(options(loaded))
    fields = {name: getattr(opt, name) for name in dir(opt) if not name.startswith(("_", "o_"))}
    fields |= {name: own[name] for name in ("integrator", "solver", "cone", "jacobian")}
    for name, bits in (("disableflags", lib.mjtDisableBit), ("enableflags", lib.mjtEnableBit)):
        flags = {key.partition("_")[2].lower(): int(bit) for key, bit in bits.__members__.items()}
        fields[name] = [flag for flag, bit in flags.items() if flag and fields[name] & bit]
    return {name: np.ravel(value).tolist() for name, value in fields.items()}

"""An MJCF model: its text, and the model that MuJoCo compiles from it."""

from __future__ import annotations

import copy
import os
import re
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple, SupportsInt

import numpy as np
from numpy.typing import NDArray

from ....reference.errors import MbcheckError, UsageError
from ....reference.scene import Array
from ...engines.mujoco.library import import_mujoco, quiet
from ...engines.run import contained
from ..tuning import NUMERICS
from .source import ROOT, Element, Source, read

Flags = NDArray[np.bool_]
Numbers = NDArray[np.integer[Any]]

ENGINE = "mujoco"
"""Name of MuJoCo among the versions of a document."""

LISTS: Mapping[str, str] = {
    "body": "bodies",
    "joint": "joints",
    "geom": "geoms",
    "site": "sites",
    "tendon": "tendons",
    "equality": "equalities",
    "actuator": "actuators",
    "sensor": "sensors",
    "mesh": "meshes",
    "hfield": "hfields",
    "texture": "textures",
    "material": "materials",
    "key": "keys",
    "pair": "pairs",
    "exclude": "excludes",
}
"""Kind of object -> attribute of ``MjSpec`` that lists it."""

SECTIONS = ("tendon", "equality", "actuator", "sensor")
"""Kinds whose elements are recognised by their section, which has this name, not by their tag."""

TAGS = {"joint": ("joint", "freejoint")}

KINDS = {
    "jnt_type": ("mjtJoint", "mjJNT"),
    "eq_type": ("mjtEq", "mjEQ"),
    "geom_type": ("mjtGeom", "mjGEOM"),
    "site_type": ("mjtGeom", "mjGEOM"),
    "tex_type": ("mjtTexture", "mjTEXTURE"),
    "sensor_type": ("mjtSensor", "mjSENS"),
    "sensor_objtype": ("mjtObj", "mjOBJ"),
    "sensor_reftype": ("mjtObj", "mjOBJ"),
    "actuator_trntype": ("mjtTrn", "mjTRN"),
    "actuator_dyntype": ("mjtDyn", "mjDYN"),
    "actuator_gaintype": ("mjtGain", "mjGAIN"),
    "actuator_biastype": ("mjtBias", "mjBIAS"),
    "wrap_type": ("mjtWrap", "mjWRAP"),
    "body_sameframe": ("mjtSameFrame", "mjSAMEFRAME"),
}
"""Field of ``MjModel`` -> its enumeration, and the prefix of the members."""

NOT_A_NUMBER = re.compile(r"(?:^|\s)[+-]?nan(?:\s|$)", re.IGNORECASE)

NUMERIC = re.compile(r"[\s0-9.eE+-]*", re.ASCII)

OPENED = "as opened"
"""Name of the state `qpos0`, in which a viewer opens a model."""

DYNAMIC = ("qpos", "qvel", "act", "ctrl", "mocap_pos", "mocap_quat", "time")
"""Fields of ``MjData`` in which two states may differ."""

EXACT = {"tolerance": 0.0, "iterations": 200, "ls_tolerance": 1e-6, "ls_iterations": 100}
"""Options with which MuJoCo's solver iterates to round-off."""


class State(NamedTuple):
    """A state of the file: ``keys`` are the keyframes that define it, or `OPENED`.

    ``number`` is the number of the keyframe, None for `OPENED`.
    """

    keys: tuple[str, ...]
    position: Array
    velocity: Array
    number: int | None

    @property
    def name(self) -> str:
        """Names of the keyframes that define it, joined by equals signs."""
        return " = ".join(self.keys)


@dataclass(frozen=True)
class Loaded:
    """A model with its text and MuJoCo's warnings.

    Attributes
    ----------
    mujoco : module
    path : Path
    source : Source
    spec, model
        ``MjSpec`` and ``MjModel``.
    warnings : tuple of str
        Warnings of MuJoCo's compiler.
    """

    mujoco: Any
    path: Path
    source: Source
    spec: Any
    model: Any
    warnings: tuple[str, ...]

    @cached_property
    def places(self) -> dict[tuple[str, int], Element]:
        """Element of the text for each object (kind, id), as far as it can be identified.

        Objects are identified by line, which MuJoCo does not know in included files, by name, or
        else by order, if equally many objects and elements remain.
        """
        places: dict[tuple[str, int], Element] = {}
        for kind, listed in LISTS.items():
            elements = [element for one, element in self.elements if one == kind]
            index, left = dict[Any, list[Element]](), []
            for one in elements:
                for key in (one.line, one.name, (one.line, one.name)):
                    index.setdefault(key, []).append(one)
            for made in getattr(self.spec, listed):
                match = re.search(r"line (\d+)", getattr(made, "info", "") or "")
                line, name = int(match[1]) if match else 0, made.name or None
                alike = index.get((line, name)) or index.get(line)
                alike = alike or (index.get(name, []) if name else [])
                if alike and made.id >= 0:  # of those in a line, the one after the object before
                    before = places.get((kind, made.id - 1))
                    at = alike.index(before) + 1 if before in alike else 0
                    places[kind, made.id] = alike[min(at, len(alike) - 1)]
                elif made.id > 0 or (made.id == 0 and kind != "body"):
                    left.append(made.id)
            taken = set(places.values())
            free = [element for element in elements if element not in taken]
            if len(free) == len(left):
                for number, element in zip(sorted(left), in_order(free), strict=True):
                    places[kind, number] = element
        return places

    @cached_property
    def numbers(self) -> dict[Element, list[int]]:
        """Ids of the objects that each element of the text became."""
        numbers: dict[Element, list[int]] = {}
        for (_, number), element in self.places.items():
            numbers.setdefault(element, []).append(number)
        return numbers

    @cached_property
    def elements(self) -> tuple[tuple[str, Element], ...]:
        """Elements that become objects, with their kinds."""
        elements = self.source.root.walk()
        return tuple((kind, element) for element in elements if (kind := kind_of(element)))

    def name(self, kind: str, number: SupportsInt) -> str:
        """Return the name of an object, or its kind and number."""
        kind_of_object = self.member("mjtObj", "mjOBJ", kind)
        name = self.mujoco.mj_id2name(self.model, kind_of_object, int(number))
        return str(name) if name else f"{kind} {number}"

    def member(self, enumeration: str, prefix: str, name: str) -> int:
        """Return a member of one of MuJoCo's enumerations."""
        return int(getattr(getattr(self.mujoco, enumeration), f"{prefix}_{name.upper()}"))

    def of_kind(self, field: str, *kinds: str) -> Flags:
        """Return the objects (n,) whose field of the model, one of `KINDS`, is of these kinds."""
        return np.isin(
            getattr(self.model, field), [self.member(*KINDS[field], kind) for kind in kinds]
        )

    def first_of(self, what: str) -> Numbers:
        """Return the first control ("ctrl") or force ("out") of each actuator (n_u,).

        Before MuJoCo 4.0 each has one of both.
        """
        count = len(self.model.actuator_trntype)
        return np.asarray(getattr(self.model, f"actuator_{what}adr", np.arange(count)))

    @cached_property
    def states(self) -> tuple[State, ...]:
        """Distinct states of the file, the one in which it opens first."""
        m = self.model
        every = [State((OPENED,), m.qpos0.copy(), np.zeros(m.nv), None)]
        every += [
            State((self.name("key", i),), m.key_qpos[i].copy(), m.key_qvel[i].copy(), i)
            for i in range(m.nkey)
        ]
        states: dict[tuple[float, ...], State] = {}
        for state in every:
            data = self.data(state)
            values = np.concatenate([np.ravel(getattr(data, field)) for field in DYNAMIC])
            same = states.get(key := tuple(values.tolist()))
            states[key] = state if same is None else state._replace(keys=same.keys + state.keys)
        return tuple(states.values())

    def at_limits(self, state: State) -> list[str]:
        """Return the joints that are at an end of their range in a state, up to round-off."""
        m = self.model
        off = np.abs(state.position[m.jnt_qposadr][:, None] - m.jnt_range)
        near = np.min(off, axis=1) <= NUMERICS.at_limit * np.max(np.abs(m.jnt_range), axis=1)
        return [self.name("joint", i) for i in np.flatnonzero(self.limited_joints & near)]

    @property
    def limited_joints(self) -> Flags:
        """Hinges and slides (njnt,) that have limits."""
        return (self.model.jnt_limited != 0) & self.of_kind("jnt_type", "slide", "hinge")

    @property
    def sliding_dofs(self) -> Flags:
        """Degrees of freedom (nv,) that translate: slides, and the first three of free joints."""
        m = self.model
        slide, free = (self.of_kind("jnt_type", kind)[m.dof_jntid] for kind in ("slide", "free"))
        return np.asarray(slide | (free & (np.arange(m.nv) - m.jnt_dofadr[m.dof_jntid] < 3)))

    def data(self, state: State, model: Any = None) -> Any:
        """Return MuJoCo's data in a state."""
        model = self.model if model is None else model
        data = self.mujoco.MjData(model)
        if state.number is not None:
            self.mujoco.mj_resetDataKeyframe(model, data, state.number)
        data.qpos[:], data.qvel[:] = state.position, state.velocity
        return data

    def sharp(self, *disabled: str) -> Any:
        """Return a copy of the model with exact accelerations, some parts switched off.

        Its integrator is Euler, since ``discrete`` has no accelerations, only steps; its solver is
        Newton's method, iterated to round-off.
        """
        lib = self.mujoco
        model = copy.copy(self.model)
        model.opt.integrator = lib.mjtIntegrator.mjINT_EULER
        model.opt.solver = lib.mjtSolver.mjSOL_NEWTON
        model.opt.jacobian = lib.mjtJacobian.mjJAC_DENSE
        for name, value in EXACT.items():
            setattr(model.opt, name, value)
        self.switch_off(model, "autoreset", "sensor", "warmstart", *disabled)
        return model

    def switch_off(self, model: Any, *names: str) -> None:
        """Switch off parts of a model by MuJoCo's flags."""
        for name in names:
            model.opt.disableflags |= self.member("mjtDisableBit", "mjDSBL", name)

    @cached_property
    def fatal_warnings(self) -> tuple[int, ...]:
        """Numbers of MuJoCo's warnings after which the state is lost."""
        names = ("badqpos", "badqvel", "badqacc")
        return tuple(self.member("mjtWarning", "mjWARN", name) for name in names)

    def lost(self, data: Any) -> bool:
        """Return True if MuJoCo has counted a non-finite or huge state."""
        return any(data.warning[number].number for number in self.fatal_warnings)

    def disabled(self, name: str) -> bool:
        """Return True if a flag of MuJoCo switches this part off."""
        return bool(self.model.opt.disableflags & self.member("mjtDisableBit", "mjDSBL", name))

    def enabled(self, name: str) -> bool:
        """Return True if a flag of MuJoCo switches this part on."""
        return bool(self.model.opt.enableflags & self.member("mjtEnableBit", "mjENBL", name))

    def compiled(self, text: str) -> Any:
        """Return the model of another text in the folder of the file; None if it is invalid."""
        with quiet(self.mujoco), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                spec = self.mujoco.MjSpec.from_string(text)
                spec.modelfiledir = str(self.path.parent)
                return spec.compile()
            except Exception:  # MuJoCo raises several types
                return None

    def dumped(self, model: Any) -> bytes:
        """Return a compiled model as bytes, which are equal for equal models."""
        buffer = np.zeros(self.mujoco.mj_sizeModel(model), np.uint8)
        self.mujoco.mj_saveModel(model, None, buffer)
        return buffer.tobytes()

    @cached_property
    def bits(self) -> bytes:
        """Compiled model of the file as bytes."""
        return self.dumped(self.model)

    def compiles_alike(self, text: str) -> bool:
        """Return True if another text compiles to the same model, to the last bit."""
        model = self.compiled(text)
        return model is not None and self.dumped(model) == self.bits

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Name of the joint of each degree of freedom."""
        return tuple(self.name("joint", joint) for joint in self.model.dof_jntid)


def kind_of(element: Element) -> str | None:
    """Return the kind of object that an element of the text becomes, if any."""
    section = element.parent
    if section is None or element.tag == "default" or element.within("default"):
        return None
    if section.tag in SECTIONS and section.parent is not None:
        return section.tag if section.parent.tag == ROOT else None
    if element.within("tendon", "equality"):
        return None
    return next((kind for kind in LISTS if element.tag in TAGS.get(kind, (kind,))), None)


def in_order(elements: Sequence[Element]) -> list[Element]:
    """Return elements in MuJoCo's order: parts of a body before those of its children."""
    owners = [next((id(a) for a in one.ancestors() if a.tag == "body"), 0) for one in elements]
    first = {owner: place for place, owner in reversed(list(enumerate(owners)))}
    return [elements[i] for i in sorted(range(len(elements)), key=lambda i: first[owners[i]])]


def load(path: str | Path) -> Loaded:
    """Read and compile a file.

    Raises
    ------
    UsageError
        If it cannot be read, is not MJCF, or MuJoCo does not compile it.
    """
    mujoco = import_mujoco()
    place = Path(path).absolute()
    if str(place).encode(errors="replace") != os.fsencode(place):
        raise UsageError(f"{place.name}: MuJoCo opens no file whose name is not UTF-8: rename it")
    source = read(place)
    refuse_numbers(source)
    with contained() as console, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            spec = mujoco.MjSpec.from_file(str(place))
            model = spec.compile()
        except Exception as error:  # ValueError, FatalError, and others, depending on the version
            failure = " ".join(str(error).split()) or type(error).__name__
        else:
            failure = ""
    if failure:
        words = failure.removeprefix("Error: ")
        raise UsageError(f"MuJoCo cannot compile {place.name}: {words}{includer(source, words)}")
    lines = [line.removeprefix("WARNING:").strip() for line in console.text.splitlines()]
    if not lines:  # older versions of MuJoCo print nothing
        lines = [" ".join(str(warning.message).split()) for warning in caught]
    return Loaded(mujoco, place, source, spec, model, tuple(line for line in lines if line))


def includer(source: Source, failure: str) -> str:
    """Return the line that includes the file which a message of MuJoCo names, if any."""
    for element in source.root.walk():
        files = [Path(x).name for key, x in element.attributes.items() if key.startswith("file")]
        if any(name and name in failure for name in files) and " line " not in failure:
            return f" ({element.file}, line {element.line})"
    return ""


def refuse_numbers(source: Source) -> None:
    """Refuse values that are not numbers, or too large to compute with."""
    for element in source.root.walk():
        for name, value in element.attributes.items():
            where = f"{element.file}, line {element.line}: {name} of {element.address}"
            if NOT_A_NUMBER.search(value) and name not in ("name", "class", "file"):
                raise UsageError(f"{where} is not a number: {value.strip()[:40]!r}")
            numeric = "e" in value.lower() and NUMERIC.fullmatch(value)
            if numeric and max(map(abs, numbers(value)), default=0.0) > NUMERICS.max_number:
                raise UsageError(f"{where} is out of any range: {value.strip()[:40]!r}")


def numbers(text: str) -> list[float]:
    """Return the numbers of an attribute; none if it has another form."""
    try:
        return [float(word) for word in text.split()]
    except ValueError:  # MuJoCo reports it
        return []


class NotFiniteError(MbcheckError):
    """Forces or accelerations are not finite in a state of the model."""

"""A model as MuJoCo compiles it, beside the text that it came from."""

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
from .source import ROOT, Element, Source, read

Flags = NDArray[np.bool_]
Numbers = NDArray[np.integer[Any]]

ENGINE = "mujoco"
"""Name under which the version of MuJoCo stands in documents."""

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
"""Kind of object -> where an ``MjSpec`` lists it."""

SECTIONS = ("tendon", "equality", "actuator", "sensor")
"""Kinds whose elements are told by the section of this name that holds them, not by their tags."""

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
"""Field of ``MjModel`` -> the enumeration that it is of, and how its members begin."""

NOT_A_NUMBER = re.compile(r"(?:^|\s)[+-]?nan(?:\s|$)", re.IGNORECASE)

NUMERIC = re.compile(r"[\s0-9.eE+-]*", re.ASCII)

LARGEST = 1e100
"""Largest number of the text that is taken; products of larger ones leave the range of floats."""

OPENED = "as opened"
"""State `qpos0`, in which a viewer opens a model."""

DYNAMIC = ("qpos", "qvel", "act", "ctrl", "mocap_pos", "mocap_quat", "time")
"""Fields of ``MjData`` in which two states may differ."""

AT_LIMIT = 1e-9
"""Share of its range within which a joint stands at a limit."""

LOST = ("badqpos", "badqvel", "badqacc")
"""Warnings of MuJoCo's after which a state is lost."""

EXACT = {"tolerance": 0.0, "iterations": 200, "ls_tolerance": 1e-6, "ls_iterations": 100}
"""Options with which MuJoCo's solver goes on to rounding."""


class State(NamedTuple):
    """A state that the file tells: ``keys`` are the keyframes that hold it, or `OPENED`.

    ``number`` is that of the keyframe, None for `OPENED`.
    """

    keys: tuple[str, ...]
    position: Array
    velocity: Array
    number: int | None

    @property
    def name(self) -> str:
        """Its keyframes in one word, or what else it is."""
        return " = ".join(self.keys)


@dataclass(frozen=True)
class Loaded:
    """A model, its text, and what MuJoCo said of it.

    Attributes
    ----------
    mujoco : module
    path : Path
    source : Source
    spec, model
        ``MjSpec`` and ``MjModel``.
    warnings : tuple of str
        MuJoCo's own, of compiling.
    """

    mujoco: Any
    path: Path
    source: Source
    spec: Any
    model: Any
    warnings: tuple[str, ...]

    @cached_property
    def places(self) -> dict[tuple[str, int], Element]:
        """Where each object (kind, id) stands in the text, where that is known.

        By line, which MuJoCo does not know in included files; by name; else by order, if as many
        objects as elements are left.
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
        """The objects that each element of the text became, by their ids."""
        numbers: dict[Element, list[int]] = {}
        for (_, number), element in self.places.items():
            numbers.setdefault(element, []).append(number)
        return numbers

    @cached_property
    def elements(self) -> tuple[tuple[str, Element], ...]:
        """The elements that become objects, with their kinds."""
        elements = self.source.walk()
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
        """Return where a field of the model, one of `KINDS`, is one of these kinds."""
        return np.isin(
            getattr(self.model, field), [self.member(*KINDS[field], kind) for kind in kinds]
        )

    @cached_property
    def states(self) -> tuple[State, ...]:
        """All states that the file tells, each once; the one that it opens in comes first."""
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
        """Return the joints that stand at the end of their range in a state, to rounding."""
        m = self.model
        one = self.of_kind("jnt_type", "slide", "hinge") & (m.jnt_limited != 0)
        off = np.abs(state.position[m.jnt_qposadr][:, None] - m.jnt_range)
        near = np.min(off, axis=1) <= AT_LIMIT * np.max(np.abs(m.jnt_range), axis=1)
        return [self.name("joint", number) for number in np.flatnonzero(one & near)]

    def data(self, state: State, model: Any = None) -> Any:
        """Return MuJoCo's data in a state."""
        model = self.model if model is None else model
        data = self.mujoco.MjData(model)
        if state.number is not None:
            self.mujoco.mj_resetDataKeyframe(model, data, state.number)
        data.qpos[:], data.qvel[:] = state.position, state.velocity
        return data

    def sharp(self, *disabled: str) -> Any:
        """Return a copy of the model whose accelerations are exact, some parts switched off.

        Euler, because ``discrete`` has steps in the place of accelerations; Newton's method to
        rounding.
        """
        lib = self.mujoco
        model = copy.copy(self.model)
        model.opt.integrator = lib.mjtIntegrator.mjINT_EULER
        model.opt.solver = lib.mjtSolver.mjSOL_NEWTON
        model.opt.jacobian = lib.mjtJacobian.mjJAC_DENSE
        for name, value in EXACT.items():
            setattr(model.opt, name, value)
        for name in ("autoreset", "sensor", "warmstart", *disabled):
            model.opt.disableflags |= self.member("mjtDisableBit", "mjDSBL", name)
        return model

    @cached_property
    def fatal(self) -> tuple[int, ...]:
        """The warnings of `LOST`, by their numbers."""
        return tuple(self.member("mjtWarning", "mjWARN", name) for name in LOST)

    def lost(self, data: Any) -> bool:
        """Return whether MuJoCo has counted a state that is not finite, or huge."""
        return any(data.warning[number].number for number in self.fatal)

    def disabled(self, name: str) -> bool:
        """Return whether a flag of MuJoCo switches something off."""
        return bool(self.model.opt.disableflags & self.member("mjtDisableBit", "mjDSBL", name))

    def enabled(self, name: str) -> bool:
        """Return whether a flag of MuJoCo switches something on."""
        return bool(self.model.opt.enableflags & self.member("mjtEnableBit", "mjENBL", name))

    def compiled(self, text: str) -> Any:
        """Return the model of another text, in the folder of this one; None if it is wrong."""
        with quiet(self.mujoco), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                spec = self.mujoco.MjSpec.from_string(text)
                spec.modelfiledir = str(self.path.parent)
                return spec.compile()
            except Exception:  # MuJoCo has several ways to say no
                return None

    def dumped(self, model: Any) -> bytes:
        """Return a compiled model as the bytes that tell whether another is the same."""
        buffer = np.zeros(self.mujoco.mj_sizeModel(model), np.uint8)
        self.mujoco.mj_saveModel(model, None, buffer)
        return buffer.tobytes()

    @cached_property
    def bits(self) -> bytes:
        """The compiled model of the file as these bytes."""
        return self.dumped(self.model)

    def compiles_alike(self, text: str) -> bool:
        """Return True if another text compiles to the same model, to the last bit."""
        model = self.compiled(text)
        return model is not None and self.dumped(model) == self.bits

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The name of the joint of each degree of freedom."""
        return tuple(self.name("joint", joint) for joint in self.model.dof_jntid)


def kind_of(element: Element) -> str | None:
    """Return what kind of object an element of the text becomes, if any."""
    section = element.parent
    if section is None or element.tag == "default" or element.within("default"):
        return None
    if section.tag in SECTIONS and section.parent is not None:
        return section.tag if section.parent.tag == ROOT else None
    if element.within("tendon", "equality"):
        return None
    return next((kind for kind in LISTS if element.tag in TAGS.get(kind, (kind,))), None)


def in_order(elements: Sequence[Element]) -> list[Element]:
    """Return elements in MuJoCo's order: what belongs to a body stands before its children's."""
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
        except Exception as error:  # ValueError, FatalError, and what else a version has
            failure = " ".join(str(error).split()) or type(error).__name__
        else:
            failure = ""
    if failure:
        words = failure.removeprefix("Error: ")
        raise UsageError(f"MuJoCo cannot compile {place.name}: {words}{asked_by(source, words)}")
    lines = [line.removeprefix("WARNING:").strip() for line in console.text.splitlines()]
    if not lines:  # older versions of MuJoCo tell only one way
        lines = [" ".join(str(warning.message).split()) for warning in caught]
    return Loaded(mujoco, place, source, spec, model, tuple(line for line in lines if line))


def asked_by(source: Source, failure: str) -> str:
    """Return which line asks for a file that a message of MuJoCo's names, if one does."""
    for element in source.walk():
        files = [Path(x).name for key, x in element.attributes.items() if key.startswith("file")]
        if any(name and name in failure for name in files) and " line " not in failure:
            return f" ({element.file}, line {element.line})"
    return ""


def refuse_numbers(source: Source) -> None:
    """Refuse values that are no numbers, or too large to compute with."""
    for element in source.walk():
        for name, value in element.attributes.items():
            where = f"{element.file}, line {element.line}: {name} of {element.address}"
            if NOT_A_NUMBER.search(value) and name not in ("name", "class", "file"):
                raise UsageError(f"{where} is not a number: {value.strip()[:40]!r}")
            numeric = "e" in value.lower() and NUMERIC.fullmatch(value)
            if numeric and max(map(abs, numbers(value)), default=0.0) > LARGEST:
                raise UsageError(f"{where} is out of any range: {value.strip()[:40]!r}")


def numbers(text: str) -> list[float]:
    """Return the numbers of an attribute; none if it holds something else."""
    try:
        return [float(word) for word in text.split()]
    except ValueError:  # MuJoCo says what it makes of it
        return []


class NotFiniteError(MbcheckError):
    """Forces or accelerations are not finite in a state of the model."""

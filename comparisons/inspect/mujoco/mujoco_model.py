"""A model as MuJoCo compiles it, beside the text that it came from."""

from __future__ import annotations

import copy
import os
import re
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ....reference.errors import EngineUnavailableError, MbcheckError, UsageError
from ....reference.scene import Array
from ...engines.mujoco import import_mujoco, quiet
from ...engines.run import contained
from ..source import Element, Source, read

LIKE: Mapping[str, str] = {
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

HOLDERS = {"tendon": "tendon", "equality": "equality", "actuator": "actuator", "sensor": "sensor"}
"""Kinds whose elements are told by the section that holds them, not by their tags."""

TAGS = {"joint": ("joint", "freejoint")}

NOT_A_NUMBER = re.compile(r"(?:^|\s)[+-]?nan(?:\s|$)", re.IGNORECASE)

NUMERIC = re.compile(r"[\s0-9.eE+-]*", re.ASCII)

LARGEST = 1e100
"""Of a number in the text; products of larger ones leave the range of floats."""

GL = "MUJOCO_GL"
"""Environment variable that MuJoCo reads as it is imported."""

OPENED = "as opened"
"""State `qpos0`, in which a viewer opens a model."""


class State(NamedTuple):
    """A state that the file tells: ``keys`` are the keyframes that hold it, or `OPENED`."""

    keys: tuple[str, ...]
    position: Array
    velocity: Array
    number: int | None
    """Of the keyframe; None for `OPENED`."""

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
        found: dict[tuple[str, int], Element] = {}
        for kind, listed in LIKE.items():
            elements = [element for one, element in self.elements if one == kind]
            lines, names = grouped(elements, "line"), grouped(elements, "name")
            left = []
            for made in getattr(self.spec, listed):
                match = re.search(r"line (\d+)", getattr(made, "info", "") or "")
                near = lines.get(int(match[1]) if match else 0, [])
                exact = [element for element in near if element.name == (made.name or None)]
                chosen = exact or near or (names.get(made.name, []) if made.name else [])
                if chosen and made.id >= 0:
                    found[kind, made.id] = self.nth(chosen, kind, made.id, found)
                elif made.id > 0 or (made.id == 0 and kind != "body"):
                    left.append(made.id)
            taken = {id(element) for (one, _), element in found.items() if one == kind}
            free = [element for element in elements if id(element) not in taken]
            if len(free) == len(left):
                for number, element in zip(sorted(left), in_order(free), strict=True):
                    found[kind, number] = element
        return found

    def nth(
        self, near: list[Element], kind: str, number: int, found: Mapping[Any, Element]
    ) -> Element:
        """Return the one of several elements in a line that is not taken by the one before."""
        before = found.get((kind, number - 1))
        at = near.index(before) + 1 if before in near else 0
        return near[min(at, len(near) - 1)]

    @cached_property
    def numbers(self) -> dict[Element, list[int]]:
        """The objects that each element of the text became, by their ids."""
        found: dict[Element, list[int]] = {}
        for (_, number), element in self.places.items():
            found.setdefault(element, []).append(number)
        return found

    @cached_property
    def elements(self) -> tuple[tuple[str, Element], ...]:
        """The elements that become objects, with their kinds."""
        kinds = ((kind_of(element), element) for element in self.source.walk())
        return tuple((kind, element) for kind, element in kinds if kind is not None)

    def element(self, kind: str, number: int) -> Element | None:
        """Return the element of an object, if it is known."""
        return self.places.get((kind, number))

    def name(self, kind: str, number: int) -> str:
        """Return the name of an object, or its kind and number."""
        view = self.mujoco.mj_id2name(self.model, self.object_types[kind], number)
        return str(view) if view else f"{kind} {number}"

    @cached_property
    def object_types(self) -> dict[str, Any]:
        """MuJoCo's word for a kind of object."""
        types = self.mujoco.mjtObj
        return {kind: getattr(types, f"mjOBJ_{kind.upper()}") for kind in LIKE}

    @cached_property
    def states(self) -> tuple[State, ...]:
        """All states that the file tells, each once; the one that it opens in comes first."""
        model = self.model
        still = np.zeros(model.nv)
        found = [State((OPENED,), model.qpos0.copy(), still, None)]
        for number in range(model.nkey):
            name = self.name("key", number)
            made = State(
                (name,), model.key_qpos[number].copy(), model.key_qvel[number].copy(), number
            )
            for i, other in enumerate(found):
                if self.same(made, other):
                    found[i] = other._replace(keys=(*other.keys, name), number=number)
                    break
            else:
                found.append(made)
        return tuple(found)

    def same(self, one: State, other: State) -> bool:
        """Return whether two states differ in nothing."""
        if not (
            np.array_equal(one.position, other.position)
            and np.array_equal(one.velocity, other.velocity)
        ):
            return False
        first, second = self.data(one), self.data(other)
        return all(
            np.array_equal(getattr(first, field), getattr(second, field))
            for field in ("act", "ctrl", "mocap_pos", "mocap_quat", "time")
        )

    def data(self, state: State, model: Any = None) -> Any:
        """Return MuJoCo's data in a state."""
        model = self.model if model is None else model
        data = self.mujoco.MjData(model)
        if state.number is not None:
            self.mujoco.mj_resetDataKeyframe(model, data, state.number)
        data.qpos[:] = state.position
        data.qvel[:] = state.velocity
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
        model.opt.tolerance, model.opt.iterations = 0.0, 200
        model.opt.ls_tolerance, model.opt.ls_iterations = 1e-6, 100
        for name in ("autoreset", "sensor", "warmstart", *disabled):
            model.opt.disableflags |= int(getattr(lib.mjtDisableBit, f"mjDSBL_{name.upper()}"))
        return model

    def disabled(self, name: str) -> bool:
        """Return whether a flag of MuJoCo switches something off."""
        bit = getattr(self.mujoco.mjtDisableBit, f"mjDSBL_{name.upper()}")
        return bool(self.model.opt.disableflags & int(bit))

    def enabled(self, name: str) -> bool:
        """Return whether a flag of MuJoCo switches something on."""
        bit = getattr(self.mujoco.mjtEnableBit, f"mjENBL_{name.upper()}")
        return bool(self.model.opt.enableflags & int(bit))

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
    def joint_of(self) -> Array:
        """The joint (nv,) that each degree of freedom belongs to."""
        return np.asarray(self.model.dof_jntid, dtype=int)

    def dof_name(self, dof: int) -> str:
        """Return the name of the joint of a degree of freedom."""
        return self.name("joint", int(self.joint_of[dof]))


def kind_of(element: Element) -> str | None:
    """Return what kind of object an element of the text becomes, if any."""
    if element.parent is None or element.within("default") or element.tag == "default":
        return None
    holder = element.parent.tag
    for kind, section in HOLDERS.items():
        if holder == section and element.parent.parent is not None:
            return kind if element.parent.parent.tag == "mujoco" else None
    if element.within("tendon") or element.within("equality"):
        return None
    return next((kind for kind in LIKE if element.tag in TAGS.get(kind, (kind,))), None)


def grouped(elements: list[Element], key: str) -> dict[Any, list[Element]]:
    """Return elements by one of their properties."""
    found: dict[Any, list[Element]] = {}
    for element in elements:
        found.setdefault(getattr(element, key), []).append(element)
    return found


def in_order(elements: list[Element]) -> list[Element]:
    """Return elements in MuJoCo's order: what belongs to a body stands before its children's."""
    owners = [next((id(a) for a in e.above[::-1] if a.tag == "body"), 0) for e in elements]
    first = {owner: place for place, owner in reversed(list(enumerate(owners)))}
    return [elements[i] for i in sorted(range(len(elements)), key=lambda i: first[owners[i]])]


def load(path: str | Path) -> Loaded:
    """Read and compile a file.

    Raises
    ------
    UsageError
        If it cannot be read, is not MJCF, or MuJoCo does not compile it.
    """
    mujoco = imported()
    place = Path(path).absolute()
    source = read(place)
    refuse_numbers(source)
    with contained() as console, warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            spec = mujoco.MjSpec.from_file(str(place))
            model = spec.compile()
        except Exception as error:  # ValueError, FatalError, and what else a version has
            failure = " ".join(str(error).split()) or type(error).__name__
        else:
            failure = ""
    if failure:
        raise UsageError(f"MuJoCo cannot compile {place.name}: {failure.removeprefix('Error: ')}")
    lines = [line.removeprefix("WARNING:").strip() for line in console.text.splitlines()]
    if not lines:  # older versions of MuJoCo tell only one way
        lines = [" ".join(str(warning.message).split()) for warning in told]
    return Loaded(mujoco, place, source, spec, model, tuple(line for line in lines if line))


def imported() -> Any:
    """Return the mujoco module.

    Raises
    ------
    EngineUnavailableError
        With the reason.
    """
    try:
        return import_mujoco()
    except EngineUnavailableError as error:
        chosen = os.environ.get(GL)
        if not chosen:
            raise
        raise EngineUnavailableError(
            f"{error}; {GL}={chosen} asks for an OpenGL that may not be there: leave it unset, or "
            "install its library (on Debian libosmesa6 for osmesa, libegl1 for egl)"
        ) from error


def refuse_numbers(source: Source) -> None:
    """Refuse values that are no numbers, or too large to compute with.

    Raises
    ------
    UsageError
    """
    for element in source.walk():
        for name, value in element.attributes.items():
            where = f"{element.file}, line {element.line}: {name} of {element.address}"
            if NOT_A_NUMBER.search(value) and name not in ("name", "class", "file"):
                raise UsageError(f"{where} is not a number: {value.strip()[:40]!r}")
            if "e" in value.lower() and NUMERIC.fullmatch(value):
                try:
                    numbers = [abs(float(word)) for word in value.split()]
                except ValueError:
                    continue  # MuJoCo says what it makes of it
                if max(numbers, default=0.0) > LARGEST:
                    raise UsageError(f"{where} is out of any range: {value.strip()[:40]!r}")


class NotFiniteError(MbcheckError):
    """Forces or accelerations are not finite in a state of the model."""

"""Rules about the text: what it repeats, states without effect, or leaves open."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator

import numpy as np

from ..mujoco.model import numbers
from ..mujoco.source import ROOT, Attribute, Element
from ..subject import Hit, InspectedModel
from ..tuning import EFFORT, THRESHOLDS
from .parts import about_attribute, shortened

CONVENTIONS = ("compiler", "include", ROOT)
"""Elements whose attributes define the meaning of the file, and are never redundant."""

IDENTITY = ("name", "file", "user")
"""Attributes that are not tried."""

ANGLES = ("euler", "axisangle")
JOINT_ANGLES = ("range", "ref", "springref", "springdamper")


def repeated_default(
    s: InspectedModel, hits: Collection[Hit] = (), budget: float = EFFORT.compiled_bytes
) -> tuple[list[Hit], str | None]:
    """Return attributes without which the file compiles to the same bytes.

    Parameters
    ----------
    s : InspectedModel
    hits : collection of Hit
        Findings of other rules, whose attributes are not tried.
    budget : float
        See `EffortLimits.compiled_bytes`.

    Returns
    -------
    The findings, and the reason why some attributes were not tried, if any.
    """
    source, known = s.loaded.source, {(hit.element, hit.attribute) for hit in hits}

    def same(left_out: Collection[Attribute]) -> bool:
        return s.loaded.compiles_alike(source.text(left_out))

    if not same([]):
        return [], "the file does not compile to the same from one text"
    groups: dict[tuple[str, str], dict[tuple[str, ...], list[Attribute]]] = {}
    for element, key in attributes(s):
        if (element, key) not in known:
            words = (element.attributes.get("class", ""), element.attributes.get("type", ""))
            value = (element.attributes[key], *words, str(element.within("default")))
            alike = groups.setdefault((element.tag, key), {})
            alike.setdefault(value, []).append((element, key))
    likely = [
        alike[value]
        for alike in groups.values()
        for value in sorted(alike, key=lambda words: len(words[0]))[: EFFORT.values]
    ]
    tried = likely[: max(1, int(budget / (len(source.text()) + len(s.loaded.bits))))]
    singly = sum(map(len, likely)) <= EFFORT.single_attributes
    idle: list[Attribute] = []
    for group in tried:
        if same(group):
            idle += group
        elif singly and len(group) > 1:
            idle += [one for one in group if same([one])]
    left = sum(map(len, groups.values())) - len(tried)
    reason = f"{left} values of attributes were not tried, in so large a file" if left else None
    return [about_attribute(*one, "changes nothing: the model is the same") for one in idle], reason


def attributes(s: InspectedModel) -> Iterator[Attribute]:
    """Yield the attributes that are tried."""
    unused = set(unused_classes(s))
    for element in s.loaded.source.root.walk():
        needed = element.tag in CONVENTIONS or element.within("custom")
        if not (needed or unused.intersection((element, *element.ancestors()))):
            yield from ((element, key) for key in element.attributes if key not in IDENTITY)


def unused_class(s: InspectedModel) -> Iterator[Hit]:
    for element in unused_classes(s):
        name = element.attributes["class"]
        yield Hit(element, f"default:{name}", f"no element is of class {name}")


def unused_classes(s: InspectedModel) -> list[Element]:
    """Return the classes of defaults that no element uses, nor a class within them."""
    used = {
        element.attributes.get(key)
        for element in s.loaded.source.root.walk()
        for key in ("class", "childclass")
        if element.tag != "default"
    }
    return [
        element
        for element in s.loaded.source.tagged("default")
        if element.parent is not None
        and element.parent.tag == "default"
        and "class" in element.attributes
        and used.isdisjoint(
            below.attributes.get("class", "") for below in element.walk() if below.tag == "default"
        )
    ]


def constrained(s: InspectedModel) -> bool:
    """Return True if MuJoCo's solver may have constraints to solve."""
    m = s.model
    parts = (m.jnt_limited, m.tendon_limited, m.dof_frictionloss, m.tendon_frictionloss)
    iterative = s.options.integrator == "discrete"
    return bool(m.neq or iterative or touches(s) or any(map(np.any, parts)))


def touches(s: InspectedModel) -> bool:
    """Return True if anything can touch."""
    return bool(s.model.nflex or np.any(s.can_touch))


OPTIONS: dict[tuple[str, ...], tuple[Callable[[InspectedModel], bool], str]] = {
    ("solver", "iterations", "tolerance", "ls_iterations", "ls_tolerance", "jacobian"): (
        constrained,
        "there is no constraint to solve for",
    ),
    (
        *("cone", "impratio", "noslip_iterations", "noslip_tolerance"),
        *("ccd_iterations", "ccd_tolerance", "sdf_iterations", "sdf_initpoints"),
    ): (touches, "nothing can touch"),
    ("o_margin", "o_solref", "o_solimp", "o_friction"): (
        lambda s: touches(s) and s.loaded.enabled("override"),
        "contacts are not overridden (flag override)",
    ),
    ("magnetic",): (
        lambda s: bool(np.any(s.loaded.of_kind("sensor_type", "magnetometer"))),
        "no magnetometer feels it",
    ),
    ("wind",): (
        lambda s: bool(s.model.opt.density or s.model.opt.viscosity),
        "there is no medium: density and viscosity are 0",
    ),
    ("sleep_tolerance",): (lambda s: s.loaded.enabled("sleep"), "nothing sleeps (flag sleep)"),
}
"""Attributes of ``option`` -> test that the model uses them, and the reason if not."""


def unused_option(s: InspectedModel) -> Iterator[Hit]:
    uses = {key: OPTIONS[keys] for keys in OPTIONS for key in keys}
    for element in s.loaded.source.tagged("option"):
        for key in element.attributes:
            if key in uses and not uses[key][0](s):
                yield about_attribute(element, key, f"has no effect: {uses[key][1]}")


SETTINGS: dict[str, dict[tuple[str, ...], tuple[str, str]]] = {
    "joint": {
        ("springref",): ("jnt_stiffness", "it has no stiffness"),
        ("margin", "solreflimit", "solimplimit"): ("jnt_limited", "it has no limits"),
        ("solreffriction", "solimpfriction"): ("dof_frictionloss", "it has no friction"),
    },
    "tendon": {
        ("springlength",): ("tendon_stiffness", "it has no stiffness"),
        ("margin", "solreflimit", "solimplimit"): ("tendon_limited", "it has no limits"),
        ("solreffriction", "solimpfriction"): ("tendon_frictionloss", "it has no friction"),
    },
}
"""Kind -> attributes -> field without which they have no effect, and the reason."""

CONTACT = ("condim", "friction", "solref", "solimp", "solmix", "margin", "gap", "priority")
"""Attributes of a geom that matter in contact."""


def unused_setting(s: InspectedModel) -> Iterator[Hit]:
    m = s.model
    for kind, element in s.loaded.elements:
        if not (made := s.loaded.numbers.get(element, [])):
            continue
        idle = []
        for keys, (field, reason) in SETTINGS.get(kind, {}).items():
            objects = np.isin(m.dof_jntid, made) if field.startswith("dof_") else made
            idle += [] if np.any(getattr(m, field)[objects]) else [(keys, reason)]
        if kind == "geom" and not m.nflex and not np.any(s.can_touch[made]):
            idle.append((CONTACT, "it cannot touch anything"))
        for keys, reason in idle:
            for key in filter(element.attributes.__contains__, keys):
                yield about_attribute(element, key, f"has no effect: {reason}")


def implicit_degrees(s: InspectedModel) -> Iterator[Hit]:
    elements = [] if s.setting("angle") else s.loaded.source.root.walk()
    keys = [(element, key) for element in elements for key in angles(s, element)]
    for element, key in keys[:1]:
        text = shortened(element.attributes[key])
        more = f", and {len(keys) - 1} others" if len(keys) > 1 else ""
        words = f'{key}="{text}"{more}: angles are in degrees, the default, as no unit is given'
        yield Hit(element, element.address, words, attribute=key)


def angles(s: InspectedModel, element: Element) -> list[str]:
    """Return the attributes of an element that hold angles other than 0."""
    keys: Collection[str] = ANGLES
    if element.tag == "joint" and not element.within("tendon", "equality"):
        slide = s.loaded.of_kind("jnt_type", "slide")[s.loaded.numbers.get(element, [])[:1]]
        if element.within("default") and element.attributes.get("type") == "slide":
            return []
        keys = ANGLES if np.any(slide) else (*ANGLES, *JOINT_ANGLES)
    return [key for key in keys if any(numbers(element.attributes.get(key, "")))]


def angle_unit(s: InspectedModel) -> Iterator[Hit]:
    radians, hinges = s.setting("angle") == "radian", s.loaded.of_kind("jnt_type", "hinge")
    for kind, element in s.loaded.elements:
        made = s.loaded.numbers.get(element, [])
        if kind != "joint" or not made or not hinges[made[0]]:
            continue
        size = max(map(abs, numbers(element.attributes.get("range", ""))), default=0.0)
        if radians and size > THRESHOLDS.max_turn:
            words = f"a range of {size:g} rad is {size / (2 * np.pi):.3g} turns: in degrees?"
        elif not radians and 0 < size < np.pi + 0.01:
            words = f"a range of {size:g} degrees is {np.deg2rad(size):.2g} rad: in radians?"
        else:
            continue
        yield Hit(element, element.address, words, attribute="range")

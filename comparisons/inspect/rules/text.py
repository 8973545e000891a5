"""Rules about the text: what is said twice, said in vain, or not said."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator

import numpy as np

from ..mujoco.model import numbers
from ..mujoco.source import ROOT, Attribute, Element
from ..subject import Hit, InspectedModel

BUDGET = 4e7
"""Bytes of text and models that are compiled at most to find defaults that are repeated."""

VALUES = 40
"""Different values of one attribute that are tried at most, the shortest first: defaults are."""

SINGLY = 200
"""Attributes up to which each is tried alone where a group of equal ones makes a difference."""

CONVENTIONS = ("compiler", "include", ROOT)
"""Elements whose attributes tell what the rest of the file means: saying these is right."""

IDENTITY = ("name", "file", "user")
"""Attributes that are not tried."""

TURN = 4 * np.pi
"""A range of a hinge beyond it is one in degrees, if radians are meant."""

ANGLES = ("euler", "axisangle")
JOINT_ANGLES = ("range", "ref", "springref", "springdamper")


def repeated_default(
    s: InspectedModel, hits: Collection[Hit] = (), budget: float = BUDGET
) -> tuple[list[Hit], str | None]:
    """Return attributes without which the file compiles to the same bytes.

    Parameters
    ----------
    s : InspectedModel
    hits : collection of Hit
        Findings of other rules, whose attributes are not tried.
    budget : float
        See `BUDGET`.

    Returns
    -------
    The findings, and why some attributes were not tried, if any were not.
    """
    source, stated = s.loaded.source, {(hit.element, hit.attribute) for hit in hits}

    def same(left_out: Collection[Attribute]) -> bool:
        return s.loaded.compiles_alike(source.text(left_out))

    if not same([]):
        return [], "the file does not compile to the same from one text"
    groups: dict[tuple[str, str], dict[tuple[str, ...], list[Attribute]]] = {}
    for element, key in attributes(s):
        if (element, key) not in stated:
            words = (element.attributes.get("class", ""), element.attributes.get("type", ""))
            value = (element.attributes[key], *words, str(element.within("default")))
            alike = groups.setdefault((element.tag, key), {})
            alike.setdefault(value, []).append((element, key))
    likely = [
        alike[value]
        for alike in groups.values()
        for value in sorted(alike, key=lambda words: len(words[0]))[:VALUES]
    ]
    tried = likely[: max(1, int(budget / (len(source.text()) + len(s.loaded.bits))))]
    singly = sum(map(len, likely)) <= SINGLY
    idle: list[Attribute] = []
    for group in tried:
        if same(group):
            idle += group
        elif singly and len(group) > 1:
            idle += [one for one in group if same([one])]
    left = sum(map(len, groups.values())) - len(tried)
    reason = f"{left} values of attributes were not tried, in so large a file" if left else None
    return [in_vain(*one, "changes nothing: the model is the same") for one in idle], reason


def attributes(s: InspectedModel) -> Iterator[Attribute]:
    """Yield the attributes that may be left out for a try."""
    unused = set(unused_classes(s))
    for element in s.loaded.source.walk():
        right = element.tag in CONVENTIONS or element.within("custom")
        if not (right or unused.intersection((element, *element.ancestors()))):
            yield from ((element, key) for key in element.attributes if key not in IDENTITY)


def in_vain(element: Element, key: str, reason: str) -> Hit:
    """Return the finding of an attribute that need not stand there."""
    text = shortened(element.attributes[key])
    return Hit(element, element.address, f'{key}="{text}" {reason}', attribute=key)


def shortened(text: str, most: int = 40) -> str:
    """Return the beginning of a text."""
    return text if len(text) <= most else f"{text[:most]}..."


def unused_class(s: InspectedModel) -> Iterator[Hit]:
    for element in unused_classes(s):
        name = element.attributes["class"]
        yield Hit(element, f"default:{name}", f"no element is of class {name}")


def unused_classes(s: InspectedModel) -> list[Element]:
    """Return the classes of defaults that neither an element nor a class within them has."""
    used = {
        element.attributes.get(key)
        for element in s.loaded.source.walk()
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
    """Return whether MuJoCo's solver ever has something to solve."""
    m = s.model
    parts = (m.jnt_limited, m.tendon_limited, m.dof_frictionloss, m.tendon_frictionloss)
    iterative = s.facts.options.integrator == "discrete"
    return bool(m.neq or iterative or touches(s) or any(map(np.any, parts)))


def touches(s: InspectedModel) -> bool:
    """Return whether anything can touch."""
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
"""Attributes of ``option`` -> whether the model has a use for them, and why not."""


def unused_option(s: InspectedModel) -> Iterator[Hit]:
    uses = {key: OPTIONS[keys] for keys in OPTIONS for key in keys}
    for element in s.loaded.source.tagged("option"):
        for key in element.attributes:
            if key in uses and not uses[key][0](s):
                yield in_vain(element, key, f"has no use: {uses[key][1]}")


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
"""Kind -> attributes -> the field without which they have no use, and why not."""

CONTACT = ("condim", "friction", "solref", "solimp", "solmix", "margin", "gap", "priority")
"""Attributes of a geom that matter in contact."""


def unused_setting(s: InspectedModel) -> Iterator[Hit]:
    m = s.model
    for kind, element in s.loaded.elements:
        made = s.loaded.numbers.get(element, [])
        for keys, (field, reason) in SETTINGS.get(kind, {}).items() if made else ():
            of_dofs = np.isin(m.dof_jntid, made) if field.startswith("dof_") else made
            if not np.any(getattr(m, field)[of_dofs]):
                yield from useless(element, keys, reason)
        if kind == "geom" and made and not m.nflex and not np.any(s.can_touch[made]):
            yield from useless(element, CONTACT, "it cannot touch anything")


def useless(element: Element, keys: tuple[str, ...], reason: str) -> list[Hit]:
    """Return those attributes of an element that have no use."""
    present = [key for key in keys if key in element.attributes]
    return [in_vain(element, key, f"has no use: {reason}") for key in present]


def implicit_degrees(s: InspectedModel) -> Iterator[Hit]:
    elements = [] if s.setting("angle") else s.loaded.source.walk()
    keys = [(element, key) for element in elements for key in angles(s, element)]
    for element, key in keys[:1]:
        text = shortened(element.attributes[key])
        more = f", and {len(keys) - 1} others" if len(keys) > 1 else ""
        message = (
            f'{key}="{text}"{more}: angles are in degrees because the file does not say otherwise'
        )
        yield Hit(element, element.address, message, attribute=key)


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
        if radians and size > TURN:
            words = f"a range of {size:g} rad is {size / (2 * np.pi):.3g} turns: degrees are meant?"
        elif not radians and 0 < size < np.pi + 0.01:
            words = f"a range of {size:g} degrees is {np.deg2rad(size):.2g} rad: radians are meant?"
        else:
            continue
        yield Hit(element, element.address, words, attribute="range")

"""Rules about the text: what is said twice, said in vain, or not said."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator

import numpy as np

from ..source import Element
from ..subject import Hit, Subject
from .find_model import setting

BUDGET = 4e7
"""Bytes of text and models that are compiled at most to find defaults that are repeated."""

VALUES = 40
"""Different values of one attribute that are tried at most, the shortest first: defaults are."""

SINGLY = 200
"""Attributes up to which each is tried alone where a group of equal ones makes a difference."""

CONVENTIONS = ("compiler", "include", "mujoco")
"""Elements whose attributes tell what the rest of the file means: saying these is right."""

IDENTITY = ("name", "file", "user")
"""Attributes that are not tried."""

TURN = 4 * np.pi
"""A range of a hinge beyond it is one in degrees, if radians are meant."""

ANGLES = ("euler", "axisangle", "range", "ref", "springref", "springdamper")


def repeated_default(
    s: Subject, told: Collection[tuple[Element, str]]
) -> tuple[list[Hit], str | None]:
    """Return attributes without which the file compiles to the same bytes.

    Parameters
    ----------
    s : Subject
    told : collection of (Element, str)
        Attributes that another rule has told.

    Returns
    -------
    The findings, and why some attributes were not tried, if any were not.
    """
    source = s.loaded.source
    whole = s.loaded.dumped(s.loaded.model)

    def same(left_out: list[tuple[Element, str]]) -> bool:
        model = s.loaded.compiled(source.text(left_out))
        return model is not None and s.loaded.dumped(model) == whole

    if not same([]):
        return [], "the file does not compile to the same from one text"
    groups: dict[tuple[str, str], dict[tuple[str, ...], list[tuple[Element, str]]]] = {}
    vain = set(unused_classes(s))
    for element, key in attributes(source.walk(), told):
        if vain.intersection((element, *element.above)):
            continue
        words = (element.attributes.get("class", ""), element.attributes.get("type", ""))
        alike = groups.setdefault((element.tag, key), {})
        value = (element.attributes[key], *words, str(element.within("default")))
        alike.setdefault(value, []).append((element, key))
    likely = [
        alike[value]
        for alike in groups.values()
        for value in sorted(alike, key=lambda words: len(words[0]))[:VALUES]
    ]
    affordable = max(1, int(BUDGET / (len(source.text()) + len(whole))))
    singly = sum(map(len, likely)) <= SINGLY
    found: list[Hit] = []
    for group in likely[:affordable]:
        if same(group):
            found += [repeated(element, key) for element, key in group]
        elif singly and len(group) > 1:
            found += [repeated(*one) for one in group if same([one])]
    left = sum(map(len, groups.values())) - min(len(likely), affordable)
    return (
        found,
        f"{left} values of attributes were not tried, in so large a file" if left else None,
    )


def attributes(
    elements: Iterator[Element], told: Collection[tuple[Element, str]]
) -> Iterator[tuple[Element, str]]:
    """Yield the attributes that may be left out for a try."""
    for element in elements:
        if element.tag in CONVENTIONS or element.within("custom"):
            continue
        for key in element.attributes:
            if key not in IDENTITY and (element, key) not in told:
                yield element, key


def repeated(element: Element, key: str) -> Hit:
    """Return the finding of an attribute that changes nothing."""
    message = f'{key}="{shortened(element.attributes[key])}" changes nothing: the model is the same'
    return Hit(element, element.address, message, attribute=key)


def shortened(text: str, most: int = 40) -> str:
    """Return the beginning of a text."""
    return text if len(text) <= most else f"{text[:most]}..."


def unused_class(s: Subject) -> Iterator[Hit]:
    """A class of defaults that nothing has."""
    for element in unused_classes(s):
        name = element.attributes["class"]
        yield Hit(element, f"default:{name}", f"no element is of class {name}")


def unused_classes(s: Subject) -> list[Element]:
    """Return the classes of defaults that neither an element nor a class within them has."""
    elements = list(s.loaded.source.walk())
    used = {
        element.attributes.get(key)
        for element in elements
        for key in ("class", "childclass")
        if element.tag != "default"
    }
    found = []
    for element in elements:
        nested = element.parent is not None and element.parent.tag == "default"
        if nested and element.tag == "default" and "class" in element.attributes:
            inside = (below for below in element.walk() if below.tag == "default")
            if not used.intersection(below.attributes.get("class", "") for below in inside):
                found.append(element)
    return found


def constrained(s: Subject) -> bool:
    """Return whether MuJoCo's solver ever has something to solve."""
    m = s.loaded.model
    parts = (m.jnt_limited, m.tendon_limited, m.dof_frictionloss, m.tendon_frictionloss)
    iterative = s.facts.options.integrator == "discrete"
    return bool(m.neq or m.nflex or iterative or any(map(np.any, parts)) or np.any(s.touching))


def touched(s: Subject) -> bool:
    """Return whether anything can touch."""
    return bool(s.loaded.model.nflex or np.any(s.touching))


def magnetic(s: Subject) -> bool:
    """Return whether a sensor feels a magnetic field."""
    kind = int(s.loaded.mujoco.mjtSensor.mjSENS_MAGNETOMETER)
    return bool(np.any(s.loaded.model.sensor_type == kind))


def overriding(s: Subject) -> bool:
    """Return whether contacts are overridden."""
    return touched(s) and s.loaded.enabled("override")


def windy(s: Subject) -> bool:
    """Return whether there is a medium that can flow."""
    return bool(s.loaded.model.opt.density or s.loaded.model.opt.viscosity)


CONTACT_OPTIONS = (
    "cone",
    "impratio",
    "noslip_iterations",
    "noslip_tolerance",
    "ccd_iterations",
    "ccd_tolerance",
    "sdf_iterations",
    "sdf_initpoints",
)

OPTIONS: dict[str, tuple[Callable[[Subject], bool], str]] = {
    **dict.fromkeys(
        ("solver", "iterations", "tolerance", "ls_iterations", "ls_tolerance", "jacobian"),
        (constrained, "there is no constraint to solve for"),
    ),
    **dict.fromkeys(
        CONTACT_OPTIONS,
        (touched, "nothing can touch"),
    ),
    **dict.fromkeys(
        ("o_margin", "o_solref", "o_solimp", "o_friction"),
        (overriding, "contacts are not overridden (flag override)"),
    ),
    "magnetic": (magnetic, "no magnetometer feels it"),
    "wind": (windy, "there is no medium: density and viscosity are 0"),
    "sleep_tolerance": (lambda s: s.loaded.enabled("sleep"), "nothing sleeps (flag sleep)"),
}
"""Attribute of ``option`` -> whether the model has a use for it, and why not."""


def unused_option(s: Subject) -> Iterator[Hit]:
    """An option that nothing uses."""
    for element in s.loaded.source.tagged("option"):
        for key, value in element.attributes.items():
            if key in OPTIONS and not OPTIONS[key][0](s):
                message = f'{key}="{shortened(value)}" has no use: {OPTIONS[key][1]}'
                yield Hit(element, element.address, message, attribute=key)


SETTINGS: dict[str, dict[tuple[str, ...], tuple[str, str]]] = {
    "joint": {
        ("springref",): ("jnt_stiffness", "it has no stiffness"),
        ("margin", "solreflimit", "solimplimit"): ("jnt_limited", "it has no limits"),
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


def unused_setting(s: Subject) -> Iterator[Hit]:
    """An attribute that its element has no use for."""
    can = s.touching
    m = s.loaded.model
    for kind, element in s.loaded.elements:
        numbers = s.loaded.numbers.get(element, [])
        for keys, (field, reason) in SETTINGS.get(kind, {}).items():
            if numbers and not np.any(getattr(m, field)[numbers]):
                yield from idle(element, keys, reason)
        if kind == "joint" and numbers:
            dofs = np.isin(m.dof_jntid, numbers)
            if not np.any(m.dof_frictionloss[dofs]):
                yield from idle(element, ("solreffriction", "solimpfriction"), "it has no friction")
        if kind == "geom" and numbers and not m.nflex and not np.any(can[numbers]):
            yield from idle(element, CONTACT, "it cannot touch anything")


def idle(element: Element, keys: tuple[str, ...], reason: str) -> Iterator[Hit]:
    """Yield those attributes of an element that have no use."""
    for key in keys:
        if key in element.attributes:
            message = f'{key}="{shortened(element.attributes[key])}" has no use: {reason}'
            yield Hit(element, element.address, message, attribute=key)


def implicit_degrees(s: Subject) -> Iterator[Hit]:
    """Angles whose unit the file does not tell."""
    if setting(s, "angle"):
        return
    found = [(e, key) for e in s.loaded.source.walk() for key in angles(s, e)]
    if found:
        element, key = found[0]
        more = f", and {len(found) - 1} others" if len(found) > 1 else ""
        yield Hit(
            element,
            element.address,
            f'{key}="{shortened(element.attributes[key])}"{more}: angles are in degrees because '
            "the file does not say otherwise",
            attribute=key,
        )


def angles(s: Subject, element: Element) -> list[str]:
    """Return the attributes of an element that hold angles other than 0."""
    keys: Collection[str] = ANGLES[:2]
    if element.tag == "joint" and not element.within("tendon") and not element.within("equality"):
        kinds = [s.loaded.model.jnt_type[i] for i in s.loaded.numbers.get(element, [])]
        slide = int(s.loaded.mujoco.mjtJoint.mjJNT_SLIDE)
        if element.within("default") and element.attributes.get("type") == "slide":
            return []
        keys = ANGLES if not kinds or kinds[0] != slide else ANGLES[:2]
    return [key for key in keys if any(numbers(element.attributes.get(key, "")))]


def numbers(text: str) -> list[float]:
    """Return the numbers of an attribute; none if it holds something else."""
    try:
        return [float(word) for word in text.split()]
    except ValueError:
        return []


def angle_unit(s: Subject) -> Iterator[Hit]:
    """Angles that look as if they were in the other unit."""
    radians = setting(s, "angle") == "radian"
    hinge = int(s.loaded.mujoco.mjtJoint.mjJNT_HINGE)
    for kind, element in s.loaded.elements:
        made = s.loaded.numbers.get(element, [])
        if kind != "joint" or not made or s.loaded.model.jnt_type[made[0]] != hinge:
            continue
        size = max(map(abs, numbers(element.attributes.get("range", ""))), default=0.0)
        if radians and size > TURN:
            words = f"a range of {size:g} rad is {size / (2 * np.pi):.3g} turns: degrees are meant?"
        elif not radians and 0 < size < np.pi + 0.01:
            words = f"a range of {size:g} degrees is {np.deg2rad(size):.2g} rad: radians are meant?"
        else:
            continue
        yield Hit(element, element.address, words, attribute="range")

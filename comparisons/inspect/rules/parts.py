"""Rules about what a model consists of: bodies, joints, geoms, actuators, tendons, sensors."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from ...checks.rules import conditions
from ...engines.mujoco.engine import MuJoCo
from ..mujoco.facts import exclusions, kinds_of_geom, partners
from ..mujoco.model import Flags
from ..mujoco.source import ROOT
from ..subject import Hit, InspectedModel

MERGED = 1e-6
"""Distance [m] below which MuJoCo takes a centre of mass for its body's frame."""

ROUNDED = 1e-12
"""Share of the model's size by which rounding may move a centre of mass."""

POINT = 1e-4
"""Radius of gyration, in the model's size, below which a body is a point: insects are none."""

HEAVY = 1e3
"""Times the inertia of what a joint moves."""

NARROW = 1e-6
"""Range [rad, m] of a joint that holds it."""

PROBES = 4
"""Random states in which a joint that nothing moves is looked for."""

IDLE = 1e-12
"""Share of the largest acceleration that is none."""

MOST_DOFS = 400
"""With more, joints that nothing moves are not looked for."""

NAMING = ("body", "body1", "body2", "objname", "refname", "target", "subtree1", "subtree2")
"""Attributes that name a body."""


def welded_body(s: InspectedModel) -> Iterator[Hit]:
    m = s.model
    return s.hits(
        "body",
        leaves(s) & ~empty(s) & (m.body_weldid != 0) & (m.body_jntnum == 0),
        lambda i: (
            "it has no joint and no child: it is a part of "
            f"{s.loaded.name('body', m.body_parentid[i])}, of {m.body_mass[i]:.4g} kg"
        ),
    )


def empty_body(s: InspectedModel) -> Iterator[Hit]:
    return s.hits("body", leaves(s) & empty(s), "it has no mass, no geom, no site and no child")


def leaves(s: InspectedModel) -> Flags:
    """Return which bodies (nbody,) have no children, and are named by nothing else of the file."""
    m, elements = s.model, s.loaded.source.walk()
    words = {element.attributes.get(key, "") for element in elements for key in NAMING}
    named = words.union(*(word.split() for word in words))
    unnamed = np.array([i and s.loaded.name("body", i) not in named for i in range(m.nbody)], bool)
    return unnamed & (m.body_mocapid < 0) & ~np.isin(np.arange(m.nbody), m.body_parentid)


def empty(s: InspectedModel) -> Flags:
    """Return which bodies (nbody,) have neither mass nor parts."""
    m = s.model
    owners = (m.jnt_bodyid, m.geom_bodyid, m.site_bodyid, m.cam_bodyid, m.light_bodyid)
    idle = ~np.isin(np.arange(m.nbody), np.concatenate(owners)) & (m.body_mass == 0)
    return idle & (m.nflex == 0)


def locked_joint(s: InspectedModel) -> Iterator[Hit]:
    m = s.model
    locks = s.loaded.of_kind("eq_type", "joint") & (m.eq_obj2id < 0) & (m.eq_active0 != 0)
    yield from s.hits(
        "joint",
        locks & (not s.loaded.disabled("equality")),
        lambda i: f"equality {s.loaded.name('equality', i)} holds it at one place",
        of=m.eq_obj1id,
    )
    width, simple = np.diff(m.jnt_range)[:, 0], s.loaded.of_kind("jnt_type", "slide", "hinge")
    yield from s.hits(
        "joint",
        (m.jnt_limited != 0) & simple & (width < NARROW),
        lambda i: f"its range is {width[i]:.2g} wide, and holds it",
    )


def idle_joint(s: InspectedModel) -> Iterator[Hit]:
    m = s.model
    if not m.nv or m.nv > MOST_DOFS or m.nflex:
        return
    trees = m.body_treeid[m.geom_bodyid[s.can_touch]]
    moves = np.isin(m.dof_treeid, trees) | np.any([one.velocity for one in s.loaded.states], axis=0)
    lib, model = s.loaded.mujoco, s.loaded.sharp("autoreset")
    data, draw = lib.MjData(model), partial(np.random.default_rng(1).uniform, -1, 1)

    def stays(dofs: np.ndarray) -> bool:
        """Return whether degrees of freedom (nv,) stay at rest in a random state of all else."""
        lib.mj_resetData(model, data)
        lib.mj_integratePos(model, data.qpos, draw(m.nv), 1.0)
        data.qvel[:] = np.where(dofs, 0, draw(m.nv))
        data.eq_active[:] = 1
        data.ctrl[:], data.act[:] = draw(m.nu), draw(m.na)
        lib.mj_forward(model, data)
        size = np.abs(data.qacc)
        return bool(np.all(size[dofs] <= IDLE * max(1.0, np.max(size))))

    message = "no force, and no motion of anything else, accelerates it from rest"
    for joint, dofs in enumerate(m.dof_jntid == np.arange(m.njnt)[:, None]):
        if not np.any(moves[dofs]) and all(stays(dofs) for _ in range(PROBES)):
            yield s.hit("joint", joint, message)


def contact_unused(s: InspectedModel) -> Iterator[Hit]:
    if s.facts.options.contact and not s.model.nflex and not np.any(s.can_touch):
        message = f"contact is on, and none of {s.facts.counts['geoms']} geoms can touch another"
        yield s.about("option/flag", "option", message=message)


def geom_never_touches(s: InspectedModel) -> Iterator[Hit]:
    meant = np.any(s.can_touch) & ((s.model.geom_contype | s.model.geom_conaffinity) != 0)
    return s.hits(
        "geom", meant & ~s.can_touch, "it is made for contact, and no other geom can touch it"
    )


def contact_leftovers(s: InspectedModel) -> Iterator[Hit]:
    pairs = exclusions(s.loaded)
    names = [" and ".join(s.loaded.name("body", body) for body in pair) for pair in pairs]
    if not s.facts.options.contact:
        message = "contact is off, so that this pair never touches"
        yield from s.hits("pair", np.ones(s.model.npair, bool), message)
        message = "contact is off, so {} need not be excluded"
        yield from (s.hit("exclude", i, message.format(both)) for i, both in enumerate(names))
        return
    possible, bodies = partners(s.loaded, excluded=False), kinds_of_geom(s.loaded)[0][:, 0]
    for i, pair in enumerate(pairs):
        if not np.any(possible[np.ix_(*(bodies == body for body in pair))]):
            yield s.hit("exclude", i, f"{names[i]} could not touch anyway")


def geom_mass(s: InspectedModel) -> Iterator[Hit]:
    for element in s.loaded.source.tagged("geom"):
        body = element.parent
        if body is None or not any(child.tag == "inertial" for child in body.children):
            continue
        for key in ("mass", "density"):
            if key in element.attributes and s.setting("inertiafromgeom") != "true":
                message = (
                    f"its {key} of {element.attributes[key]} does not count: {body.address} has an "
                    "<inertial>"
                )
                yield Hit(element, element.address, message, attribute=key)


def inertia_floor(s: InspectedModel) -> Iterator[Hit]:
    m, said = s.model, dict[tuple[str, int], Hit]()
    rigid = np.bincount(m.body_weldid[m.body_mass > 0], minlength=m.nbody)  # bodies in one piece
    alone = (m.body_weldid != 0) & (m.body_mass > 0) & (rigid[m.body_weldid] == 1)
    least = np.min(m.body_inertia, axis=1)
    inertias = [
        ("body", int(i), "a principal inertia", "kg m^2", float(least[i]))
        for i in np.flatnonzero(alone & (least < (POINT * s.facts.size) ** 2 * m.body_mass))
    ] + [
        ("joint", int(joint), "the moved inertia", "(SI)", float(inertia))
        for view in s.views
        if view.linear
        for joint, inertia in zip(m.dof_jntid, np.diag(view.linear.mass), strict=True)
    ]
    for kind, number, what, unit, inertia in inertias:
        statement = conditions.inertia_floor(
            what, inertia, unit, MuJoCo.min_inertia, "MuJoCo", conditions.NEAR_FLOOR
        )
        if statement is not None:
            said.setdefault((kind, number), s.hit(kind, number, statement.message))
    yield from said.values()


def inertia_raised(s: InspectedModel) -> Iterator[Hit]:
    m = s.model
    settings = ("boundmass", "boundinertia", "balanceinertia", "settotalmass")
    for element in s.loaded.source.tagged("compiler"):
        for key in [key for key in settings[: 4 if s.strict else 3] if key in element.attributes]:
            without = s.loaded.compiled(s.loaded.source.text([(element, key)]))
            if without is None:
                message = (
                    f'without {key}="{element.attributes[key]}" MuJoCo refuses the file: it stands '
                    "for masses or inertias that no body can have"
                )
                yield Hit(element, element.address, message, attribute=key)
                continue
            if without.nbody != m.nbody:
                continue
            changed = np.any(m.body_inertia != without.body_inertia, axis=1)
            changed |= m.body_mass != without.body_mass
            if np.any(changed):
                message = (
                    f'{key}="{element.attributes[key]}" changes masses or inertias of '
                    f"{np.sum(changed)} bodies, {s.loaded.name('body', np.argmax(changed))} the "
                    "first: they are not those of the file"
                )
                yield Hit(element, element.address, message, attribute=key)


def merged_centre(s: InspectedModel) -> Iterator[Hit]:
    offset = np.linalg.norm(s.model.body_ipos, axis=1)
    return s.hits(
        "body",
        s.loaded.of_kind("body_sameframe", "body") & (offset > ROUNDED * s.facts.size),
        lambda i: (
            f"its centre of mass is {offset[i]:.3g} m from its frame, and MuJoCo takes both "
            f"for one place, as all below {MERGED:g} m"
        ),
    )


def huge_armature(s: InspectedModel) -> Iterator[Hit]:
    linear, armature = s.views[0].linear, np.asarray(s.model.dof_armature)
    if linear is None:
        return iter(())
    moved = np.maximum(np.diag(linear.mass) - armature, 0)
    return s.hits(
        "joint",
        (armature > 0) & (armature > HEAVY * moved),
        lambda dof: (
            f"its armature of {armature[dof]:.3g} is {armature[dof] / moved[dof]:.3g} times the "
            f"inertia that it moves, {moved[dof]:.3g}: its motion is that of the rotor alone"
        ),
        of=s.model.dof_jntid,
        attribute="armature",
    )


def negative_damping(s: InspectedModel) -> Iterator[Hit]:
    m, message = s.model, "its damping of {:g} feeds energy"
    parts = (("joint", m.dof_damping, m.dof_jntid), ("tendon", m.tendon_damping, None))
    for kind, damping, of in parts:
        words = partial(lambda values, i: message.format(values[i]), damping)
        yield from s.hits(kind, np.asarray(damping) < 0, words, of, "damping")


LIMITS = {
    "joint": (("range", "jnt_limited"), ("actuatorfrcrange", "jnt_actfrclimited")),
    "tendon": (("range", "tendon_limited"), ("actuatorfrcrange", "tendon_actfrclimited")),
    "actuator": (("forcerange", "actuator_forcelimited"), ("actrange", "actuator_actlimited")),
}
"""Kind -> attribute and the field that tells whether it counts."""


def range_ignored(s: InspectedModel) -> Iterator[Hit]:
    listed = [
        (element, key, field)
        for wanted, fields in LIMITS.items()
        for kind, element in s.loaded.elements
        for key, field in fields
        if kind == wanted and key in element.attributes
    ]
    for element, key, field in listed:
        for number in s.loaded.numbers.get(element, [])[:1]:
            if not getattr(s.model, field)[number]:
                message = f'{key}="{element.attributes[key]}" limits nothing: it is off, or empty'
                yield Hit(element, element.address, message, attribute=key)


def idle_actuator(s: InspectedModel) -> Iterator[Hit]:
    m, kind = s.model, s.loaded.of_kind
    gain = ~kind("actuator_gaintype", "fixed") | (m.actuator_gainprm[:, 0] != 0)
    constant = kind("actuator_biastype", "affine") & ~np.any(m.actuator_biasprm[:, :3], axis=1)
    bias = ~kind("actuator_biastype", "none") & ~constant
    message = "its force is always 0: neither control nor bias reaches what it moves"
    for i, acts in enumerate(gain | bias):
        parts = [value_of(m, f"actuator_{name}", i) for name in ("damping", "armature")]
        if not ((acts and np.any(gears(m, i))) or np.any(parts)):
            yield s.hit("actuator", i, message)


def value_of(model: Any, field: str, number: int) -> Any:
    """Return a value of an object; 0 if this version of MuJoCo does not have it."""
    return getattr(model, field)[number] if hasattr(model, field) else 0


def gears(model: Any, actuator: int) -> Any:
    """Return the gears of all outputs of an actuator."""
    if not hasattr(model, "actuator_outadr"):  # before 4.0 each has one
        return model.actuator_gear[actuator]
    first, count = int(model.actuator_outadr[actuator]), int(model.actuator_outnum[actuator])
    return model.actuator_gear[first : first + count]


def idle_tendon(s: InspectedModel) -> Iterator[Hit]:
    m, joined = s.model, s.loaded.of_kind("eq_type", "tendon")
    sensed = m.sensor_objid[s.loaded.of_kind("sensor_objtype", "tendon")]
    pulled = m.actuator_trnid[s.loaded.of_kind("actuator_trntype", "tendon"), 0]
    used = np.concatenate([sensed, pulled, m.eq_obj1id[joined], m.eq_obj2id[joined]])
    fields = ("stiffness", "damping", "frictionloss", "armature", "limited")
    message = (
        "it has neither stiffness, damping, friction, armature nor limits, and no actuator, "
        "sensor or equality uses it"
    )
    for i in np.setdiff1d(np.arange(m.ntendon), used):
        if not any(np.any(value_of(m, f"tendon_{field}", i)) for field in fields):
            yield s.hit("tendon", i, message)


def duplicate_sensor(s: InspectedModel) -> Iterator[Hit]:
    m = s.model
    names = ("type", "objtype", "objid", "reftype", "refid", "cutoff", "dim", "delay", "interval")
    seen: dict[bytes, int] = {}
    for i in range(m.nsensor):
        values = [np.asarray(value_of(m, f"sensor_{name}", i)) for name in (*names, "intprm")]
        first = seen.setdefault(b"|".join(value.tobytes() for value in values), i)
        if first != i:
            yield s.hit("sensor", i, f"it shows what {s.loaded.name('sensor', first)} shows")


def unused_asset(s: InspectedModel) -> Iterator[Hit]:
    m, kind = s.model, s.loaded.of_kind
    owners = ("geom", "site", "tendon", "skin", "flex")
    named = {element.attributes.get("mesh", "") for element in s.loaded.source.walk()}
    used = {
        "material": [np.ravel(getattr(m, f"{owner}_matid", [])) for owner in owners],
        "mesh": [  # a geom may be fitted to one, a flex made of one
            m.geom_dataid[kind("geom_type", "mesh", "sdf")],
            [i for i in range(m.nmesh) if s.loaded.name("mesh", i) in named],
        ],
        "hfield": [m.geom_dataid[kind("geom_type", "hfield")]],
        "texture": [  # a sky needs no material
            np.ravel(m.mat_texid),
            np.flatnonzero(kind("tex_type", "skybox")),
            m.light_texid,
        ],
    }
    for (name, numbers), count in zip(
        used.items(), (m.nmat, m.nmesh, m.nhfield, m.ntex), strict=True
    ):
        idle = ~np.isin(np.arange(count), np.concatenate(numbers))
        shared = [is_shared(s, name, i) for i in range(count)]
        yield from s.hits(name, idle & ~np.array(shared, bool), f"nothing uses this {name}")


def is_shared(s: InspectedModel, kind: str, number: int) -> bool:
    """Return whether an object stands in an included file, which others may include too."""
    element = s.loaded.places.get((kind, number))
    return element is not None and element.file != s.loaded.source.files[0]


def unused_site(s: InspectedModel) -> Iterator[Hit]:
    words = {
        value
        for element in s.loaded.source.walk()
        for key, value in element.attributes.items()
        if key != "name"
    }
    sites = [s.loaded.places.get(("site", number)) for number in range(s.model.nsite)]
    idle = np.array([site is not None and site.name not in words for site in sites], bool)
    return s.hits("site", idle, "no sensor, tendon, actuator or equality refers to it")


def inactive_equality(s: InspectedModel) -> Iterator[Hit]:
    message = "it is not active, and holds nothing until a program says so"
    return s.hits("equality", s.model.eq_active0 == 0, message)


def switched_off(s: InspectedModel) -> Iterator[Hit]:
    m = s.model
    limits = np.count_nonzero(m.jnt_limited)
    for flag, (count, what) in {
        "equality": (m.neq, "equalities"),
        "limit": (limits + np.count_nonzero(m.tendon_limited), "limits"),
        "spring": (np.count_nonzero([*m.jnt_stiffness, *m.tendon_stiffness]), "springs"),
        "damper": (np.count_nonzero([*m.dof_damping, *m.tendon_damping]), "dampers"),
        "frictionloss": (np.count_nonzero(m.dof_frictionloss), "joints with friction"),
        "actuation": (m.nu, "actuators"),
        "sensor": (m.nsensor, "sensors"),
        "constraint": (m.neq + limits, "equalities and limits"),
    }.items():
        if s.loaded.disabled(flag) and count:
            yield s.about("option/flag", message=f'{flag}="disable" switches off {count} {what}')


def compiler_warning(s: InspectedModel) -> Iterator[Hit]:
    for warning in dict.fromkeys(s.loaded.warnings):
        yield Hit(None, ROOT, f"MuJoCo: {warning}")

"""Rules about the parts of a model: bodies, joints, geoms, actuators, tendons, sensors."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from ....reference.scene import Array
from ...checks.rules import conditions
from ...engines.mujoco.engine import MuJoCo
from ..mujoco.facts import exclusions, kinds_of_geom, partners
from ..mujoco.model import Flags, numbers
from ..mujoco.source import ROOT, Element
from ..subject import Hit, InspectedModel
from ..tuning import EFFORT, THRESHOLDS

INERTIA_UNITS = {
    1e-3: "g m^2", 1e-4: "kg cm^2", 1e-6: "kg mm^2", 1e-7: "g cm^2", 1e-9: "g mm^2",
}  # fmt: skip
"""Other units of inertia, by their size in kg m^2."""

NAMING = ("body", "body1", "body2", "objname", "refname", "target", "subtree1", "subtree2")
"""Attributes that name a body."""


# Bodies against the size of their geoms --------------------------------------------------------


Extent = tuple[int, Array, float, float, bool]
"""Body, and the space of its geoms in its frame: middle (3,) and reach [m], the distance from there
to the farthest point; volume [m^3] of the boxes around the geoms, an upper bound of theirs; True if
the body has an ``<inertial>`` that counts."""


def extents(s: InspectedModel) -> Iterator[Extent]:
    """Yield the extents of moving bodies to which no other body is welded.

    Without contact geoms are drawings, and say nothing about sizes.
    """
    m = s.model
    rigid = np.bincount(m.body_weldid, minlength=m.nbody)
    alone = (m.body_weldid == np.arange(m.nbody)) & (rigid == 1) & (m.body_mass > 0)
    solid = ~s.loaded.of_kind("geom_type", "plane", "hfield") & s.options.contact
    sizes = 2 * m.geom_aabb.reshape(-1, 6)[:, 3:]
    for body in range(1, m.nbody):
        own = np.flatnonzero(solid & (m.geom_bodyid == body))
        if not (alone[body] and len(own)):
            continue
        places, radii = m.geom_pos[own], m.geom_rbound[own]
        middle = (np.min(places - radii[:, None], 0) + np.max(places + radii[:, None], 0)) / 2
        element = s.loaded.places.get(("body", body))
        tags = {child.tag for child in element.children} if element else set[str]()
        reach = float(np.max(np.linalg.norm(places - middle, axis=1) + radii))
        stated = "inertial" in tags and s.setting("inertiafromgeom") != "true"
        yield body, middle, reach, float(np.sum(np.prod(sizes[own], axis=1))), stated


def odd_inertia(s: InspectedModel) -> Iterator[Hit]:
    m = s.model
    for body, _, reach, _, stated in extents(s):
        gyration = float(np.sqrt(np.max(m.body_inertia[body]) / m.body_mass[body]))
        share = gyration / reach
        if not stated or np.min(m.body_inertia[body]) <= conditions.NEAR_FLOOR * MuJoCo.min_inertia:
            continue  # a point, which `inertia_floor` reports
        if not THRESHOLDS.min_gyration < share < THRESHOLDS.max_gyration:
            yield s.hit(
                "body",
                body,
                f"its inertia of {np.max(m.body_inertia[body]):.3g} kg m^2 with a mass of "
                f"{m.body_mass[body]:.4g} kg has a radius of gyration of {gyration:.3g} m, "
                f"{'larger' if share > 1 else 'smaller'} than a body that extends {reach:.3g} m "
                "can have",
                fix=inertia_remedy(s, body, reach, share),
            )


def inertia_remedy(s: InspectedModel, body: int, reach: float, share: float) -> str:
    """Return the inertia to write: converted from a usual unit, or about that of the geoms.

    ``share`` is the radius of gyration as written, relative to the reach [m] of the geoms.
    """
    expected = THRESHOLDS.usual_gyration
    factors = {abs(math.log(share / expected) + math.log(u) / 2): u for u in INERTIA_UNITS}
    factor = factors[min(factors)]
    inertial = next(x for x in s.loaded.places["body", body].children if x.tag == "inertial")
    key = next((name for name in inertial.attributes if name.endswith("inertia")), "")
    if key and 0.5 < share * math.sqrt(factor) / expected < 1 / expected:
        written = inertial.attributes[key]
        values = " ".join(f"{factor * value:.6g}" for value in numbers(written))
        return f'write {key}="{values}", if {shortened(written)} is in {INERTIA_UNITS[factor]}'
    usual = float(s.model.body_mass[body]) * (expected * reach) ** 2
    return f"write about {usual:.2g} kg m^2, or mend the mass or the geoms"


def far_centre(s: InspectedModel) -> Iterator[Hit]:
    for body, middle, reach, _, stated in extents(s):
        off = float(np.linalg.norm(s.model.body_ipos[body] - middle))
        if stated and off > THRESHOLDS.max_centre_offset * reach:
            yield s.hit(
                "body",
                body,
                f"its centre of mass is {off:.3g} m from the middle of its geoms, which extend "
                f"{reach:.3g} m",
            )


def odd_density(s: InspectedModel) -> Iterator[Hit]:
    m = s.model
    for body, _, _, volume, _ in extents(s):
        density = float(m.body_mass[body]) / volume if volume > 0 else 1.0
        if not THRESHOLDS.min_density < density < THRESHOLDS.max_density:
            yield s.hit(
                "body",
                body,
                f"its mass of {m.body_mass[body]:.4g} kg in the box of its geoms is a density of "
                f"{density:.3g} kg/m^3, {'more than osmium' if density > 1e3 else 'less than air'}",
            )


def uneven_masses(s: InspectedModel) -> Iterator[Hit]:
    m = s.model
    rigid = np.zeros(m.nbody)
    np.add.at(rigid, m.body_weldid, m.body_mass)
    for body in range(1, m.nbody):
        above = int(m.body_weldid[m.body_parentid[body]])
        if m.body_weldid[body] != body or above == 0 or rigid[above] == 0:
            continue
        ratio = float(m.body_subtreemass[body] / rigid[above])
        inertia = float(np.max(m.dof_armature[m.dof_bodyid == above], initial=0.0))
        if ratio > THRESHOLDS.max_carried_mass and inertia == 0:
            yield s.hit(
                "body",
                body,
                f"with its descendants it weighs {ratio:.3g} times as much as the body that "
                f"carries it, {s.loaded.name('body', above)}, whose joints have no armature",
            )


def overlapping(s: InspectedModel, always: bool) -> Iterator[Hit]:
    """Yield the pairs of geoms of one mechanism that overlap always, or sometimes."""
    for pair, count in sorted(s.meetings.items()):
        if (count == EFFORT.draws) == always:
            names = " and ".join(s.loaded.name("geom", geom) for geom in pair)
            yield s.hit(
                "geom",
                pair[0],
                f"{names} overlap in {'all' if always else count} of {EFFORT.draws} random "
                f"positions within the ranges of the joints"
                f"{': the contact never ends' if always else ''}",
            )


# Parts ----------------------------------------------------------------------------------------


def welded_body(s: InspectedModel) -> Iterator[Hit]:
    m = s.model
    return s.hits(
        "body",
        leaves(s) & ~empty(s) & (m.body_weldid != 0) & (m.body_jntnum == 0),
        lambda i: (
            f"it has no joint and no child: its {m.body_mass[i]:.4g} kg are a part of "
            f"{s.loaded.name('body', m.body_parentid[i])}"
        ),
    )


def empty_body(s: InspectedModel) -> Iterator[Hit]:
    return s.hits("body", leaves(s) & empty(s), "it has no mass, no geom, no site and no child")


def leaves(s: InspectedModel) -> Flags:
    """Return the bodies (nbody,) without children that no other element names."""
    m, elements = s.model, s.loaded.source.root.walk()
    words = {element.attributes.get(key, "") for element in elements for key in NAMING}
    named = words.union(*(word.split() for word in words))
    unnamed = np.array([i and s.loaded.name("body", i) not in named for i in range(m.nbody)], bool)
    return unnamed & (m.body_mocapid < 0) & ~np.isin(np.arange(m.nbody), m.body_parentid)


def empty(s: InspectedModel) -> Flags:
    """Return the bodies (nbody,) that have neither mass nor parts."""
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
        lambda i: f"equality {s.loaded.name('equality', i)} fixes it at one position",
        of=m.eq_obj1id,
    )
    width, simple = np.diff(m.jnt_range)[:, 0], s.loaded.of_kind("jnt_type", "slide", "hinge")
    yield from s.hits(
        "joint",
        (m.jnt_limited != 0) & simple & (width < THRESHOLDS.locked_range),
        lambda i: f"its range is only {width[i]:.2g} wide, and fixes it",
    )


def idle_joint(s: InspectedModel) -> Iterator[Hit]:
    m = s.model
    if not m.nv or m.nv > EFFORT.max_idle_dofs or m.nflex:
        return
    trees = m.body_treeid[m.geom_bodyid[s.can_touch]]
    moves = np.isin(m.dof_treeid, trees) | np.any([one.velocity for one in s.loaded.states], axis=0)
    lib, model = s.loaded.mujoco, s.loaded.sharp("autoreset")
    data, draw = lib.MjData(model), partial(np.random.default_rng(1).uniform, -1, 1)

    def stays(dofs: np.ndarray) -> bool:
        """Return True if degrees of freedom (nv,) stay at rest in a random state of all others."""
        lib.mj_resetData(model, data)
        lib.mj_integratePos(model, data.qpos, draw(m.nv), 1.0)
        data.qvel[:] = np.where(dofs, 0, draw(m.nv))
        data.eq_active[:] = 1
        data.ctrl[:], data.act[:] = draw(m.nu), draw(m.na)
        lib.mj_forward(model, data)
        size = np.abs(data.qacc)
        return bool(np.all(size[dofs] <= THRESHOLDS.idle_acceleration * max(1.0, np.max(size))))

    message = "no force, and no motion of other joints, accelerates it from rest"
    for joint, dofs in enumerate(m.dof_jntid == np.arange(m.njnt)[:, None]):
        if not np.any(moves[dofs]) and all(stays(dofs) for _ in range(EFFORT.idle_draws)):
            yield s.hit("joint", joint, message)


def contact_unused(s: InspectedModel) -> Iterator[Hit]:
    if s.options.contact and not s.model.nflex and not np.any(s.can_touch):
        message = f"contact is on, and none of {s.counts['geoms']} geoms can touch another"
        yield s.about("option/flag", "option", message=message)


def geom_never_touches(s: InspectedModel) -> Iterator[Hit]:
    meant = np.any(s.can_touch) & ((s.model.geom_contype | s.model.geom_conaffinity) != 0)
    return s.hits(
        "geom",
        meant & ~s.can_touch,
        "its contact bits allow contact, but no other geom can touch it",
    )


def contact_leftovers(s: InspectedModel) -> Iterator[Hit]:
    pairs = exclusions(s.loaded)
    names = [" and ".join(s.loaded.name("body", body) for body in pair) for pair in pairs]
    if not s.options.contact:
        message = "contact is off: this pair never touches"
        yield from s.hits("pair", np.ones(s.model.npair, bool), message)
        message = "contact is off: {} need not be excluded"
        yield from (s.hit("exclude", i, message.format(both)) for i, both in enumerate(names))
        return
    possible, bodies = partners(s.loaded, excluded=False), kinds_of_geom(s.loaded)[0][:, 0]
    for i, pair in enumerate(pairs):
        if not np.any(possible[np.ix_(*(bodies == body for body in pair))]):
            yield s.hit("exclude", i, f"{names[i]} could not touch in any case")


def geom_mass(s: InspectedModel) -> Iterator[Hit]:
    for element in s.loaded.source.tagged("geom"):
        body = element.parent
        if body is None or not any(child.tag == "inertial" for child in body.children):
            continue
        for key in ("mass", "density"):
            if key in element.attributes and s.setting("inertiafromgeom") != "true":
                words = f"does not count: {body.address} has an <inertial>"
                yield about_attribute(element, key, words)


def inertia_floor(s: InspectedModel) -> Iterator[Hit]:
    m, said = s.model, dict[tuple[str, int], Hit]()
    rigid = np.bincount(m.body_weldid[m.body_mass > 0], minlength=m.nbody)  # bodies in one piece
    alone = (m.body_weldid != 0) & (m.body_mass > 0) & (rigid[m.body_weldid] == 1)
    least = np.min(m.body_inertia, axis=1)
    inertias = [
        ("body", int(i), "a principal inertia", "kg m^2", float(least[i]))
        for i in np.flatnonzero(
            alone & (least < (THRESHOLDS.point_gyration * s.size) ** 2 * m.body_mass)
        )
    ] + [
        ("joint", int(joint), "the moved inertia", "(SI)", float(inertia))
        for _, linear in s.linear_views
        for joint, inertia in zip(m.dof_jntid, np.diag(linear.mass), strict=True)
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
                yield about_attribute(
                    element, key, "hides masses or inertias without which MuJoCo refuses the file"
                )
            elif without.nbody == m.nbody:
                changed = np.any(m.body_inertia != without.body_inertia, axis=1)
                changed |= m.body_mass != without.body_mass
                first = s.loaded.name("body", np.argmax(changed))
                words = f"changes masses or inertias of {np.sum(changed)} bodies, first {first}"
                if np.any(changed):
                    yield about_attribute(element, key, words)


def merged_centre(s: InspectedModel) -> Iterator[Hit]:
    offset = np.linalg.norm(s.model.body_ipos, axis=1)
    return s.hits(
        "body",
        s.loaded.of_kind("body_sameframe", "body") & (offset > THRESHOLDS.centre_roundoff * s.size),
        lambda i: (
            f"its centre of mass is {offset[i]:.3g} m from its frame, and MuJoCo moves it there, "
            f"as all below {THRESHOLDS.merged_centre:g} m"
        ),
    )


def huge_armature(s: InspectedModel) -> Iterator[Hit]:
    linear, armature = s.views[0].linear, np.asarray(s.model.dof_armature)
    if linear is None:
        return iter(())
    moved = np.maximum(np.diag(linear.mass) - armature, 0)
    return s.hits(
        "joint",
        (armature > 0) & (armature > THRESHOLDS.max_armature * moved),
        lambda dof: (
            f"its armature of {armature[dof]:.3g} is {armature[dof] / moved[dof]:.3g} times the "
            f"inertia that it moves, {moved[dof]:.3g}: the rotor alone sets its motion"
        ),
        of=s.model.dof_jntid,
        attribute="armature",
    )


def negative_damping(s: InspectedModel) -> Iterator[Hit]:
    m, message = s.model, "its damping of {:g} adds energy"
    parts = (("joint", m.dof_damping, m.dof_jntid), ("tendon", m.tendon_damping, None))
    for kind, damping, of in parts:
        words = partial(lambda values, i: message.format(values[i]), damping)
        yield from s.hits(kind, np.asarray(damping) < 0, words, of, "damping")


def about_attribute(element: Element, key: str, reason: str) -> Hit:
    """Return the finding of an attribute that has no effect, or a wrong one."""
    text = shortened(element.attributes[key])
    return Hit(element, element.address, f'{key}="{text}" {reason}', attribute=key)


def shortened(text: str, most: int = 40) -> str:
    """Return the beginning of a text."""
    return text if len(text) <= most else f"{text[:most]}..."


LIMITS = {
    "joint": (("range", "jnt_limited"), ("actuatorfrcrange", "jnt_actfrclimited")),
    "tendon": (("range", "tendon_limited"), ("actuatorfrcrange", "tendon_actfrclimited")),
    "actuator": (("forcerange", "actuator_forcelimited"), ("actrange", "actuator_actlimited")),
}
"""Kind -> attribute, and the field of flags for those with effect."""


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
                yield about_attribute(element, key, "limits nothing: it is off, or empty")


def idle_actuator(s: InspectedModel) -> Iterator[Hit]:
    m, kind = s.model, s.loaded.of_kind
    gain = ~kind("actuator_gaintype", "fixed") | (m.actuator_gainprm[:, 0] != 0)
    constant = kind("actuator_biastype", "affine") & ~np.any(m.actuator_biasprm[:, :3], axis=1)
    bias = ~kind("actuator_biastype", "none") & ~constant
    message = "its force is always 0: it has neither gain nor bias, or no gear"
    for i, acts in enumerate(gain | bias):
        parts = [value_of(m, f"actuator_{name}", i) for name in ("damping", "armature")]
        if not ((acts and np.any(gears(m, i))) or np.any(parts)):
            yield s.hit("actuator", i, message)


def value_of(model: Any, field: str, number: int) -> Any:
    """Return a value of an object; 0 if this release of MuJoCo lacks it."""
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
            yield s.hit("sensor", i, f"it measures the same as {s.loaded.name('sensor', first)}")


def unused_asset(s: InspectedModel) -> Iterator[Hit]:
    m, kind = s.model, s.loaded.of_kind
    owners = ("geom", "site", "tendon", "skin", "flex")
    named = {element.attributes.get("mesh", "") for element in s.loaded.source.root.walk()}
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
    for (name, ids), count in zip(used.items(), (m.nmat, m.nmesh, m.nhfield, m.ntex), strict=True):
        idle = ~np.isin(np.arange(count), np.concatenate(ids))
        elements = [s.loaded.places.get((name, i)) for i in range(count)]
        shared = [one is not None and one.file != s.files[0] for one in elements]  # with others
        yield from s.hits(name, idle & ~np.array(shared, bool), f"nothing uses this {name}")


def unused_site(s: InspectedModel) -> Iterator[Hit]:
    words = {
        value
        for element in s.loaded.source.root.walk()
        for key, value in element.attributes.items()
        if key != "name"
    }
    sites = [s.loaded.places.get(("site", number)) for number in range(s.model.nsite)]
    idle = np.array([site is not None and site.name not in words for site in sites], bool)
    return s.hits("site", idle, "no sensor, tendon, actuator or equality refers to it")


def inactive_equality(s: InspectedModel) -> Iterator[Hit]:
    message = "it has no effect until a program activates it"
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

"""Rules about what a model consists of: bodies, joints, geoms, actuators, tendons, sensors."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from ..mujoco.source import ROOT
from ..subject import Hit, Subject
from .contact import exclusions, kinds_of_geom, partners

FLOOR = 1e-13
"""Inertia [kg m^2] below which it only stands for 0: 100 times what MuJoCo refuses."""

MERGED = 1e-6
"""Distance [m] below which MuJoCo takes a centre of mass for its body's frame."""

ROUNDED = 1e-12
"""Share of the model's size by which rounding may move a centre of mass."""

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


def welded_body(s: Subject) -> Iterator[Hit]:
    """A body without joint at the end of a branch."""
    m = s.loaded.model
    for number in leaves(s):
        if m.body_weldid[number] and not m.body_jntnum[number] and not nothing_in(s, number):
            parent = s.loaded.name("body", m.body_parentid[number])
            message = (
                f"it has no joint and no child: it is a part of {parent}, of "
                f"{m.body_mass[number]:.4g} kg"
            )
            yield s.hit("body", number, message)


def empty_body(s: Subject) -> Iterator[Hit]:
    """A body that holds nothing."""
    for number in filter(lambda number: nothing_in(s, number), leaves(s)):
        yield s.hit("body", number, "it has no mass, no geom, no site and no child")


def leaves(s: Subject) -> list[int]:
    """Return the bodies without children, which nothing else of the file names."""
    m, elements = s.loaded.model, s.loaded.source.walk()
    words = {element.attributes.get(key, "") for element in elements for key in NAMING}
    named = words.union(*(word.split() for word in words))
    last = (m.body_mocapid < 0) & ~np.isin(np.arange(m.nbody), m.body_parentid)
    return [int(i) for i in np.flatnonzero(last) if i and s.loaded.name("body", i) not in named]


def nothing_in(s: Subject, number: int) -> bool:
    """Return whether a body has neither mass nor parts."""
    m = s.loaded.model
    owners = (m.jnt_bodyid, m.geom_bodyid, m.site_bodyid, m.cam_bodyid, m.light_bodyid)
    return not (m.nflex or m.body_mass[number] or any(np.any(one == number) for one in owners))


def locked_joint(s: Subject) -> Iterator[Hit]:
    """A joint that is held where it is."""
    lib, m = s.loaded.mujoco, s.loaded.model
    locks = (m.eq_type == int(lib.mjtEq.mjEQ_JOINT)) & (m.eq_obj2id < 0) & (m.eq_active0 != 0)
    for i in np.flatnonzero(locks & (not s.loaded.disabled("equality"))):
        message = f"equality {s.loaded.name('equality', i)} holds it at one place"
        yield s.hit("joint", m.eq_obj1id[i], message)
    width = np.diff(m.jnt_range, axis=1)[:, 0]
    simple = (m.jnt_limited != 0) & s.loaded.joints("slide", "hinge")
    for i in np.flatnonzero(simple & (width < NARROW)):
        yield s.hit("joint", i, f"its range is {width[i]:.2g} wide, and holds it")


def idle_joint(s: Subject) -> Iterator[Hit]:
    """A joint that nothing moves."""
    m = s.loaded.model
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

    for joint in range(m.njnt):
        dofs = m.dof_jntid == joint
        if not np.any(moves[dofs]) and all(stays(dofs) for _ in range(PROBES)):
            message = "no force, and no motion of anything else, accelerates it from rest"
            yield s.hit("joint", joint, message)


def contact_unused(s: Subject) -> Iterator[Hit]:
    """Contact is on, and nothing can touch."""
    if s.facts.options.contact and not s.loaded.model.nflex and not np.any(s.can_touch):
        message = f"contact is on, and none of {s.facts.counts['geoms']} geoms can touch another"
        yield s.about("option/flag", "option", message=message)


def geom_never_touches(s: Subject) -> Iterator[Hit]:
    """A geom for contact without a partner."""
    m = s.loaded.model
    meant = np.any(s.can_touch) & ((m.geom_contype | m.geom_conaffinity) != 0)
    for i in np.flatnonzero(meant & ~s.can_touch):
        yield s.hit("geom", i, "it is made for contact, and no other geom can touch it")


def contact_leftovers(s: Subject) -> Iterator[Hit]:
    """Pairs and exclusions without effect."""
    on, bodies = s.facts.options.contact, kinds_of_geom(s.loaded)[0][:, 0]
    for i in range(0 if on else s.loaded.model.npair):
        yield s.hit("pair", i, "contact is off, so that this pair never touches")
    possible = partners(s.loaded, excluded=False)
    for i, pair in enumerate(exclusions(s.loaded)):
        names = " and ".join(s.loaded.name("body", body) for body in pair)
        if not on:
            yield s.hit("exclude", i, f"contact is off, so {names} need not be excluded")
        elif not np.any(possible[np.ix_(*(bodies == body for body in pair))]):
            yield s.hit("exclude", i, f"{names} could not touch anyway")


def geom_mass(s: Subject) -> Iterator[Hit]:
    """Mass of a geom beside an explicit inertial."""
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


def inertia_floor(s: Subject) -> Iterator[Hit]:
    """Inertia that only stands for 0."""
    m = s.loaded.model
    least = np.min(m.body_inertia, axis=1)
    for number in np.flatnonzero((m.body_weldid != 0) & (m.body_mass > 0) & (least < FLOOR)):
        message = (
            f"a principal inertia of {least[number]:.3g} kg m^2 is next to what MuJoCo refuses, "
            "1e-15"
        )
        yield s.hit("body", number, message)
    small: dict[int, float] = {}
    for view in s.views:
        diagonal = np.diag(view.linear.mass) if view.linear else np.zeros(0)
        for dof in np.flatnonzero(diagonal < FLOOR):
            small.setdefault(int(m.dof_jntid[dof]), float(diagonal[dof]))
    for joint, inertia in small.items():
        yield s.hit("joint", joint, f"it moves an inertia of {inertia:.3g} only")


def inertia_raised(s: Subject) -> Iterator[Hit]:
    """The compiler changes masses and inertias."""
    m = s.loaded.model
    for element in s.loaded.source.tagged("compiler"):
        for key in ("boundmass", "boundinertia", "balanceinertia", "settotalmass"):
            if key not in element.attributes:
                continue
            without = s.loaded.compiled(s.loaded.source.text([(element, key)]))
            if without is None or without.nbody != m.nbody:
                continue
            changed = np.any(m.body_inertia != without.body_inertia, axis=1)
            changed |= m.body_mass != without.body_mass
            if np.any(changed):
                first = s.loaded.name("body", np.argmax(changed))
                message = (
                    f'{key}="{element.attributes[key]}" changes masses or inertias of '
                    f"{np.sum(changed)} bodies, {first} the first: they are not those of the file"
                )
                yield Hit(element, element.address, message, attribute=key)


def merged_centre(s: Subject) -> Iterator[Hit]:
    """A centre of mass that MuJoCo moves."""
    lib, m = s.loaded.mujoco, s.loaded.model
    offset = np.linalg.norm(m.body_ipos, axis=1)
    same = m.body_sameframe == int(lib.mjtSameFrame.mjSAMEFRAME_BODY)
    for number in np.flatnonzero(same & (offset > ROUNDED * s.facts.size)):
        message = (
            f"its centre of mass is {offset[number]:.3g} m from its frame, and MuJoCo takes both "
            f"for one place, as all below {MERGED:g} m"
        )
        yield s.hit("body", number, message)


def huge_armature(s: Subject) -> Iterator[Hit]:
    """An armature that drowns the mechanism."""
    m = s.loaded.model
    linear = s.views[0].linear
    inertia = np.diag(linear.mass) if linear else np.zeros(m.nv)
    for dof in np.flatnonzero((np.asarray(m.dof_armature) > 0) & (linear is not None)):
        armature = float(m.dof_armature[dof])
        moved = max(float(inertia[dof]) - armature, 0.0)
        if armature > HEAVY * moved:
            message = (
                f"its armature of {armature:.3g} hides what it moves, {moved:.3g}: forces on it "
                "do next to nothing"
            )
            yield s.hit("joint", m.dof_jntid[dof], message, attribute="armature")


def negative_damping(s: Subject) -> Iterator[Hit]:
    """A damper that feeds energy."""
    m = s.loaded.model
    dampers = [("joint", i, m.dof_damping[dof]) for dof, i in enumerate(m.dof_jntid)]
    dampers += [("tendon", i, damping) for i, damping in enumerate(m.tendon_damping)]
    for kind, number, damping in dampers:
        if damping < 0:
            message = f"its damping of {damping:g} feeds energy"
            yield s.hit(kind, number, message, attribute="damping")


LIMITS = {
    "joint": (("range", "jnt_limited"), ("actuatorfrcrange", "jnt_actfrclimited")),
    "tendon": (("range", "tendon_limited"), ("actuatorfrcrange", "tendon_actfrclimited")),
    "actuator": (("forcerange", "actuator_forcelimited"), ("actrange", "actuator_actlimited")),
}
"""Kind -> attribute and the field that tells whether it counts."""


def range_ignored(s: Subject) -> Iterator[Hit]:
    """A range that does not limit."""
    listed = [
        (element, key, field)
        for wanted, fields in LIMITS.items()
        for kind, element in s.loaded.elements
        for key, field in fields
        if kind == wanted and key in element.attributes
    ]
    for element, key, field in listed:
        for number in s.loaded.numbers.get(element, [])[:1]:
            if not getattr(s.loaded.model, field)[number]:
                message = f'{key}="{element.attributes[key]}" limits nothing: it is off, or empty'
                yield Hit(element, element.address, message, attribute=key)


def idle_actuator(s: Subject) -> Iterator[Hit]:
    """An actuator whose force is always 0."""
    lib, m = s.loaded.mujoco, s.loaded.model
    fixed, affine = int(lib.mjtGain.mjGAIN_FIXED), int(lib.mjtBias.mjBIAS_AFFINE)
    none = int(lib.mjtBias.mjBIAS_NONE)
    for i, kind in enumerate(m.actuator_biastype):
        gain = m.actuator_gaintype[i] != fixed or m.actuator_gainprm[i, 0]
        bias = kind != none and (kind != affine or np.any(m.actuator_biasprm[i, :3]))
        parts = [value_of(m, f"actuator_{name}", i) for name in ("damping", "armature")]
        if (not (gain or bias) or not np.any(gears(m, i))) and not np.any(parts):
            message = "its force is always 0: neither control nor bias reaches what it moves"
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


def idle_tendon(s: Subject) -> Iterator[Hit]:
    """A tendon that does nothing."""
    lib, m = s.loaded.mujoco, s.loaded.model
    sensed = m.sensor_objid[m.sensor_objtype == int(lib.mjtObj.mjOBJ_TENDON)]
    pulled = m.actuator_trnid[m.actuator_trntype == int(lib.mjtTrn.mjTRN_TENDON), 0]
    joined = m.eq_type == int(lib.mjtEq.mjEQ_TENDON)
    used = np.concatenate([sensed, pulled, m.eq_obj1id[joined], m.eq_obj2id[joined]])
    fields = ("stiffness", "damping", "frictionloss", "armature", "limited")
    for i in sorted({*range(m.ntendon)}.difference(used.tolist())):
        if not any(np.any(value_of(m, f"tendon_{field}", i)) for field in fields):
            message = (
                "it has neither stiffness, damping, friction, armature nor limits, and no "
                "actuator, sensor or equality uses it"
            )
            yield s.hit("tendon", i, message)


def duplicate_sensor(s: Subject) -> Iterator[Hit]:
    """Two sensors of the same."""
    m = s.loaded.model
    names = ("type", "objtype", "objid", "reftype", "refid", "cutoff", "dim", "delay", "interval")
    seen: dict[bytes, int] = {}
    for i in range(m.nsensor):
        values = [np.asarray(value_of(m, f"sensor_{name}", i)) for name in (*names, "intprm")]
        first = seen.setdefault(b"|".join(value.tobytes() for value in values), i)
        if first != i:
            yield s.hit("sensor", i, f"it shows what {s.loaded.name('sensor', first)} shows")


def unused_asset(s: Subject) -> Iterator[Hit]:
    """An asset that nothing shows."""
    lib, m = s.loaded.mujoco, s.loaded.model
    owners = ("geom", "site", "tendon", "skin", "flex")
    named = {element.attributes.get("mesh", "") for element in s.loaded.source.walk()}
    meshed = np.isin(m.geom_type, [int(lib.mjtGeom.mjGEOM_MESH), int(lib.mjtGeom.mjGEOM_SDF)])
    skies = np.flatnonzero(m.tex_type == int(lib.mjtTexture.mjTEXTURE_SKYBOX))
    used = {
        "material": [np.ravel(getattr(m, f"{owner}_matid", [])) for owner in owners],
        "mesh": [  # a geom may be fitted to one, a flex made of one
            m.geom_dataid[meshed],
            [i for i in range(m.nmesh) if s.loaded.name("mesh", i) in named],
        ],
        "hfield": [m.geom_dataid[m.geom_type == int(lib.mjtGeom.mjGEOM_HFIELD)]],
        "texture": [np.ravel(m.mat_texid), skies, m.light_texid],  # skies need no material
    }
    counts = {"material": m.nmat, "mesh": m.nmesh, "hfield": m.nhfield, "texture": m.ntex}
    for kind, numbers in used.items():
        for i in np.setdiff1d(np.arange(counts[kind]), np.concatenate(numbers)):
            yield s.hit(kind, i, f"nothing uses this {kind}")


def unused_site(s: Subject) -> Iterator[Hit]:
    """A site that nothing refers to."""
    words = {
        value
        for element in s.loaded.source.walk()
        for key, value in element.attributes.items()
        if key != "name"
    }
    for number in range(s.loaded.model.nsite):
        element = s.loaded.places.get(("site", number))
        if element is not None and (element.name is None or element.name not in words):
            yield s.hit("site", number, "no sensor, tendon, actuator or equality refers to it")


def inactive_equality(s: Subject) -> Iterator[Hit]:
    """An equality that is off."""
    for i in np.flatnonzero(np.asarray(s.loaded.model.eq_active0) == 0):
        yield s.hit("equality", i, "it is not active, and holds nothing until a program says so")


def switched_off(s: Subject) -> Iterator[Hit]:
    """A flag switches off what the model has."""
    m = s.loaded.model
    limits = np.count_nonzero(m.jnt_limited)
    parts = {
        "equality": (m.neq, "equalities"),
        "limit": (limits + np.count_nonzero(m.tendon_limited), "limits"),
        "spring": (np.count_nonzero([*m.jnt_stiffness, *m.tendon_stiffness]), "springs"),
        "damper": (np.count_nonzero([*m.dof_damping, *m.tendon_damping]), "dampers"),
        "frictionloss": (np.count_nonzero(m.dof_frictionloss), "joints with friction"),
        "actuation": (m.nu, "actuators"),
        "sensor": (m.nsensor, "sensors"),
        "constraint": (m.neq + limits, "equalities and limits"),
    }
    for flag, (count, what) in parts.items():
        if s.loaded.disabled(flag) and count:
            message = f'{flag}="disable" switches off {count} {what}'
            yield s.about("option/flag", message=message)


def compiler_warning(s: Subject) -> Iterator[Hit]:
    """What MuJoCo itself warns of."""
    for warning in dict.fromkeys(s.loaded.warnings):
        yield Hit(None, ROOT, f"MuJoCo: {warning}")

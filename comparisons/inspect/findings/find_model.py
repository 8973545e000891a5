"""Rules about what a model consists of: bodies, joints, geoms, actuators, tendons, sensors."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..subject import Hit, Subject
from .contact import kinds_of_geom, partners

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


def welded_body(s: Subject) -> Iterator[Hit]:
    """A body without joint at the end of a branch."""
    for number in leaves(s):
        m = s.loaded.model
        moving = m.body_weldid[number] != 0
        if moving and not m.body_jntnum[number] and not nothing_in(s, number):
            message = (
                f"it has no joint and no child: it is a part of {parent_name(s, number)}, of "
                f"{m.body_mass[number]:.4g} kg"
            )
            yield s.hit("body", number, message)


def empty_body(s: Subject) -> Iterator[Hit]:
    """A body that holds nothing."""
    for number in leaves(s):
        if nothing_in(s, number):
            yield s.hit("body", number, "it has no mass, no geom, no site and no child")


def leaves(s: Subject) -> list[int]:
    """Return the bodies without children, which nothing else of the file names."""
    m = s.loaded.model
    parents = set(np.asarray(m.body_parentid[1:]).tolist())
    called = named_elsewhere(s)
    return [
        number
        for number in range(1, m.nbody)
        if number not in parents
        and m.body_mocapid[number] < 0
        and s.loaded.name("body", number) not in called
    ]


NAMING = ("body", "body1", "body2", "objname", "refname", "target", "subtree1", "subtree2")
"""Attributes that name a body."""


def named_elsewhere(s: Subject) -> set[str]:
    """Return all names that stand in attributes which name bodies."""
    words = (
        element.attributes.get(key, "") for element in s.loaded.source.walk() for key in NAMING
    )
    return {name for word in words for name in (word, *word.split())}


def nothing_in(s: Subject, number: int) -> bool:
    """Return whether a body has neither mass nor parts."""
    m = s.loaded.model
    owners = (m.geom_bodyid, m.site_bodyid, m.cam_bodyid, m.light_bodyid)
    return (
        not m.body_mass[number]
        and not m.body_jntnum[number]
        and not any(np.any(owner == number) for owner in owners)
        and not m.nflex
    )


def parent_name(s: Subject, number: int) -> str:
    """Return the name of a body's parent."""
    return s.loaded.name("body", int(s.loaded.model.body_parentid[number]))


def locked_joint(s: Subject) -> Iterator[Hit]:
    """A joint that is held where it is."""
    lib, m = s.loaded.mujoco, s.loaded.model
    for i in np.flatnonzero(m.eq_type == int(lib.mjtEq.mjEQ_JOINT)):
        if m.eq_obj2id[i] < 0 and m.eq_active0[i] and not s.loaded.disabled("equality"):
            joint = int(m.eq_obj1id[i])
            message = f"equality {s.loaded.name('equality', int(i))} holds it at one place"
            yield s.hit("joint", joint, message)
    for i in np.flatnonzero(m.jnt_limited):
        low, high = map(float, m.jnt_range[i])
        simple = m.jnt_type[i] >= int(lib.mjtJoint.mjJNT_SLIDE)
        if simple and high - low < NARROW:
            yield s.hit("joint", int(i), f"its range is {high - low:.2g} wide, and holds it")


def idle_joint(s: Subject) -> Iterator[Hit]:
    """A joint that nothing moves."""
    lib, m = s.loaded.mujoco, s.loaded.model
    if not m.nv or m.nv > MOST_DOFS or m.nflex:
        return
    model = s.loaded.sharp("autoreset")
    data = lib.MjData(model)
    generator = np.random.default_rng(1)
    ever = np.zeros(m.nv, dtype=bool)
    for state in s.loaded.states:
        ever |= state.velocity != 0
    ever[np.isin(m.dof_treeid, m.body_treeid[m.geom_bodyid[s.touching]])] = True
    for joint in range(m.njnt):
        first = int(m.jnt_dofadr[joint])
        count = int(np.sum(m.dof_jntid == joint))
        own = slice(first, first + count)
        if np.any(ever[own]):
            continue
        for _ in range(PROBES):
            lib.mj_resetData(model, data)
            lib.mj_integratePos(model, data.qpos, generator.uniform(-1, 1, m.nv), 1.0)
            data.qvel[:] = generator.uniform(-1, 1, m.nv)
            data.qvel[own] = 0
            data.eq_active[:] = 1
            data.ctrl[:] = generator.uniform(-1, 1, m.nu)
            data.act[:] = generator.uniform(-1, 1, m.na)
            lib.mj_forward(model, data)
            if not np.all(np.abs(data.qacc[own]) <= IDLE * max(1.0, np.max(np.abs(data.qacc)))):
                break
        else:
            message = "no force, and no motion of anything else, accelerates it from rest"
            yield s.hit("joint", joint, message)


def contact_unused(s: Subject) -> Iterator[Hit]:
    """Contact is on, and nothing can touch."""
    if s.facts.options.contact and not s.loaded.model.nflex and not np.any(s.touching):
        count = s.facts.counts["geoms"]
        yield s.about(
            "option/flag",
            "option",
            message=f"contact is on, and none of {count} geoms can touch another",
        )


def geom_never_touches(s: Subject) -> Iterator[Hit]:
    """A geom for contact without a partner."""
    m, can = s.loaded.model, s.touching
    if not np.any(can):
        return
    for i in np.flatnonzero(~can & ((m.geom_contype | m.geom_conaffinity) != 0)):
        yield s.hit("geom", int(i), "it is made for contact, and no other geom can touch it")


def contact_leftovers(s: Subject) -> Iterator[Hit]:
    """Pairs and exclusions without effect."""
    m = s.loaded.model
    kinds = kinds_of_geom(s.loaded)[0]
    possible = partners(s.loaded, excluded=False) if s.facts.options.contact else None
    for i in range(m.npair if possible is None else 0):
        yield s.hit("pair", i, "contact is off, so that this pair never touches")
    for i, signature in enumerate(np.asarray(m.exclude_signature)):
        one, other = int(signature) >> 16, int(signature) & 0xFFFF
        names = f"{s.loaded.name('body', one)} and {s.loaded.name('body', other)}"
        if possible is None:
            yield s.hit("exclude", i, f"contact is off, so {names} need not be excluded")
        elif not np.any(possible[np.ix_(kinds[:, 0] == one, kinds[:, 0] == other)]):
            yield s.hit("exclude", i, f"{names} could not touch anyway")


def geom_mass(s: Subject) -> Iterator[Hit]:
    """Mass of a geom beside an explicit inertial."""
    for element in s.loaded.source.tagged("geom"):
        body = element.parent
        if body is None or not any(child.tag == "inertial" for child in body.children):
            continue
        if setting(s, "inertiafromgeom") == "true":
            continue
        for key in ("mass", "density"):
            if key in element.attributes:
                message = (
                    f"its {key} of {element.attributes[key]} does not count: {body.address} has an "
                    "<inertial>"
                )
                yield Hit(element, element.address, message, attribute=key)


def setting(s: Subject, key: str) -> str:
    """Return an attribute of the compiler's, the last that stands in the file."""
    found = [e.attributes[key] for e in s.loaded.source.tagged("compiler") if key in e.attributes]
    return found[-1] if found else ""


def inertia_floor(s: Subject) -> Iterator[Hit]:
    """Inertia that only stands for 0."""
    m = s.loaded.model
    for number in np.flatnonzero((m.body_weldid != 0) & (m.body_mass > 0)):
        least = float(np.min(m.body_inertia[number]))
        if least < FLOOR:
            message = (
                f"a principal inertia of {least:.3g} kg m^2 is next to what MuJoCo refuses, 1e-15"
            )
            yield s.hit("body", int(number), message)
    seen = set()
    for view in s.views:
        if view.linear is None:
            continue
        for dof in np.flatnonzero(np.diag(view.linear.mass) < FLOOR):
            joint = int(m.dof_jntid[dof])
            if joint not in seen:
                seen.add(joint)
                found = float(view.linear.mass[dof, dof])
                yield s.hit("joint", joint, f"it moves an inertia of {found:.3g} only")


def inertia_raised(s: Subject) -> Iterator[Hit]:
    """The compiler changes masses and inertias."""
    for element in s.loaded.source.tagged("compiler"):
        for key in ("boundmass", "boundinertia", "balanceinertia", "settotalmass"):
            if key not in element.attributes:
                continue
            without = s.loaded.compiled(s.loaded.source.text([(element, key)]))
            if without is None or without.nbody != s.loaded.model.nbody:
                continue
            m = s.loaded.model
            changed = (m.body_mass != without.body_mass) | np.any(
                m.body_inertia != without.body_inertia, axis=1
            )
            if np.any(changed):
                first = s.loaded.name("body", int(np.flatnonzero(changed)[0]))
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
        yield s.hit("body", int(number), message)


def huge_armature(s: Subject) -> Iterator[Hit]:
    """An armature that drowns the mechanism."""
    m = s.loaded.model
    linear = s.views[0].linear if s.views else None
    if linear is None:
        return
    for dof in np.flatnonzero(np.asarray(m.dof_armature) > 0):
        armature, whole = float(m.dof_armature[dof]), float(linear.mass[dof, dof])
        moved = max(whole - armature, 0.0)
        if armature > HEAVY * moved:
            message = (
                f"its armature of {armature:.3g} hides what it moves, {moved:.3g}: forces on it "
                "do next to nothing"
            )
            yield s.hit("joint", int(m.dof_jntid[dof]), message, attribute="armature")


def negative_damping(s: Subject) -> Iterator[Hit]:
    """A damper that feeds energy."""
    m = s.loaded.model
    for dof in np.flatnonzero(np.asarray(m.dof_damping) < 0):
        message = f"its damping of {m.dof_damping[dof]:g} feeds energy"
        yield s.hit("joint", int(m.dof_jntid[dof]), message, attribute="damping")
    for i in np.flatnonzero(np.asarray(m.tendon_damping) < 0):
        yield s.hit("tendon", int(i), f"its damping of {m.tendon_damping[i]:g} feeds energy")


LIMITS = {
    "joint": (("range", "jnt_limited"), ("actuatorfrcrange", "jnt_actfrclimited")),
    "tendon": (("range", "tendon_limited"), ("actuatorfrcrange", "tendon_actfrclimited")),
    "actuator": (("forcerange", "actuator_forcelimited"), ("actrange", "actuator_actlimited")),
}
"""Kind -> attribute and the field that tells whether it counts."""


def range_ignored(s: Subject) -> Iterator[Hit]:
    """A range that does not limit."""
    for kind, fields in LIMITS.items():
        for element in [e for k, e in s.loaded.elements if k == kind]:
            for key, field in fields:
                for number in s.loaded.numbers.get(element, [])[:1]:
                    given = element.attributes.get(key)
                    if given is not None and not getattr(s.loaded.model, field)[number]:
                        message = f'{key}="{given}" limits nothing: it is off, or empty'
                        yield Hit(element, element.address, message, attribute=key)


def idle_actuator(s: Subject) -> Iterator[Hit]:
    """An actuator whose force is always 0."""
    lib, m = s.loaded.mujoco, s.loaded.model
    fixed, none = int(lib.mjtGain.mjGAIN_FIXED), int(lib.mjtBias.mjBIAS_NONE)
    affine = int(lib.mjtBias.mjBIAS_AFFINE)
    for i in range(len(m.actuator_gaintype)):
        gain = m.actuator_gaintype[i] != fixed or m.actuator_gainprm[i, 0]
        bias = m.actuator_biastype[i] not in (none, affine) or (
            m.actuator_biastype[i] == affine and np.any(m.actuator_biasprm[i, :3])
        )
        parts = np.any([told(m, "actuator_damping", i), told(m, "actuator_armature", i)])
        if (not (gain or bias) or not np.any(gears(m, i))) and not parts:
            message = "its force is always 0: neither control nor bias reaches what it moves"
            yield s.hit("actuator", i, message)


def told(model: Any, field: str, number: int) -> Any:
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
    tendon = int(lib.mjtObj.mjOBJ_TENDON)
    used = set(m.sensor_objid[m.sensor_objtype == tendon].tolist())
    used |= set(m.actuator_trnid[m.actuator_trntype == int(lib.mjtTrn.mjTRN_TENDON), 0].tolist())
    joined = m.eq_type == int(lib.mjtEq.mjEQ_TENDON)
    used |= set(m.eq_obj1id[joined].tolist()) | set(m.eq_obj2id[joined].tolist())
    fields = ("stiffness", "damping", "frictionloss", "armature", "limited")
    for i in range(m.ntendon):
        if i not in used and not any(np.any(told(m, f"tendon_{f}", i)) for f in fields):
            message = (
                "it has neither stiffness, damping, friction, armature nor limits, and no "
                "actuator, sensor or equality uses it"
            )
            yield s.hit("tendon", i, message)


def duplicate_sensor(s: Subject) -> Iterator[Hit]:
    """Two sensors of the same."""
    m = s.loaded.model
    fields = ("type", "objtype", "objid", "reftype", "refid", "cutoff", "dim", "delay", "interval")
    seen: dict[bytes, int] = {}
    for i in range(m.nsensor):
        rows = [np.asarray(told(m, f"sensor_{f}", i)).tobytes() for f in (*fields, "intprm")]
        first = seen.setdefault(b"|".join(rows), i)
        if first != i:
            yield s.hit("sensor", i, f"it shows what {s.loaded.name('sensor', first)} shows")


def unused_asset(s: Subject) -> Iterator[Hit]:
    """An asset that nothing shows."""
    lib, m = s.loaded.mujoco, s.loaded.model
    fields = ("geom_matid", "site_matid", "tendon_matid", "skin_matid", "flex_matid")
    materials = {int(i) for field in fields for i in np.ravel(getattr(m, field, []))}
    kind = np.asarray(m.geom_type)
    meshed = (int(lib.mjtGeom.mjGEOM_MESH), int(lib.mjtGeom.mjGEOM_SDF))
    used = {
        "material": materials,
        "mesh": set(m.geom_dataid[np.isin(kind, meshed)].tolist()) | mesh_names(s),
        "hfield": set(m.geom_dataid[kind == int(lib.mjtGeom.mjGEOM_HFIELD)].tolist()),
        "texture": set(np.ravel(m.mat_texid).tolist()) | backgrounds(s),
    }
    counts = {"material": m.nmat, "mesh": m.nmesh, "hfield": m.nhfield, "texture": m.ntex}
    for name, count in counts.items():
        for i in range(count):
            if i not in used[name]:
                yield s.hit(name, i, f"nothing uses this {name}")


def mesh_names(s: Subject) -> set[int]:
    """Return the meshes that the text names: a geom may be fitted to one, a flex made of one."""
    names = {e.attributes.get("mesh", "") for e in s.loaded.source.walk()}
    return {i for i in range(s.loaded.model.nmesh) if s.loaded.name("mesh", i) in names}


def backgrounds(s: Subject) -> set[int]:
    """Return the textures that need no material: skies, and what lights throw."""
    m = s.loaded.model
    sky = int(s.loaded.mujoco.mjtTexture.mjTEXTURE_SKYBOX)
    return set(np.flatnonzero(m.tex_type == sky).tolist()) | set(m.light_texid.tolist())


def unused_site(s: Subject) -> Iterator[Hit]:
    """A site that nothing refers to."""
    words = {
        value
        for element in s.loaded.source.walk()
        for key, value in element.attributes.items()
        if key != "name"
    }
    for number in range(s.loaded.model.nsite):
        element = s.loaded.element("site", number)
        if element is not None and (element.name is None or element.name not in words):
            yield s.hit("site", number, "no sensor, tendon, actuator or equality refers to it")


def inactive_equality(s: Subject) -> Iterator[Hit]:
    """An equality that is off."""
    for i in np.flatnonzero(np.asarray(s.loaded.model.eq_active0) == 0):
        yield s.hit(
            "equality", int(i), "it is not active, and holds nothing until a program says so"
        )


def switched_off(s: Subject) -> Iterator[Hit]:
    """A flag switches off what the model has."""
    m = s.loaded.model
    parts = {
        "equality": (m.neq, "equalities"),
        "limit": (int(np.sum(m.jnt_limited) + np.sum(m.tendon_limited)), "limits"),
        "spring": (int(np.sum(m.jnt_stiffness != 0) + np.sum(m.tendon_stiffness != 0)), "springs"),
        "damper": (int(np.sum(m.dof_damping != 0) + np.sum(m.tendon_damping != 0)), "dampers"),
        "frictionloss": (int(np.sum(m.dof_frictionloss > 0)), "joints with friction"),
        "actuation": (m.nu, "actuators"),
        "sensor": (m.nsensor, "sensors"),
        "constraint": (m.neq + int(np.sum(m.jnt_limited)), "equalities and limits"),
    }
    for flag, (count, what) in parts.items():
        if s.loaded.disabled(flag) and count:
            message = f'{flag}="disable" switches off {count} {what}'
            yield s.about("option/flag", message=message)


def compiler_warning(s: Subject) -> Iterator[Hit]:
    """What MuJoCo itself warns of."""
    for warning in dict.fromkeys(s.loaded.warnings):
        yield Hit(None, "mujoco", f"MuJoCo: {warning}")

"""Rules about how a model moves: its step, its loops, its states, its energy."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import numpy as np

from ....reference.soft_constraint import IMPEDANCES
from ...checks.rules import conditions
from ..mujoco.closures import ClosedLoop
from ..mujoco.facts import DEEP, DRAWS
from ..mujoco.model import OPENED
from ..mujoco.trial import edited
from ..subject import Hit, InspectedModel, StepLimit, View
from .remedies import (
    MARGIN,
    NEAR,
    all_stay_finite,
    closure_remedy,
    option,
    rounded,
    step_remedies,
)
from .stability import fed_by_drive, grows_in_run

OPEN = 1e-6
"""How far a loop may be open as the file has it: in the model's size, or in rad."""

WEIGHTLESS = 1e-12
"""Share of its weight, at its size, that a joint may feel of gravity where it feels none."""


def step_limit(s: InspectedModel) -> Iterator[Hit]:
    for limit in s.limits_of_file:
        place = f"{limit.place} in the state {limit.state!r}"
        statement = conditions.step_limit(
            s.timestep, limit.limit, limit.omega or math.nan, place, limit.integrator
        )
        if statement is not None:
            fix = remedies(s, limit) or "no integrator and no step that was tried holds a run"
            share = limit.share_of(s.timestep)
            yield s.about("option", message=statement.message, fix=fix, measure=share)


def remedies(s: InspectedModel, limit: StepLimit) -> str:
    """Return what makes the file's step stable; what grows at every step is to be mended first."""
    for view in s.views:
        for mode in fed_by_drive(view):
            if view.linear is not None and grows_in_run(s, view, mode):
                joint = s.loaded.joint_names[mode.place(view.linear.mass)]
                long = [one.integrator for one in s.steps if one.limit >= MARGIN * s.timestep]
                there = " or ".join(f'integrator="{name}"' for name in long)
                stable = f"; for all other motions {there} is stable" if long else ""
                return (
                    f"first mend what feeds the motion of {joint} (unstable_mode): with that no "
                    f"run can show that an integrator or a step holds{stable}"
                )
    return step_remedies(s, limit)


def near_step_limit(s: InspectedModel) -> Iterator[Hit]:
    for limit in s.limits_of_file:
        share = limit.share_of(s.timestep)
        if NEAR < share <= 1:
            message = (
                f"{limit.integrator} is stable up to {limit.limit:.4g} s (a mode of "
                f"{limit.omega:.4g} 1/s, {limit.place}) in the state {limit.state!r}, and the "
                f"timestep is {s.timestep:.4g} s: {share:.0%} of it"
            )
            yield s.about("option", message=message, fix=remedies(s, limit), measure=share)


def coarse_step(s: InspectedModel) -> Iterator[Hit]:
    near = any(limit.share_of(s.timestep) > NEAR for limit in s.limits_of_file)
    if s.shortest_period is not None and not near:  # which says it louder
        yield from s.state(conditions.coarse_step(s.timestep, s.shortest_period), "option")


def not_finite(s: InspectedModel) -> Iterator[Hit]:
    reasons = [str(view.reason) for view in s.views if view.failed]
    return (s.about("keyframe", "worldbody", message=reason) for reason in reasons)


def closure_softness(s: InspectedModel) -> Iterator[Hit]:
    said: dict[int, Hit] = {}
    for one in sorted(s.closures, key=lambda item: -item.opening):
        statement = conditions.closure_softness(
            f"{one.kind} {one.name}",
            one.opening,
            size_of(s, one),
            f"its load of {one.force:.3g} in the state {one.state!r} (solref "
            f"{spaced(one.effective)}, impedance {one.impedance:.4g})",
            turn=one.turn,
        )
        if statement is None or one.number in said or is_handle(s, one.number):
            continue  # the state where it opens most has said it
        left_out = load_leaves_out(s, one.state)
        words = f"; the load leaves out {left_out}" if left_out else ""
        fix = closure_remedy(s, one) or (
            "no setting of solref and solimp that was tried closes it at this step; shorten the "
            "timestep, or relieve it"
        )
        message, measure = statement.message + words, max(one.opening, one.turn or 0.0)
        said[one.number] = s.hit("equality", one.number, message, fix=fix, measure=measure)
    yield from said.values()


def is_handle(s: InspectedModel, number: int) -> bool:
    """Return whether an equality ties a body to a mocap body, which drags it softly on purpose."""
    m, kinds = s.model, s.loaded.of_kind("eq_type", "connect", "weld")
    if not kinds[number]:
        return False
    body = s.loaded.member("mjtObj", "mjOBJ", "body")
    ids = np.array([m.eq_obj1id[number], m.eq_obj2id[number]])
    bodies = ids if m.eq_objtype[number] == body else m.site_bodyid[ids]
    return bool(np.any(m.body_mocapid[m.body_rootid[bodies]] >= 0))


def load_leaves_out(s: InspectedModel, state: str) -> str:
    """Return what acts in a state, and is no part of the load of a closure there."""
    for one in s.views:
        if one.linear is not None and one.state.name == state:
            friction = [*s.model.dof_frictionloss, *s.model.tendon_frictionloss]
            parts = {
                "contacts": one.linear.rows.contacts,
                "limits": one.linear.rows.limits,
                "dry friction": any(friction),
            }
            return " and ".join(word for word, acts in parts.items() if acts)
    return ""


def closure_open(s: InspectedModel) -> Iterator[Hit]:
    said: dict[int, Hit] = {}
    for one in s.closures:
        if one.now > OPEN * size_of(s, one):
            message = f"{one.kind} {one.name} is open by {one.now:.3g} in the state {one.state!r}"
            hit = s.hit("equality", one.number, message, measure=one.now)
            said.setdefault(one.number, hit)
    yield from said.values()


def size_of(s: InspectedModel, closure: ClosedLoop) -> float:
    """Return in what a closure's opening is measured: the model's size [m], or 1 rad."""
    return s.facts.size if closure.kind in ("connect", "weld") else 1.0


def spaced(values: Iterable[float]) -> str:
    """Return numbers as MJCF writes them."""
    return " ".join(f"{value:g}" for value in values)


def solref_raised(s: InspectedModel) -> Iterator[Hit]:
    least = 2 * s.timestep * (s.facts.options.refsafe and s.facts.options.integrator != "discrete")
    fixes = dict[float, str]()
    for kind, number, (constant, ratio), _ in constraints(s):
        if 0 < constant < least * (1 - 1e-9):
            step = rounded(constant / 2, up=False, digits=4)
            if step not in fixes:
                tried = edited(s.loaded, option("timestep", step))
                holds = all_stay_finite(tried, s.loaded.states)
                fixes[step] = f'timestep="{step:g}" or shorter' if holds else ""
            message = (
                f"solref has a time constant of {constant:g} s, and MuJoCo silently takes "
                f"{least:.4g} s, two timesteps, in its place"
            )
            taken = f'solref="{least:.16g} {ratio:.16g}", which is what MuJoCo takes now'
            # a geom's solref is mixed with that of what it touches
            fix = "; or ".join(filter(None, [fixes[step], "" if kind == "geom" else taken]))
            yield s.hit(kind, number, message, attribute="solref", fix=fix)


def solimp_clamped(s: InspectedModel) -> Iterator[Hit]:
    hardest = IMPEDANCES[1]
    taken = f"MuJoCo takes {hardest:g}, its largest, without a word"
    for kind, number, _, solimp in constraints(s):
        if max(solimp[:2]) > hardest:
            beyond = spaced(float(d) for d in solimp[:2] if d > hardest)
            yield s.hit(kind, number, f"solimp has impedances of {beyond}; {taken}")


def constraints(s: InspectedModel) -> Iterator[tuple[str, int, np.ndarray, np.ndarray]]:
    """Yield the constraints that can act: kind, number, solref (2,), solimp (5,)."""
    m = s.model
    for kind, acts, solref, solimp in (
        ("equality", np.ones(m.neq), m.eq_solref, m.eq_solimp),
        ("joint", m.jnt_limited, m.jnt_solref, m.jnt_solimp),
        ("tendon", m.tendon_limited, m.tendon_solref_lim, m.tendon_solimp_lim),
        ("geom", s.can_touch, m.geom_solref, m.geom_solimp),
    ):
        yield from ((kind, int(i), solref[i], solimp[i]) for i in np.flatnonzero(acts))


def contact_depth(s: InspectedModel) -> Iterator[Hit]:
    for view in starts(s) if s.facts.options.contact else ():
        data = s.loaded.data(view.state)
        s.loaded.mujoco.mj_fwdPosition(s.model, data)
        contacts = [(-float(contact.dist), contact.geom) for contact in data.contact]
        deep = [
            (depth, pair)
            for depth, pair in contacts
            if depth > DEEP * s.facts.size and s.meetings.get((int(pair[0]), int(pair[1]))) != DRAWS
        ]
        if deep:
            depth, geoms = max(deep, key=lambda one: one[0])
            names = " and ".join(s.loaded.name("geom", i) for i in geoms)
            more = f" ({len(deep)} contacts are as deep)" if len(deep) > 1 else ""
            message = f"in the state {view.state.name!r}, {names} lie {depth:.3g} m in each other"
            yield s.hit("geom", geoms[0], message + more, measure=depth)


def starts(s: InspectedModel) -> list[View]:
    """Return the states from which runs start: the keyframes.

    Without any, programs mostly set one; the one in which the file opens counts for the house.
    """
    keyframes = [one for one in s.views if one.state.keys != (OPENED,)]
    return keyframes or (list(s.views) if s.strict else [])


def keyframe_outside_range(s: InspectedModel) -> Iterator[Hit]:
    m = s.model
    low, high = m.jnt_range.T
    limited = (m.jnt_limited != 0) & s.loaded.of_kind("jnt_type", "slide", "hinge")
    slack = 1e-9 * np.max(np.abs(m.jnt_range), axis=1)
    for view in starts(s):
        values = view.state.position[m.jnt_qposadr]
        for i in np.flatnonzero(limited & ((values < low - slack) | (values > high + slack))):
            yield s.hit(
                "joint",
                i,
                f"in the state {view.state.name!r} it is at {values[i]:.4g}, beyond its range of "
                f"{low[i]:.4g} to {high[i]:.4g}",
            )


def no_keyframe(s: InspectedModel) -> Iterator[Hit]:
    if s.model.nv and not s.model.nkey:
        yield s.about(
            "worldbody", message="the file has no keyframe: where a run starts is not told"
        )


def auto_reset(s: InspectedModel) -> Iterator[Hit]:
    if s.facts.options.autoreset:
        message = "auto-reset is on: a run that diverges is set back to its start"
        yield s.about("option/flag", "option", message=message)


def clock_rounding(s: InspectedModel) -> Iterator[Hit]:
    return s.state(conditions.clock_rounding(s.timestep, "the clock"), "option")


def energy_off(s: InspectedModel) -> Iterator[Hit]:
    if not s.facts.options.energy and conservative(s):
        message = "nothing here feeds or takes energy, and the flag that keeps its books is off"
        yield s.about("option/flag", "option", message=message)


def conservative(s: InspectedModel) -> bool:
    """Return whether nothing feeds or takes energy of a model."""
    m = s.model
    spent = (m.dof_damping, m.dof_frictionloss, m.tendon_damping, m.tendon_frictionloss)
    limits = (m.jnt_limited, m.tendon_limited, s.can_touch)
    driven = m.neq or m.nflex or m.nu or m.nmocap or m.opt.density or m.opt.viscosity
    return bool(m.nv) and not (driven or any(np.any(values) for values in (*spent, *limits)))


def ill_conditioned(s: InspectedModel) -> Iterator[Hit]:
    statements = (
        conditions.ill_conditioned(
            view.linear.mass, f"in the state {view.state.name!r}", conditions.FEW_DIGITS
        )
        for view in s.views
        if view.linear is not None
    )
    return s.state(next(filter(None, statements), None), "worldbody")


def idle_gravity(s: InspectedModel) -> Iterator[Hit]:
    lib, m = s.loaded.mujoco, s.model
    if not any(s.facts.options.gravity) or not m.nv:
        return
    data, generator = lib.MjData(m), np.random.default_rng(0)
    weight = float(np.sum(m.body_mass)) * float(np.linalg.norm(m.opt.gravity)) * s.facts.size
    for _ in range(3):
        data.qpos[:], data.qvel[:] = m.qpos0, 0
        lib.mj_integratePos(m, data.qpos, generator.uniform(-1, 1, m.nv), 1.0)
        lib.mj_fwdPosition(m, data)
        lib.mj_fwdVelocity(m, data)
        if np.max(np.abs(data.qfrc_bias)) > WEIGHTLESS * weight:
            return
    message = f"gravity {spaced(s.facts.options.gravity)} moves no joint in any configuration"
    yield s.about("option", message=message)

"""Rules about the motion of a model: its step, its loops, its states, its energy, its growth."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from typing import Any

import numpy as np

from ....reference.soft_constraint import IMPEDANCES
from ...checks.rules import conditions
from ..mujoco.model import OPENED, Loaded
from ..subject import Hit, InspectedModel
from ..tuning import EFFORT, NUMERICS, THRESHOLDS
from ..views import (
    Shape,
    StepLimit,
    View,
    fed_by_drive,
    growing,
    growth_in_run,
    is_fed_by_drive,
    view_of,
)
from .drives import drives, sign_attribute
from .remedies import (
    closure_remedy,
    edited,
    far_starts,
    fault_in_runs,
    in_words,
    integrator_remedy,
    joint_edits,
    moments,
    rounded,
    short_run,
    step_remedies,
    with_option,
)


def step_limit(s: InspectedModel) -> Iterator[Hit]:
    for limit in s.limits_of_file:
        place = f"{limit.place} in the state {limit.state!r}"
        statement = conditions.step_limit(
            s.timestep, limit.limit, limit.omega or math.nan, place, limit.integrator
        )
        if statement is not None:
            fix = remedies(s, limit) or "no integrator and no step that was tried is stable"
            share = limit.share_of(s.timestep)
            yield s.about("option", message=statement.message, fix=fix, measure=share)


def remedies(s: InspectedModel, limit: StepLimit) -> str:
    """Return edits that make the step stable, once no motion grows whatever the step."""
    if not s.fed_growth:
        return step_remedies(s, limit)
    _, mode = s.fed_growth[0]
    share = THRESHOLDS.recommended_step
    long = [one.integrator for one in s.steps if s.timestep <= share * one.limit]
    there = " or ".join(f'integrator="{name}"' for name in long)
    stable = f"; for all other motions {there} is stable" if long else ""
    return (
        f"first mend the growing motion of {s.loaded.joint_names[mode.dof]} (unstable_mode): as "
        f"long as it grows, no run can show that an integrator or a step is stable{stable}"
    )


def near_step_limit(s: InspectedModel) -> Iterator[Hit]:
    for limit in s.limits_of_file:
        share = limit.share_of(s.timestep)
        if THRESHOLDS.near_step_limit < share <= 1:
            message = (
                f"{limit.integrator} is stable up to {limit.limit:.4g} s (a mode of "
                f"{limit.omega:.4g} 1/s, {limit.place}) in the state {limit.state!r}, and the "
                f"timestep is {s.timestep:.4g} s: {share:.0%} of it"
            )
            yield s.about("option", message=message, fix=remedies(s, limit), measure=share)


def coarse_step(s: InspectedModel) -> Iterator[Hit]:
    most = THRESHOLDS.near_step_limit
    near = any(limit.share_of(s.timestep) > most for limit in s.limits_of_file)
    if s.shortest_period is not None and not near:  # `near_step_limit` reports it
        yield from s.state(conditions.coarse_step(s.timestep, s.shortest_period), "option")


def not_finite(s: InspectedModel) -> Iterator[Hit]:
    reasons = [str(view.reason) for view in s.views if view.failed]
    return (s.about("keyframe", "worldbody", message=reason) for reason in reasons)


def closure_softness(s: InspectedModel) -> Iterator[Hit]:
    hits: dict[int, Hit] = {}
    for one in sorted(s.closures, key=lambda item: -item.opening):
        statement = conditions.closure_softness(
            f"{one.kind} {one.name}",
            one.opening,
            s.size_of(one),
            f"its load of {one.force:.3g} in the state {one.state!r} (solref "
            f"{spaced(one.effective)}, impedance {one.impedance:.4g})",
            turn=one.turn,
        )
        if statement is None or one.number in hits or is_handle(s, one.number):
            continue  # reported for the state where it opens most
        left_out = load_leaves_out(s, one.state)
        words = f"; the load does not include {left_out}" if left_out else ""
        fix = closure_remedy(s, one) or (
            "no setting of solref and solimp that was tried closes it at this step; shorten the "
            "timestep, or reduce its load"
        )
        message, measure = statement.message + words, max(one.opening, one.turn or 0.0)
        hits[one.number] = s.hit("equality", one.number, message, fix=fix, measure=measure)
    yield from hits.values()


def is_handle(s: InspectedModel, number: int) -> bool:
    """Return True if an equality ties a body to a mocap body, which drags it softly on purpose."""
    m, kinds = s.model, s.loaded.of_kind("eq_type", "connect", "weld")
    if not kinds[number]:
        return False
    body = s.loaded.member("mjtObj", "mjOBJ", "body")
    ids = np.array([m.eq_obj1id[number], m.eq_obj2id[number]])
    bodies = ids if m.eq_objtype[number] == body else m.site_bodyid[ids]
    return bool(np.any(m.body_mocapid[m.body_rootid[bodies]] >= 0))


def load_leaves_out(s: InspectedModel, state: str) -> str:
    """Return the forces of a state that the load of a closure does not include."""
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
    hits: dict[int, Hit] = {}
    for one in s.closures:
        if one.now > THRESHOLDS.open_loop * s.size_of(one):
            message = f"{one.kind} {one.name} is open by {one.now:.3g} in the state {one.state!r}"
            hit = s.hit("equality", one.number, message, measure=one.now)
            hits.setdefault(one.number, hit)
    yield from hits.values()


def spaced(values: Iterable[float]) -> str:
    """Return numbers as MJCF writes them."""
    return " ".join(f"{value:g}" for value in values)


def solref_raised(s: InspectedModel) -> Iterator[Hit]:
    least = 2 * s.timestep * (s.options.refsafe and s.options.integrator != "discrete")
    fixes = dict[float, str]()
    for kind, number, (constant, ratio), _ in constraints(s):
        if 0 < constant < least * (1 - 1e-9):
            step = rounded(constant / 2, up=False, digits=4)
            if step not in fixes:
                tried, words = with_option(s.loaded, "timestep", step), f'timestep="{step:g}"'
                fault = fault_in_runs(s, tried, s.loaded.states, words)
                fixes[step] = "" if fault else f"{words} or shorter"
            message = (
                f"solref has a time constant of {constant:g} s; MuJoCo silently uses two "
                f"timesteps, {least:.4g} s"
            )
            taken = f'solref="{least:.16g} {ratio:.16g}", as MuJoCo uses now'
            # a geom's solref is mixed with that of what it touches
            fix = "; or ".join(filter(None, [fixes[step], "" if kind == "geom" else taken]))
            yield s.hit(kind, number, message, attribute="solref", fix=fix)


def solimp_clamped(s: InspectedModel) -> Iterator[Hit]:
    hardest = IMPEDANCES[1]
    used = f"MuJoCo silently uses {hardest:g}, its largest"
    for kind, number, _, solimp in constraints(s):
        if max(solimp[:2]) > hardest:
            beyond = spaced(float(d) for d in solimp[:2] if d > hardest)
            yield s.hit(kind, number, f"solimp has impedances of {beyond}; {used}")


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
    for view in starts(s) if s.options.contact else ():
        data = s.loaded.data(view.state)
        s.loaded.mujoco.mj_fwdPosition(s.model, data)
        contacts = [(-float(contact.dist), contact.geom) for contact in data.contact]
        always = {pair for pair, count in s.meetings.items() if count == EFFORT.draws}
        deep = [
            (depth, pair)
            for depth, pair in contacts
            if depth > NUMERICS.deep * s.size and (int(pair[0]), int(pair[1])) not in always
        ]
        if deep:
            depth, geoms = max(deep, key=lambda one: one[0])
            names = " and ".join(s.loaded.name("geom", i) for i in geoms)
            more = f" ({len(deep)} contacts are as deep)" if len(deep) > 1 else ""
            message = f"in the state {view.state.name!r}, {names} overlap by {depth:.3g} m"
            yield s.hit("geom", geoms[0], message + more, measure=depth)


def starts(s: InspectedModel) -> list[View]:
    """Return the states from which runs start: the keyframes.

    Without keyframes programs mostly set a state; then `qpos0` counts for rules of the house.
    """
    keyframes = [one for one in s.views if one.state.keys != (OPENED,)]
    return keyframes or (list(s.views) if s.strict else [])


def keyframe_outside_range(s: InspectedModel) -> Iterator[Hit]:
    m = s.model
    low, high = m.jnt_range.T
    slack = 1e-9 * np.max(np.abs(m.jnt_range), axis=1)
    for view in starts(s):
        values = view.state.position[m.jnt_qposadr]
        outside = (values < low - slack) | (values > high + slack)
        for i in np.flatnonzero(s.loaded.limited_joints & outside):
            yield s.hit(
                "joint",
                i,
                f"in the state {view.state.name!r} it is at {values[i]:.4g}, beyond its range of "
                f"{low[i]:.4g} to {high[i]:.4g}",
            )


def no_keyframe(s: InspectedModel) -> Iterator[Hit]:
    if s.model.nv and not s.model.nkey:
        message = "the file has no keyframe, which would define the initial state of a run"
        yield s.about("worldbody", message=message)


def auto_reset(s: InspectedModel) -> Iterator[Hit]:
    if s.options.autoreset:
        message = "auto-reset is on: a run that diverges is reset to its start"
        yield s.about("option/flag", "option", message=message)


def clock_rounding(s: InspectedModel) -> Iterator[Hit]:
    return s.state(conditions.clock_rounding(s.timestep, "the clock"), "option")


def energy_off(s: InspectedModel) -> Iterator[Hit]:
    if not s.options.energy and conservative(s):
        message = "the model conserves energy, and the flag that records it is off"
        yield s.about("option/flag", "option", message=message)


def conservative(s: InspectedModel) -> bool:
    """Return True if a model conserves energy."""
    m = s.model
    spent = (m.dof_damping, m.dof_frictionloss, m.tendon_damping, m.tendon_frictionloss)
    limits = (m.jnt_limited, m.tendon_limited, s.can_touch)
    driven = m.neq or m.nflex or m.nu or m.nmocap or m.opt.density or m.opt.viscosity
    return bool(m.nv) and not (driven or any(np.any(values) for values in (*spent, *limits)))


def ill_conditioned(s: InspectedModel) -> Iterator[Hit]:
    statements = (
        conditions.ill_conditioned(
            linear.mass, f"in the state {view.state.name!r}", conditions.FEW_DIGITS
        )
        for view, linear in s.linear_views
    )
    return s.state(next(filter(None, statements), None), "worldbody")


def idle_gravity(s: InspectedModel) -> Iterator[Hit]:
    lib, m = s.loaded.mujoco, s.model
    if not any(s.options.gravity) or not m.nv:
        return
    data, generator = lib.MjData(m), np.random.default_rng(0)
    weight = float(np.sum(m.body_mass)) * float(np.linalg.norm(m.opt.gravity)) * s.size
    for _ in range(3):
        data.qpos[:], data.qvel[:] = m.qpos0, 0
        lib.mj_integratePos(m, data.qpos, generator.uniform(-1, 1, m.nv), 1.0)
        lib.mj_fwdPosition(m, data)
        lib.mj_fwdVelocity(m, data)
        if np.max(np.abs(data.qfrc_bias)) > THRESHOLDS.gravity_share * weight:
            return
    message = f"gravity {spaced(s.options.gravity)} moves no joint in any configuration"
    yield s.about("option", message=message)


# Growth, whatever the step --------------------------------------------------------------------

UNKNOWN = (
    "no integrator and no shorter step that was tried is stable: look for stiff or light parts"
)
"""Remedy of a run that fails with all that was tried."""


def unstable_mode(s: InspectedModel) -> Iterator[Hit]:
    for one, mode in s.fed_growth:
        joint, rate = s.loaded.joint_names[mode.dof], mode.rate
        fed_by = feeders(s, one, mode)
        actuators = ", ".join(s.loaded.name("actuator", i) for i in fed_by)
        source = f"actuators {actuators} feed" if actuators else "negative damping feeds"
        swing = f" and oscillates at {rate.imag:.4g} rad/s" if rate.imag else ""
        message = (
            f"in the state {one.state.name!r} a motion of {joint} grows by a factor of e in "
            f"{1 / rate.real:.3g} s ({rate.real:.3g} 1/s){swing}, whatever the step: {source} it"
        )
        signs = sign_remedy(s, one, mode, fed_by)
        fix = "reverse the sign of " + " and ".join(words for _, _, _, words, _, _ in signs)
        if not signs:
            fix = damping_remedy(s, one, mode) or (
                "reverse the sign of the gain, or of the gear" if actuators else "reverse its sign"
            )
        causes = tuple((rule, s.hit(kind, i, "").name) for rule, kind, i, *_ in signs)
        yield s.hit("joint", s.model.dof_jntid[mode.dof], message, fix=fix, causes=causes)


def feeders(s: InspectedModel, view: View, mode: Shape) -> list[int]:
    """Return the actuators that push along a mode and react to position or speed."""
    m = s.model
    reacts = s.loaded.of_kind("actuator_biastype", "affine", "muscle") & np.any(
        m.actuator_biasprm[:, 1:3] != 0, axis=1
    )
    power = np.abs(moments(s.loaded, view.state) @ mode.vector) * reacts
    large: list[int] = np.flatnonzero(
        power > THRESHOLDS.named_power * np.max(power, initial=0.0)
    ).tolist()
    return large


WrongSign = tuple[str, str, int, str, str, Any]
"""A sign that feeds a motion: the rule that finds it, kind and number of the object, the attribute,
and its field and index in ``MjModel``."""


def sign_remedy(
    s: InspectedModel, one: View, mode: Shape, feeding: Sequence[int]
) -> list[WrongSign]:
    """Return the wrong signs of actuators and dampers, if reversing them ends the growth."""
    m, name, wrong = s.model, s.loaded.name, list[WrongSign]()
    for servo in drives(s):
        i = servo.actuator
        signs = ((1, "position", servo.stiffness), (2, "speed", servo.damping))
        for column, what, resists in signs if i in feeding else ():
            if resists < 0:
                words, field = f"{sign_attribute(s, i, what)} of {servo.name}", "actuator_biasprm"
                wrong.append(("positive_feedback", "actuator", i, words, field, (i, column)))
    joints = np.unique(m.dof_jntid[(m.dof_damping < 0) & (mode.vector != 0)]).tolist()
    tendons = np.flatnonzero(m.tendon_damping < 0).tolist()
    places = [("joint", i, "dof_damping", m.dof_jntid == i) for i in joints]
    places += [("tendon", i, "tendon_damping", i) for i in tendons]
    wrong += [
        ("negative_damping", kind, i, f"damping of {name(kind, i)}", field, index)
        for kind, i, field, index in places
    ]

    def change(model: Any) -> None:
        for *_, field, index in wrong:
            getattr(model, field)[index] *= -1

    tried = edited(s.loaded, change)
    ends = wrong and no_mode_is_fed(s, tried) and runs_settle(s, tried, one, mode)
    return wrong if ends else []


def damping_remedy(s: InspectedModel, one: View, mode: Shape) -> str | None:
    """Return a damping of a joint that ends the growth, if any does."""
    assert one.linear is not None
    dofs = s.model.dof_jntid == s.model.dof_jntid[mode.dof]
    unit = THRESHOLDS.damping_unit * float(np.max(np.diag(one.linear.mass)[dofs]))
    edits = (
        (words, edited(s.loaded, change))
        for words, change in joint_edits(
            s, "damping", dofs, unit * max(mode.omega for mode in growing(one))
        )
    )
    stable = (edit for edit in edits if no_mode_is_fed(s, edit[1]))
    tried = islice(stable, EFFORT.run_tries)
    return next((words for words, model in tried if runs_settle(s, model, one, mode)), None)


def no_mode_is_fed(s: InspectedModel, tried: Loaded) -> bool:
    """Return True if drives and dampers of an edited model feed no mode in any state."""
    views = (view_of(tried, view.state) for view, _ in s.linear_views if view.steady_hinge is None)
    return all(view.linear is not None and not any(fed_by_drive(view)) for view in views)


def runs_settle(s: InspectedModel, tried: Loaded, one: View, mode: Shape) -> bool:
    """Return True if runs of an edited model do not grow, near a state and far from it.

    Where gravity lets another motion grow, the modes alone decide.
    """
    again, horizon = view_of(tried, one.state), THRESHOLDS.growth_folds / mode.rate.real
    if growing(again):
        return True
    slowest = max(again.simulated, key=lambda mode: mode.rate.real)
    factor = growth_in_run(tried, again, slowest, horizon)
    if factor is None or factor >= np.exp(1):
        return False
    fastest = max(mode.omega for mode in again.simulated) or 1.0
    step = min(s.timestep, 1 / (NUMERICS.steps_per_radian * fastest))
    rk4 = s.loaded.member("mjtIntegrator", "mjINT", "RK4")
    fine = with_option(with_option(tried, "integrator", rk4), "timestep", step)
    dofs = s.model.dof_jntid == s.model.dof_jntid[mode.dof]
    starts = far_starts(fine, one.state, dofs, NUMERICS.far_starts[-1:])
    runs = (short_run(fine, start, horizon) for start in starts)
    for failed, energies in runs:
        first, second = (np.max(part, initial=0.0) for part in np.array_split(energies[:, 1], 2))
        if failed is not None or second > NUMERICS.lasting_ratio * first:
            return False
    return True


def run_fails(s: InspectedModel) -> Iterator[Hit]:
    beyond = any(limit.share_of(s.timestep) > 1 for limit in s.limits_of_file)
    beyond |= any(view.failed or any(fed_by_drive(view)) for view in s.views)
    if beyond or s.model.nv > EFFORT.max_remedy_dofs:  # other rules report it
        return
    named = [one for one in s.loaded.states if one.keys != (OPENED,)]
    for state in (named or list(s.loaded.states))[: EFFORT.runs]:
        step, _ = short_run(s.loaded, state)
        if step is None:
            continue
        spins = [view.reason for view in s.views if view.state is state and view.reason]
        why = f" (no modes: {spins[0]})" if spins else ""
        message = (
            f"a run from the state {state.name!r} with constant controls diverges in step {step}, "
            f"at {step * s.timestep:.3g} s{why}"
        )
        fixes = integrator_remedy(s, [state])
        shorter = (rounded(share * s.timestep, up=False) for share in THRESHOLDS.shorter_steps)
        edits = ((f'timestep="{x:g}"', with_option(s.loaded, "timestep", x)) for x in shorter)
        stable = (words for words, x in edits if not fault_in_runs(s, x, [state], words))
        fixes += islice(stable, 1)
        yield s.about("option", message=message, fix=in_words(s, fixes) or UNKNOWN)
        return


def unstable_equilibrium(s: InspectedModel) -> Iterator[Hit]:
    most = THRESHOLDS.rest_acceleration * max(1.0, float(np.linalg.norm(s.options.gravity)))
    for one in s.views:
        linear, modes = one.linear, growing(one)
        if linear is None or linear.rows.contacts or not modes:
            continue
        mode = max(modes, key=lambda mode: mode.rate.real)
        if np.max(np.abs(linear.acceleration)) <= most and not is_fed_by_drive(linear, mode):
            message = (
                f"the state {one.state.name!r} is an unstable equilibrium, like an inverted "
                f"pendulum: a motion of {s.loaded.joint_names[mode.dof]} grows by a factor of e in "
                f"{1 / mode.rate.real:.3g} s"
            )
            yield s.hit("joint", s.model.dof_jntid[mode.dof], message)

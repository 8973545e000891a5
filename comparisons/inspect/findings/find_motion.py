"""Rules about how a model moves: its step, its loops, its states, its energy."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ..subject import Hit, Subject

NEAR = 0.8
"""Share of the largest stable step above which a step is near it."""

FEW_STEPS = 10
"""In the shortest period."""

OPENING = 1e-3
"""How far a loop may open: in the model's size, or in rad."""

OPEN = 1e-6
"""How far a loop may be open as the file has it: in the model's size, or in rad."""

DEEP = 1e-3
"""How far bodies may lie in each other as the file has them, in the model's size."""

HARDEST = 0.9999
"""Impedance that MuJoCo takes at most."""

WORST = 1e12
"""Condition number of the mass matrix, in units of its diagonal, that leaves four digits."""


def own_step(s: Subject) -> Iterator[tuple[float, str]]:
    """Yield the share of its largest stable step that the file's timestep is, and the words."""
    for step in s.steps:
        if step.chosen and 0 < step.limit < math.inf:
            mode = "" if step.omega is None else f" (a mode of {step.omega:.4g} 1/s, {step.joint})"
            yield (
                s.timestep / step.limit,
                f"{step.integrator} is stable up to {step.limit:.4g} s{mode} in the state "
                f"{step.state!r}, and the timestep is {s.timestep:.4g} s",
            )


def step_limit(s: Subject) -> Iterator[Hit]:
    """The timestep is longer than the integrator bears."""
    for share, words in own_step(s):
        if share > 1:
            fix = f"choose a timestep below {s.timestep / share:.3g} s"
            yield s.about("option", message=f"{words}: {share:.3g} times that", fix=fix)


def near_step_limit(s: Subject) -> Iterator[Hit]:
    """It is close to that."""
    for share, words in own_step(s):
        if NEAR < share <= 1:
            fix = f"choose a timestep below {0.5 * s.timestep / share:.3g} s"
            yield s.about("option", message=f"{words}: {share:.0%} of it", fix=fix)


def coarse_step(s: Subject) -> Iterator[Hit]:
    """Few steps in the shortest period."""
    if any(share > NEAR for share, _ in own_step(s)):
        return  # which says it louder
    if s.shortest_period and s.shortest_period < FEW_STEPS * s.timestep:
        steps = s.shortest_period / s.timestep
        yield s.about(
            "option",
            message=f"the shortest period, {s.shortest_period:.4g} s, has {steps:.3g} steps",
            fix=f"choose a timestep of {s.shortest_period / 20:.2g} s if that motion matters",
        )


def not_finite(s: Subject) -> Iterator[Hit]:
    """Forces or accelerations are not finite."""
    for view in s.views:
        if view.failed:
            yield s.about("keyframe", "worldbody", message=str(view.reason))


def closure_softness(s: Subject) -> Iterator[Hit]:
    """A loop opens under its load."""
    seen = set()
    for one in sorted(s.closures, key=lambda item: -item.opening):
        size = s.facts.size if one.kind in ("connect", "weld") else 1.0
        wide = one.opening > OPENING * size or (one.turn or 0.0) > OPENING
        if wide and one.number not in seen:
            seen.add(one.number)
            turn = "" if one.turn is None else f" and {one.turn:.2g} rad"
            message = (
                f"{one.kind} {one.name} is to open by {one.opening:.3g}{turn} under its load of "
                f"{one.force:.3g} in the state {one.state!r}, whatever the step: solref "
                f"{pair(one.effective)}, impedance {one.impedance:.4g}"
            )
            yield s.hit("equality", one.number, message)


def pair(values: tuple[float, ...]) -> str:
    """Return numbers as MJCF writes them."""
    return " ".join(f"{value:g}" for value in values)


def closure_open(s: Subject) -> Iterator[Hit]:
    """A loop is open as the file has it."""
    seen = set()
    for one in s.closures:
        size = s.facts.size if one.kind in ("connect", "weld") else 1.0
        if one.now > OPEN * size and one.number not in seen:
            seen.add(one.number)
            message = f"{one.kind} {one.name} is open by {one.now:.3g} in the state {one.state!r}"
            yield s.hit("equality", one.number, message)


def solref_raised(s: Subject) -> Iterator[Hit]:
    """MuJoCo softens a constraint because of the step."""
    options = s.facts.options
    if not options.refsafe or options.integrator == "discrete":
        return
    least = 2 * options.timestep
    for kind, number, solref, _ in constraints(s):
        if 0 < solref[0] < least * (1 - 1e-9):
            message = (
                f"solref has a time constant of {solref[0]:g} s, and MuJoCo takes {least:.4g} s, "
                "two timesteps, in its place without a word"
            )
            yield s.hit(kind, number, message, attribute="solref")


def solimp_clamped(s: Subject) -> Iterator[Hit]:
    """An impedance beyond MuJoCo's limits."""
    for kind, number, _, solimp in constraints(s):
        beyond = tuple(float(d) for d in solimp[:2] if d > HARDEST)
        if beyond:
            message = (
                f"solimp has impedances of {pair(beyond)}; MuJoCo takes {HARDEST:g}, its largest, "
                "without a word"
            )
            yield s.hit(kind, number, message)


def constraints(s: Subject) -> Iterator[tuple[str, int, np.ndarray, np.ndarray]]:
    """Yield the constraints that can act: kind, number, solref (2,), solimp (5,)."""
    m = s.loaded.model
    for i in np.arange(m.neq):
        yield "equality", int(i), m.eq_solref[i], m.eq_solimp[i]
    for i in np.flatnonzero(m.jnt_limited):
        yield "joint", int(i), m.jnt_solref[i], m.jnt_solimp[i]
    for i in np.flatnonzero(m.tendon_limited):
        yield "tendon", int(i), m.tendon_solref_lim[i], m.tendon_solimp_lim[i]
    for i in np.flatnonzero(s.touching):
        yield "geom", int(i), m.geom_solref[i], m.geom_solimp[i]


def contact_depth(s: Subject) -> Iterator[Hit]:
    """Bodies lie in each other as the file has them."""
    lib, model = s.loaded.mujoco, s.loaded.model
    if not s.facts.options.contact:
        return
    for view in s.views:
        data = s.loaded.data(view.state)
        lib.mj_fwdPosition(model, data)
        depths = [(-float(contact.dist), contact.geom) for contact in data.contact]
        deepest = max(depths, key=lambda item: item[0], default=(0.0, None))
        if deepest[1] is not None and deepest[0] > DEEP * s.facts.size:
            names = " and ".join(s.loaded.name("geom", int(i)) for i in deepest[1])
            count = sum(depth > DEEP * s.facts.size for depth, _ in depths)
            yield s.hit(
                "geom",
                int(deepest[1][0]),
                f"in the state {view.state.name!r}, {names} lie {deepest[0]:.3g} m in each other"
                + (f" ({count} contacts are as deep)" if count > 1 else ""),
            )


def keyframe_outside_range(s: Subject) -> Iterator[Hit]:
    """A keyframe is beyond a joint's limits."""
    m = s.loaded.model
    for view in s.views:
        for joint in np.flatnonzero(m.jnt_limited):
            at = int(m.jnt_qposadr[joint])
            low, high = map(float, m.jnt_range[joint])
            value = float(view.state.position[at])
            simple = m.jnt_type[joint] >= int(s.loaded.mujoco.mjtJoint.mjJNT_SLIDE)
            slack = 1e-9 * max(abs(low), abs(high))
            if simple and not low - slack <= value <= high + slack:
                yield s.hit(
                    "joint",
                    int(joint),
                    f"in the state {view.state.name!r} it is at {value:.4g}, beyond its range of "
                    f"{low:.4g} to {high:.4g}",
                )


def no_keyframe(s: Subject) -> Iterator[Hit]:
    """No initial condition is told."""
    if s.facts.counts["nv"] and not s.facts.counts["keyframes"]:
        yield s.about(
            "worldbody", message="the file has no keyframe: where a run starts is not told"
        )


def auto_reset(s: Subject) -> Iterator[Hit]:
    """A run that fails starts anew."""
    if s.facts.options.autoreset:
        yield s.about(
            "option/flag",
            "option",
            message="auto-reset is on: a run that diverges is set back to its start",
        )


def clock_rounding(s: Subject) -> Iterator[Hit]:
    """The clock adds up rounded steps."""
    if math.frexp(s.timestep)[0] != 0.5:
        near = 2.0 ** round(math.log2(s.timestep))
        yield s.about(
            "option",
            message=f"the timestep {s.timestep:g} s is no power of two, so the clock adds up "
            "rounded steps",
            fix=f'timestep="{near:.17g}"',
        )


def energy_off(s: Subject) -> Iterator[Hit]:
    """Energy would tell the error of a run, and is not kept."""
    if not s.facts.options.energy and conservative(s):
        yield s.about(
            "option/flag",
            "option",
            message="nothing here feeds or takes energy, and the flag that keeps its books is off",
        )


def conservative(s: Subject) -> bool:
    """Return whether nothing feeds or takes energy of a model."""
    m = s.loaded.model
    spent = (m.dof_damping, m.dof_frictionloss, m.tendon_damping, m.tendon_frictionloss)
    fluid = float(m.opt.density) or float(m.opt.viscosity)
    can_touch = bool(np.any(s.touching))
    held = m.neq or m.nflex or m.nu or m.nmocap or np.any(m.jnt_limited) or np.any(m.tendon_limited)
    return bool(m.nv) and not (
        held or fluid or can_touch or any(np.any(values) for values in spent)
    )


def ill_conditioned(s: Subject) -> Iterator[Hit]:
    """Rounding leaves few digits of accelerations."""
    for view in s.views:
        if view.linear is None or not len(view.linear.mass):
            continue
        root = 1 / np.sqrt(np.diag(view.linear.mass))
        condition = float(np.linalg.cond(view.linear.mass * np.outer(root, root)))
        if condition > WORST:
            yield s.about(
                "worldbody",
                message=f"the mass matrix has a condition number of {condition:.2g} in the state "
                f"{view.state.name!r}: rounding leaves {max(0.0, 16 - math.log10(condition)):.0f} "
                "digits of accelerations",
            )
            return


def idle_gravity(s: Subject) -> Iterator[Hit]:
    """Gravity that nothing feels."""
    lib, m = s.loaded.mujoco, s.loaded.model
    if not any(s.facts.options.gravity) or not m.nv:
        return
    data = lib.MjData(m)
    generator = np.random.default_rng(0)
    weight = float(np.sum(m.body_mass)) * float(np.linalg.norm(m.opt.gravity)) * s.facts.size
    for _ in range(3):
        change = generator.uniform(-1, 1, m.nv)
        data.qpos[:] = m.qpos0
        lib.mj_integratePos(m, data.qpos, change, 1.0)
        lib.mj_fwdPosition(m, data)
        data.qvel[:] = 0
        lib.mj_fwdVelocity(m, data)
        if np.max(np.abs(data.qfrc_bias)) > 1e-12 * weight:
            return
    yield s.about(
        "option",
        message=f"gravity {pair(s.facts.options.gravity)} moves no joint in any configuration",
    )

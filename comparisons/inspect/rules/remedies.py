"""Fixes with numbers: each is tried on a copy of the model, whose limit and short run must hold."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from ....reference.scene import Array
from ...checks.rules.conditions import OPENING
from ..mujoco.closures import ClosedLoop, closures
from ..mujoco.facts import integrator, integrators
from ..mujoco.model import Flags, Loaded, NotFiniteError, State
from ..mujoco.trial import edited, stays_finite
from ..subject import InspectedModel, StepLimit
from ..views import step_limit_of, view

NEAR = 0.8
"""Share of its limit from which on `near_step_limit` warns of a step."""

QUIET = NEAR - 0.01
"""Share that a recommended step has."""

MARGIN = 1.1
"""Times the timestep that a limit must have after a fix."""

PREFERRED = ("implicitfast", "implicit", "discrete", "RK4")
"""Integrators, the cheapest first."""

MOST_JOINTS, MOST_TRIES = 12, 40
"""Joints that are given armature, and values of it that are tried."""

MOST_DOFS = 60
"""With more degrees of freedom no armature is looked for."""

DAMPINGS = tuple(float(x) for x in np.geomspace(0.1, 1000.0, 13))
"""Of the inertia of a joint over the step, what is tried as damping."""

GAINS = (0.7, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001)
"""Shares of gains that are tried."""

HARDER = (0.99, 0.999, 0.9999)
"""Impedances that are tried on a closure."""

STEPS = (None, 10.0, 4.0, 2.5)
"""Time constants that are tried, in timesteps; None: that of the file."""


def rounded_up(value: float, digits: int = 2) -> float:
    """Return a number of so many digits that is not below one."""
    unit = 10.0 ** (math.floor(math.log10(value)) - digits + 1)
    return float(f"{math.ceil(value / unit * (1 - 1e-9)) * unit:.{digits}g}")


def rounded_down(value: float, digits: int = 2) -> float:
    """Return a number of so many digits that is not above one."""
    unit = 10.0 ** (math.floor(math.log10(value)) - digits + 1)
    return float(f"{math.floor(value / unit * (1 + 1e-9)) * unit:.{digits}g}")


def states_of(s: InspectedModel, name: str | None) -> list[State]:
    """Return the state of this name first, then the others that have small motions."""
    states = [one.state for one in s.views if one.linear and one.steady_hinge is None]
    return sorted(states, key=lambda state: state.name != name)


def set_option(name: str, value: Any, model: Any) -> None:
    """Set an option of a model."""
    setattr(model.opt, name, value)


def all_stay_finite(loaded: Loaded, states: Sequence[State]) -> bool:
    """Return whether short runs from the first two of these states stay finite."""
    return all(stays_finite(loaded, state) for state in states[:2])


def step_remedies(s: InspectedModel, limit: StepLimit) -> str:
    """Return what makes the file's integrator stable, the cheapest first; each was tried."""
    states = states_of(s, limit.state)
    integrators, lost = integrator_remedy(s, states)
    parts = [*integrators, *armature_remedy(s, limit)]
    parts += [*damping_remedy(s, limit), *gain_remedy(s, limit), *step_remedy(s, states)]
    return in_words(parts, lost)


def in_words(remedies: Sequence[str], lost: Sequence[str]) -> str:
    """Return remedies, and the integrators that were tried and lose the run."""
    words = "; or ".join(remedies)
    if not remedies or not lost:
        return words
    one = "it" if len(lost) == 1 else "them"
    return f"{words} (not integrator {' or '.join(lost)}: a run with {one} fails, too)"


def integrator_remedy(s: InspectedModel, states: Sequence[State]) -> tuple[list[str], list[str]]:
    """Return the cheapest other integrator that holds a run, if one does, and those that do not.

    Those whose limit the file's step keeps are tried, and all where no limit is known.
    """
    limits, lost = {one.integrator: one.limit for one in s.steps}, list[str]()
    there = limits or integrators(s.loaded)
    for name in PREFERRED:
        own = name == s.facts.options.integrator
        if name in there and not own and limits.get(name, math.inf) >= MARGIN * s.timestep:
            kind = s.loaded.member("mjtIntegrator", "mjINT", name)
            tried = edited(s.loaded, partial(set_option, "integrator", kind))
            if not all_stay_finite(tried, states):
                lost.append(f'"{name}"')
                continue
            most = limits.get(name, math.inf)
            words = "without limit" if math.isinf(most) else f"stable up to {most:.3g} s"
            small = f" ({words} in small motions)" if limits else ""
            return [f'integrator="{name}"{small}'], lost
    return [], lost


def step_remedy(s: InspectedModel, states: Sequence[State]) -> Iterator[str]:
    """Yield a shorter timestep."""
    limit = next(one for one in s.steps if one.of_file).limit
    if not 0 < limit < math.inf:
        return
    step = rounded_down(QUIET * limit)
    tried = edited(s.loaded, partial(set_option, "timestep", step))
    if step_limit_again(tried, states) >= step and all_stay_finite(tried, states):
        yield f'timestep="{step:g}"'


def step_holds(s: InspectedModel, step: float) -> bool:
    """Return True if short runs from the file's states stay finite with another timestep [s]."""
    return all_stay_finite(edited(s.loaded, partial(set_option, "timestep", step)), s.loaded.states)


def step_limit_again(loaded: Loaded, states: Sequence[State]) -> float:
    """Return the limit [s] of an edited model's own integrator."""
    limit = limit_of_own(loaded, states)
    return 0.0 if limit is None else limit.limit


def limit_of_own(loaded: Loaded, states: Sequence[State]) -> StepLimit | None:
    """Return the limit of an edited model's own integrator; None where nothing can be said."""
    views = [view(loaded, state) for state in states]
    if any(one.linear is None for one in views) or not views:
        return None
    return step_limit_of(loaded, integrator(loaded), views)


def armature_remedy(s: InspectedModel, limit: StepLimit) -> Iterator[str]:
    """Yield the armature on few joints that makes the file's step stable, if some does."""
    loaded, state = s.loaded, states_of(s, limit.state)[:1]
    names = loaded.joint_names
    if limit.constraint or limit.joint not in names or len(names) > MOST_DOFS or not state:
        return
    simple = loaded.of_kind("jnt_type", "hinge", "slide")[loaded.model.dof_jntid]
    now, dofs, value = limit, list[int](), 0.0
    for _ in range(MOST_TRIES):
        dof = names.index(str(now.joint)) if now.joint in names else -1
        if now.constraint or dof < 0 or not simple[dof] or len(dofs) > MOST_JOINTS:
            return
        if dof not in dofs:
            dofs.append(dof)
            inertia = float(s.views[0].linear.mass[dof, dof]) if s.views[0].linear else 1.0
            value = max(value, inertia * min(4.0, MARGIN * s.timestep / now.limit))
        else:
            value *= min(4.0, max(1.1, MARGIN * s.timestep / now.limit))

        def change(model: Any, value: float = value) -> None:
            model.dof_armature[dofs] = np.maximum(model.dof_armature[dofs], rounded_up(value))

        tried = edited(loaded, change)
        again = limit_of_own(tried, state)
        if again is None or again.limit <= 0:
            return
        if again.limit >= MARGIN * s.timestep:
            every = states_of(s, limit.state)
            if step_limit_again(tried, every) >= s.timestep and all_stay_finite(tried, every):
                joints = ", ".join(names[i] for i in sorted(dofs))
                plural = "joints" if len(dofs) > 1 else "joint"
                yield f'armature="{rounded_up(value):g}" on {plural} {joints}'
            return
        now = again


def damping_remedy(s: InspectedModel, limit: StepLimit) -> Iterator[str]:
    """Yield the damping with which the step is stable: of the joint that sets it, or of driven."""
    dof = dof_of(s, limit)
    if dof is None or not s.views[0].linear:
        return
    m, joints = s.model, s.model.dof_jntid
    driven = np.any(moments(s.loaded, states_of(s, limit.state)[0])[servos(s)], axis=0)
    scale = float(s.views[0].linear.mass[dof, dof]) / s.timestep
    for dofs in (joints == joints[dof], (joints == joints[dof]) | driven):
        for share in DAMPINGS:
            value = rounded_up(share * scale)

            def change(model: Any, dofs: Flags = dofs, value: float = value) -> None:
                model.dof_damping[dofs] = np.maximum(m.dof_damping[dofs], value)

            if holds(s, limit, change):
                names = dict.fromkeys(np.array(s.loaded.joint_names)[dofs].tolist())
                joint = "joint" if len(names) == 1 else "joints"
                yield f'damping="{value:g}" on {joint} {", ".join(names)}'
                return


def gain_remedy(s: InspectedModel, limit: StepLimit) -> Iterator[str]:
    """Yield how far gains of servos must fall: of those on the joint that sets it, or of all."""
    dof = dof_of(s, limit)
    if dof is None or not np.any(servos(s)):
        return
    own = servos(s) & (moments(s.loaded, states_of(s, limit.state)[0])[:, dof] != 0)
    for numbers in (own, servos(s)):
        for share in GAINS if np.any(numbers) else ():

            def change(model: Any, numbers: Flags = numbers, share: float = share) -> None:
                model.actuator_gainprm[numbers, 0] *= share
                model.actuator_biasprm[numbers, 1:3] *= share

            if holds(s, limit, change):
                names = ", ".join(s.loaded.name("actuator", i) for i in np.flatnonzero(numbers))
                yield f"{share:g} times the gains (kp, kv) of {names}"
                return


def servos(s: InspectedModel) -> Flags:
    """Return which actuators (n_u,) react to where they are, or how fast."""
    acts = np.any(s.model.actuator_biasprm[:, 1:3] != 0, axis=1)
    return np.asarray(acts & s.loaded.of_kind("actuator_biastype", "affine"))


def dof_of(s: InspectedModel, limit: StepLimit) -> int | None:
    """Return the degree of freedom that sets a limit, None where a constraint does."""
    names = s.loaded.joint_names
    if limit.constraint or limit.joint not in names or len(names) > MOST_DOFS:
        return None
    return names.index(str(limit.joint)) if states_of(s, limit.state) else None


def holds(s: InspectedModel, limit: StepLimit, change: Callable[[Any], None]) -> bool:
    """Return whether the file's step is stable after an edit: by the limit, and in short runs."""
    tried, states = edited(s.loaded, change), states_of(s, limit.state)
    if step_limit_again(tried, states[:1]) < MARGIN * s.timestep:
        return False
    return step_limit_again(tried, states) >= s.timestep and all_stay_finite(tried, states)


def moments(loaded: Loaded, state: State) -> Array:
    """Return the moment arms (n_u, n_v) of actuators in a state."""
    m, data = loaded.model, loaded.data(state)
    loaded.mujoco.mj_forward(m, data)
    arms = np.zeros((m.nu, m.nv))
    if m.nu:
        rows = data.moment_rownnz, data.moment_rowadr, data.moment_colind
        loaded.mujoco.mju_sparse2dense(arms, data.actuator_moment, *rows)
    return arms


def closure_remedy(s: InspectedModel, closure: ClosedLoop) -> str | None:
    """Return how to close a loop harder at the file's step and integrator, if that can be."""
    states = states_of(s, closure.state)
    every = {state.name: state for state in s.loaded.states}
    size = s.facts.size if closure.kind in ("connect", "weld") else 1.0
    for steps in STEPS if closure.solref[0] > 0 else STEPS[:1]:
        for hard in HARDER:
            solimp = f"{hard:g} {hard:g} 0.001"
            constant = closure.solref[0] if steps is None else steps * s.timestep
            if constant > closure.solref[0] > 0:
                continue

            def change(model: Any, constant: float = constant, hard: float = hard) -> None:
                model.eq_solref[closure.number, 0] = constant
                model.eq_solimp[closure.number, :3] = hard, hard, 0.001

            tried = edited(s.loaded, change)
            try:
                again = closures(tried, every[closure.state])
            except (NotFiniteError, np.linalg.LinAlgError):
                return None
            one = next(one for one in again if one.number == closure.number)
            if one.opening > OPENING * size or (one.turn or 0.0) > OPENING:
                continue
            stable = not states or step_limit_again(tried, states) >= MARGIN * s.timestep
            if stable and all_stay_finite(tried, states or list(every.values())):
                solref = f"{constant:g} {closure.solref[1]:g}"
                return f'solref="{solref}" solimp="{solimp}": it opens by {one.opening:.2g} then'
    return None

"""Fixes with numbers: each is tried on a copy of the model, whose limit and short run must hold."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import chain, islice, product
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

MOST_DOFS = 60
"""With more degrees of freedom no settings of joints and servos are looked for."""

SHARES = tuple(float(x) for x in np.geomspace(0.1, 1000.0, 24))
"""Of the inertia of a joint, what is tried as armature; over the step, as damping."""

GAINS = (0.7, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001)
"""Shares of gains that are tried."""

HARDER = (0.99, 0.999, 0.9999)
"""Impedances that are tried on a closure."""

STEPS = (None, 10.0, 4.0, 2.5)
"""Time constants that are tried, in timesteps; None: that of the file."""

Edit = tuple[str, Callable[[Any], None]]
"""A change of a ``MjModel``, and how the file says it."""


def rounded(value: float, up: bool, digits: int = 2) -> float:
    """Return the next number of so many digits that is not below, or not above, a value."""
    unit = 10.0 ** (math.floor(math.log10(value)) - digits + 1)
    whole = math.ceil(value / unit * (1 - 1e-9)) if up else math.floor(value / unit * (1 + 1e-9))
    return float(f"{whole * unit:.{digits}g}")


def option(name: str, value: Any) -> Callable[[Any], None]:
    """Return the change of an option of a model."""
    return lambda model: setattr(model.opt, name, value)


def joint_edits(s: InspectedModel, name: str, dofs: Flags, scale: float) -> Iterator[Edit]:
    """Yield values of ``armature`` or ``damping`` of degrees of freedom (nv,), the least first."""
    joints = list(dict.fromkeys(np.array(s.loaded.joint_names)[dofs].tolist()))
    where = f"{'joint' if len(joints) == 1 else 'joints'} {', '.join(joints)}"
    for value in (rounded(share * scale, up=True) for share in SHARES):

        def change(model: Any, value: float = value) -> None:
            values = getattr(model, f"dof_{name}")
            values[dofs] = np.maximum(values[dofs], value)

        yield f'{name}="{value:g}" on {where}', change


def gain_edits(s: InspectedModel, actuators: Flags) -> Iterator[Edit]:
    """Yield shares of the gains of some servos (nu,), the largest first."""
    names = ", ".join(s.loaded.name("actuator", i) for i in np.flatnonzero(actuators))
    for share in GAINS if np.any(actuators) else ():

        def change(model: Any, share: float = share) -> None:
            model.actuator_gainprm[actuators, 0] *= share
            model.actuator_biasprm[actuators, 1:3] *= share

        yield f"{share:g} times the gains (kp, kv) of {names}", change


def step_remedies(s: InspectedModel, limit: StepLimit) -> str:
    """Return the edits that make the file's integrator stable, cheapest first; each was tried.

    Settings are those of the joint that sets the limit, or of it and all that servos drive.
    """
    states, linear = states_of(s, limit.state), s.views[0].linear
    parts, lost = integrator_remedy(s, states)
    names = s.loaded.joint_names
    known = limit.joint in names and not limit.constraint and len(names) <= MOST_DOFS
    if known and states and linear is not None:
        dof, joints = names.index(str(limit.joint)), s.model.dof_jntid
        own, acts = joints == joints[dof], servos(s)
        arms, inertia = moments(s.loaded, states[0]), float(linear.mass[dof, dof])
        both = own, own | np.any(arms[acts], axis=0)
        kinds = [
            [joint_edits(s, "armature", dofs, inertia) for dofs in both],
            [joint_edits(s, "damping", dofs, inertia / s.timestep) for dofs in both],
            [gain_edits(s, acts & (arms[:, dof] != 0)), gain_edits(s, acts)],
        ]
        for kind in kinds:
            edits = (words for words, change in chain(*kind) if holds(s, states, change))
            parts += [words for words in islice(edits, 1)]
    file_limit = next(one for one in s.steps if one.of_file).limit
    if 0 < file_limit < math.inf:
        step = rounded(QUIET * file_limit, up=False)
        if holds(s, states, option("timestep", step), margin=1.0):
            parts.append(f'timestep="{step:g}"')
    return in_words(parts, lost)


def holds(
    s: InspectedModel,
    states: Sequence[State],
    change: Callable[[Any], None],
    margin: float = MARGIN,
) -> bool:
    """Return True if the step is stable after an edit: by its limit, and in short runs.

    Parameters
    ----------
    s : InspectedModel
    states : sequence of State
        The one whose limit must be ``margin`` steps, and others that must permit the step.
    change : callable
    margin : float
    """
    tried = edited(s.loaded, change)
    step = float(tried.model.opt.timestep)
    if step_limit_again(tried, states[:1]) < margin * step:
        return False
    return step_limit_again(tried, states) >= step and all_stay_finite(tried, states)


def step_limit_again(loaded: Loaded, states: Sequence[State]) -> float:
    """Return the limit [s] of an edited model's own integrator; 0 where nothing can be said."""
    views = [view(loaded, state) for state in states]
    if any(one.linear is None for one in views) or not views:
        return 0.0
    return step_limit_of(loaded, integrator(loaded), views).limit


def states_of(s: InspectedModel, name: str | None) -> list[State]:
    """Return the state of this name first, then the others that have small motions."""
    states = [one.state for one in s.views if one.linear and one.steady_hinge is None]
    return sorted(states, key=lambda state: state.name != name)


def all_stay_finite(loaded: Loaded, states: Sequence[State]) -> bool:
    """Return whether short runs from the first two of these states stay finite."""
    return all(stays_finite(loaded, state) for state in states[:2])


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
            tried = edited(s.loaded, option("integrator", kind))
            if not all_stay_finite(tried, states):
                lost.append(f'"{name}"')
                continue
            most = limits.get(name, math.inf)
            words = "without limit" if math.isinf(most) else f"stable up to {most:.3g} s"
            small = f" ({words} in small motions)" if limits else ""
            return [f'integrator="{name}"{small}'], lost
    return [], lost


def servos(s: InspectedModel) -> Flags:
    """Return which actuators (n_u,) react to where they are, or how fast."""
    acts = np.any(s.model.actuator_biasprm[:, 1:3] != 0, axis=1)
    return np.asarray(acts & s.loaded.of_kind("actuator_biastype", "affine"))


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
    constants = [closure.solref[0] if x is None else x * s.timestep for x in STEPS]
    for constant, hard in product(constants if closure.solref[0] > 0 else constants[:1], HARDER):
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
            solref, solimp = f"{constant:g} {closure.solref[1]:g}", f"{hard:g} {hard:g} 0.001"
            return f'solref="{solref}" solimp="{solimp}": it opens by {one.opening:.2g} then'
    return None

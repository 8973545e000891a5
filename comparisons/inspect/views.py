"""Small motions of a model in the states of its file, and the steps that they allow."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np

from ...reference.errors import UsageError
from ...reference.scene import Array
from .mujoco.facts import integrator, integrators
from .mujoco.linear import linearise
from .mujoco.model import OPENED, Flags, Loaded, NotFiniteError, State
from .mujoco.steady import steady_rotation
from .spectrum import SCHEMES, SHORT, WHOLE_UP_TO, Shape, longest_step, shapes
from .subject import StepLimit, View

MOST_DOFS = 120
"""With more degrees of freedom, modes are computed only if asked for."""

MOST_STATES = 8
"""States whose modes are computed."""

RK4_REAL = 2.785293563405282
"""Up to this times its time constant RK4 keeps a decay bounded."""


def state_views(
    loaded: Loaded, about_rotation: Mapping[str, float | str] | None, modes: bool | None
) -> tuple[View, ...]:
    """Return the states of a model with their modes; see `inspect`.

    Raises
    ------
    UsageError
        If there is no such rotation.
    """
    reasons = [why_no_modes(loaded, state, modes) for state in loaded.states[:MOST_STATES]]
    reasons += [f"modes are found of the first {MOST_STATES} states"] * len(loaded.states)
    views = [
        view(loaded, state) if reason is None else View(state, reason=reason)
        for state, reason in zip(loaded.states, reasons, strict=False)
    ]
    about_rotation = about_rotation or {}
    if len(about_rotation) > 1:
        raise UsageError("one hinge can turn steadily, not several")
    views += [
        view(loaded, steady_rotation(loaded, joint, speed), joint)
        for joint, speed in about_rotation.items()
    ]
    return tuple(views)


def view(loaded: Loaded, state: State, steady_hinge: str | None = None) -> View:
    """Return a state with its modes, or why it has none."""
    try:
        linear = linearise(loaded, state)
    except NotFiniteError as error:
        return View(state, reason=str(error), failed=True)
    except np.linalg.LinAlgError as error:
        return View(state, reason=f"the mass matrix cannot be solved with ({error})", failed=True)
    if linear.closed and np.any(state.velocity):
        return View(state, reason="closed loops move: their small motions are not constant")
    moving = np.eye(loaded.model.nv)[:, moving_dofs(View(state, steady_hinge=steady_hinge))]
    free = linear.free if steady_hinge is None else moving
    modes = modes_within(free, linear.mass, linear.damping, linear.stiffness)
    step = float(loaded.model.opt.timestep)
    mass, damping, stiffness, *_ = linear.simulated.motion(integrator(loaded), step)
    soft = len(linear.rows.weight) or linear.closed
    simulated = modes_within(moving, mass, damping, stiffness) if soft else modes
    return View(state, linear, modes, simulated, steady_hinge=steady_hinge)


def why_no_modes(loaded: Loaded, state: State, wanted: bool | None) -> str | None:
    """Return why modes of a state are not computed, if they are not."""
    nv, ball = loaded.model.nv, loaded.of_kind("jnt_type", "free", "ball")
    if nv == 0:
        return "nothing can move"
    if wanted is False:
        return "not asked for"
    if wanted is None and nv > MOST_DOFS:
        return f"{nv} degrees of freedom (--modes finds them)"
    if loaded.model.nflex and nv > MOST_DOFS:
        return "a flex of that many degrees of freedom"
    ends = np.append(loaded.model.jnt_dofadr, nv)[1:][ball]
    if any(np.any(state.velocity[end - 3 : end]) for end in ends):
        return "a ball or free joint turns: its small motions are not constant"
    return None


def modes_within(
    directions: Array, mass: Array, damping: Array, stiffness: Array
) -> tuple[Shape, ...]:
    """Return the modes of motions that are sums of directions (n, k)."""
    inner = (directions.T @ matrix @ directions for matrix in (mass, damping, stiffness))
    return tuple(mode._replace(vector=directions @ mode.vector) for mode in shapes(*inner))


def step_limits(loaded: Loaded, views: Sequence[View]) -> tuple[StepLimit, ...]:
    """Return the largest stable step of each integrator, and where it is least."""
    states = [one for one in views if one.linear is not None]
    known: dict[tuple[object, ...], tuple[float, Shape | None]] = {}
    return tuple(
        step_limit_of(loaded, name, states, known)
        for name in (integrators(loaded) if states else ())
    )


def step_limit_of(
    loaded: Loaded,
    name: str,
    views: Sequence[View],
    known: dict[tuple[object, ...], tuple[float, Shape | None]] | None = None,
) -> StepLimit:
    """Return the largest stable step of one integrator in states that have small motions.

    Parameters
    ----------
    loaded : Loaded
    name : str
        Of the integrator.
    views : sequence of View
    known : dict, optional
        Steps that were found for integrators that take the same late; it is added to.
    """
    known = {} if known is None else known
    own = name == integrator(loaded)
    best = StepLimit(name, math.inf, None, None, None, own)
    for one, sliding in product(views, (False, True)):
        assert one.linear is not None
        simulated = one.linear.simulated
        if sliding and not np.any(simulated.rows.dry):
            continue  # where dry friction holds nothing, it is the same
        at, raised = partial(simulated.motion, name, sliding=sliding), simulated.raised_from(name)
        motion, modes = at(SHORT), one.simulated
        key = (SCHEMES[name], id(one), sliding, raised, *(part.tobytes() for part in motion[3:]))
        if sliding or (raised < np.inf and len(motion.mass) > WHOLE_UP_TO):
            moves = np.eye(len(motion.mass))[:, moving_dofs(one)]
            modes = modes_within(moves, motion.mass, motion.damping, motion.stiffness)
        if key not in known:
            known[key] = longest_step(name, at, modes, raised)
        limit, mode = known[key]
        if limit < best.limit:
            best = StepLimit(name, limit, one.state.name, None, None, own)
            if mode is not None:
                row = simulated.setting_row(mode.vector, mode.omega, sliding)
                joint = loaded.joint_names[mode.place(simulated.mass)]
                best = replace(best, omega=mode.omega, joint=joint, constraint=row)
    best = min(best, activation_limit(loaded, name, own), key=lambda limit: limit.limit)
    raised_from = [one.linear.simulated.raised_from(name) for one in views if one.linear]
    return replace(best, softened=min(raised_from, default=math.inf))


def moving_dofs(view: View) -> Flags:
    """Return which degrees of freedom (nv,) small motions have: a steady hinge keeps its speed."""
    return np.asarray((view.state.velocity == 0) | (view.steady_hinge is None))


def activation_limit(loaded: Loaded, name: str, own: bool) -> StepLimit:
    """Return the largest step at which filters of actuators are stable: 2 T for Euler's steps."""
    m = loaded.model
    filters = loaded.of_kind("actuator_dyntype", "filter") & (m.actuator_dynprm[:, 0] > 0)
    if not np.any(filters):
        return StepLimit(name, math.inf, None, None, None, own)
    number = int(np.argmin(np.where(filters, m.actuator_dynprm[:, 0], np.inf)))
    constant = float(m.actuator_dynprm[number, 0])
    times = RK4_REAL if SCHEMES[name] == "RK44" else 2.0
    state, place = OPENED, f"activation of {loaded.name('actuator', number)}"
    return StepLimit(name, times * constant, state, 1 / constant, place, own)

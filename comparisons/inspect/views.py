"""How a model moves: the modes of its states, its stable steps, its shortest period, its loops."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress

import numpy as np

from ...reference.errors import UsageError
from ...reference.scene import Array
from .mujoco.closures import Closure, closures
from .mujoco.facts import integrator
from .mujoco.linear import linearise
from .mujoco.model import Loaded, NotFiniteError, State
from .mujoco.steady import steady_rotation
from .spectrum import SCHEMES, Shape, Step, longest_step, shapes
from .subject import StepLimit, View

MOST_DOFS = 120
"""With more degrees of freedom, modes are computed only if asked for."""

MOST_STATES = 8
"""States whose modes are computed."""

OSCILLATING = 1.0
"""Modes whose damping ratio is below this have a period to speak of."""


def state_views(
    loaded: Loaded, about_rotation: Mapping[str, float | str] | None, modes: bool | None
) -> tuple[View, ...]:
    """Return the states of a model with their modes; see `inspection.inspect`.

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
    if about_rotation and len(about_rotation) > 1:
        raise UsageError("one hinge can turn steadily, not several")
    for joint, speed in (about_rotation or {}).items():
        views.append(view(loaded, steady_rotation(loaded, joint, speed), joint))
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
    moves = (state.velocity == 0) | (steady_hinge is None)  # a steady hinge keeps its speed
    moving = np.eye(loaded.model.nv)[:, moves]
    free = linear.free if steady_hinge is None else moving
    modes = modes_within(free, linear.mass, linear.damping, linear.stiffness)
    mass, damping, stiffness, *_ = next(iter(linear.simulated.values()))
    soft = linear.rows or linear.closed
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
    states = [(one, one.linear) for one in views if one.linear is not None]
    limits, known = [], dict[tuple[object, ...], Step]()
    for name in states[0][1].simulated if states else ():
        if not hasattr(loaded.mujoco.mjtIntegrator, f"mjINT_{name.upper()}"):
            continue
        steps = []
        for one, linear in states:
            motion = linear.simulated[name]
            key = (SCHEMES[name], id(one), *(part.tobytes() for part in motion[3:]))
            if key not in known:
                known[key] = longest_step(name, motion, one.simulated)
            steps.append((known[key], one))
        least, where = min(steps, key=lambda item: item[0].limit)
        limits.append(
            StepLimit(
                integrator=name,
                limit=least.limit,
                state=where.state.name if math.isfinite(least.limit) else None,
                omega=least.omega,
                joint=None if least.place is None else loaded.joint_names[least.place],
                of_file=name == integrator(loaded),
            )
        )
    return tuple(limits)


def shortest_period(views: Sequence[View]) -> float | None:
    """Return the shortest period of all modes as simulated [s]; None if nothing oscillates."""
    rates = [
        mode.rate.imag
        for one in views
        for mode in one.simulated
        if mode.rate.imag > 0 and (mode.damping_ratio or 0.0) < OSCILLATING
    ]
    return 2 * math.pi / max(rates) if rates else None


def all_closures(loaded: Loaded) -> tuple[Closure, ...]:
    """Return the closures in all states, stiffest first, those that open most before others."""
    every: list[Closure] = []
    for state in loaded.states[:MOST_STATES]:
        with suppress(NotFiniteError, np.linalg.LinAlgError):
            every += closures(loaded, state)
    return tuple(sorted(every, key=lambda one: (-one.omega, -one.opening)))

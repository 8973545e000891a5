"""Rules about motions that grow of themselves, whatever the step."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ....reference.scene import Array
from ..mujoco.linear import Linear
from ..mujoco.model import OPENED, State
from ..mujoco.trial import edited, failing_step, growth, stays_finite
from ..spectrum import Shape
from ..subject import Hit, InspectedModel, View
from ..views import view
from .remedies import integrator_remedy, moments, rounded_down, rounded_up, set_option

SLOWEST = 0.2
"""Growth [1/s] below which nothing is said: a run of seconds does not show it."""

FOLDS = 4.0
"""Times by which a mode may grow by e in the run that shows it; half of that must be seen."""

FED = 0.5
"""Share of the power that feeds a mode from which on an actuator or a damper is to blame."""

MOST_RUNS = 2
"""States from which a run is tried."""

MOST_DOFS = 60
"""With more degrees of freedom none is."""

SHORTER = (0.5, 0.2, 0.1)
"""Of the file's timestep, what is tried where a run fails."""

UNKNOWN = (
    "no integrator and no shorter step that was tried goes on: look for what is stiff or light"
)

STEPS_PER_RADIAN = 40.0
"""Steps of the runs that show growth."""

REST = 1e-3
"""Share of gravity, or [m/s^2, rad/s^2], by which a state of rest may accelerate."""

CONCERNED = 0.3
"""Share of the largest power from which on an actuator is named."""


class Feeding(NamedTuple):
    """Mean power that feeds a mode, and the share of it that springs and gravity do not give."""

    total: float
    foreign: float


def feeding(linear: Linear, mode: Shape) -> Feeding:
    """Return what feeds a mode.

    Of ``f = -C v - K q``, a symmetric K that is negative gives what it gives by itself; a
    negative C and the rotational part of K feed in each cycle.
    """
    parts, rate = linear.simulated.parts, mode.rate
    gravity = linear.stiffness - parts.servo
    circulation = power_of(skew(parts.servo), mode, rate.conjugate())
    damping = [
        power_of(symmetric(matrix), mode, abs(rate) ** 2)
        for matrix in (parts.actuator, parts.passive)
    ]
    servo = power_of(symmetric(parts.servo), mode, rate.real)
    own = power_of(symmetric(gravity), mode, rate.real)
    foreign = sum(max(0.0, value) for value in (circulation, *damping, servo))
    return Feeding(foreign + max(0.0, own), foreign)


def symmetric(matrix: Array) -> Array:
    """Return the symmetric part."""
    return np.asarray((matrix + matrix.T) / 2)


def skew(matrix: Array) -> Array:
    """Return the antisymmetric part."""
    return np.asarray((matrix - matrix.T) / 2)


def power_of(matrix: Array, mode: Shape, factor: complex) -> float:
    """Return the mean power of forces ``-factor matrix q`` on a mode."""
    return float(-np.real(factor * np.vdot(mode.vector, matrix @ mode.vector)))


def growing(view: View) -> list[Shape]:
    """Return the modes, constraints as they act, that grow fast enough to be seen."""
    return [
        mode
        for mode in view.simulated
        if mode.kind == "unstable" and mode.rate.real > SLOWEST and view.steady_hinge is None
    ]


def fed_by_drive(view: View) -> Iterator[Shape]:
    """Yield the modes that grow, and that gravity and springs do not feed for the most part."""
    for mode in growing(view):
        assert view.linear is not None
        fed = feeding(view.linear, mode)
        if fed.foreign > FED * fed.total:
            yield mode


def unstable_mode(s: InspectedModel) -> Iterator[Hit]:
    """A mode that an actuator or a damper feeds."""
    said = set[str]()
    for one in s.views:
        for mode in fed_by_drive(one):
            linear = one.linear
            assert linear is not None
            joint = s.loaded.joint_names[mode.place(linear.mass)]
            if joint in said or not seen(s, one, mode):
                continue
            said.add(joint)
            actuators = feeders(s, one, mode)
            source = f"actuators {', '.join(actuators)}" if actuators else "negative damping"
            swing = f" and oscillates at {mode.rate.imag:.4g} rad/s" if mode.rate.imag else ""
            message = (
                f"in the state {one.state.name!r} a motion of {joint} grows by e in "
                f"{1 / mode.rate.real:.3g} s ({mode.rate.real:.3g} 1/s){swing}, whatever the step: "
                f"{source} feed it"
            )
            number = int(s.model.dof_jntid[mode.place(linear.mass)])
            fix = damping_remedy(s, one, number) or (
                "turn the sign of the gain, or of the gear" if actuators else "turn its sign"
            )
            yield s.hit("joint", number, message)._replace(fix=fix)


def seen(s: InspectedModel, view: View, mode: Shape) -> bool:
    """Return whether a run shows that a mode grows."""
    direction = np.real(mode.vector)
    step = min(s.timestep, 1 / (STEPS_PER_RADIAN * max(one.omega for one in view.simulated)))
    horizon = FOLDS / mode.rate.real
    return growth(s.loaded, view.state, direction, step, horizon) > np.exp(FOLDS / 2)


def feeders(s: InspectedModel, view: View, mode: Shape) -> list[str]:
    """Return the actuators that push along a mode, and react to where it is."""
    m = s.model
    reacts = s.loaded.of_kind("actuator_biastype", "affine", "muscle") & np.any(
        m.actuator_biasprm[:, 1:3] != 0, axis=1
    )
    power = np.abs(moments(s.loaded, view.state) @ mode.vector) * reacts
    large = np.flatnonzero(power > CONCERNED * np.max(power, initial=0.0))
    return [s.loaded.name("actuator", number) for number in large]


def damping_remedy(s: InspectedModel, one: View, joint: int) -> str | None:
    """Return the damping of a joint with which no mode grows there, if some does it."""
    m, linear = s.model, one.linear
    assert linear is not None
    dofs = np.flatnonzero(m.dof_jntid == joint)
    scale = float(np.max(np.diag(linear.mass)[dofs])) * max(mode.omega for mode in growing(one))
    for share in np.geomspace(0.01, 100, 17):
        value = rounded_up(share * scale)

        def change(model: Any, value: float = value) -> None:
            model.dof_damping[dofs] = value

        tried = edited(s.loaded, change)
        again = view(tried, one.state)
        if again.linear is not None and not growing(again):
            damped = max(again.simulated, key=lambda mode: mode.rate.real)
            step = min(s.timestep, 1 / (STEPS_PER_RADIAN * max(x.omega for x in again.simulated)))
            horizon = FOLDS / max(mode.rate.real for mode in growing(one))
            if growth(tried, one.state, np.real(damped.vector), step, horizon) < np.exp(1):
                return f'damping="{value:g}" on joint {s.loaded.name("joint", joint)}'
    return None


def run_fails(s: InspectedModel) -> Iterator[Hit]:
    """A run from a state of the file that leaves the range of numbers, whatever the reason."""
    beyond = any(limit.share_of(s.timestep) > 1 for limit in s.limits_of_file)
    beyond |= any(view.failed or any(fed_by_drive(view)) for view in s.views)
    if beyond or s.model.nv > MOST_DOFS:  # other rules say it, and what to do
        return
    named = [one for one in s.loaded.states if one.keys != (OPENED,)]
    for state in (named or list(s.loaded.states))[:MOST_RUNS]:
        step = failing_step(s.loaded, state)
        if step is None:
            continue
        spins = [view.reason for view in s.views if view.state is state and view.reason]
        why = f" ({spins[0]})" if spins else ""
        message = (
            f"a run from the state {state.name!r}, controls held, leaves the range of numbers in "
            f"step {step}, at {step * s.timestep:.3g} s{why}"
        )
        fixes = [*integrator_remedy(s, [state]), *shorter_step(s, state)]
        yield s.about("option", message=message, fix="; or ".join(fixes) or UNKNOWN)
        return


def shorter_step(s: InspectedModel, state: State) -> Iterator[str]:
    """Yield a timestep with which the run goes on."""
    for share in SHORTER:
        step = rounded_down(share * s.timestep)
        if stays_finite(edited(s.loaded, partial(set_option, "timestep", step)), state):
            yield f'timestep="{step:g}"'
            return


def unstable_equilibrium(s: InspectedModel) -> Iterator[Hit]:
    """A state of rest that is a maximum of the potential."""
    gravity = float(np.linalg.norm(s.facts.options.gravity))
    for one in s.views:
        linear, modes = one.linear, growing(one)
        if linear is None or linear.contacts or not modes:
            continue
        if np.max(np.abs(linear.acceleration)) > REST * max(1.0, gravity):
            continue
        mode = max(modes, key=lambda mode: mode.rate.real)
        fed = feeding(linear, mode)
        if fed.foreign > FED * fed.total:
            continue
        number = int(s.model.dof_jntid[mode.place(linear.mass)])
        message = (
            f"the state {one.state.name!r} is at rest like a pendulum that stands: a motion of "
            f"{s.loaded.name('joint', number)} grows by e in {1 / mode.rate.real:.3g} s"
        )
        yield s.hit("joint", number, message)

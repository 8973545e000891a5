"""Rules about motions that grow of themselves, whatever the step."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import islice
from typing import Any

import numpy as np

from ....reference.scene import Array
from ..mujoco.facts import Facts
from ..mujoco.linear import Linear
from ..mujoco.model import OPENED
from ..mujoco.trial import MOST_STEPS, edited, growth, short_run, stays_finite
from ..spectrum import Shape
from ..subject import Hit, InspectedModel, View
from ..views import view
from .drives import drives, sign_attribute
from .remedies import in_words, integrator_remedy, joint_edits, moments, option, rounded

SLOWEST = 0.2
"""Growth [1/s] below which nothing is said: a run of seconds does not show it."""

FOLDS = 4.0
"""Times by which a mode may grow by e in the run that shows it; half of that must be seen."""

SLOW = 0.1
"""Of the rate of a mode that grows, what is the unit of the damping that is tried."""

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

STEPS_PER_RADIAN, FEWEST = 40.0, 2.0
"""Steps of the runs that show growth, and the fewest in a radian of modes that do not grow: Runge
and Kutta's method is stable up to 2.78 radians a step, so it feeds none of these."""

REST = 1e-3
"""Share of gravity, or [m/s^2, rad/s^2], by which a state of rest may accelerate."""

CONCERNED = 0.3
"""Share of the largest power from which on an actuator is named."""


def is_fed_by_drive(linear: Linear, mode: Shape) -> bool:
    """Return True if an actuator or a damper gives most of the mean power that feeds a mode.

    Of ``f = -C v - K q``, a symmetric K that is negative gives what it gives by itself; a
    negative C and the rotational part of K feed in each cycle.
    """
    parts, rate = linear.simulated.parts, mode.rate

    def product(matrix: Array) -> complex:
        """Real by the symmetric part of a matrix, imaginary by the rotational one."""
        return complex(np.vdot(mode.vector, matrix @ mode.vector))

    servo = product(parts.servo)
    powers = [
        -(rate.conjugate() * 1j * servo.imag).real,
        -(abs(rate) ** 2) * product(parts.actuator).real,
        -(abs(rate) ** 2) * product(parts.passive).real,
        -rate.real * servo.real,
    ]
    foreign = sum(max(0.0, power) for power in powers)
    own = max(0.0, -rate.real * product(linear.stiffness - parts.servo).real)
    return foreign > FED * (foreign + own)


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
        if view.linear is not None and is_fed_by_drive(view.linear, mode):
            yield mode


def unstable_mode(s: InspectedModel) -> Iterator[Hit]:
    said = set[str]()
    for one in s.views:
        for mode in fed_by_drive(one):
            linear = one.linear
            assert linear is not None
            joint = s.loaded.joint_names[mode.place(linear.mass)]
            if joint in said or not grows_in_run(s, one, mode):
                continue
            said.add(joint)
            fed_by = feeders(s, one, mode)
            actuators = ", ".join(s.loaded.name("actuator", i) for i in fed_by)
            source = f"actuators {actuators} feed" if actuators else "negative damping feeds"
            swing = f" and oscillates at {mode.rate.imag:.4g} rad/s" if mode.rate.imag else ""
            message = (
                f"in the state {one.state.name!r} a motion of {joint} grows by e in "
                f"{1 / mode.rate.real:.3g} s ({mode.rate.real:.3g} 1/s){swing}, whatever the step: "
                f"{source} it"
            )
            number = int(s.model.dof_jntid[mode.place(linear.mass)])
            fix = sign_remedy(s, one, fed_by) or damping_remedy(s, one, number)
            fix = fix or (
                "turn the sign of the gain, or of the gear" if actuators else "turn its sign"
            )
            yield s.hit("joint", number, message, fix=fix)


def grows_in_run(s: InspectedModel, view: View, mode: Shape) -> bool:
    """Return whether a run shows that a mode grows."""
    horizon = FOLDS / mode.rate.real
    step = step_of_run(view, mode, s.timestep, horizon)
    if step is None:
        return False
    return growth(s.loaded, view.state, np.real(mode.vector), step, horizon) > np.exp(FOLDS / 2)


def step_of_run(view: View, mode: Shape, timestep: float, horizon: float) -> float | None:
    """Return the step [s] of a run that shows what a mode does; None if it takes too many.

    All modes have `STEPS_PER_RADIAN` if there is time for that, else this one has, and all others
    `FEWEST`.
    """
    fastest = max(one.omega for one in view.simulated)
    finest = min(timestep, 1 / (STEPS_PER_RADIAN * fastest))
    longest = min(timestep, 1 / max(STEPS_PER_RADIAN * mode.omega, FEWEST * fastest))
    step = max(finest, horizon / MOST_STEPS)
    return step if step <= longest else None


def feeders(s: InspectedModel, view: View, mode: Shape) -> list[int]:
    """Return the numbers of the actuators that push along a mode, and react to where it is."""
    m = s.model
    reacts = s.loaded.of_kind("actuator_biastype", "affine", "muscle") & np.any(
        m.actuator_biasprm[:, 1:3] != 0, axis=1
    )
    power = np.abs(moments(s.loaded, view.state) @ mode.vector) * reacts
    large: list[int] = np.flatnonzero(power > CONCERNED * np.max(power, initial=0.0)).tolist()
    return large


def ends_growth(s: InspectedModel, one: View, change: Callable[[Any], None]) -> bool:
    """Return whether no mode grows in a state after an edit: by the modes, and in a run."""
    tried = edited(s.loaded, change)
    again = view(tried, one.state)
    if again.linear is None or growing(again):
        return False
    slowest = max(again.simulated, key=lambda mode: mode.rate.real)
    horizon = FOLDS / max(mode.rate.real for mode in growing(one))
    step = step_of_run(again, slowest, s.timestep, horizon)
    if step is None:
        return False
    return growth(tried, one.state, np.real(slowest.vector), step, horizon) < np.exp(1)


def sign_remedy(s: InspectedModel, one: View, feeding: Sequence[int]) -> str | None:
    """Return the attributes of actuators whose sign is to be turned, if that ends the growth."""
    wrong = [
        (servo.actuator, column, sign_attribute(s, servo.actuator, what))
        for servo in drives(s)
        for column, what, resists in ((1, "position", servo.stiffness), (2, "speed", servo.damping))
        if servo.actuator in feeding and resists < 0
    ]

    def change(model: Any) -> None:
        for actuator, column, _ in wrong:
            model.actuator_biasprm[actuator, column] *= -1

    if not wrong or not ends_growth(s, one, change):
        return None
    return "turn the sign of " + " and ".join(
        f"{attribute} of {s.loaded.name('actuator', actuator)}" for actuator, _, attribute in wrong
    )


def damping_remedy(s: InspectedModel, one: View, joint: int) -> str | None:
    """Return the damping of a joint with which no mode grows there, if some does it."""
    assert one.linear is not None
    dofs = s.model.dof_jntid == joint
    inertia = float(np.max(np.diag(one.linear.mass)[dofs]))
    edits = joint_edits(s, "damping", dofs, SLOW * inertia * max(m.omega for m in growing(one)))
    return next((words for words, change in edits if ends_growth(s, one, change)), None)


def run_fails(s: InspectedModel) -> Iterator[Hit]:
    beyond = any(limit.share_of(s.timestep) > 1 for limit in s.limits_of_file)
    beyond |= any(view.failed or any(fed_by_drive(view)) for view in s.views)
    if beyond or s.model.nv > MOST_DOFS:  # other rules say it, and what to do
        return
    named = [one for one in s.loaded.states if one.keys != (OPENED,)]
    for state in (named or list(s.loaded.states))[:MOST_RUNS]:
        step, _ = short_run(s.loaded, state)
        if step is None:
            continue
        spins = [view.reason for view in s.views if view.state is state and view.reason]
        why = f" (no modes: {spins[0]})" if spins else ""
        message = (
            f"a run from the state {state.name!r}, controls held, leaves the range of numbers in "
            f"step {step}, at {step * s.timestep:.3g} s{why}"
        )
        fixes, lost = integrator_remedy(s, [state])
        shorter = (rounded(share * s.timestep, up=False) for share in SHORTER)
        holding = (
            x for x in shorter if stays_finite(edited(s.loaded, option("timestep", x)), state)
        )
        fixes += [f'timestep="{step:g}"' for step in islice(holding, 1)]
        yield s.about("option", message=message, fix=in_words(fixes, lost) or UNKNOWN)
        return


def rests(view: View, facts: Facts) -> bool:
    """Return whether a state with small motions is one of rest."""
    assert view.linear is not None
    gravity = float(np.linalg.norm(facts.options.gravity))
    return bool(np.max(np.abs(view.linear.acceleration)) <= REST * max(1.0, gravity))


def unstable_equilibrium(s: InspectedModel) -> Iterator[Hit]:
    for one in s.views:
        linear, modes = one.linear, growing(one)
        if linear is None or linear.rows.contacts or not modes or not rests(one, s.facts):
            continue
        mode = max(modes, key=lambda mode: mode.rate.real)
        if is_fed_by_drive(linear, mode):
            continue
        number = int(s.model.dof_jntid[mode.place(linear.mass)])
        message = (
            f"the state {one.state.name!r} is at rest like a pendulum that stands: a motion of "
            f"{s.loaded.name('joint', number)} grows by e in {1 / mode.rate.real:.3g} s"
        )
        yield s.hit("joint", number, message)

"""Growing motions of a model, whatever the step: their cause, and runs that confirm them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...reference.scene import Array
from ..engines.isolation import tell
from .mujoco.linear import Linear
from .mujoco.model import Loaded, State
from .tuning import NUMERICS, THRESHOLDS
from .views import Shape, View


def is_fed_by_drive(linear: Linear, mode: Shape) -> bool:
    """Return True if an actuator or a damper supplies most of the mean power fed into a mode.

    In ``f = -C v - K q`` a negative symmetric K feeds a mode that diverges; a negative C and the
    skew part of K feed it in each cycle.
    """
    parts, rate = linear.parts, mode.rate

    def product(matrix: Array) -> complex:
        """Real part by the symmetric part of a matrix, imaginary part by the skew one."""
        return complex(np.vdot(mode.vector, matrix @ mode.vector))

    servo = product(parts.servo)
    powers = [
        -(rate.conjugate() * 1j * servo.imag).real,
        -(abs(rate) ** 2) * product(parts.actuator).real,
        -(abs(rate) ** 2) * product(parts.passive).real,
        -rate.real * servo.real,
    ]
    foreign = sum(max(0.0, power) for power in powers)
    own = max(0.0, -rate.real * product(parts.stiffness - parts.servo).real)
    return foreign > THRESHOLDS.fed_share * (foreign + own)


def growing(view: View) -> list[Shape]:
    """Return the modes, with soft constraints, that grow fast enough to be seen in a run."""
    return [
        mode
        for mode in view.simulated
        if mode.kind == "unstable"
        and mode.rate.real > THRESHOLDS.min_growth
        and view.steady_hinge is None
    ]


def fed_by_drive(view: View) -> Iterator[Shape]:
    """Yield the growing modes that drives or dampers feed, rather than gravity and springs."""
    for mode in growing(view):
        if view.linear is not None and is_fed_by_drive(view.linear, mode):
            yield mode


def fed_growth(loaded: Loaded, views: Sequence[View]) -> Iterator[tuple[View, Shape]]:
    """Yield a mode of each joint that drives or dampers feed and that a run shows to grow."""
    joints, folds = set[str](), THRESHOLDS.growth_folds
    for view in views:
        for mode in fed_by_drive(view):
            joint = loaded.joint_names[mode.dof]
            if joint not in joints:
                factor = growth_in_run(loaded, view, mode, folds / mode.rate.real)
                if factor is not None and factor > np.exp(folds / 2):
                    joints.add(joint)
                    yield view, mode


def growth_in_run(loaded: Loaded, view: View, mode: Shape, horizon: float) -> float | None:
    """Return the growth factor along a mode in a run of a length [s]; None if it is too long.

    The step resolves all modes by `Numerics.steps_per_radian` if there is time for that, else this
    one, and all others by `Numerics.min_steps_per_radian`.
    """
    fastest, timestep = max(one.omega for one in view.simulated), float(loaded.model.opt.timestep)
    many, few = NUMERICS.steps_per_radian, NUMERICS.min_steps_per_radian
    step = max(min(timestep, 1 / (many * fastest)), horizon / NUMERICS.run_steps)
    if step > min(timestep, 1 / max(many * mode.omega, few * fastest)):
        return None
    tell((f"a run of {horizon:.3g} s to see growth",))
    return growth(loaded, view.state, np.real(mode.vector), step, horizon)


def growth(loaded: Loaded, state: State, direction: Array, step: float, horizon: float) -> float:
    """Return the growth factor of a small departure within a run from a state.

    Parameters
    ----------
    loaded : Loaded
    state : State
    direction : array (nv,)
    step, horizon : float
        Step and length of the run by RK4 [s].
    """
    lib, model, size = loaded.mujoco, loaded.sharp(), NUMERICS.perturbation
    model.opt.integrator, model.opt.timestep = lib.mjtIntegrator.mjINT_RK4, step
    runs = [loaded.data(state, model) for _ in range(2)]
    largest = float(np.max(np.abs(direction))) or 1.0
    lib.mj_integratePos(model, runs[1].qpos, size * direction / largest, 1.0)
    steps = max(10, min(NUMERICS.run_steps, int(horizon / step)))
    difference, most = np.empty(model.nv), 0.0
    for i in range(steps):
        for data in runs:
            lib.mj_step(model, data)
        if i >= steps // 2:
            lib.mj_differentiatePos(model, difference, 1.0, runs[0].qpos, runs[1].qpos)
            most = max(most, float(np.max(np.abs(difference))))
    return most / size if np.isfinite(most) else np.inf

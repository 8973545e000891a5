"""Remedies with numbers: each is tried on a copy, whose limit and short run must be stable."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import chain, islice, product
from typing import Any

import numpy as np

from ....reference.scene import Array
from ...checks.rules.conditions import OPENING
from ..mujoco.closures import ClosedLoop, closures
from ..mujoco.facts import integrator, integrators
from ..mujoco.model import Flags, Loaded, NotFiniteError, State
from ..subject import InspectedModel
from ..tuning import EFFORT, NUMERICS, THRESHOLDS
from ..views import StepLimit, step_limit_of, view_of

# Trials: edited copies of a model, and short runs ---------------------------------------------


def edited(loaded: Loaded, change: Callable[[Any], None]) -> Loaded:
    """Return a model with an edited copy of its ``MjModel``; its text does not change."""
    model = copy.copy(loaded.model)
    change(model)
    loaded.mujoco.mj_setConst(model, loaded.mujoco.MjData(model))
    return replace(loaded, model=model)


def stays_finite(loaded: Loaded, state: State) -> bool:
    """Return True if a short run from a perturbed state neither fails nor will fail later.

    Where nothing drives the model, growth of its energy that continues would only fail later.
    """
    step, energies = short_run(loaded, state)
    driven = loaded.model.nu or loaded.model.nflex
    return step is None and bool(driven or not keeps_growing(energies))


def keeps_growing(energies: Array) -> bool:
    """Return True if a run gains energy, kinetic and total, from each quarter to the next.

    Parameters
    ----------
    energies : array (n, 2)
        Potential and kinetic energy [J] at n times; too few samples show no growth.
    """
    parts = NUMERICS.energy_parts
    if len(energies) < 2 * parts:
        return False
    total, kinetic = (
        [float(np.max(part)) for part in np.array_split(values, parts)]
        for values in (np.sum(energies, axis=1), energies[:, 1])
    )
    floor = NUMERICS.energy_roundoff * float(np.max(np.abs(energies[0])))
    gains = np.diff(total) > NUMERICS.energy_gain * max(kinetic[0], floor)
    return bool(np.all(gains) and np.all(np.diff(kinetic) > 0))


def short_run(loaded: Loaded, state: State) -> tuple[int | None, Array]:
    """Run a model from a perturbed state.

    Returns
    -------
    The step at which the run fails, if it does, and its potential and kinetic energy (n, 2) [J].
    """
    lib, model = loaded.mujoco, copy.copy(loaded.model)
    loaded.switch_off(model, "autoreset")
    data, energies = loaded.data(state, model), list[Array]()
    size = NUMERICS.perturbation
    departure = np.random.default_rng(0).uniform(-size, size, model.nv)
    lib.mj_integratePos(model, data.qpos, departure, 1.0)
    steps = min(NUMERICS.run_steps, int(NUMERICS.run_time / model.opt.timestep) + 1)
    for step in range(1, steps + 1):
        lib.mj_step(model, data)
        if loaded.lost(data):
            return step, np.array(energies)
        if (step - 1) % max(1, steps // NUMERICS.energy_samples) == 0:
            lib.mj_energyPos(model, data)
            lib.mj_energyVel(model, data)
            energies.append(data.energy.copy())
    return None, np.array(energies)


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


# Remedies -------------------------------------------------------------------------------------

Edit = tuple[str, Callable[[Any], None]]
"""A change of a ``MjModel``, with its MJCF."""


def rounded(value: float, up: bool, digits: int = 2) -> float:
    """Round a value up or down to a number of digits."""
    unit = 10.0 ** (math.floor(math.log10(value)) - digits + 1)
    whole = math.ceil(value / unit * (1 - 1e-9)) if up else math.floor(value / unit * (1 + 1e-9))
    return float(f"{whole * unit:.{digits}g}")


def with_option(loaded: Loaded, name: str, value: Any) -> Loaded:
    """Return a model with another value of an option."""
    return edited(loaded, lambda model: setattr(model.opt, name, value))


def joint_edits(s: InspectedModel, name: str, dofs: Flags, scale: float) -> Iterator[Edit]:
    """Yield values of ``armature`` or ``damping`` of degrees of freedom (nv,), ascending."""
    joints = list(dict.fromkeys(np.array(s.loaded.joint_names)[dofs].tolist()))
    where = f"{'joint' if len(joints) == 1 else 'joints'} {', '.join(joints)}"
    for value in (rounded(share * scale, up=True) for share in THRESHOLDS.inertia_shares):

        def change(model: Any, value: float = value) -> None:
            values = getattr(model, f"dof_{name}")
            values[dofs] = np.maximum(values[dofs], value)

        yield f'{name}="{value:g}" on {where}', change


def gain_edits(s: InspectedModel, actuators: Flags) -> Iterator[Edit]:
    """Yield factors of the gains of some servos (nu,), descending."""
    names = ", ".join(s.loaded.name("actuator", i) for i in np.flatnonzero(actuators))
    for share in THRESHOLDS.gain_shares if np.any(actuators) else ():

        def change(model: Any, share: float = share) -> None:
            model.actuator_gainprm[actuators, 0] *= share
            model.actuator_biasprm[actuators, 1:3] *= share

        yield f"{share:g} times the gains (kp, kv) of {names}", change


def step_remedies(s: InspectedModel, limit: StepLimit) -> str:
    """Return the tried edits that make the file's integrator stable, the cheapest first.

    They change the joint that sets the limit, or it and all joints that servos drive.
    """
    states, linear = states_of(s, limit.state), s.views[0].linear
    parts, lost = integrator_remedy(s, states)
    names = s.loaded.joint_names
    known = limit.joint in names and not limit.constraint and len(names) <= EFFORT.max_remedy_dofs
    if known and states and linear is not None:
        dof, joints = names.index(str(limit.joint)), s.model.dof_jntid
        alone, acts = joints == joints[dof], servos(s)
        arms, inertia = moments(s.loaded, states[0]), float(linear.mass[dof, dof])
        both = alone, alone | np.any(arms[acts], axis=0)
        kinds = [
            [joint_edits(s, "armature", dofs, inertia) for dofs in both],
            [joint_edits(s, "damping", dofs, inertia / s.timestep) for dofs in both],
            [gain_edits(s, acts & (arms[:, dof] != 0)), gain_edits(s, acts)],
        ]
        for kind in kinds:
            edits = (
                words
                for words, change in chain(*kind)
                if is_stable(edited(s.loaded, change), states)
            )
            parts += islice(edits, 1)
    file_limit = next(one for one in s.steps if one.of_file).limit
    if 0 < file_limit < math.inf:
        step = rounded(THRESHOLDS.recommended_step * file_limit, up=False)
        if is_stable(with_option(s.loaded, "timestep", step), states, margin=1.0):
            parts.append(f'timestep="{step:g}"')
    return in_words(parts, lost)


def is_stable(
    tried: Loaded, states: Sequence[State], margin: float = THRESHOLDS.remedy_margin
) -> bool:
    """Return True if the timestep of an edited model is stable: by its limit, and in short runs.

    Parameters
    ----------
    tried : Loaded
    states : sequence of State
        The state whose limit must be ``margin`` steps, and others that must permit the step.
    margin : float
    """
    step = float(tried.model.opt.timestep)
    if step_limit_again(tried, states[:1]) < margin * step:
        return False
    return step_limit_again(tried, states) >= step and all_stay_finite(tried, states)


def step_limit_again(loaded: Loaded, states: Sequence[State]) -> float:
    """Return the largest stable step [s] of an edited model; 0 where there are no modes."""
    views = [view_of(loaded, state) for state in states]
    if any(one.linear is None for one in views) or not views:
        return 0.0
    return step_limit_of(loaded, integrator(loaded), views).limit


def states_of(s: InspectedModel, name: str | None) -> list[State]:
    """Return the states that have small motions, the one of this name first."""
    states = [one.state for one, _ in s.linear_views if one.steady_hinge is None]
    return sorted(states, key=lambda state: state.name != name)


def all_stay_finite(loaded: Loaded, states: Sequence[State]) -> bool:
    """Return True if short runs from the first of these states stay finite."""
    return all(stays_finite(loaded, state) for state in states[: EFFORT.runs])


def in_words(remedies: Sequence[str], lost: Sequence[str]) -> str:
    """Return a sentence about remedies, and the integrators whose runs fail, too."""
    words = "; or ".join(remedies)
    also = f" (not integrator {' or '.join(lost)}: its run fails, too)" if lost else ""
    return f"{words}{also}" if words else ""


def integrator_remedy(s: InspectedModel, states: Sequence[State]) -> tuple[list[str], list[str]]:
    """Return the cheapest other integrator whose run is stable, if any, and those that fail.

    Integrators whose limit permits the timestep are tried, all of them where no limit is known.
    """
    limits, lost = {one.integrator: one.limit for one in s.steps}, list[str]()
    there = limits or integrators(s.loaded)
    for name in THRESHOLDS.preferred_integrators:
        most = limits.get(name, math.inf)
        permitted = most >= THRESHOLDS.remedy_margin * s.timestep
        if name in there and name != s.options.integrator and permitted:
            kind = s.loaded.member("mjtIntegrator", "mjINT", name)
            if not all_stay_finite(with_option(s.loaded, "integrator", kind), states):
                lost.append(f'"{name}"')
                continue
            words = "without limit" if math.isinf(most) else f"stable up to {most:.3g} s"
            small = f" ({words} in small motions)" if limits else ""
            return [f'integrator="{name}"{small}'], lost
    return [], lost


def servos(s: InspectedModel) -> Flags:
    """Return the actuators (n_u,) that react to position or speed."""
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
    """Return settings that close a loop harder at the file's step and integrator, if any do."""
    states = states_of(s, closure.state)
    every = {state.name: state for state in s.loaded.states}
    time_constant = closure.solref[0]
    constants = [time_constant if x is None else x * s.timestep for x in THRESHOLDS.closure_steps]
    tried_constants = constants if time_constant > 0 else constants[:1]
    for constant, hard in product(tried_constants, THRESHOLDS.impedances):
        if constant > time_constant > 0:
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
        if one.opening > OPENING * s.size_of(closure) or (one.turn or 0.0) > OPENING:
            continue
        least = THRESHOLDS.remedy_margin * s.timestep
        stable = not states or step_limit_again(tried, states) >= least
        if stable and all_stay_finite(tried, states or list(every.values())):
            solref, solimp = f"{constant:g} {closure.solref[1]:g}", f"{hard:g} {hard:g} 0.001"
            return f'solref="{solref}" solimp="{solimp}": it then opens by {one.opening:.2g}'
    return None

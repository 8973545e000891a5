"""Remedies with numbers: each is tried on a copy, whose limit and short run must be stable."""

from __future__ import annotations

import copy
import math
from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import islice, product
from typing import Any

import numpy as np

from ....reference.scene import Array
from ...checks.rules.conditions import OPENING
from ...engines.isolation import tell
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


FAILS = "its run fails"
SPINS = (
    f"a run with a servo's joint displaced by up to {max(NUMERICS.far_starts):g} rad fails, or "
    "keeps a motion that a shorter step does not show"
)


def fault_in_runs(
    s: InspectedModel, tried: Loaded, states: Sequence[State], words: str = "the model"
) -> str:
    """Return the fault that short runs of an edited model show; empty if they show none.

    The runs start near the first of these states, and away from the very first; ``words`` name the
    edit.
    """
    tell((words,))
    few = states[: EFFORT.runs]
    if not all(stays_finite(tried, state) for state in few):
        return FAILS
    shorter = NUMERICS.shorter_step * float(tried.model.opt.timestep)
    if integrator(tried) != s.options.integrator:  # else its step is below its limit
        shorter = min([shorter, *(THRESHOLDS.recommended_step * x.limit for x in s.limits_of_file)])
    return SPINS if any(keeps_spinning(tried, state, shorter) for state in few[:1]) else ""


def stays_finite(loaded: Loaded, state: State) -> bool:
    """Return True if a run from near a state neither fails nor would fail later.

    Where nothing drives the model, growth of its energy that continues would only fail later.
    """
    step, energies = short_run(loaded, state)
    driven = loaded.model.nu or loaded.model.nflex
    return step is None and bool(driven or not keeps_growing(energies))


Lasting = tuple[float, float, State]
"""Share of the kinetic energy that a run keeps, this energy [J], and the start of the run."""


def keeps_spinning(loaded: Loaded, state: State, shorter: float) -> bool:
    """Return True if a run with a servo's joint displaced fails, or keeps a motion due to its step.

    A servo at its largest force may reverse it every few steps, at a speed that depends on the
    step, and never come to rest. Displacements would tear closed loops: there, none is tried.
    """
    driven = np.any(moments(loaded, state)[servos(loaded)], axis=0) & (loaded.model.neq == 0)
    horizon, lasting = min(NUMERICS.far_time, NUMERICS.run_steps * shorter), list[Lasting]()
    for start in far_starts(loaded, state, driven, NUMERICS.far_starts):
        step, energies = short_run(loaded, start, horizon)
        peak, last = kinetic(energies)
        if step is not None:
            return True
        if last > NUMERICS.lasting_energy * peak:
            lasting.append((last / peak, last, start))
    lasting.sort(key=lambda one: -one[0])
    for _, last, start in lasting[: EFFORT.fine_runs]:
        fine = with_option(loaded, "timestep", shorter)
        peak, expected = kinetic(short_run(fine, start, horizon)[1])
        if last > NUMERICS.lasting_ratio * expected + NUMERICS.lasting_energy * peak:
            return True
    return False


def far_starts(
    loaded: Loaded, state: State, dofs: Flags, sizes: Sequence[float]
) -> Iterator[State]:
    """Yield states with one joint displaced within its range; floating bodies stay in place.

    The degrees of freedom ``dofs`` (nv,) are displaced by each of the ``sizes`` [rad] or, if they
    slide, that share of the model's size; where these are too many starts, some are left out.
    """
    m, limited = loaded.model, loaded.limited_joints
    unit = np.diag(np.where(loaded.sliding_dofs, float(m.stat.extent), 1.0))
    jointed = ~loaded.of_kind("jnt_type", "free")[m.dof_jntid]
    places, ends = m.jnt_qposadr[limited], m.jnt_range[limited].T
    every = list(product(unit[jointed & dofs], sizes))
    for axis, size in every[:: math.ceil(len(every) / EFFORT.far_starts) or 1]:
        position = state.position.copy()
        loaded.mujoco.mj_integratePos(m, position, size * axis, 1.0)
        position[places] = np.clip(position[places], *ends)
        yield state._replace(position=position)


def kinetic(energies: Array) -> tuple[float, float]:
    """Return the largest kinetic energy [J] of a run (n, 2), and of its last part."""
    last = np.array_split(energies[:, 1], NUMERICS.energy_parts)[-1]
    return float(np.max(energies[:, 1], initial=0.0)), float(np.max(last, initial=0.0))


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


def short_run(
    loaded: Loaded, state: State, horizon: float = NUMERICS.run_time
) -> tuple[int | None, Array]:
    """Run a model for some time [s] from a perturbed state, with constant controls.

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
    steps = min(NUMERICS.run_steps, int(horizon / model.opt.timestep) + 1)
    for step in range(1, steps + 1):
        lib.mj_step(model, data)
        if loaded.lost(data):
            return step, np.array(energies)
        if (step - 1) % max(1, steps // NUMERICS.energy_samples) == 0:
            lib.mj_energyPos(model, data)
            lib.mj_energyVel(model, data)
            energies.append(data.energy.copy())
    return None, np.array(energies)


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
    """Yield values of ``armature`` or ``damping`` of degrees of freedom (nv,), ascending.

    Each is the value to be written, for the joints that have less.
    """
    before, names = np.array(getattr(s.model, f"dof_{name}")), np.array(s.loaded.joint_names)
    for value in (rounded(share * scale, up=True) for share in THRESHOLDS.inertia_shares):
        less = dofs & (before < value)

        def change(model: Any, value: float = value, less: Flags = less) -> None:
            getattr(model, f"dof_{name}")[less] = value

        joints = list(dict.fromkeys(names[less].tolist()))
        where = f"{'joint' if len(joints) == 1 else 'joints'} {', '.join(joints)}"
        if joints:
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
    parts = integrator_remedy(s, states)
    names = s.loaded.joint_names
    known = limit.joint in names and not limit.constraint and len(names) <= EFFORT.max_remedy_dofs
    if known and states and linear is not None:
        dof, joints = names.index(str(limit.joint)), s.model.dof_jntid
        alone, acts = joints == joints[dof], servos(s.loaded)
        arms, inertia = moments(s.loaded, states[0]), float(linear.mass[dof, dof])
        both = alone, alone | np.any(arms[acts], axis=0)
        kinds = [
            [joint_edits(s, "armature", dofs, inertia) for dofs in both],
            [joint_edits(s, "damping", dofs, inertia / s.timestep) for dofs in both],
            [gain_edits(s, acts & (arms[:, dof] != 0)), gain_edits(s, acts)],
        ]
        for kind in kinds:
            stable = (first_stable(s, list(edits), states) for edits in kind)
            parts += islice(filter(None, stable), 1)
    file_limit = next(one for one in s.steps if one.of_file).limit
    if 0 < file_limit < math.inf:
        step = rounded(THRESHOLDS.recommended_step * file_limit, up=False)
        words = f'timestep="{step:g}"'
        if is_stable(s, with_option(s.loaded, "timestep", step), states, words):
            parts.append(words)
    return in_words(s, parts)


def first_stable(s: InspectedModel, edits: Sequence[Edit], states: Sequence[State]) -> str | None:
    """Return the smallest of some edits, ascending, that makes the step stable, if any does.

    The more is edited, the larger is the limit: bisection finds where the trials of runs begin.
    """
    first = bisect_left(
        edits, True, key=lambda edit: is_below_limit(edited(s.loaded, edit[1]), states)
    )
    tried = islice(edits, first, first + EFFORT.run_tries)
    stable = (words for words, x in tried if is_stable(s, edited(s.loaded, x), states, words))
    return next(stable, None)


def is_stable(s: InspectedModel, tried: Loaded, states: Sequence[State], words: str) -> bool:
    """Return True if the step of an edited model is well below its limit, and short runs show it.

    Then `near_step_limit` has no finding either; ``words`` name the edit.
    """
    return is_below_limit(tried, states) and not fault_in_runs(s, tried, states, words)


def is_below_limit(tried: Loaded, states: Sequence[State]) -> bool:
    """Return True if the timestep of an edited model is well below the largest stable step."""
    views = [view_of(tried, state) for state in states]
    if any(one.linear is None for one in views) or not views:
        return False
    limit = step_limit_of(tried, integrator(tried), views).limit
    return float(tried.model.opt.timestep) <= THRESHOLDS.recommended_step * limit


def states_of(s: InspectedModel, name: str | None) -> list[State]:
    """Return the states that have small motions, the one of this name first."""
    states = [one.state for one, _ in s.linear_views if one.steady_hinge is None]
    return sorted(states, key=lambda state: state.name != name)


def in_words(s: InspectedModel, remedies: Sequence[str]) -> str:
    """Return a sentence about remedies, and rejected integrators by the fault of their runs."""
    words, names = "; or ".join(remedies), dict[str, str]()
    for name, fault in s.rejected.items():
        names[fault] = f'{names[fault]} or "{name}"' if fault in names else f'"{name}"'
    also = "; ".join(f"not integrator {listed}: {fault}" for fault, listed in names.items())
    return f"{words} ({also})" if words and also else words


def integrator_remedy(s: InspectedModel, states: Sequence[State]) -> list[str]:
    """Return the cheapest other integrator whose run is stable, if any; reject those with a fault.

    Integrators whose limit permits the timestep are tried, all of them where no limit is known.
    """
    limits = {one.integrator: one.limit for one in s.steps}
    there = limits or integrators(s.loaded)
    for name in THRESHOLDS.preferred_integrators:
        most = limits.get(name, math.inf)
        permitted = s.timestep <= THRESHOLDS.recommended_step * most
        if name in there and name != s.options.integrator and permitted:
            kind, edit = s.loaded.member("mjtIntegrator", "mjINT", name), f'integrator="{name}"'
            fault = fault_in_runs(s, with_option(s.loaded, "integrator", kind), states, edit)
            if fault:
                s.rejected[name] = fault
                continue
            words = "without limit" if math.isinf(most) else f"stable up to {most:.3g} s"
            small = f" ({words} in small motions)" if limits else ""
            return [edit + small]
    return []


def servos(loaded: Loaded) -> Flags:
    """Return the actuators (n_u,) that react to position or speed."""
    acts = np.any(loaded.model.actuator_biasprm[:, 1:3] != 0, axis=1)
    return np.asarray(acts & loaded.of_kind("actuator_biastype", "affine"))


def moments(loaded: Loaded, state: State) -> Array:
    """Return the moment arms (n_u, n_v) of actuators in a state, the sum of all their forces."""
    m, data = loaded.model, loaded.data(state)
    loaded.mujoco.mj_forward(m, data)
    arms = np.zeros((len(data.moment_rownnz), m.nv))
    if m.nu:
        rows = data.moment_rownnz, data.moment_rowadr, data.moment_colind
        loaded.mujoco.mju_sparse2dense(arms, data.actuator_moment, *rows)
        arms = np.add.reduceat(arms, loaded.first_of("out"), axis=0)
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
        solref, solimp = f"{constant:g} {closure.solref[1]:g}", f"{hard:g} {hard:g} 0.001"
        words = f'solref="{solref}" solimp="{solimp}"'
        if (
            is_stable(s, tried, states, words)
            if states
            else not fault_in_runs(s, tried, list(every.values()), words)
        ):
            return f"{words}: it then opens by {one.opening:.2g}"
    return None

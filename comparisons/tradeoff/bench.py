"""Runs of a user's model: starts, controls, measurements, and converged runs."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from hashlib import sha256
from math import inf
from time import monotonic, thread_time
from typing import Any, NamedTuple

import numpy as np

from ...reference.errors import UsageError
from ...reference.scene import Array
from ..inspect.mujoco.facts import integrator, integrators
from ..inspect.mujoco.model import Loaded, State
from ..inspect.rules.remedies import edited
from ..inspect.views import state_views, step_limits
from ..queries.environment import versions
from .request import TradeoffRequest
from .store import RunStore
from .table import percent
from .tuning import BENCH

RESOLVED = {"tolerance": 1e-15, "iterations": 200, "ls_iterations": 100}
"""Options of Newton's solver in the converged run; without a tolerance it iterates at round-off,
and takes 30 times as long for the same digits."""

AFTERWARDS = ("mj_fwdPosition", "mj_fwdVelocity", "mj_energyPos", "mj_energyVel")
"""Functions that update sites, constraints and energies to the state at the end of a step."""

EVALUATIONS = {"RK4": 4}
"""Evaluations of the forces in a step, for integrators with more than one."""

TIME_UP = "the time was up before its converged run"
"""Reason why a start has no converged run, if there is no other."""


class TimeUpError(Exception):
    """The time of --budget is up."""


class Setting(NamedTuple):
    """An integrator as MJCF spells it, a step [s], and other changes of the file.

    ``iterations`` is the limit of the solver, ``closure`` the longest time constant [s] of a loop;
    None leaves the value of the file.
    """

    integrator: str
    step: float
    iterations: int | None = None
    closure: float | None = None

    @property
    def name(self) -> str:
        """Description of the setting."""
        words = [f"{self.integrator} at {1e3 * self.step:.4g} ms"]
        words += [f"closures of {1e3 * self.closure:.4g} ms"] if self.closure else []
        words += [f"{self.iterations} iterations"] if self.iterations else []
        return ", ".join(words)

    @property
    def work(self) -> float:
        """Evaluations of forces in a simulated second [1/s]."""
        return EVALUATIONS.get(self.integrator, 1) / self.step

    def alike(self, other: Setting) -> bool:
        """Return True if another setting differs in the step alone, and in its consequences."""
        hard = self.closure is None, other.closure is None
        return self[::2] == other[::2] and hard[0] == hard[1]


@dataclass(frozen=True)
class Start:
    """Initial state and controls of runs.

    Attributes
    ----------
    state : State
    draw : int
        Number of the draw of controls that oscillate inside their ranges; 0: constant controls.
    controls : array (n_periods, n_u)
        Controls, constant over each period.
    """

    state: State
    draw: int
    controls: Array

    @property
    def name(self) -> str:
        """Description of the start."""
        kind = f"moving controls ({self.draw})" if self.draw else "constant controls"
        return f"{self.state.name}, {kind}"


@dataclass(frozen=True)
class SampledRun:
    """A run, sampled after each period until its state is lost.

    Attributes
    ----------
    positions : array (n, n_q)
    points : array (n, n_sites, 3)
        Positions of observed sites [m].
    energy : array (n,)
        Kinetic and potential energy [J].
    kinetic : float
        Largest kinetic energy [J].
    violation : float
        Largest residual of an equality (m, rad).
    rows : int
        Largest number of simultaneous rows of contacts, limits and friction.
    failed : float or None
        Time at which the state was lost [s].
    seconds : float
        Processor time of the stepping per simulated second [s/s].
    """

    positions: Array
    points: Array
    energy: Array
    kinetic: float
    violation: float
    rows: int
    failed: float | None
    seconds: float


class Bench:
    """A model, prepared for comparable runs.

    Attributes
    ----------
    loaded : Loaded
    request : TradeoffRequest
    store : RunStore
        Keeps runs.
    deadline : float
        Time limit on the clock `time.monotonic`.
    period : float
        Time [s] over which controls are constant, and after which runs are compared.
    count : int
        Number of periods.
    sites : array of int
        Observed sites.
    observed : bool array (n_v + n_sites,)
        True for observed degrees of freedom, and for all of these sites.
    """

    def __init__(self, loaded: Loaded, request: TradeoffRequest) -> None:
        self.loaded, self.request = loaded, request
        self.deadline = monotonic() + request.budget
        self.period = BENCH.longest * float(loaded.model.opt.timestep)
        if request.horizon < self.period:
            raise UsageError(
                f"--horizon {request.horizon:g}: runs are compared after every {BENCH.longest} "
                f"steps of the file; give {self.period:g} s or more"
            )
        self.count = max(1, round(request.horizon / self.period))
        self.sites, dofs = observables(loaded, request.observed)
        self.observed = np.append(dofs, np.ones(len(self.sites), dtype=bool))
        self.limits: dict[float | None, dict[str, float]] = {}
        names = ("horizon", "seed", "exact", "observed")
        about = {name: getattr(request, name) for name in names} | {"target": request.target}
        about |= {"MuJoCo": str(loaded.mujoco.__version__), **versions(())}
        digest = sha256(loaded.dumped(loaded.model)).hexdigest()
        self.store = RunStore(request.resume, model=digest, **about)

    @property
    def file(self) -> Setting:
        """Setting of the file."""
        return Setting(integrator(self.loaded), float(self.loaded.model.opt.timestep))

    def limit(self, setting: Setting) -> float:
        """Return the largest stable step of small motions [s]; infinite if there is none."""
        closure, loaded = setting.closure, self.loaded
        if closure not in self.limits:
            if closure is not None:
                loaded = edited(loaded, partial(harden, constant=closure))
            limits = step_limits(loaded, state_views(loaded, None, None))
            self.limits[closure] = {one.integrator: one.limit for one in limits}
        limit = self.limits[closure].get(setting.integrator, inf)
        return limit if limit > 0 else inf

    def starts(self, draws: Sequence[int]) -> Iterator[Start]:
        """Yield the states of the file with controls of these draws; 0 is constant controls."""
        model = self.loaded.model
        limited = model.actuator_ctrllimited.astype(bool)
        for state in self.loaded.states:
            level = self.loaded.data(state).ctrl.copy()
            low, high = model.actuator_ctrlrange.T
            level = np.where(limited, np.clip(level, low, high), level)
            for draw in draws:
                if not draw:
                    yield Start(state, draw, np.tile(level, (self.count, 1)))
                elif np.any(limited):
                    yield Start(state, draw, self.moved(level, limited, draw))

    def other_starts(self) -> Iterator[Start]:
        """Yield two starts inside the ranges of joints, one near a limit that a control reaches.

        They are at rest; controls move, or push to the limit. Starts in which loops are open, or
        bodies overlap more than in the file, are left out.
        """
        m, random = (
            self.loaded.model,
            np.random.default_rng([self.request.seed, *BENCH.proof_draws]),
        )
        first = [*self.starts((0,))][:2][-1]
        state, level = first.state._replace(velocity=np.zeros(m.nv)), first.controls[0]
        limited, near = self.loaded.limited_joints, BENCH.limit_distance
        joints, most = np.flatnonzero(limited), max(self.strain(state), BENCH.strain)
        ranged = m.actuator_ctrllimited.astype(bool)
        for draw, name in enumerate(("a start", "another start"), max(BENCH.proof_draws) + 1):
            for _ in range(BENCH.start_draws if len(joints) else 0):
                shares = random.uniform(near, 1 - near, len(joints))
                drawn = self.placed(state, f"{name} inside the ranges", joints, shares)
                if self.strain(drawn) <= most:
                    moved = self.moved(level, ranged, draw)
                    yield Start(drawn, draw * bool(np.any(ranged)), moved)
                    break
        drives = (m.actuator_ctrllimited != 0) & self.loaded.of_kind("actuator_trntype", "joint")
        drives[drives] &= limited[m.actuator_trnid[drives, 0]]
        ways = [(i, end, up) for i in np.flatnonzero(drives) for end in (0, 1) for up in (0, 1)]
        for actuator, end, up in random.permutation(np.array(ways)):
            joint, pushing = int(m.actuator_trnid[actuator, 0]), level.copy()
            pushing[actuator] = m.actuator_ctrlrange[actuator, end]
            name = f"{self.loaded.name('joint', joint)} near a limit that its control reaches"
            start = self.placed(state, name, [joint], near + (1 - 2 * near) * up)
            push = self.acceleration(self.placed(state, "", [joint], up), pushing)
            if (2 * up - 1) * push[m.jnt_dofadr[joint]] > 0 and self.strain(start) <= most:
                yield Start(start, 0, np.tile(pushing, (self.count, 1)))
                return

    def placed(self, state: State, name: str, joints: Any, shares: Any) -> State:
        """Return a state with some hinges and slides at shares of their ranges."""
        m, position = self.loaded.model, state.position.copy()
        low, high = m.jnt_range[joints].T
        position[m.jnt_qposadr[joints]] = low + shares * (high - low)
        return state._replace(keys=(name,), position=position)

    def strain(self, state: State) -> float:
        """Return the opening of loops and the depth of contacts [m, rad]."""
        data = self.loaded.data(state)
        self.loaded.mujoco.mj_fwdPosition(self.loaded.model, data)
        depths = [-float(contact.dist) for contact in data.contact]
        return max([0.0, *depths, *np.abs(data.efc_pos[: data.ne]).tolist()])

    def acceleration(self, state: State, controls: Array) -> Array:
        """Return the accelerations (n_v,) in a state, without limits and contacts."""
        model = self.loaded.sharp("limit", "contact")
        data = self.loaded.data(state, model)
        data.ctrl[:] = controls
        self.loaded.mujoco.mj_forward(model, data)
        return np.array(data.qacc)

    def moved(self, level: Array, limited: Any, draw: int) -> Array:
        """Return smooth controls (n_periods, n_u) that begin at a level (n_u,)."""
        random = np.random.default_rng([self.request.seed, draw])
        low, high = self.loaded.model.actuator_ctrlrange.T
        omega = 2 * np.pi * random.uniform(*BENCH.frequencies, size=(2, len(level)))
        phase = random.uniform(0, 2 * np.pi, size=(2, len(level)))
        times = self.period * np.arange(self.count)[:, None, None]
        waves = np.sum(np.sin(omega * times + phase) - np.sin(phase), axis=1) / 2
        moved = level + BENCH.control_share * (high - low) / 2 * waves
        return np.where(limited, np.clip(moved, low, high), level)

    def settings(self) -> list[Setting]:
        """Return the settings to try: the file's own, then those with less work first.

        If closures count as exact, settings with closures as hard as each step permits are added.
        """
        file, longest, steps = self.file, int(np.log2(BENCH.longest)), BENCH.closure_steps
        softest = np.max(time_constants(self.loaded.model), initial=0.0)
        every = list[Setting]()
        for name in integrators(self.loaded):
            for power in range(longest, -int(np.log2(BENCH.finest)) - 1, -1):
                one = Setting(name, file.step * 2.0**power)
                every.append(one)
                if self.request.exact and steps * one.step < softest:
                    every.append(one._replace(closure=steps * one.step))
        return sorted(every, key=lambda one: (one != file, one.work))

    def compiled(self, setting: Setting, sharp: bool) -> Any:
        """Return a copy of the model with a setting; it does not reset itself."""
        lib, model = self.loaded.mujoco, copy.copy(self.loaded.model)
        model.opt.integrator = self.loaded.member("mjtIntegrator", "mjINT", setting.integrator)
        model.opt.timestep = setting.step
        self.loaded.switch_off(model, "autoreset")
        if setting.iterations:
            model.opt.iterations = setting.iterations
        if setting.closure:
            harden(model, setting.closure)
        if sharp:
            model.opt.solver = lib.mjtSolver.mjSOL_NEWTON
            for option, value in RESOLVED.items():
                setattr(model.opt, option, value)
        return model

    def run(
        self, start: Start, setting: Setting, sharp: bool = False, off: Array | None = None
    ) -> SampledRun:
        """Return a run.

        Parameters
        ----------
        start : Start
        setting : Setting
        sharp : bool
            True if the solver iterates to round-off.
        off : array (n_v,), optional
            Departure of each degree of freedom from the start (m, rad).

        Raises
        ------
        TimeUpError
            If the time is up before it ends.
        """
        lib, model = self.loaded.mujoco, self.compiled(setting, sharp)
        data = self.loaded.data(start.state, model)
        if off is not None:
            lib.mj_integratePos(model, data.qpos, off, 1.0)
        steps = round(self.period / setting.step)
        equality = int(lib.mjtConstraint.mjCNSTR_EQUALITY)
        positions, points, energies = [], [], []
        kinetic = violation = seconds = 0.0
        rows, failed = 0, None
        for control in start.controls:
            data.ctrl[:] = control
            begin = thread_time()
            for done in range(0, steps, BENCH.steps_at_once):
                lib.mj_step(model, data, min(BENCH.steps_at_once, steps - done))
                lost = self.loaded.lost(data)
                late = monotonic() > self.deadline
                if lost or late:
                    break
            if late:
                raise TimeUpError
            seconds += thread_time() - begin
            if lost or not np.all(np.isfinite(data.qpos)):
                failed = float(data.time)
                break
            for function in AFTERWARDS:  # a step leaves the values before it
                getattr(lib, function)(model, data)
            closed = data.efc_type == equality
            violation = max(violation, float(np.max(np.abs(data.efc_pos[closed]), initial=0.0)))
            rows = max(rows, int(np.sum(~closed)))
            kinetic = max(kinetic, float(data.energy[1]))
            positions.append(data.qpos.copy())
            points.append(data.site_xpos[self.sites].copy())
            energies.append(float(np.sum(data.energy)))
        time = max(1, len(positions)) * self.period
        return SampledRun(
            np.reshape(positions, (len(positions), model.nq)),
            np.reshape(points, (len(points), len(self.sites), 3)),
            np.array(energies),
            kinetic,
            violation,
            rows,
            failed,
            seconds / time,
        )

    def departure(self, start: Start, run: SampledRun, size: Array) -> tuple[Array, float]:
        """Return a departure (n_v,) of random signs from a run's start (m, rad), and its size.

        It is a share of the target, relative to 1 m or 1 rad, or to a smaller observed motion.
        """
        model, share = self.loaded.model, BENCH.departure * self.request.target
        off = np.random.default_rng(1).choice([-share, share], model.nv)
        starts = []
        for moved in (0 * off, off):
            data = self.loaded.data(start.state)
            self.loaded.mujoco.mj_integratePos(model, data.qpos, moved, 1.0)
            self.loaded.mujoco.mj_kinematics(model, data)
            points = data.site_xpos[self.sites]
            starts.append(replace(run, positions=data.qpos[None], points=points[None]))
        departed = float(self.apart(starts[0], starts[1], size)[0])
        shrink = min(1.0, share / departed) if departed else 1.0
        return shrink * off, shrink * departed

    def distances(self, one: SampledRun, other: SampledRun) -> Array:
        """Return the distances of the observables (n, n_dofs + n_sites) of two runs.

        They are at each time that both reached.
        """
        n = min(len(one.positions), len(other.positions))
        moved = np.empty((n, self.loaded.model.nv))
        for i in range(n):
            self.loaded.mujoco.mj_differentiatePos(
                self.loaded.model, moved[i], 1.0, other.positions[i], one.positions[i]
            )
        gaps = np.linalg.norm(one.points[:n] - other.points[:n], axis=2)
        return np.hstack([np.abs(moved), gaps])

    def apart(self, one: SampledRun, other: SampledRun, size: Array) -> Array:
        """Return the largest error (n,) at each time that both reached, relative to `sizes`."""
        errors = self.distances(one, other)[:, self.observed]
        return np.asarray(np.max(errors / np.where(size > 0, size, 1.0), axis=1, initial=0.0))

    def sizes(self, run: SampledRun) -> Array:
        """Return the range of motion of the observables in a run (n_dofs + n_sites,).

        All joints that turn have the range of the one that turns most, and all that slide likewise:
        for a joint that rests no range would remain. A range below `BenchOptions.still` is 0.
        """
        model, n = self.loaded.model, len(run.positions)
        if not n:
            return np.ones(int(np.sum(self.observed)))
        first = [np.repeat(one[:1], n, axis=0) for one in (run.positions, run.points)]
        reach = np.max(
            self.distances(run, replace(run, positions=first[0], points=first[1])),
            axis=0,
            initial=0.0,
        )
        slides = self.loaded.sliding_dofs
        for kind in (slides, ~slides):
            reach[: model.nv][kind] = np.max(reach[: model.nv][kind], initial=0.0)
        return np.where(reach < BENCH.still, 0.0, reach)[self.observed]


def observables(loaded: Loaded, names: tuple[str, ...]) -> tuple[Any, Any]:
    """Return the sites and the degrees of freedom (n_v,) of these names; without any all joints.

    Raises
    ------
    UsageError
        If there is no joint and no site of a name.
    """
    if not names:
        return np.array([], dtype=int), np.ones(loaded.model.nv, dtype=bool)
    sites = {loaded.name("site", number): number for number in range(loaded.model.nsite)}
    for name in names:
        if name not in (*sites, *loaded.joint_names):
            raise UsageError(f"--observe {name[:60]}: {loaded.path.name} has no such joint or site")
    numbers = [sites[name] for name in names if name in sites]
    return np.array(numbers, dtype=int), np.isin(loaded.joint_names, names)


def time_constants(model: Any) -> Array:
    """Return the time constants [s] of the active equalities (n,), from ``solref``.

    Stiffness k and damping b that are given directly have the time constant 2 / b, or 1 / sqrt(k)
    without damping.
    """
    constant, ratio = model.eq_solref[model.eq_active0.astype(bool)].T
    with np.errstate(all="ignore"):
        direct = np.where(ratio < 0, -2 / ratio, 1 / np.sqrt(np.abs(constant)))
    return np.asarray(np.where(constant > 0, constant, direct))


def harden(model: Any, constant: float) -> None:
    """Give all softer equalities this time constant [s], with the same damping ratios."""
    factors = time_constants(model) / constant
    for number, factor in zip(np.flatnonzero(model.eq_active0), factors, strict=True):
        if factor > 1 and model.eq_solref[number, 0] > 0:
            model.eq_solref[number, 0] = constant
        elif factor > 1:
            model.eq_solref[number] *= factor**2, factor


# Converged runs -------------------------------------------------------------------------------


@dataclass(frozen=True)
class Converged:
    """The converged run from a start, and its uncertainty.

    Attributes
    ----------
    start : Start
    setting : Setting
    run : SampledRun
    size : array (n,)
        Range of motion of the observables.
    error : array (n_periods,)
        Relative change with twice the step, and with closures half as hard if they count as exact.
    spread : array (n_periods,)
        Relative change with a second start.
    apart : float
        Relative departure of that start, see `Bench.departure`.
    softness : array (n_periods,)
        Relative change with closures as soft as in the file, or, if they are so, with hard ones;
        empty without closures.
    """

    start: Start
    setting: Setting
    run: SampledRun
    size: Array
    error: Array = field(default_factory=lambda: np.zeros(0))
    spread: Array = field(default_factory=lambda: np.zeros(0))
    apart: float = 0.0
    softness: Array = field(default_factory=lambda: np.zeros(0))

    def count(self, target: float) -> int:
        """Return the number of periods over which it is known for a target."""
        most = BENCH.known_share * target
        return min(known(self.error, most), known(self.spread, most))

    @property
    def smooth(self) -> bool:
        """True if no contacts, limits and friction acted."""
        return self.run.rows == 0

    def grows(self, target: float) -> bool:
        """Return True if small errors grow too much, whatever the step."""
        most = BENCH.known_share * target
        return known(self.error, most) > known(self.spread, most)

    def reason(self, target: float) -> str:
        """Return the reason why it is not known for longer."""
        if self.run.failed is not None:
            return f"the converged run itself loses its state at t = {self.run.failed:.3g} s"
        cause = "contacts, limits or friction" if not self.smooth else "the motion"
        if self.grows(target):
            largest = float(np.max(self.spread))
            return f"small errors grow by a factor of {largest / self.apart:.2g} ({cause})"
        most = percent(BENCH.known_share * target)
        tried = f"{self.setting.integrator} at {1e3 * self.setting.step:.3g} ms"
        what = (
            "twice the step or closures twice as soft" if self.setting.closure else "twice the step"
        )
        change = percent(float(np.max(self.error)))
        return f"{cause}: no run converges to {most} ({tried}; {what} changes it by {change})"


def converge(bench: Bench, start: Start, late: bool = False) -> Converged | str:
    """Return the converged run from a start, or the reason why there is none.

    Parameters
    ----------
    bench : Bench
        Its store keeps the run.
    start : Start
    late : bool
        True if there is no time to compute it.
    """
    key = f"converged run, {start.name}"
    truth: Converged | str | None = bench.store.get(key, Converged | str)
    if truth is not None:
        return truth
    try:
        truth = TIME_UP if late else refined(bench, start)
    except TimeUpError:
        return TIME_UP
    if isinstance(truth, Converged) or (truth != TIME_UP and "--budget" not in truth):
        bench.store.put(key, truth)
    return truth


def refined(bench: Bench, start: Start) -> Converged | str:
    """Compute the converged run from a start, or return the reason why there is none.

    The longest step serves if the run is clearly known to its end. Shorter ones are refined where
    the motion is smooth; where no time is left, the reason states the time needed.

    Raises
    ------
    TimeUpError
        If there was no time.
    """
    target, exact = bench.request.target, bench.request.exact
    constants = time_constants(bench.loaded.model)
    closure = float(np.min(constants)) / BENCH.hard_closure if exact and len(constants) else None
    best: Converged | None = None
    took, least = 0.0, min(BENCH.min_periods, bench.count)
    for finer in BENCH.finer:
        step, began, trial = bench.file.step / BENCH.converged / finer, monotonic(), finer == 1
        need = BENCH.refinement_work * took
        if best and began + need > bench.deadline:
            words = f"steps of {1e3 * step:.2g} ms take about {need:.0f} s: raise --budget"
            return f"{best.reason(target)}; {words}"
        for name in BENCH.sharpest[: 1 if trial else None]:
            truth = converged_by(bench, start, Setting(name, step, closure=closure))
            if not np.any(truth.size):
                return f"nothing moves by {BENCH.still:g} m or rad: the motion is small"
            best = max(truth, best or truth, key=lambda one: one.count(target))
            if truth.run.failed is not None:
                continue
            if trial and truth.count(BENCH.margin * target) == bench.count:
                return truth
            if not trial and truth.count(target) >= least:
                return truth
            if not trial and (truth.grows(target) or not truth.smooth):
                return truth.reason(target)  # no other step helps
        took = monotonic() - began
    assert best is not None
    return best if best.count(target) >= least else best.reason(target)


def converged_by(bench: Bench, start: Start, setting: Setting) -> Converged:
    """Return the run by a setting, with its uncertainty."""
    whole = bench.run(start, setting, sharp=True)
    size = bench.sizes(whole)
    if not np.any(size):
        return Converged(start, setting, whole, size)
    coarse = setting._replace(step=2 * setting.step)
    half = bench.run(start, coarse, sharp=True)
    off, departed = bench.departure(start, whole, size)
    perturbed = bench.run(start, coarse, sharp=True, off=off)
    error, spread = (bench.apart(a, b, size) for a, b in ((half, whole), (perturbed, half)))
    softness = np.zeros(0)
    if len(constants := time_constants(bench.loaded.model)):
        hard = float(np.min(constants)) / BENCH.hard_closure
        for closure in (2 * hard, None) if setting.closure else (hard,):
            other = bench.run(start, setting._replace(closure=closure), sharp=True)
            softness = bench.apart(other, whole, size)
            if setting.closure and closure:
                error = np.maximum(error, np.resize(softness, len(error)))
    return Converged(start, setting, whole, size, error, spread, departed, softness)


def known(errors: Array, most: float) -> int:
    """Return the number of periods before an error first exceeds a bound."""
    above = np.flatnonzero(~(errors <= most))
    return int(above[0]) if len(above) else len(errors)

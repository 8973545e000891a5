"""Runs of a user's model: from where, with which controls, and what is measured of them."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
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
from ..inspect.mujoco.trial import edited
from ..inspect.views import state_views, step_limits
from ..queries.environment import versions
from .request import TradeoffRequest
from .store import RunStore

LONGEST, FINEST = 8, 8
"""Steps reach from so many times the file's own to its so manyth part."""

CONVERGED = 32
"""Parts of the file's step that the converged run takes, by the method of order 4."""

SHARE = 0.25
"""Of half the range of a control that the moving controls use."""

TRIED, PROVED = (0, 1, 2), (3, 4, 5)
"""Draws of controls by which settings are chosen, and those by which a choice is proved."""

NEAR = 0.1
"""Share of its range by which a joint stays away from its limits in other starts."""

STRAIN, DRAWS = 1e-6, 20
"""How far loops may be open, or bodies lie in each other, in these [m, rad]; draws of each."""

FREQUENCIES = (0.3, 1.5)
"""Between which their oscillations lie [Hz]."""

RESOLVED = {"tolerance": 1e-15, "iterations": 200, "ls_iterations": 100}
"""Options of Newton's solver in the converged run; without a tolerance it goes on at rounding, and
takes 30 times as long for the same digits."""

CLOSURE = 2.5
"""Steps that the time constant of a closure has where it is as hard as `refsafe` lets it be."""

AT_ONCE = 16
"""Steps between two looks at whether the state is lost: a lost one takes long to step."""

AFTERWARDS = ("mj_fwdPosition", "mj_fwdVelocity", "mj_energyPos", "mj_energyVel")
"""What brings sites, constraints and energies to the state that a step ends in."""


class TimeUpError(Exception):
    """The time is up."""


class Setting(NamedTuple):
    """An integrator as MJCF spells it, a step [s], and what else is not as in the file.

    ``iterations`` are the most of the solver, ``closure`` is the longest time constant [s] that a
    loop may have; None: that of the file.
    """

    integrator: str
    step: float
    iterations: int | None = None
    closure: float | None = None

    @property
    def name(self) -> str:
        """The setting in words."""
        words = [f"{self.integrator} at {1e3 * self.step:.4g} ms"]
        words += [f"closures of {1e3 * self.closure:.4g} ms"] if self.closure else []
        words += [f"{self.iterations} iterations"] if self.iterations else []
        return ", ".join(words)

    def alike(self, other: Setting) -> bool:
        """Return whether another is the same but for the step, and what follows from that."""
        hard = self.closure is None, other.closure is None
        return self[::2] == other[::2] and hard[0] == hard[1]


@dataclass(frozen=True)
class Start:
    """Where runs start, and their controls.

    Attributes
    ----------
    state : State
    draw : int
        Number of the draw of the controls, which oscillate inside their ranges; 0: they are held.
    controls : array (n_periods, n_u)
        Constant over each period.
    """

    state: State
    draw: int
    controls: Array

    @property
    def name(self) -> str:
        """The start in words."""
        return f"{self.state.name}, controls {f'moving ({self.draw})' if self.draw else 'held'}"


@dataclass(frozen=True)
class SampledRun:
    """A run, sampled after each period; lost rows are not there.

    Attributes
    ----------
    positions : array (n, n_q)
    points : array (n, n_sites, 3)
        Of observed sites [m].
    energy : array (n,)
        Kinetic and potential [J].
    kinetic : float
        The largest [J].
    violation : float
        Largest residual of an equality (m, rad).
    rows : int
        Most rows of contacts, limits and friction at once.
    failed : float or None
        When the state was lost [s].
    seconds : float
        Processor time of the stepping [s/s], which other programs do not lengthen.
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
    """A model, set up for runs that may be compared.

    Attributes
    ----------
    loaded : Loaded
    asked : TradeoffRequest
    store : RunStore
        Keeps what was run.
    deadline : float
        On the clock `time.monotonic`.
    period : float
        Time [s] over which controls are constant, and after which runs are compared.
    count : int
        Of periods.
    sites : array of int
        Sites that are observed.
    observed : bool array (n_v + n_sites,)
        Which degrees of freedom are observed, and all of these sites.
    """

    def __init__(self, loaded: Loaded, asked: TradeoffRequest) -> None:
        self.loaded, self.asked = loaded, asked
        self.deadline = monotonic() + asked.budget
        self.period = LONGEST * float(loaded.model.opt.timestep)
        if asked.horizon < self.period:
            raise UsageError(
                f"--horizon {asked.horizon:g}: runs are compared after each {LONGEST} steps of the "
                f"file; give {self.period:g} s or more"
            )
        self.count = max(1, round(asked.horizon / self.period))
        self.sites, dofs = observables(loaded, asked.observed)
        self.observed = np.append(dofs, np.ones(len(self.sites), dtype=bool))
        self.limits: dict[float | None, dict[str, float]] = {}
        names = ("horizon", "seed", "exact", "observed")
        about = {name: getattr(asked, name) for name in names} | {"target": asked.target}
        about |= {"MuJoCo": str(loaded.mujoco.__version__), **versions(())}
        digest = sha256(loaded.dumped(loaded.model)).hexdigest()
        self.store = RunStore(asked.resume, model=digest, **about)

    @property
    def file(self) -> Setting:
        """The setting of the file."""
        return Setting(integrator(self.loaded), float(self.loaded.model.opt.timestep))

    @property
    def late(self) -> bool:
        """Whether the time is up."""
        return monotonic() > self.deadline

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
        """Yield the states of the file with controls of these draws; 0 is those that are held."""
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

        They are at rest; controls move, or push to the limit. A start in which loops are open, or
        bodies lie deeper in each other than in the file, is left out.
        """
        m, random = self.loaded.model, np.random.default_rng([self.asked.seed, *PROVED])
        first = [*self.starts((0,))][:2][-1]
        state, level = first.state._replace(velocity=np.zeros(m.nv)), first.controls[0]
        limited = (m.jnt_limited != 0) & self.loaded.of_kind("jnt_type", "hinge", "slide")
        joints, most = np.flatnonzero(limited), max(self.strain(state), STRAIN)
        ranged = m.actuator_ctrllimited.astype(bool)
        for draw, name in enumerate(("a start", "another start"), max(PROVED) + 1):
            for _ in range(DRAWS if len(joints) else 0):
                shares = random.uniform(NEAR, 1 - NEAR, len(joints))
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
            near = self.placed(state, name, [joint], NEAR + (1 - 2 * NEAR) * up)
            push = self.acceleration(self.placed(state, "", [joint], up), pushing)
            if (2 * up - 1) * push[m.jnt_dofadr[joint]] > 0 and self.strain(near) <= most:
                yield Start(near, 0, np.tile(pushing, (self.count, 1)))
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
        random = np.random.default_rng([self.asked.seed, draw])
        low, high = self.loaded.model.actuator_ctrlrange.T
        omega = 2 * np.pi * random.uniform(*FREQUENCIES, size=(2, len(level)))
        phase = random.uniform(0, 2 * np.pi, size=(2, len(level)))
        times = self.period * np.arange(self.count)[:, None, None]
        waves = np.sum(np.sin(omega * times + phase) - np.sin(phase), axis=1) / 2
        moved = level + SHARE * (high - low) / 2 * waves
        return np.where(limited, np.clip(moved, low, high), level)

    def settings(self) -> Iterator[Setting]:
        """Yield what is tried: the file's own first, then each integrator, long steps first.

        Where closures count as exact, those as hard as each step lets them be, too.
        """
        file = self.file
        softest = np.max(time_constants(self.loaded.model), initial=0.0)
        yield file
        for name in integrators(self.loaded):
            for power in range(int(np.log2(LONGEST)), -int(np.log2(FINEST)) - 1, -1):
                one = Setting(name, file.step * 2.0**power)
                if one != file:
                    yield one
                if self.asked.exact and CLOSURE * one.step < softest:
                    yield one._replace(closure=CLOSURE * one.step)

    def compiled(self, setting: Setting, sharp: bool) -> Any:
        """Return a copy of the model with a setting; it does not reset itself."""
        lib, model = self.loaded.mujoco, copy.copy(self.loaded.model)
        model.opt.integrator = self.loaded.member("mjtIntegrator", "mjINT", setting.integrator)
        model.opt.timestep = setting.step
        model.opt.disableflags |= self.loaded.member("mjtDisableBit", "mjDSBL", "autoreset")
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
        self, start: Start, setting: Setting, sharp: bool = False, off: float = 0.0
    ) -> SampledRun:
        """Return a run.

        Parameters
        ----------
        start : Start
        setting : Setting
        sharp : bool
            Whether the solver goes on to rounding.
        off : float
            Departure of each degree of freedom from the start, of random sign (m, rad).

        Raises
        ------
        TimeUpError
            If the time is up before it ends.
        """
        lib, model = self.loaded.mujoco, self.compiled(setting, sharp)
        data = self.loaded.data(start.state, model)
        if off:
            signs = np.random.default_rng(1).choice([-off, off], model.nv)
            lib.mj_integratePos(model, data.qpos, signs, 1.0)
        steps = round(self.period / setting.step)
        equality = int(lib.mjtConstraint.mjCNSTR_EQUALITY)
        positions, points, energies = [], [], []
        kinetic = violation = seconds = 0.0
        rows, failed = 0, None
        for control in start.controls:
            data.ctrl[:] = control
            begin = thread_time()
            for done in range(0, steps, AT_ONCE):
                lib.mj_step(model, data, min(AT_ONCE, steps - done))
                lost = self.loaded.lost(data)
                if lost or self.late:
                    break
            if self.late:
                raise TimeUpError
            seconds += thread_time() - begin
            if lost or not np.all(np.isfinite(data.qpos)):
                failed = float(data.time)
                break
            for function in AFTERWARDS:  # a step leaves what it has computed before it
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

    def distances(self, run: SampledRun, positions: Array, points: Array) -> Array:
        """Return the distances of the observables of a run from positions and points of sites.

        Parameters
        ----------
        run : SampledRun
        positions, points : array (n, n_q), (n, n_sites, 3)

        Returns
        -------
        array (n, n_dofs + n_sites)
            At each time that both reached.
        """
        n = min(len(run.positions), len(positions))
        moved = np.empty((n, self.loaded.model.nv))
        for i in range(n):
            self.loaded.mujoco.mj_differentiatePos(
                self.loaded.model, moved[i], 1.0, positions[i], run.positions[i]
            )
        gaps = np.linalg.norm(run.points[:n] - points[:n], axis=2)
        return np.hstack([np.abs(moved), gaps])

    def apart(self, one: SampledRun, other: SampledRun, size: Array) -> Array:
        """Return the largest error (n,) at each time that both reached, relative to `sizes`."""
        away = self.distances(one, other.positions, other.points)[:, self.observed]
        return np.asarray(np.max(away / np.where(size > 0, size, 1.0), axis=1, initial=0.0))

    def sizes(self, run: SampledRun) -> Array:
        """Return how far the observables move in a run (n_dofs + n_sites,).

        A joint counts as moving as far as any of its kind, which turns or which slides: one that
        stands still has no size of its own.
        """
        model, n = self.loaded.model, len(run.positions)
        if not n:
            return np.ones(int(np.sum(self.observed)))
        first = np.repeat(run.positions[:1], n, axis=0), np.repeat(run.points[:1], n, axis=0)
        reach = np.max(self.distances(run, *first), axis=0, initial=0.0)
        slide, free = (
            self.loaded.of_kind("jnt_type", kind)[model.dof_jntid] for kind in ("slide", "free")
        )
        slides = slide | (free & (np.arange(model.nv) - model.jnt_dofadr[model.dof_jntid] < 3))
        for kind in (slides, ~slides):
            reach[: model.nv][kind] = np.max(reach[: model.nv][kind], initial=0.0)
        return np.asarray(reach[self.observed])


def observables(loaded: Loaded, names: tuple[str, ...]) -> tuple[Any, Any]:
    """Return the sites, and which degrees of freedom (n_v,), of these names; all joints of none.

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
    """Return the time constants [s] of the equalities that act (n,), as ``solref`` has them.

    Stiffness and damping that are given directly make one by the damping, 2 / b, or without one by
    the stiffness.
    """
    constant, ratio = model.eq_solref[model.eq_active0.astype(bool)].T
    with np.errstate(all="ignore"):
        direct = np.where(ratio < 0, -2 / ratio, 1 / np.sqrt(np.abs(constant)))
    return np.asarray(np.where(constant > 0, constant, direct))


def harden(model: Any, constant: float) -> None:
    """Give all equalities that are softer this time constant [s]; damping ratios stay."""
    factors = time_constants(model) / constant
    for number, factor in zip(np.flatnonzero(model.eq_active0), factors, strict=True):
        if factor > 1 and model.eq_solref[number, 0] > 0:
            model.eq_solref[number, 0] = constant
        elif factor > 1:
            model.eq_solref[number] *= factor**2, factor

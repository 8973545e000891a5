"""Modes of small motions about the states of a model, largest stable steps, and growing motions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Literal, NamedTuple

import numpy as np
from scipy.linalg import eig
from scipy.optimize import least_squares

from ...reference.amplification import (
    AMPLIFICATION,
    ComplexArray,
    Vibrations,
    amplification_factors,
    first_order,
    largest_stable_step,
    rates,
    surpluses,
    vibrations,
)
from ...reference.errors import UnknownNameError, UsageError
from ...reference.linear import rigid_and_elastic
from ...reference.scene import Array
from ..documents.fields import Number
from ..engines.isolation import tell
from .mujoco.facts import integrator, integrators
from .mujoco.linear import Linear, LinearMotion, LinearProbe, linearise
from .mujoco.model import OPENED, Flags, Loaded, NotFiniteError, State
from .tuning import EFFORT, NUMERICS, THRESHOLDS

SCHEMES = {
    "Euler": "semi_implicit_euler",
    "implicit": "semi_implicit_euler",
    "implicitfast": "semi_implicit_euler",
    "RK4": "RK44",
    "discrete": "semi_implicit_euler",
}
"""Integrator of MuJoCo -> published scheme, given the parts that it treats implicitly."""

RK4_REAL = 2.785293563405282
"""End of the stability interval of RK4 on the negative real axis."""

Kind = Literal["rigid", "oscillating", "decaying", "unstable"]


class Shape(NamedTuple):
    """A mode: eigenvalue [1/s], vector (nv,), kind, and the coordinate with most kinetic energy.

    A complex pair of eigenvalues is one mode.
    """

    rate: complex
    vector: ComplexArray
    kind: Kind
    dof: int

    @property
    def omega(self) -> float:
        """Modulus of the eigenvalue [rad/s]."""
        return abs(self.rate)

    @property
    def damping_ratio(self) -> float | None:
        """``-re / omega``; None for a rigid mode."""
        return None if self.kind == "rigid" else float(-self.rate.real / self.omega) + 0.0


def shapes(directions: Array, mass: Array, damping: Array, stiffness: Array) -> tuple[Shape, ...]:
    """Return the modes of ``M a + C v + K q = 0`` within some directions, ascending in modulus.

    Directions that neither spring nor damper resists are rigid modes; they are split off first,
    because their double eigenvalue 0 would keep half its digits only.

    Parameters
    ----------
    directions : array (n, k)
    mass, damping, stiffness : array (n, n)
        Only the mass need be symmetric.
    """
    if not directions.shape[1]:
        return ()
    m, c, k = (directions.T @ matrix @ directions for matrix in (mass, damping, stiffness))
    root = 1 / np.sqrt(np.diag(m))
    m, c, k = (matrix * np.outer(root, root) for matrix in (m, c, k))
    c = c * (np.linalg.norm(c) > NUMERICS.slowest)
    k = k * (np.linalg.norm(k) > NUMERICS.slowest**2)
    free, elastic = rigid_and_elastic(m, c, k, NUMERICS.free)
    pairs = [(0j, direction.astype(complex)) for direction in free.T]
    m, c, k = (elastic.T @ matrix @ elastic for matrix in (m, c, k))
    if n := len(m):
        values, vectors = eig(first_order(Vibrations(m, c, k, c)))
        upper, top = values.imag >= 0, np.max(np.abs(values))
        least = max(NUMERICS.zero_rate * top, NUMERICS.slowest)
        values[np.abs(values) < least] = 0  # round-off of the largest
        for part in (values.real, values.imag):
            part[np.abs(part) < NUMERICS.free * top] = 0
        pairs += [
            (rate, elastic @ vector)
            for rate, vector in zip(values[upper].tolist(), vectors[:n, upper].T, strict=True)
        ]
    modes = []
    for rate, inner in pairs:
        vector = directions @ (root * inner)
        dof = int(np.argmax((vector.conj() * (mass @ vector)).real))  # share of kinetic energy
        modes.append(Shape(rate, vector, kind_of_rate(rate), dof))
    return tuple(sorted(modes, key=lambda mode: (mode.omega, mode.rate.imag)))


def kind_of_rate(rate: complex) -> Kind:
    """Return the kind of a mode with an eigenvalue."""
    if rate == 0:
        return "rigid"
    if rate.real > NUMERICS.zero_rate * abs(rate):
        return "unstable"
    return "oscillating" if rate.imag else "decaying"


# Largest stable steps -------------------------------------------------------------------------


def longest_step(
    integrator: str,
    at: Callable[[float], LinearMotion],
    modes: Sequence[Shape],
    raised_from: float = np.inf,
    full_up_to: int = NUMERICS.full_matrix_dofs,
) -> tuple[float, Shape | None]:
    """Return the longest step [s] that keeps small motions bounded, and the mode that sets it.

    Up to a number of degrees of freedom the matrix of a step decides, above it each mode alone,
    which is exact where damping does not couple modes. Rigid modes are split off from that matrix,
    see `shapes`: round-off of their multiple eigenvalue 1 is no growth. The mode is None if all
    steps are stable.

    Parameters
    ----------
    integrator : str
    at : callable
        From a step to the motions, which depend on it beyond ``raised_from`` [s].
    modes : sequence of Shape
        Modes for short steps.
    """
    if not any(mode.omega for mode in modes):
        return np.inf, None
    motion = at(NUMERICS.short_step)
    scheme, full = SCHEMES[integrator], len(motion.mass) <= full_up_to
    elastic = np.eye(len(motion.mass))
    if full:
        unit = scaled(motion)
        resisting = np.vstack([unit.damping, unit.late_damping, unit.late_stiffness])
        elastic = rigid_and_elastic(unit.mass, resisting, unit.stiffness, NUMERICS.free)[1]
    if not elastic.shape[1]:
        return np.inf, None

    def reduced(motion: LinearMotion) -> LinearMotion:
        if not full:
            return modal(motion, modes)
        return LinearMotion(*(elastic.T @ matrix @ elastic for matrix in scaled(motion)))

    short = reduced(motion)
    fixed = vibrations(*short[:4]) if full and not np.any(short.late_stiffness) else None
    undamped = short.vibrations(0.0)
    horizon = NUMERICS.horizon_radians / float(np.max(np.abs(rates(undamped))))

    def reduced_at(step: float) -> LinearMotion:
        return reduced(at(step)) if step > raised_from else short

    def vibrations_at(step: float) -> tuple[Vibrations, ComplexArray]:
        of = reduced_at(step)
        late = fixed if fixed and of is short else of.vibrations(step)
        return late, rates(of.vibrations(0.0))

    limit = largest_stable_step(
        scheme, undamped, horizon, at=vibrations_at,
        folds=NUMERICS.growth_folds, scan=NUMERICS.scanned_steps,
    )  # fmt: skip
    if not 0 < limit < np.inf:
        return limit, None
    step = 1.001 * limit
    beyond = reduced_at(step)

    def excess(factors: ComplexArray, of: LinearMotion) -> Array:
        return surpluses(factors, rates(of.vibrations(0.0)), step, horizon, NUMERICS.growth_folds)

    if full:
        values, vectors = np.linalg.eig(AMPLIFICATION[scheme](beyond.vibrations(step), step))
        worst = np.argmax(excess(values, beyond))
        return limit, most_similar(elastic @ vectors[: len(beyond.mass), worst], motion, modes)
    single = [LinearMotion(*(part[i : i + 1] for part in beyond)) for i in range(len(modes))]
    factors = (amplification_factors(scheme, x.vibrations(step), step) for x in single)
    most = [np.max(excess(f, x)) for f, x in zip(factors, single, strict=True)]
    return limit, modes[int(np.argmax(most))]


def scaled(motion: LinearMotion) -> LinearMotion:
    """Return the same motions with unit inertias."""
    root = 1 / np.sqrt(np.diag(motion.mass))
    return LinearMotion(*(matrix * np.outer(root, root) for matrix in motion))


def modal(motion: LinearMotion, modes: Sequence[Shape]) -> LinearMotion:
    """Return each mode as a separate motion, arrays (k, 1, 1), by Rayleigh's quotients."""
    vectors = np.array([mode.vector for mode in modes]).T
    with np.errstate(all="ignore"):
        parts = [
            np.sum(vectors.conj() * (matrix @ vectors), axis=0).real[:, None, None]
            for matrix in motion
        ]
    moves = np.array([mode.kind != "rigid" for mode in modes])[:, None, None]
    return LinearMotion(np.ones_like(parts[0]), *(moves * part / parts[0] for part in parts[1:]))


def most_similar(vector: ComplexArray, motion: LinearMotion, modes: Sequence[Shape]) -> Shape:
    """Return the mode nearest to a vector (n,) of motions with unit inertias."""
    root = np.sqrt(np.diag(motion.mass))
    shares = [
        abs(np.vdot(root * mode.vector, vector)) / np.linalg.norm(root * mode.vector)
        for mode in modes
    ]
    least = NUMERICS.similar_shape * max(shares)
    near = [mode for mode, share in zip(modes, shares, strict=True) if share > least]
    return max(near, key=lambda mode: mode.omega)


# States ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class View:
    """A state, and small motions about it.

    Attributes
    ----------
    state : State
    linear : Linear or None
    modes : tuple of Shape
        Modes with loops closed exactly.
    simulated : tuple of Shape
        Modes with all constraints as soft as MuJoCo has them.
    reason : str or None
        Reason why there are no modes.
    failed : bool
        True if the reason is that forces are not finite.
    steady_hinge : str or None
        Hinge that turns steadily.
    """

    state: State
    linear: Linear | None = None
    modes: tuple[Shape, ...] = ()
    simulated: tuple[Shape, ...] = ()
    reason: str | None = None
    failed: bool = False
    steady_hinge: str | None = None

    @property
    def moving_dofs(self) -> Flags:
        """Degrees of freedom (nv,) of small motions: a steady hinge keeps its speed."""
        return np.asarray((self.state.velocity == 0) | (self.steady_hinge is None))


@dataclass(frozen=True)
class StepLimit:
    """Largest stable step of an integrator over all states.

    Attributes
    ----------
    integrator : str
        integrator, as MJCF spells it
    limit : float
        largest stable step [s]; null if every step is stable
    state : str or None
        state with the smallest limit; null if every step is stable
    omega : float or None
        modulus of the eigenvalue of the mode that sets the limit [1/s]; null if there is none
    joint : str or None
        joint with most kinetic energy in that mode; null if there is none
    of_file : bool
        true for the integrator of the file
    constraint : str or None
        closure, limit, contact or dry friction that sets the limit; null if none does
    softened : float
        step from which on MuJoCo softens constraints [s] (refsafe); null if it softens none
    """

    integrator: str
    limit: Number
    state: str | None
    omega: float | None
    joint: str | None
    of_file: bool
    constraint: str | None = None
    softened: Number = math.inf

    @property
    def place(self) -> str:
        """Name of the constraint or joint that sets the limit."""
        return self.constraint or str(self.joint)

    def share_of(self, step: float) -> float:
        """Return a step [s] as a share of the limit; 0 if nothing limits it."""
        return step / self.limit if self.limit > 0 else math.inf


def state_views(
    loaded: Loaded, about_rotation: Mapping[str, float | str] | None, modes: bool | None
) -> tuple[View, ...]:
    """Return the states of a model with their modes; see `inspect`.

    Raises
    ------
    UsageError
        If there is no such rotation.
    """
    most, about_rotation = EFFORT.max_states, about_rotation or {}
    reasons = [why_no_modes(loaded, state, modes) for state in loaded.states[:most]]
    reasons += [f"modes are computed for the first {most} states only"] * len(loaded.states)
    views = [
        view_of(loaded, state) if reason is None else View(state, reason=reason)
        for state, reason in zip(loaded.states, reasons, strict=False)
    ]
    if len(about_rotation) > 1:
        raise UsageError("one hinge can turn steadily, not several")
    views += [
        view_of(loaded, steady_rotation(loaded, joint, speed), joint)
        for joint, speed in about_rotation.items()
    ]
    return tuple(views)


def view_of(loaded: Loaded, state: State, steady_hinge: str | None = None) -> View:
    """Return a state with its modes, or the reason why it has none."""
    try:
        linear = linearise(loaded, state)
    except NotFiniteError as error:
        return View(state, reason=str(error), failed=True)
    except np.linalg.LinAlgError as error:
        return View(state, reason=f"the mass matrix is singular ({error})", failed=True)
    if linear.closed and np.any(state.velocity):
        return View(state, reason="closed loops move: their small motions are not constant")
    bare = View(state, linear, steady_hinge=steady_hinge)
    moving = np.eye(loaded.model.nv)[:, bare.moving_dofs]
    free = linear.free if steady_hinge is None else moving
    modes = shapes(free, linear.mass, linear.parts.damping, linear.parts.stiffness)
    motion = linear.motion(integrator(loaded), float(loaded.model.opt.timestep))
    soft = len(linear.rows.weight) or linear.closed
    return replace(bare, modes=modes, simulated=shapes(moving, *motion[:3]) if soft else modes)


def why_no_modes(loaded: Loaded, state: State, wanted: bool | None) -> str | None:
    """Return the reason why modes of a state are not computed, if they are not."""
    nv, ball = loaded.model.nv, loaded.of_kind("jnt_type", "free", "ball")
    ends, many = np.append(loaded.model.jnt_dofadr, nv)[1:][ball], nv > EFFORT.max_dofs
    turns = any(np.any(state.velocity[end - 3 : end]) for end in ends)
    reasons = {
        "nothing can move": nv == 0,
        "switched off by --no-modes": wanted is False,
        f"{nv} degrees of freedom (--modes finds them)": wanted is None and many,
        f"a flex with {nv} degrees of freedom": loaded.model.nflex and many,
        "a ball or free joint turns: its small motions are not constant": turns,
    }
    return next((words for words, applies in reasons.items() if applies), None)


def step_limits(loaded: Loaded, views: Sequence[View]) -> tuple[StepLimit, ...]:
    """Return the largest stable step of each integrator, and the state that limits it most."""
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
        Name of the integrator.
    views : sequence of View
    known : dict, optional
        Limits of integrators that treat the same parts implicitly; it is added to.
    """
    known = {} if known is None else known
    best = StepLimit(name, math.inf, None, None, None, name == integrator(loaded))
    softened = math.inf
    for one, sliding in product(views, (False, True)):
        assert one.linear is not None
        raised = one.linear.raised_from(name)
        softened = min(softened, raised)
        if sliding and not np.any(one.linear.rows.dry):
            continue  # without friction that sticks both are the same
        at = partial(one.linear.motion, name, sliding=sliding)
        motion, modes = at(NUMERICS.short_step), one.simulated
        key = (SCHEMES[name], id(one), sliding, raised, *(part.tobytes() for part in motion[3:]))
        if sliding or (raised < np.inf and len(motion.mass) > NUMERICS.full_matrix_dofs):
            modes = shapes(np.eye(len(motion.mass))[:, one.moving_dofs], *motion[:3])
        if key not in known:
            known[key] = longest_step(name, at, modes, raised)
        limit, mode = known[key]
        if limit < best.limit:
            row = mode and one.linear.setting_row(mode.vector, mode.omega, sliding)
            omega, joint = (mode.omega, loaded.joint_names[mode.dof]) if mode else (None, None)
            best = StepLimit(name, limit, one.state.name, omega, joint, best.of_file, row)
    m, filters = loaded.model, loaded.of_kind("actuator_dyntype", "filter")
    constants = np.where(filters & (m.actuator_dynprm[:, 0] > 0), m.actuator_dynprm[:, 0], np.inf)
    constant = float(np.min(constants, initial=np.inf))
    limit = constant * (RK4_REAL if SCHEMES[name] == "RK44" else 2.0)
    if limit < best.limit:  # a filter of an actuator, which is stable up to 2 T by Euler's steps
        joint = f"activation of {loaded.name('actuator', np.argmin(constants))}"
        best = StepLimit(name, limit, OPENED, 1 / constant, joint, best.of_file)
    return replace(best, softened=softened)


# Growing motions, whatever the step ------------------------------------------------------------


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

    The step resolves this mode by `Numerics.steps_per_radian`, and all others, which RK4 must only
    not feed, by `Numerics.min_steps_per_radian`.
    """
    fastest, timestep = max(one.omega for one in view.simulated), float(loaded.model.opt.timestep)
    many, few = NUMERICS.steps_per_radian, NUMERICS.min_steps_per_radian
    step = min(timestep, 1 / max(many * mode.omega, few * fastest))
    if horizon > NUMERICS.run_steps * step:
        return None
    tell((f"a run of {horizon:.3g} s to see growth",))
    lib, model, size = loaded.mujoco, loaded.sharp(), NUMERICS.perturbation
    model.opt.integrator, model.opt.timestep = lib.mjtIntegrator.mjINT_RK4, step
    runs = [loaded.data(view.state, model) for _ in range(2)]
    direction = np.real(mode.vector)
    largest = float(np.max(np.abs(direction))) or 1.0
    lib.mj_integratePos(model, runs[1].qpos, size * direction / largest, 1.0)
    steps = max(10, int(horizon / step))
    difference, most = np.empty(model.nv), 0.0
    for i in range(steps):
        for data in runs:
            lib.mj_step(model, data)
        if i >= steps // 2:
            lib.mj_differentiatePos(model, difference, 1.0, runs[0].qpos, runs[1].qpos)
            most = max(most, float(np.max(np.abs(difference))))
    return most / size if np.isfinite(most) else np.inf


# Steady rotations -----------------------------------------------------------------------------


def steady_rotation(loaded: Loaded, joint: str, speed: float | str) -> State:
    """Find the steady motion in which a hinge turns and all other joints keep their positions.

    The search starts from the first keyframe, or `qpos0`, and uses the method of Levenberg and
    Marquardt, which does not move bodies that float freely; the hinge keeps its speed.

    Raises
    ------
    UsageError
        If there is no such hinge, or no such motion.
    """
    m, names = loaded.model, [loaded.name("joint", i) for i in range(loaded.model.njnt)]
    if joint not in names:
        raise UnknownNameError("joint", joint, names)
    if not loaded.of_kind("jnt_type", "hinge")[names.index(joint)]:
        raise UsageError(f"{joint} is not a hinge: give a hinge, which alone can turn steadily")
    if isinstance(speed, str) or not np.isfinite(speed):
        raise UsageError(f"the speed of {joint} must be a finite number [rad/s], not {speed}")
    axes, dof = np.eye(m.nv), int(m.jnt_dofadr[names.index(joint)])
    turn, others = axes[dof], np.delete(axes, dof, axis=1)
    first = loaded.states[min(1, len(loaded.states) - 1)]
    name = f"{joint} at {speed:g} rad/s"
    state = first._replace(keys=(name,), velocity=turn * speed)
    probe = LinearProbe(loaded, state)

    def moved(x: Array, angle: float = 0.0) -> Array:
        return probe.displaced(probe.scale * (others @ x) + angle * turn)

    def unbalanced(x: Array, angle: float = 0.0) -> float:
        left, size = unbalanced_forces(probe, moved(x, angle))
        return float(np.max(np.abs(left / size) @ others, initial=0.0))

    x, exact = np.zeros(others.shape[1]), dict.fromkeys(("xtol", "ftol", "gtol"), 1e-15)
    _, size = unbalanced_forces(probe, moved(x))
    if x.size:
        x = least_squares(
            lambda x: (unbalanced_forces(probe, moved(x))[0] / size) @ others,
            x,
            "3-point",
            method="lm",
            **exact,
        ).x
    excess = unbalanced(x)
    if not excess <= NUMERICS.balanced:
        raise UsageError(
            f"no steady motion was found with {name}: a share of {excess:.2g} of the forces is "
            "unbalanced; start nearer to it, with a keyframe"
        )
    for angle in NUMERICS.steady_angles:
        change = unbalanced(x, angle)
        if change > NUMERICS.steady:
            raise UsageError(
                f"a rotation of {joint} is not steady: after {angle:g} rad a share of {change:.2g} "
                "of the forces is unbalanced (gravity across the axis has this effect)"
            )
    return state._replace(position=moved(x))


def unbalanced_forces(probe: LinearProbe, position: Array) -> tuple[Array, Array]:
    """Return the unbalanced forces (nv,) in a steady motion, and the size of the acting ones."""
    velocity = probe.state.velocity
    probe.put(position, velocity)
    inertia, passive, actuator, _ = probe.forces(np.zeros_like(velocity))
    if probe.data.ne:
        raise UsageError("a model with closed loops does not rotate steadily")
    size = np.abs(inertia) + np.abs(passive) + np.abs(actuator)
    size += np.diag(probe.mass()) * max(1.0, float(np.max(velocity**2)))
    return inertia - passive - actuator, size

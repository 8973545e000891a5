"""The published one-step schemes that engines claim to use, on the reference's equations.

Running an engine's own scheme on the true equations of motion predicts the trajectory
that a correct engine must produce with a given step, rounding apart. Nothing here is
used to compute the reference.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from scipy.integrate import RK45

from ..differences import PROBE
from ..quaternions import product
from ..scene import Array, Dynamics, scalar_accelerations

Step = Callable[[Any, list[float], float], list[float]]


@dataclass(frozen=True)
class Tableau:
    """Explicit Runge-Kutta method: strictly lower triangular a, weights b; nodes sum a."""

    a: tuple[tuple[float, ...], ...]
    b: tuple[float, ...]


S5 = math.sqrt(5)

TABLEAUS = {
    "ExplicitEuler": Tableau(((),), (1,)),
    "ExplicitMidpoint": Tableau(((), (1 / 2,)), (0, 1)),
    "RK33": Tableau(((), (1 / 3,), (0, 2 / 3)), (1 / 4, 0, 3 / 4)),
    "RK44": Tableau(((), (1 / 2,), (0, 1 / 2), (0, 0, 1)), (1 / 6, 2 / 6, 2 / 6, 1 / 6)),
    "DOPRI5": Tableau(
        tuple(tuple(float(v) for v in RK45.A[i, :i]) for i in range(6)),
        tuple(float(v) for v in RK45.B),
    ),
    "RK67": Tableau(
        (
            (),
            ((5 - S5) / 10,),
            (-S5 / 10, (5 + 2 * S5) / 10),
            ((-15 + 7 * S5) / 20, (-1 + S5) / 4, (15 - 7 * S5) / 10),
            ((5 - S5) / 60, 0, 1 / 6, (15 + 7 * S5) / 60),
            ((5 + S5) / 60, 0, (9 - 5 * S5) / 12, 1 / 6, (-5 + 3 * S5) / 10),
            (1 / 6, 0, (-55 + 25 * S5) / 12, (-25 - 7 * S5) / 12, 5 - 2 * S5, (5 + S5) / 2),
        ),
        (1 / 12, 0, 0, 0, 5 / 12, 5 / 12, 1 / 12),
    ),
}
"""Explicit Runge-Kutta methods by Exudyn's names. Sources: midpoint (Runge), RK33 (Heun) and RK44
(Kutta) in Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, section II.1; DOPRI5
Dormand and Prince (1980), J. Comp. Appl. Math. 6, 19-26; RK67 Butcher (1964), J. Austral.
Math. Soc. 4, 179-194, seven stages of order 6."""


class ScalarEquations:
    """A scene's equations with plain numbers, ready for a scheme.

    With ``clock`` the drive is no function of time but an oscillator ``u'' = -omega^2 u``
    integrated along, as in an MJCF whose forcing is a body, of a scene whose drive is a cosine.
    """

    def __init__(self, dynamics: Dynamics, parameters: Any, clock: bool = False) -> None:
        self.dynamics = dynamics
        self.c = type(dynamics.coefficients(parameters))(
            *(float(value) for value in dynamics.coefficients(parameters))
        )
        self.accelerations = scalar_accelerations(dynamics, self.c)
        self.clock = clock and dynamics.drive is not None and hasattr(self.c, "omega")
        self.n = len(dynamics.coordinates) + self.clock
        self.damping = np.zeros((self.n, self.n))
        size = len(dynamics.coordinates)
        self.damping[:size, :size] = dynamics.damping_matrix(self.c)

    def start(self, state: Array, time: float) -> list[float]:
        """Return the state with the clock's position and rate put in."""
        n = len(self.dynamics.coordinates)
        q, v = [float(x) for x in state[:n]], [float(x) for x in state[n:]]
        if self.clock:
            phase = self.c.omega * time
            q.append(math.cos(phase))
            v.append(-self.c.omega * math.sin(phase))
        return q + v

    def drive(self, t: float, q: Sequence[Any]) -> Any:
        """Return the drive at a time, or where the clock stands."""
        if self.clock:
            return q[-1]
        return self.dynamics.drive(t, self.c, math) if self.dynamics.drive else 0.0

    def rates(self, t: float, x: Sequence[float]) -> list[float]:
        """Return dx/dt."""
        n = self.n
        q, v = x[:n], x[n:]
        size = n - self.clock
        a = list(self.accelerations(self.drive(t, q), q[:size], v[:size], math))
        if self.clock:
            a.append(-(self.c.omega**2) * q[-1])
        return [*v, *a]

    def mass_and_forces(self, t: float, q: Any, v: Any) -> tuple[Any, Any]:
        """Return M (n, n) and f (n,) with the clock as a unit mass on its own spring."""
        mass = self.dynamics.mass_matrix(q, self.c, math)
        if self.clock:
            mass = [[*row, 0.0] for row in mass] + [[0.0] * (self.n - 1) + [1.0]]
        return np.array(mass), self.forces(t, q, v)

    def forces(self, t: float, q: Any, v: Any, xp: Any = math) -> list[Any]:
        """Return f (n,), the clock's spring included."""
        f = list(self.dynamics.forces(self.drive(t, q), q, v, self.c, xp))
        return [*f, -(self.c.omega**2) * q[-1]] if self.clock else f


class VelocityEquations(ScalarEquations):
    """A scene's equations for its velocities w: where quaternions turn, those of their bodies.

    ``M_w w' = f_w`` with ``q' = T(q) w``, ``M_w = T' M T`` and ``f_w = T' (f - M T(q') w)``. The
    columns of T for a quaternion are those of q (0, w) / 2: w is in the frame of the body.

    Attributes
    ----------
    names : tuple of str
        Of w, as observables.
    n : int
    damping : array (n, n)
        Of the joints alone.
    """

    def __init__(self, dynamics: Dynamics, parameters: Any) -> None:
        super().__init__(dynamics, parameters)
        places = {name: i for i, name in enumerate(dynamics.coordinates)}
        self.turning = [
            [places.pop(name) for name in one.coordinates] for one in dynamics.quaternions
        ]
        self.plain = list(places.values())
        rates = (name for one in dynamics.quaternions for name in one.rates)
        self.names = (*(f"{name}_dot" for name in places), *rates)
        self.n = len(self.names)
        columns = self.columns(list(dynamics.completed({}).values())[: len(self.damping)])
        self.damping = columns.T @ self.damping @ columns

    def columns(self, q: Any, plain: float = 1.0) -> Array:
        """Return T (n_q, n), or without ``plain`` its part linear in q."""
        columns = np.zeros((len(q), self.n), dtype=np.asarray(q).dtype)
        columns[self.plain, range(len(self.plain))] = plain
        for first, places in zip(range(len(self.plain), self.n, 3), self.turning, strict=True):
            turn = [q[i] for i in places]
            for k, axis in enumerate(np.eye(3) / 2, first):
                columns[places, k] = product(turn, [0.0, *axis])
        return columns

    def mass_and_forces(self, t: float, q: Any, v: Any, xp: Any = math) -> tuple[Any, Any]:
        """Return M_w (n, n) and f_w (n,)."""
        columns, mass = self.columns(q), np.array(self.dynamics.mass_matrix(q, self.c, math))
        rates = columns @ v
        force = super().forces(t, q, rates, xp) - mass @ self.columns(rates, plain=0.0) @ v
        return columns.T @ mass @ columns, columns.T @ force

    def forces(self, t: float, q: Any, v: Any, xp: Any = math) -> Any:
        """Return f_w (n,)."""
        return self.mass_and_forces(t, q, v, xp)[1]


def explicit_runge_kutta(equations: ScalarEquations, tableau: Tableau) -> Step:
    """Return the step function of a tableau."""
    stages = [(math.fsum(row), moved(row)) for row in tableau.a]
    end = moved(tableau.b)

    def step(t: Any, x: list[float], h: float) -> list[float]:
        k: list[list[float]] = []
        for node, begin in stages:
            k.append(equations.rates(t + node * h, begin(x, h, k)))
        return end(x, h, k)

    return step


@cache
def moved(weights: tuple[float, ...]) -> Callable[..., list[float]]:
    """Return the function (x, h, k) with the value ``x + h sum(w_j k_j)``, added in their order.

    It is written out: in small lists loops over the weights take longer than the sums.
    """
    terms = [(j, w) for j, w in enumerate(weights) if w]
    if not terms:
        return lambda x, h, k: x
    total = " + ".join(f"{float(w)!r} * k_{j}" for j, w in terms)
    names, rates = (", ".join(one.format(j) for j, _ in terms) for one in ("k_{}", "k[{}]"))
    source = f"lambda x, h, k: [x_i + h * ({total}) for x_i, {names} in zip(x, {rates})]"
    function: Callable[..., list[float]] = eval(source)
    return function


def mean_acceleration(
    equations: ScalarEquations, t: Any, q: Any, v: Any, h: float, damping: Any = None
) -> Array:
    """Return ``(M + h D)^-1 f(q, v)``, by which velocities change in a step.

    ``damping`` is the function that returns D, a value of `DAMPING`; without it D is 0.
    """
    mass, f = equations.mass_and_forces(t, q, v)
    return np.linalg.solve(mass + h * damping(equations, t, q, v) if damping else mass, f)


def semi_implicit_euler(equations: ScalarEquations, damping: Callable[..., Array]) -> Step:
    """Velocity first, implicit in some damping; then position with the new velocity.

    ``v+ = v + h (M + h D)^-1 f(q, v)``, ``q+ = q + h v+``, with ``D = damping(equations, t,
    q, v)``.
    """
    n = equations.n

    def step(t: Any, x: list[float], h: float) -> list[float]:
        q, v = x[:n], x[n:]
        change = mean_acceleration(equations, t, q, v, h, damping)
        v = [v_i + h * float(a) for v_i, a in zip(v, change, strict=True)]
        return [*(q_i + h * v_i for q_i, v_i in zip(q, v, strict=True)), *v]

    return step


def joint_damping(equations: ScalarEquations, t: Any, q: list[float], v: list[float]) -> Array:
    """Return the damping of the joints alone (n, n)."""
    return equations.damping


def all_damping(equations: ScalarEquations, t: Any, q: list[float], v: list[float]) -> Array:
    """Return ``-df/dv`` (n, n), with what inertia adds to it, by complex steps."""
    places = range(equations.n)
    columns = [
        equations.forces(t, q, [complex(v[i], PROBE * (i == j)) for i in places], cmath)
        for j in places
    ]
    return -np.array(columns, dtype=complex).imag.T / PROBE


def damper_forces(equations: ScalarEquations, t: Any, q: list[float], v: list[float]) -> Array:
    """Return ``-df/dv`` (n, n) without what inertia adds, which vanishes with v."""
    return all_damping(equations, t, q, [0.0] * equations.n)


DAMPING = {
    "semi_implicit_euler": joint_damping,
    "implicit_euler_dampers": damper_forces,
    "implicit_euler_velocity": all_damping,
}
"""Which derivatives of the forces a semi-implicit Euler method takes at the end of its step."""

OF_VELOCITIES: dict[str, Any] = {"ExplicitEuler": None, **DAMPING}
"""The same of all schemes in whose step velocities do not depend on how rotations go on."""

SCHEMES: dict[str, Callable[[ScalarEquations], Step]] = {
    name: (lambda equations, tableau=tableau: explicit_runge_kutta(equations, tableau))  # type: ignore[misc]
    for name, tableau in TABLEAUS.items()
}
SCHEMES |= {
    name: (lambda equations, damping=damping: semi_implicit_euler(equations, damping))  # type: ignore[misc]
    for name, damping in DAMPING.items()
}


def integrate(
    equations: ScalarEquations,
    scheme: str,
    state: Array,
    step: float,
    samples: Array,
    start_time: float = 0.0,
) -> Array:
    """Run a scheme of `SCHEMES` with a fixed step.

    Parameters
    ----------
    equations : ScalarEquations
    scheme : str
    state : array (2 n,)
        Of the scene; the clock follows from the time.
    step : float
        Step [s].
    samples : int array (n_t,)
        Step numbers at which the state is recorded, increasing.
    start_time : float

    Returns
    -------
    array (2 n, n_t)
        NaN from the first infinite or undefined state on.
    """
    advance = SCHEMES[scheme](equations)
    x = equations.start(state, start_time)
    n = len(equations.dynamics.coordinates)
    rows = [*range(n), *range(equations.n, equations.n + n)]
    out = np.full((len(rows), len(samples)), np.nan)
    done = 0
    try:
        for column, number in enumerate(samples):
            for i in range(done, int(number)):
                x = advance(start_time + i * step, x, step)
            done = int(number)
            if not all(math.isfinite(value) for value in x):
                break
            out[:, column] = [x[row] for row in rows]
    except (OverflowError, ValueError, np.linalg.LinAlgError):
        pass  # math raises where NumPy would return inf: the scheme is unstable here
    return out

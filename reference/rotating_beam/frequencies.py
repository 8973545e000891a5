r"""Natural frequencies of `rotating_beam` about steady rotation, by several routes.

With lengths in L and times in T of (19), and the shape w(xi) of a bending vibration, the
beam that does not stretch has

    w'''' - gamma^2 (tau w')' = lambda (1 + alpha Dirac(xi - beta)) w,
    tau(xi) = delta (1 - xi) + (1 - xi^2)/2 + alpha (delta + beta) [xi < beta],

clamped at 0 and free at 1. ``lambda = omega^2`` flapwise, out of the plane of rotation;
``lambda = omega^2 + gamma^2`` chordwise, in it. These are (17), (18) with (21) put right (its
K^C has lost the bending stiffness) and any number of modes.

- `ritz`: polynomials of high degree on either side of the mass (spectral). Values from above.
- `shooting`: power series of the equation, step by step from the clamp, and the roots of the
  determinant at the free end. Shares nothing with `ritz` but the equation.
- `assumed_modes`: the paper's n bending modes of the beam at rest without mass, (12) with its
  xi_i put right: ``(sin - sinh)(1) / (cos + cosh)(1)``. Two of them make figure 3.

Engines model other continua, about a state that rotation has stretched:

- *extensible*: stiffness EA, ``1/2 EA (|r'| - 1)^2 + 1/2 EI (angle of r')'^2`` per reference
  length (absolute nodal coordinates), chordwise with the gyroscopic coupling of u and v;
- *shear_flexible*: the cross-section has an angle of its own, shear stiffness k G A and, if
  wanted, rotary inertia (geometrically exact beam).

Figure 3 names no speed (a = L). Its largest first frequencies, at beta = 0.442, 0.429 and 0.42
for 0.4, 0.8 and 1.2 kg, are what two assumed modes give at 7.76, 7.00 and 6.77 rad/s, at no
one speed all three; with three modes, or four, or converged, no speed gives any of them:
converged, none lies beyond 0.4. With two modes the crossover with the massless beam is at 0.67
near 7.5 rad/s; it is another point for each speed and each pair of masses. See
`best_mass_position`, `crossover`, `matching_speed`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import block_diag, cholesky, eigh, solve_triangular
from scipy.optimize import brentq, minimize_scalar

from ..errors import MbcheckError, ParameterError, UnknownNameError
from ..scene import Array
from .equations import RotatingBeam

PLANES = ("chordwise", "flapwise")
CONTINUA = ("inextensible", "extensible", "shear_flexible")

EPS = float(np.finfo(float).eps)


class Numbers(NamedTuple):
    """Dimensionless parameters (19) of a beam in steady rotation.

    Attributes
    ----------
    delta : float
        Hub radius a/L.
    gamma : float
        Speed T Omega.
    alpha : float
        Mass m/(rho A L).
    beta : float
        Its place d/L, 0 to 1.
    """

    delta: float = 0.0
    gamma: float = 0.0
    alpha: float = 0.0
    beta: float = 1.0


def time_unit(p: RotatingBeam) -> float:
    """T of (19) [s]."""
    return float(p.length**2 * np.sqrt(p.density * p.area / (p.youngs_modulus * p.second_moment)))


def numbers(p: RotatingBeam) -> Numbers:
    """Dimensionless parameters at the final speed ``angular_speed``."""
    return Numbers(
        delta=p.hub_radius / p.length,
        gamma=abs(p.angular_speed) * time_unit(p),
        alpha=p.mass / (p.density * p.area * p.length),
        beta=p.mass_position,
    )


def tension(n: Numbers, x: Any) -> Any:
    """Return tau(xi): the tension is gamma^2 tau EI/L^2."""
    outside = n.delta * (1 - x) + (1 - x**2) / 2
    return outside + n.alpha * (n.delta + n.beta) * (x < n.beta)


# Polynomials of high degree on either side of the mass --------------------------------------


class Table(NamedTuple):
    """Basis functions (rows) at points (columns) of all elements, with their derivatives."""

    x: Array
    weight: Array
    value: Array
    slope: Array
    curvature: Array


def element_ends(n: Numbers) -> Array:
    """Ends of the elements: one on either side of a mass inside the beam."""
    return np.array([0.0, 1.0] if n.beta in (0.0, 1.0) or n.alpha == 0 else [0.0, n.beta, 1.0])


def basis(
    ends: Array,
    degree: int,
    s: Array,
    weight: Array,
    times: int = 2,
    bend: Array | None = None,
) -> Table:
    """Legendre polynomials of one element each, integrated from the clamp.

    Integrated twice, they are clamped shapes with continuous value and slope, and their own
    energy of bending is 1: that keeps elements of any length well conditioned. Integrated
    once, they vanish at the clamp and are continuous.

    Parameters
    ----------
    ends : array (elements + 1,)
    degree : int
    s, weight : array (k,)
        Points in each element, -1 to 1, and their weights.
    times : {2, 1}
    bend : array (elements - 1,), optional
        Ratio of the slopes behind and before an inner end; 1 by default.
    """
    p = legendre.legvander(s, degree + times).T
    tables = [p]
    for _ in range(times):  # the integral from -1; what stands for P_-1 is -P_0
        last = tables[-1]
        k = np.arange(len(last) - 1)[:, None]
        tables.append((last[1:] - np.vstack([-last[:1], last[:-2]])) / (2 * k + 1))
    norm = np.sqrt(np.arange(degree) + 0.5)[:, None]
    tables = [norm * table[:degree] for table in tables[::-1]]
    # at the end all are 0 but one slope, or but two values: the element carries what is beyond
    end_slope, end_values = 2 * norm[0, 0], norm[:2, 0] * np.array([2.0, -2 / 3])
    elements = len(ends) - 1
    half = np.diff(ends) / 2
    flat_x, weights = places(ends, s, weight)
    x = flat_x.reshape(elements, -1)
    found = np.zeros((3, elements, degree, elements, len(s)))
    for e in range(elements):
        for order, table in enumerate(tables):
            found[order, e, :, e] = table * half[e] ** (times - 0.5 - order)
        for after in range(e + 1, elements):
            slope = end_slope * half[e] ** 0.5
            if times == 1:
                found[0, e, 0, after] = slope
                continue
            slope *= 1.0 if bend is None else bend[e]
            found[0, e, :2, after] = end_values[:, None] * half[e] ** 1.5
            found[0, e, 0, after] += slope * (x[after] - ends[e + 1])
            found[1, e, 0, after] = slope
    flat = found.reshape(3, elements * degree, -1)
    return Table(flat_x, weights, *flat)


def at_mass(n: Numbers, ends: Array, degree: int, times: int = 2) -> Array:
    """Values of the basis where the mass sits, times the root of its ratio alpha."""
    if n.beta == 0:
        return np.zeros(degree * (len(ends) - 1))
    end = np.ones(1)
    found: Array = np.sqrt(n.alpha) * basis(ends, degree, end, end, times).value[:, 0]
    return found


def places(ends: Array, s: Array, weight: Array) -> tuple[Array, Array]:
    """Points and weights of all elements in a row."""
    half, middle = np.diff(ends) / 2, (ends[1:] + ends[:-1]) / 2
    return (middle[:, None] + np.outer(half, s)).ravel(), np.outer(half, weight).ravel()


def gram(rows: Array, factor: Any, columns: Array | None = None) -> Array:
    """Return the integrals of products of basis functions; ``factor`` includes the weights."""
    found: Array = (rows * factor) @ (rows if columns is None else columns).T
    return found


def gauss(degree: int) -> tuple[Array, Array]:
    """Points and weights that integrate products of three such polynomials."""
    found: tuple[Array, Array] = legendre.leggauss(degree + 8)
    return found


class Found(NamedTuple):
    """Dimensionless results: frequencies, a bound on their errors, shapes at places.

    ``shapes`` (count, places) are deflections, 1 at the tip.
    """

    omega: Array
    bound: Array
    places: Array
    shapes: Array


DEGREES = (16, 24, 36, 54, 80, 120)
"""Of the polynomials, until two agree."""

AGREED = 1e-12
"""Relative difference of frequencies at which they do."""

ROUNDING = 2e-14
"""Relative rounding error that an eigenvalue is granted for each unit of cancellation."""

LOCAL = np.linspace(-1, 1, 65)
"""Points per element at which shapes are given."""

Solve = Callable[[int], tuple[Array, Array, Array]]
"""From a degree to frequencies, places and shapes."""


def converged(solve: Solve, count: int, cancellation: Callable[[Array], Any]) -> Found:
    """Raise the degree until the frequencies stand still.

    The bound is their last change, plus rounding times ``cancellation``. The change from one
    degree to the next is far above what the next leaves: convergence is exponential.
    """
    before = None
    for degree in DEGREES:
        omega, x, shapes = solve(degree)
        if before is not None:
            change = np.abs(omega - before)
            if np.all(change < (AGREED + ROUNDING * cancellation(omega)) * omega):
                bound = change + ROUNDING * cancellation(omega) * omega
                return Found(omega, bound, x, shapes / shapes[:, -1:])
        before = omega
    raise MbcheckError(
        f"{count} frequencies need polynomials of a degree above {DEGREES[-1]}: "
        "ask for fewer, or for a lower speed"
    )


def check(n: Numbers, plane: str, count: int) -> None:
    """Raise where there is nothing to solve."""
    if plane not in PLANES:
        raise UnknownNameError("plane", plane, PLANES)
    if not 0 <= n.beta <= 1:
        raise ParameterError(f"mass_position (d/L) must be between 0 and 1, not {n.beta!r}")
    if not 1 <= count <= MOST:
        raise ParameterError(f"count must be between 1 and {MOST}, not {count!r}")


MOST = 12
"""Frequencies that may be asked for."""


def ritz(n: Numbers, plane: str = "chordwise", count: int = 2) -> Found:
    """Frequencies of the inextensible beam, by polynomials: (17) with very many modes."""
    check(n, plane, count)
    ends = element_ends(n)
    shift = n.gamma**2 if plane == "chordwise" else 0.0

    def solve(degree: int) -> tuple[Array, Array, Array]:
        at, held = basis(ends, degree, *gauss(degree)), at_mass(n, ends, degree)
        mass = gram(at.value, at.weight) + np.outer(held, held)
        stiffness = gram(at.curvature, at.weight)
        stiffness += gram(at.slope, n.gamma**2 * tension(n, at.x) * at.weight)
        # the inverse problem: the lowest frequencies are the best determined
        inverse, vectors = eigh(mass, stiffness)
        omega = np.sqrt(1 / inverse[::-1][:count] - shift)
        shown = basis(ends, degree, LOCAL, 0 * LOCAL)
        return omega, shown.x, vectors[:, ::-1][:, :count].T @ shown.value

    return converged(solve, count, lambda omega: 1 + shift / omega**2)


# Power series ------------------------------------------------------------------------------

TERMS = 40
"""Of the series; with steps this short they decay below rounding."""

GRID = 0.05
"""Spacing of lambda^(1/4) at which the determinant's sign is looked at."""


def transfer(n: Numbers, load: Array, x: float, step: float) -> Array:
    """Matrices (k, 4, 4) that carry (w, w', w'', V) from x to x + step, no mass between.

    ``V = w''' - gamma^2 tau w'`` is minus the shear force and has the derivative ``load w``.
    """
    square = n.gamma**2
    tau = square * float(tension(n, x)), -square * (n.delta + x), -square / 2
    w = np.zeros((TERMS + 3, 4, len(load)))
    v = np.zeros((TERMS + 1, 4, len(load)))
    w[0, 0], w[1, 1], w[2, 2], v[0, 3] = 1, 1, 0.5, 1
    for k in range(TERMS):
        v[k + 1] = load * w[k] / (k + 1)
        slope = tau[0] * (k + 1) * w[k + 1] + tau[1] * k * w[k] + tau[2] * (k - 1) * w[k - 1]
        w[k + 3] = (v[k] + slope) / ((k + 1) * (k + 2) * (k + 3))
    degree: Array = np.arange(TERMS + 3.0)
    powers = step**degree
    rows = [powers, degree * powers / step, degree * (degree - 1) * powers / step**2]
    state = [np.tensordot(row, w, 1) for row in rows] + [np.tensordot(powers[: TERMS + 1], v, 1)]
    return np.moveaxis(np.array(state), 2, 0)


def free_end_determinant(n: Numbers, load: Array, refine: int = 1) -> Array:
    """Return numbers (k,) that vanish where ``load = lambda`` (k,) belongs to a vibration.

    The two solutions that the clamp permits are orthonormalised after each step: they would
    else become parallel. That changes the determinant by a positive factor only.
    """
    grown = 1 + n.gamma * np.sqrt(float(tension(n, 0.0))) + float(np.max(load)) ** 0.25
    edges = [0.0, n.beta, 1.0] if 0 < n.beta < 1 else [0.0, 1.0]
    two = np.eye(4)[:, 2:]
    for left, right in pairwise(edges):
        steps = refine * int(np.ceil((right - left) * grown))
        step = (right - left) / steps
        for i in range(steps):
            two, upper = np.linalg.qr(transfer(n, load, left + i * step, step) @ two)
            two = two * np.sign(np.diagonal(upper, axis1=1, axis2=2))[:, None, :]
        if right == n.beta:
            two[:, 3] += (load * n.alpha)[:, None] * two[:, 0]
    found: Array = two[:, 2, 0] * two[:, 3, 1] - two[:, 2, 1] * two[:, 3, 0]
    return found


def shooting(n: Numbers, plane: str = "chordwise", count: int = 2) -> tuple[Array, Array]:
    """Frequencies of the inextensible beam, by power series; with a bound on their errors.

    Returns
    -------
    omega, bound : array (count,)
        Dimensionless; the bound is what halving the steps changes, and rounding.
    """
    check(n, plane, count)
    shift = n.gamma**2 if plane == "chordwise" else 0.0

    def determinant(root: float, refine: int) -> float:
        return float(free_end_determinant(n, np.array([root**4]), refine)[0])

    roots: list[tuple[float, float]] = []
    grid: Array = GRID * np.arange(1.0, 2 + int(np.pi / GRID))  # a root in each pi, or nearly
    while len(roots) < count:
        signs = np.sign(free_end_determinant(n, grid**4))
        for i in np.flatnonzero(signs[:-1] * signs[1:] < 0):
            ends = grid[i], grid[i + 1]
            pair = [brentq(determinant, *ends, (r,), xtol=1e-15, rtol=4 * EPS) for r in (1, 2)]
            roots.append((pair[0], pair[1]))
        grid = grid[-1] + GRID * np.arange(len(grid))
    coarse, fine = np.sqrt(np.array(roots[:count]).T ** 4 - shift)
    pull = 40 * EPS * n.gamma**2 * float(tension(n, 0.0))  # what a strong tension costs
    return fine, np.abs(fine - coarse) + (4 * ROUNDING * (1 + shift / fine**2) + pull) * fine


# The paper's assumed modes -----------------------------------------------------------------


def rest_roots(count: int) -> Array:
    """Return the roots of ``cos cosh = -1``, (11) with its signs put right."""

    def scaled(k: float) -> float:
        return float(np.cos(k) + 1 / np.cosh(k))

    return np.array([brentq(scaled, i * np.pi, (i + 1) * np.pi, xtol=1e-15) for i in range(count)])


def rest_modes(x: Any, count: int) -> tuple[Array, Array, Array]:
    """Modes (12) of the beam at rest without a mass, put right; first and second derivatives.

    Written with exponentials that decay, so that high modes keep their digits.

    Parameters
    ----------
    x : array (points,)
        Places, 0 to 1.
    count : int
    """
    k = rest_roots(count)[:, None]
    z = k * np.atleast_1d(x)
    # cosh - q sinh = (1 - q)/2 e^z + (1 + q)/2 e^-z, and 1 - q is of order e^-k
    down = np.exp(-k)
    below = 1 - down**2 + 2 * np.sin(k) * down  # 2 e^-k (sinh + sin)
    less = 2 * down * (np.sin(k) - np.cos(k) - down) / below  # 1 - q, q = (cosh + cos)/(sinh + sin)
    q = 1 - less
    rising = less * np.exp(z) / 2
    falling = (1 + q) * np.exp(-z) / 2
    return (
        rising + falling - np.cos(z) + q * np.sin(z),
        k * (rising - falling + np.sin(z) + q * np.cos(z)),
        k**2 * (rising + falling + np.cos(z) - q * np.sin(z)),
    )


class Matrices(NamedTuple):
    """Dimensionless matrices of (18), each (modes, modes): M_22, K_2 and D_1."""

    mass: Array
    bending: Array
    centrifugal: Array


def assumed_mode_matrices(n: Numbers, modes: int = 2) -> Matrices:
    """Matrices of (18): D_1 with the hub, once."""
    at = np.array([0.0, n.beta, 1.0]) if 0 < n.beta < 1 else np.array([0.0, 1.0])
    s, weight = legendre.leggauss(24 + 6 * modes)
    x, w = places(at, s, weight)
    value, slope, curvature = rest_modes(x, modes)
    mass = gram(value, w)
    at_mass = rest_modes(n.beta, modes)[0]
    return Matrices(
        mass=mass + n.alpha * at_mass @ at_mass.T,
        bending=gram(curvature, w),
        centrifugal=gram(slope, w * tension(n, x)),
    )


def assumed_modes(
    n: Numbers, modes: int = 2, plane: str = "chordwise", count: int = 1, as_printed: bool = False
) -> Array:
    """Frequencies (count,) of (18), dimensionless, with so many bending modes.

    With ``as_printed`` those of (21): without the bending stiffness, proportional to gamma.
    """
    check(n, plane, count)
    if modes < count:
        raise ParameterError(f"{count} frequencies need as many modes, not {modes}")
    found = assumed_mode_matrices(n, modes)
    shift = n.gamma**2 if plane == "chordwise" else 0.0
    stiffness = n.gamma**2 * found.centrifugal + (0 if as_printed else found.bending)
    squares = eigh(stiffness, found.mass, eigvals_only=True)[:count] - shift
    return np.sqrt(np.maximum(squares, 0.0))


def first_frequency(n: Numbers, modes: int | None = None) -> float:
    """First chordwise frequency, dimensionless, with n assumed modes or (None) converged."""
    found = ritz(n, "chordwise", 1).omega if modes is None else assumed_modes(n, modes)
    return float(found[0])


def best_mass_position(n: Numbers, modes: int | None = None) -> float:
    """Return the beta at which the first chordwise frequency is largest: figure 3.

    Parameters
    ----------
    n : Numbers
        Its beta is ignored.
    modes : int, optional
        So many assumed modes; converged by default.
    """

    def lower(beta: float) -> float:
        return -first_frequency(n._replace(beta=beta), modes)

    grid = np.linspace(0.04, 1, 25)
    top = int(np.argmin([lower(beta) for beta in grid]))
    around = grid[max(top - 1, 0)], grid[min(top + 1, len(grid) - 1)]
    return float(minimize_scalar(lower, bounds=around, options={"xatol": 1e-6}).x)


def crossover(n: Numbers, other: float = 0.0, modes: int | None = None) -> float:
    """Return the largest beta at which two masses give the same first chordwise frequency.

    NaN where there is none: at low speed a mass lowers the frequency wherever it sits.

    Parameters
    ----------
    n : Numbers
        Its beta is ignored.
    other : float
        The other mass ratio.
    modes : int, optional
        So many assumed modes; converged by default.
    """
    at_other = None if other else first_frequency(n._replace(alpha=0.0), modes)

    def difference(beta: float) -> float:
        one = first_frequency(n._replace(beta=beta), modes)
        return one - (at_other or first_frequency(n._replace(beta=beta, alpha=other), modes))

    grid = np.linspace(1, 0.05, 20)
    before = difference(grid[0])
    for i in range(1, len(grid)):
        now = difference(grid[i])
        if before < 0 <= now:
            return float(brentq(difference, grid[i], grid[i - 1], xtol=1e-9))
        before = now
    return float("nan")


def matching_speed(n: Numbers, position: float, modes: int | None = None) -> float:
    """Return the lowest gamma at which `best_mass_position` is this; NaN where none is.

    Parameters
    ----------
    n : Numbers
        Its beta and gamma are ignored.
    position : float
    modes : int, optional
        So many assumed modes; converged by default.
    """

    def excess(gamma: float) -> float:
        return best_mass_position(n._replace(gamma=gamma), modes) - position

    grid = np.geomspace(*MATCHED, 13)
    before = excess(grid[0])
    for low, high in pairwise(grid):
        after = excess(high)
        if before < 0 <= after:
            return float(brentq(excess, low, high, rtol=1e-4))
        before = after
    return float("nan")


MATCHED = (2.0, 200.0)
"""Range of gamma that is looked through."""


# Continua that stretch ---------------------------------------------------------------------


class Stretched(NamedTuple):
    """Steady rotation of a beam that stretches, at places: y = (a + X)/L, and N L^2/EI."""

    y: Array
    force: Array


def steady_state(n: Numbers, slenderness: float) -> Callable[[Array, Any], Stretched]:
    """Return ``(places, element numbers) -> Stretched``: ``y'' = -(gamma^2/slenderness) y``.

    Parameters
    ----------
    n : Numbers
    slenderness : float
        EA L^2 / EI.

    Raises
    ------
    ParameterError
        If the beam is torn apart.
    """
    k = n.gamma / np.sqrt(slenderness)

    def sine(x: Any) -> Any:
        """sin(k x)/k."""
        return x * np.sinc(k * x / np.pi)

    # y = delta cos k x + b sin(k x)/k, less jump sin(k (x - beta))/k beyond the mass
    # where y' jumps by alpha k^2 y(beta); and y' = 1 at the end, beyond the mass
    beyond, square = np.cos(k * (1 - n.beta)), k**2
    per_b = np.cos(k) - n.alpha * square * sine(n.beta) * beyond
    if k >= np.pi / 2 or per_b <= 0:
        raise ParameterError("at this speed the beam stretches without end: EA is too small")
    at_mass = n.delta * np.cos(k * n.beta)
    b = (1 + n.delta * square * sine(1.0) + n.alpha * square * at_mass * beyond) / per_b
    at_mass += b * sine(n.beta)
    jump = n.alpha * square * at_mass

    def integral(x: Any, past: Any) -> Any:
        """Of y from 0 to x."""
        return n.delta * sine(x) + (b * sine(x / 2) ** 2 - jump * sine(past / 2) ** 2) * 2

    whole = integral(1.0, 1 - n.beta)

    def at(x: Array, element: Any) -> Stretched:
        beyond_mass = (element > 0) | (n.beta == 0)
        past = (x - n.beta) * beyond_mass
        force = whole - integral(x, past) + n.alpha * at_mass * ~beyond_mass
        y = n.delta * np.cos(k * x) + b * sine(x) - jump * sine(past)
        return Stretched(y, n.gamma**2 * force)

    return at


def gyroscopic_frequencies(
    mass: Array, gyroscopic: Array, stiffness: Array, count: int
) -> tuple[Array, Array]:
    """Lowest frequencies and complex shapes (count, n) of ``M a + G v + K q = 0``, G skew.

    With M and K positive definite all are real; they are found as 1/omega of a Hermitian
    matrix, so that the lowest are the best determined.
    """
    k, m = cholesky(stiffness, lower=True), cholesky(mass, lower=True)
    w = solve_triangular(k, m, lower=True)
    g = solve_triangular(k, solve_triangular(k, gyroscopic, lower=True).T, lower=True).T
    size = len(mass)
    matrix = 1j * np.block([[-g, -w], [w.T, np.zeros((size, size))]])
    inverse, vectors = eigh(matrix, subset_by_index=(2 * size - count, 2 * size - 1))
    shapes = solve_triangular(k.T, vectors[:size], lower=False)
    return 1 / inverse[::-1], shapes[:, ::-1].T


def stretching(
    n: Numbers,
    slenderness: float,
    plane: str = "chordwise",
    count: int = 2,
    shear: float | None = None,
    rotary: float = 0.0,
) -> Found:
    """Frequencies of a beam that stretches, about its stretched state.

    Parameters
    ----------
    n : Numbers
    slenderness : float
        EA L^2 / EI.
    plane : {"chordwise", "flapwise"}
    count : int
    shear : float, optional
        k G A L^2 / EI; chordwise only. Without it, cross-sections stay normal.
    rotary : float
        I/(A L^2) of the cross-section, with ``shear`` only.
    """
    check(n, plane, count)
    if shear is not None and plane != "chordwise":
        raise ParameterError("the shear-flexible beam is solved in the plane of rotation only")
    ends = element_ends(n)
    state = steady_state(n, slenderness)
    number = np.arange(len(ends) - 1)
    square = n.gamma**2
    before, behind = (1 + state(ends[1:-1], number[:-1] + i).force / slenderness for i in (0, 1))
    times = 2 if shear is None else 1

    def solve(degree: int) -> tuple[Array, Array, Array]:
        points = gauss(degree + 12)  # what is integrated is no polynomial
        v = basis(ends, degree, *points, times, behind / before)
        y, force = state(v.x, np.repeat(number, len(points[0])))
        steady = 1 + force / slenderness
        held = at_mass(n, ends, degree, times)
        mass = gram(v.value, v.weight) + np.outer(held, held)
        shown = basis(ends, degree, LOCAL, 0 * LOCAL, times, behind / before)
        spin = np.zeros_like(mass)
        if shear is None:  # the angle is v' over the stretch
            twist = v.curvature + v.slope * (square / slenderness * y / steady)
            lateral = gram(twist, v.weight / steady**2) + gram(v.slope, v.weight * force / steady)
        else:  # the angle has the same basis as v
            shearing = gram(v.slope, shear * v.weight)
            mixed = gram(v.slope, v.weight * (force - shear * steady), v.value)
            angle = gram(v.slope, v.weight)
            angle += gram(v.value, v.weight * steady * (shear * steady - force))
            spin = rotary * gram(v.value, v.weight)
            lateral = np.block([[shearing, mixed], [mixed.T, angle]])
        if plane == "flapwise":
            inverse, vectors = eigh(mass, lateral)
            omega = 1 / np.sqrt(inverse[::-1][:count])
            return omega, shown.x, vectors[:, ::-1][:, :count].T @ shown.value
        size = len(mass)
        lateral[:size, :size] -= square * mass
        if shear is not None and rotary == 0:  # the angle follows v at once
            follows = np.linalg.solve(lateral[size:, size:], lateral[size:, :size])
            lateral = lateral[:size, :size] - lateral[:size, size:] @ follows
        elif shear is not None:
            mass = block_diag(mass, spin)
        u = basis(ends, degree, *points, 1)
        carried = at_mass(n, ends, degree, 1)
        axial_mass = gram(u.value, u.weight) + np.outer(carried, carried)
        axial = gram(u.slope, slenderness * u.weight) - square * axial_mass
        turn = np.zeros((len(mass), len(axial)))
        turn[:size] = 2 * n.gamma * (gram(v.value, u.weight, u.value) + np.outer(held, carried))
        skew = block_diag(np.zeros_like(axial), np.zeros_like(mass))
        skew[len(axial) :, : len(axial)], skew[: len(axial), len(axial) :] = turn, -turn.T
        omega, shapes = gyroscopic_frequencies(
            block_diag(axial_mass, mass), skew, block_diag(axial, lateral), count
        )
        deflection = shapes[:, len(axial) : len(axial) + size] @ shown.value
        return omega, shown.x, (deflection / deflection[:, -1:]).real

    stiffest = 10 + (shear or 0.0) / 50  # as springs in series, it costs digits
    return converged(solve, count, lambda omega: stiffest * (1 + square / omega**2))


# In SI units -------------------------------------------------------------------------------


@dataclass(frozen=True)
class BeamModes:
    """Natural frequencies about steady rotation.

    Attributes
    ----------
    plane, continuum : str
    omega : array (count,)
        Circular frequencies [rad/s], ascending.
    bound : array (count,)
        On their errors [rad/s].
    places : array (k,)
        Reference coordinate x of the beam [m], 0 to L.
    shapes : array (count, k)
        Deflection of each mode there, 1 at the tip.
    """

    plane: str
    continuum: str
    omega: Array
    bound: Array
    places: Array
    shapes: Array

    @property
    def hertz(self) -> Array:
        """Frequencies [Hz]."""
        return self.omega / (2 * np.pi)


def frequencies(
    p: RotatingBeam,
    plane: str = "chordwise",
    count: int = 2,
    continuum: str = "inextensible",
    shear_stiffness: float | None = None,
    rotary_inertia: bool = False,
) -> BeamModes:
    """Lowest natural frequencies of the beam that rotates at ``angular_speed``.

    Parameters
    ----------
    p : RotatingBeam
    plane : {"chordwise", "flapwise"}
        In the plane of rotation (the hub's speed prescribed), or out of it.
    count : int
    continuum : {"inextensible", "extensible", "shear_flexible"}
        The last one chordwise only.
    shear_stiffness : float, optional
        k G A [N] of the shear-flexible beam.
    rotary_inertia : bool
        Of the shear-flexible beam's cross-sections.
    """
    if continuum not in CONTINUA:
        raise UnknownNameError("continuum", continuum, CONTINUA)
    n, unit = numbers(p), time_unit(p)
    if continuum == "inextensible":
        found = ritz(n, plane, count)
    else:
        section = p.second_moment / (p.area * p.length**2)
        if continuum == "extensible":
            found = stretching(n, 1 / section, plane, count)
        elif shear_stiffness is None:
            raise ParameterError("the shear-flexible beam needs its shear_stiffness (k G A)")
        else:
            shear = shear_stiffness * p.length**2 / (p.youngs_modulus * p.second_moment)
            rotary = section if rotary_inertia else 0.0
            found = stretching(n, 1 / section, plane, count, shear, rotary)
    return BeamModes(
        plane=plane,
        continuum=continuum,
        omega=found.omega / unit,
        bound=found.bound / unit,
        places=found.places * p.length,
        shapes=found.shapes,
    )

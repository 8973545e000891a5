r"""Approximate rotations of `hula_hoop` and their stability, equations (7)-(62) of the paper.

The ansatz is (16), (17) with a constant phase theta_0 that the paper does not have::

    theta = alpha tau + theta_0 + u_1 cos(2 alpha tau - gamma)
    q     = q_1 cos(alpha tau - beta)

Harmonic balance gives five conditions: cos and sin of alpha tau in (7), and the mean, cos
and sin of 2 alpha tau in (8). In the phase s = alpha tau + theta_0, with the complex
amplitudes q = Re(Q e^{is}), theta - s = Re(U e^{2is}) and G_n = J_n(|U|) e^{i n arg U},
they are, with no term dropped::

    (32)  (1 - alpha^2 + 2 i rho alpha) Q - eps alpha^2 (-i G_0 + G_1) = F_eq e^{-i theta_0}
    (44)  zeta_m alpha - alpha^2/2 Re(Q conj(G_0 - i G_1)) = 0
    (42)  (-4 alpha^2 (1 + I_eq) + 2 i alpha zeta_m) U
              - alpha^2/2 [Q (G_0 - i G_1) + conj(Q) (i G_1 - G_2)] = 0

The paper's solutions:

- it sets theta_0 = 0, which leaves four unknowns for five conditions, derives (44), the
  mean torque balance, and drops it;
- it keeps J_0 = 1 and J_1 = u_1/2, drops q_1 J_1 from (42) (to keep it in (44)), and loses on
  the way from (32) to (33) and (35) the term ``-eps alpha^2 u_1 sin(gamma)/2``, of which (36)
  keeps the cosine twin; (32), (42) and (44) themselves are printed right;
- the result (35), (36), (46), (47) is linear in (q_1 cos beta, q_1 sin beta, u_1 cos gamma,
  u_1 sin gamma) and (49)-(52) solve it exactly: the "Newton method for acquiring the
  accurate values" has nothing to do there, and can only be meant for the equations before
  they are truncated.

Hence three solutions: `paper_solution` as printed, `refined_solution` by Newton's method on
the untruncated (32), (42) with theta_0 = 0, and `corrected_solution` of all five.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import jv

from ..differences import by_differences
from ..errors import UnknownNameError
from ..newton import Effort, Rows, linearisation, newton
from ..scene import Array, coefficients_at
from .equations import HulaHoop, orbit_guesses

BRANCHES = ("stable", "unstable")
"""Signs of the half angle, in the order of `orbit_guesses`."""
EFFORT = Effort(jacobians=50, longest=0.5)
"""Corrections [rad] longer than this may leave the branch of a phase."""
ROUNDING = 1e-12
"""Residual, in units of the largest terms, up to which a solution counts as one."""


class Nondimensional(NamedTuple):
    """Coefficients of (7), (8)."""

    alpha: Any
    epsilon: Any
    rho: Any
    zeta_m: Any
    inertia: Any
    force: Any


def nondimensional(p: HulaHoop) -> Nondimensional:
    """Coefficients of (7), (8): alpha, epsilon, rho, zeta_m, 1 + I_eq, amplitude of F_eq.

    Each has the shape of the parameters that it depends on.

    Raises
    ------
    ParameterError
        If there is gravity, which they have not.
    """
    p.refuse_gravity("the paper's solutions of hula_hoop")
    return Nondimensional(
        alpha=2 * np.pi * p.force_frequency / p.omega_n,
        epsilon=p.free_mass / (p.main_mass + p.free_mass),
        rho=p.damping_ratio,
        zeta_m=p.hinge_damping_ratio,
        inertia=1 + p.inertia_ratio,
        force=p.force_amplitude / (p.stiffness * p.rod_length),
    )


class RotationMotion(NamedTuple):
    """q, theta and their first two derivatives by tau."""

    q: Any
    theta: Any
    q_dot: Any
    theta_dot: Any
    q_ddot: Any
    theta_ddot: Any


@dataclass(frozen=True)
class ApproximateSolution:
    """A rotation in the form (16), (17) plus a constant phase; every field has shape (...).

    Attributes
    ----------
    alpha : array
        Forcing frequency over natural frequency [1].
    q_1, beta : array
        Amplitude [1, in rod lengths] and phase lag [rad] of q.
    u_1, gamma : array
        Amplitude [rad] and phase lag [rad] of the oscillation of theta. The paper trusts
        its expansion for ``|u_1| < 0.5``. `paper_solution` gives q_1 and u_1 opposite
        signs, as printed; the others give them positive.
    theta_0 : array
        Constant phase of theta [rad].
    residual : array
        Largest absolute residual of the (nondimensional) equations it is meant to solve.
    """

    alpha: Any
    q_1: Any
    beta: Any
    u_1: Any
    gamma: Any
    theta_0: Any
    residual: Any

    def motion(self, tau: ArrayLike) -> RotationMotion:
        """Evaluate (16), (17) and derivatives at nondimensional time tau.

        Parameters
        ----------
        tau : array_like
            Broadcasts against the fields.

        Returns
        -------
        Motion
            Arrays of the broadcast shape.
        """
        phase = self.alpha * np.asarray(tau)
        eta, psi = phase - self.beta, 2 * phase - self.gamma
        f_q, f_u = self.alpha, 2 * self.alpha
        return RotationMotion(
            q=self.q_1 * np.cos(eta),
            theta=phase + self.theta_0 + self.u_1 * np.cos(psi),
            q_dot=-self.q_1 * f_q * np.sin(eta),
            theta_dot=self.alpha - self.u_1 * f_u * np.sin(psi),
            q_ddot=-self.q_1 * f_q**2 * np.cos(eta),
            theta_ddot=-self.u_1 * f_u**2 * np.cos(psi),
        )

    def state(self, t: ArrayLike, p: HulaHoop) -> Array:
        """Return the dimensional state at times t.

        Parameters
        ----------
        t : array_like, shape (n_t,)
            Times [s].
        p : HulaHoop
            The parameters the solution belongs to.

        Returns
        -------
        array, shape (4, ..., n_t)
            y [m], theta [rad, not wrapped], y_dot [m/s], theta_dot [rad/s].
        """
        length, omega_n = (np.asarray(value)[..., None] for value in (p.rod_length, p.omega_n))
        fields = (np.asarray(value)[..., None] for value in vars(self).values())
        motion = type(self)(*fields).motion(omega_n * np.asarray(t))
        return np.stack(
            np.broadcast_arrays(
                length * motion.q,
                motion.theta,
                length * omega_n * motion.q_dot,
                omega_n * motion.theta_dot,
            )
        )


def paper_solution(p: HulaHoop) -> ApproximateSolution:
    """Closed form (49)-(52) as printed; theta_0 = 0.

    arctan is the principal one, in (-pi/2, pi/2). The choice does not matter: beta + pi
    turns the signs of u_1 and q_1 and adds pi to gamma, which is the same motion.

    Parameters
    ----------
    p : HulaHoop
        Fields may be arrays of broadcast shape (...).

    Returns
    -------
    ApproximateSolution
        Its residual is that of the printed (35), (36), (46), (47), see `printed_residuals`;
        (44) is not satisfied.
    """
    c = nondimensional(p)
    stiffness = 1 - c.alpha**2
    damping = 2 * c.rho * c.alpha
    inertial = c.epsilon * c.alpha**2
    ratio = -4 * np.sqrt(4 * c.inertia**2 + (c.zeta_m / c.alpha) ** 2)  # T below (52)
    phi = np.arctan(c.zeta_m / (2 * c.alpha * c.inertia))
    with np.errstate(divide="ignore", invalid="ignore"):
        beta = np.arctan(
            (
                inertial * (stiffness * ratio - inertial * np.cos(phi) / 2)
                + c.force * damping * ratio
            )
            / (
                inertial * (-damping * ratio + inertial * np.sin(phi) / 2)
                + c.force * stiffness * ratio
            )
        )
        u_1 = inertial / (ratio * (stiffness * np.sin(beta) - damping * np.cos(beta)))
        solution = _solution(c.alpha, ratio * u_1, beta, u_1, beta - phi, 0.0)
        return _with_residual(solution, printed_residuals(solution, p))


def refined_solution(p: HulaHoop) -> ApproximateSolution:
    """Newton's method on (32), (42) with all terms and Bessel functions; theta_0 = 0.

    This is as accurate as the paper's ansatz can be made. Since the mean torque balance (44)
    stays violated, it is hardly better than `paper_solution`: the phase is missing.

    Parameters
    ----------
    p : HulaHoop
        Fields may be arrays of broadcast shape (...).

    Returns
    -------
    ApproximateSolution
        With the residual of (32), (42); NaN where Newton's method finds no solution. Where
        u_1 is not small it may be another root than the one near `paper_solution`.
    """
    alpha, *_ = np.broadcast_arrays(*nondimensional(p))
    solution, _ = _balanced(p, np.zeros(alpha.shape), free_phase=False)
    residuals = balance_residuals(solution, p)
    return _with_residual(solution, np.delete(residuals, 2, axis=0))


def corrected_solution(
    p: HulaHoop, branch: Literal["stable", "unstable"] = "stable"
) -> ApproximateSolution:
    """First-order rotation with the phase theta_0 and the mean torque balance (44) kept.

    Bessel functions are kept in full: this costs nothing, and gives the exact
    projection (Galerkin) of (7), (8) on the ansatz. Solutions come in pairs, born in a fold.

    Parameters
    ----------
    p : HulaHoop
        Fields may be arrays of broadcast shape (...).
    branch : {"stable", "unstable"}
        Which phase theta_0. On the stable branch the mean torque pushes a disturbed phase
        back; on the other it pushes it away, and the motion is a saddle. "stable" is thus
        necessary for stability and not sufficient: `floquet_multipliers` decide.

    Returns
    -------
    ApproximateSolution
        With the residual of all five equations; NaN where there is no solution.

    Raises
    ------
    UnknownNameError
        If there is no such branch.
    """
    if branch not in BRANCHES:
        raise UnknownNameError("branch", branch, BRANCHES)
    guess = orbit_guesses(p)[BRANCHES.index(branch)]
    solution, torque_slope = _balanced(p, guess[1], free_phase=True)
    solution = _where((torque_slope > 0) == (branch == "stable"), solution)
    return _with_residual(solution, balance_residuals(solution, p))


def printed_residuals(solution: ApproximateSolution, p: HulaHoop) -> Array:
    """Left-hand sides of (35), (36), (46), (47) as printed, which know no theta_0.

    Returns
    -------
    array, shape (4, ...)
    """
    c = nondimensional(p)
    q_cos, q_sin = solution.q_1 * np.cos(solution.beta), solution.q_1 * np.sin(solution.beta)
    u_cos, u_sin = solution.u_1 * np.cos(solution.gamma), solution.u_1 * np.sin(solution.gamma)
    stiffness, damping = 1 - c.alpha**2, 2 * c.rho * c.alpha
    inertial, inertia = c.epsilon * c.alpha**2, 4 * c.alpha**2 * c.inertia
    friction = 2 * c.zeta_m * c.alpha
    return np.stack(
        np.broadcast_arrays(
            stiffness * q_sin - damping * q_cos - inertial,
            stiffness * q_cos + damping * q_sin - inertial * u_cos / 2 - c.force,
            -inertia * u_sin - friction * u_cos - c.alpha**2 * q_sin / 2,
            -inertia * u_cos + friction * u_sin - c.alpha**2 * q_cos / 2,
        )
    )


def balance_residuals(solution: ApproximateSolution, p: HulaHoop) -> Array:
    """Harmonics of (7), (8) under the ansatz: (32), (44), (42) with no term dropped.

    Returns
    -------
    array, shape (5, ...)
        Coefficients of cos and sin of ``s = alpha tau + theta_0`` in (7), less the force;
        the mean of (8); coefficients of cos and sin of ``2 s`` in (8).
    """
    theta_0 = solution.theta_0
    q = solution.q_1 * np.exp(-1j * (solution.beta + theta_0))
    u = solution.u_1 * np.exp(-1j * (solution.gamma + 2 * theta_0))
    slide, mean, hinge = _balances(theta_0, q, u, nondimensional(p))
    return np.stack(np.broadcast_arrays(slide.real, -slide.imag, mean, hinge.real, -hinge.imag))


def _harmonics(u: Any) -> tuple[Any, Any, Any]:
    """Complex amplitudes of sin(theta) at s, of cos(theta) at s and at 3 s; see the top."""
    g_0, g_1, g_2 = (jv(n, np.abs(u)) * np.exp(1j * n * np.angle(u)) for n in range(3))
    return -1j * g_0 + g_1, g_0 - 1j * g_1, 1j * g_1 - g_2


def _impedance(c: Nondimensional) -> Any:
    return 1 - c.alpha**2 + 2j * c.rho * c.alpha


def _response(theta_0: Any, u: Any, c: Nondimensional) -> Any:
    """Q from (32)."""
    force = c.force * np.exp(-1j * theta_0)
    return (force + c.epsilon * c.alpha**2 * _harmonics(u)[0]) / _impedance(c)


def _balances(theta_0: Any, q: Any, u: Any, c: Nondimensional) -> tuple[Any, Any, Any]:
    """Left-hand sides of (32), (44), (42) as at the top: complex, real, complex."""
    sin_1, cos_1, cos_3 = _harmonics(u)
    slide = _impedance(c) * q - c.epsilon * c.alpha**2 * sin_1 - c.force * np.exp(-1j * theta_0)
    mean = c.zeta_m * c.alpha - c.alpha**2 / 2 * (q * np.conj(cos_1)).real
    inertia = -4 * c.alpha**2 * c.inertia + 2j * c.alpha * c.zeta_m
    hinge = inertia * u - c.alpha**2 / 2 * (q * cos_1 + np.conj(q) * cos_3)
    return slide, mean, hinge


def _balanced(p: HulaHoop, theta_0: Array, free_phase: bool) -> tuple[ApproximateSolution, Any]:
    """Solve the balances for (theta_0, Re U, Im U), Q being eliminated by (32).

    Parameters
    ----------
    theta_0 : array
        First guess; it stays where ``free_phase`` is false, when (44) is dropped.

    Returns
    -------
    solution : ApproximateSolution
        NaN where the iteration has not converged.
    torque_slope : array
        d(mean torque)/d(theta_0) along the other balances; positive: restoring.
    """
    shape, guess = theta_0.shape, theta_0.ravel()
    c = Nondimensional(*(np.broadcast_to(v, shape).ravel() for v in nondimensional(p)))

    def residual(rows: Rows, x: Array) -> Array:
        of, u = coefficients_at(c, rows), x[1] + 1j * x[2]
        _, mean, hinge = _balances(x[0], _response(x[0], u, of), u, of)
        first = mean if free_phase else x[0] - guess[rows]
        return np.stack(np.broadcast_arrays(first, hinge.real, hinge.imag))

    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        u = _response(guess, 0, c) / (-8 * c.inertia + 4j * c.zeta_m / c.alpha)  # (46), (47)
        start = np.stack([guess, u.real, u.imag])
        roots = newton(residual, linearisation(residual, by_differences), start, EFFORT)
        jacobians = np.nan_to_num(roots.jacobians)
        torque_slope = np.linalg.det(jacobians) / np.linalg.det(jacobians[:, 1:, 1:])
        phase, u = roots.unknowns[0], roots.unknowns[1] + 1j * roots.unknowns[2]
        q = _response(phase, u, c)
        scale = c.zeta_m * c.alpha + c.alpha**2 * (np.abs(q) + 4 * c.inertia * np.abs(u))
        left = np.abs(residual(np.arange(len(guess)), roots.unknowns))
        converged = np.max(left, axis=0) <= ROUNDING * scale
    beta, gamma = -np.angle(q) - phase, -np.angle(u) - 2 * phase
    values = c.alpha, np.abs(q), _wrap(beta), np.abs(u), _wrap(gamma), _wrap(phase)
    solution = _solution(*(value.reshape(shape) for value in values))
    return _where(converged.reshape(shape), solution), torque_slope.reshape(shape)


def _wrap(angle: Any) -> Any:
    """Angle in (-pi, pi]."""
    return np.pi - (np.pi - angle) % (2 * np.pi)


def _solution(*values: Any) -> ApproximateSolution:
    """Solution with fields broadcast to one shape and an unknown residual."""
    return ApproximateSolution(*np.broadcast_arrays(*values, np.nan))


def _where(condition: Any, solution: ApproximateSolution) -> ApproximateSolution:
    """Solution with NaN, but for alpha, where the condition does not hold."""
    alpha, *unknowns = vars(solution).values()
    return ApproximateSolution(alpha, *(np.where(condition, value, np.nan) for value in unknowns))


def _with_residual(solution: ApproximateSolution, residuals: Array) -> ApproximateSolution:
    return replace(solution, residual=np.max(np.abs(residuals), axis=0))

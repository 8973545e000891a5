r"""Rotations of `hula_hoop` that turn once in a period of the force, by harmonic balance.

With the phase ``s = omega t`` and ``theta = s + phi(s)``, ``phi`` periodic, equation (5) is linear
in y: its harmonics follow from those of the force and of ``sin(theta)``, whose second derivative is
what the free mass pushes with. What is left is (6) for ``phi`` alone,

    phi'' + h (1 + phi') + kappa cos(theta) y'' = 0,

which is collocated at equally spaced nodes and solved by Newton's method. A rotation that half a
period later is its own mirror image (y reversed, half a turn on) has nodes on half a period: its
``phi`` has harmonics of even order alone, y and ``sin(theta)`` those of odd order.

Orbits are smooth: a few dozen nodes leave 1e-6 rad. It is a second route to what shooting finds;
searches start with it, and shooting confirms what it finds.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..newton import Rows, correction
from ..scene import Array, coefficients_at
from .equations import Coefficients

LONGEST = 0.5
"""Longer corrections of phi [rad] are shortened to this."""

ITERATIONS = 20
"""Corrections at most."""

QUADRATIC = 1e-5
"""Correction [rad] after which no other is made: it leaves its square."""

SWING = 6.0
"""Departure of phi from its mean [rad] beyond which a search is given up."""

CHUNK = 128
"""Points whose matrices are made together; about what the cache holds."""


@dataclass(frozen=True)
class Nodes:
    """Equally spaced phases of the force, on a period or on half of it.

    Attributes
    ----------
    count : int
        Even.
    half : bool
    """

    count: int
    half: bool

    @property
    def span(self) -> float:
        """Length [rad] of what the nodes are on."""
        return np.pi if self.half else 2 * np.pi

    @cached_property
    def phases(self) -> Array:
        """The nodes s (count,) [rad]."""
        return self.span * np.arange(self.count) / self.count

    @cached_property
    def orders(self) -> Rows:
        """Orders of the harmonics of y."""
        return np.arange(1, self.count, 2) if self.half else np.arange(1, self.count // 2 + 1)

    @cached_property
    def weights(self) -> Array:
        """Weight of each harmonic, itself and its conjugate; the last of a period is both."""
        weights = np.full(len(self.orders), 2.0)
        if not self.half:
            weights[-1] = 1.0
        return weights

    @cached_property
    def derivatives(self) -> tuple[Array, Array]:
        """Matrices (count, count) that differentiate phi once and twice."""
        orders = np.fft.fftfreq(self.count, self.span / (2 * np.pi) / self.count)
        waves = np.fft.fft(np.eye(self.count), axis=0)
        second = np.fft.ifft(-(orders**2)[:, None] * waves, axis=0).real
        orders[self.count // 2] = 0.0
        return np.fft.ifft(1j * orders[:, None] * waves, axis=0).real, second

    @cached_property
    def cosines(self) -> Array:
        """Harmonics (orders, count) at the nodes."""
        return np.cos(np.outer(self.orders, self.phases))

    @cached_property
    def sines(self) -> Array:
        """Harmonics (orders, count) at the nodes."""
        return np.sin(np.outer(self.orders, self.phases))

    def waves(self, values: Array) -> Any:
        """Return the complex amplitudes (m, orders) of the harmonics of values (m, count).

        Real products: BLAS shares complex ones of this size among threads, which costs more than
        they save.
        """
        shares = self.weights / self.count
        return (values @ self.cosines.T - 1j * (values @ self.sines.T)) * shares

    @cached_property
    def pairs(self) -> Rows:
        """Differences of places (count, count), counted from the least."""
        index = np.arange(self.count)
        return index[:, None] - index + self.count - 1


@dataclass(frozen=True)
class Balance:
    """The conditions on phi at the nodes, of points with their coefficients (k,)."""

    c: Coefficients
    nodes: Nodes

    def solve(self, which: Rows, phi: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Return the solutions phi (m, count) of some points by Newton's method, and their success.

        Each point is left alone as soon as it is solved, or lost.
        """
        phi, solved = np.array(phi), np.zeros(len(which), dtype=bool)
        with np.errstate(all="ignore"):
            for begin in range(0, len(which), CHUNK):
                part = np.s_[begin : begin + CHUNK]
                phi[part], solved[part] = self._solved(which[part], phi[part])
        return phi, solved

    def _solved(self, which: Rows, phi: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Return the same of points whose matrices fit into the cache.

        Jacobians have single precision, which costs no correction more; residuals have double.
        """
        c, nodes = coefficients_at(self.c, which), self.nodes
        first, second = nodes.derivatives
        short = np.float32
        diagonal, first_short, second_short = (
            np.arange(nodes.count), first.astype(short), second.astype(short)
        )  # fmt: skip
        kappa = (c.coupling / c.inertia)[:, None]
        friction = (c.hinge_damping / (c.inertia * c.omega))[:, None]
        response, matrices, forced = self._reaction(c)
        going, solved = np.arange(len(which)), np.zeros(len(which), dtype=bool)
        for _ in range(ITERATIONS):
            x = phi[going]
            sine, cosine = np.sin(nodes.phases + x), np.cos(nodes.phases + x)
            waves = nodes.waves(sine) * response
            push = forced + waves.real @ nodes.cosines - waves.imag @ nodes.sines
            left = x @ second.T + friction * (1 + x @ first.T) + kappa * cosine * push
            factor = cosine.astype(short)
            slopes = matrices * factor[:, None, :]
            slopes *= (kappa * cosine).astype(short)[:, :, None]
            slopes += second_short
            slopes += friction.astype(short)[:, :, None] * first_short
            slopes[:, diagonal, diagonal] -= kappa * sine * push
            change, size = correction(slopes, left.T.astype(short))
            x += change.T * np.minimum(1.0, LONGEST / size)[:, None]
            phi[going] = x
            done = size < QUADRATIC
            solved[going[done]] = True
            goes_on = ~done & (np.ptp(x, axis=1) < 2 * SWING)
            going = going[goes_on]
            if not going.size:
                break
            matrices, response, forced = matrices[goes_on], response[goes_on], forced[goes_on]
            kappa, friction = kappa[goes_on], friction[goes_on]
        return phi, solved

    def _reaction(self, c: Coefficients) -> tuple[Any, Any, Array]:
        """Return the response of y'' to the harmonics (m, orders) and to the nodes of sin(theta).

        The latter are matrices (m, count, count); the response (m, count) to the force is added.
        """
        nodes = self.nodes
        orders, pairs = nodes.orders, nodes.pairs
        response = -(c.coupling * c.omega**2)[:, None] * orders**4 / impedance(c, orders)
        weights = nodes.weights[:, None] / nodes.count
        angles = (
            orders[:, None] * nodes.span * np.arange(1 - nodes.count, nodes.count) / nodes.count
        )
        kernel = response.real @ (weights * np.cos(angles))
        kernel -= response.imag @ (weights * np.sin(angles))
        first = -(c.force / impedance(c, orders[:1])[:, 0])[:, None]
        forced = np.real(first * np.exp(1j * nodes.phases))
        return response, kernel.astype(np.float32)[:, pairs], forced

    def states(self, which: Rows, phi: Array) -> Array:
        """Return the states (4, m) at s = 0 of rotations with these phi (m, count)."""
        c, nodes = coefficients_at(self.c, which), self.nodes
        orders, omega = nodes.orders, c.omega
        sines = nodes.waves(np.sin(nodes.phases + phi))
        pushed = (c.coupling * omega**2)[:, None] * orders**2 * sines
        pushed[:, 0] += c.force
        y = pushed / impedance(c, orders)
        rate = omega * (1 + phi @ nodes.derivatives[0][0])
        return np.array([y.real.sum(1), phi[:, 0], -omega * (y * orders).imag.sum(1), rate])


def impedance(c: Coefficients, orders: Rows) -> Any:
    """Return k - (M + m) (n omega)^2 + i c n omega (m, orders) [N/m]."""
    speed = c.omega[:, None] * orders
    stiffness, mass, damping = (x[:, None] for x in (c.stiffness, c.mass, c.damping))
    return stiffness - mass * speed**2 + 1j * damping * speed

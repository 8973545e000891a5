r"""rotating_beam as a chain of rigid rods with springs in their hinges.

::

    A   O====a====(2k)---h---(k)---h---(k)---h---       h = L/n, k = EI/h, n hinges
    B   O====a====-h/2-(k)---h---(k)---h---(k)-h/2-     the first half rod is part of the hub

This is the beam of an engine with rigid bodies. Coordinates are the hub's angle and the
hinges' (each rod to the one before). A rod has its own moment of inertia, rho A h^3/12; the
concentrated mass is a point of the rod that has the place d.

Both schemes converge to the inextensible beam with the second order in h: scheme A because the
spring at the clamp stands for half a cell only (with k there the order is one), scheme B
because its hinges are in the middle of the cells. The error's factor of h^2 depends on where in
its rod the mass sits: an order can be measured only with numbers of segments
that leave it there, best at an end.

In absolute angles the mass matrix has the entries ``m_ij cos(phi_i - phi_j)``, with constant m_ij:
the arm of the body nearer to the hub times the first moment of the other and of all beyond it.

Lengths are over L, as in `mbcheck.reference.rotating_beam`.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..errors import UnknownNameError
from ..scene import Array, Continuum, EquationsOfMotion
from .hub import Terms, hub_fields, of
from .parameters import Coefficients, RotatingBeam, hub_gravity, reach
from .starts import chain_start

ROOT = {"A": 2.0, "B": 1.0}
"""Spring of the first hinge over EI/h."""


class Layout(NamedTuple):
    """Hinges of a chain and the rods beyond them; lengths over L.

    Attributes
    ----------
    hinges, lengths, springs : array (n,)
        Distances from the clamp, rods, and springs over EI/L.
    """

    hinges: Array
    lengths: Array
    springs: Array


def layout(n: int, scheme: str) -> Layout:
    """Return the layout of a scheme."""
    if scheme not in ROOT:
        raise UnknownNameError("scheme", scheme, ROOT)
    hinges, lengths, springs = np.arange(n) / n, np.full(n, 1 / n), np.full(n, float(n))
    springs[0] *= ROOT[scheme]
    if scheme == "B":
        hinges = hinges + 0.5 / n
        lengths[-1] /= 2
    return Layout(hinges, lengths, springs)


class Chain(NamedTuple):
    """Hub and rods in absolute angles; all inertias in kg m^2.

    Attributes
    ----------
    coupling : array (1 + n, 1 + n)
        m_ij.
    moments : array (1 + n,)
        First moments over L, of each with all beyond it, on which gravity acts.
    springs : array (1 + n,)
        Of the hinges [N m], 0 of the hub.
    """

    coupling: Array
    moments: Array
    springs: Array


def assemble(c: Coefficients, shape: Layout) -> Chain:
    """Return the bodies of a chain."""
    start, ends = shape.hinges[0], np.append(shape.hinges[1:], np.inf)
    middle, tip = c.hub_ratio + start / 2, c.hub_ratio + c.place
    arm, rods = c.place - shape.hinges, c.beam * shape.lengths
    point = c.point * ((shape.hinges < c.place) & (c.place <= ends))
    on_hub = c.point * (c.place <= start)
    hub = c.beam * start
    moments = np.append(hub * middle + on_hub * tip, rods * shape.lengths / 2 + point * arm)
    turning = c.hub + hub * (middle**2 + start**2 / 12) + on_hub * tip**2
    inertias = np.append(turning, rods * shape.lengths**2 / 3 + point * arm**2)
    carried = np.append(beyond(rods + point), 0.0)
    arms = np.append(c.hub_ratio + start, shape.lengths)
    moments = moments + arms * carried
    coupling = np.triu(np.outer(arms, moments), 1)
    coupling = coupling + coupling.T + np.diag(inertias + arms**2 * carried)
    return Chain(coupling, moments, np.append(0.0, c.bending * shape.springs))


def beyond(values: Any) -> Any:
    """Return the sums (..., k) from each to the last."""
    return np.cumsum(values[..., ::-1], axis=-1)[..., ::-1]


def directions(q: Any) -> tuple[Any, Any]:
    """Cosines and sines (..., 1 + n) of hub and rods, in the hub frame."""
    angles = np.cumsum(np.concatenate([0 * q[..., :1], q[..., 1:]], axis=-1), axis=-1)
    return np.cos(angles), np.sin(angles)


def embedding(p: RotatingBeam, state: Mapping[str, float]) -> dict[str, float]:
    """Return the state of a chain whose rods are chords of the scene's beam."""
    return chain_start(p, state, (*layout(int(p.segments), p.scheme).hinges.tolist(), 1.0))


@lru_cache(maxsize=128)
def chain_scene(n: int, scheme: str = "A") -> EquationsOfMotion:
    """Return the chain of n hinges; the same object for the same numbers.

    Parameters
    ----------
    n : int
    scheme : {"A", "B"}
    """
    shape = layout(n, scheme)

    @lru_cache(maxsize=64)
    def chain_of(c: Coefficients) -> Chain:
        return assemble(c, shape)

    def terms(q: Any, v: Any, c: Coefficients) -> Terms:
        """Mass matrix and forces of the free hub with its chain."""
        chain, (cos, sin) = chain_of(c), directions(q)
        alike = cos[..., :, None] * cos[..., None, :] + sin[..., :, None] * sin[..., None, :]
        apart = sin[..., :, None] * cos[..., None, :] - cos[..., :, None] * sin[..., None, :]
        mass = beyond(beyond(chain.coupling * alike).swapaxes(-1, -2))
        g_x, g_y = (np.asarray(g)[..., None] for g in hub_gravity(q[..., 0], c))
        swing = of(chain.coupling * apart, np.cumsum(v, axis=-1) ** 2)
        load = beyond(chain.moments * (cos * g_y - sin * g_x) - swing)
        return Terms(mass, load - chain.springs * q)

    def potential(q: Any, c: Coefficients) -> Any:
        """Energy of the springs and potential energy of gravity [J]."""
        chain, (cos, sin) = chain_of(c), directions(q)
        g_x, g_y = (np.asarray(g)[..., None] for g in hub_gravity(q[..., 0], c))
        weight = chain.moments * (g_x * cos + g_y * sin)
        return np.sum(chain.springs * q * q / 2 - weight, axis=-1)

    def tip(q: Any, v: Any, c: Coefficients) -> tuple[Any, ...]:
        """Tip's displacement over L and its rate in the hub frame."""
        angles, rates = np.cumsum(q[..., 1:], axis=-1), np.cumsum(v[..., 1:], axis=-1)
        cos, sin, half = np.cos(angles), np.sin(angles), np.sin(angles / 2)
        terms = sin, cos * rates, -2 * half * half, -sin * rates
        return tuple(term @ shape.lengths for term in terms)

    return EquationsOfMotion(
        **hub_fields(terms, potential, tip, {f"joint_{i}": "rad" for i in range(1, n + 1)}),
        title=f"hub with a chain of {n} hinges, scheme {scheme}",
        embedding=embedding,
        stiff=(1e-11, 1e-9),
        continuum=Continuum(tuple(f"joint_{i}" for i in range(1, n + 1)), reach=reach),
    )

"""Starts of the search for rotations of `hula_hoop`: solutions of harmonic balance.

A rotation that turns once in a period of the force either repeats itself half a period later, when
the equations of motion are those of -y and theta + pi, or has a twin. The first kind is balanced
over half a period, the second over all of it, at a tenth of the cost of the period map.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ....reference.hula_hoop.balance import Balance, Nodes
from ....reference.hula_hoop.equations import Coefficients, coefficients
from ....reference.orbits import Orbits
from ....reference.scene import Array
from ..orbit_map import Ints, OrbitMap
from ..quantity import Points


class StartOptions(NamedTuple):
    """Starts of harmonic balance.

    Attributes
    ----------
    half_nodes, nodes : Nodes
        Over half a period and over all of it. They leave 1e-6 rad where the rotation is rough.
    half_starts, starts : tuple of (int, float, complex)
        Which guess, by what angle [rad] its rod is turned on, and by what complex amplitude [rad]
        it swings: at twice the frequency of the force, and at that itself. The second of the former
        finds rotations whose theta' swings by more than its mean.
    """

    half_nodes: Nodes = Nodes(16, half=True)
    nodes: Nodes = Nodes(32, half=False)
    half_starts: tuple[tuple[int, float, complex], ...] = ((0, 0.0, 0.0), (1, 5 * np.pi / 4, 0.5))
    starts: tuple[tuple[int, float, complex], ...] = (
        (0, 0.0, 1.0),
        (0, np.pi / 4, 1.6j),
        (0, 0.0, 0.5j),
    )


OPTIONS = StartOptions()


def balanced_rotations(maps: OrbitMap, known: Orbits) -> Iterator[tuple[Ints, Array]]:
    """Yield points without a stable rotation, and states from which one is sought."""
    points = maps.flow.points
    c, count = coefficients_of(points), len(points)
    guesses = [
        np.broadcast_to(guess, (4, count))
        for guess in points.scene.orbit.guesses(points.parameters)
    ]
    for nodes, starts in (
        (OPTIONS.half_nodes, OPTIONS.half_starts),
        (OPTIONS.nodes, OPTIONS.starts),
    ):
        for guess, angle, amplitude in starts:
            which = np.flatnonzero(~(known.leading < 1))
            order = 2 if nodes.half else 1
            swing = np.imag(amplitude * np.exp(1j * order * nodes.phases))
            yield balanced(c, nodes, which, guesses[guess][1, which, None] + angle + swing)


def balanced(c: Coefficients, nodes: Nodes, which: Ints, phi: Array) -> tuple[Ints, Array]:
    """Return the points that harmonic balance solves from phi (m, nodes), and their states."""
    balance = Balance(c, nodes)
    phi, solved = balance.solve(which, phi)
    return which[solved], balance.states(which[solved], phi[solved])


def coefficients_of(points: Points) -> Coefficients:
    """Return the coefficients (k,) of the reference's equations.

    Raises
    ------
    ParameterError
        If there is gravity, which no rotation is its own mirror image in.
    """
    points.parameters.refuse_gravity("maps of hula_hoop's rotations")
    values = coefficients(points.parameters)
    return Coefficients(*(np.array(np.broadcast_to(x, len(points)), float) for x in values))

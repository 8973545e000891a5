"""A hub that carries a model of the beam: equations of motion from those of the free hub.

The hub's angle is the first coordinate. Where its motion is prescribed, its row and column of the
mass matrix are those of the identity, and what its acceleration does to the others is part of the
forces. Inside, axes of points come first (the transposed of what scenes are given), so that NumPy's
matrix products run over them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg.lapack import dgesv

from ..scene import with_rates
from .parameters import (
    EQUILIBRIA,
    Coefficients,
    RotatingBeam,
    coefficients,
    conserved,
    drive,
    drive_end_time,
    period,
    unforced,
)

OUTPUTS = ("tip_deflection", "tip_deflection_dot", "tip_axial", "tip_axial_dot")


class Terms(NamedTuple):
    """``mass @ a = load`` of the free hub and its beam.

    Attributes
    ----------
    mass : array (..., N, N)
    load : array (..., N)
        Forces less the velocity-dependent inertia terms, without the drive.
    """

    mass: Any
    load: Any


def of(matrix: Any, vector: Any) -> Any:
    """Product of matrices (..., i, j) and vectors (..., j)."""
    if matrix.ndim == 2 and vector.ndim == 1:
        return matrix.dot(vector)
    return (matrix @ vector[..., None])[..., 0]


def dot(one: Any, other: Any) -> Any:
    """Scalar products of vectors (..., i)."""
    return np.sum(one * other, axis=-1)


def pointwise(function: Callable[..., Any], q: Any, v: Any, c: Coefficients, *more: Any) -> Any:
    """Return the value of a function ``(q, v, c, *more)`` for coefficients over points too.

    Points of coefficients are the last axis of states.
    """
    q, v = np.asarray(q), np.asarray(v)
    if not any(isinstance(value, np.ndarray) and value.ndim for value in c):
        return function(q, v, c, *more)
    count = max(np.size(value) for value in c)
    rows = [np.broadcast_to(value, (count,)) for value in c]
    others = [np.broadcast_to(value, (*np.shape(value)[:-1], count)) for value in more]
    parts = [
        function(
            q[..., i],
            v[..., i],
            Coefficients(*(float(row[i]) for row in rows)),
            *(other[..., i] for other in others),
        )
        for i in range(count)
    ]
    return np.stack(parts, axis=-1)


def hub_fields(
    terms: Callable[[Any, Any, Coefficients], Terms],
    potential: Callable[[Any, Coefficients], Any],
    tip: Callable[[Any, Any, Coefficients], Sequence[Any]],
    beam: Mapping[str, str],
    solve: Callable[[Any, Any, Coefficients, Any], Any] | None = None,
) -> dict[str, Any]:
    """Return the fields of `EquationsOfMotion` that all models of the beam share.

    Parameters
    ----------
    terms : callable ``(q, v, c) -> Terms``
        Of states (..., N).
    potential : callable ``(q, c) -> V``
        Energy of springs or strain, and of gravity [J].
    tip : callable ``(q, v, c) -> (value, value, value, value)``
        `OUTPUTS` over L.
    beam : mapping of str to str
        Coordinates of the beam and their units.
    solve : callable ``(q, v, c, u) -> accelerations (..., N)``, optional
        By default the mass matrix is factorised.
    """

    def driven(q: Any, v: Any, c: Coefficients, u: Any) -> Terms:
        mass, load = terms(q, v, c)
        free, u = 1 - c.prescribed, np.asarray(u)
        load = load - (c.prescribed * u)[..., None] * mass[..., 0]
        load[..., 0] = u + free * load[..., 0]
        mass = mass.copy()
        mass[..., 0, :] *= free
        mass[..., 1:, 0] *= free
        mass[..., 0, 0] += c.prescribed
        return Terms(mass, load)

    def solved(q: Any, v: Any, c: Coefficients, u: Any) -> Any:
        mass, load = driven(q, v, c, u)
        if load.ndim == 1 and load.dtype == float:
            _, _, solution, failed = dgesv(mass, load)
            return solution if not failed else np.full_like(load, np.nan)
        return np.linalg.solve(mass, load[..., None])[..., 0]

    solve = solve or solved

    def at_points(u: Any, q: Any) -> Any:
        return np.broadcast_to(u, q.shape[1:]).T

    def mass_matrix(q: Any, c: Coefficients, xp: Any = np) -> Any:
        """Mass matrix (N, N, ...); the hub's row is that of the identity if it is prescribed."""
        return pointwise(
            lambda q, v, c: driven(q.T, v.T, c, 0.0).mass.swapaxes(-1, -2).T, q, np.zeros_like(q), c
        )

    def forces(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> Any:
        """Forces less the velocity-dependent inertia terms."""
        return pointwise(lambda q, v, c, u: driven(q.T, v.T, c, at_points(u, q)).load.T, q, v, c, u)

    def accelerations(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> Any:
        """Solution of ``M a = forces``."""
        return pointwise(lambda q, v, c, u: solve(q.T, v.T, c, at_points(u, q)).T, q, v, c, u)

    def energy(q: Any, v: Any, c: Coefficients) -> Any:
        """Kinetic energy, that of springs or strain, and potential energy of gravity [J]."""
        return pointwise(
            lambda q, v, c: (dot(v.T, of(terms(q.T, v.T, c).mass, v.T)) / 2 + potential(q.T, c)).T,
            q,
            v,
            c,
        )

    def momentum(q: Any, v: Any, c: Coefficients) -> Any:
        """Angular momentum of hub, beam and mass about the axis [kg m^2/s]."""
        return pointwise(lambda q, v, c: dot(terms(q.T, v.T, c).mass[..., 0, :], v.T).T, q, v, c)

    def power(q: Any, v: Any, c: Coefficients, u: Any) -> Any:
        u, (mass, load) = at_points(u, q), terms(q.T, v.T, c)
        taken = dot(mass[..., 0, :], solve(q.T, v.T, c, u)) - load[..., 0]
        return (c.prescribed * taken + (1 - c.prescribed) * u).T * v[0]

    def powers(u: Any, q: Any, v: Any, c: Coefficients) -> dict[str, Any]:
        """Power [W] of the torque on the hub: the given one, or what its motion takes."""
        return {"hub": pointwise(power, q, v, c, u)}

    def outputs(q: Any, v: Any, c: Coefficients, xp: Any = np) -> dict[str, Any]:
        """Tip's displacement in the hub frame [m], and its rate."""
        values = pointwise(
            lambda q, v, c: c.length * np.stack([value.T for value in tip(q.T, v.T, c)]), q, v, c
        )
        return dict(zip(OUTPUTS, values, strict=True))

    def invariants(p: RotatingBeam) -> Mapping[str, Callable[..., Any]]:
        """Conserved quantities of the undriven beam."""
        return conserved(p, energy, momentum)

    return {
        "name": "rotating_beam",
        "parameters": RotatingBeam,
        "coordinates": ("theta", *beam),
        "units": with_rates(theta="rad", tip_deflection="m", tip_axial="m", **beam),
        "coefficients": coefficients,
        "drive": drive,
        "mass_matrix": mass_matrix,
        "forces": forces,
        "accelerations": accelerations,
        "damping_matrix": lambda c: np.zeros((1 + len(beam),) * 2),
        "energy": energy,
        "powers": powers,
        "equilibria": EQUILIBRIA,
        "steady_coordinates": dict.fromkeys(EQUILIBRIA, ("theta",)),
        "rotations_per_period": {"theta": 1},
        "period": period,
        "unforced": unforced,
        "outputs": outputs,
        "observed": OUTPUTS[:3],
        "invariants": invariants,
        "drive_end_time": drive_end_time,
    }

r"""rotating_beam in finite elements, discretised as Exudyn's two beams are.

Each element has 2 nodes; integrals along it, of length h, are sums over Gauss points.

- ``ancf``, absolute nodal coordinates (Gerstmayr, Irschik (2008), J. Sound Vib. 318, 461-487): a
  node has a place and a slope vector, r is cubic in between, and the strain energy is that of
  ``EA/2 (|r'| - 1)^2``, in 5 points, and of ``EI/2 (r' x r'' / |r'|^2)^2``, in 3.
- ``geometrically_exact`` (Simo, Vu-Quoc (1986), J. Appl. Mech. 53, 849-863): a node has a place and
  an angle, which are linear in between. With the axes t, n of the angle in the middle, the one
  point where it is taken, the strain energy is that of ``EA/2 (r' t - 1)^2 + k G A/2 (r' n)^2 +
  EI/2 angle'^2``; cross sections have rotary inertia.

Coordinates are the hub's angle and the displacements of the nodes in the hub frame, where the
clamp is linear: the first node keeps its place and its angle, and an ``ancf`` one may stretch.
With X of all nodes, Q turning vectors by 90 degrees and ``T = Q X`` (and 1 of an angle),
accelerations are ``theta'' T + X'' + 2 theta' Q X' + theta'^2 Q Q X``, less gravity, and the mass
matrix is constant.

The mass sits on a node. Axes of points come first inside, as in `equations`.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre

from ..differences import by_complex_step
from ..scene import Array, Continuum, EquationsOfMotion
from . import EXTENSIBLE
from .frequencies.stretching import frequencies
from .hub import Terms, dot, hub_fields
from .parameters import Coefficients, RotatingBeam, coefficients, hub_gravity, reach
from .starts import unstretched_nodes

POISSON = 0.3
"""Poisson's ratio of the shear-flexible beam; the paper's beam does not shear."""

SHEAR_FACTOR = 5 / 6
"""Shear correction factor of a rectangular cross section."""

SHEAR = SHEAR_FACTOR / (2 * (1 + POISSON))
"""k G A over E A."""

NODAL = {"ancf": ("x", "y", "slope_x", "slope_y"), "geometrically_exact": ("x", "y", "angle")}
"""Coordinates of a node by element."""

AXIAL_POINTS, BENDING_POINTS = 5, 3

STRETCHES = 3
"""Steps of Newton's method to the straight beam that rotation and weight stretch by some 1e-5."""


def shear_stiffness(p: RotatingBeam) -> float:
    """Return k G A [N] of the beam that shears."""
    return SHEAR * p.youngs_modulus * p.area


def stations(n: int, place: float) -> Array:
    """Return the nodes' distances (n + 1,) from the clamp over L: equal ones beside the mass."""
    if place == 1:
        return np.linspace(0, 1, n + 1)
    inner = min(n - 1, max(1, round(n * place)))
    ends = np.linspace(0, place, inner + 1), np.linspace(place, 1, n - inner + 1)[1:]
    return np.concatenate(ends)


def free_coordinates(nodes: int, size: int) -> Any:
    """Return which coordinates of nodes, each of so many, the clamp leaves."""
    free = np.arange(size, size * nodes)
    return np.append(2, free) if size == len(NODAL["ancf"]) else free


class Mesh(NamedTuple):
    """Constant matrices; N coordinates of all nodes, n of them free.

    Attributes
    ----------
    lengths : array
        Of the elements (n_e,) [m].
    free : array
        Places of the free coordinates (n,).
    straight : array
        Coordinates of the straight beam (N,), from the axis.
    quarter : array
        Q (N, N).
    angles : array
        1 of an angle (N,).
    axes : array
        1 of x, and of y (2, N).
    mass : array
        (N, N).
    inverse : array
        Of the mass matrix of the free coordinates (n, n).
    axial : float
        E A [N].
    bending : float
        E I [N m^2].
    stretch : float or array
        Of ANCF: r' by the coordinates of an element (n_e, 5, 4), and the points' lengths
        (n_e, 5).
    curve : float or array
        Of ANCF: r', r'' (n_e, 3, 4), and the points' lengths (n_e, 3).
    """

    lengths: Array
    free: Array
    straight: Array
    quarter: Array
    angles: Array
    axes: Array
    mass: Array
    inverse: Array
    axial: float
    bending: float
    stretch: Any
    curve: Any


def hermite(points: Array, lengths: Array) -> tuple[Array, Array]:
    """Return r' and r'' (n_e, points, 4) by the places and slopes at the ends of elements."""
    t, h = points, lengths[:, None]
    one = np.ones_like(h)
    first = [(6 * t * t - 6 * t) / h, (1 - 4 * t + 3 * t * t) * one]
    first += [-first[0], (3 * t * t - 2 * t) * one]
    second = [(12 * t - 6) / h**2, (6 * t - 4) / h]
    second += [-second[0], (6 * t - 2) / h]
    return np.stack(first, axis=-1), np.stack(second, axis=-1)


def element_mass(ancf: bool, lengths: Array, line: float, rotary: float) -> Array:
    """Return the consistent mass matrices (n_e, 2 k, 2 k) of elements with k coordinates a node."""
    h = lengths[:, None, None]
    if ancf:
        one = np.ones_like(h)
        scale = np.concatenate([one, h, one, h], axis=1)
        shape = np.array(
            [[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]
        )
        return np.kron(line * h * shape * scale * scale.swapaxes(1, 2) / 420, np.eye(2)[None])
    section = np.diag([line, line, rotary])
    return h * np.kron(np.array([[2, 1], [1, 2]]) / 6, section)[None]


@lru_cache(maxsize=128)
def mesh(n: int, element: str, c: Coefficients) -> Mesh:
    """Return the mesh of n elements."""
    ancf, size = element == "ancf", len(NODAL[element])
    place = float(c.place)
    at = c.length * stations(n, place)
    lengths = np.diff(at)
    line, bending, axial = c.beam / c.length**3, c.bending * c.length, c.axial / c.length
    total = size * (n + 1)
    mass = np.zeros((total, total))
    blocks = element_mass(ancf, lengths, line, line * bending / axial)
    for i, block in enumerate(blocks):
        mass[size * i : size * (i + 2), size * i : size * (i + 2)] += block
    carrier = size * int(np.argmin(np.abs(at - place * c.length)))
    for i in (carrier, carrier + 1):
        mass[i, i] += c.point / c.length**2
    straight = np.zeros((n + 1, size))
    straight[:, 0] = c.hub_ratio * c.length + at
    straight[:, 2] = ancf
    rotate = np.zeros((size, size))
    rotate[:2, :2] = [[0, -1], [1, 0]]
    angles = np.zeros(size)
    if ancf:
        rotate[2:, 2:] = [[0, -1], [1, 0]]
    else:
        angles[2] = 1
    axes = np.tile(np.eye(2, size), n + 1)
    free = free_coordinates(n + 1, size)
    stretch = curve = None
    if ancf:
        points, weights = legendre.leggauss(AXIAL_POINTS)
        stretch = hermite((1 + points) / 2, lengths)[0], lengths[:, None] * weights / 2
        points, weights = legendre.leggauss(BENDING_POINTS)
        curve = *hermite((1 + points) / 2, lengths), lengths[:, None] * weights / 2
    return Mesh(
        lengths=lengths,
        free=free,
        straight=straight.ravel(),
        quarter=np.asarray(np.kron(np.eye(n + 1), rotate), dtype=float),
        angles=np.tile(angles, n + 1),
        axes=axes,
        mass=mass,
        inverse=np.asarray(np.linalg.inv(mass[np.ix_(free, free)]), dtype=float),
        axial=axial,
        bending=bending,
        stretch=stretch,
        curve=curve,
    )


def ends_of(shape: Any, size: int) -> Any:
    """Coordinates (..., n_e, 2, size) of both ends of elements from those of the nodes (..., N)."""
    nodes = shape.reshape(*shape.shape[:-1], -1, size)
    return np.stack([nodes[..., :-1, :], nodes[..., 1:, :]], axis=-2)


def on_nodes(forces: Any) -> Any:
    """Forces (..., N) on the nodes from those on both ends of elements (..., n_e, 2, size)."""
    *points, count, _, size = forces.shape
    total = np.zeros((*points, count + 1, size), dtype=forces.dtype)
    total[..., :-1, :] += forces[..., 0, :]
    total[..., 1:, :] += forces[..., 1, :]
    return total.reshape(*points, -1)


class Strains(NamedTuple):
    """Strain energy [J], and the forces against it on the nodes (..., N)."""

    energy: Any
    forces: Any


def ancf_strains(shape: Any, beam: Mesh) -> Strains:
    """Return the strain energy of displacements (..., N) of the nodes, and its derivatives."""
    ends = ends_of(shape, 4)
    ends = ends.reshape(*ends.shape[:-2], 4, 2)
    slopes, weights = beam.stretch
    moved = slopes @ ends  # r' - (1, 0)
    x, y = 1 + moved[..., 0], moved[..., 1]
    size = np.sqrt(x * x + y * y)
    strain = (moved[..., 0] * (2 + moved[..., 0]) + y * y) / (1 + size)
    normal = beam.axial * weights * strain
    energy = np.sum(normal * strain, axis=(-2, -1)) / 2
    pull = np.stack([x, y], axis=-1) * (normal / size)[..., None]
    forces = slopes.swapaxes(-1, -2) @ pull
    slopes, curves, weights = beam.curve
    first, second = slopes @ ends, curves @ ends
    x, y = 1 + first[..., 0], first[..., 1]
    x2, y2 = second[..., 0], second[..., 1]
    square = x * x + y * y
    bend = (x * y2 - y * x2) / square
    moment = beam.bending * weights * bend
    energy = energy + np.sum(moment * bend, axis=(-2, -1)) / 2
    share = (moment / square)[..., None]
    twist = np.stack([-y, x], axis=-1) * share
    lost = np.stack([y2 - 2 * bend * x, -x2 - 2 * bend * y], axis=-1) * share
    forces = forces + slopes.swapaxes(-1, -2) @ lost + curves.swapaxes(-1, -2) @ twist
    return Strains(energy, -on_nodes(forces.reshape(*forces.shape[:-2], 2, 4)))


def shearing_strains(shape: Any, beam: Mesh) -> Strains:
    """Return the strain energy of displacements (..., N) of the nodes, and its derivatives."""
    ends = ends_of(shape, 3)
    change = (ends[..., 1, :] - ends[..., 0, :]) / beam.lengths[:, None]
    angle = (ends[..., 1, 2] + ends[..., 0, 2]) / 2
    x, y = change[..., 0], change[..., 1]
    cos, sin, half = np.cos(angle), np.sin(angle), np.sin(angle / 2)
    stretch = x * cos + y * sin - 2 * half * half
    shear = y * cos - x * sin - sin
    normal, across, moment = (
        beam.axial * stretch,
        SHEAR * beam.axial * shear,
        beam.bending * change[..., 2],
    )
    density = normal * stretch + across * shear + moment * change[..., 2]
    twist = (normal * shear - across * (1 + stretch)) * beam.lengths / 2
    along = cos * normal - sin * across, sin * normal + cos * across
    first = np.stack([-along[0], -along[1], twist - moment], axis=-1)
    last = np.stack([along[0], along[1], twist + moment], axis=-1)
    forces = -on_nodes(np.stack([first, last], axis=-2))
    return Strains(np.sum(density * beam.lengths, axis=-1) / 2, forces)


STRAINS = {"ancf": ancf_strains, "geometrically_exact": shearing_strains}


class Bordered(NamedTuple):
    """Mass matrix and load of hub and free coordinates, as blocks.

    Attributes
    ----------
    hub : array (...,)
    coupling : array (..., n)
        First row of the mass matrix.
    brake : array (...,)
    load : array (..., n)
        Forces less the velocity-dependent inertia terms.
    """

    hub: Any
    coupling: Any
    brake: Any
    load: Any


def bordered(q: Any, v: Any, c: Coefficients, beam: Mesh, strains: Any) -> Bordered:
    """Return the terms of the equations of motion of states (..., 1 + n)."""
    shape, rates = spread(q, beam), spread(v, beam)
    at = beam.straight + shape
    turn = beam.angles + at @ beam.quarter.T
    carried = turn @ beam.mass
    speed = v[..., :1]
    swing = speed * (2 * rates @ beam.quarter.T + speed * (at @ (beam.quarter @ beam.quarter).T))
    inertia = (swing - weight_of(q, c, beam)) @ beam.mass
    load = strains(shape, beam).forces - inertia
    hub, brake = c.hub + dot(carried, turn), -dot(turn, inertia)
    return Bordered(hub, carried[..., beam.free], brake, load[..., beam.free])


def weight_of(q: Any, c: Coefficients, beam: Mesh) -> Any:
    """Gravity as an acceleration (..., N) of the nodes, in the hub frame."""
    gravity = np.stack(hub_gravity(q[..., 0], c), axis=-1)
    return c.length * gravity @ beam.axes


def spread(values: Any, beam: Mesh) -> Any:
    """Coordinates of all nodes (..., N) from the hub's angle and the free ones (..., 1 + n)."""
    whole = np.zeros((*values.shape[:-1], len(beam.straight)), dtype=values.dtype)
    whole[..., beam.free] = values[..., 1:]
    return whole


@lru_cache(maxsize=64)
def element_scene(n: int, element: str = "ancf") -> EquationsOfMotion:
    """Return the equations of n elements; the same object for the same arguments."""
    strains, names = STRAINS[element], NODAL[element]

    def terms(q: Any, v: Any, c: Coefficients) -> Terms:
        """Mass matrix and forces of the free hub with its elements."""
        beam = mesh(n, element, c)
        parts = bordered(q, v, c, beam, strains)
        mass = np.zeros((*q.shape, q.shape[-1]), dtype=parts.coupling.dtype)
        mass[..., 1:, 1:] = beam.mass[np.ix_(beam.free, beam.free)]
        mass[..., 0, 0] = parts.hub
        mass[..., 0, 1:] = mass[..., 1:, 0] = parts.coupling
        return Terms(mass, np.concatenate([parts.brake[..., None], parts.load], axis=-1))

    def solve(q: Any, v: Any, c: Coefficients, u: Any) -> Any:
        """Accelerations of hub and nodes; the mass matrix of the nodes is constant."""
        beam = mesh(n, element, c)
        hub, coupling, brake, load = bordered(q, v, c, beam, strains)
        follow = coupling @ beam.inverse.T
        carried = hub - dot(follow, coupling)
        loose = (u + brake - dot(follow, load)) / (carried + c.prescribed)
        angular = c.prescribed * u + (1 - c.prescribed) * loose
        rest = load @ beam.inverse.T - angular[..., None] * follow
        return np.concatenate([angular[..., None], rest], axis=-1)

    def potential(q: Any, c: Coefficients) -> Any:
        """Strain energy and potential energy of gravity [J]."""
        beam = mesh(n, element, c)
        shape = spread(q, beam)
        weight = dot(weight_of(q, c, beam) @ beam.mass, beam.straight + shape)
        return strains(shape, beam).energy - weight

    def tip(q: Any, v: Any, c: Coefficients) -> tuple[Any, ...]:
        """Tip's displacement over L and its rate in the hub frame."""
        x, y = -len(names), 1 - len(names)
        return tuple(value / c.length for value in (q[..., y], v[..., y], q[..., x], v[..., x]))

    def embedding(p: RotatingBeam, state: Mapping[str, float]) -> dict[str, float]:
        """Return the state of the scene's beam, stretched as rotation and weight stretch it.

        Else its first motion would be waves along it, which the scene's beam does not have and few
        methods follow. What drives the hub, which depends on the time, is left out.
        """
        c = coefficients(p)
        one, at = mesh(n, element, c), stations(n, float(c.place))
        begin = unstretched_nodes(p, state, at, element == "ancf")
        along, mass = begin.along[one.free], one.mass[np.ix_(one.free, one.free)]
        hub, hub_dot = (float(state.get(name, 0.0)) for name in ("theta", "theta_dot"))
        q, v = np.append(hub, begin.places[one.free]), np.append(hub_dot, begin.rates[one.free])

        def pull(x: Any) -> Any:
            """Forces along the beam, stretches as columns, less those of its own motion."""
            moved = np.vstack([np.full(x.shape[1:], hub), q[1:, None] + along @ x])
            parts = bordered(moved.T, np.tile(v[:, None], x.shape[1:]).T, c, one, strains)
            slow = mass @ begin.accelerations[one.free]
            return along.T @ (parts.load - slow - begin.hub * parts.coupling).T

        stretches = np.zeros(along.shape[1])
        for _ in range(STRETCHES):
            force, slope = by_complex_step(pull, stretches)
            stretches -= np.linalg.solve(slope, force)
        q[1:] += along @ stretches
        names = (f"{name}{rate}" for rate in ("", "_dot") for name in ("theta", *nodes))
        return dict(zip(names, map(float, np.append(q, v)), strict=True))

    clamp = ("node_0_slope_x",) if element == "ancf" else ()
    nodes = clamp + tuple(f"node_{i}_{name}" for i in range(1, n + 1) for name in names)
    units = {node: unit_of(node) for node in nodes}

    def spectrum(p: RotatingBeam, plane: str, count: int) -> tuple[Array, Array]:
        """Frequencies [rad/s] of the beam that the elements converge to."""
        if element == "ancf":
            assert EXTENSIBLE.continuum.spectrum is not None
            return EXTENSIBLE.continuum.spectrum(p, plane, count)
        modes = frequencies(p, plane, count, "shear_flexible", shear_stiffness(p), True)
        return modes.omega, modes.bound

    return EquationsOfMotion(
        **hub_fields(terms, potential, tip, units, solve),
        title=f"hub with a beam of {n} elements ({element.replace('_', ' ')})",
        embedding=embedding,
        stiff=(1e-8, 1e-6) if element == "ancf" else (1e-7, 1e-5),
        continuum=Continuum(nodes, spectrum, reach=reach, has_waves=True),
    )


def unit_of(node: str) -> str:
    """Return the unit of a node's coordinate."""
    return {"x": "1" if "slope" in node else "m", "y": "1" if "slope" in node else "m"}.get(
        node.rsplit("_", 1)[1], "rad"
    )

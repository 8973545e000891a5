r"""rotating_beam as a chain of rigid rods with springs in their hinges.

::

    A   O====a====(2k)---h---(k)---h---(k)---h---       h = L/n, k = EI/h, n hinges
    B   O====a====-h/2-(k)---h---(k)---h---(k)-h/2-     the first half rod is part of the hub

What an engine of rigid bodies can make of the beam. Coordinates are the hub's angle and the
hinges' (each rod to the one before). A rod has its own moment of inertia, rho A h^3/12; the
concentrated mass is a point of the rod that has the place d.

Both schemes converge to the inextensible beam with the second order in h: scheme A because the
spring at the clamp stands for half a cell only (with k there the order is one), scheme B
because its hinges are in the middle of the cells. The error's factor of h^2 depends on where in
its rod the mass sits: an order can be measured only with numbers of segments
that leave it there, best at an end.

Everything is found in O(n) operations without a matrix: rod after rod, from the tip, the force
in a hinge is linear in the hinge's acceleration, with a symmetric matrix (2, 2), the rod's and
those of all beyond (the articulated-body method; moments in the hinges are known beforehand).
`mass_matrix` and `forces` are written down independently of that, from absolute angles:
``M_ij = m_ij cos(phi_i - phi_j)``.

Lengths are over L, as in `mbcheck.reference.rotating_beam`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np

from ..errors import UnknownNameError
from ..linear import linearise, modes
from ..scene import Array, Continuum, EquationsOfMotion, with_rates
from .parameters import (
    EQUILIBRIA,
    Coefficients,
    RotatingBeam,
    coefficients,
    conserved,
    drive,
    drive_end_time,
    hanging,
    hub_gravity,
    period,
    reach,
    rotation,
    unforced,
)
from .scene import UNITS
from .starts import chain_start

ROOT = {"A": 2.0, "B": 1.0}
"""Spring of the first hinge over EI/h."""

OUTPUTS = ("tip_deflection", "tip_deflection_dot", "tip_axial", "tip_axial_dot")


class Layout(NamedTuple):
    """Where the hinges of a chain are, from the clamp, and what follows each (over L)."""

    hinges: tuple[float, ...]
    lengths: tuple[float, ...]
    springs: tuple[float, ...]
    """Over EI/L"""


def layout(n: int, scheme: str, root: float | None = None) -> Layout:
    """Return the layout of a scheme, with another spring at the clamp if wanted."""
    if scheme not in ROOT:
        raise UnknownNameError("scheme", scheme, ROOT)
    h = 1 / n
    first = (ROOT[scheme] if root is None else root) * n
    springs = (first, *(float(n),) * (n - 1))
    if scheme == "A":
        return Layout(tuple(i / n for i in range(n)), (h,) * n, springs)
    return Layout(tuple((i + 0.5) / n for i in range(n)), (h,) * (n - 1) + (h / 2,), springs)


class Rod(NamedTuple):
    """One rod with the point mass on it; lengths over L, so that all inertias are in kg m^2."""

    length: Any
    mass: Any
    moment: Any
    """First moment about its hinge"""
    inertia: Any
    """About its hinge"""
    spring: Any
    """In its hinge [N m]"""


class Chain(NamedTuple):
    """The hub, with what is fixed on it, and the rods."""

    hinge: Any
    """Distance of the first hinge from the axis, over L"""
    inertia: Any
    """Of the hub about its axis"""
    moment: Any
    """First moment of what is fixed on the hub, about the axis"""
    rods: tuple[Rod, ...]


def assemble(c: Coefficients, shape: Layout) -> Chain:
    """Return the bodies of a chain."""
    start = shape.hinges[0]
    middle = c.hub_ratio + start / 2
    on_hub = c.point * (c.place <= start)
    rods = []
    ends = (*shape.hinges[1:], np.inf)
    for hinge, end, length, spring in zip(shape.hinges, ends, *shape[1:], strict=True):
        mass, arm = c.beam * length, c.place - hinge
        point = c.point * ((hinge < c.place) & (c.place <= end))
        rods.append(
            Rod(
                length=length,
                mass=mass + point,
                moment=mass * length / 2 + point * arm,
                inertia=mass * length**2 / 3 + point * arm**2,
                spring=c.bending * spring,
            )
        )
    return Chain(
        hinge=c.hub_ratio + start,
        inertia=c.hub
        + c.beam * start * (middle**2 + start**2 / 12)
        + on_hub * (c.hub_ratio + c.place) ** 2,
        moment=c.beam * start * middle + on_hub * (c.hub_ratio + c.place),
        rods=tuple(rods),
    )


_assembled = lru_cache(maxsize=64)(assemble)


def chain_of(c: Coefficients, shape: Layout) -> Chain:
    """Return the bodies, remembered where all coefficients are numbers."""
    try:
        return _assembled(c, shape)
    except TypeError:  # arrays over points
        return assemble(c, shape)


class ChainMotion(NamedTuple):
    """Accelerations of hub and hinges, and the torque on the hub that goes with them."""

    accelerations: list[Any]
    torque: Any


def solved(u: Any, q: Any, v: Any, c: Coefficients, shape: Layout, xp: Any = np) -> ChainMotion:
    """Solve the equations of motion, from the tip to the hub and back."""
    chain = chain_of(c, shape)
    rates, rate = [], v[0]
    for own in v[1:]:
        rate = rate + own
        rates.append(rate)
    # force in the hinge of what is beyond: (xx, xy; xy, yy) a + (fx, fy), in the rod's frame
    xx = xy = yy = fx = fy = beyond = 0.0
    factors = []
    for i in range(len(chain.rods) - 1, -1, -1):
        length, mass, moment, inertia, spring = chain.rods[i]
        square = rates[i] * rates[i]
        turning = -spring * q[i + 1]
        across, along = moment + length * yy, length * xy
        share = 1 / (inertia + length * length * yy)
        free = (turning - beyond + length * (along * square - fy)) * share
        fx = fx - (moment + length * xx) * square + along * free
        fy = fy - along * square + across * free
        xx = xx + mass - along * along * share
        yy = yy + mass - across * across * share
        xy = xy - along * across * share
        cos, sin = xp.cos(q[i + 1]), xp.sin(q[i + 1])
        factors.append((length, square, across * share, along * share, free, cos, sin))
        mixed, both, apart = cos * sin, 2 * cos * sin * xy, xx - yy
        cos2, sin2 = cos * cos, sin * sin
        xx, yy = cos2 * xx - both + sin2 * yy, sin2 * xx + both + cos2 * yy
        xy = mixed * apart + (cos2 - sin2) * xy
        fx, fy = cos * fx - sin * fy, sin * fx + cos * fy
        beyond = turning
    # gravity is an acceleration of the axis, away from it
    g_x, g_y = hub_gravity(q[0], c, xp)
    arm, square = chain.hinge, v[0] * v[0]
    carried = chain.inertia + arm * arm * yy
    rest = beyond + arm * (fy - arm * xy * square - (xy * g_x + yy * g_y)) - chain.moment * g_y
    free_hub = 1 - c.prescribed
    # a prescribed hub may have no inertia
    angular = c.prescribed * u + free_hub * (u - rest) / (carried + c.prescribed)
    ax, ay = -arm * square - g_x, arm * angular - g_y
    accelerations, last = [angular], angular
    for length, square, across, along, free, cos, sin in reversed(factors):
        ax, ay = cos * ax + sin * ay, cos * ay - sin * ax
        own = free - across * ay - along * ax
        accelerations.append(own - last)
        ax, ay, last = ax - length * square, ay + length * own, own
    return ChainMotion(accelerations, carried * angular + rest)


class Weights(NamedTuple):
    """In absolute angles: ``m_ij = arm_i moment_j`` for i < j, ``m_ii = inertia_i``; 0 the hub.

    Gravity acts on each with its moment.
    """

    arm: list[Any]
    moment: list[Any]
    inertia: list[Any]


def weights(chain: Chain) -> Weights:
    """Return what the mass matrix in absolute angles is made of."""
    beyond = 0.0
    moments, inertias = [], []
    for rod in reversed(chain.rods):
        moments.append(rod.moment + rod.length * beyond)
        inertias.append(rod.inertia + rod.length**2 * beyond)
        beyond = beyond + rod.mass
    arms = [chain.hinge, *(rod.length for rod in chain.rods)]
    hub = chain.inertia + chain.hinge**2 * beyond
    moments.append(chain.moment + chain.hinge * beyond)
    return Weights(arms, moments[::-1], [hub, *inertias[::-1]])


def summed(values: Sequence[Any]) -> list[Any]:
    """Return the running sums."""
    total: Any = 0.0
    angles = []
    for value in values:
        total = total + value
        angles.append(total)
    return angles


def beyond(values: Sequence[Any]) -> list[Any]:
    """Return the sums from each to the last."""
    return summed(values[::-1])[::-1]


def directions(q: Any, xp: Any) -> tuple[list[Any], list[Any]]:
    """Cosines and sines of hub and rods, in the hub frame."""
    angles = summed([0.0 * q[0], *q[1:]])
    return [xp.cos(angle) for angle in angles], [xp.sin(angle) for angle in angles]


def inertia_forces(
    q: Any, v: Any, c: Coefficients, shape: Layout, xp: Any = np
) -> tuple[list[list[Any]], list[Any]]:
    """Mass matrix of the free hub with its chain, gravity less velocity-dependent terms."""
    w = weights(chain_of(c, shape))
    cos, sin = directions(q, xp)
    size = len(cos)
    absolute: list[list[Any]] = [[w.inertia[i]] * size for i in range(size)]
    for i in range(size):
        for j in range(i + 1, size):
            entry = w.arm[i] * w.moment[j] * (cos[i] * cos[j] + sin[i] * sin[j])
            absolute[i][j] = absolute[j][i] = entry
    rows = [beyond(row) for row in absolute]
    columns = [beyond([row[j] for row in rows]) for j in range(size)]
    squares = [rate * rate for rate in summed(v)]
    # sum over j of -m_ij sin(phi_i - phi_j) rate_j^2: those within, those beyond
    within_x = summed([w.arm[j] * cos[j] * squares[j] for j in range(size)])
    within_y = summed([w.arm[j] * sin[j] * squares[j] for j in range(size)])
    beyond_x = beyond([w.moment[j] * cos[j] * squares[j] for j in range(size)])
    beyond_y = beyond([w.moment[j] * sin[j] * squares[j] for j in range(size)])
    g_x, g_y = hub_gravity(q[0], c, xp)
    loads = []
    for i in range(size):
        x, y = (w.moment[i] * part[i - 1] if i else 0.0 for part in (within_x, within_y))
        if i + 1 < size:
            x, y = x + w.arm[i] * beyond_x[i + 1], y + w.arm[i] * beyond_y[i + 1]
        loads.append(cos[i] * (y + w.moment[i] * g_y) - sin[i] * (x + w.moment[i] * g_x))
    return [list(row) for row in zip(*columns, strict=True)], beyond(loads)


def embedding(p: RotatingBeam, state: Mapping[str, float]) -> dict[str, float]:
    """Return the state of a chain whose rods are chords of the scene's beam."""
    return chain_start(p, state, (*layout(int(p.segments), p.scheme).hinges, 1.0))


@lru_cache(maxsize=128)
def chain_scene(n: int, scheme: str = "A", root: float | None = None) -> EquationsOfMotion:
    """Return the chain of n hinges; the same object for the same numbers.

    Parameters
    ----------
    n : int
    scheme : {"A", "B"}
    root : float, optional
        Spring of the first hinge over EI/h, by default that of `ROOT`.
    """
    shape = layout(n, scheme, root)
    motion = partial(solved, shape=shape)

    def mass_matrix(q: Any, c: Coefficients, xp: Any = np) -> list[list[Any]]:
        """M; its first row is that of the identity where the hub is prescribed."""
        mass, _ = inertia_forces(q, [0.0] * (n + 1), c, shape, xp)
        free = 1 - c.prescribed
        mass[0] = [free * entry for entry in mass[0]]
        for row in mass[1:]:
            row[0] = free * row[0]
        mass[0][0] = mass[0][0] + c.prescribed
        return mass

    def forces(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> list[Any]:
        """Forces on the coordinates; a prescribed acceleration is one of them."""
        mass, loads = inertia_forces(q, v, c, shape, xp)
        springs = [rod.spring for rod in chain_of(c, shape).rods]
        return [
            u + (1 - c.prescribed) * loads[0],
            *(
                loads[i + 1] - springs[i] * q[i + 1] - c.prescribed * u * mass[i + 1][0]
                for i in range(n)
            ),
        ]

    def accelerations(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> list[Any]:
        """Accelerations of hub and hinges."""
        return motion(u, q, v, c, xp=xp).accelerations

    def energy(q: Any, v: Any, c: Coefficients) -> Any:
        """Kinetic energy, that of the springs and potential energy of gravity [J]."""
        chain = chain_of(c, shape)
        cos, sin = directions(q, np)
        g_x, g_y = hub_gravity(q[0], c)
        moments = zip(weights(chain).moment, cos, sin, strict=True)
        weight = sum(moment * (g_x * c_i + g_y * s_i) for moment, c_i, s_i in moments)
        rates = summed(v)
        twice = chain.inertia * v[0] ** 2
        x, y = 0.0 * v[0], chain.hinge * v[0]  # velocity of the hinge, along hub x, y
        for i, rod in enumerate(chain.rods):
            rate, c_i, s_i = rates[i + 1], cos[i + 1], sin[i + 1]
            twice = twice + rod.mass * (x**2 + y**2) + rod.inertia * rate**2
            twice = twice + 2 * rod.moment * rate * (c_i * y - s_i * x)
            twice = twice + rod.spring * q[i + 1] ** 2
            x, y = x - rod.length * s_i * rate, y + rod.length * c_i * rate
        return twice / 2 - weight

    def momentum(q: Any, v: Any, c: Coefficients) -> Any:
        """Angular momentum about the axis [kg m^2/s]."""
        mass, _ = inertia_forces(q, [0.0] * (n + 1), c, shape)
        return sum(entry * rate for entry, rate in zip(mass[0], v, strict=True))

    def invariants(p: RotatingBeam) -> Mapping[str, Any]:
        """What a beam keeps that nothing drives; nothing while it is driven."""
        driven = p.torque_amplitude if p.drive == "torque" else p.ramp_time
        return {} if np.any(driven) else conserved(p, energy, momentum)

    def powers(u: Any, q: Any, v: Any, c: Coefficients) -> dict[str, Any]:
        """Power [W] of the torque on the hub: the given one, or what its motion takes."""
        taken = motion(u, q, v, c).torque
        return {"hub": (c.prescribed * taken + (1 - c.prescribed) * u) * v[0]}

    def outputs(q: Any, v: Any, c: Coefficients, xp: Any = np) -> dict[str, Any]:
        """Tip's displacement in the hub frame."""
        angles, rates = summed(q[1:]), summed(v[1:])
        sums: list[Any] = [0.0, 0.0, 0.0, 0.0]
        for length, angle, rate in zip(shape.lengths, angles, rates, strict=True):
            cos, sin, half = xp.cos(angle), xp.sin(angle), xp.sin(angle / 2)
            terms = sin, cos * rate, -2 * half * half, -sin * rate
            sums = [a + length * b for a, b in zip(sums, terms, strict=True)]
        return {name: c.length * a for name, a in zip(OUTPUTS, sums, strict=True)}

    hinges = tuple(f"joint_{i}" for i in range(1, n + 1))
    return EquationsOfMotion(
        name="rotating_beam",
        title=f"hub with a chain of {n} hinges, scheme {scheme}",
        parameters=RotatingBeam,
        coordinates=("theta", *hinges),
        units=UNITS | with_rates(**dict.fromkeys(hinges, "rad")),
        coefficients=coefficients,
        drive=drive,
        mass_matrix=mass_matrix,
        forces=forces,
        accelerations=accelerations,
        damping_matrix=lambda c: np.zeros((n + 1, n + 1)),
        energy=energy,
        powers=powers,
        equilibria=EQUILIBRIA,
        steady_coordinates=dict.fromkeys(EQUILIBRIA, ("theta",)),
        rotations_per_period={"theta": 1},
        period=period,
        unforced=unforced,
        outputs=outputs,
        observed=OUTPUTS[:3],
        invariants=invariants,
        embedding=embedding,
        stiff=(1e-11, 1e-9),
        continuum=Continuum(hinges, reach=reach),
        drive_end_time=drive_end_time,
    )


def scene_of(p: RotatingBeam) -> EquationsOfMotion:
    """Return the chain of these ``segments`` and this ``scheme``."""
    return chain_scene(int(p.segments), p.scheme)


def chain_frequencies(
    p: RotatingBeam, count: int = 2, scene: EquationsOfMotion | None = None
) -> Array:
    """Lowest chordwise frequencies (count,) [rad/s] in rotation at ``angular_speed``, or hanging.

    The hub's motion is prescribed, whatever drives it.
    """
    scene = scene_of(p) if scene is None else scene
    state = scene.state((hanging if p.has_gravity else rotation)(p))
    mass, damping, stiffness = linearise(scene, p.replace(drive="prescribed"), state)
    vibrations = modes(mass, damping, stiffness, steady=[0])[1:]
    return np.array([mode.omega for mode in vibrations[:count]])

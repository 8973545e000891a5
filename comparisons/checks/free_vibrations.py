"""Free vibrations of a model's equations, and the largest stable step of a method."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag, eigh

from ...reference.amplification import (
    AMPLIFICATION,
    DEFECT,
    Vibrations,
    excess,
    largest_stable_step,
    rates,
    vibrations,
)
from ...reference.differences import by_complex_step
from ...reference.equations import ModelEquations
from ...reference.errors import MbcheckError, NoOrbitError
from ...reference.linear import linearise, linearise_at
from ...reference.scene import Array
from ..engines.run import EPS
from ..engines.setup import Setup
from .truth import rows

START = "start"
CLOCK = "drive"
"""Coordinate of a drive that the engine integrates."""

PHASE = 12.0
"""12 times the phase error [rad] up to which the error of a vibration shrinks with the step: the
phase error of the trapezoidal rule grows by omega (omega h)^2 / 12 per second."""


class Place(NamedTuple):
    """A state about which model equations are linearised.

    Attributes
    ----------
    name : str
        `START`, or a state of rest.
    coordinates : tuple of str
    state : array (2 n,)
        Of the claim.
    matrices : Vibrations
        Arrays (n, n).
    modes : Vibrations
        The same, as single modes where it falls into them.
    """

    name: str
    coordinates: tuple[str, ...]
    state: Array
    matrices: Vibrations
    modes: Vibrations

    @property
    def rates(self) -> Array:
        """Eigenvalues (2 n,) [1/s]; those that vanish but for rounding are 0."""
        values = rates(self.modes)
        values = np.where(np.abs(values) > DEFECT * np.max(np.abs(values)), values, 0)
        return np.where(np.abs(values.real) > DEFECT * np.abs(values), values, 1j * values.imag)


class Critical(NamedTuple):
    """The mode that limits the step: its circular frequency, or rate [1/s], and its coordinate."""

    omega: float
    coordinate: str


class Limit(NamedTuple):
    """The largest stable step [s], the state and the mode that limit it."""

    step: float
    place: Place
    mode: Critical


def places(setup: Setup, scheme: str) -> tuple[Place, ...]:
    """Return the vibrations of a model about the case's start, and about its states of rest.

    Where nothing grows of itself, if there is such a place.
    """
    equations = setup.bound.equations
    start = tuple(equations.start(setup.case)[: len(equations.scene.coordinates)].tolist())
    # others take all dampers at the end of a step but a soft closure's, which implicit Euler does
    only_joints = scheme == "semi_implicit_euler" or setup.bound.has_soft_closure
    only_joints = only_joints and scheme != "implicit_euler"
    first, *rests = start_and_rests(equations, start, setup.bound.integrates_drive, only_joints)
    if not any(np.array_equal(first.state, other.state) for other in rests):
        rests.append(first)
    steady = tuple(at for at in rests if not np.any(at.rates.real > 0))
    return steady or tuple(rests)


@lru_cache(maxsize=512)
def start_and_rests(
    equations: ModelEquations,
    start: tuple[float, ...],
    clock: bool = False,
    only_joints: bool = False,
) -> tuple[Place, ...]:
    """Return the vibrations of equations about a start (n,) at rest, and their states of rest.

    These are without motors where there is none with.
    """
    scene, states = equations.scene, {START: np.array([*start, *[0.0] * len(start)])}
    for name, where in scene.equilibria.items():
        for parameters in (equations.parameters, scene.unforced(equations.parameters)):
            try:
                states[name] = scene.state(where(parameters))
                break
            except (NoOrbitError, ArithmeticError, np.linalg.LinAlgError):
                continue
    return tuple(place(equations, name, at, clock, only_joints) for name, at in states.items())


def place(
    equations: ModelEquations, name: str, state: Array, clock: bool, only_joints: bool
) -> Place:
    """Linearise a claim; motors and bearings count, a drive only as the clock that it is."""
    scene, parameters = equations.scene, equations.parameters
    matrices = list(linearise(scene, parameters, state))
    c = scene.coefficients(parameters)
    matrices.append(scene.damping_matrix(c) if only_joints else matrices[1])
    coordinates = scene.coordinates
    if clock and scene.drive is not None and hasattr(c, "omega"):
        more = (1.0, 0.0, float(c.omega) ** 2, 0.0)
        matrices = [block_diag(m, value) for m, value in zip(matrices, more, strict=True)]
        coordinates = (*coordinates, CLOCK)
    if not all(np.all(np.isfinite(matrix)) for matrix in matrices):
        raise MbcheckError(f"the equations are not finite at {name}")
    return Place(name, coordinates, state, Vibrations(*matrices), vibrations(*matrices))


def stable_step(setup: Setup, horizon: float, among: Sequence[Place] | None = None) -> Limit | None:
    """Return the largest step that keeps free vibrations bounded over a horizon [s], if any.

    About the places ``among``, by default those of `places`.
    """
    scheme = setup.linear_scheme
    if scheme is None:
        return None
    looked = among or places(setup, scheme)
    limits = [largest_stable_step(scheme, at.modes, horizon) for at in looked]
    least = int(np.argmin(limits))
    if not np.isfinite(limits[least]):
        return None
    return Limit(limits[least], looked[least], critical(scheme, looked[least], limits[least]))


def drowns(setup: Setup, horizon: float) -> bool:
    """Return True if a run amplifies round-off to the size of the motion."""
    scheme, step = setup.linear_scheme, setup.step_size
    return scheme is not None and any(
        excess(scheme, at.modes, step, horizon, 1 / EPS) > 0 for at in places(setup, scheme)
    )


def critical(scheme: str, at: Place, step: float) -> Critical:
    """Return the mode that a step multiplies most."""
    n = len(at.coordinates)
    mass, damping, stiffness, _ = at.matrices
    values, vectors = np.linalg.eig(AMPLIFICATION[scheme](at.matrices, step))
    shape = vectors[:n, np.argmax(np.abs(values))]
    inertia = (shape.conj() @ mass @ shape).real
    spring = abs(shape.conj() @ stiffness @ shape) / inertia
    damper = abs(shape.conj() @ damping @ shape) / inertia
    omega = float(np.sqrt(spring)) if damper**2 < 4 * spring else float(damper)
    share = np.abs(shape) * np.sqrt(np.diag(mass))
    return Critical(omega, at.coordinates[int(np.argmax(share))])


class Excitation(NamedTuple):
    """Modes that a start excites and steps do not resolve.

    Attributes
    ----------
    omega : float
        The slowest of them [rad/s], infinite if there is none.
    amplitudes : array (k,)
        Of observables, all of these vibrations together.
    """

    omega: float
    amplitudes: Array


def excitation(setup: Setup, step: float, horizon: float) -> Excitation:
    """Return the modes that a start excites and steps [s] do not resolve over a horizon [s].

    The phase error of a method of order p grows by some ``omega (omega step)^p / 12`` per second.
    Above 1 rad in all, halved steps do not predict the error: it falls only as fewer such modes
    are left, more slowly than by the order.
    """
    equations, case, order = setup.bound.solved_equations, setup.case, setup.integrator.order
    scene, parameters = equations.scene, equations.parameters
    c, start = scene.coefficients(parameters), equations.start(case)
    q, v = np.split(start, 2)
    mass, _, stiffness, _ = linearise_at(scene, c, np.append(q, 0 * v))
    squares, shapes = eigh((stiffness + stiffness.T) / 2, (mass + mass.T) / 2)
    omega = np.sqrt(np.maximum(squares, 0.0))
    lost = omega * (omega * step) ** order * horizon > PHASE
    omega, shapes = omega[lost], shapes[:, lost]
    drive = scene.drive(case.start_time, c) if scene.drive else 0.0
    pushed = np.array(scene.accelerations(drive, q, v, c))
    speeds = np.hypot(shapes.T @ mass @ v, (shapes.T @ mass @ pushed) / omega)

    slopes = by_complex_step(lambda x: rows(equations, x, setup.scene.observables), start)[1]
    seen = np.abs(slopes[:, : len(q)] @ shapes) / omega + np.abs(slopes[:, len(q) :] @ shapes)
    return Excitation(float(np.min(omega, initial=np.inf)), seen @ speeds)

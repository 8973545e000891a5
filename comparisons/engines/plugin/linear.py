"""Matrices of small motions, from what an engine tells."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ....models.kinematics import mass_matrix
from ....models.mechanism import mechanism
from ....models.system import System
from ....reference import get_scene
from ....reference.differences import by_differences, one_by_one
from ....reference.errors import Unsupported
from ....reference.scene import Array, Case
from .validation import matrices, numbers

if TYPE_CHECKING:
    from .adapter import PluginAdapter

ORDER = 8
DIFFERENCE = 0.03
"""Order and step of central differences (rad, m and their rates). Truncation is 1e-15 then; what
rounding leaves of accelerations, whose stiffest modes are far faster than those looked at, falls
with the step."""

TURNING = DIFFERENCE / 6
"""The same step where quaternions turn: rotations have poles at the length 0, at the distance 1."""


def linearise(
    engine: PluginAdapter, case: Case, model: str, state: Array
) -> tuple[Array, Array, Array]:
    """Return M, C, K, each (n, n), about a state of rest or steady motion.

    The engine's own of a tree at rest, if it tells them; else central differences, of its
    inverse dynamics, or of its accelerations times the mass matrix of the MJCF, which leaves
    the eigenvalues alone.

    Raises
    ------
    Unsupported
        If a closure gives way and there is no inverse dynamics: modes are those of a closed
        loop, and accelerations of another.
    """
    n = len(state) // 2
    resting = not np.any(state[n:])
    if resting and not engine.has_constraints(case, model):
        try:
            return returned_matrices(engine, case, model, state)
        except Unsupported:  # then it follows from differences
            pass
    if "inverse_dynamics" in engine.functions:
        return by_inverse_dynamics(engine, case, model, state)
    if engine.gives_way(case, model):
        raise Unsupported("accelerations of a soft closure show no modes of a closed loop")
    system = engine.joint_system(case, model)
    mass = own_mass_matrix(engine, case, model, system, state)

    def forces(places: Array) -> Array:
        times = np.full(places.shape[1], case.start_time)
        accelerations = engine.accelerations(case, model, times, places.T)
        masses = [
            mass if np.array_equal(place[:n], state[:n])
            else own_mass_matrix(engine, case, model, system, place)
            for place in places.T
        ]  # fmt: skip
        return np.einsum("kij,kj->ik", masses, accelerations)

    width = TURNING if system.layout.is_spatial else DIFFERENCE
    _, slopes = by_differences(forces, state, ORDER, width)
    slopes[engine.prescribed(case, model)] = 0
    return mass, -slopes[:, n:], -slopes[:, :n]


def by_inverse_dynamics(
    engine: PluginAdapter, case: Case, model: str, state: Array
) -> tuple[Array, Array, Array]:
    """Return M, C, K, each (n, n), by the engine's inverse dynamics.

    A loop counts as closed for good: its constraint's forces do no work here. C and K are
    central differences, the accelerations kept: they hold for small departures from the
    motion through ``state``.
    """
    time, n = np.array([case.start_time]), len(state) // 2
    system, q, v = engine.joint_states(case, model, time, state[None])
    closed = engine.has_constraints(case, model)
    # a soft closure gives way even at rest, which a closed loop does not
    a = 0 * v[0] if closed else engine.joint_accelerations(system, time, q, v)[0]
    jacobian = engine.jacobian(case, model, system.joints, state)

    def force(moved: Array) -> Array:
        at, speed = engine.joint_motion(case, model, system.joints, case.start_time, moved)
        force = engine.inner.inverse_dynamics(system, case.start_time, at, speed, a.copy())
        force = numbers("inverse_dynamics", force, a.shape, finite=True)
        # joints of a tree are linear in the coordinates
        here = engine.jacobian(case, model, system.joints, moved) if closed else jacobian
        return np.asarray(here @ force)

    _, slopes = by_differences(one_by_one(force), state)
    slopes[engine.prescribed(case, model)] = 0
    mass = engine.mass_matrices(case, model, state[None])[0]
    return mass, slopes[:, n:], slopes[:, :n]


def returned_matrices(
    engine: PluginAdapter, case: Case, model: str, state: Array
) -> tuple[Array, Array, Array]:
    """Return M, C, K, each (n, n), by the engine's own function.

    Raises
    ------
    Unsupported
        If it has none.
    """
    names = engine.coordinates(case, model)
    keys = (*names, *(f"{name}_dot" for name in names))
    there = replace(case, state=dict(zip(keys, map(float, state), strict=True)))
    system = engine.joint_system(there, model)
    jacobian = engine.jacobian(case, model, system.joints, state)
    mass, damping, stiffness = (
        jacobian @ item @ jacobian.T
        for item in matrices(engine.inner.linearise(system), system.layout.size[1])
    )
    readout = engine.joint_readout(case, model, system)
    return readout.completed(mass, state, case.parameters), damping, stiffness


def own_mass_matrix(
    engine: PluginAdapter, case: Case, model: str, system: System, state: Array
) -> Array:
    """Return the mass matrix (n, n) of the coordinates that the file or the scene has."""
    if not engine.reads_mjcf:
        scene = get_scene(case.scene)
        q, c = state[: len(state) // 2], scene.coefficients(case.parameters)
        return np.array(scene.mass_matrix(q, c), dtype=float)
    q, _ = engine.joint_motion(case, model, system.joints, case.start_time, state)
    matrix = mass_matrix(mechanism(system.mjcf), q)
    return engine.of_coordinates(case, model, system, state, matrix)

"""What the second formulation says of a scene at random parameters and states."""

from __future__ import annotations

import dataclasses
from decimal import Decimal, localcontext
from typing import Any, NamedTuple

import numpy as np

from mbcheck.reference import get_scene
from mbcheck.tests.support.formulations.newton_euler import (
    DIGITS,
    EPS,
    decimals,
    move,
    quaternion_accelerations,
)
from mbcheck.tests.support.formulations.scenes import build

Array = np.ndarray[Any, Any]


class Sample(NamedTuple):
    """Parameters (arrays over k points) and states.

    Attributes
    ----------
    q, v : array (n, k)
    times : array (k,)
    """

    parameters: Any
    q: Array
    v: Array
    times: Array


class Quantity(NamedTuple):
    """Values, and what round-off of one ulp makes of them; points last."""

    value: Array
    error: Array


def draw(name: str, count: int, seed: int, **words: str) -> Sample:
    """Draw parameters within a factor of two, gravity, and states far from rest."""
    scene, rng = get_scene(name), np.random.default_rng(seed)
    values: dict[str, Any] = dict(words)
    for item in dataclasses.fields(scene.parameters):
        if item.name.startswith("gravity"):
            values[item.name] = rng.uniform(-10, 10, count)
        elif not isinstance(item.default, str):
            values[item.name] = item.default * 2 ** rng.uniform(-1, 1, count)
    if "moment_1" in values:
        parts = rng.uniform(1, 5, (3, count)) * 1e-3
        for axis in range(3):
            values[f"moment_{axis + 1}"] = parts.sum(axis=0) - parts[axis]
    radians = np.array([scene.units[x] == "rad" for x in scene.coordinates])[:, None]
    q = rng.uniform(-1, 1, (len(radians), count)) * np.where(radians, 3, 0.2)
    v = rng.uniform(-1, 1, q.shape) * np.where(radians, 10, 2)
    for quaternion in scene.quaternions:
        rows = [scene.coordinates.index(x) for x in quaternion.coordinates]
        q[rows], v[rows] = rng.normal(size=(4, count)), rng.normal(size=(4, count)) * 4
    return Sample(scene.parameters(**values), q, v, rng.uniform(0, 1, count))


def witness(name: str, sample: Sample) -> dict[str, Quantity]:
    """Return mass matrix, forces, accelerations, energy and powers by the second formulation."""
    with localcontext(prec=DIGITS):
        points = [at_point(name, sample, k) for k in range(len(sample.times))]
    return {
        key: Quantity(*(np.stack([one[key][i] for one in points], -1) for i in (0, 1)))
        for key in points[0]
    }


def at_point(name: str, sample: Sample, k: int) -> dict[str, tuple[Array, Array]]:
    """Return values and errors at one point."""
    scene, p, t = get_scene(name), sample.parameters.at(k), float(sample.times[k])
    names, q, v = scene.coordinates, decimals(sample.q[:, k]), decimals(sample.v[:, k])
    m, *unit = (
        build(name, p, dict(zip(names, q, strict=True)), dict(zip(names, rates, strict=True)), t)
        for rates in (v, *decimals(np.eye(len(names))))
    )
    motion = move(m)
    inertia, moving, bent = m.sizes()
    jacobian = np.array([one.velocities() for one in unit]).T
    jacobian_size = np.array([one.sizes()[1] for one in unit]).T
    mass = jacobian.T @ m.inertia() @ jacobian
    accelerations, errors = dict(motion.accelerations), dict(motion.errors)
    length = Decimal(0) * mass
    if scene.quaternions:
        rows = [names.index(x) for x in scene.quaternions[0].coordinates]
        along = np.zeros(len(names), dtype=object)
        along[rows] = q[rows] / (q[rows] @ q[rows])
        arm = 0 if scene.quaternions[0].place else p.centre @ p.centre
        trace = Decimal(float(sum(p.moments) + 2 * p.mass * arm))
        length = trace * np.outer(along, along)
        turning = scene.quaternions[0].rates
        values, rounded = quaternion_accelerations(
            q[rows],
            v[rows],
            [accelerations[x] for x in turning],
            [errors[x] for x in turning],
        )
        accelerations |= dict(zip(scene.quaternions[0].coordinates, values, strict=True))
        errors |= dict(zip(scene.quaternions[0].coordinates, rounded, strict=True))
    a = np.array([accelerations[x] for x in names])
    length_size = abs(length).astype(float)
    free = jacobian.T @ (motion.load - m.inertia() @ (motion.bodies - jacobian @ a))
    free_size = jacobian_size.T @ (motion.load_size.astype(float) + inertia @ bent)
    energy = v @ (mass + length) @ v / 2 + sum(value for value, _ in m.potentials)
    size = moving @ inertia @ moving / 2 + float(abs(v) @ abs(length) @ abs(v)) / 2
    return {
        "mass_matrix": rounded_to(
            mass + length, jacobian_size.T @ inertia @ jacobian_size + length_size
        ),
        "forces": rounded_to(free + length @ a, free_size + length_size @ abs(a).astype(float)),
        "accelerations": (a.astype(float), np.array([errors[x] for x in names])),
        "energy": rounded_to(energy, size + float(sum(size for _, size in m.potentials))),
    } | {f"power {key}": rounded_to(power, m.power_sizes[key]) for key, power in m.powers.items()}


def rounded_to(values: Any, sizes: Any) -> tuple[Array, Array]:
    """Return values and one ulp of their sizes."""
    return np.array(values).astype(float), EPS * np.array(sizes).astype(float)

"""What the second formulation says of a scene at random parameters and states."""

from __future__ import annotations

import dataclasses
from decimal import localcontext
from typing import Any, NamedTuple

import numpy as np

from mbcheck.reference import get_scene
from mbcheck.tests.support.formulations.newton_euler import (
    DIGITS,
    EPS,
    Mechanism,
    move,
    quaternion_accelerations,
    rates_of,
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
        key: Quantity(*(np.array([one[key][i] for one in points]).astype(float).T for i in (0, 1)))
        for key in points[0]
    }


def at_point(name: str, sample: Sample, k: int) -> dict[str, tuple[Any, Any]]:
    """Return values and errors at one point."""
    scene, p = get_scene(name), sample.parameters.at(k)
    names, t = scene.coordinates, float(sample.times[k])
    q = dict(zip(names, sample.q[:, k], strict=True))
    v = dict(zip(names, sample.v[:, k], strict=True))
    m = build(name, p, q, v, t)
    motion = move(m)
    accelerations, errors = dict(motion.accelerations), dict(motion.errors)
    unit = [build(name, p, q, dict.fromkeys(names, 0) | {x: 1}, t) for x in names]
    jacobian = np.array([one.velocities() for one in unit])
    inertia = m.inertia()
    mass = jacobian @ inertia @ jacobian.T
    mass_error = EPS * abs(jacobian) @ abs(inertia) @ abs(jacobian.T)
    kinetic = m.kinetic()
    for quaternion in scene.quaternions:
        ...
    a = np.array([accelerations[x] for x in names])
    ...

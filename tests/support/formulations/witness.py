"""What second formulations say of a scene at random parameters and states."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from decimal import Decimal, localcontext
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from mbcheck.reference.quaternions import Quaternion
from mbcheck.reference.scene import EquationsOfMotion
from mbcheck.tests.support.formulations.newton_euler import (
    DIGITS,
    Mechanism,
    decimals,
    hamilton,
    norm,
    rates_of,
    skew,
    zeros,
)
from mbcheck.tests.support.formulations.scenes import Builder

Array = np.ndarray[Any, Any]

EPS = float(np.finfo(float).eps)


class Sample(NamedTuple):
    """Parameters (arrays over k points), states q, v (n, k), and times (k,)."""

    parameters: Any
    q: Array
    v: Array
    times: Array


class Quantity(NamedTuple):
    """Values, and what round-off of one ulp makes of them; points last."""

    value: Array
    error: Array


Formulation = Callable[[EquationsOfMotion, Any, Array, Array, Decimal], dict[str, tuple[Any, Any]]]
"""Values and their sizes at one point, of parameters, coordinates, rates and time as decimals."""


def draw(scene: EquationsOfMotion, count: int, seed: int, **chosen: Any) -> Sample:
    """Draw parameters within a factor of two, gravity, and states far from rest."""
    rng = np.random.default_rng(seed)
    values = dict(chosen)
    for name, default in scene.parameters().as_dict().items():
        if name.startswith("gravity"):
            values[name] = rng.uniform(-10, 10, count)
        elif name not in chosen and not isinstance(default, str):
            values[name] = (default or 0.5) * 2 ** rng.uniform(-1, 1, count)
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


def numbers_at(sample: Sample, k: int) -> tuple[Any, Array, Array, Decimal]:
    """Return parameters, coordinates, rates and time of one point as decimals."""
    p = sample.parameters.at(k).as_dict()
    numbers = {x: y if isinstance(y, str) else +Decimal(float(y)) for x, y in p.items()}
    q, v = decimals([sample.q[:, k], sample.v[:, k]])
    return SimpleNamespace(**numbers), q, v, +Decimal(float(sample.times[k]))


def witness(
    scene: EquationsOfMotion, sample: Sample, formulation: Formulation
) -> dict[str, Quantity]:
    """Return what a formulation says at all points."""
    with localcontext(prec=DIGITS):
        count = len(sample.times)
        points = [formulation(scene, *numbers_at(sample, k)) for k in range(count)]
    return {
        key: Quantity(
            np.stack([np.array(one[key][0]).astype(float) for one in points], -1),
            EPS * np.stack([np.array(one[key][1]).astype(float) for one in points], -1),
        )
        for key in points[0]
    }


def stated(scene: EquationsOfMotion, sample: Sample) -> tuple[Any, Any]:
    """Return coefficients and drive of the reference at all points, as arrays."""
    count = len(sample.times)
    c = [scene.coefficients(sample.parameters.at(k)) for k in range(count)]
    drive = scene.drive or (lambda t, c: 0.0)
    u = np.array([drive(t, one) for t, one in zip(sample.times, c, strict=True)], dtype=float)
    return type(c[0])(*np.array([[float(x) for x in one] for one in c]).T), u


def by_newton_and_euler(builder: Builder) -> Formulation:
    """Return the formulation of a mechanism that is built of bodies, joints and loads."""

    def formulation(
        scene: EquationsOfMotion, p: Any, q: Array, v: Array, t: Decimal
    ) -> dict[str, tuple[Any, Any]]:
        names = scene.coordinates
        m, *unit = (
            Mechanism(dict(zip(names, q, strict=True)), dict(zip(names, rates, strict=True)))
            for rates in (v, *decimals(np.eye(len(names), dtype=int)))
        )
        for one in (m, *unit):
            builder(one, p, t)
        read, bodies, reactions = m.move()
        of_length = zeros(len(q), len(q))
        if scene.quaternions:
            rows = [names.index(x) for x in scene.quaternions[0].coordinates]
            turning = np.array([read[x] for x in scene.quaternions[0].rates])
            accelerations = turning_quaternion(q[rows], v[rows], turning)
            read |= dict(zip(scene.quaternions[0].coordinates, accelerations, strict=True))
            of_length[np.ix_(rows, rows)] = length_inertia(
                p, q[rows], not scene.quaternions[0].place
            )
        a = np.array([read[x] for x in names])
        jacobian = np.array([one.velocities() for one in unit]).T
        sizes = np.array([one.sizes()[1] for one in unit]).T
        inertia_size, moving, bent = m.sizes()
        load, load_size = m.loads()
        inertia = m.inertia()
        length_size = abs(of_length).astype(float)
        mass = jacobian.T @ inertia @ jacobian + of_length
        mass_size = sizes.T @ inertia_size @ sizes + length_size
        forces = jacobian.T @ (load - inertia @ (bodies - jacobian @ a)) + of_length @ a
        force_size = sizes.T @ (load_size + inertia_size @ bent) + length_size @ abs(a).astype(
            float
        )
        potential, potential_size = np.sum(m.potentials, axis=0)
        speed = abs(v).astype(float)
        kinetic_size = (moving @ inertia_size @ moving + speed @ length_size @ speed) / 2
        outputs = body_outputs(m, p, scene.quaternions[0]) if scene.quaternions else {}
        size = np.sum(load_size + inertia_size @ abs(bodies).astype(float))
        outputs |= {name: (sign * reactions[i], size) for name, (i, sign) in m.told.items()}
        energy = v @ mass @ v / 2 + potential, kinetic_size + float(potential_size)
        given = {names.index(name): size for name, (_, size) in m.given.items()}
        powers = {f"power {name}": power for name, power in m.powers.items()}
        for name, (number, _) in m.given.items():
            size = (mass_size @ abs(a).astype(float) + force_size)[names.index(name)]
            powers["power hub"] = reactions[number] * m.v[name], size * abs(float(m.v[name]))
        solved = motion((mass, mass_size), (forces, force_size), a, given)
        return solved | powers | outputs | {"energy": energy}

    return formulation


def motion(
    mass: tuple[Any, Any], forces: tuple[Any, Any], a: Any, given: Mapping[int, Any]
) -> dict[str, tuple[Any, Any]]:
    """Return M, f and a of M a = f with their sizes, or a alone where some of a are given.

    Skeel's condition: N. J. Higham, *Accuracy and Stability of Numerical Algorithms*, 2nd edition
    (2002), theorem 7.4.
    """
    residual = mass[1] @ abs(a).astype(float) + forces[1]
    free = [i for i in range(len(a)) if i not in given]
    size = np.array([float(given.get(i, 0)) for i in range(len(a))])
    size[free] = abs(np.linalg.inv(mass[0][np.ix_(free, free)].astype(float))) @ residual[free]
    if given:
        return {"accelerations": (a, size)}
    return {"mass_matrix": mass, "forces": forces, "accelerations": (a, size)}


def body_outputs(m: Mechanism, p: Any, quaternion: Quaternion) -> dict[str, tuple[Any, Any]]:
    """Return attitude and rates of the body with the quaternion, and momenta.

    Those of a tree afloat are of all bodies, about their centre of mass, else of the body alone,
    about its point.
    """
    bodies = m.bodies[1:] if quaternion.place else m.bodies[-1:]
    one = bodies[0]
    about = one.place - one.axes @ [p.centre_x, p.centre_y, p.centre_z]
    if quaternion.place:
        about = sum(b.mass * b.place for b in bodies) / sum(b.mass for b in bodies)
    spun = [b.mass * skew(b.place - about) @ b.velocity for b in bodies]
    turned = [b.tensor @ b.spin for b in bodies]
    vectors = {
        "momentum": (sum(spun + turned), norm(sum(abs(part) for part in spun + turned))),
        "omega": (one.axes.T @ one.spin, norm(one.spin)),
        **{f"R_{row}": (axes, 1) for row, axes in zip("xyz", one.axes, strict=True)},
    }
    if quaternion.place:
        size = sum(b.mass * norm(b.velocity) for b in bodies)
        vectors["linear_momentum"] = sum(b.mass * b.velocity for b in bodies), size
    return {
        f"{name}{'' if name.startswith('R') else '_'}{axis}": (value, size)
        for name, (vector, size) in vectors.items()
        for axis, value in zip("xyz", vector, strict=True)
    }


def turning_quaternion(q: Any, v: Any, turning: Any) -> Any:
    """Return q'' of q' = q (rho, omega / 2), with omega' (3,) and, by convention, rho' = 0."""
    rates = np.array([q @ v / (q @ q), *rates_of(q, v) / 2])
    return hamilton(v, rates) + hamilton(q, np.array([Decimal(0), *turning / 2]))


def length_inertia(p: Any, q: Any, about_point: bool) -> Any:
    """Return the mass matrix that a quaternion's length has by convention: the tensor's trace."""
    arm = p.centre_x**2 + p.centre_y**2 + p.centre_z**2
    trace = p.moment_1 + p.moment_2 + p.moment_3 + 2 * p.mass * arm * about_point
    return trace * np.outer(q, q) / (q @ q) ** 2
